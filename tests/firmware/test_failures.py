"""Failures in the loop: what breaks on a robot at sea reaches the firmware, on every board alike."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.control.mission import Mission
from hypertuna.errors import InputError
from hypertuna.firmware.boards import find_firmware, missing
from hypertuna.firmware.channel import Air, RadioModel
from hypertuna.firmware.failures import Failures, split_faults
from hypertuna.firmware.in_the_loop import FirmwareRun, firmware_in_the_loop
from hypertuna.firmware.scenario import Scenario, find_scenario
from hypertuna.swimming.gait import Gait

Fly = Callable[..., FirmwareRun]


@pytest.fixture(scope="module")
def fly() -> Fly:
    """Firmware on this machine, in the loop with the twin."""
    try:
        find_firmware("hypertuna", "pc")
    except InputError as error:
        pytest.skip(str(error))
    fish = ht.load("hypertuna")
    return lambda scenario, **options: firmware_in_the_loop(fish, scenario, **options)


def faults(run: FirmwareRun) -> list[str]:
    """Faults that the robot ever told."""
    seen = int(np.bitwise_or.reduce(run.answers["faults"]))
    return [row[0] for bit, row in enumerate(_core.fault_table()) if seen >> bit & 1]


def states(run: FirmwareRun) -> set[str]:
    """States that the robot was in."""
    return {_core.state_table()[k][0] for k in np.unique(run.answers["state"])}


AFLOAT = find_scenario("afloat")
NO_STROKE = [row[0] for row in _core.fault_table()].index("no_stroke")


def test_a_reset_boots_the_firmware_again_with_its_memory(fly: Fly) -> None:
    """The tick counts from zero again; after the watchdog's reset the robot says so, after a brown-out not."""
    run = fly(AFLOAT, ticks=500, faults="board:watchdog@2")
    assert len(run.mismatches) == 0
    assert run.ticks == 500 - 30  # it boots for 0.3 s
    tick = run.answers["tick"].astype(int)
    assert np.flatnonzero(np.diff(tick) != 1).tolist() == [199]
    assert tick[200] == tick[0]
    assert "watchdog" in faults(run)
    assert "watchdog" not in faults(fly(AFLOAT, ticks=500, faults="board:brownout@2"))


def test_a_stuck_bus_silences_the_depth_and_makes_ticks_late(fly: Fly) -> None:
    run = fly(AFLOAT, ticks=1000, faults="bus:stuck@4-6")
    assert len(run.mismatches) == 0
    assert run.ticks == 1000 - 100
    assert len(fly(AFLOAT, ticks=400).answers) == 400


def test_a_leak_is_told(fly: Fly) -> None:
    run = fly(AFLOAT, ticks=300, faults="hull:leak@2")
    leak = [row[0] for row in _core.fault_table()].index("leak")
    wet = run.answers["faults"] >> leak & 1
    assert not wet[:200].any()
    assert wet[-1] == 1


@pytest.mark.parametrize("circuit", ["I-left", "I-right", "II-left", "II-right"])
def test_lost_oil_is_no_two_failed_sensors(fly: Fly, circuit: str) -> None:
    """Bend and pressure contradict the model, so both sensors count as faulty; but one side's pressure never rises."""
    gait = find_scenario("gait:unoptimised-max", ht.load("hypertuna"))
    run = fly(gait, ticks=700, faults=f"oil-{circuit}:lost@4")
    told = np.flatnonzero(run.answers["faults"] >> NO_STROKE & 1)
    assert len(run.mismatches) == 0
    assert 400 < told[0] < 700


@pytest.mark.parametrize("fault", ["bend-II:shift@4", "pressure-II-left:clogged@4", "pressure-II-left:shift@4"])
def test_a_failed_sensor_is_no_lost_oil(fly: Fly, fault: str) -> None:
    run = fly(find_scenario("gait:unoptimised-max", ht.load("hypertuna")), ticks=700, faults=fault)
    assert "no_stroke" not in faults(run)


def gait(frequency: float, amplitude: tuple[float, float], bias: tuple[float, float] = (0.0, 0.0)) -> Scenario:
    """Gait with angles in degrees, on a cable."""
    degrees = Gait(frequency, tuple(np.radians(amplitude)), (0.0, 0.8), tuple(np.radians(bias)))
    return Scenario("gait", Mission(()), degrees, cable=True)


