"""Which other geometries bend as far as the shipped one, and what decides: validation/fe/family.json (some minutes).

By sections without ends (fe_section), of mean half axes, at a hundredth of the cost of the body. What ends take is
about the same share for geometries near each other, so they are compared with the shipped one by sections alone.

python validation/fe/family.py
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.description import Robot
from hypertuna.fe_model import FeOptions
from hypertuna.fe_section import section_bend
from hypertuna.soft_joint import drive_unit, muscle

FISH = ht.load("hypertuna-fe")
PRESSURE = np.array([100e3, 150e3, 200e3, 250e3])
# Outer and inner diameter [mm], braid [deg], levers of joint I and II [mm]: a section bends as far as the shipped one.
DESIGNS = (
    (5.0, 3.6, 34, 10.09, 6.3),
    (5.0, 3.8, 36, 12.0, 7.67),
    (4.5, 3.4, 34, 11.69, 6.99),
    (5.5, 3.6, 36, 10.66, 7.16),
)
LITTLE = 0.02
POISSON = (0.475, 0.49, 0.499)


def shipped() -> tuple[float, ...]:
    """The design of the description, in the units of `DESIGNS`."""
    unit = drive_unit(FISH)
    lengths = (unit.outer_diameter, unit.inner_diameter, *(group.actuator.lever for group in FISH.joints))
    outer, inner, *levers = (round(1e3 * length, 6) for length in lengths)
    return (outer, inner, round(math.degrees(unit.braid_angle), 6), *levers)


def changed(unit: dict[str, float], levers: tuple[float | None, float | None] = (None, None)) -> Robot:
    """The shipped fish with another drive unit and other levers [SI]."""
    groups = []
    for group, lever in zip(FISH.joints, levers, strict=True):
        actuator = group.actuator if lever is None else group.actuator.model_copy(update={"lever": lever})
        groups.append(group.model_copy(update={"actuator": actuator}))
    return FISH.model_copy(
        update={"drive_unit": drive_unit(FISH).model_copy(update=unit), "joints": tuple(groups)},
    )


def bent(fish: Robot, joint: str, poisson: float = FeOptions().poisson) -> tuple[float, float]:
    """Angle at 250 kPa [deg] and R^2 of a line over 100 to 250 kPa, by sections."""
    angle = section_bend(fish, joint, PRESSURE, options=FeOptions(poisson=poisson), segments=False).angle
    return math.degrees(angle[-1]), float(np.corrcoef(PRESSURE, angle)[0, 1] ** 2)


def family() -> list[dict[str, Any]]:
    """The designs, with what they differ in."""
    rows = []
    for outer, inner, braid, one, two in (shipped(), *DESIGNS):
        unit = {"outer_diameter": outer / 1e3, "inner_diameter": inner / 1e3, "braid_angle": math.radians(braid)}
        fish = changed(unit, (one / 1e3, two / 1e3))
        row = {"outer_mm": outer, "inner_mm": inner, "braid_deg": braid, "lever_i_mm": one, "lever_ii_mm": two}
        for joint, name in (("I", "i"), ("II", "ii")):
            row[f"bend_{name}_deg"], row[f"r_squared_{name}"] = bent(fish, joint)
        at_rest = muscle(fish, friction=False).at(np.ones(1), pressure=250e3)
        row["blocked_force_n"] = float(at_rest["pull"][0])
        rows.append(row)
        print(row, flush=True)
    return rows


def sensitivity() -> list[dict[str, Any]]:
    """Change of the bend at 250 kPa [%] where one quantity is 1 % more; of 2 % to both sides."""
    unit, rows = drive_unit(FISH), []
    names = {"outer_diameter": "outer diameter", "inner_diameter": "inner diameter", "braid_angle": "braid angle"}
    for key, name in names.items():
        fishes = [changed({key: getattr(unit, key) * (1 + sign * LITTLE)}) for sign in (-1, 1)]
        rows.append(_slope(name, fishes))
    levers = [group.actuator.lever for group in FISH.joints]
    rows.append(_slope("lever", [changed({}, tuple((1 + s * LITTLE) * w for w in levers)) for s in (-1, 1)]))
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
    told = {"sensitivity": sensitivity(), "poisson": compressed(), "family": family()}
    path = Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(told, indent=2) + "\n")
