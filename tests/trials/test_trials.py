"""Manifests of tracked runs, published folders, trials of both, and the errors of bad ones."""

import json
import math
import runpy
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.cli.main import app
from hypertuna.description.changes import changed
from hypertuna.description.validation import nested_model
from hypertuna.trials.importers import import_folder
from hypertuna.trials.manifest import Manifest, parse_manifest, read_manifest
from hypertuna.trials.plausibility import implausible_runs
from hypertuna.trials.trials import Trials, read_trials
from told import told, tried, write

TANK = Path(__file__).parents[2] / "examples" / "tank"
HEAD = "frequency_hz,amplitude_I_deg,amplitude_II_deg,phase_II_deg,speed_m_s"


# Manifests


def document():
    """The manifest of the example."""
    return tomllib.loads((TANK / "tank.toml").read_text())


def parsed(whole, robot, folder=TANK):
    return Trials(parse_manifest(whole, robot, folder=folder, file="tank.toml"))


def test_manifest_of_the_example(tuna):
    trials = read_trials(TANK / "tank.toml", tuna)
    assert len(trials.steady) == 24
    (recording,) = trials.recordings
    assert trials.runs[-4:] == ("tank.csv:26", "start/a", "start/b", "start/c")
    assert recording.noise == pytest.approx(math.radians(0.1))
    assert recording.joints.angle.shape == (201, 2)
    first = recording.tracks[0]
    assert first.pose[0] == pytest.approx([0.5, 1.0, math.radians(10)])  # the start given, not the frame tracked
    assert first.pose[1] == pytest.approx([0.49928, 0.99840, math.radians(10.301)])
    nose = 0.5 + 0.281 / 2 * math.cos(math.radians(10))  # half a head's length ahead
    assert recording.start.x == pytest.approx(nose)


@pytest.mark.parametrize(("file", "column"), [("poses.csv", "x_mm"), ("poses.csv", "run"), ("angles.csv", "joint_II")])
def test_a_column_that_is_there_twice_is_refused(tuna, tmp_path, file, column):
    """Others, which nothing reads, may be."""
    for name in ("tank.toml", "tank.csv", "angles.csv", "poses.csv"):
        (tmp_path / name).write_text((TANK / name).read_text())
    lines = (TANK / file).read_text().splitlines()
    for extra, word in ((column, f"{file}: column {column} must be there once, but is there 2 times"), ("unused", "")):
        first = next(k for k, line in enumerate(lines) if not line.startswith("#"))
        again = [line + (f",{extra},{extra}" if k == first else ",0,0") for k, line in enumerate(lines)]
        again[first] = f"{lines[first]},{extra}" + (",unused" if word else f",{extra}")
        write(tmp_path / file, *lines[:first], *again[first:])
        trials, sentence = tried(read_trials, tmp_path / "tank.toml", tuna)
        assert word in sentence
        assert (trials is None) == bool(word)


def test_example_is_what_its_script_makes(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["make.py", str(tmp_path)])
    runpy.run_path(str(TANK / "make.py"))
    for name in ("tank.csv", "angles.csv", "poses.csv"):
        made, kept = ((folder / name).read_text().splitlines() for folder in (tmp_path, TANK))
        assert made[:2] == kept[:2]
        for ours, theirs in zip(made[2:], kept[2:], strict=True):
            for a, b in zip(ours.split(","), theirs.split(","), strict=True):
                assert a == b or float(a) == pytest.approx(float(b), abs=0.011)  # the last digit that is written


def test_first_frame_without_a_start_and_a_frame_that_turns_clockwise(tuna):
    whole = document()
    del whole["recordings"][0]["start"]
    plain = parsed(whole, tuna).recordings[0].tracks[0]
    assert plain.pose[0] == pytest.approx([0.50122, 0.99887, math.radians(9.832)])
    whole["recordings"][0]["poses"] |= {"yaw_zero_deg": 90.0, "clockwise": True}
    whole["recordings"][0]["start"] = {"x_m": 0.5, "y_m": 1.0, "yaw_deg": 450.0}
    compass = parsed(whole, tuna).recordings[0].tracks[0]
    assert compass.pose[1:, 2] == pytest.approx(math.pi / 2 - plain.pose[1:, 2])
    assert compass.pose[0, 2] == pytest.approx(0)  # 90 - 450 = -360 deg, but no whole turn before the second frame


