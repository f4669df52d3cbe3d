"""Firmware in the loop: the same bits on this machine and on an emulated Cortex-M7, within its bounds.

These tests need the programs of `make firmware`, and those of the emulator `make system-deps` too.
"""

import functools
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.provenance import robot_path
from hypertuna.errors import InputError
from hypertuna.firmware.boards import find_firmware, missing, started
from hypertuna.firmware.channel import RadioModel
from hypertuna.firmware.in_the_loop import firmware_in_the_loop
from hypertuna.firmware.lockstep import ORDERS, order
from hypertuna.firmware.parameters import firmware_table
from hypertuna.firmware.relay import radio_model
from hypertuna.firmware.scenario import START, Scenario, find_scenario, random_messages, scheduled_orders
from hypertuna.swimming.gait import named_gait
from program import Run
from radio_bench import free_port

MAX_INSTRUCTIONS, MAX_TEXT, MAX_STACK = 4100, 100 * 1024, 2048
DOCS = Path(__file__).parents[2] / "docs" / "firmware.md"
STORED = json.loads((DOCS.parents[1] / "validation" / "lockstep" / "lockstep.json").read_text())  # tables of the docs
MEASURE = "validation/lockstep/measure.py, and docs/figures.py"
STALE = 0.05  # a change of the firmware by which the tables must be measured anew


@pytest.fixture(scope="module")
def fish() -> ht.Robot:
    return ht.load("hypertuna")


@pytest.fixture(scope="module")
def pc() -> Path:
    return _built("pc")


@pytest.fixture(scope="module")
def qemu(pc: Path) -> Path:
    if (lack := missing("qemu")) is not None:
        pytest.skip(lack)
    return _built("qemu")


def _built(board: str, robot: str = "hypertuna") -> Path:
    try:
        return find_firmware(robot, board)
    except InputError as error:
        pytest.skip(str(error))


def test_hundred_thousand_ticks_have_the_same_bits(fish: ht.Robot, qemu: Path, pc: Path) -> None:
    run = firmware_in_the_loop(fish, find_scenario("random"), board="qemu", ticks=100_000, seed=1)
    assert run.ticks == 100_000
    assert len(run.mismatches) == 0
    assert run.instructions("controller") <= MAX_INSTRUCTIONS
    assert 0 < run.answers["stack"].max() <= MAX_STACK
    stored = STORED["hypertuna"]["runs"]["random messages"]
    for part in ("controller", "pilot", "radio"):
        assert run.instructions(part) == pytest.approx(stored[part], rel=STALE), f"run {MEASURE}"
    assert int(run.answers["stack"].max()) == pytest.approx(stored["stack"], rel=STALE), f"run {MEASURE}"
    # The messages went everywhere: other digests in nearly every tick, arming, all sources of commands, refusals.
    assert len(np.unique(run.answers["digest"])) > 0.99 * run.ticks
    more = firmware_in_the_loop(fish, find_scenario("random"), board="pc", ticks=100_000, seed=3)
    assert {*run.answers["state"].tolist(), *more.answers["state"].tolist()} == set(range(len(_core.state_table())))
    assert {"armed", "disarmed", "out_of_range", "unknown", "faulty"} <= set(run.refused)
    assert 0.05 < (run.answers["state"] != 0).mean() < 0.9


@pytest.mark.parametrize("seed", [0, 6, 7])
def test_a_mission_that_never_began_is_refused(fish: ht.Robot, pc: Path, seed: int) -> None:
    """These random orders end a mission without its begin, and the board read waypoints where there were none."""
    messages = random_messages(firmware_table(fish), 3000, seed)
    kinds = [ORDERS[kind] for kind in messages["order"]]
    first = kinds.index("end", kinds.index("waypoint"))
    assert "begin" not in kinds[:first]
    with started("pc", pc) as board:
        answers = board.run(messages)
    assert answers["refusal"][first] != 0


def test_a_difference_is_found(fish: ht.Robot, pc: Path) -> None:
    """Two programs that get different messages differ: the comparison can fail."""
    messages = random_messages(firmware_table(fish), 300, 3)
    other = messages.copy()
    other["sample"][200, 0] += 1
    with started("pc", pc) as a, started("pc", pc) as b:
        answers = a.run(messages), b.run(other)
    same = answers[0]["digest"] == answers[1]["digest"]
    assert same[:200].all()
    assert not same[200]


def test_gait_on_the_twin(fish: ht.Robot, qemu: Path) -> None:
    run = firmware_in_the_loop(fish, find_scenario("gait:unoptimised-0.3", fish), board="qemu", ticks=600)
    assert len(run.mismatches) == 0
    assert not run.refused
    assert run.instructions("controller") <= MAX_INSTRUCTIONS
    assert run.answers["state"][-1] != 0
    assert run.mission_run is not None
    assert run.status is None  # there is no mission that could end
    # It swims: the tail bends as far as it is asked to, within its posture control's first beats.
    assert abs(run.mission_run.data["angle"]).max() > np.radians(12)


