"""Runs that begin in motion: told from rest, their twist from the first beat, its derivatives, walls and lags."""

import math

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.identification.coefficients import free, from_scale, with_values
from hypertuna.identification.experiment import experiment
from hypertuna.identification.identify import identify
from hypertuna.identification.prediction import predict, weighted
from hypertuna.swimming.model import parameter_names, twist_from_rest
from hypertuna.trials.comparison import compare_recording, how_begun, replay_recording
from hypertuna.trials.manifest import Recording, parse_manifest
from hypertuna.trials.replay import head_center, joint_grid, replay, replay_jacobian
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.start import UnknownBegin, Velocity, beat_of, begin_together, begins_in_motion
from hypertuna.trials.tracks import JointSeries, Track, lag_of
from hypertuna.trials.trials import Trials

CRUISE = np.array([-0.15, 0.01, -0.05])  # u, v, r of the nose beyond those of rest, where only the joints move
RATE = 60.0  # frames per second


def waves(robot, duration=4.0, frequency=0.8, offset=0.4):
    """Joint angles of a wave in full motion at its first sample."""
    time = np.arange(round(duration * RATE) + 1) / RATE
    lag = 0.9 * np.arange(len(robot.joints))
    return JointSeries(time, math.radians(15) * np.sin(2 * np.pi * frequency * time[:, np.newaxis] + offset - lag))


def start_of(robot, joints):
    """The twist of a swim with `CRUISE`."""
    return twist_from_rest(robot, joint_grid(robot, smooth(joints, noise=0.0))[0][0]) + CRUISE


def cruise(robot, *, noise=0.0, seed=0, name="cruise", velocity=None, moving=True, frequency=0.8, twist=CRUISE):
    """A recording of a swim that begins in motion, with white noise [m, m, rad] on its poses."""
    joints = waves(robot, frequency=frequency)
    made = replay(robot, smooth(joints, noise=0.0), twist=None if twist is None else tuple(start_of(robot, joints)))
    rng = np.random.default_rng(seed)
    pose = np.column_stack([np.interp(joints.time, made.time, axis) for axis in head_center(robot, made).T])
    pose = pose + noise * rng.standard_normal(pose.shape)
    tracks = [Track("a", joints.time, pose)]
    if moving:
        joints, tracks = begin_together(joints, tracks, 0.0, 1 / frequency)
    return Recording(name, joints, 0.0, tuple(tracks), moving=moving, velocity=velocity)


def test_velocity_of_the_head_s_center_is_a_twist_of_the_nose():
    """The nose is half a head ahead: a turn to port moves it to port, which is -v."""
    eel = ht.load("rexeel")
    assert Velocity(0.2, 0.05, 0.5).twist(eel) == pytest.approx([-0.2, -0.05 - 0.5 * 0.06, 0.5])


def test_beat_is_that_of_the_angles():
    frequency, amplitude = beat_of(smooth(waves(ht.load("rexeel"), frequency=1.3), noise=0.0))
    assert frequency == pytest.approx(1.3, rel=0.02)
    assert amplitude == pytest.approx(math.radians(15), rel=0.01)


