"""What the twin reaches: tables of docs/twin.md, computed in both water laws and stored in study.json.

python validation/twin/study.py    # half a minute on two cores
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.hydraulics import circuits, servo_angle
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.cli.console import progress_bar
from hypertuna.description.changes import changed
from hypertuna.description.provenance import provenance
from hypertuna.description.schema.water import WaterLaw
from hypertuna.io.files import write_atomically
from hypertuna.paper.computed import SPEEDS, SWIM
from hypertuna.paper.ledger import published_value
from hypertuna.paper.seeds import taken_hash
from hypertuna.simulation.plant import parts_of
from hypertuna.simulation.run import TwinRun

STORED = Path(__file__).with_name("study.json")
OTHERS = Path(__file__).resolve().parents[2] / "examples"  # folder with robot files of other members of the family
WATERS: tuple[WaterLaw, ...] = ("lumped", "strip")
FREQUENCIES = range(1, 7)  # Hz
AMPLITUDE = (16, 25)  # deg, of joints I and II
LIMITS = (200, 250, 300, 400, 500, 600)  # kPa, working limits that are tried
BORES = (3, 4, 5, 6)  # mm, of the lines
THREADS = 2


@dataclass(frozen=True)
class Row:
    """A variant of the default robot: one thing changed, and in closed loop unless that is the change."""

    label: str
    values: Mapping[str, Any] = field(default_factory=dict)  # changed values by keys of the robot's file
    options: Mapping[str, Any] = field(default_factory=dict)  # of the twin's run


def limit(kpa: float) -> dict[str, float]:
    """Return values for a working limit [kPa]: the soft and hard limits and the sensor's range change with it."""
    work = 1e3 * kpa
    limits = {"pressure_work_pa": work, "pressure_soft_pa": 1.25 * work, "pressure_hard_pa": 1.5 * work}
    return {f"controller.{key}": value for key, value in limits.items()} | {"sensors.pressure.high": max(1e6, 2 * work)}


ROWS = (  # variants of the robot that are compared
    Row("default robot"),
    Row("open loop", options={"closed_loop": False}),
    *(Row(f"working limit {kpa} kPa", limit(kpa)) for kpa in LIMITS),
    Row("no limit", limit(2000)),
    *(Row(f"lines of {mm} mm", {"joints.line.bore_m": mm / 1e3}) for mm in (3, 4, 6)),
    *(Row(f"oil at {celsius} C", options={"temperature": celsius + 273.15}) for celsius in (10, 30)),
    *(Row(f"servos of {rate} rad/s", {"servos.piston pump.speed_rad_s": float(rate)}) for rate in (5, 10)),
    *(Row(f"filled to {kpa} kPa", {"joints.line.fill_pressure_pa": 1e3 * kpa}) for kpa in (30, 60, 90)),
    *(Row(f"{100 * air:g} % air", {"oil.air": air}) for air in (0.0, 0.03)),
)


def robots(water: WaterLaw) -> Iterator[tuple[str, ht.Robot, Mapping[str, Any]]]:
    """Yield label, robot and options of every row, then those of other robot files.

    The controller knows all but the oil, which nobody measures.
    """
    default = ht.load("hypertuna").using(water=water)
    for row in ROWS:
        unknown = any(key.startswith("oil.") for key in row.values)
        options = {"controller_robot": default} if unknown else {}
        yield row.label, changed(default, row.values), options | row.options
    for path in sorted(OTHERS.glob("hypertuna-*.toml")):
        yield path.stem, ht.load(path).using(water=water), {}


def swum(robot: ht.Robot, gait: ht.Gait, **options: Any) -> dict[str, Any]:
    """Return the arguments of a run that lasts as long as those of the paper's page."""
    return {"robot": robot, "gait": gait, "duration": SWIM, "start": "swimming", **options}


def eight(robot: ht.Robot, **options: Any) -> list[dict[str, Any]]:
    """Return the results of swimming the published gaits."""
    runs = [swum(robot, ht.named_gait(robot, name), **options) for name in SPEEDS]
    return ht.twins(runs, measure=numbers, threads=THREADS)


def numbers(run: TwinRun) -> dict[str, Any]:
    """Return bends, pressures, speed, power and frequent limits of the last beats."""
    assert run.status == "completed", f"{run.robot.name}, {run.gait}: {run.status}"
    high = run.pressure_max.reshape(-1, 2).max(axis=1) / 1e3
    return {
        "frequency_hz": run.gait.frequency,
        "harmonic_deg": np.degrees(run.first_harmonic).round(2).tolist(),
        "swing_deg": np.degrees(run.swing).round(2).tolist(),
        "pressure_kpa": high.round(1).tolist(),
        "lowest_kpa": round(float(run.pressure_min.min()) / 1e3, 1),
        "speed_m_s": round(run.speed, 4),
        "power_w": round(run.electrical_power, 2),
        "limits": [name.removesuffix("_limit") for name in run.limits if run.acting[name] > 0.05],
    }


