"""Runs that are one measured number each (drag, thrust, power or rate of turn), read from CSV files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from hypertuna.description.robot import Robot
from hypertuna.display import Tabular
from hypertuna.errors import InputError
from hypertuna.io.door import RUNS
from hypertuna.io.tables import Table, table_of
from hypertuna.ranges import POSITIVE, POSITIVE_WHOLE, Range
from hypertuna.swimming.gait import Gait, gait_table
from hypertuna.trials.steady import SIZE, gait_keys, gait_of, name_of, number, origin, unique

U = Range(above=0, max=100, unit="m/s")  # speeds through the water
NUMBER = Range(min=-1e9, max=1e9)  # measured values [SI]


@dataclass(frozen=True)
class NumberRun(Tabular, data=lambda run: run.row()):
    """A run that is one measured number."""

    name: str
    value: float  # mean of the repeats [SI]
    sd: float | None = None  # standard deviation of a single repeat [SI]
    gait: Gait | None = None  # as commanded; None for a straight body
    u: float = 0.0  # speed of the towed or held head through the water [m/s]
    repeats: int = 1  # number of runs that the value is the mean of
    file: str = ""  # file and line of the run
    line: int = 0

    columns: ClassVar[Mapping[str, str]]  # by attribute: name of its column in a file
    beats: ClassVar[bool] = True  # whether runs of this type have a gait
    per_si: ClassVar[float] = 1.0  # units of the file per SI unit

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
        """Return the run as columns of one row, with the names and units of a CSV file."""
        gait = {} if self.gait is None else gait_table([self.gait])
        sizes = {"u": 1.0, "value": self.per_si, "sd": self.per_si, "repeats": 1}
        given = {key: (getattr(self, key), size) for key, size in sizes.items() if key in self.columns}
        own = {self.columns[key]: [None if x is None else x * size] for key, (x, size) in given.items()}
        return {"run": [self.name]} | gait | own


ENDS = {"repeats": "repeats", "name": "run"}  # columns that all types of runs have


class Tow(NumberRun):
    """Drag of the straight body towed head first, by a force gauge between carriage and head, with the joints at 0.

    Parameters
    ----------
    name : str
        Name of the run.
    value : float
        Drag, mean of the repeats [N].
    sd : float, optional
        Standard deviation of a single repeat [N].
    u : float
        Speed of the head through the water [m/s].
    repeats : int
        Number of runs that the value is the mean of.
    """

    columns = {"u": "u_m_s", "value": "drag_n", "sd": "drag_sd_n"} | ENDS
    beats = False


class HeldThrust(NumberRun):
    """Mean thrust over a beat with the head held, in still water or a current: net of drag, positive toward the head.

    Parameters
    ----------
    name, repeats
        As of `Tow`.
    value, sd : float
        As of `Tow`, of the thrust [N].
    gait : Gait
        As commanded.
    u : float
        Speed of the current, head first [m/s].
    """

    columns = {"frequency": "frequency_hz", "u": "u_m_s", "value": "thrust_n", "sd": "thrust_sd_n"} | ENDS


class PowerRun(NumberRun):
    """Mean mechanical power of all joints over a settled beat.

    If it is the electrical power, free `cost_factor` in the fit.

    Parameters
    ----------
    name, gait, repeats
        As of `HeldThrust`.
    value, sd : float
        As of `Tow`, of the power [W].
    """

    columns = {"frequency": "frequency_hz", "value": "power_w", "sd": "power_sd_w"} | ENDS


class TurnRun(NumberRun):
    """Mean rate of turn of a settled gait, counter-clockwise; on a circle, it is speed over radius.

    Parameters
    ----------
    name, gait, repeats
        As of `HeldThrust`.
    value, sd : float
        As of `Tow`, of the rate of turn [rad/s]; files have deg/s.
    """

    columns = {"frequency": "frequency_hz", "value": "turn_rate_deg_s", "sd": "turn_rate_sd_deg_s"} | ENDS
    per_si = 180 / math.pi


R = TypeVar("R", bound=NumberRun)


def read_numbers(path: str | Path | Table, robot: Robot, made: type[R]) -> tuple[R, ...]:
    """Read runs of a type `made` from a CSV file with one row per run; docs/trials.md lists the columns."""
    table = table_of(path, RUNS)
    names = made.columns
    needed = {key: names[key] for key in ("value", *(() if made.beats else ("u",)))}
    if made.beats:
        keys = gait_keys(table, robot, names)
        for key in set(needed) - set(keys):
            raise InputError("must be a column", file=table.file, key=names[key], value="missing", fix="add it")
    else:
        keys = table.keys({column: key for key, column in names.items()}, needed, fix="add it")

    def run(line: int, cells: dict[str, str]) -> R:
        sizes = {"value": made.per_si, "sd": made.per_si, "u": 1.0}
        numbers: dict[str, Any] = {
            key: number(cells[key], key) / size for key, size in sizes.items() if cells.get(key) or key in needed
        }
        gait = gait_of(cells, robot) if made.beats else None
        return made(name_of(cells, table.file, line), **numbers, gait=gait, **origin(cells, table.file, line))

    return tuple(table.parse(unique(run), keys, names))
