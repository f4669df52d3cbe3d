"""Measure the trained policy of goto.npz beside a plain pilot, over a thousand episodes of hypertuna/Goto-v0 each.

python examples/learning/evaluate_goto.py [--episodes 1000] [--threads 2]    writes goto.json; 10 minutes
"""

import argparse
import json
from pathlib import Path

import hypertuna as ht
from hypertuna.learning.environments import SwimmerVectorEnv
from hypertuna.learning.policy import plain_pilot, read_policy, success_rate
from hypertuna.simulation.estimates import random_robots

FOLDER = Path(__file__).parent
SEED = 1000  # not one of the training's episodes


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--episodes", type=int, default=1000)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    policy, robots = read_policy(FOLDER / "goto.npz"), random_robots(ht.load("hypertuna"), 32, SEED)
    results = {}
    for name, others in (("the robot itself", ()), ("robots within the estimates", robots)):
        env = SwimmerVectorEnv(100, "Goto", robots=others, step=policy.step, threads=options.threads)
        for who, act in (("policy", policy), ("pilot", plain_pilot(env.swimmers))):
            result = success_rate(env, act, episodes=options.episodes, seed=SEED)
            results[f"{who}, {name}"] = result
            print(f"{who}, {name}: {result}", flush=True)
    (FOLDER / "goto.json").write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
