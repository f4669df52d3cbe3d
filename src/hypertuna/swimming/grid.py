"""Grids of gaits that are never in memory as a whole, and parts of any gaits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from hypertuna.arrays import Array
from hypertuna.swimming.gait import KINDS, Gaits, check_count, grid_axes

AXES = ("frequency", *KINDS)


@dataclass(frozen=True)
class GaitGrid:
    """A grid of gaits of any size: every combination of the values of its axes, the last changing fastest.

    Parameters
    ----------
    frequency, amplitude, phase, bias
        Values of each, as of `Gaits.grid` [Hz, rad].

    Raises
    ------
    InputError
        As `Gait` does, at the first value that cannot be used.
    """

    frequency: Sequence[float] | Array  # (n,) [Hz]
    amplitude: Sequence[Sequence[float]] | Array  # (n, groups) [rad], as phase and bias
    phase: Sequence[Sequence[float]] | Array
    bias: Sequence[Sequence[float]] | Array | None = None
    degrees: bool = field(default=False, kw_only=True)  # whether a sweep labels its axes in degrees

    def __post_init__(self) -> None:
        for name, axis in grid_axes({name: getattr(self, name) for name in AXES}, 1.0).items():
            object.__setattr__(self, name, axis)

    @classmethod
    def from_degrees(
        cls,
        *,
        frequency: Sequence[float],
        amplitude: Sequence[Sequence[float]],
        phase: Sequence[Sequence[float]],
        bias: Sequence[Sequence[float]] | None = None,
    ) -> Self:
        """Make a grid from angles in degrees.

        Parameters
        ----------
        frequency, amplitude, phase, bias
            Values of each, as of `Gaits.grid_degrees` [Hz, deg].

        Returns
        -------
        GaitGrid

        Raises
        ------
        InputError
            As `Gait` does, at the first value that cannot be used, in degrees.

        Examples
        --------
        >>> phase = [(0, lag / 100) for lag in range(10_000)]
        >>> len(GaitGrid.from_degrees(frequency=range(1, 7), amplitude=[(8, a) for a in range(100)], phase=phase))
        6000000
        """
        given = {"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias}
        return cls(**grid_axes(given, math.pi / 180), degrees=True)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(getattr(self, name)) for name in AXES)

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def gaits(self) -> Gaits:
        """All gaits at once, if there are not too many."""
        check_count(len(self))
        whole = Part.of(self, 0, len(self)).listed()
        return Gaits(*whole.columns, shape=self.shape, degrees=self.degrees)


@dataclass(frozen=True)
class Part:
    """A range of gaits that is small to send: of a grid its axes, of a list the range alone."""

    first: int  # of all gaits
    last: int  # one beyond
    gaits: Gaits | GaitGrid = field(repr=False)  # the grid, or the gaits of the range

    @classmethod
    def of(cls, gaits: Gaits | GaitGrid, first: int, last: int) -> Self:
        """Take a range of gaits."""
        if isinstance(gaits, Gaits):
            gaits = Gaits(*(column[first:last] for column in gaits.columns), shape=(last - first,))
        return cls(first, last, gaits)

    def listed(self) -> Gaits:
        """Return the gaits as a list."""
        if isinstance(self.gaits, Gaits):
            return self.gaits
        index = np.unravel_index(np.arange(self.first, self.last), self.gaits.shape)
        columns: list[Any] = [np.asarray(getattr(self.gaits, name))[k] for name, k in zip(AXES, index, strict=True)]
        return Gaits(*columns, shape=(self.last - self.first,))

    def chunks(self, size: int) -> Iterator[Gaits]:
        """Yield the gaits as lists of at most a size."""
        for first in range(self.first, self.last, size):
            last, start = min(first + size, self.last), self.first if isinstance(self.gaits, Gaits) else 0
            yield Part.of(self.gaits, first - start, last - start).listed()


def axis(gaits: Gaits | GaitGrid, name: str) -> Array:
    """Return the values along an axis of a grid, or of all gaits of a list, (n,) [Hz] or (n, groups) [rad]."""
    values: Any = getattr(gaits, name)
    if isinstance(gaits, Gaits) and len(gaits.shape) == 4:
        # Along its own axis an entry stands where all other indices are 0.
        values = values.reshape(*gaits.shape, *values.shape[1:])
        values = values[tuple(slice(None) if name == other else 0 for other in AXES)]
    return np.asarray(values)
