"""First description of a new robot: every value is an estimate with a rule, until the user measures it."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np

from hypertuna.description.drag import NOSES, STRIDE, beating, blunt_area, friction, swing
from hypertuna.description.schema.base import NAME
from hypertuna.description.shape import DENSITY, FIN_DRAG, FULL, Shape, edge, ellipse_drag, link_columns, link_lengths
from hypertuna.errors import InputError
from hypertuna.io.door import read_toml
from hypertuna.io.files import shipped
from hypertuna.ranges import Range, Whole, check_choice

GIVEN = "as given to `hypertuna robot new`"
# Allowed sizes of a robot.
LINKS = Whole(min=2, max=20)
LENGTH = Range(min=0.03, max=10.0, unit="m")
SLENDER = Range(min=0.03, max=0.45)  # height over length: outside, mass or length has a slip
FLAT = Range(min=0.15, max=2.0)  # width over height
FLOATS = Range(min=1 / 3, max=3.0)  # mass of the water that the sections displace over the robot's
SPAN = Range(min=0.02, max=0.6)  # of the tail fin, over the length
CHORD = Range(min=0.01, max=0.4)  # of the tail fin, over the length
SHORTEST = 0.02  # of a link, over the length of the robot
SEGMENTS = 3  # of a flexible fin
SWING, LAG = 40.0, 80.0  # deg, of all joints together, and from the first to beyond the last
AMPLITUDE = 30.0  # deg, of a single joint
CRUISE = 2.0, 0.3  # Hz of a robot of 0.3 m; slower with the root of the length

OWN = ("height", "width", "fin_span", "fin_chord")  # sizes that [sources] mentions if they are given
SOURCES = {
    "body.mass_kg": GIVEN,
    "links.name": "as made by `hypertuna robot new`",
    "links.length_m": "estimate: the head is half of the fish (seven tenths before a single joint), the rest in equal "
    "parts",
    "joints": "estimate: each joint at the front end of its link",
    "water.density_kg_m3": "estimate: fresh water",
    "gaits": f"""estimate: {CRUISE[0]:g} Hz at {CRUISE[1]:g} m, less with the root of the length; the joints \
bend {SWING:g} deg together, more toward the tail, in a wave of {LAG:g} deg; a single joint {AMPLITUDE:g} deg""",
    "gait_bounds": "estimate: a quarter to twice that frequency, up to 1.5 times those amplitudes",
}


class Estimate(NamedTuple):
    """Rule of an estimate, and the factor within which the true value lies in 90 % of cases, with a reason."""

    rule: str
    factor: float = 1.0  # 1 for a value that is no estimate, or does not affect a settled beat
    reason: str = ""  # reason for the factor

    @property
    def source(self) -> str:
        """Text of the estimate's entry in ``[sources]``."""
        if self.factor == 1:
            return self.rule
        return f"{self.rule}; within a factor of {self.factor:g} in 90 % of cases: {self.reason}"


def water_estimates(shape: Shape, nose: str, swung: float, given: set[str]) -> dict[str, Estimate]:
    """Return the estimates of ``[water.strip]`` and of the links' areas, by key; given: names of the known sizes.

    `swung` [m] is the amplitude of the fin's middle in the gait.
    """
    return dict(_estimates(shape, nose, swung, given))


