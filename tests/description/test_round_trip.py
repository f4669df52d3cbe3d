"""Robot descriptions, properties: each allowed one reads back unchanged from a file and from a document."""

import json
import tomllib
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from hypertuna.description.robot import parse

TEXTS = st.text(st.characters(categories=("L", "N", "P", "S", "Zs")), min_size=1, max_size=8)
NAMES = st.text(st.characters(categories=("L", "N"), include_characters="_-.+()' "), min_size=1, max_size=8).filter(
    lambda name: name[0].isalnum()
)
POSITIVE = st.floats(1e-3, 1e3)


@st.composite
def documents(draw: st.DrawFn) -> dict[str, Any]:
    """Any valid robot, as a document."""
    links = draw(st.integers(1, 6))

    def column(values: st.SearchStrategy[float], size: int = links) -> list[float]:
        return draw(st.lists(values, min_size=size, max_size=size))

    def degrees(low: float, high: float, size: int) -> list[float]:
        return [round(angle, 6) for angle in column(st.floats(low, high), size)]

    length, mass = column(POSITIVE), column(POSITIVE)
    owner = draw(st.lists(st.integers(0, 3), min_size=links - 1, max_size=links - 1))
    groups = [[i for i, g in enumerate(owner, start=1) if g == group] for group in sorted({*owner} - {0})]
    keys = ("added_mass_normal", "added_mass_tangential", "added_inertia", "drag_normal", "drag_tangential")
    laws: dict[str, Any] = {
        "strip": {key: column(POSITIVE) for key in keys} | {"cross_flow": draw(st.booleans())},
        "lumped": {key: column(POSITIVE) for key in ("added_mass", "friction", "drag")},
        "elongated": {key: column(POSITIVE) for key in ("added_mass_normal", "drag_normal", "drag_tangential")},
    }
    law = draw(st.sampled_from(sorted(laws)))
    gait = {"frequency_hz": draw(POSITIVE), "amplitude_deg": degrees(0, 180, len(groups))}
    return {
        "format": 1,
        "name": draw(NAMES),
        "description": draw(TEXTS),
        "body": {"length_m": sum(length), "mass_kg": sum(mass) * draw(st.floats(1, 2))},
        "links": {
            "name": draw(st.lists(NAMES, min_size=links, max_size=links, unique=True)),
            "length_m": length,
            "com_m": [x * l for x, l in zip(column(st.floats(0, 1)), length, strict=True)],  # noqa: E741
            "mass_kg": mass,
            "lateral_area_m2": column(POSITIVE),
            "wetted_area_m2": column(POSITIVE),
        },
        "joints": [{"name": f"{g}", "links": group, "bandwidth_hz": draw(POSITIVE)} for g, group in enumerate(groups)],
        "model": {"water": law, "joints": draw(st.sampled_from(("ideal", "bandwidth")))},
        "water": {"density_kg_m3": draw(POSITIVE), law: laws[law]},
        "gaits": {draw(NAMES): gait | {"phase_deg": degrees(-360, 360, len(groups))}},
        "battery": {"cells": draw(st.integers(1, 9)), "capacity_ah": round(draw(POSITIVE), 3), "voltage_v": 3.6},
        "sources": {"links.mass_kg": draw(TEXTS)},
    }


def as_toml(value: Any) -> str:
    """Write a value in TOML, tables inline."""
    if isinstance(value, dict):
        pairs = (f"{as_toml(key)} = {as_toml(part)}" for key, part in value.items())
        return f"{{{', '.join(pairs)}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(as_toml, value))}]"
    return json.dumps(value, ensure_ascii=False)


@given(document=documents())
def test_any_robot_makes_the_round_trip(document: dict[str, Any]) -> None:
    text = "\n".join(f"{key} = {as_toml(value)}" for key, value in document.items())
    robot = parse(tomllib.loads(text))
    assert robot.document() == document
    assert parse(robot.document()) == robot
    assert parse(robot.document()).hash == robot.hash
