"""What shells and notebooks show of a result: a card of a title, numbers, a sentence, a table and a picture."""

from __future__ import annotations

import html
import io
import math
import pkgutil
import re
import sys
import textwrap
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from hypertuna.arguments import checked
from hypertuna.errors import InputError, shown
from hypertuna.io.files import data_columns
from hypertuna.io.quantity import Quantity
from hypertuna.ranges import Range

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

LINES, COLUMNS = 5, 100  # of a text
OPEN = 8  # rows of a table that are not folded
FAST = 0.5  # s: a shorter call shows no progress
REFRESH = 0.1  # s between two pictures of a progress bar
WIDTHS = Range(min=2, max=40, unit="inch")  # of a figure
SCREEN = 144  # dots per inch of a figure in a notebook

# The colors are those of the notebook: text and lines in its color, the body in one that both themes show well.
STYLE = """
.ht-card{max-width:52rem;font-size:.92rem;line-height:1.45;margin:.3rem 0;color:inherit}
.ht-card .ht-title{font-weight:600;font-size:1.02rem;margin:0 0 .3rem}
.ht-card svg{display:block;width:100%;max-height:17rem;margin:.3rem 0;overflow:hidden}
.ht-card svg text{fill:currentColor;font-family:inherit}
@media (max-width:34rem){.ht-card .curve text{font-size:19px}}
.ht-card .water{fill:currentColor;opacity:.22}
.ht-card .body,.ht-card .joint{fill:#2f86c5}
.ht-card .link{fill:currentColor;fill-opacity:.1;stroke:currentColor;stroke-opacity:.55}
.ht-card .mark{stroke:currentColor;stroke-opacity:.8;fill:none}
@media (prefers-reduced-motion:reduce){.ht-card .moving{display:none}}
.ht-facts{display:flex;flex-wrap:wrap;gap:.35rem 1.7rem;margin:.5rem 0}
.ht-facts span{display:block;font-size:.82em;opacity:.72}
.ht-facts b{font-weight:600;font-size:1.08em;white-space:nowrap}
.ht-card .ht-caption{font-size:.82em;margin:0 0 .3rem;opacity:.72}
.ht-card p{margin:.4rem 0;opacity:.85}
.ht-card .ht-wide{overflow-x:auto}
.ht-card table.ht-table{border-collapse:collapse;margin:.4rem 0;font-size:.9em;color:inherit;border:none}
.ht-card .ht-table th,.ht-card .ht-table td{padding:.14rem .9rem .14rem 0;text-align:right;border:none;
background:none;white-space:nowrap;color:inherit}
.ht-card .ht-table th{font-weight:500;opacity:.72;border-bottom:1px solid;border-color:inherit}
.ht-card .ht-table :is(th,td).ht-left{text-align:left}
.ht-card summary{cursor:pointer;opacity:.8}
"""


@dataclass(frozen=True)
class Card:
    """What is shown of a result, in words and numbers as they are printed."""

    title: str
    facts: Sequence[tuple[str, str]] = ()  # label, and value with its unit
    text: str = ""  # sentences
    columns: Sequence[str] = ()  # of a table
    rows: Sequence[Sequence[str]] = ()
    picture: Callable[[], str] | None = None  # makes <svg> elements; pages alone call it


class Displayed:
    """A result that shells show in five lines, and notebooks as a card.

    A class names the function that makes its card, ``"package.module:function"``: imported when it is shown.
    """

    _card: ClassVar[str]

    def __init_subclass__(cls, card: str = "", **options: Any) -> None:
        super().__init_subclass__(**options)
        if card:
            cls._card = card
            cls.__repr__ = Displayed.__repr__  # type: ignore[method-assign]  # else a dataclass writes its own

    def __repr__(self) -> str:
        return card_text(pkgutil.resolve_name(self._card)(self))

    def _repr_html_(self) -> str:
        """Return the card as HTML, for notebooks."""
        return card_html(pkgutil.resolve_name(self._card)(self))


