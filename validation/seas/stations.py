"""Ground stations that a robot at sea hears by MAVLink besides its own: a second one, a joystick that nobody holds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hypertuna.firmware.lockstep import RADIO
from hypertuna.radio.dialect import dialect

IDS = (255, 190)  # system and component of a ground station, QGroundControl's and our client's
TICKS = 100  # per second


def station_of(kind: str, start: float, seed: int) -> Callable[[int], bytes] | None:
    """Return the function of a tick's bytes that a failure's station sends to the robot; None without a station."""
    if kind not in ("station:second", "stick:noise"):
        return None
    link, random, waiting = dialect().MAVLink(None, *IDS), np.random.default_rng(seed), bytearray()
    center = random.normal(0, 60, 4)  # where the uncentered stick rests, of 1000

    def send(tick: int) -> bytes:
        since = tick - round(start * TICKS)
        if since >= 0 and since % TICKS == 0:
            waiting.extend(link.heartbeat_encode(6, 8, 0, 0, 4).pack(link))
        if since >= 0 and since % (TICKS // 10) == 5:
            noise = random.normal(0, 30, 4) + center if kind == "stick:noise" else np.zeros(4)
            x, y, r, z = (int(value) for value in np.clip(noise + np.array([0, 0, 0, 500]), -1000, 1000))
            waiting.extend(link.manual_control_encode(1, x, y, z, r, 0).pack(link))
        sent = bytes(waiting[:RADIO])
        del waiting[:RADIO]
        return sent

    return send
