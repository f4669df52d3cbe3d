"""Values that are allowed but unlikely, each in a sentence: slips of units and of powers of ten."""

import math
import re
from collections.abc import Iterator
from typing import Any

from hypertuna.description.robot import Robot
from hypertuna.description.schema.body import AROUND

# Usual values by key without indices, in the units of the file; wide enough for robots in a lab, a lake or at sea.
USUAL: dict[str, tuple[float, float]] = {
    "body.length_m": (0.02, 20.0),
    "body.width_m": (0.002, 10.0),
    "body.height_m": (0.002, 10.0),
    "links.length_m": (5e-4, 10.0),
    "water.density_kg_m3": (900.0, 1300.0),
    "water.lumped.added_mass": (0.0, 5.0),
    "water.strip.added_mass_normal": (0.001, 5.0),
    "water.elongated.added_mass_normal": (0.0, 5.0),
    "water.strip.drag_normal": (0.05, 10.0),
    "water.elongated.drag_normal": (0.05, 10.0),
    "water.strip.drag_tangential": (5e-4, 1.0),
    "water.elongated.drag_tangential": (0.0, 1.0),
    "gaits.frequency_hz": (0.02, 20.0),
    "gaits.amplitude_deg": (1.6, 180.0),
    "gait_bounds.frequency_hz": (0.01, 30.0),
    "joints.amplitude_max_deg": (1.6, 180.0),
    "joints.bend_max_deg": (1.6, 180.0),
    "joints.bandwidth_hz": (0.1, 200.0),
    "joints.pressure_max_pa": (2e3, 5e6),
    "joints.line.length_m": (0.005, 20.0),
    "joints.line.bore_m": (0.0005, 0.03),
    "joints.line.compliance_m3_pa": (0.0, 1e-9),
    "joints.actuator.segment_length_m": (0.001, 1.0),
    "joints.actuator.semi_major_m": (0.002, 1.0),
    "joints.actuator.semi_minor_m": (0.002, 1.0),
    "joints.servo.torque_n_m": (0.01, 200.0),
    "joints.servo.speed_rad_s": (0.3, 60.0),
    "joints.servo.voltage_v": (2.0, 60.0),
    "joints.servo.stall_current_a": (0.05, 200.0),
    "joints.servo.idle_current_a": (0.001, 2.0),
    "joints.servo.friction_n_m": (1e-4, 20.0),
    "joints.servo.inertia_kg_m2": (1e-8, 1.0),
    "joints.servo.bandwidth_hz": (1.0, 100.0),
    "joints.actuator.stiffness_factor": (0.2, 20.0),
    "hinge.stiffness_n_m_per_rad": (1e-4, 1e3),
    "hinge.damping_n_m_s_per_rad": (1e-6, 10.0),
    "links.inertia_kg_m2": (1e-9, 100.0),
    "drive_unit.outer_diameter_m": (0.0006, 0.1),
    "drive_unit.inner_diameter_m": (0.0003, 0.1),
    "drive_unit.braid_angle_deg": (5.0, 54.7),
    "materials.modulus_100_pa": (2e3, 1e8),
    "materials.modulus_fe_pa": (2e3, 1e8),
    "materials.tensile_strength_pa": (1e4, 1e9),
    "materials.relaxation_s": (0.0, 1.0),
    "pump.bore_m": (0.002, 0.2),
    "pump.crank_m": (0.001, 0.5),
    "pump.rod_m": (0.002, 1.0),
    "pump.dead_volume_m3": (0.0, 1e-3),
    "pump.seal_friction_n": (0.0, 500.0),
    "oil.viscosity_40_m2_s": (3e-7, 1e-2),
    "oil.viscosity_100_m2_s": (3e-7, 1e-2),
    "oil.density_kg_m3": (500.0, 2500.0),
    "oil.bulk_modulus_pa": (4e8, 1e10),
    "oil.cavitation_pa": (-101325.0, -1e4),
    "servos.torque_n_m": (0.005, 200.0),
    "servos.speed_rad_s": (0.3, 60.0),
    "servos.voltage_v": (2.0, 60.0),
    "servos.stall_current_a": (0.005, 200.0),
    "servos.inertia_kg_m2": (1e-7, 1.0),
    "battery.capacity_ah": (0.02, 500.0),
    "battery.voltage_v": (1.0, 60.0),
    "controller.rate_hz": (5.0, 5000.0),
    "controller.pressure_work_pa": (2e3, 1e7),
    "controller.pressure_soft_pa": (2e3, 1e7),
    "controller.pressure_hard_pa": (2e3, 1e7),
    "fins.span_m": (0.002, 2.0),
    "fins.stall_deg": (5.0, 60.0),
    "joints.line.fill_pressure_pa": (1e3, 1e6),
    "joints.actuator.lever_m": (5e-4, 0.2),
    "joints.actuator.spacing_m": (5e-4, 0.2),
    "water.strip.added_inertia": (0.05, 5.0),
    "water.strip.drag_beating": (0.0, 20.0),
    "water.strip.added_mass_tangential": (5e-4, 0.6),
    "water.strip.edge_lift": (0.1, 2.0),
    "servos.idle_current_a": (0.001, 2.0),
    "servos.friction_n_m": (1e-4, 20.0),
    "servos.bandwidth_hz": (0.5, 200.0),
    "battery.charged_v": (1.0, 60.0),
    "battery.resistance_ohm": (1e-3, 1.0),
    "battery.converter_v": (1.0, 60.0),
    "battery.electronics_w": (0.0, 200.0),
    "controller.frequency_max_hz": (0.2, 50.0),
    "controller.fin_max_deg": (1.6, 90.0),
    "controller.voltage_low_v": (1.0, 60.0),
    "controller.timeout_s": (0.02, 60.0),
    "controller.smoothing_s": (0.005, 30.0),
    "controller.slew_rad_s": (0.5, 200.0),
    "controller.pulse_center_us": (300.0, 3000.0),
    "controller.pulse_min_us": (300.0, 3000.0),
    "controller.pulse_max_us": (300.0, 3000.0),
    "controller.pulse_us_per_rad": (100.0, 3000.0),
    "guidance.turn_max_deg_s": (1.6, 400.0),
    "guidance.climb_max_deg": (1.6, 90.0),
    "guidance.pitch_max_deg": (1.6, 90.0),
    "guidance.single_fin_max_deg": (1.6, 90.0),
    "guidance.lookahead_m": (0.1, 100.0),
    "guidance.power_w": (0.02, 1e4),
    "guidance.surface_depth_m": (0.005, 5.0),
    "firmware.tilt_max_deg": (5.0, 180.0),
    "firmware.voltage_empty_v": (1.0, 60.0),
    "firmware.rise_depth_m": (0.05, 100.0),
    "firmware.depth_max_m": (0.5, 1000.0),
    "spatial.com_height_m": (-1.0, 1.0),
    "spatial.height_m": (0.001, 5.0),
    "spatial.width_m": (5e-4, 5.0),
    "spatial.drag_vertical": (0.02, 5.0),
    "fins.x_m": (0.002, 10.0),
    "fins.y_m": (0.002, 5.0),
    "fins.chord_m": (0.002, 2.0),
    "fins.drag_zero": (0.001, 0.5),
    "fins.bandwidth_hz": (0.3, 50.0),
    "fins.speed_rad_s": (0.3, 60.0),
}
SLIPS: dict[str, dict[str, float]] = {  # by unit: what may have been meant, and its factor to the unit
    "m": {"mm": 1e-3, "cm": 1e-2},
    "m^2": {"cm^2": 1e-4, "mm^2": 1e-6},
    "m^3": {"ml": 1e-6, "l": 1e-3},
    "kg": {"g": 1e-3},
    "Pa": {"MPa": 1e6, "kPa": 1e3, "bar": 1e5},
    "kg/m^3": {"g/cm^3": 1e3},
    "m^2/s": {"mm^2/s": 1e-6},
    "deg": {"radians": 180 / math.pi},
    "s": {"ms": 1e-3},
    "N m": {"kg cm": 0.0980665, "N mm": 1e-3},
    "kg m^2": {"g cm^2": 1e-7, "kg cm^2": 1e-4},
    "A": {"mA": 1e-3},
    "A h": {"mAh": 1e-3},
    "m/s": {"cm/s": 1e-2, "mm/s": 1e-3},
    "rad/s": {"rpm": math.pi / 30, "deg/s": math.pi / 180},
}
WIDE = 0.6  # width over height of a section whose width is unknown
DENSITY = (5.0, 10e3)  # kg/m^3, of a link: the plate of a fin in the place of an ellipse, to lead
SLENDER = (0.004, 1.0)  # height of a link over the length of the body
FRICTION = (0.1, 12.0)  # wetted over lateral area
HEAVY = 1.3  # of the whole robot over its links
HIGH = 0.7  # of fins and sections over the length of the robot
LOW = 0.01  # of the trailing edge over that length
BLUNT = (1e-6, 0.5)  # drag area over the square of that length
FRONT = 0.1  # of a link: centers of mass lie behind it
BULK = (0.3, 400.0)  # kg/m^3, mass over length cubed
SWIMMING = (0.01, 20.0)  # lengths per second


