"""Text of a robot image: facts about a robot for programs without Python to show, and the ranges of its gaits.

All numbers are in SI units and radians, as in the rest of the image; keys are those of the robot's file without units.
"""

import math
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any

from hypertuna.control.sensors import channels
from hypertuna.description.robot import Robot, load
from hypertuna.description.schema.body import JointGroup, NamedGait
from hypertuna.description.shape import ASPECT
from hypertuna.description.twin import require_controller, why_no_twin
from hypertuna.io.files import published, verdicts
from hypertuna.simulation.recorded import CONDITIONS, LOSSES
from hypertuna.swimming.gait import KINDS
from hypertuna.swimming.outline import FIN, GIRTH, PEDUNCLE

FREQUENCIES = (0.1, 5.0)  # Hz: range of the knob if the robot's file has neither bounds nor gaits
BEND = math.pi / 4  # rad: range of a joint's knob if its file has no bounds, gaits or largest amplitude
FINS = ("x", "y", "z", "span", "chord")  # keys of [fins] that the text repeats
VERDICT = ("model", "class", "computed", "verdict", "seeds", "note")  # keys of a verdict that the text repeats
PUBLISHED = "hypertuna"  # the robot for whose gaits data/published has numbers
MEASURES = {  # by id in data/published, in addition to speed/GAIT: quantity and gait
    "power/fastest": ("electrical_power", "unoptimised-max"),
    "cost-of-transport/minimum": ("electrical_cost_of_transport", "unoptimised-max"),
    "power/lake": ("electrical_power", "optimised-0.5"),
    "turning/radius-bl": ("turn_radius_bl", "turning"),
}


def robot_facts(robot: Robot, models: Iterable[Robot]) -> dict[str, Any]:
    """Return the robot's part of an image's text; `models`: the robot with each choice of water law and joints."""
    return {
        "robot": robot.name,
        "description": robot.description,
        "fit": None if robot.fit is None else robot.fit.text,
        "hash": robot.hash,
        **body_text(robot),
        "outline": {"girth": GIRTH, "fin": FIN, "peduncle": PEDUNCLE},
        "joints": [_joint(group) for group in robot.joints],
        "hinges": [hinge.link for hinge in robot.hinges],
        "limits": _limits(robot),
        "ranges": _ranges(robot),
        "gaits": [_gait(robot, name, gait) for name, gait in robot.gaits.items()],
        "models": [{"water": model.model.water, "joints": model.model.joints} for model in models],
        "twin": _twin(robot),
        "no_twin": why_no_twin(robot),
        "ledger": _ledger(robot),
    }


def body_text(robot: Robot) -> dict[str, Any]:
    """Return the part of the text that changes with lengths, masses and areas of the body."""
    return {
        "length": robot.body.length,
        "mass": robot.body.mass,
        "links": _links(robot),
        "tail": _tail(robot),
        "fins": None if robot.fins is None else {key: getattr(robot.fins, key) for key in FINS},
    }


def numbers_of_text(value: Any, place: str = "") -> Iterator[tuple[str, float]]:
    """Yield the numbers in a part of the text, each with its path, such as ``links.0.length``."""
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, part in parts:
        yield from numbers_of_text(part, f"{place}.{name}" if place else str(name))
    if isinstance(value, (int, float)):
        yield place, float(value)


