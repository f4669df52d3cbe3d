"""Make the notebooks from the programs beside them: run each, and keep what it shows.

    python examples/notebooks/make.py                    # run all, and write NAME.ipynb
    python examples/notebooks/make.py --check swim       # run it, and compare its texts with those of NAME.ipynb

A program is divided by lines `# %%` for code and `# %% [markdown]` for text. Running needs ipykernel, nbclient
and nbformat.
"""

import argparse
import os
import re
import sys
import sysconfig
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

HERE = Path(__file__).parent
NAMES = ("swim", "identify", "twin", "design", "story")
CHANGING = r"[\d.]+ s\b|[\d.]+e-\d+|<Figure size .*>"  # times, and numbers that are rounding error alone


def cells(program: str) -> list[nbformat.NotebookNode]:
    """Divide a program into cells."""
    made = []
    for part in re.split(r"^# %%", program, flags=re.MULTILINE)[1:]:
        head, _, body = part.partition("\n")
        if head.strip() == "[markdown]":
            text = re.sub(r"^# ?", "", body.strip(), flags=re.MULTILINE)
            made.append(nbformat.v4.new_markdown_cell(text, id=f"cell-{len(made)}"))
        else:
            code = re.sub(r"^# !", "!", body.strip(), flags=re.MULTILINE)  # a command of the shell
            made.append(nbformat.v4.new_code_cell(code, id=f"cell-{len(made)}"))
    return made


def run(name: str) -> nbformat.NotebookNode:
    """Run the program of a notebook in an empty folder, as if it were downloaded alone."""
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    notebook = nbformat.v4.new_notebook(cells=cells((HERE / f"{name}.py").read_text(encoding="utf-8")), metadata=kernel)
    os.environ["PATH"] = os.pathsep.join([sysconfig.get_path("scripts"), os.environ["PATH"]])
    with tempfile.TemporaryDirectory() as folder:
        place = {"metadata": {"path": folder}}
        NotebookClient(notebook, timeout=600, kernel_name="python3", coalesce_streams=True, resources=place).execute()
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # times of the run
        if "outputs" in cell:  # without the empty ones that progress bars leave
            cell.outputs = [output for output in cell.outputs if any(output.get("data", {"": output}).values())]
    notebook.metadata.pop("language_info", None)
    return notebook


def texts(notebook: nbformat.NotebookNode) -> list[str]:
    """Return the code of a notebook and the texts that it shows, without what changes from run to run."""
    found = []
    for cell in notebook.cells:
        found.append(cell.source)
        for output in cell.get("outputs", []):
            text = output.get("text") or output.get("data", {}).get("text/plain", "")
            found.append(re.sub(CHANGING, "~", text))
    return found


def main() -> int:
    """Make or check notebooks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=NAMES, help="notebooks (default: all)")
    parser.add_argument("--check", action="store_true", help="compare with the stored notebooks, and write nothing")
    options = parser.parse_args()
    for name in options.names:
        file, fresh = HERE / f"{name}.ipynb", run(name)
        if not options.check:
            nbformat.write(fresh, file)
            continue
        stored = texts(nbformat.read(file, as_version=4))
        for old, new in zip(stored, texts(fresh), strict=True):
            if old != new:
                print(f"{file.name} is not what its program shows:\n{old}\nis now\n{new}", file=sys.stderr)
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
