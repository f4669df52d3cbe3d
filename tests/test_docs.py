"""The documentation tells what the program does: its tables, outputs and pictures are made by the program."""

import re
import runpy
import shlex
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.sizing import largest_beat, size_pump
from hypertuna.paper.reproduce import Ledger
from program import Run

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted(path for path in (ROOT / "docs").rglob("*.md") if "_build" not in path.parts)]
TASKS = [page for page in PAGES if page.parent.name in ("start", "howto") or page.name == "README.md"]
HEAVIEST = 300_000  # bytes of a picture

# What takes minutes as written, and what the test runs in its place.
SHORTER = {
    "--seeds 0:100": "--seeds 0:2 --duration 5",
    "mission box": "mission box --duration 5",
    "mission first.toml": "mission first.toml --duration 5",
    "--robust worst5": "--robust worst5 --samples 4 --population 8 --generations 2",
}
# What needs an extra, a board or a robot: that its options exist is all the test checks.
OPTIONS_ALONE = ("hypertuna fe ", "hypertuna hil ", "hypertuna radio ", "hypertuna identify tank.mcap ")
TOOLS = (".", "jupyter", "pip", "python3", "sudo")  # run by no test here; those of installing by test_make.py


def named(page: Path) -> str:
    """Return the name of a page in the output of the tests."""
    return str(page.relative_to(ROOT))


