"""Speed above which the fins' effect on depth is reversed by the pitch of the hull, as with stern planes."""

import math

from hypertuna import _core
from hypertuna.description.robot import Robot, require


def inversion_speed(robot: Robot) -> float:
    """Return the speed [m/s] above which fins up take a robot down; infinite if there is none.

    Fins at an angle d have the lift A U^2 (d + a), and the stern of the hull has the lift k U^2 a; the two balance at
    an incidence a. Weight and buoyancy balance the moment (mu_z - mu_t - k x) U^2 a by an angle of pitch: this is
    Munk's moment minus that of the two lifts, x apart. The path angle is pitch minus incidence. It changes its sign at
    the speed at which this moment per radian is equal to that of weight and buoyancy.
    """
    links, space, fins = robot.links, require(robot.spatial, "spatial", robot), require(robot.fins, "fins", robot)
    density = robot.water.density
    columns = zip(links.mass, space.com_height, space.volume, space.buoyancy_height, strict=True)
    righting = _core.GRAVITY * sum(density * volume * c - mass * h for mass, h, volume, c in columns)
    heave = [
        c * density * math.pi / 4 * width**2 for c, width in zip(space.added_mass_vertical, space.width, strict=True)
    ]
    munk = sum(mu * length for mu, length in zip(heave, links.length, strict=True)) - _added_along(robot)
    turning = munk - space.shedding_vertical * max(heave) * (sum(links.length) - fins.x)
    return math.sqrt(max(righting, 0.0) / turning) if turning > 0 else math.inf


def _added_along(robot: Robot) -> float:
    """Return the added mass of the straight robot along its axis [kg]."""
    links, strip, lumped = robot.links, robot.water.strip, robot.water.lumped
    if robot.model.water == "strip" and strip is not None:
        plates = [area**2 / length for area, length in zip(links.lateral_area, links.length, strict=True)]
        plate = robot.water.density * math.pi / 4
        return plate * sum(c * plate_area for c, plate_area in zip(strip.added_mass_tangential, plates, strict=True))
    if robot.model.water == "lumped" and lumped is not None:
        return sum(c * mass for c, mass in zip(lumped.added_mass, links.mass, strict=True))
    return 0.0
