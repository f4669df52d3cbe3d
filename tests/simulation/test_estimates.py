"""How far estimates may be off: declared with the key, or by the robot's own file."""

import tomllib

import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.description.robot import Robot, parse
from hypertuna.description.validation import declared
from hypertuna.errors import InputError
from hypertuna.simulation.estimates import random_robots, spreads, varied


def first(actuation: str) -> Robot:
    return parse(tomllib.loads(first_robot("fish", actuation=actuation)))


def test_every_declared_spread_is_that_of_some_robot_and_has_its_own_place(tuna: ht.Robot) -> None:
    keys = {key: one.spread for key, one in declared(Robot).items() if one.spread is not None}
    servos = first("servo").document()
    servos["joints"][0]["servo"]["inertia_kg_m2"] = 1e-4
    found = spreads(tuna) | spreads(parse(servos))
    assert found == keys
    assert list(spreads(tuna)) == [key for key in sorted(keys, key=lambda key: keys[key].place) if ".servo." not in key]


def test_a_robot_states_its_own_spread_and_what_it_measured_has_none(tuna: ht.Robot) -> None:
    document = tuna.document() | {"uncertainty": {"joints.line": 1.5, "joints.line.bore_m": 2.0}}
    document["sources"] = document["sources"] | {"oil.air": "measured under vacuum"}
    robot = parse(document)
    own = spreads(robot)
    assert [(own[key].low, own[key].high) for key in ("joints.line.bore_m", "joints.line.fill_pressure_pa")] == [
        (0.5, 2.0),
        (1 / 1.5, 1.5),
    ]
    assert own["servos.speed_rad_s"] == spreads(tuna)["servos.speed_rad_s"]
    assert "oil.air" not in own
    with pytest.raises(InputError, match="oil.air must be an estimate of the robot"):
        varied(robot, {"oil.air": 0.5})


def test_values_are_multiples_or_sums_and_a_default_may_be_off_too(tuna: ht.Robot) -> None:
    keys = (
        "joints.line.bore_m",
        "oil.temperature_c",
        "joints.actuator.stiffness_factor",
        "controller.pressure_work_pa",
    )
    low, middle, high = (varied(tuna, dict.fromkeys(keys, part)) for part in (0.0, 0.5, 1.0))
    oils = [robot.oil.temperature for robot in (tuna, low, middle, high) if robot.oil]
    bores = [[group.line.bore for group in robot.joints if group.line] for robot in (tuna, low, high)]
    assert bores[1] == pytest.approx([0.8 * bore for bore in bores[0]])
    assert bores[2] == pytest.approx([1.2 * bore for bore in bores[0]])
    assert oils == pytest.approx([oils[0], oils[0] - 10, oils[0], oils[0] + 10])
    factors = [group.actuator.stiffness_factor for group in middle.joints if group.actuator]
    assert factors == pytest.approx([(0.7 * 1.4) ** 0.5] * len(tuna.joints))
    for robot in (low, high):
        limits = robot.controller
        assert limits
        assert limits.pressure_hard == pytest.approx(1.5 * (limits.pressure_work or 0.0))


def test_robots_with_servos_on_axles_differ_within_the_spreads() -> None:
    robot = first("servo")
    at, *speeds = (
        one.joints[0].servo.speed for one in [robot, *random_robots(robot, 20, seed=2)] if one.joints[0].servo
    )
    assert 0.9 * at <= min(speeds) < 0.95 * at < 1.05 * at < max(speeds) <= 1.1 * at
