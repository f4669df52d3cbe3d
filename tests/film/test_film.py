"""Films that are drawn from a motion, and what is read from them."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from dataclasses import replace

import cv2
import numpy as np
import pytest

import hypertuna as ht
from film.rendered import write_film
from film.small import DEPTH, EYE, ROBOT, beating, camera, film, fish, sections
from hypertuna.errors import InputError
from hypertuna.film.camera import write_camera
from hypertuna.film.noise import beat_of
from hypertuna.film.run import track_film, write_film_run
from hypertuna.film.source import open_film
from hypertuna.film.states import BORDER, OK
from hypertuna.film.track import mean_of
from hypertuna.film.view import motion_of
from hypertuna.io.checkpoint import Journal

FISH = fish()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A film of calm water, the sections of its fish, its camera, and what it shows."""
    place = tmp_path_factory.mktemp("film")
    truth = film(place / "calm.mp4")
    sections(FISH, place / "sections.csv")
    write_camera(camera(EYE), place / "camera.toml", "a camera")
    np.save(place / "truth.npy", truth)
    return place


def rms(values):
    return np.sqrt((values**2).mean(axis=0))


def tracked(path, folder, **options):
    own = {"depth": DEPTH, "sections": folder / "sections.csv", **options}
    return track_film(ht.load(ROBOT), path, camera(EYE), **own)


@pytest.fixture(scope="module")
def run(folder):
    return tracked(folder / "calm.mp4", folder)


def test_calm_water_gives_pose_and_angles(run, folder) -> None:
    truth = np.load(folder / "truth.npy")
    assert (run.tracked.state == OK).all()
    half, length = FISH.length[0] / 2, FISH.length.sum()
    place = truth[:, :2] + half * np.stack([np.cos(truth[:, 2]), np.sin(truth[:, 2])], axis=1)
    head = np.linalg.norm(run.head[:, :2] - place, axis=1)
    assert np.sqrt((head**2).mean()) < 0.002 * length
    assert np.degrees(np.sqrt(((run.head[:, 2] - truth[:, 2] - np.pi) ** 2).mean())) < 0.3
    joints = np.degrees(rms(run.angle - truth[:, 3:]))
    assert (joints < 0.6).all()  # of a fish of 120 px
    assert run.size == pytest.approx(1, abs=0.003)


def test_the_beat_is_found(run) -> None:
    assert run.beat is not None
    assert run.beat.frequency == pytest.approx(3.5, rel=0.003)
    assert np.degrees(run.beat.amplitude) == pytest.approx([8, 14, 20], abs=0.3)


def test_frames_are_numbered_by_their_times(folder) -> None:
    source = open_film(folder / "calm.mp4")
    assert source.rate == pytest.approx(60)
    whole = dict(source.frames())
    assert list(whole) == list(range(60))
    number, picture = next(source.frames(37))
    assert number == 37
    assert (picture == whole[37]).all()


def test_files_are_those_of_markers(run, folder) -> None:
    robot = ht.load(ROBOT)
    written = write_film_run(run, robot, folder / "run.toml", "a test")
    entry = tomllib.loads((folder / "run.toml").read_text())["recordings"][0]
    assert len(entry["joints"]["noise_deg"]) == 3
    assert entry["joints"]["noise_tau_s"] > 0
    assert [os.path.basename(name) for name in written] == ["calm-joints.csv", "calm-poses.csv", "run.toml"]
    lines = (folder / "calm-joints.csv").read_text().splitlines()
    assert lines[1] == "time_s,joint_front_deg,joint_middle_deg,joint_fin_deg," + ",".join(
        f"joint_{name}_sd_deg" for name in ("front", "middle", "fin")
    )
    assert len(lines) == 62


def test_the_same_upside_down(folder, run) -> None:
    """Nose and tail are told apart by the shape and the motion, not by left and right."""
    frames = (picture[::-1, ::-1] for _, picture in open_film(folder / "calm.mp4").frames())
    write_film(folder / "turned.mp4", frames, crf=12)
    eye = replace(EYE, place=(-EYE.place[0], -EYE.place[1], EYE.place[2]))
    other = track_film(
        ht.load(ROBOT), folder / "turned.mp4", camera(eye), depth=DEPTH, sections=folder / "sections.csv"
    )
    np.testing.assert_allclose(other.head[:, :2], -run.head[:, :2], atol=1e-3)
    assert (np.degrees(rms(other.angle - run.angle)) < 1).all()


