"""Runs that a tank can make, what they measure with which noise, and the runs that a design chooses from."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, TypeAlias

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, shown
from hypertuna.optimization.design_space import DesignSpace
from hypertuna.ranges import POSITIVE, Range
from hypertuna.swimming.gait import Gait, gait_record, gait_text

# Default noise of one measurement: relative, and in the unit of the quantity.
NOISE = {"speed": (0.02, 0.003), "cost_of_transport": (0.03, 0.0), "drag": (0.03, 0.005)}
UNITS = {"speed": "m/s", "cost_of_transport": "J/(kg m)", "drag": "N"}
SLOWEST = 3.0  # noises of a speed: a slower gait tells next to nothing
TOWED = Range(above=0, max=20, unit="m/s")
# Candidates: levels of the frequency, of the amplitude over its bound, of the lag over its bound, of the last group's
# amplitude over that of the others.
FREQUENCIES, AMPLITUDES, LAGS, FINS = 5, (0.4, 0.7, 1.0), (0.17, 0.45, 0.72), (0.6, 1.0)


@dataclass(frozen=True)
class Tow:
    """The straight robot towed along its axis: its drag is measured."""

    speed: float  # [m/s]

    def __post_init__(self) -> None:
        TOWED.check(self.speed, "speed of a tow", "give the speed of the carriage in m/s")


Run: TypeAlias = Gait | Tow


@dataclass(frozen=True)
class Measurement:
    """One measured number of a run."""

    run: Run
    quantity: str  # of `NOISE`
    value: float  # [SI]
    sd: float | None = None  # of the value [SI]; None: the default noise
    name: str = ""
    day: str = ""  # runs of one day share an offset

    def __post_init__(self) -> None:
        if self.quantity not in measured_of(self.run):
            fix = f"give one of {', '.join(measured_of(self.run))}"
            raise InputError("must be measured in such a run", key="quantity", value=shown(self.quantity), fix=fix)
        key = f"{self.quantity} of {self.name or run_text(self.run)}"
        POSITIVE.check(self.value, key, "leave the run out: a design works with logarithms")
        if self.sd is not None:
            POSITIVE.check(self.sd, f"standard deviation of {key}", "leave it out for the default noise")

    @property
    def noise(self) -> float:
        """Standard deviation of the logarithm of the value."""
        return self.sd / self.value if self.sd is not None else noise_of(self.quantity, self.value)


def noise_of(quantity: str, value: Any) -> Any:
    """Return the default standard deviation of the logarithm of a value [SI], or of an array of them."""
    relative, absolute = NOISE[quantity]
    return np.hypot(relative, absolute / value)


def measured_of(run: Run) -> tuple[str, ...]:
    """Return the quantities that a run can measure."""
    return ("drag",) if isinstance(run, Tow) else ("speed", "cost_of_transport")


def run_text(run: Run) -> str:
    """Describe a run in words."""
    return f"tow at {run.speed:.3g} m/s" if isinstance(run, Tow) else gait_text(run)


def run_record(run: Run) -> dict[str, Any]:
    """Return a run as JSON."""
    return {"tow_m_s": run.speed} if isinstance(run, Tow) else gait_record(run)


def run_of(record: Any) -> Run:
    """Return the run of a record."""
    if "tow_m_s" in record:
        return Tow(record["tow_m_s"])
    keys = {key: record[f"{key}_deg"] for key in ("amplitude", "phase")}
    return Gait.from_degrees(frequency=record["frequency_hz"], **keys, bias=record.get("bias_deg"))


def candidate_gaits(space: DesignSpace, robot: Robot) -> list[Gait]:
    """Return a grid of gaits over frequency, amplitude, lag and the last group's share, within the bounds."""
    low, high = space.low[0], space.high[0]
    levels = product(np.linspace(low, high, FREQUENCIES), AMPLITUDES, LAGS, FINS)
    return _unique(gait_of_shares(space, robot, *level) for level in levels)


def target_gaits(space: DesignSpace, robot: Robot, count: int) -> list[Gait]:
    """Return gaits spread evenly over the box of the candidates: Halton's points."""
    ends = ((space.low[0], space.high[0]), *((levels[0], levels[-1]) for levels in (AMPLITUDES, LAGS, FINS)))
    points = (
        [low + _halton(k, base) * (high - low) for (low, high), base in zip(ends, (2, 3, 5, 7), strict=True)]
        for k in range(1, count + 1)
    )
    return _unique(gait_of_shares(space, robot, *point) for point in points)


def tows(speeds: Array) -> list[Tow]:
    """Return tows from half the slowest to half more than the fastest of the gaits' speeds [m/s]."""
    return [Tow(round(float(u), 3)) for u in np.geomspace(0.5 * speeds.min(), 1.5 * speeds.max(), 4)]


def gait_of_shares(
    space: DesignSpace, robot: Robot, frequency: float, amplitude: float, lag: float, fin: float
) -> Gait:
    """Return a gait by its frequency [Hz] and its shares of the bounds of amplitudes and lags."""
    groups = len(robot.joints)
    low, high = space.low[1:].reshape(-1, groups), space.high[1:].reshape(-1, groups)
    share = np.full(groups, amplitude)
    share[-1] *= fin if groups > 1 else 1.0
    bend = np.clip(share * high[0], low[0], high[0])
    last = low[1][-1] + lag * (high[1][-1] - low[1][-1])
    phase = np.clip(
        last * np.linspace(0, 1, groups) if groups > 1 else low[1], low[1], high[1]
    )  # a wave toward the tail
    rest = np.clip(0.0, low[2], high[2])
    degrees = [np.round(np.degrees(row), 1).tolist() for row in (bend, phase, rest)]
    return Gait.from_degrees(
        frequency=float(f"{frequency:.3g}"), amplitude=degrees[0], phase=degrees[1], bias=degrees[2]
    )


def _unique(gaits: Any) -> list[Gait]:
    """Return the gaits that differ, in their order: a robot of one joint group has no lag."""
    return list({gait.values.tobytes(): gait for gait in gaits}.values())


def _halton(k: int, base: int) -> float:
    """Return number k of the van der Corput sequence in a base."""
    share, value = 1.0, 0.0
    while k:
        share, (k, digit) = share / base, divmod(k, base)
        value += share * digit
    return value


def shared_frequency(runs: Sequence[Run]) -> tuple[float, int] | None:
    """Return the frequency [Hz] that two thirds or more of at least four gaits share, and their number; else None."""
    beats = [run.frequency for run in runs if isinstance(run, Gait)]
    for frequency in beats:
        count = sum(math.isclose(frequency, other, rel_tol=0.05) for other in beats)
        if len(beats) >= 4 and 3 * count >= 2 * len(beats):
            return frequency, count
    return None
