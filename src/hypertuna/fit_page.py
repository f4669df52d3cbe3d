"""The page on a fit: what was found, how certain it is, and how it was made."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from hypertuna.agreement import ERRORS, LABELS
from hypertuna.identify import Fit
from hypertuna.plots_fit import plot_correlation, plot_errors, plot_intervals, plot_measured
from hypertuna.posterior import Posterior
from hypertuna.report import WIDTH, Fact, Part, Picture, Section, Table, write_page

__all__ = ["fit_sections", "write_fit"]


def write_fit(fits: Mapping[str, Fit], best: str, path: str | Path, *, sampled: Posterior | None = None) -> Path:
    """Write a page on a fit, or on several of different water laws.

    Parameters
    ----------
    fits : mapping of Fit
        By water law.
    best : str
        The law to tell of.
    path : str or Path
    sampled : Posterior, optional
        Of the best fit.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    fit = fits[best]
    judged = fit.validation or fit.train
    told = "runs that it had not seen" if fit.validation else "the runs that it was fitted to"
    facts = [
        Fact(f"{LABELS[key][2] * value:.2g} {LABELS[key][1]}", f"rms error of {LABELS[key][0]} in {told}")
        for key, value in judged.rms.items()
    ]
    known = sum(d.determined for d in fit.certainty.directions)
    facts.append(Fact(f"{known} of {len(fit.free)}", "directions that the runs determine"))
    files = fit.robot.fit.trials if fit.robot.fit else ""
    lede = f"{len(fit.free)} coefficients of {fit.robot.name}, {best} water law, fitted to {files}."
    sections = [*([_laws(fits, best)] if len(fits) > 1 else []), *fit_sections(fit, sampled=sampled)]
    return write_page(f"Fit of {fit.robot.name}", sections, path, lede=lede, facts=facts)


def fit_sections(fit: Fit, *, sampled: Posterior | None = None) -> list[Section]:
    """Write the sections of a page on a fit.

    Parameters
    ----------
    fit : Fit
    sampled : Posterior, optional

    Returns
    -------
    list of Section
    """
    return [_values(fit, sampled), _open(fit), _agreement(fit), _made(fit, sampled)]


def _laws(fits: Mapping[str, Fit], best: str) -> Section:
    """Compare water laws."""
    keys = [key for key in LABELS if any(key in fit.train.rms for fit in fits.values())]
    rows: list[list[str | float]] = []
    for law, fit in fits.items():
        judged = (fit.validation or fit.train).rms
        rows.append([law, len(fit.free), *_criteria(fit), *(LABELS[key][2] * judged.get(key, np.nan) for key in keys)])
    columns = ["law", "coefficients", "AICc", "BIC", *(f"{LABELS[key][0]}, rms ({LABELS[key][1]})" for key in keys)]
    shows = f"Water laws fitted to the same runs; the {best} law has the lower criterion."
    made = (
        "AICc and BIC of the training runs: only differences count, 10 and more are clear. Errors of validation runs."
    )
    return Section("Which water law", [Table(columns, rows, shows, made)])


def _criteria(fit: Fit) -> list[str]:
    """Return criteria as text."""
    values = (fit.criteria["aicc"], fit.criteria["bic"])
    return ["-" if value is None else f"{value:.1f}" for value in values]


def _values(fit: Fit, sampled: Posterior | None) -> Section:
    """Values and intervals."""
    sure = fit.certainty
    columns = ["coefficient", "value", "95 % interval", "unit", ""]
    rows: list[list[str | float]] = []
    for k, f in enumerate(fit.free):
        factor, unit = (180 / np.pi, "deg") if f.unit == "rad" else (1.0, f.unit)
        remark = f"on its {sure.bound[k]} bound" if sure.bound[k] else "" if sure.determined[k] else "not determined"
        ends = f"{factor * sure.low[k]:.3g} to {factor * sure.high[k]:.3g}"
        rows.append([f.name, f"{factor * fit.values[k]:.4g}", ends, unit, remark])
        if sampled is not None:
            rows[-1].insert(3, f"{factor * sampled.low[k]:.3g} to {factor * sampled.high[k]:.3g}")
    if sampled is not None:
        columns.insert(3, "posterior")
    made = (
        "Intervals from the Jacobian at the fit, Student's t, held within the bounds. Not determined: the interval is "
        "longer than the value (than a tenth of the allowed range for values near 0)."
    )
    figure = plot_intervals(fit, sampled=sampled, width=WIDTH)
    parts: list[Part] = [
        Picture("intervals", figure, "Every coefficient with its 95 % interval between its bounds.", made),
        Table(columns, rows, "The fitted coefficients."),
    ]
    return Section("Coefficients", [*parts, *fit.warnings])


