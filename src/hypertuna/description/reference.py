"""The pages that document a schema."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from hypertuna.description.robot import Robot

_NOUNS = {
    "number": ("number", "numbers"),
    "integer": ("whole number", "whole numbers"),
    "string": ("text", "texts"),
    "boolean": ("`true` or `false`", "`true` or `false`"),
}
_LIMITS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a robot file: keys with description and ``unit``."""
    schema = Robot.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | schema


def reference() -> str:
    """Return docs/description.md: every key of a robot file with unit, rule and meaning."""
    introduction = (
        "Every key of `robots/NAME.toml`, generated from the schema that `hypertuna robot schema` prints.\n"
        "Numbers must be finite; a list has one value per link, or per joint group in a gait."
    )
    return markdown(json_schema(), title="Robot description", introduction=introduction)


def markdown(schema: Mapping[str, Any], *, title: str, introduction: str) -> str:
    """Return a JSON Schema of a TOML file as a Markdown page: one section per table, one row per key."""
    lines = [f"# {title}", "", introduction]
    for heading, table in _tables(schema, schema["$defs"], ""):
        lines += ["", f"## {heading or 'Top level'}", "", table["description"].split("\n", 1)[0], ""]
        lines += ["| key | unit | value | meaning |", "|---|---|---|---|"]
        required = table.get("required", [])
        for name, rule in table["properties"].items():
            value = _value_in_words(rule) + ("" if name in required else ", optional")
            cells = [f"`{name}`", rule.get("unit", ""), value, rule["description"].replace("|", "\\|")]
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _tables(
    table: Mapping[str, Any], shared: Mapping[str, Any], heading: str
) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield a table of the schema and its subtables, each with its heading as in a TOML file."""
    yield f"`{heading}`" if heading else "", table
    path = heading.strip("[]")
    for name, rule in table["properties"].items():
        below = f"{path}.{name}" if path else name
        rule = _unless_null(rule)
        forms = (
            (rule, f"[{below}]"),
            (rule.get("items"), f"[[{below}]]"),
            (rule.get("additionalProperties"), f"[{below}.NAME]"),
        )
        for form, title in forms:
            if isinstance(form, Mapping) and "$ref" in form:
                yield from _tables(shared[form["$ref"].rsplit("/", 1)[-1]], shared, title)


def _unless_null(rule: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the rule of an optional key that is present."""
    options: list[Mapping[str, Any]] = rule.get("anyOf", [rule])
    return next(option for option in options if option.get("type") != "null")


def _value_in_words(rule: Mapping[str, Any], number: int = 0) -> str:
    """Describe the values of a key, such as "number > 0"; number 1 is the plural."""
    rule = _unless_null(rule)
    if choices := rule.get("enum", [rule["const"]] if "const" in rule else None):
        return " or ".join(f"`{json.dumps(choice)}`" for choice in choices)
    if pair := rule.get("prefixItems"):
        return f"{('pair', 'pairs')[number]} of {_value_in_words(pair[0], 1)}"
    if rule.get("type") == "array":
        return f"list of {_value_in_words(rule['items'], 1)}"
    if entries := rule.get("additionalProperties"):
        return f"{_value_in_words(entries, 1)} by name"
    noun = _NOUNS.get(rule.get("type", ""), ("table", "tables"))[number]
    limits = (f"{sign} {rule[name]:g}" for name, sign in _LIMITS.items() if name in rule)
    return f"{noun} {' and '.join(limits)}".strip()
