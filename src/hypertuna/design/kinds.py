"""The kinds of runs that a tank can make, by the kinds of trials that they give: all that a design knows of each."""

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
COASTS = 2.0  # body lengths at the first speed: how long a glide is followed
BEATS = {"power": "mechanical_power"}  # names of the quantities of a settled beat that are others than of runs
Motion = tuple[Gait | None, float]  # gait, None of a straight body; speed [m/s]
Told = tuple[str, float, float | None]  # quantity, value and standard deviation of the mean of repeats [SI]


class RunKind(ABC):
    """A kind of run."""

    key: ClassVar[str]  # of the kind of trial, as manifests have it
    trials: ClassVar[tuple[type[Any], ...]]  # of which it takes results; its files are those of the first
    needs: ClassVar[str] = ""  # option of a design: what the tank must have
    speed: ClassVar[str] = ""  # key of the speed in records
    series: ClassVar[bool] = False  # whether a run is measured over time

    @abstractmethod
    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the quantities that a run can measure."""

    @abstractmethod
    def text(self, motion: Motion) -> str:
        """Return a run in words."""

    @abstractmethod
    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return the runs to choose from, of gaits that swim and of speeds [m/s]."""

    def told(self, trial: Any) -> tuple[Motion, list[Told]]:
        """Return what a trial was, and what it measured."""
        sd = None if trial.sd is None else trial.sd / math.sqrt(trial.repeats)
        return (trial.gait, trial.u), [(kind_of(trial).quantities[0].name, trial.value, sd)]

    @abstractmethod
    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Return a quantity of each run (rows,) [SI], NaN where it has none, and its derivatives (rows, n)."""


class Swims(RunKind):
    """Free swims of a gait."""

    key, trials = "steady", (SteadyRun, TurnRun, PowerRun)

    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return what a beat tells; of a gait that bends to one side the rate of turn, too."""
        return (*MEASURED, "power", *(("turn_rate",) if motion[0] is not None and any(motion[0].bias) else ()))

    def text(self, motion: Motion) -> str:
        """Return the gait."""
        return gait_text(_gait(motion))

    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return all gaits."""
        return [(gait, 0.0) for gait in gaits]

    def told(self, trial: Any) -> tuple[Motion, list[Told]]:
        """Return what a trial was, and what it measured."""
        if not isinstance(trial, SteadyRun):
            motion, ((name, value, sd),) = super().told(trial)
            return motion, [(name, abs(value), sd)]
        root = math.sqrt(trial.repeats)
        given = ((name, getattr(trial, name), getattr(trial, f"{name}_sd")) for name in MEASURED)
        known = [(name, value, None if sd is None else sd / root) for name, value, sd in given if value is not None]
        return (trial.gait, 0.0), known

    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Settle the gaits; rates of turn are to either side."""
        place = {gait: k for k, gait in enumerate(dict.fromkeys(map(_gait, motions)))}
        gaits, own = Gaits.of(list(place)), [place[_gait(motion)] for motion in motions]
        beats = settle(at.robot, gaits, model=at.model, steps=STEPS)
        slopes = directional_derivatives(at.robot, gaits, beats, np.asarray(at.along), model=at.model, steps=STEPS)
        good = ((beats["status"] == 0) & (beats["speed"] > 0))[own]
        names = [BEATS.get(name, name) for name in quantities]
        value, by = (
            np.array([table[name][k] for name, k in zip(names, own, strict=True)]) for table in (beats, slopes)
        )
        sign = np.where([name == "turn_rate" for name in quantities], np.sign(value), 1.0)
        return np.where(good, sign * value, np.nan), sign[:, np.newaxis] * by


class Tows(RunKind):
    """A carriage that tows the straight body."""

    key, trials, needs, speed = "tows", (Tow,), "tow", "tow_m_s"

    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the drag."""
        return ("drag",)

    def text(self, motion: Motion) -> str:
        """Return the speed."""
        return f"tow at {motion[1]:.3g} m/s"

    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return all speeds."""
        return [(None, u) for u in speeds]

    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Return the drag, as the kind of trial predicts it."""
        return _held(at, motions, -1.0)


class Thrusts(RunKind):
    """A gauge that holds the head of the beating robot."""

    key, trials, needs, speed = "thrusts", (HeldThrust,), "hold", "held_m_s"

    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the thrust."""
        return ("thrust",)

    def text(self, motion: Motion) -> str:
        """Return the gait."""
        return f"held still, {gait_text(_gait(motion))}"

    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return all gaits in still water."""
        return [(gait, 0.0) for gait in gaits]

    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Return the thrust, as the kind of trial predicts it."""
        return _held(at, motions, 1.0)


class Glides(RunKind):
    """The straight body, let go in motion."""

    key, trials, needs, speed, series = "glides", (Glide,), "glide", "glide_m_s", True

    def measured(self, motion: Motion) -> tuple[str, ...]:
        """Return the length over which the speed falls by a factor of e."""
        return ("coasting_length",)

    def text(self, motion: Motion) -> str:
        """Return the first speed."""
        return f"glide from {motion[1]:.3g} m/s"

    def choices(self, gaits: Sequence[Gait], speeds: Sequence[float]) -> list[Motion]:
        """Return all speeds."""
        return [(None, u) for u in speeds]

    def told(self, trial: Any) -> tuple[Motion, list[Told]]:
        """Return the coasting length."""
        length, sd, u = trial.coasting()
        return (None, u), [("coasting_length", length, sd)]

    def predict(self, at: Point, motions: Sequence[Motion], quantities: Sequence[str]) -> tuple[Array, Array]:
        """Compute the lengths from two speeds of a glide.

        Of a drag by the square of the speed, 1/u grows by 1/length a second; else it is the mean over the glide.
        """
        still, along, found = np.zeros((2 * STEPS + 1, len(at.robot.links.name), 3)), np.asarray(at.along), []
        for _, u in motions:
            time, begin = COASTS * at.robot.body.length / u, np.array([-u, 0.0, 0.0])
            track = _core.track(at.model, still, along, step=time / STEPS, twist=begin, rates=True)
            end, by = -track["rate"][-1, 0], -track["rate_gradient"][-1, 0, len(begin) :]
            length = time / (1 / end - 1 / u)
            found.append((length, by * length**2 / (time * end**2)))
        return np.array([one[0] for one in found]), np.array([one[1] for one in found])


RUN_KINDS: dict[str, RunKind] = {kind.key: kind for kind in (Swims(), Thrusts(), Tows(), Glides())}


def _gait(motion: Motion) -> Gait:
    """Return the gait of a motion that has one."""
    assert motion[0] is not None
    return motion[0]


def _held(at: Point, motions: Sequence[Motion], sign: float) -> tuple[Array, Array]:
    """Return the force on a held or towed head, as the kinds of trials predict it; sign: 1 toward the head."""
    rest = (0.0,) * len(at.robot.joints)
    gaits = tuple(gait or Gait(1.0, rest, rest) for gait, _ in motions)
    u, none = np.array([u for _, u in motions]), np.zeros(len(motions))
    made = HeldRows(none, none.astype(int), (), len(motions), gaits, u, sign).predict(at)
    return made.computed, made.jacobian
