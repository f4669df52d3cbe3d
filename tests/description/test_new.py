"""First robots: what `robot new` writes is valid, its own arithmetic, and swims."""

import math
import tomllib
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, reject, settings
from hypothesis import strategies as st

from hypertuna.actuation.new import first_robot
from hypertuna.description.drag import NOSES
from hypertuna.description.inversion import inversion_speed
from hypertuna.description.new import new_robot, shape_of
from hypertuna.description.plausibility import implausible
from hypertuna.description.robot import load, parse
from hypertuna.description.schema.body import DRIVES
from hypertuna.description.shape import Shape, link_columns, link_lengths
from hypertuna.description.writer import robot_text
from hypertuna.errors import InputError
from hypertuna.firmware.header import header
from hypertuna.firmware.parameters import firmware_table
from hypertuna.mission.file import read_mission
from hypertuna.mission.flight import fly
from hypertuna.simulation.dive import dive
from hypertuna.simulation.twin import twin
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.swim import swim

SIZES = [(2, 0.3, 0.85), (3, 0.3, 0.85), (5, 0.3, 0.85), (4, 0.1, 0.02), (3, 1.5, 60.0), (12, 0.6, 1.0)]


@pytest.mark.parametrize(("links", "length", "mass"), SIZES)
def test_a_first_robot_is_sourced_and_swims(links: int, length: float, mass: float) -> None:
    document = new_robot("fish", links=links, length=length, mass=mass)
    text = first_robot("fish", links=links, length=length, mass=mass)
    assert tomllib.loads(text) == document
    robot = parse(document)
    assert robot.unsourced() == ()
    assert robot.body.length == pytest.approx(length)
    assert math.fsum(robot.links.mass) == pytest.approx(mass)
    result = swim(robot, named_gait(robot, "cruise"))
    assert result.settled
    # Robots of published size swim at 0.2 to 1 lengths per second (HyperTuna: 0.57 at 2 Hz); large ones at less.
    assert 0.1 < result.speed / length * math.sqrt(length / 0.3) < 1.2


def test_a_fin_has_the_added_mass_of_a_plate() -> None:
    """That of aspect ratio 2 has 0.757 rho pi/4 chord^2 span (DNV-RP-C205), where its sections have chord span^2."""
    shape = Shape.of(0.3, 0.85, fin_span=0.06, fin_chord=0.03)
    links, strip = link_columns(shape, (0.27, 0.03), friction=0.01, beating=0.0)
    assert links["wetted_area_m2"][1] == pytest.approx(2 * links["lateral_area_m2"][1], rel=1e-3)  # both sides
    assert strip["added_mass_normal"][1] == pytest.approx(0.757 * 0.03 / 0.06, rel=1e-3)


def test_the_shape_floats_and_has_published_proportions() -> None:
    shape = Shape.of(0.52, 2.687)  # HyperTuna without what is in no link
    places, height, width = shape.sections(0.0, 0.52)
    body = places < 0.85 * 0.52
    volume = np.where(body, math.pi / 4 * height * width, height * width).mean() * 0.52
    assert 1000 * volume == pytest.approx(2.687, rel=1e-3)
    assert 0.10 < shape.height < 0.16  # head 0.12 m, fin 0.16 m
    assert shape.fin_aspect == pytest.approx(shape.height / (0.15 * 0.52 * (1 + 0.342) / 2), rel=0.01)


@pytest.mark.parametrize(
    "sizes",
    [
        {"height": 0.07},
        {"width": 0.05},
        {"height": 0.07, "width": 0.05},
        {"height": 0.07, "mass": 0.6},
        {"width": 0.05, "mass": 0.6},
        {"fin_span": 0.09, "mass": 0.6},
        {"fin_span": 0.09, "fin_chord": 0.03},
        {"fin_chord": 0.05, "height": 0.07},
    ],
)
def test_own_sizes_are_kept_and_the_others_make_a_fish_that_floats(sizes: dict[str, float]) -> None:
    shape, lengths = shape_of(length=0.3, **sizes)  # type: ignore[arg-type]
    robot = parse(new_robot("fish", length=0.3, **sizes))  # type: ignore[arg-type]
    for name, size in sizes.items():
        assert getattr(shape, name, size) == size
    assert shape.buoyancy == pytest.approx(1.0, abs=0.03)  # the rest is the fin's plate, and mass to three digits
    assert math.fsum(robot.links.mass) == pytest.approx(shape.mass)
    assert robot.water.strip is not None
    assert robot.water.strip.edge_height == pytest.approx(sizes.get("fin_span", shape.height), rel=6e-3)
    if {"fin_span", "fin_chord"} <= {*sizes}:
        assert shape.fin_aspect == pytest.approx(sizes["fin_span"] / sizes["fin_chord"])
    _, height, width = shape.sections(0.0, shape.fin_start * 0.3)
    assert (height.max(), width.max()) == pytest.approx((shape.height, shape.width), rel=0.01)
    assert lengths == link_lengths(3, 0.3)


