"""Forms of files of tracked points: one swim in each is read the same; times, weights and axes are never guessed."""

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.trials.forms import form_name
from hypertuna.trials.markers import read_markers
from tracked_files import (
    FILES,
    FPS,
    FRAMES,
    MISSING,
    NAMES,
    PX,
    RATE,
    TrackedFile,
    columns,
    kinovea,
    motive,
    numbers,
    pixels,
    seconds,
    swim,
)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_one_swim_is_read_the_same_in_every_form(file: TrackedFile, tmp_path) -> None:
    markers = read_markers(file.write(tmp_path), **file.options)
    seen = (markers.weight > 0).any(axis=1)
    time = markers.time[seen] - markers.time[seen][0]
    assert time == pytest.approx(np.array(FRAMES) / RATE, abs=1e-5)
    assert len(markers.names) == len(NAMES)
    place = swim()
    assert np.isnan(markers.place[seen][MISSING]).all()
    np.testing.assert_allclose(markers.place[seen], place, atol=2e-5)
    assert (markers.weight[seen] > 0.8).sum() == place[..., 0].size - 1


def told(path, **options) -> str:
    with pytest.raises(ht.InputError) as error:
        read_markers(path, **PX | options)
    return str(error.value)


def write(folder, clock: str, times, **more):
    path = folder / "swim.csv"
    path.write_text(columns(pixels(swim()), clock, times, **more))
    return path


@pytest.mark.parametrize(
    ("clock", "times", "options", "sentence"),
    [
        ("frame", numbers("frame"), FPS, "line 2, frame must be the number of a frame, but is 'frame'"),
        ("frame", numbers("{}.5"), FPS, "line 2, frame must be a whole number, but is 0.5"),
        ("frame", ["", *numbers()[1:]], FPS, "line 2, frame must be a finite number, but is missing"),
        ("frame", numbers()[::-1], FPS, "line 3, frame must be later than the previous frame, at 47"),
        ("frame", numbers(), {}, "must have a column of time, but is missing: give --frame-rate"),
        ("frame", numbers(), {"frame_rate": 3.0}, "--frame-rate must be from 5 to 2000 Hz, but is 3"),
        ("frame", numbers("{}00"), {"frame_rate": 60.0}, "the rate by frame must be from 5 to 2000 Hz, but is 0.6"),
        ("time_s", seconds(1e-3), {}, "by time_s must be from 5 to 2000 Hz, but is 0.06: in ms it would be possible"),
        ("time_s", seconds(), {"frame_rate": 50.0}, "--frame-rate must be 60 Hz, as the column time_s says, but is 50"),
        ("time_s", seconds(), {"frame_rate": 120.0}, "if the film was played 2 times slower, drop the column time_s"),
        (
            "time_s",
            [str(k) for k in FRAMES],
            {},
            "but is 1: in ms it would be possible: call the column time_ms; if its",
        ),
        (
            "t",
            numbers(),
            {},
            "column t must say its unit in its name: it grows by 1: call it frame if it counts",
        ),
        ("counter", numbers(), FPS, "column counter grows from row to row, but nothing says what it counts"),
        ("seconds", seconds(), {}, ""),
    ],
)
def test_a_clock_is_refused_where_it_is_in_doubt(tmp_path, clock, times, options, sentence) -> None:
    path = write(tmp_path, clock, times)
    if sentence:
        assert sentence in told(path, **options)
    else:
        assert read_markers(path, **PX, **options).notes == ()


def test_a_long_table_names_its_column_of_time_where_that_is_in_doubt(tmp_path) -> None:
    """The first of its columns, too."""
    rows = [f"{k},{name},{10 * k + m},{m}" for k in range(4) for m, name in enumerate(NAMES)]
    path = tmp_path / "long.csv"
    path.write_text("\n".join(["t,marker,x,y", *rows]))
    assert "column t must say its unit in its name: it grows by 1" in told(path)


def test_what_a_clock_was_taken_for_is_told(tmp_path) -> None:
    def notes(clock, times, **options):
        return " ".join(read_markers(write(tmp_path, clock, times), **PX, **options).notes)

    assert "column time is taken in ms, which gives 60 frames per second" in notes("time", seconds(1e-3))
    assert "the clock counts from the first frame, at 1764187812.000 s" in notes("unix_time_s", seconds(1, 1764187812))
    assert "each row counts as the next frame" in notes("comment", ["7"] * len(FRAMES), frame_rate=RATE)
    coarse = notes("time_s", [f"{k / RATE:.2f}" for k in FRAMES])
    assert "column time_s is rounded to 0.01 s, 0.5 frames" in coarse


