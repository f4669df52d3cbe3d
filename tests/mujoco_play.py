"""Robots in MuJoCo: models of them, with the engine plugin of `make mujoco-plugin` too, and gaits that they play."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arrays import Array

PLUGIN = Path(__file__).parents[1] / "build/mujoco/libhypertuna_mujoco.so"
PUBLISHED = tuple(name for name in ht.load("hypertuna").gaits if name != "turning")


@cache
def load_plugin() -> None:
    """Load the plugin, or skip."""
    if not PLUGIN.is_file():
        pytest.skip("the plugin for MuJoCo is not built: run `make mujoco-plugin`")
    mujoco.mj_loadPluginLibrary(str(PLUGIN))


def model(robot: ht.Robot, **options: Any) -> mujoco.MjModel:
    """The robot in MuJoCo."""
    if options.get("plugin"):
        load_plugin()
    return mujoco.MjModel.from_xml_string(ht.mjcf(robot, **options))


def play(
    m: mujoco.MjModel, gait: str, beats: int, prefix: str = "", moment: Callable[[float], float] | None = None
) -> Array:
    """Time and place of the nose (steps, 3) while it swims a gait of the file from rest, as the docs do it.

    `moment` [N m] is what the last actuator gives, by the gait's clock [rad].
    """
    d = mujoco.MjData(m)
    frequency, *angles = m.numeric(gait).data
    amplitude, phase, bias = np.reshape(angles, (3, -1))
    path = np.empty((round(beats / (frequency * m.opt.timestep)), 3))
    for row in path:
        d.ctrl[: len(phase)] = bias + amplitude * np.sin(2 * np.pi * frequency * d.time - phase)
        if moment is not None:
            d.ctrl[-1] = moment(2 * np.pi * frequency * d.time)
        mujoco.mj_step(m, d)
        row[:] = d.time, *d.sensor(f"{prefix}position").data[:2]
    return path


def speed(m: mujoco.MjModel, gait: str, beats: int, **options: Any) -> float:
    """Mean speed over the last of some beats from rest [m/s]."""
    path, period = play(m, gait, beats, **options), 1 / m.numeric(gait).data[0]
    ends = [[np.interp(path[-1, 0] - before, path[:, 0], at) for at in path.T[1:]] for before in (0, period)]
    return float(np.hypot(*np.subtract(*ends)) / period)
