"""Missions on the twin at sea: parts make a whole, seeds repeat, depth and way are held, failures keep their rules."""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.control.guidance import gait_table
from hypertuna.control.mission import Mission, Waypoint
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.frames import angles_of
from hypertuna.mission.checks import check_current
from hypertuna.mission.file import parse_mission
from hypertuna.mission.flight import Flight, fly, waypoint_results
from hypertuna.mission.record import MissionRecord, names_of
from hypertuna.mission.run import ENDINGS, ending, fly_part, fly_parts, joined_parts, mission_start

NORTH = -math.pi / 2  # of the axis from nose to tail: the robot faces north
OUT = Mission(waypoints=(Waypoint(0, 60, 1, 0.3, 2), Waypoint(30, 60, 1, 0.3, 2)), heading=NORTH, stay=True)


@pytest.fixture(scope="module")
def robot() -> ht.Robot:
    return ht.load("hypertuna")


@pytest.fixture(scope="module")
def minutes(robot: ht.Robot) -> MissionRecord:
    """Three minutes: a survey at the surface, a dive, a way at depth, across a current of 0.1 m/s."""
    mission = Mission(**{**OUT.__dict__, "current": (0.1, 0.0)})
    return flown(robot, mission, seed=3, duration=180).record


def flown(robot: ht.Robot, mission: Mission, **options: Any) -> Flight:
    """Fly a mission of no file, which scatters nothing over its seeds."""
    place = {"x_m": 0.0, "y_m": 0.0}
    point = place | {"speed_m_s": 0.3, "radius_m": 2.0}
    start = place | {"heading_deg": 0.0}
    file = parse_mission({"format": 1, "name": "flown", "start": start, "waypoints": [point]})
    return fly(replace(file, mission=mission), robot, **options)


def modes(record: MissionRecord) -> list[str]:
    return [record.modes[int(mode)] for mode in record.data["mode"]]


def test_parts_make_the_whole(robot: ht.Robot) -> None:
    """A mission that goes on from a saved state is the same to the last bit."""
    start = mission_start(robot, OUT, seed=5, duration=8, every=4)
    whole, _ = fly_part(start, 800)
    first, state = fly_part(start, 400)
    second, _ = fly_part(start, 400, state)
    run, parts = joined_parts(start, [whole]), joined_parts(start, [first, second])
    assert len(run.time) == 200
    for name, values in run.data.items():
        assert np.array_equal(values, parts.data[name]), name
    with pytest.raises(ValueError, match="must be one of this mission's"):
        fly_part(start, 100, state[:-1])


def test_a_seed_repeats_and_another_differs(robot: ht.Robot) -> None:
    runs = [flown(robot, OUT, seed=seed, duration=3).record for seed in (1, 1, 2)]
    assert np.array_equal(runs[0].position, runs[1].position)
    assert not np.array_equal(runs[0].position, runs[2].position)


def test_it_knows_where_it_is(minutes: MissionRecord) -> None:
    """Position within four of the deviations that it says; current, heading and pitch as they are.

    Not within three: the slow first beats at a new frequency look like a current, which the estimator does not know.
    """
    late = minutes.time > 60
    off = np.hypot(*(minutes.data["position_estimated"] - minutes.position[:, :2]).T)
    assert (off[late] < 4 * minutes.data["position_error"][late]).all()
    # The antenna dips at the start: the receiver needs seconds to find the satellites again, and fixes come later.
    assert minutes.data["current_estimated"][-1] == pytest.approx([0.1, 0], abs=0.09)
    angles, seen = minutes.angles[late], np.unwrap(angles_of(minutes.data["attitude_estimated"][late]), axis=0)
    error = np.degrees(np.remainder(angles - seen + math.pi, 2 * math.pi) - math.pi)
    assert abs(error[:, :2]).max() < 2.5  # roll, pitch
    assert abs(error[:, 2]).max() < 6  # heading, with the compass's offset


def test_it_holds_depth_and_course(minutes: MissionRecord) -> None:
    """The first leg from 25 m on, 15 s or more at 1 m: within 10 cm, as near to the leg as it believes to be."""
    far = (minutes.data["position_estimated"][:, 1] > 25) & (minutes.data["leg"] == 0) & (minutes.depth > 0.8)
    far &= np.array(modes(minutes)) == "transit"  # not on its way up for a fix
    assert far.sum() > 150
    assert minutes.depth[far] == pytest.approx(1.0, abs=0.1)
    assert abs(minutes.data["position_estimated"][far, 0]).max() < 0.6
    assert abs(np.degrees(minutes.angles[far, 1])).max() < 12
    assert np.isfinite(minutes.position).all()


@pytest.mark.parametrize("fault", ["depth:nan@20", "imu:nan@20", "field:nan@20", "battery:nan@20"])
def test_a_lost_sensor_is_told_and_survived(robot: ht.Robot, fault: str) -> None:
    reason = {"depth": "depth_lost", "imu": "imu_lost", "field": "compass_lost", "battery": "battery_lost"}
    flight = flown(robot, OUT, seed=1, faults=[fault], duration=45)
    run = flight.record
    told = reason[fault.partition(":")[0]]
    assert 21 < run.first_reasons[told] < 26
    assert flight.status != "diverged"
    assert np.isfinite(run.data["position_estimated"]).all()
    assert modes(run)[-1] in ("home", "ended", "surface", "hold")  # a fast robot is home in time
    assert run.depth.max() < 1.5


