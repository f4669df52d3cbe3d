"""Finite elements of a joint: geometry by hand, a mesh that is the drawing, virtual work, mirror symmetry, resume."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.fe.bend import JOURNAL, fe_bend
from hypertuna.fe.energies import LOOSE, Axis, aligned_axis_energy
from hypertuna.fe.fields import _strain
from hypertuna.fe.geometry import joint_body, write_geometry
from hypertuna.fe.measure import measure, von_mises
from hypertuna.fe.mesh import MESHES, MeshSize, joint_mesh
from hypertuna.fe.model import FeModel, FeOptions, equilibrium, fe_model
from hypertuna.fe.newton import Problem, lead

ROBOT = ht.load("hypertuna")
SMALL = MeshSize(0.8, largest=6.0, order=3, pieces=3.0)  # seconds instead of minutes
COARSE = FeOptions(mesh=SMALL)
P = 60e3  # Pa, enough to bend
UNIT = {"outer_diameter_m": 0.005, "inner_diameter_m": 0.0036, "braid_angle_deg": 35.0, "material_set": "fe"}


def with_joint(**changes: Any) -> ht.Robot:
    """HyperTuna with another joint II: hoses of 5 mm by 3.6 mm, nothing on its axis, and what changes."""
    document = ROBOT.document()
    document["drive_unit"] |= UNIT | changes.pop("unit", {})
    group = document["joints"][1]
    group["drive_units"] = changes.pop("drive_units", group["drive_units"])
    group["actuator"] |= {"lever_m": 0.0066, "spacing_m": 0.006, "axis_stiffness_n": 0.0}
    group["actuator"].pop("axis_buckling_n", None)
    group["actuator"] |= changes
    return parse(document)


def small(**changes: Any) -> ht.Robot:
    """A joint with one hose a side, which takes few elements."""
    size = {"segment_length_m": [0.03], "semi_major_m": [0.014], "semi_minor_m": [0.013]}
    return with_joint(drive_units=1, **(size | changes))


def test_the_taper_goes_through_the_middles_of_the_segments() -> None:
    body = joint_body(ROBOT, "I")
    half_axes = np.interp([0.01, 0.03, 0.05, 0.07], body.stations, body.semi_major)
    np.testing.assert_allclose(half_axes, [0.05775, 0.05200, 0.04600, 0.04006], rtol=2e-3)  # as described
    assert body.length == pytest.approx(0.08)


def test_an_even_taper_is_kept_exactly() -> None:
    body = joint_body(with_joint(semi_major_m=[0.031, 0.027, 0.023], semi_minor_m=[0.018, 0.016, 0.014]), "II")
    np.testing.assert_allclose(body.semi_major, [0.033, 0.029, 0.025, 0.021], rtol=1e-12)
    np.testing.assert_allclose(body.semi_minor, [0.019, 0.017, 0.015, 0.013], rtol=1e-12)


def test_volume_and_area_by_hand() -> None:
    body = joint_body(small(), "II")
    assert body.volume == pytest.approx(math.pi * 0.03 * (0.014 * 0.013 - 2 * 0.0025**2))
    # the plane z = 0: as wide as the body, less both channels, and the tip plate
    assert body.symmetry_area == pytest.approx(0.03 * (0.026 - 2 * 0.005) + 0.003 * 0.026)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"lever_m": 0.002}, "must keep the hoses of both sides apart"),
        ({"spacing_m": 0.0051}, "must keep neighboring hoses apart"),
        ({"spacing_m": 0.0175}, "must leave 0.5 mm of matrix around the outermost hoses"),
        ({"semi_minor_m": 3 * [0.030], "semi_major_m": [0.030, 0.030, 0.009]}, "must leave a section at both ends"),
    ],
)
def test_drive_units_must_fit(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        joint_body(with_joint(**changes), "II")


def test_true_stress_of_a_pull_is_its_own_von_mises() -> None:
    stress = np.zeros((1, 3, 3))
    stress[0, 0, 0] = 7.0
    assert von_mises(stress)[0] == pytest.approx(7.0)
    assert von_mises(stress + 5 * np.eye(3))[0] == pytest.approx(7.0)  # pressure does not count


@pytest.mark.parametrize("name", ["nothing.obj", "nothing"])
def test_only_known_formats_are_written(tmp_path: Path, name: str) -> None:
    pytest.importorskip("ngsolve", reason="needs the extra fe")
    with pytest.raises(InputError, match=r"must end in \.step, \.stp or \.stl"):
        write_geometry(joint_body(ROBOT, "II"), tmp_path / name)


@pytest.mark.fe
@pytest.mark.parametrize("joint", ["I", "II"])
@pytest.mark.parametrize("pieces", [6.0, 9.0])
def test_the_mesh_is_the_drawing(joint: str, pieces: float) -> None:
    import ngsolve as ngs

    body = joint_body(ROBOT, joint)
    mesh, _kept = joint_mesh(body, MeshSize(0.8, order=3, pieces=pieces))
    one = ngs.CF(1.0)
    assert 2 * ngs.Integrate(one * ngs.dx("matrix"), mesh) == pytest.approx(body.volume, rel=1e-3)
    assert ngs.Integrate(one * ngs.ds("symmetry"), mesh) == pytest.approx(body.symmetry_area, rel=1e-3)
    # the walls are round: every point is at the radius from its channel's axis
    points = mesh.MapToAllElements(ngs.IntegrationRule(ngs.TRIG, 6), mesh.Boundaries("wall_.*"))
    y, z = (np.asarray(axis(points)) for axis in (ngs.y, ngs.z))
    away = np.min([np.hypot(y - channel.y, z - channel.z) for channel in body.upper], axis=0)
    np.testing.assert_allclose(away, body.radius, rtol=0.02)  # a chord would be 5 to 8 % off


@pytest.mark.fe
def test_a_face_that_is_not_recognized_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    from hypertuna.fe import geometry as fe_geometry

    body, name = joint_body(small(), "II"), fe_geometry._face_name
    monkeypatch.setattr(fe_geometry, "_face_name", lambda *face: name(*face).replace("cap_", "tie_"))
    with pytest.raises(InputError, match="must have the drawing's area of the channels' ends"):
        joint_mesh(body, MeshSize(0.8, order=3))


@pytest.mark.fe
def test_at_rest_nothing_moves() -> None:
    model = fe_model(small(), "II", COARSE)
    assert equilibrium(model, pressure=(0.0, 0.0)).iterations == 1
    found = measure(model)
    assert abs(found.angle) < 1e-9
    assert found.length == pytest.approx(model.body.length, rel=1e-12)
    assert found.stress_max < 0.1  # Pa
    assert found.fiber_stretch == pytest.approx((1.0, 1.0), abs=1e-9)


@pytest.mark.fe
@pytest.mark.parametrize(
    ("gradient", "largest"),
    [
        ([[0.2, 0, 0], [0, -0.1, 0], [0, 0, -0.05]], math.log(1.2)),
        ([[-0.2, 0, 0], [0, -0.3, 0], [0, 0, -0.1]], math.log(0.9)),
        # simple shear by 0.5: stretches s and 1 / s, with s - 1 / s = 0.5
        ([[0, 0.5, 0], [0, 0, 0], [0, 0, 0]], math.asinh(0.25)),
    ],
)
def test_the_largest_strain_of_uniform_strains(gradient: list[list[float]], largest: float) -> None:
    import ngsolve as ngs

    model = fe_model(small(), "II", COARSE)
    place = (ngs.x, ngs.y, ngs.z)
    moved = [sum(g * x for g, x in zip(row, place, strict=True)) for row in gradient]
    model.displacement.Set(ngs.CF(tuple(moved)))
    difference = ngs.Integrate((_strain(model) - largest) ** 2, model.mesh) / ngs.Integrate(ngs.CF(1.0), model.mesh)
    assert math.sqrt(difference) < 1e-6


@pytest.mark.fe
def test_left_and_right_are_mirror_images() -> None:
    found = []
    for pressure in ((P, 0.0), (0.0, P)):
        model = fe_model(small(), "II", COARSE)
        assert equilibrium(model, pressure=pressure).converged
        found.append(measure(model))
    left, right = found
    assert left.angle > 0.03
    assert right.angle == pytest.approx(-left.angle, rel=0.05)  # the mesh is coarse, and not its own mirror image
    assert right.volume == pytest.approx(left.volume[::-1], rel=0.02)
    both = fe_model(small(), "II", COARSE)
    equilibrium(both, pressure=(P, P))
    straight = measure(both)
    assert abs(straight.angle) < 0.05 * left.angle
    length = straight.tip[0] - both.body.plate  # a straight line, the plate behind it, which the hoses bulge a little
    assert straight.length == pytest.approx(length, rel=3e-3)
    plate = both.body.plate * np.array([math.cos(left.angle), math.sin(left.angle)])
    chord = math.dist((0.0, 0.0), left.tip - plate)
    assert chord < left.length < 1.01 * chord / np.sinc(left.angle / (2 * math.pi))  # nearly an arc of a circle


@pytest.mark.fe
def test_the_slope_of_the_energy_is_the_force_on_every_unknown() -> None:
    model = fe_model(small(), "II", COARSE)
    equilibrium(model, pressure=(P, 20e3), couple=0.01)
    problem, u = model.problem, model.problem.state.vec
    force, trial = u.CreateVector(), u.CreateVector()
    direction = u.CreateVector()
    direction.FV().NumPy()[:] = 1e-6 * np.random.default_rng(1).standard_normal(len(u))
    trial.data = u + 3 * direction  # away from equilibrium, where the force is not zero
    problem.energy.Apply(trial, force)
    slope = force.InnerProduct(direction)
    ends = [u.CreateVector() for _ in range(2)]
    for end, sign in zip(ends, (1, -1), strict=True):
        end.data = trial + 0.1 * sign * direction
    difference = (problem.energy.Energy(ends[0]) - problem.energy.Energy(ends[1])) / 0.2
    assert slope == pytest.approx(difference, rel=1e-4)


@pytest.mark.fe
def test_volume_and_angle_are_what_the_loads_work_on() -> None:
    """In equilibrium the total energy changes with a pressure by minus its volume, with T by minus sin(angle)."""
    model = fe_model(small(), "II", COARSE)

    def total(left: float, right: float, couple: float) -> float:
        assert equilibrium(model, pressure=(left, right), couple=couple).converged
        return 2 * float(model.problem.energy.Energy(model.problem.state.vec))

    step, turn = 500.0, 2e-4
    slopes = [
        (total(P + step, 10e3, 0.01) - total(P - step, 10e3, 0.01)) / (2 * step),
        (total(P, 10e3 + step, 0.01) - total(P, 10e3 - step, 0.01)) / (2 * step),
        (total(P, 10e3, 0.01 + turn) - total(P, 10e3, 0.01 - turn)) / (2 * turn),
    ]
    total(P, 10e3, 0.01)
    found = measure(model)
    hose = math.pi * (0.0025**2 - 0.0018**2) * 0.03
    assert slopes[0] == pytest.approx(-(found.volume[0] + hose), rel=1e-3)
    assert slopes[1] == pytest.approx(-(found.volume[1] + hose), rel=1e-3)
    assert slopes[2] == pytest.approx(-math.sin(found.angle), rel=1e-2)


@pytest.mark.fe
def test_a_long_body_bends_under_a_couple_as_a_beam() -> None:
    """Soft hoses without a braid to speak of: M = E I angle / L, with the second moment of the holed section."""
    unit = {"outer_diameter_m": 0.004, "inner_diameter_m": 0.0039, "braid_stiffness_n_per_m": 1e-3}
    robot = small(segment_length_m=[0.12], lever_m=0.0045, unit=unit)
    model = fe_model(robot, "II", FeOptions(mesh=MeshSize(0.8, order=3, pieces=20.0)))
    T = 1e-3
    assert equilibrium(model, pressure=(0.0, 0.0), couple=T).converged
    hole = math.pi * 0.002**2
    second = math.pi / 4 * 0.014 * 0.013**3 - 2 * (hole * 0.0045**2 + math.pi / 4 * 0.002**4)
    E = 2 * 1.475 * 80e3 / 3  # 2 (1 + nu) times the shear modulus, a third of the modulus_fe_pa
    angle = measure(model).angle
    assert angle == pytest.approx(T * 0.12 / (E * second), rel=0.05)  # its ends are held: a little stiffer


@pytest.mark.fe
def test_work_is_taken_up_where_it_ended(tmp_path: Path) -> None:
    pressure = [20e3, 40e3, 60e3]
    whole = fe_bend(small(), "II", pressure, options=COARSE)
    fe_bend(small(), "II", pressure, options=COARSE, folder=tmp_path)
    lines = (tmp_path / JOURNAL).read_bytes().splitlines(keepends=True)
    (tmp_path / JOURNAL).write_bytes(b"".join(lines[:3]) + lines[3][:10])  # as a kill leaves it
    asked: list[int] = []
    again = fe_bend(small(), "II", pressure, options=COARSE, folder=tmp_path, each=lambda _m, k, _f: asked.append(k))
    assert asked == [2]
    np.testing.assert_allclose(again.angle, whole.angle, rtol=1e-6)
    with pytest.raises(
        InputError, match="has 40 kPa as pressure 2, but --pressure has 60 kPa now: a run may add higher"
    ):
        fe_bend(small(), "II", pressure[::2], options=COARSE, folder=tmp_path)
    with pytest.raises(InputError, match="has 40 kPa as pressure 2, but --pressure has none now"):
        fe_bend(small(), "II", pressure[:1], options=COARSE, folder=tmp_path)
    with pytest.raises(InputError, match="was started with poisson"):
        fe_bend(small(), "II", pressure, options=FeOptions(mesh=SMALL, poisson=0.49), folder=tmp_path)
    (tmp_path / "state-001.bin").write_bytes(b"short")
    (tmp_path / JOURNAL).write_bytes(b"".join(lines[:3]))
    with pytest.raises(InputError, match=r"state-001\.bin must hold"):
        fe_bend(small(), "II", pressure, options=COARSE, folder=tmp_path)


@pytest.mark.fe
def test_a_damaged_state_is_not_taken_up(tmp_path: Path) -> None:
    pressure = [20e3, 40e3]
    fe_bend(small(), "II", pressure[:1], options=COARSE, folder=tmp_path)
    state = tmp_path / "state-000.bin"
    numbers = np.frombuffer(state.read_bytes()).copy()
    numbers[len(numbers) // 2] += 1e-4  # m: a likely number
    state.write_bytes(numbers.tobytes())
    with pytest.raises(InputError, match=r"state-000\.bin is damaged: it is not what the journal tells: remove the"):
        fe_bend(small(), "II", pressure, options=COARSE, folder=tmp_path)


@pytest.mark.fe
def test_a_pressure_that_is_not_reached_is_told_and_the_rest_kept() -> None:
    soft = small(unit={"braid_stiffness_n_per_m": 1000.0})  # fibers give way: 60 kPa bursts it
    found = fe_bend(soft, "II", [5e3, 60e3, 80e3], options=COARSE)
    assert found.status == "failed"
    assert found.pressure.tolist() == [5e3]
    assert found.status_text.startswith("60 kPa was not reached (")
    assert found.status_text.endswith("results end at 5 kPa.")


@pytest.mark.fe
@pytest.mark.parametrize(
    ("options", "says"),
    [
        (FeOptions(mesh="medum"), "mesh must be a known mesh, but is 'medum': did you mean"),
        (FeOptions(law="ogden"), "law must be a known law, but is 'ogden'"),
        (FeOptions(poisson=0.5), "poisson must be at least 0 and less than 0.5, but is 0.5"),
        (FeOptions(material="steel"), "material must be a known material set"),
    ],
)
def test_options_that_do_not_exist(options: FeOptions, says: str) -> None:
    with pytest.raises(InputError, match=says):
        fe_model(ROBOT, "II", options)


NO_BRAID = {"outer_diameter_m": 0.004, "inner_diameter_m": 0.0039, "braid_stiffness_n_per_m": 1e-3}
LONG = FeOptions(mesh=MeshSize(0.8, order=3, pieces=20.0))


def bar(**changes: Any) -> ht.Robot:
    """A long joint of matrix, with a hose a side that has hardly any stiffness."""
    return small(segment_length_m=[0.12], lever_m=0.0045, axis_width_m=0.012, **({"unit": NO_BRAID} | changes))


def matrix_of_bar() -> tuple[float, float]:
    """Stiffness of the bar's matrix in tension [N] and in bending [N m^2]."""
    E, hole = 2 * 1.475 * 80e3 / 3, math.pi * 0.002**2  # 2 (1 + nu) times the shear modulus, a third of modulus_fe_pa
    area = math.pi * 0.014 * 0.013 - 2 * hole
    second = math.pi / 4 * 0.014 * 0.013**3 - 2 * (hole * 0.0045**2 + math.pi / 4 * 0.002**4)
    return E * area, E * second


