"""Damage thousands of input files and run the commands that read them: `run.py FIRST LAST`, seeds of each kind of file.

    python validation/mutations/run.py 0 2223      # 20,007 files, an hour and a half on one core

Prints what is wrong, a line each, and ends with exit code 1 if anything is.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from mutations import CASES, problems


def main() -> None:
    """Run the seeds, and count."""
    first, last = map(int, sys.argv[1:])
    count = wrong = 0
    for seed in range(first, last):
        for case in CASES:
            with tempfile.TemporaryDirectory() as folder:
                for problem in problems(case, seed, Path(folder)):
                    wrong += 1
                    print(problem, flush=True)
            count += 1
    print(f"{count} files, {wrong} problems")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
