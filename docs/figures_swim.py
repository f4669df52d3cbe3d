"""The swimming fish of README.md, and the table of peers beside it."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

from figures_common import FISH, rows

from hypertuna.description.schema.water import LAWS
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.outline import swimming_svg
from hypertuna.swimming.swim import swim

SPEEDS = Path(__file__).parents[1] / "validation/mujoco/speeds.csv"
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


def mujoco_rows() -> list[dict[str, str]]:
    """Read the stored speeds in MuJoCo."""
    with SPEEDS.open() as file:
        return list(csv.DictReader(file))


def mujoco_table() -> str:
    """Tabulate speeds of the published gaits in the plane."""
    body: dict[str, list[str]] = {}
    for row in mujoco_rows():
        if row["water"] != "plugin in space":
            cells = body.setdefault(row["gait"], [row["gait"], f"{float(row['speed_m_s']):.4f}"])
            if row["water"] == "stock":
                cells.append(f"{float(row['mujoco_m_s']):.4f}")
            cells.append(f"{float(row['difference_percent']):+.3f} %")
    head = ["gait", "here, lumped [m/s]", "stock [m/s]", "stock", *(f"plugin, {law}" for law in LAWS)]
    return rows(head, list(body.values()))


def mujoco_space_table() -> str:
    """Tabulate speeds and depths in space."""
    body = []
    for row in mujoco_rows():
        if row["water"] == "plugin in space":
            fins, off = math.degrees(float(row["fins_rad"])), float(row["difference_percent"])
            depths = [f"{float(row[name]):.3f}" for name in ("depth_m", "mujoco_depth_m")]
            body.append([row["law"], f"{fins:.0f}", f"{float(row['speed_m_s']):.4f}", f"{off:+.3f} %", *depths])
    head = ["law", "fins [deg]", "speed here [m/s]", "in MuJoCo", "depth here [m]", "in MuJoCo [m]"]
    return rows(head, body)


TABLES = {"peers": peer_table, "mujoco": mujoco_table, "mujoco in space": mujoco_space_table}
FILES = {"docs/fish.svg": fish_svg}  # functions that draw a file, by its path