def _links(robot: Robot) -> list[dict[str, Any]]:
    """Return a table for each link; without [spatial], height is lateral area over length; width follows."""
    links, spatial = robot.links, robot.spatial
    heights = [area / length for area, length in zip(links.lateral_area, links.length, strict=True)]
    widths = [ASPECT * height for height in heights]
    columns = {
        "name": links.name,
        "length": links.length,
        "height": heights if spatial is None else spatial.height,
        "width": widths if spatial is None else spatial.width,
        "mass": links.mass,
        "com": links.com,
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _tail(robot: Robot) -> dict[str, Any]:
    """Return a table with the height of the tail's trailing edge [m]; None if no water law states it."""
    strip = robot.water.strip
    return {"edge_height": (strip.edge_height or None) if strip is not None else None}


def _joint(group: JointGroup) -> dict[str, Any]:
    """Return the table of a joint group; keys that its file leaves out are None."""
    keys = ("name", "links", "share", "bandwidth", "phase_offset", "amplitude_max", "bend_max")
    return {key: getattr(group, key) for key in keys} | {"drive": group.drive.actuation}


def _limits(robot: Robot) -> dict[str, Any] | None:
    """Return the robot's bounds on each parameter of a gait, lowest and highest; None without bounds."""
    bounds = robot.gait_bounds
    return None if bounds is None else {key: getattr(bounds, key) for key in ("frequency", *KINDS)}


def _ranges(robot: Robot) -> dict[str, Any]:
    """Return the range of a page's knob for each gait parameter, which includes the bounds and the robot's gaits.

    A bias may be as large as an amplitude, and a lag half a cycle to either side; the first joint group has no lag.
    """
    limits, gaits = robot.gait_bounds, list(robot.gaits.values())
    hertz = [gait.frequency for gait in gaits] + list(limits.frequency if limits else ())
    ranges: dict[str, Any] = {"frequency": _span(hertz or FREQUENCIES)} | {kind: [] for kind in KINDS}
    for g, group in enumerate(robot.joints):
        of_gaits = {kind: [getattr(gait, kind)[g] for gait in gaits] for kind in KINDS}
        for kind in KINDS if limits else ():
            of_gaits[kind] += getattr(limits, kind)[g]
        largest = max([*of_gaits["amplitude"], group.amplitude_max or 0.0]) or BEND
        ranges["amplitude"].append((0.0, largest))
        ranges["phase"].append(_span([*of_gaits["phase"], *((-math.pi, math.pi) if g else (0.0,))]))
        ranges["bias"].append(_span([*of_gaits["bias"], -largest, largest]))
    return ranges


def _span(values: Iterable[float]) -> tuple[float, float]:
    """Return the lowest and the highest value."""
    ordered = sorted(values)
    return ordered[0], ordered[-1]


def _twin(robot: Robot) -> dict[str, Any] | None:
    """Return the twin's part of the text: ticks per second, sensor channels, conditions, losses; None without twin."""
    if why_no_twin(robot):
        return None
    conditions, losses = (
        [{"name": name, "place": place, "text": text} for name, (place, text) in table.items()]
        for table in (CONDITIONS, LOSSES)
    )
    return {
        "rate": require_controller(robot).rate,
        "channels": channels(robot, pilot=False),
        "conditions": conditions,
        "losses": losses,
    }


def _gait(robot: Robot, name: str, gait: NamedGait) -> dict[str, Any]:
    """Return a gait of the robot's file, with the numbers published for it."""
    parts = {key: getattr(gait, key) for key in ("frequency", *KINDS)}
    return {"name": name} | parts | {"published": _published(robot, name, gait)}


@cache
def _shipped() -> Robot:
    """Return the robot of the published numbers, as shipped with the package."""
    return load(PUBLISHED)


def _published(robot: Robot, name: str, gait: NamedGait) -> dict[str, Any]:
    """Return a gait's published numbers by quantity: value, unit, kind, source and the ledger's verdicts."""
    if robot.name != PUBLISHED or _shipped().gaits.get(name) != gait:
        return {}
    quantities = {f"speed/{name}": "speed"} | {key: quantity for key, (quantity, of) in MEASURES.items() if of == name}
    facts = {quantity: {"id": key} | published()["values"].get(key, {}) for key, quantity in quantities.items()}
    return {
        quantity: fact | {"verdicts": _verdicts(robot, fact["id"])}
        for quantity, fact in facts.items()
        if "value" in fact
    }


def _verdicts(robot: Robot, key: str) -> list[dict[str, Any]]:
    """Return the stored verdicts on a published number, one for each model that computes the number."""
    entries = verdicts()["entries"] if _judged(robot) else ()
    return [{part: entry[part] for part in VERDICT} for entry in entries if entry["id"] == key]


def _ledger(robot: Robot) -> dict[str, Any] | None:
    """Return the ledger's marks, classes and models, with their meanings; None for a robot without verdicts."""
    return {key: verdicts()[key] for key in ("marks", "classes", "models")} if _judged(robot) else None


def _judged(robot: Robot) -> bool:
    """Return whether the stored verdicts belong to this robot, with any choice of water law and joints."""
    if robot.name != PUBLISHED:
        return False
    choice = _shipped().model
    model = robot.model.model_copy(update={"water": choice.water, "joints": choice.joints})
    return bool(robot.model_copy(update={"model": model}).hash == verdicts()["robot_hash"])
