"""Own robots of 2 to 20 links, of every drive, with and without --sea, in every command: a result or one sentence."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import pytest

from matrix import COMMANDS, all_cases, covering_pairs, outcome
from program import Run

CASES = covering_pairs()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of robots, each written once."""
    return tmp_path_factory.mktemp("robots")


def test_the_cases_have_every_pair_that_there_is() -> None:
    places = list(combinations(range(4), 2))
    of_all, of_some = (
        {(a, case[a], b, case[b]) for case in cases for a, b in places} for cases in (all_cases(), CASES)
    )
    assert of_some == of_all
    assert len(CASES) < len(all_cases()) / 6


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_has_a_result_or_one_sentence_for_every_robot(
    command: str, folder: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.delenv("HYPERTUNA_ROBOT", raising=False)
    outcomes = [outcome(case, folder, run) for case in CASES if case.command == command]
    assert len(outcomes) >= 19
