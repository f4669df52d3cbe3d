"""Sweep a number of random gaits within the paper's bounds in this process alone; print time and memory as JSON."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from timing import processor_seconds, stay_on_one_core

stay_on_one_core()

import numpy as np  # noqa: E402

import hypertuna  # noqa: E402


def peak_bytes() -> int:
    """Return the peak resident memory of this process [bytes]; getrusage would include the parent's memory."""
    status = Path("/proc/self/status").read_text()
    return 1024 * int(status.split("VmHWM:")[1].split()[0])


def random_gaits(count: int) -> hypertuna.Gaits:
    """Return random gaits within the paper's bounds (Eq. 41): up to 6 Hz, 16 and 25 deg, 80 deg of phase; all beat."""
    box = np.random.default_rng(1).uniform(size=(4, count))
    zero = np.zeros(count)
    return hypertuna.Gaits(
        frequency=1 + 5 * box[0],
        amplitude=np.radians(np.stack([4 + 12 * box[1], 5 + 20 * box[2]], axis=1)),
        phase=np.radians(np.stack([zero, 80 * box[3]], axis=1)),
        bias=np.zeros((count, 2)),
        shape=(count,),
    )


def main() -> None:
    """Print gaits, processor and wall seconds, peak resident memory and the share that settled."""
    count = int(sys.argv[1])
    robot, gaits, found = hypertuna.load("hypertuna"), random_gaits(count), []
    hypertuna.sweep(robot, random_gaits(8), threads=1)  # imports modules and loads kernels before the clock starts
    clock = time.perf_counter()
    seconds = processor_seconds(lambda: found.append(hypertuna.sweep(robot, gaits, threads=1)))
    print(
        json.dumps(
            {
                "gaits": count,
                "seconds": seconds,
                "wall_seconds": time.perf_counter() - clock,
                "peak_bytes": peak_bytes(),
                "settled": float(found[0]["settled"].mean()),
            }
        )
    )


if __name__ == "__main__":
    main()
