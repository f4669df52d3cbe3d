"""CPU time of start-up: median of ten runs of each command, with the installed hypertuna, beside its target.

python benchmarks/startup.py exits with 1 if a target is missed; run it on a quiet machine, from an installed wheel.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys

RUNS = 10  # of each command
TARGETS = {  # s of CPU time
    ("-c", "import hypertuna"): 0.15,
    ("-m", "hypertuna", "version"): 0.25,
    ("-m", "hypertuna", "--help"): 0.25,
    ("-m", "hypertuna", "swim", "--robot", "hypertuna", "--gait", "unoptimised-max"): 0.6,
}


def cpu_time(arguments: tuple[str, ...]) -> float:
    """Return the CPU time of a Python process [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> int:
    """Print the medians; return 1 if one is above its target."""
    missed = 0
    for arguments, target in TARGETS.items():
        median = statistics.median(cpu_time(arguments) for _ in range(RUNS))
        missed |= median > target
        print(f"{median:6.3f} s of {target:.2f} s  python {' '.join(arguments)}")
    return missed


if __name__ == "__main__":
    sys.exit(main())
