"""Base of the kinds of trials: how a kind is fitted, listed in tables and drawn."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

T = TypeVar("T", bound=Any)  # a type of trial, with a `name` (unique in its kind), a `file`, and `to_pandas`

FAILED = 10.0  # error of a run without a settled beat: multiples of the measured value, body lengths, or rad


@dataclass(frozen=True)
class Quantity:
    """A quantity that trials of a kind measure: its name, unit and noise."""

    name: str
    unit: str  # SI
    error: str  # unit of its errors: "m", "deg", or "relative" for single numbers (error over measured value)
    shown: str  # displayed unit of the errors
    factor: float  # displayed units per unit of the error
    level: float  # initial noise level if neither a file nor repeated runs state it: relative, or SI
    source: str  # name of the measurement in sentences
    path: str = ""  # for a component of a vector: name of the vector, with whose length the error is compared
    per_si: float = 1.0  # units of the error per SI unit

    @property
    def key(self) -> str:
        """Name of the error, with the unit."""
        return f"{self.name}_{self.error}"

    @property
    def label(self) -> str:
        """The name in words."""
        return self.name.replace("_", " ")

    @property
    def relative(self) -> bool:
        """Whether a run is a single number, with a relative error."""
        return self.error == "relative"


@dataclass(frozen=True)
class Sample:
    """One independent measurement: a number, or all frames of a run along one axis."""

    quantity: str
    run: int  # index of the run in its `Rows`
    sd: float  # standard deviation [SI]; if not known, a factor on the noise level
    known: bool  # whether `sd` is known
    count: int  # number of elements


@dataclass(frozen=True)
class Point:
    """A model with which trials are predicted: coefficients, their derivatives, and integration steps."""

    robot: Robot
    model: Any  # the core's model
    columns: Mapping[str, Sequence[float]]  # columns of the model that differ from the robot's description
    along: Array | None  # (parameters, n): derivatives of the parameters, then of the springs' numbers, by the scaled
    # free coefficients; None: zero Jacobians
    count: int  # n, number of free coefficients
    nuisances: Mapping[str, tuple[int, float, float]]  # by name: index, value [SI], derivative by the scaled value
    levels: Mapping[str, float]  # noise by quantity
    steps: int  # Runge-Kutta steps per beat
    gradient_steps: int  # Runge-Kutta steps per beat for derivatives
    threads: int
    # Points on both sides along the k-th scaled free coefficient, and their distance; None without `along`
    beside: Callable[[int], tuple[Point, Point, float]] | None = None

    @property
    def model_along(self) -> Array:
        """Derivatives of the model's parameters alone (parameters, n), for trials in which hinges stay rigid."""
        count = len(self.model.parameter_names())
        return np.zeros((count, self.count)) if self.along is None else np.ascontiguousarray(self.along[:count])


@dataclass(frozen=True)
class Prediction:
    """Computed values of `Rows`, with Jacobian, failures, and other quantities of the runs."""

    computed: Array  # (elements,), in the units of the measurements
    jacobian: Array  # (elements, n), with respect to the scaled free coefficients
    failed: NDArray[np.bool_]  # (runs,): whether a run has no settled beat
    unstable: NDArray[np.bool_]  # (runs,): whether a run's beat is periodic but unstable
    measurable: Mapping[str, tuple[Array, Array]]  # quantities of all runs, measured or not, and their Jacobians


@dataclass(frozen=True)
class Rows(ABC):
    """Rows of a fit's residual that are predicted together."""

    measured: Array  # (elements,) [SI]
    sample: NDArray[np.intp]  # (elements,): index of each element's sample in `samples`
    samples: Sequence[Sample]
    runs: int

    one_motion: ClassVar[bool] = False  # whether all runs repeat one motion
    uncertain: ClassVar[Any] = False  # whether inputs of the model, such as joint angles, have errors (see `drawn`)

    @cached_property
    def sd(self) -> Array:
        """Standard deviations (samples,) of the samples, absolute or relative as `Sample` says."""
        return np.array([sample.sd for sample in self.samples])

    @abstractmethod
    def predict(self, at: Point) -> Prediction:
        """Return the computed rows; a run without a settled beat gets values that are far off and a zero Jacobian."""

    def drawn(self, robot: Robot, rng: np.random.Generator) -> Self:
        """Return the rows with new random errors in the model's inputs, such as joint angles."""
        return self

    def speed_errors(self) -> list[dict[int, float]]:
        """Return for each trial weights by element: the weighted sum of errors is its speed's relative error.

        Only weights other than 0 are stored, since full rows would take memory quadratic in the number of runs.
        """
        return [{} for _ in range(1 if self.one_motion else self.runs)]


