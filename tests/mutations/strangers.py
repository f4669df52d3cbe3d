"""Readers of files that strangers may send, called in this process: each ends in a result or an `InputError`.

A reader has whole files, and damage that knows their structure: checksums are made right again, so that what is wrong
reaches the code behind them. Now and then the path is that of no regular file.
"""

import functools
import json
import os
import random
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import hypertuna as ht
import point_files
from hypertuna.errors import DamageWarning, InputError
from mutations import amplified, forged, forged_points, surfaces, units
from mutations.cases import CALIBRATION, EXAMPLES, MARKERS, PLACES, ROBOTS, ROOT, RUNS, SPRING, TANK, TENSILE, Reaction
from mutations.damage import Damage, of_bytes, of_structure, of_table, of_text
from mutations.judge import CONTROL, LONGEST_ERROR, memory_above, watched
from tracked_files import FILES, TrackedFile, swim

HANGS = 600.0  # s by the clock, of a machine that others use as well
SPECIAL = 0.01  # of the paths are of no regular file


@dataclass(frozen=True)
class Reader:
    """A reader, a whole file of its kind, and the ways to damage it."""

    name: str
    whole: Callable[[], bytes]
    read: Callable[[Path], Any]
    damages: tuple[Damage, ...]
    file: str = "file"  # its name
    every: int = 1
    there: bool = True


def judged(reader: Reader, seed: int, memory: int | None = None) -> Reaction:
    """Damage a file by a seed, read it, maybe with limited memory [bytes], and judge the outcome."""
    chance = random.Random(f"{reader.name} {seed}")
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / reader.file
        if chance.random() < SPECIAL:
            special(path, chance)
        else:
            content = chance.choice(reader.damages)(whole(reader), chance)
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(content)
        with warnings.catch_warnings(action="error"), watched(InputError, hangs=HANGS) as watch:
            warnings.simplefilter("ignore", DamageWarning)
            with memory_above(memory):
                reader.read(path)
        sentence = "" if watch.raised is None else str(watch.raised)
        sign = CONTROL.search(sentence)
        problems = (
            watch.problem,
            f"a sentence of {len(sentence)} characters" if len(sentence) > LONGEST_ERROR else "",
            f"the control character {sign[0]!r} in a sentence" if sign else "",
        )
    accepted = watch.raised is None and not watch.problem
    return Reaction(tuple(filter(None, problems)), accepted, watch.seconds)


@functools.cache
def whole(reader: Reader) -> bytes:
    """Return the whole file of a reader."""
    return reader.whole()


def special(path: Path, chance: random.Random) -> None:
    """Put something at a path that is no regular file."""
    kind = chance.randrange(6)
    path.parent.mkdir(exist_ok=True)
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        path.symlink_to(chance.choice(("/dev/zero", "/dev/urandom", "/dev/full", "/proc/kmsg", "/dev/tty")))
    elif kind == 2:
        path.symlink_to(path)
    elif kind == 3:
        path.mkdir()
    elif kind == 4:
        with path.open("wb") as file:
            file.truncate(1 << 40)  # a hole
    elif kind == 5:
        path.write_bytes(b"x")
        path.chmod(chance.choice((0, 0o200)))


@functools.cache
def tuna() -> ht.Robot:
    """Return the robot that files are read for."""
    return ht.load("hypertuna")


def _robot(path: Path) -> Any:
    robot = ht.load(path)
    return robot.hash, repr(robot)


def _plan(path: Path) -> Any:
    from hypertuna.mission.import_plan import check_plan, plan_document, plan_text, read_plan

    plan = read_plan(path)
    document = plan_document(plan, "plan")
    return plan_text(document, plan, str(path)), check_plan(document, plan, str(path))


def _log(path: Path) -> Any:
    from hypertuna.mission.log_fields import record_columns
    from hypertuna.mission.read_log import read_log
    from hypertuna.reports.studio import robot_and_log

    log = read_log(path)
    robot_and_log(path)
    return log.record.summary(), record_columns(log.record)


def _radio(path: Path) -> Any:
    from hypertuna.io.mcap import is_radio_log
    from hypertuna.radio.log import read_radio_log

    return is_radio_log(path), read_radio_log(path), ht.read_trials(path, tuna())


def _box(path: Path) -> Any:
    from hypertuna.firmware.black_box import mission_record, read_black_box

    return [mission_record(box, tuna()) for box in read_black_box(path)]


def _policy(path: Path) -> Any:
    from hypertuna.learning.policy import read_policy

    return read_policy(path)


def _journal(path: Path) -> Any:
    from hypertuna.io.checkpoint import Journal, read_header

    header = read_header(path)
    with Journal(path, header) as journal:
        return journal.records


