"""Failures of board, hull and radio in the loop, spelled as those of sensors: ``PART:KIND@START-END`` in s."""

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

from hypertuna.control.sensors import fault_texts, fault_times
from hypertuna.errors import InputError, did_you_mean, shown

SPELLING = re.compile(r"(?P<part>[a-z]+):(?P<kind>[a-z]+)@(?P<times>[^:@]+)")  # pattern of a failure that is typed
FAILURES = {
    "board:brownout": "the supply dips: the board boots again with what its memory stores, and so does the receiver",
    "board:watchdog": "the watchdog resets the board, which keeps its power",
    "bus:stuck": "the I2C bus hangs: no depth, and every second tick comes late",
    "hull:leak": "water in the hull",
    "link:lost": "the ground station falls silent",
}
PARTS = {name.partition(":")[0] for name in FAILURES}  # what can fail
OUTAGE = 0.3  # s from a reset to the firmware's next tick


class Failure(NamedTuple):
    """A failure from a time until another [s]."""

    name: str  # of FAILURES
    start: float
    end: float

    def holds(self, time: float) -> bool:
        """Return whether the failure is present at a time [s]."""
        return self.start <= time < self.end


def split_faults(spelled: str | Iterable[str]) -> tuple[tuple[str, ...], tuple[Failure, ...]]:
    """Return faults of the twin's sensors and fins, as texts, and faults of the board, parsed."""
    sensors: list[str] = []
    failures: list[Failure] = []
    for text in fault_texts(spelled):
        match = SPELLING.fullmatch(text.strip())
        if match is None or match["part"] not in PARTS:
            sensors.append(text)
            continue
        name, times = f"{match['part']}:{match['kind']}", match["times"]
        if name not in FAILURES:
            rule, fix = "must be of a known kind", did_you_mean(name, FAILURES)
            raise InputError(rule, key="fault", value=shown(text), fix=fix)
        failures.append(Failure(name, *fault_times(text, times)))
        if name == "bus:stuck":
            sensors.append(f"depth:nan@{times}")
    return tuple(sensors), tuple(failures)


class Failures:
    """Failures of a run, queried in each tick."""

    def __init__(self, failures: Iterable[Failure], tick: float) -> None:
        self.list, self.tick = tuple(failures), tick

    def has(self, name: str, tick: int) -> bool:
        """Return whether a failure holds in a tick."""
        return any(failure.name == name and failure.holds(tick * self.tick) for failure in self.list)

    def reset(self, tick: int) -> str | None:
        """Return "brownout" or "watchdog" in the tick with which the firmware boots again."""
        for failure in self.list:
            part, _, kind = failure.name.partition(":")
            if part == "board" and tick == math.ceil((failure.start + OUTAGE) / self.tick):
                return kind
        return None

    def stopped(self, tick: int) -> bool:
        """Return whether the board makes no tick, because it boots or is late."""
        time = tick * self.tick
        booting = any(f.name.startswith("board:") and f.start <= time < f.start + OUTAGE for f in self.list)
        return booting or (self.has("bus:stuck", tick) and tick % 2 == 1)

    @property
    def resets(self) -> tuple[float, ...]:
        """Times at which the receiver loses its power [s]."""
        return tuple(failure.start for failure in self.list if failure.name == "board:brownout")
