"""Runs that are one measured number each: drag of a tow, thrust of a held fish, power of a beat; from CSV files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from hypertuna.description.robot import Robot
from hypertuna.display import Tabular
from hypertuna.errors import InputError
from hypertuna.io.door import RUNS
from hypertuna.io.tables import read_table
from hypertuna.ranges import POSITIVE, POSITIVE_WHOLE, Range
from hypertuna.swimming.gait import Gait, gait_table
from hypertuna.trials.steady import SIZE, gait_keys, gait_of, name_of, number, origin, unique

U = Range(above=0, max=100, unit="m/s")
NUMBER = Range(min=-1e9, max=1e9)  # SI


@dataclass(frozen=True)
class NumberRun(Tabular, data=lambda run: run.row()):
    """A run that is one measured number."""

    name: str
    value: float  # mean of the repeats [SI]
    sd: float | None = None  # of a single repeat [SI]
    gait: Gait | None = None  # as commanded; None for a straight body
    u: float = 0.0  # speed of the head through the water, where it is given [m/s]
    repeats: int = 1  # number of runs that the value is the mean of
    file: str = ""  # file and line of the run
    line: int = 0

    columns: ClassVar[Mapping[str, str]]  # of a file, by attribute
    beats: ClassVar[bool] = True  # whether it has a gait

    def __post_init__(self) -> None:
        if self.value == 0 and self.sd is None:
            fix = f"give {self.columns['sd']}"
            raise InputError("must have a standard deviation where it is 0", key="value", value="without", fix=fix)
        NUMBER.check(self.value, "value", "leave out the run if it is unknown")
        if self.sd is not None:
            for limits in (POSITIVE, SIZE):
                limits.check(self.sd, "sd", "leave it out if it is unknown")
        if self.u or not self.beats:
            U.check(self.u, "u", "give the speed of the head through the water, head first")
        POSITIVE_WHOLE.check(self.repeats, "repeats", "give the number of runs that the value is the mean of")

    def row(self) -> dict[str, Any]:
        """Return the run as columns of one row, as a file has them."""
        gait = {} if self.gait is None else gait_table([self.gait])
        own = {
            self.columns[key]: [getattr(self, key)] for key in ("u", "value", "sd", "repeats") if key in self.columns
        }
        return {"run": [self.name]} | gait | own


ENDS = {"repeats": "repeats", "name": "run"}


class Tow(NumberRun):
    """The drag of the straight body, towed head first: a force gauge between carriage and head, joints at 0."""

    columns = {"u": "u_m_s", "value": "drag_n", "sd": "drag_sd_n"} | ENDS
    beats = False


class HeldThrust(NumberRun):
    """The mean thrust of a beat while the head is held, still or in a current: toward the head, less the drag."""

    columns = {"frequency": "frequency_hz", "u": "u_m_s", "value": "thrust_n", "sd": "thrust_sd_n"} | ENDS


class PowerRun(NumberRun):
    """The mean mechanical power of all joints over a settled beat, or what is drawn for it: free `cost_factor`."""

    columns = {"frequency": "frequency_hz", "value": "power_w", "sd": "power_sd_w"} | ENDS


R = TypeVar("R", bound=NumberRun)


def read_numbers(path: str | Path, robot: Robot, made: type[R]) -> tuple[R, ...]:
    """Read runs of a type from a CSV file: one row per run; docs/trials.md lists the columns."""
    table = read_table(path, RUNS)
    own = made.columns
    needed = {key: own[key] for key in ("value", *(() if made.beats else ("u",)))}
    if made.beats:
        keys = gait_keys(table, robot, own)
        for key in set(needed) - set(keys):
            raise InputError("must be a column", file=table.file, key=own[key], value="missing", fix="add it")
    else:
        keys = table.keys({column: key for key, column in own.items()}, needed, fix="add it")

    def run(line: int, cells: dict[str, str]) -> R:
        numbers: dict[str, Any] = {"value": number(cells["value"], "value")}
        numbers |= {key: number(cells[key], key) for key in ("u", "sd") if cells.get(key) or key in needed}
        gait = gait_of(cells, robot) if made.beats else None
        return made(name_of(cells, table.file, line), **numbers, gait=gait, **origin(cells, table.file, line))

    return tuple(table.parse(unique(run), keys, own))
