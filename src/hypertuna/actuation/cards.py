"""Cards of the bend of a joint and of pump sizes, as terminals and notebooks show them."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from hypertuna.actuation.bending import Bend, Correction
from hypertuna.actuation.sizing import REACHED, Size, Sizes
from hypertuna.description.provenance import provenance
from hypertuna.display import Card, Facts, Part, Table, cards
from hypertuna.io.files import dataset
from hypertuna.io.quantity import ZERO_CELSIUS, column_units, counted, label, listed, suffix
from hypertuna.pictures import captioned, curve_svg

ROWS = 11  # largest number of pressures in a table
TURBULENT = "turbulent: the pressure drop is underestimated"  # text for a line whose flow is not laminar
# Limits that reduce the bend: letter in tables, and meaning.
LIMITS = {
    "pressure": ("p", "the pressure limit"),
    "suction": ("s", "suction"),
    "servo": ("v", "a servo that lags by speed, torque or bandwidth"),
    "compliance": ("c", "compliance of lines, oil and air"),
    "line": ("l", "the oil line, which lags"),
    "turbulent": ("t", TURBULENT),
}


@cards.of(Sizes)
def sizes_card(sizes: Sizes) -> Card:
    """Show the torque, speed and stroke that each beat needs of the servos; then one case in full, or a table."""
    beats: dict[tuple[str, float], list[Size]] = {}
    for size in sizes:
        beats.setdefault((size.joint, size.frequency), []).append(size)
    varied, parts = [*sizes[0].values], list[Part]()
    for cases in beats.values() if not varied else ():
        facts = _servo_facts(cases[0]) | (_case_facts(cases[0]) if len(cases) == 1 else {})
        beat = f"joint {cases[0].joint} at {cases[0].frequency:.3g} Hz, {_degrees(cases[0].command)} deg commanded"
        parts += [(f"{beat}; a servo needs, and has", "bold"), Facts(facts)]
    if varied:
        parts.append((f"over {listed(varied)}", "dim"))
    if varied or len(sizes) > len(beats):
        parts += [_case_table(sizes), f"limits: {_legend(sizes)}"]
    if varied:
        stalls = any(size.torque > size.torque_limit for size in sizes)
        parts += ["torque above 100 %: the servo stalls below the pressure limit"] * stalls
        parts.append((sizes_verdict(sizes), "bold"))
    title = f"{sizes.robot.name}: the pump's servos, the lines, and the bend reached in air"
    return Card(title, parts, lambda: _loads_svg(sizes))


def sizes_dataset(sizes: Sizes) -> Any:
    """Return a data set of all cases, with a variable for each column."""
    rows = [size.record() | {"turbulent": int(size.turbulent), "limits": " ".join(size.limits)} for size in sizes]
    units = column_units(Size)

    def column(name: str) -> tuple[str, list[Any], dict[str, str]]:
        unit = units.get(name, "W" if name.endswith("_w") else "")
        attributes = {"units": unit} if unit else {}
        return "case", [row[name] for row in rows], attributes | {"long_name": label(name.removesuffix(suffix(unit)))}

    return dataset({name: column(name) for name in rows[0]}, {}, provenance(sizes.robot))


def _degrees(angle: float) -> str:
    """Return an angle [rad] as text in degrees."""
    return f"{math.degrees(angle):.3g}"


def _servo_facts(size: Size) -> dict[str, str]:
    """Return the torque and speed that a beat needs of a servo, and those that the servo has, as text."""
    speed_left = size.servo_speed_limit * max(0.0, 1 - size.torque / size.torque_limit)
    return {
        "torque, at the pressure limit": f"{size.torque:.3g} of {size.torque_limit:.3g} N m",
        "servo speed": f"{size.servo_speed:.3g} of {size.servo_speed_limit:.3g} rad/s, {speed_left:.3g} at that torque",
        "stroke": f"{_degrees(size.stroke)} of {_degrees(size.stroke_limit)} deg",
    }


def _case_facts(size: Size) -> dict[str, str]:
    """Return all numbers of one case by label, as text."""
    record = size.record()
    shares = ", ".join(f"{name} {watts:.2g}" for name, watts in size.electrical_power.items() if name != "total")
    turbulent = f", {TURBULENT}" if size.turbulent else ""
    return {
        "oil": f"{record['temperature_c']:.3g} C, {record['viscosity_mm2_s']:.4g} mm^2/s",
        "line": f"{record['bore_mm']:.3g} mm, Reynolds number {size.reynolds:.3g}{turbulent}",
        "pressure drop, along the line": f"{record['pressure_drop_kpa']:.3g} kPa for the whole bend",
        "corner, of the line": f"{size.corner:.3g} Hz, for small motions {size.corner_rest:.3g} Hz",
        "resonance, with the muscles": f"{size.resonance:.3g} Hz, damping ratio {size.damping_ratio:.2g}",
        "ring, with the cylinder": f"{size.ring:.3g} Hz, damping ratio {size.ring_damping_ratio:.2g}",
        "bend, reached": f"{record['bend_deg']:.3g} deg, {record['lag_deg']:.3g} deg late",
        "command fraction": f"{100 * size.command_fraction:.3g} % of the whole",
        "max pressure, of cylinders": f"{record['pressure_max_kpa']:.0f} kPa; min {record['pressure_min_kpa']:.0f} kPa",
        "limited by": "; ".join(LIMITS[name][1] for name in _limits(size)) or "nothing",
        "electrical power, both servos": f"{size.electrical_power['total']:.3g} W: {shares}",
    }


def _case_table(sizes: Sizes) -> Table:
    """Return a table of the varied values and the results, with a row for each case."""
    bores, temperatures = ({getattr(size, name) for size in sizes} for name in ("bore", "temperature"))
    columns: dict[str, Callable[[Size], str]] = {"\njoint": lambda size: size.joint}
    columns["f\n[Hz]"] = lambda size: f"{size.frequency:.3g}"
    for key in sizes[0].values:
        columns[f"\n{key.rpartition('.')[2]}"] = partial(lambda key, size: f"{size.values[key]:.4g}", key)
    if len(bores) > 1:
        columns["bore\n[mm]"] = lambda size: f"{1e3 * size.bore:.3g}"
    if len(temperatures) > 1:
        columns["oil\n[C]"] = lambda size: f"{size.temperature - ZERO_CELSIUS:.3g}"
        columns["viscosity\n[mm^2/s]"] = lambda size: f"{1e6 * size.viscosity:.3g}"
    columns["bend\n[deg]"] = lambda size: f"{math.degrees(size.bend):.1f}"
    if sizes[0].values:  # else the facts above have them
        columns["of\n[deg]"] = lambda size: _degrees(size.command)
        columns["torque\nof limit"] = lambda size: f"{100 * size.torque / size.torque_limit:.0f} %"
        columns["servo speed\nof limit"] = lambda size: f"{100 * size.servo_speed / size.servo_speed_limit:.0f} %"
        columns["stroke\nof limit"] = lambda size: f"{100 * size.stroke / size.stroke_limit:.0f} %"
    else:
        columns["corner\n[Hz]"] = lambda size: f"{size.corner:.2g}"
    columns["power\n[W]"] = lambda size: f"{size.electrical_power['total']:.3g}"
    columns["\nlimits"] = lambda size: _letters(size) or "none"
    rows = [[text(size) for text in columns.values()] for size in sizes]
    return Table([*columns], rows, left=(0, len(columns) - 1))


def _limits(size: Size) -> tuple[str, ...]:
    """Return the names of the limits that reduce a case's bend, without "servo" where the pressure limits it too."""
    return tuple(name for name in size.limits if name != "servo" or "pressure" not in size.limits)


