"""Expected information gain of one more measurement: how much it would narrow the fit of a bench."""

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

STEP = 1e-4  # step of a logarithm for central differences
# Standard deviations of measurements with common workshop instruments.
CALIPER = 0.05e-3  # m
RULER = 0.2e-3  # m, on a cut-open joint
PHOTOGRAPH = math.radians(1.0)  # angle of a braid on a photograph
TENSILE_TEST, LOAD_CELL, SYRINGE, BENDING_TEST = 0.05, 0.02, 0.02, 0.03  # relative
STRAIN = 0.005  # free contraction of a drive unit [1]
GONIOMETER = math.radians(0.2)  # bend of a joint
ARM = 0.08  # m, distance from the middle of a joint to the scale that holds it straight
NARROWED = 0.9  # an unknown is listed if a measurement shortens its interval below this part


@dataclass(frozen=True)
class InformationGain:
    """One more measurement, with its expected value and the intervals that it would narrow."""

    text: str  # the quantity, and the instrument
    value: float  # value that the fit predicts, in `unit`
    sd: float  # standard deviation of the measurement, in `unit`
    unit: str
    half_interval: float  # half the 95 % interval of the expected value, in `unit`
    bits: float  # expected information gain: log2 of the prediction's standard deviation before over after
    before: dict[str, float]  # half the 95 % interval of the logarithm of each unknown narrowed by a tenth or more
    after: dict[str, float]  # the same half intervals after the measurement

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
    of: Callable[[Robot], float]  # returns the measured value of a robot [SI]
    sd: float  # standard deviation of the value [SI]; if negative, relative to the value
    unit: str  # displayed unit
    factor: float = 1.0  # displayed units per SI unit

    def noise(self, value: float) -> float:
        """Return the standard deviation of the measurement [SI] for a value [SI]."""
        return self.sd if self.sd > 0 else -self.sd * abs(value)


def information_gain(fit: BenchFit) -> tuple[InformationGain, ...]:
    """Return the expected information gains of further measurements, the largest first (docs/bench.md).

    A measurement of standard deviation t and gradient g turns the covariance C of the logarithms of the unknowns into
    C - C g g^T C / (t^2 + g^T C g); g comes from central differences of the model.
    """
    cov, n = fit.covariance, len(fit.free)
    half_widths = [fit.quantile * u.relative(float(v)) for u, v in zip(fit.free, fit.values, strict=True)]
    before = np.sqrt(np.diag(cov))
    gains = []
    for candidate in candidates(fit.described, fit.bench, fit.free):
        value = candidate.of(fit.robot)
        sd = candidate.noise(value)
        if not sd:  # a relative noise of a value of 0, such as a bend at 0 kPa
            continue
        gradient = np.array([_derivative(fit, candidate, k) for k in range(n)])
        covariance = cov @ gradient
        variance = float(gradient @ covariance)
        after = np.sqrt(np.diag(cov) - covariance**2 / (sd**2 + variance))
        narrowed = [k for k in np.argsort(after / before).tolist() if after[k] < NARROWED * before[k]]
        gains.append(
            InformationGain(
                text=candidate.text,
                value=value * candidate.factor,
                sd=sd * candidate.factor,
                unit=candidate.unit,
                half_interval=fit.quantile * math.sqrt(variance) * candidate.factor,
                bits=0.5 * math.log2(1 + variance / sd**2),
                before={fit.free[k].name: half_widths[k] * float(before[k]) for k in narrowed},
                after={fit.free[k].name: half_widths[k] * float(after[k]) for k in narrowed},
            )
        )
    return tuple(sorted(gains, key=lambda candidate: -candidate.bits))


def _derivative(fit: BenchFit, candidate: Candidate, k: int) -> float:
    """Return the derivative of a measurement's value [SI] with respect to the logarithm of unknown k."""
    unknown, mask = fit.free[k], np.eye(len(fit.free), dtype=bool)[k]
    up, down = (
        candidate.of(with_unknowns(fit.described, fit.free, np.where(mask, value, fit.values), checked=False))
        for value in (unknown.value(unknown.log(float(fit.values[k])) + side * STEP) for side in (1, -1))
    )
    return (up - down) / (2 * STEP)


