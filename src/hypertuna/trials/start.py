"""Find how a tracked run begins: at rest, or in motion, with a twist estimated from its first beat."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.model import parameter_names
from hypertuna.trials.replay import replay_jacobian, seen_from_start
from hypertuna.trials.smoothing import SmoothSeries, strongest_frequency, white_noise
from hypertuna.trials.tracks import JointSeries, Track

GRID = 512  # times at which joint angles are sampled to find their frequency
MIN_FRAMES = 10  # least number of frames of a run that begins in motion
TIME_TOLERANCE = 1e-9  # s: difference up to which two times are equal
MAX_ROUNDS, MAX_HALVINGS = 20, 8  # Gauss-Newton iterations; halvings of a step that increases the cost
COST_TOLERANCE = 1e-9  # predicted relative decrease of the cost below which the rounds end
MIN_SD = 1e-6  # m and rad: least standard deviation of a first pose
GUESS_FRAMES = 8  # least number of frames for a rough guess of the twist
STILL_RATIO = 0.5  # early over later motion of joints and head, below which a run begins at rest


@dataclass(frozen=True)
class Velocity:
    """Velocity of the center of the head link through the water at the first sample."""

    forward: float = 0.0  # m/s, where the head faces
    left: float = 0.0  # m/s, to port
    turn: float = 0.0  # rad/s, counter-clockwise

    def twist(self, robot: Robot) -> Array:
        """Return the twist (3,) of the nose: u toward the tail, v to starboard [m/s], r [rad/s]."""
        return np.array([-self.forward, -self.left - self.turn * robot.links.length[0] / 2, self.turn])


Begin = tuple[Array | None, Array]  # initial twist (3,), and errors (runs, 3) of first poses
Replayed = Callable[
    [Array | None], tuple[Array, Array, Array]
]  # by twist: poses at frames, their derivatives by the twist and by others


@dataclass(frozen=True)
class UnknownBegin:
    """Unknown initial twist (common to all runs) and errors of first poses, with the frames from which to fit them.

    Poses are relative to the first frame of their run, so an error of that frame moves and rotates the whole run.
    """

    run: NDArray[np.intp]  # (frames,): index of each frame's run
    pose: Array  # (frames, 3): tracked poses, in the axes of a replay from the origin
    sd: Array  # (runs, 3): standard deviations of the first poses [m, m, rad]
    twist: bool  # whether the twist is unknown
    poses: bool  # whether the first poses have unknown errors

    @classmethod
    def of(cls, pose: Sequence[Array], twist: Array | None, poses: bool) -> Self | None:
        """Return the unknowns for the poses (frames, 3) of each run, None if all is known; arguments: `begin_of`."""
        run = np.repeat(np.arange(len(pose)), [len(part) for part in pose])
        twist_unknown = twist is not None and bool(np.isnan(twist).any())
        sd = np.array([np.maximum(white_noise(part), MIN_SD) for part in pose])
        return cls(run, np.concatenate(pose), sd, twist_unknown, poses) if twist_unknown or poses else None

    def moved(self, computed: Array, by: Array, error: Array) -> tuple[Array, Array]:
        """Move poses (frames, 3) and derivatives (frames, 3, n) by the errors (runs, 3) of the runs' first poses."""
        x, y, turn = error[self.run].T
        c, s, zero = np.cos(turn), np.sin(turn), np.zeros(len(turn))
        rotation = np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1], axis=1).reshape(-1, 3, 3)
        shift = np.column_stack([x, y, turn])
        return np.einsum("fij,fj->fi", rotation, computed) + shift, rotation @ by

    def jacobian(self, moved: Array, by_twist: Array, error: Array) -> Array:
        """Return derivatives (frames, 3, unknowns) of moved poses with respect to the unknown twist and first poses."""
        by = np.zeros((len(moved), 3, error.size if self.poses else 0))
        if self.poses:
            frames, first_column, arm = np.arange(len(moved)), 3 * self.run, moved - error[self.run]
            for axis in range(3):
                by[frames, axis, first_column + axis] = 1.0
            by[frames, 0, first_column + 2], by[frames, 1, first_column + 2] = -arm[:, 1], arm[:, 0]
        return np.concatenate([by_twist, by], axis=2) if self.twist else by

    def seen(self, replayed: Replayed, twist: Array | None, error: Array) -> tuple[Array, Array, Array]:
        """Return the poses (frames, 3) of a replay from the first poses with their errors, and two sets of derivatives.

        Those by the twist come first, then those by the other unknowns.
        """
        computed, by_twist, by = replayed(twist)
        moved, derivatives = self.moved(computed, np.concatenate([by_twist, by], axis=2), error)
        return moved, derivatives[..., : by_twist.shape[2]], derivatives[..., by_twist.shape[2] :]

    def noise(self, residual_poses: Array, given: Array | None) -> Array:
        """Return the noise (3,) [m, m, rad] of frames: given, or from residuals (frames, 3); at least white noise."""
        white = self.sd.min(axis=0)
        if given is not None:
            return np.asarray(np.maximum(given, white))
        # residuals beyond white noise are model errors, which are correlated over all frames of a run
        excess = max(float(np.mean(np.mean(residual_poses**2, axis=0) / white**2)) - 1, 0.0)
        return np.asarray(white * np.sqrt(1 + len(residual_poses) / len(self.sd) * excess))

    def stepped(self, begin: Begin, step: Array) -> Begin:
        """Add a step (unknowns,) to the twist and to the errors of first poses."""
        twist, error = begin
        if self.twist and twist is not None:
            twist, step = twist + step[:3], step[3:]
        return twist, error + step.reshape(error.shape) if self.poses else error

    def cost(self, residual_poses: Array, error: Array, noise: Array) -> float:
        """Return the cost: squared residuals (frames, 3) and errors of first poses over their variances, summed."""
        first_poses = float(((error / self.sd) ** 2).sum()) if self.poses else 0.0
        return float(((residual_poses / noise) ** 2).sum()) + first_poses

    def gain(self, by: Array, error: Array, noise: Array) -> tuple[Array, Array]:
        """Return the least-squares matrix (unknowns, 3 frames) from residuals to steps, and the step due to the prior.

        noise: (3,) [m, m, rad], of frames. The prior pulls the errors of first poses toward 0.
        """
        weight = np.tile(1 / noise, len(by))
        count = by.shape[2]
        prior = np.eye(count)[count - error.size :] / self.sd.reshape(-1, 1) if self.poses else np.zeros((0, count))
        inverse = np.linalg.pinv(np.concatenate([weight[:, np.newaxis] * by.reshape(len(weight), -1), prior]))
        prior_step = inverse[:, len(weight) :] @ (error / self.sd).ravel() if self.poses else np.zeros(count)
        return np.asarray(inverse[:, : len(weight)] * weight), -prior_step


