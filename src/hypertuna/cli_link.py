"""The commands `hypertuna link ...`: a robot's parameters, logs, calibration and missions over the radio."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.console import check_suffix, number, print_json, progress_bar, tell_written
from hypertuna.dialect import need_radio
from hypertuna.errors import InputError, did_you_mean
from hypertuna.link_calibrate import KINDS, Calibration, Pair, calibrate, read_pairs, sensor_of
from hypertuna.link_client import Client, connect
from hypertuna.link_log import LinkLogWriter
from hypertuna.mission_file import read_mission
from hypertuna.results import write_atomically

__all__ = ["Connect", "Key", "link_app", "read_key"]

link_app = typer.Typer(no_args_is_help=True, help="A robot over the radio: needs the extra radio, and log for logs.")

Connect = Annotated[
    str, typer.Option("--connect", help="udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/ttyUSB0:9600.")
]
Key = Annotated[str | None, typer.Option("--key", help="File of 32 bytes to sign with.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
SAMPLING = 2.0  # s of readings that one reference is taken over


def read_key(path: str | None) -> bytes | None:
    """Read a key.

    Parameters
    ----------
    path : str or None

    Returns
    -------
    bytes or None

    Raises
    ------
    InputError
        If it has another length than 32.
    """
    if path is None:
        return None
    content = Path(path).read_bytes()
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
        taken = {name: robot.set_parameter(name, value) for name, value in wished}
        if taken and output is None:
            found = taken
        else:
            with progress_bar("parameters") as progress:
                found = robot.parameters(progress)
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
    most = math.inf if duration is None else number(duration, "--duration", "s")
    with LinkLogWriter(output, "") as log, connect(place, key=read_key(key), listener=log.write) as robot:
        begun = last = time.monotonic()
        with progress_bar("seconds") as progress:
            try:
                while (now := time.monotonic()) - begun < most:
                    list(robot.poll(min(0.2, begun + most - now)))
                    if now - last > 2:
                        last = now
                        log.flush()
                        progress(int(now - begun), int(most) if most < math.inf else int(now - begun) + 1)
            except KeyboardInterrupt:
                pass
        facts = {"messages": log.messages, "kinds": sorted(robot.last), "seconds": time.monotonic() - begun}
    if as_json:
        print_json({"written": output, **facts})
        return
    typer.echo(f"{facts['messages']} messages in {facts['seconds']:.0f} s: {', '.join(sorted(robot.last))}")
    tell_written(output)


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
        robot.upload(mission, progress)
        count = len(robot.download())
    print_json({"mission": file, "items": count}) if as_json else typer.echo(f"{file}: {count} items are on board")


@link_app.command("calibrate")
def calibrate_command(
    csv: Annotated[str | None, typer.Option("--csv", help="Rows of sensor, counts, reference.")] = None,
    sensor: Annotated[
        str | None, typer.Option("--sensor", help="Live: bend_0, pressure_3, current_1, servo_5.")
    ] = None,
    reference: Annotated[
        str | None, typer.Option("--at", help="Live: references such as -20,0,20 in deg, kPa or A.")
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
        found = calibrate(read_pairs(csv))
        if place is not None:
            with connect(place, key=read_key(key)) as robot:
                _keep(robot, found)
    else:
        assert sensor is not None
        assert place is not None
        kind, index = sensor_of(sensor)
        with connect(place, key=read_key(key)) as robot:
            found = _servo_live(robot, index) if kind == "servo" else _sensor_live(robot, sensor, reference)
            _keep(robot, found)
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
    return {"sensor": one.sensor, "points": one.points, f"rms_{unit}": one.rms * factor, "parameters": one.parameters}


def _setting(text: str) -> tuple[str, float]:
    """Read NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not equals or not name:
        fix = "write it as proportional=0.2"
        raise InputError("must be NAME=VALUE", key="--set", value=text, fix=fix)
    return name.strip().lower(), number(value, f"--set {name}", "SI")


def _keep(robot: Client, found: tuple[Calibration, ...]) -> None:
    """Send what was found."""
    for one in found:
        for name, value in one.parameters.items():
            robot.set_parameter(name, value)


def _sensor_live(robot: Client, sensor: str, reference: str | None) -> tuple[Calibration, ...]:
    """Ask for one reference after another, and take the readings' mean at each."""
    kind, index = sensor_of(sensor)
    unit, factor = KINDS[kind]
    if reference is None:
        raise InputError("must name references", key="--at", value="missing", fix=f"give them in {unit}: -20,0,20")
    known = robot.parameters()
    names = (f"{kind}_zero_{index}", f"{kind}_scale_{index}")
    for name in names:
        if name not in known:
            raise InputError("must be a parameter of the robot", key=name, fix=did_you_mean(name, known))
    zero, scale = (known[name] for name in names)
    pairs: list[Pair] = []
    for text in reference.split(","):
        value = number(text, "--at", unit)
        typer.prompt(f"bring {sensor} to {value:g} {unit}, hold it, and press Enter", default="", show_default=False)
        pairs.append((sensor, _reading(robot, kind, index) / scale + zero, value / factor))
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
                values.append(getattr(message, field)[place] * step)
        if time.monotonic() > end + 10:
            raise InputError("must come from the robot", key="HYDRAULICS", value="silent", fix="come nearer")
    return sum(values) / len(values)


def _servo_live(robot: Client, index: int) -> tuple[Calibration, ...]:
    """Hold the servo at its neutral, ask where it stands, and take that off."""
    known = robot.parameters()
    name = f"servo_trim_{index}"
    if name not in known:
        raise InputError("must be a parameter of the robot", key=name, fix=did_you_mean(name, known))
    typer.prompt("the tail is armed and rests: keep clear, and press Enter", default="", show_default=False)
    robot.arm()
    try:
        text = typer.prompt(f"angle of servo {index} from its neutral mark, in deg")
        angle = math.radians(number(text, "angle", "deg"))
    finally:
        robot.arm(False)
    trim = known[name] - angle * known["pulse_per_rad"]
    return (Calibration(f"servo_{index}", {name: trim}, 0.0, 1),)
