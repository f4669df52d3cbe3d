"""What notebooks and shells show of a fit to bench runs, and of a family of actuators."""

from functools import partial

import numpy as np

from hypertuna.characterization.data import KINDS
from hypertuna.characterization.family import Family
from hypertuna.characterization.fit import BenchFit
from hypertuna.display import Card, number
from hypertuna.pictures import bars_svg, computed_svg


def bench_card(fit: BenchFit) -> Card:
    """Show the unknowns with their intervals, the errors, and the warnings."""
    facts = [("rows", f"{len(fit.bench.angle)}")]
    for kind, level in fit.rms.items():
        facts.append((f"{kind} error", number(KINDS[kind].factor * level, f"{KINDS[kind].unit} rms")))
    rows = [
        (
            one["name"],
            number(one["value"], one["unit"].removeprefix("1")),
            f"{number(one['low'])} to {number(one['high'])}",
            "yes" if one["determined"] else "no",
        )
        for one in fit.parameters
    ]
    title = f"Fit of {len(fit.free)} unknowns of {fit.described.name}{'' if fit.converged else ', not converged'}"
    bent = np.isfinite(fit.bench.angle)
    angles = np.degrees([fit.bench.angle[bent], fit.angle[bent]]).T.tolist()
    picture = partial(computed_svg, angles, "bend [deg]", "a row of the bench")
    columns = ("unknown", "value", "95 % interval", "determined")
    return Card(title, facts, " ".join([fit.stop, *fit.warnings]), columns, rows, picture)


def family_card(family: Family) -> Card:
    """Show what the bench leaves open, and the most informative measurements."""
    rows = [
        (one.text, number(one.interval[1], one.unit), f"{number(one.interval[0])} to {number(one.interval[2])}")
        for one in family.quantities
    ]
    facts = [("members", f"{len(family.members)}"), ("measured values", f"{len(family.space.sd)}")]
    text = f"The most informative measurement is: {family.next[0].text}." if family.next else ""
    title = f"Family of {family.space.robot.name}: designs that meet the bench"
    bars = [
        (one.text, one.interval[0] / one.interval[1], one.interval[2] / one.interval[1]) for one in family.quantities
    ]
    picture = partial(bars_svg, bars, "90 % interval over the median")
    return Card(title, facts, text, ("open", "median", "90 % interval"), rows, picture)
