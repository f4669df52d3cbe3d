"""What shells and notebooks show: five lines of text, a card without script that names no color of its theme."""

import html
import inspect
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

import hypertuna as ht
from hypertuna.cli.console import print_lines
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.display import (
    Card,
    Displayed,
    Facts,
    Part,
    Plotted,
    Table,
    Tabular,
    card_html,
    card_of,
    card_text,
    cards,
    number,
)
from hypertuna.fe.bend import FeBend
from hypertuna.fe.comparison import FeComparison
from hypertuna.fe.joint_map import JointMap
from hypertuna.fe.measure import Measured
from hypertuna.fe.model import FeOptions

# Classes whose values are no results, or have no table or figure of their own, each with its reason.
PLAIN = {
    "InputError": "an error",
    "Leg": "a leg of a dive, which shows it",
    "Limit": "an argument: three values",
    "MeasuredBend": "numbers that their run shows",
    "Measurement": "a number that its design shows",
    "Glide": "rows that its trials show",
    "HeldThrust": "a number that its trials show",
    "Pose": "an argument: three values",
    "PowerRun": "a number that its trials show",
    "Sea": "an argument: three values",
    "Studio": "a page, not a result",
    "TankDesign": "a file: what it asks for is shown",
    "TankRun": "an argument: what to make",
    "Tow": "a number that its trials show",
    "TurnRun": "a number that its trials show",
    "YawDecay": "rows that its trials show",
}
NO_PLOT = {"Gaits": "plot_sweep draws what they swim", "SteadyRun": "one point of the figure of its trials"}
KINDS = [
    "robot",
    "gait",
    "gaits",
    "swim",
    "rest",
    "gradient",
    "turning",
    "bend",
    "optimum",
    "no-optimum",
    "front",
    "fit",
    "posterior",
    "twin",
    "losses",
    "dry twin",
    "sea",
    "dive",
    "posture",
    "mission",
    "flight",
    "record",
    "trials",
    "steady",
    "recording",
    "joints",
    "smooth",
    "track",
    "pump",
    "scoreboard",
    "bench",
    "next runs",
    "family",
    "spring",
]


def public_classes() -> set[str]:
    """Name the public classes, and those that public functions return; sweeps and replays are xarray's own."""
    classes = {name for name in ht.__all__ if inspect.isclass(getattr(ht, name))}
    functions = [getattr(ht, name) for name in ht.__all__ if inspect.isfunction(getattr(ht, name))]
    returned = {str(inspect.signature(function).return_annotation) for function in functions}
    others = {"xr.Dataset", "pd.DataFrame", "Figure", "Path", "Array", "None", "list[T]", "tuple[str, ...]"}
    words = {word for text in returned - others for word in re.findall(r"[A-Z]\w+", text)}
    return classes | words - {"Callable", "None", "Path"}


def test_every_public_result_is_shown_plotted_and_a_table(made: dict[str, Any]) -> None:
    shown = {kind.__name__: kind for value in made.values() for kind in [type(value)]}
    assert public_classes() - PLAIN.keys() <= shown.keys(), "no example in `made`"
    for name, kind in shown.items():
        assert issubclass(kind, Displayed), name
        assert issubclass(kind, Tabular), name
        assert issubclass(kind, Plotted) != (name in NO_PLOT), name


def results(kind: type) -> set[type]:
    """Return the classes below one that are results."""
    return {kind, *(one for below in type.__subclasses__(kind) for one in results(below))} - {Displayed, Plotted}


def test_every_class_with_a_card_is_shown_here(made: dict[str, Any]) -> None:
    shown = {type(value) for value in made.values()} | {FeBend, FeComparison, JointMap}  # these need an extra
    assert all(map(cards.__getitem__, shown))
    assert {*cards} == shown
    assert {kind for kind in results(Displayed) if kind.__module__.startswith("hypertuna.")} == shown
    assert {*made} == {*KINDS}