def test_phases_more_than_a_turn_apart_beat_on_board(fish: ht.Robot, pc: Path) -> None:
    """-200 and 200 deg are a lag of 40 deg, and the board takes lags of a turn at most."""
    scenario = find_scenario("gait:unoptimised-0.3", fish)
    gaits = [ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=phase) for phase in ((-200, 200), (0, 40))]
    runs = [firmware_in_the_loop(fish, replace(scenario, gait=gait), board="pc", ticks=400) for gait in gaits]
    assert [run.refused for run in runs] == [{}, {}]
    bends = [run.mission_run.data["angle"] for run in runs if run.mission_run is not None]
    assert abs(bends[0]).max() > np.radians(8)
    np.testing.assert_allclose(*bends, atol=1e-4)


def test_a_robot_that_is_lost_comes_up(fish: ht.Robot, pc: Path) -> None:
    """Three meters deep the cable to the ground breaks: the tail rests after 5 s, after a minute the robot comes up."""
    run = firmware_in_the_loop(fish, find_scenario("lost:unoptimised-0.3", fish), board="pc", ticks=24_000)
    assert len(run.mismatches) == 0
    depth = run.answers["depth"]
    assert (depth[5200:11_000] > 2).all()
    assert depth[-1] < 0.5
    names = [name for name, *_ in _core.state_table()]
    states = run.answers["state"]
    way = [names[state] for state in states[np.flatnonzero(np.diff(states, prepend=-1))]]
    assert way == ["disarmed", "rest", "gait", "rest", "home", "rest"]
    np.testing.assert_allclose(depth[-1], -run.mission_run.data["position"][-1, 2], atol=0.1)
    # It had fixes before it dived: it comes home to where it was armed, and rests as soon as fixes tell that place. The
    # current, which takes minutes longer, matters only before a dive.
    assert np.hypot(*run.mission_run.data["position"][-1, :2]) < 5


@pytest.mark.parametrize("board", ["pc", "qemu"])
def test_mission_on_the_twin(fish: ht.Robot, pc: Path, board: str, request: pytest.FixtureRequest) -> None:
    request.getfixturevalue(board)
    ticks = 9000 if board == "pc" else 600
    run = firmware_in_the_loop(fish, find_scenario("box"), board=board, ticks=ticks)
    assert len(run.mismatches) == 0
    assert not run.refused
    if board == "pc":  # after a minute of fixes it dives and goes its way
        assert run.answers["mode"][-1] == 1
        np.testing.assert_allclose(run.answers["depth"][-1], -run.mission_run.data["position"][-1, 2], atol=0.1)
        assert run.answers["speed"][-1] > 0.2


def test_bounds_and_runs_of_the_docs() -> None:
    page = DOCS.read_text()
    for words in (
        f"controller to {MAX_INSTRUCTIONS:,}",
        f"{MAX_TEXT // 1024} kB of program",
        f"{MAX_STACK // 1024} kB of stack",
    ):
        assert words in page
    for found in STORED.values():
        runs = found["runs"].values()
        assert sum(run["ticks"] for run in runs) >= 100_000
        assert all(run["differ"] in (0, None) and run["stack"] <= MAX_STACK for run in runs)
        assert found["sizes"]["text"] <= MAX_TEXT


@pytest.mark.parametrize("robot", STORED)
def test_sizes_are_those_of_the_docs(robot: str) -> None:
    program = _built("qemu", robot)
    text = int(subprocess.run(["arm-none-eabi-size", program], capture_output=True, text=True).stdout.split()[6])
    assert text <= MAX_TEXT
    assert text == pytest.approx(STORED[robot]["sizes"]["text"], rel=STALE), f"run {MEASURE}"


def test_symbols(qemu: Path) -> None:
    symbols = subprocess.run(["arm-none-eabi-nm", "-C", qemu], capture_output=True, text=True).stdout
    for word in ("malloc", "operator new", "free", "_sbrk", "unwind", "__cxa_throw", "personality"):
        assert word not in symbols, word


def test_no_arithmetic_in_double_precision(qemu: Path) -> None:
    code = subprocess.run(["arm-none-eabi-objdump", "-d", qemu], capture_output=True, text=True).stdout
    assert ".f32" in code
    assert ".f64" not in code
    assert "__aeabi_d" not in code


