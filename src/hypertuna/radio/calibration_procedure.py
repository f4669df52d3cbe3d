"""Calibrate a connected robot: ask its operator, sample its sensors, and store parameters on board."""

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.radio.calibration import KINDS, Calibration, Pair, calibrate, parse_sensor, zero_and_scale
from hypertuna.radio.check import request
from hypertuna.radio.client import Client
from hypertuna.radio.imu import (
    FACES,
    POSITIONS,
    SAMPLES_MIN,
    Position,
    calibrate_accelerometer,
    calibrate_compass,
    calibrate_gyroscope,
    covered,
    fit_sphere,
)
from hypertuna.radio.log import read_radio_log
from hypertuna.radio.parameters import read_parameter, set_parameter
from hypertuna.radio.samples import SAMPLING, Samples, average, sample_imu, streaming

REST = 5.0  # s for which a gyroscope at rest is sampled
TURNING_MAX = 300.0  # s: longest time for turning the robot to calibrate its compass
SAMPLES_ENOUGH = 150  # samples of a compass that suffice once they cover all directions
PREFLIGHT_CALIBRATION = 241  # number of the MAV_CMD
Known = dict[str, float]  # parameters on board before a calibration
Calibrated = tuple[tuple[Calibration, ...], Known]  # results, and the parameters that they replace


class Operator(Protocol):
    """The person at the robot. Messages are received while a question is open, so that no old one is left."""

    def ask(self, robot: Client, question: str) -> str:
        """Ask the operator a question, and return the answer."""

    def ask_number(self, robot: Client, question: str, key: str, unit: str) -> float:
        """Ask the operator for a number in a unit, and return it; `key` names the number in errors."""

    def tell(self, text: str, *, end: str = "\n") -> None:
        """Show the operator a text."""


def calibrate_live(robot: Client, operator: Operator, sensor: str, references: Sequence[float]) -> Calibrated:
    """Calibrate a sensor or servo of a connected robot."""
    if sensor == "servo":
        return _servos_live(robot, operator)
    kind, _ = parse_sensor(sensor)
    procedures = {"accelerometer": _accelerometer_live, "gyroscope": _gyroscope_live, "compass": _compass_live}
    if kind in procedures:
        return procedures[kind](robot, operator)
    return (_servo_live if kind == "servo" else _sensor_live)(robot, operator, sensor, references)


def store(robot: Client, calibrations: tuple[Calibration, ...], known: Known) -> None:
    """Send all parameters of calibrations to the robot; if one is refused, restore those already sent."""
    stored: list[str] = []
    try:
        for name, value in ((name, value) for fit in calibrations for name, value in fit.parameters.items()):
            set_parameter(robot, name, value)
            stored.append(name)
    except InputError as error:
        try:
            for name in stored:
                set_parameter(robot, name, known[name])
        except InputError:
            fix = f"{error.fix}; the robot may have new values of {', '.join(stored)}: calibrate again"
            raise InputError(error.rule, key=error.key, value=error.value, fix=fix) from None
        raise


def known_parameters(robot: Client, names: Sequence[str]) -> Known:
    """Read parameters of the robot by name [SI]."""
    return {name: read_parameter(robot, name) for name in names}


def _sensor_live(robot: Client, operator: Operator, sensor: str, references: Sequence[float]) -> Calibrated:
    """Calibrate a sensor by its mean readings at references that the operator sets; a single one gives only a scale."""
    kind, index = parse_sensor(sensor)
    if kind == "depth" and not references:
        return (_zero_depth(robot, operator),), {}
    unit, factor = KINDS[kind]
    names = zero_and_scale(sensor)
    on_board = known_parameters(robot, names)
    zero, scale = on_board.values()
    pairs: list[Pair] = []
    for value in references:
        operator.ask(robot, f"bring {sensor} to {value:g} {unit}, hold it, and press Enter")
        reading = average(robot, kind, index)
        counts = reading if kind == "depth" else reading / scale + zero
        operator.tell(f"  it shows {scale * (counts - zero) * factor:.4g} {unit}")
        pairs.append((sensor, counts, value / factor))
    if len(pairs) > 1:
        return calibrate(pairs), on_board
    _, counts, value = pairs[0]
    if counts <= zero:
        raise InputError(
            "must read more counts than its zero", key=sensor, value=f"{counts:.0f} counts", fix="check its divider"
        )
    return (Calibration(sensor, {names[1]: value / (counts - zero)}, 0.0, 1),), on_board


def _zero_depth(robot: Client, operator: Operator) -> Calibration:
    """Make the robot take its present depth as zero."""
    operator.ask(robot, "keep the depth sensor in air or at the surface, and press Enter")
    robot.command(PREFLIGHT_CALIBRATION, 0, 0, 1, name="zero of the depth")
    depth = request(robot, "LOCAL_POSITION_NED").z
    return Calibration("depth", {}, 0.0, 1, (f"it shows {depth:.2f} m now, until the next boot or arming",))


# --- IMU


def _axis_parameters(name: str) -> list[str]:
    """Return the names of a three-axis sensor's parameters, such as field_zero_0 to field_scale_2."""
    return [f"{name}_{part}_{k}" for part in ("zero", "scale") for k in range(3)]


def _zeros_and_scales(on_board: Known) -> tuple[Array, Array]:
    """Return zeros (3,) and scales (3,) from the parameters of a three-axis sensor."""
    values = list(on_board.values())
    return np.array(values[:3]), np.array(values[3:])


