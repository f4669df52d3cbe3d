"""One swim of a tracked fish in every form of text file: frames 20 to 25 lost, a marker missing, one unsure."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

RATE = 60.0  # Hz
FRAMES = [k for k in range(48) if not 20 <= k < 26]
NAMES = ("nose", "eye", "gill", "dorsal", "peduncle", "tip")
MISSING = (5, 2)  # frame in the list, marker
PX = {"scale": 0.001, "pixels": True}


def swim(count: int = 6) -> np.ndarray:
    """Places (frames, markers, 2) [m] of a wave that moves to -x; one is missing."""
    frame = np.array(FRAMES)[:, np.newaxis]
    along = np.linspace(0, 0.3, count)
    phase = 2 * np.pi * (2 * frame / RATE - along / 0.3)
    x = 1 - 0.2 * frame / RATE + along
    place = np.stack([np.round(x, 5), np.round(-0.5 + 0.1 * along * np.sin(phase), 5)], axis=-1)
    if count == 6:
        place[MISSING] = np.nan
    return place


@dataclass(frozen=True, eq=False)
class TrackedFile:
    """A file of the swim, and how it is read."""

    name: str
    text: Callable[[np.ndarray], str | bytes]
    options: dict[str, Any] = field(default_factory=dict)
    suffix: str = ".csv"

    def write(self, folder: Path, place: np.ndarray | None = None) -> Path:
        path = folder / f"swim{self.suffix}"
        text = self.text(swim() if place is None else place)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path


def pixels(place: np.ndarray) -> np.ndarray:
    """Places in pixels of 1 mm, y down."""
    return place * [1000, -1000]


def cell(value: float, missing: str = "") -> str:
    return f"{value:.6g}" if np.isfinite(value) else missing


def table(rows: Sequence[Sequence[str]], mark: str = ",") -> str:
    return "\n".join(mark.join(row) for row in rows) + "\n"


def columns(
    place: np.ndarray,
    clock: str,
    times: Sequence[str],
    *,
    mark: str = ",",
    weight: Sequence[str] = (),
    missing: str = "",
) -> str:
    """Columns nose_x, nose_y, ... behind a column of time or frames; weight: name, of seen and of missing."""
    more = [weight[0]] if weight else []
    head = [clock, *(f"{name}_{axis}" for name in NAMES for axis in ("x", "y", *more))]
    rows = [head]
    for time, frame in zip(times, place, strict=True):
        row = [time]
        for point in frame:
            row += [cell(value, missing) for value in point]
            row += [weight[1] if np.isfinite(point).all() else weight[2]] if weight else []
        rows.append(row)
    return table(rows, mark)


def seconds(unit: float = 1.0, start: float = 0.0, digits: int = 6) -> list[str]:
    return [f"{(start + k / RATE) / unit:.{digits}f}" for k in FRAMES]


def numbers(form: str = "{}") -> list[str]:
    return [form.format(k) for k in FRAMES]


def deeplabcut(
    place: np.ndarray, *, index: Sequence[str] | None = None, animals: Sequence[str] = ("",), more: Sequence[str] = ()
) -> str:
    """Lines of names, then frames; the second animal swims elsewhere. index: cells before the points."""
    lead = 1 if index is None else len(index)
    axes = ("x", "y") if index is not None else ("x", "y", "likelihood", *more)
    points = [(animal, name, axis) for animal in animals for name in NAMES for axis in axes]
    blank = [""] * (lead - 1)
    rows = [["scorer", *blank, *["net"] * len(points)]]
    if animals != ("",):
        rows.append(["individuals", *blank, *(animal for animal, _, _ in points)])
    rows += [
        ["bodyparts", *blank, *(name for _, name, _ in points)],
        ["coords", *blank, *(axis for *_, axis in points)],
    ]
    for k, frame in zip(FRAMES, place, strict=True):
        row = [str(k)] if index is None else [part.format(k) for part in index]
        for shift in range(len(animals)):
            for point in frame:
                seen = bool(np.isfinite(point).all())
                row += [cell(value + 300 * shift) for value in (point if seen or index is not None else (7.0, 7.0))]
                row += [] if index is not None else ["0.98" if seen else "0.02", *["3.5"] * len(more)]
        rows.append(row)
    return table(rows)


def sleap(place: np.ndarray) -> str:
    """Two tracks of one animal, one after the other; corrected frames without scores."""
    rows = [
        ["track", "frame_idx", "instance.score", *(f"{name}.{axis}" for name in NAMES for axis in ("x", "y", "score"))]
    ]
    for k, frame in zip(FRAMES, place, strict=True):
        corrected = k % 4 == 0
        row = ["track_0" if k < 30 else "track_1", str(k), "nan" if corrected else "0.9"]
        for point in frame:
            row += [*map(cell, point), "" if corrected or not np.isfinite(point).all() else "0.93"]
        rows.append(row)
    return table([rows[0], *rows[30:], *rows[1:30]])


def space(place: np.ndarray, up: str) -> np.ndarray:
    """Places (frames, markers, 3) [m] with another axis up, right-handed."""
    x, y = place[..., 0], place[..., 1]
    depth = np.where(np.isfinite(x), 0.02, np.nan)
    return np.stack([x, y, depth] if up == "z" else [x, depth, -y], axis=-1)


def anipose(place: np.ndarray) -> str:
    parts = ("x", "y", "z", "error", "ncams", "score")
    rows = [[*(f"{name}_{part}" for name in NAMES for part in parts), "M_00", "center_0", "fnum"]]
    for k, frame in zip(FRAMES, 1e3 * space(place, "z"), strict=True):
        row = []
        for point in frame:
            seen = bool(np.isfinite(point).all())
            row += [*map(cell, point), "0.2" if seen else "", "2", "0.96" if seen else ""]
        rows.append([*row, "1", "0", str(k)])
    return table(rows)


def digitized(place: np.ndarray, cameras: bool) -> str:
    """DLTdv: a row for each frame of the film, NaN where nothing was clicked."""
    by = dict(zip(FRAMES, place if cameras else space(place, "z"), strict=True))
    if cameras:
        head = [f"pt{m + 1}_cam{c}_{axis}" for m in range(6) for c in (1, 2) for axis in "XY"]
    else:
        head = [f"pt{m + 1}_{axis}" for m in range(6) for axis in "XYZ"]
    rows = [head]
    for k in range(FRAMES[-1] + 1):
        points = by.get(k, np.full((6, 2 if cameras else 3), np.nan))
        rows.append([cell(value, "NaN") for point in points for value in (*point, *(point if cameras else ()))])
    return table(rows)


def sparse(place: np.ndarray, head: str = "") -> str:
    """Of DLTdv 8: frame, column and value of each number that was set, column after column."""
    rows = [
        [str(k + 1), str(2 * m + c + 1), cell(value)]
        for m in range(6) for c in range(2) for k, value in zip(FRAMES, place[:, m, c], strict=True)
        if np.isfinite(value)
    ]  # fmt: skip
    return head + table(rows, "\t")


def trex(place: np.ndarray) -> str:
    head = [
        "frame",
        "time",
        "X#wcentroid (cm)",
        "Y#wcentroid (cm)",
        *(f"pose{axis}{m}" for m in range(6) for axis in "XY"),
    ]
    rows = [head]
    for k, frame in zip(FRAMES, place, strict=True):
        rows.append([str(k), f"{k / RATE:.6f}", "1", "2", *(cell(value, "inf") for point in frame for value in point)])
    return table(rows)


def motive(place: np.ndarray) -> str:
    names = [f"fish:{name}" for name in NAMES for _ in "xyz"]
    rows = [
        ["Format Version", "1.23", "Take Name", "t", "Capture Frame Rate", "60", "Export Frame Rate", "60"],
        ["", "Type", *["Marker"] * 18, *["Rigid Body"] * 3],
        ["", "Name", *names, *["fish"] * 3],
        ["", "ID", *["1:1"] * 18, *["2"] * 3],
        ["", "", *["Position"] * 18, *["Position"] * 3],
        ["Frame", "Time (Seconds)", *["X", "Y", "Z"] * 7],
    ]
    rows[0] += ["Length Units", "Millimeters"]
    for k, frame in zip(FRAMES, 1e3 * space(place, "y"), strict=True):
        rows.append([str(k), f"{k / RATE:.6f}", *(cell(value) for point in frame for value in point), "1", "2", "3"])
    return table([rows[0], [""], *rows[1:]])


def qualisys(place: np.ndarray, lead: bool) -> str:
    rows = [["NO_OF_FRAMES", str(len(FRAMES))], ["NO_OF_CAMERAS", "4"], ["NO_OF_MARKERS", "6"], ["FREQUENCY", "60"]]
    rows += [["DESCRIPTION", "--"], ["DATA_INCLUDED", "3D"], ["MARKER_NAMES", *NAMES]]
    if lead:
        rows.append(["Frame", "Time", *(f"{name} {axis}" for name in NAMES for axis in "XYZ")])
    by = dict(zip(FRAMES, 1e3 * space(place, "z"), strict=True))
    for k in FRAMES if lead else range(FRAMES[-1] + 1):
        own = by.get(k, np.zeros((6, 3)))
        row = [str(k + 1), f"{k / RATE:.6f}"] if lead else []
        rows.append([*row, *(cell(value, "0.000") for point in own for value in point)])
    return table(rows, "\t")


def vicon(place: np.ndarray) -> str:
    """Devices first, as Nexus exports them."""
    rows = [["Devices"], ["600"], ["", "", "Force"], ["Frame", "Sub Frame", "Fx"], ["", "", "N"], ["1", "0", "3.2"]]
    rows += [["Trajectories"], ["60"], ["", "", *(c for name in NAMES for c in (f"fish:{name}", "", ""))]]
    rows += [["Frame", "Sub Frame", *["X", "Y", "Z"] * 6], ["", "", *["mm"] * 18]]
    for k, frame in zip(FRAMES, 1e3 * space(place, "z"), strict=True):
        rows.append([str(k + 1), "0", *(cell(value) for point in frame for value in point)])
    return table(rows)


def trc(place: np.ndarray) -> str:
    """Of OpenSim: lines end with a tab, numbers begin below an empty line."""
    rows = [
        ["PathFileType", "4", "(X/Y/Z)", "swim.trc"],
        ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units"],
    ]
    rows += [["60.00", "60.00", str(len(FRAMES)), "6", "mm"]]
    rows += [["Frame#", "Time", *(c for name in NAMES for c in (name, "", ""))]]
    rows += [["", "", *(f"{axis}{m + 1}" for m in range(6) for axis in "XYZ")], [""]]
    for k, frame in zip(FRAMES, 1e3 * space(place, "z"), strict=True):
        rows.append([str(k + 1), f"{k / RATE:.6f}", *(cell(value) for point in frame for value in point), ""])
    return table(rows, "\t")


def names_above(place: np.ndarray, clock: str, over: str, times: Sequence[str], before: str = "") -> str:
    """Names above x, y, as Tracker and pandas write them."""
    rows = [[over, *(c for name in NAMES for c in (name, "" if before else name))], [clock, *["x", "y"] * 6]]
    rows += [[t, *map(cell, frame.ravel())] for t, frame in zip(times, place, strict=True)]
    return before + table(rows)


def ethovision(place: np.ndarray) -> str:
    rows = [['"Number of header lines:"', '"6"'], ['"Experiment"', '"tank"'], ['"Subject name"', '"Subject 1"'], []]
    rows += [['"Trial time"', '"Recording time"', *(f'"{axis} {name}"' for name in NAMES for axis in "XY")]]
    rows += [['"s"', '"s"', *['"cm"'] * 12]]
    for k, frame in zip(FRAMES, 1e2 * place, strict=True):
        rows.append([*[f"{k / RATE:.6f}"] * 2, *(cell(value, '"-"') for point in frame for value in point)])
    return table(rows, ";")


def with_units(place: np.ndarray) -> str:
    """Units in a line below the names, as TEMA writes them."""
    head, rows = columns(1e3 * place, "Time", seconds(1e-3, digits=3), mark=";").split("\n", 1)
    return f"{head}\n[ms]{';[mm]' * 12}\n{rows}"


def labview(place: np.ndarray) -> str:
    """A measurement file: two headers, decimal commas, an empty column of comments."""
    head, *rows = columns(place, "X_Value", seconds(), mark="\t").replace(".", ",").splitlines()
    lines = ["LabVIEW Measurement\t", "Separator\tTab", "Decimal_Separator\t,", "Time\t12:30:15,1"]
    lines += ["***End_of_Header***\t", "\t", "Channels\t12" + "\t" * 12, "X_Dimension\tTime", "***End_of_Header***\t"]
    return "\n".join([*lines, f"{head}\tComment", *(f"{row}{chr(9) * (k % 2)}" for k, row in enumerate(rows))])


def named(form: str) -> Callable[[np.ndarray], str]:
    """Other names of the columns of coordinates, of the marker {m}, {M} in capitals, and the axis {a} or {A}."""

    def text(place: np.ndarray) -> str:
        _, *rows = columns(place, "", seconds()).splitlines()
        names = [form.format(m=name, M=name.capitalize(), a=axis, A=axis.upper()) for name in NAMES for axis in "xy"]
        return "\n".join([",".join(["Zeit [s]", *names]), *rows])

    return text


def kinovea(place: np.ndarray, coded: bool) -> str:
    """One point after the other, and a time code in hundredths of seconds, or names and milliseconds."""
    lines = ["#Kinovea Trajectory data export", "#T X Y", *[""] * (not coded)]
    for m, name in enumerate(NAMES):
        lines += [] if coded else [f"# {name}"]
        for k, (x, y) in zip(FRAMES, place[:, m], strict=True):
            time = f"0:00:00:{100 * k / RATE:02.0f}" if coded else f"{1000 * k / RATE:.3f}"
            lines += [f"{time} {x:.6g} {y:.6g} "] * bool(np.isfinite(x))
        lines.append("")
    return "\n".join(lines)


def stamps(place: np.ndarray) -> str:
    """Seconds and nanoseconds in two columns, as ROS writes them."""
    head, *rows = columns(place, "", [f"{1764187812 + k // 60},{k % 60 * 10**9 // 60}" for k in FRAMES]).split("\n")
    return "\n".join([f"header.stamp.sec,header.stamp.nanosec{head}", *rows])


def long(place: np.ndarray, animals: bool) -> str:
    rows = [["frame", *["individual"] * animals, "bodypart", "x", "y", "likelihood"]]
    for k, frame in reversed(list(zip(FRAMES, place, strict=True))):
        for animal in ("ann", "bob") if animals else ("",):
            for name, point in zip(NAMES, frame, strict=True):
                seen = bool(np.isfinite(point).all())
                if seen or animals:
                    shift = 500 * (animal == "bob")
                    own = [
                        *(cell(value + shift) for value in (point if seen else (1.0, 1.0))),
                        "0.9" if seen else "0.1",
                    ]
                    rows.append([str(k), *[animal] * animals, name, *own])
    return table(rows)


def of(name: str, text: Callable[[np.ndarray], str | bytes], suffix: str = ".csv", **options: Any) -> TrackedFile:
    return TrackedFile(name, lambda place: text(pixels(place)), PX | options, suffix)


def weighted(name: str, seen: str, missing: str) -> Callable[[np.ndarray], str]:
    return lambda place: columns(place, "frame", numbers(), weight=(name, seen, missing), missing="9")


def clocked(clock: str, times: Sequence[str], **more: Any) -> Callable[[np.ndarray], str]:
    return lambda place: columns(place, clock, times, **more)


def records(place: np.ndarray) -> list[dict[str, Any]]:
    """Records of the frames, {"frame": 0, "nose_x": ..., ...}; a missing number is null, as pandas writes it."""
    cells = [[None if np.isnan(value) else float(value) for value in frame.ravel()] for frame in np.round(place, 3)]
    names = [f"{name}_{axis}" for name in NAMES for axis in "xy"]
    return [{"frame": k, **dict(zip(names, row, strict=True))} for k, row in zip(FRAMES, cells, strict=True)]


def by_index(place: np.ndarray) -> dict[str, dict[str, Any]]:
    """Columns whose values are keyed by the frame, as pandas writes a table with that index."""
    rows = records(place)
    return {name: {str(row["frame"]): row[name] for row in rows} for name in [*rows[0]][1:]}


def nested(row: dict[str, Any]) -> dict[str, Any]:
    """Return a record with the markers as x and y in a list, or as an object."""
    points = {name: [row[f"{name}_x"], row[f"{name}_y"]] for name in NAMES}
    return {"frame": row["frame"], **points, "tip": {"x": row["tip_x"], "y": row["tip_y"]}}


def keypoints(frame: np.ndarray, score: float) -> list[list[float]]:
    """Return x, y and score of each marker; zeros of one that is missing."""
    return [[*map(float, point), score] if np.isfinite(point).all() else [0.0, 0.0, 0.0] for point in frame]


def super_animal(place: np.ndarray) -> list[dict[str, Any]]:
    """All frames of the film, the fish beside an animal that was not found."""
    by = {k: keypoints(frame, 0.9) for k, frame in zip(FRAMES, place, strict=True)}
    empty = [[-1.0, -1.0, -1.0]] * len(NAMES)
    return [{"bodyparts": [by.get(k, empty), empty], "bboxes": []} for k in range(FRAMES[-1] + 1)]


def coco(place: np.ndarray, film: bool) -> dict[str, Any] | list[dict[str, Any]]:
    """Annotations of pictures in COCO's form, in no order; or results that name their pictures, as AlphaPose."""
    found = []
    for k, frame in zip(FRAMES, place, strict=True):
        values = [value for point in keypoints(frame, 0.9 if film else 2) for value in point]
        found.insert(0, {"image_id": f"{k}.jpg" if film else 500 + k, "category_id": 1, "keypoints": values})
    pictures = [{"id": 500 + k, "file_name": f"run/img{k:04d}.png"} for k in FRAMES]
    return found if film else {"images": pictures, "annotations": found, "categories": [{"id": 1, "keypoints": NAMES}]}


