"""Bend of a joint over nested spaces of displacements, with the grid convergence index: data/fe/nested.json.

python validation/fe/nested.py JOINT LEVELS [--pressure KPA]     one series, in the place of that of the same name

LEVELS is a list of ORDER:BISECTIONS, for example 4:0,4:1,4:2 or 4:0,5:0,6:0. The first level is the mesh `coarse`, with
elements curved to the fourth order. Finer levels have the same curved body: the straight tetrahedra are bisected, then
curved by the same polynomials; higher orders of displacements leave the curve as it is. So each space of displacements
holds the one before it, and each level starts from the state of the one before it. One core: half an hour a series.
Work that was interrupted goes on from the states in build/fe: remove them after a change of the code.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import time
from dataclasses import replace
from typing import Any

import numpy as np
from ledger import STORE as FOLDER
from ledger import WORK, rounded, stored

import hypertuna as ht
from hypertuna.description.provenance import provenance
from hypertuna.fe.bend import ngsolve_version
from hypertuna.fe.measure import measure
from hypertuna.fe.mesh import MESHES
from hypertuna.fe.model import FeModel, FeOptions, fe_model, model_on
from hypertuna.fe.newton import CLOSE, lead
from hypertuna.paper.chapters.finite_elements import ROBOT, joint_hash

STORE = FOLDER / "nested.json"
MESH = "coarse"  # mesh of the coarsest level
FIRST = 50e3  # Pa: first step on the way to the pressure of the study
SAFETY = 1.25  # safety factor of the grid convergence index, with three levels


def convergence(unknowns: list[int], values: list[float]) -> dict[str, float] | None:
    """Return observed order, limit and convergence index of the last three values; None where they do not converge.

    As Celik et al. 2008 for element sizes N^(-1/3): value = limit + c h^order, index = 1.25 |last - limit| / |last|.
    """
    h = [count ** (-1 / 3) for count in unknowns[-3:]]
    first, second = (b - a for a, b in zip(values[-3:], values[-2:], strict=False))
    if first * second <= 0:
        return None
    low, high = 1e-3, 50.0

    def excess(order: float) -> float:
        """Ratio of the two changes for an order, over that seen, less 1; rises with the order."""
        sizes = [size**order for size in h]
        return float((sizes[0] - sizes[1]) / (sizes[1] - sizes[2]) / (first / second) - 1)

    if excess(low) > 0 or excess(high) < 0:
        return None
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if excess(middle) > 0 else (middle, high)
    limit = values[-1] + second / ((h[1] / h[2]) ** low - 1)
    return {"order": low, "limit": limit, "index_percent": 100 * SAFETY * abs(limit / values[-1] - 1)}


def finer(base: FeModel, order: int, bisections: int) -> FeModel:
    """Return a model at rest of the same geometry: higher order of displacements, all tetrahedra bisected."""
    import ngsolve as ngs

    size = replace(base.options.size, order=order, curve=base.options.size.curvature)
    mesh = ngs.Mesh(base.mesh.ngmesh.Copy())
    mesh.ngmesh.SetGeometry(None)  # new points stay on the faces of the tetrahedra
    for _ in range(bisections):
        for element in mesh.Elements(ngs.VOL):
            mesh.SetRefinementFlag(element, True)
        mesh.Refine(onlyonce=True)
    base.mesh.UnsetDeformation()
    deformation = ngs.GridFunction(ngs.VectorH1(mesh, order=size.curvature))
    deformation.Set(base.deformation)
    base.mesh.SetDeformation(base.deformation)
    mesh.SetDeformation(deformation)
    return model_on(base.robot, base.body, replace(base.options, mesh=size), mesh, deformation)


def take_over(model: FeModel, last: FeModel) -> None:
    """Start a model from the loads and displacements of the coarser level."""
    for one in (model, last):
        one.mesh.UnsetDeformation()
    model.displacement.Set(last.displacement)
    if model.body.axis:
        for one, other in zip(model.problem.state.components[1:], last.problem.state.components[1:], strict=True):
            one.vec.data = other.vec
    for one in (model, last):
        one.mesh.SetDeformation(one.deformation)
    for load, value in zip(model.problem.loads, last.problem.loads, strict=True):
        load.Set(value.Get())


def solve(model: FeModel, pressure: float, *, warm: bool) -> tuple[int, str]:
    """Bring a model to a pressure [Pa]; return the number of Newton steps, and the failure, empty without one.

    A level that starts from a coarser one gains little energy: its steps end by the whole energy instead.
    """
    problem = model.problem
    if warm:
        least = CLOSE * abs(float(problem.energy.Energy(problem.state.vec)))
        found = [lead(problem, (pressure, 0.0, 0.0), least=least)]
    else:
        found = [lead(problem, (load, 0.0, 0.0)) for load in (FIRST, pressure)]
    return sum(one.iterations for one in found), "" if found[-1].converged else found[-1].text


def series(joint: str, levels: list[tuple[int, int]], pressure: float) -> list[dict[str, Any]]:
    """Bend a joint on all levels at a pressure [Pa]; states in build/fe, if any, are where levels start."""
    base = fe_model(ht.load(ROBOT), joint, FeOptions(mesh=MESHES[MESH]))
    model, rows = base, []
    for k, (order, bisections) in enumerate(levels):
        start, spent, steps = time.process_time(), 0.0, 0
        if k:
            last, model = model, finer(base, order, bisections)
            take_over(model, last)
        path = WORK / f"nested-{joint}-{order}-{bisections}-{pressure / 1e3:g}.npz"
        if path.exists():
            stored_state = np.load(path)
            np.asarray(model.problem.state.vec)[:] = stored_state["state"]
            model.problem.loads[0].Set(pressure)
            spent, steps = float(stored_state["seconds"]), int(stored_state["iterations"])
        iterations, text = solve(model, pressure, warm=k > 0 or path.exists())
        seconds, iterations = spent + time.process_time() - start, steps + iterations
        WORK.mkdir(parents=True, exist_ok=True)
        np.savez(path, state=np.asarray(model.problem.state.vec), seconds=seconds, iterations=iterations)
        measured = measure(model)
        row = {
            "order": order,
            "bisections": bisections,
            "elements": model.mesh.ne,
            "unknowns": model.unknowns,
            "bend_deg": math.degrees(measured.angle),
            "oil_left_ml": 1e6 * measured.volume[0],
            "energy_mj": 2e3 * float(model.problem.energy.Energy(model.problem.state.vec)),
            "iterations": iterations,
            "seconds": seconds,
            "memory_gb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9,
            "fault": text or measured.fault,
        }
        print(json.dumps(row), flush=True)
        if row["fault"]:
            break
        rows.append(row)
    return rows


def main() -> None:
    """Read the command line, compute, store."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("joint", choices=["I", "II"])
    parser.add_argument("levels")
    parser.add_argument("--pressure", type=float, default=150.0, help="kPa")
    asked = parser.parse_args()
    levels = [(int(order), int(times)) for order, times in (level.split(":") for level in asked.levels.split(","))]
    rows = series(asked.joint, levels, 1e3 * asked.pressure)
    record: dict[str, Any] = provenance(ht.load(ROBOT), water=False) | {
        "command": f"python validation/fe/nested.py {asked.joint} {asked.levels} --pressure {asked.pressure:g}",
        "ngsolve_version": ngsolve_version(),
        "joint_hash": joint_hash(ht.load(ROBOT), asked.joint),
        "pressure_kpa": asked.pressure,
        "levels": rows,
    }
    unknowns = [row["unknowns"] for row in rows]
    for key in ("bend_deg", "oil_left_ml"):
        found = convergence(unknowns, [row[key] for row in rows]) if len(rows) >= 3 else None
        record[f"convergence_{key}"] = found
    kept = json.loads(STORE.read_text()) if STORE.exists() else {}
    name = f"{asked.joint} {'h' if levels[-1][1] else 'p'}"
    stored(STORE, dict(sorted((kept | {name: record}).items())))
    print(json.dumps(rounded(record)))


if __name__ == "__main__":
    main()
