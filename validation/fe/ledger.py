"""Store what the ledger tells of finite elements: bends of both joints in two descriptions, and pictures of one.

    python validation/fe/ledger.py                 # compute, and write data/fe; one core, minutes for each joint
    python validation/fe/ledger.py hypertuna-fe    # of one description
    python validation/fe/ledger.py --check         # compute, and compare with data/fe

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
from hypertuna.paper.chapters.finite_elements import FE, ROBOTS, command, joint_hash

ROOT = Path(__file__).resolve().parents[2]
STORE = ROOT / "data" / "fe"
WORK = ROOT / "build" / "fe"
CLOSE = 1e-3  # of the largest bend: what another machine or version may differ by


def computed(robot: str, joint: str, folder: Path, *, pictures: bool) -> dict[str, Any]:
    """Run the command; return what it printed, with what it took and what it is of."""
    line, extra = command(robot, joint), [] if pictures else ["--no-pictures"]
    process = subprocess.Popen(
        [sys.executable, "-m", "hypertuna", *line, "-o", str(folder), *extra], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    said = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{' '.join(line)} failed")
    record: dict[str, Any] = json.loads(said)
    facts = {"command": f"hypertuna {' '.join(line)}", "memory_gb": usage.ru_maxrss * 1024 / 1e9}
    return record | facts | {"joint_hash": joint_hash(load(robot), joint)}


def rounded(value: Any) -> Any:
    """Round all numbers to six digits: the file stays readable, and says no more than it knows."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    return [rounded(part) for part in value] if isinstance(value, list) else value


def apart(record: dict[str, Any], path: Path) -> float:
    """Largest difference of the bends from the stored ones, over the largest of those."""
    bends = [[step["bend_deg"] for step in one["steps"]] for one in (record, json.loads(path.read_text()))]
    return float(np.abs(np.subtract(*bends)).max() / np.max(bends[1]))


def main() -> None:
    """Compute; store or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare with what is stored")
    parser.add_argument("robots", nargs="*", default=list(ROBOTS.values()), help="descriptions, all by default")
    given = parser.parse_args()
    check = given.check
    WORK.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(dir=WORK)) if check else WORK
    worst = 0.0
    for robot in given.robots:
        for group in load(robot).joints:
            path = STORE / f"{robot}-{group.name}.json"
            folder = work / path.stem
            record = computed(robot, group.name, folder, pictures=robot == ROBOTS[FE] and not check)
            print(
                f"{robot} {group.name}: {record['steps'][-1]['bend_deg']:.2f} deg, {record['seconds']:.0f} s",
                flush=True,
            )
            if check:
                worst = max(worst, apart(record, path))
                continue
            write_atomically(path, (json.dumps(rounded(record), indent=1) + "\n").encode())
            if robot == ROBOTS[FE]:
                write_filmstrip(folder, STORE / f"{group.name}.png")
    if check:
        print(f"bends differ by {100 * worst:.3f} % at most")
        sys.exit(worst > CLOSE)


if __name__ == "__main__":
    main()
