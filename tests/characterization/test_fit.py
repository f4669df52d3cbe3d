"""Bench runs: reading, fits, coverage of intervals, and the information gain of another measurement."""

from __future__ import annotations

import math
import re
import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from drawn import apart
from hypertuna.actuation.bending import bend
from hypertuna.actuation.soft_joint import mooney, muscle
from hypertuna.characterization.data import Bench, read_bench
from hypertuna.characterization.experiment_design import information_gain
from hypertuna.characterization.fit import BenchFit, fit_bench
from hypertuna.characterization.problem import computed
from hypertuna.characterization.unknowns import unknowns, with_unknowns
from hypertuna.description.robot import parse
from hypertuna.description.writer import robot_text

EXAMPLE = Path(__file__).parents[2] / "examples" / "bench"
HEAD = "joint,side,branch,pressure_kpa,angle_deg\n"
PRESSURES = (60, 120, 180, 240)  # kPa


def written(folder: Path, text: str) -> Path:
    path = folder / "bench.csv"
    path.write_text(text)
    return path


def loops(
    robot: ht.Robot, folder: Path, *, noise: float = 0.0, seed: int = 0, joints: str = "I", sd: str = ""
) -> Bench:
    """Bend a robot to the left and back, read with some noise [deg]."""
    rng, rows = np.random.default_rng(seed), []
    for joint in joints.split(","):
        found = bend(robot, joint, 1e3 * np.array(PRESSURES), unload=True)
        assert found.unload_angle is not None
        for branch, path in (("load", found.angle), ("unload", found.unload_angle[::-1])):
            angles = np.degrees(path) + noise * rng.standard_normal(len(path))
            rows += [f"{joint},left,{branch},{p},{a:.9f},{sd}" for p, a in zip(PRESSURES, angles, strict=True)]
    return read_bench(written(folder, HEAD.replace("\n", ",angle_sd_deg\n") + "\n".join(rows)), robot)


# --- what is read


def test_the_example_is_read(tuna: ht.Robot) -> None:
    bench = read_bench(EXAMPLE / "bench.csv", tuna)
    assert len(bench.angle) == 40
    assert bench.joints == (0, 1)
    assert bench.sides(0) == (0, 1)
    assert (bench.pressure.max(), bench.unload.sum()) == (250e3, 20)
    assert np.isfinite(bench.volume).sum() == 5
    assert sorted(np.concatenate([loop.rows for loop in bench.loops]).tolist()) == list(range(40))
    assert not bench.warnings


