"""Check arguments of public functions against their annotations, so that a wrong type raises an `InputError`."""

from __future__ import annotations

import ast
import functools
import inspect
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from hypertuna.errors import PLAIN, InputError, did_you_mean, shown, with_article

if TYPE_CHECKING:
    import xarray as xr

LISTS = ("Sequence", "tuple", "Iterable", "list")  # annotations of collections
NAMED_KINDS = ("a Robot", "a Gait", "a MissionFile")  # types for which a name may be given
FIXES = {  # by type or argument: where its values come from
    "Robot": 'give a name such as "hypertuna", the path of a file, or what hypertuna.load returns',
    "Gaits": "make them by hypertuna.Gaits.grid_degrees, or give a list of gaits",
    "Executor": "give concurrent.futures.ProcessPoolExecutor(), for example, or a function that makes one",
    "Gait": "make one by hypertuna.Gait.from_degrees, or name one of the robot's gaits",
    "Trials": "give the path of a CSV file, or what hypertuna.read_trials returns",
    "Recording": "pass one of the recordings of the trials that hypertuna.read_trials returns",
    "JointSeries": "take joints of a recording, or read them by hypertuna.read_joints",
    "Track": "take one of tracks of a recording, or read them by hypertuna.read_tracks",
    "MissionFile": 'give a name such as "box", the path of a file, or what hypertuna.read_mission returns',
    "Limit": "make them by hypertuna.gait_limits",
    "robot": 'give a name such as "hypertuna", or the path of a file',
    "grid": "give what hypertuna.sweep returns",
    "Dataset": "give what hypertuna.sweep or hypertuna.replay returns",
    "Sea": "make one by hypertuna.Sea",
    "Swim": "give results such as hypertuna.swim returns",
    "Path": "give the path of a file",
    "Callable": "give hypertuna.progress_bar(), for example",
}

P = ParamSpec("P")
R = TypeVar("R")


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """Wrap a function so that the types of its arguments are checked at each call."""

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        checked_arguments(function, *args, **kwargs)
        return function(*args, **kwargs)

    return call


def checked_arguments(function: Callable[..., Any], *args: Any, **kwargs: Any) -> dict[str, Any]:
    """Check the types of a function's arguments; return all of them by name, including defaults."""
    name, kinds, signature = function.__qualname__, _kinds(inspect.unwrap(function)), inspect.signature(function)
    try:
        bound = signature.bind(*args, **kwargs)
    except TypeError as error:
        unknown = next((key for key in kwargs if key not in signature.parameters), None)
        fix = f"see help(hypertuna.{name})" if unknown is None else did_you_mean(unknown, signature.parameters)
        raise TypeError(f"{name}(): {error}: {fix}") from None
    for key, value in bound.arguments.items():
        kind = kinds.get(key)
        if kind is not None and not _fits(value, kind):
            fix = _fix_text(value, kind, key) or f"see help(hypertuna.{name})"
            raise InputError(f"must be {_words(kind)}", key=key, value=_value_text(value), fix=fix)
    bound.apply_defaults()
    return bound.arguments


def check_made_by(maker: str, data: xr.Dataset, key: str, names: Sequence[str]) -> None:
    """Check that a data set is a result of the public function `maker`, by the variables that it must have."""
    if missing := [name for name in names if name not in data.variables]:
        fix = f"give what hypertuna.{maker} returned"
        raise InputError(f"must be a result of {maker}", key=key, value=f"a Dataset without {missing[0]}", fix=fix)


def _value_text(value: Any) -> str:
    """Return a value and its type as text for an error."""
    text = f"{value}" if isinstance(value, bool) else shown(value)
    with_type = isinstance(value, PLAIN) and value is not None and not text.startswith("a ")
    return f"{text} ({type(value).__name__})" if with_type else text


def _fix_text(value: Any, kind: ast.expr, key: str) -> str | None:
    """Return advice for a value of the wrong type; kind: annotation of the argument `key`."""
    parts = _choices(kind)
    names = [_name(part) for part in parts]
    if isinstance(value, str) and {"float", "int", "Array", "ArrayLike"} & {*names} and _is_number_text(value):
        return f"write {value.strip()} without quotes"
    if "int" in names and isinstance(value, float) and value.is_integer():
        return f"write {int(value)}"
    if names == ["str"] and value is not None:
        return "write text in quotes"
    for part in parts:
        if isinstance(part, ast.Subscript) and _name(part.value) in LISTS and _fits(value, part.slice):
            return f"write [{shown(value)}]" if isinstance(value, PLAIN) else "put it in a list"
        if isinstance(part, ast.Subscript) and isinstance(part.slice, ast.Tuple) and _name(part.value) == "tuple":
            return f"write {key}=({', '.join('abc'[: len(part.slice.elts)])})"
    inner = [_name(each) for part in parts for each in ast.walk(part) if isinstance(each, ast.expr)]
    return next((FIXES[each] for each in [*(n for n in inner if n == "Robot"), key, *inner] if each in FIXES), None)


def _is_number_text(text: str) -> bool:
    """Return whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


@functools.cache
def _kinds(function: Callable[..., Any]) -> dict[str, ast.expr]:
    """Return the annotations of a function's parameters as syntax trees."""
    names = _Aliases(function.__globals__)
    parameters = inspect.signature(function).parameters.values()
    return {
        p.name: names.visit(_tree(p.annotation))
        for p in parameters
        if p.annotation is not p.empty and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    }


