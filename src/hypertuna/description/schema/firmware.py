"""The table of the firmware in a robot description: pins of the microcontroller, limits of the supervisor."""

from collections.abc import Collection, Iterator, Sequence
from typing import Annotated, Any

from pydantic import Field

from hypertuna import _core
from hypertuna.description.channels import ANALOG, CHANNELS
from hypertuna.description.schema.base import (
    Check,
    Count,
    Fraction,
    Index,
    Key,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    PositiveFraction,
    Radio,
    entry,
)
from hypertuna.description.schema.body import Drive

MAX_ID = 250  # largest system number in MAVLink

# Pins of a Teensy 4.1, from PJRC's pin card. Pins 42 to 47 belong to the SD card; higher pins are under the board.
PINS = tuple(range(42))
ANALOG_PINS = (*range(14, 28), *range(38, 42))
# Pins with hardware pulse-width modulation, whose pulses a late interrupt does not stretch.
PULSE_PINS = (*range(16), 18, 19, *range(22, 26), 28, 29, 33, 36, 37)
# Pins RX, TX of each serial port.
PORTS = {1: (0, 1), 2: (7, 8), 3: (15, 14), 4: (16, 17), 5: (21, 20), 6: (25, 24), 7: (28, 29), 8: (34, 35)}
DEPTH = {18: "the depth sensor", 19: "the depth sensor"}  # pins SDA and SCL of its bus


def _pins_key(quantity: str) -> str:
    """Return the name of the attribute with the pins of a kind of analog sensor."""
    return f"{quantity}_pin" if CHANNELS[quantity].size == 1 else f"{quantity}_pins"


def _analog_pins() -> dict[str, tuple[Any, Any]]:
    """Return type and key of the pins of every analog channel, by attribute."""
    order = {"joint": ", one per joint group", "circuit": ", left and right of each joint group", "robot": ""}
    keys: dict[str, tuple[Any, Any]] = {}
    for name in ANALOG:
        if CHANNELS[name].size == 1:
            keys[_pins_key(name)] = (Index, entry(f"analog pin of the {name} sensor", how="read the wiring"))
        else:
            text = f"analog pins of the {name} sensors{order[CHANNELS[name].per]}"
            keys[_pins_key(name)] = (tuple[Index, ...], entry(text, how="read the wiring"))
    return keys


ANSWERS = _core.answer_table()  # possible responses to a fault, in the order of their numbers
FIRST_ANSWER = 15  # place of the first response among the parameters of the radio


def _answers() -> dict[str, tuple[Any, Key]]:
    """Return, by attribute, type and key of the response to each fault with a choice of responses."""
    choices = [(key, name, answer) for name, _, answer, *_, key in _core.fault_table() if key]
    spelled = ", ".join(f"{number} {answer}" for number, answer in enumerate(ANSWERS))
    most = len(ANSWERS) - 1
    kind = Annotated[int, Field(strict=True, ge=0, le=most)]
    return {
        key: (kind, entry(
            f"response to the fault {name}: {spelled}",
            default=ANSWERS.index(answer),
            radio=Radio(FIRST_ANSWER + k, 0, most, bounds=True, whole=True),
        ))
        for k, (key, name, answer) in enumerate(choices)
    }  # fmt: skip


