"""Time contestants against each other on one core of a noisy machine.

Contestants take turns, so that other load affects all of them alike; what counts is the processor time of
this process, not the clock on the wall; and results are medians, of times and of the ratios within each turn.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from statistics import median

# Variables that limit libraries to one thread
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def stay_on_one_core() -> None:
    """Pin this process to one core and its libraries to one thread; call it before importing them."""
    for name in ONE_THREAD:
        os.environ[name] = "1"
    if hasattr(os, "sched_setaffinity"):  # not on macOS
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def processor_seconds(work: Callable[[], object], repeats: int = 1) -> float:
    """Return the processor time of one call [s], averaged over `repeats` calls in a row."""
    start = time.process_time()
    for _ in range(repeats):
        work()
    return (time.process_time() - start) / repeats


class Race:
    """Times of contestants that took turns."""

    def __init__(self, contestants: Mapping[str, Callable[[], object]], turns: int, *, repeats: int = 1) -> None:
        for work in contestants.values():  # a first call fills caches and compiles
            work()
        self.times: dict[str, list[float]] = {name: [] for name in contestants}
        for _ in range(turns):
            for name, work in contestants.items():
                self.times[name].append(processor_seconds(work, repeats))

    def seconds(self, name: str) -> float:
        """Return the median time of one call [s]."""
        return median(self.times[name])

    def ratio(self, slow: str, fast: str) -> float:
        """Return the time of `slow` over that of `fast`, the median over the turns."""
        return median(s / f for s, f in zip(self.times[slow], self.times[fast], strict=True))
