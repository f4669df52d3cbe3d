"""Harmonic gaits, one sine per joint group: one gait, a list of gaits, a grid."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Displayed, Plotted, Tabular
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.swimming.gait_checks import AXES as AXES
from hypertuna.swimming.gait_checks import KINDS as KINDS
from hypertuna.swimming.gait_checks import NEEDED as NEEDED
from hypertuna.swimming.gait_checks import checked_values, largest
from hypertuna.swimming.gait_checks import grid_axes as grid_axes

MAX_GAITS = 10_000_000  # most gaits of a grid in memory: 2 GB of results


@dataclass(frozen=True)
class Gait(Plotted, Tabular, data=lambda gait: gait_table([gait])):
    """A periodic motion of the joint groups.

    Group g bends by alpha_g(t) = bias_g + amplitude_g sin(2 pi frequency t - phase_g), so phase is the lag behind
    the clock of the first group (Eq. 37 of the paper, without its transient).

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
        than half a turn, a phase more than one turn for each joint group before its own, or lengths differ.
    """

    frequency: float
    amplitude: tuple[float, ...]
    phase: tuple[float, ...]
    bias: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        angles = {kind: getattr(self, kind) for kind in KINDS}
        for name, value in checked_values(self.frequency, angles, unit=1.0).items():
            object.__setattr__(self, name, value)

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
        frequency, amplitude, phase, bias
            As in `Gait`, but with angles in degrees [Hz, deg].

        Returns
        -------
        Gait

        Raises
        ------
        InputError
            For the same reasons as `Gait`, with the value in degrees.

        Examples
        --------
        >>> gait = Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40))
        >>> round(gait.phase[1], 4)
        0.6981
        """
        angles = {"amplitude": amplitude, "phase": phase, "bias": () if bias is None else bias}
        return cls(**checked_values(frequency, angles, unit=math.pi / 180))

    @property
    def values(self) -> Array:
        """Frequency [Hz], then amplitude, phase and bias of every joint group [rad], shape (1 + 3 groups,)."""
        return np.array([self.frequency, *self.amplitude, *self.phase, *self.bias])


def gait_table(gaits: Sequence[Gait]) -> dict[str, Any]:
    """Return gaits as columns, with the angles of each joint group in degrees."""
    columns: dict[str, Any] = {"frequency_hz": [gait.frequency for gait in gaits]}
    for kind in KINDS:
        for g, angles in enumerate(np.degrees([getattr(gait, kind) for gait in gaits]).round(10).T):
            columns[f"{kind}_{g + 1}_deg"] = angles
    return columns


def lags(gait: Gait) -> list[float]:
    """Return each joint group's lag behind the first [rad], from -pi to pi."""
    return [math.remainder(phase - gait.phase[0], 2 * math.pi) for phase in gait.phase]


