"""Arrange trials for a fit: measured elements, the independent samples that they form, and each sample's noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import Free
from hypertuna.identification.names import NUISANCES
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.trials.kind import Rows, Sample
from hypertuna.trials.kinds import QUANTITIES
from hypertuna.trials.trials import Trials

Flags = NDArray[np.bool_]  # truth values
Indices = NDArray[np.intp]

NAMES = tuple(QUANTITIES)  # names of all measured quantities
LARGE_ERROR = 0.15  # relative error of numbers, or of tracks over their distance from the start; noise is smaller


@dataclass(frozen=True)
class Experiment:
    """Trials arranged for a fit: elements are single numbers, a sample is one independent measurement.

    All frames of a tracked run along one axis are one sample, because their errors are correlated from frame to frame.
    """

    robot: Robot
    trials: Trials
    free: tuple[Free, ...]
    measured: Array  # (elements,) [SI]; poses are relative to the start of their run
    sample: Indices  # (elements,), index of each element's sample
    kind: Indices  # (samples,), index of the quantity in NAMES
    run: Indices  # (samples,), index of the run in trials.runs
    sd: Array  # (samples,), standard deviation [SI]; if not known, a factor on the noise level
    known: Flags  # (samples,), whether `sd` is known
    count: Indices  # (samples,), number of elements of each sample
    groups: tuple[Rows, ...]  # their elements, samples and runs follow each other in the arrays above
    loss: str = "linear"  # name of the loss, see `loss_terms`
    steps: int = DEFAULT_STEPS  # Runge-Kutta steps per beat
    threads: int = 1

    @property
    def unknown_kinds(self) -> tuple[str, ...]:
        """Quantities whose noise has to be estimated."""
        return tuple(name for k, name in enumerate(NAMES) if (~self.known & (self.kind == k)).any())

    @property
    def without_intervals(self) -> bool:
        """Whether there are too few measurements to estimate intervals: no more than free coefficients."""
        without_prior = sum(f.prior is None for f in self.free)
        samples = len(self.kind)
        return samples <= len(self.free) and (samples <= without_prior or bool(self.unknown_kinds))

    @property
    def sizes(self) -> dict[str, float]:
        """Scale of errors by quantity: 1 for relative errors, otherwise the rms of the measured values [m or rad]."""
        kinds, rms = self.kind[self.sample], {}
        for k, (name, q) in enumerate(QUANTITIES.items()):
            alike = [j for j, other in enumerate(QUANTITIES.values()) if j == k or (q.path and other.path == q.path)]
            values = self.measured[np.isin(kinds, alike)]
            if len(values):
                rms[name] = 1.0 if q.relative else float(np.sqrt(np.mean(values**2) * len(alike)))
        return rms

    @property
    def level_caps(self) -> dict[str, float]:
        """Largest noise level of each quantity; larger residuals mean that the model is wrong, not the measurement."""
        return {name: max(LARGE_ERROR * size, QUANTITIES[name].level) for name, size in self.sizes.items()}

    def noise(self, levels: Mapping[str, float]) -> Array:
        """Return the standard deviations (samples,) [SI]; levels: of quantities whose noise is unknown."""
        level = np.array([levels.get(name, 1.0) for name in NAMES])[self.kind]
        return np.where(self.known, 1.0, level) * self.sd


def experiment(robot: Robot, trials: Trials, frees: Sequence[Free] = (), **options: Any) -> Experiment:
    """Arrange trials for a fit; options: loss, steps and threads of the `Experiment`.

    If a recording's time offset is free, only the frames that the replay spans for all allowed offsets are used.
    """
    if not trials.runs:
        raise InputError("must have at least one run", key="trials", fix="give measured runs")
    lower_bounds = {f.name: f.lower for f in frees if f.column in NUISANCES}
    groups = [rows for kind, members in trials.kinds.items() for rows in kind.rows(robot, members, lower_bounds)]
    samples = list[Sample]()
    element_samples, sample_runs, first_run = list[Indices](), list[int](), 0
    for rows in groups:
        element_samples.append(len(samples) + rows.sample)
        sample_runs += [first_run + sample.run for sample in rows.samples]
        samples += rows.samples
        first_run += rows.runs
    return Experiment(
        robot,
        trials,
        tuple(frees),
        measured=np.concatenate([rows.measured for rows in groups]),
        sample=np.concatenate(element_samples),
        kind=np.array([NAMES.index(sample.quantity) for sample in samples]),
        run=np.array(sample_runs),
        sd=np.concatenate([rows.sd for rows in groups]),
        known=np.array([sample.known for sample in samples]),
        count=np.array([sample.count for sample in samples]),
        groups=tuple(groups),
        **options,
    )
