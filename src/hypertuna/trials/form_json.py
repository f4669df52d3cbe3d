"""Read tracked points from JSON or its lines: records or columns, DeepLabCut's SuperAnimal, COCO, AlphaPose, MMPose."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError, shown
from hypertuna.io.door import CELLS, ROWS, damage, parse_json, read_bytes
from hypertuna.trials.form_columns import read_plain
from hypertuna.trials.forms import KEYPOINTS, points_of_grid
from hypertuna.trials.grid import Grid, frame_number
from hypertuna.trials.points import Points

Row = dict[str, str]  # cells by name of column
# Forms that are refused: keys that they have, and what to do.
OTHERS: dict[str, tuple[set[str], str]] = {
    "OpenPose, of one frame": ({"people"}, f"read all files of the film, and {KEYPOINTS}"),
    "SLEAP's labels": ({"skeletons"}, "export its analysis: Export Analysis HDF5 or CSV in SLEAP"),
    "LabelMe, of one picture": ({"shapes", "imagePath"}, f"read all files of the film, and {KEYPOINTS}"),
    "the VGG Image Annotator": ({"_via_img_metadata"}, KEYPOINTS),
    "Label Studio": ({"annotations", "data"}, KEYPOINTS),
}
LONGEST_NAME = 200  # characters of a column's name
TRIPLE = 3  # numbers of a keypoint: x, y and its score
ANIMAL = ("track_id", "idx", "person_id", "instance_id")  # keys of an animal's number


def read(path: str | Path, individual: str | None) -> Points:
    """Read the points of one animal from a JSON file."""
    file = str(path)
    try:
        document = _parsed(read_bytes(path, "points"))
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        rule, fix = "must be valid JSON", "write it again, or as CSV"
        raise InputError(rule, file=file, value=f"not ({error})", fix=fix) from None
    for form, (keys, fix) in OTHERS.items():
        one = document[0] if isinstance(document, list) and document else document
        if isinstance(one, dict) and keys <= one.keys():
            raise InputError(f"is of the form of {form}, which is not read", file=file, fix=fix)
    errors: tuple[type[Exception], ...] = (LookupError, *damage())
    for form, rows_of in TABLES.items():
        try:
            rows = rows_of(file, document)
        except InputError:
            raise
        except errors:
            raise InputError(f"is of the form of {form}, but not whole", file=file, fix="export it again") from None
        if rows is not None:
            points = read_plain(_grid(file, rows), individual)
            return replace(points, form=form, in_pixels=True)
    if not any(rows := _records(file, document)):
        rule = "must hold a record or a value for each frame"
        listed = shown(", ".join(list(document)[:8])) if isinstance(document, dict) else "other values"
        raise InputError(rule, file=file, value=f"JSON of {listed}", fix=KEYPOINTS)
    points = points_of_grid(_grid(file, rows), individual)
    return points if points.form != "plain columns" else replace(points, form="JSON")


def _parsed(content: bytes) -> Any:
    """Return the value of JSON, or the list of those of its lines."""
    try:
        return parse_json(content)
    except ValueError as error:
        if "Extra data" not in str(error):
            raise
        return [parse_json(line) for line in content.splitlines() if line.strip()]


def _grid(file: str, rows: Sequence[Row]) -> Grid:
    """Return a table of rows, under the names of all their columns."""
    head = list(dict.fromkeys(name for row in sorted(rows, key=len, reverse=True) for name in row))
    _check_size(file, len(rows), len(head))
    cells = [(n, [row.get(name, "") for name in head]) for n, row in enumerate(rows, 1)]
    return Grid(file, [(1, head), *cells], word="record")


def _check_size(file: str, rows: int, columns: int) -> None:
    """Check the size of a table before it is made."""
    if rows * columns > CELLS or rows > ROWS:
        rule, value = f"must have at most {CELLS} cells and {ROWS} records", f"{rows} records of {columns} cells"
        raise InputError(rule, file=file, value=value, fix="cut it into parts")


def _text(value: Any) -> str:
    """Return a value as a cell of a table."""
    return "" if value is None else str(value).strip()


def _records(file: str, document: Any) -> list[Row]:
    """Return the records of pandas and others: a list of them, columns, or both by an index."""
    if isinstance(document, dict) and isinstance(document.get("data"), list):
        names, index, rows = document.get("columns"), document.get("index"), document["data"]
        if isinstance(names, list):
            names, rows = ["", *map(str, names)], [row for row in rows if isinstance(row, list)]
            index = index if isinstance(index, list) and len(index) == len(rows) else [None] * len(rows)
            rows = [dict(zip(names, [key, *row], strict=False)) for key, row in zip(index, rows, strict=True)]
        document = rows
    if isinstance(document, dict) and document:
        document = _rows_of(file, document)
    found = document if isinstance(document, list) else []
    return [dict(_flat(file, "", record)) for record in found if isinstance(record, dict)]


def _rows_of(file: str, table: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the records of columns: lists beside numbers that hold for all rows; or objects, by index or by frame."""
    if all(isinstance(value, dict) for value in table.values()):
        if all(frame_number(key) is not None for key in table):
            return [{"frame": key, **value} for key, value in table.items()]
        rows: dict[str, dict[str, Any]] = {}
        for name, column in table.items():
            for key, value in column.items():
                rows.setdefault(key, {"": key})[name] = value
        return list(rows.values())
    lists = {key: value for key, value in table.items() if isinstance(value, list)}
    single = {key: value for key, value in table.items() if isinstance(value, (int, float, str))}
    if len(lists) == 1 and all(isinstance(one, dict) for one in next(iter(lists.values()))):
        records = next(iter(lists.values()))
        _check_size(file, len(records), len(single))
        return [single | record for record in records]
    count = max(map(len, lists.values()), default=0)
    _check_size(file, count, len(lists) + len(single))
    return [single | {key: value[k] for key, value in lists.items() if k < len(value)} for k in range(count)]


