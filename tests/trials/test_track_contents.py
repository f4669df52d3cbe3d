"""What tables of tracks hold beside a clock: units, animals, numbers, sheets; read, or refused in a sentence."""

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.trials.markers import read_markers
from tracked_files import FILES, FRAMES, NAMES, PX, RATE, columns, numbers, pixels, swim

FPS = {"frame_rate": RATE}
PLACE = pixels(swim())


def told(path, **options) -> str:
    with pytest.raises(ht.InputError) as error:
        read_markers(path, **PX | FPS | options)
    return str(error.value)


def text(folder, content: str):
    path = folder / "swim.csv"
    path.write_text(content)
    return path


def rows(*more: str) -> list[str]:
    """Lines of the swim, below each other; more: cells behind the number of the frame."""
    head, *lines = columns(PLACE, "frame", numbers()).splitlines()
    return [head, *(line.replace(",", "".join(f",{cell}" for cell in (*more, "")), 1) for line in lines)]


def test_of_several_animals_in_a_wide_table_one_is_chosen(tmp_path) -> None:
    head, *first = rows("a")
    second = rows("b")[1:]
    head = head.replace("frame,", "frame,individual,")
    path = text(tmp_path, "\n".join([head, *(line for pair in zip(first, second, strict=True) for line in pair)]))
    assert "--individual must be one of a, b: choose the animal" in told(path)
    assert read_markers(path, **PX, **FPS, individual="b").time == pytest.approx(np.array(FRAMES) / RATE)
    path = text(tmp_path, "\n".join([head, *first[:20], *second[20:]]))
    assert "--individual must be one of a, b" in told(path)


@pytest.mark.parametrize("name", ["frames as floats", "TRex", "Motive"])
def test_an_animal_is_not_chosen_where_a_file_tells_none_apart(name, tmp_path) -> None:
    (file,) = (file for file in FILES if file.name == name)
    assert "--individual is for files of several animals, but is 'fish1'" in told(
        file.write(tmp_path), individual="fish1"
    )


def test_local_places_of_motive_are_refused(tmp_path) -> None:
    (file,) = (file for file in FILES if file.name == "Motive")
    path = file.write(tmp_path)
    first, rest = path.read_text().split("\n", 1)
    path.write_text(f"{first},Coordinate Space,Local\n{rest}")
    assert "Coordinate Space must be Global, but is 'Local'" in told(path)


def test_z_of_some_markers_is_refused(tmp_path) -> None:
    head = rows()[0]
    assert "marker nose must have a column of z, like others" in told(
        text(tmp_path, "\n".join([f"{head},eye_z", *(f"{row},1" for row in rows()[1:])]))
    )


def test_the_second_of_two_columns_x_is_called_x_1_by_pandas(tmp_path) -> None:
    head = "frame,x,y," + ",".join(f"{axis}.{m}" for m in range(1, 6) for axis in "xy")
    markers = read_markers(text(tmp_path, "\n".join([head, *rows()[1:]])), **PX, **FPS)
    assert len(markers.names) == len(NAMES)
    np.testing.assert_allclose(markers.place, swim(), atol=2e-5)


def test_six_animals_of_idtracker_are_no_body_whatever_their_clock_is_called(tmp_path) -> None:
    head = "time," + ",".join(f"{axis}{m}" for m in range(1, 7) for axis in "xy")
    assert "is of the form of idtracker.ai, and holds one point" in told(text(tmp_path, "\n".join([head, *rows()[1:]])))


@pytest.mark.parametrize("mark", [",", "."])
def test_separators_of_thousands_are_refused(tmp_path, mark) -> None:
    head, *lines = columns(np.round(PLACE), "frame", numbers(), mark=";").splitlines()
    cells = [[f"{int(c):,}".replace(",", mark) if c else "" for c in line.split(";")] for line in lines]
    assert "must be of the size of the others" in told(text(tmp_path, "\n".join([head, *map(";".join, cells)])))


