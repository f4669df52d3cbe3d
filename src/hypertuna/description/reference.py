"""The schema of a TOML file in words: its tables and keys, with units, allowed values, defaults and meanings."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from hypertuna.description.robot import Robot, load
from hypertuna.description.schema.base import BEYOND
from hypertuna.description.validation import declared, plain

# Types of JSON Schema in words, singular and plural.
_NOUNS = {
    "number": ("number", "numbers"),
    "integer": ("whole number", "whole numbers"),
    "string": ("text", "texts"),
    "boolean": ("`true` or `false`", "`true` or `false`"),
}
_LIMITS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}


class Key(NamedTuple):
    """A key of a robot's file with its documentation, in words."""

    key: str  # such as joints.line.bore_m or gaits.NAME.frequency_hz
    unit: str
    value: str  # allowed values
    default: str  # empty if the key is required
    typical: str  # HyperTuna's value, or the usual range
    how: str  # how to find the value
    meaning: str


def keys() -> list[Key]:
    """Return all keys of a robot's file; typical values are HyperTuna's, or usual ranges."""
    schema, result = json_schema(), []
    typical = _typical()
    for heading, table in tables(schema, schema["$defs"], ""):
        path = heading.strip("[]`")
        for name, rule in table["properties"].items():
            value = value_in_words(rule)
            if not value.endswith(("table", "tables", "tables by name")):
                key = f"{path}.{name}".lstrip(".")
                plain_key = key.replace(".NAME", "")
                default = "" if name in table.get("required", []) else _default(rule)
                meaning = re.sub(r" \(default: .*\)$", "", rule["description"])
                how = declared(Robot)[plain_key].how
                result.append(Key(key, rule.get("unit", ""), value, default, typical.get(plain_key, ""), how, meaning))
    return result


def _default(rule: Mapping[str, Any]) -> str:
    """Return the default of an optional key: the rule that its meaning states, else the value, else "none"."""
    if rule_in_words := re.search(r"\(default: (.*)\)$", rule["description"]):
        return rule_in_words[1]
    value = rule.get("default")
    return "none" if value is None or value in ([], {}) else json.dumps(value).strip('"')


def _typical() -> dict[str, str]:
    """Return typical values as text, by key without indices and without names of gaits and materials."""
    typical = {key: "{:g} to {:g}".format(*k.usual) for key, k in declared(Robot).items() if k.usual}
    own_values: dict[str, str] = {}
    for entry in load("hypertuna").entries():
        if not entry.default:
            own_values.setdefault(plain(entry.key), _shown(entry.value))
    return typical | own_values


def _shown(value: Any) -> str:
    """Return a value of a robot as text; a list of numbers is shown as its lowest and highest."""
    flat = (
        [x for part in value for x in (part if isinstance(part, list) else [part])] if isinstance(value, list) else []
    )
    if flat and all(isinstance(x, int | float) for x in flat):
        return f"{min(flat):.4g} to {max(flat):.4g}" if min(flat) < max(flat) else f"{flat[0]:.4g}"
    return f"{value:.4g}" if isinstance(value, float) else ", ".join(map(str, flat)) or str(value)


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a robot file: keys with description and ``unit``."""
    schema = Robot.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | schema


def tables(
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
                yield from tables(shared[form["$ref"].rsplit("/", 1)[-1]], shared, title)


def _unless_null(rule: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the rule for the value of a key, without the alternative null of an optional key."""
    options: list[Mapping[str, Any]] = rule.get("anyOf", [rule])
    return next(option for option in options if option.get("type") != "null")


def value_in_words(rule: Mapping[str, Any], number: int = 0) -> str:
    """Return the allowed values of a key in words, such as "number > 0"; number: 0 for singular, 1 for plural."""
    rule = _unless_null(rule)
    if choices := rule.get("enum", [rule["const"]] if "const" in rule else None):
        return " or ".join(f"`{json.dumps(choice)}`" for choice in choices)
    if pair := rule.get("prefixItems"):
        return f"{('pair', 'pairs')[number]} of {value_in_words(pair[0], 1)}"
    if rule.get("type") == "array":
        return f"list of {value_in_words(rule['items'], 1)}"
    if entries := rule.get("additionalProperties"):
        return f"{value_in_words(entries, 1)} by name"
    noun = _NOUNS.get(rule.get("type", ""), ("table", "tables"))[number]
    # limits of BEYOND only keep slips out, and are not mentioned
    present = {name: rule[name] for name in _LIMITS if name in rule and abs(rule[name]) < BEYOND}
    limits = (f"{_LIMITS[name]} {limit:g}" for name, limit in present.items())
    return f"{noun} {' and '.join(limits)}".strip()
