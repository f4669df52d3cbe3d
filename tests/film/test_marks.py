"""Films of dots and tags that are drawn from a motion: their centers, and the trials that they give."""

import json
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from film.marked import SLOW, WIDE, dotted, spot, tagged, write_colors
from film.rendered import write_film
from film.small import DEPTH, ROBOT, beating, camera, fish
from hypertuna.cli.main import app
from hypertuna.errors import InputError
from hypertuna.film.camera import write_camera
from hypertuna.film.marks import Marks, points_of
from hypertuna.film.source import open_film
from hypertuna.trials.marker_import import ChainOptions, fit_markers
from hypertuna.trials.markers import markers_of

DOTS = np.linspace(0.01, 0.29, 8)  # m from the nose
TAGS = {3: 0.02, 7: 0.07, 8: 0.13, 11: 0.19, 12: 0.24, 20: 0.28}


def slow(t):
    return beating(t, speed=0.45)


def near(t):
    pose, angle = beating(t, speed=0.25)
    return pose - [0.32, 0.03, 0.0], angle


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A film of dots and one of tags, their places and cameras."""
    place = tmp_path_factory.mktemp("marks")
    write_colors(place / "dots.mp4", dotted(slow, DOTS, SLOW))
    write_colors(place / "tags.mp4", tagged(near, TAGS.values(), WIDE, TAGS, count=24))
    for name, places in (("dots", {f"d{k}": at for k, at in enumerate(DOTS)}), ("tags", TAGS)):
        lines = ["marker,from_nose_m", *(f"{marker},{at}" for marker, at in places.items())]
        (place / f"{name}.csv").write_text("\n".join(lines) + "\n")
    write_camera(camera(SLOW), place / "camera.toml", "a camera")
    return place


def found(path, marks, eye=SLOW, **options):
    return points_of(ht.load(ROBOT), open_film(path, **options), camera(eye), DEPTH, marks, lambda done, total: None)


@pytest.mark.parametrize(("kind", "spots", "eye", "motion"), [("dots", DOTS, SLOW, slow), ("tags", TAGS, WIDE, near)])
def test_centers_and_angles_are_those_of_the_motion(folder, kind, spots, eye, motion) -> None:
    points = found(folder / f"{kind}.mp4", Marks(kind, places=folder / f"{kind}.csv"), eye)
    at = [*spots.values()] if kind == "tags" else spots
    truth = np.array([[spot(fish(), *motion(t), one)[0] for one in at] for t in points.time])
    off = (points.place - truth) / camera(eye).pixel_size([eye.size[0] / 2, eye.size[1] / 2], DEPTH)
    assert np.isnan(off).mean() < 0.05
    assert np.sqrt(np.nanmean(off**2, axis=(0, 2))).max() < 0.5  # px
    run = fit_markers(ht.load(ROBOT), markers_of(points), ChainOptions(folder / f"{kind}.csv"))
    angle = np.array([motion(t)[1] for t in run.markers.time])
    own = np.concatenate(run.stretches)
    assert len(own) > 0.8 * len(points.time)
    z = (run.fit.angle - angle)[own] / run.fit.sd[own, 3:]
    assert 0.6 < np.sqrt(np.mean(z**2)) < 1.7  # the noise that the chain finds is that of the centers
    assert np.degrees(np.sqrt(np.median((run.fit.angle - angle)[own] ** 2, axis=0))).max() < 1


def test_dots_are_ordered_from_the_nose_without_places(folder) -> None:
    """By the motion, for equal distances tell nothing."""
    points = found(folder / "dots.mp4", Marks("dots"))
    assert points.names == tuple(f"dot{k}" for k in range(1, 9))
    nose = slow(float(points.time[5]))[0][:2]
    assert np.linalg.norm(points.place[5, 0] - nose) < 0.015


def test_a_missing_dot_is_a_missing_point(tmp_path) -> None:
    def hidden(k, dot):
        return dot == 4 and 20 <= k < 30

    write_colors(tmp_path / "missing.mp4", dotted(slow, DOTS, SLOW, hidden=hidden))
    points = found(tmp_path / "missing.mp4", Marks("dots"))
    lost = np.isnan(points.place[..., 0])
    assert lost[20:30, 4].all()
    assert lost[:, :6].sum() <= 12
    truth = np.array([spot(fish(), *slow(t), DOTS[4])[0] for t in points.time])
    assert np.nanmax(np.linalg.norm(points.place[:, 4] - truth, axis=1)) < 0.003


def test_dots_that_touch_are_told(tmp_path) -> None:
    """Two dots of one color that are one in the picture have no places."""

    def still(t):
        return slow(t)[0], np.zeros(3)

    spots = np.array([0.02, 0.07, 0.12, 0.17, 0.22, 0.28])
    films = [[*dotted(still, at, SLOW, count=40)] for at in (spots, np.where(spots == 0.12, 0.161, spots))]
    write_colors(tmp_path / "touch.mp4", [*films[0][:20], *films[1][20:30], *films[0][30:]])
    points = found(tmp_path / "touch.mp4", Marks("dots"))
    assert np.isnan(points.place[20:30, 2:4]).all()
    assert "touch in 10 frames" in " ".join(points.notes)


def test_another_color_is_no_dot(tmp_path) -> None:
    """A blue hose in the picture, and red dots."""
    pictures = [*dotted(slow, DOTS, SLOW)]
    for k, picture in enumerate(pictures):
        picture[40 + k : 52 + k, 200:330] = (230, 60, 40)
    write_colors(tmp_path / "hose.mp4", pictures)
    points = found(tmp_path / "hose.mp4", Marks("dots", color="red"))
    assert points.place.shape[1] == len(DOTS)
    assert np.isfinite(points.place).mean() > 0.85


def test_what_cannot_be_tracked_is_refused(folder, tmp_path) -> None:
    write_film(tmp_path / "gray.mp4", (picture for _, picture in open_film(folder / "dots.mp4").frames()))
    for path, marks, sentence in (
        (tmp_path / "gray.mp4", Marks("dots"), "color differs"),
        (folder / "dots.mp4", Marks("tags"), "3 tags of the dictionary 4x4_50"),
        (folder / "dots.mp4", Marks("dots", color="gray"), "color"),
        (folder / "dots.mp4", Marks("dots", color="#808080"), "not a gray"),
        (folder / "dots.mp4", Marks("tags", dictionary="4x4_5"), "4x4_50"),
        (folder / "tags.mp4", Marks("tags"), "880 x 300"),
    ):
        with pytest.raises(InputError, match=sentence):
            found(path, marks)


def test_a_mirrored_film_is_told_by_its_tags(folder, tmp_path) -> None:
    write_film(tmp_path / "mirror.mp4", (picture[:, ::-1] for _, picture in open_film(folder / "tags.mp4").frames()))
    with pytest.raises(InputError, match="mirror"):
        found(tmp_path / "mirror.mp4", Marks("tags"), WIDE)
    with pytest.raises(InputError, match="is it --dictionary 4x4"):
        found(folder / "tags.mp4", Marks("tags", dictionary="6x6_50"), WIDE)


def test_command(folder, tmp_path) -> None:
    program = [sys.executable, "-m", "hypertuna", "trials", "track", str(folder / "dots.mp4"), "--robot", ROBOT]
    options = ["--camera", str(folder / "camera.toml"), "--depth", str(DEPTH), "--marks", "dots"]
    more = ["--places", str(folder / "dots.csv"), "-o", str(tmp_path / "run.toml"), "--json"]
    more += ["--overlay", str(tmp_path / "overlay.mp4")]
    ran = subprocess.run([*program, *options, *more], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    record = json.loads(ran.stdout)["runs"][0]
    assert record["markers"] == [f"d{k}" for k in range(8)]
    assert (tmp_path / "run.svg").exists()
    green = [(picture[..., 1].astype(int) - picture[..., 2] > 60).sum()
             for _, picture in open_film(tmp_path / "overlay.mp4").colors()]  # fmt: skip
    assert len(green) == 60
    assert min(green) > 100
    entry = tomllib.loads((tmp_path / "run.toml").read_text())["recordings"][0]
    assert len(entry["joints"]["noise_deg"]) == 3
    assert "slow motion" not in ran.stdout
    for option, sentence in ((["--sections", "s.csv"], "--sections is for outlines"),
                             (["--scale", "fish"], "--scale cannot be the fish's with --marks")):  # fmt: skip
        ran = subprocess.run([*program, *options, *more, *option], capture_output=True, text=True, check=False)
        assert ran.returncode == 2
        assert sentence in ran.stderr


def test_a_beat_that_the_robot_does_not_make_is_told(folder, tmp_path) -> None:
    line = ["trials", "track", f"{folder}/dots.mp4", "--robot", ROBOT, "--camera", f"{folder}/camera.toml"]
    line += ["--depth", f"{DEPTH}", "--marks", "dots", "--places", f"{folder}/dots.csv", "--frame-rate", "240"]
    result = CliRunner().invoke(app, [*line, "-o", f"{tmp_path}/run.toml", "--json"], catch_exceptions=False)
    told = " ".join(json.loads(result.stdout)["runs"][0]["warnings"])
    assert "the beat of 14 Hz is outside the robot's 0.5 to 4 Hz: is the film slow motion" in told


def test_commands_of_the_page_run(folder, tmp_path, monkeypatch) -> None:
    text = (Path(ROBOT).parents[1] / "docs/film.md").read_text().replace("\\\n", " ")
    commands = [line.split() for line in text.splitlines() if line.startswith("hypertuna") and "--marks" in line]
    assert len(commands) == 2
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROBOT, tmp_path)
    for command, eye in zip(commands, (SLOW, WIDE), strict=True):
        write_camera(camera(eye), tmp_path / "camera.toml", "a camera")
        for name in (command[3], command[command.index("--places") + 1]):
            shutil.copy(folder / name, tmp_path)
        result = CliRunner().invoke(app, command[1:])
        assert result.exit_code == 0, result.output


@pytest.mark.parametrize("option", [["--dot-color", "red"], ["--places", "dots.csv"], ["--tail-first"]])
def test_an_option_of_marks_is_refused_for_an_outline(folder, option: list[str]) -> None:
    line = ["trials", "track", f"{folder}/dots.mp4", "--robot", str(ROBOT), "--camera", f"{folder}/camera.toml"]
    with pytest.raises(InputError, match=f"^{option[0]} is used only with --marks: add --marks dots or --marks tags"):
        CliRunner().invoke(app, [*line, "-o", f"{folder}/run.toml", *option], catch_exceptions=False)
