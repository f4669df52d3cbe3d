"""Tables and the picture of docs/scoreboard.md; `python docs/figures.py` runs this."""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hypertuna.display import number
from hypertuna.scoreboard.plots import plot_scoreboard
from hypertuna.scoreboard.scoreboard import score_swimmers
from hypertuna.scoreboard.scores import Score, Scoreboard, coverage, leave_one_out, ratios_of, swimmer_logs

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "docs"))
from figures_common import rows  # noqa: E402  # beside this file


@cache
def board() -> Scoreboard:
    """Predict all swimmers."""
    return score_swimmers()


def before() -> dict[tuple[str, str, str], float]:
    """Return the ratios before the law of the fin changed, by swimmer, run and quantity."""
    lines = (ROOT / "validation/scoreboard/before.csv").read_text().splitlines()
    table = csv.DictReader(line for line in lines if not line.startswith("#"))
    return {(row["swimmer"], row["run"], row["quantity"].split()[0]): float(row["ratio"]) for row in table}


def _ratio(value: float) -> str:
    """Write a ratio; nothing for NaN."""
    return "" if np.isnan(value) else f"{value:.2f}"


def _row(score: Score) -> list[str]:
    """Return the cells of a score."""
    old = before().get((score.swimmer, score.run, score.quantity), np.nan)
    band = "" if score.band is None else " to ".join(map(number, score.band))
    cells = [score.swimmer, score.run, number(score.published), number(score.predicted), band]
    return [*cells, _ratio(score.ratio), _ratio(score.own / score.published), _ratio(old)]


def speed_table() -> str:
    """Tabulate all speeds: published, predicted, before the law changed."""
    heads = ["swimmer", "run", "published [m/s]", "predicted [m/s]", "90 % band", "ratio", "own sections", "before"]
    return rows(heads, [_row(score) for score in board().speeds], left=2)


def other_table() -> str:
    """Tabulate thrusts of fish held fixed, and powers."""
    others = [score for score in board().scores if score.quantity != "speed"]
    body = [
        [f"{score.swimmer}, {score.run}", f"{score.quantity} [{score.entry.unit}]", *_row(score)[2:]]
        for score in others
    ]
    heads = ["swimmer, run", "quantity", "published", "predicted", "ratio", "own sections", "before"]
    return rows(heads, [[*cells[:4], *cells[5:]] for cells in body], left=2)


def summary_table() -> str:
    """Tabulate statistics of the scores, today and before the law of the fin changed."""
    old: dict[str, list[float]] = {}
    for (name, _, quantity), ratio in before().items():
        if quantity == "speed":
            old.setdefault(name, []).append(ratio)
    body = []
    for name, logs in (("today", swimmer_logs(ratios_of(board().scores))), ("before", swimmer_logs(old))):
        sizes = np.array([*logs.values()])
        near = [f"{(np.abs(sizes) <= np.log(factor)).sum()} of {len(sizes)}" for factor in (1.3, 2.0)]
        left = np.sqrt(np.mean(leave_one_out(logs) ** 2))
        body.append([name, f"{np.sqrt(np.mean(sizes**2)):.2f}", f"{np.exp(sizes.mean()):.2f}", *near, f"{left:.2f}"])
    heads = ["law", "rms of the logarithm", "geometric mean", "within 1.3", "within 2", "leave-one-out"]
    return rows(heads, body)


def band_table() -> str:
    """Tabulate which part of the published speeds is inside the bands, and how wide the bands are."""
    kinds = {
        "estimates, and excursions that are assumed": False,
        "estimates alone, as `hypertuna swim` prints them": True,
    }
    body = []
    for name, alone in kinds.items():
        inside, ratio = coverage(board().scores, estimates_alone=alone)
        body.append([name, f"{100 * inside:.0f} %", f"{ratio:.2f}"])
    return rows(["band of", "holds of the published speeds", "upper over lower end, median"], body)


def laws_table() -> str:
    """Tabulate how published and predicted swimmers, and random fish, obey the laws of all swimmers."""
    body = []
    shoals = {f"swimmers, {speed}": board().swum(speed) for speed in ("published", "predicted")}
    for name, shoal in (shoals | {"random fish": board().shoal}).items():
        cells = [f"{np.isfinite(shoal.speed).sum()} of {len(shoal.speed)}"]
        for values in (shoal.over_gazzola, shoal.strouhal, shoal.stride):
            low, middle, high = np.nanquantile(values, (0.1, 0.5, 0.9))
            cells.append(f"{middle:.2f} ({low:.2f} to {high:.2f})")
        body.append([name, *cells])
    return rows(["", "with a speed", "Re over Gazzola's", "Strouhal number", "stride length [BL]"], body)


def others_table() -> str:
    """Tabulate the speeds that a drag area, fitted to another speed, predicts."""
    body = [
        [name, other.fitted, other.run, _ratio(other.ratio) or "none", "yes" if other.holds else "no"]
        for name, others in board().others.items()
        for other in others
    ]
    return rows(["swimmer", "fitted to", "predicts", "ratio", "within 10 % and the published error"], body, left=3)


TABLES: dict[str, Callable[[], str]] = {
    "scoreboard speeds": speed_table,
    "scoreboard thrusts": other_table,
    "scoreboard summary": summary_table,
    "scoreboard bands": band_table,
    "scoreboard laws": laws_table,
    "scoreboard several speeds": others_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/scoreboard.svg": lambda: plot_scoreboard(board())}

if __name__ == "__main__":  # this page alone
    import re

    from hypertuna.figures import save

    page = ROOT / "docs/scoreboard.md"
    text = re.sub(
        r"(<!-- table: (.+?) -->\n).*?(<!-- end -->)",
        lambda m: f"{m[1]}\n{TABLES[m[2]]()}\n\n{m[3]}",
        page.read_text(),
        flags=re.DOTALL,
    )
    page.write_text(text)
    for name, picture in PICTURES.items():
        save(picture(), ROOT / name)
