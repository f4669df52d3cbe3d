"""Numbers of the ledger on the pages of the documentation: each is that of the ledger, wherever it stands."""

import re
import runpy
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hypertuna.paper.computed import SPEEDS, TWIN
from hypertuna.paper.ledger import Finding, judge, published
from hypertuna.paper.seeds import Numbers, all_seeds

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [DOCS.parent / "README.md", *sorted(page for page in DOCS.rglob("*.md") if "_build" not in page.parts)]
made: dict[str, Any] = runpy.run_path(str(DOCS / "figures_stated.py"))
# Columns of a gait's row that hold a number of the twin's run, and the name of that number over the seeds.
COLUMNS = {r"twin(, m/s| \[m/s\])": "speed", r"(power \[)?W\]?": "power"}
UNCHANGED = ("default robot", "stiff")  # labels of rows with the eight speeds of the robot as it is
EIGHT = [name.replace("optimised-", "") for name in SPEEDS]  # heads of such a table
LAKE = published()["lake"]["gait"]
ROW = [*(f"{name} speed" for name in SPEEDS), "unoptimised-max power", f"{LAKE} power"]


def test_every_sentence_stands_on_a_page() -> None:
    text = "\n".join(page.read_text() for page in PAGES)
    for sentence in made["SENTENCES"]:
        assert re.search(made["pattern_of"](sentence), text), sentence


def test_no_number_of_the_twin_on_the_page_of_the_paper_is_written_by_hand() -> None:
    """Its sentences on the twin have no number with a unit but those that docs/figures.py writes."""
    text = re.sub(r"<!-- table: .*?<!-- end -->", "", (DOCS / "paper.md").read_text(), flags=re.DOTALL)
    for sentence in made["SENTENCES"]:
        text = re.sub(made["pattern_of"](sentence), "", text)
    parts = [" ".join(part.split()) for part in re.split(r"(?<=[.?!:;])\s+|\n\n|\n- |\|", text)]
    ours = [part for part in parts if re.search(r"\b(twin|default robot)\b", part)]
    assert len(ours) > 20
    assert [part for part in ours if re.search(r"\d\s*(m/s|W\b|J/|kPa|deg\b|%|Wh|BL|s\b)", part)] == []


def test_a_number_that_is_not_the_ledger_s_is_replaced() -> None:
    found = [
        Finding("power/fastest", TWIN, "in sight", 11.46, band=(5.0, 25.06)),
        Finding("power/lake", TWIN, "in sight", 10.64),
        Finding("speed/unoptimised-max", TWIN, "prediction", 0.2387, band=(0.1113, 0.4124)),
    ]
    ledger = SimpleNamespace(
        entries=[judge(published(), one) for one in found], summary={"speeds": {TWIN: {"rms_relative_error": 0.4037}}}
    )
    page = """It rains. The default robot of the twin has an rms error of 9 %. The twin takes 1.23
and -4 W in these gaits. The speed of its fastest gait is 0.235 m/s, and 0.235 is nobody's number. In this gait,
90 % of the robots that the paper allows swim 1 to
2 m/s; 0.56 m/s is published."""
    expected = """It rains. The default robot of the twin has an rms error of 40.4 %. The twin takes 11.5
and 10.6 W in these gaits. The speed of its fastest gait is 0.239 m/s, and 0.235 is nobody's number. In this gait,
90 % of the robots that the paper allows swim 0.111 to
0.412 m/s; 0.56 m/s is published."""
    assert made["stated"](page, lambda: ledger) == expected
    assert made["stated"](expected, lambda: ledger) == expected
    ledger.entries[0] = judge(published(), found[0]._replace(computed=None, note="stale: it has changed"))
    with pytest.raises(ValueError, match="power/fastest . twin is on a page and has no number: stale"):
        made["stated"](page, lambda: ledger)


def tables(page: Path) -> list[list[list[str]]]:
    """Return the tables of a page: rows of cells, the heads first."""
    found: list[list[list[str]]] = [[]]
    for line in page.read_text().splitlines():
        if not line.startswith("|"):
            found.append([])
        elif not set(line) <= set("|-: "):
            found[-1].append([cell.strip(" `") for cell in line.strip().removeprefix("|").removesuffix("|").split("|")])
    return [rows for rows in found if len(rows) > 1]


def told(rows: list[list[str]]) -> list[tuple[str, str]]:
    """Return the numbers of a table that are the twin's by their row and column: name over the seeds, and text."""
    heads, *body = rows
    numbers = []
    for row in body:
        if row[0] in SPEEDS:
            named = [
                (what, cell)
                for head, cell in zip(heads, row, strict=True)
                for pattern, what in COLUMNS.items()
                if re.fullmatch(pattern, head) and "(" not in cell  # with the interval of a family
            ]
            numbers += [(f"{row[0]} {what}", cell) for what, cell in named]
        elif row[0] in UNCHANGED and heads[1:11] == [*EIGHT, "fastest [W]", "lake [W]"]:
            numbers += zip(ROW, row[1:11], strict=True)
    return numbers


@pytest.fixture(scope="module")
def waters() -> list[Numbers]:
    """Return the twin's numbers over the seeds, by either water law."""
    stored = [all_seeds()[study] for study in ("swims", "strips")]
    assert [one.reason for one in stored] == ["", ""]
    return [one.numbers for one in stored]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_run_of_the_twin_has_one_speed_and_one_power_on_all_pages(page: Path, waters: list[Numbers]) -> None:
    """The numbers of a table are within the seeds, in the water of either law."""
    for name, text in (number for rows in tables(page) for number in told(rows)):
        half = 0.5 * 10.0 ** -len(text.partition(".")[2])
        within = [n[name].min() - half <= float(text) <= n[name].max() + half for n in waters]
        assert any(within), (
            f"{page.name}: {name} of {text}, over the seeds {[float(np.median(n[name])) for n in waters]}"
        )
