"""Fit of an actuator to bench runs: values of its unknowns, and the combinations that the bench determines."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.characterization.combinations import DETERMINED, Combination, combinations
from hypertuna.characterization.data import KINDS, Bench
from hypertuna.characterization.problem import BenchProblem, bench_problem, computed, effective_parameters
from hypertuna.characterization.sampling import randomized_fits
from hypertuna.characterization.unknowns import BORDER, Unknown, keys_of, sourced, with_unknowns
from hypertuna.characterization.unknowns import KINDS as UNKNOWNS
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.identification import estimator
from hypertuna.identification.estimator import Direction
from hypertuna.identification.loss import interval_factor, residual_scale

STARTS = 3  # searches by default
MAX_EVALUATIONS = 100  # most evaluations in one search
KNOWN = 2.0  # a determined value is known within this factor to either side
STOPS = {  # text by the status of the search
    0: f"The search was stopped after {MAX_EVALUATIONS} evaluations before it had converged",
    1: "The search converged: the gradient of the error is zero",
    2: "The search converged: the error does not change any more",
    3: "The search converged: the unknowns do not change any more",
    4: "The search converged: neither error nor unknowns change any more",
}
TOLERANCE, ROUGH = 1e-6, 1e-3  # relative change that ends the final search, and the rough searches before it
INSIDE = 1e-6  # least distance of a start from its bounds, as a part of their range
FIRST_LEVEL = {"angle": math.radians(1.0), "volume": 1e-7}  # rad, m^3: noise assumed before the first search
MIN_LEVEL = {"angle": math.radians(1e-4), "volume": 1e-11}  # rad, m^3: smallest estimated noise, that of instruments
MIN_FREEDOM = 2.0  # fewest degrees of freedom with which a noise that is not stated can be estimated
NORMAL_QUANTILE = 1.959964  # half width of a normal 95 % interval in standard deviations
LARGE_SCALE = 1.5  # a warning is given if residuals are more than this many times the stated noise
PARTS = 100  # steps of progress in each stage


@dataclass(frozen=True)
class BenchFit(Plotted, Tabular, data=lambda fit: fit.parameters):
    """A fit of an actuator's unknowns to bench runs: values, intervals, combinations and errors."""

    robot: Robot  # robot with the fitted values and their sources
    described: Robot  # before the fit
    bench: Bench
    free: tuple[Unknown, ...]
    values: Array  # (n,) [SI]
    low: Array  # (n,) [SI], 95 % interval, within the bounds
    high: Array  # (n,) [SI]
    narrowing: Array  # (n,), length of each interval without the bench over its length with the bench
    covariance: Array  # (n, n), covariance of the logarithms `Unknown.log`
    directions: tuple[Direction, ...]  # from the best to the least determined
    combinations: tuple[Combination, ...]  # determined combinations, the narrowest first
    found: dict[str, Array]  # computed values (rows,) by kind [SI]
    noise: dict[str, float]  # estimated noise of the kinds without stated noise: angle [rad], volume [m^3]
    rms: dict[str, float]  # root mean square of computed minus measured values, by kind [SI]
    residual_scale: float  # scale of the residuals over the stated noise, 1 at least
    freedom: float  # degrees of freedom
    quantile: float  # half width of a 95 % interval in standard deviations
    stop: str  # why the search ended, as a sentence
    converged: bool
    evaluations: int
    seconds: float
    loss: str
    samples: Array  # (fits, n) [SI], randomized fits
    warnings: tuple[str, ...]

    @property
    def angle(self) -> Array:
        """Computed bends (rows,) [rad]."""
        return self.found["angle"]

    @property
    def parameters(self) -> list[dict[str, Any]]:
        """Unknowns with their intervals, lengths in mm and angles in degrees."""
        rows = []
        columns = (self.free, self.values, self.low, self.high, self.narrowing)
        for unknown, value, low, high, narrowing in zip(*columns, strict=True):
            unit, factor = BORDER[unknown.unit]
            sizes = {"described": unknown.described, "value": value, "low": low, "high": high}
            bounds = {"lower": unknown.lower * factor, "upper": unknown.upper * factor}
            judgment = {"narrowing": narrowing, "determined": _determined(narrowing, low, high)}
            facts = {"unit": unit, "counted": UNKNOWNS[unknown.kind].counted} | bounds | judgment
            rows.append({"name": unknown.name} | {key: size * factor for key, size in sizes.items()} | facts)
        return rows

    @property
    def record(self) -> dict[str, Any]:
        """Record of the fit, for JSON; the robot in it is the one before the fit."""
        names = ("residual_scale", "freedom", "stop", "converged", "evaluations", "seconds", "loss", "warnings")
        directions = {"singular_value": "singular_value", "sd": "sd", "constrained": "determined", "vector": "vector"}
        return {name: getattr(self, name) for name in (*names, "correlation")} | {
            "rows": len(self.bench.angle),
            "joints_measured": [self.described.joints[j].name for j in self.bench.joints],
            "unknowns": self.parameters,
            "determined": len(self.combinations),
            "combinations": [vars(item) for item in self.combinations],
            "spectrum": [{key: getattr(item, name) for name, key in directions.items()} for item in self.directions],
            "noise": at_border(self.noise),
            "rms": at_border(self.rms),
            "fit_hash": self.robot.hash,
            **provenance(self.described),
        }

    @property
    def correlation(self) -> Array:
        """Correlations (n, n) of the unknowns' logarithms."""
        sd = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(sd, sd))


