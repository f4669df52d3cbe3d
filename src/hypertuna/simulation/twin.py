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
from hypertuna.description.robot import Robot, require
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.ranges import FINITE
from hypertuna.simulation.plant import (
    STEP,
    check_command,
    checked_seed,
    command_columns,
    controller_of,
    found_faults,
    listed,
    open_loop,
    parts_of,
    settled_speed,
    steps_needed,
    steps_of,
    ticks_of,
)
from hypertuna.simulation.run import VARIABLES, TwinRun
from hypertuna.swimming.gait import Gait, check_gait

__all__ = ["STEP", "twin", "twins"]

Array = NDArray[np.float64]
T = TypeVar("T")

MEDIA = ("water", "air")
STARTS = ("rest", "swimming")
CONDITIONS = "status_at"


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
    if temperature is not None:
        temperature = FINITE.check(temperature, "temperature", "give the temperature of the oil in K")
    if command_lost_at != math.inf:
        FINITE.check(command_lost_at, "command_lost_at", "leave it out for a command without end")
    control = require(robot.controller, "controller", robot)
    tick = 1 / control.rate
    ticks = ticks_of(duration, tick)
    parts = parts_of(robot, medium, temperature)
    steps = steps_needed(tick, parts, robot) if step is None else steps_of(tick, step)
    columns = controller_of(robot if controller_robot is None else controller_robot)
    check_command(robot, gait, columns)
    if not closed_loop:
        columns = open_loop(columns)
    given = listed(faults)
    record = _core.simulate(
        parts.plant,
        _core.GaitCommand(_core.Controller(columns), command_columns(gait), lost_at=command_lost_at),
        _core.World({"clamped": medium == "air"}),
        sensors=_core.Sensors(parts.sensors, checked_seed(seed)),
        faults=found_faults(given, robot, duration),
        twist=_first_twist(robot, gait, start, medium),
        ticks=ticks,
        steps=steps,
    )
    done = int(record.pop("ticks")[0])
    return TwinRun(
        robot=robot,
        gait=gait,
        duration=duration,
        medium=medium,
        closed_loop=closed_loop,
        seed=seed,
        temperature=parts.temperature,
        start=start,
        faults_given=given,
        step=tick / steps,
        time=np.arange(done, dtype=np.float64) * tick,
        data=_data(record, done, len(robot.joints)),
        status="completed" if done == ticks else "diverged",
    )


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


def _first_twist(robot: Robot, gait: Gait, start: str, medium: str) -> Array:
    """Twist of the head at the start."""
    if start == "rest" or medium == "air":
        return np.zeros(6)
    return np.array([-settled_speed(robot, gait), 0.0, 0.0, 0.0, 0.0, 0.0])


def _data(record: dict[str, Array], done: int, joints: int) -> dict[str, Array]:
    """Name and cut what was recorded."""
    columns = {name: column[:done] for name, column in record.items()}
    columns["speed"] = -columns.pop("surge")
    data = {name: columns[name] for name in VARIABLES}
    for name in ("angle", "rate", "moment"):
        if columns[name].shape[1] > joints:
            data[f"hinge_{name}"] = columns[name][:, joints]
            data[name] = columns[name][:, :joints]
    return data | {CONDITIONS: columns[CONDITIONS]}


def _check_choice(key: str, value: str, known: Sequence[str]) -> None:
    if value not in known:
        fix = did_you_mean(value, known)
        raise InputError(f"must be {' or '.join(known)}", key=key, value=shown(value), fix=fix)
