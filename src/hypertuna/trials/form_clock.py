"""Columns of time and frames in forms of text: one reader for all, that refuses a clock of which nothing is known."""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hypertuna.errors import InputError, shown
from hypertuna.io.tables import parse_float
from hypertuna.trials.clock import UNITS
from hypertuna.trials.form import INDEX, RATES, TIME, plain, seconds_per_unit, time_and_frame
from hypertuna.trials.form import UNITS as LENGTHS
from hypertuna.trials.grid import Samples
from hypertuna.trials.points import Points

# Seconds and their parts in two columns, as ROS has them: names after `plain`, and units [s] of the parts.
WHOLE = re.compile(r"(?P<stem>.*?)(?:tv)?(?:secs?|seconds?)")
PARTS = {"nano": 1e-9, "n": 1e-9, "micro": 1e-6, "u": 1e-6, "milli": 1e-3, "m": 1e-3}
PART = re.compile(rf"(?P<stem>.*?)(?:tv)?(?P<unit>{'|'.join(PARTS)})(?:secs?|seconds?)")
INTERVAL = re.compile(r"(?:dt|delta_?t(?:ime)?|(?:frame)?interval|timestep)(?:s|sec|ms|us|ns)?")
STATED = re.compile(r"#+\s*([A-Za-z][\w ./-]{0,40}?)\s*[:=]\s*(\S.{0,40}?)")  # a comment that says what a key is
STATED_RATE = re.compile(r"(\d{1,4}(?:\.\d{1,6})?)\s*(?:hz|fps|frames?\W.*)?", re.IGNORECASE)
LIKE, DIGIT = re.compile(r"\d:\d\d"), re.compile(r"\d")
LENGTH_KEYS = ("unit", "lengthunit", "unitoflength", "coordinateunit", "positionunit")
FILE = re.compile("files?(name|path)?")
GROWING = 3  # rows from which on a column of growing numbers may be a clock
MOST = 0.9  # part of the cells of a column that makes it a clock
SAME_SPAN = 0.05  # relative difference of two clocks that agree


Comments = Sequence[tuple[int, str]]  # numbers of lines, and texts


