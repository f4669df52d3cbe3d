"""Options of the commands that use finite elements."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from hypertuna.actuation.bending import check_pressure
from hypertuna.actuation.soft_joint import MATERIAL_SETS
from hypertuna.arrays import Array
from hypertuna.cli import options as opt
from hypertuna.errors import InputError
from hypertuna.fe.energies import LAWS
from hypertuna.fe.mesh import MESHES
from hypertuna.fe.model import FeOptions

BEND_PRESSURES: Any = "0:250:6"  # default of --pressure [kPa], as typed
MAX_PRESSURES = 200  # of one call: finite elements take seconds or more for each


@dataclass(frozen=True)
class Elements(FeOptions):
    """Options of a joint's finite elements, with the defaults of `FeOptions`."""

    material: Annotated[
        str | None, opt.text("--material", f"Material set: {', '.join(MATERIAL_SETS)}. (default: the robot's)")
    ] = FeOptions.material
    law: Annotated[str, opt.text("--law", f"Law of the elements' matrix: {', '.join(LAWS)}.")] = FeOptions.law
    poisson: Annotated[float, opt.number("--poisson", "figures, 0.475 say", "Poisson's ratio of the matrix.")] = (
        FeOptions.poisson
    )
    mesh: Annotated[Any, opt.text("--mesh", f"{', '.join(MESHES)}.")] = FeOptions.mesh


@dataclass(frozen=True)
class CoarseElements(Elements):
    """Elements of commands that solve a joint many times."""

    mesh: Annotated[Any, opt.text("--mesh", f"{', '.join(MESHES)}.")] = "coarse"


def rising(pressures: Sequence[float]) -> Array:
    """Return the pressures of --pressure [kPa] in Pa, after checks of their number and order."""
    if len(pressures) > MAX_PRESSURES:
        rule = f"must be at most {MAX_PRESSURES} pressures"
        raise InputError(rule, key="--pressure", value=f"{len(pressures)}", fix="ask for fewer")
    return check_pressure(1e3 * np.array(pressures))
