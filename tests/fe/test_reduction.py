"""Reduced joint: the analytic joint comes back from its own points, the twin runs on the table, virtual work holds."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.actuation.soft_joint import JointTable, joint_tables
from hypertuna.cli.fe import fe_app
from hypertuna.description.robot import load, parse
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError
from hypertuna.fe.mesh import MESHES, MeshSize
from hypertuna.fe.model import FeOptions
from hypertuna.fe.reduction import Joint, ReducedJoint, joint_by_elements, reduce_joint, with_reduced, write_reduced
from hypertuna.simulation.plant import parts_of
from hypertuna.simulation.twin import twin

ROBOT = ht.load("hypertuna")
TABLE = {table.name: table for table in joint_tables(ROBOT)}
PRESSURE = np.linspace(0, 250e3, 6)
LENGTH = 0.06  # m, at rest; in the points below the sum of the pressures shortens the joint
OWN, OTHER = 2e-13, 1e-13  # m^3/Pa, that the points below have beside the analytic joint's volumes


def by_table(table: JointTable, own: float = OWN, other: float = OTHER, fails: float = math.inf) -> Joint:
    """The joint of a table, beside what its sides take in at an angle; couples above `fails` find nothing."""

    def solve(couple: float, path: Sequence[tuple[float, float]]) -> dict[str, Any]:
        pressure = np.array(path[-1])

        def excess(angle: float) -> float:
            at = table.at([angle])
            return float(-at["elastic"][0] - pressure @ at["slope"][0] - couple * math.cos(angle))

        if couple > fails:
            return {"fault": "no step lowers the energy"}
        angle = brentq(excess, -0.7, 0.7, xtol=1e-14)
        volume = table.at([angle])["volume"][0] + own * pressure + other * pressure[::-1]
        return {"angle": angle, "volume": volume.tolist(), "length": LENGTH * (1 - pressure.sum() / 5e6), "fault": ""}

    return solve


def like_analytic() -> ht.Robot:
    """HyperTuna whose joints have their own analytic tables as reduced ones."""
    document = ROBOT.document()
    for group, table in zip(document["joints"], TABLE.values(), strict=True):
        angle = np.linspace(-38, 38, 153)
        at = table.at(np.radians(angle))
        elastic = 0.5 * (at["elastic"][::-1] - at["elastic"])
        columns = {"angle_deg": angle, "elastic_n_m": elastic, "volume_m3": at["volume"][:, 0]}
        group["reduced"] = {key: column.tolist() for key, column in columns.items()}
    return parse(document)


@pytest.mark.parametrize("name", ["I", "II"])
def test_the_analytic_joint_comes_back_from_its_points(name: str) -> None:
    table = TABLE[name]
    found = reduce_joint(ROBOT, name, pressure=PRESSURE, solve=by_table(table))
    fit, angle = found.potential, np.linspace(-found.potential.reach, found.potential.reach, 60)
    at = table.at(angle)
    assert fit.elastic(angle) == pytest.approx(-at["elastic"], abs=3e-3 * abs(at["elastic"]).max())
    assert fit.volume(angle) == pytest.approx(at["volume"][:, 0], abs=2e-3 * np.ptp(at["volume"]))
    assert (fit.compliance, fit.cross) == pytest.approx((OWN, OTHER), rel=0.01)
    moment = PRESSURE.max() * at["slope"].max()  # of the largest pressure, for scale
    assert found.residual.moment < 1e-3 * moment
    assert found.residual.moment < found.residual_new.moment < 3e-3 * moment
    assert found.residual.volume < 1e-3 * np.ptp(at["volume"])
    assert found.status == "converged"
    # Sides share their oil about the line's 60 kPa: left and right add up to 120 kPa until the right has none.
    assert found.pressure[:3].tolist() == [[0, 120e3], [50e3, 70e3], [100e3, 20e3]]
    assert not found.pressure[3:, 1].any()
    assert found.moment == pytest.approx(found.couple[:, None] * np.cos(found.angle))
    # Each point has its length, in the record too; the fit leaves it alone.
    length = np.tile(1e3 * LENGTH * (1 - found.pressure.sum(axis=1) / 5e6), (len(found.couple), 1))
    np.testing.assert_allclose(found.record()["length_mm"], length)
    np.testing.assert_allclose(1e3 * found.dataset()["length"], length)


def test_moment_and_volume_over_angle_and_pressure() -> None:
    """At an angle and a pressure they are the analytic joint's; where no couple reached, nothing is told."""
    couple, table = np.linspace(-0.3, 0.3, 13), TABLE["II"]
    found = reduce_joint(ROBOT, "II", pressure=PRESSURE, couple=couple, solve=by_table(table))
    angle = np.radians([-80.0, -10.0, 0.0, 12.0])
    moment, volume = found.over_angle(angle)
    assert np.isnan(moment[0]).all()
    at = table.at(angle[1:])
    expected = -at["elastic"][:, None] - at["slope"] @ found.pressure.T
    inside = np.isfinite(moment[1:])
    assert inside.sum() == 8  # a side with pressure bends beyond the rest
    assert moment[1:][inside] == pytest.approx(expected[inside], abs=1e-3)
    oil = at["volume"][:, None] + OWN * found.pressure + OTHER * found.pressure[:, ::-1]
    assert volume[1:][inside] == pytest.approx(oil[inside], abs=1e-8)
    stored = found.dataset()
    assert stored["moment_at"].shape == (49, 6)
    assert float(stored["angle"][6, 3]) == found.angle[6, 3]
    assert "finite elements" in stored.attrs["source"]


