"""Robot descriptions: what is read, with defaults, units and sources; the reference of all keys."""

import copy
import math
import pickle
import tomllib
from pathlib import Path

import pytest
from figures_reference import reference

from eel_file import EEL, edited
from hypertuna.description import plausibility, robot
from hypertuna.description import reference as page
from hypertuna.description.reference import json_schema, keys
from hypertuna.description.robot import Robot, cached, load, parse
from hypertuna.description.schema.base import Part, entry
from hypertuna.errors import InputError

ROOT = Path(__file__).parents[2]


def test_defaults_and_units() -> None:
    eel = parse(tomllib.loads(EEL))
    assert eel.links.inertia == pytest.approx([0.5 * 0.3**2 / 12, 0.3 * 0.2**2 / 12, 0.1 * 0.1**2 / 12])
    assert eel.joints[0].share == (1.0,)
    assert eel.joints[1].amplitude_max == pytest.approx(math.pi / 6)
    assert eel.gaits["wave"].phase[1] == pytest.approx(math.pi / 2)
    assert eel.gaits["wave"].bias == (0.0, 0.0)
    assert eel.water.strip is not None
    assert eel.water.strip.linear_normal == (0.0, 0.0, 0.0)
    assert load("hypertuna").battery.capacity == 3.5 * 3600  # type: ignore[union-attr]


def test_a_choice_of_model_is_replaced_and_checked() -> None:
    fish = load("hypertuna")
    assert fish.using() is fish
    ideal = fish.using(joints="ideal")
    assert (ideal.model.joints, ideal.model.water, ideal.file) == ("ideal", fish.model.water, fish.file)
    assert ideal.using(joints=fish.model.joints).hash == fish.hash != ideal.hash
    with pytest.raises(InputError, match=r"model\.areas must be 'consistent' or 'as-printed', but is 'printed'"):
        fish.using(areas="printed")


def test_the_hash_is_that_of_what_can_change_a_result() -> None:
    def hash_of(text: str) -> str:
        return parse(tomllib.loads(text), file="any").hash

    same = (
        edited("[body]", "# a comment\n[body]"),
        edited("length_m = 0.6", "length_m = 6e-1"),
        edited("three links", "an eel"),
        edited("measured", "guessed"),
        edited("links = [2]", "links = [2]\nshare = [1.0]"),
    )
    other = (edited("90.0", "91.0"), edited("drag_normal = [2.0", "drag_normal = [2.1"), edited('"eel"', '"fish"'))
    assert {hash_of(text) for text in same} == {hash_of(EEL)}
    assert len({hash_of(text) for text in (EEL, *other)}) == 1 + len(other)


def test_a_source_covers_what_is_below_it() -> None:
    eel = parse(tomllib.loads(EEL))
    assert eel.source("links.mass_kg[1]") == "measured"
    assert eel.source("links.com_m") == "estimate: middle"
    assert eel.source("linksandmore") is None
    assert [entry.key for entry in eel.entries() if entry.estimate] == ["links.com_m"]
    assert "water.density_kg_m3" in eel.unsourced()
    assert "links.mass_kg" not in eel.unsourced()
    inertia = next(entry for entry in eel.entries() if entry.key == "links.inertia_kg_m2")
    assert (inertia.default, inertia.source) == (True, "default: a slender rod's m l^2/12")


def test_every_key_says_how_to_find_its_value() -> None:
    found = keys()
    assert [key.key for key in found if not key.how] == []
    by_name = {key.key: key.how for key in found}
    assert by_name["joints.line.bore_m"] == "data sheet of the hose, or a drill bit as gauge"
    assert by_name["oil.density_kg_m3"] == "data sheet of the oil"  # as the table says
    assert by_name["joints.servo.torque_n_m"] == "data sheet of the servo"
    for table in ("model", "water", "spatial"):  # "handbook for the shape" stood nine times in one of them
        hints = [key.how for key in found if key.key.startswith(f"{table}.") and not key.key.startswith("water.lumped")]
        assert len(hints) - len(set(hints)) <= 1, table  # one tow gives two of them


