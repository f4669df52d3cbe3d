"""Swim twins one after another, side by side in lanes, and as environments, and print how many a second, as JSON.

Started by run.py, whose core and limits of threads it inherits.
"""

from __future__ import annotations

import json
import sys

import numpy as np

import hypertuna
from hypertuna import _core
from hypertuna.learning.environments import SwimmerVectorEnv
from timing import Race

DURATION = 20.0  # of a run [s]
SWIMMERS, STEPS = 128, 5  # of the environment; steps in a turn


def main() -> None:
    """Print the instruction set, its lanes, runs per second alone and in lanes, and steps of the environment."""
    robot, lanes = hypertuna.load("hypertuna"), _core.twin_lanes()
    gait = hypertuna.named_gait(robot, "unoptimised-max")
    runs = [{"robot": robot, "gait": gait, "duration": DURATION, "seed": seed} for seed in range(lanes)]
    env = SwimmerVectorEnv(SWIMMERS, "Goto")
    env.reset(seed=1)
    actions = np.random.default_rng(1).uniform(-1, 1, (STEPS, *env.action_space.shape)).astype(np.float32)
    race = Race(
        {
            "alone": lambda: hypertuna.twin(robot, gait, duration=DURATION),
            "lanes": lambda: hypertuna.twins(runs, measure=lambda run: run.status, threads=1),
            "steps": lambda: [env.step(action) for action in actions],
        },
        int(sys.argv[1]),
    )
    found = {
        "isa": _core.isa(),
        "lanes": lanes,
        "alone": 1 / race.seconds("alone"),
        "together": lanes / race.seconds("lanes"),
        "gain": lanes * race.ratio("alone", "lanes"),
        "steps": SWIMMERS * STEPS / race.seconds("steps"),
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()
