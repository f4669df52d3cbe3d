"""Flights: missions on the twin, their logs, journals, seeds; and the command `hypertuna mission`."""

from __future__ import annotations

import json
import math
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.cli.main import main
from hypertuna.cli.mission import _not_done
from hypertuna.control.mission import Mission, fence_distance
from hypertuna.display import card_of
from hypertuna.mission.file import MissionFile, read_mission
from hypertuna.mission.flight import Flight, fly, outcome
from hypertuna.mission.run import expected, fly_parts, joined_parts, mission_start
from hypertuna.mission.seeds import fly_seeds

Run = Callable[..., tuple[int, str, str]]

SHORT = """
format = 1
name = "short"
robot = "hypertuna"
stay = true
[origin]
latitude_deg = 43.85
longitude_deg = 125.3
[start]
x_m = 0.0
y_m = 0.0
heading_deg = 0.0
[[waypoints]]
x_m = 0.0
y_m = 14.0
speed_m_s = 0.4
radius_m = 2.0
[limits]
fence_m = [[-20.0, -20.0], [20.0, -20.0], [20.0, 40.0], [-20.0, 40.0]]
[scatter]
current_m_s = 0.05
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("mission") / "short.toml"
    path.write_text(SHORT)
    return path


@pytest.fixture(scope="module")
def file(path: Path) -> MissionFile:
    return read_mission(path)


@pytest.fixture(scope="module")
def flight(file: MissionFile, tuna: ht.Robot) -> Flight:
    return fly(file, tuna)


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `hypertuna` with arguments: exit code, output, errors."""
    monkeypatch.setenv("COLUMNS", "200")

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["hypertuna", *arguments])
        with pytest.raises(SystemExit) as exit_:
            main()
        return int(exit_.value.code or 0), *capsys.readouterr()

    return call


def same(a: Flight, b: Flight) -> None:
    """Two flights are equal to the last bit."""
    assert a.status == b.status
    np.testing.assert_array_equal(a.record.time, b.record.time)
    for name, values in a.record.data.items():
        np.testing.assert_array_equal(values, b.record.data[name], err_msg=name)


# --- a flight


def test_it_is_the_mission_run_with_energy_and_charge(file: MissionFile, flight: Flight, tuna: ht.Robot) -> None:
    start = mission_start(tuna, file.mission, seed=0)
    whole = joined_parts(start, [part for _, part in fly_parts(start)])
    record = flight.record
    assert flight.status == whole.status
    np.testing.assert_allclose(record.time, whole.time, atol=1e-9)
    for name in ("position", "attitude", "power", "mode", "depth_estimated"):
        np.testing.assert_array_equal(record.data[name], whole.data[name], err_msg=name)
    charge, voltage = whole.data["charge"], whole.data["battery_voltage"]
    assert record.energy[-1] == pytest.approx((voltage * np.diff(charge, prepend=0.0)).sum())
    assert record.energy[-1] > whole.energy > 0.5 * record.energy[-1]  # idle current and converter beside the servos
    assert tuna.battery is not None
    assert record.data["charge_left"][-1] == pytest.approx(1 - charge[-1] / tuna.battery.capacity)


def test_it_ends_within_the_waypoint(flight: Flight) -> None:
    one = outcome(flight)
    assert one.status == "done"
    assert one.goal_distance < 4
    assert 11 < one.distance < 30
    assert one.depth_max < 1.0
    assert one.fence_margin_min > 15
    assert one.duration > 0.5 * expected(flight.record.mission)


def test_a_seed_has_its_own_noise_and_water(file: MissionFile, flight: Flight, tuna: ht.Robot) -> None:
    other = fly(file, tuna, seed=3)
    assert other.record.mission.current != flight.record.mission.current
    assert outcome(other).status == "done"
    same(other, fly(file, tuna, seed=3))


def test_ctrl_c_keeps_the_flights_that_have_ended(file: MissionFile, tuna: ht.Robot, tmp_path: Path) -> None:
    def stop(count: int, _: int) -> None:
        if count == 2:
            raise KeyboardInterrupt

    options: dict[str, Any] = {"threads": 1, "duration": 5.0, "checkpoint": tmp_path / "seeds.journal"}
    with pytest.raises(KeyboardInterrupt):
        fly_seeds(file, tuna, range(8), **options, report=stop)
    kept = (tmp_path / "seeds.journal").read_bytes()
    assert kept.count(b"\n") == 3  # the header, and two flights
    assert [one.seed for one in fly_seeds(file, tuna, range(8), **options)] == [*range(8)]
    assert (tmp_path / "seeds.journal").read_bytes().startswith(kept)


