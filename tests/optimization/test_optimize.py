"""From an objective to a gait: what the methods agree on, what limits do, and that a search survives its end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.optimization.constraints import Limit, gait_limits
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.objective import objective
from hypertuna.optimization.optimize import METHODS, WEIGHT, optimize
from hypertuna.optimization.optimum import Optimum
from hypertuna.optimization.problem import Problem
from models import changed

RUNS = 20  # of the particle swarm, that gradients are compared with


@pytest.fixture(scope="module")
def fastest(tuna: ht.Robot) -> dict[str, Optimum]:
    """The fastest gait by every method."""
    return {method: optimize(tuna, maximize="speed", method=method, seed=1) for method in METHODS}


def test_methods_agree_on_the_fastest_gait(fastest: dict[str, Optimum]) -> None:
    speeds = [best.speed for best in fastest.values()]
    assert max(speeds) / min(speeds) - 1 < 5e-3


def test_fastest_gait_lies_where_table_iv_says(tuna: ht.Robot, fastest: dict[str, Optimum]) -> None:
    """Amplitudes and frequency are at their bounds, but the phase is 27 deg where the paper has 37.4.

    The speed hardly depends on it: it is 0.5 % lower at the paper's phase, and with ideal joints the best is 32 deg.
    """
    ideal = optimize(tuna.using(joints="ideal"), maximize="speed", method="gradient")
    for best, phase in ((fastest["gradient"], 27.07), (ideal, 32.33)):
        assert best.gait is not None
        assert best.gait.frequency == pytest.approx(6.0)
        assert np.degrees(best.gait.amplitude).tolist() == pytest.approx([16.0, 25.0])
        assert np.degrees(best.gait.phase[1]) == pytest.approx(phase, abs=0.05)
        assert set(best.bounds) == {"frequency_hz", "amplitude_I_deg", "amplitude_II_deg"}
        assert set(best.bounds.values()) == {"upper"}
        printed = ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 37.43))
        assert 0 < 1 - ht.swim(best.robot, printed).speed / best.speed < 6e-3


def test_gradients_find_what_twenty_swarms_find_with_a_fifth_of_the_gaits(tuna: ht.Robot) -> None:
    swarms = [optimize(tuna, maximize="speed", seed=seed, particles=8, iterations=20).speed for seed in range(RUNS)]
    best = optimize(tuna, maximize="speed", method="gradient")
    assert best.speed > (1 - 1e-3) * max(swarms)
    assert best.evaluations < 900 / 5  # of the paper's 15 particles and 60 iterations


def test_how_flat_the_best_is(tuna: ht.Robot, fastest: dict[str, Optimum]) -> None:
    """At the ends of the ranges the speed is 0.5 % lower, unless they are the bounds."""
    best, space = fastest["gradient"], gait_bounds(tuna)
    assert best.gait is not None
    at, tops = space.point(best.gait), []
    for k, (name, ends) in enumerate(best.near_best.items()):
        assert name == space.names[k]
        for end in ends:
            x = at.copy()
            x[k] = end * space.unit[space.free[k]]
            change = 1 - ht.swim(tuna, space.gait(x)).speed / best.speed
            tops.append(x[k] == pytest.approx(space.upper[k]))
            assert change == pytest.approx(0 if tops[-1] else 5e-3, abs=1e-4)
    assert tops == [False, True, False, True, False, True, False, False]
    assert best.near_best["phase_II_deg"] == pytest.approx((16.7, 37.4), abs=0.1)
    assert best.remark == "The best is flat: within 0.5 % of it for phase II from 16.7 to 37.4 deg."


def test_near_the_best_all_limits_are_kept(tuna: ht.Robot) -> None:
    """A limit of the torque ends the ranges where it is passed, not where the speed has fallen."""
    best = optimize(tuna, maximize="speed", limits=gait_limits(tuna, torque=0.5), method="gradient")
    assert best.gait is not None
    assert best.margins[0].active
    low, high = best.near_best["frequency_hz"]
    assert low < best.gait.frequency == pytest.approx(high, rel=1e-6)
    assert optimize(tuna, speed=0.4, method="gradient").near_best == {}


@pytest.mark.parametrize("speed", [0.3, 0.5])
def test_expected_speed_is_met_at_the_cost_of_a_limit_instead(tuna: ht.Robot, speed: float) -> None:
    """|U - U_e| is an exact penalty: below the threshold the gait is that of least cost at that speed."""
    tracked = optimize(tuna, speed=speed, method="gradient")
    held = optimize(tuna, minimize="cost_of_transport", limits=gait_limits(tuna, speed=speed), method="gradient")
    assert tracked.speed == pytest.approx(speed, rel=1e-5)
    assert tracked.cost_of_transport == pytest.approx(held.cost_of_transport, rel=1e-4)
    assert tracked.weight_threshold is not None
    assert tracked.weight_threshold > 2 * WEIGHT
    assert tracked.remark == ""


def test_threshold_is_where_the_speed_gives_way(tuna: ht.Robot) -> None:
    threshold = optimize(tuna, speed=0.4, method="gradient").weight_threshold
    assert threshold is not None
    below, above = (optimize(tuna, speed=0.4, weight=k * threshold, method="gradient") for k in (0.98, 1.02))
    assert below.speed == pytest.approx(0.4, rel=1e-5)
    assert above.speed < 0.4 * (1 - 1e-3)


def test_no_threshold_without_derivatives(tuna: ht.Robot) -> None:
    best = optimize(tuna, speed=0.4, limits=[Limit("efficiency", 0.01, upper=False)], iterations=20)
    assert best.speed == pytest.approx(0.4, rel=1e-3)
    assert best.margins[0].margin > 0
    assert best.swim is not None
    assert best.margins[0].value == pytest.approx(best.swim.efficiency, rel=1e-6)
    assert best.weight_threshold is None


def test_no_weight_and_a_speed_out_of_reach_is_the_fastest_gait(tuna: ht.Robot, fastest: dict[str, Optimum]) -> None:
    best = optimize(tuna, speed=5.0, weight=0.0, method="gradient")
    assert best.speed == pytest.approx(fastest["gradient"].speed, rel=1e-6)
    assert "instead of the expected 5 m/s" in best.remark


def test_a_gait_that_is_cheap_since_it_hardly_swims_is_remarked(tuna: ht.Robot) -> None:
    remark = "The gait hardly swims"
    assert remark in optimize(ht.load("examples/myfish.toml"), minimize="cost_of_transport", method="gradient").remark
    assert remark not in optimize(tuna, speed=0.4, method="gradient").remark


@pytest.mark.parametrize("method", METHODS)
def test_limits_are_kept_and_those_that_hold_are_named(tuna: ht.Robot, method: str) -> None:
    ideal = tuna.using(joints="ideal")
    limits = gait_limits(ideal, joint_rate=np.radians(300), torque=5.0, amplitude_by_bandwidth=True)
    best = optimize(ideal, maximize="speed", limits=limits, method=method)
    assert best.gait is not None
    assert all(margin.margin >= 0 for margin in best.margins)
    assert {margin.limit.quantity for margin in best.margins} >= {"rate_I", "rate_II", "torque_peak", "reach_I"}
    assert any(margin.active for margin in best.margins)
    rate = 2 * np.pi * best.gait.frequency * np.degrees(best.gait.amplitude)
    assert (rate <= 300 * (1 + 1e-9)).all()
    free = optimize(ideal, maximize="speed", method="gradient")
    assert best.speed < 0.9 * free.speed


def test_torque_limit_holds_the_torque_of_the_swim(tuna: ht.Robot, fastest: dict[str, Optimum]) -> None:
    free = fastest["gradient"]
    assert free.swim is not None
    limit = free.swim.torque_peak / 2
    held = optimize(tuna, maximize="speed", limits=gait_limits(tuna, torque=limit), method="gradient")
    assert held.swim is not None
    assert held.swim.torque_peak == pytest.approx(limit, rel=1e-6)
    assert held.swim.torque_peak <= limit
    assert held.margins[0].active
    assert held.margins[0].value == pytest.approx(limit, rel=1e-6)
    assert held.speed < free.speed


@pytest.mark.parametrize("method", METHODS)
def test_impossible_limits_are_reported_and_nothing_is_returned(tuna: ht.Robot, method: str) -> None:
    limits = gait_limits(tuna, speed=2.0)
    best = optimize(tuna, maximize="speed", limits=limits, method=method, particles=4, iterations=8)
    assert best.gait is None
    assert best.swim is None
    assert np.isnan(best.speed)
    assert "No gait was found that satisfies all limits: the nearest one violates speed by" in best.stop
    assert not np.isfinite(best.history).any()


def test_same_seed_same_result(tuna: ht.Robot) -> None:
    one, two, other = (optimize(tuna, speed=0.4, iterations=5, seed=seed) for seed in (3, 3, 4))
    assert one.gait == two.gait != other.gait
    assert one.history.tolist() == two.history.tolist()


def test_progress_counts_gaits(tuna: ht.Robot) -> None:
    told: list[tuple[int, int]] = []
    best = optimize(tuna, maximize="speed", method="pso", iterations=3, progress=lambda *numbers: told.append(numbers))
    assert told == [(15, 45), (30, 45), (45, 45)]
    assert best.evaluations == 45
    assert best.swum.tolist() == [15, 30, 45]


@pytest.mark.parametrize("method", METHODS)
def test_resumed_search_ends_the_same(tuna: ht.Robot, method: str, tmp_path: Path) -> None:
    arguments: dict[str, Any] = {"speed": 0.4, "method": method, "particles": 5, "iterations": 6}
    path = tmp_path / "run.jsonl"

    class EndError(Exception):
        pass

    def end(done: int, total: int) -> None:
        if done > 10:
            raise EndError

    with pytest.raises(EndError):
        optimize(tuna, **arguments, checkpoint=path, progress=end)
    known = len(path.read_text().splitlines()) - 1
    assert 0 < known < 6
    resumed, straight = optimize(tuna, **arguments, checkpoint=path), optimize(tuna, **arguments)
    assert resumed.gait == straight.gait
    assert resumed.history.tolist() == straight.history.tolist()
    assert resumed.evaluations == straight.evaluations


def test_killed_in_the_middle_it_resumes_to_the_same_gait(tuna: ht.Robot, tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    program = "from hypertuna.optimization.optimize import *; from hypertuna import load; import sys; "
    program += "optimize(load('hypertuna'), maximize='speed', method='pso', particles=40, checkpoint=sys.argv[1])"
    with subprocess.Popen([sys.executable, "-c", program, str(path)]) as killed:
        while killed.poll() is None and (not path.exists() or path.read_bytes().count(b"\n") < 6):
            time.sleep(0.001)
        os.kill(killed.pid, signal.SIGKILL)
    records = path.read_bytes().count(b"\n") - 1
    assert 5 <= records < 60, "killed in the middle"
    resumed = optimize(tuna, maximize="speed", method="pso", particles=40, checkpoint=path)
    straight = optimize(tuna, maximize="speed", method="pso", particles=40)
    assert resumed.gait == straight.gait
    assert resumed.speed == straight.speed
    assert resumed.history.tolist() == straight.history.tolist()
    assert path.read_bytes().count(b"\n") == 61


def test_checkpoint_of_another_search_is_refused(tuna: ht.Robot, tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    optimize(tuna, maximize="speed", iterations=1, checkpoint=path)
    with pytest.raises(InputError, match="was started with seed = 1, but now it is 2"):
        optimize(tuna, maximize="speed", iterations=1, seed=2, checkpoint=path)
    with pytest.raises(InputError, match="robot_hash"):
        optimize(tuna.using(joints="ideal"), maximize="speed", iterations=1, checkpoint=path)
    with pytest.raises(InputError, match="bounds"):
        optimize(tuna, maximize="speed", iterations=1, bounds={"frequency": (1, 2)}, checkpoint=path)


def test_a_gait_that_does_not_settle_is_not_returned(tuna: ht.Robot) -> None:
    """Gaits without any drag never settle, even if they seem fast."""
    links = len(tuna.links.name)
    slippery = changed(tuna, {"water.lumped.drag": [0.0] * links, "water.lumped.friction": [0.0] * links})
    space = gait_bounds(slippery)
    told = Problem(slippery, space, (objective("speed"),)).evaluate((space.lower + space.upper)[np.newaxis] / 2)
    assert not told.feasible[0]
    best = optimize(slippery, maximize="speed", particles=4, iterations=2)
    assert best.gait is None
    assert best.stop.endswith("No gait was found that settles and swims forward.")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({}, "objective must be one of maximize, minimize and speed, but is none"),
        ({"maximize": "speed", "speed": 0.4}, "but is maximize and speed"),
        ({"maximize": "speed", "weight": 0.1}, "weight applies only to an expected speed"),
        ({"maximize": "speeed"}, "did you mean speed"),
        (
            {"maximize": "speed", "method": "cmaes"},
            "method must be gradient, pso, cma or de, but is 'cmaes': did you mean cma",
        ),
        ({"maximize": "speed", "method": "pso", "particles": 1}, "particles must be from 2 to 10000, but is 1"),
        (
            {"maximize": "speed", "method": "cma", "bounds": {"frequency": (2, 2), "amplitude": (9, 9)}},
            "one free gait parameter, but is 'cma', which varies at least two: use pso, gradient or de",
        ),
        ({"maximize": "speed", "iterations": 0}, "iterations must be from 1 to 10000, but is 0"),
        ({"maximize": "speed", "seed": -1}, "seed must be from 0"),
        ({"maximize": "speed", "steps": 30}, "steps must be a multiple of 4"),
        (
            {"maximize": "efficiency", "method": "gradient"},
            "must work without derivatives, which are not available for efficiency",
        ),
    ],
)
def test_arguments_that_cannot_be_used_are_refused(tuna: ht.Robot, arguments: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        optimize(tuna, **arguments)
