"""Sweep: many gaits at once, over lanes and threads; and exact derivatives."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Literal, Self, cast

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, shown
from hypertuna.io.files import dataset
from hypertuna.ranges import POSITIVE_WHOLE
from hypertuna.swimming.beat import DEFAULT_STEPS, QUANTITIES, STATUSES, directional_derivatives, settle
from hypertuna.swimming.gait import LARGEST, Gait, check_gait
from hypertuna.swimming.model import parameter_names

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MAX_GAITS = 10_000_000  # of a grid: 2 GB of results
CHUNK = 16384  # gaits between two reports of progress: bounds the memory that is not result


@dataclass(frozen=True)
class Gaits:
    """Many gaits: a list, or a grid."""

    frequency: Array  # (gaits,) [Hz]
    amplitude: Array  # (gaits, groups) Of each joint group [rad]
    phase: Array  # (gaits, groups) Of each joint group [rad]
    bias: Array  # (gaits, groups) Of each joint group [rad]
    # (gaits,) of a list; (frequencies, amplitudes, phases, biases) of a grid, whose gaits are in that order,
    # the last changing fastest
    shape: tuple[int, ...]

    def __post_init__(self) -> None:
        count, groups = len(self.frequency), np.shape(self.amplitude)[-1]
        columns = {"amplitude": self.amplitude, "phase": self.phase, "bias": self.bias}
        for name, column in columns.items():
            if np.shape(column) != (count, groups):
                shape = f"{np.shape(column)}"
                rule = f"must have the shape ({count}, {groups}), one row per gait"
                raise InputError(rule, key=name, value=shape, fix="give an angle per joint group")
        if math.prod(self.shape) != count:
            rule = f"must multiply to {count}, the number of gaits"
            raise InputError(rule, key="shape", value=f"{self.shape}", fix="use Gaits.of or Gaits.grid")
        sound = np.isfinite(self.frequency) & (self.frequency > 0) & (self.amplitude >= 0).all(axis=1)
        for name, column in columns.items():
            sound &= (np.abs(column) <= LARGEST[name]).all(axis=1)
        if not sound.all():
            k = int(np.argmin(sound))  # raises the error of this one
            Gait(float(self.frequency[k]), *(tuple(column[k].tolist()) for column in columns.values()))

    @classmethod
    def of(cls, gaits: Sequence[Gait]) -> Self:
        """Put gaits in a list.

        Parameters
        ----------
        gaits : sequence of Gait
            With equally many joint groups.

        Returns
        -------
        Gaits

        Raises
        ------
        InputError
            If there is none, or they differ in their number of joint groups.
        """
        if not gaits:
            raise InputError("must hold at least one gait", key="gaits", value="empty", fix="give the gaits to swim")
        if len({len(gait.amplitude) for gait in gaits}) > 1:
            fix = "give every gait one value per joint group"
            raise InputError("must have equally many joint groups", key="gaits", fix=fix)
        amplitude, phase, bias = (
            np.array([getattr(gait, name) for gait in gaits]) for name in ("amplitude", "phase", "bias")
        )
        return cls(np.array([gait.frequency for gait in gaits]), amplitude, phase, bias, (len(gaits),))

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
        frequency : sequence of float
            [Hz].
        amplitude, phase, bias : sequence of sequence of float
            Each entry has one angle per joint group [rad]; no bias if left out.

        Returns
        -------
        Gaits

        Raises
        ------
        InputError
            As `Gait` does, at the first value that cannot be used.
        """
        bias = [(0.0,) * len(amplitude[0])] if bias is None and len(amplitude) else (bias or [])
        axes = [frequency, amplitude, phase, bias]
        for name, axis in zip(("frequency", "amplitude", "phase", "bias"), axes, strict=True):
            if not len(axis):
                raise InputError("must have at least one value", key=name, value="empty", fix="give a range or a list")
        # Each value is checked once, not once for every combination.
        for k in range(max(len(axis) for axis in axes)):
            f, a, p, b = (axis[min(k, len(axis) - 1)] for axis in (frequency, amplitude, phase, bias))
            Gait(cast(float, f), *(tuple(cast(Sequence[float], angles)) for angles in (a, p, b)))
        shape = tuple(len(axis) for axis in axes)
        if math.prod(shape) > MAX_GAITS:
            rule = f"must have at most {MAX_GAITS} gaits in all"
            raise InputError(rule, key="grid", value=f"{math.prod(shape)}", fix="take fewer values")
        index = np.indices(shape).reshape(4, -1)
        columns = [np.asarray(axis, dtype=np.float64)[k] for axis, k in zip(axes, index, strict=True)]
        return cls(columns[0], columns[1], columns[2], columns[3], shape)

    def __len__(self) -> int:
        return len(self.frequency)


def thread_count(threads: int | None) -> int:
    """Return a number of threads, all processors for None."""
    if threads is None:
        return len(os.sched_getaffinity(0))
    return POSITIVE_WHOLE.check(threads, "threads", "leave it out for all processors")


