"""The first file of a new robot: the fish of description/new.py, with drives for its joints."""

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from typing import Any, Unpack

import numpy as np

from hypertuna import _core
from hypertuna.actuation.soft_joint import JointModel, joint_models
from hypertuna.actuation.tail import with_tail
from hypertuna.description.at_sea import DIVES, add_space, take_to_sea
from hypertuna.description.commented import commented
from hypertuna.description.inversion import inversion_speed
from hypertuna.description.new import Sizes, shape_of
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.actuator import HOSE, DriveUnit
from hypertuna.description.schema.body import DRIVES, Drive
from hypertuna.description.schema.control import Controller
from hypertuna.description.shape import Shape
from hypertuna.errors import InputError
from hypertuna.io.door import read_toml
from hypertuna.io.files import shipped
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.swim import settled_speed, swim

HEADER = """\
# {name}, written by `hypertuna robot new`.
# Every value that was not given is an estimate; [sources] has its rule. Replace values as you measure them, write
# "measured" and how into [sources], and run `hypertuna robot check`.
"""
LEAST_SHARE = 20  # % of the gait's amplitudes; smaller amplitudes hardly move a robot
FASTER = 2.0  # highest frequency of a command over the highest frequency of the gait bounds
STALLED = 1.2  # range of a current sensor over the current of a stalled servo
RESERVE = 3.0  # stall torque over the largest torque of the beat: a usual rule for lasting loads
SERVO_V, SERVO_SPEED = 7.4, 7.5  # V and rad/s of servos, from data sheets
PRESSURE = 250e3  # Pa, pressure limit: HyperTuna's joints were tested up to it
LEVER = 0.6  # lever of a tendon over the half width of the body
LEAST, BEND = math.radians(0.2), math.radians(90.0)  # smallest and largest bend of a joint group with muscles
STROKE = 0.6  # travel of the piston for the largest commanded bend, over the crank
AIR = 0.01  # volume of air bubbles over the oil's volume
REACH = 1.2  # largest bend that control may command over the bend at the pressure limit
CELL = {"voltage_v": 3.7, "charged_v": 4.2}  # voltages of a lithium polymer cell
LOW_V = 3.4  # voltage of such a cell at which a status warns
CHARGE, STRING = 15.0, 5.0  # energy of the battery per mass of robot [W h/kg], as HyperTuna's; largest string [A h]
SENSORS = ("rate", "acceleration", "current", "voltage", "depth")  # sensors of all robots
OF_OIL = ("bend", "pressure")  # further sensors of robots with oil
AS_HYPERTUNA = "estimate: as HyperTuna's, see robots/hypertuna.toml"


def first_robot(
    name: str,
    *,
    joints: Sequence[str] = (),
    actuation: str = "none",
    sea: bool = False,
    tail: str = "driven",
    **sizes: Unpack[Sizes],
) -> str:
    """Return the text of a new robot's file, complete enough to swim; sizes as in `new_robot`, tail as in `with_tail`.

    `actuation` is "none" or a key of `MADE`; `sea` adds the tables that dives, missions and the firmware need.
    """
    drive = DRIVES.get(actuation)
    if sea and drive is None:
        raise InputError("needs an actuation", key="--sea", fix="add --actuation servo or --actuation hydraulic")
    document, (shape, _) = with_tail(name, tail, joints=joints, **sizes), shape_of(**sizes)
    if drive is not None:
        _add_control(document, drive)
        MADE[actuation](document, shape)
    if sea:
        tuna = read_toml(shipped("robots") / "hypertuna.toml")
        add_space(document, tuna, shape)
        speed = _slow_cruise(document)
        if not speed > 0:
            key, rule = (
                "--lengths" if sizes.get("lengths") else "--links",
                "must make a fish that swims head first with --sea",
            )
            fix = "give a longer head, or more joints"
            raise InputError(rule, key=key, value=f"one at {speed:.2g} m/s", fix=fix)
        take_to_sea(document, tuna, shape, speed)
        robot = parse(document)
        slow, cruise = (settled_speed(robot, named_gait(robot, name)) for name in document["guidance"]["gaits"])
        if not slow < cruise:  # true of some fish of a few grams
            document["guidance"]["gaits"] = ["cruise"]
    parse(document, file=f"{name}.toml")
    return HEADER.format(name=name) + commented(document, Robot)


def _slow_cruise(document: dict[str, Any]) -> float:
    """Reduce the amplitudes of the cruise until the fins can make the robot dive; return its speed [m/s]."""
    gait, limit = document["gaits"]["cruise"], DIVES * inversion_speed(parse(document))
    full_amplitude = gait["amplitude_deg"]
    if (torque := "joints.servo.torque_n_m") in document["sources"]:
        document["sources"][torque] += " without --sea"

    def speed(percent: int) -> float:
        gait["amplitude_deg"] = [round(percent * a / 100, 1) for a in full_amplitude]
        robot = parse(document)
        return swim(robot, named_gait(robot, "cruise")).speed

    return speed(LEAST_SHARE + bisect_right(range(LEAST_SHARE + 1, 101), limit, key=speed))


