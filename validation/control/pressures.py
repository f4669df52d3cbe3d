"""Pressures of random twins, for README.md. Run: python validation/control/pressures.py [RUNS [FIRST_SEED]] [-j JOBS].

Each run is a line of a file in build/ for this controller, and not repeated; the summary is stored in pressures.json.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.hydraulics import drive_names
from hypertuna.actuation.new import first_robot
from hypertuna.control.sensors import KINDS, channels, sensor_of
from hypertuna.control.sensors import faults as read_faults
from hypertuna.description.changes import changed
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, parse
from hypertuna.simulation.plant import controller_of, parts_of, steps_of

HERE = Path(__file__).parent
HOUSE = HERE.parents[1]  # the repository
DEFAULT = ht.load("hypertuna")
TABLE, RECORD = HOUSE / "build" / f"pressures-{DEFAULT.hash[:12]}.csv", HERE / "pressures.json"
FAMILY = HOUSE / "data" / "twin" / "family.json"
OWN = 30  # number of robots that `robot new` writes
ROBOTS = {"hypertuna": 0.25, "low": 0.15, "family": 0.2, "own": 0.4}  # share of the runs
LOW = {"work": 200e3, "soft": 250e3, "hard": 300e3}  # Pa: limits far below the pressures of HyperTuna's healthy beats
BOUND = 1.05  # pressure over the hard limit beyond which a run is counted and explained
STIFFNESS = {"modulus_100_pa", "modulus_fe_pa", "tensile_pa"}  # keys of a silicone's stiffness, whatever its law
# A run takes at least SECONDS [s] and BEATS, at most LONGEST [s]; the control period [s]
SECONDS, BEATS, LONGEST, TICK = 6.0, 1.5, 24.0, 0.01
SLOWEST, FASTEST = 0.05, 8.0  # Hz, of the beats
# 0 C in kelvins; temperature [K] at which the stiffness of the robot's file holds
KELVIN, SILICONE_AT = 273.15, 293.15
# Of oil and silicone [C]: from the oil's pour point to 60.
TEMPERATURES = (-9.0, *np.arange(-5.0, 61.0, 5.0).tolist())
SUPPLIES = (1.0, 0.92, 0.84, 0.76, 0.68)  # servos' voltage over the converter's rated one
SENSORS = {"pressure": 0.7, "bend": 0.16, "current": 0.07, "battery": 0.07}  # how probable a fault is, by sensor
WRONG = 30e3  # Pa: a reading this far from the truth must be reported
TOLD, TOLD_BEAT = 2.0, 0.1  # a report may take so many seconds, or so many beats where that is longer
KEPT = 2 / 3  # an unreported fault must leave at least this share of the healthy swing
COLUMNS = (  # of the table
    *("seed", "robot", "temperature_c", "medium", "supply", "commands", "faults", "hard_kpa", "peak_kpa", "unit_kpa"),
    *("time_s", "circuit", "frequency_hz", "hard_stop_s", "flags", "wrong", "late", "blamed", "harm", "false"),
    "status",
)


class Order(NamedTuple):
    """A command of the controller, from a time on [s, Hz, rad]."""

    since: float
    frequency: float
    amplitude: tuple[float, ...]
    phase: tuple[float, ...]
    bias: tuple[float, ...]
    armed: bool


class Sample(NamedTuple):
    """Robot, conditions, commands and faults of a run."""

    robot: str  # "hypertuna", "low", "family N" or "own N"
    temperature: float  # C
    air: bool
    supply: float  # part of the servos' voltage
    orders: tuple[Order, ...]
    faults: tuple[str, ...]
    seconds: float  # duration


def sample(seed: int) -> Sample:
    """Sample a run: robot, medium, temperature, supply, a gait with steps of its command, and sensor faults."""
    random = np.random.default_rng(seed)
    name = str(random.choice(list(ROBOTS), p=list(ROBOTS.values())))
    if name in ("family", "own"):
        name += f" {int(random.integers(OWN if name == 'own' else len(family())))}"
    robot = robot_of(name)
    place, air = int(random.integers(len(TEMPERATURES))), bool(random.random() < 0.5)
    supply = float(random.choice(SUPPLIES, p=(0.5, 0.125, 0.125, 0.125, 0.125)))
    slow = _frequency(random, robot)
    seconds = min(LONGEST, max(SECONDS, BEATS / slow))
    orders = tuple(_orders(random, robot, slow, seconds))
    faults = tuple(_faults(random, robot, seconds))
    return Sample(name, TEMPERATURES[place], air, supply, orders, faults, seconds)


def _frequency(random: np.random.Generator, robot: Robot) -> float:
    fastest = min(FASTEST, robot.controller.frequency_max if robot.controller else FASTEST)
    return float(SLOWEST * (fastest / SLOWEST) ** random.random())


def _faults(random: np.random.Generator, robot: Robot, seconds: float) -> Iterator[str]:
    """Sample none to two faults, a fifth of them early; a fault lasts, ends, or comes and goes."""
    named = channels(robot, pilot=False)
    share = random.random()
    for _ in range(0 if share < 0.2 else 1 if share < 0.75 else 2):
        part = random.choice(list(SENSORS), p=list(SENSORS.values()))
        fault = f"{random.choice([name for name in named if name.split('-')[0] == part])}:{random.choice(list(KINDS))}"
        start = float(random.uniform(0, 1 if random.random() < 0.2 else seconds - TICK))
        lasts = random.random()
        if lasts < 0.7:
            yield f"{fault}@{start:.2f}"
        elif lasts < 0.85:
            yield f"{fault}@{start:.2f}-{start + random.uniform(0.05, 2):.2f}"
        else:
            while start < seconds - TICK:
                end = start + float(random.uniform(0.02, 0.5))
                yield f"{fault}@{start:.2f}-{end:.2f}"
                start = end + float(random.uniform(0.02, 1))


def _orders(random: np.random.Generator, robot: Robot, slow: float, seconds: float) -> Iterator[Order]:
    """Sample a gait within the joints' bends, the slowest of the run, and up to three steps of its command."""
    bends = [float(group.bend_max or 0.0) for group in robot.joints]

    def frequency() -> float:
        return max(slow, _frequency(random, robot))

    def amplitude() -> tuple[float, ...]:
        return tuple(random.uniform(0, bend) for bend in bends) if random.random() < 0.7 else tuple(bends)

    def phase() -> tuple[float, ...]:
        return 0.0, *(math.radians(random.uniform(-180, 180)) for _ in bends[1:])

    def bias() -> tuple[float, ...]:
        return tuple(random.uniform(-bend, bend) for bend in bends)

    def often_biased() -> tuple[float, ...]:
        return bias() if random.random() < 0.5 else (0.0,) * len(bends)

    order = Order(0.0, slow, amplitude(), phase(), often_biased(), True)
    yield order
    for time in sorted(random.uniform(0.5, seconds, int(random.integers(4)))):
        change: dict[str, Any] = (
            lambda: {"frequency": frequency()},
            lambda: {"amplitude": amplitude()},
            lambda: {"phase": phase()},
            lambda: {"bias": bias()},
            lambda: {"frequency": frequency(), "amplitude": amplitude(), "phase": phase(), "bias": often_biased()},
            lambda armed=order.armed: {"armed": not armed},
        )[int(random.integers(6))]()
        order = order._replace(since=float(time), **change)
        yield order


