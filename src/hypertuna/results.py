"""Results as labeled arrays: units on every quantity, and what made them."""

from __future__ import annotations

import csv
import functools
import importlib.metadata
import io
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description import Robot
from hypertuna.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    *("body_points", "columns_csv", "dataset", "provenance", "rows_csv", "trajectory"),
    *("version", "write_atomically", "write_netcdf"),
]

Array = NDArray[np.float64]


@functools.cache
def version() -> str:
    """Return the version of hypertuna.

    Returns
    -------
    str
    """
    return importlib.metadata.version("hypertuna")


def provenance(robot: Robot, *, water: bool = True) -> dict[str, str]:
    """Say what made a result: attributes for every dataset and file.

    Parameters
    ----------
    robot : Robot
    water : bool
        Whether the robot's model of body and water had a part in it.

    Returns
    -------
    dict of str
        Version, instruction set, robot and its hash, choice of model.
    """
    made = {
        "hypertuna_version": version(),
        "isa": _core.isa(),
        "robot": robot.name,
        "robot_file": robot.file,
        "robot_hash": robot.hash,
    }
    model = robot.model
    return made | ({"water": model.water, "joints": model.joints, "areas": model.areas} if water else {})


def dataset(variables: Mapping[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]) -> xr.Dataset:
    """Make a labeled dataset; what labels it is imported only now, because that takes longer than a swim.

    Parameters
    ----------
    variables, coordinates, attributes : mapping
        As `xarray.Dataset` takes them.

    Returns
    -------
    xarray.Dataset
    """
    import xarray as xr

    return xr.Dataset(variables, coordinates, attributes)


def trajectory(
    robot: Robot,
    time: Array,
    joints: Array,
    motion: Mapping[str, Any],
    *,
    current: tuple[float, float] = (0.0, 0.0),
) -> xr.Dataset:
    """Label a motion of the core.

    Parameters
    ----------
    robot : Robot
    time : ndarray, shape (times,)
        [s].
    joints : ndarray, shape (times, links, 3)
        Angle [rad], rate [rad/s] and acceleration [rad/s^2] of the joint at the front of every link.
    motion : mapping
        What `_core.advance` returns, in the frame of the water.
    current : tuple of float
        Velocity of the water in the frame of the result [m/s].

    Returns
    -------
    xarray.Dataset
        Dimensions time, link and joint group; units and meaning in the attributes. Positions are in the ground
        frame: origin at the nose's start, x and y fixed, heading counter-clockwise from x to the tail.
    """
    pose = np.array(motion["pose"])
    pose[:, :2] += np.outer(time, current)
    twist, torque = motion["twist"], motion["torque"]
    tail = body_points(robot, pose, joints[:, :, 0])[:, -1]
    power = torque * joints[:, :, 1]
    groups = [joint.name for joint in robot.joints]
    members = [list(joint.links) for joint in robot.joints]

    def per_group(column: Array) -> Array:
        return np.stack([column[:, links].sum(axis=1) for links in members], axis=1)

    heading = pose[:, 2]
    ahead = -(twist[:, 0])
    variables = {
        "x": ("time", pose[:, 0], "m", "position of the nose"),
        "y": ("time", pose[:, 1], "m", "position of the nose"),
        "heading": ("time", heading, "rad", "angle of the head's axis (nose to tail) from x, counter-clockwise"),
        "u": ("time", twist[:, 0], "m/s", "velocity of the nose through the water along the head's axis, to the tail"),
        "v": ("time", twist[:, 1], "m/s", "velocity of the nose through the water across the head's axis"),
        "r": ("time", twist[:, 2], "rad/s", "rate of turn of the head, counter-clockwise"),
        "forward_speed": ("time", ahead, "m/s", "velocity of the nose through the water along the head's axis, ahead"),
        "tail_x": ("time", tail[:, 0], "m", "position of the tail tip"),
        "tail_y": ("time", tail[:, 1], "m", "position of the tail tip"),
        "joint_angle": (("time", "link"), joints[:, :, 0], "rad", "angle of the joint at the front of the link"),
        "joint_rate": (("time", "link"), joints[:, :, 1], "rad/s", "rate of the joint"),
        "joint_torque": (("time", "link"), torque, "N m", "torque of the joint on the link"),
        "bend": (("time", "group"), per_group(joints[:, :, 0]), "rad", "angle of the joint group"),
        "group_power": (("time", "group"), per_group(power), "W", "mechanical power of the joint group"),
        "power": ("time", power.sum(axis=1), "W", "mechanical power of all joints"),
        "loss": ("time", motion["loss"], "W", "power that the water takes"),
        "energy": ("time", motion["energy"], "J", "kinetic energy of body and entrained water"),
    }
    return dataset(
        {
            name: (dims, values, {"units": unit, "long_name": text})
            for name, (dims, values, unit, text) in variables.items()
        },
        {
            "time": ("time", time, {"units": "s", "long_name": "time"}),
            "link": ("link", list(robot.links.name)),
            "group": ("group", groups),
        },
        provenance(robot) | {"current_x_m_s": current[0], "current_y_m_s": current[1]},
    )


