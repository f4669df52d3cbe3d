"""Body of a robot image: what a page may change of a robot's body, and what of the image follows it.

A knob multiplies values of the robot's file by a factor. How each number of the image follows is found here by
computing it for changed descriptions, never written by hand: a number is ``(v + sum of s (f^q - 1)) * product of f^p``
over the knobs' factors f, to the last digits, or the knob is left out. A knob of few steps may have v by step instead.
"""

import copy
import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, parse
from hypertuna.description.twin import why_no_twin
from hypertuna.errors import InputError
from hypertuna.simulation.image_source import Source, source_of

RANGES = ((0.6, 1.6), (0.8, 1.25))  # of a factor: the first whose ends are descriptions of a robot
POWERS = (1, 2, -1, 3, -2)
SAME = 1e-12  # relative
# Columns that stay: what is on board knows the described robot.
KEPT = ("controller.", "pilot.", "missions.")

STEPS = tuple(k / 10 for k in range(6, 17))  # factors of what is solved for anew, so that it follows no law

Numbers = Callable[[Robot], Mapping[str, Array]]  # columns of a robot by name, flat
# Power p; or power q and size s of a term of a sum; or values at the factors that a knob may have.
Law = tuple[int] | tuple[int, float] | tuple[tuple[float, ...]]


@dataclass
class Knob:
    """A factor on values of a robot's file."""

    name: str
    label: str
    unit: str
    value: float  # that the factor multiplies, as in the file
    powers: dict[str, int]  # of the factor, by key
    sums: dict[str, float] = field(default_factory=dict)  # what keys gain where the factor is 2
    range: tuple[float, float] = RANGES[0]
    steps: tuple[float, ...] = ()  # factors that it may have; any within the range where empty
    laws: dict[tuple[str, int], Law] = field(default_factory=dict)  # by column and place in it
    lawless: set[tuple[str, int]] = field(default_factory=set)  # numbers of the twin that follow no law

    @property
    def twin(self) -> bool:
        """Whether the twin follows."""
        return not self.lawless


def body_facts(robot: Robot, numbers: Numbers, all_numbers: Numbers) -> tuple[dict[str, Any], Source]:
    """Return the knobs of a robot's body as the image's text has them, and the source that holds their values.

    `numbers` computes the columns that knobs usually change, `all_numbers` all of the image.
    """
    document = robot.document()
    source = source_of(robot)
    knobs = [knob for knob in _knobs(robot, document) if source.holds([*knob.powers, *knob.sums])]
    present = numbers(robot)
    every = all_numbers(robot)
    knobs = [
        knob
        for knob in knobs
        if (
            _find_values(knob, document, all_numbers, every)
            if knob.steps
            else _find_laws(knob, document, numbers, present)
        )
    ]
    knobs = _verified(knobs, document, every, all_numbers)
    twin = not why_no_twin(robot)
    return {"knobs": [_written(knob, source, twin) for knob in knobs]}, source


def with_factors(document: Mapping[str, Any], knobs: list[Knob], factors: Mapping[str, float]) -> dict[str, Any]:
    """Return a document of a robot's file with the values of its knobs times factors."""
    changed = copy.deepcopy(dict(document))
    for knob in knobs:
        factor = factors.get(knob.name, 1.0)
        for key, power in knob.powers.items():
            table, last = _table(changed, key)
            table[last] *= factor**power
        for key, size in knob.sums.items():
            table, last = _table(changed, key)
            table[last] += size * (factor - 1)
    return changed


# --- knobs


