"""Sweep: many gaits at once, over lanes and threads; and exact derivatives."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.io.checkpoint import Journal
from hypertuna.io.files import dataset
from hypertuna.ranges import POSITIVE_WHOLE, check_choice
from hypertuna.swimming.beat import (
    APPROACH,
    DEFAULT_STEPS,
    QUANTITIES,
    STATUSES,
    directional_derivatives,
    settle,
    settle_from_rest,
)
from hypertuna.swimming.gait import KINDS, Gait, Gaits, check_gait, gait_of
from hypertuna.swimming.model import parameter_names, parameter_values

if TYPE_CHECKING:
    import xarray as xr

CHUNK = 1024  # gaits between two reports of progress, and before Ctrl-C ends a sweep


def thread_count(threads: int | None) -> int:
    """Return a number of threads, all processors for None."""
    if threads is None:
        return len(os.sched_getaffinity(0))
    return POSITIVE_WHOLE.check(threads, "threads", "leave it out for all processors")


@checked
def sweep(
    robot: Robot | str | Path,
    gaits: Gaits | Sequence[Gait],
    *,
    threads: int | None = None,
    steps: int = DEFAULT_STEPS,
    method: Literal["newton", "beats"] = "newton",
    beats: int = 50,
    check_rest: bool = False,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Swim many gaits.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    gaits : Gaits or sequence of Gait
    threads, steps : int
        Threads, all processors if left out; the result does not depend on them. Runge-Kutta steps per beat, a multiple
        of 4.
    method : {"newton", "beats"}
    beats : int
        Solve for the settled beat, or swim this many beats from rest and take the last.
    check_rest : bool
        Whether to check that a start from rest leads to each settled beat, which takes three to four times as long.
    checkpoint : str or Path, optional
        File of a journal, from which the same call resumes after an interruption.
    progress : callable, optional
        Called with the number of gaits completed and their total.

    Returns
    -------
    xarray.Dataset
        Every quantity of `hypertuna.swimming.beat.QUANTITIES`, ``status`` and ``settled``, with dimensions frequency,
        amplitude, phase and bias for a grid, or gait for a list; angles of every joint group are coordinates such as
        ``amplitude_I`` [rad, or deg for `Gaits.grid_degrees`: their attribute ``units``]. Each dimension of a grid is
        indexed by the last joint group whose angle differs all along it: ``.sel(phase=40, method="nearest")``. A gait
        that diverged leaves the others untouched. With `check_rest` also ``reached_from_rest`` and
        ``speed_from_rest``; the attribute ``check_rest`` says whether it was done.

    Raises
    ------
    InputError
        If the gaits do not fit the robot.
    """
    robot = robot_of(robot)
    gaits = gaits if isinstance(gaits, Gaits) else Gaits.of(gaits)
    check_gait(gaits[0], robot)
    check_choice(method, ("newton", "beats"), "method")
    wait = POSITIVE_WHOLE.check(beats, "beats", "give the beats to swim from rest") - 1 if method == "beats" else -1
    if check_rest and wait >= 0:
        raise InputError("must be by newton to check starts from rest", key="method", value="beats", fix="leave it out")
    threads = thread_count(threads)
    names = (*QUANTITIES, "status", *(_FROM_REST if check_rest else ()))

    def swum(first: int, last: int) -> dict[str, Array]:
        part = Gaits(*(column[first:last] for column in gaits.columns), shape=(last - first,))
        result = settle(robot, part, steps=steps, wait=wait, approach=APPROACH * check_rest, threads=threads)
        if check_rest:
            result |= _from_rest(robot, part, result, steps, threads)
        return {name: result[name] for name in names}

    parts = []
    digest = hashlib.sha256(b"".join(np.ascontiguousarray(column).tobytes() for column in gaits.columns)).hexdigest()
    options = {"gaits": digest, "steps": steps, "wait": wait, "check_rest": check_rest, "chunk": CHUNK}
    with Journal(checkpoint, journal_header("sweep", robot, options)) as journal:
        for first in range(0, len(gaits), CHUNK):
            last = min(first + CHUNK, len(gaits))
            if checkpoint is None:
                parts.append(swum(first, last))
            else:
                kept = journal.answer([first, last], lambda: swum(first, last))  # noqa: B023 - called at once
                parts.append({name: np.array(kept[name], _TYPES.get(name, np.float64)) for name in names})
            if progress is not None:
                progress(last, len(gaits))
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return _dataset(robot, gaits, whole, {"steps": steps, "method": method, "check_rest": int(check_rest)})


