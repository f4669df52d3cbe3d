"""Find the blinks of a lamp in a film, and the offset and drift of a log's clock from the film's."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.film.source import Film
from hypertuna.io.tables import parse_float, read_table

MIN_LEVEL = 20.0  # gray levels between lamp on and off
LAMP_MARGIN = 4  # px around the lamp's pixel that are averaged
MAX_DRIFT = 1e-3  # s per s: largest drift of the log's clock that is considered
USUAL_DRIFT = 1e-4  # s per s: prior standard deviation of the drift
MAX_BLINKS = 200  # in a film or a log
MAX_RMS = 0.5  # frames: largest rms residual of the blinks about the line that relates both clocks


@dataclass(frozen=True)
class Clock:
    """The clock of a log relative to that of a film: film = log + offset + drift (log - middle)."""

    offset: float  # s to add to the log's clock, in the middle of the blinks
    middle: float  # s: mean time of the matched blinks by the log's clock
    drift: float  # s per s
    sd: float  # s, standard deviation of the offset
    drift_sd: float
    left: float  # s: rms residual of the blinks about the line
    blinks: int  # number of blinks matched between film and log


def lamp_of(film: Film) -> tuple[int, int]:
    """Return the pixel (u, v) that blinks most: it turns bright and dark, and is brighter than most pixels."""
    import cv2

    samples = np.stack([cv2.blur(sample, (5, 5)) for sample in film.sample()]).astype(np.int16)
    high, low = np.percentile(samples, [95, 5], axis=0)
    middle = np.median(samples, axis=0)
    swing = (high - low) * (np.minimum(high - middle, middle - low) <= 0.25 * (high - low))
    bright = np.where(high > np.percentile(high, 50) + MIN_LEVEL, swing, 0)
    v, u = np.unravel_index(int(np.argmax(bright)), bright.shape)
    if bright[v, u] < MIN_LEVEL:
        fix = "give its pixel by --led, film it larger, or cover it from the light of the room"
        raise InputError("must show a lamp that blinks", file=film.file, value="none", fix=fix)
    return int(u), int(v)


def blinks_of(film: Film, lamp: tuple[int, int]) -> Array:
    """Return the film times [s] at which the lamp at a pixel (u, v) turns on.

    They are known to about half a frame, since the lamp may turn on at any time between two frames.
    """
    u, v = lamp
    if not (0 <= u < film.width and 0 <= v < film.height):
        rule, fix = "must lie in the picture", "give the pixel as a viewer shows it"
        raise InputError(rule, file=film.file, key="--led", value=f"{u}, {v}", fix=fix)
    window = (slice(max(v - LAMP_MARGIN, 0), v + LAMP_MARGIN + 1), slice(max(u - LAMP_MARGIN, 0), u + LAMP_MARGIN + 1))
    level = np.full(len(film.time), np.nan)
    for number, frame in film.frames():
        level[number] = frame[window].astype(float).mean()
    recorded = np.isfinite(level)
    time, level = film.time[recorded], level[recorded]
    low, high = np.percentile(level, [2, 98])
    if high - low < MIN_LEVEL:  # one short blink in a long film
        low, high = float(np.median(level)), float(level.max())
    if high - low < MIN_LEVEL:
        rule, fix = f"must blink by {MIN_LEVEL:g} gray levels", "check --led, and whether the lamp is seen"
        raise InputError(rule, file=film.file, key="the lamp", value=f"{high - low:.1f}", fix=fix)
    lit = level > (low + high) / 2
    starts = np.flatnonzero(lit[1:] & ~lit[:-1]) + 1
    # the lamp turned on at some time since the previous frame: on average half an interval before this one
    return np.asarray(time[starts] - 0.5 / film.rate)


def read_blinks(path: str | Path, column: str = "blink") -> Array:
    """Read the log times [s] at which the lamp turned on, from a CSV file with time_s and a column of 0 or 1."""
    table = read_table(path)
    for name in ("time_s", column):
        if name not in table.head:
            value, fix = ", ".join(table.head), "name the column of the lamp by --column"
            raise InputError("must be a column", file=table.file, key=name, value=f"missing in {value}", fix=fix)
    rows = np.array(table.parse(lambda _, cells: [parse_float(cells[name]) for name in ("time_s", column)]))
    time, on = rows.T
    if not np.isfinite(rows).all() or (np.diff(time) <= 0).any():
        raise InputError(
            "must have numbers, and times that grow",
            file=table.file,
            key=f"time_s and {column}",
            fix="sort the rows by time",
        )
    lit = on > 0.5 * (on.min() + on.max()) if np.ptp(on) else np.zeros(len(on), dtype=bool)
    starts = np.flatnonzero(lit[1:] & ~lit[:-1]) + 1
    if not len(starts):
        fix = "log the command of the lamp: 1 while it is on"
        raise InputError("must go from off to on", file=table.file, key=column, value="never", fix=fix)
    return np.asarray((time[starts] + time[starts - 1]) / 2)


def clock_between(film: Array, log: Array, rate: float, file: str) -> Clock:
    """Match the times (n,) [s] of blinks in film and log, and return the log's clock; rate: frames per second [Hz].

    Blinks may be missing in either. Raise an error where two different matches fit equally many blinks.
    """
    if not len(film):
        raise InputError("must show a blink", file=file, key="the lamp", value="none", fix="film the lamp going on")
    for blinks, where in ((film, "the film"), (log, "the log")):
        if len(blinks) > MAX_BLINKS:
            fix = "blink a few times at the begin and at the end"
            raise InputError(
                f"must be {MAX_BLINKS} at most", file=file, key=f"blinks in {where}", value=f"{len(blinks)}", fix=fix
            )
    matches: dict[tuple[int, ...], Clock] = {}
    for film_blink in film:
        for log_blink in log:
            match = _match(film, log, float(film_blink), float(log_blink), 1 / rate)
            if match is not None:
                matches.setdefault(match[0], match[1])
    most_matched = max((clock.blinks for clock in matches.values()), default=0)
    candidates = [clock for clock in matches.values() if clock.blinks == most_matched]
    offsets = sorted(clock.offset for clock in candidates)
    if len(candidates) > 1 and offsets[-1] - offsets[0] > 2 / rate:
        value = f"offsets of {', '.join(f'{offset:.3g}' for offset in offsets[:4])} s"
        rule, fix = "must match in one way", "blink at unequal times, such as after 1, 3 and 4 s, or film all blinks"
        raise InputError(rule, file=file, key="the blinks", value=value, fix=fix)
    if not candidates or 2 * most_matched <= min(len(film), len(log)):
        value = f"{len(film)} in the film and {len(log)} in the log, of which {most_matched} fit each other"
        fix = "check that both saw the same lamp"
        raise InputError("must be the same in film and log", file=file, key="the blinks", value=value, fix=fix)
    return min(candidates, key=lambda clock: clock.left)


def _match(
    film: Array, log: Array, film_time: float, log_time: float, frame: float
) -> tuple[tuple[int, ...], Clock] | None:
    """Match all blinks, given that the film's blink at `film_time` [s] is the log's at `log_time` [s].

    Return each film blink's index in the log (-1: none) and the clock; None if the blinks do not fit. frame: interval
    between frames [s].
    """
    misfit = film[:, np.newaxis] - log - (film_time - log_time)
    allowed = frame + MAX_DRIFT * np.abs(log - log_time)
    nearest = np.argmin(np.abs(misfit), axis=1)
    in_film = np.flatnonzero(np.abs(misfit[np.arange(len(film)), nearest]) < allowed[nearest])
    in_log = nearest[in_film]
    if len(set(in_log.tolist())) < len(in_log):
        return None
    middle, sd = float(log[in_log].mean()), frame / math.sqrt(12)
    since_middle, lag = log[in_log] - middle, film[in_film] - log[in_log]
    information = float((since_middle**2).sum()) + (sd / USUAL_DRIFT) ** 2
    drift = float((since_middle * (lag - lag.mean())).sum()) / information
    residual = float(np.sqrt(((lag - lag.mean() - drift * since_middle) ** 2).mean()))
    if residual > MAX_RMS * frame:
        return None
    partner = [-1] * len(film)
    for k, j in zip(in_film.tolist(), in_log.tolist(), strict=True):
        partner[k] = j
    count = len(in_film)
    return tuple(partner), Clock(
        float(lag.mean()), middle, drift, sd / math.sqrt(count), sd / math.sqrt(information), residual, count
    )