def amplitudes(robot: ht.Robot, closed: bool) -> list[dict[str, Any]]:
    """Return the results of swimming with large amplitude at 1 to 6 Hz."""
    gaits = [ht.Gait.from_degrees(frequency=f, amplitude=AMPLITUDE, phase=(0, 0)) for f in FREQUENCIES]
    return ht.twins([swum(robot, gait, closed_loop=closed) for gait in gaits], measure=numbers, threads=THREADS)


def driven(robot: ht.Robot, frequency: float, amplitude: Any, medium: str) -> tuple[Any, Any]:
    """Return both joints' amplitude [deg] and largest pump pressure [kPa]; servos are driven by inverse volumes."""
    parts, models, oil = parts_of(robot, medium, None), joint_models(robot), circuits(robot)
    t = np.arange(400) * 0.01
    target = np.zeros((len(t), 4))
    for j in range(2):
        bend = np.radians(amplitude[j]) * np.sin(2 * np.pi * frequency * t) * np.minimum(1, t * frequency)
        gained = models[j].hold(bend)["volume"] - models[j].at(0.0)["volume"][0]
        for side in range(2):
            target[:, 2 * j + side] = servo_angle(oil, gained[:, side], 2 * j + side)
    world = _core.World({"clamped": medium == "air"})
    target = np.nan_to_num(target, nan=1.2)
    out = _core.simulate(parts.plant, target, world, twist=np.zeros(6), tick=0.01, steps=20)
    last = slice(200, 400)
    turn = np.exp(-2j * np.pi * frequency * t[last])
    angle = np.degrees(abs(2 * np.mean(out["angle"][last] * turn[:, None], axis=0)))
    return angle, out["pump_pressure_high"][last].max(axis=0).reshape(2, 2).max(axis=1) / 1e3


def bores() -> Iterator[dict[str, Any]]:
    """Yield the pressure for 20 deg of joint II at the cylinder in Fig. 8, with joint I at rest and at 16 deg."""
    for mm in BORES:
        robot, cells = changed(ht.load("hypertuna"), {"joints.line.bore_m": mm / 1e3}), []
        for frequency, other in ((1, 0.0), (3, 0.0), (6, 0.0), (6, 16.0)):
            amplitude = np.array([other, 20.0])
            for _ in range(10):
                angle, pressure = driven(robot, frequency, amplitude, "air")
                amplitude[1] = min(amplitude[1] * np.clip(20 / angle[1], 0.5, 1.5), 40.0)
            cells.append([round(float(pressure[1]), 1), round(float(angle[1]), 2)])
        yield {"bore_mm": mm, "pressure_kpa_and_bend_deg": cells}


def compute() -> dict[str, Any]:
    """Return the results of all runs, by water law."""
    found: dict[str, dict[str, Any]] = {water: {"rows": {}} for water in WATERS}
    todo = [(water, *one) for water in WATERS for one in robots(water)]
    with progress_bar("rows", slow=True) as progress:
        for k, (water, label, robot, options) in enumerate(todo):
            runs = eight(robot, **options)
            row = {key: [run[key] for run in runs] for key in ("speed_m_s", "power_w")}
            found[water]["rows"][label] = row | {"rms_percent": round(100 * rms(row["speed_m_s"]), 2)}
            if label == ROWS[0].label:
                found[water]["gaits"] = dict(zip(SPEEDS, runs, strict=True))
                found[water] |= {loop: amplitudes(robot, loop == "closed") for loop in ("closed", "open")}
            progress(k + 1, len(todo))
    return found | {"bores": list(bores())}


def rms(speeds: Sequence[float], names: Sequence[str] = SPEEDS) -> float:
    """Return the rms error of speeds [1]."""
    return math.sqrt(
        np.mean([(u / published_value(f"speed/{name}") - 1) ** 2 for u, name in zip(speeds, names, strict=True)])
    )


def store(path: Path, content: Mapping[str, Any], script: str) -> None:
    """Write results with the script and robot that made them."""
    robot = ht.load("hypertuna")
    facts = {key: provenance(robot)[key] for key in ("hypertuna_version", "isa")} | {"taken_hash": taken_hash(robot)}
    write_atomically(path, lines(facts | {"command": f"python validation/twin/{script}"} | content))


def lines(record: Mapping[str, Any]) -> bytes:
    """Return a record as JSON, each list of numbers on one line."""
    text = json.dumps(record, indent=1)
    return (re.sub(r"\[[^][{}]*\]", lambda found: re.sub(r"\s+", " ", found[0]), text) + "\n").encode()


if __name__ == "__main__":
    store(STORED, compute(), "study.py")
