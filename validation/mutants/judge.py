"""Mutate one module after another of a room, and see whether the room's own tests notice.

    make mutants ROOM=trials SEED=1                             # ten mutants, no file is changed
    python validation/mutants/judge.py trials --seed 1 2 --count 10

Each mutant is one change of one operator or number (`mutants.py`), imported in place of its module by every process of
the tests (`path/sitecustomize.py`). First the tests run without a mutant and must pass; the lines that each executes
are kept in build/mutants/ROOM.lines until its file or the package changes (`path/lines_by_test.py`). Only the tests
that execute a mutant judge it, the fastest forty first, then the others of their files; those that imports execute, all
tests of the room. The first that fails ends a run. A mutant is killed if a test fails after some process imported it.
Tests that together would take over a minute, as traced, are left out, the slowest first: what only they kill survives.
All runs are forks of one process, which has imported the libraries and neither the package nor its tests (`warm.py`).
A run may take three times as long as without a mutant, and a minute more: a timeout is neither killed nor survived.
What cannot be noticed stands in `equivalent.toml` with its reason, and is not drawn. Killed ones are on disk at once,
and the same command goes on after `kill -9`; remove build/mutants to judge them anew. The output of the last run is in
build/mutants/ROOM.log. The room "all" is every room with tests of its own. The exit code is 1 if not all were killed.
"""

import argparse
import functools
import hashlib
import importlib.util
import json
import os
import subprocess
import sys
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from tempfile import TemporaryDirectory

from mutants import Mutant, drawn

from hypertuna.cli.console import progress_bar

ROOT = Path(__file__).resolve().parents[2]
PLACE = ROOT / "build" / "mutants"  # folder of traces and logs
# Of PYTHONPATH: this study's hooks first
PATHS = (str(Path(__file__).with_name("path")), os.environ.get("PYTHONPATH", ""))
TIMES, MORE = 3.0, 60.0  # a mutant's tests may take TIMES as long as without it, and MORE seconds
FIRST = 40  # number of tests in the first group
BUDGET = 60.0  # s, processor time that a mutant's tests may take by their traces
KILLED, SURVIVED, TIMEOUT = "killed", "survived", "timeout"


def modules(room: str) -> list[str]:
    """Return the modules of a room, which is a folder or a module of src/hypertuna."""
    place = ROOT / "src" / "hypertuna" / room
    found = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    return [str(path.relative_to(ROOT)) for path in found if path.is_file()]


def suite(room: str) -> list[str]:
    """Return the files of a room's tests, by their paths from the repository's root."""
    files = sorted((ROOT / "tests" / room).rglob("test_*.py"))
    return [str(path.relative_to(ROOT)) for path in [*files, ROOT / "tests" / f"test_{room}.py"] if path.is_file()]


def rooms() -> list[str]:
    """Return all rooms with tests of their own."""
    return [path.stem for path in sorted((ROOT / "src" / "hypertuna").glob("[a-z]*")) if suite(path.stem)]


@functools.cache
def core() -> str:
    """Return the extension's file, built now if its sources changed, so that no run builds it."""
    spec = importlib.util.find_spec("hypertuna._core")
    assert spec is not None
    assert spec.origin is not None
    return spec.origin


@dataclass
class Trace:
    """Lines that a test executes; without seconds, those of collecting its file or, with no name, of all imports."""

    seconds: float = 0.0
    lines: dict[str, set[int]] = field(default_factory=lambda: defaultdict(set))  # by module

    def meets(self, mutant: Mutant) -> bool:
        """Return whether the test executes a mutant's lines, or any of its module where imports execute the mutant."""
        lines = self.lines.get(mutant.module.removeprefix("src/hypertuna/"), set())
        return any(mutant.lines is None or mutant.lines[0] <= line <= mutant.lines[1] for line in lines)


def traced(room: str) -> dict[str, Trace]:
    """Return the trace of each test, from the last run of its file if nothing has changed since."""
    tests: dict[str, Trace] = defaultdict(Trace)
    folder = PLACE / f"{room}.lines"
    common = [path for part in ("src", "core/include", "bindings") for path in (ROOT / part).rglob("*.[hcp][pty]*")]
    common += [*(ROOT / "tests").glob("*.py"), *(ROOT / "tests" / room).glob("conftest.py")]
    base = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(common)))
    for file in suite(room):
        key = base.copy()
        key.update((ROOT / file).read_bytes())
        place = folder / f"{Path(file).stem}-{key.hexdigest()[:16]}.jsonl"
        if not place.is_file():
            folder.mkdir(parents=True, exist_ok=True)
            for old in folder.glob(f"{Path(file).stem}-*"):
                old.unlink()
            with TemporaryDirectory() as parts:
                outcome([file], log=PLACE / f"{room}.log", lines=parts)
                text = "".join(part.read_text(encoding="utf-8") for part in Path(parts).iterdir())
            new = place.with_suffix(".new")
            new.write_text(text, encoding="utf-8")
            new.rename(place)
        for row in map(json.loads, place.read_text(encoding="utf-8").splitlines()):
            test = tests[row["test"]]
            test.seconds += row["seconds"]
            for module, lines in row["lines"].items():
                test.lines[module].update(lines)
    return tests


