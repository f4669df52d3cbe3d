"""Pictures of gallery.md: each by the code that stands above it."""

import contextlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

ROOT = Path(__file__).parents[1]
# A program of the gallery's page, and its picture's file
ENTRY = re.compile(r"```python\n(.*?)```\n\n!\[.*?\]\((gallery/.*?)\)", re.DOTALL)


def _pictures() -> dict[str, Callable[[], Figure]]:
    page = (ROOT / "docs/gallery.md").read_text()
    entries = ENTRY.findall(page)
    # A piece of code needs nothing else of the earlier pieces.
    imports = "\n".join(re.findall(r"^import .*", page, re.MULTILINE))

    def run(code: str) -> Figure:
        names: dict[str, Any] = {}
        with contextlib.chdir(ROOT):
            exec(f"{imports}\n{code}", names)
        figure: Figure = names["figure"]
        return figure

    return {f"docs/{name}": lambda code=code: run(code) for code, name in entries}  # type: ignore[misc]  # a default argument is not inferred


TABLES: dict[str, Callable[[], str]] = {}
PICTURES = _pictures()
