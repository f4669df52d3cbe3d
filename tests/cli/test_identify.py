"""The command `identify`: from files to files, and what it says of bad input."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.identification.plots import plot_intervals
from program import Run
from synthetic import grid, steady

GAITS = grid([2, 4, 6], [(8, 15), (16, 25)], [0, 30])
COLUMNS = ("frequency_hz", "amplitude_I_deg", "amplitude_II_deg", "phase_I_deg", "phase_II_deg", "speed_m_s")


@pytest.fixture(scope="module")
def tank(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A CSV file of twelve steady runs with 1 % noise on speed and cost of transport."""
    path = tmp_path_factory.mktemp("tank") / "tank.csv"
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow([*COLUMNS, "cost_of_transport_j_per_kg_m"])
        for run in steady(ht.load("hypertuna"), GAITS, noise=0.01).steady:
            angles = np.degrees([*run.gait.amplitude, *run.gait.phase]).round(9)
            rows.writerow([run.gait.frequency, *angles, run.speed, run.cost_of_transport])
    return str(path)


def test_from_a_file_of_runs_to_a_robot_that_other_commands_take(run: Run, tank: str, tmp_path: Path) -> None:
    output, report = tmp_path / "fit.toml", tmp_path / "fit.html"
    options = (
        "--robot",
        "hypertuna",
        "--free",
        "water.drag[0,7],joints.phase_offset[II]",
        "--starts",
        "2",
        "--seed",
        "3",
    )
    code, text, errors = run("identify", tank, *options, "-o", str(output), "--report", str(report), "--json")
    assert (code, errors) == (0, "")
    told = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    names = [row["name"] for row in told["parameters"]]
    assert names == ["water.lumped.drag[0]", "water.lumped.drag[7]", "joints.phase_offset[1]"]
    keys = ("name", "value", "sd", "low", "high", "unit", "scale", "lower", "upper", "prior", "bound", "constrained")
    assert tuple(told["parameters"][0]) == keys
    assert [row["unit"] for row in told["parameters"]] == ["1", "1", "deg"]
    assert told["parameters"][2]["upper"] == 90
    assert len(told["correlation"]) == len(told["directions"]) == 3
    assert {"singular_value", "constrained", "sentence"} <= set(told["directions"][0])
    assert len(told["train"]["runs"]) == 10
    assert len(told["validation"]["runs"]) == 2
    assert told["validation"]["rms"]["speed_relative"] < 0.05
    assert told["stop"].startswith("The search converged")
    robot = ht.load(output)
    assert (told["robot"], told["output"], told["fit_hash"]) == ("hypertuna", str(output), robot.hash)
    assert told["robot_hash"] == ht.load("hypertuna").hash
    assert np.degrees(robot.joints[1].phase_offset) == pytest.approx(told["parameters"][2]["value"])
    assert robot.water.lumped is not None
    assert robot.water.lumped.drag[7] == told["parameters"][1]["value"]
    page = report.read_text()
    assert page.count("<svg") == 4
    assert "<summary>All 12 runs, the worst first</summary>" in page
    assert all(f"tank.csv:{line}" in page for line in range(2, 14))
    assert all(text in page for text in ("hypertuna identify", told["robot_hash"], told["fit_hash"]))
    assert all(name in page for name in names)


def test_what_people_read(run: Run, tank: str) -> None:
    code, text, _ = run(
        "identify", tank, "--robot", "hypertuna", "--free", "water.drag[0]", "--starts", "1", "--posterior", "10"
    )
    assert code == 0
    for words in (
        "hypertuna, lumped water: 10 runs fitted, 2 kept for validation",
        "water.lumped.drag[0] ",
        "validation rms",
        "The search converged",
    ):
        assert words in text
    assert "autocorrelation times long" in text


