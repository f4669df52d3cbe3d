"""Steady runs: measured speed and cost of transport of gaits, read from CSV files."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from hypertuna.description.robot import Robot
from hypertuna.display import Displayed, Tabular
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.door import RUNS
from hypertuna.io.tables import Table, read_table
from hypertuna.ranges import POSITIVE, POSITIVE_WHOLE, Range
from hypertuna.swimming.gait import KINDS, NEEDED, Gait

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
MEASURED = ("speed", "cost_of_transport")
# Columns of other quantities, by the attribute that they give: speeds in body lengths, and powers over mass and speed.
LENGTHS = {"speed_bl_s": "speed", "speed_sd_bl_s": "speed_sd"}
POWERS = {"power_w": "cost_of_transport", "power_sd_w": "cost_of_transport_sd"}
SPEED = Range(min=-100, max=100, unit="m/s")
SIZE = Range(min=1e-9, max=1e9)  # of costs of transport and standard deviations, in SI
MAX_DIGITS = 9  # of a number of repeats


@dataclass(frozen=True)
class SteadyRun(Displayed, Tabular):
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
        for key in MEASURED:
            value, sd = getattr(self, key), getattr(self, f"{key}_sd")
            for name, number in ((key, value), (f"{key}_sd", sd)):
                for limits in (SPEED,) if name == "speed" else (POSITIVE, SIZE):
                    if number is not None:
                        limits.check(number, name, "leave it out if it is unknown")
            if sd is not None and value is None:
                raise InputError(f"needs {key}, too", key=f"{key}_sd", fix=f"give {key}, or leave this out")
        POSITIVE_WHOLE.check(self.repeats, "repeats", "give the number of swims that the run is the mean of")


def read_steady(path: str | Path, robot: Robot) -> tuple[SteadyRun, ...]:
    """Read steady runs from a CSV file: one row per gait; docs/trials.md lists the columns."""
    table = read_table(path, RUNS)
    lines: dict[str, int] = {}

    def run(line: int, cells: dict[str, str]) -> SteadyRun:
        made = _run(cells, robot, table.file, line, set(table.head))
        if made.name in lines:
            value, fix = f"{shown(made.name)}, as in line {lines[made.name]}", "give each run its own name"
            raise InputError("must be unique", key="name", value=value, fix=fix)
        lines[made.name] = line
        return made

    return tuple(table.parse(run, _keys(table, robot), COLUMNS))


def _keys(table: Table, robot: Robot) -> list[str]:
    """Return the attribute of a run or of its gait in each column; check that they are complete and unique.

    Columns of angles are KIND_GROUP_deg. GROUP is the name of a joint group, or its number from 1, counted from the
    head, if no group has that name.
    """
    names = [group.name for group in robot.joints]
    rule = f"in KIND_GROUP_deg, GROUP is a joint group of {robot.name} by name or number ({', '.join(names)})"
    groups = {str(g + 1): g for g in range(len(names))} | {name: g for g, name in enumerate(names)}
    angles = {f"{kind}_{name}_deg": f"{kind}[{g}]" for kind in KINDS for name, g in groups.items()}
    required = {f"{kind}[{g}]": f"{kind}_{name}_deg" for kind in NEEDED for g, name in enumerate(names)}
    del required["phase[0]"]  # 0 by definition
    said: set[str] = set()
    if {"time_s", "time", "t"} & {*table.head}:
        fix = (
            "tracks of head or markers belong in a manifest, `[[recordings]]` (trials import markers makes one). One "
            "tracked point gives only a speed: measure it, and write a row of a table of steady runs"
        )
        raise InputError("has a column of time, so it is not a table of steady runs", file=table.file, fix=fix)
    keys = table.keys(
        {column: key for key, column in COLUMNS.items()} | LENGTHS | POWERS | angles,
        {"frequency": COLUMNS["frequency"]} | required,
        fix=f"add it; {rule}",
        hint=lambda column: _hint(column, f"{rule}; choose the robot that swam with --robot: ", angles, said),
    )
    if not set(MEASURED) & set(keys):
        either = " or ".join(COLUMNS[key] for key in MEASURED)
        raise InputError("must be a column", file=table.file, key=either, value="missing", fix="add what was measured")
    return keys


def _hint(column: str, rule: str, angles: Mapping[str, str], said: set[str]) -> str:
    """Return what to do about an unknown column of angles, the rule once; nothing for others."""
    if not column.startswith(KINDS):
        return ""
    # one phase without a joint group: not that of the first, which is 0 by definition
    own = {key: name for name, key in angles.items()}  # names of groups come after their numbers
    names = [name for key, name in own.items() if not (column.startswith("phase") and key == "phase[0]")]
    text = f"{'' if rule in said else rule}{did_you_mean(column, names or angles)}"
    said.add(rule)
    return text


def _run(cells: dict[str, str], robot: Robot, file: str, line: int, columns: set[str]) -> SteadyRun:
    """Return the run of the cells of a row."""
    groups = range(len(robot.joints))
    angles = {kind: [_number(cells.get(f"{kind}[{g}]", "0"), f"{kind}[{g}]") for g in groups] for kind in KINDS}
    gait = Gait.from_degrees(frequency=_number(cells["frequency"], "frequency"), **angles)
    measured = {key: _number(cells[key], key) for key in COLUMNS if key.startswith(MEASURED) and cells.get(key)}
    for column, key in LENGTHS.items():
        if column in columns and key in measured:
            measured[key] *= robot.body.length
    for column, key in POWERS.items():
        if column in columns and key in measured:
            if not measured.get("speed"):
                raise InputError("needs a speed other than 0, too", key=key, fix="give the speed, or leave this out")
            measured[key] /= robot.body.mass * abs(measured["speed"])
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
