"""The command `hypertuna twin`."""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.actuation.hydraulics import with_bore
from hypertuna.cli import options as opt
from hypertuna.cli.command import listed
from hypertuna.cli.console import attended, summary_table, table
from hypertuna.cli.emit import draw, emit, made_by
from hypertuna.cli.gait import GaitOptions, check_duration, gait_degrees, gait_text
from hypertuna.description.robot import Robot
from hypertuna.display import number
from hypertuna.io.quantity import ZERO_CELSIUS, quantity, values_of
from hypertuna.simulation.losses import PLACES
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twin

KILO = 1e3
MIN_SPEED = 0.01  # 1/s: a robot slower than this many body lengths stands, and has no cost per distance
# Variables in a CSV file.
COLUMNS = (
    *("time", "angle_set", "angle", "angle_measured", "pump_pressure", "unit_pressure", "servo_angle"),
    *("electrical_power", "x", "y", "heading", "speed", "status"),
)
BACKWARD = "The robot does not swim head first, or hardly moves: there is no cost of transport and no range."


@opt.grouped
def twin_command(
    robot: opt.RobotOptions,
    gait: GaitOptions,
    duration: opt.Duration = 20,
    fault: Annotated[
        list[str] | None,
        opt.text(
            "--fault",
            "Fault of a sensor, CHANNEL:KIND@START or CHANNEL:KIND@START-END with times in s; repeatable. Channels: "
            "bend, pressure and current, each alone or with -JOINT, the last two also with -JOINT-left or "
            "-JOINT-right; imu; battery. Kinds: stuck, open, spike, nan. Examples: bend-II:stuck@5, imu:nan@5-8.",
            "FAULT",
        ),
    ] = None,
    open_loop: Annotated[bool, typer.Option("--open-loop", help="Switch the posture control off.")] = False,
    medium: opt.Medium = "water",
    temperature: opt.Temperature = None,
    line_bore: opt.Bore = None,
    seed: opt.Seed = 0,
    start: Annotated[
        str, opt.word("--start", ("rest", "swimming"), "Start at rest, or swimming at the gait's settled speed.")
    ] = "rest",
    losses: Annotated[
        str | None,
        opt.file("--losses", help="Write a picture of where the power goes to this file.", suffixes=opt.FIGURES),
    ] = None,
    files: opt.Files = opt.NO_FILES,
) -> None:
    """Simulate the whole robot: controller, servos, pumps, oil, muscles, tail, water, sensors.

    The exit code is 0 for a run, 1 for one that diverged (its results until then are printed), 2 for bad input.
    """
    fish = robot_with(robot, line_bore)
    beat = gait.make(fish)
    check_duration(beat, duration)
    options: dict[str, Any] = {"closed_loop": not open_loop, "temperature": kelvin(temperature), "start": start}
    options |= {"duration": duration, "medium": medium, "faults": tuple(fault or ()), "seed": seed}
    run = attended("simulating", lambda: twin(fish, beat, **options))
    pictured = None if run.status == "diverged" else losses
    if pictured is not None:
        draw("hypertuna.simulation.plots_losses:plot_losses", pictured, run.losses)
    emit(
        run,
        record=_record,
        lines=_lines,
        columns=COLUMNS,
        facts=_record,
        figure="hypertuna.simulation.plots:plot_twin",
        **vars(files),
        written=(pictured,),
        failed=run.status == "diverged",
    )


def robot_with(robot: opt.RobotOptions, line_bore: float | None) -> Robot:
    """Load a robot, with all oil lines of another inner diameter [mm] if one is given."""
    fish = robot.load()
    return fish if line_bore is None else with_bore(fish, 1e-3 * line_bore)


def made_by_twin(robot: Robot) -> dict[str, Any]:
    """Return what made a run of the twin, which moves its joints by itself, not by a joint law."""
    return {key: value for key, value in made_by(robot).items() if key != "joints"}


def kelvin(celsius: float | None) -> float | None:
    """Convert a temperature from degrees C to K."""
    return None if celsius is None else celsius + ZERO_CELSIUS


def swims_forward(run: TwinRun) -> bool:
    """Return whether a robot swims head first; also true in air and of a diverged run, which have no speed."""
    return math.isnan(run.speed) or run.speed_bl > MIN_SPEED


def _joints(run: TwinRun) -> list[dict[str, Any]]:
    """Return setpoint and motion of each joint group over the last whole beats."""
    return _rows(
        run.joints,
        amplitude_set_deg=np.degrees(run.gait.amplitude),
        swing_deg=np.degrees(run.swing),
        first_harmonic_deg=np.degrees(run.first_harmonic),
        swing_error_deg=np.degrees(run.swing - run.gait.amplitude),
        bias_set_deg=np.degrees(run.gait.bias),
        bias_deg=np.degrees(run.bias),
        phase_set_deg=np.degrees(run.gait.phase),
        phase_deg=np.degrees(run.phase),
    )


