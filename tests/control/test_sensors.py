"""Sensors from a robot's description, and faults as the command line spells them."""

import tomllib

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.new import first_robot
from hypertuna.control.sensors import channels, fault_times, faults, sensor_columns
from hypertuna.description.robot import parse
from hypertuna.errors import InputError

TRUTH = {"bend": [0.1, -0.2], "pressure": [6e4] * 4, "current": [0.3] * 4, "rate": [0.0] * 3}
TRUTH |= {"acceleration": [0.0, 0.0, 9.8], "voltage": [15.0]}


@pytest.fixture(scope="module")
def robot() -> ht.Robot:
    return ht.load("hypertuna")


def readings(robot: ht.Robot, seed: int, spelled: tuple[str, ...] = ()) -> np.ndarray:
    sensors = _core.Sensors(sensor_columns(robot), seed)
    given = [tuple(fault) for fault in faults(spelled, robot)]
    return np.array([np.concatenate([*sensors.read(TRUTH, given).values()]) for _ in range(50)])


def test_a_seed_repeats_and_another_differs(robot: ht.Robot) -> None:
    assert np.array_equal(readings(robot, 1), readings(robot, 1))
    assert not np.array_equal(readings(robot, 1), readings(robot, 2))


def test_a_fault_changes_its_own_channel_alone(robot: ht.Robot) -> None:
    sound, faulty = readings(robot, 1), readings(robot, 1, ("bend-II:stuck@0.2",))
    changed = np.flatnonzero((sound != faulty).any(axis=0))
    names = [name for name, row in _core.Sensors(sensor_columns(robot), 1).read(TRUTH).items() for _ in row]
    assert [names[k] for k in changed] == ["bend"]
    assert len(np.unique(faulty[20:, changed])) == 1


def test_faults_are_read_as_they_are_spelled(robot: ht.Robot) -> None:
    known = channels(robot, pilot=False)
    (fault,) = faults("bend-II:stuck@5", robot)
    assert fault == ("stuck", *known["bend-II"], 5.0, float("inf"))
    (fault,) = faults(["pressure-I-left:open@3-4.5"], robot)
    assert fault == ("open", *known["pressure-I-left"], 3.0, 4.5)
    assert known["imu"][1] - known["imu"][0] == 5
    assert faults((), robot) == ()


def test_a_joint_with_oil_has_two_currents(robot: ht.Robot) -> None:
    known = channels(robot, pilot=False)
    first = known["current"][0]
    assert known["current"] == (first, first + 3)
    for j, group in enumerate(robot.joints):
        assert known[f"current-{group.name}"] == (first + 2 * j, first + 2 * j + 1)
        assert known[f"current-{group.name}-right"] == (first + 2 * j + 1, first + 2 * j + 1)


def test_a_joint_with_a_servo_has_one_current() -> None:
    """Two places a joint, as for the two circuits of one with oil: the first is read."""
    eel = parse(tomllib.loads(first_robot("eel", joints=["J1", "J2"], actuation="servo")))
    known = channels(eel, pilot=False)
    first = known["current"][0]
    assert [known[f"current-{group.name}"] for group in eel.joints] == [
        (first + 2 * j, first + 2 * j) for j in range(len(eel.joints))
    ]


def test_a_fault_may_start_at_once() -> None:
    assert fault_times("", "0") == (0.0, float("inf"))
    assert fault_times("", "0-0.5") == (0.0, 0.5)
    for times in ("-1", "5-5"):
        with pytest.raises(InputError, match="end after the start"):
            fault_times("", times)


@pytest.mark.parametrize(
    ("spelled", "said"),
    [
        ("bend-II", "CHANNEL:KIND@SECONDS"),
        ("bend-III:stuck@5", "did you mean bend-II"),
        ("bend-II:broken@5", "stuck, open, spike, nan"),
        ("bend-II:stuck@soon", "seconds"),
        ("bend-II:stuck@5-4", "end after the start"),
        ("bend-II:stuck@nan", "seconds"),
    ],
)
def test_bad_spellings_name_the_choices(robot: ht.Robot, spelled: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        faults(spelled, robot)