def test_seeds_are_the_same_over_threads_and_after_a_resume(
    file: MissionFile, tuna: ht.Robot, tmp_path: Path, flight: Flight
) -> None:
    one = fly_seeds(file, tuna, [0, 1, 2], threads=1, checkpoint=tmp_path / "seeds.journal")
    lines = (tmp_path / "seeds.journal").read_text().splitlines(keepends=True)
    (tmp_path / "torn.journal").write_text("".join(lines[:3]) + lines[3][:20])
    told: list[tuple[int, int]] = []
    two = fly_seeds(
        file, tuna, [0, 1, 2], threads=2, checkpoint=tmp_path / "torn.journal", report=lambda *p: told.append(p)
    )
    assert one == two
    assert one[0] == outcome(flight)
    assert told == [(1, 3), (2, 3), (3, 3)]
    with pytest.raises(ht.InputError, match="was started with seeds"):
        fly_seeds(file, tuna, [0, 1], checkpoint=tmp_path / "seeds.journal")
    with pytest.raises(ht.InputError, match="must be from 1 to 10000 seeds"):
        fly_seeds(file, tuna, [])


def test_a_flight_goes_on_from_its_journal(file: MissionFile, flight: Flight, tuna: ht.Robot, tmp_path: Path) -> None:
    journal = tmp_path / "short.journal"
    same(fly(file, tuna, checkpoint=journal), flight)
    lines = journal.read_text().splitlines(keepends=True)
    assert len(lines) > 2  # header, and more than one part
    journal.write_text("".join(lines[:2]))
    same(fly(file, tuna, checkpoint=journal), flight)
    with pytest.raises(ht.InputError, match="was started with seed"):
        fly(file, tuna, seed=1, checkpoint=journal)


# --- geometry


def test_the_margin_to_a_square_fence(file: MissionFile) -> None:
    places = np.array([[0, 0], [19, 0], [0, 39], [30, 0], [23, 44]])
    np.testing.assert_allclose(fence_distance(file.mission, places), [20, 1, 1, -10, -5])
    turned = Mission(file.mission.waypoints, fence=tuple(reversed(file.mission.fence)))
    np.testing.assert_allclose(fence_distance(turned, places), [20, 1, 1, -10, -5])
    assert np.isinf(fence_distance(Mission(file.mission.waypoints), places)).all()


def test_the_lake_takes_800_m_at_half_a_meter_a_second() -> None:
    assert expected(read_mission("lake").mission) == pytest.approx(1600)


def test_no_mission_is_swum_faster_than_the_fastest_gait() -> None:
    assert expected(read_mission("lake").mission, fastest=0.25) == pytest.approx(3200)


# --- the command


def test_the_command_flies_and_writes(run: Run, path: Path, flight: Flight, tmp_path: Path) -> None:
    pytest.importorskip("foxglove", reason="needs the extra log")
    from hypertuna.mission.read_log import read_log

    log, track, plot = (str(tmp_path / name) for name in ("run.mcap", "run.gpx", "run.svg"))
    code, output, _ = run("mission", str(path), "-o", log, "--gpx", track, "--plot", plot, "--json")
    told, one = json.loads(output), outcome(flight)
    assert code == 0
    assert (told["status"], told["seed"], told["robot"]) == ("done", 0, "hypertuna")
    assert told["distance_m"] == pytest.approx(one.distance)
    assert told["energy_wh"] == pytest.approx(one.energy / 3600)
    assert "The mission is done" in told["status_text"]
    read = read_log(log)
    assert read.complete
    assert read.record.facts["status"] == "done"
    np.testing.assert_allclose(read.record.data["position"], flight.record.data["position"], atol=1e-12)
    np.testing.assert_allclose(read.record.energy, flight.record.energy, rtol=1e-12)
    assert read.record.mission == flight.record.mission
    assert Path(track).read_text().count("<trk>") == 2
    assert "estimated" in Path(plot).read_text()
    code, output, _ = run("mission", str(path))
    assert f"{one.distance:.4g}" in output
    assert "The mission is done" in output


