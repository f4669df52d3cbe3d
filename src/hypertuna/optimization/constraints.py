"""Limits that a gait must keep: of joints, drives and wake."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.sweep import Gaits

__all__ = ["Limit", "gait_limits", "gait_quantities"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Limit:
    """A constraint: a quantity that must not pass a limit.

    Attributes
    ----------
    quantity : str
        One of `hypertuna.swimming.beat.QUANTITIES`, or of the `gait_quantities` of the gait alone.
    limit : float
        [unit of the quantity].
    upper : bool
        Whether it is the largest allowed value, not the smallest.
    unit : str
        Unit that the limit is told in.
    scale : float
        That unit in SI [unit of the quantity].
    """

    quantity: str
    limit: float
    upper: bool = True
    unit: str = "1"
    scale: float = 1.0


def gait_limits(
    robot: Robot,
    *,
    joint_rate: float | None = None,
    torque: float | None = None,
    amplitude_by_bandwidth: bool = False,
    strouhal: tuple[float, float] | None = None,
    speed: float | None = None,
) -> tuple[Limit, ...]:
    """Make the limits that a robot's joints, drives and wake set.

    Parameters
    ----------
    robot : Robot
    joint_rate : float, optional
        Largest rate of any joint group [rad/s].
    torque : float, optional
        Largest magnitude of any joint's torque [N m].
    amplitude_by_bandwidth : bool
        Whether no joint group may be commanded more than it makes of its largest amplitude at that frequency,
        A <= A_max / sqrt(1 + (f/f_b)^2). It matters with ideal joints, which do not lose amplitude themselves.
    strouhal : tuple of float, optional
        Smallest and largest Strouhal number [1].
    speed : float, optional
        Least speed [m/s].

    Returns
    -------
    tuple of Limit

    Raises
    ------
    InputError
        If a limit is not positive, or a joint group lacks its largest amplitude or bandwidth.
    """
    given = {"joint_rate": joint_rate, "torque": torque, "speed": speed}
    given |= {} if strouhal is None else {"strouhal": min(strouhal)}
    for key, value in given.items():
        if value is not None and not (np.isfinite(value) and value > 0):
            raise InputError("must be greater than 0", key=key, value=f"{value:g}", fix="or leave it out")
    limits: list[Limit] = []
    groups = [group.name for group in robot.joints]
    if joint_rate is not None:
        limits += [Limit(f"rate_{name}", joint_rate, unit="deg/s", scale=np.pi / 180) for name in groups]
    if torque is not None:
        limits.append(Limit("torque_peak", torque, unit="N m"))
    if amplitude_by_bandwidth:
        _check_reach(robot)
        limits += [Limit(f"reach_{name}", 1.0) for name in groups]
    if strouhal is not None:
        if not strouhal[0] <= strouhal[1]:
            pair = f"{strouhal[0]:g}:{strouhal[1]:g}"
            raise InputError(
                "must be the lowest value, then the highest", key="strouhal", value=pair, fix="exchange them"
            )
        limits += [Limit("strouhal", strouhal[0], upper=False), Limit("strouhal", strouhal[1])]
    if speed is not None:
        limits.append(Limit("speed", speed, upper=False, unit="m/s"))
    return tuple(limits)


def gait_quantities(robot: Robot, gaits: Gaits) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return what follows from gaits alone, without swimming, and its derivatives.

    Parameters
    ----------
    robot : Robot
    gaits : Gaits

    Returns
    -------
    values : dict of ndarray, shape (gaits,)
        ``rate_GROUP``: largest rate of the joint group [rad/s]; ``reach_GROUP``: its commanded amplitude over what it
        would make of its largest at that frequency [1].
    slopes : dict of ndarray, shape (gaits, 1 + 3 groups)
        By frequency, then amplitude, phase and bias of every group.
    """
    f, values, slopes = gaits.frequency, {}, {}
    for g, group in enumerate(robot.joints):
        amplitude = gaits.amplitude[:, g]
        bandwidth = np.inf if group.bandwidth is None else group.bandwidth
        loss = np.sqrt(1 + (f / bandwidth) ** 2)  # commanded over made amplitude of a first-order lag
        d_loss = f / (bandwidth**2 * loss)
        made, d_made = (1.0, 0.0) if robot.model.joints == "ideal" else (1 / loss, -d_loss / loss**2)
        largest = np.nan if group.amplitude_max is None else group.amplitude_max
        for name, value, by_frequency, by_amplitude in (
            ("rate", f * made * amplitude, (made + f * d_made) * amplitude, f * made),
            ("reach", loss * amplitude / largest, d_loss * amplitude / largest, loss / largest),
        ):
            unit = 2 * np.pi if name == "rate" else 1.0
            slope = np.zeros((len(f), 1 + 3 * len(robot.joints)))
            slope[:, 0], slope[:, 1 + g] = unit * by_frequency, unit * by_amplitude
            values[f"{name}_{group.name}"], slopes[f"{name}_{group.name}"] = unit * value, slope
    return values, slopes


def _check_reach(robot: Robot) -> None:
    """Check that amplitudes can be limited by bandwidth."""
    for g, group in enumerate(robot.joints):
        for key, value in (("amplitude_max_deg", group.amplitude_max), ("bandwidth_hz", group.bandwidth)):
            if value is None:
                rule = "is needed to limit the amplitude by bandwidth"
                raise InputError(rule, file=robot.file or None, key=f"joints[{g}].{key}", fix="add it to the file")