def chosen(tests: dict[str, Trace], mutant: Mutant) -> list[list[str]]:
    """Return the tests to run one group after the other: those that execute the mutant, fastest first, then the others.

    The others are those of the same files, which may share a fixture, or all if imports execute the mutant. Those that
    would exceed the budget are left out. In a group, the tests of a file follow one another and share its fixtures.
    """
    met = {name for name, test in tests.items() if test.meets(mutant)}
    everywhere = mutant.lines is None or "" in met
    files = {name.partition("::")[0] for name in met}
    found = [name for name in tests if "::" in name and (everywhere or name.partition("::")[0] in files)]
    found.sort(key=lambda name: (name not in met, tests[name].seconds))
    until = list(accumulate(tests[name].seconds for name in found))
    found = [name for k, name in enumerate(found) if not k or until[k] <= BUDGET]
    first = min(FIRST, len(met.intersection(found)))
    return [by_file(group) for group in (found[:first], found[first:]) if group]


def by_file(tests: list[str]) -> list[str]:
    """Return tests grouped by file, files in the order of their first tests."""
    files = list(dict.fromkeys(name.partition("::")[0] for name in tests))
    return sorted(tests, key=lambda name: files.index(name.partition("::")[0]))


@functools.cache
def warm() -> subprocess.Popen[str]:
    """Return the process that runs pytest; it ends with this one."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, PATHS)), "HYPERTUNA_CORE": core()}
    line = [sys.executable, str(Path(__file__).with_name("warm.py"))]
    return subprocess.Popen(line, cwd=ROOT, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def run(arguments: list[str], environment: dict[str, str], log: str, limit: float | None) -> int | None:
    """Run pytest; return its exit code, None if it took longer than `limit` in s."""
    asked, answer = warm().stdin, warm().stdout
    assert asked is not None
    assert answer is not None
    told = {"arguments": arguments, "environment": environment, "log": log, "limit": limit}
    print(json.dumps(told), file=asked, flush=True)
    code: int | None = json.loads(answer.readline())
    return code


def outcome(
    tests: list[str],
    mutant: Mutant | None = None,
    limit: float | None = None,
    log: Path | None = None,
    lines: str | None = None,
) -> str:
    """Run tests with a mutant, in at most `limit` seconds: killed, survived or timeout; note lines in a folder."""
    environment: dict[str, str] = {}
    line = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:randomly", "-W", "ignore:Module already imported"]
    if lines:
        environment["HYPERTUNA_LINES"] = lines
        line += ["-p", "lines_by_test"]
    with TemporaryDirectory() as folder:
        imported, names = Path(folder) / "imported", Path(folder) / "tests"
        names.write_text("\n".join(tests), encoding="utf-8")
        line.append(f"@{names}")
        if mutant is not None:
            name = mutant.module.removeprefix("src/").removesuffix(".py").replace("/", ".").removesuffix(".__init__")
            told = {"name": name, "file": str(ROOT / mutant.module), "place": mutant.place, "imported": str(imported)}
            environment["HYPERTUNA_MUTANT"] = json.dumps(told)
        code = run(line, environment, str(log or os.devnull), limit)
        if code is None:
            return TIMEOUT
        if code and not imported.is_file():
            sys.exit(f"error: tests must pass without a mutant, but fail: see {log or tests}")
        return KILLED if code else SURVIVED


def judged(room: str, seeds: list[int], count: int) -> Iterator[tuple[int, Mutant, str]]:
    """Yield seed, mutant and outcome of the first `count` mutants in the order of each seed."""
    equivalent = tomllib.loads(Path(__file__).with_name("equivalent.toml").read_text(encoding="utf-8"))
    PLACE.mkdir(parents=True, exist_ok=True)
    journal, log = PLACE / f"{room}.killed", PLACE / f"{room}.log"
    known = set(journal.read_text(encoding="utf-8").splitlines()) if journal.is_file() else set()
    tests: dict[str, Trace] = {}
    for seed in seeds:
        order = [one for one in drawn(ROOT, modules(room), seed) if one.name not in equivalent]
        for one in order[:count]:
            key = json.dumps([one.name, one.place])
            result = KILLED if key in known else SURVIVED
            if result == SURVIVED:
                tests = tests or traced(room)
                for group in chosen(tests, one):
                    limit = TIMES * sum(tests[name].seconds for name in group) + MORE
                    result = outcome(group, one, limit, log)
                    if result != SURVIVED:
                        break
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
    asked_rooms = rooms() if asked.room == "all" else [asked.room]
    for what, found in (("a folder or module of src/hypertuna", modules), ("with tests of its own", suite)):
        if not all(map(found, asked_rooms)):
            print(f"error: ROOM must be {what}, or all, but is {asked.room}", file=sys.stderr)
            return 2
    total: Counter[str] = Counter()
    with progress_bar(f"mutants of {asked.room}", slow=True) as progress:
        for room in asked_rooms:
            counts: dict[int, Counter[str]] = {seed: Counter() for seed in asked.seed}
            for seed, one, result in judged(room, asked.seed, asked.count):
                counts[seed][result] += 1
                total[result] += 1
                progress(total.total(), asked.count * len(asked.seed) * len(asked_rooms))
                if result != KILLED:
                    print(f"{result}: {one.name}", flush=True)
            for seed, count in counts.items():
                print(f"{room}, seed {seed}: {described(count)}", flush=True)
    if len(asked_rooms) > 1:
        print(f"all: {described(total)}, {total[KILLED] / total.total():.0%}")
    return int(total[KILLED] < total.total())


def described(count: Counter[str]) -> str:
    """Return the counts of outcomes in a sentence."""
    return f"{count[KILLED]} killed of {count.total()}, {count[TIMEOUT]} timeouts"


if __name__ == "__main__":
    sys.exit(main())
