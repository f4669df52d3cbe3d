"""The camera over a tank: maps pixels to places at the fish's depth, through lens and water surface."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError

from hypertuna.arrays import Array
from hypertuna.description.mistakes import translate
from hypertuna.description.schema.base import Check, Degrees, Part, Positive, Real, entry, number
from hypertuna.errors import InputError
from hypertuna.io.door import read_toml
from hypertuna.io.files import write_atomically
from hypertuna.ranges import Range
from hypertuna.trials.importers import manifest_text

LENS_ITERATIONS = 12  # fixed-point iterations that invert the lens distortion
Pixels = Annotated[int, number(Range(min=16, max=20_000))]
Index = Annotated[float, number(Range(min=1, max=2))]
Lens = Annotated[float, number(Range(min=-1, max=1))]


class Camera(Part):
    """A camera over a tank. x and y lie in the water's surface, z is up; in an untilted picture x is right and y up."""

    format: Literal[1] = entry("version of this format, 1", default=1)
    width: Pixels = entry("width of the picture", "", key="width_px")
    height: Pixels = entry("height of the picture", "", key="height_px")
    focal: Positive = entry("focal length", "", key="focal_px")
    center: tuple[Real, Real] = entry(
        "pixel on the axis of the lens, from the center of the first", "", key="center_px"
    )
    lens_k1: Lens = entry("radial distortion: r (1 + k1 r^2), r in focal lengths (default: 0)", default=0.0)
    place: tuple[Real, Real, Positive] = entry("place of the camera; z is its height over the water", "m")
    tilt: tuple[Degrees, Degrees, Degrees] = entry(
        "rotation vector from looking straight down (default: 0)", "deg", default=(0.0, 0.0, 0.0)
    )
    refractive_index: Index = entry("of the water; 1 for a fish in air", default=1.333)

    def _checks(self) -> Iterator[Check]:
        down = -self.axes[2, 2]
        fix = "turn the camera down, or give the tilt in degrees"
        yield Check(down > 0.5, "tilt", "must leave the camera within 60 degrees of straight down", fix)

    @property
    def off_vertical(self) -> float:
        """Angle between the camera's axis and straight down [rad]."""
        x, y, z = self.axes[:, 2]
        return float(np.arctan2(np.hypot(x, y), -z))

    @property
    def axes(self) -> Array:
        """Rotation matrix (3, 3) from picture axes (right, down, along the line of sight) to tank axes."""
        vector = np.array(self.tilt)
        angle = float(np.linalg.norm(vector))
        x, y, z = vector / angle if angle > 0 else vector
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        return np.asarray(rotation @ np.diag([1.0, -1.0, -1.0]))

    def sight(self, pixels: ArrayLike, depth: float) -> tuple[Array, Array]:
        """Return the places (..., 2) [m] that pixels (..., 2) see at a depth [m], and the lean (..., 2) of each ray.

        The lean is the horizontal distance that the line of sight covers under water per unit of height.
        """
        distorted = (np.asarray(pixels, dtype=float) - self.center) / self.focal
        undistorted = distorted.copy()
        for _ in range(LENS_ITERATIONS):
            undistorted = distorted / (1 + self.lens_k1 * (undistorted**2).sum(axis=-1, keepdims=True))
        axes, (x, y, height) = self.axes, self.place
        ray = undistorted @ axes[:, :2].T + axes[:, 2]
        slope = ray[..., :2] / -ray[..., 2:]  # in air: horizontal distance per unit of descent
        tangent = np.linalg.norm(slope, axis=-1, keepdims=True)
        sine = tangent / np.hypot(1.0, tangent) / self.refractive_index
        slope_in_water = slope * np.divide(
            sine / np.sqrt(1 - sine**2),
            tangent,
            out=np.full_like(tangent, 1 / self.refractive_index),
            where=tangent > 0,
        )
        return np.array([x, y]) + height * slope + depth * slope_in_water, -slope_in_water

    def pixel_size(self, pixel: ArrayLike, depth: float) -> float:
        """Return the size [m] of a pixel's footprint at a depth [m]: the square root of its area."""
        u, v = np.asarray(pixel, dtype=float)
        corners, _ = self.sight([[u - 0.5, v], [u + 0.5, v], [u, v - 0.5], [u, v + 0.5]], depth)
        a, b = corners[1] - corners[0], corners[3] - corners[2]
        return float(np.sqrt(abs(a[0] * b[1] - a[1] * b[0])))

    def pixels(self, places: ArrayLike, depth: float, within: float = 1e-6) -> Array:
        """Return the pixels (..., 2) that see places (..., 2) [m] at a depth [m], by Newton's method on `sight`.

        within: step [px] below which the iteration ends.
        """
        places = np.asarray(places, dtype=float)
        pixel = np.broadcast_to(np.array(self.center), places.shape).copy()
        for _ in range(20):
            neighbors = np.stack([pixel, pixel + np.array([1.0, 0.0]), pixel + np.array([0.0, 1.0])])
            center, right, below = self.sight(neighbors, depth)[0]
            jacobian = np.stack([right - center, below - center], axis=-1)
            step = np.linalg.solve(jacobian, (places - center)[..., np.newaxis])[..., 0]
            pixel += step
            if np.abs(step).max(initial=0.0) < within:
                break
        return pixel


def read_camera(path: str | Path) -> Camera:
    """Read a camera from a TOML file."""
    document = read_toml(path)
    try:
        return Camera.model_validate(document)
    except ValidationError as error:
        raise translate(error, document, Camera, str(path)) from None
    except InputError as error:
        raise InputError(error.rule, file=str(path), key=error.key, value=error.value, fix=error.fix) from None


def write_camera(camera: Camera, path: str | Path, comment: str) -> None:
    """Write a camera to a TOML file."""
    values = camera.model_dump(mode="json", by_alias=True)
    write_atomically(path, manifest_text(_rounded(values), comment).encode())


def _rounded(value: Any) -> Any:
    """Return the values of a camera file with their numbers rounded to eight digits."""
    if isinstance(value, dict):
        return {key: _rounded(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(part) for part in value]
    return float(f"{value:.8g}") if isinstance(value, float) else value
