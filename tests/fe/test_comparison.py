"""Analytic model beside finite elements, its neutral layer released, and sections without ends."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.actuation.bending import bend
from hypertuna.actuation.soft_joint import mooney, muscle
from hypertuna.errors import InputError
from hypertuna.fe import bend as fe_bend_module
from hypertuna.fe.bend import FeBend, fe_bend
from hypertuna.fe.comparison import compare, shortening_bend
from hypertuna.fe.mesh import MeshSize
from hypertuna.fe.model import FeOptions
from hypertuna.fe.newton import Equilibrium
from program import Run

PRESSURE = np.array([25e3, 50e3])
# As coarse as the check of the mesh' areas lets it be.
QUICK = FeOptions(mesh=MeshSize(1.1, largest=5.0, order=3, pieces=4.8))
COMMAND = ["fe", "compare", "--robot", "hypertuna-fe", "--joint", "II"]


@pytest.fixture(scope="module")
def fish() -> ht.Robot:
    return ht.load("hypertuna-fe")


@pytest.fixture(scope="module")
def found(fish: ht.Robot) -> FeBend:
    return fe_bend(fish, "II", PRESSURE, options=QUICK)


def test_all_but_the_soft_joints_is_as_in_hypertuna(fish: ht.Robot) -> None:
    first, second = ht.load("hypertuna").document(), fish.document()

    def without(document: dict[str, Any]) -> dict[str, Any]:
        kept = {key: value for key, value in document.items() if key not in ("name", "description", "drive_unit")}
        sources = {
            key: text
            for key, text in document["sources"].items()
            if not key.startswith(("joints.actuator", "drive_unit"))
        }
        joints = [{key: value for key, value in group.items() if key != "actuator"} for group in document["joints"]]
        return kept | {"sources": sources, "joints": joints}

    assert without(first) == without(second)
    same = ("friction", "hose", "matrix")
    assert [first["drive_unit"][key] for key in same] == [second["drive_unit"][key] for key in same]


def test_soft_lengths_and_sections_follow_from_table_ii(fish: ht.Robot) -> None:
    """The middle 10 mm of L4 are the connector; its soft ends lie between the links' middles."""
    one, two = (group.actuator for group in fish.joints)
    assert one is not None
    assert two is not None
    assert sum(one.segment_length) + sum(two.segment_length) + 0.010 == pytest.approx(sum(fish.links.length[1:7]))
    a4, b4 = fish.links.lateral_area[4] / 0.050 / 2, 0.019799  # b where the ellipse' perimeter is S_y / l
    for found, front, rear, place in (
        (one.semi_major[3], one.semi_major[2], a4, 20 / 35),
        (one.semi_minor[3], one.semi_minor[2], b4, 20 / 35),
        (two.semi_major[0], a4, two.semi_major[1], 15 / 35),
        (two.semi_minor[0], b4, two.semi_minor[1], 15 / 35),
    ):
        assert found == pytest.approx(front + place * (rear - front), abs=1e-5)


