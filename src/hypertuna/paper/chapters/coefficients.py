"""Table III: what the published speeds tell of the nine coefficients, and of the joints' bandwidth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.identification.identify import Fit, identify
from hypertuna.paper.computed import OURS, PAPER, SPEEDS, Trial, bandwidths
from hypertuna.paper.ledger import Finding
from hypertuna.reports.html import WIDTH, Picture, Section, Table
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.swim import swim
from hypertuna.trials.trials import SteadyRun, Trials

__all__ = ["Fits", "bandwidth_table", "coefficient_table", "findings", "fit_published", "sections"]

TIES = "[0,1-6,7]"  # Table III: head, six links alike, fin
NINE = tuple(f"water.{name}{TIES}" for name in ("added_mass", "friction", "drag"))
INITIAL = {"water.added_mass": 0.2, "water.friction": 0.2, "water.drag": 10.0}  # Table III, column mu_0
UNOPTIMISED, OPTIMISED = SPEEDS[:4], SPEEDS[4:]
SYMBOLS = {"added_mass": "c_m", "friction": "c_f", "drag": "c_d"}


@dataclass(frozen=True)
class Fits:
    """Identifications from published speeds.

    Attributes
    ----------
    nine : dict of str to Fit
        The nine coefficients of Table III from the eight speeds, by model.
    four : Fit
        The joints' bandwidth from the four unoptimized gaits.
    predicted : dict of str to float
        Speeds of all eight gaits with that bandwidth [m/s].
    left_out : dict of str to (float, float)
        For each gait, the bandwidth from the other seven [Hz] and the speed with it [m/s].
    """

    nine: dict[str, Fit]
    four: Fit
    predicted: dict[str, float]
    left_out: dict[str, tuple[float, float]]


def fit_published(
    trials: Mapping[str, Trial],
    paper: Mapping[str, Any],
    *,
    starts: int = 1,
    progress: Callable[[], None] | None = None,
) -> Fits:
    """Identify from the published speeds.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping
    starts : int
        Searches for the nine coefficients, the first from the paper's start values.
    progress : callable, optional
        Called after each of three parts.

    Returns
    -------
    Fits
    """
    step = progress or (lambda: None)
    robot = trials[OURS].robot
    runs = Trials(
        tuple(
            SteadyRun(name, named_gait(robot, name), speed=paper["values"][f"speed/{name}"]["value"], file="Table IV")
            for name in SPEEDS
        )
    )
    nine = {}
    for model in (PAPER, OURS):
        nine[model] = identify(trials[model].robot, runs, NINE, validate=0, start=INITIAL, starts=starts)
        step()
    four = identify(robot, runs.only(UNOPTIMISED), ["joints.bandwidth"], validate=0, starts=1)
    left_out = {}
    for name in SPEEDS:
        rest = identify(robot, runs.only(set(SPEEDS) - {name}), ["joints.bandwidth"], validate=0, starts=1)
        left_out[name] = (float(rest.values[0]), swim(rest.robot, named_gait(robot, name)).speed)
    step()
    predicted = {name: swim(four.robot, named_gait(robot, name)).speed for name in SPEEDS}
    return Fits(nine, four, predicted, left_out)


def findings(fits: Fits) -> Iterator[Finding]:
    """Yield the coefficients of Table III with their intervals.

    Parameters
    ----------
    fits : Fits

    Yields
    ------
    Finding
    """
    for model, fit in fits.nine.items():
        sure = fit.uncertainty
        for k, one in enumerate(fit.free):
            interval = (float(sure.low[k]), float(sure.high[k]))
            end = {"lower": one.lower, "upper": one.upper, None: None}[sure.bound[k]]
            value = float(fit.values[k]) if end is None else end
            note = f"95 % interval {interval[0]:.3g} to {interval[1]:.3g}{'' if end is None else ', at its bound'}"
            yield Finding(f"coefficient/{one.name.rpartition('.')[2]}", model, value, note, interval)


def sections(fits: Fits, trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> list[Section]:
    """Show Table III and the bandwidth.

    Parameters
    ----------
    fits : Fits
    trials : mapping of str to Trial
    paper : mapping

    Returns
    -------
    list of Section
    """
    from hypertuna.paper.figures import plot_intervals

    fit = fits.nine[OURS]
    names = [_symbol(one.name) for one in fit.free]
    published = [paper["values"][f"coefficient/{one.name.rpartition('.')[2]}"]["value"] for one in fit.free]
    low, high = ([getattr(one, side) for one in fit.free] for side in ("lower", "upper"))
    shown = {model: (one.values, one.uncertainty.low, one.uncertainty.high) for model, one in fits.nine.items()}
    picture = Picture(
        "table-iii",
        plot_intervals(names, (low, high), published, shown, width=WIDTH),
        "The nine coefficients of Table III between their bounds: as published, and as identified from the eight "
        "published speeds, with 95 % intervals. Where the interval fills the whole range, the speeds say nothing of "
        "the coefficient.",
        "`hypertuna.identify` with exact derivatives from the paper's start values; intervals from the curvature of "
        "the error at the result.",
    )
    return [
        Section(
            "Identification, Table III",
            [
                _text(fits, paper),
                picture,
                coefficient_table(fits, paper),
                _bandwidth(fits, paper),
                bandwidth_table(fits, paper),
            ],
        )
    ]


def _symbol(name: str) -> str:
    """Write a coefficient as the paper does."""
    column, _, index = name.rpartition(".")[2].partition("[")
    return f"{SYMBOLS[column]},{index.rstrip(']')}"


def _text(fits: Fits, paper: Mapping[str, Any]) -> str:
    """Say what the fits tell."""
    ideal, ours = fits.nine[PAPER], fits.nine[OURS]
    bound = paper["values"]["speed/model-error-max"]["value"]
    known = sum(direction.determined for fit in fits.nine.values() for direction in fit.uncertainty.directions)
    ends = sum(side is not None for side in ours.uncertainty.bound)
    return f"""The authors identified nine coefficients from their tank tests, which are not published. Published are
