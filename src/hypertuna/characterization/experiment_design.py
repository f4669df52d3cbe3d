"""Expected information gain of one more measurement: by how much it would narrow the fit of a bench."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.bending import bend
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import drive_unit, joint_group, joint_models, mooney, muscle
from hypertuna.characterization.data import BOTH, KINDS, Bench
from hypertuna.characterization.fit import BenchFit
from hypertuna.characterization.problem import blocked_moment, shortening
from hypertuna.characterization.unknowns import Unknown, with_unknowns
from hypertuna.description.robot import Robot
from hypertuna.description.schema.actuator import NEUTRAL_BRAID

STEP = 1e-4  # of a logarithm, for differences
# Standard deviation of each measurement, of common workshop instruments.
CALIPER = 0.05e-3  # m
RULER = 0.2e-3  # m, on a cut-open joint
PHOTOGRAPH = math.radians(1.0)
TENSILE_TEST, LOAD_CELL, SYRINGE, BENDING_TEST = 0.05, 0.02, 0.02, 0.03  # relative
STRAIN = 0.005  # of a contraction
GONIOMETER = math.radians(0.2)
ARM = 0.08  # m, of the scale that holds a joint straight
NARROWED = 0.9  # of its interval: unknowns narrowed less are not listed


@dataclass(frozen=True)
class InformationGain:
    """One more measurement, and what it would narrow."""

    text: str  # the quantity, and the instrument
    value: float  # expected by the fit, in `unit`
    sd: float  # standard deviation of the measurement, in `unit`
    unit: str
    half_interval: float  # half the 95 % interval of the expected value, in `unit`
    bits: float  # expected information gain, log2 of the ratio of standard deviations of the prediction
    before: dict[str, float]  # half the 95 % interval of the logarithm of each unknown narrowed by a tenth or more
    after: dict[str, float]

    @property
    def record(self) -> dict[str, Any]:
        """Record of the measurement, for JSON."""
        narrowed = [{"name": n, "before_log": self.before[n], "after_log": after} for n, after in self.after.items()]
        facts = {"measure": self.text, "unit": self.unit, "expected": self.value, "sd": self.sd, "bits": self.bits}
        return facts | {"expected_half_interval": self.half_interval, "narrowed": narrowed}


@dataclass(frozen=True)
class Candidate:
    """A possible measurement: its value for a robot, its standard deviation, and its displayed unit."""

    text: str
    of: Callable[[Robot], float]  # [SI]
    sd: float  # of the value [SI]; negative: relative
    unit: str
    factor: float = 1.0  # displayed units per SI unit

    def noise(self, value: float) -> float:
        """Return the standard deviation at a value [SI]."""
        return self.sd if self.sd > 0 else -self.sd * abs(value)


def information_gain(fit: BenchFit) -> tuple[InformationGain, ...]:
    """Compute the expected information gain of further measurements, the most informative first (docs/bench.md).

    A measurement of standard deviation t and gradient g turns the covariance C of the logarithms of the unknowns into
    C - C g g^T C / (t^2 + g^T C g); g comes from central differences of the model.
    """
    cov, n = fit.covariance, len(fit.free)
    half = [fit.quantile * u.relative(float(v)) for u, v in zip(fit.free, fit.values, strict=True)]
    before = np.sqrt(np.diag(cov))
    gains = []
    for one in candidates(fit.described, fit.bench, fit.free):
        value = one.of(fit.robot)
        sd = one.noise(value)
        if not sd:  # relative to a value of 0, as a bend at 0 kPa
            continue
        gradient = np.array([_derivative(fit, one, k) for k in range(n)])
        covariance = cov @ gradient
        variance = float(gradient @ covariance)
        after = np.sqrt(np.diag(cov) - covariance**2 / (sd**2 + variance))
        narrowed = [k for k in np.argsort(after / before).tolist() if after[k] < NARROWED * before[k]]
        gains.append(
            InformationGain(
                text=one.text,
                value=value * one.factor,
                sd=sd * one.factor,
                unit=one.unit,
                half_interval=fit.quantile * math.sqrt(variance) * one.factor,
                bits=0.5 * math.log2(1 + variance / sd**2),
                before={fit.free[k].name: half[k] * float(before[k]) for k in narrowed},
                after={fit.free[k].name: half[k] * float(after[k]) for k in narrowed},
            )
        )
    return tuple(sorted(gains, key=lambda one: -one.bits))


def _derivative(fit: BenchFit, one: Candidate, k: int) -> float:
    """Differentiate a measurement by the logarithm of unknown k."""
    unknown, mask = fit.free[k], np.eye(len(fit.free), dtype=bool)[k]
    up, down = (
        one.of(with_unknowns(fit.described, fit.free, np.where(mask, value, fit.values), checked=False))
        for value in (unknown.value(unknown.log(float(fit.values[k])) + side * STEP) for side in (1, -1))
    )
    return (up - down) / (2 * STEP)


def candidates(described: Robot, bench: Bench, free: Sequence[Unknown]) -> list[Candidate]:
    """List measurements of parts, of a drive unit alone, and of every joint on the bench."""
    top = float(bench.pressure.max())
    at = f"at {top / 1e3:g} kPa"
    outer, inner, angle = (partial(_of_unit, name) for name in ("outer_diameter", "inner_diameter", "braid_angle"))
    found = [
        Candidate("outer diameter of the hose, by caliper", outer, CALIPER, "mm", 1e3),
        Candidate("inner diameter of the hose, by pin gauge", inner, CALIPER, "mm", 1e3),
        Candidate("braid angle at rest, by photograph", angle, PHOTOGRAPH, "deg", 180 / math.pi),
        Candidate(f"blocked force of one drive unit {at}", lambda r: _pull(r, top, 1.0), -LOAD_CELL, "N"),
        Candidate(f"free contraction of one drive unit {at}", lambda r: _contraction(r, top), STRAIN, "%", 100.0),
    ]
    for part in ("hose", "matrix"):
        if f"{part}_modulus" in {one.kind for one in free}:
            name = getattr(drive_unit(described), part)
            text, modulus = f"tensile test of the {part}'s silicone", mooney(described, name).modulus
            found.append(Candidate(text, partial(_relative, name, modulus), -TENSILE_TEST, "of described"))
    return found + [one for j in bench.joints for one in [*_held(described, bench, j), *_of_joint(described, bench, j)]]


def _held(described: Robot, bench: Bench, joint: int) -> list[Candidate]:
    """List measurements of a joint that is held, or that both sides shorten, which the bench lacks."""
    name, own = described.joints[joint].name, bench.joint == joint
    top = float(bench.pressure[own].max())
    at = f"at {top / 1e3:g} kPa"

    def force(robot: Robot) -> float:
        return blocked_moment(robot, joint, top, arm=ARM) / ARM

    found = []
    if not np.isfinite(bench.moment[own]).any():
        text = f"blocked force of joint {name} {at}, on a luggage scale {1e3 * ARM:g} mm from its middle"
        found.append(Candidate(text, force, KINDS["moment"].sd, "N"))
    if not np.isfinite(bench.shortening[own]).any():
        text = f"shortening of joint {name}, {BOTH} sides {at}, by ruler"
        found.append(
            Candidate(text, partial(_both_shorter, joint=joint, pressure=top), KINDS["shortening"].sd, "mm", 1e3)
        )
    return found


def open_quantities(described: Robot, bench: Bench) -> list[Candidate]:
    """List what the bench does not measure of its joints at their highest pressures."""
    return [one for joint in bench.joints for one in _open(described, bench, joint)]


def _open(described: Robot, bench: Bench, joint: int) -> list[Candidate]:
    """List what the bench does not measure of a joint at its highest pressure."""
    top = float(bench.pressure[bench.joint == joint].max())
    at = (bench.joint == joint) & (bench.pressure == top)
    both = bench.side == len(SIDES)
    name = f"of joint {described.joints[joint].name}"

    def lacks(kind: str, rows: NDArray[np.bool_] = ~both) -> bool:
        return not np.isfinite(getattr(bench, kind)[at & rows]).any()

    def of(text: str, value: Callable[[Robot, int, float], float], unit: str, factor: float = 1.0) -> Candidate:
        return Candidate(text, lambda robot: value(robot, joint, top), 0.0, unit, factor)

    at_top = f"{name} at {top / 1e3:g} kPa"
    return [
        *[of(f"blocked moment {at_top}", blocked_moment, "N m")] * lacks("moment"),
        *[of(f"bend {at_top}", _angle, "deg", 180 / math.pi)] * lacks("angle"),
        *[of(f"shortening {at_top}", _shorter, "mm", 1e3)] * lacks("shortening"),
        *[of(f"shortening by both sides {at_top}", _both_shorter, "mm", 1e3)] * lacks("shortening", both),
        *[of(f"oil volume {at_top}", _volume, "ml", 1e6)] * lacks("volume"),
        of(f"moment per bend {name} without pressure", _stiffness, "N m/rad"),
    ]


def _angle(robot: Robot, joint: int, pressure: float) -> float:
    """Compute the bend by one side [rad]."""
    return float(bend(robot, joint, [pressure]).angle[0])


def _shorter(robot: Robot, joint: int, pressure: float) -> float:
    """Compute how much one side shortens a joint [m]."""
    return float(bend(robot, joint, [pressure]).shortening[0]) * joint_group(robot, joint)[1].length


def _both_shorter(robot: Robot, joint: int, pressure: float) -> float:
    """Compute how much both sides shorten a joint [m]."""
    return float(shortening(robot, joint, np.array([pressure]))[0])


def _volume(robot: Robot, joint: int, pressure: float) -> float:
    """Compute the oil that one side takes in [m^3]."""
    return float(bend(robot, joint, [pressure]).volume[0])


def _stiffness(robot: Robot, joint: int, pressure: float) -> float:
    """Compute the moment per bend without pressure [N m/rad]."""
    return joint_models(robot)[joint].stiffness


def _of_joint(described: Robot, bench: Bench, joint: int) -> list[Candidate]:
    """List measurements of a joint; bends only on sides and branches that the bench lacks."""
    name, own = described.joints[joint].name, bench.joint == joint
    top = float(bench.pressure[own].max())

    def lever(robot: Robot) -> float:
        return joint_group(robot, joint)[1].lever

    def length(robot: Robot) -> float:
        return joint_group(robot, joint)[1].segment_length[0]

    stiffness, volume = (partial(value, joint=joint, pressure=top) for value in (_stiffness, _volume))
    found = [
        Candidate(f"lever of joint {name}, cut open", lever, RULER, "mm", 1e3),
        Candidate(f"segment length of joint {name}, cut open", length, RULER, "mm", 1e3),
        Candidate(f"moment per bend of joint {name} without pressure", stiffness, -BENDING_TEST, "N m/rad"),
    ]
    if not np.isfinite(bench.volume[own]).any():
        text = f"oil volume of joint {name} at {top / 1e3:g} kPa, by syringe"
        found.append(Candidate(text, volume, -SYRINGE, "ml", 1e6))
    for side, word in enumerate(SIDES):
        rows = own & (bench.side == side) & np.isfinite(bench.angle)
        for unload, branch in ((False, "loading"), (True, "unloading")):
            if not (rows & (bench.unload == unload)).any() and not (unload and not rows.any()):
                at = top / 2 if unload else top
                text = f"{word} bend of joint {name}, {branch}, at {at / 1e3:g} kPa"
                angle = partial(_bend, joint, word, sorted({at, top}), unload)
                found.append(Candidate(text, angle, GONIOMETER, "deg", 180 / math.pi))
    return found


def _of_unit(name: str, robot: Robot) -> float:
    """Return a number of the drive units [SI]."""
    return float(getattr(drive_unit(robot), name))


def _relative(material: str, described: float, robot: Robot) -> float:
    """Return the modulus of a silicone over the described one [Pa]."""
    return mooney(robot, material).modulus / described


def _bend(joint: int, side: str, pressure: list[float], unload: bool, robot: Robot) -> float:
    """Compute the bend at the top of rising pressures [Pa], or unloaded to the least of them [rad]."""
    curve = bend(robot, joint, pressure, side=side, unload=unload)
    return float((curve.angle if curve.unload_angle is None else curve.unload_angle)[-1])


def _pull(robot: Robot, pressure: float, stretch: float) -> float:
    """Compute the pull of one drive unit without friction [N]."""
    return float(np.asarray(muscle(robot).at(np.array([stretch]), pressure=pressure)["pull"])[0])


def _contraction(robot: Robot, pressure: float) -> float:
    """Compute the contraction at which the pull of one drive unit is zero [1]."""
    from scipy.optimize import brentq

    neutral = math.cos(NEUTRAL_BRAID) / math.cos(drive_unit(robot).braid_angle)  # there the pressure pulls no more
    return 1 - float(brentq(lambda stretch: _pull(robot, pressure, stretch), neutral, 1.0, xtol=1e-13))