def _flat(file: str, name: str, value: Any) -> Iterator[tuple[str, str]]:
    """Yield names of columns and cells of a value in a record: of a point [x, y] or {"x": x, "y": y}, two."""
    if len(name) > LONGEST_NAME:
        rule, fix = f"must have names of at most {LONGEST_NAME} characters", "shorten them"
        raise InputError(rule, file=file, key=f"{name[:20]}...", value="longer", fix=fix)
    inside = isinstance(value, list) and value and all(isinstance(one, (list, dict)) for one in value)
    if isinstance(value, dict):
        for key, one in value.items():
            yield from _flat(file, f"{name}_{key}" if name else str(key), one)
    elif inside:
        for k, one in enumerate(value, 1):
            yield from _flat(file, f"{name}{k}", one)
    elif isinstance(value, list) and len(value) == len("xy"):
        yield from ((f"{name}_{axis}", _text(one)) for axis, one in zip("xy", value, strict=True))
    else:
        yield name, _text(value)


def _points(names: Sequence[str], values: Sequence[Sequence[Any]]) -> Row:
    """Return the cells of points: x, y and the score of each."""
    row: Row = {}
    for name, value in zip(names, values, strict=True):
        row |= {f"{name}_{axis}": _text(one) for axis, one in zip(("x", "y", "score"), value, strict=False)}
    return row


def _super_animal(file: str, document: Any) -> list[Row] | None:
    """Return rows of DeepLabCut's SuperAnimal: for each frame the points of each animal, without names."""
    if not isinstance(document, list) or not all(isinstance(one, dict) and "bodyparts" in one for one in document):
        return None
    rows = []
    for frame, one in enumerate(document):
        animals = [animal for animal in one["bodyparts"] if any(point[-1] > 0 for point in animal)]
        _check_one(file, frame, len(animals))
        points = animals[0] if animals else []
        rows.append({"frame": str(frame)} | _points([f"p{k + 1}" for k in range(len(points))], points))
    return rows


def _mmpose(file: str, document: Any) -> list[Row] | None:
    """Return rows of MMPose: frames with instances, of which each has keypoints and their scores."""
    if not isinstance(document, dict) or not isinstance(document.get("instance_info"), list):
        return None
    rows, named = [], document.get("meta_info", {}).get("keypoint_id2name", {})
    for k, one in enumerate(document["instance_info"]):
        _check_one(file, k, len(one["instances"]))
        row = {"frame": _text(one.get("frame_id", k))}
        for animal in one["instances"]:
            scores = animal.get("keypoint_scores", [""] * len(animal["keypoints"]))
            names = [str(named.get(str(m), f"p{m + 1}")) for m in range(len(scores))]
            row |= _points(names, [[*p[:2], s] for p, s in zip(animal["keypoints"], scores, strict=True)])
        rows.append(row)
    return rows


def _coco(file: str, document: Any) -> list[Row] | None:
    """Return rows of COCO or AlphaPose, in the order of the frames: x, y and score or visibility of each keypoint."""
    boxed = isinstance(document, dict)
    found = document.get("annotations") if boxed else document
    if not isinstance(found, list) or not all(isinstance(one, dict) and "keypoints" in one for one in found):
        return None
    pictures = {one["id"]: one.get("file_name", one["id"]) for one in document.get("images", [])} if boxed else {}
    named = {one["id"]: one.get("keypoints", []) for one in document.get("categories", [])} if boxed else {}
    rows = []
    for one in found:
        values = one["keypoints"]
        if len(values) % TRIPLE:
            rule, fix = f"must have {TRIPLE} numbers for each keypoint", "export it again"
            raise InputError(rule, file=file, key="keypoints", value=f"{len(values)} of them", fix=fix)
        points = [values[k : k + TRIPLE] for k in range(0, len(values), TRIPLE)]
        names = named.get(one.get("category_id"), [])
        names = names if len(names) == len(points) else [f"p{k + 1}" for k in range(len(points))]
        animal = next(({"animal": _text(one[key])} for key in ANIMAL if key in one), {})
        picture = _text(pictures.get(one["image_id"], one["image_id"]))
        rows.append({"frame": picture, **animal, **_points([str(name) for name in names], points)})
    return sorted(rows, key=lambda row: frame_number(row["frame"]) or 0.0)


def _check_one(file: str, frame: int, count: int) -> None:
    """Check that a frame has one animal at most, where a form does not say which is which."""
    if count > 1:
        rule, fix = "must have one animal, for nothing tells several apart", "track one, or give each a file of its own"
        raise InputError(rule, file=file, key=f"frame {frame}", value=f"{count} of them", fix=fix)


TABLES: dict[str, Callable[[str, Any], list[Row] | None]] = {
    "DeepLabCut's SuperAnimal": _super_animal,
    "MMPose": _mmpose,
    "COCO's keypoints": _coco,
}
