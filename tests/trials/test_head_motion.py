"""Motions that no body makes are reported in tracks of markers, and in recordings of a manifest."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.trials.trials import implausible
from program import Run

CASES = Path(__file__).parents[3] / "shared" / "cases"
THREE = str(CASES / "three.toml")
pytestmark = pytest.mark.skipif(not CASES.exists(), reason="the cases are not there")


def markers(tmp_path: Path, change) -> str:
    """Write the markers of the reference, 48 frames at 60 Hz, after a change of places (frames, markers, 2) [px]."""
    head, *rows = csv.reader((CASES / "markers-reference.csv").read_text().splitlines())
    data = np.array(rows, dtype=float)
    place = change(data[:, 1:].reshape(len(data), -1, 2).copy()).reshape(len(data), -1)
    names = ["time_s", *head[1:]]
    lines = [f"{k / 60:.4f}," + ",".join(f"{x:.1f}" for x in row) for k, row in enumerate(place)]
    (tmp_path / "a.csv").write_text("\n".join([",".join(names), *lines]).replace("nan", "") + "\n")
    return str(tmp_path / "a.csv")


def imported(run: Run, tmp_path: Path, change) -> tuple[int, str]:
    """Return exit code and all sentences of the import of changed markers."""
    words = ("--robot", THREE, "--unit", "px", "--scale", "0.001", "-o", str(tmp_path / "out.toml"), "--json")
    code, output, errors = run("trials", "import", "markers", markers(tmp_path, change), *words)
    return code, errors if code else " ".join(json.loads(output)["runs"][0]["warnings"])


def flipped(frames):
    def change(place):
        place[frames] = place[frames, ::-1]
        return place

    return change


def elsewhere(place):
    place[24:] += 500
    return place


def filled(place):
    place[20:26] = place[19]
    return place


def lines(place):
    """20 lost frames, each marker moved along a line in their place."""
    for k in range(14, 34):
        place[k] = place[13] + (place[34] - place[13]) * (k - 13) / 21
    return place


def cubic(place):
    """6 lost frames, each marker moved along the cubic through two places before and after."""
    known, lost = np.array([18, 19, 26, 27]), np.arange(20, 26)
    flat = place.reshape(len(place), -1)
    flat[lost] = np.vander(lost - 22.5, 4) @ np.linalg.solve(np.vander(known - 22.5, 4), flat[known])
    return place


def doubled(place):
    """Half of the frames, the others halfway between them."""
    place[1:-1:2] = (place[:-2:2] + place[2::2]) / 2
    return place


def raised(factor):
    """Frames of a film at a lower rate, repeated, and tracked again with an error of 0.1 px where they are many."""

    def change(place):
        frames = (np.floor(np.arange(len(place)) / factor) * factor).astype(int)
        return place[frames] + (factor == 2) * np.random.default_rng(0).normal(0, 0.1, place.shape)

    return change


def resting(place):
    """As at rest before it begins: the body's first place, to the pixel, repeats."""
    place[:10] = place[10]
    return place


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (flipped(range(20, 32)), "the head flips between 0.3167 and 0.3333 s, the first of 2 times"),
        (elsewhere, "the head leaps away between 0.3833 and 0.4000 s: another animal is taken"),
        (lambda place: place - place[:, :1], "stands still while others move: are the places from it, or is the fish"),
        (lambda place: place - place.mean(axis=1, keepdims=True), "the mean of the markers stands still while others"),
        (lambda place: place[[*range(40), *[39] * 8]], "8 frames repeat the one before: are lost ones filled in"),
        (filled, "6 frames repeat the one before: are lost ones filled in"),
        (lines, "20 frames lie on straight lines or cubics between others: are lost ones filled in?"),
        (doubled, "frames lie midway between others, as if the frame rate was raised 2 times: track the film"),
        (raised(2), "frames repeat the one before, as if the frame rate was raised 2 times: track the film"),
        (raised(4), "frames repeat the one before, as if the frame rate was raised 4 times"),
        (raised(2.5), "frames repeat the one before, as if the frame rate was raised 2.5 times"),
        (raised(1.2), "7 frames repeat the one before: are lost ones filled in, or was the frame rate raised?"),
        (cubic, "8 frames lie on straight lines or cubics between others: are lost ones filled in?"),
    ],
)
def test_jumps_of_the_head_and_filled_frames_are_told(run: Run, tmp_path: Path, change, sentence: str) -> None:
    code, warnings = imported(run, tmp_path, change)
    assert (code, sentence in warnings) == (0, True), warnings


