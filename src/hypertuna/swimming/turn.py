"""Turns: circles of settled beats with a bias, over phase, bias and frequency."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.pose import Points
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.swimming.beat import DEFAULT_STEPS, STATUSES
from hypertuna.swimming.gait import Gait, Gaits
from hypertuna.swimming.sweep import sweep
from hypertuna.swimming.swim import Swim, swim
from hypertuna.swimming.trajectory import center_of, nose_points

if TYPE_CHECKING:
    import xarray as xr

MAX_BEATS = 120  # most beats of a path; a gait that turns by 3 degrees per beat completes its circle
POINTS_PER_BEAT = 32  # points of a path per beat
PHASE = math.radians(0.05)  # tolerance of the phase of the tightest turn


@dataclass(frozen=True)
class Circle:
    """A circle fitted to points."""

    center: complex  # x + i y [m]
    radius: float  # [m]
    residual: float  # root mean square of the points' distances from the circle [m]


@dataclass(frozen=True)
class Tightest:
    """The tightest turn of a grid, and the tightest turn between its neighbors in phase."""

    gait: Gait  # gait of the grid with the tightest turn
    turn_radius: float  # mean distance of the nose from the center of the turn [m]
    speed: float  # forward positive [m/s]
    circle: Circle  # circle fitted to the nose's path
    phase_between: float  # phase of the last joint group with the smallest radius, between the grid's neighbors [rad]
    turn_radius_between: float  # turn radius at `phase_between` [m]


@dataclass(frozen=True)
class Turning(Plotted, Tabular, data=lambda turning: turning.sweep):
    """Turns of a grid of gaits."""

    robot: Robot
    gaits: Gaits  # the grid
    sweep: xr.Dataset  # results of `sweep`, with circle_radius and circle_residual [m] of each path, NaN if unsettled
    tightest: Tightest | None  # tightest turn of all settled gaits; None if no gait turns
    forward: Tightest | None  # tightest turn head first; None if no gait turns so


def fit_circle(points: Points) -> Circle:
    """Fit a circle to points: algebraically, then by least squares of the points' distances from the circle.

    The algebraic fit is Taubin's (1991), unbiased on short arcs where Kasa's is not; it starts a Levenberg-Marquardt
    search for the center (x, y) and the radius R that minimize the sum of (abs(p - center) - R)^2.

    `points` (K,) [m]; returns [m].
    """
    from scipy.optimize import least_squares

    z = np.asarray(points, dtype=np.complex128)
    if z.ndim != 1 or len(z) < 3 or not np.isfinite(z).all():
        raise InputError("must be at least three finite points", key="points", fix="give x + i y of a path")
    middle = complex(z.mean())
    size = float(np.sqrt(np.mean(np.abs(z - middle) ** 2)))
    if size == 0:
        return Circle(middle, 0.0, 0.0)
    w = (z - middle) / size
    first = _taubin(w)
    if first is None:
        spread = np.linalg.svd(np.column_stack([w.real, w.imag]), compute_uv=False)[1] / math.sqrt(len(w))
        return Circle(complex(math.nan, math.nan), math.inf, float(spread) * size)
    fit = least_squares(lambda c: np.abs(w - complex(c[0], c[1])) - c[2], first, method="lm", xtol=1e-14, ftol=1e-14)
    x, y, radius = fit.x
    return Circle(middle + size * complex(x, y), size * abs(radius), size * float(np.sqrt(np.mean(fit.fun**2))))


def nose_path(beat: Swim) -> Points:
    """Return the nose's path (points,) [m], a settled beat continued until the nose completes its circle."""
    beats = math.ceil(2 * math.pi * beat.gait.frequency / abs(beat.turn_rate)) if beat.turn_rate else MAX_BEATS
    motion = beat.continued(min(beats, MAX_BEATS))
    stride = max(1, beat.steps // POINTS_PER_BEAT)
    return nose_points(motion)[:-1:stride]


def point_radius(beat: Swim, behind: float) -> float:
    """Return the mean distance [m] from the center of the turn to the point of the head `behind` [m] the nose."""
    motion = beat.trajectory
    direction = np.exp(1j * motion.heading.values)
    return float(np.abs(nose_points(motion) + behind * direction - center_of(motion))[:-1].mean())


@checked
def turn(
    robot: Robot | str | Path,
    gaits: Gaits,
    *,
    threads: int | None = None,
    steps: int = DEFAULT_STEPS,
    progress: Callable[[int, int], None] | None = None,
) -> Turning:
    """Swim the turns of a grid of gaits, and fit circles to their paths.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    gaits : Gaits
        A grid of frequency, amplitude, phase and bias.
    threads, steps, progress
        As of `sweep`.

    Returns
    -------
    Turning
    """
    robot = robot_of(robot)
    if not gaits.is_grid:
        raise InputError("must be a grid", key="gaits", fix="make them by Gaits.grid")
    results = sweep(robot, gaits, threads=threads, steps=steps)
    radius, residual = np.full(len(gaits), math.nan), np.full(len(gaits), math.nan)
    settled, radii = (results[name].values.ravel() for name in ("settled", "turn_radius"))
    for k in range(len(gaits)):
        if settled[k] and math.isinf(radii[k]):
            radius[k] = math.inf
        elif settled[k] and not math.isnan(radii[k]):
            circle = fit_circle(nose_path(swim(robot, gaits[k], steps=steps)))
            radius[k], residual[k] = circle.radius, circle.residual
        if progress is not None:
            progress(k + 1, len(gaits))
    dims = results.turn_radius.dims
    for name, values, text in (
        ("circle_radius", radius, "radius of the circle fitted to the path"),
        ("circle_residual", residual, "rms distance of the nose from that circle"),
    ):
        results[name] = (dims, values.reshape(gaits.shape), {"units": "m", "long_name": text})
    turns = settled & np.isfinite(radii)
    forward = turns & (results.speed.values.ravel() > 0)
    best, first = (_tightest(robot, gaits, radii, among, steps) for among in (turns, forward))
    return Turning(robot, gaits, results, best, first)


def tightest(robot: Robot, gait: Gait, *, low: float, high: float, steps: int = DEFAULT_STEPS) -> tuple[float, float]:
    """Find the phase of the last joint group with the tightest turn, head or tail first as the gait swims.

    `low`, `high`: range of the phase [rad]; returns the phase [rad] and the turn radius [m].
    """
    from scipy.optimize import minimize_scalar

    forward = swim(robot, gait, steps=steps).speed > 0

    def radius(phase: float) -> float:
        beat = swim(robot, replace(gait, phase=(*gait.phase[:-1], float(phase))), steps=steps)
        valid = beat.settled and (beat.speed > 0) == forward
        return min(beat.turn_radius, 1e3 * robot.body.length) if valid else 1e3 * robot.body.length

    search = minimize_scalar(radius, bounds=(low, high), method="bounded", options={"xatol": PHASE})
    start_radius = radius(gait.phase[-1])
    return (float(search.x), float(search.fun)) if search.fun < start_radius else (gait.phase[-1], start_radius)


def _taubin(w: Points) -> Array | None:
    """Return x, y and radius of an algebraic fit to centered points of unit size; None for points on a line."""
    square = np.abs(w) ** 2
    mean = float(square.mean())
    columns = np.column_stack([(square - mean) / (2 * math.sqrt(mean)), w.real, w.imag])
    _, _, axes = np.linalg.svd(columns, full_matrices=False)
    a, b, c = axes[2]
    a /= 2 * math.sqrt(mean)
    d = -mean * a
    if abs(a) < 1e-12:
        return None
    return np.array([-b / (2 * a), -c / (2 * a), math.sqrt(b * b + c * c - 4 * a * d) / abs(2 * a)])


def _tightest(robot: Robot, gaits: Gaits, radius: Array, among: NDArray[np.bool_], steps: int) -> Tightest | None:
    """Return the tightest turn of the gaits `among` in a grid, refined in phase; None without gaits."""
    if not among.any():
        return None
    k = int(np.where(among, radius, math.inf).argmin())
    gait = gaits[k]
    beat = swim(robot, gait, steps=steps)
    assert beat.status == STATUSES[0]
    phases = np.unique(gaits.phase[:, -1])
    index = int(np.searchsorted(phases, gait.phase[-1]))
    low, high = phases[max(index - 1, 0)], phases[min(index + 1, len(phases) - 1)]
    phase, smallest = gait.phase[-1], beat.turn_radius
    if high > low:
        phase, smallest = tightest(robot, gait, low=float(low), high=float(high), steps=steps)
    return Tightest(gait, beat.turn_radius, beat.speed, fit_circle(nose_path(beat)), phase, smallest)
