"""Free coefficients: their names, ties and bounds, and the robots that their values make."""

from __future__ import annotations

import difflib
import math
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.description.writer import robot_text, write_robot
from hypertuna.identification.coefficients import (
    Free,
    columns,
    free,
    from_scale,
    parameter_jacobian,
    sample_robots,
    to_scale,
    with_fit,
    with_values,
)
from hypertuna.identification.names import free_of, split_names
from hypertuna.swimming.model import parameter_names
from models import MODELS, changed
from synthetic import NINE


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("water.drag", ["water.lumped.drag[0-7]"]),  # tied
        ("water.lumped.drag[0,1-6,7]", ["water.lumped.drag[0]", "water.lumped.drag[1-6]", "water.lumped.drag[7]"]),
        ("water.drag[0+7,1-6]", ["water.lumped.drag[0+7]", "water.lumped.drag[1-6]"]),
        ("joints.bandwidth[*]", ["joints.bandwidth[0]", "joints.bandwidth[1]"]),
        ("joints.bandwidth[II]", ["joints.bandwidth[1]"]),
        ("links.mass[L7]", ["links.mass[7]"]),
        ("links.mass_kg[L7]", ["links.mass[7]"]),  # as the file has it
        ("water.density", ["water.density"]),
        ("cost_factor", ["cost_factor"]),
    ],
)
def test_names(tuna: ht.Robot, name: str, found: list[str]) -> None:
    assert [f.name for f in free(tuna, [name])] == found


def test_table_iii_is_the_default(tuna: ht.Robot) -> None:
    frees = free(tuna, NINE)
    assert [(f.lower, f.upper) for f in frees] == [(0, 1)] * 6 + [(0, 30)] * 3
    assert [f.start for f in frees] == [0.12092, 0.15816, 0.0882, 0.03845, 0.16131, 0.20809, 27.0706, 3.9829, 20.7766]


def test_commas_inside_brackets_do_not_split() -> None:
    assert split_names("water.drag[0,1-6,7], joints.bandwidth,") == ["water.drag[0,1-6,7]", "joints.bandwidth"]


def test_a_time_offset_for_each_recording(tuna: ht.Robot) -> None:
    frees = free(tuna, ["time_offset"], recordings={"a": 0.1, "b": 0.0}, start={"time_offset[b]": 0.2})
    assert [(f.name, f.start, f.unit) for f in frees] == [("time_offset[a]", 0.1, "s"), ("time_offset[b]", 0.2, "s")]


@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        (["water.dragg[0]"], "free water.dragg[0] is not a coefficient that can be free: did you mean water.drag[0]?"),
        (["water.dragg"], "free water.dragg is not a coefficient that can be free: did you mean water.drag?"),
        (["water.drag[9]"], "free water.drag[9] must have indices from 0 to 7"),
        (["water.drag[3-1]"], "but is '3-1'"),
        (["water.drag[]"], "must have indices"),
        (["water.strip.drag_normal"], "is not used by model.water = 'lumped': choose water = 'strip' in [model]"),
        (["gait.frequency"], "belongs to the gait, which the trials give"),
        (["water.density[0]"], "has one value only"),
        (["time_offset"], "needs recordings of joint angles, and the trials have none"),
        (["water.drag", "water.drag[2]"], "water.lumped.drag[2] must be listed only once"),
        ([], "free must name at least one coefficient"),
    ],
)
def test_names_that_cannot_be_free(tuna: ht.Robot, names: list[str], sentence: str) -> None:
    with pytest.raises(ht.InputError) as error:
        free(tuna, names)
    assert sentence in str(error.value)


def test_bandwidth_of_ideal_joints_cannot_be_free(tuna: ht.Robot) -> None:
    with pytest.raises(ht.InputError, match="is not used by model.joints = 'ideal'"):
        free(tuna.using(joints="ideal"), ["joints.bandwidth"])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"bounds": {"water.drag": (5, 1)}}, "must have a lower bound below its upper one"),
        ({"bounds": {"water.drag": (-1, 30)}}, "must not be negative"),
        ({"bounds": {"water.drag": (0, 20)}}, "must start within its bounds, 0 to 20"),
        ({"start": {"water.drag": 40}}, "must start within its bounds, 0 to 30, but is 40"),
        ({"bounds": {"water.friction": (0, 2)}}, "bounds water.friction must be a free coefficient"),
        ({"log": ["water.drag"], "bounds": {"water.drag": (0, 30)}}, "must have bounds greater than 0 in log scale"),
    ],
)
def test_bounds_and_starts_that_do_not_fit(tuna: ht.Robot, options: dict[str, object], sentence: str) -> None:
    with pytest.raises(ht.InputError) as error:
        free(tuna, ["water.drag[0]"], **options)  # type: ignore[arg-type]
    assert sentence in str(error.value)