def implausible(robot: Robot) -> list[str]:
    """Return a sentence for each unlikely value of a robot, none if all are likely."""
    if (slip := _unit_of_lengths(robot)) is not None:
        return [slip, *(told for told in _unusual(robot) if "s.length_m" not in told)]  # comparisons would repeat it
    unlikely = (_unlikely_links, _unlikely_sizes, _unlikely_speeds, _coarse_sensors, _idle_factors)
    return [*_unusual(robot), *(sentence for check in unlikely for sentence in check(robot))]


def _unit_of_lengths(robot: Robot) -> str | None:
    """Return a sentence on links that are too long for the mass, if another unit explains it."""
    whole, mass = math.fsum(robot.links.length), robot.body.mass
    for unit, factor in SLIPS["m"].items() if mass / whole**3 < BULK[0] else ():
        if BULK[0] <= mass / (factor * whole) ** 3 <= BULK[1]:
            lengths = ", ".join(f"{factor * length:.6g}" for length in robot.links.length)
            return (
                f"links.length_m adds up to {whole:g} m, in a robot of {mass:g} kg: is it in {unit}? "
                f"Then write [{lengths}]."
            )
    return None


def _unusual(robot: Robot) -> Iterator[str]:
    """Compare single values with usual ones."""
    for entry in robot.entries():
        usual = USUAL.get(_plain(robot, entry.key))
        if usual is None or entry.default:
            continue
        numbers = [*_numbers(entry.value)]
        bad = [x for x in numbers if not usual[0] <= x <= usual[1] and x != 0]
        if entry.key.endswith("amplitude_deg") and max(numbers, default=0.0) >= usual[0]:
            bad = []  # a joint may well rest
        if bad:
            worst = max(bad, key=abs)
            limits = f"usual are {usual[0]:g} to {usual[1]:g}"
            yield f"{entry.key} has {worst:g} {entry.unit}".rstrip() + f"; {limits}: {_slip(worst, entry.unit, usual)}."


