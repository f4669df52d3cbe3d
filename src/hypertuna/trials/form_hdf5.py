"""Read tracked points from HDF5 files of DeepLabCut (pandas tables), SLEAP (analysis) and MATLAB 7.3."""

import pickletools
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.io.door import check_numbers
from hypertuna.io.hdf5 import Hdf5, read_hdf5
from hypertuna.io.matlab import dense
from hypertuna.trials.form import one_point
from hypertuna.trials.form_matlab import candidates_of, points_of_arrays
from hypertuna.trials.points import Points, Rows, choose_individual, joined_tracks, of_one_animal, seen

AXES = ("x", "y", "z")  # names of coordinates
MAX_LEVELS = 6  # largest number of levels of column names (scorer, individuals, bodyparts, coords) and of blocks
LABELS = "the labels of single pictures, not a track"  # in an error


def read(path: str | Path, individual: str | None) -> Points:
    """Read the points of one animal from an HDF5 file."""
    file = read_hdf5(path)
    kinds = {name: str(settings.get("pandas_type", "")) for name, settings in file.attributes.items()}
    frames = [name for name, kind in kinds.items() if kind in ("frame", "frame_table")]
    names = {*file.arrays, *file.texts, *file.left_out}
    if frames:
        return _deeplabcut(file, frames, individual)
    if "tracks_json" in file.attributes or {"frames", "instances"} <= set(file.attributes):
        fix = "export its analysis: Export Analysis HDF5 or CSV in SLEAP"
        raise InputError("is of the form of SLEAP's labels (.slp), which are not read", file=file.file, fix=fix)
    if "tracks" in names and "node_names" in file.attributes:
        return _sleap(file, individual)
    if "trajectories" in names:
        raise one_point("idtracker.ai", file.file, "track several points of one body, by DeepLabCut or SLEAP")
    if any("MATLAB_class" in settings for settings in file.attributes.values()):
        return points_of_arrays("MATLAB 7.3", file.file, _matlab(file), individual)
    if any(name.startswith("processing/") for name in file.attributes):
        fix = "export CSV or HDF5 from the program that tracked the points"
        raise InputError("is of the form of NWB, which is not read", file=file.file, fix=fix)
    arrays = {name.replace("/", "."): array for name, array in file.arrays.items()}
    if candidates_of(arrays):
        return points_of_arrays("HDF5", file.file, arrays, individual)
    listed = ", ".join(sorted(name for name in file.attributes if "/" not in name)[:8])
    fix = "export CSV, or the HDF5 file of DeepLabCut's analyze_videos or of SLEAP's analysis"
    rule = "must hold tracked points in the form of DeepLabCut, SLEAP or MATLAB"
    raise InputError(rule, file=file.file, value=f"an HDF5 file of {shown(listed)}" if listed else "empty", fix=fix)


def _deeplabcut(file: Hdf5, frames: list[str], individual: str | None) -> Points:
    """Read a pandas table in the format `table` or `fixed`; column names: scorer, (individuals), bodyparts, coords."""
    name = "df_with_missing" if "df_with_missing" in frames else frames[0]
    columns, values, frame = _table(file, name) if f"{name}/table" in file.attributes else _fixed(file, name)
    if not columns or len({len(one) for one in columns}) > 1 or len(columns[0]) not in (2, 3, 4):
        rule, fix = "must have columns of scorer, bodyparts and coords, as DeepLabCut writes them", "export it again"
        raise InputError(rule, file=file.file, key=name, value="others", fix=fix)
    if frame is None:
        fix = "give the file that analyze_videos wrote, or the labels of one video as CSV"
        raise InputError(f"holds {LABELS}", file=file.file, key=name, fix=fix)
    animals = [one[-3] if len(one) == 4 else "" for one in columns]
    own = choose_individual(
        file.file, [one for one in dict.fromkeys(animals) if one != "single"] or ["single"], individual
    )
    parts: dict[str, dict[str, int]] = {}
    for k, (one, animal) in enumerate(zip(columns, animals, strict=True)):
        if animal in (own, "single"):
            parts.setdefault(one[-2], {})[one[-1].lower()] = k
    axes = [axis for axis in AXES if all(axis in of_part for of_part in parts.values())]
    if axes[:2] != ["x", "y"]:
        fix = "export it again"
        raise InputError("must have columns of x and y of each body part", file=file.file, key=name, fix=fix)
    place = np.stack([values[:, [of_part[axis] for axis in axes]] for of_part in parts.values()], axis=1)
    unknown = np.full(len(values), np.nan)
    weight = [values[:, of_part["likelihood"]] if "likelihood" in of_part else unknown for of_part in parts.values()]
    rows = Rows("frame", frame)
    return Points("DeepLabCut", file.file, tuple(parts), seen(place), np.stack(weight, axis=1), rows, frame=frame)


def _table(file: Hdf5, name: str) -> tuple[list[tuple[str, ...]], Array, Array | None]:
    """Read a pandas table in the format `table`, with pickled column names; return names, numbers and frame numbers."""
    settings, columns, blocks = file.attributes[f"{name}/table"], [], []
    for k in range(MAX_LEVELS):
        block = f"values_block_{k}"
        if f"{name}/table/{block}" in (*file.arrays, *file.left_out):
            array = file.array(f"{name}/table/{block}", 2)
            columns += (block_names := _names(str(settings.get(f"{block}_kind", ""))))
            if len(block_names) != array.shape[1]:
                raise _damaged(file, name)
            blocks.append(array)
    index = file.arrays.get(f"{name}/table/index")
    if not blocks:
        raise _damaged(file, name)
    return columns, np.concatenate(blocks, axis=1).astype(float), _frames(index, len(blocks[0]))