def test_rows_without_cells_at_the_end_are_left_out_and_a_row_of_units_is_read(tmp_path) -> None:
    head, *lines = rows()
    blank = "," * head.count(",")
    path = text(tmp_path, "\n".join([head, *lines, blank, blank]))
    assert len(read_markers(path, **PX, **FPS).time) == len(FRAMES)
    units = "," + ",".join(["px"] * head.count(","))
    path = text(tmp_path, "\n".join([head, units, *lines]))
    assert len(read_markers(path, **PX, **FPS).time) == len(FRAMES)
    with pytest.raises(ht.InputError, match="--unit must be px, as the file says, but is a length"):
        read_markers(path, **FPS)


def test_a_mark_at_the_end_of_each_row_is_no_cell(tmp_path) -> None:
    head, *lines = rows()
    path = text(tmp_path, "\n".join([head, *(f"{line}," for line in lines)]))
    np.testing.assert_allclose(read_markers(path, **PX, **FPS).place, swim(), atol=2e-5)
    assert "line 2 must have 13 cells, like the line of names, but is 14 long" in told(
        text(tmp_path, "\n".join([head, *(f"{line},7" for line in lines)]))
    )


@pytest.mark.parametrize(
    ("above", "below", "sentence"),
    [
        ("subject,A\nday,3\n", "", "line 1 must begin with its line of names: remove the lines above line 3, if that"),
        ("subject,A,,,,,,,,,,,\n", "", "line 1 must begin with its line of names: remove the lines above line 2"),
        (
            "",
            "number,right,down,right,down,,,,,,,,\n",
            "line 2 must hold numbers, below one line of names, but is",
        ),
    ],
)
def test_lines_of_words_beside_the_line_of_names_are_named(tmp_path, above, below, sentence) -> None:
    head, *lines = rows()
    assert sentence in told(text(tmp_path, f"{above}{head}\n{below}" + "\n".join(lines)))


def test_rows_below_the_frames_of_a_file_without_a_clock_are_no_frames(tmp_path) -> None:
    """Nor does a row below an empty line or a comment, of which frames may be lost, say when it was."""
    place = np.where(np.isfinite(PLACE), PLACE, np.nanmean(PLACE))
    head, *lines = columns(place, "note", [""] * len(place)).splitlines()
    for name, of in (("means", np.mean), ("largest values", np.max)):
        last = columns(of(place, axis=0)[np.newaxis], "note", [""]).splitlines()[1]
        assert f"line 44 holds the {name} of the rows above: remove what" in told(
            text(tmp_path, "\n".join([head, *lines, last]))
        )
    for lost in ("", "# lost"):
        path = text(tmp_path, "\n".join([head, *lines[:20], lost, *lines[20:]]))
        assert "line 23 must be that of the next frame, for no column counts them, but is below lines" in told(path)
    assert len(read_markers(text(tmp_path, "\n\n".join([head, *lines])), **PX, **FPS).time) == len(lines)


def test_what_is_no_pixel_and_no_likelihood_is_named(tmp_path) -> None:
    parts = columns(PLACE / 1280, "frame", numbers())
    assert "parts of the picture's width and height?" in told(text(tmp_path, parts))
    logits = columns(PLACE, "frame", numbers(), weight=("score", "4.5", "-2"))
    assert "is up to 4.5: scale the column; of logits" in told(text(tmp_path, logits))


def test_a_table_of_poses_is_sent_to_its_own_command(tmp_path) -> None:
    poses = "time_s,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0.1,0,0,0,0,0,0,1\n"
    assert "is of the form of poses, and holds no markers: import them: hypertuna trials import poses" in told(
        text(tmp_path, poses)
    )


