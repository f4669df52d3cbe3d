"""Numbers of a robot's file, and sizes of the caudal fin, as variables of a design.

A variable has the unit of the file. Values that scale with a link's length or mass (`following`) change with it, as in
the studio, and so do the sums of the body. ``fin.span``, ``fin.chord``, ``fin.area`` and ``fin.aspect_ratio`` are
factors on the described caudal fin.
"""

from __future__ import annotations

import copy
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hypertuna.description.changes import NAMES
from hypertuna.description.fin import shape_fin
from hypertuna.description.following import scale
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.base import Key, Part
from hypertuna.description.validation import Place, written
from hypertuna.errors import InputError, did_you_mean, shown

# Variables of the fin, each with its powers in the factors on span and chord.
FIN = {"span": (1.0, 0.0), "chord": (0.0, 1.0), "area": (0.5, 0.5), "aspect_ratio": (0.5, -0.5)}
WHOLE_FIN = "factor"  # unit of the fin's variables, which are factors on the described fin
FOLLOWED = {"links.length": "length", "links.mass": "mass"}  # variables with which other values scale
TEXTS = ("description", "sources", "uncertainty", "fit")  # tables without numbers to vary


@dataclass(frozen=True)
class Variable:
    """A number of a robot's file that a search or a sweep varies."""

    name: str  # key with its unit, joint groups by name: ``hinge.stiffness_n_m_per_rad``; or ``fin.span``
    label: str  # the name without the unit
    unit: str  # unit of the file
    value: float  # described value
    low: float  # lower end of the range
    high: float  # upper end of the range
    place: Place  # place in the document; empty for the fin

    @property
    def attributes(self) -> dict[str, str]:
        """Unit and meaning, as attributes of data sets."""
        return {"units": "1" if self.unit in ("", WHOLE_FIN) else self.unit, "long_name": f"{self.name} of the robot"}


@dataclass(frozen=True)
class _Leaf:
    """A value of a robot's file, with its key, its place and its declaration in the schema."""

    name: str  # key with units
    label: str  # key without units
    place: Place
    value: Any
    about: Key | None  # declaration in the schema


def variable(robot: Robot, name: str, low: float, high: float) -> Variable:
    """Return the number of a robot that a key names as a variable between two values [unit of the file]."""
    if name.startswith("fin."):
        return _checked(robot, _fin_variable(robot, name, low, high))
    leaves = list(_leaves(robot, robot.model_dump(mode="json", by_alias=True, exclude_none=True), "", "", ()))
    by_alias = {alias: leaf for leaf in leaves for alias in (leaf.label, leaf.name)}
    if name not in by_alias:
        lists = [alias for alias in by_alias if alias.startswith(f"{name}[")]
        rule = "is a list of values" if lists else "must be a number in the robot's file"
        names = [alias for alias, leaf in by_alias.items() if isinstance(leaf.value, float)]
        names += [f"fin.{kind}" for kind in FIN]
        fix = f"choose one with its index: {lists[0]}" if lists else did_you_mean(name, names)
        raise InputError(rule, key="design", value="" if lists else shown(name), file=robot.file or None, fix=fix)
    leaf = by_alias[name]
    if isinstance(leaf.value, bool | str) or not isinstance(leaf.value, int | float):
        fix = "choose a key that holds a number"
        raise InputError("must be a number to design", key=leaf.name, value=shown(leaf.value), fix=fix)
    if isinstance(leaf.value, int):
        fix = "try its values one by one, by --set"
        raise InputError("must be a whole number, which nothing has a derivative by", key=leaf.name, fix=fix)
    _check_ends(leaf.name, low, high)
    unit, usual = (leaf.about.unit, leaf.about.usual) if leaf.about else ("", None)
    if usual is not None and not all(end == 0 or usual[0] <= end <= usual[1] for end in (low, high)):
        rule = f"must stay within what is usual, {usual[0]:g} to {usual[1]:g} {unit}".rstrip()
        key, value = f"design {leaf.name}", f"{low:g}:{high:g}"
        raise InputError(rule, key=key, value=value, file=robot.file or None, fix="check the unit")
    return _checked(robot, Variable(leaf.name, leaf.label, unit, leaf.value, low, high, leaf.place))


def variables(robot: Robot, ends: Mapping[str, tuple[float, float]]) -> tuple[Variable, ...]:
    """Return numbers of a robot as variables; ends: range by key, at both ends of which the robot must be valid."""
    chosen = tuple(variable(robot, name, *map(float, pair)) for name, pair in ends.items())
    for name, count in Counter(item.name for item in chosen).items():
        if count > 1:
            raise InputError("must be given once", key=f"design {name}", value=f"{count} times", fix="leave one out")
    names = {item.name for item in chosen}
    fin = sorted(name for name in names if name.startswith("fin."))
    if len(fin) > 2 or (len(fin) == 2 and {*fin} not in ({"fin.span", "fin.chord"}, {"fin.area", "fin.aspect_ratio"})):
        fix = "give fin.span and fin.chord, or fin.area and fin.aspect_ratio"
        raise InputError("must be independent", key="design", value=" and ".join(fin), fix=fix)
    return chosen


