"""The page of the ledger, its folder and its command."""

import html
import json
import re
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from hypertuna.cli.main import main
from hypertuna.paper.computed import OURS, PAPER
from hypertuna.paper.ledger import CLASSES, MARKS
from hypertuna.paper.page import ledger_html
from hypertuna.paper.reproduce import Ledger, ledger_record
from hypertuna.reports.html import Picture, Section, Table, anchor
from hypertuna.reports.studio import studio_page


class Page(HTMLParser):
    """What a page refers to, and its text."""

    def __init__(self) -> None:
        super().__init__()
        self.references: list[str] = []
        self.identifiers: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("src", "href", "xlink:href"):
                self.references.append(value or "")
            if name == "id":
                self.identifiers.append(value or "")

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def test_the_page_needs_nothing_else(ledger: Ledger, folder: Path) -> None:
    text = (folder / "index.html").read_text()
    page = Page()
    page.feed(text)
    outside = [reference for reference in page.references if not reference.startswith(("#", "data:"))]
    assert outside == ["ledger.json"]
    assert {reference[1:] for reference in page.references if reference.startswith("#")} <= set(page.identifiers)
    assert "url(http" not in text
    assert "@import" not in text
    words = " ".join(page.words).replace("\N{MINUS SIGN}", "-")
    assert all(entry.id in words and entry.computed_text in words for entry in ledger.entries)


def test_the_page_shows_every_section_and_says_what_its_figures_are(folder: Path, sections: list[Section]) -> None:
    text = (folder / "index.html").read_text()
    for section in sections:
        assert f"<h2>{section.title}</h2>" in text
        for part in section.parts:
            if isinstance(part, Picture):
                assert part.shows.endswith(".")
                assert part.made
                assert f'<figure id="{part.name}" ' in text
            elif isinstance(part, Table):
                assert all(len(row) == len(part.columns) for row in part.rows)
    assert "--full" in text  # what was left out


def test_the_page_and_the_command_begin_with_what_the_numbers_are_worth(
    ledger: Ledger, folder: Path, sections: list[Section]
) -> None:
    text, summary = (folder / "index.html").read_text(), ledger.summary
    first = f"<dt>{summary['reproduced']} of {summary['predictions']}</dt><dd>predicted numbers are reproduced"
    assert text.index("<h1>hypertuna") < text.index('id="tool"') < text.index('id="audit"') < text.index(first)
    heads = (first, '<h2 id="worth">What the numbers are worth</h2>', f"<h2>{sections[0].title}</h2>")
    places = [text.index(head) for head in heads]
    assert places == sorted(places)
    for name, reason in CLASSES.items():
        assert f"<tr><td>{name}<span" in text[places[1] : places[2]]
        assert reason.split(",")[0].replace("'", "&#39;") in text[places[1] : places[2]]


def test_the_studio_is_in_the_page_with_the_robot_at_its_fastest_gait(ledger: Ledger, folder: Path) -> None:
    text, best = (folder / "index.html").read_text(), ledger.trials[OURS].gaits["unoptimised-max"]
    (frame,) = re.findall(r'<iframe class="studio" title="[^"]+" srcdoc="([^"]*)">', text)
    assert html.unescape(frame) == studio_page(best.robot, best.gait, ledger="")
    assert text.index(frame) < text.index('id="tool"')
    assert "WebAssembly" in text.replace(frame, "")  # what is said where a browser has none
    assert '<svg class="fish"' in text.split("<noscript>")[1].split("</noscript>")[0]


def test_every_number_has_a_place_to_link_to(ledger: Ledger, folder: Path) -> None:
    page = Page()
    page.feed((folder / "index.html").read_text())
    places = [place for place in page.identifiers if place.startswith("number-")]
    assert places == [f"number-{anchor(key)}" for key in dict.fromkeys(entry.id for entry in ledger.entries)]
    assert len(set(page.identifiers)) == len(page.identifiers)


def test_links_to_the_docs_of_a_clone(ledger: Ledger) -> None:
    root = Path(__file__).parents[2]
    pages = re.findall(r'href="\.\./(docs/[^"#]+)"', ledger_html(ledger, [], "../docs"))
    assert len(pages) >= 10
    assert all((root / page).is_file() for page in pages)


