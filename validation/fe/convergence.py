"""Bend at 250 kPa over the mesh, and the paper's numbers of elements: rows of validation/fe/convergence.json.

python validation/fe/convergence.py JOINT MESH     one row, added to the file

MESH is coarse, medium, fine, paper, or one of the first three without the mixed form: "fine displacement".

The shipped description by third-order elements; "paper" takes second-order elements and a mesh of about as many
tetrahedra as the paper's (section III.B: 37,648 for joint I, 10,965 for joint II), of the half body; the mixed form
asks for the third order, so that it goes without. "medium" is what validation/fe/ledger.py stored.
"""

from __future__ import annotations

import json
import math
import resource
import sys
from pathlib import Path

import hypertuna as ht
from hypertuna.fe.bend import fe_bend
from hypertuna.fe.mesh import MeshSize
from hypertuna.fe.model import FeOptions

PAPER = {
    "I": MeshSize(0.27, largest=1.75, grading=0.32, order=2, pieces=29.0),
    "II": MeshSize(0.325, largest=2.6, grading=0.55, order=2, pieces=19.0),
}
ROBOT = "hypertuna"
ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "fe" / "convergence"
PRESSURE = (50e3, 100e3, 150e3, 200e3, 250e3)


def stored(joint: str) -> dict[str, object]:
    """Take the row of the shipped mesh from data/fe."""
    record = json.loads((ROOT / "data" / "fe" / f"{ROBOT}-{joint}.json").read_text())
    steps = [step for step in record["steps"] if step["pressure_kpa"] > 0]
    same = {key: record[key] for key in ("joint", "mesh", "elements", "unknowns", "r_squared", "memory_gb")}
    columns = {key: [step[key] for step in steps] for key in ("bend_deg", "pressure_kpa", "iterations")}
    cost = sum(step["seconds"] for step in steps)
    return {"robot": ROBOT, **same, **columns, "seconds": cost, "status": record["status_text"]}


def row(joint: str, mesh: str) -> dict[str, object]:
    """Bend the joint on one mesh."""
    size, _, form = mesh.partition(" ")
    options = FeOptions(mesh=PAPER[joint] if size == "paper" else size, mixed=not form and size != "paper")
    folder = WORK / f"{joint}-{mesh}".replace(" ", "-")  # goes on after an end
    folder.mkdir(parents=True, exist_ok=True)
    found = fe_bend(ht.load(ROBOT), joint, PRESSURE, options=options, folder=folder)
    return {
        "robot": ROBOT,
        "joint": joint,
        "mesh": mesh,
        "elements": found.elements,
        "unknowns": found.unknowns,
        "bend_deg": [math.degrees(angle) for angle in found.angle],
        "pressure_kpa": [pressure / 1e3 for pressure in found.pressure],
        "r_squared": found.r_squared(),
        "iterations": list(found.iterations),
        "seconds": sum(found.seconds),
        "memory_gb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9,
        "status": found.status_text,
    }


if __name__ == "__main__":
    import ngsolve

    ngsolve.SetNumThreads(1)
    path = Path(__file__).with_suffix(".json")
    new = stored(sys.argv[1]) if sys.argv[2] == "medium" else row(sys.argv[1], sys.argv[2])
    rows = json.loads(path.read_text()) if path.exists() else []  # now: other rows may have come while this one ran
    rows = [kept for kept in rows if (kept["joint"], kept["mesh"]) != (new["joint"], new["mesh"])] + [new]
    path.write_text(json.dumps(sorted(rows, key=lambda kept: (kept["joint"], kept["elements"])), indent=2) + "\n")
    print(new)
