"""Values of a robot that are set by key, as in the option `--set` and in the sizing of pumps."""

import re
from collections.abc import Mapping
from typing import Any

from hypertuna.description.robot import Robot, parse
from hypertuna.description.validation import written
from hypertuna.errors import InputError, InputErrors, did_you_mean
from hypertuna.io.door import parse_toml

NAMES = ("name", "drives", "quantity")  # keys that name a table in a list: of joint groups, servos, sensors


def changed(robot: Robot, values: Mapping[str, Any], option: str = "--set") -> Robot:
    """Return the robot with new values [units of the file], by key as in its file.

    A table of a list is chosen by name or index, ``joints.II.bandwidth_hz`` or ``links.mass_kg[3]``; without either,
    all tables of the list get the value: ``joints.line.bore_m``. `option` is named in errors.
    """
    if not values:
        return robot
    document = robot.document()
    sources = document.setdefault("sources", {})
    try:
        for key, value in values.items():
            place = written(tuple(_set(document, key, value, key)))
            old_source = robot.source(place)
            sources[place] = f"{key} set to {value}{f'; before: {old_source}' if old_source else ''}"
        return parse(document, file=robot.file)
    except InputError as error:
        errors = error.errors if isinstance(error, InputErrors) else (error,)
        relabeled = [InputError(e.rule, file=option, key=e.key, value=e.value, fix=_fix(e, values)) for e in errors]
        relabeled = [e for e in relabeled if not (e.key or "").startswith("sources")] or relabeled
        raise InputErrors(relabeled) from None


def settable(robot: Robot) -> list[str]:
    """Return the keys of all values in a robot's file that `changed` can set, without [uncertainty] and [sources]."""
    document = robot.document()
    return _settable({key: part for key, part in document.items() if key not in ("uncertainty", "sources")}, "")


def _settable(node: Any, key: str) -> list[str]:
    """Return the keys of the values below a node; tables of a list are named, or have an index."""
    if isinstance(node, dict):
        parts = list(node.items())
    elif isinstance(node, list) and node and all(isinstance(part, dict) for part in node):
        names = [next((str(part[name]) for name in NAMES if name in part), f"[{k}]") for k, part in enumerate(node)]
        parts = list(zip(names, node, strict=True))
    else:
        return [key]
    return [leaf for name, part in parts for leaf in _settable(part, f"{key}.{name}".replace(".[", "[").lstrip("."))]


def _fix(error: InputError, values: Mapping[str, Any]) -> str | None:
    """Return the fix of an error; if a comma split one number into two integers, the fix is a decimal point."""
    pairs = [v for v in values.values() if isinstance(v, list) and len(v) == 2 and all(isinstance(x, int) for x in v)]
    pair = next((pair for pair in pairs if str(pair) == error.value and error.rule == "must be a number"), None)
    return error.fix if pair is None else f"write a decimal point, {pair[0]}.{pair[1]}"


def toml_value(text: str) -> Any:
    """Return the value of a text in TOML; numbers with commas are a list, and words without quotes are text."""
    for candidate in (text, f"[{text}]" if "," in text else text):
        try:
            return parse_toml(f"value = {candidate}")["value"]
        except InputError:
            continue
    try:
        return float(text)  # forms that TOML lacks, such as .5
    except ValueError:
        return text


def _set(node: Any, rest: str, value: Any, key: str) -> list[str]:
    """Set the value of a key below a node, in all tables of a list if none is named; return the names of its place."""
    if isinstance(node, list):
        return _set_in_list(node, rest, value, key)
    if not isinstance(node, dict):
        raise InputError("goes beyond a value", key=key, fix="leave out the end of the key")
    matches = [name for name in node if re.match(rf"{re.escape(name)}($|[.\[])", rest)]
    word = re.match(r'"[^"]+"|[^.\[]+', rest)
    name = max(matches, key=len) if matches else word[0] if word else ""
    if not name:
        raise InputError("is no key", key=key, fix="write it as in the robot's file: body.mass_kg")
    below = rest[len(name) :].removeprefix(".")
    name = name.strip('"')
    if not below:
        node[name] = value
        return [name]
    return [name, *_set(node.setdefault(name, {}), below, value, key)]


def _set_in_list(nodes: list[Any], rest: str, value: Any, key: str) -> list[str]:
    """Set the value in one table or number of a list, or in all tables; return the names of its place in the list."""
    if index := re.match(r"\[(\d+)\]\.?", rest):
        k = int(index[1])
        if k >= len(nodes):
            fix = f"indices are from 0 to {len(nodes) - 1}"
            raise InputError("is beyond the end of the list", key=key, fix=fix)
        if below := rest[index.end() :]:
            return _set(nodes[k], below, value, key)
        nodes[k] = value
        return []
    tables = [node for node in nodes if isinstance(node, dict)]
    tables_by_name = {str(node[part]): node for node in tables for part in NAMES if part in node}
    matches = [name for name in tables_by_name if rest.startswith(f"{name}.")]
    if matches:
        name = max(matches, key=len)
        return _set(tables_by_name[name], rest[len(name) + 1 :], value, key)
    if not tables:
        raise InputError("is a list of values", key=key, fix="choose one with its index: [0]")
    next_name = rest.partition(".")[0]
    if "." in rest and not any(next_name in node for node in tables):
        raise InputError("names none of the list", key=key, fix=did_you_mean(next_name, tables_by_name))
    places = [_set(node, rest, value, key) for node in tables]
    return places[0]
