"""The twin beside the paper: the eight gaits from servo to wake, Fig. 8, power and range; no swimming data is used."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from hypertuna.actuation.battery import range_of
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.paper.chapter import Chapter, Trials, prose
from hypertuna.paper.computed import (
    COSTS,
    OURS,
    SPEEDS,
    SWIM,
    TANK_PHASE,
    TWIN,
    Bores,
    Twins,
    bandwidths,
    run_published,
)
from hypertuna.paper.ledger import Finding, published, published_value
from hypertuna.reports.html import WIDTH, Part, Picture, Section, Table
from hypertuna.reports.results import posture_table, spelled_limits
from hypertuna.simulation.posture_test import CLOSE, Held
from hypertuna.simulation.run import TwinRun

EASED = "twin, angle within reach"  # where the set angle of Fig. 8 is out of reach
ESTIMATED = "servos as data sheets have them, not fitted to this number, but chosen with it in sight"


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Twins:
    """Run the twin of the paper's robot."""
    return run_published(trials[OURS].robot, published(), full=full, progress=step)


def findings(twins: Twins) -> Iterator[Finding]:
    """Yield speeds, costs, powers, range and settling times."""
    runs = twins.gaits
    for name in SPEEDS:
        yield Finding(f"speed/{name}", TWIN, runs[name].speed, _reached(runs[name]))
    gain = 100 * (runs["optimised-max"].speed / runs["unoptimised-max"].speed - 1)
    yield Finding("speed/change-max", TWIN, gain, "optimised against unoptimised")
    for speed in COSTS:
        before, after = (runs[f"{kind}optimised-{speed}"].cost_of_transport for kind in ("un", ""))
        note = f"electrical: {before:.3g} to {after:.3g} J/(kg m)"
        yield Finding(f"cost-of-transport/change-{speed}", TWIN, 100 * (after / before - 1), note)
    yield from _powers(twins)
    for held in twins.posture.held:
        yield _settling(held, TWIN)
    for held in twins.posture.eased:
        yield _settling(held, EASED)


def sections(twins: Twins) -> list[Section]:
    """Show the twin beside the paper."""
    return [_swim_section(twins), _posture_section(twins)]


def speed_table(twins: Twins) -> Table:
    """Tabulate the eight speeds, with amplitudes and power."""
    rows: list[list[str | float]] = []
    for name in SPEEDS:
        run, value = twins.gaits[name], published_value(f"speed/{name}")
        reached = ", ".join(f"{angle:.1f}" for angle in np.degrees(run.swing))
        setpoints = ", ".join(f"{angle:.4g}" for angle in np.degrees(run.gait.amplitude))
        cells = [name, f"{run.gait.frequency:g}", setpoints, reached, f"{value:g}", f"{run.speed:.3f}"]
        error = f"{100 * (run.speed / value - 1):+.1f} %"
        rows.append([*cells, error, f"{run.power:.1f}", f"{run.cost_of_transport:.1f}"])
    columns = ["gait", "f [Hz]", "set [deg]", "reached [deg]", "published [m/s]", "twin [m/s]", "error", "power [W]"]
    return Table(
        [*columns, "cost [J/(kg m)]"],
        rows,
        "The eight gaits of Table IV in the twin: half of the swing of each joint from left to right, speed, and the "
        "electrical power of the servos.",
        f"Runs of {SWIM:g} s; means over the last whole beats. No swimming data is used beyond Table III.",
    )


def tank_table(twins: Twins) -> Table:
    """Tabulate amplitudes over frequency beside those of the identified bandwidth."""
    groups = twins.robot.joints
    rows: list[list[str | float]] = []
    for run in twins.tank:
        row: list[str | float] = [f"{run.gait.frequency:g} Hz"]
        for group, setpoint, amplitude in zip(groups, run.gait.amplitude, run.amplitude, strict=True):
            lag = 1 / np.sqrt(1 + (run.gait.frequency / group.bandwidth) ** 2) if group.bandwidth else np.nan
            row += [f"{np.degrees(amplitude):.1f}", f"{np.degrees(setpoint * lag):.1f}"]
        rows.append([*row, f"{run.speed:.3f}", f"{run.cost_of_transport:.1f}", spelled_limits(run.limits)])
    heads = [f"{group.name}: {what} [deg]" for group in groups for what in ("twin", "lag")]
    both = " and ".join(f"{angle:g}" for angle in np.degrees(twins.tank[0].gait.amplitude).round(9))
    return Table(
        ["frequency", *heads, "speed [m/s]", "cost [J/(kg m)]", "active limits"],
        rows,
        f"Amplitude of the first harmonic of each joint where {both} deg are set, in the twin, and with a first-order "
        f"lag of {bandwidths(twins.robot)} Hz that was identified from speeds.",
        f"Runs of {SWIM:g} s in water at a phase difference of {TANK_PHASE:g} deg.",
    )


