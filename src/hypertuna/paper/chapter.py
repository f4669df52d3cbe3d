"""Chapters of the ledger: each computes a result, yields findings on it, and shows it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from hypertuna.paper.computed import Trial
from hypertuna.paper.ledger import Finding
from hypertuna.reports.html import Part, Picture, Section, Table

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure

T = TypeVar("T")
Trials: TypeAlias = Mapping[str, Trial]  # swims of all that the paper reports, by model


def _trials(trials: Trials, full: bool, step: Callable[[], None]) -> Any:
    """Return the swims: the result of chapters that need no more."""
    return trials


def _no_findings(result: Any) -> Iterable[Finding]:
    """Return no findings: of chapters that only show."""
    return ()


@dataclass(frozen=True)
class Chapter(Generic[T]):
    """A chapter of the ledger."""

    name: str  # of its result
    sections: Callable[[T], list[Section]]
    findings: Callable[[T], Iterable[Finding]] = _no_findings
    # From the swims, whether to compute in full, and a function to call after every step but the last.
    compute: Callable[[Trials, bool, Callable[[], None]], T] = _trials
    steps: int = 1  # of progress
    full_steps: int = 1  # the same, if computed in full


@cache
def _environment() -> Environment:
    """Return the templates of sections; their filter ``f`` formats a value: ``{{ speed | f(".3g") }}``."""
    import jinja2

    loader = jinja2.PackageLoader("hypertuna.paper")
    environment = jinja2.Environment(
        loader=loader, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["f"] = format
    return environment


def compose(template: str, shown: Mapping[str, Figure | bytes | Table] | None = None, **values: Any) -> Section:
    """Return the section of a template, with the figures (drawn, or PNG) and tables that it shows.

    The template has a title, ``# Turning``, paragraphs of Markdown, and for each figure or table a paragraph with its
    name, its caption and how it was made: ``!turning``, ``Radius against phase.``, ``Source: Settled beats.`` A table
    may come with both.
    """
    text = _environment().get_template(f"{template}.md").render(values)
    title, *blocks = re.split(r"\n{2,}", text.strip())
    parts: list[Part] = []
    for block in blocks:
        if block.startswith("!"):
            name, _, caption = block.removeprefix("!").partition("\n")
            parts.append(_captioned(name, (shown or {})[name], caption.replace("\n", " ")))
        elif parts and isinstance(parts[-1], str):
            parts[-1] += f"\n\n{block}"
        else:
            parts.append(block)
    return Section(title.removeprefix("# "), parts)


def _captioned(name: str, part: Figure | bytes | Table, caption: str) -> Part:
    """Return a figure or a table with its caption."""
    shows, _, made = caption.partition(" Source: ")
    if not isinstance(part, Table):
        return Picture(name, part, shows, made)
    return replace(part, shows=shows, made=made) if caption else part
