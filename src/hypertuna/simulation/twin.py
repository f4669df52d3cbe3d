"""Twin: the whole robot closed loop, from a command through servos, oil and silicone to the wake.

The equations stand in core tail.hpp, plant.hpp and twin.hpp; docs/twin.md tells what the twin shows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.simulation.plant import STEP, run_command
from hypertuna.simulation.run import TwinRun
from hypertuna.swimming.gait import Gait, check_gait

__all__ = ["STEP", "twin", "twins"]

Array = NDArray[np.float64]
T = TypeVar("T")

MEDIA = ("water", "air")
STARTS = ("rest", "swimming")


def twin(
    robot: Robot,
    gait: Gait,
    *,
    duration: float,
    medium: str = "water",
    faults: str | Iterable[str] = (),
    seed: int = 0,
    closed_loop: bool = True,
    temperature: float | None = None,
    start: str = "rest",
    step: float | None = None,
    command_lost_at: float = math.inf,
    controller_robot: Robot | None = None,
) -> TwinRun:
    """Run the robot's twin: command in, servo pulses, oil, bending tail, water, sensors, controller.

    Parameters
    ----------
    robot : Robot
        With the tables drive_unit, pump, oil, battery, servos, sensors, controller and, in each joint group, actuator
        and line.
    gait : Gait
        The command, from the first tick on.
    duration : float
        Of the run [s].
    medium : str
        ``"water"``: swimming freely. ``"air"``: the head held still, without water.
    faults : str or iterable of str
        Sensor faults as on the command line: ``"bend-II:stuck@5"``.
    seed : int
        Of the sensors' noise; the same seed gives the same run to the last bit.
    closed_loop : bool
        Whether posture control corrects amplitude and bias; else the pumps' inverse maps alone.
    temperature : float, optional
        Of the oil [K]. The controller goes on counting on the robot's own.
    start : str
        ``"rest"``, or ``"swimming"``: at the speed of the settled beat of joints that lag by their bandwidth.
    step : float, optional
        Of the inner Runge-Kutta integration [s]; it is rounded so that it divides the control tick. Left out, `STEP`,
        or less where the plant is stiffer: little air and compliance, wide lines, light rotors.
    command_lost_at : float
        Time from which no command comes any more [s].
    controller_robot : Robot, optional
        Robot that the controller takes this one for; itself if left out.

    Returns
    -------
    TwinRun

    Raises
    ------
    InputError
        If the robot lacks a table, the gait does not fit it or asks for more than its controller takes, or an option is
        out of range.

    Examples
    --------
    >>> import hypertuna as ht
    >>> fish = ht.load("hypertuna")
    >>> run = ht.twin(fish, ht.Gait.from_degrees(frequency=1, amplitude=(8, 12), phase=(0, 20)), duration=5)
    >>> run.status
    'completed'
    """
    check_gait(gait, robot)
    _check_choice("medium", medium, MEDIA)
    _check_choice("start", start, STARTS)
    fields = run_command(
        robot,
        gait,
        _core.World({"clamped": medium == "air"}),
        medium=medium,
        duration=duration,
        faults=faults,
        seed=seed,
        closed_loop=closed_loop,
        temperature=temperature,
        step=step,
        command_lost_at=command_lost_at,
        speed=0.0 if start == "rest" or medium == "air" else None,
        controller_robot=controller_robot,
    )
    return TwinRun(**fields, medium=medium, start=start)


def twins(runs: Sequence[Mapping[str, Any]], *, measure: Callable[[TwinRun], T], threads: int = 1) -> list[T]:
    """Run many twins over threads.

    Parameters
    ----------
    runs : sequence of mapping
        Arguments of `twin` by name, robot and gait among them, one mapping per run.
    measure : callable
        What to keep of each run; the whole record of one holds 1 MB per 10 s.
    threads : int
        The results do not depend on it.

    Returns
    -------
    list
        In the order of the runs.

    Raises
    ------
    InputError
        As `twin` does.
    """

    def one(options: Mapping[str, Any]) -> T:
        return measure(twin(**options))

    if threads <= 1:
        return [one(options) for options in runs]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(one, runs))


def _check_choice(key: str, value: str, known: Sequence[str]) -> None:
    if value not in known:
        fix = did_you_mean(value, known)
        raise InputError(f"must be {' or '.join(known)}", key=key, value=shown(value), fix=fix)
