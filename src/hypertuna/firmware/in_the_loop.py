"""Firmware in the loop: the twin at sea, flown by the firmware on a board in lock-step.

The same firmware runs as a program on this machine: both get the same messages and must answer with the same bits.
"""

import contextlib
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.firmware.boards import INSTRUCTIONS, Board, find_firmware, started
from hypertuna.firmware.channel import RadioModel
from hypertuna.firmware.failures import Failures, split_faults
from hypertuna.firmware.lockstep import (
    COMPARED,
    FIXED,
    FROM_BOARD,
    GROUND,
    KEPT,
    LEAK,
    RESET,
    STACK,
    Counts,
    order,
)
from hypertuna.firmware.parameters import FirmwareTable, firmware_table
from hypertuna.firmware.relay import Relay
from hypertuna.firmware.scenario import START, Scenario, random_messages, released_at, scheduled_orders
from hypertuna.mission.run import (
    MissionRun,
    MissionStart,
    ending,
    fly_parts,
    joined_parts,
    mission_start,
)
from hypertuna.ranges import Whole

Messages = NDArray[Any]
Station = Callable[[int], bytes]  # what a ground station sends in a tick

RADIO_DEPTH = 0.3  # m of fresh water over the antenna, which blocks a radio of hundreds of MHz
AFLOAT = START + 50  # tick until which the robot is at the surface
CHUNK = 3000  # random messages sent at a time
PARTS = ("controller", "pilot", "radio", "whole")  # parts of a tick whose instructions are counted
TICK = 0.01  # control period [s]
STATES = tuple(name for name, *_ in _core.state_table())
GUIDED = ("mission", "home", "surface")  # states in which the pilot on board makes the command
MILLI = 1000  # mm in 1 m
RANGES = {  # of options
    "ticks": Whole(min=1, max=100_000_000),  # up to eleven days
    "seed": Whole(min=0, max=2**64 - 1),
    "radio": Whole(min=1, max=65535),  # port
}


@dataclass(frozen=True)
class FirmwareRun:
    """Result of a run of firmware in the loop."""

    scenario: Scenario
    board: str
    answers: Messages = field(repr=False)  # (ticks,) of FROM_BOARD
    mismatches: NDArray[np.int64] = field(repr=False)  # ticks at which board and this machine differed in any bit
    duration: float  # wall-clock time [s]
    mission_run: MissionRun | None = field(repr=False)  # of the twin
    compared: bool = True  # whether the same firmware ran on this machine
    # counters of the packets of "robot" and "ground" (`Air.counters`); empty without a modeled radio
    air: dict[str, dict[str, int]] = field(default_factory=dict)

    @property
    def real_time_factor(self) -> float:
        """Simulated time over wall-clock time."""
        return self.ticks * TICK / self.duration

    @property
    def counts(self) -> bool:
        """Whether the board counts instructions and measures its stack."""
        return self.board == "qemu"

    @property
    def status(self) -> str | None:
        """End of a mission as `MissionRun.status` has it, by the pilot on board; None without a mission."""
        if self.mission_run is None:
            return None
        if self.mission_run.status == "diverged":
            return "diverged"
        if not self.mission_run.start.mission.waypoints:
            return None
        last, endings = self.answers[-1], {"home": "home", "surface": "up"}
        status = ending(last["mode"], last["reasons"])
        return endings.get(_before_rest(self.answers["state"]) or "", status) if status == "given up" else status

    @property
    def refused(self) -> dict[str, list[int]]:
        """Refused commands: ticks by reason."""
        names = [name for name, _ in _core.refusal_table()]
        refusal = self.answers["refusal"]
        return {names[k]: np.flatnonzero(refusal == k).tolist() for k in np.unique(refusal[refusal > 0])}

    @property
    def ticks(self) -> int:
        """Number of control ticks."""
        return len(self.answers)

    def instructions(self, part: str) -> float | None:
        """Return the maximum number of instructions of a part of a tick; None on a board that does not count them."""
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
    faults: str | Iterable[str] = (),
    station: Station | None = None,
    report: Callable[[int, int], None] | None = None,
) -> FirmwareRun:
    """Run the firmware of a robot on a board.

    `faults` are of sensors and fins as `mission_start` takes them, and `failures.FAILURES`. `station` returns the bytes
    that the robot's radio receives from the ground in each tick, at most `RADIO`, while the antenna is not under water.

    With `radio` (a port), commands over the radio reach the board alone: the firmware on this machine does not run.
    `air` puts the modeled radio between board and ground. `ticks`: until the mission is done, or 6000, if omitted.
    """
    for key, number in (("ticks", ticks), ("seed", seed), ("radio", radio)):
        if number is not None:
            RANGES[key].check(number, key)
    ticks = scenario.ticks if ticks is None else ticks
    table = firmware_table(robot)
    firmware = _firmware(table, board, folder)
    reference = _firmware(table, "pc", folder) if radio is None else None
    sensors, failures = split_faults(faults)
    if scenario.mission is None and (sensors or failures or station):
        raise InputError("need a twin", key="faults", value=scenario.name, fix="give a mission or afloat")
    begun = time.perf_counter()
    relay: Relay | None = None
    with contextlib.ExitStack() as stack:
        if radio is not None and air is not None:
            relay = stack.enter_context(Relay(board, radio, air, seed=seed))
        port = radio if relay is None else relay.board_port
        tested = stack.enter_context(started(board, firmware, port, black_box))
        if relay is not None:
            relay.connect()
        second = stack.enter_context(started("pc", reference)) if reference is not None else None
        run = None
        if scenario.mission is None:
            assert ticks is not None
            answers, mismatches = _streamed(tested, second, random_messages(table, ticks, seed), report)
        else:
            failing = Failures(failures, TICK)
            ground = radio is None
            loop = Loop(table, scenario, tested, second, relay, failing, station, ground=ground, real_time=real_time)
            released = released_at(scenario) * TICK
            start = mission_start(
                robot, scenario.mission, seed=seed, faults=sensors, resets=failing.resets, released=released
            )
            run = loop.fly(start, ticks, report)
            answers, mismatches = np.array(loop.answers), loop.mismatches
    duration = time.perf_counter() - begun
    packets = {} if relay is None else {side: relay.air.counters(k) for k, side in enumerate(("robot", "ground"))}
    differing = np.array(mismatches, dtype=np.int64)
    return FirmwareRun(scenario, board, answers, differing, duration, run, radio is None, packets)