@np.errstate(over="ignore", invalid="ignore")  # after too large a step the cost is NaN, which counts as not smaller
def fit_begin(
    unknown: UnknownBegin, replayed: Replayed, twist: Array | None, error: Array, noise: Array | None
) -> tuple[Array | None, Array, Array, Array]:
    """Fit the initial twist and the errors (runs, 3) of first poses; also return poses (frames, 3) and derivatives.

    Gauss-Newton from a guess, with shorter steps where a whole step increases the cost. The derivatives include the
    change of the fitted unknowns, except for the product of residuals and curvature (Kaufman 1975). noise: of frames
    (3,) [m, m, rad]; None: estimated from the residuals of each round.
    """
    begin, seen = (twist, error), unknown.seen(replayed, twist, error)
    for rounds_left in reversed(range(MAX_ROUNDS)):
        poses, by_twist, by = seen
        if not all(np.isfinite(part).all() for part in seen):
            break
        residual = unknown.pose - poses
        frame_noise = unknown.noise(residual, noise)
        matrix = unknown.jacobian(poses, by_twist, begin[1])
        gain, prior_step = unknown.gain(matrix, begin[1], frame_noise)
        step = gain @ residual.ravel() + prior_step
        nearer = _nearer(unknown, replayed, begin, residual, matrix, step, frame_noise) if rounds_left else None
        if nearer is None:
            return *begin, poses, by - matrix @ (gain @ by.reshape(gain.shape[1], -1))
        begin, seen = nearer
    return *begin, poses, by


