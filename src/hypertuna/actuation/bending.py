"""Bend of a soft joint under pressure.

The angle at a pressure balances moments and axial forces: `balance` of core joint.hpp, with the pull of muscle.hpp.
docs/actuator.md derives the equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import LUMEN_MIN, drive_unit, joint_group, joint_sections, muscle, soft_joint
from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, robot_of
from hypertuna.description.schema.actuator import NEUTRAL_BRAID
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, shown
from hypertuna.io.files import dataset
from hypertuna.ranges import check_choice, check_name

if TYPE_CHECKING:
    import xarray as xr

# Options of the core's equations, and the steps from the printed to the corrected equations. The sections of the last
# two steps account for the whole joint: matrix around the hoses, whose ends are held.
FREE = {"printed": False, "nominal_stress": False, "inner_balance": False, "passive": True, "shortens": True}
PRINTED = {"printed": True, "nominal_stress": True, "inner_balance": True, "passive": False, "shortens": False}
LAWS: dict[str, dict[str, bool]] = {"corrected": FREE, "as_printed": PRINTED}
TRUE_STRESS = PRINTED | {"nominal_stress": False}  # true stress on the deformed section
HELD = FREE | {"shortens": False}  # an axis of constant length
STEPS: tuple[tuple[str, dict[str, bool], dict[str, bool]], ...] = (
    ("Eqs 4-18 as printed", PRINTED, {"plain": True, "friction": False}),
    ("Eqs 10-11: true stress on the deformed section", TRUE_STRESS, {"plain": True, "friction": False}),
    (
        "Eqs 12-13: balance on the outer diameter, deformed wall",
        TRUE_STRESS | {"inner_balance": False},
        {"plain": True, "friction": False},
    ),
    ("stress as it varies through the wall", HELD | {"passive": False}, {"plain": True, "friction": False}),
    ("walls of the other side resist", HELD, {"plain": True, "friction": False}),
    ("the body shortens, and braids go slack", FREE, {"plain": True, "friction": False}),
    ("matrix around the hoses swells, their ends do not", FREE, {"plain": False, "friction": False}),
    ("Eq. 4: friction, rising pressure", FREE, {"plain": False, "friction": True}),
)


@dataclass(frozen=True)
class Bend(Plotted, Tabular, data=lambda bend: bend.dataset()):
    """Bend of a joint under the pressure of one side: angle, oil and state of the muscles at each pressure."""

    robot: Robot
    joint: str  # name of the joint group
    side: str  # side under pressure, "left" or "right"
    material: str  # material set
    law: str  # equations, a key of `LAWS`
    friction: bool  # whether the braids have friction
    pressure: Array  # (n,) rising gauge pressure [Pa]
    angle: Array  # (n,) bend toward the side under pressure [rad]
    unload_pressure: Array | None  # (n,) falling gauge pressure while unloading [Pa]
    unload_angle: Array | None  # (n,) bend while unloading [rad]
    segments: Array  # (n or 2 n, segments) angle of each segment, loading then unloading [rad]
    shortening: Array  # (n or 2 n,) shortening of the axis over its length, loading then unloading [1]
    volume: Array  # (n or 2 n,) oil taken in since rest by the side under pressure, loading then unloading [m^3]
    braid_angle_max: float  # largest angle between a braid and its axis [rad]
    lumen_left_min: float  # smallest part of its lumen that a stretched muscle keeps [1]
    status: str  # "free" or "locked"
    status_text: str  # the status as a sentence

    @property
    def branches(self) -> dict[str, tuple[Array, Array]]:
        """Pressures [Pa] and angles [rad] of "loading" and, if it was computed, of "unloading"."""
        branches = {"loading": (self.pressure, self.angle)}
        if self.unload_pressure is not None and self.unload_angle is not None:
            branches["unloading"] = (self.unload_pressure, self.unload_angle)
        return branches

    @property
    def loop_area(self) -> float:
        """Area of the hysteresis loop of angle over pressure [Pa rad]; 0 without unloading."""
        if self.unload_angle is None:
            return 0.0
        return float(np.trapezoid(self.unload_angle[::-1] - self.angle, self.pressure))

    @property
    def friction_loss(self) -> float:
        """Net work of the oil on the joint [J]; over a closed loop this is the loss to friction."""
        path = self.pressure if self.unload_pressure is None else np.append(self.pressure, self.unload_pressure)
        return float(np.trapezoid(path, self.volume))

    def r_squared(self) -> float:
        """Return the coefficient of determination [1] of a line through the angle over the pressure while loading.

        Returns
        -------
        float
            Coefficient of determination [1], see `straightness`.
        """
        return straightness(self.pressure, self.angle)

    def dataset(self) -> xr.Dataset:
        """Return the bend as labeled arrays.

        Returns
        -------
        xarray.Dataset
            Dimension pressure; angle [rad] and, if it was computed, unload_angle [rad] at the same pressures.
        """
        text = "angle toward the side with the pressure, on the way"
        variables = {"angle": ("pressure", self.angle, "rad", f"{text} up")}
        if self.unload_angle is not None:
            variables["unload_angle"] = ("pressure", self.unload_angle[::-1], "rad", f"{text} down")
        coordinates = {"pressure": ("pressure", self.pressure, "Pa", "gauge pressure")}
        facts = {"joint": self.joint, "side": self.side, "material": self.material, "law": self.law}
        facts |= {"friction": str(self.friction).lower(), "status": self.status_text}
        return dataset(variables, coordinates, provenance(self.robot) | facts)


@checked
def bend(
    robot: Robot | str | Path,
    joint: str | int,
    pressure: ArrayLike,
    *,
    side: str = "left",
    material: str | None = None,
    friction: bool = True,
    unload: bool = False,
    law: str = "corrected",
) -> Bend:
    """Compute the bend of a joint in air under the pressure of one side, from rest.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    joint : str or int
        Name or index of a joint group.
    pressure : array_like, shape (n,)
        Rising gauge pressures of one side [Pa]; the other side has no pressure.
    side : str
        ``"left"`` or ``"right"``: the side under pressure.
    material : str, optional
        Material set, see `mooney`.
    friction : bool
        Whether the braids have friction.
    unload : bool
        Whether the pressure falls through the same values afterwards; friction makes the two branches differ.
    law : str
        ``"corrected"``, or ``"as_printed"`` for Eqs 4-18 exactly as the paper prints them; the printed equations have
        no hysteresis, since their friction lacks an area and a sign.

    Returns
    -------
    Bend

    Raises
    ------
    InputError
        If the joint, side, set or law does not exist, the robot lacks a table, or the pressures do not rise from 0.

    Examples
    --------
    >>> import numpy as np
    >>> import hypertuna as ht
    >>> curve = ht.bend(ht.load("hypertuna"), "I", [100e3, 250e3])
    >>> np.degrees(curve.angle).round(1).tolist()
    [9.9, 18.3]
    """
    robot = robot_of(robot)
    rising = check_pressure(pressure)
    side_index = check_side(side)
    check_name(law, LAWS, "law", "law")
    material_set = material or drive_unit(robot).material_set
    printed = law == "as_printed"
    model = soft_joint(robot, joint, material_set, friction=friction, plain=printed).with_law(**LAWS[law])
    path = np.concatenate([rising, rising[::-1]]) if unload else rising
    pressures = np.zeros((len(path), 2))
    pressures[:, side_index] = path
    states = np.asarray(model.bend(pressures))
    segments = states[..., 0] * (1 - 2 * side_index)
    n = len(rising)
    has_friction = friction and law == "corrected" and drive_unit(robot).friction > 0
    return Bend(
        robot=robot,
        joint=joint_group(robot, joint)[0].name,
        side=side,
        material=material_set,
        law=law,
        friction=has_friction,
        pressure=rising,
        angle=segments[:n].sum(axis=1),
        unload_pressure=path[n:] if unload else None,
        unload_angle=segments[n:].sum(axis=1) if unload else None,
        segments=segments,
        **_muscles(robot, joint, material_set, states, float(rising[-1]), side_index, printed),
    )


def straightness(pressure: Array, angle: Array, low: float = 100e3, high: float = 250e3) -> float:
    """Return the coefficient of determination [1] of a line through the angles [rad] between two pressures [Pa].

    The default range is the paper's (section III.A); NaN if fewer than three points lie in the range.
    """
    inside = (pressure >= low * (1 - 1e-12)) & (pressure <= high * (1 + 1e-12))
    if inside.sum() < 3:
        return math.nan
    return float(np.corrcoef(pressure[inside], angle[inside])[0, 1] ** 2)


def check_pressure(pressure: ArrayLike) -> Array:
    """Return pressures [Pa] as an array (n,); they must be finite, increasing and not negative."""
    rule, fix = "must be a list of finite numbers", "give pressures in Pa"
    try:
        rising = np.atleast_1d(np.asarray(pressure, dtype=np.float64))
    except (TypeError, ValueError):
        rising = np.array([np.nan])
    if rising.ndim != 1 or not len(rising) or not np.isfinite(rising).all():
        raise InputError(rule, key="pressure", value=shown(pressure), fix=fix)
    if rising[0] < 0:
        fix = "put the other side under pressure to bend the other way"
        raise InputError("must not be negative", key="pressure", value=f"{rising.min() / 1e3:g} kPa", fix=fix)
    falls = np.flatnonzero(np.diff(rising) <= 0)
    if len(falls):
        pair = f"{rising[falls[0]] / 1e3:g} kPa, then {rising[falls[0] + 1] / 1e3:g} kPa"
        lower = ",".join(f"{p / 1e3:g}" for p in np.unique(rising[falls[0] : falls[0] + 2]))
        fix = f"write the lower one first, and each once: {lower}"
        raise InputError("must increase", key="pressure", value=pair, fix=fix)
    return rising


def check_side(side: str) -> int:
    """Return the index of a side: 0 for left, 1 for right."""
    return SIDES.index(check_choice(side, SIDES, "side"))


def _muscles(
    robot: Robot, joint: str | int, material: str, bent: Array, pressure: float, active: int, printed: bool
) -> dict[str, Any]:
    """Return the muscles' fields of a `Bend`: oil taken in, largest braid angle, lumen left, shortening, status."""
    unit, (group, actuator) = drive_unit(robot), joint_group(robot, joint)
    length = joint_sections(robot, joint, plain=printed)[:, 0]
    hose, axis = muscle(robot, material), 1 + bent[..., 1]
    curvature = bent[..., 0] / length / np.sqrt(axis)

    def lumen(stretch: Array) -> Array:
        return np.asarray(hose.at(stretch.ravel(), pressure=0.0)["lumen"]).reshape(stretch.shape)

    stretch = [axis - actuator.levers[0] * curvature, axis + actuator.levers[1] * curvature]
    short, long = stretch[active], stretch[1 - active]
    growth = lumen(short) - lumen(np.ones(1))
    volume = cast(int, group.drive_units) * (growth * length).sum(axis=1)
    lumen_left = float((lumen(long) / lumen(np.ones(1))).min())
    braid = math.acos(min(1.0, float(short.min()) * math.cos(unit.braid_angle)))
    shortening = -(bent[..., 1] * length).sum(axis=1) / actuator.length
    facts = {"volume": volume, "braid_angle_max": braid, "lumen_left_min": lumen_left, "shortening": shortening}
    if not printed and lumen_left < LUMEN_MIN:
        text = f"The joint locks below {pressure / 1e3:g} kPa: the lumen of the stretched muscles closes."
        return facts | {"status": "locked", "status_text": text}
    angle, neutral = (f"{math.degrees(value):.1f}" for value in (braid, NEUTRAL_BRAID))
    text = f"At {pressure / 1e3:g} kPa the braid stands at {angle} deg (at {neutral} a muscle pulls no more)"
    note = "" if printed else f" and the joint is {1e3 * shortening.max() * actuator.length:.1f} mm shorter"
    return facts | {"status": "free", "status_text": f"{text}{note}."}


@dataclass(frozen=True)
class Correction:
    """One correction of the printed equations, and the bend with it."""

    text: str  # the correction
    angle: float  # bend of the joint with all corrections up to this one [rad]


def misprints(robot: Robot, joint: str | int, pressure: float, material: str | None = None) -> tuple[Correction, ...]:
    """Return the bend at a pressure [Pa] after each correction of the printed equations, added one by one.

    The effect of a correction depends on the corrections before it; the last step adds friction while loading.
    """
    pressures = np.array([[check_pressure(pressure)[0], 0.0]])

    def bend_angle(law: dict[str, bool], parts: dict[str, bool]) -> float:
        joint_model = soft_joint(robot, joint, material, friction=parts["friction"], plain=parts["plain"])
        model = joint_model.with_law(**law)
        return float(np.asarray(model.bend(pressures))[..., 0].sum())

    return tuple(Correction(text, bend_angle(law, parts)) for text, law, parts in STEPS)
