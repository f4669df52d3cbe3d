"""Electrical cost of a sweep's gaits: the twin swims each gait, many at once in vector lanes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.description.twin import require_controller
from hypertuna.errors import InputError
from hypertuna.simulation.plant import check_command
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import CHUNK, twins
from hypertuna.swimming.gait import Gait, Gaits

if TYPE_CHECKING:
    import xarray as xr

BEATS = 16.0  # length of a run, which begins at the speed of its settled beat
MAX_RUNS = 100_000  # largest number of runs of the twin, which take about an hour
# The columns that the twin adds to a sweep: unit and meaning.
COLUMNS = {
    "twin_speed": ("m/s", "speed in the twin, whose joints swing as drives and controller let them"),
    "electrical_power": ("W", "mean electrical power of all servos in the twin"),
    "electrical_cost_of_transport": ("J/(kg m)", "electrical power over mass and speed, in the twin"),
    "twin_settled": ("1", "1 where speed and swings of the twin change by less than 0.2 % per beat"),
}


def check_runs(robots: Sequence[Robot], gaits: Gaits | Sequence[Gait]) -> None:
    """Check that there are not too many robots and gaits for the twin, and that each robot has one."""
    if (count := len(robots) * len(gaits)) > MAX_RUNS:
        rule, fix = f"must be at most {MAX_RUNS} gaits to swim in the twin", "take fewer values"
        raise InputError(rule, key="electrical", value=f"{count}", fix=fix)
    for robot in robots:
        require_controller(robot)


def with_electrical(
    swept: xr.Dataset,
    robots: Sequence[Robot],
    gaits: Gaits | Sequence[Gait],
    *,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Swim each robot and gait of a sweep in the twin, and return the sweep with the columns of `COLUMNS` added.

    Cases go robot by robot, in the sweep's order. A gait beyond the controller's bounds, or a diverged run, has NaN.
    """
    check_runs(robots, gaits)
    cases = [(robot, gait) for robot in robots for gait in gaits]
    values = np.full((len(cases), len(COLUMNS)), math.nan)
    taken = [k for k, case in enumerate(cases) if _takes(*case)]
    for first in range(0, len(taken), CHUNK * threads):
        part = taken[first : first + CHUNK * threads]
        runs = [
            {"robot": robot, "gait": gait, "duration": BEATS / gait.frequency, "start": "swimming"}
            for robot, gait in (cases[k] for k in part)
        ]
        values[part] = twins(runs, measure=_measured, threads=threads)
        if progress is not None:
            progress(first + len(part), len(taken))
    return swept.assign(
        {
            name: (swept.settled.dims, values[:, k].reshape(swept.settled.shape), {"units": unit, "long_name": text})
            for k, (name, (unit, text)) in enumerate(COLUMNS.items())
        }
    )


def _takes(robot: Robot, gait: Gait) -> bool:
    """Return whether a gait is within the bounds of a robot's controller."""
    try:
        check_command(robot, gait)
    except InputError:
        return False
    return True


def _measured(run: TwinRun) -> Array:
    """Return the values of `COLUMNS` (columns,) for a run; NaN if it diverged."""
    if run.status == "diverged":
        return np.full(len(COLUMNS), math.nan)
    return np.array([run.speed, run.electrical_power, run.cost_of_transport, run.settled])
