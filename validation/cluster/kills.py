"""Sweeps on a Dask cluster of processes whose workers are killed at random: complete, and equal to the bit?

Writes kills.json beside this file. A run: 32,768 gaits in 64 shards by two workers, one of which is killed by SIGKILL
after four random numbers of shards. A worker that builds an editable install is spared: the build would be broken.
"""

from __future__ import annotations

import json
import os
import random
import signal
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from distributed import LocalCluster

import hypertuna as ht
from hypertuna.io.files import version
from hypertuna.parallel.executors import cluster

RUNS = 20  # sweeps with killed workers
KILLS = 4  # workers killed in a run
GRID = ht.Gaits.grid_degrees(
    frequency=np.linspace(1, 6, 128), amplitude=[(a, 20) for a in (8, 10, 12, 16)], phase=[(0.0, k) for k in range(64)]
)


def building(process: int) -> bool:
    """Return whether a process is building the extension: the first import of an editable install does."""
    try:
        children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
        return any(Path(f"/proc/{child}/comm").read_text().strip() in ("cmake", "ninja") for child in children)
    except OSError:
        return True  # it ended while it was looked at


def killer(local: LocalCluster, seed: int, killed: list[int]) -> Callable[[int, int], None]:
    """Return a function for the sweep's progress that kills a random worker after random numbers of shards."""
    chance = random.Random(seed)
    times = chance.sample(range(4, 60), KILLS)

    def report(done: int, total: int) -> None:
        pids = [worker.pid for worker in local.workers.values()]
        living = [pid for pid in pids if pid and not building(pid)]
        if done in times and living:
            killed.append(chance.choice(living))
            os.kill(killed[-1], signal.SIGKILL)

    return report


def main() -> None:
    # With starts from rest, which take longer.
    whole = ht.sweep("hypertuna", GRID, check_rest=True)
    runs = []
    for seed in range(RUNS):
        with (
            tempfile.TemporaryDirectory() as place,
            LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as local,
            cluster(local.scheduler_address) as executor,
        ):
            folder = Path(place) / "a.shards"
            killed: list[int] = []
            how = {"executor": executor, "progress": killer(local, seed, killed)}
            made = ht.sweep_shards("hypertuna", GRID, folder, size=512, check_rest=True, **how)
            equal = ht.merge_shards(folder).identical(whole)
        runs.append({"seed": seed, "killed": len(killed), "shards": made, "complete_and_equal": equal})
        print(runs[-1], flush=True)
    record = {"version": version(), "isa": whole.isa, "gaits": len(GRID), "runs": runs}
    record["complete_and_equal"] = f"{sum(run['complete_and_equal'] for run in runs)} of {len(runs)}"
    Path(__file__).with_suffix(".json").write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
