"""What notebooks and shells show of a fit."""

from hypertuna.display import Card, number
from hypertuna.identification.identify import Fit
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
