"""What another measurement would be worth: by how much it would narrow what a bench leaves free, by the model."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.bending import SIDES, bend
from hypertuna.actuation.soft_joint import drive_unit, joint_group, mooney, muscle, soft_joint
from hypertuna.characterization.data import Bench, Loop
from hypertuna.characterization.fit import BenchFit
from hypertuna.characterization.search import computed
from hypertuna.characterization.unknowns import with_unknowns
from hypertuna.description.robot import Robot

__all__ = ["Worth", "worth"]

Array = NDArray[np.float64]

STEP = 1e-4  # of a logarithm, for differences
# Standard deviation of each measurement: of instruments that a workshop has.
CALIPER = 0.05e-3  # m
RULER = 0.2e-3  # m: of what lies inside silicone, cut open or by the mold
PHOTOGRAPH = math.radians(1.0)
TENSILE_TEST, LOAD_CELL, SYRINGE, BENDING_TEST = 0.05, 0.02, 0.02, 0.03  # relative
STRAIN = 0.005  # of a contraction
GONIOMETER = math.radians(0.2)
SHORTEST_STRETCH = 0.4  # no braid contracts so far


@dataclass(frozen=True)
class Worth:
    """One more measurement, and what it would do.

    Attributes
    ----------
    text : str
        What is measured, and how.
    value, sd : float
        What the fit expects, and the standard deviation of the measurement, in ``unit``.
    unit : str
    expected : float
        Half the 95 % interval within which the fit expects the value, in ``unit``.
    bits : float
        Information gained: half the logarithm to base 2 of how many times the variance of the prediction is larger than
        before. Below 1/2 the measurement tells little that the bench does not.
    before, after : dict of float
        Half the 95 % interval of each unknown's logarithm that it would narrow by a tenth or more.
    """

    text: str
    value: float
    sd: float
    unit: str
    expected: float
    bits: float
    before: dict[str, float]
    after: dict[str, float]


@dataclass(frozen=True)
class _Candidate:
    """What could be measured: its value for a robot, its standard deviation, and how people read it."""

    text: str
    of: Callable[[Robot], float]
    sd: float  # of the value; negative: relative
    unit: str
    factor: float = 1.0  # units in one SI unit


def worth(fit: BenchFit) -> tuple[Worth, ...]:
    """Compute what more measurements would be worth.

    Parameters
    ----------
    fit : BenchFit

    Returns
    -------
    tuple of Worth
        The most informative first.

    Notes
    -----
    A measurement y with the standard deviation t and the gradient g by the logarithms of the unknowns turns their
    covariance C into C - C g g^T C / (t^2 + g^T C g), and gains log2(1 + g^T C g / t^2) / 2 bits. g comes from the
    model, by central differences at the fit.
    """
    cov, n = fit.covariance, len(fit.free)
    half = [fit.quantile * u.relative(float(v)) for u, v in zip(fit.free, fit.values, strict=True)]
    before = np.sqrt(np.diag(cov))
    found = []
    for one in _candidates(fit):
        value = one.of(fit.robot)
        sd = one.sd if one.sd > 0 else -one.sd * abs(value)
        slope = np.array([_slope(fit, one, k) for k in range(n)])
        reach = cov @ slope
        variance = float(slope @ reach)
        after = np.sqrt(np.diag(cov) - reach**2 / (sd**2 + variance))
        told = [k for k in np.argsort(after / before).tolist() if after[k] < 0.9 * before[k]]
        found.append(
            Worth(
                text=one.text,
                value=value * one.factor,
                sd=sd * one.factor,
                unit=one.unit,
                expected=fit.quantile * math.sqrt(variance) * one.factor,
                bits=0.5 * math.log2(1 + variance / sd**2),
                before={fit.free[k].name: half[k] * float(before[k]) for k in told},
                after={fit.free[k].name: half[k] * float(after[k]) for k in told},
            )
        )
    return tuple(sorted(found, key=lambda one: -one.bits))


def _slope(fit: BenchFit, one: _Candidate, k: int) -> float:
    """Differentiate what is measured by the logarithm of an unknown."""
    unknown, steps = fit.free[k], np.eye(len(fit.free))[k]
    up, down = (
        one.of(with_unknowns(fit.described, fit.free, np.where(steps != 0, value, fit.values), checked=False))
        for value in (unknown.value(unknown.log(float(fit.values[k])) + side * STEP) for side in (1, -1))
    )
    return (up - down) / (2 * STEP)


def _candidates(fit: BenchFit) -> list[_Candidate]:
    """List what a workshop could measure: parts, a drive unit alone, every joint that was on the bench."""
    top = float(fit.bench.pressure.max())
    kinds, at = {one.kind for one in fit.free}, f"at {top / 1e3:g} kPa"
    found = [
        _Candidate(
            "outer diameter of the hose, by caliper", lambda r: drive_unit(r).outer_diameter, CALIPER, "mm", 1e3
        ),
        _Candidate(
            "inner diameter of the hose, by pin gauge", lambda r: drive_unit(r).inner_diameter, CALIPER, "mm", 1e3
        ),
        _Candidate(
            "braid angle at rest, by photograph",
            lambda r: drive_unit(r).braid_angle,
            PHOTOGRAPH,
            "deg",
            180 / math.pi,
        ),
        _Candidate(f"blocked force of one drive unit {at}", lambda r: _pull(r, top, 1.0), -LOAD_CELL, "N"),
        _Candidate(f"free contraction of one drive unit {at}", lambda r: _free(r, top), STRAIN, "%", 100.0),
    ]
    found += [
        _Candidate(f"tensile test of the {part}'s silicone", _modulus_of(fit, part), -TENSILE_TEST, "of described")
        for part in ("hose", "matrix")
        if f"{part}_modulus" in kinds
    ]
    for j in fit.bench.joints:
        found += _of_joint(fit, j, top)
    return found


def _modulus_of(fit: BenchFit, part: str) -> Callable[[Robot], float]:
    """Return what reads the modulus of the hose's or the matrix's silicone, over that of the description."""
    name = getattr(drive_unit(fit.described), part)
    whole = mooney(fit.described, name).modulus
    return lambda robot: mooney(robot, name).modulus / whole


def _of_joint(fit: BenchFit, joint: int, top: float) -> list[_Candidate]:
    """List what could be measured of a joint; bends only on sides and branches that were not."""
    name, bench = fit.described.joints[joint].name, fit.bench
    mine = bench.joint == joint
    found = [
        _Candidate(f"lever of joint {name}, cut open", lambda r: joint_group(r, joint)[1].lever, RULER, "mm", 1e3),
        _Candidate(
            f"segment length of joint {name}, cut open",
            lambda r: joint_group(r, joint)[1].segment_length[0],
            RULER,
            "mm",
            1e3,
        ),
        _Candidate(
            f"moment per bend of joint {name} without pressure",
            lambda r: float(sum(soft_joint(r, joint).stiffness())),
            -BENDING_TEST,
            "N m/rad",
        ),
    ]
    if not np.isfinite(bench.volume[mine]).any():
        text = f"oil volume of joint {name} at {top / 1e3:g} kPa, by syringe"
        found.append(_Candidate(text, lambda r: _volume(r, joint, top), -SYRINGE, "ml", 1e6))
    for side, word in enumerate(SIDES):
        rows = mine & (bench.side == side)
        for unload, branch in ((False, "loading"), (True, "unloading")):
            if not (rows & (bench.unload == unload)).any() and not (unload and not rows.any()):
                probe = _probe(joint, side, top, unload)
                text = f"{word} bend of joint {name}, {branch}, at {(top / 2 if unload else top) / 1e3:g} kPa"
                found.append(_Candidate(text, _bend_of(probe), GONIOMETER, "deg", 180 / math.pi))
    return found


def _bend_of(probe: Bench) -> Callable[[Robot], float]:
    """Return what computes the last bend of a bench."""
    return lambda robot: float(computed(robot, probe)[0][-1])


def _probe(joint: int, side: int, top: float, unload: bool) -> Bench:
    """Make a bench of one measurement: at the top, or half way back from it."""
    one = np.ones(1, dtype=np.int64)
    return Bench(
        joint=joint * one,
        side=side * one,
        pressure=np.array([top / 2 if unload else top]),
        angle=np.zeros(1),
        unload=np.array([unload]),
        angle_sd=np.full(1, np.nan),
        volume=np.full(1, np.nan),
        loops=(Loop(joint, side, top, np.zeros(1, dtype=np.int64)),),
        files=("",),
        lines=(0,),
    )


def _volume(robot: Robot, joint: int, pressure: float) -> float:
    """Oil that the left side's drive units take up on the way to a pressure [m^3]."""
    return float(bend(robot, joint, [pressure]).volume[0])


def _pull(robot: Robot, pressure: float, stretch: float) -> float:
    """Pull of one drive unit without friction [N]."""
    return float(np.asarray(muscle(robot).at(np.array([stretch]), pressure=pressure)["pull"])[0])


def _free(robot: Robot, pressure: float) -> float:
    """Contraction at which one drive unit pulls no more [1]."""
    from scipy.optimize import brentq

    return 1 - float(brentq(lambda stretch: _pull(robot, pressure, stretch), SHORTEST_STRETCH, 1.0, xtol=1e-13))
