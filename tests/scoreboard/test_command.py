"""The command `hypertuna scoreboard`, and the factor that README states."""

from __future__ import annotations

import json
import math
import re
import time
from pathlib import Path

import pandas as pd
import pytest

import hypertuna as ht
from hypertuna.scoreboard.scores import ratios_of, swimmer_logs
from hypertuna.scoreboard.swimmers import swimmers
from program import Run

ROOT = Path(__file__).parents[2]
SECONDS = 20.0


@pytest.fixture(scope="module")
def board() -> ht.Scoreboard:
    start = time.process_time()
    result = ht.score_swimmers()
    assert time.process_time() - start < SECONDS
    return result


def test_the_factor_in_the_readme_holds(board: ht.Scoreboard) -> None:
    text = " ".join((ROOT / "README.md").read_text().split())
    told = re.search(r"(\d+) of (\d+) published swimmers within a factor of ([\d.]+)", text)
    assert told is not None
    logs = swimmer_logs(ratios_of(board.scores))
    assert int(told[2]) == len({score.swimmer for score in board.speeds})
    assert int(told[1]) == sum(abs(log) <= math.log(float(told[3])) for log in logs.values())


def test_every_swimmer_is_scored_or_says_why_not(board: ht.Scoreboard) -> None:
    assert len({score.swimmer for score in board.scores}) == len(swimmers()) >= 12
    assert all(score.predicted > 0 or score.note for score in board.speeds)


def test_what_was_predicted_before_the_law_of_the_fin_changed_is_still_scored(board: ht.Scoreboard) -> None:
    before = pd.read_csv(ROOT / "validation/scoreboard/before.csv", comment="#")
    now = {(score.swimmer, score.run): score.published for score in board.scores if "power" not in score.quantity}
    for row in before.itertuples():
        assert now[row.swimmer, row.run] == pytest.approx(row.published, rel=1e-3)
        assert row.ratio == pytest.approx(row.predicted / row.published, rel=0.01)


def test_the_command_prints_writes_and_draws(run: Run, tmp_path: Path) -> None:
    csv, picture = tmp_path / "scores.csv", tmp_path / "scores.svg"
    code, output, errors = run("scoreboard", "tunabot", "one-tail-fish", "-o", str(csv), "--plot", str(picture))
    assert (code, errors) == (0, "")
    assert "Tunabot, 15 Hz" in output
    assert "swimmers with several speeds" in output
    table = pd.read_csv(csv)
    assert [*table.swimmer.unique()] == ["Tunabot", "One-tail fish"]
    assert table.length_m[0] == 0.255
    assert (tmp_path / "scores.csv.json").exists()
    assert "<svg" in picture.read_text()


def test_json_has_scores_and_summary(run: Run) -> None:
    code, output, _ = run("scoreboard", "one-tail-fish", "--json")
    record = json.loads(output)
    assert code == 0
    assert record["swimmers"] == record["own_swimmers"] == record["several_speeds"] == 1
    assert [score["run"] for score in record["scores"]] == ["15 deg", "30 deg"]
    assert record["scores"][0]["ratio"] == pytest.approx(record["scores"][0]["predicted"] / 0.124)
    assert len(record["others"]["One-tail fish"]) == 2


def test_a_swimmer_that_robot_new_refuses_says_why(run: Run, tmp_path: Path) -> None:
    text = (ROOT / "data/swimmers/tunabot.toml").read_text().replace("mass_kg = 0.306", "mass_kg = 306.0")
    path = tmp_path / "heavy.toml"
    path.write_text(text)
    code, output, _ = run("scoreboard", str(path))
    assert code == 0
    assert "times as high as long at neutral buoyancy" in output


def test_a_gait_that_no_robot_has_says_why(run: Run, tmp_path: Path) -> None:
    text = (ROOT / "data/swimmers/tunabot.toml").read_text()
    path = tmp_path / "fast.toml"
    path.write_text(text.replace("speed_m_s", "phase_deg = [0.0, 1000.0]\nspeed_m_s"))
    code, output, _ = run("scoreboard", str(path))
    assert code == 0
    assert "phase" in output.splitlines()[-1]


def test_bad_input_is_one_sentence(run: Run, tmp_path: Path) -> None:
    assert run("scoreboard", "tunabott")[::2] == (
        2,
        "error: tunabott must be a known swimmer or the path of a .toml file: did you mean tunabot?\n",
    )


def test_shells_and_notebooks_show_a_scoreboard(board: ht.Scoreboard) -> None:
    assert repr(board).startswith("Published swimmers, predicted")
    assert "Tunabot" in board._repr_html_()
    assert len(board.to_pandas()) == len(board.scores)
