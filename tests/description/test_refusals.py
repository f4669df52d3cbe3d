"""Robot descriptions: what is refused, and the sentence that says why."""

import pickle
import re
from pathlib import Path
from typing import Any

import pytest

from eel_file import edited
from hypertuna.description.robot import load, parse
from hypertuna.description.schema.control import Controller, Guidance
from hypertuna.errors import InputError

ROOT = Path(__file__).parents[2]

# What is changed in the file, and the whole sentence that comes back.
BAD = [
    (
        "mass_kg = [0.5, 0.3, 0.1]",
        "mass_kg = [0.5, -0.3, 0.1]",
        "links.mass_kg[1] must be greater than 0, but is -0.3: give the mass of each link [kg].",
    ),
    (
        "length_m = 0.6",
        "length_m = 0.7",
        "links.length_m must add up to body.length_m = 0.7, but is 0.6 in all: correct the links or the body length.",
    ),
    (
        "mass_kg = 1.0",
        "mass_kg = 0.8",
        "links.mass_kg must add up to at most body.mass_kg = 0.8, but is 0.9 in all: "
        "correct the links or the mass of the whole robot.",
    ),
    (
        "mass_kg = 1.0",
        "mass_kg = 0.001",
        "links.mass_kg must add up to at most body.mass_kg = 0.001, but is 0.9 in all: "
        "correct the links (in g?) or the mass of the whole robot.",
    ),
    ("com_m = [", "con_m = [", "links.con_m is not a known key: did you mean com_m?"),
    ("bandwidth_hz", "bandwith_hz", "joints[0].bandwith_hz is not a known key: did you mean bandwidth_hz?"),
    ("[gaits.wave]", "[gait.wave]", "gait is not a known key: did you mean gaits?"),
    (
        "[0.0, 90.0]",
        "[0.0, 90.0]\nzzz = 1",
        "gaits.wave.zzz is not a known key: use one of frequency_hz, amplitude_deg, phase_deg, bias_deg.",
    ),
    (
        "length_m = [0.3, 0.2, 0.1]",
        "length_m = [0.3, 0.3]",
        "links.length_m must be 3 long, one value per link, as in the other columns, but is 2 long: give 3 values.",
    ),
    (
        "mass_kg = [0.5, 0.3, 0.1]",
        "mass_kg = [0.5, 0.3]",
        "links.mass_kg must be 3 long, one value per link in links.length_m, but is 2 long: give 3 values.",
    ),
    (
        "drag_normal = [2.0, 2.0, 2.0]",
        "drag_normal = [2.0]",
        "water.strip.drag_normal must be 3 long, one value per link, but is 1 long: give 3 values.",
    ),
    (
        "amplitude_deg = [10.0, 20.0]",
        "amplitude_deg = [10.0]",
        "gaits.wave.amplitude_deg must be 2 long, one value per joint group, but is 1 long: give 2 values.",
    ),
    (
        "density_kg_m3 = 1000.0",
        "density_kg_m3 = nan",
        "water.density_kg_m3 must be a finite number, but is nan: give the density of the water [kg/m^3].",
    ),
    (
        "com_m = [0.15, 0.1",
        "com_m = [0.15, inf",
        "links.com_m[1] must be a finite number, but is inf: "
        "give the distance of each center of mass from the link's front end [m].",
    ),
    (
        "com_m = [0.15, 0.1",
        "com_m = [0.15, 0.3",
        "links.com_m[1] must lie inside the link, at most its length_m = 0.2, but is 0.3: "
        "measure the center of mass from the link's front end in m.",
    ),
    (
        "frequency_hz = 1.0",
        "frequency_hz = 0",
        "gaits.wave.frequency_hz must be greater than 0, but is 0: give the beat frequency [Hz].",
    ),
    (
        "frequency_hz = 1.0",
        'frequency_hz = "fast"',
        "gaits.wave.frequency_hz must be a number, but is 'fast': give the beat frequency [Hz].",
    ),
    (
        "frequency_hz = 1.0",
        "frequency_hz = true",
        "gaits.wave.frequency_hz must be a number, but is true: give the beat frequency [Hz].",
    ),
    (
        "links = [1]",
        "links = 1",
        "joints[0].links must be a list, but is 1: give the links whose front joints this group bends.",
    ),
    (
        "[body]\nlength_m = 0.6\nmass_kg = 1.0",
        "body = 3",
        "body must be a table, but is 3: give the table of the whole robot's dimensions and mass.",
    ),
    (
        "density_kg_m3 = 1000.0",
        "density_kg_m3 = 0",
        "water.density_kg_m3 must be greater than 0, but is 0: give the density of the water [kg/m^3].",
    ),
    (
        "links = [2]",
        "links = [3]",
        "joints[1].links[0] must be a link from 1 to 2, but is 3: "
        "joint i sits at the front end of link i, and link 0 is the head.",
    ),
    (
        "links = [2]",
        "links = [2, 1]",
        "joints[1].links[1] must be in one joint group only, but is 1, which joints[0] has too: remove it from one.",
    ),
    (
        "links = [2]",
        "links = [2]\nshare = [0.5]",
        "joints[1].share must add up to 1, but is 0.5 in all: leave share out for equal shares.",
    ),
    (
        "links = [2]",
        "links = [2]\nshare = [0.5, 0.5]",
        "joints[1].share must be 1 long, one value per link of the group, but is 2 long: give 1 value.",
    ),
    (
        'name = "rear"',
        'name = "front"',
        "joints[1].name must be unique, but is 'front': give each its own name.",
    ),
    (
        "amplitude_max_deg = 30.0",
        "amplitude_max_deg = 200.0",
        "joints[1].amplitude_max_deg must be at most 180, but is 200.0: give the largest commanded amplitude [deg].",
    ),
    (
        'water = "strip"',
        'water = "stripe"',
        "model.water must be 'lumped', 'strip' or 'elongated', but is 'stripe': give the law of the water forces.",
    ),
    (
        'water = "strip"',
        'water = "lumped"',
        "model.water must be a law with coefficients, but is 'lumped': "
        "add the table [water.lumped] or choose another law in [model].",
    ),
    (
        'water = "strip"',
        'water = "strip"\njoints = "bandwidth"',
        "joints[1].bandwidth_hz is missing for model.joints = 'bandwidth': "
        "give it in Hz, or choose joints = 'ideal' in [model].",
    ),
    (
        '"links.com_m"',
        '"links.con_m"',
        'sources."links.con_m" must be a key with a value: did you mean links.com_m?',
    ),
    (
        "[gaits.wave]",
        '[gaits."0.5 Hz"]\nbias_deg = ["left", 0.0]',
        "gaits.\"0.5 Hz\".bias_deg[0] must be a number, but is 'left': give the mean angle of each joint group [deg].",
    ),
    (
        "links = [2]",
        "links = []",
        "joints[1].links must not be empty, but is []: give the links whose front joints this group bends.",
    ),
    (
        '"measured"',
        '""',
        "sources.links must not be empty, but is '': give the source of each value, by key or the start of a key.",
    ),
    (
        'water = "strip"',
        'water = "strip"\njoints = "rigid"',
        "model.joints must be 'ideal' or 'bandwidth', but is 'rigid': "
        "give the model of the joints, without or with the lag of their bandwidth.",
    ),
    (
        "drag_tangential =",
        "cross_flow = 1\ndrag_tangential =",
        "water.strip.cross_flow must be true or false, but is 1: "
        "give the form of the normal drag: v_n |v| if true, v_n |v_n| if false.",
    ),
    ("format = 1", "format = 2", "format must be 1, but is 2: give the version of this format, 1."),
    (
        "mass_kg = [0.5, 0.3, 0.1]",
        "mass_kg = [0.5, 0.3, 1e-322]",
        "links.inertia_kg_m2[2] must be positive and finite, but is 0, from m l^2/12: "
        "correct the link's mass and length.",
    ),
]