def _merged(path: Path) -> Any:
    from hypertuna.parallel.shards import open_shards, write_merged

    forged.unpack(path)
    for name in ("out.csv", "out.nc"):
        write_merged(open_shards(path.parent), path.parent.parent / name, lambda *_: None)
    return ht.merge_shards(path.parent)


def _swimmer(path: Path) -> Any:
    from hypertuna.scoreboard.swimmers import read_swimmer

    return read_swimmer(path)


def _surface(path: Path) -> Any:
    from hypertuna.fe.fields import read_surface

    return read_surface(path)


def _table(module: str, name: str, *arguments: Any, **options: Any) -> Callable[[Path], Any]:
    """Return the call of a reader of tables, with the robot in place of ROBOT."""

    def read(path: Path) -> Any:
        function = getattr(__import__(f"hypertuna.{module}", fromlist=[name]), name)
        return function(path, *(tuna() if one == "ROBOT" else one for one in arguments), **options)

    return read


def _markers(path: Path) -> Any:
    from hypertuna.trials.markers import read_markers

    return read_markers(path, scale=1e-3, frame_rate=30.0)


def _points(path: Path) -> Any:
    from hypertuna.trials.forms import read_points

    return read_points(path)


def _poses(path: Path) -> Any:
    from hypertuna.trials.pose_import import read_pose_run

    return read_pose_run(tuna(), path)


def _camera(path: Path) -> Any:
    from hypertuna.film.camera import read_camera

    return read_camera(path).sight([1.0, 2.0], 0.1)


def _sections(path: Path) -> Any:
    from hypertuna.film.sections import body_of

    return body_of(ht.load(EXAMPLES / "minnow.toml"), path)


def _film(path: Path) -> Any:
    from hypertuna.film.source import open_film

    film = open_film(path)
    read = film.frames(8), film.colors(9)
    return film.sample(5).mean(), [sum(int(frame.sum()) for _, frame in one) for one in read]


def _places(path: Path) -> Any:
    from hypertuna.trials.marker_places import read_places

    return read_places(path, ht.load("rexeel"), [f"{k + 1}" for k in range(12)])


def _manifest(path: Path) -> Any:
    for file in TANK.glob("*.csv"):
        (path.parent / file.name).write_bytes(file.read_bytes())
    return ht.read_trials(path, tuna())


def _runs(path: Path) -> Any:
    return ht.read_trials(path, tuna())


def _scheduler(path: Path) -> Any:
    from hypertuna.parallel.executors import cluster

    with cluster(str(path)):
        pass


TEXTS = (of_text, of_structure)
TOMLS = (*TEXTS, amplified.of_toml)
TABLES = (of_table, of_structure, amplified.of_table)
LOGS = (forged.of_log, forged.of_log, forged.of_log, of_bytes)


# Binary forms of points: whole files, and the damage that knows each.
POINTS: dict[str, tuple[str, Callable[[], bytes], tuple[Damage, ...]]] = {
    "points of DeepLabCut": ("p.h5", point_files.deeplabcut, (forged_points.of_hdf5, amplified.of_hdf5)),
    "points of DeepLabCut, fixed": ("p.h5", point_files.deeplabcut_fixed, (forged_points.of_hdf5, amplified.of_hdf5)),
    "points of SLEAP": ("p.h5", point_files.sleap, (forged_points.of_hdf5, amplified.of_hdf5)),
    "points of MATLAB 7.3": ("p.mat", point_files.matlab73, (of_bytes, amplified.of_hdf5)),
    "points of MATLAB": ("p.mat", point_files.matlab, (forged_points.of_matlab, amplified.of_matlab)),
    "points of DLTdv": ("p.mat", point_files.dltdv, (forged_points.of_matlab, amplified.of_matlab)),
    "points of TRex": ("p.npz", point_files.trex, (forged.of_npz, amplified.of_npz)),
    "midlines of TRex": ("p.npz", point_files.trex_midlines, (forged.of_npz, amplified.of_npz)),
    "points in C3D": ("p.c3d", point_files.c3d, (forged_points.of_c3d, amplified.of_c3d)),
    "workbook": ("p.xlsx", point_files.workbook, (forged_points.of_workbook, amplified.of_workbook)),
}


def _bag(form: str) -> Callable[[], bytes]:
    return lambda: point_files.bag(form, kinds=("Odometry", "JointState"), count=40)


def _text(path: Path) -> Callable[[], bytes]:
    return path.read_bytes


def _toml(name: str, path: Path, read: Callable[[Path], Any]) -> Reader:
    return Reader(name, path.read_bytes, read, TOMLS, f"{name.replace(' ', '-')}.toml")


FORMS = (
    *("semicolons and decimal commas", "UTF-16", "labels of DeepLabCut", "Anipose", "DLTdv, two cameras", "TRex"),
    *("Motive", "Qualisys", "Vicon", "TRC", "EthoVision", "rows of two animals", "LabVIEW", "DLTdv 8, sparse"),
    *("JSON of columns by frame", "JSON of points", "DeepLabCut's SuperAnimal", "COCO", "AlphaPose", "MMPose"),
)


