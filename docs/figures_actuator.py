"""Tables and picture of docs/actuator.md; docs/figures.py takes them in."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from figures_common import rows
from matplotlib.figure import Figure
from scipy.optimize import brentq

from hypertuna import _core
from hypertuna.actuation.bending import LAWS, bend, misprints
from hypertuna.actuation.plots import plot_bend
from hypertuna.actuation.soft_joint import (
    MATERIAL_SETS,
    JointTable,
    joint_group,
    joint_tables,
    mooney,
    muscle,
    soft_joint,
)
from hypertuna.description.robot import Robot, load, parse

FISH = load("hypertuna")
JOINTS = tuple(group.name for group in FISH.joints)
TOP = 250e3  # Pa
PRESSURE = np.linspace(0, TOP, 26)


def varied(unit: dict[str, Any] | None = None, joint: int = 0, actuator: dict[str, Any] | None = None) -> Robot:
    """Return HyperTuna with other keys in its muscle and in the actuator of one joint."""
    document = FISH.document() | {"sources": {}}
    document["drive_unit"] |= unit or {}
    document["joints"][joint]["actuator"] |= actuator or {}
    return parse(document)


def degrees(robot: Robot, joint: str | int, pressure: float = TOP, **options: Any) -> float:
    """Return the angle of a joint, in degrees."""
    return math.degrees(bend(robot, joint, [pressure], **options).angle[0])


def correction_table() -> str:
    """Tabulate what every correction of the paper's equations does at 250 kPa."""
    found = {joint: misprints(FISH, joint, TOP) for joint in JOINTS}
    body = []
    for k, step in enumerate(found[JOINTS[0]]):
        cells = []
        for steps in found.values():
            now = math.degrees(steps[k].angle)
            cells += [f"{now:.2f}", f"{now - math.degrees(steps[k - 1].angle):+.2f}" if k else ""]
        body.append([step.text, *cells])
    return rows(["equations", *(f"{text} [deg]" for joint in JOINTS for text in (joint, "change"))], body)


def hysteresis_table() -> str:
    """Tabulate both branches, and what is between them."""
    fine = np.linspace(0, TOP, 1001)
    body = []
    for joint in JOINTS:
        loop = bend(FISH, joint, fine, unload=True)
        assert loop.unload_angle is not None
        back = loop.unload_angle[::-1]
        stuck = fine[np.flatnonzero(back < back[-1])[-1] + 1] / 1e3
        width = np.degrees(np.max(back - loop.angle))
        at = [np.interp(1e5, fine, np.degrees(angle)) for angle in (loop.angle, back)]
        cells = (*(f"{angle:.2f}" for angle in at), f"{np.degrees(loop.angle[-1]):.2f}", f"{width:.2f}")
        body.append([joint, *cells, f"{stuck:.0f}", f"{1e3 * loop.loss:.0f}"])
    head = ["joint", "100 kPa, up [deg]", "down [deg]", "250 kPa [deg]", "largest width [deg]", "sticks down to [kPa]"]
    return rows([*head, "loss [mJ]"], body)


def material_table() -> str:
    """Tabulate what the three material sets imply."""
    assert FISH.drive_unit is not None
    body = []
    for name in MATERIAL_SETS:
        moduli = [
            mooney(FISH, silicone, name).modulus / 1e3 for silicone in (FISH.drive_unit.hose, FISH.drive_unit.matrix)
        ]
        cells = [f"{modulus:.0f}" for modulus in moduli]
        for joint in JOINTS:
            found = bend(FISH, joint, PRESSURE, material=name)
            cells += [f"{math.degrees(found.angle[-1]):.1f}", f"{found.r_squared():.3f}"]
        body.append([f"`{name}`", *cells])
    heads = [text for joint in JOINTS for text in (f"{joint} at 250 kPa [deg]", "R²")]
    return rows(["set", "E of hose [kPa]", "E of matrix [kPa]", *heads], body)


FAMILY: tuple[dict[str, Any], ...] = (
    {},
    {"braid_angle_deg": 37.0},
    {"braid_angle_deg": 36.0, "friction": 0.0},
    {"inner_diameter_m": 6e-3},
    {"outer_diameter_m": 9e-3, "inner_diameter_m": 6.3e-3, "braid_angle_deg": 39.0},
    {"outer_diameter_m": 7.5e-3, "inner_diameter_m": 5.5e-3, "braid_angle_deg": 37.0},
)