def _firmware(table: FirmwareTable, board: str, folder: str | Path | None) -> Path:
    """Return the path of a robot's firmware, checked to be built with the numbers of the description."""
    name = table.robot.name
    path = find_firmware(name, board, folder)
    if table.values.astype("<f4").tobytes() not in path.read_bytes():
        source = table.robot.file or name
        command = f"hypertuna firmware params --robot {source} -o firmware/robots/{name}.hpp"
        fix = f"run `{command}` and `make firmware ROBOT={name}`"
        raise InputError(f"has other numbers than {source}", file=str(path), fix=fix)
    return path


class Loop:
    """A board in the place of the twin's pilot: called with the sensors' readings, it returns servo pulses."""

    def __init__(
        self,
        table: FirmwareTable,
        scenario: Scenario,
        board: Board,
        other: Board | None,
        relay: Relay | None,
        failures: Failures,
        station: Station | None,
        *,
        ground: bool = True,
        real_time: bool = False,
    ) -> None:
        self.ground = ground  # whether to pretend contact with the ground, without a real station
        self.failures, self.station = failures, station
        self.tick_count = self.missed = 0
        self.ticks: list[int] = []  # tick of each answer
        self.board, self.other, self.relay, self.scenario = board, other, relay, scenario
        self.counts, self.commands = Counts(table, scenario.origin or (0, 0)), dict(scheduled_orders(scenario))
        self.tick = float(table.values[0])
        self.center = float(table.column("pulse_center")[0])  # pulse of a centered servo [s]
        self.last = [self.center] * (2 * len(table.robot.joints) + 2)  # last pulse of every servo [s]
        self.depth = self.counts.names.index("depth")  # index of its reading
        self.start_depth = scenario.mission.depth if scenario.mission is not None and scenario.cable else 0.0
        self.answers: list[Any] = []
        self._under_way = False
        self.mismatches: list[int] = []
        self.clock = time.perf_counter() if real_time else None

    def __call__(self, readings: list[float], antenna: float) -> list[float]:
        """Run a tick with the sensors' readings and the height of the antenna [m]; return servo pulses [s]."""
        tick, failures = self.tick_count, self.failures
        self.tick_count += 1
        if self.relay is not None:
            self.relay.carry(tick * self.tick, deaf=not self.scenario.cable and antenna < -RADIO_DEPTH)
        if failures.stopped(tick):
            self.missed += 1
            return self.last
        reachable = (self.scenario.cable or antenna >= -RADIO_DEPTH) and not failures.has("link:lost", tick)
        commanded = tick in self.commands and reachable
        message = self.commands[tick].copy() if commanded else order("none")
        sensor_count = len(self.counts.zero)
        if tick < AFLOAT:  # it is armed at the surface, even if a mission on a cable begins at depth
            readings[self.depth] -= self.start_depth
        message["sample"] = self.counts.of(np.asarray(readings[:sensor_count]))
        silent = self.scenario.silent
        contact = self.ground and reachable and (silent is None or tick < silent)
        message["flags"] = GROUND * contact | STACK * (tick % 1000 == 0) | LEAK * failures.has("hull:leak", tick)
        if (reset := failures.reset(tick)) is not None:
            message["flags"] |= RESET | KEPT * (reset == "watchdog")
        message["missed"], self.missed = self.missed, 0
        if self.station is not None and reachable:
            received = self.station(tick)
            message["length"], message["radio"][: len(received)] = len(received), np.frombuffer(received, np.uint8)
        if len(readings) > sensor_count:
            message["flags"] |= FIXED
            message["fix"] = self.counts.fix(readings[sensor_count], readings[sensor_count + 1])
            message["accuracy"] = round(readings[sensor_count + 2] * MILLI)
        if self.clock is not None:
            time.sleep(max(0.0, self.clock + tick * self.tick - time.perf_counter()))
        sent = message.tobytes()
        for each in filter(None, (self.board, self.other)):
            each.send(sent)
        content = self.board.answer()
        if self.other is not None and self.other.answer()[:COMPARED] != content[:COMPARED]:
            self.mismatches.append(tick)
        answer = np.frombuffer(content, FROM_BOARD)[0]
        self.answers.append(answer)
        self.ticks.append(tick)
        # A servo without pulses holds its position.
        pulses = zip(answer["pulse"][: len(self.last)].tolist(), self.last, strict=True)
        self.last = [pulse if pulse > 0 else last for pulse, last in pulses]
        return self.last

    def fly(self, start: MissionStart, ticks: int | None, report: Callable[[int, int], None] | None) -> MissionRun:
        """Run the twin for this many ticks, or until the firmware reports that its mission is done."""
        ticks = round(start.duration / start.tick) if ticks is None else ticks
        start = replace(start, core={**start.core, "board": self}, duration=ticks * start.tick)
        parts = []
        for ticks_before, part in fly_parts(start, ended=lambda _: self.done):
            parts.append(part)
            if report is not None:
                report(ticks_before + int(part["ticks"][0]), ticks)
        return joined_parts(start, parts)

    @property
    def done(self) -> bool:
        """Whether the pilot on board has ended its mission, so that the robot rests where it ended."""
        return self.scenario.gait is None and self._flown and self.answers[-1]["state"] == STATES.index("rest")

    @property
    def _flown(self) -> bool:
        """Whether the pilot has ever commanded the robot, so that its mission has begun."""
        self._under_way = self._under_way or STATES[self.answers[-1]["state"]] in GUIDED
        return self._under_way


def _before_rest(states: NDArray[Any]) -> str | None:
    """Return the last state in which the pilot commanded, if the robot now rests or is disarmed; else None."""
    names = [STATES[number] for number in states[np.flatnonzero(np.diff(states, prepend=-1))]]
    under_way = [k for k, name in enumerate(names) if name in GUIDED]
    return names[under_way[-1]] if under_way and names[-1] in ("rest", "disarmed") else None


def _streamed(
    board: Board, other: Board | None, messages: Messages, report: Callable[[int, int], None] | None
) -> tuple[Messages, list[int]]:
    """Return a board's answers to messages, and the ticks at which those of another board differ."""
    answers, mismatches = [], []
    for begin in range(0, len(messages), CHUNK):
        part = messages[begin : begin + CHUNK]
        answers.append(board.run(part))
        if other is not None:
            bits, expected = (pair.view(np.uint8).reshape(len(part), -1) for pair in (answers[-1], other.run(part)))
            differ = (bits != expected)[:, :COMPARED].any(axis=1)
            mismatches += (begin + np.flatnonzero(differ)).tolist()
        if report is not None:
            report(begin + len(part), len(messages))
    return np.concatenate(answers), mismatches
