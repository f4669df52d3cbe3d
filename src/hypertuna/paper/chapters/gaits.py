"""The eight gaits of Table IV: speeds, costs of transport, range on the battery."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.metrics import cost_of_transport
from hypertuna.paper.computed import OURS, PAPER, SPEEDS, WISHES, Trial, bandwidths
from hypertuna.paper.ledger import Finding, judge
from hypertuna.reports.html import WIDTH, Picture, Section
from hypertuna.swimming.swim import Swim

__all__ = ["ARITHMETIC", "findings", "range_finding", "range_section", "sections"]

ARITHMETIC = "the paper's own numbers"
COSTS = WISHES[:3]  # wishes whose costs of transport the paper compares


def findings(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield what the models answer: speeds, changes by optimization; and what the paper's own numbers do.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping

    Yields
    ------
    Finding
    """
    for model, trial in trials.items():
        gaits = trial.gaits
        for name in SPEEDS:
            yield Finding(f"speed/{name}", model, gaits[name].speed, _settled_note(gaits[name]))
        gain = _change(gaits["unoptimised-max"].speed, gaits["optimised-max"].speed)
        yield Finding("speed/change-max", model, gain, "optimised against unoptimised")
        for wish in COSTS:
            before, after = (gaits[f"{kind}optimised-{wish}"] for kind in ("un", ""))
            change = _change(before.cost_of_transport, after.cost_of_transport)
            note = f"mechanical: {before.cost_of_transport:.3g} to {after.cost_of_transport:.3g} J/(kg m)"
            yield Finding(f"cost-of-transport/change-{wish}", model, change, note)
    yield _largest_error(trials[PAPER], paper)
    yield _largest_cost_error(trials[PAPER], paper)
    yield range_finding(trials[PAPER].robot, paper)


