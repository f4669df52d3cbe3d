"""Fit of an actuator to bench runs: which combinations of its unknowns they determine, and which they leave free."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.characterization.combinations import DETERMINED, Combination, Direction, combinations
from hypertuna.characterization.data import Bench
from hypertuna.characterization.sampling import draws
from hypertuna.characterization.search import (
    FIRST_LEVEL,
    KINDS,
    ROUGH,
    Problem,
    computed,
    levels,
    pose,
    search,
    start_points,
    taken_up,
)
from hypertuna.characterization.unknowns import Unknown, keys_of, with_unknowns
from hypertuna.description.robot import Robot, parse
from hypertuna.errors import InputError
from hypertuna.identification.prediction import loss_terms
from hypertuna.identification.profile import Valley, lengths
from hypertuna.identification.residuals import excess

__all__ = ["BenchFit", "fit_bench"]

Array = NDArray[np.float64]

ROUNDS, SAME_LEVEL = 10, 1e-2  # of estimating unknown noise
LEAST_FREEDOM = 2.0  # rows beyond what the fit takes up, for a noise that is not stated
STARTS = 3
PARTS = 100  # of a stage, for the progress
CONFIDENCE = 0.95
ON_BOUND = 1e-4  # of the allowed range: so near, a value sits on its bound


@dataclass(frozen=True)
class BenchFit:
    """A fit of an actuator's unknowns to bench runs.

    Attributes
    ----------
    robot : Robot
        With the fitted values and their origin.
    described : Robot
        As it was before.
    bench : Bench
    free : tuple of Unknown
    values, low, high : ndarray, shape (n,)
        Fitted value and 95 % interval, held within the bounds [SI].
    narrowing : ndarray, shape (n,)
        How many times shorter each interval is than without the bench [1].
    covariance : ndarray, shape (n, n)
        Of the logarithms that the fit goes by, `Unknown.log`.
    directions : tuple of Direction
        The singular spectrum, from the best to the least determined; as many as unknowns.
    combinations : tuple of Combination
        Those that are determined, from the best known.
    angle, volume : ndarray, shape (rows,)
        Computed bend [rad] and volume [m^3].
    noise : dict of float
        Estimated noise of the kinds whose noise is not stated: angle [rad], volume [m^3].
    rms : dict of float
        Of computed less measured, by kind.
    excess : float
        How many times larger residuals are than the stated noise, 1 at least.
    freedom : float
        Rows beyond what the fit takes up.
    quantile : float
        Of the 95 % interval, in standard deviations.
    stop : str
    converged : bool
    evaluations : int
    seconds : float
    loss : str
    draws : ndarray, shape (draws, n)
        Other actuators that meet the bench as well [SI].
    warnings : tuple of str
    """

    robot: Robot
    described: Robot
    bench: Bench
    free: tuple[Unknown, ...]
    values: Array
    low: Array
    high: Array
    narrowing: Array
    covariance: Array
    directions: tuple[Direction, ...]
    combinations: tuple[Combination, ...]
    angle: Array
    volume: Array
    noise: dict[str, float]
    rms: dict[str, float]
    excess: float
    freedom: float
    quantile: float
    stop: str
    converged: bool
    evaluations: int
    seconds: float
    loss: str
    draws: Array
    warnings: tuple[str, ...]

    @property
    def correlation(self) -> Array:
        """Correlation of the logarithms."""
        sd = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(sd, sd))


def fit_bench(
    robot: Robot,
    bench: Bench,
    free: Sequence[str] | str | None = None,
    *,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    loss: str = "soft_l1",
    starts: int = STARTS,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> BenchFit:
    """Identify what bench runs tell of an actuator, with 95 % intervals, and say what they leave free.

    Parameters
    ----------
    robot : Robot
    bench : Bench
        From `hypertuna.characterization.data.read_bench`.
    free : sequence of str or str, optional
        As for `hypertuna.characterization.unknowns.unknowns`.
    bounds : mapping, optional
        Lowest and highest value by name [SI].
    loss : {"soft_l1", "linear", "huber", "cauchy"}
        What becomes of a residual beyond its standard deviation.
    starts : int
        Searches: from the description, then from Sobol's points within the bounds.
    seed : int
        Of those points.
    progress : callable, optional
        Called with what is done and the total.

    Returns
    -------
    BenchFit

    Raises
    ------
    InputError
        If names or options cannot be used, tables are missing, or there are too few rows to tell the noise from.

    Notes
    -----
    Unknowns are sought by their logarithms x. What is held possible without the bench (the bounds) counts as one more
    measurement of each, at its described value with the standard deviation (ln upper - ln lower) / sqrt(12) of a
    uniform distribution; so the result is unique where the rows leave unknowns free, and an interval there is that of
    the bounds. With the Jacobian J of the residuals over their noise, in those units, J = U diag(s) V^T gives
    combinations sum_k V_kj x_k, products of powers: the bench knows the j-th s_j times better than it was known before,
    and both together leave 1 / sqrt(1 + s_j^2) of its interval. The profile widens that where the valley
    of equally good fits bends. Noise that is not stated is estimated from the residuals in turn with the fit.
    """
    begun = time.monotonic()
    problem = pose(robot, bench, free, bounds, loss, starts)
    points = start_points(problem, starts, seed)
    best: Any = None
    level, evaluations = np.array(FIRST_LEVEL), 0
    stated = not np.isnan(problem.sd).any()
    if not stated:  # said before the search if it is plain already
        _check_freedom(problem, len(problem.measured) - taken_up(problem.slope(points[0], level)), stated)
    for k, z in enumerate(points):
        found = search(problem, z, level, ROUGH, _ticks(progress, k, len(points) + 2))
        evaluations += int(found.nfev)
        best = found if best is None or found.cost < best.cost else best
    tick = _ticks(progress, len(points), len(points) + 2)
    for k in range(ROUNDS):
        new = levels(problem, best, level)
        if k and np.allclose(new, level, rtol=SAME_LEVEL, atol=0.0):
            break
        level, best = new, search(problem, best.x, new, tick=tick)
        evaluations += int(best.nfev)
    fit = _result(problem, best, level, evaluations, _ticks(progress, len(points) + 1, len(points) + 2))
    return replace(fit, seconds=time.monotonic() - begun)


def _ticks(progress: Callable[[int, int], None] | None, stage: int, stages: int) -> Callable[[], None]:
    """Make what counts the steps of a stage; nobody knows how many it takes, so its last part waits for its end."""
    done = 0

    def tick() -> None:
        nonlocal done
        done = min(done + 1, PARTS - 1)
        if progress is not None:
            progress(PARTS * stage + done, PARTS * stages)

    return tick


def _result(problem: Problem, found: Any, level: Array, evaluations: int, tick: Callable[[], None]) -> BenchFit:
    """Say what came out of a fit."""
    from scipy.special import stdtrit

    rows, bench = len(problem.measured), problem.bench
    residual, slope = problem.residual(found.x, level), problem.slope(found.x, level)
    freedom = rows - taken_up(slope)
    stated = not np.isnan(problem.sd).any()
    _check_freedom(problem, freedom, stated)
    over, factor = _factor(problem, residual[:rows] ** 2, freedom)
    quantile = float(stdtrit(max(freedom, 1.0), 0.5 + CONFIDENCE / 2)) if not stated or over > 1 else 1.959964
    slope[:rows] /= factor
    _, singular, vectors = np.linalg.svd(slope[:rows], full_matrices=True)
    singular = np.append(singular, np.zeros(len(problem.free)))[: len(problem.free)]
    length = _lengths(problem, found.x, level, factor, slope, singular, vectors, quantile)
    drawn = draws(problem, found.x, level, factor, slope, tick=tick)
    spread, low, high = problem.spread, *problem.ends()
    cov = vectors.T * length**2 @ vectors
    sd = np.sqrt(np.diag(cov))
    ends = np.sort([problem.values(np.clip(found.x + side * quantile * sd, low, high)) for side in (-1, 1)], axis=0)
    values = problem.values(found.x)
    directions = tuple(Direction(v, float(s), float(d)) for v, s, d in zip(vectors, singular, length, strict=True))
    ends = np.clip(ends, *np.array([[one.lower, one.upper] for one in problem.free]).T)  # rounding left them outside
    fish = with_unknowns(problem.robot, problem.free, values)
    angle, volume = computed(fish, bench)
    off = {"angle": angle - bench.angle, "volume": (volume - bench.volume)[problem.with_volume]}
    fit = BenchFit(
        robot=fish,
        described=problem.robot,
        bench=bench,
        free=problem.free,
        values=values,
        low=ends[0],
        high=ends[1],
        narrowing=1 / sd,
        covariance=np.outer(spread, spread) * cov,
        directions=directions,
        combinations=combinations(problem.free, found.x, directions, cov, drawn, quantile),
        angle=angle,
        volume=volume,
        noise={KINDS[k]: float(level[k]) for k in np.unique(problem.kind[np.isnan(problem.sd)])},
        rms={name: float(np.sqrt(np.mean(error**2))) for name, error in off.items() if len(error)},
        excess=over,
        freedom=freedom,
        quantile=quantile,
        stop=f"{str(found.message).rstrip('.')} ({evaluations} evaluations).",
        converged=bool(found.status > 0),
        evaluations=evaluations,
        seconds=0.0,
        loss=problem.loss,
        draws=np.array([problem.values(z) for z in drawn]),
        warnings=(),
    )
    return replace(fit, robot=_with_origin(fit), warnings=(*bench.warnings, *_warnings(fit)))


def _check_freedom(problem: Problem, freedom: float, stated: bool) -> None:
    """Check that noise which is not stated can be told from the residuals."""
    if not stated and freedom < LEAST_FREEDOM:
        rows = len(problem.measured)
        rule = "must be stated where the rows can be met exactly: their noise cannot be told from them"
        value, fix = f"left out in a bench of {rows} row{'s' * (rows > 1)}", "add the column, or measure more rows"
        raise InputError(rule, file=problem.bench.files[0], key="angle_sd_deg", value=value, fix=fix)


def _factor(problem: Problem, square: Array, freedom: float) -> tuple[float, float]:
    """Tell by how much residuals exceed their noise, and what intervals are multiplied by, see `certainty`."""
    part = max(freedom, 1.0) / len(square)
    over = max(1.0, excess(square, problem.loss) / math.sqrt(part))
    own = square / over**2
    _, first, second = loss_terms(problem.loss, own)
    bend_of_loss = max(float(np.mean(first + 2 * own * second)), 1e-3)
    scatter = over * math.sqrt(float(np.mean(own * first**2)) / part) / bend_of_loss
    return over, max(1.0, scatter)


def _lengths(
    problem: Problem,
    z: Array,
    level: Array,
    factor: float,
    slope: Array,
    singular: Array,
    vectors: Array,
    quantile: float,
) -> Array:
    """Return the standard deviation along every direction, with what the bending of the valley adds."""
    rows, (low, high) = len(problem.measured), problem.ends()

    def at(x: Array) -> Array:
        there = problem.residual(np.clip(z + x, low, high), level)
        there[:rows] /= factor
        return there

    sd = 1 / np.sqrt(1 + singular**2)
    return lengths(Valley(at, slope, np.minimum(low - z, 0), np.maximum(high - z, 0), vectors, sd, quantile))


def _with_origin(fit: BenchFit) -> Robot:
    """Return the fitted robot with the origin of what was fitted in its sources."""
    document = fit.robot.document()
    sources = document.setdefault("sources", {})
    files = ", ".join(dict.fromkeys(fit.bench.files))
    told: dict[str, list[str]] = {}
    for one, value, low, high, narrowing in zip(fit.free, fit.values, fit.low, fit.high, fit.narrowing, strict=True):
        sure = "" if narrowing >= DETERMINED else "; free by itself, the bench knows combinations only"
        ends = f"95 % from {low / one.described:.3g} to {high / one.described:.3g}"
        for key in keys_of(fit.described, one):
            told.setdefault(key, []).append(f"{one.name} {value / one.described:.3g} ({ends}{sure})")
    given = _given(fit.described)
    for key, parts in told.items():
        before = fit.described.source(key) if key in given else None
        text = f"fitted by hypertuna actuator fit to {files}; times what was described: {', '.join(parts)}"
        sources[key] = f"{text}. Before: {before}" if before else text
    return parse(document, file=fit.described.file)


def _given(robot: Robot) -> set[str]:
    """Keys of a robot's file, without indices."""
    unset = robot.model_copy(update={"sources": {}})
    return {re.sub(r"\[\d+\]", "", key) for key in unset.unsourced()}


def _warnings(fit: BenchFit) -> list[str]:
    """Sentences on what a reader should not overlook."""
    told = []
    if fit.excess > 1.5 and not fit.noise:
        told.append(
            f"Residuals are {fit.excess:.2g} times what the stated noise explains: the model cannot meet all rows, or "
            "the noise is understated. The intervals allow for it."
        )
    for one, value in zip(fit.free, fit.values.tolist(), strict=True):
        near = ON_BOUND * math.log(one.upper / one.lower)
        if min(math.log(value / one.lower), math.log(one.upper / value)) < near:
            told.append(f"{one.name} sits on a bound, {value:.4g} {one.unit}".removesuffix(" 1") + ".")
    if not fit.bench.unload.any() and any(one.kind == "friction" for one in fit.free):
        told.append("No row has branch = unload: friction shows in the loop only.")
    if not fit.converged:
        told.append("The search did not converge: more --starts may help.")
    return told
