"""The twin beside the paper: the eight gaits from servo to wake, Fig. 8, power and range; no swimming data is used."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from hypertuna.actuation.sizing import size_pump
from hypertuna.description.robot import Robot
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import (
    OURS,
    SPEEDS,
    SWIM,
    TANK,
    TANK_PHASE,
    Bores,
    Twins,
    bandwidths,
    run_published,
)
from hypertuna.paper.ledger import FAMILY, UNPUBLISHED, Finding, published, published_value
from hypertuna.reports.html import WIDTH, Section, Table, table_of
from hypertuna.simulation.cards import posture_table, spelled_limits
from hypertuna.simulation.posture import MAX_ERROR

SIZING = "pump sizing"


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Twins:
    """Return the runs of the twin of the paper's robot."""
    return run_published(trials[OURS].robot, published(), full=full, progress=step)


def findings(twins: Twins) -> Iterator[Finding]:
    """Yield the torque that servos need at the highest frequency and large amplitude, over what they have."""
    tank = published()["tank"]
    amplitude, hertz = np.radians(tank["amplitude_deg"][TANK]), max(tank["frequency_hz"])
    for size in size_pump(twins.robot, frequency=[hertz], amplitude=amplitude):
        torque_left = size.torque_limit * (1 - size.servo_speed / size.servo_speed_limit)
        note = (
            f"{size.torque:.3g} N m at the working pressure; the servo's line leaves {torque_left:.3g} of "
            f"{size.torque_limit:.3g} N m at {size.servo_speed:.3g} rad/s, the largest speed of the beat; {FAMILY}"
        )
        part = size.torque / torque_left if torque_left > 0 else math.inf
        yield Finding(f"servo/torque-{hertz:g}hz-{size.joint}", SIZING, "in sight", part, note)


def sections(twins: Twins) -> list[Section]:
    """Show the twin beside the paper: the eight gaits and what is behind them, and Fig. 8."""
    return [*_swim_sections(twins), *_posture_sections(twins)]


def speed_table(twins: Twins) -> Table:
    """Tabulate the eight speeds, with amplitudes and power."""
    rows = []
    for name in SPEEDS:
        run, value = twins.gaits[name], published_value(f"speed/{name}")
        reached = ", ".join(f"{angle:.1f}" for angle in np.degrees(run.swing))
        setpoints = ", ".join(f"{angle:.4g}" for angle in np.degrees(run.gait.amplitude))
        cells = [name, f"{run.gait.frequency:g}", setpoints, reached, f"{value:g}", f"{run.speed:.3f}"]
        error = f"{100 * (run.speed / value - 1):+.1f} %"
        rows.append([*cells, error, f"{run.electrical_power:.1f}", f"{run.cost_of_transport:.1f}"])
    angles, speeds = ["set [deg]", "reached [deg]"], ["published [m/s]", "twin [m/s]", "error"]
    return Table(["gait", "f [Hz]", *angles, *speeds, "power [W]", "cost [J/(kg m)]"], rows)


def tank_table(twins: Twins) -> Table:
    """Tabulate amplitudes over frequency beside those by the identified bandwidth."""
    groups, rows = twins.robot.joints, []
    for run in twins.tank:
        row = [f"{run.gait.frequency:g} Hz"]
        for group, setpoint, amplitude in zip(groups, run.gait.amplitude, run.first_harmonic, strict=True):
            lag = 1 / np.sqrt(1 + (run.gait.frequency / group.bandwidth) ** 2) if group.bandwidth else np.nan
            row += [f"{np.degrees(amplitude):.1f}", f"{np.degrees(setpoint * lag):.1f}"]
        rows.append([*row, f"{run.speed:.3f}", f"{run.cost_of_transport:.1f}", spelled_limits(run.limits)])
    header = [f"{group.name}: {what} [deg]" for group in groups for what in ("twin", "lag")]
    return Table(["frequency", *header, "speed [m/s]", "cost [J/(kg m)]", "active limits"], rows)