@pytest.mark.parametrize(
    ("scenario", "servo"),
    [
        (gait(0.44, (6.4, 10.3), (3.2, 0.3)), "I-left"),
        (gait(1.7, (11.2, 23.1)), "II-left"),
        (gait(2.3, (9.6, 13.8), (2.7, 5.8)), "II-right"),
        (gait(0.98, (3.6, 5.4), (1.1, 1.2)), "I-left"),
    ],
)
def test_a_stuck_servo_is_told_within_six_beats(fly: Fly, scenario: Scenario, servo: str) -> None:
    """It stands near its center or the gait is biased, so half of the bend and all pressures seem sound."""
    assert scenario.gait is not None
    last = 600 + round(600 / scenario.gait.frequency)
    run = fly(scenario, ticks=last, faults=f"servo-{servo}:stuck@6")
    told = run.answers["faults"] >> NO_STROKE & 1
    assert not told[:600].any()
    assert told.any()


@pytest.mark.parametrize(
    ("scenario", "fault"),
    [
        (gait(1.9, (9.0, 8.0)), "bend-II:clogged@4.3"),  # a small beat: without oil, too, pressures would hardly rise
        (gait(6.0, (6.0, 10.6)), "pressure-I-right:clogged@3.4"),
        (gait(0.6, (5.3, 8.7), (0.0, -3.3)), "bend-II:shift@6.6"),
        (gait(3.0, (7.6, 16.8)), "bend-II:drift@3.7"),
        (gait(5.6, (9.6, 14.0), (-3.6, -0.7)), ()),  # the pump draws a vacuum, and water swings the joint
    ],
)
def test_a_sound_servo_is_not_told(fly: Fly, scenario: Scenario, fault: str) -> None:
    assert "no_stroke" not in faults(fly(scenario, ticks=1600, faults=fault))


def test_radio_does_not_pass_water(fly: Fly) -> None:
    """Two meters deep no order reaches the robot, unless a cable leads down."""
    gait = replace(find_scenario("gait:unoptimised-0.3", ht.load("hypertuna")), mission=Mission((), depth=2.0))
    assert "gait" in states(fly(gait, ticks=300))
    assert states(fly(replace(gait, cable=False), ticks=300)) <= {"disarmed", "surface"}  # it comes up by itself


def test_a_deaf_radio_loses_what_is_sent() -> None:
    air = Air(RadioModel(rate=48_000))
    air.deaf = True
    air.write(1, b"arm!", 0.0)
    assert air.read(0, 1.0) == b""
    assert air.counters(1)["lost"] == 1
    air.deaf = False
    air.write(1, b"arm!", 1.0)
    assert air.read(0, 2.0) == b"arm!"


def test_the_ground_reaches_the_robot_by_its_radio(fly: Fly) -> None:
    """A station arms the robot, and its heartbeats hold off the loss of the link; not under water."""
    pytest.importorskip("pymavlink")
    from hypertuna.radio.dialect import dialect

    def station(tick: int, hearts: bool = True) -> bytes:
        link = dialect().MAVLink(None, 255, 190)
        link.seq = tick % 256
        heart = link.heartbeat_encode(6, 8, 0, 0, 4).pack(link) if hearts and tick % 100 == 0 else b""
        arm = link.command_long_encode(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0).pack(link) if tick == 150 else b""
        return bytes(heart + arm)

    silent = replace(AFLOAT, silent=0)  # no contact but by the radio
    heard = fly(silent, ticks=800, station=station)
    assert "rest" in states(heard)
    assert "link_lost" not in faults(heard)
    assert "link_lost" in faults(fly(silent, ticks=800, station=lambda tick: station(tick, hearts=False)))
    deep = fly(replace(silent, cable=False, mission=Mission((), depth=2.0)), ticks=800, station=station)
    assert states(deep) <= {"disarmed", "surface"}


def test_faults_are_parted_between_twin_and_board() -> None:
    sensors, failures = split_faults(["depth:nan@3", "board:brownout@10", "fins:stuck@5", "link:lost@20-80"])
    assert sensors == ("depth:nan@3", "fins:stuck@5")
    assert failures == (("board:brownout", 10, np.inf), ("link:lost", 20, 80))
    one = Failures(failures, 0.01)
    assert (one.has("link:lost", 1999), one.has("link:lost", 2000), one.has("link:lost", 8000)) == (False, True, False)
    assert [tick for tick in range(1100) if one.stopped(tick)] == list(range(1000, 1030))
    assert one.reset(1030) == "brownout"
    assert one.resets == (10,)
    assert split_faults("bus:stuck@3")[0] == ("depth:nan@3",)
    with pytest.raises(InputError, match="must be of a known kind"):
        split_faults("board:burnt@3")


def test_failures_have_the_same_bits_on_an_emulated_board(fly: Fly) -> None:
    if (lack := missing("qemu")) is not None:
        pytest.skip(lack)
    run = fly(AFLOAT, board="qemu", ticks=600, faults=["board:watchdog@2", "bus:stuck@3-4", "hull:leak@5"])
    assert run.ticks == 600 - 30 - 50
    assert len(run.mismatches) == 0
