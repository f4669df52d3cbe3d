"""Cards of a fit to bench runs, of a family of actuators and of a spring."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from hypertuna.characterization.data import BRANCHES
from hypertuna.characterization.family import Family, Next
from hypertuna.characterization.fit import BenchFit, at_border
from hypertuna.characterization.spring import SIGNIFICANT, SpringFit
from hypertuna.characterization.unknowns import FACTORS
from hypertuna.display import Card, Part, Table, cards
from hypertuna.io.quantity import counted
from hypertuna.pictures import bars_svg, computed_svg

SMALL = 0.5  # half intervals of a logarithm below this are written as a percentage, others as a factor
MEASUREMENTS, NARROWED = 8, 3  # most measurements listed, and most narrowed quantities named for each


@cards.of(BenchFit)
def bench_card(fit: BenchFit) -> Card:
    """Show a fit: unknowns with intervals, determined combinations, errors and warnings."""
    bench, n, known = fit.bench, len(fit.free), len(fit.combinations)
    joints = f"joint{'s' * (len(bench.joints) > 1)} {' and '.join(fit.described.joints[j].name for j in bench.joints)}"
    rms = ", ".join(f"{key.replace('_', f' {value:.2g} ')}" for key, value in at_border(fit.rms).items())
    alone = sum(row["determined"] for row in fit.parameters)
    remark = "" if alone == n else "; the fitted values are one of many sets that fit as well"
    determined = f"The bench determines {alone} of {n} unknowns, and {counted(known, 'combination')} of them{remark}."
    parts: list[Part] = [(determined, "bold"), f"rms of the residuals: {rms}", _unknown_table(fit)]
    rows = [
        [
            c.text,
            f"{c.value:.3g}",
            f"{c.low:.3g} .. {c.high:.3g}, {half_text(math.log(c.high / c.low) / 2)}",
        ]
        for c in fit.combinations
    ]
    if rows:
        parts.append(Table(["combination, over the described one", "value", "95 % interval"], rows, whole=0))
    used = {name for c in fit.combinations for name in c.exponents}
    parts += [(f"{name} = {meaning}", "dim") for name, meaning in FACTORS.values() if name in used]
    spectrum = (f"{d.singular_value:.2g}" if d.singular_value > 1e-3 else "0" for d in fit.directions)
    parts.append(f"singular values, bench over bounds: {', '.join(spectrum)}")
    parts += [(warning, "yellow") for warning in fit.warnings]
    parts.append((f"{fit.stop} {fit.seconds:.1f} s in all.", "green" if fit.converged else "bold red"))
    with_angle = np.isfinite(fit.bench.angle)
    angles = np.degrees([fit.bench.angle[with_angle], fit.angle[with_angle]]).T.tolist()
    title = f"{fit.robot.name}, {joints}: {counted(len(bench.angle), 'row')}"
    return Card(title, parts, partial(computed_svg, angles, "bend [deg]", "a row of the bench"))


def _unknown_table(fit: BenchFit) -> Table:
    """Return the table of a fit's unknowns with their intervals."""
    rows = []
    for row in fit.parameters:
        interval = f"{row['low']:.3g} .. {row['high']:.3g}"
        unit = row["counted"] or row["unit"].removeprefix("1")
        remark = ("" if row["determined"] else "not determined", "yellow")
        rows.append([row["name"], f"{row['described']:.3g}", f"{row['value']:.3g}", interval, unit, remark])
    return Table(["unknown", "described", "fitted", "95 % interval", "unit", ""], rows, left=(0, 4, 5), whole=0)


def half_text(log: float) -> str:
    """Return half an interval of a logarithm as text: a percentage, or a factor if the interval is wide."""
    return f"\u00b1{100 * log:.2g} %" if log < SMALL else f"\u00d7/\u00f7 {math.exp(log):.2g}"


