"""Foxglove layout for a mission's log: map, 3D view of the robot, plots of the recorded quantities."""

from typing import Any

from hypertuna.mission.log_fields import DERIVED, fields
from hypertuna.mission.record import MissionRecord

# By title of a plot: its topics, and the prefixes of the keys that it draws.
PLOTS = {
    "Depth [m]": {"/motion": ("depth_m",), "/estimate": ("depth_estimated",)},
    "Heading [deg]": {"/motion": ("heading_deg",)},
    "Speed [m/s]": {"/motion": ("speed_m_s",), "/estimate": ("speed_estimated",)},
    "Joints [deg]": {"/joints": ("angle_",)},
    "Pressures [kPa]": {"/hydraulics": ("pump_pressure",)},
    "Power [W]": {"/battery": ("power_w",)},
}
STATES = ("mode_name", "state_name")  # keys of /mode that are shown as bars over time
FLAGS = ("reason_names", "fault_names")  # keys of /mode that are shown as lists


def layout(record: MissionRecord) -> dict[str, Any]:
    """Return a layout that Foxglove can import; it names only paths that the record's log has."""
    topics = fields(record.data, record.joints, record.circuits)
    topic_keys = {topic: [row.key for row in rows] for topic, rows in topics.items()}
    topic_keys["/motion"] += DERIVED
    modes = {"mode": STATES[0], "state": STATES[1], "reasons": FLAGS[0], "faults": FLAGS[1]}
    mode_names = [name for key, name in modes.items() if key in topic_keys.get("/mode", ())]
    followed = "robot" if record.true else "estimate"  # frame of the true pose, or without it of the estimate
    panels: dict[str, Any] = {"3D!space": {"followMode": "follow-position", "followTf": followed}}
    if record.origin is not None:
        panels["map!place"] = {"followTopic": "/location", "zoomLevel": 17}
    for title, prefixes_by_topic in PLOTS.items():
        paths = [
            _path(topic, key)
            for topic, prefixes in prefixes_by_topic.items()
            for key in topic_keys.get(topic, ())
            if key.startswith(prefixes)
        ]
        if paths:
            panels[f"Plot!{title.split()[0].lower()}"] = {"title": title, "paths": paths, "isSynced": True}
    if states := [_path("/mode", name) for name in mode_names if name in STATES]:
        panels["StateTransitions!states"] = {"paths": states, "isSynced": True}
    panels |= {f"RawMessages!{name}": {"topicPath": f"/mode.{name}"} for name in mode_names if name in FLAGS}
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _tiled([*panels], "row"),
    }


def _path(topic: str, key: str) -> dict[str, Any]:
    """Return the settings of a plotted line, with the path to a topic's number in Foxglove's syntax."""
    return {"value": f"{topic}.{key}", "label": key, "enabled": True, "timestampMethod": "receiveTime"}


def _tiled(panels: list[str], direction: str) -> Any:
    """Return the tiling of panels in Foxglove's layout: repeated halving, by turns beside and below each other."""
    if len(panels) == 1:
        return panels[0]
    half, other = len(panels) // 2, "column" if direction == "row" else "row"
    parts = {"first": _tiled(panels[:half], other), "second": _tiled(panels[half:], other)}
    return parts | {"direction": direction, "splitPercentage": 100 * half / len(panels)}