def test_a_name_is_the_same_everywhere_and_not_broken_within_a_word(
    run: Run, tank: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = ("--robot", "hypertuna", "--free", "water.added_mass[*]", "--starts", "1")
    names = [one["name"] for one in json.loads(run("identify", tank, *options, "--json")[1])["parameters"]]
    assert names[0] == "water.lumped.added_mass[0]"
    wide = run("identify", tank, *options)[1]
    assert all(any(line.startswith(f"{name} ") for line in wide.splitlines()) for name in names)
    monkeypatch.setenv("COLUMNS", "50")
    narrow = run("identify", tank, *options)[1]
    first = " ".join(line.split(maxsplit=1)[0] for line in narrow.splitlines() if line[:1].strip())
    assert " ".join(name.replace("water.lumped.", "water.lumped. ") for name in names) in first
    fit = ht.identify("hypertuna", tank, ["water.drag[7]"], starts=1)
    labels = [text.get_text().replace("\n", "") for text in plot_intervals(fit).axes[0].get_yticklabels()]
    assert labels[0].startswith("water.lumped.drag[7]: ")


def test_laws_beside_each_other(run: Run, tank: str, tmp_path: Path) -> None:
    report = tmp_path / "fit.html"
    options = ("--robot", "hypertuna", "--free", "water.drag[7],water.drag_normal[7]", "--water", "lumped,strip")
    code, text, _ = run("identify", tank, *options, "--starts", "1", "--json", "--report", str(report))
    told = json.loads(text)
    assert code == 0
    assert told["best"] == "lumped"  # which made the runs
    assert told["laws"]["lumped"]["criteria"]["aicc"] < told["laws"]["strip"]["criteria"]["aicc"]
    assert "Which water law" in report.read_text()


def test_resumes_from_a_checkpoint(run: Run, tank: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second run answers all searches from the file, and writes nothing to it."""
    path = tmp_path / "fit.jsonl"
    options = (
        tank,
        "--robot",
        "hypertuna",
        "--free",
        "water.drag[7]",
        "--starts",
        "2",
        "--checkpoint",
        str(path),
        "--json",
    )
    first, known = json.loads(run("identify", *options)[1]), path.read_bytes()
    monkeypatch.setattr("hypertuna.identification.search._search_from", lambda *_, **__: pytest.fail("searched anew"))
    again = json.loads(run("identify", *options)[1])
    assert path.read_bytes() == known
    for told in (first, again):
        del told["seconds"]
    assert again == first


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--free", "water.dragg"), "free water.dragg is not a coefficient that can be free: did you mean water.drag?"),
        (("--free", "water.strip.drag_normal"), "choose water = 'strip' in [model]"),
        (("--free", "water.drag[8]"), "must have indices from 0 to 7"),
        (("--free", ""), "free must name at least one coefficient"),
        (("--free", "water.drag", "--validate", "1"), "validate must be at least 0 and less than 1, but is 1"),
        (("--free", "water.drag", "--validate", "most"), "--validate must be a number, but is 'most'"),
        (("--free", "water.drag", "--loss", "l1"), "--loss must be soft_l1, linear, huber or cauchy, but is 'l1'"),
        (("--free", "water.drag", "--bounds", "water.drag"), "--bounds must be NAME=LOW:HIGH, but is water.drag"),
        (("--free", "water.drag", "--bounds", "water.drag=3"), "--bounds water.drag must be LOW:HIGH, but is '3'"),
        (("--free", "water.drag", "--bounds", "water.friction=0:1"), "must be a free coefficient"),
        (("--free", "water.drag", "--start", "water.drag=99"), "must start within its bounds, 0 to 30, but is 99"),
        (
            ("--free", "water.drag", "--water", "lump"),
            "--water must be a known water law, but is 'lump': did you mean lumped?",
        ),
        (("--free", "water.drag", "--posterior", "3"), "posterior must be from 10 to 100000"),
        (("--free", "water.drag", "-o", "fit.txt"), "--output must end in .toml"),
        (("--free", "time_offset"), "the trials have none"),
        (("--free", "joints.bandwidth", "--joints", "ideal"), "is not used by model.joints = 'ideal'"),
    ],
)
def test_bad_input(run: Run, tank: str, options: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run("identify", tank, "--robot", "hypertuna", "--starts", "1", *options)
    assert (code, output) == (2, "")
    assert sentence in errors
    assert "Traceback" not in errors


def test_bad_rows_are_named_by_file_and_line(run: Run, tank: str, tmp_path: Path) -> None:
    lines = Path(tank).read_text().splitlines()
    lines[4] = lines[4].replace(lines[4].split(",")[5], "fast")
    bad = tmp_path / "bad.csv"
    bad.write_text("\n".join(lines))
    code, _, errors = run("identify", str(bad), "--robot", "hypertuna", "--free", "water.drag")
    assert code == 2
    assert f"{bad}: line 5" in errors


def test_a_narrow_terminal_keeps_remarks_whole(run: Run, tank: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    bounds = ("--bounds", "water.lumped.added_mass[0+2+4+6-7]=0.9:1")
    code, text, _ = run(
        "identify",
        tank,
        *("--robot", "hypertuna", "--free", "water.added_mass[0+2+4+6-7],water.drag[7]", "--starts", "1"),
        *("--start", "water.added_mass=0.95", "--posterior", "10", *bounds),
    )
    assert code == 0
    assert "lower bound" in text
    assert "…" not in text
    assert "1 runs" not in text
    assert " 1:" not in text  # a number has no unit


def test_a_law_without_free_coefficients_of_its_own_is_told(run: Run, tank: str) -> None:
    options = ("--robot", "hypertuna", "--free", "water.drag_normal[7],joints.bandwidth", "--water", "strip,lumped")
    told = json.loads(run("identify", tank, *options, "--starts", "1", "--json")[1])
    for law in ("strip", "lumped"):
        assert told["laws"][law]["warnings"][0].startswith("The lumped law has no free water coefficient of its own")


def test_far_speeds_are_fitted_with_a_warning(run: Run, tmp_path: Path) -> None:
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(0, 0))
    runs = tmp_path / "far.csv"
    head = "frequency_hz,amplitude_I_deg,amplitude_II_deg,phase_II_deg,speed_m_s"
    runs.write_text(f"{head}\n2,16,25,0,{15 * ht.swim('hypertuna', gait).speed}\n")
    code, text, errors = run("identify", str(runs), "--free", "water.drag[7]", "--starts", "1")
    text = " ".join(text.split())
    assert (code, errors) == (0, "")
    assert "the measured speeds are 15 times those of the model: likely causes are another unit" in text
    assert "but to a training error of" in text


def test_speeds_in_another_unit_are_refused_from_python_too(tmp_path: Path) -> None:
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(0, 0))
    run = ht.SteadyRun("cm", gait, 100 * ht.swim("hypertuna", gait).speed, file="cm.csv")
    with pytest.raises(ht.InputError, match=r"cm\.csv: the measured speeds are 100 times .*: check the unit, m/s"):
        ht.identify("hypertuna", ht.Trials((run,)), "water.drag[7]")


def test_speeds_in_another_unit_are_refused_before_the_fit(run: Run, tank: str, tmp_path: Path) -> None:
    """Centimeters a second would be fitted by a drag of a ten thousandth, without a word."""
    with open(tank, newline="") as file:
        head, *rows = csv.reader(file)
    at, wrong, output = head.index("speed_m_s"), tmp_path / "cm.csv", tmp_path / "fit.toml"
    with wrong.open("w", newline="") as file:
        scaled = [[*row[:at], 100 * float(row[at]), *row[at + 1 :]] for row in rows]
        csv.writer(file).writerows([head, *scaled])
    code, _, errors = run("identify", str(wrong), "--free", "joints.bandwidth", "-o", str(output))
    assert code == 2
    assert "cm.csv: the measured speeds are 100 times those of the model: check the unit, m/s." in errors
    assert not output.exists()


def test_a_search_that_did_not_converge_exits_with_1(run: Run, tank: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hypertuna.identification.search.MAX_EVALUATIONS", 1)
    code, text, _ = run("identify", tank, "--robot", "hypertuna", "--free", "water.drag[0,7]", "--starts", "1")
    assert code == 1
    assert "before it had converged" in text
