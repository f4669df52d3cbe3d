"""Batches of gaits that workers swim range by range, and the layout of their results."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, robot_of
from hypertuna.errors import InputError
from hypertuna.parallel.layout import Layout
from hypertuna.ranges import POSITIVE_WHOLE, check_choice
from hypertuna.swimming.beat import APPROACH, QUANTITIES, STATUSES, check_steps, settle, settle_from_rest
from hypertuna.swimming.gait import AXES, KINDS, Gait, Gaits, check_gait, part_of
from hypertuna.swimming.swim import SUMMARY
from hypertuna.swimming.yielding import BEND, bend_table

CHUNK = 1024  # gaits swum in one call, after which progress is reported and Ctrl-C acts
# Additional variables of a data set if starts from rest are checked.
FROM_REST = {
    "reached_from_rest": {"long_name": "whether a start from rest leads to this beat"},
    "speed_from_rest": {"units": "m/s", "long_name": "speed of the settled beat that a start from rest leads to"},
}


@dataclass(frozen=True)
class Part:
    """A range of gaits, compact to send to a worker: the axes of the grid, or the range's list if that is shorter."""

    first: int  # index of the first gait
    last: int  # index after the last gait
    gaits: Gaits = field(repr=False)  # the whole grid, or the gaits of the range

    @classmethod
    def of(cls, gaits: Gaits, first: int, last: int) -> Self:
        """Return the part of gaits from index `first` to before `last`."""
        whole = gaits.is_grid and sum(gaits.shape) < last - first
        return cls(first, last, gaits if whole else part_of(gaits, first, last))

    def chunks(self, size: int) -> Iterator[Gaits]:
        """Yield the gaits of the part as lists of at most `size`."""
        start = 0 if self.gaits.is_grid else self.first
        for first in range(self.first, self.last, size):
            yield part_of(self.gaits, first - start, min(first + size, self.last) - start)


@dataclass(frozen=True)
class Swimming:
    """A robot and the options of its swims: all that a worker needs besides the gaits."""

    robot: Robot
    steps: int  # Runge-Kutta steps per beat
    wait: int  # beats from rest before the beat that is measured, -1 to solve for the settled beat
    check_rest: bool  # whether to check that a start from rest leads to the settled beat
    threads: int

    def swim(self, part: Part) -> dict[str, Array]:
        """Return the results of a part's gaits as columns (gaits,)."""
        chunks = [self._swim(gaits) for gaits in part.chunks(CHUNK)]
        return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in chunks[0]}

    def _swim(self, gaits: Gaits) -> dict[str, Array]:
        """Return the results of a list of gaits as columns (gaits,)."""
        approach = APPROACH * self.check_rest
        result = settle(self.robot, gaits, steps=self.steps, wait=self.wait, approach=approach, threads=self.threads)
        extra = _from_rest(self.robot, gaits, result, self.steps, self.threads) if self.check_rest else {}
        result |= extra | {"settled": result["status"] == 0}
        return {name: result[name] for name in (*QUANTITIES, *bend_table(self.robot), *extra, "status", "settled")}


@dataclass(frozen=True)
class Batch:
    """Gaits to swim, with the robot and the options of the swims."""

    gaits: Gaits
    swimming: Swimming

    @property
    def options(self) -> dict[str, Any]:
        """All inputs of the results except the robot, for the header of journals."""
        columns = [getattr(self.gaits, name) for name in AXES]
        digest = hashlib.sha256(b"".join(np.ascontiguousarray(column).tobytes() for column in columns)).hexdigest()
        swims = self.swimming
        return {
            "gaits": digest,
            "shape": list(self.gaits.shape),
            "steps": swims.steps,
            "wait": swims.wait,
            "check_rest": swims.check_rest,
        }

    @cached_property
    def layout(self) -> Layout:
        """Layout of the dataset of results: dimensions, variables, coordinates and attributes."""
        grid, swims = self.gaits.is_grid, self.swimming
        variables: dict[str, Any] = {
            name: {"units": about.unit, "long_name": about.meaning} for name, about in QUANTITIES.items()
        }
        bends = bend_table(swims.robot).items()
        variables |= {name: {"units": unit, "long_name": meaning} for name, (unit, meaning) in bends}
        flags = {"flag_values": list(range(len(STATUSES))), "flag_meanings": " ".join(STATUSES)}
        variables |= FROM_REST if swims.check_rest else {}
        variables["status"] = {"long_name": "how the search ended"} | flags
        variables["settled"] = {"long_name": "whether the gait repeats itself and is stable"}
        facts = {
            "steps": swims.steps,
            "method": "newton" if swims.wait < 0 else "beats",
            "check_rest": int(swims.check_rest),
        }
        sizes = dict(zip(AXES if grid else ("gait",), self.gaits.shape, strict=True))
        table = {name: name for name in table_names(variables)}
        return Layout(sizes, variables, _coordinates(swims.robot, self.gaits), provenance(swims.robot) | facts, table)


