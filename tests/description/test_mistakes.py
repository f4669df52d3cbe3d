"""All mistakes of a robot file in one answer, and only those that are in it."""

import pickle
import tomllib

import pytest

from hypertuna.description.new import new_robot
from hypertuna.description.robot import load, parse
from hypertuna.errors import InputError, InputErrors
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.swim import swim

FIRST = """
format = 1
name = "first"

[body]
length_m = 300
mass_kg = 0.5

[links]
lenght_m = [0.15, 0.075, 0.075]
mass_kg = [0.3, -0.1, 0.05]
com_m = [0.07, 0.03]
lateral_area_m2 = [0.01, 0.005, "0.004"]

[[joints]]
name = "front"
link = [1]

[[joints]]
name = "rear"
links = [3]
bandwidth_hz = "5"

[model]
water = "stripe"
joints = "bandwidth"

[water]
density = 1000

[water.strip]
drag_normal = [1.4, 1.5]

[gaits.cruise]
frequency_hz = 2
amplitude_deg = [15]
"""
FOUND = {
    "links.lenght_m": "is not a known key",
    "joints[0].link": "is not a known key",
    "water.density": "is not a known key",
    "links.mass_kg[1]": "must be greater than 0",
    "links.lateral_area_m2[2]": "must be a number",
    "joints[1].bandwidth_hz": "must be a number",
    "model.water": "must be 'lumped', 'strip' or 'elongated'",
    "water.strip.drag_tangential": "is missing",
    "gaits.cruise.phase_deg": "is missing",
    "links.com_m": "must be 3 long",
    "links.length_m": "must add up to body.length_m = 300",
    "joints[1].links[0]": "must be a link from 1 to 2",
    "joints[0].bandwidth_hz": "is missing for model.joints = 'bandwidth'",
    "water.strip.drag_normal": "must be 3 long",
    "gaits.cruise.amplitude_deg": "must be 2 long",
}
MENDED = {
    "length_m = 300": "length_m = 0.3",
    "lenght_m": "length_m",
    "-0.1, 0.05": "0.1, 0.05",
    "com_m = [0.07, 0.03]": "com_m = [0.07, 0.03, 0.03]",
    '"0.004"': "0.004",
    "link = [1]": "links = [1]\nbandwidth_hz = 5",
    "links = [3]": "links = [2]",
    '"5"': "5",
    "stripe": "strip",
    "density =": "density_kg_m3 =",
    "[1.4, 1.5]": "[1.4, 1.5, 1.3]",
    "[15]": "[15, 20]",
}


def mistakes_of(text: str) -> InputErrors:
    """The errors of a robot's text."""
    with pytest.raises(InputErrors) as caught:
        parse(tomllib.loads(text), file="first.toml")
    return caught.value


def test_a_long_list_of_mistakes_ends() -> None:
    errors = mistakes_of(FIRST + "".join(f"unknown_{k} = 1\n" for k in range(60)))
    lines = [line for line in str(errors).splitlines() if line.startswith("  ")]
    assert lines[14].startswith("  15. ")
    assert lines[15] == f"  and {len(errors.errors) - 15} more, which often follow from these"


def test_values_beyond_measure_are_refused() -> None:
    document = new_robot("first")
    document["links"]["lateral_area_m2"][0] = 1e30
    with pytest.raises(InputError) as errors:
        parse(document, file="first.toml")
    assert "first.toml: links.lateral_area_m2[0] must be at most 1e12, but is 1e+30: give the" in str(errors.value)


def test_one_answer_has_all_mistakes_and_lets_a_newcomer_mend_them() -> None:
    errors = mistakes_of(FIRST)
    assert {
        error.key: error.rule for error in errors.errors if FOUND[str(error.key)] in error.rule
    }.keys() == FOUND.keys()
    assert len(errors.errors) == len(FOUND)
    told = str(errors)
    assert told.startswith(f"first.toml has {len(FOUND)} mistakes:\n  1. links.lenght_m is not a known key")
    text = FIRST
    for wrong, right in MENDED.items():
        assert wrong in text
        text = text.replace(wrong, right, 1)
    strip, gait = (block.split("\n", 1) for block in errors.paste.split("\n\n"))
    for head, lines in (strip, gait):  # below the header of its table
        text = text.replace(head, f"{head}\n{lines}", 1)
    assert parse(tomllib.loads(text)).links.wetted_area[0] == pytest.approx(2.55 * 0.01)


NEARLY_EMPTY = {
    "": {},
    'format = 1\nname = "perch"': {},
    "[body]\nmass_kg = 2.0\nlength_m = 0.45": {"length": 0.45, "mass": 2.0},
    "[body]\nmas_kg = 0.85\nlength_m = 0.3": {"mass": 0.85},
    "[links]\nlength_m = [0.2, 0.05, 0.05, 0.05]": {"links": 4},
    "[link]\nlenght_m = [0.2, 0.05, 0.05, 0.05]\nmass_kg = [0.7, 0.1, 0.1, 0.1]": {"links": 4, "mass": 1.0},
    'name = "perch"\n[[joint]]\nname = "tail"\nlinks = [1, 2]': {"groups": ["tail"]},
    "[watr]\ndensity_kg_m3 = 1025": {},
}


@pytest.mark.parametrize("text", NEARLY_EMPTY)
def test_of_a_nearly_empty_file_a_whole_robot_is_to_paste_that_swims(text: str) -> None:
    errors = mistakes_of(text)
    assert errors.whole
    robot = parse(tomllib.loads(errors.paste))
    told = {"links": len(robot.links.length), "groups": [group.name for group in robot.joints]}
    told |= {"length": robot.body.length, "mass": robot.body.mass, "links": len(robot.links.length)}
    assert NEARLY_EMPTY[text] == {key: pytest.approx(told[key]) for key in NEARLY_EMPTY[text]}
    assert swim(robot, named_gait(robot, "cruise")).settled
    assert "drive_unit" not in errors.paste
    assert len(errors.paste.splitlines()) < 66


def test_the_file_to_paste_is_that_of_robot_new() -> None:
    document = new_robot("first")
    del document["sources"], document["uncertainty"]
    assert tomllib.loads(mistakes_of("").paste) == document


def test_missing_keys_of_a_joint_group_say_which_one() -> None:
    document = new_robot("fish", links=4)
    del document["joints"][1]["links"]
    with pytest.raises(InputErrors) as caught:
        parse(document)
    assert "into [[joints]] number 2\nlinks = [2]" in str(caught.value)


def test_every_key_that_a_table_lacks_is_in_the_block() -> None:
    document = load("hypertuna").document()
    gone = {key: document["guidance"].pop(key) for key in ("lookahead_m", "turn_max_deg_s", "bias_max_deg")}
    del document["controller"]
    with pytest.raises(InputErrors) as caught:
        parse(document | {"controller": {}})
    block = tomllib.loads(caught.value.paste)
    assert block["guidance"] == gone
    assert block["controller"].items() <= load("hypertuna").document()["controller"].items()
    assert len(block["controller"]) == 14


def test_a_pair_without_its_second_value_is_told() -> None:
    """A missing value of a list has no key to paste."""
    document = load("hypertuna").document()
    document["gait_bounds"]["amplitude_deg"][0] = [0.0]
    with pytest.raises(InputError, match=r"gait_bounds.amplitude_deg\[0\]\[1\] is missing"):
        parse(document)


def test_errors_survive_the_way_between_processes() -> None:
    errors = mistakes_of(FIRST)
    assert str(pickle.loads(pickle.dumps(errors))) == str(errors)
