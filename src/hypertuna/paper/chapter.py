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
Trials: TypeAlias = Mapping[str, Trial]  # model -> its swims of all tests in the paper


def _trials(trials: Trials, full: bool, step: Callable[[], None]) -> Any:
    """Return the trials unchanged, as the result of chapters that compute nothing else."""
    return trials


def _no_findings(result: Any) -> Iterable[Finding]:
    """Return no findings, for chapters that only show results."""
    return ()


@dataclass(frozen=True)
class Chapter(Generic[T]):
    """A chapter of the ledger: how it is computed, its findings and its sections."""

    name: str  # key of its result in `Ledger.results`
    sections: Callable[[T], list[Section]]
    findings: Callable[[T], Iterable[Finding]] = _no_findings
    # Computes the result from the trials and `full`; calls the function after every step but the last.
    compute: Callable[[Trials, bool, Callable[[], None]], T] = _trials
    steps: int = 1  # number of steps of `compute`
    full_steps: int = 1  # number of its steps in full


compose = partial(html.compose, "hypertuna.paper")  # sections of a template of this room
