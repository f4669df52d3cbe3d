"""Damage thousands of input files, and judge what the commands that read them answer.

    python validation/mutations/run.py -j 2                             # 20,000 files; the same command resumes
    python validation/mutations/run.py --kind "first robot" --seed 17   # one file again

Each worker runs commands in its own process; one that ends or hangs is counted and replaced. Exit code 1 if anything
is wrong. Summary in results.json.
"""

import argparse
import contextlib
import csv
import hashlib
import itertools
import json
import multiprocessing
import os
import resource
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[name] = "1"

from mutations import cases, strangers  # noqa: E402  # above, the folder is put on the path
from mutations.cases import CASES  # noqa: E402
from mutations.strangers import READERS  # noqa: E402

FILES = 20_000  # that are damaged by default
HANGS = 900.0  # s on the clock of a busy machine, after which a worker counts as hanging and is killed
MEMORY = 3 << 30  # bytes that a worker which runs commands may use
ABOVE = 1 << 30  # bytes that a worker which runs readers may use for a file
KINDS: list[Any] = [*CASES, *READERS]
COLUMNS = ("kind", "seed", "outcome", "seconds", "slowest_s", "problem")
Row = dict[str, Any]


def state() -> str:
    """Return a digest of the sources: a journal is only resumed with the same ones."""
    files = [path for folder in ("src", "tests/mutations", "examples", "missions", "robots") for path in
             sorted((ROOT / folder).rglob("*.*")) if path.suffix in (".py", ".so", ".toml", ".csv")]  # fmt: skip
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:16]


def work(line: Connection, folder: str, parent: int) -> None:
    """Judge the files that the parent sends through a pipe, until it ends."""
    tempfile.tempdir = folder
    started = False
    while os.getppid() == parent:
        if not line.poll(5.0):
            continue
        k, seed = line.recv()
        if not started:
            start(KINDS[k])
            started = True
        begin = time.process_time()
        verdict = judged(k, seed)
        outcome = "wrong" if verdict.problems else "accepted" if verdict.accepted else "refused"
        problem = "; ".join(verdict.problems).replace("\n", " ")
        line.send((outcome, time.process_time() - begin, verdict.seconds, problem))


def start(kind: Any) -> None:
    """Before the first file, limit this process's memory for commands, or load all libraries of the readers."""
    if kind in CASES:
        return resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    for reader in READERS:
        with tempfile.TemporaryDirectory() as folder, contextlib.suppress(Exception):
            (path := Path(folder) / reader.file).parent.mkdir(exist_ok=True)
            path.write_bytes(strangers.whole(reader))
            reader.read(path)
    return None


def judged(k: int, seed: int) -> cases.Reaction:
    """Judge one damaged file, by the index of its kind and its seed."""
    kind = KINDS[k]
    return cases.judged(kind, seed) if kind in CASES else strangers.judged(kind, seed, ABOVE)


@dataclass
class Worker:
    """Process that judges files, and the file that it is at."""

    folder: str
    job: tuple[int, int] | None = None
    begin: float = 0.0

    def __post_init__(self) -> None:
        self.line, other = multiprocessing.Pipe()
        arguments = (other, self.folder, os.getpid())
        self.process = multiprocessing.get_context("fork").Process(target=work, args=arguments, daemon=True)
        self.process.start()
        other.close()

    def give(self, job: tuple[int, int]) -> None:
        """Send the process a file, as the index of its kind and its seed."""
        self.job, self.begin = job, time.monotonic()
        self.line.send(job)

    def row(self, outcome: str, seconds: float, slowest: float, problem: str) -> Row:
        """Return the row of the file that the process has judged."""
        assert self.job is not None
        values = (KINDS[self.job[0]].name, self.job[1], outcome, f"{seconds:.3f}", f"{slowest:.3f}", problem)
        return dict(zip(COLUMNS, values, strict=True))


def run(jobs: Iterator[tuple[int, int]], count: int, folder: str) -> Iterator[Row]:
    """Judge all files in `count` processes; yield each one's row."""
    workers = [Worker(folder) for _ in range(count)]
    for worker in workers:
        if (job := next(jobs, None)) is not None:
            worker.give(job)
    while busy := [worker for worker in workers if worker.job]:
        ready = wait([worker.line for worker in busy], timeout=1.0)
        for worker in busy:
            late = time.monotonic() - worker.begin
            if worker.line in ready:
                try:
                    yield worker.row(*worker.line.recv())
                except EOFError:
                    worker.process.join()
                    yield worker.row("wrong", late, late, f"ends the process: {worker.process.exitcode}")
                    workers[workers.index(worker)] = worker = Worker(folder)
            elif late > HANGS:
                worker.process.kill()
                yield worker.row("wrong", late, late, "hangs")
                workers[workers.index(worker)] = worker = Worker(folder)
            else:
                continue
            worker.job = None
            if (job := next(jobs, None)) is not None:
                worker.give(job)