def test_derivatives_by_the_twist_at_the_start(every_model):
    """Against differences, and those along the directions are the same as at rest where the twist is that of rest."""
    joints, step = joint_grid(every_model, smooth(waves(every_model, 1.0), noise=0.0))
    directions = np.zeros((len(parameter_names(every_model)), 2))
    directions[-4:, 0] = 1.0
    twist = CRUISE
    pose, _, by = replay_jacobian(every_model, joints, step, directions, twist=twist)
    assert by.shape == (len(pose), 3, 5)
    for k in range(3):
        h = 1e-6 * np.eye(3)[k]
        ends = [replay_jacobian(every_model, joints, step, directions, twist=twist + d)[0] for d in (h, -h)]
        difference = (ends[0] - ends[1]) / 2e-6
        assert by[..., k] == pytest.approx(difference, abs=1e-5 * np.abs(difference).max())
    replayed = replay(every_model, smooth(waves(every_model, 1.0), noise=0.0), twist=tuple(CRUISE))
    assert pose[:, 0] == pytest.approx(replayed["x"].to_numpy(), abs=1e-12)


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_twist_comes_back_from_the_first_beat(noise):
    """With 1 mm and 1 mrad of white noise, too; a replay from rest is far off.

    The first frame has the error of a quintic through 38 frames at its end, 6 / sqrt(38) = 1 of the noise, and the
    twist that of 75 frames over times of about a beat, 1.25 s: below 1 mm/s and, as a turn is damped within 0.3 s,
    1 mrad / 0.3 s.
    """
    eel = ht.load("rexeel")
    recording = cruise(eel, noise=noise)
    curve = smooth(recording.joints, noise=0.0)
    twist, _, begin = how_begun(eel, recording, curve)
    assert begin == "in motion, velocity estimated from the first beat"
    error = np.abs(twist - start_of(eel, recording.joints))
    assert (error < [2e-3 + 4 * noise, 4e-3 + 8 * noise, 0.02 + 12 * noise]).all()
    compared = compare_recording(eel, recording, replay_recording(eel, recording))
    travel = abs(recording.tracks[0].pose[-1, 0] - recording.tracks[0].pose[0, 0])
    assert float(compared.rmse[0]) < 0.01 * travel + 3 * noise
    rest = Recording("rest", recording.joints, 0.0, recording.tracks)
    compared = compare_recording(eel, rest, replay_recording(eel, rest))
    assert float(compared.rmse[0]) > 0.1 * travel


def test_runs_in_motion_are_told_from_runs_at_rest():
    """A run cut out of a swim, one whose wave sets in, and a glide before the wave sets in."""
    eel = ht.load("rexeel")
    moving = cruise(eel, moving=False)
    assert begins_in_motion(smooth(moving.joints, noise=0.0), moving.tracks)
    time = moving.joints.time
    ramp = np.clip(time, 0, 1)[:, np.newaxis] ** 2
    joints = JointSeries(time, ramp * moving.joints.angle)
    for twist, in_motion in ((None, False), ((-0.2, 0.0, 0.0), True)):
        made = replay(eel, smooth(joints, noise=0.0), twist=twist)
        poses = np.column_stack([np.interp(time, made.time, axis) for axis in head_center(eel, made).T])
        assert begins_in_motion(smooth(joints, noise=0.0), [Track("a", time, poses)]) == in_motion


def test_derivatives_of_a_prediction_include_those_of_how_it_begins():
    """Of runs without noise: what the derivatives leave out is a product with the residuals."""
    eel = ht.load("rexeel")
    trials = Trials((cruise(eel), cruise(eel, name="given", velocity=Velocity(0.15, 0.0, -0.3))))
    frees = free(eel, ["water.drag_normal", "water.drag_tangential", "water.added_mass_normal[0-4]", "links.mass[2]"])
    data, x = experiment(eel, trials, frees), np.array([f.start for f in frees])
    by = predict(data, x).jacobian
    for k in range(len(frees)):
        h = 1e-5 * abs(x[k]) * np.eye(len(x))[k]
        ends = [predict(data, from_scale(frees, x + d), gradient_steps=None).computed for d in (h, -h)]
        difference = (ends[0] - ends[1]) / (2 * h[k])
        assert by[:, k] == pytest.approx(difference, abs=1e-4 * np.abs(difference).max()), frees[k].name


