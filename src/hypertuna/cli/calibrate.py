"""The command `hypertuna radio calibrate`: sensors and servos of a robot, from a file or live."""

import os
import select
import sys
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit
from hypertuna.cli.parsing import number as read_number
from hypertuna.cli.radio import Key
from hypertuna.display import Table
from hypertuna.errors import InputError
from hypertuna.firmware.black_box import read_black_box
from hypertuna.radio.calibration import AXES, KINDS, SINGLE, Calibration, calibrate, parse_sensor, read_pairs
from hypertuna.radio.calibration_procedure import (
    calibrate_live,
    calibrate_log,
    calibrate_readings,
    known_parameters,
    store,
)
from hypertuna.radio.client import Client, connect
from hypertuna.radio.parameters import read_parameter
from hypertuna.radio.samples import check_disarmed

BOX_SUFFIX = ".bin"  # of black-box files
ONE_REFERENCE = ("servo", "voltage")  # kinds of sensor that a single reference calibrates


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
    if log is not None and place is None and log.endswith(BOX_SUFFIX):
        fix = "give it, because a black box has readings by the robot's present calibration"
        raise InputError("must name the connection to the robot", key="--connect", value="missing", fix=fix)
    references = [] if sensor is None else _references(sensor, reference)
    calibrations: tuple[Calibration, ...] = ()
    if csv is not None:
        calibrations = calibrate(read_pairs(csv))
    elif log is not None and not log.endswith(BOX_SUFFIX):
        calibrations = (calibrate_log(log),)
    if place is not None:
        with connect(place, key=key) as robot:
            check_disarmed(robot)
            if sensor is not None:
                calibrations, known = calibrate_live(robot, Terminal(), sensor, references)
            elif log is not None and log.endswith(BOX_SUFFIX):
                ticks = read_black_box(log)[-1].ticks  # of the last boot
                calibrations, known = calibrate_readings(robot, ticks["field_read"], ticks["acceleration_read"])
            else:
                known = known_parameters(robot, [name for one in calibrations for name in one.parameters])
            if csv is not None:
                calibrations = calibrate(read_pairs(csv), pulse_center=read_parameter(robot, "pulse_center"))
            store(robot, calibrations, known)
    emit(
        calibrations,
        record=lambda calibrations: {"sensors": [one.record() for one in calibrations], "kept": place is not None},
        lines=lambda calibrations: _lines(calibrations, place),
        as_json=as_json,
    )


def _lines(calibrations: Sequence[Calibration], place: str | None) -> Iterator[Any]:
    """Yield the lines that the terminal prints for calibrations."""
    rows = []
    for calibration in calibrations:
        parameters = ", ".join(f"{name} = {value:.7g}" for name, value in calibration.parameters.items())
        residual, unit = calibration.reading
        rows.append((calibration.sensor, f"{calibration.points}", f"{residual:.3g} {unit}", parameters))
    yield Table(["sensor", "points", "rms", "parameters"], rows, left=range(4))
    for calibration in calibrations:
        yield from (f"{calibration.sensor}: {note}" for note in calibration.notes)
    yield "The robot keeps them." if place else "Nothing was sent: --connect sends them to a robot.", "dim"


def _references(sensor: str, values: Sequence[float] | None) -> list[float]:
    """Check the number of a sensor's references, and return them.

    Two are needed; a voltage needs one above 0, depth and a servo need none, sensors with axes must have none.
    """
    kind = "servo" if sensor == "servo" else parse_sensor(sensor)[0]
    unit, references = KINDS[kind][0], list(values or [])
    typed = ",".join(f"{value:g}" for value in references) or "missing"
    if kind in AXES or sensor == "servo":
        if references:
            raise InputError(f"must not be given for {sensor}", key="--at", value=typed, fix="leave it out")
        return []
    if kind == "servo" and len(references) > 1:
        raise InputError("must be one angle of a servo", key="--at", value=typed, fix="write it as --at=2")
    if not (kind in ONE_REFERENCE or (kind == "depth" and not references)) and len(set(references)) < 2:
        fix = f"give them in {unit}: --at={'0,1.5' if kind == 'depth' else '-20,0,20'}"
        raise InputError("must name at least two references", key="--at", value=typed, fix=fix)
    if kind == "voltage" and (not references or references[0] <= 0):
        fix = "measure it at the battery: --at=16.2"
        raise InputError("must be a voltage above 0", key="--at", value=typed, fix=fix)
    return references


class Terminal:
    """The operator at a terminal."""

    def ask(self, robot: Client, question: str) -> str:
        """Ask a question and return the typed line; read the robot's messages meanwhile, so that none waits unread."""
        self.tell(question, end=": ")
        line, input_ = b"", sys.stdin.fileno()
        while not line.endswith(b"\n"):
            list(robot.poll(0.1))
            while not line.endswith(b"\n") and select.select([input_], [], [], 0)[0]:
                if not (key := os.read(input_, 1)):
                    self.tell("")
                    fix = "run it in a terminal"
                    raise InputError("must answer", key="standard input", value="at its end", fix=fix)
                line += key
        return line.decode(errors="replace").strip()

    def ask_number(self, robot: Client, question: str, key: str, unit: str) -> float:
        """Ask a question, and return the number that the operator types in `unit`; key: the number's name in errors."""
        return read_number(self.ask(robot, question), key, unit)

    def tell(self, text: str, *, end: str = "\n") -> None:
        """Show a text on the standard error."""
        typer.echo(f"{text}{end}", nl=False, err=True)