def test_joints_are_found_by_name_or_number_and_columns_in_any_order(tuna: ht.Robot, tmp_path: Path) -> None:
    text = "angle_deg,run,pressure_kpa,side,joint\n5,a,100,left,II\n9,b,200,Right,2\n"
    bench = read_bench(written(tmp_path, text), tuna)
    assert bench.joint.tolist() == [1, 1]
    assert bench.side.tolist() == [0, 1]
    assert [loop.top for loop in bench.loops] == [100e3, 200e3]
    assert np.isnan(bench.angle_sd).all()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "must be a table, but is empty"),
        (HEAD, "must be a table, but is empty"),
        ("joint,side,angle_deg\nI,left,3\n", "pressure_kpa must be a column, but is missing"),
        ("joint,side,pressure_kpa,angle_deg,torque\nI,left,9,3,1\n", "line 1, torque is not a known column"),
        ("joint,joint,side,pressure_kpa,angle_deg\nI,I,left,9,3\n", "line 1, joint must appear only once"),
        (HEAD + "III,left,load,100,3\n", "line 2, joint must be a joint of hypertuna, but is 'III': did you mean II?"),
        (HEAD + "I,port,load,100,3\n", "line 2, side must be left, right or both, but is 'port'"),
        (HEAD + "I,left,up,100,3\n", "line 2, branch must be load or unload, but is 'up'"),
        (HEAD + "I,left,load,100,3\nI,left,load,nan,3\n", "line 3, pressure_kpa must be a finite number, but is 'nan'"),
        (HEAD + "I,left,load,100,-1e300\n", "line 2, angle_deg must be from -1e+12 to 1e+12, but is -1e+300"),
        (HEAD + "I,left,load,100,\n", "line 2 must have a measured value, but is empty: give angle_deg, volume_ml,"),
        (HEAD + "I,left,load,-5,3\n", "line 2, pressure_kpa must not be negative, but is -5"),
        (HEAD + "I,left,load,250000,3\n", "line 2, pressure_kpa must be at most 2000, but is 250000: give it in kPa"),
        (HEAD + "I,left,load,100,300\n", "line 2, angle_deg must be at most 180"),
        (HEAD + "I,right,load,100,-8\n", "line 2, angle_deg must be positive for the right side of joint I, too"),
        (HEAD + "I,left,load,100\n", "line 2 must have 5 cells"),
    ],
)
def test_a_bad_bench_is_reported_by_line_and_column(tuna: ht.Robot, tmp_path: Path, text: str, sentence: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(ht.InputError, match=re.escape(sentence)) as error:
        read_bench(path, tuna)
    assert str(error.value).startswith(str(path))


def test_angles_in_radians_are_warned_of(tuna: ht.Robot, tmp_path: Path) -> None:
    bench = read_bench(written(tmp_path, HEAD + "I,left,load,100,0.17\nI,left,load,200,0.3\n"), tuna)
    assert "measured in radians" in bench.warnings[0]


def test_a_robot_without_an_actuator_is_reported_which_table_it_lacks(tmp_path: Path) -> None:
    eel = ht.load("rexeel-theory") if "rexeel-theory" in ht.robots() else ht.load("rexeel")
    bench = read_bench(written(tmp_path, f"{HEAD}1,left,load,100,5\n"), eel)
    with pytest.raises(ht.InputError, match=r"drive_unit is missing: add the table \[drive_unit\]"):
        fit_bench(eel, bench)


def test_a_material_without_the_constants_in_use_is_reported(tuna: ht.Robot, tmp_path: Path) -> None:
    document = tuna.document() | {"sources": {}}
    document["drive_unit"]["material_set"] = "fe"
    del document["materials"]["DR10"]["modulus_fe_pa"]
    with pytest.raises(
        ht.InputError, match=re.escape("materials.DR10.modulus_fe_pa is missing for drive_unit.material_set = 'fe'")
    ):
        fit_bench(parse(document), loops(tuna, tmp_path))


def test_a_bench_without_pressure_tells_nothing(tuna: ht.Robot, tmp_path: Path) -> None:
    text = HEAD + "\n".join(f"I,left,load,0,{angle}" for angle in (0.1, -0.1, 0.05, 0.0))
    fit = fit_bench(tuna, read_bench(written(tmp_path, text), tuna), "lever,friction", starts=1)
    assert not fit.combinations
    assert max(one.singular_value for one in fit.directions) == 0
    assert fit.values == pytest.approx([one.described for one in fit.free])


# --- unknowns


def test_a_bench_is_computed_as_joints_bend(tuna: ht.Robot, tmp_path: Path) -> None:
    bench = loops(tuna, tmp_path, joints="I,II")
    rows = computed(tuna, bench)
    angle, volume = rows["angle"], rows["volume"]
    np.testing.assert_allclose(angle, bench.angle, rtol=1e-9)
    found = bend(tuna, "I", [240e3])
    top = (bench.joint == 0) & (bench.pressure == 240e3)
    np.testing.assert_allclose(volume[top], found.volume[0], rtol=1e-12)
    alone = computed(tuna, bench, 1)["angle"]
    assert np.isnan(alone[bench.joint == 0]).all()
    np.testing.assert_array_equal(alone[bench.joint == 1], angle[bench.joint == 1])


def test_unknowns_change_what_they_name(tuna: ht.Robot) -> None:
    frees = unknowns(tuna, (0, 1), both_sides=(0,))
    names = [one.name for one in frees]
    assert len(names) == 13
    assert "asymmetry[I]" in names
    assert "asymmetry[II]" not in names  # bent one way only
    values = np.array([one.described for one in frees])
    assert with_unknowns(tuna, frees, values).hash == tuna.hash  # what is described, again
    changed = with_unknowns(tuna, frees, values * 1.02)
    again = [one.described for one in unknowns(changed, (0, 1), both_sides=(0,))]
    # moduli and lengths are counted from what is described, which has changed
    kept = ["modulus" in name or "length" in name for name in names]
    assert again == pytest.approx(np.where(kept, values, 1.02 * values).tolist())
    was, now = (mooney(robot, "DR10").modulus for robot in (tuna, changed))
    assert now == pytest.approx(1.02 * was)
    actuators = [robot.joints[1].actuator for robot in (tuna, changed)]
    assert actuators[1].segment_length == pytest.approx([1.02 * x for x in actuators[0].segment_length])


def test_pull_goes_by_the_factor_that_stands_for_the_braid_angle(tuna: ht.Robot) -> None:
    """The ideal muscle: P (pi d^2 / 4) (3 cos^2 - 1) / sin^2, blocked at rest; walls carry nothing there."""
    (one,) = unknowns(tuna, (0,), names="braid_angle")
    force = np.asarray(muscle(tuna).at(np.ones(1), pressure=200e3)["pull"])[0]
    assert force == pytest.approx(
        200e3 * math.pi / 4 * tuna.drive_unit.outer_diameter**2 * math.exp(one.log(one.described)), rel=1e-12
    )
    for free in unknowns(tuna, (0,)):
        for value in (free.lower, free.described, free.upper):
            assert free.value(free.log(value)) == pytest.approx(value, rel=1e-12)
    angle = one.described
    by_hand = 4 / math.tan(angle) ** 3 / math.cos(angle) ** 2 / math.exp(one.log(angle)) * angle
    assert one.relative(angle) == pytest.approx(1 / by_hand, rel=1e-6)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"free": "leaver"}, "free leaver must be an unknown of this bench and robot: did you mean lever?"),
        ({"free": "lever[II]"}, "free lever[II] must be an unknown of this bench and robot: did you mean lever[I]?"),
        ({"free": "lever,lever[I]"}, "free lever[I] must be listed only once"),
        ({"free": ""}, "free must name at least one unknown"),
        ({"bounds": {"lever": (0.021, 0.03)}}, "bounds lever must include the described value, 1"),
        ({"bounds": {"lever": (0.03, 0.01)}}, "bounds lever must be the lower bound, then the upper one, but is 30 to"),
        ({"bounds": {"lever": (0.0, 0.03)}}, "bounds lever must be a lower bound above 0, then a higher upper bound"),
        ({"bounds": {"diameter_ratio": (0.5, 1.0)}}, "bounds diameter_ratio must end below 1"),
        ({"loss": "l2"}, "loss must be a known loss"),
        ({"starts": 0}, "starts must be from 1 to 1024"),
    ],
)
def test_bad_options_of_a_fit(tuna: ht.Robot, tmp_path: Path, options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ht.InputError, match=re.escape(sentence)):
        fit_bench(tuna, loops(tuna, tmp_path), **options)