def _tree(annotation: Any) -> ast.expr:
    """Return an annotation as a syntax tree."""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return ast.parse(text, mode="eval").body


class _Aliases(ast.NodeTransformer):
    """Replaces aliases in annotations by the types that they stand for."""

    def __init__(self, names: Mapping[str, Any]) -> None:
        self.names = names

    def visit_Name(self, node: ast.Name) -> ast.expr:
        target = self.names.get(node.id)
        alias = target is not None and node.id not in SIMPLE and not isinstance(target, type)
        return _tree(target) if alias and not inspect.isroutine(target) else node


def _fits(value: Any, kind: ast.expr) -> bool:
    """Return whether a value fits an annotation."""
    match kind:
        case ast.BinOp(left=left, right=right):
            return _fits(value, left) or _fits(value, right)
        case ast.Constant(value=None):
            return value is None
        case ast.Subscript(value=outer, slice=inner):
            return _fits_inside(value, _name(outer), inner)
    test = SIMPLE.get(_name(kind))
    return test[1](value) if test else any(_name(kind) == base.__name__ for base in type(value).__mro__)


def _fits_inside(value: Any, outer: str, inner: ast.expr) -> bool:
    """Return whether a value fits the annotation `outer[inner]`, such as Sequence[float]."""
    parts = inner.elts if isinstance(inner, ast.Tuple) else [inner]
    if outer == "Mapping":
        return isinstance(value, Mapping) and all(
            _fits(key, parts[0]) and _fits(part, parts[1]) for key, part in value.items()
        )
    if outer in LISTS:
        if isinstance(value, str | bytes | Mapping) or not hasattr(value, "__iter__"):
            return False
        if outer == "Iterable" and not hasattr(value, "__len__"):
            return True  # an iterator can be read only once, so its values are not checked
        if outer == "tuple":
            items = list(value)
            return len(items) == len(parts) and all(map(_fits, items, parts))
        return hasattr(value, "__len__") and all(_fits(part, parts[0]) for part in value)
    return callable(value) if outer == "Callable" else isinstance(value, str) if outer == "Literal" else True


def _words(kind: ast.expr) -> str:
    """Return words for an annotation: "a number", "a Swim, a Fit or a list of them"."""
    words: list[str] = []
    for part in _choices(kind):
        word = _words_of_one(part)
        element = word.removeprefix("a list, each ")
        words.append("a list of them" if word != element and element == _joined(words) else word)
    if words[:1] and words[0] in NAMED_KINDS and "text" in words:
        words[words.index("text")] = "its name"
    elif len(words) > 2 and "text" in words and "a path" in words:
        words.remove("text")
    return _joined(words)


def _joined(words: list[str]) -> str:
    """Return alternatives joined: a, b or c."""
    return " or ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def _choices(kind: ast.expr) -> list[ast.expr]:
    """Return the alternatives of a union annotation, without None."""
    if isinstance(kind, ast.BinOp):
        return [*_choices(kind.left), *_choices(kind.right)]
    return [] if isinstance(kind, ast.Constant) else [kind]


def _words_of_one(kind: ast.expr) -> str:
    """Return words for an annotation that is no union."""
    if isinstance(kind, ast.Subscript):
        inner = kind.slice.elts if isinstance(kind.slice, ast.Tuple) else [kind.slice]
        outer = _name(kind.value)
        return {
            "tuple": f"{len(inner)} values, each {_words(inner[0])}",
            "Mapping": f"a dict, each value {_words(inner[-1])}",
            "Callable": "a function",
            "Literal": "one of its choices",
        }.get(
            outer,
            "a list of paths" if "Path" in map(_name, _choices(inner[0])) else f"a list, each {_words(inner[0])}",
        )
    name = _name(kind)
    return SIMPLE[name][0] if name in SIMPLE else with_article(name)


def _name(kind: ast.expr) -> str:
    """Return the name of a type without its module; "" for an annotation that is no name."""
    return kind.attr if isinstance(kind, ast.Attribute) else kind.id if isinstance(kind, ast.Name) else ""


def _is_number(value: Any) -> bool:
    """Return whether a value is a number of Python or NumPy, or an array without dimensions."""
    try:
        float(value)
    except (TypeError, ValueError, OverflowError):
        return False
    return not isinstance(value, str | bytes | bool)


def _is_whole(value: Any) -> bool:
    """Return whether a value is a whole number."""
    try:
        operator.index(value)
    except TypeError:
        return False
    return not isinstance(value, bool)


def _is_array(value: Any) -> bool:
    """Return whether a value is a number or a regular list of numbers."""
    import numpy as np

    try:
        np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        return False
    return not isinstance(value, str | bytes) and value is not None


def _is_bool(value: Any) -> bool:
    """Return whether a value is a bool of Python or NumPy."""
    return isinstance(value, bool) or type(value).__name__ == "bool"


SIMPLE: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "float": ("a number", _is_number),
    "int": ("a whole number", _is_whole),
    "bool": ("True or False", _is_bool),
    "str": ("text", lambda value: isinstance(value, str)),
    "Path": ("a path", lambda value: hasattr(value, "__fspath__")),
    "Any": ("anything", lambda value: True),
    "Array": ("numbers", _is_array),
    "ArrayLike": ("numbers", _is_array),
}
