"""Logs of missions: MCAP files (mcap.dev) that Foxglove and Rerun open, written in chunks with checksums.

Topic /tf has the true and the estimated pose as foxglove.FrameTransform; the other topics are messages in
JSON with schemas, whose keys carry the unit. Needs the extra `log`.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Self

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.frames import attitude_to
from hypertuna.io.files import write_atomically
from hypertuna.io.mcap import CHUNK, ENDING, METADATA, NANO, need_log
from hypertuna.mission.geodesy import from_local
from hypertuna.mission.log_fields import DEGREES, DERIVED, Field, fields, schema
from hypertuna.mission.record import BELIEVED, COLUMNS, MissionRecord, mission_table

PART = 2000  # rows written at once


class LogWriter:
    """Writer of a log during a mission: after `write` the record is on disk in whole chunks."""

    def __init__(self, target: Path | IO[bytes]) -> None:
        need_log()
        import foxglove
        from foxglove.mcap import MCAPCompression, MCAPWriteOptions

        self._context = foxglove.Context()
        options = MCAPWriteOptions(chunk_size=CHUNK, compression=MCAPCompression.Zstd, profile="hypertuna")
        try:
            self._file = foxglove.open_mcap(target, allow_overwrite=True, context=self._context, writer_options=options)
        except OSError as error:
            fix = "choose a path that can be written"
            raise InputError("must be a writable file", file=str(target), value=f"not ({error})", fix=fix) from None
        self._channels: dict[str, Any] = {}
        self._head: str | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def write(self, record: MissionRecord) -> None:
        """Append a record in whole chunks."""
        if self._head is None:
            self._head = _head(record)
            self._file.write_metadata(METADATA, {"record": self._head, **record.facts})
        topics = fields(record.data, record.joints, record.circuits)
        stamps = np.round(record.time * NANO).astype(np.int64).tolist()
        frames, places = _frames(record), _places(record)
        texts = {topic: _messages(topic, rows, record) for topic, rows in topics.items()}
        for k, stamp in enumerate(stamps):
            for child, poses in frames.items():
                self._transform(child, poses[k], stamp)
            if places is not None:
                self._location(places[k], record.depth[k], stamp)
            for topic, messages in texts.items():
                if topic not in self._channels:
                    self._channels[topic] = self._channel(topic, schema(topic, topics[topic]))
                self._channels[topic].log(messages[k], log_time=stamp)
        self._file.flush()

    def close(self, facts: Mapping[str, str] | None = None) -> None:
        """Finish the file with its index."""
        if facts:
            self._file.write_metadata(ENDING, dict(facts))
        self._file.close()

    def _channel(self, topic: str, json_schema: Mapping[str, Any]) -> Any:
        import foxglove

        return foxglove.Channel(topic, schema=dict(json_schema), context=self._context)

    def _transform(self, child: str, pose: Sequence[float], stamp: int) -> None:
        """Log a pose: x, y, z, then w, x, y, z."""
        from foxglove.channels import FrameTransformChannel
        from foxglove.messages import FrameTransform, Quaternion, Timestamp, Vector3

        if "/tf" not in self._channels:
            self._channels["/tf"] = FrameTransformChannel("/tf", context=self._context)
        x, y, z, qw, qx, qy, qz = pose
        message = FrameTransform(
            timestamp=Timestamp(sec=stamp // NANO, nsec=stamp % NANO),
            parent_frame_id="world",
            child_frame_id=child,
            translation=Vector3(x=x, y=y, z=z),
            rotation=Quaternion(x=qx, y=qy, z=qz, w=qw),
        )
        self._channels["/tf"].log(message, log_time=stamp)

    def _location(self, place: Sequence[float], depth: float, stamp: int) -> None:
        """Log a place on the Earth, for maps."""
        from foxglove.channels import LocationFixChannel
        from foxglove.messages import Color, LocationFix, Timestamp

        if "/location" not in self._channels:
            self._channels["/location"] = LocationFixChannel("/location", context=self._context)
        message = LocationFix(
            timestamp=Timestamp(sec=stamp // NANO, nsec=stamp % NANO),
            frame_id="world",
            latitude=place[0],
            longitude=place[1],
            altitude=-float(depth),
            color=Color(r=0.0, g=0.447, b=0.698, a=1.0),  # the blue of the figures
        )
        self._channels["/location"].log(message, log_time=stamp)


def write_log(record: MissionRecord, path: str | Path, report: Callable[[int, int], None] | None = None) -> Path:
    """Write a record as a log, whole or not at all."""
    whole = io.BytesIO()
    with LogWriter(whole) as writer:
        for begin in range(0, len(record.time), PART):
            writer.write(record.part(slice(begin, begin + PART)))
            if report is not None:
                report(min(begin + PART, len(record.time)), len(record.time))
    return write_atomically(path, whole.getvalue())


def _head(record: MissionRecord) -> str:
    """Return the names and facts of a record as JSON."""
    facts = {
        "name": record.name,
        "robot": record.robot,
        "mission": mission_table(record.mission),
        "columns": sorted(record.data),
        "joints": record.joints,
        "circuits": record.circuits,
        "modes": record.modes,
        "reasons": record.reasons,
        "origin": record.origin,
        "controls": record.controls,
        "faults": record.faults,
    }
    return json.dumps(facts, allow_nan=False)


def _frames(record: MissionRecord) -> dict[str, list[list[float]]]:
    """Return the poses of each frame, with forward-left-up axes: x, y, z, then w, x, y, z."""
    data = record.data
    parts = {"robot": (record.position, record.attitude)} if record.true else {}
    if set(BELIEVED) <= set(data):
        believed = np.column_stack([data["position_estimated"], -data["depth_estimated"]])
        parts["estimate"] = (believed, data["attitude_estimated"])
    return {
        child: np.concatenate([place, attitude_to("enu", attitude)], axis=1).tolist()
        for child, (place, attitude) in parts.items()
    }


def _places(record: MissionRecord) -> list[list[float]] | None:
    """Return latitudes and longitudes [deg], if the record has an origin."""
    if record.origin is None:
        return None
    places: list[list[float]] = np.degrees(from_local(record.origin, record.position[:, :2])).tolist()
    return places


def _messages(topic: str, rows: Sequence[Field], record: MissionRecord) -> list[bytes]:
    """Return the messages of a topic."""
    keys = [row.key for row in rows]
    columns = [
        (record.data[row.name] if row.part is None else record.data[row.name][:, row.part]) * row.factor for row in rows
    ]
    if topic == "/motion":
        keys += list(DERIVED)
        columns += [record.depth, _ahead(record), *(record.angles * DEGREES).T]
    table = np.column_stack(columns).tolist()
    messages = [dict(zip(keys, row, strict=True)) for row in table]
    if topic == "/mode":
        for message in messages:
            _name_modes(message, record)
    for key in (row.key for row in rows if COLUMNS[row.name].silent):
        for message in messages:
            if math.isnan(message[key]):
                message[key] = None
    return [json.dumps(message, allow_nan=False).encode() for message in messages]


def _ahead(record: MissionRecord) -> Array:
    """Return the speed through the water, true or estimated (T,) [m/s]."""
    if "velocity" in record.data:
        return np.asarray(-record.data["velocity"][:, 0])
    none = np.zeros(len(record.time))
    return none if record.true else np.asarray(record.data.get("speed_estimated", none))


def _name_modes(message: dict[str, Any], record: MissionRecord) -> None:
    """Put names beside the numbers of mode and control, reasons and faults."""
    for key, names in (("mode", record.modes), ("control", record.controls)):
        if key in message and 0 <= message[key] < len(names):
            message[f"{key}_name"] = names[int(message[key])]
    for key, names in (("reasons", record.reasons), ("faults", record.faults)):
        if key in message:
            flags = int(message[key])
            message[f"{key[:-1]}_names"] = [name for bit, name in enumerate(names) if flags >> bit & 1]
