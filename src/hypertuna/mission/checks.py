"""Check whether a robot can fly a mission: fence, radii, depths and current."""

import math
from itertools import pairwise

import numpy as np

from hypertuna.actuation.battery import range_of
from hypertuna.control.controller import sensor_range
from hypertuna.control.guidance import error_of_fixes, gait_table
from hypertuna.control.mission import Mission, fence_distance
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.robot import Robot, require
from hypertuna.errors import InputError

PILOTED = ("battery", "controller", "spatial", "fins", "guidance")  # tables that a robot needs to fly missions
GROUND_SPEED_MIN = 0.05  # m/s toward home over ground; the pilot reports a lower speed as `swept`
SPEED_MIN = 0.1  # m/s: GROUND_SPEED_MIN plus the error of the velocity over ground with which the pilot decides
NOSE_DIP = 0.5  # m: depth to which the nose dips during the first beats at the surface
OVERSHOOT = 0.3  # m by which the robot may exceed the depth that it dives to
FIX_FACTOR, FIX_TIME = (
    2.0,
    60.0,
)  # a mission with its fixes takes this multiple of the course's time, plus this time [s]


def check_fit(robot: Robot, mission: Mission) -> None:
    """Check fence, radii and depths of a mission against the limits and the position error of a robot's pilot."""
    pilot = require(robot.guidance, "guidance", robot)
    places = np.array([(point.x, point.y) for point in mission.waypoints]).reshape(-1, 2)
    margins = fence_distance(mission, places)
    for k in np.flatnonzero(margins < pilot.fence_margin)[:1]:
        rule = f"must be at least {pilot.fence_margin:g} m inside the fence (guidance.fence_margin_m of the robot)"
        fix = "move the point inside, or enlarge the fence"
        raise InputError(rule, key=f"waypoints[{k}]", value=f"{margins[k]:.3g} m inside", fix=fix)
    smallest_radius = error_of_fixes(robot)
    radii = {f"waypoints[{k}].radius_m": point.radius for k, point in enumerate(mission.waypoints)}
    for key, radius in (radii | {"home.radius_m": mission.home_radius}).items():
        if radius < smallest_radius:
            rule = f"must be at least {smallest_radius:.2g} m, the uncertainty of the position right after fixes"
            raise InputError(rule, key=key, value=f"{radius:g}", fix="enlarge it: no robot knows its place better")
    deepest = max((point.depth for point in mission.waypoints), default=0.0)
    for bound, why in (
        (NOSE_DIP, "because the nose dips that far at the surface"),
        (deepest + OVERSHOOT, _overshoot(deepest)),
    ):
        if mission.depth_max < bound:
            rule, fix = f"must be at least {bound:g} m, {why}", "allow more depth, or move the waypoints up"
            raise InputError(rule, key="limits.depth_m", value=f"{mission.depth_max:g}", fix=fix)
    if mission.depth_max > (limit := deepest_limit(robot)):
        rule, fix = f"must be at most {limit:g} m, the limit of the robot's hull or depth sensor", "reduce the limit"
        raise InputError(rule, key="limits.depth_m", value=f"{mission.depth_max:g}", fix=fix)


def warnings_of(robot: Robot, mission: Mission) -> list[str]:
    """Return warnings about a mission that will be slow, or will end before all waypoints are reached."""
    pilot, fastest = require(robot.guidance, "guidance", robot), gait_table(robot).speed[-1]
    course, top_speed, warnings = course_time(mission, fastest), max(mission.speeds), []
    if top_speed > fastest:
        warnings.append(f"the mission commands {top_speed:.3g} m/s, but the fastest gait reaches {fastest:.3g} m/s")
    if fastest < SPEED_MIN:
        warnings.append(
            f"the fastest gait reaches {fastest:.3g} m/s: below {SPEED_MIN:g} m/s the pilot cannot tell whether "
            "a current sweeps the robot away"
        )
    if 0 < mission.duration < FIX_FACTOR * course + FIX_TIME:
        warnings.append(
            f"the course takes {course:.0f} s, and waits for fixes often double that; limits.duration_s is "
            f"{mission.duration:g} s, so the pilot may turn home before the last waypoint"
        )
    reserve = 1 - mission.battery + mission.reserve
    if reserve >= 1:
        warnings.append("the battery starts at its reserve, limits.battery: the pilot turns home at once")
    elif (battery_time := range_of(robot, power=pilot.power, speed=fastest, reserve=reserve).endurance) < course:
        warnings.append(f"the course takes {course:.0f} s, but the charge above the reserve lasts {battery_time:.0f} s")
    return warnings


def course_time(mission: Mission, fastest: float) -> float:
    """Return the time [s] that the course takes at its speeds, limited to `fastest` [m/s], in its current."""
    total = 0.0
    depths = [*(point.depth for point in mission.waypoints), *[0.0] * (not mission.stay)]
    for (begin, end), commanded, depth in zip(pairwise(mission.course), mission.speeds, depths, strict=True):
        distance, speed = math.dist(begin, end), min(commanded, fastest)
        if distance == 0:
            continue
        east, north = (end[0] - begin[0]) / distance, (end[1] - begin[1]) / distance
        current = _current_at(mission, depth)
        across = current[0] * north - current[1] * east
        ahead = math.sqrt(max(speed**2 - across**2, 0.0)) + current[0] * east + current[1] * north
        total += distance / max(ahead, GROUND_SPEED_MIN)
    return total


def _current_at(mission: Mission, depth: float) -> tuple[float, float]:
    """Return the current toward east and north [m/s] at a depth [m]."""
    fraction = min(depth / mission.bottom, 1.0)
    (east, north), (deep_east, deep_north) = mission.current, mission.current_bottom
    return east + fraction * (deep_east - east), north + fraction * (deep_north - north)


def deepest_limit(robot: Robot) -> float:
    """Return the largest depth limit [m] that a robot accepts: that of its hull or of its depth sensor's range."""
    firmware = robot.firmware
    return min(sensor_range(robot, "depth")[1], math.inf if firmware is None else firmware.depth_max)


def _overshoot(deepest: float) -> str:
    return f"{OVERSHOOT:g} m below the deepest waypoint at {deepest:g} m"


def check_current(robot: Robot, mission: Mission, added: float = 0.0) -> None:
    """Check that a robot can swim home against the current [m/s] at the surface and at its deepest waypoint.

    `added` is the maximum speed of a randomized current.
    """
    require_at_sea(robot, *PILOTED)
    fastest = gait_table(robot).speed[-1]
    at_depth = _current_at(mission, max((point.depth for point in mission.waypoints), default=0.0))
    strongest = max(math.hypot(*mission.current), math.hypot(*at_depth)) + added
    if strongest > fastest - GROUND_SPEED_MIN:
        rule = f"must be at most {fastest - GROUND_SPEED_MIN:.3g} m/s for a robot that swims at {fastest:.3g} m/s"
        fix = "wait for less current" if not added else "wait for less current, or reduce scatter.current_m_s"
        raise InputError(rule, key="water.current_m_s", value=f"{strongest:.3g} m/s in all", fix=fix)
