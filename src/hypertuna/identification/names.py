"""Names of free coefficients: the parameters of the robot that a name selects, and ties among them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from hypertuna.description.robot import Robot
from hypertuna.description.schema.water import LAWS
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.files import shipped
from hypertuna.swimming.model import parameter_names

NUISANCES = {"time_offset": "s", "cost_factor": "1"}  # of the trials, not of the robot: name and unit
NAME = re.compile(r"(?P<column>[\w.]+)(?:\[(?P<index>.*)\])?")


def split_names(text: str) -> list[str]:
    """Split names at commas outside brackets.

    >>> split_names("water.drag[0,1-6,7], joints.bandwidth")
    ['water.drag[0,1-6,7]', 'joints.bandwidth']
    """
    return [name.strip() for name in re.split(r",(?![^\[]*\])", text) if name.strip()]


def free_of(robot: Robot, names: Sequence[str]) -> tuple[str, ...]:
    """Return the names that the robot's water law has, of a list that serves several laws."""
    other = LAWS.keys() - {robot.model.water}
    known = known_columns(robot)

    def applies(name: str) -> bool:
        column = name.partition("[")[0]
        if column.split(".")[0] != "water" or column in known:
            return True
        law, _, last = column.removeprefix("water.").rpartition(".")
        return law not in other and (bool(law) or f"water.{robot.model.water}.{last}" in known)

    return tuple(name for name in names if applies(name))


@cache
def default_bounds() -> dict[str, Any]:
    """Return default bounds and starts of data/published/bounds.toml.

    Table `coefficient`: `lower`, `upper`, `start` and `source` by column [SI]; table `factor`: bounds as multiples of
    the described value for columns of the links.
    """
    path = shipped("data/published") / "bounds.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


def known_columns(robot: Robot) -> dict[str, int]:
    """Return the columns that can be free with their numbers of values, 0 for a single value without an index."""
    count: dict[str, int] = {}
    for name in parameter_names(robot):
        column, bracket, _ = name.partition("[")
        if not column.startswith("gait."):
            count[column] = count.get(column, 0) + bool(bracket)
    return count | dict.fromkeys(NUISANCES, 0)


def resolve(
    robot: Robot, known: Mapping[str, int], name: str, recordings: Sequence[str], key: str
) -> list[tuple[str, str]]:
    """Return the pairs of column and canonical index that a name selects."""
    match = NAME.fullmatch(name)
    column, index = (match["column"], match["index"]) if match else (name, None)
    short = f"water.{robot.model.water}.{column.removeprefix('water.')}"
    if column not in known and column.startswith("water.") and short in known:
        column = short
    if column not in known:
        raise _unknown(robot, known, name, key)
    if column.startswith("joints.bandwidth") and robot.model.joints == "ideal":
        fix = "choose joints = 'bandwidth' in [model], or --joints bandwidth"
        raise InputError("is not used by model.joints = 'ideal'", file=robot.file, key=f"{key} {name}", fix=fix)
    if column == "time_offset":
        selected = list(recordings) if index is None else [index]
        for recording in selected:
            if recording not in recordings:
                fix = did_you_mean(recording, recordings)
                raise InputError("must name a recording of the trials", key=f"{key} {name}", fix=fix)
        if not selected:
            fix = "leave it out"
            raise InputError("needs recordings of joint angles, and the trials have none", key=f"{key} {name}", fix=fix)
        return [(column, recording) for recording in selected]
    count = known[column]
    if index is None:
        return [(column, _canonical(range(count)) if count else "")]
    if not count:
        raise InputError("has one value only", key=f"{key} {name}", fix=f"write {column} without brackets")
    parts = [str(i) for i in range(count)] if index.strip() == "*" else index.split(",")
    return [(column, _canonical(_indices(robot, column, part.strip(), count, f"{key} {name}"))) for part in parts]


def _unknown(robot: Robot, known: Mapping[str, int], name: str, key: str) -> InputError:
    """Return the error for a name that cannot be free."""
    column = name.partition("[")[0]
    law = column.removeprefix("water.").partition(".")[0]
    if column.startswith("water.") and law in LAWS.keys() - {robot.model.water}:
        fix = f"choose --water {law}"
        return InputError(f"is not used by model.water = {robot.model.water!r}", key=f"{key} {name}", fix=fix)
    if column.startswith("gait."):
        rule = "belongs to the gait, which the trials give"
        return InputError(rule, key=f"{key} {name}", fix="free coefficients of water, joints or links")
    short = [f"water.{name.rpartition('.')[2]}" for name in known if name.startswith("water.") and name.count(".") == 2]
    fix = did_you_mean(column, [*known, *short])
    return InputError("is not a coefficient that can be free", key=f"{key} {name}", fix=fix)


def _indices(robot: Robot, column: str, text: str, count: int, key: str) -> list[int]:
    """Return the indices of an index, a range, or several tied by +; names of links and joint groups are indices."""
    names = [group.name for group in robot.joints] if column.startswith("joints.") else list(robot.links.name)
    indices: list[int] = []
    for part in text.split("+"):
        match = re.fullmatch(r"(\d+)(?:-(\d+))?", part.strip())
        if part.strip() in names:
            indices.append(names.index(part.strip()))
        elif match and int(match[1]) <= int(match[2] or match[1]) < count:
            indices += range(int(match[1]), int(match[2] or match[1]) + 1)
        else:
            ranges = f"indices from 0 to {count - 1}, ranges such as 1-{count - 1}"
            rule = f"must have {ranges}, or names ({', '.join(names)})"
            raise InputError(rule, key=key, value=shown(part.strip()), fix="correct the index")
    return sorted(set(indices))


def _canonical(indices: Iterable[int]) -> str:
    """Format indices as ranges tied by +."""
    parts: list[list[int]] = []
    for i in indices:
        if parts and parts[-1][-1] == i - 1:
            parts[-1] = [parts[-1][0], i]
        else:
            parts.append([i])
    return "+".join("-".join(str(end) for end in part) for part in parts)


def members(index: str) -> tuple[int, ...]:
    """Return the indices of a canonical index."""
    ends = [[int(end) for end in part.split("-")] for part in index.split("+")]
    return tuple(i for end in ends for i in range(end[0], end[-1] + 1))


def check_once(places: Sequence[tuple[str, str]]) -> None:
    """Check that no parameter is free twice."""
    taken: set[tuple[str, str | int]] = set()
    for column, index in places:
        for i in [index] if column in NUISANCES else members(index or "0"):
            if (column, i) in taken:
                name = f"{column}[{i}]" if index else column
                raise InputError("must be listed only once", key=name, value="named twice", fix="remove it from one")
            taken.add((column, i))


def covered(
    robot: Robot, known: Mapping[str, int], name: str, places: Sequence[tuple[str, str]], key: str
) -> list[tuple[str, str]]:
    """Return the free coefficients that a name covers."""
    named = [index for column, index in places if column == "time_offset"]
    wide = resolve(robot, known, name, named, key)
    column = wide[0][0]
    if column in NUISANCES:
        matching = [place for place in places if place in wide]
    else:
        inside = {i for _, index in wide for i in members(index or "0")}
        matching = [(c, index) for c, index in places if c == column and inside.issuperset(members(index or "0"))]
    if not matching:
        fix = did_you_mean(name, [f"{c}[{index}]" if index else c for c, index in places])
        raise InputError("must be a free coefficient", key=f"{key} {name}", fix=fix)
    return matching