def _add_control(document: dict[str, Any], drive: Drive) -> None:
    """Add HyperTuna's battery, sensors and controller to a document, and limits of the joints."""
    sensors = SENSORS + OF_OIL * drive.oil
    tuna = read_toml(shipped("robots") / "hypertuna.toml")
    for group, (_, largest) in zip(document["joints"], document["gait_bounds"]["amplitude_deg"], strict=True):
        group |= {"amplitude_max_deg": largest, "bend_max_deg": largest}
    document["battery"] = tuna["battery"]
    document["sensors"] = [sensor for sensor in tuna["sensors"] if sensor["quantity"] in sensors]
    hertz_max = min(FASTER * document["gait_bounds"]["frequency_hz"][1], tuna["controller"]["frequency_max_hz"])
    document["controller"] = tuna["controller"] | {"frequency_max_hz": float(f"{hertz_max:.2g}")}
    document["sources"] |= dict.fromkeys(("battery", "sensors", "controller"), AS_HYPERTUNA)
    document["sources"] |= {
        "joints.amplitude_max_deg": "estimate: 1.5 times the amplitude of the gait",
        "joints.bend_max_deg": "estimate: as the largest amplitude",
        "controller.frequency_max_hz": f"estimate: {FASTER:g} times the highest of gait_bounds, at most HyperTuna's",
    }


def _current_sensor(document: dict[str, Any], stall: float) -> None:
    """Widen the range of the current sensor, if necessary, so that it covers the current of a stalled servo [A]."""
    sensor = next(sensor for sensor in document["sensors"] if sensor["quantity"] == "current")
    if (ratio := float(f"{STALLED * stall / sensor['high']:.2g}")) > 1:
        scaled = {key: ratio * sensor[key] for key in ("low", "high", "noise", "resolution", "bias")}
        document["sensors"][document["sensors"].index(sensor)] = sensor | scaled | {"part": "of this range"}


def _add_tendons(document: dict[str, Any], shape: Shape) -> None:
    """Add tendons beside the spine, whose drums bend all joints of a group equally, and servos that turn the drums."""
    fronts = np.cumsum([0.0, *document["links"]["length_m"]])
    for group in document["joints"]:
        levers: list[float] = []
        for link in group["links"]:
            station = min(fronts[link], 0.98 * shape.fin_start * shape.length)
            height = float(shape.sections(station, station + 1e-3 * shape.length)[1].mean())
            levers.append(float(f"{LEVER * shape.width / shape.height * height / 2:.2g}"))
        drums = [float(f"{sum(levers[: i + 1]) / len(levers):.4g}") for i in range(len(levers))]
        group["tendons"] = {"drum_m": drums, "lever_m": [levers[: i + 1] for i in range(len(levers))]}
    document["sources"]["joints.tendons"] = (
        f"estimate: each runs beside the spine, at {LEVER:g} times the half width at each joint; drums that share the "
        "bend equally, and turn as far as all joints of the group bend together"
    )
    _add_servos(document, shape)


def _add_servos(document: dict[str, Any], _: Shape) -> None:
    """Add a servo to each joint, with a battery and current sensor that suit it; remove the keys of pressure."""
    control = document["controller"]
    document["controller"] = {key: value for key, value in control.items() if not key.startswith("pressure_")}
    charge = CHARGE * document["body"]["mass_kg"] / (2 * CELL["voltage_v"])
    strings = math.ceil(charge / STRING)
    cell = CELL | {"capacity_ah": float(f"{charge / strings:.2g}")}
    cell["resistance_ohm"] = float(f"{0.04 / cell['capacity_ah']:.2g}")
    document["battery"] = {"cells": 2 * strings, "series": 2} | cell | {"usable": 0.9}
    document["controller"]["voltage_low_v"] = 2 * LOW_V
    for group, torque in zip(document["joints"], _torques(document), strict=True):
        servo = {"torque_n_m": torque, "speed_rad_s": SERVO_SPEED, "voltage_v": SERVO_V}
        group["servo"] = servo | {"idle_current_a": 0.05, "friction_n_m": float(f"{0.04 * torque:.2g}")}
        _current_sensor(document, torque * SERVO_SPEED / SERVO_V)
    document["sources"] |= {
        "battery": "estimate: two cells of lithium polymer in series, for servos of 7.4 V; data sheets: 3.7 V, 4.2 V "
        "full, 0.04 ohm A h, nine tenths of the charge usable",
        "battery.cells": f"estimate: a string of two for every {STRING:g} A h",
        "battery.capacity_ah": f"estimate: {CHARGE:g} W h per kg of robot, as HyperTuna's",
        "controller.voltage_low_v": f"estimate: {LOW_V:g} V per cell, a fifth of the charge",
        "joints.servo": "estimate: data sheets of digital servos: 0.13 to 0.15 s for 60 degrees at 7.4 V, 5 to 100 mA "
        "at rest, friction of 4 % of the stall torque",
        "joints.servo.torque_n_m": f"estimate: {RESERVE:g} times the largest torque of the gait",
    }


