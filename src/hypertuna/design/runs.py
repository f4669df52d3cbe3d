"""Runs that a tank can make: their measured quantities with noise, and grids of candidate and target gaits."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.design.kinds import RUN_KINDS, Motion, Swims
from hypertuna.errors import InputError, shown
from hypertuna.optimization.design_space import DesignSpace
from hypertuna.ranges import POSITIVE
from hypertuna.swimming.gait import Gait, gait_record
from hypertuna.trials.decay import Decay
from hypertuna.trials.numbers import NumberRun, U
from hypertuna.trials.steady import SteadyRun


class RunQuantity(NamedTuple):
    """A quantity of runs: default noise, relative and absolute [SI]; displayed unit, and its number per SI unit."""

    relative: float
    absolute: float
    unit: str
    per_si: float = 1.0


QUANTITIES = {
    "speed": RunQuantity(0.02, 0.003, "m/s"),
    "cost_of_transport": RunQuantity(0.03, 0.0, "J/(kg m)"),
    "turn_rate": RunQuantity(0.03, 0.02, "deg/s", 180 / math.pi),  # magnitude
    "power": RunQuantity(0.03, 0.0, "W"),
    "drag": RunQuantity(0.03, 0.005, "N"),
    "thrust": RunQuantity(0.03, 0.005, "N"),
    "coasting_length": RunQuantity(0.08, 0.0, "m"),
}
SLOWEST = 3.0  # a candidate's expected value must exceed this many times its absolute noise
# Grid of candidates: number of frequencies; amplitude and lag over their bounds; amplitude of the last group over that
# of the others; bias over its bound.
FREQUENCIES, AMPLITUDES, LAGS, FINS, BIASES = 5, (0.4, 0.7, 1.0), (0.17, 0.45, 0.72), (0.6, 1.0), (0.4, 1.0)


@dataclass(frozen=True)
class TankRun:
    """A run that a tank can make: kind, gait and speed, without results.

    Parameters
    ----------
    kind : str
        Kind of trial, as a manifest has it: a key of `RUN_KINDS`.
    gait : Gait, optional
        The commanded gait; None for a straight body.
    u : float
        Speed of a tow or a current, or the speed at which a glide begins [m/s].
    """

    kind: str
    gait: Gait | None = None
    u: float = 0.0

    def __post_init__(self) -> None:
        if self.u or self.gait is None:
            U.check(self.u, f"speed of {self.kind}", "give the speed through the water in m/s")

    @property
    def motion(self) -> Motion:
        """Gait (None for a straight body) and speed [m/s]."""
        return self.gait, self.u

    @property
    def swims(self) -> bool:
        """Whether the run is a free swim of a gait."""
        return isinstance(RUN_KINDS[self.kind], Swims)

    @property
    def turns(self) -> bool:
        """Whether the run is a free swim of a gait with bias."""
        return self.swims and self.gait is not None and any(self.gait.bias)

    @property
    def measured(self) -> tuple[str, ...]:
        """Quantities that the run can measure."""
        return RUN_KINDS[self.kind].measured(self.motion)

    def __str__(self) -> str:
        return RUN_KINDS[self.kind].text(self.motion)


def run_record(run: TankRun) -> dict[str, Any]:
    """Return a run as a JSON record with its gait, its speed or both."""
    key = RUN_KINDS[run.kind].speed
    return ({key: run.u} if key else {}) | ({} if run.gait is None else gait_record(run.gait))


def run_of(record: Any) -> TankRun:
    """Return the run that a JSON record describes."""
    given = ((key, record[kind.speed]) for key, kind in RUN_KINDS.items() if kind.speed in record)
    kind, u = next(given, (Swims.key, 0.0))
    if "frequency_hz" not in record:
        return TankRun(kind, u=u)
    keys = {key: record[f"{key}_deg"] for key in ("amplitude", "phase")}
    gait = Gait.from_degrees(frequency=record["frequency_hz"], **keys, bias=record.get("bias_deg"))
    return TankRun(kind, gait, u)


def swims(gaits: Iterable[Gait]) -> list[TankRun]:
    """Return a free swim of each gait."""
    return [TankRun(Swims.key, gait) for gait in gaits]


@dataclass(frozen=True)
class Measurement:
    """A measured value of one quantity of a run.

    Parameters
    ----------
    run : TankRun
    quantity : str
        What was measured: one of ``run.measured``.
    value : float
        The measured number, greater than 0 [SI].
    sd : float, optional
        Standard deviation of the measured number [SI]; None for the default noise of the quantity.
    name : str
        Name of the run.
    day : str
        Name of the day; the runs of a day share an offset.

    Raises
    ------
    InputError
        If a run of this kind does not measure the quantity, or the value or its standard deviation is not positive.
    """

    run: TankRun
    quantity: str
    value: float
    sd: float | None = None
    name: str = ""
    day: str = ""

    def __post_init__(self) -> None:
        if self.quantity not in self.run.measured:
            fix = f"give one of {', '.join(self.run.measured)}"
            raise InputError("must be measured in such a run", key="quantity", value=shown(self.quantity), fix=fix)
        key = f"{self.quantity} of {self.name or self.run}"
        POSITIVE.check(self.value, key, "leave the run out: a design works with logarithms")
        if self.sd is not None:
            POSITIVE.check(self.sd, f"standard deviation of {key}", "leave it out for the default noise")

    @property
    def noise(self) -> float:
        """Standard deviation of the logarithm of the measured value."""
        return self.sd / self.value if self.sd is not None else noise_of(self.quantity, self.value)


Trial = SteadyRun | NumberRun | Decay | Measurement


def measurements(trial: Trial, day: str = "") -> list[Measurement]:
    """Return the measured numbers of a trial, means over its repeats with the noise of a mean."""
    if isinstance(trial, Measurement):
        return [replace(trial, day=trial.day or day)]
    kind = next((kind for kind in RUN_KINDS.values() if isinstance(trial, kind.trials)), None)
    if kind is None:
        rule, fix = "must be a run that a design knows", "give steady runs, turns, powers, tows, held thrusts or glides"
        raise InputError(rule, key="tell", value=type(trial).__name__, fix=fix)
    motion, quantities = kind.means(trial)
    return [Measurement(TankRun(kind.key, *motion), *values, trial.name, day) for values in quantities]


def noise_of(quantity: str, value: Any) -> Any:
    """Return the default standard deviation of the logarithm of a measured value or array of values [SI]."""
    quantity_noise = QUANTITIES[quantity]
    return np.hypot(quantity_noise.relative, quantity_noise.absolute / value)


def candidate_gaits(space: DesignSpace, robot: Robot, biases: Sequence[float] = (0.0,)) -> list[Gait]:
    """Return a grid of gaits over frequency, amplitude, lag, the last group's share and bias, within the bounds."""
    low, high = space.low[0], space.high[0]
    levels = product(np.linspace(low, high, FREQUENCIES), AMPLITUDES, LAGS, FINS, biases)
    return _unique(gait_of_shares(space, robot, *level) for level in levels)