def pull_tip(model: FeModel, force: float) -> None:
    """Pull at the tip plate along the joint [N]."""
    import ngsolve as ngs

    energy, space, pull = model.problem.energy, model.problem.state.space, ngs.Parameter(0.0)
    area = ngs.Integrate(ngs.CF(1.0) * ngs.ds("tip"), model.mesh)
    u = space.TrialFunction()[0]  # its x, or with the arc's angles itself
    energy += ngs.Variation((-pull / (2 * area) * (u[0] if model.body.axis else u)).Compile() * ngs.ds("tip"))
    assert lead(Problem(energy, model.problem.state, (pull,), model.problem.shear), (force,)).converged


def strain_under(robot: ht.Robot, force: float) -> float:
    """Strain of the axis of a bar that is pulled at its tip [N], away from its ends."""
    model = fe_model(robot, "II", LONG)
    pull_tip(model, force)
    end = max(vertex.point[0] for vertex in model.mesh.vertices) * 0.12 / 0.123
    near, far = (model.mesh(part * end, 0.0, 1e-9) for part in (0.3, 0.7))
    return float(model.displacement(far)[0] - model.displacement(near)[0]) / (0.4 * 0.12)


@pytest.mark.fe
def test_slack_fibers_do_not_push() -> None:
    """A joint that is pushed shorter without pressure slackens its braids, and its hoses keep their oil."""
    model = fe_model(small(), "II", COARSE)
    before = measure(model).volume
    pull_tip(model, -2.0)
    found = measure(model)
    assert found.length < 0.97 * model.body.length
    ratio = np.divide(found.volume, before)
    assert 0.97 < ratio.min() < ratio.max() < 1.0  # fibers that push would spread the hoses by 5 %


