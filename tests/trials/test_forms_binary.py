"""Tracked points in binary files: one swim reads the same in every form; what holds no points is refused."""

import pickle
import struct
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import point_files
from hypertuna.errors import InputError
from hypertuna.io import extras, hdf5
from hypertuna.io.hdf5 import read_hdf5
from hypertuna.trials import form_hdf5
from hypertuna.trials.forms import read_points
from hypertuna.trials.markers import read_markers
from point_files import FORMS, FRAMES, HIDDEN, NAMES, RATE, swim

ASIDE = np.array([1000.0, 0.0])  # where another animal is


def saved(folder: Path, name: str, content: bytes) -> Path:
    """A file of that content."""
    (folder / name).write_bytes(content)
    return folder / name


@pytest.mark.parametrize("name", FORMS)
def test_one_swim_reads_the_same_in_every_form(name, tmp_path):
    end, content, form = FORMS[name]
    points = read_points(saved(tmp_path, f"swim{end}", content()))
    assert points.form == form
    assert points.place[..., :2] == pytest.approx(swim(), abs=1e-4, nan_ok=True)  # C3D has floats of 32 bits
    assert np.isnan(points.place[HIDDEN]).all()
    assert len(points.where) == FRAMES
    rate = None if points.rate else RATE
    markers = read_markers(tmp_path / f"swim{end}", frame_rate=None if points.time is not None else rate)
    assert np.diff(markers.time) == pytest.approx(1 / RATE)
    assert (markers.weight > 0).sum() == FRAMES * len(NAMES) - 1


@pytest.mark.parametrize("make", [point_files.deeplabcut, point_files.deeplabcut_fixed])
def test_an_animal_of_several_is_chosen(make, tmp_path):
    path = saved(tmp_path, "two.h5", make(("left", "right")))
    assert read_points(path, "right").place == pytest.approx(swim() + ASIDE, nan_ok=True)
    with pytest.raises(InputError, match="--individual must be one of left, right: choose the animal"):
        read_points(path)


def test_tracks_that_are_there_together_are_two_animals(tmp_path):
    path = saved(tmp_path, "two.h5", point_files.sleap(2, overlap=True))
    assert read_points(path, "fish_1").place == pytest.approx(swim() + ASIDE, nan_ok=True)
    with pytest.raises(InputError, match="must be one of fish_0, fish_1"):
        read_points(path)