def clock_columns(
    samples: Samples, used: Sequence[int], head: Sequence[str] = ()
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the columns of time and frames as fields of `Points`, and sentences on them.

    used: columns of coordinates, likelihoods, names; head: names of columns, where not those of the samples.
    """
    names = ["" if k in used or _is_label(samples, k, name) else name for k, name in enumerate(head or samples.head)]
    time, second, frame = time_and_frame(names)
    fields: dict[str, Any] = {}
    pair = _pair(samples, names)
    if pair is not None and time in (None, *pair[:2]):
        used, time = [*used, *pair[:2]], pair[0]
        values = samples.numbers(pair[0], limit=False) + pair[2] * samples.numbers(pair[1], limit=False)
        fields = {"time": values, "time_unit": 1.0, "time_name": f"{names[pair[0]]} and {names[pair[1]]}"}
    elif time is not None:
        values, of_text = samples.times(time)
        fields |= {"time": values, "time_unit": 1.0 if of_text else second, "time_name": names[time]}
        _check_others(samples, names, fields)
    for k in (k for k, name in enumerate(names) if plain(name) in RATES and samples.rows):
        rates = samples.numbers(k)
        if not (rates == rates[0]).all():
            rule, fix = "must be the same in all rows", "give each run in a file of its own, or a column time_s"
            raise InputError(rule, file=samples.file, key=f"column {names[k]}", value="not", fix=fix)
        fields["rate"] = float(rates[0])
    taken = [*used, *(k for k in (time, frame) if k is not None)]
    index, notes = _index(samples, taken, clock=len(taken) > len(used)), ()
    if frame is None:
        frame = index
        _check_intervals(samples, names, time, frame)
    elif index is not None:
        step, frame_step = np.diff(samples.numbers(index)), np.diff(samples.frames(frame))
        if (step * frame_step[0] != frame_step * step[0]).any():
            sentence = "and the first column, without a name, disagree: the frames are those of the former"
            return _with_frame(samples, names, frame, fields), (f"{names[frame]} {sentence}",)
    return _with_frame(samples, names, frame, fields), notes


def with_comments(points: Points, comments: Comments) -> Points:
    """Return points with the frame rate and the unit of length that comments state, such as `# fps: 60`."""
    for line, comment in comments:
        match = STATED.fullmatch(comment)
        key, value = (plain(match[1]), match[2].lower().strip("[]() ")) if match else ("", "")
        fix = "correct the comment, or remove it"
        if key in RATES and key != "rate" and (rate := STATED_RATE.fullmatch(value)):
            if points.rate is not None and points.rate != float(rate[1]):
                rule = f"must be {points.rate:g}, as the file says elsewhere"
                raise InputError(rule, file=points.file, key=f"line {line}", value=shown(comment), fix=fix)
            points = replace(points, rate=float(rate[1]))
        elif key.removesuffix("s") in LENGTH_KEYS and value in LENGTHS:
            known = points.in_pixels or points.length_unit is not None
            stated: dict[str, Any] = {"length_unit": LENGTHS[value], "in_pixels": LENGTHS[value] is None}
            if known and (points.length_unit, points.in_pixels) != tuple(stated.values()):
                rule = "must be the unit that the form or the names of columns say"
                raise InputError(rule, file=points.file, key=f"line {line}", value=shown(comment), fix=fix)
            points = replace(points, **stated)
    return points


def _pair(samples: Samples, names: Sequence[str]) -> tuple[int, int, float] | None:
    """Return the columns of whole seconds and of their parts, and the unit of these [s]; None without them."""
    parts_of = {k: match for k, name in enumerate(names) if name and (match := PART.fullmatch(plain(name)))}
    wholes = {k: match for k, name in enumerate(names) if name and (match := WHOLE.fullmatch(plain(name)))}
    for k, whole in wholes.items():
        for j, part in parts_of.items():
            if k not in parts_of and whole["stem"] == part["stem"]:
                seconds, parts = samples.numbers(k, limit=False), samples.numbers(j, limit=False)
                unit = PARTS[part["unit"]]
                if (seconds == np.round(seconds)).all() and ((parts >= 0) & (unit * parts < 1)).all():
                    return k, j, unit
    return None


def _check_intervals(samples: Samples, names: Sequence[str], time: int | None, frame: int | None) -> None:
    """Check that no column of intervals that differ is the only clock."""
    for k in (k for k, name in enumerate(names) if INTERVAL.fullmatch(plain(name)) and time is None and frame is None):
        values = np.array([parse_float(text) for text in samples.text(k)[1:]])
        if np.isfinite(values).any() and np.nanmax(values) - np.nanmin(values) > SAME_SPAN * np.nanmax(np.abs(values)):
            rule, fix = "has the intervals between the frames, and no times", "write their sum into a column time_s"
            raise InputError(rule, file=samples.file, key=f"column {names[k]}", fix=fix)


def _is_label(samples: Samples, column: int, name: str) -> bool:
    """Return whether a column of files names the film, the same one in each row."""
    return bool(FILE.fullmatch(plain(name))) and len(set(samples.text(column))) == 1 < len(samples.rows)


def _with_frame(samples: Samples, names: list[str], frame: int | None, fields: dict[str, Any]) -> dict[str, Any]:
    """Return fields of `Points` with those of a column of frames."""
    if frame is None:
        return fields
    return fields | {"frame": samples.frames(frame), "frame_name": names[frame] or "the first column"}


def _check_others(samples: Samples, names: list[str], fields: dict[str, Any]) -> None:
    """Check that other columns of time span as long as the one that is read, in the units stated or in any."""
    for k, name in enumerate(names):
        match = TIME.fullmatch(plain(name))
        if not match or name == fields["time_name"] or not samples.rows:
            continue
        try:
            values, of_text = samples.times(k)
        except InputError:
            continue  # no clock
        own, other = fields["time_unit"], 1.0 if of_text else seconds_per_unit(match)
        read, span = (float(np.ptp(one)) * (unit or 1.0) for one, unit in ((fields["time"], own), (values, other)))
        factors = [1.0] if own and other else [one / two for one in UNITS.values() for two in UNITS.values()]
        if span > 0 and all(abs(factor * span - read) > SAME_SPAN * max(factor * span, read) for factor in factors):
            rule, value = "must agree", f"{read:.4g} s long and {span:.4g} s"
            fix = "keep the clock that is right, such as that of the camera and not that of the film"
            key = f"the columns {fields['time_name']} and {name}"
            raise InputError(rule, file=samples.file, key=key, value=value, fix=fix)


def _index(samples: Samples, used: Sequence[int], clock: bool) -> int | None:
    """Return the index of an unnamed column of frame numbers, whose whole numbers grow; None without one.

    Beside a clock, an index that only counts the rows says nothing. Without one, a column that looks like a clock and
    has no known name is refused: its meaning would be a guess.
    """
    candidates, skipping = [], []  # columns that may be an index, and those of them that do not only count the rows
    for k in (k for k in range(len(samples.head)) if k not in used and len(samples.rows) >= GROWING):
        texts = samples.text(k)
        values, nameless = np.array([parse_float(text) for text in texts]), INDEX.fullmatch(samples.head[k])
        whole, step = np.isfinite(values).all(), np.diff(values[np.isfinite(values)])
        if nameless and whole and (values == np.round(values)).all() and (step > 0).all():
            candidates.append(k)
            skipping += [k] * bool((step != 1).any())
        elif not clock and (rule := _looks_like_a_clock(texts, values, step)):
            key = f"column {samples.head[k]}" if samples.head[k] else f"column {k + 1}, which has no name"
            raise InputError(rule, file=samples.file, key=key, value=shown(texts[-1]), fix=CALL)
    if len(skipping) > 1:
        rule, fix = "must have one index", "call the column of frames frame, and drop the others"
        raise InputError(rule, file=samples.file, value=f"{len(skipping)} columns without a name that count", fix=fix)
    return next(iter(skipping if clock else [*skipping, *candidates]), None)


CALL = "call it frame, or time_s, or drop it"


def _looks_like_a_clock(texts: list[str], values: Any, step: Any) -> str:
    """Return what a column of no known name looks like, of cells, their numbers, and steps between these; or ""."""
    if len(step) + 1 >= MOST * len(values) and (step >= 0).all() and (step > 0).any():
        return "grows from row to row, but nothing says what it counts"
    if sum(bool(LIKE.search(text)) for text in texts) >= MOST * len(texts) and len(set(texts)) > 1:
        return "looks like a clock, but its name is not known"
    named = len(step) == 0 and texts == sorted(set(texts)) and all(DIGIT.search(text) for text in texts)
    return "numbers the rows by names, but nothing says what these are" if named else ""
