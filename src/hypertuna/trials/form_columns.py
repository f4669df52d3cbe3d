"""Text forms of plain columns: a row for each frame (nose_x, nose_y, ...; Anipose), or for each frame and marker."""

import re
from itertools import zip_longest
from typing import Any

import numpy as np

from hypertuna.errors import InputError, shown
from hypertuna.io.door import CELLS
from hypertuna.io.tables import parse_float
from hypertuna.trials.form import (
    FIX,
    RATES,
    SECONDS,
    UNITS,
    WEIGHTS,
    Text,
    of_columns,
    one_point,
    plain,
    time_and_frame,
    unit_of,
)
from hypertuna.trials.form_clock import clock_columns
from hypertuna.trials.grid import FIRST_LINES, MISSING, Grid, Samples, is_number
from hypertuna.trials.points import Points, choose_individual, no_individuals

OTHERS = ("error", "ncams")  # of Anipose, without a use
UNSEEN = ("occluded", "missing", "lost", "invalid", "interpolated")  # flags of markers that were not seen
SCORES = (*WEIGHTS, "c")  # behind the name of a marker; OpenPose's tables have nose_c
AXIS = "|".join(("x", "y", "z", *SCORES, *OTHERS, *UNSEEN))
UNIT = r"(?:[_. (\[/]+(?P<unit>m|cm|mm|um|µm|in|inch|ft|px|pixels?)[)\]]?)?"
NAMED = re.compile(
    rf"(?P<name>.+)[_. :/|(\[-](?P<axis>{AXIS})[)\]]?(?:[_. -]?(?:pos|position|coord|coordinate))?{UNIT}", re.IGNORECASE
)
CAMEL = re.compile(rf"(?P<name>.*[a-z0-9])(?P<axis>[XYZ]){UNIT}")
NUMBERED = re.compile(rf"(?P<axis>x|y|z|p)[_. ]?(?P<name>.+?){UNIT}", re.IGNORECASE)
COORDINATE = re.compile(rf"(?:(?:pos|position|coords?)[_. ]?)?(?P<axis>x|y|z){UNIT}", re.IGNORECASE)
MARKER = re.compile("(body|key)?(part|point|joint)s?(name|id)?|(marker|node|landmark|label|feature)s?(name|id)?|name")
ANIMAL = re.compile("(individual|animal|track|instance|subject|object|particle|fish)s?(name|id|no|number)?|id")
TUPLE, PARTS = re.compile(r"\((?:'[^']*',? ?){2,5}\)"), re.compile("'([^']*)'")
NO_UNITS = ("", "-", "1", "#", "no", "nr", "frame", "frames")  # of a number of a frame
ANIPOSE = {"fnum", "m_00", "center_0"}


def _axes(head: list[str]) -> dict[str, tuple[int, str | None]]:
    """Return the column and the unit of each coordinate of a table with one point in each row."""
    matches = [(k, match) for k, name in enumerate(head) if (match := COORDINATE.fullmatch(name))]
    return {match["axis"].lower(): (k, match["unit"]) for k, match in reversed(matches)}


def _is_long(grid: Grid) -> bool:
    head = grid.cells(0)
    return {"x", "y"} <= _axes(head).keys() and any(MARKER.fullmatch(plain(name)) for name in head)


def _long(grid: Grid, individual: str | None) -> Points:
    """Read a table with a row for each frame and marker."""
    head = grid.rows[0][1]
    names = [plain(name) for name in head]
    samples = grid.below(1, head)
    coordinates = _axes(head)
    named = [k for k, name in enumerate(names) if name in WEIGHTS or MARKER.fullmatch(name)]
    named += [k for k, _ in coordinates.values()]
    samples.check_once(named)
    time, _, frame = time_and_frame(head)
    if time is None and frame is None:
        fix = "add a column frame or time_s"
        raise InputError("must say the frame of each row", file=grid.file, key="a row for each marker", fix=fix)
    if animals := [k for k, name in enumerate(names) if ANIMAL.fullmatch(name)]:
        animal = choose_individual(grid.file, samples.text(animals[0]), individual)
        samples = samples.only([k for k, name in enumerate(samples.text(animals[0])) if name == animal])
    marker = next(k for k, name in enumerate(names) if MARKER.fullmatch(name))
    label = samples.text(marker)
    markers = list(dict.fromkeys(label))
    clock, _ = clock_columns(samples, named)
    instants, row = np.unique(clock["frame"] if frame is not None else clock["time"], return_inverse=True)
    if not np.isfinite(instants).all():
        raise InputError("must say the frame of each row", file=grid.file, key=head[frame or time or 0], fix="fill it")
    if len(markers) * len(instants) > CELLS:
        rule, fix = "must not name a marker in each row", f"check the column {head[marker]}"
        raise InputError(rule, file=grid.file, value=f"{len(markers)} markers in {len(instants)} frames", fix=fix)
    order = {name: m for m, name in enumerate(markers)}
    column = np.array([order[name] for name in label])
    cells = row * len(markers) + column
    unique, first = np.unique(cells, return_index=True)
    if len(unique) < len(cells):
        repeat = int(np.setdiff1d(np.arange(len(cells)), first)[0])
        key, fix = f"{samples.where[repeat]}, marker {label[repeat]}", "give a row for each frame and marker of one run"
        raise InputError("must be there once", file=grid.file, key=key, value="there twice", fix=fix)
    axes = [coordinates[axis][0] for axis in "xyz" if axis in coordinates]
    place = np.full((len(instants), len(markers), len(axes)), np.nan)
    weight = np.full((len(instants), len(markers)), np.nan)
    place[row, column] = np.column_stack([samples.numbers(k) for k in axes])
    place[~np.isfinite(place).all(axis=2)] = np.nan
    if (score := next((k for k, name in enumerate(names) if name in WEIGHTS), None)) is not None:
        weight[row, column] = samples.numbers(score, words=True)
    if len(markers) < 2:
        raise InputError("must have at least two markers", file=grid.file, value=f"{len(markers)}", fix=FIX)
    _, line = np.unique(row, return_index=True)
    clock = {key: value[line] if isinstance(value, np.ndarray) else value for key, value in clock.items()}
    return Points(
        "rows of frames and markers", grid.file, tuple(markers), place, weight, samples.only(line.tolist()).where,
        **unit_of(grid.file, [unit for _, unit in coordinates.values()]), **clock,
    )  # fmt: skip


