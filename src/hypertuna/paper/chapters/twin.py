"""The twin beside the paper: the eight gaits from servo to wake, Fig. 8, power and range; no swimming data is used."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.battery import range_of
from hypertuna.description.robot import Robot
from hypertuna.paper.computed import SPEEDS, SWIM, TANK_PHASE, WISHES, Twins, bandwidths
from hypertuna.paper.ledger import Finding
from hypertuna.reports.html import WIDTH, Part, Picture, Section, Table
from hypertuna.reports.results import posture_table, spelled_limits
from hypertuna.simulation.posture_test import CLOSE, Held, PostureTest
from hypertuna.simulation.run import TwinRun

__all__ = ["EASED", "TWIN", "bore_table", "findings", "sections", "speed_table", "tank_table"]

Array = NDArray[np.float64]

TWIN = "twin"
EASED = "twin, angle within reach"  # where the set angle of Fig. 8 is not
COSTS = WISHES[:3]
ESTIMATED = "servos as data sheets have them, not fitted to this number, but chosen with it in sight"


def findings(twins: Twins, paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield what the twin answers: speeds, costs, powers, range, settling.

    Parameters
    ----------
    twins : Twins
    paper : mapping

    Yields
    ------
    Finding
    """
    runs = twins.gaits
    for name in SPEEDS:
        yield Finding(f"speed/{name}", TWIN, runs[name].speed, _reached(runs[name]))
    gain = 100 * (runs["optimised-max"].speed / runs["unoptimised-max"].speed - 1)
    yield Finding("speed/change-max", TWIN, gain, "optimised against unoptimised")
    for wish in COSTS:
        before, after = (runs[f"{kind}optimised-{wish}"].cost_of_transport for kind in ("un", ""))
        note = f"electrical: {before:.3g} to {after:.3g} J/(kg m)"
        yield Finding(f"cost-of-transport/change-{wish}", TWIN, 100 * (after / before - 1), note)
    yield from _powers(twins, paper)
    for one in twins.posture.held:
        yield _settling(one, TWIN)
    for one in twins.posture.eased:
        yield _settling(one, EASED)


