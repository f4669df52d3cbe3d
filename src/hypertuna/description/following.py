"""Values of a robot's file that scale with a link's length, mass or height, or with the hinge's stiffness."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from hypertuna.description.schema.actuator import Hinge
from hypertuna.description.schema.base import Part
from hypertuna.description.schema.body import Fins, Links, Spatial
from hypertuna.description.schema.water import Strip

# Tables that have such values, by key.
TABLES: dict[str, type[Part]] = {"links": Links, "spatial": Spatial, "fins": Fins, "water.strip": Strip, "hinge": Hinge}


def followers(kind: str, link: int, *, alias: bool = False) -> dict[str, int]:
    """Return the values that scale with a size of a link, each with its power of the factor on that size.

    kind: "length", "mass", "height" or "stiffness". The values are named by attributes, or with `alias` by file keys.
    """
    powers = {}
    for table, part in TABLES.items():
        for name, key in part.declared.items():
            per_link = table in ("links", "spatial")
            if kind in key.follows and (table != "fins" or link == 0):  # fins are on the head
                place = f"{part.model_fields[name].alias}{f'[{link}]' * per_link}" if alias else name
                powers[f"{table}.{place}"] = key.follows[kind]
    return powers


def given(document: Mapping[str, Any], powers: Mapping[str, int]) -> dict[str, int]:
    """Return the powers of the keys that a file gives; the other keys follow through the schema's defaults."""

    def is_given(key: str) -> bool:
        try:
            table, last = table_of(document, key)
            return bool(table[last])  # zero stays zero
        except (KeyError, IndexError, TypeError):
            return False

    return {key: power for key, power in powers.items() if is_given(key)}


def table_of(document: Any, key: str) -> tuple[Any, Any]:
    """Return the table or list that holds a key such as ``links.length_m[3]``, and the key or index in it."""
    *path, last = (int(part) if part.isdigit() else part for part in re.split(r"[.\[]", key.replace("]", "")))
    for part in path:
        document = document[part]
    return document, last


def scale(document: dict[str, Any], kind: str, link: int, factor: float) -> None:
    """Multiply the values that follow a link's length, mass or height by powers of a factor."""
    for key, power in given(document, followers(kind, link, alias=True)).items():
        table, last = table_of(document, key)
        table[last] *= factor**power
