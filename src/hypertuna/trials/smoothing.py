"""Smoothing: turn measured joint angles into functions of time with rates and accelerations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.ranges import NOT_NEGATIVE
from hypertuna.trials.tracks import JointSeries, series_columns

DEGREE = 5  # of the splines, whose accelerations are cubic
NEIGHBORS = np.array([-3, -2, -1, 1, 2, 3])  # offsets of the samples from which a sample's noise is estimated
HARMONICS = 6  # largest number of harmonics of a periodic motion
MIN_BEATS = 2.0  # least number of beats of a periodic motion
SAMPLES_PER_INTERVAL = 4  # least number of samples per interval between knots
INTERVAL_GROWTH = 1.15  # ratio of successive numbers of intervals that are tried
GRID, PADDING, NEAR = 512, 8, 0.1  # least points and padding factor of a spectrum; relative error of its peak
MIN_NOISE = 1e-9  # rad: smaller residuals do not count as noise


class Curve(Protocol):
    """A function of time with derivatives."""

    def derivative(self, order: int, /) -> Callable[[Array], Array]:
        """Return the derivative of some order as a function; order 0 is the curve itself."""


@dataclass(frozen=True)
class Harmonics:
    """A periodic motion: mean, then cosines and sines of the beat and its multiples."""

    frequency: float  # Hz
    cosine: Array  # (harmonics + 1,) [rad], the first one the mean
    sine: Array  # (harmonics + 1,) [rad], the first one 0

    def derivative(self, order: int) -> Callable[[Array], Array]:
        """Return the derivative of some order as a function; each order adds pi/2 to phases and multiplies by omega."""
        omega = 2 * math.pi * self.frequency * np.arange(len(self.cosine))

        def at(time: Array) -> Array:
            phase = np.outer(time, omega) + order * math.pi / 2
            return np.asarray((np.cos(phase) * self.cosine + np.sin(phase) * self.sine) @ omega**order)

        return at


@dataclass(frozen=True)
class SmoothSeries(Plotted, Tabular, data=lambda smooth: smooth._columns()):
    """A joint series as functions of time with rates and accelerations."""

    series: JointSeries  # as measured
    noise: Array  # (groups,) [rad], standard deviation of the noise
    curves: tuple[Curve, ...]  # angle of each joint group [rad] over time [s]
    memory: float = 1.0  # correlation time of the noise, in samples

    def _columns(self) -> dict[str, Array]:
        """Return the smoothed angles and rates at the samples as columns."""
        angle, rate, _ = np.moveaxis(self(self.series.time), -1, 0)
        return series_columns(self.series.time, angle=angle, rate=rate)

    def drawn(self, rng: np.random.Generator) -> JointSeries:
        """Return the smooth angles with new random noise of the same standard deviation and correlation time.

        Parameters
        ----------
        rng : numpy.random.Generator

        Returns
        -------
        JointSeries
        """
        angle = self(self.series.time)[:, :, 0]
        noise, keep = rng.standard_normal(angle.shape), (self.memory - 1) / (self.memory + 1)
        # First-order autoregressive noise: its memory is 1 + 2 (keep + keep^2 + ...).
        for k in range(1, len(noise) if keep else 0):
            noise[k] = keep * noise[k - 1] + math.sqrt(1 - keep**2) * noise[k]
        return replace(self.series, angle=angle + self.noise * noise)

    def __call__(self, time: Array) -> Array:
        """Evaluate the joint groups: `time` (times,) [s]; returns (times, groups, 3) [rad], [rad/s], [rad/s^2]."""
        derivatives = [[curve.derivative(order)(time) for order in range(3)] for curve in self.curves]
        return np.moveaxis(np.array(derivatives), -1, 0)


@checked
def smooth(
    series: JointSeries, *, noise: float | Sequence[float] | None = None, noise_tau: float | None = None
) -> SmoothSeries:
    """Smooth a joint series by the motion that explains its samples with the fewest parameters.

    Candidates are periodic motions of 1 to 6 harmonics and quintic splines of evenly spaced knots, the same for all
    joint groups. The Bayesian information criterion chooses: the sum over the groups of K ln(residual variance) of K
    independent samples, plus ln K for each number. Residuals below the given noise count as the noise.

    Parameters
    ----------
    series : JointSeries
    noise : float or sequence of float, shape (groups,), optional
        Standard deviation sigma of the measured angles [rad], one for all joint groups or one each; 0 interpolates by
        quintic splines. Default: estimated for each joint group from the residuals of polynomials through three
        samples on either side of a sample.
    noise_tau : float, optional
        Memory of the noise [s]: samples of a time T count as T / noise_tau independent ones, as those of noise whose
        autocorrelation has this integral over all lags, negative ones included. Default: all samples are independent.

    Returns
    -------
    SmoothSeries
    """
    from scipy.interpolate import make_interp_spline  # imported here: slow to import

    groups = series.angle.shape[1]
    for value in () if noise is None else np.ravel(noise).tolist():
        NOT_NEGATIVE.check(value, "noise", "give the standard deviation of the measured angles in radians")
    if noise is not None and np.size(noise) not in (1, groups):
        rule, fix = f"must be one number, or {groups}, one for each joint group", "give as many numbers"
        raise InputError(rule, file=series.file, key="noise", value=f"{np.size(noise)} long", fix=fix)
    if noise_tau is not None:
        NOT_NEGATIVE.check(noise_tau, "noise_tau", "give the memory of the noise in seconds")
    stated = np.zeros(groups) if noise is None else np.broadcast_to(np.ravel(noise), groups).astype(float)
    sigma = white_noise(series.angle, series.time) if noise is None else stated
    memory = max(1.0, (noise_tau or 0.0) / float(np.median(np.diff(series.time))))
    if noise is not None and not stated.any():
        splines = [make_interp_spline(series.time, angle, k=DEGREE) for angle in series.angle.T]
        return SmoothSeries(series, sigma, tuple(splines), memory)
    floor, count = np.maximum(stated, MIN_NOISE) ** 2, len(series.time) / memory
    best, curves = math.inf, None
    for residual, numbers, candidate in (*_periodic(series), *_splines(series)):
        if numbers < groups * count and (score := _score(residual, numbers, floor, count)) < best:
            best, curves = score, candidate
    return SmoothSeries(series, sigma, curves or smooth(series, noise=0.0).curves, memory)


Candidate = tuple[Array, int, tuple[Curve, ...]]  # residuals (times, groups), numbers, curves


def _score(residual: Array, numbers: int, least: Array, count: float) -> float:
    """Return the Bayesian information criterion of a fit from its residuals (times, groups) and number of parameters.

    least: lower bound of the variance (groups,); count: number of independent samples.
    """
    variance = np.maximum(np.mean(residual**2, axis=0), least)
    return float(count * np.log(variance).sum() + numbers * math.log(count))


def _periodic(series: JointSeries) -> Iterator[Candidate]:
    """Yield candidates of periodic motion (residuals, number of parameters, curves), if there are two beats or more."""
    from scipy.optimize import minimize_scalar  # imported here: slow to import

    time, angle, count = series.time, series.angle, len(series.time)
    span, groups = float(np.ptp(time)), angle.shape[1]

    def fitted(frequency: float, harmonics: int) -> tuple[Array, Array]:
        phase = np.outer(time, 2 * math.pi * frequency * np.arange(1, harmonics + 1))
        basis = np.column_stack([np.ones(count), np.cos(phase), np.sin(phase)])
        numbers = np.linalg.lstsq(basis, angle, rcond=None)[0]
        return numbers, basis @ numbers - angle

    def misfit(frequency: float) -> float:
        return float((fitted(frequency, 2)[1] ** 2).sum())

    peak = strongest_frequency(time, angle)
    if span * peak < MIN_BEATS:
        return
    grid = np.linspace((1 - NEAR) * peak, (1 + NEAR) * peak, 41)
    k = int(np.argmin([misfit(frequency) for frequency in grid]))
    ends = (grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)])
    frequency = float(minimize_scalar(misfit, bounds=ends, method="bounded", options={"xatol": 1e-9 * peak}).x)
    for harmonics in range(1, HARMONICS + 1):
        if 2 * harmonics * frequency > (count - 1) / span:
            return  # beyond half the rate of the samples
        numbers, residual = fitted(frequency, harmonics)
        cosine = numbers[: harmonics + 1]
        sine = np.concatenate([np.zeros((1, groups)), numbers[harmonics + 1 :]])
        curves = tuple(Harmonics(frequency, cosine[:, g], sine[:, g]) for g in range(groups))
        yield residual, numbers.size + 1, curves


def _splines(series: JointSeries) -> Iterator[Candidate]:
    """Yield candidates of quintic splines (residuals, number of parameters, curves), with more and more knots."""
    from scipy.interpolate import BSpline, make_lsq_spline

    time, angle = series.time, series.angle
    intervals, limit = 1, len(time) // SAMPLES_PER_INTERVAL - DEGREE
    while intervals <= limit:
        inner = np.linspace(time[0], time[-1], intervals + 1)[1:-1]
        knots = np.concatenate([np.full(DEGREE + 1, time[0]), inner, np.full(DEGREE + 1, time[-1])])
        intervals = max(intervals + 1, round(INTERVAL_GROWTH * intervals))
        try:
            spline = make_lsq_spline(time, angle, knots, k=DEGREE, method="norm-eq")  # the time of "qr" is quadratic
        except (ValueError, np.linalg.LinAlgError):  # some interval between knots has no samples
            continue
        curves = tuple(BSpline(knots, column, DEGREE) for column in spline.c.T)
        yield spline(time) - angle, spline.c.size, curves


def strongest_frequency(time: Array, angle: Array) -> float:
    """Return the strongest frequency [Hz] of angles (times, groups): the peak of the power summed over groups."""
    grid_time = np.linspace(time[0], time[-1], max(GRID, len(time)))
    wave = np.column_stack([np.interp(grid_time, time, column) for column in angle.T])
    wave = (wave - wave.mean(axis=0)) * np.hanning(len(grid_time))[:, np.newaxis]
    power = (np.abs(np.fft.rfft(wave, PADDING * len(grid_time), axis=0)) ** 2).sum(axis=1)
    k = int(np.argmax(power[1:-1])) + 1
    left, middle, right = power[k - 1 : k + 2]
    bend = left - 2 * middle + right
    peak = k + (0.5 * (left - right) / bend if bend < 0 else 0.0)
    return float(peak / (PADDING * len(grid_time) * (grid_time[1] - grid_time[0])))


def white_noise(values: Array, time: Array | None = None) -> Array:
    """Estimate the noise (columns,) of samples (times, columns) from deviations from quintics through neighbors."""
    margin = NEIGHBORS.max()
    time = np.arange(len(values), dtype=float) if time is None else time
    if len(values) <= 2 * margin:
        return np.zeros(values.shape[1])
    middle = np.arange(margin, len(time) - margin)
    neighbors = middle[:, np.newaxis] + NEIGHBORS
    offset = time[neighbors] - time[middle, np.newaxis]
    # Lagrange's weights at the sample: prod_m arm_m / (arm_m - arm_j)
    weights = np.empty_like(offset)
    for j in range(len(NEIGHBORS)):
        others = np.delete(offset, j, axis=1)
        weights[:, j] = np.prod(others / (others - offset[:, j : j + 1]), axis=1)
    residual = values[middle] - np.einsum("kj,kjg->kg", weights, values[neighbors])
    return np.asarray(np.sqrt(np.mean(residual**2 / (1 + (weights**2).sum(axis=1, keepdims=True)), axis=0)))
