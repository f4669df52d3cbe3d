"""CSV files of the commands: pandas reads each, a column is there once, and what made it stands in a file beside it."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest

from program import Run

GRID = ("--frequency", "1:2:2", "--amplitude", "8,15", "--phase", "0,40")
COMMANDS = [
    ("sweep", *GRID),
    ("turn", *GRID, "--bias", "10,10"),
    ("pump", "--frequency", "1,2"),
    ("joint", "bend", "--joint", "I"),
    ("pareto", "--population", "4", "--generations", "1", "--no-polish"),
    ("twin", "--gait", "optimised-0.3", "--duration", "1"),
    ("dive", "--gait", "optimised-0.3", "--duration", "20"),
    ("posture-test", "--frequency", "1", "--angle", "5,5", "--duration", "3"),
]


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_pandas_reads_the_csv_file_of_a_command(command: tuple[str, ...], run: Run, tmp_path: Path) -> None:
    path = tmp_path / "made.csv"
    code, _, errors = run(*command, "-o", str(path))
    assert code == 0, errors
    table = pd.read_csv(path)
    assert len(table)
    assert not [name for name in table.columns if name.startswith("Unnamed") or name.endswith(".1")]
    assert not table.columns.str.endswith("_rad").any()
    assert not table.isna().all(axis=None)
    assert json.loads((tmp_path / "made.csv.json").read_text())["robot"] == "hypertuna"
    assert len(list(tmp_path.iterdir())) == 2
