"""What notebooks and shells show of a fit to bench runs."""

from functools import partial

import numpy as np

from hypertuna.characterization.fit import NOISE, BenchFit
from hypertuna.display import Card, number
from hypertuna.pictures import computed_svg


def bench_card(fit: BenchFit) -> Card:
    """Show the unknowns with their intervals, the errors, and the warnings."""
    facts = [("rows", f"{len(fit.bench.angle)}")]
    for kind, level in fit.rms.items():
        unit, factor = NOISE[kind]
        facts.append((f"{kind} error", number(factor * level, f"{unit} rms")))
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
    angles = np.degrees([fit.bench.angle, fit.angle]).T.tolist()
    picture = partial(computed_svg, angles, "bend [deg]", "a row of the bench")
    columns = ("unknown", "value", "95 % interval", "determined")
    return Card(title, facts, " ".join([fit.stop, *fit.warnings]), columns, rows, picture)