eight speeds. **Nine numbers cannot be determined from eight**, and it is worse than that: of the nine directions in
the space of the coefficients the speeds determine {known or "none"} in either model, and every 95 % interval is as
wide as the bounds. So Table III can be neither confirmed nor refuted from what is published.

What can be told is how well the model can do at all. **With ideal joints no coefficients were found within the bounds
of Table III that meet the eight speeds**: the best ones miss them by {_percent(ideal.train.rms)} rms and
{_percent(ideal.train.max)} at most. With joint bandwidth the best ones miss them by {_percent(ours.train.rms)}
rms and {_percent(ours.train.max)} at most, within the {bound:g} % that the paper claims for its model; {ends} of
the nine then sit on their bounds, far from Table III.{_best_known(ours)}

{_starts(fits)}"""


def _best_known(fit: Fit) -> str:
    """Say what is known best, of the directions whose sentence names a coefficient."""
    told = [d.sentence for d in fit.uncertainty.directions if any(one.name in d.sentence for one in fit.free)]
    return f" Of the direction that is known best the program says: {told[0]}" if told else ""


def _starts(fits: Fits) -> str:
    """Say where the searches began, and how the one with ideal joints ended."""
    fit = fits.nine[PAPER]
    alone = "the paper's start values alone (`hypertuna reproduce --full` takes others, too)"
    others = f"the paper's start values and others, {len(fit.costs)} in all"
    return f"The searches began at {alone if len(fit.costs) == 1 else others}. With ideal joints: {fit.stop}"


def _percent(errors: Mapping[str, float]) -> str:
    """Write a relative error of the speed."""
    return f"{100 * errors['speed_relative']:.1f} %"


def coefficient_table(fits: Fits, paper: Mapping[str, Any]) -> Table:
    """Write Table III with our identification beside it.

    Parameters
    ----------
    fits : Fits
    paper : mapping

    Returns
    -------
    Table
    """
    rows: list[list[str | float]] = []
    for k, one in enumerate(fits.nine[OURS].free):
        told = paper["values"][f"coefficient/{one.name.rpartition('.')[2]}"]["value"]
        cells: list[str | float] = [_symbol(one.name), f"{one.lower:g} to {one.upper:g}", f"{told:g}"]
        for fit in fits.nine.values():
            sure = fit.uncertainty
            end = {"lower": one.lower, "upper": one.upper, None: None}[sure.bound[k]]
            cells.append(f"{fit.values[k]:.3g}" if end is None else f"{end:g}, its bound")
            cells.append(f"{sure.low[k]:.3g} to {sure.high[k]:.3g}")
        rows.append(cells)
    heads = [f"{model}: {what}" for model in fits.nine for what in ("identified", "95 % interval")]
    return Table(
        ["coefficient", "bounds", "published", *heads],
        rows,
        "Table III: the coefficients as published (column mu), and as identified from the eight published speeds.",
        "Bounds and start values as the authors'; robust loss, noise of the speeds estimated from the residuals.",
    )


def _misses(fits: Fits, paper: Mapping[str, Any]) -> tuple[dict[str, float], dict[str, float]]:
    """Return errors of the speeds in percent: with the bandwidth from four gaits, and of each gait left out."""
    truth = {name: paper["values"][f"speed/{name}"]["value"] for name in SPEEDS}
    from_four = {name: 100 * (fits.predicted[name] / truth[name] - 1) for name in SPEEDS}
    return from_four, {name: 100 * (fits.left_out[name][1] / truth[name] - 1) for name in SPEEDS}


def _bandwidth(fits: Fits, paper: Mapping[str, Any]) -> str:
    """Tell of the joints' bandwidth: from four gaits, judged on four, and leaving each one out."""
    sure, (value,) = fits.four.uncertainty, fits.four.values
    from_four, left_out = _misses(fits, paper)
    fitted, judged = ([from_four[name] for name in names] for names in (UNOPTIMISED, OPTIMISED))
    bands, left = [band for band, _ in fits.left_out.values()], list(left_out.values())
    return f"""**The joints' bandwidth alone, from the four unoptimized gaits**, with Table III as published, is
{value:.2f} Hz (95 % interval {sure.low[0]:.2f} to {sure.high[0]:.2f} Hz). It predicts the four optimized gaits, which
it has not seen, with an error of {_largest(judged):.1f} % at most and {_rms(judged):.1f} % rms; the four that it was
fitted to it meets within {_largest(fitted):.1f} %. Leaving out one gait of all eight at a time gives {min(bands):.2f}
to {max(bands):.2f} Hz, and predicts the one left out with {_largest(left):.1f} % at most and {_rms(left):.1f} % rms.
The robot's description has {bandwidths(fits.four.described)} Hz."""


def bandwidth_table(fits: Fits, paper: Mapping[str, Any]) -> Table:
    """Write the eight speeds with the bandwidth from four gaits, and with that from the others of each.

    Parameters
    ----------
    fits : Fits
    paper : mapping

    Returns
    -------
    Table
    """
    from_four, left_out = _misses(fits, paper)
    rows: list[list[str | float]] = []
    for name in SPEEDS:
        band, speed = fits.left_out[name]
        told = f"{paper['values'][f'speed/{name}']['value']:.3f}"
        four = [f"{fits.predicted[name]:.3f}", f"{from_four[name]:+.1f} %"]
        rows.append([name, told, *four, f"{band:.2f}", f"{speed:.3f}", f"{left_out[name]:+.1f} %"])
    return Table(
        ["gait", "published [m/s]", "from four [m/s]", "error", "others' bandwidth [Hz]", "left out [m/s]", "error"],
        rows,
        "Speeds with the bandwidth from the four unoptimized gaits, and with that from the seven others of each gait.",
        "`hypertuna identify --free joints.bandwidth`, Table III unchanged.",
    )


def _largest(values: Sequence[float]) -> float:
    """Return the largest magnitude."""
    return max(map(abs, values))


def _rms(values: Sequence[float]) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
