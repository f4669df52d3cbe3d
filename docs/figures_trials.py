"""Tables of docs/trials.md; docs/figures.py takes them in."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from figures_common import rows
from matplotlib.figure import Figure

from hypertuna.trials.manifest import reference as manifest_keys
from hypertuna.trials.steady import COLUMNS

ROOT = Path(__file__).resolve().parents[1]


def steady_columns() -> str:
    """Tabulate the columns of a file of steady runs."""
    body = [
        ["`frequency_hz`", "Hz", "yes", "beat frequency"],
        ["`amplitude_GROUP_deg`", "deg", "yes", "commanded amplitude of each joint group"],
        ["`phase_GROUP_deg`", "deg", "yes", "lag of each joint group; default of the first: 0"],
        ["`bias_GROUP_deg`", "deg", "", "mean angle of each joint group (default: 0)"],
        ["`{speed}`", "m/s", "either", "speed along the mean path"],
        ["`{speed_sd}`", "m/s", "", "standard deviation of the speed of a single swim"],
        ["`{cost_of_transport}`", "J/(kg m)", "or", "mechanical power over mass of the robot and speed"],
        ["`{cost_of_transport_sd}`", "J/(kg m)", "", "standard deviation of the cost of transport of a single swim"],
        ["`{repeats}`", "", "", "number of swims that the row is the mean of (default: 1)"],
        ["`{name}`", "", "", "name of the run (default: FILE:LINE)"],
    ]
    return rows(
        ["column", "unit", "required", "meaning"], [[cell.format(**COLUMNS) for cell in r] for r in body], left=4
    )


def quoted(name: str, kind: str, lines: int | None = None) -> str:
    """Quote the first lines of a file of the examples."""
    text = (ROOT / "examples" / name).read_text().splitlines()
    return "\n".join([f"```{kind}", *text[:lines], *(["..."] if lines else []), "```"])


TABLES: dict[str, Callable[[], str]] = {
    "steady columns": steady_columns,
    "steady example": lambda: quoted("tank/tank.csv", "text", 5),
    "manifest example": lambda: quoted("tank/tank.toml", "toml"),
    "manifest keys": manifest_keys,
}
PICTURES: dict[str, Callable[[], Figure]] = {}