def test_error_of_a_fit_is_smallest_where_its_gradient_is_zero():
    """Gradient of the sum of squares against differences, with noise on all frames.

    How a run begins must be the best for each set of coefficients: with three rounds of Gauss and Newton it was not,
    the gradient differed from it by up to a thousand times, and searches ended with both drags 24 % too large.
    """
    eel = ht.load("rexeel-theory")
    noise, x = np.array([6e-4, 8e-4, 2e-2]), np.array([0.7, 4.0, 1.4])
    frees = free(eel, ["water.drag_normal=common", "water.drag_tangential=common", "water.added_mass_normal=common"])
    swims = with_values(eel, frees, x)
    trials = Trials(tuple(cruise(swims, name=f"{f}", frequency=f, noise=noise) for f in (0.5, 0.8)))
    data = experiment(eel, trials, frees)
    levels = dict(zip(("x", "y", "yaw"), noise, strict=True))

    def error(values):
        return 0.5 * (weighted(data, predict(data, values, gradient_steps=None, levels=levels), levels)[0] ** 2).sum()

    residual, jacobian = weighted(data, predict(data, x, levels=levels), levels)
    difference = [(error(x + h) - error(x - h)) / 2e-4 for h in 1e-4 * np.eye(3)]
    assert jacobian.T @ residual == pytest.approx(difference, abs=0.01 * np.abs(difference).max())


def test_coefficients_come_back_from_runs_in_motion():
    eel = ht.load("rexeel")
    runs = tuple(cruise(eel, name=f"{f}", frequency=f, noise=1e-4, seed=round(10 * f)) for f in (0.5, 0.8, 1.1))
    names = ["water.drag_normal", "water.drag_tangential"]
    start = {"water.drag_normal": 3.0, "water.drag_tangential": 0.02}
    fit = identify(eel, Trials(runs), names, validate=0, starts=1, start=start)
    assert fit.values == pytest.approx([eel.water.strip.drag_normal[0], eel.water.strip.drag_tangential[0]], rel=0.02)


@pytest.mark.parametrize("moving", [True, False])
def test_added_mass_comes_back_from_frames_with_noise(moving):
    """White noise of 1 mm and 10 mrad, on the first frame too: without its error the added mass came out 70 % off.

    Coefficients within 10 %; the fit begins with half the added mass.
    """
    eel = ht.load("rexeel")
    runs = []
    for k, frequency in enumerate((0.5, 0.8, 1.1)):
        twist = CRUISE if moving else None
        run = cruise(eel, name=f"{k}", frequency=frequency, twist=twist, moving=False)
        rng = np.random.default_rng(k)
        noise = np.array([1e-3, 1e-3, 1e-2]) * rng.standard_normal(run.tracks[0].pose.shape)
        tracks = [Track("a", run.tracks[0].time, run.tracks[0].pose + noise)]
        joints = run.joints
        if moving:
            joints, tracks = begin_together(joints, tracks, 0.0, 1 / frequency)
        runs.append(Recording(f"{k}", joints, 0.0, tuple(tracks), moving=moving, align=True))
    names, start = ["water.added_mass_normal=common", "water.drag_normal"], {"water.added_mass_normal": 0.5}
    fit = identify(eel, Trials(tuple(runs)), names, validate=0, starts=1, start=start)
    assert fit.values == pytest.approx([1.0, eel.water.strip.drag_normal[0]], rel=0.1)


def manifest(tmp_path, **more):
    """A manifest of a swim in motion; more: keys of its recording or of the top level."""
    eel = ht.load("rexeel")
    recording = cruise(eel, moving=False)
    time, track = recording.joints.time, recording.tracks[0]
    target = np.column_stack([np.interp(time + 0.05, time, angle) for angle in recording.joints.angle.T])
    heads = [f"{kind}_{g}" for kind in ("made", "target") for g in range(5)]
    rows = np.column_stack([time, recording.joints.angle, target])
    np.savetxt(tmp_path / "j.csv", rows, delimiter=",", header=",".join(["time_s", *heads]), comments="")
    rows = np.column_stack([track.time, track.pose])
    np.savetxt(tmp_path / "p.csv", rows, delimiter=",", header="time_s,x,y,yaw", comments="")
    joints = {"file": "j.csv", "columns": heads[:5], "targets": heads[5:], "unit": "rad", "noise_deg": 0.0}
    poses = {"files": ["p.csv"], "x": "x", "y": "y", "yaw": "yaw", "length_unit": "m", "angle_unit": "rad"}
    tank = {"tank": more.pop("tank")} if "tank" in more else {}
    use = {"use": more.pop("use")} if "use" in more else {}
    document = {"format": 1, "recordings": [{"name": "a", "joints": joints | use, "poses": poses, **more}], **tank}
    return parse_manifest(document, eel, folder=tmp_path, file="m.toml")[0]


