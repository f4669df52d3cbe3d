"""The silhouette of a robot: its links, and the half widths and half heights of its sections from nose to tail."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.pose import coordinate_names, coordinate_shares
from hypertuna.description.robot import Robot
from hypertuna.description.shape import Shape
from hypertuna.errors import InputError
from hypertuna.film.numbers import read_rows
from hypertuna.ranges import Range

STATIONS = 201  # places from nose to tail tip at which sections are stored
COLUMNS = ("from_nose_m", "width_m", "height_m")  # of a file of sections
SIZE = Range(min=0, max=10, unit="m")  # of sections


@dataclass(frozen=True)
class SilhouetteFit:
    """The result of fitting a silhouette to the pixels of a frame."""

    unknowns: Array
    information: Array  # (unknowns, unknowns): Fisher information of the pixels, times the squared noise of a pixel
    seen: Array  # (links,): 1 where the pixels show all of a link's rear half
    noise: float  # gray levels: standard deviation of a pixel
    offset: float  # m: distance between drawn and seen edges


@dataclass(frozen=True)
class Body:
    """A chain of links with elliptical sections.

    Unknowns: x, y and heading of the nose, joint angles, logs of size and girth, contrast. Size multiplies all lengths
    and sections, girth the widths alone.
    """

    length: Array  # (links,) [m]
    share: Array  # (links, groups): heading of a link = that of the head + share @ joint angles
    section: Array  # (stations, 2): half width and half height, squared [m^2]
    groups: tuple[str, ...]
    measured: bool = False  # whether the sections are from a file
    learned: bool = False  # whether the widths are from the film
    file_off: float = 0.0  # fraction of the area by which a sections file was off, if the film's widths replaced it

    @property
    def unknowns(self) -> int:
        """Number of unknowns in the fit to one frame."""
        return 6 + len(self.groups)

    @property
    def stations(self) -> Array:
        """Distances of the stations from the nose [m]."""
        return np.linspace(0.0, float(self.length.sum()), len(self.section))

    @property
    def area(self) -> float:
        """Area of the silhouette from straight above [m^2]."""
        return float(2 * np.trapezoid(np.sqrt(self.section[:, 0]), self.stations))

    def fit(self, pixels: Array, start: Array, prior: tuple[Array, Array], stages: Array, loss: float) -> SilhouetteFit:
        """Fit the silhouette to pixels (n, 5); prior: mean and precision (times the squared noise) of the unknowns."""
        chain = (self.length, self.share, self.section)
        found = _core.fit_silhouette(pixels, *chain, start, *prior, stages, loss, ITERATIONS)
        noise, offset = map(float, found["noise_offset"])
        return SilhouetteFit(found["unknowns"], found["information"], found["seen"], noise, offset)

    def draw(self, pixels: Array, unknowns: Array, edge: float) -> dict[str, Any]:
        """Return values, derivatives and edge distances of a silhouette drawn over pixels (n, 5); edge: blur [m]."""
        return _core.draw_silhouette(pixels, self.length, self.share, self.section, unknowns, edge)

    def joints(self, unknowns: Array) -> tuple[Array, Array]:
        """Return the joints (..., links + 1, 2) [m] and the headings of the links (..., links) [rad]."""
        groups = len(self.groups)
        heading = unknowns[..., 2:3] + unknowns[..., 3 : 3 + groups] @ self.share.T
        size = np.exp(unknowns[..., 3 + groups, np.newaxis])
        steps = np.stack([np.cos(heading), np.sin(heading)], axis=-1) * (size * self.length)[..., np.newaxis]
        nose = unknowns[..., np.newaxis, :2]
        return np.concatenate([nose, nose + np.cumsum(steps, axis=-2)], axis=-2), heading

    def outline(self, unknowns: Array) -> Array:
        """Return the outline (points, 2) [m] seen from straight above, for pictures."""
        points, heading = self.joints(unknowns)
        ends = np.append(0.0, np.cumsum(self.length))
        link = np.clip(np.searchsorted(ends, self.stations, side="right") - 1, 0, len(self.length) - 1)
        size, girth = np.exp(unknowns[3 + len(self.groups) : 5 + len(self.groups)])
        axis = np.stack([np.cos(heading), np.sin(heading)], axis=-1)[link]
        middle = points[link] + size * (self.stations - ends[link])[:, np.newaxis] * axis
        side = size * girth * np.sqrt(self.section[:, :1]) * np.stack([-axis[:, 1], axis[:, 0]], axis=-1)
        return np.concatenate([middle + side, (middle - side)[::-1]])


ITERATIONS = 15  # Levenberg-Marquardt iterations per stage of a fit


def body_of(robot: Robot, file: str | Path | None = None) -> Body:
    """Return the silhouette of a robot: sections from a CSV file, or else estimated from lengths, areas and mass."""
    length = np.array(robot.links.length)
    share = np.cumsum(coordinate_shares(robot), axis=0)
    stations = np.linspace(0.0, float(length.sum()), STATIONS)
    half_sizes = _estimated(robot, stations) if file is None else _read(file, stations)
    return Body(length, share, half_sizes**2, coordinate_names(robot), file is not None)


def _estimated(robot: Robot, stations: Array) -> Array:
    """Estimate half widths and half heights (stations, 2) [m]: a slender fish with the lateral areas of the links."""
    shape = Shape.of(robot.body.length, robot.body.mass)
    station, height, width = shape.sections(0.0, shape.length)
    ends = np.append(0.0, np.cumsum(robot.links.length)) / float(np.sum(robot.links.length)) * shape.length
    for begin, end, area in zip(ends[:-1], ends[1:], robot.links.lateral_area, strict=True):
        in_link = (station >= begin) & (station < end)
        height[in_link] *= area / (end - begin) / height[in_link].mean()
    place = stations / stations[-1] * shape.length
    half = np.column_stack([np.interp(place, station, column, left=0.0) / 2 for column in (width, height)])
    half[0] = 0.0
    return half


def _read(path: str | Path, stations: Array) -> Array:
    """Read half widths and half heights (stations, 2) [m] of sections from a CSV file."""
    advice = "measure widths and heights at a dozen stations, nose and tail tip among them"
    rows = read_rows(path, COLUMNS, SIZE, advice)
    place, width, height = rows.T
    total = float(stations[-1])
    if len(rows) < 3 or (np.diff(place) <= 0).any() or abs(place[0]) > 0 or abs(place[-1] / total - 1) > 0.02:
        rule = f"must go in rising order from 0 at the nose to {total:g} at the tail tip, in three lines at least"
        raise InputError(rule, file=str(path), key="from_nose_m", fix="correct the stations, or the robot's lengths")
    return np.column_stack([np.interp(stations, place, column) / 2 for column in (width, height)])
