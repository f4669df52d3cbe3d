"""Tables and picture of docs/turning.md; docs/figures.py includes them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from figures_common import rows
from matplotlib.figure import Figure
from scipy.optimize import brentq

from hypertuna.description.robot import Robot, load, parse
from hypertuna.errors import InputError
from hypertuna.paper.ledger import published
from hypertuna.swimming.gait import Gait, Gaits, named_gait
from hypertuna.swimming.plots_turn import plot_turn
from hypertuna.swimming.sweep import sweep
from hypertuna.swimming.swim import swim
from hypertuna.swimming.turn import Turning, point_radius, turn

FISH = load("hypertuna")
PAPER = published()
GAIT = named_gait(FISH, "turning")
PUBLISHED_RADIUS = PAPER["values"]["turning/radius-bl"]["value"]  # BL
PHASES = np.radians(PAPER["turning"]["phase_deg"])  # phases of the published turns [rad]
HEAD, FIN = 0, len(FISH.links.name) - 1  # indices of links
FACTORS = (1 / 8, 8.0)  # range of the factors tried to meet the published radius
# Quantity -> keys of its numbers in the robot's file.
KNOBS: dict[str, tuple[str, ...]] = {
    "drag across the head": (f"water.lumped.drag[{HEAD}]",),
    "friction of the head": (f"water.lumped.friction[{HEAD}]",),
    "added mass of the head": (f"water.lumped.added_mass[{HEAD}]",),
    "area of the caudal fin": (f"links.lateral_area_m2[{FIN}]", f"links.wetted_area_m2[{FIN}]"),
    "drag across the soft joints": tuple(f"water.lumped.drag[{i}]" for i in range(2, FIN)),
}


def beat(stroke: Sequence[float]) -> Gait:
    """Return the one-sided beat from straight to a stroke [rad]."""
    half = tuple(angle / 2 for angle in stroke)
    return replace(GAIT, amplitude=half, bias=half)


@cache
def around() -> Turning:
    """Turn with the paper's gait over the phases, at full and at half stroke."""
    half = tuple(angle / 2 for angle in GAIT.bias)
    phases = [(0.0, phase) for phase in PHASES]
    return turn(FISH, Gaits.grid(frequency=[2.0], amplitude=[GAIT.amplitude], phase=phases, bias=[GAIT.bias, half]))


def turn_cells(robot: Robot, gait: Gait) -> list[str]:
    """Return cells of a turn: radius of the nose and of the center of the head at 200 deg, and the tightest phase."""
    done, length = swim(robot, gait), robot.body.length
    grid = Gaits.grid(
        frequency=[gait.frequency], amplitude=[gait.amplitude], phase=[(0.0, p) for p in PHASES], bias=[gait.bias]
    )
    found = sweep(robot, grid).squeeze()
    radius = np.where(found.settled, found.turn_radius, np.inf) / length
    k = int(radius.argmin())
    center = point_radius(done, robot.links.com[HEAD]) / length
    if not done.settled:
        return [done.status, "", f"{math.degrees(PHASES[k]):.0f} ({radius[k]:.2f})"]
    return [f"{done.turn_radius / length:.2f}", f"{center:.2f}", f"{math.degrees(PHASES[k]):.0f} ({radius[k]:.2f})"]


def strokes() -> dict[str, Gait]:
    """Return one-sided beats by what limits their stroke."""
    bend = [group.bend_max or 0.0 for group in FISH.joints]
    limit = [group.amplitude_max or 0.0 for group in FISH.joints]
    return {
        "to the amplitude limit": beat(limit),
        "to the largest bend in air": beat(bend),
        "to twice the amplitude limit: the published gait as read here": beat([2 * a for a in limit]),
        "to twice the largest bend in air: full stroke of the soft joints": beat([2 * a for a in bend]),
    }


def stroke_table() -> str:
    """Tabulate the radius against the stroke."""
    body = []
    for name, gait in strokes().items():
        ends = ", ".join(f"{2 * math.degrees(a):.1f}" for a in gait.amplitude)
        body.append([name, ends, *turn_cells(FISH, gait)])
    head = ["one-sided beat", "stroke [deg]", "nose [BL]", "center of the head [BL]", "tightest phase [deg] (BL)"]
    return rows(head, body)


