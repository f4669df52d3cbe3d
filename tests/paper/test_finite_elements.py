"""Stored results of finite elements: they belong to the shipped robot, and what does not is not told."""

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.io.files import shipped
from hypertuna.paper.chapters import finite_elements as reproduce_fe
from hypertuna.paper.chapters.actuator import LINES, line_findings
from hypertuna.paper.chapters.finite_elements import (
    FE,
    ROBOT,
    Elements,
    findings,
    joint_hash,
    read_elements,
    sections,
    solve_elements,
)
from hypertuna.paper.ledger import judge, published
from hypertuna.reports.html import Picture, inline

PRESSURE = np.linspace(0, 250, 6)  # kPa
TENTH = 1.1  # of the bend of the fast model, in made-up records


def record(robot: ht.Robot, joint: str) -> dict[str, Any]:
    """Make up a result: a tenth more than the fast model bends; oil and length as in the model."""
    bent = ht.bend(robot, joint, 1e3 * PRESSURE, friction=False)
    model = next(model for model in joint_models(robot) if model.name == joint)
    group = next(group for group in robot.joints if group.name == joint)
    still = model.balance(np.stack([1e3 * PRESSURE, 0 * PRESSURE], axis=1))
    lumens = group.drive_units * np.pi / 4 * robot.drive_unit.inner_diameter**2
    oil = 1e6 * (still["volume"] + lumens * (group.actuator.length - model["length"]))
    length = 1e3 * (group.actuator.length + model["length"] * (model["rest"] + still["strain"]))
    columns = {
        "pressure_kpa": PRESSURE,
        "bend_deg": TENTH * np.degrees(bent.angle),
        "oil_taken_ml": 1e6 * bent.volume,
        "volume_left_ml": oil[:, 0],
        "volume_right_ml": oil[:, 1],
        "length_mm": length,
    }
    steps = [dict(zip(columns, map(float, row), strict=True)) for row in zip(*columns.values(), strict=True)]
    facts = {"status": "converged", "status_text": "All 6 pressures were reached.", "mesh": "medium"}
    facts |= {"material": robot.drive_unit.material_set, "law": "mooney_rivlin", "poisson": 0.475}
    facts |= {"elements": 1234, "unknowns": 5678, "seconds": 99.0, "joint_hash": joint_hash(robot, joint)}
    return facts | {"steps": steps}


def png(wide: int, high: int) -> bytes:
    """Write a gray picture."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", wide, high, 8, 0, 0, 0, 0)
    lines = zlib.compress((b"\0" + b"\x80" * wide) * high)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", lines) + chunk(b"IEND", b"")


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Put made-up results in the place of the stored ones."""
    robot = ht.load(ROBOT)
    for group in robot.joints:
        (tmp_path / f"{ROBOT}-{group.name}.json").write_text(json.dumps(record(robot, group.name)))
    (tmp_path / "I.png").write_bytes(png(30, 20))
    monkeypatch.setattr(reproduce_fe, "shipped", lambda _: tmp_path)
    return tmp_path


def changed(path: Path, **facts: Any) -> None:
    """Change a stored result."""
    path.write_text(json.dumps(json.loads(path.read_text()) | facts))


def told(elements: Elements) -> dict[tuple[str, str], Any]:
    """Judge all findings, by id and model."""
    return {(found.id, found.model): judge(published(), found) for found in findings(elements)}


def test_what_is_stored_belongs_to_the_shipped_robot() -> None:
    for one in read_elements().solved.values():
        assert one.record is not None, one.reason
        assert one.record["robot"] == one.robot.name
        assert one.record["mesh"] == reproduce_fe.MESH
        for key in ("command", "hypertuna_version", "ngsolve_version", "robot_hash"):
            assert one.record[key]
        paths = shipped("data/fe").glob(f"{ROBOT}-{one.joint}-map*.json")
        assert len(one.maps) == len(list(paths))  # none is of another joint


def test_the_fast_model_is_near_what_is_stored() -> None:
    """Bends within 5 %, oil, moments and volumes within 10 %: slack hoses keep their oil in both models."""
    solved = read_elements().solved.values()
    assert max(np.abs(one.difference).max() for one in solved) < 0.05
    assert max(np.abs(one.oil_difference).max() for one in solved) < 0.1
    assert max(one.over_points["moment"] for one in solved) < 0.1
    assert max(one.over_points["volume"] for one in solved) < 0.1


