"""Sweeps of any size, written to a folder of shards."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot
from hypertuna.parallel.executors import Executors, thread_count
from hypertuna.parallel.shards import Cases, make_shards
from hypertuna.swimming.batch import Part, Swimming, batch
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.swimming.gait import Gait, Gaits


@checked
def sweep_shards(
    robot: Robot | str | Path,
    gaits: Gaits | Sequence[Gait],
    folder: str | Path,
    *,
    size: int | None = None,
    part: tuple[int, int] = (1, 1),
    executor: Executors | None = None,
    threads: int | None = None,
    steps: int = DEFAULT_STEPS,
    method: Literal["newton", "beats"] = "newton",
    beats: int = 50,
    check_rest: bool = False,
    command: str = "hypertuna.sweep_shards with the same arguments",
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Swim any number of gaits, and write the results to a folder of shards, from which the same call resumes.

    Each shard is written by the process that swims it, whole or not at all: all workers must share the file system of
    `folder`. Memory holds one shard per worker, never the whole grid. `merge_shards` reads the result.

    Parameters
    ----------
    robot, gaits, executor, threads, steps, method, beats, check_rest
        As in `sweep`; a grid may have any size.
    folder : str or Path
        Folder of the shards, made if it is absent.
    size : int
        Gaits per shard; by default a 64th of all, but from 256 to 131072.
    part : tuple of int
        Numbers I and N: swim every N-th shard, from the I-th. All N parts together make the whole.
    command : str
        Command that makes missing shards, for the error that names them.
    progress : callable, optional
        Called with the number of this part's shards that exist, and their total.

    Returns
    -------
    int
        Number of shards that this call made.

    Raises
    ------
    InputError
        If the gaits do not fit the robot, or the folder holds other results.
    """
    settings: Any = {"threads": thread_count(threads, executor), "steps": steps, "method": method, "beats": beats}
    work = batch(robot, gaits, **settings, check_rest=check_rest)
    header = journal_header("sweep", work.swimming.robot, work.options)
    cases = Cases(header, len(work.gaits), work.layout, partial(_swim, work.swimming, work.gaits))
    return make_shards(cases, folder, executor, size=size, part=part, command=command, progress=progress)


def _swim(swimming: Swimming, gaits: Gaits, first: int, last: int) -> dict[str, Array]:
    """Return the results of the gaits from index `first` to before `last` as columns."""
    return swimming.swim(Part.of(gaits, first, last))
