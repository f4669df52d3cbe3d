"""Tracked points of one animal or robot as read from a file, in its units, before any checks."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.ranges import CELL

APART = 0.5  # lengths: another animal is at least as far away
MAX_LISTED = 300  # largest length of the list of names in an error [characters]
MAX_COORDINATE = CELL.max or np.inf  # in any unit


class Rows(Sequence[str]):
    """Names of rows in errors, such as "line 12": a word, and the number of each row."""

    def __init__(self, word: str, number: Sequence[float] | Array) -> None:
        self.word, self.number = word, number

    def __len__(self) -> int:
        return len(self.number)

    def __getitem__(self, row: Any) -> Any:
        return Rows(self.word, self.number[row]) if isinstance(row, slice) else f"{self.word} {self.number[row]:.12g}"


@dataclass(frozen=True)
class Points:
    """Tracked points as read from a file, in its units."""

    form: str  # name of the form, in sentences
    file: str
    names: tuple[str, ...]  # names of the points, in the order of the file
    place: Array  # (rows, points, 2 or 3) in the file's unit; NaN where a point is missing
    weight: Array  # (rows, points) likelihood as in the file, NaN where the file has none
    where: Sequence[str]  # (rows,) name of each row in errors, such as "line 12"
    time: Array | None = None  # (rows,) as in the file, NaN where a cell is empty
    time_unit: float | None = None  # seconds per unit of `time`; None where the file does not say
    frame: Array | None = None  # (rows,) numbers of frames as written, NaN where a cell is empty
    rate: float | None = None  # frames per second, where the file says
    length_unit: float | None = None  # meters per unit, where the file says
    in_pixels: bool = False  # whether the file says so
    y_down: bool | None = None  # whether y points down; None where the form does not say
    vertical: int | None = None  # index of the axis that points up, if the form defines it
    ignored: tuple[str, ...] = ()  # names of unused columns
    notes: tuple[str, ...] = ()  # sentences on how the file was read, without the final dot
    time_name: str = "time"  # name of the time column
    frame_name: str = "frame"  # name of the frame column


def no_individuals(file: str, chosen: str) -> InputError:
    """Return the error to raise where an animal is chosen in a file that does not tell several apart."""
    fix = "leave it out, or check which file this is"
    return InputError("is for files of several animals", file=file, key="--individual", value=shown(chosen), fix=fix)


def choose_individual(file: str, known: Sequence[str], chosen: str | None, *, what: str = "animal") -> str:
    """Return which of a file's animals (or cameras, or other `what`) to read: the chosen one, or the only one."""
    known = list(dict.fromkeys(known))
    if chosen is None and len(known) == 1:
        return known[0]
    if chosen not in known:
        listable = len(", ".join(known)) <= MAX_LISTED
        rule = f"must be one of {', '.join(known)}" if listable else f"must be one of the {len(known)} of the file"
        fix = f"choose the {what}" if chosen is None and listable else did_you_mean(chosen or "", known)
        value = None if chosen is None else shown(chosen)
        raise InputError(rule, file=file, key="--individual", value=value, fix=fix)
    return chosen


def seen(place: Array) -> Array:
    """Return places (..., 2 or 3) with NaN where a coordinate is missing or too large in any unit."""
    return np.where((np.abs(place) <= MAX_COORDINATE).all(axis=-1, keepdims=True), place, np.nan)


def of_one_animal(frame: Array, track: Sequence[Any] | Array, place: Array) -> bool:
    """Whether tracks, never there at the same time, are of one animal: each begins where the one before ended.

    frame, track: number and name (rows,), in the order of frames; place: (rows, points, 2), NaN where missing.
    """
    shown_rows = np.isfinite(place[..., 0]).any(axis=1)
    if not shown_rows.any():
        return True
    place, frame, tracks = place[shown_rows], frame[shown_rows], np.asarray(track)[shown_rows]
    center = np.nanmedian(place, axis=1)
    length = 2 * float(np.median(np.nanmax(np.linalg.norm(place - center[:, np.newaxis], axis=2), axis=1)))
    step, frames = np.linalg.norm(np.diff(center, axis=0), axis=1), np.diff(frame)
    same = np.asarray(tracks[1:] == tracks[:-1], dtype=bool)
    usual = float(np.quantile(step[same] / frames[same], 0.9)) if same.any() else 0.0
    return bool((step <= APART * length + 2 * usual * frames)[~same].all())


def joined_tracks(names: Sequence[str]) -> str:
    """Return the sentence on tracks that are read as one animal."""
    listed = ", ".join(names[:12])
    return f"the tracks {listed} are never there at the same time, follow each other, and are read as one animal"
