"""Posterior of the coefficients of a fit, sampled by emcee."""

import math
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot, parse
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import Free, bounds_of, from_scale, prior_rows, to_scale
from hypertuna.identification.experiment import Experiment, experiment
from hypertuna.identification.identify import Fit
from hypertuna.identification.loss import curvature, loss_terms
from hypertuna.identification.prediction import predict
from hypertuna.identification.residuals import squares
from hypertuna.io.checkpoint import Journal
from hypertuna.parallel.executors import map_shards, thread_count
from hypertuna.ranges import Whole
from hypertuna.trials.trials import digest

WALKERS_PER_COEFFICIENT, MIN_WALKERS = 4, 16  # number of walkers of the sampler
BLOCK = 25  # steps between two records of the checkpoint
BURN_IN = 0.3  # fraction of the chain that is discarded
MIN_LENGTH = 50  # length of a sufficient chain, in autocorrelation times
STEP_RANGE = Whole(min=10, max=100_000)  # allowed numbers of steps


@dataclass(frozen=True)
class Posterior(Plotted, Tabular, data=lambda sampled: sampled._columns()):
    """Samples from the posterior of a fit, without the burn-in."""

    free: tuple[Free, ...]
    samples: Array  # (samples, n) [SI]
    low: Array  # (n,) [SI], 2.5 % quantiles
    high: Array  # (n,) [SI], 97.5 % quantiles
    covariance: Array  # (n, n), covariance of the samples in the scales of the coefficients
    acceptance: float  # fraction of the proposed steps that were accepted
    autocorrelation: Array  # (n,), autocorrelation time in steps
    steps: int
    walkers: int
    sentence: str  # on the length of the chain

    def _columns(self) -> dict[str, Array]:
        """Return the samples of each coefficient in displayed units, as columns."""
        return {f.name: f.border[1] * values for f, values in zip(self.free, self.samples.T, strict=True)}

    @property
    def record(self) -> dict[str, Any]:
        """Record of the posterior for JSON."""
        intervals = zip(self.free, self.low, self.high, strict=True)
        rows = [{"name": f.name, "low": f.border[1] * low, "high": f.border[1] * high} for f, low, high in intervals]
        names = ("acceptance", "steps", "walkers", "sentence")
        record = {"parameters": rows, "autocorrelation_steps": self.autocorrelation}
        return record | {name: getattr(self, name) for name in names}


