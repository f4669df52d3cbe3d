"""Runs that a robot of known coefficients would have made, with noise or without."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import hypertuna as ht
from hypertuna.swimming.beat import settle
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import head_center, replay
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.tracks import JointSeries, Track
from hypertuna.trials.trials import Trials

NINE = ("water.added_mass[0,1-6,7]", "water.friction[0,1-6,7]", "water.drag[0,1-6,7]")  # Table III


def grid(
    frequencies: Sequence[float], amplitudes: Sequence[tuple[float, float]], phases: Sequence[float]
) -> list[ht.Gait]:
    """Gaits of HyperTuna, every frequency [Hz] with every amplitude and phase [deg]."""
    return [
        ht.Gait.from_degrees(frequency=f, amplitude=a, phase=(0, p))
        for f in frequencies
        for a in amplitudes
        for p in phases
    ]


def tank() -> list[ht.Gait]:
    """The 180 gaits that section III.D of the paper varies: 6 frequencies, 3 amplitudes, 10 phases."""
    return grid(range(1, 7), ((8, 15), (12, 20), (16, 25)), range(0, 100, 10))


def steady(
    robot: ht.Robot,
    gaits: Sequence[ht.Gait],
    *,
    noise: float = 0.0,
    seed: int = 0,
    cost: bool = True,
    told: bool = False,
) -> Trials:
    """Steady runs with relative noise, told or not told in the file."""
    found = settle(robot, ht.Gaits.of(gaits))
    rng = np.random.default_rng(seed)
    speed, spent = (
        found[name] * (1 + noise * rng.standard_normal(len(gaits))) for name in ("speed", "cost_of_transport")
    )
    return Trials(
        tuple(
            SteadyRun(
                name=f"run {k}",
                gait=gait,
                speed=float(speed[k]),
                speed_sd=noise * abs(float(found["speed"][k])) if told else None,
                cost_of_transport=float(spent[k]) if cost else None,
                cost_of_transport_sd=noise * float(found["cost_of_transport"][k]) if told and cost else None,
                file="synthetic.csv",
            )
            for k, gait in enumerate(gaits)
        )
    )


def swims(robot: ht.Robot, *, runs: int = 3, noise: float = 0.0, late: float = 0.0, seed: int = 0) -> Trials:
    """A recording of a beat that sets in, and tracks of the head [m, rad] whose clock is `late` [s]."""
    groups = len(robot.joints)
    time = np.linspace(0, 2, 101)
    ramp = np.minimum(time, 1) ** 2 * (3 - 2 * np.minimum(time, 1))
    angle = np.stack([0.3 * ramp * np.sin(2 * np.pi * time - 0.9 * g) for g in range(groups)], axis=1)
    joints = JointSeries(time, angle)
    made = replay(robot, smooth(joints, noise=0.0), time_offset=late)
    pose, clock = head_center(robot, made), made["time"].to_numpy()
    frames = np.arange(late, 1.7, 1 / 30)
    rng = np.random.default_rng(seed)
    tracks = []
    for k in range(runs):
        at = np.column_stack([np.interp(frames, clock, pose[:, axis]) for axis in range(3)])
        drift = noise * rng.standard_normal(3) * (frames - frames[0])[:, np.newaxis]  # errors go on from frame to frame
        tracks.append(Track(str(k), frames, at + drift))
    return Trials((Recording("swim", joints, 0.0, tuple(tracks), file="synthetic.toml"),))