def test_a_bound_covers_what_its_name_does(tuna: ht.Robot) -> None:
    frees = free(tuna, ["water.drag[0,1-6,7]"], bounds={"water.drag": (0, 40), "water.drag[7]": (10, 50)})
    assert [(f.lower, f.upper) for f in frees] == [(0, 40), (0, 40), (10, 50)]


def test_each_law_takes_its_own_names(tuna: ht.Robot) -> None:
    names = ("water.drag", "water.strip.drag_normal", "water.added_inertia", "joints.bandwidth", "water.density")
    assert free_of(tuna, names) == ("water.drag", "joints.bandwidth", "water.density")
    assert free_of(tuna.using(water="strip"), names) == names[1:]


def test_log_scale(tuna: ht.Robot) -> None:
    frees = free(tuna, ["water.drag[7]", "joints.bandwidth"], log=["water.drag"])
    assert (frees[0].scale, frees[0].lower) == ("log", 30e-4)
    values = np.array([20.0, 4.0])
    assert to_scale(frees, values) == pytest.approx([math.log(20), 4])
    assert from_scale(frees, to_scale(frees, values)) == pytest.approx(values)


def parameters(robot: ht.Robot) -> np.ndarray:
    """Every parameter of a robot, in the order of their names; those of a gait are 0."""
    found = []
    for name in parameter_names(robot):
        column, _, index = name.partition("[")
        part: object = robot
        table, _, last = column.rpartition(".")
        if table == "gait":
            found.append(0.0)
            continue
        if table == "joints":
            found.append(getattr(robot.joints[int(index[:-1])], last) or 0.0)
            continue
        for attribute in column.split("."):
            part = getattr(part, attribute)
        found.append(float(part[int(index[:-1])] if index else part))  # type: ignore[index, arg-type]
    return np.array(found)


def test_directions_are_derivatives_of_the_parameters(every_model: ht.Robot) -> None:
    """Inertia, which the description leaves out, follows masses and lengths; log scale is relative."""
    names = ["links.mass[0,1+2]", "links.length[1]", "water.density"]
    names += ["water.drag[1-2]", "water.friction"] if every_model.model.water == "lumped" else ["water.drag_normal[0]"]
    frees = free(every_model, names, log=["links.mass[0]", "links.length"])
    values = np.array([f.start for f in frees])
    matrix, x = parameter_jacobian(every_model, frees, values), to_scale(frees, values)
    for k in range(len(frees)):
        step = 1e-6 * max(abs(x[k]), 1e-3) * np.eye(len(x))[k]
        ends = [parameters(with_values(every_model, frees, from_scale(frees, x + side * step))) for side in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * step[k])
        assert matrix[:, k] == pytest.approx(slope, rel=1e-6, abs=1e-9 * abs(slope).max())


def test_values_of_the_description_change_nothing(every_model: ht.Robot) -> None:
    law = every_model.model.water
    frees = free(every_model, ["links.mass", "water.drag[*]" if law == "lumped" else "water.drag_normal[*]"][1:])
    assert with_values(every_model, frees, [f.start for f in frees]).hash == every_model.hash


def test_links_that_outgrow_the_body_make_it_grow() -> None:
    eel = ht.load("rexeel")
    frees = free(eel, ["links.mass[5]", "links.length[5]"])
    grown = with_values(eel, frees, [0.2, 0.1])
    assert grown.body.mass == pytest.approx(0.892 + 0.06)
    assert grown.body.length == pytest.approx(0.612)
    assert columns(eel, frees, [0.2, 0.1])["links.mass"] == [*eel.links.mass[:5], 0.2]


def fitted(robot: ht.Robot) -> ht.Robot:
    """The robot with two fitted coefficients."""
    frees = free(robot, ["water.drag[0,1-6]"])
    return with_fit(
        robot, frees, [20.0, 4.0], covariance=np.diag([1.0, 0.01]), trials="tank.csv", seed=1, text="identified"
    )


