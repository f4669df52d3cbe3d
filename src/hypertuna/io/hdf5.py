"""Users' HDF5 files, read in a process of their own: a damaged file can hang or crash the library that reads it."""

import json
import math
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.door import opened

WAIT = 120.0  # s of wall-clock time for reading a file


@dataclass(frozen=True)
class Hdf5:
    """Content of an HDF5 file, by the path within the file."""

    file: str
    arrays: dict[str, Array] = field(default_factory=dict)
    texts: dict[str, tuple[str, ...]] = field(default_factory=dict)
    attributes: dict[str, dict[str, Any]] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()  # arrays that are too large

    def array(self, name: str, dimensions: int) -> Array:
        """Return a required array of numbers with a number of dimensions, or raise InputError."""
        if name in self.left_out:
            rule, fix = "must have at most 12 million numbers", "cut the film into parts, and export each"
            raise InputError(rule, file=self.file, key=name, value="more", fix=fix)
        array = self.arrays.get(name)
        if array is None or array.ndim != dimensions or not array.size:
            value = "missing" if array is None else f"of the shape {array.shape}"
            rule = f"must be an array of numbers of {dimensions} dimensions"
            raise InputError(rule, file=self.file, key=name, value=value, fix="export the file again")
        return np.asarray(array)


def read_hdf5(path: str | Path) -> Hdf5:
    """Read the numbers, texts and attributes of an HDF5 file, within limits; links to other files are not followed."""
    child = Path(__file__).with_name("hdf5_child.py")
    environment = dict(os.environ) | {"OPENBLAS_NUM_THREADS": "1", "HDF5_PLUGIN_PATH": "::"}
    with opened(path, "points") as stream:
        try:
            result = subprocess.run(
                [sys.executable, "-P", str(child)], stdin=stream, capture_output=True, timeout=WAIT, env=environment
            )
        except subprocess.TimeoutExpired:
            result = None
    if result is None or result.returncode:
        rule, fix = "must be a whole HDF5 file", "export it again: it is damaged, or was cut short"
        raise InputError(rule, file=str(path), value="not", fix=fix)
    head, _, content = result.stdout.partition(b"\n")
    contents = json.loads(head)
    data, offset = Hdf5(str(path), left_out=tuple(contents["left_out"])), 0
    for entry in contents["entries"]:
        name = entry["name"]
        if "texts" in entry:
            data.texts[name] = tuple(entry["texts"])
        elif "attributes" in entry:
            data.attributes[name] = entry["attributes"]
        else:
            count = math.prod(entry["shape"])
            array = np.frombuffer(content, np.dtype(entry["type"]), count, offset).reshape(entry["shape"])
            data.arrays[name], offset = array, offset + array.nbytes
    return data
