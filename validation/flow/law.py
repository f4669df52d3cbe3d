"""What the strip law of HyperTuna makes of this folder's coefficients, nothing fitted.

    python validation/flow/law.py [-o FILE]

Keulegan-Carpenter numbers of the tail's links in the settled beats of Table IV's gaits, and the errors of the eight
speeds with coefficients of the flow solver and the lattice, and with drag of the head from handbooks (seconds).
"""

import argparse
import json
import math
import runpy
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import parse
from hypertuna.paper.computed import SPEEDS
from hypertuna.paper.ledger import published_value
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.trajectory import body_of, body_points

HERE = Path(__file__).parent
FISH = ht.load("hypertuna")
TRUTH = np.array([published_value(f"speed/{name}") for name in SPEEDS])
HEAD = math.pi / 4 * 0.1201 * 0.0833  # m^2, section of the head: height and width in the robot's file
# Form drag of the head on its section, for HEADS. Streamlined: form is in the friction, as Hoerner's factor. Square
# end: Hoerner's base drag 0.029/sqrt(C_f S/A) = 0.10 for the head's friction, C_f S/A = 0.084. Blunt cylinder, length
# over diameter 2 to 7: 0.85 to 0.99 (Aeronautical Engineer's Data Book). The base drag and the 0.2 of a cylinder with a
# round nose are quoted from memory of Hoerner (1965).
BEATING = 10 * 9.5 ** (-1 / 3) - 1.17  # of the fin, where the robot's file has 8 KC^(-1/3), less steady flow's
HEADS = {"streamlined": 0.0, "square end": 0.10, "cylinder, round nose": 0.20, "cylinder, blunt": 0.87}


def strip(joints: str = "bandwidth", **changes: Any) -> ht.Robot:
    """Return HyperTuna on strips with other coefficients."""
    document = FISH.document()
    document["model"] |= {"water": "strip", "joints": joints}
    document["water"]["strip"] |= changes
    return parse(document, file=FISH.file)


def travel(robot: ht.Robot, gait: str) -> np.ndarray:
    """Return the links' Keulegan-Carpenter numbers (2, links), at their middles: with the head held, and swimming."""
    motion = ht.swim(robot, named_gait(robot, gait)).trajectory
    time, joints = motion["time"].values, motion["joint_angle"].values
    height = np.array(robot.links.lateral_area) / robot.links.length
    result = []
    for heading, body in (
        (0 * motion["heading"].values, body_points(robot, np.zeros((len(time), 3)), joints)),
        (motion["heading"].values, body_of(robot, motion)),
    ):
        middle = (body[:, 1:] + body[:, :-1]) / 2
        along = np.exp(1j * (heading[:, None] + np.cumsum(joints, axis=1)))
        across = (np.gradient(middle, time, axis=0)[1:-1] * np.conj(along[1:-1])).imag
        result.append(np.abs(across).max(axis=0) * (time[-1] - time[0]) / height)
    return np.array(result)


def computed() -> tuple[np.ndarray, np.ndarray]:
    """Return KC (n,), and C_n and C_m (n, 2), of the ellipse 0.61 on the finest meshes of table.py."""
    rows = [row for row in runpy.run_path(str(HERE / "table.py"))["finest"]() if row["section"] == "0.61"]
    return np.array([row["kc"] for row in rows]), np.array(
        [(row["drag_normal"], row["added_mass_normal"]) for row in rows]
    )


def errors(robot: ht.Robot) -> list[float]:
    """Return the errors of the eight speeds [%]."""
    speeds = np.array([ht.swim(robot, named_gait(robot, name)).speed for name in SPEEDS])
    return [round(float(each), 2) for each in 100 * (speeds / TRUTH - 1)]


def column(values: Any, place: slice, new: Any) -> list[float]:
    """Return a column of the strip law with other values at some links."""
    result = np.array(values, dtype=float)
    result[place] = new
    return [float(each) for each in result]


def variants(travels: np.ndarray) -> dict[str, Mapping[str, Any]]:
    """Return changes of the robot's file by name of the variant, for travels (gaits, links) while swimming."""
    law = FISH.water.strip
    assert law is not None
    kc, found = computed()
    tail = slice(1, -1)
    drag = np.interp(travels[:, tail].mean(axis=0), kc, found[:, 0])
    mass = np.interp(travels[:, tail].mean(axis=0), kc, found[:, 1])
    heads = {name: column(law.blunt_area, slice(0, 1), value * HEAD) for name, value in HEADS.items()}
    result: dict[str, Mapping[str, Any]] = {
        "as in the file": {},
        "C_n of the tail from the flow solver": {"drag_normal": column(law.drag_normal, tail, drag)},
        "C_n and C_m of the tail from it": {
            "drag_normal": column(law.drag_normal, tail, drag),
            "added_mass_normal": column(law.added_mass_normal, tail, mass),
        },
        "C_n of the fin after Luhar and Nepf": {"drag_beating": column(law.drag_beating, slice(-1, None), BEATING)},
        "edge_lift 0.42, small motions of the lattice": {"edge_lift": 0.42},
        "edge_lift 0.89, whole motion, free wake of the lattice": {"edge_lift": 0.89},
    }
    result |= {f"head: {name}, C_D = {HEADS[name]:g}": {"blunt_area_m2": area} for name, area in heads.items()}
    return result | {
        f"head: {name}, edge_lift 0.42": {"blunt_area_m2": heads[name], "edge_lift": 0.42}
        for name in ("cylinder, round nose", "cylinder, blunt")
    }


def main() -> None:
    """Compute, print and store."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", type=Path)
    given = parser.parse_args()
    robot = strip()
    travels = np.array([travel(robot, name) for name in SPEEDS])
    speeds = {
        name: {joints: errors(strip(joints, **changes)) for joints in ("bandwidth", "ideal")}
        for name, changes in variants(travels[:, 1]).items()
    }
    record = provenance(robot) | {"command": shlex.join(["python", *sys.argv])}
    record |= {
        "gaits": list(SPEEDS),
        "links": list(robot.links.name),
        "kc": travels.round(2).tolist(),
        "errors": speeds,
    }
    for name, found in speeds.items():
        print(name, {joints: round(float(np.sqrt(np.mean(np.square(each)))), 1) for joints, each in found.items()})
    print(travels.min(axis=0).round(2), travels.max(axis=0).round(2), sep="\n")
    if given.o:
        given.o.write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
