"""Values of a robot's file that follow a link's length, mass or height, or the hinge's stiffness."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from hypertuna.description.schema.actuator import Hinge
from hypertuna.description.schema.base import Part
from hypertuna.description.schema.body import Fins, Links, Spatial
from hypertuna.description.schema.water import Strip

TABLES: dict[str, type[Part]] = {"links": Links, "spatial": Spatial, "fins": Fins, "water.strip": Strip, "hinge": Hinge}


def followers(kind: str, link: int, *, alias: bool = False) -> dict[str, int]:
    """Return powers of a factor on a link's length, mass or height by the attributes, or file keys, that follow it."""
    powers = {}
    for table, part in TABLES.items():
        for name, key in part.declared.items():
            per_link = table in ("links", "spatial")
            if kind in key.follows and (table != "fins" or link == 0):  # on the head
                place = f"{part.model_fields[name].alias}{f'[{link}]' * per_link}" if alias else name
                powers[f"{table}.{place}"] = key.follows[kind]
    return powers


def given(document: Mapping[str, Any], powers: Mapping[str, int]) -> dict[str, int]:
    """Return the powers of those keys that a file gives; the others follow by the schema's defaults."""

    def is_given(key: str) -> bool:
        try:
            table, last = table_of(document, key)
            return bool(table[last])  # nothing multiplies zero
        except (KeyError, IndexError, TypeError):
            return False

    return {key: power for key, power in powers.items() if is_given(key)}


def table_of(document: Any, key: str) -> tuple[Any, Any]:
    """Return the table or list of a document that holds a key such as ``links.length_m[3]``, and its name there."""
    *path, last = (int(part) if part.isdigit() else part for part in re.split(r"[.\[]", key.replace("]", "")))
    for part in path:
        document = document[part]
    return document, last


def scale(document: dict[str, Any], kind: str, link: int, factor: float) -> None:
    """Multiply the values that follow a link's length, mass or height by powers of a factor."""
    for key, power in given(document, followers(kind, link, alias=True)).items():
        table, last = table_of(document, key)
        table[last] *= factor**power