def test_pictures_of_both_joints_are_stored_and_small() -> None:
    elements = read_elements()
    assert set(elements.pictures) == set(elements.solved)
    assert all(len(picture) < 300_000 for picture in elements.pictures.values())
    assert len(list(shipped("data/fe").glob("*.png"))) == len(elements.pictures)


def test_a_tenth_more_than_the_fast_model(store: Path) -> None:
    elements = read_elements()
    entries = told(elements)
    assert len(entries) == 2 * 3
    fish = ht.load(ROBOT)
    angle = TENTH * np.degrees(ht.bend(fish, "I", [250e3], friction=False).angle[0])
    assert entries["fe/bending-I", FE].computed == pytest.approx(angle)
    for one in elements.solved.values():
        assert one.difference[1:] == pytest.approx(1 / TENTH - 1)
        assert one.oil_difference == pytest.approx(0, abs=1e-9)
        assert one.over_points["volume"] == pytest.approx(0, abs=1e-8)
        assert 0.01 < one.over_points["moment"] < 0.3  # which the angle's tenth needs, over that of the straight joint
    line = np.corrcoef(PRESSURE[2:], elements.solved["I"].angle[2:])[0, 1] ** 2
    assert f"R² = {line:.3f}" in entries["fe/bending-I", FE].note
    assert "1,234 tetrahedra" in entries["fe/bending-I", FE].note


def test_bends_are_judged_by_a_straight_line() -> None:
    pressure = 1e3 * np.linspace(0, 250, 11)  # Pa
    for power, verdict in ((1.0, "agrees"), (1.3, "deviates"), (0.7, "deviates")):
        found = line_findings("I", FE, pressure, (pressure / 1e6) ** power)
        assert next(judge(published(), one).verdict for one in found) == verdict, power
    linear, below = line_findings("I", FE, pressure, pressure / 1e6 + 0.1)  # straight, but not through the origin
    assert linear.computed == pytest.approx(1)
    line = 0.35 * np.array([0.4, 0.6, 0.8])
    assert below.computed == pytest.approx(np.mean((np.array([0.1, 0.15, 0.2]) + 0.1) / line))


def test_a_map_adds_its_states(store: Path) -> None:
    """A map with a side that holds 1 ml less at one point: the volume's difference is that over the range."""
    one = read_elements().solved["II"]
    (pressure, elements), before = one.points, one.over_points
    step = {"angle_deg": [[0.0]], "moment_n_m": [[0.0]], "length_mm": [[float(1e3 * elements.length[0, 0])]]}
    volume = 1e6 * elements.volume[0, 0]
    step |= {"volume_left_ml": [[float(volume[0]) - 1]], "volume_right_ml": [[float(volume[1])]]}
    record = {"elements": step, "pressure_left_kpa": [0.0], "pressure_right_kpa": [0.0]}
    path = store / f"{ROBOT}-II-map.json"
    path.write_text(json.dumps(record | {"joint_hash": joint_hash(one.robot, "II")}))
    more = read_elements().solved["II"]
    assert more.points[0].shape == (len(pressure) + 1, 2)
    whole = 1e6 * np.append(elements.volume.ravel(), elements.volume.min() - 0)
    low = min(whole.min(), volume[0] - 1)
    assert more.over_points["volume"] == pytest.approx(1 / (whole.max() - low), rel=1e-6)
    assert more.over_points["moment"] == pytest.approx(before["moment"])
    path.write_text(json.dumps(record | {"joint_hash": "of another one"}))
    assert read_elements().solved["II"].maps == ()


