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
from hypertuna.identification.identify import identify
from hypertuna.reports.fit import write_fit
from hypertuna.swimming.model import parameter_names
from hypertuna.trials import kinds
from hypertuna.trials.kind import Kind, Point, Prediction, Quantity, Rows, Sample
from hypertuna.trials.trials import Trials, digest, split
from synthetic import grid, steady, swims

COLUMN = "water.lumped.friction"


@dataclass(frozen=True)
class Pulled:
    """A made-up pull: it is the sum of all friction times the squared speed."""

    name: str
    u: float  # m/s
    pull: float  # N
    file: str = "pull.csv"

    def to_pandas(self) -> pd.DataFrame:
        """Return it as a row."""
        return pd.DataFrame({"run": [self.name], "u_m_s": [self.u], "pull_n": [self.pull]})


def pull_of(friction: Sequence[float], u: float | np.ndarray) -> Any:
    """The made-up law."""
    return sum(friction) * u**2


@dataclass(frozen=True)
class PulledRows(Rows):
    """Tows together."""

    u: np.ndarray

    def predict(self, at: Point) -> Prediction:
        """Compute the pull."""
        friction = at.columns.get(COLUMN, at.robot.water.lumped.friction)
        jacobian = np.zeros((self.runs, at.count))
        if at.along is not None:
            own = [name.startswith(COLUMN) for name in parameter_names(at.robot)]
            jacobian = np.outer(self.u**2, at.along[own].sum(axis=0))
        none = np.zeros(self.runs, dtype=bool)
        return Prediction(pull_of(friction, self.u), jacobian, none, none, {})


class Pull(Kind[Pulled]):
    """Tows."""

    trial = Pulled
    key, label, others = "pulls", "pull", "speeds of pulling"
    quantities = (Quantity("pull", "N", "relative", "%", 100.0, 0.05, "pull"),)

    def motion(self, trial: Pulled) -> dict[str, float]:
        """A pull has no beat."""
        return {}

    def rows(self, robot: ht.Robot, trials: Sequence[Pulled], lowest: Mapping[str, float]) -> list[Rows]:
        """Lay out a number for each."""
        samples = [Sample("pull", k, pull.pull, False, 1) for k, pull in enumerate(trials)]
        pull, u = np.array([[pull.pull, pull.u] for pull in trials]).T
        return [PulledRows(pull, np.arange(len(pull)), samples, len(pull), u)]

    def cells(self, trial: Pulled) -> tuple[str, str, str]:
        """Name and speed."""
        return trial.name, "pulled", f"{trial.u} m/s"

    def picture(self, trials: Sequence[Pulled]) -> str:
        """Draw nothing."""
        return "<svg></svg>"

    def plot(self, trials: Sequence[Pulled], *, width: float) -> Figure:
        """Plot pull over speed."""
        figure = Figure(figsize=(width, width))
        figure.subplots().plot([pull.u for pull in trials], [pull.pull for pull in trials], "o")
        return figure

    def summaries(self, trials: Sequence[Pulled], robot: ht.Robot) -> list[dict[str, Any]]:
        """Count them."""
        return [{"file": "pull.csv", "runs": len(trials)}]

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Write the count."""
        yield f"{summary['file']}: {summary['runs']} pulls"


@pytest.fixture
def pulled(monkeypatch: pytest.MonkeyPatch, tuna: ht.Robot) -> Trials:
    """Tows of a robot with half the friction, once their kind stands in the list."""
    lists = {"KINDS": (*kinds.KINDS, Pull())}
    lists["QUANTITIES"] = {one.name: one for kind in lists["KINDS"] for one in kind.quantities}  # type: ignore[assignment]
    lists["NAMES"] = tuple(lists["QUANTITIES"])
    one = Pull.quantities[0]
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
    return Trials(tuple(Pulled(f"pull {u:g}", u, float(pull_of(half, u))) for u in (0.1, 0.2, 0.3, 0.4)))


def test_a_new_kind_is_fitted_alone(pulled: Trials, tuna: ht.Robot) -> None:
    fit = identify(tuna, pulled, ["water.friction=common"], validate=0, starts=1)
    assert fit.values == pytest.approx([0.5], rel=1e-6)
    assert fit.train.rms["pull_relative"] < 1e-6
    assert fit.uncertainty.directions[0].sentence.startswith("Pull constrains water.lumped.friction[0-7]=common to ")
    assert {"pull_measured_n", "pull_computed_n"} < fit.train.runs[0].keys()


def test_a_new_kind_is_fitted_beside_the_others(pulled: Trials, tuna: ht.Robot, tmp_path: Path) -> None:
    """The pulls alone change the friction: beats and swims are those of the robot as it is."""
    beats = steady(tuna, grid([1, 2, 3], [(8, 15), (16, 25)], [0]), noise=0.01)
    trials = pulled + swims(tuna, runs=2, noise=0.01) + beats
    assert [kind.key for kind in trials.kinds] == ["steady", "recordings", "pulls"]
    assert digest(trials) != digest(trials.only(trials.runs[:-1]))
    assert sorted(name for part in split(trials, 0.3, 0) for name in part.runs) == sorted(trials.runs)
    fit = identify(tuna, trials, ["water.friction=common", "water.drag=common"], validate=0, starts=1)
    assert 0.4 < fit.values[0] < 1.1
    assert {"speed_relative", "x_m", "pull_relative"} < set(fit.quantities)
    page = write_fit({"lumped": fit}, "lumped", tmp_path / "fit.html").read_text(encoding="utf-8")
    assert "pull 0.1" in page
    assert "pull (%)" in page
    assert fit.robot.fit is not None
    assert fit.robot.fit.trials == "synthetic.csv, synthetic.toml, pull.csv"


def test_a_new_kind_is_shown(pulled: Trials, tuna: ht.Robot) -> None:
    assert "pull 0.2" in pulled._repr_html_()
    assert pulled.plot().axes[0].lines
    assert list(pulled.to_pandas()["pull_n"]) == [pull.pull for pull in pulled.members]  # type: ignore[union-attr]
    assert list(_lines(_summary(pulled, tuna), "x")) == [
        "pull.csv: 4 pulls",
        "4 runs in all, checked against the model of x",
    ]