def _fixed(file: Hdf5, name: str) -> tuple[list[tuple[str, ...]], Array, Array | None]:
    """Read a pandas table in the format `fixed`, with names as indices; return names, numbers and frame numbers."""
    values, names = file.array(f"{name}/block0_values", 2), []
    for k in range(MAX_LEVELS):
        level, label = (f"{name}/block0_items_{word}{k}" for word in ("level", "label"))
        if level in file.texts:
            words, codes = file.texts[level], file.array(label, 1)
            if len(codes) != values.shape[1] or codes.min() < 0 or codes.max() >= len(words):
                raise _damaged(file, name)
            names.append([words[int(code)] for code in codes])
    if f"{name}/block1_values" in file.arrays:
        raise _damaged(file, name)
    return [*zip(*names, strict=True)], values.astype(float), _frames(file.arrays.get(f"{name}/axis1"), len(values))


def _frames(index: Array | None, count: int) -> Array | None:
    """Return the frame numbers (count,) in a table's index; None if the index has names of pictures."""
    return index.astype(float) if index is not None and index.shape == (count,) and index.dtype.kind in "iuf" else None


def _damaged(file: Hdf5, name: str) -> InputError:
    """Return the error for a pandas table whose parts do not match."""
    return InputError("must be a whole table of pandas", file=file.file, key=name, value="not", fix="export it again")


def _names(pickled: str) -> list[tuple[str, ...]]:
    """Return the tuples of strings in a pickled list, read from its opcodes without executing them."""
    memo: dict[int, str] = {}
    row: list[str] = []
    rows: list[tuple[str, ...]] = []
    try:
        for code, argument, _ in pickletools.genops(pickled.encode("latin-1")):
            if code.name == "MARK":
                row = []
            elif "UNICODE" in code.name:
                row.append(str(argument))
            elif "PUT" in code.name and row:
                memo[int(argument or 0)] = row[-1]
            elif "GET" in code.name:
                row.append(memo.get(int(argument or 0), ""))
            elif code.name == "TUPLE":
                rows.append(tuple(row))
                row = []
    except ValueError:  # damaged, or of a wrong encoding
        return []
    return rows


def _sleap(file: Hdf5, individual: str | None) -> Points:
    """Read SLEAP's analysis: tracks (tracks, 2, nodes, frames), or in the order of the preset `standard`."""
    tracks, nodes = file.array("tracks", 4), file.texts.get("node_names", ())
    standard = tracks.shape[3] == 2 and tracks.shape[2] == len(nodes)
    place = tracks.transpose(1, 0, 2, 3) if standard else tracks.transpose(0, 3, 2, 1)  # (tracks, frames, nodes, 2)
    if place.shape[2:] != (len(nodes), 2):
        rule, fix = f"must have the shape (tracks, 2, {len(nodes)} nodes, frames)", "export the analysis again"
        raise InputError(rule, file=file.file, key="tracks", value=f"of the shape {tracks.shape}", fix=fix)
    place = seen(place.astype(float))
    weight = np.full(place.shape[:3], np.nan)
    if (scores := file.arrays.get("point_scores")) is not None and scores.ndim == 3:
        scores = scores.transpose(1, 0, 2) if standard else scores.transpose(0, 2, 1)
        weight = scores.astype(float) if scores.shape == weight.shape else weight
    track_names = file.texts.get("track_names", ())
    names = list(track_names) if len(track_names) == len(place) else [f"track_{k}" for k in range(len(place))]
    present: Any = np.isfinite(place).any(axis=(2, 3))
    seen_tracks = np.flatnonzero(present.any(axis=1))
    if not len(seen_tracks):
        raise InputError(
            "must hold points that were seen", file=file.file, value="none", fix="export the analysis again"
        )
    frame = np.arange(float(place.shape[1]))
    notes: tuple[str, ...] = ()
    chosen: tuple[Any, ...] = ()
    if individual is None and len(seen_tracks) > 1 and present.sum(axis=0).max() == 1:
        track = present.argmax(axis=0)
        chosen = (track, np.arange(len(track)))
        rows = np.flatnonzero(present.any(axis=0))
        if of_one_animal(frame[rows], track[rows], place[chosen][rows]):
            notes = (joined_tracks([names[k] for k in seen_tracks]),)
    if not notes:
        chosen = (names.index(choose_individual(file.file, [names[k] for k in seen_tracks], individual)),)
    return Points(
        "SLEAP", file.file, tuple(nodes), place[chosen], weight[chosen], Rows("frame", frame), frame=frame, notes=notes
    )


def _matlab(file: Hdf5) -> dict[str, Array]:
    """Return the arrays of a MATLAB 7.3 file by name, with dimensions in MATLAB's order, which HDF5 reverses."""
    arrays, numbers = {}, 0
    for name, array in file.arrays.items():
        if name.endswith(("/data", "/ir", "/jc")) and "MATLAB_sparse" in file.attributes.get(
            name.rpartition("/")[0], {}
        ):
            continue
        arrays[name.replace("/", ".")] = np.asarray(array.T)
    for name, about in file.attributes.items():
        rows, names = about.get("MATLAB_sparse"), [f"{name}/{part}" for part in ("data", "ir", "jc")]
        if isinstance(rows, int) and 0 < rows < 10_000_000 and all(part in file.arrays for part in names):
            values, row, begin = (file.arrays[part] for part in names)
            check_numbers(numbers := numbers + rows * begin.size, file.file)
            arrays[name.replace("/", ".")] = dense(rows, values, row, begin, file=file.file)
    return arrays
