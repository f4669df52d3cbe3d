"""Write logs of missions: MCAP files (mcap.dev) for Foxglove and Rerun, in chunks with checksums.

Topic /tf has the true and the estimated pose as foxglove.FrameTransform. The other topics are messages in JSON with
schemas, whose keys carry the unit. Needs the extra `log`.
"""

import dataclasses
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.frames import attitude_to
from hypertuna.io.files import write_atomically
from hypertuna.io.mcap import ENDING, METADATA, NANO, McapWriter
from hypertuna.mission.geodesy import from_local
from hypertuna.mission.log_fields import Field, derived, fields, schema
from hypertuna.mission.record import COLUMNS, ESTIMATED, MissionRecord

CHUNK_ROWS = 2000  # rows of the record per chunk


class LogWriter(McapWriter):
    """Writes a log during a mission: after each `write`, the file is complete up to there."""

    def write(self, record: MissionRecord) -> None:
        """Append a record, and end the chunk."""
        from foxglove import Channel
        from foxglove.channels import FrameTransformChannel, LocationFixChannel

        if not self.channels:
            self.write_metadata(METADATA, {"record": _head(record), **record.facts})
        stamps = np.round(record.time * NANO).astype(np.int64).tolist()
        streams = [(self.channel("/tf", FrameTransformChannel), poses) for poses in _transforms(record, stamps)]
        if record.origin is not None:
            streams.append((self.channel("/location", LocationFixChannel), _locations(record, stamps)))
        for topic, rows in fields(record.data, record.joints, record.circuits).items():
            channel = self.channel(topic, Channel, schema=schema(topic, rows))
            streams.append((channel, _messages(topic, rows, record)))
        for k, stamp in enumerate(stamps):
            for channel, messages in streams:
                channel.log(messages[k], log_time=stamp)
        self.flush()

    def close(self, facts: Mapping[str, str] | None = None) -> None:
        """Write the facts and the file's index, and close the file."""
        if facts:
            self.write_metadata(ENDING, facts)
        super().close()


def write_log(record: MissionRecord, path: str | Path, report: Callable[[int, int], None] | None = None) -> Path:
    """Write a record as a log, completely or not at all."""
    buffer = io.BytesIO()
    with LogWriter(buffer) as writer:
        for begin in range(0, len(record.time), CHUNK_ROWS):
            writer.write(record.part(slice(begin, begin + CHUNK_ROWS)))
            if report is not None:
                report(min(begin + CHUNK_ROWS, len(record.time)), len(record.time))
    return write_atomically(path, buffer.getvalue())


def _head(record: MissionRecord) -> str:
    """Return the header of a log as JSON: the record's fields other than arrays, and the names of its columns."""
    names = {field.name for field in dataclasses.fields(record)} - {"time", "data", "facts", "mission"}
    facts = {name: getattr(record, name) for name in sorted(names)}
    facts |= {"mission": dataclasses.asdict(record.mission), "columns": sorted(record.data)}
    return json.dumps(facts, allow_nan=False)


def _transforms(record: MissionRecord, stamps: Sequence[int]) -> list[list[Any]]:
    """Return the transforms of the true and the estimated pose, a list over time for each, in forward-left-up axes."""
    from foxglove.messages import FrameTransform, Quaternion, Timestamp, Vector3

    data, poses = record.data, {}
    if record.true:
        poses["robot"] = (record.position, record.attitude)
    if set(ESTIMATED) <= set(data):
        position = np.column_stack([data["position_estimated"], -data["depth_estimated"]])
        poses["estimate"] = (position, data["attitude_estimated"])
    return [
        [
            FrameTransform(
                timestamp=Timestamp(sec=stamp // NANO, nsec=stamp % NANO),
                parent_frame_id="world",
                child_frame_id=child,
                translation=Vector3(x=x, y=y, z=z),
                rotation=Quaternion(x=qx, y=qy, z=qz, w=qw),
            )
            for stamp, (x, y, z), (qw, qx, qy, qz) in zip(
                stamps, position.tolist(), attitude_to("enu", attitude).tolist(), strict=True
            )
        ]
        for child, (position, attitude) in poses.items()
    ]


def _locations(record: MissionRecord, stamps: Sequence[int]) -> list[Any]:
    """Return a message per time with latitude and longitude [deg] and altitude [m], for maps."""
    from foxglove.messages import Color, LocationFix, Timestamp

    assert record.origin is not None
    places = np.degrees(from_local(record.origin, record.position[:, :2])).tolist()
    return [
        LocationFix(
            timestamp=Timestamp(sec=stamp // NANO, nsec=stamp % NANO),
            frame_id="world",
            latitude=latitude,
            longitude=longitude,
            altitude=-depth,
            color=Color(r=0.0, g=0.447, b=0.698, a=1.0),  # the blue of the figures
        )
        for stamp, (latitude, longitude), depth in zip(stamps, places, record.depth.tolist(), strict=True)
    ]


def _messages(topic: str, rows: Sequence[Field], record: MissionRecord) -> list[bytes]:
    """Return the messages of a topic in JSON, one per time of the record."""
    columns = {row.key: row.of(record) for row in rows}
    if topic == "/motion":
        columns |= derived(record)
    messages = [dict(zip(columns, row, strict=True)) for row in np.column_stack(list(columns.values())).tolist()]
    nullable = [row.key for row in rows if COLUMNS[row.name].silent]
    for message in messages:
        if topic == "/mode":
            _name_modes(message, record)
        message.update((key, None) for key in nullable if math.isnan(message[key]))
    return [json.dumps(message, allow_nan=False).encode() for message in messages]


def _name_modes(message: dict[str, Any], record: MissionRecord) -> None:
    """Add names to a message, in place, for its numbers of mode and state and its flags of reasons and faults."""
    for key, names in (("mode", record.modes), ("state", record.states)):
        if key in message and 0 <= message[key] < len(names):
            message[f"{key}_name"] = names[int(message[key])]
    for key, names in (("reasons", record.reasons), ("faults", record.faults)):
        if key in message:
            flags = int(message[key])
            message[f"{key[:-1]}_names"] = [name for bit, name in enumerate(names) if flags >> bit & 1]
