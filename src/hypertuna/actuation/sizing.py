"""Size of the pump: what a beat asks of servos, cylinders and lines, what they can do, and how much bend is left."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.actuation.bending import JointTable, joint_tables
from hypertuna.actuation.hydraulics import Circuits, circuits, servo_angle, supply_voltage
from hypertuna.description.robot import Robot, parse, require
from hypertuna.errors import InputError

__all__ = ["POWERS", "Size", "largest_beat", "size_pump", "with_bore"]

Array = NDArray[np.float64]

SAMPLE = 1e-3  # s between rows of a run
BEATS, LAGS = 4, 6.0  # a run takes so many beats, and so many time constants of the line
STABLE = 1.5  # part of 2.7, where Runge-Kutta steps become unstable
STIFF = 1e6  # Pa: the pressure at which a step must be stable
FLOWS = 200  # instants of a beat at which the joint's flow is looked for
HALVINGS = 8  # of the command, until no pressure is above its limit
SLOW_SERVO = 0.95  # a servo that makes less of its command limits the beat
LONGEST = 200.0  # s of a run
LAMINAR = 2300  # Reynolds number up to which a line's flow is laminar
DEEP_SUCTION = 0.8  # of the cavitation pressure: air swells there, and the joint's passive side no longer follows
POWERS = ("idle", "holding", "hydraulic", "friction", "inertia", "braking")


@dataclass(frozen=True)
class Size:
    """One joint at one frequency, line bore and oil temperature."""

    joint: str  # Name of the joint group
    frequency: float  # Of the beat [Hz], of the line [m], of the oil [K]
    bore: float
    temperature: float
    viscosity: float  # Kinematic viscosity of the oil [m^2/s]
    command: float  # Amplitude that the servos are told to make [rad]
    torque: float  # Of a servo at the joint's pressure limit with friction, and at stall [N m]
    torque_limit: float
    speed: float  # Largest rate of a servo that makes the beat exactly, and without load [rad/s]
    speed_limit: float
    stroke: float  # Largest servo angle either way for the command, and the dead center that it leads to [rad]
    stroke_limit: float
    resistance: float  # Of the line [Pa s/m^3, Pa s^2/m^3]
    inertance: float
    # Volume that one side takes up per pressure, at rest and on the way to the pressure limit [m^3/Pa]
    capacity_rest: float
    capacity: float
    corner_rest: float  # Corner frequency of the line with these, 1 / (2 pi R C) [Hz]
    corner: float
    resonance: float  # Of the line's inertance with the capacity, 1 / (2 pi sqrt(I C)) [Hz], and its damping ratio [1]
    damping: float
    # Of the line's inertance with oil and air of the cylinder at the fill pressure [Hz], and its damping ratio [1]:
    # what a step of the servo strikes
    ring: float
    ring_damping: float
    # Largest pressure drop along the line if the joint makes the command, by laminar flow [Pa], and Reynolds number
    drop: float
    reynolds: float
    amplitude: float  # First harmonic of the bend that is left, in air and without mass [rad]
    lag: float  # How much later it is than the command [rad]
    # Part of the command that the servos were told, less than 1 where more would pass the pressure limit [1]
    part: float
    pressure_max: float  # Of the cylinders [Pa]
    pressure_min: float
    limits: tuple[str, ...]  # What stands between command and bend: "pressure", "suction", "servo"
    power: dict[str, float]  # Mean electrical power of both servos, ``total`` and shares [W]

    @property
    def turbulent(self) -> bool:
        """Whether the line's flow is beyond the laminar law, so that the drop is told too small."""
        return self.reynolds > LAMINAR


def largest_beat(robot: Robot) -> tuple[float, tuple[float, ...]]:
    """Return the fastest and largest beat that a robot's file allows: returns [Hz], [rad]."""
    bounds = require(robot.gait_bounds, "gait_bounds", robot, "give a frequency")
    amplitudes = tuple(
        require(group.amplitude_max, f"joints.{group.name}.amplitude_max_deg", robot, "give an amplitude")
        for group in robot.joints
    )
    return bounds.frequency[1], amplitudes


def size_pump(
    robot: Robot,
    *,
    frequency: Sequence[float],
    amplitude: Sequence[float],
    bore: Sequence[float | None] = (None,),
    temperature: Sequence[float | None] = (None,),
    progress: Callable[[int, int], None] | None = None,
) -> list[Size]:
    """Size the pump: every joint at every frequency, line bore and oil temperature.

    `frequency` [Hz], `amplitude` (groups,) [rad], `bore`, `temperature` [m], [K].
    """
    _check(robot, frequency, amplitude)
    tables = joint_tables(robot)
    cases = list(itertools.product(frequency, bore, temperature))
    built = {(d, t): circuits(robot, t, bore=d) for d in bore for t in temperature}  # all input is checked here
    sizes = []
    for k, (f, d, t) in enumerate(cases):
        for j, angle in enumerate(amplitude):
            sizes.append(_size(robot, built[d, t], tables[j], j, d, f, angle))
        if progress is not None:
            progress(k + 1, len(cases))
    return sizes


