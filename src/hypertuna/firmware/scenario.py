"""Scenarios of firmware in the loop: a mission, a gait, or random messages that reach every branch."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.control.mission import Mission
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean
from hypertuna.firmware.lockstep import (
    DEGREES,
    FIXED,
    GROUND,
    LAST,
    LEAK,
    NO_SAMPLE,
    ORDERS_GIVEN,
    STACK,
    TO_BOARD,
    Counts,
    give,
    order,
)
from hypertuna.firmware.parameters import FirmwareTable
from hypertuna.mission.file import MissionFile, missions, read_mission
from hypertuna.ranges import WHOLE
from hypertuna.swimming.gait import Gait, lags, named_gait

START = 100  # ticks before the first command, in which the attitude settles
COLD = 6100  # ticks that the ground waits for the first fix of a cold receiver
STORED = 250  # ticks to store the longest mission before arming
Messages = NDArray[Any]

DEFAULT_TICKS = 6000  # of a scenario that does not end by itself
FINS, DIVE, SILENT = -0.35, 5000, 5200  # of lost:GAIT: angle of the fins [rad]; ticks at which the dive and contact end


@dataclass(frozen=True)
class Scenario:
    """Input of a run of firmware in the loop: a mission, a gait, or random messages."""

    name: str
    mission: Mission | None  # water, start and waypoints; None for random messages without a twin
    gait: Gait | None = None  # commanded instead of a mission
    origin: tuple[int, int] | None = None  # latitude and longitude of x = y = 0 in the mission [1e-7 deg]
    robot: str | None = None  # named by the mission
    silent: int | None = None  # tick from which there is no contact with the ground
    cable: bool = False  # whether a cable to the ground replaces the radio, which water interrupts

    @property
    def ticks(self) -> int | None:
        """Control ticks of a run; None for one that ends with its mission."""
        if self.mission is not None and self.gait is None:
            return None
        return DEFAULT_TICKS if self.silent is None else 4 * DEFAULT_TICKS


def find_scenario(name: str, robot: Robot | None = None) -> Scenario:
    """Return a scenario: random, afloat, gait:NAME, lost:NAME (a dive, contact lost at 3 m), a mission or its file."""
    if name == "random":
        return Scenario(name, None)
    if name == "afloat":
        return Scenario(name, Mission(()), cable=True)
    if name.startswith(("gait:", "lost:")):
        if robot is None:
            raise InputError("must be given with a gait", key="--robot", fix="give --robot")
        gait = named_gait(robot, name[5:])
        silent = SILENT if name.startswith("lost:") else None
        return Scenario(name, Mission(()), gait, silent=silent, cable=True)
    if name not in missions() and not name.lower().endswith(".toml"):
        choices = ["random", "afloat", *(f"gait:{gait}" for gait in (robot.gaits if robot else ())), *missions()]
        raise InputError("is no scenario", key="--scenario", value=repr(name), fix=did_you_mean(name, choices))
    return scenario_of(read_mission(name), name)


def scenario_of(file: MissionFile, name: str = "mission") -> Scenario:
    """Return the scenario of a mission file."""
    origin = None
    if file.origin is not None:
        latitude, longitude = (round(math.degrees(angle) * DEGREES) for angle in file.origin)
        origin = (latitude, longitude)
    return Scenario(name, file.mission, None, origin, file.robot)


def scheduled_orders(scenario: Scenario) -> Iterator[tuple[int, Any]]:
    """Yield tick and message (TO_BOARD) of each command."""
    mission = scenario.mission
    assert mission is not None
    if scenario.gait is not None:
        gait = scenario.gait
        numbers = (gait.frequency, *gait.amplitude, *lags(gait), *gait.bias)
        yield START, give("arm")
        dives = scenario.silent is not None
        yield START + 1, order("gait", *numbers, *([FINS, FINS] if dives else [0.0, 0.0]))
        if dives:
            yield DIVE, order("gait", *numbers, 0.0, 0.0)
        return
    if not mission.waypoints:
        return
    m = mission
    numbers = (*m.home, m.home_radius, m.home_speed, m.depth_max, m.reserve, m.duration, m.surface_every, m.stay)
    steps = [order("begin", *numbers, 0.0, 0.0, 0.0, *m.start, m.declination, m.silence_below)]
    steps += [order("waypoint", *waypoint) for waypoint in m.waypoints]
    steps += [order("corner", *corner) for corner in m.fence]
    # Like a ground station: the mission brings the origin of its coordinates, a fix the robot's position.
    steps += [order("origin", fix=scenario.origin)] if scenario.origin is not None else []
    begin = START + COLD * m.cold
    yield from enumerate([*steps, order("end")], begin)
    ready = begin + len(steps) + STORED
    yield from enumerate([give("arm"), give("mission")], ready)


def released_at(scenario: Scenario) -> int:
    """Return the tick of the last order, until which someone holds the robot at the surface; 0 with a cable."""
    return 0 if scenario.cable else max((tick for tick, _ in scheduled_orders(scenario)), default=0)


def random_messages(table: FirmwareTable, ticks: int, seed: int) -> Messages:
    """Return messages (ticks,) of TO_BOARD with noise, failing sensors, valid and invalid commands."""
    random = np.random.default_rng(WHOLE.check(seed, "seed", "give a whole number"))
    messages = np.zeros(ticks, TO_BOARD)
    counts = Counts(table, (0, 0))
    at_rest = _at_rest(counts)
    clock = np.arange(ticks)[:, None]
    swing = 400 * np.sin(0.01 * 2 * np.pi * clock * random.uniform(0.2, 4, len(at_rest)))
    samples = at_rest + swing + random.normal(0, 30, (ticks, len(at_rest))) + _added_events(counts, clock[:, 0])
    # A sensor fails for a while: silent, stuck, or random.
    for _ in range(ticks // 400):
        first, channel = int(random.integers(ticks)), int(random.integers(len(at_rest)))
        last = first + int(random.integers(1, 400))
        kind = random.integers(3)
        length = len(samples[first:last])
        samples[first:last, channel] = (
            NO_SAMPLE if kind == 0 else samples[first, channel] if kind == 1 else random.integers(-40000, 70000, length)
        )
    messages["sample"] = NO_SAMPLE
    messages["sample"][:, counts.channels] = np.clip(np.rint(samples), -(2**31), 2**31 - 1)
    messages["fix"] = random.integers(-2000, 2000, (ticks, 2))
    tick = clock[:, 0]
    contact = ((tick // 2000) % 4 < 3) & (tick % 30000 < 20000)
    messages["flags"] = FIXED * (tick % 100 == 0) | GROUND * contact | LEAK * (tick % 25000 > 24800)
    for k in np.flatnonzero(random.random(ticks) < 0.03):
        message = _random_order(table, random)
        for name in ("order", "which", "number"):
            messages[name][k] = message[name]
    messages["flags"][-1] |= LAST | STACK
    return messages


def _added_events(counts: Counts, clock: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return samples to add: dives to 4 m, a robot on its side, a battery that runs empty."""
    added = np.zeros((len(clock), len(counts.names)))
    index = {name: counts.names.index(name) for name in ("depth", "acceleration", "voltage")}
    scale = {name: counts.scale[k] for name, k in index.items()}
    added[:, index["depth"]] = np.maximum(0.0, 4.0 * np.sin(2 * np.pi * clock / 9000)) / scale["depth"]
    on_side = clock % 7000 > 6000
    for axis, gravity in ((1, 9.81), (2, -9.81)):
        added[:, index["acceleration"] + axis] = on_side * gravity / scale["acceleration"]
    added[:, index["voltage"]] = np.where(clock % 60000 > 59000, -3.5, 0.0) / scale["voltage"]
    return added


