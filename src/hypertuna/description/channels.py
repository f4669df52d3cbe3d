"""Kinds of sensors that a robot can have, from the one table of the core (pilot/readings.hpp)."""

from typing import Literal, NamedTuple

from hypertuna import _core


class Channel(NamedTuple):
    """A kind of sensor: names, unit, number per robot, and its channels."""

    name: str  # the quantity of [[sensors]], and the prefix of its calibration
    part: str  # that its faults are named by
    column: str  # of logs
    unit: str
    meaning: str
    per: Literal["joint", "circuit", "robot"]  # that each has a sensor
    converter: Literal["analog", "digital", "none"]  # that makes counts of its signal
    pilot: bool  # only the pilot reads it
    first: int  # channel
    size: int  # channels reserved for it

    def count(self, joints: int) -> int:
        """Return the number of channels of this kind that a robot has, by its number of joint groups."""
        return {"joint": joints, "circuit": 2 * joints, "robot": self.size}[self.per]


CHANNELS = {row[0]: Channel(*row) for row in _core.channel_table()}  # type: ignore[arg-type]  # C++ knows no Literal
COUNTED = {name: channel for name, channel in CHANNELS.items() if channel.converter != "none"}
ANALOG = tuple(name for name, channel in CHANNELS.items() if channel.converter == "analog")
