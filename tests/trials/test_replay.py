"""Replay of measured joints: smoothing, the swim itself, comparison with tracks, and the errors of bad input."""

import json
import math
import time as clock

import numpy as np
import pytest
import typer
from scipy.interpolate import make_smoothing_spline
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna import _core
from hypertuna.cli.replay import replay_command
from hypertuna.swimming.model import core_model, parameter_names
from hypertuna.trials.replay import Pose, head_center, joint_grid, replay, replay_jacobian, residuals, rmse
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.tracks import JointSeries, Track, read_joints, read_tracks

SAMPLING = 44.0  # Hz


def angles(gait, time):
    """Angle, rate and acceleration of the joint groups, from the definition of a gait: (times, groups, 3)."""
    clock = 2 * np.pi * gait.frequency
    phase = clock * time[:, None] - np.array(gait.phase)
    amplitude = np.array(gait.amplitude)
    waves = (np.sin(phase), clock * np.cos(phase), -(clock**2) * np.sin(phase))
    motion = np.stack([amplitude * wave for wave in waves], axis=-1)
    motion[:, :, 0] += gait.bias
    return motion


def sampled(gait, duration, rate=SAMPLING):
    time = np.arange(round(duration * rate) + 1) / rate
    return JointSeries(time, angles(gait, time)[:, :, 0])


@pytest.fixture(scope="module")
def eel():
    return ht.load("rexeel")


@pytest.fixture(scope="module")
def gait():
    """The wave of the eel, with a bias so that it turns, too."""
    return ht.Gait.from_degrees(
        frequency=0.5, amplitude=(30,) * 5, phase=(0, 50.4, 100.8, 151.2, 201.6), bias=(5, 5, 5, 0, 0)
    )


# Smoothing


@pytest.mark.parametrize(
    ("frequency", "rate", "amplitude_deg", "noise_deg", "rate_error", "acceleration_error"),
    [(0.5, 44, 10, 0.03, 0.012, 0.06), (0.5, 44, 30, 0.03, 0.006, 0.04), (6, 200, 16, 0.1, 0.02, 0.06)],
)
def test_rates_and_accelerations_of_a_noisy_harmonic(
    frequency, rate, amplitude_deg, noise_deg, rate_error, acceleration_error
):
    """Relative rms errors; the cubic spline of generalized cross-validation, the obvious other choice, does worse."""
    random = np.random.default_rng(1)
    wave = ht.Gait.from_degrees(frequency=frequency, amplitude=(amplitude_deg,) * 12, phase=np.linspace(0, 330, 12))
    clean = sampled(wave, 4, rate)
    noisy = JointSeries(clean.time, clean.angle + np.radians(noise_deg) * random.standard_normal(clean.angle.shape))
    curve = smooth(noisy)
    assert np.degrees(curve.noise) == pytest.approx(noise_deg, rel=0.25)
    inner = np.linspace(0, 4, 4001)
    truth = angles(wave, inner)
    scale = np.sqrt(np.mean(truth**2, axis=0))
    error = np.sqrt(np.mean((curve(inner) - truth) ** 2, axis=0)) / scale
    assert np.median(error[:, 1]) < rate_error
    assert np.median(error[:, 2]) < acceleration_error
    some = range(0, 12, 4)
    cubic = np.transpose([make_smoothing_spline(noisy.time, noisy.angle[:, g]).derivative(2)(inner) for g in some])
    cubic_error = np.sqrt(np.mean((cubic - truth[:, some, 2]) ** 2, axis=0)) / scale[some, 2]
    assert np.median(error[:, 2]) < 0.7 * np.median(cubic_error)


def test_no_noise_interpolates(gait):
    series = sampled(gait, 4)
    assert np.allclose(smooth(series, noise=0)(series.time)[:, :, 0], series.angle, rtol=0, atol=1e-12)


def test_smoothing_stays_within_the_noise(gait):
    series, noise = sampled(gait, 4), math.radians(0.2)
    missed = smooth(series, noise=noise)(series.time)[:, :, 0] - series.angle
    assert np.all(np.sqrt(np.mean(missed**2, axis=0)) < noise * (1 + math.sqrt(2 / len(series.time))))


