"""Dive with the pectoral fins down, then rise with them up, as in the paper's Fig. 15; measure both halves."""

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from hypertuna.arguments import checked
from hypertuna.description.inversion import inversion_speed
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.io.quantity import Format
from hypertuna.ranges import FINITE, POSITIVE
from hypertuna.simulation.sea import Sea
from hypertuna.simulation.sea_run import SeaRun
from hypertuna.simulation.twin import STILL, twin_at_sea
from hypertuna.swimming.gait import Gait, gait_of

ANGLE = math.radians(45)  # default angle of the fins
MAX_PITCH_RANGE = math.radians(2)  # a leg is steady if its pitch, averaged over beats, varies by less
INVERSION_MARGIN = 0.8  # fraction of the inversion speed above which fins at 45 deg no longer dive the robot
MIN_DEPTH_RATE = 0.05  # fraction of the speed: a robot that sinks or rises more slowly does neither


@dataclass(frozen=True)
class Leg:
    """The downward or the upward part of a dive; means are over its last half."""

    fins: Annotated[float, Format("deg")]  # target angle of both fins, leading edge up [rad]
    depth_rate: Annotated[float, Format("m/s")]  # rate of change of depth, positive down [m/s]
    pitch: Annotated[float, Format("deg")]  # mean, nose up [rad]
    pitch_range: Annotated[float, Format("deg")]  # range of the pitch averaged over beats [rad]
    roll_max: Annotated[float, Format("deg")]  # largest absolute roll, not averaged over beats [rad]
    speed: Annotated[float, Format("m/s")]  # mean through the water, ahead [m/s]
    depth: tuple[float, float]  # depth of the nose at the start and the end of the whole leg [m]

    @property
    def steady(self) -> bool:
        """Whether the pitch, averaged over beats, stays within 2 degrees."""
        return self.pitch_range < MAX_PITCH_RANGE

    @property
    def right(self) -> bool:
        """Whether the robot goes where the fins point: down with fins down, up with fins up."""
        return self.depth_rate * self.fins < 0 and abs(self.depth_rate) > MIN_DEPTH_RATE * abs(self.speed)


@dataclass(frozen=True)
class Dive(Plotted, Tabular, data=lambda dive: dive.run.dataset()):
    """A dive with the fins down, then up: its run, and measurements of its two legs."""

    run: SeaRun
    switch: float  # time at which the fins turn from down to up [s]
    angle: float  # by which the fins point down, then up [rad]

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        """The completed legs: down, then up."""
        spans = ((0.0, self.switch, -self.angle), (self.switch, self.run.duration, self.angle))
        length = self.run.time[-1] + self.run.tick if len(self.run.time) else 0.0
        return tuple(self._leg(*span) for span in spans if length > span[1] - self.run.tick)

    @property
    def symmetry(self) -> float:
        """Rate of rising over rate of diving [1]: 1 if they are equal, NaN without both legs."""
        return -self.legs[1].depth_rate / self.legs[0].depth_rate if len(self.legs) == 2 else math.nan

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences on each leg, and on the speed above which the fins act the wrong way."""
        if self.run.status == "diverged":
            return (self.run.divergence,)
        sentences = []
        for leg, verb in zip(self.legs, ("dives", "floats"), strict=True):
            rate = f"{verb} at {100 * abs(leg.depth_rate):.3g} cm/s"
            result = rate if leg.right else f"does not: its depth changes by {100 * leg.depth_rate:+z.1f} cm/s"
            pitch = "steady" if leg.steady else f"not steady, it ranges over {math.degrees(leg.pitch_range):.2g} deg"
            sentences.append(f"With its fins at {math.degrees(leg.fins):+z.3g} deg it {result}; its pitch is {pitch}.")
        if not all(leg.right for leg in self.legs):
            limit, speed = inversion_speed(self.run.robot), max(leg.speed for leg in self.legs)
            if speed > INVERSION_MARGIN * limit:
                sentences.append(
                    f"Near and above {limit:.3g} m/s the water turns its hull against the fins: "
                    "swim slower, or put its ballast lower (spatial.com_height_m)."
                )
        return tuple(sentences)

    def _leg(self, start: float, end: float, fins: float) -> Leg:
        """Measure depth rate, pitch and speed of a leg over its last half."""
        run, depth = self.run, self.run.depth
        first, middle, last = np.searchsorted(run.time, np.array([start, (start + end) / 2, end - run.tick]) - 1e-9)
        last = min(last, len(run.time) - 1)  # a duration may end within a tick
        second_half, half_beat = slice(middle, last + 1), 0.5 / run.gait.frequency
        whole_beats = (run.time >= run.time[middle] + half_beat) & (run.time <= run.time[last] - half_beat)
        pitch = run.averaged(run.pitch)[whole_beats] if whole_beats.any() else run.pitch[second_half]
        return Leg(
            fins=fins,
            depth_rate=float((depth[last] - depth[middle]) / (run.time[last] - run.time[middle])),
            pitch=float(run.pitch[second_half].mean()),
            pitch_range=float(np.ptp(pitch)),
            roll_max=float(abs(run.roll[second_half]).max()),
            speed=float(run.speed[second_half].mean()),
            depth=(float(depth[first]), float(depth[last])),
        )


@checked
def dive(
    robot: Robot | str | Path,
    gait: Gait | str,
    *,
    angle: float = ANGLE,
    duration: float = 30.0,
    depth: float = 2.0,
    sea: Sea = STILL,
    seed: int = 0,
) -> Dive:
    """Dive with the fins down for half of the time, then rise with them up.

    Parameters
    ----------
    robot, gait, sea, seed
        As in `twin_at_sea`.
    angle, duration, depth : float
        Angle of the fins [rad], duration of both legs [s], depth at the start [m].

    Returns
    -------
    Dive

    Raises
    ------
    InputError
        As `twin_at_sea` does, or if a leg is shorter than four beats.
    """
    robot = robot_of(robot)
    gait = gait_of(robot, gait)
    angle = POSITIVE.check(angle, "angle", "give radians: the fins go down by it, then up")
    if FINITE.check(duration, "duration", "give the seconds") < 8 / gait.frequency:
        rule = f"must be at least eight beats, {8 / gait.frequency:.3g} s at {gait.frequency:g} Hz"
        raise InputError(rule, key="duration", value=f"{duration:g} s", fix="give 20 s or more: the robot must settle")
    switch = duration / 2
    options: Any = {"duration": duration, "depth": depth, "sea": sea, "seed": seed}
    run = twin_at_sea(robot, gait, fins=lambda time: -angle if time < switch else angle, **options)
    return Dive(run, switch, angle)
