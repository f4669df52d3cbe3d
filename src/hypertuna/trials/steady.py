"""Steady runs: measured speed, cost of transport and bends of hinges of gaits, read from CSV files."""

import math
from collections.abc import Callable, Mapping, Sized
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from hypertuna.description.robot import Robot
from hypertuna.display import Displayed, Tabular
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.door import RUNS
from hypertuna.io.tables import Table, conversion, table_of
from hypertuna.ranges import POSITIVE, POSITIVE_WHOLE, Range
from hypertuna.swimming.gait import KINDS, NEEDED, Gait
from hypertuna.swimming.yielding import bend_name

R = TypeVar("R", bound=Any)  # a type of runs, which have a `name`

# By attribute of `SteadyRun`: name of its column. Columns of angles are named by joint group.
COLUMNS = {
    "name": "run",
    "frequency": "frequency_hz",
    "speed": "speed_m_s",
    "speed_sd": "speed_sd_m_s",
    "cost_of_transport": "cost_of_transport_j_per_kg_m",
    "cost_of_transport_sd": "cost_of_transport_sd_j_per_kg_m",
    "repeats": "repeats",
}
MEASURED = ("speed", "cost_of_transport")  # attributes that are measured quantities
# Columns in other units, with their attributes: speeds in body lengths; powers, which are divided by mass and speed.
LENGTHS = {"speed_bl_s": "speed", "speed_sd_bl_s": "speed_sd"}
POWERS = {"power_w": "cost_of_transport", "power_sd_w": "cost_of_transport_sd"}
SPEED = Range(min=-100, max=100, unit="m/s")  # measured speeds
SIZE = Range(min=1e-9, max=1e9)  # costs of transport and standard deviations [SI]
BENDS = {  # measured quantities of a hinge, named as in the settled beat, and their ranges
    "bend_amplitude": Range(above=0, max=180, unit="deg"),
    "bend_lag": Range(min=-360, max=360, unit="deg"),
}
MAX_DIGITS = 9  # largest number of digits in a number of repeats


@dataclass(frozen=True)
class MeasuredBend:
    """Measured swing of a hinge: amplitude and lag of its angle's part at the beat's frequency.

    Parameters
    ----------
    bend_amplitude : float, optional
        Mean of the repeats [rad], greater than 0.
    bend_amplitude_sd : float, optional
        Standard deviation of a single repeat [rad].
    bend_lag : float, optional
        Lag behind the clock of the first joint group, mean of the repeats [rad].
    bend_lag_sd : float, optional
        Standard deviation of a single repeat [rad].
    """

    bend_amplitude: float | None = None
    bend_amplitude_sd: float | None = None
    bend_lag: float | None = None
    bend_lag_sd: float | None = None

    def __post_init__(self) -> None:
        for key, limits in BENDS.items():
            value, sd = (x if x is None else math.degrees(x) for x in (getattr(self, key), getattr(self, f"{key}_sd")))
            _check(key, value, sd, (limits,))


@dataclass(frozen=True)
class SteadyRun(Displayed, Tabular):
    """Measured speed, cost of transport or bends of hinges of a settled gait, at least one of them."""

    name: str
    gait: Gait  # as commanded
    speed: float | None = None  # mean of the repeats along their mean path [m/s], as `Swim.speed`
    speed_sd: float | None = None  # standard deviation of a single repeat [m/s]; the mean's is this / sqrt(repeats)
    cost_of_transport: float | None = None  # mean of the repeats [J/(kg m)]
    cost_of_transport_sd: float | None = None  # standard deviation of a single repeat [J/(kg m)]
    repeats: int = 1  # number of swims that the values are means of
    file: str = ""  # file and line of the run
    line: int = 0
    bends: tuple[MeasuredBend, ...] = ()  # of each hinge, head to tail; empty if none was measured

    def __post_init__(self) -> None:
        bent = [value for bend in self.bends for value in (bend.bend_amplitude, bend.bend_lag)]
        if all(value is None for value in (self.speed, self.cost_of_transport, *bent)):
            fix = "fill in at least one of them, or remove the row of a run that is not made yet"
            raise InputError("must be given, or cost_of_transport, or the bend of a hinge", key="speed", fix=fix)
        for key in MEASURED:
            limits = (SPEED,) if key == "speed" else (POSITIVE, SIZE)
            _check(key, getattr(self, key), getattr(self, f"{key}_sd"), limits)
        POSITIVE_WHOLE.check(self.repeats, "repeats", "give the number of swims that the run is the mean of")

    def measured(self) -> dict[str, tuple[str, float, float | None]]:
        """Return what was measured, by name in a settled beat.

        Returns
        -------
        dict of tuple
            Quantity, mean and standard deviation [SI].
        """
        sources: list[tuple[Any, str, str]] = [(self, name, name) for name in MEASURED]
        sources += [(b, name, bend_name(self.bends, name, d)) for d, b in enumerate(self.bends) for name in BENDS]
        found = ((name, key, getattr(of, key), getattr(of, f"{key}_sd")) for of, key, name in sources)
        return {name: (key, value, sd) for name, key, value, sd in found if value is not None}


