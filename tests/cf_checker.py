"""NetCDF files: the checker of IOOS on the CF conventions, in a process of its own (its imports warn); equality."""

from __future__ import annotations

import subprocess
import sysconfig
from pathlib import Path

import xarray as xr

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


def same_files(one: str, other: str) -> None:
    """Check that two NetCDF files are the same but for the commands that wrote them."""
    with xr.open_dataset(one, engine="h5netcdf") as a, xr.open_dataset(other, engine="h5netcdf") as b:
        assert a.drop_attrs(deep=False).identical(b.drop_attrs(deep=False))
        commands = {"command", "history"}
        assert {*a.attrs} == {*b.attrs} > commands
        assert all(a.attrs[name] == b.attrs[name] for name in {*a.attrs} - commands)
