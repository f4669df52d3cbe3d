"""Steps of a design: for each run its prediction, its results and the uncertainty after it; warnings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from hypertuna.arrays import Array
from hypertuna.design.criterion import CHECK, NEVER
from hypertuna.design.posterior import Posterior
from hypertuna.design.runs import Measurement, TankRun, shared_frequency

MISSED = 3.0  # a measurement this many standard deviations from its prediction contradicts the model
LOOSE = 2.0  # repeats that differ by more than this many times their noise have another source of error
OPEN = 0.1  # a coefficient with a smaller relative standard deviation is known well enough
NAMED = 4  # largest number of coefficients that a warning names
DRIFTS = 3.0  # a slope of this many standard deviations is a drift


@dataclass(frozen=True)
class Step:
    """One measured run: the prediction before the run, and the uncertainty after it."""

    results: tuple[Measurement, ...]
    predicted: tuple[tuple[float, float], ...]  # of each result: log value, and its standard deviation with noise
    half_width: float  # rms half width of the 95 % intervals of the targets' logarithms after the run
    sd: tuple[float, ...]  # standard deviations of the scaled coefficients after the run
    discrepancy: float  # standard deviation of the model's discrepancy, relative

    @property
    def run(self) -> TankRun:
        """The run of the step."""
        return self.results[0].run

    @property
    def off(self) -> float:
        """Largest distance of a measurement from its prediction, in standard deviations."""
        pairs = zip(self.results, self.predicted, strict=True)
        return max((abs(math.log(r.value) - mean) / sd for r, (mean, sd) in pairs if sd > 0), default=math.nan)


def warnings_of(posterior: Posterior, steps: Sequence[Step], next_runs: Sequence[TankRun], never: Array) -> list[str]:
    """Return warnings: coefficients that no run can narrow, and results that contradict the model or each other."""
    warnings = []
    if shared := shared_frequency([*(step.run for step in steps), *next_runs]):
        warnings.append(
            f"{shared[1]} of {len(steps) + len(next_runs)} runs beat at {shared[0]:g} Hz: what the model misses at "
            "other frequencies stays unseen; exchange one of them."
        )
    if len(steps) >= CHECK and (check := steps[len(steps) // CHECK * CHECK - 1]).off > MISSED:
        warnings.append(
            f"The check of {check.run} was {check.off:.1f} standard deviations from its prediction: the "
            "model misses something there. Repeat the run, and measure more gaits like it."
        )
    for sentence in (_missed(steps), _repeats(posterior.results), _drift(posterior)):
        warnings += [sentence] if sentence else []
    if posterior.day:
        warnings.append(f"Days differ by {100 * posterior.day:.1f} %: begin each day with a repeat.")
    logarithmic = [coefficient.scale == "log" for coefficient in posterior.unknowns.free]
    size = np.where(logarithmic, 1.0, np.maximum(np.abs(posterior.unknowns.mean), 1e-12))
    prior, never = posterior.unknowns.sd / size, never / size
    undetermined = [k for k in np.argsort(-never / prior) if never[k] > max(NEVER * prior[k], OPEN)]
    if undetermined:
        names = posterior.unknowns.names
        remaining = ", ".join(f"{names[k]} {never[k]:.2f} of {prior[k]:.2f}" for k in undetermined[:NAMED])
        more = f" and {len(undetermined) - NAMED} more" if len(undetermined) > NAMED else ""
        warnings.append(
            "No run in this tank tells much of some coefficients: of the relative standard deviations of their priors "
            f"remain {remaining}{more}."
        )
    return warnings


def _missed(steps: Sequence[Step]) -> str:
    """Return a warning if runs other than checks were far from their predictions, else an empty text."""
    off = [step for k, step in enumerate(steps) if step.off > MISSED and (k + 1) % CHECK]
    if not off:
        return ""
    farthest = max(off, key=lambda step: step.off)
    name = farthest.results[0].name or str(farthest.run)
    more = f", the farthest of {len(off)} such runs" if len(off) > 1 else ""
    return (
        f"The result of {name} was {farthest.off:.1f} standard deviations from its prediction{more}: check gait and "
        "unit. The last lines of the state's file may be deleted, to tell them anew."
    )


def _repeats(results: Sequence[Measurement]) -> str:
    """Return a warning if repeats on one day differ by more than their noise, else an empty text."""
    ratios = [
        math.log(first.value / second.value) ** 2 / (first.noise**2 + second.noise**2)
        for first, second in combinations(results, 2)
        if (first.run, first.quantity, first.day) == (second.run, second.quantity, second.day)
    ]
    ratio = math.sqrt(sum(ratios) / len(ratios)) if ratios else 0.0
    if ratio <= LOOSE:
        return ""
    return f"Repeats differ by {ratio:.1f} times their noise: state a larger standard deviation of the measurements."


def _drift(posterior: Posterior) -> str:
    """Return a warning if results drift in the course of a day, else an empty text."""
    results = posterior.results
    if len(results) < CHECK:
        return ""
    mean, _ = posterior.predict(posterior.rows)
    residuals = np.log([result.value for result in results]) - mean
    weights = np.array([result.noise**-2 for result in results])
    days = [result.day for result in results]
    order = np.array([days[:k].count(day) for k, day in enumerate(days)], dtype=float)
    for day in set(days):
        same_day = np.array([other == day for other in days])
        order[same_day] -= np.average(order[same_day], weights=weights[same_day])
    information = float(weights @ order**2)
    if not information:
        return ""
    slope = float(weights @ (order * residuals)) / information
    if abs(slope) * math.sqrt(information) <= DRIFTS:
        return ""
    return f"Results drift by {100 * slope:+.1f} % a run: repeat the first run, and look at battery and temperature."