def test_at_small_pressure_a_layer_that_may_shorten_is_two_linear_equations(fish: ht.Robot) -> None:
    """Force and moment of one section, joint I: l = 1 + e, both units get shorter, the other side's braids are slack.

    With N units a side at w that pull F0 + k (e - k_w) and s (e + k_w), k_w = curvature times w, s = 6 ring (c1 + c2):
    (E A + N k + N s) e - N (k - s) k_w = -N F0 and (E I / w^2 + N k + N s) k_w - N (k - s) e = N F0.
    """
    group, unit = fish.joints[0], fish.drive_unit
    actuator = group.actuator
    assert actuator is not None
    assert unit is not None
    assert group.drive_units is not None
    small, count, w, r = 100.0, group.drive_units, actuator.lever, unit.outer_diameter / 2
    hose, matrix = (mooney(fish, name) for name in (unit.hose, unit.matrix))
    tube = muscle(fish, friction=False)
    step = 1e-4
    low, pull, high = (tube.at(np.array([1 + s * step]), pressure=small)["pull"][0] for s in (-1, 0, 1))
    stiff = count * (high - low) / (2 * step)
    slack = count * 6 * math.pi * (r**2 - (unit.inner_diameter / 2) ** 2) * (hose.c1 + hose.c2)
    angle, E = 0.0, 6 * (matrix.c1 + matrix.c2)
    for length, a, b in zip(actuator.segment_length, actuator.semi_major, actuator.semi_minor, strict=True):
        holes = 2 * count * math.pi * r**2
        area = math.pi * a * b - holes
        second = actuator.stiffness_factor * (math.pi / 4 * a * b**3 - holes * (w**2 + r**2 / 4))
        balance = np.array([[E * area, 0.0], [0.0, E * second / w**2]])
        balance += [[stiff + slack, slack - stiff], [slack - stiff, stiff + slack]]
        axis, turn = np.linalg.solve(balance, [-count * pull, count * pull])
        assert axis + turn < 0  # slack, as taken
        angle += length * turn / w
    assert shortening_bend(fish, "I", [small])[0] == pytest.approx(angle, rel=2e-3)


