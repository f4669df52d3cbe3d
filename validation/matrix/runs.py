"""Own robots of tests/matrix.py in every command, for README.md. Run: python validation/matrix/runs.py [COMMAND...]."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections import Counter
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from hypertuna.cli.main import main
from matrix import COMMANDS, Case, all_cases, expected, outcome


def run(*arguments: str) -> tuple[int, str, str]:
    """Run `hypertuna` with arguments: exit code, output, errors."""
    output, errors, code = io.StringIO(), io.StringIO(), 0
    typed = mock.patch.object(sys, "argv", ["hypertuna", *arguments])
    with typed, contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
        try:
            main()
        except SystemExit as end:
            code = int(end.code or 0)
    return code, output.getvalue(), errors.getvalue()


def count(cases: list[Case], folder: Path) -> Counter[str]:
    """Count how many cases end in a result, an error sentence or a fault; print each fault."""
    found: Counter[str] = Counter()
    for case in cases:
        try:
            told = outcome(case, folder, run)
            found["result" if told == "result" else "sentence"] += 1
        except Exception as error:  # of the program, or not as expected
            found["fault"] += 1
            print(f"fault: {case}: {type(error).__name__}: {error}", file=sys.stderr)
    return found


def table(chosen: list[str]) -> int:
    """Print a row of counts for each command, and return the number of faults."""
    print("| command | robots | result | one sentence | fault | outcome asserted |")
    print("|---|---:|---:|---:|---:|---:|")
    total: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
        for command in chosen:
            cases = [case for case in all_cases() if case.command == command]
            found = count(cases, Path(place))
            known = sum(expected(case) is not None for case in cases)
            cells = [len(cases), *(found[kind] for kind in ("result", "sentence", "fault")), known]
            print(f"| `{command}` | {' | '.join(map(str, cells))} |", flush=True)
            total += found
    print(f"\n{total.total()} cases: {total['result']} results, {total['sentence']} sentences, {total['fault']} faults")
    return total["fault"]


if __name__ == "__main__":
    os.environ["COLUMNS"] = "400"
    sys.exit(1 if table(sys.argv[1:] or list(COMMANDS)) else 0)