def test_one_side_alone_tells_nothing_of_the_other() -> None:
    found = reduce_joint(ROBOT, "II", pressure=PRESSURE, fill=0.0, solve=by_table(TABLE["II"]))
    assert not found.pressure[:, 1].any()
    assert found.potential.compliance == pytest.approx(OWN, rel=0.01)
    assert found.potential.cross == 0


def test_virtual_work_of_the_table_is_exact() -> None:
    """The twin's moment is the derivative of its energy less pressure times volume, between the points too."""
    found = reduce_joint(ROBOT, "II", pressure=PRESSURE, solve=by_table(TABLE["II"]))
    table = joint_tables(with_reduced(ROBOT, found))[1]
    reach = found.potential.reach
    assert table.angle[[0, -1]] == pytest.approx([-reach, reach], rel=1e-6)
    angle, h = np.linspace(-0.99, 0.99, 301) * reach, 1e-6
    below, at, above = (table.at(angle + shift) for shift in (-h, 0, h))
    assert -at["elastic"] == pytest.approx((above["energy"] - below["energy"]) / (2 * h), abs=1e-9)
    assert at["slope"] == pytest.approx((above["volume"] - below["volume"]) / (2 * h), abs=1e-13)
    assert at["volume"][:, 1] == pytest.approx(at["volume"][::-1, 0], rel=1e-12)
    assert at["slope"][:, 1] == pytest.approx(-at["slope"][::-1, 0], rel=1e-12)
    # What the table interpolates is what was fitted.
    assert -at["elastic"] == pytest.approx(found.potential.elastic(angle), abs=1e-5)
    assert at["slope"][:, 0] == pytest.approx(found.potential.volume(angle, derivative=True), rel=1e-5)
    for name in ("friction", "carried"):  # of the muscles: finite elements have no friction
        assert at[name] == pytest.approx(TABLE["II"].at(angle)[name], rel=2e-3, abs=5)


def test_a_joint_without_points_that_were_found_says_so() -> None:
    found = reduce_joint(ROBOT, "II", pressure=PRESSURE, couple=[-0.1, 0, 0.1], solve=by_table(TABLE["II"], fails=0.05))
    assert found.status == "partial"
    assert found.status_text == "6 of 18 points have no equilibrium; the first: no step lowers the energy."
    assert np.isnan(found.angle[2]).all()
    assert np.isnan(found.length[2]).all()
    assert found.potential.reach == abs(found.angle[:2]).max()
    short = reduce_joint(ROBOT, "II", pressure=PRESSURE[:3], solve=by_table(TABLE["II"]))
    assert short.status_text.endswith("deg, short of bend_max_deg = 31.2: use larger couples.")
    with pytest.raises(InputError, match="must suffice for a table"):
        reduce_joint(ROBOT, "II", pressure=PRESSURE, solve=by_table(TABLE["II"], fails=-1.0))


