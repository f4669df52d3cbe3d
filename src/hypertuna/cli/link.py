"""The commands `hypertuna link ...`: a robot's parameters, logs, calibration and missions over the radio."""

from __future__ import annotations

import math
import os
import select
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import print_json, print_lines, print_written, progress_bar, table
from hypertuna.cli.parsing import Setting
from hypertuna.cli.parsing import number as read_number
from hypertuna.errors import InputError
from hypertuna.io.files import write_atomically
from hypertuna.mission.file import read_mission
from hypertuna.mission.upload import download, upload
from hypertuna.radio.calibration import KINDS, Calibration, Pair, calibrate, parse_sensor, read_pairs
from hypertuna.radio.client import Client, connect
from hypertuna.radio.dialect import SILENT, need_radio
from hypertuna.radio.log import RadioLogWriter, check_new
from hypertuna.radio.parameters import read_parameter, read_parameters, set_parameter

link_app = opt.group("A robot over the radio; needs the extra radio, and log for logs.")

PLACES = "udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/ttyUSB0:9600."
Connect = Annotated[str, opt.text("--connect", PLACES, "PLACE")]
Key = Annotated[str | None, opt.text("--key", "File with the 32-byte key that signs messages.", "FILE")]
FLUSH = 2.0  # s of a log that a crash may cost
SAMPLING = 2.0  # s of readings that one reference is taken over


def read_key(path: str | None) -> bytes | None:
    """Read a key."""
    if path is None:
        return None
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        fix = "make one: openssl rand -out key 32"
        raise InputError("must be a readable file", file=path, value=f"not ({error.strerror})", fix=fix) from None
    if len(content) != 32:
        fix = "make one: openssl rand -out key 32"
        raise InputError("must have 32 bytes", file=path, value=f"{len(content)} long", fix=fix)
    return content


