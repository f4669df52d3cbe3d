"""Cards of results for shells and notebooks: a title, numbers, a sentence, a table and a picture."""

from __future__ import annotations

import html
import importlib
import io
import math
import pkgutil
import re
import sys
import textwrap
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Concatenate, ParamSpec, TypeAlias, TypeVar

from hypertuna.arguments import checked
from hypertuna.errors import InputError, shown
from hypertuna.io.files import data_columns
from hypertuna.io.quantity import Quantity
from hypertuna.ranges import Range

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

P = ParamSpec("P")
R = TypeVar("R")
V = TypeVar("V")

LINES, COLUMNS = 5, 100  # largest size of a card as plain text
OPEN_ROWS = 8  # rows of a table that a notebook shows unfolded
MIN_SHOWN = 0.5  # s: calls that take less time show no progress
REFRESH = 0.1  # s between updates of a progress bar
WIDTHS = Range(min=2, max=40, unit="inch")  # allowed widths of a figure
SCREEN_DPI = 144  # of a figure in a notebook

# Text and lines have the notebook's color; the body's color is clear in both light and dark themes.
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
class Facts:
    """Labeled values of a card: quantities or texts; an empty label gives the value above in another unit."""

    values: Mapping[str, Quantity | str]
    digits: int = 4  # significant ones of numbers

    def rows(self) -> list[tuple[str, str, str]]:
        """Return label, value and unit of each fact that has a label."""
        facts = [Quantity(fact, "", label) if isinstance(fact, str) else fact for label, fact in self.values.items()]
        return [
            (fact.label, fact.value if isinstance(fact.value, str) else f"{fact.value:.{self.digits}g}", fact.unit)
            for fact in facts
            if fact.label is not None
        ]

    def pairs(self) -> list[tuple[str, str]]:
        """Return each label, and its value with its unit."""
        pairs: list[tuple[str, str]] = []
        for label, value, unit in self.rows():
            text = "–" if value == "nan" else f"{value} {unit}".rstrip()
            previous, first = pairs.pop() if pairs and not label else (label, "")
            pairs.append((previous, f"{first} ({text})" if first else text))
        return pairs


@dataclass(frozen=True)
class Table:
    """A table with heads of one or two lines; a cell is text, or text with its style on a terminal.

    Columns are aligned right, except those in `left`, counted from 0. On a narrow terminal, only the column `fold`
    shrinks; without it, all columns but `whole`, which holds names.
    """

    heads: Sequence[str]
    rows: Sequence[Sequence[Any]]
    left: Sequence[int] = (0,)
    fold: int = -1
    whole: int = -1
    tight: bool = False  # whether columns are close together

    @property
    def plain(self) -> tuple[list[str], list[list[str]]]:
        """Heads, each as one line, and rows, without styles."""
        return [head.replace("\n", " ").strip() for head in self.heads], [[*map(_cell, row)] for row in self.rows]

    def width(self) -> int:
        """Return the number of letters that a line of the table needs."""
        return sum(max(len(_cell(cell)) for cell in column) + 2 for column in zip(self.heads, *self.rows, strict=True))


Part: TypeAlias = "str | tuple[str, str] | Facts | Table"  # a sentence; a sentence and its style on a terminal


@dataclass(frozen=True)
class Card:
    """A summary of a result for terminals and notebooks, with words and numbers ready to print."""

    title: str
    parts: Sequence[Part] = ()
    picture: Callable[[], str] | None = None  # returns <svg> elements; only pages call it

    def lines(self) -> list[Part]:
        """Return title and parts, as a terminal prints them."""
        return [(self.title, "bold"), *self.parts]


