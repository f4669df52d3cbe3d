"""Write a changed robot into the text of its file; comments and layout are kept."""

import contextlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hypertuna.description.provenance import robot_path
from hypertuna.description.robot import Robot, parse
from hypertuna.io.door import parse_toml, read_text
from hypertuna.io.files import write_atomically

SAME = 1e-13  # relative tolerance within which numbers are equal and keep their notation


def robot_text(robot: Robot, *, note: str | None = None) -> str:
    """Return a robot as TOML: the text of its file with changed values replaced, or a new text if there is no file.

    Comments and layout are kept; `note`, the origin of the new values, replaces the comments beside them.
    """
    import tomlkit  # slow to import

    with contextlib.suppress(Exception):  # no file, or a layout that tomlkit cannot change
        document = tomlkit.parse(read_text(robot_path(robot.file), "toml"))
        _merge(document, robot.document(), note=note or ("identified, see [fit]" if robot.fit else "changed"))
        if parse(parse_toml(tomlkit.dumps(document))).hash == robot.hash:  # else the robot is from another text
            return _ended(tomlkit.dumps(document))
    return _ended(tomlkit.dumps(_merge(tomlkit.document(), robot.document())))


def _ended(text: str) -> str:
    """Return a text with a newline at its end."""
    return text if text.endswith("\n") else f"{text}\n"


def write_robot(robot: Robot, path: str | Path, *, note: str | None = None) -> Path:
    """Write a robot file, whole or not at all; `note` as for `robot_text`."""
    return write_atomically(path, robot_text(robot, note=note).encode())


def _merge(table: Any, target: Mapping[str, Any], note: str = "") -> Any:
    """Change a table of a document to equal its target; values that are already equal keep their notation."""
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
    """Return whether a value is a list of tables, each with its own comments."""
    return isinstance(value, list) and any(isinstance(part, Mapping) for part in value)


def _remark(table: Any, changed: Sequence[str], note: str) -> None:
    """Put a note into the comments of changed values, and add it to the comment of their table's header."""
    for key in changed:
        trivia = getattr(table.item(key), "trivia", None) if hasattr(table, "item") else None
        if trivia is not None and trivia.comment:
            trivia.comment = f"# {note}"
    trivia = getattr(table, "trivia", None)
    if changed and trivia is not None and trivia.comment:
        trivia.comment += f"; {', '.join(changed)} {note}"


def _new(value: Any) -> Any:
    """Return a new value as tomlkit's objects: a mapping as a table, a matrix with a line for each row."""
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
    """Change the items of a list to equal those of a target of the same length."""
    for i, value in enumerate(target):
        if not _same(items[i], value):
            if isinstance(value, Mapping):
                _merge(items[i], value, note)
            else:
                items[i] = value


def _same(old: Any, value: Any) -> bool:
    """Return whether two values of documents are equal; numbers may differ by rounding."""
    if isinstance(value, Mapping):
        return isinstance(old, Mapping) and set(old) == set(value) and all(_same(old[k], value[k]) for k in value)
    if isinstance(value, list):
        return isinstance(old, list) and len(old) == len(value) and all(map(_same, old, value))
    if isinstance(value, float) and isinstance(old, (int, float)) and not isinstance(old, bool):
        return math.isclose(old, value, rel_tol=SAME, abs_tol=0.0)
    return (type(value) is bool and old is value) or (type(value) is not bool and old == value)