# The swim


@pytest.mark.parametrize("name", ["rexeel", "hypertuna"])
def test_sampled_harmonic_swims_as_the_gait_does(name):
    robot = ht.load(name).using(joints="ideal")
    gait = ht.Gait.from_degrees(
        frequency=0.5, amplitude=(20,) * len(robot.joints), phase=40.0 * np.arange(len(robot.joints))
    )
    swum = ht.swim(robot, gait, from_rest=4.0, steps=512).trajectory.isel(time=-1)
    replayed = replay(robot, smooth(sampled(gait, 4), noise=0), step=1 / 256).isel(time=-1)
    assert float(replayed.time) == pytest.approx(4.0)
    for quantity in ("x", "y", "heading", "u", "v", "r", "tail_x", "bend", "joint_rate", "energy"):
        assert np.allclose(replayed[quantity], swum[quantity], rtol=1e-5, atol=1e-6), quantity
    assert np.allclose(replayed.joint_torque, swum.joint_torque, rtol=1e-2, atol=1e-4)  # accelerations at the very end


def wavy(robot, duration=1.0):
    """A joint motion of any robot as it enters a replay: harmonics a third of a turn apart from group to group."""
    groups = len(robot.joints)
    wave = ht.Gait.from_degrees(
        frequency=1, amplitude=(20,) * groups, phase=60.0 * np.arange(groups), bias=(5,) * groups
    )
    return joint_grid(robot, smooth(sampled(wave, duration), noise=0))


def test_slopes_swim_the_replay(every_model):
    """The same track as `replay`, whose rate is that of its steps once the start is over; no direction changes it."""
    groups = len(every_model.joints)
    wave = ht.Gait.from_degrees(frequency=1, amplitude=(20,) * groups, phase=60.0 * np.arange(groups))
    curve = smooth(sampled(wave, 2), noise=0)
    joints, step = joint_grid(every_model, curve)
    replayed = replay(every_model, curve)
    count = len(parameter_names(every_model))
    for directions in (0, 1, 11):
        pose, rate, slope = replay_jacobian(every_model, joints, step, np.ones((count, directions)))
        assert slope.shape == (len(pose), 3, directions)
        for axis, name in enumerate(("x", "y", "heading")):
            assert np.allclose(pose[:, axis], replayed[name], rtol=0, atol=1e-12), name
    middle = (pose[2:] - pose[:-2]) / (2 * step)
    assert np.allclose(rate[10:-1], middle[9:], rtol=0, atol=0.02 * np.abs(rate).max(axis=0))


def test_slopes_of_a_replay_are_those_of_differences(every_model):
    """Every column of the robot along a random direction: its size is what the parameter has, a step a millionth of it.

    Rounding makes the difference wrong by 1e-16 / 1e-6, curvature and kinks of v |v| by about as much as the step.
    """
    joints, step = wavy(every_model)
    names = parameter_names(every_model)
    robot_s = [name for name in names if not name.startswith("gait.")]
    columns = dict.fromkeys(name.partition("[")[0] for name in robot_s)
    random = np.random.default_rng(3)
    values = {name: np.array(_column(every_model, name)) for name in columns}
    change = {name: random.uniform(0.5, 1, len(value)) * np.where(value, value, 1.0) for name, value in values.items()}
    directions = np.zeros((len(names), len(columns)))
    for k, name in enumerate(columns):
        directions[[i for i, full in enumerate(names) if full.partition("[")[0] == name], k] = change[name]
    _, _, slope = replay_jacobian(every_model, joints, step, directions)
    for k, name in enumerate(columns):
        if name in idle_edge(every_model):
            assert not slope[:, :, k].any(), name
            continue
        pose = replay_jacobian(every_model, joints, step, directions[:, :0])[0]
        allowed = 1e-5 * np.abs(slope).max(axis=(0, 2))
        close = []
        for h in (1e-6, -1e-6)[
            : 1 + (name in kinks(every_model))
        ]:  # forward: some are zero, the least that they may be
            models = [core_model(every_model, {name: values[name] + side * h * change[name]}) for side in (1, 2)]
            ends = [replay_jacobian(every_model, joints, step, directions[:, :0], model=model)[0] for model in models]
            difference = (4 * ends[0] - 3 * pose - ends[1]) / (2 * h)
            close.append(np.all(np.abs(slope[:, :, k] - difference) < allowed))
        assert any(close), name
        unmoved = name.startswith("joints.")  # measured angles are the ones made
        assert np.any(slope[:, :, k]) != unmoved, name