def _check(key: str, value: float | None, sd: float | None, ranges: tuple[Range, ...]) -> None:
    """Check a measured value and its standard deviation, each of which may be missing."""
    for name, number, limits in ((key, value, ranges), (f"{key}_sd", sd, (POSITIVE, SIZE))):
        for one in limits if number is not None else ():
            one.check(number, name, "leave it out if it is unknown")
    if sd is not None and value is None:
        raise InputError(f"needs {key}, too", key=f"{key}_sd", fix=f"give {key}, or leave this out")


def bend_columns(hinges: Sized) -> dict[str, str]:
    """Return the columns of measured bends of hinges by key: ``bend_lag_sd[1]`` of the second hinge."""
    keys = [(d, key, sd) for d in range(len(hinges)) for key in BENDS for sd in ("", "_sd")]
    return {f"{key}{sd}[{d}]": f"{bend_name(hinges, key, d)}{sd}_deg" for d, key, sd in keys}


def measured_columns(run: SteadyRun) -> dict[str, float | None]:
    """Return what was measured of a run by column of its file, in the unit of the column; None if it is missing."""
    numbers = {COLUMNS[key]: getattr(run, key) for name in MEASURED for key in (name, f"{name}_sd")}
    for key, column in bend_columns(run.bends).items():
        name, _, d = key.removesuffix("]").partition("[")
        value = getattr(run.bends[int(d)], name)
        numbers[column] = None if value is None else math.degrees(value)
    return numbers


def read_steady(path: str | Path | Table, robot: Robot) -> tuple[SteadyRun, ...]:
    """Read steady runs from a CSV file: one row per gait; docs/trials.md lists the columns."""
    table = table_of(path, RUNS)
    if {"time_s", "time", "t"} & {*table.head}:
        fix = (
            "tracks of head or markers belong in a manifest, `[[recordings]]` (trials import markers or poses makes "
            "one). One tracked point gives only a speed: measure it, and write a row of a table of steady runs"
        )
        raise InputError("has a column of time, so it is not a table of steady runs", file=table.file, fix=fix)
    bends = bend_columns(robot.hinges)
    known = COLUMNS | bends
    keys = gait_keys(table, robot, known, LENGTHS | POWERS)
    if not {*MEASURED, *bends} & set(keys):
        either = " or ".join([*(COLUMNS[key] for key in MEASURED), *list(bends.values())[::2]])
        raise InputError("must be a column", file=table.file, key=either, value="missing", fix="add what was measured")
    return tuple(
        table.parse(unique(lambda line, cells: _run(cells, robot, table.file, line, set(table.head))), keys, known)
    )


def unique(make: Callable[[int, dict[str, str]], R]) -> Callable[[int, dict[str, str]], R]:
    """Wrap `make`, which makes a run from a line and its cells, so that it raises an error for a repeated name."""
    lines: dict[str, int] = {}

    def run(line: int, cells: dict[str, str]) -> R:
        new = make(line, cells)
        if new.name in lines:
            value, fix = f"{shown(new.name)}, as in line {lines[new.name]}", "give each run its own name"
            raise InputError("must be unique", key="name", value=value, fix=fix)
        lines[new.name] = line
        return new

    return run


def gait_keys(
    table: Table, robot: Robot, own: Mapping[str, str], others: Mapping[str, str] = MappingProxyType({})
) -> list[str]:
    """Return for each column its attribute of a run or gait; check that the columns are complete and unique.

    own: columns by attribute, except angles; others: attributes by column. Columns of angles are KIND_GROUP_deg.
    GROUP is the name of a joint group, or its number from 1, counted from the head, if no group has that name.
    """
    names = [group.name for group in robot.joints]
    rule = f"in KIND_GROUP_deg, GROUP is a joint group of {robot.name} by name or number ({', '.join(names)})"
    rule += "; bends of hinges are columns bend_amplitude_deg and bend_lag_deg of steady runs" * bool(robot.hinges)
    groups = {str(g + 1): g for g in range(len(names))} | {name: g for g, name in enumerate(names)}
    angles = {f"{kind}_{name}_deg": f"{kind}[{g}]" for kind in KINDS for name, g in groups.items()}
    required = {f"{kind}[{g}]": f"{kind}_{name}_deg" for kind in NEEDED for g, name in enumerate(names)}
    del required["phase[0]"]  # 0 by definition
    explained: set[str] = set()
    return table.keys(
        {column: key for key, column in own.items()} | dict(others) | angles,
        {"frequency": own["frequency"]} | required,
        fix=f"add it; {rule}",
        hint=lambda column: (
            _bend_hint(column, robot, own)
            or _hint(column, f"{rule}; choose the robot that swam with --robot: ", angles, explained)
        ),
    )


