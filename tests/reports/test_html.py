"""Pages need nothing else, say every section, and tell what their figures show and how they were made."""

import io
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import hypertuna as ht
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.figures import INK, styled
from hypertuna.identification.identify import identify
from hypertuna.paper.figures import plot_dots, plot_map
from hypertuna.reports import html
from hypertuna.reports.html import Fact, Picture, Section, Table, inline, page, write_page
from hypertuna.simulation.posture import posture_test

VOID = {"meta", "br", "hr", "img", "link", "input"}


class Page(HTMLParser):
    """The elements of a page: which are open, what they refer to, and their text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.references: list[str] = []
        self.identifiers: list[str] = []
        self.words = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name in ("src", "href", "xlink:href", "action"):
                self.references.append(value or "")
            if name == "id":
                self.identifiers.append(value or "")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data: str) -> None:
        self.words += data


@styled
def line() -> Figure:
    figure = Figure(figsize=(4, 2))
    figure.subplots().plot([0, 1], [1, 2], color=INK, label="rise & fall")
    return figure


def sections() -> list[Section]:
    picture = Picture("line", line(), "A line that rises.", "Made by `plot`.")
    other = Picture("other", line(), "The same.", "Made again.")
    table = Table(["gait", "speed [m/s]"], [["slow", 0.12345], ["fast", "0.5 ± 0.1"]], "Two speeds.", "Computed.")
    return [
        Section("First", ["Some **words** of `code`.\n\nA second paragraph.", picture, other]),
        Section("Second", [table]),
    ]


def test_a_page_holds_everything_and_needs_nothing_else() -> None:
    text = page("Title", sections(), lede="What it is about.", facts=[Fact("5 %", "of all")])
    found = Page(text)
    assert not found.open
    assert len(set(found.identifiers)) == len(found.identifiers)
    assert all(reference.startswith("#") for reference in found.references)
    assert {reference[1:] for reference in found.references} <= set(found.identifiers)
    assert not re.search(r"url\((?!#)|@import|https?://(?!www\.w3\.org)", text)
    texts = ("Title", "What it is about.", "5\N{NO-BREAK SPACE}%", "First", "A second paragraph.", "A line that rises.")
    for words in (*texts, "Made by plot.", "Second", "0.123", "0.5 ± 0.1", "Two speeds.", "Computed."):
        assert words in found.words
    assert "<strong>words</strong>" in text
    assert "<code>plot</code>" in text


def test_light_and_dark() -> None:
    text = page("Title", sections())
    assert "@media (prefers-color-scheme: dark)" in text
    svg = inline(sections()[0].parts[1])  # type: ignore[arg-type]
    assert INK.lower() not in svg.lower()
    assert "var(--ink)" in svg


def test_pictures_on_white_are_turned_dark() -> None:
    from PIL import Image

    content = io.BytesIO()
    Image.new("RGB", (4, 3), "white").save(content, "PNG")
    text = page("Title", [Section("One", [Picture("photo", content.getvalue(), "White.", "Made.")])])
    assert '<svg class="photo"' in text
    assert "figure svg.photo { filter: invert(1)" in text


def test_numbers_have_a_minus_sign_and_code_keeps_its_hyphen() -> None:
    parts = ["It is -3 % or (-4.5), of 1-6, `-5`.", Picture("line", line(), "At -2 m.", "Made."), "A-7 of 2026-11-21."]
    words = Page(page("Title", [Section("One", parts)])).words
    for text in ("\N{MINUS SIGN}3", "(\N{MINUS SIGN}4.5)", "1-6", "-5.", "At \N{MINUS SIGN}2", "A-7 of 2026-11-21."):
        assert text in words


def test_headings_have_anchors_and_short_sections_stand_side_by_side() -> None:
    tall = [styled(lambda: Figure(figsize=(4, 9)))() for _ in range(2)]
    short = [Section(f"Tall {k}", ["Some words.", Picture(f"figure-{k}", tall[k], "", "")]) for k in range(2)]
    text = page("Title", [sections()[0], *short])
    assert {"section-first", "section-tall-0", "section-tall-1"} <= set(re.findall(r'<section id="([^"]*)"', text))
    pairs = re.findall(r'<div class="pair">\s*<section id="([^"]*)">.*?<section id="([^"]*)">', text, flags=re.DOTALL)
    assert pairs == [("section-tall-0", "section-tall-1")]


def test_what_a_page_shows_is_escaped() -> None:
    bad = "<script>alert(1)</script>"
    parts = [bad, Picture("line", line(), bad, bad), Table([bad], [[bad]], bad, bad)]
    text = page(bad, [Section(bad, parts)], lede=bad, facts=[Fact(bad, bad)])
    assert "<script>alert" not in text
    assert not Page(text).open


def test_two_columns_without_a_broken_paragraph_in_reading_order() -> None:
    wide = Table([f"a long head {k}" for k in range(9)], [["a cell of some length"] * 9], "Wide.", "")
    pictures = [Picture(name, line(), "", "") for name in ("line", "other")]
    text = page("Title", [Section("One", [f"One.{' Go on.' * 30}\n\nTwo.{' Go on.' * 30}", *pictures, wide, "Last."])])
    places = [text.index(part) for part in ("<p>One.", "<p>Two.", 'id="line"', 'id="other"', "Wide.", "<p>Last.")]
    assert places == sorted(places)
    assert "section { columns: 2;" in text
    assert ".text p, figure { break-inside: avoid; }" in text
    spans = re.findall(r'<(\w+) class="[^"]*\bwide"', text)
    assert spans == ["figure", "div"]  # the wide table, and the text after it
    for words in ("<p>One.", "<p>Two.", "<p>Last."):
        assert text.count(words) == 1


def test_columns_of_numbers() -> None:
    table = Table(
        ["name", "value", "unit", "error"], [["2 Hz", "0, its bound", "1", ""], ["", 0.5, "Hz", "-3 %"]], "", ""
    )
    assert table.numeric == (False, True, False, True)


def test_a_map_marks_the_best_phase_of_each_frequency() -> None:
    fish = ht.load("hypertuna")
    phases = [(0.0, phase) for phase in np.radians([0, 40, 80])]
    levels = np.radians([(8, 15), (16, 25)]).tolist()
    tank = ht.sweep(fish, ht.Gaits.grid(frequency=[2.0, 6.0], amplitude=levels, phase=phases))
    figure = plot_map(tank, "speed", "speed [m/s]", {"small": 20.0, "large": None})
    for k, axes in enumerate(figure.axes[:2]):
        speed = tank.speed.isel(amplitude=k, bias=0).transpose("phase", "frequency").values
        assert list(axes.lines[0].get_ydata()) == pytest.approx([(0, 40, 80)[row] for row in speed.argmax(axis=0)])
    assert [len(axes.lines) for axes in figure.axes[:2]] == [2, 1]  # the published phase, where there is one


def test_dots_stand_in_order_with_their_numbers() -> None:
    figure = plot_dots(
        [("cheap", 1.0, "fish"), ("dear", 5621.0, "other"), ("ours", 2.5, "computed")], "cost [J]", log=True
    )
    (axes,) = figure.axes
    assert [text.get_text() for text in axes.get_yticklabels()] == ["cheap", "dear", "ours"]
    assert [text.get_text() for text in axes.texts] == ["1", "5621", "2.5"]
    assert axes.get_ylim()[0] > axes.get_ylim()[1]  # the first on top


def test_results_of_every_kind_on_one_page(tmp_path: Path) -> None:
    fish = ht.load("hypertuna")
    gait = ht.named_gait(fish, "unoptimised-max")
    best = ht.optimize(fish, maximize="speed", method="gradient", particles=1)
    front = ht.pareto(fish, population=8, generations=2, polish=False)
    speeds = [(name, ht.swim(fish, ht.named_gait(fish, name)).speed) for name in ("unoptimised-0.3", "unoptimised-max")]
    runs = tuple(ht.SteadyRun(name, ht.named_gait(fish, name), speed=speed) for name, speed in speeds)
    fit = identify(fish, ht.Trials(runs), ["joints.bandwidth"], validate=0, starts=1)
    run = ht.twin(fish, ht.named_gait(fish, "unoptimised-0.3"), duration=3)
    test = posture_test(fish, frequencies=[2.0], angle=[0.2, 0.2], duration=2, limits=False)
    text = ht.report([ht.swim(fish, gait), run, test, best, fit, front], tmp_path / "fish.html").read_text()
    found = Page(text)
    assert not found.open
    assert len(set(found.identifiers)) == len(found.identifiers)
    assert f"{best.speed:.3g}" in found.words
    for words in (
        "hypertuna, 6 Hz",
        f"hypertuna, {run.gait.frequency:.4g} Hz",
        "posture control in air",
        "highest speed",
        "Coefficients",
        "best compromises",
    ):
        assert words in found.words.replace("\N{NO-BREAK SPACE}", " ")
    with pytest.raises(InputError, match="at least one result"):
        ht.report([], tmp_path / "none.html")
    for bad in (3, [3], "fish"):
        with pytest.raises(InputError, match="results must be a result or a list of them, but is"):
            ht.report(bad, tmp_path / "none.html")
    assert not (tmp_path / "none.html").exists()


def test_the_band_of_a_robot_with_estimates_is_on_the_page(tmp_path: Path) -> None:
    swim = ht.swim(parse(new_robot("fish")), "cruise")
    assert swim.band is not None
    assert swim.band.ends() in Page(ht.report(swim, tmp_path / "band.html").read_text()).words.replace(
        "\N{NO-BREAK SPACE}", " "
    )
    assert "estimates" not in ht.report(ht.swim("hypertuna", "turning"), tmp_path / "none.html").read_text()


def test_a_page_on_a_gait_has_the_command_that_swims_it_in_the_studio(tmp_path: Path) -> None:
    fish = ht.load("hypertuna")
    ht.report(ht.swim(fish.using(joints="ideal"), "turning"), tmp_path / "a.html")
    line = "Turn the knobs of this gait in the browser: "
    command = "hypertuna studio hypertuna --frequency 2 --amplitude 16,25 --phase 0,200 --bias 16,25 --joints ideal"
    assert f"{line}<code>{command}</code>." in (tmp_path / "a.html").read_text()
    other = fish.model_copy(update={"body": fish.body.model_copy(update={"mass": 3.5})})  # in no file
    ht.report(ht.swim(other, ht.named_gait(fish, "turning")), tmp_path / "b.html")
    assert line not in (tmp_path / "b.html").read_text()


def test_a_page_is_written_whole(tmp_path: Path) -> None:
    path = write_page("Title", sections(), tmp_path / "page.html")
    assert path.read_text() == page("Title", sections())
    with pytest.raises(InputError):
        write_page("Title", sections(), path / "below a file.html")


def test_a_line_of_a_template_with_a_tag_alone_leaves_no_line() -> None:
    """An empty line would end a paragraph or a table of Markdown, and spaces before one would make it code."""
    template = html._environment("hypertuna.reports").from_string("one\n  {% if true %}\ntwo\n  {% endif %}\nthree")
    assert template.render() == "one\ntwo\nthree"
