"""Pressures of random twins, for README.md. Run: python validation/control/pressures.py [RUNS [FIRST_SEED]] [-j JOBS].

Each run is a line of a file in build/ for this robot, and not repeated; the summary is stored in pressures.json.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import hypertuna as ht
from hypertuna import _core
from hypertuna.control.sensors import KINDS, channels
from hypertuna.control.sensors import faults as read_faults
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, parse
from hypertuna.simulation.plant import controller_of, parts_of, steps_of

HERE = Path(__file__).parent
ROBOT = ht.load("hypertuna")
TABLE, RECORD = HERE.parents[1] / "build" / f"pressures-{ROBOT.hash[:12]}.csv", HERE / "pressures.json"
LIMIT = (ROBOT.controller.pressure_hard or math.nan) / 1e3 if ROBOT.controller else math.nan  # kPa: the hard limit
HARD = 1.05 * LIMIT
STIFFNESS = {"modulus_100_pa", "modulus_fe_pa", "tensile_pa"}  # of a silicone, by any set
SECONDS, TICK = 6.0, 0.01  # of a run, and of control [s]
KELVIN, SILICONE_AT = 273.15, 293.15
# Of oil and silicone [C]: from the oil's pour point to 60.
TEMPERATURES = (-9.0, *np.arange(-5.0, 61.0, 5.0).tolist())
SUPPLIES = (7.4, 6.8, 6.2, 5.6, 5.0)  # V: of the converter, the first its own
SENSORS = {"pressure": 0.55, "bend": 0.25, "current": 0.1, "battery": 0.1}  # share of the faults
CIRCUITS = ("I-left", "I-right", "II-left", "II-right")
COLUMNS = (
    *("seed", "temperature_c", "medium", "supply_v", "commands", "faults", "peak_kpa", "unit_kpa", "time_s", "circuit"),
    *("frequency_hz", "hard_stop_s", "flags", "status"),
)


class Order(NamedTuple):
    """A command from a time on [s, Hz, rad]."""

    since: float
    frequency: float
    amplitude: tuple[float, ...]
    phase: tuple[float, ...]
    bias: tuple[float, ...]
    armed: bool


class Sample(NamedTuple):
    """A run."""

    temperature: float  # C
    air: bool
    supply: float  # V at the servos
    orders: tuple[Order, ...]
    faults: tuple[str, ...]


def sample(seed: int) -> Sample:
    """Sample a run: medium, temperature, supply, a gait with steps of its command, and none to two sensor faults."""
    random = np.random.default_rng(seed)
    place, air = int(random.integers(len(TEMPERATURES))), bool(random.random() < 0.5)
    supply = float(random.choice(SUPPLIES, p=(0.5, 0.125, 0.125, 0.125, 0.125)))
    orders = tuple(_orders(random))
    named = channels(ROBOT, pilot=False)
    share = random.random()
    faults = []
    for _ in range(0 if share < 0.25 else 1 if share < 0.85 else 2):
        part = random.choice(list(SENSORS), p=list(SENSORS.values()))
        name = random.choice([name for name in named if name.split("-")[0] == part])
        start = random.uniform(0, SECONDS - TICK)
        end = "" if random.random() < 0.8 else f"-{start + random.uniform(0.05, 2):.2f}"
        faults.append(f"{name}:{random.choice(list(KINDS))}@{start:.2f}{end}")
    return Sample(TEMPERATURES[place], air, supply, orders, tuple(faults))


def _orders(random: np.random.Generator) -> Iterator[Order]:
    """Sample a gait of up to 8 Hz within the joints' bends, and up to three steps of its command."""
    bends = [float(group.bend_max or 0.0) for group in ROBOT.joints]

    def frequency() -> float:
        return float(random.uniform(0.2, 8))

    def amplitude() -> tuple[float, ...]:
        return tuple(random.uniform(0, bend) for bend in bends) if random.random() < 0.7 else tuple(bends)

    def phase() -> tuple[float, ...]:
        return 0.0, math.radians(random.uniform(0, 180))

    def bias() -> tuple[float, ...]:
        return tuple(random.uniform(-bend, bend) for bend in bends)

    def rarely_biased() -> tuple[float, ...]:
        return bias() if random.random() < 0.3 else (0.0,) * len(bends)

    order = Order(0.0, frequency(), amplitude(), phase(), rarely_biased(), True)
    yield order
    for time in sorted(random.uniform(0.5, SECONDS, int(random.integers(4)))):
        change: dict[str, Any] = (
            lambda: {"frequency": frequency()},
            lambda: {"amplitude": amplitude()},
            lambda: {"phase": phase()},
            lambda: {"bias": bias()},
            lambda: {"frequency": frequency(), "amplitude": amplitude(), "phase": phase(), "bias": rarely_biased()},
            lambda armed=order.armed: {"armed": not armed},
        )[int(random.integers(6))]()
        order = order._replace(since=float(time), **change)
        yield order