class Plotted(Displayed):
    """A result with a figure: the class names the function that plots it, ``"package.module:function"``."""

    _figure: ClassVar[str]

    def __init_subclass__(cls, figure: str = "", **options: Any) -> None:
        super().__init_subclass__(**options)
        if figure:
            cls._figure = figure

    def plot(self, *, width: float = 7.2) -> Figure:
        """Plot the result.

        Parameters
        ----------
        width : float
            Of the figure, 2 to 40 [inch].

        Returns
        -------
        matplotlib.figure.Figure
            Shown by notebooks; ``figure.savefig("name.svg")`` writes it.
        """
        width = WIDTHS.check(width, "width", "give the width of the figure in inches")
        figure: Figure = pkgutil.resolve_name(self._figure)(self, width=width)
        return in_notebooks(figure)


class Tabular:
    """A result that is a table: the class names the function, or is given it, that returns a dataset or columns."""

    _data: ClassVar[str | Callable[[Any], Any]]

    def __init_subclass__(cls, data: str | Callable[[Any], Any] = "", **options: Any) -> None:
        super().__init_subclass__(**options)
        if data:
            cls._data = data if isinstance(data, str) else staticmethod(data)

    def to_pandas(self) -> pd.DataFrame:
        """Return the result as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            Columns have their unit in their name: ``speed_m_s``, ``phase_II_deg``. Angles are in degrees.
        """
        import pandas as pd  # slow to import

        make = type(self)._data
        data = (pkgutil.resolve_name(make) if isinstance(make, str) else make)(self)
        return pd.DataFrame(data) if isinstance(data, dict) else to_pandas(data)


def to_pandas(data: Any) -> pd.DataFrame:
    """Return a sweep, or another labeled dataset, as a table of pandas.

    Parameters
    ----------
    data : xarray.Dataset
        As of `sweep`, `replay` or ``Swim.trajectory``; or a result that is a table itself.

    Returns
    -------
    pandas.DataFrame
        A row for each gait or instant. Columns have their unit in their name: ``speed_m_s``, ``phase_II_deg``; angles
        are in degrees. ``attrs`` has what made the data.
    """
    import pandas as pd  # slow to import

    if isinstance(data, Tabular):
        return data.to_pandas()
    if not hasattr(data, "data_vars"):
        fix = "give what hypertuna.sweep or hypertuna.replay returns"
        raise InputError("must be a labeled dataset", key="data", value=shown(data), fix=fix)
    table = pd.DataFrame(data_columns(data))
    table.attrs = dict(data.attrs)
    return table


def facts_of(summary: Mapping[str, Quantity]) -> list[tuple[str, str]]:
    """Return the labeled numbers of a summary as facts of a card."""
    return [
        (one.label, str(one.value) if isinstance(one.value, str | int) else number(one.value, one.unit))
        for one in summary.values()
        if one.label
    ]


def columns_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """Return the columns of rows, those of the first by name."""
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}


def in_notebooks(figure: Figure) -> Figure:
    """Make a notebook show a figure that pyplot does not know."""

    def png() -> bytes:
        content = io.BytesIO()
        figure.savefig(content, format="png", dpi=SCREEN)
        return content.getvalue()

    figure._repr_png_ = png  # type: ignore[attr-defined]  # notebooks look for it by name
    return figure


def number(value: float, unit: str = "", digits: int = 3) -> str:
    """Write a number to three digits, with its unit; a dash for NaN."""
    if value is None or math.isnan(value):
        return "–"
    size = abs(value)
    if size == 0 or not 1e-4 <= size < 1e6:
        text = f"{value:.{digits}g}"
    else:
        text = f"{value:.{max(0, digits - 1 - math.floor(math.log10(size)))}f}"
    return f"{text} {unit}".rstrip()