def _nearer(
    unknown: UnknownBegin,
    replayed: Replayed,
    begin: Begin,
    residual_poses: Array,
    matrix: Array,
    step: Array,
    noise: Array,
) -> tuple[Begin, tuple[Array, Array, Array]] | None:
    """Try a step and fractions of it; return the first with a smaller cost, and its replay, or None."""
    cost = unknown.cost(residual_poses, begin[1], noise)
    predicted = unknown.cost(residual_poses - matrix @ step, unknown.stepped(begin, step)[1], noise)
    if cost - predicted <= COST_TOLERANCE * cost:
        return None
    for k in range(MAX_HALVINGS):
        trial = unknown.stepped(begin, step / 2**k)
        seen = unknown.seen(replayed, *trial)
        if unknown.cost(unknown.pose - seen[0], trial[1], noise) < cost:
            return trial, seen
    return None


def beat_of(curve: SmoothSeries) -> tuple[float, Array]:
    """Return the strongest frequency [Hz] of joint angles, and half the range (groups,) of each [rad]."""
    time = np.linspace(curve.series.time[0], curve.series.time[-1], GRID)
    angle = curve(time)[:, :, 0]
    return strongest_frequency(time, angle), np.ptp(angle, axis=0) / 2


def begins_in_motion(curve: SmoothSeries, tracks: Sequence[Track]) -> bool:
    """Return whether runs begin in motion: joints or head move at first, compared with later.

    Joints: change of the angles in the first eighth of a beat, compared with all eighths. Head: forward speed in the
    first quarter of a beat, compared with the second half of the run.
    """
    period, series = 1 / beat_of(curve)[0], curve.series.time
    eighth = min(period, float(np.ptp(series))) / 8
    times = np.linspace(series[0], series[-1] - eighth, GRID)
    change = np.linalg.norm(curve(times + eighth)[:, :, 0] - curve(times)[:, :, 0], axis=1)
    speeds = []
    for track in tracks:
        forward, time = _forward_speed(track), track.time[1:] - track.time[0]
        early, later = time <= max(2 * eighth, time[min(3, len(time)) - 1]), time > time[-1] / 2
        speeds.append((float(forward[early].mean()), float(forward[later].mean())))
    early_speed, later_speed = np.abs(np.mean(speeds, axis=0))
    return bool(change[0] > STILL_RATIO * np.sqrt(np.mean(change**2)) or early_speed > STILL_RATIO * later_speed)


def begin_together(
    joints: JointSeries, tracks: Sequence[Track], offset: float, period: float
) -> tuple[JointSeries, list[Track]]:
    """Cut joint angles and tracks to a common first time, at which each track gets a smoothed first pose."""
    begin = max(track.time[0] for track in tracks)
    kept = np.flatnonzero(joints.time + offset >= begin - TIME_TOLERANCE)
    lines = None if joints.lines is None else [joints.lines[k] for k in kept.tolist()]
    joints = replace(joints, time=joints.time[kept], angle=joints.angle[kept], lines=lines)
    first = joints.time[0] + offset
    moved = []
    for track in tracks:
        later = track.time > first + TIME_TOLERANCE
        pose = np.concatenate([_first_pose(track, first, period)[:1], track.pose[later]])
        moved.append(Track(track.run, np.append(first, track.time[later]), pose))
    return joints, moved