def _torques(document: Mapping[str, Any]) -> list[float]:
    """Return the stall torque [N m] that the servo of each joint group needs for the cruise."""
    robot = parse(document)
    beat = swim(robot, named_gait(robot, "cruise")).trajectory
    peaks = [np.abs(beat[name].to_numpy()).max(axis=0) for name in ("joint_torque", "motor_torque")]
    loads = (max(peaks[0][[*g.links]]) if g.tendons is None else peaks[1][k] for k, g in enumerate(robot.joints))
    return [float(f"{max(0.05, RESERVE * largest):.2g}") for largest in loads]


def _add_hydraulics(document: dict[str, Any], shape: Shape) -> None:
    """Add HyperTuna's muscles, pump, oil and lines, scaled to the sections, and batteries by the robot's mass."""
    tuna = read_toml(shipped("robots") / "hypertuna.toml")
    strings = math.ceil(document["body"]["mass_kg"] / tuna["body"]["mass_kg"])
    document["battery"] = tuna["battery"] | {"cells": strings * tuna["battery"]["cells"]}
    document |= {table: tuna[table] for table in ("materials", "drive_unit", "oil")}
    lengths = document["links"]["length_m"]
    bodies = [_soft_body(shape, lengths, group["links"]) for group in document["joints"]]
    bodies_of_both = (bodies, [group["actuator"] for group in tuna["joints"]])
    narrow, of_hypertuna = (min(min(body["semi_minor_m"]) for body in bodies_of) for bodies_of in bodies_of_both)
    hose = DriveUnit.scaled(tuna["drive_unit"], width=narrow / of_hypertuna)
    document["drive_unit"] |= hose
    for group, body in zip(document["joints"], bodies, strict=True):
        pairs = max(1, round(0.8 * min(body["semi_major_m"]) / (1.25 * hose["outer_diameter_m"])))
        group |= {"pressure_max_pa": PRESSURE, "drive_units": pairs, "actuator": body}
        group["line"] = _line(shape, sum(lengths[: group["links"][0]]) - lengths[0], pairs, body, hose)
    document["pump"], document["servos"] = {"bore_m": 0.02 * shape.length, "crank_m": 0.048 * shape.length}, []
    document["pump"] |= {"rod_m": 0.12 * shape.length, "neutral_deg": 90.0, "dead_volume_m3": 1e-6}
    try:
        _size_pump(document)
    except InputError:
        rule, value = "must fit the joints", "hydraulic, and the shortest joint has no room for hoses or hardly bends"
        fix = "give longer links behind the head or fewer joint groups, or take --actuation servo"
        raise InputError(rule, key="--actuation", value=value, fix=fix) from None
    control = tuna["controller"]
    document["controller"] |= Controller.scaled(control, pressure=PRESSURE / control["pressure_work_pa"])
    document["sources"] |= SOURCES | dict.fromkeys(("materials", "oil"), AS_HYPERTUNA)


# Function that adds the drives, by the value of --actuation; the keys are those of `DRIVES`.
MADE = {"servo": _add_servos, "tendons": _add_tendons, "hydraulic": _add_hydraulics}

SOURCES = {
    "joints.actuator": "estimate: elliptical sections of the fish's shape, three fifths of the links of the group, "
    "in three segments, HyperTuna's proportions, which bend as far as its joints; longer segments bend farther",
    "joints.actuator.lever_m": "estimate: 0.55 times the narrowest half width, as HyperTuna's",
    "joints.drive_units": "estimate: HyperTuna's number of pairs per height of the section over diameter of the hose",
    "joints.bend_max_deg": "estimate: bend by these muscles at the pressure limit, without load; at most 90 deg",
    "joints.amplitude_max_deg": "estimate: 0.85 times the largest bend",
    "joints.pressure_max_pa": "estimate: up to which HyperTuna's joints were tested",
    "joints.line": "estimate: from the head to the joint; bore 0.8 times the hose and losses as "
    "HyperTuna's; filled to 60 kPa, a quarter of the pressure limit",
    "joints.line.compliance_m3_pa": "estimate: hoses, braid and fittings give 8 % of their volume at the limit",
    **{f"controller.{key}": f"estimate: {scale.words}" for key, scale in Controller.scales("pressure").items()},
    "drive_unit": f"estimate: {HOSE.words}",
    "battery.cells": "estimate: HyperTuna's for every robot of its mass",
    "pump": "estimate: crank and rod by the length; 1.2 times the largest bend takes three fifths of the crank",
    "servos": f"estimate: data sheets of digital servos; stall torque {RESERVE:g} times that at the pressure limit",
    "gaits": "estimate: as without an actuator, the amplitudes at most nine tenths of the largest",
}


