"""Text forms of pose-tracking programs: DeepLabCut and Lightning Pose, SLEAP, TRex, idtracker.ai."""

import re
from dataclasses import replace

import numpy as np

from hypertuna.errors import InputError
from hypertuna.trials.form import Text, of_columns, one_point, unit_of
from hypertuna.trials.form_clock import clock_columns
from hypertuna.trials.grid import Grid, Samples
from hypertuna.trials.points import Points, choose_individual, joined_tracks, of_one_animal

HEADS = ("individuals", "bodyparts", "coords")  # first cells of DeepLabCut's lines of names below the scorer's


def _is_deeplabcut(grid: Grid) -> bool:
    return grid.cells(0)[0] == "scorer" or {"bodyparts", "coords"} <= {
        grid.cells(k)[0] for k in range(4) if grid.cells(k)
    }


def _deeplabcut(grid: Grid, individual: str | None) -> Points:
    """Read a file of DeepLabCut or Lightning Pose: three or four lines of names, and a column of frames before points.

    Labels of pictures (CollectedData) have the pictures' names instead of frames, in one column or in three.
    """
    names = {row[0].lower(): row for _, row in grid.rows[:4] if row[0].lower() in (*HEADS, "scorer")}
    if not {"bodyparts", "coords"} <= set(names):
        fix = "give the file as DeepLabCut wrote it, with its lines scorer, bodyparts and coords"
        raise InputError("must have lines of bodyparts and coords", file=grid.file, value="without", fix=fix)
    parts, axes = names["bodyparts"], [axis.lower() for axis in names["coords"]]
    first = next((k for k, axis in enumerate(axes[1:], 1) if axis), 1)  # column of the points
    head = [f"{part} {axis}".strip() for part, axis in zip(parts, axes, strict=False)]
    data = Grid(grid.file, [(n, row) for n, row in grid.rows if row[0].lower() not in names])
    for row in names.values():
        Grid(grid.file, [(grid.rows[0][0], row)]).below(0, parts)
    samples = data.below(0, [*head[:1], *head[1:]])
    animals = names.get("individuals", [""] * len(axes))
    animal = choose_individual(
        grid.file,
        [
            name
            for name in dict.fromkeys(a for a, axis in zip(animals, axes, strict=True) if axis == "x")
            if name != "single"
        ]
        or ["single"],
        individual,
    )
    columns: dict[str, dict[str, int]] = {}
    used, ignored = [], []
    for k, axis in enumerate(axes[first:], first):
        if animals[k] in (animal, "single") and axis in ("x", "y", "z", "likelihood"):
            columns.setdefault(parts[k], {})["weight" if axis == "likelihood" else axis] = k
            used.append(k)
        elif axis and animals[k] in (animal, "single"):
            ignored.append(head[k])
    samples.check_once(used)
    notes = _check_labels(samples, first)
    frame, column = samples.frames(first - 1), ("bodyparts", "coords")[0] if first == 1 else "the pictures"
    return of_columns(
        "DeepLabCut", samples, columns, frame=frame, frame_name=column, ignored=tuple(ignored), notes=notes
    )


def _check_labels(samples: Samples, first: int) -> tuple[str, ...]:
    """Check that hand labels, whose rows are named by pictures, are of one video; return notes about them."""
    texts = samples.text(first - 1)
    if first == 1 and not any("/" in text or "\\" in text or ("." in text and text[-1:].isalpha()) for text in texts):
        return ()
    folders = {(*row[: first - 1], re.sub(r"[^/\\]*$", "", row[first - 1])) for _, row in samples.rows}
    if len(folders) > 1:
        rule, fix = "must be of one video", "give the labels of each video in a file of its own, or analyze the video"
        raise InputError(rule, file=samples.file, value=f"labels of the pictures of {len(folders)}", fix=fix)
    return ("labels of pictures that were picked from a video: their times are those of the numbers in their names",)