def _check(robot: Robot, frequency: Sequence[float], amplitude: Sequence[float]) -> None:
    """Check the beat."""
    if len(amplitude) != len(robot.joints):
        rule, fix = f"must be {len(robot.joints)} long, one value per joint group", "give one for each joint group"
        raise InputError(rule, key="amplitude", value=f"{len(amplitude)} long", fix=fix)
    for key, values, unit in (("frequency", frequency, "Hz"), ("amplitude", np.degrees(amplitude), "deg")):
        for value in values:
            if not 0 < value < math.inf:
                raise InputError("must be greater than 0", key=key, value=f"{value:g}", fix=f"give it in {unit}")
    slowest, rule = min(frequency, default=math.inf), f"must be at least {BEATS / LONGEST:g} Hz"
    if slowest * LONGEST < BEATS:
        raise InputError(rule, key="frequency", value=f"{slowest:g}", fix="slower beats take too long to compute")


def _size(
    robot: Robot,
    found: Circuits,
    table: JointTable,
    j: int,
    bore: float | None,
    frequency: float,
    amplitude: float,
) -> Size:
    """Size one joint."""
    group, supply = robot.joints[j], supply_voltage(robot)
    limit = require(group.pressure_max, f"joints.{group.name}.pressure_max_pa", robot)
    column = {name: float(found.column(name)[2 * j]) for name in found.columns}
    hose = require(group.line, "joints.line", robot)
    line = _line(found, table, j, limit, hose.fill_pressure)
    bore = hose.bore if bore is None else bore
    time, period = _times(frequency, line["resistance"] * line["capacity_rest"])
    target = _target(found, table, j, amplitude * np.sin(2 * np.pi * frequency * time))
    rows = np.ascontiguousarray(found.values[2 * j : 2 * j + 2])
    seen, part = _limited(rows, table, supply, _held(robot, target, time), frequency, period, limit)
    volume = table.at(amplitude * np.sin(2 * np.pi * np.linspace(0, 1, FLOWS + 1)))["volume"]
    flow = float(np.abs(np.diff(volume, axis=0)).max() * FLOWS * frequency)
    return Size(
        joint=group.name,
        frequency=frequency,
        bore=bore,
        temperature=found.temperature,
        viscosity=found.viscosity,
        command=amplitude,
        drop=line["resistance"] * flow + column["loss"] * flow**2,
        reynolds=4 * flow / (np.pi * bore * found.viscosity),
        part=part,
        **line,
        **_servo(column, rows[0], target[-period:], time[1], supply / column["voltage"], limit),
        **_beat(column, seen, part * target[-period:], frequency, time[1], part),
    )


def _servo(
    column: dict[str, float], row: Array, target: Array, interval: float, voltage: float, limit: float
) -> dict[str, Any]:
    """Return what a beat asks of a servo, and what it can do at its part of the rated voltage."""
    slopes = _core.displaced(row, np.ascontiguousarray(target.ravel()))[:, 1]
    return {
        "torque": limit * float(slopes.max()) + column["friction"],
        "torque_limit": column["stall_torque"] * voltage,
        "speed": float(np.abs(np.diff(target, axis=0)).max() / interval),
        "speed_limit": column["speed"] * voltage,
        "stroke": float(np.abs(target).max()),
        "stroke_limit": min(column["neutral"], np.pi - column["neutral"]),
    }


def _beat(
    column: dict[str, float], seen: dict[str, Array], told: Array, frequency: float, interval: float, part: float
) -> dict[str, Any]:
    """Return what the last beat of a run was, and what limited it."""
    period, rows = len(told), len(seen["bend"])
    clock = np.exp(-2j * np.pi * frequency * interval * np.arange(rows - period, rows))
    harmonic = complex(2j * np.mean(seen["bend"][-period:] * clock))
    asked, made = (abs(np.mean(angle[-period:] * clock[:, None], axis=0)) for angle in (told, seen["angle"]))
    pressure = seen["pump_pressure"][-period:]
    limits = {
        "pressure": part < 1,
        "suction": pressure.min() < DEEP_SUCTION * column["cavitation"],
        "servo": (made < SLOW_SERVO * asked).any(),
    }
    shares = {"total": "power"} | {name: f"power_{name}" for name in POWERS}
    return {
        "amplitude": abs(harmonic),
        "lag": -float(np.angle(harmonic)),
        "pressure_max": float(pressure.max()),
        "pressure_min": float(pressure.min()),
        "limits": tuple(name for name, acts in limits.items() if acts),
        "power": {name: float(seen[key][-period:].sum(axis=1).mean()) for name, key in shares.items()},
    }


