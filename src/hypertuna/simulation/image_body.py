"""Body of a robot image: knobs with which a page changes a robot's body, and how the image's numbers follow them.

A knob multiplies values of the robot's file by a factor f. A number v of the image then becomes
``(v + sum of s (f^q - 1)) * product of f^p`` over all knobs; `follows` of a key's declaration gives its powers p. For
a knob with a few discrete steps, the image may instead list the number's value at each step.
"""

import copy
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.hydraulics import has_oil
from hypertuna.arrays import Array
from hypertuna.description.following import followers, given, table_of
from hypertuna.description.robot import Robot, parse
from hypertuna.description.twin import why_no_twin
from hypertuna.errors import InputError
from hypertuna.simulation.image_source import Source, source_of
from hypertuna.simulation.sea import BOTTOM_RATE, LINKS, ellipsoid_inertia
from hypertuna.swimming.model import column_places
from hypertuna.swimming.yielding import SPRING

RANGES = ((0.6, 1.6), (0.8, 1.25))  # ranges of a factor; the first one whose ends give a valid robot is used
TOLERANCE = 1e-12  # relative: numbers that differ by less are equal
# Prefixes of columns that knobs leave unchanged: the software on board is configured for the described robot.
FIXED_COLUMNS = ("controller.", "pilot.", "missions.")

STEPS = tuple(k / 10 for k in range(6, 17))  # factors of a knob whose numbers must be computed at each step

Numbers = Callable[[Robot], Mapping[str, Array]]  # returns a robot's columns by name, as flat arrays
# How a number follows a factor: power p; or power q and size s of a term of the sum; or values at the knob's steps.
FollowingLaw = tuple[int] | tuple[int, float] | tuple[tuple[float, ...]]
Laws = dict[tuple[str, int], FollowingLaw]  # by column, and index in the column


@dataclass
class Knob:
    """A factor on values of a robot's file, with the laws by which the image's numbers follow it."""

    name: str
    label: str
    unit: str
    value: float  # in the file, which the factor multiplies
    powers: dict[str, int]  # by key of the file: power of the factor that multiplies its value
    sums: dict[str, float] = field(default_factory=dict)  # by key: s in value + s (factor - 1)
    range: tuple[float, float] = RANGES[0]
    steps: tuple[float, ...] = ()  # allowed factors; if empty, any within the range
    part: tuple[str, int] = ("", 0)  # property that the factor multiplies, and index of its link or hinge
    laws: Laws = field(default_factory=dict)


def body_facts(
    robot: Robot, models: Sequence[Robot], numbers: Numbers, steps: Callable[[Robot], int]
) -> tuple[dict[str, Any], Source]:
    """Return a robot's knobs for the image's text, and the source text with the values that they change.

    `numbers` computes the numbers of a robot's image, `steps` the integration steps per tick of its twin; `models` are
    the robot's choices of water law and joints.
    """
    document = robot.document()
    source = source_of(robot)
    knobs = [knob for knob in _knobs(robot, document) if source.holds([*knob.powers, *knob.sums])]
    present = numbers(robot)
    for knob in knobs:
        if knob.steps:
            knob.laws = _values(knob, document, numbers, present)
            continue
        for knob.range in RANGES:
            if None not in [_changed(document, [knob], {knob.name: factor}) for factor in knob.range]:
                knob.laws = _laws(knob, robot, models, present)
                break
    knobs = [knob for knob in knobs if knob.laws]
    twin = None if why_no_twin(robot) else _twin_follows(knobs, document, steps, steps(robot))
    return {"knobs": [_written(knob, source, twin) for knob in knobs]}, source


def with_factors(document: Mapping[str, Any], knobs: list[Knob], factors: Mapping[str, float]) -> dict[str, Any]:
    """Scale the values of knobs in a robot's document; factors: by name of knob, 1 if missing."""
    changed = copy.deepcopy(dict(document))
    for knob in knobs:
        factor = factors.get(knob.name, 1.0)
        for key, power in knob.powers.items():
            table, name = table_of(changed, key)
            table[name] *= factor**power
        for key, size in knob.sums.items():
            table, name = table_of(changed, key)
            table[name] += size * (factor - 1)
    return changed


# --- knobs