def _letters(size: Size) -> str:
    """Return the letters of the limits that reduce a case's bend, and of turbulent flow."""
    return "".join(LIMITS[name][0] for name in (*_limits(size), *["turbulent"] * size.turbulent))


def _legend(sizes: Sizes) -> str:
    """Return the meaning of the letters that occur in these cases."""
    used = "".join(map(_letters, sizes))
    return "; ".join(f"{letter} {text}" for letter, text in LIMITS.values() if letter in used) or "none"


def sizes_verdict(sizes: Sequence[Size]) -> str:
    """Return a sentence on the smallest values with which all joints reach their bend; if none do, on the best ones."""
    cases: dict[tuple[float, ...], list[Size]] = {}
    for size in sizes:
        cases.setdefault(tuple(size.values.values()), []).append(size)
    goal = f"{100 * REACHED:g} % of the commanded bend with enough torque for the pressure limit"
    sufficient = sorted(values for values, of_case in cases.items() if all(size.reached for size in of_case))
    fractions = {values: min(size.bend / size.command for size in of_case) for values, of_case in cases.items()}
    chosen = sufficient[0] if sufficient else max(fractions, key=fractions.__getitem__)
    values_text = listed([f"{key} = {value:.4g}" for key, value in zip(sizes[0].values, chosen, strict=True)])
    if sufficient:
        return f"{len(sufficient)} of {counted(len(cases), 'case')} reach {goal}; the smallest has {values_text}."
    return f"No case reaches {goal}; the best one reaches {100 * fractions[chosen]:.0f} %, with {values_text}."


