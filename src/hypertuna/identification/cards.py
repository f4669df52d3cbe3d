"""Cards of a fit and of its posterior, for terminals and notebooks."""

from typing import Any

import numpy as np

from hypertuna.display import Card, Facts, Part, Table, cards, number
from hypertuna.identification.coefficients import ABSOLUTE_UNITS
from hypertuna.identification.identify import Fit
from hypertuna.identification.posterior import Posterior
from hypertuna.identification.residuals import LABELS
from hypertuna.identification.tables import coefficient_table, error_table
from hypertuna.io.quantity import counted, key_of
from hypertuna.pictures import BARS, bars_svg, captioned, computed_svg
from hypertuna.trials.kinds import KINDS


@cards.of(Fit)
def fit_card(fit: Fit) -> Card:
    """Show the coefficients with their intervals, the errors, and the warnings."""
    return sampled_card(fit, None, fit.seconds)


def sampled_card(fit: Fit, sampled: Posterior | None, seconds: float) -> Card:
    """Show a fit with the intervals of its posterior, if given; seconds: time that both took [s]."""
    fitted, held_out = (len(trials.runs) for trials in fit.trials)
    heads, rows = coefficient_table(fit, sampled)
    cells = [(str(row[0]), *map(str, row[1:-1]), (str(row[-1]), "yellow")) for row in rows]
    parts: list[Part] = [Table(heads, cells, left=(0, len(heads) - 2, len(heads) - 1), whole=0)]
    parts.append(digits_table(*error_table(fit)))
    parts += [(direction.sentence, "yellow") for direction in fit.uncertainty.directions if not direction.constrained]
    parts += [(warning, "yellow") for warning in fit.warnings]
    if sampled is not None:
        parts.append(f"{sampled.sentence} {100 * sampled.acceptance:.0f} % of the steps were accepted.")
    style = "bold red" if not fit.converged else "yellow" if "training error" in fit.stop else "green"
    parts.append((f"{fit.stop} {seconds:.1f} s in all.", style))
    runs = f"{counted(fitted, 'run')} fitted, {held_out} kept for validation"
    return Card(f"{fit.robot.name}, {fit.robot.model.water} water: {runs}", parts, lambda: _runs_svg(fit))


def digits_table(heads: list[str], rows: list[list[Any]]) -> Table:
    """Return a table whose numbers have three digits."""
    return Table(heads, [[f"{x:.3g}" if isinstance(x, float) else x for x in row] for row in rows])


def _runs_svg(fit: Fit) -> str:
    """Draw computed over measured numbers of runs as SVG, or the errors of tracked runs if there are no numbers."""
    runs = [run for part in fit.parts.values() for run in part.runs]
    for kind, quantity in ((owner, quantity) for owner in KINDS for quantity in owner.quantities):
        measured, computed = (key_of(f"{quantity.name}_{of}", quantity.unit) for of in ("measured", "computed"))
        pairs = [(run[measured], run[computed]) for run in runs if measured in run]
        if pairs:
            return computed_svg(pairs, f"{quantity.label} [{quantity.unit}]", f"a {kind.label}")
    key = next(iter(fit.quantities), "")
    errors = {run["run"]: run[f"{key}_rms"] for run in runs if f"{key}_rms" in run}
    if not errors:
        return ""
    label, unit, factor = LABELS[key]
    rows = [(name, 0.0, factor * errors[name]) for name in sorted(errors, key=lambda name: -errors[name])]
    return captioned(bars_svg(rows, f"error of {label} [{unit} rms]"), "The tracked runs, the largest error first.")


@cards.of(Posterior)
def posterior_card(sampled: Posterior) -> Card:
    """Show the intervals of the coefficients, and how long the chain is."""
    columns = ("coefficient", "2.5 %", "97.5 %", "unit")
    rows = [
        (free.name, number(free.border[1] * low), number(free.border[1] * high), free.border[0].removeprefix("1"))
        for free, low, high in zip(sampled.free, sampled.low, sampled.high, strict=True)
    ]
    facts = {"steps": f"{sampled.steps}", "walkers": f"{sampled.walkers}"}
    facts["accepted"] = number(100 * sampled.acceptance, "%")
    title = f"Posterior of {len(sampled.free)} coefficients"
    return Card(title, [Facts(facts), sampled.sentence, Table(columns, rows)], lambda: _ranges_svg(sampled))


def _ranges_svg(sampled: Posterior) -> str:
    """Draw each coefficient's interval relative to its median; an offset's is relative to its `ABSOLUTE_UNITS`."""
    medians = np.median(sampled.samples, axis=0)
    sizes = [ABSOLUTE_UNITS.get(free.column, abs(value)) for free, value in zip(sampled.free, medians, strict=True)]
    low, high = (100 * (ends - medians) / sizes for ends in (sampled.low, sampled.high))
    rows = zip((free.name for free in sampled.free), low.tolist(), high.tolist(), strict=True)
    caption = "95 % intervals around the medians, in percent of them."
    if any(free.column in ABSOLUTE_UNITS for free in sampled.free):
        caption += " Of offsets: in percent of 0.1 s or 0.1 rad."
    limit_note = f" The first {BARS} coefficients." if len(sampled.free) > BARS else ""
    return captioned(bars_svg(rows, "95 % interval around the median [%]"), caption + limit_note)
