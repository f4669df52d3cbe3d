"""Self-contained HTML pages: sections of text, pictures and tables, for wide screens and phones, light and dark."""

from __future__ import annotations

import base64
import html
import io
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, pairwise, product
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from hypertuna.io.files import version, write_atomically

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["WIDTH", "Fact", "Part", "Picture", "Section", "Table", "inline", "page", "write_page"]

WIDTH = 4.3  # of a plot on a page, inches: its text stays readable on a phone
COLUMN = 502  # px, of two on a wide page
MOST = 10  # parts side by side whose every arrangement is tried


@dataclass(frozen=True)
class Picture:
    """A figure with its two sentences.

    Attributes
    ----------
    name : str
        Of its file and of the parts inside: letters, digits and hyphens, unique on the page.
    figure : matplotlib.figure.Figure, str or bytes
        Drawn at most `WIDTH` wide; an ``<svg>`` element; or the content of a PNG file.
    shows, made : str
        What it shows, and how it was made: a sentence each.
    """

    name: str
    figure: Figure | str | bytes
    shows: str
    made: str

    @cached_property
    def svg(self) -> str:
        """The figure as an SVG file, its letters as text; around a PNG, which it holds."""
        if isinstance(self.figure, str):
            return self.figure
        if isinstance(self.figure, bytes):
            return _framed(self.figure)
        import matplotlib

        text = io.StringIO()
        with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": self.name}):
            self.figure.savefig(text, format="svg", metadata={"Date": None})
        return text.getvalue()


@dataclass(frozen=True)
class Table:
    """Rows of cells; wide ones scroll on a phone.

    Attributes
    ----------
    columns : sequence of str
    rows : sequence of sequences of str or float
        Numbers are written to three digits. Columns of them, and of texts that begin like one, stand to the right.
    shows, made : str
        What it shows, and how it was made: a sentence each.
    folded : str
        Words to click on that unfold it; empty for one that stands open.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[str | float]]
    shows: str
    made: str = ""
    folded: str = ""

    @property
    def numeric(self) -> tuple[bool, ...]:
        """Whether each column holds numbers or nothing; the first one names the rows."""
        return tuple(k > 0 and all(_numeric(row[k]) for row in self.rows) for k in range(len(self.columns)))


@dataclass(frozen=True)
class Fact:
    """A number worth large letters.

    Attributes
    ----------
    number, text : str
    """

    number: str
    text: str


# A text may have several paragraphs, set apart by an empty line; `code` and **strong** words are marked.
Part: TypeAlias = str | Picture | Table


@dataclass(frozen=True)
class Section:
    """A heading, and what stands below it in reading order.

    Attributes
    ----------
    title : str
    parts : sequence of str, Picture or Table
    """

    title: str
    parts: Sequence[Part]


def write_page(
    title: str, sections: Sequence[Section], path: str | Path, *, lede: str = "", facts: Sequence[Fact] = ()
) -> Path:
    """Write a page that needs nothing else, whole or not at all.

    Parameters
    ----------
    title : str
    sections : sequence of Section
    path : str or Path
    lede : str
        What the page is about, below the title.
    facts : sequence of Fact

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    return write_atomically(path, page(title, sections, lede=lede, facts=facts).encode())


def page(
    title: str,
    sections: Sequence[Section],
    *,
    lede: str = "",
    facts: Sequence[Fact] = (),
    template: str = "page.html.j2",
    values: Mapping[str, Any] | None = None,
) -> str:
    """Return a page as text.

    Parameters
    ----------
    title : str
    sections : sequence of Section
    lede : str
    facts : sequence of Fact
    template : str
        In the folder of templates.
    values : mapping, optional
        More values for the template.

    Returns
    -------
    str
    """
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("hypertuna.reports"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"short": "{:.3g}".format, "prose": _prose, "words": _words, "cell": _cell, "rows": _rows}
    environment.tests |= {"picture": lambda part: isinstance(part, Picture), "table": lambda p: isinstance(p, Table)}
    text = environment.get_template(template).render(
        title=title, lede=lede, facts=facts, sections=sections, inline=inline, version=version(), **(values or {})
    )
    text = text.replace("(kg m)", "(kg\N{NO-BREAK SPACE}m)")
    return re.sub(r"(\d) (%|km\b|Hz\b|m/s|BL\b|deg\b|J/)", "\\1\N{NO-BREAK SPACE}\\2", text)