@pytest.mark.parametrize("change", [lambda place: place, resting])
def test_a_right_track_has_no_doubts(run: Run, tmp_path: Path, change) -> None:
    assert imported(run, tmp_path, change)[1].count("the head ") == 0
    assert not any(word in imported(run, tmp_path, change)[1] for word in ("repeat", "straight lines", "raised"))


def test_a_head_that_flips_again_and_again_is_refused(run: Run, tmp_path: Path) -> None:
    code, errors = imported(run, tmp_path, flipped(np.random.default_rng(1).random(48) < 0.3))
    assert (code, "the head must go on from frame to frame, but is flipping" in errors) == (2, True), errors


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("", "", ""),
        ('length_unit = "m"', 'length_unit = "mm"', "hardly moves"),
        ('angle_unit = "deg"', 'angle_unit = "rad"', "yaws faster than any head"),
        ('unit = "deg"', 'unit = "rad"', "bend by less than half a turn"),
        ('angle_unit = "deg"', 'angle_unit = "deg"\nyaw_zero_deg = 180.0', "moves tail first all the time"),
        ('angle_unit = "deg"', 'angle_unit = "deg"\nyaw_zero_deg = 90.0', "moves to its side all the time"),
        ('angle_unit = "deg"', 'angle_unit = "deg"\nclockwise = true', "yaws against the model, with the joint angles"),
        ("joints", "radians", "are the angles in radians?"),
        ("poses", "millimeters", "lengths a second: check length_unit"),
        ("poses", "centimeters", "of the robot's lengths a beat, more than any swimmer: check length_unit"),
    ],
)
def test_a_manifest_in_other_units_is_unlikely(run: Run, tmp_path: Path, old: str, new: str, sentence: str) -> None:
    assert imported(run, tmp_path, lambda place: place)[0] == 0
    path = tmp_path / "out.toml"
    factors = {"radians": np.pi / 180, "millimeters": 1000.0, "centimeters": 10.0}
    if factor := factors.get(new):
        table = tmp_path / f"a-{old}.csv"
        columns = slice(1, None) if new == "radians" else slice(1, 3)
        comment, head, *rows = table.read_text().splitlines()
        values = np.array([row.split(",") for row in rows], dtype=float)
        values[:, columns] *= factor
        table.write_text("\n".join([comment, head, *(",".join(f"{x:.7g}" for x in row) for row in values)]) + "\n")
    elif new:
        path.write_text(path.read_text().replace(old, new, 1))
    code, output, errors = run("trials", "check", str(path), "--robot", THREE, "--json")
    assert code == 0, errors
    warnings = json.loads(output)["warnings"]
    assert (len(warnings), sentence in " ".join(warnings)) == (bool(sentence), True), warnings


def test_a_turn_against_the_model_is_told(tmp_path: Path) -> None:
    """A circle by biased joints, whose log has the bias of the other sign: the beats of the yaw agree, the turn not."""
    fish, time = ht.load("hypertuna"), np.arange(241) / 60
    wave = np.radians([10, 20]) * np.sin(2 * np.pi * 2 * time[:, np.newaxis] - np.array([0, 0.6]))
    bias = np.radians([4, 8])
    swim = ht.replay(fish, ht.smooth(ht.JointSeries(time, wave + bias), noise=0.0))
    poses = np.column_stack([time, *(np.interp(time, swim.time, swim[key]) for key in ("x", "y"))])
    yaw = np.interp(time, swim.time, np.unwrap(swim["heading"])) + np.pi
    np.savetxt(tmp_path / "poses.csv", np.column_stack([poses, yaw]), "%.6f", ",", header="time_s,x,y,yaw", comments="")
    manifest = """format = 1
[[recordings]]
name = "circle"
begin = "rest"
joints = {file = "joints.csv", columns = ["a", "b"], unit = "rad", noise_deg = 0.0}
poses = {files = ["poses.csv"], x = "x", y = "y", yaw = "yaw", length_unit = "m", angle_unit = "rad"}
"""
    (tmp_path / "a.toml").write_text(manifest)
    for sign, sentence in ((1, False), (-1, True)):
        joints = np.column_stack([time, wave + sign * bias])
        np.savetxt(tmp_path / "joints.csv", joints, "%.6f", ",", header="time_s,a,b", comments="")
        _, warnings = implausible(ht.read_trials([tmp_path / "a.toml"], fish), fish)
        assert ("turns against the model" in " ".join(warnings)) == sentence, (yaw[-1] - yaw[0], warnings)
