"""The ledger: every number of the paper that the model can answer, computed beside published, with a verdict."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import count
from typing import Any

import numpy as np

from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.paper.chapter import Chapter, Trials
from hypertuna.paper.chapters import (
    actuator,
    budget,
    coefficients,
    diving,
    finite_elements,
    gaits,
    lake,
    optima,
    others,
    passive,
    posterior,
    seeds,
    strips,
    tank,
    turning,
    twin,
)
from hypertuna.paper.computed import AS_PRINTED, MODELS, SPEEDS, swim_published
from hypertuna.paper.ledger import CLASSES, RULES, VERDICTS, Entry, judge, published
from hypertuna.reports.html import Section

# Chapters in the order of the page; entries with the same id are in this order too.
CHAPTERS: tuple[Chapter[Any], ...] = (
    gaits.CHAPTER,
    tank.CHAPTER,
    coefficients.CHAPTER,
    optima.CHAPTER,
    actuator.CHAPTER,
    finite_elements.CHAPTER,
    twin.CHAPTER,
    seeds.CHAPTER,
    strips.CHAPTER,
    budget.CHAPTER,
    posterior.CHAPTER,
    turning.CHAPTER,
    diving.CHAPTER,
    lake.CHAPTER,
    gaits.RANGE,
    others.CHAPTER,
    passive.CHAPTER,
)


@dataclass(frozen=True)
class Ledger:
    """All entries, their summary, and the results that they come from."""

    entries: tuple[Entry, ...]
    summary: dict[str, Any]
    provenance: dict[str, str]
    trials: Trials
    results: dict[str, Any]  # of the chapters, by name
    full: bool


def reproduce(*, full: bool = False, progress: Callable[[int, int], None] | None = None) -> Ledger:
    """Compute the paper's numbers; report progress by the number of steps and their total.

    In full: also with the areas as Table II prints them, coefficients from more starts, finite elements computed again
    where the extra `fe` is installed, the lake flown again, the twin with oil lines of other bores, and the twin over
    all seeds, which are stored.
    """
    paper, robot = published(), load("hypertuna")
    steps = count(1)
    total = len(MODELS) + (len(AS_PRINTED) if full else 0)
    total += sum(chapter.full_steps if full else chapter.steps for chapter in CHAPTERS)

    def step() -> None:
        if progress is not None:
            progress(next(steps), total)

    trials = swim_published(robot, paper, full=full, progress=step)
    results = {}
    for chapter in CHAPTERS:
        results[chapter.name] = chapter.compute(trials, full, step)
        step()
    all_findings = [finding for chapter in CHAPTERS for finding in chapter.findings(results[chapter.name])]
    findings = results[budget.CHAPTER.name].judged(all_findings)
    order = list(paper["values"])
    entries = tuple(judge(paper, finding) for finding in sorted(findings, key=lambda finding: order.index(finding.id)))
    made_by = provenance(robot)
    for key in ("joints", "areas"):  # each entry's model has its own
        del made_by[key]
    return Ledger(entries, _summary(entries), made_by, trials, results, full)


def ledger_record(ledger: Ledger) -> dict[str, Any]:
    """Return the JSON record of a ledger: provenance, summary, classes, rules of the verdicts, entries."""
    rules = [asdict(rule) for rule in RULES]
    entries = [{key.rstrip("_"): value for key, value in asdict(entry).items()} for entry in ledger.entries]
    parts = {"summary": ledger.summary, "classes": CLASSES, "rules": rules, "entries": entries}
    return ledger.provenance | parts


def ledger_sections(ledger: Ledger) -> list[Section]:
    """Return the sections of all chapters, in order."""
    return [section for chapter in CHAPTERS for section in chapter.sections(ledger.results[chapter.name])]


def _summary(entries: tuple[Entry, ...]) -> dict[str, Any]:
    """Return counts of predicted and reproduced numbers and of verdicts, in all and by class, and errors of speeds.

    A number that several models predict counts once; it is reproduced if one of them reproduces it.
    """
    speeds: dict[str, list[Entry]] = {}
    for entry in entries:
        if entry.id.removeprefix("speed/") in SPEEDS and entry.relative_error is not None:
            speeds.setdefault(entry.model, []).append(entry)
    errors = {model: np.array([entry.relative_error for entry in part], float) for model, part in speeds.items()}
    classes = {name: _verdicts([entry for entry in entries if entry.class_ == name]) for name in CLASSES}
    reproduced = [entry for entry in entries if entry.verdict == "reproduced"]
    return {
        "predictions": len({entry.id for entry in entries if entry.class_ == "prediction"}),
        "reproduced": len({entry.id for entry in reproduced}),
        "reproduced_measured": len({entry.id for entry in reproduced if entry.kind == "measured"}),
        "verdicts": _verdicts(entries),
        "classes": classes,
        "speeds": {
            model: {
                "rms_relative_error": float(np.sqrt(np.mean(error**2))),
                "largest_relative_error": float(np.abs(error).max()),
                "largest_at": speeds[model][int(np.abs(error).argmax())].id,
            }
            for model, error in errors.items()
        },
    }


def _verdicts(entries: Sequence[Entry]) -> dict[str, int]:
    """Return how many entries have each verdict."""
    verdicts = [entry.verdict for entry in entries]
    return {verdict: verdicts.count(verdict) for verdict in VERDICTS}
