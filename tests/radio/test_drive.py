"""Driving and the commands of the link, against the robot on UDP by the clock."""

import io
import json
import math
import os
import pty
import select
import struct
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")

from rich.console import Console

import hypertuna as ht
from hypertuna.cli.drive import Pad
from hypertuna.errors import InputError
from hypertuna.firmware.parameters import firmware_table
from hypertuna.radio.calibration import calibrate, read_pairs
from hypertuna.radio.client import address
from hypertuna.radio.dialect import dialect
from hypertuna.radio.drive import Stick, gamepad, keys, moved, pressed, view
from hypertuna.radio.log import read_radio_log
from program import Run
from radio_bench import free_port, running

PROGRAM = [sys.executable, "-m", "hypertuna"]


def test_keys_move_the_stick_within_its_bounds() -> None:
    stick = Stick()
    for key in "wwwwwwwwwwwwaadddr":
        stick = pressed(stick, key)
    assert stick == Stick(ahead=1.0, turn=0.2, climb=0.2)
    assert pressed(stick, "x") == Stick(ahead=1.0)
    assert pressed(stick, "s").ahead == 0.9
    assert [pressed(stick, key).order for key in ("\n", "m", "q", "3", "0", "?")] == [
        "arm",
        "mission",
        "quit",
        "3",
        "",
        "",
    ]


def test_keys_that_a_terminal_spells_out_are_no_orders() -> None:
    """F5 is ESC [ 1 5 ~, Home ESC [ 1 ~, up ESC [ A or ESC O A: none may start gait 1 or 5."""
    assert keys(b"\x1b[15~\x1b[1~\x1b[A\x1bOA\x1b[1;5C\x1b") == ""
    assert keys(b"w\x1b[15~2 ") == "w2 "


def test_a_gamepad_that_goes_away_stops(tmp_path: Path) -> None:
    """Events in pieces, then the end of the device: a stop, once, and a sentence."""
    said: list[str] = []
    os.mkfifo(tmp_path / "pad")
    reading = os.open(tmp_path / "pad", os.O_RDONLY | os.O_NONBLOCK)
    writing = os.open(tmp_path / "pad", os.O_WRONLY)
    with Pad(str(tmp_path / "pad"), said) as pad:
        assert pad.events() == []
        event = struct.pack("<IhBB", 0, 32767, 2, 0)
        os.write(writing, event + event[:3])
        assert pad.events() == [("turn", 1.0)]
        os.write(writing, event[3:])
        assert pad.events() == [("turn", 1.0)]
        os.close(writing)
        assert pad.events() == [("gone", 1.0)]
        assert pad.events() == []
    os.close(reading)
    assert moved(Stick(ahead=1), ("gone", 1.0)) == Stick(order="stop")
    assert said == ["the gamepad is disconnected: drive with the keys, or restart the command"]
    for path in (tmp_path / "none", tmp_path):
        with pytest.raises(InputError, match="--gamepad must be a joystick device"):
            Pad(str(path), said)


def test_a_gamepad_speaks_in_events_of_eight_bytes() -> None:
    """Left stick: right and forward; a button; the middle is quiet."""
    events = b"".join(
        struct.pack("<IhBB", 0, value, kind, number)
        for value, kind, number in ((32767, 2, 0), (-16384, 2, 1), (1000, 2, 0), (1, 1, 0), (0, 1, 0), (5, 0x82, 4))
    )
    found = gamepad(events + b"rest")
    assert found == [
        ("turn", 1.0),
        ("ahead", pytest.approx(0.5, abs=1e-3)),
        ("turn", 0.0),
        ("arm", 1.0),
        ("climb", 0.0),
    ]
    assert moved(Stick(), ("ahead", -0.5)) == Stick()
    assert moved(Stick(), ("turn", 1.0)).turn == 1.0


@pytest.mark.parametrize("width", [50, 100, 160])
def test_the_view_fits_any_width(width: int) -> None:
    made = {
        "HEARTBEAT": dialect().MAVLink_heartbeat_message(12, 0, 129, 1, 4, 3),
        "HYDRAULICS": dialect().MAVLink_hydraulics_message(0, 1 << 13, [1234, -50], [600, 610, 620, 630], [1] * 4),
        "PILOT": dialect().MAVLink_pilot_message(0, 0, 1 << 11, 100, [0, 0], 300, 0, 0),
    }
    console = Console(width=width, record=True, file=io.StringIO())
    console.print(view(made, ["a value is out of range"], Stick(ahead=0.5, turn=-0.2), ("slow", "fast"), 0.3))
    text = console.export_text()
    assert max(map(len, text.splitlines())) <= width
    for wanted in ("12.3, -0.5 deg", "low_voltage", "leak", "20% to port", "out of range", "armed"):
        assert wanted in text


