"""Columns of a robot that can be free, those of the core's model and of its hinges' springs: values and places."""

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, cast, get_origin

from hypertuna.description.robot import Robot
from hypertuna.description.validation import field_at, nested_model, unit_of, written
from hypertuna.swimming.model import parameter_names
from hypertuna.swimming.yielding import SPRING, spring_values

SPRINGS = ("hinge", "hinges")  # tables of one hinge, and of several
LISTS = ("joints", "hinges")  # tables of which a robot's file has several, each with one value of a column


def is_spring(column: str) -> bool:
    """Return whether a column is of the springs of hinges: ``hinge.stiffness``, or ``hinges.stiffness`` of several."""
    return column.partition(".")[0] in SPRINGS


def known_columns(robot: Robot) -> dict[str, int]:
    """Return by column its number of values, 0 for a single value without an index; without columns of the gait.

    Numbers of stops are columns if all hinges have stops.
    """
    count: dict[str, int] = {}
    for name in parameter_names(robot):
        column, bracket, _ = name.partition("[")
        if not column.startswith("gait."):
            count[column] = count.get(column, 0) + bool(bracket)
    table = "hinges" if robot.hinge_list else "hinge"
    stops = bool(robot.hinges) and all(hinge.stop is not None for hinge in robot.hinges)
    names = [name for name in SPRING if robot.hinges and (stops or not name.startswith("stop"))]
    return count | {f"{table}.{name}": len(robot.hinge_list or ()) for name in names}


def parameter_rows(robot: Robot) -> dict[str, int]:
    """Return the row of each parameter in derivatives of settled beats: the model's, then those of the springs."""
    return {name: k for k, name in enumerate([*parameter_names(robot), *spring_values(robot)])}


def parameter_name(column: str, index: int | None) -> str:
    """Return the name of a column's value among `parameter_rows`; index: None for a column of one value."""
    if index is None:
        return column
    table, _, name = column.partition(".")
    return f"{table}[{index}].{name}" if is_spring(column) else f"{column}[{index}]"


@cache
def column_key(column: str) -> tuple[tuple[str, ...], str]:
    """Return a column's keys in a robot's file, outermost first, and its unit there; column: as water.lumped.drag."""
    model: Any = Robot
    keys, unit = [], ""
    for part in column.split("."):
        field = next(field for name, field in model.model_fields.items() if part == name or part == field.alias)
        keys.append(field.alias)
        unit, model = unit_of(field), nested_model(field.annotation)
    return tuple(keys), unit


def column_of(robot: Robot, column: str) -> tuple[Any, ...]:
    """Return the values of a column such as water.lumped.drag [SI]."""
    table, _, name = column.rpartition(".")
    if table == "joints":
        return tuple(getattr(group, name) for group in robot.joints)
    if is_spring(column):
        return tuple(getattr(hinge, name) for hinge in robot.hinges)
    part: Any = robot
    for attribute in column.split("."):
        part = getattr(part, attribute)
    return part if isinstance(part, tuple) else (part,)


def file_key(column: str) -> str:
    """Return a column's key in a robot's file, as text: ``hinge.stiffness_n_m_per_rad``."""
    return written(column_key(column)[0])


def write_column(document: dict[str, Any], column: str, numbers: Sequence[float]) -> None:
    """Write the values [SI] of a column into a robot's document, in the unit of the file."""
    keys, unit = column_key(column)
    in_unit = [float(f"{math.degrees(x):.15g}") if unit == "deg" else x for x in numbers]
    if keys[0] in LISTS:
        for table, number in zip(document[keys[0]], in_unit, strict=True):
            table[keys[1]] = number
        return
    table = document
    for key in keys[:-1]:
        table = table[key]
    field = field_at(Robot, keys)[1]
    one_per_link = field is not None and get_origin(field.annotation) is tuple
    table[keys[-1]] = cast(Any, in_unit) if one_per_link else in_unit[0]


def with_springs(robot: Robot, columns: Mapping[str, Sequence[float]]) -> Robot:
    """Return the robot with other numbers of its hinges' springs [SI], without a check; columns: by name."""
    if not columns:
        return robot
    changed = (
        {name.partition(".")[2]: column[d] for name, column in columns.items()} for d in range(len(robot.hinges))
    )
    hinges = [hinge.model_copy(update=values) for hinge, values in zip(robot.hinges, changed, strict=True)]
    return robot.model_copy(update={"hinge_list": tuple(hinges)} if robot.hinge_list else {"hinge": hinges[0]})
