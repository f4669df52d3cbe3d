"""The command `hypertuna radio calibrate`: sensors and servos of a robot, from a file or live."""

import math
import os
import select
import sys
import time
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.arrays import Array
from hypertuna.cli import options as opt
from hypertuna.cli.console import table
from hypertuna.cli.emit import emit
from hypertuna.cli.parsing import number as read_number
from hypertuna.cli.radio import Key
from hypertuna.errors import InputError
from hypertuna.firmware.black_box import read_black_box
from hypertuna.radio.calibration import (
    AXES,
    KINDS,
    SINGLE,
    Calibration,
    Pair,
    calibrate,
    parse_sensor,
    read_pairs,
    zero_and_scale,
)
from hypertuna.radio.check import request
from hypertuna.radio.client import Client, connect
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
from hypertuna.radio.samples import SAMPLING, Samples, average, check_disarmed, sample_imu, streaming

REST = 5.0  # s of samples of a gyroscope
TURNING_MAX = 300.0  # s that the compass may be turned for
ENOUGH = 150  # samples of a compass that covers all directions
PREFLIGHT_CALIBRATION = 241  # MAV_CMD
BOX = ".bin"  # end of the name of a black box
ONE_REFERENCE = ("servo", "voltage")  # kinds that one reference calibrates
Known = dict[str, float]  # parameters on board before a calibration
Calibrated = tuple[tuple[Calibration, ...], Known]


