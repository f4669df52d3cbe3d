"""The firmware's radio over a bad channel: no wrong order is followed, and the loss of the ground has its rule."""

from collections.abc import Iterator

import numpy as np
import pytest

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")

from hypertuna.firmware.channel import Air, RadioModel
from hypertuna.radio.dialect import dialect
from radio.test_channel import GROUND, ROBOT
from radio_bench import TICK, RadioBench, Told

BAD = RadioModel(loss=0.3, burst=4.0, damage=0.1, late=0.1)
MANUAL = 2  # State of firmware/app/vehicle/states.hpp


@pytest.fixture
def bench() -> Iterator[RadioBench]:
    bench = RadioBench()
    yield bench
    bench.close()


class Ground:
    """A ground station in simulated time: it writes frames, and reads what comes."""

    def __init__(self) -> None:
        self.mavlink = dialect()
        self.writer = self.mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self.reader = self.mavlink.MAVLink(None)
        self.reader.robust_parsing = True

    def pack(self, message: object) -> bytes:
        content: bytes = message.pack(self.writer)  # type: ignore[attr-defined]
        self.writer.seq = (self.writer.seq + 1) % 256
        return content

    def heartbeat(self) -> bytes:
        return self.pack(self.mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))

    def command(self, what: int, *values: float) -> bytes:
        numbers = [*values, *[0.0] * (7 - len(values))]
        return self.pack(self.mavlink.MAVLink_command_long_message(1, 1, what, 0, *numbers))

    def parameter(self, name: str, value: float) -> bytes:
        return self.pack(self.mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, 9))

    def hear(self, content: bytes) -> list[str]:
        return [m.get_type() for m in self.reader.parse_buffer(content) or []]


def armed(bench: RadioBench, ground: Ground) -> Told:
    for _ in range(60):
        bench.tick()
    _, told = bench.tick(ground.command(400, 1))
    assert told.armed
    return told


def test_ten_minutes_of_a_bad_channel(bench: RadioBench) -> None:
    """A third of the packets is lost in bursts, a tenth is damaged and a tenth comes late.

    The ground asks for a gait of its own every second, always faster than before, and sets a parameter to a value of
    its own. What the robot follows is one of these, and never an older one than before: nothing is half-written,
    repeated or made up. Every frame that arrived whole is found.
    """
    ground, air = Ground(), Air(BAD, seed=11)
    bench.tick(ground.parameter("snag_distance", 0.0))  # it swims for minutes, and the bench's fixes stay
    armed(bench, ground)
    ticks = int(600 / TICK)
    frames, stream, heard = [], bytearray(), []
    frequency, first, begun = 0.0, 0.7, False
    for k in range(ticks):
        time = k * TICK
        say = b""
        if k % 50 == 0:
            say = ground.heartbeat()
        elif k % 100 == 25:
            say = ground.command(52510, 1 + k / ticks, 5, 5)
        elif k % 100 == 75:
            say = ground.parameter("learning", 0.5 + 0.5 * k / ticks)  # refused: it is armed
        if say:
            frames.append(say)
            air.write(GROUND, say, time)
        came = air.read(ROBOT, time)
        stream += came
        out, told = bench.tick(came)
        air.write(ROBOT, out, time)
        heard += ground.hear(air.read(GROUND, time))
        # The frequency that it follows rises from gait to gait, or is zero while the ground is not heard.
        assert told.armed
        asked = (np.float32(told.frequency) - 1) * ticks
        if told.frequency != 0:
            begun = True
            assert asked == pytest.approx(round(float(asked) / 100 - 0.25) * 100 + 25, abs=0.2)
            assert told.frequency >= frequency - 1e-6
            frequency = told.frequency
        assert told.first == pytest.approx(first)
    whole = sum(stream.count(frame) for frame in set(frames))  # the same bytes come again after 256
    assert begun
    assert told.frames == whole + 2
    assert whole < 0.75 * len(frames)
    assert told.bad > 0
    assert told.replayed > 0
    assert frequency > 1.9
    assert told.max_waiting <= 8
    assert air.counters(ROBOT)["dropped"] == air.counters(GROUND)["dropped"] == 0
    assert heard.count("HEARTBEAT") > 200


