"""The options that `hypertuna fe bend`, `fe compare` and `fe reduce` share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from hypertuna.actuation.bending import check_pressure
from hypertuna.actuation.soft_joint import MATERIAL_SETS
from hypertuna.cli.options import number, text
from hypertuna.errors import InputError
from hypertuna.fe.energies import LAWS
from hypertuna.fe.mesh import MESHES

MAX_PRESSURES = 200  # of one call: each takes seconds at least

Material = Annotated[
    str | None, text("--material", f"Material set: {', '.join(MATERIAL_SETS)}. (default: the robot's)")
]
Law = Annotated[str, text("--law", f"Law of the elements' matrix: {', '.join(LAWS)}.")]
Poisson = Annotated[float, number("--poisson", "figures, 0.475 say", "Poisson's ratio of the matrix.")]
Mixed = Annotated[bool, typer.Option("--mixed/--no-mixed", help="Make the pressure of the matrix an unknown.")]
Mesh = Annotated[Any, text("--mesh", f"{', '.join(MESHES)}.")]


def rising(pressures: Sequence[float]) -> NDArray[np.float64]:
    """Return the pressures that a joint is led through [Pa], from those of the option [kPa]."""
    if len(pressures) > MAX_PRESSURES:
        rule = f"must be at most {MAX_PRESSURES} pressures"
        raise InputError(rule, key="--pressure", value=f"{len(pressures)}", fix="ask for fewer")
    return check_pressure(1e3 * np.array(pressures))