def test_the_command_flies_seeds(run: Run, path: Path, tmp_path: Path) -> None:
    table = str(tmp_path / "seeds.csv")
    code, output, _ = run("mission", str(path), "--seeds", "0:2", "-o", table, "--json")
    told = json.loads(output)
    assert code == 0
    assert [one["seed"] for one in told["flights"]] == [0, 1]
    assert told["summary"]["status"] == {"done": 2}
    distance = [one["distance_m"] for one in told["flights"]]
    assert told["summary"]["distance_m"]["mean"] == pytest.approx(np.mean(distance))
    lines = Path(table).read_text().splitlines()
    assert lines[0].startswith("seed,status,waypoints_reached,waypoints_passed,waypoints_skipped,duration_s,distance_m")
    assert len(lines) == 3
    assert "1 done" in run("mission", str(path), "--seeds", "0:1")[1]


def test_what_is_not_done_is_exit_code_1(run: Run, path: Path) -> None:
    code, output, _ = run("mission", str(path), "--duration", "10", "--json")
    told = json.loads(output)
    assert code == 1
    assert told["status"] == "given up"
    assert told["duration_s"] == pytest.approx(10, abs=0.2)
    code, output, _ = run("mission", str(path), "--duration", "10", "--seeds", "0:2")
    assert code == 1
    assert "not done: given up, waypoint 1 of 1 ahead: seeds 0, 1\n" in output


def test_flights_that_fail_alike_are_one_line(flight: Flight) -> None:
    """By what ended them and at which waypoint; reasons that do not end a mission are no cause."""
    one = outcome(flight)
    passed = [*one.waypoints, one.waypoints[0] | {"waypoint": 2, "outcome": "passed"}]
    late = replace(one, seed=4, status="home", waypoints=passed, reasons={"time_up": 9.0, "no_fix": 2.0})
    lost = replace(one, seed=7, status="adrift", reasons={"adrift": 30.0})
    lines = [line for line, _ in _not_done([one, lost, late, replace(late, seed=5)])]
    assert lines == [
        "not done: home, waypoint 2 of 2 passed, time up: seeds 4, 5",
        "not done: adrift, all waypoints reached: seed 7",
    ]


def test_more_speed_than_the_gaits_have_is_told(path: Path, run: Run, tmp_path: Path) -> None:
    hasty, slow = tmp_path / "hasty.toml", tmp_path / "slow.toml"
    for file, speed in ((hasty, 2.5), (slow, 0.25)):
        file.write_text(re.sub(r"speed_m_s = .*", f"speed_m_s = {speed}", path.read_text()))
    told, usual = (json.loads(run("mission", str(p), "--duration", "2", "--json")[1]) for p in (hasty, slow))
    found = re.search(
        r" The mission commands 2.5 m/s, but the fastest gait reaches (0\.\d+) m/s\.$", told["status_text"]
    )
    assert found
    assert told["expected_s"] == pytest.approx(usual["expected_s"] * 0.25 / float(found[1]), rel=5e-3)
    assert "fastest" not in usual["status_text"]


def test_more_speed_on_the_way_home_than_the_gaits_have_is_told(path: Path, run: Run, tmp_path: Path) -> None:
    file = tmp_path / "home.toml"
    legs = re.sub(r"speed_m_s = .*", "speed_m_s = 0.25", path.read_text().replace("stay = true\n", ""))
    file.write_text(legs + "\n[home]\nx_m = 0.0\ny_m = 0.0\nspeed_m_s = 2.5\n")
    told = json.loads(run("mission", str(file), "--duration", "2", "--json")[1])
    assert " [home] commands 2.5 m/s, but the fastest gait reaches" in told["status_text"]


def test_a_flight_that_ends_elsewhere_and_crosses_the_fence_says_so(flight: Flight) -> None:
    away = flight.record.data["position"].copy()
    away[-1, :2] = 0.0, 60.0  # m: 20 m beyond the fence, 46 m beyond the only waypoint
    adrift = replace(flight, record=replace(flight.record, data=flight.record.data | {"position": away}))
    told = " ".join(str(line[0]) for line in card_of(adrift).lines() if isinstance(line, tuple))
    assert "It crossed the fence by 20 m." in told
    assert "By the pilot's estimate the mission is done: all waypoints reached, and home after" in told
    assert "It is 46 m from the last waypoint, beyond the radius of 2 m: the pilot judges by its estimated" in told


