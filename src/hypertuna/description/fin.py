"""The caudal fin of a robot's file, with another span and chord: areas, added mass, lift and drag of beating follow."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.drag import beating_of_chord
from hypertuna.description.following import scale
from hypertuna.description.schema.water import helmbold, plate_mass
from hypertuna.errors import InputError

SAME = 1e-3  # relative difference of areas within which a link counts as all fin


def shape_fin(document: dict[str, Any], whole: Mapping[str, Any], span: float, chord: float) -> None:
    """Multiply span and chord of the caudal fin of a document, whose values with all defaults are `whole`.

    A fin of its own (``edge_height_m``, ``edge_aspect``) is exchanged within the last link, or within the links that it
    covers; their lengths stay. Else the fin is all of the last link, the chord its length.
    """
    last = len(whole["links"]["length_m"]) - 1
    strip, defaults = document["water"].get("strip", {}), whole["water"].get("strip", {})
    height, aspect = strip.get("edge_height_m"), defaults.get("edge_aspect")
    if height and aspect:
        kappa, new_aspect = defaults["edge_added_mass"], aspect * span / chord
        new_kappa = kappa * plate_mass(new_aspect) / plate_mass(aspect)
        mass_ratio = plate_mass(new_aspect) / plate_mass(aspect) * chord**2 * span
        strip.setdefault("added_mass_normal", list(defaults["added_mass_normal"]))
        if height / aspect > document["links"]["length_m"][last]:
            ratios = _spread(document, height**2 / aspect, (span, chord), mass_ratio)
        else:
            _exchange(document, kappa, (height, aspect), (span, chord), mass_ratio)
            ratios = {last: mass_ratio}
        lift = min(defaults["edge_lift"] * helmbold(new_aspect) / helmbold(aspect), 1.0)
        strip |= {"edge_height_m": height * span, "edge_aspect": new_aspect}
        strip |= {"edge_added_mass": new_kappa, "edge_lift": lift}
    else:
        ratios = {last: span**2 * chord}
        old_length = document["links"]["length_m"][last]
        scale(document, "height", last, span)
        scale(document, "length", last, chord)
        if "length_m" in document.get("body", {}):
            document["body"]["length_m"] += old_length * (chord - 1)
        if any(beating := strip.get("drag_beating", ())):
            beating[last] = beating_of_chord(beating[last], chord)
    if "lumped" in document["water"]:
        for link, ratio in ratios.items():
            document["water"]["lumped"]["added_mass"][link] *= ratio


def _exchange(
    document: dict[str, Any],
    kappa: float,
    plate: tuple[float, float],
    factors: tuple[float, float],
    mass_ratio: float,
) -> None:
    """Exchange the plate (height [m], aspect ratio) at the end of the last link for one of other span and chord."""
    strip, links, (height, aspect), (span, chord) = document["water"]["strip"], document["links"], plate, factors
    length, area, old = links["length_m"][-1], links["lateral_area_m2"][-1], height**2 / aspect
    if height / aspect * chord > length:
        rule, value = f"must fit its link, {length:g} m long", f"a chord of {height / aspect * chord:.4g} m"
        raise InputError(rule, key="the fin", value=value, fix="take a smaller chord, or a longer last link")
    new_area = area + old * (span * chord - 1)
    mass = kappa * (height / aspect) ** 2 * height  # over rho pi/4, as that of the link
    link_mass = strip["added_mass_normal"][-1] * area**2 / length + mass * (mass_ratio - 1)
    if new_area <= 0 or link_mass < 0:
        rule, value = "must leave its link an area and added mass", f"{new_area:.3g} m^2 and {link_mass:.3g} m^3"
        raise InputError(rule, key="the fin", value=value, fix="take a larger fin")
    links["lateral_area_m2"][-1] = new_area
    for table, key in (("links", "wetted_area_m2"), ("spatial", "height_m")):
        if key in document.get(table, {}):
            document[table][key][-1] *= new_area / area
    strip["added_mass_normal"][-1] = link_mass * length / new_area**2
    if any(beating := strip.get("drag_beating", ())):  # the mean of the link, of which the fin is a part
        own = beating_of_chord(beating[-1] * area / old, chord)
        beating[-1] = own * old * span * chord / new_area


# --- a fin over several links


@dataclass(frozen=True)
class Pieces:
    """Pieces of the links in order from the trailing edge, each of one height; the fin is the first `fin` of them."""

    ends: Array  # (n + 1,) m from the trailing edge
    height: Array  # (n,) m
    mass: Array  # (n,) m^2, added mass across of a length, over rho pi/4
    beating: Array  # (n,) drag of beating on the height
    fin: int


def _pieces(document: Mapping[str, Any], plate: float) -> Pieces:
    """Cut the links where the fin begins, so that its lateral area is the plate's [m^2]; the head is none of it."""
    links, strip = document["links"], document["water"]["strip"]
    length, area = np.array(links["length_m"])[::-1], np.array(links["lateral_area_m2"])[::-1]
    height = area / length
    mass = np.array(strip["added_mass_normal"])[::-1] * height**2
    beating = np.array(strip.get("drag_beating", np.zeros(len(area))))[::-1]
    sums = np.cumsum(area)
    fin = max(int(np.searchsorted(sums, plate * (1 + SAME), side="right")), 1)
    left = plate - sums[fin - 1]
    if left < SAME * plate or fin >= len(area) - 1:
        return Pieces(np.append(0.0, np.cumsum(length)), height, mass, beating, min(fin, len(area) - 1))
    # The front of link `fin` is as the link before it, and its rear the fin.
    share = 1 - (area[fin] - left) / (height[fin + 1] * length[fin])
    columns = [one[fin] - (1 - share) * one[fin + 1] for one in (height, mass, height * beating)]
    if not 0 < share < 1 or min(columns) < 0:
        fin += int(left > area[fin] / 2)
        return Pieces(np.append(0.0, np.cumsum(length)), height, mass, beating, fin)
    cut = [share * length[fin], (1 - share) * length[fin]]
    ends = np.append(0.0, np.cumsum(np.concatenate([length[:fin], cut, length[fin + 1 :]])))
    rear = [columns[0] / share, columns[1] / share, columns[2] / columns[0]]
    height, mass, beating = (
        np.concatenate([one[:fin], [value, one[fin + 1]], one[fin + 1 :]])
        for one, value in zip((height, mass, beating), rear, strict=True)
    )
    return Pieces(ends, height, mass, beating, fin + 1)


