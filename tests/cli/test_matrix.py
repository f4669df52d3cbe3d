"""Own robots of all sizes, drives and tails, with and without --sea, in every command: a result or one sentence."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import pytest

from hypertuna.description.robot import load, parse
from hypertuna.description.writer import write_robot
from matrix import (
    AT_SEA_ALONE,
    BOARD,
    COMMANDS,
    GAIT,
    NEW,
    TWIN,
    all_cases,
    answer,
    covering_pairs,
    outcome,
    typed,
    write_case,
)
from program import Run

CASES = covering_pairs()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of robots, each written once."""
    return tmp_path_factory.mktemp("robots")


def test_the_cases_have_every_pair_that_there_is() -> None:
    places = list(combinations(range(5), 2))
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


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a robot that has a twin, fins, a pilot and firmware, but for the moment at its hinge."""
    file = write_case(tmp_path_factory.mktemp("driven"), 5, "servo", True)
    hinge = {"link": 4, "stiffness_n_m_per_rad": 0.2, "moment_n_m": 0.05}
    write_robot(parse(load(file).document() | {"hinge": hinge, "sources": {}}), file)
    return file


@pytest.mark.parametrize("command", [command for command in COMMANDS if command != NEW])
def test_a_moment_at_a_hinge_swims_settled_beats_and_has_no_twin(
    command: str, driven: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(driven.parent)
    told = answer(typed(command, driven), run)
    if command in GAIT:
        assert told == "result"
    elif command in TWIN | AT_SEA_ALONE | BOARD | {"export fmu", "hil"}:
        assert "hinge.moment_n_m must be 0 in twin and firmware" in told