@pytest.mark.fe
@pytest.mark.parametrize("held", [0.0, 10.0, 100.0])  # N, beside 44 N of the matrix
def test_the_axis_adds_its_stiffness_to_that_of_the_matrix(held: float) -> None:
    EA, force = matrix_of_bar()[0], 0.1
    found = strain_under(bar(axis_stiffness_n=held), force)
    assert found == pytest.approx(force / (EA + held), rel=0.01)


@pytest.mark.fe
def test_a_buckled_axis_carries_its_buckling_load() -> None:
    EA, held, buckling = matrix_of_bar()[0], 100.0, 0.3
    robot = bar(axis_stiffness_n=held, axis_buckling_n=buckling)
    assert strain_under(robot, -0.2) == pytest.approx(-0.2 / (EA + held), rel=0.01)
    assert strain_under(robot, -0.9) == pytest.approx(-(0.9 - buckling) / EA, rel=0.02)
    assert strain_under(robot, 0.9) == pytest.approx(0.9 / (EA + held), rel=0.02)  # a pull does not buckle it


@pytest.mark.fe
@pytest.mark.parametrize("held", [40.0, 1e4])
def test_a_held_axis_bends_by_the_shortening_over_the_lever(held: float) -> None:
    """kappa = eps w / (w^2 + EI / (EA + held)): eps / w with a held axis, eps w / (w^2 + I / A) with a free one."""
    EA, EI = matrix_of_bar()
    unit = {"outer_diameter_m": 0.004, "inner_diameter_m": 0.0039}
    model = fe_model(bar(axis_stiffness_n=held, unit=unit), "II", LONG)
    assert equilibrium(model, pressure=(4e3, 0.0)).converged
    found = measure(model)
    curvature, axis, w = found.angle / 0.12, found.length / 0.12 - 1, 0.0045
    shortening = w * curvature - axis
    assert curvature * w / shortening == pytest.approx(w**2 / (w**2 + EI / (EA + held)), rel=0.05)