def _estimates(shape: Shape, nose: str, swung: float, given: set[str]) -> Iterator[tuple[str, Estimate]]:
    """Yield the key and the estimate of each value, for `water_estimates`."""
    aspect, known_sizes = shape.width / shape.height, given & {"height", "width"}
    yield "water.strip", Estimate("estimate: theory and handbooks, for the same shape")
    if not known_sizes:
        rule = "estimate: of the same shape"
        yield "links.lateral_area_m2", Estimate(rule, 1.25, "a body that floats may be flatter or rounder")
    yield (
        "water.strip.added_mass_normal",
        Estimate(
            "estimate: potential flow, rho pi/4 h^2 of every section, over the square of the mean h; the fin as a "
            "plate of its aspect ratio (DNV-RP-C205 2010)",
            1.15,
            "sections of other forms have 0.9 to 1.2 times that of an ellipse",
        ),
    )
    rule = "estimate: Lamb's k1 of a prolate spheroid as long and as thick, all on the head"
    yield "water.strip.added_mass_tangential", Estimate(rule)
    rule = f"estimate: {ellipse_drag(aspect):.3g} for an ellipse {aspect:.3g} times as wide as high, {FIN_DRAG:g} for "
    rule += "the fin, a plate (Hoerner 1965, chapter 3), mean over the area"
    yield "water.strip.drag_normal", Estimate(rule, 1.3, "rounded to sharp edges of the same section")
    rule = f"estimate: ITTC 1957 at {STRIDE:g} lengths per beat of the cruise"
    reason = "laminar to rough: coasting bluegills have 0.015 +- 0.007"
    yield "water.strip.drag_tangential", Estimate(rule, 1.6, reason)
    rule = f"estimate: a plate in a flow to and fro has 8 KC^(-1/3), KC = 2 pi a/c (Graham 1980): {swung:.2g} m is the "
    rule += f"amplitude a of the fin's middle in the cruise; less the {FIN_DRAG:g} of steady flow, by the fin's part "
    rule += "of the area"
    reason = "the scatter of plates of finite span, and of the amplitude in free swimming"
    yield "water.strip.drag_beating", Estimate(rule, 1.5, reason)
    kind = NOSES[nose]
    rule = "estimate: Hoerner's form drag of a streamlined body (1965, chapter 6), and on the largest section "
    rule += ", ".join(f"{drag:g} for {part}" for part, drag in kind.parts.items())
    yield "water.strip.blunt_area_m2", Estimate(f"{rule}; fit it to your first steady runs", kind.factor, kind.reason)
    if "fin_span" in given:
        yield "water.strip.edge_height_m", Estimate(GIVEN)
    else:
        rule = "estimate: a fin as high as the body"
        yield "water.strip.edge_height_m", Estimate(rule, 1.3, "a tail fin may be lower or higher than its body")
    if {"fin_span", "fin_chord"} <= given:
        yield "water.strip.edge_aspect", Estimate("span over mean chord, " + GIVEN)
    else:
        rule = "estimate: span^2 over area of the fin"
        yield "water.strip.edge_aspect", Estimate(rule, 1.4, "fins of one span may be larger or smaller by as much")
    rule = "estimate: a plate of the fin's aspect ratio (DNV-RP-C205 2010)"
    yield "water.strip.edge_added_mass", Estimate(rule, 1.1, "other planforms than a rectangle")
    rule = "estimate: Helmbold's lift slope of a wing of the fin's aspect ratio, over pi AR/2"
    yield (
        "water.strip.edge_lift",
        Estimate(rule, 1.15, "the scatter of wings of low aspect ratio, and fins that give way"),
    )
    rule = "estimate: none; a thin fin keeps no suction at the incidences of a beat"
    yield "water.strip.edge_suction", Estimate(rule)


class Sizes(TypedDict, total=False):
    """Sizes of a robot as measured by its builder [m], [kg]; sizes that are not given are estimated."""

    links: int  # number of links; default 3
    length: float  # default 0.3 m
    mass: float | None
    lengths: Sequence[float]  # lengths of the links, in place of `links` and `length`
    nose: str  # key of `NOSES`; default "robot"
    height: float | None  # largest height of the body without fins
    width: float | None  # largest width of the body without fins
    fin_span: float | None  # span of the tail fin, tip to tip
    fin_chord: float | None  # area of the tail fin over its span


def new_robot(
    name: str, *, joints: Sequence[str] = (), last_alone: bool = False, **sizes: Unpack[Sizes]
) -> dict[str, Any]:
    """Return a robot's document for `parse`: a fish of given sizes, with joints and a gait.

    `joints` names the joint groups, head to tail; they share the links behind the head (default: one for each link).
    With `last_alone` they share those ahead of the last link, which has a group of its own without a name.
    """
    shape, lengths = shape_of(**sizes)
    links, groups = len(lengths), _groups(len(lengths) - last_alone, joints)
    groups |= {"": [links - 1]} if last_alone else {}
    frequency = float(f"{CRUISE[0] * math.sqrt(CRUISE[1] / shape.length):.2g}")
    wave, nose = _wave(len(groups)), sizes.get("nose", "robot")
    beats = [
        (a / len(members), p)
        for members, a, p in zip(groups.values(), *map(np.radians, wave.values()), strict=True)
        for _ in members
    ]
    swung = swing(shape, lengths, [a for a, _ in beats], [p for _, p in beats])
    columns, strip = link_columns(shape, lengths, friction(shape, frequency), beating(shape, swung))
    wetted = math.fsum(columns["wetted_area_m2"])
    strip["blunt_area_m2"] = [float(f"{blunt_area(shape, nose, frequency, wetted):.3g}")] + [0.0] * (links - 1)
    estimates = water_estimates(shape, nose, swung, {name for name, value in sizes.items() if value is not None})
    return {
        "format": 1,
        "name": name,
        "description": f"{name}: a fish of {links} links, estimated from its size",
        "body": {"mass_kg": shape.mass},
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
        "uncertainty": {key: estimate.factor for key, estimate in estimates.items() if estimate.factor > 1},
        "sources": _sources(shape, sizes) | {key: estimate.source for key, estimate in estimates.items()},
    }


