"""Replay of the recordings of a manifest: errors beside repeatability, clocks, and what the command says and writes."""

import json
import math
from pathlib import Path

import h5netcdf
import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.cli.main import app
from hypertuna.description.robot import load, parse
from hypertuna.description.writer import write_robot
from hypertuna.trials.comparison import best_time_offset, compare_recording, repeatability, replay_recording
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import head_center, replay
from hypertuna.trials.tracks import JointSeries, Track

TANK = Path(__file__).parents[2] / "examples" / "tank"


@pytest.fixture(scope="module")
def series():
    """Two seconds of HyperTuna's joints at 2 Hz, from rest."""
    time = np.arange(201) / 100
    wave = np.sin(4 * np.pi * time[:, np.newaxis] - np.radians([0, 40]))
    return JointSeries(time, np.clip(2 * time, 0, 1)[:, np.newaxis] ** 3 * np.radians([16, 25]) * wave)


def track(robot, series, run="a", drift=(0.0, 0.0, 0.0), later=0.0):
    """What a camera sees of the replay: 30 Hz on a clock of its own, with a drift [m/s, m/s, rad/s]."""
    made = replay(robot, series)
    time = np.arange(55) / 30
    poses = [np.interp(time, made.time, axis) for axis in head_center(robot, made).T]
    return Track(run, time + later, np.column_stack(poses) + time[:, np.newaxis] * drift)


def test_ratio_is_error_over_repeatability(tuna, series):
    """Two runs that drift apart by +-d have repeatability d times the rms of time; a third of 2 d is that far off."""
    drift = np.array([0.01, 0.02, 0.1])
    apart = (track(tuna, series, "a", drift), track(tuna, series, "b", -drift))
    grown = math.sqrt(np.mean((np.arange(55) / 30) ** 2))
    assert repeatability(apart) == pytest.approx(grown * drift, rel=1e-9)
    recording = Recording("swim", series, None, apart)
    compared = compare_recording(tuna, recording, replay_recording(tuna, recording))
    assert compared.rmse.to_numpy() == pytest.approx(grown * drift, rel=1e-9)
    assert compared.ratio.to_numpy() == pytest.approx([1, 1, 1], rel=1e-9)
    moved = tuple(track(tuna, series, run, base * drift) for run, base in (("a", 3), ("b", 1)))
    recording = Recording("swim", series, None, moved)
    compared = compare_recording(tuna, recording, replay_recording(tuna, recording))
    assert compared.ratio.to_numpy() == pytest.approx([math.sqrt(5)] * 3, rel=1e-9)  # 1 about their mean, 2 from it
    single = Recording("swim", series, None, moved[:1])
    compared = compare_recording(tuna, single, replay_recording(tuna, single))
    assert np.isnan(compared.ratio).all()


@pytest.mark.parametrize("later", [-0.1, 0.0, 0.06, 0.2])
@pytest.mark.parametrize("drift", [(0.0, 0.0, 0.0), (0.02, -0.02, 0.02)])
def test_best_time_offset_is_that_of_the_clocks(tuna, series, later, drift):
    tracks = tuple(track(tuna, series, run, side * np.array(drift), later) for run, side in (("a", 1), ("b", -0.5)))
    recording = Recording("swim", series, None, tracks, time_offset=0.01)
    result = replay_recording(tuna, recording)
    found = compare_recording(tuna, recording, result)
    assert found.attrs["best_time_offset_s"] == pytest.approx(later, abs=1e-4 if drift == (0, 0, 0) else 0.01)
    assert found.attrs["best_time_offset_s"] == 0.01 + best_time_offset(tuna, result, tracks)
    assert (found.best_offset_rmse <= found.rmse + 1e-9)[2]  # yaw, which tells the clock best
    part = found.where(found.repeatability > 0)  # runs without drift have no ratio
    assert part.best_offset_ratio.to_numpy() == pytest.approx(
        (part.best_offset_rmse / part.repeatability).to_numpy(), rel=1e-12, nan_ok=True
    )
    again = Recording("swim", series, None, tracks, time_offset=found.attrs["best_time_offset_s"])
    given = compare_recording(tuna, again, replay_recording(tuna, again))
    assert given.rmse.to_numpy() == pytest.approx(found.best_offset_rmse.to_numpy(), abs=1e-9)


def test_replay_starts_where_the_first_run_does(tuna, series):
    (recording,) = ht.read_trials(TANK / "tank.toml", tuna).recordings
    assert head_center(tuna, replay_recording(tuna, recording))[0] == pytest.approx([0.5, 1.0, math.radians(10)])


def run(*arguments):
    return CliRunner().invoke(app, ["replay", *(str(argument) for argument in arguments), "--robot", "hypertuna"])


def two_recordings(folder):
    """The manifest of the example with its recording twice, the second with the clocks apart and no run column."""
    text = (TANK / "tank.toml").read_text().replace('"angles.csv"', f'"{TANK}/angles.csv"').replace('"tank.csv"', "")
    lines = (TANK / "poses.csv").read_text().splitlines()
    (folder / "one.csv").write_text("\n".join([lines[1], *(line for line in lines if line.startswith("a,"))]))
    one = text[text.index("[[recordings]]") :].replace('"start"', '"late"').replace("[0.0, 2.0]", "[0.0, 2.1]")
    one = one.replace('"poses.csv"', '"one.csv"').replace('run = "run"\n', "").replace("s = 0.0", "s = 0.08")
    path = folder / "two.toml"
    path.write_text(text.replace('"poses.csv"', f'"{TANK}/poses.csv"') + one)
    return path


