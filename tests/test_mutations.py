"""Damaged files of users: an answer or a sentence. `validation/mutations` has the long run."""

from pathlib import Path
from unittest.mock import Mock

import pytest

from mutations import CASES, Case, problem_of, problems


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_damaged_files_end_in_an_answer_or_a_sentence(case: Case, tmp_path: Path) -> None:
    assert [problem for seed in range(6) for problem in problems(case, seed, tmp_path)] == []


def test_what_no_user_should_meet_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The check itself can fail: by an exception, a refusal without a sentence, a strange exit code."""
    for end, problem in (
        (KeyError("hose"), "KeyError: 'hose'"),
        (SystemExit(2), "refused without a sentence"),
        (SystemExit(70), "exit code 70"),
    ):
        monkeypatch.setattr("hypertuna.cli.main.main", Mock(side_effect=end))
        assert problem in problem_of(("version",), tmp_path)
