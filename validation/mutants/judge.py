"""Mutate one module after another of a room, and see whether the room's own tests notice.

    make mutants ROOM=trials SEED=1                             # ten mutants, no file is changed
    python validation/mutants/judge.py trials --seed 1 2 --count 10

Each mutant is one change of one operator or number (`mutants.py`), imported in place of its module by every process of
the tests (`path/sitecustomize.py`). Without a mutant the tests must pass. Those that mention the mutated function and
module come first, and the first that fails ends a run. A mutant is killed if a test fails after some process imported
it. A run may take three times as long as one without a mutant, and a minute more: a timeout is neither killed nor
survived. What cannot be noticed stands in `equivalent.toml` with its reason, and is not drawn. Killed ones are on disk
at once, and the same command goes on after `kill -9`; remove build/mutants to judge them anew. The output of the last
run is in build/mutants/ROOM.log. The exit code is 1 if not all were killed.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from mutants import Mutant, drawn

from hypertuna.cli.console import progress_bar

ROOT = Path(__file__).resolve().parents[2]
PLACE = ROOT / "build" / "mutants"
PATHS = (str(Path(__file__).with_name("path")), os.environ.get("PYTHONPATH", ""))
TIMES, MORE = 3.0, 60.0  # of a run without a mutant; s
KILLED, SURVIVED, TIMEOUT = "killed", "survived", "timeout"


def modules(room: str) -> list[str]:
    """Return the modules of a room, a folder or a module of src/hypertuna."""
    place = ROOT / "src" / "hypertuna" / room
    found = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    return [str(path.relative_to(ROOT)) for path in found if path.is_file()]


def suite(room: str, mutant: Mutant | None = None) -> list[str]:
    """Return the files of a room's tests, those nearest to a mutant first."""
    files = sorted((ROOT / "tests" / room).rglob("test_*.py"))
    files += [path for path in [ROOT / "tests" / f"test_{room}.py"] if path.is_file()]
    if mutant is not None:
        stem = Path(mutant.module).stem
        words = [stem, *mutant.function.split(".")]
        text = {path: path.read_text(encoding="utf-8") for path in files}
        files.sort(key=lambda path: (path.name != f"test_{stem}.py", -sum(word in text[path] for word in words)))
    return [str(path) for path in files]


def outcome(files: list[str], mutant: Mutant | None = None, limit: float | None = None, log: Path | None = None) -> str:
    """Run tests with a mutant, in at most `limit` seconds: killed, survived or timeout."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, PATHS))}
    line = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *files]
    with TemporaryDirectory() as folder, open(log or os.devnull, "w") as output:
        imported = Path(folder) / "imported"
        if mutant is not None:
            name = mutant.module.removeprefix("src/").removesuffix(".py").replace("/", ".").removesuffix(".__init__")
            told = {"name": name, "file": str(ROOT / mutant.module), "place": mutant.place, "imported": str(imported)}
            environment["HYPERTUNA_MUTANT"] = json.dumps(told)
        process = subprocess.Popen(
            line, cwd=ROOT, env=environment, stdout=output, stderr=output, start_new_session=True
        )
        try:
            code = process.wait(limit)
        except subprocess.TimeoutExpired:
            return TIMEOUT
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        if code and not imported.is_file():
            sys.exit(f"error: tests must pass without a mutant, but fail: see {log or files}")
        return KILLED if code else SURVIVED


def judged(room: str, seeds: list[int], count: int) -> Iterator[tuple[int, Mutant, str]]:
    """Yield seed, mutant and outcome of the first `count` mutants in the order of each seed."""
    equivalent = tomllib.loads(Path(__file__).with_name("equivalent.toml").read_text(encoding="utf-8"))
    PLACE.mkdir(parents=True, exist_ok=True)
    journal, log = PLACE / f"{room}.killed", PLACE / f"{room}.log"
    known = set(journal.read_text(encoding="utf-8").splitlines()) if journal.is_file() else set()
    limit = None
    for seed in seeds:
        order = [one for one in drawn(ROOT, modules(room), seed) if one.name not in equivalent]
        for one in order[:count]:
            key = json.dumps([one.name, one.place])
            if limit is None and key not in known:
                start = time.monotonic()
                outcome(suite(room), log=log)
                limit = TIMES * (time.monotonic() - start) + MORE
            result = KILLED if key in known else outcome(suite(room, one), one, limit, log)
            if result == KILLED and key not in known:
                known.add(key)
                with journal.open("a", encoding="utf-8") as file:
                    file.write(key + "\n")
            yield seed, one, result


def main() -> int:
    """Judge mutants, print those that were not killed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("room")
    parser.add_argument("--seed", type=int, nargs="+", default=[1])
    parser.add_argument("--count", type=int, default=10)
    asked = parser.parse_args()
    for what, found in (("a folder or module of src/hypertuna", modules), ("with tests of its own", suite)):
        if not found(asked.room):
            print(f"error: ROOM must be {what}, but is {asked.room}", file=sys.stderr)
            return 2
    counts: dict[int, Counter[str]] = {seed: Counter() for seed in asked.seed}
    with progress_bar(f"mutants of {asked.room}", slow=True) as progress:
        for done, (seed, one, result) in enumerate(judged(asked.room, asked.seed, asked.count), start=1):
            counts[seed][result] += 1
            progress(done, asked.count * len(asked.seed))
            if result != KILLED:
                print(f"{result}: {one.name}", flush=True)
    for seed, count in counts.items():
        numbers = f"{count[KILLED]} killed of {count.total()}, {count[TIMEOUT]} timeouts"
        print(f"{asked.room}, seed {seed}: {numbers}")
    return int(any(count[KILLED] < count.total() for count in counts.values()))


if __name__ == "__main__":
    sys.exit(main())