_TYPES = {"status": np.int8, "reached_from_rest": np.bool_}  # of results that are no float64
_FROM_REST = {
    "reached_from_rest": {"long_name": "whether a start from rest leads to this beat"},
    "speed_from_rest": {"units": "m/s", "long_name": "speed of the settled beat that a start from rest leads to"},
}


def _from_rest(robot: Robot, gaits: Gaits, result: dict[str, Any], steps: int, threads: int) -> dict[str, Any]:
    """Find the gaits whose settled beat a start from rest leads to, and the speeds that the others lead to."""
    reached = result["arrived"] & (result["status"] == 0)
    speed = np.where(reached, result["speed"], np.nan)
    other = np.flatnonzero(~reached)
    if len(other):
        part = Gaits(*(column[other] for column in gaits.columns), shape=(len(other),))
        found = settle_from_rest(robot, part, steps=steps, threads=threads)
        speed[other] = np.where(found["status"] == 0, found["speed"], np.nan)
    return {"reached_from_rest": reached, "speed_from_rest": speed}


def _dataset(robot: Robot, gaits: Gaits, results: dict[str, Any], how: dict[str, Any]) -> xr.Dataset:
    """Label the results of a sweep."""
    grid = len(gaits.shape) == 4
    dims = ("frequency", *KINDS) if grid else ("gait",)
    variables: dict[str, Any] = {
        name: (dims, results[name].reshape(gaits.shape), *meaning) for name, meaning in QUANTITIES.items()
    }
    status = results["status"].reshape(gaits.shape)
    variables |= {
        name: (dims, results[name].reshape(gaits.shape), about) for name, about in _FROM_REST.items() if name in results
    }
    flags = {"flag_values": list(range(len(STATUSES))), "flag_meanings": " ".join(STATUSES)}
    variables["status"] = (dims, status, {"long_name": "how the search ended"} | flags)
    variables["settled"] = (dims, status == 0, {"long_name": "whether the gait repeats itself and is stable"})
    coordinates: dict[str, Any] = {}
    unit = "deg" if gaits.degrees else "rad"
    for axis, name in enumerate(("frequency", *KINDS)):
        # Along its own axis of a grid an entry stands where all other indices are 0.
        pick = tuple(slice(None) if k == axis else 0 for k in range(4)) if grid else (slice(None),)
        values = getattr(gaits, name).reshape(*gaits.shape, -1)[pick]
        dim = name if grid else "gait"
        if name == "frequency":
            coordinates[name] = (dim, values[:, 0], "Hz", "beat frequency")
            continue
        values = np.degrees(values).round(10) if gaits.degrees else values
        for g, group in enumerate(robot.joints):
            coordinates[f"{name}_{group.name}"] = (dim, values[:, g], unit, f"{name} of joint group {group.name}")
        if grid and (index := _index(robot, name, values, unit)) is not None:
            coordinates[name] = index
    return dataset(variables, coordinates, provenance(robot) | how)


POWERS = ("mechanical_power", "mechanical_power_positive")
DERIVATIVES = ("speed", "cost_of_transport", *POWERS, "strouhal", "torque_peak", "rate_peak")
ANGLES = ("gait.amplitude", "gait.phase", "gait.bias", "joints.phase_offset")  # parameters in radians