# --- fits


def test_progress_is_reported_from_the_first_slopes_on(tuna: ht.Robot, tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    fit_bench(
        tuna,
        loops(tuna, tmp_path, sd="0.05"),
        "stiffness_factor",
        starts=1,
        progress=lambda done, total: told.append((done, total)),
    )
    assert told[0] == (1, 300)  # a search, then its rounds, then draws
    assert told == sorted(told)
    assert told[-1] == (232, 300)


def test_what_is_determined_comes_back_exactly(tuna: ht.Robot, tmp_path: Path) -> None:
    frees = unknowns(tuna, (0,), names="stiffness_factor,outer_diameter,friction")
    truth = np.array([one.described * f for one, f in zip(frees, (0.9, 1.1, 1.2), strict=True)])
    bench = loops(with_unknowns(tuna, frees, truth), tmp_path, sd="0.01")
    fit = fit_bench(tuna, bench, [one.name for one in frees], starts=1)
    assert fit.converged
    assert fit.values == pytest.approx(truth, rel=2e-3)
    assert ((fit.low <= truth) & (truth <= fit.high)).all()
    assert [one.constrained for one in fit.directions] == [True, True, True]
    assert len(fit.combinations) == 3
    assert not fit.warnings


def test_the_matrix_stiffness_against_bending_is_told_from_its_modulus(tuna: ht.Robot, tmp_path: Path) -> None:
    """E I holds both, but E A, by which the joint shortens, the modulus alone."""
    fit = fit_bench(tuna, loops(tuna, tmp_path, sd="0.05"), "stiffness_factor,matrix_modulus,friction", starts=1)
    assert [one.constrained for one in fit.directions] == [True, True, True]
    assert fit.directions[-1].singular_value < 0.1 * fit.directions[0].singular_value


def test_one_measured_bend_fixes_one_combination(tuna: ht.Robot, tmp_path: Path) -> None:
    text = "joint,side,pressure_kpa,angle_deg,angle_sd_deg\nI,left,250,18.2,0.1\n"
    fit = fit_bench(tuna, read_bench(written(tmp_path, text), tuna), "lever,stiffness_factor,outer_diameter", starts=1)
    assert [one.constrained for one in fit.directions] == [True, False, False]
    assert len(fit.combinations) == 1
    alone = written(tmp_path, "joint,side,pressure_kpa,angle_deg\nII,left,250,31.2\n")
    with pytest.raises(ht.InputError, match="angle_sd_deg must be a column: .* too few for"):
        fit_bench(tuna, read_bench(alone, tuna), "lever,stiffness_factor,outer_diameter", starts=1)


def test_two_published_bends_fix_two_combinations_of_twelve_unknowns(tuna: ht.Robot) -> None:
    fit = fit_bench(tuna, read_bench(EXAMPLE / "paper.csv", tuna), starts=1)
    assert len(fit.free) == 12
    assert [one.constrained for one in fit.directions] == [True] * 2 + [False] * 10
    assert max(one.singular_value for one in fit.directions[2:]) < 1e-6
    assert not (fit.narrowing > 3).any()  # and no unknown by itself
    assert [sum("[I]" in name for name in one.exponents) > 0 for one in fit.combinations] != [False, False]


def test_intervals_hold_the_truth_in_repeats(tuna: ht.Robot, tmp_path: Path) -> None:
    """Eight repeats with unknown noise: 24 intervals of 95 %, of which 20 or more hold with 99 % probability."""
    names = "lever,stiffness_factor,friction"
    frees = unknowns(tuna, (0,), names=names)
    truth = np.array([one.described * f for one, f in zip(frees, (1.05, 1.2, 0.8), strict=True)])
    actual, held, noise = with_unknowns(tuna, frees, truth), 0, []
    for seed in range(8):
        fit = fit_bench(tuna, loops(actual, tmp_path, noise=0.1, seed=seed), names, starts=1, loss="linear")
        held += int(((fit.low <= truth) & (truth <= fit.high)).sum())
        noise.append(fit.noise["angle"] ** 2)
    assert held >= 20
    assert math.degrees(math.sqrt(np.mean(noise))) == pytest.approx(0.1, rel=3 / math.sqrt(2 * 8 * 5))


def test_one_misread_row_does_little_with_a_robust_loss(tuna: ht.Robot, tmp_path: Path) -> None:
    bench = loops(tuna, tmp_path, noise=0.02, seed=3)
    wrong = replace(bench, angle=bench.angle + np.radians(4.0) * (np.arange(len(bench.angle)) == 2))
    off = {}
    for loss in ("linear", "soft_l1"):
        fit = fit_bench(tuna, wrong, "stiffness_factor", starts=1, loss=loss)
        off[loss] = abs(math.log(fit.values[0] / fit.free[0].described))
    assert off["linear"] > 3 * off["soft_l1"]


# --- the example


@pytest.fixture(scope="module")
def example(tuna: ht.Robot) -> BenchFit:
    return fit_bench(tuna, read_bench(EXAMPLE / "bench.csv", tuna), starts=1)


def test_the_example_is_what_its_script_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["make.py", str(tmp_path)])
    runpy.run_path(str(EXAMPLE / "make.py"))
    assert (tmp_path / "bench.csv").read_text() == (EXAMPLE / "bench.csv").read_text()


