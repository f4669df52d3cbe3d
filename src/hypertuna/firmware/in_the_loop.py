"""Firmware in the loop: the twin at sea, and the firmware on a board in the pilot's place, in lock-step.

The same firmware runs as a program on this machine beside it. Both get the same messages and must answer with the same
bits.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.firmware.boards import INSTRUCTIONS, Board, firmware_of, started
from hypertuna.firmware.channel import RadioModel
from hypertuna.firmware.lockstep import COMPARED, FIXED, FROM_BOARD, GROUND, STACK, Counts, order
from hypertuna.firmware.parameters import FirmwareTable, firmware_table
from hypertuna.firmware.relay import Relay
from hypertuna.firmware.scenario import Scenario, orders_of, random_messages
from hypertuna.mission.run import MissionRun, fly_part, joined, mission_start

__all__ = ["FirmwareRun", "firmware_in_the_loop"]

Array = NDArray[np.float64]
Messages = NDArray[Any]

PART = 3000  # ticks that the twin makes at a time
PARTS = ("controller", "pilot", "radio", "whole")  # of a tick, that instructions are counted of
TICK = 0.01  # s
USUAL = 6000  # ticks of what does not end by itself
MOST_TICKS = 100_000_000  # eleven days


@dataclass(frozen=True)
class FirmwareRun:
    """What came of it."""

    scenario: Scenario
    board: str
    answers: Messages = field(repr=False)  # (ticks,) Of the board
    # Ticks in which it and the same firmware on this machine differed in any bit
    different: NDArray[np.int64] = field(repr=False)
    duration: float  # That it took [s]
    flown: MissionRun | None = field(repr=False)  # What the twin made of it
    compared: bool = True  # Whether the same firmware ran on this machine beside it
    # What became of the packets of "robot" and "ground", as `Air.told` says it; empty without a modelled radio
    air: dict[str, dict[str, int]] = field(default_factory=dict)

    @property
    def real_time_factor(self) -> float:
        """Simulated time over the time that it took."""
        return self.ticks * TICK / self.duration

    @property
    def counts(self) -> bool:
        """Whether the board counts instructions and measures its stack."""
        return self.board == "qemu"

    @property
    def status(self) -> str | None:
        """How a mission ended: what the pilot on board says, unless the twin diverged; None where there is none."""
        if self.flown is None:
            return None
        if self.flown.status == "diverged":
            return "diverged"
        if not self.flown.start.mission.waypoints:
            return None
        mode = _core.mode_names()[self.answers[-1]["mode"]]
        return mode if mode in ("done", "hold") else "given up"

    @property
    def refused(self) -> dict[str, list[int]]:
        """Orders that were not followed: ticks by reason."""
        names = [name for name, _ in _core.refusal_table()]
        found = self.answers["refusal"]
        return {names[k]: np.flatnonzero(found == k).tolist() for k in np.unique(found[found > 0])}

    @property
    def ticks(self) -> int:
        """Control ticks that were made."""
        return len(self.answers)

    def instructions(self, part: str) -> float | None:
        """Return the most instructions that a part of a tick took."""
        return float(self.answers[part].max() * INSTRUCTIONS) if self.counts else None


def firmware_in_the_loop(
    robot: Robot,
    scenario: Scenario,
    *,
    board: str = "pc",
    ticks: int | None = None,
    seed: int = 0,
    folder: str | Path | None = None,
    radio: int | None = None,
    air: RadioModel | None = None,
    real_time: bool = False,
    black_box: str | Path | None = None,
    report: Callable[[int, int], None] | None = None,
) -> FirmwareRun:
    """Run the firmware of a robot on a board."""
    _check_between(ticks, "ticks", 1, MOST_TICKS)
    _check_between(seed, "seed", 0, 2**64 - 1)
    _check_between(radio, "radio", 1, 65535)
    table = firmware_table(robot)
    firmware = _firmware(table, board, folder)
    beside = _firmware(table, "pc", folder) if radio is None else None
    begun = time.perf_counter()
    relay: Relay | None = None
    with contextlib.ExitStack() as stack:
        if radio is not None and air is not None:
            relay = stack.enter_context(Relay(board, radio, air, seed=seed))
        on = stack.enter_context(started(board, firmware, radio if relay is None else relay.board_port, black_box))
        if relay is not None:
            relay.connect()
        other = stack.enter_context(started("pc", beside)) if beside is not None else None
        if scenario.mission is None:
            messages = random_messages(table, USUAL if ticks is None else ticks, seed)
            answers, different = _streamed(on, other, messages, report)
            flown = None
        else:
            loop = _Loop(table, scenario, on, other, relay, real_time)
            flown = _flown(robot, scenario, loop, ticks, seed, report)
            answers, different = np.array(loop.answers), loop.different
    took = time.perf_counter() - begun
    told = {} if relay is None else {side: relay.air.told(k) for k, side in enumerate(("robot", "ground"))}
    return FirmwareRun(scenario, board, answers, np.array(different, dtype=np.int64), took, flown, radio is None, told)


def _check_between(number: int | None, key: str, least: int, most: int) -> None:
    """Check a whole number that may be left out."""
    if number is not None and not least <= number <= most:
        fix = f"give {'less' if number > most else 'more'}"
        raise InputError(f"must be from {least} to {most}", key=key, value=str(number), fix=fix)


def _firmware(table: FirmwareTable, board: str, folder: str | Path | None) -> Path:
    """Find the firmware of a robot, and check that it has the numbers of the description as it is now."""
    name = table.robot.name
    path = firmware_of(name, board, folder)
    if table.values.astype("<f4").tobytes() not in path.read_bytes():
        source = table.robot.file or name
        written = f"hypertuna firmware params --robot {source} -o firmware/robots/{name}.hpp"
        fix = f"run `{written}` and `make firmware ROBOT={name}`"
        raise InputError(f"has other numbers than {source}", file=str(path), fix=fix)
    return path


class _Loop:
    """A board in the place of the twin's pilot: called with what the sensors show, it returns servo pulses."""

    def __init__(
        self,
        table: FirmwareTable,
        scenario: Scenario,
        board: Board,
        other: Board | None,
        relay: Relay | None,
        real_time: bool,
    ) -> None:
        assert scenario.mission is not None
        self.board, self.other, self.relay = board, other, relay
        self.counts = Counts(table, scenario.origin)
        self.orders, self.silent = dict(orders_of(scenario)), scenario.silent
        self.servos = 2 * len(table.robot.joints) + 2
        self.center = float(table.values[[name for _, name, _ in table.fields].index("pulse_center")])
        self.tick = float(table.values[0])
        self.last = [self.center] * self.servos
        self.answers: list[Any] = []
        self.different: list[int] = []
        self.clock = time.perf_counter() if real_time else None

    def __call__(self, readings: list[float]) -> list[float]:
        made = len(self.answers)
        message = self.orders[made].copy() if made in self.orders else order("none")
        sensed = len(self.counts.zero)
        message["sample"] = self.counts.of(np.asarray(readings[:sensed]))
        hears = self.other is not None and (self.silent is None or made < self.silent)
        message["flags"] = GROUND * hears | STACK * (made % 1000 == 0)
        if len(readings) > sensed:
            message["flags"] |= FIXED
            message["fix"] = self.counts.fix(readings[sensed], readings[sensed + 1])
        if self.clock is not None:
            time.sleep(max(0.0, self.clock + made * self.tick - time.perf_counter()))
        if self.relay is not None:
            self.relay.carry(made * self.tick)
        sent = message.tobytes()
        for one in filter(None, (self.board, self.other)):
            one.send(sent)
        got = self.board.answer()
        if self.other is not None and self.other.answer()[:COMPARED] != got[:COMPARED]:
            self.different.append(made)
        answer = np.frombuffer(got, FROM_BOARD)[0]
        self.answers.append(answer)
        # A servo without pulses stays where it is.
        pulses = zip(answer["pulse"][: self.servos].tolist(), self.last, strict=True)
        self.last = [pulse if pulse > 0 else last for pulse, last in pulses]
        return self.last


