"""Results that a design does not take: of another unit, entered before, beyond the robot, of another kind."""

from __future__ import annotations

from pathlib import Path

import pytest

from hypertuna.design.tank import TankDesign
from program import Run

THREE = Path(__file__).parents[3] / "shared" / "cases" / "three.toml"
pytestmark = pytest.mark.skipif(not THREE.exists(), reason="the cases are not there")
HEAD = "run,frequency_hz,amplitude_J1_deg,amplitude_J2_deg,phase_J1_deg,phase_J2_deg,speed_m_s\n"
TRACK = "dlc-labeled-images.csv"


@pytest.fixture
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new design of a robot of two joints, in the folder of the test."""
    monkeypatch.chdir(tmp_path)
    with TankDesign("tank.jsonl", THREE, tow=True, glide=True) as tank:
        gait = tank.ask().choices[0].run.gait
    assert gait is not None
    assert gait.frequency == 2.25  # of the tables below
    Path(TRACK).write_bytes((THREE.parent / TRACK).read_bytes())
    return tmp_path / "tank.jsonl"


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        (HEAD + "run-01,2.25,16.8,15.1,0,81,17.5", "is it in cm/s?"),
        (HEAD + "run-01,2.25,0.293,0.2635,0,1.41,0.175", "is it in radians? Then write 16.8"),
        (HEAD + "own,22.5,16.8,15.1,0,81,0.175", "beyond 2 times the robot's bound, 4 Hz"),
        (HEAD + "own,2.25,168,151,0,81,0.175", "amplitude of J1 of own must not be beyond 2 times"),
        ("u_m_s,drag_n\n0.2,5.0", "give it in N, is it in gf?"),
        ("time_s,speed_m_s\n0,0.3\n100,0.25\n200,0.2\n300,0.18", "give time_s in s"),
    ],
)
def test_a_result_in_another_unit_leaves_the_state_as_it_was(run: Run, state: Path, table: str, sentence: str) -> None:
    before = state.read_bytes()
    Path("told.csv").write_text(table)
    code, _, errors = run("design", "tell", "--state", str(state), "told.csv")
    assert (code, sentence in errors, errors.count("\n")) == (2, True, 1), errors
    assert state.read_bytes() == before


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("tell --state tank.jsonl --value 21", "is it in cm/s?"),
        ("tell --state tank.jsonl --value 1,75", "must have decimal points, but is 1,75: write 1.75"),
        (f"tell --state tank.jsonl {TRACK}", "trials import markers"),
        ("ask --state tank.jsonl --robot rexeel", "is a design of another robot, but is three"),
    ],
)
def test_other_words_are_refused(run: Run, state: Path, words: str, sentence: str) -> None:
    before = state.read_bytes()
    code, _, errors = run("design", *words.split())
    assert (code, sentence in errors) == (2, True), errors
    assert state.read_bytes() == before


def test_the_same_file_is_not_told_twice_and_its_lines_may_be_deleted(run: Run, state: Path) -> None:
    Path("told.csv").write_text(HEAD + "run-01,2.25,16.8,15.1,0,81,0.9")
    words = ("design", "tell", "--state", str(state), "told.csv")
    code, output, errors = run(*words)
    assert code == 0, errors
    assert "standard deviations from its prediction" in " ".join(output.split())  # which is 0.18 m/s
    assert "was entered already, as 0.9 m/s" in run(*words)[2]
    state.write_bytes(b"".join(state.read_bytes().splitlines(keepends=True)[:-1]))
    assert run(*words)[0] == 0


def test_a_pair_of_values_is_no_decimal_comma(run: Run, state: Path) -> None:
    assert run("design", "tell", "--state", str(state), "--value", "0.175,2")[0] == 0


def test_a_run_of_an_asked_name_and_another_gait_is_noted(run: Run, state: Path) -> None:
    """It is taken: the name may be of a table that was asked for before other runs were told."""
    Path("told.csv").write_text(HEAD + "run-01,3.5,10,10,0,60,0.175")
    code, _, errors = run("design", "tell", "--state", str(state), "told.csv")
    assert (code, "run-01 is taken with its own gait, 3.5 Hz" in errors) == (0, True)
