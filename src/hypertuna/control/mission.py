"""Mission: waypoints, limits and water of a dive, and the geometry of its fence."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from hypertuna.arrays import Array

TIDE = 44712.0  # s: 12.42 h, period of the Moon's semidiurnal tide
Point = tuple[float, float]  # east, north [m]


class Waypoint(NamedTuple):
    """A place to swim to, with depth and speed of the leg to it."""

    x: float  # m, east of the origin
    y: float  # m, north of the origin
    depth: float  # m below the surface
    speed: float  # m/s through the water
    radius: float  # m: distance within which it is reached
    hold: float = 0.0  # s to stay there


@dataclass(frozen=True)
class Mission:
    """A mission and its water.

    Positions are (east, north) of the origin [m]; currents are velocities of the water (east, north) [m/s].
    """

    waypoints: tuple[Waypoint, ...]  # in order; the legs are straight, the first one from the start
    start: tuple[float, float] = (0.0, 0.0)
    home: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0  # rad at the start: axis of the head from nose to tail, counter-clockwise from x (east)
    depth: float = 0.0  # m at the start
    battery: float = 1.0  # fraction of the charge at the start
    home_radius: float = 3.0  # m: distance within which the robot is home
    home_speed: float = 0.3  # m/s through the water on the way home
    fence: tuple[tuple[float, float], ...] = field(default=())  # corners, either way round; none for no fence
    depth_max: float = 5.0  # m
    reserve: float = 0.1  # fraction of the usable charge to come home with
    duration: float = 0.0  # s after which the robot should be home, 0 for no limit
    surface_every: float = 0.0  # s after a fix until it surfaces for the next; 0: only when its position is uncertain
    stay: bool = False  # surface at the last waypoint instead of going home
    silence_below: bool = False  # whether a silent ground station recalls the robot even under water
    declination: float = 0.0  # rad: angle from true to magnetic north, east positive, as the pilot knows it
    bottom: float = 20.0  # m, depth of the ground
    current: tuple[float, float] = (0.0, 0.0)  # at the surface
    current_bottom: tuple[float, float] = (0.0, 0.0)  # at the ground, linear in between
    gaps: tuple[tuple[float, float], ...] = field(default=())  # s: (start, end) without satellites
    air_pressure: float = 101325.0  # Pa, at the surface
    dip: float = math.radians(60)  # rad: angle of the magnetic field below the horizon
    field_declination: float = 0.0  # rad, true declination of the field, east positive; unknown to the pilot
    tide: tuple[float, float] = (0.0, 0.0)  # amplitude of an added current, a sine in time from 0 at the start
    tide_period: float = TIDE  # s
    gust: tuple[float, float] = (0.0, 0.0)  # strongest current of the wind, at the surface
    gust_depth: float = 1.0  # m, at which the wind's current ends
    gust_time: float = 10.0  # s between changes of the wind's strength
    cold: bool = False  # whether the satellite receiver is switched on without an almanac
    jump: float = 0.0  # m, largest jump of the fixes due to reflected signals
    jump_every: float = 0.0  # s, mean time between two jumps, 0 for no jumps
    jump_told: bool = True  # whether the accuracy that the receiver reports includes the jumps

    @property
    def course(self) -> list[Point]:
        """Points of the course: start, waypoints, and home unless the mission stays at the last waypoint [m]."""
        return [self.start, *((point.x, point.y) for point in self.waypoints), *[self.home] * (not self.stay)]

    @property
    def speeds(self) -> list[float]:
        """Speeds of the legs of the course [m/s]."""
        return [*(point.speed for point in self.waypoints), *[self.home_speed] * (not self.stay)]


def sides(fence: Sequence[Point]) -> list[tuple[Point, Point]]:
    """Return the sides of a fence, from each corner to the next; none without a fence."""
    return list(zip(fence, (*fence[1:], *fence[:1]), strict=True))


def fence_distance(mission: Mission, places: Array) -> Array:
    """Return the distances (K,) of places (K, 2) to the nearest side of the fence [m].

    Negative outside, infinite without a fence.
    """
    x, y = np.asarray(places, float).T
    if not mission.fence:
        return np.full(len(x), math.inf)
    nearest, inside = np.full(len(x), math.inf), np.zeros(len(x), bool)
    for (ax, ay), (bx, by) in sides(mission.fence):
        ex, ey = bx - ax, by - ay
        fraction = np.clip(((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey), 0, 1)
        nearest = np.minimum(nearest, np.hypot(x - ax - fraction * ex, y - ay - fraction * ey))
        if ey != 0:
            inside ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) / ey * ex)
    return np.where(inside, nearest, -nearest)


def cross(first: tuple[Point, Point], second: tuple[Point, Point]) -> bool:
    """Return whether two line segments cross or touch."""

    def side(a: Point, b: Point, p: Point) -> float:
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])

    (a, b), (c, d) = first, second
    separate = any(max(a[k], b[k]) < min(c[k], d[k]) or max(c[k], d[k]) < min(a[k], b[k]) for k in (0, 1))
    return not separate and side(a, b, c) * side(a, b, d) <= 0 and side(c, d, a) * side(c, d, b) <= 0
