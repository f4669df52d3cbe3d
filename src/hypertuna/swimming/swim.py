"""Swims of one gait: the settled beat, or a run from rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.arguments import checked
from hypertuna.arrays import Array, rounded_number
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.io.quantity import Format, Quantity, label, summarized
from hypertuna.ranges import Whole
from hypertuna.swimming.beat import (
    APPROACH,
    DEFAULT_STEPS,
    QUANTITIES,
    STATUSES,
    check_steps,
    settle,
    settle_from_rest,
)
from hypertuna.swimming.gait import Gait, Gaits, gait_of
from hypertuna.swimming.model import core_model, twist_from_rest
from hypertuna.swimming.trajectory import trajectory
from hypertuna.swimming.yielding import (
    Bend,
    bend_joints,
    bend_summary,
    bends_of,
    folds,
    moment_power,
    softness,
    too_soft,
)

if TYPE_CHECKING:
    import xarray as xr

    from hypertuna.swimming.band import Band

MAX_BEATS = 10_000  # most beats of a run: half a gigabyte of trajectory
BEATS = Whole(min=1, max=MAX_BEATS)  # allowed number of beats
SETTLED = 1e-4  # a run from rest is settled if its last beat is this near the settled speed (relative)

# Quantities that terminal and JSON show of a swim; those in JSON only come last.
SUMMARY = {
    name: Format(about.shown_unit, about.label.partition(", ")[2] if about.shown == 2 else None)
    for name, about in sorted(QUANTITIES.items(), key=lambda item: -item[1].shown)
    if about.shown
}


@dataclass(frozen=True)
class Swim(Plotted, Tabular, data=lambda swim: swim.trajectory):
    """How a robot swims a gait. Means are over one beat: the settled beat, or the last beat of a run from rest."""

    robot: Robot
    gait: Gait
    speed: float  # m/s along the mean path through the water, forward positive; NaN for a body that spins
    speed_bl: float  # body lengths per second
    mechanical_power: float  # W, mean mechanical power of all joints
    mechanical_power_positive: float  # W, mechanical power with negative power of a joint group counted as zero
    power_to_water: float  # W, mean power that the body gives to the water
    cost_of_transport: float  # J/(kg m), mechanical power per mass and speed
    cost_of_transport_positive: float  # J/(kg m), positive mechanical power per mass and speed
    efficiency: float  # power to tow the straight body at this speed over mechanical power; NaN without power
    strouhal: float  # frequency times tail excursion over speed
    stride_length: float  # body lengths per beat
    tail_excursion: float  # m, peak to peak, of the tail tip across the mean path
    torque_peak: float  # N m, largest magnitude of any driven joint's torque over the beat
    rate_peak: float  # rad/s, largest rate of any joint group
    turn_rate: float  # rad/s, mean, counter-clockwise positive
    turn_radius: float  # m, of the nose's mean path; infinite when straight, NaN for a body that spins
    spectral_radius: float  # largest modulus of the multipliers: growth of a disturbance per beat
    change_per_beat: float  # change of the motion from this beat to the next, body lengths or rad
    distance_to_settled: float  # distance from the settled motion, relative to the distance traveled in a beat
    beats: int  # number of beats integrated
    multipliers: NDArray[np.complex128]  # (3 + 2 hinges,) of the monodromy matrix, largest first; NaN from rest
    status: str  # "settled", "unsettled", "unstable" or "diverged"
    status_text: str  # the status as a sentence, with the beat to which a start from rest leads
    reached_from_rest: bool | None  # whether a start from rest leads to this beat; None if that is not checked
    settled_from_rest: Swim | None  # the other settled beat to which a start from rest leads; None without another
    steps: int  # Runge-Kutta steps per beat
    current: tuple[float, float]  # m/s, velocity of the water
    from_rest: float | None  # s, duration of the run from rest; None for the settled beat
    bends: tuple[Bend, ...]  # swings of the hinges
    _start: Array | None  # twist at the start of the trajectory; None from rest
    _state: Array  # the core's state at the start: momentum of the body, angles and momenta of the hinges

    @property
    def settled(self) -> bool:
        """Whether the gait repeats itself and recovers from small disturbances."""
        return self.status == "settled"

    @cached_property
    def band(self) -> Band | None:
        """Range of the settled speed [m/s] that uncertain estimates in the robot's file leave; None without any."""
        if self.from_rest is not None or not (self.settled and math.isfinite(self.speed)):
            return None
        from hypertuna.swimming.band import speed_band  # imported here, since most swims need no band

        return speed_band(self.robot, Gaits.of([self.gait]))

    @cached_property
    def trajectory(self) -> xr.Dataset:
        """The motion at every step of the settled beat or of the run from rest; units are in the attributes."""
        return self._motion(1.0 if self.from_rest is None else self.from_rest * self.gait.frequency)

    def summary(self) -> dict[str, Quantity]:
        """Return the results by their names in JSON; results of a turn are hidden if the path is straight.

        Returns
        -------
        dict of Quantity
        """
        straight = self.turn_radius >= _core.NEARLY_STRAIGHT * self.robot.body.length
        hidden = {name: Format(unit, None) for name, (unit, _) in SUMMARY.items() if straight and name[:5] == "turn_"}
        return summarized(self, SUMMARY | hidden) | bend_summary(self.robot, self.bends)

    def continued(self, beats: int) -> xr.Dataset:
        """Return the motion over more beats, from the start of `trajectory`.

        Parameters
        ----------
        beats : int
            Number of beats, at least 1.

        Returns
        -------
        xarray.Dataset
            As `trajectory`; for one beat of a settled gait it is equal to `trajectory`.
        """
        return self._motion(float(BEATS.check(beats, "beats", "give a whole number of beats")))

    def _motion(self, beats: float) -> xr.Dataset:
        """Integrate the motion over a number of beats from the start; return its dataset."""
        count = round(beats * self.steps)
        step = 1 / (self.gait.frequency * self.steps)
        clock: Array = np.pi / self.steps * (np.arange(2 * count + 1, dtype=np.float64) % (2 * self.steps))
        model = core_model(self.robot)
        motor_joints = joints = _core.joint_motion(model, **vars(self.gait), clock=clock)
        hinge_power: Array | float = 0.0
        if self.bends:
            joints = bend_joints(self.robot, self.gait, motor_joints, self._state, self.steps)
            hinge_power = moment_power(self.robot, clock, joints - motor_joints)[::2]
        twist = twist_from_rest(self.robot, joints[0]) if self._start is None else self._start
        motion = _core.advance(model, joints, step=step, twist=twist, pose=np.zeros(3))
        time = step * np.arange(count + 1, dtype=np.float64)
        driven: dict[str, Any] = {"driven": motor_joints[::2], "hinge_power": hinge_power}
        return trajectory(self.robot, time, joints[::2], motion, current=self.current, **driven)