@pytest.mark.parametrize(("grams", "fixed"), [(0.0, False), (15.0, True)])
def test_a_robot_at_rest_has_fixes_if_it_floats(robot: ht.Robot, grams: float, fixed: bool) -> None:
    """Without an IMU it holds. As heavy as its water it may settle with the antenna below: not if trimmed to float."""
    spatial = robot.spatial
    assert spatial is not None
    first, *others = spatial.volume
    lighter = spatial.model_copy(update={"volume": (first + grams * 1e-6, *others)})
    run = flown(robot.model_copy(update={"spatial": lighter}), OUT, seed=1, faults=["imu:nan@60"], duration=130).record
    assert modes(run)[-1] == "hold"
    falls = np.diff(run.data["position_error"]) < -0.005
    assert falls[run.time[1:] > 90].any() == fixed


@pytest.mark.parametrize(
    ("fault", "deepest"), [("fin-port:stuck@5", 4.5), ("fin-starboard:down@5", 4.5), ("fins:down@5", 6.0)]
)
def test_a_lost_fin_loses_no_robot(robot: ht.Robot, fault: str, deepest: float) -> None:
    """One fin alone keeps it within its 4 m; with both down it glides beyond before it stops (docs/pilot.md)."""
    mission = Mission(**{**OUT.__dict__, "depth_max": 4.0})
    flight = flown(robot, mission, seed=1, faults=[fault], duration=120)
    assert flight.status != "diverged"
    assert flight.record.depth.max() < deepest


@pytest.mark.parametrize("noise", [0.0, 0.002, 0.05])
def test_a_coarse_depth_sensor_ends_no_mission(robot: ht.Robot, noise: float) -> None:
    """Readings with steps of 5 cm repeat while the sensor works; if it is stuck, the fins seem not to answer."""
    document = robot.document()
    depth = next(sensor for sensor in document["sensors"] if sensor.get("quantity") == "depth")
    depth |= {"resolution": 0.05, "noise": noise}
    coarse = parse(document)
    mission = Mission(**{**OUT.__dict__, "waypoints": (Waypoint(0, 60, 4, 0.3, 2),)})
    told, after = ("depth_lost", 7) if noise >= 0.05 else ("no_answer", 25)  # s
    healthy = flown(coarse, mission, seed=1, duration=100).record
    assert not healthy.first_reasons
    assert healthy.depth.max() > 2
    stuck = flown(coarse, mission, seed=1, duration=100, faults=["depth:stuck@75"]).record
    assert next(iter(stuck.first_reasons)) == told
    assert stuck.first_reasons[told] == pytest.approx(75 + after, abs=5)


def test_home_before_the_last_waypoint_is_not_done(robot: ht.Robot) -> None:
    """The time is up at once: home is here."""
    flight = flown(robot, Mission(**{**OUT.__dict__, "duration": 1.0}), seed=1, duration=200)
    assert modes(flight.record)[-1] == "ended"
    assert flight.record.data["leg"][-1] == 0
    assert flight.status == "home"