def _spread(
    document: dict[str, Any], plate: float, factors: tuple[float, float], mass_ratio: float
) -> dict[int, float]:
    """Stretch a fin [m^2] over the last links from the trailing edge; return new over old added masses of links.

    The fin's height at a distance x from the edge is the former one at x / chord, times the span. Where a shorter fin
    ends, the body is as high as ahead of the fin. At each place the larger counts: of heights, masses and drags.
    """
    links, strip, (span, chord) = document["links"], document["water"]["strip"], factors
    old = _pieces(document, plate)
    ends = np.append(0.0, np.cumsum(links["length_m"][::-1]))  # of the links
    if chord * old.ends[old.fin] > ends[-2]:
        rule, value = f"must end behind the head, {ends[-2]:.4g} m long", f"{chord * old.ends[old.fin]:.4g} m"
        raise InputError(rule, key="the fin", value=value, fix="take a smaller chord")
    edges = np.unique(np.concatenate([ends, old.ends, chord * old.ends[: old.fin + 1]]))
    middle, step = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
    piece = np.searchsorted(old.ends, middle) - 1
    ahead = np.maximum(piece, old.fin)  # the body at a place, or else the body ahead of the fin
    body = np.minimum(old.height[ahead], old.height[piece])
    body_mass = np.minimum(old.mass[ahead] * (body / old.height[ahead]) ** 2, old.mass[piece])
    body_drag = np.minimum(old.beating[ahead] * body, old.beating[piece] * old.height[piece])
    source = np.minimum(np.searchsorted(old.ends, middle / chord) - 1, old.fin)  # piece of the fin that comes there
    height = np.where(source < old.fin, span * old.height[source], 0.0)
    mass = np.where(source < old.fin, old.mass[source] * mass_ratio / chord, 0.0)
    own = np.array([beating_of_chord(value, chord) if value else 0.0 for value in old.beating])
    pairs = (height, body), (mass, body_mass), (height * own[source], body_drag)
    link = np.minimum(np.searchsorted(ends, middle), len(ends) - 1) - 1
    area, added, drag = (np.bincount(link, step * np.maximum(*pair))[::-1] for pair in pairs)
    lengths, areas = np.array(links["length_m"]), np.array(links["lateral_area_m2"])
    before = np.array(strip["added_mass_normal"]) * areas**2 / lengths
    for table, key in (("links", "lateral_area_m2"), ("links", "wetted_area_m2"), ("spatial", "height_m")):
        if key in document.get(table, {}):
            document[table][key] = (np.array(document[table][key]) * area / areas).tolist()
    strip["added_mass_normal"] = (added * lengths / area**2).tolist()
    if old.beating.any():
        strip["drag_beating"] = (drag / area).tolist()
    return dict(enumerate((added / before).tolist()))