def test_a_cable_over_the_fish_does_not_matter(folder) -> None:
    truth = film(folder / "cable.mp4", cable=True)
    other = tracked(folder / "cable.mp4", folder)
    own = np.concatenate(other.stretches)
    assert len(own) > 45
    joints = np.degrees(rms((other.angle - truth[:, 3:])[own]))
    assert (joints < 1.5).all()


def test_another_fish_that_does_not_touch_does_not_matter(folder) -> None:
    def other(t):
        pose, angle = beating(t)
        return pose + np.array([0.05, -0.17, 0.0]), angle

    both = [film(folder / f"{name}.mp4", motion, noise=0.0) for name, motion in
            (("one", beating), ("other", other))]  # fmt: skip
    pictures = zip(*(open_film(folder / f"{name}.mp4").frames() for name in ("one", "other")), strict=True)
    write_film(folder / "two.mp4", (np.minimum(a, b) for (_, a), (_, b) in pictures))
    found = tracked(folder / "two.mp4", folder)
    own = found.tracked.state == OK
    assert min(np.degrees(rms((found.angle - truth[:, 3:])[own])).max() for truth in both) < 1
    assert (found.tracked.state == OK).mean() > 0.9


def refused(path, folder, sentence, **options):
    with pytest.raises(InputError, match=sentence):
        tracked(path, folder, **options)


def test_frames_at_the_border_are_left_out(folder) -> None:
    def leaving(t):
        pose, angle = beating(t)
        return pose - [0.33, 0.0, 0.0], angle

    film(folder / "leaving.mp4", leaving)
    found = tracked(folder / "leaving.mp4", folder)
    assert (found.tracked.state == BORDER).sum() > 5
    assert not (found.tracked.state[np.concatenate(found.stretches)] == BORDER).any()
    assert "not whole in the picture" in " ".join(found.warnings)

    def gone(t):
        pose, angle = beating(t)
        return pose - [0.6, 0.0, 0.0], angle

    film(folder / "gone.mp4", gone)
    refused(folder / "gone.mp4", folder, "whole|swim through")


def test_an_empty_tank_is_refused(folder) -> None:
    film(folder / "empty.mp4", lambda t: (np.array([9.0, 0.0, 0.0]), np.zeros(3)))
    refused(folder / "empty.mp4", folder, "contrast must show a fish")


def test_a_fish_that_stays_is_refused(folder) -> None:
    """The median of the frames then shows the fish itself."""
    film(folder / "stays.mp4", lambda t: beating(t, speed=0.2))
    refused(folder / "stays.mp4", folder, "swim through")


def test_a_variable_rate_is_refused(folder) -> None:
    times = np.cumsum(np.random.default_rng(0).uniform(0.008, 0.03, 40))
    film(folder / "variable.mp4", count=40, times=times)
    refused(folder / "variable.mp4", folder, "constant rate")


def test_lost_frames_keep_their_times(folder) -> None:
    times = np.delete(np.arange(60), [20, 21, 40]) / 60
    pictures = [picture for k, picture in open_film(folder / "calm.mp4").frames() if k not in (20, 21, 40)]
    write_film(folder / "lost.mp4", pictures, times=times)
    source = open_film(folder / "lost.mp4")
    np.testing.assert_allclose(source.time, times, atol=1e-4)


def test_a_fish_of_another_length_is_refused(folder) -> None:
    near = camera(replace(EYE, place=(*EYE.place[:2], 1.3)))
    with pytest.raises(InputError, match="as long as the robot"):
        track_film(ht.load(ROBOT), folder / "calm.mp4", near, depth=DEPTH, sections=folder / "sections.csv")