def law_table() -> str:
    """Tabulate turns by water law and stroke: at 200 deg, and the tightest of all and head first."""
    strip, feasible = FISH.using(water="strip"), "to the largest bend in air"
    cases = {
        "lumped": FISH,
        "strip": strip,
        "strip, all of the suction": parse_strip(strip, edge_suction=1.0),
        "strip, no shedding": parse_strip(strip, tail_shedding=0.0),
    }
    body = []
    for stroke, gait in {"full": GAIT, "feasible": strokes()[feasible]}.items():
        for name, robot in cases.items():
            swims = [swim(robot, replace(gait, phase=(0.0, phase))) for phase in PHASES]
            radius = [done.turn_radius / robot.body.length if done.settled else math.inf for done in swims]
            ahead = [r if done.speed > 0 else math.inf for r, done in zip(radius, swims, strict=True)]
            at, best, first = swim(robot, gait), int(np.argmin(radius)), int(np.argmin(ahead))
            way = "head first" if at.speed > 0 else "tail first"
            cells = [f"{at.turn_radius / robot.body.length:.2f}, {way}"]
            cells += [f"{r[k]:.2f} at {math.degrees(PHASES[k]):.0f}" for r, k in ((radius, best), (ahead, first))]
            body.append([stroke, name, *cells])
    return rows(["stroke", "law", "at 200 deg [BL]", "tightest [BL, deg]", "tightest head first"], body, 2)


def parse_strip(robot: Robot, **values: float) -> Robot:
    """Return the robot with other values in [water.strip]."""
    document = robot.document()
    document["water"]["strip"] |= values
    return parse(document, file=robot.file)


def knob_table() -> str:
    """Tabulate the radius with one quantity at a time halved and doubled, and the factor for the published radius."""
    body = []
    full = strokes()["to twice the largest bend in air: full stroke of the soft joints"]
    for name, keys in KNOBS.items():
        at = [radius(keys, factor, GAIT) for factor in (0.5, 1.0, 2.0)]
        cells = [f"{value:.3f}" for value in at]
        body.append([name, *cells, needed(keys, GAIT), needed(keys, full)])
    head = ["times", "½ [BL]", "1 [BL]", "2 [BL]", f"alone meets {PUBLISHED_RADIUS:g} BL", "with the full stroke"]
    return rows(head, body)


def radius(keys: Sequence[str], factor: float, gait: Gait) -> float:
    """Return the nose's turning radius with numbers multiplied [BL]."""
    factors: Mapping[str, float] = dict.fromkeys(keys, factor)
    done = swim(scaled(FISH, factors), gait)
    return done.turn_radius / FISH.body.length if done.settled else math.nan


def scaled(robot: Robot, factors: Mapping[str, float]) -> Robot:
    """Return the robot with some numbers of its file multiplied."""
    document = robot.document()
    for key, factor in factors.items():
        table, _, place = key.partition("[")
        *tables, name = table.split(".")
        part: Any = document
        try:
            for step in tables:
                part = part[step]
            index = int(place.removesuffix("]"))
            column = list(part[name])
            column[index] *= factor
        except (KeyError, IndexError, ValueError, TypeError):
            raise InputError("must be a number of a list of the robot's file", key=key, fix="see its tables") from None
        part[name] = column
    return parse(document, file=robot.file)


def needed(keys: Sequence[str], gait: Gait) -> str:
    """Return as text the factor nearest to 1 that gives the published radius, else the least radius found."""
    logs = np.linspace(*np.log(FACTORS), 25)
    values = np.array([radius(keys, math.exp(log), gait) for log in logs]) - PUBLISHED_RADIUS
    crossings = [k for k in range(len(logs) - 1) if values[k] * values[k + 1] < 0]
    if not crossings:
        k = int(np.nanargmin(values))
        return f"no: at least {values[k] + PUBLISHED_RADIUS:.2f}, at {math.exp(logs[k]):.2g}"
    k = min(crossings, key=lambda k: abs(logs[k]))
    log = brentq(lambda x: radius(keys, math.exp(x), gait) - PUBLISHED_RADIUS, logs[k], logs[k + 1], xtol=1e-3)
    return f"{math.exp(log):.2f}"


def model_table() -> str:
    """Tabulate the radius with other models, and at other frequencies."""
    cases: dict[str, tuple[Robot, Gait]] = {
        "lumped law, joint bandwidth": (FISH, GAIT),
        "lumped law, ideal joints": (FISH.using(joints="ideal"), GAIT),
        "lumped law, areas as printed": (FISH.using(areas="as-printed"), GAIT),
    }
    cases |= {f"at {f:g} Hz": (FISH, replace(GAIT, frequency=f)) for f in (0.5, 1.0, 4.0)}
    body = [[name, *turn_cells(robot, gait)] for name, (robot, gait) in cases.items()]
    return rows(["model", "nose [BL]", "center of the head [BL]", "tightest phase [deg] (BL)"], body)


TABLES: dict[str, Callable[[], str]] = {
    "turning strokes": stroke_table,
    "turning knobs": knob_table,
    "turning models": model_table,
    "turning laws": law_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {
    "docs/turning.svg": lambda: plot_turn(
        around(), published=(PAPER["values"]["turning/best-phase"]["value"], float(PUBLISHED_RADIUS))
    )
}
