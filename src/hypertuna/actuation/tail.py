"""Passive and flexible tails: hinges that stand for a flexible plate, and robots whose last link is not driven."""

import math
from collections.abc import Sequence
from typing import Any, Unpack

from hypertuna.description.new import LINKS, SEGMENTS, SHORTEST, Sizes, new_robot, shape_of
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.swimming.yielding import reduced_inertia, softness

LEAST_LINKS = 3
RATIO = 1.6  # k/k_r: where the swims of one hinge were most efficient, 0.8 to 2.8 within a tenth (docs/model.md)
ZETA = 0.05  # damping over the critical one
MODULUS = 2.4e9  # Pa, of polycarbonate


def plate_springs(length: Sequence[float], height: Sequence[float], thickness: float, modulus: float) -> list[float]:
    """Return the stiffness [N m/rad] of hinges that stand for a plate in segments, one at each segment's front edge.

    The plate is clamped at its front. The hinges are a chain of pseudo-rigid bodies (Howell, Compliant Mechanisms,
    2001): each stands for half a segment on either side, k = E I / length, the first for half a segment alone. Under a
    force at the tip, a chain of n equal segments deflects 1 + 1/(2 n^2) times as far as the beam; all hinges are
    stiffened by this factor, so one segment has k = 3 E I / length. Sizes in m, `modulus` in Pa.
    """
    bending = [modulus * h * thickness**3 / 12 for h in height]
    halves = [segment / 2 / stiffness for segment, stiffness in zip(length, bending, strict=True)]
    compliances = [segment + following for segment, following in zip([0.0, *halves], halves, strict=False)]
    factor = 1 + 1 / (2 * len(length) ** 2)
    return [factor / compliance for compliance in compliances]


def with_tail(name: str, tail: str, *, joints: Sequence[str] = (), **sizes: Unpack[Sizes]) -> dict[str, Any]:
    """Return a document like `new_robot`'s; its last link is "driven", "passive", or "flexible" in `SEGMENTS` parts."""
    if tail == "driven":
        return new_robot(name, joints=joints, **sizes)
    if (links := len(shape_of(**sizes)[1])) < LEAST_LINKS:
        rule, fix = f"must be at least {LEAST_LINKS} with --tail {tail}", "a driven joint goes ahead of the tail"
        raise InputError(rule, key="--links", value=f"{links}", fix=fix)
    document = new_robot(name, joints=joints, last_alone=True, **sizes)
    _undrive_last(document)
    last = len(document["links"]["name"]) - 1
    count = 1
    if tail == "flexible":
        document, count = _in_segments(document, sizes), SEGMENTS
    _add_springs(document, range(last, last + count))
    return document


def _undrive_last(document: dict[str, Any]) -> None:
    """Remove the joint group of the last link, which it has alone."""
    del document["joints"][-1]
    for table in (*document["gaits"].values(), document["gait_bounds"]):
        for key in ("amplitude_deg", "phase_deg"):
            del table[key][-1]


def _in_segments(document: dict[str, Any], sizes: Sizes) -> dict[str, Any]:
    """Return the document with its last link cut into `SEGMENTS` equal links."""
    _, lengths = shape_of(**sizes)
    shortest = SEGMENTS * SHORTEST * math.fsum(lengths)
    if lengths[-1] < shortest or len(lengths) + SEGMENTS - 1 not in LINKS:
        rule = f"must leave the fin {shortest:.3g} m and two links to spare with --tail flexible"
        fix = "give fewer and longer links, or take --tail passive"
        key = "--lengths" if sizes.get("lengths") else "--links"
        raise InputError(rule, key=key, value=f"{len(lengths)}, the last of {lengths[-1]:.3g} m", fix=fix)
    segment_lengths = [*lengths[:-1], *[lengths[-1] / SEGMENTS] * SEGMENTS]
    others: Any = {key: value for key, value in sizes.items() if key not in ("links", "length", "lengths")}
    segmented = new_robot(document["name"], lengths=segment_lengths, **others)
    segmented["links"]["name"] = document["links"]["name"][:-1] + [f"fin {i + 1}" for i in range(SEGMENTS)]
    unchanged = {key: document[key] for key in ("description", "joints", "gaits", "gait_bounds")}
    sources = {key: document["sources"][key] for key in ("links.length_m", "body.mass_kg")}
    sources["links.length_m"] += f"; the fin in {SEGMENTS} equal segments"
    return segmented | unchanged | {"sources": segmented["sources"] | sources}


def _add_springs(document: dict[str, Any], links: range) -> None:
    """Add hinges at the front of the links; their stiffness is `RATIO` times that of resonance at the cruise."""
    columns, frequency = document["links"], document["gaits"]["cruise"]["frequency_hz"]
    length = [columns["length_m"][i] for i in links]
    height = [columns["lateral_area_m2"][i] / columns["length_m"][i] for i in links]
    relative = plate_springs(length, height, (12 / MODULUS) ** (1 / 3), MODULUS)  # a plate of 1 N m^2 per m of height
    tables = [{"link": i, "stiffness_n_m_per_rad": k} for i, k in zip(links, relative, strict=True)]
    robot = parse(document | {"hinges": tables})
    scale = RATIO / softness(robot, frequency)
    for table, inertia in zip(tables, reduced_inertia(robot).diagonal().tolist(), strict=True):
        stiffness = scale * table["stiffness_n_m_per_rad"]
        damping = 2 * ZETA * math.sqrt(stiffness * inertia)
        table |= {"stiffness_n_m_per_rad": float(f"{stiffness:.3g}"), "damping_n_m_s_per_rad": float(f"{damping:.2g}")}
    document |= {"hinge": tables[0]} if len(tables) == 1 else {"hinges": tables}
    key = "hinge" if len(tables) == 1 else "hinges"
    thickness = 1e3 * (12 * scale / MODULUS) ** (1 / 3)
    plate = f"that of a plate of {thickness:.2g} mm of polycarbonate ({MODULUS / 1e9:g} GPa)"
    rule = f"estimate: {RATIO:g} times the stiffness at resonance with the cruise, where swims are efficient; {plate}"
    document["sources"] |= {key: rule, f"{key}.damping_n_m_s_per_rad": f"estimate: {ZETA:g} of the critical damping"}
