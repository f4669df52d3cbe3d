"""Motions that no body makes: a head that flips, leaps or moves tail first, frames that repeat the one before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.trials.points import APART

Frames = NDArray[np.intp]

FLIP = math.pi / 2  # rad: half of a flip. What turns by more in a frame has no known sense of turn, either
FASTEST = 20.0  # lengths a second: beyond the bursts of fish
LONGEST_STRIDE = 3.0  # lengths a beat: the fastest fish go about one
OFTEN = 0.1  # of the steps: more jumps leave no stretch of frames that would do
BACKWARD = 0.05  # body lengths that a run must go to tell forward from backward
FEWEST, MANY = 3, 0.25  # markers and frames in a row, or part of all frames, that make straight lines no chance
CENTERED = 1e-3  # of the body: markers whose mean moves less are given from it
STILL = 0.05  # of the next smallest way: a marker that goes less stands still
ABEAM = 1.2  # way to the side over way ahead: beyond 50 deg
FILLED = (2, 4)  # orders of differences that vanish on straight lines and on cubics
FLOAT32 = 1.2e-7  # resolution of single precision
RAISED, PERIODS = 0.25, (2, 3, 4, 5)  # step of a repeated frame over that of a new one; frames after which they come
RESOLVED = 3.0  # finest steps of a coordinate: slower motion repeats frames by its rounding


def jumps_of(time: Array, pose: Array, stretches: Sequence[Frames], length: float) -> tuple[Frames, Frames]:
    """Return the frames before which the head (frames, 3) [m, m, rad] flips, and those before which it leaps away."""
    flips, leaps = [], []
    for frames in stretches:
        step, interval = np.diff(pose[frames], axis=0), np.diff(time[frames])
        turn = np.abs((step[:, 2] + math.pi) % (2 * math.pi) - math.pi)
        far = np.linalg.norm(step[:, :2], axis=1) > length * (APART + FASTEST * interval)
        flips.append(frames[1:][turn > FLIP])
        leaps.append(frames[1:][far & (turn <= FLIP)])
    none = np.zeros(0, dtype=np.intp)
    return np.concatenate([none, *flips]), np.concatenate([none, *leaps])


def jump_sentences(time: Array, flips: Frames, leaps: Frames) -> list[str]:
    """Return sentences on jumps of the head."""
    sentences = []
    for jumps, what, cause in (
        (flips, "flips", "the labels change ends, or another animal is taken"),
        (leaps, "leaps away", "another animal is taken, or the clock has a gap"),
    ):
        if len(jumps):
            k, more = int(jumps[0]), f", the first of {len(jumps)} times" if len(jumps) > 1 else ""
            sentences.append(
                f"the head {what} between {time[k - 1]:.4f} and {time[k]:.4f} s{more}: {cause}; "
                "mend the track, or leave the markers of these frames empty"
            )
    return sentences


def repeats_of(place: Array, within: float = 0.0) -> int:
    """Return how many frames of markers (frames, markers, 2) repeat the one before while the body moves.

    within: part of the usual step up to which a frame repeats. A body at rest may repeat frames. It does not stop from
    its usual speed within a frame and start so, too, nor stop so for the last frames of a run.
    """
    step = np.asarray(np.abs(np.diff(place, axis=0)))
    moved = step[np.isfinite(step) & (step > 0)]
    size = np.max(np.nan_to_num(step), axis=(1, 2))
    least = within * float(np.median(size)) if len(size) else 0.0
    seen, same = np.asarray(np.isfinite(place).all(axis=2)), np.isnan(step) | (step <= least)
    still = np.asarray(same.all(axis=(1, 2)) & (seen[1:] == seen[:-1]).all(axis=1) & seen[1:].any(axis=1))
    if not still.any() or not len(moved):
        return 0
    usual = float(np.median(size[~still]))
    if usual <= RESOLVED * float(moved.min()):
        return 0
    ends = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    return sum(
        int(end - begin)
        for begin, end in zip(ends[::2], ends[1::2], strict=True)
        if begin > 0 and size[begin - 1] > usual / 2
        if (size[end] > usual / 2 if end < len(size) else end - begin >= FEWEST)
    )


def raised_of(place: Array) -> tuple[Fraction, bool]:
    """Return by which factor the frame rate of markers (frames, markers, 2) was raised, and whether by interpolation.

    Frames were repeated where steps are small at regular intervals, interpolated where second differences are.
    """
    for order in (1, 2):
        step = np.linalg.norm(np.diff(place, n=order, axis=0), axis=2)
        known = np.isfinite(step)
        size = np.nansum(step, axis=1) / np.maximum(known.sum(axis=1), 1)
        if (factor := raised_by(np.where(known.any(axis=1), size, np.nan))) > 1:
            return factor, order == 2
    return Fraction(1), False


def raised_by(size: Array) -> Fraction:
    """Return by which factor a frame rate was raised, 1 if it was not: half of the changes or more are then small.

    size: of the changes (steps,) from frame to frame, NaN where it is not known.
    """
    for period in PERIODS:
        phase = np.arange(len(size)) % period
        known = [size[(phase == k) & np.isfinite(size)] for k in range(period)]
        if min(map(len, known)) < 2 * FEWEST:
            continue
        usual = np.array([np.median(one) for one in known])
        small = usual < RAISED * usual.max()
        if 2 * small.sum() < period:
            continue
        made, new = (np.concatenate([one for one, less in zip(known, small, strict=True) if less == which])
                     for which in (True, False))  # fmt: skip
        if np.quantile(made, 0.9) < min(np.quantile(new, 0.1), np.median(new) / 2):
            return Fraction(period, period - int(small.sum()))
    return Fraction(1)


def filled_of(place: Array) -> int:
    """Return how many frames of markers (frames, markers, 2) lie on straight lines or on cubics between others.

    Noise and the beat bend the path of a marker in every frame, unless lost frames were filled in.
    """
    return max(_filled(place, order) for order in FILLED)


def _filled(place: Array, order: int) -> int:
    """Return how many frames of markers lie where the differences of an order vanish, within rounding."""
    step = np.asarray(np.abs(np.diff(place, axis=0)))
    bend = np.asarray(np.abs(np.diff(place, n=order, axis=0)).max(axis=2))
    seen = np.isfinite(bend)
    if not seen.any() or not (step > 0).any():
        return 0
    # rounding changes a difference by up to half of the finest step times the sum of its binomial coefficients
    finest = max(float(step[step > 0].min()), float(np.nanmax(np.abs(place))) * FLOAT32) * 2.0 ** (order - 1)
    if float(np.quantile(bend[seen], 0.9)) <= RESOLVED * finest:
        return 0
    flat = (bend <= 1.005 * finest) & (step[order - 1 :].max(axis=2) > 0)
    smooth = (flat | ~seen).all(axis=1) & (flat.sum(axis=1) >= FEWEST)
    if smooth.mean() >= MANY:
        return int(smooth.sum())
    ends = np.flatnonzero(np.diff(np.concatenate([[0], smooth.astype(int), [0]])))
    runs = np.asarray(ends[1::2] - ends[::2])
    return int((runs[runs >= FEWEST] + order - 2).sum())


def still_of(place: Array) -> int | None:
    """Return the index of a marker of (frames, markers, 2) that hardly moves while all others do; None without one."""
    shown = np.asarray(np.isfinite(place).all(axis=2).any(axis=0))
    size = np.full(len(shown), np.inf)
    low, high = (np.nanquantile(place[:, shown], part, axis=0) for part in (0.05, 0.95))
    size[shown] = np.linalg.norm(high - low, axis=1)
    order = np.argsort(size)
    return int(order[0]) if len(size) > 2 and size[order[0]] < STILL * size[order[1]] else None


def follows(place: Array) -> bool:
    """Whether the mean of all markers (frames, markers, 2) stands still, as no body does: their places are from it."""
    mean = place[np.isfinite(place).all(axis=(1, 2))].mean(axis=1)
    return len(mean) > FEWEST and bool(np.ptp(mean, axis=0).max() < CENTERED * np.nanmax(np.ptp(place, axis=1)))


def _off_course(pose: Array, stretches: Sequence[Frames], length: float) -> list[Array]:
    """Return how far a head (frames, 3) [m, m, rad] moves ahead and to port in windows of a third of each stretch.

    The list has an array (2, windows) [m] per stretch; it is empty where one has no window in which the head moves.
    """
    ways = []
    for frames in stretches:
        lag = max(len(frames) // 3, 1)
        own = pose[frames]
        facing = np.stack([np.cos(own[:, 2]), np.sin(own[:, 2])], axis=1)
        mean = np.cumsum(np.vstack([np.zeros(2), facing]), axis=0)
        step, way = own[lag:, :2] - own[:-lag, :2], (mean[lag:-1] - mean[: -lag - 1]) / lag
        ahead, port = (step * way).sum(axis=1), step[:, 1] * way[:, 0] - step[:, 0] * way[:, 1]
        if not len(ahead) or max(np.abs(ahead).max(), np.abs(port).max()) < BACKWARD * length / 3:
            return []
        ways.append(np.stack([ahead, port]))
    return ways


def tail_first(pose: Array, stretches: Sequence[Frames], length: float) -> bool:
    """Whether a head (frames, 3) [m, m, rad] moves against the direction that it faces, all the time."""
    ways = _off_course(pose, stretches, length)
    return bool(ways) and all(ahead.max() < 0 and ahead.min() <= -BACKWARD * length / 3 for ahead, _ in ways)


def sideways(pose: Array, stretches: Sequence[Frames], length: float) -> bool:
    """Whether a head (frames, 3) [m, m, rad] moves to one of its sides rather than ahead or back, all the time."""
    ways = _off_course(pose, stretches, length)
    return bool(ways) and all(
        (np.abs(port) > ABEAM * np.abs(ahead)).all() and abs(np.sign(port).sum()) == len(port) for ahead, port in ways
    )


def speed_of(time: Array, pose: Array, *, part: float = 0.5) -> float:
    """Return a quantile of the head's speeds from frame to frame [m/s], by default the median."""
    return float(np.quantile(np.linalg.norm(np.diff(pose[:, :2], axis=0), axis=1) / np.diff(time), part))
