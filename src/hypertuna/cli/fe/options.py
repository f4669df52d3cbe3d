"""The options that `hypertuna fe bend`, `fe compare` and `fe reduce` share, and how they are read."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from hypertuna.actuation.bending import MATERIAL_SETS, check_pressure
from hypertuna.cli.old_console import number
from hypertuna.cli.old_options import pressures
from hypertuna.fe.energies import LAWS
from hypertuna.fe.mesh import MESHES
from hypertuna.fe.model import FeOptions

__all__ = [
    "LAW",
    "MESH",
    "MIXED",
    "POISSON",
    "Law",
    "Material",
    "Mesh",
    "Mixed",
    "Poisson",
    "elements",
    "rising_pressures",
]

MOST_PRESSURES = 200  # of one call: each takes seconds at least
# What is taken where nothing is asked for.
LAW, POISSON, MIXED, MESH = FeOptions.law, f"{FeOptions.poisson:g}", FeOptions.mixed, str(FeOptions.mesh)

Material = Annotated[
    str | None, typer.Option("--material", help=f"Material set: {', '.join(MATERIAL_SETS)}. (default: the robot's)")
]
Law = Annotated[str, typer.Option("--law", help=f"Law of the elements' matrix: {', '.join(LAWS)}.")]
Poisson = Annotated[str, typer.Option("--poisson", help="Poisson's ratio of the matrix.")]
Mixed = Annotated[
    bool, typer.Option("--mixed/--no-mixed", help="Whether the matrix' pressure is an unknown of its own.")
]
Mesh = Annotated[str, typer.Option("--mesh", help=f"{', '.join(MESHES)}.")]


def elements(material: str | None, law: str, poisson: str, mesh: str, *, mixed: bool) -> FeOptions:
    """Read what a model of finite elements takes beyond the description."""
    return FeOptions(material, law, number(poisson, "--poisson", "figures, 0.475 say"), mesh, mixed)


def rising_pressures(text: str) -> NDArray[np.float64]:
    """Read the pressures that a joint is led through: `text` [kPa]; returns (n,) [Pa]."""
    return check_pressure(1e3 * np.array(pressures(text, MOST_PRESSURES)))