def test_the_robot_rests_when_the_ground_falls_silent(bench: RadioBench) -> None:
    """A gait goes on while heartbeats come, ends link_timeout after the last, and begins again with the next."""
    ground = Ground()
    armed(bench, ground)
    bench.tick(ground.command(52510, 2, 5, 5))
    for k in range(1000):
        _, told = bench.tick(ground.heartbeat() if k % 100 == 0 else b"")
        assert told.frequency == 2
    last = None
    for k in range(3000):
        _, told = bench.tick()
        if told.frequency == 0 and last is None:
            last = k
    assert last is not None
    assert 4.0 < last * TICK + 0.99 < 5.1 + 0.99  # 99 ticks since the last heartbeat
    assert told.armed
    for _ in range(3):
        _, told = bench.tick(ground.heartbeat())
    assert told.frequency == 0  # until a gait is ordered again


def test_a_joystick_that_stops_stops_the_tail(bench: RadioBench) -> None:
    """MANUAL_CONTROL holds for manual_timeout, even if other messages arrive."""
    ground = Ground()
    armed(bench, ground)
    stick = ground.mavlink.MAVLink_manual_control_message
    bench.tick(ground.command(176, 1, 100 + MANUAL))
    bench.tick(ground.pack(stick(1, 0, 0, 500, 0, 0)))  # centered first
    for _ in range(50):
        _, told = bench.tick(ground.pack(stick(1, 0, 0, 750, 300, 0)))
    assert told.state == MANUAL
    assert told.frequency > 0
    for k in range(110):
        _, told = bench.tick(ground.heartbeat() if k % 50 == 0 else b"")
    assert told.frequency == 0
    assert told.armed
    bench.tick(ground.pack(stick(1, 0, 0, 750, 300, 0)))
    before = told.refused
    _, told = bench.tick(ground.pack(stick(1, 0, 0, 1001, 0, 0)))
    assert told.refused == before + 1
    _, told = bench.tick(ground.pack(stick(2, 0, 0, 500, 0, 0)))  # another robot's
    assert told.refused == before + 1


def test_telemetry_fits_the_radio() -> None:
    """Two minutes at 4.8 kbit/s: the module's buffer never fills, and every message comes at about its rate."""
    bench, ground, air = RadioBench(), Ground(), Air(RadioModel(), seed=1)
    counts: dict[str, int] = {}
    seconds = 120
    for k in range(int(seconds / TICK)):
        time = k * TICK
        if k % 100 == 0:
            air.write(GROUND, ground.heartbeat(), time)
        out, told = bench.tick(air.read(ROBOT, time))
        air.write(ROBOT, out, time)
        for kind in ground.hear(air.read(GROUND, time)):
            counts[kind] = counts.get(kind, 0) + 1
    bench.close()
    assert air.counters(ROBOT)["dropped"] == 0
    assert air.counters(ROBOT)["max_waiting"] < 300
    assert told.frames > 0.95 * seconds
    rates = {kind: count / seconds for kind, count in counts.items()}
    assert rates["HEARTBEAT"] == pytest.approx(1, rel=0.05)
    assert rates["HYDRAULICS"] > 2.3  # the messages for a map take 6 % of it
    assert rates["ATTITUDE"] > 2
    for kind in ("LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "GAIT", "PILOT", "SERVO_OUTPUT_RAW"):
        assert rates[kind] > 0.25
    for kind in (
        "SYS_STATUS",
        "BATTERY_STATUS",
        "MISSION_CURRENT",
        "GPS_RAW_INT",
        "EXTENDED_SYS_STATE",
        "HOME_POSITION",
    ):
        assert counts[kind] > 3