def _knobs(robot: Robot, document: Mapping[str, Any]) -> Iterator[Knob]:
    """Yield what may be changed of a robot: lengths and masses of links, the last link's height, springs."""
    names, last = robot.links.name, len(robot.links.name) - 1
    links = document["links"]
    for i, name in enumerate(names):
        powers = _given(
            document,
            **{f"links.{key}[{i}]": 1 for key in ("length_m", "com_m", "lateral_area_m2", "wetted_area_m2")},
            **{f"links.inertia_kg_m2[{i}]": 2, f"spatial.inertia_pitch_kg_m2[{i}]": 2},
            **{f"spatial.buoyancy_center_m[{i}]": 1},
            **({"fins.x_m": 1} if i == 0 else {}),
        )
        value = links["length_m"][i]
        sums = {"body.length_m": value} if "length_m" in document.get("body", {}) else {}
        yield Knob(f"length-{i}", f"length of {name}", "m", value, powers, sums)
    for i, name in enumerate(names):
        inertias = ("links.inertia_kg_m2", "spatial.inertia_pitch_kg_m2", "spatial.inertia_roll_kg_m2")
        powers = _given(document, **{f"{key}[{i}]": 1 for key in ("links.mass_kg", *inertias)})
        value = links["mass_kg"][i]
        sums = {"body.mass_kg": value} if "mass_kg" in document.get("body", {}) else {}
        yield Knob(f"mass-{i}", f"mass of {name}", "kg", value, powers, sums)
    sides = {f"{key}[{last}]": 1 for key in ("links.lateral_area_m2", "links.wetted_area_m2", "spatial.height_m")}
    fin = _given(document, **sides, **{"water.strip.edge_height_m": 1})
    edge = robot.water.strip is not None and robot.water.strip.edge_height > 0
    label = f"area of the caudal fin ({names[last]})" if edge else f"area of {names[last]}, by its height"
    yield Knob("fin", label, "m^2", links["lateral_area_m2"][last], fin)
    if robot.hinge is not None:
        key = "hinge.stiffness_n_m_per_rad"
        yield Knob("hinge", "stiffness of the hinge", "N m/rad", robot.hinge.stiffness, {key: 1})
    unit = robot.drive_unit
    if unit is not None and not why_no_twin(robot) and not all(group.direct for group in robot.joints):
        moduli = ("modulus_100_pa", "modulus_fe_pa", "tensile_pa[0]", "tensile_pa[1]")
        keys = {f"materials.{name}.{key}": 1 for name in dict.fromkeys((unit.hose, unit.matrix)) for key in moduli}
        label, value = "stiffness of the silicones, in the twin", robot.materials[unit.matrix].modulus_100
        yield Knob("silicone", label, "Pa", value, _given(document, **keys), steps=STEPS)


def _given(document: Mapping[str, Any], **powers: int) -> dict[str, int]:
    """Return the keys that a file gives; others follow by the schema's defaults."""

    def stands(key: str) -> bool:
        try:
            table, last = _table(document, key)
            return bool(table[last])  # nothing multiplies zero
        except (KeyError, IndexError, TypeError):
            return False

    return {key: power for key, power in powers.items() if stands(key)}


def _table(document: Any, key: str) -> tuple[Any, Any]:
    """Return the table or list of a document that a key is in, and its name or index there."""
    *path, last = _parts(key)
    for part in path:
        document = document[part]
    return document, last


def _parts(key: str) -> Iterator[str | int]:
    """Split a key such as ``links.length_m[3]``."""
    for part in key.split("."):
        name, bracket, index = part.partition("[")
        yield name
        if bracket:
            yield int(index[:-1])


# --- laws


def _find_laws(knob: Knob, document: Mapping[str, Any], numbers: Numbers, present: Mapping[str, Array]) -> bool:
    """Find a knob's range, and how numbers follow from one end to the other; False where a model's follows no law."""
    for knob.range in RANGES:
        try:
            less, more = (parse(with_factors(document, [knob], {knob.name: factor})) for factor in knob.range)
            break
        except InputError:
            continue
    else:
        return False
    low, high = numbers(less), numbers(more)
    for name, before in present.items():
        for k in np.flatnonzero(np.logical_or(_differ(before, low[name]), _differ(before, high[name]))):
            law = _law(float(before[k]), float(low[name][k]), float(high[name][k]), knob.range)
            if law is not None:
                knob.laws[name, int(k)] = law
            elif _swims(name):
                return False
            else:
                knob.lawless.add((name, int(k)))
    return bool(knob.laws)


def _find_values(knob: Knob, document: Mapping[str, Any], numbers: Numbers, present: Mapping[str, Array]) -> bool:
    """Find powers and values of numbers at the steps of a knob; False where the twin needs other steps of its own."""
    knob.range = (knob.steps[0], knob.steps[-1])
    try:
        found = [numbers(parse(with_factors(document, [knob], {knob.name: factor}))) for factor in knob.steps]
    except InputError:
        return False
    for name, before in present.items():
        if name.startswith(KEPT):
            continue
        for k in np.flatnonzero(np.logical_or.reduce([_differ(before, one[name]) for one in found])):
            values = tuple(float(one[name][k]) for one in found)
            pairs = list(zip(values, knob.steps, strict=True))
            power = next((p for p in POWERS if all(_same(x, float(before[k]) * f**p) for x, f in pairs)), None)
            knob.laws[name, int(k)] = (values,) if power is None else (power,)
    return bool(knob.laws) and ("run.steps", 0) not in knob.laws


def _law(value: float, low: float, high: float, factors: tuple[float, float]) -> Law | None:
    """Return the law of a number with its values at two factors; None where it follows none that is known."""
    less, more = factors
    for p in POWERS:
        if _same(low, value * less**p) and _same(high, value * more**p):
            return (p,)
    for q in POWERS:
        size = (high - value) / (more**q - 1)
        if _same(low, value + size * (less**q - 1)):
            return (q, size)
    return None


