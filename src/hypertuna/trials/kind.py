"""Base of the kinds of trials: what a kind adds to a fit, to tables and to figures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
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

T = TypeVar("T", bound=Any)  # of trials: each has a `name`, unique among those of its kind, a `file`, and `to_pandas`

FAILED = 10.0  # error of a run without a settled beat: times what was measured, or body lengths, or rad


@dataclass(frozen=True)
class Quantity:
    """A quantity that trials of a kind measure: its name, unit and noise."""

    name: str
    unit: str  # SI
    error: str  # unit of its errors: m, deg, or "relative" of single numbers, over what was measured
    shown: str  # displayed unit of the errors
    factor: float  # displayed units per unit of the error
    level: float  # first noise level where neither a file nor repeated runs state it: relative, or SI
    source: str  # what sentences call the measurement
    path: str = ""  # of components: name of the vector, whose length is the size that their errors are judged by
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
        """Whether a run is one number, with a relative error."""
        return self.error == "relative"


@dataclass(frozen=True)
class Sample:
    """One independent measurement: a number, or all frames of a run along one axis."""

    quantity: str
    run: int  # in its rows
    sd: float  # standard deviation [SI]; where unknown, the factor on the noise level
    known: bool  # whether `sd` is known
    count: int  # elements


@dataclass(frozen=True)
class Point:
    """A model at which trials are predicted: its coefficients, their derivatives, and the steps of integration."""

    robot: Robot
    model: Any  # of the core
    columns: Mapping[str, Sequence[float]]  # of the robot that differ from the description
    along: Array | None  # (parameters, n) by the scaled free coefficients; None for zero Jacobians
    count: int  # n
    nuisances: Mapping[str, tuple[int, float, float]]  # by name: position, value [SI], derivative by the scaled one
    levels: Mapping[str, float]  # noise by quantity
    steps: int  # Runge-Kutta steps per beat, and of its derivatives
    gradient_steps: int
    threads: int


@dataclass(frozen=True)
class Prediction:
    """Computed values of trials' rows, with Jacobian, failures and other quantities of the runs."""

    computed: Array  # (elements,), in the units of what was measured
    jacobian: Array  # (elements, n), by the free coefficients, each in its scale
    failed: NDArray[np.bool_]  # (runs,), without a settled beat
    unstable: NDArray[np.bool_]  # (runs,), periodic but unstable
    measurable: Mapping[str, tuple[Array, Array]]  # quantities of all runs, measured or not, and their Jacobians


@dataclass(frozen=True)
class Rows(ABC):
    """Rows of the residual that are predicted together."""

    measured: Array  # (elements,) [SI]
    sample: NDArray[np.intp]  # (elements,), index into samples
    samples: Sequence[Sample]
    runs: int

    one_motion: ClassVar[bool] = False  # whether all runs repeat one motion
    uncertain: ClassVar[Any] = False  # whether what the model is given has errors, see `drawn`

    @cached_property
    def sd(self) -> Array:
        """Standard deviations (samples,) of the samples, absolute or relative as `Sample` says."""
        return np.array([sample.sd for sample in self.samples])

    @abstractmethod
    def predict(self, at: Point) -> Prediction:
        """Return the computed rows; a run without a settled beat gets values far off and a zero Jacobian."""

    def drawn(self, robot: Robot, rng: np.random.Generator) -> Self:
        """Return the rows with random errors of the model's inputs, such as joint angles, drawn anew."""
        return self

    def speed_errors(self) -> list[dict[int, float]]:
        """Return each trial's weights by element, which turn errors into the relative error of its speed.

        Only weights other than 0 are kept: rows of all elements would take memory by the square of the runs.
        """
        return [{} for _ in range(1 if self.one_motion else self.runs)]


def spans(columns: Mapping[str, Sequence[float]]) -> dict[str, list[float]]:
    """Return minimum and maximum of each column that is not empty."""
    return {name: [min(values), max(values)] for name, values in columns.items() if values}


def span_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield lines of text for the minima and maxima in a summary, and for quantities that it lacks."""
    for name, span in summary.items():
        if isinstance(span, list):
            low, high = (f"{round(value, 12):.4g}" for value in span)
            yield f"  {name}: {low}" + f" to {high}" * (high != low)
        elif span is None:
            yield f"  {name}: not given"


def evenly_spaced(trials: Sequence[T], count: int) -> Sequence[T]:
    """Return about `count` of the trials, at equal steps through their order."""
    return trials[:: max(1, len(trials) // count)]


class Kind(ABC, Generic[T]):
    """A kind of trial, such as steady runs: how it is fitted, listed and drawn. Its trials have `name` and `file`."""

    trial: type[T]
    key: ClassVar[str]  # in manifests, and in what `trials check` prints
    label: ClassVar[str]  # of one
    others: ClassVar[str]  # what else could be measured of this kind, in sentences
    transient: ClassVar[bool] = False  # whether it shows transients
    nuisance: ClassVar[str] = ""  # coefficient of the trials, not of the robot, that it may have
    quantities: ClassVar[tuple[Quantity, ...]]

    def runs(self, trial: T) -> tuple[str, ...]:
        """Return the names of a trial's runs; by default the trial is one run."""
        return (trial.name,)

    def only(self, trial: T, names: Collection[str]) -> T | None:
        """Return the trial with only the runs of some names, or None if it has none of them."""
        return trial if trial.name in names else None

    def tells(self, trial: T, nuisance: str) -> bool:
        """Return whether a trial's results depend on a coefficient of the trials, such as `cost_factor`."""
        return nuisance == self.nuisance

    @abstractmethod
    def motion(self, trial: T) -> dict[str, float]:
        """Return a trial's frequency [Hz], largest amplitude [rad] and speed [m/s], those of them that it has."""

    @abstractmethod
    def rows(self, robot: Robot, trials: Sequence[T], lowest: Mapping[str, float]) -> list[Rows]:
        """Return the rows of a fit's residual from trials; lowest: lower bounds of free nuisances by name [SI]."""

    def part(self, trials: Sequence[T], count: int) -> Sequence[T]:
        """Return about `count` evenly spaced trials for a rough search; all of them in kinds of few trials."""
        return trials

    def implausible(self, trials: Sequence[T], robot: Robot) -> tuple[list[InputError], list[str]]:
        """Return errors on files that must be in wrong units, and warnings on files that are unlikely."""
        return [], []

    def repeated(self, training: Sequence[T], validation: Sequence[T]) -> list[str]:
        """Return warnings of validation runs that repeat motions of the training runs."""
        return []

    @abstractmethod
    def cells(self, trial: T) -> tuple[str, str, str]:
        """Return the texts of a trial in a table: name, gait and speed."""

    @abstractmethod
    def picture(self, trials: Sequence[T]) -> str:
        """Return an <svg> element of one trial or more, with its caption."""

    @abstractmethod
    def plot(self, trials: Sequence[T], *, width: float) -> Figure:
        """Return a figure of one trial or more; `width` [inch]."""

    def table(self, trials: Sequence[T]) -> pd.DataFrame:
        """Return a table with a row for each run."""
        import pandas as pd

        return pd.concat([trial.to_pandas() for trial in trials])

    @abstractmethod
    def summaries(self, trials: Sequence[T], robot: Robot) -> list[dict[str, Any]]:
        """Return a summary of each trial or file for JSON, units in the names."""

    @abstractmethod
    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Yield the lines of text of a summary from `summaries`."""
