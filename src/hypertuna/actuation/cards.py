"""What is shown of the bend of a joint and of pump sizes."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from hypertuna.actuation.bending import Bend, Step
from hypertuna.actuation.sizing import Sizes
from hypertuna.display import Card, Part, Table, cards, number
from hypertuna.pictures import captioned, curve_svg

ROWS = 11  # pressures


@cards.of(Sizes)
def sizes_card(sizes: Sizes) -> Card:
    """Show what bend and power each case of a pump gives."""
    columns = ("joint", "frequency", "bore", "bend", "of", "power", "largest pressure", "limits")
    rows = [
        (
            size.joint,
            number(size.frequency, "Hz"),
            number(1e3 * size.bore, "mm"),
            number(float(np.degrees(size.bend)), "deg"),
            number(float(np.degrees(size.command)), "deg"),
            number(size.electrical_power["total"], "W"),
            number(size.pressure_max / 1e3, "kPa"),
            ", ".join(size.limits) or "none",
        )
        for size in sizes
    ]
    return Card(f"Pump: {len(sizes)} cases", [Table(columns, rows)], lambda: _loads_svg(sizes))


def _loads_svg(sizes: Sizes) -> str:
    """Draw the servo's torque and speed of each case, and the line between the limits of both."""
    torque = [100 * size.torque / size.torque_limit for size in sizes]
    speed = [100 * size.servo_speed / size.servo_speed_limit for size in sizes]
    label = "servo torque [% of stall] over servo speed [% of that without load]"
    text = "Each dot is a case: torque at the pressure limit, largest speed. Dashed: what the servo gives."
    return captioned(curve_svg(speed, torque, label, dots=True, dashed=[[(0, 100), (100, 0)]]), text)


@cards.of(Bend)
def bend_card(bend: Bend) -> Card:
    """Show a bend."""
    return bends_card(bend, {bend.material: bend})


def bends_card(first: Bend, sets: Mapping[str, Bend], misprints: Sequence[Step] = ()) -> Card:
    """Show a bend and those of other material sets, or a sample of their pressures."""
    several, columns = len(sets) > 1, {}
    for name, one in sets.items():
        columns[f"{name if several else 'loading'}\n[deg]"] = np.degrees(one.angle)
        if one.unload_angle is not None:
            columns[f"{name + ', ' if several else ''}unloading\n[deg]"] = np.degrees(one.unload_angle[::-1])
    count = len(first.pressure)
    picked = np.unique(np.linspace(0, count - 1, min(count, ROWS)).round().astype(int))
    rows = [(f"{first.pressure[k] / 1e3:.4g}", *(f"{column[k]:.2f}" for column in columns.values())) for k in picked]
    parts: list[Part] = [Table(["pressure\n[kPa]", *columns], rows, left=())]
    if count > ROWS:
        parts.append((f"{ROWS} of {count} pressures; -o FILE.csv and --json have all", "dim"))
    if math.isfinite(squared := first.r_squared() if count > 1 else math.nan):
        parts.append(f"line over 100 to 250 kPa, loading: R^2 = {squared:.4f}")
    if first.unload_angle is not None:
        loop = f"loop area {math.degrees(first.loop_area) / 1e3:.1f} kPa deg"
        parts.append(f"{loop}; friction loss {first.friction_loss:.2g} J")
    if several:
        low, high = spread(sets)
        parts.append(f"spread of the materials at {first.pressure[-1] / 1e3:g} kPa: {low:.1f} to {high:.1f} deg")
    parts += [f"{math.degrees(step.angle):6.2f} deg  {step.text}" for step in misprints]
    parts.append((first.status_text, "green" if first.status == "free" else "bold yellow"))
    material = "" if several else f", material set {first.material}"
    equations = "" if first.law == "corrected" else ", equations as printed"
    title = f"{first.robot.name}: joint {first.joint}, {first.side} side{material}{equations}"
    return Card(title, parts, lambda: _bend_svg(first))


def _bend_svg(bend: Bend) -> str:
    """Draw the angle over the pressure."""
    x, y = (np.concatenate(part) for part in zip(*bend.branches.values(), strict=True))
    return curve_svg(x / 1e3, np.degrees(y), "bend [deg] over pressure [kPa]")


def spread(sets: Mapping[str, Bend]) -> tuple[float, float]:
    """Return the smallest and the largest bend of the sets at the last pressure [deg]."""
    angles = [math.degrees(one.angle[-1]) for one in sets.values()]
    return min(angles), max(angles)
