"""Environments of Gymnasium: for one swimmer, and for many that step in one call."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from hypertuna.description.robot import Robot, robot_of
from hypertuna.errors import InputError, shown
from hypertuna.learning.spans import STEP, knobs
from hypertuna.learning.swimmers import LIMIT, Swimmers
from hypertuna.learning.tasks import TASKS, Task
from hypertuna.parallel.executors import thread_count
from hypertuna.ranges import POSITIVE_WHOLE, check_choice

Batch = NDArray[np.floating[Any]]
Flags = NDArray[np.bool_]

LOST = -10.0  # reward of a twin that left the limits of a robot
# Attributes of an environment that change, besides its swimmers.
CHANGING = ("_np_random", "_np_random_seed", "_rngs", "_ended")


@dataclass(frozen=True)
class EnvState:
    """State of an environment: swimmers, goals, random generators and ended episodes."""

    kind: tuple[object, ...]  # `Swimmers.kind`
    moments: tuple[dict[str, Any], dict[str, Any]]  # changing attributes of environment and swimmers


class _Saved:
    """Base of the environments of one swimmer and of many: saves and restores their state."""

    swimmers: Swimmers
    np_random: np.random.Generator

    def save_state(self) -> EnvState:
        """Save the state, with the random generators: a restored environment has the same future, to the last bit."""
        kept = {name: value for name, value in vars(self).items() if name in CHANGING}
        kept["_np_random"] = self.np_random  # the property makes the generator at its first use
        return EnvState(self.swimmers.kind, copy.deepcopy((kept, self.swimmers.moment)))

    def restore_state(self, state: EnvState) -> None:
        """Restore a state of this environment, of a copy (`copy.deepcopy`), or of one with the same arguments."""
        if not isinstance(state, EnvState) or state.kind != self.swimmers.kind:
            rule, fix = "must be of an environment of the same task, robots, number and step", "save it in this one"
            raise InputError(rule, key="state", fix=fix)
        kept, swimmers = copy.deepcopy(state.moments)  # a copy: the state may be restored again
        vars(self).update(kept)
        vars(self.swimmers).update(swimmers)


class Spaces:
    """Spaces of one swimmer: actions are `knobs`, observations are normalized."""

    def __init__(self, swimmers: Swimmers) -> None:
        self.action = spaces.Box(-1.0, 1.0, (len(knobs(swimmers.robot)),), np.float32)
        self.observation = spaces.Box(-LIMIT, LIMIT, (swimmers.size,), np.float32)


class SwimmerEnv(_Saved, gymnasium.Env[Batch, Batch]):
    """A Gymnasium environment of one swimmer, which acts on a task.

    Parameters
    ----------
    task : str or Task
        ``"Swim"``, ``"Turn"``, ``"Goto"`` or ``"Station"``, or a task of your own.
    robot : Robot, str or Path
        With all that `hypertuna.twin` needs, and the largest bend of each joint.
    robots : sequence of Robot, str or Path
        Robots of the same structure, one of which is sampled at each reset: domain randomization. The controller
        has the numbers of `robot`.
    step : float
        Length of a step [s], whole control ticks.
    """

    def __init__(
        self,
        task: str | Task,
        *,
        robot: Robot | str | Path = "hypertuna",
        robots: Sequence[Robot | str | Path] = (),
        step: float = STEP,
        render_mode: str | None = None,
    ) -> None:
        self.swimmers = Swimmers(_task_of(task), robot_of(robot), 1, [*map(robot_of, robots)], step=step)
        spaces, self.metadata = Spaces(self.swimmers), {"render_modes": [], "render_fps": 1 / step}
        self.action_space, self.observation_space, self.render_mode = spaces.action, spaces.observation, render_mode

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Batch, dict[str, Any]]:
        """Start an episode; return the first observation (size,) and no infos."""
        super().reset(seed=seed)
        self.swimmers.restart([0], [self.np_random])
        return _as_float32(self.swimmers.observe())[0], {}

    def step(self, action: Batch) -> tuple[Batch, float, bool, bool, dict[str, Any]]:
        """Make a step; return observation, reward, whether the task or the time has ended, and success."""
        reward, done, cut, success = _stepped(self.swimmers, [action])
        observation = _as_float32(self.swimmers.observe())[0]
        return observation, float(reward[0]), bool(done[0]), bool(cut[0]), {"is_success": bool(success[0])}


class SwimmerVectorEnv(_Saved, VectorEnv[Batch, Batch, Batch]):
    """Many swimmers that step in one call, side by side in the lanes of a processor and over threads.

    Parameters
    ----------
    num_envs : int
        Number of swimmers.
    autoreset_mode : AutoresetMode or str
        How the next episode follows one that ends, as Gymnasium defines it. SAME_STEP: within the same step; `infos`
        has the last observation of the old one as `final_obs`, and its success in `final_info`. NEXT_STEP: in the next
        step, which ignores the action and has the reward 0. DISABLED: when you reset it, by
        ``reset(options={"reset_mask": ended})``.
    threads : int or None
        Threads that step them, None for all processors; results do not depend on it.
    task, robot, robots, step
        As of `SwimmerEnv`.
    """

    def __init__(
        self,
        num_envs: int,
        task: str | Task,
        *,
        robot: Robot | str | Path = "hypertuna",
        robots: Sequence[Robot | str | Path] = (),
        step: float = STEP,
        threads: int | None = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.SAME_STEP,
        render_mode: str | None = None,
    ) -> None:
        self.num_envs = POSITIVE_WHOLE.check(num_envs, "num_envs", "give a number of swimmers")
        variants, threads = [*map(robot_of, robots)], thread_count(threads)
        self.swimmers = Swimmers(_task_of(task), robot_of(robot), self.num_envs, variants, threads, step)
        word = autoreset_mode.value if isinstance(autoreset_mode, AutoresetMode) else autoreset_mode
        self.mode = AutoresetMode(check_choice(word, [mode.value for mode in AutoresetMode], "autoreset_mode"))
        self.metadata = {"render_modes": [], "render_fps": 1 / step, "autoreset_mode": self.mode}
        single = Spaces(self.swimmers)
        self.single_action_space, self.single_observation_space = single.action, single.observation
        self.action_space = batch_space(single.action, self.num_envs)
        self.observation_space = batch_space(single.observation, self.num_envs)
        self.render_mode = render_mode
        self._rngs = [self.np_random] * self.num_envs
        self._ended = np.zeros(self.num_envs, dtype=bool)  # swimmers whose episode has ended and is not yet reset

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Batch, dict[str, Any]]:
        """Start an episode of every swimmer, or of those of a mask (num_envs,), ``options={"reset_mask": mask}``.

        All share one seed, or each has its own of a list, or goes on by None.
        """
        rows = self._masked((options or {}).get("reset_mask"))
        if isinstance(seed, Sequence):
            if len(seed) != self.num_envs:
                rule, fix = (
                    f"must be one for each of {self.num_envs} swimmers",
                    "give a number, or a list of that length",
                )
                raise InputError(rule, key="seed", value=shown(seed), fix=fix)
            for k in rows:
                self._rngs[k] = self._rngs[k] if seed[k] is None else np_random(seed[k])[0]
        elif seed is not None:
            super().reset(seed=seed)
            for k in rows:
                self._rngs[k] = self.np_random
        self.swimmers.restart(rows, self._rngs)
        self._ended[rows] = False
        return _as_float32(self.swimmers.observe()), {}

    def step(self, actions: Batch) -> tuple[Batch, Batch, Flags, Flags, dict[str, Any]]:
        """Make a step of every swimmer; return observations, rewards, ends of tasks and of time, and infos."""
        to_restart = self._ended
        if to_restart.any() and self.mode == AutoresetMode.DISABLED:
            rule, fix = "must be reset after an episode ends", 'call reset(options={"reset_mask": ended})'
            raise InputError(rule, key="swimmers", value=shown(np.flatnonzero(to_restart).tolist()), fix=fix)
        reward, done, cut, success = _stepped(self.swimmers, actions)
        reward[to_restart], done[to_restart], cut[to_restart] = 0, False, False
        observation = _as_float32(self.swimmers.observe())
        ended = done | cut
        has_success = ~ended if self.mode == AutoresetMode.SAME_STEP else ~to_restart
        infos: dict[str, Any] = {"is_success": success & has_success, "_is_success": has_success}
        if self.mode == AutoresetMode.SAME_STEP:
            if ended.any():
                final = {"is_success": success & ended, "_is_success": ended}
                infos |= {"final_obs": observation, "_final_obs": ended, "final_info": final, "_final_info": ended}
            to_restart = ended
        if to_restart.any():
            self.swimmers.restart(np.flatnonzero(to_restart), self._rngs)
            observation = _as_float32(self.swimmers.observe())
        self._ended = ended & (self.mode != AutoresetMode.SAME_STEP)
        return observation, reward, done, cut, infos

    def _masked(self, mask: Any) -> Sequence[int]:
        """Return the indices of the swimmers in a mask; without a mask, those of all swimmers."""
        if mask is None:
            return range(self.num_envs)
        if np.shape(mask) != (self.num_envs,) or np.asarray(mask).dtype != bool or not np.any(mask):
            rule, fix = f"must be {self.num_envs} truths, one at least true", "give terminated | truncated of a step"
            raise InputError(rule, key="reset_mask", value=shown(mask), fix=fix)
        return np.flatnonzero(mask).tolist()


def register() -> None:
    """Register the tasks with Gymnasium."""
    for name in TASKS:
        gymnasium.register(
            f"hypertuna/{name}-v0",
            entry_point="hypertuna.learning.environments:SwimmerEnv",
            vector_entry_point="hypertuna.learning.environments:SwimmerVectorEnv",
            kwargs={"task": name},
        )


def _task_of(task: str | Task) -> Task:
    if isinstance(task, Task):
        return task
    check_choice(task, tuple(TASKS), "task")
    return TASKS[task]()


def _as_float32(observation: NDArray[np.float64]) -> Batch:
    return observation.astype(np.float32)


def _stepped(swimmers: Swimmers, actions: Any) -> tuple[Batch, Flags, Flags, Flags]:
    """Make a step; return rewards, ends of tasks and of time, and successes. A twin beyond its limits ends, too."""
    reward, done, success = swimmers.act(np.asarray(actions, dtype=float))
    beyond = swimmers.lost
    done = done | beyond
    cut = ~done & (swimmers.steps * swimmers.step >= swimmers.task.seconds - 1e-9)
    return np.where(beyond, LOST, reward), done, cut, success & ~beyond
