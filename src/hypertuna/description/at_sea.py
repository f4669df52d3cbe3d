"""Estimated tables that a robot needs to dive, to fly missions and to run the firmware."""

import math
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any

from hypertuna import _core
from hypertuna.description.channels import CHANNELS
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.body import Drive
from hypertuna.description.schema.control import Guidance
from hypertuna.description.shape import DENSITY, Shape
from hypertuna.description.twin import new_command, require_groups
from hypertuna.errors import InputError

SERVO_PINS = (2, 3, 4, 5, 6, 9, 10, 11, 12, 13, 29, 33, 36, 37)  # of a Teensy 4.1; the first are HyperTuna's
ANALOG_PINS = (14, 15, 16, 17, 20, 21, 22, 23, 24, 25, 38, 39, 40, 41, 27)  # of a Teensy 4.1, in the order of use
HEEL = 2.6  # deg, roll that reveals a lost fin: full turns roll such robots less
LONE = 20.0  # deg, angle of the fins above which the roll is monitored: one fin alone then rolls them by 3 deg
ROLL = 0.6  # natural frequency of roll over the beat frequency; 0.4 to 0.6 on HyperTuna
DIVES = 0.65  # speed of the cruise over the inversion speed; 0.58 on HyperTuna at 2 Hz

SOURCES = {
    "spatial.com_height_m": f"estimate: ballast in the head, so low that roll has {ROLL:g} of the frequency of the "
    "beat: at the same frequency the robot would roll far; higher ballast would hold its pitch at low speeds only",
    "spatial.volume_m3": "estimate: each link carries itself, mass over density",
    "spatial.buoyancy_center_m": "estimate: at the centers of mass, so that the robot lies level",
    "spatial.buoyancy_height_m": "estimate: in the plane of the joints",
    "spatial.height_m": "estimate: lateral area over length",
    "spatial.width_m": "estimate: the ellipse of the link's volume",
    "spatial.drag_vertical": "estimate: Hoerner's ellipse along its longer axis, 0.015 (1 + h/b) + 1.1 b/h",
    "spatial.added_mass_vertical": "estimate: potential flow, 0.9 for the flow around the ends",
    "spatial.drag_roll": "estimate: 1.2 for the fin, which is a plate; a quarter of that for round sections",
    "spatial.shedding_vertical": "estimate: a bare hull's, as HyperTuna's",
    "fins": "estimate: three tenths of the length behind the nose, on a short head at four fifths of it; span 0.118 "
    "times the length, chord 0.8 times the span, as HyperTuna's",
    "guidance": "estimate: as HyperTuna's, see robots/hypertuna.toml",
    "gaits.cruise.amplitude_deg": "estimate: at most those without --sea, lessened in proportion until the robot swims "
    f"at {DIVES:g} of its speed of inversion, docs/spatial.md: above it, the water turns the hull against the fins",
    "gaits.slow": "estimate: half of the amplitudes of cruise, at 0.85 of its frequency, to stay above that of roll",
    "guidance.gaits": "estimate: all of them",
    "guidance.bias_max_deg": "estimate: half of the gait's amplitudes, as HyperTuna's, as far as the joints bend",
    **dict.fromkeys(
        ("guidance.fin_tilt_deg", "guidance.fin_min_deg"),
        f"estimate: between the heel of a full turn in a dive, about 2 deg, and the 3 deg by which a lone fin at "
        f"{LONE:g} deg rolls such robots",
    ),
    **{
        f"guidance.{key}": f"estimate: {scale.words}"
        for key, scale in Guidance.scales("length", "mass", "speed").items()
    },
}
BOARD = {
    "firmware": "estimate: as HyperTuna's, see robots/hypertuna.toml; pins of a Teensy 4.1 in their order",
    "firmware.voltage_empty_v": "estimate: 15/16 of controller.voltage_low_v, as HyperTuna's",
}


def require_at_sea(robot: Robot, *tables: str, pilot: bool = True) -> None:
    """Check that a robot has the named tables, and with `pilot` a pilot's sensors; the error lists what it lacks."""
    board = "firmware" in tables
    require_groups(robot, sea=True, board=board)
    absent = [f"[{table}]" for table in tables if getattr(robot, table) is None]
    sensors = {sensor.quantity for sensor in robot.sensors}
    quantities = ("rate", "acceleration", *(name for name, channel in CHANNELS.items() if channel.pilot))
    unmeasured = [name for name in quantities if pilot and name not in sensors]
    if unmeasured:
        absent.append(f"[[sensors]] for {', '.join(unmeasured)}")
    if not absent:
        return
    them, their = ("it", "its") if len(absent) == 1 else ("them", "their")
    gaits = ", [gaits]" if "[guidance]" in absent else ""
    fix = f"copy {them}{gaits} and {their} lines of [sources] from a robot of this size; "
    fix += f"`{new_command(robot, sea=True, board=board)}` writes it"
    rule = "is missing" if len(absent) == 1 else "are missing"
    raise InputError(rule, file=robot.file or None, key=", ".join(absent), fix=fix)


def antenna_of(robot: Robot) -> tuple[float, float]:
    """Return the satellite antenna's distance behind the nose and height above the axis [m].

    The antenna is at the head's center of mass, as high as the highest part of the body.
    """
    links = robot.links
    head_height = links.lateral_area[0] / links.length[0] if robot.spatial is None else robot.spatial.height[0]
    return links.com[0], float(robot.body.height or head_height) / 2


