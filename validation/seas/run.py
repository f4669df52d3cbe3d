"""Random seas, each with a random failure, flown by the firmware on board `pc`: README.md.

    python validation/seas/run.py                        # seeds 0 to 99, on one processor
    python validation/seas/run.py --seeds 7:8 -j 1       # one sea, its table on stdout
    python validation/seas/run.py --seeds 0:300 --group entangled=50 --count 20 -o some.csv  # the first 20 of 300

Every sea is on disk when it has ended: the same command resumes after any interruption, `kill -9` among them. The table
goes to seas.csv beside this file, with what made it and a summary in seas.csv.json.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from flights import fly
from sampled_sea import FAULTS, GROUPS, ROBOT, kinds_of, sampled
from verdict import judge

import hypertuna as ht
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.io.checkpoint import Journal
from hypertuna.io.files import write_atomically

HERE = Path(__file__).resolve().parent
PRESSURE = 1.05  # of the hard limit: no pressure in a circuit may exceed it


def sail(seed: int, kind: str, firmware: Path | None = None) -> dict[str, Any]:
    """Fly through the sea of a seed with a kind of failure; return the row of its table."""
    sea = sampled(seed, kind)
    began = time.perf_counter()
    truth = fly(sea, ht.load(ROBOT), firmware)
    verdict = judge(truth, sea)
    row = {"seed": seed, "failure": sea.kind, "from_s": sea.start, "ok": not verdict.broken}
    row |= {name: round(value, 4) if isinstance(value, float) else value for name, value in asdict(verdict).items()}
    row |= {"broken": "; ".join(verdict.broken), "done": truth.done, "told": " ".join(sorted(truth.told))}
    current = sea.document["water"]["current_m_s"]
    row |= {"pressure_kpa": round(truth.pressure / 1e3, 1)}
    row |= {"compass_off_deg": round(math.degrees(sea.off), 1)}
    return row | {"current_m_s": current, "computed_s": round(time.perf_counter() - began, 1)}


def table(rows: list[dict[str, Any]]) -> bytes:
    """Return the rows as CSV."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [name for name in rows[0] if name != "computed_s"], extrasaction="ignore")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Count verdicts, endings and broken rules."""
    broken: dict[str, list[int]] = {}
    for row in rows:
        for rule in filter(None, row["broken"].split("; ")):
            broken.setdefault(rule, []).append(row["seed"])
    endings = [row["ending"] for row in rows]
    control = ht.load(ROBOT).controller
    assert control is not None
    assert control.pressure_hard is not None
    limit = PRESSURE * control.pressure_hard / 1e3
    return {
        "seas": len(rows),
        "ok": sum(row["ok"] for row in rows),
        **{f"claims {name}": _claims(rows, name) for name in ("within_two", "within_three")},
        "endings": {name: endings.count(name) for name in sorted(set(endings))},
        "broken": dict(sorted(broken.items())),
        "not done without a failure": [row["seed"] for row in rows if not row["done"] and not FAULTS[row["failure"]]],
        f"above {limit:g} kPa": [row["seed"] for row in rows if row["pressure_kpa"] > limit],
    }


def _claims(rows: list[dict[str, Any]], name: str) -> float:
    """Return which part of all reported places is true; a flight counts by its duration."""
    long = sum(row["end"] for row in rows)
    return round(sum(row[name] * row["end"] for row in rows) / long, 4) if long else 1.0


def main() -> None:
    """Fly, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:100", help="from:to (default: 0:100)")
    parser.add_argument("--count", type=int, help="only so many of the seeds, from the first (default: all)")
    parser.add_argument("-j", type=int, default=1, help="processes (default: 1)")
    parser.add_argument("--journal", type=Path, default=HERE.parents[1] / "build" / "seas.journal")
    parser.add_argument("--firmware", type=Path, help="folder of the program (default: build/firmware)")
    parser.add_argument("-o", type=Path, help="table (default: seas.csv beside this file for 0:100, else stdout)")
    parser.add_argument(
        "--group",
        action="append",
        default=[],
        help=f"NAME=COUNT: so many seas of a group of failures: {', '.join(GROUPS)}",
    )
    options = parser.parse_args()
    asked = {name: int(count) for name, _, count in (text.partition("=") for text in options.group)}
    first, last = (int(part) for part in options.seeds.split(":"))
    seeds = list(range(first, last))
    kinds = dict(zip(seeds, kinds_of(range(first, last), asked), strict=True))
    out = HERE / "seas.csv" if options.o is None and options.seeds == "0:100" else options.o
    options.journal.parent.mkdir(parents=True, exist_ok=True)
    header = journal_header("seas", ht.load(ROBOT), {"seeds": seeds, "groups": asked})
    rows: list[dict[str, Any]] = []
    pool = ProcessPoolExecutor(options.j)
    with Journal(options.journal, header) as journal:
        flown = seeds[: options.count]
        work = {seed: pool.submit(sail, seed, kinds[seed], options.firmware) for seed in flown[journal.unread :]}
        try:
            for seed in flown:
                row = journal.answer(seed, lambda seed=seed: work[seed].result())
                rows.append(row)
                state = "ok" if row["ok"] else row["broken"]
                print(f"sea {seed}: {row['failure']}, {row['ending']}, {state}", file=sys.stderr, flush=True)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
    result = summary(rows)
    if out is None:
        sys.stdout.write(table(rows).decode())
    else:
        write_atomically(out, table(rows))
        facts = {key: str(value) for key, value in provenance(ht.load(ROBOT)).items()}
        words = [options.seeds, *(f"--group {one}" for one in options.group)]
        words += [f"--count {options.count}"] * (options.count is not None)
        facts |= {"command": " ".join(["python validation/seas/run.py --seeds", *words])}
        write_atomically(Path(f"{out}.json"), (json.dumps(facts | result, indent=1) + "\n").encode())
    print(json.dumps(result), file=sys.stderr)
    sys.exit(result["ok"] < result["seas"])


if __name__ == "__main__":
    main()
