"""Do 95 % intervals hold the truth 95 times in 100? Fits of synthetic runs with noise, over and over.

    python validation/identify/study.py [repeats] [-o FILE]

180 gaits of HyperTuna, speed and cost of transport with 1 % noise that the fit is not told, nine free coefficients,
default options. Every fit starts at the truth, for speed: what is studied are the intervals, not the search.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtrit

import hypertuna as ht
from hypertuna.identification.identify import identify
from hypertuna.io.checkpoint import Journal

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from synthetic import NINE, steady, tank

NOISE = 0.01  # of a measured speed, relative
FIRST_SEED = 1000  # lower ones were used during development


def repeat(robot: ht.Robot, gaits: Sequence[ht.Gait], names: Sequence[str], seed: int) -> dict[str, Any]:
    """Fit once; return the truth's distance from the result along every direction, in standard deviations."""
    fit = identify(robot, steady(robot, gaits, noise=NOISE, seed=seed), names, validate=0, starts=1, threads=1)
    truth = np.array([f.start for f in fit.free])
    sure = fit.uncertainty
    along = [float(d.vector @ ((fit.values - truth) / sure.unit)) for d in sure.directions]
    return {
        "seed": seed,
        "off": [x / d.sd for x, d in zip(along, sure.directions, strict=True)],
        "linear_off": [x * d.singular_value for x, d in zip(along, sure.directions, strict=True)],
        "sd": [d.sd for d in sure.directions],
        "constrained": [d.constrained for d in sure.directions],
        "coefficient_held": ((sure.low <= truth) & (truth <= sure.high)).tolist(),
        "coefficient_constrained": list(sure.constrained),
        "quantile": float(stdtrit(sure.freedom, 0.975)),
        "noise": fit.noise,
        "converged": fit.converged,
        "values": fit.values.tolist(),
    }


def summary(records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the coverage of directions reported as constrained: together, and by rank from the best known."""
    off = np.abs([record["off"] for record in records])
    constrained = np.array([record["constrained"] for record in records])
    held = off < np.array([record["quantile"] for record in records])[:, np.newaxis]
    known = constrained.sum(axis=0)
    coefficients = np.array([record["coefficient_held"] for record in records])
    named = np.array([record["coefficient_constrained"] for record in records])
    with np.errstate(invalid="ignore"):
        return {
            "repeats": len(records),
            "converged": int(sum(record["converged"] for record in records)),
            "coverage": float(held[constrained].mean()),
            "reported_as_constrained": known.tolist(),
            "coverage_by_direction": ((held & constrained).sum(axis=0) / known).round(3).tolist(),
            "coverage_of_open_directions": float(held[~constrained].mean()) if (~constrained).any() else None,
            "coverage_of_constrained_coefficients": float(coefficients[named].mean()),
            "coverage_of_coefficients": coefficients.mean(axis=0).round(3).tolist(),
            "coefficients_reported_as_constrained": named.sum(axis=0).tolist(),
            "noise": {
                kind: float(np.mean([record["noise"][kind] for record in records])) for kind in records[0]["noise"]
            },
        }


def main() -> None:
    """Run the study; finished fits are stored, so that an interrupted study continues."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repeats", nargs="?", type=int, default=200)
    parser.add_argument("-o", "--output", type=Path, default=Path("study.jsonl"))
    given = parser.parse_args()
    robot, gaits = ht.load("hypertuna"), tank()
    with Journal(given.output, {"kind": "study of nine coefficients"}) as journal:
        seeds = range(FIRST_SEED, FIRST_SEED + given.repeats)
        records = [journal.answer(seed, partial(repeat, robot, gaits, NINE, seed)) for seed in seeds]
    print(json.dumps(summary(records), indent=2))


if __name__ == "__main__":
    main()
