"""A search whose gaits a tank swims: it hands out a batch, takes runs of it in any order, and goes on from its file."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import hypertuna as ht
from hypertuna.optimization.constraints import Limit
from hypertuna.optimization.experiment import TankSearch
from hypertuna.optimization.optimum import Margin, _infeasible_sentence

OPTIONS: dict[str, Any] = {
    "robot": "hypertuna",
    "maximize": "speed",
    "minimize": None,
    "speed": None,
    "weight": None,
    "bounds": None,
    "limits": [],
    "method": "pso",
    "particles": 4,
    "iterations": 3,
    "seed": 2,
}


def runs(gaits: dict[str, ht.Gait]) -> list[ht.SteadyRun]:
    """Runs of gaits that swim the faster, the faster they beat."""
    return [ht.SteadyRun(name, gait, speed=0.1 * gait.frequency) for name, gait in gaits.items()]


def test_the_open_gaits_are_those_that_are_not_told_yet(tmp_path: Path) -> None:
    path = tmp_path / "search.jsonl"
    with TankSearch(path, OPTIONS) as search:
        first = search.ask()
        assert list(first) == [f"batch-1-gait-{k:02d}" for k in range(1, 5)]
        assert search.tell(runs({name: first[name] for name in ("batch-1-gait-03", "batch-1-gait-01")})) == 2
        assert list(search.ask()) == ["batch-1-gait-02", "batch-1-gait-04"]
        assert search.best is None
    with TankSearch(path) as search:  # from the file alone
        assert search.ask() == {name: first[name] for name in ("batch-1-gait-02", "batch-1-gait-04")}
        assert search.tell(runs(search.ask())) == 0
        assert search.best is not None
        assert search.best.gait.frequency == max(gait.frequency for gait in first.values())
        assert list(search.ask()) == [f"batch-2-gait-{k:02d}" for k in range(1, 5)]


def test_a_run_of_another_gait_is_refused_and_none_is_kept() -> None:
    with TankSearch(None, OPTIONS) as search:
        first, *others = runs(search.ask())
        strange = replace(first, name="other", gait=replace(first.gait, frequency=1.01 * first.gait.frequency))
        with pytest.raises(ht.InputError, match="other must be a gait of the current batch that is not measured yet"):
            search.tell([*others, strange])
        assert len(search.ask()) == 4


def test_what_no_gait_met_is_said() -> None:
    """A limit that is met to the last bit is met."""
    speed, power = Limit("speed", 0.1, upper=False), Limit("mechanical_power", 1.0)
    no_way = "No gait was found that settles and swims forward."
    assert _infeasible_sentence([Margin(speed, -0.1, -1.0), Margin(power, 2.0, -1.0)]) == no_way
    assert _infeasible_sentence([Margin(speed, 0.2, 1.0), Margin(power, 1.0, 0.0)]) == no_way
    told = _infeasible_sentence([Margin(speed, 0.0, 0.0), Margin(power, 1.1, -0.1)])
    assert told.endswith("the nearest one violates mechanical_power by 10 %.")