@settings(max_examples=60, deadline=None)
@given(
    size=st.fixed_dictionaries(
        {
            "links": st.integers(2, 20),
            "length": st.floats(0.03, 10.0),
            "nose": st.sampled_from(sorted(NOSES)),
        }
    ),
    parts=st.fixed_dictionaries(
        {},
        optional={
            "mass": st.floats(1.0, 100.0),
            "height": st.floats(0.03, 0.45),
            "width": st.floats(0.02, 0.5),
            "fin_span": st.floats(0.02, 0.6),
            "fin_chord": st.floats(0.01, 0.4),
        },
    ),
)
@example({"links": 3, "length": 1.0, "nose": "robot"}, {"fin_span": 0.6, "fin_chord": 0.01})
def test_no_first_robot_is_unlikely(size: Any, parts: dict[str, float]) -> None:
    length = size["length"]
    own: Any = {key: part * (length**3 if key == "mass" else length) for key, part in parts.items()}
    try:
        robot = parse(new_robot("fish", **size, **own))
    except InputError:
        reject()
    assert implausible(robot) == []
    assert robot.unsourced() == ()


@pytest.mark.parametrize("actuation", DRIVES)
@pytest.mark.parametrize("length", [0.2, 0.3, 1.5])
def test_no_first_robot_with_an_actuator_is_unlikely(actuation: str, length: float) -> None:
    text = first_robot("fish", length=length, actuation=actuation, sea=True, width=0.14 * length, fin_span=0.3 * length)
    assert implausible(parse(tomllib.loads(text))) == []


def test_factors_of_estimates_are_kept_and_checked(tmp_path: Path) -> None:
    document = new_robot("fish")
    robot = parse(document)
    assert robot.uncertainty == document["uncertainty"]
    assert tomllib.loads(robot_text(robot)) == document
    bare = {key: value for key, value in document.items() if key != "uncertainty"}
    assert parse(bare).uncertainty is None
    for key, factor in document["uncertainty"].items():
        assert (robot.source(key) or "").endswith(document["sources"][key].partition("in 90 %")[2])
        assert f"within a factor of {factor:g} in 90 % of cases" in document["sources"][key]
    with pytest.raises(InputError, match=r"water\.strip\.blunt_area.*must be a key with a value.*blunt_area_m2"):
        parse(document | {"uncertainty": {"water.strip.blunt_area": 2.0}})
    for factor in (0.5, 1e3):
        with pytest.raises(InputError, match="uncertainty.* must be at (least 1|most 100), but is"):
            parse(document | {"uncertainty": {"water.strip": factor}})


def test_a_factor_of_a_measured_value_is_told() -> None:
    document = new_robot("fish")
    document["sources"]["water.strip.blunt_area_m2"] = "measured, towed at three speeds"
    (told,) = implausible(parse(document))
    assert told.startswith("uncertainty has a factor for water.strip.blunt_area_m2, whose source is no estimate")