def _slip(value: float, unit: str, usual: tuple[float, float]) -> str:
    """Return the unit that a value may be in, with the value in the unit of the file."""
    for other, factor in SLIPS.get(unit, {}).items():
        if usual[0] <= value * factor <= usual[1]:
            return f"is it in {other}? Then write {value * factor:.6g}"
    return "check the unit and the power of ten"


def _unlikely_links(robot: Robot) -> Iterator[str]:
    """Compare the links' masses, lengths and areas with each other."""
    links, whole = robot.links, robot.body.length
    if not BULK[0] <= robot.body.mass / whole**3 <= BULK[1]:
        like = (20 * whole**3, f"{20 * whole**3:.2g}")[1]
        yield f"body.mass_kg has {robot.body.mass:g} kg; a slender fish of {whole:g} m has about {like} kg: check both."
    if robot.body.mass > HEAVY * (total := math.fsum(links.mass)):
        yield f"body.mass_kg is {robot.body.mass:g} kg, but links.mass_kg adds up to {total:.4g} kg: check both."
    for i, (length, com) in enumerate(zip(links.length, links.com, strict=True)):
        if com < FRONT * length:
            slip = _slip(com, "m", (FRONT * length, length))
            yield f"links.com_m[{i}] is {com:g} m, at the front end of a link of {length:g} m: {slip}."
    volumes = robot.spatial.volume if robot.spatial is not None else (None,) * len(links.name)
    for i, (length, mass, area, wetted, volume) in enumerate(
        zip(links.length, links.mass, links.lateral_area, links.wetted_area, volumes, strict=True)
    ):
        height = area / length
        if not SLENDER[0] <= height / whole <= SLENDER[1]:
            slip = _slip(area, "m^2", (SLENDER[0] * whole * length, SLENDER[1] * whole * length))
            yield f"links.lateral_area_m2[{i}] makes link {links.name[i]} {height:.3g} m high on average: {slip}."
            continue
        if not FRICTION[0] <= wetted / area <= FRICTION[1]:
            yield (
                f"links.wetted_area_m2[{i}] is {wetted / area:.3g} times the lateral area; a plate has 2, an ellipse "
                f"about {AROUND:g}: check both."
            )
        density = mass / (volume or math.pi / 4 * WIDE * height**2 * length)
        if not DENSITY[0] <= density <= DENSITY[1]:
            of = "its volume" if volume else f"an ellipse {WIDE:g} times as wide as high"
            slip = _slip(mass, "kg", (mass * DENSITY[0] / density, mass * DENSITY[1] / density))
            yield f"links.mass_kg[{i}] gives link {links.name[i]} {density:.3g} kg/m^3, by {of}: {slip}."