def test_a_waypoint_that_would_be_skipped_is_refused(robot: ht.Robot) -> None:
    point = OUT.waypoints[-1]
    fence = ((point.x - 100, point.y - 100), (point.x + 2, point.y - 100), (point.x + 2, point.y + 100))
    fence = (*fence, (point.x - 100, point.y + 100))
    with pytest.raises(
        InputError, match=r"must be at least 3 m inside the fence .guidance.fence_margin_m .* but is 2 m inside"
    ):
        mission_start(robot, Mission(**{**OUT.__dict__, "fence": fence}))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"waypoints": (Waypoint(0, 60, 1, 0.3, 0.5),)},
            r"waypoints\[0\].radius_m must be at least 1.9 m, the uncertainty .* 0.5",
        ),
        ({"home_radius": 1.0}, r"home.radius_m must be at least 1.9 m"),
        (
            {"depth_max": 1.2},
            r"limits.depth_m must be at least 1.3 m, 0.3 m below the deepest waypoint at 1 m, but is 1.2",
        ),
        ({"depth_max": 0.4, "waypoints": ()}, r"limits.depth_m must be at least 0.5 m, because the nose dips that far"),
    ],
)
def test_what_a_robot_cannot_know_or_keep_is_refused(robot: ht.Robot, change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        mission_start(robot, replace(OUT, **change))


def test_a_current_against_which_there_is_no_way_home_is_refused(robot: ht.Robot) -> None:
    """A current that is slower below counts as it is at the surface, and back; 5 cm/s must be left of the speed."""
    fastest = gait_table(robot).speed[-1]
    most = fastest - 0.05
    for current, bottom in (((0.0, most + 0.01), (0.0, 0.0)), ((0.0, 0.1), (0.0, 7.0))):
        with pytest.raises(
            InputError,
            match=rf"water.current_m_s must be at most {most:.3g} m/s for a robot that swims at {fastest:.3g}",
        ):
            flown(robot, replace(OUT, current=current, current_bottom=bottom), duration=1)
    steady = replace(OUT, current=(most - 0.1, 0.0), current_bottom=(most - 0.1, 0.0))
    check_current(robot, steady)
    fix = f"{most + 0.02:.3g} m/s in all: wait for less current, or reduce scatter.current_m_s"
    with pytest.raises(InputError, match=re.escape(fix)):
        check_current(robot, steady, 0.12)


def test_a_mission_ends_as_the_pilot_says() -> None:
    modes, reasons = ([name for name, _ in table] for table in (_core.mode_table(), _core.reason_table()))
    adrift = 1 << reasons.index("adrift")
    for mode, flags, status in [
        ("done", 0, "done"),
        ("ended", 0, "home"),
        ("ended", adrift, "adrift"),
        ("home", adrift, "adrift"),
        ("home", 0, "given up"),
        ("transit", 0, "given up"),
        ("hold", adrift, "hold"),
    ]:
        assert ending(modes.index(mode), flags) == status
        assert status in ENDINGS


@pytest.mark.parametrize(("ticks", "rows"), [(0, 1), (7, 1), (13, 2)])
def test_a_mission_that_diverges_is_told_within_a_row_too(robot: ht.Robot, ticks: int, rows: int) -> None:
    """The plant breaks after these ticks, ten a row: a row that was begun is there, and the first always."""

    def fly(_: int, asked: int, state: bytes | None) -> tuple[dict[str, Array], bytes]:
        part, state = fly_part(start, asked, state)
        return part | {"ticks": np.array([float(ticks)])}, state

    start = mission_start(robot, OUT, duration=0.2)
    run = joined_parts(start, [part for _, part in fly_parts(start, fly)])
    assert (run.status, len(run.time)) == ("diverged", rows)
    whole = joined_parts(start, [part for _, part in fly_parts(start)])
    assert (whole.status, len(whole.time)) == ("given up", 2)


def test_waypoints_are_told_apart(robot: ht.Robot) -> None:
    """A record by hand: the first waypoint is reached, the second passed, the third skipped, the fourth ahead."""
    start = mission_start(robot, OUT, duration=1)
    part, _ = fly_part(start, 50)
    run = joined_parts(start, [part])
    points = tuple(Waypoint(10.0 * k, 0, 1, 0.3, 2) for k in range(4))
    leg, reached, passed = np.array([[0, 0, 0], [1, 1, 0], [2, 1, 1], [3, 1, 1], [3, 1, 1]]).T.astype(float)
    data = {name: values for name, values in run.data.items() if name in ("attitude", "reasons")} | {
        "position": run.data["position"] + [3.0, 4.0, -1.5],
        "position_estimated": run.data["position"][:, :2],
        "position_error": np.linspace(1, 5, 5),
        **{"leg": leg, "reached": reached, "passed": passed},
    }
    record = MissionRecord("m", "r", replace(OUT, waypoints=points), run.time, data, **names_of(robot))
    rows = waypoint_results(record)
    assert [row["outcome"] for row in rows] == ["reached", "passed", "skipped", "ahead"]
    assert [row["uncertainty_m"] for row in rows] == [2, 3, 4, None]
    assert [row["waypoint"] for row in rows] == [1, 2, 3, 4]
    assert rows[0]["true_m"] == pytest.approx(5, abs=0.1)
    assert rows[0]["believed_m"] == pytest.approx(0, abs=0.1)
    assert rows[1]["believed_m"] == pytest.approx(10, abs=0.1)
    assert rows[1]["depth_m"] == pytest.approx(1.5, abs=0.2)
    assert rows[3]["time_s"] is None


def test_a_mission_may_last_a_day(robot: ht.Robot) -> None:
    far = Mission(waypoints=(Waypoint(9000.0, 0.0, 1.0, 0.3, 3.0),))
    assert mission_start(robot, far).duration == 1e5
    with pytest.raises(InputError, match="duration must be from 0.01 to 100000 s"):
        mission_start(robot, far, duration=2e5)


def test_faults_of_fins_are_checked(robot: ht.Robot) -> None:
    with pytest.raises(InputError, match="known kind"):
        mission_start(robot, OUT, faults="fins:gone@5")
    with pytest.raises(InputError, match="time"):
        mission_start(robot, OUT, faults="fins:up@5-4")
    with pytest.raises(InputError, match="sensor that is read in this run"):
        mission_start(robot, OUT, faults="fin-left:up@5")


def test_without_satellites_it_says_so(robot: ht.Robot) -> None:
    mission = Mission(**{**OUT.__dict__, "gaps": ((0.0, 1e6),)})
    run = flown(robot, mission, seed=1, duration=85).record
    assert "no_fix" in run.first_reasons
    assert run.data["position_error"][-1] > run.data["position_error"][0]
