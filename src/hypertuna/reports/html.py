"""Self-contained HTML pages: sections of text, pictures and tables, for wide screens and phones, light and dark."""

from __future__ import annotations

import base64
import html
import io
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from hypertuna import display
from hypertuna.io.files import version, write_atomically

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure

WIDTH = 4.3  # width of a plot on a page [inch], whose text stays readable on a phone
COLUMN = 502  # width of one of two columns on a wide page [px]


@dataclass(frozen=True)
class Picture:
    """A figure of a page, with its caption and a sentence on how it was made."""

    name: str  # of its file and its ids: letters, digits and hyphens, unique on the page
    figure: Figure | str | bytes  # at most `WIDTH` wide; an ``<svg>`` element; or the content of a PNG file
    shows: str  # caption: what the figure shows, a sentence
    made: str  # how it was made, a sentence

    @cached_property
    def svg(self) -> str:
        """The figure as an SVG file with its letters as text; a PNG is embedded in one."""
        if isinstance(self.figure, str):
            return self.figure
        if isinstance(self.figure, bytes):
            wide, high = struct.unpack(">II", self.figure[16:24])  # at the start of the first chunk, IHDR
            content = base64.b64encode(self.figure).decode()
            image = f'<image width="{wide}" height="{high}" href="data:image/png;base64,{content}"/>'
            return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}">{image}</svg>'
        import matplotlib

        from hypertuna.figures import disable_formulas

        disable_formulas(self.figure)
        text = io.StringIO()
        with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": self.name}):
            self.figure.savefig(text, format="svg", metadata={"Date": None})
        return text.getvalue()


@dataclass(frozen=True)
class Table:
    """Rows of cells; wide ones scroll on a phone."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str | float]]  # numbers are written to three digits
    shows: str = ""  # caption: what the table shows, a sentence
    made: str = ""  # how it was made, a sentence
    folded: str = ""  # label that unfolds the table; empty to show it open

    @property
    def numeric(self) -> tuple[bool, ...]:
        """Whether each column is aligned to the right: not the first, others if all cells are empty or numbers."""
        return tuple(k > 0 and all(_numeric(row[k]) for row in self.rows) for k in range(len(self.columns)))


def table_of(table: display.Table, shows: str = "", made: str = "") -> Table:
    """Return a table of a card as one of a page, with its caption and a sentence on how it was made."""
    return Table(*table.plain, shows, made)


@dataclass(frozen=True)
class Fact:
    """A number in large letters, with its meaning."""

    number: str
    text: str


# Text is Markdown: paragraphs, `code` and **strong** words.
Part: TypeAlias = str | Picture | Table


@dataclass(frozen=True)
class Section:
    """A heading, and the parts below it in reading order."""

    title: str
    parts: list[Part]


Shown: TypeAlias = "Figure | str | bytes | Table"


@cache
def _environment(room: str) -> Environment:
    """Return the templates of a room: of pages (HTML), and of sections (Markdown)."""
    import jinja2
    from markdown_it import MarkdownIt
    from markupsafe import Markup

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(room),
        autoescape=lambda name: name is not None and name.endswith(".html.j2"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    markdown = MarkdownIt("zero").enable(["backticks", "emphasis"])  # everything else is escaped
    environment.filters |= {
        "f": format,
        "prose": lambda text: Markup(markdown.render(text)),
        "words": lambda text: Markup(markdown.renderInline(text)),
        "cell": _cell,
        "spans": _spans,
        "anchor": anchor,
    }
    environment.tests |= {"picture": lambda part: isinstance(part, Picture), "table": lambda p: isinstance(p, Table)}
    return environment


def compose(room: str, template: str, shown: Mapping[str, Shown], **values: Any) -> list[Section]:
    """Return the sections of a template NAME.md of a room, with the figures and tables that it shows.

    A section has a title, ``# Turning``, paragraphs of Markdown, and for each figure or table a paragraph with its
    name, its caption and how it was made: ``!turning``, ``Radius against phase.``, ``Source: Settled beats.`` A table
    may come with both. The filter ``f`` formats a value: ``{{ speed | f(".3g") }}``.
    """
    text = _environment(room).get_template(f"{template}.md").render(values)
    sections: list[Section] = []
    for block in re.split(r"\n{2,}", text.strip()):
        if block.startswith("# "):
            sections.append(Section(block.removeprefix("# "), []))
            continue
        parts = sections[-1].parts
        if block.startswith("!"):
            name, _, caption = block.removeprefix("!").partition("\n")
            part, (shows, _, made) = shown[name], caption.replace("\n", " ").partition(" Source: ")
            if not isinstance(part, Table):
                parts.append(Picture(name, part, shows, made))
            else:
                parts.append(replace(part, shows=shows, made=made) if caption else part)
        elif parts and isinstance(parts[-1], str):
            parts[-1] += f"\n\n{block}"
        else:
            parts.append(block)
    return sections


def write_page(
    title: str, sections: Sequence[Section], path: str | Path, *, lede: str = "", facts: Sequence[Fact] = ()
) -> Path:
    """Write a page that needs no other file, completely or not at all."""
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
    """Return a page as HTML, from a template of this room with more values."""
    text = (
        _environment("hypertuna.reports")
        .get_template(template)
        .render(
            title=title,
            lede=lede,
            facts=facts,
            rows=_rows(sections),
            inline=inline,
            version=version(),
            **(values or {}),
        )
    )
    text = text.replace("(kg m)", "(kg\N{NO-BREAK SPACE}m)")
    text = re.sub(r"(\d) (%|km\b|Hz\b|m/s|BL\b|deg\b|J/)", "\\1\N{NO-BREAK SPACE}\\2", text)
    return "".join(_with_minus(part) for part in _VERBATIM.split(text))


_VERBATIM = re.compile(r"(<(?:script|style|code|pre|svg)\b.*?</(?:script|style|code|pre|svg)>|<[^>]*>)", re.DOTALL)


def _with_minus(part: str) -> str:
    """Return a part of a page, with the minus sign in place of the hyphen before a number, in text alone."""
    return part if part.startswith("<") else re.sub(r"(?<![\w.\])-])-(?=\d)", "\N{MINUS SIGN}", part)


def anchor(title: str) -> str:
    """Return the identifier of a heading."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def inline(picture: Picture) -> str:
    """Return a figure as an SVG element in the colors and font of the page, with identifiers unique on it."""
    if isinstance(picture.figure, str):
        return picture.figure
    if isinstance(picture.figure, bytes):
        return picture.svg.replace(
            "<svg", f'<svg class="photo" role="img" aria-label="{html.escape(picture.shows)}"', 1
        )
    svg = picture.svg[picture.svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    label = html.escape(picture.shows).replace("\\", r"\\")
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"', rf'\1 role="img" aria-label="{label}"', svg, count=1)
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r"""font: ([^;"']*?)'DejaVu Sans'[^;"]*""", r"font: \1var(--sans)", svg)
    svg = re.sub(r'\b(id="|url\(#|href="#)', rf"\g<1>{picture.name}-", svg)
    svg = re.sub(r">-(?=\d)", ">\N{MINUS SIGN}", svg)
    for color, variable in _themed().items():
        svg = re.sub(rf"\b(fill|stroke): {color}", rf"\1: var({variable})", svg, flags=re.IGNORECASE)
    return svg


