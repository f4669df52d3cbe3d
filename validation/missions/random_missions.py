"""Fly random missions: fences, waypoints, currents up to twice the robot's speed, lost sensors and fins, no satellites.

    python validation/missions/random_missions.py -n 118 -o build/random.jsonl     # resumes where the file ends

Each flight is one line of JSON. The table lists every flight that left its fence, went below its depth limit, ended
away from home, or claims a waypoint or a home that it had not reached.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.control.guidance import gait_table
from hypertuna.control.mission import Mission, Point, Waypoint, cross, fence_distance, sides
from hypertuna.mission.record import MissionRecord, names_of
from hypertuna.mission.run import MissionRun, fly_parts, joined_parts, mission_start

SENSORS = ("imu", "field", "depth", "battery")  # that fail in a mission
KINDS = ("nan", "stuck")  # of sensors' failures
FINS = ("fin-port:stuck", "fin-starboard:down", "fins:up", "fins:down")  # failures of fins
SIGMAS = 3.0  # an excursion or a claimed place may be off by so many standard deviations
DEPTH = 0.3  # m, allowed beyond the limit of depth


@dataclass(frozen=True)
class Sample:
    """A random mission, and what fails in it."""

    mission: Mission
    faults: tuple[str, ...]


def sample(seed: int) -> Sample:
    """Sample a mission: fence around the start, waypoints inside, water, satellites, a fault in every second one."""
    random = np.random.default_rng([20, seed])
    while True:
        mission = _course(random)
        if all(_inside(mission, place, 4.0) for place in mission.course) and not any(
            cross(leg, side) for leg in zip(mission.course, mission.course[1:], strict=False) for side in
            sides(mission.fence)
        ):  # fmt: skip
            break
    faults: list[str] = []
    if random.uniform() < 0.5:
        what = f"{random.choice(SENSORS)}:{random.choice(KINDS)}" if random.uniform() < 0.75 else random.choice(FINS)
        faults = [f"{what}@{random.uniform(5, 300):.0f}"]
    return Sample(mission, tuple(faults))


def _course(random: np.random.Generator) -> Mission:
    """Sample fence, waypoints and water, which need not fit each other."""
    fastest = gait_table(robot()).speed[-1]
    corners = random.integers(4, 8)
    angle = 2 * math.pi * (np.arange(corners) + random.uniform(-0.3, 0.3, corners)) / corners
    reach = random.uniform(20, 60, corners)
    fence = tuple((float(r * math.cos(a)), float(r * math.sin(a))) for r, a in zip(reach, angle, strict=True))
    start = _place(random, 10)
    depth = np.where(random.uniform(size=4) < 0.2, 0.0, random.uniform(0.3, 3.0, 4))
    points = tuple(
        Waypoint(
            *_place(random, 50),
            float(depth[k]),
            float(random.uniform(0.58, 0.98) * fastest),
            float(random.uniform(2.5, 5)),
        )
        for k in range(random.integers(1, 5))
    )
    limit = max(point.depth for point in points) + random.uniform(0.7, 2)
    strongest = fastest * random.choice([0.43, 0.86, 2.3], p=[0.6, 0.25, 0.15])
    speed, toward = strongest * random.uniform(0.3, 1), 2 * math.pi * random.uniform()
    current = (speed * math.sin(toward), speed * math.cos(toward))
    fades = random.uniform() < 0.3
    gaps: tuple[tuple[float, float], ...] = ()
    if random.uniform() < 0.35:
        begin = random.choice([0.0, random.uniform(50, 300)])
        gaps = ((float(begin), 1e6 if random.uniform() < 0.6 else float(begin) + 200),)
    return Mission(
        waypoints=points,
        start=start,
        home=start if random.uniform() < 0.8 else _place(random, 10),
        heading=float(random.uniform(-math.pi, math.pi)),
        fence=fence,
        depth_max=float(limit),
        bottom=float(limit + random.uniform(0.5, 5)),
        duration=float(random.choice([0.0, 500.0, 900.0])),
        surface_every=float(random.choice([0.0, 120.0])),
        current=current,
        current_bottom=(0.3 * current[0], 0.3 * current[1]) if fades else current,
        gaps=gaps,
    )


def _place(random: np.random.Generator, reach: float) -> Point:
    radius, angle = reach * math.sqrt(random.uniform()), 2 * math.pi * random.uniform()
    return float(radius * math.cos(angle)), float(radius * math.sin(angle))


def _inside(mission: Mission, place: Point, room: float) -> bool:
    return bool(fence_distance(mission, np.array([place]))[0] > room)


@cache
def robot() -> ht.Robot:
    """Load the robot, once per process."""
    return ht.load("hypertuna")


def fly_one(seed: int) -> dict[str, Any]:
    """Fly a sampled mission; return what happened as the row of the table."""
    one = sample(seed)
    start = mission_start(robot(), one.mission, seed=seed, faults=one.faults, duration=1200)
    parts: list[Any] = []
    for _, part in fly_parts(start, ended=_rests):
        parts.append(part)
    return {"seed": seed} | measure(joined_parts(start, parts), one)


def _rests(part: Any) -> bool:
    """Return whether a part ends a mission, or held all through."""
    modes = {ht._core.mode_table()[int(mode)][0] for mode in part["mode"]}
    return bool(modes & {"done", "ended"}) or modes == {"hold"}


def measure(run: MissionRun, one: Sample) -> dict[str, Any]:
    """Measure a flight: excursion, depth, claims, and what it reported."""
    data, mission = run.data, one.mission
    place, error = data["position"][:, :2], data["position_error"]
    off = np.hypot(*(data["position_estimated"] - place).T)
    beyond = -fence_distance(mission, place)
    worst = int(beyond.argmax())
    home = np.hypot(*(place - mission.home).T)
    record = MissionRecord("", "", mission, run.time, {k: data[k] for k in ("position", "attitude", "reasons")},
                           **names_of(robot()))  # fmt: skip
    return {
        "status": run.status,
        "faults": " ".join(one.faults),
        "satellites": "all" if not mission.gaps else "none" if mission.gaps[0] == (0.0, 1e6) else "gaps",
        "current": math.hypot(*mission.current),
        "time": float(run.time[-1]),
        "beyond": float(beyond[worst]),
        "beyond_time": float(run.time[worst]),
        "beyond_error": float(error[worst]),
        "home": float(home[-1]),
        "home_radius": mission.home_radius,
        "end_off": float(off[-1]),
        "end_error": float(error[-1]),
        "off_sigmas": float((off / error).max()),
        "depth_over": float((-data["position"][:, 2]).max() - mission.depth_max),
        "depth_end": float(-data["position"][-1, 2]),
        "waypoints": len(mission.waypoints),
        "claims": claims(run),
        "reasons": record.first_reasons,
    }


def claims(run: MissionRun) -> list[list[float]]:
    """Return true distance, radius, uncertainty and depth error [m] at every waypoint reported as reached."""
    leg, mission = run.data["leg"].astype(int), run.start.mission
    rows = np.flatnonzero(np.diff(run.data["reached"])) + 1
    return [
        [
            float(np.hypot(*(run.data["position"][k, :2] - mission.waypoints[leg[k] - 1][:2]))),
            mission.waypoints[leg[k] - 1].radius,
            float(run.data["position_error"][k]),
            float(-run.data["position"][k, 2] - mission.waypoints[leg[k] - 1].depth),
        ]
        for k in rows
    ]


def complaints(row: dict[str, Any]) -> Iterator[str]:
    """Yield what is wrong with a flight, in words."""
    swept = "swept" in row["reasons"]
    if row["beyond"] > max(1.0, SIGMAS * row["beyond_error"]) and not swept:
        yield f"outside by {row['beyond']:.1f} m with an uncertainty of {row['beyond_error']:.1f} m"
    if row["status"] == "done" and row["home"] > row["home_radius"] + SIGMAS * row["end_error"]:
        yield f"done {row['home']:.1f} m from home"
    if row["status"] == "done" and row["end_error"] > row["home_radius"]:
        yield f"done with an uncertainty of {row['end_error']:.1f} m"
    if row["depth_over"] > DEPTH:
        yield f"{row['depth_over']:.2f} m below its limit"
    for far, radius, error, depth in row["claims"]:
        if far > radius + SIGMAS * error or error > radius:
            yield f"reached a waypoint of {radius:.1f} m at {far:.1f} m with an uncertainty of {error:.1f} m"
        if abs(depth) > DEPTH:
            yield f"reached a waypoint {depth:+.1f} m from its depth"


def table(rows: list[dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of a table of flights that went wrong, and the counts."""
    wrong = {row["seed"]: list(complaints(row)) for row in rows}
    for row in rows:
        if wrong[row["seed"]]:
            seed, texts = row["seed"], "; ".join(wrong[row["seed"]])
            reasons = " ".join(f"{name}@{time:.0f}" for name, time in row["reasons"].items())
            yield (
                f"{seed:4d} {row['status']:9s} {row['time']:6.0f} s  current {row['current']:.2f} m/s  satellites "
                f"{row['satellites']:4s}  {row['faults'] or 'healthy'}\n       {texts}\n       {reasons}"
            )
    out = [row for row in rows if row["beyond"] > 0]
    yield f"{len(rows)} flights: " + ", ".join(f"{n} {s}" for s, n in Counter(r["status"] for r in rows).items())
    yield f"outside the fence: {len(out)}, by more than 1 m and {SIGMAS:g} uncertainties and not swept: " + str(
        sum(any("outside" in text for text in texts) for texts in wrong.values())
    )
    yield f"max depth beyond the limit: {max(row['depth_over'] for row in rows):.2f} m"
    yield f"flights with a complaint: {sum(map(bool, wrong.values()))}"


def main() -> None:
    """Fly the missions that the file lacks, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=118, help="missions, of seeds 1 to N")
    parser.add_argument("-j", type=int, default=1, help="processes")
    parser.add_argument("-o", type=Path, required=True, help="file of JSON lines, one per flight")
    options = parser.parse_args()
    rows = [json.loads(line) for line in options.o.read_text().splitlines()] if options.o.exists() else []
    flown = {row["seed"] for row in rows}
    with ProcessPoolExecutor(options.j) as pool, options.o.open("a") as file:
        for row in pool.map(fly_one, [seed for seed in range(1, options.n + 1) if seed not in flown]):
            rows.append(row)
            print(json.dumps(row), file=file, flush=True)
    print("\n".join(table(sorted(rows, key=lambda row: int(row["seed"])))))
    sys.exit(any(any(complaints(row)) for row in rows))


if __name__ == "__main__":
    main()
