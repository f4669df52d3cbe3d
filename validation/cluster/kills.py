"""Sweeps on a Dask cluster of processes whose workers are killed at random: complete, and equal to the bit?

Writes kills.json beside this file. A run: 32,768 gaits in 64 shards by two workers, SIGKILL to one of them at
random times. A worker that builds an editable install is spared: the build would be broken, not the work.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from distributed import LocalCluster

import hypertuna as ht
from hypertuna.io.files import version
from hypertuna.parallel.executors import cluster

RUNS = 20
PAUSE = (1.0, 5.0)  # seconds between two kills: a worker that is started anew swims some shards in between
GRID = ht.GaitGrid.from_degrees(
    frequency=np.linspace(1, 6, 128), amplitude=[(a, 20) for a in (8, 10, 12, 16)], phase=[(0.0, k) for k in range(64)]
)


def building(process: int) -> bool:
    """Whether a process is building the extension, as one that imports an editable install does at first."""
    try:
        children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
        return any(Path(f"/proc/{child}/comm").read_text().strip() in ("cmake", "ninja") for child in children)
    except OSError:
        return True  # it ended while it was looked at


@contextlib.contextmanager
def killed_at_random(local: LocalCluster, seed: int) -> Iterator[list[int]]:
    """Kill a worker process at random until the work is done; yield the list of those killed."""
    chance, done, killed = random.Random(seed), threading.Event(), list[int]()

    def kill() -> None:
        while not done.wait(chance.uniform(*PAUSE)):
            pids = [worker.pid for worker in local.workers.values()]
            if living := [pid for pid in pids if pid and not building(pid)]:
                killed.append(chance.choice(living))
                with contextlib.suppress(ProcessLookupError):
                    os.kill(killed[-1], signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        yield killed
    finally:
        done.set()
        killer.join()


def main() -> None:
    # To start from rest takes longer: the time in which workers are killed.
    whole = ht.sweep("hypertuna", GRID, check_rest=True)
    runs = []
    for seed in range(RUNS):
        with (
            tempfile.TemporaryDirectory() as place,
            LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as local,
            cluster(local.scheduler_address) as executor,
        ):
            folder = Path(place) / "a.shards"
            with killed_at_random(local, seed) as killed:
                made = ht.sweep_shards("hypertuna", GRID, folder, size=512, check_rest=True, executor=executor)
            equal = ht.merge_shards(folder).identical(whole)
        runs.append({"seed": seed, "killed": len(killed), "shards": made, "complete_and_equal": equal})
        print(runs[-1], flush=True)
    record = {"version": version(), "isa": whole.isa, "gaits": len(GRID), "runs": runs}
    record["complete_and_equal"] = f"{sum(run['complete_and_equal'] for run in runs)} of {len(runs)}"
    Path(__file__).with_suffix(".json").write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
