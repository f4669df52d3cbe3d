"""Tracks as they come from other programs, changed as they are in real life: each is right, refused, or told.

A track that is read with other times or angles than before the change, without a sentence on it, is a fault.
"""

import functools
import random
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hypertuna.actuation.new import first_robot
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.trials.chain import chain_of
from hypertuna.trials.marker_import import ChainOptions, fit_marker_run
from hypertuna.trials.marker_places import equal_spacing
from hypertuna.trials.marker_run import MarkerRun
from mutations.cases import Reaction
from mutations.damage import FACTORS, of_structure, of_table, of_text
from mutations.judge import CONTROL, LONGEST_ERROR
from tracked_files import FILES, FRAMES, MISSING, NAMES, RATE, TrackedFile

ALIKE = 0.4  # frames: times that are the same
NEAR = np.radians(4)  # angles that are the same
FAR = 2e-3  # m: markers that are elsewhere
MOST = 0.05  # of the frames may differ: one damaged number changes one frame
ROWS_ONLY = "each row counts as the next frame"  # said of every file of a form without a clock
Rows = list[list[str]]
Change = Callable[[bytes, random.Random], bytes]


@functools.cache
def robot() -> Robot:
    """Return a robot of three links."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "three.toml"
        path.write_text(first_robot("three", lengths=(0.1, 0.1, 0.1), mass=0.4, joints=("J1", "J2")))
        return load(path)


@functools.cache
def swim() -> np.ndarray:
    """Return markers (frames, markers, 2) [m] on the robot that swims to -x, with 0.3 mm of noise; one is missing."""
    beat = 4 * np.pi * np.array(FRAMES) / RATE
    z = np.column_stack([
        1 - 0.2 * np.array(FRAMES) / RATE, 0.005 * np.sin(beat) - 0.5, 0.05 * np.sin(beat - 1),
        np.radians(12) * np.sin(beat), np.radians(18) * np.sin(beat - 0.9),
    ])  # fmt: skip
    places = equal_spacing(robot(), NAMES)
    place, _ = chain_of(robot(), places.link, places.along, places.across)(z)
    place = np.round(place + 3e-4 * np.random.default_rng(0).standard_normal(place.shape), 5)
    place[MISSING] = np.nan
    return np.asarray(place)


@functools.cache
def whole(file: TrackedFile) -> tuple[bytes, MarkerRun]:
    """Return the whole file, and what is read from it."""
    with tempfile.TemporaryDirectory() as folder:
        path = file.write(Path(folder), swim())
        return path.read_bytes(), fit_marker_run(robot(), path, ChainOptions(), **file.options)


def judged(seed: int) -> Reaction:
    """Change a track by a seed, read it, and judge what comes of it."""
    chance = random.Random(f"track {seed}")
    return reaction(chance.choice(CHANGES), chance)


def reaction(change: Change, chance: random.Random) -> Reaction:
    """Change a track, read it, and judge what comes of it."""
    file = chance.choice(FILES)
    content, before = whole(file)
    begin, problem, accepted = time.process_time(), "", False
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(action="error"):
        path = Path(folder) / f"swim{file.suffix}"
        path.write_bytes(change(content, chance))
        try:
            run = fit_marker_run(robot(), path, ChainOptions(), **file.options)
            refusal = run.refusal()
            if refusal is not None:
                raise refusal
            accepted = True
            new = [text for text in run.warnings if text not in before.warnings]
            problem = "" if new or ROWS_ONLY in " ".join(run.warnings) else silent(run, before)
        except InputError as error:
            if len(str(error)) > LONGEST_ERROR or CONTROL.search(str(error)):
                problem = "a sentence that is too long, or has a control character"
        except Exception as error:
            problem = f"{type(error).__name__}: {error}"
    told = (f"{file.name}, {change.__name__}: {problem}",) if problem else ()
    return Reaction(told, accepted, time.process_time() - begin)


def silent(run: MarkerRun, before: MarkerRun) -> str:
    """Return in what a run differs from that of the whole file, or nothing.

    A clock of another rate or begin is a clock like any other, and a mirrored axis an axis: nothing in a file says that
    it is wrong.
    """
    names, known = ([name.strip().lower() for name in one.places.names] for one in (run, before))
    both = [(names.index(name), m) for m, name in enumerate(known) if name in names]
    both = both if len(both) > 2 else list(zip(range(len(names)), range(len(known)), strict=False))
    seen = np.flatnonzero((before.markers.weight > 0).any(axis=1))
    used = np.concatenate(run.stretches)
    place, was_there = (
        run.markers.place[used][:, [k for k, _ in both]],
        before.markers.place[seen][:, [m for _, m in both]],
    )
    with warnings.catch_warnings(action="ignore"):  # of two frames without a common marker
        middles = [
            np.nanmedian(np.linalg.norm(place[:, np.newaxis] * axes - was_there, axis=3), axis=2)
            for axes in ([1, 1], [-1, 1], [1, -1])
        ]
    middle = min(middles, key=lambda one: float(np.median(np.nanmin(one, axis=1))))
    own = np.nanargmin(middle, axis=1)
    if np.mean(middle[np.arange(len(used)), own] > FAR) > MOST:
        return "markers elsewhere"
    was, now = before.markers.time[seen[own]], run.markers.time[used]
    rate, start = np.polyfit(was, now, 1)
    if np.mean(np.abs(now - start - rate * was) * RATE > ALIKE * rate) > MOST:
        return f"other times, by up to {np.abs(now - was).max():.3f} s"
    side = 1 if middle is middles[0] else -1
    off = np.abs(side * run.fit.angle[used] - before.fit.angle[seen[own]]).max(axis=1)
    if np.mean(off > NEAR) > MOST:
        return f"other angles, by up to {np.degrees(off.max()):.0f} deg"
    return ""


def _cells(change: Callable[[Rows, random.Random], Rows]) -> Change:
    """Return a change of the cells of a table."""

    @functools.wraps(change)
    def changed(content: bytes, chance: random.Random) -> bytes:
        encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8"
        lines = content.decode(encoding).splitlines()
        mark = max(";\t,", key=lines[-1].count)
        rows = change([line.split(mark) for line in lines], chance)
        return "\n".join([*map(mark.join, rows), ""]).encode(encoding)

    return changed


def _first(rows: Rows) -> int:
    """Return the first row of numbers."""
    return next((k for k, row in enumerate(rows) if len(row) > 3 and sum(map(_number, row)) > len(row) / 2), 0)


def _value(cell: str) -> float:
    return float(cell.replace(",", "."))


def _number(cell: str) -> bool:
    try:
        _value(cell)
    except ValueError:
        return False
    return True


@_cells
def lost_rows(rows: Rows, chance: random.Random) -> Rows:
    """Lose rows at random, or a stretch of them."""
    first, part = _first(rows), chance.choice((0.02, 0.2, 0.5))
    if chance.random() < 0.5:
        at = chance.randrange(first, len(rows))
        return rows[:at] + rows[at + chance.choice((1, 3, 8)) :]
    return rows[:first] + [row for row in rows[first:] if chance.random() > part]


@_cells
def moved_rows(rows: Rows, chance: random.Random) -> Rows:
    """Shuffle rows, sort them as text, double one, or begin again."""
    first = _first(rows)
    body = rows[first:]
    kind = chance.randrange(4)
    if kind == 0:
        chance.shuffle(body)
    elif kind == 1:
        body.sort(key=lambda row: row[0])
    elif kind == 2:
        body.insert(chance.randrange(len(body)), chance.choice(body))
    else:
        body += body[: chance.choice((1, 5, 20))]
    return rows[:first] + body


@_cells
def moved_columns(rows: Rows, chance: random.Random) -> Rows:
    """Put columns in another order: as text, from the end, or two of them."""
    wide = max(map(len, rows))
    order = list(range(wide))
    kind = chance.randrange(3)
    if kind == 0:
        head = next((row for row in rows if len(row) == wide), rows[0])
        order.sort(key=lambda k: head[k])
    elif kind == 1:
        order.reverse()
    else:
        a, b = chance.randrange(wide), chance.randrange(wide)
        order[a], order[b] = b, a
    return [[row[k] for k in order] if len(row) == wide else row for row in rows]


@_cells
def numbers_of_frames(rows: Rows, chance: random.Random) -> Rows:
    """Write the first column in another way."""
    form = chance.choice(("{:.1f}", "{:.4e}", "img{:04.0f}.png", "frame_{:.0f}", "{:.0f} ", "{:06.0f}", "{:.3g}"))
    first = _first(rows)
    return rows[:first] + [[form.format(_value(r[0])), *r[1:]] if _number(r[0]) else r for r in rows[first:]]


@_cells
def lost_cells(rows: Rows, chance: random.Random) -> Rows:
    """Empty cells at random, or a whole column."""
    first, blank = _first(rows), chance.choice(("", "nan", "NaN", "-", "NA"))
    if chance.random() < 0.3:
        at = chance.randrange(len(rows[-1]))
        return rows[:first] + [[blank if k == at else c for k, c in enumerate(row)] for row in rows[first:]]
    return rows[:first] + [[blank if chance.random() < 0.03 else cell for cell in row] for row in rows[first:]]


@_cells
def other_scale(rows: Rows, chance: random.Random) -> Rows:
    """Multiply the numbers of a column, or of all but the first."""
    first, factor = _first(rows), chance.choice([factor for factor in FACTORS if factor > 0])
    at = chance.randrange(len(rows[-1])) if chance.random() < 0.6 else None

    def scaled(k: int, cell: str) -> str:
        own = k == at if at is not None else k > 0
        return f"{_value(cell) * factor:g}" if own and _number(cell) else cell

    return rows[:first] + [[scaled(k, cell) for k, cell in enumerate(row)] for row in rows[first:]]


@_cells
def other_names(rows: Rows, chance: random.Random) -> Rows:
    """Change the names of columns."""
    kind = chance.randrange(5)
    change: Callable[[str], str] = (
        str.upper,
        str.title,
        lambda text: f" {text} ",
        lambda text: text.replace("_", " ").replace(".", "_"),
        lambda text: chance.choice(("t", "time", "frame", "timestamp", "index")) if chance.random() < 0.1 else text,
    )[kind]
    first = _first(rows)
    return [[change(cell) for cell in row] for row in rows[:first]] + rows[first:]


@_cells
def one_more_column(rows: Rows, chance: random.Random) -> Rows:
    """Put a column before the others: of rows, of constants, of a clock that runs otherwise."""
    first = _first(rows)
    name = chance.choice(("", "index", "time", "frame", "timestamp", "Unnamed: 0", "n"))
    begin, step = chance.choice(((0, 1), (1, 1), (0, 2), (7, 0), (0, 1 / 60), (0, 16.7)))
    new = [f"{begin + step * k:.6g}" for k in range(len(rows) - first)]
    heads = [[*(("" if k < first - 1 else name,) if first else ()), *row] for k, row in enumerate(rows[:first])]
    return heads + [[cell, *row] for cell, row in zip(new, rows[first:], strict=True)]


CHANGES = (
    *(lost_rows, moved_rows, moved_columns, numbers_of_frames, lost_cells, other_scale, other_names, one_more_column),
    *(of_table, of_text, of_structure),
)
