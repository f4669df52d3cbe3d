"""Poses of other programs: bags of ROS 2, tables with quaternions; frames, clocks, what is missing."""

import json
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
import point_files
from hypertuna.cli.main import app
from hypertuna.errors import InputError
from hypertuna.trials.pose_import import DIRECTIONS, View, _axis, _seen_from_above, read_pose_run
from point_files import EACH, angles_of_bag, bag, pose_of_bag

FISH = ht.load("hypertuna")


def saved(folder: Path, name: str, content: bytes) -> Path:
    """A file of that content."""
    (folder / name).write_bytes(content)
    return folder / name


def expected(count=120):
    """Poses (frames, 3) of the bag."""
    return np.array([pose_of_bag(k) for k in range(count)])


@pytest.mark.parametrize("form", ["db3", "mcap"])
@pytest.mark.parametrize("topic", ["/odom", "/tf:head", "/pose"])
def test_poses_and_joints_of_a_bag(form, topic, tmp_path):
    run = read_pose_run(FISH, saved(tmp_path, f"run.{form}", bag(form)), topic=topic)
    assert run.pose == pytest.approx(expected())
    assert run.time == pytest.approx(np.arange(120) * EACH / 1e9)
    assert run.angle == pytest.approx(np.array([angles_of_bag(k) for k in range(120)]))
    assert run.joint_names == ("front", "rear")