def read_journal(path: Path) -> list[Row]:
    """Return the rows that an earlier run of the same sources left; begin the journal if there are none."""
    head = f"# sources {state()}\n"
    if path.exists():
        lines = path.read_text().splitlines(keepends=True)
        if lines[:1] != [head]:
            sys.exit(f"{path} is of other sources: remove it, or give another --journal")
        rows = [dict(zip(COLUMNS, row, strict=False)) for row in csv.reader(lines[1:])]
        return [row | {"seed": int(row["seed"])} for row in rows if len(row) == len(COLUMNS)]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(head)
    return []


def summary(rows: list[Row]) -> dict[str, Any]:
    """Return files by kind: accepted, refused, wrong, and the processor time of the slowest command."""
    kinds = {}
    for case in KINDS:
        own = [row for row in rows if row["kind"] == case.name]
        counts = {key: sum(row["outcome"] == key for row in own) for key in ("accepted", "refused", "wrong")}
        slowest = max((float(row["slowest_s"]) for row in own), default=0.0)
        if not own:
            continue
        kinds[case.name] = {"files": len(own), **counts, "slowest_command_s": round(slowest, 2)}
    total = {key: sum(kind[key] for kind in kinds.values()) for key in ("files", "accepted", "refused", "wrong")}
    mean = sum(float(row["seconds"]) for row in rows) / max(len(rows), 1)
    return total | {
        "mean_s_per_file": round(mean, 3),
        "slowest_command_s": max(kind["slowest_command_s"] for kind in kinds.values()),
        "sources": state(),
        "kinds": kinds,
        "problems": [f"{row['kind']}, seed {row['seed']}: {row['problem']}" for row in rows if row["problem"]],
    }


def main() -> None:
    """Judge the files that the journal lacks, and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=FILES, help="number of files")
    parser.add_argument("--first", type=int, default=0, help="first seed of each kind")
    parser.add_argument("--kind", action="append", help="kinds to run, by name")
    parser.add_argument("--readers", action="store_true", help="readers in process, in place of commands")
    parser.add_argument("--seed", type=int, help="run one seed, and show what is wrong")
    parser.add_argument("-j", type=int, default=1, dest="workers", help="workers")
    parser.add_argument("--journal", type=Path, default=ROOT / "build/mutations.csv", help="what is done")
    parser.add_argument("--results", type=Path, default=Path(__file__).with_name("results.json"), help="summary")
    options = parser.parse_args()
    chosen = READERS if options.readers else CASES
    named = [k for k, one in enumerate(KINDS) if one in chosen and (not options.kind or one.name in options.kind)]
    kinds = [k for k in named if KINDS[k].there]
    if options.seed is not None:
        start(KINDS[kinds[0]])
        sys.exit(sum(show(k, options.seed) for k in kinds) > 0)
    rows = read_journal(options.journal)
    done = {(row["kind"], row["seed"]) for row in rows}
    seeds = ((k, seed) for seed in itertools.count(options.first) for k in kinds if seed % KINDS[k].every == 0)
    jobs = [(k, seed) for k, seed in itertools.islice(seeds, options.files) if (KINDS[k].name, seed) not in done]
    begin = told = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, options.journal.open("a", buffering=1) as journal:
        writer = csv.DictWriter(journal, COLUMNS, lineterminator="\n")
        for count, row in enumerate(run(iter(jobs), options.workers, folder), 1):
            writer.writerow(row)
            rows.append(row)
            if row["problem"]:
                print(f"{row['kind']}, seed {row['seed']}: {row['problem'][:300]}", flush=True)
            if (now := time.monotonic()) - told > 30 or count == len(jobs):
                left = (now - begin) / count * (len(jobs) - count) / 60
                print(f"{count} of {len(jobs)} files, {left:.0f} min to go", flush=True)
                told = now
    facts = summary(rows)
    options.results.write_text(json.dumps(facts, indent=1) + "\n")
    print(f"{facts['files']} files: {facts['accepted']} accepted, {facts['refused']} refused, {facts['wrong']} wrong; "
          f"{facts['mean_s_per_file']} s a file, {facts['slowest_command_s']} s the slowest command")  # fmt: skip
    sys.exit(facts["wrong"] > 0)


def show(k: int, seed: int) -> bool:
    """Judge one file, and print what is wrong; return whether anything is."""
    verdict = judged(k, seed)
    print(f"{KINDS[k].name}, seed {seed}: {'; '.join(verdict.problems) or 'nothing is wrong'}")
    return bool(verdict.problems)


if __name__ == "__main__":
    main()
