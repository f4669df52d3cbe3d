"""Families of actuators: what a bench holds beside bends, designs that meet it, and what a further row would tell."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.bending import bend
from hypertuna.actuation.new import first_robot
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.designs import NO_ROOM, designs, with_room
from hypertuna.characterization.family import Family, chosen_robot, family
from hypertuna.characterization.fit import fit_bench
from hypertuna.characterization.population import _step, populate
from hypertuna.characterization.problem import blocked_moment, computed, elements, shortening
from hypertuna.characterization.unknowns import with_unknowns
from hypertuna.description.changes import changed
from hypertuna.fe.geometry import joint_body

ROOT = Path(__file__).parents[2]
HEAD = "joint,side,pressure_kpa,angle_deg,angle_sd_deg,shortening_mm,force_n,arm_mm,moment_n_m,volume_ml\n"
TOP = 250e3  # Pa
MEMBERS = 80


def written(folder: Path, text: str, name: str = "bench.csv") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def bent(robot: ht.Robot, joint: str) -> str:
    """Write the row of a bend."""
    return f"{joint},left,250,{math.degrees(bend(robot, joint, [TOP]).angle[0]):.3f},0.1,,,,,\n"


def test_a_bend_of_none_is_no_bend_to_solve_for(tuna: ht.Robot, tmp_path: Path) -> None:
    """And nothing is divided by it, which NumPy would warn of."""
    bench = read_bench(written(tmp_path, f"{HEAD}I,left,0,0,0.1,,,,,0\n{bent(tuna, 'I')}"), tuna)
    space = designs(tuna, bench, "lever[I]")
    assert [bench.pressure[space.elements.row[one.element]] for one in space.solved] == [TOP]


# --- what a bench holds beside bends


def test_forces_moments_and_shortenings_are_read_beside_bends(tuna: ht.Robot, tmp_path: Path) -> None:
    rows = "I,left,250,18,,0.5,,,,1.2\nI,both,250,,,6.3,,,,\nII,right,200,,,,2.5,80,,\nII,left,250,,,,,,0.2,\n"
    bench = read_bench(written(tmp_path, HEAD + rows), tuna)
    assert bench.side.tolist() == [0, 2, 1, 0]
    np.testing.assert_allclose(bench.shortening[:2], [0.5e-3, 6.3e-3])
    np.testing.assert_allclose(bench.moment[2:], [0.2, 0.2])
    np.testing.assert_allclose(bench.arm[2:], [0.08, math.inf])
    np.testing.assert_allclose(bench.moment_sd[2:], 0.05 * 0.2)  # 5 % of a luggage scale
    np.testing.assert_allclose(bench.shortening_sd[:2], 0.2e-3)  # of a ruler
    assert [len(loop.rows) for loop in bench.loops] == [1, 1]  # held joints are in no loop
    assert bench.sides(0) == (0,)
    assert elements(bench).kind.tolist() == ["angle", "volume", "shortening", "shortening", "moment", "moment"]


@pytest.mark.parametrize(
    ("row", "end"),
    [
        ("I,left,{},18,,,,,,", 2000),
        ("I,left,250,{},,,,,,", 180),
        ("I,left,250,,,,2,{},,", 10000),
    ],
)
def test_ranges_end_where_another_unit_is_likely(tuna: ht.Robot, tmp_path: Path, row: str, end: float) -> None:
    """At 2 MPa, half a turn, and an arm of 10 m."""
    read_bench(written(tmp_path, f"{HEAD}{row.format(end)}\n"), tuna)
    with pytest.raises(ht.InputError, match=f"must be at most {end}"):
        read_bench(written(tmp_path, f"{HEAD}{row.format(1.001 * end)}\n"), tuna)


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        ("I,left,250,,,,,,,", "line 2 must have a measured value, but is empty"),
        ("I,both,250,3,,6,,,,", "line 2, angle_deg must be empty with both sides under pressure"),
        ("I,left,250,3,,,2,80,,", "line 2, angle_deg must be empty on a line of a held joint"),
        ("I,left,250,,,,2,,,", "line 2, arm_mm must be given with a force"),
        ("I,left,250,3,,,,80,,", "line 2, arm_mm belongs to a force"),
        ("I,left,250,,,,2,80,0.2,", "line 2, force_n must not be given with a moment"),
        ("I,left,250,,,,2,0,,", "line 2, arm_mm must be greater than 0"),
        ("I,left,250,,,,2,1e6,,", "line 2, arm_mm must be at most 10000"),
        ("I,left,250,,,,two,80,,", "line 2, force_n must be a finite number, but is 'two'"),
        ("I,left,250,,,a ruler,,,,", "line 2, shortening_mm must be a finite number"),
        ("I,left,250,3,0,,,,,", "line 2, angle_sd_deg must be greater than 0"),
    ],
)
def test_bad_rows_are_reported_by_line_and_column(tuna: ht.Robot, tmp_path: Path, row: str, sentence: str) -> None:
    with pytest.raises(ht.InputError, match=re.escape(sentence)):
        read_bench(written(tmp_path, f"{HEAD}{row}\n"), tuna)


def test_a_bench_must_have_a_column_of_what_was_measured(tuna: ht.Robot, tmp_path: Path) -> None:
    with pytest.raises(ht.InputError, match="must have a column of what was measured: add angle_deg"):
        read_bench(written(tmp_path, "joint,side,pressure_kpa\nI,left,250\n"), tuna)


def test_the_blocked_moment_holds_the_joint_straight(tuna: ht.Robot) -> None:
    """Against the balance of the core: under this moment of the surroundings the joint does not bend."""
    for friction in (0.0, tuna.drive_unit.friction):
        fish = changed(tuna, {"drive_unit.friction": friction})
        moment, model = blocked_moment(fish, 0, TOP), joint_models(fish)[0]
        held = model.balance([[TOP, 0.0]], -moment)["angle"][0]
        free = model.balance([[TOP, 0.0]])["angle"][0]
        if friction == 0:
            assert abs(held) < 1e-6 * free
        else:  # which takes its part, and would hold as much again
            assert 0 < held < 0.2 * free
    left, right = (blocked_moment(changed(tuna, {"joints.I.actuator.asymmetry": 0.2}), 0, TOP, side) for side in (0, 1))
    assert left > right > 0


def test_a_force_nearby_needs_less_moment_than_a_couple(tuna: ht.Robot) -> None:
    """A uniform beam under a moment of its muscles, held at a distance from its middle, does not move there."""
    length, arm = tuna.joints[0].actuator.length, 0.08
    place = np.linspace(0, length, 100001)
    to_force = length / 2 + arm - place
    force = np.trapezoid(to_force, place) / np.trapezoid(to_force**2, place)  # no deflection, for M = 1
    ratio = blocked_moment(tuna, 0, TOP, arm=arm) / blocked_moment(tuna, 0, TOP)
    assert ratio == pytest.approx(force * arm, rel=1e-6)


def test_both_sides_shorten_a_joint_more_than_one(tuna: ht.Robot) -> None:
    one = bend(tuna, "I", [TOP]).shortening[0] * tuna.joints[0].actuator.length
    both = shortening(tuna, 0, np.array([TOP]))[0]
    assert both > 1.5 * one > 0
    held = changed(tuna, {"joints.I.actuator.axis_stiffness_n": 1e5, "joints.I.actuator.axis_buckling_n": 1e4})
    assert 0 < shortening(held, 0, np.array([TOP]))[0] < 0.2 * both


def test_a_fit_takes_all_kinds_of_rows(tuna: ht.Robot, tmp_path: Path) -> None:
    names = "stiffness_factor[I],lever[I]"
    frees = designs(tuna, read_bench(written(tmp_path, HEAD + bent(tuna, "I")), tuna), names).free
    actual = with_unknowns(tuna, frees, np.array([one.described * 1.1 for one in frees]))
    moment = blocked_moment(actual, 0, TOP)
    both = 1e3 * shortening(actual, 0, np.array([TOP]))[0]
    text = f"{HEAD}{bent(actual, 'I')}I,left,250,,,,,,{moment:.5f},\nI,both,250,,,{both:.4f},,,,\n"
    fit = fit_bench(tuna, read_bench(written(tmp_path, text), tuna), names, starts=1)
    assert fit.values == pytest.approx([1.1 * one.described for one in frees], rel=0.02)
    assert set(fit.rms) == {"angle", "shortening", "moment"}
    assert not fit.noise  # a stated one, and those of a scale and a ruler


# --- room


def test_a_power_rises_until_half_of_the_points_count() -> None:
    """With e = exp(-step) for three of four points, (1 + 3 e)^2 / (1 + 3 e^2) / 4 count: 0.9 of before at least."""
    lower = np.array([0.0, -1.0, -1.0, -1.0])
    assert _step(0 * lower, lower, 0.5) == 0.5  # all the rest
    for before in (0.0, 1.2, 3.0):
        step = _step(before * lower, lower, 100.0)
        first, last = ((1 + 3 * e) ** 2 / (1 + 3 * e**2) / 4 for e in (math.exp(-before), math.exp(-before - step)))
        assert last == pytest.approx(min(0.5, 0.9 * first))


def test_muscles_that_find_no_room_are_refused(tuna: ht.Robot) -> None:
    def with_size(**sizes: float) -> ht.Robot:
        keys = {"outer": "drive_unit.outer_diameter_m", "lever": "joints.I.actuator.lever_m"}
        return changed(tuna, {keys[name]: size for name, size in sizes.items()})

    spaced = with_room(with_size(outer=0.0062), 0)
    assert spaced.joints[0].actuator.spacing == pytest.approx(0.0067)  # as close as can be
    assert with_room(tuna, 0) is tuna
    with pytest.raises(ht.InputError, match="matrix around the outermost hoses"):
        with_room(with_size(lever=0.019), 0)
    with pytest.raises(ht.InputError, match="film on the axis"):
        with_room(with_size(lever=tuna.drive_unit.outer_diameter / 2 + 0.0004), 0)
    with pytest.raises(ht.InputError, match="oil pipes of the joints behind"):
        with_room(changed(with_size(lever=0.004), {"joints.II.line.bore_m": 0.027}), 0)
    assert with_room(with_size(lever=0.004), 0)  # pipes of 6 mm lie above and below the muscles


def test_the_widest_pipe_that_finds_room_touches_the_rim(tuna: ht.Robot) -> None:
    """Above the outermost muscle on each side lies one pipe, with a wall of 1 mm and 0.5 mm of matrix all around."""
    close, low, high = {"joints.I.actuator.lever_m": 0.004}, 0.006, 0.027

    def fits(bore: float) -> bool:
        with contextlib.suppress(ht.InputError):
            return bool(with_room(changed(tuna, close | {"joints.II.line.bore_m": bore}), 0))
        return False

    for _ in range(30):
        low, high = (middle, high) if fits(middle := (low + high) / 2) else (low, middle)
    body, radius = joint_body(changed(tuna, close), "I"), low / 2 + 0.001
    apart = body.radius + 0.0005 + radius
    height = max(channel.z for channel in body.channels) + math.sqrt(apart**2 - 0.004**2)
    turn = np.linspace(0, 2 * math.pi, 100_001)
    rim = np.hypot(body.semi_minor.min() * np.cos(turn), body.semi_major.min() * np.sin(turn) - height).min()
    assert rim == pytest.approx(radius + 0.0005, rel=1e-5)


# --- families


@pytest.fixture(scope="module")
def truth(tuna: ht.Robot) -> ht.Robot:
    """Another actuator than the described one."""
    keys = {"joints.I.actuator.lever_m": 0.012, "joints.I.actuator.stiffness_factor": 1.3, "drive_unit.friction": 0.05}
    return changed(tuna, keys | {"drive_unit.braid_angle_deg": 31.0})


@pytest.fixture(scope="module")
def found(tuna: ht.Robot, truth: ht.Robot, tmp_path_factory: pytest.TempPathFactory) -> Family:
    bench = read_bench(written(tmp_path_factory.mktemp("bench"), HEAD + bent(truth, "I")), tuna)
    return family(tuna, bench, members=MEMBERS)


def test_rows_have_the_unknowns_in_units_that_people_use(found: Family) -> None:
    """The lever of joint I in mm: 12 of the truth lies within the interval, and that within the bounds."""
    rows = {row["name"]: row for row in found.rows}
    lever, unknown = rows["lever[I]"], next(u for u in found.space.free if u.name == "lever[I]")
    assert lever["unit"] == "mm"
    assert [lever[name] for name in ("lower", "described", "upper")] == pytest.approx(
        [1e3 * value for value in (unknown.lower, unknown.described, unknown.upper)]
    )
    for row in rows.values():
        assert row["lower"] <= row["low"] <= row["median"] <= row["high"] <= row["upper"]
        assert row["lower"] <= row["chosen"] <= row["upper"]


def test_all_members_meet_the_bench_within_its_noise(found: Family) -> None:
    off = (found.found - found.space.elements.measured) / found.space.sd
    assert np.abs(off).max() < 4.5
    assert np.std(off) == pytest.approx(1.0, abs=0.3)
    for one in found.members:
        again = with_unknowns(found.space.robot, found.space.free, one.values, checked=False)
        for joint in found.space.bench.joints:
            with_room(again, joint)
        assert computed(one.robot, found.space.bench)["angle"][0] == pytest.approx(
            computed(again, found.space.bench)["angle"][0], rel=1e-9
        )
    low, high = (np.array([getattr(one, end) for one in found.space.free]) for end in ("lower", "upper"))
    assert ((low <= found.values * (1 + 1e-9)) & (found.values <= high * (1 + 1e-9))).all()


def test_the_family_holds_the_truth_and_leaves_the_moment_open(found: Family, truth: ht.Robot) -> None:
    quantity = next(one for one in found.quantities if one.text.startswith("blocked moment"))
    low, _, high = quantity.interval
    assert low < blocked_moment(truth, 0, TOP) < high
    assert high > 3 * low  # one bend says little of it
    lines = {one.text.partition(" of joint")[0] for one in found.quantities}
    expected = {
        "blocked moment",
        "shortening",
        "shortening by both sides",
        "oil volume",
        "moment per bend",
    }
    assert lines == expected


def test_the_page_says_what_the_paper_s_angles_leave_open(tuna: ht.Robot) -> None:
    """Ranges over factors of ten, from another sample: their ends to a factor of 1.6."""
    page = (ROOT / "docs/bench.md").read_text(encoding="utf-8")
    block = page.partition("<!-- the family, compared")[2].partition("<!-- end of the family -->")[0]
    said = re.findall(r"^\| (.+?) \| (.+?) \| ([\d.]+) \.\. ([\d.]+) \|$", block, flags=re.MULTILINE)
    found = family(tuna, read_bench(ROOT / "examples/bench/paper.csv", tuna), members=200, seed=1)
    assert [name for name, *_ in said] == [one.text.removesuffix(" at 250 kPa") for one in found.quantities]
    for (name, unit, *ends), one in zip(said, found.quantities, strict=True):
        low, _, high = one.interval
        assert unit == one.unit
        assert np.abs(np.log([float(ends[0]) / low, float(ends[1]) / high])).max() < math.log(1.6), name


def test_a_seed_gives_the_same_family_again(found: Family, tuna: ht.Robot) -> None:
    told: list[tuple[int, int]] = []
    again = populate(found.space, MEMBERS, seed=found.seed, progress=lambda done, total: told.append((done, total)))
    assert told == sorted(told)
    assert told[-1] == (2 * MEMBERS, 2 * MEMBERS)
    np.testing.assert_array_equal(again.points, found.population.points)
    assert again.evaluations == found.population.evaluations
    other = populate(found.space, MEMBERS, seed=1)
    assert not np.array_equal(other.points, found.population.points)


def test_a_blocked_moment_narrows_the_family_as_expected(found: Family, tuna: ht.Robot, tmp_path: Path) -> None:
    """Of the moment itself, and of the stiffness, which the bend ties to it."""
    told = next(one for one in found.next if one.text.startswith("blocked force of joint I"))
    member = chosen_robot(found)
    force = blocked_moment(member, 0, TOP, arm=0.08) / 0.08
    (low, _), (_, high) = told.expected[0], told.expected[-1]
    assert low < force < high
    text = f"{HEAD}{bent(member, 'I')}I,left,250,,,,{force:.3f},80,,\n"
    after = family(tuna, read_bench(written(tmp_path, text), tuna), members=MEMBERS, model_error=0.0)

    def spread(one: Family, value: Callable[[ht.Robot], float]) -> float:
        return float(np.std(np.log([value(fish.robot) for fish in one.members])))

    measures: dict[str, Callable[[ht.Robot], float]] = {
        "blocked moment of joint I at 250 kPa": lambda fish: blocked_moment(fish, 0, TOP),
        "moment per bend of joint I without pressure": lambda fish: joint_models(fish)[0].stiffness,
    }
    for text, value in measures.items():
        assert spread(after, value) / spread(found, value) == pytest.approx(told.narrows[text], rel=0.5)
    assert not any(one.text.startswith(("blocked moment", "bend")) for one in after.quantities)  # measured
    assert not any(one.text.startswith("blocked force of joint I") for one in after.next)


def test_gains_are_ranked_and_a_blunt_instrument_gains_little(found: Family) -> None:
    bits = [one.bits for one in found.next]
    assert bits == sorted(bits, reverse=True)
    by_text = {one.text: one for one in found.next}
    right = by_text["right bend of joint I, loading, at 250 kPa"]  # the same as the left one, but for asymmetry
    assert right.bits < 1 < by_text["oil volume of joint I at 250 kPa, by syringe"].bits
    assert all(0 <= ratio < 0.9 for one in found.next for ratio in one.narrows.values())


def test_levers_are_solved_for_where_stiffness_is_known(tuna: ht.Robot, tmp_path: Path) -> None:
    """Bend I is flat in the lever: two levers may give one bend, and both are drawn."""
    bench = read_bench(written(tmp_path, HEAD + bent(tuna, "I")), tuna)
    space = designs(tuna, bench, "lever,braid_angle,outer_diameter", model_error=0.0)
    assert [space.free[one.unknown].kind for one in space.solved] == ["lever"]
    drawn = [space.at(np.append(point, 0.0)) for point in np.random.default_rng(0).random((100, 3))]
    met = [one for one in drawn if not one.excluded]
    assert len(met) > 5
    for one in met:
        assert computed(one.robot, bench)["angle"][0] == pytest.approx(bench.angle[0], rel=1e-3)
    assert {one.excluded for one in drawn} >= {"", NO_ROOM}


def test_the_chosen_design_is_a_robot_with_sources(found: Family, tuna: ht.Robot) -> None:
    fish = chosen_robot(found)
    source = fish.source("joints.actuator.lever_m")
    assert source is not None
    assert source.startswith("one of 80 designs of hypertuna joint family (seed 0) that meet ")
    assert "Before: " in source
    angle = computed(fish, found.space.bench)["angle"][0]
    assert angle == pytest.approx(found.found[found.middle, 0], rel=1e-9)
    for one in found.quantities:
        low, _, high = one.interval
        assert low <= one.values[found.middle] <= high


def test_a_misread_row_is_warned_of(tuna: ht.Robot, truth: ht.Robot, tmp_path: Path) -> None:
    rows = bent(truth, "I") + bent(truth, "I") + "I,right,250,40,0.1,,,,,\n"
    found = family(tuna, read_bench(written(tmp_path, HEAD + rows), tuna), "lever,stiffness_factor", members=50)
    assert any("line 4: the angle is 40 deg, but" in text for text in found.warnings)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"members": 10}, "members must be from 50 to 5000"),
        ({"model_error": 2.0}, "model error must be from 0 to 0.5"),
        ({"free": "leaver"}, "free leaver must be an unknown"),
        ({"bounds": {"lever": (0.03, 0.01)}}, "bounds lever must be the lower bound"),
    ],
)
def test_bad_options_of_a_family(found: Family, options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ht.InputError, match=re.escape(sentence)):
        family(found.space.robot, found.space.bench, **options)


def test_a_bend_that_no_design_reaches_is_said(tuna: ht.Robot, tmp_path: Path) -> None:
    bench = read_bench(written(tmp_path, HEAD + "I,left,250,120,0.1,,,,,\n"), tuna)
    with pytest.raises(
        ht.InputError, match="bench must be met by one in 100 designs within the bounds, but is met by 0 of 5000: "
    ):
        family(tuna, bench, "lever,stiffness_factor", members=50)


def test_a_robot_of_one_joint_and_a_new_one(tmp_path: Path) -> None:
    """Two hydraulic robots beside HyperTuna, from forces alone and from a bend."""
    for names, row in ((["J"], "J,left,100,,,,,,MOMENT,\n"), (["A", "B"], "B,left,100,ANGLE,0.2,,,,,\n")):
        path = written(
            tmp_path,
            first_robot("fish", joints=names, actuation="hydraulic", lengths=(0.2, 0.1, 0.1), mass=1.0),
            f"{len(names)}.toml",
        )
        fish = ht.load(path)
        joint = len(names) - 1
        angle = math.degrees(bend(fish, joint, [100e3]).angle[0])
        row = row.replace("MOMENT", f"{blocked_moment(fish, joint, 100e3):.4f}").replace("ANGLE", f"{angle:.3f}")
        found = family(fish, read_bench(written(tmp_path, HEAD + row), fish), members=50)
        assert {one.text.rpartition(" of joint ")[2][0] for one in found.quantities} == {names[-1]}
        assert len({id(one) for one in found.members}) > 25


def test_members_draw_as_a_figure_with_what_was_excluded(found: Family) -> None:
    figure = found.plot()
    texts = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert {"member", "chosen", NO_ROOM} <= set(texts)
    assert replace(found, middle=0).plot() is not figure