def _open(fit: Fit) -> Section:
    """Say what the runs determine, and what not."""
    rows: list[list[str | float]] = [
        [k + 1, "yes" if d.determined else "no", d.singular_value, d.sentence]
        for k, d in enumerate(fit.certainty.directions)
    ]
    missing = sum(not d.determined for d in fit.certainty.directions)
    text = (
        "Every direction is determined: no combination of coefficients is left open by the runs."
        if not missing
        else f"{missing} of {len(rows)} directions are open: along them coefficients can move together, and the runs "
        "would look the same within their noise. Single values are then no properties of the water."
    )
    shows = "Directions in the space of the coefficients, from the best known to the least known."
    made = "Singular value decomposition of the weighted Jacobian; each is the inverse of a standard deviation."
    picture = Picture(
        "correlation",
        plot_correlation(fit, width=WIDTH),
        "Correlation of the coefficients' errors: near 1 or -1, the runs know only a combination of the two.",
        "From the covariance of the linearized fit.",
    )
    return Section(
        "What the runs determine",
        [text, Table(["", "determined", "singular value", "in words"], rows, shows, made), picture],
    )


def _agreement(fit: Fit) -> Section:
    """Put computed beside measured."""
    parts: list[Part] = []
    if any(trials.steady for trials in fit.trials):
        shows = "Computed against measured: on the line they agree."
        made = "Settled beats with the fitted coefficients; validation runs were not seen by the fit."
        parts.append(Picture("measured", plot_measured(fit, width=WIDTH), shows, made))
    shows = "Error of every run."
    made = "Computed minus measured; of tracked runs the rms over all frames, seen from each run's first frame."
    parts.append(Picture("errors", plot_errors(fit, width=WIDTH), shows, made))
    columns = ["", "training rms", "largest"] + (["validation rms", "largest"] if fit.validation else [])
    rows: list[list[str | float]] = []
    for key, (name, unit, factor) in LABELS.items():
        if key in fit.train.rms:
            both = [part for part in (fit.train, fit.validation) if part is not None]
            cells = [factor * found.get(key, np.nan) for part in both for found in (part.rms, part.largest)]
            rows.append([f"{name} ({unit})", *cells])
    parts.append(Table(columns, rows, "Errors of all runs together."))
    return Section("Computed and measured", parts)


def _made(fit: Fit, sampled: Posterior | None) -> Section:
    """How the fit was made."""
    runs = [len(trials.runs) for trials in fit.trials]
    noise = ", ".join(
        f"{LABELS[ERRORS[name]][2] * level:.2g} {LABELS[ERRORS[name]][1]} ({LABELS[ERRORS[name]][0]})"
        if name != "yaw"
        else f"{np.degrees(level):.2g} deg (yaw)"
        for name, level in fit.noise.items()
    )
    texts: list[Part] = [
        f"{runs[0]} runs for the fit, {runs[1]} drawn at random (seed {fit.seed}) for validation; loss {fit.loss}. "
        f"{fit.stop}",
        f"Noise estimated from the residuals: {noise}." if noise else "The trials tell the noise of every run.",
    ]
    if sampled is not None:
        texts.append(
            f"Posterior: {sampled.walkers} walkers of {sampled.steps} steps, {100 * sampled.acceptance:.0f} % of them "
            f"taken. {sampled.sentence}"
        )
    aicc, bic = _criteria(fit)
    if fit.criteria["samples"] is not None:  # a loss that is no likelihood has no criteria
        texts.append(f"AICc {aicc}, BIC {bic} with {fit.criteria['samples']} independent measurements.")
    return Section("How it was made", texts)
