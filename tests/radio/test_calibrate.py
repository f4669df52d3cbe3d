"""Calibrations live: the command asks, and a robot on the bench, whose sensors a test moves, keeps what fits."""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from threading import Event, Thread, Timer
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")

import hypertuna as ht
from black_box import JOINTS, head, sealed
from hypertuna import _core
from hypertuna.firmware.black_box import record_dtype
from hypertuna.firmware.parameters import firmware_table
from hypertuna.radio.calibration import SINGLE
from hypertuna.radio.client import connect
from hypertuna.radio.imu import POSITIONS
from hypertuna.radio.parameters import read_parameters, set_parameter
from program import Run
from radio_bench import free_port, running

PROGRAM = [sys.executable, "-m", "hypertuna"]
GRAVITY, FIELD = np.array([0, 0, 9.80665]), np.array([0.0, 0.5, -0.866])  # world: east, north, up
DIVIDER = 0.95  # volts shown per volt


class Bench:
    """A robot on the bench: its sensors read the file that is written here."""

    def __init__(self, folder: Path) -> None:
        self.file, self.port = folder / "readings", free_port()
        self.accelerometer: Callable[[np.ndarray], np.ndarray] = lambda x: x
        self.compass: Callable[[np.ndarray], np.ndarray] = lambda x: x
        self.rate, self.voltage, self.depth = np.zeros(3), 15.0, 0.0
        self.hold(Rotation.identity())

    def hold(self, attitude: Rotation) -> None:
        """Turn the robot to an attitude, body to world."""
        gravity, field = attitude.inv().apply(GRAVITY), attitude.inv().apply(FIELD)
        numbers = [*self.accelerometer(gravity), *self.rate, *self.compass(field), self.voltage, self.depth]
        new = self.file.with_suffix(".new")
        new.write_text(" ".join(f"{number:.9g}" for number in numbers))
        new.replace(self.file)

    def parameters(self) -> dict[str, float]:
        with connect(f"udp:{self.port}") as robot:
            return read_parameters(robot)

    def calibrate(self, sensor: str, *options: str, steps: Sequence[Callable[[], object]] = ()) -> tuple[int, Any, str]:
        """Run the command, and do a step at each of its questions; return exit code, record and errors."""
        command = [
            *PROGRAM,
            "radio",
            "calibrate",
            "--connect",
            f"udp:{self.port}",
            "--json",
            "--sensor",
            sensor,
            *options,
        ]
        pipe = subprocess.PIPE
        with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe) as process:
            assert process.stdin is not None
            assert process.stdout is not None
            assert process.stderr is not None
            errors, waiting = b"", iter(steps)
            patience = Timer(120, process.kill)  # of a question that no step answers
            patience.start()
            while part := process.stderr.read(1):
                errors += part
                if errors.endswith((b"Enter: ", b"neutral: ", b"in deg: ", b"`enough`: ")):
                    answer = next(waiting)()
                    process.stdin.write(f"{'' if answer is None else answer}\n".encode())
                    process.stdin.flush()
            told = process.stdout.read()
            patience.cancel()
        return process.returncode, json.loads(told) if told else None, errors.decode()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    with running(bench.port, bench.file):
        with connect(f"udp:{bench.port}") as robot:
            set_parameter(robot, "link_rate", 115200)
        yield bench


@pytest.fixture
def turning(bench: Bench) -> Iterator[Callable[[bool], None]]:
    """Turn the robot until the test ends, through all directions or on a table alone."""
    ends, threads = Event(), []

    def begin(everywhere: bool) -> None:
        def run() -> None:
            step = 0
            while not ends.wait(0.05):
                step += 1
                angles = (0.11 * step, 0.043 * step * everywhere, 0.071 * step * everywhere)
                bench.hold(Rotation.from_euler("ZXY", angles))

        threads.append(Thread(target=run))
        threads[-1].start()

    yield begin
    ends.set()
    for thread in threads:
        thread.join()


def described(name: str) -> float:
    return next(p.standard for p in firmware_table(ht.load("hypertuna")).parameters if p.name == name)


def test_a_turned_compass_is_kept(bench: Bench, turning: Callable[[bool], None]) -> None:
    """Iron of 30 % of the field, and an axis that is 15 % too weak: both are found, and on board afterwards."""
    iron, ratio = np.array([0.3, -0.2, 0.1]), np.array([1.0, 0.85, 1.1])
    bench.compass = lambda x: ratio * x + iron
    turning(True)
    code, record, errors = bench.calibrate("compass", steps=[lambda: None])
    assert code == 0, errors
    assert "12 of 12 directions" in errors
    (one,) = record["sensors"]
    assert one["rms_percent"] < 2
    assert one["notes"][1].startswith("the field dips by 60 +-")
    kept, count = bench.parameters(), described("field_scale_0")
    for k in range(3):
        assert kept[f"field_zero_{k}"] * count == pytest.approx(iron[k], abs=0.01)
        assert kept[f"field_scale_{k}"] * ratio[k] / count == pytest.approx(1, abs=0.01)