def _flown(
    robot: Robot,
    scenario: Scenario,
    loop: _Loop,
    ticks: int | None,
    seed: int,
    report: Callable[[int, int], None] | None,
) -> MissionRun:
    """Let the twin go on until the firmware says that its mission is done."""
    assert scenario.mission is not None
    start = mission_start(robot, scenario.mission, seed=seed)
    core = {**start.core, "board": loop}
    start = replace(start, core=core)
    usual = USUAL if scenario.silent is None else 3 * USUAL
    most = (usual if scenario.gait is not None else round(start.duration / start.tick)) if ticks is None else ticks
    records: list[dict[str, Array]] = []
    state, made = None, 0
    done = _core.mode_names().index("done")
    while made < most:
        asked = min(PART, most - made)
        record, state = fly_part(start, asked, state)
        records.append(record)
        made += int(record["ticks"][0])
        if report is not None:
            report(made, most)
        if int(record["ticks"][0]) < asked or (scenario.gait is None and loop.answers[-1]["mode"] == done):
            break
    return joined(start, records)


def _bits(answers: Messages) -> NDArray[np.uint8]:
    """Return all that boards must agree on, a row per answer."""
    return np.frombuffer(answers.tobytes(), np.uint8).reshape(len(answers), -1)[:, :COMPARED]


def _streamed(
    board: Board, other: Board | None, messages: Messages, report: Callable[[int, int], None] | None
) -> tuple[Messages, list[int]]:
    """Pass messages through both boards, without waiting for each answer."""
    answers, different = [], []
    for begin in range(0, len(messages), PART):
        part = messages[begin : begin + PART]
        answers.append(board.run(part))
        if other is not None:
            differ = _bits(answers[-1]) != _bits(other.run(part))
            different += (begin + np.flatnonzero(differ.any(axis=1))).tolist()
        if report is not None:
            report(begin + len(part), len(messages))
    return np.concatenate(answers), different