def test_manifest_says_how_a_run_begins(tmp_path):
    shown = manifest(tmp_path)
    assert shown.moving
    assert shown.velocity is None
    assert not manifest(tmp_path, begin="rest").moving
    given = manifest(tmp_path, velocity={"forward_m_s": 0.15, "turn_deg_s": -17.0})
    assert given.moving
    assert given.velocity == Velocity(0.15, 0.0, math.radians(-17))
    with pytest.raises(ht.InputError, match=r"recordings\[0\].velocity cannot be given with begin = \"rest\""):
        manifest(tmp_path, begin="rest", velocity={"forward_m_s": 0.15})


def test_lag_behind_targets_and_targets_as_a_choice(tmp_path):
    """The target of a sample is the angle 0.05 s later: the angle lags by that, to half a step of the search."""
    measured, commanded = manifest(tmp_path), manifest(tmp_path, use="targets")
    assert measured.lag == pytest.approx([0.05] * 5, abs=0.002)
    assert commanded.lag == measured.lag
    assert not np.allclose(measured.joints.angle, commanded.joints.angle)
    same = waves(ht.load("rexeel"))
    assert lag_of(same, same) == pytest.approx([0.0] * 5, abs=1e-12)


def test_a_run_ends_where_the_nose_comes_near_a_wall(tmp_path):
    whole = manifest(tmp_path, begin="rest").tracks[0]
    nose = whole.pose[:, 0] + 0.06 * np.cos(whole.pose[:, 2])
    low = float(nose.min())
    tank = {"x_m": [low - 0.05, 1.0], "y_m": [-5.0, 5.0], "wall_distance_m": 0.1}
    cut = manifest(tmp_path, begin="rest", tank=tank)
    assert cut.ended == ("p",)
    track = cut.tracks[0]
    assert len(track.time) == int(np.argmax(nose < low + 0.05))
    assert (track.pose[:, 0] + 0.06 * np.cos(track.pose[:, 2])).min() >= low + 0.05
    with pytest.raises(ht.InputError, match="lower wall_distance_m, or correct the walls"):
        manifest(tmp_path, tank=tank | {"wall_distance_m": 3.0})


def test_the_velocity_of_the_head_s_center_is_that_of_the_nose_half_a_link_ahead():
    fish = ht.load("hypertuna")
    half = fish.links.length[0] / 2
    np.testing.assert_allclose(Velocity(0.2, 0.1, 0.5).twist(fish), [-0.2, -0.1 - 0.5 * half, 0.5])
    np.testing.assert_array_equal(Velocity().twist(fish), [0, 0, 0])


def test_the_noise_of_frames_grows_with_the_residual_beyond_white_noise():
    least = np.array([1.0, 2.0, 0.5])
    for runs in (1, 2):  # of 8 frames together
        told = UnknownBegin(
            np.repeat(np.arange(runs), 8 // runs), np.zeros((8, 3)), np.tile(least, (runs, 1)), True, False
        )
        for size, factor in ((0.0, 1.0), (1.0, 1.0), (2.0, math.sqrt(1 + 8 / runs * 3))):
            np.testing.assert_allclose(told.noise(size * np.tile(least, (8, 1)), None), factor * least)
        np.testing.assert_array_equal(told.noise(np.zeros((8, 3)), np.array([3.0, 1.0, 0.1])), [3.0, 2.0, 0.5])
