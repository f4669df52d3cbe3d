"""Chapters of the ledger: each computes a result, yields findings on it, and shows it."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeAlias, TypeVar

from hypertuna.paper.computed import Trial
from hypertuna.paper.ledger import Finding
from hypertuna.reports import html
from hypertuna.reports.html import Section

T = TypeVar("T")
Trials: TypeAlias = Mapping[str, Trial]  # swims of all that the paper reports, by model


def _trials(trials: Trials, full: bool, step: Callable[[], None]) -> Any:
    """Return the trials as they are: the result of chapters that compute nothing else."""
    return trials


def _no_findings(result: Any) -> Iterable[Finding]:
    """Return no findings, for chapters that only show results."""
    return ()


@dataclass(frozen=True)
class Chapter(Generic[T]):
    """A chapter of the ledger: how it is computed, its findings and its sections."""

    name: str  # of its result
    sections: Callable[[T], list[Section]]
    findings: Callable[[T], Iterable[Finding]] = _no_findings
    # From the swims, whether to compute in full, and a function to call after every step but the last.
    compute: Callable[[Trials, bool, Callable[[], None]], T] = _trials
    steps: int = 1  # of progress
    full_steps: int = 1  # the same, if computed in full


compose = partial(html.compose, "hypertuna.paper")  # sections of a template of this room
