"""The lumped law in MuJoCo: an independent rigid-body engine, exact up to rounding.

Each link has mass ``m (1 + c_m)`` and its own inertia, not scaled (added mass acts on translation only). The base is
slide, slide, hinge; the equations of motion ``M qdd + bias = torque + drag`` give base accelerations from the first
three rows and joint torques from the others. Drag is put in by MuJoCo's own velocities, frames and Jacobians.
"""

from __future__ import annotations

import mujoco
import numpy as np

from oracles.planar import Chain, Joints, Lumped, Real

BASE = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'


def model(chain: Chain, water: Lumped) -> mujoco.MjModel:
    """MuJoCo model of a chain with arrays (n,), the nose at the origin, the links along x."""
    bodies, front = "", 0.0
    for i, mass in enumerate(chain.mass * (1 + water.added_mass)):
        inertia = " ".join([repr(float(chain.inertia[i]))] * 3)
        bodies += (
            f'<body pos="{front!r} 0 0">{BASE if i == 0 else ""}<joint type="hinge" axis="0 0 1"/>'
            f'<inertial pos="{float(chain.com[i])!r} 0 0" mass="{float(mass)!r}" diaginertia="{inertia}"/>'
        )
        front = float(chain.length[i])
    bodies += "</body>" * len(chain.mass)
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0"><flag contact="disable"/></option><worldbody>{bodies}</worldbody></mujoco>'
    )


def drag(m: mujoco.MjModel, d: mujoco.MjData, water: Lumped) -> Real:
    """Generalized force (n + 2,) of friction and drag at the centers of mass."""
    total = np.zeros(m.nv)
    for i in range(m.nbody - 1):
        velocity = np.zeros(6)  # angular, then linear, at the center of mass, in its frame
        mujoco.mj_objectVelocity(m, d, mujoco.mjtObj.mjOBJ_BODY, i + 1, velocity, 1)
        along, across = velocity[3], velocity[4]
        local = np.array(
            [
                -0.5 * water.density * water.friction[i] * water.friction_area[i] * along * abs(along),
                -0.5 * water.density * water.drag[i] * water.drag_area[i] * across * abs(across),
                0.0,
            ]
        )
        force = d.ximat[i + 1].reshape(3, 3) @ local
        mujoco.mj_applyFT(m, d, force, np.zeros(3), d.xipos[i + 1], i + 1, total)
    return total


def solve(chain: Chain, water: Lumped, joints: Joints, state: Real) -> tuple[Real, Real]:
    """World accelerations of nose x, y and head angle (3,), and joint torques (n - 1,), for ``state`` (6,)."""
    m = model(chain, water)
    d = mujoco.MjData(m)
    d.qpos[:] = np.concatenate([state[:3], joints.angle[1:]])
    d.qvel[:] = np.concatenate([state[3:], joints.rate[1:]])
    mujoco.mj_forward(m, d)
    matrix = np.zeros((m.nv, m.nv))
    for k, unit in enumerate(np.eye(m.nv)):
        mujoco.mj_mulM(m, d, matrix[k], unit)
    load = drag(m, d, water) - d.qfrc_bias
    given = joints.acceleration[1:]
    base = np.linalg.solve(matrix[:3, :3], load[:3] - matrix[:3, 3:] @ given)
    return base, matrix[3:, :3] @ base + matrix[3:, 3:] @ given - load[3:]
