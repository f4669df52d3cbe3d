"""How a tracked run begins: at rest, or in motion with a twist that its first beat shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.model import parameter_names
from hypertuna.trials.replay import replay_jacobian, seen_from_start
from hypertuna.trials.smoothing import SmoothSeries
from hypertuna.trials.tracks import JointSeries, Track

GRID = 512  # instants at which joint angles are looked at for their frequency
PADDING = 8  # of the spectrum
MIN_FRAMES = 10  # of a run that begins in motion
SAME_TIME = 1e-9  # s
STEPS = 5  # of Gauss and Newton, for the described robot
STILL = 0.5  # of what joints and head do later: those that do less begin at rest


@dataclass(frozen=True)
class Velocity:
    """Velocity of the center of the head link through the water at the first sample."""

    forward: float = 0.0  # m/s, where the head faces
    left: float = 0.0  # m/s, to port
    turn: float = 0.0  # rad/s, counter-clockwise

    def twist(self, robot: Robot) -> Array:
        """Return the twist (3,) of the nose: u toward the tail, v to starboard [m/s], r [rad/s]."""
        return np.array([-self.forward, -self.left - self.turn * robot.links.length[0] / 2, self.turn])


@dataclass(frozen=True)
class FirstBeat:
    """The first beat of a run in motion: what turns its tracked poses into the twist at its begin.

    The described robot's twist is that of least squared differences. With other coefficients it is one Gauss-Newton
    step from there, twist + gain @ (tracked - computed), whose derivatives by the coefficients are exact.
    """

    twist: Array  # (3,) [m/s, m/s, rad/s] with the coefficients of the described robot
    gain: Array  # (3, 3 frames), of the poses frame by frame
    time: Array  # (frames,) [s] after the first sample
    pose: Array  # (frames, 3), tracked, in the axes of a replay from the origin

    def correct(
        self, robot: Robot, joints: Array, step: float, along: Array, model: _core.Model
    ) -> tuple[Array, Array]:
        """Return the twist (3,) with the coefficients of a model, and its derivatives (3, directions)."""
        center, by = _first_poses(robot, joints, step, along, model, self)
        if not (np.isfinite(center).all() and np.isfinite(by).all()):
            return self.twist, np.zeros((3, along.shape[1]))
        derivative = -self.gain @ by[..., 3:].reshape(self.gain.shape[1], along.shape[1])
        return self.twist + self.gain @ (self.pose - center).ravel(), derivative


def beat_of(curve: SmoothSeries) -> tuple[float, Array]:
    """Return the strongest frequency [Hz] of joint angles and half the range (groups,) of each [rad]."""
    time = np.linspace(curve.series.time[0], curve.series.time[-1], GRID)
    angle = curve(time)[:, :, 0]
    wave = (angle - angle.mean(axis=0)) * np.hanning(GRID)[:, np.newaxis]
    power = (np.abs(np.fft.rfft(wave, PADDING * GRID, axis=0)) ** 2).sum(axis=1)
    k = int(np.argmax(power[1:-1])) + 1
    left, middle, right = power[k - 1 : k + 2]
    bend = left - 2 * middle + right
    peak = k + (0.5 * (left - right) / bend if bend < 0 else 0.0)
    return float(peak / (PADDING * GRID * (time[1] - time[0]))), np.ptp(angle, axis=0) / 2


def begins_in_motion(curve: SmoothSeries, tracks: Sequence[Track]) -> bool:
    """Return whether runs begin in motion: unless joints and head are still at first, compared with later.

    Joints: change of the angles in the first eighth of a beat, beside that of all eighths. Head: forward speed in the
    first quarter, beside that of the second half.
    """
    period, series = 1 / beat_of(curve)[0], curve.series.time
    part = min(period, float(np.ptp(series))) / 8
    times = np.linspace(series[0], series[-1] - part, GRID)
    change = np.linalg.norm(curve(times + part)[:, :, 0] - curve(times)[:, :, 0], axis=1)
    speeds = []
    for track in tracks:
        forward, time = _forward_speed(track), track.time[1:] - track.time[0]
        first, later = time <= max(2 * part, time[min(3, len(time)) - 1]), time > time[-1] / 2
        speeds.append((float(forward[first].mean()), float(forward[later].mean())))
    begin, late = np.abs(np.mean(speeds, axis=0))
    return bool(change[0] > STILL * np.sqrt(np.mean(change**2)) or begin > STILL * late)


def begin_together(
    joints: JointSeries, tracks: Sequence[Track], offset: float, period: float
) -> tuple[JointSeries, list[Track]]:
    """Cut joints and tracks of runs in motion to begin together; the first frame is that of smoothed poses."""
    begin = max(track.time[0] for track in tracks)
    kept = np.flatnonzero(joints.time + offset >= begin - SAME_TIME)
    lines = None if joints.lines is None else [joints.lines[k] for k in kept.tolist()]
    joints = replace(joints, time=joints.time[kept], angle=joints.angle[kept], lines=lines)
    first = joints.time[0] + offset
    moved = []
    for track in tracks:
        later = track.time > first + SAME_TIME
        pose = np.concatenate([_first_pose(track, first, period)[:1], track.pose[later]])
        moved.append(Track(track.run, np.append(first, track.time[later]), pose))
    return joints, moved


def first_beat(robot: Robot, joints: Array, step: float, tracks: Sequence[Track], period: float) -> FirstBeat:
    """Return the first beat of runs in motion: joints (2 steps + 1, links, 3), tracks that begin with them."""
    half = robot.links.length[0] / 2
    end = min(period, 0.5 * step * (len(joints) // 2))
    times, poses, twists = [], [], []
    for track in tracks:
        time, pose = track.time - track.time[0], seen_from_start(track.pose, math.pi)
        own = (time > 0) & (time <= end)
        times.append(time[own])
        poses.append(pose[own])
        rate = _first_pose(Track(track.run, time, pose), 0.0, period)[1]
        twists.append([rate[0], rate[1] - half * rate[2], rate[2]])
    frames = np.concatenate(times), np.concatenate(poses)
    size = 1 / np.array([robot.body.length, robot.body.length, 1.0])  # a body length beside a radian
    none = np.zeros((len(parameter_names(robot)), 0))
    beat = FirstBeat(np.mean(twists, axis=0), np.zeros((3, 3 * len(frames[0]))), *frames)
    for _ in range(STEPS):
        center, by = _first_poses(robot, joints, step, none, None, beat)
        matrix = (by * size[:, np.newaxis]).reshape(-1, 3)
        if len(matrix) < 3 or not np.isfinite(matrix).all():
            break
        gain = np.asarray(np.linalg.pinv(matrix), dtype=float) * np.tile(size, len(matrix) // 3)
        beat = replace(beat, twist=beat.twist + gain @ (beat.pose - center).ravel(), gain=gain)
    return beat


def _first_poses(
    robot: Robot, joints: Array, step: float, along: Array, model: _core.Model | None, beat: FirstBeat
) -> tuple[Array, Array]:
    """Return head centers (frames, 3) at the frames of a first beat and derivatives (frames, 3, 3 + directions)."""
    steps = min(math.ceil(float(beat.time.max(initial=0.0)) / step) + 1, len(joints) // 2)
    motion = joints[: 2 * steps + 1]
    pose, _, by = replay_jacobian(robot, motion, step, along, model=model, twist=beat.twist)
    center, by = head_of(robot.links.length[0] / 2, pose, by)
    clock = beat.time / step
    left = np.clip(np.floor(clock).astype(int), 0, steps - 1)
    part = np.clip(clock - left, 0.0, 1.0)[:, np.newaxis]
    at = center[left] * (1 - part) + center[left + 1] * part
    return at, by[left] * (1 - part[..., np.newaxis]) + by[left + 1] * part[..., np.newaxis]


def head_of(half: float, pose: Array, by: Array, by_half: Array | None = None) -> tuple[Array, Array]:
    """Return head centers (times, 3), from that of the start, of noses that start at the origin, with derivatives."""
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    center = np.column_stack([pose[:, 0] + half * (c - 1), pose[:, 1] + half * s, pose[:, 2]])
    by = by.copy()
    by[:, 0] -= (half * s)[:, np.newaxis] * by[:, 2]
    by[:, 1] += (half * c)[:, np.newaxis] * by[:, 2]
    if by_half is not None:
        by[:, 0] += np.outer(c - 1, by_half)
        by[:, 1] += np.outer(s, by_half)
    return center, by


def _forward_speed(track: Track) -> Array:
    """Return the speed (frames - 1,) [m/s] of the head's center where the head faces, between frames."""
    step = np.diff(track.pose[:, :2], axis=0) / np.diff(track.time)[:, np.newaxis]
    yaw = (track.pose[1:, 2] + track.pose[:-1, 2]) / 2
    return np.asarray(np.cos(yaw) * step[:, 0] + np.sin(yaw) * step[:, 1])


def _first_pose(track: Track, first: float, period: float) -> Array:
    """Return pose and rate (2, 3) at a time [s]: those of a quintic through the first half beat."""
    own = track.time <= max(first + period / 2, track.time[min(MIN_FRAMES, len(track.time)) - 1])
    if own.sum() < MIN_FRAMES:
        rule, fix = f"must have at least {MIN_FRAMES} frames to begin in motion", 'track more, or write begin = "rest"'
        raise InputError(rule, key=f"run {track.run}", value=f"{len(track.time)}", fix=fix)
    powers = np.vander((track.time[own] - first) / period, 6, increasing=True)
    fitted = np.linalg.lstsq(powers, track.pose[own], rcond=None)[0]
    return np.asarray(fitted[:2] / [[1.0], [period]])
