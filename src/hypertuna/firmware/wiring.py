"""Wiring of a robot's board: every pin of a Teensy 4.1 that [firmware] uses, the part at it, its level and its bus."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from hypertuna.actuation.hydraulics import drive_names
from hypertuna.control.controller import sensor_range
from hypertuna.control.sensors import sensor_absent
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.channels import ANALOG, CHANNELS
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.firmware import PORTS, Firmware
from hypertuna.firmware.parameters import pins_of

SUPPLY = 3.3  # V of the board's pins and of its converter, by PJRC's card; no pin withstands more
IMU_BAUD, RECEIVER_BAUD, I2C_RATE = 115_200, 38_400, 400_000  # bit/s, as in firmware/boards/teensy41/teensy.hpp
DEPTH_PINS = {"SDA": 18, "SCL": 19}  # of the depth sensor, on the bus Wire
# Resistances of one decade of the series E24.
E24 = (10, 11, 12, 13, 15, 16, 18, 20, 22, 24, 27, 30, 33, 36, 39, 43, 47, 51, 56, 62, 68, 75, 82, 91)
UPPER = 100e3  # resistor from the battery to the pin [ohm]
# Analog sensor -> unit in which its range is printed, and factor from SI to that unit.
UNITS = {"bend": ("deg", 180 / math.pi), "pressure": ("kPa", 1e-3), "current": ("A", 1.0), "voltage": ("V", 1.0)}


class Wire(NamedTuple):
    """A pin of the board."""

    pin: int
    part: str  # at the other end
    signal: str  # of the part
    to: str  # direction of the signal: "board", "part" or "both"
    bus: str
    rate: int  # of the bus [bit/s], 0 for none
    level: str  # voltages at the pin
    range: str = ""  # of an analog sensor, from the lower to the higher level


class Divider(NamedTuple):
    """Three resistors at an analog pin: to the battery, to ground, to 3.3 V [ohm]."""

    upper: float
    lower: float
    lift: float

    def volts(self, battery: float) -> float:
        """Return the voltage of the pin [V] for a voltage of the battery [V]."""
        current = battery / self.upper + SUPPLY / self.lift
        return current / (1 / self.upper + 1 / self.lower + 1 / self.lift)


@dataclass(frozen=True)
class Wiring:
    """Wiring of a robot's board."""

    robot: Robot
    wires: tuple[Wire, ...]  # by pin
    divider: Divider  # of the battery's voltage, of the series E24


def wiring_of(robot: Robot) -> Wiring:
    """Return the wiring of a robot with the table [firmware]."""
    require_at_sea(robot, "firmware")
    firmware = require(robot.firmware, "firmware", robot)
    wires = sorted([*_servo_wires(robot), *_analog_wires(robot, firmware), *_digital_wires(robot, firmware)])
    return Wiring(robot, tuple(wires), _divider(robot, firmware))


def _servo_wires(robot: Robot) -> Iterator[Wire]:
    places = {group.name: group.drive.place for group in robot.joints}
    drives = [f"on the {places[name]} of joint {name}" if name in places else f"of joint {name.replace('-', ', ')}"
              for name in drive_names(robot)]  # fmt: skip
    names = [*(f"servo {text}" for text in drives), "servo of the port fin", "servo of the starboard fin"]
    for number, (pin, name) in enumerate(zip(pins_of(robot)["servo"], names, strict=True)):
        if pin >= 0:
            yield Wire(pin, name, f"servo_{number}", "part", "pulses", 0, "0 or 3.3 V")


def _analog_wires(robot: Robot, firmware: Firmware) -> Iterator[Wire]:
    level = f"{SUPPLY * firmware.analog_low:.2f} to {SUPPLY * firmware.analog_high:.2f} V"
    for name in ANALOG:
        part = next((sensor.part for sensor in robot.sensors if sensor.quantity == name), name)
        signals = [f"{name}_{k}" for k in range(len(pins_of(robot)[name]))] if CHANNELS[name].size > 1 else [name]
        for pin, signal, where in zip(pins_of(robot)[name], signals, _place_texts(robot, name), strict=True):
            if pin >= 0:
                yield Wire(pin, f"{part}{where}", signal, "board", "analog", 0, level, _range_text(robot, name))


def _place_texts(robot: Robot, name: str) -> list[str]:
    """Return where each sensor of a kind is, as the end of its part's name."""
    if CHANNELS[name].per == "joint":
        return [f", joint {group.name}" for group in robot.joints]
    if CHANNELS[name].per == "circuit":
        return [f", joint {group.name}, {side}" for group in robot.joints for side in ("left", "right")]
    return [""]


def _range_text(robot: Robot, name: str) -> str:
    """Return, as text, the range of a kind of analog sensor from which calibration starts."""
    if sensor_absent(robot, name):
        return ""
    unit, factor = UNITS[name]
    low, high = (factor * end for end in sensor_range(robot, name))
    return f"{low:.4g} to {high:.4g} {unit}"


def _digital_wires(robot: Robot, firmware: Firmware) -> Iterator[Wire]:
    parts = {sensor.quantity: sensor.part for sensor in robot.sensors}
    ports = (
        (firmware.imu_serial, f"IMU {parts.get('rate', '')}", IMU_BAUD),
        (firmware.position_serial, f"receiver {parts.get('position', '')}", RECEIVER_BAUD),
        (firmware.radio_serial, "radio modem", firmware.radio_baud),
    )
    for port, part, baud in ports:
        receive, send = PORTS[port]
        yield Wire(receive, part.strip(), "TX of part", "board", f"Serial{port}", baud, "0 or 3.3 V")
        yield Wire(send, part.strip(), "RX of part", "part", f"Serial{port}", baud, "0 or 3.3 V")
    for signal, pin in DEPTH_PINS.items():
        part = f"depth sensor {parts.get('depth', '')}".strip()
        yield Wire(pin, part, signal, "both", "I2C", I2C_RATE, "3.3 V by a pull-up")
    yield Wire(firmware.leak_pin, "leak probe", "leak", "board", "digital", 0, "3.3 V dry, 0 V wet")
    yield Wire(firmware.recovery_pin, "jumper", "recovery", "board", "digital", 0, "open; 0 V deletes the key at boot")


def _divider(robot: Robot, firmware: Firmware) -> Divider:
    """Return resistors of E24 near those that bring the range of the battery's voltage to the pin's range.

    With G the sum of the three conductances, the pin shows battery / (upper G) + 3.3 V / (lift G).
    """
    low, high = sensor_range(robot, "voltage")
    gain = SUPPLY * (firmware.analog_high - firmware.analog_low) / (high - low)
    offset = firmware.analog_low - low * gain / SUPPLY  # share of 3.3 V at 0 V
    conductance = 1 / (gain * UPPER)
    return Divider(UPPER, _e24(1 / (conductance * (1 - gain - offset))), _e24(1 / (conductance * offset)))


def _e24(ohm: float) -> float:
    """Return the nearest resistance of the series E24."""
    decade = 10.0 ** math.floor(math.log10(ohm) - 1)
    return min((value * decade * power for value in E24 for power in (1, 10)), key=lambda x: abs(math.log(x / ohm)))
