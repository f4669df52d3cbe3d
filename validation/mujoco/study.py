"""HyperTuna in MuJoCo beside the same gaits here: in the plane by all water laws, and in space by the engine plugin.

In space the reference integrates the accelerations of the core's body, with the joints on their gait, by Runge and
Kutta's method in Python.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

import hypertuna as ht
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.io.files import rows_csv
from hypertuna.simulation.sea import Sea, space_columns, world_at_sea
from hypertuna.swimming.model import core_model

BEATS = 80  # from rest: the slowest gait approaches its settled beat by 13 % a beat
STEPS = 256  # per beat, of the reference in space
SECONDS, DEPTH = 8.0, 10.0  # swims in space: duration [s], depth at the start [m]
FINS = (-0.3, 0.0, 0.15)  # rad, deflections of both fins


def gaits(robot: ht.Robot) -> list[str]:
    """Return the names of the published gaits."""
    return [name for name in robot.gaits if name != "turning"]


def play(m: mujoco.MjModel, gait: str, seconds: float, fins: float | None = None) -> Array:
    """Return time and position of the nose (steps, 4) from rest."""
    d = mujoco.MjData(m)
    frequency, *angles = m.numeric(gait).data
    amplitude, phase, bias = np.reshape(angles, (3, -1))
    if fins is not None:
        d.ctrl[-2:] = fins
    path = np.empty((round(seconds / m.opt.timestep), 4))
    for row in path:
        d.ctrl[: len(phase)] = bias + amplitude * np.sin(2 * np.pi * frequency * d.time - phase)
        mujoco.mj_step(m, d)
        row[:] = d.time, *d.sensor("position").data
    return path


def last_beat(path: Array, period: float) -> Array:
    """Return the displacement over the last beat (3,) [m]."""
    now, before = ([np.interp(path[-1, 0] - ago, path[:, 0], at) for at in path.T[1:]] for ago in (0, period))
    return np.subtract(now, before)


def in_the_plane(plugin: bool, laws: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    """Yield rows of speeds in the plane."""
    for law in laws:
        robot = ht.load("hypertuna").using(joints="ideal", water=law)
        m = mujoco.MjModel.from_xml_string(ht.mjcf(robot, plugin=plugin))
        for gait in gaits(robot):
            period, ours = 1 / robot.gaits[gait].frequency, ht.swim(robot, gait).speed
            theirs = float(np.linalg.norm(last_beat(play(m, gait, BEATS * period), period)) / period)
            yield row("plugin" if plugin else "stock", law, gait, "", ours, theirs)


def row(water: str, law: str, gait: str, fins: Any, ours: float, theirs: float, **more: float) -> dict[str, Any]:
    """Return a row of the table."""
    off = 100 * (theirs / ours - 1)
    return {
        "water": water,
        "law": law,
        "gait": gait,
        "fins_rad": fins,
        "speed_m_s": round(ours, 6),
        "mujoco_m_s": round(theirs, 6),
        "difference_percent": round(off, 4),
        "depth_m": "",
        "mujoco_depth_m": "",
    } | {key: round(value, 5) for key, value in more.items()}


def in_space(law: str, gait: str, fins: float) -> dict[str, Any]:
    """Return the row of a swim in space from rest: speed over the last beat, and depth at the end."""
    robot = ht.load("hypertuna").using(joints="ideal", water=law)
    period = 1 / robot.gaits[gait].frequency
    m = mujoco.MjModel.from_xml_string(ht.mjcf(robot, plugin=True, free=True))
    m.body("L0").pos[2] = m.qpos0[2] = -DEPTH
    paths = [play(m, gait, SECONDS, fins), reference(robot, gait, fins)]
    theirs, ours = (float(np.linalg.norm(last_beat(path, period)) / period) for path in paths)
    return row(
        "plugin in space", law, gait, fins, ours, theirs, mujoco_depth_m=-paths[0][-1, 3], depth_m=-paths[1][-1, 3]
    )


def reference(robot: ht.Robot, gait: str, fins: float) -> Array:
    """Return time and position of the nose (steps, 4) by the core's accelerations."""
    beat, groups = robot.gaits[gait], len(robot.joints)
    share = np.zeros((len(robot.links.name), groups))
    for g, group in enumerate(robot.joints):
        share[list(group.links), g] = group.share
    body = _core.Body(core_model(robot), {"share": share, **space_columns(robot)})
    world, omega, amplitude, phase = (
        world_at_sea(robot, Sea()),
        2 * np.pi * beat.frequency,
        *map(np.array, (beat.amplitude, beat.phase)),
    )
    moments = np.concatenate([np.zeros((1, groups)), np.eye(groups)])

    def rate(t: float, state: Array) -> Array:
        """Return the rate of the state: position (3), attitude (4), twist (6) and fin (1)."""
        position, q, twist, fin = np.split(state, [3, 7, 13])
        angle, speed = amplitude * np.sin(omega * t - phase), omega * amplitude * np.cos(omega * t - phase)
        pose = [*position, *(q / np.linalg.norm(q)), *fin, *fin]
        states = len(moments)
        got = body.accelerations(
            world,
            bend=np.array([[angle, speed]] * states),
            twist=np.array([twist] * states),
            pose=np.array([pose] * states),
            moment=moments,
        )
        by_moment = (got[1:] - got[0]).T
        needed = np.linalg.solve(by_moment[6:], -(omega**2) * angle - got[0, 6:])  # that keeps the joints on the gait
        w, x, y, z = q
        p, o, r = twist[3:]
        turn = [-x * p - y * o - z * r, w * p + y * r - z * o, w * o + z * p - x * r, w * r + x * o - y * p]
        along = Rotation.from_quat(q, scalar_first=True).apply(twist[:3])
        towards = 2 * np.pi * robot.fins.bandwidth * (fins - fin) if robot.fins else [0]
        return np.concatenate([along, np.divide(turn, 2), got[0, :6] + by_moment[:6] @ needed, towards])

    # At rest there is no momentum, and joints that start to move make none.
    rates = omega * amplitude * np.cos(phase)
    twist = start_twist(body, world, rates, amplitude * np.sin(-phase))
    state, step = np.array([0, 0, -DEPTH, 1, 0, 0, 0, *twist, 0.0]), 1 / (beat.frequency * STEPS)
    path = np.empty((round(SECONDS / step), 4))
    for k, out in enumerate(path):
        t = k * step
        k1 = rate(t, state)
        k2 = rate(t + step / 2, state + step / 2 * k1)
        k3 = rate(t + step / 2, state + step / 2 * k2)
        k4 = rate(t + step, state + step * k3)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        out[:] = t + step, *state[:3]
    return path


