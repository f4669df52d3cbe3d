"""Environments of Gymnasium: many swimmers in one call, or one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from hypertuna.description.robot import Robot, robot_of
from hypertuna.learning.spans import STEP, knobs
from hypertuna.learning.swimmers import LIMIT, Swimmers
from hypertuna.learning.tasks import TASKS, Task
from hypertuna.ranges import POSITIVE_WHOLE, check_choice

Batch = NDArray[np.floating[Any]]
Flags = NDArray[np.bool_]

LOST = -10.0  # reward of a twin that left what a robot can do


class Spaces:
    """Spaces of one swimmer: actions are `knobs`, observations are normalized."""

    def __init__(self, swimmers: Swimmers) -> None:
        self.action = spaces.Box(-1.0, 1.0, (len(knobs(swimmers.robot)),), np.float32)
        self.observation = spaces.Box(-LIMIT, LIMIT, (swimmers.size,), np.float32)


class SwimmerEnv(gymnasium.Env[Batch, Batch]):
    """One swimmer.

    Parameters
    ----------
    task : str or Task
        ``"Swim"``, ``"Turn"``, ``"Goto"`` or ``"Station"``, or a task of your own.
    robot : Robot, str or Path
        With all that `hypertuna.twin` needs, and the largest bend of each joint.
    robots : sequence of Robot
        Robots of the same structure, one of which is sampled at each reset: domain randomization. The controller
        has the numbers of `robot`.
    step : float
        Length of a step [s], whole control ticks.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": [], "render_fps": round(1 / STEP)}

    def __init__(
        self,
        task: str | Task,
        *,
        robot: Robot | str | Path = "hypertuna",
        robots: Sequence[Robot] = (),
        step: float = STEP,
        render_mode: str | None = None,
    ) -> None:
        self.swimmers = Swimmers(_task(task), robot_of(robot), 1, robots, step=step)
        of = Spaces(self.swimmers)
        self.action_space, self.observation_space, self.render_mode = of.action, of.observation, render_mode

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Batch, dict[str, Any]]:
        """Start an episode."""
        super().reset(seed=seed)
        self.swimmers.restart([0], self.np_random)
        return _single(self.swimmers.observe())[0], {}

    def step(self, action: Batch) -> tuple[Batch, float, bool, bool, dict[str, Any]]:
        """Make a step."""
        reward, done, cut, success = _stepped(self.swimmers, np.asarray(action, dtype=float)[np.newaxis])
        observation = _single(self.swimmers.observe())[0]
        return observation, float(reward[0]), bool(done[0]), bool(cut[0]), {"is_success": bool(success[0])}


class SwimmerVectorEnv(VectorEnv[Batch, Batch, Batch]):
    """Many swimmers that step in one call, side by side in the lanes of a processor and over threads.

    An episode that ends is followed by the next within the same step: `infos` has its last observation as `final_obs`.

    Parameters
    ----------
    num_envs : int
        Number of swimmers.
    threads : int
        Threads that step them; results do not depend on it.
    task, robot, robots, step
        As of `SwimmerEnv`.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": [], "autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(
        self,
        num_envs: int,
        task: str | Task,
        *,
        robot: Robot | str | Path = "hypertuna",
        robots: Sequence[Robot] = (),
        step: float = STEP,
        threads: int = 1,
        render_mode: str | None = None,
    ) -> None:
        self.num_envs = POSITIVE_WHOLE.check(num_envs, "num_envs", "give a number of swimmers")
        self.swimmers = Swimmers(_task(task), robot_of(robot), self.num_envs, robots, threads, step)
        of = Spaces(self.swimmers)
        self.single_action_space, self.single_observation_space = of.action, of.observation
        self.action_space = batch_space(of.action, self.num_envs)
        self.observation_space = batch_space(of.observation, self.num_envs)
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Batch, dict[str, Any]]:
        """Start an episode of every swimmer."""
        super().reset(seed=seed[0] if isinstance(seed, list) else seed)
        self.swimmers.restart(range(self.num_envs), self.np_random)
        return _single(self.swimmers.observe()), {}

    def step(self, actions: Batch) -> tuple[Batch, Batch, Flags, Flags, dict[str, Any]]:
        """Make a step of every swimmer."""
        reward, done, cut, success = _stepped(self.swimmers, np.asarray(actions, dtype=float))
        observation = _single(self.swimmers.observe())
        infos: dict[str, Any] = {"is_success": success}
        ended = np.flatnonzero(done | cut)
        if len(ended):
            infos |= {"final_obs": observation, "_final_obs": done | cut}
            self.swimmers.restart(ended, self.np_random)
            observation = _single(self.swimmers.observe())
        return observation, reward, done, cut, infos


def register() -> None:
    """Register the tasks with Gymnasium."""
    for name in TASKS:
        gymnasium.register(
            f"hypertuna/{name}-v0",
            entry_point="hypertuna.learning.environments:SwimmerEnv",
            vector_entry_point="hypertuna.learning.environments:SwimmerVectorEnv",
            kwargs={"task": name},
        )


def _task(task: str | Task) -> Task:
    if not isinstance(task, str):
        return task
    check_choice(task, tuple(TASKS), "task")
    return TASKS[task]()


def _single(observation: NDArray[np.float64]) -> Batch:
    return observation.astype(np.float32)


def _stepped(swimmers: Swimmers, action: NDArray[np.float64]) -> tuple[Batch, Flags, Flags, Flags]:
    """Reward, end, end of the time, and success of a step; a twin that left what a robot can do ends its episode."""
    reward, done, success = swimmers.act(action)
    lost = swimmers.lost
    done = done | lost
    cut = ~done & (swimmers.steps * swimmers.step >= swimmers.task.seconds - 1e-9)
    return np.where(lost, LOST, np.nan_to_num(reward)), done, cut, success & ~lost