def test_a_file_keeps_its_comments_and_its_layout(tuna: ht.Robot, tmp_path: Path) -> None:
    original = Path("robots/hypertuna.toml").read_text()
    path = write_robot(fitted(tuna), tmp_path / "fit.toml")
    difference = list(difflib.ndiff(original.splitlines(), path.read_text().splitlines()))
    assert [line for line in difference if line.startswith("- ")] == [
        "- [water.lumped]  # Table III",
        "- drag       = [27.0706, 3.9829,  3.9829,  3.9829,  3.9829,  3.9829,  3.9829,  20.7766]",
    ]
    added = [line for line in difference if line.startswith("+ ")]
    assert added[0] == "+ [water.lumped]  # Table III; drag identified, see [fit]"
    assert added[1] == "+ drag       = [20.0, 4.0,  4.0,  4.0,  4.0,  4.0,  4.0,  20.7766]"
    loaded = ht.load(path)
    assert loaded.hash == fitted(tuna).hash
    source = loaded.source("water.lumped.drag[1]")
    assert source is not None
    assert source.startswith("[0], [1-6] identified from tank.csv, see [fit]; others: Table III")
    assert "fit" not in {key.split(".")[0] for key in loaded.unsourced()}


def test_a_robot_without_a_file_is_written_too(every_model: ht.Robot) -> None:
    import tomllib

    robot = parse(every_model.document())
    assert parse(tomllib.loads(robot_text(robot))).hash == robot.hash


def test_a_changed_robot_is_written_as_it_is(tuna: ht.Robot) -> None:
    import tomllib

    without = {"gaits": {}, "guidance": None, "sources": {}}  # guidance goes by the gaits
    robot = changed(tuna, {"name": "other", "water.strip.cross_flow": True, **without})
    assert parse(tomllib.loads(robot_text(robot))).hash == robot.hash


def test_draws_have_the_spread_of_the_fit(tuna: ht.Robot) -> None:
    robots = sample_robots(fitted(tuna), 400, seed=3)
    drag = np.array([robot.water.lumped.drag for robot in robots])  # type: ignore[union-attr]
    assert drag[:, 0].std() == pytest.approx(1.0, rel=0.1)  # 400 draws: 3.5 %
    assert drag[:, 1].std() == pytest.approx(0.1, rel=0.1)
    assert np.ptp(drag[:, 1:7], axis=1).max() == 0
    assert np.ptp(drag[:, 7]) == 0
    assert [robot.hash for robot in sample_robots(fitted(tuna), 3, seed=3)] == [robot.hash for robot in robots[:3]]


def test_draws_of_an_open_direction_stay_within_its_bounds(tuna: ht.Robot) -> None:
    frees = free(tuna, ["water.drag[0]"])
    prior = np.array([[30**2 / 12]])  # all that is known
    wide = with_fit(tuna, frees, [29.0], covariance=prior, trials="tank.csv", seed=1, text="identified")
    drag = np.array([robot.water.lumped.drag[0] for robot in sample_robots(wide, 200, seed=1)])  # type: ignore[union-attr]
    assert (drag >= 0).all()
    assert (drag <= 30).all()
    assert drag.std() > 3


def test_draws_need_a_fit(tuna: ht.Robot) -> None:
    with pytest.raises(ht.InputError, match=r"must have a table \[fit\] to sample from"):
        sample_robots(tuna, 1, seed=0)


def test_other_values_drop_the_fit(tuna: ht.Robot) -> None:
    robot = fitted(tuna)
    again = with_values(robot, free(robot, ["water.drag[7]"]), [21.0])
    assert again.fit is None
    assert again.source("fit") is None


def test_a_fit_table_must_be_square(tuna: ht.Robot) -> None:
    document = fitted(tuna).document()
    document["fit"]["covariance"] = [[1.0, 0.0], [0.0]]
    with pytest.raises(ht.InputError, match=r"fit.covariance\[1\] must be 2 long"):
        parse(document)


def test_every_default_start_lies_within_its_bounds() -> None:
    for robot in MODELS.values():
        law = robot.model.water
        names = {name.partition("[")[0] for name in parameter_names(robot) if not name.startswith("gait.")}
        names -= {"joints.bandwidth"} if robot.model.joints == "ideal" else set()
        for f in free(robot, sorted(names)):
            assert isinstance(f, Free)
            assert f.lower <= f.start <= f.upper, (robot.name, law, f.name)