@pytest.mark.parametrize("unset", [0.0, -1.0])
def test_places_of_zeros_off_the_body_are_missing(tmp_path, unset) -> None:
    """Some programs write them where a marker is not found. A body that swims through the origin keeps its place."""
    place, lost = PLACE.copy(), np.zeros(PLACE.shape[:2], dtype=bool)
    lost[::4, 3] = lost[7] = True
    place[lost] = unset
    markers = read_markers(text(tmp_path, columns(place, "frame", numbers())), **PX, **FPS)
    assert (markers.weight[lost] == 0).all()
    assert f"{lost.sum()} places of zeros or -1, off the body, count as missing" in markers.notes
    home = PLACE - PLACE[0, 0]
    markers = read_markers(text(tmp_path, columns(home, "frame", numbers())), **PX, **FPS)
    assert markers.weight[0, 0] == 1


def test_flags_of_lost_markers_are_refused_and_those_of_seen_ones_read(tmp_path) -> None:
    flags = {"occluded": ("0", "1"), "valid": ("1", "0")}
    path = {name: columns(PLACE, "frame", numbers(), weight=(name, *own), missing="9") for name, own in flags.items()}
    assert "gill_occluded counts frames in which the marker was not seen: write" in told(
        text(tmp_path, path["occluded"])
    )
    assert (read_markers(text(tmp_path, path["valid"]), **PX, **FPS).weight == 0).sum() == 1
    scores = columns(PLACE, "frame", numbers(), weight=("c", "0.9", "0.1"), missing="9")
    assert (read_markers(text(tmp_path, scores), **PX, **FPS).weight == 0).sum() == 1


@pytest.mark.parametrize("names", [("x_mm", "y_mm"), ("X (mm)", "Y (mm)"), ("pos_x [mm]", "pos_y [mm]")])
def test_a_row_for_each_marker_may_state_its_unit(tmp_path, names) -> None:
    cells = [
        f"{k},{name},{x:.3f},{y:.3f}"
        for k, frame in zip(FRAMES, 1e3 * swim(), strict=True)
        for name, (x, y) in zip(NAMES, frame, strict=True)
        if np.isfinite(x)
    ]
    path = text(tmp_path, "\n".join([f"frame,marker,{','.join(names)}", *cells]))
    np.testing.assert_allclose(read_markers(path, **FPS).place, swim(), atol=2e-6)
    assert "--unit must be 0.001 m, as the file says, but is px" in told(path)


def test_a_column_of_the_rate_counts(tmp_path) -> None:
    """It must be one rate, and that of the times and of --frame-rate."""

    def read(rates, clock="frame", times=(), **options):
        head, *lines = columns(PLACE, clock, times or numbers()).splitlines()
        with_rates = [f"{head},fps", *(f"{line},{rate}" for line, rate in zip(lines, rates, strict=True))]
        return read_markers(text(tmp_path, "\n".join(with_rates)), **PX, **options)

    same, other = [60] * len(FRAMES), [120] * len(FRAMES)
    assert read(same).time[-1] == pytest.approx(47 / RATE)
    for words, given in (
        ("column fps must be the same in all rows", {"rates": [*same[1:], 30]}),
        ("--frame-rate must be 120 Hz, as the file says", {"rates": other} | FPS),
        ("the file's frame rate must be 60 Hz, as the column time_s says", {"rates": other, "clock": "time_s"}),
    ):
        with pytest.raises(ht.InputError, match=words):
            read(**given, times=[f"{k / RATE:.7f}" for k in FRAMES] if "clock" in given else ())


def test_of_a_workbook_no_run_is_dropped_in_silence(tmp_path) -> None:
    from openpyxl import Workbook

    book = Workbook()
    sheets = [book.active, book.create_sheet("second")]
    for row in [line.split(",") for line in rows()]:
        for sheet in sheets:
            sheet.append(row)
    book.save(tmp_path / "two.xlsx")
    assert "must have one sheet of a run, but is 'Sheet' and 'second' with the same columns" in told(
        tmp_path / "two.xlsx"
    )
    sheets[1]["A1"] = "notes"
    book.save(tmp_path / "two.xlsx")
    assert (
        "the sheet 'Sheet' is read, and of 1 others nothing" in read_markers(tmp_path / "two.xlsx", **PX, **FPS).notes
    )