def kinks(robot):
    """What changes heights where the last link is as high as the one ahead: only a lower one leaves a leading edge."""
    strip, height = robot.water.strip, np.divide(robot.links.lateral_area, robot.links.length)
    last = robot.model.water == "strip" and not (strip.edge_height and strip.edge_aspect) and height[-1] == height[-2]
    return {"links.length", "links.lateral_area"} if last else set()


def idle_edge(robot):
    """The strips' numbers of the fin without effect: of an edge that sheds nothing, or of a plate that is not there.

    A height or an aspect ratio of 0 means the last link itself. Without a lower link ahead it has no leading edge for
    suction. A plate has no more added mass than the link that carries it.
    """
    if robot.model.water != "strip":
        return set()
    strip, links = robot.water.strip, robot.links
    height = links.lateral_area[-1] / links.length[-1]
    idle = set() if strip.tail_shedding else {"lift", "suction"}
    if not (strip.edge_height and strip.edge_aspect):
        idle |= {"aspect", "added_mass"} | ({"height"} if not strip.edge_height or not strip.tail_shedding else set())
        idle |= {"suction"} if kinks(robot) else set()
    elif strip.edge_added_mass * strip.edge_height**3 / strip.edge_aspect**2 > (
        strip.added_mass_normal[-1] * height**2 * links.length[-1]
    ):
        idle |= {"added_mass"}
    return {f"water.strip.edge_{what}" for what in idle}


def _column(robot, name):
    """The values of one of the robot's columns."""
    *tables, last = name.split(".")
    if tables == ["joints"]:
        return [1.0] * len(robot.joints)
    part = robot
    for table in tables:
        part = getattr(part, table)
    return np.atleast_1d(getattr(part, last))


def test_order_of_convergence_in_the_step(gait):
    eel = ht.load("rexeel-theory")  # smooth: shedding would set in and end within steps
    curve = smooth(sampled(gait, 4), noise=0)

    def end(step):
        return head_center(eel, replay(eel, curve, step=step))[-1]

    exact = end(1 / 640)
    error = [np.linalg.norm(end(step) - exact) for step in (1 / 10, 1 / 20, 1 / 40)]
    order = np.log2(np.divide(error[:-1], error[1:]))
    assert np.all(order > 3.6), order


def test_measured_joints_know_no_bandwidth(gait):
    robot = ht.load("hypertuna")
    wave = ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(0, 40))
    curve = smooth(sampled(wave, 2, 200), noise=0)
    slow, ideal = (replay(robot.using(joints=joints), curve) for joints in ("bandwidth", "ideal"))
    assert slow.x.equals(ideal.x)
    assert np.allclose(slow.bend, angles(wave, slow.time.to_numpy())[:, :, 0], rtol=0, atol=1e-6)


def test_start_without_momentum(eel, gait):
    """Whatever the joints do at the first sample: here they jump into full motion."""
    curve = smooth(sampled(gait, 4), noise=0)
    first = replay(eel, curve).isel(time=0)
    joints = np.zeros((1, 6, 3))
    joints[:, 1:] = curve(np.zeros(1))
    twist = np.array([[float(first[name]) for name in "uvr"]])
    momentum = _core.dynamics(core_model(eel), joints, twist)["momentum"]
    assert np.abs(twist).max() > 0.01
    assert np.abs(momentum).max() < 1e-12