def _is_lone(grid: Grid) -> bool:
    """Whether each row has one point: x and y, without the name of a marker and without other coordinates."""
    for k in range(min(3, len(grid.rows))):  # below its name, as Tracker writes it
        head = grid.cells(k)
        if {"x", "y"} <= _axes(head).keys() and sum(bool(COORDINATE.fullmatch(name)) for name in head) < 4:
            others = {match["name"] for name in head if (match := NAMED.fullmatch(name) or NUMBERED.fullmatch(name))}
            return any(ANIMAL.fullmatch(plain(name)) for name in head) or not others - {*AXIS.split("|"), *SECONDS}
    return False


def _lone(grid: Grid, individual: str | None) -> Points:
    tracker = grid.comment.lower().startswith(("#mass", "#multi")) or grid.cells(0)[0].startswith("mass")
    form = "Tracker" if tracker else "a table of tracked objects"
    raise one_point(form, grid.file, "add a column marker, or nose_x, nose_y, ... in one row")


def read_plain(grid: Grid, individual: str | None) -> Points:
    """Read plain columns, such as nose_x, nose_y, nose_likelihood, or x1, y1, p1, or those of Anipose."""
    head = [_without_scorer(name) for name in grid.rows[0][1]]
    if sum(not np.isnan(parse_float(name.replace(",", "."))) for name in head) > len(head) / 2:
        fix = f"remove the # before them: {grid.comment[:60]}" if "x" in grid.comment.lower() else f"add it: {FIX}"
        raise InputError("has no line of names above its numbers", file=grid.file, fix=fix)
    grid = _with_units(grid)
    _check_names(grid)
    head = [_without_scorer(name) for name in grid.rows[0][1]]
    samples = _of_animal(grid.below(1, head), individual)
    time, _, frame = time_and_frame(head)
    markers, unit, ignored = _columns(samples, {time, frame})
    used = [k for axes in markers.values() for k in axes.values()]
    samples.check_once([k for k, name in enumerate(head) if name])
    if not markers:
        listed = shown(", ".join(ignored[:8]))
        rule, fix = "must have columns of at least two markers", f"{FIX}, with no unit or one of {', '.join(UNITS)}"
        raise InputError(rule, file=grid.file, value=f"without: its columns are {listed}", fix=fix)
    anipose = ANIPOSE & set(grid.cells(0)) and any("z" in axes for axes in markers.values())
    clock, notes = clock_columns(samples, used)
    taken = [*str(clock.get("time_name", "")).split(" and "), clock.get("frame_name")]
    return of_columns(
        "Anipose" if anipose else "plain columns",
        samples,
        {name: {a: k for a, k in axes.items() if a != "other"} for name, axes in markers.items()},
        words=True,
        **unit,
        notes=notes,
        ignored=() if anipose else tuple(name for name in ignored if name not in taken),
        **clock,
    )


def _without_scorer(name: str) -> str:
    """Return nose_x for a name such as ('scorer', 'nose', 'x'), which pandas writes of several lines of names."""
    return "_".join(PARTS.findall(name)[-2:]) if TUPLE.fullmatch(name) else name


