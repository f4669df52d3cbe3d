"""The controller on board as the core takes it: what a robot's description makes of its constants.

The equations stand in core cpg.hpp, posture.hpp, safety.hpp and controller.hpp; docs/control.md derives them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.actuation.bending import JointTable, joint_tables
from hypertuna.actuation.hydraulics import Circuits, circuits, pump_servo, servo_angle
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.body import JointGroup
from hypertuna.description.schema.control import Controller
from hypertuna.errors import InputError
from hypertuna.swimming.model import core_model

__all__ = ["PumpMap", "controller_columns", "pump_map"]

Array = NDArray[np.float64]

SETTLED = 4.7439  # rate times time at which a critically damped filter has made 95 % of a step: (1 + x) e^-x = 0.05
MAP_DEGREE = 5
FLOOR = 0.2  # of the cavitation pressure: as low as the pump may draw its units to hold a bend at rest
BEYOND = 1.2  # of a joint's largest bend under pressure: what control may ask for, to make up for losses
BEND_STEP = 2.0  # of the fastest beat's largest change within a tick: what a sound bend sensor may show


@dataclass(frozen=True)
class PumpMap:
    """Servo angle of a circuit for a bend toward its side: a polynomial, and how well it fits.

    Attributes
    ----------
    coefficients : ndarray, shape (6,)
        Of 1, u, u^2, ... for the bend u [rad] toward the side: servo angle [rad].
    residual_angle : float
        Largest error over the range [rad].
    residual_volume : float
        The same as displaced oil [m^3].
    """

    coefficients: Array
    residual_angle: float
    residual_volume: float


def controller_columns(robot: Robot, temperature: float | None = None) -> dict[str, list[float]]:
    """Compute the constants of a robot's controller.

    Parameters
    ----------
    robot : Robot
        With all tables of actuator, hydraulics and controller.
    temperature : float, optional
        Of the oil [K] that the controller counts on; the robot's own if left out.

    Returns
    -------
    dict of str to list of float
        As core controller.hpp names them, one value per joint or circuit (two per joint, left and right) or one.

    Raises
    ------
    InputError
        If a table is missing.
    """
    control = require(robot.controller, "controller", robot)
    found = circuits(robot, temperature)
    tick = 1 / control.rate
    columns = _constants(robot, control, tick)
    for j in range(len(robot.joints)):
        for name, value in _joint(robot, control, found, j).items():
            columns.setdefault(name, []).append(value)
    for c in range(len(found.names)):
        map_ = pump_map(robot, found, c)
        fill = robot.joints[c // 2].line.fill_pressure  # type: ignore[union-attr]
        for name, values in {"map": map_.coefficients.tolist(), **_supervisor(control, found, c, fill)}.items():
            columns.setdefault(name, []).extend(float(value) for value in values)
    return columns


def pump_map(robot: Robot, found: Circuits, circuit: int) -> PumpMap:
    """Fit the servo angle that holds a bend at rest: the inverse of volumes and pressures of both sides.

    Parameters
    ----------
    robot : Robot
    found : Circuits
        Its circuits.
    circuit : int
        Which one; 2 j + s is side s of joint j.

    Returns
    -------
    PumpMap
        Least squares over the joint's reach.
    """
    group = robot.joints[circuit // 2]
    reach = _reach(group)
    bend = np.linspace(-reach, reach, 201)
    table = joint_tables(robot)[circuit // 2]
    volume, pressure = _side_at_rest(robot, table, found, circuit, bend)
    angle = servo_angle(found, _displacement(found, circuit, volume, pressure), circuit)
    if not np.isfinite(angle).all():
        rule = "must leave the crank room for the joint's whole reach"
        fix = "choose it near 90, or a longer crank or a wider bore"
        value = f"{math.degrees(robot.pump.neutral):g}" if robot.pump else None
        raise InputError(rule, file=robot.file, key="pump.neutral_deg", value=value, fix=fix)
    slope = _core.displaced(found.values[circuit], angle)[:, 1]
    fit = np.polynomial.Polynomial.fit(bend, angle, MAP_DEGREE, w=slope).convert()
    error = fit(bend) - angle
    return PumpMap(np.asarray(fit.coef, dtype=np.float64), float(abs(error).max()), float(abs(error * slope).max()))


def _reach(group: JointGroup) -> float:
    return BEYOND * require(group.bend_max, f"joints.{group.name}.bend_max_deg")


def _displacement(found: Circuits, circuit: int, volume: Array, pressure: Array) -> Array:
    """Volume that the cylinder must have pushed out where its units have grown and stand under a pressure."""
    at = {name: float(found.column(name)[circuit]) for name in found.columns}
    oil = at["oil_pump"] + at["oil_unit"]
    atmosphere = _core.ATMOSPHERE
    swollen = oil * (1 - pressure / at["bulk_modulus"] + at["air"] * atmosphere / (atmosphere + pressure))
    displaced: Array = at["chamber"] + at["unit_rest"] + volume + at["compliance"] * pressure - swollen
    return displaced


def _side_at_rest(robot: Robot, table: JointTable, found: Circuits, circuit: int, bend: Array) -> tuple[Array, Array]:
    """Volume gained [m^3] and pressure [Pa] of a side that holds a bend toward itself.

    The moments balance with both sides as far from the fill pressure, one above and one below it; where the lower one
    would cavitate it stays there.
    """
    side = circuit % 2
    toward = 1.0 if side == 0 else -1.0
    load = table.at(toward * bend)
    own, other = toward * load["slope"][:, side], toward * load["slope"][:, 1 - side]
    elastic, volume = toward * load["elastic"], load["volume"][:, side] - table.at([0.0])["volume"][:, side]
    fill = require(robot.joints[circuit // 2].line, "joints.line", robot).fill_pressure
    low = FLOOR * float(found.column("cavitation")[circuit])
    off = -(elastic + fill * (own + other)) / (own - other)
    low_other = np.maximum(fill - off, low)
    pressure = np.maximum(-(elastic + low_other * other) / own, low)
    return volume, pressure


def _follow(rate: float, tick: float) -> tuple[float, float]:
    """Rate and decay per tick of a critically damped filter."""
    return rate * tick, math.exp(-rate * tick)


def _constants(robot: Robot, control: Controller, tick: float) -> dict[str, list[float]]:
    """Compute what the whole controller has once."""
    rate, decay = _follow(SETTLED / control.smoothing, tick)
    sensor = {kind: sensor_range(robot, kind) for kind in ("pressure", "current", "rate", "acceleration", "voltage")}
    servo = circuits_voltage(robot)
    values = {
        "tick": tick,
        "relax": math.exp(-2 * control.convergence * tick),
        "couple": math.exp(-control.coupling * tick),
        "smoothing_rate": rate,
        "smoothing_decay": decay,
        "proportional": control.proportional,
        "integral": control.integral,
        "derivative": control.derivative,
        "peak_smoothing": control.peak_smoothing,
        "missing": 0.25,
        "limited": 0.1,
        "moving": 0.05,
        "least": math.radians(3.0),
        "pressure_soft": control.pressure_soft,
        "pressure_hard": control.pressure_hard,
        "pressure_low": sensor["pressure"][0],
        "pressure_high": sensor["pressure"][1],
        "pressure_step": control.pressure_step,
        "current_low": sensor["current"][0],
        "current_high": sensor["current"][1],
        "rate_high": sensor["rate"][1],
        "acceleration_high": sensor["acceleration"][1],
        "voltage_rated": servo,
        "voltage_low": control.voltage_low,
        "voltage_least": sensor["voltage"][0],
        "voltage_most": sensor["voltage"][1],
        "frequency_most": control.frequency_max,
        "fin_most": control.fin_max,
        "timeout": round(control.timeout / tick),
        "pulse_center": control.pulse_center,
        "pulse_per_rad": control.pulse_per_rad,
        "pulse_least": control.pulse_min,
        "pulse_most": control.pulse_max,
        "slew": control.slew * tick,
    }
    return {"joints": [float(len(robot.joints))], **{name: [float(value)] for name, value in values.items()}}


def circuits_voltage(robot: Robot) -> float:
    """Voltage that the pump servos' torque and speed are rated at."""
    return float(require(pump_servo(robot).voltage, "servos.voltage_v", robot))