def test_window_and_clock(tuna):
    """Of joints logged from 0 to 2 s, half a second before the poses' clock: 0.5 to 2.5 s there."""
    whole = document()
    del whole["recordings"][0]["start"]
    whole["recordings"][0] |= {"time_offset_s": 0.5, "window_s": [0.6, 1.5]}
    (recording,) = parsed(whole, tuna).recordings
    assert recording.joints.time[[0, -1]] == pytest.approx([0.1, 1.0])
    assert recording.joints.lines[0] == 13
    assert recording.tracks[2].time[[0, -1]] == pytest.approx([0.6, 1.5])


def with_recording(**changes):
    """The manifest of the example with other values in its recording, by dotted key; None removes a key."""
    whole = document()
    for key, value in changes.items():
        *tables, last = key.split("__")
        table = whole["recordings"][0]
        for name in tables:
            table = table[name]
        if value is None:
            del table[last]
        else:
            table[last] = value
    return whole


@pytest.mark.parametrize(
    ("whole", "sentence"),
    [
        ({"format": 2}, "format must be 1, but is 2: give the version of this format, 1."),
        ({"format": 1}, "steady or recordings must be given: name the files of measurements; lists are steady, tows"),
        ({"format": 1, "steddy": []}, "steddy is not a known key: did you mean steady?"),
        (
            document() | {"robot": "rexeel"},
            "robot must be the robot's name, hypertuna, but is 'rexeel': choose the robot",
        ),
        (
            with_recording(name="a/b"),
            "recordings[0].name must be a name without /, and not of dots alone, but is 'a/b'",
        ),
        (with_recording(joints__unit="grad"), "recordings[0].joints.unit must be 'deg' or 'rad', but is 'grad'"),
        (with_recording(joints__noise_deg=-0.1), "recordings[0].joints.noise_deg must not be negative"),
        (
            with_recording(joints__columns=["joint_I"]),
            "the number of recordings[0].joints.columns must be 2, one per joint group",
        ),
        (with_recording(start__y_m=1e300), "recordings[0].start.y_m must be at most 1e12, but is 1e+300"),
        (with_recording(joints__clock="t"), "recordings[0].joints.clock is not a known key"),
        (
            with_recording(poses__length_unit=None),
            "recordings[0].poses.length_unit is missing: give the unit of x and y",
        ),
        (with_recording(poses__files=[]), "recordings[0].poses.files must not be empty"),
        (with_recording(poses__files=["poses.csv"] * 2), "recordings[0]: run a must be unique, but is in two files"),
        (with_recording(poses__clockwise="no"), "recordings[0].poses.clockwise must be true or false, but is 'no'"),
        (
            with_recording(window_s=[2.0, 1.0]),
            "recordings[0].window_s must be two times, the first earlier, but is [2.0",
        ),
        (with_recording(window_s=[1.0]), "recordings[0].window_s must be two times"),
        (
            with_recording(window_s=[5.0, 9.0]),
            f"{TANK}/angles.csv: the series must overlap the window, 5 to 9 s of the",
        ),
        (
            with_recording(time_offset_s=9.0, window_s=None),
            "recordings[0]: run a must have at least two frames, the second",
        ),
        (with_recording(time_offset_s="1"), "recordings[0].time_offset_s must be a number, but is '1': give the time"),
        (with_recording(repeats=0), "recordings[0].repeats must be greater than 0, but is 0: give the number of swims"),
        (
            with_recording(start__yaw_deg=None),
            "recordings[0].start.yaw_deg is missing: give the direction that the head",
        ),
        (
            with_recording(joints__file="angels.csv"),
            f"{TANK}/angels.csv must be a file, but is missing: check the path.",
        ),
        (with_recording(joints__columns=["joint_I", "joint_2"]), f"{TANK}/angles.csv: column joint_2 must be a column"),
        (
            document() | {"recordings": document()["recordings"] * 2},
            "recordings[1].name must be unique, but is 'start'",
        ),
    ],
)
def test_bad_manifests_are_reported(tuna, whole, sentence):
    assert told(parsed, whole, tuna).removeprefix("tank.toml: ").startswith(sentence)


def test_broken_toml_is_reported(tmp_path, tuna):
    path = write(tmp_path / "tank.toml", "format = 1", "steady = [")
    assert told(read_manifest, path, tuna).startswith(
        f"{path} must be valid TOML, but is not (Invalid value (at end of"
    )
    write(path, "format = 0x" + "f" * 5000)
    assert told(read_manifest, path, tuna).startswith(
        f"{path} must be valid TOML, but is not (a number of more than 100 digits)"
    )


KEYS = [
    "format",
    "robot",
    "steady",
    "recordings",
    "name",
    "joints",
    "poses",
    "start",
    "window_s",
    "repeats",
    "file",
    "unit",
]
VALUES = st.recursive(
    st.one_of(
        st.integers(), st.floats(), st.booleans(), st.none(), st.sampled_from(["deg", "tank.csv", "", "\0", "/"])
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.sampled_from(KEYS), inner, max_size=4)),
    max_leaves=12,
)


