"""A first description of an own robot: every value an estimate with its rule, to be replaced by measured ones."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from hypertuna.description.schema.base import NAME
from hypertuna.description.shape import (
    ASPECT,
    BEATING,
    BLUNT,
    DENSITY,
    ELLIPSE,
    FIN_START,
    PLATE,
    Shape,
    edge,
    link_columns,
    link_lengths,
)
from hypertuna.errors import InputError
from hypertuna.io.files import shipped
from hypertuna.io.tables import read_toml
from hypertuna.ranges import Range, Whole

LINKS = Whole(min=2, max=20)
LENGTH = Range(min=0.03, max=10.0, unit="m")
FULL = 20.0  # kg/m^3: mass of a slender fish over its length cubed
SLENDER = Range(min=0.03, max=0.45)  # height over length: outside, mass or length has a slip
SHORTEST = 0.02  # of a link, over the length of the robot
SWING, LAG = 40.0, 80.0  # deg, of all joints together, and from the first to beyond the last
AMPLITUDE = 30.0  # deg, of a single joint
CRUISE = 2.0, 0.3  # Hz of a robot of 0.3 m; slower with the root of the length
BANDWIDTH = 5.0  # Hz, of joints that servos drive

SOURCES = {
    "body.mass_kg": "as given to `hypertuna robot new`",
    "links.name": "as made by `hypertuna robot new`",
    "links.length_m": "estimate: the head is half of the fish (seven tenths before a single joint), the rest in equal "
    "parts",
    "links": f"""estimate: a slender fish: NACA four-digit profile in side view, elliptical sections {ASPECT:g} times \
as wide as high, from {100 * FIN_START:g} % of the length on a trapezoidal fin as high as the body; the height is that \
of neutral buoyancy""",
    "joints": "estimate: each joint at the front end of its link",
    "water.density_kg_m3": "estimate: fresh water",
    "water.strip": "estimate: theory and handbooks, for the same shape",
    "water.strip.added_mass_normal": "estimate: potential flow, rho pi/4 h^2 of every section, over the square of the "
    "mean h; the fin as a plate of its aspect ratio (DNV-RP-C205 2010)",
    "water.strip.added_mass_tangential": "estimate: Lamb's k1 of a prolate spheroid as long and as thick, all on the "
    "head",
    "water.strip.drag_normal": f"estimate: {ELLIPSE:.3g} for an ellipse {ASPECT:g} times as wide as high, {PLATE:g} "
    "for the fin, a plate (Hoerner), mean over the area",
    "water.strip.drag_tangential": "estimate: ITTC 1957 at one length per second, times Hoerner's form factor",
    "water.strip.drag_beating": f"""estimate: {BEATING:g} for the fin, by its part of the area: a plate in a flow to \
and fro has 8 KC^(-1/3) (Graham 1980), here at KC = 9.5 as on HyperTuna, less the {PLATE:g} of steady flow""",
    "water.strip.blunt_area_m2": f"""estimate: {BLUNT:g} times the largest section, as identified on HyperTuna; fit \
it to your first steady runs""",
    "water.strip.edge_height_m": "estimate: span of the fin, as high as the body",
    "water.strip.edge_lift": "estimate: Helmbold's lift slope of a wing of the fin's aspect ratio, over pi AR/2",
    "water.strip.edge_suction": "estimate: none; a thin fin keeps no suction at the incidences of a beat",
    "gaits": f"""estimate: {CRUISE[0]:g} Hz at {CRUISE[1]:g} m, less with the root of the length; the joints \
