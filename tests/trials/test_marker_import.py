"""Tracks of a real fish: results that contradict the robot are reported, and a refusal names the cause and its fix."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.cli.main import app
from hypertuna.description.new import new_robot
from hypertuna.description.pose import coordinate_names
from hypertuna.description.robot import parse
from hypertuna.description.writer import write_robot
from hypertuna.trials.chain import chain_of
from hypertuna.trials.comparison import compare_recording, replay_recording
from hypertuna.trials.marker_import import ChainOptions, fit_marker_run, in_order, read_marker_run
from hypertuna.trials.marker_places import equal_spacing, read_places
from hypertuna.trials.markers import read_markers
from hypertuna.trials.trials import read_trials

CASES = Path(__file__).parents[3] / "shared" / "cases"
COUNT, NOISE = 14, 5e-4  # markers; m, of a coordinate


@pytest.fixture(scope="module")
def eel():
    return ht.load("rexeel")


def swim(eel, frames: int = 120):
    """Time [s] and unknowns of a straight swim to +x."""
    time = np.arange(frames) / 60
    waves = [math.radians(12 + 3 * g) * np.sin(2 * np.pi * 1.5 * time - 0.9 * g) for g in range(len(eel.joints))]
    heading = math.pi + 0.1 * np.sin(9 * time)
    return time, np.column_stack([0.4 + 0.3 * time, 0 * time, heading, *waves])


def tracked(eel, path, *, across=0.0, scale=(1, 1), order=slice(None), lost=0.0, noise=NOISE, names=None):
    """Write markers of the swim; return the unknowns."""
    time, z = swim(eel)
    names = names or [f"m{k + 1}" for k in range(COUNT)]
    places = equal_spacing(eel, names)
    rng = np.random.default_rng(1)
    place = chain_of(eel, places.link, places.along, np.zeros(COUNT) + across)(z)[0]
    place = (place + noise * rng.standard_normal(place.shape)) * scale
    place[rng.random(place.shape[:2]) < lost] = np.nan
    head = ["time_s", *(f"{name}_{axis}" for name in np.array(names)[order] for axis in "xy")]
    rows = [[f"{t:.5f}", *(f"{v:.6f}" for v in row.ravel())] for t, row in zip(time, place[:, order], strict=True)]
    path.write_text("\n".join(",".join(row) for row in [head, *rows]).replace("nan", "") + "\n")
    return z


def error_deg(run, z):
    own = np.concatenate(run.stretches)
    return np.degrees(np.sqrt(np.mean((run.fit.angle[own] - z[own, 3:]) ** 2, axis=0)))


def refusal(run) -> str:
    assert run.refusal() is not None
    return str(run.refusal())


def hinged():
    """A fish of two driven joints whose fin hangs on a spring."""
    document = new_robot("fish", links=4, length=0.4, mass=1.5)
    document["joints"] = document["joints"][:2]
    for name in ("gaits", "gait_bounds"):
        del document[name], document["sources"][name]
    document["hinge"] = {"link": 3, "stiffness_n_m_per_rad": 0.1, "damping_n_m_s_per_rad": 1e-3}
    document["sources"]["hinge"] = "bench"
    return parse(document, file="fish.toml")


def film_of(robot, gait, path) -> ht.Swim:
    """Write the markers of eight settled beats of a robot, at 50 frames a second."""
    swum = ht.swim(robot, gait)
    motion = swum.continued(8)
    clock = np.arange(0, 8 / gait.frequency, 0.02)
    names = coordinate_names(robot)
    lead = [robot.joints[g].links[0] for g in range(len(robot.joints))] + [hinge.link for hinge in robot.hinges]
    angles = motion["joint_angle"].to_numpy()[:, lead]
    columns = [motion[name].to_numpy() for name in ("x", "y", "heading")]
    z = np.column_stack([np.interp(clock, motion["time"], column) for column in (*columns, *angles.T)])
    places = equal_spacing(robot, [f"m{k + 1}" for k in range(COUNT)])
    place = chain_of(robot, places.link, places.along, places.across)(z)[0]
    place += 3e-4 * np.random.default_rng(2).standard_normal(place.shape)
    head = ["time_s", *(f"m{k + 1}_{axis}" for k in range(COUNT) for axis in "xy")]
    rows = [",".join([f"{t:.5f}", *(f"{v:.6f}" for v in row.ravel())]) for t, row in zip(clock, place, strict=True)]
    path.write_text("\n".join([",".join(head), *rows]) + "\n")
    assert names == ("J1", "J2", "hinge")
    return swum


def test_markers_in_pairs_need_places(eel, tmp_path) -> None:
    """Seven on each side, 10 mm off the midline, which are not equally spaced along it."""
    names = [f"{side}{k}" for k in range(COUNT // 2) for side in "lr"]
    time, z = swim(eel)
    places = equal_spacing(eel, names[::2])
    link, along = np.repeat(places.link, 2), np.repeat(places.along, 2)
    place = chain_of(eel, link, along, np.tile([-0.01, 0.01], COUNT // 2))(z)[0]
    head = ["time_s", *(f"{name}_{axis}" for name in names for axis in "xy")]
    rows = [[f"{t:.5f}", *(f"{v:.5f}" for v in row.ravel())] for t, row in zip(time, place, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(map(",".join, [head, *rows])) + "\n")
    with pytest.raises(ht.InputError, match="in pairs at one place of the body, as l0 and r0: raw and smoothed"):
        fit_marker_run(eel, tmp_path / "a.csv", ChainOptions())
    # places that are taken from the run may be in pairs; angles are then right to 1.4 deg
    assert in_order(read_markers(tmp_path / "a.csv"), pairs=True)[0] == [*range(COUNT)]


def test_a_film_of_a_fin_on_a_spring_gives_its_bend_and_replays_it(tmp_path) -> None:
    """The hinge is fitted like a joint: amplitude and lag as a table of steady runs has them, and replays bend it."""
    robot = hinged()
    write_robot(robot, tmp_path / "fish.toml")
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, 60))
    (bend,) = film_of(robot, gait, tmp_path / "a.csv").bends
    assert bend.bend_amplitude > 0.05
    arguments = ["--robot", str(tmp_path / "fish.toml"), "--output", str(tmp_path / "a.toml"), "--json"]
    out = CliRunner().invoke(app, ["trials", "import", "markers", str(tmp_path / "a.csv"), *arguments])
    assert out.exit_code == 0, out.output
    found = json.loads(out.stdout)["runs"][0]
    assert found["rejected"] == 0
    assert found["frequency_hz"] == pytest.approx(2, rel=5e-3)
    assert found["bend_amplitude_deg"] == pytest.approx(math.degrees(bend.bend_amplitude), rel=0.02)
    assert found["bend_lag_deg"] == pytest.approx(math.degrees(bend.bend_lag), abs=2)
    merged = fit_marker_run(robot, tmp_path / "a.csv", ChainOptions(merge=[("J2", "hinge")]))
    assert merged.fit.angle[:, 2] == pytest.approx(merged.fit.angle[:, 1])  # one bend, where markers are few
    (recording,) = read_trials(tmp_path / "a.toml", robot).recordings
    assert recording.hinges == 1
    measured = compare_recording(robot, recording, replay_recording(robot, recording))
    rigid = replace(recording, hinges=0, joints=replace(recording.joints, angle=recording.joints.angle[:, :2]))
    stiff = compare_recording(robot, rigid, replay_recording(robot, rigid))
    errors = [float(one["rmse"].sel(axis="x")) for one in (measured, stiff)]
    assert errors[0] < 0.2 * errors[1]


def test_markers_whose_names_are_sorted_as_text_follow_their_numbers(eel, tmp_path) -> None:
    order = sorted(range(COUNT), key=lambda k: f"m{k + 1}")
    z = tracked(eel, tmp_path / "a.csv", order=order)
    run = read_marker_run(eel, tmp_path / "a.csv")
    assert run.places.names == tuple(f"m{k + 1}" for k in range(COUNT))
    assert (error_deg(run, z) < 1).all()
    assert run.warnings == ["a: markers are taken in the order of their numbers, m1 to m14."]


def test_markers_that_do_not_lie_in_their_order_are_refused_with_the_order_that_they_lie_in(eel, tmp_path) -> None:
    """As after a sort of their names by the alphabet."""
    words = "snout eye gill heart liver dorsal belly anal rib spine peduncle root fin tip"
    names = words.split()
    order = sorted(range(COUNT), key=lambda k: names[k])
    tracked(eel, tmp_path / "a.csv", order=order, names=names)
    with pytest.raises(ht.InputError, match=r"lie as (snout, eye, gill, .* tip|tip, fin, .* snout), or the other way"):
        read_marker_run(eel, tmp_path / "a.csv")


def test_a_robot_that_moves_tail_first_all_the_time_is_told(eel, tmp_path) -> None:
    z = tracked(eel, tmp_path / "a.csv", order=slice(None, None, -1))
    assert "moves tail first all the time" in " ".join(read_marker_run(eel, tmp_path / "a.csv").warnings)
    turned = fit_marker_run(eel, tmp_path / "a.csv", ChainOptions(tail_first=True))
    assert turned.warnings == []
    assert (error_deg(turned, z) < 1).all()


def test_a_marker_off_the_midline_is_named_with_the_place_that_fits(eel, tmp_path) -> None:
    across = np.zeros(COUNT)
    across[5] = 0.02
    z = tracked(eel, tmp_path / "a.csv", across=across)
    run = read_marker_run(eel, tmp_path / "a.csv")
    (sentence,) = run.warnings
    assert "marker m6 lies -0.0 mm along and +20.0 mm across its link" in sentence
    assert "across_m = 0.0200 on link 2 would fit" in sentence
    assert run.record()["marker_across_mm"][5] == pytest.approx(20, abs=0.3)
    assert run.record()["marker_rejected"].tolist() == [120 * (m == 5) for m in range(COUNT)]
    assert run.noises == pytest.approx(np.full(COUNT, NOISE), rel=0.5)
    without = fit_marker_run(eel, tmp_path / "a.csv", ChainOptions(leave_out=["m6"]))
    assert "m6" not in without.places.names
    with pytest.raises(ht.InputError, match="--leave-out must be a tracked marker, but is 'm66': did you mean m6"):
        fit_marker_run(eel, tmp_path / "a.csv", ChainOptions(leave_out=["m66"]))
    assert (error_deg(run, z) < 1.5).all()


def test_places_taken_from_the_run_give_the_angles_of_a_fish_that_is_straight_in_the_mean(eel, tmp_path) -> None:
    """Every marker 8 mm off at random: 10 deg of error with places on the midline, 2 with those of the run."""
    z = tracked(eel, tmp_path / "a.csv", across=np.random.default_rng(3).normal(0, 8e-3, COUNT))
    plain = fit_marker_run(eel, tmp_path / "a.csv", ChainOptions())
    assert max(error_deg(plain, z)) > 8
    assert "by --places-from-run" in " ".join(plain.warnings)
    learned = fit_marker_run(eel, tmp_path / "a.csv", ChainOptions(from_run=True))
    assert (error_deg(learned, z) < 2.5).all()
    assert learned.fit.noise < 3 * NOISE < plain.fit.noise


@pytest.mark.parametrize("factor", [0.86, 1.2])
def test_a_wrong_scale_is_refused_with_the_one_that_fits(eel, tmp_path, factor) -> None:
    tracked(eel, tmp_path / "a.csv", scale=(factor, factor))
    text = refusal(fit_marker_run(eel, tmp_path / "a.csv", ChainOptions()))
    assert "correct the scale: the line through the markers is" in text
    fit = float(text.partition("than along the body; ")[2].split()[0])
    assert fit == pytest.approx(1 / factor, rel=0.02)


def test_another_unit_is_named(eel, tmp_path) -> None:
    tracked(eel, tmp_path / "a.csv", scale=(1000, 1000))
    with pytest.raises(ht.InputError, match=r"must span about the robot, but is \d+ m wide: is the unit another"):
        fit_marker_run(eel, tmp_path / "a.csv", ChainOptions())


def test_a_refusal_of_lost_markers_does_not_blame_the_scale(eel, tmp_path) -> None:
    tracked(eel, tmp_path / "a.csv", lost=0.8)
    text = refusal(fit_marker_run(eel, tmp_path / "a.csv", ChainOptions()))
    assert "of the markers are missing: add markers near that joint, or --merge" in text
    assert "scale" not in text
    tracked(eel, tmp_path / "b.csv", lost=0.95)
    text = refusal(fit_marker_run(eel, tmp_path / "b.csv", ChainOptions()))
    assert "in which 5 markers are seen: track more markers" in text


def test_merged_joints_share_one_bend(eel, tmp_path) -> None:
    tracked(eel, tmp_path / "a.csv")
    run = fit_marker_run(eel, tmp_path / "a.csv", ChainOptions(merge=[["4", "5"]]))
    assert run.fit.angle[:, 3] == pytest.approx(run.fit.angle[:, 4])
    assert np.ptp(run.fit.angle[:, 2] - run.fit.angle[:, 3]) > 0.1
    assert run.fit.sd[:, 6] == pytest.approx(run.fit.sd[:, 7])
    with pytest.raises(ht.InputError, match="--merge must be a joint group, but is '6'"):
        fit_marker_run(eel, tmp_path / "a.csv", ChainOptions(merge=[["4", "6"]]))


def test_angles_beyond_what_a_joint_does_are_told(eel, tmp_path) -> None:
    tracked(eel, tmp_path / "a.csv")
    made = read_marker_run(eel, tmp_path / "a.csv")
    text = " ".join(replace(made, limits=np.full(5, math.radians(10))).warnings)
    assert "joint 5 bends by 2" in text
    assert "and is described for 10 deg" in text


def test_a_quarter_of_the_markers_rejected_is_told(eel, tmp_path) -> None:
    tracked(eel, tmp_path / "a.csv")
    made = read_marker_run(eel, tmp_path / "a.csv")
    rejected = np.zeros((120, COUNT), dtype=bool)
    rejected[:, : COUNT // 4] = True
    few = replace(made, fit=replace(made.fit, rejected=rejected)).warnings
    rejected[:, COUNT // 4] = True
    many = replace(made, fit=replace(made.fit, rejected=rejected)).warnings
    assert few == []
    assert many == ["a: 29 % of the markers are rejected: check their order, their places and the robot before you use "
                    "the angles."]  # fmt: skip


def run(*arguments):
    return CliRunner().invoke(app, ["trials", "import", "markers", *(str(argument) for argument in arguments)])


def test_the_picture_is_written_also_where_the_run_is_refused(eel, tmp_path) -> None:
    tracked(eel, tmp_path / "a.csv", lost=0.9)
    done = run(tmp_path / "a.csv", "--robot", "rexeel", "-o", tmp_path / "out.toml")
    assert f"the picture is {tmp_path}/out.svg" in str(done.exception)
    assert "none can be used" in (tmp_path / "out.svg").read_text()
    assert not (tmp_path / "out.toml").exists()


def test_command_takes_places_from_a_run_and_writes_them(eel, tmp_path) -> None:
    across = np.random.default_rng(3).normal(0, 4e-3, COUNT)
    tracked(eel, tmp_path / "a.csv", across=across)
    options = ("--robot", "rexeel", "-o", tmp_path / "out.toml", "--places-from-run", tmp_path / "places.csv")
    done = run(tmp_path / "a.csv", *options, "--leave-out", "m3", "--merge", "4,5", "--json")
    assert done.exit_code == 0, done.output
    (said,) = json.loads(done.output)["runs"]
    assert len(said["marker_noise_mm"]) == COUNT - 1
    places = read_places(tmp_path / "places.csv", eel, [f"m{k + 1}" for k in range(COUNT)])
    assert places.names == tuple(said["markers"])
    assert np.abs(np.array(places.across) - np.delete(across, 2)).max() < 3e-3
    assert len(read_trials(tmp_path / "out.toml", eel).recordings) == 1


EXPECTED = {  # by the README of the cases: frames that are used and the last time, or the reported sentences
    "markers-reference": (48, 0.7833),
    "frames-as-floats-gap": (42, 0.7833),
    "anipose-fnum-gap": (42, 0.7833),
    "dlc-labeled-images": (16, 0.75),
    "names-in-order": (48, 0.7833),
    "names-sorted-as-text": (48, 0.7833),
    "sleap-corrected-frames": (48, 0.7833),
    "likelihood-percent": (48, 0.7833),
    "visible-words": (48, 0.7833),
    "tail-first": "the robot moves tail first all the time",
    "no-header-savetxt": "has no line of names above its numbers",
    "motive-header": "--unit must be 1 m, as the file says, but is px",
    "two-animals-centroids": "is of the form of idtracker.ai",
}


@pytest.mark.skipif(not CASES.exists(), reason="the cases are not there")
@pytest.mark.parametrize("case", EXPECTED)
def test_a_case_that_went_wrong_is_right(case) -> None:
    robot, expected = ht.load(CASES / "three.toml"), EXPECTED[case]
    clocked = (CASES / f"{case}.csv").read_text()[:6] in ("time_s", "second", "Format")
    options = {"scale": 0.001, "pixels": True, "frame_rate": None if clocked else 60.0}
    if isinstance(expected, str) and case != "tail-first":
        with pytest.raises(ht.InputError, match=expected):
            read_marker_run(robot, CASES / f"{case}.csv", **options)
        return
    made = read_marker_run(robot, CASES / f"{case}.csv", **options)
    if isinstance(expected, str):
        assert expected in " ".join(made.warnings)
        return
    used = np.concatenate(made.stretches)
    assert (len(used), made.markers.time[used[-1]]) == (expected[0], pytest.approx(expected[1], abs=1e-4))
    assert len(made.stretches) == 1 + case.endswith("-gap")
    last = math.degrees(made.head[used[-1], 2]) % 360
    assert last == pytest.approx(181.3 if len(used) != 16 else last, abs=1.0)
    if case == "names-sorted-as-text":
        frame = int(np.argmin(np.abs(made.markers.time - 0.1167)))
        assert np.degrees(made.fit.angle[frame]) == pytest.approx([10.57, 10.26], abs=0.02)


@pytest.mark.skipif(not CASES.exists(), reason="the cases are not there")
def test_an_export_of_motive_is_read_with_its_own_unit() -> None:
    robot = ht.load(CASES / "three.toml")
    made = read_marker_run(robot, CASES / "motive-header.csv")
    reference = read_marker_run(robot, CASES / "markers-reference.csv", scale=0.001, pixels=True)
    assert np.degrees(np.abs(made.fit.angle - reference.fit.angle)).max() < 0.2


def test_a_marker_that_stands_still_is_named(eel, tmp_path):
    """A corner of the tank among the markers of the body, with the noise of all."""
    tracked(eel, tmp_path / "a.csv")
    head, *rows = (tmp_path / "a.csv").read_text().splitlines()
    noise = np.random.default_rng(2).normal(0.9, NOISE, (len(rows), 2))
    corner = [f"{row},{x:.6f},{y:.6f}" for row, (x, y) in zip(rows, noise, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join([f"{head},corner_x,corner_y", *corner]) + "\n")
    with pytest.raises(ht.InputError, match="marker corner must move with the others, or be left out, but is still"):
        read_marker_run(eel, tmp_path / "a.csv")
    assert fit_marker_run(eel, tmp_path / "a.csv", ChainOptions(leave_out=["corner"])).refusal() is None


def test_likelihoods_that_count_the_other_way_are_told(eel, tmp_path):
    tracked(eel, tmp_path / "a.csv")
    head, *rows = (tmp_path / "a.csv").read_text().splitlines()
    text = [f"{head},m1_likelihood", *(f"{row},0.9" for row in rows)]
    for m in range(2, COUNT + 1):
        text = [f"{text[0]},m{m}_likelihood", *(f"{row},0.02" for row in text[1:])]
    (tmp_path / "a.csv").write_text("\n".join(text) + "\n")
    with pytest.raises(ht.InputError, match="whether the column of likelihoods counts the other way round"):
        read_marker_run(eel, tmp_path / "a.csv")
