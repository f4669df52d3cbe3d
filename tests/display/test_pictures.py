"""Pictures of results on their cards: bars, dots, and bodies that move as recorded."""

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arrays import Array
from hypertuna.mission.flight import outcome
from hypertuna.pictures import computed_svg, track_svg


def test_bars_and_dots_stand_where_their_values_are(made: dict[str, Any]) -> None:
    table = made["gradient"].to_pandas().speed_percent[:10]
    widths = np.array(re.findall(r'<rect [^>]*width="([\d.]+)"', made["gradient"]._repr_html_()), dtype=float)
    np.testing.assert_allclose(widths / widths[0], table.abs() / table[0], atol=0.001)
    page = computed_svg([(1.0, 1.5), (2.0, 2.0), (np.nan, 1.0), (4.0, 3.0)], "speed", "a run")
    dots = np.array(re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)"', page), dtype=float)
    begin, end = np.array(re.findall(r"([\d.]+),([\d.]+)", page), dtype=float)  # of the dashed line, from 1 to 4
    slope = (end - begin) / 3
    np.testing.assert_allclose((dots - begin) / slope + 1, [(1, 1.5), (2, 2), (4, 3)], atol=0.002)


def test_pictures_of_few_and_of_many_values(made: dict[str, Any]) -> None:
    tracked = ht.Trials(made["trials"].recordings)
    assert "Run a from above." in tracked._repr_html_()
    assert ht.Trials()._repr_html_().count("<svg") == 0
    assert ht.Trials(made["trials"].steady[:1])._repr_html_().count("<circle") == 1
    many = ht.Gaits.grid(
        frequency=np.linspace(1, 3, 1000).tolist(), amplitude=[(0.1, 0.001 * k) for k in range(200)], phase=[(0, 0)]
    )
    assert 200 < many._repr_html_().count("<circle") <= 24**2


def bodies(page: str) -> Array:
    """Return the outlines of a moving body, (frames, points, 2), y up."""
    values = re.search(r'<animate attributeName="d"[^>]* values="([^"]*)"', page)
    assert values
    steps = [np.array(re.findall(r"-?\d+", path), dtype=float).reshape(-1, 2) for path in values[1].split(";")]
    return np.cumsum(steps, axis=1) * (1, -1)


@pytest.mark.parametrize("kind", ["twin", "dry twin", "sea", "dive"])
def test_the_body_of_a_run_bends_as_recorded_in_real_time(made: dict[str, Any], kind: str) -> None:
    run, page = getattr(made[kind], "run", made[kind]), made[kind]._repr_html_()
    span = re.search(r"The last ([\d.]+) beats from above, ([\d.]+) to ([\d.]+) s, in real time", page)
    assert span
    shown = min(3 / run.gait.frequency, run.time[-1])
    assert float(span[1]) == pytest.approx(shown * run.gait.frequency, rel=0.05)
    assert f'dur="{shown:.6g}s"' in page
    shapes = bodies(page)
    center = (shapes + shapes[:, ::-1])[:, : shapes.shape[1] // 2] / 2
    head, tail = (center[:, b] - center[:, a] for a, b in ((0, 15), (-12, -1)))
    between = [np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b) for a, b in zip(head, tail, strict=True)]
    instants = np.linspace(run.time[-1] - shown, run.time[-1], len(shapes))
    bend = np.interp(instants, run.time, run.data["angle"].sum(axis=1))
    assert np.ptp(bend) > np.radians(10)
    np.testing.assert_allclose(between, bend, atol=np.radians(1.5))


def test_the_water_passes_at_the_speed_of_the_run(made: dict[str, Any]) -> None:
    run = made["sea"]
    page = run._repr_html_()
    passed = re.search(r'type="translate" from="0 0" to="([-\d.]+) [-\d.]+" dur="([\d.]+)s"', page)
    assert passed
    last = run.time > run.time[-1] - 3 / run.gait.frequency
    assert float(passed[1]) / 1e3 / float(passed[2]) * run.robot.body.length == pytest.approx(
        run.speed[last].mean(), rel=0.03
    )


def test_a_turn_goes_round_nose_first(made: dict[str, Any]) -> None:
    turning = made["turning"]
    beat, page = ht.swim(turning.robot, turning.tightest.gait), turning._repr_html_()
    side = -np.copysign(360, beat.turn_rate)  # on a screen y is down
    assert f'type="rotate" from="0" to="{side:g}" dur="{2 * np.pi / abs(beat.turn_rate):.6g}s"' in page
    shapes = bodies(page) / 1e3 * beat.robot.body.length
    nose, tail = shapes[:, 0], shapes[:, shapes.shape[1] // 2]
    assert np.hypot(*nose.T).mean() == pytest.approx(beat.turn_radius, rel=0.02)
    onward = beat.turn_rate * nose[:, ::-1] * (-1, 1)
    assert (np.sum(onward * (nose - tail), axis=1) * beat.speed > 0).all()


def test_a_body_moves_along_the_track_of_a_flight(made: dict[str, Any]) -> None:
    page = made["flight"]._repr_html_()
    assert f'dur="{outcome(made["flight"]).duration:.6g}s" rotate="auto"' in page
    assert "The whole track from above, in real time." in page
    assert "sped up 40 times" in track_svg([0, 1, 2], [0, 1, 0], 400.0, "")


def test_a_coarse_record_is_not_drawn_as_a_body(made: dict[str, Any]) -> None:
    swim = made["swim"]
    page = ht.twin_at_sea(swim.robot, swim.gait, duration=1.0, every=10)._repr_html_()
    assert "The body is not drawn: the record has fewer than 8 rows a beat." in page
    assert "<animate " not in page


def test_a_swim_swims_with_its_numbers(made: dict[str, Any]) -> None:
    page, swim = made["swim"]._repr_html_(), made["swim"]
    assert "<animate " in page
    assert "animateTransform" in page
    assert "One beat from above, slowed down 2.7 times." in page  # 2.13 Hz; a beat takes 1.28 s
    assert page.count("<b>") == 7
    assert f"{swim.speed:.4g} m/s ({swim.speed_bl:.4g} BL/s)" in page


def test_a_diverged_swim_is_shown_without_its_picture(made: dict[str, Any]) -> None:
    show: Callable[[], str] = replace(made["swim"], status="diverged")._repr_html_
    assert "<svg" not in show()
