"""Tables and picture of docs/bench.md; docs/figures.py includes them."""

from __future__ import annotations

import math
import runpy
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from unittest import mock

from figures_common import rows
from matplotlib.figure import Figure

from hypertuna.characterization.data import read_bench
from hypertuna.characterization.experiment_design import information_gain
from hypertuna.characterization.fit import BenchFit, fit_bench
from hypertuna.characterization.plots import plot_bench
from hypertuna.characterization.unknowns import BORDER, FACTORS, KINDS, unknowns
from hypertuna.description.robot import load

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "bench"
FISH = load("hypertuna")
BEST = 6  # number of measurements shown, the most informative ones


@cache
def fitted(name: str) -> BenchFit:
    """Fit one of the examples."""
    return fit_bench(FISH, read_bench(FOLDER / f"{name}.csv", FISH), starts=1)


@cache
def truth() -> dict[str, float]:
    """Return the factors on described values that the example's script takes as true."""
    with tempfile.TemporaryDirectory() as folder, mock.patch("sys.argv", ["make.py", folder]):
        found: dict[str, float] = runpy.run_path(str(FOLDER / "make.py"))["TRUTH"]
    return found


def unknown_table() -> str:
    """Tabulate the unknowns with their default bounds."""
    body = []
    for one in unknowns(FISH, (0,), both_sides=(0,)):
        unit, factor = BORDER[one.unit]
        limits = KINDS[one.kind][:2]
        relative = abs(limits[1] * one.described - one.upper) < 1e-12 and one.described != 1
        unit = "times described" if relative else KINDS[one.kind].counted or unit
        low, high = limits if relative else (one.lower * factor, one.upper * factor)
        name, stands = one.kind + "[JOINT]" * (one.joint is not None), FACTORS.get(one.kind, ("", ""))[0]
        body.append([f"`{name}`", unit, f"`{stands}`" if stands else "itself", f"{low:.3g}", f"{high:.3g}"])
    return rows(["unknown", "unit", "in products", "lower", "upper"], body, left=3)


def combination_table() -> str:
    """Tabulate the example's combinations beside the truth."""
    fit = fitted("bench")
    logs = {u.factor: u.log(u.described * truth().get(u.name, 1.0)) - u.log(u.described) for u in fit.free}
    body = []
    for one in fit.combinations:
        real = math.exp(sum(e * logs[name] for name, e in one.exponents.items()))
        body.append([f"`{one.text}`", f"{one.value:.2f}", f"{one.low:.2f} .. {one.high:.2f}", f"{real:.2f}"])
    return rows(["product, over the described one", "fitted", "95 % interval", "true"], body)


def paper_table() -> str:
    """Tabulate the products of unknowns that the paper's two angles determine."""
    fit = fitted("paper")
    body = [[f"`{one.text}`", f"{one.low:.1g} .. {one.high:.1g}"] for one in fit.combinations]
    return rows(["product, over the described one", "95 % interval"], body)


def information_gain_table() -> str:
    """Tabulate the information gain of measurements after the paper's angles and after the example's bench."""
    fits = {"after the paper's two angles": fitted("paper"), "after the bench": fitted("bench")}
    bits = {name: {one.text: one.bits for one in information_gain(fit)} for name, fit in fits.items()}
    texts = list(dict.fromkeys(text for told in bits.values() for text in list(told)[:BEST]))
    body = [[text, *(f"{told[text]:.1f}" if text in told else "made" for told in bits.values())] for text in texts]
    return rows(["measurement", *(f"{name} [bits]" for name in bits)], body)


TABLES: dict[str, Callable[[], str]] = {
    "bench unknowns": unknown_table,
    "bench combinations": combination_table,
    "bench paper": paper_table,
    "bench information gain": information_gain_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/bench.svg": lambda: plot_bench(fitted("bench"))}