def _circuits(run: TwinRun) -> list[dict[str, Any]]:
    """Return the pressures of each oil circuit."""
    return _rows(run.circuits, pressure_max_kpa=run.pressure_max / KILO, pressure_min_kpa=run.pressure_min / KILO)


def _rows(names: Sequence[str], **columns: Any) -> list[dict[str, Any]]:
    """Return a row of the columns for each name."""
    return [{"name": name} | {key: values[k] for key, values in columns.items()} for k, name in enumerate(names)]


def _sentences(run: TwinRun) -> list[str]:
    """Describe the run, and add a sentence if the robot did not swim forward."""
    return [*run.sentences, *([] if swims_forward(run) else [BACKWARD])]


def _record(run: TwinRun) -> dict[str, Any]:
    """Return the JSON record."""
    return (
        values_of(run.summary())
        | ({} if swims_forward(run) else {"cost_of_transport_j_per_kg_m": math.nan})
        | {"battery_power_w": run.battery_power, "losses": run.losses.rows}
        | {"joints": _joints(run), "circuits": _circuits(run), "limits": list(run.limits), "faults": list(run.faults)}
        | {"status": run.status, "status_text": _sentences(run), "settled": run.settled}
        | gait_degrees(run.gait)
        | {"duration_s": run.duration, "medium": run.medium, "start": run.start, "seed": run.seed}
        | {"closed_loop": run.closed_loop, "temperature_c": run.temperature - ZERO_CELSIUS}
        | made_by_twin(run.robot)
    )


def _lines(run: TwinRun) -> Iterator[Any]:
    """Lay out a run: totals, joints, circuits, sentences."""
    loop = "closed loop" if run.closed_loop else "open loop"
    oil = f", oil at {run.temperature - ZERO_CELSIUS:.3g} C" if run.circuits else ""
    yield f"{run.robot.name}, {gait_text(run.gait)}", "bold"
    yield f"{run.duration:g} s in {run.medium} from {run.start}, {loop}{oil}", "dim"
    summary = run.summary()
    if not swims_forward(run):
        summary["cost_of_transport_j_per_kg_m"] = quantity("cost_of_transport", "–")
    yield summary_table(summary, digits=3)
    yield ""
    yield _joint_table(run)
    servos = [group.name for group in run.robot.joints if group.servo is not None]
    if servos and run.closed_loop:
        lag = "the swing error and the lag of the phase are the servo's own"
        yield f"No sensor reads the bend of {listed(servos)}, so the controller does not correct it: {lag}.", "dim"
    yield ""
    if run.circuits:
        yield from _pressure_lines(run)
        yield ""
    yield from _loss_lines(run)
    yield ""
    good = run.settled and not run.limits and not run.faults
    bad = run.status == "diverged" or bool(run.faults)
    for k, sentence in enumerate(_sentences(run)):
        yield sentence, "green" if good or (k == 0 and run.settled) else "bold red" if bad else "yellow"


def _pressure_lines(run: TwinRun) -> Iterator[Any]:
    """Lay out the pressures of the oil circuits."""
    yield f"cylinder pressure, peaks within ticks, {_beats(run)}", "dim"
    rows = ((row["name"], f"{row['pressure_min_kpa']:.0f}", f"{row['pressure_max_kpa']:.0f}") for row in _circuits(run))
    yield table(["\ncircuit", "min\n[kPa]", "max\n[kPa]"], rows)


def _loss_lines(run: TwinRun) -> Iterator[Any]:
    """Lay out where the power goes, a line a place."""
    losses = run.losses
    yield f"where the {number(losses.power, 'W')} of the cells go, {_beats(run)}", "dim"
    rows = [
        (place, f"{losses.at(place):.3g}", f"{100 * losses.at(place) / losses.power:.0f}", losses.named(place))
        for place in PLACES
        if losses.at(place)
    ]
    yield table(["\nplace", "mean\n[W]", "part\n[%]", "\nof it [W]"], rows, left=(0, 3), fold=3)


def _beats(run: TwinRun) -> str:
    """Name the beats that means are over."""
    return f"last {run.beat_count} beats" if run.beat_count > 1 else "last beat"


def _joint_table(run: TwinRun) -> Any:
    """Lay out setpoints and motions of the joints."""
    columns = [("swing", "swing_deg", ".1f"), ("amplitude set", "amplitude_set_deg", ".1f")]
    columns += [("swing error", "swing_error_deg", "+z.1f")]
    columns += [("bias", "bias_deg", "z.1f"), ("set", "bias_set_deg", ".1f")] if any(run.gait.bias) else []
    columns += [("phase", "phase_deg", "z.0f"), ("set", "phase_set_deg", ".0f")]
    rows = ((row["name"], *(f"{row[key]:{form}}" for _, key, form in columns)) for row in _joints(run))
    return table(["\njoint", *(f"{head}\n[deg]" for head, *_ in columns)], rows)
