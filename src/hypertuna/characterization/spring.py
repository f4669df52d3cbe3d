"""Spring of a hinge from a bench test: loads on the fin in air, and the angles to which they bend it.

The robot lies on its side, so that the hinge's axis is level. A mass m hung at the distance a from the axis bends the
fin until m g a cos(angle + tilt) = stiffness x + cubic x^3, where x = angle - zero, and tilt is the fin's angle below
the horizontal without a load. The fin's own weight shifts the zero and nothing else, as long as the angles are small.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.characterization.unknowns import sourced
from hypertuna.description.changes import changed
from hypertuna.description.robot import Robot
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, shown
from hypertuna.io.door import RUNS
from hypertuna.io.tables import parse_float, read_table
from hypertuna.ranges import Range, check_name

ARM, ANGLE = "arm_m", "angle_deg"
LOADS = {  # ranges of the columns of loads: larger numbers are in another unit
    "mass_kg": Range(min=0, max=100, unit="kg"),
    "force_n": Range(min=-1000, max=1000, unit="N"),
    "moment_n_m": Range(min=-1000, max=1000, unit="N m"),
}
HUNG = "mass_kg"  # the load that keeps its direction, down, while the fin turns
COLUMNS = (*LOADS, ARM, ANGLE)
ARMS, ANGLES = Range(above=0, max=10, unit="m"), Range(above=-90, below=90, unit="deg")
ROWS_MIN, ROWS_CUBIC = 3, 5  # fewest rows for a fit, and for a cubic term
SIGNIFICANT = 0.01  # a cubic term is kept if chance would explain its gain less often than this
EXACT = 1e-9  # rad: residuals below this are of rounding
SLOPE_MIN = 0.1  # least change of the residual with the angle


@dataclass(frozen=True)
class SpringTest:
    """Loads on a fin and the angles to which they bend it."""

    load: Array  # (rows,) N m: moment, of a hung mass at a level fin
    hung: NDArray[np.bool_]  # whether the moment falls with the cosine of the angle
    angle: Array  # (rows,) rad, from the fin without a load
    file: str


@dataclass(frozen=True)
class SpringFit(Plotted, Tabular, data=lambda fit: fit.rows):
    """A spring fitted to a bench test by least squares of the angles, with 95 % intervals of the t distribution."""

    test: SpringTest
    tilt: float  # rad, of the fin below the horizontal without a load
    stiffness: float  # N m/rad
    stiffness_sd: float  # N m/rad
    stiffness_interval: tuple[float, float]  # N m/rad
    zero: float  # rad, angle without a load
    zero_interval: tuple[float, float]  # rad
    cubic: float  # N m/rad^3, 0 if not significant
    cubic_interval: tuple[float, float]  # N m/rad^3, NaN without a cubic term
    residual: Array  # (rows,) rad, measured minus computed angle
    rms_straight: float  # rad, of the residuals without a cubic term
    chance: float  # probability that chance explains the gain by a cubic term (F test); NaN if not tested
    softens: bool  # whether a significant cubic term is negative; it is not kept

    @property
    def rms(self) -> float:
        """Root mean square of the residuals [rad]."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Moment, measured angle and residual of each row."""
        columns = (moments(self.test, self.tilt), np.degrees(self.test.angle), np.degrees(self.residual))
        names = ("moment_n_m", ANGLE, "residual_deg")
        return [dict(zip(names, row, strict=True)) for row in np.transpose(columns).tolist()]


def moments(test: SpringTest, tilt: float) -> Array:
    """Return the moments of the loads at the measured angles (rows,) [N m]."""
    return test.load * np.where(test.hung, np.cos(test.angle + tilt), 1.0)


