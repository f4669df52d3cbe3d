"""Tasks: goals, what a swimmer observes of them, and rewards.

Every function takes all swimmers at once: positions and speeds are in body lengths, angles in radians, and a goal is a
row of numbers that holds for an episode.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array

CAPTURED = 0.5  # BL: a point this near to the nose counts as reached
TURNED = np.radians(10)  # rad: a heading this near to the goal counts as reached
EFFORT = 0.1  # subtracted from the reward of a step at the largest electrical power


class Seen(NamedTuple):
    """Swimmers at the end of a step; x east, y north, headings point ahead, counter-clockwise from x."""

    position: Array  # (N, 2) of the nose over ground [BL]
    heading: Array  # (N,) [rad]
    speed: Array  # (N,) mean over the step, ahead through the water [BL/s]
    effort: Array  # (N,) mean electrical power of the step over the largest [1]


class Outcome(NamedTuple):
    """Rewards, ends and successes of all swimmers in a step."""

    reward: Array  # (N,)
    done: NDArray[np.bool_]  # (N,) whether the task has ended
    success: NDArray[np.bool_]  # (N,) whether the task is fulfilled now


@dataclass(frozen=True)
class Task(ABC):
    """A task: its goals, what a swimmer observes of them, and the reward of a step."""

    size: ClassVar[int]  # numbers of an observation that describe the task
    seconds: float = 60.0  # duration of an episode
    current: float = 0.0  # largest speed of a uniform current, in a random direction [BL/s]

    @abstractmethod
    def goal(self, rng: np.random.Generator) -> Array:
        """Sample the goal of an episode."""

    @abstractmethod
    def observe(self, goal: Array, seen: Seen, current: Array) -> Array:
        """Return what each swimmer observes of its task (N, size); `current` (N, 2) is over ground [BL/s]."""

    @abstractmethod
    def outcome(self, goal: Array, seen: Seen, before: Seen) -> Outcome:
        """Return reward, end and success of a step."""


@dataclass(frozen=True)
class Swim(Task):
    """Track a speed at the least energy: from 0.3 to 1.5 BL/s."""

    size: ClassVar[int] = 1
    seconds: float = 10.0

    def goal(self, rng: np.random.Generator) -> Array:
        """Sample the goal of an episode."""
        return rng.uniform(0.3, 1.5, size=1)

    def observe(self, goal: Array, seen: Seen, current: Array) -> Array:
        """Return what each swimmer observes of its task (N, size)."""
        return goal

    def outcome(self, goal: Array, seen: Seen, before: Seen) -> Outcome:
        """Return reward, end and success of a step."""
        error = np.abs(seen.speed - goal[:, 0])
        close = error < 0.1 * goal[:, 0]
        return Outcome(-error - EFFORT * seen.effort, np.zeros(len(error), dtype=bool), close)


@dataclass(frozen=True)
class Turn(Task):
    """Turn to a random heading."""

    size: ClassVar[int] = 2
    seconds: float = 40.0

    def goal(self, rng: np.random.Generator) -> Array:
        """Sample the goal of an episode."""
        return rng.uniform(-np.pi, np.pi, size=1)

    def observe(self, goal: Array, seen: Seen, current: Array) -> Array:
        """Return what each swimmer observes of its task (N, size)."""
        error = goal[:, 0] - seen.heading
        return np.stack([np.cos(error), np.sin(error)], axis=1)

    def outcome(self, goal: Array, seen: Seen, before: Seen) -> Outcome:
        """Return reward, end and success of a step."""
        error = np.abs(wrapped(goal[:, 0] - seen.heading))
        reward = -error / np.pi - EFFORT * seen.effort
        return Outcome(reward, np.zeros(len(error), dtype=bool), error < TURNED)


@dataclass(frozen=True)
class Goto(Task):
    """Reach a point that is 3 to 8 BL away."""

    size: ClassVar[int] = 3
    seconds: float = 60.0

    def goal(self, rng: np.random.Generator) -> Array:
        """Sample the goal of an episode."""
        distance, bearing = rng.uniform(3, 8), rng.uniform(-np.pi, np.pi)
        return distance * np.array([np.cos(bearing), np.sin(bearing)])

    def observe(self, goal: Array, seen: Seen, current: Array) -> Array:
        """Return what each swimmer observes of its task (N, size)."""
        return _toward(goal - seen.position, seen.heading)

    def outcome(self, goal: Array, seen: Seen, before: Seen) -> Outcome:
        """Return reward, end and success of a step."""
        distance = np.linalg.norm(goal - seen.position, axis=1)
        nearer = np.linalg.norm(goal - before.position, axis=1) - distance
        reached = distance < CAPTURED
        return Outcome(nearer - EFFORT * seen.effort + 5.0 * reached, reached, reached)


@dataclass(frozen=True)
class Station(Task):
    """Hold a place in a current of up to 0.5 BL/s."""

    size: ClassVar[int] = 5
    seconds: float = 60.0
    current: float = 0.5

    def goal(self, rng: np.random.Generator) -> Array:
        """Sample the goal of an episode."""
        return np.zeros(2)

    def observe(self, goal: Array, seen: Seen, current: Array) -> Array:
        """Return what each swimmer observes of its task (N, size)."""
        return np.concatenate([_toward(goal - seen.position, seen.heading), _body_axes(current, seen.heading)], axis=1)

    def outcome(self, goal: Array, seen: Seen, before: Seen) -> Outcome:
        """Return reward, end and success of a step."""
        distance = np.linalg.norm(goal - seen.position, axis=1)
        reward = 1 / (1 + distance**2) - EFFORT * seen.effort
        return Outcome(reward, np.zeros(len(distance), dtype=bool), distance < 1)


TASKS: dict[str, type[Task]] = {"Swim": Swim, "Turn": Turn, "Goto": Goto, "Station": Station}  # classes by name


def wrapped(angle: Array) -> Array:
    """Return angles wrapped to the range from -pi to pi."""
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def _body_axes(vector: Array, heading: Array) -> Array:
    """Return the components ahead and to the left of vectors over ground (N, 2)."""
    cosine, sine = np.cos(heading), np.sin(heading)
    x, y = vector.T
    return np.stack([cosine * x + sine * y, cosine * y - sine * x], axis=1)


def _toward(vector: Array, heading: Array) -> Array:
    """Return cosine and sine of the bearing relative to the heading, and the distance over 4 BL, (N, 3)."""
    distance = np.linalg.norm(vector, axis=1, keepdims=True)
    return np.concatenate([_body_axes(vector, heading) / np.maximum(distance, 1e-9), distance / 4], axis=1)
