"""Which estimate matters, and what a soft caudal fin would change: tables of docs/twin.md, stored in influence.json.

python validation/twin/influence.py    # two minutes on two cores
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from sensitivity import influence
from study import WATERS, eight, rms, store

import hypertuna as ht
from hypertuna.cli.console import progress_bar
from hypertuna.description.changes import changed
from hypertuna.description.robot import parse
from hypertuna.paper.computed import SPEEDS
from hypertuna.simulation.estimates import spreads

STORED = Path(__file__).with_name("influence.json")
SAMPLES = 64  # of Saltelli's scheme
GAIT = "unoptimised-max"  # 6 Hz, large amplitude
HINGES = (math.inf, 1.0, 0.5, 0.3, 0.2, 0.1)  # N m/rad, stiffness of the fin's root


def indices(robot: ht.Robot) -> dict[str, Any]:
    """Return Sobol's total indices of reach and speed, with half-widths of 95 % intervals."""
    robot = changed(robot, {"sensors.pressure.high": 1e6})  # reads every limit
    with progress_bar(f"indices, {robot.model.water}", slow=True) as progress:
        found = influence(robot, ht.named_gait(robot, GAIT), samples=SAMPLES, progress=progress)
    assert not found.diverged
    rows = zip(spreads(robot).values(), found.total.T, found.error.T, strict=True)
    indices = {f.name: {"total": total.round(3).tolist(), "error": error.round(3).tolist()} for f, total, error in rows}
    ends = {"mean": found.mean.round(4).tolist(), "deviation": found.deviation.round(4).tolist()}
    return {"samples": SAMPLES, "outputs": found.outputs, "indices": indices} | ends


def hinges(robot: ht.Robot) -> list[dict[str, Any]]:
    """Return speeds, powers and errors of both sets of gaits with the caudal fin on a spring."""
    found = []
    for stiffness in HINGES:
        table = {"hinge": {"link": len(robot.links.name) - 1, "stiffness_n_m_per_rad": stiffness}}
        runs = eight(robot if math.isinf(stiffness) else parse(robot.document() | table))
        speeds = [run["speed_m_s"] for run in runs]
        halves = [round(100 * rms(speeds[part], SPEEDS[part]), 1) for part in (slice(4), slice(4, 8))]
        label = "stiff" if math.isinf(stiffness) else f"{stiffness:g}"
        powers = [run["power_w"] for run in runs]
        found.append({"stiffness": label, "speed_m_s": speeds, "power_w": powers, "rms_percent": halves})
    return found


if __name__ == "__main__":
    laws = {water: ht.load("hypertuna").using(water=water) for water in WATERS}
    store(STORED, {water: {**indices(fish), "hinges": hinges(fish)} for water, fish in laws.items()}, "influence.py")
