"""The model of the radio against numbers that a pencil gives."""

import numpy as np
import pytest

from hypertuna.errors import InputError
from hypertuna.firmware.channel import Air, RadioModel

ROBOT, GROUND = 0, 1


def test_a_packet_takes_its_time() -> None:
    """10 bytes and 12 of overhead at 4800 bit/s: 36.7 ms, after the gap of 5 ms and before 20 ms of latency."""
    air = Air(RadioModel())
    air.write(ROBOT, bytes(10), 1.0)
    arrival = 1.0 + 0.005 + 8 * 22 / 4800 + 0.02
    assert air.read(GROUND, arrival - 1e-6) == b""
    assert air.read(GROUND, arrival + 1e-6) == bytes(10)


def test_the_channel_carries_one_at_a_time_and_takes_turns() -> None:
    """Both always want to send: each gets half of what full packets carry, less the turns."""
    model = RadioModel()
    air = Air(model)
    got, end = [0, 0], 60.0
    for time in np.arange(0, end, 0.01):
        for side in (ROBOT, GROUND):
            got[side] += len(air.read(side, time))
            air.write(side, bytes(20), time)
    each = end / (2 * (model.airtime(58) + model.turn)) * 58
    assert got == pytest.approx([each, each], rel=0.02)
    assert air.counters(ROBOT)["max_waiting"] == 512
    assert air.counters(ROBOT)["dropped"] > 0


def test_no_byte_is_lost_or_reordered_on_a_good_channel() -> None:
    random = np.random.default_rng(1)
    air, sent, got = Air(RadioModel()), b"", b""
    for time in np.arange(0, 30, 0.01):
        chunk = random.bytes(int(random.integers(0, 6)))
        sent += chunk
        air.write(GROUND, chunk, time)
        got += air.read(ROBOT, time)
    assert got + air.read(ROBOT, 100.0) == sent


@pytest.mark.parametrize("burst", [1.0, 5.0])
def test_losses_have_the_part_and_the_length_that_were_asked_for(burst: float) -> None:
    air = Air(RadioModel(loss=0.3, burst=burst, rate=1e6, packet=1, buffer=10**6), seed=3)
    count = 20_000
    losses = []
    for k in range(count):
        before = air.counters(ROBOT)["lost"]
        air.write(ROBOT, b"x", k * 0.1)
        air.read(GROUND, k * 0.1 + 0.09)
        losses.append(air.counters(ROBOT)["lost"] - before)
    assert np.mean(losses) == pytest.approx(0.3, abs=0.03)
    starts = np.sum(np.diff([0, *losses]) == 1)
    expected = burst if burst > 1 else 1 / 0.7  # by chance alone a loss is followed by another with 0.3
    assert np.sum(losses) / starts == pytest.approx(expected, rel=0.1)


def test_damage_flips_bits_and_late_packets_come_behind_the_next() -> None:
    air = Air(RadioModel(damage=0.5, late=0.2, packet=8), seed=5)
    got = b""
    for k in range(400):
        air.write(ROBOT, bytes([k % 256] * 8), k * 0.1)
        got += air.read(GROUND, k * 0.1)
    got += air.read(GROUND, 1000.0)
    packets = [got[k : k + 8] for k in range(0, len(got), 8)]
    whole = [packet[0] for packet in packets if len(set(packet)) == 1]
    assert len(whole) < len(packets)
    assert any(np.diff(np.array(whole[:50], dtype=int)) < 0)


def test_the_same_seed_gives_the_same_air() -> None:
    def run(seed: int) -> bytes:
        air, got = Air(RadioModel(loss=0.3, damage=0.1, late=0.1), seed=seed), b""
        for k in range(300):
            air.write(ROBOT, bytes([k % 256] * 5), k * 0.02)
            got += air.read(GROUND, k * 0.02)
        return got

    assert run(1) == run(1) != run(2)


@pytest.mark.parametrize("bad", [{"rate": 0}, {"loss": 1.0}, {"damage": -0.1}, {"burst": 0.5}, {"packet": 0}])
def test_nonsense_is_refused(bad: dict[str, float]) -> None:
    with pytest.raises(InputError, match="must be"):
        RadioModel(**bad)
