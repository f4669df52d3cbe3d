"""Base of the binary forms: names of rows, missing places, and points from arrays of numbers."""

from collections.abc import Sequence

import numpy as np

from hypertuna.arrays import Array
from hypertuna.ranges import CELL

LARGEST = CELL.max or np.inf


class Rows(Sequence[str]):
    """What rows are called in errors: a word and the number of each."""

    def __init__(self, word: str, number: Sequence[float] | Array) -> None:
        self.word, self.number = word, number

    def __len__(self) -> int:
        return len(self.number)

    def __getitem__(self, row):  # type: ignore[no-untyped-def]  # one or a slice
        return Rows(self.word, self.number[row]) if isinstance(row, slice) else f"{self.word} {self.number[row]:.12g}"


def seen(place: Array) -> Array:
    """Return places (..., 2 or 3), NaN where a coordinate is missing or no place in any unit."""
    return np.where((np.abs(place) <= LARGEST).all(axis=-1, keepdims=True), place, np.nan)
