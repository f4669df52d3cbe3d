"""Names of free coefficients: which parameters of the robot a name stands for, and which of them are tied."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.files import shipped
from hypertuna.swimming.model import parameter_names

__all__ = [
    "NUISANCES",
    "check_once",
    "covered",
    "default_bounds",
    "free_of",
    "known_columns",
    "members",
    "resolve",
    "split_names",
]

NUISANCES = {"time_offset": "s", "cost_factor": "1"}  # of the trials, not of the robot: name and unit
NAME = re.compile(r"(?P<column>[\w.]+)(?:\[(?P<index>.*)\])?")


def split_names(text: str) -> list[str]:
    """Split names at commas outside brackets.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of str

    Examples
    --------
    >>> split_names("water.drag[0,1-6,7], joints.bandwidth")
    ['water.drag[0,1-6,7]', 'joints.bandwidth']
    """
    return [name.strip() for name in re.split(r",(?![^\[]*\])", text) if name.strip()]


def free_of(robot: Robot, names: Sequence[str]) -> tuple[str, ...]:
    """Keep those names that the robot's law has, for a list that serves several laws.

    Parameters
    ----------
    robot : Robot
    names : sequence of str
        As for `free`.

    Returns
    -------
    tuple of str
    """
    other = {"lumped", "strip"} - {robot.model.water}
    known = known_columns(robot)

    def mine(name: str) -> bool:
        column = name.partition("[")[0]
        if column.split(".")[0] != "water" or column in known:
            return True
        law, _, last = column.removeprefix("water.").rpartition(".")
        return law not in other and (bool(law) or f"water.{robot.model.water}.{last}" in known)

    return tuple(name for name in names if mine(name))


@cache
def default_bounds() -> dict[str, Any]:
    """Read default bounds and starts from data/published/bounds.toml.

    Returns
    -------
    dict
        Table ``coefficient`` with ``lower``, ``upper``, ``start`` and ``source`` by column in SI units, and ``factor``
        of the described value for columns of the links.
    """
    path = shipped("data/published") / "bounds.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


def known_columns(robot: Robot) -> dict[str, int]:
    """Columns that can be free, and how many values each has; 0 for what is not a list."""
    count: dict[str, int] = {}
    for name in parameter_names(robot):
        column, bracket, _ = name.partition("[")
        if not column.startswith("gait."):
            count[column] = count.get(column, 0) + bool(bracket)
    return count | dict.fromkeys(NUISANCES, 0)


def resolve(
    robot: Robot, known: Mapping[str, int], name: str, recordings: Sequence[str], key: str
) -> list[tuple[str, str]]:
    """Read one name: pairs of column and canonical index."""
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
        wanted = list(recordings) if index is None else [index]
        for recording in wanted:
            if recording not in recordings:
                fix = did_you_mean(recording, recordings)
                raise InputError("must name a recording of the trials", key=f"{key} {name}", fix=fix)
        if not wanted:
            fix = "leave it out"
            raise InputError("is of recordings of joint angles, and the trials have none", key=f"{key} {name}", fix=fix)
        return [(column, recording) for recording in wanted]
    count = known[column]
    if index is None:
        return [(column, _canonical(range(count)) if count else "")]
    if not count:
        raise InputError("has one value only", key=f"{key} {name}", fix=f"write {column} without brackets")
    parts = [str(i) for i in range(count)] if index.strip() == "*" else index.split(",")
    return [(column, _canonical(_indices(robot, column, part.strip(), count, f"{key} {name}"))) for part in parts]


def _unknown(robot: Robot, known: Mapping[str, int], name: str, key: str) -> InputError:
    """Say why a name cannot be free."""
    column = name.partition("[")[0]
    law = column.removeprefix("water.").partition(".")[0]
    if column.startswith("water.") and law in {"lumped", "strip"} - {robot.model.water}:
        fix = f"choose --water {law}"
        return InputError(f"is not used by model.water = {robot.model.water!r}", key=f"{key} {name}", fix=fix)
    if column.startswith("gait."):
        rule = "belongs to the gait, which the trials give"
        return InputError(rule, key=f"{key} {name}", fix="free coefficients of water, joints or links")
    short = [f"water.{name.rpartition('.')[2]}" for name in known if name.startswith("water.") and name.count(".") == 2]
    fix = did_you_mean(column, [*known, *short])
    return InputError("is not a coefficient that can be free", key=f"{key} {name}", fix=fix)


def _indices(robot: Robot, column: str, text: str, count: int, key: str) -> list[int]:
    """Read an index, a range, or several tied by +; names of links and joint groups count as indices."""
    names = [group.name for group in robot.joints] if column.startswith("joints.") else list(robot.links.name)
    found: list[int] = []
    for part in text.split("+"):
        match = re.fullmatch(r"(\d+)(?:-(\d+))?", part.strip())
        if part.strip() in names:
            found.append(names.index(part.strip()))
        elif match and int(match[1]) <= int(match[2] or match[1]) < count:
            found += range(int(match[1]), int(match[2] or match[1]) + 1)
        else:
            rule = (
                f"must have indices from 0 to {count - 1}, ranges such as 1-{count - 1}, or names ({', '.join(names)})"
            )
            raise InputError(rule, key=key, value=shown(part.strip()), fix="correct what stands in the brackets")
    return sorted(set(found))


def _canonical(indices: Iterable[int]) -> str:
    """Write indices as ranges tied by +."""
    parts: list[list[int]] = []
    for i in indices:
        if parts and parts[-1][-1] == i - 1:
            parts[-1] = [parts[-1][0], i]
        else:
            parts.append([i])
    return "+".join("-".join(str(end) for end in part) for part in parts)


def members(index: str) -> tuple[int, ...]:
    """Read a canonical index."""
    ends = [[int(end) for end in part.split("-")] for part in index.split("+")]
    return tuple(i for end in ends for i in range(end[0], end[-1] + 1))


def check_once(found: Sequence[tuple[str, str]]) -> None:
    """Check that no parameter is free twice."""
    taken: dict[tuple[str, Any], str] = {}
    for column, index in found:
        for i in [index] if column in NUISANCES else members(index or "0"):
            if (column, i) in taken:
                name = f"{column}[{i}]" if index else column
                raise InputError("must be free once", key=name, value="named twice", fix="remove it from one")
            taken[column, i] = index


def covered(
    robot: Robot, known: Mapping[str, int], name: str, found: Sequence[tuple[str, str]], key: str
) -> list[tuple[str, str]]:
    """Free coefficients that a name covers."""
    named = [index for column, index in found if column == "time_offset"]
    wide = resolve(robot, known, name, named, key)
    column = wide[0][0]
    if column in NUISANCES:
        mine = [place for place in found if place in wide]
    else:
        inside = {i for _, index in wide for i in members(index or "0")}
        mine = [(c, index) for c, index in found if c == column and inside.issuperset(members(index or "0"))]
    if not mine:
        fix = did_you_mean(name, [f"{c}[{index}]" if index else c for c, index in found])
        raise InputError("must be a free coefficient", key=f"{key} {name}", fix=fix)
    return mine
