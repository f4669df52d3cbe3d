"""Sphinx settings: pages in Markdown, the Python interface from its docstrings, no file from the network."""

import base64
import html
import itertools
import json
import re
from importlib.metadata import version as installed_version
from pathlib import Path
from typing import Any

from docutils.nodes import Text, document
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx

from hypertuna.description.robot import load
from hypertuna.io.files import verdicts
from hypertuna.reports.html import anchor
from hypertuna.reports.studio import studio_page

NOTEBOOKS = Path(__file__).parents[1] / "examples" / "notebooks"

project = "hypertuna"
author = "the hypertuna authors"
project_copyright = author
release = version = installed_version("hypertuna")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_design",
    "sphinx-mathjax-offline",
]
exclude_patterns = ["_build"]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_member_order = "bysource"
napoleon_google_docstring = False

html_theme = "furo"
html_title = f"hypertuna {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_extra_path = ["fish.svg"]
html_copy_source = False


def plain_words(_: Sphinx, tree: document) -> None:
    """Remove links from the plain words of a type in a docstring, as "shape" in "array, shape (n,)"."""
    for link in tree.findall(pending_xref):
        target = str(link.get("reftarget", "")).rpartition(".")[2]
        if link.get("refdomain") == "py" and link.get("reftype") in ("class", "obj") and target[:1].islower():
            link.replace_self(Text(link.astext()))


def without_back_links(_: Sphinx, name: str, __: str, context: dict[str, Any], ___: document | None) -> None:
    """Remove links from sources back to the reference: Sphinx does not find names that another module exports."""
    if name.startswith("_modules/"):
        context["body"] = re.sub(r'<a class="viewcode-back"[^>]*>.*?</a>', "", context["body"], flags=re.DOTALL)


def whole_sentences(_: Sphinx, what: str, __: str, ___: Any, ____: Any, lines: list[str]) -> None:
    """Keep napoleon from taking the words before a colon in the docstring of a property for its type."""
    if what in ("property", "attribute") and lines:
        lines[0] = re.sub(r": (?=\w)", " – ", lines[0])


def by_keyboard(_: Sphinx, __: str, ___: str, context: dict[str, Any], ____: document | None) -> None:
    """Let keys scroll wide code and tables, and give the menu's captions a heading level, which the theme omits.

    Pictures open in full size, since their texts are small on a narrow screen.
    """
    body = context.get("body", "").replace("<pre>", '<pre tabindex="0">')
    body = body.replace('<div class="table-wrapper', '<div tabindex="0" class="table-wrapper')
    context["body"] = re.sub(r'<img alt="[^"]*" src="([^"]*)"[^>]*/>', r'<a class="picture" href="\1">\g<0></a>', body)
    menu = context.get("furo_navigation_tree", "")
    context["furo_navigation_tree"] = menu.replace('role="heading"', 'role="heading" aria-level="2"')


def executed(app: Sphinx, __: str, source: list[str]) -> None:
    """Fill a page's directive `notebook` with the cells of examples/notebooks/NAME.ipynb and their outputs."""

    def filled(line: re.Match[str]) -> str:
        return linked(cells(line[1]), line[1], Path(app.outdir))

    source[0] = re.sub(r"^```{notebook} (\w+)\n```$", filled, source[0], flags=re.MULTILINE)


def linked(page: str, name: str, site: Path) -> str:
    """Return a page whose pictures are files of the site, with links to them in full size."""
    pictures = itertools.count(1)

    def put(found: re.Match[str]) -> str:
        file = f"_images/notebook-{name}-{next(pictures)}.png"
        (site / "_images").mkdir(parents=True, exist_ok=True)
        (site / file).write_bytes(base64.b64decode(found["data"]))
        return f'<a href="../{file}">{found["before"]}../{file}{found["after"]}</a>'

    return re.sub(r'(?P<before><img\b[^>]*\bsrc=")data:image/png;base64,(?P<data>[^"]+)(?P<after>"[^>]*>)', put, page)


def cells(name: str) -> str:
    """Return the cells of a notebook and their outputs as MyST, without the title, which the page has."""
    notebook = json.loads((NOTEBOOKS / f"{name}.ipynb").read_text(encoding="utf-8"))
    parts = []
    for cell in notebook["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "code":
            parts.append(f"```{'sh' if text.startswith('!') else 'python'}\n{text.removeprefix('!')}\n```")
            parts += map(shown, cell["outputs"])
        else:
            parts.append(re.sub(r"^# .*\n+", "", text))
    return "\n\n".join(parts)


def shown(output: dict[str, Any]) -> str:
    """Return an output of a cell as MyST: its card or table, its figure, or its text."""
    data = output.get("data", {})
    if "text/html" in data:
        page = f'<div class="notebook-output" tabindex="0">{"".join(data["text/html"])}</div>'
    elif "image/png" in data:
        picture = "".join(data["image/png"]).replace("\n", "")
        page = f'<div class="notebook-output"><img alt="figure" src="data:image/png;base64,{picture}"></div>'
    else:
        text = "".join(output.get("text", data.get("text/plain", "")))
        return f"```text\n{text.rstrip()}\n```"
    return f"````{{raw}} html\n{page}\n````"


def ledger_places(_: Sphinx, name: str, __: str, context: dict[str, Any], ___: document | None) -> None:
    """Give each number of the ledger's table an anchor, as on the page that `hypertuna paper` writes."""
    if name != "paper":
        return
    waiting = {html.escape(entry["id"]): f"number-{anchor(entry['id'])}" for entry in verdicts()["entries"]}

    def placed(row: re.Match[str]) -> str:
        place = waiting.pop(row[2], None)
        return row[0] if place is None else f'<tr id="{place}"{row[1]}{row[2]}<'

    rows = r'<tr((?: class="[^"]*")?>\s*<td><p><code[^>]*><span class="pre">)([^<]*)<'
    context["body"] = re.sub(rows, placed, context["body"])
    if waiting:
        raise ValueError(f"the ledger's table has no row of {', '.join(waiting)}: run `python docs/figures.py`")


def studio(app: Sphinx, failure: Exception | None) -> None:
    """Write the studio's page, whose verdicts link to the ledger's table."""
    if failure is None and app.builder.format == "html":
        page = studio_page(load("hypertuna"), ledger="paper.html")
        (Path(app.outdir) / "studio.html").write_text(page, encoding="utf-8")


def setup(app: Sphinx) -> None:
    """Connect the functions above to Sphinx's events."""
    app.connect("source-read", executed)
    app.connect("doctree-read", plain_words)
    app.connect("autodoc-process-docstring", whole_sentences, priority=400)  # before napoleon
    app.connect("html-page-context", without_back_links)
    app.connect("html-page-context", by_keyboard, priority=900)  # after the theme
    app.connect("html-page-context", ledger_places)
    app.connect("build-finished", studio)
