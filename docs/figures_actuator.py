"""Tables and picture of docs/actuator.md; docs/figures.py includes them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from figures_common import rows
from matplotlib.figure import Figure
from scipy.optimize import brentq

from hypertuna.actuation.bending import bend, misprints
from hypertuna.actuation.plots import plot_bend
from hypertuna.actuation.soft_joint import MATERIAL_SETS, joint_group, joint_models, joint_sections, mooney, soft_joint
from hypertuna.description.robot import Robot, load, parse

FISH = load("hypertuna")
JOINTS = tuple(group.name for group in FISH.joints)
TOP = 250e3  # largest pressure [Pa]
ELEMENTS = Path(__file__).parents[1] / "data" / "fe"  # results of finite elements
PRESSURE = np.linspace(0, TOP, 26)


def varied(unit: dict[str, Any] | None = None, joint: int = 0, actuator: dict[str, Any] | None = None) -> Robot:
    """Return HyperTuna with other keys in its muscle and in the actuator of one joint."""
    document = FISH.document() | {"sources": {}}
    document["drive_unit"] |= unit or {}
    document["joints"][joint]["actuator"] |= actuator or {}
    return parse(document)


def degrees(robot: Robot, joint: str | int, pressure: float = TOP, **options: Any) -> float:
    """Return the bend of a joint at a pressure [Pa], in degrees."""
    return math.degrees(bend(robot, joint, [pressure], **options).angle[0])


def correction_table() -> str:
    """Tabulate the bend at 250 kPa after each correction of the paper's equations."""
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
    """Tabulate both branches of the hysteresis loop, its width and its loss."""
    fine = np.linspace(0, TOP, 251)
    body = []
    for joint in JOINTS:
        loop = bend(FISH, joint, fine, unload=True)
        assert loop.unload_angle is not None
        back = loop.unload_angle[::-1]
        stuck = fine[np.flatnonzero(back < back[-1])[-1] + 1] / 1e3
        width = np.degrees(np.max(back - loop.angle))
        at = [np.interp(1e5, fine, np.degrees(angle)) for angle in (loop.angle, back)]
        cells = (*(f"{angle:.2f}" for angle in at), f"{np.degrees(loop.angle[-1]):.2f}", f"{width:.2f}")
        body.append([joint, *cells, f"{stuck:.0f}", f"{1e3 * loop.friction_loss:.0f}"])
    head = ["joint", "100 kPa, up [deg]", "down [deg]", "250 kPa [deg]", "largest width [deg]", "sticks down to [kPa]"]
    return rows([*head, "loss [mJ]"], body)


def material_table() -> str:
    """Tabulate the moduli and the bends of the three material sets."""
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


# Other muscles: keys of the drive unit that differ.
FAMILY: tuple[dict[str, Any], ...] = (
    {},
    {"friction": 0.0},
    {"braid_angle_deg": 30.0},
    {"braid_angle_deg": 28.0},
    {"outer_diameter_m": 3.5e-3, "inner_diameter_m": 2.5e-3, "braid_angle_deg": 28.0},
    {"outer_diameter_m": 5e-3, "inner_diameter_m": 3.6e-3, "braid_angle_deg": 33.0},
    {"outer_diameter_m": 6e-3, "inner_diameter_m": 4.4e-3, "braid_angle_deg": 33.0},
)


def fitted(unit: dict[str, Any], joint: int) -> tuple[Robot, bool]:
    """Return a robot with the shortest lever that gives the published bend, and True; else the nearest, and False."""
    group, actuator = joint_group(FISH, joint)
    assert group.bend_max is not None
    wanted = math.degrees(group.bend_max)

    def excess(lever: float) -> float:
        return degrees(varied(unit, joint, {"lever_m": lever}), joint) - wanted

    levers = actuator.lever * np.linspace(0.5, 1.7, 13)
    found = [excess(lever) for lever in levers]
    if max(found) < 0:
        return varied(unit, joint, {"lever_m": float(levers[np.argmax(found)])}), False
    k = next(k for k, value in enumerate(found) if value > 0)
    return varied(unit, joint, {"lever_m": float(brentq(excess, levers[k - 1], levers[k], xtol=1e-7))}), True


def family_table() -> str:
    """Tabulate muscles with the levers that bend both joints as far as published, or else as far as they can."""
    body = []
    for unit in FAMILY:
        chosen = [fitted(unit, joint) for joint in range(len(JOINTS))]
        shape = chosen[0][0].drive_unit
        assert shape is not None
        hose = f"{1e3 * shape.outer_diameter:g} × {1e3 * shape.inner_diameter:g}"
        levers, half, whole, shorter = [], [], [], []
        for joint, (robot, meets) in enumerate(chosen):
            found = bend(robot, joint, [1e5, TOP])
            actuator = joint_group(robot, joint)[1]
            levers.append(f"{1e3 * actuator.lever:.1f}")
            half.append(f"{math.degrees(found.angle[0]):.1f}")
            whole.append(f"{math.degrees(found.angle[1]):.1f}" + ("" if meets else " at most"))
            shorter.append(f"{1e3 * found.shortening[1] * actuator.length:.1f}")
        cells = (f"{math.degrees(shape.braid_angle):g}", f"{shape.friction:g}")
        body.append([hose, *cells, *(", ".join(cell) for cell in (levers, half, whole, shorter))])
    head = ["hose [mm]", "braid [deg]", "friction", "levers [mm]"]
    return rows([*head, "at 100 kPa [deg]", "at 250 kPa [deg]", "shorter by [mm]"], body)


