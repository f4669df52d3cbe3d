"""Sensor faults at random in the twin: what validation/faults does 500 times, some dozen times."""

import importlib.util
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).parents[2] / "validation" / "faults" / "runs.py"
RUNS = 24
START = 2.0  # s: by then a joint beats as wide as it was asked to, where its pressures allow


def _load() -> Any:
    spec = importlib.util.spec_from_file_location("fault_runs", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def study() -> Any:
    return _load()


@pytest.fixture(scope="module")
def rows(study: Any) -> list[Any]:
    return list(study.both(range(RUNS)))


def test_pressure_never_passes_the_hard_limit_by_a_twentieth(rows: list[Any], study: Any) -> None:
    assert max(max(healthy.peak, faulty.peak) for _, _, healthy, faulty in rows) < study.HARD


def test_nothing_but_a_faulty_reading_is_ever_no_number(rows: list[Any]) -> None:
    assert all(healthy.finite and faulty.finite for _, _, healthy, faulty in rows)


def test_pulses_stay_within_clamp_and_slew(rows: list[Any]) -> None:
    assert all(healthy.pulses and faulty.pulses for _, _, healthy, faulty in rows)


def test_every_fault_is_told_and_no_other(rows: list[Any], study: Any) -> None:
    for fault, _, healthy, faulty in rows:
        found = {name for name in faulty.conditions if name.endswith("_fault")}
        assert found == {study.condition(fault)}, fault
        assert not [name for name in healthy.conditions if name.endswith("_fault")]


def _grows(fault: str) -> bool:
    """Return whether a joint goes blind within the start, before its governor has allowed the whole amplitude."""
    return fault.startswith("pressure") and float(fault.split("@")[1]) < START


def test_the_tail_beats_on(rows: list[Any], study: Any) -> None:
    """Half of the healthy swing at least, where no circuit was released and no joint went blind within its start."""
    beating = [row for row in rows if "hard_stop" not in row[3].conditions and not _grows(row[0])]
    assert len(beating) > len(rows) / 2
    for fault, _, healthy, faulty in beating:
        assert (faulty.swing > study.SWING_MIN * healthy.swing).all(), fault
