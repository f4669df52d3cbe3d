"""The documentation tells what the program does: its tables, outputs and pictures are made by the program."""

import re
import runpy
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import hypertuna as ht

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted(path for path in (ROOT / "docs").rglob("*.md") if "_build" not in path.parts)]
HEAVIEST = 300_000  # bytes of a picture


def named(page: Path) -> str:
    """Return the name of a page in the output of the tests."""
    return str(page.relative_to(ROOT))


@pytest.fixture(scope="module")
def figures() -> dict[str, Any]:
    return runpy.run_path(str(ROOT / "docs" / "figures.py"))


def words(picture: Path) -> list[str]:
    """Return the texts of an SVG picture, which matplotlib leaves in comments where it draws letters as curves."""
    return re.findall(r"<!-- (.*?) -->", picture.read_text())


def steady(text: str) -> str:
    """Hide what is rounding error alone, and how long it took: they differ from machine to machine."""
    text = re.sub(r"\b[\d.]+(\s+s in all)\b", r"0\1", text)
    return re.sub(r"\b\d(\.\d+)?e-(0[7-9]|1\d)\b", "0", text)


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_tables_and_outputs_are_the_program_s(page: Path, figures: dict[str, Any]) -> None:
    text = page.read_text()
    assert steady(text) == steady(figures["filled"](text)), f"run: python docs/figures.py and look at {page.name}"


def test_every_table_is_shown_somewhere(figures: dict[str, Any]) -> None:
    shown = {name for page in PAGES for name in re.findall(r"<!-- table: (.+?) -->", page.read_text())}
    assert shown == set(figures["TABLES"])


def test_pictures_are_the_program_s(figures: dict[str, Any], tmp_path: Path) -> None:
    for name, picture in figures["PICTURES"].items():
        committed, fresh = ROOT / name, tmp_path / Path(name).name
        figures["save"](picture(), fresh)
        assert words(fresh) == words(committed) != [], f"run: python docs/figures.py, then look at {name}"
        assert committed.stat().st_size < HEAVIEST
        ElementTree.parse(committed)


def test_animated_pictures_are_the_program_s(figures: dict[str, Any]) -> None:
    number = r"-?\d+\.\d+"
    for name, text in figures["FILES"].items():
        fresh, committed = text(), (ROOT / name).read_text()
        assert re.sub(number, "", fresh) == re.sub(number, "", committed), f"run: python docs/figures.py: {name}"
        points = [np.array(re.findall(number, one), float) for one in (fresh, committed)]
        np.testing.assert_allclose(*points, atol=0.5)  # of a body that is 1000 long
        assert len(committed) < HEAVIEST
        ElementTree.fromstring(committed)


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


def symbol_table() -> list[list[str]]:
    """Return the rows of the symbol table: symbol, meaning, unit, C++, Python."""
    page = (ROOT / "docs" / "conventions.md").read_text().split("## Symbols")[1]
    lines = [line for line in page.splitlines() if line.startswith("| $")]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]


@pytest.mark.parametrize("row", symbol_table(), ids=lambda row: row[0])
def test_names_of_the_symbol_table_exist(row: list[str]) -> None:
    core = "\n".join(path.read_text() for path in (ROOT / "core/include/hypertuna").rglob("*.hpp"))
    for name in re.findall(r"[A-Za-z_]\w*", " ".join(re.findall(r"`([^`]+)`", row[3]))):
        assert re.search(rf"\b{name}\b", core), f"no {name} in the core"
    robot = ht.load("hypertuna")
    gait = ht.Gait(1.0, (0.1, 0.1), (0.0, 0.0))
    swim = ht.swim(robot, gait)
    known = {"robot": robot, "gait": gait, "swim": swim, "trajectory": swim.trajectory, "g": 0}
    for name in re.findall(r"`((?:robot|gait|swim|trajectory)\.[^`]+)`", row[4]):
        eval(name, known)


@pytest.mark.parametrize("page", sorted((ROOT / "docs/howto").glob("*.md")), ids=named)
def test_sentences_of_a_how_to_are_short(page: Path) -> None:
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^(#.*|\|.*|<!--.*|!\[.*)$", "", text, flags=re.MULTILINE)
    sentences = [one.split() for one in re.split(r"[.:;?!]\s|\n\n", re.sub(r"\]\([^)]*\)", "]", text))]
    assert [" ".join(words) for words in sentences if len(words) > 30] == []


def test_the_check_of_the_site_finds_what_is_broken(tmp_path: Path) -> None:
    check = runpy.run_path(str(ROOT / "docs/check_site.py"))["faults"]
    (tmp_path / "a.html").write_text('<a href="b.html#here">b</a><a href="https://example.org">far</a>')
    (tmp_path / "b.html").write_text('<p id="here">b</p>')
    assert check(tmp_path) == []
    (tmp_path / "b.html").write_text('<a href="c.html">c</a><script src="https://example.org/x.js"></script>')
    assert check(tmp_path) == [
        "a.html: no place b.html#here",
        "b.html: fetches https://example.org/x.js",
        "b.html: no file c.html",
    ]
