"""The forms of files that hold tracked points: a list that says how each form is recognized and read.

To add a form, write a module with `read(path, individual) -> Points` and its line in `FORMS`; or, for a form of text,
`recognized(grid)` and `read(grid, individual) -> Points` and its line in the `TEXTS` of its module. A reader of files
with cells can make a `Grid`, and call `points_of_grid`.
"""

from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from hypertuna.errors import InputError
from hypertuna.io.door import opened
from hypertuna.trials import form_captures, form_columns, form_headed, form_poses, form_shapes
from hypertuna.trials.form_clock import with_comments
from hypertuna.trials.grid import Grid, read_grid
from hypertuna.trials.points import Points, no_individuals

FIRST_BYTES = 512  # number of first bytes from which a file's form is recognized


class Form(NamedTuple):
    """A form of binary files: its name, its reader, and the suffixes and first bytes by which it is recognized."""

    name: str
    suffixes: tuple[str, ...]
    begins: tuple[bytes, ...] = ()
    read: str = ""  # "module:function" of (path, individual), imported when it is needed
    fix: str = ""  # for a form that is not read: what to do
    individuals: bool = False  # whether it may hold several animals, or variables
    tracks: bool = False  # whether it holds tracked points and nothing else


# Fixes in errors.
EXPORT = "export CSV: analyze_videos(..., save_as_csv=True) in DeepLabCut, Export Analysis CSV in SLEAP"
POSES = "import its poses: hypertuna trials import poses"
SAVE_CSV, TRACKED = "save it as CSV", "track its markers, and give the table of their places"
KEYPOINTS = "write its points as CSV: frame, marker, x, y, score in a row for each frame and point"
FORMS: tuple[Form, ...] = (
    Form("SLEAP's labels", (".slp",), fix="export its analysis: Export Analysis HDF5 or CSV in SLEAP", tracks=True),
    Form("HDF5", (".h5", ".hdf5"), (b"\x89HDF\r\n\x1a\n",), "hypertuna.trials.form_hdf5:read", individuals=True),
    Form("MATLAB 7.3", (), (b"MATLAB 7.3 MAT-file",), "hypertuna.trials.form_hdf5:read", individuals=True),
    Form("MATLAB", (".mat",), (b"MATLAB 5.0 MAT-file",), "hypertuna.trials.form_matlab:read", individuals=True),
    Form("C3D", (".c3d",), (), "hypertuna.trials.form_c3d:read", tracks=True),
    Form("an array of NumPy", (".npy",), (b"\x93NUMPY",), "hypertuna.trials.form_numpy:read"),
    Form("an archive of NumPy", (".npz",), (), "hypertuna.trials.form_numpy:read", individuals=True),
    Form("a workbook", (".xlsx", ".xlsm"), (), "hypertuna.trials.form_workbook:read", individuals=True),
    Form("an old workbook", (".xls", ".ods"), (b"\xd0\xcf\x11\xe0",), fix="save it as .xlsx, or the sheet as CSV"),
    Form("a log (MCAP)", (".mcap",), (b"\x89MCAP0",), fix=POSES),
    Form("a bag of ROS 2", (".db3",), (b"SQLite format 3",), fix=POSES),
    Form("a bag of ROS 1", (".bag",), (b"#ROSBAG",), fix="convert it by rosbags-convert, then import its poses"),
    Form("pickled Python", (".pickle", ".pkl"), (b"\x80\x03", b"\x80\x04", b"\x80\x05"), fix=EXPORT),
    Form("a video", (".mp4", ".avi", ".mov", ".mkv"), fix=TRACKED),
    Form("JSON", (".json", ".jsonl", ".ndjson"), (b"{", b"["), "hypertuna.trials.form_json:read", individuals=True),
    Form("XML", (".xml",), (b"<",), fix=KEYPOINTS),
    Form("a zip archive", (".zip",), (b"PK\x03\x04",), fix="unpack it"),
    Form(
        "a compressed file", (".gz", ".bz2", ".xz", ".7z", ".zst"), (b"\x1f\x8b", b"BZh", b"\xfd7zXZ"), fix="unpack it"
    ),
    Form("a table of Arrow or Parquet", (".parquet", ".feather"), (b"PAR1", b"ARROW1"), fix=SAVE_CSV),
    Form("data of R, SPSS or Stata", (".rds", ".rdata", ".sav", ".dta"), fix=SAVE_CSV),
    Form("a skeleton's motion", (".bvh", ".amc", ".asf", ".fbx"), (b"HIERARCHY",), fix=KEYPOINTS),
    Form("YAML", (".yaml", ".yml"), fix=KEYPOINTS),
    Form("a picture", (".png", ".jpg", ".jpeg", ".tif", ".tiff"), (b"\x89PNG", b"\xff\xd8\xff"), fix=TRACKED),
)
# plain columns come last, since they accept files of any other form
TEXTS = (*form_shapes.TEXTS, *form_poses.TEXTS, *form_captures.TEXTS, *form_headed.TEXTS, *form_columns.TEXTS)


def read_points(path: str | Path, individual: str | None = None) -> Points:
    """Read the tracked points of one animal, in the units of the file."""
    if form := binary_form(path):
        if form.fix:
            rule = f"must be a file of tracked points, but is of the form of {form.name}"
            raise InputError(rule, file=str(path), fix=form.fix)
        if individual is not None and not form.individuals:
            raise no_individuals(str(path), individual)
        module, _, function = form.read.partition(":")
        points: Points = getattr(import_module(module), function)(path, individual)
        return points
    return points_of_grid(read_grid(path), individual)


def points_of_grid(grid: Grid, individual: str | None) -> Points:
    """Return the points of a text file or a sheet, read by the first text form that recognizes it."""
    form = next(form for form in TEXTS if form.recognized(grid))
    if individual is not None and not form.individuals:
        raise no_individuals(grid.file, individual)
    return with_comments(form.read(grid, individual), grid.comments)


def binary_form(path: str | Path) -> Form | None:
    """Find the form of a binary file from its suffix and first bytes; return None for a text file."""
    with opened(path, "points") as stream:
        first_bytes = stream.read(FIRST_BYTES) or b""
    suffix = Path(path).suffix.lower()
    by_suffix = [form for form in FORMS if suffix in form.suffixes]
    by_bytes = [form for form in FORMS if form.begins and first_bytes.startswith(form.begins)]
    # a known suffix decides, unless the first bytes belong to another form
    if by_suffix and (by_suffix[0] in by_bytes or not by_bytes or not by_suffix[0].begins):
        return by_suffix[0]
    return by_bytes[0] if by_bytes else (by_suffix[0] if by_suffix else None)


def form_name(path: str | Path) -> str:
    """Return the form's name if a file holds tracked points, otherwise ""; other readers use it in their errors."""
    try:
        return read_points(path).form
    except InputError:
        pass
    try:  # points that cannot be read, in a form that holds nothing else
        if form := binary_form(path):
            return form.name if form.tracks else ""
        grid = read_grid(path)
    except InputError:
        return ""
    return next((form.name for form in TEXTS[:-1] if form.recognized(grid)), "")
