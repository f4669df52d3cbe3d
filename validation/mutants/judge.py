"""Mutate one module after another of a room, and see whether the room's own tests notice.

    make mutants ROOM=trials SEED=1                             # ten mutants, no file is changed
    python validation/mutants/judge.py trials --seed 1 --count 10

Each mutant is one change of one operator or number (`mutants.py`), imported in place of its module by every process of
the tests (`path/sitecustomize.py`). Tests of the module come first, and the first that fails ends a run. A run may take
three times as long as one without a mutant, and a minute more. What cannot be noticed stands in `equivalent.toml` with
its reason, and is not drawn. Results are on disk at once, and the same command goes on after `kill -9`: remove
build/mutants after a change of code or tests. The exit code is 1 if a mutant survived.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path

from mutants import Mutant, drawn

from hypertuna.cli.console import progress_bar

ROOT = Path(__file__).resolve().parents[2]
PATHS = (str(Path(__file__).with_name("path")), os.environ.get("PYTHONPATH", ""))
TIMES, MORE = 3.0, 60.0  # of a run without a mutant; s


def modules(room: str) -> list[str]:
    """Return the modules of a room, a folder or a module of src/hypertuna."""
    place = ROOT / "src" / "hypertuna" / room
    found = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    return [str(path.relative_to(ROOT)) for path in found]


def tests(room: str, module: str) -> list[str]:
    """Return the tests of a room, those of a module first."""
    own = f"test_{Path(module).stem}.py"
    folder = ROOT / "tests" / room
    if not folder.is_dir():
        return [str(ROOT / "tests" / f"test_{room}.py")]
    first = [str(path) for path in sorted(folder.rglob(own))]
    return [*first, *(str(path) for path in sorted(folder.rglob("test_*.py")) if path.name != own)]


def passes(files: list[str], mutant: Mutant | None, limit: float | None = None) -> bool:
    """Run tests with a mutant; False where one fails or they take too long."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, PATHS))}
    if mutant is not None:
        name = mutant.module.removeprefix("src/").removesuffix(".py").replace("/", ".").removesuffix(".__init__")
        told = {"name": name, "file": str(ROOT / mutant.module), "place": mutant.place}
        environment["HYPERTUNA_MUTANT"] = json.dumps(told)
    line = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *files]
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(line, cwd=ROOT, env=environment, stdout=quiet, stderr=quiet, start_new_session=True)
    try:
        return process.wait(limit) == 0
    except subprocess.TimeoutExpired:
        return False
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def judged(room: str, seed: int, count: int) -> Iterator[tuple[Mutant, bool]]:
    """Yield the first mutants in the order of a seed, with whether the tests noticed them."""
    equivalent = tomllib.loads(Path(__file__).with_name("equivalent.toml").read_text(encoding="utf-8"))
    order = [one for one in drawn(ROOT, modules(room), seed) if one.name not in equivalent]
    journal = ROOT / "build" / "mutants" / f"{room}-{seed}.jsonl"
    journal.parent.mkdir(parents=True, exist_ok=True)
    known = dict(json.loads(line) for line in journal.read_text().splitlines()) if journal.is_file() else {}
    start = time.monotonic()
    if len(known) < count and not passes(tests(room, ""), None):
        sys.exit(f"the tests of {room} must pass without a mutant")
    limit = TIMES * (time.monotonic() - start) + MORE
    for one in order[:count]:
        if one.name not in known:
            known[one.name] = not passes(tests(room, one.module), one, limit)
            with journal.open("a") as file:
                file.write(json.dumps([one.name, known[one.name]]) + "\n")
        yield one, known[one.name]


def main() -> int:
    """Judge mutants, print those that survived."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("room")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    if not all((ROOT / module).is_file() for module in modules(asked.room)):
        print(f"error: {asked.room} must be a folder or module of src/hypertuna", file=sys.stderr)
        return 2
    found = []
    with progress_bar(f"mutants of {asked.room}", slow=True) as progress:
        for one, noticed in judged(asked.room, asked.seed, asked.count):
            found.append((one, noticed))
            progress(len(found), asked.count)
    survived = [one.name for one, noticed in found if not noticed]
    if asked.json:
        print(json.dumps({"room": asked.room, "seed": asked.seed, "mutants": len(found), "survived": survived}))
    else:
        print(*survived, f"{asked.room}: {len(found) - len(survived)} of {len(found)} mutants noticed", sep="\n")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
