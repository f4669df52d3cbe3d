"""Train a policy that reaches a point (hypertuna/Goto-v0) by PPO, and write its curve and its weights.

python examples/learning/train_goto.py [--steps 2400000] [--seed 1] [--threads 2]

It needs the extras `rl` and `sb3`, Stable-Baselines3 with PyTorch.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecMonitor

from hypertuna.learning.sb3 import Sb3VecEnv
from hypertuna.learning.tasks import Goto, wrapped

FOLDER = Path(__file__).parent
STEP = 0.5  # s: slow enough that the tail follows what is tried


class Guided(Goto):
    """Goto with a reward for turning toward the point, too: a difference of potentials, which changes no optimum."""

    def outcome(self, goal, seen, before):
        found = super().outcome(goal, seen, before)
        old, new = (abs(wrapped(np.arctan2(*(goal - at.position).T[::-1]) - at.heading)) for at in (before, seen))
        return found._replace(reward=found.reward + (old - new))


class Curve(BaseCallback):
    """Write steps, mean return and share of reached points of the last hundred episodes after each rollout."""

    def __init__(self, file):
        super().__init__()
        self.rows, self.file, self.start = [], file, time.monotonic()

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        episodes = self.model.ep_info_buffer
        if len(episodes) < 100:  # the first that end are those that reach the point
            return
        reached = np.mean([episode["is_success"] for episode in episodes])
        reward = np.mean([episode["r"] for episode in episodes])
        seconds = time.monotonic() - self.start
        self.rows.append((self.num_timesteps, round(float(reward), 3), round(float(reached), 3)))
        print(f"{self.num_timesteps} steps, return {reward:.2f}, reached {reached:.0%}, {seconds:.0f} s", flush=True)
        with self.file.open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerows([("steps", "return", "reached"), *self.rows])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=2_400_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--output", type=Path, default=FOLDER)
    options = parser.parse_args()
    env = VecMonitor(Sb3VecEnv(128, Guided(), step=STEP, threads=options.threads), info_keywords=("is_success",))
    network = {"net_arch": [64, 64], "log_std_init": -0.7}
    model = PPO(
        *("MlpPolicy", env),
        n_steps=32,
        batch_size=1024,
        n_epochs=10,
        gamma=0.97,
        learning_rate=lambda left: 1e-3 * left,
        policy_kwargs=network,
        seed=options.seed,
        device="cpu",
    )
    model.learn(options.steps, callback=Curve(options.output / "goto.csv"))
    model.save(options.output / "goto.zip")
    layers = model.policy.mlp_extractor.policy_net[0], model.policy.mlp_extractor.policy_net[2], model.policy.action_net
    weights = {
        f"{what}{k}": p.detach().numpy()
        for k, layer in enumerate(layers)
        for what, p in (("weight", layer.weight), ("bias", layer.bias))
    }
    np.savez(options.output / "goto.npz", **weights, step=STEP, task="Goto")


if __name__ == "__main__":
    main()