@link_app.command("params")
def params_command(
    place: Connect,
    settings: Annotated[
        list[Any] | None, opt.setting("--set", "SI", "Parameter to set, in SI units; repeatable.")
    ] = None,
    output: Annotated[
        str | None, opt.file("-o", "--output", help="Write the parameters to this .csv file.", suffixes=(".csv",))
    ] = None,
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Read the parameters of a robot, or set some. The robot keeps them; it must be disarmed for that."""
    need_radio()
    pairs: list[Setting] = settings or []
    with connect(place, key=read_key(key)) as robot:
        values = {name.lower(): set_parameter(robot, name.lower(), value) for name, value in pairs}
        if not values or output is not None:
            with progress_bar("parameters") as progress:
                values = read_parameters(robot, progress)
    if output is not None:
        rows = [f"{name},{value:.9g}" for name, value in values.items()]
        write_atomically(output, "\n".join(["name,value", *rows, ""]).encode())
    if as_json:
        print_json({"parameters": values, "written": output})
        return
    for name, value in values.items():
        typer.echo(f"{name} = {value:.7g}")
    print_written(output)


@link_app.command("log")
def log_command(
    place: Connect,
    output: Annotated[str, opt.file("-o", "--output", help="Write the log to this .mcap file.", suffixes=(".mcap",))],
    duration: Annotated[float | None, opt.number("--duration", "s", "Duration in s. (default: until Ctrl-C)")] = None,
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Record all that a robot and its tank's camera send, for Foxglove, `identify` and `actuator fit`."""
    need_radio()
    check_new(output)
    limit = math.inf if duration is None else duration
    if limit <= 0:
        raise InputError("must be positive", key="--duration", value=f"{limit:g}", fix="give seconds")
    with connect(place, key=read_key(key)) as robot, RadioLogWriter(output, "") as log:
        robot.listener = log.write
        begin, lost = time.monotonic(), None
        with progress_bar("seconds") as progress:
            try:
                _record_all(robot, log, begin + limit, lambda now: progress(now, int(min(limit, now + 1))))
            except KeyboardInterrupt:
                pass
            except InputError as error:
                lost = error
        facts: dict[str, Any] = {
            "messages": log.messages,
            "kinds": sorted(robot.last),
            "seconds": time.monotonic() - begin,
        }
    if as_json:
        print_json({"written": output, **facts})
    else:
        typer.echo(f"{facts['messages']} messages in {facts['seconds']:.0f} s: {', '.join(facts['kinds'])}")
        print_written(output)
    if lost is not None:
        raise lost


def _record_all(robot: Client, log: RadioLogWriter, end: float, report: Callable[[int], None]) -> None:
    """Listen until a time; every two seconds what has come is on the disk."""
    begun = last = time.monotonic()
    while (now := time.monotonic()) < end:
        list(robot.poll(min(0.2, end - now)))
        if now - last > FLUSH:
            last = now
            log.flush()
            report(int(now - begun))


@link_app.command("mission")
def mission_command(
    place: Connect,
    mission: Annotated[
        str, typer.Argument(metavar="MISSION", help="Mission file, or name of a mission that comes with hypertuna.")
    ],
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Send a mission to a robot: it keeps the stored mission until it has all of the new one."""
    need_radio()
    items = read_mission(mission).mission
    with connect(place, key=read_key(key)) as robot, progress_bar("items") as progress:
        upload(robot, items, progress)
        count = len(download(robot))
    print_json({"mission": mission, "items": count}) if as_json else typer.echo(
        f"{mission}: {count} items are on board"
    )


@link_app.command("calibrate")
def calibrate_command(
    csv: Annotated[
        str | None, opt.text("--csv", "CSV file with the columns sensor, counts and reference.", "FILE")
    ] = None,
    sensor: Annotated[str | None, opt.text("--sensor", "Live: bend_0, pressure_3, current_1, servo_5.")] = None,
    reference: Annotated[
        Sequence[float] | None,
        opt.numbers(
            "--at",
            "deg, kPa or A",
            "Live: references such as -20,0,20 in deg, kPa or A; a servo's neutral angle.",
        ),
    ] = None,
    place: Annotated[
        str | None, opt.text("--connect", "Connection to the robot that stores the calibration and is read live.")
    ] = None,
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Calibrate bend, pressure and current sensors and servos' zeros, from a CSV file or live, step by step."""
    if (csv is None) == (sensor is None):
        raise InputError("must be given, or --sensor, and not both", key="--csv", fix="give one of them")
    if sensor is not None and place is None:
        raise InputError(
            "must name the connection to the robot", key="--connect", value="missing", fix="--sensor reads live"
        )
    if csv is not None:
        calibrations = _from_file(csv, place, key)
    elif sensor is not None and place is not None:
        calibrations = _live(sensor, reference, place, key)
    if as_json:
        print_json({"sensors": [_record(one) for one in calibrations], "kept": place is not None})
    else:
        print_lines(_lines(calibrations, place))


def _from_file(csv: str, place: str | None, key: str | None) -> tuple[Calibration, ...]:
    """Calibrate from a file, with what the robot knows if it is to store the result."""
    pairs = read_pairs(csv)
    calibrations = calibrate(pairs)
    if place is None:
        return calibrations
    with connect(place, key=read_key(key)) as robot:
        names = ["pulse_center", *(name for one in calibrations for name in one.parameters)]
        known = {name: read_parameter(robot, name) for name in names}
        calibrations = calibrate(pairs, pulse_center=known["pulse_center"])
        _keep(robot, calibrations, known)
    return calibrations


def _live(sensor: str, reference: Sequence[float] | None, place: str, key: str | None) -> tuple[Calibration, ...]:
    """Calibrate a sensor or a servo's zero, step by step."""
    kind, index = parse_sensor(sensor)
    references = _references(kind, reference)
    with connect(place, key=read_key(key)) as robot:
        sensed = [f"{kind}_zero_{index}", f"{kind}_scale_{index}"]
        names = [f"servo_trim_{index}", "pulse_per_rad"] if kind == "servo" else sensed
        known = {name: read_parameter(robot, name) for name in names}
        live = _servo_live if kind == "servo" else _sensor_live
        calibrations = live(robot, sensor, references, known)
        _keep(robot, calibrations, known)
    return calibrations


def _record(one: Calibration) -> dict[str, Any]:
    """Return the JSON record of a calibration."""
    unit, factor = KINDS[parse_sensor(one.sensor)[0]]
    return {
        "sensor": one.sensor,
        "points": one.points,
        f"rms_{unit.lower()}": one.rms * factor,
        "parameters": one.parameters,
    }


def _lines(calibrations: Sequence[Calibration], place: str | None) -> Iterator[Any]:
    """Lay out calibrations."""
    rows = []
    for one in calibrations:
        unit, factor = KINDS[parse_sensor(one.sensor)[0]]
        parameters = ", ".join(f"{name} = {value:.7g}" for name, value in one.parameters.items())
        rows.append((one.sensor, f"{one.points}", f"{one.rms * factor:.3g} {unit}", parameters))
    yield table(["sensor", "points", "rms", "parameters"], rows, left=range(4))
    yield "The robot keeps them." if place else "Nothing was sent: --connect sends them to a robot.", "dim"


def _references(kind: str, values: Sequence[float] | None) -> list[float]:
    """Check the references of a sensor: two at least; of a servo, one angle or none."""
    unit, references = KINDS[kind][0], list(values or [])
    given = ",".join(f"{value:g}" for value in references) or "missing"
    if kind == "servo" and len(references) > 1:
        raise InputError("must be one angle of a servo", key="--at", value=given, fix="write it as --at=2")
    if kind != "servo" and len(set(references)) < 2:
        fix = f"give them in {unit}: --at=-20,0,20"
        raise InputError("must name at least two references", key="--at", value=given, fix=fix)
    return references


def _keep(robot: Client, calibrations: tuple[Calibration, ...], known: Mapping[str, float]) -> None:
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
                raise InputError("must answer", key="standard input", value="at its end", fix="start it in a terminal")
            line += key
    return line.decode(errors="replace").strip()


def _sensor_live(
    robot: Client, sensor: str, references: Sequence[float], known: Mapping[str, float]
) -> tuple[Calibration, ...]:
    """Ask for one reference after another, and average the readings at each."""
    kind, index = parse_sensor(sensor)
    unit, factor = KINDS[kind]
    zero, scale = (known[f"{kind}_{what}_{index}"] for what in ("zero", "scale"))
    pairs: list[Pair] = []
    for value in references:
        _answer(robot, f"bring {sensor} to {value:g} {unit}, hold it, and press Enter")
        reading = _reading(robot, kind, index)
        typer.echo(f"  it shows {reading * factor:.4g} {unit}", err=True)
        pairs.append((sensor, reading / scale + zero, value / factor))
    return calibrate(pairs)


def _reading(robot: Client, kind: str, index: int) -> float:
    """Average the readings of a sensor over SAMPLING seconds [SI]."""
    step = {"bend": math.pi / 18000, "pressure": 100.0, "current": 0.01}[kind]
    each = 2 if kind == "bend" else 4
    field, place = (kind, index) if index < each else (f"{kind}_34", index - each)
    values: list[float] = []
    end = time.monotonic() + SAMPLING
    while time.monotonic() < end or not values:
        for message in robot.poll(0.2):
            if message.get_type() == "HYDRAULICS":
                count = getattr(message, field)[place]
                if count == SILENT:
                    raise InputError("must answer", key=f"{kind}_{index}", value="silent", fix="check its wires")
                values.append(count * step)
        if time.monotonic() > end + 10:
            raise InputError("must come from the robot", key="HYDRAULICS", value="silent", fix="come nearer")
    return sum(values) / len(values)


def _servo_live(
    robot: Client, sensor: str, references: Sequence[float], known: Mapping[str, float]
) -> tuple[Calibration, ...]:
    """Hold the servo at neutral, ask for its angle unless it is given, and subtract it from the trim."""
    name = f"servo_trim_{parse_sensor(sensor)[1]}"
    if references:
        angle = references[0]
    else:
        _answer(robot, "keep clear: Enter arms the robot, and its tail rests at neutral")
        robot.arm()
        try:
            angle = read_number(_answer(robot, f"angle of {sensor} from its neutral mark, in deg"), "angle", "deg")
        finally:
            robot.arm(False)
    trim = known[name] - math.radians(angle) * known["pulse_per_rad"]
    return (Calibration(sensor, {name: trim}, 0.0, 1),)
