"""The commands `hypertuna radio params | log | mission | check | sign`."""

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.cli.parsing import Setting
from hypertuna.display import Table
from hypertuna.errors import InputError
from hypertuna.io.door import KINDS, read_bytes
from hypertuna.io.files import rows_csv
from hypertuna.mission.file import read_mission
from hypertuna.mission.geodesy import declination
from hypertuna.mission.upload import download, upload
from hypertuna.radio.check import Readiness, check_ready
from hypertuna.radio.client import connect
from hypertuna.radio.log import RadioLogWriter, check_new
from hypertuna.radio.parameters import read_parameters, set_parameter
from hypertuna.radio.samples import check_disarmed, set_interval
from hypertuna.ranges import POSITIVE


def _read_key(path: str, _: str) -> bytes:
    """Return the key of 32 bytes from a file."""
    content = read_bytes(path, "key")
    if len(content) != 32:
        raise InputError("must have 32 bytes", file=path, value=f"{len(content)} bytes long", fix=KINDS["key"].fix)
    return content


# Forms of the radio's address, for help texts and errors
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
    output: Annotated[str | None, opt.file("--output", "the parameters", ".csv")] = None,
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
    output: Annotated[str, opt.file("--output", "the log", ".mcap")],
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
        dict(sorted(log.counts.items())),
        record=lambda counts: {"written": output, "messages": counts, "seconds": seconds},
        lines=lambda counts: [f"messages in {seconds:.0f} s: {', '.join(f'{name} {n}' for name, n in counts.items())}"],
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
    file, note = read_mission(mission), ""
    items = file.mission
    if file.origin is not None and file.declination is None:
        items = replace(items, declination=declination(file.origin))
        note = f", declination {math.degrees(items.declination):.1f} deg by the World Magnetic Model"
    with connect(place, key=key) as robot, progress_bar("items") as progress:
        upload(robot, items, progress)
        stored = download(robot)
    emit(
        stored,
        record=lambda stored: {"mission": mission, "items": len(stored)},
        lines=lambda stored: [f"{mission}: {len(stored)} items are on board{note}"],
        as_json=as_json,
    )


def check_command(place: Connect, key: Key = None, as_json: opt.AsJson = False) -> None:
    """Check whether a disarmed robot may be armed: its faults, and what its sensors read. Exit code 1 if it may not."""
    with connect(place, key=key) as robot:
        readiness = check_ready(robot)
    emit(readiness, record=Readiness.record, lines=_readiness_lines, as_json=as_json, failed=not readiness.ready)


def _readiness_lines(found: Readiness) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a check before arming."""
    if found.faults:
        rows = [(name, sentence, "yes" if forbids else "") for name, sentence, forbids in found.faults]
        yield Table(["fault", "meaning", "forbids arming"], rows, left=range(3))
    heading, roll, pitch = (math.degrees(angle) for angle in (found.heading, found.roll, found.pitch))
    yield f"battery {found.voltage:.2f} V, depth {found.depth:.2f} m"
    yield f"heading {heading:.0f} deg, roll {roll:.0f} deg to starboard, nose {pitch:.0f} deg up"
    yield from (f"not ready: {reason}" for reason in found.reasons)
    yield ("The robot may be armed.", "bold") if found.ready else ("The robot may not be armed.", "bold")


def sign_command(
    place: Connect,
    new: Annotated[
        str | None, typer.Argument(metavar="FILE", help="File with the new key of 32 bytes; without it, --off.")
    ] = None,
    off: Annotated[bool, opt.flag("--off", "Delete the key: the robot accepts unsigned messages again.")] = False,
    key: Key = None,
    as_json: opt.AsJson = False,
) -> None:
    """Give a disarmed robot the key that signs messages, on the bench: the key travels in the clear.

    A robot that has a key already needs it: --key OLD.
    """
    if (new is None) is not off:
        raise InputError("or --off must be given", key="FILE", fix="make a key: openssl rand -out key 32")
    secret = bytes(32) if new is None else _read_key(new, "FILE")
    with connect(place, key=key) as robot:
        check_disarmed(robot)
        robot.begin_signing(secret) if new is not None else robot.end_signing()
    emit(
        new,
        record=lambda new: {"signed": new is not None, "key": new},
        lines=lambda new: [f"The robot accepts messages signed by {new} only." if new else "The robot has no key."],
        as_json=as_json,
    )
