"""Clocks of tracks: read, or refused in a sentence; the order of the rows counts only where nothing else is known."""

import io

import numpy as np
import pytest
from scipy.io import savemat

import hypertuna as ht
from hypertuna.trials.markers import read_markers
from tracked_files import FRAMES, PX, RATE, columns, numbers, pixels, seconds, swim

FPS = {"frame_rate": RATE}
TIME = np.array(FRAMES) / RATE
X, Y = np.moveaxis(np.nan_to_num(pixels(swim())), -1, 0)


def told(path, **options) -> str:
    with pytest.raises(ht.InputError) as error:
        read_markers(path, **PX | options)
    return str(error.value)


def table(folder, clock, times):
    path = folder / "swim.csv"
    path.write_text(columns(pixels(swim()), clock, times))
    return path


def matlab(folder, **arrays):
    content = io.BytesIO()
    savemat(content, {"x": X, "y": Y} | arrays)
    (folder / "swim.mat").write_bytes(content.getvalue())
    return folder / "swim.mat"


@pytest.mark.parametrize(
    "clock",
    [
        {"frame": FRAMES, "fps": RATE},
        {"frames": np.array(FRAMES)[:, np.newaxis], "fps": RATE},
        {"time_ms": 1e3 * TIME},
        {"t": TIME, "fps": RATE},
    ],
)
def test_frames_and_times_of_matlab_keep_lost_frames(tmp_path, clock) -> None:
    markers = read_markers(matlab(tmp_path, **clock), **PX)
    assert markers.time - markers.time[0] == pytest.approx(TIME)


def test_rows_of_matlab_without_a_clock_are_told_but_those_of_dltdv_are_frames(tmp_path) -> None:
    assert "each row counts as the next frame" in " ".join(read_markers(matlab(tmp_path, fps=RATE), **PX).notes)
    points = np.stack([X, Y], axis=-1).reshape(len(X), -1)
    path = tmp_path / "digitized.mat"
    savemat(path, {"xypts": points})
    assert not any("each row" in note for note in read_markers(path, **PX, **FPS).notes)
    savemat(path, {"xypts": points, "frameNum": FRAMES})
    assert read_markers(path, **PX, **FPS).time == pytest.approx(TIME)


@pytest.mark.parametrize(
    ("arrays", "sentence"),
    [
        ({"t": np.arange(48.0)}, "t must have a value for each of the 42 frames, but is of 48"),
        ({"fs": 1000.0, "fps": RATE}, "must have one frame rate, but is fs 1000, fps 60"),
        ({"x": np.ones((42, 101)), "y": np.ones((42, 101))}, "must say which side is of frames, but is 42 by 101"),
    ],
)
def test_what_matlab_leaves_in_doubt_is_refused(tmp_path, arrays, sentence) -> None:
    assert sentence in told(matlab(tmp_path, **arrays), **FPS if "fps" not in arrays else {})


