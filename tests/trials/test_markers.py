"""Tracked markers to joint angles: a synthetic round trip within the noise's bound, formats, places, errors."""

import json
import math
import runpy
import sys
from inspect import signature
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.cli.main import app
from hypertuna.identification.identify import identify
from hypertuna.trials.chain import TUKEY, _losses, chain_of, check_rank, fit_chain
from hypertuna.trials.marker_import import read_marker_run, write_marker_runs
from hypertuna.trials.marker_places import equal_spacing, read_places
from hypertuna.trials.markers import read_markers
from hypertuna.trials.trials import read_trials

NOISE = 5e-4  # m, of a coordinate


def motion(robot, frames=120, rate=60.0):
    """Time [s] and unknowns (frames, n) of a swim through a curve: nose, heading and joint angles [m, rad]."""
    time = np.arange(frames) / rate
    groups = len(robot.joints)
    waves = [math.radians(12 + 3 * g) * np.sin(2 * np.pi * 1.5 * time - 0.9 * g) for g in range(groups)]
    heading = 2.8 + 0.8 * time + 0.1 * np.sin(9 * time)
    return time, np.column_stack([0.4 + 0.2 * time, 0.1 * time, heading, *waves])


def markers_of(robot, count):
    """A chain with markers at equal distances."""
    places = equal_spacing(robot, [f"m{k}" for k in range(count)])
    return chain_of(robot, places.link, places.along, places.across)


@pytest.mark.parametrize(("name", "count"), [("rexeel", 8), ("rexeel", 20), ("hypertuna", 9)])
def test_noise_free_markers_give_the_angles_back(name, count):
    robot = ht.load(name)
    chain = markers_of(robot, count)
    _, z = motion(robot)
    fit = fit_chain(chain, chain(z)[0], np.ones((len(z), count)))
    assert fit.angle == pytest.approx(z[:, 3:], abs=1e-8)
    turns = 2 * math.pi * round((z[0, 2] - fit.pose[0, 2]) / (2 * math.pi))
    assert fit.pose == pytest.approx(z[:, :3] - [0, 0, turns], abs=1e-8)
    assert fit.determined.all()
    assert not fit.rejected.any()


def test_jacobian_of_the_chain_is_that_of_its_places():
    chain = markers_of(ht.load("hypertuna"), 7)
    _, z = motion(ht.load("hypertuna"), frames=3)
    for k in range(z.shape[1]):
        step = 1e-6 * np.eye(z.shape[1])[k]
        difference = (chain(z + step)[0] - chain(z - step)[0]) / 2e-6
        assert chain(z)[1][..., k] == pytest.approx(difference, abs=1e-8)


@pytest.mark.parametrize("lost", [0.0, 0.1])
@pytest.mark.parametrize("swapped", [0, 8])
def test_errors_are_those_of_the_linearized_covariance(lost, swapped):
    """(z - truth)' C^-1 (z - truth) has the mean n = 8 unknowns, +-4 sqrt(2 n / frames), lost and swapped or not."""
    eel = ht.load("rexeel")
    chain = markers_of(eel, 14)
    _, z = motion(eel, frames=300)
    rng = np.random.default_rng(3)
    place = chain(z)[0] + NOISE * rng.standard_normal((300, 14, 2))
    weight = (rng.random((300, 14)) >= lost).astype(float)
    for frame in rng.choice(300, swapped, replace=False):  # two markers trade places for one frame
        a, b = rng.choice(14, 2, replace=False)
        place[frame, [a, b]] = place[frame, [b, a]]
    place[weight == 0] = np.nan
    fit = fit_chain(chain, place, weight)
    assert fit.noise == pytest.approx(NOISE, rel=0.05)
    error = np.column_stack([fit.pose, fit.angle]) - z
    error[:, 2] -= 2 * math.pi * np.round(error[:, 2] / (2 * math.pi))
    own = fit.determined
    assert own.mean() > 0.9
    covariance = fit.covariance[own] * (NOISE / fit.noise) ** 2
    square = np.einsum("fi,fij,fj->f", error[own], np.linalg.inv(covariance), error[own])
    n = z.shape[1]
    assert abs(square.mean() - n) < 4 * math.sqrt(2 * n / own.sum())
    assert (np.abs(error[own]) < 5.5 * fit.sd[own]).all()
    if not swapped:
        assert fit.rejected.sum() <= 3  # 6 sd of a distance: exp(-18) of the markers
    else:
        assert fit.rejected.sum() >= 2 * swapped - 4  # neighbors that trade places may still be near


