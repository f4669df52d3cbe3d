"""The pilot from a robot's description: gait table, constants, reasons, and that it sends pulses."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core, frames
from hypertuna.control.controller import controller_columns
from hypertuna.control.guidance import curvature, gait_table, glide, mission_columns, pilot_columns
from hypertuna.control.mission import Mission, Waypoint, cross, fence_distance
from hypertuna.control.sensors import channels, faults, pilot_sensor_columns
from hypertuna.description.robot import parse
from hypertuna.errors import InputError

PAGE = Path(__file__).parents[2] / "docs" / "pilot.md"
CALM = {"bend": [0.0, 0.0], "pressure": [6e4] * 4, "current": [0.3] * 4, "rate": [0.0] * 3, "voltage": [15.5]}
CALM |= {"acceleration": [0.0, 0.0, 9.81], "depth": [0.0], "field": [0.0, -0.5, -0.86]}


@pytest.fixture(scope="module")
def robot() -> ht.Robot:
    return ht.load("hypertuna")


def changed(robot: ht.Robot, **guidance: object) -> ht.Robot:
    document = robot.document()
    return parse(document | {"guidance": document["guidance"] | guidance})


def test_the_table_has_the_speeds_of_the_description(robot: ht.Robot) -> None:
    table = gait_table(robot)
    assert robot.guidance is not None
    assert table.speed == robot.guidance.speed
    assert table.gaits == tuple(ht.named_gait(robot, name) for name in robot.guidance.gaits)


def test_gaits_from_elsewhere_swim_as_fast_as_they_do(robot: ht.Robot) -> None:
    gaits = [ht.named_gait(robot, name) for name in ("unoptimised-0.3", "unoptimised-0.4")]
    table = gait_table(robot, gaits)
    speeds = [ht.swim(robot.using(joints="bandwidth"), gait).speed for gait in gaits]
    assert table.speed == pytest.approx(speeds, rel=1e-9)  # rounded


@pytest.mark.parametrize(
    ("names", "speed", "said"),
    [
        (["unoptimised-0.4", "unoptimised-0.3"], (), "increase in speed"),
        (["unoptimised-0.4", "unoptimised-0.3"], (0.2, 0.3), "increase in frequency"),
        (["unoptimised-0.3"], (0.2, 0.3), "one speed per gait"),
        (["unoptimised-0.3"] * 13, (0.3,) * 13, "1 to 12 gaits"),
    ],
)
def test_a_table_that_cannot_be_looked_up_is_refused(
    robot: ht.Robot, names: list[str], speed: tuple[float, ...], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        gait_table(robot, [ht.named_gait(robot, name) for name in names], speed)


def test_a_table_has_as_many_gaits_as_the_core_takes(robot: ht.Robot) -> None:
    assert robot.guidance is not None
    gait = ht.named_gait(robot, robot.guidance.gaits[0])
    gaits = [replace(gait, frequency=1 + 0.1 * k) for k in range(_core.MAX_GAITS + 1)]
    speed = [0.1 + 0.01 * k for k in range(len(gaits))]
    assert len(gait_table(robot, gaits[:-1], speed[:-1]).gaits) == _core.MAX_GAITS
    with pytest.raises(InputError, match=f"must have 1 to {_core.MAX_GAITS} gaits"):
        gait_table(robot, gaits, speed)


def test_the_glide_by_hand(robot: ht.Robot) -> None:
    """A straight body is slowed by 1/2 rho sum(c_f S) u^2: over a way of m / (1/2 rho c_f S) by a factor e."""
    lumped, links = robot.water.lumped, robot.links
    assert lumped is not None
    mass = sum(m * (1 + c) for m, c in zip(links.mass, lumped.added_mass, strict=True))
    drag = 500 * sum(c * s for c, s in zip(lumped.friction, links.wetted_area, strict=True))
    assert glide(robot) == pytest.approx(mass / drag, rel=1e-9)


def test_curvature_is_that_of_a_swim(robot: ht.Robot) -> None:
    """Nearly in proportion to the bias: half of the bias bends the path half as much, to a tenth."""
    table = gait_table(robot)
    whole = curvature(robot, table, (0.14, 0.21))
    assert curvature(robot, table, (0.07, 0.105)) == pytest.approx(whole / 2, rel=0.1)


def test_the_battery_that_the_pilot_counts_on(robot: ht.Robot) -> None:
    """Four cells from 3.0 to 4.2 V, 95 % usable: empty at 12.24 V; what is drawn through 0.14 ohm drops some."""
    columns = pilot_columns(robot)
    assert robot.guidance is not None
    assert robot.battery is not None
    power = robot.guidance.power
    drawn = power / 0.9 + robot.battery.electronics  # behind the converter, and beside it
    assert columns["battery_empty"][0] == pytest.approx(4 * (3.0 + 0.05 * 1.2))
    assert columns["battery_span"][0] == pytest.approx(0.95 * 4.8)
    assert columns["battery_drop"][0] == pytest.approx(0.14 * drawn / 14.4)
    assert columns["endurance"][0] == pytest.approx(47.9 * 3600 / drawn, rel=0.03)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"gaits": ["unoptimised-0.3", "nobody"], "speed_m_s": [0.2, 0.3]}, "must be a known gait"),
        ({"speed_m_s": [0.3]}, "one per gait, but is 1 long"),
        ({"gaits": ["unoptimised-0.3", "unoptimised-0.4"], "speed_m_s": [0.4, 0.3]}, "must rise"),
        ({"bias_max_deg": [8.0]}, "must be 2 long"),
        ({"error_near_m": 13.0}, "at most error_max_m"),
        ({"lookahead_m": 0.0}, "greater than 0"),
    ],
)
def test_what_cannot_be_used_is_told(robot: ht.Robot, change: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        changed(robot, **change)


def test_distances_to_a_fence_by_hand() -> None:
    """A rectangle 4 m by 10 m: within and outside of a side, at the height of neither corner, and off a corner."""
    fence = ((10.0, 20.0), (14.0, 20.0), (14.0, 30.0), (10.0, 30.0))
    places = np.array([[11.0, 25.0], [12.0, 28.5], [9.0, 25.0], [7.0, 16.0], [12.0, 33.0]])
    for corners in (fence, fence[::-1]):
        distance = fence_distance(Mission((Waypoint(12.0, 25.0, 1.0, 0.3, 2.0),), fence=corners), places)
        np.testing.assert_allclose(distance, [1.0, 1.5, -1.0, -5.0, -3.0])
    assert fence_distance(Mission((Waypoint(12.0, 25.0, 1.0, 0.3, 2.0),)), places).tolist() == [math.inf] * 5


@pytest.mark.parametrize(
    ("second", "crossing"),
    [
        (((0.0, 2.0), (2.0, 0.0)), True),
        (((0.0, 0.5), (1.0, 2.0)), False),  # both ends on one side
        (((1.0, 1.0), (3.0, 0.0)), True),  # one touches the other
        (((3.0, 3.0), (4.0, 4.0)), False),  # on the same line
    ],
)
@pytest.mark.parametrize("shift", [(0.0, 0.0), (10.0, -7.0), (-3.0, 5.0)])
def test_segments_cross_wherever_they_are(
    second: tuple[tuple[float, float], tuple[float, float]], crossing: bool, shift: tuple[float, float]
) -> None:
    (a, b), (c, d) = (
        tuple((p[0] + shift[0], p[1] + shift[1]) for p in segment) for segment in (((0.0, 0.0), (2.0, 2.0)), second)
    )
    for one, other in (((a, b), (c, d)), ((c, d), (a, b)), ((b, a), (d, c))):
        assert cross(one, other) == crossing


def test_decisions_divide_the_control_rate(robot: ht.Robot) -> None:
    columns = pilot_columns(robot)  # ten decisions a second, of a hundred ticks
    assert (columns["every"], columns["tick"], columns["period"]) == ([10.0], [0.01], [0.1])
    with pytest.raises(InputError, match=r"divide controller\.rate_hz"):
        pilot_columns(changed(robot, decisions_hz=30.0))


def test_a_robot_without_pilot_is_told_what_it_lacks() -> None:
    with pytest.raises(InputError, match="guidance"):
        pilot_columns(ht.load("rexeel"))


def test_a_period_belongs_to_a_position(robot: ht.Robot) -> None:
    assert pilot_sensor_columns(robot)["fix_every"] == [100.0]
    document = robot.document()
    document["sensors"][0]["period_s"] = 1.0
    with pytest.raises(InputError, match="belongs to quantity = 'position'"):
        parse(document)


def test_sensors_of_the_way_can_fail(robot: ht.Robot) -> None:
    known = channels(robot, pilot=True)
    assert known["field"][1] - known["field"][0] == 2
    assert known["position"][1] - known["position"][0] == 1
    (fault,) = faults("depth:stuck@5", robot, pilot=True)
    assert fault[1:3] == known["depth"]
    assert "depth" not in channels(ht.load("rexeel"), pilot=True)


def test_pulses_of_a_pilot_that_dives_and_turns(robot: ht.Robot) -> None:
    """It faces east (the field, north, is to port) and is commanded north, below: tail to port, fins down in front.

    On one heading, a compass that is off looks like a current: so it swims north before it turns, and then dives.
    """
    mission = Mission(waypoints=(Waypoint(0, 30, 2, 0.3, 2),))
    columns = controller_columns(robot)
    pilot = _core.Pilot(_core.LiveController(columns), pilot_columns(robot), mission_columns(mission))
    draw = np.random.default_rng(1)
    # Body axes: x toward the tail, y to starboard, z up.
    begin, end, speed, tick_s = 2000, 3500, 0.3, 0.01  # ticks of the turn to starboard; m/s
    place = np.zeros(2)
    for tick in range(7150):
        turned = math.pi / 2 * min(1, max(0, (tick - begin) / (end - begin)))  # from north to east
        rate = -math.pi / 2 / ((end - begin) * tick_s) if begin < tick < end else 0.0
        place += speed * tick_s * np.array([math.sin(turned), math.cos(turned)])
        field = [-0.5 * math.cos(turned), -0.5 * math.sin(turned), CALM["field"][2]]
        readings = CALM | {"field": field, "rate": [0.0, 0.0, rate]}
        noisy = {name: (at + 1e-4 * draw.standard_normal(len(at))).tolist() for name, at in readings.items()}
        row = pilot.fly(noisy | ({"fix": place.tolist()} if tick % 100 == 0 else {}))
    assert row["mode"] == "transit"
    assert row["reasons"] == []
    # What the fixes tell of compass and current together may turn it by some hundredths.
    assert row["facing"] == pytest.approx([1, 0, 0], abs=0.05)
    assert row["bias"][0] < -0.1
    assert row["fin"][0] < -0.3
    low, high = columns["pulse_min"][0], columns["pulse_max"][0]
    assert all(low <= pulse <= high for pulse in row["pulse"])


def test_the_page_has_every_mode_and_reason() -> None:
    text = PAGE.read_text()
    rows = [f"| `{name}` | {sentence} |" for name, sentence in _core.reason_table()]
    assert [row for row in rows if row not in text] == []
    assert [name for name, _ in _core.mode_table() if f"`{name}`" not in text] == []


def test_headings_are_learned_from_field_and_gravity(robot: ht.Robot) -> None:
    """At any heading and a pitch of 10 degrees the attitude is there from the first tick on."""
    for heading in np.arange(0, 2 * math.pi, 0.7):
        attitude = frames.attitude_of(roll=0.05, pitch=math.radians(10), heading=heading)
        r = frames.rotation_of(attitude)
        field = r.T @ [0, math.cos(1), -math.sin(1)]
        mission = Mission(waypoints=(Waypoint(0, 30, 2, 0.3, 2),))
        controller = _core.LiveController(controller_columns(robot))
        pilot = _core.Pilot(controller, pilot_columns(robot), mission_columns(mission))
        row = pilot.fly(CALM | {"acceleration": (9.81 * r[2]).tolist(), "field": field.tolist()})
        assert abs(np.dot(row["quaternion"], attitude)) == pytest.approx(1, abs=1e-9)