def fitted(unit: dict[str, Any], joint: int) -> Robot:
    """Choose the lever with which a joint with another muscle bends as far as published; the longer one of two."""
    group, actuator = joint_group(FISH, joint)
    assert group.bend_max is not None
    wanted = math.degrees(group.bend_max)

    def excess(lever: float) -> float:
        return degrees(varied(unit, joint, {"lever_m": lever}), joint) - wanted

    levers = actuator.lever * np.linspace(1.6, 0.7, 19)
    signs = [excess(lever) > 0 for lever in levers]
    k = signs.index(True)
    return varied(unit, joint, {"lever_m": float(brentq(excess, levers[k - 1], levers[k], xtol=1e-9))})


def family_table() -> str:
    """Tabulate other muscles that bend both joints as far as published."""
    body = []
    for unit in FAMILY:
        robots = [fitted(unit, joint) for joint in range(len(JOINTS))]
        shape = robots[0].drive_unit
        assert shape is not None
        hose = f"{1e3 * shape.outer_diameter:g} × {1e3 * shape.inner_diameter:g}"
        levers, half, gain = [], [], []
        for joint, robot in enumerate(robots):
            levers.append(f"{1e3 * joint_group(robot, joint)[1].lever:.1f}")
            half.append(f"{degrees(robot, joint, 1e5):.1f}")
            gain.append(f"{1e6 * joint_tables(robot)[joint].at([0.0])['slope'][0, 0]:.2f}")
        blocked = muscle(robots[0]).at(np.ones(1), pressure=TOP)["pull"][0]
        cells = (f"{math.degrees(shape.braid_angle):g}", f"{shape.friction:g}", ", ".join(levers), ", ".join(half))
        body.append([hose, *cells, f"{blocked:.1f}", ", ".join(gain)])
    head = [
        "hose [mm]",
        "braid [deg]",
        "friction",
        "levers [mm]",
        "at 100 kPa [deg]",
        "blocked force [N]",
        "dV/dα [mL/rad]",
    ]
    return rows(head, body)


SENSITIVE: tuple[tuple[str, tuple[str | int, ...]], ...] = (
    ("lever", ("joints", -1, "actuator", "lever_m")),
    ("braid angle", ("drive_unit", "braid_angle_deg")),
    ("outer diameter", ("drive_unit", "outer_diameter_m")),
    ("inner diameter", ("drive_unit", "inner_diameter_m")),
    ("friction", ("drive_unit", "friction")),
    ("modulus of the hose", ("materials", "DR10", "modulus_100_pa")),
    ("modulus of the matrix", ("materials", "EC50", "modulus_100_pa")),
)


def sensitivity_table() -> str:
    """Tabulate by how many percent the bend changes where a value changes by one."""
    body = []
    for text, keys in SENSITIVE:
        cells = []
        for joint in range(len(JOINTS)):
            angles = []
            for factor in (0.99, 1.01):
                document = FISH.document()
                place: Any = document
                for key in keys[:-1]:
                    place = place[joint if key == -1 else key]
                place[keys[-1]] *= factor
                angles.append(degrees(parse(document), joint))
            cells.append(f"{50 * (angles[1] - angles[0]) / degrees(FISH, joint):+.2f}")
        body.append([text, *cells])
    return rows(["1 % more", *(f"{joint} [%]" for joint in JOINTS)], body)


def balance(load: Callable[[float], tuple[float, Any]], pressures: tuple[float, float], reach: float) -> float:
    """Find the angle where the moment of a table vanishes, in degrees."""

    def moment(angle: float) -> float:
        elastic, slope = load(angle)
        return float(elastic + slope @ pressures)

    return math.degrees(brentq(moment, -reach, reach, xtol=1e-14))


def of_table(table: JointTable) -> Callable[[float], tuple[float, Any]]:
    """Look up elastic moment and volume slopes of a table."""

    def load_at(angle: float) -> tuple[float, Any]:
        found = table.at([angle])
        return float(found["elastic"][0]), found["slope"][0]

    return load_at