def test_start_pose_current_and_clock(eel, gait):
    series, turn = sampled(gait, 2), 0.7
    plain = replay(eel, series)
    start = Pose.from_head_center(eel, 1.0, 2.0, math.pi + turn)
    assert start.heading == pytest.approx(turn)
    moved = replay(eel, series, start=start, current=(0.1, -0.2), time_offset=0.5)
    assert head_center(eel, moved)[0] == pytest.approx([1.0, 2.0, math.pi + turn])
    assert moved.time.to_numpy() == pytest.approx(plain.time.to_numpy() + 0.5)
    c, s = math.cos(turn), math.sin(turn)
    passed, x, y = (plain[name].to_numpy() for name in ("time", "x", "y"))
    assert np.allclose(moved.x.to_numpy(), start.x + c * x - s * y + 0.1 * passed, atol=1e-12)
    assert np.allclose(moved.y.to_numpy(), start.y + s * x + c * y - 0.2 * passed, atol=1e-12)


def test_divergence_is_reported(eel, gait):
    wild = JointSeries(np.arange(40) / 44, 100 * sampled(gait, 39 / 44).angle)
    result = replay(eel, wild, step=0.5, twist=(1e2, 1e2, 1e2))
    assert result.status == "diverged"
    assert result.status_text.startswith("The replay diverged")
    assert all(np.isfinite(values).all() for values in result.data_vars.values())
    assert replay(eel, sampled(gait, 2)).status == "completed"


# Comparison with tracked poses


def tracked(robot, result, run="one", every=7, pose=(0.0, 0.0, 0.0)):
    """A track of a replay as another camera sees it, at some of its instants."""
    made = head_center(robot, result)[::every]
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x, y = made[:, 0], made[:, 1]
    seen = np.column_stack([pose[0] + c * x - s * y, pose[1] + s * x + c * y, made[:, 2] + pose[2]])
    return Track(run, result.time.to_numpy()[::every], seen)


def test_track_of_the_replay_itself_has_no_error_wherever_it_is_seen_from(eel, gait):
    result = replay(eel, sampled(gait, 3))
    track = tracked(eel, result, pose=(2.0, -1.0, 2.5))
    assert np.abs(residuals(eel, result, track)).max() < 1e-12
    compared = rmse(eel, result, [track])
    assert compared.rmse.to_numpy() == pytest.approx([0, 0, 0], abs=1e-12)
    assert np.isnan(compared.repeatability).all()


def test_error_splits_into_that_of_the_mean_and_repeatability(eel, gait):
    result = replay(eel, sampled(gait, 3))
    base = tracked(eel, result)
    ramp = np.linspace(0, 1, len(base.time))[:, None]
    drifts = [np.array(drift) for drift in ([0.03, 0, 0.2], [0.01, 0, 0.1], [-0.01, 0.02, 0])]
    tracks = [Track(f"run {n}", base.time, base.pose + ramp * drift) for n, drift in enumerate(drifts)]
    compared = rmse(eel, result, tracks)
    grown = math.sqrt(float(np.mean(ramp**2)))
    assert compared.run_rmse.to_numpy() == pytest.approx(grown * np.abs(drifts), abs=1e-12)
    assert compared.mean_rmse.to_numpy() == pytest.approx(grown * np.abs(np.mean(drifts, axis=0)), abs=1e-12)
    assert compared.repeatability.to_numpy() == pytest.approx(grown * np.std(drifts, axis=0), abs=1e-12)
    whole = np.hypot(compared.mean_rmse, compared.repeatability).to_numpy()
    assert compared.rmse.to_numpy() == pytest.approx(whole, abs=1e-12)


def test_frames_outside_the_replay_do_not_count(eel, gait):
    result = replay(eel, sampled(gait, 3), time_offset=1.0)
    time = np.arange(0, 6, 0.25)
    compared = residuals(eel, result, Track("long", time, np.zeros((len(time), 3))))
    assert len(compared) == np.sum((time >= 1) & (time <= 4))
    with pytest.raises(ht.InputError, match="run late must overlap the replay, 1 to 4 s, but is 7 to 8 s"):
        residuals(eel, result, Track("late", np.array([7.0, 8.0]), np.zeros((2, 3))))


# Files


def write(path, lines):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


def table(gait, duration=1.0):
    """Lines of a file of angles as a logger writes it."""
    series = sampled(gait, duration)
    names = ",".join(["time_s", *(f"angle_{g + 1}" for g in range(series.angle.shape[1]))])
    rows = [
        f"{t:.6f},{','.join(f'{a:.9f}' for a in np.degrees(row))}"
        for t, row in zip(series.time, series.angle, strict=True)
    ]
    return ["# a log", "# 44 Hz", "", names, *rows]