def test_the_own_length_mends_a_wrong_depth(folder, run) -> None:
    """The camera believes the fish at the surface: lengths by it are short, by the fish's length right."""
    wrong = tracked(folder / "calm.mp4", folder, depth=0.0)
    by_camera = tracked(folder / "calm.mp4", folder, depth=0.0, scale="camera")
    way, short, right = (np.linalg.norm(one.head[-1, :2] - one.head[0, :2]) for one in (run, by_camera, wrong))
    assert short / way == pytest.approx(1 - DEPTH / 1.333 / (1.6 + DEPTH / 1.333), abs=0.004)
    assert right / way == pytest.approx(1, abs=0.004)
    assert "shorter" in " ".join(wrong.warnings)


def test_widths_of_the_file_that_are_too_large_leave_the_scale(folder) -> None:
    wide = sections(replace(FISH, half_width=1.1 * FISH.half_width), folder / "wide.csv")
    found = tracked(folder / "calm.mp4", folder, sections=wide)
    assert found.size == pytest.approx(1, abs=0.01)
    assert found.record()["width_factor"] == pytest.approx(1 / 1.1, abs=0.02)
    assert "9 % narrower than its sections" in " ".join(found.warnings)


def test_widths_are_learned_and_written(folder) -> None:
    """Without sections; the estimated ones are half as wide before the fin, and give a length 2 % off."""
    found = tracked(folder / "calm.mp4", folder, sections=None)
    assert found.size == pytest.approx(1, abs=0.01)
    truth = np.load(folder / "truth.npy")
    assert (np.degrees(rms(found.angle - truth[:, 3:])) < 1.5).all()
    written = write_film_run(found, ht.load(ROBOT), folder / "learned.toml", "a test")
    place, width, _ = np.loadtxt(next(name for name in written if "sections" in name), delimiter=",", skiprows=1).T
    body = (place > 0.05 * place[-1]) & (place < 0.8 * place[-1])
    true = 2 * np.interp(place / place[-1], np.linspace(0, 1, len(FISH.half_width)), FISH.half_width)
    assert np.abs(width - true)[body].max() < 0.1 * true.max()
    assert "learned" in " ".join(found.warnings)


def test_a_file_of_sections_of_another_fish_is_told_and_not_used(folder) -> None:
    """Its widest place is farther back: with it the joints are 1.2, 2.0 and 1.3 deg off."""
    place = np.linspace(0, 1, len(FISH.half_width))
    back = {name: np.interp(place**1.4, place, getattr(FISH, name)) for name in ("half_width", "half_height")}
    given = sections(replace(FISH, **back), folder / "calm-sections.csv")
    before = given.read_bytes()
    found = tracked(folder / "calm.mp4", folder, sections=given)
    truth = np.load(folder / "truth.npy")
    assert (np.degrees(rms(found.angle - truth[:, 3:])) < 1).all()
    assert "of another robot, or damaged" in " ".join(found.warnings)
    written = write_film_run(found, ht.load(ROBOT), folder / "other.toml", "a test")
    assert given.read_bytes() == before
    again = tracked(folder / "calm.mp4", folder, sections=next(name for name in written if "sections" in name))
    assert not again.body.learned
    assert not again.body.file_off


def test_harmonics_without_evidence_are_noise() -> None:
    """A sine in noise with memory: the mean and the higher harmonics are not followed."""
    draw, time = np.random.default_rng(5), np.arange(150) / 60
    truth = np.radians([10, 20]) * np.sin(2 * np.pi * 2.4 * time[:, np.newaxis])
    errors = []
    for _ in range(40):
        noise = np.zeros((150, 2))
        for k in range(1, 150):
            noise[k] = 0.9 * noise[k - 1] + draw.normal(0, np.radians(0.7), 2)
        beat = beat_of(time, truth + noise)
        waves = np.exp(2j * np.pi * beat.frequency * time[:, np.newaxis] * np.arange(5))
        columns = np.column_stack(
            [np.ones(150), *(part for k in range(1, 5) for part in (waves.real[:, k], waves.imag[:, k]))]
        )
        plain = columns @ np.linalg.lstsq(columns, truth + noise, rcond=None)[0]
        errors.append([((curve - truth) ** 2).mean() for curve in (beat.angle(time), plain)])
    own, other = np.sqrt(np.mean(errors, axis=0))
    assert own < 0.8 * other


