"""Time of a settled gait under the water laws that leave a wake; as a program, of two builds that take turns.

python benchmarks/settled.py OLD NEW [--turns N]

OLD and NEW are Python interpreters, such as .venv/bin/python of two clones. Each has a process of its own on the same
core. Prints beats that a gait takes to settle, processor time (medians) and NEW over OLD (median over the turns);
returns 1 if one exceeds 1.05.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Callable, Iterable
from functools import partial
from statistics import fmean, median
from typing import Any

from timing import processor_seconds, stay_on_one_core

ALLOWED = 1.05  # largest time of NEW over OLD
REPEATS = 3  # calls of a case in a turn
ALONE = 20  # gaits that swim one by one


def cases() -> dict[str, tuple[Callable[[], float], int]]:
    """Return a function that settles gaits and returns mean beats, and their number, by name: in lanes or alone."""
    import hypertuna
    from hypertuna.description.new import new_robot
    from hypertuna.description.robot import parse
    from hypertuna.swimming.beat import settle
    from hypertuna.swimming.model import core_model
    from peers import fish

    ours, found = hypertuna.load("hypertuna").using(joints="ideal"), {}
    robots = {f"HyperTuna, {law}": ours.using(water=law) for law in ("strip", "elongated")}
    robots["`robot new`, strip"] = parse(new_robot("new"), file="new.toml")
    hinge = {"link": 7, "stiffness_n_m_per_rad": 0.2, "damping_n_m_s_per_rad": 0.001}  # the fin's root
    robots["HyperTuna with a hinge, strip"] = parse(robots["HyperTuna, strip"].document() | {"hinge": hinge})

    def gaits(part: fish.Gaits) -> hypertuna.Gaits:
        columns = part.frequency, part.amplitude, part.phase
        return hypertuna.Gaits(*columns, bias=0 * part.phase, shape=(len(part),))

    whole = fish.grid()
    some = [gaits(whole[k : k + 1]) for k in range(0, len(whole), len(whole) // ALONE)]
    for name, robot in robots.items():
        for how, parts in {"in lanes": [gaits(whole)], "alone": some}.items():
            work = partial(_mean_beats, partial(settle, robot, model=core_model(robot)), parts)
            found[f"{name}, {how}"] = work, sum(len(part.frequency) for part in parts)
    return found


def _mean_beats(settle: Callable[..., Any], parts: Iterable[Any]) -> float:
    """Settle gaits, part by part, and return the mean number of beats that they take."""
    return fmean(settle(part)["beats"].mean() for part in parts)


def work() -> None:
    """Print the beats of each case, then answer every line of the standard input by the times of a gait [s]; JSON."""
    contestants = cases()
    print(json.dumps({name: run() for name, (run, _) in contestants.items()}), flush=True)
    for _ in sys.stdin:
        times = {name: processor_seconds(run, REPEATS) / count for name, (run, count) in contestants.items()}
        print(json.dumps(times), flush=True)


def compare(pythons: list[str], turns: int) -> list[dict[str, list[float]]]:
    """Let two interpreters take turns; return for each, by case, the beats followed by the time of each turn."""
    command = [__file__, "--work"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    builds = [subprocess.Popen([python, *command], text=True, **pipes) for python in pythons]
    found: list[dict[str, list[float]]] = [{}, {}]
    for turn in range(turns + 1):
        for k in (0, 1) if turn % 2 else (1, 0):
            stdin, stdout = builds[k].stdin, builds[k].stdout
            assert stdin is not None
            assert stdout is not None
            if turn:
                print("next", file=stdin, flush=True)
            for name, value in json.loads(stdout.readline()).items():
                found[k].setdefault(name, []).append(value)
    for build in builds:
        build.communicate()
    return found


def main() -> int:
    """Compare two builds; return 1 if the new one takes too long."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("python", nargs="*", metavar="PYTHON", help="the old build's and the new one's")
    parser.add_argument("--turns", type=int, default=30)
    parser.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    stay_on_one_core()
    if options.work:
        work()
        return 0
    if len(options.python) != 2:
        parser.error("name two interpreters, the old build's and the new one's")
    builds = compare(options.python, options.turns)
    missed = 0
    print("| | beats | new | time of a gait [us] | new | new over old |\n|---|---:|---:|---:|---:|---:|")
    for name, (before, *old) in builds[0].items():
        after, *new = builds[1][name]
        ratio = median(b / a for a, b in zip(old, new, strict=True))
        missed |= ratio > ALLOWED
        times = f"{1e6 * median(old):.1f} | {1e6 * median(new):.1f}"
        print(f"| {name} | {before:.2f} | {after:.2f} | {times} | {ratio:.3f} |")
    return missed


if __name__ == "__main__":
    sys.exit(main())