@checked
def swim(
    robot: Robot | str | Path,
    gait: Gait | str,
    *,
    from_rest: float | None = None,
    steps: int = DEFAULT_STEPS,
    current: tuple[float, float] = (0.0, 0.0),
) -> Swim:
    """Swim a gait: solve for its settled beat, or integrate from rest.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    gait : Gait or str
        Gait, or the name of one of the robot's.
    from_rest : float, optional
        Integrate from rest for this many seconds [s] instead of solving for the settled beat. At rest there is no
        momentum, and joints that start to move cannot create any: the head moves at once.
    steps : int
        Runge-Kutta steps per beat, a multiple of 4.
    current : tuple of float
        Uniform velocity of the water in the frame of the trajectory, x and y [m/s]. It carries the robot along;
        speed and cost of transport are through the water.

    Returns
    -------
    Swim
        With a `status`: whether the gait is settled; and whether a start from rest leads to the settled beat.

    Raises
    ------
    InputError
        If the gait does not fit the robot, or an option is out of range.

    Examples
    --------
    >>> import hypertuna as ht
    >>> gait = ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40))
    >>> round(ht.swim(ht.load("hypertuna"), gait).speed, 3)
    0.578
    """
    robot = robot_of(robot)
    gait = gait_of(robot, gait)
    check_steps(steps)
    wait = -1
    if from_rest is not None:
        # n / f seconds are n beats, however the quotient was rounded
        beats_swum = from_rest * gait.frequency * (1 + 1e-12)
        if not 1 <= beats_swum <= MAX_BEATS:
            rule = f"must last between one beat and {MAX_BEATS} beats"
            value = f"{from_rest:g} s of {gait.frequency:g} Hz"
            raise InputError(rule, key="from_rest", value=value, fix="give the seconds to swim")
        wait = int(beats_swum) - 1
    if np.shape(current) != (2,) or not np.isfinite(current).all():
        raise InputError("must be two finite numbers", key="current", value=str(current), fix="give m/s along x and y")
    gaits, carried = Gaits.of([gait]), (float(current[0]), float(current[1]))
    if from_rest is not None:
        last = _swim(robot, gait, settle(robot, gaits, steps=steps, wait=wait), steps, carried, from_rest)
        if last.status == "diverged":
            return last
        status, text = _verdict_from_rest(last, swim(robot, gait, steps=steps))
        return replace(last, status=status, status_text=text)
    result = settle(robot, gaits, steps=steps, approach=APPROACH)
    settled = _swim(robot, gait, result, steps, carried)
    if settled.status == "diverged":
        return settled
    reached, elsewhere = bool(result["arrived"][0]), None
    if not reached:
        other = settle_from_rest(robot, gaits, steps=steps)
        if STATUSES[other["status"][0]] == "settled":
            elsewhere, result = _swim(robot, gait, other, steps, carried), other
    text = _start_text(settled, reached, elsewhere, int(result["approach_beats"][0]))
    return replace(settled, status_text=text, reached_from_rest=reached, settled_from_rest=elsewhere)