def _accelerometer_live(robot: Client, operator: Operator) -> Calibrated:
    on_board = known_parameters(robot, _axis_parameters("accel"))
    means: dict[Position, Array] = {}
    with streaming(robot, "RAW_IMU"):
        for k, position in enumerate(POSITIONS, 1):
            operator.ask(robot, f"{k} of {len(POSITIONS)}: hold the robot {position.text}, and press Enter")
            means[position] = sample_imu(robot, SAMPLING)["acceleration"].mean(axis=0)
    return (calibrate_accelerometer(means),), on_board


def _gyroscope_live(robot: Client, operator: Operator) -> Calibrated:
    on_board = known_parameters(robot, _axis_parameters("rate"))
    operator.ask(robot, "put the robot on a table, let it rest, and press Enter")
    with streaming(robot, "RAW_IMU"):
        counts = sample_imu(robot, REST)["rate"]
    return (calibrate_gyroscope(counts, _zeros_and_scales(on_board)[1]),), on_board


def _compass_live(robot: Client, operator: Operator) -> Calibrated:
    """Calibrate the compass while the operator turns the robot, until its samples cover all directions."""
    on_board = known_parameters(robot, _axis_parameters("field"))
    zero, scale = _zeros_and_scales(known_parameters(robot, _axis_parameters("accel")))
    operator.ask(
        robot, "keep away from iron, press Enter, and turn the robot slowly in all directions until you read `enough`"
    )
    parts: list[Samples] = []
    deadline = time.monotonic() + TURNING_MAX
    faces = 0
    with streaming(robot, "RAW_IMU"):
        while time.monotonic() < deadline:
            parts.append(sample_imu(robot, 1.0))
            field = np.concatenate([part["field"] for part in parts])
            sphere = fit_sphere(field, 1.0) if len(field) >= SAMPLES_MIN else None
            faces = 0 if sphere is None else covered(sphere.readings(field))
            operator.tell(f"\r  {len(field)} samples, {faces} of {len(FACES)} directions ", end="")
            if faces == len(FACES) and len(field) >= SAMPLES_ENOUGH:
                break
    operator.tell("enough" if faces == len(FACES) else "")
    acceleration = scale * (np.concatenate([part["acceleration"] for part in parts]) - zero)
    return (calibrate_compass(field, acceleration),), on_board


def calibrate_log(path: str | Path) -> Calibration:
    """Calibrate the compass from the RAW_IMU messages of a log."""
    fields = read_radio_log(path).fields.get("RAW_IMU")
    if fields is None:
        fix = "record it with `hypertuna radio log --rate RAW_IMU=10`"
        raise InputError("must be in the log", file=str(path), key="RAW_IMU", value="missing", fix=fix)
    return calibrate_compass(np.column_stack([fields[f"{axis}mag"] for axis in "xyz"]))


def calibrate_readings(robot: Client, field: Array, acceleration: Array) -> Calibrated:
    """Calibrate the compass from readings (samples, 3) of field and acceleration with the calibration on board."""
    on_board = known_parameters(robot, _axis_parameters("field"))
    zero, scale = _zeros_and_scales(on_board)
    finite = np.isfinite(field).all(axis=1) & np.isfinite(acceleration).all(axis=1)
    counts = field[finite].astype(float) / scale + zero
    return (calibrate_compass(counts, acceleration[finite].astype(float)),), on_board


# --- servos


def _servo_live(robot: Client, operator: Operator, sensor: str, references: Sequence[float]) -> Calibrated:
    """Calibrate a servo's trim from its angle at neutral, given as a reference or read by the operator."""
    if references:
        return _trim_calibrations(robot, {sensor: references[0]})
    return _trims_at_neutral(robot, operator, [sensor])


def _servos_live(robot: Client, operator: Operator) -> Calibrated:
    """Calibrate the trims of all servos from their angles at neutral, which the operator reads."""
    names = []
    for number in range(10):
        try:
            read_parameter(robot, f"servo_trim_{number}")
        except InputError:
            break
        names.append(f"servo_{number}")
    return _trims_at_neutral(robot, operator, names)


def _trims_at_neutral(robot: Client, operator: Operator, sensors: Sequence[str]) -> Calibrated:
    """Arm the robot so that servos go to neutral, let the operator read their angles, and return the trims."""
    operator.ask(robot, "keep clear: Enter arms the robot, and its tail rests at neutral")
    robot.arm()
    try:
        angles = {
            sensor: operator.ask_number(robot, f"angle of {sensor} from its neutral mark, in deg", "angle", "deg")
            for sensor in sensors
        }
    finally:
        robot.arm(False)
    return _trim_calibrations(robot, angles)


def _trim_calibrations(robot: Client, angles: dict[str, float]) -> Calibrated:
    """Return servos' trims, corrected by their angles at neutral [deg]."""
    names = {sensor: f"servo_trim_{parse_sensor(sensor)[1]}" for sensor in angles}
    on_board = known_parameters(robot, list(names.values()))
    factor = read_parameter(robot, "pulse_per_rad")
    trims = {names[sensor]: on_board[names[sensor]] - math.radians(angle) * factor for sensor, angle in angles.items()}
    return tuple(Calibration(sensor, {names[sensor]: trims[names[sensor]]}, 0.0, 1) for sensor in angles), on_board
