"""Constants of the controller on board, computed from the robot's description.

The equations are in core cpg.hpp, posture.hpp, safety.hpp and controller.hpp; docs/control.md derives them.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hypertuna import _core
from hypertuna.actuation.hydraulics import SIDES, Circuits, circuits, has_oil, rated_voltage, servo_angle, viscosity
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.arrays import Array, rounded_number, rounded_parts, without_last_bit
from hypertuna.description.robot import Robot, joint_key, require
from hypertuna.description.schema.base import Part
from hypertuna.description.schema.body import JointGroup
from hypertuna.description.schema.control import Controller
from hypertuna.description.schema.hydraulics import HOTTEST, JointServo
from hypertuna.description.twin import require_controller
from hypertuna.errors import InputError
from hypertuna.swimming.model import core_model

SETTLING_FACTOR = 4.7439  # rate times time to 95 % of a step of a critically damped filter: (1 + x) e^-x = 0.05
MAX_SUCTION = 0.2  # lowest pressure that holds a bend at rest, as a fraction of the cavitation pressure (below 0)
FILL_TOLERANCE = 1e-6  # relative difference of both sides' mean pressure from the fill, below which no limit acts
REACH = 1.2  # largest bend that control may command, over the joint's largest bend; the excess makes up for losses
NO_LIMIT = 1e9  # value that means no limit, for stall pressure [Pa] and rates [rad/s] of a servo without oil
MAP_TERMS, HOLD_TERMS = 6, 4  # terms of a pump map (controller_model.hpp) and of the pressure at rest (safety.hpp)
HAMMER_PRESSURE = 100e3  # Pa: gauge pressure in a cylinder at which hammer is computed
SMOOTH_HAMMER = 0.15  # hammer of a servo's largest change of rate within a tick, as a fraction of soft limit minus fill
RING_TICKS = 3.0  # ringing period of a line above which that fraction is reduced
SHORT_RING_TICKS = 2.0  # ringing period of a line below which pumps cannot make it ring
MAX_DRAW = 1.5  # largest rate of a bend, over the rate at which hammer would make the drawing side's oil cavitate
RING_GAIN = 0.5  # largest relative increase of hammer by ringing that has not yet died out
BEND_STEP = 2.0  # largest change of a working bend sensor within a tick, over the change in the fastest beat
# Choices of the posture control, which docs/control.md explains (core posture.hpp)
MAX_MISSING = 0.25  # fraction of a beat's readings that may be missing
MAX_LIMITED = 0.1  # fraction of a beat in which a limit acts, above which corrections must not grow
MIN_SWING = 0.05  # smallest swing of a working bend sensor, as a fraction of the sent amplitude
AMPLITUDE_MIN = math.radians(3.0)  # smallest sent amplitude at which the bend sensor is judged


@dataclass(frozen=True)
class PumpMap:
    """Fit of a circuit's servo angle as a function of the bend toward its side: three joined parabolas."""

    low: float  # rad: bends at the ends of the middle parabola
    high: float
    terms: Array  # (6,): factors of bend and its square in the middle, lower, upper parabola [rad/rad, rad/rad^2]
    residual_angle: float  # rad: largest over the range
    residual_volume: float  # m^3 of displaced oil: largest over the range

    def angle(self, bend: ArrayLike) -> Array:
        """Return servo angles [rad] at bends (n,) [rad]."""
        return _bend_powers(np.asarray(bend, dtype=np.float64), self.low, self.high) @ self.terms


def controller_columns(robot: Robot) -> dict[str, list[float]]:
    """Return the constants of a robot's controller, by their names in core controller_model.hpp.

    A column has one value, or one per joint, or one per circuit (index 2 joint + side).
    """
    control = require_controller(robot)
    hydraulics = circuits(robot)
    columns = _constants(robot, control) | _oil(robot, control, hydraulics)
    at_pour_point = circuits(robot, robot.oil.pour_point) if robot.oil else hydraulics
    for j, group in enumerate(robot.joints):
        if group.servo is not None:
            rows = [_axle(robot, group, group.servo), _no_oil(group.servo)]
        else:
            rows = [_circuit(robot, hydraulics, at_pour_point, 2 * j + side) for side in range(len(SIDES))]
            rows[0] |= _joint(robot, control, hydraulics, j)
            rows[0] |= _rates(robot, hydraulics, 2 * j, rows[0])
        for row in rows:
            for name, value in row.items():
                columns.setdefault(name, []).extend(np.atleast_1d(value).tolist())
    return columns


