"""Damaged files of users: an answer or a sentence. `validation/mutations` has the long run."""

import random
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from mutations import tracks
from mutations.cases import CASES, Case, judged, whole
from mutations.damage import of_bytes, of_table, of_text
from mutations.judge import answer
from mutations.strangers import READERS, Reader
from mutations.strangers import judged as read
from mutations.strangers import whole as sound
from tracked_files import FILES


@pytest.mark.filterwarnings("default")  # the program decides what to do about a warning
@pytest.mark.parametrize("case", [case for case in CASES if case.there], ids=lambda case: case.name)
def test_damaged_files_end_in_an_answer_or_a_sentence(case: Case) -> None:
    assert answer(case.commands[0], Path(whole(case)[0].name)).code in (0, 1)  # the whole file
    seeds = range(0, 3 * case.every, case.every)
    assert {seed: problems for seed in seeds if (problems := judged(case, seed).problems)} == {}


@pytest.mark.parametrize("reader", [reader for reader in READERS if reader.there], ids=lambda reader: reader.name)
def test_readers_return_or_raise_one_sentence(reader: Reader, tmp_path: Path) -> None:
    path = tmp_path / reader.file
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(sound(reader))
    if reader.name != "scheduler file":  # no scheduler answers
        reader.read(path)
    assert {seed: problems for seed in range(12) if (problems := read(reader, seed).problems)} == {}


@pytest.mark.parametrize("change", tracks.CHANGES, ids=lambda change: change.__name__)
def test_a_changed_track_is_right_or_refused_or_told(change: tracks.Change) -> None:
    problems = (tracks.reaction(change, random.Random(f"{change.__name__} {seed}")).problems for seed in range(12))
    assert [*filter(None, problems)] == []


def test_times_by_the_order_of_the_rows_and_angles_of_other_markers_are_found() -> None:
    """The check itself can fail."""
    _, run = tracks.whole(FILES[0])
    rows = replace(run, markers=replace(run.markers, time=np.arange(len(run.markers.time)) / 60))
    assert tracks.silent(run, run) == ""
    assert "other times" in tracks.silent(rows, run)
    bent = replace(run, fit=replace(run.fit, angle=run.fit.angle + 0.1))
    assert "other angles, by up to 6 deg" in tracks.silent(bent, run)
    moved = replace(run, markers=replace(run.markers, place=run.markers.place + 0.5))
    assert "markers elsewhere" in tracks.silent(moved, run)


@pytest.mark.parametrize("error", [KeyError("hose"), MemoryError(), RecursionError()])
def test_what_a_reader_must_not_raise_is_found(error: Exception) -> None:
    reader = Reader("any", b"x = 1".strip, Mock(side_effect=error), (of_text,))
    assert read(reader, 0).problems[0].startswith(type(error).__name__)


def test_what_no_user_should_meet_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The check itself can fail: by an exception, a refusal without a sentence, a strange exit code."""
    for end, problem in (
        (KeyError("hose"), "KeyError: 'hose'"),
        (SystemExit(2), "refused without a sentence"),
        (SystemExit(70), "exit code 70"),
    ):
        monkeypatch.setattr("hypertuna.cli.main.main", Mock(side_effect=end))
        assert problem in answer("version", tmp_path).problem


@pytest.mark.parametrize(
    ("output", "problem"),
    [
        ("speed nan m/s", "exit code 0 and nan"),
        ('{"settled": true, "speed_m_s": null}', "settled without numbers"),
        ("robot \x1b[31m", "the control character '\\x1b'"),
        ("speed 0.3 m/s", ""),
    ],
)
def test_answers_without_numbers_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, output: str, problem: str
) -> None:
    monkeypatch.setattr("hypertuna.cli.main.main", lambda: print(output))
    assert answer("version", tmp_path).problem == problem


def test_another_result_from_a_damaged_journal_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    case = next(case for case in CASES if case.name == "journal of a swarm")
    whole(case)
    monkeypatch.setattr("hypertuna.cli.main.main", lambda: print('{"speed_m_s": 1}'))
    assert "another result than from the whole file" in judged(case, 0).problems[0]


@pytest.mark.parametrize("damage", [of_text, of_table, of_bytes])
def test_damage_is_of_its_seed(damage: Mock) -> None:
    content = b"time_s,x_m\n0,0.1\n1,0.2\n"
    made = [damage(content, random.Random(seed)) for seed in range(40)]
    assert made == [damage(content, random.Random(seed)) for seed in range(40)]
    assert len(set(made)) > 30