def _soft_body(shape: Shape, lengths: Sequence[float], links: Sequence[int]) -> dict[str, Any]:
    """Return the table of a joint group's soft body: three segments at the front of the group's first link."""
    start, length = sum(lengths[: links[0]]), 0.6 * sum(lengths[i] for i in links)
    segment = float(f"{length / 3:.3g}")
    stations = np.minimum(start + segment * np.arange(3.0), 0.98 * shape.fin_start * shape.length)
    heights = [float(shape.sections(station, station + 1e-3 * shape.length)[1].mean()) for station in stations]
    minor = [float(f"{shape.width / shape.height * height / 2:.3g}") for height in heights]
    major = [float(f"{height / 2:.3g}") for height in heights]
    lever = float(f"{0.55 * min(minor):.3g}")
    return {"lever_m": lever, "segment_length_m": [segment] * 3, "semi_major_m": major, "semi_minor_m": minor}


def _line(
    shape: Shape, behind_head: float, pairs: int, body: Mapping[str, Any], hose: Mapping[str, float]
) -> dict[str, float]:
    """Return the table of a joint's oil line; `behind_head` [m] is the distance from the head to the joint."""
    length, bore = 0.15 * shape.length + behind_head, 0.8 * hose["outer_diameter_m"]
    units = pairs * hose["inner_diameter_m"] ** 2 * sum(body["segment_length_m"])
    volume = math.pi / 4 * (units + bore**2 * length)
    values = {"length_m": length, "bore_m": bore, "compliance_m3_pa": 0.08 * volume / PRESSURE}
    return {key: float(f"{value:.2g}") for key, value in values.items()} | {"loss": 1.5, "fill_pressure_pa": 60e3}


def _size_pump(document: dict[str, Any]) -> None:
    """Set bends and amplitudes to the muscles' range, and the pump's bore and servos to the oil that they need."""
    pump, displaced = document["pump"], 0.0
    for j, model in enumerate(joint_models(parse(document))):
        bend = min(abs(float(model.balance([[PRESSURE, 0.0]])["angle"][0])), 0.9 * model.reach, BEND)
        if not bend >= LEAST:  # also true if it is NaN
            raise InputError("must bend")
        group, gait = document["joints"][j], document["gaits"]["cruise"]
        group["bend_max_deg"] = math.floor(10 * math.degrees(bend)) / 10
        group["amplitude_max_deg"] = math.floor(8.5 * math.degrees(bend)) / 10
        gait["amplitude_deg"][j] = min(gait["amplitude_deg"][j], round(0.9 * group["amplitude_max_deg"], 1))
        document["gait_bounds"]["amplitude_deg"][j] = [0.0, group["amplitude_max_deg"]]
        displaced = max(displaced, _displaced(group["line"]["compliance_m3_pa"], model, REACH * bend))
    area = displaced / (STROKE * pump["crank_m"])
    pump["bore_m"] = math.sqrt(4 * area / math.pi)
    pump["dead_volume_m3"] = 0.1 * displaced
    document["pump"] = {key: float(f"{value:.2g}") for key, value in pump.items()}
    torque = float(f"{RESERVE * PRESSURE * area * pump['crank_m']:.2g}")
    servo = {"drives": "piston pump", "count": 2 * len(document["joints"]), "torque_n_m": torque}
    servo |= {"speed_rad_s": SERVO_SPEED, "voltage_v": SERVO_V, "stall_current_a": torque * SERVO_SPEED / SERVO_V}
    servo |= {"idle_current_a": 0.05, "friction_n_m": 0.04 * torque, "inertia_kg_m2": 0.005 * torque / SERVO_SPEED}
    rounded = {key: float(f"{value:.2g}") if isinstance(value, float) else value for key, value in servo.items()}
    document["servos"] = [rounded | {"bandwidth_hz": 10.0}]
    _current_sensor(document, torque * SERVO_SPEED / SERVO_V)


def _displaced(compliance: float, model: JointModel, bend: float) -> float:
    """Return the oil [m^3] that a cylinder displaces to bend a joint, with compliance and air bubbles."""
    state = model.hold([-bend, bend])
    straight = model.at(0.0)["volume"]
    pressure = np.minimum(state["pressure"], PRESSURE)
    swelling = compliance + AIR * straight / _core.ATMOSPHERE
    return float(np.abs(state["volume"] - straight + swelling * (pressure - model.fill)).max())