def read_spring(path: str | Path, *, arm: float | None = None) -> SpringTest:
    """Read a bench test from a CSV file; `arm` [m] is that of rows without their own."""
    if arm is not None:
        ARMS.check(arm, "arm", "give the distance from the hinge's axis to the load in m")
    table = read_table(path, RUNS)
    table.keys({c: c for c in COLUMNS}, {ANGLE: ANGLE}, fix=f"add it; columns are {', '.join(COLUMNS)}")
    if not set(table.head) & LOADS.keys():
        raise InputError("must have a column of loads", file=table.file, fix=f"add one of {', '.join(LOADS)}")
    rows = table.parse(lambda line, cells: _row(cells, arm), names={c: c for c in COLUMNS})
    load, hung, angle = zip(*rows, strict=True)
    return SpringTest(np.array(load), np.array(hung), np.array(angle), table.file)


def _row(cells: Mapping[str, str], arm: float | None) -> tuple[float, bool, float]:
    """Return the load of a row [N m], whether it hangs, and its angle [rad]; errors name the column."""
    given = [key for key in LOADS if cells.get(key)]
    if len(given) != 1:
        value, fix = " and ".join(given) or "none", f"give one of {', '.join(LOADS)}"
        raise InputError("must have one load", value=value, fix=fix)
    key = given[0]
    load = _number(cells, key, LOADS[key], f"give it in {LOADS[key].unit}")
    if key != "moment_n_m":
        if not cells.get(ARM) and arm is None:
            raise InputError("must be given with a mass or a force", key=ARM, value="empty", fix="or give --arm in m")
        own = _number(cells, ARM, ARMS, "give it in m") if cells.get(ARM) else None
        load *= (arm if own is None else own) or 0.0
    return (
        load * (_core.GRAVITY if key == HUNG else 1.0),
        key == HUNG,
        math.radians(_number(cells, ANGLE, ANGLES, None)),
    )


def _number(cells: Mapping[str, str], key: str, limits: Range, fix: str | None) -> float:
    """Return the number in a cell, within limits."""
    value = parse_float(cells[key])
    if not math.isfinite(value):
        raise InputError("must be a finite number", key=key, value=shown(cells[key]) if cells[key] else "empty")
    return limits.check(value, key, fix)


def fit_spring(test: SpringTest, *, tilt: float = 0.0) -> SpringFit:
    """Fit stiffness and zero to a bench test by least squares of the angles; a cubic term only if significant."""
    from scipy import stats

    ANGLES.check(math.degrees(tilt), "tilt", "give the fin's angle below the horizontal without a load")
    count, largest = len(test.angle), float(np.abs(test.load).max(initial=0.0))
    if count < ROWS_MIN:
        fix = "hang more weights"
        raise InputError(f"must have {ROWS_MIN} rows", file=test.file, value=f"{count}", fix=fix)
    if np.ptp(test.load) == 0:
        raise InputError("must have different loads", file=test.file, value="one", fix="hang several weights")
    if (np.abs(test.angle + tilt)[test.hung] >= math.pi / 2).any():
        rule, fix = "must bend the fin less than straight down", "hang smaller weights, or check the tilt"
        raise InputError(rule, file=test.file, key=ANGLE, fix=fix)
    found, covariance, residual = straight = _search(test, tilt, largest, 2)
    rms, chance, softens = float(np.sqrt(np.mean(residual**2))), math.nan, False
    if count >= ROWS_CUBIC and rms > EXACT:
        hardened = _search(test, tilt, largest, 3)
        left = float(np.sum(hardened[2] ** 2))
        ratio = max(count * rms**2 - left, 0.0) * (count - 3)
        chance = float(stats.f.sf(ratio / left, 1, count - 3)) if left > 0 else 0.0
        softens = chance < SIGNIFICANT and bool(hardened[0][2] < 0)
        found, covariance, residual = straight if chance >= SIGNIFICANT or softens else hardened
    if found[1] <= 0:
        rule, fix = "must grow with the load", "count angles positive the way the load pulls, and check the rows"
        raise InputError(rule, file=test.file, key=ANGLE, fix=fix)
    bend, sd = float(found[1]), np.sqrt(np.diag(covariance))
    half, stiffness = float(stats.t.ppf(0.975, count - len(found))), largest / bend
    softest, stiffest = bend + half * sd[1], bend - half * sd[1]
    cubic, spread = 0.0, math.nan
    if len(found) == 3:
        cubic = stiffness * float(found[2])
        slope = np.array([0.0, -cubic / bend, stiffness])
        spread = half * float(np.sqrt(slope @ covariance @ slope))
    return SpringFit(
        test=test,
        tilt=tilt,
        stiffness=stiffness,
        stiffness_sd=stiffness * float(sd[1]) / bend,
        stiffness_interval=(largest / softest, largest / stiffest if stiffest > 0 else math.inf),
        zero=float(found[0]),
        zero_interval=(float(found[0] - half * sd[0]), float(found[0] + half * sd[0])),
        cubic=cubic,
        cubic_interval=(cubic - spread, cubic + spread),
        residual=residual,
        rms_straight=rms,
        chance=chance,
        softens=softens,
    )


