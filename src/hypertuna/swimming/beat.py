"""Settled beats of many gaits: the core's rows, turned into quantities with names and a verdict."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna import _core, metrics
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model

DEFAULT_STEPS = _core.BEAT_STEPS  # Runge-Kutta steps per beat: 8e-7 of the speed, 2e-6 of the power
MAX_BEATS = _core.NEWTON_BEATS  # of each stage of Newton's method
APPROACH = _core.APPROACH_BEATS  # beats at most in which a start from rest is followed toward a settled beat
AFTER = 200  # beats from rest after which the search for what it leads to begins: slow transients have chosen
NEUTRAL = _core.NEUTRAL  # a body that stands still keeps a disturbance as it is: its multipliers are 1 but for rounding
STRAIGHT = _core.STRAIGHT  # body lengths: a larger turning radius is no turn

STATUSES = tuple(_core.beat_statuses())


class Meaning(NamedTuple):
    """Unit and meaning of a result."""

    unit: str
    meaning: str


QUANTITIES = {
    "speed": Meaning("m/s", "mean speed along the path through the water, forward positive; NaN for a body that spins"),
    "speed_bl": Meaning("1/s", "speed in body lengths per second"),
    "mechanical_power": Meaning("W", "mean mechanical power of all joints"),
    "mechanical_power_positive": Meaning("W", "mean mechanical power, negative power of a joint group counted as zero"),
    "power_to_water": Meaning("W", "mean power that the water takes"),
    "cost_of_transport": Meaning("J/(kg m)", "mechanical power per mass and speed"),
    "cost_of_transport_positive": Meaning("J/(kg m)", "the same of the positive power"),
    "efficiency": Meaning("1", "power to tow the straight body at this speed over mechanical power"),
    "strouhal": Meaning("1", "frequency times peak-to-peak tail excursion over speed"),
    "stride_length": Meaning("1", "body lengths per beat"),
    "tail_excursion": Meaning("m", "excursion of the tail tip across the mean path, peak to peak"),
    "torque_peak": Meaning("N m", "largest magnitude of any driven joint's torque over the beat"),
    "rate_peak": Meaning("rad/s", "largest rate of any joint group over the beat"),
    "turn_rate": Meaning("rad/s", "mean rate of turn, counter-clockwise"),
    "turn_radius": Meaning(
        "m", "mean distance of the nose from the center of the turn; infinite when straight, NaN for a body that spins"
    ),
    "spectral_radius": Meaning("1", "largest modulus of the monodromy's multipliers: growth of a disturbance per beat"),
    "change_per_beat": Meaning("1", "change of the motion from beat to beat, body lengths or rad"),
    "distance_to_settled": Meaning("1", "distance from the settled motion, over the distance traveled in a beat"),
    "beats": Meaning("1", "beats integrated"),
}
# Of the core's names, those that are others here.
NAMES = {"power": "mechanical_power", "power_positive": "mechanical_power_positive", "loss": "power_to_water"}
NAMES |= {"excursion": "tail_excursion"}


def check_steps(steps: int) -> None:
    """Check a number of steps per beat."""
    if not 8 <= steps <= 8192 or steps % 4:
        raise InputError("must be a multiple of 4 from 8 to 8192", key="steps", value=str(steps), fix="take 128")


_COLUMNS = _core.settle_columns()
_TWIST, _MOMENTUM, _MONODROMY = (_COLUMNS.index(name) for name in ("u", "p_x", "m_00"))
_END = slice(_core.gradient_outputs().index("end_p_x"), None)
_PERIODIC = [STATUSES.index(status) for status in ("settled", "unstable")]


def settle(
    robot: Robot,
    gaits: Gaits,
    *,
    model: _core.Model | None = None,
    steps: int = DEFAULT_STEPS,
    wait: int = -1,
    from_rest: int = -1,
    approach: int = 0,
    threads: int = 1,
) -> dict[str, Any]:
    """Find the settled beats of gaits: quantities, status, twist, momentum and multipliers, (gaits,) each.

    `wait` is the number of beats to swim from rest before the one that counts, -1 to solve for the settled beat: from
    a brisk speed, or from the motion after `from_rest` beats from rest. With `approach`, a start from rest is followed
    toward each settled beat for so many beats at most: "arrived", "approach_beats".
    """
    check_steps(steps)
    model, columns = model or core_model(robot), gaits.columns
    frequency = columns[0]
    rows = _core.settle(
        model,
        *columns,
        steps=steps,
        wait=wait,
        max_beats=MAX_BEATS,
        from_rest=from_rest,
        approach=approach,
        threads=threads,
    )
    row = dict(zip(_COLUMNS, rows.T[:_TWIST], strict=False))
    length, mass = robot.body.length, robot.body.mass
    speed = row["speed"]
    multipliers = _multipliers(rows[:, _MONODROMY : _MONODROMY + 9].reshape(-1, 3, 3))
    radius = np.abs(multipliers).max(axis=1)
    finite = np.isfinite(row["turn"] + row["power"] + row["loss"] + row["residual"])
    finite &= np.isfinite(speed + row["excursion"]) | spins(row["turn"])
    verdict = np.where(row["distance"] < _core.SETTLED_DISTANCE, np.where(radius > NEUTRAL, 2, 0), 1)
    return {
        "speed": speed,
        "speed_bl": metrics.body_lengths_per_second(speed, length),
        "mechanical_power": row["power"],
        "mechanical_power_positive": row["power_positive"],
        "power_to_water": row["loss"],
        "cost_of_transport": metrics.cost_of_transport(row["power"], mass, speed),
        "cost_of_transport_positive": metrics.cost_of_transport(row["power_positive"], mass, speed),
        "efficiency": metrics.efficiency(row["towed_power"], row["power"]),
        "strouhal": metrics.strouhal(frequency, row["excursion"], speed),
        "stride_length": metrics.stride_length(speed, frequency, length),
        "tail_excursion": row["excursion"],
        "torque_peak": row["torque_peak"],
        "rate_peak": row["rate_peak"],
        "turn_rate": row["turn"] * frequency,
        "turn_radius": np.where(row["radius"] >= STRAIGHT * length, np.inf, row["radius"]),
        "spectral_radius": radius,
        "change_per_beat": row["residual"],
        "distance_to_settled": row["distance"],
        "beats": row["beats"],
        "arrived": row["approach"] < _core.ARRIVED_DISTANCE,
        "approach_beats": row["approach_beats"],
        "status": np.where(finite, verdict, 3).astype(np.int8),  # of `STATUSES`
        "twist": rows[:, _TWIST : _TWIST + 3],
        "momentum": rows[:, _MOMENTUM : _MOMENTUM + 3],
        "multipliers": multipliers,
    }


def settle_from_rest(robot: Robot, gaits: Gaits, *, steps: int = DEFAULT_STEPS, threads: int = 1) -> dict[str, Any]:
    """Find the settled beats that starts from rest lead to, as `settle`; a start that leads to none is unsettled."""
    result = settle(robot, gaits, steps=steps, from_rest=AFTER, approach=APPROACH, threads=threads)
    lost = (result["status"] == 0) & ~result["arrived"]
    return result | {"status": np.where(lost, np.int8(1), result["status"])}


def spins(turn: ArrayLike) -> NDArray[np.bool_]:
    """Whether a beat turns the body by more than half a circle [rad]: it has no path then, and no speed along it."""
    return np.abs(np.asarray(turn, dtype=np.float64)) > np.pi


def directional_derivatives(
    robot: Robot,
    gaits: Gaits,
    beats: Mapping[str, Any],
    directions: Array,
    *,
    model: _core.Model | None = None,
    steps: int = DEFAULT_STEPS,
    threads: int = 1,
) -> dict[str, Array]:
    """Differentiate settled beats along directions in the space of all parameters.

    One beat in dual numbers gives the derivatives of its end P1 and its results by the start P0 and the parameters p.
    The settled start moves with p so that P1 = P0 stays: dP0/dp = (I - dP1/dP0)^-1 dP1/dp (implicit function theorem).

    `directions` (parameters, directions); returns (gaits, directions) of each quantity.
    """
    check_steps(steps)
    momentum, along = np.ascontiguousarray(beats["momentum"]), np.ascontiguousarray(directions)
    columns = gaits.columns
    frequency = columns[0]
    model = model or core_model(robot)
    rows = _core.gradient(model, *columns, momentum, along, steps=steps, threads=threads)
    by_start, by_parameters = rows[..., :3], rows[..., 3:]
    remains = np.eye(3) - by_start[:, _END]
    sound = np.isin(beats["status"], _PERIODIC) & np.isfinite(beats["speed"]) & (np.abs(np.linalg.det(remains)) > 0)
    start = np.full((len(frequency), 3, directions.shape[1]), np.nan)
    start[sound] = np.linalg.solve(remains[sound], by_parameters[sound, _END])
    total = dict(zip(_core.gradient_outputs(), np.moveaxis(by_parameters + by_start @ start, 1, 0), strict=True))

    # d(a / |U|) = da / |U| - a / |U| dU / U
    speed = beats["speed"][:, np.newaxis]
    with np.errstate(divide="ignore", invalid="ignore"):
        faster, heavy = total["speed"] / speed, robot.body.mass * np.abs(speed)
        tail = along[0] * beats["tail_excursion"][:, np.newaxis] + frequency[:, np.newaxis] * total["excursion"]
        over_speed = {
            "cost_of_transport": total["power"] / heavy,
            "cost_of_transport_positive": total["power_positive"] / heavy,
            "strouhal": tail / np.abs(speed),
        }
        result = {name: rate - beats[name][:, np.newaxis] * faster for name, rate in over_speed.items()}
    return result | {NAMES.get(name, name): rate for name, rate in total.items() if not name.startswith("end_")}


def status_text(status: str, beats: float, distance: float, spectral_radius: float) -> str:
    """Return the verdict on a search for the settled beat as a sentence."""
    if status == "settled":
        text = f"The gait is settled: consecutive beats agree to {distance:.1e} of the distance traveled"
        decays = f"; {_decay(spectral_radius)}"
        return f"{text}{'' if np.isnan(spectral_radius) else decays}."
    if status == "unstable":
        text = f"The gait is periodic but unstable: a disturbance grows {_growth(spectral_radius)} each beat"
        return f"{text}, so the robot will not stay in it."
    if status == "unsettled":
        off = f"it is still off by {distance:.1e} of the distance traveled in a beat"
        return f"The gait is unsettled after {beats:.0f} beats: {off}."
    fix = "check the robot first (`hypertuna robot check FILE`), then use more steps per beat"
    return f"The gait diverged within {beats:.0f} beats: its speeds grew beyond all bounds; {fix}."


def _growth(spectral_radius: float) -> str:
    """Describe how fast a disturbance of an unstable beat grows."""
    small = f"by {100 * (spectral_radius - 1):.2g} %"
    return small if spectral_radius < 2 else f"to {spectral_radius:.3g} times its size"


def _decay(spectral_radius: float) -> str:
    """Describe how fast a disturbance of a settled beat decays."""
    loss = 100 * (1 - spectral_radius)
    if loss < 0.01:
        return "a disturbance hardly decays"
    if loss < 5:
        return f"a disturbance decays slowly, by {loss:.2g} % each beat"
    return f"a disturbance decays by {loss:.0f} % each beat"


def _multipliers(monodromy: Array) -> NDArray[np.complex128]:
    """Eigenvalues of each matrix (gaits, 3, 3); NaN where it is not finite."""
    try:
        return np.linalg.eigvals(monodromy).astype(np.complex128)
    except np.linalg.LinAlgError:  # some are not finite
        finite = np.isfinite(monodromy).all(axis=(1, 2))
        multipliers = np.full((len(monodromy), 3), np.nan, dtype=np.complex128)
        multipliers[finite] = np.linalg.eigvals(monodromy[finite])
        return multipliers
