"""Pictures of cards: what is drawn stands where its values are, in a frame of 630 by 150 at (80, 20)."""

import math
import re
from itertools import pairwise

import pytest

from hypertuna.pictures import BARS, bars_svg, computed_svg, curve_svg, track_svg

TEXT = re.compile(r'<text x="(\S+)" y="(\S+)"(?: text-anchor="(\w+)")?>([^<]*)</text>')


def texts(page: str) -> list[tuple[str, ...]]:
    """Return place, side and words of each text."""
    return [found.groups("") for found in TEXT.finditer(page)]


@pytest.mark.parametrize(
    ("points", "places"),
    [
        ([(0, 0), (1, 1), (2, 4)], "80.0,170.0 395.0,132.5 710.0,20.0"),
        ([(-1, 5), (0, 7), (1, 5)], "80.0,170.0 395.0,20.0 710.0,170.0"),
        ([(0, 2), (4, 2)], "80.0,95.0 710.0,95.0"),  # around a single value a tenth of it
        ([(0, 0), (4, 0)], "80.0,95.0 710.0,95.0"),  # and 1 around 0
    ],
)
def test_a_curve_fills_its_frame(points: list[tuple[float, float]], places: str) -> None:
    page = curve_svg([x for x, _ in points], [y for _, y in points], "y over x")
    assert f'<polyline points="{places}" fill="none" stroke="#2f86c5" stroke-width="2"/>' in page
    assert "circle" not in page


@pytest.mark.parametrize(
    ("x", "y", "places"), [((0, 2), (0, 1), "80.0,170.0 380.0,20.0"), ((0, 9), (0, 1), "80.0,170.0 710.0,100.0")]
)
def test_a_map_has_one_scale(x: tuple[float, ...], y: tuple[float, ...], places: str) -> None:
    assert f'points="{places}"' in curve_svg(x, y, "", equal=True)


def test_the_ends_of_a_curve_are_written_beside_it() -> None:
    y = [("74", "172", "end", "3.00"), ("74", "26", "end", "5.00")]
    title = ("80", "12", "", "y over x")
    wide = [*y, ("80", "192", "start", "1.00"), ("710", "192", "end", "2.00"), title]
    assert texts(curve_svg([1, 2], [3, 5], "y over x")) == wide
    for width, ends in ((1.61, [("201", "192", "end", "1.61")]), (1.59, [])):  # 120.75 and 119.25 of 75 a unit
        low = "0 to 1.59" if not ends else "0"
        found = texts(curve_svg([0, width], [0, 2], "y over x", equal=True))
        assert found == [
            ("74", "172", "end", "0"),
            ("74", "26", "end", "2.00"),
            ("80", "192", "start", low),
            *ends,
            title,
        ]
    exactly = texts(curve_svg([0, 1.6], [0, 2], "", equal=True))  # 120
    assert ("200", "192", "end", "1.60") in exactly


def test_of_few_points_nothing_is_drawn() -> None:
    assert not curve_svg([], [], "")
    assert not curve_svg([1], [1], "")
    assert not curve_svg([1, 2], [1, math.nan], "")
    assert "polyline" in curve_svg([1, 2], [1, 2], "")
    assert curve_svg([1], [2], "", dots=True).count("<circle") == 1
    assert not curve_svg([], [], "", dots=True)
    assert not computed_svg([(1, math.nan)], "speed", "a run")


def test_dots_and_the_line_of_equal_values() -> None:
    page = computed_svg([(1, 2), (3, 1), (math.inf, 1)], "speed", "a run")
    assert re.findall(r'<circle cx="(\S+)" cy="(\S+)" r="4" class="joint"/>', page) == [
        ("80.0", "95.0"),
        ("710.0", "170.0"),
    ]
    assert '<polyline points="80.0,170.0 710.0,20.0" class="mark" stroke-dasharray="7 5"/>' in page
    assert page.count("polyline") == 1  # dots are not joined
    assert "computed over measured speed" in page


def test_a_long_curve_is_thinned() -> None:
    for count, drawn in ((600, 600), (1199, 1199), (1200, 600), (1801, 601)):
        assert len(re.findall(r"[\d.]+,[\d.]+", curve_svg(range(count), range(count), ""))) == drawn


@pytest.mark.parametrize(
    ("seconds", "loop", "pace"), [(8, 8, "in real time"), (10, 10, "in real time"), (25, 10, "sped up 2.5 times")]
)
def test_a_body_moves_along_a_track_in_ten_seconds_at_most(seconds: float, loop: float, pace: str) -> None:
    page = track_svg([0, 2], [0, 1], seconds, "track")
    assert f'path="M80.0,170.0 380.0,20.0" dur="{loop}s"' in page  # a map
    assert f"The whole track from above, {pace}." in page
    assert "animateMotion" not in curve_svg([0, 2], [0, 1], "track")


def test_bars_stand_below_each_other_on_one_axis() -> None:
    page = bars_svg([("up", 0, 3), ("down", 0, -1), ("none", 1, 1), ("unknown", 0, math.nan)], "change")
    bars = re.findall(r'<rect class="joint" x="(\S+)" y="(\S+)" width="(\S+)" height="16"/>', page)
    # -1 to 3 over 330 from 410: 82.5 a unit, 0 at 492.5
    assert bars == [("492.5", "26", "247.5"), ("410.0", "50", "82.5"), ("575.0", "74", "1.0")]
    assert '<path class="mark" d="M492.5 20V102"/>' in page
    assert 'viewBox="-24 -6 784 138"' in page
    names = [("398", y, "end", name) for y, name in (("39", "up"), ("63", "down"), ("87", "none"))]
    assert texts(page) == [
        ("80", "12", "", "change"),
        *names,
        ("410", "120", "start", "-1.00"),
        ("740", "120", "end", "3.00"),
    ]


def test_the_axis_of_bars_includes_zero_and_ten_are_drawn() -> None:
    bars = re.findall(r'x="(\S+)" y="(\S+)" width="(\S+)"', bars_svg([(f"{k}", 1, 2) for k in range(12)], ""))
    assert bars[0] == ("575.0", "26", "165.0")
    assert len(bars) == BARS == 10
    assert {float(b[1]) - float(a[1]) for a, b in pairwise(bars)} == {24}
