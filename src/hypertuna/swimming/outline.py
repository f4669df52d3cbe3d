"""The swimming body as shapes, without matplotlib: midlines and outlines of a beat, and an animated SVG."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.pose import Points
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.swim import Swim
from hypertuna.swimming.trajectory import body_of, center_of, nose_points

if TYPE_CHECKING:
    import xarray as xr

MIDLINES = 12  # midlines drawn per beat
FRAMES = 32  # frames of an animation per beat
FRAME = 40  # ms, duration of a frame: on the screen a beat of any gait takes 1.3 s
GIRTH = 0.135  # largest thickness of the drawn body, body lengths; thickness is schematic, only the midline is computed
FIN = 0.006  # half thickness of the fin, body lengths
PEDUNCLE = 0.93  # distance from the nose to the fin, body lengths
SCALE = 1000  # SVG units per body length
DOTS = 0.08  # spacing of the specks in the water, body lengths


def last_beat(swim: Swim) -> xr.Dataset:
    """Return the last whole beat of a swim."""
    motion = swim.trajectory
    if swim.status == "diverged" or not np.isfinite(motion.x + motion.y + motion.heading).all():
        raise InputError("has nothing finite to draw", key="plot", fix="the gait diverged; try more steps per beat")
    beats = 1 if swim.from_rest is None else swim.beats
    return motion.isel(time=slice((beats - 1) * swim.steps, beats * swim.steps + 1))


def followed(lines: Points, heading: Array) -> Points:
    """Return midlines (times, links + 1) in a frame that follows the body's mean motion; heading (times,) [rad]."""
    nose, fraction = lines[:, 0], np.linspace(0, 1, len(lines))
    drift, turn = nose[0] + fraction * (nose[-1] - nose[0]), fraction * (heading[-1] - heading[0])
    spin = np.exp(-1j * (turn + np.mean(heading - turn)))
    result: Points = (lines - drift[:, np.newaxis]) * spin[:, np.newaxis]
    return result


def midlines(swim: Swim, count: int = MIDLINES) -> Points:
    """Return midlines over the last beat, (count, links + 1) [m], in a frame that follows the mean motion."""
    motion = last_beat(swim)
    return _frames(followed(body_of(swim.robot, motion), motion.heading.values), count)


def outlines(swim: Swim) -> tuple[Array, Array]:
    """Return outlines of the body over the last beat, in a frame in which the mean path goes straight to the left.

    Returns the outlines (frames, points, 2), and the displacement of the water in a beat (2,) [body lengths].
    """
    motion = last_beat(swim)
    step = water_step(swim.robot, nose_points(motion), motion.heading.values)
    return bodies(swim.robot, midlines(swim, FRAMES)), step


def water_step(robot: Robot, nose: Points, heading: Array) -> Array:
    """Return the displacement of the water past the body over a motion (2,) [body lengths]; nose [m], heading [rad]."""
    step = -(nose[-1] - nose[0]) / robot.body.length * np.exp(-1j * np.mean(heading))
    return np.array([step.real, step.imag])


def bodies(robot: Robot, lines: Points) -> Array:
    """Return outlines (frames, points, 2) [body lengths] of the body around midlines (frames, links + 1) [m]."""
    lines = lines / robot.body.length
    return np.stack([_outline(robot, line - lines[:, 0].mean()) for line in lines])


def swimming_svg(swim: Swim) -> str:
    """Return an animated SVG of the swimming body over one beat."""
    shapes, step = outlines(swim)
    seconds = FRAMES * FRAME / 1000
    return film_svg(np.concatenate([shapes, shapes[:1]]), step, seconds, seconds, f"{swim.robot.name} swimming")


def film_svg(shapes: Array, step: Array, period: float, seconds: float, label: str) -> str:
    """Return an animated SVG of bodies (frames, points, 2) [body lengths] in water that moves past them.

    step: displacement of the water in a period (2,) [body lengths]; if it is zero, no water is drawn. period: of the
    water [s]. seconds: duration of all frames [s].
    """
    reach = 1.7 * float(np.abs(shapes[..., 1]).max())
    dots = "".join(
        f'<circle cx="{SCALE * x:.0f}" cy="{-SCALE * y:.0f}" r="3.5"/>'
        for x, y in (specks(step, reach) if step.any() else ())
    )
    water = (
        f'<g class="water moving">{dots}<animateTransform attributeName="transform" type="translate" from="0 0" '
        f'to="{SCALE * step[0]:.1f} {-SCALE * step[1]:.1f}" dur="{period:.6g}s" repeatCount="indefinite"/></g>'
    )
    view = f"-170 {-SCALE * reach:.0f} 1340 {2 * SCALE * reach:.0f}"
    return _fish(view, label, (water if dots else "") + _moving(shapes, seconds), shapes[0])


