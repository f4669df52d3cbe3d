"""Decays of a straight body that was let go: the speed of a glide or the yaw rate of a turn; read from CSV files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, TypeVar

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.display import Tabular
from hypertuna.errors import InputError
from hypertuna.io.tables import Table, table_of
from hypertuna.ranges import CELL
from hypertuna.trials.steady import SIZE, number

MIN_ROWS = 4  # of a decay; one of them is spent on the fitted first value


@dataclass(frozen=True)
class Decay(Tabular, data=lambda decay: decay.rows()):
    """Speed or yaw rate of a coasting body over time, with its joints at 0."""

    name: str
    time: Array  # (rows,) [s]
    value: Array  # (rows,) [m/s] or [rad/s]
    sd: float | None = None  # standard deviation of each value; errors are independent
    file: str = ""

    columns: ClassVar[Mapping[str, str]]  # by attribute: name of its column in a file
    per_si: ClassVar[float] = 1.0  # units of the file per SI unit

    def __post_init__(self) -> None:
        if len(self.time) < MIN_ROWS:
            rule, fix = f"must have at least {MIN_ROWS} rows", "record a longer decay"
            raise InputError(rule, file=self.file, key=f"run {self.name}", value=f"{len(self.time)}", fix=fix)
        for k in np.flatnonzero(np.diff(self.time) <= 0)[:1] + 1:
            rule = f"must be later than the previous row, at {self.time[k - 1]:g} s"
            fix = "sort the rows of each run by time, or name runs in a column `run`"
            where, value = f"run {self.name}, time_s", f"{self.time[k]:g} s"
            raise InputError(rule, file=self.file, key=where, value=value, fix=fix)
        if not self.value[0]:
            rule, fix = "must begin in motion", "leave out the rows before the body was let go"
            raise InputError(rule, file=self.file, key=f"run {self.name}", value="0 in its first row", fix=fix)

    def rows(self) -> dict[str, Array]:
        """Return times and values as columns of a CSV file, in the file's units."""
        return {self.columns["time"]: self.time, self.columns["value"]: self.per_si * self.value}


ENDS = {"time": "time_s", "name": "run"}  # columns that all types of decays have


class Glide(Decay):
    """The forward speed of a straight body that coasts.

    Parameters
    ----------
    name : str
        Name of the run.
    time : ndarray, shape (rows,)
        Increasing times [s].
    value : ndarray, shape (rows,)
        Speed at each [m/s].
    sd : float, optional
        Standard deviation of each value, independent of the others [m/s].
    file : str
        File of the run.
    """

    columns = {"value": "speed_m_s", "sd": "speed_sd_m_s"} | ENDS

    def coasting(self) -> tuple[float, float, float]:
        """Fit a line to 1/u over time; return the distance [m] in which the speed u falls to 1/e.

        Returns
        -------
        length : float
            For quadratic drag, mass with added mass over (1/2 density times drag area) [m].
        sd : float
            Its standard deviation, by that of the values, or by their residuals [m].
        u : float
            Speed in the middle of the glide [m/s].
        """
        kept = self.value > 0
        time, value = self.time[kept], self.value[kept]
        if len(time) < MIN_ROWS:
            rule, fix = f"must have at least {MIN_ROWS} speeds above 0", "track the glide while it moves ahead"
            raise InputError(rule, file=self.file, key=f"run {self.name}", value=f"{len(time)}", fix=fix)
        weight = value**4  # of each 1/u in the fit, for equal errors of all speeds u
        middle = np.average(time, weights=weight)
        spread = float(weight @ (time - middle) ** 2)
        slope = float(weight @ ((time - middle) / value)) / spread
        if not slope > 0:
            rule, fix = "must slow down", "leave out the rows before the body was let go"
            raise InputError(rule, file=self.file, key=f"run {self.name}", fix=fix)
        line = np.average(1 / value, weights=weight) + slope * (time - middle)
        variance = float(weight @ (1 / value - line) ** 2) / (len(time) - 2)
        sd = math.sqrt(variance) if self.sd is None else self.sd
        return 1 / slope, sd / (slope**2 * math.sqrt(spread)), float(1 / math.sqrt(line[0] * line[-1]))


class YawDecay(Decay):
    """The yaw rate of a straight body that was turned about its center of mass and let go.

    Parameters
    ----------
    name, time, sd, file
        As of `Glide` [s, rad/s].
    value : ndarray, shape (rows,)
        Yaw rate at each time [rad/s].
    """

    columns = {"value": "yaw_rate_deg_s", "sd": "yaw_rate_sd_deg_s"} | ENDS
    per_si = 180 / math.pi


D = TypeVar("D", bound=Decay)


def read_decays(path: str | Path | Table, robot: Robot, made: type[D]) -> tuple[D, ...]:
    """Read decays of a type `made` from a CSV file with a row per time; without a column `run` the file is one run."""
    table, names = table_of(path), made.columns
    needed = {key: names[key] for key in ("time", "value")}
    keys = table.keys({column: key for key, column in names.items()}, needed, fix="add it")

    def row(_: int, cells: dict[str, str]) -> tuple[str, float, float, float]:
        fix = "give a number, or leave out the line"
        time, value = (CELL.check(number(cells[key], key), key, fix) for key in ("time", "value"))
        sd = SIZE.check(number(cells["sd"], "sd"), "sd", "leave it out") if cells.get("sd") else math.nan
        return cells.get("name") or Path(table.file).stem, time, value, sd

    rows = table.parse(row, keys, names)
    runs: dict[str, list[tuple[str, float, float, float]]] = {}
    for record in rows:
        runs.setdefault(record[0], []).append(record)
    return tuple(
        _decay(made, name, np.array([record[1:] for record in own_rows]), table.file) for name, own_rows in runs.items()
    )


def _decay(made: type[D], name: str, rows: Array, file: str) -> D:
    """Return a decay from rows (rows, 3) of time, value and standard deviation; it keeps the rms of the last."""
    sd = float(np.sqrt(np.mean(rows[:, 2] ** 2))) / made.per_si
    return made(name, rows[:, 0], rows[:, 1] / made.per_si, None if math.isnan(sd) else sd, file)
