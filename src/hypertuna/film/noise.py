"""What a periodic motion leaves of tracked angles: the noise of ripples on the water, with its memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hypertuna.arrays import Array

HARMONICS = 4
LEAST_BEATS = 3.0  # in the film
SLOWEST, FASTEST = 0.2, 0.2  # beats per second; of the frame rate
TRIALS = 8  # of a frequency, per resolution of the film
SMALL_BEAT = np.radians(1.0)  # amplitude of a beat
STEADY = 0.5  # part of the variance that the harmonics must tell


@dataclass(frozen=True)
class Beat:
    """A periodic motion through tracked joint angles."""

    frequency: float  # Hz
    harmonics: Array  # (1 + 2 HARMONICS, groups) [rad]: mean, then cosine and sine of each
    noise: Array  # (groups,) [rad]: standard deviation of what is left
    memory: float  # s: over which it is correlated
    beats: float  # in the film

    def angle(self, time: Array) -> Array:
        """Return the joint angles (times, groups) [rad]."""
        return np.asarray(_waves(time, self.frequency) @ self.harmonics)

    @property
    def amplitude(self) -> Array:
        """Amplitude of the first harmonic (groups,) [rad]."""
        return np.hypot(self.harmonics[1], self.harmonics[2])


def beat_of(time: Array, angle: Array) -> Beat | None:
    """Fit harmonics to joint angles (frames, groups) [rad]; None where the motion is not periodic."""
    span = float(time[-1] - time[0])
    if len(time) < 4 * (1 + 2 * HARMONICS) or np.ptp(angle, axis=0).max() < 2 * SMALL_BEAT:
        return None
    rate = (len(time) - 1) / span
    low, high = max(SLOWEST, 1.5 / span), FASTEST * rate
    grid = np.arange(low, high, 1 / (TRIALS * span))
    if not len(grid):
        return None
    first = [_left(time, angle, f, 1) for f in grid]
    best = float(grid[int(np.argmin(first))])
    for width in (1 / (TRIALS * span), 1 / (TRIALS**2 * span), 1 / (TRIALS**3 * span)):
        near = best + width * np.linspace(-1, 1, 17)
        best = float(near[int(np.argmin([_left(time, angle, f, HARMONICS) for f in near]))])
    waves = _waves(time, best)
    harmonics = np.linalg.lstsq(waves, angle, rcond=None)[0]
    left = angle - waves @ harmonics
    if best * span < LEAST_BEATS or (left**2).sum() > STEADY * ((angle - angle.mean(axis=0)) ** 2).sum():
        return None
    freedom = len(time) / max(len(time) - waves.shape[1] - 1, 1)
    return Beat(best, harmonics, left.std(axis=0) * np.sqrt(freedom), memory_of(left, time), best * span)


def memory_of(left: Array, time: Array) -> float:
    """Return the time [s] over which residuals (frames, groups) are correlated: 1 + 2 sum of correlations, in frames.

    The sum ends at the first lag whose correlation is below 0.05.
    """
    interval = float(np.median(np.diff(time)))
    centered = left - left.mean(axis=0)
    variance = (centered**2).mean(axis=0)
    total = 1.0
    for lag in range(1, len(left) // 3):
        both = (centered[lag:] * centered[:-lag]).mean(axis=0) / np.maximum(variance, 1e-300)
        if float(np.median(both)) < 0.05:
            break
        total += 2 * float(np.median(both))
    return total * interval


def _waves(time: Array, frequency: float, count: int = HARMONICS) -> Array:
    """Return columns (times, 1 + 2 count): 1, cosines and sines."""
    phase = 2 * np.pi * frequency * time
    columns = [np.ones_like(time)]
    for k in range(1, count + 1):
        columns += [np.cos(k * phase), np.sin(k * phase)]
    return np.stack(columns, axis=1)


def _left(time: Array, angle: Array, frequency: float, count: int) -> float:
    """Return the sum of squares that harmonics of a frequency leave."""
    q, _ = np.linalg.qr(_waves(time, frequency, count))
    return float(((angle - q @ (q.T @ angle)) ** 2).sum())


def path_noise(time: Array, head: Array, frequency: float) -> Array:
    """Return the standard deviations (3,) [m, m, rad] of what a swim along a smooth path leaves of head poses.

    The path and the yaw are polynomials of time with harmonics of the beat, which turn with the fish.
    """
    order = 2 + min(int(frequency * (time[-1] - time[0]) / 3), 6)
    powers = np.polynomial.legendre.legvander(np.interp(time, time[[0, -1]], [-1.0, 1.0]), order)
    waves = _waves(time, frequency, 2)[:, 1:]
    yaw = np.concatenate([powers, waves], axis=1)
    slow = np.linalg.lstsq(yaw, head[:, 2], rcond=None)[0]
    faced = np.exp(1j * (powers @ slow[: order + 1]))[:, np.newaxis]
    path = np.concatenate([powers, faced * waves, 1j * faced * waves], axis=1)
    place = head[:, 0] + 1j * head[:, 1]
    rows = np.concatenate([path.real, path.imag]), np.concatenate([place.real, place.imag])
    # powers have complex coefficients: those of x and of y
    both = np.concatenate([rows[0], np.concatenate([np.zeros_like(powers), powers])], axis=1)
    left = (rows[1] - both @ np.linalg.lstsq(both, rows[1], rcond=None)[0]).reshape(2, -1)
    off = head[:, 2] - yaw @ slow
    return np.array([*(left**2).mean(axis=1) ** 0.5, float((off**2).mean() ** 0.5)])
