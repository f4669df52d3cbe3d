"""Shape of an exported robot: convex pieces of each link, in the link's axes."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot

AROUND = 24  # points around a section
NOSE = 0.45  # fraction of the head's length that is rounded
EDGE = 0.0015  # half thickness of fins, as a fraction of the body's length
SKIN, SOFT, FIN = "0.33 0.46 0.55 1", "0.86 0.55 0.30 1", "0.22 0.33 0.42 1"  # RGBA colors of hull, soft joints, fins


class Piece(NamedTuple):
    """A convex piece of a link."""

    link: int
    name: str
    color: str
    points: Array  # (n, 3) [m], relative to `place`
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)  # in the link's axes [m]


def sections(robot: Robot) -> tuple[Array, Array]:
    """Return height and width (links,) [m] of the links' sections; without [spatial], links are neutrally buoyant."""
    if robot.spatial is not None:
        return np.array(robot.spatial.height), np.array(robot.spatial.width)
    height = np.divide(robot.links.lateral_area, robot.links.length)
    volume = np.divide(robot.links.mass, robot.water.density)
    return height, np.minimum(volume / (math.pi / 4 * height * robot.links.length), height)


def pieces(robot: Robot) -> Iterator[Piece]:
    """Yield the pieces of all links: bodies whose sections pass smoothly into each other, caudal and pectoral fins."""
    height, width = sections(robot)
    length, last = robot.links.length, len(robot.links.length) - 1
    soft = {link for group in robot.joints for link in group.links}
    body_length, has_tail_fin = robot.body.length, edge_height(robot) > height[-1]
    for i, long in enumerate(length):
        before, after = max(i - 1, 0), min(i + 1, last)
        ends = np.array([[height[before] + height[i], width[before] + width[i]],
                         [height[after] + height[i], width[after] + width[i]]]) / 2  # fmt: skip
        if i == last:
            ends[1] = 0.35 * ends[0] if has_tail_fin else (height[i], 2 * EDGE * body_length)
        yield Piece(i, robot.links.name[i], SOFT if i in soft and i != last else SKIN, _loft(long, ends, head=i == 0))
    if has_tail_fin:
        long, half = length[-1], edge_height(robot) / 2
        for name, z in (("upper", half), ("lower", -half)):
            lobe = [(0.15 * long, 0), (0.80 * long, z), (long, z), (0.62 * long, 0)]
            yield Piece(last, f"fin-{name}", FIN, _plate(lobe, EDGE * body_length))
    if robot.fins is not None:
        fin = robot.fins
        for name, side in (("port", -1), ("starboard", 1)):
            half, root, tip = fin.chord / 2, -side * fin.span / 2, side * fin.span / 2
            plate = _plate([(-half, root), (-0.3 * half, tip), (half, tip), (half, root)], EDGE * body_length)
            yield Piece(0, f"pectoral-{name}", FIN, plate[:, [0, 2, 1]], (fin.x, side * fin.y, fin.z))


def edge_height(robot: Robot) -> float:
    """Return the height of the tail fin's trailing edge [m]; 0 if it is not stated."""
    return 0.0 if robot.water.strip is None else robot.water.strip.edge_height


def _loft(length: float, ends: Array, *, head: bool) -> Array:
    """Return points of elliptic sections from front to rear, with a round cap in front (at a joint or the nose)."""
    cap = np.linspace(0, math.pi / 2, 7)
    reach = NOSE * length if head else ends[0, 1] / 2
    x = [*(reach * (1 - np.cos(cap)) if head else -reach * np.cos(cap)), length]
    scale = [*np.maximum(np.sin(cap), 0.02), 1.0]
    around = 2 * math.pi * np.arange(AROUND) / AROUND
    return np.array(
        [
            (position, size * w / 2 * math.cos(a), size * h / 2 * math.sin(a))
            for position, size in zip(x, scale, strict=True)
            for h, w in [ends[0] + max(position, 0) / length * (ends[1] - ends[0])]
            for a in around
        ]
    )


def _plate(corners: list[tuple[float, float]], half: float) -> Array:
    """Return the points of an upright plate: corners (x, z), thickness along y."""
    return np.array([(x, y, z) for x, z in corners for y in (-half, half)])
