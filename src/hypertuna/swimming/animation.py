"""The swimming body in motion, as an animated GIF."""

import io
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from hypertuna.figures import COLORS, FAINT, GRID, INK
from hypertuna.io.files import write_atomically
from hypertuna.swimming.outline import FRAME, outlines, slowed, specks
from hypertuna.swimming.swim import Swim


def animate_swim(swim: Swim, path: str | Path) -> None:
    """Write the body swimming one beat as an animated GIF that repeats without a jump."""
    shapes, step = outlines(swim)
    reach = 1.15 * max(0.16, float(np.abs(shapes[..., 1]).max()))
    figure = Figure(figsize=(6.4, 6.4 * 2 * reach / 1.3), dpi=100, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-0.15, 1.15), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    dots = specks(step, reach)
    (water,) = axes.plot(*dots.T, ".", color=GRID, ms=5, zorder=1)
    (body,) = axes.fill(*shapes[0].T, color=COLORS[1], lw=0, zorder=2)
    text = f"{swim.robot.name}, {swim.gait.frequency:g} Hz: {swim.speed:.2f} m/s, {slowed(swim)}"
    axes.text(0.015, 0.03, text, transform=axes.transAxes, color=FAINT if swim.settled else INK, fontsize=9)
    frames = []
    for k, shape in enumerate(shapes):
        water.set_data(*(dots + step * (k / len(shapes))).T)
        body.set_xy(shape)
        canvas.draw()
        frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("P", palette=Image.Palette.ADAPTIVE))
    content = io.BytesIO()
    frames[0].save(content, "GIF", save_all=True, append_images=frames[1:], duration=FRAME, loop=0)
    write_atomically(path, content.getvalue())
