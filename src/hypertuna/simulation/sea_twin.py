"""The twin at sea: the whole robot in space, with fins, weight, buoyancy, current, surface and bottom.

The equations stand in core body6.hpp; docs/spatial.md tells what they say and what is left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.control import Controller
from hypertuna.errors import InputError, shown
from hypertuna.frames import attitude_of
from hypertuna.ranges import FINITE, POSITIVE_WHOLE
from hypertuna.simulation.plant import EXACT, run_command
from hypertuna.simulation.sea import Sea, world_at_sea
from hypertuna.simulation.sea_run import SeaRun
from hypertuna.swimming.gait import Gait, check_gait

__all__ = ["twin_at_sea"]

Array = NDArray[np.float64]
Fins = float | ArrayLike | Callable[[float], ArrayLike]

STILL = Sea()


def twin_at_sea(
    robot: Robot,
    gait: Gait,
    *,
    duration: float,
    fins: Fins = 0.0,
    sea: Sea = STILL,
    depth: float = 2.0,
    roll: float = 0.0,
    pitch: float = 0.0,
    heading: float = 0.0,
    speed: float | None = None,
    faults: str | Iterable[str] = (),
    seed: int = 0,
    closed_loop: bool = True,
    temperature: float | None = None,
    step: float | None = None,
    command_lost_at: float = math.inf,
    every: int = 1,
) -> SeaRun:
    """Run the robot's twin in space under one command.

    Parameters
    ----------
    robot : Robot
        With all that `twin` takes, and the tables spatial and fins.
    gait : Gait
        The command, from the first tick on.
    duration : float
        Of the run [s].
    fins : float, array_like or callable
        Angle that both pectoral fins are told, leading edge up: one, or one each, port first; or what returns that at a
        time [rad].
    sea : Sea
        Still and deep if left out.
    depth : float
        Of the nose at the start [m].
    roll, pitch, heading : float
        At the start: starboard down, nose up, clockwise from north [rad].
    speed : float, optional
        Through the water at the start, ahead; that of the settled beat in the plane if left out [m/s].
    faults : str or iterable of str
        Sensor faults as on the command line: ``"bend-II:stuck@5"``.
    seed : int
        Of the sensors' noise.
    closed_loop : bool
        Whether posture control corrects amplitude and bias.
    temperature : float, optional
        Of the oil [K].
    step : float, optional
        Of the inner integration, as in `twin` [s].
    command_lost_at : float
        Time from which no command comes any more [s].
    every : int
        Ticks from one row of the record to the next.

    Returns
    -------
    SeaRun

    Raises
    ------
    InputError
        If the robot lacks a table, the command does not fit it, or an option is out of range.

    Examples
    --------
    >>> import hypertuna as ht
    >>> fish = ht.load("hypertuna")
    >>> gait = ht.Gait.from_degrees(frequency=2, amplitude=(8, 12), phase=(0, 20))
    >>> run = ht.twin_at_sea(fish, gait, duration=3, fins=-0.5, depth=1)
    >>> bool(run.depth[-1] > 1)
    True
    """
    check_gait(gait, robot)
    control = require(robot.controller, "controller", robot)
    fields = run_command(
        robot,
        gait,
        world_at_sea(robot, sea),
        medium="water",
        duration=duration,
        faults=faults,
        seed=seed,
        closed_loop=closed_loop,
        temperature=temperature,
        step=step,
        command_lost_at=command_lost_at,
        speed=None if speed is None else FINITE.check(speed, "speed", "give it in m/s"),
        pose=_pose(depth, roll, pitch, heading, sea),
        fins=lambda ticks, tick: _fin_angles(fins, ticks, tick, control),
        every=_every(every),
    )
    return SeaRun(**fields, sea=sea)


def _every(every: int) -> int:
    return POSITIVE_WHOLE.check(every, "every", "give a whole number of ticks")


def _pose(depth: float, roll: float, pitch: float, heading: float, sea: Sea) -> Array:
    """Position, attitude and fins at the start."""
    depth = FINITE.check(depth, "depth", "give the depth of the nose in m")
    if not 0 <= depth < sea.bottom:
        rule = f"must be from 0 to the bottom at {sea.bottom:g} m"
        raise InputError(rule, key="depth", value=f"{depth:g}", fix="give the depth of the nose in m")
    angles = {"roll": roll, "pitch": pitch, "heading": heading}
    for key, angle in angles.items():
        FINITE.check(angle, key, "give it in radians")
    return np.concatenate([[0.0, 0.0, -depth], attitude_of(**angles), [0.0, 0.0]])


def _fin_angles(fins: Fins, ticks: int, tick: float, control: Controller) -> Array:
    """Target angles of both fins in every tick (ticks, 2) [rad]."""
    pairs: list[Any] = [fins(tick * k) for k in range(ticks)] if callable(fins) else [fins]
    try:
        angles = np.array([np.broadcast_to(np.asarray(pair, dtype=float), 2) for pair in pairs])
    except (TypeError, ValueError):
        fix = "give one angle in radians, or two, port first"
        raise InputError("must be one angle, or one for each fin", key="fins", value=shown(pairs[0]), fix=fix) from None
    largest = abs(angles).max()
    if not largest <= control.fin_max * (1 + EXACT):
        rule = f"must be at most {math.degrees(control.fin_max):g} deg, the controller.fin_max_deg"
        raise InputError(rule, key="fins", value=f"{math.degrees(largest):g} deg", fix="give less")
    return np.ascontiguousarray(np.broadcast_to(angles, (ticks, 2)))
