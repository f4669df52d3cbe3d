"""Shards over any executor: a bounded number in flight, results in order, a lost worker's shards computed again."""

from __future__ import annotations

import contextlib
import os
import reprlib
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar, cast

from hypertuna import _core
from hypertuna.errors import InputError
from hypertuna.io.door import parse_json, read_bytes
from hypertuna.io.extras import need
from hypertuna.io.files import version
from hypertuna.ranges import POSITIVE_WHOLE

S = TypeVar("S")
R = TypeVar("R")

# An executor, or a function that makes one: a pool that lost a process is unusable, and the function makes a new one.
Executors: TypeAlias = Executor | Callable[[], AbstractContextManager[Executor]]

IN_FLIGHT = 256  # shards submitted and not yet consumed: bounds the memory of their results
LOSSES = 5  # workers that one shard may lose before the work stops
TIMEOUT = 30  # seconds to reach a scheduler


def thread_count(threads: int | None, executor: Executors | None = None) -> int:
    """Return the given number of threads; None: one per processor, or one on each worker of an executor."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if executor is None else 1
    return POSITIVE_WHOLE.check(threads, "threads", "leave it out for all processors")


def map_shards(
    work: Callable[[S], R], shards: Iterable[S], executor: Executors | None = None, *, in_flight: int = IN_FLIGHT
) -> Generator[R]:
    """Yield ``work(shard)`` for each shard, in their order; without an executor one after another.

    Shards of a lost worker are submitted again. An exception of `work` is raised with the shard in its note.
    """
    if executor is None:
        yield from map(work, shards)
        return
    task = _Task(work, version(), _core.isa())
    remaining, waiting, losses = iter(shards), deque[tuple[S, Future[R]]](), 0
    with _Pool(executor) as pool:
        try:
            while True:
                for shard in islice(remaining, in_flight - len(waiting)):
                    waiting.append((shard, pool.submit(task, shard)))
                if not waiting:
                    return
                shard, future = waiting[0]
                if _is_lost(future):
                    losses += 1
                    if losses > LOSSES:
                        raise _too_many_losses(shard)
                    waiting[0] = shard, pool.submit(task, shard)  # the others wait: only this shard can end its worker
                    continue
                try:
                    result = future.result()
                except Exception as error:
                    error.add_note(f"in shard {reprlib.repr(shard)}")
                    raise
                waiting.popleft()
                if losses:
                    losses = 0
                    for k, (other, pending) in enumerate(waiting):
                        if pending.done() and _is_lost(pending):
                            waiting[k] = other, pool.submit(task, other)
                yield result
        finally:
            for _, future in waiting:
                future.cancel()


@dataclass(frozen=True)
class _Task(Generic[S, R]):
    """A call of `work` on a worker, which must have the same version and instruction set, else results differ."""

    work: Callable[[S], R]
    version: str
    isa: str

    def __call__(self, shard: S) -> R:
        for key, here, sent in (("hypertuna", version(), self.version), ("HYPERTUNA_ISA", _core.isa(), self.isa)):
            if here != sent:
                rule = f"must be {sent} on every worker, as on the machine that started the work"
                fix = "install the same version everywhere" if key == "hypertuna" else "set it to the same everywhere"
                raise InputError(rule, key=key, value=here, fix=fix)
        return self.work(shard)


class _Pool:
    """An executor; if it breaks, a new one replaces it, where a function that makes executors was given."""

    def __init__(self, executor: Executors) -> None:
        self._stack = contextlib.ExitStack()
        self._make = None if isinstance(executor, Executor) else executor
        self._pool = self._open_pool() if self._make else executor

    def __enter__(self) -> _Pool:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def submit(self, task: Callable[[S], R], shard: S) -> Future[R]:
        """Submit a shard to the executor, made anew if it broke; return the future of its result."""
        try:
            return self._pool.submit(task, shard)  # type: ignore[union-attr]  # an executor, see __init__
        except BrokenExecutor:
            if self._make is None:
                fix = "run again to resume, or pass a function that makes the executor"
                raise InputError("lost a process and takes no more work", key="executor", fix=fix) from None
            self._pool = self._open_pool()
            return self._pool.submit(task, shard)

    def _open_pool(self) -> Executor:
        assert self._make is not None
        pool = self._stack.enter_context(self._make())
        self._stack.callback(_end_processes, pool)
        return pool


def _end_processes(pool: Executor) -> None:
    """Kill the idle processes of a pool: a process that died may hold the lock of the queue for which they wait."""
    processes: dict[int, Any] = getattr(pool, "_processes", None) or {}
    for process in list(processes.values()):
        process.kill()


def _is_lost(future: Future[Any]) -> bool:
    """Wait for a future; return whether its worker was lost."""
    try:
        error = future.exception()
    except CancelledError:
        return True
    dask = sys.modules.get("distributed")
    return isinstance(error, BrokenExecutor) or (dask is not None and isinstance(error, dask.KilledWorker))


def _too_many_losses(shard: object) -> InputError:
    """Return the error of a shard that ends its workers."""
    rule = f"lost the worker of shard {reprlib.repr(shard)} {LOSSES + 1} times in a row"
    return InputError(rule, key="executor", fix="give workers more memory, or make shards smaller; then run again")


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """Yield an executor of a Dask scheduler, given by its address or the path of its scheduler file."""
    need("cluster", "distributed", by="--cluster")
    import distributed

    client: Any = None
    with contextlib.suppress(OSError, ValueError, TypeError, KeyError, NotImplementedError):  # no answer, or no address
        client = cast(Any, distributed.Client)(_scheduler_address(address), timeout=TIMEOUT, set_as_default=False)
    if client is None:
        fix = "give the address that `dask scheduler` prints, such as tcp://node1:8786, or its scheduler file"
        raise InputError("must be a Dask scheduler that answers", key="--cluster", value=address, fix=fix)
    with client:
        yield client.get_executor(pure=False)


def _scheduler_address(given: str) -> str:
    """Return a scheduler's address, given or in a scheduler file; ValueError for one at which a client would hang."""
    from distributed.comm.addressing import get_address_host_port, resolve_address

    address: str = parse_json(read_bytes(given, "scheduler"))["address"] if Path(given).is_file() else given
    _, port = cast(Any, get_address_host_port)(cast(Any, resolve_address)(address))
    if not 0 < port < 2**16:
        raise ValueError
    return address
