"""The stock file in single precision: MJX and MuJoCo Warp on this processor, beside MuJoCo in double precision.

Needs `pip install mujoco-mjx mujoco-warp` (1.2 GB); each compiles for one to two minutes.
"""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arrays import Array
from mujoco_play import model

SECONDS = 0.5  # of each simulation
M = model(ht.load("hypertuna").using(joints="ideal", water="lumped"))  # HyperTuna in MuJoCo
FREQUENCY, *ANGLES = M.numeric("unoptimised-0.5").data
AMPLITUDE, PHASE, BIAS = np.reshape(ANGLES, (3, -1))
TIMES = np.arange(0, SECONDS, M.opt.timestep)[:, np.newaxis]  # of steps [s]
CONTROLS = BIAS + AMPLITUDE * np.sin(2 * np.pi * FREQUENCY * TIMES - PHASE)  # joint angles at each step [rad]


def check(name: str, place: Array) -> None:
    """Compare the head's x, y [m] and heading [rad] with MuJoCo's, within 3 % of the distance and of the turn."""
    d = mujoco.MjData(M)
    for control in CONTROLS:
        d.ctrl = control
        mujoco.mj_step(M, d)
    way, turn = np.hypot(*d.qpos[:2]), abs(d.qpos[2])
    off = np.abs(place - d.qpos[:3]) / [way, way, turn]
    print(f"{name}: {place}, MuJoCo: {d.qpos[:3]}, off by {100 * off} %")
    assert (off < 0.03).all()
    assert way > 0.1


def test_mjx() -> None:
    mjx = pytest.importorskip("mujoco.mjx", reason="needs mujoco-mjx")
    import jax

    there, controls = mjx.put_model(M), jax.numpy.asarray(CONTROLS)
    begin = mjx.put_data(M, mujoco.MjData(M))

    @jax.jit
    def swim(begin: mjx.Data) -> mjx.Data:
        return jax.lax.fori_loop(
            0, len(controls), lambda k, d: mjx.step(there, d.replace(ctrl=controls[k].astype(d.ctrl.dtype))), begin
        )

    place = np.asarray(swim(begin).qpos)
    assert place.dtype == np.float32
    check("MJX", place[:3])


def test_warp() -> None:
    warp = pytest.importorskip("mujoco_warp", reason="needs mujoco-warp")
    there, now = warp.put_model(M), warp.put_data(M, mujoco.MjData(M))
    for control in CONTROLS:
        now.ctrl.assign(control[np.newaxis].astype(np.float32))
        warp.step(there, now)
    check("MuJoCo Warp", now.qpos.numpy()[0, :3])