def card_text(card: Card) -> str:
    """Write a card in five lines at most."""
    facts = textwrap.wrap("; ".join(f"{label} {value}".strip() for label, value in card.facts), COLUMNS)
    lines = [card.title, *(facts if len(facts) <= LINES - 2 else [*facts[: LINES - 3], "..."])]
    if card.text:
        lines.append(card.text)
    rows = [", ".join(filter(None, row)) for row in card.rows]
    room = LINES - len(lines)
    if len(rows) > room:
        rows = [*rows[: room - 1], f"... and {len(rows) - room + 1} more"] if room > 1 else []
    return "\n".join(textwrap.shorten(line, COLUMNS, placeholder=" ...") for line in [*lines, *rows])


def card_html(card: Card) -> str:
    """Write a card as HTML without script."""
    facts = "".join(f"<div><span>{safe(label)}</span><b>{safe(value)}</b></div>" for label, value in card.facts)
    parts = [f"<style>{STYLE}</style>", f'<div class="ht-title">{safe(card.title)}</div>']
    parts += [] if card.picture is None else [card.picture()]
    parts += [f'<div class="ht-facts">{facts}</div>'] if facts else []
    parts += [f"<p>{safe(card.text)}</p>"] if card.text else []
    parts += [_table(card.columns, card.rows[:OPEN])] if card.rows else []
    if len(card.rows) > OPEN:
        rest = _table(card.columns, card.rows[OPEN:])
        parts.append(f"<details><summary>{len(card.rows) - OPEN} more rows</summary>{rest}</details>")
    return f'<div class="ht-card">{"".join(parts)}</div>'


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Write a table; columns of text are set left."""
    left = [k == 0 or not all(_numeric(row[k]) for row in rows) for k in range(len(columns))]
    kinds = ['class="ht-left"' if side else "" for side in left]
    head = "".join(f"<th {kind}>{safe(name)}</th>" for kind, name in zip(kinds, columns, strict=True))
    body = "".join(
        f"<tr>{''.join(f'<td {kind}>{safe(cell)}</td>' for kind, cell in zip(kinds, row, strict=True))}</tr>"
        for row in rows
    )
    table = f'<table class="ht-table"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    return f'<div class="ht-wide">{table}</div>'


def _numeric(cell: str) -> bool:
    """Whether a cell is empty, or a number with its unit or without."""
    return re.fullmatch(r"–?|[-+]?[\d.]+(e[-+]?\d+)?( \S+)?", cell) is not None


def safe(text: str) -> str:
    """Escape text for HTML; a unit stays beside its number."""
    return html.escape(str(text)).replace("(kg m)", "(kg\N{NO-BREAK SPACE}m)")


@checked
def progress_bar(what: str = "done") -> Callable[[int, int], None]:
    """Show the progress of a long call in a notebook, where it vanishes at the end, or on a terminal.

    Parameters
    ----------
    what : str
        What is counted: "gaits".

    Returns
    -------
    callable
        Argument ``progress`` of `sweep`, `turn`, `optimize`, `pareto` and `identify`, and ``report`` of `fly`.
    """
    begin = last = time.monotonic()
    notebook = _notebook_display()

    def report(count: int, total: int) -> None:
        nonlocal last
        now, ended = time.monotonic(), count >= total
        if now - last < (0 if ended else REFRESH) or (last == begin and now - begin < FAST):
            return
        last = now
        left = (
            f", {(now - begin) * (total - count) / count:.0f} s left" if 0 < count < total else f", {now - begin:.0f} s"
        )
        text = f"{count} of {total} {what}{left}"
        if notebook is not None:
            notebook("" if ended else f'<progress value="{count}" max="{total}"></progress> {html.escape(text)}')
        elif sys.stderr.isatty():
            print(f"\r{text:<60}", end="\n" if ended else "", file=sys.stderr, flush=True)

    return report


def _notebook_display() -> Callable[[str], None] | None:
    """Return what shows and replaces HTML in the notebook that runs this, None elsewhere."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if not hasattr(shell, "kernel"):
        return None
    from IPython.display import display

    place: Any = display
    handle: Any = None

    def show(page: str) -> None:
        nonlocal handle
        if handle is not None:
            handle.update({"text/html": page}, raw=True)
        elif page:
            handle = place({"text/html": page}, raw=True, display_id=True)

    return show