def test_the_example_s_combinations_hold_its_truth(
    example: BenchFit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["make.py", str(tmp_path)])
    factors = runpy.run_path(str(EXAMPLE / "make.py"))["TRUTH"]
    truth = {
        one.factor: one.log(one.described * factors.get(one.name, 1.0)) - one.log(one.described) for one in example.free
    }
    told = [math.exp(sum(e * truth[name] for name, e in one.exponents.items())) for one in example.combinations]
    held = [one.low <= value <= one.high for one, value in zip(example.combinations, told, strict=True)]
    assert len(held) >= 7
    assert sum(held) >= len(held) - 1
    assert example.noise["angle"] == pytest.approx(math.radians(0.2), rel=0.5)
    assert 4 <= sum(one.singular_value < 1 for one in example.directions) <= 6  # left free
    values = np.array([one.described * factors.get(one.name, 1.0) for one in example.free])
    assert ((example.low <= values) & (values <= example.high)).sum() >= len(values) - 1


def test_a_measurement_of_nothing_tells_nothing(example: BenchFit) -> None:
    flat = replace(example, bench=replace(example.bench, pressure=np.zeros_like(example.bench.pressure)))
    assert 0 < len(information_gain(flat)) < len(information_gain(example))


def test_information_gain_of_a_measurement(example: BenchFit) -> None:
    found = {one.text: one for one in information_gain(example)}
    caliper = found["outer diameter of the hose, by caliper"]
    assert caliper.value == pytest.approx(1e3 * example.robot.drive_unit.outer_diameter)
    # two normal measurements of one number: their inverse variances add up
    before, own = caliper.before["outer_diameter"], example.quantile * caliper.sd / caliper.value
    assert caliper.after["outer_diameter"] == pytest.approx(1 / math.hypot(1 / before, 1 / own), rel=1e-6)
    assert caliper.bits == pytest.approx(math.log2(math.hypot(1, before / own)), rel=1e-6)
    bits = [one.bits for one in information_gain(example)]
    assert bits == sorted(bits, reverse=True)
    assert all(one.after[name] < one.before[name] for one in found.values() for name in one.after)
    assert "oil volume of joint II at 250 kPa, by syringe" in found
    assert "oil volume of joint I at 250 kPa, by syringe" not in found  # it was measured


