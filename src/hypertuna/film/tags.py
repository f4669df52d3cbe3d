"""ArUco tags on a robot: their centers in every frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.film.source import Film, Gray

MIN_SEEN = 0.1  # fraction of the frames: a tag seen in fewer is a false detection
MIN_TAGS = 3  # on a robot


def dictionaries() -> list[str]:
    """Return the names of known dictionaries, such as 4x4_50."""
    import cv2

    return [name.removeprefix("DICT_").lower() for name in dir(cv2.aruco) if name.startswith("DICT_")]


def detector_of(dictionary: str) -> Any:
    """Return OpenCV's detector of the tags of a dictionary."""
    import cv2

    name = dictionary.lower().removeprefix("dict_")
    if name not in dictionaries():
        fix = did_you_mean(name, dictionaries())
        raise InputError("must be a dictionary of OpenCV", key="--dictionary", value=shown(dictionary), fix=fix)
    constant = next(one for one in dir(cv2.aruco) if one.lower() == f"dict_{name}")
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    settings.cornerRefinementWinSize = 3
    settings.minMarkerPerimeterRate = 0.02
    return cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, constant)), settings)


def found_tags(detector: Any, frame: Gray) -> tuple[dict[int, Array], set[int]]:
    """Return the center (2,) [px] of each tag that a frame shows once, and the tags that it shows twice."""
    corners, ids, _ = detector.detectMarkers(frame)
    centers: dict[int, Array] = {}
    twice: set[int] = set()
    for corner, tag in zip(corners, [] if ids is None else ids.ravel().tolist(), strict=True):
        twice |= {tag} & centers.keys()
        centers[tag] = _middle(corner[0].astype(float))
    return {tag: center for tag, center in centers.items() if tag not in twice}, twice


def _middle(corner: Array) -> Array:
    """Return where the diagonals of corners (4, 2) cross: the tag's center, even if the tag is seen obliquely."""
    a, b = corner[2] - corner[0], corner[3] - corner[1]
    side = corner[1] - corner[0]
    part = (side[0] * b[1] - side[1] * b[0]) / (a[0] * b[1] - a[1] * b[0])
    return np.asarray(corner[0] + part * a)


def find_tags(
    film: Film, dictionary: str, wanted: list[int] | None, progress: Callable[[int, int], None]
) -> tuple[Array, list[int], list[str]]:
    """Return the centers (frames, tags, 2) [px] of tags, their numbers, and notes for the user.

    wanted: the tags on the robot, if they are known.
    """
    detector, count = detector_of(dictionary), len(film.time)
    found: list[dict[int, Array]] = [{} for _ in range(count)]
    seen_twice: set[int] = set()
    for number, frame in film.frames():
        found[number], doubled = found_tags(detector, frame)
        seen_twice |= doubled
        progress(number + 1, count)
    frame_counts = {tag: sum(tag in one for one in found) for one in found for tag in one}
    tags = wanted or sorted(tag for tag, times in frame_counts.items() if times >= MIN_SEEN * count)
    if sum(frame_counts.get(tag, 0) > 0 for tag in tags) < MIN_TAGS:
        _refuse(film, detector, dictionary, wanted, frame_counts)
    notes = [f"tags {', '.join(map(str, tags))} are followed"]
    for tag in sorted(seen_twice & set(tags)):
        notes.append(f"tag {tag} is there twice in some frames, and is missing there")
    if unused := sorted(set(frame_counts) - set(tags)):
        notes.append(f"tags without a use: {', '.join(map(str, unused))}")
    return np.array([[one.get(tag, [np.nan] * 2) for tag in tags] for one in found]), tags, notes


def _refuse(film: Film, detector: Any, dictionary: str, wanted: list[int] | None, frame_counts: dict[int, int]) -> None:
    """Raise an error for too few tags, with advice: the film may be mirrored, or the tags of another dictionary."""
    samples = film.sample()
    rule = f"must show {MIN_TAGS} tags of the dictionary {dictionary} at least"
    value = f"only {', '.join(map(str, sorted(frame_counts)))}" if frame_counts else "none"
    fix = "make them 24 px wide with a white border of one cell, and check --places"
    if sum(len(found_tags(detector, sample[:, ::-1].copy())[0]) for sample in samples) > len(samples):
        value, fix = "none, but their mirror images", "mirror the film back: ffmpeg -i FILM -vf hflip film.mp4"
    elif not frame_counts:
        for name in dictionaries():
            if sum(len(found_tags(detector_of(name), sample)[0]) for sample in samples[:5]) > 5:
                fix = f"is it --dictionary {name}?"
                break
    raise InputError(rule, file=film.file, key="the tags", value=value, fix=fix)