def write_plain(path, robot, count=14, frames=120, noise=NOISE, seed=1):
    """Write markers of a swim in pixels of 0.5 mm, y down, with a few missing; return time and truth."""
    time, z = motion(robot, frames)
    rng = np.random.default_rng(seed)
    place = markers_of(robot, count)(z)[0]
    place = (place + noise * rng.standard_normal(place.shape)) * [2000, -2000]
    lost = rng.random((frames, count)) < 0.05
    heads = ["time_s", *(f"{axis}{k + 1}" for k in range(count) for axis in "xy")]
    lines = [",".join(heads)]
    for t, row, missing in zip(time, place, lost, strict=True):
        cells = (f"{x:.3f}" if not gone else "" for point, gone in zip(row, missing, strict=True) for x in point)
        lines.append(",".join([f"{t:.5f}", *cells]))
    path.write_text("\n".join(lines) + "\n")
    return time, z


def run(*arguments):
    return CliRunner().invoke(app, ["trials", "import", "markers", *(str(argument) for argument in arguments)])


def test_command_writes_what_trials_reads(tmp_path):
    eel = ht.load("rexeel")
    time, z = write_plain(tmp_path / "swim.csv", eel)
    manifest, plot = tmp_path / "swim.toml", tmp_path / "swim.svg"
    options = ("--robot", "rexeel", "--unit", "px", "--scale", 0.0005, "-o", manifest)
    done = run(tmp_path / "swim.csv", *options, "--plot", plot, "--json")
    assert done.exit_code == 0, done.output
    (said,) = json.loads(done.output)["runs"]
    assert said["frames"] == 120
    assert said["noise_mm"] == pytest.approx(1e3 * NOISE, rel=0.1)
    assert said["length_ratio"] == pytest.approx(1, abs=0.01)
    assert "chain of the robot" in plot.read_text()
    (recording,) = read_trials(manifest, eel).recordings
    own = np.isin(np.round(time, 4), np.round(recording.joints.time, 4))
    error = recording.joints.angle - z[own, 3:]
    assert (np.sqrt(np.mean(error**2, axis=0)) < 1.3 * np.radians(said["angle_sd_deg"])).all()
    head = recording.tracks[0].pose[:, :2] - z[own, :2]
    assert np.linalg.norm(head, axis=1) == pytest.approx(0.06, abs=6 * 1e-3 * max(said["head_sd_mm"]))


def deeplabcut(place, likelihood):
    """Lines of a file of DeepLabCut."""
    names = [f"m{k}" for k in range(place.shape[1])]
    head = [["scorer"] + ["net"] * 3 * len(names), ["bodyparts"] + [n for n in names for _ in range(3)]]
    head.append(["coords"] + ["x", "y", "likelihood"] * len(names))
    rows = [
        [str(k), *(f"{v}" for point, p in zip(row, sure, strict=True) for v in (*point, p))]
        for k, (row, sure) in enumerate(zip(place, likelihood, strict=True))
    ]
    return "\n".join(",".join(row) for row in head + rows)


def sleap(place, score):
    """Lines of an analysis file of SLEAP, with a second animal."""
    names = [f"m{k}" for k in range(place.shape[1])]
    head = ["track", "frame_idx", "instance.score", *(f"{n}.{a}" for n in names for a in ("x", "y", "score"))]
    rows = [
        [track, str(k), "1", *(f"{v}" for point, p in zip(row, sure, strict=True) for v in (*point, p))]
        for track in ("eel", "perch")
        for k, (row, sure) in enumerate(zip(place, score, strict=True))
    ]
    return "\n".join(",".join(row) for row in [head, *rows])


def plain(place, score):
    """Lines of plain columns, nose_x, nose_y, ..., with a column without a use."""
    names = [f"m{k}" for k in range(place.shape[1])]
    head = ["frame", "comment", *(f"{n}_{a}" for n in names for a in ("x", "y", "likelihood"))]
    rows = [
        [str(k), "7", *(f"{v}" for point, p in zip(row, sure, strict=True) for v in (*point, p))]
        for k, (row, sure) in enumerate(zip(place, score, strict=True))
    ]
    return "\n".join(",".join(row) for row in [head, *rows])


