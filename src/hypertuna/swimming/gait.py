"""Harmonic gaits: one sine per joint group."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.ranges import FINITE, POSITIVE

# Largest magnitude of each angle [rad]: half a turn of a joint, and a phase whose sine is still exact.
LARGEST = {"amplitude": math.pi * (1 + 1e-12), "phase": 1e4, "bias": math.pi * (1 + 1e-12)}


@dataclass(frozen=True)
class Gait:
    """A periodic motion of the joint groups.

    Group g bends by alpha_g(t) = bias_g + amplitude_g sin(2 pi frequency t - phase_g), so phase is the lag behind
    the clock of the first group (Eq. 37 of the paper, settled).

    Parameters
    ----------
    frequency : float
        Beat frequency [Hz], greater than 0.
    amplitude : sequence of float, shape (groups,)
        Amplitude of each joint group [rad], not negative.
    phase : sequence of float, shape (groups,)
        Lag of each joint group [rad].
    bias : sequence of float, shape (groups,), optional
        Mean angle of each joint group [rad], counter-clockwise; left out, it is zero.

    Raises
    ------
    InputError
        If a value is not finite, frequency is not positive, an amplitude is negative, an amplitude or bias is more
        than half a turn, or lengths differ.
    """

    frequency: float
    amplitude: tuple[float, ...]
    phase: tuple[float, ...]
    bias: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        _keep(self, self.frequency, self.amplitude, self.phase, self.bias, unit=1.0)

    @classmethod
    def from_degrees(
        cls,
        *,
        frequency: float,
        amplitude: Sequence[float],
        phase: Sequence[float],
        bias: Sequence[float] | None = None,
    ) -> Self:
        """Make a gait from angles in degrees.

        Parameters
        ----------
        frequency : float
            Beat frequency [Hz], greater than 0.
        amplitude, phase, bias : sequence of float, shape (groups,)
            As for `Gait`, but in degrees [deg].

        Returns
        -------
        Gait
            In radians.

        Raises
        ------
        InputError
            As `Gait` does, with the value in degrees.

        Examples
        --------
        >>> gait = Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40))
        >>> round(gait.phase[1], 4)
        0.6981
        """
        gait = cls.__new__(cls)
        _keep(gait, frequency, amplitude, phase, () if bias is None else bias, unit=math.pi / 180)
        return gait


def check_gait(gait: Gait, robot: Robot) -> None:
    """Check that a gait fits a robot."""
    groups = len(robot.joints)
    if len(gait.amplitude) != groups:
        names = ", ".join(group.name for group in robot.joints)
        raise InputError(
            f"must be {groups} long, one value per joint group of {robot.name} ({names})",
            key="amplitude",
            value=f"{len(gait.amplitude)} long",
            fix=f"give {groups} values for amplitude, phase and bias each",
        )


def named_gait(robot: Robot, name: str) -> Gait:
    """Return a gait of the robot's description by its name.

    Parameters
    ----------
    robot : Robot
    name : str
        A key of the table ``[gaits]``.

    Returns
    -------
    Gait

    Raises
    ------
    InputError
        If the robot has no gait of that name.
    """
    if name not in robot.gaits:
        fix = did_you_mean(name, robot.gaits)
        raise InputError("must be a gait of the robot", file=robot.file, key="gait", value=shown(name), fix=fix)
    known = robot.gaits[name]
    return Gait(known.frequency, known.amplitude, known.phase, known.bias)


def _keep(
    gait: Gait,
    frequency: float,
    amplitude: Sequence[float],
    phase: Sequence[float],
    bias: Sequence[float],
    *,
    unit: float,
) -> None:
    """Check the values as given and set the fields of a frozen gait, angles times their unit."""
    beat = POSITIVE.check(frequency, "frequency", "give it in Hz")
    angles = {"amplitude": _list(amplitude, "amplitude"), "phase": _list(phase, "phase"), "bias": _list(bias, "bias")}
    groups = len(angles["amplitude"])
    angles["bias"] = angles["bias"] or (0.0,) * groups
    for key, values in angles.items():
        if len(values) != groups:
            rule = f"must be {groups} long, as amplitude is"
            raise InputError(rule, key=key, value=f"{len(values)} long", fix="give one value per joint group")
    for key, values in angles.items():
        for g, value in enumerate(values):
            if key == "amplitude" and value < 0:
                fix = "add half a turn to its phase instead"
                raise InputError("must not be negative", key=f"amplitude[{g}]", value=f"{value:g}", fix=fix)
            if abs(value) * unit > LARGEST[key]:
                rule = f"must be at most {LARGEST[key] / unit:g} {'rad' if unit == 1 else 'deg'}"
                raise InputError(rule, key=f"{key}[{g}]", value=f"{value:g}", fix="check its unit")
    object.__setattr__(gait, "frequency", beat)
    for key, values in angles.items():
        object.__setattr__(gait, key, tuple(value * unit for value in values))


def _list(values: Sequence[float], key: str) -> tuple[float, ...]:
    """Return finite numbers, one per joint group."""
    fix = "give one angle per joint group"
    try:
        items = list(values)
    except TypeError:
        raise InputError("must be a list of numbers", key=key, value=shown(values), fix=fix) from None
    return tuple(FINITE.check(value, f"{key}[{g}]", fix) for g, value in enumerate(items))