def test_poses_in_json(tmp_path):
    from mcap.writer import Writer

    with (tmp_path / "run.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        schemas = [writer.register_schema(f"foxglove.{name}", "jsonschema", b"{}") for name in ("PoseInFrame", "Log")]
        topics = [
            writer.register_channel(name, "json", own) for name, own in zip(("/pose", "/log"), schemas, strict=True)
        ]
        for k, (x, y, yaw) in enumerate(expected(20)):
            turn = {"x": 0, "y": 0, "z": np.sin(yaw / 2), "w": np.cos(yaw / 2)}
            pose = {"position": {"x": x, "y": y, "z": 0}, "orientation": turn}
            message = {"timestamp": {"sec": 5, "nsec": k * EACH}, "frame_id": "tank", "pose": pose}
            writer.add_message(topics[0], k * EACH, json.dumps(message).encode(), k * EACH)
            writer.add_message(topics[1], k * EACH, b"{}", k * EACH)
        writer.finish()
    run = read_pose_run(FISH, tmp_path / "run.mcap")
    assert run.pose == pytest.approx(expected(20))
    assert run.time == pytest.approx(np.arange(20) * EACH / 1e9)


def test_a_folder_is_a_bag(tmp_path):
    (tmp_path / "run").mkdir()
    saved(tmp_path / "run", "run_0.mcap", bag("mcap", kinds=("PoseStamped",)))
    assert read_pose_run(FISH, tmp_path / "run").name == "run"
    saved(tmp_path / "run", "run_1.mcap", b"")
    with pytest.raises(InputError, match="must hold one .mcap or .db3 file, but is 2 of them"):
        read_pose_run(FISH, tmp_path / "run")


def test_headers_without_times_are_told(tmp_path):
    path = saved(tmp_path, "run.db3", bag(kinds=("Odometry", "JointState"), stamped=False))
    run = read_pose_run(FISH, path)
    assert run.time == pytest.approx(np.arange(120) * EACH / 1e9)
    assert "headers without times: the times are those of the recording" in run.notes


def test_a_bag_that_was_cut_short_is_told(tmp_path):
    content = bag("mcap", kinds=("PoseStamped",), count=20_000)
    run = read_pose_run(FISH, saved(tmp_path, "cut.mcap", content[: len(content) * 2 // 3]))
    assert 1000 < len(run.time) < 20_000
    assert run.notes[-1].startswith("the bag is cut short")


def test_joints_are_named_from_head_to_tail(tmp_path):
    path = saved(tmp_path, "run.db3", bag(kinds=("Odometry", "JointState")))
    run = read_pose_run(FISH, path, joints=["rear", "front"])
    assert run.angle[3] == pytest.approx(angles_of_bag(3)[::-1])
    with pytest.raises(InputError, match=r"--joints must be 2, one per joint group of hypertuna \(I, II\), but is 1"):
        read_pose_run(FISH, path, joints=["rear"])
    with pytest.raises(InputError, match="--joints must be a joint of the file, but is 'reer': did you mean rear"):
        read_pose_run(FISH, path, joints=["reer", "front"])
    with pytest.raises(InputError, match="must be 5, one per joint group of rexeel"):
        read_pose_run(ht.load("rexeel"), path)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("old.bag", b"#ROSBAG V2.0\n", "but is a bag of ROS 1: convert it: rosbags-convert"),
        ("run.db3.zst", b"\x28\xb5\x2f\xfd1234", "but is a compressed file: give a .mcap or .db3 file, unpacked"),
        ("run.db3", b"SQLite format 3\0" + bytes(100), "must be a whole bag of ROS 2|must have tables"),
        (
            "run.db3",
            bag(kinds=("JointState",)),
            r"must hold poses over time, but is '/joints \(sensor_msgs/JointState\)'",
        ),
        ("run.db3", bag(count=3, kinds=("Odometry",)), "must hold at least 12 poses, but is 3 of /odom"),
        ("run.db3", bag(), "--topic must be one of /odom, /tf:head, /pose: choose the poses of the robot's head"),
    ],
)
def test_what_holds_no_poses_is_refused(name, content, words, tmp_path):
    with pytest.raises(InputError, match=words):
        read_pose_run(FISH, saved(tmp_path, name, content))


def test_a_table_of_another_simulator(tmp_path):
    run = read_pose_run(FISH, saved(tmp_path, "run.csv", point_files.pose_table()))
    assert run.pose == pytest.approx(expected(40), abs=1e-6)
    assert run.angle is None
    few = "time_s,x,y,z,qw,qx,qy,qz,a_deg,b\n" + "".join(f"{k / 10},0,0,0,1,0,0,0,{k},0.1\n" for k in range(20))
    run = read_pose_run(FISH, saved(tmp_path, "two.csv", few.encode()), joints=["a_deg", "b"])
    assert run.angle[9] == pytest.approx([np.radians(9), 0.1])
    with pytest.raises(InputError, match="must have columns of time_s, x, y, z, qx, .* but is without qx, qy, qz, qw"):
        read_pose_run(FISH, saved(tmp_path, "yaw.csv", b"time_s,x,y,z,yaw\n1,2,3,4,5\n2,2,3,4,5\n"))


@pytest.mark.parametrize(("up", "forward"), [p for p in product(DIRECTIONS, DIRECTIONS) if p[0][-1] != p[1][-1]])
def test_any_axis_may_point_up_and_forward(up, forward):
    """A body that turns by 90 deg about what points up, counter-clockwise from above, turns its yaw by as much."""
    axis = _axis(up)
    turns = np.array([[*(np.sin(a / 2) * axis), np.cos(a / 2)] for a in (0.0, np.pi / 2)])
    place = np.array([[0.0, 0, 0], _axis(forward)])  # moves the way that it faced
    pose = _seen_from_above("file", "topic", place, turns, View(up, forward, ahead=0.0))
    assert pose[1, 2] - pose[0, 2] == pytest.approx(np.pi / 2)
    assert pose[1, :2] == pytest.approx([np.cos(pose[0, 2]), np.sin(pose[0, 2])], abs=1e-12)
    ahead = _seen_from_above("file", "topic", place, turns, View(up, forward, ahead=0.2))
    assert ahead[0, :2] == pytest.approx(0.2 * pose[1, :2], abs=1e-12)


def test_a_nose_that_points_up_is_refused(tmp_path):
    path = saved(tmp_path, "run.db3", bag(kinds=("Odometry",)))
    with pytest.raises(InputError, match="--forward or --up must lie flat, but is z of the body, which points up"):
        read_pose_run(FISH, path, view=View("z", "z"))


def test_a_direction_without_a_length_is_refused():
    with pytest.raises(InputError, match=r"pose 1 of /odom must be a place and a unit quaternion"):
        _seen_from_above("file", "/odom", np.zeros((2, 3)), np.zeros((2, 4)), View())


TABLE = "{},x,y,z,qw,qx,qy,qz,j1,j2,{}\n"


def table(tmp_path, times, head="time_s", scale=1.0, angle=0.2, more=("more", 0.0)):
    """A table of a body that swims by 0.1 m a second, at times [s]; more: name of a column, and its number per s."""
    rows = [f"{t:.7g},{scale * 0.1 * t:.7g},0,0,1,0,0,0,{angle},{-angle},{more[1] * t:.7g}\n" for t in times]
    return saved(tmp_path, "run.csv", (TABLE.format(head, more[0]) + "".join(rows)).encode())


TIMES = np.arange(30) / 50


def test_a_repeated_time_is_told(tmp_path):
    run = read_pose_run(FISH, table(tmp_path, [*TIMES[:9], *TIMES[8:]]))
    assert run.time == pytest.approx(TIMES)
    assert run.notes == ("1 rows at the time of another are left out",)


def test_a_clock_says_its_unit(tmp_path):
    assert read_pose_run(FISH, table(tmp_path, 1000 * TIMES, "t_ms", 1e-3)).time == pytest.approx(TIMES)
    run = read_pose_run(FISH, table(tmp_path, 1000 * TIMES, "timestamp", 1e-3))
    assert run.time == pytest.approx(TIMES)
    assert run.notes == ("column timestamp is taken in ms, which gives 50 frames per second, 0.58 s in all",)
    with pytest.raises(InputError, match="must have a column of time, but is missing: give --frame-rate in Hz"):
        read_pose_run(FISH, table(tmp_path, range(30), "frame"))
    assert read_pose_run(FISH, table(tmp_path, range(30), "frame", 0.01), frame_rate=50).time == pytest.approx(TIMES)


def test_a_table_says_the_units_of_places_and_angles(tmp_path):
    """Separators and signs of decimals are those of tables of markers, too."""
    text = table(tmp_path, TIMES, "Time [s]", 1000, 10).read_text().replace(",", ";").replace(".", ",")
    names = {";x;y;z": ";x (mm);y (mm);z (mm)", ";j1;j2": ";j1 [deg];j2_degrees"}
    for old, new in names.items():
        text = text.replace(old, new)
    run = read_pose_run(FISH, saved(tmp_path, "run.csv", text.encode()), joints=["j1 [deg]", "j2_degrees"])
    assert run.pose[-1, :2] == pytest.approx([0.058, 0])
    assert run.angle[-1] == pytest.approx(np.radians([10, -10]))


def test_unlikely_poses_are_told(tmp_path):
    head, *rows = (line.split(",") for line in table(tmp_path, TIMES).read_text().splitlines())
    held = TIMES[np.arange(30) // 3 * 3]
    x = -0.1 * held - 0.005 * np.sin(20 * held)
    lines = [",".join([row[0], f"{at:.9f}", *row[2:]]) for row, at in zip(rows, x, strict=True)]
    run = read_pose_run(FISH, saved(tmp_path, "run.csv", "\n".join([",".join(head), *lines]).encode()))
    assert run.notes[0].startswith("8 poses repeat the one before")
    assert run.notes[1].startswith("the robot moves tail first all the time: does --forward")
    run = read_pose_run(FISH, table(tmp_path, TIMES), view=View(forward="y"))
    assert run.notes == ("the robot moves to its side all the time: does --forward name the axis to the nose?",)


@pytest.mark.parametrize(
    ("words", "given"),
    [
        ("the rate by time_s must be from 5 to 2000 Hz, but is 0.05: in ms", {"times": 1000 * TIMES}),
        ("line 32, time_s must be later than .* 0.58, but is 0.004: it starts", {"times": [*TIMES, *TIMES + 0.004]}),
        ("line 3, time_s must be later than .*: they run backward", {"times": TIMES[::-1]}),
        ("the columns time_s and sim_time must agree, but is .* 1.16 s", {"times": TIMES, "more": ("sim_time", 2.0)}),
        (
            "column x must be there once, but is x, target_position_x",
            {"times": TIMES, "more": ("target_position_x", 0)},
        ),
        ("j1 must say its unit in its name, but is 3 rad: are they in deg", {"times": TIMES, "angle": 3}),
        ("less than 20 lengths a second, .*: are they in mm or cm", {"times": TIMES, "scale": 1000}),
        ("less than 20 lengths a second, .*: are they in mm.$", {"times": TIMES, "scale": 30000}),
        (
            "j1 must bend by less than half a turn, but is 20 rad: are they in deg. Then call it j1_deg",
            {"times": TIMES, "angle": 20},
        ),
    ],
)
def test_a_table_in_other_units_is_refused(words, given, tmp_path):
    with pytest.raises(InputError, match=words):
        read_pose_run(FISH, table(tmp_path, **given), joints=["j1", "j2"])


def test_the_command_writes_what_replay_reads(tmp_path):
    path = saved(tmp_path, "run.mcap", bag("mcap", kinds=("Odometry", "JointState")))
    done = CliRunner().invoke(app, ["trials", "import", "poses", str(path), "-o", str(tmp_path / "out.toml"), "--json"])
    result = json.loads(done.output)
    assert (done.exit_code, result["runs"][0]["joints"], result["runs"][0]["missing"]) == (0, ["front", "rear"], [])
    recording = ht.read_trials(tmp_path / "out.toml", FISH).recordings[0]
    assert recording.joints.angle[5] == pytest.approx(angles_of_bag(5))
    assert recording.tracks[0].pose[-1] == pytest.approx([*expected()[-1]])


def test_missing_joints_are_told(tmp_path):
    path = saved(tmp_path, "run.db3", bag(kinds=("Odometry",)))
    done = CliRunner().invoke(app, ["trials", "import", "poses", str(path), "-o", str(tmp_path / "out.toml")])
    assert "missing: joint angles: the file has none. Name a CSV file of them" in " ".join(done.output.split())
    with pytest.raises(InputError, match=r"recordings\[0\].joints"):
        ht.read_trials(tmp_path / "out.toml", FISH)


def tum(start: float = 1764187812.0) -> list[str]:
    """Lines of TUM: time, place, quaternion."""
    return [
        f"{start + k * EACH / 1e9:.6f} {x:.9f} {y:.9f} 0 0 0 {np.sin(yaw / 2):.9f} {np.cos(yaw / 2):.9f}"
        for k, (x, y, yaw) in enumerate(expected())
    ]


def test_poses_without_names_are_those_of_tum(tmp_path):
    """With names in a comment, too; and with those of EuRoC."""
    rows = [line.split() for line in tum()]
    euroc = [f"{1e9 * float(row[0]):.0f},{','.join([*row[1:4], row[7], *row[4:7]])}" for row in rows]
    place, turn = (
        ",".join(f"{key}_{axis} [{unit}]" for axis in axes)
        for key, axes, unit in (("p_RS_R", "xyz", "m"), ("q_RS", "wxyz", ""))
    )
    for lines in (tum(), ["# timestamp tx ty tz qx qy qz qw", *tum()], [f"#timestamp [ns],{place},{turn}", *euroc]):
        run = read_pose_run(FISH, saved(tmp_path, "run.txt", "\n".join(lines).encode()))
        assert run.pose == pytest.approx(expected(), abs=1e-6)
        assert run.time == pytest.approx(np.arange(120) * EACH / 1e9, abs=1e-5)


def test_poses_of_kitti_are_rotations_beside_places(tmp_path):
    """They have no times, so that the command needs a frame rate; 12 other numbers in a row are no poses."""
    turns = [(np.cos(yaw), np.sin(yaw), x, y) for x, y, yaw in expected()]
    lines = [f"{c:.9f} {-s:.9f} 0 {x:.9f} {s:.9f} {c:.9f} 0 {y:.9f} 0 0 1 0" for c, s, x, y in turns]
    path = saved(tmp_path, "run.txt", "\n".join(lines).encode())
    run = read_pose_run(FISH, path, frame_rate=1e9 / EACH)
    assert run.pose == pytest.approx(expected(), abs=1e-6)
    with pytest.raises(InputError, match="must have a column of time, but is missing: give --frame-rate"):
        read_pose_run(FISH, path)
    path = saved(tmp_path, "other.txt", ("\n".join([*lines[:30], "1 2 3 4 5 6 7 8 9 10 11 12"])).encode())
    with pytest.raises(InputError, match="must hold rotations, as KITTI writes them, but is other numbers"):
        read_pose_run(FISH, path, frame_rate=60.0)
