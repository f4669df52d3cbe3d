"""First robots with an actuator: each estimate by the rule that its source states, by hand."""

import math
import tomllib
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.description.robot import parse


def document(actuation: str, **sizes: Any) -> dict[str, Any]:
    return tomllib.loads(first_robot("fish", joints=["J1", "J2"], actuation=actuation, **sizes))


@pytest.fixture(scope="module")
def oil() -> dict[str, Any]:
    """A fish of 0.3 m: a head of 0.15 m and two links of 0.075 m."""
    return document("hydraulic")


def test_soft_bodies_and_lines_follow_from_the_links(oil: dict[str, Any]) -> None:
    """Lines have a head of 0.15 body lengths and what lies between head and joint; hoses give 8 % at 250 kPa."""
    outer, inner = oil["drive_unit"]["outer_diameter_m"], oil["drive_unit"]["inner_diameter_m"]
    narrowest = min(min(joint["actuator"]["semi_minor_m"]) for joint in oil["joints"])
    assert outer == pytest.approx(0.004 * narrowest / 0.0142, rel=5e-3)  # HyperTuna's hose and narrowest half width
    for joint, behind in zip(oil["joints"], (0.0, 0.075), strict=True):
        body, line = joint["actuator"], joint["line"]
        assert body["segment_length_m"] == [pytest.approx(0.6 * 0.075 / 3)] * 3
        assert body["lever_m"] == pytest.approx(0.55 * min(body["semi_minor_m"]), rel=5e-3)
        assert joint["drive_units"] == round(0.8 * min(body["semi_major_m"]) / (1.25 * outer))
        assert line["length_m"] == pytest.approx(0.15 * 0.3 + behind)
        assert line["bore_m"] == pytest.approx(0.8 * outer, rel=0.03)  # two digits
        hoses = joint["drive_units"] * math.pi / 4 * inner**2 * 0.045
        volume = hoses + math.pi / 4 * (0.8 * outer) ** 2 * line["length_m"]
        assert line["compliance_m3_pa"] == pytest.approx(0.08 * volume / 250e3, rel=0.03)
        assert (line["loss"], line["fill_pressure_pa"]) == (1.5, 60e3)


def test_bends_pump_and_servos_follow_from_the_muscles(oil: dict[str, Any]) -> None:
    for joint, amplitude, bounds, model in zip(
        oil["joints"],
        oil["gaits"]["cruise"]["amplitude_deg"],
        oil["gait_bounds"]["amplitude_deg"],
        joint_models(parse(oil)),
        strict=True,
    ):
        reached = abs(math.degrees(float(model.balance([[250e3, 0.0]])["angle"][0])))
        assert joint["bend_max_deg"] == pytest.approx(reached, abs=0.1)
        assert joint["amplitude_max_deg"] == pytest.approx(0.85 * reached, abs=0.1)
        assert bounds == [0.0, joint["amplitude_max_deg"]]
        assert amplitude <= 0.9 * joint["amplitude_max_deg"] + 0.05
    pump, (servo,), model = oil["pump"], oil["servos"], joint_models(parse(oil))[0]
    assert (pump["crank_m"], pump["rod_m"], pump["neutral_deg"]) == (0.014, 0.036, 90.0)  # 0.048 and 0.12 of 0.3 m
    area = math.pi / 4 * pump["bore_m"] ** 2
    displaced = 0.6 * pump["crank_m"] * area  # 1.2 times the largest bend takes three fifths of the crank
    assert pump["dead_volume_m3"] == pytest.approx(0.1 * displaced, rel=0.15)
    bend = 1.2 * math.radians(oil["joints"][0]["bend_max_deg"])
    held = model.hold([-bend, bend])
    taken = abs(held["volume"] - model.at(0.0)["volume"]).max()  # oil of the muscles; the hoses' gives the rest
    assert taken < displaced < 1.5 * taken
    torque = 3 * 250e3 * area * pump["crank_m"]
    assert servo["torque_n_m"] == pytest.approx(torque, rel=0.15)
    assert servo["count"] == 4
    assert (servo["speed_rad_s"], servo["voltage_v"], servo["bandwidth_hz"]) == (7.5, 7.4, 10.0)
    assert servo["stall_current_a"] == pytest.approx(servo["torque_n_m"] * 7.5 / 7.4, rel=0.02)
    assert servo["friction_n_m"] == pytest.approx(0.04 * servo["torque_n_m"], rel=0.02)
    assert servo["inertia_kg_m2"] == pytest.approx(0.005 * servo["torque_n_m"] / 7.5, rel=0.02)
    assert servo["idle_current_a"] == 0.05
    pressures = [oil["controller"][f"pressure_{name}_pa"] for name in ("work", "soft", "hard")]
    assert pressures == [250e3, 312.5e3, 375e3]


@pytest.mark.parametrize(("mass", "strings"), [(None, 1), (2.0, 1), (3.0, 2)])
def test_servos_have_a_battery_by_the_mass(mass: float | None, strings: int) -> None:
    """15 W h per kg at two cells of 3.7 V, in strings of 5 A h at most: 4.05 A h for 2 kg, 2 x 3.04 A h for 3 kg."""
    fish = document("servo", **({} if mass is None else {"mass": mass, "length": 0.5}))
    battery, charge = fish["battery"], 15 * fish["body"]["mass_kg"] / 7.4 / strings
    assert (battery["cells"], battery["series"], battery["usable"]) == (2 * strings, 2, 0.9)
    assert battery["capacity_ah"] == pytest.approx(charge, rel=0.03)
    assert battery["resistance_ohm"] == pytest.approx(0.04 / charge, rel=0.05)
    assert (battery["voltage_v"], battery["charged_v"]) == (3.7, 4.2)
    assert fish["controller"]["voltage_low_v"] == 6.8
    robot = parse(fish)
    beat = ht.swim(robot, ht.named_gait(robot, "cruise")).trajectory.joint_torque
    largest = np.abs(beat.to_numpy()).max(axis=list(beat.dims).index("time"))
    for joint in fish["joints"]:
        torque = max(0.05, 3 * max(largest[i] for i in joint["links"]))
        assert joint["servo"]["torque_n_m"] == pytest.approx(torque, rel=0.05)
        assert joint["servo"]["friction_n_m"] == pytest.approx(0.04 * joint["servo"]["torque_n_m"], rel=0.05)
        assert joint["amplitude_max_deg"] == joint["bend_max_deg"]