@pytest.mark.parametrize("form", [deeplabcut, sleap, plain])
def test_formats_read_alike(tmp_path, form):
    rng = np.random.default_rng(0)
    place, sure = rng.random((20, 4, 2)), np.full((20, 4), 0.9)
    sure[3, 2] = 0.2
    (tmp_path / "a.csv").write_text(form(place, sure))
    given = {"individual": "eel"} if form is sleap else {}
    markers = read_markers(tmp_path / "a.csv", scale=0.5, frame_rate=50.0, y_down=True, **given)
    assert markers.names == ("m0", "m1", "m2", "m3")
    assert markers.time == pytest.approx(np.arange(20) / 50)
    assert np.isnan(markers.place[3, 2]).all()
    markers.place[3, 2] = place[3, 2] * [0.5, -0.5]
    assert markers.place == pytest.approx(place * [0.5, -0.5])
    assert markers.weight[3].tolist() == [0.9, 0.9, 0, 0.9]
    assert markers.ignored == (("comment",) if form is plain else ())


def told(call, *arguments, **options):
    with pytest.raises(ht.InputError) as error:
        call(*arguments, **options)
    return str(error.value)


def test_errors_name_line_column_rule_value_and_fix(tmp_path):
    eel, path = ht.load("rexeel"), tmp_path / "bad.csv"
    rows = [[f"{k / 30}", *(f"{x}" for x in range(8))] for k in range(15)]
    rows[4][3] = "3,1"[:1] + "o"
    path.write_text("\n".join(",".join(row) for row in [["t", *(f"{a}{k}" for k in "1234" for a in "xy")], *rows]))
    text = told(read_markers, path)
    assert "bad.csv: line 6, x2 must be a number, but is '3o': give a number, or leave the cell empty" in text
    rows[4][3] = "1e300"
    path.write_text("\n".join(",".join(row) for row in [["t", *(f"{a}{k}" for k in "1234" for a in "xy")], *rows]))
    assert "line 6, x2 must be from -1e+12 to 1e+12, but is 1e+300" in told(read_markers, path)
    rows[4] = ["0", *rows[3][1:]]
    path.write_text("\n".join(",".join(row) for row in [["t", *(f"{a}{k}" for k in "1234" for a in "xy")], *rows]))
    assert "line 6, t must be later than the previous frame" in told(read_markers, path)
    path.write_text(plain(np.zeros((15, 3, 2)), np.ones((15, 3))))
    assert "must have a column of time, but is missing: give --frame-rate" in told(read_markers, path)
    assert "must determine every joint angle, but leave that of joint group" in told(
        read_marker_run, eel, path, frame_rate=30.0
    )
    path.write_text(sleap(np.zeros((15, 3, 2)), np.ones((15, 3))))
    assert "--individual must be one of eel, perch: choose the animal" in told(read_markers, path, frame_rate=30.0)
    assert "did you mean eel?" in told(read_markers, path, frame_rate=30.0, individual="eels")
    (tmp_path / "a.h5").write_bytes(b"")
    assert "must be a whole HDF5 file" in told(read_markers, tmp_path / "a.h5")


def test_places_of_markers(tmp_path):
    eel, path = ht.load("rexeel"), tmp_path / "places.csv"
    path.write_text("marker,link,along_m,across_m\nfin,L2,0.01,0.002\nnose,0,0,\n")
    assert read_places(path, eel, ["nose", "tail", "fin"]) == (("fin", "nose"), (2, 0), (0.01, 0.0), (0.002, 0.0))
    path.write_text("marker,from_nose_m\nnose,0\ntail,0.61\nfin,0.15\n")
    found = read_places(path, eel, ["nose", "tail", "fin"])
    assert found.link == (0, 5, 1)
    assert found.along == pytest.approx((0, 0.098, 0.03))
    path.write_text("marker,from_nose_m\nsnout,0\n")
    assert "line 2, marker must be a tracked marker, but is 'snout'" in told(read_places, path, eel, ["nose", "tail"])
    path.write_text("marker,from_nose_m\nnose,0.7\n")
    assert "must be 0 to 0.61 m, the length of the links" in told(read_places, path, eel, ["nose"])
    check_rank(markers_of(eel, 7), ["m"] * 7, "f")
    with pytest.raises(ht.InputError, match="joint group 5 open"):
        check_rank(chain_of(eel, [0, 0, 1, 2, 3, 4], [0, 0.1, 0.05, 0.05, 0.05, 0.09], [0.0] * 6), ["m"] * 6, "f")


