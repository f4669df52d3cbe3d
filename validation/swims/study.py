"""Is each settled beat the one that a start from rest leads to, and a speed a speed? Robots and gaits at random.

    nice python validation/swims/study.py [robots] [gaits] [-o FILE]
    nice python validation/swims/study.py 10000 --springs [-o FILE]

Each settled beat says whether a start from rest leads to it. Here the start is swum, by plain beats without a
search of any kind, and what they end in is compared with what the beat said. With --springs each robot has hinges and
one gait, and the starts of every tenth are swum.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import hypertuna as ht
from hypertuna.io.files import version
from hypertuna.swimming.beat import APPROACH, STATUSES, settle, settle_from_rest
from hypertuna.swimming.gait import Gaits

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from random_robots import random_gaits, random_robot, with_random_springs

BEATS = (300, 1500, 10_000)  # beats simulated from rest; more of them where fewer do not reach the settled beat
NEAR = 1e-2  # two twists are the same within this part of the stride, or of a thousandth of a body length
FASTEST = 10.0  # body lengths a beat, which no swimmer exceeds


def strides(robot: ht.Robot, gaits: Gaits, one: NDArray[np.float64], other: NDArray[np.float64]) -> Any:
    """Return the distance of twists (gaits, 3) from others, relative to the stride of the others."""
    scale = np.array([1 / robot.body.length, 1 / robot.body.length, 1.0])
    size = np.abs((one - other) * scale).max(axis=1) / gaits.frequency
    return size / (np.abs(other[:, 0]) / robot.body.length / gaits.frequency + 1e-3)


def sprung(seed: int) -> dict[str, Any]:
    """Settle a gait such as one may try of a random robot with springs; count the robot whose springs are too fast."""
    seed_of_links = seed
    while len((robot := random_robot(seed_of_links)).links.name) < 3:  # a driven joint and a hinge
        seed_of_links += 1_000_000
    frequency = np.exp(np.random.default_rng(seed).uniform(np.log(0.5), np.log(4.0), 1))
    robot = with_random_springs(robot, float(frequency[0]), seed)
    gaits = Gaits(frequency, *(column[:1] for column in random_gaits(robot, 2, seed).columns[1:]), shape=(1,))
    try:
        return examine(robot, gaits, seed, swum=seed % 10 == 0)
    except ht.InputError as error:
        if "steps of a beat" not in str(error):
            raise
        return {"seed": seed, "gaits": 1, "refused": 1}


def examine(robot: ht.Robot, gaits: Gaits, seed: int, *, swum: bool = True) -> dict[str, Any]:
    """Settle gaits, simulate each from rest too if `swum`, and return how they compare."""
    count = len(gaits.frequency)
    start = time.process_time()
    settle(robot, gaits)
    middle = time.process_time()
    found = settle(robot, gaits, approach=APPROACH)
    checked = time.process_time()
    settled, arrived = found["status"] == 0, found["arrived"] & (found["status"] == 0)
    other = found if arrived.all() else settle_from_rest(robot, gaits)
    elsewhere = settled & ~arrived & (other["status"] == 0)
    goal = np.where(elsewhere[:, np.newaxis], other["twist"], found["twist"])
    left, off = np.arange(count), np.full(count, np.inf)  # distance of the start from rest from where it should be
    for beats in BEATS if swum else ():
        part = Gaits(*(column[left] for column in gaits.columns), shape=(len(left),))
        off[left] = strides(robot, part, settle(robot, part, wait=beats)["twist"], goal[left])
        left = np.flatnonzero((arrived | elsewhere) & ~(off < NEAR))
        if not len(left):
            break
    left = left if swum else left[:0]
    spin = settled & (np.abs(found["turn_rate"]) > np.pi * gaits.frequency)
    stride = np.abs(found["stride_length"])
    away = np.flatnonzero(settled & ~arrived)
    row = {
        "seed": seed,
        "law": robot.model.water,
        "links": len(robot.links.name),
        **({"hinges": len(robot.hinges)} if robot.hinges else {}),
        "gaits": count,
        **{name: int((found["status"] == k).sum()) for k, name in enumerate(STATUSES)},
        "spin": int(spin.sum()),
        "no_speed": int((settled & ~np.isfinite(found["speed"])).sum()),
        "too_fast": int((settled & (stride > FASTEST)).sum()),
        "fastest_bl_per_beat": float(np.max(stride[settled & ~spin], initial=0.0)),
        "arrived": int(arrived.sum()),
        "elsewhere": int(elsewhere.sum()),
        "nowhere": int((settled & ~arrived & (other["status"] != 0)).sum()),
        "rescued": int((~settled & (other["status"] == 0)).sum()),
        "swum": count if swum else 0,
        "wrong": left.tolist(),
        "beats_from_rest": float(np.median(found["approach_beats"][arrived])) if arrived.any() else 0.0,
        "cpu_settle_s": middle - start,
        "cpu_checked_s": checked - middle,
    }
    speeds = zip(away, found["speed"][away], other["speed"][away], strict=True)
    row["away"] = [{"gait": int(k), "speed": a, "speed_from_rest": b} for k, a, b in speeds]
    return row


def main() -> None:
    """Run the study, print its table, and store it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", type=int, nargs="?", default=50)
    parser.add_argument("gaits", type=int, nargs="?", default=200)
    parser.add_argument("--springs", action="store_true", help="robots with hinges, a gait each")
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    if options.springs:
        with ProcessPoolExecutor() as pool:
            rows = list(pool.map(sprung, range(options.robots), chunksize=20))
    else:
        robots = map(random_robot, range(options.robots))
        rows = [examine(robot, random_gaits(robot, options.gaits, seed), seed) for seed, robot in enumerate(robots)]
    names = ("gaits", "refused", *STATUSES, "spin", "no_speed", "too_fast")
    names += ("arrived", "elsewhere", "nowhere", "rescued", "swum")
    total = {name: sum(row.get(name, 0) for row in rows) for name in names}
    total |= {"wrong": sum(len(row.get("wrong", ())) for row in rows)}
    total |= {"fastest_bl_per_beat": max(row.get("fastest_bl_per_beat", 0.0) for row in rows)}
    total |= {name: round(sum(row.get(name, 0) for row in rows), 2) for name in ("cpu_settle_s", "cpu_checked_s")}
    for name, value in total.items():
        print(f"{name:20} {value}")
    if options.output is not None:
        size = "--springs" if options.springs else f"{options.gaits}"
        command = f"python validation/swims/study.py {options.robots} {size}"
        rows = [row for row in rows if not options.springs or row.get("away") or row.get("wrong")]
        made = {"command": command, "hypertuna_version": version(), "seeds": f"0 to {options.robots - 1}"}
        lines = ",\n".join(json.dumps(row, default=float).replace("NaN", "null") for row in rows)
        head = json.dumps(made | {"total": total}, indent=1)[:-2]
        options.output.write_text(f'{head},\n "robots": [\n{lines}\n]}}\n')


if __name__ == "__main__":
    main()
