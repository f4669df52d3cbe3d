"""Constants of the pilot on board, computed from the robot's description.

The equations are in core attitude.hpp, estimator.hpp, steering.hpp and guidance.hpp; docs/pilot.md derives them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.actuation.battery import battery_columns, range_of
from hypertuna.arrays import rounded_number
from hypertuna.control.controller import controller_columns, given_constants, sensor_range
from hypertuna.control.mission import Mission
from hypertuna.control.sensors import STANDARD_AIR, sensor_of
from hypertuna.description.at_sea import antenna_of
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.control import Guidance
from hypertuna.description.twin import require_controller
from hypertuna.errors import InputError
from hypertuna.swimming.gait import Gait, lags, named_gait
from hypertuna.swimming.model import core_model
from hypertuna.swimming.swim import settled_speed, swim

AIR_PRESSURE = (50e3, 108.5e3)  # Pa: range of air pressures, from the highest lakes to the strongest anticyclone
DEPTH_STEP = 0.5  # m, largest change of a working depth sensor within a tick
FIELD_BAND = (0.5, 1.5)  # fractions of the field's strength between which a compass reading is no fault
FIX_MARGIN = 1.2  # position error that suffices at the surface, over the error after some ten fixes
STEER_FRACTION = 0.5  # fraction of the largest tail bias at which the curvature of the path is computed


@dataclass(frozen=True)
class GaitTable:
    """Gaits of increasing speed and frequency, between which the pilot interpolates."""

    gaits: tuple[Gait, ...]
    speed: tuple[float, ...]  # speed of each gait through the water [m/s]


def gait_table(robot: Robot, gaits: Sequence[Gait] = (), speed: Sequence[float] = ()) -> GaitTable:
    """Return a robot's gait table, from given gaits or from the named gaits in ``[guidance]``.

    Speeds [m/s] default to those of ``[guidance]``, then to the settled beats with the joints' bandwidth.
    """
    if not gaits:
        guidance = require(robot.guidance, "guidance", robot)
        gaits, speed = [named_gait(robot, name) for name in guidance.gaits], speed or guidance.speed or ()
    if not speed:
        speed = [settled_speed(robot, gait) for gait in gaits]
    table = GaitTable(tuple(gaits), tuple(float(value) for value in speed))
    _check_table(table)
    return table


def _check_table(table: GaitTable) -> None:
    """Check that speed and frequency increase from gait to gait, so that each speed has one gait."""
    if not 1 <= len(table.gaits) <= _core.MAX_GAITS:
        rule, fix = f"must have 1 to {_core.MAX_GAITS} gaits", "omit some: gaits between two of them are interpolated"
        raise InputError(rule, key="guidance.gaits", value=f"{len(table.gaits)}", fix=fix)
    if len(table.speed) != len(table.gaits):
        rule, fix = "must have one speed per gait", "give a speed per gait, or none"
        raise InputError(rule, key="guidance.speed_m_s", value=f"{len(table.speed)}", fix=fix)
    frequency = tuple(gait.frequency for gait in table.gaits)
    for column, unit, values in (("speed", "m/s", table.speed), ("frequency", "Hz", frequency)):
        if not all(a < b for a, b in zip([0.0, *values], values, strict=False)):
            rule, fix = f"must increase in {column} from gait to gait", "choose other gaits, slowest first"
            value = f"{', '.join(f'{v:.4g}' for v in values)} {unit}"
            raise InputError(rule, key="guidance.gaits", value=value, fix=fix)


def glide(robot: Robot) -> float:
    """Return the distance [m] in which the gliding body slows to 1/e: mass and added mass over drag / speed^2."""
    at_rest = np.zeros((1, len(robot.links.name), 3))
    motion = _core.dynamics(core_model(robot), at_rest, np.array([[-1.0, 0.0, 0.0]]))
    return rounded_number(1 / abs(float(motion["acceleration"][0, 0])))


def curvature(robot: Robot, table: GaitTable, bias: Sequence[float]) -> float:
    """Return the path's curvature [1/m] in the middle gait with a tail bias [rad] of each joint group.

    It is extrapolated linearly from the rate of turn over speed at `STEER_FRACTION` of the bias.
    """
    gait = table.gaits[len(table.gaits) // 2]
    turning = swim(robot, replace(gait, bias=tuple(STEER_FRACTION * value for value in bias)))
    if not turning.settled:
        rule, fix = "must let the robot swim steadily", "choose a smaller bias"
        raise InputError(rule, key="guidance.bias_max_deg", value=turning.status_text, fix=fix)
    return rounded_number(abs(turning.turn_rate / turning.speed) / STEER_FRACTION)


def pilot_columns(robot: Robot, table: GaitTable | None = None) -> dict[str, list[float]]:
    """Return the constants of a robot's pilot, without its controller's, by their names in core pilot.hpp."""
    pilot = require(robot.guidance, "guidance", robot)
    control = require_controller(robot)
    table = gait_table(robot) if table is None else table
    ticks = control.rate / pilot.decisions
    if ticks < 1 or abs(ticks - round(ticks)) > 1e-9 * ticks:
        rule, fix = f"must divide controller.rate_hz = {control.rate:g}", f"choose for example {control.rate / 10:g}"
        raise InputError(rule, file=robot.file, key="guidance.decisions_hz", value=f"{pilot.decisions:g}", fix=fix)
    joints = {"bias_max": list(pilot.bias_max), "bend_max": controller_columns(robot)["reach"]}
    values = {
        "every": round(ticks),
        "tick": 1 / control.rate,
        "period": 1 / pilot.decisions,
        "glide": glide(robot),
        "curvature": curvature(robot, table, pilot.bias_max),
        "fin_angle_max": control.fin_max,
        **_plain(pilot),
        **_sensed(robot),
        **_battery(robot, pilot, table),
    }
    return {
        **{name: [float(value)] for name, value in values.items()},
        **joints,
        "gaits": [float(len(table.gaits))],
        "speed": list(table.speed),
        "frequency": [gait.frequency for gait in table.gaits],
        "swing": [value for gait in table.gaits for value in gait.amplitude],
        "lag": [lag for gait in table.gaits for lag in lags(gait)],
    }


def depth_tolerance(pilot: Guidance) -> float:
    """Return the difference in depth [m] within which a waypoint counts as reached."""
    return 2 * pilot.surface_depth


def error_of_fixes(robot: Robot) -> float:
    """Return the error [m] of the mean of several fixes: their common offset and their averaged noise."""
    position = sensor_of(robot, "position")
    return FIX_MARGIN * math.hypot(position.bias, position.noise / 3)


def _plain(pilot: Guidance) -> dict[str, float]:
    """Return the pilot's constants that depend on the table [guidance] alone."""
    return given_constants("pilot", pilot) | {
        **{name: rounded_number(math.sin(getattr(pilot, name))) for name in ("fin_tilt", "pitch_max", "climb_max")},
        "depth_tolerance": depth_tolerance(pilot),
        "arrival_timeout": pilot.retry,
        # At the surface depth the antenna may still be wet: fixes come from up to twice that depth.
        "fix_depth": 2 * pilot.surface_depth,
        "fix_error_max": pilot.error_max,
    }