def inline(picture: Picture) -> str:
    """Return a figure as an SVG element in the page's colors and letters; names of its parts are its own.

    Parameters
    ----------
    picture : Picture

    Returns
    -------
    str
    """
    if isinstance(picture.figure, str):
        return picture.figure
    if isinstance(picture.figure, bytes):
        return picture.svg.replace("<svg", f'<svg role="img" aria-label="{html.escape(picture.shows)}"', 1)
    svg = picture.svg[picture.svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    label = html.escape(picture.shows).replace("\\", r"\\")
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"', rf'\1 role="img" aria-label="{label}"', svg, count=1)
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r"""font: ([^;"']*?)'DejaVu Sans'[^;"]*""", r"font: \1var(--sans)", svg)
    svg = re.sub(r'\b(id="|url\(#|href="#)', rf"\g<1>{picture.name}-", svg)
    for color, variable in _themed().items():
        svg = re.sub(rf"\b(fill|stroke): {color}", rf"\1: var({variable})", svg, flags=re.IGNORECASE)
    return svg


def _framed(png: bytes) -> str:
    """Put the content of a PNG file into an SVG file of the same shape."""
    wide, high = struct.unpack(">II", png[16:24])  # the first chunk, IHDR, begins with them
    content = base64.b64encode(png).decode()
    image = f'<image width="{wide}" height="{high}" href="data:image/png;base64,{content}"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}">{image}</svg>'


def _rows(parts: Sequence[Part]) -> list[list[list[tuple[int, Part]]]]:
    """Lay out a section for wide screens: rows of one or two columns of parts, each with its place in reading order."""
    flat = [p for part in parts for p in (part.strip().split("\n\n") if isinstance(part, str) else [part])]
    rows = []
    for wide, group in groupby(enumerate(flat), lambda item: isinstance(item[1], Table) and _wide(item[1])):
        members = list(group)
        rows += [[[item]] for item in members] if wide else _columns(members)
    return rows


def _columns(items: list[tuple[int, Part]]) -> list[list[list[tuple[int, Part]]]]:
    """Part items into two columns of nearly equal height; what comes first stays on the left."""
    if len(items) == 1:
        return [[items]]
    heights = [_height(part) for _, part in items[:MOST]]

    def unequal(sides: tuple[int, ...]) -> tuple[float, int]:
        right = sum(height for height, side in zip(heights, sides, strict=True) if side)
        moved = sum(before > after for before, after in pairwise(sides))  # read down, then up again
        return abs(sum(heights) - 2 * right) // 60, moved

    sides = min(((0, *rest) for rest in product((0, 1), repeat=len(heights) - 1)), key=unequal)
    columns = [[item for item, at in zip(items, sides, strict=False) if at == side] for side in (0, 1)]
    return [columns, *(_columns(items[MOST:]) if len(items) > MOST else [])]


def _height(part: Part) -> float:
    """Estimate how high a part is in one of two columns [px]."""
    if isinstance(part, str):
        return 26 * (len(part) / 58 + 0.5) + 14
    words = 20 * ((len(part.shows) + len(part.made)) / 72 + 0.5) + 30
    if isinstance(part, Table):
        return 50 if part.folded else 38 * (len(part.rows) + 1) + words
    box = re.search(r'viewBox="([^"]+)"', part.svg)
    _, _, wide, high = map(float, box[1].split()) if box else (0, 0, 1, 1)
    return COLUMN * high / wide + words


def _wide(table: Table) -> bool:
    """Tell whether a table needs more than one of two columns."""
    cells = [[_cell(value) for value in row] for row in table.rows]
    heads = [max(name.split() or [""], key=len) for name in table.columns]  # heads break between words
    widths = [max(map(len, column)) for column in zip(heads, *cells, strict=True)]
    return sum(8 * width + 14 for width in widths) > COLUMN


def _themed() -> dict[str, str]:
    """Colors of the plots that the page replaces by its own, which follow the reader's choice of light or dark."""
    from matplotlib.colors import to_hex

    from hypertuna.figures import COLORS, FAINT, GRID, INK

    colors = {INK: "--ink", FAINT: "--faint", GRID: "--grid", "white": "--paper"}
    colors |= dict(zip(COLORS, ("--orange", "--blue", "--green", "--pink", "--amber", "--sky"), strict=True))
    return {to_hex(color): variable for color, variable in colors.items()}


def _prose(text: str) -> str:
    """Write paragraphs of text as HTML, with `code` and **strong** words."""
    from markupsafe import Markup

    return Markup("\n").join(Markup("<p>{}</p>").format(_words(part)) for part in text.strip().split("\n\n"))


def _words(text: str) -> str:
    """Write a text without paragraphs as HTML, with `code` and **strong** words."""
    from markupsafe import Markup

    words = html.escape(text, quote=False)
    words = re.sub(r"`([^`]+)`", r"<code>\1</code>", words)
    return Markup(re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", words))


def _cell(value: str | float) -> str:
    """Write what stands in a cell."""
    return value if isinstance(value, str) else f"{value:.3g}"


def _numeric(value: str | float) -> bool:
    """Tell whether a cell holds a number or nothing, and may stand to the right."""
    return not isinstance(value, str) or re.match(r"[-+−±<>≤≥≈✓≠✗]?\s?\d|–?$", value) is not None