def test_missing_programs_are_told(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code, _, told = run("hil", "--board", "pc", "--firmware", str(tmp_path))
    assert code == 2
    assert "make firmware ROBOT=hypertuna" in told
    monkeypatch.setattr(shutil, "which", lambda program: None)
    code, _, told = run("hil", "--board", "qemu")
    assert code == 2
    assert "make system-deps" in told


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--board", "teensy"), "--board"),
        (("--scenario", "bux"), "box"),
        (("--scenario", "gait:nope"), "nope"),
        (("--ticks", "many"), "--ticks"),
        (("--ticks", "0"), "ticks must be from 1 to"),
        (("--ticks", "-5"), "ticks must be from 1 to"),
        (("--seed", "-1"), "seed must be from 0 to"),
        (("--radio", "99999"), "radio must be from 1 to 65535, but is 99999"),
        (("--robot", "rexeel"), "joints must be at most 4 groups for the firmware"),
        (("--black-box", "box.txt"), "--black-box must end in .bin"),
    ],
)
def test_bad_input(run: Run, options: tuple[str, ...], words: str) -> None:
    code, _, told = run("hil", *options)
    assert code == 2
    assert words in told


def test_json(run: Run, pc: Path) -> None:
    code, told, _ = run("hil", "--ticks", "500", "--json")
    assert code == 0
    found = json.loads(told)
    assert found["ticks"] == 500
    assert found["mismatches"] == 0
    assert found["real_time_factor"] > 0
    assert found["instructions_per_tick_max"] is None


@pytest.mark.parametrize(("fault", "reason"), [("battery:nan@10", "battery_lost"), ("field:nan@10", "compass_lost")])
def test_reasons_of_the_pilot_are_printed(run: Run, pc: Path, fault: str, reason: str) -> None:
    """A lost compass is a reason of the pilot alone, not among the faults."""
    _, told, _ = run("hil", "--scenario", "box", "--fault", fault, "--ticks", "1400", "--json")
    assert json.loads(told)["reasons"] == [reason]


def test_a_run_without_a_way_to_go_is_not_given_up(fish: ht.Robot, pc: Path) -> None:
    assert firmware_in_the_loop(fish, find_scenario("afloat"), ticks=20).status is None
    assert firmware_in_the_loop(fish, find_scenario("box"), ticks=20).status == "given up"


def test_the_origin_comes_with_the_mission_or_by_the_first_fix() -> None:
    """As on a real robot: an origin at the first tick hid that the first fix moved the mission."""

    def origins(scenario: Scenario) -> list[tuple[int, Any]]:
        given = ORDERS.index("origin")
        return [(tick, message["fix"]) for tick, message in scheduled_orders(scenario) if message["order"] == given]

    box = find_scenario("box")
    ((tick, fix),) = origins(box)
    assert tick > START
    assert np.degrees(ht.read_mission("box").origin) == pytest.approx(fix / 1e7, abs=1e-7)
    assert origins(replace(box, origin=None)) == []


def test_a_mission_that_comes_home_early_is_not_done(fish: ht.Robot, pc: Path) -> None:
    run = firmware_in_the_loop(fish, find_scenario("box"), ticks=20)
    answers = run.answers[-4:].copy()
    names, modes = ([name for name, *_ in table] for table in (_core.state_table(), _core.mode_table()))
    for way, status in ((("mission", "home", "rest"), "home"), (("mission", "surface", "rest"), "up")):
        answers["state"] = [names.index(name) for name in ("rest", *way)]
        assert replace(run, answers=answers).status == status
        answers["mode"][-1] = modes.index("done")
        assert replace(run, answers=answers).status == "done"
        answers["mode"][-1] = 0
    last = run.answers[-1:].copy()
    adrift = 1 << [name for name, _ in _core.reason_table()].index("adrift")
    for mode, reasons, status in (("ended", 0, "home"), ("ended", adrift, "adrift"), ("done", 0, "done")):
        last["mode"], last["reasons"] = modes.index(mode), reasons
        assert replace(run, answers=last).status == status


def test_firmware_of_another_description_is_told(run: Run, pc: Path, tmp_path: Path) -> None:
    """Else two programs with the same old numbers would agree, and the new ones would never have been tried."""
    changed = tmp_path / "mine.toml"
    changed.write_text(
        robot_path(ht.load("hypertuna").file).read_text().replace("learning = 0.7\n", "learning = 0.6\n")
    )
    code, _, told = run("hil", "--robot", str(changed), "--ticks", "10")
    assert code == 2
    assert "has other numbers than" in told
    assert f"hypertuna firmware params --robot {changed} -o firmware/robots/hypertuna.hpp" in told