def target_gaits(space: DesignSpace, robot: Robot, count: int, biases: Sequence[float] = (0.0,)) -> list[Gait]:
    """Return gaits at Halton points, which spread evenly over the range of the candidates."""
    ranges = (
        (space.low[0], space.high[0]),
        *((levels[0], levels[-1]) for levels in (AMPLITUDES, LAGS, FINS, biases)),
    )
    points = (
        [low + _halton(k, base) * (high - low) for (low, high), base in zip(ranges, (2, 3, 5, 7, 11), strict=True)]
        for k in range(1, count + 1)
    )
    return _unique(gait_of_shares(space, robot, *point) for point in points)


def speeds_of(speeds: Array) -> list[float]:
    """Return four speeds [m/s], from 0.5 times the slowest to 1.5 times the fastest of the given speeds."""
    return [round(float(u), 3) for u in np.geomspace(0.5 * speeds.min(), 1.5 * speeds.max(), 4)]


def bias_ends(space: DesignSpace, robot: Robot) -> Array:
    """Return the bound of bias (groups,) [rad] on the side with the larger range: all lower or all upper bounds."""
    low, high = (bounds[1:].reshape(-1, len(robot.joints))[2] for bounds in (space.low, space.high))
    return np.asarray(np.where(np.abs(low).max() > np.abs(high).max(), low, high))


def gait_of_shares(
    space: DesignSpace, robot: Robot, frequency: float, amplitude: float, lag: float, fin: float, bias: float = 0.0
) -> Gait:
    """Return the gait with a frequency [Hz] and with parts of the bounds of amplitude, lag and bias."""
    groups = len(robot.joints)
    low, high = space.low[1:].reshape(-1, groups), space.high[1:].reshape(-1, groups)
    share = np.full(groups, amplitude)
    share[-1] *= fin if groups > 1 else 1.0
    amplitudes = np.clip(share * high[0], low[0], high[0])
    last_phase = low[1][-1] + lag * (high[1][-1] - low[1][-1])
    wave = last_phase * np.linspace(0, 1, groups) if groups > 1 else low[1]  # traveling toward the tail
    phase = np.clip(wave, low[1], high[1])
    bias_angles = np.clip(bias * bias_ends(space, robot), low[2], high[2])
    degrees = [np.round(np.degrees(row), 1).tolist() for row in (amplitudes, phase, bias_angles)]
    return Gait.from_degrees(
        frequency=float(f"{frequency:.3g}"), amplitude=degrees[0], phase=degrees[1], bias=degrees[2]
    )


def _unique(gaits: Any) -> list[Gait]:
    """Return the gaits without repeats, in their order; a robot with one joint group has no lag to vary."""
    return list({gait.values.tobytes(): gait for gait in gaits}.values())


def _halton(k: int, base: int) -> float:
    """Return the k-th number of the van der Corput sequence in a base [1]."""
    share, value = 1.0, 0.0
    while k:
        share, (k, digit) = share / base, divmod(k, base)
        value += share * digit
    return value


def shared_frequency(runs: Sequence[TankRun]) -> tuple[float, int] | None:
    """Return a frequency [Hz] of two thirds or more of at least four gaits, and the number of such gaits; else None."""
    beats = [run.gait.frequency for run in runs if run.gait is not None]
    for frequency in beats:
        count = sum(math.isclose(frequency, other, rel_tol=0.05) for other in beats)
        if len(beats) >= 4 and 3 * count >= 2 * len(beats):
            return frequency, count
    return None
