"""Outcome of each waypoint, reached, passed or skipped, with the believed and the true distance from it."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hypertuna.mission.record import MissionRecord


def waypoint_results(record: MissionRecord) -> list[dict[str, Any]]:
    """Return a row per waypoint: number from 1, outcome, time, believed and true distance, uncertainty, depth.

    Values are those at the time at which the robot went on; None for a waypoint that is still ahead.
    """
    outcomes = list(_outcomes(record))
    ahead = len(record.mission.waypoints) - len(outcomes)
    nothing = dict.fromkeys(("time_s", "believed_m", "true_m", "uncertainty_m", "depth_m"))
    rows = [_result(record, k, *one) for k, one in enumerate(outcomes)] + [{"outcome": "ahead"} | nothing] * ahead
    return [{"waypoint": number} | row for number, row in enumerate(rows, 1)]


def _outcomes(record: MissionRecord) -> Iterator[tuple[str, int]]:
    """Yield outcome and row of every waypoint that the robot left behind, in order."""
    legs, reached, passed = (record.data[name].astype(int) for name in ("leg", "reached", "passed"))
    for k in np.flatnonzero(np.diff(legs)) + 1:
        counts = {"reached": reached[k] - reached[k - 1], "passed": passed[k] - passed[k - 1]}
        counts["skipped"] = legs[k] - legs[k - 1] - sum(counts.values())
        for name, count in counts.items():
            yield from [(name, int(k))] * max(count, 0)


def _result(record: MissionRecord, k: int, outcome: str, row: int) -> dict[str, Any]:
    """Return the row of one waypoint."""
    place = record.mission.waypoints[k][:2]
    believed = record.data["position_estimated"][row] - place
    true = record.position[row, :2] - place if record.true else None
    return {
        "outcome": outcome,
        "time_s": float(record.time[row]),
        "believed_m": float(np.hypot(*believed)),
        "true_m": None if true is None else float(np.hypot(*true)),
        "uncertainty_m": float(record.data["position_error"][row]),
        "depth_m": float(record.depth[row]),
    }