def _rows(sections: Sequence[Section]) -> list[list[Section]]:
    """Return the sections in rows: two side by side where neither fills two columns, as text beside a tall figure."""
    rows: list[list[Section]] = []
    for section in sections:
        if rows and len(rows[-1]) == 1 and _narrow(rows[-1][0]) and _narrow(section):
            rows[-1].append(section)
        else:
            rows.append([section])
    return rows


def _narrow(section: Section) -> bool:
    """Return whether a section is too short for two columns: one of them would stay empty by three tenths."""
    if any(isinstance(part, Table) and _wide(part) for part in section.parts):
        return False
    heights = [height for part in section.parts for height in _heights(part)]
    taller = min((max(sum(heights[:k]), sum(heights[k:])) for k in range(len(heights) + 1)), default=0)
    return 2 * taller - sum(heights) > 0.3 * taller


def _heights(part: Part) -> list[float]:
    """Return estimated heights [px], in one column, of the pieces of a part, between which a column may break."""
    if isinstance(part, str):
        return [26 * (len(block) // 56 + 1) + 14 for block in part.split("\n\n")]
    caption = 20 * (len(part.shows + part.made) // 75 + 1) + 28
    if isinstance(part, Table):
        return [36 * (len(part.rows) + 1) + caption]
    view_box = re.search(r'viewBox="\S+ \S+ (\S+) (\S+)"', part.svg)
    return [(COLUMN * float(view_box[2]) / float(view_box[1]) if view_box else COLUMN) + caption]


def _spans(parts: Sequence[Part]) -> list[tuple[Part, bool]]:
    """Return every part with whether it spans both columns: wide tables do, and parts alone between them."""
    spans = [True, *(isinstance(part, Table) and _wide(part) for part in parts), True]
    return [(part, spans[k] or (spans[k - 1] and spans[k + 1])) for k, part in enumerate(parts, start=1)]


def _wide(table: Table) -> bool:
    """Return whether a table needs more than one of two columns."""
    cells = [[_cell(value) for value in row] for row in table.rows]
    heads = [max(name.split() or [""], key=len) for name in table.columns]  # heads break between words
    widths = [max(map(len, column)) for column in zip(heads, *cells, strict=True)]
    return sum(8 * width + 14 for width in widths) > COLUMN


def _themed() -> dict[str, str]:
    """Return the CSS variable for every color of the plots: the page has light and dark values of them."""
    from matplotlib.colors import to_hex

    from hypertuna.figures import BODY, COLORS, FAINT, GRID, INK

    colors = {INK: "--ink", FAINT: "--faint", GRID: "--grid", "white": "--paper", BODY: "--body"}
    colors |= {"#DDEBF3": "--surface", "#EFE7D6": "--hold", "#E4EEDD": "--home", "#ECECEC": "--done"}  # of missions
    colors |= dict(zip(COLORS, ("--orange", "--blue", "--green", "--pink", "--amber", "--sky"), strict=True))
    return {to_hex(color): variable for color, variable in colors.items()}


def _cell(value: str | float) -> str:
    """Return a cell as text, a number to three digits."""
    return value if isinstance(value, str) else f"{value:.3g}"


def _numeric(value: str | float) -> bool:
    """Return whether a cell is empty or begins with a number."""
    return not isinstance(value, str) or re.match(r"[-+−±<>≤≥≈✓≠✗]?\s?\d|–?$", value) is not None
