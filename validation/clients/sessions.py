"""Run the sessions of real clients against the firmware in the loop, on either board, and keep their transcripts.

`python validation/clients/sessions.py [CLIENT ...]` writes transcripts/CLIENT-BOARD.txt.
"""

import importlib.metadata
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).parent
CLIENTS, BOARDS = ("mavsdk", "mavproxy", "pymavlink", "node"), ("pc", "qemu")
PATIENCE = 300.0  # s, that a session may take on a busy machine
NODE = ("node-mavlink", "npm ci --prefix validation/clients")  # npm package, and the command that installs it
PACKAGES = {"mavsdk": "mavsdk", "mavproxy": "MAVProxy", "pymavlink": "pymavlink"}  # Python package of each client
NOISE = re.compile(
    r"(Debug|Info |Warn )\]|^\s*$|Log Directory|Telemetry log|t=\w+ \w+ +\d+|Saved .* to |/tmp/"
)  # times and folders


def absent(client: str) -> str:
    """Return why a client cannot run; empty if it can."""
    if client == "node":
        if shutil.which("node") is None:
            return "Node.js is not installed"
        return "" if (HERE / "node_modules" / NODE[0]).is_dir() else f"{NODE[0]} is not installed: {NODE[1]}"
    name = PACKAGES[client]
    try:
        importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return f"{name} is not installed: pip install {name}"
    return ""


def version(client: str) -> str:
    """Return name and version of a client."""
    if client == "node":
        package = json.loads((HERE / "node_modules" / NODE[0] / "package.json").read_text())
        return f"{NODE[0]} {package['version']}"
    return f"{PACKAGES[client]} {importlib.metadata.version(PACKAGES[client])}"


def session(client: str, address: str) -> tuple[int, str]:
    """Run a session; return its exit code and transcript."""
    program = (
        ["node", HERE / "node_session.mjs"] if client == "node" else [sys.executable, HERE / f"{client}_session.py"]
    )
    done = subprocess.run(
        [*program, address],
        capture_output=True,
        text=True,
        errors="replace",
        timeout=PATIENCE,
        check=False,
        env=os.environ | {"PYTHONWARNINGS": "ignore", "PYTHONUNBUFFERED": "1"},
    )
    return done.returncode, done.stdout + done.stderr


def clean(transcript: str, address: str) -> str:
    """Drop colors, times, folders and the address, which differ from run to run."""
    text = re.sub(r"\x1b\[[0-9;]*m", "", transcript).replace(address.rpartition(":")[2], "PORT")
    return "\n".join(line.rstrip() for line in text.splitlines() if not NOISE.search(line)) + "\n"


def main(clients: Sequence[str]) -> None:
    sys.path.insert(0, str(HERE.parents[1] / "tests"))
    from radio_bench import free_port, in_the_loop

    folder = HERE / "transcripts"
    for client in clients:
        if reason := absent(client):
            print(f"{client}: {reason}")
            continue
        for board in BOARDS:
            port = free_port()
            address = f"udp:{port}" if board == "pc" else f"tcp:127.0.0.1:{port}"
            with in_the_loop(board, port):
                code, transcript = session(client, address)
            print(f"{client}, {board}: exit code {code}")
            head = (
                f"{version(client)}, firmware on {board} beside the twin: {Path(__file__).name}, exit code {code}\n\n"
            )
            folder.mkdir(exist_ok=True)
            path = folder / f"{client}-{board}.txt"
            path.write_text(head + clean(transcript, address), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:] or CLIENTS)
