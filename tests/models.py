"""The models that properties must hold for: both robots, every water law that they have, and its variants."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.swimming.gait import named_gait


def changed(robot: ht.Robot, changes: Mapping[str, Any]) -> ht.Robot:
    """The robot with other values for keys of its file, such as ``water.strip.cross_flow``; None takes a table out."""
    document = robot.document()
    for key, value in changes.items():
        *tables, last = key.split(".")
        table = document
        for name in tables:
            table = table[name]
        if value is None:
            del table[last]
        else:
            table[last] = value
    return parse(document, file=robot.file)


def _strip_variants(robot: ht.Robot) -> dict[str, ht.Robot]:
    """The strip law with one thing at a time of those that a description may leave out."""
    strip = robot.using(water="strip")
    links = len(robot.links.name)
    plain = {"water.strip.cross_flow": False}
    # As much as the quadratic drag of a 7 cm high section at 2 cm/s; a tenth of it along the body.
    linear = {"water.strip.linear_normal_pa_s": [1.0] * links, "water.strip.linear_tangential_pa_s": [0.1] * links}
    edge = {"tail_shedding": 1.0, "edge_aspect": 0.0, "edge_suction": 0.3}
    return {
        "strip": changed(strip, plain),
        "strip-cross-flow": changed(strip, {"water.strip.cross_flow": True}),
        "strip-linear": changed(strip, plain | linear),
        "strip-shedding": changed(strip, plain | {"water.strip.tail_shedding": 0.3}),
        "strip-edge": changed(strip, plain | {f"water.strip.{key}": value for key, value in edge.items()}),
    }


def _models() -> dict[str, ht.Robot]:
    tuna, eel = ht.load("hypertuna"), ht.load("rexeel-theory")
    lumped = {
        "lumped": tuna,
        "lumped-ideal": tuna.using(joints="ideal"),
        "lumped-as-printed": tuna.using(areas="as-printed"),
    }
    slender = [(robot, {"elongated": robot.using(water="elongated")}) for robot in (tuna, eel)]
    named = [(tuna, lumped), (tuna, _strip_variants(tuna)), (eel, _strip_variants(eel)), *slender]
    return {f"{robot.name}-{name}": variant for robot, variants in named for name, variant in variants.items()}


MODELS = _models()

FASTEST = {"hypertuna": "unoptimised-max", "rexeel-theory": "wave-30"}


def fastest(robot: ht.Robot) -> ht.Gait:
    """The fastest gait of the robot's description."""
    return named_gait(robot, FASTEST[robot.name])


def turning(robot: ht.Robot, bias: float = 0.3) -> ht.Gait:
    """The same with a bias of all joints, as a fraction of their amplitudes: positive bends them counter-clockwise."""
    gait = fastest(robot)
    return replace(gait, bias=tuple(bias * amplitude for amplitude in gait.amplitude))


def later(gait: ht.Gait, beats: float) -> ht.Gait:
    """The gait with its clock set back by a number of beats."""
    return replace(gait, phase=tuple(phase + 2 * math.pi * beats for phase in gait.phase))


def mirrored(gait: ht.Gait) -> ht.Gait:
    """The gait seen in a mirror: every joint angle with the other sign."""
    return replace(later(gait, 0.5), bias=tuple(-bias for bias in gait.bias))


def has_linear_drag(robot: ht.Robot) -> bool:
    """Whether some force is proportional to velocity: speed is then not proportional to frequency."""
    strip = robot.water.strip
    return robot.model.water == "strip" and strip is not None and any(strip.linear_normal + strip.linear_tangential)
