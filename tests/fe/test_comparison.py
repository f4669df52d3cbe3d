"""Fast model beside finite elements, of two geometries, and sections without ends."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.actuation.bending import bend
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.fe import bend as fe_bend_module
from hypertuna.fe.bend import FeBend, fe_bend
from hypertuna.fe.comparison import compare
from hypertuna.fe.mesh import MeshSize
from hypertuna.fe.model import FeOptions
from hypertuna.fe.newton import Equilibrium
from program import Run

PRESSURE = np.array([25e3, 50e3])
# As coarse as the check of the mesh' areas lets it be.
QUICK = FeOptions(mesh=MeshSize(0.9, largest=5.0, order=3, pieces=6.0))
COMMAND = ["fe", "compare", "--robot", "hypertuna", "--joint", "II"]


@pytest.fixture(scope="module")
def fish() -> ht.Robot:
    return ht.load("hypertuna")


@pytest.fixture(scope="module")
def found(fish: ht.Robot) -> FeBend:
    return fe_bend(fish, "II", PRESSURE, options=QUICK)


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


def uneven(fish: ht.Robot, asymmetry: float) -> ht.Robot:
    """The fish with joints whose sides have unlike levers."""
    actuators = [group.actuator.model_copy(update={"asymmetry": asymmetry}) for group in fish.joints if group.actuator]
    groups = zip(fish.joints, actuators, strict=True)
    joints = tuple(group.model_copy(update={"actuator": actuator}) for group, actuator in groups)
    return fish.model_copy(update={"joints": joints})


# Another geometry, which the fast model was not built with: by finite elements (medium mesh, datasheet, one side,
# without friction) bends at 50 to 250 kPa.
KPA = np.linspace(50, 250, 5)
OTHER = {"I": (3.98, 6.79, 8.85, 10.43, 11.67), "II": (8.15, 12.57, 15.10, 16.68, 17.70)}  # deg


def other(fish: ht.Robot) -> ht.Robot:
    """The fish with hoses of 8 mm by 5.6 mm, a braid of 38 deg, other levers, shorter joints and stiffer silicones."""
    document = fish.document()
    hoses = {"outer_diameter_m": 0.008, "inner_diameter_m": 0.0056, "braid_angle_deg": 38.0}
    document["drive_unit"] |= hoses | {"material_set": "datasheet"}
    for group, lever, inner in zip(document["joints"], (0.01238, 0.00686), (slice(0, 3), slice(1, 3)), strict=True):
        body = group["actuator"]
        for key in ("segment_length_m", "semi_major_m", "semi_minor_m"):
            body[key] = body[key][inner]
        body["lever_m"] = lever
        body["axis_stiffness_n"] = 0.0
        body.pop("axis_buckling_n", None)
    document["sources"].pop("joints.actuator.axis_buckling_n", None)
    return parse(document)


@pytest.mark.parametrize("joint", ["I", "II"])
def test_the_fast_model_bends_a_geometry_that_it_was_not_built_with(fish: ht.Robot, joint: str) -> None:
    """By 8 to 13 % less: its thick hoses go slack over more of the section than round ones in the matrix tell."""
    angle = np.degrees(bend(other(fish), joint, 1e3 * KPA, friction=False).angle)
    assert (angle < OTHER[joint]).all()
    assert angle == pytest.approx(OTHER[joint], rel=0.14)


@pytest.mark.fe
def test_sections_bend_to_the_right_as_the_mirrored_ones_to_the_left(fish: ht.Robot) -> None:
    from hypertuna.fe.section import section_bend

    one = {"segments": False}
    left, right = (section_bend(uneven(fish, 0.2), "II", PRESSURE, side=side, **one) for side in ("left", "right"))
    mirrored = section_bend(uneven(fish, -0.2), "II", PRESSURE, **one)
    np.testing.assert_allclose(right.angle, mirrored.angle, rtol=1e-3)  # on a mesh that is not its mirror image
    np.testing.assert_allclose(right.axis, mirrored.axis, rtol=1e-4)
    assert (left.angle > 1.1 * right.angle).all()  # the levers are seen: by a fifth longer


@pytest.mark.fe
def test_differences_are_those_of_the_columns(found: FeBend, fish: ht.Robot) -> None:
    compared = compare(found)
    analytic = bend(fish, "II", PRESSURE)
    np.testing.assert_allclose(compared.analytic.angle, analytic.angle)
    np.testing.assert_allclose(compared.difference, analytic.angle / found.angle - 1)
    assert compared.reasons == ()
    assert (compared.fe.oil > 0).all()
    assert (np.diff(compared.shortening) > 0).all()  # under more pressure the body is shorter
    assert 0.005 < compared.shortening[-1] < 0.2
    assert compared.shortening[-1] == pytest.approx(1 - found.measured[-1].length / 0.060)  # [m] of the description


@pytest.mark.fe
def test_reasons_lead_from_one_model_to_the_other(found: FeBend) -> None:
    reasons = compare(found, reasons=True).reasons
    angle = np.array([reason.angle for reason in reasons])
    assert angle[0] == compare(found).analytic.angle[-1]
    assert angle[-1] == found.angle[-1]
    assert len(angle) == 4
    assert angle[1] > angle[0]  # nothing rubs
    assert angle[2] > angle[3]  # ends hold
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
        *("--robot", "hypertuna", "--joint", "II", "--pressure", "20", "--mesh", "coarse", "--json"),
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
