"""Write a changed robot into the text of its file, with comments and layout kept."""

import contextlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hypertuna.description.provenance import robot_path
from hypertuna.description.robot import Robot, parse
from hypertuna.io.door import parse_toml, read_text
from hypertuna.io.files import write_atomically

SAME = 1e-13  # relative tolerance of the same number in another notation


def robot_text(robot: Robot, *, note: str | None = None) -> str:
    """Return a robot as TOML: the text of its file with changed values replaced, else a new text.

    Comments and layout are kept; `note`, the origin of the new values, replaces comments beside them.
    """
    import tomlkit  # slow to import

    with contextlib.suppress(Exception):  # no file, or a layout that tomlkit cannot change
        document = tomlkit.parse(read_text(robot_path(robot.file), "toml"))
        _merge(document, robot.document(), note=note or ("identified, see [fit]" if robot.fit else "changed"))
        if parse(parse_toml(tomlkit.dumps(document))).hash == robot.hash:  # else it was read from something else
            return _ended(tomlkit.dumps(document))
    return _ended(tomlkit.dumps(_merge(tomlkit.document(), robot.document())))


def _ended(text: str) -> str:
    """Return a text with a newline at its end."""
    return text if text.endswith("\n") else f"{text}\n"


def write_robot(robot: Robot, path: str | Path, *, note: str | None = None) -> Path:
    """Write a robot file, whole or not at all; `note` as for `robot_text`."""
    return write_atomically(path, robot_text(robot, note=note).encode())


def _merge(table: Any, target: Mapping[str, Any], note: str = "") -> Any:
    """Change a table of a document to equal its target; values that are equal stay as written."""
    for key in [key for key in table if key not in target]:
        del table[key]
    changed = []
    for key, value in target.items():
        if key not in table:
            table[key] = _new(value)
        elif not _same(table[key], value):
            if isinstance(value, Mapping):
                try:
                    _merge(table[key], value, "" if key in ("fit", "uncertainty", "sources") else note)
                except Exception:  # tomlkit raises anything where it cannot change an inline or dotted table
                    del table[key]
                    table[key] = _new(value)
                continue
            if isinstance(value, list) and isinstance(table[key], list) and len(value) == len(table[key]):
                _merge_list(table[key], value, note)
            else:
                table[key] = value
            changed += [key] * (not _has_tables(value))
    if note:
        _remark(table, changed, note)
    return table


def _has_tables(value: Any) -> bool:
    """Whether a value is a list of tables, each with its own comments."""
    return isinstance(value, list) and any(isinstance(part, Mapping) for part in value)


def _remark(table: Any, changed: Sequence[str], note: str) -> None:
    """Add a note on changes to the comments of changed values and of their table's header."""
    for key in changed:
        trivia = getattr(table.item(key), "trivia", None) if hasattr(table, "item") else None
        if trivia is not None and trivia.comment:
            trivia.comment = f"# {note}"
    trivia = getattr(table, "trivia", None)
    if changed and trivia is not None and trivia.comment:
        trivia.comment += f"; {', '.join(changed)} {note}"


def _new(value: Any) -> Any:
    """Return a new value laid out for the document: tables by key, matrices by row."""
    import tomlkit

    if isinstance(value, Mapping):
        table = tomlkit.table()
        for key, part in value.items():
            table[key] = _new(part)
        return table
    if isinstance(value, list) and value and isinstance(value[0], list):
        rows = tomlkit.array()
        for row in value:
            rows.append(row)
        return rows.multiline(True)
    return value


def _merge_list(items: Any, target: list[Any], note: str) -> None:
    """Change the items of a list to those of a target of equal length."""
    for i, value in enumerate(target):
        if not _same(items[i], value):
            if isinstance(value, Mapping):
                _merge(items[i], value, note)
            else:
                items[i] = value


def _same(there: Any, value: Any) -> bool:
    """Whether two values of documents are equal."""
    if isinstance(value, Mapping):
        return isinstance(there, Mapping) and set(there) == set(value) and all(_same(there[k], value[k]) for k in value)
    if isinstance(value, list):
        return isinstance(there, list) and len(there) == len(value) and all(map(_same, there, value))
    if isinstance(value, float) and isinstance(there, (int, float)) and not isinstance(there, bool):
        return math.isclose(there, value, rel_tol=SAME, abs_tol=0.0)
    return (type(value) is bool and there is value) or (type(value) is not bool and there == value)
