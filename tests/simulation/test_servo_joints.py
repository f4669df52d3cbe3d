"""Joints that servos turn: the axle's equation by SciPy, limits, robots with and without oil beside them."""

import copy
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hypertuna as ht
from hypertuna.actuation.hydraulics import with_bore
from hypertuna.description.robot import Robot, parse
from hypertuna.firmware.header import header
from hypertuna.firmware.parameters import firmware_table
from hypertuna.mission.flight import fly

SERVO = {"torque_n_m": 2.0, "speed_rad_s": 10.0, "voltage_v": 7.4, "friction_n_m": 0.05}
GAIT = ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(0, 40))
MUSCLES = ("actuator", "line", "drive_units", "pressure_max_pa")
OIL = ("pump", "oil", "drive_unit", "materials")


def with_servos(*joints: int, **servo: float) -> Robot:
    """HyperTuna with servos on the axles of some joints; without oil where no joint keeps its muscles."""
    document = copy.deepcopy(ht.load("hypertuna").document())
    document.pop("sources")
    for j in joints:
        group = document["joints"][j]
        document["joints"][j] = {key: group[key] for key in group if key not in MUSCLES} | {"servo": SERVO | servo}
    left = 2 * (len(document["joints"]) - len(joints))
    for pump in document["servos"]:
        pump["count"] = left if left and pump["drives"] == "piston pump" else pump["count"]
    for key in ("firmware", "guidance"):
        document.pop(key)
    if not left:
        document["servos"] = [servo for servo in document["servos"] if servo["drives"] != "piston pump"]
        document["sensors"] = []
        for key in OIL:
            document.pop(key)
        for key in ("pressure_step_pa", "pressure_work_pa", "pressure_soft_pa", "pressure_hard_pa"):
            document["controller"].pop(key)
    return parse(document)


def one_joint() -> Robot:
    """Head and tail, a servo between them; the tail alone moves on the bench."""
    document = with_servos(0, 1).document()
    tail = {"length_m": 0.1, "com_m": 0.04, "mass_kg": 0.3, "lateral_area_m2": 0.006, "wetted_area_m2": 0.012}
    links: dict[str, Any] = {"name": ["head", "tail"]}
    links |= {key: [2 * value, value] for key, value in tail.items()}
    document |= {"links": links, "body": {"length_m": 0.3, "mass_kg": 0.9}, "gaits": {}}
    document["joints"] = [document["joints"][1] | {"links": [1]}]
    document["gait_bounds"] = {"frequency_hz": [0.1, 6.0], "amplitude_deg": [[0.0, 25.0]], "phase_deg": [[0.0, 0.0]]}
    for key in ("spatial", "fins", "gait_bounds"):
        document.pop(key)
    lumped = {"added_mass": [0.3, 0.2], "friction": [0.1, 0.1], "drag": [20.0, 5.0]}
    document["water"] = {"density_kg_m3": 1000.0, "lumped": lumped}
    return parse(document)


def test_the_axle_moves_as_its_equation_says() -> None:
    """(I + J) q'' = loop within the torque-speed line - friction, on the bench; SciPy from tick to tick."""
    robot = one_joint()
    gait = ht.Gait.from_degrees(frequency=3, amplitude=(25,), phase=(0,))
    run = ht.twin(robot, gait, duration=1.0, medium="air", step=1e-4)
    servo = robot.joints[0].servo
    assert servo is not None
    inertia = robot.links.inertia[1] + robot.links.mass[1] * robot.links.com[1] ** 2
    loop = 2 * math.pi * servo.bandwidth / math.sqrt(math.sqrt(2) - 1)  # of two equal lags
    stall = servo.torque  # the converter keeps the rated voltage

    def rate(_: float, at: Any, target: float) -> list[float]:
        q, w = at
        desired = servo.inertia * loop * (loop * (target - q) - 2 * w)
        torque = np.clip(desired, -stall - stall * w / servo.speed, stall - stall * w / servo.speed)
        rubbed = servo.friction * w / math.hypot(w, 0.05)
        return [w, (torque - rubbed) / (inertia + servo.inertia)]

    at = np.zeros(2)
    for k, target in enumerate(run.data["servo_target"][:-1, 0]):
        at = solve_ivp(rate, (0, run.tick), at, args=(float(target),), rtol=1e-9, atol=1e-11, max_step=1e-3).y[:, -1]
        assert run.data["angle"][k + 1, 0] == pytest.approx(at[0], abs=2e-6)
    assert np.ptp(run.data["angle"]) > math.radians(40)
    np.testing.assert_array_equal(run.data["servo_angle"][:, 0], run.data["angle"][:, 0])


@pytest.mark.parametrize("joints", [(0,), (1,), (0, 1)])
def test_servos_beside_muscles_and_alone(joints: tuple[int, ...]) -> None:
    robot = with_servos(*joints)
    run = ht.twin(robot, GAIT, duration=8)
    assert run.status == "completed"
    assert run.circuits == tuple(
        f"{'I' * (j + 1)}-{side}" for j in (0, 1) if j not in joints for side in ("left", "right")
    )
    assert len(run.drives) == 4 - len(joints)
    assert np.degrees(run.swing) == pytest.approx([16, 25], abs=0.5)
    assert np.isnan(run.data["angle_measured"]).all(axis=0).tolist() == [j in joints for j in (0, 1)]
    assert run.data["pump_pressure"].shape[1] == len(run.circuits)
    assert not run.faults
    torque, speed = run.data["servo_torque"], run.data["servo_rate"]
    for j in joints:
        c = run.drives.index("I" * (j + 1))
        assert abs(torque[:, c]).max() <= 2.0 * (1 + 1e-9)
        assert abs(speed[:, c]).max() < 10.0
    assert run.dataset().sizes["drive"] == len(run.drives)