def test_command_compares_every_recording(tmp_path):
    path, plot, output = two_recordings(tmp_path), tmp_path / "heads.svg", tmp_path / "heads.nc"
    done = run(path, "--json", "--plot", plot, "-o", output)
    assert done.exit_code == 0, done.output
    said = json.loads(done.output)
    assert said["robot"] == "hypertuna"
    first, late = said["recordings"]
    assert [recording["name"] for recording in said["recordings"]] == ["start", "late"]
    assert first["runs"] == ["a", "b", "c"]
    assert len(first["axes"]["yaw"]["run_rmse_deg"]) == 3
    axis = first["axes"]["y"]
    assert axis["rmse_cm"] == pytest.approx(math.hypot(axis["mean_rmse_cm"], axis["repeatability_cm"]))
    assert axis["ratio"] == pytest.approx(axis["rmse_cm"] / axis["repeatability_cm"])
    assert 1 <= axis["ratio"] < 1.5  # the model that made the tracks
    assert first["joint_noise_deg"] == pytest.approx([0.1, 0.1])
    assert (late["runs"], late["axes"]["x"]["ratio"], late["time_offset_s"]) == (["one"], None, 0.08)
    assert late["best_time_offset_s"] == pytest.approx(0, abs=0.01)
    assert late["axes"]["yaw"]["best_offset_rmse_deg"] < 0.3 * late["axes"]["yaw"]["rmse_deg"]
    assert "late" in plot.read_text()
    with h5netcdf.File(output) as file:
        assert set(file.groups) == {"start", "late"}
        assert file["start"]["x"].shape == (first["steps"] + 1,)
        assert file["late"].attrs["command"].startswith("hypertuna")


def test_command_says_it_in_words():
    said = run(TANK / "tank.toml").output
    assert "rmse of 3 runs" in said
    assert "Not replayed: 24 steady runs." in said


def test_options_that_a_manifest_decides_are_refused(tmp_path):
    for option in (
        ["--columns", "a"],
        ["--yaw-clockwise"],
        ["--noise", "0"],
        ["--poses", "p.csv"],
        ["--start", "0,0,0"],
    ):
        error = run(TANK / "tank.toml", *option).exception
        assert (
            str(error) == f"{option[0]} cannot be combined with a manifest or a folder: "
            "leave it out, or give a CSV file of joint angles."
        )
    error = run(TANK / "angles.csv").exception
    assert str(error).startswith("--columns is required with a CSV file")
    steady = tmp_path / "steady.toml"
    steady.write_text(f'format = 1\nsteady = ["{TANK}/tank.csv"]')
    assert "must hold at least one recording" in str(run(steady).exception)


def test_a_recording_that_diverges_is_reported_and_the_others_are_compared(tmp_path):
    path = two_recordings(tmp_path)
    rows = (TANK / "angles.csv").read_text().splitlines()
    wild = [f"{t},{3000 * float(a)},{b}" for t, a, b in (row.split(",", 2) for row in rows[2:])]
    (tmp_path / "wild.csv").write_text("\n".join([rows[1], *wild]))
    text = path.read_text()
    at = text.rindex(f'"{TANK}/angles.csv"')
    path.write_text(text[:at] + text[at:].replace(f'"{TANK}/angles.csv"', '"wild.csv"', 1))
    done = run(path, "--json", "--step", "0.05")
    assert done.exit_code == 1
    first, late = json.loads(done.output)["recordings"]
    assert (first["status"], late["status"]) == ("completed", "diverged")
    assert "axes" in first
    assert "axes" not in late


def test_the_fitted_time_offset_counts(tmp_path):
    """In place of the recording's own, whose errors stay in the JSON; a recording that the fit leaves out keeps it."""
    fitted = load("hypertuna").document()
    one = {
        "names": ["time_offset[start]"],
        "units": ["s"],
        "scale": ["natural"],
        "value": [0.05],
        "covariance": [[1e-6]],
    }
    fitted["fit"] = one | {"text": "identified", "trials": "tank.toml", "seed": 0, "lower": [-0.25], "upper": [0.25]}
    robot = write_robot(parse(fitted), tmp_path / "fit.toml")
    path = two_recordings(tmp_path)
    plain, moved = (
        json.loads(CliRunner().invoke(app, ["replay", str(path), "--robot", str(name), "--json"]).output)["recordings"]
        for name in ("hypertuna", robot)
    )
    assert [r["time_offset_source"] for r in plain] == ["trials", "trials"]
    assert [r["time_offset_source"] for r in moved] == ["fit", "trials"]
    assert moved[0]["time_offset_s"] == 0.05
    own = moved[0]["without_fitted_offset"]
    assert (own["time_offset_s"], own["axes"]) == (plain[0]["time_offset_s"], plain[0]["axes"])
    assert moved[0]["axes"]["yaw"]["rmse_deg"] > 1.1 * own["axes"]["yaw"]["rmse_deg"]  # the clocks agree without it
    assert moved[1]["axes"] == plain[1]["axes"]
    said = CliRunner().invoke(app, ["replay", str(path), "--robot", str(robot)]).output
    assert "time offset 0.050 s from [fit], in place of 0 s" in said