def begin_of(
    robot: Robot,
    joints: Array,
    step: float,
    tracks: Sequence[Track],
    twist: Array | None,
    inexact: bool,
    *,
    until: float = math.inf,
) -> tuple[Array | None, Array]:
    """Estimate the initial twist (3,) and the errors (runs, 3) of first poses from the frames up to `until` [s].

    joints: (2 steps + 1, links, 3), which begin with the tracks. twist: None at rest, NaN if it is unknown. inexact:
    whether the first poses have errors.
    """
    error, half = np.zeros((len(tracks), 3)), robot.links.length[0] / 2
    time = [track.time - track.time[0] for track in tracks]
    pose = [seen_from_start(track.pose, math.pi) for track in tracks]
    used = [t <= min(until, 0.5 * step * (len(joints) - 1)) for t in time]
    clock = np.concatenate([t[k] for t, k in zip(time, used, strict=True)])
    unknown = UnknownBegin.of([p[k] for p, k in zip(pose, used, strict=True)], twist, inexact)
    if unknown is None:
        return twist, error
    if unknown.twist:
        twist = np.mean([_first_twist(*parts, half) for parts in zip(time, pose, strict=True)], axis=0)
    steps = min(math.ceil(float(clock.max(initial=0.0)) / step) + 1, len(joints) // 2)
    motion, no_directions = joints[: 2 * steps + 1], np.zeros((len(parameter_names(robot)), 0))

    def replayed(twist: Array | None) -> tuple[Array, Array, Array]:
        pose, _, by = replay_jacobian(robot, motion, step, no_directions, twist=twist)
        at, by = between(*head_of(half, pose, by), clock / step)
        return at, by, by[..., :0]

    return fit_begin(unknown, replayed, twist, error, None)[:2]


def with_first_poses(tracks: Sequence[Track], error: Array) -> list[Track]:
    """Correct the first poses of tracks by errors (runs, 3), which are in the axes of each first pose."""
    moved = []
    for track, (x, y, turn) in zip(tracks, error, strict=True):
        direction = track.pose[0, 2] - math.pi
        c, s = math.cos(direction), math.sin(direction)
        first = track.pose[0] + np.array([c * x - s * y, s * x + c * y, turn])
        moved.append(replace(track, pose=np.concatenate([first[np.newaxis], track.pose[1:]])))
    return moved


def between(center: Array, by: Array, clock: Array) -> tuple[Array, Array]:
    """Interpolate poses (steps + 1, 3) and derivatives at times (frames,) [steps]; before 0, return the first ones."""
    before = np.clip(np.floor(clock).astype(int), 0, len(center) - 2)
    fraction = np.clip(clock - before, 0.0, 1.0)[:, np.newaxis]
    at = center[before] * (1 - fraction) + center[before + 1] * fraction
    return at, by[before] * (1 - fraction[..., np.newaxis]) + by[before + 1] * fraction[..., np.newaxis]


def _first_twist(time: Array, pose: Array, half: float) -> Array:
    """Guess the initial twist (3,) of the nose from a parabola fitted to the first poses (frames, 3)."""
    count = max(GUESS_FRAMES, len(time) // 16)
    rate = np.polynomial.polynomial.polyfit(time[:count], pose[:count], 2)[1]
    return np.array([rate[0], rate[1] - half * rate[2], rate[2]])


def head_of(half: float, pose: Array, by: Array, by_half: Array | None = None) -> tuple[Array, Array]:
    """Convert nose poses (times, 3) that start at 0 to the head's center relative to its start, with derivatives."""
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
    """Return the speed (frames - 1,) [m/s] of the head's center in the direction it faces, between frames."""
    step = np.diff(track.pose[:, :2], axis=0) / np.diff(track.time)[:, np.newaxis]
    yaw = (track.pose[1:, 2] + track.pose[:-1, 2]) / 2
    return np.asarray(np.cos(yaw) * step[:, 0] + np.sin(yaw) * step[:, 1])


def _first_pose(track: Track, first: float, period: float) -> Array:
    """Return pose and rate (2, 3) at time `first` [s], from a quintic fitted to the first half beat."""
    used = track.time <= max(first + period / 2, track.time[min(MIN_FRAMES, len(track.time)) - 1])
    if used.sum() < MIN_FRAMES:
        rule, fix = f"must have at least {MIN_FRAMES} frames to begin in motion", 'track more, or write begin = "rest"'
        raise InputError(rule, key=f"run {track.run}", value=f"{len(track.time)}", fix=fix)
    powers = np.vander((track.time[used] - first) / period, 6, increasing=True)
    fitted = np.linalg.lstsq(powers, track.pose[used], rcond=None)[0]
    return np.asarray(fitted[:2] / [[1.0], [period]])
