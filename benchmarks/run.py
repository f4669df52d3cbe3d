"""Measure how fast hypertuna is, against other tools, and print it as tables, as JSON or as a page of the docs."""

from __future__ import annotations

import argparse
import json
import platform
import sys
from collections.abc import Callable
from datetime import date
from importlib.metadata import version
from pathlib import Path

from timing import stay_on_one_core

stay_on_one_core()  # before the libraries are imported

from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402

import items  # noqa: E402
import searches  # noqa: E402
from hypertuna import _core  # noqa: E402
from items import Item, Row  # noqa: E402

# Compiled benchmark of the equations' right-hand side
RHS = Path(__file__).resolve().parents[1] / "build" / "bench" / "rhs"
PEERS = ("numpy", "numba", "jax", "scipy", "mujoco")


def machine() -> dict[str, str]:
    """Return the machine of the measurement, and the versions of the software."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    cores = "?"
    if info.exists():
        lines = info.read_text().splitlines()
        values = {line.partition(":")[0].strip(): line.partition(":")[2].strip() for line in lines}
        cpu = f"{values.get('model name', cpu)}, family {values.get('cpu family')}, model {values.get('model')}"
        cores = str(sum(line.startswith("processor") for line in lines))
    return {
        "date": date.today().isoformat(),
        "processor": cpu,
        "cores": f"{cores}, one of them used",
        "instruction set": f"{_core.isa()}, {_core.lanes()} lanes",
        "system": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "versions": ", ".join(f"{name} {version(name)}" for name in ("hypertuna", *PEERS)),
    }


def measure(only: str, rhs: Path, quick: bool, say: Callable[[str], None]) -> list[Item]:
    """Measure the items whose letters are in `only`."""
    turns = 3 if quick else 9
    counts = (10**4, 10**5) if quick else (10**4, 10**5, 10**6)
    work: dict[str, Callable[[], Item]] = {
        "a": lambda: items.right_hand_side(rhs, turns),
        "b": lambda: items.periodic_sweep(10 * turns),
        "c": lambda: items.against_jax(turns),
        "d": lambda: items.against_scipy_and_mujoco(turns),
        "e": lambda: items.many_gaits(counts),
        "f": lambda: items.call_overhead(200 * turns),
        "g": lambda: searches.gait_search(turns),
        "h": lambda: searches.identification(turns),
        "i": lambda: items.twin_speed(turns),
        "j": lambda: items.many_twins(turns),
        "k": lambda: items.settled_gaits(turns),
    }
    found = []
    for letter in only:
        say(f"Measuring ({letter}) ...")
        found.append(work[letter]())
    return found


def number(row: Row) -> str:
    """Return value and unit of a row as text."""
    text = f"{row.value:.3g}" if 1e-3 <= abs(row.value) < 1e3 else f"{row.value:,.0f}"
    return f"{text} {row.unit}".strip()


def print_tables(found: list[Item], console: Console) -> None:
    """Print a table per item."""
    console.print(*(f"{key}: {value}" for key, value in machine().items()), sep="\n", highlight=False)
    for item in found:
        table = Table(
            "",
            "measured",
            "goal",
            title=item.title,
            caption=item.method,
            title_justify="left",
            caption_justify="left",
            expand=True,
        )
        for row in item.rows:
            table.add_row(row.what, number(row), row.goal)
        console.print("", table)


def markdown(found: list[Item]) -> str:
    """Return the page of the docs."""
    parts = [
        "# Benchmarks\n",
        "`python benchmarks/run.py --markdown docs/benchmarks.md` writes this page, after `make bench`. The "
        "contestants take turns on one core. Numbers are medians of processor time, and ratios are medians of the "
        "ratios within each turn. Before it is timed, every peer must compute the same speeds.\n",
        *(f"- {key}: {value}" for key, value in machine().items()),
    ]
    for item in found:
        parts += [f"\n## {item.title}\n", item.method + "\n", "| | measured | goal |", "|---|---:|---|"]
        parts += [f"| {row.what} | {number(row)} | {row.goal} |" for row in item.rows]
    return "\n".join(parts) + "\n"


def main() -> None:
    """Read the options, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="write the page of the docs")
    parser.add_argument("--quick", action="store_true", help="fewer turns, no sweep of a million gaits")
    parser.add_argument(
        "--only", default="abcdefghijk", metavar="LETTERS", help="measure these items only (default all)"
    )
    parser.add_argument("--rhs", type=Path, default=RHS, metavar="FILE", help="the compiled benchmarks/rhs.cpp")
    options = parser.parse_args()
    if unknown := set(options.only) - set("abcdefghijk"):
        parser.error(f"--only must name items a to k, but has {''.join(sorted(unknown))}")
    if "a" in options.only and not options.rhs.exists():
        parser.error(f"{options.rhs} does not exist: build it by `make build/bench`, or leave (a) out by --only")
    progress = Console(stderr=True)
    found = measure(options.only, options.rhs, options.quick, progress.print)
    if options.markdown:
        options.markdown.write_text(markdown(found))
    if options.json:
        values = {row.key: row.value for item in found for row in item.rows}
        json.dump({"machine": machine(), **values}, sys.stdout, indent=2)
        print()
    else:
        print_tables(found, Console() if sys.stdout.isatty() else Console(width=100))


if __name__ == "__main__":
    main()
