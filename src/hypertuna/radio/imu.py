"""Calibrate accelerometer, gyroscope and compass from counts in the robot's axes: x to the tail, y starboard, z up.

While the robot is turned in a constant field (gravity or the Earth's magnetic field), the counts lie on an ellipsoid.
The fit maps it to a sphere, |scale (counts - zero)| = field, by robust least squares. Samples that do not determine
zero and scale are refused.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.radio.calibration import Calibration

AXES = "xyz"  # names of the axes
SAMPLES_MIN = 20  # least number of samples of a calibration
SCATTER_MAX = {"compass": 0.05, "accelerometer": 0.02}  # largest rms of the residuals, as a fraction of the field
ERROR_MAX = 0.02  # largest standard error of a zero, as a fraction of the field: 1 deg
RATIO_MAX = 1.5  # of two axes' scales: a larger one is no soft iron, but a faulty sensor or samples in a plane
COVERED_MIN = 10  # directions, of a dodecahedron's 12 faces, that samples of the compass must cover
STILL_MAX = 0.02  # rad/s: largest standard deviation of a gyroscope at rest
CREEP_MAX = 0.005  # rad/s: largest change of its mean from the first to the second half of the samples
DIP_SPREAD_MAX = math.radians(10)  # largest standard deviation of the angle between field and horizon
ALONG_MIN = math.cos(math.radians(25))  # smallest fraction of gravity along an axis that is held up or down

GOLDEN = (1 + math.sqrt(5)) / 2  # golden ratio
FACES = np.array(  # unit vectors through the faces of a dodecahedron, (12, 3)
    [np.roll((0.0, a, b * GOLDEN), k) for k in range(3) for a in (-1, 1) for b in (-1, 1)]
) / math.hypot(1, GOLDEN)


class Position(NamedTuple):
    """A position of the robot while the accelerometer is calibrated."""

    text: str
    up: tuple[int, int, int] | None  # readings of x, y, z in units of gravity; None: an oblique position, as a check


POSITIONS = (  # in the order of the calibration
    Position("level", (0, 0, 1)),
    Position("on its back", (0, 0, -1)),
    Position("on its port side", (0, 1, 0)),
    Position("on its starboard side", (0, -1, 0)),
    Position("nose up", (-1, 0, 0)),
    Position("nose down", (1, 0, 0)),
    Position("nose half up", None),
    Position("rolled half to starboard", None),
    Position("rolled half to port, nose half down", None),
)


@dataclass(frozen=True)
class Sphere:
    """Zero and scale that turn an axis-aligned ellipsoid of counts into a sphere of readings."""

    zero: Array  # (3,) [counts]
    scale: Array  # (3,) [SI per count]
    rms: float  # rms difference between the readings' norm and the field [SI]
    error: float  # standard error of the least certain zero [SI]

    def readings(self, counts: Array) -> Array:
        """Return the readings (n, 3) [SI] of counts (n, 3)."""
        values: Array = self.scale * (counts - self.zero)
        return values


def fit_sphere(counts: Array, field: float) -> Sphere | None:
    """Fit zero and scale of three axes to counts (n, 3) in a field [SI]; None if the samples do not determine them."""
    midpoint = (counts.max(axis=0) + counts.min(axis=0)) / 2
    half_range = np.ptp(counts, axis=0) / 2
    if not (half_range > 0).all():
        return None
    scaled = (counts - midpoint) / half_range
    rows = np.hstack([scaled**2, scaled])
    coefficients, _, rank, _ = np.linalg.lstsq(rows, np.ones(len(rows)), rcond=1e-6)
    if rank < 6 or not (coefficients[:3] > 0).all():
        return None
    # Solution of sum(a x^2 + d x) = 1: the center is -d / (2 a), and sum a (x - center)^2 = 1 + sum d^2 / (4 a).
    center = -coefficients[3:] / (2 * coefficients[:3])
    size = np.sqrt(coefficients[:3] / (1 + coefficients[:3] @ center**2))

    def residuals(p: Array) -> Array:
        error: Array = np.linalg.norm(p[3:] * (scaled - p[:3]), axis=1) - 1
        return error

    fit = least_squares(residuals, np.concatenate([center, size]), loss="soft_l1", f_scale=0.02)
    center, size = fit.x[:3], np.abs(fit.x[3:])
    freedom = len(scaled) - 6
    errors = residuals(fit.x)
    try:
        covariance = np.linalg.inv(fit.jac.T @ fit.jac) * (errors @ errors) / max(1, freedom)
    except np.linalg.LinAlgError:
        return None
    error = float(np.max(np.sqrt(np.diag(covariance)[:3]) * size))
    rms = math.sqrt(float(errors @ errors) / max(1, freedom))
    return Sphere(midpoint + half_range * center, field * size / half_range, field * rms, field * error)


def covered(directions: Array) -> int:
    """Return how many of a dodecahedron's faces are hit by vectors (n, 3) from its center."""
    return len(set(np.argmax(directions @ FACES.T, axis=1)))


def calibrate_compass(counts: Array, acceleration: Array | None = None) -> Calibration:
    """Fit the compass to counts (n, 3) of a robot that is turned in all directions; the field's strength becomes 1.

    acceleration: readings (n, 3) [m/s^2]. If given, the field's angle to gravity must be constant; it is not if the
    axes of the two sensors differ.
    """
    sphere = _fit("compass", counts, 1.0, "turn it nose up, nose down, on both sides and on its back, far from iron")
    readings = sphere.readings(counts)
    if (faces := covered(readings)) < COVERED_MIN:
        fix = "keep turning it nose up, nose down, on both sides and on its back, in several headings"
        raise InputError("must be turned in all directions", key="compass", value=f"turned in {_share(faces)}", fix=fix)
    notes = [f"{_share(faces)} are covered"]
    if acceleration is not None:
        notes.append(_dip_sentence(readings, acceleration))
    return _sphere_calibration("compass", "field", sphere, len(counts), notes)


