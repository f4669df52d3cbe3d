"""Mission: where a robot is to go, in which water, and within which bounds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Mission", "Waypoint", "cross", "fence_distance", "sides"]

Array = NDArray[np.float64]
Point = tuple[float, float]


class Waypoint(NamedTuple):
    """A place to go to."""

    x: float  # East and north of the origin [m]
    y: float
    depth: float  # Below the surface, on the way there [m]
    speed: float  # Through the water, on the way there [m/s]
    radius: float  # Within which it counts as reached [m]


@dataclass(frozen=True)
class Mission:
    """A mission and the water that it goes through.

    Positions are (east, north) of the origin [m]; currents are velocities of the water (east, north) [m/s].
    """

    waypoints: tuple[Waypoint, ...]  # In their order; the legs between them are straight, the first from the start
    start: tuple[float, float] = (0.0, 0.0)  # Where it begins and where it comes home to [m]
    home: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0  # At the start: angle of the head's axis, nose to tail, from x, counter-clockwise [rad]
    depth: float = 0.0  # At the start [m]
    battery: float = 1.0  # Part of the charge at the start [1]
    home_radius: float = 3.0  # Within which the robot is at home [m]
    home_speed: float = 0.3  # Through the water, on the way home [m/s]
    # Corners around the water that it may be in, either way round [m]; none for no fence
    fence: tuple[tuple[float, float], ...] = field(default=())
    depth_max: float = 5.0  # That it may not go below [m]
    reserve: float = 0.1  # Part of the usable charge to come home with [1]
    duration: float = 0.0  # Time after which it should be home [s]; 0 for no end
    # Time after the last fix to come up for the next [s]; 0 for only when the position is uncertain
    surface_every: float = 0.0
    stay: bool = False  # Whether it comes up at the last waypoint instead of going home
    bottom: float = 20.0  # Depth of the ground [m]
    # Of the water at the surface and at the ground, straight in between [m/s]
    current: tuple[float, float] = (0.0, 0.0)
    current_bottom: tuple[float, float] = (0.0, 0.0)
    gaps: tuple[tuple[float, float], ...] = field(default=())  # From and to: times without satellites [s]


def sides(fence: Sequence[Point]) -> list[tuple[Point, Point]]:
    """Return the sides of a fence, each from one corner to the next, the last one back to the first."""
    return list(zip(fence, (*fence[1:], *fence[:1]), strict=True))


def fence_distance(mission: Mission, places: Array) -> Array:
    """Return how far inside the fence places are: `places` (K, 2) [m]; returns (K,) [m]."""
    x, y = np.asarray(places, float).T
    if not mission.fence:
        return np.full(len(x), math.inf)
    nearest, inside = np.full(len(x), math.inf), np.zeros(len(x), bool)
    for (ax, ay), (bx, by) in sides(mission.fence):
        ex, ey = bx - ax, by - ay
        part = np.clip(((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey), 0, 1)
        nearest = np.minimum(nearest, np.hypot(x - ax - part * ex, y - ay - part * ey))
        if ey != 0:
            inside ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) / ey * ex)
    return np.where(inside, nearest, -nearest)


def cross(first: tuple[Point, Point], second: tuple[Point, Point]) -> bool:
    """Tell whether two straight lines from one point to another cross or touch."""

    def side(a: Point, b: Point, p: Point) -> float:
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])

    (a, b), (c, d) = first, second
    apart = any(max(a[k], b[k]) < min(c[k], d[k]) or max(c[k], d[k]) < min(a[k], b[k]) for k in (0, 1))
    return not apart and side(a, b, c) * side(a, b, d) <= 0 and side(c, d, a) * side(c, d, b) <= 0
