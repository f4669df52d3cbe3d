"""The turning test of section III.G."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import OURS, PAPER, Trial
from hypertuna.paper.ledger import Finding, published, published_value
from hypertuna.reports.html import WIDTH, Section
from hypertuna.swimming.turn import fit_circle, nose_path, point_radius

if TYPE_CHECKING:
    import xarray as xr

FEASIBLE = "feasible stroke"


def findings(trials: Trials) -> Iterator[Finding]:
    """Yield turning radii and the phase of the tightest turn."""
    for model, trial in trials.items():
        yield from turning_findings(model, trial)


def sections(trials: Trials) -> list[Section]:
    """Show the turning test."""
    from hypertuna.swimming.plots_turn import plot_turning

    ours, point = trials[OURS], (published_value("turning/best-phase"), published_value("turning/radius-bl"))
    swept = {model: trials[model].turning for model in (PAPER, OURS)}
    figures = {"turning": plot_turning(swept, ours.robot.body.length, published=point, width=WIDTH)}
    radius, best, *_ = turning_findings(OURS, ours)
    return compose("turning", figures, phase=point[0], published=point[1], radius=radius, best=best)


def turning_findings(model: str, trial: Trial) -> Iterator[Finding]:
    """Yield the radius at the published phase, and the phase of the tightest turn head first."""
    length, turn = trial.robot.body.length, trial.gaits["turning"]
    center = point_radius(turn, trial.robot.links.com[0]) / length
    circle = fit_circle(nose_path(turn)).radius / length
    stroke = ", ".join(f"{2 * angle:.3g}" for angle in np.degrees(turn.gait.amplitude))
    possible = ", ".join(f"{np.degrees(group.bend_max or np.nan):.3g}" for group in trial.robot.joints)
    note = (
        f"mean distance of the nose from the center of the turn (circle fitted to its path: {circle:.3g} BL; center of "
        f"the head: {center:.3g} BL); swims {_way(turn.speed > 0)} at {abs(turn.speed):.2g} m/s, with strokes of "
        f"{stroke} deg, where the joints bend by {possible} deg in air"
    )
    yield Finding("turning/radius-bl", model, "prediction", turn.turn_radius / length, note)
    yield _tightest(model, trial.turning, length)
    grid = trial.feasible.isel(frequency=0, amplitude=0, bias=0)
    tested = published()["turning"]["phase_deg"].index(published_value("turning/best-phase"))
    note = f"strokes of {possible} deg, which the joints can make; swims {_way(float(grid.speed[tested]) > 0)}"
    radius = float(grid.turn_radius[tested]) / length
    yield Finding("turning/radius-bl", f"{model}, {FEASIBLE}", "prediction", radius, note)
    yield _tightest(f"{model}, {FEASIBLE}", trial.feasible, length)


def _tightest(model: str, turns: xr.Dataset, length: float) -> Finding:
    """Return the finding on the phase of the tightest turn among those that swim head first."""
    grid, phases = turns.isel(frequency=0, amplitude=0, bias=0), published()["turning"]["phase_deg"]
    radius, forward = grid.turn_radius.values / length, grid.speed.values > 0
    first, overall = int(np.where(forward, radius, np.inf).argmin()), int(radius.argmin())
    note = (
        f"the tightest head first, {radius[first]:.3g} BL; of all {radius[overall]:.3g} BL at {phases[overall]:g} deg, "
        f"{_way(forward[overall])}"
    )
    return Finding("turning/best-phase", model, "prediction", float(phases[first]), note)


def _way(forward: bool) -> str:
    """Return "head first" or "tail first"."""
    return "head first" if forward else "tail first"


CHAPTER = Chapter("turning", sections, findings)
