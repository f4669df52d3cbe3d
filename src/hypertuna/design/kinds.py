"""Kinds of runs that a tank can make: for each, the trials it yields, its candidates and their prediction."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.swimming.beat import directional_derivatives, settle
from hypertuna.swimming.gait import Gait, Gaits, gait_text
from hypertuna.trials.decay import Glide
from hypertuna.trials.kind import Point
from hypertuna.trials.kind_numbers import HeldRows
from hypertuna.trials.kinds import kind_of
from hypertuna.trials.numbers import HeldThrust, PowerRun, Tow, TurnRun
from hypertuna.trials.steady import MEASURED, SteadyRun

STEPS = 64  # Runge-Kutta steps per beat or glide: their error is far below the noise of a tank
COASTS = 2.0  # a glide is followed for the time of this many body lengths at its first speed
BEATS = {"power": "mechanical_power"}  # quantity of a run: its name in a settled beat, where the two differ
Motion = tuple[Gait | None, float]  # gait, None for a straight body; speed [m/s]
Mean = tuple[str, float, float | None]  # name of a quantity; mean of repeats and its standard deviation [SI]


class RunKind(ABC):
    """A kind of run, with the quantities it measures and their prediction."""

    key: ClassVar[str]  # key of the kind of trial in manifests
    trials: ClassVar[tuple[type[Any], ...]]  # classes of trials that give results; files use the first
    needs: ClassVar[str] = ""  # option of a design that says whether the tank has the equipment
    speed: ClassVar[str] = ""  # key of the speed in records
    series: ClassVar[bool] = False  # whether a run is measured over time

    @abstractmethod
    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the names of the quantities that a run can measure."""

    @abstractmethod
    def text(self, motion: Motion) -> str:
        """Return the run in words, with its gait or speed."""

    @abstractmethod
    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return the candidates of this kind, made from the given gaits or speeds [m/s]."""

    def means(self, trial: Any) -> tuple[Motion, list[Mean]]:
        """Return a trial's gait and speed, and its measured quantities with standard deviations."""
        sd = None if trial.sd is None else trial.sd / math.sqrt(trial.repeats)
        return (trial.gait, trial.u), [(kind_of(trial).quantities[0].name, trial.value, sd)]

    @abstractmethod
    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Return predicted quantities (rows,) [SI], NaN where a run has none, and their derivatives (rows, n)."""


class Swims(RunKind):
    """Free swims of a gait."""

    key, trials = "steady", (SteadyRun, TurnRun, PowerRun)

    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the names of the quantities of a beat, with the rate of turn if the gait has a bias."""
        return (*MEASURED, "power", *(("turn_rate",) if motion[0] is not None and any(motion[0].bias) else ()))

    def text(self, motion: Motion) -> str:
        """Return the gait in words."""
        return gait_text(_gait(motion))

    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return a swim of each gait."""
        return [(gait, 0.0) for gait in gaits]

    def means(self, trial: Any) -> tuple[Motion, list[Mean]]:
        """Return a trial's gait and speed, and its measured quantities with standard deviations."""
        if not isinstance(trial, SteadyRun):
            motion, ((name, value, sd),) = super().means(trial)
            return motion, [(name, abs(value), sd)]
        root = math.sqrt(trial.repeats)
        stated = ((name, getattr(trial, name), getattr(trial, f"{name}_sd")) for name in MEASURED)
        measured = [(name, value, None if sd is None else sd / root) for name, value, sd in stated if value is not None]
        return (trial.gait, 0.0), measured

    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Return quantities of the settled gaits and their derivatives; rates of turn are magnitudes."""
        index_of = {gait: k for k, gait in enumerate(dict.fromkeys(map(_gait, motions)))}
        gaits, of_motion = Gaits.of(list(index_of)), [index_of[_gait(motion)] for motion in motions]
        beats = settle(at.robot, gaits, model=at.model, steps=STEPS)
        slopes = directional_derivatives(at.robot, gaits, beats, np.asarray(at.along), model=at.model, steps=STEPS)
        settled = ((beats["status"] == 0) & (beats["speed"] > 0))[of_motion]
        names = [BEATS.get(name, name) for name in quantities]
        value, slope = (
            np.array([table[name][k] for name, k in zip(names, of_motion, strict=True)]) for table in (beats, slopes)
        )
        sign = np.where([name == "turn_rate" for name in quantities], np.sign(value), 1.0)
        return np.where(settled, sign * value, np.nan), sign[:, np.newaxis] * slope


class Tows(RunKind):
    """Tows of the straight body by a carriage."""

    key, trials, needs, speed = "tows", (Tow,), "tow", "tow_m_s"

    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the name of the drag, the only quantity."""
        return ("drag",)

    def text(self, motion: Motion) -> str:
        """Return the speed in words."""
        return f"tow at {motion[1]:.3g} m/s"

    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return a tow at each speed."""
        return [(None, u) for u in speeds]

    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Return the drag of each run [N] and its derivatives, as the kind of trial predicts it."""
        return _forces(at, motions, -1.0)


