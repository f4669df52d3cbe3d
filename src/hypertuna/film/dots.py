"""Colored dots on a robot: find their centers in a frame, order them along the body, follow them between frames."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.film.source import Film, Gray, background_of

# Named colors of dots as #rrggbb; only the hue is used.
COLORS = {
    "red": "#ff0000",
    "orange": "#ff8000",
    "yellow": "#ffff00",
    "green": "#00c000",
    "cyan": "#00ffff",
    "blue": "#0000ff",
    "magenta": "#ff00ff",
}
MIN_COLOR = 15.0  # smallest distance in a and b of CIE Lab from the color of the empty tank
MIN_AREA = 5  # px
LARGE, SMALL = 1.45, 0.3  # times the usual area: above LARGE two dots touch, below SMALL it is no whole dot
GATE = 0.5  # largest distance of a dot from its expected place, over the least distance between neighbors
MAX_LOST = 0.2  # s without dots, after which the search starts anew
MIN_DOTS = 3  # on a robot
RIM = 2  # px around a dot whose pixels also count toward its center
Blobs = tuple[Array, Array]  # centers (n, 2) [px] and areas (n,) [px]


@dataclass(frozen=True)
class Palette:
    """The color of dots: the direction and the distance by which it differs from the color of the empty tank."""

    tank: NDArray[np.float32]  # (height, width, 2): a and b of CIE Lab
    hue: Array | None  # (2,): unit vector in the plane of a and b; None for any color
    level: float = MIN_COLOR  # peak strength of a dot's color, as `__call__` returns it

    def __call__(self, frame: Gray) -> Array:
        """Return how strongly each pixel (height, width) has the color of a dot."""
        difference = _chroma(frame) - self.tank
        if self.hue is None:
            return np.asarray(np.hypot(difference[..., 0], difference[..., 1]))
        along = difference @ self.hue
        return np.asarray(along - np.abs(difference @ np.array([-self.hue[1], self.hue[0]], np.float32)))

    def blobs(self, frame: Gray) -> Blobs:
        """Return the centers (n, 2) [px] and the areas (n,) [px] of the dots in a frame."""
        import cv2

        strong = self(frame)
        _, label, stats, _ = cv2.connectedComponentsWithStats((strong > 0.5 * self.level).astype(np.uint8))
        centers, areas = [], []
        for k in range(1, len(stats)):
            left, top, wide, high, area = stats[k]
            if area < MIN_AREA:
                continue
            box = (slice(max(top - RIM, 0), top + high + RIM), slice(max(left - RIM, 0), left + wide + RIM))
            weight = np.where((label[box] == k) | (label[box] == 0), np.maximum(strong[box] - 0.15 * self.level, 0), 0)
            u, v = box[1].start + np.arange(weight.shape[1]), box[0].start + np.arange(weight.shape[0])
            centers.append(np.array([weight.sum(axis=0) @ u, weight.sum(axis=1) @ v]) / weight.sum())
            areas.append(area)
        return np.array(centers).reshape(-1, 2), np.array(areas, dtype=float)


def _chroma(frame: Gray) -> Array:
    """Return the color a and b (height, width, 2), in CIE Lab, of each pixel of a frame."""
    import cv2

    return np.asarray(cv2.cvtColor(frame, cv2.COLOR_BGR2LAB)[..., 1:])


def hue_of(color: str) -> Array:
    """Return the direction (2,) of a color, given by name or as #rrggbb, from gray in CIE Lab."""
    import cv2

    text = COLORS.get(color.lower(), color).removeprefix("#")
    try:
        red, green, blue = bytes.fromhex(text)
    except ValueError:
        fix = f"give one of {', '.join(COLORS)}, or #rrggbb as a picture viewer shows it"
        raise InputError("must be a color", key="--dot-color", value=shown(color), fix=fix) from None
    chroma = (
        cv2.cvtColor(np.array([[[blue, green, red]]], np.uint8), cv2.COLOR_BGR2LAB)[0, 0, 1:].astype(np.float32) - 128
    )
    size = float(np.hypot(*chroma))
    if size < MIN_COLOR:
        fix = "paint the dots in a strong color"
        raise InputError("must be a color, not a gray", key="--dot-color", value=shown(color), fix=fix)
    return np.asarray(chroma / size)


def palette_of(film: Film, color: str | None) -> tuple[Palette, int, float]:
    """Return the palette of a film's dots, their number in most of its samples, and their usual area [px]."""
    samples = film.sample(colors=True)
    # the median of a and b: medians of red, green and blue alone could mix fish, dots and tank to a color of none
    tank = background_of(np.stack([_chroma(sample) for sample in samples])).astype(np.float32)
    palette = Palette(tank, None if color is None else hue_of(color))
    import cv2

    level = float(np.median([cv2.blur(palette(sample), (3, 3)).max() for sample in samples]))
    if level < MIN_COLOR:
        rule = f"must show dots whose color differs from the tank's by {MIN_COLOR:g} of CIE Lab"
        fix = "paint strong colors, film in white light, and let the robot swim: what stays belongs to the tank"
        raise InputError(rule, file=film.file, key="the dots", value=f"{level:.1f}", fix=fix)
    palette = Palette(tank, palette.hue, level)
    areas = [palette.blobs(sample)[1] for sample in samples]
    usual_area = float(np.median(np.concatenate(areas)))
    counts = np.bincount([int((area > SMALL * usual_area).sum()) for area in areas])
    return palette, int(np.argmax(counts[1:])) + 1 if len(counts) > 1 else 0, usual_area


