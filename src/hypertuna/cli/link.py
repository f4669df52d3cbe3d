"""The commands `hypertuna link ...`: a robot's parameters, logs, calibration and missions over the radio."""

from __future__ import annotations

import math
import os
import select
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import check_suffix, number, print_json, progress_bar, tell_written
from hypertuna.errors import InputError
from hypertuna.io.files import write_atomically
from hypertuna.mission.file import read_mission
from hypertuna.mission.upload import download, upload
from hypertuna.radio.calibration import KINDS, Calibration, Pair, calibrate, read_pairs, sensor_of
from hypertuna.radio.client import Client, connect
from hypertuna.radio.dialect import SILENT, need_radio
from hypertuna.radio.log import LinkLogWriter, check_new
from hypertuna.radio.parameters import read_parameter, read_parameters, set_parameter

__all__ = ["FLUSH", "Connect", "Key", "link_app", "read_key"]

link_app = typer.Typer(no_args_is_help=True, help="A robot over the radio: needs the extra radio, and log for logs.")

Connect = Annotated[
    str, typer.Option("--connect", help="udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/ttyUSB0:9600.")
]
Key = Annotated[str | None, typer.Option("--key", help="File of 32 bytes to sign with.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
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
    settings: Annotated[list[str] | None, typer.Option("--set", help="NAME=VALUE in SI; again for more.")] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write them to this .csv file.")] = None,
    key: Key = None,
    as_json: AsJson = False,
) -> None:
    """Read a robot's parameters, or set some; the robot keeps them. It must be disarmed for that."""
    need_radio()
    check_suffix(output, (".csv",), "--output")
    wished = [_setting(text) for text in settings or []]
    with connect(place, key=read_key(key)) as robot:
        taken = {name: set_parameter(robot, name, value) for name, value in wished}
        if taken and output is None:
            found = taken
        else:
            with progress_bar("parameters") as progress:
                found = read_parameters(robot, progress)
    if output is not None:
        rows = [f"{name},{value:.9g}" for name, value in found.items()]
        write_atomically(output, "\n".join(["name,value", *rows, ""]).encode())
    if as_json:
        print_json({"parameters": found, "written": output})
        return
    for name, value in found.items():
        typer.echo(f"{name} = {value:.7g}")
    tell_written(output)


@link_app.command("log")
def log_command(
    place: Connect,
    output: Annotated[str, typer.Option("-o", "--output", help="Log to write, .mcap.")],
    duration: Annotated[str | None, typer.Option("--duration", help="Seconds (default: until Ctrl-C).")] = None,
    key: Key = None,
    as_json: AsJson = False,
) -> None:
    """Record all that a robot and its tank's camera send, for Foxglove, `identify` and `actuator fit`."""
    need_radio()
    check_suffix(output, (".mcap",), "--output")
    check_new(output)
    most = math.inf if duration is None else number(duration, "--duration", "s")
    if most <= 0:
        raise InputError("must be positive", key="--duration", value=f"{most:g}", fix="give seconds")
    with connect(place, key=read_key(key)) as robot, LinkLogWriter(output, "") as log:
        robot.listener = log.write
        begun, lost = time.monotonic(), None
        with progress_bar("seconds") as progress:
            try:
                _record_all(robot, log, begun + most, lambda done: progress(done, int(min(most, done + 1))))
            except KeyboardInterrupt:
                pass
            except InputError as error:
                lost = error
        facts = {"messages": log.messages, "kinds": sorted(robot.last), "seconds": time.monotonic() - begun}
    if as_json:
        print_json({"written": output, **facts})
    else:
        typer.echo(f"{facts['messages']} messages in {facts['seconds']:.0f} s: {', '.join(sorted(robot.last))}")
        tell_written(output)
    if lost is not None:
        raise lost


def _record_all(robot: Client, log: LinkLogWriter, end: float, report: Callable[[int], None]) -> None:
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
    file: Annotated[str, typer.Argument(metavar="MISSION", help="Mission file, or name of one that comes along.")],
    key: Key = None,
    as_json: AsJson = False,
) -> None:
    """Send a mission to a robot: it has the old one until it has all of the new."""
    need_radio()
    mission = read_mission(file).mission
    with connect(place, key=read_key(key)) as robot, progress_bar("items") as progress:
        upload(robot, mission, progress)
        count = len(download(robot))
    print_json({"mission": file, "items": count}) if as_json else typer.echo(f"{file}: {count} items are on board")