@cache
def robot_at(temperature: float, supply: float) -> Robot:
    """Return the robot at a temperature [C] and a supply of its servos [V].

    Silicones are as stiff as rubber is: in proportion to the absolute temperature.
    """
    document = ROBOT.document()
    factor = (temperature + KELVIN) / SILICONE_AT
    for material in document["materials"].values():
        for key in STIFFNESS & material.keys():
            value = material[key]
            material[key] = [factor * part for part in value] if isinstance(value, list) else factor * value
    document["battery"]["converter_v"] = supply
    return parse(document, file=ROBOT.file)


def run_of(seed: int, run: Sample) -> tuple[dict[str, np.ndarray], bool]:
    """Run a sample; return its record, and whether it went to its end.

    The controller is that of the robot's own description: it knows neither temperature nor supply.
    """
    robot, ticks = robot_at(run.temperature, run.supply), round(SECONDS / TICK)
    parts = parts_of(robot, "air" if run.air else "water", run.temperature + KELVIN)
    columns = {name: np.array([getattr(order, name) for order in run.orders], dtype=float) for name in Order._fields}
    record = _core.simulate(
        parts.plant,
        _core.GaitCommand(_core.LiveController(controller_of(ROBOT)), columns, lost_at=math.inf),
        _core.World({"clamped": float(run.air)}),
        sensors=_core.Sensors(parts.sensors, seed),
        faults=list(read_faults(run.faults, ROBOT, SECONDS)),
        twist=np.zeros(6),
        ticks=ticks,
        steps=steps_of(TICK, parts, robot),
        every=1,
    )
    return record, int(record["ticks"][0]) == ticks


def row(seed: int) -> dict[str, Any]:
    """Run a seed and return its line."""
    run = sample(seed)
    record, whole = run_of(seed, run)
    pump, unit = (record[f"{part}_pressure_high"] for part in ("pump", "unit"))
    tick, circuit = np.unravel_index(np.maximum(pump, unit).argmax(), pump.shape)
    flags = record["status"].astype(np.int64)
    names = [name for name, _, _ in _core.condition_table()]
    stops = np.flatnonzero(flags >> names.index("hard_stop") & 1)
    order = next(order for order in reversed(run.orders) if order.since <= tick * TICK)
    values = (
        *(seed, f"{run.temperature:g}", "air" if run.air else "water", f"{run.supply:g}", len(run.orders)),
        *(" ".join(run.faults), f"{pump.max() / 1e3:.1f}", f"{unit.max() / 1e3:.1f}", f"{tick * TICK:.2f}"),
        *(CIRCUITS[circuit], f"{order.frequency:.2f}", f"{stops[0] * TICK:.2f}" if stops.size else ""),
        *(f"{int(np.bitwise_or.reduce(flags)):05x}", "completed" if whole else "diverged"),
    )
    return dict(zip(COLUMNS, values, strict=True))


def cause(line: dict[str, str]) -> str:
    """Return medium, temperature of the oil, and which sensors were faulty before the peak."""
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


def summary(lines: list[dict[str, str]]) -> dict[str, Any]:
    """Summarize runs: how high their pressures went, and why those above the limit did."""
    peaks = np.array([max(float(line["peak_kpa"]), float(line["unit_kpa"])) for line in lines])
    over = [line for line, peak in zip(lines, peaks, strict=True) if peak > HARD]
    return {
        "runs": len(lines),
        "bound_kpa": HARD,
        "above_bound": len(over),
        "above_hard_limit": int((peaks > LIMIT).sum()),
        "largest_kpa": float(peaks.max()),
        "quantiles_kpa": {f"{100 * q:g} %": round(float(np.quantile(peaks, q)), 1) for q in (0.5, 0.9, 0.99, 0.999)},
        "hard_stops": sum(bool(line["hard_stop_s"]) for line in lines),
        "diverged": sum(line["status"] != "completed" for line in lines),
        "causes": dict(Counter(cause(line) for line in over).most_common()),
        "worst": [line["seed"] for line in sorted(over, key=lambda line: -float(line["peak_kpa"]))[:20]],
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
    record = {"provenance": provenance(ROBOT), **summary([lines[seed] for seed in seeds])}
    RECORD.write_text(json.dumps(record, indent=1) + "\n")
    print(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