def test_addresses() -> None:
    assert address("udp:14550") == ("udpin:127.0.0.1:14550", 9600)
    assert address("serial:/dev/ttyUSB0:57600") == ("/dev/ttyUSB0", 57600)
    assert address("serial:/dev/ttyUSB0") == ("/dev/ttyUSB0", 9600)
    assert address("tcp:localhost:5760")[0] == "tcp:localhost:5760"
    for bad in ("", "udp", "udp:", "udp:99999999", "tcp:5760", "usb:1", "serial:"):
        with pytest.raises(InputError, match="must"):
            address(bad)


def test_calibration_is_a_straight_line(tmp_path: Path) -> None:
    """Counts of 100 at 0 deg and 10 a degree: zero 100, scale 0.1 deg. A servo at 0 for 1512 us: trim 12 us."""
    file = tmp_path / "pairs.csv"
    rows = [
        "sensor,counts,reference",
        "bend_1,0,-10",
        "bend_1,100,0",
        "bend_1,300,20",
        "servo_2,1412,-9",
        "servo_2,1612,9",
    ]
    file.write_text("\n".join(rows))
    bend, servo = calibrate(read_pairs(file))
    assert bend.parameters == {"bend_zero_1": pytest.approx(100), "bend_scale_1": pytest.approx(math.radians(0.1))}
    assert bend.rms == pytest.approx(0, abs=1e-12)
    assert servo.parameters == {"servo_trim_2": pytest.approx(12e-6)}
    done = subprocess.run([*PROGRAM, "radio", "calibrate", "--csv", file, "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["sensors"][0]["parameters"]["bend_zero_1"] == pytest.approx(100)


@pytest.mark.parametrize(
    ("rows", "wanted"),
    [
        ("bend_0,1,5\nbend_0,2,5", "must be measured at two or more references, but is measured at one, in 2 rows"),
        ("bend_0,1,5\nbend_0,1,6", "must change with the reference"),
        ("bend_0,1,-9\nbend_0,3,0\nbend_0,2,9", "must follow the reference along a straight line, but is off by"),
        ("band_0,1,5", "line 2, sensor must name a sensor"),
        ("bend_0,-1e300,5", "line 2, counts must be from -1e.12 to 1e.12, but is -1e.300"),
        ("bend_0,x,5", "line 2, counts must be a finite number"),
    ],
)
def test_a_calibration_that_says_nothing_is_refused(tmp_path: Path, rows: str, wanted: str) -> None:
    file = tmp_path / "pairs.csv"
    file.write_text(f"sensor,counts,reference\n{rows}\n")
    with pytest.raises(InputError, match=wanted):
        calibrate(read_pairs(file))


def test_parameters_and_logs_by_the_command(tmp_path: Path) -> None:
    port = free_port()
    log = tmp_path / "run.mcap"
    with running(port):
        place = ["--connect", f"udp:{port}", "--json"]
        done = subprocess.run([*PROGRAM, "radio", "params", *place, "--set", "link_rate=115200"], capture_output=True)
        assert json.loads(done.stdout)["parameters"] == {"link_rate": 115200}
        done = subprocess.run([*PROGRAM, "radio", "params", *place, "-o", tmp_path / "all.csv"], capture_output=True)
        assert done.returncode == 0, done.stderr
        table = firmware_table(ht.load("hypertuna"))
        assert len((tmp_path / "all.csv").read_text().splitlines()) == 1 + len(table.parameters)
        done = subprocess.run(
            [*PROGRAM, "radio", "params", *place, "--set", "link_rate=1"], capture_output=True, text=True
        )
        assert done.returncode == 2
        assert done.stderr == "error: link_rate must be accepted by the robot, but is 1: a value is out of range.\n"
        done = subprocess.run([*PROGRAM, "radio", "log", *place, "-o", log, "--duration=-3"], capture_output=True)
        assert (done.returncode, done.stderr) == (
            2,
            b"error: --duration must be greater than 0, but is -3: give it in s.\n",
        )
        done = subprocess.run([*PROGRAM, "radio", "log", *place, "-o", log, "--duration", "3"], capture_output=True)
        assert done.returncode == 0, done.stderr
        counts = json.loads(done.stdout)["messages"]
        assert counts == {name: len(times) for name, times in read_radio_log(log).time.items()} != {}
    assert log.stat().st_size > 1000
    done = subprocess.run(
        [*PROGRAM, "radio", "params", "--connect", f"udp:{free_port()}"], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr[:53]) == (2, "error: --connect must receive a heartbeat within 10 s")


def test_a_servo_and_a_sensor_live() -> None:
    """2 deg at neutral are taken off in one step, or asked for; what a sensor's noise makes is refused whole."""
    port = free_port()
    with running(port):
        place = ["--connect", f"udp:{port}", "--json"]
        call = [*PROGRAM, "radio", "calibrate", *place, "--sensor"]
        subprocess.run([*PROGRAM, "radio", "params", *place, "--set", "link_rate=115200"], check=True)
        done = subprocess.run([*call, "servo_2", "--at=2"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        (one,) = json.loads(done.stdout)["sensors"]
        assert one["parameters"] == {"servo_trim_2": pytest.approx(-math.radians(2) * 637e-6, rel=1e-5)}
        done = subprocess.run([*call, "servo_2"], capture_output=True, text=True, input="\n-2\n")
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["sensors"][0]["parameters"] == {"servo_trim_2": pytest.approx(0, abs=1e-9)}
        done = subprocess.run([*call, "bend_0", "--at=0,9"], capture_output=True, text=True, input="\n\n")
        assert (done.returncode, "bend_scale_0 must be accepted by the robot" in done.stderr) == (2, True), done.stderr
        found = subprocess.run([*PROGRAM, "radio", "params", *place], capture_output=True)
        assert json.loads(found.stdout)["parameters"]["bend_zero_0"] == 32768  # that was new, and is as before


def test_what_a_live_calibration_needs_is_told_before_it_connects(run: Run) -> None:
    place = ("--connect", f"udp:{free_port()}")
    for options, told in (
        (("--sensor", "bend_0", "--at=0", *place), "--at must name at least two references, but is 0"),
        (("--sensor", "bend_0", *place), "--at must name at least two references, but is missing"),
        (("--sensor", "servo_2", "--at=0,1", *place), "--at must be one angle of a servo"),
        (("--sensor", "bond_0", "--at=0,1", *place), "sensor must name a sensor or a servo"),
        (("--sensor", "bend_0", "--at=0,1"), "--connect must name the connection to the robot"),
        ((), "exactly one of --csv, --sensor and --log must be given"),
    ):
        code, _, errors = run("radio", "calibrate", *options)
        assert (code, told in errors) == (2, True), errors


def test_a_drive_from_a_terminal(tmp_path: Path) -> None:
    """Keys typed into a terminal: arm, a gait, the stick, quit. The log says that the robot did all of it."""
    port, log = free_port(), tmp_path / "drive.mcap"
    with running(port):
        master, slave = pty.openpty()
        command = [*PROGRAM, "radio", "drive", "--connect", f"udp:{port}", "--log", log, "--json"]
        process = subprocess.Popen(command, stdin=slave, stdout=subprocess.PIPE, stderr=slave, cwd=tmp_path)
        os.close(slave)
        screen = b""

        def typed(keys: bytes, wanted: bytes) -> None:
            """Type, and read the screen until it shows what is wanted."""
            nonlocal screen
            os.write(master, keys)
            begin, end = len(screen), time.monotonic() + 60
            while wanted not in screen[begin:] and time.monotonic() < end:
                if select.select([master], [], [], 0.1)[0]:
                    try:
                        screen += os.read(master, 65536)
                    except OSError:  # the program has ended
                        return

        typed(b"", b"frequency")  # from a message that comes every few seconds
        typed(b"\n", b"yes")
        typed(b"2", b"gait ")  # as the state, from a heartbeat
        typed(b"wwwd", b"manual")
        typed(b"q", b"never shown")
        assert process.stdout is not None
        told = json.loads(process.stdout.read())
        assert process.wait(timeout=60) == 0
        process.stdout.close()
        os.close(master)
    assert told["messages"] > 0
    assert b"frequency" in screen
    assert b"deg" in screen
    from hypertuna.radio.log import read_radio_log

    found = read_radio_log(log)
    armed = found.fields["HEARTBEAT"]["base_mode"].astype(int) & 128
    assert armed.any()
    assert set(found.fields["HEARTBEAT"]["custom_mode"]) >= {101, 102, 103}
