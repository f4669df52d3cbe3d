"""Prepare the pixels of a film for the fit: contrast to the empty tank, and places at the fish's depth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.film.camera import Camera
from hypertuna.film.sections import Body
from hypertuna.film.source import Film, Gray, background_of

THRESHOLD = 0.45  # fraction of the fish's contrast above which a pixel may be of the fish
MIN_CONTRAST = 15.0  # gray levels
MIN_CONTRAST_TO_NOISE = 4.0  # ratio of the fish's contrast to the picture's noise
MOTION_WIDTH, EDGE = 480, 4  # px to which pictures are reduced to find their motion, and border left out
MARGIN = 14  # px around the fish
Box = tuple[slice, slice]  # rows and columns of a picture


@dataclass(frozen=True)
class View:
    """A film of a fish at one depth."""

    film: Film
    camera: Camera
    depth: float  # m of the fish below the surface
    background: Gray  # (height, width)
    dark: bool  # whether the fish is darker than the tank
    contrast: float  # gray levels: contrast of the fish to the tank
    noise: float  # gray levels: standard deviation of a pixel of the empty tank
    grid: NDArray[np.float32]  # (height, width, 4): place at the depth [m] and lean of the ray, by `Camera.sight`
    pixel: float  # m: size of a pixel at the fish's depth, in the middle of the picture
    motion: float = 0.0  # px by which the tank moves in the picture

    def difference(self, frame: Gray) -> Gray:
        """Return gray levels (height, width) by which a frame is darker than the tank, or brighter if not `dark`."""
        return np.asarray(_difference(self.background, frame, self.dark))

    def pixels(self, frame: Gray, box: Box) -> Array:
        """Return the pixels in a box as rows (n, 5): place [m], lean of the ray, contrast [gray levels]."""
        value = self.background[box].astype(float) - frame[box]
        value = value if self.dark else -value
        return np.concatenate([self.grid[box].reshape(-1, 4), value.reshape(-1, 1)], axis=1)

    def box(self, body: Body, unknowns: Array) -> tuple[Box, bool]:
        """Return the box of pixels around a silhouette, and whether the whole silhouette is in the picture."""
        points, _ = body.joints(unknowns)
        pixels = self.camera.pixels(points, self.depth, within=1.0)
        half_width = float(np.sqrt(body.section[:, 0].max())) / self.pixel
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        size = np.array([self.film.width, self.film.height])
        inside = bool((low > 1).all() and (high < size - 2).all())
        low = np.clip(low - half_width - MARGIN, 0, size).astype(int)
        high = np.clip(high + half_width + MARGIN, 0, size).astype(int)
        return (slice(low[1], high[1]), slice(low[0], high[0])), inside

    def parts(self, frame: Gray) -> list[Array]:
        """Return the pixels (n, 2), row and column, of each connected part that may be the fish, the largest first."""
        import cv2

        mask = (cv2.GaussianBlur(self.difference(frame), (3, 3), 0) > THRESHOLD * self.contrast).astype(np.uint8)
        _, label, statistics, _ = cv2.connectedComponentsWithStats(mask)
        order = 1 + np.argsort(-statistics[1:, 4])[:5]
        part_pixels = []
        for part in order:
            left, top, width, height, _ = statistics[part]
            rows, columns = np.nonzero(label[top : top + height, left : left + width] == part)
            part_pixels.append(np.column_stack([rows + top, columns + left]))
        return part_pixels


def view_of(film: Film, camera: Camera, depth: float, body: Body) -> tuple[View, Gray]:
    """Return the view of a film, and the sampled frames from which tank, contrast and noise were measured."""
    if (film.width, film.height) != (camera.width, camera.height):
        rule = f"must have the size of the camera's picture, {camera.width} x {camera.height}"
        value, fix = f"{film.width} x {film.height} pixels", "film and calibrate in the same mode"
        raise InputError(rule, file=film.file, value=value, fix=fix)
    u, v = np.meshgrid(np.arange(film.width, dtype=float), np.arange(film.height, dtype=float))
    grid = np.empty((film.height, film.width, 4), np.float32)
    for rows in np.array_split(np.arange(film.height), 16):  # a stripe at a time
        place, lean = camera.sight(np.stack([u[rows], v[rows]], axis=-1), depth)
        grid[rows] = np.concatenate([place, lean], axis=-1)
    pixel = camera.pixel_size([film.width / 2, film.height / 2], depth)
    samples = film.sample()
    background = background_of(samples)
    fish_area = body.area / pixel**2  # px of the fish
    levels = [_contrast(background, samples, dark, fish_area) for dark in (True, False)]
    dark, contrast = levels[0] >= levels[1], max(levels)
    differences = samples[:, ::4, ::4].astype(np.int16) - background[::4, ::4]
    noise = max(1.4826 * float(np.median(np.abs(differences))), 0.5)
    if contrast < max(MIN_CONTRAST, MIN_CONTRAST_TO_NOISE * noise):
        rule = f"must show a fish that is darker or brighter than the tank by {MIN_CONTRAST:g} gray levels"
        fix = "check that a fish swims through the picture, use a white floor and a dark fish, and let the waves settle"
        raise InputError(rule, file=film.file, key="contrast", value=f"{contrast:.1f}", fix=fix)
    motion = motion_of(background, samples, dark, contrast)
    return View(film, camera, depth, background, dark, contrast, noise, grid, pixel, motion), samples


def motion_of(background: Gray, samples: Gray, dark: bool, contrast: float) -> float:
    """Return how far the tank moves in the picture [px]: the 90 % quantile of the samples' shifts from the first.

    Each shift is that of least squares, beside a gain and an offset of the light, where no sample shows the fish.
    """
    import cv2

    step = max(int(background.shape[1]) // MOTION_WIDTH, 1)
    size = (background.shape[1] // step, background.shape[0] // step)
    tank = np.ones(size[::-1], bool)
    tank[[*range(EDGE), *range(-EDGE, 0)]] = tank[:, [*range(EDGE), *range(-EDGE, 0)]] = False

    def seen(sample: Gray) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        near = cv2.blur(_difference(background, sample, dark), (5, 5)) > THRESHOLD / 2 * contrast
        away = cv2.resize(cv2.dilate(near.astype(np.uint8), np.ones((25, 25), np.uint8)), size) == 0
        small = cv2.resize(sample, size, interpolation=cv2.INTER_AREA).astype(np.float32)
        return np.asarray(cv2.GaussianBlur(small, (0, 0), 2.0)), np.asarray(away & tank)

    first, own = seen(samples[0])
    by_y, by_x = (np.asarray(one) for one in np.gradient(first))
    shifts: list[float] = []
    for sample in samples[1:]:
        picture, both = seen(sample)
        both &= own
        rows = np.stack([by_x[both], by_y[both], first[both], np.ones(int(both.sum()))], axis=1).astype(float)
        shift: Any = np.linalg.lstsq(rows.T @ rows, rows.T @ picture[both].astype(float))[0]
        shifts.append(float(np.hypot(*shift[:2])))
    return step * float(np.quantile(shifts, 0.9))


def _difference(background: Gray, frame: Gray, dark: bool) -> Any:
    """Return gray levels (height, width) by which a frame is darker than the background, or brighter if not dark."""
    import cv2

    return cv2.subtract(background, frame) if dark else cv2.subtract(frame, background)


def _contrast(background: Gray, samples: Gray, dark: bool, size: float) -> float:
    """Return the median contrast [gray levels] of a fish darker, or else brighter, than the tank; size: area [px]."""
    import cv2

    levels = []
    for sample in samples:
        blurred = cv2.blur(_difference(background, sample, dark), (5, 5))
        areas = np.cumsum(np.bincount(blurred.ravel(), minlength=256)[::-1])[::-1]  # px at or above each level
        levels.append(float(np.flatnonzero(areas >= min(size / 3, areas[0]))[-1]))
    return float(np.median(levels))
