"""Steady runs: measured speed and cost of transport of gaits, read from CSV files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import check_width, read_rows
from hypertuna.swimming.gait import Gait

# Columns of a file by attribute of `SteadyRun`; columns of angles are named by joint group.
COLUMNS = {
    "name": "run",
    "frequency": "frequency_hz",
    "speed": "speed_m_s",
    "speed_sd": "speed_sd_m_s",
    "cost_of_transport": "cost_of_transport_j_per_kg_m",
    "cost_of_transport_sd": "cost_of_transport_sd_j_per_kg_m",
    "repeats": "repeats",
}
ANGLES = ("amplitude", "phase", "bias")
MAX_NAMED = 5  # bad rows in an error
MAX_DIGITS = 9  # of a number of repeats


@dataclass(frozen=True)
class SteadyRun:
    """Measured speed or cost of transport of a settled gait, or both."""

    name: str
    gait: Gait  # as commanded
    speed: float | None = None  # mean of the repeats along their mean path [m/s], as `Swim.speed`
    speed_sd: float | None = None  # of a single repeat [m/s]; that of the mean is smaller by sqrt(repeats)
    cost_of_transport: float | None = None  # mean of the repeats [J/(kg m)]
    cost_of_transport_sd: float | None = None  # of a single repeat [J/(kg m)]
    repeats: int = 1  # number of swims that the values are means of
    file: str = ""  # file and line of the run
    line: int = 0

    def __post_init__(self) -> None:
        if self.speed is None and self.cost_of_transport is None:
            fix = "give at least one of the two"
            raise InputError("must be given, or cost_of_transport", key="speed", fix=fix)
        _check_number(self.speed, "speed", positive=False)
        _check_number(self.cost_of_transport, "cost_of_transport", positive=True)
        for key in ("speed", "cost_of_transport"):
            sd = getattr(self, f"{key}_sd")
            _check_number(sd, f"{key}_sd", positive=True)
            if sd is not None and getattr(self, key) is None:
                raise InputError(f"must have {key} beside it", key=f"{key}_sd", fix=f"give {key}, or leave this out")
        if self.repeats < 1:
            fix = "give the number of swims that the run is the mean of"
            raise InputError("must be 1 or more", key="repeats", value=str(self.repeats), fix=fix)


def read_steady(path: str | Path, robot: Robot) -> tuple[SteadyRun, ...]:
    """Read steady runs from a CSV file: one row per gait; docs/trials.md lists the columns."""
    file = str(path)
    (line, head), *rows = read_rows(path)
    keys = _keys(head, robot, file, line)
    runs: dict[str, SteadyRun] = {}
    bad: dict[int, InputError] = {}
    for line, row in rows:
        try:
            check_width(row, head, file=file, line=line)
            run = _run(dict(zip(keys, row, strict=True)), robot, file, line)
            if run.name in runs:
                value, fix = f"{shown(run.name)}, as in line {runs[run.name].line}", "give each run its own name"
                raise InputError("must be unique", key="name", value=value, fix=fix)
            runs[run.name] = run
        except InputError as error:
            bad[line] = _placed(error, file, line, dict(zip(keys, head, strict=True)))
    if bad:
        raise _together(bad, file)
    return tuple(runs.values())


def _angle_columns(robot: Robot) -> dict[str, str]:
    """Return keys such as amplitude[1] by the names of their columns, KIND_GROUP_deg.

    GROUP is the name of a joint group, or its number from 1, counted from the head, if no group has that name.
    """
    numbers = {str(g + 1): g for g in range(len(robot.joints))}
    names = {group.name: g for g, group in enumerate(robot.joints)}
    return {f"{kind}_{name}_deg": f"{kind}[{g}]" for kind in ANGLES for name, g in (numbers | names).items()}


def _keys(head: Sequence[str], robot: Robot, file: str, line: int) -> list[str]:
    """Return the attribute of a run or of its gait in each column; check that they are complete and unique."""
    groups = [group.name for group in robot.joints]
    rule = f"in KIND_GROUP_deg, GROUP is a joint group of {robot.name} by name or number ({', '.join(groups)})"
    known = {column: key for key, column in COLUMNS.items()} | _angle_columns(robot)
    keys: list[str] = []
    for column in head:
        if column not in known:
            fix = did_you_mean(column, [name for name, key in known.items() if name not in head and key not in keys])
            hint = f"{rule}: " if column.startswith(ANGLES) else ""
            raise InputError("is not a known column", file=file, key=f"line {line}, {column}", fix=hint + fix)
        if known[column] in keys:
            twin = head[keys.index(known[column])]
            raise InputError("must appear only once", file=file, key=f"line {line}, {column}", value=f"{twin}, too")
        keys.append(known[column])
    required = {f"{kind}[{g}]": f"{kind}_{name}_deg" for kind in ANGLES[:2] for g, name in enumerate(groups)}
    del required["phase[0]"]  # 0 by definition
    for key, column in ({"frequency": COLUMNS["frequency"]} | required).items():
        if key not in keys:
            raise InputError("must be a column", file=file, key=column, value="missing", fix=f"add it; {rule}")
    if not {"speed", "cost_of_transport"} & set(keys):
        either = f"{COLUMNS['speed']} or {COLUMNS['cost_of_transport']}"
        raise InputError("must be a column", file=file, key=either, value="missing", fix="add what was measured")
    return keys


def _run(cells: Mapping[str, str], robot: Robot, file: str, line: int) -> SteadyRun:
    """Return the run of the cells of a row."""
    groups = range(len(robot.joints))
    angles = {kind: [_number(cells.get(f"{kind}[{g}]", "0"), f"{kind}[{g}]") for g in groups] for kind in ANGLES}
    gait = Gait.from_degrees(frequency=_number(cells["frequency"], "frequency"), **angles)
    measured = {
        key: _number(cells[key], key) for key in COLUMNS if key.startswith(("speed", "cost")) and cells.get(key)
    }
    repeats = cells.get("repeats") or "1"
    if not repeats.isdecimal() or len(repeats) > MAX_DIGITS:
        raise InputError("must be a whole number", key="repeats", value=shown(repeats), fix="write digits only")
    name = cells.get("name") or f"{Path(file).name}:{line}"
    return SteadyRun(name, gait, **measured, repeats=int(repeats), file=file, line=line)


def _number(text: str, key: str) -> float:
    """Return a number; the gait and the run check its value."""
    try:
        return float(text)
    except ValueError:
        fix = "give a number" if text else "fill the cell, or remove the line"
        raise InputError("must be a number", key=key, value=shown(text) if text else "empty", fix=fix) from None


def _check_number(value: float | None, key: str, *, positive: bool) -> None:
    """Check an optional number."""
    if value is not None and not math.isfinite(value):
        raise InputError("must be a finite number", key=key, value=f"{value}", fix="leave it out if it is unknown")
    if value is not None and positive and value <= 0:
        raise InputError("must be greater than 0", key=key, value=f"{value:g}", fix="leave it out if it is unknown")


def _placed(error: InputError, file: str, line: int, columns: Mapping[str, str]) -> InputError:
    """Return the error of an attribute as that of its cell."""
    key = error.key or ""
    column = columns.get(key) or COLUMNS.get(key)
    place = f"line {line}, {column}" if column else f"line {line}"
    return InputError(error.rule, file=file, key=place, value=error.value, fix=error.fix)


def _together(bad: Mapping[int, InputError], file: str) -> InputError:
    """Return one error for all bad rows, with the first ones in full."""
    errors = list(bad.values())
    if len(errors) == 1:
        return errors[0]
    texts = [
        f"{error.key} {error.rule}" + f", but is {error.value}" * bool(error.value) for error in errors[:MAX_NAMED]
    ]
    more = f"; and {len(errors) - MAX_NAMED} more" if len(errors) > MAX_NAMED else ""
    return InputError(f"has {len(errors)} rows that cannot be used", file=file, fix="; ".join(texts) + more)