def _knobs(robot: Robot, document: Mapping[str, Any]) -> Iterator[Knob]:
    """Yield the knobs of a robot: lengths and masses of links, the last link's height, springs, silicones."""
    names, last = robot.links.name, len(robot.links.name) - 1
    for kind, symbol, key in (("length", "m", "length_m"), ("mass", "kg", "mass_kg")):
        for i, name in enumerate(names):
            value = document["links"][key][i]
            sums = {f"body.{key}": value} if key in document.get("body", {}) else {}
            powers = given(document, followers(kind, i, alias=True))
            yield Knob(f"{kind}-{i}", f"{kind} of {name}", symbol, value, powers, sums, part=(kind, i))
    fin = given(document, followers("height", last, alias=True))
    edge = robot.water.strip is not None and robot.water.strip.edge_height > 0
    label = f"area of the caudal fin ({names[last]})" if edge else f"area of {names[last]}, by its height"
    yield Knob("fin", label, "m^2", document["links"]["lateral_area_m2"][last], fin, part=("height", last))
    for d, (key, hinge) in enumerate(zip(robot.hinge_keys, robot.hinges, strict=True)):
        number, suffix = ("", "") if len(robot.hinges) == 1 else (f"-{d}", f" before {names[hinge.link]}")
        for kind, name, symbol in (("stiffness", "hinge", "N m/rad"), ("moment", "moment", "N m")):
            if value := getattr(hinge, kind):
                places = followers(kind, 0, alias=True).items()
                powers = {f"{key}{place.removeprefix('hinge')}": power for place, power in places}
                yield Knob(f"{name}{number}", f"{kind} of the hinge{suffix}", symbol, value, powers, part=(kind, d))
    unit = robot.drive_unit
    if unit is not None and not why_no_twin(robot) and has_oil(robot):
        moduli = ("modulus_100_pa", "modulus_fe_pa", "tensile_pa[0]", "tensile_pa[1]")
        keys = {f"materials.{name}.{key}": 1 for name in dict.fromkeys((unit.hose, unit.matrix)) for key in moduli}
        label, value = "stiffness of the silicones, in the twin", robot.materials[unit.matrix].modulus_100
        yield Knob("silicone", label, "Pa", value, given(document, keys), steps=STEPS)


# --- laws


def _changed(document: Mapping[str, Any], knobs: list[Knob], factors: Mapping[str, float]) -> Robot | None:
    """Return the robot with factors on its knobs; None if its file would be refused."""
    try:
        return parse(with_factors(document, knobs, factors))
    except InputError:
        return None


def _laws(knob: Knob, robot: Robot, models: Sequence[Robot], present: Mapping[str, Array]) -> Laws:
    """Return the laws by which numbers follow a link's length, mass or height, or stiffness and moment of the hinge."""
    kind, link = knob.part
    powers, laws = followers(kind, link), Laws()
    for name, place in _places(robot, models, link).items():
        if name in present and place in powers:
            k = link if len(present[name]) > 1 else 0
            if present[name][k]:  # nothing multiplies zero
                laws[name, k] = (powers[place],)
    laws |= _sums(kind, link, robot, len(models))
    return {place: laws[place] for name in present for place in ((name, 0), (name, link)) if place in laws}


def _places(robot: Robot, models: Sequence[Robot], link: int) -> dict[str, str]:
    """Return for each number of the image, by name, the key of the description that it holds."""
    text = f"text.links.{link}"
    springs = {f"spring.{name}": f"hinge.{name}" for name in SPRING}
    heights = ("height", "width") if robot.spatial is None else ("height",)  # widths follow heights
    return {
        **{
            f"models.{k}.{name}": place
            for k, model in enumerate(models)
            for name, place in (column_places(model) | springs).items()
        },
        **{f"plant.link.{name}": f"spatial.{attribute}" for name, attribute in LINKS.items()},
        **{f"plant.link.{axis}": f"spatial.inertia_{axis}" for axis in ("roll", "pitch")},
        **{f"{text}.{name}": f"links.{name}" for name in ("length", "com", "mass")},
        **{f"{text}.{name}": "spatial.height" for name in heights},
        **{"text.fins.x": "fins.x", "text.tail.edge_height": "water.strip.edge_height"},
        **{"plant.fin.x": "fins.x", "plant.spring.stiffness": "hinge.stiffness"},
    }


