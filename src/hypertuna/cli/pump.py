"""The command `hypertuna pump`."""

import math
from collections.abc import Sequence
from typing import Annotated, Any

from hypertuna.actuation.cards import sizes_dataset
from hypertuna.actuation.hydraulics import circuits
from hypertuna.actuation.sizing import Sizes, largest_beat, size_over
from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.cli.twin import kelvin
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.ranges import Whole
from hypertuna.swimming.gait import named_gait

CASES = Whole(max=10_000)  # number of cases of one call


def _key_values(text: str, key: str) -> tuple[str, list[float]]:
    """Return key and values from KEY=VALUES; key: the option, for errors."""
    name, values = parsing.pair(text, key, "KEY=VALUE,...")
    return name, parsing.values(values, f"{key} {name}", "the unit of the key")


@opt.grouped
def pump_command(
    robot: opt.RobotOptions,
    gait: opt.GaitName = None,
    frequency: Annotated[
        Sequence[float] | None, opt.values("--frequency", "Hz", f"Beat frequency: {opt.RANGE}. (default: the highest)")
    ] = None,
    amplitude: Annotated[
        Sequence[float] | None,
        opt.numbers("--amplitude", "degrees", "Amplitudes, one per joint group. (default: the largest)"),
    ] = None,
    bore: Annotated[
        Sequence[float] | None,
        opt.values("--bore", "mm", f"Inner diameter of all lines: {opt.RANGE}. {opt.ROBOTS}", limits=opt.BORES),
    ] = None,
    temperature: Annotated[
        Sequence[float] | None,
        opt.values("--temperature", "C", f"Oil temperature: {opt.RANGE}. {opt.ROBOTS}"),
    ] = None,
    over: Annotated[
        list[Any] | None,
        opt.option(
            ("--over",),
            f"Key of the robot's file and its {opt.RANGE}, such as joints.I.actuator.lever_m=0.008:0.012:3 or "
            '"servos.piston pump.torque_n_m=3:7:3"; repeatable.',
            "KEY=VALUE,...",
            _key_values,
        ),
    ] = None,
    files: opt.Files = opt.NO_FILES,
) -> None:
    """Size the pump: torque, speed and stroke of its servos, drop and bandwidth of the lines.

    Each joint beats alone, in air and without mass: what hydraulics alone can do. Without a gait, frequency and
    amplitude are the largest possible.
    """
    fish = robot.load()
    circuits(fish)  # raises errors of the robot's file before the options are checked
    frequencies, amplitudes = _beat(fish, gait, frequency, amplitude)
    bores: list[float | None] = [None] if bore is None else [1e-3 * value for value in bore]
    temperatures = [None] if temperature is None else [kelvin(value) for value in temperature]
    axes = [*(values for _, values in over or []), frequencies, bores, temperatures]
    CASES.check(math.prod(map(len, axes)), "the number of cases", "take fewer values: each case takes about 0.1 s")
    with progress_bar("sizing") as progress:
        sizes = size_over(
            fish,
            dict(over or []),
            frequency=frequencies,
            amplitude=amplitudes,
            bore=bores,
            temperature=temperatures,
            progress=progress,
        )
    columns = [*sizes[0].record()]
    emit(sizes, record=_record, dataset=sizes_dataset, columns=columns, digits=None, **vars(files))


def _record(sizes: Sizes) -> dict[str, Any]:
    """Return the JSON record of the sizes."""
    return provenance(sizes.robot) | {"sizes": [size.record() for size in sizes]}


def _beat(
    robot: Robot, gait: str | None, frequency: Sequence[float] | None, amplitude: Sequence[float] | None
) -> tuple[list[float], tuple[float, ...]]:
    """Return frequencies [Hz] and amplitudes [rad]: as given, else of a named gait, else the largest."""
    if gait is not None:
        named = named_gait(robot, gait)
        fastest, largest = named.frequency, tuple(named.amplitude)
    else:
        fastest, largest = largest_beat(robot) if frequency is None or amplitude is None else (0.0, ())
    angles = largest if amplitude is None else tuple(math.radians(angle) for angle in amplitude)
    return [fastest] if frequency is None else list(frequency), angles
