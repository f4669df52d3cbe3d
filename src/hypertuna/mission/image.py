"""Robot image with the robot's pilot and the shipped missions that it can fly; `hosts/image.hpp` reads it."""

import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

from hypertuna import _core
from hypertuna.control.guidance import mission_columns, pilot_columns
from hypertuna.control.sensors import channels, pilot_sensor_columns
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.mission.file import MissionFile, missions, read_mission, scatter_seed, scatter_span
from hypertuna.mission.mishaps import FIN_KINDS
from hypertuna.mission.run import ENDINGS, MissionStart, flight_columns, mission_start
from hypertuna.simulation.image import twin_image

Ready = tuple[MissionFile, MissionStart]  # a mission that the robot can fly
# Fields of a mission that the image's text repeats.
SHOWN_FIELDS = (
    "fence",
    "home",
    "home_radius",
    "start",
    "heading",
    "depth_max",
    "bottom",
    "current",
    "current_bottom",
    "stay",
)


def robot_image(robot: Robot, added: Mapping[str, Any] | None = None, facts: Mapping[str, Any] | None = None) -> bytes:
    """Return the image of a robot: its models in water, its twin, and its pilot with the missions that it can fly.

    Model 0 is the robot's own choice; the others are all combinations of its water laws and joint models. `added`
    columns replace or extend the image's; `facts` extend its text.
    """
    flyable = list(_ready(robot))
    columns = dict(added or {})
    if flyable:
        columns |= {f"sensors.{name}": values for name, values in pilot_sensor_columns(robot).items()}
        columns |= {f"pilot.{name}": values for name, values in pilot_columns(robot, flyable[0][1].table).items()}
    for k, mission in enumerate(flyable):
        columns |= {f"missions.{k}.{name}": values for name, values in _columns(*mission).items()}
    text = {"missions": [_mission(*mission) for mission in flyable], "pilot": _pilot(robot) if flyable else None}
    return twin_image(robot, columns, text | dict(facts or {}))


def _ready(robot: Robot) -> Iterator[Ready]:
    """Yield the file and the start of each shipped mission that the robot can fly."""
    if robot.guidance is None:
        return
    for name in missions():
        file = read_mission(name)
        with contextlib.suppress(InputError):  # the robot lacks a table, or the fence is too narrow for it
            yield file, mission_start(robot, file.mission)


def _columns(file: MissionFile, start: MissionStart) -> dict[str, Any]:
    """Return a mission's numbers as columns, by the names that `read_mission` in hosts/host.cpp reads."""
    mission, scatter = file.mission, file.scatter
    return (
        mission_columns(mission)
        | flight_columns(start.robot, mission)
        | {
            "scatter.current": scatter.current,
            "scatter.gaps": scatter.gaps,
            "scatter.gap": scatter.gap,
            "scatter.span": scatter_span(mission),
            "scatter.hash": scatter_seed(file),
            "pose": start.core["pose"][:7],
            "charge": start.core["charge"],
            "ticks": start.ticks,
        }
    )


def _mission(file: MissionFile, start: MissionStart) -> dict[str, Any]:
    """Return the texts and numbers [SI] that hosts show of a mission; duration: after which the mission is given up."""
    mission = file.mission
    facts = {"name": file.name, "text": file.description, "origin": file.origin, "duration": start.duration}
    rows = {"waypoints": [list(point) for point in mission.waypoints], "gaps": mission.gaps}
    return facts | rows | {name: getattr(mission, name) for name in SHOWN_FIELDS}


def _pilot(robot: Robot) -> dict[str, Any]:
    """Return the names of modes, reasons and endings, in order of number, and of sensors and fins that can fail."""
    lists = {"modes": _core.mode_table(), "reasons": _core.reason_table(), "endings": list(ENDINGS.items())[1:]}
    by_key = {key: [{"name": name, "text": text} for name, text in rows] for key, rows in lists.items()}
    return by_key | {"channels": channels(robot, pilot=True), "fin_faults": list(FIN_KINDS)}