def _verified(
    knobs: list[Knob], document: Mapping[str, Any], present: Mapping[str, Array], all_numbers: Numbers
) -> list[Knob]:
    """Return the knobs whose laws hold together: with all factors changed at once, drawn and at their ranges' ends."""
    chance = np.random.default_rng(1)
    drawn = [
        {knob.name: float(chance.choice(knob.steps) if knob.steps else chance.uniform(*knob.range)) for knob in knobs}
        for _ in range(2)
    ]
    ends = [{knob.name: knob.range[end] for knob in knobs} for end in (0, 1)]
    for factors in (*drawn, *ends) if knobs else ():
        try:
            changed = parse(with_factors(document, knobs, factors))
        except InputError:  # no robot, all taken together: its file is refused when it is read
            continue
        try:
            found = all_numbers(changed)
        except InputError:  # it swims, but has no twin
            for knob in knobs:
                knob.lawless.add(("run.steps", 0))
            continue
        wrong = list(_wrong(present, found, knobs, factors))
        blamed = [knob for knob in knobs if any(_swims(name) and (name, k) in knob.laws for name, k in wrong)]
        if blamed:
            left = [knob for knob in knobs if knob not in blamed]
            return _verified(left, document, present, all_numbers)
        if any(_swims(name) for name, _ in wrong):
            raise AssertionError(f"numbers of the model follow no knob: {wrong}")
        for place in wrong:
            concerned = [knob for knob in knobs if place in knob.laws or place in knob.lawless] or knobs
            for knob in concerned:
                knob.lawless.add(place)
    return knobs


def _wrong(
    present: Mapping[str, Array], found: Mapping[str, Array], knobs: list[Knob], factors: Mapping[str, float]
) -> Iterator[tuple[str, int]]:
    """Yield the places of numbers that are not as the laws say."""
    expected = {name: values.copy() for name, values in present.items() if not name.startswith(KEPT)}
    laws = [(knob, place, law) for knob in knobs for place, law in knob.laws.items()]
    for knob, (name, k), law in laws:
        if isinstance(law[0], tuple):
            expected[name][k] = law[0][knob.steps.index(factors[knob.name])]
    for knob, (name, k), law in laws:
        if len(law) == 2:
            expected[name][k] += law[1] * (factors[knob.name] ** law[0] - 1)
    for knob, (name, k), law in laws:
        if len(law) == 1 and not isinstance(law[0], tuple):
            expected[name][k] *= factors[knob.name] ** law[0]
    for name, values in expected.items():
        yield from ((name, int(k)) for k in np.flatnonzero(_differ(values, found[name])))


def _swims(name: str) -> bool:
    """Whether a number is of a model in water or of the text, not of the twin alone."""
    return name.startswith(("models.", "text."))


def _same(a: float, b: float) -> bool:
    return bool(abs(a - b) <= SAME * max(abs(a), abs(b)))


def _differ(a: Array, b: Array) -> Array:
    """Whether numbers (n,) differ by more than rounding."""
    with np.errstate(invalid="ignore"):
        close = abs(a - b) <= SAME * np.maximum(abs(a), abs(b))
    return np.asarray(~(close | (a == b)))


# --- text


def _written(knob: Knob, source: Source, twin: bool) -> dict[str, Any]:
    """Return a knob for the image's text; a power is one number, a term of a sum two."""
    keys = [{"key": key, "at": source.at(key), "power": power} for key, power in knob.powers.items()]
    keys += [{"key": key, "at": source.at(key), "sum": size} for key, size in knob.sums.items()]
    facts = {name.removeprefix("text."): law for (name, _), law in knob.laws.items() if name.startswith("text.")}
    return {
        **{"name": knob.name, "label": knob.label, "unit": knob.unit, "value": knob.value, "range": knob.range},
        **({"steps": knob.steps} if knob.steps else {}),
        **{"keys": keys, "columns": _grouped(knob), "facts": facts},
        **({"twin": knob.twin} if twin else {}),
    }


def _grouped(knob: Knob) -> dict[str, list[list[Any]]]:
    """Return the laws by column: place and law; `models.*.` are all models that have the column."""
    laws: dict[str, list[list[Any]]] = {}
    for (name, k), law in knob.laws.items():
        if not name.startswith("text.") and (knob.twin or _swims(name)):
            laws.setdefault(name, []).append([k, *law])
    plain = {name: law for name, law in laws.items() if not name.startswith("models.")}
    of_models = sorted((name.split(".", 2)[2], law) for name, law in laws.items() if name.startswith("models."))
    for column, group in itertools.groupby(of_models, key=lambda one: one[0]):
        rows = [row for _, row in group]
        if any(row != rows[0] for row in rows):
            raise AssertionError(f"the models' column {column} follows different laws")
        plain[f"models.*.{column}"] = rows[0]
    return plain
