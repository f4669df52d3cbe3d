"""The turning test of section III.G."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hypertuna.paper.computed import OURS, PAPER, Trial
from hypertuna.paper.ledger import Finding
from hypertuna.reports.html import WIDTH, Picture, Section
from hypertuna.swimming.turn import fit_circle, nose_path, point_radius

__all__ = ["findings", "sections"]


def findings(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield turning radii and the phase of the tightest turn.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping

    Yields
    ------
    Finding
    """
    for model, trial in trials.items():
        yield from _turning(model, trial, paper)


def sections(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> list[Section]:
    """Show the turning test.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping

    Returns
    -------
    list of Section
    """
    from hypertuna.swimming.plots_turn import plot_turning

    ours = trials[OURS]
    point = paper["values"]["turning/best-phase"]["value"], paper["values"]["turning/radius-bl"]["value"]
    shown = {model: trials[model].turning for model in (PAPER, OURS)}
    picture = Picture(
        "turning",
        plot_turning(shown, ours.robot.body.length, published=point, width=WIDTH),
        "Mean distance of the nose from the center of the turn against the phase difference; open marks swim tail "
        "first.",
        "One-sided settled beats at 2 Hz and large amplitude, bias equal to amplitude; the star is Fig. 14(b)'s.",
    )
    radius, best = _turning(OURS, ours, paper)
    text = f"""The paper found its tightest turn at {point[0]:g} deg, with a radius of {point[1]:g} BL; the model's is
at {best.computed:g} deg on the same grid. There its radius is {radius.computed:.3g} BL: {radius.note}."""
    return [Section("Turning", [picture, text])]


def _turning(model: str, trial: Trial, paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield the turning radius of the published gait, and the phase of the tightest turn."""
    length, done = trial.robot.body.length, trial.gaits["turning"]
    around = trial.turning.isel(frequency=0, amplitude=0, bias=0)
    radius, ahead = around.turn_radius.values / length, around.speed.values > 0
    phases = paper["turning"]["phase_deg"]
    way = "forward" if done.speed > 0 else "tail first"
    first = np.where(ahead, radius, np.inf).argmin()
    center = point_radius(done, trial.robot.links.com[0]) / length
    circle = fit_circle(nose_path(done)).radius / length
    note = (
        f"mean distance of the nose from the center of the turn (circle fitted to its path: {circle:.3g} BL; center of "
        f"the head: {center:.3g} BL); swims {way} at {abs(done.speed):.2g} m/s. "
        f"The tightest turn that swims forward: {radius[first]:.3g} BL at {phases[first]:g} deg"
    )
    yield Finding("turning/radius-bl", model, done.turn_radius / length, note)
    best = int(radius.argmin())
    note = f"swims {'forward' if ahead[best] else 'tail first'} there; radii of the grid are {np.min(radius):.2f} to "
    yield Finding("turning/best-phase", model, float(phases[best]), f"{note}{np.max(radius):.2f} BL")