def test_the_error_of_the_length_is_in_the_intervals_of_the_head(run) -> None:
    """A wrong size moves places by their distance from below the camera."""
    away = np.abs(run.tracked.unknowns[:, :2] - run.view.camera.place[:2])
    far = replace(run, tuning=replace(run.tuning, size_sd=0.01))
    assert (far.head_sd[:, :2] >= 0.01 * away).all()
    assert (replace(far, scale="camera").head_sd[:, 0] < 0.01 * away[:, 0]).any()


def test_a_fin_that_is_not_seen_is_refused(folder) -> None:
    pale = replace(FISH, length=FISH.length[:3], share=FISH.share[:3],
                   half_width=FISH.half_width[:240], half_height=FISH.half_height[:240])  # fmt: skip
    from film.rendered import Scene, frames

    scene = Scene(EYE, pale, depth=DEPTH)
    write_film(folder / "pale.mp4", frames(scene, beating, np.arange(60) / 60))
    refused(folder / "pale.mp4", folder, "joint fin")


def test_a_picture_of_another_size_is_refused(folder) -> None:
    frames = (cv2.resize(picture, (240, 136)) for _, picture in open_film(folder / "calm.mp4").frames())
    write_film(folder / "half.mp4", frames)
    refused(folder / "half.mp4", folder, "480 x 272")


