"""The eight gaits of Table IV: speeds, costs of transport, range on the battery."""

from collections.abc import Iterator, Mapping

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.metrics import cost_of_transport
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.chapters.model_checks import start_finding
from hypertuna.paper.computed import COSTS, OURS, PAPER, SPEEDS, Trial, bandwidths
from hypertuna.paper.ledger import Class, Finding, judge, published, published_value
from hypertuna.reports.html import WIDTH, Section
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.swim import Swim

ARITHMETIC = "the paper's own numbers"
ALIKE = 0.1  # two gaits are the same swim if all their numbers differ by at most this fraction


def findings(trials: Trials) -> Iterator[Finding]:
    """Yield speeds and changes by optimization of each model, the largest errors of the paper's, and the range."""
    for model, trial in trials.items():
        notes = {name: "" if swim.settled else swim.status_text for name, swim in trial.gaits.items()}
        yield from gait_findings(model, trial.gaits, notes)
        yield start_finding(model, trial)
    yield _largest_error(trials[PAPER])
    yield _largest_cost_error(trials[PAPER])
    yield range_finding(trials[PAPER].robot)


def gait_findings(model: str, gaits: Mapping[str, Swim], notes: Mapping[str, str]) -> Iterator[Finding]:
    """Yield the eight speeds of a water law, and the changes of speed and of mechanical costs by optimization."""
    classes = speed_classes({name: gaits[name].gait for name in SPEEDS})
    for name in SPEEDS:
        yield Finding(f"speed/{name}", model, classes[name], gaits[name].speed, notes[name])
    gain = change(gaits["unoptimised-max"].speed, gaits["optimised-max"].speed)
    yield Finding("speed/change-max", model, "prediction", gain, "optimised against unoptimised")
    for speed in COSTS:
        before, after = _costs(gaits, speed)
        note = f"mechanical: {before:.3g} to {after:.3g} J/(kg m)"
        yield Finding(f"cost-of-transport/change-{speed}", model, "prediction", change(before, after), note)


def speed_classes(gaits: Mapping[str, Gait]) -> dict[str, Class]:
    """Return the class of each of the eight speeds: "fitted" for the four gaits of the identification, or "prediction".

    A gait that is almost a fitted one is fitted too: its speed follows.
    """
    fitted = [_numbers(gaits[name]) for name in SPEEDS if name.startswith("unoptimised")]
    close = {name: np.isclose(_numbers(gaits[name]), fitted, rtol=ALIKE, atol=0.0).all(axis=1).any() for name in SPEEDS}
    return {name: "fitted" if close[name] else "prediction" for name in SPEEDS}


def _numbers(gait: Gait) -> tuple[float, ...]:
    """Return the numbers of a gait in Table IV: frequency [Hz], amplitudes and phase difference [rad]."""
    return (gait.frequency, *gait.amplitude, gait.phase[1] - gait.phase[0])


def sections(trials: Trials) -> list[Section]:
    """Show the eight gaits, and how the fastest one swims."""
    from hypertuna.swimming.plots import plot_ledger, plot_swim

    gaits, best = trials[OURS].gaits, trials[OURS].gaits["unoptimised-max"]
    computed = {model: [trials[model].gaits[name].speed for name in SPEEDS] for model in (PAPER, OURS)}
    labels, speeds = (
        [_label(name, gaits[name]) for name in SPEEDS],
        [published_value(f"speed/{name}") for name in SPEEDS],
    )
    return compose(
        "gaits",
        {"speeds": plot_ledger(labels, speeds, computed, width=WIDTH), "swim": plot_swim(best, width=WIDTH)},
        ideal=_within(trials[PAPER]),
        lagging=_within(trials[OURS]),
        bandwidth=bandwidths(trials[OURS].robot),
        changes="; ".join(_cost_change(speed, trials[OURS]) for speed in COSTS),
        best=best,
    )


def range_sections(trials: Trials) -> list[Section]:
    """Show the range on one charge."""
    return compose("range", {}, entry=judge(published(), range_finding(trials[PAPER].robot)))


