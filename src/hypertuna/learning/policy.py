"""Policies: a multilayer perceptron from observations to actions, and the plain pilot to compare it with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.door import KINDS, read_npz
from hypertuna.learning.environments import SwimmerVectorEnv
from hypertuna.learning.spans import LAG
from hypertuna.learning.swimmers import Swimmers
from hypertuna.ranges import POSITIVE

Act = Callable[[NDArray[Any]], NDArray[Any]]  # observations (N, size) to actions (N, knobs)


@dataclass(frozen=True)
class Policy:
    """A perceptron with tanh between its layers; its output is clipped to -1 and 1."""

    weights: tuple[Array, ...]  # of each layer, (out, in)
    biases: tuple[Array, ...]  # of each layer, (out,)
    step: float | None = None  # step of an action in the training [s]
    task: str | None = None  # task of the training

    def __call__(self, observation: NDArray[Any]) -> Array:
        """Return the actions (N, out) of observations (N, in)."""
        value = np.asarray(observation, dtype=float)
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            value = np.tanh(value @ weight.T + bias)
        return np.clip(value @ self.weights[-1].T + self.biases[-1], -1, 1)


def read_policy(path: str | Path) -> Policy:
    """Read a policy from a file of NumPy: weight0, bias0, weight1, ..., maybe step [s] and task of the training.

    Parameters
    ----------
    path : str or Path
        As examples/learning/train_goto.py writes it.

    Returns
    -------
    Policy

    Raises
    ------
    InputError
        If the file cannot be read, or its layers do not follow each other.
    """
    stored = read_npz(path)
    if several := next((name for name in ("step", "task") if name in stored and stored[name].size != 1), None):
        fix = "store one value, or leave it out"
        raise InputError("must be one value", file=str(path), key=several, value=f"{stored[several].size}", fix=fix)
    task = str(stored.pop("task")) if "task" in stored else None
    try:
        arrays = {name: np.asarray(value, dtype=float) for name, value in stored.items()}
    except ValueError:  # an array of texts
        raise InputError("must be a whole .npz file of numbers", file=str(path), fix=KINDS["policy"].fix) from None
    step = None
    if "step" in arrays:
        step = POSITIVE.check(arrays.pop("step").tolist(), "step", "store it in seconds", file=str(path))
    layers = range(len(arrays) // 2)
    names = [f"{kind}{k}" for k in layers for kind in ("weight", "bias")]
    if not names or set(arrays) != set(names):
        fix = "store each layer as weight0, bias0, weight1, ..."
        raise InputError("must have the arrays of layers", file=str(path), value=", ".join(sorted(arrays)), fix=fix)
    weights, biases = ([arrays[f"{kind}{k}"] for k in layers] for kind in ("weight", "bias"))
    for k, (weight, bias) in enumerate(zip(weights, biases, strict=True)):
        expected = weight.shape[1:] if k == 0 else biases[k - 1].shape
        fits = bias.ndim == 1 and weight.ndim == 2 and weight.shape == bias.shape + expected
        if not (fits and np.isfinite(weight).all() and np.isfinite(bias).all()):
            rule, fix = "must be finite and follow the layer before", "store (out, in) weights and (out,) biases"
            raise InputError(rule, file=str(path), key=f"weight{k}", value=f"of shape {weight.shape}", fix=fix)
    return Policy(tuple(weights), tuple(biases), step, task)


def plain_pilot(swimmers: Swimmers, *, frequency: float = 2.0, amplitude: float = 0.5, gain: float = 2.0) -> Act:
    """Return a simple pilot for Goto: one gait [Hz, part of the largest bend], biased in proportion to the bearing."""
    joints, size = len(swimmers.robot.joints), swimmers.task.size

    def act(observation: NDArray[Any]) -> NDArray[Any]:
        cosine, sine = observation[:, -size], observation[:, -size + 1]
        bearing = np.arctan2(sine, cosine)
        action = np.tile(swimmers.rest, (len(observation), 1))
        action[:, 0] = 2 * frequency / swimmers.span.frequency - 1
        action[:, 1 : 1 + joints] = 2 * amplitude - 1
        action[:, 1 + joints : 2 * joints] = 2 * np.radians(60) / LAG - 1
        action[:, 2 * joints :] = np.clip(-gain * bearing, -1, 1)[:, np.newaxis]
        return action

    return act


def success_rate(env: SwimmerVectorEnv, act: Act, *, episodes: int, seed: int) -> dict[str, Any]:
    """Return the share of episodes that end in success, and the mean time [s] and energy [J] of those."""
    if env.mode != AutoresetMode.SAME_STEP:
        raise InputError("must be SameStep", key="autoreset_mode", value=env.mode.value, fix="leave it out")
    observation, _ = env.reset(seed=seed)
    swimmers, successes, seconds, energy = env.swimmers, [], [], []
    joules = np.zeros(env.num_envs)
    elapsed = np.zeros(env.num_envs)
    quota = np.full(env.num_envs, episodes // env.num_envs)  # equal: short episodes are not counted more often
    quota[: episodes % env.num_envs] += 1
    while quota.any():
        actions = act(observation)
        observation, _, done, cut, infos = env.step(actions)
        elapsed += swimmers.step
        joules += swimmers.step * swimmers.power * swimmers.effort
        for k in np.flatnonzero(done | cut):
            if quota[k]:
                quota[k] -= 1
                successes.append(bool(infos["final_info"]["is_success"][k]))
                if successes[-1]:
                    seconds.append(elapsed[k])
                    energy.append(joules[k])
            elapsed[k] = joules[k] = 0.0
    means = (float(np.mean(values)) if values else float("nan") for values in (seconds, energy))
    return {"episodes": len(successes), "success": float(np.mean(successes))} | dict(
        zip(("seconds", "joules"), means, strict=True)
    )
