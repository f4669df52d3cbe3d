"""Twins that go on together: the bits of a run, at any time, whoever their neighbors are."""

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.robot import parse
from hypertuna.simulation.plant import controller_of, parts_of, steps_of
from hypertuna.swimming.gait import lags

ROBOT = ht.load("hypertuna")
GAIT = ht.named_gait(ROBOT, "unoptimised-max")
PARTS = parts_of(ROBOT, "water", None)
STEPS = steps_of(0.01, PARTS, ROBOT)


def start(seed: int, robot: ht.Robot = ROBOT, speed: float = 0.0) -> tuple:
    parts = parts_of(robot, "water", None)
    return parts.plant, _core.LiveController(controller_of(robot)), _core.Sensors(parts.sensors, seed), speed


def give(batch: _core.Batch, count: int, gait: ht.Gait) -> None:
    rows = (np.tile(row, (count, 1)) for row in (gait.amplitude, lags(gait), gait.bias))
    batch.command(np.full(count, gait.frequency), *rows)


def test_a_batch_has_the_bits_of_runs_and_a_restart_those_of_a_start() -> None:
    seeds = range(11)  # more than one group of lanes, the last one not full
    runs = [ht.twin(ROBOT, GAIT, duration=0.7, seed=seed) for seed in seeds]
    batch = _core.Batch([start(seed) for seed in seeds], steps=STEPS)
    give(batch, len(seeds), GAIT)
    batch.advance(20, threads=2)
    batch.restart(4, start(9))
    give(batch, len(seeds), GAIT)
    batch.advance(40)
    now = batch.columns()
    for name in ("x", "heading", "angle", "rate", "servo_angle", "flow"):
        for k, run in enumerate(runs):
            expected = runs[9].data[name][40] if k == 4 else run.data[name][60]
            np.testing.assert_array_equal(now[name][k], expected, err_msg=f"{name} of twin {k}")
        assert (now[name][3] != now[name][5]).any()  # seeds differ
    drawn = (runs[0].data["power"][:60] * 0.01).sum()
    assert now["energy"][0] == pytest.approx(drawn, rel=1e-9)


def test_a_restart_may_bring_another_robot_of_the_structure() -> None:
    document = ROBOT.document()
    document["links"]["mass_kg"] = [1.1 * mass for mass in document["links"]["mass_kg"]]
    heavy = parse(document)
    batch = _core.Batch([start(1), start(2)], steps=STEPS)
    batch.restart(1, start(2, heavy))
    give(batch, 2, GAIT)
    batch.advance(30)
    expected = ht.twin(heavy, GAIT, duration=0.4, seed=2).data["x"][30]
    assert batch.columns()["x"][1] == expected
    with pytest.raises(ValueError, match="same links, joints, water law"):
        batch.restart(0, start(1, ROBOT.using(water="strip")))
    with pytest.raises(IndexError):
        batch.restart(2, start(1))
