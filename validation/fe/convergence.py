"""Bend over order and mesh, local volume, and the paper's numbers of elements: rows of validation/fe/convergence.json.

python validation/fe/convergence.py JOINT MESH [--order N] [--poisson NU] [--to KPA]     one row, added to the file

MESH is coarse, medium, fine or paper; "paper" takes displacements of the second order on about as many tetrahedra as
the paper's (section III.B: 37,648 for joint I, 10,965 for joint II), of the half body. Elements are curved to the
order of their displacements: displacements of a lower order than the elements' could not rotate, and would lock (joint
II at 50 kPa, order 3 on elements of order 4: 7.9 deg instead of 13.5).
"""

from __future__ import annotations

import argparse
import json
import math
import resource
from dataclasses import replace
from pathlib import Path
from typing import Any

from volume import volume_kept

import hypertuna as ht
from hypertuna.fe.bend import fe_bend
from hypertuna.fe.mesh import MESHES, MeshSize, mesh_size
from hypertuna.fe.model import FeOptions

PAPER = {  # meshes with the paper's numbers of elements
    "I": MeshSize(0.27, largest=1.75, grading=0.32, order=2, pieces=29.0),
    "II": MeshSize(0.325, largest=2.6, grading=0.55, order=2, pieces=19.0),
}
ROBOT = "hypertuna"
STORE = Path(__file__).with_suffix(".json")
PRESSURE = (50e3, 100e3, 250e3)  # Pa, of stored bends
KEYS = ("joint", "mesh", "order", "poisson")  # by which a row is known


def row(joint: str, mesh: str, order: int | None = None, poisson: float = 0.475, to: float = 250.0) -> dict[str, Any]:
    """Bend a joint on one mesh, up to a pressure [kPa]."""
    size = PAPER[joint] if mesh == "paper" else mesh_size(mesh)
    size = replace(size, order=order or size.order)
    volumes: list[dict[str, Any]] = []
    found = fe_bend(
        ht.load(ROBOT),
        joint,
        [pressure for pressure in PRESSURE if pressure <= 1e3 * to],
        options=FeOptions(mesh=size, poisson=poisson),
        each=lambda model, _k, _measured: volumes.append(volume_kept(model)),
    )
    return {
        "robot": ROBOT,
        "joint": joint,
        "mesh": mesh,
        "order": size.order,
        "poisson": poisson,
        "elements": found.elements,
        "unknowns": found.unknowns,
        "pressure_kpa": [pressure / 1e3 for pressure in found.pressure],
        "bend_deg": [math.degrees(angle) for angle in found.angle],
        "volume_ratio": volumes,
        "iterations": list(found.iterations),
        "seconds": sum(found.seconds),
        "memory_gb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9,
        "status": found.status_text,
    }


def store(new: dict[str, Any]) -> None:
    """Store a row; it replaces one of the same joint, mesh, order and Poisson's ratio."""
    rows = json.loads(STORE.read_text()) if STORE.exists() else []  # now: other rows may have come meanwhile
    rows = [kept for kept in rows if [kept[key] for key in KEYS] != [new[key] for key in KEYS]] + [new]
    rows.sort(key=lambda kept: (kept["joint"], kept["poisson"], kept["elements"], kept["order"]))
    STORE.write_text(json.dumps(rows, indent=1) + "\n")
    print(json.dumps(new), flush=True)


def main() -> None:
    """Read the command line, compute, store."""
    import ngsolve

    ngsolve.SetNumThreads(1)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("joint", choices=list(PAPER))
    parser.add_argument("mesh", choices=[*MESHES, "paper"])
    parser.add_argument("--order", type=int)
    parser.add_argument("--poisson", type=float, default=0.475)
    parser.add_argument("--to", type=float, default=250.0, help="highest pressure, kPa")
    asked = parser.parse_args()
    store(row(asked.joint, asked.mesh, asked.order, asked.poisson, asked.to))


if __name__ == "__main__":
    main()