@dataclass(frozen=True)
class Gaits(Displayed, Tabular, data=lambda gaits: gait_table(list(gaits))):
    """Many gaits: a list, or a grid of any size, of which only the axes are in memory."""

    # A list has a row for each gait; a grid has the values along each of its axes.
    frequency: Array  # (gaits,) [Hz]
    amplitude: Array  # (gaits, groups) [rad]
    phase: Array  # (gaits, groups) [rad]
    bias: Array  # (gaits, groups) [rad]
    # (gaits,) of a list; (frequencies, amplitudes, phases, biases) of a grid, in which the biases change fastest
    shape: tuple[int, ...] = field(kw_only=True)
    degrees: bool = field(default=False, kw_only=True)  # whether a sweep labels its axes in degrees, as they were given

    def __post_init__(self) -> None:
        if self.is_grid:
            axes = grid_axes({name: getattr(self, name) for name in AXES}, 1.0)
            if (sizes := tuple(map(len, axes.values()))) != self.shape:
                raise InputError(f"must be {sizes}", key="shape", value=f"{self.shape}", fix="use Gaits.grid")
            for name, axis in axes.items():
                object.__setattr__(self, name, axis)
            return
        count, groups = len(self.frequency), np.shape(self.amplitude)[-1]
        for name, column in zip(KINDS, self.columns[1:], strict=True):
            if np.shape(column) != (count, groups):
                rule = f"must have the shape ({count}, {groups}), one row per gait"
                fix = "give an angle per joint group"
                raise InputError(rule, key=name, value=f"{np.shape(column)}", fix=fix)
        if math.prod(self.shape) != count:
            rule = f"must multiply to {count}, the number of gaits"
            raise InputError(rule, key="shape", value=f"{self.shape}", fix="use Gaits.of or Gaits.grid")
        valid = np.isfinite(self.frequency) & (self.frequency > 0) & (self.amplitude >= 0).all(axis=1)
        for name, column in zip(KINDS, self.columns[1:], strict=True):
            valid &= (np.abs(column) <= [largest(name, g) for g in range(groups)]).all(axis=1)
        if not valid.all():
            self[int(np.argmin(valid))]  # raises the error of this gait

    @classmethod
    def of(cls, gaits: Sequence[Gait]) -> Self:
        """Return a list of gaits as `Gaits`.

        Parameters
        ----------
        gaits : sequence of Gait
            At least one, all with equally many joint groups.

        Returns
        -------
        Gaits
        """
        if not isinstance(gaits, Sequence) or not all(isinstance(gait, Gait) for gait in gaits):
            fix = "give what Gait, Gaits.grid or Gaits.grid_degrees return"
            raise InputError("must be a list of gaits", key="gaits", value=shown(gaits), fix=fix)
        if not gaits:
            raise InputError("must hold at least one gait", key="gaits", value="empty", fix="give the gaits to swim")
        if len({len(gait.amplitude) for gait in gaits}) > 1:
            fix = "give every gait one value per joint group"
            raise InputError("must have equally many joint groups", key="gaits", fix=fix)
        columns = (np.array([getattr(gait, name) for gait in gaits]) for name in ("frequency", *KINDS))
        return cls(*columns, shape=(len(gaits),))

    @classmethod
    def grid(
        cls,
        *,
        frequency: Sequence[float],
        amplitude: Sequence[Sequence[float]],
        phase: Sequence[Sequence[float]],
        bias: Sequence[Sequence[float]] | None = None,
    ) -> Self:
        """Combine every frequency with every amplitude, phase and bias.

        Parameters
        ----------
        frequency, amplitude, phase, bias
            Values along each axis, each as in `Gait` [Hz, rad].

        Returns
        -------
        Gaits

        Raises
        ------
        InputError
            For the same reasons as `Gait`, at the first invalid value.
        """
        return cls._grid({"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias}, unit=1.0)

    @classmethod
    def grid_degrees(
        cls,
        *,
        frequency: Sequence[float],
        amplitude: Sequence[Sequence[float]],
        phase: Sequence[Sequence[float]],
        bias: Sequence[Sequence[float]] | None = None,
    ) -> Self:
        """Combine every frequency with every amplitude, phase and bias, given in degrees.

        Parameters
        ----------
        frequency, amplitude, phase, bias
            As in `Gaits.grid`, but with angles in degrees [Hz, deg].

        Returns
        -------
        Gaits

        Raises
        ------
        InputError
            For the same reasons as `Gait`, at the first invalid value, in degrees.

        Examples
        --------
        >>> phase = [(0, lag / 100) for lag in range(10_000)]
        >>> len(Gaits.grid_degrees(frequency=range(1, 7), amplitude=[(8, a) for a in range(100)], phase=phase))
        6000000
        """
        axes = {"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias}
        return cls._grid(axes, unit=math.pi / 180)

    @classmethod
    def _grid(cls, given: Mapping[str, Any], unit: float) -> Self:
        """Return a grid, given frequencies [Hz] and angles; unit: size of the angles' unit [rad]."""
        axes = grid_axes(given, unit)
        return cls(**axes, shape=tuple(map(len, axes.values())), degrees=unit != 1)

    @property
    def is_grid(self) -> bool:
        """Whether the gaits are a grid: all combinations of values along axes."""
        return len(self.shape) == len(AXES)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def __iter__(self) -> Iterator[Gait]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, k: int) -> Gait:
        index = np.unravel_index(k, self.shape) if self.is_grid else (k,) * len(AXES)
        frequency, *angles = (getattr(self, name)[n].tolist() for name, n in zip(AXES, index, strict=True))
        return Gait(frequency, *map(tuple, angles))

    @property
    def columns(self) -> tuple[Array, Array, Array, Array]:
        """Frequency [Hz], amplitude, phase and bias [rad] of each gait, as arrays for the core."""
        if self.is_grid:
            check_count(len(self))
            return part_of(self, 0, len(self)).columns
        frequency, *angles = (np.ascontiguousarray(getattr(self, name)) for name in AXES)
        return frequency, angles[0], angles[1], angles[2]


def part_of(gaits: Gaits, first: int, last: int) -> Gaits:
    """Return the gaits from index `first` to before `last` as a list."""
    rows = np.unravel_index(np.arange(first, last), gaits.shape) if gaits.is_grid else [slice(first, last)] * len(AXES)
    return Gaits(*(getattr(gaits, name)[k] for name, k in zip(AXES, rows, strict=True)), shape=(last - first,))


def check_count(gaits: int) -> None:
    """Check that a number of gaits fits in memory."""
    if gaits > MAX_GAITS:
        rule = f"must be at most {MAX_GAITS}"
        raise InputError(
            rule, key="the number of gaits", value=f"{gaits}", fix="take fewer values, or write shards, -o NAME.shards"
        )


def check_gait(gait: Gait, robot: Robot) -> None:
    """Check that a gait has one value per joint group of a robot."""
    groups = len(robot.joints)
    if len(gait.amplitude) != groups:
        names = ", ".join(group.name for group in robot.joints)
        rule = f"must be {groups} long, one value per joint group of {robot.name} ({names})"
        fix = f"give {groups} values for amplitude, phase and bias each"
        raise InputError(rule, key="amplitude", value=f"{len(gait.amplitude)} long", fix=fix)


def gait_of(robot: Robot, gait: Gait | str) -> Gait:
    """Check that a gait fits a robot, and return it; a text is the name of a gait in the robot's file."""
    gait = named_gait(robot, gait) if isinstance(gait, str) else gait
    check_gait(gait, robot)
    return gait


@checked
def named_gait(robot: Robot | str | Path, name: str) -> Gait:
    """Return a gait of the robot's description by its name.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    name : str
        A key of the table ``[gaits]``.

    Returns
    -------
    Gait
    """
    robot = robot_of(robot)
    if name not in robot.gaits:
        fix = did_you_mean(name, robot.gaits)
        raise InputError("must be a gait of the robot", file=robot.file, key="gait", value=shown(name), fix=fix)
    found = robot.gaits[name]
    return Gait(found.frequency, found.amplitude, found.phase, found.bias)


def gait_text(gait: Gait) -> str:
    """Return a gait as text, with the words of the command line's options."""
    kinds = KINDS if any(gait.bias) else NEEDED
    angles = (
        f"{key} {', '.join(f'{a:.4g}' for a in np.degrees(getattr(gait, key)).round(6) + 0.0)} deg" for key in kinds
    )
    return f"{gait.frequency:g} Hz, {', '.join(angles)}"


def gait_degrees(gait: Gait, kinds: Sequence[str] = KINDS) -> dict[str, Any]:
    """Return frequency [Hz] and angles [deg] of a gait, by their keys in JSON records."""
    angles = {f"{key}_deg": np.degrees(getattr(gait, key)).round(10).tolist() for key in kinds}
    return {"frequency_hz": gait.frequency} | angles


def gait_record(gait: Gait) -> dict[str, Any]:
    """Return a gait as a table of a robot file; the bias is left out if it is zero."""
    return gait_degrees(gait, KINDS if any(gait.bias) else NEEDED)
