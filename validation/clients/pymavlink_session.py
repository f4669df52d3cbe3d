"""A session of pymavlink with its common dialect: `pymavlink_session.py udp:PORT | tcp:HOST:PORT`. It prints what it
asks for and what it gets."""

import math
import os
import sys
import time
from typing import Any

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil

PATIENCE = 60.0  # s, that an answer may take
WIRE = 115200.0  # bit/s of the serial line
BASE = 100  # custom mode of the state `disarmed`
MISSION, FENCE = 0, 1  # kinds of lists of points, as MAVLink numbers them
# Robot's states, in the order of their custom modes
STATES = ("disarmed", "rest", "manual", "gait", "mission", "paused", "home", "surface", "held")


class Session:
    """Connection to a robot, which prints what it asks for and what it gets."""

    def __init__(self, address: str) -> None:
        kind, _, place = address.partition(":")
        self.line = mavutil.mavlink_connection(f"udpin:127.0.0.1:{place}" if kind == "udp" else f"tcp:{place}")
        heart = self.line.wait_heartbeat(timeout=PATIENCE)
        assert heart is not None
        print(
            f"heartbeat of system {heart.get_srcSystem()}, type {heart.type}, mode {STATES[heart.custom_mode - BASE]}"
        )
        self.mav = self.line.mav

    def wait(self, kind: str, **fields: Any) -> Any:
        end, beat = time.monotonic() + PATIENCE, 0.0
        while time.monotonic() < end:
            if time.monotonic() - beat > 1:
                beat = time.monotonic()
                self.mav.heartbeat_send(6, 8, 0, 0, 0)
            m = self.line.recv_match(type=[kind, "STATUSTEXT"], blocking=True, timeout=0.5)
            if m is not None and m.get_type() == "STATUSTEXT":
                print(f"    says: {m.text}")
            elif m is not None and all(getattr(m, name) == value for name, value in fields.items()):
                return m
        raise SystemExit(f"no {kind} with {fields} in {PATIENCE:g} s")

    def command(self, name: str, what: int, *values: float, result: int = 0) -> None:
        """Send a command, again while the robot is busy."""
        end = time.monotonic() + PATIENCE
        while True:
            self.mav.command_long_send(1, 1, what, 0, *values, *[0.0] * (7 - len(values)))
            ack = self.wait("COMMAND_ACK", command=what)
            if ack.result == result or end < time.monotonic():
                break
            time.sleep(0.5)
        print(f"{name}: result {ack.result}")
        assert ack.result == result

    def mode(self, expected: str) -> None:
        """Check the mode of the next heartbeat."""
        heart = self.wait("HEARTBEAT")
        mode = f"{STATES[heart.custom_mode - BASE]}, {'armed' if heart.base_mode & 128 else 'disarmed'}"
        print(f"    {mode}")
        assert mode == expected

    def upload(self, kind: int, items: list[tuple[Any, ...]]) -> int:
        """Upload a list; return the result."""
        self.mav.mission_count_send(1, 1, len(items), kind)
        while True:
            m = self.line.recv_match(
                type=["MISSION_REQUEST_INT", "MISSION_ACK", "STATUSTEXT"], blocking=True, timeout=PATIENCE
            )
            assert m is not None
            if m.get_type() == "STATUSTEXT":
                print(f"    says: {m.text}")
            elif m.mission_type != kind:  # of a list before, answered twice on a slow line
                continue
            elif m.get_type() == "MISSION_ACK":
                return int(m.type)
            else:
                frame, command, p1, p2, p3, p4, x, y, z = items[m.seq]
                self.mav.mission_item_int_send(1, 1, m.seq, frame, command, 0, 1, p1, p2, p3, p4, x, y, z, kind)

    def download(self, kind: int) -> list[tuple[Any, ...]]:
        """Download a list."""
        self.mav.mission_request_list_send(1, 1, kind)
        items = []
        for k in range(self.wait("MISSION_COUNT", mission_type=kind).count):
            self.mav.mission_request_int_send(1, 1, k, kind)
            m = self.wait("MISSION_ITEM_INT", seq=k, mission_type=kind)
            items.append((m.frame, m.command, m.param1, m.param2, m.param3, m.param4, m.x, m.y, m.z))
        self.mav.mission_ack_send(1, 1, 0, kind)
        return items

    def round_trip(self, name: str, kind: int, items: list[tuple[Any, ...]]) -> None:
        """Upload a list, download it, and compare."""
        assert self.upload(kind, items) == 0
        found = self.download(kind)
        for a, b in zip(items, found, strict=True):
            assert all(x == y or math.isclose(x, y, rel_tol=1e-6) or x != x != y for x, y in zip(a, b, strict=True)), (
                a,
                b,
            )
        print(f"{name}: {len(found)} items up and down, the same")