def _sums(kind: str, link: int, robot: Robot, models: int) -> Laws:
    """Return the laws of numbers that are sums over links, or of an ellipsoid's moments of inertia."""
    links, spatial, laws = robot.links, robot.spatial, Laws()
    if column := {"length": "body_length", "mass": "robot_mass"}.get(kind):
        value = getattr(links, kind)[link]
        names = (*(f"models.{k}.{column}" for k in range(models)), f"text.{kind}")
        laws |= {(name, 0): (1, value) for name in names}
    if kind == "mass":
        laws["world.sea.stiffness", 0] = (1, value * BOTTOM_RATE**2)
    elif spatial is not None and kind in ("length", "height"):
        size = links.length[link] if kind == "length" else spatial.height[link]
        for axis in ("pitch",) if kind == "length" else ("roll", "pitch"):
            if getattr(spatial, f"inertia_{axis}") is None:
                laws[f"plant.link.{axis}", link] = (2, ellipsoid_inertia(links.mass[link], size))
    return laws


def _values(knob: Knob, document: Mapping[str, Any], numbers: Numbers, present: Mapping[str, Array]) -> Laws:
    """Compute numbers at each of a knob's steps; return no laws if the twin then needs other integration steps."""
    knob.range, laws = (knob.steps[0], knob.steps[-1]), Laws()
    try:
        by_step = [numbers(parse(with_factors(document, [knob], {knob.name: factor}))) for factor in knob.steps]
    except InputError:  # at some step it is no valid robot, or its pumps do not reach all bends
        return laws
    for name, now in present.items():
        if name.startswith(FIXED_COLUMNS):
            continue
        rows = np.array([one[name] for one in by_step])  # (steps, n)
        proportional = _all_close(rows, np.outer(knob.steps, now))
        for k in np.flatnonzero(~_all_close(rows, now)):
            laws[name, int(k)] = (1,) if proportional[k] else (tuple(rows[:, k].tolist()),)
    return Laws() if ("run.steps", 0) in laws else laws


def _twin_follows(knobs: list[Knob], document: Mapping[str, Any], steps: Callable[[Robot], int], now: int) -> bool:
    """Return whether the twin's integration steps stay valid under all knobs: with random factors and at both ends."""
    rng = np.random.default_rng(1)
    random_sets = [
        {knob.name: float(rng.choice(knob.steps) if knob.steps else rng.uniform(*knob.range)) for knob in knobs}
        for _ in range(2)
    ]
    extremes = [{knob.name: knob.range[end] for knob in knobs} for end in (0, 1)]
    changed = (_changed(document, knobs, factors) for factors in (*random_sets, *extremes))
    try:  # factors that together give no valid robot do not count: the page's reader refuses its file
        return all(steps(robot) == now for robot in changed if robot is not None)
    except InputError:  # it swims, but has no twin
        return False


def _all_close(rows: Array, others: Array) -> NDArray[np.bool_]:
    """Return for each column (n,) whether its numbers agree in all rows to within rounding."""
    return np.asarray(np.isclose(rows, others, rtol=TOLERANCE, atol=0.0, equal_nan=True).all(axis=0))


# --- text


def _written(knob: Knob, source: Source, twin: bool | None) -> dict[str, Any]:
    """Return a knob as written to the image's text, with the values that it changes and their powers or sum terms."""
    keys = [{"key": key, "at": source.at(key), "power": power} for key, power in knob.powers.items()]
    keys += [{"key": key, "at": source.at(key), "sum": size} for key, size in knob.sums.items()]
    facts = {name.removeprefix("text."): law for (name, _), law in knob.laws.items() if name.startswith("text.")}
    return {
        **{"name": knob.name, "label": knob.label, "unit": knob.unit, "value": knob.value, "range": knob.range},
        **({"steps": knob.steps} if knob.steps else {}),
        **{"keys": keys, "columns": _grouped(knob, bool(twin)), "facts": facts},
        **({} if twin is None else {"twin": twin}),
    }


def _grouped(knob: Knob, twin: bool) -> dict[str, list[list[Any]]]:
    """Return a knob's laws by column, each with its index; ``models.*.`` stands for all models with that column."""
    laws: dict[str, dict[int, list[Any]]] = {}
    for (name, k), law in knob.laws.items():
        if name.startswith("models.") or (twin and not name.startswith("text.")):
            laws.setdefault(re.sub(r"^models\.\d+", "models.*", name), {})[k] = [k, *law]
    return {column: [*rows.values()] for column, rows in laws.items()}
