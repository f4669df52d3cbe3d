"""Tables of a fit, as heads and rows for terminals and pages."""

import math
from collections.abc import Mapping
from typing import Any

from hypertuna.identification.identify import Fit
from hypertuna.identification.posterior import Posterior
from hypertuna.identification.residuals import LABELS

Table = tuple[list[str], list[list[str | float]]]  # heads, rows


def coefficient_table(fit: Fit, sampled: Posterior | None = None) -> Table:
    """Tabulate the coefficients with their intervals, also those of the posterior if given."""
    samples = [] if sampled is None else sampled.record["parameters"]
    rows: list[list[str | float]] = []
    for k, row in enumerate(fit.parameters):
        remark = f"on its {row['bound']} bound" if row["bound"] else "" if row["constrained"] else "not constrained"
        intervals = map(_interval, (row, *samples[k : k + 1]))
        rows.append([row["name"], f"{row['value']:.5g}", *intervals, _unit(row), remark])
    return ["coefficient", "value", "95 % interval", *(["posterior"] if samples else []), "unit", ""], rows


def _interval(row: Mapping[str, Any]) -> str:
    """Return an interval as text; "none" without one."""
    return "none" if math.isnan(row["low"]) else f"{row['low']:.4g} .. {row['high']:.4g}"


def _unit(row: Mapping[str, Any]) -> str:
    """Return the unit of a coefficient as text, empty for 1; a common factor multiplies the described values."""
    return "x described" if row["name"].endswith("=common") else row["unit"].removeprefix("1")


def error_table(fit: Fit) -> Table:
    """Tabulate the errors over all runs, for training and for validation."""
    rows: list[list[str | float]] = []
    for key in fit.quantities:
        label, unit, factor = LABELS[key]
        errors = (factor * error.get(key, math.nan) for part in fit.parts.values() for error in (part.rms, part.max))
        rows.append([f"{label} ({unit})", *errors])
    return ["error", *(head for name in fit.parts for head in (f"{name} rms", "max"))], rows


def law_table(fits: Mapping[str, Fit]) -> Table:
    """Tabulate criteria and errors of several water laws."""
    keys = [key for key in LABELS if any(key in fit.quantities for fit in fits.values())]
    rows: list[list[str | float]] = []
    for law, fit in fits.items():
        rms = (fit.validation or fit.train).rms
        errors = (LABELS[key][2] * rms.get(key, math.nan) for key in keys)
        rows.append([law, str(len(fit.free)), *criteria_texts(fit), *errors])
    labels = (f"{LABELS[key][0]}, validation rms ({LABELS[key][1]})" for key in keys)
    return ["water law", "coefficients", "AICc", "BIC", *labels], rows


def criteria_texts(fit: Fit) -> list[str]:
    """Return AICc and BIC as texts, "-" if they are not defined."""
    return ["-" if fit.criteria[name] is None else f"{fit.criteria[name]:.1f}" for name in ("aicc", "bic")]
