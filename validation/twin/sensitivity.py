"""Which estimate matters: the twin's reach and speed over what its hydraulics may be, by Sobol's indices."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.simulation.estimates import spreads, varied
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twins
from hypertuna.swimming.gait import Gait

Array = NDArray[np.float64]

SECONDS = 8.0  # of a run: at a steady beat and, begun at speed, near a steady swim
THREADS = 2


@dataclass(frozen=True)
class Influence:
    """Sobol's indices of some outputs of the twin.

    A run that diverges has no outputs: where one did, indices, means and deviations are not numbers.
    """

    factors: tuple[str, ...]  # keys of the estimates
    outputs: tuple[str, ...]
    first: Array  # (outputs, factors) Part of the variance that is due to a factor alone
    total: Array  # The same, due to a factor alone and along with others
    error: Array  # (outputs, factors) Half width of the total index's 95 % interval, by bootstrap
    mean: Array  # (outputs,) Of each output over the ranges [unit of the output]
    deviation: Array
    runs: int  # Runs made, and how many of them diverged
    diverged: int


def influence(
    robot: Robot,
    gait: Gait,
    *,
    factors: Sequence[str] = (),
    samples: int = 64,
    seed: int = 1,
    seconds: float = SECONDS,
    threads: int = THREADS,
    progress: Callable[[int, int], None] | None = None,
) -> Influence:
    """Compute how the twin's joint amplitudes and speed depend on estimates, by Saltelli's scheme.

    `factors` are keys of the robot's `spreads`, all where none are given; `seconds` [s]; returns [deg], [m/s].
    """
    from scipy import stats

    if samples < 2 or samples & (samples - 1):
        raise InputError("must be a power of two", key="samples", value=str(samples), fix="give 64, say")
    factors = factors or tuple(spreads(robot))
    outputs = (*(f"amplitude of joint {group.name} [deg]" for group in robot.joints), "speed [m/s]")
    total, done = samples * (len(factors) + 2), 0
    controllers: dict[tuple[float, ...], Robot] = {}
    everything: list[Array] = []

    def evaluate(parts: Array) -> Array:
        nonlocal done
        columns = []
        for start in range(0, parts.shape[1], 16 * threads):
            block = parts[:, start : start + 16 * threads]
            runs = [_options(robot, gait, factors, part, controllers, seconds) for part in block.T]
            columns += twins(runs, measure=_outputs, threads=threads)
            done += block.shape[1]
            if progress is not None:
                progress(done, total)
        everything.append(np.array(columns))
        return np.array(columns).T

    dists = [stats.uniform()] * len(factors)
    with np.errstate(invalid="ignore"):
        found = stats.sobol_indices(func=evaluate, n=samples, dists=dists, rng=np.random.default_rng(seed))
    values = np.concatenate(everything)
    diverged = int(np.isnan(values[:, 0]).sum())
    error = np.full_like(found.total_order, np.nan)
    if not diverged:
        spread_of = found.bootstrap(n_resamples=200).total_order.confidence_interval
        error = (spread_of.high - spread_of.low) / 2
    plain = np.concatenate(everything[:2])  # the two independent samples
    return Influence(
        factors=tuple(factors),
        outputs=outputs,
        first=found.first_order if not diverged else np.full_like(error, np.nan),
        total=found.total_order if not diverged else np.full_like(error, np.nan),
        error=error,
        mean=plain.mean(axis=0),
        deviation=plain.std(axis=0),
        runs=total,
        diverged=diverged,
    )


def _options(
    robot: Robot,
    gait: Gait,
    factors: Sequence[str],
    part: Array,
    controllers: dict[tuple[float, ...], Robot],
    seconds: float,
) -> dict[str, Any]:
    """Return the options of a run of another robot, whose controller knows only its own limits."""
    changes = dict(zip(factors, part.tolist(), strict=True))
    own = {factor: change for factor, change in changes.items() if factor.startswith("controller.")}
    key = tuple(own.values())
    if key not in controllers:
        controllers[key] = varied(robot, own)
    options = {"robot": varied(robot, changes), "controller_robot": controllers[key], "gait": gait}
    return options | {"duration": seconds, "start": "swimming"}


def _outputs(run: TwinRun) -> list[float]:
    """Return joint amplitudes [deg] and speed [m/s]; NaN where the run diverged, whatever it recorded."""
    if run.status == "diverged":
        return [math.nan] * (len(run.joints) + 1)
    return [*np.degrees(run.first_harmonic).tolist(), run.speed]
