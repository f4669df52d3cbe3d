"""Results that a design refuses: entered before, beyond what the robot can do, or in another unit."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.design.kinds import RUN_KINDS
from hypertuna.design.posterior import Posterior
from hypertuna.design.prediction import Row
from hypertuna.design.runs import QUANTITIES, Measurement, TankRun
from hypertuna.errors import InputError
from hypertuna.swimming.gait import Gait
from hypertuna.trials.head_motion import LONGEST_STRIDE
from hypertuna.trials.plausibility import FAR

MUCH = 2.0  # times a bound of the robot's gaits: it takes eight times the power, which grows as the cube of either
SURELY = 6.0  # standard deviations: a larger difference is no noise, if the ratio is also beyond FAR
SAME_GAIT = 0.1  # of the frequency, and rad: the same gait, as it is rounded or set by hand
UNITS: dict[str, dict[str, float]] = {  # displayed unit -> units used by mistake, with their number in one of it
    "m/s": {"cm/s": 100, "mm/s": 1000},
    "deg/s": {"rad/s": math.pi / 180},
    "N": {"gf": 1000 / 9.81, "mN": 1000},
    "W": {"mW": 1000},
}


def check_gaits(results: Iterable[Measurement], robot: Robot) -> None:
    """Refuse gaits far beyond the bounds of the robot's gaits, which it cannot have made."""
    if (bounds := robot.gait_bounds) is None:
        return
    for result in results:
        if (gait := result.run.gait) is None:
            continue
        pairs = [(f"frequency of {result.name}", gait.frequency, bounds.frequency[1], "Hz")]
        for group, angle, ends in zip(robot.joints, gait.amplitude, bounds.amplitude, strict=True):
            name = f"amplitude of {group.name} of {result.name}"
            pairs.append((name, math.degrees(angle), math.degrees(ends[1]), "deg"))
        for key, value, high, unit in pairs:
            if 0 < MUCH * high < value:
                rule = f"must not be beyond {MUCH:g} times the robot's bound, {high:.4g} {unit}"
                fix = "correct the unit, or the robot's gait_bounds"
                raise InputError(rule, key=key, value=f"{value:.4g} {unit}", fix=fix)


def check_stride(results: Iterable[Measurement], robot: Robot) -> None:
    """Refuse speeds of more lengths a beat than any swimmer goes, however little is known before."""
    for result in results:
        if result.quantity != "speed" or result.run.gait is None:
            continue
        stride = result.value / (result.run.gait.frequency * robot.body.length)
        if stride > LONGEST_STRIDE:
            rule = f"must be at most {LONGEST_STRIDE:g} of the robot's lengths a beat"
            value, fix = f"{_shown(result)}, {stride:.3g} lengths", "give it in m/s: is it in cm/s?"
            raise InputError(rule, key=f"the speed of {result.name or result.run}", value=value, fix=fix)


def check_new(results: Sequence[Measurement], earlier: Sequence[Measurement]) -> None:
    """Refuse results that are among the earlier ones: they would count twice."""
    for k, result in enumerate(results):
        for old in (*earlier, *results[:k]) if result.name else ():
            same = (old.name, old.run, old.quantity) == (result.name, result.run, result.quantity)
            if same and (old.value == result.value or old.day == result.day):
                rule, fix = f"was entered already, as {_shown(old)}", "leave it out; a repeat has a name of its own"
                raise InputError(rule, key=f"the {result.quantity} of {result.name}", fix=fix)


def renamed(results: Iterable[Measurement], asked: Iterable[tuple[str, TankRun]]) -> list[str]:
    """Return sentences on runs that have the name of one that is asked for, and another gait."""
    runs, notes = dict(asked), dict[str, None]()
    for result in results:
        gait, run = result.run.gait, runs.get(result.name)
        if run is not None and run.gait is not None and gait is not None and not _same_gait(run.gait, gait):
            notes[f"{result.name} is taken with its own gait, {result.run}; the one now asked for is {run}."] = None
    return [*notes]


def _same_gait(one: Gait, other: Gait) -> bool:
    """Whether two gaits are the same as commanded; only differences of phases matter."""
    turns = [[phase - gait.phase[0] for phase in gait.phase] + [*gait.amplitude, *gait.bias] for gait in (one, other)]
    off = np.abs((np.subtract(turns[0], turns[1]) + math.pi) % (2 * math.pi) - math.pi)
    return abs(one.frequency - other.frequency) <= SAME_GAIT * one.frequency and bool(off.max() <= SAME_GAIT)


def check_size(results: Sequence[Measurement], prior: Posterior) -> None:
    """Refuse results so far from their prediction before all runs that the unit, not the robot, must be another."""
    predicted = zip(*prior.predict([Row(result.run, result.quantity) for result in results]), strict=True)
    for result, (mean, known) in zip(results, predicted, strict=True):
        sd = math.hypot(known, result.noise)
        ratio = result.value / math.exp(mean)
        size = max(ratio, 1 / ratio)
        if size <= FAR or abs(math.log(ratio)) <= SURELY * sd:
            continue
        unit = QUANTITIES[result.quantity].unit
        rule = f"is {float(f'{ratio:.2g}'):g} times what is expected, more than coefficients are wrong by"
        off = {other: abs(math.log(ratio / factor)) for other, factor in UNITS.get(unit, {}).items()}
        likely = min(off, key=lambda other: off[other], default="")
        guess = f", is it in {likely}?" if likely and off[likely] < 2 * sd else "."
        what = "time_s in s and speed_m_s in m/s" if RUN_KINDS[result.run.kind].series else f"it in {unit}"
        fix = f"give {what}{guess} If it is right, correct the robot, and begin a new design"
        raise InputError(
            rule, key=f"the {result.quantity} of {result.name or result.run}", value=_shown(result), fix=fix
        )


def _shown(result: Measurement) -> str:
    """Return the value of a result with its displayed unit."""
    quantity = QUANTITIES[result.quantity]
    return f"{quantity.per_si * result.value:.4g} {quantity.unit}"
