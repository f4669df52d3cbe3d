"""What a robot cannot do of a mission: bounds that it would not keep, and claims that it could not make."""

import math

import numpy as np

from hypertuna.control.guidance import error_of_fixes, gait_table
from hypertuna.control.mission import Mission, fence_distance
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.robot import Robot, require
from hypertuna.errors import InputError

PILOTED = ("battery", "controller", "spatial", "fins", "guidance")  # tables of a robot that flies missions
WAY_MIN = 0.05  # m/s over ground toward home: the pilot reports less than that as `swept`
DIP = 0.5  # m that the nose dips below the surface during its first beats
OVERSHOOT = 0.3  # m that the robot may go beyond the depth that it dives to


def check_fit(robot: Robot, mission: Mission) -> None:
    """Check fence, radii and depths of a mission against what the pilot of a robot keeps, and can know."""
    pilot = require(robot.guidance, "guidance", robot)
    places = np.array([(point.x, point.y) for point in mission.waypoints]).reshape(-1, 2)
    room = fence_distance(mission, places)
    for k in np.flatnonzero(room < pilot.fence_margin)[:1]:
        rule = f"must be {pilot.fence_margin:g} m inside the fence, guidance.fence_margin_m of the robot"
        fix = "move the point inside, or enlarge the fence"
        raise InputError(rule, key=f"waypoints[{k}]", value=f"{room[k]:.3g} m inside", fix=fix)
    least = error_of_fixes(robot)
    radii = {f"waypoints[{k}].radius_m": point.radius for k, point in enumerate(mission.waypoints)}
    for key, radius in (radii | {"home.radius_m": mission.home_radius}).items():
        if radius < least:
            rule = f"must be at least {least:.2g} m, the error of the position right after fixes"
            raise InputError(rule, key=key, value=f"{radius:g}", fix="enlarge it: within less, no place can be known")
    deepest = max((point.depth for point in mission.waypoints), default=0.0)
    for need, why in ((DIP, "that the nose dips at the surface"), (deepest + OVERSHOOT, _overshoot(deepest))):
        if mission.depth_max < need:
            rule, fix = f"must be at least {need:g} m, {why}", "allow more depth, or move the waypoints up"
            raise InputError(rule, key="limits.depth_m", value=f"{mission.depth_max:g}", fix=fix)


def _overshoot(deepest: float) -> str:
    return f"{OVERSHOOT:g} m below the deepest waypoint at {deepest:g} m"


def check_current(robot: Robot, mission: Mission, added: float = 0.0) -> None:
    """Check that a robot comes home against the current [m/s] at the surface and at its deepest waypoint.

    `added` is the maximum speed of a randomized current.
    """
    require_at_sea(robot, *PILOTED)
    fastest = gait_table(robot).speed[-1]
    part = max((point.depth for point in mission.waypoints), default=0.0) / mission.bottom
    deep = [
        above + part * (below - above) for above, below in zip(mission.current, mission.current_bottom, strict=True)
    ]
    strongest = max(math.hypot(*mission.current), math.hypot(*deep)) + added
    if strongest > fastest - WAY_MIN:
        rule = f"must be at most {fastest - WAY_MIN:.3g} m/s for a robot that swims at {fastest:.3g} m/s"
        fix = "wait for less current" if not added else "wait for less current, or reduce scatter.current_m_s"
        raise InputError(rule, key="water.current_m_s", value=f"{strongest:.3g} m/s in all", fix=fix)
