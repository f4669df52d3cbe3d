"""Which estimate matters, what the twin's speeds may be, and what a soft caudal fin would change.

    python validation/twin/influence.py [-o validation/twin/influence.json]

The record goes into docs/twin.md by docs/figures.py: run this again when the description or the twin changes.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.console import progress_bar
from hypertuna.description import parse
from hypertuna.published_swims import SPEEDS
from hypertuna.results import provenance, write_atomically
from hypertuna.sobol import FACTORS, influence, spread

ROBOT = ht.load("hypertuna")
GAITS = {name: ht.named_gait(ROBOT, name) for name in SPEEDS}
SAMPLES = 64
DRAWS = 64
HINGES = (0.1, 0.2, 0.3, 0.5, 1.0)  # N m/rad
LIMITS = ((5.0, 250e3), (5.0, 300e3), (5.0, 350e3), (4.5, 300e3), (4.0, 300e3), (4.0, 450e3))  # mm, Pa


def indices(progress: Callable[[int, int], None]) -> list[dict[str, Any]]:
    """Sobol's indices of reach and speed at 5 and 6 Hz, large amplitude."""
    records = []
    for name in ("unoptimised-0.5", "unoptimised-max"):
        found = influence(ROBOT, GAITS[name], samples=SAMPLES, progress=progress)
        columns = {"first": found.first, "total": found.total, "error": found.error}
        records.append(
            {
                "gait": name,
                "outputs": found.outputs,
                "factors": [factor.name for factor in found.factors],
                **{key: values.round(3).tolist() for key, values in columns.items()},
                "mean": found.mean.round(4).tolist(),
                "deviation": found.deviation.round(4).tolist(),
                "runs": found.runs,
            }
        )
    return records


def speeds(progress: Callable[[int, int], None]) -> dict[str, Any]:
    """Median and 95 % interval of the eight speeds, m/s."""
    found = spread(ROBOT, GAITS, draws=DRAWS, progress=progress)
    middle = np.nanmedian(found.speed, axis=0)
    return {
        name: {"median": round(float(m), 4), "interval": [round(x, 4) for x in found.interval(name)]}
        for name, m in zip(found.gaits, middle, strict=True)
    }


def swum(robot: ht.Robot) -> dict[str, Any]:
    """Eight speeds [m/s] and powers [W] of a robot."""
    runs = [{"robot": robot, "gait": gait, "duration": 12.0, "start": "swimming"} for gait in GAITS.values()]
    found = ht.twins(runs, measure=lambda run: (round(run.speed, 4), round(run.power, 2)), threads=2)
    return {name: {"speed": speed, "power": power} for name, (speed, power) in zip(GAITS, found, strict=True)}


def hinges() -> list[dict[str, Any]]:
    """A caudal fin on a hinge at the front of the last link."""
    records = []
    for stiffness in HINGES:
        hinge = {"link": len(ROBOT.links.name) - 1, "stiffness_n_m_per_rad": stiffness}
        records.append({"stiffness_n_m_per_rad": stiffness, **swum(parse(ROBOT.document() | {"hinge": hinge}))})
    return records


def limits() -> list[dict[str, Any]]:
    """Other bores of the lines and pressure limits."""
    records = []
    for bore, soft in LIMITS:
        document = ROBOT.document()
        for joint in document["joints"]:
            joint["line"]["bore_m"] = bore * 1e-3
        document["controller"] |= {"pressure_soft_pa": soft, "pressure_hard_pa": 1.2 * soft}
        records.append({"bore_mm": bore, "pressure_soft_kpa": soft / 1e3, **swum(parse(document))})
    return records


def main() -> None:
    """Compute all of it and write one JSON file."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_suffix(".json"))
    output: Path = parser.parse_args().output
    ranges = [{"name": f.name, "key": f.key, "low": f.low, "high": f.high, "how": f.how} for f in FACTORS]
    with progress_bar("twins") as progress:
        record = {"ranges": ranges, "indices": indices(progress), "speeds": speeds(progress)}
    record |= {"hinges": hinges(), "limits": limits(), "made_by": provenance(ROBOT)}
    write_atomically(output, (json.dumps(record, indent=1) + "\n").encode())
    print(f"written: {output}", file=sys.stderr)


if __name__ == "__main__":
    main()