def _determined(narrowing: float, low: float, high: float) -> bool:
    """Return whether the bench determines a value: it narrows the interval threefold, to a factor of 4 at most."""
    return bool(narrowing >= DETERMINED and high <= KNOWN**2 * low)


def at_border(levels: Mapping[str, float]) -> dict[str, float]:
    """Return errors by kind in displayed units; the keys are column names that end in the unit."""
    return {KINDS[kind].column: level * KINDS[kind].factor for kind, level in levels.items()}


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
    """Fit the unknowns of an actuator to bench runs, with 95 % intervals; docs/bench.md has the theory.

    free, bounds [SI] and loss: as for `unknowns` and `hypertuna.identify`. starts: number of searches; the first starts
    from the described values, the others from Sobol points of this seed. progress: called with parts done and total.
    """
    started = time.monotonic()
    problem = bench_problem(robot, bench, free, bounds, loss, starts)
    low, high = problem.bounds()
    points = estimator.start_points([np.zeros(len(problem.free))], low, high, starts, seed)
    levels = {name: FIRST_LEVEL[name] for name in problem.unknown_kinds}
    if np.isnan(problem.elements.sd).any():  # fail early
        _check_freedom(problem, len(problem.measured) - effective_parameters(problem.jacobian(points[0], levels)))
    ticks = [_ticks(progress, k, len(points) + 2) for k in range(len(points) + 2)]

    def search(start: Array, levels: dict[str, float], stage: int) -> dict[str, Any]:
        return _search(problem, start, levels, ROUGH if stage < len(points) else TOLERANCE, ticks[stage])

    rough, refined, levels = estimator.fit(points, levels, search, lambda z, now: _levels(problem, z, now))
    result = refined[-1] | {"evaluations": sum(result["evaluations"] for result in (*rough, *refined))}
    return replace(_result(problem, result, levels, ticks[-1]), seconds=time.monotonic() - started)


def _ticks(progress: Callable[[int, int], None] | None, stage: int, stages: int) -> Callable[[], None]:
    """Return a function that reports one more step of a stage, whose number of steps is unknown in advance."""
    part = 0

    def tick() -> None:
        nonlocal part
        part = min(part + 1, PARTS - 1)
        if progress is not None:
            progress(PARTS * stage + part, PARTS * stages)

    return tick


