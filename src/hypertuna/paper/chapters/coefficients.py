"""Table III: what the published speeds determine of the nine coefficients, and of the joints' bandwidth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.identification.identify import Fit, identify
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.chapters.model_checks import model_checks
from hypertuna.paper.computed import OURS, PAPER, SPEEDS, bandwidths
from hypertuna.paper.ledger import Finding, published_value
from hypertuna.reports.html import Section, Table
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.swim import swim
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.trials import Trials as Runs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TIES = "[0,1-6,7]"  # links that share a coefficient in Table III: head, six links, fin
NINE = tuple(f"water.{name}{TIES}" for name in ("added_mass", "friction", "drag"))
INITIAL = {"water.added_mass": 0.2, "water.friction": 0.2, "water.drag": 10.0}  # Table III, column mu_0
UNOPTIMISED, OPTIMISED = SPEEDS[:4], SPEEDS[4:]
SYMBOLS = {"added_mass": "c_m", "friction": "c_f", "drag": "c_d"}


@dataclass(frozen=True)
class Fits:
    """Identifications from published speeds: of nine coefficients by model, and of the joints' bandwidth."""

    trials: Trials
    nine: dict[str, Fit]  # the nine coefficients of Table III from the eight speeds, by model
    four: Fit  # the joints' bandwidth from the four unoptimized gaits
    predicted: dict[str, float]  # speeds of all eight gaits with that bandwidth [m/s]
    left_out: dict[str, tuple[float, float]]  # by gait: bandwidth from the other seven [Hz], speed with it [m/s]


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Fits:
    """Return the identifications from the published speeds; in full with more starts than the paper's."""
    robot = trials[OURS].robot
    runs = published_runs(robot)
    nine = {}
    for model in (PAPER, OURS):
        starts = 4 if full else 1
        nine[model] = identify(trials[model].robot, runs, NINE, validate=0, start=INITIAL, starts=starts)
        step()
    four = identify(robot, runs.only(UNOPTIMISED), ["joints.bandwidth"], validate=0, starts=1)
    left_out = {}
    for name in SPEEDS:
        fit_without = identify(robot, runs.only(set(SPEEDS) - {name}), ["joints.bandwidth"], validate=0, starts=1)
        left_out[name] = (float(fit_without.values[0]), swim(fit_without.robot, named_gait(robot, name)).speed)
    predicted = {name: swim(four.robot, named_gait(robot, name)).speed for name in SPEEDS}
    return Fits(trials, nine, four, predicted, left_out)


def published_runs(robot: Robot) -> Runs:
    """Return the eight gaits of Table IV with their speeds."""
    return Runs(
        tuple(
            SteadyRun(name, named_gait(robot, name), speed=published_value(f"speed/{name}"), file="Table IV")
            for name in SPEEDS
        )
    )


def findings(fits: Fits) -> Iterator[Finding]:
    """Yield the coefficients of Table III with their intervals."""
    for model, fit in fits.nine.items():
        for k, coefficient in enumerate(fit.free):
            interval = (float(fit.uncertainty.low[k]), float(fit.uncertainty.high[k]))
            at_bound = _bound(fit, k)
            value = float(fit.values[k]) if at_bound is None else at_bound
            note = f"95 % interval {interval[0]:.3g} to {interval[1]:.3g}{'' if at_bound is None else ', at its bound'}"
            yield Finding(_id(coefficient.name), model, "fitted", value, note, interval)


def sections(fits: Fits) -> list[Section]:
    """Show Table III and the bandwidth, then the checks of the model."""
    sections = compose(
        "coefficients",
        {
            "table-iii": _figure(fits),
            "coefficients": coefficient_table(fits),
            "bandwidth": bandwidth_table(fits),
        },
        **_facts(fits),
        **_bandwidth(fits),
    )
    return [*sections, *model_checks(fits.nine, fits.trials)]


def coefficient_table(fits: Fits) -> Table:
    """Return Table III with our identification beside it."""
    rows = []
    for k, coefficient in enumerate(fits.nine[OURS].free):
        cells = [_symbol(coefficient.name), f"{coefficient.lower:g} to {coefficient.upper:g}"]
        cells.append(f"{published_value(_id(coefficient.name)):g}")
        for fit in fits.nine.values():
            at_bound = _bound(fit, k)
            cells.append(f"{fit.values[k]:.3g}" if at_bound is None else f"{at_bound:g}, its bound")
            cells.append(f"{fit.uncertainty.low[k]:.3g} to {fit.uncertainty.high[k]:.3g}")
        rows.append(cells)
    header = [f"{model}: {what}" for model in fits.nine for what in ("identified", "95 % interval")]
    return Table(["coefficient", "bounds", "published", *header], rows)


