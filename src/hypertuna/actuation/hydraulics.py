"""Pump, oil and lines: the hydraulic circuits of a robot for the core."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hypertuna import _core
from hypertuna.arrays import Array, rounded_number, without_last_bit
from hypertuna.description.robot import Robot, joint_key, parse, require
from hypertuna.description.schema.base import Part
from hypertuna.description.schema.body import JointGroup
from hypertuna.description.schema.hydraulics import HOTTEST, Line, Oil, Pump, Servo
from hypertuna.errors import InputError
from hypertuna.io.quantity import ZERO_CELSIUS
from hypertuna.ranges import POSITIVE

SIDES = ("left", "right")
DRIVES = "piston pump"  # value of the key `drives` of servos that drive the pump
SOFTER = "more air or compliance, a narrower or longer line, or heavier rotors"  # fix for a circuit that is too stiff
LAMINAR_INERTIA = 4 / 3  # momentum of Poiseuille flow over that of plug flow
ASTM_OFFSET = 0.7  # cSt, offset of the viscosity in ASTM D341


@dataclass(frozen=True)
class Circuits:
    """Numbers of a robot's circuits for the core, two rows per joint; without oil, the left row is the joint servo."""

    names: tuple[str, ...]  # "I-left", "I-right", ...: circuit 2 j + s is side s of joint j; "" for an empty row
    columns: tuple[str, ...]  # names of the columns in core/include/hypertuna/actuation/circuit.hpp
    values: Array  # (circuits, columns) [SI]
    temperature: float  # temperature of the oil [K]; NaN without oil
    viscosity: float  # kinematic viscosity of the oil [m^2/s]; NaN without oil

    def column(self, name: str) -> Array:
        """Return the column of a name: one quantity of every circuit [SI]."""
        column: Array = self.values[:, self.columns.index(name)]
        return column

    def row(self, circuit: int) -> dict[str, float]:
        """Return every quantity of one circuit by name [SI]."""
        return dict(zip(self.columns, self.values[circuit].tolist(), strict=True))


def viscosity(oil: Oil, temperature: ArrayLike) -> Array:
    """Return an oil's kinematic viscosity [m^2/s] at a temperature [K]: log10 log10(nu + 0.7) = A - B log10 T (ASTM).

    A and B follow from the viscosities at 40 and 100 C. In the equation nu is in cSt.
    """
    kelvin = np.asarray(temperature, dtype=np.float64)
    outside = ~((kelvin >= oil.pour_point) & (kelvin <= HOTTEST))
    if outside.any():
        low, high = (f"{limit - ZERO_CELSIUS:.4g}" for limit in (oil.pour_point, HOTTEST))
        value = f"{kelvin[outside].flat[0] - ZERO_CELSIUS:.4g} degC"
        fix = f"{oil.name} flows above its pour point, and its viscosity is known up to 100 C"
        raise InputError(f"must be from {low} to {high} degC", key="temperature", value=value, fix=fix)
    log_kelvin = np.log10(np.array([40.0, 100.0]) + ZERO_CELSIUS)
    log_log_nu = np.log10(np.log10(np.array([oil.viscosity_40, oil.viscosity_100]) * 1e6 + ASTM_OFFSET))
    slope = (log_log_nu[1] - log_log_nu[0]) / (log_kelvin[1] - log_kelvin[0])
    interpolated = log_log_nu[0] + slope * (np.log10(kelvin) - log_kelvin[0])
    result: Array = (10.0 ** (10.0**interpolated) - ASTM_OFFSET) * 1e-6
    return result


def line_resistance(length: float, bore: float, dynamic_viscosity: float) -> float:
    """Return the laminar resistance of a line, 128 mu l / (pi d^4) (Poiseuille) [Pa s/m^3]."""
    return 128 * dynamic_viscosity * length / (np.pi * bore**4)


def line_inertance(length: float, bore: float, density: float) -> float:
    """Return the inertance of a line in laminar flow, 4/3 rho l / (pi d^2 / 4) [Pa s^2/m^3].

    The factor 4/3 holds for a Poiseuille profile, up to a Womersley number d/2 sqrt(w / nu) of about 2.
    """
    return LAMINAR_INERTIA * density * length / (np.pi / 4 * bore**2)