def _search(
    problem: BenchProblem, start: Array, levels: dict[str, float], tolerance: float, tick: Callable[[], None]
) -> dict[str, Any]:
    """Return the optimum reached from a start (n,); `tick` is called at every evaluation of residuals or Jacobians."""

    def residual(z: Array) -> Array:
        tick()
        return problem.residual(z, levels)

    def jacobian(z: Array) -> Array:
        tick()
        return problem.jacobian(z, levels, rough=True)

    low, high = problem.bounds()
    margin, rows = INSIDE * (high - low), len(problem.measured)
    unit_groups = np.ones(rows, dtype=np.intp)
    result = estimator.minimize(
        estimator.LeastSquares(residual, jacobian, low, high, problem.loss, np.arange(rows), unit_groups),
        np.clip(start, low + margin, high - margin),
        ftol=tolerance,
        xtol=tolerance,
        gtol=tolerance,
        max_evaluations=MAX_EVALUATIONS,
    )
    return result | {"stop": STOPS[result["status"]], "evaluations": int(result["nfev"])}


def _levels(problem: BenchProblem, z: Array, levels: dict[str, float]) -> dict[str, float]:
    """Return the noise [rad and m^3] of kinds without stated noise, from the residuals at z (n,)."""
    # the fit of tank runs puts the degrees of freedom into the equation of the scale; equal for a linear loss
    rows = len(problem.measured)
    squares = problem.residual(z, levels)[:rows] ** 2
    share = 1 - effective_parameters(problem.jacobian(z, levels, rough=True)[:rows]) / rows
    new = dict(levels)
    for name, level in levels.items():
        chosen = (problem.elements.kind == name) & np.isnan(problem.elements.sd)
        if share > 0:
            scale = residual_scale(squares[chosen], problem.loss) / math.sqrt(share)
            new[name] = max(level * scale, MIN_LEVEL[name])
    return new


def _rms(problem: BenchProblem, errors: Array) -> dict[str, float]:
    """Return the root mean square of the errors of each kind of measurement [SI]."""
    kinds = problem.elements.kind
    return {kind: float(np.sqrt(np.mean(errors[kinds == kind] ** 2))) for kind in dict.fromkeys(kinds.tolist())}


def _result(
    problem: BenchProblem, result: dict[str, Any], levels: dict[str, float], tick: Callable[[], None]
) -> BenchFit:
    """Return the fit with intervals, combinations and warnings, from the result of a search."""
    rows, bench, z, (low, high) = len(problem.measured), problem.bench, result["x"], problem.bounds()
    residual, jacobian = problem.residual(z, levels), problem.jacobian(z, levels)
    freedom = rows - effective_parameters(jacobian)
    if levels:
        _check_freedom(problem, freedom)
    squares, share = residual[:rows] ** 2, max(freedom, 1.0) / rows
    scale = max(1.0, residual_scale(squares, problem.loss) / math.sqrt(share))
    factor = interval_factor(squares, problem.loss, scale, np.ones(rows, dtype=np.intp), max(freedom, 1.0))
    quantile = estimator.t_quantile(max(freedom, 1.0)) if levels or scale > 1 else NORMAL_QUANTILE
    jacobian[:rows] /= factor

    def scaled(point: Array) -> Array:
        residual_at = problem.residual(point, levels)
        residual_at[:rows] /= factor
        return residual_at

    options: dict[str, Any] = {"quantile": quantile, "prior": 1.0, "profile": (scaled, jacobian)}
    estimate = estimator.estimate(jacobian[:rows], z, low, high, unit=np.ones(len(z)), **options)
    points = randomized_fits(problem, z, levels, factor, jacobian, tick=tick)
    intervals = np.sort([problem.values(end) for end in (estimate.low, estimate.high)], axis=0)
    intervals = np.clip(intervals, *np.array([[item.lower, item.upper] for item in problem.free]).T)  # against rounding
    # a singular value s narrows the interval of its direction by sqrt(1 + s^2)
    directions = tuple(estimate.directions(lambda s, sd: math.hypot(1, s) >= DETERMINED))
    values = problem.values(z)
    robot = with_unknowns(problem.robot, problem.free, values)
    computed_values = computed(robot, bench)
    errors = problem.elements.of(computed_values) - problem.measured
    fit = BenchFit(
        robot=robot,
        described=problem.robot,
        bench=bench,
        free=problem.free,
        values=values,
        low=intervals[0],
        high=intervals[1],
        narrowing=1 / estimate.sd,
        covariance=np.outer(problem.prior_sd, problem.prior_sd) * estimate.covariance,
        directions=directions,
        combinations=tuple(
            item
            for item in combinations(problem.free, z, directions, estimate.covariance, points, quantile)
            if item.high <= KNOWN**2 * item.low
        ),
        found=computed_values,
        noise=levels,
        rms=_rms(problem, errors),
        residual_scale=scale,
        freedom=freedom,
        quantile=quantile,
        stop=f"{result['stop']} ({result['evaluations']} evaluations).",
        converged=bool(result["status"] > 0),
        evaluations=result["evaluations"],
        seconds=0.0,
        loss=problem.loss,
        samples=np.array([problem.values(point) for point in points]),
        warnings=(),
    )
    sides = estimator.on_bound(z, low, high)
    return replace(fit, robot=_with_sources(fit), warnings=(*bench.warnings, *_warnings(fit, sides)))