class Thrusts(RunKind):
    """Measurements of thrust by a gauge that holds the head of the beating robot."""

    key, trials, needs, speed = "thrusts", (HeldThrust,), "hold", "held_m_s"

    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the name of the thrust, the only quantity."""
        return ("thrust",)

    def text(self, motion: Motion) -> str:
        """Return the gait in words."""
        return f"held still, {gait_text(_gait(motion))}"

    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return a measurement of each gait in still water."""
        return [(gait, 0.0) for gait in gaits]

    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Return the thrust of each run [N] and its derivatives, as the kind of trial predicts it."""
        return _forces(at, motions, 1.0)


class Glides(RunKind):
    """Glides of the straight body, released in motion."""

    key, trials, needs, speed, series = "glides", (Glide,), "glide", "glide_m_s", True

    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the name of the coasting length, over which the speed falls by a factor of e."""
        return ("coasting_length",)

    def text(self, motion: Motion) -> str:
        """Return the first speed in words."""
        return f"glide from {motion[1]:.3g} m/s"

    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return a glide from each speed."""
        return [(None, u) for u in speeds]

    def means(self, trial: Any) -> tuple[Motion, list[Mean]]:
        """Return a glide's first speed, and its coasting length with its standard deviation."""
        length, sd, u = trial.coasting()
        return (None, u), [("coasting_length", length, sd)]

    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Return coasting lengths [m] from the first and the last speed of a glide, and their derivatives.

        With drag proportional to the square of the speed, 1/u grows by 1/length per second. With other drag, the
        length is a mean over the glide.
        """
        straight, along, results = np.zeros((2 * STEPS + 1, len(at.robot.links.name), 3)), at.model_along, []
        for _, u in motions:
            time, twist = COASTS * at.robot.body.length / u, np.array([-u, 0.0, 0.0])
            track = _core.track(at.model, straight, along, step=time / STEPS, twist=twist, rates=True)
            last_speed, slope = -track["rate"][-1, 0], -track["rate_gradient"][-1, 0, len(twist) :]
            length = time / (1 / last_speed - 1 / u)
            results.append((length, slope * length**2 / (time * last_speed**2)))
        return np.array([pair[0] for pair in results]), np.array([pair[1] for pair in results])


RUN_KINDS: dict[str, RunKind] = {kind.key: kind for kind in (Swims(), Thrusts(), Tows(), Glides())}


def _gait(motion: Motion) -> Gait:
    """Return the gait of a motion, which must have one."""
    assert motion[0] is not None
    return motion[0]


def _forces(at: Point, motions: Sequence[Motion], sign: float) -> tuple[Array, Array]:
    """Return forces on a held or towed head [N] and their derivatives; sign: 1 for thrust, -1 for drag."""
    straight = (0.0,) * len(at.robot.joints)
    gaits = tuple(gait or Gait(1.0, straight, straight) for gait, _ in motions)
    u, zeros = np.array([u for _, u in motions]), np.zeros(len(motions))
    rows = HeldRows(zeros, zeros.astype(int), (), len(motions), gaits, u, sign).predict(at)
    return rows.computed, rows.jacobian