def test_forces_that_are_not_balanced_are_no_bend(fish: ht.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    import scipy.optimize

    found = scipy.optimize.root

    def astray(forces: Any, start: Any, args: tuple[float, ...], **options: Any) -> Any:
        solution = found(forces, start, args, **options)
        solution.x = solution.x + (0.01 if args[0] > 5e3 else 0.0)
        return solution

    monkeypatch.setattr(scipy.optimize, "root", astray)
    angle = shortening_bend(fish, "I", [5e3, 10e3])
    assert angle[0] > 0
    assert math.isnan(angle[1])


def uneven(fish: ht.Robot, asymmetry: float) -> ht.Robot:
    """The fish with joints whose sides have unlike levers."""
    actuators = [group.actuator.model_copy(update={"asymmetry": asymmetry}) for group in fish.joints if group.actuator]
    groups = zip(fish.joints, actuators, strict=True)
    joints = tuple(group.model_copy(update={"actuator": actuator}) for group, actuator in groups)
    return fish.model_copy(update={"joints": joints})


def test_the_right_side_bends_as_the_left_of_the_mirrored_joint(fish: ht.Robot) -> None:
    left, right = (shortening_bend(uneven(fish, 0.2), "II", PRESSURE, side=side) for side in ("left", "right"))
    mirrored = shortening_bend(uneven(fish, -0.2), "II", PRESSURE, side="left")
    np.testing.assert_allclose(right, mirrored, rtol=1e-9)
    assert (np.abs(left / right - 1) > 0.01).all()  # so the levers are seen
    with pytest.raises(InputError, match="side must be left or right, but is 'up'"):
        shortening_bend(fish, "II", PRESSURE, side="up")


@pytest.mark.fe
def test_sections_bend_to_the_right_as_the_mirrored_ones_to_the_left(fish: ht.Robot) -> None:
    from hypertuna.fe.section import section_bend

    one = {"segments": False}
    left, right = (section_bend(uneven(fish, 0.2), "II", PRESSURE, side=side, **one) for side in ("left", "right"))
    mirrored = section_bend(uneven(fish, -0.2), "II", PRESSURE, **one)
    np.testing.assert_allclose(right.angle, mirrored.angle, rtol=1e-3)  # on a mesh that is not its mirror image
    np.testing.assert_allclose(right.axis, mirrored.axis, rtol=1e-4)
    assert (left.angle > 1.1 * right.angle).all()  # the levers are seen: by a fifth longer


def test_a_layer_that_may_shorten_bends_farther_where_passive_braids_are_stiff(fish: ht.Robot) -> None:
    unit = fish.drive_unit
    assert unit is not None
    steep = fish.model_copy(update={"drive_unit": unit.model_copy(update={"braid_angle": math.radians(24)})})
    held = bend(steep, "II", [250e3], friction=False).angle[0]
    free = shortening_bend(steep, "II", [250e3])[0]
    assert free > 1.3 * held  # 24 deg stretch by 9 % at most; held, the other side's braids stop the joint


@pytest.mark.fe
def test_differences_are_those_of_the_columns(found: FeBend, fish: ht.Robot) -> None:
    compared = compare(found)
    analytic = bend(fish, "II", PRESSURE)
    np.testing.assert_allclose(compared.analytic.angle, analytic.angle)
    np.testing.assert_allclose(compared.difference, analytic.angle / found.angle - 1)
    assert compared.reasons == ()
    assert (compared.fe.oil > 0).all()
    assert (np.diff(compared.shortening) > 0).all()  # under more pressure the body is shorter
    assert 0.01 < compared.shortening[-1] < 0.2
    assert compared.shortening[-1] == pytest.approx(1 - found.measured[-1].length / 0.060)  # [m] of the description


@pytest.mark.fe
def test_reasons_lead_from_one_model_to_the_other(found: FeBend) -> None:
    reasons = compare(found, reasons=True).reasons
    angle = np.array([reason.angle for reason in reasons])
    assert angle[0] == compare(found).analytic.angle[-1]
    assert angle[-1] == found.angle[-1]
    assert angle[1] > angle[0]  # nothing rubs
    assert angle[4] > angle[5]  # ends hold
    assert np.isfinite(angle).all()


@pytest.mark.fe
def test_nothing_to_compare_is_said(found: FeBend) -> None:
    nothing = replace(
        found, pressure=np.empty(0), measured=(), iterations=(), seconds=(), status_text="100 kPa failed."
    )
    with pytest.raises(InputError, match="must reach a pressure"):
        compare(nothing)


@pytest.mark.fe
def test_sections_do_not_depend_on_the_side_of_the_mesh(fish: ht.Robot) -> None:
    """One mean section stands for all segments within 5 %."""
    from hypertuna.fe.section import section_bend

    each = section_bend(fish, "II", PRESSURE)
    mean = section_bend(fish, "II", PRESSURE, segments=False)
    np.testing.assert_allclose(mean.angle, each.angle, rtol=0.05)
    assert (each.axis < 1).all()


@pytest.mark.fe
def test_the_command_compares(tmp_path: Path) -> None:
    from hypertuna.cli.main import app

    arguments = [
        "fe",
        "compare",
        *("--robot", "hypertuna-fe", "--joint", "II", "--pressure", "20", "--mesh", "coarse", "--json"),
    ]
    result = CliRunner().invoke(app, [*arguments, "-o", str(tmp_path / "run")])
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told == json.loads((tmp_path / "run" / "compare.json").read_text())
    (step,) = told["steps"]
    assert step["bend_difference_percent"] == pytest.approx(100 * (step["bend_analytic_deg"] / step["bend_fe_deg"] - 1))


@pytest.mark.fe
def test_the_command_says_that_nothing_was_reached(monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    monkeypatch.setattr(
        fe_bend_module, "equilibrium", lambda model, pressure: Equilibrium(False, 1, "no step goes down")
    )
    code, output, _ = run(*COMMAND, "--pressure", "20", "--mesh", "coarse")
    assert (code, output) == (1, "20 kPa was not reached (no step goes down); there are no results.\n")
    code, output, _ = run(*COMMAND, "--pressure", "20", "--mesh", "coarse", "--json")
    assert (code, json.loads(output)["status"], json.loads(output)["steps"]) == (1, "failed", [])


@pytest.mark.fe
def test_bad_options_leave_no_folder(tmp_path: Path) -> None:
    from hypertuna.cli.main import app

    result = CliRunner().invoke(app, [*COMMAND, "--side", "up", "-o", str(tmp_path / "run")])
    assert "side must be left or right" in str(result.exception)
    assert not (tmp_path / "run").exists()


def test_bad_pressures_are_refused() -> None:
    from hypertuna.cli.main import app

    result = CliRunner().invoke(app, [*COMMAND, "--pressure", "100,50"])
    assert isinstance(result.exception, InputError)  # which the program turns into a sentence and exit code 2
    assert "pressure must increase" in str(result.exception)