def _check_freedom(problem: BenchProblem, freedom: float) -> None:
    """Check that there are enough rows to estimate the noise, if it is not stated."""
    if freedom < MIN_FREEDOM:
        rows = len(problem.measured)
        n = len(problem.free)
        rule = f"must be a column: {rows} row{'s' * (rows > 1)} are too few for {n} unknowns to estimate their noise"
        fix = f"add a column angle_sd_deg, such as 0.5, or measure {n + math.ceil(MIN_FREEDOM)} rows"
        raise InputError(rule, file=problem.bench.files[0], key="angle_sd_deg", fix=fix)


def _with_sources(fit: BenchFit) -> Robot:
    """Return the fitted robot, with the bench named as the source of fitted values."""
    file_names = ", ".join(dict.fromkeys(fit.bench.files))
    texts: dict[str, list[str]] = {}
    for u, value, low, high, narrowing in zip(fit.free, fit.values, fit.low, fit.high, fit.narrowing, strict=True):
        determined = _determined(narrowing, low, high)
        note = "" if determined else "; not determined by itself, one of many values that fit as well"
        interval = f"95 % from {low / u.described:.3g} to {high / u.described:.3g}"
        for key in keys_of(fit.described, u):
            texts.setdefault(key, []).append(f"{u.name} {value / u.described:.3g} ({interval}{note})")
    origin = f"fitted by hypertuna joint fit to {file_names}; times what was described"
    return sourced(fit.robot, fit.described, {key: f"{origin}: {', '.join(parts)}" for key, parts in texts.items()})


def _warnings(fit: BenchFit, bound: Sequence[str | None]) -> list[str]:
    """Return warnings on residuals, bounds, missing rows and convergence."""
    warnings = []
    if fit.residual_scale > LARGE_SCALE and not fit.noise:
        warnings.append(
            f"Residuals are {fit.residual_scale:.2g} times the stated noise: the model cannot meet all rows, or "
            "the noise is understated. The intervals include this."
        )
    for unknown, value, side in zip(fit.free, fit.values.tolist(), bound, strict=True):
        if side:
            warnings.append(f"{unknown.name} is on a bound, {value:.4g} {unknown.unit}".removesuffix(" 1") + ".")
    if not fit.bench.unload.any() and any(unknown.kind == "friction" for unknown in fit.free):
        warnings.append("No row has branch = unload: friction shows in the loop only.")
    if not fit.converged:
        warnings.append("The search did not converge: more --starts may help.")
    return warnings