def test_a_port_that_is_taken_is_told(qemu: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with (
            pytest.raises(InputError, match=f"radio must be a free port .* but is {port}"),
            started("qemu", qemu, port),
        ):
            pass


def test_folders_may_be_relative(run: Run, pc: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the programs and of the black box, though the program runs in a folder of its own."""
    (tmp_path / "build").symlink_to(pc.parent)
    monkeypatch.chdir(tmp_path)
    code, out, err = run("hil", "--ticks", "100", "--firmware", "build", "--black-box", "box.bin")
    assert (code, err) == (0, "")
    assert "Every tick has the same bits" in out
    assert (tmp_path / "box.bin").stat().st_size > 0


def test_firmware_that_dies_is_told(pc: Path, tmp_path: Path) -> None:
    program = tmp_path / "hypertuna-pc"
    program.write_text("#!/bin/sh\nexit 3\n")
    program.chmod(0o755)
    with started("pc", program) as board:
        board.send(order("none").tobytes())
        with pytest.raises(InputError, match="ended with status 3"):
            board.answer()


def persistently(ask: Callable[[], None]) -> None:
    """Ask up to four times what is answered by silence, as a pilot does after five tries of the client's own."""
    for left in reversed(range(4)):
        try:
            return ask()
        except InputError as error:
            if "answered" not in str(error) or not left:
                raise


@pytest.mark.parametrize("board", ["pc", "qemu"])
def test_through_the_modelled_radio(fish: ht.Robot, pc: Path, board: str, request: pytest.FixtureRequest) -> None:
    """A fifth of the packets is lost, in bursts, a tenth damaged: what is asked again and again arrives."""
    pytest.importorskip("pymavlink", reason="the radio needs the extra radio")
    from hypertuna.radio.client import connect

    request.getfixturevalue(board)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    air = RadioModel(rate=57600, loss=0.2, burst=2, damage=0.1)
    given = {"board": board, "ticks": 4500, "radio": port, "air": air, "real_time": True}
    with ThreadPoolExecutor(1) as pool:
        flight = pool.submit(firmware_in_the_loop, fish, find_scenario("afloat"), **given)
        with connect(f"udp:{port}", patience=60) as robot:
            persistently(robot.arm)
            persistently(lambda: robot.gait(named_gait(fish, "unoptimised-0.3")))
            assert robot.wait(lambda m: m.get_type() == "GAIT" and m.frequency == 2000, 20)
        run = flight.result()
    assert run.answers["state"].any()
    assert not run.compared
    assert run.air["ground"]["sent"] >= 2  # to arm and to swim, at the least
    robot = run.air["robot"]  # a heartbeat a second alone is thirty packets
    assert 0 < robot["lost"] < robot["sent"]
    assert 0 < robot["damaged"] < robot["sent"]


def test_numbers_of_the_radio() -> None:
    assert radio_model("") == RadioModel()
    assert radio_model("rate=2400, loss=0.3,packet=40") == RadioModel(rate=2400, loss=0.3, packet=40)
    for text, told in (
        ("speed=1", r"air must be NAME=NUMBER of the radio, but is 'speed=1'"),
        ("loss", "NAME=NUMBER of the radio, but is 'loss': write loss=NUMBER"),
        ("loss=much", "air.loss must be a number, but is 'much'"),
        ("loss=1.5", "loss must be at least 0 and less than 1"),
        ("rate=nan", "air.rate must be"),
    ):
        with pytest.raises(InputError, match=told):
            radio_model(text)


def test_a_modelled_radio_needs_a_ground_station(run: Run) -> None:
    code, _, told = run("hil", "--air", "loss=0.1")
    assert code == 2
    assert "--air needs a ground station: give its port by --radio" in told


@pytest.mark.parametrize(("scenario", "told"), [("box", True), ("afloat", False)])
def test_who_starts_a_mission_is_told(run: Run, pc: Path, scenario: str, told: bool) -> None:
    note = "note: box is armed and started by itself; --scenario afloat waits for the ground station"
    port = str(free_port())
    _, _, errors = run("hil", "--board", "pc", "--scenario", scenario, "--radio", port, "--ticks", "20")
    assert (note in errors) == told


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_closed_terminal_ends_it_as_ctrl_c_does(pc: Path, tmp_path: Path, number: signal.Signals) -> None:
    """Its firmware ends with it, and no folder of pipes is left behind."""
    command = [sys.executable, "-m", "hypertuna", "hil", "--board", "pc", "--scenario", "afloat", "--ticks", "100000"]
    place = {"TMPDIR": str(tmp_path)}
    # As a terminal starts it: under nohup, SIGHUP stays ignored.
    default = functools.partial(signal.signal, number, signal.SIG_DFL)
    process = subprocess.Popen(command, env=os.environ | place, stderr=subprocess.PIPE, text=True, preexec_fn=default)
    end = time.monotonic() + 60
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")  # the firmware, which starts in its folder
    while not (list(tmp_path.iterdir()) and children.read_text()) and time.monotonic() < end:
        time.sleep(0.05)
    assert list(tmp_path.iterdir())
    process.send_signal(number)
    told = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert told.endswith("interrupted\n")
    assert "Traceback" not in told
    assert list(tmp_path.iterdir()) == []