def designed(robot: Robot, design: Sequence[Variable], values: Sequence[float], *, made_by: str = "") -> Robot:
    """Return the robot with new values of variables [unit of the file]; `made_by` is added to their sources.

    Without `made_by` sources are left out, since a search does not need them. InputError if the file would be invalid.
    """
    document = robot.document()
    full = robot.model_dump(mode="json", by_alias=True, exclude_none=True)
    old_document = copy.deepcopy(document)
    if not made_by:
        document = {name: part for name, part in document.items() if name not in ("sources", "uncertainty")}
    for var, value in zip(design, values, strict=True):
        if var.place:
            _follow(document, var, value)
    for var, value in zip(design, values, strict=True):
        if var.place:
            _put(document, full, var.place, float(value))
    span, chord = (
        math.prod(value ** FIN[var.name[4:]][k] for var, value in zip(design, values, strict=True) if not var.place)
        for k in (0, 1)
    )
    if (span, chord) != (1.0, 1.0):
        shape_fin(document, full, span, chord)
    if made_by:
        sources = document.setdefault("sources", {})
        for key in [*_changes(old_document, document)]:
            source = robot.source(key)  # an estimate stays an estimate
            sources[key] = f"{source}; {made_by}" if source else made_by
    return parse(document, file=robot.file)


def _check_ends(name: str, low: float, high: float) -> None:
    """Check that the range of a variable has two finite ends in rising order."""
    key, value = f"design {name}", f"{low:g}:{high:g}"
    if not math.isfinite(low) or not math.isfinite(high):
        raise InputError("must be finite", key=key, value=value, fix="give LOW:HIGH")
    if not low < high:
        fix = "exchange the two" if low > high else "set the value by --set, or give a range"
        raise InputError("must have a lower value below a higher one", key=key, value=value, fix=fix)


def _checked(robot: Robot, varied: Variable) -> Variable:
    """Check that the robots at both ends of a variable's range are valid; return the variable."""
    for end in (varied.low, varied.high):
        try:
            designed(robot, (varied,), (end,))
        except InputError as error:
            rule = f"must keep the robot's file valid (at {end:g} {error.key or ''} {error.rule})"
            key, value = f"design {varied.name}", f"{varied.low:g}:{varied.high:g}"
            fix = error.fix or "narrow the range"
            raise InputError(rule, key=key, value=value, file=robot.file or None, fix=fix) from None
    return varied


def _leaves(part: Part, dump: Any, name: str, label: str, place: Place) -> Iterator[_Leaf]:
    """Yield the values of a table and of its subtables."""
    for attribute, field in type(part).model_fields.items():
        alias = field.alias or attribute
        if alias in dump and not (part.table == "" and alias in TEXTS and not name):
            value = getattr(part, attribute)
            tables = isinstance(value, tuple) and any(isinstance(row, Part) for row in value)
            short = alias if tables else attribute  # a number's attribute has no unit
            names = f"{name}.{alias}".lstrip("."), f"{label}.{short}".lstrip(".")
            yield from _values(value, dump[alias], *names, (*place, alias), part.declared.get(attribute))


def _values(value: Any, dump: Any, name: str, label: str, place: Place, about: Key | None) -> Iterator[_Leaf]:
    """Yield the leaves of a value: those of a table, of a list's tables (by name) or numbers (by index), or itself."""
    if isinstance(value, Part):
        yield from _leaves(value, dump, name, label, place)
    elif isinstance(value, Mapping):
        for key, part in value.items():
            yield from _values(part, dump[key], f"{name}.{key}", f"{label}.{key}", (*place, key), about)
    elif isinstance(value, tuple):
        for k, (part, dumped) in enumerate(zip(value, dump, strict=True)):
            names = [str(dumped[key]) for key in NAMES if key in dumped] if isinstance(dumped, Mapping) else []
            index = f".{names[0]}" if names else f"[{k}]"
            yield from _values(part, dumped, f"{name}{index}", f"{label}{index}", (*place, k), about)
    else:
        yield _Leaf(name, label, place, dump, about)


def _put(document: Any, whole: Any, place: Place, value: float) -> None:
    """Set a value of a document; tables and lists that it lacks are copied from `whole`, which has all defaults."""
    *path, last = place
    for part in path:
        whole = whole[part]
        if isinstance(document, dict) and part not in document:
            document[part] = copy.deepcopy(whole) if isinstance(whole, list) else {}
        document = document[part]
    document[last] = value


def _follow(document: dict[str, Any], varied: Variable, value: float) -> None:
    """Scale the values of a document that depend on a link's length or mass, and correct the sum of the body."""
    kind = FOLLOWED.get(varied.label.partition("[")[0])
    if kind is None:
        return
    scale(document, kind, int(varied.place[-1]), value / varied.value)
    total = f"{kind}_{'m' if kind == 'length' else 'kg'}"
    if total in document.get("body", {}):
        document["body"][total] += value - varied.value


def _changes(before: Any, after: Any, key: str = "") -> Iterator[str]:
    """Yield the keys, without indices, of numbers that differ between two documents."""
    if isinstance(after, dict):
        for name, part in after.items():
            key_below = written((name,)) if not key else f"{key}.{written((name,))}"
            yield from _changes(before.get(name) if isinstance(before, dict) else None, part, key_below)
    elif isinstance(after, list) and after and isinstance(after[0], dict):
        pairs = zip(before or [None] * len(after), after, strict=True)
        yield from dict.fromkeys(change for old, new in pairs for change in _changes(old, new, key))
    elif before != after:
        yield key


def _fin_variable(robot: Robot, name: str, low: float, high: float) -> Variable:
    """Return the variable that a name such as fin.span stands for: a factor on the caudal fin, between two values."""
    kind = name.removeprefix("fin.")
    if kind not in FIN:
        fix = did_you_mean(name, [f"fin.{size}" for size in FIN])
        raise InputError("must be a size of the caudal fin", key="design", value=shown(name), fix=fix)
    _check_ends(name, low, high)
    if not low > 0:
        fix = "give factors on the fin as described: 0.5:1.5"
        raise InputError("must be greater than 0", key=f"design {name}", value=f"{low:g}:{high:g}", fix=fix)
    return Variable(name, name, WHOLE_FIN, 1.0, low, high, ())