def same(a: ReducedJoint, b: ReducedJoint) -> bool:
    """Whether two reduced joints are the same to the last bit."""
    return a.table() == b.table() and bool((a.angle == b.angle).all() and (a.volume == b.volume).all())


def test_a_killed_reduction_goes_on_where_it_was(tmp_path: Path) -> None:
    file, asked = tmp_path / "reduce.journal", 0
    given: dict[str, Any] = {"pressure": PRESSURE, "checkpoint": file}
    whole = reduce_joint(ROBOT, "II", pressure=PRESSURE, solve=by_table(TABLE["II"]))

    def dies(couple: float, path: Sequence[tuple[float, float]]) -> Any:
        nonlocal asked
        asked += 1
        if asked == 9:
            raise KeyboardInterrupt
        return by_table(TABLE["II"])(couple, path)

    with pytest.raises(KeyboardInterrupt):
        reduce_joint(ROBOT, "II", solve=dies, **given)
    resumed = reduce_joint(ROBOT, "II", solve=dies, **given)
    assert asked == 9 + 30 - 8  # of 30 points eight were known
    assert same(whole, resumed)
    with pytest.raises(InputError, match="was started with pressure"):
        reduce_joint(ROBOT, "II", solve=dies, **given | {"fill": 0.0})


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"pressure": [0, 1e5, 1e5]}, "pressure must increase"),
        ({"pressure": [-1e3, 1e5]}, "pressure must not be negative, but is -1 kPa"),
        ({"pressure": [math.nan]}, "pressure must be a list of finite numbers"),
        ({"fill": -2e3}, "fill must not be negative, but is -2 kPa"),
        ({"couple": "much"}, "couple must be a list of finite numbers"),
        ({"joint": "III"}, "joint III is not a joint of the robot"),
    ],
)
def test_bad_input_is_told(change: dict[str, Any], sentence: str) -> None:
    arguments = {"joint": "II", "pressure": PRESSURE, "solve": by_table(TABLE["II"])} | change
    with pytest.raises(InputError) as caught:
        reduce_joint(ROBOT, arguments.pop("joint"), **arguments)
    assert sentence in str(caught.value)


GOOD = {"angle_deg": [-20.0, -10.0, 0.0, 10.0, 20.0], "elastic_n_m": [-0.2, -0.1, 0.0, 0.1, 0.2]}
GOOD |= {"volume_m3": [2.0e-6, 2.5e-6, 2.9e-6, 3.3e-6, 3.6e-6]}


def with_table(**columns: Any) -> ht.Robot:
    """HyperTuna whose joint II has a reduced table."""
    document = ROBOT.document()
    document["joints"][1]["reduced"] = GOOD | columns
    return parse(document, file="tuna.toml")