def _with_units(grid: Grid) -> Grid:
    """Return a table whose names have the units of the line below them, if that holds units and nothing else."""
    units = [cell.strip("[]() ") for cell in grid.cells(1)]
    if not any(units) or not {*units} <= {*UNITS, *SECONDS, *NO_UNITS}:
        return grid
    (line, names), _, *rows = grid.rows
    pairs = zip_longest(names, [unit * (unit not in NO_UNITS) for unit in units], fillvalue="")
    stated = re.compile(rf".*[_. (\[/](?:{'|'.join({*UNITS, *SECONDS})})[)\]]?", re.IGNORECASE)
    head = [f"{name} ({unit})" if unit and not stated.fullmatch(name) else name for name, unit in pairs]
    return Grid(grid.file, [(line, head), *rows], grid.comments)


def _check_names(grid: Grid) -> None:
    """Check that the table begins with its line of names, below which are numbers."""
    top = [cells for _, cells in grid.rows[:FIRST_LINES]]
    wide = [k for k, cells in enumerate(top) if 2 * len(cells) >= max(map(len, top))]
    first = next((k for k in wide if k and _of_numbers(top[k][1:])), 1)
    if first == 1:
        return
    size = [(sum(bool(NAMED.fullmatch(name)) for name in cells), len(cells)) for cells in top]
    if size[first - 1] > size[0]:
        fix = f"remove the lines above line {grid.rows[first - 1][0]}, if that has the names"
        raise InputError("must begin with its line of names", file=grid.file, key=f"line {grid.rows[0][0]}", fix=fix)
    rule, fix = "must hold numbers, below one line of names", f"{FIX}, in one line, and remove what is no number"
    raise InputError(rule, file=grid.file, key=f"line {grid.rows[1][0]}", value=shown(", ".join(top[1])), fix=fix)


def _of_numbers(cells: list[str]) -> bool:
    """Return whether half of the cells that are filled in are numbers, or words for missing ones."""
    filled = [cell for cell in cells if cell]
    return 2 * sum(is_number(cell) or cell.lower() in MISSING for cell in filled) >= len(filled)


def _of_animal(samples: Samples, individual: str | None) -> Samples:
    """Return the rows of one animal, where a column names several; without such a column there is none to choose."""
    for k, name in enumerate(samples.head):
        animals = samples.text(k)
        if ANIMAL.fullmatch(plain(name)) and len(set(animals)) < len(animals):
            animal = choose_individual(samples.file, animals, individual)
            return samples.only([row for row, one in enumerate(animals) if one == animal])
    if individual is not None:
        raise no_individuals(samples.file, individual)
    return samples


def _columns(samples: Samples, taken: set[int | None]) -> tuple[dict[str, dict[str, int]], dict[str, Any], list[str]]:
    """Return each marker's columns by axis and weight, the unit in names as fields of `Points`, and unused names."""
    found: dict[str, dict[str, int]] = {}
    ignored, units = [], set()
    for k, name in enumerate(samples.head):
        # pandas calls the second of two columns x that stand there x.1
        bare = f"{name}.0" if name.lower() in ("x", "y", "z") and f"{name}.1" in samples.head else name
        match = NAMED.fullmatch(bare) or CAMEL.fullmatch(bare) or NUMBERED.fullmatch(bare)
        if k in taken:
            continue
        if match:
            axis = match["axis"].lower()
            found.setdefault(match["name"].rstrip(), {})[
                axis if axis in "xyz" else "weight" if axis in SCORES else "other"
            ] = k
            if axis in UNSEEN and any(text not in ("", "0", "0.0", "False", "false") for text in samples.text(k)):
                fix = f"write {match['name']}_visible, 1 minus it, or leave the coordinates of these frames empty"
                raise InputError("counts frames in which the marker was not seen", file=samples.file, key=name, fix=fix)
            if axis in OTHERS:
                ignored.append(name)
            if axis in "xyz":
                units.add((match["unit"] or "").lower())
        elif name and not ANIMAL.fullmatch(plain(name)) and plain(name) not in RATES:
            ignored.append(name)
    # a column such as "body" or "yaw" is no pair of coordinates
    incomplete = [name for name, axes in found.items() if not {"x", "y"} <= set(axes)]
    for name in incomplete:
        is_word = all(re.match(r"[xyzp][a-z]{2}", samples.head[k], re.IGNORECASE) for k in found[name].values())
        if not is_word and (len(incomplete) == len(found) or set(found[name]) & {"x", "y"}):
            axis = "y" if "x" in found[name] else "x"
            raise InputError(f"must have a column of {axis}", file=samples.file, key=f"marker {name}", fix=FIX)
        ignored += [samples.head[k] for k in found.pop(name).values()]
    return found, unit_of(samples.file, units), ignored


TEXTS = (
    Text("rows of frames and markers", _is_long, _long, individuals=True),
    Text("a table of tracked objects", _is_lone, _lone, individuals=True),
    Text("plain columns", lambda grid: True, read_plain, individuals=True),
)
