"""Table and picture of docs/design.md; docs/figures.py includes them."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from figures_common import rows
from matplotlib.figure import Figure

from hypertuna.description.robot import load
from hypertuna.design.plots import plot_design
from hypertuna.design.runs import noise_of
from hypertuna.design.tank import NextRuns, TankDesign
from hypertuna.identification.coefficients import from_scale, with_values
from hypertuna.swimming.swim import swim
from hypertuna.trials.steady import SteadyRun

ROOT = Path(__file__).resolve().parents[1]
RUNS, SEED = 12, 3  # runs of the designed series; seed of the hidden robot


@cache
def tank() -> NextRuns:
    """Return the design after runs in a simulated tank, whose fish is the minnow with other coefficients."""
    rng = np.random.default_rng(SEED)
    with TankDesign(None, load(ROOT / "examples/minnow.toml")) as state:
        unknowns = state.unknowns
        x = unknowns.mean + 0.5 * unknowns.sd * rng.standard_normal(len(unknowns.mean))
        fish = with_values(unknowns.robot, unknowns.free, from_scale(unknowns.free, x))
        for _ in range(RUNS):
            choice = state.ask().choices[0]
            assert choice.run.gait is not None
            true = swim(fish, choice.run.gait).speed
            value = true * np.exp(noise_of("speed", true) * rng.standard_normal())
            state.tell([SteadyRun(choice.name, choice.run.gait, float(value))])
            if state.ask().stop:
                break
        return state.ask()


def study_table() -> str:
    """Tabulate the study of validation/design."""
    found = json.loads((ROOT / "validation/design/study.json").read_text())["summary"]
    body = [
        [
            f"{one['how'].replace('design', 'designed')}, {one['runs']} runs",
            "has a linear drag" if one["linear_drag"] else "is right",
            *(f"{100 * one[name]:.1f}" for name in ("error", "half_width")),
            f"{100 * one['coverage']:.0f}",
            *(f"{100 * one[name]:.1f}" for name in ("plain_error", "plain_half_width")),
            f"{100 * one['plain_coverage']:.0f}",
        ]
        for one in found
    ]
    heads = ["runs", "the model", "error", "± claimed", "held", "error, trusting", "± claimed", "held"]
    return rows(heads, body, 2)


TABLES: dict[str, Callable[[], str]] = {"designed runs": study_table}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/design.svg": lambda: plot_design(tank())}