def _search(test: SpringTest, tilt: float, largest: float, count: int) -> tuple[Array, Array, Array]:
    """Return the fitted unknowns (count,), their covariance and the residuals (rows,) [rad].

    The unknowns are the zero [rad], the bend by the largest load [rad], and cubic over stiffness [1/rad^2]. A residual
    is the distance of a measured angle from equilibrium: the imbalance over its slope.
    """
    from scipy.optimize import least_squares

    parts = moments(test, tilt) / largest
    across = np.where(test.hung, test.load / largest * np.sin(test.angle + tilt), 0.0)

    def residual(unknowns: Array) -> Array:
        zero, bend, ratio = (*unknowns, 0.0)[:3]
        x = test.angle - zero
        return np.asarray(
            (x + ratio * x**3 - bend * parts) / np.maximum(1 + 3 * ratio * x**2 + bend * across, SLOPE_MIN)
        )

    start = np.polynomial.polynomial.polyfit(parts, test.angle, 1)
    fit = least_squares(residual, [*start, 0.0][:count], method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    covariance = np.linalg.pinv(fit.jac.T @ fit.jac) * np.sum(fit.fun**2) / (len(fit.fun) - count)
    return fit.x, covariance, fit.fun


def with_spring(robot: Robot, fit: SpringFit, hinge: str | None = None) -> Robot:
    """Return a robot with the fitted spring at a hinge, and the bench test as its source; hinge: see `hinge_of`."""
    d = hinge_of(robot, hinge)
    place, cubic = robot.hinge_keys[d], robot.hinges[d].cubic
    values = {f"{place}.stiffness_n_m_per_rad": fit.stiffness}
    values |= {f"{place}.cubic_n_m_per_rad3": fit.cubic} if fit.cubic or cubic else {}
    low, high = fit.stiffness_interval
    text = f"bench test, {len(fit.test.angle)} weights of {fit.test.file}: 95 % from {low:.3g} to {high:.3g} N m/rad"
    if len(robot.hinges) > 1:  # a source is of the tables of all hinges
        text = f"of the hinge of {robot.links.name[robot.hinges[d].link]}: {text}; others as before"
    return sourced(changed(robot, values), robot, {re.sub(r"\[\d+\]", "", key): text for key in values})


def hinge_of(robot: Robot, name: str | None) -> int:
    """Return the index of a hinge by the link behind it, or its number from the head; None: the only one."""
    links = [robot.links.name[hinge.link] for hinge in robot.hinges]
    if not links:
        fix = "name a robot with [hinge]: robot new --tail passive writes one"
        raise InputError("must have a hinge", file=robot.file or None, value="without", fix=fix)
    if name is None and len(links) > 1:
        fix = f"name the link behind it, {', '.join(links)}, or its number from the head"
        raise InputError("must be given for a robot with several", key="--hinge", value="missing", fix=fix)
    numbers = {f"{d + 1}": d for d in range(len(links))} | {link: d for d, link in enumerate(links)}
    check_name(name or "1", numbers, "--hinge", "hinge", f"hinges are in front of {', '.join(links)}")
    return numbers[name or "1"]
