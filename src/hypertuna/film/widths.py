"""Learn the widths of a fish from the pixels of a film, if its sections are not measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.film.sections import Body
from hypertuna.film.source import Gray
from hypertuna.film.view import View

BIN = 2.0  # px: length of a bin along the fish
BEYOND = 0.12  # body lengths before the nose and behind the tail that are searched for the fish's ends
ASIDE = 6.0  # px: margin beside the widest section within which pixels count
NOSE = (0.1, 0.5)  # fractions of the largest squared width: between them it is linear, and its line is 0 at the nose
FIN = (0.88, 0.95)  # body lengths from the nose: the tail tip is where the width falls to half of the width there

TINY = 1e-12  # m: keeps divisions finite


def learned(view: View, body: Body, fits: list[tuple[Gray, Array]]) -> Body:
    """Learn a body's widths and ends from frames with fitted unknowns, which may be shifted along the fish.

    Contrast summed over a strip across the fish is width times contrast, whether or not the picture is blurred.
    """
    total = float(body.length.sum())
    edges = np.linspace(-BEYOND, 1 + BEYOND, round((1 + 2 * BEYOND) * total / (BIN * view.pixel)) + 1) * total
    middle = (edges[1:] + edges[:-1]) / 2
    square, half = np.median([_measured(view, body, fit, edges) for fit in fits], axis=0)
    top = int(np.argmax(square))
    near_nose = np.arange(top)[(square[:top] > NOSE[0] * square[top]) & (square[:top] < NOSE[1] * square[top])]
    nose, tail = 0.0, total
    if len(near_nose) > 1 and (line := np.polyfit(middle[near_nose], square[near_nose], 1))[0] > 0:
        nose = float(np.clip(-line[1] / line[0], edges[0], middle[near_nose[0]]))
    half_fin = 0.5 * float(np.median(half[(middle > FIN[0] * total) & (middle < FIN[1] * total)]))
    thin = np.flatnonzero((half < half_fin) & (middle > FIN[0] * total))
    if half_fin > 0 and len(thin):
        k = int(thin[0])
        tail = float(np.interp(-half_fin, -half[k - 1 : k + 1], middle[k - 1 : k + 1]))
    inside = (middle > nose) & (middle < tail - BIN * view.pixel)
    squares = np.interp(nose + body.stations * (tail - nose) / total, np.append(nose, middle[inside]),
                        np.append(0.0, square[inside]))  # fmt: skip
    return replace(body, section=np.column_stack([np.maximum(squares, 0.0), body.section[:, 1]]), learned=True)


def shape_off(body: Body, shown: Body) -> float:
    """Return the difference of a body's widths, scaled to fit best, from those of a film, as a fraction of the area."""
    inner = slice(len(body.section) // 20, -(len(body.section) // 20))  # without the ends, which frames blur
    half, film = np.sqrt(body.section[inner, 0]), np.sqrt(shown.section[inner, 0])
    factor = float(half @ film) / max(float(half @ half), TINY)
    return float(np.abs(film - factor * half).sum()) / max(float(film.sum()), TINY)


def _measured(view: View, body: Body, fit: tuple[Gray, Array], edges: Array) -> tuple[Array, Array]:
    """Measure squared half widths [m^2] and apparent half widths [m] in a frame, per bin of distance from the nose [m].

    The apparent half widths include some of the height where the line of sight leans.
    """
    frame, unknowns = fit
    box, _ = view.box(body, unknowns)
    pixels = view.pixels(frame, box)
    points, heading = body.joints(unknowns)
    axis = np.stack([np.cos(heading), np.sin(heading)])
    size, links = float(np.exp(unknowns[3 + len(body.groups)])), len(body.length)
    from_joints = pixels[:, np.newaxis, :2] - points[:-1]
    along = from_joints[..., 0] * axis[0] + from_joints[..., 1] * axis[1]
    across = from_joints[..., 1] * axis[0] - from_joints[..., 0] * axis[1]
    low, high = np.zeros(links), size * body.length
    low[0], high[-1] = -np.inf, np.inf
    off_link = along - np.clip(along, low, high)
    link = np.argmin(off_link**2 + across**2, axis=1)
    nearest = np.arange(len(link)), link
    ends = np.append(0.0, np.cumsum(body.length))
    place = ends[link] + np.clip(along, low, high)[nearest] / size
    reach = size * float(np.sqrt(body.section[:, 0].max())) + ASIDE * view.pixel
    is_near = np.hypot(off_link, across)[nearest] < reach
    nose = view.camera.pixels(points[0], view.depth)
    seen = pixels[:, 4] * (view.camera.pixel_size(nose, view.depth) ** 2 / unknowns[-1])  # m^2 of the fish in a pixel
    area, _ = np.histogram(place[is_near], edges, weights=seen[is_near])
    lean = (pixels[:, 3] * axis[0][link] - pixels[:, 2] * axis[1][link])[is_near]
    count, _ = np.histogram(place[is_near], edges)
    mean = np.histogram(place[is_near], edges, weights=lean)[0] / np.maximum(count, 1)
    half = area / np.diff(edges) / (2 * size * size)
    middle = (edges[1:] + edges[:-1]) / 2
    half_height = np.interp(middle, body.stations, body.section[:, 1], left=0.0, right=0.0)
    return np.sign(half) * half**2 - half_height * mean**2, half
