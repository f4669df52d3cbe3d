"""All numbers that the page shows, in texts, tables and plots, are those of the chapters' models.

The stored ones, to four digits, are the page as it was read beside the paper. Another number means that a model, a
stored study or a formula of a chapter changed: see that it should, and store them with `HYPERTUNA_STORE=1`.
"""

import json
import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.cm import ScalarMappable
from matplotlib.collections import Collection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from hypertuna.reports.html import Part, Picture, Section, Table

STORED = Path(__file__).with_name("numbers.json")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
PATHS = ("fig12a",)  # pictures of the steps of a search, which differ from processor to processor
TOLERANCE = 2e-3  # relative; and a unit of the last digit, which another processor may round the other way


def numbers(part: Part) -> Iterator[str]:
    """Yield the numbers of a part in reading order; of drawn curves, bars and maps, mean and spread."""
    if isinstance(part, Picture):
        yield from NUMBER.findall(f"{part.shows} {part.made}")
        if isinstance(part.figure, Figure) and part.name not in PATHS:
            for axes in part.figure.axes:
                for drawn in (*axes.lines, *axes.collections, *axes.patches, *axes.images):
                    yield from (f"{value:.4g}" for value in _drawn(drawn))
                yield from NUMBER.findall(" ".join(text.get_text() for text in axes.texts))
    elif isinstance(part, Table):
        cells = [cell if isinstance(cell, str) else f"{cell:.4g}" for row in part.rows for cell in row]
        yield from NUMBER.findall(" ".join([part.shows, part.made, *cells]))
    else:
        yield from NUMBER.findall(re.sub(r"<svg.*?</svg>|\d+ evaluations", "", part, flags=re.DOTALL))


def _drawn(drawn: Artist) -> Iterator[float]:
    """Yield mean and spread of the coordinates of a drawn thing, and of the values that color it."""
    if isinstance(drawn, Line2D):
        points = drawn.get_xydata()
    elif isinstance(drawn, Patch):
        points = drawn.get_patch_transform().transform(drawn.get_path().vertices)
    elif isinstance(drawn, Collection):
        points = np.vstack([drawn.get_offsets(), *(path.vertices for path in drawn.get_paths())])
    else:
        points = np.empty((0, 2))
    colors = drawn.get_array() if isinstance(drawn, ScalarMappable) else None
    values = [] if colors is None else [np.ravel(colors)]
    for axis in (*np.asarray(points, dtype=float).T, *values):
        finite = np.ma.filled(np.ma.masked_invalid(axis), np.nan)
        if np.isfinite(finite).any():
            yield from (float(np.nanmean(finite)), float(np.nanstd(finite)))


def close(computed: str, stored: str) -> bool:
    """Return whether two numbers are equal but for rounding."""
    digits = len(stored.partition("e")[0].partition(".")[2])
    exponent = int(stored.partition("e")[2] or 0)
    last = 10.0 ** (exponent - digits) if digits or "e" in stored else 0.0
    return abs(float(computed) - float(stored)) <= max(TOLERANCE * abs(float(stored)), 1.01 * last)


@pytest.fixture(scope="module")
def shown(sections: list[Section]) -> dict[str, list[list[str]]]:
    return {section.title: [list(numbers(part)) for part in section.parts] for section in sections}


def test_the_numbers_of_the_page(shown: dict[str, list[list[str]]]) -> None:
    if os.environ.get("HYPERTUNA_STORE"):
        lines = ",\n".join(f" {json.dumps(title)}: {json.dumps(parts)}" for title, parts in shown.items())
        STORED.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    assert list(shown) == list(stored)
    pairs = ((title, *pair) for title in shown for pair in zip(shown[title], stored[title], strict=True))
    beside = [(title, one, other) for title, *parts in pairs for one, other in zip(*parts, strict=True)]
    assert not [(title, one, other) for title, one, other in beside if not close(one, other)]  # computed, stored


@pytest.mark.parametrize(
    ("computed", "same"),
    [("12.34", True), ("12.35", True), ("12.40", False), ("-12.34", False)],  # 0.03 is two thousandths of 12.34
)
def test_rounding_is_no_change(computed: str, same: bool) -> None:
    assert close(computed, "12.34") == same
    assert close(f"{computed}e-7", "12.34e-7") == same