def test_a_marker_that_no_frame_shows_has_no_residual(tmp_path):
    """Its column is empty: no mean over nothing, of which Python warns."""
    eel, path = ht.load("rexeel"), tmp_path / "swim.csv"
    write_plain(path, eel)
    head, *lines = path.read_text().splitlines()
    cells = [line.split(",") for line in lines]
    write_lines = [head, *(",".join([*row[:5], "", "", *row[7:]]) for row in cells)]
    path.write_text("\n".join(write_lines) + "\n")
    made = read_marker_run(eel, path, scale=0.0005, y_down=True)
    assert np.isnan(made.record()["marker_rms_mm"]).tolist() == [k == 2 for k in range(14)]


def test_wrong_scale_and_wrong_place_are_told(tmp_path):
    eel = ht.load("rexeel")
    write_plain(tmp_path / "swim.csv", eel)
    good = read_marker_run(eel, tmp_path / "swim.csv", scale=0.0005, y_down=True)
    assert not good.warnings
    slightly = read_marker_run(eel, tmp_path / "swim.csv", scale=0.00052, y_down=True)
    assert "4 % longer than along the chain" in " ".join(slightly.warnings)
    text = told(read_marker_run, eel, tmp_path / "swim.csv", scale=0.00047, y_down=True)  # joints 46 deg off
    assert "the line through the markers must be as long as along the chain" in text
    assert "6 % shorter" in text
    assert "1.07 times the scale would fit" in text
    text = told(read_marker_run, eel, tmp_path / "swim.csv", scale=0.0006, y_down=True)
    assert "correct the scale: the line through the markers is 19 % longer" in text


def test_example_is_what_its_script_makes(tmp_path, monkeypatch):
    """To a pixel's last digit; its three swims are in motion, and rejected are the two markers that it swaps."""
    eels, eel = Path(__file__).parents[2] / "examples" / "eel", ht.load("rexeel")
    monkeypatch.setattr(sys, "argv", ["make.py", str(tmp_path)])
    runpy.run_path(str(eels / "make.py"))
    for name in ("slow", "middle", "fast"):
        made, kept = (
            np.genfromtxt(folder / f"{name}.csv", delimiter=",", skip_header=2) for folder in (tmp_path, eels)
        )
        assert made == pytest.approx(kept, abs=0.11, nan_ok=True)
        run = read_marker_run(eel, eels / f"{name}.csv", scale=0.001, y_down=True)
        assert np.argwhere(run.fit.rejected).tolist() == [[30, 2], [30, 7]]


def test_markers_give_the_coefficients_back_within_their_intervals(tmp_path):
    """The eel of the example has 1.3 times the drags described: 95 % intervals hold that, to a third at most."""
    eel = ht.load("rexeel")
    trials = []
    for name in ("slow", "middle", "fast"):
        run = read_marker_run(eel, Path(__file__).parents[2] / f"examples/eel/{name}.csv", scale=0.001, y_down=True)
        write_marker_runs([run], eel, tmp_path / f"{name}.toml", "test")
        trials.append(read_trials(tmp_path / f"{name}.toml", eel))
    fit = identify(eel, trials[0] + trials[1] + trials[2], validate=0, starts=1)
    for truth, low, high in zip((1.3, 1.3, 1.0), fit.uncertainty.low, fit.uncertainty.high, strict=True):
        assert low < truth < high
        assert high - low < 0.7 * truth


def test_markers_are_as_the_file_says_and_half_sure_unless_told() -> None:
    defaults = {name: one.default for name, one in signature(read_markers).parameters.items() if name != "path"}
    assert {name: value for name, value in defaults.items() if value is not None} == {
        "pixels": False,
        "min_likelihood": 0.5,
    }


def test_the_loss_of_a_residual_is_zero_at_zero_and_flat_beyond_tukey_s_limit() -> None:
    loss, _ = _losses(np.array([0.0, TUKEY / 2, TUKEY, 2 * TUKEY]), tukey=True)
    np.testing.assert_allclose(loss, TUKEY**2 / 6 * np.array([0, 1 - 0.75**3, 1, 1]))
