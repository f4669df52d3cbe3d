"""Base of the text forms: read points from named columns, recognize columns of time and frames."""

import re
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from hypertuna.errors import InputError, shown
from hypertuna.trials.grid import Grid, Samples
from hypertuna.trials.points import Points

# Units of length in names of columns [m]; none of pixels.
UNITS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "in": 0.0254, "inch": 0.0254, "ft": 0.3048,
    "px": None, "pixel": None, "pixels": None,
}  # fmt: skip
# Names of likelihoods and of flags of markers that were seen.
WEIGHTS = (
    "likelihood", "lik", "score", "confidence", "conf", "prob", "probability", "visible", "visibility", "valid", "p"
)  # fmt: skip
AXES = {"x": 0, "y": 1, "z": 2}
FIX = "name columns of markers x1, y1, x2, y2, ... or nose_x, nose_y, ..."


class Text(NamedTuple):
    """A form of text files or sheets: its name, a test for it, and its reader."""

    name: str
    recognized: Callable[[Grid], bool]
    read: Callable[[Grid, str | None], Points]
    individuals: bool = False  # whether it may hold several animals or cameras


def of_columns(
    form: str,
    samples: Samples,
    columns: dict[str, dict[str, int]],
    *,
    words: bool = False,
    infinite: bool = False,
    **known: Any,
) -> Points:
    """Return points from their columns; columns: by point, that of "x" and "y", and optionally of "z" and "weight"."""
    if len(columns) < 2:
        raise InputError("must have at least two markers", file=samples.file, value=f"{len(columns)}", fix=FIX)
    for name, axes in columns.items():
        if axis := next((axis for axis in "xy" if axis not in axes), None):
            raise InputError(f"must have a column of {axis}", file=samples.file, key=f"marker {name}", fix=FIX)
    flat = [name for name, axes in columns.items() if "z" not in axes]
    if 0 < len(flat) < len(columns):
        fix = "give z of all markers, or of none"
        raise InputError("must have a column of z, like others", file=samples.file, key=f"marker {flat[0]}", fix=fix)
    spatial = all("z" in axes for axes in columns.values())
    place = np.full((len(samples.rows), len(columns), 3 if spatial else 2), np.nan)
    weight = np.full(place.shape[:2], np.nan)
    for m, axes in enumerate(columns.values()):
        for axis in "xyz"[: place.shape[2]]:
            place[:, m, AXES[axis]] = samples.numbers(axes[axis], infinite=infinite)
        if "weight" in axes:
            weight[:, m] = samples.numbers(axes["weight"], words=words, infinite=infinite)
    place[~np.isfinite(place).all(axis=2)] = np.nan
    return Points(form, samples.file, tuple(columns), place, weight, samples.where, **known)


def one_point(form: str, file: str, fix: str) -> InputError:
    """Return the error for a file with one point per animal, which does not show joint angles."""
    rule = f"is of the form of {form}, and holds one point of each animal: joint angles need several along one body"
    return InputError(rule, file=file, fix=fix)


# Names of time and frame columns after `plain`; a name of time may end with one of these units [s].
SECONDS = {
    "s": 1.0, "sec": 1.0, "sek": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0,
    "ms": 1e-3, "msec": 1e-3, "millis": 1e-3, "milliseconds": 1e-3,
    "us": 1e-6, "µs": 1e-6, "usec": 1e-6, "micros": 1e-6, "microseconds": 1e-6,
    "ns": 1e-9, "nsec": 1e-9, "nanos": 1e-9, "nanoseconds": 1e-9,
    "min": 60.0, "minutes": 60.0,
}  # fmt: skip
FRAMES = "frames?|fnum|fr|bild|einzelbild|trame|cuadro|fotograma|fotogramma|quadro|beeld|klatka|кадр|フレーム|帧"
TIMES = "time|zeit|temps|tiempo|tempo|tijd|czas|время|時間|时间"
FRAME = re.compile(
    rf"(?:video|camera|cam|image|img)?(?:{FRAMES})(?:idx|index|ids?|no|nos|nr|num|nummer|number|numbers|count|counter)?"
    r"|(?:image|img|picture|file)s?(?:name|no|nr|num|number|idx|index|path|file)?|slice|fno"
)
TIME = re.compile(
    rf"(?!(?:{FRAME.pattern})$)(?:video|camera|frame|image|elapsed|relative|rel|abs|absolute|clock|unix|epoch|utc|system|local|gps|sim|wall|ros|real|trial|recording)?"
    rf"(?:(?:timestamp|dateandtime|datetime|timeofday|timecode|{TIMES}|pts(?:time)?|utc|clock|elapsed|t)"
    rf"(?P<unit>{'|'.join(SECONDS)}|hhmmss[a-z]*)?|(?P<bare>{'|'.join(SECONDS)}))"
)
RATES = (
    "fps", "framerate", "framespersecond", "videofps", "videoframerate", "fs", "rate", "samplerate", "samplingrate"
)  # fmt: skip
INDEX = re.compile(r"(unnamed.{0,9}|index)?", re.IGNORECASE)  # of a table, as pandas names it


def unit_of(file: str, units: Iterable[str | None]) -> dict[str, Any]:
    """Return the unit that the names of columns of coordinates state, as fields of `Points`; it must be one."""
    words = {(unit or "").lower() for unit in units}
    if len(words) > 1:
        value, fix = ", ".join(sorted(unit or "none" for unit in words)), "write all coordinates in one unit"
        raise InputError("must have one unit", file=file, key="names of columns", value=value, fix=fix)
    word = next(iter(words), "")
    if word and word not in UNITS:
        rule, value = f"must be one of {', '.join(UNITS)}", shown(word)
        raise InputError(rule, file=file, key="the unit in names of columns", value=value, fix="convert the places")
    length = UNITS.get(word)
    return {"length_unit": length, "in_pixels": bool(word) and length is None}


def plain(name: str) -> str:
    """Return the name of a column in lower case, without separators and brackets."""
    return re.sub(r"[\W_]", "", name.lower())


def seconds_per_unit(match: re.Match[str]) -> float | None:
    """Return the unit [s] in the name of a column of time that `TIME` matched; None where it has none."""
    return SECONDS.get(match["unit"] or match["bare"] or "")


def time_and_frame(head: list[str]) -> tuple[int | None, float | None, int | None]:
    """Return the time column's index, its unit [s] and the frame column's index; None for any not in the names."""
    matches = [(k, match) for k, name in enumerate(head) if (match := TIME.fullmatch(plain(name)))]
    units = {k: seconds_per_unit(match) for k, match in matches}
    time = next((k for k in units if units[k] is not None), next(iter(units), None))
    frame = next((k for k, name in enumerate(head) if FRAME.fullmatch(plain(name))), None)
    return time, None if time is None else units[time], frame
