"""Model of two LoRa modules in transparent mode, which carry bytes in packets over one shared channel.

One module transmits at a time. Bytes wait in a module's buffer; packets take airtime, and are lost, damaged or
reordered at random from a seed, in simulated time.
"""

import heapq
from dataclasses import dataclass, field

import numpy as np

from hypertuna.ranges import POSITIVE, Range

SIDES = 2  # 0: robot, 1: ground
COUNTS = ("sent", "lost", "damaged", "dropped", "max_waiting")  # counters of packets; the last two count bytes


@dataclass(frozen=True)
class RadioModel:
    """Parameters of a pair of LoRa modules and their channel."""

    rate: float = 4800.0  # data rate on the air [bit/s]
    packet: int = 58  # maximum payload of a packet [bytes]
    overhead: int = 12  # preamble, header and checksum of a packet [bytes]
    gap: float = 0.005  # pause of the writer after which an incomplete packet is sent [s]
    turn: float = 0.01  # from the end of a packet to the start of the next [s]
    latency: float = 0.02  # from the end of a packet to its bytes at the other end [s]
    buffer: int = 512  # capacity [bytes]; further bytes are dropped
    loss: float = 0.0  # fraction of packets lost
    burst: float = 1.0  # mean length of consecutive losses [packets]; above 1: bursts (Gilbert, 1960)
    damage: float = 0.0  # fraction of packets with flipped bits
    late: float = 0.0  # fraction of packets that arrive after the sender's next

    def __post_init__(self) -> None:
        for name in ("rate", "packet", "buffer"):
            POSITIVE.check(getattr(self, name), name, "give a positive number")
        for name in ("loss", "damage", "late"):
            Range(min=0, below=1).check(getattr(self, name), name, "give a fraction of the packets")
        Range(min=1).check(self.burst, "burst", "give a number of packets")

    def airtime(self, payload: int) -> float:
        """Return the airtime of a packet [s]."""
        return 8 * (payload + self.overhead) / self.rate


@dataclass
class _Module:
    """One module: waiting bytes, time of the last write, state of the burst, counters."""

    waiting: bytearray = field(default_factory=bytearray)
    written: float = 0.0
    fading: bool = False  # whether it is in a burst of losses
    held: tuple[float, bytes] | None = None  # arrival [s] and content of a late packet, which the next one overtakes
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COUNTS, 0))


class Air:
    """Two modules and the channel between them."""

    def __init__(self, model: RadioModel, *, seed: int = 0) -> None:
        self.model = model
        self._random = np.random.default_rng(seed)
        self._modules = tuple(_Module() for _ in range(SIDES))
        self._free = 0.0  # s: the channel is free from this time
        self._last = 0  # the last sender: the other module has priority
        # Packets on their way to each side: arrival [s], number and content.
        self._coming: tuple[list[tuple[float, int, bytes]], ...] = ([], [])
        self._count = 0  # packets delivered
        self.deaf = False  # whether the robot's antenna is under water: all packets are lost

    def write(self, side: int, content: bytes, time: float) -> None:
        """Write bytes to a module at `time` [s], which never decreases."""
        self._advance(time)
        if not content:
            return
        module = self._modules[side]
        capacity_left = self.model.buffer - len(module.waiting)
        module.counts["dropped"] += max(0, len(content) - capacity_left)
        module.waiting += content[:capacity_left]
        module.written = time
        module.counts["max_waiting"] = max(module.counts["max_waiting"], len(module.waiting))

    def read(self, side: int, time: float) -> bytes:
        """Return the bytes that have arrived at a module by `time` [s]."""
        self._advance(time)
        received, arrivals = bytearray(), self._coming[side]
        while arrivals and arrivals[0][0] <= time:
            received += heapq.heappop(arrivals)[2]
        return bytes(received)

    def counters(self, side: int) -> dict[str, int]:
        """Return the counters of a module, by `COUNTS`."""
        return dict(self._modules[side].counts)

    def _ready(self, side: int) -> float:
        """Return the time from which a module is ready to send [s]; infinite for never."""
        module = self._modules[side]
        if not module.waiting:
            return float("inf")
        full = len(module.waiting) >= self.model.packet
        return module.written + (0.0 if full else self.model.gap)

    def _advance(self, time: float) -> None:
        """Send every packet that starts by `time` [s]."""
        while True:
            ready = [self._ready(side) for side in range(SIDES)]
            starts = [max(ready_at, self._free) for ready_at in ready]
            other = 1 - self._last
            side = other if starts[other] <= starts[self._last] else self._last
            if not starts[side] <= time:
                return
            module = self._modules[side]
            content = bytes(module.waiting[: self.model.packet])
            del module.waiting[: self.model.packet]
            end = starts[side] + self.model.airtime(len(content))
            self._free, self._last = end + self.model.turn, side
            self._carry(side, content, end + self.model.latency)

    def _carry(self, side: int, content: bytes, arrival: float) -> None:
        """Lose, damage or delay a packet, or deliver it."""
        module, model = self._modules[side], self.model
        module.counts["sent"] += 1
        # Gilbert's two states: mean burst length as given, and the same fraction of losses as without bursts.
        p_end = 1 / model.burst
        p_begin = p_end * model.loss / (1 - model.loss) if model.burst > 1 else model.loss
        in_burst = model.burst > 1 and module.fading
        module.fading = self._random.uniform() < ((1 - p_end) if in_burst else p_begin)
        damaged, late = self._random.uniform(size=2) < (model.damage, model.late)
        if module.fading or self.deaf:
            module.counts["lost"] += 1
        else:
            if damaged:
                module.counts["damaged"] += 1
                bits = np.unpackbits(np.frombuffer(content, dtype=np.uint8))
                flips = min(len(bits), int(self._random.integers(1, 9)))
                bits[self._random.choice(len(bits), size=flips, replace=False)] ^= 1
                content = np.packbits(bits).tobytes()
            if late and module.held is None:
                module.held = (arrival, content)
                return
            self._deliver(1 - side, content, arrival)
        if module.held is not None:
            overtaken, module.held = module.held[1], None
            self._deliver(1 - side, overtaken, arrival)

    def _deliver(self, side: int, content: bytes, time: float) -> None:
        self._count += 1
        heapq.heappush(self._coming[side], (time, self._count, content))