class Functions(dict[type, Callable[..., Any]]):
    """Functions that show results, by the class of the result.

    At first use for a class, they import the modules beside the class whose names begin with `modules`.
    """

    def __init__(self, modules: str) -> None:
        super().__init__()
        self.modules = modules

    def of(self, kind: type[R]) -> Callable[[Callable[Concatenate[R, P], V]], Callable[Concatenate[R, P], V]]:
        """Return a decorator that registers a function for a class of results."""

        def keep(function: Callable[Concatenate[R, P], V]) -> Callable[Concatenate[R, P], V]:
            self[kind] = function
            return function

        return keep

    def __missing__(self, kind: type) -> Callable[..., Any]:
        room = importlib.import_module(kind.__module__.rpartition(".")[0])
        for module in pkgutil.iter_modules(room.__path__, f"{room.__name__}."):
            if kind not in self and module.name.rpartition(".")[2].startswith(self.modules):
                importlib.import_module(module.name)
        return dict(self)[kind]


cards, tables, plots = Functions("cards"), Functions("cards"), Functions("plots")


class Displayed:
    """A result that Python shells show in five lines, and terminals and notebooks as a card."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.__repr__ = Displayed.__repr__  # type: ignore[method-assign]  # else a dataclass writes its own

    def __repr__(self) -> str:
        return card_text(card_of(self))

    def _repr_html_(self) -> str:
        """Return the card as HTML, for notebooks."""
        return card_html(card_of(self))


class Plotted(Displayed):
    """A result with a figure."""

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
        figure: Figure = plots[type(self)](self, width=width)
        return in_notebooks(figure)


class Tabular:
    """A result that converts to a table: its `data` or its function in `tables` gives a data set, columns or rows."""

    _data: ClassVar[Callable[[Any], Any] | None] = None

    def __init_subclass__(cls, data: Callable[[Any], Any] | None = None, **options: Any) -> None:
        super().__init_subclass__(**options)
        if data:
            cls._data = staticmethod(data)

    def to_pandas(self) -> pd.DataFrame:
        """Return the result as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            Columns have their unit in their name: ``speed_m_s``, ``phase_II_deg``. Angles are in degrees.
        """
        import pandas as pd  # slow to import

        data = (type(self)._data or tables[type(self)])(self)
        return to_pandas(data) if hasattr(data, "data_vars") else pd.DataFrame(data)


def card_of(result: Any) -> Card:
    """Return the card of a result."""
    card: Card = cards[type(result)](result)
    return card


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


def in_notebooks(figure: Figure) -> Figure:
    """Let notebooks show a figure that was not made by pyplot; return the figure."""

    def png() -> bytes:
        content = io.BytesIO()
        figure.savefig(content, format="png", dpi=SCREEN_DPI)
        return content.getvalue()

    figure._repr_png_ = png  # type: ignore[attr-defined]  # notebooks look for it by name
    return figure


def number(value: float, unit: str = "", digits: int = 3) -> str:
    """Return a number as text with three digits and its unit; a dash for NaN."""
    if value is None or math.isnan(value):
        return "–"
    size = abs(value)
    if size == 0 or not 1e-4 <= size < 1e6:
        text = f"{value:.{digits}g}"
    else:
        text = f"{value:.{max(0, digits - 1 - math.floor(math.log10(size)))}f}"
    return f"{text} {unit}".rstrip()


def card_text(card: Card) -> str:
    """Return a card as text of at most five lines."""
    pairs = [pair for part in card.parts if isinstance(part, Facts) for pair in part.pairs()]
    facts = textwrap.wrap("; ".join(f"{label} {value}".strip() for label, value in pairs), COLUMNS)
    lines = [card.title, *(facts if len(facts) <= LINES - 2 else [*facts[: LINES - 3], "..."])]
    if text := " ".join(filter(None, map(_sentence, card.parts))):
        lines.append(text)
    table = next((part for part in card.parts if isinstance(part, Table)), Table((), ()))
    rows = [", ".join(filter(None, map(_cell, row))) for row in table.rows]
    room = LINES - len(lines)
    if len(rows) > room:
        rows = [*rows[: room - 1], f"... and {len(rows) - room + 1} more"] if room > 1 else []
    return "\n".join(textwrap.shorten(line, COLUMNS, placeholder=" ...") for line in [*lines, *rows])


def _sentence(part: Part) -> str:
    """Return the sentence of a part; "" for a part that is no sentence or is printed dim."""
    return part if isinstance(part, str) else part[0] if isinstance(part, tuple) and part[1] != "dim" else ""


def card_html(card: Card) -> str:
    """Return a card as HTML without scripts."""
    parts = [f"<style>{STYLE}</style>", f'<div class="ht-title">{safe(card.title)}</div>']
    parts += [] if card.picture is None else [card.picture()]
    parts += map(_part_html, card.parts)
    return f'<div class="ht-card">{"".join(parts)}</div>'


def _part_html(part: Part) -> str:
    """Return a part of a card as HTML."""
    if isinstance(part, Table):
        rest = Table(part.heads, part.rows[OPEN_ROWS:])
        details = f"<details><summary>{len(rest.rows)} more rows</summary>{_table(rest)}</details>" if rest.rows else ""
        return (_table(Table(part.heads, part.rows[:OPEN_ROWS])) if part.rows else "") + details
    if isinstance(part, Facts):
        facts = (f"<div><span>{safe(label)}</span><b>{safe(value)}</b></div>" for label, value in part.pairs())
        return f'<div class="ht-facts">{"".join(facts)}</div>' if part.values else ""
    return f"<p>{safe(_cell(part))}</p>" if _cell(part) else ""


def _cell(cell: str | tuple[str, str]) -> str:
    """Return the text of a cell or a sentence, without its style."""
    return cell if isinstance(cell, str) else cell[0]


def _table(part: Table) -> str:
    """Return a table as HTML; columns of text are aligned left."""
    columns, rows = part.plain
    is_left = [k == 0 or not all(_numeric(row[k]) for row in rows) for k in range(len(columns))]
    classes = ['class="ht-left"' if aligned else "" for aligned in is_left]
    head = "".join(f"<th {kind}>{safe(name)}</th>" for kind, name in zip(classes, columns, strict=True))
    body = "".join(
        f"<tr>{''.join(f'<td {kind}>{safe(cell)}</td>' for kind, cell in zip(classes, row, strict=True))}</tr>"
        for row in rows
    )
    table = f'<table class="ht-table"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    return f'<div class="ht-wide">{table}</div>'


def _numeric(cell: str) -> bool:
    """Return whether a cell is empty, or a number with or without a unit."""
    return re.fullmatch(r"–?|[-+]?[\d.]+(e[-+]?\d+)?( \S+)?", cell) is not None


def safe(text: str) -> str:
    """Escape text for HTML, with a space in units that does not break the line."""
    return html.escape(str(text)).replace("(kg m)", "(kg\N{NO-BREAK SPACE}m)")


@checked
def progress_bar(what: str = "done") -> Callable[[int, int], None]:
    """Return a callback that shows the progress of a long call, in a notebook (removed at the end) or on a terminal.

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
        if now - last < (0 if ended else REFRESH) or (last == begin and now - begin < MIN_SHOWN):
            return
        last = now
        remark = (
            f", {(now - begin) * (total - count) / count:.0f} s left" if 0 < count < total else f", {now - begin:.0f} s"
        )
        text = f"{count} of {total} {what}{remark}"
        if notebook is not None:
            notebook("" if ended else f'<progress value="{count}" max="{total}"></progress> {html.escape(text)}')
        elif sys.stderr.isatty():
            print(f"\r{text:<60}", end="\n" if ended else "", file=sys.stderr, flush=True)

    return report


def _notebook_display() -> Callable[[str], None] | None:
    """Return a function that shows HTML in the running notebook, replacing its last; None outside of notebooks."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if not hasattr(shell, "kernel"):
        return None
    from IPython.display import display

    display_html: Any = display
    handle: Any = None

    def show(page: str) -> None:
        nonlocal handle
        if handle is not None:
            handle.update({"text/html": page}, raw=True)
        elif page:
            handle = display_html({"text/html": page}, raw=True, display_id=True)

    return show
