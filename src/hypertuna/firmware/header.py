"""C++ header of a robot, firmware/robots/NAME.hpp: numbers, parameters with their descriptions, and wiring."""

import numpy as np

from hypertuna.control.sensors import sensor_of
from hypertuna.description.channels import ANALOG
from hypertuna.description.robot import require
from hypertuna.firmware.metadata import metadata
from hypertuna.firmware.parameters import FirmwareTable, pins_of


def header(table: FirmwareTable) -> str:
    """Return the C++ header firmware/robots/NAME.hpp of a robot."""
    import jinja2

    robot = table.robot
    wired = require(robot.firmware, "firmware", robot)
    parts = pins_of(robot)
    analog = [pin for name in ANALOG for pin in parts[name]]  # in the order of the channels
    pins = {"servo": parts["servo"], "analog": analog, "leak": (wired.leak_pin,), "recovery": (wired.recovery_pin,)}
    loader = jinja2.PackageLoader("hypertuna.firmware")
    environment = jinja2.Environment(loader=loader, trim_blocks=True, keep_trailing_newline=True)
    environment.filters["literal"] = _literal
    period = require(sensor_of(robot, "position").period, "sensors.period_s", robot)
    return environment.get_template("robot.hpp.j2").render(
        table=table, robot=robot, wired=wired, pins=pins, fix_ms=round(1000 * period), files=metadata(table)
    )


def _literal(value: float) -> str:
    """Return a float literal of the same 32 bits in C++."""
    text = str(np.float32(value))
    return f"{text}f" if any(c in text for c in ".e") else f"{text}.0f"