def posterior(
    fit: Fit,
    steps: int,
    *,
    executor: Executor | None = None,
    threads: int | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Posterior:
    """Sample the posterior of a fit with `steps` of affine-invariant walkers (Goodman and Weare 2010, emcee).

    The prior is uniform between the bounds in the coefficients' scales, times the fit's priors; the likelihood is that
    of the fit. The executor gets each walker's step as a task; the result depends neither on the executor nor on the
    number of threads. progress: called with the finished steps and their total.
    """
    import emcee  # imported here: slow to import

    check_posterior(steps, fit.loss)
    options: dict[str, Any] = {"loss": fit.loss, "steps": fit.steps}
    data = experiment(fit.described, fit.trials[0], fit.free, **options, threads=thread_count(threads, executor))
    walkers = max(MIN_WALKERS, WALKERS_PER_COEFFICIENT * len(fit.free))
    scale = fit.uncertainty.residual_scale

    density = _Density(fit.free, fit.loss, data, fit.noise, scale, *bounds_of(fit.free))
    # weighted so that the density is as wide as the fit's covariance, which includes robust loss and excess residuals
    weight = (scale / fit.uncertainty.factor) ** 2 / curvature(density.squares_at(fit.values), fit.loss, data.count)
    density = replace(density, weight=weight)
    lower, upper = density.lower, density.upper
    pool = None if executor is None else _Pool(executor)
    sampler = emcee.EnsembleSampler(walkers, len(fit.free), density, pool=pool)
    sampler.log_prob_fn = density  # replaces emcee's wrapper, which prints a traceback at Ctrl-C
    options |= {"trials": digest(fit.trials[0]), "seed": fit.seed, "values": fit.values.tolist()}
    header = journal_header("posterior", fit.described, options)

    def advanced(state: dict[str, Any], count: int, seed: int) -> dict[str, Any]:
        random = np.random.RandomState(seed % 2**32).get_state()
        sampler.reset()
        final = sampler.run_mcmc(emcee.State(state["x"], log_prob=state["log"], random_state=random), count)
        accepted = float(np.sum(sampler.acceptance_fraction) * count)
        return {"chain": sampler.get_chain(), "log": final.log_prob, "accepted": accepted}

    chain: list[Any] = []
    accepted, state = 0.0, {"x": _start_points(fit, lower, upper, walkers), "log": None}
    with Journal(checkpoint, header) as journal:
        for first in range(0, steps, BLOCK):
            count = min(BLOCK, steps - first)
            work = partial(advanced, state, count, fit.seed + first)
            block = journal.answer({"first": first, "steps": count, "x": state["x"]}, work)
            chain += block["chain"]
            accepted += block["accepted"]
            state = {"x": np.array(block["chain"][-1]), "log": np.array(block["log"])}
            if progress is not None:
                progress(first + count, steps)
    return _posterior(fit, np.array(chain), accepted / (steps * walkers))


@dataclass(frozen=True)
class _Density:
    """Natural logarithm of the posterior's density at scaled coefficients x (n,), up to a constant."""

    free: tuple[Free, ...]
    loss: str
    data: Experiment
    noise: dict[str, float]
    scale: float  # ratio of the residuals to the stated noise
    lower: Array  # (n,) in the scales of the coefficients
    upper: Array
    weight: float = 1.0  # factor on the loss

    def squares_at(self, values: Array) -> Array:
        """Return the squared residuals (samples,) over their variance and the squared scale."""
        predicted = predict(self.data, values, gradient_steps=None, levels=self.noise)
        return squares(self.data, predicted, self.noise) / self.scale**2

    def __call__(self, x: Array) -> float:
        if not ((x >= self.lower) & (x <= self.upper)).all():
            return -math.inf
        prior_terms = float((prior_rows(self.free, x)[0] ** 2).sum())
        terms = loss_terms(self.loss, self.squares_at(from_scale(self.free, x)))[0]
        return -0.5 * (self.weight * float(terms.sum()) + prior_terms)


@dataclass(frozen=True)
class _Pool:
    """Gives an executor the method `map` that emcee calls."""

    executor: Executor

    def map(self, function: Callable[[Array], float], points: Iterable[Array]) -> Iterator[float]:
        """Yield the function's value at each point."""
        return map_shards(function, points, self.executor)


def check_posterior(steps: int, loss: str) -> None:
    """Check the number of steps, and that the loss is a likelihood."""
    STEP_RANGE.check(steps, "posterior", "give a number such as 1000")
    if loss == "cauchy":
        rule, fix = "must follow from a likelihood to sample a posterior", "fit with soft_l1, huber or linear"
        raise InputError(rule, key="loss", value="'cauchy', whose integral is infinite", fix=fix)


def with_posterior(fit: Fit, sampled: Posterior) -> Robot:
    """Return the fitted robot with the covariance of the posterior in its table [fit]."""
    table = fit.robot.fit
    assert table is not None  # every fit has one
    text = f"{table.text}; covariance of {len(sampled.samples)} posterior samples"
    document = fit.robot.document()
    # a common factor of the table is relative to the fitted values, see `with_fit`
    unit = np.array([v if f.common and f.scale != "log" else 1.0 for f, v in zip(fit.free, fit.values, strict=True)])
    covariance = sampled.covariance / np.outer(unit, unit)
    document["fit"] |= {"text": text, "covariance": covariance.tolist()}
    return parse(document, file=fit.robot.file)


def _start_points(fit: Fit, lower: Array, upper: Array, walkers: int) -> Array:
    """Return start points (walkers, n) scattered about the fit by its standard deviations, within the bounds."""
    rng = np.random.default_rng(fit.seed)
    width = upper - lower
    spread = np.minimum(np.sqrt(np.diag(fit.uncertainty.covariance)), 0.1 * width)
    points = to_scale(fit.free, fit.values) + spread * rng.standard_normal((walkers, len(width)))
    folded = np.abs((points - lower) / width) % 2  # reflect points outside the bounds
    reflected = np.where(folded > 1, 2 - folded, folded)
    return np.asarray(lower + width * np.clip(reflected, 1e-6, 1 - 1e-6))


def _posterior(fit: Fit, chain: Array, acceptance: float) -> Posterior:
    """Build the `Posterior` from a chain (steps, walkers, n), without its burn-in."""
    import emcee

    steps, walkers, n = chain.shape
    kept = chain[int(BURN_IN * steps) :]
    with np.errstate(invalid="ignore"):  # the chain may not have moved
        tau = np.asarray(emcee.autocorr.integrated_time(kept, tol=0, quiet=True), dtype=float)
    flat = kept.reshape(-1, n)
    low, high = (from_scale(fit.free, np.quantile(flat, q, axis=0)) for q in (0.025, 0.975))
    longest = float(np.nanmax(tau)) if np.isfinite(tau).any() else math.inf
    length = f"{len(kept) / longest:.0f} autocorrelation times long"
    if len(kept) >= MIN_LENGTH * longest:
        sentence = f"The chain is {length}: enough for 95 % intervals."
    else:
        advice = f"; take {math.ceil(MIN_LENGTH * longest / (1 - BURN_IN)):d} steps" if math.isfinite(longest) else ""
        sentence = f"The chain is only {length}: its intervals are rough{advice}."
    samples, covariance = np.array([from_scale(fit.free, x) for x in flat]), np.atleast_2d(np.cov(flat.T))
    return Posterior(fit.free, samples, low, high, covariance, acceptance, tau, steps, walkers, sentence)
