"""What the package exports: one list, every name of it typed and documented in the same form."""

import ast
import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import hypertuna

FUNCTIONS = {
    name: getattr(hypertuna, name) for name in hypertuna.__all__ if inspect.isfunction(getattr(hypertuna, name))
}
METHODS = {
    f"{name}.{key}": member
    for name in hypertuna.__all__
    if inspect.isclass(cls := getattr(hypertuna, name))
    for key, member in vars(cls).items()
    if not key.startswith("_") and inspect.isroutine(inspect.unwrap(getattr(cls, key)))
    for member in [inspect.unwrap(getattr(cls, key))]
    if member.__module__.startswith("hypertuna")
}

# A value that has a unit is one of these types, and its description says the unit in brackets: "[rad]", "[1]" for none.
NUMBERS = re.compile(r"\b(float|ndarray|NDArray|ArrayLike|Array)\b")
UNIT = re.compile(r"\[[^\]]+\]")


def sections(docstring: str) -> dict[str, dict[str, str]]:
    """Entries of every section of a numpydoc docstring: name (or type) to the text below it."""
    lines = inspect.cleandoc(docstring).splitlines()
    found: dict[str, dict[str, str]] = {"": {}}
    entries, names = found[""], [""]
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if line and re.fullmatch(r"-{3,}", following):
            entries, names = found.setdefault(line, {}), []
        elif line and not line.startswith((" ", "---")):
            head, _, kind = line.partition(" : ")
            names = [name.lstrip("*") for name in head.split(", ")]
            entries.update(dict.fromkeys(names, kind))
        else:
            entries.update({name: f"{entries[name]} {line.strip()}" for name in names})
    return found


def test_the_list_is_the_whole_of_the_interface() -> None:
    source = ast.parse(Path(hypertuna.__file__).with_suffix(".pyi").read_text())
    imported = {
        alias.asname or alias.name for node in source.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    assert {name for name in imported if not name.startswith("_")} == {
        n for n in hypertuna.__all__ if not n.startswith("_")
    }
    assert len(set(hypertuna.__all__)) == len(hypertuna.__all__)


@pytest.mark.parametrize("name", hypertuna.__all__)
def test_every_name_is_documented(name: str) -> None:
    value = getattr(hypertuna, name)
    assert not callable(value) or inspect.getdoc(value), f"{name} has no docstring"


@pytest.mark.parametrize(("name", "function"), (FUNCTIONS | METHODS).items(), ids=(FUNCTIONS | METHODS).keys())
def test_every_function_is_typed_and_says_what_it_takes_and_gives(name: str, function: Callable[..., Any]) -> None:
    signature = inspect.signature(function)
    parameters = {key: p for key, p in signature.parameters.items() if key not in ("self", "cls")}
    untyped = [key for key, p in parameters.items() if p.annotation is p.empty]
    assert not untyped, f"{name}: no type for {untyped}"
    assert signature.return_annotation is not signature.empty, f"{name}: no return type"

    doc = sections(inspect.getdoc(function) or "")
    assert set(doc.get("Parameters", {})) == set(parameters), f"{name}: section Parameters does not match the signature"
    unitless = [
        key
        for key, p in parameters.items()
        if NUMBERS.search(str(p.annotation)) and not UNIT.search(doc["Parameters"][key])
    ]
    assert not unitless, f"{name}: no unit in brackets for {unitless}"
    if str(signature.return_annotation) not in ("None", "<class 'NoneType'>"):
        assert doc.get("Returns"), f"{name}: no section Returns"
        described = " ".join(f"{key} {text}" for key, text in doc["Returns"].items())
        number = NUMBERS.search(str(signature.return_annotation))
        assert not number or UNIT.search(described), f"{name}: no unit in brackets for what it returns"
