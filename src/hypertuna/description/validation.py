"""Places of values in a document, and their texts in errors: key as in the file, rule, fix."""

import re
import types
from collections.abc import Iterator, Mapping
from functools import cache, lru_cache
from typing import Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from hypertuna.description.schema.base import Key, Part

T = TypeVar("T")
Place = tuple[int | str, ...]  # place of a value in a document: keys and indices, outermost first
_NOUNS = {  # types in pydantic's messages, in the words of a TOML file
    "dictionary": "a table",
    "tuple": "a list",
    "string": "text",
    "number": "a number",
    "integer": "a whole number",
    "boolean": "true or false",
}
_PHRASES = {  # regular expressions in pydantic's messages, and their replacements
    "^Value error, ": "",
    "Input should": "must",
    "be greater than or equal to 0$": "not be negative",
    "greater than or equal to": "at least",
    "less than or equal to": "at most",
}


def nested_model(annotation: Any) -> type[BaseModel] | None:
    """Return the pydantic model inside an annotation such as ``tuple[Model, ...]`` or ``Model | None``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    models = (nested_model(part) for part in get_args(annotation))
    return next((model for model in models if model is not None), None)


@cache
def declared(table: type[Part]) -> Mapping[str, Key]:
    """Return the declared keys of a table and its subtables, by key without indices and names."""
    keys: dict[str, Key] = {}
    for name, field in table.model_fields.items():
        keys[str(field.alias)] = table.declared[name]
        below = nested_model(field.annotation)
        if below is not None and issubclass(below, Part):
            keys |= {f"{field.alias}.{key}": declaration for key, declaration in declared(below).items()}
    return keys


def plain(key: str) -> str:
    """Return a key without indices and without the names of gaits and materials."""
    return re.sub(r'^(gaits|materials)\.("[^"]*"|[^.]+)\.', r"\1.", re.sub(r"\[\d+\]", "", key))


def entry_of(table: Mapping[str, T], key: str) -> T | None:
    """Return the entry of a table whose name is the longest prefix of a key, None if there is none."""
    without_index = re.sub(r"\[\d+\]", "", key)
    starts = [start for start in table if without_index == start or without_index.startswith(f"{start}.")]
    return table[max(starts, key=len)] if starts else None


def field_at(model: type[BaseModel] | None, place: Place) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """Return model and field at a place in a document; no model (None) for a plain value, no field if it is unknown."""
    field: FieldInfo | None = None
    named = False  # whether the next part is a name, as in [gaits.NAME]
    for part in place:
        if isinstance(part, int):
            continue
        if named or model is None:
            named = False
            continue
        field = next((candidate for candidate in model.model_fields.values() if candidate.alias == part), None)
        if field is None:
            return None, None
        model, named = nested_model(field.annotation), is_table(field.annotation)
    return model, field


def fix_for(model: type[BaseModel], key: str) -> str | None:
    """Return the fix for a missing key such as ``joints[0].line`` or ``joints.I.line``: the table or value to write."""
    place: list[str] = []
    for part in re.split(r"[.\[\]]+", key):
        if field_at(model, (*place, part))[1] is not None:
            place.append(part)
    table, field = field_at(model, tuple(place))
    return fix_of(field) if table is None or field is None else f"add the table [{'.'.join(place)}]"


def unit_of(field: FieldInfo | None) -> str:
    """Return the unit of a field; empty if it has none."""
    extra = field.json_schema_extra if field else None
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""


@lru_cache(maxsize=10_000)
def written(place: Place) -> str:
    """Return a place in the document as text: ``joints[0].links[2]``."""
    names = (part if isinstance(part, int) or re.fullmatch(r"[\w-]+", part) else f'"{part}"' for part in place)
    return "".join(f"[{name}]" if isinstance(name, int) else f".{name}" for name in names).removeprefix(".")


def rule_of(message: str) -> str:
    """Return pydantic's message as a rule, in the words of a TOML file: "must be a number"."""
    if "should have at least 1 " in message:
        return "must not be empty"
    if "exceeded maximum size" in message:
        return "must be a smaller number"
    if limit := re.search(r"should have at most (\d+) items", message):
        return f"must have at most {limit[1]} values"
    noun = next((ours for theirs, ours in _NOUNS.items() if f"valid {theirs}" in message), None)
    if noun:
        return f"must be {noun}"
    for theirs, ours in _PHRASES.items():
        message = re.sub(theirs, ours, message)
    message = message.replace("1000000000000", "1e12")
    return message


def fix_of(field: FieldInfo | None) -> str | None:
    """Return the fix for a wrong value, from meaning and unit of the field: "give the length of each link [m]"."""
    if field is None or field.description is None:
        return None
    unit, meaning = unit_of(field), re.sub(r" \(default: .*\)$", "", field.description)
    return f"give the {re.split(', which|[:;]', meaning)[0]} [{unit}]" if unit else f"give the {meaning}"


def is_table(annotation: Any) -> bool:
    """Return whether an annotation is a dict, or a dict or None."""
    if get_origin(annotation) in (Union, types.UnionType):
        return any(is_table(part) for part in get_args(annotation))
    return get_origin(annotation) is dict


def values(value: Any, place: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Yield all values of a document with their places; a list of numbers or texts is one value."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from values(part, (*place, name))
    elif isinstance(value, list) and all(isinstance(part, Mapping) for part in value):
        for i, part in enumerate(value):
            yield from values(part, (*place, i))
    else:
        yield place, value