def test_times_that_disagree_with_the_frames_are_told(tmp_path) -> None:
    times = seconds()
    path = write(tmp_path, "frame", numbers())
    rows = [row.split(",") for row in path.read_text().splitlines()]
    jump = [f"{float(t) + 0.1 * (k > 30):.4f}" for k, t in enumerate(times)]
    path.write_text("\n".join(",".join([row[0], t, *row[1:]]) for row, t in zip(rows, ["time_s", *jump], strict=True)))
    (note,) = read_markers(path, **PX).notes
    assert "the columns time_s and frame disagree by" in note


@pytest.mark.parametrize(
    ("weight", "sentence"),
    [
        (("likelihood", "970", "20"), "the likelihood of the markers must be parts of 1, or percent, but is up to 970"),
        (("score", "-0.1", "-7"), "the likelihood of the markers must be parts of 1, but is negative"),
    ],
)
def test_a_likelihood_of_another_scale_is_refused(tmp_path, weight, sentence) -> None:
    assert sentence in told(write(tmp_path, "frame", numbers(), weight=weight, missing="9"), **FPS)


def test_units_that_disagree_are_refused(tmp_path) -> None:
    path = write(tmp_path, "frame", numbers())
    text = path.read_text().replace("_x", "_x_mm").replace("_y", "_y_mm")
    path.write_text(text)
    assert "--unit or --scale must agree with the file, whose form is that of plain columns" in told(
        path, scale=1.0, pixels=False, **FPS
    )
    assert "--unit must be 0.001 m, as the file says, but is px: leave out --unit and --scale" in told(path, **FPS)
    down = read_markers(path, frame_rate=RATE, y_down=True)
    assert down.place[0, 0] == pytest.approx(swim()[0, 0])
    path.write_text(text.replace("_mm", "_px"))
    assert "--unit must be px, as the file says, but is a length" in told(path, scale=None, pixels=False, **FPS)
    assert read_markers(path, **PX, **FPS).place[0, 0] == pytest.approx(swim()[0, 0])
    path.write_text(text.replace("_mm", "_in"))
    inches = read_markers(path, frame_rate=RATE, y_down=True)
    assert inches.place[0, 0] == pytest.approx(25.4 * swim()[0, 0])
    path.write_text(text.replace("nose_x_mm", "nose_x_cm"))
    assert "names of columns must have one unit, but is cm, mm" in told(path, **FPS)


def test_tracks_of_sleap_that_do_not_follow_each_other_are_animals(tmp_path) -> None:
    (file,) = (file for file in FILES if file.name == "SLEAP")
    place = swim()
    place[[k for k, frame in enumerate(FRAMES) if frame >= 30]] += 0.6
    assert "--individual must be one of track_1, track_0: choose the animal" in told(file.write(tmp_path, place), **FPS)


def test_a_decimal_comma_beside_decimal_points_is_refused(tmp_path) -> None:
    path = write(tmp_path, "time_s", seconds(), mark=";")
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:9], lines[9].replace(".", ","), *lines[10:]]))
    assert "line 10, time_s must have one decimal sign, but is a point above, and a comma here" in told(path)


