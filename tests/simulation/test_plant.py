"""The plant, servo to wake, against an independent one: Lagrange's equations, roots for pressures, SciPy's DOP853."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from hypertuna import Robot, _core, load
from hypertuna.actuation.hydraulics import circuits
from hypertuna.description.robot import parse
from hypertuna.simulation.plant import parts_of
from oracles import plant as oracle

TICK = 0.01
TICKS = 12
SUPPLY = 7.4


def plain() -> Robot:
    """Return HyperTuna with joints that the oracle knows: no friction in the muscles, nothing that holds the axis."""
    document = load("hypertuna").document() | {"sources": {}}
    document["drive_unit"] |= {"outer_diameter_m": 5e-3, "inner_diameter_m": 3.6e-3, "braid_angle_deg": 35.0}
    document["drive_unit"] |= {"friction": 0.0, "material_set": "fe"}
    document["pump"]["bore_m"] = 0.02
    for group, lever in zip(document["joints"], (0.01, 0.0066), strict=True):
        kept = {key: value for key, value in group["actuator"].items() if not key.startswith("axis_")}
        group["actuator"] = kept | {"lever_m": lever, "spacing_m": 0.006}
        group["line"] |= {"bore_m": 0.004, "fill_pressure_pa": 60e3}
    return parse(document)


def oracle_joint(robot: Robot, g: int) -> oracle.Joint:
    """Make the oracle's joint from the description, by the moduli of the paper's finite elements: E = 6 C1."""
    unit, group = robot.drive_unit, robot.joints[g]
    assert unit is not None
    assert group.actuator is not None
    assert group.drive_units is not None
    assert group.line is not None
    assert group.pressure_max is not None
    assert unit.material_set == "fe"
    hose, matrix = robot.materials[unit.hose], robot.materials[unit.matrix]
    assert hose.modulus_fe is not None
    assert matrix.modulus_fe is not None
    count, radius, lever = group.drive_units, unit.outer_diameter / 2, group.actuator.lever
    soft = sum(group.actuator.segment_length)
    sections = []
    for length, a, b in zip(
        group.actuator.segment_length, group.actuator.semi_major, group.actuator.semi_minor, strict=True
    ):
        area = math.pi * (a * b - 2 * count * radius**2)
        second = math.pi / 4 * (a * b**3 - 2 * count * radius**2 * (4 * lever**2 + radius**2))
        active = length * (1 - 2 * unit.outer_diameter / soft)
        sections.append(oracle.Section(active, area, second, math.sqrt(area / (2 * count * math.pi) + radius**2)))
    return oracle.Joint(
        muscle=oracle.Muscle(unit.outer_diameter, unit.inner_diameter, unit.braid_angle, hose.modulus_fe / 6),
        units=count,
        lever=lever,
        sections=sections,
        matrix=matrix.modulus_fe / 6,
        relaxation=matrix.relaxation,
        fill=group.line.fill_pressure,
        highest=group.pressure_max,
    )


@pytest.fixture(scope="module")
def joints() -> list[oracle.Joint]:
    """Make the oracle's joints, whose tables take a while, once."""
    robot = plain()
    return [oracle_joint(robot, g) for g in range(len(robot.joints))]


def oracle_robot(robot: Robot, joints: list[oracle.Joint], *, clamped: bool) -> oracle.Robot:
    """Make the oracle from the description."""
    links, water = robot.links, robot.water.lumped
    assert water is not None
    share = np.zeros((len(links.name), len(robot.joints)))
    for g, group in enumerate(robot.joints):
        share[list(group.links), g] = group.share
    oil = circuits(robot)
    rows = [dict(zip(oil.columns, row, strict=True)) for row in oil.values]
    half, mass = 0.0 if clamped else robot.water.density / 2, np.array(links.mass)
    return oracle.Robot(
        length=np.array(links.length),
        com=np.array(links.com),
        mass=mass,
        inertia=np.array(links.inertia),
        share=share,
        joints=joints,
        circuits=[oracle.Circuit(**{f.name: row[f.name] for f in fields(oracle.Circuit)}) for row in rows],
        added=0.0 * mass if clamped else mass * np.array(water.added_mass),
        friction=half * np.array(water.friction) * np.array(links.wetted_area),
        drag=half * np.array(water.drag) * np.array(links.lateral_area),
        clamped=clamped,
    )


def swinging_targets(robot: Robot) -> np.ndarray[Any, Any]:
    """Servo targets of a beat at 5 Hz that sets in: the two sides of a joint in antiphase, joint II a quarter later."""
    time = TICK * np.arange(TICKS)
    swing = 0.25 * np.minimum(1, time / 0.1)
    beat = [np.sin(2 * np.pi * 5 * time - lag) for lag in (0, np.pi, np.pi / 2, 3 * np.pi / 2)]
    return np.stack([swing * sine for sine in beat], axis=1)


@pytest.mark.parametrize("medium", ["air", "water"])
def test_plant_agrees_with_an_independent_one(medium: str, joints: list[oracle.Joint]) -> None:
    robot, twist = plain(), np.array([-0.3, 0.0, 0.0] if medium == "water" else [0.0] * 3)
    targets = swinging_targets(robot)
    plant, world = parts_of(robot, medium, None).plant, _core.World({"clamped": medium == "air"})
    at_start = np.concatenate([twist[:2], np.zeros(3), twist[2:]])
    ours = _core.simulate(plant, targets, world, twist=at_start, tick=TICK, steps=40)

    reference = oracle_robot(robot, joints, clamped=medium == "air")
    start = np.concatenate([np.zeros(5), twist, np.zeros(2 + 2 + 16)])
    supply = ours["battery_voltage"] * 0 + SUPPLY
    states, pressures = oracle.run(reference, start, targets[:-1], supply[:-1], TICK)

    bends, theirs = ours["angle"], states[:, 3:5]
    assert np.ptp(theirs, axis=0).min() > math.radians(5), "the comparison moves the joints"
    assert np.ptp(pressures) > 200e3, "and the oil"
    assert bends == pytest.approx(theirs, abs=5e-5)  # braids that go slack are kinks to both integrators
    assert ours["servo_angle"] == pytest.approx(states[:, 12::4], abs=2e-6)
    assert ours["pump_pressure"] == pytest.approx(pressures[:, :, 0], abs=100)
    assert ours["unit_pressure"] == pytest.approx(pressures[:, :, 1], abs=100)
    assert ours["heading"] == pytest.approx(states[:, 2], abs=1e-6)
    assert ours["x"] == pytest.approx(states[:, 0], abs=1e-6)


def test_wrong_columns_are_refused_with_a_sentence() -> None:
    with pytest.raises(ValueError, match=r"columns: lacks sea\.current_east"):
        _core.World({"sea.density": 1000.0})
    with pytest.raises(ValueError, match=r"gaps: shape must be \(3, 2\), but is \(3, 1\)"):
        _core.World({"gaps": [1.0, 2.0, 3.0]})
    with pytest.raises(ValueError, match="name: must be an array of doubles"):
        _core.World({"name": "text"})
    plant = parts_of(load("hypertuna"), "water", None).plant
    with pytest.raises(ValueError, match="targets: must have one column per circuit"):
        _core.simulate(plant, np.zeros((2, 3)), _core.World({}), twist=np.zeros(6), tick=TICK, steps=40)
