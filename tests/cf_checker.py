"""The checker of IOOS on the CF conventions, in a process of its own: its imports warn."""

from __future__ import annotations

import subprocess
import sysconfig
from pathlib import Path

from hypertuna.io.files import CONVENTIONS


def cf_issues(*files: Path) -> str:
    """Return the report of the strict checker; empty if it finds nothing in any of the files."""
    program = Path(sysconfig.get_path("scripts")) / "compliance-checker"
    test = CONVENTIONS.lower().replace("-", ":")
    command = [program, "--test", test, "--criteria", "strict", *files]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    report = done.stdout + done.stderr  # exceptions of the checker are warnings, with exit code 0
    passed = done.returncode == 0 and report.count("All tests passed!") == len(files) and "WARNING" not in report
    return "" if passed else report