@pytest.mark.fe
def test_compression_along_the_arc_does_not_push_the_axis_aside() -> None:
    """An energy of the length alone falls if the strip turns aside: it wrinkles, as finely as the mesh lets it."""
    import ngsolve as ngs
    from netgen.occ import Box, OCCGeometry

    mesh = ngs.Mesh(OCCGeometry(Box((0, 0, 0), (1, 1, 1))).GenerateMesh(maxh=1.0))

    def energy(stretch: float, aside: float, turn: float = 0.3) -> float:
        c, s = math.cos(turn), math.sin(turn)
        along = ngs.CF((stretch * c - aside * s, stretch * s + aside * c, 0.0))
        return float(aligned_axis_energy(Axis(100.0, 3.0, 0.01), along, ngs.CF(turn))(mesh(0.5, 0.5, 0.5)))

    assert energy(0.98, 0.0) == pytest.approx(100 * 0.02**2 / 2 / 0.01)
    assert energy(0.90, 0.0) == pytest.approx((3 * 0.1 - 3**2 / 200) / 0.01)  # buckled
    assert energy(1.02, 0.0) == pytest.approx(100 * 0.02**2 / 2 / 0.01)
    assert energy(0.98, 0.1) > energy(0.98, 0.0)
    assert energy(1.00, 0.1) == pytest.approx(
        100 * (math.hypot(1, 0.1) - 1) ** 2 / 2 / 0.01 + LOOSE * 50 / 0.01 * 0.1**2
    )