def test_the_information_gain_is_that_of_the_measurement_once_made(tuna: ht.Robot, tmp_path: Path) -> None:
    """The oil volume of a joint, predicted and then measured: the interval of the outer diameter."""
    names, bench = "outer_diameter,lever,friction", loops(tuna, tmp_path, sd="0.1")
    fit = fit_bench(tuna, bench, names, starts=1, loss="linear")
    told = next(one for one in information_gain(fit) if one.text.startswith("outer diameter"))
    narrow = fit.quantile * told.sd / told.value
    outer = tuna.drive_unit.outer_diameter
    known = {"outer_diameter": tuple(outer * math.exp(side * math.sqrt(3) * narrow / fit.quantile) for side in (-1, 1))}
    again = fit_bench(tuna, bench, names, starts=1, loss="linear", bounds=known)  # a bound of that standard deviation
    for k, one in enumerate(fit.free):
        half = math.log(again.high[k] / again.low[k]) / 2
        if one.name in told.after and one.name != "outer_diameter":
            assert half == pytest.approx(told.after[one.name], rel=0.15)


def test_a_fitted_robot_keeps_its_file_and_tells_where_values_are_from(example: BenchFit, tuna: ht.Robot) -> None:
    text = robot_text(example.robot, note="fitted, see [sources]")
    assert text.startswith("# HyperTuna: hydraulically powered double-joint soft robotic fish.")
    assert "[drive_unit]" in text
    assert "# Table III" in text  # a comment beside what did not change
    source = example.robot.source("drive_unit.outer_diameter_m")
    assert source is not None
    assert source.startswith("fitted by hypertuna joint fit to ")
    assert "not determined by itself, one of many values that fit as well" in source
    assert f"Before: {tuna.source('drive_unit')}" in source
    assert example.robot.unsourced() == tuna.unsourced()
    np.testing.assert_allclose(computed(example.robot, example.bench)["angle"], example.angle, rtol=1e-9)


def test_a_fit_is_drawn_with_a_plot_for_each_joint_and_what_is_determined_in_one_color(example: BenchFit) -> None:
    figure = example.plot()
    figure.canvas.draw()
    boxes = [axes.get_window_extent() for axes in figure.axes]
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["joint I", "joint II", "spectrum", "95 % intervals"]
    assert apart(boxes)
    spectrum, intervals = figure.axes[2:]
    handles, labels = spectrum.get_legend_handles_labels()
    told = handles[labels.index("determined")].get_color()
    found = [line.get_color() == told for line in intervals.lines[1::3]]
    assert found == [unknown["determined"] for unknown in example.parameters]
    assert 0 < sum(found) < len(found)