def test_points_in_space_are_seen_on_the_plane_that_they_swim_in(tmp_path) -> None:
    """A tilted plane keeps all distances; an axis that is given, or the nearest, is the vertical one."""
    place = swim()
    flat = np.concatenate([place, np.zeros_like(place[..., :1])], axis=2)
    turn = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    head = ",".join(["time_s", *(f"{name}_{axis}" for name in NAMES for axis in "xyz")])

    def read(points, **options):
        rows = [
            ",".join([time, *(f"{v:.6f}" for v in row.ravel())]) for time, row in zip(seconds(), points, strict=True)
        ]
        (tmp_path / "space.csv").write_text("\n".join([head, *rows]).replace("nan", ""))
        return read_markers(tmp_path / "space.csv", **options)

    markers = read(flat @ turn.T)
    apart = np.linalg.norm(markers.place[:, :1] - markers.place, axis=2)
    np.testing.assert_allclose(apart, np.linalg.norm(place[:, :1] - place, axis=2), atol=1e-5)
    assert "if z points down, give --y-axis down" in markers.notes[0]

    def side(place):
        """Return on which side of the line from nose to tip the dorsal marker lies [m^2]."""
        (a, b), (c, d) = place[0, [0, 3]] - place[0, 5]
        return a * d - b * c

    assert side(markers.place) == pytest.approx(side(place), abs=1e-6)
    np.testing.assert_allclose(read(flat[..., [0, 2, 1]] * [1, 1, -1], vertical="y").place, place, atol=2e-6)
    with pytest.raises(ht.InputError, match="--vertical must say which axis points up"):
        read(flat + np.random.default_rng(0).normal(0, 0.1, flat.shape))


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        (
            "a.csv",
            "# time_s,x1,y1 and others\n0.1,0.2,0.3,7\n0.2,0.3,0.4,7\n",
            "has no line of names above its numbers: remove the #",
        ),
        ("a.csv", "0.1,0.2,0.3\n0.2,0.3,0.4\n", "has no line of names above its numbers: add it"),
        ("a.csv", "time_s x1 y1\n0 1 2 3\n", "must be a table of cells, but is separated by spaces"),
        ("a.csv", "seconds,x1,y1,x2,y2\n0,1,2,3,4\n", "is of the form of idtracker.ai, and holds one point of each"),
        ("a.csv", "frame,X#wcentroid (cm),Y#wcentroid (cm)\n0,1,2\n", "is of the form of TRex, and holds one point"),
        ("a.csv", "frame,track_id,x,y\n0,1,2,3\n", "is of the form of a table of tracked objects, and holds one point"),
        ("a.csv", "LABEL,TRACK_ID,POSITION_X\n0,1,2\n", "is of the form of TrackMate, and holds one point"),
        ("a.txt", "Time\tArena\tTrack\tX\tY\tLabel\n0\t1\t1\t2\t3\t0\n", "is of the form of ToxTrac, and holds one"),
        ("a.csv", "X1,Y1,ProbId1,X2,Y2,ProbId2\n1,2,1,3,4,1\n", "is of the form of idTracker, and holds one point of"),
        (
            "a.csv",
            "Frame;Time;X_Arena0_Ind0;Y_Arena0_Ind0\n0;0;1;2\n",
            "is of the form of AnimalTA, and holds",
        ),
        (
            "a.lvm",
            "LabVIEW Measurement\t\n***End_of_Header***\nx1\ty1\n",
            "is of the form of LabVIEW, but has no",
        ),
        ("a.csv", "Subject,Behavior,Time\nfish,swim,0.5\n", "is of the form of BORIS, and holds events, no points"),
        ("a.json", '{"people": []}', "is of the form of OpenPose, of one frame, which is not read: read all files of"),
        ("a.json", "[{}, {}]", "must hold a record or a value for each frame, but is JSON of other values: write"),
        ("a.json", '{"skeletons": []}', "is of the form of SLEAP's labels, which is not read: export its analysis"),
        (
            "a.json",
            '{"a": [[1, 2, 3]]}',
            "must have columns of at least two markers, but is without: its columns are 'a'",
        ),
        (
            "a.json",
            '{"type": "x"}',
            "must hold a record or a value for each frame, but is JSON of 'type': write",
        ),
        ("a.json", '[{"bodyparts": [[[1, 2, 1]], [[1, 2, 1]]]}]', "frame 0 must have one animal, for nothing tells"),
        (
            "a.json",
            '[{"keypoints": [1, 2], "image_id": 1}]',
            "keypoints must have 3 numbers for each keypoint, but is 2",
        ),
        ("a.json", '[{"bodyparts": [[[]]]}]', "is of the form of DeepLabCut's SuperAnimal, but not whole: export it"),
        ("a.json", '[{"keypoints": {}, "image_id": []}]', "is of the form of COCO's keypoints, but not whole"),
        ("a.json", '[{"x1": 1, "y1": 2', "must be valid JSON, but is not (Expecting"),
        (
            "a.json",
            '[{"frame": "a", "x1": 1, "y1": 2, "x2": 3, "y2": 4}]',
            "record 1, frame must be the number of a frame",
        ),
        ("a.xml", "<annotations/>", "is of the form of XML: write its points as CSV"),
        ("a.txt", "t\tx\ty\n0\t1\t2\n", "is of the form of a table of tracked objects, and holds one point of each"),
        ("a.txt", "#mass A\nt\tx\ty\n0\t1\t2\n", "is of the form of Tracker, and holds one point of each animal"),
        (
            "a.txt",
            "#Kinovea Trajectory data export\n#T X Y\n0:00:00:00 8 3\n0:00:00:03 8 4\n",
            "the form of Kinovea, and",
        ),
        ("a.csv", " ,X,Y,Slice,Counter\n1,2,3,1,0\n", "is of the form of ImageJ, multi-point, and holds one point"),
        ("a.csv", "frame,0,1,2,3\nnose_x,1,2,3,4\nnose_y,1,2,3,4\n", "is a transposed table: a row for each"),
        ("a.csv", "marker,axis,0,1\nnose,x,1,2\nnose,y,3,4\neye,x,3,4\neye,y,3,4\n", "is a transposed table"),
        ("a.csv", "marker,x0,y0,x1,y1\nnose,1,2,3,4\ntail,2,3,4,5\n", "is a transposed table: a row for each"),
        ("a.csv", "time,keypoint,space,position\n0,a,x,1\n0,a,y,1\n", "has a row for each coordinate: pivot it"),
        ("a.csv", 'time_s,a,b\n0,"(1, 2)","(3, 4)"\n', "has x and y of a marker in one cell: write each into a column"),
        ("a.txt", "1 0 0 5 0 1 0 6 0 0 1 7\n" * 3, "is of the form of poses of KITTI: a rotation and a place"),
        ("a.txt", "1.5 5 6 7 0 0 0 1\n" * 3, "is of the form of poses of TUM: time, place, quaternion, and holds no"),
        ("a.csv", "time_s,nose_x_km,nose_y_km\n0,1,2\n", "without: its columns are 'nose_x_km, nose_y_km': name col"),
        ("a.csv", "dt,x1,y1,x2,y2\n0.1,1,2,3,4\n0.3,1,2,3,4\n0.1,1,2,3,4\n", "has the intervals between the frames"),
        ("a.csv", "frame,x1,y1\n0,1,5,2,0\n", "are these decimal commas? Then save it with semicolons"),
        ("a.csv", "time_s;x1;y1;x2;y2\n0;1'234'567;2;3;4\n", "write numbers without a separator of thousands"),
        ("a.csv", "time_s,x1,y1,x2,y2\n0,\u22121.5,2,3,4\n", "write numbers with a minus sign of ASCII, -"),
        ("a.csv", "time_s,x1,y1,x2,y2\n0,1.5D-03,2,3,4\n", "write numbers with e before the exponent"),
        (
            "a.csv",
            "time_s,x1,y1,x2,y2\n0,1.5 mm,2,3,4\n",
            "without their unit, which belongs in the name of the column",
        ),
        ("a.csv", "time_s,x1,y1\n0,1,2\ntime_s,x1,y1\n", "the line of names comes again"),
        ("a.csv", "t\0i\0m\0e\0\n\0", "must be text, but is with zero bytes: in UTF-16 without its mark"),
        ("a.parquet", "PAR1", "is of the form of a table of Arrow or Parquet: save it as CSV"),
        ("a.csv.gz", "x", "is of the form of a compressed file: unpack it"),
        ("a.bvh", "HIERARCHY", "is of the form of a skeleton's motion"),
        ("a.slp", "x", "is of the form of SLEAP's labels: export its analysis"),
        ("a.mp4", "x", "is of the form of a video: track its markers"),
    ],
)
def test_a_refusal_says_what_a_file_looks_like(tmp_path, name, content, sentence) -> None:
    (tmp_path / name).write_text(content)
    assert sentence in told(tmp_path / name, **FPS)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("", "sep=;\n", ""),
        ("", "Film of the tank\nby hand\n", "line 1 must begin with its line of names: remove the lines above line 3"),
        ("frame;", "Unnamed: 0;", ""),
        ("frame;", "index;", ""),
    ],
)
def test_what_programs_put_before_a_table(tmp_path, old, new, sentence) -> None:
    path = write(tmp_path, "frame", numbers(), mark=";")
    path.write_text(path.read_text().replace(old, new, 1))
    if sentence:
        assert sentence in told(path, **FPS)
    else:
        assert read_markers(path, **PX | FPS).time[-1] == pytest.approx(47 / RATE)