def test_every_type_of_result_has_a_picture(made: dict[str, Any]) -> None:
    drawn: dict[str, bool] = {}
    for kind, value in made.items():
        if kind != "no-optimum":  # nothing swims
            drawn[type(value).__name__] = re.search("<svg.*?<(path|circle|rect|poly)", value._repr_html_()) is not None
    assert [name for name, shown in drawn.items() if not shown] == []


# Numbers without a unit, by their label: counts and ratios.
COUNTS = {
    "links",
    "gaits",
    "settled",
    "gaits swum",
    "waypoints",
    "steady runs",
    "tracked recordings",
    "samples",
    "rows",
}
COUNTS |= {
    "members",
    "measured values",
    "tracked runs",
    "frames",
    "repeats",
    "steps",
    "walkers",
    "joint group",
    "times",
}
COUNTS |= {"waypoints reached", "waypoints passed", "waypoints skipped"}
RATIOS = {"Strouhal number", "efficiency", "charge left, part of the whole"}
BARE = re.compile(r"[-+]?[\d.]+(e[-+]?\d+)?")


@pytest.mark.parametrize("kind", KINDS)
def test_a_card_has_numbers_in_a_table_and_each_has_its_unit(made: dict[str, Any], kind: str) -> None:
    card = card_of(made[kind])
    tables = [part for part in card.parts if isinstance(part, Table)]
    facts = [pair for part in card.parts if isinstance(part, Facts) for pair in part.pairs()]
    if kind != "no-optimum":  # has a sentence that says why
        assert facts or any(table.rows for table in tables)
    bare = [label for label, value in facts if BARE.fullmatch(value)]
    for table in tables:
        if not {"unit", "training rms"} & {*table.heads}:  # it stands in the row, beside the value
            columns = zip(table.heads, zip(*table.rows, strict=True), strict=bool(table.rows))
            bare += [head for head, cells in columns if "[" not in head and any(map(numeric, cells))]
    plain = COUNTS | RATIOS
    if kind == "scoreboard":  # of counts and ratios alone
        plain |= {quantity.label or "" for quantity in made[kind].summary().values()} | {"ratio", "own\nratio"}
        plain |= {"published", "predicted"}  # below the sentence with their unit
    if kind == "bench":  # the sentence above says over what
        plain |= {"value"}
    assert {*bare} <= plain


def numeric(cell: str | tuple[str, str]) -> bool:
    """Whether a cell is a number without its unit."""
    return BARE.fullmatch(cell if isinstance(cell, str) else cell[0]) is not None


def texts(part: Part) -> list[tuple[str, str]]:
    """Return what a part says on a terminal, and in a notebook."""
    if isinstance(part, Table):
        cells = [cell if isinstance(cell, str) else cell[0] for row in part.rows for cell in row]
        return [(word, word) for text in [*part.heads, *cells] for word in text.split()]
    if isinstance(part, Facts):
        shown = [(f"{label} {value} {unit}", f"{value} {unit}") for label, value, unit in part.rows() if value != "nan"]
        return shown + [(label, label) for label, _, _ in part.rows()]
    text = part if isinstance(part, str) else part[0]
    return [(text, text)]


@pytest.mark.parametrize("kind", KINDS)
def test_a_terminal_and_a_notebook_show_the_same(
    made: dict[str, Any], kind: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "900")
    card = card_of(made[kind])
    print_lines(card.lines())
    terminal = " ".join(capsys.readouterr().out.split())
    page = re.sub("<style>.*?</style>|<svg.*?</svg>", "", made[kind]._repr_html_(), flags=re.DOTALL)
    page = " ".join(html.unescape(re.sub("<[^>]+>", " ", page)).split())
    assert page.startswith(" ".join(card.title.split()))
    for part in [card.title, *card.parts]:
        for printed, shown in texts(part):
            assert " ".join(printed.split()) in terminal
            assert " ".join(shown.split()) in page


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "fit"])  # whose page has more than its card
def test_a_page_shows_what_a_card_does(made: dict[str, Any], kind: str, tmp_path: Path) -> None:
    page = ht.report([made[kind], made[kind]], tmp_path / "page.html").read_text()
    identifiers = re.findall(r'<(?:section|figure) id="([^"]*)"', page)
    assert len({*identifiers}) == len(identifiers)
    words = re.sub("<style>.*?</style>|<svg.*?</svg>", "", page, flags=re.DOTALL)
    words = " ".join(html.unescape(re.sub("<[^>]+>", " ", words)).replace("\N{MINUS SIGN}", "-").split())
    card = card_of(made[kind])
    for _, shown in (pair for part in [card.title, *card.parts] for pair in texts(part)):
        assert " ".join(shown.split()).replace("`", "") in words


