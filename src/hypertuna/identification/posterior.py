"""Posterior: the coefficients that the runs allow, drawn by emcee, beside the linear intervals of a fit."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot, parse
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import from_scale, to_scale
from hypertuna.identification.identify import Fit
from hypertuna.identification.prediction import Experiment, experiment, loss_terms, predict
from hypertuna.identification.residuals import curvature, squares
from hypertuna.io.checkpoint import Journal
from hypertuna.trials.trials import digest

__all__ = ["Posterior", "check_draws", "posterior", "with_posterior"]

Array = NDArray[np.float64]

WALKERS = 4  # per coefficient, though 16 at least
BLOCK = 25  # steps between two records of the checkpoint
BURNT = 0.3  # part of the chain that is thrown away at its start
ENOUGH = 50  # autocorrelation times that a chain should be long


@dataclass(frozen=True)
class Posterior:
    """Draws from the posterior of a fit.

    Attributes
    ----------
    draws : ndarray, shape (draws, n)
        Values in SI units, the first part of the chain left out.
    low, high : ndarray, shape (n,)
        95 % interval of each coefficient in SI units: quantiles 2.5 % and 97.5 %.
    covariance : ndarray, shape (n, n)
        Of the draws, in the scales of the coefficients.
    acceptance : float
        Part of the proposed steps that were taken.
    autocorrelation : ndarray, shape (n,)
        Steps after which a chain has forgotten where it was.
    steps, walkers : int
    sentence : str
        Whether the chain is long enough.
    """

    draws: Array
    low: Array
    high: Array
    covariance: Array
    acceptance: float
    autocorrelation: Array
    steps: int
    walkers: int
    sentence: str


def posterior(
    fit: Fit,
    steps: int,
    *,
    threads: int | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Posterior:
    """Draw from the posterior of a fit by affine-invariant walkers (Goodman and Weare 2010, emcee).

    Parameters
    ----------
    fit : Fit
    steps : int
        Of each walker.
    threads : int, optional
        All processors if left out; the result does not depend on it.
    checkpoint : str or Path, optional
        File of finished blocks of steps: started again after any end, the draws go on from there.
    progress : callable, optional
        Called with the steps done and their total.

    Returns
    -------
    Posterior

    Raises
    ------
    InputError
        If there are fewer steps than 10, or the fit's loss is "cauchy", which is no likelihood.

    Notes
    -----
    The prior is uniform between the bounds, each coefficient in its scale. The likelihood is that of the fit: its loss,
    its noise levels, and its factor where residuals exceed the stated noise.
    """
    import emcee  # here, because only posteriors need it

    check_draws(steps, fit.loss)
    frees, n = fit.free, len(fit.free)
    data = experiment(fit.described, fit.trials[0], frees)
    lower, upper = (to_scale(frees, [getattr(f, side) for f in frees]) for side in ("lower", "upper"))
    workers = threads or len(os.sched_getaffinity(0))
    walkers = max(16, WALKERS * n)
    begin = _begin(fit, lower, upper, walkers)
    # as wide about the fit as its covariance, which holds what the loss makes less of and what residuals exceed
    best = predict(data, frees, fit.values, steps=fit.steps, slope_steps=None, threads=workers)
    own = squares(data, best, fit.noise) / fit.certainty.excess**2
    share = (fit.certainty.excess / fit.certainty.factor) ** 2 / curvature(data, own, fit.loss)
    sampler = emcee.EnsembleSampler(walkers, n, lambda x: _log_posterior(data, fit, share, x, lower, upper, workers))
    options = {
        "trials": digest(fit.trials[0]),
        "seed": fit.seed,
        "loss": fit.loss,
        "values": fit.values.tolist(),
        "steps": fit.steps,
    }
    header = journal_header("posterior", fit.described, options)
    chain: list[Any] = []
    accepted, at = 0.0, {"x": begin, "log": None}
    with Journal(checkpoint, header) as journal:
        for first in range(0, steps, BLOCK):
            here = min(BLOCK, steps - first)
            work = partial(_block, sampler, at, here, fit.seed + first)
            told = journal.answer({"first": first, "steps": here, "x": at["x"]}, work)
            chain += told["chain"]
            accepted += told["accepted"]
            at = {"x": np.array(told["chain"][-1]), "log": np.array(told["log"])}
            if progress is not None:
                progress(first + here, steps)
    return _posterior(fit, np.array(chain), accepted / (steps * walkers))


def check_draws(steps: int, loss: str) -> None:
    """Check a number of steps, and that a fit's loss has a posterior.

    Parameters
    ----------
    steps : int
    loss : str

    Raises
    ------
    InputError
        If there are fewer than 10, or the loss is "cauchy".
    """
    if steps < 10:
        raise InputError("must be 10 at least", key="posterior", value=str(steps), fix="give steps, such as 1000")
    if loss == "cauchy":
        rule, fix = "must be a likelihood for a posterior", "fit with soft_l1, huber or linear"
        raise InputError(rule, key="loss", value="'cauchy', whose integral is infinite", fix=fix)


def with_posterior(fit: Fit, sampled: Posterior) -> Robot:
    """Return the fitted robot whose table ``[fit]`` holds the covariance of the posterior.

    Parameters
    ----------
    fit : Fit
    sampled : Posterior

    Returns
    -------
    Robot
    """
    table = fit.robot.fit
    assert table is not None  # a fit writes it
    text = f"{table.text}; covariance of {len(sampled.draws)} draws from the posterior"
    document = fit.robot.document()
    document["fit"] |= {"text": text, "covariance": sampled.covariance.tolist()}
    return parse(document, file=fit.robot.file)


def _begin(fit: Fit, lower: Array, upper: Array, walkers: int) -> Array:
    """Start walkers where the linear fit would have them, well within the bounds."""
    rng = np.random.default_rng(fit.seed)
    width = upper - lower
    spread = np.minimum(np.sqrt(np.diag(fit.certainty.covariance)), 0.1 * width)
    drawn = to_scale(fit.free, fit.values) + spread * rng.standard_normal((walkers, len(width)))
    # what falls outside comes back in as from a mirror, and stays off the bound
    folded = np.abs((drawn - lower) / width) % 2
    inside = np.where(folded > 1, 2 - folded, folded)
    start: Array = lower + width * np.clip(inside, 1e-6, 1 - 1e-6)
    return start


def _log_posterior(
    data: Experiment, fit: Fit, share: float, x: Array, lower: Array, upper: Array, threads: int
) -> float:
    """Logarithm of the posterior density, but for a constant."""
    if not ((x >= lower) & (x <= upper)).all():
        return -math.inf
    found = predict(data, fit.free, from_scale(fit.free, x), steps=fit.steps, slope_steps=None, threads=threads)
    z = squares(data, found, fit.noise) / fit.certainty.excess**2
    return -0.5 * share * float(loss_terms(fit.loss, z)[0].sum())


def _block(sampler: Any, at: dict[str, Any], steps: int, seed: int) -> dict[str, Any]:
    """Take some steps with random numbers of their own."""
    import emcee

    state = emcee.State(at["x"], log_prob=at["log"], random_state=np.random.RandomState(seed % 2**32).get_state())
    sampler.reset()
    end = sampler.run_mcmc(state, steps)
    return {
        "chain": sampler.get_chain(),
        "log": end.log_prob,
        "accepted": float(np.sum(sampler.acceptance_fraction) * steps),
    }


def _posterior(fit: Fit, chain: Array, acceptance: float) -> Posterior:
    """Summarize a chain of shape (steps, walkers, n)."""
    import emcee

    steps, walkers, n = chain.shape
    kept = chain[int(BURNT * steps) :]
    tau = np.asarray(emcee.autocorr.integrated_time(kept, tol=0, quiet=True), dtype=float)
    flat = kept.reshape(-1, n)
    low, high = (from_scale(fit.free, np.quantile(flat, q, axis=0)) for q in (0.025, 0.975))
    longest = float(np.nanmax(tau)) if np.isfinite(tau).any() else math.inf
    if len(kept) >= ENOUGH * longest:
        sentence = f"The chain is {len(kept) / longest:.0f} autocorrelation times long: enough for 95 % intervals."
    else:
        wanted = f"; take {math.ceil(ENOUGH * longest / (1 - BURNT)):d} steps" if math.isfinite(longest) else ""
        sentence = (
            f"The chain is only {len(kept) / longest:.0f} autocorrelation times long: its intervals are rough{wanted}."
        )
    draws = np.array([from_scale(fit.free, x) for x in flat])
    covariance = np.atleast_2d(np.cov(flat.T))
    return Posterior(draws, low, high, covariance, acceptance, tau, steps, walkers, sentence)
