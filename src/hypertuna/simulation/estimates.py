"""How far the estimates of a description may be off, and random robots within these ranges."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hypertuna.description.provenance import factor_of, is_estimate
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.base import Key, Spread
from hypertuna.description.validation import declared
from hypertuna.errors import InputError


def spreads(robot: Robot) -> dict[str, Spread]:
    """Return how far the estimates of a robot may be off, by key: ``joints.line.bore_m`` is that of all joints.

    By the factor in its ``[uncertainty]``, else as declared with the key; a default is an estimate.
    """
    document, found = robot.document(), {}
    for key, one in declared(Robot).items():
        tables, last = _tables(document, key, one)
        given = any(last in table for table in tables)
        if one.spread is not None and tables and (is_estimate(robot, key) or not given):
            factor = factor_of(robot, key)
            found[key] = one.spread if factor == 1 else one.spread._replace(low=1 / factor, high=factor, added=False)
    return dict(sorted(found.items(), key=lambda item: item[1].place))


def varied(robot: Robot, parts: Mapping[str, float]) -> Robot:
    """Return a robot with some of its estimates at parts of their `spreads`, by key."""
    document, known = robot.document(), spreads(robot)
    for key, part in parts.items():
        if key not in known:
            raise InputError("must be an estimate of the robot", file=robot.file, key=key, fix="leave this key out")
        one, spread = declared(Robot)[key], known[key]
        tables, last = _tables(document, key, one)
        for table in tables:
            value = table[last] if last in table else one.options["default"]
            new = spread.at(value, part)
            table |= {other: table[other] * new / value for other in spread.along} | {last: new}
    return parse(document, file=robot.file)


def random_robots(robot: Robot, count: int, seed: int) -> list[Robot]:
    """Sample robots with estimates off at random, but the controller's."""
    keys = [key for key in spreads(robot) if not key.startswith("controller.")]
    parts = np.random.default_rng(seed).random((count, len(keys)))
    return [varied(robot, dict(zip(keys, row, strict=True))) for row in parts.tolist()]


def _tables(document: Mapping[str, Any], key: str, one: Key) -> tuple[list[dict[str, Any]], str]:
    """Return the tables of a key that have a value of it or leave it to a number, all of lists; and its name there."""
    *path, last = key.split(".")
    nodes: Sequence[Any] = [document]
    for name in path:
        nodes = [part for node in nodes if name in node for part in _listed(node[name])]
    return [node for node in nodes if last in node or one.options.get("default")], last


def _listed(node: Any) -> list[Any]:
    return node if isinstance(node, list) else [node]
