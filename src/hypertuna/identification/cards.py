"""What notebooks and shells show of a fit."""

from hypertuna.display import Card, number
from hypertuna.identification.identify import Fit
from hypertuna.identification.posterior import Posterior
from hypertuna.identification.residuals import LABELS
from hypertuna.identification.tables import coefficient_table


def fit_card(fit: Fit) -> Card:
    """Show the coefficients with their intervals, the errors, and the warnings."""
    columns, rows = coefficient_table(fit)
    counts = zip(("training", "validation"), fit.trials, strict=True)
    facts = [("runs", ", ".join(f"{len(trials.runs)} for {name}" for name, trials in counts if trials.runs))]
    for name, part in fit.parts.items():
        for key, rms in list(part.rms.items())[:2]:
            label, unit, factor = LABELS[key]
            facts.append((f"{label} error, {name}", number(factor * rms, f"{unit} rms")))
    text = " ".join([f"{fit.stop}", *fit.warnings])
    title = f"Fit of {len(fit.free)} coefficients of {fit.described.name}{'' if fit.converged else ', not converged'}"
    return Card(title, facts, text, columns, [[str(cell) for cell in row] for row in rows])


def posterior_card(sampled: Posterior) -> Card:
    """Show the intervals of the coefficients, and how long the chain is."""
    columns = ("coefficient", "2.5 %", "97.5 %", "unit")
    rows = [
        (free.name, number(free.border[1] * low), number(free.border[1] * high), free.border[0].removeprefix("1"))
        for free, low, high in zip(sampled.free, sampled.low, sampled.high, strict=True)
    ]
    facts = [("steps", f"{sampled.steps}"), ("walkers", f"{sampled.walkers}")]
    facts.append(("accepted", number(100 * sampled.acceptance, "%")))
    return Card(f"Posterior of {len(sampled.free)} coefficients", facts, sampled.sentence, columns, rows)