def test_a_weak_servo_does_not_follow() -> None:
    """Torque decides: 0.1 N m do not beat the tail through the water as 2 N m do, and the controller cannot see it."""
    strong, weak = (ht.twin(with_servos(0, 1, torque_n_m=torque), GAIT, duration=6) for torque in (2.0, 0.1))
    assert weak.swing[0] < 0.6 * strong.swing[0]
    assert weak.speed < 0.8 * strong.speed


@pytest.mark.parametrize("joints", [(1,), (0, 1)], ids=["mixed", "servos"])
def test_an_amplitude_at_the_joint_s_maximum_is_named_as_such(joints: tuple[int, ...]) -> None:
    # The core has one governor of amplitudes for all joints; here its limit was that of pressures, "(II, )".
    robot = with_servos(*joints)
    bend = math.degrees(robot.joints[1].bend_max or 0.0)
    run = ht.twin(robot, ht.Gait.from_degrees(frequency=2, amplitude=(4, bend), phase=(0, 40), bias=(0, 5)), duration=4)
    assert "amplitude_limit" in run.limits
    assert any(one.startswith("The joint was asked to bend further than it reaches (II): ") for one in run.sentences)
    assert [one for one in run.sentences if "II" in one and "pressure" in one] == []


def test_a_robot_without_oil_has_no_word_of_it_and_takes_none() -> None:
    robot = with_servos(0, 1)
    bends = [math.degrees(group.bend_max or 0.0) for group in robot.joints]
    gait = ht.Gait.from_degrees(frequency=3, amplitude=bends, phase=(0, 40), bias=(5, 5))
    run = ht.twin(robot, gait, duration=4)
    told = " ".join([*run.sentences, *run.limits, *run.summary()]).lower()
    assert run.limits
    assert [word for word in ("oil", "pump", "pressure", "cylinder", "circuit") if word in told] == []
    for use in (lambda: ht.twin(robot, gait, duration=4, temperature=280.0), lambda: with_bore(robot, 0.003)):
        with pytest.raises(ht.InputError, match="applies to oil, and servos turn all joints of hypertuna"):
            use()


def test_water_and_rotor_slow_a_servo() -> None:
    """The loop does not know its load: with the same torque and speed, a lag beyond the unloaded one."""
    run = ht.twin(with_servos(0, 1), GAIT, duration=6)
    assert math.degrees(run.phase[0]) > 2 * math.degrees(math.atan(2 * math.pi * 2 / (2 * math.pi * 10 / 0.6436)))


def test_a_joint_has_muscles_or_a_servo() -> None:
    document = ht.load("hypertuna").document()
    document["joints"][0]["servo"] = SERVO
    with pytest.raises(ht.InputError, match=r"joints\[0\].drive_units must not stand beside joints\[0\].servo"):
        parse(document)


def test_faults_are_those_of_sensors_that_are_there() -> None:
    robot = with_servos(1)
    with pytest.raises(ht.InputError, match="must be of a sensor that is read"):
        ht.twin(robot, GAIT, duration=1, faults="pressure-II:stuck@0.5")
    assert ht.twin(robot, GAIT, duration=2, faults="pressure-I-left:nan@0.5").faults == ("pressure_fault",)


def test_nothing_to_size_without_oil() -> None:
    from hypertuna.actuation.sizing import size_pump

    with pytest.raises(ht.InputError, match="has no pump: servos turn all its joints"):
        size_pump(with_servos(0, 1), frequency=[2], amplitude=[0.2, 0.3])


def test_a_robot_without_oil_swims_a_mission() -> None:
    """Pilot, controller and plant at sea: towards the first waypoint, without a fault."""
    document = with_servos(0, 1).document()
    own = ht.load("hypertuna").document()
    kept = [sensor for sensor in own["sensors"] if sensor.get("quantity") not in ("bend", "pressure", "current")]
    robot = parse(document | {"guidance": own["guidance"], "sensors": kept})
    record = fly(ht.read_mission("box"), robot, duration=30).record
    assert record.circuits == ("I", "I-unused", "II", "II-unused")
    assert not record.data["status"].any()
    assert not record.data["pump_pressure"].any()
    assert 0.2 < record.distance / record.time[-1] < 0.35


def test_firmware_has_pins_for_what_is_there() -> None:
    document = ht.load("hypertuna").document()
    document.pop("sources")
    group = document["joints"][1]
    document["joints"][1] = {key: group[key] for key in group if key not in MUSCLES} | {"servo": SERVO}
    document["servos"][1]["count"] = 2
    wiring = document["firmware"]
    with pytest.raises(ht.InputError, match=r"firmware.servo_pins must be 5 long"):
        parse(document)
    wiring |= {
        "servo_pins": [2, 3, 4, 5, 6],
        "bend_pins": [14],
        "pressure_pins": [16, 17],
        "current_pins": [20, 21, 22],
    }
    table = firmware_table(parse(document))
    text = header(table)
    assert "{2, 3, 4, -1, 5, 6}," in text
    assert "{14, -1, 16, 17, -1, -1, 20, 21, 22, -1, 26}," in text  # bend, pressure, current, voltage
    places = [k for k, field in enumerate(table.fields) if field[1] == "direct"]
    assert table.values[places].tolist() == [0.0, 1.0]
