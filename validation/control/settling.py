"""Settling of the posture control over seeds, and what the bend sensor can show at best (a minute on one core).

python validation/control/settling.py            # print the table of docs/control.md from settling.json
python validation/control/settling.py --compute  # compute it anew, and store it in settling.json
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.control.sensors import sensor_of
from hypertuna.description.provenance import provenance
from hypertuna.io.files import write_atomically
from hypertuna.paper.ledger import published
from hypertuna.simulation.posture import MAX_ERROR, fitted_peaks, hold, peak_bends

STORED = Path(__file__).with_name("settling.json")
ROBOT = "hypertuna"
SEEDS = range(32)
WITHIN = 4.0  # s in which the paper's joints settle, section III.C
FACTS = published()["posture"]  # published numbers of the posture test
ANGLE, SECONDS = math.radians(FACTS["angle_deg"]), FACTS["duration_s"]  # commanded amplitude [rad]; duration of a run
METERS = {  # ways to know a beat's peak bends: the key of a record, and its name in the table
    "bend": "true bend",
    "fit": "sensor",  # harmonics fitted to each beat
    "readings": "single readings",  # the sensor's largest of each beat
}


def settling_times(robot: ht.Robot, frequency: float, seed: int) -> dict[str, float | None]:
    """Return the settling times [s] of a run by each meter; None where it does not settle."""
    angle = [ANGLE if group.name == FACTS["joint"] else 0.0 for group in robot.joints]
    (held,) = hold(robot, frequency, angle, duration=SECONDS, medium="air", seed=seed)
    _, largest = peak_bends(held.run.time, held.run.data["angle_measured"][:, held.joint], frequency)
    readings = replace(held, measured=largest).settling_measured
    return {"bend": held.settling, "fit": held.settling_measured, "readings": readings}


def ideal_share(robot: ht.Robot, frequency: float, draws: int = 200) -> dict[str, float]:
    """Return the share of joints that beat by the set angle exactly and that each sensor meter sees settled in time."""
    sensor, random = sensor_of(robot, "bend"), np.random.default_rng(0)
    rate = robot.controller.rate if robot.controller else math.nan
    time = np.arange(0, SECONDS, 1 / rate)
    seen = {"fit": 0, "readings": 0}
    for _ in range(draws):
        phase = 2 * math.pi * frequency * time - random.uniform(0, 2 * math.pi)
        noisy = ANGLE * np.sin(phase) + sensor.noise * random.normal(size=len(time))
        read = np.round(noisy / sensor.resolution) * sensor.resolution
        for name, meter in (("fit", fitted_peaks), ("readings", peak_bends)):
            end, peaks = meter(time, read, frequency)
            seen[name] += bool(abs(peaks[end >= WITHIN] - ANGLE).max() < MAX_ERROR)
    return {name: count / draws for name, count in seen.items()}


def compute() -> dict[str, Any]:
    """Run all seeds."""
    robot = ht.load(ROBOT)
    rows = []
    for frequency in FACTS["frequency_hz"]:
        runs = [settling_times(robot, frequency, seed) for seed in SEEDS]
        times = {meter: [run[meter] for run in runs] for meter in METERS}
        rows.append({"frequency_hz": frequency, "settling_s": times, "ideal_share": ideal_share(robot, frequency)})
    facts = {key: provenance(robot)[key] for key in ("hypertuna_version", "isa", "robot", "robot_hash")}
    facts["command"] = "python validation/control/settling.py --compute"
    return facts | {"seeds": list(SEEDS), "rows": rows}


def table() -> str:
    """Return what is stored as a table: median, 90th percentile and share within 4 s; what ideal joints show."""
    record = json.loads(STORED.read_text(encoding="utf-8"))
    heads = [f"{name}: median [s]; 90 % [s]; in {WITHIN:g} s [%]" for name in METERS.values()]
    heads += [f"ideal joint by {METERS[meter]} [%]" for meter in ("fit", "readings")]
    lines = [["f [Hz]", *heads], ["---:"] * (len(heads) + 1)]
    for row in record["rows"]:
        cells = [_cell(row["settling_s"][meter]) for meter in METERS]
        ideal = [f"{100 * row['ideal_share'][meter]:.0f}" for meter in ("fit", "readings")]
        lines.append([f"{row['frequency_hz']:g}", *cells, *ideal])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(times: Sequence[float | None]) -> str:
    """Return median, 90th percentile and share in time; a run that does not settle comes last."""
    known = np.array([math.inf if time is None else time for time in times], dtype=np.float64)
    ends = (float(np.quantile(known, part, method="higher")) for part in (0.5, 0.9))
    spelled = [f"{end:.2f}" if math.isfinite(end) else "–" for end in ends]
    return "; ".join([*spelled, f"{100 * np.mean(known <= WITHIN):.0f}"])


def main() -> None:
    """Compute and store, or print what is stored."""
    if "--compute" in sys.argv:
        write_atomically(STORED, (json.dumps(compute(), indent=1) + "\n").encode())
    print(table())


if __name__ == "__main__":
    main()