@given(
    value=VALUES,
    keys=st.lists(st.sampled_from(["recordings", 0, "joints", "poses", "files", "start", *KEYS]), max_size=3),
)
def test_any_document_is_trials_or_one_sentence(tuna, value, keys):
    """The manifest of the example with anything in any place."""
    whole = place = document()
    for key in keys[:-1]:
        inner = place.get(key) if isinstance(place, dict) else place[0] if key == 0 and place else None
        if not isinstance(inner, (dict, list)):
            break
        place = inner
    if isinstance(place, dict):
        place[keys[-1] if keys else "format"] = value
    trials, sentence = tried(parsed, whole, tuna)
    assert sentence or trials.runs


@given(content=st.one_of(st.binary(max_size=100), st.text(max_size=200).map(lambda s: s.encode("utf-8", "replace"))))
def test_any_bytes_are_a_manifest_or_one_sentence(tmp_path_factory, tuna, content):
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_bytes(content)
    assert str(path) in told(read_manifest, path, tuna)  # none of them is a whole manifest


# Trials


def test_runs_are_chosen_and_joined_by_name(tmp_path, tuna):
    trials = read_trials([TANK / "tank.toml"], tuna)
    some = trials.only(["start/c", "tank.csv:3", "start/a"])
    assert some.runs == ("tank.csv:3", "start/a", "start/c")
    assert trials.only(["tank.csv:3"]).recordings == ()
    other = write(tmp_path / "other.csv", HEAD, "6,16,25,40,0.58")
    assert (some + read_trials(other, tuna)).runs == ("tank.csv:3", "other.csv:2", "start/a", "start/c")
    assert told(trials.only, ["start/d"]) == "run must be a run of the trials, but is 'start/d': did you mean start/c?"
    assert "run tank.csv:3 must be unique, but is given twice" in told(
        read_trials, [TANK / "tank.csv", TANK / "tank.toml"], tuna
    )


# A published folder


@pytest.fixture
def eels(tmp_path):
    """A folder laid out as the robot eel's files are, with two swims at two amplitudes."""
    folder = tmp_path / "eels"
    folder.mkdir()
    time = np.arange(60) / 44
    joints = ",".join(f"target_{j},actual_{j}" for j in range(1, 6))
    for amplitude in (5, 10):
        bends = amplitude * np.sin(3 * time)
        rows = (f"{t:.4f},{','.join(['0', f'{a:.3f}'] * 5)},130" for t, a in zip(time, bends, strict=True))
        log = ("# a log", "", f"time_s,{joints},sample_rate_hz", *rows)
        write(folder / f"{amplitude}deg_hardware_motor_angles.csv", *log)
        head = "video,frame,timestamp,x_cm,y_cm,robot_yaw,interpolated"
        rows = (f"{v},{k},{k / 30},61,{61 + k / 10},{90 - k},0" for v in "pq" for k in range(30))
        write(folder / f"{amplitude}deg_hardware_trajectories.csv", head, *rows)
    return folder


