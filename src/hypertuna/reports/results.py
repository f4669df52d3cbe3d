"""One page on results of any kind, each by its card and its figure."""

from collections.abc import Container, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hypertuna.arguments import checked
from hypertuna.description.robot import Robot
from hypertuna.display import STYLE, Displayed, Facts, Plotted, card_of
from hypertuna.display import Table as Shown
from hypertuna.errors import InputError, shown
from hypertuna.identification.identify import Fit
from hypertuna.reports.html import WIDTH, Part, Picture, Section, Table, table_of, write_page
from hypertuna.reports.studio import studio_command
from hypertuna.swimming.gait import Gait

QUANTITY = ("quantity", "value")  # head of a table of facts


@checked
def report(results: Any, path: str | Path, *, title: str = "") -> Path:
    """Write results as one self-contained HTML page, for wide screens and phones, light and dark.

    Parameters
    ----------
    results : result, or sequence of results
        What notebooks show as a card, such as a swim, a run of the twin, a fit or a front: a section or several for
        each, in their order.
    path : str or Path
        Of the page; replaced if it exists.
    title : str
        Of the page; the names of the robots if left out.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If there is no result, one is none that notebooks show as a card, or the file cannot be written.
    """
    is_list = isinstance(results, Sequence) and not isinstance(results, str | Displayed)
    items = list(results) if is_list else [results]
    if not items:
        raise InputError("must hold at least one result", key="results", value="empty", fix="give a swim, or a fit")
    sections: list[Section] = []
    for k, result in enumerate(items):
        if not isinstance(result, Displayed):
            rule, fix = "must be a result or a list of them", "give what hypertuna.swim or hypertuna.identify returns"
            raise InputError(rule, key="results", value=shown(result), fix=fix)
        titles = {section.title for section in sections}
        sections += [_unique(section, k, titles) for section in _sections(result)]
    robots = {robot.name: robot.description for result in items if (robot := _robot(result))}
    lede = "\n\n".join(f"{text}." for text in dict.fromkeys(robots.values()))
    return write_page(title or " and ".join(robots) or "Results", sections, path, lede=lede)


def _robot(result: Displayed) -> Robot | None:
    """Return the robot of a result; None where it has none, or its name alone."""
    robot = getattr(result, "robot", None)
    return robot if isinstance(robot, Robot) else None


def _unique(section: Section, k: int, titles: Container[str]) -> Section:
    """Return a section of result k with unique names of pictures, and a title that is not among `titles`."""
    parts = [
        replace(part, name=f"result-{k}-{part.name}") if isinstance(part, Picture) else part for part in section.parts
    ]
    return Section(f"{section.title} ({k + 1})" if section.title in titles else section.title, parts)


def _sections(result: Displayed) -> list[Section]:
    """Return the sections of one result."""
    if isinstance(result, Fit):
        from hypertuna.reports.fit import fit_sections  # imported here, because the import of matplotlib takes long

        return fit_sections(result)
    return [Section(card_of(result).title, [*_parts(result)])]


def _parts(result: Displayed) -> Iterator[Part]:
    """Yield what a card shows, its picture, and the figure of the result."""
    card = card_of(result)
    for part in card.parts:
        if isinstance(part, Facts):
            yield Table(QUANTITY, part.pairs())
        elif isinstance(part, Shown):
            yield table_of(part)
        elif text := part if isinstance(part, str) else part[0]:
            yield text
    robot, gait = _robot(result), getattr(result, "gait", None)
    if robot and isinstance(gait, Gait) and (command := studio_command(robot, gait)):
        yield f"Turn the knobs of this gait in the browser: `{command}`."
    if card.picture is not None:
        picture = f'<div class="ht-card"><style>{STYLE}</style>{card.picture()}</div>'
        yield Picture("card", picture, card.title, "")
        if isinstance(result, Plotted):
            yield Picture("figure", result.plot(width=WIDTH), card.title, "")
