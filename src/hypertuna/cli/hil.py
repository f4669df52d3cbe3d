"""The command `hypertuna hil`."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated, Any

import typer

from hypertuna import _core
from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit, made_by
from hypertuna.errors import InputError
from hypertuna.firmware.boards import BOARDS, missing
from hypertuna.firmware.failures import FAILURES
from hypertuna.firmware.in_the_loop import PARTS, FirmwareRun, firmware_in_the_loop
from hypertuna.firmware.relay import radio_model
from hypertuna.firmware.scenario import find_scenario
from hypertuna.mission.checks import check_current

TUNA = "hypertuna"  # the robot that flies scenarios that name none


@opt.grouped
def hil_command(
    robot: opt.MissionRobot,
    board: Annotated[str, opt.word("--board", tuple(BOARDS), "pc, or qemu for an emulated Cortex-M7.")] = "pc",
    scenario: Annotated[
        str,
        opt.text(
            "--scenario", "A mission or its file, gait:NAME, lost:NAME, afloat, or random messages without a twin."
        ),
    ] = "random",
    ticks: Annotated[
        int | None,
        opt.whole_number("--ticks", "Maximum run in control ticks. (default: until the mission is complete, or 6000)"),
    ] = None,
    seed: opt.Seed = 0,
    radio: Annotated[
        int | None,
        opt.whole_number(
            "--radio",
            "Port of 127.0.0.1 for MAVLink: the board pc sends UDP to it, the board qemu listens on it for TCP.",
        ),
    ] = None,
    air: Annotated[
        str | None,
        opt.text(
            "--air",
            "Parameters of a modeled radio between the robot and the port of --radio (then UDP for every board), such "
            "as rate=4800,loss=0.3. (default: a cable)",
        ),
    ] = None,
    fault: Annotated[
        list[str] | None,
        opt.text(
            "--fault",
            "Failure: of a sensor or a fin's servo as depth:nan@100, or "
            f"{', '.join(FAILURES)} as board:brownout@60 or link:lost@60-180; repeatable.",
        ),
    ] = None,
    real_time: Annotated[bool, opt.flag("--real-time", "Run no faster than real time.")] = False,
    black_box: Annotated[str | None, opt.file("--black-box", "the black box of the board", ".bin")] = None,
    firmware: Annotated[
        str | None, opt.text("--firmware", "Folder of the programs. (default: build/firmware)", "FOLDER")
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Run the firmware in the loop: the twin at sea and the firmware on a board, in lock-step.

    The same firmware runs beside it as a program on this machine, and must answer with the same bits in every tick.
    The exit code is 0 if it did and its mission, if it has one, is done; 1 if not, 2 for bad input.
    """
    if air is not None and radio is None:
        raise InputError("needs a ground station", key="--air", fix="give its port by --radio")
    if (missing_tool := missing(board)) is not None:
        raise InputError("must be able to run here", key="--board", value=board, fix=missing_tool)
    chosen = robot.load() if robot.robot else None
    plan = find_scenario(scenario, replace(robot, robot=TUNA).load() if chosen is None and ":" in scenario else chosen)
    fish = chosen if chosen is not None else replace(robot, robot=plan.robot or TUNA).load()
    if plan.mission is not None:
        check_current(fish, plan.mission)
        if radio is not None and plan.mission.waypoints:
            note = f"note: {scenario} is armed and started by itself; --scenario afloat waits for the ground station"
            typer.echo(note, err=True)
    with progress_bar("ticks") as progress:
        run = firmware_in_the_loop(
            fish,
            plan,
            board=board,
            ticks=ticks,
            seed=seed,
            folder=firmware,
            radio=radio,
            air=None if air is None else radio_model(air),
            faults=fault or [],
            real_time=real_time,
            black_box=black_box,
            report=progress,
        )
    emit(
        run,
        record=lambda run: _record(run) | made_by(fish, seed=seed, black_box=black_box),
        lines=_lines,
        written=(black_box,),
        as_json=as_json,
        failed=bool(len(run.mismatches)) or run.status not in (None, "done"),
    )


def _record(run: FirmwareRun) -> dict[str, Any]:
    """Return the JSON record of a run of the firmware."""
    last, mission = run.answers[-1], run.mission_run
    record: dict[str, Any] = {
        "board": run.board,
        "scenario": run.scenario.name,
        "ticks": run.ticks,
        "mismatches": len(run.mismatches) if run.compared else None,
        "first_mismatch": int(run.mismatches[0]) if len(run.mismatches) else None,
        "instructions_per_tick_max": {part: run.instructions(part) for part in PARTS} if run.counts else None,
        "stack_bytes": int(run.answers["stack"].max()) if run.counts else None,
        "real_time_factor": run.real_time_factor,
        "air": run.air or None,
        "refused": {reason: len(ticks) for reason, ticks in run.refused.items()},
        "mode": _core.mode_table()[last["mode"]][0],
        "state": _core.state_table()[last["state"]][0],
        "faults": _names(_core.fault_table(), last["faults"]),
    }
    if mission is not None:
        record |= {"status": run.status, "distance_m": mission.distance, "energy_wh": mission.energy / 3600}
        record |= {"reasons": _names(_core.reason_table(), last["reasons"])}
    return record


def _names(table: Sequence[Sequence[Any]], bits: Any) -> list[str]:
    """Return the names of the rows of a table whose bits are set."""
    return [row[0] for bit, row in enumerate(table) if int(bits) >> bit & 1]


def _lines(run: FirmwareRun) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a run of the firmware."""
    record = _record(run)
    yield f"{run.scenario.name} on {run.board}: {run.ticks} ticks", "bold"
    yield f"real-time factor: {run.real_time_factor:.1f}"
    if (counts := record["instructions_per_tick_max"]) is not None:
        yield f"max instructions in a tick: {', '.join(f'{part} {count:.0f}' for part, count in counts.items())}"
        yield f"max stack: {record['stack_bytes']} bytes"
    if run.mission_run is not None:
        status = f"{record['status']}, " if record["status"] is not None else ""
        distance = f"{record['distance_m']:.1f} m over ground"
        yield f"at the end: {status}{distance}, state {record['state']}, mode {record['mode']}"
        yield f"reasons of the pilot at the end: {', '.join(record['reasons']) or 'none'}"
    for side, packets in run.air.items():
        counts = f"{packets['sent']} packets, {packets['lost']} lost, {packets['damaged']} damaged"
        yield f"radio of the {side}: {counts}, {packets['dropped']} bytes dropped"
    yield f"faults at the end: {', '.join(record['faults']) or 'none'}"
    for reason, ticks in run.refused.items():
        style = "dim" if run.mission_run is None else "yellow"
        yield f"orders refused, {reason}: {len(ticks)}, first in tick {ticks[0]}", style
    if not run.compared:
        yield "Not compared: orders over the radio reach the board alone.", "dim"
    elif len(run.mismatches):
        mismatch = f"{len(run.mismatches)} ticks, first in tick {run.mismatches[0]}"
        yield f"The board differs from the program on this machine in {mismatch}.", "bold red"
    else:
        yield "Every tick has the same bits as the program on this machine.", "green"