def _unlikely_sizes(robot: Robot) -> Iterator[str]:
    """Compare fins and sections with the length of the robot."""
    whole, fins, strip, spatial = robot.body.length, robot.fins, robot.water.strip, robot.spatial
    sizes = {
        "body.height_m": robot.body.height or 0.0,
        "fins.span_m": fins.span if fins else 0.0,
        "fins.chord_m": fins.chord if fins else 0.0,
        "water.strip.edge_height_m": strip.edge_height if strip else 0.0,
        "spatial.height_m": max(spatial.height) if spatial else 0.0,
        "spatial.width_m": max(spatial.width) if spatial else 0.0,
    }
    for key, size in sizes.items():
        if size > HIGH * whole or (0 < size < LOW * whole and key.startswith("water")):
            slip = _slip(size, "m", (0.05 * whole, HIGH * whole))
            yield f"{key} has {size:g} m, in a robot {whole:g} m long: {slip}."
    area = max(strip.blunt_area) if strip else 0.0
    if area and not BLUNT[0] <= area / whole**2 <= BLUNT[1]:
        slip = _slip(area, "m^2", (BLUNT[0] * whole**2, BLUNT[1] * whole**2))
        yield f"water.strip.blunt_area_m2 has {area:g} m^2, in a robot {whole:g} m long: {slip}."


def _unlikely_speeds(robot: Robot) -> Iterator[str]:
    """Compare given speeds with the length of the robot."""
    given = {"guidance.speed_m_s": (robot.guidance and robot.guidance.speed) or ()}
    given["fit.speed_m_s"] = (robot.fit and robot.fit.speed) or ()
    for key, speeds in given.items():
        fast = max(speeds, default=0.0) / robot.body.length
        if fast and not SWIMMING[0] <= fast <= SWIMMING[1]:
            slip = _slip(max(speeds), "m/s", (SWIMMING[0] * robot.body.length, SWIMMING[1] * robot.body.length))
            yield f"{key} is up to {fast:.3g} lengths per second; fish swim at 0.5 to 10: {slip}."


def _coarse_sensors(robot: Robot) -> Iterator[str]:
    """Find sensors whose readings repeat while they work: equal readings are how a stuck one is recognized."""
    effects = {
        "depth": "a stuck one is recognized only on the way up or down",
        "field": "a stuck one is recognized only by a reading out of range",
        "position": None,  # a receiver tells its own errors
    }
    for k, sensor in enumerate(robot.sensors):
        effect = effects.get(sensor.quantity or "position", "the controller may take a working one for a stuck one")
        if sensor.hidden_change and effect:
            yield (
                f"sensors[{k}].resolution of the {sensor.quantity} sensor is {sensor.resolution:g}, with a noise of "
                f"{sensor.noise:g}: its readings repeat, and {effect}: "
                "choose a sensor with finer steps, or correct its noise."
            )


def _idle_factors(robot: Robot) -> Iterator[str]:
    """Find factors of values that are no estimates any more: they have no effect."""
    for key in robot.uncertainty or {}:
        if not (robot.source(key) or "estimate").startswith("estimate"):
            yield (
                f"uncertainty has a factor for {key}, whose source is no estimate, so it has no effect: remove the "
                'factor, or begin the source with "estimate".'
            )


def _plain(robot: Robot, key: str) -> str:
    """Return a key without indices and without the names of gaits and materials."""
    plain = re.sub(r"\[\d+\]", "", key)
    return re.sub(r'^(gaits|materials)\.("[^"]*"|[^.]+)\.', r"\1.", plain)


def _numbers(value: Any) -> Iterator[float]:
    """Yield the numbers of a value, a list or a list of lists."""
    if isinstance(value, list):
        for part in value:
            yield from _numbers(part)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield float(value)
