"""Fly every shipped mission with 32 seeds, and count how many end `done`. Half an hour on one core.

    python validation/missions/seeds.py            # all; goes on where it was interrupted
    python validation/missions/seeds.py box        # one of them

Each seed has its own noise, current and gaps of the satellites. The flights of a mission are stored beside this file in
NAME-seeds.csv, what made them in NAME-seeds.csv.json. The exit code is 1 if fewer than 90 % of a mission's flights are
done.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
from pathlib import Path

from hypertuna.mission.file import missions

ROOT = Path(__file__).resolve().parents[2]
SEEDS = range(1, 33)  # seed 0 has neither current nor gaps
ENOUGH = 0.9  # fraction of the flights that must be done


def stored(mission: str) -> list[dict[str, str]]:
    """Return the stored flights of a mission."""
    text = (ROOT / "validation" / "missions" / f"{mission}-seeds.csv").read_text()
    return list(csv.DictReader(text.splitlines()))


def done(flights: list[dict[str, str]]) -> int:
    """Count the flights that are done."""
    return sum(flight["status"] == "done" for flight in flights)


def fly_and_store(mission: str) -> None:
    """Fly a mission with all seeds by `hypertuna`, which prints why and where flights failed; store the flights."""
    journal = Path("build") / f"{mission}.journal"
    (ROOT / journal.parent).mkdir(exist_ok=True)
    command = ["mission", mission, "--seeds", f"{SEEDS.start}:{SEEDS.stop}", "--checkpoint", str(journal)]
    command += ["-o", f"validation/missions/{mission}-seeds.csv"]
    code = subprocess.run([sys.executable, "-m", "hypertuna", *command], cwd=ROOT, check=False).returncode
    if code not in (0, 1):  # 1: not all are done
        sys.exit(code)
    (ROOT / journal).unlink()


def main() -> None:
    """Fly the missions of the command line, or all; compare with what must be done."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("missions", nargs="*", metavar="NAME", help="default: all")
    chosen = parser.parse_args().missions or missions()
    for mission in chosen:
        fly_and_store(mission)
    counts = {mission: done(stored(mission)) for mission in chosen}
    print("\n".join(f"{mission}: {count} of {len(SEEDS)} done" for mission, count in counts.items()))
    sys.exit(any(count < ENOUGH * len(SEEDS) for count in counts.values()))


if __name__ == "__main__":
    main()