@cards.of(Family)
def family_card(found: Family) -> Card:
    """Show a family: measured values, open quantities, unknowns, and the most informative measurements."""
    bench, robot, population = found.space.bench, found.space.robot, found.population
    joints = f"joint{'s' * (len(bench.joints) > 1)} {' and '.join(robot.joints[j].name for j in bench.joints)}"
    facts = [
        [
            *(fact_text(one), one["unit"]),
            *(f"{one[key]:.3g}" for key in ("measured", "sd")),
            *(f"{one['low']:.3g} .. {one['high']:.3g}", f"{one['chosen']:.3g}", f"{one['residual']:+.1f}"),
        ]
        for one in found.facts
    ]
    quantities = [
        [one.text, one.unit, f"{one.interval[0]:.3g} .. {one.interval[2]:.3g}", f"{one.values[found.middle]:.3g}"]
        for one in found.quantities
    ]
    unknowns = [
        [
            *(one["name"], one["unit"].removeprefix("1"), f"{one['lower']:.3g} .. {one['upper']:.3g}"),
            *(f"{one['low']:.3g} .. {one['high']:.3g}", f"{one['chosen']:.3g}"),
        ]
        for one in found.rows
    ]
    designs = f"{counted(population.tried, 'design')} drawn within the bounds"
    computed = f"{counted(population.evaluations, 'design')} computed in all"
    measured = ["measured", "unit", "value", "sd", "90 % of designs", "chosen", "residual\n[sd]"]
    parts: list[Part] = [
        Table(measured, facts, left=(0, 1)),
        Table(["open", "unit", "90 % of designs", "chosen"], quantities, left=(0, 1)),
        Table(["unknown", "unit", "bounds", "90 % of designs", "chosen"], unknowns, left=(0, 1)),
        ("What to measure next, the most informative first:", "bold"),
        *map(_told, found.next[:MEASUREMENTS]),
        *((warning, "yellow") for warning in found.warnings),
        (f"{designs}, {computed}, seed {found.seed}, {found.seconds:.1f} s.", "green"),
    ]
    bars = [
        (one.text, one.interval[0] / one.interval[1], one.interval[2] / one.interval[1]) for one in found.quantities
    ]
    title = f"{robot.name}, {joints}: {len(found.members)} designs that meet {counted(len(found.space.sd), 'value')}"
    return Card(title, parts, partial(bars_svg, bars, "90 % interval over the median"))


def fact_text(fact: Mapping[str, Any]) -> str:
    """Return the name of a measured value: quantity, joint, side and pressure."""
    falling = ", falling" if fact["branch"] == BRANCHES[1] else ""
    return f"{fact['joint']}, {fact['side']}, {fact['pressure_kpa']:g} kPa{falling}: {fact['kind']}"


def _told(measurement: Next) -> str:
    """Return as text the expected readings of a measurement, and the quantities that it narrows."""
    expected = ", or ".join(f"{low:.3g} to {high:.3g}" for low, high in measurement.expected)
    narrows = list(measurement.narrows.items())
    parts = [f"{text} to {100 * ratio:.0f} %" for text, ratio in narrows[:NARROWED]]
    parts += [f"{len(narrows) - NARROWED} more"] * (len(narrows) > NARROWED)
    narrowed = ", ".join(parts) or "nothing by a tenth"
    return f"{measurement.bits:4.1f} bits  {measurement.text}: {expected} {measurement.unit}. It narrows {narrowed}."


@cards.of(SpringFit)
def spring_card(fit: SpringFit) -> Card:
    """Show a spring: stiffness, zero and cubic term with intervals, and how well they meet the angles."""
    low, high = map(math.degrees, fit.zero_interval)
    rows = [
        ("stiffness", fit.stiffness, fit.stiffness_interval, "N m/rad"),
        ("angle without a load", math.degrees(fit.zero), (low, high), "deg"),
        *[("cubic term", fit.cubic, fit.cubic_interval, "N m/rad^3")] * (fit.cubic > 0),
    ]
    cells = [[name, f"{value:.4g}", f"{ends[0]:.4g} .. {ends[1]:.4g}", unit] for name, value, ends, unit in rows]
    parts: list[Part] = [
        Table(["", "value", "95 % interval", "unit"], cells, left=(0, 3)),
        f"standard deviation of the stiffness: {fit.stiffness_sd:.2g} N m/rad",
        f"rms of the angles' residuals: {math.degrees(fit.rms):.2g} deg",
    ]
    if fit.softens:
        text = "The spring softens at larger angles, which [hinge] cannot describe: hang smaller weights."
        parts.append((text, "yellow"))
    elif fit.cubic:
        straight = f"Without a cubic term the rms is {math.degrees(fit.rms_straight):.2g} deg"
        parts.append(f"{straight}: so much more by chance in {100 * fit.chance:.1g} % (F test).")
    elif math.isfinite(fit.chance):
        parts.append(f"A cubic term is not significant: chance {fit.chance:.2g}, above {SIGNIFICANT} (F test).")
    angles = np.degrees([fit.test.angle, fit.test.angle - fit.residual]).T.tolist()
    title = f"Spring of a hinge: {counted(len(fit.test.angle), 'row')} of {fit.test.file}"
    return Card(title, parts, partial(computed_svg, angles, "angle [deg]", "a row of the test"))