def _sources(shape: Shape, sizes: Sizes) -> dict[str, str]:
    """Return the texts of ``[sources]`` by key; they name the sizes that the builder gave."""
    sizes_given = {name: size for name, size in sizes.items() if name in OWN and size is not None}
    listed = [f"{name.replace('_', ' ')} {sizes_given[name]:g} m" for name in OWN if name in sizes_given]
    aspect = shape.width / shape.height
    return {
        "links": f"""estimate: a slender fish: NACA four-digit profile in side view, elliptical sections {aspect:.3g} \
times as wide as high, from {100 * shape.fin_start:.3g} % of the length on a fin {shape.fin_span:.3g} m high; \
{f"as given: {', '.join(listed)}; " * bool(listed)}the rest is that of neutral buoyancy""",
        **SOURCES,
        **({"links.length_m": GIVEN} if sizes.get("lengths") else {}),
        **({} if sizes.get("mass") else {"body.mass_kg": _mass_rule(sizes)}),
    }


def _mass_rule(sizes: Sizes) -> str:
    """Return the text of ``[sources]`` for an estimated mass of the robot."""
    if sizes.get("height") or sizes.get("width"):
        return "estimate: that of the water in the place of the fish"
    return f"estimate: {FULL:g} kg/m^3 times the cube of the length, a slender fish"


def shape_of(
    *,
    links: int = 3,
    length: float = 0.3,
    mass: float | None = None,
    lengths: Sequence[float] = (),
    nose: str = "robot",
    height: float | None = None,
    width: float | None = None,
    fin_span: float | None = None,
    fin_chord: float | None = None,
) -> tuple[Shape, Sequence[float]]:
    """Return the shape of a robot of given `Sizes`, and the lengths of its links [m]."""
    key = "--lengths" if lengths else ""
    if lengths:
        links, length = (
            len(lengths),
            math.fsum(Range(above=0).check(x, "--lengths", "give the length of each link in m") for x in lengths),
        )
    LINKS.check(links, key or "--links", "a head, and one link behind each joint")
    LENGTH.check(
        length, key or "--length", f"give {'the length of each link' if key else 'the length of the robot'} in m"
    )
    if lengths and min(lengths) < SHORTEST * length:
        rule, fix = f"must each be at least {100 * SHORTEST:g} % of the length", "join short links with their neighbors"
        raise InputError(rule, key="--lengths", value=f"{min(lengths):g} of {length:g} m", fix=fix)
    check_choice(nose, NOSES, "--nose")
    if mass is not None:
        Range(above=0).check(mass, "--mass", "give the mass of the robot in kg")
    own = {"--height": (height, SLENDER), "--width": (width, Range(min=0.01, max=0.9)), "--fin-span": (fin_span, SPAN)}
    for option, (size, limits) in {**own, "--fin-chord": (fin_chord, CHORD)}.items():
        if size is not None:
            in_m = Range(min=(limits.min or 0) * length, max=(limits.max or 0) * length, unit="m")
            in_m.check(size, option, f"give it in m; it is taken for a robot of {length:g} m")
    shape = Shape.of(length, mass, height=height, width=width, fin_span=fin_span, fin_chord=fin_chord)
    _check_floats(shape, "--height" if mass is None else "--mass")
    return shape, lengths or link_lengths(links, length)


def _check_floats(shape: Shape, key: str) -> None:
    """Check that the sections of a neutrally buoyant fish have usual proportions."""
    mass, slender, flat = shape.mass, shape.height / shape.length, shape.width / shape.height
    if slender not in SLENDER:
        rule = f"must make a fish from {SLENDER.min:g} to {SLENDER.max:g} times as high as long at neutral buoyancy"
        low, high = (mass * (limit / slender) ** 2 for limit in (SLENDER.min or 0, SLENDER.max or 0))
        fix = f"a robot of {shape.length:g} m has about {low:.2g} to {high:.2g} kg"
        raise InputError(rule, key=key, value=f"{mass:g} kg, {slender:.2g} times as high", fix=fix)
    if flat not in FLAT:
        rule = f"must make a body from {FLAT.min:g} to {FLAT.max:g} times as wide as high at neutral buoyancy"
        value = f"{mass:g} kg, {shape.height:.2g} m high and {shape.width:.2g} m wide"
        raise InputError(rule, key=key, value=value, fix="check mass, height and width")
    if shape.buoyancy not in FLOATS:
        rule = f"must be from {FLOATS.min:.2g} to {FLOATS.max:g} times that of the water in its place"
        value = f"{mass:g} kg, in the place of {shape.buoyancy * mass:.2g} kg of water"
        raise InputError(rule, key=key, value=value, fix="check mass, height and width")


