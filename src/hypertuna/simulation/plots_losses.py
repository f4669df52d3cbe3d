"""Sankey diagram of losses: power flows down from the battery to the water, and losses branch off to the right."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from hypertuna.arrays import Array
from hypertuna.display import number, plots
from hypertuna.figures import BODY, COLORS, FAINT, WIDTH, styled
from hypertuna.simulation.losses import PLACES, Losses

REACH, TURN, TIP = 0.3, 0.06, 0.12  # length, inner radius and arrowhead of a branch, in widths of the flow
LINE, HEAD, LETTER = 0.16, 0.5, 0.072  # inch: height of a text line, space above the flow, width of a letter
MAX_FLOW = 1.3  # inch: largest width of the flow


@plots.of(Losses)
@styled
def plot_losses(losses: Losses, *, width: float = WIDTH) -> Figure:
    """Plot the flow of power from place to place; `width` of the figure [inch]."""
    scale = min(MAX_FLOW, 0.25 * width)  # inch: width of the flow at the battery
    edge = 1 + TURN + REACH + 0.08  # left edge of the texts, in widths of the flow
    letters = int((width - edge * scale) / LETTER)
    texts = {place: textwrap.wrap(losses.named(place), letters) for place in PLACES}
    shares = {place: min(1.0, max(0.0, losses.at(place) / losses.power)) for place in PLACES}
    rows = {place: max(shares[place] + 2 * TURN, (len(texts[place]) + 1.6) * LINE / scale) for place in PLACES}
    height = HEAD + scale * (sum(rows.values()) + TURN)
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(-0.05, width / scale - 0.05), ylim=((HEAD - height) / scale, HEAD / scale))
    axes.axis("off")
    axes.text(0.0, 0.36 / scale, losses.title, fontsize=8, color=FAINT, va="center")
    axes.text(0.0, 0.13 / scale, f"{number(losses.power)} W from the cells", weight="bold", va="center")
    flow_left, start = 1.0, 0.0
    for k, place in enumerate(PLACES):
        loss, middle = min(flow_left, shares[place]), start + rows[place] / 2
        flow_after = flow_left - loss
        if place == PLACES[-1]:
            _draw(axes, _end(start, flow_left, rows[place]), COLORS[k])
        else:
            turn, end = middle - TURN - loss / 2, start + rows[place]
            flow = [(0, start), (flow_left, start), (flow_left, turn), (flow_after, turn), (flow_after, end), (0, end)]
            _draw(axes, np.array(flow), BODY)
            _draw(axes, _branch(turn, flow_left, loss), COLORS[k])
        text_y = -middle + len(texts[place]) * LINE / scale / 2
        label = f"{place} {number(losses.at(place), 'W')}"
        axes.text(edge, text_y, label, weight="bold", va="center")
        for j, text in enumerate(texts[place]):
            axes.text(edge, text_y - (j + 1) * LINE / scale, text, fontsize=8, va="center")
        flow_left, start = flow_after, start + rows[place]
    return figure


def _draw(axes: Axes, corners: Array, color: str) -> None:
    """Draw a part of the flow as a polygon; the corners' heights are positive down."""
    axes.add_patch(Polygon(corners * [1, -1], closed=True, fc=color, ec=color, lw=0.4))


def _branch(start: float, right: float, size: float) -> Array:
    """Return the corners of an arrow that branches off the flow's right edge and turns to the right."""
    turn = np.linspace(0, np.pi / 2, 25)
    arc = np.stack([-np.cos(turn), np.sin(turn)], axis=1)
    center, end, tip = np.array([right + TURN, start]), 1 + TURN + REACH, min(0.5 * size, TIP)
    below = start + TURN
    head = [(end - tip, below + size), (end, below + size / 2), (end - tip, below)]
    return np.concatenate([center + (TURN + size) * arc, np.array(head), (center + TURN * arc)[::-1]])


def _end(start: float, size: float, length: float) -> Array:
    """Return the corners of the last part of the flow, which ends in an arrow down."""
    tip = min(0.5 * size, TIP)
    end = start + length - tip
    return np.array([(0, start), (size, start), (size, end), (size / 2, end + tip), (0, end)])
