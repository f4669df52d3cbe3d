"""Ranges of the estimated values in a robot's description, and random robots within these ranges."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hypertuna.description.provenance import factor_of, is_estimate
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.base import Key, Spread
from hypertuna.description.validation import declared
from hypertuna.errors import InputError


def spreads(robot: Robot) -> dict[str, Spread]:
    """Return the ranges of a robot's estimated values by key; ``joints.line.bore_m`` covers all joints.

    A range follows from the factor in the robot's ``[uncertainty]``, or else from the key's declaration. Values left at
    their defaults count as estimates.
    """
    document, ranges = robot.document(), {}
    for key, k in declared(Robot).items():
        tables, name = _tables(document, key, k)
        has_value = any(name in table for table in tables)
        if k.spread is not None and tables and (is_estimate(robot, key) or not has_value):
            factor = factor_of(robot, key)
            ranges[key] = k.spread if factor == 1 else k.spread._replace(low=1 / factor, high=factor, added=False)
    return dict(sorted(ranges.items(), key=lambda item: item[1].place))


def varied(robot: Robot, parts: Mapping[str, float]) -> Robot:
    """Return a robot whose estimates, by key, are moved to a fraction from 0 to 1 of their range in `spreads`."""
    document, ranges = robot.document(), spreads(robot)
    for key, part in parts.items():
        if key not in ranges:
            raise InputError("must be an estimate of the robot", file=robot.file, key=key, fix="leave this key out")
        declaration, spread = declared(Robot)[key], ranges[key]
        tables, name = _tables(document, key, declaration)
        for table in tables:
            value = table[name] if name in table else declaration.options["default"]
            new = spread.at(value, part)
            table |= {other: table[other] * new / value for other in spread.along} | {name: new}
    return parse(document, file=robot.file)


def random_robots(robot: Robot, count: int, seed: int) -> list[Robot]:
    """Sample robots whose estimates, except the controller's, are drawn uniformly within their `spreads`."""
    keys = [key for key in spreads(robot) if not key.startswith("controller.")]
    parts = np.random.default_rng(seed).random((count, len(keys)))
    return [varied(robot, dict(zip(keys, row, strict=True))) for row in parts.tolist()]


def _tables(document: Mapping[str, Any], key: str, declaration: Key) -> tuple[list[dict[str, Any]], str]:
    """Return the tables that set a key, or leave it at a default other than 0, and the key's last name."""
    *path, own_name = key.split(".")
    nodes: Sequence[Any] = [document]
    for name in path:
        nodes = [part for node in nodes if name in node for part in _listed(node[name])]
    return [node for node in nodes if own_name in node or declaration.options.get("default")], own_name


def _listed(node: Any) -> list[Any]:
    return node if isinstance(node, list) else [node]
