"""The noise of ripples on the water and its correlation time, from residuals of a beat fitted to tracked angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hypertuna.arrays import Array

HARMONICS = 4  # number of harmonics of the beat that are fitted
MIN_BEATS = 3.0  # beats that the film must show
MIN_FREQUENCY, MAX_FREQUENCY = 0.2, 0.2  # slowest beat [Hz]; fastest beat as a fraction of the frame rate
OVERSAMPLING = 8  # trial frequencies per 1 / (film duration)
MIN_AMPLITUDE = np.radians(1.0)  # rad: a smaller motion is no beat
MIN_FREEDOM = 3.0  # degrees of freedom that are assumed at least for Student's t
TINY = 1e-12  # rad^2: keeps divisions finite
MAX_UNEXPLAINED = 0.5  # fraction of the variance that the harmonics may leave as residuals


@dataclass(frozen=True)
class Beat:
    """A periodic motion through tracked joint angles."""

    frequency: float  # Hz
    harmonics: Array  # (1 + 2 HARMONICS, groups) [rad]: mean, then cosine and sine of each
    noise: Array  # (groups,) [rad]: standard deviation of the residuals
    memory: float  # s: correlation time of the residuals
    beats: float  # number of beats in the film

    def angle(self, time: Array) -> Array:
        """Return the joint angles (times, groups) [rad]."""
        return np.asarray(_waves(time, self.frequency) @ self.harmonics)

    @property
    def amplitude(self) -> Array:
        """Amplitude of the first harmonic (groups,) [rad]."""
        return np.asarray(np.hypot(self.harmonics[1], self.harmonics[2]))


def beat_of(time: Array, angle: Array) -> Beat | None:
    """Fit a beat to joint angles (frames, groups) [rad] at times (frames,) [s]; None if the motion is not periodic."""
    span = float(time[-1] - time[0])
    if len(time) < 4 * (1 + 2 * HARMONICS) or np.ptp(angle, axis=0).max() < 2 * MIN_AMPLITUDE:
        return None
    rate = (len(time) - 1) / span
    low, high = max(MIN_FREQUENCY, 1.5 / span), MAX_FREQUENCY * rate
    trials = np.arange(low, high, 1 / (OVERSAMPLING * span))
    if not len(trials):
        return None
    first = [_residual_sum(time, angle, f, 1) for f in trials]
    best = float(trials[int(np.argmin(first))])
    for width in (1 / (OVERSAMPLING * span), 1 / (OVERSAMPLING**2 * span), 1 / (OVERSAMPLING**3 * span)):
        finer = best + width * np.linspace(-1, 1, 17)
        best = float(finer[int(np.argmin([_residual_sum(time, angle, f, HARMONICS) for f in finer]))])
    waves = _waves(time, best)
    harmonics = np.asarray(np.linalg.lstsq(waves, angle, rcond=None)[0])
    residual = angle - waves @ harmonics
    if best * span < MIN_BEATS or (residual**2).sum() > MAX_UNEXPLAINED * ((angle - angle.mean(axis=0)) ** 2).sum():
        return None
    noise = np.asarray(residual.std(axis=0) * _fit_correction(residual, time, best))
    trusted = harmonics * _evidence(harmonics, residual, time, best)
    return Beat(best, np.asarray(trusted), noise, memory_of(residual, time), best * span)


def _evidence(harmonics: Array, residual: Array, time: Array, frequency: float) -> Array:
    """Return for each harmonic the fraction (1 + 2 HARMONICS, 1) of its power, over all joints, that is not noise.

    The noise at a harmonic's frequency is the spectrum of `residual`, from lags up to one beat (Bartlett's window).
    """
    interval, span = float(np.median(np.diff(time))), float(time[-1] - time[0])
    count = min(int(1 / (frequency * interval)) + 1, len(residual) - 1)
    lags = np.arange(1 - count, count)
    cov = np.array(
        [residual[max(lag, 0) : len(residual) + lag].T @ residual[max(-lag, 0) : len(residual) - lag] for lag in lags]
    )
    cov *= (1 - np.abs(lags) / count)[:, np.newaxis, np.newaxis] * interval / (len(residual) - len(harmonics))
    fraction = np.ones((len(harmonics), 1))
    for k in range(HARMONICS + 1):
        rows = harmonics[max(2 * k - 1, 0) : 2 * k + 1]
        spectrum = np.tensordot(np.cos(2 * np.pi * k * frequency * interval * lags), cov, axes=1)
        noise = spectrum * (2 if k else 1) / span + TINY * np.eye(len(spectrum))
        power = float((rows * np.linalg.solve(noise, rows.T).T).sum())
        fraction[max(2 * k - 1, 0) : 2 * k + 1] = max(1 - rows.size / max(power, TINY), 0.0)
    return fraction


def memory_of(residuals: Array, time: Array) -> float:
    """Return the correlation time [s] of residuals (frames, groups): (1 + 2 sum of autocorrelations) frames.

    The sum ends at the first lag whose correlation, the median over the groups, is below 0.05.
    """
    interval = float(np.median(np.diff(time)))
    centered = residuals - residuals.mean(axis=0)
    variance = (centered**2).mean(axis=0)
    total = 1.0
    for lag in range(1, len(residuals) // 3):
        correlation = (centered[lag:] * centered[:-lag]).mean(axis=0) / np.maximum(variance, 1e-300)
        if float(np.median(correlation)) < 0.05:
            break
        total += 2 * float(np.median(correlation))
    return total * interval


def _waves(time: Array, frequency: float, count: int = HARMONICS) -> Array:
    """Return the design matrix (times, 1 + 2 count) of `count` harmonics: 1, then cosine and sine of each."""
    phase = 2 * np.pi * frequency * time
    columns = [np.ones_like(time)]
    for k in range(1, count + 1):
        columns += [np.cos(k * phase), np.sin(k * phase)]
    return np.stack(columns, axis=1)


def _residual_sum(time: Array, angle: Array, frequency: float, count: int) -> float:
    """Fit `count` harmonics of a frequency [Hz] to joint angles; return the sum of squared residuals [rad^2]."""
    q, _ = np.linalg.qr(_waves(time, frequency, count))
    return float(((angle - q @ (q.T @ angle)) ** 2).sum())


def path_noise(time: Array, head: Array, frequency: float) -> Array:
    """Return standard deviations (3,) [m, m, rad] of head poses (frames, 3) about a smooth swim that is fitted to them.

    The fitted yaw is a parabola in time plus two harmonics of the beat. In axes that turn with the parabola, the
    fitted velocity is linear in time plus these harmonics: a straight swim or a turn, steady or slowly changing. The
    result is scaled by `student`, so that 1.96 of it are a 95 % interval.
    """
    span = float(time[-1] - time[0])
    since_middle = (time - time.mean()) / span
    powers = np.stack([np.ones_like(since_middle), since_middle, since_middle**2], axis=1)
    waves = _waves(time, frequency, 2)[:, 1:]
    columns = np.concatenate([powers, waves], axis=1)
    coefficients = np.linalg.lstsq(columns, head[:, 2], rcond=None)[0]
    rotation = np.exp(1j * (powers @ coefficients[:3]))
    step = np.append(0.0, np.diff(time))
    distances = [np.cumsum(step * rotation * factor) for factor in (1.0, since_middle)]
    path = np.column_stack([np.ones_like(rotation), *distances, rotation[:, np.newaxis] * waves])
    place = head[:, 0] + 1j * head[:, 1]
    off_path = place - path @ np.linalg.lstsq(path, place, rcond=None)[0]
    yaw = head[:, 2] - columns @ coefficients
    residuals = np.stack([off_path.real, off_path.imag, yaw], axis=1)
    degrees = span / memory_of(residuals, time) - columns.shape[1]
    return np.asarray(residuals.std(axis=0) * _fit_correction(residuals, time, frequency, 3, 2) * student(degrees))


def _fit_correction(residual: Array, time: Array, frequency: float, others: int = 1, waves: int = HARMONICS) -> float:
    """Return the factor from a fit's residual standard deviation to the noise's: fitted columns absorb some noise.

    Independent values: film duration over correlation time. The noise has half periods longer than its correlation
    time, so harmonics above that frequency absorb none. others: columns of the fit beside those of `waves` harmonics.
    """
    memory = memory_of(residual, time)
    values = (float(time[-1] - time[0])) / memory
    fitted = others + 2 * min(int(0.5 / (memory * frequency)) + 1, waves)
    return float(np.sqrt(values / max(values - fitted, 0.25 * values)))


def student(free: float) -> float:
    """Return the ratio of the 95 % intervals of Student's t and a normal distribution; free: degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(max(free, MIN_FREEDOM), 0.975) / stdtrit(np.inf, 0.975))