def bandwidth_table(fits: Fits) -> Table:
    """Tabulate the eight speeds by the bandwidth from four gaits, and each by the bandwidth from the seven others."""
    from_four, left_out = _errors(fits)
    rows = []
    for name in SPEEDS:
        band, speed = fits.left_out[name]
        four = [f"{fits.predicted[name]:.3f}", f"{from_four[name]:+.1f} %"]
        others = [f"{band:.2f}", f"{speed:.3f}", f"{left_out[name]:+.1f} %"]
        rows.append([name, f"{published_value(f'speed/{name}'):.3f}", *four, *others])
    header = ["published [m/s]", "from four [m/s]", "error", "others' bandwidth [Hz]", "left out [m/s]", "error"]
    return Table(["gait", *header], rows)


def _id(name: str) -> str:
    """Return the id of a coefficient in the ledger."""
    return f"coefficient/{name.rpartition('.')[2]}"


def _symbol(name: str) -> str:
    """Return the symbol of a coefficient in the paper."""
    column, _, index = name.rpartition(".")[2].partition("[")
    return f"{SYMBOLS[column]},{index.rstrip(']')}"


def _bound(fit: Fit, k: int) -> float | None:
    """Return the bound that coefficient k lies on; None if on neither."""
    side = fit.uncertainty.bound[k]
    return None if side is None else {"lower": fit.free[k].lower, "upper": fit.free[k].upper}[side]


def _figure(fits: Fits) -> Figure:
    """Draw the coefficients between their bounds."""
    from hypertuna.paper.figures import plot_intervals

    free = fits.nine[OURS].free
    return plot_intervals(
        [_symbol(one.name) for one in free],
        ([one.lower for one in free], [one.upper for one in free]),
        [published_value(_id(one.name)) for one in free],
        {model: (fit.values, fit.uncertainty.low, fit.uncertainty.high) for model, fit in fits.nine.items()},
    )


def _facts(fits: Fits) -> dict[str, Any]:
    """Return the values that fill in the text on the coefficients."""
    ours = fits.nine[OURS]
    directions = [d for fit in fits.nine.values() for d in fit.uncertainty.directions]
    sentences = [d.sentence for d in ours.uncertainty.directions if any(one.name in d.sentence for one in ours.free)]
    return {
        "ideal": fits.nine[PAPER],
        "ours": ours,
        "determined": sum(direction.constrained for direction in directions),
        "bound": published_value("speed/model-error-max"),
        "at_bound": sum(side is not None for side in ours.uncertainty.bound),
        "best_known": sentences[0] if sentences else "",
        "starts": len(fits.nine[PAPER].costs),
    }


def _errors(fits: Fits) -> tuple[dict[str, float], dict[str, float]]:
    """Return errors of each speed [%]: by the bandwidth from four gaits, and by that from the seven other gaits."""
    truth = {name: published_value(f"speed/{name}") for name in SPEEDS}
    from_four = {name: 100 * (fits.predicted[name] / truth[name] - 1) for name in SPEEDS}
    return from_four, {name: 100 * (fits.left_out[name][1] / truth[name] - 1) for name in SPEEDS}


def _bandwidth(fits: Fits) -> dict[str, Any]:
    """Return the values that fill in the text on the bandwidth: from four gaits, and from seven for each left out."""
    uncertainty, (value,) = fits.four.uncertainty, fits.four.values
    from_four, left_out = _errors(fits)
    errors = {
        "fitted": [from_four[name] for name in UNOPTIMISED],
        "tested": [from_four[name] for name in OPTIMISED],
        "left_out": list(left_out.values()),
    }
    return {
        "bandwidth": value,
        "low": uncertainty.low[0],
        "high": uncertainty.high[0],
        "largest": {name: max(map(abs, values)) for name, values in errors.items()},
        "rms": {name: float(np.sqrt(np.mean(np.square(values)))) for name, values in errors.items()},
        "bands": [band for band, _ in fits.left_out.values()],
        "described": bandwidths(fits.four.described),
    }


CHAPTER = Chapter("fits", sections, findings, compute, steps=3, full_steps=3)
