"""Store what the ledger tells of finite elements: bends of both joints, pictures, and with --map maps.

    python validation/fe/ledger.py                 # compute, and write data/fe; one core, minutes for each joint
    python validation/fe/ledger.py --check         # compute, and compare with data/fe
    python validation/fe/ledger.py --map           # small maps over pressures and couples instead; minutes each

Work that was interrupted goes on in build/fe: remove that after a change of the code. Needs the extra `fe`.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.description.robot import load
from hypertuna.fe.pictures import write_filmstrip
from hypertuna.io.files import write_atomically
from hypertuna.paper.chapters.finite_elements import ROBOT, command, joint_hash

ROOT = Path(__file__).resolve().parents[2]
STORE = ROOT / "data" / "fe"
WORK = ROOT / "build" / "fe"  # folder for pictures and states
CLOSE = 1e-3  # largest difference on another machine or version, over the largest bend
MAPS = {  # options of `hypertuna fe map`, for the maps of each joint: both sides as the twin has them, up to its limit
    "I": ["--pressure 130,250,440 --moment 0", "--pressure 250 --moment -0.4"],
    "II": ["--pressure 130,180,220,320,440 --moment 0", "--pressure 250,440 --moment -0.1,0.1"],
}


def computed(line: list[str], joint: str, *extra: str) -> dict[str, Any]:
    """Run a command; return the JSON that it printed, with the command, its memory and the joint's hash."""
    process = subprocess.Popen([sys.executable, "-m", "hypertuna", *line, *extra], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    said = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{' '.join(line)} failed")
    record: dict[str, Any] = json.loads(said)
    facts = {"command": f"hypertuna {' '.join(line)}", "memory_gb": usage.ru_maxrss * 1024 / 1e9}
    return record | facts | {"joint_hash": joint_hash(load(ROBOT), joint)}


def rounded(value: Any) -> Any:
    """Round all numbers to six digits, so that the file is readable and not falsely precise."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    return [rounded(part) for part in value] if isinstance(value, list) else value


def apart(record: dict[str, Any], path: Path) -> float:
    """Return the largest difference of bends from the stored ones, over the largest stored bend."""
    bends = [[step["bend_deg"] for step in one["steps"]] for one in (record, json.loads(path.read_text()))]
    return float(np.abs(np.subtract(*bends)).max() / np.max(bends[1]))


def main() -> None:
    """Compute; store or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare with what is stored")
    parser.add_argument("--map", action="store_true", help="maps instead of bends")
    parser.add_argument("--joint", help="of one joint only")
    given = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    joints = [group.name for group in load(ROBOT).joints if given.joint in (None, group.name)]
    if given.map:
        for joint, (number, options) in [(name, one) for name in joints for one in enumerate(MAPS[name])]:
            name = f"{ROBOT}-{joint}-map-{number}"
            line = ["fe", "map", "--robot", ROBOT, "--joint", joint, *options.split(), "--json"]
            record = computed(line, joint, "--checkpoint", str(WORK / f"{name}.journal"))
            print(f"{name}: {record['status_text']} {record['seconds']:.0f} s", flush=True)
            stored(STORE / f"{name}.json", record)
        return
    work = Path(tempfile.mkdtemp(dir=WORK)) if given.check else WORK
    worst = 0.0
    for joint in joints:
        path = STORE / f"{ROBOT}-{joint}.json"
        folder = work / path.stem
        extra = ["--no-pictures"] if given.check else []
        record = computed(command(joint), joint, "-o", str(folder), *extra)
        print(f"{joint}: {record['steps'][-1]['bend_deg']:.2f} deg, {record['seconds']:.0f} s", flush=True)
        if given.check:
            worst = max(worst, apart(record, path))
            continue
        stored(path, record)
        write_filmstrip(folder, STORE / f"{joint}.png")
    if given.check:
        print(f"bends differ by {100 * worst:.3f} % at most")
        sys.exit(worst > CLOSE)


def stored(path: Path, record: dict[str, Any]) -> None:
    """Write a record."""
    write_atomically(path, (json.dumps(rounded(record), indent=1) + "\n").encode())


if __name__ == "__main__":
    main()