def _line(found: Circuits, table: JointTable, j: int, limit: float, fill: float) -> dict[str, Any]:
    """Return what line and actuator are for small motions, and on the way to the pressure limit."""
    resistance, inertance = (float(found.column(name)[2 * j]) for name in ("resistance", "inertance"))
    rest, capacity_rest = table.at([0.0]), _capacity_rest(table)
    # What one side's pressure alone does, the other side open: the bend where silicone balances the limit.
    angles = table.angle[table.angle >= 0]
    at = table.at(angles)
    held = -at["elastic"] / at["slope"][:, 0]  # pressure that holds each angle
    volume = float(np.interp(limit, held, at["volume"][:, 0])) - float(rest["volume"][0, 0])
    capacity = volume / limit
    oil, modulus, air = (float(found.column(name)[2 * j]) for name in ("oil_pump", "bulk_modulus", "air"))
    gives = oil * (1 / modulus + air * _core.ATMOSPHERE / (_core.ATMOSPHERE + fill) ** 2)
    return {
        "resistance": resistance,
        "inertance": inertance,
        "capacity_rest": capacity_rest,
        "capacity": capacity,
        "corner_rest": 1 / (2 * np.pi * resistance * capacity_rest),
        "corner": 1 / (2 * np.pi * resistance * capacity),
        "resonance": 1 / (2 * np.pi * math.sqrt(inertance * capacity)),
        "damping": resistance / 2 * math.sqrt(capacity / inertance),
        "ring": 1 / (2 * np.pi * math.sqrt(inertance * gives)),
        "ring_damping": resistance / 2 * math.sqrt(gives / inertance),
    }


def _capacity_rest(table: JointTable) -> float:
    """Return the volume that one side takes up per pressure, for small motions about rest [m^3/Pa]."""
    step = table.step / 2
    stiffness = -np.diff(table.at([-step, step])["elastic"])[0] / (2 * step)
    return float(table.at([0.0])["slope"][0, 0] ** 2 / stiffness)


def _times(frequency: float, lag: float) -> tuple[Array, int]:
    """Return the times of a run's rows [s], and how many of them make a beat."""
    if LAGS * lag > LONGEST:
        rule, value = (
            f"must be so wide that it settles within {LONGEST:g} s",
            f"so narrow that it takes {LAGS * lag:.3g}",
        )
        raise InputError(rule, key="bore of a line", value=value, fix="take wider lines or warmer oil")
    period = max(8, round(1 / frequency / SAMPLE))
    beats = max(BEATS, math.ceil(LAGS * lag * frequency))
    return np.arange(beats * period) / (period * frequency), period


def _target(found: Circuits, table: JointTable, j: int, bend: Array) -> Array:
    """Return the servo angles of both sides that push out what the units of a bent joint hold [rad]."""
    volume = table.at(bend)["volume"] - table.at([0.0])["volume"]
    target = np.stack([servo_angle(found, volume[:, s], 2 * j + s) for s in (0, 1)], axis=1)
    reach = table.angle[-1]
    if not np.isfinite(target).all() or np.abs(bend).max() > reach:
        rule = f"must be at most what pump and joint can do: the joint locks at {np.degrees(reach):.3g} deg"
        value = f"{np.degrees(np.abs(bend).max()):.4g}"
        fix = "command less, or describe a pump with more stroke"
        raise InputError(rule, key=f"amplitude_deg[{j}]", value=value, fix=fix)
    return target


def _held(robot: Robot, target: Array, time: Array) -> Array:
    """Hold each target for a tick of the controller, if the robot has one."""
    if robot.controller is None:
        return target
    tick = np.floor(time * robot.controller.rate + 1e-9) / robot.controller.rate
    return np.stack([np.interp(tick, time, side) for side in target.T], axis=1)


def _limited(
    rows: Array, table: JointTable, supply: float, target: Array, frequency: float, period: int, limit: float
) -> tuple[dict[str, Array], float]:
    """Run a beat; where the cylinders pass the limit, tell the servos less until they do not."""

    def run(part: float) -> dict[str, Array]:
        stiff = _core.circuit_stiffness(rows[0], STIFF, 0.0)
        interval = 1 / (period * frequency)
        steps = max(1, math.ceil(interval * stiff / STABLE))
        return _core.run_pair(
            rows,
            table.points,
            first=table.first,
            step=table.step,
            stop=table.stop,
            target=np.ascontiguousarray(part * target),
            supply=supply,
            interval=interval,
            steps=steps,
        )

    seen, low, high = run(1.0), 0.0, 1.0
    if seen["pump_pressure"][-period:].max() <= limit:
        return seen, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        seen = run(middle)
        low, high = (middle, high) if seen["pump_pressure"][-period:].max() <= limit else (low, middle)
    return run(low), low


def with_bore(robot: Robot, bore: float) -> Robot:
    """Return a robot with other oil lines: `bore` [m]."""
    document = robot.document()
    for k, joint in enumerate(document["joints"]):
        line = require(joint.get("line"), f"joints[{k}].line", robot)
        line["bore_m"] = bore
    return parse(document, file=robot.file)
