"""Which other geometries bend as far as the shipped one, and what decides: validation/fe/family.json (some minutes).

By sections without ends (fe_section), of mean half axes, at a hundredth of the cost of the body. What ends take is
about the same share for geometries near each other, so they are compared with the shipped one by sections alone.

python validation/fe/family.py
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

import hypertuna as ht
from hypertuna.actuation.soft_joint import drive_unit, muscle
from hypertuna.description.robot import Robot
from hypertuna.fe.model import FeOptions
from hypertuna.fe.section import section_bend

FISH = ht.load("hypertuna")
PRESSURE = np.array([100e3, 150e3, 200e3, 250e3])
UNITS = (  # other drive units: diameters [mm], braid [deg]
    (5.0, 3.6, 34),
    (5.0, 3.8, 36),
    (4.5, 3.4, 34),
    (5.5, 3.6, 36),
)
RANGE = (0.8, 1.3)  # of their levers over the shipped ones
CLOSE = 5e-6  # m, of a lever
LITTLE = 0.02
POISSON = (0.475, 0.49, 0.499)


def with_levers(fish: Robot, levers: Sequence[float | None]) -> Robot:
    """A fish with other levers [m], where they are not None."""
    groups = []
    for group, lever in zip(fish.joints, levers, strict=True):
        actuator = group.actuator if lever is None else group.actuator.model_copy(update={"lever": lever})
        groups.append(group.model_copy(update={"actuator": actuator}))
    return fish.model_copy(update={"joints": tuple(groups)})


def bent(fish: Robot, joint: str, poisson: float = FeOptions().poisson) -> tuple[float, float]:
    """Angle at 250 kPa [deg] and R^2 of a line over 100 to 250 kPa, by sections."""
    angle = section_bend(fish, joint, PRESSURE, options=FeOptions(poisson=poisson), segments=False).angle
    return math.degrees(angle[-1]), float(np.corrcoef(PRESSURE, angle)[0, 1] ** 2)


def lever(fish: Robot, joint: int, bend_deg: float) -> float:
    """Lever [m] at which a section of another drive unit bends so far at 250 kPa."""

    def over(lever: float) -> float:
        levers = tuple(lever if k == joint else None for k in range(2))
        return bent(with_levers(fish, levers), FISH.joints[joint].name)[0] - bend_deg

    low, high = (share * FISH.joints[joint].actuator.lever for share in RANGE)
    return float(brentq(over, low, high, xtol=CLOSE))


def family() -> list[dict[str, Any]]:
    """The shipped drive unit, and others with levers by which sections bend as far."""
    unit = drive_unit(FISH)
    rows = [told(FISH)]
    for outer, inner, braid in UNITS:
        sizes = {"outer_diameter": outer / 1e3, "inner_diameter": inner / 1e3, "braid_angle": math.radians(braid)}
        fish = FISH.model_copy(update={"drive_unit": unit.model_copy(update=sizes)})
        levers = tuple(lever(fish, joint, rows[0][f"bend_{name}_deg"]) for joint, name in enumerate(("i", "ii")))
        rows.append(told(with_levers(fish, levers)))
    return rows


def told(fish: Robot) -> dict[str, Any]:
    """What a design is, and how its sections bend."""
    unit = drive_unit(fish)
    row: dict[str, Any] = {"outer_mm": 1e3 * unit.outer_diameter, "inner_mm": 1e3 * unit.inner_diameter}
    row["braid_deg"] = math.degrees(unit.braid_angle)
    for group, name in zip(fish.joints, ("i", "ii"), strict=True):
        row[f"lever_{name}_mm"] = 1e3 * group.actuator.lever
        row[f"bend_{name}_deg"], row[f"r_squared_{name}"] = bent(fish, group.name)
    row["blocked_force_n"] = float(muscle(fish, friction=False).at(np.ones(1), pressure=250e3)["pull"][0])
    print(row, flush=True)
    return row


def sensitivity() -> list[dict[str, Any]]:
    """Change of the bend at 250 kPa [%] where one quantity is 1 % more; of 2 % to both sides."""
    unit, rows = drive_unit(FISH), []
    names = {"outer_diameter": "outer diameter", "inner_diameter": "inner diameter", "braid_angle": "braid angle"}
    for key, name in names.items():
        units = [unit.model_copy(update={key: getattr(unit, key) * (1 + sign * LITTLE)}) for sign in (-1, 1)]
        fishes = [FISH.model_copy(update={"drive_unit": other}) for other in units]
        rows.append(_slope(name, fishes))
    levers = [group.actuator.lever for group in FISH.joints]
    rows.append(_slope("lever", [with_levers(FISH, [(1 + s * LITTLE) * w for w in levers]) for s in (-1, 1)]))
    for material, name in ((unit.hose, "modulus of the hose"), (unit.matrix, "modulus of the matrix")):
        fishes = []
        for sign in (-1, 1):
            solid = FISH.materials[material]
            other = solid.model_copy(update={"modulus_fe": solid.modulus_fe * (1 + sign * LITTLE)})
            fishes.append(FISH.model_copy(update={"materials": {**FISH.materials, material: other}}))
        rows.append(_slope(name, fishes))
    return rows


def compressed() -> list[dict[str, Any]]:
    """Bends of the shipped design with silicone that keeps its volume better and better."""
    rows = []
    for poisson in POISSON:
        row: dict[str, Any] = {"poisson": poisson}
        for joint, name in (("I", "i"), ("II", "ii")):
            row[f"bend_{name}_deg"], row[f"r_squared_{name}"] = bent(FISH, joint, poisson)
        rows.append(row)
        print(row, flush=True)
    return rows


def _slope(name: str, fishes: list[Robot]) -> dict[str, Any]:
    row: dict[str, Any] = {"quantity": name}
    for joint, key in (("I", "i"), ("II", "ii")):
        low, high = (bent(fish, joint)[0] for fish in fishes)
        row[f"bend_{key}_percent"] = 100 * math.log(high / low) / (100 * math.log((1 + LITTLE) / (1 - LITTLE)))
    print(row, flush=True)
    return row


if __name__ == "__main__":
    found = {"sensitivity": sensitivity(), "poisson": compressed(), "family": family()}
    path = Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(found, indent=2) + "\n")
