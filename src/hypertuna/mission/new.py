"""Write a first mission for a robot: a square that suits its speed, turning radius, fixes and depth limit."""

import math

from hypertuna.control.guidance import curvature, error_of_fixes, gait_table
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.commented import commented
from hypertuna.description.robot import Robot, require, robots
from hypertuna.errors import InputError
from hypertuna.mission.checks import OVERSHOOT, PILOTED, deepest_limit
from hypertuna.mission.file import parse_mission
from hypertuna.mission.schema import Document

BELOW_FASTEST = 0.86  # fraction of the fastest gait's speed; the rest is kept for currents
LEG = 60.0  # s per side, so that dead reckoning between two fixes stays within the radius
SIDE_MIN, DEPTH, MARGIN = 10.0, 1.0, 30.0  # m: shortest side, depth, distance from the square to the fence
TIME_FACTOR, EXTRA_TIME = 3.0, 600.0  # time limit: multiple of the course's time, plus s, for fixes at the surface

HEADER = """\
# A square for {robot}, written by `hypertuna mission new`.
# Speed: {part:.0%} of the fastest gait's {fastest:.3g} m/s. Side: a minute to swim, so that fixes come often enough.
# Radius: right after fixes the position is known to {error:.2g} m. The robot turns within {turn:.2g} m.
"""
HINTS = {
    "start": "For GPX, and for places in degrees, add [origin] with latitude_deg and longitude_deg of x = y = 0.",
    "water": "Correct the depth of the ground, and state the current that you expect.",
}


def spelled(robot: Robot) -> str:
    """Return how a mission file names the robot: by name if it comes with hypertuna, by path otherwise."""
    return robot.name if robot.file == f"robots/{robot.name}.toml" and robot.name in robots() else robot.file


def usual_speed(robot: Robot) -> float:
    """Return a speed through the water [m/s] that leaves some reserve against currents."""
    return round(BELOW_FASTEST * gait_table(robot).speed[-1], 3)


def usual_radius(robot: Robot) -> float:
    """Return a radius of waypoints [m] that is larger than the position error right after fixes."""
    return max(3.0, math.ceil(15 * error_of_fixes(robot)) / 10)


def new_mission(robot: Robot, name: str) -> str:
    """Return the text of a mission file that a robot can swim."""
    require_at_sea(robot, *PILOTED)
    table, pilot = gait_table(robot), require(robot.guidance, "guidance", robot)
    speed, radius, length = usual_speed(robot), usual_radius(robot), sum(robot.links.length)
    turn = 1 / curvature(robot, table, pilot.bias_max)
    side = float(max(SIDE_MIN, round(LEG * table.speed[-1]), math.ceil(6 * turn)))
    limit = min(round(DEPTH + max(1.0, length), 1), deepest_limit(robot))
    depth = min(DEPTH, math.floor(round(10 * (limit - OVERSHOOT), 6)) / 10)
    if depth <= 0:
        rule, fix = f"must be more than {OVERSHOOT:g} m", "correct firmware.depth_max_m, or the depth sensor"
        raise InputError(rule, file=robot.file, key="the largest depth", value=f"{limit:g} m", fix=fix)
    shared = {"depth_m": depth, "speed_m_s": speed, "radius_m": radius}
    low, high = -MARGIN, side + MARGIN
    document = {
        "format": 1,
        "name": name,
        "description": f"a square of {side:g} m at a depth of {depth:g} m",
        "robot": spelled(robot),
        "start": {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0},
        "waypoints": [{"x_m": x, "y_m": y, **shared} for x, y in ((0.0, side), (side, side), (side, 0.0), (0.0, 0.0))],
        "home": {"radius_m": radius, "speed_m_s": speed},
        "water": {"bottom_m": max(6.0, 2 * limit), "current_m_s": 0.0, "current_deg": 0.0},
        "limits": {
            "fence_m": [[low, low], [high, low], [high, high], [low, high]],
            "depth_m": limit,
            "battery": 0.2,
            "duration_s": 60.0 * math.ceil((TIME_FACTOR * 4 * side / speed + EXTRA_TIME) / 60),
        },
    }
    parse_mission(document)  # its name, which is that of the file, may be none of a mission
    header = HEADER.format(
        robot=robot.name, part=BELOW_FASTEST, fastest=table.speed[-1], error=error_of_fixes(robot), turn=turn
    )
    return header + commented(document, Document, hints=HINTS)