def along_body(points: Array) -> Array:
    """Return the order (n,) of points (n, 2) along the body: of all nearest-neighbor paths, the shortest."""
    distance = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    paths = []
    for first in range(len(points)):
        path, rest = [first], set(range(len(points))) - {first}
        while rest:
            path.append(min(rest, key=lambda k: distance[path[-1], k]))
            rest.remove(path[-1])
        paths.append(path)
    return np.array(min(paths, key=lambda path: distance[path[:-1], path[1:]].sum()))


@dataclass
class Follower:
    """Follows dots from frame to frame. `place` (count, 2) [px] estimates all dots, also those not seen now."""

    count: int
    usual: float  # px: usual area of a dot
    rate: float  # Hz
    place: Array | None = None
    step: Array = field(default_factory=lambda: np.zeros(2))  # px per frame: mean motion of the dots
    lost: int = 0  # frames since dots were seen
    begun: list[int] = field(default_factory=list)  # frames at which the search started anew
    touching: int = 0  # number of frames in which dots touch, and so look like one

    def next(self, number: int, blobs: Blobs) -> Array:
        """Return the dots (count, 2) [px] in the next frame, NaN where a dot is missing."""
        centers, areas = blobs[0][blobs[1] > SMALL * self.usual], blobs[1][blobs[1] > SMALL * self.usual]
        if self.place is None or self.lost > MAX_LOST * self.rate:
            return self._anew(number, centers, areas)
        expected = self.place + self.step
        gate = GATE * float(np.linalg.norm(np.diff(self.place, axis=0), axis=1).min()) + np.linalg.norm(self.step)
        distance = np.linalg.norm(expected[:, np.newaxis] - centers, axis=2)
        dot, blob = linear_sum_assignment(np.where(distance < gate, distance, 10 * gate)) if len(centers) else ([], [])
        dots = np.full((self.count, 2), np.nan)
        merged = False
        for k, j in zip(dot, blob, strict=True):
            if distance[k, j] >= gate:
                continue
            if areas[j] > LARGE * self.usual:
                merged = True
                continue
            dots[k] = centers[j]
        self.touching += merged
        seen = np.isfinite(dots[:, 0])
        if seen.sum() < max(2, self.count / 2):
            self.lost += 1
            return np.full((self.count, 2), np.nan)
        moved = np.where(seen[:, np.newaxis], dots, _carried(self.place[seen], dots[seen], self.place))
        self.step = (moved - self.place).mean(axis=0) / (self.lost + 1)
        self.place, self.lost = moved, 0
        return dots

    def _anew(self, number: int, centers: Array, areas: Array) -> Array:
        """Find the dots (count, 2) [px] without earlier frames; return NaN unless exactly `count` dots are seen."""
        if len(centers) != self.count or (areas > LARGE * self.usual).any():
            self.lost += 1
            return np.full((self.count, 2), np.nan)
        self.place, self.step, self.lost = centers[along_body(centers)], np.zeros(2), 0
        self.begun.append(number)
        return self.place.copy()


def _carried(before: Array, after: Array, points: Array) -> Array:
    """Move points (n, 2) [px] by the translation and rotation that best map `before` to `after` (m, 2) [px]."""
    old, new = (before - before.mean(axis=0)) @ [1, 1j], (after - after.mean(axis=0)) @ [1, 1j]
    turn = np.exp(1j * np.angle((new * old.conj()).sum()))
    rotated = ((points - before.mean(axis=0)) @ [1, 1j]) * turn
    return np.asarray(np.stack([rotated.real, rotated.imag], axis=1) + after.mean(axis=0))


def follow_dots(
    film: Film, color: str | None, count: int | None, progress: Callable[[int, int], None]
) -> tuple[Array, list[int], list[str]]:
    """Return dots (frames, dots, 2) [px] in order along the body, the frames at which a search began, and notes.

    count: number of dots, if it is known. A new search does not use earlier frames, so it may count the dots from the
    other end of the body.
    """
    palette, seen_count, usual_area = palette_of(film, color)
    count = seen_count if count is None else count
    if count < MIN_DOTS:
        fix = "paint a dot on each link at least, and give their color by --dot-color"
        raise InputError(f"must show {MIN_DOTS} colored dots at least", file=film.file, value=f"{count}", fix=fix)
    follower, dots = Follower(count, usual_area, film.rate), np.full((len(film.time), count, 2), np.nan)
    for number, blobs in _blobs(film, palette):
        dots[number] = follower.next(number, blobs)
        progress(number + 1, len(film.time))
    if not follower.begun:
        rule, fix = f"must show all {count} dots apart in one frame at least", "check --places and --dot-color"
        raise InputError(rule, file=film.file, value=f"{seen_count} in most frames", fix=fix)
    notes = [f"{count} dots of {np.sqrt(4 * usual_area / np.pi):.1f} px are followed"]
    if follower.touching:
        notes.append(f"dots of one color touch in {follower.touching} frames, and are missing there")
    return dots, follower.begun, notes


def _blobs(film: Film, palette: Palette) -> Iterator[tuple[int, Blobs]]:
    """Yield the number of each frame of a film, and the centers and areas of its dots."""
    for number, frame in film.colors():
        yield number, palette.blobs(frame)