def start_twist(body: _core.Body, world: _core.World, rates: Array, angle: Array) -> Array:
    """Return the twist (6,) after an impulse on the joints of a robot at rest has set them to rates."""
    moments = np.concatenate([np.zeros((1, len(rates))), np.eye(len(rates))])
    states = len(moments)
    rest = {"bend": np.array([[angle, 0 * angle]] * states), "twist": np.zeros((states, 6))}
    pose = np.array([[0, 0, -DEPTH, 1, 0, 0, 0, 0, 0.0]] * states)
    got = body.accelerations(world, **rest, pose=pose, moment=moments)
    by_moment = (got[1:] - got[0]).T
    return by_moment[:6] @ np.linalg.solve(by_moment[6:], rates)


def main() -> None:
    """Write the table."""
    top = Path(__file__).parents[2]
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", default=str(Path(__file__).with_name("speeds.csv")))
    mujoco.mj_loadPluginLibrary(str(top / "build/mujoco/libhypertuna_mujoco.so"))
    rows = [*in_the_plane(False, ("lumped",)), *in_the_plane(True, ("lumped", "strip", "elongated"))]
    rows += [in_space(law, "unoptimised-0.4", fins) for law in ("lumped", "strip", "elongated") for fins in FINS]
    rows_csv({"mujoco": mujoco.__version__, "beats": BEATS}, rows).write(parser.parse_args().output)
    for each in rows:
        print(*each.values())


if __name__ == "__main__":
    main()
