"""The state of a design: it survives a kill, a second writer is refused, and it needs no other file."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.design.runs import Measurement, TankRun
from hypertuna.design.tank import TankDesign
from hypertuna.errors import InputError
from program import Run

MINNOW = Path(__file__).parents[2] / "examples" / "minnow.toml"


@pytest.fixture
def begun(tmp_path: Path) -> Path:
    """A design with two runs."""
    state = tmp_path / "tank.jsonl"
    with TankDesign(state, MINNOW) as tank:
        for speed in (0.13, 0.05):
            choice = tank.ask().choices[0]
            tank.tell([Measurement(choice.run, "speed", speed, name=choice.name, day="monday")])
    return state


def test_a_design_goes_on_from_its_file_alone(begun: Path) -> None:
    """The very next runs, of a robot whose file is gone."""
    with TankDesign(begun) as tank:
        first, steps = tank.ask(3), list(tank.steps)
    with TankDesign(begun) as tank:
        again = tank.ask(3)
        assert [one.run for one in again.choices] == [one.run for one in first.choices]
        assert tank.steps == steps
    assert [one.name for one in again.choices] == ["run-03", "run-04", "run-05"]
    assert [one.why for one in again.choices][1] == "check"
    assert [step.results[0].day for step in steps] == ["monday", "monday"]


def test_asking_for_more_runs_begins_with_those_of_fewer(begun: Path) -> None:
    with TankDesign(begun) as tank:
        few, many = tank.ask(1), tank.ask(6)
    assert [one.run for one in many.choices][:1] == [one.run for one in few.choices]
    widths = [one.half_width for one in many.choices]
    assert widths == sorted(widths, reverse=True)


def test_a_killed_writer_loses_nothing(begun: Path) -> None:
    """Killed at once after `tell` has returned, while the file is open."""
    code = (
        "import sys, os, signal\nfrom hypertuna.design.tank import TankDesign\n"
        "from hypertuna.design.runs import Measurement\n"
        "tank = TankDesign(sys.argv[1])\ntank.tell([Measurement(tank.ask().choices[0].run, 'speed', 0.1)])\n"
        "os.kill(os.getpid(), signal.SIGKILL)"
    )
    ended = subprocess.run([sys.executable, "-c", code, str(begun)], check=False)
    assert ended.returncode == -signal.SIGKILL
    torn = begun.read_bytes()
    with TankDesign(begun) as tank:
        assert len(tank.steps) == 3
    begun.write_bytes(torn[:-20])  # as if it had died within the write
    with TankDesign(begun) as tank:
        assert len(tank.steps) == 2


def test_a_second_writer_is_refused(begun: Path) -> None:
    with TankDesign(begun), pytest.raises(InputError, match="in use by another run"):
        TankDesign(begun)


def test_a_result_that_is_refused_leaves_the_state_as_it_was(begun: Path) -> None:
    before = begun.read_bytes()
    still = ht.Gait.from_degrees(frequency=1.0, amplitude=(0, 0, 0), phase=(0, 0, 0))
    with TankDesign(begun) as tank:
        good = tank.ask().choices[0].run
        with pytest.raises(InputError, match="no settled beat"):
            tank.tell([Measurement(good, "speed", 0.1), Measurement(TankRun("steady", still), "speed", 0.1)])
        assert len(tank.steps) == 2
    assert begun.read_bytes() == before


def test_a_damaged_state_is_refused_by_its_line(begun: Path) -> None:
    lines = begun.read_bytes().splitlines(keepends=True)
    begun.write_bytes(b"".join([lines[0], lines[1].replace(b"0.13", b"0.31"), *lines[2:]]))
    with pytest.raises(InputError, match="2 is damaged"):
        TankDesign(begun)


def test_a_design_ends_when_it_knows_enough() -> None:
    """Exact results: after four runs, the last of them a check, and once the width is met."""
    with TankDesign(None, MINNOW, width=0.5) as tank:
        for k in range(4):
            result = tank.ask()
            assert not result.stop, k
            choice = result.choices[0]
            value = choice.expected["speed"][0]
            tank.tell([Measurement(choice.run, "speed", value)])
        result = tank.ask(2)
        assert "Complete" in result.stop
        assert result.choices == ()


def test_a_check_that_fails_keeps_a_design_from_its_end() -> None:
    with TankDesign(None, MINNOW, width=1.0) as tank:
        for factor in (1.0, 1.0, 1.0, 3.0):
            choice = tank.ask().choices[0]
            tank.tell([Measurement(choice.run, "speed", choice.expected["speed"][0] * factor, sd=0.001)])
        result = tank.ask()
    assert result.stop == ""
    assert any("standard deviations from its prediction" in warning for warning in result.warnings)


def test_the_commands(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From a robot file to the next run: ask, a filled-in table, values, a page, a figure, JSON."""
    monkeypatch.chdir(tmp_path)
    state = ("--state", "tank.jsonl")
    code, output, _ = run("design", "ask", *state, "--robot", str(MINNOW), "--runs", "2", "-o", "next.csv")
    assert code == 0
    assert "run-02" in output
    rows = Path("next.csv").read_text().splitlines()
    filled = [line[:-1] + value + "," for line, value in zip(rows[1:], ("0.11", "0.06"), strict=True)]
    Path("next.csv").write_text("\n".join([rows[0], *filled]))
    code, output, errors = run("design", "tell", *state, "next.csv", "--day", "1", "--json")
    assert code == 0, errors
    record = json.loads(output)
    assert [one["speed"] for one in record["history"]] == [0.11, 0.06]
    assert [one["run"] for one in record["runs"]] == ["run-03"]
    code, output, _ = run("design", "tell", *state, "--value", "0.1", "--value", "0.09")
    assert code == 0
    assert "4 runs told" in output
    code, _, errors = run("design", "ask", *state, "--report", "tank.html", "--plot", "tank.svg")
    assert code == 0, errors
    assert "<svg" in Path("tank.html").read_text()
    with TankDesign("tank.jsonl") as tank:
        assert [one.day for one in tank.results] == ["1"] * 4


