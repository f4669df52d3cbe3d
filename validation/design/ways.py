"""Is there a better design than the greedy one? python validation/design/ways.py [DRAWS].

The hidden robots of draws.py, whose model is right, and fresh ones: 12 runs as `design ask` takes them; the remaining
runs planned together by exchange before each; four times as many targets; and 24 runs of the grid. Results are added to
ways.json beside this file, a line a draw; draws that it has are left out.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from draws import FIRST_SEED, Tank, fish, grids, hidden, synthetic_unknowns, unseen

from hypertuna.design.criterion import CHECK, Design, design
from hypertuna.design.posterior import infer
from hypertuna.design.prediction import Row
from hypertuna.design.runs import Measurement, TankRun, candidate_gaits, swims, target_gaits
from hypertuna.design.unknowns import Unknowns
from hypertuna.optimization.design_space import gait_bounds

RESULT = Path(__file__).parent / "ways.json"
RUNS = {"greedy": 12, "exchange": 12, "120 targets": 12, "grid": 24}  # number of runs of each way to choose them


def greedy(plan: Design, made: int) -> TankRun:
    """Return the next run as `design ask` does."""
    return plan.farthest() if (made + 1) % CHECK == 0 else plan.best()


def exchanged(plan: Design, made: int) -> TankRun:
    """Return the first of all runs to come, which are exchanged one by one until no exchange improves the whole."""
    chosen: list[TankRun] = []
    now = plan
    for k in range(made, RUNS["exchange"]):
        chosen.append(greedy(now, k))
        now = now.after(chosen[-1:])
    free = [k for k in range(len(chosen)) if (made + k + 1) % CHECK]
    for _ in range(2):
        for k in free:
            rest = chosen[:k] + chosen[k + 1 :]
            chosen[k] = (plan.after(rest) if rest else plan).best()
    return min((chosen[k] for k in free), key=plan.score) if (made + 1) % CHECK else chosen[0]


def error(unknowns: Unknowns, how: str, seed: int) -> float:
    """Return the rms error of the predicted speeds [%]."""
    rng, robot = np.random.default_rng(seed), unknowns.robot
    tank = Tank(hidden(unknowns, rng), rng)
    rows = unseen(robot, rng)
    truth = np.log(tank.speeds([row.run for row in rows]))
    order, space = grids(robot, rng)["grid"], gait_bounds(robot)
    gaits = swims(candidate_gaits(space, robot))
    targets = [Row(run, "speed") for run in swims(target_gaits(space, robot, 120 if how == "120 targets" else 30))]
    results: list[Measurement] = []
    for k in range(RUNS[how]):
        if how == "grid":
            run = order[k]
        else:
            plan = design(infer(unknowns, results), "speed", gaits, targets)
            run = exchanged(plan, k) if how == "exchange" else greedy(plan, k)
        results += [one] if (one := tank.measure(run)) else []
    mean, _ = infer(unknowns, results).predict(rows)
    good = np.isfinite(truth) & np.isfinite(mean)
    return round(100 * float(np.sqrt(np.mean((mean - truth)[good] ** 2))), 4)


def medians(lines: Sequence[dict[str, float]]) -> dict[str, float]:
    """Return the median error of each way [%]."""
    return {how: round(float(np.median([line[how] for line in lines])), 2) for how in RUNS}


def main(draws: int = 40) -> None:
    """Make the draws that are missing."""
    unknowns, lines = synthetic_unknowns(fish()), json.loads(RESULT.read_text()) if RESULT.exists() else {}
    for seed in range(FIRST_SEED, FIRST_SEED + draws):
        if str(seed) not in lines:
            lines[str(seed)] = {how: error(unknowns, how, seed) for how in RUNS}
            RESULT.write_text("{\n" + ",\n".join(f'"{k}": {json.dumps(v)}' for k, v in lines.items()) + "\n}\n")
    print(medians(list(lines.values())))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
