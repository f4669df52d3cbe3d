"""The notebooks run, and show what is stored in them."""

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[1] / "examples" / "notebooks"
PROGRAMS = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem != "make")
NEEDS = ("ipykernel", "nbclient", "nbformat")


needs_a_kernel = pytest.mark.skipif(
    any(find_spec(name) is None for name in NEEDS), reason="needs ipykernel, nbclient and nbformat"
)

# Cells, and the kinds of what each must show: once, and nothing beside it.
BEGIN = """
import hypertuna as ht, hypertuna.display
hypertuna.display.FAST = hypertuna.display.REFRESH = 0.0  # bars of short calls, too
swim = ht.swim("hypertuna", "optimised-0.3")
gaits = ht.Gaits.grid(frequency=[1, 2], amplitude=[(0.2, 0.3)], phase=[(0, 0.7)])
"""
CARD, FIGURE, TEXT = {"text/html", "text/plain"}, {"image/png", "text/plain"}, {"stdout"}
CELLS: list[tuple[str, list[set[str]], bool]] = [  # code, kinds of each output, whether a bar moves
    (BEGIN, [], False),
    ("swim", [CARD], False),
    ("display(swim)", [CARD], False),
    ("print(swim)", [TEXT], False),
    ("swim.plot()", [FIGURE], False),
    ("run = ht.twin(swim.robot, swim.gait, duration=1)\nrun", [CARD], False),
    ("ht.sweep('hypertuna', gaits, progress=ht.progress_bar('gaits'))", [CARD], False),  # done at its first report
    ("report = ht.progress_bar()\nfor k in range(5):\n    report(k, 4)\nprint('done')", [TEXT], True),
    ("best = ht.optimize('hypertuna', maximize='speed', progress=ht.progress_bar())\nbest", [CARD], True),  # ends early
    ("file = ht.fly('box', 'hypertuna', duration=130, report=ht.progress_bar('s'))", [], True),  # given up
]


@needs_a_kernel
def test_a_notebook_shows_each_result_once_and_no_bar_that_is_done() -> None:
    import nbclient
    import nbformat

    bars: list[int] = []

    class Client(nbclient.NotebookClient):
        def process_message(self, msg: Any, cell: Any, cell_index: int) -> Any:
            if "<progress" in msg["content"].get("data", {}).get("text/html", ""):
                bars.append(cell_index)
            return super().process_message(msg, cell, cell_index)

    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(code) for code, *_ in CELLS])
    Client(notebook, timeout=120, kernel_name="python3", coalesce_streams=True).execute()
    for k, (cell, (code, kinds, moves)) in enumerate(zip(notebook.cells, CELLS, strict=True)):
        assert (k in bars) == moves, code
        shown = [set(one["data"]) if "data" in one else {one["name"]} for one in cell.outputs if not empty(one)]
        assert shown == kinds, code


def empty(output: Any) -> bool:
    """Whether nothing is seen of an output."""
    return not any(output.get("data", {"text": output.get("text")}).values())


@needs_a_kernel
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
    for cell in json.loads(file.read_text())["cells"]:
        shown = [output["output_type"] for output in cell.get("outputs", [])]
        assert len(shown) == len({*shown}), cell["source"]  # a printed text and a result at most
    assert not [output for output in outputs if empty(output) or "<progress" in str(output)]
    kinds = {kind for output in outputs for kind in output.get("data", {})}
    assert {"text/html", "image/png"} <= kinds