def test_a_marker_that_qualisys_did_not_see_first_takes_no_row_with_it(tmp_path) -> None:
    (file,) = (file for file in FILES if file.name == "Qualisys without frames")
    path = file.write(tmp_path)
    lines = path.read_text().splitlines()
    lines[7] = "\t\t\t" + "\t".join(lines[7].split("\t")[3:])
    path.write_text("\n".join(lines) + "\n")
    markers = read_markers(path)
    assert markers.time[-1] == pytest.approx(47 / RATE)
    assert np.isnan(markers.place[0, 0]).all()


def test_of_two_indices_the_one_with_lost_frames_counts(tmp_path) -> None:
    path = write(tmp_path, "", numbers())
    lines = path.read_text().splitlines()
    path.write_text("\n".join([f",{lines[0]}", *(f"{k + 1},{line}" for k, line in enumerate(lines[1:]))]))
    assert read_markers(path, **PX | FPS).time[-1] == pytest.approx(47 / RATE)
    path.write_text("\n".join([f",{lines[0]}", *(f"{3 * k},{line}" for k, line in enumerate(lines[1:]))]))
    assert "must have one index, but is 2 columns without a name that count" in told(path, **FPS)


def test_labels_of_two_videos_are_no_track(tmp_path) -> None:
    (file,) = (file for file in FILES if file.name == "labels of DeepLabCut")
    path = file.write(tmp_path)
    path.write_text(path.read_text().replace("run1,img047", "run2,img047"))
    assert "must be of one video, but is labels of the pictures of 2" in told(path, **FPS)


