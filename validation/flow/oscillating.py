"""Drag and added mass of sections that heave in still water: rows of validation/flow/oscillating.json.

python validation/flow/oscillating.py SECTION KC [--mesh coarse|medium|fine] [--edge H] [--step DT] [--reynolds RE]
                                                     [--cycles N] [--half]

SECTION is "plate", or the ratio b/a of the axes of an ellipse that moves along its minor axis, such as 0.61. The
two-dimensional Navier-Stokes equations by finite elements (NGSolve), in the frame of the body, which moves at
V(t) = sin(2 pi t / T):

    w' + (w - V) . grad w = -grad p + lap w / Re,   div w = 0,   w = V on the body and 0 far away

Units are the body's height, its largest speed and the density of water, so that the Keulegan-Carpenter number is T.
Taylor-Hood elements of orders 2 and 1; third-order backward differences with explicit convection, which unlike those
of second order are stable without viscosity, for twice the step. The force is the residual of the momentum equation at
the body; least squares over the cycles after the first two give C_n and C_m:

    F = -1/2 C_n V |V| - C_m pi/4 V'
"""

import argparse
import json
import math
import resource
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

FILE = Path(__file__).with_name("oscillating.json")
RADIUS = 15.0  # of the region of water, over the section's height
THICKNESS = 0.05  # of the plate
MESHES = {"coarse": 0.20, "medium": 0.14, "fine": 0.10}  # size of elements in the wake
EDGE, EDGE_MAX, STEP = 0.0125, 0.05, 0.044  # size of elements at edges over KC, and at most; time step over that size
WAKE = 1.5  # the wake's mesh, beyond the travel of the body
DISCARDED = 2  # cycles after the start from rest


class Flow(NamedTuple):
    """Force on a heaving section over time."""

    time: np.ndarray
    force: np.ndarray
    unknowns: int


def speed(time: Any, kc: float) -> Any:
    """Return the speed of the section."""
    return np.sin(2 * np.pi * time / kc)


def water(section: str, mesh: str, kc: float, *, edge: float = EDGE_MAX, half: bool = False) -> Any:
    """Mesh the water around a section, or half of it: fine at the section's edges, coarser in its wake."""
    import ngsolve as ng
    from netgen import occ

    if section == "plate":
        body = occ.Rectangle(THICKNESS, 1.0).Face().Move((-THICKNESS / 2, -0.5, 0))
    else:
        axes = occ.Axes((0, 0, 0), n=occ.Z, h=occ.Y)
        body = occ.WorkPlane(axes).Ellipse(0.5, 0.5 * float(section)).Face()
    body.edges.name = "body"
    body.edges.maxh = 2 * edge
    body.vertices.maxh = edge
    length, height = WAKE + kc / (2 * math.pi), 0.5 + WAKE
    wake = occ.Rectangle(2 * length, 2 * height).Face().Move((-length, -height, 0))
    far = occ.Circle((0, 0), RADIUS).Face()
    far.edges.name = "far"
    around, wake = far - wake, wake - body
    if half:
        above = occ.Rectangle(2 * RADIUS, RADIUS).Face().Move((-RADIUS, 0, 0))
        above.edges.Min(occ.Y).name = "axis"
        around, wake = around * above, wake * above
    wake.faces.maxh = MESHES[mesh]
    shape = occ.OCCGeometry(occ.Glue([around, wake]), dim=2)
    return ng.Mesh(shape.GenerateMesh(maxh=2.5, grading=0.3)).Curve(2)


