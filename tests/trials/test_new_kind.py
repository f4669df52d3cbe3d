"""A kind of trial that no module knows: a class and its place in the list are enough to fit it and to show it."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import hypertuna as ht
from hypertuna.cli.trials import _lines, _summary
from hypertuna.display import plots
from hypertuna.identification.identify import identify
from hypertuna.reports.fit import write_fit
from hypertuna.swimming.model import parameter_names
from hypertuna.trials import kinds
from hypertuna.trials.kind import Kind, Point, Prediction, Quantity, Rows, Sample
from hypertuna.trials.trials import Trials, digest, split
from synthetic import grid, steady, swims

COLUMN = "water.lumped.friction"


@dataclass(frozen=True)
class Towed:
    """A made-up tow: its drag is the sum of all friction times the squared speed."""

    name: str
    u: float  # m/s
    drag: float  # N
    file: str = "tow.csv"

    def to_pandas(self) -> pd.DataFrame:
        """Return it as a row."""
        return pd.DataFrame({"run": [self.name], "u_m_s": [self.u], "drag_n": [self.drag]})


def drag_of(friction: Sequence[float], u: float | np.ndarray) -> Any:
    """The made-up law."""
    return sum(friction) * u**2


@dataclass(frozen=True)
class TowedRows(Rows):
    """Tows together."""

    u: np.ndarray

    def predict(self, at: Point) -> Prediction:
        """Compute the drag."""
        friction = at.columns.get(COLUMN, at.robot.water.lumped.friction)
        jacobian = np.zeros((self.runs, at.count))
        if at.along is not None:
            own = [name.startswith(COLUMN) for name in parameter_names(at.robot)]
            jacobian = np.outer(self.u**2, at.along[own].sum(axis=0))
        none = np.zeros(self.runs, dtype=bool)
        return Prediction(drag_of(friction, self.u), jacobian, none, none, {})


class Tow(Kind[Towed]):
    """Tows."""

    trial = Towed
    key, label, others = "tows", "tow", "speeds of towing"
    quantities = (Quantity("drag", "N", "relative", "%", 100.0, 0.05, "drag"),)

    def motion(self, trial: Towed) -> dict[str, float]:
        """A tow has no beat."""
        return {}

    def rows(self, robot: ht.Robot, trials: Sequence[Towed], lowest: Mapping[str, float]) -> list[Rows]:
        """Lay out a number for each."""
        samples = [Sample("drag", k, tow.drag, False, 1) for k, tow in enumerate(trials)]
        drag, u = np.array([[tow.drag, tow.u] for tow in trials]).T
        return [TowedRows(drag, np.arange(len(drag)), samples, len(drag), u)]

    def cells(self, trial: Towed) -> tuple[str, str, str]:
        """Name and speed."""
        return trial.name, "towed", f"{trial.u} m/s"

    def picture(self, trials: Sequence[Towed]) -> str:
        """Draw nothing."""
        return "<svg></svg>"

    def summaries(self, trials: Sequence[Towed], robot: ht.Robot) -> list[dict[str, Any]]:
        """Count them."""
        return [{"file": "tow.csv", "runs": len(trials)}]

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Write the count."""
        yield f"{summary['file']}: {summary['runs']} tows"


def plot_tows(tows: Sequence[Towed], *, width: float) -> Figure:
    """Plot drag over speed."""
    figure = Figure(figsize=(width, width))
    figure.subplots().plot([tow.u for tow in tows], [tow.drag for tow in tows], "o")
    return figure


plots[Tow] = plot_tows


@pytest.fixture
def towed(monkeypatch: pytest.MonkeyPatch, tuna: ht.Robot) -> Trials:
    """Tows of a robot with half the friction, once their kind stands in the list."""
    lists = {"KINDS": (*kinds.KINDS, Tow())}
    lists["QUANTITIES"] = {one.name: one for kind in lists["KINDS"] for one in kind.quantities}  # type: ignore[assignment]
    lists["NAMES"] = tuple(lists["QUANTITIES"])
    one = Tow.quantities[0]
    from hypertuna.identification import experiment, residuals

    old = {"KINDS": kinds.KINDS, "QUANTITIES": kinds.QUANTITIES, "NAMES": experiment.NAMES}
    old |= {"LABELS": residuals.LABELS, "NUMBERS": residuals.NUMBERS}
    lists |= {"LABELS": residuals.LABELS | {one.key: (one.label, one.shown, one.factor)}}  # type: ignore[dict-item]
    lists |= {"NUMBERS": residuals.NUMBERS | {one.name: one.unit}}  # type: ignore[dict-item]
    for module in [module for name, module in sys.modules.items() if name.startswith("hypertuna.")]:
        for name, value in old.items():
            if getattr(module, name, None) is value:  # as the import would have given it
                monkeypatch.setattr(module, name, lists[name])
    half = [x / 2 for x in tuna.water.lumped.friction]
    return Trials(tuple(Towed(f"tow {u:g}", u, float(drag_of(half, u))) for u in (0.1, 0.2, 0.3, 0.4)))


def test_a_new_kind_is_fitted_alone(towed: Trials, tuna: ht.Robot) -> None:
    fit = identify(tuna, towed, ["water.friction=common"], validate=0, starts=1)
    assert fit.values == pytest.approx([0.5], rel=1e-6)
    assert fit.train.rms["drag_relative"] < 1e-6
    assert fit.uncertainty.directions[0].sentence.startswith("Drag constrains water.lumped.friction[0-7]=common to ")
    assert {"drag_measured_n", "drag_computed_n"} < fit.train.runs[0].keys()


def test_a_new_kind_is_fitted_beside_the_others(towed: Trials, tuna: ht.Robot, tmp_path: Path) -> None:
    """The tows alone change the friction: beats and swims are those of the robot as it is."""
    beats = steady(tuna, grid([1, 2, 3], [(8, 15), (16, 25)], [0]), noise=0.01)
    trials = towed + swims(tuna, runs=2, noise=0.01) + beats
    assert [kind.key for kind in trials.kinds] == ["steady", "recordings", "tows"]
    assert digest(trials) != digest(trials.only(trials.runs[:-1]))
    assert sorted(name for part in split(trials, 0.3, 0) for name in part.runs) == sorted(trials.runs)
    fit = identify(tuna, trials, ["water.friction=common", "water.drag=common"], validate=0, starts=1)
    assert 0.4 < fit.values[0] < 1.1
    assert {"speed_relative", "x_m", "drag_relative"} < set(fit.quantities)
    page = write_fit({"lumped": fit}, "lumped", tmp_path / "fit.html").read_text(encoding="utf-8")
    assert "tow 0.1" in page
    assert "drag (%)" in page
    assert fit.robot.fit is not None
    assert fit.robot.fit.trials == "synthetic.csv, synthetic.toml, tow.csv"


def test_a_new_kind_is_shown(towed: Trials, tuna: ht.Robot) -> None:
    assert "tow 0.2" in towed._repr_html_()
    assert towed.plot().axes[0].lines
    assert list(towed.to_pandas()["drag_n"]) == [tow.drag for tow in towed.members]  # type: ignore[union-attr]
    assert list(_lines(_summary(towed, tuna), "x")) == [
        "tow.csv: 4 tows",
        "4 runs in all, checked against the model of x",
    ]