def add_space(document: dict[str, Any], tuna: Mapping[str, Any], shape: Shape) -> None:
    """Add the tables ``[spatial]`` and ``[fins]`` to a robot's document; `tuna` is HyperTuna's document."""
    if len(document["joints"]) > _core.MAX_JOINTS:
        rule = f"must be at most {_core.MAX_JOINTS} joint groups with --sea"
        fix = "name fewer groups, each of several links"
        raise InputError(rule, key="--joints", value=f"{len(document['joints'])}", fix=fix)
    document["spatial"] = _spatial(document["links"], ROLL * document["gaits"]["cruise"]["frequency_hz"])
    document["fins"] = _fins(shape, document["links"]["length_m"][0], tuna["fins"])


def take_to_sea(document: dict[str, Any], tuna: Mapping[str, Any], shape: Shape, speed: float) -> None:
    """Add a pilot to a robot with fins and a controller, and a microcontroller if it has pins for all joints.

    `tuna` is HyperTuna's document, `speed` [m/s] is that of the robot's cruise. The pilot is HyperTuna's, scaled to the
    robot's length, mass and speed.
    """
    gait, drives = document["gaits"]["cruise"], [group.drive for group in parse(document).joints]
    slow = gait | {
        "frequency_hz": 0.85 * gait["frequency_hz"],
        "amplitude_deg": [round(a / 2, 1) for a in gait["amplitude_deg"]],
    }
    document["gaits"] = {"slow": slow, "cruise": gait}
    document["servos"] = [*document.get("servos", []), *(s for s in tuna["servos"] if s["drives"] == "pectoral fins")]
    document["sensors"] += [s for s in tuna["sensors"] if s["quantity"] in ("field", "position")]
    pilot = {key: value for key, value in tuna["guidance"].items() if key != "speed_m_s"}
    pilot |= {"fin_tilt_deg": HEEL, "fin_min_deg": LONE}
    bends = [(a, group["bend_max_deg"]) for a, group in zip(gait["amplitude_deg"], document["joints"], strict=True)]
    pilot |= {"gaits": ["slow", "cruise"], "bias_max_deg": [round(min(a / 2, bend - a), 1) for a, bend in bends]}
    length, mass = shape.length / tuna["body"]["length_m"], shape.mass / tuna["body"]["mass_kg"]
    pilot |= Guidance.scaled(pilot, length=length, mass=mass, speed=speed / tuna["guidance"]["speed_m_s"][0])
    document["guidance"] = pilot
    sources = SOURCES | {"servos": "estimate: as HyperTuna's fins"}
    if len(drives) <= min(drive.on_board for drive in drives):
        document["firmware"] = tuna["firmware"] | _pins(drives)
        empty, low = tuna["firmware"]["voltage_empty_v"], tuna["controller"]["voltage_low_v"]
        document["firmware"]["voltage_empty_v"] = round(document["controller"]["voltage_low_v"] * empty / low, 1)
        sources |= BOARD
    document["sources"] |= sources | document["sources"]


def _spatial(links: Mapping[str, Any], roll: float) -> dict[str, Any]:
    """Return the table ``[spatial]`` of links with elliptical sections; the robot rolls at a frequency `roll` [Hz]."""
    volume = [mass / DENSITY for mass in links["mass_kg"]]
    columns = list(zip(volume, links["lateral_area_m2"], links["length_m"], strict=True))
    height = [area / length for _, area, length in columns]
    width = [4 * v / (math.pi * area) for v, area, _ in columns]
    table = {
        "com_height_m": [-_ballast(links, height, width, roll)] + [0.0] * (len(height) - 1),
        "volume_m3": volume,
        "buoyancy_center_m": links["com_m"],
        "buoyancy_height_m": [0.0] * len(height),
        "height_m": height,
        "width_m": width,
        "drag_vertical": [0.015 * (1 + h / b) + 1.1 * b / h for h, b in zip(height, width, strict=True)],
        "added_mass_vertical": [0.9] * len(height),
        "drag_roll": [0.3] * (len(height) - 1) + [1.2],
    }
    return {key: [float(f"{x:.4g}") for x in column] for key, column in table.items()} | {"shedding_vertical": 0.28}


def _ballast(links: Mapping[str, Any], height: Sequence[float], width: Sequence[float], roll: float) -> float:
    """Return how far the head's center of mass must be below the axis [m], so that the body rolls at `roll` [Hz]."""
    sections = list(zip(links["mass_kg"], links["length_m"], height, width, strict=True))
    inertia = sum(m * (h**2 + w**2) / 16 for m, _, h, w in sections)
    added = sum(DENSITY * math.pi / 128 * (h**2 - w**2) ** 2 * length for _, length, h, w in sections)
    stiffness = (2 * math.pi * roll) ** 2 * (inertia + added)
    return float(min(stiffness / (_core.GRAVITY * links["mass_kg"][0]), height[0] / 6))


def _fins(shape: Shape, head: float, tuna: Mapping[str, float]) -> dict[str, float]:
    """Return the table ``[fins]``: HyperTuna's, with size and place for this shape; head: its length [m]."""
    span = 0.118 * shape.length
    changed = {"x_m": min(0.3 * shape.length, 0.8 * head), "y_m": shape.width / 2 + span / 2, "z_m": 0.0}
    changed |= {"span_m": span, "chord_m": 0.8 * span}
    return {**tuna} | {key: float(f"{value:.3g}") for key, value in changed.items()}


def _pins(drives: Sequence[Drive]) -> dict[str, list[int]]:
    """Return the pins of the servos of joint groups and fins, and of the analog sensors, by key."""
    servos = sum(len(drive.servos) for drive in drives)
    pumps = sum(len(drive.servos) for drive in drives if drive.oil)
    free_pins = iter(ANALOG_PINS)
    return {
        "servo_pins": list(SERVO_PINS[: servos + 2]),
        "bend_pins": list(islice(free_pins, sum(drive.oil for drive in drives))),
        "pressure_pins": list(islice(free_pins, pumps)),
        "current_pins": list(islice(free_pins, servos)),
    }
