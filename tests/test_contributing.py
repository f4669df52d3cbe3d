"""CONTRIBUTING.md names every folder, room and header, and rooms in the order of the linter's contract."""

import ast
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "CONTRIBUTING.md").read_text()


def rows(head: str) -> list[tuple[str, str]]:
    """Cells of the table of two columns whose first heading is given."""
    _, table = PAGE.split(f"| {head} |", 1)
    lines = table.split("\n\n", 1)[0].splitlines()[2:]
    return [(name.strip(), text.strip()) for _, name, text, _ in (line.split("|") for line in lines)]


def names(head: str) -> list[str]:
    """Names between backticks in the first column of a table."""
    return [name for first, _ in rows(head) for name in re.findall(r"`([^`]+)`", first)]


def headers() -> list[tuple[str, str]]:
    """Rooms and headers of the core in reading order, without the notes in parentheses."""
    cells = [(room.strip("`"), re.sub(r"\([^)]*\)", "", text)) for room, text in rows("room of the core")]
    return [(room, header.strip()) for room, text in cells for header in text.split(",")]


def tracked(*paths: str) -> list[str]:
    """Tracked files of some paths."""
    listed = subprocess.run(["git", "ls-files", *paths], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode != 0:
        pytest.skip("needs the repository")
    return listed.stdout.splitlines()


def test_every_folder_is_listed() -> None:
    folders = {f"{path.split('/')[0]}/" for path in tracked() if "/" in path} - {".ci/"}  # named beside .github
    assert folders == {f"{name.split('/')[0]}/" for name in names("folder")}
    assert [name for name in names("folder") if not tracked(name)] == []


EACH_ITS_OWN = ("cli", "chapters", "templates")  # the docstring says that each file is a command or a chapter


def test_every_module_is_listed_by_its_room() -> None:
    missing = []
    for path in map(Path, tracked("src/hypertuna/*.py")):
        room = ROOT / path.parent / "__init__.py"
        if path.parent.name not in ("hypertuna", *EACH_ITS_OWN) and not path.stem.startswith("_"):
            listed = re.findall(r"\w+", ast.get_docstring(ast.parse(room.read_text())) or "")
            missing += [str(path)] if path.stem not in listed else []
    assert missing == []


def test_every_header_of_the_core_is_listed_once() -> None:
    paths = [Path(path) for path in tracked("core/include/hypertuna")]
    found = sorted((path.parent.name, path.stem) for path in paths)
    assert sorted(headers()) == found


def test_headers_stand_above_those_that_include_them() -> None:
    order = [f"hypertuna/{room}/{header}.hpp" for room, header in headers()]
    late = {}
    for place, header in enumerate(order):
        text = (ROOT / "core/include" / header).read_text()
        late[header] = [name for name in re.findall(r'#include "([^"]+)"', text) if order.index(name) >= place]
    assert {header: those for header, those in late.items() if those} == {}


def test_every_room_is_listed_in_the_order_of_the_contract() -> None:
    files = {path.split("/")[2] for path in tracked("src/hypertuna")}
    rooms = {name for name in files if not re.search(r"^_|\.(pyi|typed)$", name)}
    listed = names("room")
    assert sorted(name.strip("/") for name in listed) == sorted(rooms)
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]["layers"]
    level = {name.strip("() "): k for k, layer in enumerate(contract[::-1]) for name in layer.split("|")}
    levels = [level[name.strip("/").removesuffix(".py")] for name in listed]
    assert levels == sorted(levels)