def _index(robot: Robot, name: str, values: Array, unit: str) -> tuple[str, Array, dict[str, str]] | None:
    """Index an axis of a grid by the angles of one joint group: the last one that is different all along it."""
    for g in reversed(range(len(robot.joints))):
        if len(np.unique(values[:, g])) == len(values):
            group = robot.joints[g].name
            about = {"units": unit, "long_name": f"{name} of joint group {group}", "same_as": f"{name}_{group}"}
            return name, values[:, g], about
    return None


@dataclass(frozen=True)
class Gradient(
    Plotted,
    Tabular,
    card="hypertuna.swimming.cards:gradient_card",
    figure="hypertuna.swimming.plots_gait:plot_gradient",
    data=lambda gradient: gradient._columns(),
):
    """Exact derivatives of a settled gait's results."""

    names: tuple[str, ...]  # of the parameters, as attributes: gait.amplitude[1], links.mass[3], water.lumped.drag[7]
    speed: Array  # (parameters,) as all that follow, SI unit of the result per unit of the parameter
    cost_of_transport: Array
    mechanical_power: Array
    mechanical_power_positive: Array
    strouhal: Array
    torque_peak: Array
    rate_peak: Array
    values: Array  # (parameters,) of the parameters [SI]
    results: Mapping[str, float]  # at the gait, by the names of the derivatives [SI]
    robot: Robot
    gait: Gait

    def influence(self, quantity: str = "speed") -> Array:
        """Return how much each parameter changes a result.

        Parameters
        ----------
        quantity : str
            Name of a result: "speed", "cost_of_transport", ...

        Returns
        -------
        ndarray, shape (parameters,)
            Change of the result for 1 % more of the parameter, of an angle for 1 degree more [%].
        """
        check_choice(quantity, DERIVATIVES, "quantity")
        angle = [name.partition("[")[0] in ANGLES for name in self.names]
        known = np.where(np.isfinite(self.values), self.values, 0.0)  # an ideal joint has an infinite bandwidth
        change: Array = getattr(self, quantity) * np.where(angle, np.radians(1), 0.01 * known)
        return 100 * change / self.results[quantity]

    def _columns(self) -> dict[str, Any]:
        """Return the columns of a table, the largest influence on the speed first."""
        influence = {f"{name}_percent": self.influence(name) for name in DERIVATIVES}
        columns = {"parameter": np.array(self.names), "value_si": self.values} | influence
        order = np.argsort(-np.abs(influence["speed_percent"]), kind="stable")
        return {name: values[order] for name, values in columns.items()}


@checked
def gradient(robot: Robot | str | Path, gait: Gait | str, *, steps: int = DEFAULT_STEPS) -> Gradient:
    """Differentiate results of a settled gait by every coefficient and gait parameter, exactly.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    gait : Gait or str
        Gait, or the name of one of the robot's.
    steps : int
        Runge-Kutta steps per beat, a multiple of 4.

    Returns
    -------
    Gradient

    Raises
    ------
    InputError
        If the gait does not fit the robot, does not settle or has no speed: it then has no derivatives.
    """
    robot = robot_of(robot)
    gait = gait_of(robot, gait)
    gaits = Gaits.of([gait])
    result = settle(robot, gaits, steps=steps)
    status = STATUSES[result["status"][0]]
    if not any(gait.amplitude):
        raise InputError("must move the robot to have derivatives", key="gait", fix="give it an amplitude")
    if status not in ("settled", "unstable"):
        raise InputError("must settle to have derivatives", key="gait", value=status, fix="see hypertuna.swim")
    if np.isnan(result["speed"][0]):
        rule, value = "must have a speed to have derivatives", "turning by more than half a circle a beat"
        raise InputError(rule, key="gait", value=value, fix="give it less bias")
    names = parameter_names(robot)
    derivatives = directional_derivatives(robot, gaits, result, np.eye(len(names)), steps=steps)
    return Gradient(
        names,
        **{name: derivatives[name][0] for name in DERIVATIVES},
        values=parameter_values(robot, gait),
        results={name: float(result[name][0]) for name in DERIVATIVES},
        robot=robot,
        gait=gait,
    )