def sensor_range(robot: Robot, quantity: str) -> tuple[float, float]:
    """Return the range of the sensors of a quantity, or say that there are none."""
    for sensor in robot.sensors:
        if sensor.quantity == quantity and sensor.low is not None and sensor.high is not None:
            return sensor.low, sensor.high
    fix = f"add [[sensors]] with quantity = {quantity!r}, low and high"
    return require(None, "sensors", robot, fix)


def _joint(robot: Robot, control: Controller, found: Circuits, j: int) -> dict[str, float]:
    """Compute what the controller knows of a joint."""
    group = robot.joints[j]
    bend_max = require(group.bend_max, f"joints.{group.name}.bend_max_deg", robot)
    high = sensor_range(robot, "bend")[1]
    static, rate, square = _pressure_of_beat(robot, control, found, j)
    return {
        "reach": _reach(group),
        "amplitude": bend_max,
        "bend_range": high,
        "bend_step": BEND_STEP * 2 * math.pi * control.frequency_max * bend_max / control.rate,
        "safe_static": static,
        "safe_rate": rate,
        "safe_square": square,
    }


def _pressure_of_beat(robot: Robot, control: Controller, found: Circuits, j: int) -> tuple[float, float, float]:
    """Bound a beat's pressure over the fill: per amplitude, by powers of the frequency, over the soft limit's room.

    What holds the bend at rest, what the flow drops in the line, and the water's load on the moving tail are added as
    if they came at once.
    """
    amplitude = float(robot.joints[j].bend_max or 0.0)
    fill = float(robot.joints[j].line.fill_pressure)  # type: ignore[union-attr]
    bend = np.linspace(0.1, 1.0, 10) * amplitude
    table = joint_tables(robot)[j]
    held = (_side_at_rest(robot, table, found, 2 * j, bend)[1] - fill) / bend
    flow = np.gradient(_side_at_rest(robot, table, found, 2 * j, bend)[0], bend)
    resistance = float(found.column("resistance")[2 * j])
    frequency = control.frequency_max
    slope = table.at(bend)["slope"]
    load = _water_load(robot, frequency)[j] / float((slope[:, 0] - slope[:, 1]).min())
    room = control.pressure_soft - fill
    return (
        float(held.max()) / room,
        2 * math.pi * resistance * float(flow.max()) / room,
        load / (amplitude * frequency**2) / room,
    )


