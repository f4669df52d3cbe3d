"""Send frames of every message of the dialect to the radio's bench, right and wrong: frames.py [SECONDS] [SEED].

Fields are extremes, chance or what the robot looks for; frames are of both versions, unsigned or signed by a wrong key,
cut, lengthened, damaged, and portioned anywhere. To a signed robot a stranger may change nothing; each robot must obey
its ground in the end. What the robot sends must parse. With PYTHONPATH=tests HYPERTUNA_BENCH=build/firmware/sanitized
it runs what `make test-firmware-sanitized` has built.
"""

import random
import sys
import time
from typing import Any

from radio.test_radio_cpp import Ground, armed
from radio_bench import RadioBench, Told

# Extreme values of floating-point fields
ODD = (0.0, -0.0, 1.0, -1.0, 0.5, 1e-40, 2.0**31, -(2.0**31), 3e38, -3e38, float("inf"), -float("inf"), float("nan"))
# Bytes of integer types
SIZES = {"int8_t": 1, "uint8_t": 1, "char": 1, "int16_t": 2, "uint16_t": 2, "int32_t": 4, "uint32_t": 4}
# Numbers of commands in MAVLink
COMMANDS = (16, 20, 21, 176, 179, 193, 224, 241, 262, 300, 400, 401, 410, 510, 511, 512, 519, 520, 52510, 52511)
# Of parameters, known and unknown
NAMES = (b"learning", b"link_rate", b"snag_distance", b"frequency_max", b"\xff" * 16, b"")
# Values of fields that a frame takes most of the time
EXTREMES = {"command": COMMANDS, "target_system": (0, 1, 1, 1), "target_component": (0, 1), "param_id": NAMES}
TICKS = 1500  # ticks of a session


def field(chance: random.Random, name: str, kind: str, length: int) -> Any:
    """Return a value of a field, or a list of them."""
    if name in EXTREMES and (kind == "char" or not length) and chance.random() < 0.9:
        return chance.choice(EXTREMES[name])
    if kind == "char":
        return bytes(chance.choice((0, 65, 95, 255, chance.randrange(256))) for _ in range(max(length, 1)))
    if kind in ("float", "double"):
        values = [chance.choice((*ODD, chance.uniform(-100, 100))) for _ in range(max(length, 1))]
    else:
        bits = 8 * SIZES.get(kind, 8)
        low = 0 if kind.startswith("u") else -(1 << bits - 1)
        high = low + (1 << bits) - 1
        values = [chance.choice((low, high, 0, 1, 9, chance.randint(low, high))) for _ in range(max(length, 1))]
    return values if length else values[0]


def frame(chance: random.Random, ground: Ground, kinds: list[Any]) -> bytes:
    """Return a frame of a random kind: valid, or damaged in one of five ways."""
    kind, writer = chance.choice(kinds), ground.writer
    while "target_system" not in kind.fieldnames and chance.random() < 0.8:  # what a robot listens to
        kind = chance.choice(kinds)
    given = zip(kind.fieldnames, kind.fieldtypes, (kind.array_lengths[k] for k in order(kind)), strict=True)
    message = kind(*(field(chance, *one) for one in given))
    writer.srcSystem, writer.srcComponent = chance.choice(((255, 190), (51, 68), (1, 1), (0, 0), (7, 7)))
    content = bytearray(message.pack(writer, force_mavlink1=kind.id < 256 and chance.random() < 0.1))
    writer.seq = chance.randrange(256)
    damage = chance.randrange(12)
    if damage == 0:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    elif damage == 1:
        content = content[: chance.randrange(len(content))]
    elif damage == 2:
        content[1] = chance.randrange(256)
    elif damage == 3:
        content += chance.randbytes(chance.randrange(300))
    elif damage == 4:
        content = bytearray((0xFD, 255)) + content
    return bytes(content)


def order(kind: Any) -> list[int]:
    """Return each field's place on the wire, in the order in which the message lists its fields."""
    return [kind.ordered_fieldnames.index(name) for name in kind.fieldnames]


def session(seed: int, counts: dict[str, int]) -> None:
    """Arm a robot, send it frames, and ask it to disarm."""
    chance, bench, ground, stranger = random.Random(seed), RadioBench(), Ground(), Ground()
    mavlink, signed = ground.mavlink, seed % 2 == 1
    kinds = [kind for kind in mavlink.mavlink_map.values() if signed or kind.id != mavlink.MAVLINK_MSG_ID_SETUP_SIGNING]
    if signed:
        bench.tick(ground.pack(mavlink.MAVLink_setup_signing_message(1, 1, list(range(32)), 1_000_000)))
        for one, key in ((ground, bytes(range(32))), (stranger, bytes(32))):
            signing = one.writer.signing
            signing.secret_key, signing.sign_outgoing, signing.timestamp = key, True, 2_000_000
    before, waiting = armed(bench, ground), b""
    for _ in range(TICKS):
        for _ in range(chance.randrange(4)):
            stranger.writer.signing.sign_outgoing = signed and chance.random() < 0.5
            waiting += frame(chance, stranger, kinds)
            counts["frames"] += 1
        cut = chance.randrange(len(waiting) + 1) if chance.random() < 0.8 else len(waiting)
        now, waiting = waiting[:cut][:2000], waiting[:cut][2000:] + waiting[cut:]
        check(bench.tick(now), ground, before if signed else None)
    for _ in range(300):
        bench.tick()
    ground.writer.srcSystem, ground.writer.seq = 255, 100
    bench.tick(ground.command(400, 0))
    for _ in range(100):
        _, told = bench.tick()
    assert not told.armed, f"seed {seed}: does not disarm"
    counts["found"] += told.frames
    bench.close()
    assert bench._process.returncode == 0


def check(answer: tuple[bytes, Told], ground: Ground, before: Told | None) -> None:
    """Check what a robot sends and does in a tick, and that its state is still that `before`, if given."""
    said, told = answer
    assert 0 <= told.frequency <= 8
    assert "BAD_DATA" not in ground.hear(said)
    if before is not None:
        same = ("commands", "armed", "state", "frequency", "amplitude", "first", "waypoints")
        assert all(getattr(told, name) == getattr(before, name) for name in same), (before, told)


if __name__ == "__main__":
    seconds, seed = map(int, (*sys.argv[1:], *("600", "1")[len(sys.argv) - 1 :]))
    end, counts, sessions = time.monotonic() + seconds, {"frames": 0, "found": 0}, 0
    while time.monotonic() < end:
        session(seed + sessions, counts)
        sessions += 1
    print(f"{sessions} sessions of {TICKS} ticks: {counts['frames']} frames sent, {counts['found']} valid ones found")
