"""The command `hypertuna fil`."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from hypertuna import _core
from hypertuna.cli.old_console import check_suffix, command_line, print_json, progress_bar, tell_written, whole_number
from hypertuna.cli.old_options import AsJson, Seed, choice
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.errors import InputError
from hypertuna.firmware.boards import BOARDS, missing
from hypertuna.firmware.in_the_loop import PARTS, FirmwareRun, firmware_in_the_loop
from hypertuna.firmware.relay import radio_model
from hypertuna.firmware.scenario import scenario_of

__all__ = ["fil_command"]


def fil_command(
    board: Annotated[str, typer.Option("--board", help="pc, or qemu for an emulated Cortex-M7.")] = "pc",
    scenario: Annotated[
        str,
        typer.Option(
            "--scenario", help="A mission or its file, gait:NAME, lost:NAME, afloat, or random messages without a twin."
        ),
    ] = "random",
    robot: Annotated[
        str | None, typer.Option("--robot", help="Robot that the firmware is made for. (default: the mission's)")
    ] = None,
    ticks: Annotated[
        str | None,
        typer.Option("--ticks", help="Longest run in control ticks. (default: until the mission is done, or 6000)"),
    ] = None,
    seed: Seed = "0",
    radio: Annotated[
        str | None,
        typer.Option(
            "--radio", help="Port of 127.0.0.1 for MAVLink: a pc speaks to it by UDP, qemu listens there for TCP."
        ),
    ] = None,
    air: Annotated[
        str | None,
        typer.Option(
            "--air",
            help="Numbers of a modelled radio between --radio's port, then UDP for every board, and the robot, such as "
            "rate=4800,loss=0.3. (default: a cable)",
        ),
    ] = None,
    real_time: Annotated[bool, typer.Option("--real-time", help="Go no faster than the clock.")] = False,
    black_box: Annotated[
        str | None, typer.Option("--black-box", help="Write the board's black box to this .bin file.")
    ] = None,
    firmware: Annotated[
        str | None, typer.Option("--firmware", help="Folder of the programs. (default: build/firmware)")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Fly the firmware: the twin at sea and the firmware on a board, in lock-step.

    The same firmware runs beside it as a program on this machine, and must answer with the same bits in every tick.
    The exit code is 0 if it did, 1 if not, 2 for bad input.
    """
    choice(board, tuple(BOARDS), "--board")
    check_suffix(black_box, (".bin",), "--black-box")
    if air is not None and radio is None:
        raise InputError("needs a ground station", key="--air", fix="give its port by --radio")
    if (lack := missing(board)) is not None:
        raise InputError("must be able to run here", key="--board", value=board, fix=lack)
    named = load(robot) if robot is not None else None
    given = scenario_of(scenario, named if named is not None or ":" not in scenario else load("hypertuna"))
    fish = named if named is not None else load(given.robot or "hypertuna")
    with progress_bar("ticks") as progress:
        done = firmware_in_the_loop(
            fish,
            given,
            board=board,
            ticks=None if ticks is None else whole_number(ticks, "--ticks"),
            seed=whole_number(seed, "--seed"),
            folder=firmware,
            radio=None if radio is None else whole_number(radio, "--radio"),
            air=None if air is None else radio_model(air),
            real_time=real_time,
            black_box=black_box,
            report=progress,
        )
    if as_json:
        told = {"seed": whole_number(seed, "--seed"), "black_box": black_box, "command": command_line()}
        print_json(_record(done) | told | provenance(fish))
    else:
        _print(done)
        tell_written(black_box)
    if len(done.different):
        raise typer.Exit(1)


def _record(done: FirmwareRun) -> dict[str, Any]:
    """Tell a run, for programs."""
    last = done.answers[-1]
    faults = [row[0] for bit, row in enumerate(_core.fault_table()) if int(last["faults"]) >> bit & 1]
    found: dict[str, Any] = {
        "board": done.board,
        "scenario": done.scenario.name,
        "ticks": done.ticks,
        "mismatches": len(done.different) if done.compared else None,
        "first_mismatch": int(done.different[0]) if len(done.different) else None,
        "instructions_per_tick_max": {part: done.instructions(part) for part in PARTS} if done.counts else None,
        "stack_bytes": int(done.answers["stack"].max()) if done.counts else None,
        "real_time_factor": done.real_time_factor,
        "air": done.air or None,
        "refused": {reason: len(ticks) for reason, ticks in done.refused.items()},
        "mode": _core.mode_names()[last["mode"]],
        "armed": bool(last["armed"]),
        "faults": faults,
    }
    if done.flown is not None:
        found |= {"status": done.status, "distance_m": done.flown.distance, "energy_wh": done.flown.energy / 3600}
    return found


def _print(done: FirmwareRun) -> None:
    """Print a run."""
    console = Console()
    record = _record(done)
    console.print(Text(f"{done.scenario.name} on {done.board}: {done.ticks} ticks", style="bold"))
    lines = {"real-time factor": f"{done.real_time_factor:.1f}"}
    if record["instructions_per_tick_max"] is not None:
        most = record["instructions_per_tick_max"]
        lines["instructions in a tick at most"] = ", ".join(f"{part} {value:.0f}" for part, value in most.items())
        lines["stack at most"] = f"{record['stack_bytes']} bytes"
    if done.flown is not None:
        ended = f"{record['status']}, " if record["status"] is not None else ""
        lines["at the end"] = f"{ended}{record['distance_m']:.1f} m over ground, mode {record['mode']}"
    for side, came in done.air.items():
        lost = f"{came['sent']} packets, {came['lost']} lost, {came['damaged']} damaged"
        lines[f"radio of the {side}"] = f"{lost}, {came['dropped']} bytes dropped"
    lines["faults at the end"] = ", ".join(record["faults"]) or "none"
    for label, value in lines.items():
        console.print(Text(f"{label}: {value}"))
    for reason, ticks in done.refused.items():
        told = f"orders refused, {reason}: {len(ticks)}, first in tick {ticks[0]}"
        console.print(Text(told, style="dim" if done.flown is None else "yellow"))
    if not done.compared:
        console.print(Text("Not compared: orders over the radio reach the board alone.", style="dim"))
    elif len(done.different):
        told = f"The board differs from the program on this machine in {len(done.different)} ticks, first in"
        console.print(Text(f"{told} tick {done.different[0]}.", style="bold red"))
    else:
        console.print(Text("Every tick has the same bits as the program on this machine.", style="green"))
