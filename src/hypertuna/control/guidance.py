"""The pilot on board as the core takes it: what a robot's description makes of its constants.

The equations stand in core attitude.hpp, estimator.hpp, steering.hpp and guidance.hpp; docs/pilot.md derives them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.actuation.battery import battery_columns, range_of
from hypertuna.control.controller import controller_columns, sensor_range
from hypertuna.control.mission import Mission
from hypertuna.control.sensors import sensor_of
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.guidance import Guidance
from hypertuna.errors import InputError
from hypertuna.swimming.gait import Gait, named_gait
from hypertuna.swimming.model import core_model
from hypertuna.swimming.swim import swim

__all__ = ["GaitTable", "gait_table", "glide", "mission_columns", "pilot_columns"]

Array = NDArray[np.float64]

DEPTH_STEP = 0.5  # m: a sound depth sensor changes by less within a tick
FIELD_BAND = (0.5, 1.5)  # of the field's strength: weaker or stronger is no compass
STEER = 0.5  # of the tail bias at which the curvature of the path is taken


@dataclass(frozen=True)
class GaitTable:
    """Gaits by rising speed and frequency: what the pilot chooses its beat from.

    Parameters
    ----------
    gaits : tuple of Gait
    speed : tuple of float
        Through the water, of each [m/s].
    """

    gaits: tuple[Gait, ...]
    speed: tuple[float, ...]


def gait_table(robot: Robot, gaits: Sequence[Gait] = (), speed: Sequence[float] = ()) -> GaitTable:
    """Make the gait table of a robot.

    Parameters
    ----------
    robot : Robot
        With the table ``[guidance]``, unless gaits are given.
    gaits : sequence of Gait, optional
        Such as `optimize` finds; the named gaits of ``[guidance]`` if left out.
    speed : sequence of float, optional
        Through the water, of each [m/s]; if left out what ``[guidance]`` says of its gaits, or the speed of the settled
        beat of joints that lag by their bandwidth.

    Returns
    -------
    GaitTable

    Raises
    ------
    InputError
        If there are too many gaits, or speed or frequency do not rise from each to the next.
    """
    if not gaits:
        guidance = require(robot.guidance, "guidance", robot)
        gaits = [named_gait(robot, name) for name in guidance.gaits]
        speed = speed or guidance.speed or ()
    if not speed:
        lagging = all(group.bandwidth is not None for group in robot.joints)
        swimmer = robot.using(joints="bandwidth") if lagging else robot
        speed = [swim(swimmer, gait).speed for gait in gaits]
    table = GaitTable(tuple(gaits), tuple(float(value) for value in speed))
    _check_table(table)
    return table


def _check_table(table: GaitTable) -> None:
    """Refuse a table that no speed can be looked up in."""
    most = _core.MOST_GAITS
    if not 1 <= len(table.gaits) <= most:
        rule, fix = f"must have 1 to {most} gaits", "leave some out: between two of them everything is linear"
        raise InputError(rule, key="guidance.gaits", value=f"{len(table.gaits)}", fix=fix)
    if len(table.speed) != len(table.gaits):
        rule, fix = "must have one speed per gait", "give a speed per gait, or none"
        raise InputError(rule, key="guidance.speed_m_s", value=f"{len(table.speed)}", fix=fix)
    for what, unit, values in (
        ("speed", "m/s", table.speed),
        ("frequency", "Hz", [gait.frequency for gait in table.gaits]),
    ):
        if not all(a < b for a, b in zip([0.0, *values], values, strict=False)):
            told = ", ".join(f"{value:.4g}" for value in values)
            rule, fix = f"must rise in {what} from gait to gait", "choose other gaits, slowest first"
            raise InputError(rule, key="guidance.gaits", value=f"{told} {unit}", fix=fix)


def glide(robot: Robot) -> float:
    """Compute the way in which a robot that does not beat slows to 1/e.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    float
        Mass with added mass over quadratic drag of the straight body [m].
    """
    links = len(robot.links.name)
    still = np.zeros((1, links, 3))
    found = _core.dynamics(core_model(robot), still, np.array([[-1.0, 0.0, 0.0]]))
    return 1 / abs(float(found["acceleration"][0, 0]))


def curvature(robot: Robot, table: GaitTable, bias: Sequence[float]) -> float:
    """Compute how strongly the path bends at the whole tail bias, by the middle gait of the table.

    Parameters
    ----------
    robot : Robot
    table : GaitTable
    bias : sequence of float
        Of each joint group [rad].

    Returns
    -------
    float
        Rate of turn over speed [1/m], taken at half of it.
    """
    gait = table.gaits[len(table.gaits) // 2]
    turning = swim(robot, replace(gait, bias=tuple(STEER * value for value in bias)))
    if not turning.settled:
        rule, fix = "must let the robot swim steadily", "choose less"
        raise InputError(rule, key="guidance.bias_max_deg", value=turning.status_text, fix=fix)
    return abs(turning.turn_rate / turning.speed) / STEER


def pilot_columns(robot: Robot, table: GaitTable | None = None) -> dict[str, list[float]]:
    """Compute the constants of a robot's pilot, but for its controller's.

    Parameters
    ----------
    robot : Robot
        With the tables of the controller, ``[guidance]``, ``[battery]`` and ``[[sensors]]`` of every quantity.
    table : GaitTable, optional
        `gait_table` of the robot if left out.

    Returns
    -------
    dict of str to list of float
        As core pilot.hpp names them.

    Raises
    ------
    InputError
        If a table is missing, or a value does not fit another.
    """
    pilot = require(robot.guidance, "guidance", robot)
    control = require(robot.controller, "controller", robot)
    table = gait_table(robot) if table is None else table
    every = control.rate / pilot.decisions
    if every < 1 or abs(every - round(every)) > 1e-9 * every:
        rule, fix = f"must divide controller.rate_hz = {control.rate:g}", f"choose for example {control.rate / 10:g}"
        raise InputError(rule, file=robot.file, key="guidance.decisions_hz", value=f"{pilot.decisions:g}", fix=fix)
    controller = controller_columns(robot)
    joints = {"bias_most": list(pilot.bias_max), "bend_most": controller["reach"]}
    values = {
        "every": round(every),
        "tick": 1 / control.rate,
        "period": 1 / pilot.decisions,
        "glide": glide(robot),
        "curvature": curvature(robot, table, pilot.bias_max),
        "fin_angle_most": control.fin_max,
        **_plain(pilot),
        **_sensed(robot),
        **_battery(robot, pilot, table),
    }
    return {**{name: [float(value)] for name, value in values.items()}, **joints, **_table_columns(table)}


def _table_columns(table: GaitTable) -> dict[str, list[float]]:
    """Write the gait table for the core: phases as lags behind the first joint group."""
    return {
        "gaits": [float(len(table.gaits))],
        "speed": list(table.speed),
        "frequency": [gait.frequency for gait in table.gaits],
        "swing": [value for gait in table.gaits for value in gait.amplitude],
        "lag": [math.remainder(p - gait.phase[0], 2 * math.pi) for gait in table.gaits for p in gait.phase],
    }


def _plain(pilot: Guidance) -> dict[str, float]:
    """Return what the core takes from the table as it stands."""
    names = (
        "gravity_rate field_rate depth_rate position_walk current_walk current_error factor_error factor_walk "
        "start_error heading_rate rate_gain heading_integral lookahead depth_lookahead depth_integral "
        "climb_lead climb_gain pitch_gain pitch_damping "
        "surface_depth fence_margin error_near error_lost drift_error_max fix_timeout retry compass_timeout "
        "fin_min fin_after single_fin_max response_time response_depth blind_fin overhead"
    )
    values = {name: float(getattr(pilot, name)) for name in names.split()}
    sines = {name: math.sin(getattr(pilot, name)) for name in ("fin_tilt",)}
    return {
        **values,
        **sines,
        "pitch_most": math.sin(pilot.pitch_max),
        "climb_most": math.sin(pilot.climb_max),
        "drift_most": pilot.drift_max,
        "turn_most": pilot.turn_max,
        "speed_least": pilot.speed_min,
        "error_most": pilot.error_max,
        "lost_after": pilot.sensor_timeout,
        "slow": pilot.blind_speed,
        # Where it counts as at the surface its antenna may still be wet: a fix comes from twice that depth at most.
        "fix_depth": 2 * pilot.surface_depth,
    }


def _sensed(robot: Robot) -> dict[str, float]:
    """Return what the pilot knows of its sensors."""
    position = sensor_of(robot, "position")
    depth_low, depth_high = sensor_range(robot, "depth")
    return {
        "rate_most": sensor_range(robot, "rate")[1],
        "acceleration_most": sensor_range(robot, "acceleration")[1],
        "field_low": FIELD_BAND[0],
        "field_high": FIELD_BAND[1],
        "depth_low": depth_low,
        "depth_high": depth_high,
        "depth_step": DEPTH_STEP,
        "fix_noise": position.noise,
        "fix_offset": position.bias,
    }


def _battery(robot: Robot, pilot: Guidance, table: GaitTable) -> dict[str, float]:
    """Return open-circuit voltages of the usable charge, their drop under load, and how long that lasts."""
    columns = battery_columns(robot)
    at = dict(zip(columns.columns, columns.values.tolist(), strict=True))
    battery = require(robot.battery, "battery", robot)
    span = at["full"] - at["empty"]
    middle = at["empty"] + 0.5 * span
    return {
        "battery_empty": at["empty"] + (1 - battery.usable) * span,
        "battery_span": battery.usable * span,
        "battery_drop": at["resistance"] * pilot.power / (at["efficiency"] * middle),
        "endurance": range_of(robot, power=pilot.power, speed=table.speed[-1]).endurance,
    }


def mission_columns(mission: Mission) -> dict[str, Any]:
    """Write a mission for the core.

    Parameters
    ----------
    mission : Mission

    Returns
    -------
    dict
        Columns by the names of core mission.hpp, ``waypoints`` (n, 5) and ``fence`` (corners, 2).
    """
    scalars = ("home_radius", "home_speed", "reserve", "duration", "surface_every")
    columns = {name: [float(getattr(mission, name))] for name in scalars}
    columns |= {"start": list(mission.start), "home": list(mission.home), "stay": [float(mission.stay)]}
    columns["depth_most"] = [float(mission.depth_max)]
    return {
        **columns,
        "waypoints": np.array(mission.waypoints, dtype=np.float64).reshape(-1, 5),
        "fence": np.array(mission.fence, dtype=np.float64).reshape(-1, 2),
    }