def test_a_key_is_declared_in_one_place(monkeypatch: pytest.MonkeyPatch) -> None:
    class Tow(Part, table="tow", how="tow the robot"):
        """The tow."""

        rope: float = entry("length of the rope", "m", usual=(1.0, 10.0), default=5.0)
        hook: float = entry("height of the hook", "m", how="ruler", default=0.0)

    class Towed(Robot):
        """A robot with a tow."""

        tow: Tow = entry("table of the tow", default_factory=Tow)

    for module in (page, plausibility, robot):
        monkeypatch.setattr(module, "Robot", Towed)
    rows = {key.key: key for key in keys()}
    assert rows["tow.rope_m"] == ("tow.rope_m", "m", "number", "5.0", "1 to 10", "tow the robot", "length of the rope")
    assert rows["tow.hook_m"].how == "ruler"
    assert "| `rope_m` | m | number | 5.0 | 1 to 10 | tow the robot | length of the rope |" in reference()
    assert "rope_m" in json_schema()["$defs"]["Tow"]["properties"]
    unlikely = Towed.model_validate(tomllib.loads(EEL) | {"tow": {"rope_m": 2000.0}})
    assert "tow.rope_m has 2000 m; usual are 1 to 10: is it in mm? Then write 2." in plausibility.implausible(unlikely)


def test_every_key_has_default_and_typical_value() -> None:
    by_name = {key.key: key for key in keys()}
    assert by_name["links.com_m"][3:5] == ("the middle of the link", "0.0095 to 0.1663")
    assert by_name["links.mass_kg"].default == ""
    assert by_name["joints.line.loss"][3:5] == ("0.0", "1.5")
    assert by_name["joints.servo.torque_n_m"].typical == "0.01 to 200"  # usual: HyperTuna has muscles
    without = {name.split(".")[0] for name, key in by_name.items() if not key.typical}
    assert without <= {"format", "name", "description", "uncertainty", "sources", "fit", "hinge", "hinges", "joints",
                       "water", "firmware",  # numbers of responses
                       "gait_bounds", "drive_unit", "spatial"}  # fmt: skip


def test_the_docs_page_is_the_schema() -> None:  # docs/figures.py writes the page
    assert (ROOT / "docs" / "description.md").read_text() == reference()


def test_the_json_schema_has_the_keys_of_the_file() -> None:
    schema = json_schema()
    assert set(load("hypertuna").document()) <= set(schema["properties"])
    links = schema["$defs"]["Links"]
    assert links["additionalProperties"] is False
    assert links["properties"]["mass_kg"]["unit"] == "kg"
    assert links["properties"]["mass_kg"]["items"] == {"exclusiveMinimum": 0, "maximum": 1e12, "type": "number"}
    assert "inertia_kg_m2" not in links["required"]
    undescribed = [
        (table, key)
        for table, rules in (schema["$defs"] | {"": schema}).items()
        for key, rule in rules["properties"].items()
        if not rule.get("description")
    ]
    assert undescribed == []


def test_a_robot_is_frozen() -> None:
    robot: Robot = load("rexeel")
    with pytest.raises(ValueError, match="frozen"):
        robot.body.length = 1.0


def test_what_is_built_from_a_robot_is_kept_with_that_object_alone() -> None:
    robot, same = load("hypertuna"), load("hypertuna")
    built = cached(robot, "key", object)
    assert cached(robot, "key", object) is built
    assert cached(robot, "other", object) is not built
    assert robot == same
    assert robot.document() == same.document()
    renamed = robot.model_copy(update={"name": "renamed"})
    for other in (same, renamed, pickle.loads(pickle.dumps(robot)), copy.deepcopy(robot)):
        assert cached(other, "key", object) is not built