@pytest.mark.parametrize(
    ("clock", "times", "options", "sentence"),
    [
        ("Timecode", numbers("00:00:00:{:02}"), FPS, "a time code counts frames: write the number of each frame"),
        ("time", [f"12:30:{k // 30:02}.{k % 30:02}" for k in FRAMES], {}, "must end with hundredths of a second, but"),
        ("time", numbers("00:00:00:{:03}"), {}, "before thousandths write a point"),
        ("recorded", numbers("12:30:{:02}.5"), FPS, "column recorded looks like a clock, but its name is not known"),
        (
            "when",
            numbers("05/04/2026 12:30:{:02} PM"),
            FPS,
            "column when looks like a clock, but its name is not known",
        ),
        (
            "when",
            numbers("2026-05-04_12-30-{:02}"),
            FPS,
            "column when numbers the rows by names, but nothing says what",
        ),
        ("moment", [f"{k / RATE:.1f}" for k in FRAMES], FPS, "column moment grows from row to row, but nothing says"),
        ("moment", ["", *numbers()[1:]], FPS, "column moment grows from row to row, but nothing says"),
        ("timestamp", seconds(1e-7, digits=0), {}, "or give --frame-rate: 6 Hz in us, 60 Hz in 100 ns"),
        ("timestamp", seconds(1e-7, digits=0), {"frame_rate": 55.0}, "must grow by 0.01818 s, as the frame rate of 55"),
        ("timestamp", seconds(1 / 90000, digits=0), {}, "666.7 Hz in us, 60 Hz in ticks of 90 kHz"),
        ("time", [f"{k / 1800:.7f}" for k in FRAMES], {}, "1800 Hz in s, 30 Hz in min"),
        ("frame", numbers()[::-1], FPS, "they run backward: write the last row first"),
        ("frame", [str((k + 220) % 256) for k in FRAMES], FPS, "a counter that starts over at 256: add 256"),
        ("time_s", [f"{(59.4 + t) % 60:.4f}" for t in TIME], {}, "a counter that starts over at 60: add 60"),
        ("frame", [str(k % 21) for k in range(42)], FPS, "it starts over there: give each run in a file of its own"),
        ("frame", [str(k // 2) for k in range(42)], FPS, "several animals, or rounded times?"),
        ("frame", [str(k ^ 1) for k in range(42)], FPS, "sort the frames by time"),
        ("image", numbers("img{:04}_cam1.png"), FPS, "must end with the number of the frame, but is 1 in all"),
        ("image", [f"20260504-123015-{int(k * 25 / 6):03}.png" for k in FRAMES], FPS, "are names with a time of day"),
    ],
)
def test_a_clock_that_cannot_be_read_is_refused(tmp_path, clock, times, options, sentence) -> None:
    assert sentence in told(table(tmp_path, clock, times), **options)


@pytest.mark.parametrize("clock", ["Zeit [s]", "temps (s)", "tiempo_s", "時間 [s]", "Время, s"])
def test_a_clock_in_another_language_is_read(tmp_path, clock) -> None:
    assert read_markers(table(tmp_path, clock.replace(",", ""), seconds()), **PX).time == pytest.approx(TIME, abs=1e-6)


def test_hundredths_of_a_second_are_read_although_frames_are_lost_where_they_start_over(tmp_path) -> None:
    times = [f"12:30:{(k + 80) // 100:02}.{(k + 80) % 100:02}" for k in FRAMES]
    assert read_markers(table(tmp_path, "time", times), **PX).time[-1] == pytest.approx(45000 + 1.27)


def test_rows_of_two_days_that_are_mixed_up_are_refused(tmp_path) -> None:
    times = [f"{(86399.5 + t) % 86400 // 3600:02.0f}:00:{(86399.5 + t) % 60:09.6f}" for t in TIME]
    times = ["23:59:" + time[6:] if time[:2] == "23" else time for time in times]
    assert read_markers(table(tmp_path, "time", times), **PX).time[-1] == pytest.approx(86399.5 + TIME[-1])
    times[5], times[30] = times[30], times[5]
    assert "line 7, time must be later than the previous frame" in told(table(tmp_path, "time", times), **FPS)


def test_a_clock_of_a_day_keeps_its_precision_in_what_is_written(tmp_path) -> None:
    from hypertuna.trials.marker_import import _write

    _write(tmp_path / "a.csv", "late", ["time_s", "x"], np.array([[45015.016667, 1 / 3]]))
    assert (tmp_path / "a.csv").read_text().endswith("45015.016667,0.3333333\n")


def test_clocks_that_disagree_are_refused(tmp_path) -> None:
    times = [f"{k / 30:.4f},{1e3 * k / 240:.3f}" for k in FRAMES]
    assert "the columns time_s and timestamp_ms must agree, but is 1.567 s long and 0.1958 s" in told(
        table(tmp_path, "time_s,timestamp_ms", times)
    )
    poses = {f"pose{axis}{m}": one[:, m] for m in range(6) for axis, one in (("X", X), ("Y", Y))}
    np.savez(tmp_path / "trex.npz", timestamp=1e6 * TIME, frame_rate=np.array(30.0), time=TIME, **poses)
    assert "the file's frame rate must be 60 Hz, as the column time says, but is 30: correct the rate in" in told(
        tmp_path / "trex.npz"
    )
    np.savez(tmp_path / "trex.npz", timestamp=1e6 * TIME, frame_rate=np.array(RATE), **poses)
    assert read_markers(tmp_path / "trex.npz", **PX).time == pytest.approx(TIME)


def test_the_name_of_the_film_in_each_row_is_no_frame(tmp_path) -> None:
    path = table(tmp_path, "file,time_s", [f"swim.mp4,{time}" for time in seconds()])
    assert read_markers(path, **PX).time == pytest.approx(TIME, abs=1e-6)