def read(path, columns=("angle_1", "angle_2", "angle_3", "angle_4", "angle_5"), unit="deg", time="time_s"):
    return read_joints(path, time=time, columns=columns, unit=unit)


def test_joints_are_read_in_radians_and_comments_skipped(tmp_path, gait):
    series = read(write(tmp_path / "angles.csv", table(gait)))
    assert np.allclose(series.angle, sampled(gait, 1.0).angle, rtol=0, atol=1e-9)
    assert series.lines[0] == 5


def changed(line, old, new):
    """Replace the cell `old` of a line (counted from 1) of a file."""

    def change(lines):
        cells = lines[line - 1].split(",")
        cells[old] = new
        lines[line - 1] = ",".join(cells)
        return lines

    return change


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (changed(14, 2, "nan"), "line 14, angle_2 must be a finite number, but is 'nan': give a number"),
        (changed(14, 2, "1e300"), "line 14, angle_2 must be from -1e+12 to 1e+12, but is 1e+300: give a number"),
        (changed(14, 0, "soon"), "line 14, time_s must be a finite number, but is 'soon': give a number"),
        (
            changed(14, 0, "0.1"),
            "line 14, time_s must be later than the previous sample, at 0.181818 s, but is 0.1 s: sort",
        ),
        (
            lambda lines: lines[:20] + lines[30:],
            "line 21, time_s must follow the previous sample within 5 median",
        ),
        (lambda lines: [*lines[:9], "0.5,1,2"], "line 10 must have 6 cells, like the line of names, but is 3 long"),
        (lambda lines: lines[:12], "the series must have at least 12 samples, but is 8 long: record a longer series"),
        (lambda lines: lines[:4], "must be a table, but is empty: give a line of column names"),
        (lambda lines: [], "must be a table, but is empty"),
        (
            changed(4, 3, "angel_3"),
            "column angle_3 must be a column of the file, but is missing: did you mean angel_3",
        ),
    ],
)
def test_bad_series_are_reported_by_line(tmp_path, gait, change, sentence):
    path = write(tmp_path / "angles.csv", change(table(gait)))
    with pytest.raises(ht.InputError) as error:
        read(path)
    assert str(error.value).removeprefix(f"{path}: ").removeprefix(f"{path} ").startswith(sentence)
    assert "\n" not in str(error.value)


def test_bad_use_is_reported(tmp_path, eel, gait):
    path = write(tmp_path / "angles.csv", table(gait))
    with pytest.raises(ht.InputError, match=r"nowhere\.csv must be a file, but is missing: check the path\."):
        read(tmp_path / "nowhere.csv")
    with pytest.raises(ht.InputError, match="unit must be a known unit, but is 'grad'"):
        read(path, unit="grad")
    with pytest.raises(ht.InputError, match=r"angles must be 5, one per joint group of rexeel .* but is 2: name"):
        replay(eel, read(path, columns=("angle_1", "angle_2")))
    series = read(path)
    for option in ({"step": 0.0}, {"step": math.nan}, {"start": (math.nan, 0, 0)}, {"time_offset": math.inf}):
        with pytest.raises(ht.InputError, match=f"{next(iter(option))} must be "):
            replay(eel, series, **option)
    with pytest.raises(ht.InputError, match=r"sample 3, angle\[1\] must be a finite number, but is nan"):
        JointSeries(series.time, np.where(np.arange(45)[:, None] * [0, 1, 0] == 3, np.nan, series.angle[:, :3]))
    with pytest.raises(ht.InputError, match="noise must not be negative"):
        smooth(series, noise=-1.0)


def track_lines(robot, result, runs=("a", "b")):
    """Lines of a file of tracked poses in cm and degrees, yaw clockwise from north as a compass has it."""
    lines = ["run,t,x_cm,y_cm,compass"]
    for run in runs:
        for t, (x, y, yaw) in zip(result.time.to_numpy()[::5], head_center(robot, result)[::5], strict=True):
            lines.append(f"{run},{t},{100 * x},{100 * y},{(90 - math.degrees(yaw)) % 360}")
    return lines