def range_finding(robot: Robot) -> Finding:
    """Return the finding on a robot's range with the battery of Table I at the published cost of transport.

    The note has the arithmetic, that of the claim, and that of the lake run.
    """
    battery, paper = robot.battery, published()
    assert battery is not None  # the robot of the paper has one
    cost = published_value("cost-of-transport/minimum") * robot.body.mass  # J/m
    energy = battery.cells * battery.capacity * battery.voltage
    claimed = published_value("range/battery") * 1e3 * cost
    charge, cell = paper["range"]["battery_ah"], paper["range"]["charged_cell_v"]
    lake = paper["lake"]["energy_wh"] * 3600 / paper["lake"]["distance_m"]
    lake_cost = float(cost_of_transport(lake, robot.body.mass, 1.0))
    note = (
        f"{battery.cells} cells x {battery.capacity / 3600:g} Ah x {battery.voltage:g} V = {energy / 3600:.1f} Wh, "
        f"over {cost / robot.body.mass:g} J/(kg m) x {robot.body.mass:g} kg. The claim needs {claimed / 3600:.0f} Wh: "
        f"{charge:g} Ah x {claimed / 3600 / charge:.1f} V, with all {battery.cells} cells in parallel "
        f"({battery.cells} x {charge / battery.cells:g} Ah) and in series ({battery.cells} x {cell:g} V) at once. "
        f"The lake run, {paper['lake']['energy_wh']:g} Wh for {paper['lake']['distance_m']:g} m or "
        f"{lake_cost:.1f} J/(kg m), gives {energy / lake / 1e3:.2g} km"
    )
    return Finding("range/battery", ARITHMETIC, "input", energy / cost / 1e3, note)


def _largest_error(trial: Trial) -> Finding:
    """Return the largest relative error of the eight speeds, beside the paper's for its validation set."""
    errors = [abs(trial.gaits[name].speed / published_value(f"speed/{name}") - 1) for name in SPEEDS]
    slow, fast = trial.gaits["optimised-0.3"], trial.gaits["optimised-max"]
    note = (
        "over the eight gaits, as the paper's validation set is not published. With inertia and quadratic drag alone, "
        f"stride length does not depend on frequency: {slow.stride_length:.3f} and {fast.stride_length:.3f} for nearly "
        f"the same gait at {slow.gait.frequency:g} and {fast.gait.frequency:g} Hz, where the published speeds give "
        f"{_published_stride('optimised-0.3', trial):.3f} and {_published_stride('optimised-max', trial):.3f}"
    )
    return Finding("speed/model-error-max", PAPER, "not judged", 100 * max(errors), note)


def _largest_cost_error(trial: Trial) -> Finding:
    """Return the largest error of optimized over unoptimized costs, beside the paper's for its validation set."""
    changes = []
    for speed in COSTS:
        before, after = _costs(trial.gaits, speed)
        changes.append((after / before) / (1 + published_value(f"cost-of-transport/change-{speed}") / 100) - 1)
    note = (
        "over the optimized gaits, each normalized by its unoptimized one, as the paper's validation set is not "
        f"published: {', '.join(f'{100 * change:+.0f} %' for change in changes)} at {', '.join(COSTS)} m/s"
    )
    return Finding("cost-of-transport/model-error", PAPER, "not judged", 100 * max(map(abs, changes)), note)


def change(before: float, after: float) -> float:
    """Return the change between two values in percent of the first."""
    return 100 * (after / before - 1)


def _costs(gaits: Mapping[str, Swim], speed: str) -> tuple[float, float]:
    """Return costs of transport [J/(kg m)] of the unoptimized and the optimized gait for a speed."""
    before, after = (gaits[f"{kind}optimised-{speed}"].cost_of_transport for kind in ("un", ""))
    return before, after


def _published_stride(name: str, trial: Trial) -> float:
    """Return the stride length [body lengths per beat] of a published speed."""
    return float(published_value(f"speed/{name}") / (trial.gaits[name].gait.frequency * trial.robot.body.length))


def _within(trial: Trial) -> int:
    """Return how many of the eight speeds are within the tolerance of the published ones."""
    speeds = [Finding(f"speed/{name}", "", "fitted", trial.gaits[name].speed) for name in SPEEDS]
    return sum(judge(published(), one).verdict == "agrees" for one in speeds)


def _cost_change(speed: str, trial: Trial) -> str:
    """Describe the change of cost of transport by optimization, computed and published."""
    value = published_value(f"cost-of-transport/change-{speed}")
    return f"{change(*_costs(trial.gaits, speed)):+.1f} % at {speed} m/s, where {value:+g} % is published"


def _label(name: str, result: Swim) -> str:
    """Return the label in a plot of a gait by name."""
    kind, speed = name.split("-")
    return f"{kind} {speed}: {result.gait.frequency:.3g} Hz, {np.degrees(result.gait.phase[-1]):.0f}°"


CHAPTER = Chapter("gaits", sections, findings)
RANGE = Chapter("range", range_sections)