def mmpose(place: np.ndarray) -> dict[str, Any]:
    info = []
    for k, frame in zip(FRAMES, place, strict=True):
        points = keypoints(frame, 0.9)
        animal = {"keypoints": [p[:2] for p in points], "keypoint_scores": [p[2] for p in points]}
        info.append({"frame_id": k, "instances": [animal]})
    return {"meta_info": {"keypoint_id2name": {str(m): name for m, name in enumerate(NAMES)}}, "instance_info": info}


def of_json(name: str, document: Callable[[np.ndarray], Any], **options: Any) -> TrackedFile:
    return of(name, lambda place: json.dumps(document(place)), ".json", **options)


def clock(seconds: float) -> str:
    """Return a time of the day."""
    return f"{seconds % 86400 // 3600:02.0f}:{seconds % 3600 // 60:02.0f}:{seconds % 60:09.6f}"


FPS = {"frame_rate": RATE}
SINCE_1970 = [str(1764187812000000000 + round(k * 1e9 / RATE)) for k in FRAMES]
FILES = (
    of("seconds", clocked("time_s", seconds())),
    of("milliseconds", clocked("Time [ms]", seconds(1e-3, digits=3))),
    of("timestamps in ms", clocked("timestamp", seconds(1e-3, digits=3))),
    of("timestamps in us", clocked("timestamp", seconds(1e-6, digits=0)), **FPS),
    of("timestamps in ticks of 100 ns", clocked("timestamp", seconds(1e-7, digits=0)), **FPS),
    of("dates", clocked("datetime", [f"2026-05-04T12:30:{15 + k / RATE:09.6f}+02:00" for k in FRAMES])),
    of("seconds and nanoseconds", stamps),
    of("times of the day over midnight", clocked("time", [clock(86399.9 + k / RATE) for k in FRAMES])),
    of("a frame rate in a comment", lambda p: f"# fps: {RATE:g}\n{columns(p, 'frame', numbers())}"),
    TrackedFile("a unit in a comment", lambda p: f"# unit: mm\n{columns(1e3 * p, 'time_s', seconds())}"),
    of("spaces, names in a comment", lambda p: "# " + columns(p, "time_s", seconds(), mark=" ", missing="nan"), ".txt"),
    of("bars", clocked("time_s", seconds(), mark="|"), ".txt"),
    of("hours, minutes, seconds", clocked("Time (hh:mm:ss.fff)", [f"0:00:{k / RATE:09.6f}" for k in FRAMES])),
    of("timestamps in ns since 1970", clocked("timestamp_ns", SINCE_1970)),
    of("frames as floats", clocked("frame", numbers("{}.0")), **FPS),
    of("frames with exponents", clocked("Frame No.", numbers("{:e}")), **FPS),
    of("names of images", clocked("image", numbers("run1/img{:04d}.png")), **FPS),
    of("the index of pandas", clocked("", numbers()), **FPS),
    of("semicolons and decimal commas", lambda p: columns(p, "time_s", seconds(), mark=";").replace(".", ",")),
    of("tabs", clocked("time_s", seconds(), mark="\t"), ".tsv"),
    of("UTF-16", lambda p: columns(p, "time_s", seconds(), mark="\t").encode("utf-16")),
    of("words of visibility", weighted("visible", "True", "False"), **FPS),
    of("likelihood in percent", weighted("likelihood", "97", "2"), **FPS),
    of("flags of visibility", weighted("visibility", "2", "0"), **FPS),
    of("DeepLabCut", deeplabcut, **FPS),
    of("Lightning Pose", lambda p: deeplabcut(p, more=("x_ens_median", "y_ens_var")), **FPS),
    of("DeepLabCut, two animals", lambda p: deeplabcut(p, animals=("ann", "bob")), individual="ann", **FPS),
    of("labels of DeepLabCut", lambda p: deeplabcut(p, index=("labeled-data", "run1", "img{:03d}.png")), **FPS),
    of("older labels of DeepLabCut", lambda p: deeplabcut(p, index=("labeled-data/run1/img{:03d}.png",)), **FPS),
    of("SLEAP", sleap, **FPS),
    TrackedFile("Anipose", anipose, {"scale": 0.001} | FPS),
    of("DLTdv, two cameras", lambda p: digitized(p, cameras=True), individual="cam2", **FPS),
    TrackedFile("DLTdv in space", lambda p: digitized(p, cameras=False), FPS),
    of("DLTdv 8, sparse", sparse, ".tsv", **FPS),
    of("DLTdv 8, sparse with names", lambda p: sparse(p, "# row\tcolumn\tvalue\n"), ".tsv", **FPS),
    of("TRex", trex),
    TrackedFile("Motive", motive),
    TrackedFile("Qualisys", lambda p: qualisys(p, lead=True), suffix=".tsv"),
    TrackedFile("Qualisys without frames", lambda p: qualisys(p, lead=False), suffix=".tsv"),
    TrackedFile("Vicon", vicon),
    TrackedFile("TRC", trc, suffix=".trc"),
    TrackedFile("Tracker", lambda p: names_above(p, "t", "", seconds(), "#multi:\n"), {}),
    of("Kinovea", lambda p: kinovea(p, coded=False), ".txt"),
    of("names above x and y", lambda p: names_above(p, "", "bodypart", numbers()), **FPS),
    TrackedFile("EthoVision", ethovision, suffix=".txt"),
    of_json("JSON of records", records, **FPS),
    of_json("JSON of columns", lambda p: {key: [row[key] for row in records(p)] for key in records(p)[0]}, **FPS),
    of_json("JSON of columns by frame", by_index, **FPS),
    of_json("JSON of frames", lambda p: {row.pop("frame"): row for row in records(p)}, **FPS),
    of_json("JSON of points", lambda p: {"fps": RATE, "frames": [nested(row) for row in records(p)]}),
    of_json(
        "JSON of pandas",
        lambda p: {"columns": [*records(p)[0]], "data": [[*row.values()] for row in records(p)]},
        **FPS,
    ),
    of("lines of JSON", lambda p: "\n".join(map(json.dumps, records(p))), ".jsonl", **FPS),
    of_json("DeepLabCut's SuperAnimal", super_animal, **FPS),
    of_json("COCO", lambda p: coco(p, film=False), **FPS),
    of_json("AlphaPose", lambda p: coco(p, film=True), **FPS),
    of_json("MMPose", mmpose, **FPS),
    TrackedFile("units below the names", with_units),
    of("LabVIEW", labview, ".lvm"),
    *(of(f"names {form}", named(form)) for form in ("{M}{A}", "{M} ({a})", "{m}[{a}]", "{m}|{a}", "{m}_{a}_coord")),
    of("rows of frames and markers", lambda p: long(p, animals=False), **FPS),
    of("rows of two animals", lambda p: long(p, animals=True), individual="ann", **FPS),
)
