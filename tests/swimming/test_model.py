"""The core's model of a robot: columns in place of the robot's own, and what its parameters are called."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import get_args, get_origin

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.robot import parse
from hypertuna.description.schema.body import Links
from hypertuna.description.schema.water import LAWS, Water, WaterLaw
from hypertuna.description.validation import nested_model, unit_of
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model, parameter_names
from models import changed, fastest

LAG = 0.3  # rad


def test_columns_take_the_place_of_the_robot_s(tuna: ht.Robot) -> None:
    """The same numbers written into the description swim the same, to the last bit."""
    links = len(tuna.links.name)
    drag, mass = np.linspace(5, 20, links).tolist(), [0.9 * mass for mass in tuna.links.mass]
    inertia = list(tuna.links.inertia)
    lumped = {"water.lumped.drag": drag, "links.mass_kg": mass, "links.inertia_kg_m2": inertia}
    written = changed(tuna, lumped)
    model = core_model(tuna, {"water.lumped.drag": drag, "links.mass": mass})
    gait = Gaits.of([fastest(tuna)])
    here, there = settle(tuna, gait, model=model), settle(written, gait)
    assert all(np.array_equal(here[name], there[name]) for name in here)
    assert here["speed"] != settle(tuna, gait)["speed"]


def test_every_column_has_the_name_of_its_parameters(every_model: ht.Robot) -> None:
    """Each one of them may be replaced, and the core sees it; those of the gait are none of the robot's."""
    names = dict.fromkeys(name.partition("[")[0] for name in parameter_names(every_model))
    with pytest.raises(ht.InputError, match="must be a column of the robot's model"):
        core_model(every_model, {"gait.frequency": [1.0]})
    for name in names:
        if not name.startswith("gait."):
            with pytest.raises(ValueError, match="shape must be"):
                core_model(every_model, {name: [1.0] * 99})


def test_unknown_columns_suggest() -> None:
    with pytest.raises(ht.InputError, match=r"'water.lumped.drags': did you mean water.lumped.drag\?"):
        core_model(ht.load("hypertuna"), {"water.lumped.drags": [1.0]})


@pytest.mark.parametrize("joints", ["ideal", "bandwidth"])
def test_a_phase_offset_is_a_lag_of_the_joint(tuna: ht.Robot, joints: str) -> None:
    """By hand: alpha = b + A / sqrt(1 + x^2) sin(p - lag - offset - atan x), x = f / f_b."""
    robot = tuna.using(joints=joints)
    gait = replace(fastest(robot), bias=(0.1, -0.2))
    x = gait.frequency / 4.7 if joints == "bandwidth" else 0.0
    clock = np.linspace(0, 2 * math.pi, 9)
    motion = _core.joint_motion(
        core_model(robot, {"joints.phase_offset": [0.0, LAG]}),
        frequency=gait.frequency,
        amplitude=gait.amplitude,
        phase=gait.phase,
        bias=gait.bias,
        clock=clock,
    )
    for group, offset, b, amplitude, lag in zip(
        robot.joints, (0.0, LAG), gait.bias, gait.amplitude, gait.phase, strict=True
    ):
        angle = b + amplitude / math.hypot(1, x) * np.sin(clock - lag - offset - math.atan(x))
        for link, share in zip(group.links, group.share, strict=True):
            assert motion[:, link, 0] == pytest.approx(share * angle, abs=1e-15)


def test_a_phase_offset_swims_like_a_later_phase(every_model: ht.Robot) -> None:
    gait, groups = fastest(every_model), len(every_model.joints)
    document = every_model.document()
    for g in range(groups):
        document["joints"][g]["phase_offset_deg"] = math.degrees(LAG * g)
    offset = ht.swim(parse(document), gait)
    later = ht.swim(every_model, replace(gait, phase=tuple(lag + LAG * g for g, lag in enumerate(gait.phase))))
    assert offset.speed == pytest.approx(later.speed, rel=1e-9)
    assert offset.mechanical_power == pytest.approx(later.mechanical_power, rel=1e-9)


def test_the_laws_of_core_and_description_are_the_same() -> None:
    """Names, and every column a coefficient of the law's table or an area of the links, per link or single alike."""
    assert {name for name, _ in _core.water_laws()} == set(LAWS) == set(get_args(WaterLaw))
    for law, columns in _core.water_laws():
        table = nested_model(Water.model_fields[law].annotation)
        assert table is not None
        own = {name: get_origin(field.annotation) is tuple for name, field in table.model_fields.items()}
        flags = {name for name, field in table.model_fields.items() if field.annotation is bool}
        assert {name for name, _, _ in columns if name in own} | flags == set(own)
        areas = list(LAWS[law].areas.values()) or [{}]
        for name, unit, per_link in columns:
            assert per_link is own.get(name, True), (law, name)
            assert all(name in own or names.get(name, name) in Links.model_fields for names in areas)
            if name in own:
                assert unit == (unit_of(table.model_fields[name]) or "1")
