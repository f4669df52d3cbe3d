"""The ledger: every number of the paper that the model can answer, computed beside published, with a verdict."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.paper import computed as published_twins
from hypertuna.paper.chapters import actuator as reproduce_actuator
from hypertuna.paper.chapters import coefficients as reproduce_fit
from hypertuna.paper.chapters import diving as reproduce_diving
from hypertuna.paper.chapters import fig12 as reproduce_fig12
from hypertuna.paper.chapters import finite_elements as reproduce_fe
from hypertuna.paper.chapters import gaits as reproduce_gaits
from hypertuna.paper.chapters import lake as reproduce_lake
from hypertuna.paper.chapters import optima as reproduce_optima
from hypertuna.paper.chapters import others as reproduce_others
from hypertuna.paper.chapters import tank as reproduce_tank
from hypertuna.paper.chapters import turning as reproduce_turning
from hypertuna.paper.chapters import twin as reproduce_twin
from hypertuna.paper.computed import AS_PRINTED, MODELS, SPEEDS, Trial, swim_published
from hypertuna.paper.ledger import RULES, VERDICTS, Entry, judge, published
from hypertuna.reports.html import Section
from hypertuna.simulation.dive import Dive

__all__ = ["Ledger", "ledger_record", "ledger_sections", "reproduce"]


@dataclass(frozen=True)
class Ledger:
    """All entries, what they add up to, and the computations behind them by model."""

    entries: tuple[Entry, ...]
    summary: dict[str, Any]
    provenance: dict[str, str]
    trials: dict[str, Trial]
    fits: reproduce_fit.Fits
    optima: reproduce_optima.Optima
    bends: reproduce_actuator.Bends
    elements: reproduce_fe.Elements
    lake: reproduce_lake.Lake
    twins: published_twins.Twins
    dive: Dive
    full: bool


def reproduce(*, full: bool = False, progress: Callable[[int, int], None] | None = None) -> Ledger:
    """Compute the paper's numbers.

    Parameters
    ----------
    full : bool
        Also under the areas as Table II prints them, nine coefficients sought from more starts, finite elements anew
        where the extra `fe` is installed, and the twin with oil lines of other bores.
    progress : callable, optional
        Called with the number of steps done and their total.

    Returns
    -------
    Ledger
    """
    paper, robot = published(), load("hypertuna")
    steps = iter(range(1, 100))
    elements = reproduce_fe.read_elements()
    total = 2 * len(MODELS) + 7 + (len(AS_PRINTED) + elements.count if full else 0)

    def step() -> None:
        if progress is not None:
            progress(next(steps), total)

    trials = swim_published(robot, paper, full=full, progress=step)
    fits = reproduce_fit.fit_published(trials, paper, starts=4 if full else 1, progress=step)
    optima = reproduce_optima.seek(trials, step)
    bends = reproduce_actuator.bend_published(robot)
    step()
    if full:
        elements = reproduce_fe.solve_elements(elements, step)
    twins = published_twins.run_published(robot, paper, full=full, progress=step)
    diving = reproduce_diving.dive_published(robot, paper)
    lake = reproduce_lake.fly_lake() if full else reproduce_lake.read_lake()
    step()
    chapters = (reproduce_gaits, reproduce_tank, reproduce_turning)
    findings = [found for chapter in chapters for found in chapter.findings(trials, paper)]
    findings += reproduce_fit.findings(fits)
    findings += reproduce_optima.findings(optima)
    findings += reproduce_actuator.findings(bends)
    findings += reproduce_fe.findings(elements)
    findings += reproduce_twin.findings(twins, paper)
    findings += reproduce_diving.findings(diving)
    findings += reproduce_lake.findings(lake)
    order = list(paper["values"])
    entries = tuple(judge(paper, found) for found in sorted(findings, key=lambda found: order.index(found.id)))
    made_by = provenance(robot)
    for key in ("joints", "areas"):  # each entry names its own
        del made_by[key]
    return Ledger(entries, _summary(entries), made_by, trials, fits, optima, bends, elements, lake, twins, diving, full)


def ledger_record(ledger: Ledger) -> dict[str, Any]:
    """Say a ledger, for programs.

    Parameters
    ----------
    ledger : Ledger

    Returns
    -------
    dict
        What made it, its summary, the rules of the verdicts, the entries.
    """
    rules = [asdict(rule) for rule in RULES]
    entries = [asdict(entry) for entry in ledger.entries]
    return ledger.provenance | {"summary": ledger.summary, "rules": rules, "entries": entries}


def ledger_sections(ledger: Ledger) -> list[Section]:
    """Tell and draw what was computed, in the order of the paper.

    Parameters
    ----------
    ledger : Ledger

    Returns
    -------
    list of Section
    """
    trials, paper = ledger.trials, published()
    return [
        *reproduce_gaits.sections(trials, paper),
        *reproduce_tank.sections(trials, paper),
        *reproduce_fit.sections(ledger.fits, trials, paper),
        *reproduce_fig12.sections(ledger.fits.nine, trials, paper),
        *reproduce_optima.sections(ledger.optima, trials, paper),
        *reproduce_actuator.sections(ledger.bends),
        *reproduce_fe.sections(ledger.elements),
        *reproduce_twin.sections(ledger.twins, paper),
        *reproduce_turning.sections(trials, paper),
        *reproduce_diving.sections(ledger.dive),
        *reproduce_lake.sections(ledger.lake),
        reproduce_gaits.range_section(trials, paper),
        *reproduce_others.sections(trials, paper),
    ]


def _summary(entries: tuple[Entry, ...]) -> dict[str, Any]:
    """Add up: errors of the eight speeds by model, verdicts."""
    speeds: dict[str, list[Entry]] = {}
    for entry in entries:
        if entry.id.removeprefix("speed/") in SPEEDS:
            speeds.setdefault(entry.model, []).append(entry)
    errors = {model: np.array([entry.relative_error for entry in part], float) for model, part in speeds.items()}
    verdicts = [entry.verdict for entry in entries]
    return {
        "speeds": {
            model: {
                "rms_relative_error": float(np.sqrt(np.mean(error**2))),
                "largest_relative_error": float(np.abs(error).max()),
                "largest_at": speeds[model][int(np.abs(error).argmax())].id,
            }
            for model, error in errors.items()
        },
        "verdicts": {verdict: verdicts.count(verdict) for verdict in VERDICTS},
    }
