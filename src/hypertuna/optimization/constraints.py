"""Limits that a gait must keep: on joints, drives and wake, and on speed, mass, length and bend."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, robot_of
from hypertuna.errors import InputError
from hypertuna.ranges import POSITIVE
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.yielding import bend_name


@dataclass(frozen=True)
class Limit:
    """A constraint: an upper or lower bound on a quantity of a gait."""

    quantity: str  # key of `hypertuna.swimming.beat.QUANTITIES` or of `gait_quantities`
    limit: float  # bound [unit of the quantity]
    upper: bool = True  # whether it is an upper bound
    unit: str = "1"  # unit in which the limit is printed
    scale: float = 1.0  # size of that unit [unit of the quantity]


@checked
def gait_limits(
    robot: Robot | str | Path,
    *,
    joint_rate: float | None = None,
    torque: float | None = None,
    amplitude_by_bandwidth: bool = False,
    strouhal: tuple[float, float] | None = None,
    speed: float | None = None,
    mass: float | None = None,
    length: float | None = None,
    bend: float | None = None,
) -> tuple[Limit, ...]:
    """Return limits for a search: on joints, drives and wake, and if given on speed, mass, length and bend.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    joint_rate : float, optional
        Max rate of any joint group [rad/s].
    torque : float, optional
        Max magnitude of any joint's torque [N m].
    amplitude_by_bandwidth : bool
        Whether to limit the commanded amplitude of each joint group to the amplitude that the group reaches at the
        gait's frequency, A <= A_max / sqrt(1 + (f/f_b)^2). Meant for ideal joints, which lose no amplitude themselves.
    strouhal : tuple of float, optional
        Min and max Strouhal number [1].
    speed : float, optional
        Min speed [m/s].
    mass, length : float, optional
        Max mass [kg] and length [m] of the robot, for searches over its design.
    bend : float, optional
        Max angle of each passive hinge [rad]; it has no derivatives.

    Returns
    -------
    tuple of Limit

    Raises
    ------
    InputError
        If a limit is not positive, a joint group lacks its max amplitude or bandwidth, or there is no hinge.
    """
    robot = robot_of(robot)
    values = {"joint_rate": joint_rate, "torque": torque, "speed": speed}
    values |= {"mass": mass, "length": length, "bend": bend}
    values["strouhal"] = None if strouhal is None else min(strouhal)
    for key, value in values.items():
        if value is not None:
            POSITIVE.check(value, key, "leave it out for no limit")
    limits: list[Limit] = []
    groups = [group.name for group in robot.joints]
    if joint_rate is not None:
        limits += [Limit(f"rate_{name}", joint_rate, unit="deg/s", scale=np.pi / 180) for name in groups]
    if torque is not None:
        limits.append(Limit("torque_peak", torque, unit="N m"))
    if amplitude_by_bandwidth:
        for g, group in enumerate(robot.joints):
            for key, bound in (("amplitude_max_deg", group.amplitude_max), ("bandwidth_hz", group.bandwidth)):
                if bound is None:
                    rule = "is needed to limit the amplitude by bandwidth"
                    raise InputError(rule, file=robot.file or None, key=f"joints[{g}].{key}", fix="add it to the file")
        limits += [Limit(f"reach_{name}", 1.0) for name in groups]
    if strouhal is not None:
        low, high = strouhal
        if not low <= high:
            rule = "must have the lower value first"
            raise InputError(rule, key="strouhal", value=f"{low:g}:{high:g}", fix="exchange them")
        limits += [Limit("strouhal", low, upper=False), Limit("strouhal", high)]
    if speed is not None:
        limits.append(Limit("speed", speed, upper=False, unit="m/s"))
    for name, unit, maximum in (("robot_mass", "kg", mass), ("robot_length", "m", length)):
        if maximum is not None:
            limits.append(Limit(name, maximum, unit=unit))
    if bend is not None:
        if not robot.hinges:
            rule, fix = "is of a passive hinge, which the robot lacks", "leave it out, or add the table [hinge]"
            raise InputError(rule, key="bend", file=robot.file or None, fix=fix)
        names = [bend_name(robot.hinges, "bend_peak", d) for d in range(len(robot.hinges))]
        limits += [Limit(name, bend, unit="deg", scale=np.pi / 180) for name in names]
    return tuple(limits)


def gait_quantities(robot: Robot, gaits: Gaits) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return quantities that need no simulation, shape (gaits,), and their gradients, shape (gaits, 1 + 3 groups).

    ``rate_GROUP`` is the max rate of a joint group [rad/s]; ``reach_GROUP`` is its commanded amplitude over the largest
    that it reaches at the gait's frequency [1]; ``robot_mass`` is in kg, ``robot_length`` in m. Gradients are with
    respect to frequency, then amplitude, phase and bias of every group.
    """
    f, values, gradients = gaits.frequency, {}, {}
    for g, group in enumerate(robot.joints):
        amplitude = gaits.amplitude[:, g]
        bandwidth = np.inf if group.bandwidth is None else group.bandwidth
        loss = np.sqrt(1 + (f / bandwidth) ** 2)  # commanded over actual amplitude of a first-order lag
        d_loss = f / (bandwidth**2 * loss)
        gain, d_gain = (1.0, 0.0) if robot.model.joints == "ideal" else (1 / loss, -d_loss / loss**2)
        largest = np.nan if group.amplitude_max is None else group.amplitude_max
        for name, unit, value, by_frequency, by_amplitude in (
            ("rate", 2 * np.pi, f * gain * amplitude, (gain + f * d_gain) * amplitude, f * gain),
            ("reach", 1.0, loss * amplitude / largest, d_loss * amplitude / largest, loss / largest),
        ):
            gradient = np.zeros((len(f), 1 + 3 * len(robot.joints)))
            gradient[:, 0], gradient[:, 1 + g] = unit * by_frequency, unit * by_amplitude
            values[f"{name}_{group.name}"], gradients[f"{name}_{group.name}"] = unit * value, gradient
    for name, total in (("robot_mass", robot.body.mass), ("robot_length", robot.body.length)):
        values[name], gradients[name] = np.full(len(f), total), np.zeros((len(f), 1 + 3 * len(robot.joints)))
    return values, gradients