def flow(
    section: str, kc: float, *, mesh: str, edge: float, step: float, reynolds: float, cycles: int, half: bool = False
) -> Flow:
    """Return the force on a section that heaves from rest."""
    import ngsolve as ng

    domain, count = water(section, mesh, kc, edge=edge, half=half), math.ceil(cycles * kc / step)
    step = cycles * kc / count
    fixed = {"dirichletx": "body|far", "dirichlety": "body|far|axis"}
    space = ng.VectorH1(domain, order=2, **fixed) * ng.H1(domain, order=1)
    (w, p), (v, q) = space.TnT()
    now, last, before, first, along = (ng.GridFunction(space) for _ in range(5))
    along.components[0].Set(ng.CF((1, 0)), definedon=domain.Boundaries("body"))
    moving = ng.Parameter(0.0)
    stress = ng.InnerProduct(ng.Grad(w), ng.Grad(v)) / reynolds - ng.div(v) * p - ng.div(w) * q - 1e-10 * p * q
    inertia = ng.InnerProduct(w, v)
    mass = ng.BilinearForm(inertia * ng.dx, symmetric=True).Assemble().mat
    stokes = ng.BilinearForm((11 / 6 / step * inertia + stress) * ng.dx, symmetric=True).Assemble().mat
    solve = stokes.Inverse(space.FreeDofs(), inverse="sparsecholesky")
    convection = ng.BilinearForm(space, nonassemble=True)
    convection += ng.InnerProduct(ng.Grad(w) * (w - ng.CF((moving, 0))) + ng.div(w) / 2 * w, v) * ng.dx
    known, carried, carried_last, carried_first = (now.vec.CreateVector() for _ in range(4))
    carried_last[:] = carried_first[:] = 0
    times, forces = step * np.arange(1, count + 1), []
    for time in times:
        moving.Set(speed(time - step, kc))
        convection.Apply(last.vec, carried)
        known.data = mass * (3 / step * last.vec - 1.5 / step * before.vec + 1 / 3 / step * first.vec)
        known.data -= 3 * carried - 3 * carried_last + carried_first
        now.vec.data = speed(time, kc) * along.vec
        now.vec.data += solve * (known - stokes * now.vec)
        known.data -= stokes * now.vec
        forces.append((2 if half else 1) * ng.InnerProduct(known, along.vec))
        if not math.isfinite(forces[-1]):
            sys.exit("the flow diverged: choose a smaller --step or a finer --mesh")
        first.vec.data, before.vec.data, last.vec.data = before.vec, last.vec, now.vec
        carried_first.data, carried_last.data = carried_last, carried
    return Flow(times, np.array(forces), space.ndof)


def coefficients(result: Flow, kc: float, cycles: range) -> tuple[float, float, float]:
    """Fit C_n and C_m over some cycles; return them and the part of the force's variance that they explain."""
    chosen = (result.time > cycles.start * kc) & (result.time <= cycles.stop * kc)
    time, force = result.time[chosen], result.force[chosen]
    v, acceleration = speed(time, kc), 2 * np.pi / kc * np.cos(2 * np.pi * time / kc)
    columns = np.stack([-0.5 * v * np.abs(v), -np.pi / 4 * acceleration], axis=1)
    (drag, mass), *_ = np.linalg.lstsq(columns, force, rcond=None)
    rest = force - columns @ (drag, mass)
    return float(drag), float(mass), float(1 - rest @ rest / (force @ force))


def row(section: str, kc: float, **choices: Any) -> dict[str, Any]:
    """Compute a row of the table."""
    import ngsolve as ng

    ng.SetNumThreads(1)
    result, count = flow(section, kc, **choices), choices["cycles"]
    drag, mass, explained = coefficients(result, kc, range(DISCARDED, count))
    single = [coefficients(result, kc, range(k, k + 1)) for k in range(DISCARDED, count)]
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return {
        "section": section,
        "kc": kc,
        **choices,
        "unknowns": result.unknowns,
        "drag_normal": round(drag, 4),
        "added_mass_normal": round(mass, 4),
        "explained": round(explained, 4),
        "drag_by_cycle": [round(each[0], 3) for each in single],
        "added_mass_by_cycle": [round(each[1], 3) for each in single],
        "cpu_s": round(usage.ru_utime + usage.ru_stime),
        "ngsolve": ng.__version__,
    }


def main() -> None:
    """Compute a row, and store it; it replaces one of the same choices."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("section")
    parser.add_argument("kc", type=float)
    parser.add_argument("--mesh", choices=list(MESHES), default="medium")
    parser.add_argument("--edge", type=float, help="elements at the edges")
    parser.add_argument("--step", type=float, help="by default as long as is stable with the elements at the edges")
    parser.add_argument("--reynolds", type=float, default=1000.0)
    parser.add_argument("--cycles", type=int, default=5)
    parser.add_argument("--half", action="store_true", help="only the water above the axis: the flow stays symmetric")
    asked = vars(parser.parse_args())
    asked["edge"] = asked["edge"] or min(EDGE_MAX, EDGE * asked["kc"])
    asked["step"] = asked["step"] or STEP * asked["edge"]
    new = row(asked.pop("section"), asked.pop("kc"), **asked)
    key = ("section", "kc", "mesh", "edge", "step", "reynolds", "cycles", "half")
    rows = json.loads(FILE.read_text()) if FILE.exists() else []
    rows = [each for each in rows if any(each.get(name, False) != new[name] for name in key)] + [new]
    rows.sort(key=lambda each: [str(each["section"]), *(str(each.get(name, False)) for name in key[2:]), each["kc"]])
    FILE.write_text("[\n" + ",\n".join(json.dumps(each) for each in rows) + "\n]\n")
    print(json.dumps(new, indent=2))


if __name__ == "__main__":
    main()
