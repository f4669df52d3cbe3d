"""The clock of tracked points: times from columns of time and frames, and rates; two that disagree are refused."""

import math

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.ranges import Range
from hypertuna.trials.points import Points

RATE = Range(min=5, max=2000, unit="Hz")
SAME = 0.01  # relative difference of two rates that are the same
ROUGH = 0.2  # frames: a coarser resolution of times is reported
HALF = 0.5  # frames: a time that lies farther from that of its frame's number
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
TICKS = {"min": 60.0, "100 ns": 1e-7, "ticks of 90 kHz": 1 / 90000}  # other units of clocks, in no name of a column
COUNTERS = (60, 100, 256, 1000, 1024, 3600, 4096, 10000, 32768, 65536, 86400, 2**32)  # at which some start over
SMALL_STEP = 5  # whole numbers that grow by less may be those of frames
SUMMARIES, MANY, ROUNDED = 6, 12, 1e-3  # last rows that may sum up others; fewest of those, and coordinates; error
FAR = 1e5  # s: a clock that begins later counts from the first frame


def clock_of(points: Points, frame_rate: float | None) -> tuple[Array, tuple[str, ...]]:
    """Return the time of each row [s], and sentences on the columns and rates that it follows from.

    frame_rate: as the user says [Hz]. A column of frames or time is always used; the order of the rows only without.
    """
    file, notes = points.file, []
    rate = points.rate if frame_rate is None else frame_rate
    for key, value in (("--frame-rate", frame_rate), ("the frame rate", points.rate)):
        if value is not None:
            RATE.check(value, key, "give frames per second", file=None if value is frame_rate else file)
    if rate and points.rate and abs(rate / points.rate - 1) > SAME:
        rule, fix = f"must be {points.rate:g} Hz, as the file says", "leave it out, or correct the rate in the file"
        raise InputError(rule, file=file, key="--frame-rate", value=f"{rate:g}", fix=fix)
    frame = points.frame
    if frame is not None:
        _check(points, frame, points.frame_name, "give the number of the frame")
        for k in np.flatnonzero(frame != np.round(frame))[:1]:
            key, fix = f"{points.where[k]}, {points.frame_name}", "give whole numbers, or call a column of time time_s"
            raise InputError("must be a whole number", file=file, key=key, value=f"{frame[k]:g}", fix=fix)
        frame = frame - frame[0] if points.time is not None else frame
    if points.time is not None:
        _check(points, points.time, points.time_name, "give the time in s")
        unit, note = _unit(points, frame, rate)
        notes += note
        start = float(points.time[0])
        time = unit * (points.time - (start if abs(unit * start) > FAR else 0.0))
        if abs(unit * start) > FAR:
            notes.append(f"the clock counts from the first frame, at {unit * start:.3f} s")
        notes += _compare(points, time, frame, rate)
    elif rate is None:
        fix = "give --frame-rate in Hz, or a column time_s"
        raise InputError("must have a column of time", file=file, key="time_s", value="missing", fix=fix)
    elif frame is not None:
        time = frame / rate
    else:
        _check_rows(points)
        time = np.arange(len(points.place)) / rate
        notes.append("there is no column of frames or time: each row counts as the next frame")
    if len(time) > 1:
        _check_rate(points, time)
    return time, tuple(notes)


def _check_rows(points: Points) -> None:
    """Check that the rows of a file without a column of frames or time are those of its frames, and all of them."""
    place, line = points.place.reshape(len(points.place), -1)[:, :MANY], getattr(points.where, "number", ())
    step = np.diff(np.array(line, dtype=float))
    for k in np.flatnonzero(step > np.min(step, initial=np.inf))[:1]:
        rule, value = "must be that of the next frame, for no column counts them", "below lines without numbers"
        fix = "add a column frame, or leave the cells of a lost frame empty between their commas"
        raise InputError(rule, file=points.file, key=points.where[k + 1], value=value, fix=fix)
    for k in range(max(len(place) - SUMMARIES, MANY), len(place)):
        above = place[:k][np.isfinite(place[:k]).all(axis=1)]
        if len(above) < MANY:
            continue
        for name, of in (("means", np.mean), ("medians", np.median), ("largest values", np.max), ("smallest", np.min)):
            if (np.abs(place[k] - of(above, axis=0)) <= ROUNDED * np.ptp(above, axis=0)).all():
                fix = "remove what a spreadsheet has computed below the frames"
                raise InputError(f"holds the {name} of the rows above", file=points.file, key=points.where[k], fix=fix)


