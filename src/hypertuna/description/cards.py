"""Card of a robot: side view, facts, and a table of the links."""

from __future__ import annotations

import math
from itertools import accumulate
from typing import Any

from hypertuna.description.robot import Robot
from hypertuna.display import Card, Facts, Table, cards, number, safe, tables

WIDE = 1000  # units of the drawing per body length


@cards.of(Robot)
def robot_card(robot: Robot) -> Card:
    """Show a robot from the side, with facts and a table of its links."""
    groups = {link: group.name for group in robot.joints for link in group.links}
    links = robot.links
    facts = {
        "length": number(robot.body.length, "m"),
        "mass": number(robot.body.mass, "kg"),
        "links": f"{len(links.name)}",
        "joint groups": ", ".join(group.name for group in robot.joints),
        "model": f"{robot.model.water} water, {robot.model.joints} joints",
        "gaits": f"{len(robot.gaits)}",
    }
    rows = [
        (
            name,
            number(1e3 * length),
            number(1e3 * area / length),
            number(mass),
            f"{groups[k]}" if k in groups else "rigid" if k else "–",
        )
        for k, (name, length, area, mass) in enumerate(
            zip(links.name, links.length, links.lateral_area, links.mass, strict=True)
        )
    ]
    columns = ("link", "length [mm]", "mean height [mm]", "mass [kg]", "joint at its front")
    gaits = f" Gaits: {', '.join(robot.gaits)}." if robot.gaits else ""
    text = f"{robot.description.rstrip('.')}.{gaits}"
    return Card(f"Robot {robot.name}", [Facts(facts), text, Table(columns, rows)], lambda: side_svg(robot))


@tables.of(Robot)
def link_columns(robot: Robot) -> dict[str, Any]:
    """Return the quantities of a robot's links by column, one value per link."""
    links, groups = robot.links, {link: group.name for group in robot.joints for link in group.links}
    return {
        "link": links.name,
        "joint": [groups.get(k) for k in range(len(links.name))],
        "length_m": links.length,
        "mass_kg": links.mass,
        "inertia_kg_m2": links.inertia,
        "com_m": links.com,
        "lateral_area_m2": links.lateral_area,
        "wetted_area_m2": links.wetted_area,
    }


def side_svg(robot: Robot) -> str:
    """Draw the links from the side at their mean height, with joints as dots and centers of mass as crosses."""
    links, scale = robot.links, WIDE / robot.body.length
    fronts = [scale * x for x in (0.0, *accumulate(links.length))]
    heights = [scale * area / length for area, length in zip(links.lateral_area, links.length, strict=True)]
    half_high = max(heights) / 2
    parts = []
    for k, (x, length, height) in enumerate(zip(fronts, links.length, heights, strict=False)):
        extent = scale * length
        parts.append(
            f'<rect class="link" x="{x + 2:.1f}" y="{-height / 2:.1f}" width="{extent - 4:.1f}" height="{height:.1f}" '
            f'rx="{min(16, 0.3 * extent, 0.3 * height):.1f}"><title>{safe(links.name[k])}</title></rect>'
        )
        com_x = x + scale * links.com[k]
        parts.append(f'<path class="mark" d="M{com_x - 6:.1f} 0h12M{com_x:.1f} -6v12"/>')
    for group in robot.joints:
        joint_xs = [fronts[link] for link in group.links]
        parts += [f'<circle class="joint" cx="{x:.1f}" cy="0" r="8"/>' for x in joint_xs]
        middle = sum(joint_xs) / len(joint_xs)
        parts.append(f'<text x="{middle:.1f}" y="{-half_high - 8:.1f}" text-anchor="middle">{safe(group.name)}</text>')
    power = 10 ** math.floor(math.log10(robot.body.length / 6))
    bar = max(step * power for step in (1, 2, 5) if step * power <= robot.body.length / 6)
    bar_y = half_high + 26
    parts.append(f'<path class="mark" stroke-width="3" d="M0 {bar_y:.1f}h{scale * bar:.1f}"/>')
    parts.append(f'<text x="{scale * bar + 10:.1f}" y="{bar_y + 7:.1f}">{1e3 * bar:g} mm</text>')
    view_box = f"-10 {-half_high - 34:.0f} {WIDE + 20} {2 * half_high + 76:.0f}"
    attributes = f'viewBox="{view_box}" font-size="22" role="img" aria-label="{safe(robot.name)} from the side"'
    return f"<svg {attributes}>{''.join(parts)}</svg>"
