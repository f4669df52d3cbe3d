"""What a bend by finite elements tells, as records and tables with units in their names: for programs and files."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuator import SIDES
from hypertuna.fe_bend import FeBend, ngsolve_version
from hypertuna.results import provenance
from hypertuna.soft_joint import drive_unit, joint_group

__all__ = ["SUMMARY", "bend_csv", "bend_record", "oil_taken"]

Array = NDArray[np.float64]

SUMMARY = "bend.json"  # file of the record, in the folder of a run

KILO, MILLI, MILLILITER = 1e3, 1e-3, 1e-6
PAIRS = ("axial_stretch", "hoop_stretch", "fiber_stretch")


def oil_taken(found: FeBend) -> Array:
    """Compute what oil the side with the pressure has taken in since rest.

    Parameters
    ----------
    found : FeBend

    Returns
    -------
    ndarray, shape (n,)
        [m^3].
    """
    group, actuator = joint_group(found.robot, found.joint)
    lumen = math.pi * (drive_unit(found.robot).inner_diameter / 2) ** 2 * sum(actuator.segment_length)
    return found.volume - (group.drive_units or 0) * lumen


def bend_record(found: FeBend) -> dict[str, Any]:
    """Tell a bend.

    Parameters
    ----------
    found : FeBend

    Returns
    -------
    dict
        Of numbers, texts and a list of dictionaries, ``"steps"``: one for each pressure that was reached.
    """
    options = found.options
    record: dict[str, Any] = provenance(found.robot) | {
        "ngsolve_version": ngsolve_version(),
        "joint": found.joint,
        "side": found.side,
        "material": found.material,
        "law": options.law,
        "poisson": options.poisson,
        "mixed": options.mixed,
        "mesh": options.mesh if isinstance(options.mesh, str) else "own",
        "elements": found.elements,
        "unknowns": found.unknowns,
        "seconds": sum(found.seconds),
        "r_squared": found.r_squared(),
        "status": found.status,
        "status_text": found.status_text,
    }
    return record | {"steps": [_step(found, k) for k in range(len(found.pressure))]}


def bend_csv(found: FeBend, command: str) -> str:
    """Write a bend as comma-separated values, a row per pressure, below comments that say what made them.

    Parameters
    ----------
    found : FeBend
    command : str

    Returns
    -------
    str
    """
    record = bend_record(found)
    steps = record.pop("steps")
    lines = [f"# {key}: {value}" for key, value in (record | {"command": command}).items()]
    if steps:
        lines.append(",".join(steps[0]))
    return "\n".join(lines + [",".join(str(value) for value in step.values()) for step in steps]) + "\n"


def _step(found: FeBend, k: int) -> dict[str, float]:
    """Tell one pressure."""
    measured = found.measured[k]
    step: dict[str, float] = {
        "pressure_kpa": float(found.pressure[k]) / KILO,
        "bend_deg": math.degrees(found.angle[k]),
        "tip_x_mm": measured.tip[0] / MILLI,
        "tip_y_mm": measured.tip[1] / MILLI,
        "oil_taken_ml": float(oil_taken(found)[k]) / MILLILITER,
    }
    for side, volume, swelling in zip(SIDES, measured.volume, measured.swelling, strict=True):
        step |= {f"volume_{side}_ml": volume / MILLILITER, f"swelling_{side}": swelling}
    for name in PAIRS:
        step |= {f"{name}_{end}": value for end, value in zip(("min", "max"), getattr(measured, name), strict=True)}
    step |= {"strain_max": measured.strain_max, "strain_99": measured.strain_99}
    step |= {"stress_max_kpa": measured.stress_max / KILO, "stress_99_kpa": measured.stress_99 / KILO}
    step |= {"jacobian_min": measured.jacobian_min}
    return step | {"newton_steps": found.iterations[k], "seconds": found.seconds[k]}