def test_tables_say_what_the_ledger_says(ledger: Ledger, sections: list[Section]) -> None:
    tables = [part for section in sections for part in section.parts if isinstance(part, Table)]
    record = {(entry["id"], entry["model"]): entry for entry in ledger_record(ledger)["entries"]}
    three = next(table for table in tables if table.columns[0] == "coefficient")
    for name, key in (("c_f,0", "friction[0]"), ("c_d,7", "drag[7]")):
        row = next(row for row in three.rows if row[0] == name)
        entry = record[f"coefficient/{key}", OURS]
        assert row[2] == f"{entry['published']:g}"
        assert row[-1] == f"{entry['interval'][0]:.3g} to {entry['interval'][1]:.3g}"
    four = next(table for table in tables if table.columns[0] == "objective")
    for target in ("0.3", "0.4", "0.5"):
        told = [row for row in four.rows if target in str(row[0])]
        for row, model in ((told[2], PAPER), (told[3], OURS)):
            keys = ("amplitude-I", "amplitude-II", "frequency", "phase")
            assert row[2:6] == [f"{record[f'optimum/{target}/{key}', model]['computed']:.4g}" for key in keys]
        assert told[1][4] == f"{record[f'optimum/{target}/frequency', OURS]['published']:g}"


def test_the_page_escapes_what_it_shows(ledger: Ledger) -> None:
    first = replace(ledger.entries[0], note="<script>alert(1)</script>")
    changed = replace(ledger, entries=(first, *ledger.entries[1:]))
    assert "<script>alert" not in ledger_html(changed, [])


def test_the_folder(ledger: Ledger, folder: Path, sections: list[Section]) -> None:
    assert json.loads((folder / "ledger.json").read_text()) == json.loads(json.dumps(ledger_record(ledger)))
    plots = list(folder.glob("*.svg"))
    pictures = [part for section in sections for part in section.parts if isinstance(part, Picture)]
    assert {plot.stem for plot in plots} == {picture.name for picture in pictures} | {"robot"}
    assert all(ET.parse(plot).getroot().tag.endswith("svg") for plot in plots)


def test_the_command(
    ledger: Ledger, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[bool] = []

    def computed(*, full: bool, progress: Any) -> Ledger:
        asked.append(full)
        return ledger

    monkeypatch.setattr("hypertuna.cli.paper.reproduce", computed)
    monkeypatch.setattr("hypertuna.paper.page.ledger_sections", lambda _: [])
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(sys, "argv", ["hypertuna", "paper", "--json"])
    with pytest.raises(SystemExit) as done:
        main()
    told = json.loads(capsys.readouterr().out)
    assert not done.value.code
    assert told["entries"] == json.loads(json.dumps(ledger_record(ledger)))["entries"]
    monkeypatch.setattr(sys, "argv", ["hypertuna", "paper", "--full", "-o", str(tmp_path / "demo")])
    with pytest.raises(SystemExit):
        main()
    *counts, page = capsys.readouterr().out.splitlines()
    assert page == f"The page: {(tmp_path / 'demo' / 'index.html').as_uri()}"
    assert (tmp_path / "demo" / "index.html").is_file()
    assert len(counts) <= 5
    assert f"{ledger.summary['reproduced']} of {ledger.summary['predictions']} predicted numbers" in " ".join(counts)
    monkeypatch.setattr(sys, "argv", ["hypertuna", "paper"])
    with pytest.raises(SystemExit):
        main()
    output = capsys.readouterr().out
    assert all(entry.id in output for entry in ledger.entries)
    assert asked == [False, True, False]
    models, lines = ledger.summary["speeds"], [line.split() for line in output.splitlines()]
    rows = [entry for entry in ledger.entries if entry.model in models]
    for e in rows:  # each on one line of 80 columns
        row = " ".join((e.model, MARKS[e.verdict], e.computed_text, e.error, e.seeds_text)).split()
        assert row in lines, " ".join(row)
        if e.band is not None:
            below = [lines[k + 1] for k, line in enumerate(lines) if line == row]  # of equal rows too
            assert f"90 % of the family {e.band_text}".split() in below