@cache
def family() -> list[dict[str, Any]]:
    """Return the stored members of HyperTuna's family."""
    members: list[dict[str, Any]] = json.loads(FAMILY.read_text(encoding="utf-8"))["members"]
    return members


@cache
def robot_of(name: str) -> Robot:
    """Return the robot of a name: HyperTuna, with its own or low limits, of its family, or written by `robot new`."""
    kind, _, number = name.partition(" ")
    if kind == "hypertuna":
        return DEFAULT
    if kind == "low":
        return changed(DEFAULT, {f"controller.pressure_{limit}_pa": value for limit, value in LOW.items()})
    if kind == "family":
        return changed(DEFAULT, family()[int(number)]["changes"])
    random = np.random.default_rng(int(number))
    links, length = int(random.integers(2, 6)), float(0.15 * (3.0 / 0.15) ** random.random())
    text = first_robot(f"own-{number}", links=links, length=length, actuation="hydraulic")
    return parse(tomllib.loads(text), file=name)


@cache
def robot_at(name: str, temperature: float, supply: float) -> Robot:
    """Return a robot at a temperature [C] and with a part of its servos' voltage.

    Silicones are as stiff as rubber is: in proportion to the absolute temperature.
    """
    document = robot_of(name).document()
    factor = (temperature + KELVIN) / SILICONE_AT
    for material in document["materials"].values():
        for key in STIFFNESS & material.keys():
            value = material[key]
            material[key] = [factor * part for part in value] if isinstance(value, list) else factor * value
    document["battery"]["converter_v"] *= supply
    return parse(document, file=robot_of(name).file)


