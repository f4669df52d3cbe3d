"""Cost of shards on this machine: bytes and time of a gait, tasks per second of Dask, speed of N processes."""

from __future__ import annotations

import json
import multiprocessing
import os
import resource
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import cloudpickle
import numpy as np
from distributed import LocalCluster

import hypertuna as ht
from hypertuna.parallel.executors import cluster, map_shards
from hypertuna.parallel.layout import NO_LAYOUT
from hypertuna.parallel.shards import Shards, _ShardTask
from hypertuna.swimming.batch import batch
from hypertuna.swimming.shards import _swim

SIZE = 16_384  # gaits of a shard
LAGS = [(0.0, lag) for lag in np.linspace(0, 80, 64)]  # deg, phases of both joints
GRID = ht.Gaits.grid_degrees(
    frequency=np.linspace(1, 6, 64), amplitude=[(a, 20) for a in np.linspace(8, 16, 32)], phase=LAGS
)
# Options of the sweep
HOW: dict[str, Any] = {"threads": 1, "steps": 128, "method": "newton", "beats": 50, "check_rest": False}


def seconds(processes: int, folder: Path) -> tuple[float, float]:
    """Return the grid's wall time [s] in processes that run already, and the processor time [s] with their start."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with ProcessPoolExecutor(processes, mp_context=multiprocessing.get_context("spawn")) as pool:
        list(map_shards(ht.load, ["hypertuna"] * 4 * processes, pool))
        begin = time.perf_counter()
        ht.sweep_shards("hypertuna", GRID, folder, size=SIZE, executor=pool)
        wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def tasks_per_second(count: int) -> float:
    """Return how many empty tasks a second pass through a scheduler and two workers in one process."""
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as local,
        cluster(local.scheduler_address) as executor,
    ):
        list(map_shards(abs, range(100), executor))
        begin = time.perf_counter()
        list(map_shards(abs, range(count), executor, in_flight=2048))
        return count / (time.perf_counter() - begin)


def main() -> None:
    record: dict[str, object] = {"gaits": len(GRID), "shard": SIZE, "cores": len(os.sched_getaffinity(0))}
    record["isa"] = ht.sweep("hypertuna", ht.Gaits.grid(frequency=[1], amplitude=[(0.1, 0.1)], phase=[(0, 0)])).isa
    swimming = batch("hypertuna", GRID, **HOW).swimming
    task = _ShardTask(Shards(Path("a.shards"), {}, len(GRID), SIZE, NO_LAYOUT, ""), partial(_swim, swimming, GRID))
    record["task_bytes"] = len(cloudpickle.dumps(task))
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for processes in (1, 2):
            times = [seconds(processes, folder / f"{processes}-{k}.shards") for k in range(3)]
            record[f"wall_s_{processes}"], record[f"cpu_s_{processes}"] = (
                min(each) for each in zip(*times, strict=True)
            )
        record["load"] = os.getloadavg()[0]
        shard = next((folder / "1-0.shards").glob("shard-*"))
        record["shard_bytes_per_gait"] = round(shard.stat().st_size / SIZE, 2)
    record["tasks_per_second"] = round(tasks_per_second(10_000))
    Path(__file__).with_suffix(".json").write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
