"""A document as TOML text, in which each key has its meaning from the schema as a comment."""

import json
import re
import textwrap
from collections.abc import Mapping
from typing import Any

from hypertuna.description.validation import Place, field_at, is_table, written

WIDTH = 120  # columns; a comment that would end beyond is put above its value

# Comments above the header of a table, by its name.
HINTS = {
    "links": "Measure each link: a ruler for lengths, a scale for masses, the point of balance for com_m, a side view\n"
    "on squared paper for lateral_area_m2.",
    "joints": "Joint i sits at the front end of link i; a joint group has one drive and one or more joints.",
    "water.strip": "One value per link. Towed straight, the head's blunt_area_m2 drags most: fit it to your trials by\n"
    "`hypertuna identify RUNS.csv --robot FILE --free 'water.blunt_area_m2[0]'`.",
    "gaits.cruise": "One value per joint group, head to tail.",
    "uncertainty": "The true value of an estimate lies within this factor in 90 % of cases; `hypertuna swim` prints\n"
    "the speeds that they leave. Remove the line of a value that you measure.",
    "sources": 'Where each value is from, by the start of its key; a source that begins with "estimate" marks an '
    "estimate.",
}


def commented(document: Mapping[str, Any], model: type[Any], *, hints: Mapping[str, str] = HINTS) -> str:
    """Return a document as TOML text, with the meaning of its keys from the model as comments."""
    return "\n".join(_table(document, model, (), hints)).strip() + "\n"


def _table(table: Mapping[str, Any], model: type[Any], place: Place, hints: Mapping[str, str]) -> list[str]:
    """Return the lines of a table: its values, then its subtables."""
    lines = [_line(key, value, model, (*place, key)) for key, value in table.items() if not _has_tables(value)]
    for key, value in table.items():
        if not _has_tables(value):
            continue
        inner_place = (*place, key)
        name = written(tuple(part for part in inner_place if isinstance(part, str)))
        hint = [f"# {line}" for line in hints.get(name, "").splitlines()]
        is_list = isinstance(value, list)
        for i, part in enumerate(value if is_list else [value]):
            header = [f"[[{name}]]" if is_list else f"[{name}]"]
            only_tables = all(_has_tables(below) for below in part.values())
            if is_list or not only_tables:
                lines += ["", *(hint if i == 0 else ()), *header]
            lines += _table(part, model, (*inner_place, i) if is_list else inner_place, hints)
    return lines


def _line(key: str, value: Any, model: type[Any], place: Place) -> str:
    """Return the line of a key and its value, with a comment on its meaning, except in later tables of a list."""
    name = key if re.fullmatch(r"[\w-]+", key) else json.dumps(key, ensure_ascii=False)
    text = f"{name} = {literal(value)}"
    if len(text) > WIDTH and isinstance(value, str):
        text = f'{name} = """{_wrapped(value)}"""'
    _, field = field_at(model, place)
    if field is None or not field.description or any(part for part in place if isinstance(part, int)):
        return text
    if is_table(field.annotation):  # a table of named entries
        return text
    beside = f"{text}  # {field.description}"
    return beside if len(beside) <= WIDTH else f"# {field.description}\n{text}"


def _has_tables(value: Any) -> bool:
    """Return whether a value is a table or a list of tables."""
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and isinstance(value[0], Mapping))


def _wrapped(text: str) -> str:
    """Return a text broken into lines that TOML joins again."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return "\\\n" + " \\\n".join(textwrap.wrap(escaped, WIDTH - 4))


def literal(value: Any) -> str:
    """Return a value in the notation of TOML."""
    if isinstance(value, list):
        return f"[{', '.join(map(literal, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.12g}" if re.search(r"[.e]", f"{value:.12g}") else f"{value:.1f}"
    return json.dumps(value, ensure_ascii=False)
