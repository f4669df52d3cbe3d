"""The swimming body in motion: outlines of a beat, and animated GIFs."""

import html
import io
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from hypertuna.arrays import Array
from hypertuna.figures import COLORS, FAINT, GRID, INK
from hypertuna.io.files import write_atomically
from hypertuna.swimming.plots import last_beat, midlines
from hypertuna.swimming.swim import Swim
from hypertuna.swimming.trajectory import Points, nose_points

FRAMES = 32  # of one beat
FRAME = 40  # ms: a beat takes 1.3 s on the screen, on any gait
GIRTH = 0.135  # largest thickness of the drawn body, body lengths; thickness is schematic, only the midline is computed
FIN = 0.006  # half thickness of the fin, body lengths
PEDUNCLE = 0.93  # where the fin begins, body lengths
DOTS = 0.08  # spacing of the specks in the water, body lengths


def outlines(swim: Swim, frames: int = FRAMES) -> tuple[Array, Array]:
    """Draw the body around its midline through the last beat, the mean path straight to the left.

    Returns `outline` (frames, points, 2), `step` (2,) [body lengths].
    """
    length, motion = swim.robot.body.length, last_beat(swim)
    lines, nose = midlines(swim, frames) / length, nose_points(motion) / length
    step = -(nose[-1] - nose[0]) * np.exp(-1j * np.mean(motion.heading.values))
    return np.stack([_outline(swim, line - lines[:, 0].mean()) for line in lines]), np.array([step.real, step.imag])


def animate_swim(swim: Swim, path: str | Path) -> None:
    """Write the swimming body of one beat as a seamless animated GIF."""
    shapes, step = outlines(swim)
    reach = 1.15 * max(0.16, float(np.abs(shapes[..., 1]).max()))
    figure = Figure(figsize=(6.4, 6.4 * 2 * reach / 1.3), dpi=100, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-0.15, 1.15), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    dots = _specks(step, reach)
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


def swimming_svg(swim: Swim) -> str:
    """Return an animated SVG of the swimming body over one beat."""
    shapes, step = outlines(swim)
    scale = 1000
    reach = 1.7 * float(np.abs(shapes[..., 1]).max()) * scale
    paths = ["M" + "L".join(f"{x * scale:.1f} {-y * scale:.1f}" for x, y in shape) + "z" for shape in shapes]
    seconds = f"{FRAMES * FRAME / 1000:g}s"
    specks = "".join(
        f'<circle cx="{x * scale:.0f}" cy="{-y * scale:.0f}" r="3.5"/>' for x, y in _specks(step, reach / scale)
    )
    return (
        f'<svg class="fish" viewBox="-170 {-reach:.0f} 1340 {2 * reach:.0f}" role="img" '
        f'aria-label="{html.escape(swim.robot.name)} swimming">'
        f'<g class="water">{specks}<animateTransform attributeName="transform" type="translate" from="0 0" '
        f'to="{step[0] * scale:.1f} {-step[1] * scale:.1f}" dur="{seconds}" repeatCount="indefinite"/></g>'
        f'<path class="body" d="{paths[0]}"><animate attributeName="d" dur="{seconds}" repeatCount="indefinite" '
        f'values="{";".join([*paths, paths[0]])}"/></path></svg>'
    )


def slowed(swim: Swim) -> str:
    """Return the time on the screen relative to the time in the water."""
    factor = FRAMES * FRAME / 1000 * swim.gait.frequency
    if factor > 1.05:
        return f"slowed down {factor:.2g} times"
    return f"sped up {1 / factor:.2g} times" if factor < 0.95 else "in real time"


def _outline(swim: Swim, line: Points) -> Array:
    """Thicken a midline, given at the joints, to a fish-like polygon."""
    joints = np.concatenate([[0.0], np.cumsum(swim.robot.links.length)]) / swim.robot.body.length
    s = (1 - np.cos(np.linspace(0, np.pi, 61))) / 2
    # Bend smoothly: interpolate the directions at the middles of the links, then add up.
    middle = (joints[1:] + joints[:-1]) / 2
    angle = np.interp(s, middle, np.unwrap(np.angle(np.diff(line))))
    steps = np.diff(s) * np.exp(0.5j * (angle[1:] + angle[:-1]))
    center = line[0] + np.concatenate([[0], np.cumsum(steps)])
    # Half thickness: the NACA four-digit section down to a thin fin.
    t = s / PEDUNCLE
    section = 5 * GIRTH * (0.2969 * np.sqrt(t) - 0.1260 * t - 0.3516 * t**2 + 0.2843 * t**3 - 0.1036 * t**4)
    normal = 1j * np.exp(1j * angle) * np.where(t < 0.5, section, np.maximum(section, FIN))
    z = np.concatenate([center + normal, (center - normal)[::-1]])
    return np.stack([z.real, z.imag], axis=1)


def _specks(step: Array, reach: float) -> Array:
    """Place specks in the water so that they look the same after a beat; the rows are shifted against each other."""
    count = round(abs(float(step[0])) / DOTS)
    spacing = abs(float(step[0])) / count if count else DOTS
    along = np.arange(-0.3 - abs(step[0]), 1.3 + abs(step[0]), spacing)
    rows = np.arange(-reach, reach, DOTS) + DOTS / 2
    return np.array([(x + spacing * (0.618 * k % 1), y) for k, y in enumerate(rows) for x in along])