def calibrate_command(
    csv: Annotated[
        str | None, opt.text("--csv", "CSV file with the columns sensor, counts and reference.", "FILE")
    ] = None,
    log: Annotated[
        str | None,
        opt.text(
            "--log", "Of the compass: log of `hypertuna radio log --rate RAW_IMU=10`, while it is turned.", "FILE"
        ),
    ] = None,
    sensor: Annotated[
        str | None,
        opt.text(
            "--sensor",
            f"Live: {', '.join(kind if kind in SINGLE else f'{kind}_0' for kind in KINDS)}; servo for all servos.",
        ),
    ] = None,
    reference: Annotated[
        Sequence[float] | None,
        opt.numbers(
            "--at",
            "deg, kPa or A",
            "Live: references such as -20,0,20 in deg, kPa, A, V or m; a servo's neutral angle.",
        ),
    ] = None,
    place: Annotated[
        str | None, opt.text("--connect", "Connection to the robot that stores the calibration and is read live.")
    ] = None,
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Calibrate sensors and servos' zeros, from a file or live. Nothing is stored unless the fit is good."""
    if sum(source is not None for source in (csv, log, sensor)) != 1:
        raise InputError("must be given", key="exactly one of --csv, --sensor and --log", fix="give one of them")
    if sensor is not None and place is None:
        rule, fix = "must name the connection to the robot", "give it, because --sensor reads the robot live"
        raise InputError(rule, key="--connect", value="missing", fix=fix)
    if log is not None and place is None and log.endswith(BOX):
        fix = "give it, because a black box has readings by the robot's present calibration"
        raise InputError("must name the connection to the robot", key="--connect", value="missing", fix=fix)
    references = [] if sensor is None else _references(sensor, reference)
    calibrations: tuple[Calibration, ...] = ()
    if csv is not None:
        calibrations = calibrate(read_pairs(csv))
    elif log is not None and not log.endswith(BOX):
        calibrations = (_of_log(log),)
    if place is not None:
        with connect(place, key=key) as robot:
            check_disarmed(robot)
            if sensor is not None:
                calibrations, known = _live(robot, sensor, references)
            elif log is not None and log.endswith(BOX):
                calibrations, known = _of_box(robot, log)
            else:
                known = _known(robot, [name for one in calibrations for name in one.parameters])
            if csv is not None:
                calibrations = calibrate(read_pairs(csv), pulse_center=read_parameter(robot, "pulse_center"))
            _keep(robot, calibrations, known)
    emit(
        calibrations,
        record=lambda calibrations: {"sensors": [one.record() for one in calibrations], "kept": place is not None},
        lines=lambda calibrations: _lines(calibrations, place),
        as_json=as_json,
    )


def _lines(calibrations: Sequence[Calibration], place: str | None) -> Iterator[Any]:
    """Lay out calibrations."""
    rows = []
    for one in calibrations:
        parameters = ", ".join(f"{name} = {value:.7g}" for name, value in one.parameters.items())
        rms, unit = one.reading
        rows.append((one.sensor, f"{one.points}", f"{rms:.3g} {unit}", parameters))
    yield table(["sensor", "points", "rms", "parameters"], rows, left=range(4))
    for one in calibrations:
        yield from (f"{one.sensor}: {note}" for note in one.notes)
    yield "The robot keeps them." if place else "Nothing was sent: --connect sends them to a robot.", "dim"


def _references(sensor: str, values: Sequence[float] | None) -> list[float]:
    """Check the references of a sensor: two at least; none of depth, one of voltage, none or one of a servo suffice."""
    kind = "servo" if sensor == "servo" else parse_sensor(sensor)[0]
    unit, references = KINDS[kind][0], list(values or [])
    given = ",".join(f"{value:g}" for value in references) or "missing"
    if kind in AXES or sensor == "servo":
        if references:
            raise InputError(f"must not be given for {sensor}", key="--at", value=given, fix="leave it out")
        return []
    if kind == "servo" and len(references) > 1:
        raise InputError("must be one angle of a servo", key="--at", value=given, fix="write it as --at=2")
    if not (kind in ONE_REFERENCE or (kind == "depth" and not references)) and len(set(references)) < 2:
        fix = f"give them in {unit}: --at={'0,1.5' if kind == 'depth' else '-20,0,20'}"
        raise InputError("must name at least two references", key="--at", value=given, fix=fix)
    if kind == "voltage" and (not references or references[0] <= 0):
        fix = "measure it at the battery: --at=16.2"
        raise InputError("must be a voltage above 0", key="--at", value=given, fix=fix)
    return references


def _live(robot: Client, sensor: str, references: Sequence[float]) -> Calibrated:
    """Calibrate a sensor or servo of a connected robot."""
    if sensor == "servo":
        return _servos_live(robot)
    kind, _ = parse_sensor(sensor)
    live = {"accelerometer": _accelerometer_live, "gyroscope": _gyroscope_live, "compass": _compass_live}
    if kind in live:
        return live[kind](robot)
    return (_servo_live if kind == "servo" else _sensor_live)(robot, sensor, references)


def _keep(robot: Client, calibrations: tuple[Calibration, ...], known: Known) -> None:
    """Send all parameters of calibrations, or restore those that the robot had before."""
    kept: list[str] = []
    try:
        for name, value in ((name, value) for one in calibrations for name, value in one.parameters.items()):
            set_parameter(robot, name, value)
            kept.append(name)
    except InputError as error:
        try:
            for name in kept:
                set_parameter(robot, name, known[name])
        except InputError:
            fix = f"{error.fix}; the robot may have new values of {', '.join(kept)}: calibrate again"
            raise InputError(error.rule, key=error.key, value=error.value, fix=fix) from None
        raise


def _answer(robot: Client, question: str) -> str:
    """Ask, and keep listening to the robot until a line is typed: no old reading is left over."""
    typer.echo(f"{question}: ", nl=False, err=True)
    line, input_ = b"", sys.stdin.fileno()
    while not line.endswith(b"\n"):
        list(robot.poll(0.1))
        while not line.endswith(b"\n") and select.select([input_], [], [], 0)[0]:
            if not (key := os.read(input_, 1)):
                typer.echo(err=True)
                raise InputError("must answer", key="standard input", value="at its end", fix="run it in a terminal")
            line += key
    return line.decode(errors="replace").strip()


def _known(robot: Client, names: Sequence[str]) -> Known:
    """Read parameters of the robot."""
    return {name: read_parameter(robot, name) for name in names}


def _sensor_live(robot: Client, sensor: str, references: Sequence[float]) -> Calibrated:
    """Ask for one reference after another, and average the readings at each; a lone voltage gives the scale alone."""
    kind, index = parse_sensor(sensor)
    if kind == "depth" and not references:
        return (_zero_depth(robot),), {}
    unit, factor = KINDS[kind]
    names = zero_and_scale(sensor)
    known = _known(robot, names)
    zero, scale = known.values()
    pairs: list[Pair] = []
    for value in references:
        _answer(robot, f"bring {sensor} to {value:g} {unit}, hold it, and press Enter")
        read = average(robot, kind, index)
        counts = read if kind == "depth" else read / scale + zero
        typer.echo(f"  it shows {scale * (counts - zero) * factor:.4g} {unit}", err=True)
        pairs.append((sensor, counts, value / factor))
    if len(pairs) > 1:
        return calibrate(pairs), known
    _, counts, value = pairs[0]
    if counts <= zero:
        raise InputError(
            "must read more counts than its zero", key=sensor, value=f"{counts:.0f} counts", fix="check its divider"
        )
    return (Calibration(sensor, {names[1]: value / (counts - zero)}, 0.0, 1),), known


def _zero_depth(robot: Client) -> Calibration:
    """Take the present depth as that of the surface."""
    _answer(robot, "keep the depth sensor in air or at the surface, and press Enter")
    robot.command(PREFLIGHT_CALIBRATION, 0, 0, 1, name="zero of the depth")
    depth = request(robot, "LOCAL_POSITION_NED").z
    return Calibration("depth", {}, 0.0, 1, (f"it shows {depth:.2f} m now, until the next boot or arming",))


# --- IMU


def _axes(name: str) -> list[str]:
    """Return the parameters of three axes: field_zero_0 to field_scale_2."""
    return [f"{name}_{part}_{k}" for part in ("zero", "scale") for k in range(3)]


def _parts(known: Known) -> tuple[Array, Array]:
    """Return zeros and scales of parameters of three axes."""
    values = list(known.values())
    return np.array(values[:3]), np.array(values[3:])


def _accelerometer_live(robot: Client) -> Calibrated:
    known = _known(robot, _axes("accel"))
    means: dict[Position, Array] = {}
    with streaming(robot, "RAW_IMU"):
        for k, position in enumerate(POSITIONS, 1):
            _answer(robot, f"{k} of {len(POSITIONS)}: hold the robot {position.text}, and press Enter")
            means[position] = sample_imu(robot, SAMPLING)["acceleration"].mean(axis=0)
    return (calibrate_accelerometer(means),), known


def _gyroscope_live(robot: Client) -> Calibrated:
    known = _known(robot, _axes("rate"))
    _answer(robot, "put the robot on a table, let it rest, and press Enter")
    with streaming(robot, "RAW_IMU"):
        counts = sample_imu(robot, REST)["rate"]
    return (calibrate_gyroscope(counts, _parts(known)[1]),), known


def _compass_live(robot: Client) -> Calibrated:
    """Sample while the robot is turned, until all directions are covered."""
    known = _known(robot, _axes("field"))
    zero, scale = _parts(_known(robot, _axes("accel")))
    _answer(
        robot, "keep away from iron, press Enter, and turn the robot slowly in all directions until you read `enough`"
    )
    parts: list[Samples] = []
    end = time.monotonic() + TURNING_MAX
    faces = 0
    with streaming(robot, "RAW_IMU"):
        while time.monotonic() < end:
            parts.append(sample_imu(robot, 1.0))
            field = np.concatenate([part["field"] for part in parts])
            sphere = fit_sphere(field, 1.0) if len(field) >= SAMPLES_MIN else None
            faces = 0 if sphere is None else covered(sphere.readings(field))
            typer.echo(f"\r  {len(field)} samples, {faces} of {len(FACES)} directions ", nl=False, err=True)
            if faces == len(FACES) and len(field) >= ENOUGH:
                break
    typer.echo("enough" if faces == len(FACES) else "", err=True)
    acceleration = scale * (np.concatenate([part["acceleration"] for part in parts]) - zero)
    return (calibrate_compass(field, acceleration),), known


def _of_log(path: str) -> Calibration:
    """Calibrate the compass from a log of RAW_IMU."""
    fields = read_radio_log(path).fields.get("RAW_IMU")
    if fields is None:
        fix = "record it with `hypertuna radio log --rate RAW_IMU=10`"
        raise InputError("must be in the log", file=path, key="RAW_IMU", value="missing", fix=fix)
    return calibrate_compass(np.column_stack([fields[f"{axis}mag"] for axis in "xyz"]))


def _of_box(robot: Client, path: str) -> Calibrated:
    """Calibrate the compass from the last boot in a black box: readings by the calibration on board."""
    known = _known(robot, _axes("field"))
    zero, scale = _parts(known)
    ticks = read_black_box(path)[-1].ticks
    field, acceleration = ticks["field_read"], ticks["acceleration_read"]
    whole = np.isfinite(field).all(axis=1) & np.isfinite(acceleration).all(axis=1)
    counts = field[whole].astype(float) / scale + zero
    return (calibrate_compass(counts, acceleration[whole].astype(float)),), known


# --- servos


def _servo_live(robot: Client, sensor: str, references: Sequence[float]) -> Calibrated:
    """Hold the servo at neutral, ask for its angle unless it is given, and subtract it from the trim."""
    if references:
        return _trimmed(robot, {sensor: references[0]})
    return _servos(robot, [sensor])


def _servos_live(robot: Client) -> Calibrated:
    """Hold all servos at neutral, and ask for the angle of one after another."""
    names = []
    for number in range(10):
        try:
            read_parameter(robot, f"servo_trim_{number}")
        except InputError:
            break
        names.append(f"servo_{number}")
    return _servos(robot, names)


def _servos(robot: Client, sensors: Sequence[str]) -> Calibrated:
    """Arm, ask for the angles of servos at neutral, and disarm."""
    _answer(robot, "keep clear: Enter arms the robot, and its tail rests at neutral")
    robot.arm()
    try:
        angles = {
            sensor: read_number(_answer(robot, f"angle of {sensor} from its neutral mark, in deg"), "angle", "deg")
            for sensor in sensors
        }
    finally:
        robot.arm(False)
    return _trimmed(robot, angles)


def _trimmed(robot: Client, angles: dict[str, float]) -> Calibrated:
    """Subtract angles [deg] from the servos' trims."""
    names = {sensor: f"servo_trim_{parse_sensor(sensor)[1]}" for sensor in angles}
    known = _known(robot, list(names.values()))
    factor = read_parameter(robot, "pulse_per_rad")
    trims = {names[sensor]: known[names[sensor]] - math.radians(angle) * factor for sensor, angle in angles.items()}
    return tuple(Calibration(sensor, {names[sensor]: trims[names[sensor]]}, 0.0, 1) for sensor in angles), known