bend {SWING:g} deg together, more toward the tail, in a wave of {LAG:g} deg; a single joint {AMPLITUDE:g} deg""",
    "gait_bounds": "estimate: a quarter to twice that frequency, up to 1.5 times those amplitudes",
}


def new_robot(
    name: str,
    *,
    links: int = 3,
    length: float = 0.3,
    mass: float | None = None,
    joints: Sequence[str] = (),
    lengths: Sequence[float] = (),
) -> dict[str, Any]:
    """Return a document for `parse`: a fish of a number of links, a length [m] and a mass [kg] that swims.

    `joints` names the joint groups, head to tail; they share the links behind the head (default: one for each link).
    `lengths` [m] are those of the links, in place of `links` and `length`.
    """
    key = "--lengths" if lengths else ""
    if lengths:
        links, length = (
            len(lengths),
            math.fsum(Range(above=0).check(one, "--lengths", "give the length of each link in m") for one in lengths),
        )
    LINKS.check(links, key or "--links", "a head, and one link behind each joint")
    LENGTH.check(
        length, key or "--length", f"give {'the length of each link' if key else 'the length of the robot'} in m"
    )
    if lengths and min(lengths) < SHORTEST * length:
        rule, fix = f"must each be at least {100 * SHORTEST:g} % of the length", "join short links with their neighbors"
        raise InputError(rule, key="--lengths", value=f"{min(lengths):g} of {length:g} m", fix=fix)
    mass = float(f"{FULL * length**3:.2g}") if mass is None else mass
    Range(above=0).check(mass, "--mass", "give the mass of the robot in kg")
    shape = Shape(length, mass)
    if shape.height / length not in SLENDER:
        rule = f"must make a fish from {SLENDER.min:g} to {SLENDER.max:g} times as high as long at neutral buoyancy"
        low, high = (mass * (limit * length / shape.height) ** 2 for limit in (SLENDER.min or 0, SLENDER.max or 0))
        fix = f"a robot of {length:g} m has about {low:.2g} to {high:.2g} kg"
        raise InputError(rule, key="--mass", value=f"{mass:g} kg, {shape.height / length:.2g} times as high", fix=fix)
    lengths, groups = lengths or link_lengths(links, length), _groups(links, joints)
    columns, strip = link_columns(shape, lengths)
    frequency = float(f"{CRUISE[0] * math.sqrt(CRUISE[1] / length):.2g}")
    wave = _wave(len(groups))
    return {
        "format": 1,
        "name": name,
        "description": f"{name}: a fish of {links} links, estimated from length and mass",
        "body": {"mass_kg": mass},
        "links": {"name": ["head", *(f"tail {i}" for i in range(1, links - 1)), "fin"], "length_m": list(lengths)}
        | columns,
        "joints": [{"name": group, "links": members} for group, members in groups.items()],
        "model": {"water": "strip", "joints": "ideal"},
        "water": {"density_kg_m3": DENSITY, "strip": strip | edge(shape)},
        "gaits": {"cruise": {"frequency_hz": frequency} | wave},
        "gait_bounds": {
            "frequency_hz": [float(f"{frequency / 4:.2g}"), 2 * frequency],
            "amplitude_deg": [[0.0, round(1.5 * a, 1)] for a in wave["amplitude_deg"]],
            "phase_deg": [[0.0, 0.0], *[[0.0, 180.0]] * (len(groups) - 1)],
        },
        "sources": SOURCES | ({"links.length_m": "as given to `hypertuna robot new`"} if key else {}),
    }


def _groups(links: int, names: Sequence[str]) -> dict[str, list[int]]:
    """Share the joints, one at the front end of each link but the head, among named groups."""
    count = links - 1
    names = names or [f"J{i}" for i in range(1, links)]
    if len(names) == 1 and names[0].isdigit():
        fix = "name them, such as front,rear; their number follows from --links"
        raise InputError("must be names of joint groups", key="--joints", value=names[0], fix=fix)
    if len(names) > count or len(set(names)) < len(names) or not all(names):
        rule, value = f"must be at most {count} different names, a joint for each link behind the head", ",".join(names)
        raise InputError(rule, key="--joints", value=value, fix="give fewer names, or more links")
    ends = [round(count * g / len(names)) for g in range(len(names) + 1)]
    return {name: list(range(ends[g] + 1, ends[g + 1] + 1)) for g, name in enumerate(names)}


def _wave(groups: int) -> dict[str, list[float]]:
    """Return amplitudes [deg], more toward the tail, and phases [deg] of a wave."""
    if groups == 1:
        return {"amplitude_deg": [AMPLITUDE], "phase_deg": [0.0]}
    weights = [2 + g for g in range(groups)]
    amplitude = [round(SWING * weight / sum(weights), 1) for weight in weights]
    return {"amplitude_deg": amplitude, "phase_deg": [round(LAG * g / groups, 1) for g in range(groups)]}


def example(document: Mapping[str, Any], file: str = "") -> tuple[dict[str, Any], dict[str, Any]]:
    """Return robots like a document, which may have mistakes: its first file, and one with tables of all kinds."""
    table = document.get("links")
    columns: dict[str, Any] = table if isinstance(table, dict) else {}
    sizes = [len(column) for column in columns.values() if isinstance(column, list)]
    joints = document.get("joints")
    groups = len(joints) if isinstance(joints, list) else 0
    count = min(max(max(sizes, key=sizes.count) if sizes else 3, 2, groups + 1), LINKS.max or 3)
    names = [f"J{i}" for i in range(1, min(groups, count - 1) + 1)]
    robot = _like(document, columns, _name_of(document, file), count, names)
    others = read_toml(shipped("robots") / "hypertuna.toml")
    others["joints"] = [{**others["joints"][-1], **group} for group in robot["joints"]]
    water = {"density_kg_m3": DENSITY}
    for law in ("strip", "lumped", "elongated"):
        column = {key: _spread(value, count) for key, value in others["water"][law].items()}
        water[law] = column | robot["water"].get(law, {})
    model: Any = document.get("model")
    if isinstance(model, dict) and (chosen := model.get("water")) in ("lumped", "elongated"):
        robot["water"][chosen] = water[chosen]
    others["spatial"] = {key: _spread(value, count) for key, value in others["spatial"].items()}
    return robot, others | robot | {"joints": others["joints"], "water": water, "sources": {}}


def _like(
    document: Mapping[str, Any], columns: Mapping[str, Any], name: str, links: int, joints: list[str]
) -> dict[str, Any]:
    """Return a first robot of the length and the mass of a document, as far as these make a fish."""
    body = document.get("body")
    given: dict[str, Any] = body if isinstance(body, dict) else {}
    lengths = _positive(columns.get("length_m"))
    length = sum(lengths) or sum(_positive(given.get("length_m")))
    mass = sum(_positive(given.get("mass_kg"))) or sum(_positive(columns.get("mass_kg")))
    part = lengths if len(lengths) == links else []
    for size, weight in ((length, mass), (length, 0.0), (0.3, 0.0)):
        try:
            like = part if size == sum(part) else []
            return new_robot(name, links=links, length=size, mass=weight or None, joints=joints, lengths=like)
        except InputError:
            continue
    raise AssertionError


def _positive(value: Any) -> list[float]:
    """Return the positive numbers of a value, a number or a list."""
    values = value if isinstance(value, list) else [value]
    return [x for x in values if isinstance(x, int | float) and not isinstance(x, bool) and 0 < x < math.inf]


def _name_of(document: Mapping[str, Any], file: str) -> str:
    """Return a robot's name, that of its file, or another."""
    names = (document.get("name"), file.rpartition("/")[2].removesuffix(".toml"), "fish")
    return next(name for name in names if isinstance(name, str) and NAME.fullmatch(name))


def _spread(value: Any, count: int) -> Any:
    """Return a list of another length, by the nearest values."""
    if not isinstance(value, list):
        return value
    return [value[round(i * (len(value) - 1) / max(count - 1, 1))] for i in range(count)]
