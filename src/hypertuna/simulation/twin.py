"""Twin: simulate the whole robot in closed loop, from a command through servos, oil and silicone to the wake.

The equations are in core tail.hpp, body6.hpp, plant.hpp and twin.hpp, with docs/twin.md and docs/spatial.md.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from hypertuna import _core
from hypertuna.arguments import checked, checked_arguments
from hypertuna.arrays import Array
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.robot import Robot, robot_of
from hypertuna.description.schema.control import Controller
from hypertuna.description.twin import require_controller
from hypertuna.errors import InputError, shown
from hypertuna.frames import attitude_of
from hypertuna.parallel.executors import Executors, map_shards, thread_count
from hypertuna.ranges import FINITE, POSITIVE_WHOLE, check_choice
from hypertuna.simulation.plant import TOLERANCE, PlannedRun, plan_command
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.sea import Sea, world_at_sea
from hypertuna.simulation.sea_run import SeaRun
from hypertuna.swimming.gait import Gait, gait_of

Fins = float | ArrayLike | Callable[[float], ArrayLike]  # fin angles [rad], or a function of time [s] that returns them
T = TypeVar("T")

STILL = Sea()  # still, deep water
CHUNK = 64  # runs per task of an executor


@checked
def twin(
    robot: Robot | str | Path,
    gait: Gait | str,
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
    """Run the robot's twin in the plane under one command: controller, servos, oil, bending tail, water and sensors.

    Parameters
    ----------
    robot : Robot, str or Path
        With the tables drive_unit, pump, oil, battery, servos, sensors, controller and, in each joint group, actuator
        and line.
    gait : Gait or str
        Command from the first tick on.
    duration : float
        Length of the run [s].
    medium : str
        ``"water"``: swimming freely. ``"air"``: the head held still, without water.
    faults : str or iterable of str
        Sensor faults as on the command line: ``"bend-II:stuck@5"``.
    seed : int
        Seed of the sensor noise; the same seed repeats a run to the last bit.
    closed_loop : bool
        Whether posture control corrects amplitude and bias; otherwise the inverse pump maps act alone.
    temperature : float, optional
        Temperature of the oil [K]; the controller keeps that of the robot's file.
    start : str
        ``"rest"``, or ``"swimming"``: at the speed of the settled beat of joints that lag by their bandwidth.
    step : float, optional
        Runge-Kutta step [s], rounded to divide the control tick; if left out, `STEP`, or less for a stiffer plant.
    command_lost_at : float
        Time from which no command arrives [s].
    controller_robot : Robot, optional
        Robot that the controller is configured for; this one if left out.

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
    plan = _planned(**locals())
    return TwinRun(**plan.run())


def _planned(robot: Robot | str | Path, gait: Gait | str, *, medium: str, start: str, **options: Any) -> PlannedRun:
    """Plan the run that the arguments of `twin` describe."""
    robot = robot_of(robot)
    gait = gait_of(robot, gait)
    check_choice(medium, ("water", "air"), "medium")
    check_choice(start, ("rest", "swimming"), "start")
    world, from_rest = _core.World({"clamped": medium == "air"}), start == "rest" or medium == "air"
    plan = plan_command(robot, gait, world, medium=medium, speed=0.0 if from_rest else None, **options)
    return PlannedRun(plan.fields | {"medium": medium, "start": start}, plan.core)


