"""Adapter of the vector environments to the interface of Stable-Baselines3."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvIndices, VecEnvObs, VecEnvStepReturn

from hypertuna.learning.environments import SwimmerVectorEnv
from hypertuna.learning.tasks import Task


class Sb3VecEnv(VecEnv):
    """A vector environment as Stable-Baselines3 takes it; arguments are those of `SwimmerVectorEnv`."""

    def __init__(self, num_envs: int, task: str | Task, **options: Any) -> None:
        self.env = SwimmerVectorEnv(num_envs, task, autoreset_mode=AutoresetMode.SAME_STEP, **options)
        self.actions: Any = None
        super().__init__(num_envs, self.env.single_observation_space, self.env.single_action_space)

    def reset(self) -> VecEnvObs:
        """Start an episode of every swimmer, from the seed that `seed` gave."""
        observation, _ = self.env.reset(seed=self._seeds[0])
        self._reset_seeds()  # seeds and options hold for one reset
        self._reset_options()
        return observation

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions for `step_wait`."""
        self.actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Make the step; return observations, rewards, ends and infos."""
        observation, reward, done, cut, infos = self.env.step(self.actions)
        success = infos["is_success"] | infos.get("final_info", infos)["is_success"]
        infos_of: list[dict[str, Any]] = [{"is_success": bool(succeeded)} for succeeded in success]
        for k in np.flatnonzero(done | cut):
            infos_of[k] |= {"terminal_observation": infos["final_obs"][k], "TimeLimit.truncated": bool(cut[k])}
        return observation, reward, done | cut, infos_of

    def close(self) -> None:
        """Release nothing: the memory is Python's."""

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of the environment, once per swimmer asked for."""
        return [getattr(self.env, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the environment."""
        setattr(self.env, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any) -> list[Any]:
        """Call a method of the environment, and return its result once per swimmer asked for."""
        result = getattr(self.env, method_name)(*args, **kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: VecEnvIndices = None) -> list[bool]:
        """Return False for each: no wrapper is used."""
        return [False for _ in self._get_indices(indices)]
