"""Sea: current, bottom and magnetic field around a robot, and the core's columns of sea and robot in space."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.control.sensors import STANDARD_AIR
from hypertuna.description.at_sea import antenna_of
from hypertuna.description.robot import Robot, require
from hypertuna.errors import InputError, shown
from hypertuna.ranges import FINITE, POSITIVE, Range

DIP = math.radians(60)  # typical angle of the Earth's magnetic field below the horizon at temperate latitudes
BOTTOM_RATE = 2 * math.pi * 10  # rad/s: natural frequency of the robot on the bottom, which acts as a stiff spring
AIR = Range(min=30e3, max=110e3, unit="Pa")  # air pressure, from the highest lakes to the strongest anticyclone
MAX_CURRENT = 10.0  # m/s
# By name of the core's column of a link in space: attribute of the table [spatial].
LINKS = {name: name for name in ("com_height", "volume", "height", "width", "drag_vertical", "drag_roll")}
LINKS |= {"center": "buoyancy_center", "center_height": "buoyancy_height", "added_vertical": "added_mass_vertical"}


@dataclass(frozen=True)
class Sea:
    """Current, bottom and magnetic field around a robot; the still surface is at depth zero."""

    current: tuple[float, float] = (0.0, 0.0)  # velocity of the water at the surface toward east and north [m/s]
    current_bottom: tuple[float, float] | None = None  # at the bottom, linear between [m/s]; None: uniform
    bottom: float = math.inf  # depth of the bottom [m]
    dip: float = DIP  # angle of the magnetic field below the horizon [rad]
    declination: float = 0.0  # angle of the magnetic field east of north [rad]
    air_pressure: float = STANDARD_AIR  # at the surface [Pa]

    def __post_init__(self) -> None:
        for key in ("current", "current_bottom"):
            values = getattr(self, key)
            if values is not None:
                object.__setattr__(self, key, _current(key, values))
        if not (isinstance(self.bottom, float) and self.bottom == math.inf):
            POSITIVE.check(self.bottom, "bottom", "give the depth in m, or omit it for deep water")
        for key in ("dip", "declination"):
            FINITE.check(getattr(self, key), key, "give the angle in radians")
        AIR.check(self.air_pressure, "air_pressure", "give the pressure in Pa")
        if self.current_bottom is not None and not math.isfinite(self.bottom):
            rule, fix = "needs the depth of the bottom", "give it in m"
            raise InputError(rule, key="current_bottom", fix=fix)

    @property
    def shear(self) -> tuple[float, float]:
        """Rate of change of the current with depth, toward east and north [1/s]."""
        if self.current_bottom is None:
            return (0.0, 0.0)
        east, north = (
            (deep - high) / self.bottom for deep, high in zip(self.current_bottom, self.current, strict=True)
        )
        return (east, north)


def _current(key: str, values: Any) -> tuple[float, float]:
    """Check that a current is two finite numbers, toward east and north [m/s], and return it."""
    fix = "give the velocities toward east and north in m/s"
    try:
        east, north = (FINITE.check(value, key, fix) for value in values)
    except (TypeError, ValueError):
        raise InputError("must be two numbers", key=key, value=shown(values), fix=fix) from None
    if math.hypot(east, north) > MAX_CURRENT:
        raise InputError(f"must be at most {MAX_CURRENT:g} m/s", key=key, value=shown(values), fix=fix)
    return (east, north)


def world_at_sea(robot: Robot, sea: Sea, gaps: Sequence[tuple[float, float]] = ()) -> _core.World:
    """Return the core's world around a robot at sea; gaps: (start, end) [s] of times without satellites."""
    space_columns(robot)  # raises where a table is missing
    return _core.World(world_columns(robot, sea, gaps))


def world_columns(robot: Robot, sea: Sea, gaps: Sequence[tuple[float, float]] = ()) -> dict[str, Any]:
    """Return the core's columns of the world at sea; gaps: (start, end) [s] of times without satellites."""
    return sea_columns(robot, sea) | {"gaps": np.array(gaps, dtype=np.float64).reshape(-1, 2)}


def sea_columns(robot: Robot, sea: Sea) -> dict[str, Any]:
    """Return the core's columns of water, bottom and magnetic field around a robot at sea."""
    east, north = sea.shear
    numbers = {
        "density": robot.water.density,
        "current_east": sea.current[0],
        "current_north": sea.current[1],
        "shear_east": east,
        "shear_north": north,
        "bottom": sea.bottom,
        "stiffness": sum(robot.links.mass) * BOTTOM_RATE**2,
        "field_east": math.cos(sea.dip) * math.sin(sea.declination),
        "field_north": math.cos(sea.dip) * math.cos(sea.declination),
        "field_up": -math.sin(sea.dip),
        "air": sea.air_pressure,
    }
    return {f"sea.{name}": value for name, value in numbers.items()}


def space_columns(robot: Robot) -> dict[str, Any]:
    """Return the core's columns of the body in space: links, fins, vortex shedding, antenna."""
    links, fins = link_bodies(robot), require(robot.fins, "fins", robot)
    return {
        **{f"link.{name}": values for name, values in links.items()},
        **{f"fin.{name}": getattr(fins, name) for name in type(fins).model_fields},
        "shedding": require(robot.spatial, "spatial", robot).shedding_vertical,
        "antenna": antenna_of(robot)[1],
    }


def ellipsoid_inertia(mass: Any, *diameters: Any) -> Any:
    """Return the moment of inertia of an ellipsoid about an axis, from its mass and its diameters across the axis."""
    return mass * sum(diameter**2 for diameter in diameters) / 20


def link_bodies(robot: Robot) -> dict[str, Array]:
    """Return the columns of the links in space, with the moments of inertia of an ellipsoid if none are given."""
    spatial = require(robot.spatial, "spatial", robot)
    links = {name: np.array(getattr(spatial, field)) for name, field in LINKS.items()}
    mass, length = np.array(robot.links.mass), np.array(robot.links.length)
    height, width = links["height"], links["width"]
    roll, pitch = (ellipsoid_inertia(mass, diameter, height) for diameter in (width, length))
    return links | {
        "roll": roll if spatial.inertia_roll is None else np.array(spatial.inertia_roll),
        "pitch": pitch if spatial.inertia_pitch is None else np.array(spatial.inertia_pitch),
    }
