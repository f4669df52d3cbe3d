"""Mutants of a module: single changes of its code that its tests should notice."""

import ast
import copy
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

SWAPPED: dict[type[ast.AST], type[ast.AST]] = {  # operators, and what a mutant has instead
    **{ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq},
    **{ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And},
    **{ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Div},
    **{ast.Pow: ast.Mult, ast.Mod: ast.Mult},
}
LEFT = (ast.AnnAssign, ast.arg, ast.FunctionDef, ast.AsyncFunctionDef)  # whose annotations change nothing
Tree = TypeVar("Tree", bound=ast.AST)
Place = tuple[tuple[str, int], ...]  # fields and indices from the module to a node


@dataclass(frozen=True)
class Mutant:
    """One change of one module."""

    module: str  # path from the repository's root
    function: str  # qualified name
    place: Place
    before: str  # the statement's line, and what stands in its place
    after: str
    lines: tuple[int, int] | None  # first and last line of which one must be executed; None: it is executed at import

    @property
    def name(self) -> str:
        """Return the mutant's name in the list of equivalent ones, which has no line number."""
        return f"{self.module}: {self.function}: {self.before} -> {self.after}"


def mutants(root: Path, module: str) -> Iterator[Mutant]:
    """Yield all mutants of a module."""
    tree = ast.parse((root / module).read_text(encoding="utf-8"))
    for place, function in _places(tree, (), ""):
        size = 1 + max(k for k, _ in enumerate(place) if isinstance(_at(tree, place[: k + 1]), ast.stmt))
        statement = _at(tree, place[:size])
        changed = mutated(statement, place[size:])
        lines = zip(*(ast.unparse(one).split("\n") for one in (statement, changed)), strict=True)
        before, after = next((old, new) for old, new in lines if old != new)
        yield Mutant(module, function, place, before.strip(), after.strip(), _lines(tree, place))


def drawn(root: Path, modules: list[str], seed: int) -> list[Mutant]:
    """Return all mutants of modules in the seed's order, which hardly changes when other code does."""
    found = [one for module in modules for one in mutants(root, module)]
    return sorted(found, key=lambda one: hashlib.sha256(f"{seed} {one.name} {one.place}".encode()).hexdigest())


def mutated(tree: Tree, place: Place) -> Tree:
    """Return a tree with the node at a place changed."""
    tree = copy.deepcopy(tree)
    parent, (field, index) = _at(tree, place[:-1]), place[-1]
    nodes = getattr(parent, field)
    new = _changed(nodes if index < 0 else nodes[index])
    assert new is not None
    if index < 0:
        setattr(parent, field, new)
    else:
        nodes[index] = new
    ast.fix_missing_locations(tree)
    return tree


def _lines(tree: ast.Module, place: Place) -> tuple[int, int] | None:
    """Return the lines of the statement around a place, without the block below it; of the body for a default."""
    nodes = [_at(tree, place[: size + 1]) for size in range(len(place))]
    if not any(isinstance(node, ast.FunctionDef) for node in nodes):
        return None
    *_, node = (node for node in nodes if isinstance(node, ast.stmt))
    if isinstance(node, ast.FunctionDef):
        return node.body[0].lineno, node.body[-1].end_lineno or 0
    if isinstance(node, ast.If | ast.For | ast.While | ast.With):
        return node.lineno, max(node.lineno, node.body[0].lineno - 1)
    return node.lineno, node.end_lineno or 0


def _changed(node: ast.AST) -> ast.AST | None:
    """Return the node that replaces a node, None where it stays."""
    if type(node) in SWAPPED:
        return SWAPPED[type(node)]()
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        return node.operand
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        return ast.copy_location(ast.Constant(not node.value), node)
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return ast.copy_location(
            ast.Constant(node.value + 1 if isinstance(node.value, int) else _off(node.value)), node
        )
    return None


def _off(value: float) -> float:
    """Return a number that differs from a value."""
    return 1.25 * value if value else 1.0


def _places(node: ast.AST, place: Place, function: str) -> Iterator[tuple[Place, str]]:
    """Yield places of nodes that can be changed, with their function's name; no annotations and no messages."""
    for field, value in ast.iter_fields(node):
        if isinstance(node, LEFT) and field in ("annotation", "returns"):
            continue
        for index, child in enumerate(value) if isinstance(value, list) else [(-1, value)]:
            if not isinstance(child, ast.AST) or isinstance(child, ast.JoinedStr | ast.Raise):
                continue
            if isinstance(child, ast.keyword) and child.arg == "strict":  # zip's own check of the code around it
                continue
            named = getattr(child, "name", None) if isinstance(child, (ast.ClassDef, *LEFT[2:])) else None
            inside = ".".join(filter(None, (function, named)))
            here = (*place, (field, index))
            if _changed(child) is not None:
                yield here, inside
            yield from _places(child, here, inside)


def _at(tree: ast.AST, place: Place) -> ast.AST:
    """Return the node at a place."""
    for field, index in place:
        value = getattr(tree, field)
        tree = value if index < 0 else value[index]
    return tree