def _bend_hint(column: str, robot: Robot, own: Mapping[str, str]) -> str:
    """Return advice on an unknown column of the measured bend of a hinge; "" for other columns."""
    if not (column.startswith("bend_") or "hinge" in column):
        return ""
    bends = [name for name in own.values() if name.startswith("bend_")]
    if bends:
        of_unit = next((name for name in bends if conversion(column, name)), "")
        return f"did you mean {of_unit}?" if of_unit else f"measured bends of the hinges are {', '.join(bends)}"
    why = "only steady runs have bends of hinges" if robot.hinges else f"{robot.name} has no hinge"
    return f"{why}: leave it out{'' if robot.hinges else ', or choose the robot that swam with --robot'}"


def _hint(column: str, rule: str, angles: Mapping[str, str], explained: set[str]) -> str:
    """Return advice on an unknown column of angles, the first time with the rule for names; "" for other columns."""
    if not column.startswith(KINDS):
        return ""
    # for a phase, do not suggest the first joint group's, which is 0 by definition
    column_names = {key: name for name, key in angles.items()}  # names of groups come after their numbers
    names = [name for key, name in column_names.items() if not (column.startswith("phase") and key == "phase[0]")]
    text = f"{'' if rule in explained else rule}{did_you_mean(column, names or angles)}"
    explained.add(rule)
    return text


def _run(cells: dict[str, str], robot: Robot, file: str, line: int, columns: set[str]) -> SteadyRun:
    """Return the steady run in a row, from its cells by attribute."""
    gait = gait_of(cells, robot)
    measured: dict[str, Any] = {
        key: number(cells[key], key) for key in COLUMNS if key.startswith(MEASURED) and cells.get(key)
    }
    for column, key in LENGTHS.items():
        if column in columns and key in measured:
            measured[key] *= robot.body.length
    for column, key in POWERS.items():
        if column in columns and key in measured:
            if not measured.get("speed"):
                raise InputError("needs a speed other than 0, too", key=key, fix="give the speed, or leave this out")
            measured[key] /= robot.body.mass * abs(measured["speed"])
    measured["bends"] = _bends(cells, robot)
    return SteadyRun(name_of(cells, file, line), gait, **(measured | origin(cells, file, line)))


def _bends(cells: Mapping[str, str], robot: Robot) -> tuple[MeasuredBend, ...]:
    """Return the measured bends of the hinges in a row; () if it has none."""
    given = {key: math.radians(number(cells[key], key)) for key in bend_columns(robot.hinges) if cells.get(key)}
    if not given:
        return ()
    each: list[dict[str, float]] = [{} for _ in robot.hinges]
    for key, value in given.items():
        name, _, d = key.removesuffix("]").partition("[")
        each[int(d)][name] = value
    bends = []
    for hinge, one in enumerate(each):
        try:
            bends.append(MeasuredBend(**one))
        except InputError as error:
            raise InputError(error.rule, key=f"{error.key}[{hinge}]", value=error.value, fix=error.fix) from None
    return tuple(bends)


def gait_of(cells: Mapping[str, str], robot: Robot) -> Gait:
    """Return the gait in a row, from its cells by key such as "amplitude[0]"."""
    groups = range(len(robot.joints))
    angles = {kind: [number(cells.get(f"{kind}[{g}]", "0"), f"{kind}[{g}]") for g in groups] for kind in KINDS}
    return Gait.from_degrees(frequency=number(cells["frequency"], "frequency"), **angles)


def name_of(cells: Mapping[str, str], file: str, line: int) -> str:
    """Return the name of the run in a row: its cell, or else FILE:LINE."""
    return cells.get("name") or f"{Path(file).name}:{line}"


def origin(cells: Mapping[str, str], file: str, line: int) -> dict[str, Any]:
    """Return the fields repeats, file and line of the run in a row."""
    repeats = cells.get("repeats") or "1"
    if not repeats.isdecimal() or len(repeats) > MAX_DIGITS:
        raise InputError("must be a whole number", key="repeats", value=shown(repeats), fix="write digits only")
    return {"repeats": int(repeats), "file": file, "line": line}


def number(text: str, key: str) -> float:
    """Parse the number in a cell; its range is checked by the gait or run made from it."""
    try:
        return float(text)
    except ValueError:
        fix = "give a number" if text else "fill the cell, or remove the line"
        raise InputError("must be a number", key=key, value=shown(text) if text else "empty", fix=fix) from None
