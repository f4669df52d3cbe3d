"""The command `hypertuna shards merge`, and how commands write shards and reach a cluster."""

from __future__ import annotations

import contextlib
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.errors import InputError
from hypertuna.io.quantity import counted
from hypertuna.parallel.executors import cluster
from hypertuna.parallel.shards import SIZES, open_shards, write_merged

PLACES = ("--cluster", "--shard")  # options that say where to compute, not what
MAX_TEXT = 300_000  # results written as text: each takes 8 kB of memory as JSON, 3 kB as CSV


@contextlib.contextmanager
def connected(address: str | None) -> Iterator[Executor | None]:
    """Connect to the workers of a Dask scheduler, if one is given."""
    if address is None:
        yield None
        return
    with cluster(address) as executor:
        yield executor


def check_text(count: int, output: str | None, as_json: bool) -> None:
    """Check that a number of results is small enough to be written as text."""
    key = "--json" if as_json else "--output" if output is not None and output.lower().endswith(".csv") else ""
    if key and count > MAX_TEXT:
        fix = "write -o NAME.nc, which takes a tenth of the memory"
        raise InputError(f"must hold at most {MAX_TEXT} results as text", key=key, value=f"{count}", fix=fix)


def write_shards(
    output: str | None,
    make: Callable[..., int],
    *subject: Any,
    places: opt.Places,
    refused: Mapping[str, Any],
    as_json: bool,
    **options: Any,
) -> bool:
    """Let `make` write shards if `output` is a folder of them, and return whether; refuse options in `refused`."""
    if not (output or "").endswith(opt.SHARDS):
        for key, given in (("--shard", places.shard), ("--shard-size", places.shard_size)):
            if given is not None:
                raise InputError("needs a folder of shards", key=key, fix=f"add -o NAME{opt.SHARDS}")
        return False
    if places.shard_size is not None:
        SIZES.check(places.shard_size, "--shard-size", "leave it out for the default")
    one_file = "write one file, -o NAME.nc or -o NAME.csv"
    for key, value in refused.items():
        if value is not None:
            fix = "leave it out: the same command resumes" if key == "--checkpoint" else one_file
            raise InputError("cannot be combined with a folder of shards", key=key, value=value, fix=fix)
    options |= {"size": places.shard_size, "part": places.shard or (1, 1), "command": _placeless(sys.argv[1:])}
    with progress_bar("shards", parts="shard") as progress, connected(places.cluster) as executor:
        shards_made = make(*subject, output, executor=executor, **options, progress=progress)
    shards = open_shards(str(output))
    missing = len(shards.missing())
    facts = {"folder": output, "items": shards.total, "shards": len(shards), "made": shards_made, "missing": missing}
    status = f"{counted(shards_made, 'shard')} made, {missing} of {len(shards)} missing"
    merge = f"hypertuna shards merge {shlex.quote(str(output))} -o FILE.nc"
    lines = [(status, "bold"), "Other parts make them." if missing else f"Merge them: {merge}"]
    emit(facts, record=dict, lines=lambda _: lines, written=(output,), as_json=as_json)
    return True


def merge_command(
    folder: Annotated[str, typer.Argument(metavar="DIR", help="Folder of shards.")],
    output: opt.TableOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Check that all shards are there, whole, and of the same work, and merge them into one file.

    Missing shards are named with the command that makes them. For .nc memory holds one variable of all results at a
    time, for .csv all of them.
    """
    shards = open_shards(folder)
    check_text(shards.total, output, False)
    with progress_bar("reading") as progress:
        write_merged(shards, output, progress)
    facts = {"folder": folder, "items": shards.total, "shards": len(shards), "written": output, **shards.header}
    status = f"{counted(len(shards), 'shard')} of {folder}, {shards.total} results: all there and whole"
    emit(facts, record=dict, lines=lambda _: [(status, "bold")], written=(output,), as_json=as_json)


def _placeless(words: Sequence[str]) -> str:
    """Return a command line without --cluster and --shard, the options that say where to compute."""
    kept, skip = [], False
    for word in words:
        if not (skip or word.partition("=")[0] in PLACES):
            kept.append(word)
        skip = word in PLACES
    return shlex.join(["hypertuna", *kept])
