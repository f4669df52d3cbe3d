"""Tracked points in binary files, as other programs write them: one swim in every form."""

import io
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

NAMES = ("nose", "neck", "back", "tail")
FRAMES, RATE = 40, 60.0
HIDDEN = (7, 2)  # frame and point that is missing


def swim():
    """Places (frames, points, 2) of a swim; one of them is missing."""
    time, along = np.arange(FRAMES)[:, np.newaxis] / RATE, np.arange(len(NAMES)) * 40.0
    place = np.stack([300 + 90 * time + along, 200 + 8 * np.sin(9 * time - along / 40)], axis=-1)
    place[HIDDEN] = np.nan
    return place


def scores():
    """Likelihoods (frames, points)."""
    return np.where(np.isnan(swim()[..., 0]), np.nan, 0.75)


def _hdf5(write: Callable) -> bytes:
    import h5py

    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        write(file)
    return content.getvalue()


def _table(animals=("",)):
    """Columns and numbers of a table of DeepLabCut; other animals are elsewhere."""
    columns, values = [], []
    for a, animal in enumerate(animals):
        for k, name in enumerate(NAMES):
            own = [swim()[:, k, 0] + 1000 * a, swim()[:, k, 1], scores()[:, k]]
            columns += [("net", *filter(None, [animal]), name, axis) for axis in ("x", "y", "likelihood")]
            values += own
    return columns, np.stack(values, axis=1)


def deeplabcut(animals=("",)) -> bytes:
    """DeepLabCut's file, pandas' format `table`, laid out as PyTables does."""

    def write(file):
        columns, values = _table(animals)
        group = file.create_group("df_with_missing")
        group.attrs["pandas_type"] = np.bytes_("frame_table")
        kind = np.dtype([("index", "<i8"), ("values_block_0", "<f8", (len(columns),))])
        rows = np.zeros(FRAMES, kind)
        rows["index"], rows["values_block_0"] = np.arange(FRAMES), values
        table = group.create_dataset("table", data=rows, chunks=(16,), maxshape=(None,))
        table.attrs["values_block_0_kind"] = np.bytes_(pickle.dumps(columns, 0))

    return _hdf5(write)


def deeplabcut_fixed(animals=("",), index=None) -> bytes:
    """DeepLabCut's table in pandas' format `fixed`."""

    def write(file):
        columns, values = _table(animals)
        group = file.create_group("df_with_missing")
        group.attrs["pandas_type"] = np.bytes_("frame")
        group["block0_values"], group["axis1"] = values, np.arange(FRAMES) if index is None else index
        for k, level in enumerate(zip(*columns, strict=True)):
            names = sorted(set(level))
            group[f"block0_items_level{k}"] = np.array(names, "S")
            group[f"block0_items_label{k}"] = np.array([names.index(one) for one in level], "i1")

    return _hdf5(write)


