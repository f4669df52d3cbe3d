"""A record of a mission that was never flown: a square at depth, plausible enough for logs, tracks and pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.frames import attitude_of
from hypertuna.mission.file import read_mission
from hypertuna.mission.record import MissionRecord

Array = NDArray[np.float64]

MODES = ("idle", "transit", "hold", "surface", "home", "done", "ended")
STATES, FAULTS = ("disarmed", "rest", "mission"), ("over_pressure", "bend_sensor")
REASONS = ("low_battery", "time_up", "fix_due", "fence")
SPEED = 0.3


def voyage(seconds: float = 300.0, rate: float = 20.0, *, bare: bool = False, seed: int = 1) -> MissionRecord:
    """Swim the shipped box along its legs at 0.3 m/s, with a drifting estimate."""
    read, random = read_mission("box"), np.random.default_rng(seed)
    mission = read.mission
    time = np.arange(0, seconds, 1 / rate)
    corners = np.array([mission.start, *(point[:2] for point in mission.waypoints)])
    miles = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    way = np.minimum(SPEED * time, miles[-1])
    x, y = (np.interp(way, miles, corners[:, k]) for k in (0, 1))
    depth = 2 * (1 - np.exp(-time / 10))
    sway = 0.01 * np.sin(2 * np.pi * 3 * time)
    leg = np.minimum(np.searchsorted(miles, way, side="right") - 1, len(corners) - 2)
    heading = np.arctan2(*(np.diff(corners, axis=0)[leg].T))
    angles = (0.02 * np.sin(time), -0.2 * np.exp(-time / 10), heading + 0.05 * np.sin(6 * np.pi * time))
    pose = np.array([attitude_of(roll=r, pitch=p, heading=h) for r, p, h in zip(*angles, strict=True)])
    position = np.column_stack([x + sway * np.cos(heading), y - sway * np.sin(heading), -depth])
    data: dict[str, Array] = {"position": position, "attitude": pose}
    if not bare:
        data |= _rest(time, data, leg, random)
    return MissionRecord(
        name="box",
        robot="hypertuna",
        mission=mission,
        time=time,
        data=data,
        joints=("I", "II"),
        circuits=("I-left", "I-right", "II-left", "II-right"),
        modes=MODES,
        reasons=REASONS,
        origin=read.origin,
        facts={"seed": str(seed), "hypertuna_version": "0"},
        states=STATES,
        faults=FAULTS,
    )


def _rest(time: Array, data: dict[str, Array], leg: NDArray[Any], random: np.random.Generator) -> dict[str, Array]:
    """Everything that a record may have beside position and attitude."""
    count, beat = len(time), np.sin(6 * np.pi * time)
    error = 0.02 * time
    power = 8 + 2 * np.abs(beat)
    energy = np.concatenate([[0], np.cumsum(np.diff(time) * (power[1:] + power[:-1]) / 2)])
    mode = np.where(time < 0.9 * time[-1], 1, 3)
    return {
        "velocity": np.column_stack([np.full(count, -SPEED), 0.01 * beat, np.zeros(count)]),
        "turn_rate": random.normal(0, 0.1, (count, 3)),
        "position_estimated": data["position"][:, :2] + np.column_stack([error, -0.3 * error]),
        "depth_estimated": -data["position"][:, 2] + random.normal(0, 0.01, count),
        "attitude_estimated": data["attitude"],
        "speed_estimated": np.full(count, SPEED),
        "current_estimated": np.zeros((count, 2)),
        "position_error": error,
        "mode": mode.astype(float),
        "reasons": np.where(mode == 3, 4.0, 0.0),
        "leg": leg.astype(float),
        "reached": leg.astype(float),
        "passed": np.zeros(count),
        "state": np.full(count, float(STATES.index("mission"))),
        "armed": np.ones(count),
        "faults": np.where(time > 20, 2.0, 0.0),
        "answer": np.zeros(count),
        "angle_set": np.outer(beat, [0.2, 0.3]),
        "angle": np.outer(beat, [0.19, 0.28]),
        "servo_target": np.outer(beat, [0.5, -0.5, 0.4, -0.4]),
        "servo_angle": np.outer(beat, [0.48, -0.48, 0.38, -0.38]),
        "pump_pressure": 1e5 * (1 + np.outer(beat, [1, -1, 0.8, -0.8])),
        "unit_pressure": 0.9e5 * (1 + np.outer(beat, [1, -1, 0.8, -0.8])),
        "pulse": 1.5e-3 + np.outer(beat, [4e-4, -4e-4, 3e-4, -3e-4, 0, 1e-4]),
        "fin_target": np.full((count, 2), -0.3),
        "fin": np.full((count, 2), -0.29),
        "fin_commanded": np.full((count, 2), -0.31),
        "frequency_commanded": np.full(count, 3.0),
        "amplitude_commanded": np.tile([0.2, 0.3], (count, 1)),
        "lag_commanded": np.tile([0, 0.7], (count, 1)),
        "bias_commanded": np.zeros((count, 2)),
        "factor_estimated": np.ones(count),
        "charge": energy / 16,
        "battery_voltage": 16.8 - 1e-4 * time,
        "power": power,
        "energy": energy,
        "charge_left": 1 - energy / 1.7e5,
        "status": (random.uniform(size=count) < 0.01).astype(float),
        "bend_read": np.outer(beat, [0.19, np.nan]),  # the second sensor is silent
        "pressure_read": 1e5 * (1 + np.outer(beat, [1, -1, 0.8, -0.8])),
        "current_read": np.outer(np.abs(beat), [1, 1, 0.8, 0.8]),
        "turn_rate_read": random.normal(0, 0.1, (count, 3)),
        "acceleration_read": np.tile([0, 0, 9.81], (count, 1)),
        "field_read": np.tile([0, 0.7, -0.7], (count, 1)),
        "depth_read": np.where(time % 10 < 1, np.nan, 2.0),
        "battery_voltage_read": 16.8 - 1e-4 * time,
    }
