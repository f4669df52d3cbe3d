"""The sources stay small enough to read: modules, functions, docstrings; names of programs do not collide."""

import ast
import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "hypertuna"
MODULES = sorted(PACKAGE.rglob("*.py"))
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef)


def docstring_lines(node: ast.Module | ast.ClassDef | ast.FunctionDef) -> int:
    """Lines of the docstring of one module, class or function."""
    first = node.body[0] if ast.get_docstring(node, clean=False) is not None else None
    return first.end_lineno - first.lineno + 1 if first and first.end_lineno else 0


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_has_400_lines_and_a_function_body_60(module: Path) -> None:
    text = module.read_text()
    assert len(text.splitlines()) <= 400
    functions = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]
    bodies = {f.name: (f.end_lineno or 0) - f.body[0].lineno + 1 - docstring_lines(f) for f in functions}
    assert {name: lines for name, lines in bodies.items() if lines > 60} == {}


def test_docstrings_are_less_than_15_percent_of_the_package() -> None:
    trees = [ast.parse(module.read_text()) for module in MODULES]
    lines = sum(docstring_lines(node) for tree in trees for node in ast.walk(tree) if isinstance(node, DOCUMENTED))
    assert lines < 0.15 * sum(len(module.read_text().splitlines()) for module in MODULES)


def test_every_ignored_type_error_names_its_code_and_reason() -> None:
    ignored = [line for module in MODULES for line in module.read_text().splitlines() if "type: ignore" in line]
    assert [line for line in ignored if not re.search(r"# type: ignore\[[\w-]+\]  # \w", line)] == []


def test_programs_of_one_name_are_imported_in_one_folder_alone() -> None:
    """Tests run in one process, where a name is one module."""
    programs = sorted((PACKAGE.parents[1] / "validation").glob("*/*.py"))
    names = {path.stem for path in programs}
    where: dict[str, set[str]] = {}
    for path in programs:
        for name in re.findall(r"^(?:from|import) (\w+)", path.read_text(), re.MULTILINE):
            where.setdefault(name, set()).add(path.parent.name)
    twice = {name for name in names if sum(path.stem == name for path in programs) > 1}
    assert {name: folders for name, folders in where.items() if name in twice and len(folders) > 1} == {}
