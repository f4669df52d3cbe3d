"""Source of a robot image: the robot's file as text, and where each number stands in that text."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, cast

from hypertuna.description.provenance import robot_path
from hypertuna.description.robot import Robot, parse
from hypertuna.description.writer import robot_text
from hypertuna.errors import InputError
from hypertuna.io.door import parse_toml, read_text

# A number in TOML, and a token: text, comment, number, bare key or sign.
NUMBER = r"[+-]?\d[\d_]*(?:\.[\d_]+)?(?:[eE][+-]?\d+)?(?![\w:.-])"
TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"""|\'\'\'.*?\'\'\'|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'|#[^\n]*'
    rf"|{NUMBER}|[\w-]+|[\[\]{{}}=,.\n]|.",
    re.DOTALL,
)


@dataclass(frozen=True)
class Source:
    """A robot's file as text, and the position of each key's number in it."""

    text: str
    places: dict[str, int]  # by key: index of the number's first character

    def holds(self, keys: Iterable[str]) -> bool:
        """Whether the text has a number for each key."""
        return all(key in self.places for key in keys)

    def at(self, key: str) -> int:
        """Return the position of a key's number in the text, counted in UTF-16 units as a browser does."""
        return len(self.text[: self.places[key]].encode("utf-16-le")) // 2


def source_of(robot: Robot) -> Source:
    """Return the text of a robot's file; without a file, or if the robot has been changed, write a new text."""
    try:
        text = read_text(robot_path(robot.file), "toml") if robot.file else ""
        unchanged = bool(text) and parse(parse_toml(text)).hash == robot.hash
    except (OSError, ValueError, InputError):
        unchanged = False
    if not unchanged:
        text = robot_text(robot)
    return Source(text, checked_places(text))


def checked_places(text: str) -> dict[str, int]:
    """Return the position of each key's number in a text, after a test that a number put there is read as its value."""
    places = dict(_places(text))
    parts, end = [], 0
    for number, start in enumerate(places.values()):
        parts += [text[end:start], str(number)]
        end = start + len(cast(re.Match[str], TOKEN.match(text, start))[0])
    try:
        values_read = dict(_numbers(parse_toml("".join([*parts, text[end:]]))))
    except InputError:  # the layout is not understood
        return {}
    return {key: start for number, (key, start) in enumerate(places.items()) if values_read.get(key) == number}


def _numbers(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the numbers of a document by key."""
    if isinstance(value, dict):
        for name, part in value.items():
            yield from _numbers(part, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for i, part in enumerate(value):
            yield from _numbers(part, f"{key}[{i}]")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield key, value


def _places(text: str) -> Iterator[tuple[str, int]]:
    """Yield key and position of each number in a text of tables, keys and lists; inline tables are not understood."""
    table, path = "", ""
    counts: dict[str, int] = {}  # index of the current table in each list of tables
    index: list[int] = []  # position of the current element in each list that encloses it
    tokens = [token for token in TOKEN.finditer(text) if token[0].strip(" \t\r") and token[0][0] != "#"]
    k = 0
    while k < len(tokens):
        word, first = tokens[k][0], k == 0 or tokens[k - 1][0] == "\n"
        if word == "\n":
            k += 1
        elif first and not index and word == "[":
            end = next((i for i in range(k, len(tokens)) if tokens[i][0] == "\n"), len(tokens))
            names = "".join(token[0] for token in tokens[k:end])
            table = names.strip("[]").replace('"', "")
            if names.startswith("[["):
                counts[table] = counts.get(table, -1) + 1
            table = ".".join(_indexed(table.split("."), counts))
            path, k = "", end
        elif first and not index:
            end = next((i for i in range(k, len(tokens)) if tokens[i][0] == "="), len(tokens))
            name = "".join(token[0] for token in tokens[k:end]).replace('"', "")
            path, k = f"{table}.{name}" if table else name, end + 1
        else:
            if word == "[":
                index.append(0)
            elif word == "]" and index:
                index.pop()
            elif word == "," and index:
                index[-1] += 1
            elif re.fullmatch(NUMBER, word):
                yield path + "".join(f"[{i}]" for i in index), tokens[k].start()
            k += 1


def _indexed(names: list[str], counts: dict[str, int]) -> Iterator[str]:
    """Yield the parts of a table's name, with an index after each that names a list of tables."""
    for n, name in enumerate(names, 1):
        full_name = ".".join(names[:n])
        yield f"{name}[{counts[full_name]}]" if full_name in counts else name