def _is_sleap(grid: Grid) -> bool:
    return {"track", "frame_idx"} <= set(grid.cells(0))


def _sleap(grid: Grid, individual: str | None) -> Points:
    """Read an analysis file of SLEAP; tracks that follow each other are joined; points set by hand have no score."""
    head = grid.rows[0][1]
    samples = grid.below(1, head)
    samples.check_once([k for k, name in enumerate(head) if name])
    lower = grid.cells(0)
    track, frame = lower.index("track"), lower.index("frame_idx")
    names, frames = samples.text(track), samples.frames(frame)
    columns: dict[str, dict[str, int]] = {}
    for k, name in enumerate(head):
        node, dot, axis = (part if not i else part.lower() for i, part in enumerate(name.rpartition(".")))
        if dot and node.lower() != "instance" and axis in ("x", "y", "score"):
            columns.setdefault(node, {})["weight" if axis == "score" else axis] = k

    def points(rows: list[int]) -> Points:
        return of_columns("SLEAP", samples.only(rows), columns, frame=frames[rows], frame_name="frame_idx")

    tracks = list(dict.fromkeys(names))
    if individual is None and len(tracks) > 1 and len(set(frames.tolist())) == len(frames):
        order = np.argsort(frames, kind="stable").tolist()
        joined = points(order)
        if of_one_animal(frames[order], [names[k] for k in order], joined.place):
            return replace(joined, notes=(joined_tracks(tracks),))
    animal = choose_individual(grid.file, names, individual)
    return points([k for k, name in enumerate(names) if name == animal])


# A column of TRex, such as poseX0 (cm): axis, number of the point, unit; and units [m], None for pixels.
TREX = re.compile(r"pose([XY])(\d+)(?: \((\w+)\))?", re.IGNORECASE)


def _is_trex(grid: Grid) -> bool:
    return any(TREX.fullmatch(name) or "#wcentroid" in name for name in grid.cells(0))


def _trex(grid: Grid, individual: str | None) -> Points:
    """Read a file of TRex with the points of its poses, in which missing numbers are infinite."""
    head = grid.rows[0][1]
    samples = grid.below(1, head)
    columns: dict[str, dict[str, int]] = {}
    units = set()
    for k, name in enumerate(head):
        if match := TREX.fullmatch(name):
            units.add(match[3])
            columns.setdefault(f"pose{match[2]}", {})[match[1].lower()] = k
    if not columns:
        raise one_point("TRex", grid.file, "add poseX, poseY or midlines to output_fields")
    samples.check_once([k for axes in columns.values() for k in axes.values()])
    clock, notes = clock_columns(samples, [k for axes in columns.values() for k in axes.values()])
    if clock.get("time_name", "").lower() == "time":
        clock["time_unit"] = 1.0  # of TRex's own column
    return of_columns(
        "TRex", samples, columns, infinite=True, notes=notes, y_down=True, **unit_of(grid.file, units), **clock
    )


def _is_idtracker(grid: Grid) -> bool:
    """Return whether the column names are those of idtracker.ai: seconds, then animals' centers x1, y1, x2, y2, ..."""
    head = grid.cells(0)
    centers = [f"{axis}{k // 2 + 1}" for k, axis in enumerate("xy" * (len(head) // 2))]
    return len(head) > 2 and head[0] in ("seconds", "time(s)", "time", "timestamp") and head[1:] == centers


def _idtracker(grid: Grid, individual: str | None) -> Points:
    fix = "track several points of one body; if x1, y1, ... are those, call the column of time time_s"
    raise one_point("idtracker.ai", grid.file, fix)


# Text formats that this module reads, in the order in which they are tried.
TEXTS = (
    Text("DeepLabCut", _is_deeplabcut, _deeplabcut, individuals=True),
    Text("SLEAP", _is_sleap, _sleap, individuals=True),
    Text("TRex", _is_trex, _trex),
    Text("idtracker.ai", _is_idtracker, _idtracker),
)
