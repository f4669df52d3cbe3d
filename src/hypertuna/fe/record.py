"""Results of finite elements as records and tables with units in the names, for `--json` and files."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import drive_unit, joint_group
from hypertuna.description.provenance import provenance
from hypertuna.fe.bend import FeBend, ngsolve_version
from hypertuna.fe.measure import Measured

SUMMARY = "bend.json"  # file of the record in the folder of a run


def oil_taken(found: FeBend) -> NDArray[np.float64]:
    """Return the oil taken in since rest by the side with the pressure (n,) [m^3].

    It is the growth of the volume in the braids over the same mesh at rest: channels of a mesh are round to 1e-4 only.
    """
    group, actuator = joint_group(found.robot, found.joint)
    inside = math.pi * (drive_unit(found.robot).outer_diameter / 2) ** 2 * sum(actuator.segment_length)
    swelling = np.array([measured.swelling[SIDES.index(found.side)] for measured in found.measured])
    return (swelling - 1) * (group.drive_units or 0) * inside


def bend_record(found: FeBend) -> dict[str, Any]:
    """Return the JSON record of a bend."""
    options, straight = found.options, found.r_squared()
    facts = {
        "ngsolve_version": ngsolve_version(),
        "joint": found.joint,
        "side": found.side,
        "material": found.material,
        "law": options.law,
        "poisson": options.poisson,
        "mixed": options.mixed,
        "mesh": options.mesh if isinstance(options.mesh, str) else vars(options.mesh),
        "elements": found.elements,
        "unknowns": found.unknowns,
        "seconds": sum(found.seconds),
        "status": found.status,
        "status_text": found.status_text,
        "r_squared": None if math.isnan(straight) else straight,
    }
    columns = (found.pressure, found.angle, oil_taken(found), found.measured, found.iterations, found.seconds)
    steps = []
    for pressure, angle, oil, measured, iterations, seconds in zip(*columns, strict=True):
        step = {
            "pressure_kpa": float(pressure) / 1e3,
            "bend_deg": math.degrees(angle),
            "oil_taken_ml": 1e6 * float(oil),
        }
        steps.append(step | measured_record(measured) | {"iterations": iterations, "seconds": seconds})
    return provenance(found.robot, water=False) | facts | {"steps": steps}


def measured_record(found: Measured) -> dict[str, float]:
    """Return the JSON record of a state."""
    record = {f"tip_{axis}_mm": 1e3 * place for axis, place in zip("xy", found.tip, strict=True)}
    record |= {"length_mm": 1e3 * found.length}
    for side, volume, swelling in zip(("left", "right"), found.volume, found.swelling, strict=True):
        record |= {f"volume_{side}_ml": 1e6 * volume, f"swelling_{side}": swelling}
    for name in ("axial", "hoop", "fiber"):
        low, high = getattr(found, f"{name}_stretch")
        record |= {f"{name}_stretch_min": low, f"{name}_stretch_max": high}
    record |= {"fiber_stretch_99": found.fiber_99, "strain_max": found.strain_max, "strain_99": found.strain_99}
    record |= {"stress_max_kpa": found.stress_max / 1e3, "stress_99_kpa": found.stress_99 / 1e3}
    return record | {"jacobian_min": found.jacobian_min}


def bend_csv(found: FeBend, command: str) -> str:
    """Return a bend as CSV, a row per pressure, below comments with its provenance."""
    record = bend_record(found)
    steps = record.pop("steps")
    facts = {key: value for key, value in (record | {"command": command}).items() if value is not None}
    lines = [f"# {key}: {str(value).lower() if isinstance(value, bool) else value}" for key, value in facts.items()]
    if steps:
        lines.append(",".join(steps[0]))
    return "\n".join(lines + [",".join(str(value) for value in step.values()) for step in steps]) + "\n"