def test_the_bend_of_a_joint_by_finite_elements_is_shown(made: dict[str, Any]) -> None:
    spans = ((1.0, 1.0),) * 5
    states = tuple(Measured(angle, (0.1, 0.0), 0.1, *spans, *(1.0,) * 5, 0.9, "") for angle in (0.0, 0.1))
    pressure, none = np.array([0.0, 5e4]), (0, 0)
    bend = FeBend(
        made["robot"], "I", "left", FeOptions(), pressure, states, none, none, 9, 9, "converged", "Converged."
    )
    assert "50, 5.73, 100.00" in repr(bend)  # kPa, deg, mm
    assert bend._repr_html_().count("<circle") == 2


def test_a_sweep_is_shown_by_xarray_with_units(made: dict[str, Any]) -> None:
    sweep = made["turning"].sweep
    assert "xr-wrap" in sweep._repr_html_()
    assert all({"units", "flag_meanings"} & {*one.attrs} or one.dtype == bool for one in sweep.data_vars.values())
    assert all("long_name" in one.attrs for one in [*sweep.data_vars.values(), *sweep.coords.values()])


@pytest.mark.parametrize("kind", KINDS)
def test_a_result_is_five_lines_of_text(made: dict[str, Any], kind: str) -> None:
    lines = repr(made[kind]).splitlines()
    assert 1 <= len(lines) <= 5
    assert max(map(len, lines)) <= 100
    assert "array(" not in repr(made[kind])