def _water_load(robot: Robot, frequency: float) -> Array:
    """Largest moment on each joint group while the tail beats at its largest bends and the head starts from rest."""
    count = len(robot.joints)
    model = core_model(robot, {"joints.bandwidth": [math.inf] * count})
    amplitude = [float(group.bend_max or 0.0) for group in robot.joints]
    clock = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    zero = [0.0] * count
    motion = _core.joint_motion(model, frequency=frequency, amplitude=amplitude, phase=zero, bias=zero, clock=clock)
    torque = _core.dynamics(model, motion, np.zeros((len(clock), 3)))["torque"]
    moments = [torque[:, list(group.links)] @ np.array(group.share) for group in robot.joints]
    return np.array([abs(moment).max() for moment in moments])


def _supervisor(control: Controller, found: Circuits, circuit: int, fill: float) -> dict[str, list[float]]:
    """Compute what the supervisor knows of a circuit."""
    at = {name: float(found.column(name)[circuit]) for name in found.columns}
    slope = float(_core.displaced(found.values[circuit], np.linspace(-0.5, 0.5, 51))[:, 1].max())
    high = _core.ATMOSPHERE + control.pressure_soft
    oil = (at["oil_pump"] + at["oil_unit"]) * (1 / at["bulk_modulus"] + at["air"] * _core.ATMOSPHERE / high**2)
    return {
        "servo_speed": [at["speed"]],
        "servo_stall": [at["stall_torque"] / slope],
        "fill": [fill],
        "give": [(at["compliance"] + oil) / slope],
    }