@checked
def twin_at_sea(
    robot: Robot | str | Path,
    gait: Gait | str,
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
    """Run the robot's twin at sea, in three dimensions, under one command.

    Parameters
    ----------
    robot : Robot, str or Path
        With the tables that `twin` needs, spatial and fins.
    gait, duration, faults, seed, closed_loop, temperature, step, command_lost_at
        As of `twin` [K, s].
    fins : float, array_like or callable
        Target angle of the pectoral fins, leading edge up: one, or one each, port first, or a function of time that
        returns them [rad].
    sea : Sea
        Still, deep water if left out.
    depth : float
        Initial depth of the nose [m].
    roll, pitch, heading : float
        Initial angles: starboard down, nose up, clockwise from north [rad].
    speed : float, optional
        Initial speed through the water, ahead [m/s]; that of the settled planar beat if left out.
    every : int
        Control ticks per row of the record.

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
    robot = robot_of(robot)
    require_at_sea(robot, "battery", "controller", "spatial", "fins", pilot=False)
    gait = gait_of(robot, gait)
    control = require_controller(robot)
    plan = plan_command(
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
        every=POSITIVE_WHOLE.check(every, "every", "give a whole number of ticks"),
    )
    return SeaRun(**plan.run(), sea=sea)


@checked
def twins(
    runs: Sequence[Mapping[str, Any]],
    *,
    measure: Callable[[TwinRun], T],
    threads: int = 1,
    executor: Executors | None = None,
) -> list[T]:
    """Run many twins at once, in the vector lanes of a processor and in threads.

    Robots of the same structure (links, joints, water law) under commands of the same length share vector instructions;
    they may differ in everything else. Each run equals that of `twin` to the last bit. Memory holds the results of
    `measure` and one batch of records per thread: 1 MB per run and 10 s.

    Parameters
    ----------
    runs : sequence of mapping
        Arguments of `twin` by name, robot and gait among them, one mapping per run.
    measure : callable
        Returns what to keep of each run.
    threads : int
        Number of threads; results do not depend on it.
    executor : concurrent.futures.Executor or callable, optional
        Where to run them, 64 at a time on `threads` threads, as of `sweep`. It must be able to send `measure`.

    Returns
    -------
    list
        In the order of the runs.

    Raises
    ------
    InputError
        As `twin` does.
    """
    threads = thread_count(threads)
    if executor is not None:
        chunks = (runs[k : k + CHUNK] for k in range(0, len(runs), CHUNK))
        shards = map_shards(partial(twins, measure=measure, threads=threads), chunks, executor)
        return [result for chunk in shards for result in chunk]
    kinds: dict[Any, list[tuple[int, PlannedRun]]] = {}
    for index, options in enumerate(runs):
        plan = _planned(**checked_arguments(twin, **options))
        core = plan.core
        kind = *core["plant"].structure, plan.fields["medium"], core["command"].tick, core["ticks"], core["steps"]
        kinds.setdefault(kind, []).append((index, plan))
    lanes = _core.twin_lanes()
    batches = [kind[k : k + lanes] for kind in kinds.values() for k in range(0, len(kind), lanes)]
    results: dict[int, T] = {}

    def run(batch: list[tuple[int, PlannedRun]]) -> None:
        for (index, plan), record in zip(batch, _simulated([plan.core for _, plan in batch]), strict=True):
            results[index] = measure(TwinRun(**plan.fields_of(record)))

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(run, batches))
    return [results[index] for index in range(len(runs))]


def _simulated(batch: list[dict[str, Any]]) -> list[dict[str, Array]]:
    """Simulate plans of the same structure and length at once, and return their records."""
    if len(batch) == 1:
        return [_core.simulate(**batch[0])]
    rows = [tuple(core[key] for key in ("plant", "command", "world", "sensors", "faults", "twist")) for core in batch]
    return _core.simulate_batch(rows, ticks=batch[0]["ticks"], steps=batch[0]["steps"])


def _pose(depth: float, roll: float, pitch: float, heading: float, sea: Sea) -> Array:
    """Return the core's initial pose (9,): position, attitude quaternion, fin angles."""
    fix = "give the depth of the nose in m"
    if not 0 <= FINITE.check(depth, "depth", fix) < sea.bottom:
        rule = f"must be from 0 to the bottom at {sea.bottom:g} m"
        raise InputError(rule, key="depth", value=f"{depth:g}", fix=fix)
    angles = {"roll": roll, "pitch": pitch, "heading": heading}
    for key, angle in angles.items():
        FINITE.check(angle, key, "give it in radians")
    return np.concatenate([[0.0, 0.0, -depth], attitude_of(**angles), [0.0, 0.0]])


def _fin_angles(fins: Fins, ticks: int, tick: float, control: Controller) -> Array:
    """Return target angles of both fins in every tick (ticks, 2) [rad]; fins: one angle, two, or a function of time."""
    pairs: list[Any] = [fins(tick * k) for k in range(ticks)] if callable(fins) else [fins]
    try:
        angles = np.array([np.broadcast_to(np.asarray(pair, dtype=float), 2) for pair in pairs])
    except (TypeError, ValueError):
        fix = "give one angle in radians, or two, port first"
        raise InputError("must be one angle, or one for each fin", key="fins", value=shown(pairs[0]), fix=fix) from None
    largest = abs(angles).max()
    if not largest <= control.fin_max * (1 + TOLERANCE):
        rule = f"must be at most {math.degrees(control.fin_max):g} deg, the controller.fin_max_deg"
        raise InputError(rule, key="fins", value=f"{math.degrees(largest):g} deg", fix="give less")
    return np.ascontiguousarray(np.broadcast_to(angles, (ticks, 2)))
