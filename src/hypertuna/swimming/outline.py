"""The swimming body as shapes, without matplotlib: midlines and outlines of a beat, and an animated SVG."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.swimming.swim import Swim
from hypertuna.swimming.trajectory import Points, body_of, nose_points

if TYPE_CHECKING:
    import xarray as xr

MIDLINES = 12  # in one beat
FRAMES = 32  # of one beat
FRAME = 40  # ms: a beat takes 1.3 s on the screen, on any gait
GIRTH = 0.135  # largest thickness of the drawn body, body lengths; thickness is schematic, only the midline is computed
FIN = 0.006  # half thickness of the fin, body lengths
PEDUNCLE = 0.93  # where the fin begins, body lengths
DOTS = 0.08  # spacing of the specks in the water, body lengths


def last_beat(swim: Swim) -> xr.Dataset:
    """Return the last whole beat of a swim."""
    motion = swim.trajectory
    if swim.status == "diverged" or not np.isfinite(motion.x + motion.y + motion.heading).all():
        raise InputError("has nothing finite to draw", key="plot", fix="the gait diverged; try more steps per beat")
    beats = 1 if swim.from_rest is None else swim.beats
    return motion.isel(time=slice((beats - 1) * swim.steps, beats * swim.steps + 1))


def midlines(swim: Swim, count: int = MIDLINES) -> Points:
    """Return midlines over the last beat, (count, links + 1) [m], in a frame that follows the mean motion."""
    motion = last_beat(swim)
    nose, heading = nose_points(motion), motion.heading.values
    part = np.linspace(0, 1, len(nose))
    drift, turned = nose[0] + part * (nose[-1] - nose[0]), part * (heading[-1] - heading[0])
    spin = np.exp(-1j * (turned + np.mean(heading - turned)))
    lines: Points = (body_of(swim.robot, motion) - drift[:, np.newaxis]) * spin[:, np.newaxis]
    return np.take(lines, np.linspace(0, len(lines) - 1, count, endpoint=False).astype(int), axis=0)


def outlines(swim: Swim, frames: int = FRAMES) -> tuple[Array, Array]:
    """Draw the body around its midline through the last beat, the mean path straight to the left.

    Returns `outline` (frames, points, 2), `step` (2,) [body lengths].
    """
    length, motion = swim.robot.body.length, last_beat(swim)
    lines, nose = midlines(swim, frames) / length, nose_points(motion) / length
    step = -(nose[-1] - nose[0]) * np.exp(-1j * np.mean(motion.heading.values))
    return np.stack([_outline(swim, line - lines[:, 0].mean()) for line in lines]), np.array([step.real, step.imag])


def swimming_svg(swim: Swim) -> str:
    """Return an animated SVG of the swimming body over one beat."""
    shapes, step = outlines(swim)
    scale = 1000
    reach = 1.7 * float(np.abs(shapes[..., 1]).max()) * scale
    paths = ["M" + "L".join(f"{x * scale:.1f} {-y * scale:.1f}" for x, y in shape) + "z" for shape in shapes]
    seconds = f"{FRAMES * FRAME / 1000:g}s"
    dots = "".join(
        f'<circle cx="{x * scale:.0f}" cy="{-y * scale:.0f}" r="3.5"/>' for x, y in specks(step, reach / scale)
    )
    return (
        f'<svg class="fish" viewBox="-170 {-reach:.0f} 1340 {2 * reach:.0f}" role="img" '
        f'aria-label="{html.escape(swim.robot.name)} swimming">'
        f'<g class="water">{dots}<animateTransform attributeName="transform" type="translate" from="0 0" '
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


def specks(step: Array, reach: float) -> Array:
    """Place specks in the water so that they look the same after a beat; the rows are shifted against each other."""
    count = round(abs(float(step[0])) / DOTS)
    spacing = abs(float(step[0])) / count if count else DOTS
    along = np.arange(-0.3 - abs(step[0]), 1.3 + abs(step[0]), spacing)
    rows = np.arange(-reach, reach, DOTS) + DOTS / 2
    return np.array([(x + spacing * (0.618 * k % 1), y) for k, y in enumerate(rows) for x in along])
