"""The strip law as physics: two numbers fitted on four gaits, all else from theory, and what becomes of it otherwise.

    python validation/hydrodynamics/study.py [-o FILE] [--twin]

Prints the tables of this folder's README; with -o stores the numbers and what made them as JSON (about a minute, with
the twin four).
"""

from __future__ import annotations

import argparse
import json
import math
import shlex
import sys
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import parse
from hypertuna.identification.identify import identify
from hypertuna.paper.computed import COSTS, SPEEDS
from hypertuna.paper.ledger import published, published_value
from hypertuna.simulation.twin import twins
from hypertuna.swimming.gait import named_gait
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.trials import Trials

FISH = ht.load("hypertuna")
TRUTH = np.array([published_value(f"speed/{name}") for name in SPEEDS])
FOUR = SPEEDS[:4]  # the unoptimized gaits, the only ones that are fitted
FREE = ("water.blunt_area[0]", "joints.bandwidth")  # what is fitted: form drag of the head, bandwidth of the joints
FIN = len(FISH.links.name) - 1  # index of the last link
SWIM = 20.0  # s, duration of a run of the twin

# Robots of the study, by what differs from the file; a list's last entry is the fin's.
VARIANTS: dict[str, Mapping[str, float]] = {
    "as in the file": {},
    "steady C_n": {"drag_beating": 0.0},
    "C_n at the KC of the slowest gaits, 12.8": {"drag_beating": 8 * 12.8 ** (-1 / 3) - 1.17},
    "C_n at the KC of the fastest gaits, 7.3": {"drag_beating": 8 * 7.3 ** (-1 / 3) - 1.17},
    "C_n after Luhar and Nepf, 10 KC^(-1/3)": {"drag_beating": 10 * 9.5 ** (-1 / 3) - 1.17},
    "last link as the fin, one height": {"edge_aspect": 0.0},
    "half of the suction": {"edge_suction": 0.5},
    "all of the suction": {"edge_suction": 1.0},
    "plate of 57 by 89 mm, all of the suction": {
        "added_mass_normal": 0.697,
        "edge_height_m": 0.0574,
        "edge_aspect": 0.0,
        "edge_lift": 0.973,
        "edge_suction": 1.0,
        "drag_beating": 8 * 5.3 ** (-1 / 3) - 1.17,
    },
    "no shedding": {"tail_shedding": 0.0},
}
# An edge as high as the last link, steady drag, and the bandwidth of the lumped law: nothing is fitted here.
PLAIN = {
    "added_mass_normal": 1.0,
    "drag_beating": 0.0,
    "edge_height_m": 0.0,
    "edge_aspect": 0.0,
    "edge_lift": 1.0,
    "edge_suction": 1.0,
}
# Changes of the robot's file, and the model of the joints, for rows without a fit
UNFITTED: dict[str, tuple[Mapping[str, float], str]] = {
    "plain edge, no shedding, no form drag": (PLAIN | {"blunt_area_m2": 0.0, "tail_shedding": 0.0}, "bandwidth"),
    "plain edge, all of the suction, no form drag": (PLAIN | {"blunt_area_m2": 0.0}, "bandwidth"),
    "theory alone, no form drag, ideal joints": ({"blunt_area_m2": 0.0}, "ideal"),
    "theory alone, no form drag, 4.7 Hz": ({"blunt_area_m2": 0.0}, "bandwidth"),
    "the file: form drag fitted, 4.7 Hz": ({}, "bandwidth"),
}


@dataclass(frozen=True)
class Result:
    """A robot's results in the paper's tests."""

    blunt_area: float  # m^2
    bandwidth: float | None  # Hz; None for ideal joints
    speeds: tuple[float, ...]  # m/s
    costs: tuple[float, ...]  # changes by optimization [%]
    turns: dict[str, tuple[float, ...]]  # radii over phases [BL] by stroke; negative where it swims tail first


def with_strip(changes: Mapping[str, float], joints: str = "bandwidth") -> ht.Robot:
    """Return HyperTuna on strips with other coefficients: of the fin, of the head (blunt_area_m2), of the robot."""
    document = FISH.document()
    document["model"] |= {"water": "strip", "joints": joints}
    table: dict[str, Any] = document["water"]["strip"]
    for key, value in changes.items():
        if isinstance(table[key], list):
            column = list(table[key])
            column[0 if key == "blunt_area_m2" else FIN] = value
            table[key] = column
        else:
            table[key] = value
    return parse(document, file=FISH.file)


def fitted(robot: ht.Robot) -> ht.Robot:
    """Fit the form drag of the head and the bandwidth of the joints to the four unoptimized gaits."""
    runs = Trials(
        tuple(
            SteadyRun(name, named_gait(robot, name), speed=published_value(f"speed/{name}"), file="Table IV")
            for name in FOUR
        )
    )
    return identify(robot, runs, FREE, validate=0, starts=1).robot


