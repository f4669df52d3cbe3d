"""Kinds of sensors that a robot can have, from the one table of the core (pilot/readings.hpp)."""

from typing import Literal, NamedTuple

from hypertuna import _core


class Channel(NamedTuple):
    """A kind of sensor: names, unit, number per robot, and its channels."""

    name: str  # the quantity in [[sensors]], and the prefix of its calibration
    part: str  # name of the part in faults
    column: str  # column in logs
    unit: str
    meaning: str
    per: Literal["joint", "circuit", "robot"]  # part of a robot that has one such sensor each
    converter: Literal["analog", "digital", "none"]  # converter that turns its signal into counts
    pilot: bool  # whether only the pilot reads it
    first: int  # index of the first channel
    size: int  # number of channels reserved for it

    def count(self, joints: int) -> int:
        """Return the number of channels of this kind in a robot with a number of joint groups."""
        return {"joint": joints, "circuit": 2 * joints, "robot": self.size}[self.per]


CHANNELS = {row[0]: Channel(*row) for row in _core.channel_table()}  # type: ignore[arg-type]  # C++ knows no Literal
COUNTED = {name: channel for name, channel in CHANNELS.items() if channel.converter != "none"}  # read as raw counts
ANALOG = tuple(name for name, channel in CHANNELS.items() if channel.converter == "analog")  # on analog pins