@pytest.mark.parametrize("damage", [lambda b: b[: len(b) // 2], lambda b: b"not a film" * 9, lambda b: b""])
def test_what_is_no_film_is_refused(folder, damage) -> None:
    (folder / "cut.mp4").write_bytes(damage((folder / "calm.mp4").read_bytes()))
    with pytest.raises(InputError, match=r"cut\.mp4"):
        open_film(folder / "cut.mp4")


@pytest.fixture(scope="module")
def long(folder):
    """A film of two blocks of the journal."""
    film(folder / "long.mp4", lambda t: beating(t, speed=0.28), count=100, noise=2.0)
    return folder / "long.mp4"


def test_a_run_that_was_killed_goes_on(folder, long) -> None:
    """Blocks in the journal are not computed again, and the result is the same."""
    robot, done = ht.load(ROBOT), []

    class Killed(Exception):
        pass

    own = {"depth": DEPTH, "sections": folder / "sections.csv"}

    def kill(count, total):
        if count >= 60:
            raise Killed

    with pytest.raises(Killed), Journal(folder / "journal", {"film": 1}) as journal:
        track_film(robot, long, camera(EYE), **own, journal=journal, progress=kill)
    with Journal(folder / "journal", {"film": 1}) as journal:
        assert journal.unread == 1
        again = track_film(robot, long, camera(EYE), **own, journal=journal, progress=lambda *now: done.append(now))
    whole = track_film(robot, long, camera(EYE), **own)
    np.testing.assert_array_equal(again.tracked.unknowns, whole.tracked.unknowns)


def test_ripples_are_in_the_noise(folder) -> None:
    """Their errors have memory; pixels alone claim a fraction of them."""
    truth = film(folder / "ripple.mp4", count=120, ripple=0.5, motion=lambda t: beating(t, speed=0.32))
    found = tracked(folder / "ripple.mp4", folder)
    off = np.degrees(found.angle - truth[:, 3:])
    pixels = np.degrees(np.sqrt(np.einsum("fii->fi", found.tracked.covariance)[:, 3:]))
    assert (np.abs(off) < 1.96 * pixels).mean() < 0.7
    assert 0.85 < (np.abs(off) < np.degrees(1.96 * found.angle_sd)).mean() <= 1
    assert found.memory > 2 / 60


def test_noise_of_known_memory_is_found() -> None:
    draw, time = np.random.default_rng(3), np.arange(1200) / 60
    noise = np.zeros((1200, 2))
    for k in range(1, 1200):
        noise[k] = 0.8 * noise[k - 1] + draw.normal(0, np.radians([0.5, 1.0]) * 0.6)
    angle = np.radians([10, 20]) * np.sin(2 * np.pi * 2.3 * time[:, np.newaxis]) + noise
    beat = beat_of(time, angle)
    assert np.degrees(beat.noise) == pytest.approx([0.5, 1.0], rel=0.15)
    assert beat.memory == pytest.approx((1.8 / 0.2) / 60, rel=0.35)
    assert beat.frequency == pytest.approx(2.3, rel=1e-3)
    assert beat_of(time, noise) is None


def test_commands(folder, tmp_path) -> None:
    program = [sys.executable, "-m", "hypertuna", "trials", "track", str(folder / "calm.mp4"), "--robot", ROBOT]
    options = ["--camera", str(folder / "camera.toml"), "--depth", str(DEPTH)]
    more = ["--sections", str(folder / "sections.csv"), "--overlay", str(tmp_path / "overlay.mp4")]
    plot = ["--plot", str(tmp_path / "run.png"), "-o", str(tmp_path / "run.toml"), "--json"]
    ran = subprocess.run([*program, *options, *more, *plot], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    facts = json.loads(ran.stdout)["run"]
    assert facts["frames_used"] == 60
    assert len(open_film(tmp_path / "overlay.mp4").time) == 60
    assert (tmp_path / "run.png").exists()
    ran = subprocess.run([*program, "-o", str(tmp_path / "a.toml")], capture_output=True, text=True, check=False)
    assert ran.returncode == 2
    assert "--camera is missing" in ran.stderr


def test_a_process_that_is_killed_leaves_a_journal_that_is_read(folder, long, tmp_path) -> None:
    program = [sys.executable, "-m", "hypertuna", "trials", "track", str(long), "--robot", ROBOT]
    options = ["--camera", str(folder / "camera.toml"), "--depth", str(DEPTH), "-o", str(tmp_path / "run.toml")]
    more = ["--sections", str(folder / "sections.csv"), "--checkpoint", str(tmp_path / "journal")]
    child = subprocess.Popen([*program, *options, *more], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while child.poll() is None:
        if (tmp_path / "journal").exists() and (tmp_path / "journal").read_bytes().count(b"\n") >= 2:
            child.send_signal(signal.SIGKILL)
            break
        time.sleep(0.01)
    child.wait()
    assert not (tmp_path / "run.toml").exists()
    ran = subprocess.run([*program, *options, *more], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "run.toml").exists()


def test_a_camera_that_moves_is_told_and_light_that_changes_is_not(run) -> None:
    """A floor with a grid, moved by 2 px, or seen in three quarters of the light."""
    floor = np.full((300, 400), 180, np.uint8)
    floor[::40] = floor[:, ::40] = 150
    floor = cv2.GaussianBlur(floor, (0, 0), 1.5)
    darker = (0.75 * floor).astype(np.uint8)
    assert motion_of(floor, np.stack([floor, darker, floor]), True, 100.0) < 0.1
    assert motion_of(floor, np.stack([floor, np.roll(floor, 2, axis=1)]), True, 100.0) == pytest.approx(2, abs=0.7)
    assert run.view.motion < 0.1
    moving = replace(run, view=replace(run.view, motion=2.0))
    assert any("the tank moves by 2 px or more in the picture" in sentence for sentence in moving.warnings)


def test_a_film_played_backward_and_frames_that_repeat_are_told(run) -> None:
    assert not any(word in sentence for sentence in run.warnings for word in ("backward", "repeat", "looks"))
    backward = replace(run, tracked=replace(run.tracked, unknowns=run.tracked.unknowns[::-1]))
    assert any("moves tail first: is the film played backward?" in sentence for sentence in backward.warnings)
    frozen = run.tracked.unknowns[[*range(30), *[29] * 6, *range(30, 54)]]
    frozen = replace(run, tracked=replace(run.tracked, unknowns=frozen))
    assert any("6 frames repeat the one before: did the camera drop frames?" in one for one in frozen.warnings)


@pytest.mark.parametrize("memory", [0.0, 0.8])  # correlation of neighbors: their sum counts for a ninth of the values
def test_the_interval_of_a_mean_holds_it_in_most_draws(memory: float) -> None:
    """19 of 20 of independent values; 90 values that count for ten tell less of their own memory."""
    noise, values = np.random.default_rng(3).standard_normal((90, 300)), np.zeros((90, 300))
    for k in range(1, 90):
        values[k] = memory * values[k - 1] + noise[k]
    means, errors = zip(*(mean_of(one[:, np.newaxis]) for one in values.T), strict=True)
    assert 0.84 < np.mean(np.abs(means) < 1.96 * np.array(errors)) < 0.97
