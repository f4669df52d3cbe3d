"""The command `hypertuna twin`."""

import math
from typing import Annotated, Any

from hypertuna.actuation.hydraulics import with_bore
from hypertuna.cli import options as opt
from hypertuna.cli.console import attended
from hypertuna.cli.emit import emit, made_by, save
from hypertuna.cli.gait import GaitOptions, check_duration
from hypertuna.description.robot import Robot
from hypertuna.io.quantity import ZERO_CELSIUS, values_of
from hypertuna.simulation.cards import circuit_rows, hinge_rows, joint_rows, swims_forward, twin_sentences
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twin
from hypertuna.swimming.gait import gait_degrees

# Variables of the dataset that a CSV file holds.
COLUMNS = (
    *("time", "angle_set", "angle", "angle_measured", "pump_pressure", "unit_pressure", "servo_angle"),
    *("electrical_power", "x", "y", "heading", "speed", "status"),
)


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
            "-JOINT-right; imu; battery. Kinds: stuck, open, spike, nan, drift, shift, "
            "clogged. Examples: bend-II:stuck@5, imu:nan@5-8.",
            "FAULT",
        ),
    ] = None,
    open_loop: Annotated[bool, opt.flag("--open-loop", "Switch the posture control off.")] = False,
    medium: opt.Medium = "water",
    temperature: opt.Temperature = None,
    line_bore: opt.Bore = None,
    seed: opt.Seed = 0,
    start: Annotated[
        str, opt.word("--start", ("rest", "swimming"), "Start at rest, or swimming at the gait's settled speed.")
    ] = "rest",
    losses: Annotated[str | None, opt.file("--losses", "a picture of where the power goes", *opt.FIGURES)] = None,
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
    figure_of = None if run.status == "diverged" else losses
    if figure_of is not None:
        save(run.losses.plot(), figure_of)
    emit(
        run,
        record=_record,
        columns=COLUMNS,
        facts=_record,
        **vars(files),
        written=(figure_of,),
        failed=run.status == "diverged",
    )


def robot_with(robot: opt.RobotOptions, line_bore: float | None) -> Robot:
    """Load a robot, with all oil lines of another inner diameter [mm] if one is given."""
    fish = robot.load()
    return fish if line_bore is None else with_bore(fish, 1e-3 * line_bore)


def made_by_twin(robot: Robot) -> dict[str, Any]:
    """Return the provenance of a run of the twin; without the law of joints, as its controller moves them."""
    return {key: value for key, value in made_by(robot).items() if key != "joints"}


def kelvin(celsius: float | None) -> float | None:
    """Convert a temperature from degrees C to K."""
    return None if celsius is None else celsius + ZERO_CELSIUS


def _record(run: TwinRun) -> dict[str, Any]:
    """Return the JSON record of a run of the twin."""
    return (
        values_of(run.summary())
        | ({} if swims_forward(run) else {"cost_of_transport_j_per_kg_m": math.nan})
        | {"battery_power_w": run.battery_power, "losses": run.losses.rows}
        | {
            "joints": joint_rows(run),
            "hinges": hinge_rows(run),
            "circuits": circuit_rows(run),
            "limits": list(run.limits),
            "faults": list(run.faults),
        }
        | {"status": run.status, "status_text": twin_sentences(run), "settled": run.settled}
        | gait_degrees(run.gait)
        | {"duration_s": run.duration, "medium": run.medium, "start": run.start, "seed": run.seed}
        | {"closed_loop": run.closed_loop, "temperature_c": run.temperature - ZERO_CELSIUS}
        | made_by_twin(run.robot)
    )