class Firmware(Part, table="firmware", keys=_analog_pins() | _answers(), how="as HyperTuna's; limits for your water"):
    """The firmware: pins, and limits of the supervisor on board; without influence on simulations."""

    servo_pins: tuple[Index, ...] = entry(
        "pins of the servos: of each joint group's left and right pump, or of the servo on its axle, then port and "
        "starboard fin",
        how="read the wiring",
    )
    leak_pin: Index = entry("pin of the leak sensor, low when wet", how="read the wiring")
    recovery_pin: Index = entry(
        "pin that deletes the signing key when it is connected to ground during a boot", how="read the wiring"
    )
    imu_serial: Count = entry("number of the serial port of the IMU", how="read the wiring")
    position_serial: Count = entry("number of the serial port of the satellite receiver", how="read the wiring")
    radio_serial: Count = entry("number of the serial port of the radio", how="read the wiring")
    radio_baud: Count = entry("rate of the radio's serial port", "bit/s", how="data sheet of the radio")
    analog_low: Fraction = entry("fraction of the converter's range that is the lower end of an analog sensor's range")
    analog_high: PositiveFraction = entry(
        "fraction of the converter's range that is the upper end of an analog sensor's range"
    )

    manual_timeout: Positive = entry(
        "time without a joystick after which the tail rests", "s", radio=Radio(1, 0.1, 1.0)
    )
    link_timeout: Positive = entry(
        "time without the ground station after which a gait ends", "s", radio=Radio(2, 0.2, 2.0)
    )
    home_timeout: Positive = entry(
        "time without the ground station after which the robot goes home", "s", radio=Radio(3, 0.2, 10.0)
    )
    voltage_empty: Positive = entry(
        "battery voltage at which the robot surfaces and disarms",
        "V",
        how="data sheet of the cell: end of discharge, times the cells in series",
        usual=(1.0, 60.0),
        radio=Radio(4, 1.0, 1.2),
    )
    voltage_after: Positive = entry("time of low voltage before the supervisor acts", "s")
    tilt_max: PositiveDegrees = entry(
        "roll or pitch beyond which the tail rests", "deg", usual=(5.0, 180.0), radio=Radio(5, 0.5, 1.0)
    )
    tilt_after: Positive = entry("time of a larger roll or pitch before the supervisor acts", "s")
    leak_after: Positive = entry("time of a leak before the supervisor acts", "s")
    rise_depth: Positive = entry(
        "depth from which a robot without a mission surfaces on return home",
        "m",
        usual=(0.05, 100.0),
        radio=Radio(6, 0.2, 4.0),
    )
    depth_max: Positive = entry(
        "deepest that the hull is taken, in missions and outside them",
        "m",
        usual=(0.5, 1000.0),
        radio=Radio(7, 0.05, 1.0),
    )
    watchdog: Positive = entry("time without a tick after which the watchdog restarts the firmware", "s")
    link_rate: Positive = entry(
        "rate of the radio over the air",
        "bit/s",
        how="data sheet of the radio: rate through the air",
        radio=Radio(8, 300.0, 115200.0, bounds=True),
    )
    link_share: PositiveFraction = entry(
        "fraction of the radio's rate for telemetry", radio=Radio(9, 0.05, 1.0, bounds=True)
    )
    system_id: Count = entry(
        "number of the robot in MAVLink, 1 to 250", radio=Radio(10, 1, 250, bounds=True, whole=True)
    )

    snag_distance: NotNegative = entry(
        "distance swum on a course without way over ground after which the robot counts as entangled or aground; 0 for "
        "never",
        "m",
        default=30.0,
        usual=(5.0, 500.0),
        radio=Radio(12, 0.0, 500.0, bounds=True),
    )
    sink_depth: Positive = entry(
        "depth by which a robot at rest may sink", "m", default=0.4, radio=Radio(13, 0.1, 10.0, bounds=True)
    )
    beacon_interval: Positive = entry(
        "time between two beacons of a robot that rests after a failsafe",
        "s",
        default=30.0,
        usual=(1.0, 600.0),
        radio=Radio(14, 1.0, 600.0, bounds=True),
    )

    def analog_pins(self, quantity: str) -> tuple[int, ...]:
        """Return the pins of a kind of analog sensor."""
        pins = getattr(self, _pins_key(quantity))
        return (pins,) if isinstance(pins, int) else pins

    def _checks(self) -> Iterator[Check]:
        """Check that pins and ports exist on the microcontroller, each with one use only."""
        yield self.ordered("analog_low", "analog_high")
        yield self.ordered("link_timeout", "home_timeout")
        identity = self.system_id <= MAX_ID
        yield Check(identity, "system_id", f"must be at most {MAX_ID}", "choose another number for this robot")
        uses = dict(DEPTH)
        for name in ("imu_serial", "position_serial", "radio_serial"):
            port = getattr(self, name)
            yield Check(port in PORTS, name, f"must be from 1 to {max(PORTS)}", "choose another port")
            for pin in PORTS[port]:
                yield _free(uses, pin, name)
        analog = tuple(map(_pins_key, ANALOG))
        kinds = dict.fromkeys(("leak_pin", "recovery_pin"), (PINS, "must be from 0 to 41"))
        kinds |= dict.fromkeys(analog, (ANALOG_PINS, "must be one of 14 to 27 or 38 to 41"))
        pulses = "must have pulses by hardware: 0 to 15, 18, 19, 22 to 25, 28, 29, 33, 36 or 37"
        for name, (pins, text) in {"servo_pins": (PULSE_PINS, pulses), **kinds}.items():
            pins_given = getattr(self, name)
            for pin in (pins_given,) if isinstance(pins_given, int) else pins_given:
                yield Check(pin in pins, name, text, "choose another pin", f"{pin}")
                yield _free(uses, pin, name)

    def pin_checks(self, drives: Sequence[Drive], sensors: Collection[str]) -> Iterator[Check]:
        """Check that every servo and sensor of the joint groups' drives has its pin."""
        groups, counts = len(drives), {"servo_pins": (self.servo_pins, 2 + sum(len(one.servos) for one in drives))}
        for name in ANALOG:
            counts[_pins_key(name)] = (self.analog_pins(name), sum(wired(name, drives, sensors)))
        for name, (pins, count) in counts.items():
            text = f"must be {count} long, for {groups} joint group{'s' * (groups != 1)}"
            yield Check(len(pins) == count, f"firmware.{name}", text, f"give {count} pins", f"{len(pins)} long")


def wired(quantity: str, drives: Sequence[Drive], sensors: Collection[str]) -> list[bool]:
    """Return for each channel of a kind of analog sensor whether a sensor is wired to it.

    A joint group that a servo turns has no bend or pressure sensor, and at most one current sensor; in a robot without
    oil, only if the robot's file describes current sensors.
    """
    per = CHANNELS[quantity].per
    if per == "robot":
        return [True] * CHANNELS[quantity].size
    if per == "joint":
        return [one.oil for one in drives]
    read = quantity == "current" and (any(one.oil for one in drives) or quantity in sensors)
    return [side < len(one.servos) and (one.oil or read) for one in drives for side in range(2)]


def _free(uses: dict[int, str], pin: int, name: str) -> Check:
    """Note the use of a pin, and return the check that the pin has no other use."""
    other = uses.setdefault(pin, name)
    text = f"must leave pin {pin} to {other}"
    return Check(other == name, f"firmware.{name}", text, "wire one of the two elsewhere")
