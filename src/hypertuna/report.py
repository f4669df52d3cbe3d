"""One self-contained HTML page: the ledger with its plots, for wide screens and phones, light and dark."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from typing import Any

import jinja2
import matplotlib
import numpy as np
from matplotlib.figure import Figure

from hypertuna.animation import slowed, swimming_svg
from hypertuna.drawing import COLORS, INK, draw, save
from hypertuna.errors import InputError
from hypertuna.ledger import MARKS, RULES, published
from hypertuna.plots import plot_ledger, plot_sweep, plot_swim, plot_turning
from hypertuna.reproduce import OURS, PAPER, SPEEDS, Ledger, ledger_record
from hypertuna.results import write_atomically
from hypertuna.style import FAINT, GRID
from hypertuna.swim import Swim

__all__ = ["ledger_page", "write_ledger"]

WIDTH = 5.0  # of a plot on the page, inches: its text stays readable on a phone
NAMES = {"reproduced": "reproduced", "deviates": "deviates", "contradicted": "contradicted", "not-computed": "to come"}

# Colors of the plots that the page replaces by its own, which follow the reader's choice of light or dark.
THEMED = {
    INK: "--ink",
    FAINT: "--faint",
    GRID: "--grid",
    "white": "--paper",
    COLORS[0]: "--orange",
    COLORS[1]: "--blue",
}


def write_ledger(ledger: Ledger, folder: str | Path) -> Path:
    """Write the ledger as a folder: index.html, ledger.json and its plots as SVG.

    Parameters
    ----------
    ledger : Ledger
    folder : str or Path
        Made if it does not exist.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        If the folder cannot be written to.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = f"not ({error.strerror})"
        raise InputError("must be a folder to write to", file=str(folder), value=reason, fix="choose another") from None
    figures = _figures(ledger)
    for name, figure in figures.items():
        save(figure, folder / f"{name}.svg")
        figure.set_layout_engine("none")  # it is laid out now
    write_atomically(folder / "ledger.json", (json.dumps(ledger_record(ledger), indent=2) + "\n").encode())
    return write_atomically(folder / "index.html", _page(ledger, figures).encode())


def ledger_page(ledger: Ledger) -> str:
    """Write the ledger as one HTML page that needs nothing else.

    Parameters
    ----------
    ledger : Ledger

    Returns
    -------
    str
    """
    return _page(ledger, _figures(ledger))


def _figures(ledger: Ledger) -> dict[str, Figure]:
    """Draw the plots of the page."""
    ours, values = ledger.trials[OURS], published()["values"]
    best = ours.gaits["unoptimised-max"]
    truth = [values[f"speed/{name}"]["value"] for name in SPEEDS]
    computed = {
        model: [trial.gaits[name].speed for name in SPEEDS]
        for model, trial in ledger.trials.items()
        if model in (PAPER, OURS)
    }
    turn = {model: ledger.trials[model].turning for model in (PAPER, OURS)}
    point = values["turning/best-phase"]["value"], values["turning/radius"]["value"]
    return {
        "speeds": plot_ledger([_short(name, ours.gaits[name]) for name in SPEEDS], truth, computed, width=WIDTH),
        "swim": plot_swim(best, width=WIDTH),
        "tank": plot_sweep(ours.tank, width=WIDTH),
        "turning": plot_turning(turn, ours.robot.body.length, published=point, width=WIDTH),
        "robot": draw(ours.robot),
    }


def _page(ledger: Ledger, figures: dict[str, Figure]) -> str:
    """Fill the template."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("hypertuna", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["short"] = "{:.3g}".format
    best = ledger.trials[OURS].gaits["unoptimised-max"]
    entries: dict[str, list[Any]] = {}
    for entry in ledger.entries:
        entries.setdefault(entry.id, []).append(entry)
    page = environment.get_template("report.html.j2").render(
        ledger=ledger,
        entries=entries,
        speeds=[f"speed/{name}" for name in SPEEDS],
        rules=RULES,
        marks=MARKS,
        names=NAMES,
        paper=PAPER,
        ours=OURS,
        best=best,
        slowed=slowed(best),
        fish=swimming_svg(best),
        bandwidth=[group.bandwidth for group in best.robot.joints],
        figures={name: _inline(figure, name) for name, figure in figures.items()},
    )
    return re.sub(r"(\d) (%|km\b|Hz\b|m/s|BL\b|deg\b)", "\\1\N{NO-BREAK SPACE}\\2", page)


def _inline(figure: Figure, name: str) -> str:
    """Return a figure as an SVG element in the page's colors and letters; names of its parts are its own."""
    text = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None})
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r"""font: ([^;"']*?)'DejaVu Sans'[^;"]*""", r"font: \1var(--sans)", svg)
    svg = re.sub(r'\b(id="|url\(#|href="#)', rf"\g<1>{name}-", svg)
    for color, variable in THEMED.items():
        code = matplotlib.colors.to_hex(color)
        svg = re.sub(rf"\b(fill|stroke): {code}", rf"\1: var({variable})", svg, flags=re.IGNORECASE)
    return svg


def _short(name: str, done: Swim) -> str:
    """Name a gait on one line."""
    kind, speed = name.split("-")
    return f"{kind} {speed}: {done.gait.frequency:.3g} Hz, {np.degrees(done.gait.phase[-1]):.0f}°"