@link_app.command("calibrate")
def calibrate_command(
    csv: Annotated[str | None, typer.Option("--csv", help="Rows of sensor, counts, reference.")] = None,
    sensor: Annotated[
        str | None, typer.Option("--sensor", help="Live: bend_0, pressure_3, current_1, servo_5.")
    ] = None,
    reference: Annotated[
        str | None,
        typer.Option(
            "--at",
            help="Live: references such as -20,0,20 in deg, kPa or A; of a servo, the angle that was read at neutral.",
        ),
    ] = None,
    place: Annotated[str | None, typer.Option("--connect", help="Robot that is to keep it, and to read live.")] = None,
    key: Key = None,
    as_json: AsJson = False,
) -> None:
    """Calibrate bend, pressure and current sensors and servos' zeros, from a CSV file or live, step by step."""
    if (csv is None) == (sensor is None):
        raise InputError("must be given, or --sensor, and not both", key="--csv", fix="give one of them")
    if sensor is not None and place is None:
        raise InputError("must say where the robot is", key="--connect", value="missing", fix="--sensor reads live")
    if csv is not None:
        pairs = read_pairs(csv)
        found = calibrate(pairs)
        if place is not None:
            with connect(place, key=read_key(key)) as robot:
                names = ["pulse_center", *(name for one in found for name in one.parameters)]
                known = {name: read_parameter(robot, name) for name in names}
                found = calibrate(pairs, pulse_center=known["pulse_center"])
                _keep(robot, found, known)
    else:
        assert sensor is not None
        assert place is not None
        kind, index = sensor_of(sensor)
        references = _references(kind, reference)
        with connect(place, key=read_key(key)) as robot:
            sensed = [f"{kind}_zero_{index}", f"{kind}_scale_{index}"]
            names = [f"servo_trim_{index}", "pulse_per_rad"] if kind == "servo" else sensed
            known = {name: read_parameter(robot, name) for name in names}
            live = _servo_live if kind == "servo" else _sensor_live
            found = live(robot, sensor, references, known)
            _keep(robot, found, known)
    if as_json:
        print_json({"sensors": [_record(one) for one in found], "kept": place is not None})
        return
    table = Table("sensor", "points", "rms", "parameters", box=None, pad_edge=False, header_style="bold")
    for one in found:
        unit, factor = KINDS[sensor_of(one.sensor)[0]]
        told = ", ".join(f"{name} = {value:.7g}" for name, value in one.parameters.items())
        table.add_row(one.sensor, f"{one.points}", f"{one.rms * factor:.3g} {unit}", told)
    console = Console()
    console.print(table)
    kept = "The robot keeps them." if place is not None else "Nothing was sent: --connect sends them to a robot."
    console.print(Text(kept, style="dim"))


def _record(one: Calibration) -> dict[str, Any]:
    """Tell a calibration, for programs."""
    unit, factor = KINDS[sensor_of(one.sensor)[0]]
    return {
        "sensor": one.sensor,
        "points": one.points,
        f"rms_{unit.lower()}": one.rms * factor,
        "parameters": one.parameters,
    }


def _references(kind: str, text: str | None) -> list[float]:
    """Read where a sensor is brought to: two places at least; for a servo the one that it was found at, or none."""
    unit = KINDS[kind][0]
    values = [] if text is None else [number(part, "--at", unit) for part in text.split(",")]
    if kind == "servo" and len(values) > 1:
        raise InputError("must be one angle of a servo", key="--at", value=str(text), fix="write it as --at=2")
    if kind != "servo" and len(set(values)) < 2:
        fix = f"give them in {unit}: --at=-20,0,20"
        raise InputError("must name two references at least", key="--at", value=text or "missing", fix=fix)
    return values


def _setting(text: str) -> tuple[str, float]:
    """Read NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not equals or not name:
        fix = "write it as proportional=0.2"
        raise InputError("must be NAME=VALUE", key="--set", value=text, fix=fix)
    return name.strip().lower(), number(value, f"--set {name}", "SI")


def _keep(robot: Client, found: tuple[Calibration, ...], known: Mapping[str, float]) -> None:
    """Send what was found: all of it, or what the robot had before."""
    kept: list[str] = []
    try:
        for name, value in ((name, value) for one in found for name, value in one.parameters.items()):
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
    """Ask, and go on listening to the robot until a line comes: it hears us, and no old reading is left over."""
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
    """Ask for one reference after another, and take the readings' mean at each."""
    kind, index = sensor_of(sensor)
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
    """Mean of a sensor's readings over some time [SI]."""
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
    """Hold the servo at its neutral, ask where it stands unless that is known, and take it off."""
    name = f"servo_trim_{sensor_of(sensor)[1]}"
    if references:
        angle = references[0]
    else:
        _answer(robot, "keep clear: Enter arms the robot, and its tail rests at neutral")
        robot.arm()
        try:
            angle = number(_answer(robot, f"angle of {sensor} from its neutral mark, in deg"), "angle", "deg")
        finally:
            robot.arm(False)
    trim = known[name] - math.radians(angle) * known["pulse_per_rad"]
    return (Calibration(sensor, {name: trim}, 0.0, 1),)