def bore_table(bores: Bores) -> Table:
    """Tabulate the effect of the bore of the oil lines on the eight speeds."""
    rows: list[list[str | float]] = []
    for bore, gaits in bores.items():
        errors = [gaits[name][0] / published_value(f"speed/{name}") - 1 for name in SPEEDS]
        rms = 100 * math.sqrt(sum(error**2 for error in errors) / len(errors))
        _, swing, power = gaits["unoptimised-max"]
        angles = ", ".join(f"{angle:.1f}" for angle in np.degrees(swing))
        cells = [f"{100 * error:+.0f} %" for error in errors]
        rows.append([f"{1e3 * bore:g} mm", f"{rms:.1f} %", *cells, angles, f"{power:.1f}"])
    return Table(
        ["bore", "rms error", *SPEEDS, "reached at 6 Hz [deg]", "power at 6 Hz [W]"],
        rows,
        "Errors of the eight speeds with oil lines of other bores, and amplitudes and power with the fastest "
        "unoptimized gait.",
        f"Runs of {SWIM:g} s, everything else as described.",
    )


def _powers(twins: Twins) -> Iterator[Finding]:
    """Yield powers, the cost of transport of the fastest gait, and the range that follows."""
    gait = published()["lake"]["gait"]
    fastest, lake = twins.gaits["unoptimised-max"], twins.gaits[gait]
    least = min(twins.gaits, key=lambda name: twins.gaits[name].cost_of_transport)
    yield Finding("power/fastest", TWIN, fastest.power, f"electrical power of all servos; {ESTIMATED}")
    yield Finding("power/lake", TWIN, lake.power, f"{gait} in still water; {ESTIMATED}")
    note = (
        f"electrical, {fastest.power:.3g} W at {fastest.speed:.3g} m/s; least of the eight gaits: "
        f"{twins.gaits[least].cost_of_transport:.3g} J/(kg m), {least}"
    )
    yield Finding("cost-of-transport/minimum", TWIN, fastest.cost_of_transport, note)
    yield _range(twins.robot, fastest)


def _range(robot: Robot, run: TwinRun) -> Finding:
    """Return the range on one charge with the fastest unoptimized gait."""
    if not (math.isfinite(run.power + run.speed) and run.speed > 0):
        return Finding("range/battery", TWIN, None, "the twin does not swim")
    result = range_of(robot, power=run.power, speed=run.speed)
    note = (
        f"unoptimised-max on {result.energy / 3600:.1f} Wh, {result.delivered / 3600:.1f} Wh of them at the servos: "
        f"{result.endurance / 3600:.2g} h at {run.power:.3g} W and {run.speed:.3g} m/s"
    )
    return Finding("range/battery", TWIN, result.range / 1e3, note)


def _reached(run: TwinRun) -> str:
    """Describe the amplitudes that a run reached, and the active limits."""
    angles = " and ".join(f"{angle:.1f}" for angle in np.degrees(run.swing))
    setpoints = " and ".join(f"{angle:.4g}" for angle in np.degrees(run.gait.amplitude))
    limits = f"; active limits: {spelled_limits(run.limits)}" if run.limits else ""
    return f"joints reach {angles} of {setpoints} deg{limits}"


def _settling(held: Held, model: str) -> Finding:
    """Return the settling time of a joint's peak bends; the end of the run where they do not settle."""
    angle, close = np.degrees(held.angle), np.degrees(CLOSE)
    note = f"joint {held.name} in air, {angle:.3g} deg set, all peak bends within {close:g} deg"
    if held.limits:
        note += f"; active limits: {spelled_limits(held.limits)}"
    if held.settling is None:
        note += f"; not settled by then, but {np.degrees(held.error[-1]):.2f} deg off"
    elif held.measured_settling is not None:
        note += f"; by the bending sensor {held.measured_settling:.2f} s"
    note += "; the bore of the oil lines was chosen with this test in sight"
    time = float(held.time[-1]) if held.settling is None else held.settling
    return Finding(f"control/settling-{held.frequency:g}hz", model, time, note)