def _powers(twins: Twins, paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield powers, the cost of transport of the fastest gait, and the range that follows."""
    fastest, lake = twins.gaits["unoptimised-max"], twins.gaits[paper["lake"]["gait"]]
    least = min(twins.gaits, key=lambda name: twins.gaits[name].cost_of_transport)
    yield Finding("power/fastest", TWIN, fastest.power, f"electrical power of all servos; {ESTIMATED}")
    yield Finding("power/lake", TWIN, lake.power, f"{paper['lake']['gait']} in still water; {ESTIMATED}")
    note = (
        f"electrical, {fastest.power:.3g} W at {fastest.speed:.3g} m/s; least of the eight gaits: "
        f"{twins.gaits[least].cost_of_transport:.3g} J/(kg m), {least}"
    )
    yield Finding("cost-of-transport/minimum", TWIN, fastest.cost_of_transport, note)
    yield _range(twins.robot, fastest)


def _range(robot: Robot, run: TwinRun) -> Finding:
    """Say how far the twin swims on one charge with its fastest unoptimized gait."""
    if not (math.isfinite(run.power + run.speed) and run.speed > 0):
        return Finding("range/battery", TWIN, None, "the twin does not swim")
    far = range_of(robot, power=run.power, speed=run.speed)
    note = (
        f"unoptimised-max on {far.energy / 3600:.1f} Wh, of which {far.given / 3600:.1f} Wh reach the servos: "
        f"{far.endurance / 3600:.2g} h at {run.power:.3g} W and {run.speed:.3g} m/s"
    )
    return Finding("range/battery", TWIN, far.range / 1e3, note)


def sections(twins: Twins, paper: Mapping[str, Any]) -> list[Section]:
    """Show what the twin does beside the paper.

    Parameters
    ----------
    twins : Twins
    paper : mapping

    Returns
    -------
    list of Section
    """
    return [_swim_section(twins, paper), _posture_section(twins)]


def speed_table(twins: Twins, paper: Mapping[str, Any]) -> Table:
    """Tabulate the eight speeds, with what joints, pressures and servos did.

    Parameters
    ----------
    twins : Twins
    paper : mapping

    Returns
    -------
    Table
    """
    rows: list[list[str | float]] = []
    for name in SPEEDS:
        run, told = twins.gaits[name], paper["values"][f"speed/{name}"]["value"]
        angles = ", ".join(f"{angle:.1f}" for angle in np.degrees(run.swing))
        wished = ", ".join(f"{angle:.4g}" for angle in np.degrees(run.gait.amplitude))
        cells: list[str | float] = [name, f"{run.gait.frequency:g}", wished, angles, f"{told:g}", f"{run.speed:.3f}"]
        cells += [f"{100 * (run.speed / told - 1):+.1f} %", f"{run.power:.1f}", f"{run.cost_of_transport:.1f}"]
        rows.append(cells)
    columns = ["gait", "f [Hz]", "set [deg]", "reached [deg]", "published [m/s]", "twin [m/s]", "error", "power [W]"]
    return Table(
        [*columns, "cost [J/(kg m)]"],
        rows,
        "The eight gaits of Table IV in the twin: half of what each joint swings from left to right, speed, and the "
        "electrical power of the servos.",
        f"Runs of {SWIM:g} s; means over the last whole beats. No swimming data is used beyond Table III.",
    )


def tank_table(twins: Twins) -> Table:
    """Tabulate amplitudes over frequency beside those of the identified bandwidth.

    Parameters
    ----------
    twins : Twins

    Returns
    -------
    Table
    """
    groups = twins.robot.joints
    rows: list[list[str | float]] = []
    for run in twins.tank:
        row: list[str | float] = [f"{run.gait.frequency:g} Hz"]
        for group, wished, made in zip(groups, run.gait.amplitude, run.amplitude, strict=True):
            lag = 1 / np.sqrt(1 + (run.gait.frequency / group.bandwidth) ** 2) if group.bandwidth else np.nan
            row += [f"{np.degrees(made):.1f}", f"{np.degrees(wished * lag):.1f}"]
        rows.append([*row, f"{run.speed:.3f}", f"{run.cost_of_transport:.1f}", spelled_limits(run.limits)])
    heads = [f"{group.name}: {what} [deg]" for group in groups for what in ("twin", "lag")]
    both = " and ".join(f"{angle:g}" for angle in np.degrees(twins.tank[0].gait.amplitude).round(9))
    return Table(
        ["frequency", *heads, "speed [m/s]", "cost [J/(kg m)]", "limits that acted"],
        rows,
        f"Amplitude of the first harmonic of each joint where {both} deg are set, in the twin, and in a first-order "
        f"lag of {bandwidths(twins.robot)} Hz that was identified from speeds.",
        f"Runs of {SWIM:g} s in water at a phase difference of {TANK_PHASE:g} deg.",
    )


def bore_table(bores: Mapping[float, Mapping[str, tuple[float, Array, float]]], paper: Mapping[str, Any]) -> Table:
    """Tabulate what the bore of the oil lines does to the eight speeds.

    Parameters
    ----------
    bores : mapping
        As `Twins` holds it.
    paper : mapping

    Returns
    -------
    Table
    """
    rows: list[list[str | float]] = []
    for bore, gaits in bores.items():
        errors = {name: gaits[name][0] / paper["values"][f"speed/{name}"]["value"] - 1 for name in SPEEDS}
        rms = 100 * math.sqrt(sum(error**2 for error in errors.values()) / len(errors))
        _, swing, power = gaits["unoptimised-max"]
        angles = ", ".join(f"{angle:.1f}" for angle in np.degrees(swing))
        told = [f"{100 * error:+.0f} %" for error in errors.values()]
        rows.append([f"{1e3 * bore:g} mm", f"{rms:.1f} %", *told, angles, f"{power:.1f}"])
    return Table(
        ["bore", "rms error", *SPEEDS, "reached at 6 Hz [deg]", "power at 6 Hz [W]"],
        rows,
        "Errors of the eight speeds with oil lines of other bores, and what the joints reach and the servos take with "
        "the fastest unoptimized gait.",
        f"Runs of {SWIM:g} s, everything else as described.",
    )


def _reached(run: TwinRun) -> str:
    """Say what amplitudes a run reached, and what kept it from more."""
    angles = " and ".join(f"{angle:.1f}" for angle in np.degrees(run.swing))
    wished = " and ".join(f"{angle:.4g}" for angle in np.degrees(run.gait.amplitude))
    limits = f"; limits that acted: {spelled_limits(run.limits)}" if run.limits else ""
    return f"joints reach {angles} of {wished} deg{limits}"


def _settling(one: Held, model: str) -> Finding:
    """Say when the peak bends of a joint have settled; the end of the run stands for never."""
    note = (
        f"joint {one.name} in air, {np.degrees(one.angle):.3g} deg set, all peak bends within {np.degrees(CLOSE):g} deg"
    )
    if one.limits:
        note += f"; limits that acted: {spelled_limits(one.limits)}"
    if one.settling is None:
        note += f"; not settled by then, but {np.degrees(one.error[-1]):.2f} deg off"
    elif one.measured_settling is not None:
        note += f"; by the bending sensor {one.measured_settling:.2f} s"
    note += "; the bore of the oil lines was chosen with this test in sight"
    at = float(one.time[-1]) if one.settling is None else one.settling
    return Finding(f"control/settling-{one.frequency:g}hz", model, at, note)


def _swim_section(twins: Twins, paper: Mapping[str, Any]) -> Section:
    """Show the eight gaits, amplitudes over frequency, and the pressures behind them."""
    from hypertuna.simulation.plots import plot_limits, plot_pressures, plot_twin

    fastest, middle = twins.gaits["unoptimised-max"], twins.tank[len(twins.tank) // 2]
    limits = Picture(
        "twin-amplitude",
        plot_limits([run.gait.frequency for run in twins.tank], _ratios(twins), _bandwidth(twins.robot), width=WIDTH),
        "Amplitude that the joints reach of the one that is set, large amplitude in water, beside the first-order lag "
        "that was identified from swimming speeds.",
        f"The twin at {TANK_PHASE:g} deg of phase difference; first harmonic over the last whole beats.",
    )
    pressures = Picture(
        "twin-pressures",
        plot_pressures(middle, width=WIDTH),
        f"Pressures of one beat at {middle.gait.frequency:g} Hz, large amplitude, in the pumps and behind the oil "
        "lines in the drive units. Dotted: the controller's limit and cavitation.",
        f"The last of {SWIM:g} s of the twin.",
    )
    whole = Picture(
        "twin",
        plot_twin(fastest, width=WIDTH),
        "The fastest unoptimized gait in the twin: bend of both joints beside what is set, pressures, power, speed and "
        "path.",
        "Made as `hypertuna twin --robot hypertuna --gait unoptimised-max --start swimming --plot twin.svg` makes it.",
    )
    text = _swim_text(twins, paper)
    parts: list[Part] = [text, limits, pressures, whole, tank_table(twins), speed_table(twins, paper)]
    parts += [bore_table(twins.bores, paper)] if twins.bores else []
    return Section("From servo to wake: the twin", parts)


def _swim_text(twins: Twins, paper: Mapping[str, Any]) -> str:
    """Say what the twin is, and what it explains of the paper."""
    errors = {name: twins.gaits[name].speed / paper["values"][f"speed/{name}"]["value"] - 1 for name in SPEEDS}
    rms = float(np.sqrt(np.mean(np.square(list(errors.values())))))
    worst = max(errors, key=lambda name: abs(errors[name]))
    slow, fast, told = twins.tank[0], twins.tank[-1], paper["values"]
    fastest, lake = twins.gaits["unoptimised-max"], twins.gaits[paper["lake"]["gait"]]
    ratios = [
        f"{100 * run.amplitude[0] / run.gait.amplitude[0]:.0f} and "
        f"{100 * run.amplitude[1] / run.gait.amplitude[1]:.0f} %"
        for run in (slow, fast)
    ]
    hertz = [f"{run.gait.frequency:g} Hz" for run in (slow, fast)]
    lag = 100 / np.sqrt(1 + (fast.gait.frequency / _bandwidth(twins.robot)) ** 2)
    return f"""Here nothing is told about how the joints move. The controller on board commands the servos, the servos
turn cranks, pistons push oil through thin lines into the drive units, and the tail bends against silicone and water.
Estimates stand for what the paper leaves out; the actuator's geometry and the bore of the oil lines were chosen with
its bench tests in sight. Of the swimming tests only the water's coefficients of Table III are used.

**The eight speeds come out with {100 * rms:.1f} % rms error**, the largest {100 * errors[worst]:+.1f} % ({worst}). At
{hertz[0]} the joints reach {ratios[0]} of large amplitude, at {hertz[1]} {ratios[1]}; the lag of
{bandwidths(twins.robot)} Hz that was identified from speeds leaves {lag:.0f} % there. {_held_back(fast)}

The servos take {fastest.power:.3g} W in the fastest unoptimized gait, where {told["power/fastest"]["value"]:g} W were
measured, and {lake.power:.3g} W with the gait of the lake run, where it was {told["power/lake"]["value"]:g} W. Servos
are as data sheets have them: not fitted to these numbers, but chosen with them in sight. {_cheapest(twins)}"""


def _held_back(run: TwinRun) -> str:
    """Say what keeps the joints from the set amplitude."""
    if not run.limits:
        return "No limit acts."
    return f"Limits that act: {spelled_limits(run.limits)}."


def _cheapest(twins: Twins) -> str:
    """Say how cost of transport goes with the frequency, where the paper finds it to fall all the way."""
    costs = {run.gait.frequency: run.cost_of_transport for run in twins.tank}
    least, last = min(costs, key=lambda hertz: costs[hertz]), max(costs)
    fall = f"Cost of transport falls from {costs[min(costs)]:.3g} J/(kg m) at {min(costs):g} Hz to {costs[least]:.3g}"
    if least == last:
        return f"{fall} at {last:g} Hz, as the paper finds."
    rise = f"and rises to {costs[last]:.3g} at {last:g} Hz"
    return f"{fall} at {least:g} Hz {rise}; the paper finds that it falls all the way."


def _posture_section(twins: Twins) -> Section:
    """Show Fig. 8 and what limits the joints."""
    from hypertuna.simulation.plots import plot_posture

    test = twins.posture
    name, degrees = test.held[0].name, np.degrees(test.held[0].angle)
    picture = Picture(
        "fig8",
        plot_posture(test, width=WIDTH),
        f"Fig. 8: bend of joint {name} from rest to {degrees:g} deg at one frequency; error of its peak bends, beat by "
        "beat, at all of them; and the largest amplitude that it holds.",
        "Made as `hypertuna posture-test --robot hypertuna --plot fig8.svg` makes it: in air, by the true bend.",
    )
    held = [one for one in test.held if one.settling is not None]
    count = f"{len(held)} of {len(test.held)}" if len(held) < len(test.held) else "all"
    text = f"""Fig. 8 of the paper shows a joint that is told to beat by {degrees:g} deg to both sides: its angle
converges within 4 s at all drive frequencies, and faster at higher ones. Which joint it is, is not said; joint I cannot
bend so far. In the twin the peak bends of joint {name} come within {np.degrees(CLOSE):g} deg and stay there at {count}
frequencies{_slowest(held)}.{_beyond(test)}"""
    return Section("Posture control, Fig. 8", [picture, text, posture_table(test)])


def _slowest(held: Sequence[Held]) -> str:
    """Say after what time the last of some has settled."""
    times = [one.settling for one in held if one.settling is not None]
    return f", after {max(times):.2g} s at most" if times else ""


def _beyond(test: PostureTest) -> str:
    """Say what stops the joint where the set angle is out of reach, and how it does within reach."""
    if not test.eased:
        return ""
    hertz = " and ".join(f"{one.frequency:g} Hz" for one in test.eased)
    first = {one.limits[0].replace("_", " ") for one in test.held if one.settling is None and one.limits}
    angles = " and ".join(f"{np.degrees(one.angle):.3g}" for one in test.eased)
    settled = [one for one in test.eased if one.settling is not None]
    count = "it settles there" if len(settled) == len(test.eased) else f"it settles at {len(settled)} of them"
    return f"""

At {hertz} it does not come so far: the {" and the ".join(sorted(first))} stops it, the status says so, and the
integrator does not wind up. Told what it can reach, {angles} deg, {count}{_slowest(settled)}. Wider oil lines move that
border, and their bore is not published."""


def _ratios(twins: Twins) -> dict[str, Array]:
    """Amplitude reached over set, by joint, over frequency."""
    return {
        f"joint {group.name}": np.array([run.amplitude[j] / run.gait.amplitude[j] for run in twins.tank])
        for j, group in enumerate(twins.robot.joints)
    }


def _bandwidth(robot: Robot) -> float:
    """Bandwidth of the joints [Hz], one for all."""
    (value,) = {group.bandwidth for group in robot.joints}
    assert value is not None  # identified from the paper's speeds
    return value