def batch(
    robot: Robot | str | Path,
    gaits: Gaits | Sequence[Gait],
    *,
    threads: int,
    steps: int,
    method: str,
    beats: int,
    check_rest: bool,
) -> Batch:
    """Check the options of a sweep, and return its batch of gaits."""
    robot = robot_of(robot)
    gaits = gaits if isinstance(gaits, Gaits) else Gaits.of(gaits)
    check_gait(gaits[0], robot)
    check_choice(method, ("newton", "beats"), "method")
    check_steps(steps)
    wait = POSITIVE_WHOLE.check(beats, "beats", "give the beats to swim from rest") - 1 if method == "beats" else -1
    if check_rest and wait >= 0:
        raise InputError("must be by newton to check starts from rest", key="method", value="beats", fix="leave it out")
    return Batch(gaits, Swimming(robot, steps, wait, check_rest, threads))


def table_names(variables: Iterable[Any]) -> list[str]:
    """Return the names of the variables that a sweep's table shows, in the table's order."""
    names = [*variables]
    bends = [name for name in names if {name, name.rpartition("_")[0]} & {*BEND}]
    return [name for name in (*SUMMARY, *bends, *FROM_REST, "status", "spectral_radius") if name in names]


def _from_rest(robot: Robot, gaits: Gaits, result: dict[str, Any], steps: int, threads: int) -> dict[str, Any]:
    """Return whether a start from rest leads to each gait's settled beat, and the speed [m/s] to which it leads."""
    reached = result["arrived"] & (result["status"] == 0)
    speed = np.where(reached, result["speed"], np.nan)
    elsewhere = np.flatnonzero(~reached)
    if len(elsewhere):
        part = Gaits(*(column[elsewhere] for column in gaits.columns), shape=(len(elsewhere),))
        from_rest = settle_from_rest(robot, part, steps=steps, threads=threads)
        speed[elsewhere] = np.where(from_rest["status"] == 0, from_rest["speed"], np.nan)
    return {"reached_from_rest": reached, "speed_from_rest": speed}


def _coordinates(robot: Robot, gaits: Gaits) -> dict[str, Any]:
    """Return dimension, values and attributes of each coordinate in a dataset of gaits."""
    grid, unit = gaits.is_grid, "deg" if gaits.degrees else "rad"
    attributes = {"units": "Hz", "long_name": "beat frequency"}
    coordinates: dict[str, Any] = {"frequency": ("frequency" if grid else "gait", gaits.frequency, attributes)}
    for name in KINDS:
        values = np.degrees(getattr(gaits, name)).round(10) if gaits.degrees else getattr(gaits, name)
        for g, group in enumerate(robot.joints):
            attributes = {"units": unit, "long_name": f"{name} of joint group {group.name}"}
            coordinates[f"{name}_{group.name}"] = (name if grid else "gait", values[:, g], attributes)
        if grid and (index := _index(robot, name, values, unit)) is not None:
            coordinates[name] = index
    return coordinates


def _index(robot: Robot, name: str, values: Array, unit: str) -> tuple[str, Array, dict[str, str]] | None:
    """Return the coordinate of an axis: the angles of the last joint group whose angles all differ along the axis."""
    for g in reversed(range(len(robot.joints))):
        if len(np.unique(values[:, g])) == len(values):
            group = robot.joints[g].name
            attributes = {"units": unit, "long_name": f"{name} of joint group {group}", "same_as": f"{name}_{group}"}
            return name, values[:, g], attributes
    return None
