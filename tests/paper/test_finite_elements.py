"""Stored results of finite elements: they belong to the shipped robots, and what does not is not told."""

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.io.files import shipped
from hypertuna.paper.chapters import finite_elements as reproduce_fe
from hypertuna.paper.chapters.finite_elements import (
    FE,
    ROBOTS,
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
TENTH = 1.1  # of the analytic bend, in made-up records


def record(robot: ht.Robot, joint: str) -> dict[str, Any]:
    """Make up a result: a tenth more than the analytic model bends."""
    angle = TENTH * np.degrees(ht.bend(robot, joint, 1e3 * PRESSURE).angle)
    steps = [{"pressure_kpa": float(p), "bend_deg": float(a)} for p, a in zip(PRESSURE, angle, strict=True)]
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
    for name in ROBOTS.values():
        robot = ht.load(name)
        for group in robot.joints:
            (tmp_path / f"{name}-{group.name}.json").write_text(json.dumps(record(robot, group.name)))
    (tmp_path / "I.png").write_bytes(png(30, 20))
    monkeypatch.setattr(reproduce_fe, "shipped", lambda _: tmp_path)
    return tmp_path


def changed(path: Path, **facts: Any) -> None:
    """Change a stored result."""
    path.write_text(json.dumps(json.loads(path.read_text()) | facts))


def told(elements: Elements) -> dict[tuple[str, str], Any]:
    """Judge all findings, by id and model."""
    return {(found.id, found.model): judge(published(), found) for found in findings(elements)}


def test_what_is_stored_belongs_to_the_shipped_robots() -> None:
    for joints in read_elements().solved.values():
        for one in joints.values():
            assert one.record is not None, one.reason
            assert one.record["robot"] == one.robot.name
            assert one.record["mesh"] == reproduce_fe.MESH
            for key in ("command", "hypertuna_version", "ngsolve_version", "robot_hash"):
                assert one.record[key]


def test_pictures_of_both_joints_are_stored_and_small() -> None:
    elements = read_elements()
    assert set(elements.pictures) == set(elements.solved[FE])
    assert all(len(picture) < 300_000 for picture in elements.pictures.values())
    assert len(list(shipped("data/fe").glob("*.png"))) == len(elements.pictures)


def test_a_tenth_more_than_the_analytic_model(store: Path) -> None:
    elements = read_elements()
    entries = told(elements)
    assert len(entries) == 2 * 3
    fish = ht.load(ROBOTS[FE])
    angle = TENTH * np.degrees(ht.bend(fish, "I", [250e3]).angle[0])
    assert entries["fe/bending-I", FE].computed == pytest.approx(angle)
    apart = entries["fe-vs-analytic", FE]
    assert apart.computed == pytest.approx(100 * (1 / TENTH - 1))
    assert (apart.published, apart.relative_error, apart.verdict) == (None, None, "undetermined")
    assert "joint I -9.1 %, joint II -9.1 %" in apart.note
    line = np.corrcoef(PRESSURE[2:], elements.solved[FE]["I"].angle[2:])[0, 1] ** 2
    assert f"R² = {line:.3f}" in entries["fe/bending-I", FE].note
    assert "1,234 tetrahedra" in entries["fe/bending-I", FE].note


def test_another_joint_s_result_does_not_count(store: Path) -> None:
    changed(store / "hypertuna-fe-II.json", joint_hash="of another one")
    entries = told(read_elements())
    for key in ("fe/bending-II", "fe-vs-analytic"):
        assert entries[key, FE].verdict == "not-computed"
        assert "joint II" in entries[key, FE].note
        assert "validation/fe/ledger.py" in entries[key, FE].note
    assert entries["fe/bending-I", FE].computed is not None


def test_a_result_of_another_poisson_s_ratio_does_not_count(store: Path) -> None:
    changed(store / "hypertuna-I.json", poisson=0.49)
    (other,) = [model for model in ROBOTS if model != FE]
    entry = told(read_elements())["fe/bending-I", other]
    assert entry.verdict == "not-computed"
    assert "poisson = 0.49, but it is 0.475 now" in entry.note


def test_nothing_stored_or_not_converged_is_said(store: Path) -> None:
    (store / "hypertuna-fe-I.json").unlink()
    changed(store / "hypertuna-II.json", status="failed", status_text="150 kPa was not reached (because).")
    elements = read_elements()
    entries = told(elements)
    assert "no result is stored" in entries["fe/bending-I", FE].note
    (other,) = [model for model in ROBOTS if model != FE]
    assert entries["fe/bending-II", other].note == "150 kPa was not reached (because)"
    (section,) = sections(elements)  # joint II of the first model is left
    assert [part.name for part in section.parts if isinstance(part, Picture)] == ["fe-bend-II"]
    for path in store.glob("*.json"):
        path.unlink()
    assert sections(read_elements()) == []


def test_a_joint_is_told_apart_by_what_its_model_takes() -> None:
    fish = ht.load("hypertuna")
    document = fish.document()
    document["battery"]["capacity_ah"] *= 2
    document["drive_unit"]["friction"] = 0.05  # these are for the analytic model alone
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
    assert len(ticks) == 4
    assert entries["fe/bending-I", FE].computed is not None
    assert "not computed again: ngsolve" in entries["fe/bending-I", FE].note


def test_the_section_shows_a_picture_from_a_file(store: Path) -> None:
    (section,) = sections(read_elements())
    shape, *_ = [part for part in section.parts if isinstance(part, Picture)]
    assert shape.name == "fe-shape-I"
    assert 'viewBox="0 0 30 20"' in shape.svg
    element = inline(shape)
    assert element.startswith('<svg role="img" aria-label="Joint I')
    assert "data:image/png;base64,iVBORw0KGgo" in element
