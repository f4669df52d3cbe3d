"""Arguments of public functions: each is checked against its annotation, so that a wrong type is an `InputError`."""

import ast
import functools
import inspect
import operator
from collections.abc import Callable, Mapping
from typing import Any, ParamSpec, TypeVar

from hypertuna.errors import InputError, shown

P = ParamSpec("P")
R = TypeVar("R")


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """Check the types of the arguments that a function is called with."""

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        kinds = _kinds(function)
        for key, value in inspect.signature(function).bind(*args, **kwargs).arguments.items():
            kind = kinds.get(key)
            if kind is not None and not _fits(value, kind):
                given = f"{shown(value)} ({type(value).__name__})".replace("\n", " ")
                fix = f"see help(hypertuna.{function.__qualname__})"
                raise InputError(f"must be {_words(kind)}", key=key, value=given, fix=fix)
        return function(*args, **kwargs)

    return call


@functools.cache
def _kinds(function: Callable[..., Any]) -> dict[str, ast.expr]:
    """Return the annotations of the parameters as syntax trees."""
    names = _Aliases(function.__globals__)
    parameters = inspect.signature(function).parameters.values()
    return {
        one.name: names.visit(_tree(one.annotation))
        for one in parameters
        if one.annotation is not one.empty and one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)
    }


def _tree(annotation: Any) -> ast.expr:
    """Return an annotation as a syntax tree."""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return ast.parse(text, mode="eval").body


class _Aliases(ast.NodeTransformer):
    """Write names of types as what they stand for."""

    def __init__(self, names: Mapping[str, Any]) -> None:
        self.names = names

    def visit_Name(self, node: ast.Name) -> ast.expr:
        known = self.names.get(node.id)
        alias = known is not None and node.id not in SIMPLE and not isinstance(known, type)
        return _tree(known) if alias and not inspect.isroutine(known) else node


def _fits(value: Any, kind: ast.expr) -> bool:
    """Whether a value is of a kind."""
    match kind:
        case ast.BinOp(left=left, right=right):
            return _fits(value, left) or _fits(value, right)
        case ast.Constant(value=None):
            return value is None
        case ast.Subscript(value=outer, slice=inner):
            return _fits_inside(value, _name(outer), inner)
    test = SIMPLE.get(_name(kind))
    return test[1](value) if test else any(_name(kind) == one.__name__ for one in type(value).__mro__)


def _fits_inside(value: Any, outer: str, inner: ast.expr) -> bool:
    """Whether a value is a collection of values of a kind."""
    parts = inner.elts if isinstance(inner, ast.Tuple) else [inner]
    if outer == "Mapping":
        return isinstance(value, Mapping) and all(
            _fits(key, parts[0]) and _fits(part, parts[1]) for key, part in value.items()
        )
    if outer in ("Sequence", "tuple", "Iterable", "list"):
        if isinstance(value, str | bytes | Mapping) or not hasattr(value, "__iter__"):
            return False
        if outer == "Iterable" and not hasattr(value, "__len__"):
            return True  # it can be gone through only once
        if outer == "tuple":
            pairs = list(value)
            return len(pairs) == len(parts) and all(map(_fits, pairs, parts))
        return hasattr(value, "__len__") and all(_fits(part, parts[0]) for part in value)
    return callable(value) if outer == "Callable" else isinstance(value, str) if outer == "Literal" else True


def _words(kind: ast.expr) -> str:
    """Return the words for a kind: "a number", "a Swim, a Fit or a list of them"."""
    words: list[str] = []
    for part in _parts(kind):
        word = _word(part)
        listed = word.removeprefix("a list, each ")
        words.append("a list of them" if word != listed and listed == _joined(words) else word)
    return _joined(words)


def _joined(words: list[str]) -> str:
    """Join alternatives."""
    return " or ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def _parts(kind: ast.expr) -> list[ast.expr]:
    """Return the alternatives of a kind but None."""
    if isinstance(kind, ast.BinOp):
        return [*_parts(kind.left), *_parts(kind.right)]
    return [] if isinstance(kind, ast.Constant) else [kind]


def _word(kind: ast.expr) -> str:
    """Return the words for a kind without alternatives."""
    if isinstance(kind, ast.Subscript):
        inner = kind.slice.elts if isinstance(kind.slice, ast.Tuple) else [kind.slice]
        outer = _name(kind.value)
        return {
            "tuple": f"{len(inner)} values, each {_words(inner[0])}",
            "Mapping": f"a dict, each value {_words(inner[-1])}",
            "Callable": "a function",
            "Literal": "one of its choices",
        }.get(outer, f"a list, each {_words(inner[0])}")
    name = _name(kind)
    return SIMPLE[name][0] if name in SIMPLE else f"{'an' if name[:1] in 'AEIO' else 'a'} {name}"


def _name(kind: ast.expr) -> str:
    """Return the last part of a name."""
    return kind.attr if isinstance(kind, ast.Attribute) else kind.id if isinstance(kind, ast.Name) else ""


def _number(value: Any) -> bool:
    """Whether a value is a number: of Python, NumPy, or an array without dimensions."""
    try:
        float(value)
    except (TypeError, ValueError, OverflowError):
        return False
    return not isinstance(value, str | bytes | bool)


def _whole(value: Any) -> bool:
    """Whether a value is a whole number."""
    try:
        operator.index(value)
    except TypeError:
        return False
    return not isinstance(value, bool)


def _array(value: Any) -> bool:
    """Whether a value is a number, or a regular list of numbers."""
    import numpy as np

    try:
        np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        return False
    return not isinstance(value, str | bytes) and value is not None


def _true_or_false(value: Any) -> bool:
    """Whether a value is a bool of Python or NumPy."""
    return isinstance(value, bool) or type(value).__name__ == "bool"


SIMPLE: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "float": ("a number", _number),
    "int": ("a whole number", _whole),
    "bool": ("True or False", _true_or_false),
    "str": ("text", lambda value: isinstance(value, str)),
    "Path": ("a path", lambda value: hasattr(value, "__fspath__")),
    "Any": ("anything", lambda value: True),
    "Array": ("numbers", _array),
    "ArrayLike": ("numbers", _array),
}
