"""Fly a mission with many seeds: into a list of outcomes, a table, or a folder of shards."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, ThreadPoolExecutor
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.checkpoint import Journal
from hypertuna.io.quantity import label, scaled
from hypertuna.mission.checks import check_current
from hypertuna.mission.file import MissionFile
from hypertuna.mission.flight import OUTCOME, Outcome, Report, fly, outcome
from hypertuna.mission.run import mission_start
from hypertuna.parallel.executors import Executors, map_shards, thread_count
from hypertuna.parallel.layout import Layout
from hypertuna.parallel.shards import Cases, make_shards

MAX_SEEDS = 10_000
TEXTS = {  # columns of text: head in a CSV file, and meaning
    "status": ("status", "how the flight ended"),
    "reasons": ("reasons_s", "reasons of the pilot, each with the time at which it first held in seconds"),
    "waypoints": ("waypoints", "outcome of each waypoint"),
}


def fly_seeds(
    file: MissionFile,
    robot: Robot,
    seeds: Sequence[int],
    *,
    executor: Executors | None = None,
    threads: int | None = None,
    faults: Iterable[str] = (),
    duration: float | None = None,
    checkpoint: str | Path | None = None,
    report: Report | None = None,
) -> list[Outcome]:
    """Fly a mission with many seeds in threads or an executor; after Ctrl-C, the journal has the finished flights."""
    header, work, pool = _checked(file, robot, seeds, tuple(faults), duration, executor, threads)
    outcomes: list[Outcome] = []
    with (
        Journal(checkpoint, header) as journal,
        closing(map_shards(work, seeds[journal.unread :], pool)) as flights,
    ):
        for k, seed in enumerate(seeds):
            outcomes.append(Outcome(**journal.answer(seed, lambda: next(flights))))
            if report is not None:
                report(k + 1, len(seeds))
    return outcomes


def fly_seed_shards(
    file: MissionFile,
    robot: Robot,
    seeds: Sequence[int],
    folder: str | Path,
    *,
    size: int | None = None,
    part: tuple[int, int] = (1, 1),
    executor: Executors | None = None,
    threads: int | None = None,
    faults: Iterable[str] = (),
    duration: float | None = None,
    command: str = "hypertuna.mission.seeds.fly_seed_shards with the same arguments",
    progress: Report | None = None,
) -> int:
    """Fly a mission with many seeds and write the outcomes to a folder of shards, by default one flight per shard.

    The arguments are those of `fly_seeds` and of `hypertuna.sweep_shards`; returns the number of shards made.
    """
    header, work, pool = _checked(file, robot, seeds, tuple(faults), duration, executor, threads)
    cases = Cases(header, len(seeds), flights_layout(file, robot, seeds), partial(_fly_range, work, seeds))
    return make_shards(cases, folder, pool, size=size or 1, part=part, command=command, progress=progress)


def flights_layout(file: MissionFile, robot: Robot, seeds: Sequence[int]) -> Layout:
    """Return the layout of a data set of outcomes: dimensions, units and names of its variables."""
    numbers = {
        name: {"units": unit or "1", "long_name": label(name, note or "")} for name, (unit, note) in OUTCOME.items()
    }
    words = {name: {"long_name": meaning} for name, (_, meaning) in TEXTS.items()}
    variables = {"status": words.pop("status")} | numbers | words
    seed_about = {"units": "1", "long_name": "seed of the flight"}
    facts = provenance(robot) | {"mission": file.name, "mission_hash": file.hash}
    table = {name: TEXTS[name][0] if name in TEXTS else name for name in variables}
    return Layout({"seed": len(seeds)}, variables, {"seed": ("seed", list(seeds), seed_about)}, facts, table)


def flight_table(outcomes: Sequence[Outcome]) -> dict[str, Array]:
    """Return outcomes of flights as columns, in the units of `flights_layout`."""
    words = {
        "status": [one.status for one in outcomes],
        "reasons": [" ".join(f"{name}@{time:g}" for name, time in one.reasons.items()) for one in outcomes],
        "waypoints": [" ".join(point["outcome"] for point in one.waypoints) for one in outcomes],
    }
    numbers = {
        name: np.array([scaled(getattr(one, name), unit) for one in outcomes]) for name, (unit, _) in OUTCOME.items()
    }
    return numbers | {name: np.array(texts, dtype=object) for name, texts in words.items()}


def _checked(
    file: MissionFile,
    robot: Robot,
    seeds: Sequence[int],
    faults: Sequence[str],
    duration: float | None,
    executor: Executors | None,
    threads: int | None,
) -> tuple[dict[str, Any], Callable[[int], dict[str, Any]], Executors]:
    """Check the arguments; return journal header, function that flies a seed, and executor (default: threads)."""
    if not 1 <= len(seeds) <= MAX_SEEDS:
        rule = f"must be from 1 to {MAX_SEEDS} seeds"
        raise InputError(rule, key="seeds", value=f"{len(seeds)}", fix="write FROM:TO, such as 0:100")
    options = {"mission": file.hash, "seeds": list(seeds), "faults": list(faults), "duration": duration}
    check_current(robot, file.mission, file.scatter.current)  # so that bad input fails before the first flight
    mission_start(robot, file.mission, faults=faults, duration=duration)
    stop = threading.Event() if executor is None else None

    @contextmanager
    def own_pool() -> Iterator[Executor]:
        pool = ThreadPoolExecutor(thread_count(threads))
        try:
            yield pool
        finally:
            if stop is not None:
                stop.set()  # so that Ctrl-C does not wait for flights
            pool.shutdown(cancel_futures=True)

    work = partial(_fly_seed, file, robot, faults, duration, stop)
    return journal_header("mission seeds", robot, options), work, executor or own_pool


def _fly_seed(
    file: MissionFile,
    robot: Robot,
    faults: Sequence[str],
    duration: float | None,
    stop: threading.Event | None,
    seed: int,
) -> dict[str, Any]:
    """Fly a mission with one seed until it ends or is stopped; return its outcome as a dictionary."""

    def go_on(*_: int) -> None:
        if stop is not None and stop.is_set():
            raise CancelledError

    return vars(outcome(fly(file, robot, seed=seed, faults=faults, duration=duration, report=go_on)))


def _fly_range(work: Callable[[int], dict[str, Any]], seeds: Sequence[int], first: int, last: int) -> dict[str, Array]:
    """Fly a mission with a range of seeds; return their outcomes as columns."""
    return flight_table([Outcome(**work(seed)) for seed in seeds[first:last]])
