"""Card and table columns of a design's next runs."""

import math
from typing import Any

import numpy as np

from hypertuna.design.runs import QUANTITIES
from hypertuna.design.tank import NextRuns
from hypertuna.display import Card, Part, Table, cards, number, tables
from hypertuna.pictures import captioned, curve_svg


@cards.of(NextRuns)
def next_runs_card(result: NextRuns) -> Card:
    """Show the next runs, how well the target gaits are known, and warnings."""
    parts: list[Part] = []
    if result.choices:
        header = ["run", "why", "motion", "expected", "half width\nafter [%]"]
        rows = [
            (
                choice.name,
                choice.why,
                str(choice.run),
                _expected(*next((*row, name) for name, row in choice.expected.items())),
                f"{100 * choice.half_width:.2g}",
            )
            for choice in result.choices
        ]
        parts.append(Table(header, rows, left=(0, 1, 2, 3), fold=2))
        narrowed = {name: (old, new) for choice in result.choices for name, (old, new) in choice.narrowed.items()}
        if narrowed:
            changes = ", ".join(f"{name} {old:.2f} → {new:.2f}" for name, (old, new) in narrowed.items())
            parts.append(f"These runs narrow (standard deviations, of logarithms in log scale): {changes}.")
    if result.stop:
        parts.append((result.stop, "green"))
    parts += [(warning, "yellow") for warning in result.warnings]
    title = f"{len(result.steps)} runs told" if len(result.steps) != 1 else "1 run told"
    parts.append(
        f"{title}: the {result.subject} of the target gaits is known within {_within(result.half_width)}; "
        f"{100 * result.width:.2g} % is enough."
    )
    return Card(f"{result.robot.name}: next runs", parts, (lambda: _widths_svg(result)) if result.steps else None)


def _expected(value: float, half_width: float, name: str) -> str:
    """Return the expected value of a quantity and its 95 % interval, as text in the displayed unit."""
    _, _, unit, size = QUANTITIES[name]
    bounds = (number(size * value * math.exp(sign * half_width)) for sign in (-1, 1))
    return f"{number(size * value)} ({' to '.join(bounds)}) {unit}"


def _within(half_width: float) -> str:
    """Return the half width of the interval of a logarithm as text: in percent, or as a factor if it is wide."""
    return f"{100 * half_width:.2g} %" if half_width < 1 else f"a factor of {math.exp(half_width):.2g}"


def _widths_svg(result: NextRuns) -> str:
    """Draw the half width of the target gaits' 95 % interval after each run."""
    widths = [100 * step.half_width for step in result.steps]
    label = "half width of the target gaits [%]"
    return captioned(curve_svg(range(1, len(widths) + 1), widths, label, dots=True), "After each run.")


@tables.of(NextRuns)
def next_runs_columns(result: NextRuns) -> dict[str, Any]:
    """Return the measured runs as columns, with the half width of the target gaits' interval after each run."""
    return {
        "run": [step.results[0].name for step in result.steps],
        "made": [str(step.run) for step in result.steps],
        "half_width": np.array([step.half_width for step in result.steps]),
        "off_sd": np.array([step.off for step in result.steps]),
        "discrepancy": np.array([step.discrepancy for step in result.steps]),
    }