@pytest.mark.fe
@pytest.mark.parametrize("mesh", ["coarse", "medium"])
@pytest.mark.parametrize("joint", ["I", "II"])
def test_the_strip_of_a_held_axis_is_in_the_mesh(joint: str, mesh: str) -> None:
    import ngsolve as ngs

    document = ROBOT.document()
    for group in document["joints"]:
        group["actuator"] |= {"axis_stiffness_n": 1000.0, "axis_width_m": 0.0071}
    body = joint_body(parse(document), joint)
    found, _kept = joint_mesh(body, MESHES[mesh])
    assert ngs.Integrate(ngs.CF(1.0) * ngs.ds("axis"), found) == pytest.approx(0.0071 / 2 * body.length, rel=1e-6)
    assert ngs.Integrate(ngs.y * ngs.y * ngs.ds("axis"), found) < 1e-20  # in the neutral layer


def test_nothing_holds_the_axis_unless_it_is_described() -> None:
    assert joint_body(with_joint(axis_width_m=0.01), "II").axis == 0
    with pytest.raises(InputError, match=r"axis_width_m must leave matrix above and below, but is 60 mm in 4"):
        joint_body(with_joint(axis_stiffness_n=1.0, axis_width_m=0.06), "II")
    with pytest.raises(InputError, match=r"strip_width_m was renamed: write axis_width_m"):
        with_joint(strip_width_m=0.006)