def sweep(
    robot: Robot,
    gaits: Gaits | Sequence[Gait],
    *,
    threads: int | None = None,
    steps: int = DEFAULT_STEPS,
    method: Literal["newton", "beats"] = "newton",
    beats: int = 50,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Swim many gaits.

    Parameters
    ----------
    robot : Robot
    gaits : Gaits or sequence of Gait
    threads : int, optional
        Threads to use, all processors if left out; the result does not depend on it.
    steps : int
        Runge-Kutta steps per beat, a multiple of 4.
    method : {"newton", "beats"}
        Solve for the settled beat, or swim `beats` beats from rest and take the last.
    beats : int
        For method "beats".
    progress : callable, optional
        Called with the number of gaits completed and their total.

    Returns
    -------
    xarray.Dataset
        Every quantity of `hypertuna.swimming.beat.QUANTITIES`, ``status`` and ``settled``, with dimensions frequency,
        amplitude, phase and bias for a grid, or gait for a list; angles of every joint group [rad] are coordinates
        such as ``amplitude_I``. A gait that diverged leaves the others untouched.

    Raises
    ------
    InputError
        If the gaits do not fit the robot.
    """
    gaits = gaits if isinstance(gaits, Gaits) else Gaits.of(gaits)
    check_gait(Gait(gaits.frequency[0], tuple(gaits.amplitude[0]), tuple(gaits.phase[0])), robot)
    if method not in ("newton", "beats"):
        raise InputError("must be 'newton' or 'beats'", key="method", value=shown(method), fix="leave it out")
    wait = POSITIVE_WHOLE.check(beats, "beats", "give the beats to swim from rest") - 1 if method == "beats" else -1
    threads = thread_count(threads)
    parts = []
    for first in range(0, len(gaits), CHUNK):
        here = slice(first, first + CHUNK)
        columns = (np.ascontiguousarray(a[here]) for a in (gaits.frequency, gaits.amplitude, gaits.phase, gaits.bias))
        result = settle(robot, *columns, steps=steps, wait=wait, threads=threads)
        parts.append({name: result[name] for name in (*QUANTITIES, "status")})
        if progress is not None:
            progress(min(first + CHUNK, len(gaits)), len(gaits))
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return _dataset(robot, gaits, whole, {"steps": steps, "method": method})


def _dataset(robot: Robot, gaits: Gaits, results: dict[str, Any], how: dict[str, Any]) -> xr.Dataset:
    """Label the results of a sweep."""
    grid = len(gaits.shape) == 4
    dims = ("frequency", "amplitude", "phase", "bias") if grid else ("gait",)
    variables: dict[str, Any] = {
        name: (dims, results[name].reshape(gaits.shape), {"units": quantity.unit, "long_name": quantity.meaning})
        for name, quantity in QUANTITIES.items()
    }
    status = results["status"].reshape(gaits.shape)
    flags = {"flag_values": list(range(len(STATUSES))), "flag_meanings": " ".join(STATUSES)}
    variables["status"] = (dims, status, {"long_name": "how the search ended"} | flags)
    variables["settled"] = (dims, status == 0, {"long_name": "whether the gait repeats itself and is stable"})
    coordinates: dict[str, Any] = {}
    for axis, name in enumerate(("frequency", "amplitude", "phase", "bias")):
        # Along its own axis of a grid an entry stands where all other indices are 0.
        pick = tuple(slice(None) if k == axis else 0 for k in range(4)) if grid else (slice(None),)
        values = getattr(gaits, name).reshape(*gaits.shape, -1)[pick]
        dim = name if grid else "gait"
        if name == "frequency":
            coordinates[name] = (dim, values[:, 0], {"units": "Hz", "long_name": "beat frequency"})
            continue
        for g, group in enumerate(robot.joints):
            text = f"{name} of joint group {group.name}"
            coordinates[f"{name}_{group.name}"] = (dim, values[:, g], {"units": "rad", "long_name": text})
    return dataset(variables, coordinates, provenance(robot) | how)


@dataclass(frozen=True)
class Gradient:
    """Exact derivatives of a settled gait's results."""

    names: tuple[str, ...]  # of the parameters, as attributes: gait.amplitude[1], links.mass[3], water.lumped.drag[7]
    speed: Array  # (parameters,) as all that follow, SI unit of the result per unit of the parameter
    cost_of_transport: Array
    power: Array
    power_positive: Array
    strouhal: Array
    torque_peak: Array
    rate_peak: Array


def gradient(robot: Robot, gait: Gait, *, steps: int = DEFAULT_STEPS) -> Gradient:
    """Differentiate results of a settled gait by every coefficient and gait parameter, exactly.

    Parameters
    ----------
    robot : Robot
    gait : Gait
    steps : int
        Runge-Kutta steps per beat, a multiple of 4.

    Returns
    -------
    Gradient

    Raises
    ------
    InputError
        If the gait does not fit the robot, or does not settle: it then has no derivatives.
    """
    check_gait(gait, robot)
    gaits = Gaits.of([gait])
    arrays = (gaits.frequency, gaits.amplitude, gaits.phase, gaits.bias)
    result = settle(robot, *arrays, steps=steps)
    status = STATUSES[result["status"][0]]
    if result["speed"][0] == 0:
        raise InputError("must move the robot to have derivatives", key="gait", fix="give it an amplitude")
    if status not in ("settled", "unstable"):
        raise InputError("must settle to have derivatives", key="gait", value=status, fix="see hypertuna.swim")
    names = parameter_names(robot)
    derivatives = directional_derivatives(robot, *arrays, result, np.eye(len(names)), steps=steps)
    results = (field.name for field in fields(Gradient) if field.name != "names")
    return Gradient(names, **{name: derivatives[name][0] for name in results})