def test_a_compass_turned_on_a_table_changes_nothing(
    bench: Bench, turning: Callable[[bool], None], monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    """The time is over before all directions are covered."""
    before = bench.parameters()
    turning(False)
    monkeypatch.setattr("hypertuna.radio.calibration_procedure.TURNING_MAX", 6.0)
    monkeypatch.setattr("hypertuna.cli.calibrate.Terminal.ask", lambda self, robot, question: "")
    code, _, errors = run("radio", "calibrate", "--connect", f"udp:{bench.port}", "--sensor", "compass")
    assert (code, "error: compass must" in errors) == (2, True), errors
    assert bench.parameters() == before


def positions(bench: Bench, swap: bool = False) -> list[Callable[[], None]]:
    """Hold the robot in each position; with `swap` nose up where nose down is asked for."""
    oblique = iter([(-1, 0, 1), (0, -1, 1), (0.7, 0.7, 1)])
    steps: list[Callable[[], None]] = []
    for position in POSITIONS:
        up = np.array(position.up or next(oblique), float)
        up[0] *= -1 if swap else 1
        attitude, _ = Rotation.align_vectors([[0, 0, 1]], [up / np.linalg.norm(up)])
        steps.append(lambda attitude=attitude: bench.hold(attitude))  # type: ignore[misc]
    return steps


def test_an_accelerometer_in_nine_positions(bench: Bench) -> None:
    zero, ratio = np.array([0.3, -0.2, 0.5]), np.array([1.02, 0.98, 0.99])
    bench.accelerometer = lambda x: ratio * x + zero
    before = bench.parameters()
    code, _, errors = bench.calibrate("accelerometer", steps=positions(bench, swap=True))
    assert (code, "must read gravity along -x when the robot is held nose up, but is x 1.0" in errors) == (2, True), (
        errors
    )
    assert bench.parameters() == before
    code, record, errors = bench.calibrate("accelerometer", steps=positions(bench))
    assert code == 0, errors
    assert record["sensors"][0]["rms_m_s2"] < 0.05
    kept, count = bench.parameters(), described("accel_scale_0")
    for k in range(3):
        assert kept[f"accel_zero_{k}"] * count == pytest.approx(zero[k], abs=0.03)
        assert kept[f"accel_scale_{k}"] * ratio[k] / count == pytest.approx(1, abs=0.003)


def test_a_gyroscope_at_rest(bench: Bench) -> None:
    bench.rate = np.array([0.02, -0.03, 0.01])
    code, _, errors = bench.calibrate("gyroscope", steps=[lambda: bench.hold(Rotation.identity())])
    assert code == 0, errors
    kept = bench.parameters()
    zeros = [kept[f"rate_zero_{k}"] * described("rate_scale_0") for k in range(3)]
    assert zeros == pytest.approx(bench.rate, abs=2e-3)


def test_voltage_and_depth(bench: Bench) -> None:
    """A meter beside the divider: one voltage gives its scale. Depths give that of the depth sensor, but no zero."""

    def show(**values: float) -> Callable[[], None]:
        def step() -> None:
            vars(bench).update(values)
            bench.hold(Rotation.identity())

        return step

    code, record, errors = bench.calibrate("voltage", "--at=16", steps=[show(voltage=16 * DIVIDER)])
    assert code == 0, errors
    (one,) = record["sensors"]
    assert list(one["parameters"]) == ["voltage_scale"]
    assert one["parameters"]["voltage_scale"] == pytest.approx(described("voltage_scale") / DIVIDER, rel=2e-3)
    steps = [show(depth=-0.2), show(depth=0.3), show(depth=1.3)]
    code, record, errors = bench.calibrate("depth", "--at=0,0.49,1.47", steps=steps)
    assert code == 0, errors
    assert "it shows" in errors
    (one,) = record["sensors"]
    assert one["parameters"] == {"depth_scale": pytest.approx(0.98 * described("depth_scale"), rel=0.01)}
    assert one["rms_m"] < 0.01
    code, _, errors = bench.calibrate("depth", "--at=0,1", steps=[show(depth=0), show(depth=0.4)])
    assert (code, "depth_scale must be accepted by the robot" in errors) == (2, True), errors
    assert bench.parameters()["depth_scale"] == pytest.approx(one["parameters"]["depth_scale"])


def test_all_servos_one_after_another(bench: Bench) -> None:
    angles = (1.0, -2.0, 0.0, 0.5, 3.0, -1.0)
    steps = [lambda: None, *(lambda angle=angle: angle for angle in angles)]
    code, record, errors = bench.calibrate("servo", steps=steps)
    assert code == 0, errors
    assert [one["sensor"] for one in record["sensors"]] == [f"servo_{k}" for k in range(6)]
    kept, factor = bench.parameters(), described("pulse_per_rad")
    trims = [kept[f"servo_trim_{k}"] / factor for k in range(6)]
    assert np.degrees(trims) == pytest.approx([-angle for angle in angles], abs=1e-3)


def test_an_armed_robot_is_not_calibrated(bench: Bench) -> None:
    with connect(f"udp:{bench.port}") as robot:
        robot.arm()
    code, _, errors = bench.calibrate("gyroscope")
    assert (code, "robot must be disarmed, but is armed" in errors) == (2, True), errors


def test_a_compass_from_a_log(bench: Bench, turning: Callable[[bool], None], tmp_path: Path, run: Run) -> None:
    pytest.importorskip("foxglove", reason="logs need the extra log")
    turning(True)
    log, place = tmp_path / "turn.mcap", ("--connect", f"udp:{bench.port}")
    code, _, errors = run("radio", "log", *place, "-o", str(log), "--duration", "20", "--rate", "RAW_IMU=10")
    assert code == 0, errors
    code, told, errors = run("radio", "calibrate", "--log", str(log), "--json")
    assert code == 0, errors
    (one,) = json.loads(told)["sensors"]
    assert one["parameters"]["field_scale_0"] == pytest.approx(described("field_scale_0"), rel=0.02)
    code, _, errors = run("radio", "log", *place, "-o", str(tmp_path / "x.mcap"), "--rate", "RAW_IMO=10")
    assert (code, "RAW_IMO must be a message: did you mean RAW_IMU" in errors) == (2, True), errors


def test_a_compass_from_a_black_box(bench: Bench, tmp_path: Path, run: Run) -> None:
    """Readings of a turned robot with iron on board: on top of the zeros that it has, the new ones."""
    iron = np.array([0.2, -0.1, 0.3])
    attitudes = Rotation.random(400, random_state=2).inv()
    rng = np.random.default_rng(3)
    content = head()
    for k, attitude in enumerate(attitudes):
        row = np.zeros((), record_dtype(JOINTS))
        row["tick"], row["attitude_estimated"] = k, (1, 0, 0, 0)
        row["field_read"] = attitude.apply(FIELD) + iron + rng.normal(0, 0.01, 3)
        row["acceleration_read"] = attitude.apply(GRAVITY)
        content += sealed(_core.RECORD_TICK, row.tobytes())
    box = tmp_path / "box000.bin"
    box.write_bytes(content)
    code, _, errors = run("radio", "calibrate", "--log", str(box))
    assert (code, "--connect must name the connection to the robot" in errors) == (2, True), errors
    with connect(f"udp:{bench.port}") as robot:
        set_parameter(robot, "field_zero_1", 500)
    code, told, errors = run("radio", "calibrate", "--log", str(box), "--connect", f"udp:{bench.port}", "--json")
    assert code == 0, errors
    assert json.loads(told)["sensors"][0]["points"] == 400
    kept, count = bench.parameters(), described("field_scale_0")
    zeros = [(kept[f"field_zero_{k}"] - 500 * (k == 1)) * count for k in range(3)]
    assert zeros == pytest.approx(iron, abs=0.01)


def test_what_does_not_go_together_is_refused(run: Run) -> None:
    place = ("--connect", f"udp:{free_port()}")
    for options, told in (
        (("--sensor", "compass", "--at=0,1", *place), "--at must not be given for compass"),
        (("--sensor", "servo", "--at=0", *place), "--at must not be given for servo"),
        (("--sensor", "voltage", *place), "--at must be a voltage above 0"),
        (("--sensor", "depth", "--at=1", *place), "--at must name at least two references"),
        (("--sensor", "depth_0", "--at=0,1", *place), "sensor must name a sensor or a servo"),
        (("--sensor", "compass"), "--connect must name the connection to the robot"),
        (("--sensor", "compass", "--log", "x.mcap", *place), "exactly one of --csv, --sensor and --log must be given"),
    ):
        code, _, errors = run("radio", "calibrate", *options)
        assert (code, told in errors) == (2, True), errors


def test_single_sensors_have_no_number() -> None:
    assert set(SINGLE) == {"voltage", "depth", "accelerometer", "gyroscope", "compass"}


def test_the_surface_is_taken_anew(bench: Bench) -> None:
    """Air pressure has changed by 30 hPa since the boot: the depth shows 0.3 m, and 0 after the command."""

    def step() -> None:
        bench.depth = 0.3
        bench.hold(Rotation.identity())
        time.sleep(1)  # until the depth of the estimate has followed

    code, record, errors = bench.calibrate("depth", steps=[step])
    assert code == 0, errors
    (one,) = record["sensors"]
    assert one["parameters"] == {}
    assert one["notes"][0].startswith(("it shows 0.0", "it shows -0.0"))
