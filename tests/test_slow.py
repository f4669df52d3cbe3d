"""The list of slow tests names tests that exist, once each, and not too many of them."""

import ast
import re
from pathlib import Path

from extras import slow

ROOT = Path(__file__).resolve().parents[1]


def functions(file: str) -> set[str]:
    """Return the names of all functions in a file."""
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def test_each_name_is_that_of_a_test() -> None:
    names = slow()
    assert names == sorted(set(names))
    for name in names:
        file, _, test = name.partition("::")
        assert re.match(r"test_\w+", test), name
        assert test.partition("[")[0] in functions(file), name
    assert len(names) < 240
