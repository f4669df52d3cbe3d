"""The page on a fit: coefficients, their uncertainty, residuals, and how the fit was made."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from hypertuna.description.provenance import provenance
from hypertuna.identification.identify import Fit
from hypertuna.identification.plots import plot_correlation, plot_errors, plot_intervals, plot_measured
from hypertuna.identification.posterior import Posterior
from hypertuna.identification.residuals import ERRORS, LABELS
from hypertuna.identification.tables import coefficient_table, criteria_texts, error_table, law_table
from hypertuna.reports.html import WIDTH, Fact, Part, Picture, Section, Table, write_page
from hypertuna.trials.comparison import replay_recording, with_fitted_clock
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
    known = sum(d.determined for d in fit.uncertainty.directions)
    facts.append(Fact(f"{known} of {len(fit.free)}", "directions that the runs determine"))
    files = fit.robot.fit.trials if fit.robot.fit else ""
    lede = f"{len(fit.free)} coefficients of {fit.robot.name}, {best} water law, fitted to {files}."
    sections = [*([_laws(fits, best)] if len(fits) > 1 else []), *fit_sections(fit, sampled=sampled, command=command)]
    return write_page(f"Fit of {fit.robot.name}", sections, path, lede=lede, facts=facts)


def fit_sections(fit: Fit, *, sampled: Posterior | None = None, command: str = "") -> list[Section]:
    """Return the sections of a page on a fit."""
    return [_values(fit, sampled), _directions(fit), _residuals(fit), _provenance(fit, sampled, command)]


def _laws(fits: Mapping[str, Fit], best: str) -> Section:
    """Compare water laws."""
    shows = f"Water laws fitted to the same runs; the {best} law has the lower criterion."
    made = "AICc and BIC of the training runs: only differences count, 10 and more are clear."
    return Section("Which water law", [Table(*law_table(fits), shows, made)])


def _values(fit: Fit, sampled: Posterior | None) -> Section:
    """Show values and intervals."""
    made = (
        "Intervals from the Jacobian at the fit, Student's t, held within the bounds. Not determined: the interval is "
        "longer than the value (than a tenth of the allowed range for values near 0; than 0.1 s for a time offset, and "
        "5.7 deg for a phase offset)."
    )
    figure = plot_intervals(fit, sampled=sampled, width=WIDTH)
    parts: list[Part] = [
        Picture("intervals", figure, "Every coefficient with its 95 % interval between its bounds.", made),
        Table(*coefficient_table(fit, sampled), "The fitted coefficients."),
    ]
    return Section("Coefficients", [*parts, *fit.warnings])


def _directions(fit: Fit) -> Section:
    """Show which directions the runs determine."""
    rows: list[list[str | float]] = [
        [d.sentence, "yes" if d.determined else "no", d.singular_value] for d in fit.uncertainty.directions
    ]
    missing = sum(not d.determined for d in fit.uncertainty.directions)
    text = (
        "Every direction is determined: the runs identify all combinations of the coefficients."
        if not missing
        else f"{missing} of {len(rows)} directions are unidentifiable: coefficients can move together along them, "
        "and the runs would look the same within their noise. Single values are then no properties of the water."
    )
    shows = "Directions in the space of the coefficients, from the best to the least determined."
    made = "Singular value decomposition of the weighted Jacobian; each is the inverse of a standard deviation."
    picture = Picture(
        "correlation",
        plot_correlation(fit, width=WIDTH),
        "Correlation of the coefficients' errors: near 1 or -1, the runs determine only a combination of the two.",
        "From the covariance of the linearized fit.",
    )
    return Section(
        "What the runs determine",
        [text, Table(["in words", "determined", "singular value"], rows, shows, made), picture],
    )


def _residuals(fit: Fit) -> Section:
    """Show computed beside measured."""
    parts: list[Part] = []
    if any(trials.steady for trials in fit.trials):
        shows = "Computed against measured: on the line they agree."
        made = "Settled beats with the fitted coefficients; validation runs were not fitted."
        parts.append(Picture("measured", plot_measured(fit, width=WIDTH), shows, made))
    shows = "Error of every run."
    made = "Computed minus measured; of tracked runs the rms over all frames, seen from each run's first frame."
    parts.append(Picture("errors", plot_errors(fit, width=WIDTH), shows, made))
    parts += _tracked(fit)
    parts.append(Table(*error_table(fit), "Errors of all runs together."))
    parts.append(_runs(fit))
    return Section("Computed and measured", parts)


def _tracked(fit: Fit) -> list[Part]:
    """Draw replays with the fitted robot over the tracks, of training and of validation."""
    by_name: dict[str, Recording] = {}
    for recording in (recording for trials in fit.trials for recording in trials.recordings):
        before = by_name.get(recording.name)
        tracks = (*(before.tracks if before else ()), *recording.tracks)
        by_name[recording.name] = replace(recording, tracks=tracks)
    recordings = [with_fitted_clock(fit.robot, recording) for recording in by_name.values()]
    replayed = [(recording, replay_recording(fit.robot, recording)) for recording in recordings]
    complete = [pair for pair in replayed if pair[1].attrs["status"] == "completed"]
    if not complete:
        return []
    shows = "Tracked runs and the fitted model: the pose of the head's center, seen from its start."
    made = "Replay of the measured joint angles from rest, with the fitted coefficients and time offsets."
    recordings, results = [pair[0] for pair in complete], [pair[1] for pair in complete]
    return [Picture("tracked", plot_recordings(fit.robot, recordings, results, width=WIDTH), shows, made)]


def _runs(fit: Fit) -> Table:
    """List the errors of every run, the worst first: by its largest error, each in units of the rms of the training."""
    keys = fit.quantities
    rms = {key: fit.train.rms.get(key) or 1.0 for key in keys}
    ranked: list[tuple[float, list[str | float]]] = []
    for name, part in fit.parts.items():
        for run in part.runs:
            error = {key: run.get(key, run.get(f"{key}_rms", np.nan)) for key in keys}
            badness = max((abs(e) / rms[key] for key, e in error.items() if np.isfinite(e)), default=np.inf)
            cells = [LABELS[key][2] * error[key] for key in keys]
            ranked.append((badness, [run["run"], f"{name}{', ' * ('status' in run)}{run.get('status', '')}", *cells]))
    columns = ["run", "part", *(f"{LABELS[key][0]} ({LABELS[key][1]})" for key in keys)]
    rows = [row for _, row in sorted(ranked, key=lambda pair: -pair[0])]
    shows = "Error of every run, the worst first."
    made = "Computed minus measured; of tracked runs the rms over all frames."
    return Table(columns, rows, shows, made, folded=f"All {len(rows)} runs, the worst first")


def _provenance(fit: Fit, sampled: Posterior | None, command: str) -> Section:
    """Show how the fit was made."""
    runs = [len(trials.runs) for trials in fit.trials]
    noise = ", ".join(
        f"{LABELS[ERRORS[name]][2] * level:.2g} {LABELS[ERRORS[name]][1]} ({LABELS[ERRORS[name]][0]})"
        if name != "yaw"
        else f"{np.degrees(level):.2g} deg (yaw)"
        for name, level in fit.noise.items()
    )
    texts: list[Part] = [
        f"{runs[0]} runs for the fit, {runs[1]} chosen at random (seed {fit.seed}) for validation; loss {fit.loss}. "
        f"{fit.stop}",
        f"Noise estimated from the residuals: {noise}." if noise else "The trials have the noise of every run.",
    ]
    if sampled is not None:
        texts.append(
            f"Posterior: {sampled.walkers} walkers of {sampled.steps} steps, {100 * sampled.acceptance:.0f} % "
            f"accepted. {sampled.sentence}"
        )
    aicc, bic = criteria_texts(fit)
    if fit.criteria["samples"] is not None:  # a loss that is no likelihood has no criteria
        texts.append(f"AICc {aicc}, BIC {bic} with {fit.criteria['samples']} independent measurements.")
    made = provenance(fit.described)
    rows: list[list[str | float]] = [
        ["command", f"`{command}`" if command else "called from Python"],
        ["robot as described", f"{made['robot']}, {made['robot_file'] or 'no file'}, sha256 {made['robot_hash']}"],
        ["fitted robot", f"sha256 {fit.robot.hash}"],
        ["model", f"{made['water']} water, {made['joints']} joints, {made['areas']} areas"],
        ["loss, seed, starts", f"{fit.loss}, {fit.seed}, {len(fit.costs)}"],
        ["made by", f"hypertuna {made['hypertuna_version']} ({made['isa']}), {datetime.date.today().isoformat()}"],
    ]
    texts.append(Table(["what", ""], rows, "What made this page."))
    return Section("How it was made", texts)
