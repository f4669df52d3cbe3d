"""The turning test of section III.G."""

from collections.abc import Iterator

import numpy as np

from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import OURS, PAPER, Trial
from hypertuna.paper.ledger import Finding, published, published_value
from hypertuna.reports.html import WIDTH, Section
from hypertuna.swimming.turn import fit_circle, nose_path, point_radius


def findings(trials: Trials) -> Iterator[Finding]:
    """Yield turning radii and the phase of the tightest turn."""
    for model, trial in trials.items():
        yield from _turning(model, trial)


def sections(trials: Trials) -> list[Section]:
    """Show the turning test."""
    from hypertuna.swimming.plots_turn import plot_turning

    ours, point = trials[OURS], (published_value("turning/best-phase"), published_value("turning/radius-bl"))
    swept = {model: trials[model].turning for model in (PAPER, OURS)}
    figures = {"turning": plot_turning(swept, ours.robot.body.length, published=point, width=WIDTH)}
    radius, best = _turning(OURS, ours)
    return compose("turning", figures, phase=point[0], published=point[1], radius=radius, best=best)


def _turning(model: str, trial: Trial) -> Iterator[Finding]:
    """Yield the turning radius of the published gait, and the phase of the tightest turn."""
    length, turn = trial.robot.body.length, trial.gaits["turning"]
    grid = trial.turning.isel(frequency=0, amplitude=0, bias=0)
    radius, forward = grid.turn_radius.values / length, grid.speed.values > 0
    phases = published()["turning"]["phase_deg"]
    first = np.where(forward, radius, np.inf).argmin()
    center = point_radius(turn, trial.robot.links.com[0]) / length
    circle = fit_circle(nose_path(turn)).radius / length
    note = (
        f"mean distance of the nose from the center of the turn (circle fitted to its path: {circle:.3g} BL; center of "
        f"the head: {center:.3g} BL); swims {_way(turn.speed > 0)} at {abs(turn.speed):.2g} m/s. "
        f"The tightest turn that swims forward: {radius[first]:.3g} BL at {phases[first]:g} deg"
    )
    yield Finding("turning/radius-bl", model, turn.turn_radius / length, note)
    best = int(radius.argmin())
    note = f"swims {_way(forward[best])} there; radii of the grid are {radius.min():.2f} to {radius.max():.2f} BL"
    yield Finding("turning/best-phase", model, float(phases[best]), note)


def _way(forward: bool) -> str:
    """Name a direction of swimming."""
    return "forward" if forward else "tail first"


CHAPTER = Chapter("turning", sections, findings)