def sections(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> list[Section]:
    """Show the eight gaits, and how the fastest one swims.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping

    Returns
    -------
    list of Section
    """
    from hypertuna.swimming.plots import plot_ledger, plot_swim

    truth = [paper["values"][f"speed/{name}"]["value"] for name in SPEEDS]
    computed = {model: [trials[model].gaits[name].speed for name in SPEEDS] for model in (PAPER, OURS)}
    held = {model: sum(_holds(name, trials[model], paper) for name in SPEEDS) for model in computed}
    gaits = trials[OURS].gaits
    hertz = bandwidths(trials[OURS].robot)
    names = [_short(name, gaits[name]) for name in SPEEDS]
    speeds = Picture(
        "speeds",
        plot_ledger(names, truth, computed, width=WIDTH),
        "Speed of the eight gaits of Table IV: as first swum, and as improved by the authors' optimizer; each line "
        "says frequency and phase difference.",
        "Settled beats with the coefficients of Table III unchanged; published speeds from Table IV and section III.D.",
    )
    changes = "; ".join(_cost_change(wish, trials[OURS], paper) for wish in COSTS)
    text = f"""The paper's own model, with joints that follow their command exactly, gives {held[PAPER]} of the eight
speeds. The error grows with frequency: no choice of coefficients mends that, because with inertia and quadratic drag
alone the distance swum per beat does not depend on frequency.

One more parameter mends it: joints that lag like a first-order filter of {hertz} Hz, as oil in thin lines makes them.
It was identified on the four unoptimized gaits; the four optimized ones are a test. With it, {held[OURS]} of the
eight speeds hold.

Cost of transport is harder. From the unoptimized to the optimized gaits it changes by {changes}."""
    best = gaits["unoptimised-max"]
    motion = Picture(
        "swim",
        plot_swim(best, width=WIDTH),
        "Paths, midlines, speed and power of the fastest unoptimized gait. The joints give power twice in a beat, "
        "and take a little back.",
        "Made by `hypertuna swim --robot hypertuna --gait unoptimised-max --plot swim.svg`.",
    )
    fast = f"""The fastest unoptimized gait: {best.speed:.3g} m/s, {best.speed_bl:.3g} body lengths per second, at
{best.power:.3g} W of mechanical power and a Strouhal number of {best.strouhal:.2g}. Every beat repeats the last one;
a disturbance shrinks to {100 * best.spectral_radius:.0f} % of itself in a beat."""
    return [Section("Eight gaits, and the fastest of them", [speeds, text, motion, fast])]


def range_section(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Section:
    """Tell of the range on one charge.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping

    Returns
    -------
    Section
    """
    found = range_finding(trials[PAPER].robot, paper)
    entry = judge(paper, found)
    text = f"**{entry.published:g} km is {entry.verdict} by the paper's own numbers**: they give {entry.answer} km."
    return Section("Range", [f"{text} {found.note}."])


def _largest_error(own: Trial, paper: Mapping[str, Any]) -> Finding:
    """Compare the largest error of the eight speeds with what the paper says of its validation set."""
    errors = [abs(own.gaits[name].speed / paper["values"][f"speed/{name}"]["value"] - 1) for name in SPEEDS]
    slow, fast = own.gaits["optimised-0.3"], own.gaits["optimised-max"]
    note = (
        "over the eight gaits, as the paper's validation set is not published. With inertia and quadratic drag alone, "
        f"stride length does not depend on frequency: {slow.stride_length:.3f} and {fast.stride_length:.3f} for nearly "
        f"the same gait at {slow.gait.frequency:g} and {fast.gait.frequency:g} Hz, where the published speeds give "
        f"{_stride('optimised-0.3', own, paper):.3f} and {_stride('optimised-max', own, paper):.3f}"
    )
    return Finding("speed/model-error-max", PAPER, 100 * max(errors), note)


def _largest_cost_error(own: Trial, paper: Mapping[str, Any]) -> Finding:
    """Compare costs of transport over those of the unoptimized gaits with what the paper says of its validation set."""
    changes = []
    for wish in COSTS:
        before, after = (own.gaits[f"{kind}optimised-{wish}"].cost_of_transport for kind in ("un", ""))
        changes.append((after / before) / (1 + paper["values"][f"cost-of-transport/change-{wish}"]["value"] / 100) - 1)
    note = (
        "over the optimized gaits, each normalized by its unoptimized one, as the paper's validation set is not "
        f"published: {', '.join(f'{100 * change:+.0f} %' for change in changes)} at {', '.join(COSTS)} m/s"
    )
    return Finding("cost-of-transport/model-error", PAPER, 100 * max(map(abs, changes)), note)


def _change(before: float, after: float) -> float:
    """Change in percent."""
    return 100 * (after / before - 1)


def _settled_note(done: Swim) -> str:
    """Warn of a gait that is not settled."""
    return "" if done.settled else done.status_text


def _stride(name: str, trial: Trial, paper: Mapping[str, Any]) -> float:
    """Stride length of a published speed."""
    speed = paper["values"][f"speed/{name}"]["value"]
    return float(speed / (trial.gaits[name].gait.frequency * trial.robot.body.length))


def range_finding(robot: Robot, paper: Mapping[str, Any]) -> Finding:
    """Compute the range on the battery of Table I at the published cost of transport.

    Parameters
    ----------
    robot : Robot
        With a battery.
    paper : mapping

    Returns
    -------
    Finding
        Its note has the arithmetic, that of the claim, and that of the lake run.
    """
    battery = robot.battery
    assert battery is not None  # the robot of the paper has one
    cost = paper["values"]["cost-of-transport/minimum"]["value"] * robot.body.mass  # J/m
    energy = battery.cells * battery.capacity * battery.voltage
    claimed = paper["values"]["range/battery"]["value"] * 1e3 * cost
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
    return Finding("range/battery", ARITHMETIC, energy / cost / 1e3, note)


def _holds(name: str, trial: Trial, paper: Mapping[str, Any]) -> bool:
    """Tell whether a speed counts as reproduced."""
    return judge(paper, Finding(f"speed/{name}", "", trial.gaits[name].speed)).verdict == "reproduced"


def _cost_change(wish: str, trial: Trial, paper: Mapping[str, Any]) -> str:
    """Say how cost of transport changes by optimization, computed and published."""
    before, after = (trial.gaits[f"{kind}optimised-{wish}"].cost_of_transport for kind in ("un", ""))
    told = paper["values"][f"cost-of-transport/change-{wish}"]["value"]
    return f"{_change(before, after):+.1f} % at {wish} m/s, where {told:+g} % is published"


def _short(name: str, done: Swim) -> str:
    """Name a gait on one line."""
    kind, speed = name.split("-")
    return f"{kind} {speed}: {done.gait.frequency:.3g} Hz, {np.degrees(done.gait.phase[-1]):.0f}°"