def _loads_svg(sizes: Sizes) -> str:
    """Draw torque over speed of the servo in each case as SVG, with the servo's torque-speed line."""
    torque = [100 * size.torque / size.torque_limit for size in sizes]
    speed = [100 * size.servo_speed / size.servo_speed_limit for size in sizes]
    label = "servo torque [% of stall] over servo speed [% of that without load]"
    text = "Each dot is a case: torque at the pressure limit, largest speed. Dashed: what the servo gives."
    return captioned(curve_svg(speed, torque, label, dots=True, dashed=[[(0, 100), (100, 0)]]), text)


@cards.of(Bend)
def bend_card(bend: Bend) -> Card:
    """Show the bend of a joint at its pressures, for one material set."""
    return bends_card(bend, {bend.material: bend})


def bends_card(first: Bend, sets: Mapping[str, Bend], misprints: Sequence[Correction] = ()) -> Card:
    """Show the bend of a joint for one or more material sets, at up to `ROWS` pressures, and the misprints' effects."""
    many_sets, columns = len(sets) > 1, {}
    for name, curve in sets.items():
        columns[f"{name if many_sets else 'loading'}\n[deg]"] = np.degrees(curve.angle)
        if curve.unload_angle is not None:
            columns[f"{name + ', ' if many_sets else ''}unloading\n[deg]"] = np.degrees(curve.unload_angle[::-1])
    count = len(first.pressure)
    chosen = np.unique(np.linspace(0, count - 1, min(count, ROWS)).round().astype(int))
    rows = [(f"{first.pressure[k] / 1e3:.4g}", *(f"{column[k]:.2f}" for column in columns.values())) for k in chosen]
    parts: list[Part] = [Table(["pressure\n[kPa]", *columns], rows, left=())]
    if count > ROWS:
        parts.append((f"{ROWS} of {count} pressures; -o FILE.csv and --json have all", "dim"))
    if math.isfinite(squared := first.r_squared() if count > 1 else math.nan):
        parts.append(f"line over 100 to 250 kPa, loading: R^2 = {squared:.4f}")
    if first.unload_angle is not None:
        loop = f"loop area {math.degrees(first.loop_area) / 1e3:.1f} kPa deg"
        parts.append(f"{loop}; friction loss {first.friction_loss:.2g} J")
    if many_sets:
        low, high = spread(sets)
        parts.append(f"spread of the materials at {first.pressure[-1] / 1e3:g} kPa: {low:.1f} to {high:.1f} deg")
    parts += [f"{math.degrees(step.angle):6.2f} deg  {step.text}" for step in misprints]
    parts.append((first.status_text, "green" if first.status == "free" else "bold yellow"))
    material = "" if many_sets else f", material set {first.material}"
    equations = "" if first.law == "corrected" else ", equations as printed"
    title = f"{first.robot.name}: joint {first.joint}, {first.side} side{material}{equations}"
    return Card(title, parts, lambda: _bend_svg(first))


def _bend_svg(bend: Bend) -> str:
    """Draw the bend over the pressure as SVG."""
    x, y = (np.concatenate(part) for part in zip(*bend.branches.values(), strict=True))
    return curve_svg(x / 1e3, np.degrees(y), "bend [deg] over pressure [kPa]")


def spread(sets: Mapping[str, Bend]) -> tuple[float, float]:
    """Return the smallest and the largest bend [deg] of material sets at the last pressure."""
    angles = [math.degrees(curve.angle[-1]) for curve in sets.values()]
    return min(angles), max(angles)
