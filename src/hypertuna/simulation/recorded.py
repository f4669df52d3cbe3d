"""Quantities that a run of the twin records: names, dimensions, units and meanings."""

from hypertuna import _core

# Conditions in the controller's status, in order of bits: by name, place ("joint", "circuit", ...) and meaning.
CONDITIONS = {name: (place, text) for name, place, text in _core.condition_table()}
# Losses that add up to the servos' power: by name, place ("servos", "oil", "joints", "water") and meaning.
LOSSES = {name: (place, text) for name, place, text in _core.loss_table()}
# By name of a recorded quantity: its dimension in addition to time, unit and meaning.
Variables = dict[str, tuple[str, str, str]]
VARIABLES: Variables = {
    "x": ("", "m", "position of the nose"),
    "y": ("", "m", "position of the nose"),
    "heading": ("", "rad", "angle of the head's axis (nose to tail) from x, counter-clockwise"),
    "speed": ("", "m/s", "velocity of the nose along the head's axis, ahead"),
    "sway": ("", "m/s", "velocity of the nose across the head's axis"),
    "yaw": ("", "rad/s", "rate of turn of the head, counter-clockwise"),
    "angle": ("joint", "rad", "bend of the joint group, counter-clockwise"),
    "rate": ("joint", "rad/s", "rate of the bend"),
    "moment": ("joint", "N m", "moment of oil and silicone, or of the servo, on the bend"),
    "hinge_angle": ("hinge", "rad", "bend of the passive hinge, counter-clockwise"),
    "hinge_rate": ("hinge", "rad/s", "rate of the hinge's bend"),
    "hinge_moment": ("hinge", "N m", "moment of the hinge's spring and damper"),
    "angle_measured": ("joint", "rad", "reading of the bend sensor"),
    "angle_set": ("joint", "rad", "bend that the command asks for"),
    "pump_pressure": ("circuit", "Pa", "gauge pressure in the cylinder"),
    "unit_pressure": ("circuit", "Pa", "gauge pressure in the drive units"),
    "pump_pressure_high": ("circuit", "Pa", "largest pressure in the cylinder within the control tick"),
    "pump_pressure_low": ("circuit", "Pa", "smallest pressure in the cylinder within the control tick"),
    "unit_pressure_high": ("circuit", "Pa", "largest pressure in the drive units within the control tick"),
    "unit_pressure_low": ("circuit", "Pa", "smallest pressure in the drive units within the control tick"),
    "pressure_measured": ("circuit", "Pa", "reading of the pressure sensor"),
    "servo_target": ("drive", "rad", "servo angle that the pulse asks for, positive pushes oil out"),
    "servo_angle": ("drive", "rad", "servo angle from neutral"),
    "servo_rate": ("drive", "rad/s", "servo rate"),
    "servo_torque": ("drive", "N m", "torque of the servo's motor at its output"),
    "flow": ("circuit", "m^3/s", "flow of oil toward the drive units"),
    "electrical_power": ("drive", "W", "mean electrical power of the servo within the control tick"),
    "current": ("drive", "A", "reading of the current sensor"),
    "power": ("", "W", "mean electrical power of all servos within the control tick"),
    **{f"loss_{name}": ("", "W", text) for name, (_, text) in LOSSES.items()},
    "battery_current": ("", "A", "current from the battery, mean of the control tick"),
    "battery_voltage": ("", "V", "voltage at the battery's terminals"),
    "pulse": ("servo", "s", "servo pulse"),
    "status": ("", "1", "flags of the controller's status"),
}

# Recorded quantities that have another name in datasets.
NAMES = {"power": "electrical_power", "electrical_power": "servo_power"}