TRACKED = {"time": "t", "pose": ("x_cm", "y_cm", "compass"), "run": "run", "length_unit": "cm", "angle_unit": "deg"}


def test_tracks_are_read_run_by_run(tmp_path, eel, gait):
    result = replay(eel, sampled(gait, 3), start=Pose(0.3, 0.2, -0.1))
    path = write(tmp_path / "poses.csv", track_lines(eel, result))
    tracks = read_tracks(path, **TRACKED, yaw_zero=math.pi / 2, clockwise=True)
    assert [track.run for track in tracks] == ["a", "b"]
    assert np.abs(residuals(eel, result, tracks[1])).max() < 1e-9
    with pytest.raises(ht.InputError, match=r"t must be later than the previous frame, at .* s, but is 0 s: sort"):
        read_tracks(path, **(TRACKED | {"run": None}))


# The command

app = typer.Typer()
app.command()(replay_command)


def test_command_compares_and_writes(tmp_path, eel, gait):
    angles_file = write(tmp_path / "angles.csv", table(gait, 3))
    result = replay(eel, read(angles_file))
    poses = write(tmp_path / "poses.csv", track_lines(eel, result))
    columns = ",".join(f"angle_{g}" for g in range(1, 6))
    given = [angles_file, "--robot", "rexeel", "--columns", columns, "--start", "1,2,30"]
    compare = ["--poses", poses, "--pose-columns", "t,x_cm,y_cm,compass,run", "--pose-units", "cm,deg"]
    frame = ["--yaw-zero", "90", "--yaw-clockwise"]
    files = ["--plot", str(tmp_path / "track.svg"), "-o", str(tmp_path / "track.nc")]
    done = CliRunner().invoke(app, [*given, *compare, *frame, *files, "--json"])
    assert done.exit_code == 0, done.output
    said = json.loads(done.output)
    assert said["status"] == "completed"
    assert said["runs"] == ["a", "b"]
    assert said["axes"]["y"]["rmse_cm"] == pytest.approx(0, abs=1e-6)
    assert said["axes"]["yaw"]["repeatability_deg"] == pytest.approx(0, abs=1e-6)
    assert (tmp_path / "track.svg").stat().st_size > 0
    assert (tmp_path / "track.nc").stat().st_size > 0
    assert "The replay is complete" in CliRunner().invoke(app, given).output


def test_command_refuses_before_it_writes(tmp_path, gait):
    angles_file = write(tmp_path / "angles.csv", table(gait))
    output = tmp_path / "track.nc"
    given = [angles_file, "--robot", "rexeel", "--columns", "angle_1,angle_2", "-o", str(output)]
    done = CliRunner().invoke(app, given)
    assert isinstance(done.exception, ht.InputError)
    assert not output.exists()


def test_a_long_replay_is_refused_before_it_is_smoothed(eel, monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(600_000) / 100
    long = JointSeries(time, np.zeros((len(time), 5)), file="long.csv")
    monkeypatch.setattr("hypertuna.trials.replay.smooth", lambda _: pytest.fail("smoothed"))
    rule = (
        r"long\.csv: a replay must take at most 1000000 steps, but is 1199998: 5999\.99 s in steps of 0\.005 s: take "
    )
    with pytest.raises(ht.InputError, match=rf"{rule}steps of at least 0\.006 s \(--step\), or replay .* in parts\."):
        replay(eel, long)
    with pytest.raises(ht.InputError, match="must take at most"):
        replay(eel, long, step=1e-9)


def test_smoothing_takes_time_by_the_samples_not_by_their_square() -> None:
    def seconds(samples: int) -> float:
        time = np.arange(samples) / 100
        noise = np.random.default_rng(0).normal(0, 0.01, (samples, 2))
        start = clock.process_time()
        smooth(JointSeries(time, np.sin(2 * np.pi * time)[:, np.newaxis] + noise))
        return clock.process_time() - start

    seconds(1000)
    assert seconds(32_000) < 8 * seconds(8000)
