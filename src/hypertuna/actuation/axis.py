"""Members that hold the axis of a soft joint: tensile stiffness and buckling load of a film or a pipe in silicone.

A member in silicone that is compressed along its axis buckles in waves. Its bending stiffness E I resists short waves,
and the silicone resists long waves: at the wave number q a load P = E I q^2 + k(q) / q^2 keeps it bent. The smallest of
these loads is the buckling load, 2 sqrt(k E I) if k does not change with q. The stiffness k of the silicone, force per
length and deflection, is that of an unbounded incompressible solid of shear modulus G, from Kelvin's solution for a
point force, which has the form of Stokes flow: a force f sin(q x) per length along a line displaces the solid at a
distance r by f K0(q r) / (4 pi G) at places across the force, and by q r K1(q r) f / (4 pi G) more at places along the
force. The force is spread evenly over the width of a film or the circle of a pipe; the deflection is the mean over it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.special import i0e, i1e, k0, k0e, k1e

from hypertuna.actuation.soft_joint import joint_group, joint_models
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.ranges import POSITIVE

WAVES = 1.0, 1e5  # range of wave numbers searched [1/m]
RIGID = 1e6  # N, tensile stiffness of an axis whose length is practically constant


@dataclass(frozen=True)
class AxisMember:
    """A member on the axis of a joint, a film or a pipe in silicone: tensile stiffness and buckling load."""

    stiffness: float  # tensile stiffness E A [N]
    bending: float  # bending stiffness E I [N m^2]
    buckling: float  # buckling load, the largest compression [N]
    wavelength: float  # wavelength of buckling [m]; if it is longer than the joint, the ends matter as well
    foundation: float  # stiffness k of the silicone against waves of this length [N/m^2]


def film(width: float, thickness: float, modulus: float, silicone: float) -> AxisMember:
    """Return stiffness and buckling load of a film from its sizes [m], its and the silicone's Young's moduli [Pa].

    The film buckles in the direction of its thickness.
    """
    _check(width=width, thickness=thickness, modulus=modulus, silicone=silicone)

    def foundation(wave: float) -> float:
        displacement, _ = quad(
            lambda s: (1 - s) * k0(wave * width * s), 0, 1, points=(min(1.0, 1 / (wave * width)),), limit=200
        )
        return float(4 * math.pi * silicone / 3 / (2 * displacement))

    return _member(modulus, width * thickness, width * thickness**3 / 12, foundation)


def pipe(outer: float, inner: float, modulus: float, silicone: float) -> AxisMember:
    """Return stiffness and buckling load of a pipe from its diameters [m], its and the silicone's Young's moduli [Pa].

    Pipes far apart carry the sum of their loads; pipes side by side share the silicone, and carry less.
    """
    _check(outer=outer, modulus=modulus, silicone=silicone)
    if not 0 <= inner < outer:
        raise InputError("must be less than outer", key="inner", value=f"{inner:g} m", fix="give both diameters in m")

    def foundation(wave: float) -> float:
        x = wave * outer / 2
        displacement = i0e(x) * k0e(x) + x / 2 * (i0e(x) * k1e(x) - i1e(x) * k0e(x))
        return 4 * math.pi * silicone / 3 / float(displacement)

    area, second = (math.pi / part * (outer**power - inner**power) for part, power in ((4, 2), (64, 4)))
    return _member(modulus, area, second, foundation)


def buckling_load(bending: float, foundation: Callable[[float], float]) -> tuple[float, float]:
    """Return the load [N] at which a member buckles in an elastic foundation, and the wave number [1/m].

    `foundation` gives the force per length and deflection [N/m^2] against waves of a wave number.
    """

    def load(exponent: float) -> float:
        wave = math.exp(exponent)
        return bending * wave**2 + foundation(wave) / wave**2

    minimum = minimize_scalar(load, bounds=np.log(WAVES), method="bounded", options={"xatol": 1e-6})
    return float(minimum.fun), math.exp(minimum.x)


def held_compression(robot: Robot, joint: str | int, pressure: ArrayLike) -> Array:
    """Return the compression [N] (n,) of an axis of constant length under pressures of both sides (n, 2) [Pa].

    A member that holds the axis must carry this compression without buckling.
    """
    name = joint_group(robot, joint)[0].name
    rigid = {"axis_stiffness": RIGID, "axis_buckling": None}
    groups = tuple(
        group.model_copy(update={"actuator": group.actuator.model_copy(update=rigid)}) if group.actuator else group
        for group in robot.joints
    )
    model = next(m for m in joint_models(robot.model_copy(update={"joints": groups})) if m.name == name)
    return np.asarray(-RIGID * (model["rest"] + model.balance(pressure)["strain"]))


def _member(modulus: float, area: float, second: float, foundation: Callable[[float], float]) -> AxisMember:
    """Return a member from its modulus [Pa], area [m^2], second moment of area [m^4] and elastic foundation."""
    load, wave = buckling_load(modulus * second, foundation)
    return AxisMember(modulus * area, modulus * second, load, 2 * math.pi / wave, foundation(wave))


def _check(**values: float) -> None:
    """Check that sizes and moduli are positive."""
    for key, value in values.items():
        POSITIVE.check(value, key, "give sizes in m and Young's moduli in Pa")
