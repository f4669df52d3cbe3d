"""Sessions of MAVSDK, MAVProxy, pymavlink and node-mavlink with the firmware in the loop, on the PC and emulated."""

import pytest

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")

from sessions import BOARDS, CLIENTS, absent, session

from radio_bench import free_port, in_the_loop

# What a complete transcript of each client contains
LAST = {"mavsdk": "cleared", "mavproxy": "TYPE_FENCE: ACCEPTED", "pymavlink": "cleared", "node": "cleared"}


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("client", CLIENTS)
def test_session(client: str, board: str) -> None:
    """Connect, parameters, fence and mission up and down, arm, start, pause, return, surface, disarm."""
    if reason := absent(client):
        pytest.skip(reason)
    port = free_port()
    with in_the_loop(board, port):
        code, transcript = session(client, f"udp:{port}" if board == "pc" else f"tcp:127.0.0.1:{port}")
    print(transcript)
    assert code == 0, transcript
    assert LAST[client] in transcript
