"""Are designed runs worth more than a grid, and do their intervals hold the truth? Hidden robots, over and over.

    python validation/design/draws.py [draws] [-o FILE]

A robot of `hypertuna robot new --links 4 --actuation servo`, with six coefficients hidden. Two grids of 24 runs in
random order against 12 designed runs, refit after each; errors, widths and coverage of the speeds of 40 gaits drawn at
random. Once the model is right; once the hidden robot has a linear drag that the model lacks.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import parse
from hypertuna.design.criterion import CHECK, design
from hypertuna.design.posterior import infer
from hypertuna.design.prediction import Row
from hypertuna.design.runs import Measurement, TankRun, candidate_gaits, gait_of_shares, swims, target_gaits
from hypertuna.design.unknowns import Unknowns
from hypertuna.io.checkpoint import Journal
from hypertuna.optimization.design_space import gait_bounds

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from hidden_fish import Tank, hidden, synthetic_unknowns, unseen

FIRST_SEED = 1000  # lower ones were used during development
LINEAR = (0.06, 0.17)  # drag linear in the speed, which the fitted model lacks, over all drag at 0.3 m/s
AFTER = {
    "grid": (4, 8, 12, 24),
    "wide grid": (4, 8, 12, 24),
    "design": (4, 8, 12),
}  # runs after which the prediction is judged
SIZES = (0.0,)  # assumed sizes of the model's discrepancy: 0 trusts the model


def fish() -> ht.Robot:
    """Return the robot as it is described."""
    import tomllib

    from hypertuna.actuation.new import first_robot

    return parse(tomllib.loads(first_robot("synthetic", actuation="servo", links=4)), file="synthetic.toml")


def grids(robot: ht.Robot, rng: np.random.Generator) -> dict[str, list[TankRun]]:
    """Return two grids of 24 gaits in random order: of frequencies and amplitudes at the usual lag, and over lags."""
    space, groups = gait_bounds(robot), len(robot.joints)
    low, high = space.low[0], space.high[0]
    usual = robot.gaits["cruise"].phase[-1] / space.high[2 * groups]
    levels = {
        "grid": product(np.linspace(low, high, 6), (0.4, 0.6, 0.8, 1.0), (usual,), (1.0,)),
        "wide grid": product(np.linspace(low, high, 4), (0.5, 1.0), (0.17, 0.45, 0.72), (0.8,)),
    }
    gaits = {name: [gait_of_shares(space, robot, *level) for level in each] for name, each in levels.items()}
    return {name: swims(each[k] for k in rng.permutation(len(each))) for name, each in gaits.items()}


def repeat(unknowns: Unknowns, how: str, seed: int, linear: bool, runs: int | None = None) -> dict[str, Any]:
    """Simulate one series of runs of a hidden robot, fit after some of them, and compare predictions with the truth."""
    rng, robot = np.random.default_rng(seed), unknowns.robot
    tank = Tank(hidden(unknowns, rng, rng.uniform(*LINEAR) if linear else 0.0), rng)
    rows = unseen(robot, rng)
    truth = np.log(tank.speeds([row.run for row in rows]))
    orders, space = grids(robot, rng), gait_bounds(robot)
    runs_of, targets = (
        swims(candidate_gaits(space, robot)),
        [Row(r, "speed") for r in swims(target_gaits(space, robot, 30))],
    )
    results: list[Measurement] = []
    found, slowest = {}, 0.0
    for k in range(1, (runs or AFTER[how][-1]) + 1):
        if how != "design":
            run = orders[how][k - 1]
        else:
            begin = time.process_time()
            plan = design(infer(unknowns, results), "speed", runs_of, targets)
            run = plan.farthest() if k % CHECK == 0 else plan.best()
            slowest = max(slowest, time.process_time() - begin)
        results += [one] if (one := tank.measure(run)) else []
        if k in AFTER[how]:
            found[k] = _judged(unknowns, results, rows, truth)
    return {"seed": seed, "linear": linear, "how": how, "slowest_s": slowest, "after": found}


def _judged(unknowns: Unknowns, results: Sequence[Measurement], rows: Sequence[Row], truth: Any) -> dict[str, float]:
    """Return error, half width and coverage of predictions, and those of a fit without a discrepancy."""
    judged = {}
    for name, more in (("", {}), ("plain_", {"sizes": SIZES})):
        posterior = infer(unknowns, results, **more)
        mean, sd = posterior.predict(rows)
        good = np.isfinite(truth) & np.isfinite(mean)
        off = np.abs(mean - truth)[good]
        judged[f"{name}error"] = float(np.sqrt(np.mean(off**2)))
        judged[f"{name}half_width"] = float(np.median(1.96 * sd[good]))
        judged[f"{name}coverage"] = float(np.mean(off <= 1.96 * sd[good]))
    return judged


def summary(records: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return medians of error and width over the draws, and mean coverage, by case and number of runs."""
    made = []
    for linear, how in product((False, True), AFTER):
        own = [one for one in records if (one["linear"], one["how"]) == (linear, how)]
        for k in AFTER[how] if own else ():
            each = [one["after"][str(k)] for one in own]
            row: dict[str, Any] = {"linear_drag": linear, "how": how, "runs": k, "draws": len(own)}
            for name in each[0]:
                middle = np.mean if name.endswith("coverage") else np.median
                row[name] = round(float(middle([one[name] for one in each])), 4)
            made.append(row | {"slowest_s": round(max(one["slowest_s"] for one in own), 3)})
    return made


def main() -> None:
    """Run the study, or continue one that was interrupted."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("draws", nargs="?", type=int, default=20)
    parser.add_argument(
        "-o", "--output", default="study.jsonl", help="records, from which an interrupted study goes on"
    )
    options = parser.parse_args()
    unknowns = synthetic_unknowns(fish())
    records = []
    with Journal(options.output, {"kind": "study of designs", "options": {"first_seed": FIRST_SEED}}) as journal:
        for seed, linear, how in product(range(FIRST_SEED, FIRST_SEED + options.draws), (False, True), AFTER):
            work = partial(repeat, unknowns, how, seed, linear)
            records.append(journal.answer([seed, linear, how], work))
    made = {"summary": summary(records)} | provenance(unknowns.robot)
    text = json.dumps(made, indent=1)
    Path(options.output).with_suffix(".json").write_text(text + "\n")
    print(text)


if __name__ == "__main__":
    main()