@pytest.mark.parametrize(("old", "new", "sentence"), BAD)
def test_bad_input_gives_one_sentence(old: str, new: str, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "eel.toml"
    file.write_text(edited(old, new))
    with pytest.raises(InputError) as caught:
        load(file)
    assert str(caught.value) == f"{file}: {sentence}"
    assert caught.value.file == str(file)
    assert caught.value.key
    assert sentence.startswith(caught.value.key)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (
            "lever_m = 0.0130",
            "lever_m = 10.0",
            "joints[0].actuator.lever_m must be less than the smallest semi_minor_m",
        ),
        ("\nbore_m = 0.0045", "\nbore_m = 4.0", "joints[0].line.bore_m must be less than length_m = 0.08"),
        ("\nbore_m = 0.0045", "\nbore_m = 0.06", "joints[0].line.bore_m must be less than 0.04488, the width of the"),
        ("\nbore_m = 0.018", "\nbore_m = 20.0", "pump.bore_m must be less than body.length_m = 0.52"),
        ("outer_diameter_m = 0.004", "outer_diameter_m = 5.0", "drive_unit.outer_diameter_m must be less than 0.04488"),
        ("[0.05775, ", "[57.75, ", "joints[0].actuator.semi_major_m[0] must be less than body.length_m = 0.52"),
    ],
)
def test_what_does_not_fit_into_the_body_was_written_in_mm(old: str, new: str, sentence: str, tmp_path: Path) -> None:
    text, file = (ROOT / "robots" / "hypertuna.toml").read_text(), tmp_path / "tuna.toml"
    assert old in text
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load(file)
    assert str(caught.value).startswith(f"{file}: {sentence}")
    assert "in m" in str(caught.value)


