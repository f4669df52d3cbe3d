"""Change thousands of tracks as real life does, and judge what the import of markers makes of them.

    python validation/mutations/tracks.py             # 4,900 tracks, about ten minutes of one processor
    python validation/mutations/tracks.py --seed 866  # one track again

Exit code 1 if one is read with other times or angles without a word, or ends in a traceback.
"""

import argparse
import os
import sys
from collections import Counter
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[name] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from mutations.tracks import judged  # noqa: E402  # above, the folder is put on the path

TRACKS = 4900  # number of tracks that are judged by default


def main() -> int:
    """Judge tracks; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tracks", type=int, default=TRACKS)
    parser.add_argument("--seed", type=int)
    asked = parser.parse_args()
    outcomes: Counter[str] = Counter()
    slowest = 0.0
    for seed in range(asked.tracks) if asked.seed is None else (asked.seed,):
        reaction = judged(seed)
        outcomes["wrong" if reaction.problems else "accepted" if reaction.accepted else "refused"] += 1
        slowest = max(slowest, reaction.seconds)
        for problem in reaction.problems:
            print(f"seed {seed}: {problem}", flush=True)
    print(
        ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items())),
        f"slowest {slowest:.1f} s",
        sep="; ",
    )
    return 1 if outcomes["wrong"] else 0


if __name__ == "__main__":
    sys.exit(main())