def test_tracks_one_after_the_other_but_apart_are_two_animals(tmp_path):
    """The second begins 1 m from where the first ended; a fish of 0.3 m does not go so far from frame to frame."""
    place = swim()
    track = np.full((2, *place.shape), np.nan)
    track[0, : FRAMES // 2], track[1, FRAMES // 2 :] = place[: FRAMES // 2], place[FRAMES // 2 :] + ASIDE
    with h5py.File(tmp_path / "two.h5", "w") as file:
        file["tracks"], file["node_names"] = track.transpose(0, 3, 2, 1), [name.encode() for name in NAMES]
    with pytest.raises(InputError, match="--individual must be one of track_0, track_1: choose the animal"):
        read_points(tmp_path / "two.h5")


def test_a_variable_that_may_be_a_clock_is_refused_and_likelihoods_count(tmp_path):
    frames, seen = 2.0 * np.arange(FRAMES), np.ones(swim().shape[:2])
    seen[3, 1] = 0.1
    path = saved(tmp_path, "a.mat", point_files._mat({"points": swim(), "sampleID": frames}))
    with pytest.raises(InputError, match="variable sampleID grows from frame to frame, but nothing says what"):
        read_points(path)
    path = saved(tmp_path, "a.mat", point_files._mat({"points": swim(), "likelihood": seen, "frame": frames}))
    markers = read_markers(path, frame_rate=2 * RATE)
    assert np.diff(markers.time) == pytest.approx(1 / RATE)
    assert markers.weight[3, 1] == 0


def test_tracks_that_are_joined_are_told(tmp_path):
    (note,) = read_points(saved(tmp_path, "one.h5", point_files.sleap(2))).notes
    assert note.startswith("the tracks fish_0, fish_1 are never there at the same time")


def test_midlines_of_trex_are_taken_at_equal_steps(tmp_path):
    points = read_points(saved(tmp_path, "swim_posture_fish0.npz", point_files.trex_midlines()))
    assert points.place[6, :, 0] == pytest.approx(309 + np.linspace(0, 120, 11))
    assert points.frame.tolist() == list(range(FRAMES))


def test_c3d_says_its_unit_rate_and_vertical(tmp_path):
    points = read_points(saved(tmp_path, "swim.c3d", point_files.c3d()))
    assert (points.length_unit, points.rate, points.vertical, points.names) == (1e-3, RATE, 2, NAMES)
    assert points.ignored == ("*12",)
    assert points.place[0, 0, 2] == pytest.approx(5.0)


def test_c3d_of_more_frames_than_its_header_can_state(tmp_path, monkeypatch):
    monkeypatch.setattr(point_files, "FRAMES", 66_000)
    points = read_points(saved(tmp_path, "long.c3d", point_files.c3d()))
    assert points.place[:66_000, :, :2] == pytest.approx(swim(), abs=0.01, nan_ok=True)
    assert np.isnan(points.place[66_000:]).all()  # the end of the last block


@pytest.mark.parametrize(("processor", "floats"), [(84, True), (84, False), (85, True), (85, False), (86, True)])
def test_c3d_of_each_processor(processor, floats, tmp_path):
    order, scale = ">" if processor == 86 else "<", -1.0 if floats else 0.5

    def real(values):
        if processor != 85:
            return np.asarray(values, f"{order}f4").tobytes()
        halves = (np.asarray(values, "<f4") * 4).view("<u2").reshape(-1, 2)[:, ::-1]
        return np.ascontiguousarray(halves).tobytes()

    head = bytes([2, 80]) + struct.pack(f"{order}5H", 2, 0, 1, 20, 0) + real([scale])
    head += struct.pack(f"{order}2H", 3, 0) + real([30.0])
    data = np.arange(160.0).reshape(20, 2, 4)
    data[..., 3] = 0
    data[4, 1, 3] = -1
    body = real(data.ravel()) if floats else (data / [0.5, 0.5, 0.5, 1]).astype(f"{order}i2").tobytes()
    parameters = bytes([1, 80, 1, processor])
    content = head.ljust(512, b"\0") + parameters.ljust(512, b"\0") + body
    points = read_points(saved(tmp_path, "old.c3d", content))
    expected = data[..., :3].copy()
    expected[4, 1] = np.nan
    assert points.place == pytest.approx(expected, nan_ok=True)
    assert points.rate == 30.0
    with pytest.raises(InputError, match="must hold the 20 frames that it states, but is only 19"):
        read_points(saved(tmp_path, "cut.c3d", content[:-8]))


def test_the_times_say_which_side_is_of_frames(tmp_path):
    few = np.nan_to_num(swim())[:3].transpose(1, 0, 2)  # 4 frames of 3 points
    arrays = {"x": few[..., 0].T, "y": few[..., 1].T}
    path = saved(tmp_path, "few.mat", point_files._mat(arrays | {"t": np.arange(4.0)}))
    assert read_points(path).place == pytest.approx(few)
    path = saved(
        tmp_path, "few.mat", point_files._mat({key: one.T for key, one in arrays.items()} | {"t": np.arange(3.0)})
    )
    assert read_points(path).place == pytest.approx(few.transpose(1, 0, 2))
    (note,) = read_points(path).notes
    assert note == "the points are those of x and y: 3 frames of 4 points"


def test_variables_of_matlab_are_chosen_by_name(tmp_path):
    from scipy.io import savemat

    place = np.nan_to_num(swim())
    savemat(tmp_path / "two.mat", {"a": place, "b": place.transpose(2, 1, 0) + 5, "t": np.arange(FRAMES) / RATE})
    points = read_points(tmp_path / "two.mat", "b")
    assert points.place == pytest.approx(place + 5)
    assert points.time == pytest.approx(np.arange(FRAMES) / RATE)
    with pytest.raises(InputError, match="must be one of a, b: choose the variable"):
        read_points(tmp_path / "two.mat")


# --- what is refused


def idtracker(folder):
    with h5py.File(folder / "trajectories.h5", "w") as file:
        file["trajectories"] = np.zeros((40, 2, 2))
    return folder / "trajectories.h5"


def labels(folder):
    return saved(folder, "CollectedData.h5", point_files.deeplabcut_fixed(index=np.array(["img"] * FRAMES, "S")))


def nwb(folder):
    with h5py.File(folder / "a.nwb", "w") as file:
        file["processing/behavior/nose/data"] = np.zeros((9, 2))
    return folder / "a.nwb"


def sleap_labels(folder):
    with h5py.File(folder / "labels.h5", "w") as file:
        file["frames"], file["instances"], file["tracks_json"] = [1], [1], ["[]"]
    return folder / "labels.h5"


def some_hdf5(folder):
    with h5py.File(folder / "other.h5", "w") as file:
        file["pressure"] = [1.0]
    return folder / "other.h5"


REFUSED = {
    "idtracker.h5": (idtracker, "is of the form of idtracker.ai, and holds one point of each animal"),
    "labels of pictures": (labels, "holds the labels of single pictures, not a track"),
    "labels of SLEAP": (
        sleap_labels,
        r"is of the form of SLEAP's labels \(.slp\), which are not read: export its analysis",
    ),
    "another HDF5": (
        some_hdf5,
        "must hold tracked points .*, but is an HDF5 file of 'pressure'",
    ),
    "NWB": (nwb, "is of the form of NWB, which is not read: export CSV or HDF5"),
    "idtracker.npy": (
        lambda folder: saved(folder, "t.npy", point_files.npy({"trajectories": 1})),
        "form of an array of NumPy, as idtracker.ai writes it .* one point of each animal",
    ),
    "idtracker.npz": (
        lambda folder: saved(folder, "t.npz", point_files.npz(trajectories=np.zeros((9, 2, 2)))),
        "form of idtracker.ai, and holds one point",
    ),
    "centers of TRex": (
        lambda folder: saved(folder, "t.npz", point_files.npz(X=np.zeros(9), Y=np.zeros(9), missing=np.zeros(9))),
        r"form of TRex, and holds one point .* give the file \*_posture_\*.npz",
    ),
    "another .npz": (lambda folder: saved(folder, "t.npz", point_files.npz(a=np.zeros(9))), "an archive of 'a'"),
    "x and y of centers": (
        lambda folder: saved(folder, "t.mat", point_files._mat({"x": np.zeros(9), "y": np.zeros(9)})),
        "form of MATLAB, and holds one point of each animal",
    ),
    "another .mat": (
        lambda folder: saved(folder, "t.mat", point_files._mat({"q": np.zeros(9)})),
        "must hold variables of points: x and y, points .*, but is a file of MATLAB with 'q': save x and y",
    ),
    "a bag": (
        lambda folder: saved(folder, "t.db3", b"SQLite format 3\0"),
        "import its poses: hypertuna trials import poses",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_holds_no_points_is_refused_by_its_form(name, tmp_path):
    make, words = REFUSED[name]
    with pytest.raises(InputError, match=words):
        read_points(make(tmp_path))


@pytest.mark.parametrize("name", FORMS)
def test_a_file_that_was_cut_short_is_refused(name, tmp_path):
    end, content, _ = FORMS[name]
    whole = content()
    with pytest.raises(InputError, match=r"must be (a whole|valid|an array)|must hold the 40 frames"):
        read_points(saved(tmp_path, f"cut{end}", whole[: len(whole) * 2 // 3]))


# --- HDF5 behind a process


def test_other_files_are_not_read_through_links(tmp_path):
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["tracks"] = np.zeros((1, 2, 2, 40))
    with h5py.File(tmp_path / "linked.h5", "w") as file:
        file["tracks"] = h5py.ExternalLink(str(tmp_path / "secret.h5"), "tracks")
        file["soft"] = h5py.SoftLink("/soft")
        file.create_dataset("raw", (40,), "f8", external=[(str(tmp_path / "secret.h5"), 0, 320)])
        layout = h5py.VirtualLayout((1, 2, 2, 40), float)
        layout[:] = h5py.VirtualSource(str(tmp_path / "secret.h5"), "tracks", (1, 2, 2, 40))
        file.create_virtual_dataset("virtual", layout)
        file["own"] = np.arange(3.0)
    assert set(read_hdf5(tmp_path / "linked.h5").arrays) == {"own"}


def test_an_array_that_is_too_large_is_named_and_not_read(tmp_path):
    with h5py.File(tmp_path / "large.h5", "w") as file:
        file.create_dataset("tracks", (1000, 2, 100, 100_000), "f8", chunks=True, compression="gzip")
        file["node_names"] = [f"{k}" for k in range(100)]
    with pytest.raises(InputError, match="tracks must have at most 12 million numbers, but is more: cut the film"):
        read_points(tmp_path / "large.h5")


def test_names_of_columns_run_nothing(tmp_path):
    class Evil:
        def __reduce__(self):
            return (open, (str(tmp_path / "made"), "w"))

    with h5py.File(saved(tmp_path, "evil.h5", point_files.deeplabcut()), "r+") as file:
        file["df_with_missing/table"].attrs["values_block_0_kind"] = np.bytes_(pickle.dumps([Evil()], 0))
    with pytest.raises(InputError, match="must be a whole table of pandas"):
        read_points(tmp_path / "evil.h5")
    assert not (tmp_path / "made").exists()


def test_a_reader_that_hangs_or_dies_ends_in_a_sentence(tmp_path, monkeypatch):
    path = saved(tmp_path, "any.h5", point_files.sleap())
    monkeypatch.setattr(hdf5, "WAIT", 0.01)
    with pytest.raises(InputError, match="must be a whole HDF5 file"):
        read_hdf5(path)
    monkeypatch.setattr(hdf5, "WAIT", 60.0)
    real = subprocess.run
    dies = [sys.executable, "-c", "import os; os.abort()"]
    monkeypatch.setattr(hdf5.subprocess, "run", lambda command, **options: real(dies, **options))
    with pytest.raises(InputError, match="must be a whole HDF5 file"):
        read_hdf5(path)


def test_a_workbook_needs_its_extra(tmp_path, monkeypatch):
    path = saved(tmp_path, "swim.xlsx", point_files.workbook())
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="openpyxl is needed by workbooks and is not installed: pip install"):
        read_points(path)


def test_of_a_file_of_matlab_a_field_data_is_an_array_and_that_of_a_sparse_matrix_is_not() -> None:
    """The sparse one: 5 in row 0 and 7 in row 2 of three rows and one column."""
    sparse = {"xy/data": np.array([5.0, 7.0]), "xy/ir": np.array([0, 2]), "xy/jc": np.array([0, 2])}
    about = {"xy": {"MATLAB_sparse": 3}}
    arrays = form_hdf5._matlab(hdf5.Hdf5("swim.mat", {"fish/data": np.array([[1.0, 2.0]]), **sparse}, attributes=about))
    assert {name: array.tolist() for name, array in arrays.items()} == {
        "fish.data": [[1.0], [2.0]],
        "xy": [[5.0], [0.0], [7.0]],
    }