def _sensed(robot: Robot) -> dict[str, float]:
    """Return ranges and errors of the pilot's sensors, by name."""
    position, depth = sensor_of(robot, "position"), sensor_range(robot, "depth")
    # Depth sensors are calibrated at the standard atmosphere, so at other air pressures the surface reads these depths.
    air_depths = [(pressure - STANDARD_AIR) / (robot.water.density * _core.GRAVITY) for pressure in AIR_PRESSURE]
    antenna = antenna_of(robot)
    return {
        "rate_max": sensor_range(robot, "rate")[1],
        "acceleration_max": sensor_range(robot, "acceleration")[1],
        "field_low": FIELD_BAND[0],
        "field_high": FIELD_BAND[1],
        "depth_low": depth[0],
        "depth_high": depth[1],
        "depth_step": DEPTH_STEP,
        "depth_repeat": sensor_of(robot, "depth").hidden_change,
        "field_repeat": sensor_of(robot, "field").hidden_change,
        "air_low": air_depths[0],
        "air_high": air_depths[1],
        "antenna_x": antenna[0],
        "antenna_z": antenna[1],
        "fix_noise": position.noise,
        "fix_offset": position.bias,
        "error_fix": error_of_fixes(robot),
    }


def _battery(robot: Robot, pilot: Guidance, table: GaitTable) -> dict[str, float]:
    """Return open-circuit voltage at empty and its span [V], voltage drop under load [V], and endurance [s]."""
    row, usable = battery_columns(robot), require(robot.battery, "battery", robot).usable
    voltage_span = row["full"] - row["empty"]
    mean_voltage, load = row["empty"] + 0.5 * voltage_span, pilot.power + row["efficiency"] * row["electronics"]
    return {
        "battery_empty": row["empty"] + (1 - usable) * voltage_span,
        "battery_span": usable * voltage_span,
        "battery_drop": row["resistance"] * load / (row["efficiency"] * mean_voltage),
        "endurance": range_of(robot, power=pilot.power, speed=table.speed[-1]).endurance,
    }


def mission_columns(mission: Mission) -> dict[str, Any]:
    """Return a mission by the names in core mission.hpp: ``waypoints`` (n, 5), ``hold`` (n,), ``fence`` (n, 2)."""
    names = dict.fromkeys(name for part, name, _ in _core.onboard_fields(1, 1) if part == "mission")
    return {
        **{name: np.ravel(np.array(getattr(mission, name), dtype=np.float64)).tolist() for name in names},
        "waypoints": np.array([point[:5] for point in mission.waypoints], dtype=np.float64).reshape(-1, 5),
        "hold": np.array([point.hold for point in mission.waypoints], dtype=np.float64),
        "fence": np.array(mission.fence, dtype=np.float64).reshape(-1, 2),
    }