def test_a_series_of_nested_spaces_is_told_with_its_joint_only(store: Path) -> None:
    levels = [{"bisections": k, "bend_deg": bend} for k, bend in enumerate((25.0, 25.5, 25.75))]
    found = {"order": 1.0, "limit": 26.0, "index_percent": 1.2136}
    series = {"levels": levels, "pressure_kpa": 150.0, "convergence_bend_deg": found}
    series["joint_hash"] = joint_hash(ht.load(ROBOT), "II")
    (store / "nested.json").write_text(json.dumps({"II h": series}))
    entries = told(read_elements())
    text = (
        "bisected meshes at 150 kPa bend by 25.00, 25.50, 25.75 deg: a limit of 26.00 deg with the observed order 1.0"
    )
    assert f"{text}, grid convergence index 1.2 %" in entries["fe/bending-II", FE].note
    assert "bisected" not in entries["fe/bending-I", FE].note
    (store / "nested.json").write_text(json.dumps({"II h": series | {"convergence_bend_deg": None}}))
    assert "25.75 deg, which tell no limit" in told(read_elements())["fe/bending-II", FE].note
    (store / "nested.json").write_text(json.dumps({"II h": series | {"joint_hash": "of another one"}}))
    assert "bisected" not in told(read_elements())["fe/bending-II", FE].note


def test_another_joint_s_result_does_not_count(store: Path) -> None:
    changed(store / "hypertuna-II.json", joint_hash="of another one")
    entries = told(read_elements())
    for key in (("fe/bending-II", FE), *((f"{line}-II", FE) for line in LINES)):
        assert entries[key].verdict == "not-computed"
        assert "joint II" in entries[key].note
        assert "validation/fe/ledger.py" in entries[key].note
    assert entries["fe/bending-I", FE].computed is not None


def test_a_result_of_another_poisson_s_ratio_does_not_count(store: Path) -> None:
    changed(store / "hypertuna-I.json", poisson=0.49)
    entry = told(read_elements())["fe/bending-I", FE]
    assert entry.verdict == "not-computed"
    assert "poisson = 0.49, but it is 0.475 now" in entry.note


def test_nothing_stored_or_not_converged_is_said(store: Path) -> None:
    (store / "hypertuna-I.json").unlink()
    changed(store / "hypertuna-II.json", status="failed", status_text="150 kPa was not reached (because).")
    elements = read_elements()
    entries = told(elements)
    assert "no result is stored" in entries["fe/bending-I", FE].note
    assert entries["fe/bending-II", FE].note == "150 kPa was not reached (because)"
    assert sections(elements) == []
    changed(store / "hypertuna-II.json", status="converged")
    (section,) = sections(read_elements())  # joint II is left
    assert [part.name for part in section.parts if isinstance(part, Picture)] == ["fe-bend-II"]


def test_a_joint_is_told_apart_by_what_its_model_takes() -> None:
    fish = ht.load("hypertuna")
    document = fish.document()
    document["battery"]["capacity_ah"] *= 2
    document["drive_unit"]["friction"] = 0.05  # these are for the fast model alone
    document["joints"][0]["actuator"]["stiffness_factor"] = 2.0
    other = parse(document)
    assert other.hash != fish.hash
    assert joint_hash(other, "I") == joint_hash(fish, "I") != joint_hash(fish, "II")
    document["joints"][1]["actuator"]["lever_m"] *= 1.01
    other = parse(document)
    assert joint_hash(other, "I") == joint_hash(fish, "I")
    assert joint_hash(other, "II") != joint_hash(fish, "II")


def test_without_the_extra_the_stored_results_stay_with_a_word(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: Any, **__: Any) -> None:
        raise InputError("is needed and is not installed", key="ngsolve", fix="install it")

    monkeypatch.setattr(reproduce_fe, "fe_bend", missing)
    ticks: list[int] = []
    entries = told(solve_elements(read_elements(), lambda: ticks.append(1)))
    assert len(ticks) == 2
    assert entries["fe/bending-I", FE].computed is not None
    assert "not computed again: ngsolve" in entries["fe/bending-I", FE].note


def test_the_section_shows_a_picture_from_a_file(store: Path) -> None:
    (section,) = sections(read_elements())
    shape, *_ = [part for part in section.parts if isinstance(part, Picture)]
    assert shape.name == "fe-shape-I"
    assert 'viewBox="0 0 30 20"' in shape.svg
    element = inline(shape)
    assert element.startswith('<svg class="photo" role="img" aria-label="Joint I')
    assert "data:image/png;base64,iVBORw0KGgo" in element