def body_points(robot: Robot, pose: Array, angles: Array) -> Array:
    """Place the joints of the body: nose, front end of every link, tail tip.

    Parameters
    ----------
    robot : Robot
    pose : ndarray, shape (times, 3)
        Position of the nose [m] and heading [rad].
    angles : ndarray, shape (times, links)
        Angle of the joint at the front of every link [rad].

    Returns
    -------
    ndarray, shape (times, links + 1, 2)
        Positions in the frame of the pose [m] (Eqs 21-24 of the paper).
    """
    theta = pose[:, 2:] + np.cumsum(angles, axis=1)
    steps = np.array(robot.links.length)[:, np.newaxis] * np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    return np.concatenate([pose[:, np.newaxis, :2], pose[:, np.newaxis, :2] + np.cumsum(steps, axis=1)], axis=1)


def columns_csv(facts: Mapping[str, Any], columns: Mapping[str, Iterable[float]], *, digits: int = 6) -> str:
    """Write columns as comma-separated values, below comments that say what made them.

    Parameters
    ----------
    facts : mapping of str
    columns : mapping of str to iterable of float
        By their heads, all of one length; a value that is not a number leaves its cell empty.
    digits : int
        Of every number.

    Returns
    -------
    str
    """
    cells = ([f"{value + 0.0:.{digits}g}" if value == value else "" for value in column] for column in columns.values())
    rows = zip(*cells, strict=True)
    return _csv(facts, [list(columns), *rows])


def rows_csv(facts: Mapping[str, Any], rows: Iterable[Mapping[str, Any]]) -> str:
    """Write rows as comma-separated values, numbers in full, below comments that say what made them.

    Parameters
    ----------
    facts : mapping of str
    rows : iterable of mapping of str
        All of the same keys, which become the head.

    Returns
    -------
    str
    """
    rows = list(rows)
    return _csv(facts, [list(row) for row in rows[:1]] + [list(row.values()) for row in rows])


def _csv(facts: Mapping[str, Any], rows: Iterable[Iterable[Any]]) -> str:
    """Write comments and rows; what holds a comma is quoted."""
    text = io.StringIO()
    text.writelines("# " + f"{key}: {value}".replace("\n", " ") + "\n" for key, value in facts.items())
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def write_atomically(path: str | Path, content: bytes) -> Path:
    """Write a file whole or not at all: under a temporary name beside it, then renamed.

    Parameters
    ----------
    path : str or Path
    content : bytes

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise _unwritable(path, error) from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(name, 0o666 & ~umask)
        os.replace(name, path)
    except OSError as error:
        Path(name).unlink(missing_ok=True)
        raise _unwritable(path, error) from None
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return path


def write_netcdf(dataset: xr.Dataset | xr.DataTree, path: str | Path) -> Path:
    """Write a dataset as NetCDF, whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset or xarray.DataTree
        A tree becomes groups of one file.
    path : str or Path

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "result.nc"
        dataset.to_netcdf(whole, engine="h5netcdf")
        return write_atomically(path, whole.read_bytes())


def _unwritable(path: Path, error: OSError) -> InputError:
    fix = "choose a path that can be written"
    return InputError("must be a writable file", file=str(path), value=f"not ({error.strerror})", fix=fix)
