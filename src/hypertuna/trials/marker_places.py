"""Places of markers on a robot: from a small CSV file, or equally spaced along the midline."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.door import RUNS
from hypertuna.io.tables import read_table
from hypertuna.trials.chain import Chain

COLUMNS = ("marker", "link", "along_m", "from_nose_m", "across_m")  # known columns of a file of places


class Places(NamedTuple):
    """Places of markers on the links of a robot."""

    names: tuple[str, ...]  # names of the markers
    link: tuple[int, ...]
    along: tuple[float, ...]  # m behind the link's front end
    across: tuple[float, ...]  # m to starboard of the link's axis


def equal_spacing(robot: Robot, names: Sequence[str]) -> Places:
    """Place markers from nose to tail, in their order, at equal distances along the midline."""
    return _from_nose(robot, names, np.linspace(0, sum(robot.links.length), len(names)).tolist(), [0.0] * len(names))


def read_places(path: str | Path, robot: Robot, markers: Sequence[str]) -> Places:
    """Read the places of markers. A marker that was not tracked is an error; a tracked one without a place is not used.

    Columns: marker; link and along_m, or from_nose_m; optionally across_m, to starboard.
    """
    table = read_table(path, RUNS)
    for column in table.head:
        if column not in COLUMNS:
            fix = did_you_mean(column, COLUMNS)
            raise InputError("is not a known column", file=table.file, key=f"line {table.line}, {column}", fix=fix)
    table.check_once(table.head)
    by_link = {"link", "along_m"} <= set(table.head)
    if "marker" not in table.head or not (by_link or "from_nose_m" in table.head):
        rule, fix = "must have the columns marker, and link and along_m or from_nose_m", "add them"
        raise InputError(rule, file=table.file, key=f"line {table.line}", value=", ".join(table.head), fix=fix)
    if len(table.rows) > len(markers):
        rule, fix = f"must have at most a line for each of the {len(markers)} tracked markers", "remove the others"
        raise InputError(rule, file=table.file, value=f"{len(table.rows)} lines long", fix=fix)
    lengths, links = robot.links.length, robot.links.name

    def row(_: int, cells: dict[str, str]) -> tuple[str, int, float, float]:
        if (name := cells["marker"]) not in markers:
            raise InputError(
                "must be a tracked marker", key="marker", value=shown(name), fix=did_you_mean(name, markers)
            )
        across = _number(cells.get("across_m") or "0", "across_m")
        if not by_link:
            distance = _number(cells["from_nose_m"], "from_nose_m")
            place = _from_nose(robot, [name], [distance], [across])
            return name, place.link[0], place.along[0], across
        if cells["link"] not in links and cells["link"] not in map(str, range(len(links))):
            fix = did_you_mean(cells["link"], links)
            raise InputError("must be a link, by name or index", key="link", value=shown(cells["link"]), fix=fix)
        link = links.index(cells["link"]) if cells["link"] in links else int(cells["link"])
        along = _number(cells["along_m"], "along_m")
        if not -lengths[link] <= along <= 2 * lengths[link]:
            fix = "give the distance behind the front end of the link in m"
            rule = f"must be near the link, which is {lengths[link]:g} m long"
            raise InputError(rule, key="along_m", value=f"{along:g}", fix=fix)
        return name, link, along, across

    rows = table.parse(row)
    names = [name for name, *_ in rows]
    for name in (name for k, name in enumerate(names) if name in names[:k]):
        raise InputError("must be listed once", file=table.file, key=f"marker {name}", fix="remove one of the lines")
    return Places(*(tuple(column) for column in zip(*rows, strict=True)))


def places_text(places: Places, comment: str) -> str:
    """Return places as the text of a CSV file for `read_places`."""
    rows = zip(places.names, places.link, places.along, places.across, strict=True)
    lines = [f"{_cell(name)},{link},{along:.6f},{across:.6f}" for name, link, along, across in rows]
    return "\n".join([f"# {comment}", "marker,link,along_m,across_m", *lines, ""])


def _cell(name: str) -> str:
    """Return a name as a cell of a CSV file, quoted if needed."""
    return '"' + name.replace('"', '""') + '"' if set(name) & set(',"#') else name


def moved(places: Places, step: Array) -> Places:
    """Return places moved along and to starboard of their links, by steps (markers, 2) [m]."""
    along, across = (np.array([places.along, places.across]) + step.T).tolist()
    return places._replace(along=tuple(along), across=tuple(across))


def straight(robot: Robot, chain: Chain, places: Places, angle: Array) -> Places:
    """Take markers that sit on a body bent by angles (groups,) [rad], and return their places on the straight body.

    The straight body is moved and rotated to where the markers are nearest to their previous places.
    """
    bent = chain(np.concatenate([np.zeros(3), angle])[np.newaxis])[0][0]
    flat = np.column_stack([chain.along.sum(axis=1), chain.across.sum(axis=1)])
    one, other = bent - bent.mean(axis=0), flat - flat.mean(axis=0)
    left, _, right = np.linalg.svd(one.T @ other)
    turn = left @ np.diag([1.0, np.sign(np.linalg.det(left @ right))]) @ right
    x, y = (one @ turn + flat.mean(axis=0)).T
    ends = np.cumsum(robot.links.length)
    link = np.asarray(places.link)
    along = x - (ends[link] - np.asarray(robot.links.length)[link])
    return places._replace(along=tuple(along.tolist()), across=tuple(y.tolist()))


def _from_nose(robot: Robot, names: Sequence[str], distance: Sequence[float], across: Sequence[float]) -> Places:
    """Convert distances [m] from the nose along the straight body to places on links."""
    ends = np.cumsum(robot.links.length)
    for name, at in zip(names, distance, strict=True):
        if not 0 <= at <= ends[-1] * (1 + 1e-9):
            rule, fix = f"must be 0 to {ends[-1]:g} m, the length of the links", "give the distance along the body"
            raise InputError(rule, key="from_nose_m", value=f"{name} at {at:g}", fix=fix)
    link = np.minimum(np.searchsorted(ends, distance, side="right"), len(ends) - 1).tolist()
    along = [at - (ends[k] - robot.links.length[k]) for at, k in zip(distance, link, strict=True)]
    return Places(tuple(names), tuple(link), tuple(float(a) for a in along), tuple(across))


def _number(text: str, key: str) -> float:
    """Return the number in a cell, which must be finite."""
    try:
        value = float(text)
    except ValueError:
        raise InputError("must be a number", key=key, value=shown(text), fix="give it in m") from None
    if not np.isfinite(value):
        raise InputError("must be finite", key=key, value=text, fix="give it in m")
    return value