def line_loss(bore: float, coefficient: float, density: float) -> float:
    """Return the entry and exit loss of a line over the flow squared, coefficient x rho / (2 area^2) [Pa s^2/m^6]."""
    return coefficient * density / (2 * (np.pi / 4 * bore**2) ** 2)


def _rest_volume(robot: Robot, group: JointGroup) -> float:
    """Return the oil volume [m^3] in the lumens of one side's drive units, straight and at rest."""
    unit = require(robot.drive_unit, "drive_unit", robot)
    actuator = require(group.actuator, f"{joint_key(robot, group.name)}.actuator", robot)
    count = require(group.drive_units, f"{joint_key(robot, group.name)}.drive_units", robot)
    return float(count * np.pi / 4 * unit.inner_diameter**2 * actuator.length)


def pump_servo(robot: Robot) -> Servo:
    """Return the table of the servos that drive the pump's cylinders; all its values must be given."""
    index = next((i for i, servo in enumerate(robot.servos) if servo.drives == DRIVES), None)
    k = require(index, f"[[servos]] with drives = {DRIVES!r}", robot, "add that table to the robot's file")
    servo = robot.servos[k]
    for name, info in type(servo).model_fields.items():
        require(getattr(servo, name), f"servos[{k}].{info.alias}", robot)
    count = sum(len(group.drive.servos) for group in robot.joints if group.drive.oil)
    if servo.count != count:
        rule, fix = f"must be {count}, one per side of each joint group with muscles", "one servo drives one cylinder"
        raise InputError(rule, file=robot.file or None, key=f"servos[{k}].count", value=str(servo.count), fix=fix)
    return servo


def rated_voltage(robot: Robot) -> float:
    """Return the lowest voltage [V] for which torque and speed of the joints' servos are given."""
    rated = [group.servo.voltage for group in robot.joints if group.servo is not None]
    if has_oil(robot):
        rated.append(require(pump_servo(robot).voltage, "servos.voltage_v", robot))
    return min(rated)


def supply_voltage(robot: Robot) -> float:
    """Return the voltage at the servos [V]: the battery's nominal one, at most the converter's; else the rated one."""
    battery, rated = robot.battery, rated_voltage(robot)
    if battery is None or battery.series is None:
        return rated
    nominal = battery.series * battery.voltage
    return nominal if battery.converter is None else min(nominal, battery.converter)


def has_oil(robot: Robot) -> bool:
    """Return whether oil moves any of the joints."""
    return any(group.drive.oil for group in robot.joints)


def drive_names(robot: Robot, *, oil: bool = False) -> tuple[str, ...]:
    """Return the names of the servos that move the joints, two per joint: "I-left", "I-right"; "II", "" with one servo.

    oil: name only the servos of circuits.
    """
    pairs = ([f"{g.name}{end}" for end in g.drive.servos if g.drive.oil or not oil] for g in robot.joints)
    return tuple(name for names in pairs for name in (*names, "", "")[: len(SIDES)])


def circuits(robot: Robot, temperature: float | None = None) -> Circuits:
    """Return the circuits of a robot at an oil temperature [K], by default that of its file.

    They are filled so that with straight joints and servos at zero all pressures are the line's fill pressure.
    """
    columns, rows = tuple(_core.circuit_columns()), []
    kelvin, nu = math.nan, math.nan
    if has_oil(robot):
        require(robot.pump, "pump", robot)
        oil = require(robot.oil, "oil", robot)
        kelvin = oil.temperature if temperature is None else temperature
        nu = rounded_number(float(viscosity(oil, kelvin)))
    for group in robot.joints:
        if group.servo is not None:
            rows += [_given(group.servo) | {"stall_torque": group.servo.torque}, {}]
        else:
            rows += [_circuit_of(robot, group, nu)] * len(SIDES)
    values = np.array([[row.get(name, 0.0) for name in columns] for row in rows], dtype=np.float64)
    return Circuits(drive_names(robot), columns, values, kelvin, nu)


