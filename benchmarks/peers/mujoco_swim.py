"""The model in MuJoCo: the chain as bodies, the joints driven, the drag applied to the bodies.

- Added mass is isotropic, so it goes into the bodies' masses and leaves their inertias alone.
- Joint angles and rates are set at every step. Their accelerations are imposed through a rotor inertia (armature) far
  above the fish's, with the torque that gives it the wanted acceleration: the water moves it by parts in 1e7, and
  MuJoCo's own solver finds the motion of the free base. That spares a constraint solver and inverse dynamics.
- Drag goes through `xfrc_applied` between `mj_step1` and `mj_step2`, by a compiled (numba) function: NumPy on so small
  arrays would take longer than MuJoCo itself.
- MuJoCo's default integrator (semi-implicit Euler, first order), as many steps per beat as all peers. Its RK4 would
  call the drag four times a step.
"""

from __future__ import annotations

import mujoco
import numba
import numpy as np

from peers.fish import STEPS, Array, Fish, Gaits, clock

ROTOR = 1e6  # inertia of a joint's rotor [kg m^2]


def mjcf(fish: Fish, dt: float) -> str:
    """Return the chain in MuJoCo's format MJCF: nose at the origin, tail along +x."""
    head = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint axis="0 0 1"/>'
    driven = fish.share.max(axis=1) > 0
    xml = ""
    for i in reversed(range(fish.links)):
        joint = head if i == 0 else f'<joint axis="0 0 1" armature="{ROTOR}"/>' if driven[i] else ""
        inertia = " ".join([f"{fish.inertia[i]:.17g}"] * 3)
        at, com, mass = fish.length[i - 1] if i else 0, fish.com[i], fish.moving_mass[i]
        body = f'<inertial pos="{com:.17g} 0 0" mass="{mass:.17g}" diaginertia="{inertia}"/>'
        xml = f'<body pos="{at:.17g} 0 0">{joint}{body}{xml}</body>'
    options = f'<option timestep="{dt:.17g}" gravity="0 0 0"><flag contact="disable" constraint="disable"/></option>'
    return f'<mujoco><compiler boundmass="0"/>{options}<worldbody>{xml}</worldbody></mujoco>'


@numba.njit(fastmath=True)
def apply_drag(k_t, k_n, axes, com, origin, velocity, force):  # type: ignore[no-untyped-def]
    """Write the drag on each body to MuJoCo's xfrc_applied, from its xmat, xipos, subtree_com and cvel."""
    for i in range(len(k_t)):
        b = i + 1  # body 0 is the world
        c, s, w = axes[b, 0], axes[b, 3], velocity[b, 2]
        vx = velocity[b, 3] - w * (com[b, 1] - origin[1, 1])
        vy = velocity[b, 4] + w * (com[b, 0] - origin[1, 0])
        vt, vn = c * vx + s * vy, c * vy - s * vx
        ft, fn = k_t[i] * vt * abs(vt), k_n[i] * vn * abs(vn)
        force[b, 0], force[b, 1] = s * fn - c * ft, -s * ft - c * fn


class Swimmer:
    """One gait in MuJoCo, which starts at rest."""

    def __init__(self, fish: Fish, gait: Gaits, steps: int = STEPS) -> None:
        omega = 2 * np.pi * gait.frequency[0]
        model = mujoco.MjModel.from_xml_string(mjcf(fish, float(1 / (gait.frequency[0] * steps))))
        self.fish, self.frequency = fish, float(gait.frequency[0])
        self.model, self.data = model, mujoco.MjData(model)
        sin, cos = clock(steps)[::2].T[:, :, None]
        share = fish.share[fish.share.any(axis=1)].T * gait.amplitude[0][:, None]
        sin_phase, cos_phase = np.sin(gait.phase[0]), np.cos(gait.phase[0])
        # joint angle, rate and driving torque at each step of a beat [steps, joints]
        self.angle = (sin * cos_phase - cos * sin_phase) @ share
        self.rate = omega * (cos * cos_phase + sin * sin_phase) @ share
        self.torque = -ROTOR * omega**2 * self.angle

    def beat(self) -> None:
        """Swim one beat."""
        model, data, fish = self.model, self.data, self.fish
        joint_angle, joint_rate, joint_torque = data.qpos[3:], data.qvel[3:], data.qfrc_applied[3:]
        where = (data.xmat, data.xipos, data.subtree_com, data.cvel, data.xfrc_applied)
        for angle, rate, torque in zip(self.angle, self.rate, self.torque, strict=True):
            joint_angle[:], joint_rate[:], joint_torque[:] = angle, rate, torque
            mujoco.mj_step1(model, data)
            apply_drag(fish.k_t, fish.k_n, *where)
            mujoco.mj_step2(model, data)

    def position(self) -> Array:
        """Return the position [2] of the nose, m."""
        return np.array(self.data.qpos[:2])


def swim(swimmer: Swimmer, beats: int) -> float:
    """Return the speed over the last of `beats` further beats, m/s."""
    for _ in range(beats - 1):
        swimmer.beat()
    before = swimmer.position()
    swimmer.beat()
    return float(np.hypot(*(swimmer.position() - before)) * swimmer.frequency)