def _groups(links: int, names: Sequence[str]) -> dict[str, list[int]]:
    """Return the links of each named joint group; the groups share the joints behind the head equally."""
    count = links - 1
    names = names or [f"J{i}" for i in range(1, links)]
    if len(names) == 1 and names[0].isdigit():
        fix = "name them, such as front,rear; their number follows from --links"
        raise InputError("must be names of joint groups", key="--joints", value=names[0], fix=fix)
    if len(names) > count or len(set(names)) < len(names) or not all(names):
        rule, value = f"must be at most {count} different names, a driven joint for each link", ",".join(names)
        raise InputError(rule, key="--joints", value=value, fix="give fewer names, or more links")
    bounds = [round(count * g / len(names)) for g in range(len(names) + 1)]
    return {name: list(range(bounds[g] + 1, bounds[g + 1] + 1)) for g, name in enumerate(names)}


def _wave(groups: int) -> dict[str, list[float]]:
    """Return amplitudes [deg], rising toward the tail, and phases [deg] of a traveling wave, by key of a gait."""
    if groups == 1:
        return {"amplitude_deg": [AMPLITUDE], "phase_deg": [0.0]}
    weights = [2 + g for g in range(groups)]
    amplitude = [round(SWING * weight / sum(weights), 1) for weight in weights]
    return {"amplitude_deg": amplitude, "phase_deg": [round(LAG * g / groups, 1) for g in range(groups)]}


def example(document: Mapping[str, Any], file: str = "") -> tuple[dict[str, Any], dict[str, Any]]:
    """Return two valid documents with the sizes of a faulty one: a first robot file, and one with all tables."""
    table = document.get("links")
    columns: dict[str, Any] = table if isinstance(table, dict) else {}
    counts = [len(column) for column in columns.values() if isinstance(column, list)]
    joints = document.get("joints")
    groups = len(joints) if isinstance(joints, list) else 0
    count = min(max(max(counts, key=counts.count) if counts else 3, 2, groups + 1), LINKS.max or 3)
    names = [f"J{i}" for i in range(1, min(groups, count - 1) + 1)]
    robot = _like(document, columns, _name_of(document, file), count, names)
    full = read_toml(shipped("robots") / "hypertuna.toml")
    full["joints"] = [{**full["joints"][-1], **group} for group in robot["joints"]]
    water = {"density_kg_m3": DENSITY}
    for law in ("strip", "lumped", "elongated"):
        column = {key: _spread(value, count) for key, value in full["water"][law].items()}
        water[law] = column | robot["water"].get(law, {})
    model: Any = document.get("model")
    if isinstance(model, dict) and (chosen := model.get("water")) in ("lumped", "elongated"):
        robot["water"][chosen] = water[chosen]
    full["spatial"] = {key: _spread(value, count) for key, value in full["spatial"].items()}
    return robot, full | robot | {"joints": full["joints"], "water": water, "sources": {}}


def _like(
    document: Mapping[str, Any], columns: Mapping[str, Any], name: str, links: int, joints: list[str]
) -> dict[str, Any]:
    """Return a first robot with the length and mass of a document, or with usual ones if these are not possible."""
    body = document.get("body")
    body_table: dict[str, Any] = body if isinstance(body, dict) else {}
    lengths = _positive(columns.get("length_m"))
    length = sum(lengths) or sum(_positive(body_table.get("length_m")))
    mass = sum(_positive(body_table.get("mass_kg"))) or sum(_positive(columns.get("mass_kg")))
    usable = lengths if len(lengths) == links else []
    for total, kg in ((length, mass), (length, 0.0), (0.3, 0.0)):
        try:
            chosen = usable if total == sum(usable) else []
            return new_robot(name, links=links, length=total, mass=kg or None, joints=joints, lengths=chosen)
        except InputError:
            continue
    raise AssertionError


def _positive(value: Any) -> list[float]:
    """Return the positive numbers in a value, which may be a number or a list."""
    values = value if isinstance(value, list) else [value]
    return [x for x in values if isinstance(x, int | float) and not isinstance(x, bool) and 0 < x < math.inf]


def _name_of(document: Mapping[str, Any], file: str) -> str:
    """Return the name of a robot: from its document, else from its file, else "fish"."""
    names = (document.get("name"), file.rpartition("/")[2].removesuffix(".toml"), "fish")
    return next(name for name in names if isinstance(name, str) and NAME.fullmatch(name))


def _spread(value: Any, count: int) -> Any:
    """Return a list resampled to a number of values by nearest neighbors; other values are returned unchanged."""
    if not isinstance(value, list):
        return value
    return [value[round(i * (len(value) - 1) / max(count - 1, 1))] for i in range(count)]