def test_the_commands_for_turns_and_what_a_tank_has(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    new = ("--robot", str(MINNOW), "--runs", "2")
    code, _, errors = run(
        *("design", "ask", "--state", "turn.jsonl", *new, "--want", "turn", "--bounds", "bias=0:15", "-o", "turn.csv")
    )
    assert code == 0, errors
    head, *rows = Path("turn.csv").read_text().splitlines()
    assert head.endswith(",turn_rate_deg_s")
    Path("turn.csv").write_text("\n".join([head, *(f"{row}-{12 + k}" for k, row in enumerate(rows))]))
    code, output, errors = run("design", "tell", "--state", "turn.jsonl", "turn.csv", "--json")
    assert code == 0, errors
    assert [one["turn_rate"] for one in json.loads(output)["history"]] == pytest.approx(np.radians([12, 13]))
    code, output, errors = run("design", "tell", "--state", "turn.jsonl", "--value", "15", "--json")
    assert code == 0, errors

    has = ("--want", "coefficients", "--tow", "--hold", "--glide")
    code, output, errors = run("design", "ask", "--state", "all.jsonl", *new, *has, "--json")
    assert code == 0, errors
    for name in ("tow", "thrust", "power", "glide"):
        path = Path(f"{name}.csv")
        gait = "2,8,12,16,0,40,80" if name in ("thrust", "power") else ""
        columns = "frequency_hz,amplitude_1_deg,amplitude_2_deg,amplitude_3_deg,phase_1_deg,phase_2_deg,phase_3_deg"
        table = {
            "tow": "u_m_s,drag_n\n0.3,0.06",
            "thrust": f"{columns},thrust_n\n{gait},0.05",
            "power": f"{columns},power_w\n{gait},0.03",
            "glide": "time_s,speed_m_s\n0,0.4\n1,0.25\n2,0.18\n3,0.15",
        }
        path.write_text(table[name])
        code, output, errors = run("design", "tell", "--state", "all.jsonl", str(path))
        assert code == 0, errors
    assert "4 runs told" in output


def test_runs_of_every_kind_are_written_and_told(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tow, a swim, a glide and a held thrust: the files are filled in as a user does, and tell the runs asked for."""
    monkeypatch.chdir(tmp_path)
    with TankDesign("all.jsonl", MINNOW, tow=True, hold=True, glide=True) as tank:
        asked = tank.ask()
        by_kind = {one.kind: one for one in tank.candidates}
        choices = [
            replace(asked.choices[0], name=f"run-{k + 1:02d}", run=own, expected={own.measured[0]: (0.1, 0.2)})
            for k, own in enumerate(by_kind[kind] for kind in ("tows", "steady", "glides", "thrusts"))
        ]
        monkeypatch.setattr(TankDesign, "ask", lambda *_: replace(asked, choices=tuple(choices)))
    code, output, errors = run("design", "ask", "--state", "all.jsonl", "-o", "next.csv")
    assert code == 0, errors
    names = ["next.csv", "next-steady.csv", "next-glides.csv", "next-thrusts.csv"]
    assert all(name in output for name in names)
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    speeds = iter((0.3, 0.2, 0.15, 0.12))
    values = {"drag_n": "0.06", "speed_m_s": "0.1", "thrust_n": "1"}
    for name in names:
        rows = list(csv.DictReader(Path(name).read_text().splitlines()))
        for k, row in enumerate(rows):
            glides = {"time_s": f"{k}", "speed_m_s": f"{next(speeds)}"} if "time_s" in row else values
            row |= {key: glides[key] for key in row if key in glides}
        Path(name).write_text("\n".join([",".join(rows[0]), *(",".join(row.values()) for row in rows)]))
    code, output, errors = run("design", "tell", "--state", "all.jsonl", *names)
    assert code == 0, errors
    with TankDesign("all.jsonl") as tank:
        told = [one.run for one in tank.results]
    assert [one.kind for one in told] == [one.run.kind for one in choices]
    assert [told[k] for k in (0, 1, 3)] == [choices[k].run for k in (0, 1, 3)]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("design ask --state new.jsonl", "new.jsonl does not exist: start one"),
        ("design ask --state new.jsonl --want cost", "--want needs --robot"),
        ("design ask --state new.jsonl --robot ROBOT --runs 0", "must be"),
        ("design ask --state new.jsonl --robot ROBOT --width 0", "width"),
        ("design ask --state new.jsonl --robot ROBOT --want turns", "--want must be"),
        ("design ask --state new.jsonl --robot ROBOT --want turn", "range of bias"),
        ("design ask --state new.jsonl --robot ROBOT --prior water.strip.drga=2", "drga"),
        ("design tell --state STATE", "must be given either in a CSV file or with --value"),
        ("design tell --state STATE --value 0.1,2,3", "must have at most 2 of speed, cost_of_transport"),
        ("design tell --state STATE --value=-0.1", "must be greater than 0"),
        ("optimize ask --state STATE", "must be the state of `hypertuna optimize ask`"),
    ],
)
def test_mistakes_are_one_sentence(
    run: Run, begun: Path, monkeypatch: pytest.MonkeyPatch, words: str, sentence: str
) -> None:
    monkeypatch.chdir(begun.parent)
    texts = words.replace("ROBOT", str(MINNOW)).replace("STATE", str(begun)).split()
    code, _, errors = run(*texts)
    assert code == 2
    assert sentence in errors
    assert errors.count("\n") == 1


def test_a_state_of_a_search_is_no_design(run: Run, tmp_path: Path) -> None:
    state = str(tmp_path / "search.jsonl")
    assert run("optimize", "ask", "--state", state, "--robot", str(MINNOW), "--maximize", "speed")[0] == 0
    code, _, errors = run("design", "ask", "--state", state)
    assert (code, "must be the state of `hypertuna design ask`" in errors) == (2, True)


def test_the_figure_and_the_table_have_every_run(begun: Path) -> None:
    with TankDesign(begun) as tank:
        result = tank.ask()
    assert list(result.to_pandas()["run"]) == ["run-01", "run-02"]
    above, below = result.plot().axes
    assert np.allclose(above.lines[1].get_ydata(), [100 * step.half_width for step in tank.steps])
    assert len(below.lines) == len(result.unknowns.names)


def test_a_speed_of_many_lengths_a_beat_is_refused_however_little_is_known() -> None:
    """In cm/s, which the first prediction, within a factor of 11, would not tell."""
    with TankDesign(None, MINNOW) as tank:
        run = tank.ask().choices[0].run
        with pytest.raises(InputError, match="must be at most 3 of the robot's lengths a beat, but is 21 m/s"):
            tank.tell([Measurement(run, "speed", 21.0, name="run-01")])
        tank.tell([Measurement(run, "speed", 0.21, name="run-01")])