def candidates(described: Robot, bench: Bench, free: Sequence[Unknown]) -> list[Candidate]:
    """Return possible further measurements: of parts, of a drive unit alone, and of every joint on the bench."""
    top = float(bench.pressure.max())
    at_top = f"at {top / 1e3:g} kPa"
    outer, inner, angle = (partial(_of_unit, name) for name in ("outer_diameter", "inner_diameter", "braid_angle"))
    parts = [
        Candidate("outer diameter of the hose, by caliper", outer, CALIPER, "mm", 1e3),
        Candidate("inner diameter of the hose, by pin gauge", inner, CALIPER, "mm", 1e3),
        Candidate("braid angle at rest, by photograph", angle, PHOTOGRAPH, "deg", 180 / math.pi),
        Candidate(f"blocked force of one drive unit {at_top}", lambda r: _pull(r, top, 1.0), -LOAD_CELL, "N"),
        Candidate(f"free contraction of one drive unit {at_top}", lambda r: _contraction(r, top), STRAIN, "%", 100.0),
    ]
    for part in ("hose", "matrix"):
        if f"{part}_modulus" in {c.kind for c in free}:
            name = getattr(drive_unit(described), part)
            text, modulus = f"tensile test of the {part}'s silicone", mooney(described, name).modulus
            parts.append(Candidate(text, partial(_relative, name, modulus), -TENSILE_TEST, "of described"))
    return parts + [c for j in bench.joints for c in [*_held(described, bench, j), *_of_joint(described, bench, j)]]


def _held(described: Robot, bench: Bench, joint: int) -> list[Candidate]:
    """Return measurements missing on the bench: of the joint held straight, and with both sides under pressure."""
    name, of_joint = described.joints[joint].name, bench.joint == joint
    top = float(bench.pressure[of_joint].max())
    at_top = f"at {top / 1e3:g} kPa"

    def force(robot: Robot) -> float:
        return blocked_moment(robot, joint, top, arm=ARM) / ARM

    result = []
    if not np.isfinite(bench.moment[of_joint]).any():
        text = f"blocked force of joint {name} {at_top}, on a luggage scale {1e3 * ARM:g} mm from its middle"
        result.append(Candidate(text, force, KINDS["moment"].sd, "N"))
    if not np.isfinite(bench.shortening[of_joint]).any():
        text = f"shortening of joint {name}, {BOTH} sides {at_top}, by ruler"
        result.append(
            Candidate(text, partial(_both_shorter, joint=joint, pressure=top), KINDS["shortening"].sd, "mm", 1e3)
        )
    return result


def open_quantities(described: Robot, bench: Bench) -> list[Candidate]:
    """Return quantities that the bench does not measure, for each of its joints at the joint's highest pressure."""
    return [candidate for joint in bench.joints for candidate in _open(described, bench, joint)]


def _open(described: Robot, bench: Bench, joint: int) -> list[Candidate]:
    """Return quantities of a joint, at its highest pressure, that the bench does not measure."""
    top = float(bench.pressure[bench.joint == joint].max())
    rows_at_top = (bench.joint == joint) & (bench.pressure == top)
    both_sides = bench.side == len(SIDES)
    name = f"of joint {described.joints[joint].name}"

    def lacks(kind: str, rows: NDArray[np.bool_] = ~both_sides) -> bool:
        return not np.isfinite(getattr(bench, kind)[rows_at_top & rows]).any()

    def entry(text: str, function: Callable[[Robot, int, float], float], unit: str, factor: float = 1.0) -> Candidate:
        return Candidate(text, lambda robot: function(robot, joint, top), 0.0, unit, factor)

    at_top = f"{name} at {top / 1e3:g} kPa"
    return [
        *[entry(f"blocked moment {at_top}", blocked_moment, "N m")] * lacks("moment"),
        *[entry(f"bend {at_top}", _angle, "deg", 180 / math.pi)] * lacks("angle"),
        *[entry(f"shortening {at_top}", _shorter, "mm", 1e3)] * lacks("shortening"),
        *[entry(f"shortening by both sides {at_top}", _both_shorter, "mm", 1e3)] * lacks("shortening", both_sides),
        *[entry(f"oil volume {at_top}", _volume, "ml", 1e6)] * lacks("volume"),
        entry(f"moment per bend {name} without pressure", _stiffness, "N m/rad"),
    ]