def test_published_folder_is_read_as_it_stands(eels, tmp_path):
    eel = ht.load("rexeel")
    trials = read_trials(eels, eel)
    assert trials.runs == ("5deg/p", "5deg/q", "10deg/p", "10deg/q")
    pose = trials.recordings[0].tracks[1].pose
    assert pose[0] == pytest.approx([0.61, 0.61, math.pi / 2])  # faces +y
    assert pose[29] == pytest.approx([0.61, 0.639, math.radians(180 - 61)])  # yaw counts clockwise
    (eels / "5deg_hardware_trajectories.csv").unlink()
    assert "5deg_hardware_trajectories.csv must be there, but is missing" in told(read_trials, eels, eel)
    assert "holds no known published files: give a CSV" in told(read_trials, tmp_path, eel)
    assert "format must be a known format, but is 'eel': did you mean rexeel?" in told(import_folder, eels, "eel")
    assert "nowhere must be a folder, but is missing" in told(import_folder, tmp_path / "nowhere")


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_import_writes_a_manifest_that_finds_the_files(eels, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    eel = ht.load("rexeel")
    whole = read_trials("eels", eel)
    assert run("trials", "import", "eels", "-o", "eel.toml").output == "written: eel.toml\n"
    assert "eels/5deg_hardware_motor_angles.csv" in (tmp_path / "eel.toml").read_text()
    (tmp_path / "sub").mkdir()
    assert run("trials", "import", "eels", "-o", "sub/eel.toml").exit_code == 0
    assert f'"{eels.resolve()}/5deg' in (tmp_path / "sub" / "eel.toml").read_text()  # not below the manifest
    for path in ("eel.toml", "sub/eel.toml"):
        found = read_trials(path, eel)
        assert found.runs == whole.runs
        assert np.array_equal(found.recordings[1].tracks[0].pose, whole.recordings[1].tracks[0].pose)
    assert isinstance(run("trials", "import", ".", "-o", "none.toml").exception, ht.InputError)
    assert not (tmp_path / "none.toml").exists()


def test_check_says_what_is_there(tmp_path):
    said = json.loads(run("trials", "check", TANK / "tank.toml", "--robot", "hypertuna", "--json").output)
    assert said["valid"]
    assert said["runs"] == 27
    assert said["steady"][0] | {"swims": 72, "frequency_hz": [1, 6], "bias_II_deg": [0, 0]} == said["steady"][0]
    assert said["recordings"][0]["frames"] == [60, 60, 60]
    # From the file: three drifts with 1 deg/s and noise of 0.3 deg, about their mean.
    assert 0.1 < said["recordings"][0]["repeatability"]["yaw_deg"] < 1
    shown = run("trials", "check", TANK / "tank.toml", "--robot", "hypertuna").output
    assert "tank.csv: 24 steady runs of 72 swims" in " ".join(shown.split())  # the path may be long
    bad = run("trials", "check", write(tmp_path / "bad.csv", HEAD, "6,16,25,40,x"), "--robot", "hypertuna", "--json")
    assert isinstance(bad.exception, ht.InputError)
    assert json.loads(bad.output)["key"] == "line 2, speed_m_s"


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        ("2,16,25,0,{speed}", ""),
        ("2,16,25,0,{fast}", "the measured speeds are 100 times those of the model: check the unit, m/s."),
        ("2,16,25,0,{slow}", "the measured speeds are 1/1000 of those of the model: check the unit, m/s."),
        ("2,0.28,0.44,0,{speed}", "the largest amplitude is 0.44 deg: is it in radians? Then write 25.2."),
    ],
)
def test_check_tells_runs_that_are_far_from_the_model(row, sentence, tmp_path):
    speed = ht.swim("hypertuna", ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(0, 0))).speed
    text = row.format(speed=speed, fast=100 * speed, slow=speed / 1000)
    file = write(tmp_path / "runs.csv", HEAD, text)
    told = json.loads(run("trials", "check", file, "--robot", "hypertuna", "--json").output)["warnings"]
    assert told == ([f"{file}: {sentence}"] if sentence else [])


@pytest.mark.parametrize(("times", "kind"), [(9, ""), (11, "far"), (49, "far"), (51, "unit"), (300, "unit")])
def test_far_speeds_are_a_warning_and_those_of_another_unit_an_error(times, kind, tmp_path):
    """From 50 on, not only near 100 and 1000: no drag explains that, but cm/s beside a model wrong by 3 does."""
    tuna = ht.load("hypertuna")
    speed = ht.swim(tuna, ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(0, 0))).speed
    for factor, words in ((times, f"are {times} times"), (1 / times, f"are 1/{times} of")):
        runs = read_trials(write(tmp_path / "runs.csv", HEAD, f"2,16,25,0,{factor * speed}"), tuna).steady
        errors, warnings = implausible_runs(runs, tuna)
        assert (len(errors), len(warnings)) == (kind == "unit", kind == "far")
        for sentence in [*map(str, errors), *warnings]:
            assert f"the measured speeds {words}" in sentence
            assert ("amplitudes from peak to peak" in sentence) == (kind == "far")


def test_check_says_nothing_of_speeds_that_the_model_lacks(tmp_path, recwarn):
    stuck = changed(ht.load("hypertuna"), {"links.wetted_area_m2": [1e12] * 8})
    trials = read_trials([write(tmp_path / "runs.csv", HEAD, "2,16,25,0,0.3")], stuck)
    assert implausible_runs(trials.steady, stuck) == ([], [])
    assert not recwarn


def test_every_key_of_the_manifest_is_in_the_example():
    """So that the page that shows it shows every key; a run from rest has no velocity. Forces have a file of theirs."""
    forces, turns = (tomllib.loads((TANK / f"{name}.toml").read_text()) for name in ("forces", "turns"))

    def keys(schema, table):
        for name, field in schema.model_fields.items():
            if name == "velocity":
                continue
            assert field.alias in table, f"{schema.__name__}.{name}"
            inner = nested_model(field.annotation)
            if inner is not None:
                value = table[field.alias]
                keys(inner, value[0] if isinstance(value, list) else value)

    keys(Manifest, forces | turns | document())