def _swim(
    robot: Robot,
    gait: Gait,
    result: Mapping[str, Any],
    steps: int,
    current: tuple[float, float],
    from_rest: float | None = None,
) -> Swim:
    """Return the swim of a settled beat, or of a run's last beat; its quantities are the core's, from `settle`."""
    values: dict[str, Any] = {name: float(result[name][0]) for name in QUANTITIES}
    status = STATUSES[result["status"][0]]
    text = _core.verdict(
        int(result["status"][0]),
        beats=values["beats"],
        distance=values["distance_to_settled"],
        spectral_radius=values["spectral_radius"],
        turn=values["turn_rate"] / gait.frequency,
    )
    multipliers, bends = result["multipliers"][0], bends_of(robot, result)
    if bends and status not in ("settled", "unstable"):
        text += f" {too_soft(softness(robot, gait.frequency))}"
    text += folds(bends)
    state = result["momentum"][0]
    return Swim(
        robot=robot,
        gait=gait,
        **values | {"beats": int(values["beats"])},
        multipliers=multipliers[np.argsort(-np.abs(multipliers))],
        status=status,
        status_text=text,
        reached_from_rest=None,
        settled_from_rest=None,
        steps=int(result["steps"][0]),
        current=current,
        from_rest=from_rest,
        bends=bends,
        _start=result["twist"][0].copy() if from_rest is None else None,
        _state=state.copy() if from_rest is None else np.zeros_like(state),
    )


def _start_text(settled: Swim, reached: bool, elsewhere: Swim | None, beats: int) -> str:
    """Return the status as a sentence, with the motion to which a start from rest leads."""
    if elsewhere is not None:
        where = f"{elsewhere.speed:.4g} m/s" if math.isfinite(elsewhere.speed) else "a body that spins"
        start = f"From rest the robot settles into another motion instead: {where}, in {beats} beats."
    elif settled.settled and reached:
        start = f"From rest the robot reaches this motion in {beats} beats."
    elif settled.settled:
        start = f"From rest the robot settles neither into this motion nor into another within {APPROACH} beats."
    else:
        return settled.status_text
    return f"{settled.status_text} {start}"


def _verdict_from_rest(last: Swim, settled: Swim) -> tuple[str, str]:
    """Return status and sentence of a run from rest; its last beat is compared with the settled beat that it nears."""
    beats, goal = last.beats, settled.settled_from_rest or settled
    if not goal.settled:
        return "unsettled", f"The gait is unsettled after {beats:.0f} beats from rest. {settled.status_text}"
    # The added scale is for gaits near rest: a thousandth of a body length per beat, or of a rad for a body that spins.
    moving = math.isfinite(last.speed) and math.isfinite(goal.speed)
    name, unit, least = ("speed", "m/s", goal.robot.body.length) if moving else ("turn_rate", "rad/s", 1.0)
    target, scale = getattr(goal, name), abs(getattr(goal, name)) + 1e-3 * goal.gait.frequency * least
    error = (getattr(last, name) - target) / scale
    words = label(name)
    if abs(error) < SETTLED:
        return "settled", f"The gait is settled after {beats:.0f} beats from rest, to {abs(error):.1e} of its {words}."
    difference = f"{abs(error) * scale:.2g} {unit} {'above' if error > 0 else 'below'} the settled {target:.4g} {unit}"
    return "unsettled", f"The gait is unsettled after {beats:.0f} beats from rest: its {words} is {difference}."


def settled_speed(robot: Robot, gait: Gait) -> float:
    """Return a gait's settled speed [m/s], with lagging joints if all bandwidths are known; NaN if unsettled."""
    return rounded_number(swim(with_known_lag(robot), gait).speed)


def with_known_lag(robot: Robot) -> Robot:
    """Return the robot with lagging joints if all bandwidths are known, else the robot unchanged."""
    all_known = all(group.bandwidth is not None for group in robot.joints)
    return robot.using(joints="bandwidth") if all_known else robot
