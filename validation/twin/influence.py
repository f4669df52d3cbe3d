"""Which estimate matters, and what a soft caudal fin would change: tables of
docs/twin.md. Run: python validation/twin/influence.py [PART ...] [--page], some 5 minutes.
"""

from __future__ import annotations

import math
import runpy
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from sensitivity import FACTORS, influence

import hypertuna as ht
from hypertuna.cli.console import progress_bar
from hypertuna.description.robot import parse

study = runpy.run_path(str(Path(__file__).with_name("study.py")))
GAITS, PUBLISHED, ROBOT, eight, main = (study[name] for name in ("GAITS", "PUBLISHED", "ROBOT", "eight", "main"))

SAMPLES = 32
INDEXED = ("unoptimised-max",)  # 6 Hz, large amplitude
HINGES = (0.1, 0.2, 0.3, 0.5, 1.0)  # N m/rad
POWERS = {"unoptimised-max": 22.45, "optimised-0.5": 18.2}  # W, published


def indices() -> Iterator[str]:
    """Sobol's total indices of reach and speed, with half of the 95 % interval."""
    with progress_bar("indices") as progress:
        found = [influence(ROBOT, ht.named_gait(ROBOT, name), samples=SAMPLES, progress=progress) for name in INDEXED]
    heads = [
        f"{ht.named_gait(ROBOT, name).frequency:g} Hz: {what}" for name in INDEXED for what in ("I", "II", "speed")
    ]
    yield f"| estimate | range | {' | '.join(heads)} |"
    yield "|---|---|" + "---:|" * len(heads)
    for k, factor in enumerate(FACTORS):
        cells = [f"{part.total[o, k]:.2f} ± {part.error[o, k]:.2f}" for part in found for o in range(3)]
        ends = (
            f"{factor.low:+g} to {factor.high:+g} K" if factor.how == "plus" else f"x {factor.low:g} to {factor.high:g}"
        )
        yield f"| {factor.name} | {ends} | {' | '.join(cells)} |"
    spans = [f"{part.mean[o]:.3g} ± {part.deviation[o]:.2g}" for part in found for o in range(3)]
    yield f"| mean ± standard deviation, deg and m/s | | {' | '.join(spans)} |"


def hinges() -> Iterator[str]:
    """A caudal fin on a spring at the front of the last link: eight speeds, and the two published powers.

    The stiffness is chosen by the first four, the unoptimised gaits, and judged by the others.
    """
    heads = [*(f"{speed:g}" for speed in PUBLISHED), "rms, first four", "rms, others", "fastest, W", "lake, W"]
    yield f"| fin, N m/rad | {' | '.join(heads)} |"
    yield "|---|" + "---:|" * len(heads)
    for stiffness in (math.inf, *HINGES[::-1]):
        table = {"hinge": {"link": len(ROBOT.links.name) - 1, "stiffness_n_m_per_rad": stiffness}}
        runs = eight(ROBOT if math.isinf(stiffness) else parse(ROBOT.document() | table))
        speeds = np.array([run.speed for run in runs])
        error = (speeds / PUBLISHED - 1).reshape(2, -1)
        rms = " | ".join(f"{100 * math.sqrt(float(np.mean(part**2))):.1f} %" for part in error)
        powers = " | ".join(f"{runs[GAITS.index(name)].electrical_power:.1f}" for name in POWERS)
        label = "stiff" if math.isinf(stiffness) else f"{stiffness:g}"
        yield f"| {label} | {' | '.join(f'{speed:.3f}' for speed in speeds)} | {rms} | {powers} |"
    yield (
        "| published | "
        + " | ".join(f"{speed:g}" for speed in PUBLISHED)
        + " | | | "
        + " | ".join(map(str, POWERS.values()))
        + " |"
    )


if __name__ == "__main__":
    main({"indices": indices, "hinges": hinges})