def _check(points: Points, values: Array, name: str, fix: str) -> None:
    """Check that a column of times or frame numbers has no gap and increases."""
    for k in np.flatnonzero(~np.isfinite(values))[:1]:
        key = f"{points.where[k]}, {name}"
        raise InputError("must be a finite number", file=points.file, key=key, value="missing", fix=fix)
    for k in np.flatnonzero(~(np.diff(values) > 0))[:1] + 1:
        key = f"{points.where[k]}, {name}"
        rule = f"must be later than the previous frame, at {values[k - 1]:.12g}"
        value, fix = f"{values[k]:.12g}", _fix_of_order(values)
        raise InputError(rule, file=points.file, key=key, value=value, fix=fix)


def _fix_of_order(values: Array) -> str:
    """Return what to do about times or frame numbers that do not increase, by their pattern."""
    step = np.diff(values)
    falls = np.flatnonzero(step < 0)
    if len(falls) == len(step):
        return "they run backward: write the last row first"
    if not len(falls):
        return "several animals, or rounded times? give one animal, or frames with --frame-rate and without the times"
    usual = float(np.median(step[step > 0])) if (step > 0).any() else 0.0
    if len(falls) > 1 + len(step) / 10 or (step[falls] > -5 * usual).any():
        return "sort the frames by time, without repeats"
    for top in COUNTERS:
        if all(top - 2 * usual <= values[f] <= top and values[f + 1] <= 2 * usual for f in falls):
            return f"it is a counter that starts over at {top}: add {top} to what follows"
    return "it starts over there: give each run in a file of its own"


def _unit(points: Points, frame: Array | None, rate: float | None) -> tuple[float, list[str]]:
    """Return the unit [s] of the time column, by its name or by a possible frame rate, and sentences on a guess.

    Several units may give a possible rate: then the frame rate decides, which the user or the file states.
    """
    assert points.time is not None
    if points.time_unit is not None or len(points.time) < 2:
        return points.time_unit or 1.0, []
    step = float(np.median(np.diff(points.time) / (np.diff(frame) if frame is not None else 1.0)))
    candidates = {name: unit for name, unit in (UNITS | TICKS).items() if 1 / (step * unit) in RATE}
    if rate is not None:
        candidates = {name: unit for name, unit in candidates.items() if abs(1 / (step * unit) / rate - 1) < SAME}
    key = f"column {points.time_name}"
    if rate is not None and not candidates:
        rule = f"must grow by {1 / rate:.4g} s, as the frame rate of {rate:g} Hz says, in some unit"
        fix = "write its unit into its name, such as time_s, or leave out --frame-rate"
        raise InputError(rule, file=points.file, key=key, value=f"in steps of {step:g}", fix=fix)
    if rate is None and step == round(step) and step < SMALL_STEP and list(candidates) != ["s"] and candidates:
        fix = f"it grows by {step:g}: call it frame if it counts frames, or time_ms"
        raise InputError("must say its unit in its name", file=points.file, key=key, fix=fix)
    if len(candidates) > 1:
        rates = ", ".join(f"{1 / (step * unit):.4g} Hz in {name}" for name, unit in candidates.items())
        rule, fix = "must say its unit in its name", f"call it time_s, time_ms or so, or give --frame-rate: {rates}"
        raise InputError(rule, file=points.file, key=key, fix=fix)
    if list(candidates) in ([], ["s"]):
        return 1.0, []  # no unit gives a possible rate: the check of the rate says so
    ((name, unit),) = candidates.items()
    fps, span = 1 / (step * unit), unit * float(np.ptp(points.time))
    return unit, [
        f"column {points.time_name} is taken in {name}, which gives {fps:.4g} frames per second, {span:.3g} s in all"
    ]