def test_both_values_of_a_rule_are_in_the_unit_of_the_file(tmp_path: Path) -> None:
    text, file = (ROOT / "robots" / "hypertuna.toml").read_text(), tmp_path / "tuna.toml"
    file.write_text(text.replace("pulse_min_us = 800.0", "pulse_min_us = 1800.0"))
    with pytest.raises(
        InputError, match="pulse_min_us must be less than pulse_center_us = 1500, but is 1800: exchange"
    ):
        load(file)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    missing, folder, binary, broken, huge = (tmp_path / f"{name}.toml" for name in ("m", "f", "b", "t", "h"))
    folder.mkdir()
    binary.write_bytes(b"\xff\xfe\x00")
    broken.write_text("format = 1\nname =\n")
    huge.write_text(f"format = {'9' * 10_000}\n")
    for path, rule in (
        (missing, "does not exist"),
        (folder, "is a folder"),
        (binary, "must be readable"),
        (broken, "must be valid TOML, but is not (Invalid value (at line 2, column 7))"),
        (huge, "must be valid TOML"),
    ):
        with pytest.raises(InputError) as caught:
            load(path)
        assert str(caught.value).startswith(f"{path} {rule}")


def test_an_unknown_robot_gets_the_nearest_name() -> None:
    with pytest.raises(InputError, match=r"^robots/hypertona\.toml does not exist: did you mean hypertuna\?$"):
        load("hypertona")


def test_an_error_survives_the_way_between_processes() -> None:
    error = InputError("must be greater than 0", file="a.toml", key="k", value="-1", fix="raise it")
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.key) == ("a.toml: k must be greater than 0, but is -1: raise it.", "k")


@pytest.mark.parametrize("name", ["$", "a/b", "[/b]", "a\0b", "\x1b[31m", "k" * 100_000, ""])
def test_names_that_files_figures_or_terminals_cannot_hold_are_refused(name: str) -> None:
    """Names of robot, links, joints, gaits and materials; other texts only without control characters."""
    plain = load("hypertuna").document()
    changes: list[tuple[str, Any]] = [
        ("name", name),
        ("links", plain["links"] | {"name": [name, *plain["links"]["name"][1:]]}),
        ("joints", [plain["joints"][0] | {"name": name}, *plain["joints"][1:]]),
        ("gaits", plain["gaits"] | {name: plain["gaits"]["turning"]}),
        ("materials", plain["materials"] | {name: next(iter(plain["materials"].values()))}),
    ]
    if "\0" in name or "\x1b" in name or len(name) > 60:
        changes.append(("description", name))
    for key, value in changes:
        with pytest.raises(InputError) as caught:
            parse(plain | {key: value})
        sentence = str(caught.value)
        assert key in sentence
        assert re.search("must be (1 to 60 letters|at most 20000 characters)|must not be empty", sentence)
        assert len(sentence) < 1000
        assert not {"\0", "\x1b"} & set(sentence)


@pytest.mark.parametrize(
    ("table", "former", "present"), [(t.table, *pair) for t in (Controller, Guidance) for pair in t.renamed.items()]
)
def test_a_renamed_key_is_refused_with_its_new_name(table: str, former: str, present: str) -> None:
    document = load("hypertuna").document()
    document[table][former] = document[table].pop(present)
    with pytest.raises(InputError, match=rf"^{table}.{former} was renamed: write {present}\.$"):
        parse(document)
