"""Cards of gradients and turns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from hypertuna.display import Card, Part, Table, cards
from hypertuna.io.files import variable_columns
from hypertuna.pictures import BARS, bars_svg, captioned
from hypertuna.swimming.gait import KINDS, gait_degrees, gait_text
from hypertuna.swimming.outline import circling_svg
from hypertuna.swimming.sweep import Gradient
from hypertuna.swimming.swim import swim
from hypertuna.swimming.turn import Tightest, Turning

INFLUENCES = ("speed", "cost_of_transport")  # results that the card of a gradient shows
ROWS = 40  # most turns in a table


@cards.of(Gradient)
def gradient_card(gradient: Gradient) -> Card:
    """Return the card of a gradient: each parameter's influence on speed and cost of transport, the largest first."""
    influence = {name: gradient.influence(name) for name in INFLUENCES}
    order = np.argsort(-np.abs(influence["speed"]))
    rows = [
        (gradient.names[k], *(f"{influence[name][k]:+z.2f} %" for name in INFLUENCES))
        for k in order
        if any(influence[name][k] for name in INFLUENCES)
    ]
    columns = ("parameter", *(name.replace("_", " ") for name in INFLUENCES))
    title = f"Influence on {gait_text(gradient.gait)} of {gradient.robot.name}"
    text = "Change of the result for 1 % more of the parameter, of an angle for 1 deg more."
    return Card(title, [text, Table(columns, rows)], lambda: _influence_svg(gradient, order[:BARS].tolist()))


def _influence_svg(gradient: Gradient, first: list[int]) -> str:
    """Return an SVG of the parameters with the largest influence on the speed; first: their indices."""
    speed = gradient.influence("speed").tolist()
    rows = [(gradient.names[k], 0.0, speed[k]) for k in first]
    return captioned(
        bars_svg(rows, "change of the speed [%]"),
        f"The {len(first)} parameters with the largest influence on the speed.",
    )


def turn_columns(turning: Turning) -> dict[str, Any]:
    """Return the turns of the grid's gaits as columns, with units in the names."""
    length = turning.robot.body.length
    names = ("frequency", "turn_radius", "circle_radius", "circle_residual", "turn_rate", "speed", "status")
    columns = variable_columns(turning.sweep, names)
    rate = np.degrees(columns["turn_rate_rad_s"])
    return {
        "turn_radius_m": columns["turn_radius_m"],
        "turn_radius_bl": columns["turn_radius_m"] / length,
        "circle_radius_bl": columns["circle_radius_m"] / length,
        "circle_residual_m": columns["circle_residual_m"],
        "turn_rate_deg_s": rate,
        "turn_per_beat_deg": rate / columns["frequency_hz"],
        "speed_m_s": columns["speed_m_s"],
        "status": columns["status"],
    }


def turn_sentences(turning: Turning) -> Iterator[str]:
    """Yield sentences on the tightest turns."""
    if turning.tightest is None:
        yield "No gait turns: give the joints a bias with --bias, or see the statuses with --json."
        return
    length = turning.robot.body.length
    yield _sentence("tightest turn", turning.tightest, length)
    if turning.forward is None:
        yield "No gait that turns swims head first."
    elif turning.forward.gait != turning.tightest.gait:
        yield _sentence("tightest that swims head first", turning.forward, length)


def _sentence(label: str, turn: Tightest, length: float) -> str:
    """Return a sentence on the tightest turn of a kind; length: of the body [m]."""
    where = f"at {math.degrees(turn.gait.phase[-1]):.4g} deg, {turn.gait.frequency:g} Hz"
    speed = f"{'head' if turn.speed > 0 else 'tail'} first at {abs(turn.speed):.2g} m/s"
    phase = math.degrees(turn.phase_between)
    between = f"; between the phases given, {turn.turn_radius_between / length:.3g} BL at {phase:.3g} deg"
    is_on_grid = turn.phase_between == turn.gait.phase[-1]
    return f"The {label}: {turn.turn_radius / length:.3g} BL {where}, {speed}{'' if is_on_grid else between}."


@cards.of(Turning)
def turning_card(turning: Turning) -> Card:
    """Return the card of turns: a table of the grid's turns, and sentences on the tightest ones."""
    best = turning.tightest
    if best is None:
        first, *others = turn_sentences(turning)
        return Card(first, others)
    columns = {name: np.asarray(column).tolist() for name, column in turn_columns(turning).items()}
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    rows = [gait_degrees(gait) | row for gait, row in zip(turning.gaits, rows, strict=True)]
    column_heads = {"frequency_hz": "f\n[Hz]"} | {f"{key}_deg": f"{key}\n[deg]" for key in KINDS}
    varying = [key for key in column_heads if any(row[key] != rows[0][key] for row in rows)]
    cells = []
    for row in sorted(rows, key=lambda row: row["turn_radius_m"])[:ROWS] if len(rows) > ROWS else rows:
        angles = (np.atleast_1d(row[key]) for key in varying)
        gait = [", ".join(f"{angle:.4g}" for angle in values) for values in angles]
        radii = (f"{row[key]:.3f}" for key in ("turn_radius_bl", "circle_radius_bl"))
        cells.append((*gait, *radii, f"{row['turn_per_beat_deg']:+z.1f}", f"{row['speed_m_s']:+z.3f}", row["status"]))
    shown = ["radius\n[BL]", "circle\n[BL]", "turn\n[deg/beat]", "speed\n[m/s]", "\nstatus"]
    content: list[Part] = [
        ("radius: mean distance of the nose from the center; circle: fitted to its path", "dim"),
        Table([*(column_heads[key] for key in varying), *shown], cells, left=(len(varying) + 4,)),
        *([(f"the {ROWS} tightest of {len(rows)}", "dim")] if len(rows) > ROWS else []),
        *turn_sentences(turning),
    ]
    title = f"{turning.robot.name}, tightest: {gait_text(best.gait)}"
    caption = "The tightest turn from above, in real time."
    return Card(title, content, lambda: captioned(circling_svg(swim(turning.robot, best.gait)), caption))