@cache
def fixed_shares(joint: str) -> Callable[[float], tuple[float, Any]]:
    """Make the joint whose segments share the angle by the matrix' compliance S / (E I) alone, whatever the load."""
    group, actuator = joint_group(FISH, joint)
    inertia = np.pi / 4 * np.array(actuator.semi_major) * np.array(actuator.semi_minor) ** 3
    assert FISH.drive_unit is not None
    stiffness = mooney(FISH, FISH.drive_unit.matrix).modulus * inertia
    lengths = np.array(actuator.segment_length)
    shares = lengths / stiffness / (lengths / stiffness).sum()
    loads = []
    for length, bending in zip(lengths, stiffness, strict=True):
        sides = (actuator.lever, actuator.lever)
        options = {"units": group.drive_units, "lever": sides, "length": [length], "stiffness": [bending]}
        one = _core.SoftJoint(muscle(FISH), **options)
        reach = one.reach(0, left=0.02, highest=2e7)
        loads.append(of_table(JointTable("", -reach, reach / 128, one.table(reach=reach, points=257), 0.0, 1e3)))

    def load_at(angle: float) -> tuple[float, Any]:
        parts = [segment(share * angle) for segment, share in zip(loads, shares, strict=True)]
        elastic = sum(share * part[0] for share, part in zip(shares, parts, strict=True))
        return float(elastic), sum(share * part[1] for share, part in zip(shares, parts, strict=True))

    return load_at


def share_table() -> str:
    """Tabulate how far one angle per joint is from a bend of each segment for itself, without friction."""
    body = []
    for joint, table in zip(JOINTS, joint_tables(FISH), strict=True):
        model = soft_joint(FISH, joint, friction=False)
        for left, right in ((1e5, 0.0), (TOP, 0.0), (TOP, 60e3), (TOP, 1e5)):
            exact = math.degrees(float(model.bend(np.array([[left, right]])).sum()))
            ours = balance(of_table(table), (left, right), table.angle[-1])
            fixed = balance(fixed_shares(joint), (left, right), table.angle[-1])
            cells = (
                f"{left / 1e3:g}",
                f"{right / 1e3:g}",
                f"{exact:.2f}",
                f"{round(ours - exact, 3) + 0.0:+.3f}",
                f"{fixed - exact:+.2f}",
            )
            body.append([joint, *cells])
    head = ["joint", "left [kPa]", "right [kPa]", "segments [deg]", "table [deg]", "shares by S/(E I) [deg]"]
    return rows(head, body)


def segment_table() -> str:
    """Tabulate the bend over the number of segments that the section, taken as linear along the joint, is cut into."""
    body = []
    for count in (1, 2, 3, 6, 12, 24):
        cells = []
        for joint in range(len(JOINTS)):
            _, actuator = joint_group(FISH, joint)
            known = len(actuator.segment_length)
            middle, places = (np.arange(known) + 0.5) / known, (np.arange(count) + 0.5) / count
            axes = {
                f"{name}_m": np.polyval(np.polyfit(middle, getattr(actuator, name), 1), places).tolist()
                for name in ("semi_major", "semi_minor")
            }
            lengths = [sum(actuator.segment_length) / count] * count
            cells.append(f"{degrees(varied(None, joint, axes | {'segment_length_m': lengths}), joint):.2f}")
        body.append([str(count), *cells])
    return rows(["segments", *(f"{joint} [deg]" for joint in JOINTS)], body)


def earlier_table() -> str:
    """Tabulate an estimate made without the walls of the other side, with and without them."""
    unit = {"outer_diameter_m": 6.24e-3, "inner_diameter_m": 4.06e-3, "braid_angle_deg": 38.0, "friction": 0.0}
    actuators = (
        {"lever_m": 0.0184, "segment_length_m": [0.02] * 3},
        {"lever_m": 0.009, "segment_length_m": [0.0155] * 2},
    )
    body = []
    for joint, actuator in enumerate(actuators):
        model = soft_joint(varied(unit, joint, actuator), joint)
        cells = []
        for passive in (False, True):
            law = LAWS["corrected"] | {"passive": passive}
            angle = model.with_law(**law).bend(np.array([[TOP, 0.0]])).sum()
            cells.append(f"{math.degrees(float(angle)):.1f}")
        body.append([JOINTS[joint], *cells])
    return rows(["joint", "without the other side's walls [deg]", "with them [deg]"], body)


def draw_bend() -> Figure:
    """Draw joint I's loop."""
    sets = {name: bend(FISH, "I", PRESSURE, material=name, unload=True) for name in MATERIAL_SETS}
    return plot_bend(sets["datasheet"], sets)


TABLES: dict[str, Callable[[], str]] = {
    "corrections": correction_table,
    "hysteresis": hysteresis_table,
    "materials": material_table,
    "family": family_table,
    "sensitivity": sensitivity_table,
    "shares": share_table,
    "segments": segment_table,
    "earlier estimate": earlier_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/bend.svg": draw_bend}
