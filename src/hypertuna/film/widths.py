"""Widths of a fish whose sections are not measured, learned from the pixels of a film."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.film.sections import Body
from hypertuna.film.source import Gray
from hypertuna.film.view import View

BINS = 2.0  # px along the fish
BEYOND = 0.12  # lengths before the nose and behind the tail that are looked at
ASIDE = 6.0  # px beside the widest section
NOSE = (0.1, 0.5)  # of the largest squared width: between these it is taken as linear, from 0 at the nose
FIN = (0.88, 0.95)  # lengths from the nose: half of the width there is at the tail tip

TINY = 1e-12  # m


def learned(view: View, body: Body, fits: list[tuple[Gray, Array]]) -> Body:
    """Return a body of the widths that frames show, by the silhouette in each; it may lie along the fish by some way.

    A strip across the fish holds its width times its contrast, blurred or not.
    """
    total = float(body.length.sum())
    edges = np.linspace(-BEYOND, 1 + BEYOND, round((1 + 2 * BEYOND) * total / (BINS * view.pixel)) + 1) * total
    middle = (edges[1:] + edges[:-1]) / 2
    square, half = np.median([_shown(view, body, one, edges) for one in fits], axis=0)
    top = int(np.argmax(square))
    front = np.arange(top)[(square[:top] > NOSE[0] * square[top]) & (square[:top] < NOSE[1] * square[top])]
    nose, tail = 0.0, total
    if len(front) > 1 and (line := np.polyfit(middle[front], square[front], 1))[0] > 0:
        nose = float(np.clip(-line[1] / line[0], edges[0], middle[front[0]]))
    level = 0.5 * float(np.median(half[(middle > FIN[0] * total) & (middle < FIN[1] * total)]))
    behind = np.flatnonzero((half < level) & (middle > FIN[0] * total))
    if level > 0 and len(behind):
        k = int(behind[0])
        tail = float(np.interp(-level, -half[k - 1 : k + 1], middle[k - 1 : k + 1]))
    known = (middle > nose) & (middle < tail - BINS * view.pixel)
    own = np.interp(nose + body.stations * (tail - nose) / total, np.append(nose, middle[known]),
                    np.append(0.0, square[known]))  # fmt: skip
    return replace(body, section=np.column_stack([np.maximum(own, 0.0), body.section[:, 1]]), learned=True)


def shape_off(body: Body, shown: Body) -> float:
    """Return by which part of the area the widths of a body differ from those that a film shows, but for one factor."""
    own = slice(len(body.section) // 20, -(len(body.section) // 20))  # without the ends, which frames blur
    half, film = np.sqrt(body.section[own, 0]), np.sqrt(shown.section[own, 0])
    factor = float(half @ film) / max(float(half @ half), TINY)
    return float(np.abs(film - factor * half).sum()) / max(float(film.sum()), TINY)


def _shown(view: View, body: Body, fit: tuple[Gray, Array], edges: Array) -> tuple[Array, Array]:
    """Return squared half widths (bins,) [m^2] between ways from the nose, and the half widths [m] that a frame shows.

    The latter hold some of the height where the line of sight leans.
    """
    frame, unknowns = fit
    box, _ = view.box(body, unknowns)
    pixels = view.pixels(frame, box)
    points, heading = body.joints(unknowns)
    axis = np.stack([np.cos(heading), np.sin(heading)])
    size, links = float(np.exp(unknowns[3 + len(body.groups)])), len(body.length)
    away = pixels[:, np.newaxis, :2] - points[:-1]
    along = away[..., 0] * axis[0] + away[..., 1] * axis[1]
    across = away[..., 1] * axis[0] - away[..., 0] * axis[1]
    low, high = np.zeros(links), size * body.length
    low[0], high[-1] = -np.inf, np.inf
    over = along - np.clip(along, low, high)
    link = np.argmin(over**2 + across**2, axis=1)
    own = np.arange(len(link)), link
    ends = np.append(0.0, np.cumsum(body.length))
    place = ends[link] + np.clip(along, low, high)[own] / size
    reach = size * float(np.sqrt(body.section[:, 0].max())) + ASIDE * view.pixel
    near = np.hypot(over, across)[own] < reach
    at = view.camera.pixels(points[0], view.depth)
    part = pixels[:, 4] * (view.camera.pixel_size(at, view.depth) ** 2 / unknowns[-1])  # m^2 of the fish in a pixel
    area, _ = np.histogram(place[near], edges, weights=part[near])
    lean = (pixels[:, 3] * axis[0][link] - pixels[:, 2] * axis[1][link])[near]
    count, _ = np.histogram(place[near], edges)
    mean = np.histogram(place[near], edges, weights=lean)[0] / np.maximum(count, 1)
    half = area / np.diff(edges) / (2 * size * size)
    middle = (edges[1:] + edges[:-1]) / 2
    tall = np.interp(middle, body.stations, body.section[:, 1], left=0.0, right=0.0)
    return np.sign(half) * half**2 - tall * mean**2, half
