"""The commands `hypertuna radio params | log | mission`."""

import math
import time
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.cli.parsing import Setting
from hypertuna.errors import InputError
from hypertuna.io.files import read_bytes, rows_csv
from hypertuna.mission.file import read_mission
from hypertuna.mission.upload import download, upload
from hypertuna.radio.client import connect
from hypertuna.radio.log import RadioLogWriter, check_new
from hypertuna.radio.parameters import read_parameters, set_parameter
from hypertuna.radio.samples import set_interval
from hypertuna.ranges import POSITIVE


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
    rates: Annotated[
        list[Any] | None, opt.setting("--rate", "Hz", "Message to request at a rate, such as RAW_IMU=10; repeatable.")
    ] = None,
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Record all that a robot and its tank's camera send, for Foxglove, `identify` and `joint fit`."""
    check_new(output)
    requested: list[Setting] = rates or []
    limit = math.inf if duration is None else duration
    with connect(place, key=key) as robot, RadioLogWriter(output, "") as log:
        robot.listener = log.write
        for name, rate in requested:
            set_interval(robot, name, 1 / POSITIVE.check(rate, "--rate", "give it in Hz"))
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
