"""The notebooks run, and show what is stored in them."""

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "examples" / "notebooks"
PROGRAMS = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem != "make")
NEEDS = ("ipykernel", "nbclient", "nbformat")


@pytest.mark.skipif(any(find_spec(name) is None for name in NEEDS), reason="needs ipykernel, nbclient and nbformat")
@pytest.mark.parametrize("name", PROGRAMS)
def test_a_notebook_shows_what_its_program_shows(name: str) -> None:
    done = subprocess.run([sys.executable, FOLDER / "make.py", "--check", name], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_notebook_is_small_and_without_errors(name: str) -> None:
    file = FOLDER / f"{name}.ipynb"
    assert file.stat().st_size < 700_000
    outputs = [output for cell in json.loads(file.read_text())["cells"] for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output["output_type"] == "error" or output.get("name") == "stderr"]
    kinds = {kind for output in outputs for kind in output.get("data", {})}
    assert {"text/html", "image/png"} <= kinds
