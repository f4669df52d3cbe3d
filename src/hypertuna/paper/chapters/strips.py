"""Water as strips: two numbers fitted on four gaits, all else from theory; with joints that lag, and in the twin."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hypertuna.identification.coefficients import with_values
from hypertuna.identification.identify import Fit, identify
from hypertuna.optimization.optimum import Optimum
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.chapters.coefficients import OPTIMISED, UNOPTIMISED, published_runs
from hypertuna.paper.chapters.gaits import gait_findings, speed_classes
from hypertuna.paper.chapters.model_checks import start_finding
from hypertuna.paper.chapters.optima import optimum_findings, table_iv
from hypertuna.paper.chapters.seeds import percent, power_findings
from hypertuna.paper.chapters.tank import tank_findings
from hypertuna.paper.chapters.turning import turning_findings
from hypertuna.paper.computed import COSTS, OURS, SPEEDS, STRIPS, TWIN, Trial, try_robot
from hypertuna.paper.ledger import Finding, published, published_value
from hypertuna.paper.seeds import Stored, read_seeds
from hypertuna.reports.html import Section, Table
from hypertuna.swimming.gait import named_gait

FREE = ("water.blunt_area[0]", "joints.bandwidth")  # form drag of the head, and the joints' lag
IN_TWIN = f"{STRIPS}, {TWIN}"
DRAG = "form drag of the head as in the robot's file, fitted to the unoptimised gaits with joints that lag"
FORM = "the form of the fin's force was weighed with the best phases in view"
FIN = "the sharp-edged fin was chosen with these changes in view"
# Gaits over which errors of speeds are averaged.
PARTS = {"fitted": UNOPTIMISED, "others": OPTIMISED, "all": SPEEDS}


@dataclass(frozen=True)
class Strips:
    """The strip law with two numbers fitted on four gaits: the fit, the swims of all tests, the twin's numbers."""

    fit: Fit
    values: tuple[float, ...]  # of the fit, to three digits, with which `trial` swims
    trial: Trial
    optima: Mapping[str, Optimum]  # by expected speed of Table IV
    swims: Stored  # the twin's runs of the eight gaits


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Strips:
    """Fit the two numbers, and swim all that the paper reports."""
    robot = trials[OURS].robot.using(water="strip")
    fit = identify(robot, published_runs(robot).only(UNOPTIMISED), FREE, validate=0, starts=1)
    values = tuple(float(f"{value:.3g}") for value in fit.values)  # the same on every machine
    trial = try_robot(with_values(robot, fit.free, values), published())
    return Strips(fit, values, trial, table_iv(trial.robot), read_seeds("strips", robot))


def findings(strips: Strips) -> Iterator[Finding]:
    """Yield speeds, changes and turns with lagging joints, then the twin's numbers over seeds, without turns."""
    blunt, bandwidth = strips.values
    note = f"{1e4 * blunt:.3g} cm^2 of drag area of the head and {bandwidth:.3g} Hz, fitted to the unoptimised gaits"
    for finding in gait_findings(STRIPS, strips.trial.gaits, dict.fromkeys(SPEEDS, note)):
        yield finding._replace(class_="in sight", note=f"{finding.note}; {FIN}") if "cost" in finding.id else finding
    for finding in (*tank_findings(STRIPS, strips.trial), *optimum_findings(STRIPS, strips.optima)):
        excluded = finding.id.startswith("optimal-phase") or finding.id == "optimum/max/phase"
        note = "; ".join(filter(None, (finding.note, FORM)))
        yield finding._replace(class_="in sight", note=note) if excluded else finding
    yield from turning_findings(STRIPS, strips.trial)
    yield start_finding(STRIPS, strips.trial)
    yield from twin_findings(strips.swims)


def twin_findings(stored: Stored) -> Iterator[Finding]:
    """Yield the twin's findings on speeds, powers and changes with this water, over seeds or over the family."""
    n = stored.numbers
    classes = speed_classes({name: named_gait(stored.robot, name) for name in SPEEDS})
    for name in SPEEDS:
        yield stored.finding(f"speed/{name}", IN_TWIN, classes[name], n[f"{name} speed"], DRAG)
    yield from power_findings(IN_TWIN, stored)
    gain = percent(n["unoptimised-max speed"], n["optimised-max speed"])
    yield stored.finding("speed/change-max", IN_TWIN, "prediction", gain, "optimised against unoptimised")
    for speed in COSTS:
        before, after = (
            n[f"{kind}-{speed} power"] / n[f"{kind}-{speed} speed"] for kind in ("unoptimised", "optimised")
        )
        key = f"cost-of-transport/change-{speed}"
        yield stored.finding(key, IN_TWIN, "in sight", percent(before, after), f"electrical; {FIN}")


def sections(strips: Strips) -> list[Section]:
    """Show the eight speeds."""
    lagging = {name: strips.trial.gaits[name].speed for name in SPEEDS}
    uncertainty = strips.fit.uncertainty
    return compose(
        "strips",
        {"strips": strip_table(strips)},
        values=strips.values,
        low=uncertainty.low,
        high=uncertainty.high,
        lagging=_rms(lagging),
        twin=_rms(_twin(strips)),
    )


def strip_table(strips: Strips) -> Table:
    """Tabulate the eight speeds: with joints that lag, and the twin's medians."""
    rows, twin = [], _twin(strips)
    classes = speed_classes({name: strips.trial.gaits[name].gait for name in SPEEDS})
    for name in SPEEDS:
        value, cells = published_value(f"speed/{name}"), []
        for speed in (strips.trial.gaits[name].speed, twin[name]):
            cells += [f"{speed:.3f}", f"{100 * (speed / value - 1):+.1f} %"]
        rows.append([name, f"{value:g}", classes[name], *cells])
    return Table(["gait", "published [m/s]", "class", "strips [m/s]", "error", "in the twin [m/s]", "error"], rows)


def _twin(strips: Strips) -> dict[str, float]:
    """Return the twin's median speeds over seeds, by gait [m/s]."""
    return {name: float(np.median(strips.swims.numbers[f"{name} speed"])) for name in SPEEDS}


def _rms(speeds: Mapping[str, float]) -> dict[str, float]:
    """Return root mean square errors [%] of speeds: of the fitted gaits, of the other four, and of all."""

    def rms_of(names: Sequence[str]) -> float:
        return 100 * float(
            np.sqrt(np.mean([(speeds[name] / published_value(f"speed/{name}") - 1) ** 2 for name in names]))
        )

    return {part: rms_of(names) for part, names in PARTS.items()}


CHAPTER = Chapter("strips", sections, findings, compute)
