"""References of the keys of robots, missions and manifests, made from the schemas of their files."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from pydantic import BaseModel

from hypertuna.description.reference import json_schema, keys, tables, value_in_words


def reference() -> str:
    """Return docs/description.md: every key of a robot file with unit, rule and meaning."""
    introduction = (
        "Every key of `robots/NAME.toml`, generated from the schema that `hypertuna robot schema` prints.\n"
        "Numbers must be finite; a list has one value per link, or per joint group in a gait. Keys without a default\n"
        "are required. Typical values are HyperTuna's, or the usual range of what HyperTuna does not have.\n"
        "`hypertuna robot keys PART` prints the keys whose names contain PART."
    )
    columns = {"default": 3, "typical": 4, "how to find it": 5}
    rows = {key.key: key for key in keys()}

    def extra_cells(key: str) -> dict[str, str]:
        return {title: rows[key][place] if key in rows else "" for title, place in columns.items()}

    return markdown(json_schema(), title="Robot description", introduction=introduction, more=extra_cells)


def markdown(
    schema: Mapping[str, Any], *, title: str, introduction: str, more: Callable[[str], Mapping[str, str]] | None = None
) -> str:
    """Return a JSON Schema of a TOML file as a Markdown page: one section per table, one row per key.

    `more` returns further columns of a key, one of which may be its default.
    """
    titles = ["key", "unit", "value", *(more("") if more else ()), "meaning"]
    lines = [f"# {title}", "", introduction]
    for heading, table in tables(schema, schema["$defs"], ""):
        lines += ["", f"## {heading or 'Top level'}", "", table["description"].split("\n", 1)[0], ""]
        lines += [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
        required = table.get("required", [])
        for name, rule in table["properties"].items():
            value, meaning = value_in_words(rule), rule["description"]
            extra = more(f"{heading.strip('[]`')}.{name}".lstrip(".")) if more else {}
            if extra.get("default"):
                meaning = re.sub(r" \(default: .*\)$", "", meaning)
            elif name not in required:
                value += ", optional"
            cells = [f"`{name}`", rule.get("unit", ""), value, *extra.values(), meaning]
            lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join(lines) + "\n"


def sections(document: type[BaseModel]) -> str:
    """Return the tables of all keys of a TOML file, as sections of a page."""
    page = markdown(document.model_json_schema(by_alias=True), title="", introduction="")
    return page[page.index("## ") :].replace("## ", "### ").rstrip()
