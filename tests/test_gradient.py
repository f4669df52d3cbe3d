"""Exact derivatives against differences of whole swims: every parameter of every model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description import parse
from hypertuna.model import parameter_names
from models import MODELS, fastest, turning

# Relative step: the difference is then wrong by about its square, 1e-8, times the curvature (a few), and for gaits whose
# search stopped at 1e-8 of a body length a beat by what is left of that; a kink of v |v| adds as much.
STEP = 1e-4
EXACT = 5e-6

OUTPUTS = ("speed", "cost_of_transport", "power")


def split(name: str) -> tuple[list[str], str, int | None]:
    """``links.mass[3]`` as tables, attribute and index."""
    column, _, index = name.partition("[")
    *tables, attribute = column.split(".")
    return tables, attribute, int(index.rstrip("]")) if index else None


def explicit(robot: ht.Robot) -> ht.Robot:
    """The robot with every column written out, so that no value follows from another, and room for heavier links."""
    document = robot.document()
    tables = {"links": robot.links, "lumped": robot.water.lumped, "strip": robot.water.strip}
    for table, part in tables.items():
        if part is not None:
            columns = document[table] if table == "links" else document["water"][table]
            for attribute, info in type(part).model_fields.items():
                columns[info.alias] = part.model_dump(mode="json")[attribute]
    document["body"]["mass_kg"] *= 2
    return parse(document)


def value(robot: ht.Robot, gait: ht.Gait, name: str) -> float:
    """The parameter's value."""
    tables, attribute, index = split(name)
    if tables == ["joints"]:
        assert index is not None
        return robot.joints[index].bandwidth or 0.0
    owner: Any = gait if tables == ["gait"] else robot
    for table in tables[tables == ["gait"] :]:
        owner = getattr(owner, table)
    found = getattr(owner, attribute)
    return float(found if index is None else found[index])


def perturbed(robot: ht.Robot, gait: ht.Gait, name: str, by: float) -> tuple[ht.Robot, ht.Gait]:
    """The robot, or the gait, with one value changed in its description."""
    tables, attribute, index = split(name)
    if tables == ["gait"]:
        known = getattr(gait, attribute)
        new = known + by if index is None else tuple(x + by * (k == index) for k, x in enumerate(known))
        return robot, replace(gait, **{attribute: new})
    document, part = robot.document(), robot
    if tables == ["joints"]:
        group = document["joints"][index]
        return parse(document | {"joints": document["joints"]} if group.update(bandwidth_hz=group["bandwidth_hz"] + by) else document), gait
    table = document
    for key in tables:
        part, table = getattr(part, key), table[key]
    alias = type(part).model_fields[attribute].alias
    if index is None:
        table[alias] += by
    else:
        table[alias][index] += by
    document["body"]["length_m"] = sum(document["links"]["length_m"])
    return parse(document), gait


def difference(of: Callable[[float], np.ndarray], x: float, unit: float, *, signed: bool) -> np.ndarray:
    """Derivative times `unit` by second-order differences; forward ones at 0 for what must not be negative."""
    h = STEP * unit
    if x - h >= 0 or signed:
        return (of(h) - of(-h)) / (2 * STEP)
    return (4 * of(h) - 3 * of(0.0) - of(2 * h)) / (2 * STEP)