def test_waypoints_count_from_1_and_have_an_uncertainty(flight: Flight) -> None:
    """The only waypoint is passed half way: text and rows call it 1, and the pilot's deviation is no error."""
    data, rows = flight.record.data, len(flight.record.time)
    after = np.arange(rows) >= rows // 2
    changed = {"leg": after * 1.0, "passed": after * 1.0, "reached": np.zeros(rows)}
    passed = replace(flight, record=replace(flight.record, data=data | changed))
    (row,) = outcome(passed).waypoints
    assert (row["waypoint"], row["outcome"]) == (1, "passed")
    told = " ".join(str(line[0]) for line in card_of(passed).lines() if isinstance(line, tuple))
    assert f"Waypoint 1 passed at a depth of {row['depth_m']:.3g} m. By the pilot's estimate it was" in told
    assert f"with an uncertainty of {row['uncertainty_m']:.3g} m; in truth {row['true_m']:.3g} m." in told
    assert row["uncertainty_m"] == data["position_error"][rows // 2]


def test_a_killed_command_goes_on(path: Path, run: Run, tmp_path: Path, flight: Flight) -> None:
    journal = tmp_path / "run.journal"
    arguments = ("mission", str(path), "--checkpoint", str(journal), "--json")
    with subprocess.Popen([sys.executable, "-m", "hypertuna", *arguments], stdout=subprocess.DEVNULL) as child:
        begin = time.monotonic()
        while child.poll() is None and time.monotonic() - begin < 60:
            if journal.exists() and journal.read_bytes().count(b"\n") >= 2:
                child.send_signal(signal.SIGKILL)
                break
            time.sleep(0.005)
        child.wait()
    assert journal.read_bytes().count(b"\n") >= 2
    resumed = json.loads(run(*arguments)[1])
    one = outcome(flight)
    assert (resumed["distance_m"], resumed["energy_wh"]) == (one.distance, one.energy / 3600)
    assert resumed["reasons_s"] == one.reasons


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--seeds", "5"), "--seeds must be FROM:TO, but is '5': write, for example, 0:100"),
        (("--seeds", "5:2"), "--seeds must be FROM:TO with 0 <= FROM < TO"),
        (("--seeds", "0:2", "--plot", "a.svg"), "--plot applies to a single flight: remove it, or remove --seeds"),
        (("--seeds", "0:2", "-o", "a.mcap"), "--output must end in .nc, .csv or .shards"),
        (("--shard", "1/2"), "--shard applies to many flights: add --seeds, such as --seeds 0:100"),
        (("-o", "a.csv"), "--output must end in .mcap"),
        (("--seed", "-1"), "seed must not be negative"),
        (("--fault", "fin-prt:stuck@1"), "fault"),
        (("--robot", "rexeel"), "rexeel"),
        (("--duration", "x"), "--duration must be a number"),
        (("--threads", "0", "--seeds", "0:1"), "threads must be at least 1"),
    ],
)
def test_bad_input_is_one_sentence(run: Run, path: Path, options: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run("mission", str(path), *options)
    assert (code, output) == (2, "")
    (error,) = (line for line in errors.splitlines() if not line.startswith("note: "))
    assert sentence in error


def test_missions_that_lack_something(run: Run, tmp_path: Path) -> None:
    bare = tmp_path / "bare.toml"
    bare.write_text(SHORT.replace('robot = "hypertuna"\n', ""))
    assert "bare.toml: robot is missing: add robot to the file, or give --robot" in run("mission", str(bare))[2]
    bare.write_text(SHORT.replace("[origin]\nlatitude_deg = 43.85\nlongitude_deg = 125.3\n", ""))
    code, _, errors = run("mission", str(bare), "--gpx", str(tmp_path / "a.gpx"))
    assert code == 2
    assert "bare.toml: origin is needed for a track on the Earth" in errors
    assert "did you mean lake?" in run("mission", "lak")[2]
    assert math.isfinite(expected(read_mission("box").mission))