@pytest.mark.parametrize(
    ("key", "column", "sentence"),
    [
        ("volume_m3", [1e-6, 2e-6], " must be 5 long, one value per angle, but is 2 long"),
        ("angle_deg", [-20.0, -10.0, 0.0, 10.0, 10.0], "[4] must rise from one to the next, but is 10 after 10"),
        ("angle_deg", [-20.0, -10.0, 0.0, 10.0, 21.0], "[0] must be symmetric about 0, but is -20 against 21"),
        ("elastic_n_m", [0.2, 0.1, 0.0, -0.1, -0.2], "[0] must have the sign of the angle, but is 0.2 at -20 deg"),
        ("elastic_n_m", [-0.2, -0.1, 0.0, 0.1, 0.3], "[0] must be the opposite on the other side, but is -0.2 at -20"),
        ("volume_m3", [3e-6, 2.9e-6, 2.8e-6, 2e-6, 1e-6], "[1] must rise from one to the next, but is 2.9e-06"),
        ("volume_m3", [0.0, 2.5e-6, 2.9e-6, 3.3e-6, 3.6e-6], "[0] must be greater than 0"),
        ("angle_deg", [-20.0, 0.0, 20.0], " must be at least 5 long, but is 3 long"),
    ],
)
def test_bad_tables_are_told(key: str, column: list[float], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        with_table(**{key: column})
    assert str(caught.value).startswith("tuna.toml: joints")
    assert f"reduced.{key}{sentence}" in str(caught.value)


def test_tables_that_the_twin_cannot_use_are_told() -> None:
    jumps = with_table(volume_m3=[2.0e-6, 2.01e-6, 2.9e-6, 2.91e-6, 3.6e-6])
    with pytest.raises(InputError, match=r"tuna.toml: joints.II.reduced.volume_m3 must increase smoothly"):
        joint_tables(jumps)
    document = with_table().document()
    document["joints"][1]["actuator"]["asymmetry"] = 0.1
    with pytest.raises(InputError, match=r"joints.II.reduced is for a joint whose sides are alike"):
        joint_tables(parse(document))


def test_the_table_is_part_of_the_robot() -> None:
    a, b = with_table(), with_table(elastic_n_m=[-0.21, -0.1, 0.0, 0.1, 0.21])
    assert len({ROBOT.hash, a.hash, b.hash}) == 3
    assert joint_tables(a)[1].at([0.3])["elastic"] != joint_tables(b)[1].at([0.3])["elastic"]
    assert joint_tables(a)[0].points is not joint_tables(a)[1].points


def test_the_twin_runs_alike_on_the_same_joint_as_a_table() -> None:
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(8, 12), phase=(0, 30))
    ours, analytic = (twin(robot, gait, duration=3, start="swimming") for robot in (like_analytic(), ROBOT))
    for name in ("angle", "unit_pressure", "speed", "servo_angle"):
        a, b = ours.data[name], analytic.data[name]
        assert abs(a - b).max() < 2e-3 * np.ptp(b), name
    assert ours.cost_of_transport == pytest.approx(analytic.cost_of_transport, rel=1e-3)


def test_the_energy_of_a_run_closes() -> None:
    """Work of the oil on the joints is what they store and what they do: no friction, no viscosity, slow beats."""
    document = like_analytic().document()
    document["drive_unit"]["friction"] = 0.0
    for material in document["materials"].values():
        material["relaxation_s"] = 0.0
    robot = parse(document)
    plant = parts_of(robot, "air", None).plant
    swing = 0.3 * np.sin(2 * np.pi * 0.5 * 0.002 * np.arange(1000))
    target = np.stack([swing, -swing, swing, -swing], axis=1)
    bench = ht._core.World({"clamped": 1})
    run = ht._core.simulate(plant, target, bench, twist=np.zeros(6), tick=0.002, steps=8)
    for j, table in enumerate(joint_tables(robot)):
        angle, sides = run["angle"][:, j], slice(2 * j, 2 * j + 2)
        at, pressure = table.at(angle), run["unit_pressure"][:, sides]
        assert run["moment"][:, j] == pytest.approx(at["elastic"] + (pressure * at["slope"]).sum(axis=1), abs=1e-9)
        oil = sum(np.trapezoid(pressure[:, s], at["volume"][:, s]) for s in (0, 1))
        done, stored = np.trapezoid(run["moment"][:, j], angle), at["energy"][-1] - at["energy"][0]
        assert oil - done - stored == pytest.approx(0, abs=2e-3 * np.ptp(at["energy"]))
        assert np.ptp(at["energy"]) > 1e-3


def test_a_written_robot_has_both_joints_and_keeps_its_comments(tmp_path: Path) -> None:
    file = tmp_path / "reduced.toml"
    robot: str | Path = "hypertuna"
    for name, table in TABLE.items():
        found = reduce_joint(ROBOT, name, pressure=PRESSURE, solve=by_table(table))
        robot = write_reduced(robot, found, file)
    text, read = file.read_text(), load(file)
    assert "# Table II; L0 is the head" in text
    assert [group.reduced is not None for group in read.joints] == [True, True]
    source = read.source("joints[1].reduced.volume_m3") or ""
    assert source.startswith("joint I: finite elements")
    assert " | joint II: finite elements" in source
    write_reduced(file, found, file)  # again: nothing doubles
    assert load(file).hash == read.hash
    assert (load(file).source("joints.reduced") or "") == source
    assert read.unsourced() == ROBOT.unsourced()