@pytest.fixture(scope="module")
def figures(ledger: Ledger) -> dict[str, Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hypertuna.paper.reproduce.reproduce", lambda: ledger)
        return runpy.run_path(str(ROOT / "docs" / "figures.py"))


def words(picture: Path) -> list[str]:
    """Return the texts of an SVG picture, which matplotlib leaves in comments where it draws letters as curves."""
    return re.findall(r"<!-- (.*?) -->", picture.read_text())


def steady(text: str) -> str:
    """Hide what is rounding error alone, and how long it took: they differ from machine to machine."""
    text = re.sub(r"\b[\d.]+(\s+s in all)\b", r"0\1", text)
    return re.sub(r"\b\d(\.\d+)?e-(0[7-9]|1\d)\b", "0", text)


def sampled(text: str) -> tuple[str, list[float]]:
    """Return a page without the intervals in its tables, and their ends: refits to noise differ between processors."""
    interval = r"\| (-?[\d.]+) \.\. (-?[\d.]+) \|"
    return re.sub(interval, "| interval |", text), [float(x) for pair in re.findall(interval, text) for x in pair]


def searched(text: str) -> str:
    """Hide numbers of Pareto fronts, and how many gaits a method tried: processors sort and round otherwise."""
    front = r"^\$ hypertuna pareto.*?(?=^\$|^```)"
    number = r"\d[\d.]*(e[-+]\d+)?,?|\s+"
    text = re.sub(front, lambda one: re.sub(number, " ", one[0]), text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^\d+ gaits by", "count gaits by", re.sub(r" {2,}", " ", text), flags=re.MULTILINE)
    return re.sub(r"^(\| \w+ \| `\w+` \|.*\|) \d+ \|$", r"\1 count |", text, flags=re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_tables_and_outputs_are_the_program_s(page: Path, figures: dict[str, Any]) -> None:
    text = page.read_text()
    filled = figures["filled"](text)
    (plain, ends), (made, computed) = sampled(text), sampled(filled)
    assert searched(steady(plain)) == searched(steady(made)), f"run: python docs/figures.py and look at {page.name}"
    np.testing.assert_allclose(ends, computed, rtol=0.05)


def test_every_table_is_shown_somewhere(figures: dict[str, Any]) -> None:
    shown = {name for page in PAGES for name in re.findall(r"<!-- table: (.+?) -->", page.read_text())}
    assert shown == set(figures["TABLES"])


PARTS = 4  # of the pictures, so that workers share them


@pytest.mark.parametrize("part", range(PARTS))
def test_pictures_are_the_program_s(part: int, figures: dict[str, Any], tmp_path: Path) -> None:
    for name, picture in [*figures["PICTURES"].items()][part::PARTS]:
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
def test_no_line_is_a_comment(page: Path) -> None:
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    assert re.findall(r"^\s*%.*", text, flags=re.MULTILINE) == []  # the site leaves such a line out


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


def test_numbers_of_the_pump_in_the_text_are_the_program_s() -> None:
    text = " ".join((ROOT / "docs/hydraulics.md").read_text().split())
    robot = ht.load("hypertuna")
    frequency, amplitude = largest_beat(robot)
    line = robot.joints[0].line
    assert line is not None
    own = line.bore
    bores, temperatures = (3e-3, own, 6e-3), (293.15, 303.15)
    sizes = size_pump(robot, frequency=[frequency], amplitude=amplitude, bore=bores, temperature=temperatures)
    one = {(size.joint, size.bore, round(size.temperature - 273.15)): size for size in sizes}
    reynolds = [f"{one['I', own, degrees].reynolds:.0f} at {degrees} °C" for degrees in (20, 30)]
    assert f"Reynolds number of joint I's line is {' and '.join(reynolds)}" in text
    bends = [np.degrees(one["II", bore, 20].bend) for bore in bores]
    said = f"joint II bends by {bends[0]:.1f} deg at 6 Hz; with {1e3 * own:g} mm it bends by {bends[1]:.1f} deg"
    assert f"{said}, and 6 mm adds nothing" in text
    assert bends[2] < bends[1]
    power = sum(one[joint, own, 20].electrical_power["hydraulic"] for joint in ("I", "II"))
    assert f"The servos put {power:.1f} W into the oil" in text
    assert f"by {power / (60 * 1.9):.2f} K/s at first" in text
    assert f"{power / 0.5:.1f} K warmer" in text


def test_numbers_of_the_bring_up_in_the_text_are_the_robot_s() -> None:
    text = " ".join((ROOT / "docs/howto/bring-up.md").read_text().split())
    robot = ht.load("hypertuna")
    firmware, controller, battery = robot.firmware, robot.controller, robot.battery
    assert firmware is not None
    assert controller is not None
    assert battery is not None
    assert f"the circuits see up to {controller.pressure_hard / 1e3:.0f} kPa" in text
    air = f"{firmware.radio_baud:,} bit/s at the wire, {firmware.link_rate / 1e3:g} kbit/s in the air"
    assert air in text
    assert f"servo rail under power | as in the file, {battery.converter:g} V" in text
    assert firmware.leak_after < 2
    assert "the fault must appear within two seconds" in text
    assert next(iter(robot.gaits)) == "unoptimised-max"
    assert "**Do not press 1**: it is the fastest gait of the file" in text
    assert max(robot.gaits.values(), key=lambda gait: gait.frequency) == robot.gaits["unoptimised-max"]


@pytest.mark.parametrize("page", TASKS, ids=named)
def test_sentences_of_a_task_are_short(page: Path) -> None:
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


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('<img src="a.html">', "a.html: no text for a.html"),
        ('<img src="a.html" alt="" >', "a.html: no text for a.html"),
        ('<a class="reference internal" href="a.html"><code>shape</code></a>', "a.html: a link of the word shape"),
        ("<pre>code</pre>", "a.html: code that no key can scroll"),
        ('<a href="a.html">a</a><img src="a.html" alt="A">', "a.html: no link to a.html, to see it in full size"),
        ('<p style="background: url(https://example.org/x.png)">', "a.html: fetches https://example.org/x.png"),
    ],
)
def test_the_check_of_the_site_finds_what_a_page_lacks(text: str, fault: str, tmp_path: Path) -> None:
    check = runpy.run_path(str(ROOT / "docs/check_site.py"))["faults"]
    (tmp_path / "a.html").write_text(
        '<a href="a.html"><img src="a.html" alt="A fish"></a><a class="reference" href="a.html">shapes</a>'
    )
    assert check(tmp_path) == []
    (tmp_path / "a.html").write_text(text)
    assert check(tmp_path) == [fault]


def test_the_check_of_the_site_reads_style_sheets(tmp_path: Path) -> None:
    check = runpy.run_path(str(ROOT / "docs/check_site.py"))["faults"]
    (tmp_path / "a.css").write_text("@import 'https://example.org/a.css'; p { background: url(https://example.org/b) }")
    assert check(tmp_path) == ["a.css: fetches https://example.org/a.css", "a.css: fetches https://example.org/b"]


def commands(text: str) -> list[str]:
    """Return the shell commands of a page in order; of those with their output, which the figures run, only writers."""
    found = []
    for kind, block in re.findall(r"^```(sh|console)\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE):
        lines = re.sub(r"\s+#.*", "", block).splitlines()
        if kind == "console":
            lines = [line[2:] for line in lines if line.startswith("$ ") and (" -o " in line or " new " in line)]
        found += [part.strip() for line in lines for part in line.split("&&") if part.strip()]
    return found


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder as the pages take it for granted: robots, trials, a bench and a mission of one's own."""
    for robot in ("minnow", "servofish"):
        shutil.copy(ROOT / f"examples/{robot}.toml", tmp_path)
    for trials in ("tank", "eel"):
        shutil.copytree(ROOT / "examples" / trials, tmp_path / trials)
    for bench in ("bench", "paper"):
        shutil.copy(ROOT / f"examples/bench/{bench}.csv", tmp_path)
    shutil.copy(ROOT / "examples/learning/goto.npz", tmp_path)
    shutil.copy(ROOT / "missions/box.toml", tmp_path / "mine.toml")
    (tmp_path / "firmware/robots").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def executed(command: str, run: Run) -> str:
    """Execute a command of a page, shorter if need be; return what is wrong, or nothing."""
    program, *arguments = shlex.split(command)
    if program == "make":
        rules = "".join(path.read_text() for path in (ROOT / "Makefile", *(ROOT / "make").iterdir()) if path.is_file())
        return "" if re.search(rf"^{arguments[0]}:", rules, flags=re.MULTILINE) else "no such target"
    if program != "hypertuna":
        return "" if program in TOOLS else "no known program"
    served = command.startswith("hypertuna studio") and " -o " not in command  # until Ctrl-C
    if served or command.startswith(OPTIONS_ALONE):
        code, _, said = run(*arguments, "--help")
        return said if code else ""
    for long, short in SHORTER.items():
        command = command.replace(long, short)
    code, _, said = run(*shlex.split(command)[1:])
    early = "mission" in arguments and code == 1  # a flight that is cut short has not come home
    return said if code and not early else ""


@pytest.mark.parametrize("page", [page for page in TASKS if commands(page.read_text())], ids=named)
def test_every_command_of_a_task_runs(page: Path, folder: Path, run: Run) -> None:
    for command in commands(page.read_text()):
        assert executed(command, run) == "", command


@pytest.mark.parametrize(
    "command",
    ["hypertuna swim --robot hypertuna --gate cruise", "hypertuna hil --bord pc", "make demos", "hypertona swim"],
)
def test_a_wrong_command_of_a_page_is_found(command: str, folder: Path, run: Run) -> None:
    assert executed(command, run) != ""


def test_every_block_of_a_task_is_of_a_kind_that_is_run() -> None:
    """Python blocks run as doctests (>>>), console blocks are made by figures.py, shell blocks run above."""
    for page in TASKS:
        kinds = set(re.findall(r"^```(\w+)$", page.read_text(), flags=re.MULTILINE))
        assert kinds <= {"sh", "console", "pycon"}, page


def test_a_page_of_a_model_begins_with_its_picture_and_what_it_leaves_out() -> None:
    listed = re.findall(r"\]\((\w+\.md)\)", (ROOT / "docs/understand.md").read_text())
    assert len(listed) > 10
    for name in listed:
        _, picture, sentences, *_ = (ROOT / "docs" / name).read_text().split("\n\n")
        assert re.fullmatch(r"!\[.+\]\(.+\)", picture), name
        assert sentences.count(". ") == 1, name
        assert len(sentences.split()) < 50, name