def run_of(seed: int, run: Sample) -> tuple[dict[str, np.ndarray], bool]:
    """Run a sample; return its record, and whether it ran to its end without diverging.

    The controller is that of the robot's own description: it knows neither temperature nor supply.
    """
    own, robot, ticks = robot_of(run.robot), robot_at(*run[:2], run.supply), round(run.seconds / TICK)
    parts = parts_of(robot, "air" if run.air else "water", run.temperature + KELVIN)
    columns = {name: np.array([getattr(order, name) for order in run.orders], dtype=float) for name in Order._fields}
    record = _core.simulate(
        parts.plant,
        _core.GaitCommand(_core.LiveController(controller_of(own)), columns, lost_at=math.inf),
        _core.World({"clamped": float(run.air)}),
        sensors=_core.Sensors(parts.sensors, seed),
        faults=list(read_faults(run.faults, own, run.seconds)),
        twist=np.zeros(6),
        ticks=ticks,
        steps=steps_of(TICK, parts, robot),
        every=1,
    )
    return record, int(record["ticks"][0]) == ticks


class Told(NamedTuple):
    """Which faults of pressure sensors a run reported, and which it did not."""

    wrong: tuple[str, ...]  # circuits whose readings were wrong for longer than a report may take
    late: tuple[str, ...]  # those of them reported too late, or never
    blamed: tuple[str, ...]  # those for which the joint's other circuit was reported instead
    false: bool  # whether a circuit without a fault was reported


def told(run: Sample, record: dict[str, np.ndarray]) -> Told:
    """Compare the reported faults of pressure sensors with the true ones."""
    robot, wrong, late, blamed, false = robot_of(run.robot), [], [], [], False
    places = record["status_at"][:, CONDITIONS.index("pressure_fault")].astype(np.int64)
    sensor = sensor_of(robot, "pressure")
    off = ~(abs(record["pressure_measured"] - np.clip(record["pump_pressure"], sensor.low, sensor.high)) <= WRONG)
    faulty = [(fault.first, fault.last) for fault in read_faults(run.faults, robot, run.seconds)]
    first = channels(robot, pilot=False)["pressure"][0]
    for c, name in enumerate(drive_names(robot)):
        has = any(low <= first + c <= high for low, high in faulty)
        seen = places >> c & 1
        false |= not has and bool(seen.any())
        since = np.flatnonzero(off[:, c])
        if not (has and since.size):
            continue
        frequency = max(order.frequency for order in run.orders)
        end = since[0] + round(max(TOLD, TOLD_BEAT / frequency) / TICK)
        lasts = [f for f in read_faults(run.faults, robot, run.seconds) if f.first <= first + c <= f.last]
        if end >= len(off) or len(lasts) > 1 or lasts[0].end < (end + 1) * TICK:
            continue
        wrong.append(name)
        if not seen[: end + 1].any():
            other = places[: end + 1] >> (c ^ 1) & 1
            (blamed if other.any() else late).append(name)
    return Told(tuple(wrong), tuple(late), tuple(blamed), false)


def without(run: Sample, circuits: Sequence[str]) -> Sample:
    """Return a run without the faults of these circuits' pressure sensors."""
    robot = robot_of(run.robot)
    first = channels(robot, pilot=False)["pressure"][0]
    places = {first + drive_names(robot).index(name) for name in circuits}
    hit = [places.isdisjoint(range(f.first, f.last + 1)) for f in read_faults(run.faults, robot, run.seconds)]
    return run._replace(faults=tuple(fault for fault, kept in zip(run.faults, hit, strict=True) if kept))


