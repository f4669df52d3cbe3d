"""The commands `hypertuna firmware params | wiring | faults`."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna import _core
from hypertuna.cli import options as opt
from hypertuna.cli.console import print_json, print_lines, print_written
from hypertuna.cli.emit import emit, made_by
from hypertuna.display import Table
from hypertuna.firmware.header import header
from hypertuna.firmware.parameters import FirmwareTable, firmware_table
from hypertuna.firmware.wiring import Wire, Wiring, wiring_of
from hypertuna.io.door import read_text
from hypertuna.io.files import rows_csv, write_atomically

firmware_app = opt.group("Firmware: parameters and wiring from a robot's description, list of faults.")


@firmware_app.command()
@opt.grouped
def params(
    robot: opt.RobotOptions,
    output: Annotated[str | None, opt.file("--output", "the C++ header of the firmware", ".hpp")] = None,
    check: Annotated[
        str | None,
        opt.text("--check", "Compare this .hpp file with the description; exit code 1 if it differs.", "FILE"),
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """List the parameters that the radio may set on a robot, and write all that its firmware is built with.

    firmware/robots/NAME.hpp is where `make firmware ROBOT=NAME` looks for them.
    """
    parameters = firmware_table(robot.load())
    if output is not None:
        write_atomically(output, header(parameters).encode())
    if as_json:
        print_json(_record(parameters))
    elif output is None and check is None:
        print_lines(_lines(parameters))
    else:
        print_written(output)
    if check is None:
        return
    if read_text(check, "header") != header(parameters):
        fix = f"write it again with hypertuna firmware params --robot {robot} -o {check}"
        typer.echo(f"{check} differs: {fix}", err=True)
        raise typer.Exit(1)
    if not as_json:
        print(f"{check} matches the description")


@firmware_app.command()
@opt.grouped
def wiring(
    robot: opt.RobotOptions,
    output: Annotated[str | None, opt.file("--output", "the table", ".csv")] = None,
    plot: opt.Plot = None,
    as_json: opt.AsJson = False,
) -> None:
    """List the used pins of a robot's board: part, signal, level, bus, and the resistors of the battery's divider."""
    emit(
        wiring_of(robot.load()),
        record=_wiring_record,
        lines=_wiring_lines,
        csv=lambda wiring: rows_csv({}, _wires(wiring)),
        output=output,
        plot=plot,
        as_json=as_json,
    )


@firmware_app.command()
def faults(as_json: opt.AsJson = False) -> None:
    """List the faults that the supervisor on board detects, and the response of the robot to each."""
    keys = ("name", "sentence", "answer", "latched", "forbids_arming", "severity", "choice")
    rows: list[dict[str, Any]] = [dict(zip(keys, row, strict=True)) for row in _core.fault_table()]
    heads = ["fault", "meaning", "answer", "latched", "forbids arming", "severity", "answer chosen by"]
    cells = [
        [*map(row.get, keys[:3]), *("yes" if row[key] else "" for key in keys[3:5]), row[keys[5]], row[keys[6]]]
        for row in rows
    ]
    table = Table(heads, cells, left=range(7))
    emit(rows, record=lambda rows: {"faults": rows}, lines=lambda _: [table], as_json=as_json)


def _wires(wiring: Wiring) -> list[dict[str, Any]]:
    """Return the wires as rows of the JSON record."""
    return [{("rate_bit_s" if key == "rate" else key): value for key, value in wire._asdict().items()}
            for wire in wiring.wires]  # fmt: skip


def _wiring_record(wiring: Wiring) -> dict[str, Any]:
    """Return the JSON record of a robot's wiring."""
    divider = {f"{name}_ohm": value for name, value in wiring.divider._asdict().items()}
    return {"wires": _wires(wiring), "battery_divider": divider} | made_by(wiring.robot)


def _wiring_lines(wiring: Wiring) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a robot's wiring."""
    yield Table(
        ["pin", "part", "signal", "bus", "range"],
        [(f"{w.pin}", w.part, w.signal, _bus(w), w.range) for w in wiring.wires],
        left=range(1, 5),
    )
    analog = next(wire.level for wire in wiring.wires if wire.bus == "analog")
    yield f"analog: {analog} over the range; servos and serial lines: 0 or 3.3 V"
    pin = next(wire.pin for wire in wiring.wires if wire.signal == "voltage")
    upper, lower, lift = (f"{ohm / 1e3:g} kohm" for ohm in wiring.divider)
    yield f"voltage divider: {upper} from the battery, {lower} to ground, {lift} to 3.3 V, all at pin {pin}"
    yield "No pin takes more than 3.3 V: a part of 5 V needs a divider or a level shifter.", "bold"


def _bus(wire: Wire) -> str:
    """Return the name of a wire's bus, with its rate if it has one."""
    return f"{wire.bus}, {wire.rate}" if wire.rate else wire.bus


def _record(parameters: FirmwareTable) -> dict[str, Any]:
    """Return the JSON record of the firmware's parameters."""
    return {
        "numbers": len(parameters.values),
        "layout": f"{parameters.layout:08x}",
        "parameters": [
            {"name": p.name, "low": p.low, "high": p.high, "value": p.standard, "whole": p.whole}
            | dict(zip(("part", "column", "index"), parameters.fields[p.field], strict=True))
            for p in parameters.parameters
        ],
    } | made_by(parameters.robot)


def _lines(parameters: FirmwareTable) -> Iterator[Any]:
    """Yield the lines that the terminal prints for the firmware's parameters."""
    rows = []
    for p in parameters.parameters:
        struct, column, index = parameters.fields[p.field]
        rows.append((p.name, f"{p.standard:.6g}", f"{p.low:.6g}", f"{p.high:.6g}", f"{struct} {column}[{index}]"))
    total, settable = len(parameters.values), len(parameters.parameters)
    yield f"{parameters.robot.name}: {total} numbers on board, {settable} of them parameters (SI)", "bold"
    yield Table(["parameter", "value", "low", "high", "of"], rows, left=(0, 4))