def _at_rest(counts: Counts) -> NDArray[np.float64]:
    """Return the samples of a robot that floats upright at the surface, its head to the south."""
    rest = counts.zero.copy()
    steady = {"pressure": [60e3], "acceleration": [0.0, 0.0, 9.81], "voltage": [15.0], "field": [0.0, 0.7, -0.7]}
    for name, values in steady.items():
        indices = [k for k, channel in enumerate(counts.names) if channel == name]
        rest[indices] += np.array(values) / counts.scale[indices]
    return rest


def _random_order(table: FirmwareTable, random: np.random.Generator) -> Any:
    """Return the message of a random order, valid or not."""
    groups, fraction = len(table.robot.joints), 0.01
    factor = float(random.choice([1.0, 1.0, 1.0, 3.0, math.nan]))
    match int(random.integers(9)):
        case 0:
            return give("arm" if random.random() < 0.95 else "disarm")
        case 1 if random.random() < 0.7:
            return give(str(random.choice(["mission", "mission", "pause", "go_on", "surface", "home", "manual"])))
        case 1:
            return order("give", which=int(random.integers(len(ORDERS_GIVEN) + 1)))
        case 2:
            index = int(random.integers(len(table.parameters)))
            parameter = table.parameters[index]
            low, high = parameter.low, parameter.high
            if table.fields[parameter.field][0] == "calibration":  # sensors stay sound, or it would never arm again
                low, high = (parameter.standard + fraction * (end - parameter.standard) for end in (low, high))
            return order("parameter", random.uniform(low, high) * factor, which=index)
        case 3:
            numbers = (*random.uniform(-50, 50, 2), 3.0, 0.3, 4.0 * factor, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            return order("begin", *numbers)
        case 4:
            return order("waypoint", *random.uniform(-50, 50, 2), random.uniform(0, 3), 0.3, 3.0 * factor)
        case 5:
            return order("end")
        case 6:
            return order("sticks", *random.uniform(-1, 1, 3) * factor)
        case _:
            bends = [float(j.bend_max or 0.0) for j in table.robot.joints]
            lags, fins = random.uniform(-3, 3, groups), random.uniform(-0.5, 0.5, 2)
            beat = (random.uniform(0, 6) * factor, *random.uniform(0, bends), *lags, *random.uniform(-0.2, 0.2, groups))
            return order("gait", *beat, *fins)