def main(address: str) -> None:
    s = Session(address)
    s.mav.param_set_send(1, 1, b"LINK_RATE", WIRE, 9)
    s.wait("PARAM_VALUE", param_id="LINK_RATE")
    s.mav.param_request_list_send(1, 1)
    count = s.wait("PARAM_VALUE", param_index=0).param_count
    s.wait("PARAM_VALUE", param_index=count - 1)
    s.mav.param_set_send(1, 1, b"LEARNING", 0.25, 9)
    print(f"{count} parameters, LEARNING = {s.wait('PARAM_VALUE', param_id='LEARNING').param_value:g}")
    position = s.wait("GLOBAL_POSITION_INT")
    print(f"position {position.lat / 1e7:.6f} {position.lon / 1e7:.6f}, {position.relative_alt / 1e3:.2f} m")
    s.command("modes", 512, 435, 0)
    print("modes:", ", ".join(STATES[k] for k in range(1, 8)), "at", BASE + 1)
    lat, lon, far, nan = position.lat, position.lon, 4000, math.nan
    corners = ((-far, -far), (-far, far), (far, far), (far, -far))
    s.round_trip("fence", FENCE, [(0, 5001, 4.0, 0.0, 0.0, 0.0, lat + n, lon + e, 0.0) for n, e in corners])
    unsupported = s.upload(FENCE, [(0, 5004, 5.0, 0.0, 0.0, 0.0, lat, lon, 0.0)])
    print(f"exclusion: result {unsupported}")
    assert unsupported == 3
    mission: list[tuple[Any, ...]] = [(2, 178, 1.0, 0.3, -1.0, 0.0, 0, 0, 0.0)]
    for north, east, altitude in ((1000, 0, -0.5), (1000, 1000, -1.0), (0, 1000, -0.5)):
        mission.append((6, 16, 5.0, 3.0, 0.0, nan, lat + north, lon + east, altitude))
    s.round_trip("mission", MISSION, [*mission, (2, 20, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)])
    s.mav.command_int_send(1, 1, 0, 179, 0, 0, 0, 0, 0, nan, lat + 500, lon, 0)
    print(f"home at coordinates: result {s.wait('COMMAND_ACK', command=179).result}")
    print(f"    {(s.wait('HOME_POSITION').latitude - lat) * 0.0111:.1f} m north of the first position")
    s.command("home here", 179, 1)
    s.command("compass, by the command of ArduPilot", 42424, result=2)
    s.command("checks before arming", 401)
    s.command("mode 2, another autopilot's ALT_HOLD", 176, 1, 2, result=3)
    s.command("arm", 400, 1)
    s.command("start", 300)
    s.mode("mission, armed")
    s.command("pause", 193, 0)
    s.mode("paused, armed")
    s.command("item 2", 224, 2)
    s.command("continue", 193, 1)
    s.command("return", 20)
    s.mode("home, armed")
    s.command("surface", 21)
    s.command("mode manual", 176, 1, BASE + 2)
    for _ in range(5):
        s.mav.manual_control_send(1, 0, 0, 500, 0, 0)
        time.sleep(0.05)
    s.mode("manual, armed")
    s.command("disarm", 400, 0)
    s.mode("rest, disarmed")
    for kind in (MISSION, FENCE, 2):
        s.mav.mission_clear_all_send(1, 1, kind)
        assert s.wait("MISSION_ACK", mission_type=kind).type == 0
    print("mission, fence and rally points cleared")


if __name__ == "__main__":
    main(sys.argv[1])