def _angle(robot: Robot, joint: int, pressure: float) -> float:
    """Return the bend of a joint [rad] with its left side under pressure [Pa]."""
    return float(bend(robot, joint, [pressure]).angle[0])


def _shorter(robot: Robot, joint: int, pressure: float) -> float:
    """Return the shortening of a joint [m] with its left side under pressure [Pa]."""
    return float(bend(robot, joint, [pressure]).shortening[0]) * joint_group(robot, joint)[1].length


def _both_shorter(robot: Robot, joint: int, pressure: float) -> float:
    """Return the shortening of a joint [m] with both sides under pressure [Pa]."""
    return float(shortening(robot, joint, np.array([pressure]))[0])


def _volume(robot: Robot, joint: int, pressure: float) -> float:
    """Return the oil [m^3] that the left side of a joint takes in under pressure [Pa]."""
    return float(bend(robot, joint, [pressure]).volume[0])


def _stiffness(robot: Robot, joint: int, pressure: float) -> float:
    """Return the moment per bend of a joint without pressure [N m/rad]."""
    return joint_models(robot)[joint].stiffness


def _of_joint(described: Robot, bench: Bench, joint: int) -> list[Candidate]:
    """Return measurements of a joint: sizes, stiffness, and what the bench lacks of oil volume and bends."""
    name, of_joint = described.joints[joint].name, bench.joint == joint
    top = float(bench.pressure[of_joint].max())

    def lever(robot: Robot) -> float:
        return joint_group(robot, joint)[1].lever

    def length(robot: Robot) -> float:
        return joint_group(robot, joint)[1].segment_length[0]

    stiffness, volume = (partial(function, joint=joint, pressure=top) for function in (_stiffness, _volume))
    result = [
        Candidate(f"lever of joint {name}, cut open", lever, RULER, "mm", 1e3),
        Candidate(f"segment length of joint {name}, cut open", length, RULER, "mm", 1e3),
        Candidate(f"moment per bend of joint {name} without pressure", stiffness, -BENDING_TEST, "N m/rad"),
    ]
    if not np.isfinite(bench.volume[of_joint]).any():
        text = f"oil volume of joint {name} at {top / 1e3:g} kPa, by syringe"
        result.append(Candidate(text, volume, -SYRINGE, "ml", 1e6))
    for side, word in enumerate(SIDES):
        rows = of_joint & (bench.side == side) & np.isfinite(bench.angle)
        for unload, branch in ((False, "loading"), (True, "unloading")):
            if not (rows & (bench.unload == unload)).any() and not (unload and not rows.any()):
                pressure = top / 2 if unload else top
                text = f"{word} bend of joint {name}, {branch}, at {pressure / 1e3:g} kPa"
                angle = partial(_bend, joint, word, sorted({pressure, top}), unload)
                result.append(Candidate(text, angle, GONIOMETER, "deg", 180 / math.pi))
    return result


def _of_unit(name: str, robot: Robot) -> float:
    """Return the attribute of the drive unit that a name stands for [SI]."""
    return float(getattr(drive_unit(robot), name))


def _relative(material: str, described: float, robot: Robot) -> float:
    """Return the modulus of a silicone over its described modulus [1]."""
    return mooney(robot, material).modulus / described


def _bend(joint: int, side: str, pressure: list[float], unload: bool, robot: Robot) -> float:
    """Return the bend [rad] at the highest of rising pressures [Pa], or after unloading to the lowest of them."""
    curve = bend(robot, joint, pressure, side=side, unload=unload)
    return float((curve.angle if curve.unload_angle is None else curve.unload_angle)[-1])


def _pull(robot: Robot, pressure: float, stretch: float) -> float:
    """Return the pull of one drive unit without friction [N] at a pressure [Pa] and a stretch."""
    return float(np.asarray(muscle(robot).at(np.array([stretch]), pressure=pressure)["pull"])[0])


def _contraction(robot: Robot, pressure: float) -> float:
    """Return the free contraction of a drive unit [1] at a pressure [Pa]: that at which it no longer pulls."""
    from scipy.optimize import brentq

    neutral = math.cos(NEUTRAL_BRAID) / math.cos(drive_unit(robot).braid_angle)  # stretch where pressure stops pulling
    return 1 - float(brentq(lambda stretch: _pull(robot, pressure, stretch), neutral, 1.0, xtol=1e-13))
