"""Cards of missions, flights and records."""

import math
from functools import partial

from hypertuna.arrays import Array
from hypertuna.control.guidance import gait_table
from hypertuna.display import Card, Facts, Part, Table, cards, number, tables
from hypertuna.io.quantity import Quantity, quantity
from hypertuna.mission.file import MissionFile
from hypertuna.mission.flight import Flight, Outcome, outcome
from hypertuna.mission.log_fields import record_columns
from hypertuna.mission.record import MissionRecord
from hypertuna.mission.run import ENDINGS
from hypertuna.pictures import curve_svg, track_svg

tables.of(MissionRecord)(record_columns)


@cards.of(Flight)
def flight_card(flight: Flight) -> Card:
    """Return the card of a flight: its track from above, its numbers, and how it ended."""
    end, mission = outcome(flight), flight.record.mission
    summary = end.summary()
    if end.duration:
        summary["mean_speed_m_s"] = quantity("mean_speed", flight.record.mean_speed, "m/s", "over ground")
    content: list[Part] = [Facts({key: item for key, item in summary.items() if math.isfinite(item.value)})]
    content += [(f"{time:8.1f} s  {reason.replace('_', ' ')}", "dim") for reason, time in end.reasons.items()]
    content.append((ending_text(flight, end), "green" if flight.status == "done" else "yellow"))
    if end.fence_margin_min < 0:
        content.append((f"It crossed the fence by {-end.fence_margin_min:.3g} m.", "yellow"))
    for point in end.waypoints:
        if point["outcome"] == "passed":
            text = (
                f"Waypoint {point['waypoint']} passed at a depth of {point['depth_m']:.3g} m. By the pilot's estimate "
                f"it was {point['believed_m']:.3g} m away, with an uncertainty of {point['uncertainty_m']:.3g} m; "
                f"in truth {point['true_m']:.3g} m."
            )
            content.append((text, "yellow"))
    if _is_elsewhere(flight, end):
        radius = _goal_radius(flight)
        goal = "the last waypoint" if mission.stay else "home"
        text = (
            f"It is {end.goal_distance:.3g} m from {goal}, beyond the radius of {radius:g} m: the pilot judges by its "
            f"estimated position, with an uncertainty of {end.goal_uncertainty:.3g} m."
        )
        content.append((text, "dim"))
    title = f"{flight.file.name}, {flight.robot.name}, seed {flight.seed}"
    return Card(title, content, partial(_track, flight.record, end.duration))


def ending_text(flight: Flight, one: Outcome) -> str:
    """Return a sentence on how a flight ended, and a warning if a commanded speed exceeds the fastest gait's."""
    mission, fastest = flight.record.mission, gait_table(flight.robot).speed[-1]
    highest = max(point.speed for point in mission.waypoints)
    command, speed = ("The mission commands", highest) if fastest < highest else ("[home] commands", mission.home_speed)
    beyond = f" {command} {speed:.3g} m/s, but the fastest gait reaches {fastest:.3g} m/s."
    beyond = beyond if fastest < max(mission.speeds) else ""
    counts = (f"{one.waypoints_reached} of {len(one.waypoints)} reached", f"{one.waypoints_passed} passed")
    reached = "" if one.status == "done" else f" (waypoints: {', '.join(counts)}, {one.waypoints_skipped} skipped)"
    reasons = f"; reasons: {', '.join(one.reasons).replace('_', ' ')}" if one.reasons else ""
    ending = ENDINGS[one.status]
    if _is_elsewhere(flight, one) and one.status != "adrift":
        ending = f"By the pilot's estimate t{ending[1:]}"
    return f"{ending}{reached} after {one.duration:.4g} s{reasons}.{beyond}"


def _is_elsewhere(flight: Flight, one: Outcome) -> bool:
    """Return whether the robot ended outside its goal's radius although the pilot's estimate put it inside."""
    return one.status in ("done", "home", "adrift") and one.goal_distance > _goal_radius(flight)


def _goal_radius(flight: Flight) -> float:
    """Return the radius [m] of the flight's goal: the last waypoint if the robot stays there, otherwise home."""
    mission = flight.record.mission
    return mission.waypoints[-1].radius if mission.stay else mission.home_radius


@tables.of(Flight)
def flight_columns(flight: Flight) -> dict[str, Array]:
    """Return the record of a flight as columns."""
    return record_columns(flight.record)


@cards.of(MissionFile)
def mission_card(file: MissionFile) -> Card:
    """Return the card of a mission: its course from above, its waypoints and limits."""
    mission = file.mission
    facts = {
        "robot": file.robot or "any",
        "waypoints": f"{len(mission.waypoints)}",
        "course": number(sum(map(math.dist, mission.course, mission.course[1:])), "m"),
        "max depth": number(mission.depth_max, "m"),
        "reserve of the charge": number(100 * mission.reserve, "%"),
        "fence": f"{len(mission.fence)} corners" if mission.fence else "none",
    }
    rows = [tuple(number(value) for value in point) for point in mission.waypoints]
    columns = ("east [m]", "north [m]", "depth [m]", "speed [m/s]", "radius [m]", "hold [s]")
    east, north = zip(*mission.course, strict=True)
    label = "course: north [m] over east [m]"
    picture = partial(curve_svg, east, north, label, equal=True)
    return Card(f"Mission {file.name}", [Facts(facts), file.description, Table(columns, rows)], picture)


@tables.of(MissionFile)
def waypoint_columns(file: MissionFile) -> dict[str, list[float]]:
    """Return the waypoints of a mission as columns."""
    columns = zip(*file.mission.waypoints, strict=True)
    return dict(zip(("x_m", "y_m", "depth_m", "speed_m_s", "radius_m", "hold_s"), map(list, columns), strict=True))


@cards.of(MissionRecord)
def record_card(record: MissionRecord) -> Card:
    """Return the card of a record: its track from above, and its numbers."""
    summary = record.summary()
    extent = {"span": Quantity(summary["end_s"].value - summary["begin_s"].value, "s", "time")}
    extent |= {"rows": Quantity(f"{summary['times'].value}", "", "times")}
    return Card(
        f"{record.name}, {record.robot}", [Facts(extent | summary)], partial(_track, record, extent["span"].value)
    )


def _track(record: MissionRecord, duration: float) -> str:
    """Return an SVG of the track from above."""
    east, north = record.path[:, 0], record.path[:, 1]
    return track_svg(east, north, duration, "north [m] over east [m]")