def test_joint_groups_share_the_links_head_to_tail() -> None:
    robot = new_robot("fish", links=6, joints=["front", "rear"])
    assert [(group["name"], group["links"]) for group in robot["joints"]] == [("front", [1, 2]), ("rear", [3, 4, 5])]
    assert all(a < b for a, b in pairwise(robot["gaits"]["cruise"]["amplitude_deg"]))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"links": 1}, "--links must be from 2 to 20, but is 1: a head, and one link behind each joint."),
        ({"length": 300.0}, "--length must be from 0.03 to 10 m, but is 300: give the length of the robot in m."),
        (
            {"mass": 850.0},
            "--mass must make a fish from 0.03 to 0.45 times as high as long at neutral buoyancy, but is 850",
        ),
        ({"height": 60.0}, "--height must be from 0.009 to 0.135 m, but is 60: give it in m; it is taken for a robot"),
        ({"fin_chord": 0.2}, "--fin-chord must be from 0.003 to 0.12 m, but is 0.2: give it in m"),
        ({"height": 0.05, "mass": 5.0}, "--mass must make a body from 0.15 to 2 times as wide as high at neutral"),
        ({"height": 0.05, "width": 0.04, "mass": 5.0}, "--mass must be from 0.33 to 3 times that of the water in its"),
        ({"nose": "round"}, "--nose must be streamlined, robot or blunt, but is 'round'"),
        ({"joints": ["a", "a"]}, "--joints must be at most 2 different names"),
        ({"joints": ["a", "b", "c"]}, "--joints must be at most 2 different names"),
    ],
)
def test_what_is_no_fish_is_refused(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        new_robot("fish", **options)
    assert str(caught.value).startswith(sentence)


@pytest.mark.parametrize("actuation", DRIVES)
@pytest.mark.parametrize(("links", "length", "mass"), [(2, 0.3, 0.85), (3, 0.5, 2.5), (5, 0.3, 0.4)])
def test_a_first_robot_with_an_actuator_runs_in_the_twin(
    actuation: str, links: int, length: float, mass: float
) -> None:
    text = first_robot("fish", links=links, length=length, mass=mass, actuation=actuation)
    robot = parse(tomllib.loads(text))
    assert robot.unsourced() == ()
    gait = named_gait(robot, "cruise")
    assert swim(robot, gait).settled
    run = twin(robot, gait, duration=5.0)
    assert run.status == "completed"
    reached = (np.ptp(run.data["angle"][300:], axis=0)) / 2
    assert reached == pytest.approx(gait.amplitude, rel=0.3)


@pytest.mark.parametrize("actuation", DRIVES)
def test_a_first_robot_at_sea_dives_flies_a_mission_and_has_firmware(actuation: str) -> None:
    robot = parse(tomllib.loads(first_robot("fish", actuation=actuation, sea=True)))
    assert (robot.unsourced(), implausible(robot)) == ((), [])
    assert "namespace" in header(firmware_table(robot))
    down = dive(robot, "cruise", duration=12.0)
    assert down.run.status == "completed"
    assert down.legs[0].right  # dives with its fins down
    assert fly(read_mission("box"), robot, duration=20.0).status == "given up"  # out of time


def test_a_first_robot_at_sea_dives_and_rises_below_the_frequency_of_its_cruise() -> None:
    # Ballast a twelfth of the height below the middle let it roll at 1.5 Hz: by 16 deg, and fins up took it down.
    robot = parse(tomllib.loads(first_robot("fish", length=0.35, mass=0.9, actuation="servo", sea=True)))
    cruise = named_gait(robot, "cruise")
    down, up = dive(robot, replace(cruise, frequency=1.5), duration=24.0).legs
    assert (down.right, up.right) == (True, True)


@pytest.mark.parametrize(
    ("links", "length", "actuation", "nose"),
    [
        (2, 0.3, "servo", "streamlined"),
        (2, 1.0, "hydraulic", "blunt"),
        (3, 0.3, "hydraulic", "robot"),
        (3, 0.55, "servo", "streamlined"),
        (3, 1.0, "servo", "robot"),
        (4, 0.3, "servo", "streamlined"),
        (4, 0.55, "hydraulic", "blunt"),
        (5, 0.3, "servo", "robot"),
        (5, 1.0, "servo", "blunt"),
    ],
)
def test_first_robots_at_sea_dive_and_rise_by_their_fins(links: int, length: float, actuation: str, nose: str) -> None:
    # With the gait of a robot without fins, the streamlined ones of servos rose with their fins down.
    text = first_robot("fish", links=links, length=length, actuation=actuation, nose=nose, sea=True)
    robot = parse(tomllib.loads(text))
    for gait in ("slow", "cruise"):
        done = dive(robot, gait, duration=60 / named_gait(robot, gait).frequency, depth=5.0)
        assert [leg.right for leg in done.legs] == [True, True]
        assert max(leg.roll_max for leg in done.legs) < math.radians(15)
    assert swim(robot, "cruise").speed <= 0.65 * inversion_speed(robot)


def test_turns_of_a_first_robot_are_not_taken_for_a_lost_fin() -> None:
    # At 1.5 deg, as HyperTuna's, three of four flights ended by the heel of a full turn, up to 2.7 deg.
    document = tomllib.loads(first_robot("fish", length=0.42, mass=1.2, actuation="servo", sea=True))
    robot, mission = parse(document), read_mission("box")
    legs = [point._replace(speed=0.22) for point in mission.mission.waypoints]
    slow = replace(mission, mission=replace(mission.mission, waypoints=legs, home_speed=0.22, duration=1800.0))
    sound, broken = fly(slow, robot), fly(slow, robot, faults=["fin-port:level@150"])
    assert sound.status == "done"
    assert [name for name in sound.record.first_reasons if "fin" in name] == []
    assert "port_fin_lost" in broken.record.first_reasons


@pytest.mark.parametrize("actuation", DRIVES)
def test_the_pilot_of_a_first_robot_steers_within_its_bends_and_on_its_own_scales(actuation: str) -> None:
    document = tomllib.loads(first_robot("fish", actuation=actuation, sea=True))
    pilot, amplitude = document["guidance"], document["gaits"]["cruise"]["amplitude_deg"]
    for bias, swing, group in zip(pilot["bias_max_deg"], amplitude, document["joints"], strict=True):
        assert 0 < bias <= swing / 2 + 0.05
        assert swing + bias <= group["bend_max_deg"] + 0.05
    speed = swim(parse(document), named_gait(parse(document), "cruise")).speed
    # as HyperTuna at its slowest gait: 25 s to answer to the fins, steering from 0.1 m/s
    tuna = load("hypertuna")
    assert tuna.guidance is not None
    assert tuna.guidance.speed is not None
    faster = speed / tuna.guidance.speed[0]
    assert pilot["response_time_s"] == pytest.approx(25 / faster, rel=0.06)
    assert pilot["speed_min_m_s"] == pytest.approx(0.1 * faster, rel=0.06)
    heavier = parse(document).body.mass / tuna.body.mass
    assert pilot["power_w"] == pytest.approx(tuna.guidance.power * heavier, rel=0.06)


def test_a_robot_at_sea_needs_an_actuation_and_pins() -> None:
    with pytest.raises(InputError, match="--sea needs an actuation: add --actuation servo"):
        first_robot("fish", sea=True)
    for actuation in ("servo", "hydraulic"):
        with pytest.raises(InputError, match="--joints must be at most 12 joint groups with --sea, but is 13"):
            first_robot("fish", links=14, actuation=actuation, sea=True)
    document = tomllib.loads(first_robot("fish", links=5, actuation="servo", sea=True))
    assert len(document["firmware"]["servo_pins"]) == 4 + 2  # the fins have one each
    parse(document)


@pytest.mark.parametrize(("actuation", "most"), [("servo", 4), ("hydraulic", 3)])
def test_a_robot_at_sea_has_the_firmware_that_a_board_has_room_for(actuation: str, most: int) -> None:
    for groups in (most, most + 1):
        document = tomllib.loads(first_robot("fish", links=groups + 1, actuation=actuation, sea=True))
        assert ("firmware" in document) is (groups == most) is ("firmware" in document["sources"])
        assert document["guidance"]["bias_max_deg"]


def test_lengths_of_links_are_kept() -> None:
    document = new_robot("fish", lengths=[0.14, 0.09, 0.09], mass=0.9)
    assert document["links"]["length_m"] == [0.14, 0.09, 0.09]
    assert document["sources"]["links.length_m"].startswith("as given")
    with pytest.raises(InputError, match=r"--lengths must be greater than 0, but is 0"):
        new_robot("fish", lengths=[0.1, 0])


def test_a_robot_of_servos_has_a_battery_of_two_cells_and_limits_to_match() -> None:
    document = tomllib.loads(first_robot("fish", length=0.32, mass=0.9, actuation="servo", sea=True))
    battery = document["battery"]
    assert (battery["cells"], battery["series"], battery["voltage_v"]) == (2, 2, 3.7)
    assert "converter_v" not in battery
    empty, low = document["firmware"]["voltage_empty_v"], document["controller"]["voltage_low_v"]
    assert 2 * 3.2 <= empty < low < 2 * battery["voltage_v"]


@pytest.mark.parametrize("actuation", ["none", "servo", "hydraulic"])
def test_what_a_robot_lacks_at_sea_is_what_the_command_writes(actuation: str) -> None:
    robot = parse(tomllib.loads(first_robot("fish", length=0.32, mass=0.9, actuation=actuation)))
    with pytest.raises(InputError) as caught:
        firmware_table(robot)
    assert "[guidance], [firmware], [[sensors]] for" in str(caught.value)
    assert "hypertuna robot new fish-sea.toml --lengths 0.16,0.08,0.08 --mass 0.9" in str(caught.value)
    sea = (
        {}
        if actuation == "none"
        else tomllib.loads(first_robot("fish-sea", lengths=[0.16, 0.08, 0.08], mass=0.9, actuation=actuation, sea=True))
    )
    document = robot.document()
    for table in ("guidance", "gaits", "firmware", "sensors") if sea else ():
        document[table] = sea[table]
    if sea:
        assert "namespace" in header(firmware_table(parse(document)))
