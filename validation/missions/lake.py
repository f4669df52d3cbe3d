"""Store the flight of the ledger: the mission `lake` with seed 0, about a minute on one core.

    python validation/missions/lake.py             # fly, and write data/missions/lake.json
    python validation/missions/lake.py --check     # fly, and compare with it

Ten seeds with sensor noise, currents to 0.2 m/s and gaps of the satellites are stored beside this file, a quarter of an
hour on one core:

    hypertuna mission lake --seeds 1:11 --checkpoint build/lake.journal -o validation/missions/lake-seeds.csv
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from hypertuna.io.files import write_atomically
from hypertuna.paper.chapters.lake import STORED, fly_lake, read_lake

PATH = Path(__file__).resolve().parents[2] / "data" / STORED
CLOSE = 0.01  # max relative difference on another machine or version


def main() -> None:
    """Fly, and write or compare."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    record = fly_lake().record
    if not check:
        lines = (f" {json.dumps(key)}: {json.dumps(value)}" for key, value in (record or {}).items())
        write_atomically(PATH, ("{\n" + ",\n".join(lines) + "\n}\n").encode())
        return
    stored = read_lake()
    if stored.record is None or record is None:
        sys.exit(stored.reason)
    for name in ("distance_m", "servo_energy_wh", "battery_energy_wh"):
        difference = record[name] / stored.record[name] - 1
        print(f"{name}: {record[name]:.5g}, stored {stored.record[name]:.5g}")
        if abs(difference) > CLOSE:
            sys.exit(f"{name} is {100 * difference:.2g} % from the stored one")


if __name__ == "__main__":
    main()
