"""The swimming body in motion: outlines of a beat, and animated GIFs."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from hypertuna.drawing import COLORS, INK
from hypertuna.plots import FAINT, GRID, last_beat
from hypertuna.results import body_points, write_atomically
from hypertuna.swim import Swim

__all__ = ["animate_swim", "outlines"]

Array = NDArray[np.float64]

FRAMES = 32  # of one beat
FRAME = 40  # ms: a beat takes 1.3 s on the screen, whatever it takes in the water
GIRTH = 0.16  # largest thickness of the drawn body, body lengths; thickness is schematic, only the midline is computed
DOTS = 0.12  # spacing of the specks in the water, body lengths


def outlines(swim: Swim, frames: int = FRAMES) -> tuple[Array, Array]:
    """Draw the body around its midline through the last beat, the mean path straight to the left.

    Parameters
    ----------
    swim : Swim
    frames : int

    Returns
    -------
    outline : ndarray, shape (frames, points, 2)
        Closed polygons in body lengths, the mean position of the nose at the origin; the thickness is schematic.
    step : ndarray, shape (2,)
        What the water moves past the body in a beat [body lengths].
    """
    motion = last_beat(swim)
    pose = np.stack([motion.x.values, motion.y.values, motion.heading.values], axis=1)
    points = body_points(swim.robot, pose, motion.joint_angle.values) / swim.robot.body.length
    z = points[..., 0] + 1j * points[..., 1]
    pick = np.linspace(0, len(z) - 1, frames, endpoint=False).astype(int)
    part = np.linspace(0, 1, len(z))[:, np.newaxis]
    drift = z[0, 0] + part * (z[-1, 0] - z[0, 0])
    z = (z - drift - np.mean(z[:, :1] - drift)) * np.exp(-1j * np.mean(pose[:, 2]))
    step = -(drift[-1, 0] - drift[0, 0]) * np.exp(-1j * np.mean(pose[:, 2]))
    return np.stack([_outline(swim, line) for line in z[pick]]), np.array([step.real, step.imag])


def animate_swim(swim: Swim, path: str | Path) -> None:
    """Write the swimming body of one beat as an animated GIF that repeats without a seam.

    Parameters
    ----------
    swim : Swim
    path : str or Path

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    shapes, step = outlines(swim)
    reach = 1.15 * max(0.16, float(np.abs(shapes[..., 1]).max()))
    figure = Figure(figsize=(6.4, 6.4 * 2 * reach / 1.3), dpi=100, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-0.15, 1.15), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    count = max(1, round(abs(step[0]) / DOTS))
    spacing = abs(step[0]) / count if count * DOTS / 3 < abs(step[0]) else DOTS
    dots = _specks(spacing, reach)
    (water,) = axes.plot(*dots.T, ".", color=GRID, ms=5)
    (body,) = axes.fill(*shapes[0].T, color=COLORS[1], lw=0)
    slower = FRAMES * FRAME / 1000 * swim.gait.frequency
    text = f"{swim.robot.name}, {swim.gait.frequency:g} Hz: {swim.speed:.2f} m/s. {_slowed(slower)}"
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


def _outline(swim: Swim, line: NDArray[np.complex128]) -> Array:
    """Thicken a midline, given at the joints, to a fish-like polygon."""
    joints = np.concatenate([[0.0], np.cumsum(swim.robot.links.length)]) / swim.robot.body.length
    s = (1 - np.cos(np.linspace(0, np.pi, 61))) / 2
    s[-1] = 1.0
    # Bend smoothly: interpolate the directions at the middles of the links, then add up.
    middle = (joints[1:] + joints[:-1]) / 2
    angle = np.interp(s, middle, np.unwrap(np.angle(np.diff(line))))
    steps = np.diff(s) * np.exp(0.5j * (angle[1:] + angle[:-1]))
    center = line[0] + np.concatenate([[0], np.cumsum(steps)])
    normal = 1j * np.exp(1j * angle) * _half_thickness(s)
    z = np.concatenate([center + normal, (center - normal)[::-1]])
    return np.stack([z.real, z.imag], axis=1)


def _half_thickness(s: Array) -> Array:
    """Half thickness along the body: the NACA four-digit section down to a thin fin."""
    section = 0.2969 * np.sqrt(s) - 0.1260 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1036 * s**4
    return np.maximum(5 * GIRTH * section, 0.008) * np.minimum(1, 40 * s)


def _specks(spacing: float, reach: float) -> Array:
    """Specks in the water: rows that repeat along the path, each row shifted in its own way."""
    along = np.arange(-0.15 - 40 * spacing, 1.15 + 40 * spacing, spacing)
    rows = np.arange(-reach, reach, DOTS) + DOTS / 2
    return np.array([(x + spacing * (0.618 * k % 1), y) for k, y in enumerate(rows) for x in along])


def _slowed(factor: float) -> str:
    """Say how the time on the screen differs from the time in the water."""
    if factor > 1.05:
        return f"Slowed down {factor:.2g} times."
    return f"Sped up {1 / factor:.2g} times." if factor < 0.95 else "In real time."