class Tags(HTMLParser):
    """Collect the tags of a page, and check that each is closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open.append(tag)
        self.seen.add(tag)
        assert not [name for name, _ in attrs if name.startswith("on")]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.parametrize("kind", KINDS)
def test_a_result_is_a_card_without_script(made: dict[str, Any], kind: str) -> None:
    page = made[kind]._repr_html_()
    tags = Tags()
    tags.feed(page)
    assert not tags.open
    assert "script" not in tags.seen
    assert len(page) < 80_000
    assert "nan" not in re.sub(r"<[^>]+>", "", page).lower().split()
    for svg in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        ElementTree.fromstring(svg)
    for color in re.findall(r"#[0-9a-f]{3,6}\b", page):  # readable on white and on black: contrast 3 at least
        red, green, blue = (int(color[k : k + 2], 16) / 255 for k in (1, 3, 5))
        linear = [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in (red, green, blue)]
        light = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
        assert min(1.05 / (light + 0.05), (light + 0.05) / 0.05) > 3


def test_a_swim_of_a_robot_with_estimates_shows_their_band() -> None:
    swim = ht.swim(parse(new_robot("fish")), "cruise")
    assert swim.band is not None
    ends = f"{swim.band.low[0]:.3g} to {swim.band.high[0]:.3g} m/s"
    assert ends in repr(swim)
    assert ends in swim._repr_html_()
    assert len(repr(swim).splitlines()) <= 5


def test_a_gradient_names_the_largest_influence_first(made: dict[str, Any]) -> None:
    gradient, swim = made["gradient"], made["swim"]
    table = gradient.to_pandas()
    sizes = table.speed_percent.abs()
    assert (sizes.diff().dropna() <= 0).all()
    # 1 % more density, and 1 deg more amplitude, by two swims each
    first = gradient.gait.amplitude
    ends = [
        ht.swim(swim.robot, replace(swim.gait, amplitude=(first[0] + side * np.radians(0.5), first[1]))).speed
        for side in (-1, 1)
    ]
    expected = 100 * (ends[1] - ends[0]) / swim.speed
    assert table.set_index("parameter").speed_percent["gait.amplitude[0]"] == pytest.approx(expected, rel=1e-3)
    frequency = [ht.swim(swim.robot, replace(swim.gait, frequency=2.13 * (1 + side * 5e-3))).speed for side in (-1, 1)]
    expected = 100 * (frequency[1] - frequency[0]) / swim.speed
    assert table.set_index("parameter").speed_percent["gait.frequency"] == pytest.approx(expected, rel=1e-3)
    with pytest.raises(ht.InputError, match="quantity must be speed, speed_bl"):
        gradient.influence("sped")


PLOTS = [kind for kind in KINDS if kind not in ("gaits", "steady")]


@pytest.mark.parametrize("kind", PLOTS)
def test_a_result_plots_itself(made: dict[str, Any], kind: str) -> None:
    figure = made[kind].plot(width=5.0)
    assert figure.get_size_inches()[0] == 5
    assert figure._repr_png_().startswith(b"\x89PNG")  # what a notebook shows


@pytest.mark.parametrize("kind", KINDS)
def test_a_result_is_a_table(made: dict[str, Any], kind: str) -> None:
    table = made[kind].to_pandas()
    assert isinstance(table, pd.DataFrame)
    assert len(table)
    assert not table.columns.has_duplicates
    assert not [name for name in table.columns if name.endswith("_rad")]
    if "time_s" in table:
        assert table.time_s.is_monotonic_increasing
        assert table.time_s.is_unique
    assert isinstance(table.index, pd.RangeIndex)


def test_text_is_escaped_and_cut() -> None:
    facts = Facts({f"cost {k}": "1 J/(kg m)" for k in range(40)})
    card = Card("<b>", [facts, "word " * 99, Table(("x",), [("<i>",)] * 20)])
    assert "<i>" not in card_html(card)
    assert "&lt;b&gt;" in card_html(card)
    assert len(card_text(card).splitlines()) == 5
    assert card_html(card).count("<tr>") == 22


@pytest.mark.parametrize(
    ("value", "text"),
    [
        *((0.1234, "0.123"), (1234.5, "1234"), (-0.0, "-0"), (float("nan"), "–"), (1e-9, "1e-09"), (99.96, "100.0")),
        *((None, "–"), (0.0, "0"), (1e-4, "0.000100"), (9.99e-5, "9.99e-05"), (1.1e-4, "0.000110")),
        *((1e6, "1e+06"), (999999.0, "999999"), (-0.5, "-0.500")),
    ],
)
def test_numbers_are_written_to_three_digits(value: float, text: str) -> None:
    assert number(value) == text


def shown_without_matplotlib() -> str:
    return (
        "import sys, hypertuna as ht; fish = ht.load('hypertuna');"
        "swim = ht.swim(fish, ht.named_gait(fish, 'turning')); fish._repr_html_(); swim._repr_html_();"
        "assert 'matplotlib' not in sys.modules, 'matplotlib'"
    )


def test_a_card_needs_no_matplotlib() -> None:
    subprocess.run([sys.executable, "-c", shown_without_matplotlib()], check=True)


def test_a_card_names_a_bound_with_its_unit() -> None:
    best = ht.optimize("hypertuna", maximize="speed", bounds={"phase_II_deg": (0, 20)})
    page = best._repr_html_()
    assert "<span>phase II</span><b>20 deg (upper bound)</b>" in page
    assert "<span>frequency</span><b>6 Hz (upper bound)</b>" in page


def test_a_figure_is_as_wide_as_two_columns_unless_told(made: dict[str, Any]) -> None:
    assert made["gradient"].plot().get_figwidth() == 7.2
    assert made["gradient"].plot(width=5).get_figwidth() == 5
    content = made["gradient"].plot(width=5)._repr_png_()
    assert int.from_bytes(content[16:20], "big") == 720  # 144 dots per inch


def test_a_table_is_set_left_in_its_first_column_and_gives_way_nowhere() -> None:
    plain = Table(("a",), ())
    assert (plain.left, plain.fold, plain.whole, plain.tight) == ((0,), -1, -1, False)
    assert Table(("a", "long"), [("abc", "x"), ("b", ("y", "bold"))]).width() == 3 + 2 + 4 + 2


@pytest.mark.parametrize(
    ("facts", "rows", "lines"),
    [
        (0, 4, ["t", "r0", "r1", "r2", "r3"]),
        (0, 5, ["t", "r0", "r1", "r2", "... and 2 more"]),
        (1, 3, ["t", "f0", "r0", "r1", "r2"]),
        (1, 4, ["t", "f0", "r0", "r1", "... and 2 more"]),
        (2, 2, ["t", "f0", "f1", "r0", "r1"]),
        (3, 1, ["t", "f0", "f1", "f2", "r0"]),
        (3, 2, ["t", "f0", "f1", "f2"]),  # a line has no room for "more"
        (4, 1, ["t", "f0", "f1", "...", "r0"]),
        (4, 0, ["t", "f0", "f1", "..."]),
    ],
)
def test_a_text_of_five_lines_leaves_out_facts_before_rows(facts: int, rows: int, lines: list[str]) -> None:
    wide = {f"f{k}": "x" * 96 for k in range(facts)}  # a line each
    text = card_text(Card("t", [Facts(wide), Table(("a",), [(f"r{k}",) for k in range(rows)])]))
    assert [line.split(" x")[0] for line in text.splitlines()] == lines


def test_lines_are_cut_at_a_hundred_letters() -> None:
    for last, end in (("longe", "longe"), ("longer", "word ...")):  # 100 and 101 letters
        line = card_text(Card("t", [f"{'word ' * 19}{last}"])).splitlines()[1]
        assert len(line) <= 100
        assert line.endswith(end)


def test_sentences_are_shown_but_for_faint_ones_in_text() -> None:
    card = Card("t", ["One.", ("Two.", "bold"), ("Three.", "dim"), ""])
    assert card_text(card) == "t\nOne. Two."
    page = card_html(card)
    assert re.findall("<p>(.*?)</p>", page) == ["One.", "Two.", "Three."]


def test_a_page_has_title_picture_and_parts_in_order() -> None:
    rows = [("a", "1.5 m"), ("b", ("–", "dim")), ("c", "-2e-05")]
    card = Card("t", [Facts({"length": "2 m"}), Table(("name", "of\nwhat"), rows), Facts({})], lambda: "<svg></svg>")
    page = card_html(card)
    assert page.startswith('<div class="ht-card"><style>')
    head = '<tr><th class="ht-left">name</th><th >of what</th></tr>'
    body = "".join(
        f'<tr><td class="ht-left">{k}</td><td >{v}</td></tr>'
        for k, v in zip("abc", ("1.5 m", "–", "-2e-05"), strict=True)
    )
    assert page.partition("</style>")[2] == (
        '<div class="ht-title">t</div><svg></svg>'
        '<div class="ht-facts"><div><span>length</span><b>2 m</b></div></div>'
        f'<div class="ht-wide"><table class="ht-table"><thead>{head}</thead><tbody>{body}</tbody></table></div></div>'
    )
    assert '<td class="ht-left">n/a</td>' in card_html(Card("t", [Table(("a", "b"), [("x", "1"), ("y", "n/a")])]))


@pytest.mark.parametrize(("rows", "more"), [(8, None), (9, "1 more rows"), (11, "3 more rows")])
def test_a_table_of_more_than_eight_rows_is_folded(rows: int, more: str | None) -> None:
    page = card_html(Card("t", [Table(("a",), [(f"{k}",) for k in range(rows)])]))
    assert re.findall("<summary>(.*?)</summary>", page) == ([more] if more else [])
    assert page.partition("<details>")[0].count("<tr>") == 1 + min(rows, 8)
    assert page.count("<tr>") == 1 + rows + (rows > 8)