def sleap(tracks=1, *, standard=False, overlap=False) -> bytes:
    """SLEAP's analysis; the animal changes its track at half of the frames, or all tracks are there always."""

    def write(file):
        place = np.full((tracks, FRAMES, len(NAMES), 2), np.nan)
        score = np.full(place.shape[:3], np.nan)
        for k in range(tracks):
            own = slice(None) if overlap else slice(k * FRAMES // tracks, (k + 1) * FRAMES // tracks)
            place[k, own], score[k, own] = swim()[own] + [1000 * k * overlap, 0], scores()[own]
        order, of_scores = ((1, 0, 2, 3), (1, 0, 2)) if standard else ((0, 3, 2, 1), (0, 2, 1))
        file.create_dataset("tracks", data=place.transpose(order), compression="gzip", compression_opts=9)
        file.create_dataset("point_scores", data=score.transpose(of_scores), compression="gzip")
        file["track_occupancy"] = np.isfinite(place).any(axis=(2, 3)).T
        file["node_names"], file["track_names"] = list(NAMES), [f"fish_{k}" for k in range(tracks)]

    return _hdf5(write)


def matlab73() -> bytes:
    """MATLAB's file of version 7.3: HDF5 behind a block of text, with the dimensions the other way round."""

    def write(file):
        for name, array in {"x": swim()[..., 0], "y": swim()[..., 1], "fps": np.array([[RATE]])}.items():
            file[name] = array.T
            file[name].attrs["MATLAB_class"] = np.bytes_("double")

    import h5py

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made.mat"
        with h5py.File(path, "w", userblock_size=512) as file:
            write(file)
        content = path.read_bytes()
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM"
    return text + content[len(text) :]


def matlab(**options) -> bytes:
    """MATLAB's file of version 5: variables x, y, fps, beside others."""
    others = {"names": np.array(NAMES, object), "about": {"lens": np.eye(3), "by": "lab"}, "fps": RATE}
    return _mat({"x": swim()[..., 0], "y": swim()[..., 1], **others}, **options)


def dltdv() -> bytes:
    """A project of DLTdv: points in a sparse array, nothing where none was set."""
    from scipy.sparse import csc_matrix

    flat = np.nan_to_num(swim().reshape(FRAMES, -1))
    return _mat({"udExport": {"data": {"xypts": csc_matrix(flat), "nFrames": FRAMES}}})


def qualisys() -> bytes:
    """An export of Qualisys: markers, x, y, z and a residual, frames; beside settings."""
    place = np.concatenate([swim(), np.zeros((FRAMES, len(NAMES), 2))], axis=2)
    labeled = {"Count": len(NAMES), "Labels": np.array(NAMES, object), "Data": place.transpose(1, 2, 0)}
    return _mat({"run": {"StartFrame": 20, "FrameRate": RATE, "Trajectories": {"Labeled": labeled}}})


def _mat(arrays, **options) -> bytes:
    from scipy.io import savemat

    content = io.BytesIO()
    savemat(content, arrays, **options)
    return content.getvalue()


def trex() -> bytes:
    """TRex's poses [px]: infinite where they are missing."""
    place = np.where(np.isnan(swim()), np.inf, swim())
    poses = {f"pose{axis}{k}": place[:, k, a] for k in range(len(NAMES)) for a, axis in enumerate("XY")}
    return npz(frame=np.arange(FRAMES), time=np.arange(FRAMES) / RATE, frame_rate=np.array([RATE]), **poses)


def trex_midlines() -> bytes:
    """TRex's midlines: points at equal steps, another number in each frame."""
    lines = []
    for k in range(FRAMES):
        x = np.linspace(0, 120, 9 + k % 3)
        lines.append(np.column_stack([300 + 90 * k / RATE + x, np.full(len(x), 200.0)]))
    lengths = np.array([len(line) for line in lines], "u8")
    return npz(frames=np.arange(FRAMES), midline_lengths=lengths, midline_points=np.concatenate(lines))


def npz(**arrays) -> bytes:
    """An archive of NumPy."""
    content = io.BytesIO()
    np.savez(content, **arrays)
    return content.getvalue()


def c3d() -> bytes:
    """A C3D file: x, y, z [mm], z up, and a point without a name."""
    import ezc3d

    made, place = ezc3d.c3d(), np.full((4, len(NAMES) + 1, FRAMES), 5.0)
    place[:2, :-1] = swim().transpose(2, 1, 0)
    place[:3, HIDDEN[1], HIDDEN[0]] = np.nan
    points = made["parameters"]["POINT"]
    points["UNITS"]["value"], points["RATE"]["value"], points["LABELS"]["value"] = ["mm"], [RATE], [*NAMES, "*12"]
    made.add_parameter("POINT", "Y_SCREEN", ["+Z"])
    made["data"]["points"] = place
    return _written("made.c3d", lambda path: made.write(str(path)))


def workbook() -> bytes:
    """A workbook with a sheet of notes, and one of plain columns."""
    from openpyxl import Workbook

    book = Workbook()
    book.active.append(["notes"])
    sheet = book.create_sheet("points")
    sheet.append(["time_s", *(f"{name}_{axis}" for name in NAMES for axis in "xy")])
    for k, row in enumerate(swim().reshape(FRAMES, -1).tolist()):
        sheet.append([k / RATE, *(None if np.isnan(value) else value for value in row)])
    content = io.BytesIO()
    book.save(content)
    return content.getvalue()


def _written(name: str, write: Callable) -> bytes:
    """What is written to a path."""
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / name)
        return (Path(folder) / name).read_bytes()


START, EACH = 1_700_000_000_000_000_000, 10_000_000  # ns: first time of a bag, and the time between its messages
PLACE, YAW = (0.1, 0.5, 0.1), 3.0  # first pose [m, rad]