def bore_table(bores: Bores) -> Table:
    """Tabulate the effect of the bore of the oil lines on the eight speeds."""
    rows = []
    for bore, gaits in bores.items():
        errors = [gaits[name][0] / published_value(f"speed/{name}") - 1 for name in SPEEDS]
        rms = 100 * math.sqrt(sum(error**2 for error in errors) / len(errors))
        _, swing, power = gaits["unoptimised-max"]
        angles = ", ".join(f"{angle:.1f}" for angle in np.degrees(swing))
        cells = [f"{100 * error:+.0f} %" for error in errors]
        rows.append([f"{1e3 * bore:g} mm", f"{rms:.1f} %", *cells, angles, f"{power:.1f}"])
    return Table(["bore", "rms error", *SPEEDS, "reached at 6 Hz [deg]", "power at 6 Hz [W]"], rows)


def _swim_sections(twins: Twins) -> list[Section]:
    """Show the eight gaits, amplitudes over frequency, and the pressures behind them."""
    from hypertuna.simulation.plots import plot_limits, plot_pressures, plot_twin

    middle, fastest = twins.tank[len(twins.tank) // 2], twins.gaits["unoptimised-max"]
    frequencies = [run.gait.frequency for run in twins.tank]
    errors = {name: twins.gaits[name].speed / published_value(f"speed/{name}") - 1 for name in SPEEDS}
    slow, fast = twins.tank[0], twins.tank[-1]
    costs = {run.gait.frequency: run.cost_of_transport for run in twins.tank}
    ratios = {
        f"joint {group.name}": np.array([run.first_harmonic[j] / run.gait.amplitude[j] for run in twins.tank])
        for j, group in enumerate(twins.robot.joints)
    }
    return compose(
        "twin",
        {
            "twin-amplitude": plot_limits(frequencies, ratios, _bandwidth(twins.robot), width=WIDTH),
            "twin-pressures": plot_pressures(middle, width=WIDTH),
            "twin": plot_twin(fastest, width=WIDTH),
            "tank": tank_table(twins),
            "speeds": speed_table(twins),
            "bores": bore_table(twins.bores),
        },
        errors=errors,
        rms=float(np.sqrt(np.mean(np.square(list(errors.values()))))),
        worst=max(errors, key=lambda name: abs(errors[name])),
        slow=slow,
        fast=fast,
        middle=middle,
        bandwidth=bandwidths(twins.robot),
        lag=100 / np.sqrt(1 + (fast.gait.frequency / _bandwidth(twins.robot)) ** 2),
        limits=spelled_limits(fast.limits) if fast.limits else "",
        fastest=fastest,
        lake=twins.gaits[published()["lake"]["gait"]],
        measured=published_value("power/fastest"),
        measured_lake=published_value("power/lake"),
        costs=costs,
        first=min(costs),
        last=max(costs),
        cheapest=min(costs, key=lambda hertz: costs[hertz]),
        setpoints=" and ".join(f"{angle:g}" for angle in np.degrees(slow.gait.amplitude).round(9)),
        bores=twins.bores,
        unpublished=UNPUBLISHED,
        seconds=SWIM,
        tank_phase=TANK_PHASE,
    )


def _posture_sections(twins: Twins) -> list[Section]:
    """Show Fig. 8 and what limits the joints."""
    from hypertuna.simulation.plots import plot_posture

    test = twins.posture
    return compose(
        "posture",
        {"fig8": plot_posture(test, width=WIDTH), "posture": table_of(posture_table(test))},
        joint=test.held[0].name,
        degrees=np.degrees(test.held[0].angle_set),
        close=np.degrees(MAX_ERROR),
        count=len(test.held),
        settled=[held.settling for held in test.held if held.settling is not None],
        eased=test.eased,
        hertz=" and ".join(f"{held.frequency:g} Hz" for held in test.eased),
        stops=sorted({held.limits[0].replace("_", " ") for held in test.held if held.settling is None and held.limits}),
        angles=" and ".join(f"{np.degrees(held.angle_set):.3g}" for held in test.eased),
        times=[held.settling for held in test.eased if held.settling is not None],
    )


def _bandwidth(robot: Robot) -> float:
    """Return the bandwidth of the joints, one for all [Hz]."""
    (value,) = {group.bandwidth for group in robot.joints}
    assert value is not None  # identified from the paper's speeds
    return value


CHAPTER = Chapter("twins", sections, findings, compute, steps=2, full_steps=2)
