"""Check before a swim: whether the robot may be armed, its faults, and what its sensors read."""

import math
from dataclasses import dataclass
from typing import Any

from hypertuna import _core
from hypertuna.errors import InputError
from hypertuna.radio.client import PATIENCE, TRIES, Client, of_kind
from hypertuna.radio.dialect import dialect
from hypertuna.radio.samples import VOLTAGE_SILENT

RUN_PREARM_CHECKS, REQUEST_MESSAGE = 401, 512  # numbers of MAV_CMD
PREARM_BIT = 1 << 28  # MAV_SYS_STATUS_PREARM_CHECK: set if the robot may be armed


@dataclass(frozen=True)
class Readiness:
    """Whether a robot may be armed, its faults and its readings."""

    ready: bool
    reasons: tuple[str, ...]  # why it may not be armed, in the robot's words
    faults: tuple[tuple[str, str, bool], ...]  # name, sentence, whether it forbids arming
    voltage: float  # V of the battery; NaN if it cannot be read
    depth: float  # m
    heading: float  # rad, clockwise from north
    roll: float  # rad, starboard down
    pitch: float  # rad, nose up

    def record(self) -> dict[str, Any]:
        """Return the JSON record."""
        keys = ("name", "sentence", "forbids_arming")
        return {
            "ready": self.ready,
            "reasons": list(self.reasons),
            "faults": [dict(zip(keys, fault, strict=True)) for fault in self.faults],
            "battery_v": self.voltage,
            "depth_m": self.depth,
            "heading_deg": math.degrees(self.heading),
            "roll_deg": math.degrees(self.roll),
            "pitch_deg": math.degrees(self.pitch),
        }


def check_ready(robot: Client) -> Readiness:
    """Ask a disarmed robot to check itself; return whether it may be armed, its faults and its readings."""
    texts_before = len(robot.texts)
    robot.command(RUN_PREARM_CHECKS, name="check")
    robot.wait(of_kind("STATUSTEXT"), PATIENCE)
    pilot, status, motion, position = (
        request(robot, name) for name in ("PILOT", "SYS_STATUS", "ATTITUDE", "LOCAL_POSITION_NED")
    )
    ready = bool(status.onboard_control_sensors_health & PREARM_BIT)
    rows = [row for k, row in enumerate(_core.fault_table()) if pilot.fault >> k & 1]
    millivolts = status.voltage_battery
    return Readiness(
        ready,
        () if ready else tuple(robot.texts[texts_before:]),
        tuple((name, sentence, forbids) for name, sentence, _, _, forbids, *_ in rows),
        math.nan if millivolts == VOLTAGE_SILENT else millivolts / 1000,
        position.z,
        motion.yaw % math.tau,
        motion.roll,
        motion.pitch,
    )


def request(robot: Client, name: str) -> Any:
    """Request a message from the robot by name, and return it."""
    for _ in range(TRIES):
        robot.command(REQUEST_MESSAGE, getattr(dialect(), f"MAVLINK_MSG_ID_{name}"), name=f"request of {name}")
        if (message := robot.wait(of_kind(name), PATIENCE)) is not None:
            return message
    raise InputError("must arrive from the robot", key=name, value="missing", fix="move closer, and try again")