# Finite elements themselves, on a small joint: what is tested is the way, not the numbers.


def small() -> ht.Robot:
    """HyperTuna whose joint II is 30 mm long, with one drive unit on each side."""
    document = ROBOT.document()
    body = {"segment_length_m": [0.03], "semi_major_m": [0.014], "semi_minor_m": [0.013]}
    document["joints"][1] |= {"drive_units": 1, "actuator": document["joints"][1]["actuator"] | body}
    document["joints"][1] |= {"bend_max_deg": 8.0, "amplitude_max_deg": 6.0}
    return parse(document, file="small.toml")


SMALL = MeshSize(0.8, largest=6.0, order=3, pieces=3.0)  # seconds instead of minutes
COARSE = FeOptions(mesh=SMALL)


@pytest.mark.fe
def test_pressure_and_couple_have_one_potential() -> None:
    """Maxwell: what the sine of the angle gains by the pressure, the volume gains by the couple."""
    solve, (p, dp), (t, dt) = joint_by_elements(small(), "II", COARSE), (100e3, 4e3), (0.0, 0.004)
    found = {(i, k): solve(t + i * dt, [(p + m * dp, 20e3) for m in range(k + 1)]) for i in (0, 1) for k in (0, 1)}
    assert not any(point["fault"] for point in found.values())
    turns = [(math.sin(found[i, 1]["angle"]) - math.sin(found[i, 0]["angle"])) / dp for i in (0, 1)]
    swells = [(found[1, k]["volume"][0] - found[0, k]["volume"][0]) / dt for k in (0, 1)]
    assert np.mean(turns) == pytest.approx(np.mean(swells), rel=2e-3)


@pytest.mark.fe
def test_a_joint_of_finite_elements_drives_the_twin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(MESHES, "small", SMALL)
    robot, fish, out = small(), tmp_path / "small.toml", tmp_path / "reduced.toml"
    write_robot(robot, fish)
    options = ["--pressure", "60,120,250", "--moment", "-0.05:0.05:3", "--mesh", "small", "-o", str(out), "--json"]
    arguments = ["--robot", str(fish), "--joint", "II", *options, "--checkpoint", str(tmp_path / "keep")]
    told = CliRunner().invoke(fe_app, ["reduce", *arguments])
    assert told.exit_code == 0, told.output
    angle, volume = np.array(json.loads(told.stdout)["angle_deg"]), json.loads(told.stdout)["volume_left_ml"]
    length = np.array(json.loads(told.stdout)["length_mm"])
    assert length.shape == angle.shape
    assert (np.diff(length[1, 1:]) < 0).all()  # 120 kPa and 0, then 250 kPa and 0: the body shortens
    assert angle[1, 0] == pytest.approx(0, abs=0.3)  # both sides have 60 kPa; the mesh is not symmetrical
    assert angle[0, 0] == pytest.approx(-angle[2, 0], abs=0.6)
    assert (np.diff(angle, axis=0) > 0).all()
    assert (np.diff(angle, axis=1) > 0).all()
    # The journal knows all points: the function finds the same without a model, and its table is near to them.
    keep = tmp_path / "keep"
    given: dict[str, Any] = {
        "pressure": [60e3, 120e3, 250e3],
        "couple": [-0.05, 0, 0.05],
        "options": FeOptions(mesh="small"),
    }
    found = reduce_joint(load(fish), "II", checkpoint=keep, solve=by_table(TABLE["II"]), **given)
    assert np.degrees(found.angle).tolist() == angle.tolist()
    assert found.residual.moment < 0.1 * 250e3 * np.ptp(found.volume[..., 0]) / np.ptp(found.angle)
    assert 1e6 * found.residual.volume < 0.1 * np.ptp(volume)
    reduced = load(out)
    assert reduced.hash == with_reduced(robot, found).hash
    run = twin(reduced, ht.Gait.from_degrees(frequency=2, amplitude=(5, 3), phase=(0, 0)), duration=2)
    assert run.status == "completed"
    assert np.degrees(run.swing[1]) > 1
