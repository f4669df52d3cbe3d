"""Dots or tags in a film, as tracked points on the swimming plane like those read from a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, shown
from hypertuna.film.camera import Camera
from hypertuna.film.dots import follow_dots
from hypertuna.film.noise import beat_of
from hypertuna.film.pace import pace_warnings
from hypertuna.film.source import Film
from hypertuna.film.tags import find_tags
from hypertuna.io.door import RUNS
from hypertuna.io.tables import read_table
from hypertuna.trials.marker_places import Places, read_places
from hypertuna.trials.marker_run import MarkerRun
from hypertuna.trials.points import Points, Rows

MIN_FORWARD = 0.1  # body lengths that dots must swim for the motion to tell nose from tail
MISFIT_RATIO = 2.0  # ratio of the misfits of both orders, above which the gaps between dots tell nose from tail


@dataclass(frozen=True)
class Marks:
    """Marks painted or glued on a robot: dots of a color, or tags of a dictionary."""

    kind: str  # "dots" or "tags"
    color: str | None = None  # color of dots; None for any
    dictionary: str = "4x4_50"  # OpenCV's dictionary of the tags
    places: str | Path | None = None  # CSV file of the marks' places on the robot


def points_of(
    robot: Robot, film: Film, camera: Camera, depth: float, marks: Marks, progress: Callable[[int, int], None]
) -> Points:
    """Find the marks in a film, at a depth [m]; return dots from nose to tail, or tags in order of their numbers."""
    if (film.width, film.height) != (camera.width, camera.height):
        rule = f"must have the size of the camera's picture, {camera.width} x {camera.height}"
        value, fix = f"{film.width} x {film.height} pixels", "film and calibrate in the same mode"
        raise InputError(rule, file=film.file, value=value, fix=fix)
    places = _places(marks.places, robot) if marks.places is not None else None
    if marks.kind == "tags":
        wanted = [_tag_number(name, str(marks.places)) for name in places.names] if places is not None else None
        pixels, tags, notes = find_tags(film, marks.dictionary, wanted, progress)
        names = [str(tag) for tag in tags] if places is None else [*places.names]
    else:
        pixels, starts, notes = follow_dots(film, marks.color, None if places is None else len(places.names), progress)
        names = [f"dot{k + 1}" for k in range(pixels.shape[1])] if places is None else [*places.names]
    place = np.full(pixels.shape, np.nan)
    seen = np.isfinite(pixels[..., 0])
    place[seen] = camera.sight(pixels[seen], depth)[0]
    if marks.kind == "dots":
        place = _nose_first(place, starts, None if places is None else _from_nose(places, robot), film.file)
        seen = np.isfinite(place[..., 0])
    parts = zip(names, seen.mean(axis=0), strict=True)
    missing = "; ".join(f"{name} in {100 * (1 - part):.0f} %" for name, part in parts if part < 0.9)
    notes += [f"missing: {missing} of the frames"] if missing else []
    kept = np.flatnonzero(seen.any(axis=1))
    return Points(
        form=f"a film of {marks.kind}",
        file=film.file,
        names=tuple(names),
        place=place[kept],
        weight=np.where(seen, 1.0, 0.0)[kept],
        where=Rows("frame", kept.tolist()),
        time=film.time[kept],
        time_unit=1.0,
        length_unit=1.0,
        y_down=False,
        notes=tuple(notes),
    )


def judged(run: MarkerRun, robot: Robot, rate: float) -> tuple[MarkerRun, tuple[Array, float] | None]:
    """Return the run with warnings about its beat added, and the noise of ripples; rate: frames per second [Hz].

    The noise: standard deviations (groups,) [rad] of the joint angles and their memory [s]; None without a steady beat.
    """
    frames = np.concatenate(run.stretches) if run.stretches else np.zeros(0, dtype=int)
    beat = beat_of(run.markers.time[frames], run.fit.angle[frames]) if len(frames) else None
    if beat is None:
        return run, None
    notes = (*run.markers.notes, *pace_warnings(robot, beat.frequency, rate))
    run = replace(run, markers=replace(run.markers, notes=notes))
    return run, (np.maximum(beat.noise, np.median(run.fit.sd[frames, 3:], axis=0)), beat.memory)


def _places(path: str | Path, robot: Robot) -> Places:
    """Read the places of marks on the robot from a file, and sort them from nose to tail."""
    table = read_table(path, RUNS)
    names = table.parse(lambda _, cells: cells.get("marker", ""))
    places = read_places(path, robot, names)
    order = np.argsort(_from_nose(places, robot), kind="stable")
    return Places(*(tuple(column[k] for k in order) for column in places))


def _from_nose(places: Places, robot: Robot) -> Array:
    """Return the distance of each place from the nose [m]."""
    length = np.array(robot.links.length)
    return np.asarray((np.cumsum(length) - length)[list(places.link)] + places.along)


def _tag_number(name: str, file: str) -> int:
    """Return the number of a tag from its name, such as 7 from "tag 7"."""
    text = name.lower().removeprefix("tag").strip()
    if not text.isdecimal():
        fix = "write the number that the tag shows"
        raise InputError("must be the number of a tag", file=file, key="marker", value=shown(name), fix=fix)
    return int(text)


def _nose_first(place: Array, begun: list[int], from_nose: Array | None, file: str) -> Array:
    """Order dots (frames, dots, 2) [m] from nose to tail, told apart by the gaps between dots or by the motion.

    begun: frames at which the search for dots began, each of which may have counted from the other end. Dots are NaN
    up to the next of these frames where neither gaps nor motion tell the nose.
    """
    ends, place, decided = [*begun[1:], len(place)], place.copy(), 0
    for first, end in zip(begun, ends, strict=True):
        direction = _forward(place[first:end], from_nose)
        if direction == 0:
            place[first:end] = np.nan
        elif direction < 0:
            place[first:end] = place[first:end, ::-1]
        decided += direction != 0
    if not decided:
        rule = f"must tell the nose from the tail: by {MIN_FORWARD:g} lengths that the robot swims head first"
        fix = "film a longer way, or give the places of dots at unequal distances by --places"
        raise InputError(rule, file=file, key="the dots", fix=fix)
    return place


def _forward(place: Array, from_nose: Array | None) -> int:
    """Return 1 if dots (frames, dots, 2) are counted from the nose, -1 if from the tail, 0 if that is not known."""
    gaps = np.linalg.norm(np.diff(place, axis=1), axis=2)
    complete = np.isfinite(gaps).all(axis=1)
    if not complete.any():
        return 0
    if from_nose is not None:
        gap, given = np.median(gaps[complete], axis=0), np.diff(from_nose)
        misfit, misfit_reversed = (float(np.abs(gap - one).sum()) for one in (given, given[::-1]))
        if max(misfit, misfit_reversed) > MISFIT_RATIO * min(misfit, misfit_reversed):
            return 1 if misfit < misfit_reversed else -1
    centered = place[complete]
    middle, facing = centered.mean(axis=1), centered[:, 0] - centered[:, -1]
    length = float(np.median(gaps[complete].sum(axis=1)))
    facing = facing / np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-9)
    forward = float((np.diff(middle, axis=0) * facing[:-1]).sum())
    return 0 if abs(forward) < MIN_FORWARD * length else 1 if forward > 0 else -1
