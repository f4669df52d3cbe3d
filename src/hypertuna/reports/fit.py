"""The page on a fit: coefficients, their uncertainty, residuals, and how the fit was made."""

import datetime
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hypertuna.description.provenance import provenance
from hypertuna.identification.identify import Fit
from hypertuna.identification.plots import plot_correlation, plot_errors, plot_intervals, plot_measured
from hypertuna.identification.posterior import Posterior
from hypertuna.identification.residuals import LABELS, NUMBERS
from hypertuna.identification.tables import coefficient_table, criteria_texts, error_table, law_table
from hypertuna.reports.html import WIDTH, Fact, Section, Shown, Table, compose, write_page
from hypertuna.trials.comparison import replay_recording, with_fitted_clock
from hypertuna.trials.kinds import QUANTITIES
from hypertuna.trials.manifest import Recording
from hypertuna.trials.plots import plot_recordings


def write_fit(
    fits: Mapping[str, Fit], best: str, path: str | Path, *, sampled: Posterior | None = None, command: str = ""
) -> Path:
    """Write a page on the best of several fits with different water laws."""
    fit = fits[best]
    errors = fit.validation or fit.train
    runs = "runs that were not fitted" if fit.validation else "the fitted runs"
    facts = [
        Fact(f"{LABELS[key][2] * value:.2g} {LABELS[key][1]}", f"rms error of {LABELS[key][0]} in {runs}")
        for key, value in errors.rms.items()
    ]
    constrained = sum(d.constrained for d in fit.uncertainty.directions)
    facts.append(Fact(f"{constrained} of {len(fit.free)}", "directions that the runs constrain"))
    files = fit.robot.fit.trials if fit.robot.fit else ""
    lede = f"{len(fit.free)} coefficients of {fit.robot.name}, {best} water law, fitted to {files}."
    sections = fit_sections(fit, sampled=sampled, command=command, laws=fits if len(fits) > 1 else {}, best=best)
    return write_page(f"Fit of {fit.robot.name}", sections, path, lede=lede, facts=facts)


def fit_sections(
    fit: Fit,
    *,
    sampled: Posterior | None = None,
    command: str = "",
    laws: Mapping[str, Fit] | None = None,
    best: str = "",
) -> list[Section]:
    """Return the sections of a page on a fit; `laws` are fits with other water laws, `best` the name of this one."""
    directions = [(d.sentence, "yes" if d.constrained else "no", d.singular_value) for d in fit.uncertainty.directions]
    shown: dict[str, Shown] = {
        "laws": Table(*law_table(laws or {})),
        "intervals": plot_intervals(fit, sampled=sampled, width=WIDTH),
        "coefficients": Table(*coefficient_table(fit, sampled)),
        "directions": Table(["in words", "constrained", "singular value"], directions),
        "correlation": plot_correlation(fit, width=WIDTH),
        "errors": plot_errors(fit, width=WIDTH),
        "totals": Table(*error_table(fit)),
        "runs": _run_table(fit),
        "provenance": _provenance_table(fit, command),
    }
    measured = any(QUANTITIES[name].key in fit.quantities for name in NUMBERS)
    if measured:
        shown["measured"] = plot_measured(fit, width=WIDTH)
    if tracked := _plot_tracked(fit):
        shown["tracked"] = tracked
    levels = ((QUANTITIES[name], level) for name, level in fit.noise.items())
    aicc, bic = criteria_texts(fit)
    return compose(
        "hypertuna.reports",
        "fit",
        shown,
        fit=fit,
        laws=laws,
        best=best,
        missing=sum(not d.constrained for d in fit.uncertainty.directions),
        measured=measured,
        tracked=tracked is not None,
        noise=", ".join(f"{q.factor * q.per_si * level:.2g} {q.shown} ({q.label})" for q, level in levels),
        sampled=sampled,
        aicc=aicc,
        bic=bic,
    )


def _plot_tracked(fit: Fit) -> Figure | None:
    """Plot replays with the fitted robot over the tracks, of training and of validation; None without any."""
    by_name: dict[str, Recording] = {}
    for recording in (recording for trials in fit.trials for recording in trials.recordings):
        earlier = by_name.get(recording.name)
        tracks = (*(earlier.tracks if earlier else ()), *recording.tracks)
        by_name[recording.name] = replace(recording, tracks=tracks)
    recordings = [with_fitted_clock(fit.robot, recording) for recording in by_name.values()]
    replayed = [(recording, replay_recording(fit.robot, recording)) for recording in recordings]
    complete = [pair for pair in replayed if pair[1].attrs["status"] == "completed"]
    if not complete:
        return None
    recordings, results = [pair[0] for pair in complete], [pair[1] for pair in complete]
    return plot_recordings(fit.robot, recordings, results, width=WIDTH)


def _run_table(fit: Fit) -> Table:
    """Return a table of the errors of every run, the worst first by its largest error over the training's rms."""
    keys = fit.quantities
    rms = {key: fit.train.rms.get(key) or 1.0 for key in keys}
    ranked = []
    for name, errors in fit.parts.items():
        for run in errors.runs:
            error = {key: run.get(key, run.get(f"{key}_rms", np.nan)) for key in keys}
            badness = max((abs(e) / rms[key] for key, e in error.items() if np.isfinite(e)), default=np.inf)
            cells = [LABELS[key][2] * error[key] for key in keys]
            ranked.append((badness, [run["run"], f"{name}{', ' * ('status' in run)}{run.get('status', '')}", *cells]))
    columns = ["run", "part", *(f"{LABELS[key][0]} ({LABELS[key][1]})" for key in keys)]
    rows = [row for _, row in sorted(ranked, key=lambda pair: -pair[0])]
    return Table(columns, rows, folded=f"All {len(rows)} runs, the worst first")


def _provenance_table(fit: Fit, command: str) -> Table:
    """Return a table of what made the fit: command, robots, model, settings, version."""
    origin = provenance(fit.described)
    facts = {
        "command": f"`{command}`" if command else "called from Python",
        "robot as described": f"{origin['robot']}, {origin['robot_file'] or 'no file'}, sha256 {origin['robot_hash']}",
        "fitted robot": f"sha256 {fit.robot.hash}",
        "model": f"{origin['water']} water, {origin['joints']} joints, {origin['areas']} areas",
        "loss, seed, starts": f"{fit.loss}, {fit.seed}, {len(fit.costs)}",
        "made by": f"hypertuna {origin['hypertuna_version']} ({origin['isa']}), {datetime.date.today().isoformat()}",
    }
    return Table(["what", ""], list(facts.items()))