def _share(faces: int) -> str:
    return f"{faces} of {len(FACES)} directions"


def _dip_sentence(field: Array, acceleration: Array) -> str:
    """Check that the field's angle to gravity is constant in samples without jerks; return a sentence with the dip."""
    norm = np.linalg.norm(acceleration, axis=1)
    calm = np.abs(norm - _core.GRAVITY) < 0.1 * _core.GRAVITY
    if np.count_nonzero(calm) < SAMPLES_MIN:
        fix = "turn it more slowly, and calibrate the accelerometer first"
        value = f"calm in only {np.count_nonzero(calm)} of {len(calm)} samples"
        raise InputError("must be turned without jerks", key="compass", value=value, fix=fix)
    sine = np.sum(field[calm] * acceleration[calm], axis=1) / norm[calm] / np.linalg.norm(field[calm], axis=1)
    dip = -np.arcsin(np.clip(sine, -1, 1))
    if (spread := float(np.std(dip))) > DIP_SPREAD_MAX:
        rule, value = "must read the field at a constant angle to gravity", f"off by {math.degrees(spread):.0f} deg rms"
        fix = "check that compass and accelerometer have the same axes, and how the IMU is mounted"
        raise InputError(rule, key="compass", value=value, fix=fix)
    return f"the field dips by {math.degrees(float(np.mean(dip))):.0f} +- {math.degrees(spread):.0f} deg"


def calibrate_accelerometer(means: Mapping[Position, Array]) -> Calibration:
    """Fit the accelerometer to its mean counts (3,) in each of POSITIONS."""
    counts = np.array([means[position] for position in POSITIONS])
    sphere = _fit("accelerometer", counts, _core.GRAVITY, "hold it still in each position, and check the IMU's wires")
    for position, reading in zip(POSITIONS, sphere.readings(counts), strict=True):
        if position.up is not None and reading @ np.array(position.up) < ALONG_MIN * _core.GRAVITY:
            measured = ", ".join(f"{AXES[k]} {value / _core.GRAVITY:.1f}" for k, value in enumerate(reading))
            fix = "hold it as asked, or mount the IMU with x to the tail, y to starboard and z up"
            rule = f"must read gravity along {_axis_text(position.up)} when the robot is held {position.text}"
            raise InputError(rule, key="accelerometer", value=f"{measured} g", fix=fix)
    return _sphere_calibration("accelerometer", "accel", sphere, len(counts), [])


def _axis_text(up: Sequence[int]) -> str:
    k = int(np.argmax(np.abs(up)))
    return f"{'+' if up[k] > 0 else '-'}{AXES[k]}"


def calibrate_gyroscope(counts: Array, scale: Array) -> Calibration:
    """Return the zeros of a gyroscope at rest, from counts (n, 3) and its scale (3,) [rad/s per count]."""
    _check_count("gyroscope", counts)
    readings = counts * scale
    spread = float(np.max(np.std(readings, axis=0)))
    half = len(readings) // 2
    creep = float(np.max(np.abs(readings[:half].mean(axis=0) - readings[half:].mean(axis=0))))
    if spread > STILL_MAX or creep > CREEP_MAX:
        value = f"turning by {max(spread, creep):.3g} rad/s"
        raise InputError("must be at rest", key="gyroscope", value=value, fix="put the robot on a table, and let go")
    zero = counts.mean(axis=0)
    return Calibration("gyroscope", {f"rate_zero_{k}": float(zero[k]) for k in range(3)}, spread, len(counts))


def _check_count(sensor: str, counts: Array) -> None:
    if len(counts) < SAMPLES_MIN:
        value, fix = f"limited to {len(counts)}", "move closer to the robot, and wait longer"
        raise InputError(f"must have at least {SAMPLES_MIN} samples", key=sensor, value=value, fix=fix)


def _fit(sensor: str, counts: Array, field: float, fix: str) -> Sphere:
    """Fit the sphere to counts (n, 3) in a field [SI]; raise an InputError if they do not determine it well enough."""
    if sensor == "compass":
        _check_count(sensor, counts)
    sphere = fit_sphere(counts, field)
    if sphere is None or sphere.scale.max() > RATIO_MAX * sphere.scale.min():
        value = "undetermined (the samples lie in a plane, or the sensor is faulty)"
        raise InputError("must get samples that determine all axes", key=sensor, value=value, fix=fix)
    if sphere.rms > SCATTER_MAX[sensor] * field:
        value = f"off by {100 * sphere.rms / field:.1f} % rms"
        raise InputError("must read a field of constant strength", key=sensor, value=value, fix=fix)
    if sphere.error > ERROR_MAX * field:
        value = f"uncertain by {100 * sphere.error / field:.1f} % of the field"
        raise InputError("must get samples that determine its zeros", key=sensor, value=value, fix=fix)
    return sphere


def _sphere_calibration(sensor: str, name: str, sphere: Sphere, points: int, notes: Sequence[str]) -> Calibration:
    parameters = {f"{name}_zero_{k}": float(sphere.zero[k]) for k in range(3)}
    parameters |= {f"{name}_scale_{k}": float(sphere.scale[k]) for k in range(3)}
    return Calibration(sensor, parameters, sphere.rms, points, tuple(notes))