def _tracked(file: TrackedFile) -> Reader:
    """Return the reader of a form of tracked points."""
    from hypertuna.trials.markers import read_markers

    text = file.text(swim())
    content = text if isinstance(text, bytes) else text.encode()
    return Reader(
        f"markers, {file.name}",
        content.strip,
        lambda path: read_markers(path, **file.options),
        TEXTS if file.suffix == ".json" else TABLES,
        f"file{file.suffix}",
    )


READERS = (
    _toml("robot", ROBOTS / "hypertuna.toml", _robot),
    _toml("small robot", EXAMPLES / "myfish.toml", _robot),
    _toml("mission", ROOT / "missions/lake.toml", ht.read_mission),
    _toml("manifest", TANK / "tank.toml", _manifest),
    _toml("swimmer", ROOT / "data/swimmers/bistable-swimmer.toml", _swimmer),
    *(
        Reader(f"plan {form}", text.encode().strip, _plan, (*TEXTS, forged.of_xml) if text[0] == "<" else TEXTS)
        for form, text in forged.PLANS.items()
    ),
    Reader(
        "steady runs",
        RUNS.encode().strip,
        _table("trials.steady", "read_steady", ht.load(EXAMPLES / "minnow.toml")),
        TABLES,
        "file.csv",
    ),
    *(
        Reader(f"runs of {name}", _text(TANK / f"{name}.csv"), _runs, TABLES, "file.csv")
        for name in ("tow", "thrust", "power", "turn", "glide", "yaw")
    ),
    Reader("markers", MARKERS.encode().strip, _markers, TABLES, "file.csv"),
    Reader("markers of DeepLabCut", forged.DEEPLABCUT.encode().strip, _markers, TABLES, "file.csv"),
    Reader("markers of SLEAP", forged.SLEAP.encode().strip, _markers, TABLES, "file.csv"),
    *(Reader(name, make, _points, damages, file) for name, (file, make, damages) in POINTS.items()),
    Reader("bag", _bag("db3"), _poses, (forged_points.of_database, amplified.of_database), "bag.db3"),
    Reader("bag in MCAP", _bag("mcap"), _poses, LOGS, "bag.mcap"),
    Reader("poses in a table", point_files.pose_table, _poses, TABLES, "poses.csv"),
    *(_tracked(file) for file in FILES if file.name in FORMS),
    Reader("places", PLACES.encode().strip, _places, TABLES, "file.csv"),
    Reader("camera", forged.CAMERA.encode().strip, _camera, TEXTS, "camera.toml"),
    Reader("sections", forged.SECTIONS.encode().strip, _sections, TABLES, "file.csv"),
    Reader("corners", forged.CORNERS.encode().strip, _table("film.calibrate", "read_corners"), TABLES, "file.csv"),
    Reader("blinks", forged.BLINKS.encode().strip, _table("film.blinks", "read_blinks"), TABLES, "file.csv"),
    Reader("film", forged.film, _film, (of_bytes,), "film.mp4"),
    Reader(
        "bench", _text(EXAMPLES / "bench/bench.csv"), _table("characterization.data", "read_bench", "ROBOT"), TABLES
    ),
    Reader("spring test", SPRING.encode().strip, _table("characterization.spring", "read_spring"), TABLES, "file.csv"),
    Reader("tensile test", TENSILE.encode().strip, _table("actuation.silicone", "read_tensile"), TABLES, "file.csv"),
    Reader("calibration", CALIBRATION.encode().strip, _table("radio.calibration", "read_pairs"), TABLES, "file.csv"),
    Reader("log", forged.log, _log, LOGS, "log.mcap"),
    Reader("radio log", forged.radio_log, _radio, LOGS, "log.mcap"),
    Reader("black box", forged.box, _box, (of_bytes, forged.of_box), "box.bin"),
    Reader(
        "policy",
        _text(EXAMPLES / "learning/goto.npz"),
        _policy,
        (of_bytes, forged.of_npz, amplified.of_npz),
        "policy.npz",
    ),
    Reader("shards", forged.shards, _merged, (forged.of_shards, forged.of_shards, of_bytes), "a.shards/packed"),
    Reader("journal", forged.journal, _journal, (forged.of_journal, of_text), "j.jsonl"),
    Reader("surface", surfaces.surface, _surface, (surfaces.of_surface,), "surface-000.vtu"),
    Reader(
        "FMU",
        lambda: units.resources()[0],
        units.read_unit,
        (units.of_list, units.of_list, of_text),
        "variables",
        there=units.BINARY.exists(),
    ),
    Reader("scheduler file", json.dumps({"address": "tcp://127.0.0.1:1"}).encode().strip, _scheduler, (of_structure,)),
)
