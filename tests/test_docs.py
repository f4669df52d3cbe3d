"""The documentation tells what the program does: its tables, outputs and pictures are made by the program."""

import re
import runpy
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
HEAVIEST = 300_000  # bytes of a picture


@pytest.fixture(scope="module")
def figures() -> dict[str, Any]:
    return runpy.run_path(str(ROOT / "docs" / "figures.py"))


def words(picture: Path) -> list[str]:
    """Return the texts of an SVG picture, which matplotlib leaves in comments where it draws letters as curves."""
    return re.findall(r"<!-- (.*?) -->", picture.read_text())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_tables_and_outputs_are_the_program_s(page: Path, figures: dict[str, Any]) -> None:
    text = page.read_text()
    assert text == figures["filled"](text), f"run: python docs/figures.py, then look at what changed in {page.name}"


def test_every_table_is_shown_somewhere(figures: dict[str, Any]) -> None:
    shown = {name for page in PAGES for name in re.findall(r"<!-- table: (.+?) -->", page.read_text())}
    assert shown == set(figures["TABLES"])


def test_pictures_are_the_program_s(figures: dict[str, Any], tmp_path: Path) -> None:
    for name, draw in figures["PICTURES"].items():
        committed, fresh = ROOT / name, tmp_path / Path(name).name
        figures["save"](draw(), fresh)
        assert words(fresh) == words(committed) != [], f"run: python docs/figures.py, then look at {name}"
        assert committed.stat().st_size < HEAVIEST
        ElementTree.parse(committed)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_every_name_in_the_symbol_table_exists() -> None:
    core = "\n".join(path.read_text() for path in (ROOT / "core/include/hypertuna").glob("*.hpp"))
    page = (ROOT / "docs" / "conventions.md").read_text().split("## Symbols")[1]
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| $")]
    assert len(rows) > 50
    for row in rows:
        for name in re.findall(r"[A-Za-z_]\w+", " ".join(re.findall(r"`([^`]+)`", row[3]))):
            assert re.search(rf"\b{name}\b", core), f"no {name} in the core, which the row of {row[0]} names"
