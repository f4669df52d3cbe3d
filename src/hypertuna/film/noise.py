"""The noise of ripples on the water, with its memory: the residuals of a periodic motion fitted to tracked angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hypertuna.arrays import Array

HARMONICS = 4
LEAST_BEATS = 3.0  # in the film
SLOWEST, FASTEST = 0.2, 0.2  # beats per second; of the frame rate
TRIALS = 8  # of a frequency, per resolution of the film
SMALL_BEAT = np.radians(1.0)  # amplitude of a beat
LEAST_FREE = 3.0  # independent values that a deviation is known from
TINY = 1e-12  # rad^2
STEADY = 0.5  # part of the variance that the harmonics must tell


@dataclass(frozen=True)
class Beat:
    """A periodic motion through tracked joint angles."""

    frequency: float  # Hz
    harmonics: Array  # (1 + 2 HARMONICS, groups) [rad]: mean, then cosine and sine of each
    noise: Array  # (groups,) [rad]: standard deviation of the residuals
    memory: float  # s: over which it is correlated
    beats: float  # in the film

    def angle(self, time: Array) -> Array:
        """Return the joint angles (times, groups) [rad]."""
        return np.asarray(_waves(time, self.frequency) @ self.harmonics)

    @property
    def amplitude(self) -> Array:
        """Amplitude of the first harmonic (groups,) [rad]."""
        return np.asarray(np.hypot(self.harmonics[1], self.harmonics[2]))


def beat_of(time: Array, angle: Array) -> Beat | None:
    """Fit harmonics to joint angles (frames, groups) [rad]; None where the motion is not periodic."""
    span = float(time[-1] - time[0])
    if len(time) < 4 * (1 + 2 * HARMONICS) or np.ptp(angle, axis=0).max() < 2 * SMALL_BEAT:
        return None
    rate = (len(time) - 1) / span
    low, high = max(SLOWEST, 1.5 / span), FASTEST * rate
    trials = np.arange(low, high, 1 / (TRIALS * span))
    if not len(trials):
        return None
    first = [_left(time, angle, f, 1) for f in trials]
    best = float(trials[int(np.argmin(first))])
    for width in (1 / (TRIALS * span), 1 / (TRIALS**2 * span), 1 / (TRIALS**3 * span)):
        finer = best + width * np.linspace(-1, 1, 17)
        best = float(finer[int(np.argmin([_left(time, angle, f, HARMONICS) for f in finer]))])
    waves = _waves(time, best)
    harmonics = np.asarray(np.linalg.lstsq(waves, angle, rcond=None)[0])
    residual = angle - waves @ harmonics
    if best * span < LEAST_BEATS or (residual**2).sum() > STEADY * ((angle - angle.mean(axis=0)) ** 2).sum():
        return None
    noise = np.asarray(residual.std(axis=0) * _widened(residual, time, best))
    trusted = harmonics * _evidence(harmonics, residual, time, best)
    return Beat(best, np.asarray(trusted), noise, memory_of(residual, time), best * span)


def _evidence(harmonics: Array, left: Array, time: Array, frequency: float) -> Array:
    """Return the fraction (1 + 2 HARMONICS, 1) of each harmonic's power over all joints that noise does not explain.

    The noise of a harmonic is the spectrum of the residuals `left`, over lags of a beat (Bartlett's window).
    """
    interval, span = float(np.median(np.diff(time))), float(time[-1] - time[0])
    count = min(int(1 / (frequency * interval)) + 1, len(left) - 1)
    lags = np.arange(1 - count, count)
    cov = np.array([left[max(lag, 0) : len(left) + lag].T @ left[max(-lag, 0) : len(left) - lag] for lag in lags])
    cov *= (1 - np.abs(lags) / count)[:, np.newaxis, np.newaxis] * interval / (len(left) - len(harmonics))
    fraction = np.ones((len(harmonics), 1))
    for k in range(HARMONICS + 1):
        rows = harmonics[max(2 * k - 1, 0) : 2 * k + 1]
        spectrum = np.tensordot(np.cos(2 * np.pi * k * frequency * interval * lags), cov, axes=1)
        noise = spectrum * (2 if k else 1) / span + TINY * np.eye(len(spectrum))
        power = float((rows * np.linalg.solve(noise, rows.T).T).sum())
        fraction[max(2 * k - 1, 0) : 2 * k + 1] = max(1 - rows.size / max(power, TINY), 0.0)
    return fraction


def memory_of(left: Array, time: Array) -> float:
    """Return the time [s] over which residuals (frames, groups) are correlated: 1 + 2 sum of correlations, in frames.

    The sum ends at the first lag whose correlation is below 0.05.
    """
    interval = float(np.median(np.diff(time)))
    centered = left - left.mean(axis=0)
    variance = (centered**2).mean(axis=0)
    total = 1.0
    for lag in range(1, len(left) // 3):
        correlation = (centered[lag:] * centered[:-lag]).mean(axis=0) / np.maximum(variance, 1e-300)
        if float(np.median(correlation)) < 0.05:
            break
        total += 2 * float(np.median(correlation))
    return total * interval


def _waves(time: Array, frequency: float, count: int = HARMONICS) -> Array:
    """Return the columns (times, 1 + 2 count) of a fit of `count` harmonics: 1, then cosine and sine of each."""
    phase = 2 * np.pi * frequency * time
    columns = [np.ones_like(time)]
    for k in range(1, count + 1):
        columns += [np.cos(k * phase), np.sin(k * phase)]
    return np.stack(columns, axis=1)


def _left(time: Array, angle: Array, frequency: float, count: int) -> float:
    """Return the sum of squared residuals [rad^2] of joint angles about `count` harmonics of a frequency [Hz]."""
    q, _ = np.linalg.qr(_waves(time, frequency, count))
    return float(((angle - q @ (q.T @ angle)) ** 2).sum())


def path_noise(time: Array, head: Array, frequency: float) -> Array:
    """Return the standard deviations (3,) [m, m, rad] of head poses about a smooth swim, widened as for normal noise.

    The yaw is a parabola of time with harmonics of the beat; the velocity and the harmonics of the place turn with the
    yaw, the velocity linear in time: a straight swim or a turn, steady or slowly changing.
    """
    span = float(time[-1] - time[0])
    since_middle = (time - time.mean()) / span
    powers = np.stack([np.ones_like(since_middle), since_middle, since_middle**2], axis=1)
    waves = _waves(time, frequency, 2)[:, 1:]
    columns = np.concatenate([powers, waves], axis=1)
    coefficients = np.linalg.lstsq(columns, head[:, 2], rcond=None)[0]
    turn = np.exp(1j * (powers @ coefficients[:3]))
    step = np.append(0.0, np.diff(time))
    distances = [np.cumsum(step * turn * factor) for factor in (1.0, since_middle)]
    path = np.column_stack([np.ones_like(turn), *distances, turn[:, np.newaxis] * waves])
    place = head[:, 0] + 1j * head[:, 1]
    off_path = place - path @ np.linalg.lstsq(path, place, rcond=None)[0]
    yaw = head[:, 2] - columns @ coefficients
    residuals = np.stack([off_path.real, off_path.imag, yaw], axis=1)
    degrees = span / memory_of(residuals, time) - columns.shape[1]
    return np.asarray(residuals.std(axis=0) * _widened(residuals, time, frequency, 3, 2) * student(degrees))


def _widened(left: Array, time: Array, frequency: float, others: int = 1, waves: int = HARMONICS) -> float:
    """Return the noise's standard deviation over that of a fit's residuals, which the fitted columns made smaller.

    Noise of a memory has as many independent values as memories fit into the film, and lies below the frequency whose
    half period is the memory: harmonics above take none of it. others: columns of the fit beside `waves` harmonics.
    """
    memory = memory_of(left, time)
    values = (float(time[-1] - time[0])) / memory
    fitted = others + 2 * min(int(0.5 / (memory * frequency)) + 1, waves)
    return float(np.sqrt(values / max(values - fitted, 0.25 * values)))


def student(free: float) -> float:
    """Return the 95 % interval of Student's t over that of a normal distribution, for some degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(max(free, LEAST_FREE), 0.975) / stdtrit(np.inf, 0.975))
