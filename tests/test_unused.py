"""No module of the package holds a function, class or constant that nothing uses."""

import ast
import re
import subprocess
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Names that one import statement takes from a module of the package.
IMPORT = re.compile(r"^\s*from (hypertuna[\w.]*) import (?:\(([^)]*)\)|(.*))$", re.MULTILINE)


def tracked(*folders: str) -> dict[str, str]:
    """Return the texts of the Python files below some folders, by name."""
    listed = subprocess.run(["git", "ls-files", *folders], cwd=ROOT, capture_output=True, text=True, check=True)
    names = [name for name in listed.stdout.split() if name.endswith((".py", ".pyi"))]
    return {name: (ROOT / name).read_text(encoding="utf-8") for name in names}


def module_of(name: str) -> str:
    """Return the module that a file of the package is."""
    return re.sub(r"/__init__|\.pyi?$", "", name.removeprefix("src/")).replace("/", ".")


def defined(tree: ast.Module) -> dict[str, ast.stmt]:
    """Return the statements that define names of a module, without commands and what a decorator may register."""
    found: dict[str, ast.stmt] = {}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.decorator_list:
            found[node.name] = node
        elif isinstance(node, ast.Assign):
            found |= {target.id: node for target in node.targets if isinstance(target, ast.Name)}
    return {name: node for name, node in found.items() if not name.endswith("_command") and name[:2] != "__"}


def unused(package: dict[str, str], others: dict[str, str]) -> list[str]:
    """Return the names that no file imports and that their modules load in no other statement."""
    imported, taken = defaultdict(set), set()
    for text in (*package.values(), *others.values()):
        taken |= set(re.findall(r"[.:](\w+)", text))  # attributes, of modules too, and functions that a text names
        for module, lines, line in IMPORT.findall(text):
            imported[module] |= set(re.findall(r"\w+", lines or line))
    names = []
    for name, text in package.items():
        module, tree = module_of(name), ast.parse(text)
        loaded = defaultdict(set)
        for statement in tree.body:
            for node in ast.walk(statement):
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                    loaded[node.id].add(statement)
        for one, statement in defined(tree).items():
            if not (one in taken | imported[module] or loaded[one] - {statement}):
                names.append(f"{module}.{one}")
    return names


def test_every_name_of_a_module_is_used() -> None:
    package = {name: text for name, text in tracked("src").items() if not name.endswith("_core.pyi")}
    assert unused(package, tracked("tests", "validation", "docs", "examples", "benchmarks")) == []


def test_what_nothing_uses_is_found() -> None:
    package = {"src/hypertuna/a.py": "USED = 1\nHOUR = 3600\ndef f(): return f() + USED\ndef g(): return 1\n"}
    assert unused(package, {"tests/test_a.py": "from hypertuna.a import (\n    g,\n)\n"}) == [
        "hypertuna.a.HOUR",
        "hypertuna.a.f",
    ]