def tested(robot: ht.Robot) -> Result:
    """Swim the eight gaits and the turns of section III.G, with the full stroke and with what the joints can make."""
    swims = {name: ht.swim(robot, named_gait(robot, name)) for name in SPEEDS}
    turn = named_gait(robot, "turning")
    half = tuple((group.bend_max or math.nan) / 2 for group in robot.joints)
    turns = {"full": turn, "feasible": replace(turn, amplitude=half, bias=half)}
    water, bandwidth = robot.water.strip, robot.joints[0].bandwidth
    assert water is not None
    return Result(
        water.blunt_area[0],
        bandwidth if robot.model.joints == "bandwidth" else None,
        tuple(swim.speed for swim in swims.values()),
        tuple(change(*(swims[f"{kind}optimised-{at}"].cost_of_transport for kind in ("un", ""))) for at in COSTS),
        {name: tuple(radii(robot, gait)) for name, gait in turns.items()},
    )


def radii(robot: ht.Robot, gait: ht.Gait) -> Iterator[float]:
    """Yield the turning radius over phases [BL], negative where the robot swims tail first."""
    for degrees in published()["turning"]["phase_deg"]:
        swim = ht.swim(robot, replace(gait, phase=(0.0, math.radians(degrees))))
        yield math.copysign(swim.turn_radius / robot.body.length, swim.speed) if swim.settled else math.nan


def on_twin(robot: ht.Robot) -> Result:
    """Run the eight gaits on the twin: seed 0."""
    options = [
        {"robot": robot, "gait": named_gait(robot, name), "duration": SWIM, "start": "swimming"} for name in SPEEDS
    ]
    runs = dict(zip(SPEEDS, twins(options, measure=lambda run: run, threads=1), strict=True))
    costs = tuple(change(*(runs[f"{kind}optimised-{at}"].cost_of_transport for kind in ("un", ""))) for at in COSTS)
    assert robot.water.strip is not None
    return Result(robot.water.strip.blunt_area[0], None, tuple(run.speed for run in runs.values()), costs, {})


def change(before: float, after: float) -> float:
    """Return a change in percent."""
    return 100 * (after / before - 1)


def rms(errors: Any) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(errors))))


def line(name: str, result: Result) -> str:
    """Return a row of the table of speeds and costs."""
    errors = 100 * (np.array(result.speeds) / TRUTH - 1)
    fit = f"{1e4 * result.blunt_area:.0f} | {'' if result.bandwidth is None else f'{result.bandwidth:.2f}'}"
    each = ", ".join(f"{error:+.0f}" for error in errors)
    costs = ", ".join(f"{cost:+.1f}" for cost in result.costs)
    return f"| {name} | {fit} | {each} | {rms(errors[:4]):.1f} | {rms(errors[4:]):.1f} | {rms(errors):.1f} | {costs} |"


def turn_line(name: str, radii: tuple[float, ...]) -> str:
    """Return a row of the table of turns: radius at the published phase, tightest of all, tightest head first."""
    phases = published()["turning"]["phase_deg"]
    at = radii[phases.index(published_value("turning/best-phase"))]
    size, ahead = np.abs(radii), np.where(np.array(radii) > 0, radii, np.inf)
    all_, first = int(np.nanargmin(size)), int(np.nanargmin(ahead))
    way = "ahead" if at > 0 else "tail first"
    tightest = f"{size[all_]:.2f} at {phases[all_]:g} | {ahead[first]:.2f} at {phases[first]:g}"
    return f"| {name} | {abs(at):.2f}, {way} | {tightest} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", type=Path)
    parser.add_argument("--twin", action="store_true")
    given = parser.parse_args()
    results = {f"{name}, nothing fitted here": tested(with_strip(*case)) for name, case in UNFITTED.items()}
    results |= {name: tested(fitted(with_strip(changes))) for name, changes in VARIANTS.items()}
    if given.twin:
        results["twin on strips"] = on_twin(with_strip({}))
    heads = ["strips", "C_D A [cm^2]", "lag [Hz]", "errors of the eight speeds [%]", "rms of four", "of the others"]
    print(f"| {' | '.join(heads)} | of eight | changes of cost [%] |")
    print("|---|---:|---:|---|---:|---:|---:|---|")
    for name, result in results.items():
        print(line(name, result))
    print("\n| turn | at 200 deg [BL] | tightest [BL, deg] | tightest head first [BL, deg] |\n|---|---|---|---|")
    for name in ("as in the file", "all of the suction", "no shedding"):
        for stroke, values in results[name].turns.items():
            print(turn_line(f"{name}, {stroke} stroke", values))
    if given.o:
        made = provenance(with_strip({})) | {"command": shlex.join(["python", *sys.argv])}
        record = made | {"gaits": SPEEDS, "results": {name: asdict(result) for name, result in results.items()}}
        given.o.write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