def _compare(points: Points, time: Array, frame: Array | None, rate: float | None) -> list[str]:
    """Check times against frame numbers and frame rate [Hz]; return sentences on frames left out and on differences."""
    if len(time) < 2:
        return []
    step = np.diff(time) / (np.diff(frame) if frame is not None else 1.0)
    # With frame numbers, the mean interval, which averages rounding errors; else the median, which ignores lost frames.
    interval = float((time[-1] - time[0]) / (frame[-1] - frame[0])) if frame is not None else float(np.median(step))
    if rate is not None:
        ratio = 1 / interval / rate
        rounded = 3 * _resolution(points) / interval if frame is None else 0.0
        if abs(ratio - 1) > SAME + rounded:
            rule = f"must be {1 / interval:.4g} Hz, as the column {points.time_name} says"
            of_file = points.rate is not None
            fix = "correct the rate in the file, or its times" if of_file else "leave it out, or correct the column"
            if (stride := round(1 / ratio)) > 1 and abs(ratio * stride - 1) <= SAME + rounded:
                times = f"if the film was played {stride} times slower, drop the column {points.time_name}"
                fix = f"{times}; if one frame of {stride} was tracked, leave out the rate"
            key = "the file's frame rate" if of_file else "--frame-rate"
            raise InputError(rule, file=points.file, key=key, value=f"{rate:g}", fix=fix)
    if frame is None:
        return _rounded(points, step)
    error = time - time[0] - interval * (frame - frame[0])
    k = int(np.argmax(np.abs(error)))
    if abs(error[k]) > HALF * interval:
        return [
            f"the columns {points.time_name} and {points.frame_name} disagree by {abs(error[k]) / interval:.1f} frames "
            f"in {points.where[k]}: the times are those of {points.time_name}"
        ]
    return []


def _rounded(points: Points, step: Array) -> list[str]:
    """Return a sentence on times that are rounded by a large part of a frame; step: between frames [s]."""
    size, usual = _resolution(points), float(np.median(step))
    if size <= ROUGH * usual or np.ptp(step[step < 1.5 * usual]) < size / 2:
        return []
    advice = "a column of frames and --frame-rate in place of it would be exact"
    return [f"column {points.time_name} is rounded to {size:g} s, {size / usual:.1f} frames: {advice}"]


def _resolution(points: Points) -> float:
    """Return the resolution of the time column [s]: the largest power of ten whose multiples all times are."""
    assert points.time is not None
    values = np.abs(points.time[: min(len(points.time), 200)])
    for digits in range(7):
        if np.allclose(values, np.round(values, digits), rtol=0, atol=1e-9):
            return float(10.0**-digits * (points.time_unit or 1.0))
    return 0.0


def _check_rate(points: Points, time: Array) -> None:
    """Check that the frames follow each other at a possible rate."""
    rate = 1 / float(np.median(np.diff(time)))
    if rate in RATE:
        return
    unit = points.time_unit or 1.0
    better = [name for name, other in UNITS.items() if rate * unit / other in RATE]
    fix = f"in {better[0]} it would be possible: call the column time_{better[0]}" if better else "check the clock"
    if RATE.min is not None and rate < RATE.min and points.time_unit is not None:
        slow = "so few frames show no beat: track all those of the film"
        fix = f"{fix}; if its unit is right, {slow}" if better else slow
    if points.time is None:
        fix = "check --frame-rate, and whether the file has all frames"
    key = f"the rate by {points.time_name if points.time is not None else points.frame_name}"
    value = f"{rate:.3g}" if math.isfinite(rate) else "none"
    raise InputError(RATE.rule, file=points.file, key=key, value=value, fix=fix)
