"""What a sweep's gaits cost at the battery is what the twin draws in each of them, of each robot of a design."""

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.description.changes import changed
from hypertuna.description.design import designed
from hypertuna.description.robot import parse
from hypertuna.simulation.electrical import BEATS, COLUMNS, with_electrical
from hypertuna.swimming.sweep import design_robots
from program import Run

GAITS = ht.Gaits.grid_degrees(frequency=[1.0, 9.0], amplitude=[(8, 12)], phase=[(0, 0), (0, 40)])


def test_the_columns_are_those_of_each_run_alone(tuna: ht.Robot) -> None:
    """To the last bit; at 9 Hz, which HyperTuna's controller does not take, there is none."""
    told: list[tuple[int, int]] = []
    swept = ht.sweep(tuna, GAITS)
    data = with_electrical(swept, [tuna], GAITS, threads=2, progress=lambda *numbers: told.append(numbers))
    assert told[-1] == (2, 2)
    assert data.speed.identical(swept.speed)
    for k in range(2):
        run = ht.twin(tuna, GAITS[k], duration=BEATS / GAITS[k].frequency, start="swimming")
        point = data.isel(frequency=0, phase=k).squeeze()
        alone = (run.speed, run.electrical_power, run.cost_of_transport, float(run.settled))
        assert tuple(float(point[name]) for name in COLUMNS) == alone
    for name in COLUMNS:
        assert data[name].dims == swept.settled.dims
        assert np.isnan(data[name].isel(frequency=1)).all()


def test_each_robot_of_a_design_has_its_own() -> None:
    fish = parse(tomllib.loads(first_robot("x", tail="passive", actuation="servo")))
    gaits = [ht.Gait(1.0, (0.2,), (0.0,)), ht.Gait(2.0, (0.2,), (0.0,))]
    levels = {"hinge.stiffness": [0.1, 0.2]}
    _, robots = design_robots(fish, levels, len(gaits))
    data = with_electrical(ht.sweep(fish, gaits, design=levels), robots, gaits)
    stiff = changed(fish, {"hinge.stiffness_n_m_per_rad": 0.2})
    run = ht.twin(stiff, gaits[1], duration=BEATS / 2, start="swimming")
    assert data.electrical_power.shape == (2, 2)
    assert data.electrical_power.values[1, 1] == pytest.approx(run.electrical_power, rel=1e-12)
    assert data.twin_speed.values[1, 1] == pytest.approx(run.speed, rel=1e-12)
    assert data.twin_speed.values[0, 1] != data.twin_speed.values[1, 1]


def test_a_robot_that_swims_backward_has_a_positive_cost(tuna: ht.Robot) -> None:
    run = ht.twin(tuna, ht.Gait.from_degrees(frequency=1, amplitude=(15, 15), phase=(0, 200)), duration=12)
    assert run.speed < 0 < run.cost_of_transport


def test_the_command_has_them_and_counts_what_the_controller_refuses(run: Run) -> None:
    gaits = ("--frequency", "1,9", "--amplitude", "8,12", "--phase", "0,0")
    code, output, errors = run("sweep", "--robot", "hypertuna", *gaits, "--electrical", "--json")
    slow, fast = json.loads(output)["gaits"]
    assert code == 0
    assert slow["electrical_cost_of_transport_j_per_kg_m"] > 10 * slow["cost_of_transport_j_per_kg_m"]
    assert fast["electrical_power_w"] is None
    assert "1 of 2 gaits are beyond the controller, or diverge in the twin." in errors
    assert "in the twin:" in run("sweep", "--robot", "hypertuna", *gaits, "--electrical")[1]
    refused = run("sweep", "--robot", "hypertuna", *gaits, "--electrical", "-o", "x.shards")
    assert (refused[0], "--electrical cannot be combined with a folder of shards" in refused[2]) == (2, True)
    assert "controller is missing" in run("sweep", "--robot", "rexeel", "--gait", "wave-30", "--electrical")[2]


def test_the_robots_of_a_design_are_made_once_and_refused_before_they_swim(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, made = str(tmp_path / "fish.toml"), list[float]()
    assert run("robot", "new", file, "--tail", "passive", "--actuation", "servo")[0] == 0

    def counted(robot: ht.Robot, variables: Any, place: Any) -> ht.Robot:
        made.append(*place)
        return designed(robot, variables, place)

    monkeypatch.setattr("hypertuna.swimming.sweep.designed", counted)
    command = ("sweep", "--robot", file, "--gait", "cruise", "--electrical", "--design", "hinge.stiffness=0.1,0.2")
    code, output, _ = run(*command, "--json")
    assert (code, len(json.loads(output)["gaits"]), made) == (0, 2, [0.1, 0.2])
    monkeypatch.setattr("hypertuna.simulation.electrical.MAX_RUNS", 1)
    monkeypatch.setattr("hypertuna.cli.sweep.sweep_designs", None)  # nothing swims
    assert "electrical must be at most 1 gaits to swim in the twin, but is 2" in run(*command)[2]
