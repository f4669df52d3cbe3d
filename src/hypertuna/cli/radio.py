"""The commands `hypertuna radio ...`: a robot's parameters, logs, calibration and missions over the radio."""

import math
import os
import select
import sys
import time
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar, table
from hypertuna.cli.emit import emit
from hypertuna.cli.parsing import Setting
from hypertuna.cli.parsing import number as read_number
from hypertuna.errors import InputError
from hypertuna.io.files import read_bytes, rows_csv
from hypertuna.mission.file import read_mission
from hypertuna.mission.upload import download, upload
from hypertuna.radio.calibration import KINDS, Calibration, Pair, calibrate, parse_sensor, read_pairs
from hypertuna.radio.client import Client, connect
from hypertuna.radio.dialect import SILENT
from hypertuna.radio.log import RadioLogWriter, check_new
from hypertuna.radio.parameters import read_parameter, read_parameters, set_parameter
from hypertuna.ranges import POSITIVE

SAMPLING = 2.0  # s of readings that one reference is taken over
Known = dict[str, float]  # parameters on board before a calibration
STEPS = {"bend": math.pi / 18000, "pressure": 100.0, "current": 0.01}  # SI per count in HYDRAULICS


def _read_key(path: str, _: str) -> bytes:
    """Read a key."""
    fix = "make one: openssl rand -out key 32"
    content = read_bytes(path, fix)
    if len(content) != 32:
        raise InputError("must have 32 bytes", file=path, value=f"{len(content)} long", fix=fix)
    return content


PLACES = "udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/ttyUSB0:9600."
Connect = Annotated[str, opt.text("--connect", PLACES, "PLACE")]
Key = Annotated[
    bytes | None, opt.option(("--key",), "File with the 32-byte key that signs messages.", "FILE", _read_key)
]


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
    pairs: list[Setting] = settings or []
    with connect(place, key=key) as robot:
        values = {name.lower(): set_parameter(robot, name.lower(), value) for name, value in pairs}
        if not values or output is not None:
            with progress_bar("parameters") as progress:
                values = read_parameters(robot, progress)
    emit(
        values,
        record=lambda values: {"parameters": values, "written": output},
        lines=lambda values: (f"{name} = {value:.7g}" for name, value in values.items()),
        csv=lambda values: rows_csv({}, ({"name": name, "value": f"{value:.9g}"} for name, value in values.items())),
        output=output,
        as_json=as_json,
    )


def log_command(
    place: Connect,
    output: Annotated[str, opt.file("-o", "--output", help="Write the log to this .mcap file.", suffixes=(".mcap",))],
    duration: Annotated[
        float | None, opt.number("--duration", "s", "Duration in s. (default: until Ctrl-C)", limits=POSITIVE)
    ] = None,
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Record all that a robot and its tank's camera send, for Foxglove, `identify` and `joint fit`."""
    check_new(output)
    limit = math.inf if duration is None else duration
    with connect(place, key=key) as robot, RadioLogWriter(output, "") as log:
        robot.listener = log.write
        begin, lost = time.monotonic(), None
        with progress_bar("seconds") as progress:
            try:
                while (seconds := time.monotonic() - begin) < limit:
                    list(robot.poll(min(0.2, limit - seconds)))
                    progress(int(seconds), int(min(limit, seconds + 1)))
            except KeyboardInterrupt:
                pass
            except InputError as error:
                lost = error
        seconds = time.monotonic() - begin
    emit(
        sorted(robot.last),
        record=lambda kinds: {"written": output, "messages": log.messages, "kinds": kinds, "seconds": seconds},
        lines=lambda kinds: [f"{log.messages} messages in {seconds:.0f} s: {', '.join(kinds)}"],
        written=(output,),
        as_json=as_json,
    )
    if lost is not None:
        raise lost


def mission_command(
    place: Connect,
    mission: Annotated[
        str, typer.Argument(metavar="MISSION", help="Mission file, or name of a mission that comes with hypertuna.")
    ],
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Send a mission to a robot: it keeps the stored mission until it has all of the new one."""
    items = read_mission(mission).mission
    with connect(place, key=key) as robot, progress_bar("items") as progress:
        upload(robot, items, progress)
        stored = download(robot)
    emit(
        stored,
        record=lambda stored: {"mission": mission, "items": len(stored)},
        lines=lambda stored: [f"{mission}: {len(stored)} items are on board"],
        as_json=as_json,
    )


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
    """Calibrate bend, pressure and current sensors and servos' zeros, from a CSV file or live."""
    if (csv is None) == (sensor is None):
        raise InputError("must be given, or --sensor, and not both", key="--csv", fix="give one of them")
    if sensor is not None and place is None:
        rule, fix = "must name the connection to the robot", "--sensor reads live"
        raise InputError(rule, key="--connect", value="missing", fix=fix)
    pairs = [] if csv is None else read_pairs(csv)
    kind, references = "", []
    if sensor is not None:
        kind, _ = parse_sensor(sensor)
        references = _references(kind, reference)
    calibrations = calibrate(pairs)
    if place is not None:
        with connect(place, key=key) as robot:
            if sensor is None:
                known = _known(robot, ["pulse_center", *(name for one in calibrations for name in one.parameters)])
                calibrations = calibrate(pairs, pulse_center=known["pulse_center"])
            else:
                calibrations, known = (_servo_live if kind == "servo" else _sensor_live)(robot, sensor, references)
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
                raise InputError("must answer", key="standard input", value="at its end", fix="start it in a terminal")
            line += key
    return line.decode(errors="replace").strip()


def _known(robot: Client, names: Sequence[str]) -> dict[str, float]:
    """Read parameters of the robot."""
    return {name: read_parameter(robot, name) for name in names}


def _sensor_live(robot: Client, sensor: str, references: Sequence[float]) -> tuple[tuple[Calibration, ...], Known]:
    """Ask for one reference after another, and average the readings at each."""
    kind, index = parse_sensor(sensor)
    unit, factor = KINDS[kind]
    known = _known(robot, [f"{kind}_zero_{index}", f"{kind}_scale_{index}"])
    zero, scale = known.values()
    pairs: list[Pair] = []
    for value in references:
        _answer(robot, f"bring {sensor} to {value:g} {unit}, hold it, and press Enter")
        reading = _reading(robot, kind, index)
        typer.echo(f"  it shows {reading * factor:.4g} {unit}", err=True)
        pairs.append((sensor, reading / scale + zero, value / factor))
    return calibrate(pairs), known


def _reading(robot: Client, kind: str, index: int) -> float:
    """Average the readings of a sensor over SAMPLING seconds [SI]."""
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
                values.append(count * STEPS[kind])
        if time.monotonic() > end + 10:
            raise InputError("must come from the robot", key="HYDRAULICS", value="silent", fix="come nearer")
    return sum(values) / len(values)


def _servo_live(robot: Client, sensor: str, references: Sequence[float]) -> tuple[tuple[Calibration, ...], Known]:
    """Hold the servo at neutral, ask for its angle unless it is given, and subtract it from the trim."""
    name = f"servo_trim_{parse_sensor(sensor)[1]}"
    known = _known(robot, [name, "pulse_per_rad"])
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
    return (Calibration(sensor, {name: trim}, 0.0, 1),), known
