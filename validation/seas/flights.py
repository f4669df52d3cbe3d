"""Flights through random seas: the firmware on board `pc`, in lock-step with the twin."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from sampled_sea import Sea
from stations import station_of
from verdict import STATE, Truth

import hypertuna as ht
from hypertuna import _core
from hypertuna.control.mission import Mission
from hypertuna.errors import InputError
from hypertuna.firmware.boards import find_firmware, started
from hypertuna.firmware.failures import Failures, split_faults
from hypertuna.firmware.in_the_loop import TICK, Loop
from hypertuna.firmware.parameters import firmware_table
from hypertuna.firmware.scenario import released_at, scenario_of
from hypertuna.mission.checks import check_current
from hypertuna.mission.file import parse_mission
from hypertuna.mission.run import MissionRun, mission_start

GUIDED = ("mission", "home", "surface", "paused", "held")  # states in which the robot swims without its pilot
WILD = 20.0  # s after which the robot of the self-check ignores its pilot
PASSIVE = 20.0  # s in another state after which a flight has ended
PATIENCE = 60.0  # s beyond the mission's own limit of time, by which the robot must have ended


class SeaLoop(Loop):
    """Loop that ends when the robot, its mission begun, has been in a passive state for a while."""

    iron = (0.0, 0.0)  # field that iron on board adds to the compass, toward tail and starboard

    def __call__(self, readings: list[float], antenna: float) -> list[float]:
        """Return the pulses for readings whose compass is disturbed by iron."""
        first = self.counts.names.index("field")
        for k, more in enumerate(self.iron):
            readings[first + k] += more
        return super().__call__(readings, antenna)

    @property
    def done(self) -> bool:
        """Whether the flight has ended."""
        states = np.array([answer["state"] for answer in self.answers[-round(PASSIVE / TICK) :]])
        began = max(self.commands) + 100 < len(self.answers)
        return began and not np.isin(states, guided()).any()


class WildLoop(SeaLoop):
    """Loop of the self-check, whose robot soon ignores its pilot and beats with its fins down."""

    def __call__(self, readings: list[float], antenna: float) -> list[float]:
        """Return the pilot's pulses, or after `WILD` those of a robot that ignores it."""
        obeyed = super().__call__(readings, antenna)
        if self.tick_count < round(WILD / TICK):
            return obeyed
        swing = 2e-4 * np.sin(2 * np.pi * 2.0 * TICK * self.tick_count)
        center = self.center
        tail = [center + swing, center - swing, center + swing, center - swing]
        return [*tail[: len(self.last) - 2], center - 2e-4, center - 2e-4]


def guided() -> list[int]:
    """Return the indices of the states in which the pilot guides the robot."""
    return [k for k, row in enumerate(_core.state_table()) if row[0] in GUIDED]


def fly(sea: Sea, robot: ht.Robot, folder: str | Path | None = None, loop: type[SeaLoop] = SeaLoop) -> Truth:
    """Fly through a sea; return the flight's truth, without rows where the mission is refused."""
    file = parse_mission(sea.document)
    scenario = scenario_of(file)
    sensors, failures = split_faults(sea.fault)
    table = firmware_table(robot)
    failing = Failures(failures, TICK)
    try:
        seconds = file.mission.duration + PATIENCE
        start = mission_start(
            robot, file.mission, seed=sea.seed, faults=sensors, resets=failing.resets,
            released=released_at(scenario) * TICK, duration=seconds,
        )  # fmt: skip
    except InputError as error:
        return _refused(file.mission, str(error))
    with started("pc", find_firmware(robot.name, "pc", folder)) as board:
        station = station_of(sea.kind, sea.start, sea.seed)
        on = loop(table, scenario, board, None, None, failing, station)
        on.iron = sea.iron
        run = on.fly(start, round(seconds / TICK), None)
    return replace(_truth(file.mission, on, run), warned=_warned(robot, file.mission))


def _warned(robot: ht.Robot, mission: Mission) -> bool:
    """Return whether the mission file would be refused with its current, which is unknown on board."""
    try:
        check_current(robot, mission)
    except InputError:
        return True
    return False


def _refused(mission: Mission, sentence: str) -> Truth:
    none = np.zeros(1)
    told = frozenset({f"refused: {sentence}"})
    return Truth(
        mission, none, np.array([[*mission.start, 0.0]]), none, np.zeros(1, bool), np.zeros((1, 3)), False, told
    )


def _truth(mission: Mission, on: Loop, run: MissionRun) -> Truth:
    """Return the twin's truth of a flight, with what the robot reported."""
    answers, time = np.array(on.answers), run.time
    row = np.searchsorted(on.ticks, np.round(time / TICK).astype(int), side="right") - 1  # last answer before
    at = answers[np.maximum(row, 0)]
    active = np.isin(at["state"], guided())
    told: set[str] = set()
    for name, table in (("reasons", _core.reason_table()), ("faults", _core.fault_table())):
        seen = int(np.bitwise_or.reduce(answers[name][max(on.commands) :]))
        told |= {entry[0] for bit, entry in enumerate(table) if seen >> bit & 1}
    told |= {_core.refusal_table()[k][0] for k in np.unique(answers["refusal"]) if k}
    visited = {_core.state_table()[k][0] for k in np.unique(answers["state"])}
    told |= {f"{STATE}{name}" for name in visited & {"surface", "held"}}
    ends = np.flatnonzero(active)
    last = at[ends[-1]] if len(ends) else at[-1]
    early = [row[0] for row in _core.reason_table()]
    early = early[: early.index("all_reached")]
    ended = _core.mode_table()[last["mode"]][0] == "done" or "all_reached" in _reasons(last)
    stopped = bool(_reasons(last) & set(early)) or "no_progress" in told  # maybe on its way home
    done = ended and int(last["leg"]) >= len(mission.waypoints) and not stopped
    place = np.column_stack([at["position"], -at["depth"]]).astype(float)
    return Truth(
        mission, time, run.data["position"], at["position_error"].astype(float), active, place, done,
        frozenset(told) - {"all_reached"}, float(run.data["pump_pressure_high"].max()),
    )  # fmt: skip


def _reasons(answer: Any) -> set[str]:
    return {row[0] for bit, row in enumerate(_core.reason_table()) if int(answer["reasons"]) >> bit & 1}
