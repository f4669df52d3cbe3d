"""Warnings on unlikely values of a robot, such as slips of units and of powers of ten."""

import math
from collections.abc import Iterator
from typing import Any

from hypertuna.description.provenance import is_estimate
from hypertuna.description.robot import Robot
from hypertuna.description.schema.body import AROUND
from hypertuna.description.validation import declared, plain

SLIPS: dict[str, dict[str, float]] = {  # by unit: other units that may have been used, each in this unit
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
# Likely ranges and limits.
WIDE = 0.6  # width over height assumed for a section whose width is unknown
DENSITY = (5.0, 10e3)  # kg/m^3, mass of a link over an elliptical volume: from a thin fin to lead
SLENDER = (0.004, 1.0)  # height of a link over the length of the body
FRICTION = (0.1, 12.0)  # wetted over lateral area
HEAVY = 1.3  # largest mass of the whole robot over the mass of its links
HIGH = 0.7  # largest height of fins and sections over the length of the robot
LOW = 0.01  # smallest height of the trailing edge over the length of the robot
BLUNT = (1e-6, 0.5)  # drag area over the square of the length
FRONT = 0.1  # smallest distance of a center of mass from a link's front end, over the link's length
BULK = (0.3, 400.0)  # kg/m^3, mass over length cubed
SWIMMING = (0.01, 20.0)  # speed in body lengths per second


def implausible(robot: Robot) -> list[str]:
    """Return a sentence for each unlikely value of a robot."""
    if (slip := _unit_of_lengths(robot)) is not None:
        return [slip, *(text for text in _unusual(robot) if "s.length_m" not in text)]  # comparisons would repeat it
    unlikely = (_unlikely_links, _unlikely_sizes, _unlikely_speeds, _coarse_sensors, _idle_factors)
    return [*_unusual(robot), *(sentence for check in unlikely for sentence in check(robot))]


def _unit_of_lengths(robot: Robot) -> str | None:
    """Return a sentence on links that are too long for the robot's mass, if another unit of length explains this."""
    total, mass = math.fsum(robot.links.length), robot.body.mass
    for unit, factor in SLIPS["m"].items() if mass / total**3 < BULK[0] else ():
        if BULK[0] <= mass / (factor * total) ** 3 <= BULK[1]:
            lengths = ", ".join(f"{factor * length:.6g}" for length in robot.links.length)
            return (
                f"links.length_m adds up to {total:g} m, in a robot of {mass:g} kg: is it in {unit}? "
                f"Then write [{lengths}]."
            )
    return None


def _unusual(robot: Robot) -> Iterator[str]:
    """Yield a sentence for each value outside its usual range."""
    keys = declared(Robot)
    for entry in robot.entries():
        usual = keys[plain(entry.key)].usual
        if usual is None or entry.default:
            continue
        numbers = [*_numbers(entry.value)]
        unlikely = [x for x in numbers if not usual[0] <= x <= usual[1] and x != 0]
        if entry.key.endswith("amplitude_deg") and max(numbers, default=0.0) >= usual[0]:
            unlikely = []  # some joints may stay straight
        if unlikely:
            worst = max(unlikely, key=abs)
            limits = f"usual are {usual[0]:g} to {usual[1]:g}"
            yield f"{entry.key} has {worst:g} {entry.unit}".rstrip() + f"; {limits}: {_slip(worst, entry.unit, usual)}."


def _slip(value: float, unit: str, usual: tuple[float, float]) -> str:
    """Return a hint for an unusual value [unit of the file]: a unit in which it is usual, else to check the unit."""
    for other, factor in SLIPS.get(unit, {}).items():
        if usual[0] <= value * factor <= usual[1]:
            return f"is it in {other}? Then write {value * factor:.6g}"
    return "check the unit and the power of ten"


def _unlikely_links(robot: Robot) -> Iterator[str]:
    """Yield sentences on masses, lengths and areas of links that do not fit each other."""
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
            volume_source = "its volume" if volume else f"an ellipse {WIDE:g} times as wide as high"
            slip = _slip(mass, "kg", (mass * DENSITY[0] / density, mass * DENSITY[1] / density))
            yield f"links.mass_kg[{i}] gives link {links.name[i]} {density:.3g} kg/m^3, by {volume_source}: {slip}."


def _unlikely_sizes(robot: Robot) -> Iterator[str]:
    """Yield sentences on fins and sections that do not fit the robot's length."""
    length, fins, strip, spatial = robot.body.length, robot.fins, robot.water.strip, robot.spatial
    sizes = {
        "body.height_m": robot.body.height or 0.0,
        "fins.span_m": fins.span if fins else 0.0,
        "fins.chord_m": fins.chord if fins else 0.0,
        "water.strip.edge_height_m": strip.edge_height if strip else 0.0,
        "spatial.height_m": max(spatial.height) if spatial else 0.0,
        "spatial.width_m": max(spatial.width) if spatial else 0.0,
    }
    for key, size in sizes.items():
        if size > HIGH * length or (0 < size < LOW * length and key.startswith("water")):
            slip = _slip(size, "m", (0.05 * length, HIGH * length))
            yield f"{key} has {size:g} m, in a robot {length:g} m long: {slip}."
    area = max(strip.blunt_area) if strip else 0.0
    if area and not BLUNT[0] <= area / length**2 <= BLUNT[1]:
        slip = _slip(area, "m^2", (BLUNT[0] * length**2, BLUNT[1] * length**2))
        yield f"water.strip.blunt_area_m2 has {area:g} m^2, in a robot {length:g} m long: {slip}."


def _unlikely_speeds(robot: Robot) -> Iterator[str]:
    """Yield sentences on speeds that are unusual in body lengths per second."""
    speeds_by_key = {"guidance.speed_m_s": (robot.guidance and robot.guidance.speed) or ()}
    speeds_by_key["fit.speed_m_s"] = (robot.fit and robot.fit.speed) or ()
    for key, speeds in speeds_by_key.items():
        fastest = max(speeds, default=0.0) / robot.body.length
        if fastest and not SWIMMING[0] <= fastest <= SWIMMING[1]:
            slip = _slip(max(speeds), "m/s", (SWIMMING[0] * robot.body.length, SWIMMING[1] * robot.body.length))
            yield f"{key} is up to {fastest:.3g} lengths per second; fish swim at 0.5 to 10: {slip}."


def _coarse_sensors(robot: Robot) -> Iterator[str]:
    """Yield sentences on sensors with so coarse a resolution that a working sensor repeats readings and looks stuck."""
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
    """Yield sentences on factors of ``[uncertainty]`` that have no effect, since their values are no estimates."""
    for key in robot.uncertainty or {}:
        if not is_estimate(robot, key):
            yield (
                f"uncertainty has a factor for {key}, whose source is no estimate, so it has no effect: remove the "
                'factor, or begin the source with "estimate".'
            )


def _numbers(value: Any) -> Iterator[float]:
    """Yield the numbers of a value, which may be a list or a list of lists."""
    if isinstance(value, list):
        for part in value:
            yield from _numbers(part)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield float(value)