def spans(columns: Mapping[str, Sequence[float]]) -> dict[str, list[float]]:
    """Return minimum and maximum of each column that is not empty."""
    return {name: [min(values), max(values)] for name, values in columns.items() if values}


def span_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line of text for each range in a summary, and for each quantity that is missing (None)."""
    for name, span in summary.items():
        if isinstance(span, list):
            low, high = (f"{round(value, 12):.4g}" for value in span)
            yield f"  {name}: {low}" + f" to {high}" * (high != low)
        elif span is None:
            yield f"  {name}: not given"


def evenly_spaced(trials: Sequence[T], count: int) -> Sequence[T]:
    """Return about `count` of the trials, evenly spaced in their order."""
    return trials[:: max(1, len(trials) // count)]


class Kind(ABC, Generic[T]):
    """A kind of trial, such as steady runs: how it is fitted, listed and drawn. Its trials have `name` and `file`."""

    trial: type[T]
    key: ClassVar[str]  # name of the kind in manifests, and in the output of `trials check`
    label: ClassVar[str]  # words for one trial of this kind
    others: ClassVar[str]  # in sentences: further measurements of this kind that could be made
    transient: ClassVar[bool] = False  # whether its trials show transients
    hinges_bend: ClassVar[bool] = False  # whether the computed motion bends the hinges; otherwise they stay rigid
    nuisance: ClassVar[str] = ""  # a coefficient of the trials, not of the robot, that a fit may free
    quantities: ClassVar[tuple[Quantity, ...]]

    def runs(self, trial: T) -> tuple[str, ...]:
        """Return the names of a trial's runs; by default the trial is one run."""
        return (trial.name,)

    def only(self, trial: T, names: Collection[str]) -> T | None:
        """Return the trial with only the runs of some names, or None if it has none of them."""
        return trial if trial.name in names else None

    def depends_on(self, trial: T, nuisance: str) -> bool:
        """Return whether a trial's results depend on a coefficient of the trials, such as `cost_factor`."""
        return nuisance == self.nuisance

    def leaves_rigid(self, trial: T) -> bool:
        """Return whether the motion of a trial leaves hinges rigid."""
        return not self.hinges_bend

    @abstractmethod
    def motion(self, trial: T) -> dict[str, float]:
        """Return a trial's "frequency" [Hz], largest "amplitude" [rad] and "speed" [m/s], as far as it has them."""

    @abstractmethod
    def rows(self, robot: Robot, trials: Sequence[T], lowest: Mapping[str, float]) -> list[Rows]:
        """Return the rows of a fit's residual from trials; lowest: lower bounds of free nuisances by name [SI]."""

    def part(self, trials: Sequence[T], count: int) -> Sequence[T]:
        """Return about `count` evenly spaced trials for a rough search; kinds with few trials return all."""
        return trials

    def implausible(self, trials: Sequence[T], robot: Robot) -> tuple[list[InputError], list[str]]:
        """Return errors on files that must be in wrong units, and warnings about files with unlikely values."""
        return [], []

    def repeated(self, training: Sequence[T], validation: Sequence[T]) -> list[str]:
        """Return warnings if validation runs repeat motions of the training runs."""
        return []

    @abstractmethod
    def cells(self, trial: T) -> tuple[str, str, str]:
        """Return the texts of a trial in a table: name, gait and speed."""

    @abstractmethod
    def picture(self, trials: Sequence[T]) -> str:
        """Return an <svg> element that shows the trials, with its caption."""

    @abstractmethod
    def plot(self, trials: Sequence[T], *, width: float) -> Figure:
        """Return a figure that shows the trials; `width` [inch]."""

    def table(self, trials: Sequence[T]) -> pd.DataFrame:
        """Return a table with a row for each run."""
        import pandas as pd

        return pd.concat([trial.to_pandas() for trial in trials])

    @abstractmethod
    def summaries(self, trials: Sequence[T], robot: Robot) -> list[dict[str, Any]]:
        """Return a summary of each trial or file for JSON, with units in the names."""

    @abstractmethod
    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Yield the lines of text of a summary from `summaries`."""