def test_readers_of_other_files_know_the_form_of_a_track(tmp_path) -> None:
    for file in FILES:
        assert form_name(file.write(tmp_path))
    assert form_name(tmp_path / "nowhere.csv") == ""


def test_a_comment_that_contradicts_the_file_is_refused(tmp_path) -> None:
    """A frame rate of a comment counts as one of the file, and so does a unit."""
    path = tmp_path / "swim.csv"
    path.write_text("# fps: 30\n" + columns(pixels(swim()), "time_s", seconds()))
    assert "the file's frame rate must be 60 Hz, as the column time_s says, but is 30" in told(path)
    path.write_text("# frame rate = 30 Hz\n" + columns(pixels(swim()), "frame", numbers()))
    assert "--frame-rate must be 30 Hz, as the file says, but is 60" in told(path, **FPS)
    path.write_text("# units: mm\n" + columns(pixels(swim()), "time_s", seconds()).replace("_x", "_x_cm", 1))
    assert "must have one unit" in told(path)


def test_times_of_kinovea_s_code_are_as_coarse_as_it(tmp_path) -> None:
    path = tmp_path / "swim.txt"
    path.write_text(kinovea(pixels(swim()), coded=True))
    markers = read_markers(path, **PX)
    assert markers.time == pytest.approx(np.array(FRAMES) / RATE, abs=0.0051)
    assert "is rounded to 0.01 s, 0.5 frames" in " ".join(markers.notes)


def test_a_fish_that_swims_up_the_wall_is_refused(tmp_path) -> None:
    """Motive's y points up, unless the lab exported with z up: then the fish would swim in an upright plane."""
    text = motive(swim())
    path = tmp_path / "swim.csv"
    path.write_text(text)
    assert read_markers(path).place.shape[1] == 6
    rows = [row.split(",") for row in text.splitlines()]
    for row in rows[7:]:
        for m in range(2, 20, 3):
            row[m + 1 : m + 3] = [f"{-float(row[m + 2] or 'nan'):.6g}", row[m + 1]]
    path.write_text("\n".join(map(",".join, rows)).replace("nan", ""))
    with pytest.raises(ht.InputError, match="y must point up, as the form of Motive says, but the fish moves along y"):
        read_markers(path)
    np.testing.assert_allclose(read_markers(path, vertical="z").place, swim(), atol=2e-5)
