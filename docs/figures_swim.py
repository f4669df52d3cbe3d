"""The swimming fish of README.md, and the table of peers beside it."""

from __future__ import annotations

import re
from pathlib import Path

from figures_common import FISH, rows

from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.outline import swimming_svg
from hypertuna.swimming.swim import swim

BENCHMARKS = Path(__file__).with_name("benchmarks.md")
STYLE = """<style>
.body { fill: #0072b2 } .water { fill: #5f6d77; opacity: 0.45 }
@media (prefers-color-scheme: dark) { .body { fill: #4fb0ea } .water { fill: #9fb0bb } }
</style>"""


def fish_svg() -> str:
    """Return HyperTuna at its fastest published gait as an animated SVG file, for light and dark pages."""
    svg = swimming_svg(swim(FISH, named_gait(FISH, "unoptimised-max")))
    return svg.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1).replace(">", f">{STYLE}", 1) + "\n"


def measured(name: str) -> str:
    """Return a number of docs/benchmarks.md."""
    found = re.search(rf"^\| {re.escape(name)} \| ([^|]*) \|", BENCHMARKS.read_text(), flags=re.MULTILINE)
    assert found, f"docs/benchmarks.md has no row '{name}'"
    return found[1].strip()


def peer_table() -> str:
    """Tabulate hypertuna beside its peers: time of each, and the ratio."""
    beat, grid = "one beat of one gait", "180 gaits, 40 beats each"
    ours = {beat: measured("hypertuna, in the grid"), grid: measured("hypertuna, 40 beats")}
    peers = (
        (beat, "SciPy `solve_ivp`, NumPy", "SciPy LSODA, rtol 1e-07", "LSODA over hypertuna in the grid"),
        (beat, "MuJoCo, the same chain", "MuJoCo", "MuJoCo over hypertuna in the grid"),
        (grid, "JAX, the equations as printed", "JAX `direct`, 40 beats", "JAX `direct` over hypertuna"),
        (grid, "JAX, rearranged by hand", "JAX `fused`, 40 beats", "JAX `fused` over hypertuna"),
    )
    body = [[task, text, measured(time), ours[task], measured(ratio)] for task, text, time, ratio in peers]
    body.append(["180 gaits, settled", "", "", measured("180 settled gaits"), ""])
    return rows(["task", "with", "time", "hypertuna", "ratio"], body, left=2)


TABLES = {"peers": peer_table}
FILES = {"docs/fish.svg": fish_svg}