def harmed(seed: int, run: Sample, record: dict[str, np.ndarray], late: Sequence[str]) -> bool:
    """Return whether unreported faults of circuits led beyond the hard limit, or left less of the swing than `KEPT`.

    Compared is the same run without these faults, but with all others: what those take is no harm of these.
    """
    control = robot_of(run.robot).controller
    assert control is not None
    other, _ = run_of(seed, without(run, late))
    high, allowed = (np.maximum(one["pump_pressure_high"], one["unit_pressure_high"]).max() for one in (record, other))
    if high > max(control.pressure_hard or 0, allowed):
        return True
    swing, whole = (np.ptp(one["angle"][len(one["angle"]) // 2 :], axis=0) for one in (record, other))
    return bool((swing < KEPT * whole - math.radians(0.5)).any())


CONDITIONS = [name for name, _, _ in _core.condition_table()]


def row(seed: int) -> dict[str, Any]:
    """Run a seed; return its line of the table."""
    run = sample(seed)
    record, whole = run_of(seed, run)
    robot = robot_of(run.robot)
    assert robot.controller is not None
    pump, unit = (record[f"{part}_pressure_high"] for part in ("pump", "unit"))
    tick, circuit = np.unravel_index(np.maximum(pump, unit).argmax(), pump.shape)
    flags = record["status"].astype(np.int64)
    stops = np.flatnonzero(flags >> CONDITIONS.index("hard_stop") & 1)
    order = next(order for order in reversed(run.orders) if order.since <= tick * TICK)
    words = told(run, record)
    harm = bool(words.late) and harmed(seed, run, record, words.late)
    values = (
        *(seed, run.robot, f"{run.temperature:g}", "air" if run.air else "water", f"{run.supply:g}", len(run.orders)),
        *(" ".join(run.faults), f"{(robot.controller.pressure_hard or 0) / 1e3:g}", f"{pump.max() / 1e3:.1f}"),
        *(f"{unit.max() / 1e3:.1f}", f"{tick * TICK:.2f}", drive_names(robot)[circuit], f"{order.frequency:.3g}"),
        *(f"{stops[0] * TICK:.2f}" if stops.size else "", f"{int(np.bitwise_or.reduce(flags)):05x}"),
        *(" ".join(part) for part in (words.wrong, words.late, words.blamed)),
        *(int(harm), int(words.false), "completed" if whole else "diverged"),
    )
    return dict(zip(COLUMNS, values, strict=True))


def cause(line: dict[str, str]) -> str:
    """Describe what a peak of pressure goes with: medium, temperature of the oil, and sensors at fault before it."""
    temperature, peak = float(line["temperature_c"]), float(line["time_s"])
    faults = [fault.split("@") for fault in line["faults"].split()]
    parts = {name.split("-")[0].split(":")[0] for name, time in faults if float(time.split("-")[0]) <= peak}
    oil = "cold" if temperature < 10 else "warm" if temperature <= 30 else "hot"
    return f"{line['medium']}, {oil} oil, {' and '.join(sorted(parts)) or 'no'} fault"


def known() -> dict[int, dict[str, str]]:
    """Return the lines of the table by their seeds."""
    if not TABLE.exists():
        return {}
    with TABLE.open(newline="") as file:
        return {int(line["seed"]): line for line in csv.DictReader(file)}


def compute(seeds: list[int], jobs: int) -> None:
    """Run seeds and append their lines."""
    TABLE.parent.mkdir(exist_ok=True)
    fresh = not TABLE.exists()
    with TABLE.open("a", newline="") as file, ProcessPoolExecutor(jobs) as pool:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if fresh:
            writer.writeheader()
        for line in pool.map(row, seeds, chunksize=8):
            writer.writerow(line)
            file.flush()


def over(line: dict[str, str]) -> float:
    """Return a run's largest pressure, divided by its hard limit."""
    return max(float(line["peak_kpa"]), float(line["unit_kpa"])) / float(line["hard_kpa"])


def summary(lines: list[dict[str, str]]) -> dict[str, Any]:
    """Summarize runs: how high their pressures went, why those above the limit did, and what was told."""
    peaks = np.array([over(line) for line in lines])
    above = [line for line, peak in zip(lines, peaks, strict=True) if peak > BOUND]
    wrong = [line for line in lines if line["wrong"]]
    return {
        "runs": len(lines),
        "robots": dict(Counter(line["robot"].split()[0] for line in lines)),
        "above_bound": len(above),
        "above_hard_limit": int((peaks > 1).sum()),
        "largest_over_limit": round(float(peaks.max()), 3),
        "quantiles_over_limit": {
            f"{100 * q:g} %": round(float(np.quantile(peaks, q)), 3) for q in (0.5, 0.9, 0.99, 0.999)
        },
        "wrong_pressure_sensors": len(wrong),
        "told_late_or_never": sum(bool(line["late"]) for line in wrong),
        "of_these_harmful": sum(line["harm"] == "1" for line in wrong),
        "false_alarms": sum(line["false"] == "1" for line in lines),
        "hard_stops": sum(bool(line["hard_stop_s"]) for line in lines),
        "diverged": sum(line["status"] != "completed" for line in lines),
        "causes": dict(Counter(cause(line) for line in above).most_common()),
        "worst": [line["seed"] for line in sorted(above, key=over, reverse=True)[:20]],
    }


def main() -> None:
    """Run what the table lacks, and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=int, nargs="?", default=10_000)
    parser.add_argument("first", type=int, nargs="?", default=0)
    parser.add_argument("-j", "--jobs", type=int, default=1)
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.runs)
    done = known()
    compute([seed for seed in seeds if seed not in done], options.jobs)
    lines = known()
    record = {"provenance": provenance(DEFAULT), **summary([lines[seed] for seed in seeds])}
    RECORD.write_text(json.dumps(record, indent=1) + "\n")
    print(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