def _circuit_of(robot: Robot, group: JointGroup, nu: float) -> dict[str, float]:
    """Return the numbers of one circuit of a joint by the core's names, with oil of a viscosity [m^2/s]."""
    pump, oil = require(robot.pump, "pump", robot), require(robot.oil, "oil", robot)
    line = require(group.line, f"{joint_key(robot, group.name)}.line", robot)
    if line.fill_pressure <= oil.cavitation:
        rule, fix = f"must be more than oil.cavitation_pa = {oil.cavitation:g}", "fill the circuit with more oil"
        key, value = f"{joint_key(robot, group.name)}.line.fill_pressure_pa", f"{line.fill_pressure:g}"
        raise InputError(rule, file=robot.file or None, key=key, value=value, fix=fix)
    return _circuit(pump, pump_servo(robot), oil, line, _rest_volume(robot, group), nu)


def require_oil(robot: Robot, key: str) -> None:
    """Refuse an option that applies to oil only, if the robot has no oil."""
    if not has_oil(robot):
        rule, fix = f"applies to oil, and servos turn all joints of {robot.name}", "leave it out"
        raise InputError(rule, file=robot.file or None, key=key, fix=fix)


def with_bore(robot: Robot, bore: float) -> Robot:
    """Return the robot with all lines of a new bore [m]."""
    require_oil(robot, "bore")
    POSITIVE.check(1e3 * bore, "bore", "give the inner diameter of the lines in mm")
    document = robot.document()
    for k, joint in enumerate(document["joints"]):
        if not robot.joints[k].drive.oil:
            continue
        line = require(joint.get("line"), f"joints[{k}].line", robot)
        line["bore_m"] = bore
    return parse(document, file=robot.file)


def servo_angle(hydraulics: Circuits, volume: ArrayLike, circuit: int = 0) -> Array:
    """Return the servo angle [rad] that displaces a volume [m^3], by the inverse of the slider-crank.

    NaN beyond the dead centers.
    """
    numbers = hydraulics.row(circuit)
    crank, rod = numbers["crank"], numbers["rod"]
    # law of cosines in the triangle of crank, rod and the distance from the piston to the axle
    distance = np.asarray(volume, dtype=np.float64) / numbers["area"] + numbers["start"] + rod - crank
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = (distance**2 + crank**2 - rod**2) / (2 * distance * crank)
        result: Array = np.pi - np.arccos(np.where(abs(cosine) <= 1, cosine, np.nan)) - numbers["neutral"]
    return result


def _given(*parts: Part) -> dict[str, float]:
    """Return the numbers of description tables under the names of circuit columns: such a key needs no line here."""
    return {name: getattr(part, name) for part in parts for name in _core.circuit_columns() if name in part.declared}


def _circuit(pump: Pump, servo: Servo, oil: Oil, line: Line, rest: float, nu: float) -> dict[str, float]:
    """Return one circuit's numbers by the core's names; rest: oil in its drive units [m^3], nu: viscosity [m^2/s]."""
    area = np.pi / 4 * pump.bore**2
    sine, cosine = (without_last_bit(f(pump.neutral)) for f in (math.sin, math.cos))
    piston_start = pump.crank * (1 - cosine) - pump.rod + math.sqrt(pump.rod**2 - (pump.crank * sine) ** 2)
    chamber = pump.dead_volume + area * (2 * pump.crank - piston_start)
    volume = rest + np.pi / 4 * line.bore**2 * line.length
    fill = line.fill_pressure
    expansion = 1 - fill / oil.bulk_modulus + oil.air * _core.ATMOSPHERE / (_core.ATMOSPHERE + fill)
    return _given(pump, servo, line, oil) | {
        "area": area,
        "start": piston_start,
        "chamber": chamber,
        "seal": pump.seal_friction,
        "stall_torque": servo.torque,
        "resistance": line_resistance(line.length, line.bore, nu * oil.density),
        "loss": line_loss(line.bore, line.loss, oil.density),
        "inertance": line_inertance(line.length, line.bore, oil.density),
        "oil_pump": chamber / expansion,
        "oil_unit": (volume + line.compliance * fill) / expansion,
        "unit_rest": volume,
    }
