"""What notebooks and shells show of missions and flights."""

import math
from functools import partial

from hypertuna.arrays import Array
from hypertuna.control.mission import Mission
from hypertuna.display import Card, facts_of, number
from hypertuna.mission.file import MissionFile
from hypertuna.mission.flight import Flight, outcome
from hypertuna.mission.log_fields import record_columns
from hypertuna.mission.record import MissionRecord
from hypertuna.pictures import curve_svg, track_svg


def flight_card(flight: Flight) -> Card:
    """Show the track of a flight from above, and six numbers."""
    result, record = outcome(flight), flight.record
    facts = [
        ("status", flight.status),
        ("waypoints reached", f"{result.waypoints_reached} of {len(record.mission.waypoints)}"),
        ("duration", _clock(result.duration)),
        ("distance, over ground", number(result.distance, "m")),
        ("energy", number(result.energy / 3600, "Wh")),
        ("max depth", number(result.depth_max, "m")),
    ]
    reasons = [f"{name.replace('_', ' ')} at {_clock(time)}" for name, time in result.reasons.items()]
    text = f"Reasons of the pilot: {', '.join(reasons)}." if reasons else ""
    east, north = record.path[:, 0], record.path[:, 1]
    title = f"Mission {flight.file.name}, flown by {flight.robot.name}, seed {flight.seed}"
    label = "north [m] over east [m]"
    return Card(title, facts, text, picture=lambda: track_svg(east, north, result.duration, label))


def flight_columns(flight: Flight) -> dict[str, Array]:
    """Return the record of a flight as columns."""
    return record_columns(flight.record)


def mission_card(file: MissionFile) -> Card:
    """Show the course of a mission."""
    mission = file.mission
    facts = [
        ("robot", file.robot or "any"),
        ("waypoints", f"{len(mission.waypoints)}"),
        ("course", number(_length(mission), "m")),
        ("max depth", number(mission.depth_max, "m")),
        ("reserve of the charge", number(100 * mission.reserve, "%")),
        ("fence", f"{len(mission.fence)} corners" if mission.fence else "none"),
    ]
    rows = [tuple(number(value) for value in point) for point in mission.waypoints]
    columns = ("east [m]", "north [m]", "depth [m]", "speed [m/s]", "radius [m]", "hold [s]")
    east, north = zip(*mission.course, strict=True)
    label = "course: north [m] over east [m]"
    picture = partial(curve_svg, east, north, label, equal=True)
    return Card(f"Mission {file.name}", facts, file.description, columns, rows, picture)


def waypoint_columns(file: MissionFile) -> dict[str, list[float]]:
    """Return the waypoints of a mission as columns."""
    columns = zip(*file.mission.waypoints, strict=True)
    return dict(zip(("x_m", "y_m", "depth_m", "speed_m_s", "radius_m", "hold_s"), map(list, columns), strict=True))


def record_card(record: MissionRecord) -> Card:
    """Show the track of a record from above, and its numbers."""
    east, north = record.path[:, 0], record.path[:, 1]
    duration = float(record.time[-1] - record.time[0])
    facts = [("duration", _clock(duration)), *facts_of(record.summary())]
    picture = partial(track_svg, east, north, duration, "north [m] over east [m]")
    return Card(f"Record of mission {record.name}, {record.robot}", facts, picture=picture)


def _length(mission: Mission) -> float:
    """Return the length of the course [m]."""
    return sum(math.dist(a, b) for a, b in zip(mission.course, mission.course[1:], strict=False))


def _clock(seconds: float) -> str:
    """Write a time in seconds, or minutes and seconds."""
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds // 60:.0f} min {seconds % 60:.0f} s"