SENSITIVE: dict[str, tuple[tuple[str | int, ...], ...]] = {  # name -> keys in the robot's file, -1 for the joint
    "lever": (("joints", -1, "actuator", "lever_m"),),
    "braid angle": (("drive_unit", "braid_angle_deg"),),
    "outer diameter": (("drive_unit", "outer_diameter_m"),),
    "inner diameter": (("drive_unit", "inner_diameter_m"),),
    "friction": (("drive_unit", "friction"),),
    "buckling load of the axis": (("joints", -1, "actuator", "axis_buckling_n"),),
    "modulus of the hose": (("materials", "DR10", "modulus_100_pa"), ("materials", "DR10", "tensile_pa", 0)),
    "modulus of the matrix": (("materials", "EC50", "modulus_100_pa"), ("materials", "EC50", "tensile_pa", 0)),
}


def multiplied(places: tuple[tuple[str | int, ...], ...], joint: int, factor: float) -> Robot:
    """Return HyperTuna with numbers of its file multiplied."""
    document = FISH.document()
    for keys in places:
        table: Any = document
        for key in keys[:-1]:
            table = table[joint if key == -1 else key]
        table[keys[-1]] *= factor
    return parse(document)


def sensitivity_table() -> str:
    """Tabulate by how many percent the bend changes per percent of each value."""
    body = []
    for text, places in SENSITIVE.items():
        cells = []
        for joint in range(len(JOINTS)):
            low, high = (degrees(multiplied(places, joint, factor), joint) for factor in (0.99, 1.01))
            cells.append(f"{50 * (high - low) / degrees(FISH, joint):+.2f}")
        body.append([text, *cells])
    return rows(["1 % more", *(f"{joint} [%]" for joint in JOINTS)], body)


def section_table() -> str:
    """Tabulate the bend of the twin, with one mean section, beside that of all sections, without friction."""
    body = []
    for joint, model in zip(JOINTS, joint_models(FISH), strict=True):
        sections, length = soft_joint(FISH, joint, friction=False), joint_group(FISH, joint)[1].length
        for left, right in ((5e4, 0.0), (1e5, 0.0), (TOP, 0.0), (TOP, 60e3), (TOP, 1e5)):
            bent = np.asarray(sections.bend(np.array([[left, right]])))[0]
            found = model.balance([left, right])
            soft = joint_sections(FISH, joint)[:, 0]
            ours = math.degrees(float(found["angle"][0]))
            exact = math.degrees(float(bent[:, 0].sum()))
            shorter = -1e3 * float(bent[:, 1] @ soft), -1e3 * float(found["strain"][0] + model["rest"]) * soft.sum()
            cells = (f"{left / 1e3:g}", f"{right / 1e3:g}", f"{exact:.2f}", f"{ours:.2f}")
            body.append([joint, *cells, *(f"{value:.2f}" for value in shorter)])
            assert max(shorter) < 1e3 * length
    head = ["joint", "left [kPa]", "right [kPa]", "sections [deg]", "one section [deg]"]
    return rows([*head, "sections, shorter [mm]", "one section, shorter [mm]"], body)


def element_table() -> str:
    """Tabulate bend and oil beside the stored finite elements of the same joints, without friction."""
    body = []
    for joint in JOINTS:
        run = json.loads((ELEMENTS / f"hypertuna-{joint}.json").read_text())
        for step in run["steps"][1:]:
            found = bend(FISH, joint, [1e3 * step["pressure_kpa"]], friction=False)
            ours = math.degrees(found.angle[0]), 1e6 * found.volume[0]
            cells = [f"{step['pressure_kpa']:g}"]
            for value, theirs in zip(ours, (step["bend_deg"], step["oil_taken_ml"]), strict=True):
                cells += [f"{theirs:.2f}", f"{value:.2f}", f"{100 * (value / theirs - 1):+.1f} %"]
            body.append([joint, *cells])
    head = ["joint", "pressure [kPa]"]
    for text in ("bend [deg]", "oil [mL]"):
        head += [f"elements: {text}", f"sections: {text}", "difference"]
    return rows(head, body)


def segment_table() -> str:
    """Tabulate the bend over the number of segments of a joint whose section varies linearly along it."""
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


def draw_bend() -> Figure:
    """Draw the hysteresis loop of joint I."""
    sets = {str(name): bend(FISH, "I", PRESSURE, material=name, unload=True) for name in MATERIAL_SETS}
    return plot_bend(sets["fe"], sets)


TABLES: dict[str, Callable[[], str]] = {
    "corrections": correction_table,
    "hysteresis": hysteresis_table,
    "materials": material_table,
    "family": family_table,
    "sensitivity": sensitivity_table,
    "one section": section_table,
    "elements": element_table,
    "segments": segment_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/bend.svg": draw_bend}
