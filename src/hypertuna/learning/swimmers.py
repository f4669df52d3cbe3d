"""Swimmers: twins of one robot, or of robots like it, that act and observe in steps of many control ticks."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.actuation.hydraulics import has_oil, pump_servo
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.description.twin import require_controller
from hypertuna.errors import InputError
from hypertuna.learning.spans import STEP, sensed_size, span_of, ticks_of
from hypertuna.learning.tasks import Outcome, Seen, Task
from hypertuna.simulation.plant import controller_of, parts_of, steps_of

LIMIT = 4.0  # observations are clipped to -LIMIT and LIMIT
# Attributes that steps change.
CHANGING = ("goal", "current", "steps", "action", "seen", "effort", "_batch", "_columns", "_drift", "_before")


@dataclass
class Swimmers:
    """Twins that follow actions; each restart samples one of `robots`. All controllers have the numbers of `robot`."""

    task: Task
    robot: Robot
    count: int
    robots: Sequence[Robot] = ()
    threads: int = 1
    step: float = STEP  # duration of an action [s]
    goal: Array = field(init=False)  # (N, numbers of a goal), see `Task.goal`
    current: Array = field(init=False)  # velocity of the water (N, 2) [BL/s]
    steps: Array = field(init=False)  # (N,) steps since the start of the episode

    def __post_init__(self) -> None:
        self.ticks = ticks_of(self.robot, self.step)
        tick = 1 / require_controller(self.robot).rate
        self.span = span_of(self.robot)
        self._parts = [parts_of(robot, "water", None) for robot in self.robots or [self.robot]]
        for robot in self.robots:
            if _structure(robot) != _structure(self.robot):
                rule, fix = f"must have the links, joints and water law of {self.robot.name}", "change numbers alone"
                raise InputError(rule, key="robots", value=robot.name, fix=fix)
        inner = max(steps_of(tick, parts, self.robot) for parts in self._parts)
        self._controller = _core.LiveController(controller_of(self.robot))
        rng = np.random.default_rng(0)
        self._batch = _core.Batch([self._new_swimmer(rng) for _ in range(self.count)], steps=inner)
        self.action = np.tile(self.rest, (self.count, 1))
        self.goal = np.stack([self.task.goal(rng) for _ in range(self.count)])
        self.current, self.steps = np.zeros((self.count, 2)), np.zeros(self.count, dtype=int)
        self._drift, self._before = np.zeros((self.count, 2)), np.zeros(self.count)
        self.power = _largest_power(self.robot)  # largest electrical power [W]
        self._columns = self._batch.columns()
        self.seen = self._look(self._columns["x"], self._columns["y"])
        self.effort = np.zeros(self.count)  # that of the last step, even if a new episode has begun since

    @property
    def rest(self) -> Array:
        """The action of a straight tail (3 joints,)."""
        joints = len(self.robot.joints)
        return np.concatenate([np.full(1 + joints, -1.0), np.full(joints - 1, -1.0), np.zeros(joints)])

    @property
    def size(self) -> int:
        """Count of the numbers of an observation."""
        return sensed_size(self.robot) + self.task.size

    def restart(self, swimmers: Iterable[int], rngs: Sequence[np.random.Generator]) -> None:
        """Start swimmers anew, each at rest with a goal, a current and a robot from its generator of `rngs`."""
        rows = [int(k) for k in swimmers]
        for k in rows:
            rng = rngs[k]
            self._batch.restart(k, self._new_swimmer(rng))
            self.goal[k] = self.task.goal(rng)
            speed, toward = self.task.current * rng.random(), 2 * math.pi * rng.random()
            self.current[k] = speed * math.cos(toward), speed * math.sin(toward)
            self.action[k], self.steps[k], self._drift[k], self._before[k] = self.rest, 0, 0.0, 0.0
        self._columns = self._batch.columns()
        seen = self._look(self._columns["x"], self._columns["y"])
        self.seen = Seen(*(_with_rows(old, new, rows) for old, new in zip(self.seen, seen, strict=True)))

    def act(self, action: Array) -> Outcome:
        """Make a step of all swimmers; return their rewards, ends and successes."""
        if action.shape != self.action.shape:
            rule, value = f"must be {self.action.shape[1]} numbers for each swimmer", f"of shape {action.shape}"
            raise InputError(rule, key="action", value=value, fix="see hypertuna.learning.spans.knobs")
        self.action = np.clip(action, -1, 1)
        x, y = self._columns["x"], self._columns["y"]
        self._batch.command(*(np.ascontiguousarray(part) for part in self.span.gait(self.action)))
        self._batch.advance(self.ticks, self.threads)
        self._columns, seen_before = self._batch.columns(), self.seen
        self.steps += 1
        self._drift += self.step * self.current
        self.seen = self._look(x, y)
        self.effort = self.seen.effort
        return self.task.outcome(self.goal, self.seen, seen_before)

    def observe(self) -> Array:
        """Return what each swimmer observes (N, size): bends with the noise of the sensors, other numbers exact.

        Speed ahead [BL/s], rate of turn [rad/s], bends as measured and as set, over the largest; the action; the task.
        """
        c = self._columns
        motion = np.stack([self.seen.speed, c["yaw"]], axis=1)
        bends = np.concatenate([c["angle_measured"], c["angle_set"]], axis=1) / np.tile(self.span.bend, 2)
        task = self.task.observe(self.goal, self.seen, self.current)
        observation = np.concatenate([motion, bends, self.action, task], axis=1)
        return np.asarray(np.clip(np.nan_to_num(observation), -LIMIT, LIMIT))

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Whether each twin has left the limits of a robot, shape (N,)."""
        return np.asarray(self._columns["lost"] != 0)

    @cached_property
    def kind(self) -> tuple[object, ...]:
        """Task, number, step and robots. A saved state can be restored only by swimmers of an equal kind."""
        return self.task, self.count, self.step, [robot.document() for robot in (self.robot, *self.robots)]

    @property
    def moment(self) -> dict[str, Any]:
        """The attributes that steps change in place, by name."""
        return {name: getattr(self, name) for name in CHANGING}

    def __deepcopy__(self, memo: dict[int, Any]) -> Swimmers:
        """Copy the attributes that steps change; the copy shares all others."""
        other = copy.copy(self)
        vars(other).update(copy.deepcopy(self.moment, memo))
        return other

    def _new_swimmer(self, rng: np.random.Generator) -> tuple[_core.Plant, _core.LiveController, _core.Sensors, float]:
        parts = self._parts[rng.integers(len(self._parts))]
        return parts.plant, self._controller, _core.Sensors(parts.sensors, int(rng.integers(2**63))), 0.0

    def _look(self, x: Array, y: Array) -> Seen:
        """Return the state and motion of the swimmers, which were at `x`, `y` [m] a step ago."""
        c, length = self._columns, self.robot.body.length
        ahead = -(np.cos(c["heading"]) * (c["x"] - x) + np.sin(c["heading"]) * (c["y"] - y))
        energy, self._before = c["energy"] - self._before, c["energy"].copy()
        position = np.stack([c["x"], c["y"]], axis=1) / length + self._drift
        return Seen(position, c["heading"] + math.pi, ahead / (length * self.step), energy / (self.step * self.power))


def _structure(robot: Robot) -> tuple[object, ...]:
    return parts_of(robot, "water", None).plant.structure, [group.drive for group in robot.joints]


def _largest_power(robot: Robot) -> float:
    """Return the electrical power [W] of the servos that move the joints, all at stall."""
    power = sum(group.stall_power for group in robot.joints)
    if has_oil(robot):
        pump = pump_servo(robot)
        power += pump.count * (pump.voltage or 0) * (pump.stall_current or 0)
    return power


def _with_rows(old: Array, new: Array, rows: Sequence[int]) -> Array:
    """Return a copy of `old` with some rows of `new`."""
    mixed = old.copy()
    mixed[rows] = new[rows]
    return mixed
