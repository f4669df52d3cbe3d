"""Tables of poses with quaternions, as simulators and motion capture write them: columns, units, clock."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.trials.clock import clock_of
from hypertuna.trials.form import unit_of
from hypertuna.trials.form_clock import clock_columns
from hypertuna.trials.grid import Samples, read_grid
from hypertuna.trials.points import Points

MARK = r"[_. /:]"  # between the words of a column's name
QUATERNION = re.compile(rf"(?:.*{MARK})?(?:q|quat|quaternion|orientation|rotation|rot){MARK}?([xyzw])", re.IGNORECASE)
PLACE = re.compile(
    rf"(?:(?:.*{MARK})?(?:p|pos|position|translation|t){MARK})?([xyz])(?:[_. (\[]+(m|cm|mm)[)\]]?)?", re.IGNORECASE
)
KEYS = ("x", "y", "z", "qx", "qy", "qz", "qw")
DEGREES, RADIANS = (
    re.compile(rf"(?:{words})[)\] ]*$", re.IGNORECASE) for words in ("deg(?:s|rees?)?|°", "rad(?:ian)?s?")
)
MOST = 0.9  # of the samples: single wrong angles of a sensor do not count
HALF_TURN, QUARTER_TURN = np.pi, np.pi / 2  # rad


@dataclass(frozen=True)
class PoseTable:
    """Poses of one body over time, and joint angles."""

    time: Array  # (rows,) [s] from the first row
    place: Array  # (rows, 3) [m]
    turn: Array  # (rows, 4): quaternions x, y, z, w
    angle: Array  # (rows, joints) [rad]
    notes: tuple[str, ...]


def pose_samples(path: str | Path) -> Samples:
    """Return the rows of a table below its line of names; commas, semicolons or tabs separate cells."""
    grid = read_grid(path)
    return grid.below(1, grid.rows[0][1])


def pose_table(samples: Samples, joints: Sequence[str], frame_rate: float | None) -> PoseTable:
    """Read the poses of a table, and the angles of the columns named `joints`; frame_rate: as of `clock_of`."""
    columns, lengths = _columns(samples)
    angles = [samples.head.index(name) for name in joints]
    samples.check_once(angles)
    clock, notes = clock_columns(samples, [*columns, *angles])
    if (time := clock.get("time")) is not None and (repeats := np.flatnonzero(np.diff(time) == 0) + 1).size:
        kept = np.setdiff1d(np.arange(len(time)), repeats).tolist()
        samples, notes = samples.only(kept), (*notes, f"{len(repeats)} rows at the time of another are left out")
        clock = {key: value[kept] if isinstance(value, np.ndarray) else value for key, value in clock.items()}
    values = np.column_stack([samples.numbers(k) for k in columns])
    unit = lengths["length_unit"] or 1.0
    no_weight = np.full((len(values), 1), np.nan)
    points = Points("poses", samples.file, ("body",), values[:, np.newaxis, :3], no_weight, samples.where, **clock)
    seconds, clock_notes = clock_of(points, frame_rate)
    angle = np.array([_radians(samples, k) for k in angles]).reshape(len(angles), len(values)).T
    if degrees := [name for name in joints if DEGREES.search(name)]:
        notes = (*notes, f"columns in deg: {', '.join(degrees)}")
    return PoseTable(seconds - seconds[0], unit * values[:, :3], values[:, 3:], angle, (*notes, *clock_notes))


def _columns(samples: Samples) -> tuple[list[int], dict[str, float | None]]:
    """Return the index of the column of each of `KEYS`, and the unit of the places as fields of `Points`."""
    found: dict[str, list[int]] = {}
    units: list[str | None] = []
    for k, name in enumerate(samples.head):
        if match := QUATERNION.fullmatch(name):
            found.setdefault(f"q{match[1].lower()}", []).append(k)
        elif match := PLACE.fullmatch(name):
            found.setdefault(match[1].lower(), []).append(k)
            units.append(match[2])
    if missing := [key for key in KEYS if key not in found]:
        rule = f"must have columns of time_s, {', '.join(KEYS)}"
        fix = "name them so; if it has yaw, write a manifest of the table by hand (see the page on trials)"
        raise InputError(rule, file=samples.file, value=f"without {', '.join(missing)}", fix=fix)
    for key, columns in found.items():
        if len(columns) > 1:
            value = ", ".join(samples.head[k] for k in columns)
            fix = "keep the columns of the measured poses of the head, and drop or rename the others"
            raise InputError("must be there once", file=samples.file, key=f"column {key}", value=value, fix=fix)
    return [found[key][0] for key in KEYS], unit_of(samples.file, units)


def _radians(samples: Samples, column: int) -> Array:
    """Return the angles [rad] of a column, whose name says their unit unless they are small."""
    name, angle = samples.head[column], samples.numbers(column)
    for k in np.flatnonzero(np.isnan(angle))[:1]:
        key, fix = f"{samples.where[int(k)]}, {name}", "give a number, or leave out the line"
        raise InputError("must be a number", file=samples.file, key=key, value="missing", fix=fix)
    if DEGREES.search(name):
        return np.radians(angle)
    size = float(np.quantile(np.abs(angle), MOST))
    stated = bool(RADIANS.search(name))
    if size > (HALF_TURN if stated else QUARTER_TURN):
        rule = "must bend by less than half a turn" if stated or size > HALF_TURN else "must say its unit in its name"
        fix = f"are they in deg? Then call it {RADIANS.sub('', name).rstrip('_ ([')}_deg" + ", else _rad" * (not stated)
        raise InputError(rule, file=samples.file, key=name, value=f"{size:.3g} rad", fix=fix)
    return angle
