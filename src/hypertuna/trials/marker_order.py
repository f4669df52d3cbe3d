"""Find the order of markers along the body, if no places are given for them."""

import re
from collections.abc import Sequence

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.trials.markers import Markers

INVERTED = 0.35  # mean spacings by which a marker may lie ahead of the marker before it
MAX_FRAMES = 200  # about the number of frames from which the order is found


def in_order(markers: Markers) -> tuple[list[int], tuple[str, ...]]:
    """Return the indices of markers from nose to tail, and a note if that is not the order of the file.

    Names sorted as text (p1, p10, p2) are put in the order of their numbers. Raise an error if the markers do not lie
    along the body in the order found.
    """
    names = markers.names
    by_number = sorted(range(len(names)), key=lambda m: _parts(names[m]))
    order = list(range(len(names)))
    notes: tuple[str, ...] = ()
    if by_number != order and list(names) == sorted(names) and _numbered(names):
        order = by_number
        notes = (f"markers are taken in the order of their numbers, {names[order[0]]} to {names[order[-1]]}",)
    _check(markers, order)
    return order, notes


def _parts(name: str) -> list[tuple[bool, int, str]]:
    """Return a sort key for a name, made of its words and numbers, so that m2 comes before m10."""
    parts = re.findall(r"[0-9]{1,12}|[^0-9]+", name.lower())
    return [(part.isdecimal(), int(part) if part.isdecimal() else 0, part) for part in parts]


def _numbered(names: Sequence[str]) -> bool:
    """Return whether names differ only in their numbers."""
    return len({re.sub("[0-9]+", "0", name) for name in names}) == 1


def _check(markers: Markers, order: Sequence[int]) -> None:
    """Check, by the distances between markers, that they lie along the body in the given order."""
    place = markers.place[:: len(markers.time) // MAX_FRAMES + 1][:, list(order)]
    if len(order) < 3 or not np.isfinite(place).all(axis=2).any(axis=0).all():
        return
    positions = _along(place)
    if positions is None:
        return
    positions = positions * np.sign(np.polyfit(np.arange(len(positions)), positions, 1)[0] or 1.0)
    spacing = float(np.ptp(positions)) / (len(positions) - 1)
    if (np.diff(positions) >= -INVERTED * spacing).all():
        return
    by_distance = [markers.names[order[m]] for m in np.argsort(positions)]
    if by_distance.index(markers.names[order[0]]) > len(by_distance) / 2:
        by_distance.reverse()
    text = ", ".join(by_distance if len(by_distance) <= 12 else [*by_distance[:10], "...", by_distance[-1]])
    rule = f"must lie along the body in the order of the file, but lie as {text}, or the other way round"
    fix = "write them from nose to tail, or give their places with --places; animals side by side are no body"
    raise InputError(rule, file=markers.file, key="the markers", fix=fix)


def _along(place: Array) -> Array | None:
    """Return positions (markers,) along the body that fit the median distances between markers (frames, markers, 2)."""
    count = place.shape[1]
    distances = np.zeros((count, count))
    for m in range(count):
        distance = np.linalg.norm(place - place[:, m : m + 1], axis=2)
        if not np.isfinite(distance).any(axis=0).all():
            return None  # two markers are never seen in the same frame
        distances[m] = np.nanmedian(distance, axis=0)
    center = np.eye(count) - 1 / count
    value, vector = np.linalg.eigh(-0.5 * center @ (distances + distances.T) ** 2 / 4 @ center)
    along: Array = vector[:, -1] * np.sqrt(max(value[-1], 0.0))
    return along
