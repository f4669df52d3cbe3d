"""The spring of a hinge from a bench test: by hand, in noise, with and without a cubic term; the command; mistakes."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.characterization.spring import SpringTest, fit_spring, read_spring
from hypertuna.errors import InputError
from program import Run

G = 9.81


def hang(masses: list[float], angles: list[float], path: Path, *, arm: float = 0.1) -> Path:
    """Write a bench test of hung masses [kg] and angles [rad]."""
    rows = [f"{mass!r},{arm},{math.degrees(angle)!r}" for mass, angle in zip(masses, angles, strict=True)]
    path.write_text("\n".join(["mass_kg,arm_m,angle_deg", *rows]) + "\n")
    return path


def test_three_exact_rows_give_the_spring_in_each_kind_of_load(tmp_path: Path) -> None:
    k, tilt, zero, angles = 0.35, math.radians(4), math.radians(1.5), [0.05, 0.2, 0.35]
    masses = [k * (angle - zero) / (G * 0.1 * math.cos(angle + tilt)) for angle in angles]
    fit = fit_spring(read_spring(hang(masses, angles, tmp_path / "hung.csv")), tilt=tilt)
    assert fit.stiffness == pytest.approx(k, rel=1e-12)
    assert fit.zero == pytest.approx(zero, abs=1e-12)
    assert (fit.cubic, fit.rms) == (0, pytest.approx(0, abs=1e-12))
    for column, arm in (("force_n", 0.1), ("moment_n_m", 1.0)):  # they stay at right angles to the fin
        rows = [f"{k * (angle - zero) / arm!r},{math.degrees(angle)!r}" for angle in angles]
        (tmp_path / "other.csv").write_text("\n".join([f"{column},angle_deg", *rows]))
        other = fit_spring(read_spring(tmp_path / "other.csv", arm=arm), tilt=tilt)
        assert other.stiffness == pytest.approx(k, rel=1e-12)


def test_the_standard_deviation_is_that_of_a_line_by_hand() -> None:
    """Moments 0, 1, 2 bend by 0, 0.2, 0.1: slope 0.05, residuals -0.05, 0.1, -0.05."""
    test = SpringTest(np.array([0.0, 1.0, 2.0]), np.zeros(3, dtype=bool), np.array([0.0, 0.2, 0.1]), "a.csv")
    fit = fit_spring(test)
    slope_sd = math.sqrt(0.015 / 1 / 2)  # sum of squares 0.015, one degree of freedom, moments about their mean 2
    assert fit.stiffness == pytest.approx(20)
    assert fit.stiffness_sd == pytest.approx(20 * slope_sd / 0.05)
    half = 12.706204736 * slope_sd  # t at 97.5 % for one degree of freedom
    assert fit.stiffness_interval == (pytest.approx(1 / (0.05 + half)), math.inf)


def drawn(chance: np.random.Generator, cubic: float, sd: float, count: int) -> SpringTest:
    """Draw a bench test of a spring of 0.35 N m/rad: masses on an arm, angles by a root search, read with noise."""
    loads = np.linspace(0.01, 0.25, count)
    true = [
        brentq(lambda angle, load=load: load * math.cos(angle) - 0.35 * angle - cubic * angle**3, 0, 1.5)
        for load in loads
    ]
    return SpringTest(loads, np.ones(count, dtype=bool), np.array(true) + sd * chance.standard_normal(count), "a.csv")


def test_a_residual_is_the_angle_beyond_equilibrium() -> None:
    test = drawn(np.random.default_rng(6), 0.0, math.radians(0.5), 8)
    fit = fit_spring(test)
    computed = [
        brentq(lambda angle, load=load: load * math.cos(angle) - fit.stiffness * (angle - fit.zero), -1, 1.5)
        for load in test.load
    ]
    assert np.abs(fit.residual).max() > 5e-3
    assert test.angle - fit.residual == pytest.approx(computed, abs=1e-4)  # of second order in the residual


def test_intervals_hold_the_truth() -> None:
    chance = np.random.default_rng(4)
    fits = [fit_spring(drawn(chance, 0.0, math.radians(0.5), 8)) for _ in range(300)]
    held = [fit.stiffness_interval[0] < 0.35 < fit.stiffness_interval[1] for fit in fits]
    assert 0.90 < np.mean(held) < 0.99
    assert 0.90 < np.mean([fit.zero_interval[0] < 0 < fit.zero_interval[1] for fit in fits]) < 0.99
    assert np.mean([fit.cubic > 0 for fit in fits]) < 0.02  # where there is none


def test_a_cubic_term_is_found_where_there_is_one() -> None:
    chance = np.random.default_rng(5)
    fits = [fit_spring(drawn(chance, 1.5, math.radians(0.2), 10)) for _ in range(100)]
    assert all(fit.cubic > 0 and fit.chance < 0.01 and fit.rms < fit.rms_straight for fit in fits)
    assert 0.88 < np.mean([fit.cubic_interval[0] < 1.5 < fit.cubic_interval[1] for fit in fits]) <= 1
    assert 0.88 < np.mean([fit.stiffness_interval[0] < 0.35 < fit.stiffness_interval[1] for fit in fits]) <= 1


def test_a_spring_that_softens_is_told() -> None:
    angle = np.linspace(0.05, 0.6, 10)
    fit = fit_spring(SpringTest(0.35 * angle - 0.2 * angle**3, np.zeros(10, dtype=bool), angle, "a.csv"))
    assert fit.softens
    assert fit.cubic == 0
    assert "softens at larger angles" in repr(fit) + fit._repr_html_()


def test_the_command_tells_draws_and_writes_what_the_function_finds(run: Run, tmp_path: Path) -> None:
    robot, plot, output = (tmp_path / name for name in ("fish.toml", "a.svg", "stiff.toml"))
    robot.write_text(first_robot("fish", tail="passive"))
    test = drawn(np.random.default_rng(5), 1.5, math.radians(0.2), 10)
    bench = hang((test.load / (G * 0.1)).tolist(), test.angle.tolist(), tmp_path / "bench.csv")
    fit = fit_spring(read_spring(bench))
    code, told, _ = run("joint", "spring", str(bench), "--json")
    assert code == 0
    assert json.loads(told)["stiffness_n_m_per_rad"] == fit.stiffness
    code, told, errors = run(
        "joint", "spring", str(bench), "--robot", str(robot), "-o", str(output), "--plot", str(plot)
    )
    assert (code, errors) == (0, "")
    assert f"{fit.stiffness:.4g}" in told
    assert "F test" in told
    assert "<!-- moment [N m] -->" in plot.read_text()
    (hinge,) = ht.load(output).hinges
    assert (hinge.stiffness, hinge.cubic) == pytest.approx((fit.stiffness, fit.cubic), rel=1e-12)
    source = ht.load(output).source("hinge.stiffness_n_m_per_rad") or ""
    assert source.startswith(f"bench test, 10 weights of {bench}: 95 % from ")
    code, _, errors = run("joint", "spring", str(bench), "--robot", "hypertuna", "-o", str(output))
    assert code == 2
    assert "must have a hinge, but is without" in errors


def test_one_of_several_hinges_is_chosen_by_its_link_or_number(run: Run, tmp_path: Path) -> None:
    robot, output = tmp_path / "fish.toml", tmp_path / "stiff.toml"
    robot.write_text(first_robot("fish", tail="flexible"))
    fish = ht.load(robot)
    names = [fish.links.name[hinge.link] for hinge in fish.hinges]
    assert len(names) == 3
    test = drawn(np.random.default_rng(5), 1.5, math.radians(0.2), 10)
    bench = hang((test.load / (G * 0.1)).tolist(), test.angle.tolist(), tmp_path / "bench.csv")
    stiffness = fit_spring(read_spring(bench)).stiffness
    arguments = ("joint", "spring", str(bench), "--robot", str(robot), "-o", str(output))
    for chosen in (names[1], "2"):
        code, _, errors = run(*arguments, "--hinge", chosen)
        assert (code, errors) == (0, "")
        written = [hinge.stiffness for hinge in ht.load(output).hinges]
        assert written == [fish.hinges[0].stiffness, pytest.approx(stiffness, rel=1e-12), fish.hinges[2].stiffness]
        source = ht.load(output).source("hinges[1].stiffness_n_m_per_rad") or ""
        assert source.startswith(f"of the hinge of {names[1]}: bench test, 10 weights")
        assert "; others as before. Before: estimate" in source
    code, _, errors = run(*arguments)
    assert code == 2
    assert (
        f"--hinge must be given for a robot with several, but is missing: name the link behind it, {names[0]},"
        in errors
    )
    code, _, errors = run(*arguments, "--hinge", "fni")
    assert code == 2
    assert f"--hinge must be a known hinge, but is 'fni': hinges are in front of {', '.join(names)}" in errors


BAD = {  # content and the sentence that it gets
    "missing": (None, "must be a file, but is missing"),
    "no loads": ("angle_deg\n1\n", "must have a column of loads: add one of mass_kg, force_n, moment_n_m"),
    "grams": ("mass_g,angle_deg\n1,2\n", "mass_g is not a known column: did you mean mass_kg"),
    "two loads": ("mass_kg,moment_n_m,angle_deg\n1,1,2\n", "line 2 must have one load, but is mass_kg and moment_n_m"),
    "no arm": ("mass_kg,angle_deg\n1,2\n", "line 2, arm_m must be given with a mass or a force.*or give --arm in m"),
    "arm in mm": ("mass_kg,arm_m,angle_deg\n1,100,2\n", "line 2, arm_m must be .*at most 10 m, but is 100"),
    "a word": ("moment_n_m,angle_deg\n1,much\n", "line 2, angle_deg must be a finite number, but is 'much'"),
    "too few": ("moment_n_m,angle_deg\n1,2\n2,4\n", "must have 3 rows, but is 2: hang more weights"),
    "one load": ("moment_n_m,angle_deg\n1,2\n1,4\n1,3\n", "must have different loads"),
    "wrong sign": ("moment_n_m,angle_deg\n1,-2\n2,-4\n3,-6\n", "angle_deg must grow with the load"),
}


@pytest.mark.parametrize(("content", "sentence"), BAD.values(), ids=BAD.keys())
def test_mistakes_are_one_sentence(tmp_path: Path, content: str | None, sentence: str) -> None:
    path = tmp_path / "bad.csv"
    if content is not None:
        path.write_text(content)
    with pytest.raises(InputError, match=sentence):
        fit_spring(read_spring(path))


def test_options_and_angles_beyond_straight_down_are_refused(tmp_path: Path) -> None:
    path = hang([0.1, 0.2, 0.3], [0.2, 0.4, 0.6], tmp_path / "a.csv")
    with pytest.raises(InputError, match="less than straight down"):
        fit_spring(read_spring(path), tilt=1.2)
    with pytest.raises(InputError, match="tilt must be"):
        fit_spring(read_spring(path), tilt=3.0)
    with pytest.raises(InputError, match="arm must be"):
        read_spring(path, arm=0.0)