def _axle(robot: Robot, group: JointGroup, servo: JointServo) -> dict[str, Any]:
    """Return the constants of a joint that a servo turns: it has no pressure limits and no bend sensor."""
    bend = require(group.bend_max, f"{joint_key(robot, group.name)}.bend_max_deg", robot)
    zeros = dict.fromkeys(("bend_range", "bend_step", "safe_static", "safe_rate", "safe_square"), 0.0)
    unlimited = dict.fromkeys(("rate", "sent_rate"), NO_LIMIT)
    return {"direct": group.turns, "reach": bend, "amplitude": bend} | unlimited | zeros | _no_oil(servo)


def _no_oil(servo: JointServo) -> dict[str, Any]:
    """Return the circuit constants of a joint without oil, whose servo has no pressure limits."""
    zeros = dict.fromkeys(
        ("fill", "map_low", "map_high", "compliance", "line", "hammer", "draw", "smooth", "spare"), 0.0
    )
    return {
        **zeros,
        "map": np.zeros(MAP_TERMS),
        "hold": np.zeros(HOLD_TERMS),
        "servo_speed": servo.speed,
        "servo_stall": NO_LIMIT,
    }


def _circuit(robot: Robot, hydraulics: Circuits, thickest: Circuits, c: int) -> dict[str, Any]:
    """Return the controller's constants of a circuit, for its pump map and its supervisor."""
    pump_fit = pump_map(robot, hydraulics, c)
    fill = _fill(robot, c // 2)
    constants = {"fill": fill, "map": pump_fit.terms, "map_low": pump_fit.low, "map_high": pump_fit.high}
    volume_per_bend, tick = _flow(thickest, c), 1 / require_controller(robot).rate
    pressure_rise = soft_limit(robot) - fill
    ticks_of_ring = _ring(hydraulics, c) / tick
    slowdown = min(1.0, RING_TICKS / ticks_of_ring)
    volume_per_bend["hammer"] *= 1.0 + RING_GAIN * (1.0 - slowdown)
    volume_per_bend |= {"draw": NO_LIMIT, "smooth": NO_LIMIT, "spare": 0.0}
    if ticks_of_ring > SHORT_RING_TICKS:
        volume_per_bend["draw"] = rounded_number(_suction(robot, hydraulics, c) / volume_per_bend["hammer"])
        volume_per_bend["smooth"] = rounded_number(SMOOTH_HAMMER * slowdown * pressure_rise / volume_per_bend["hammer"])
    if ticks_of_ring > RING_TICKS:
        volume_per_bend["spare"] = rounded_number(2.0 / volume_per_bend["hammer"])
    return constants | _supervisor(robot, hydraulics, c) | volume_per_bend | {"hold": _hold(robot, hydraulics, c)}


def _suction(robot: Robot, hydraulics: Circuits, circuit: int) -> float:
    """Return the largest fall of a filled circuit's pressure before its oil cavitates [Pa]."""
    return _fill(robot, circuit // 2) - float(hydraulics.column("cavitation")[circuit])


def _hold(robot: Robot, hydraulics: Circuits, circuit: int) -> Array:
    """Fit the pressure above the fill that holds a bend: coefficients of its powers 1 to 4 [Pa/rad to Pa/rad^4]."""
    group, fill = robot.joints[circuit // 2], _fill(robot, circuit // 2)
    bend = np.linspace(-1, 1, 201) * _reach(robot, group)
    _, pressure, _ = _side_at_rest(robot, hydraulics, circuit, bend)
    powers = np.stack([bend**power for power in range(1, HOLD_TERMS + 1)], axis=1)
    weight = np.where(abs(bend) <= (group.bend_max or 0.0), 1.0, 0.5)  # only corrections reach larger bends
    fit = np.linalg.lstsq(powers * weight[:, None], weight * (pressure - fill))[0]
    return fill * rounded_parts(np.asarray(fit, dtype=np.float64) / fill)


def pump_map(robot: Robot, hydraulics: Circuits, circuit: int) -> PumpMap:
    """Fit a circuit's servo angle at rest as a function of the bend, by least squares over the joint's reach."""
    group = robot.joints[circuit // 2]
    reach = _reach(robot, group)
    bend = np.linspace(-reach, reach, 201)
    volume, pressure, unclamped = _side_at_rest(robot, hydraulics, circuit, bend)
    if not unclamped.any():
        rule = "must keep both sides of the straight joint under pressure"
        key, fix = f"{joint_key(robot, group.name)}.line.fill_pressure_pa", "fill the circuits to some 60e3 Pa"
        raise InputError(rule, file=robot.file, key=key, value=f"{_fill(robot, circuit // 2):g}", fix=fix)
    numbers = hydraulics.row(circuit)
    air = numbers["air"] * _core.ATMOSPHERE / (_core.ATMOSPHERE + pressure)
    oil_volume = (numbers["oil_pump"] + numbers["oil_unit"]) * (1 - pressure / numbers["bulk_modulus"] + air)
    displaced = numbers["chamber"] + numbers["unit_rest"] + volume + numbers["compliance"] * pressure - oil_volume
    angle = servo_angle(hydraulics, displaced, circuit)
    if not np.isfinite(angle).all():
        rule = "must let the crank turn far enough for the joint's whole reach"
        fix = "choose an angle near 90, a longer crank or a wider bore"
        value = f"{math.degrees(robot.pump.neutral):g}" if robot.pump else None
        raise InputError(rule, file=robot.file, key="pump.neutral_deg", value=value, fix=fix)
    slope = _core.displaced(hydraulics.values[circuit], angle)[:, 1]
    low, high = float(bend[unclamped][0]), float(bend[unclamped][-1])
    powers = _bend_powers(bend, low, high)
    offset = angle - float(np.interp(0, bend, angle))
    terms = rounded_parts(np.asarray(np.linalg.lstsq(powers * slope[:, None], offset * slope)[0], dtype=np.float64))
    residual = powers @ terms - angle
    return PumpMap(low, high, terms, float(abs(residual).max()), float(abs(residual * slope).max()))


def _bend_powers(bend: Array, low: float, high: float) -> Array:
    """Return the six functions of the bend (n, 6) whose weighted sum is a pump map (core controller_model.hpp)."""
    parts = (np.clip(bend, low, high), np.minimum(bend - low, 0), np.maximum(bend - high, 0))
    return np.stack([part**power for part in parts for power in (1, 2)], axis=1)


def _reach(robot: Robot, group: JointGroup) -> float:
    """Return the bend [rad] over which a joint's pump map is fitted."""
    return REACH * require(group.bend_max, f"{joint_key(robot, group.name)}.bend_max_deg", robot)


def _held_reach(robot: Robot, control: Controller, hydraulics: Circuits, j: int) -> float:
    """Return the largest bend [rad] that is commanded: the joint's reach, or less if the working pressure limits it."""
    bend = np.linspace(0, _reach(robot, robot.joints[j]), 201)[1:]
    _, pressure, _ = _side_at_rest(robot, hydraulics, 2 * j, bend)
    bends_held = bend[pressure <= (control.works_at or math.inf)]
    return rounded_number(float(bends_held.max(initial=bend[0])))


def _side_at_rest(robot: Robot, hydraulics: Circuits, circuit: int, bend: Array) -> tuple[Array, Array, Array]:
    """Return a side's change of volume [m^3], its pressure [Pa], and whether no limit acts, (n,) each, at rest.

    bend: (n,) toward the side [rad]. Without a limit, one side is as far above the fill pressure as the other is below.
    Otherwise the lower pressure has stopped where the braid would go slack, or short of cavitation.
    """
    side, model = circuit % 2, joint_models(robot)[circuit // 2]
    low = MAX_SUCTION * float(hydraulics.column("cavitation")[circuit])
    state = model.hold(bend if side == 0 else -bend, low)
    volume = state["volume"][:, side] - model.at(0.0)["volume"][0, side]
    pressure = state["pressure"]
    near_fill = abs(pressure.mean(axis=1) - model.fill) < FILL_TOLERANCE * model.fill
    return volume, pressure[:, side], near_fill


def _fill(robot: Robot, joint: int) -> float:
    """Return the fill pressure of a joint's circuits [Pa]."""
    return float(require(robot.joints[joint].line, "joints.line", robot).fill_pressure)


def soft_limit(robot: Robot) -> float:
    """Return the soft limit [Pa]: the pressure to which the supervisor limits commands."""
    return require(require_controller(robot).pressure_soft, "controller.pressure_soft_pa", robot)


def given_constants(part: str, table: Part) -> dict[str, float]:
    """Return the scalar values of a table whose keys are also fields of the core's struct named `part`."""
    fields = _core.onboard_fields(2, 2)
    lists = {name for _, name, index in fields if index > 0}
    names = {name for owner, name, _ in fields if owner == part} - lists
    values = {name: getattr(table, name) for name in table.declared if name in names}
    return {name: float(value) for name, value in values.items() if value is not None}


def _constants(robot: Robot, control: Controller) -> dict[str, list[float]]:
    """Return the constants that do not depend on joint or circuit, by name."""
    tick = 1 / control.rate
    rate = SETTLING_FACTOR / control.smoothing
    oil = has_oil(robot)
    pressure = sensor_range(robot, "pressure") if oil else (0.0, 0.0)
    current, voltage, rate_range, acceleration = (
        sensor_range(robot, quantity) if oil or has_sensor(robot, quantity) else (0.0, 0.0)
        for quantity in ("current", "voltage", "rate", "acceleration")
    )
    limits = {name: getattr(control, name) for name in control.declared if name.startswith("pressure_")}
    limits["pressure_work"] = control.works_at or 0.0
    values = given_constants("controller", control) | {
        **{name: require(limits[name], f"controller.{name}_pa", robot) if oil else 0.0 for name in limits},
        "tick": tick,
        "relax": without_last_bit(math.exp(-2 * control.convergence * tick)),
        "couple": without_last_bit(math.exp(-control.coupling * tick)),
        "smoothing_rate": rate * tick,
        "smoothing_decay": without_last_bit(math.exp(-rate * tick)),
        "missing": MAX_MISSING,
        "limited": MAX_LIMITED,
        "moving": MIN_SWING,
        "amplitude_min": AMPLITUDE_MIN,
        "pressure_low": pressure[0],
        "pressure_high": pressure[1],
        "current_low": current[0],
        "current_high": current[1],
        "rate_high": rate_range[1],
        "acceleration_high": acceleration[1],
        "voltage_rated": rated_voltage(robot),
        "voltage_min": voltage[0],
        "voltage_max": voltage[1],
        "timeout": round(control.timeout / tick),
    }
    return {"joints": [float(len(robot.joints))], **{name: [float(value)] for name, value in values.items()}}


def has_sensor(robot: Robot, quantity: str) -> bool:
    """Return whether a robot has a sensor of a quantity."""
    return any(sensor.quantity == quantity for sensor in robot.sensors)


def sensor_range(robot: Robot, quantity: str) -> tuple[float, float]:
    """Return lowest and highest reading of the sensor of a quantity [SI]; raise an error if it is not stated."""
    for sensor in robot.sensors:
        if sensor.quantity == quantity and sensor.low is not None and sensor.high is not None:
            return sensor.low, sensor.high
    fix = f"add [[sensors]] with quantity = {quantity!r}, low and high"
    return require(None, "sensors", robot, fix)


def _joint(robot: Robot, control: Controller, hydraulics: Circuits, j: int) -> dict[str, float]:
    """Return the controller's constants of a joint, by name."""
    group = robot.joints[j]
    bend_max = require(group.bend_max, f"{joint_key(robot, group.name)}.bend_max_deg", robot)
    pressure_per_bend, rate, square = _pressure_of_beat(robot, control, hydraulics, j)
    return {
        "direct": 0.0,
        "reach": _held_reach(robot, control, hydraulics, j),
        "amplitude": bend_max,
        "bend_range": sensor_range(robot, "bend")[1],
        "bend_step": BEND_STEP * 2 * math.pi * control.frequency_max * bend_max / control.rate,
        "safe_static": pressure_per_bend,
        "safe_rate": rate,
        "safe_square": square,
    }


def _pressure_of_beat(robot: Robot, control: Controller, hydraulics: Circuits, j: int) -> tuple[float, float, float]:
    """Return a beat's pressure rise per amplitude, as a fraction of soft limit minus fill: static, rate, square terms.

    They are factors of frequency [Hz] to the powers 0, 1, 2: pressure of the bend at rest, drop along the line, water's
    load on the tail. Their peaks are added as if they came at the same time.
    """
    amplitude, fill = float(robot.joints[j].bend_max or 0.0), _fill(robot, j)
    bend = np.linspace(0.1, 1.0, 10) * amplitude
    volume, pressure, _ = _side_at_rest(robot, hydraulics, 2 * j, bend)
    pressure_per_bend, volume_per_bend = (pressure - fill) / bend, np.gradient(volume, bend)
    resistance = float(hydraulics.column("resistance")[2 * j])
    frequency = control.frequency_max
    model = joint_models(robot)[j]
    states = model.hold(bend)
    slope = model.at(bend, states["strain"], states["pressure"])["slope"]
    with np.errstate(over="ignore"):  # the load on areas beyond measure is infinite
        load = _water_load(robot, frequency)[j] / float((slope[:, 0] - slope[:, 1]).min())
    pressure_rise = soft_limit(robot) - fill
    return (
        rounded_number(float(pressure_per_bend.max()) / pressure_rise),
        rounded_number(2 * math.pi * resistance * float(volume_per_bend.max()) / pressure_rise),
        rounded_number(load / (amplitude * frequency**2) / pressure_rise),
    )


def _water_load(robot: Robot, frequency: float) -> Array:
    """Return the water's largest moment on each joint group [N m] in a beat with the largest bends, head at rest."""
    count = len(robot.joints)
    model = core_model(robot, {"joints.bandwidth": [math.inf] * count})
    amplitude = [float(group.bend_max or 0.0) for group in robot.joints]
    clock = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    zero = [0.0] * count
    motion = _core.joint_motion(model, frequency=frequency, amplitude=amplitude, phase=zero, bias=zero, clock=clock)
    torque = _core.dynamics(model, motion, np.zeros((len(clock), 3)))["torque"]
    moments = [torque[:, list(group.links)] @ np.array(group.share) for group in robot.joints]
    return np.array([abs(moment).max() for moment in moments])


def _slope(hydraulics: Circuits, circuit: int) -> float:
    """Return the largest volume that a circuit's pump displaces per servo angle [m^3/rad]."""
    return float(_core.displaced(hydraulics.values[circuit], np.linspace(-0.5, 0.5, 51))[:, 1].max())


def _flow(thickest: Circuits, circuit: int) -> dict[str, float]:
    """Return pressure per servo rate in a circuit [Pa s/rad]: drop of the thickest oil along the line, and hammer.

    Hammer: sqrt(L / C), with the line's inertance L and the compliance C of the cylinder's oil at `HAMMER_PRESSURE`.
    """
    numbers, slope = thickest.row(circuit), _slope(thickest, circuit)
    hammer = slope * math.sqrt(numbers["inertance"] / _cylinder_compliance(numbers))
    return {"line": slope * numbers["resistance"], "hammer": hammer}


def _cylinder_compliance(at: dict[str, float]) -> float:
    """Return the compliance of the oil in a circuit's cylinder at `HAMMER_PRESSURE` [m^3/Pa]."""
    pressure = _core.ATMOSPHERE + HAMMER_PRESSURE
    return at["oil_pump"] * (1 / at["bulk_modulus"] + at["air"] * _core.ATMOSPHERE / pressure**2)


def _ring(hydraulics: Circuits, circuit: int) -> float:
    """Return the period [s] of the oscillation between a line's inertance and the oil in its cylinder."""
    numbers = hydraulics.row(circuit)
    return 2 * math.pi * math.sqrt(numbers["inertance"] * _cylinder_compliance(numbers))


def _rates(robot: Robot, hydraulics: Circuits, c: int, circuit: dict[str, Any]) -> dict[str, float]:
    """Return a joint's largest rates [rad/s], at which hammer reaches the soft limit or empties a cylinder."""
    hammer = circuit["hammer"] * circuit["map"][0]
    rate = (soft_limit(robot) - circuit["fill"]) / hammer
    empty_rate = MAX_DRAW * _suction(robot, hydraulics, c) / hammer
    return {"rate": rounded_number(rate), "sent_rate": rounded_number(min(rate, empty_rate))}


def _oil(robot: Robot, control: Controller, hydraulics: Circuits) -> dict[str, list[float]]:
    """Return the constants of the servos' lag, and the oil's viscosities relative to that at the pour point."""
    bandwidths = [rate for rate in hydraulics.column("bandwidth").tolist() if rate > 0]
    loop = _core.SERVO_LOOP_RATE * min(bandwidths) / control.rate
    lowest = present = 1.0
    if robot.oil is not None and not math.isnan(hydraulics.temperature):  # NaN if no joint has oil
        hottest, now, thickest = viscosity(robot.oil, [HOTTEST, hydraulics.temperature, robot.oil.pour_point]).tolist()
        lowest, present = hottest / thickest, now / thickest
    decay = without_last_bit(math.exp(-loop))
    values = {
        "servo_loop": loop,
        "servo_decay": decay,
        "viscosity_min": rounded_number(lowest),
        "viscosity_own": rounded_number(present),
    }
    return {name: [float(value)] for name, value in values.items()}


def _supervisor(robot: Robot, hydraulics: Circuits, circuit: int) -> dict[str, float]:
    """Return the supervisor's constants of a circuit: servo speed, stall pressure, and compliance [rad/Pa]."""
    row = hydraulics.row(circuit)
    slope = _slope(hydraulics, circuit)
    pressure = _core.ATMOSPHERE + soft_limit(robot)
    oil = (row["oil_pump"] + row["oil_unit"]) * (1 / row["bulk_modulus"] + row["air"] * _core.ATMOSPHERE / pressure**2)
    return {
        "servo_speed": row["speed"],
        "servo_stall": row["stall_torque"] / slope,
        "compliance": (row["compliance"] + oil) / slope,
    }
