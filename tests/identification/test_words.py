"""What a fit says of itself: lists, the reason of a linear drag, and bars of its intervals."""

from collections.abc import Iterable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hypertuna.identification import cards, identify, sentences


def test_names_are_joined_as_one_says_them() -> None:
    assert sentences._join(["a"]) == "a"
    assert sentences._join(["a", "b"]) == "a and b"
    assert sentences._join(["a", "b", "c", "d"]) == "a, b, c and d"


def test_files_of_trials_are_named_as_a_robots_file_takes_them() -> None:
    """A fit with a sign for the terminal in a name, or with too long a list, was refused after the search."""
    assert identify._listed(["/a/b.csv", "c/b.csv", "", "\x1b[31m.csv"]) == "b.csv, memory, \\u001b[31m.csv"
    assert identify._listed([f"{k}" for k in range(52)]).endswith("48, 49, and 2 more")
    assert len(identify._listed([f"{k:03}{'x' * 250}" for k in range(1000)])) < 6000


@dataclass
class Fitted:
    """As much of a fit as the choice of a linear drag asks for."""

    train: Any
    uncertainty: Any
    free: tuple[Any, ...]
    trends: tuple[Any, ...]
    warnings: tuple[str, ...]
    evaluations: int


def fitted(error: float, bound: str, warnings: tuple[str, ...] = ()) -> Any:
    """A fit with an rms error of the speed, and where its last coefficient lies."""
    trends = tuple(SimpleNamespace(quantity=name) for name in ("amplitude", "frequency"))
    free = (SimpleNamespace(name="water.strip.drag_linear"),)
    rms = SimpleNamespace(rms={"speed_relative": error})
    return Fitted(rms, SimpleNamespace(bound=["", bound]), free, trends, warnings, 7)


def test_a_linear_drag_is_kept_with_its_reason_unless_it_is_zero() -> None:
    without = fitted(0.083, "")
    assert identify._with_linear_drag(without, fitted(0.02, "lower")) is without
    kept = identify._with_linear_drag(without, fitted(0.02, "", ("another",)))
    assert kept.warnings == (
        "water.strip.drag_linear is free, because errors of the speed go with frequency; "
        "the training error of the speed is 2 % with it and 8.3 % without.",
        "another",
    )
    assert kept.evaluations == 14


def test_bars_show_intervals_in_percent_of_the_median(monkeypatch: pytest.MonkeyPatch) -> None:
    """By hand: 1.8 to 2.5 about 2 is -10 to 25 %; an offset of 0.01 to 0.03 s about 0.02 is -10 to 10 % of 0.1 s."""
    rows: list[Any] = []

    def taken(bars: Iterable[Any], label: str) -> str:
        rows.extend(bars)
        return ""

    monkeypatch.setattr(cards, "bars_svg", taken)
    offset = next(iter(cards.ABSOLUTE_UNITS))
    free = [SimpleNamespace(name="drag", column="water.drag"), SimpleNamespace(name="offset", column=offset)]
    samples = np.array([[1.9, 0.01], [2.0, 0.02], [2.1, 0.03]])
    sampled: Any = SimpleNamespace(samples=samples, free=free, low=np.array([1.8, 0.01]), high=np.array([2.5, 0.03]))
    assert "Of offsets" in cards._ranges_svg(sampled)
    assert [name for name, *_ in rows] == ["drag", "offset"]
    np.testing.assert_allclose([ends for _, *ends in rows], [[-10, 25], [-10, 10]], rtol=1e-9)