def circling_svg(swim: Swim) -> str:
    """Return an animated SVG of a settled turn in real time: one beat, rotated about the center of the turn."""
    motion, length = last_beat(swim), swim.robot.body.length
    center, heading = center_of(motion), motion.heading.values
    unturn = np.exp(-1j * np.linspace(0, heading[-1] - heading[0], len(heading)))
    lines = (body_of(swim.robot, motion) - center) * unturn[:, np.newaxis] / length
    shapes = np.stack([_outline(swim.robot, line) for line in [*_frames(lines, FRAMES), lines[0]]])
    reach = SCALE * 1.05 * float(np.hypot(*np.moveaxis(shapes, -1, 0)).max())
    path = f'<circle class="mark" r="{SCALE * float(np.abs(lines[:, 0]).mean()):.0f}" stroke-width="4"/>'
    seconds, side = 2 * np.pi / abs(swim.turn_rate), -np.copysign(360, swim.turn_rate)
    spin = (
        f'<animateTransform attributeName="transform" type="rotate" from="0" to="{side:g}" dur="{seconds:.6g}s" '
        f'repeatCount="indefinite"/>'
    )
    fish = f"{path}<g>{spin}{_moving(shapes, 1 / swim.gait.frequency)}</g>"
    return _fish(f"{-reach:.0f} {-reach:.0f} {2 * reach:.0f} {2 * reach:.0f}", "turn", fish, shapes[0])


def _fish(view: str, label: str, moving: str, still: Array) -> str:
    """Return an SVG with the moving body, and with a still body for users who prefer reduced motion."""
    style = "@media (prefers-reduced-motion:reduce){.fish .moving{display:none}.fish .still{display:inline}}"
    return (
        f'<svg class="fish" viewBox="{view}" role="img" aria-label="{html.escape(label)}"><style>{style}</style>'
        f'{moving}<path class="body still" display="none" d="{_path(still)}"/></svg>'
    )


def _moving(shapes: Array, seconds: float) -> str:
    """Return an SVG path that cycles through outlines (frames, points, 2) [body lengths] in `seconds`."""
    paths = [_path(shape) for shape in shapes]
    return (
        f'<path class="body moving" d="{paths[0]}"><animate attributeName="d" dur="{seconds:.6g}s" '
        f'repeatCount="indefinite" values="{";".join(paths)}"/></path>'
    )


def _path(shape: Array) -> str:
    """Return the data of an SVG path along an outline (points, 2) [body lengths]."""
    points = (shape * [SCALE, -SCALE]).round().astype(int)
    steps = " ".join(f"{x} {y}" for x, y in np.diff(points, axis=0))
    return f"M{points[0, 0]} {points[0, 1]}l{steps}z".replace(" -", "-")


def _frames(lines: Points, count: int) -> Points:
    """Return `count` midlines at equal intervals of a beat, without the midline at the end of the beat."""
    return np.take(lines, np.linspace(0, len(lines) - 1, count, endpoint=False).astype(int), axis=0)


def slowed(swim: Swim) -> str:
    """Return the pace of the animation as text: "slowed down 3 times", "in real time"."""
    factor = FRAMES * FRAME / 1000 * swim.gait.frequency
    if factor > 1.05:
        return f"slowed down {factor:.2g} times"
    return f"sped up {1 / factor:.2g} times" if factor < 0.95 else "in real time"


def _outline(robot: Robot, line: Points) -> Array:
    """Return a fish-like polygon (points, 2) [body lengths] around a midline, given at the joints [body lengths]."""
    joints = np.concatenate([[0.0], np.cumsum(robot.links.length)]) / robot.body.length
    s = (1 - np.cos(np.linspace(0, np.pi, 61))) / 2
    # A smooth bend: interpolate the directions between the middles of the links, then integrate.
    middle = (joints[1:] + joints[:-1]) / 2
    angle = np.interp(s, middle, np.unwrap(np.angle(np.diff(line))))
    steps = np.diff(s) * np.exp(0.5j * (angle[1:] + angle[:-1]))
    center = line[0] + np.concatenate([[0], np.cumsum(steps)])
    # Half thickness: a NACA four-digit section that ends in a thin fin.
    t = s / PEDUNCLE
    section = 5 * GIRTH * (0.2969 * np.sqrt(t) - 0.1260 * t - 0.3516 * t**2 + 0.2843 * t**3 - 0.1036 * t**4)
    normal = 1j * np.exp(1j * angle) * np.where(t < 0.5, section, np.maximum(section, FIN))
    z = np.concatenate([center + normal, (center - normal)[::-1]])
    return np.stack([z.real, z.imag], axis=1)


def specks(step: Array, reach: float) -> Array:
    """Return places (specks, 2) [body lengths] of specks in the water; a shift by `step` keeps the pattern."""
    count = round(abs(float(step[0])) / DOTS)
    spacing = abs(float(step[0])) / count if count else DOTS
    along = np.arange(-0.3 - abs(step[0]), 1.3 + abs(step[0]), spacing)
    rows = np.arange(-reach, reach, DOTS) + DOTS / 2
    return np.array([(x + spacing * (0.618 * k % 1), y) for k, y in enumerate(rows) for x in along])