def _swim_section(twins: Twins) -> Section:
    """Show the eight gaits, amplitudes over frequency, and the pressures behind them."""
    from hypertuna.simulation.plots import plot_limits, plot_pressures, plot_twin

    middle = twins.tank[len(twins.tank) // 2]
    limits = Picture(
        "twin-amplitude",
        plot_limits([run.gait.frequency for run in twins.tank], _ratios(twins), _bandwidth(twins.robot), width=WIDTH),
        "Amplitude that the joints reach over the one that is set, large amplitude in water, beside the first-order "
        "lag that was identified from swimming speeds.",
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
        plot_twin(twins.gaits["unoptimised-max"], width=WIDTH),
        "The fastest unoptimized gait in the twin: bend of both joints beside its setpoint, pressures, power, speed "
        "and path.",
        "Made as by `hypertuna twin --robot hypertuna --gait unoptimised-max --start swimming --plot twin.svg`.",
    )
    parts: list[Part] = [_swim_text(twins), limits, pressures, whole, tank_table(twins), speed_table(twins)]
    parts += [bore_table(twins.bores)] if twins.bores else []
    return Section("From servo to wake: the twin", parts)


def _swim_text(twins: Twins) -> str:
    """Describe the twin, and what it explains of the paper."""
    errors = {name: twins.gaits[name].speed / published_value(f"speed/{name}") - 1 for name in SPEEDS}
    slow, fast = twins.tank[0], twins.tank[-1]
    costs = {run.gait.frequency: run.cost_of_transport for run in twins.tank}

    def reached(run: TwinRun) -> str:
        one, two = (100 * run.amplitude[j] / run.gait.amplitude[j] for j in (0, 1))
        return f"{one:.0f} and {two:.0f} %"

    return prose(
        "twin",
        errors=errors,
        rms=float(np.sqrt(np.mean(np.square(list(errors.values()))))),
        worst=max(errors, key=lambda name: abs(errors[name])),
        slow=slow,
        fast=fast,
        reached=reached,
        bandwidth=bandwidths(twins.robot),
        lag=100 / np.sqrt(1 + (fast.gait.frequency / _bandwidth(twins.robot)) ** 2),
        limits=spelled_limits(fast.limits) if fast.limits else "",
        fastest=twins.gaits["unoptimised-max"],
        lake=twins.gaits[published()["lake"]["gait"]],
        measured=published_value("power/fastest"),
        measured_lake=published_value("power/lake"),
        costs=costs,
        first=min(costs),
        last=max(costs),
        least=min(costs, key=lambda hertz: costs[hertz]),
    )


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
        "Made as by `hypertuna posture-test --robot hypertuna --plot fig8.svg`: in air, by the true bend.",
    )
    text = prose(
        "posture",
        joint=name,
        degrees=degrees,
        close=np.degrees(CLOSE),
        count=len(test.held),
        settled=[held.settling for held in test.held if held.settling is not None],
        eased=test.eased,
        hertz=" and ".join(f"{held.frequency:g} Hz" for held in test.eased),
        stops=sorted({held.limits[0].replace("_", " ") for held in test.held if held.settling is None and held.limits}),
        angles=" and ".join(f"{np.degrees(held.angle):.3g}" for held in test.eased),
        times=[held.settling for held in test.eased if held.settling is not None],
    )
    return Section("Posture control, Fig. 8", [picture, text, posture_table(test)])


def _ratios(twins: Twins) -> dict[str, Array]:
    """Return amplitude reached over set, by joint, over frequency [1]."""
    return {
        f"joint {group.name}": np.array([run.amplitude[j] / run.gait.amplitude[j] for run in twins.tank])
        for j, group in enumerate(twins.robot.joints)
    }


def _bandwidth(robot: Robot) -> float:
    """Return the bandwidth of the joints, one for all [Hz]."""
    (value,) = {group.bandwidth for group in robot.joints}
    assert value is not None  # identified from the paper's speeds
    return value


CHAPTER = Chapter("twins", sections, findings, compute, steps=2, full_steps=2)
