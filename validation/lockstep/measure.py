"""Firmware in lock-step on the emulated Cortex-M7: differing ticks, instructions, stack and sizes of three robots.

python validation/lockstep/measure.py           # runs everything, and writes lockstep.json: tables of docs/firmware.md
python validation/lockstep/measure.py hypertuna # one robot alone
"""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import hypertuna as ht
from hypertuna.firmware.boards import find_firmware
from hypertuna.firmware.in_the_loop import FirmwareRun, firmware_in_the_loop
from hypertuna.firmware.parameters import firmware_table
from hypertuna.firmware.scenario import find_scenario
from hypertuna.io.files import write_atomically
from hypertuna.mission.file import read_mission
from hypertuna.mission.upload import upload
from hypertuna.radio.client import connect
from hypertuna.radio.parameters import set_parameter
from hypertuna.swimming.gait import named_gait

ROOT = Path(__file__).resolve().parents[2]
STORED = Path(__file__).with_name("lockstep.json")
BUILT = ROOT / "build" / "lockstep"  # the files of the robots that `robot new` writes
SIZE = ("--sea", "--links", "4", "--length", "0.5", "--force")  # options that two robots share
ROBOTS: dict[str, tuple[str, ...]] = {  # options of `robot new`; none for HyperTuna
    "hypertuna": (),
    "oil-of-three": ("--actuation", "hydraulic", *SIZE),
    "axles-of-three": ("--actuation", "servo", *SIZE),
}
GAITS = {"hypertuna": "unoptimised-0.3"}  # the others': cruise
PARTS = ("controller", "pilot", "radio", "whole")  # of a tick, whose instructions are counted


def runs(name: str) -> dict[str, tuple[str, int | None]]:
    """Return scenario and ticks of each run; no ticks where it lasts until its mission ends."""
    gait = GAITS.get(name, "cruise")
    on_the_twin = {f"gait `{gait}` on the twin": (f"gait:{gait}", 3000)}
    if name == "hypertuna":
        on_the_twin |= {"the same, `lost` at 3 m": (f"lost:{gait}", None), "mission `box`": ("box", None)}
    return {"random messages": ("random", 100_000)} | on_the_twin


def built(name: str) -> ht.Robot:
    """Build the firmware of a robot for both boards, and return the robot."""
    options, make = ROBOTS[name], ("make", "-s", "firmware", f"ROBOT={name}")
    if not options:
        subprocess.run(make, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        return ht.load(name)
    BUILT.mkdir(parents=True, exist_ok=True)
    file, header = BUILT / f"{name}.toml", ROOT / "firmware" / "robots" / f"{name}.hpp"
    hypertuna = (sys.executable, "-m", "hypertuna")
    subprocess.run((*hypertuna, "robot", "new", file, *options), check=True, stdout=subprocess.DEVNULL)
    try:
        subprocess.run((*hypertuna, "firmware", "params", "--robot", file, "-o", header), check=True)
        subprocess.run(make, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    finally:
        header.unlink(missing_ok=True)
    return ht.load(str(file))


def sizes(robot: ht.Robot) -> dict[str, int]:
    """Return the sizes of the firmware's build: numbers of the robot, parameters, bytes."""
    table = firmware_table(robot)
    printed = subprocess.run(
        ("arm-none-eabi-size", find_firmware(robot.name, "qemu")), capture_output=True, text=True, check=True
    )
    text, data, zeroed = (int(word) for word in printed.stdout.split()[6:9])
    return {
        "joints": len(robot.joints),
        "numbers": len(table.values),
        "parameters": len(table.parameters),
        "text": text,
        "data": data + zeroed,
    }


def row(run: FirmwareRun) -> dict[str, Any]:
    """Return a run's row of the table."""
    return {
        "ticks": run.ticks,
        "differ": len(run.mismatches) if run.compared else None,
        "status": run.status,
        "stack": int(run.answers["stack"].max()),
    } | {part: round(run.instructions(part) or 0) for part in PARTS}


def session(robot: ht.Robot) -> dict[str, Any]:
    """Run a session at the serial port: store parameters and a mission, swim a gait, disarm."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with ThreadPoolExecutor(1) as pool:
        flight = pool.submit(
            firmware_in_the_loop, robot, find_scenario("afloat"), board="qemu", ticks=4000, radio=port, real_time=True
        )
        with connect(f"tcp:127.0.0.1:{port}", patience=60) as client:
            set_parameter(client, "link_rate", 57600.0)
            upload(client, read_mission("box").mission)
            client.arm()
            client.gait(named_gait(robot, GAITS.get(robot.name, "cruise")))
            client.arm(False)
        return row(flight.result())


def main(names: list[str]) -> None:
    """Measure, and store each run."""
    stored = json.loads(STORED.read_text()) if STORED.exists() else {}
    for name in names or list(ROBOTS):
        robot = built(name)
        stored[name] = {"sizes": sizes(robot), "runs": {}}

        def store(label: str, found: dict[str, Any], of: str = name) -> None:
            stored[of]["runs"][label] = found
            print(of, label, found, flush=True)
            write_atomically(STORED, (json.dumps(stored, indent=1) + "\n").encode())

        for label, (scenario, ticks) in runs(name).items():
            run = firmware_in_the_loop(robot, find_scenario(scenario, robot), board="qemu", ticks=ticks, seed=1)
            store(label, row(run))
        if name == "hypertuna":
            store("a client at the serial port", session(robot))


if __name__ == "__main__":
    main(sys.argv[1:])