def bag(form="db3", *, kinds=("Odometry", "TFMessage", "PoseStamped", "JointState"), stamped=True, count=120) -> bytes:
    """A bag of ROS 2: a robot that drifts and turns counter-clockwise, z up, through yaw = pi."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    of = {name.rpartition("/")[2]: kind for name, kind in store.types.items() if not name.startswith("action")}
    full = {name.rpartition("/")[2]: name for name in store.types}

    def header(time, frame):
        time = time if stamped else 0
        return of["Header"](stamp=of["Time"](sec=time // 10**9, nanosec=time % 10**9), frame_id=frame)

    def messages(k):
        time, (x, y, yaw) = START + k * EACH, pose_of_bag(k)
        turn = of["Quaternion"](x=0.0, y=0.0, z=float(np.sin(yaw / 2)), w=float(np.cos(yaw / 2)))
        pose = of["Pose"](position=of["Point"](x=x, y=y, z=PLACE[2]), orientation=turn)
        zero = of["Vector3"](x=0.0, y=0.0, z=0.0)
        twist = of["TwistWithCovariance"](twist=of["Twist"](linear=zero, angular=zero), covariance=np.zeros(36))
        known = of["PoseWithCovariance"](pose=pose, covariance=np.zeros(36))
        moved = of["Transform"](translation=of["Vector3"](x=x, y=y, z=0.0), rotation=turn)
        head = header(time, "tank")
        yield "/odom", "Odometry", of["Odometry"](header=head, child_frame_id="base", pose=known, twist=twist)
        frame = of["TransformStamped"](header=head, child_frame_id="head", transform=moved)
        yield "/tf", "TFMessage", of["TFMessage"](transforms=[frame])
        yield "/pose", "PoseStamped", of["PoseStamped"](header=head, pose=pose)
        angle = np.array(angles_of_bag(k))
        empty = np.zeros(0)
        yield "/joints", "JointState", of["JointState"](head, ["front", "rear"], angle, empty, empty)

    with tempfile.TemporaryDirectory() as folder:
        place, connections = Path(folder) / "bag", {}
        storage = StoragePlugin.MCAP if form == "mcap" else StoragePlugin.SQLITE3
        with Writer(place, version=9, storage_plugin=storage) as writer:
            for k in range(count):
                for topic, kind, message in messages(k):
                    if kind in kinds:
                        if topic not in connections:
                            connections[topic] = writer.add_connection(topic, full[kind], typestore=store)
                        content = store.serialize_cdr(message, full[kind])
                        writer.write(connections[topic], START + k * EACH + 700, bytes(content))
        return (place / f"bag.{form}").read_bytes()


def npy(content: Any = None) -> bytes:
    """Places (frames, points, 2), or other content, in one array."""
    stream = io.BytesIO()
    np.save(stream, swim() if content is None else content)
    return stream.getvalue()


def plain_hdf5() -> bytes:
    """Places and times, as h5py writes arrays."""

    def write(file):
        file["x"], file["y"], file["time_s"] = swim()[..., 0], swim()[..., 1], np.arange(FRAMES) / RATE

    return _hdf5(write)


def pose_table() -> bytes:
    """A table of poses with quaternions, as simulators write it."""
    lines = ["time_s,x,y,z,qw,qx,qy,qz,hip_deg"]
    for k in range(40):
        x, y, yaw = pose_of_bag(k)
        turn = f"{np.cos(yaw / 2):.9f},0,0,{np.sin(yaw / 2):.9f}"
        lines.append(f"{0.01 * k:.2f},{x:.6f},{y:.6f},0.1,{turn},{np.degrees(angles_of_bag(k)[0]):.6f}")
    return "\n".join([*lines, ""]).encode()


def pose_of_bag(k):
    """x, y [m] and yaw [rad] of a message."""
    return PLACE[0] + 0.002 * k, PLACE[1] - 0.001 * k, YAW + 0.01 * k


def angles_of_bag(k):
    """Angles of the joints of a message [rad]."""
    return 0.2 * float(np.sin(0.3 * k)), 0.3 * float(np.sin(0.3 * k - 0.5))


# Each form: the end of its name, its content, its name in sentences. All hold the points of `swim`.
FORMS: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "DeepLabCut, table": (".h5", deeplabcut, "DeepLabCut"),
    "DeepLabCut, fixed": (".h5", deeplabcut_fixed, "DeepLabCut"),
    "SLEAP": (".h5", sleap, "SLEAP"),
    "HDF5 of arrays": (".h5", plain_hdf5, "HDF5"),
    "NumPy": (".npy", npy, "NumPy"),
    "NumPy, several": (".npz", lambda: npz(x=swim()[..., 0], y=swim()[..., 1], fps=np.array(RATE)), "NumPy"),
    "SLEAP, tracks that follow each other": (".analysis.h5", lambda: sleap(3), "SLEAP"),
    "SLEAP, preset standard": (".h5", lambda: sleap(2, standard=True), "SLEAP"),
    "MATLAB": (".mat", matlab, "MATLAB"),
    "MATLAB, compressed": (".mat", lambda: matlab(do_compression=True), "MATLAB"),
    "MATLAB 7.3": (".mat", matlab73, "MATLAB 7.3"),
    "DLTdv": (".mat", dltdv, "DLTdv"),
    "Qualisys, MATLAB": (".mat", qualisys, "Qualisys"),
    "TRex": (".npz", trex, "TRex"),
    "C3D": (".c3d", c3d, "C3D"),
    "workbook": (".xlsx", workbook, "plain columns"),
}
