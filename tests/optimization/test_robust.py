"""Robust objectives: means and tails over robots, by hand and against the plain problem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import free, sample_robots, with_fit
from hypertuna.optimization.constraints import gait_limits
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.objective import objective
from hypertuna.optimization.optimize import optimize
from hypertuna.optimization.pareto import pareto
from hypertuna.optimization.problem import Problem, over_fit, robust_problem
from models import changed

OBJECTIVES = (objective("speed"), objective("cost_of_transport"))


@pytest.fixture(scope="module")
def problem(tuna: ht.Robot) -> Problem:
    return Problem(tuna, gait_bounds(tuna), OBJECTIVES, gait_limits(tuna, speed=0.05, joint_rate=8.0))


@pytest.fixture(scope="module")
def robots(tuna: ht.Robot) -> list[ht.Robot]:
    return [changed(tuna, {"water.density_kg_m3": density}) for density in (900.0, 1000.0, 1100.0)]


def points(problem: Problem, count: int = 5) -> np.ndarray:
    rng = np.random.default_rng(1)
    return problem.space.lower + rng.uniform(0.3, 1, (count, 4)) * (problem.space.upper - problem.space.lower)


@pytest.mark.parametrize("how", ["mean", "worst5"])
def test_equal_robots_are_worth_what_one_is(problem: Problem, tuna: ht.Robot, how: str) -> None:
    x = points(problem)
    one = problem.evaluate(x, derivatives=True)
    many = robust_problem(problem, [tuna] * 4, how).evaluate(x, derivatives=True)
    for name in ("value", "violation", "value_jacobian", "violation_jacobian", "speed_gradient"):
        np.testing.assert_allclose(getattr(many, name), getattr(one, name), rtol=1e-13, err_msg=name)
    for name, found in one.quantities.items():
        np.testing.assert_allclose(many.quantities[name], found, rtol=1e-13, err_msg=name)


def test_mean_and_tail_of_three_by_hand(problem: Problem, robots: list[ht.Robot]) -> None:
    robust = robust_problem(problem, robots, "mean")
    x = points(problem, 1)
    found = {name: np.stack([value] * 3) for name, value in problem.swim(x).items()}
    found["speed"] = np.array([[0.2], [0.5], [0.3]])
    found["cost_of_transport"] = np.array([[1.0], [4.0], [2.5]])
    np.testing.assert_allclose(robust.judge(x, found).value, [[-1 / 3, 2.5]])
    # ceil(0.05 * 3) = 1: the slowest for speed, the costliest for cost, though they are two different robots.
    np.testing.assert_array_equal(robust_problem(problem, robots, "worst5").judge(x, found).value, [[-0.2, 4.0]])


@pytest.mark.parametrize(("count", "tail"), [(1, 1), (20, 1), (21, 2), (32, 2), (41, 3)])
def test_worst_five_percent_are_rounded_up(problem: Problem, tuna: ht.Robot, count: int, tail: int) -> None:
    x = points(problem, 1)
    found = {name: np.stack([value] * count) for name, value in problem.swim(x).items()}
    found["cost_of_transport"] = np.arange(1.0, count + 1)[:, np.newaxis]
    value = robust_problem(problem, [tuna] * count, "worst5").judge(x, found).value
    assert value[0, 1] == pytest.approx(np.mean(np.arange(count - tail + 1, count + 1)))


@pytest.mark.parametrize("how", ["mean", "worst5"])
def test_derivatives_are_those_of_the_values(problem: Problem, robots: list[ht.Robot], how: str) -> None:
    robust, x, step = robust_problem(problem, robots, how), points(problem, 2), 1e-5
    told = robust.evaluate(x, derivatives=True)
    for k in range(4):
        shift = step * np.eye(4)[k]
        ahead, behind = robust.evaluate(x + shift), robust.evaluate(x - shift)
        for name in ("value", "violation"):
            difference = (getattr(ahead, name) - getattr(behind, name)) / (2 * step)
            jacobian = getattr(told, f"{name}_jacobian")[:, :, k]
            np.testing.assert_allclose(jacobian, difference, rtol=1e-5, atol=1e-6, err_msg=f"{name} {k}")


def test_limits_hold_for_every_robot_and_one_unusable_is_enough(problem: Problem, robots: list[ht.Robot]) -> None:
    robust, x = robust_problem(problem, robots, "mean"), points(problem)
    alone = np.stack([replace(problem, robot=robot).evaluate(x).violation for robot in robust.robots])
    np.testing.assert_array_equal(robust.evaluate(x).violation, alone.max(axis=0))
    found = robust.swim(x)
    found["status"] = np.array(found["status"])
    found["status"][1, 2] = 1  # one robot does not settle at one point
    judged = robust.judge(x, found)
    assert np.isinf(judged.value[2]).all()
    assert not judged.feasible[2]
    assert judged.quantities["status"][2] == 1


def test_worst_is_no_better_than_mean(problem: Problem, robots: list[ht.Robot]) -> None:
    x = points(problem)
    mean, worst = (robust_problem(problem, robots, how).evaluate(x).value for how in ("mean", "worst5"))
    assert (worst >= mean).all()
    assert (worst > mean).any()


def test_bad_input_is_refused(problem: Problem, tuna: ht.Robot) -> None:
    with pytest.raises(InputError, match="robust must be mean or worst5, but is 'median'"):
        robust_problem(problem, [tuna], "median")
    with pytest.raises(InputError, match="must hold at least one robot"):
        robust_problem(problem, [], "mean")


# --- over a fit


@pytest.fixture(scope="module")
def fitted(tuna: ht.Robot) -> ht.Robot:
    """HyperTuna, whose drag of the head and added mass of the fin are uncertain by a tenth."""
    frees = free(tuna, ["water.drag[0]", "water.added_mass[7]"])
    values = np.array([f.start for f in frees])
    covariance = np.diag((0.1 * values) ** 2)
    return with_fit(tuna, frees, values, covariance=covariance, trials="none", seed=1, text="made up for the test")


def test_robots_are_drawn_from_the_fit(problem: Problem, fitted: ht.Robot) -> None:
    ours = Problem(fitted, problem.space, OBJECTIVES)
    robust = over_fit(ours, "mean", samples=5, seed=3)
    assert robust.robot is fitted
    assert [robot.water for robot in robust.robots] == [robot.water for robot in sample_robots(fitted, 5, 3)]
    x = points(problem)
    # A tenth of uncertainty is felt, and its mean stays within a few percent.
    one, mean, worst = (p.evaluate(x).value for p in (ours, robust, over_fit(ours, "worst5", samples=5, seed=3)))
    assert (np.abs(mean / one - 1) < 0.1).all()
    assert (worst > mean).all()


def test_robust_fronts(fitted: ht.Robot) -> None:
    sizes = {"population": 4, "generations": 2, "samples": 4, "seed": 2}
    plain, mean, worst = (pareto(fitted, robust=how, **sizes) for how in (None, "mean", "worst5"))
    assert (plain.robust, mean.robust, worst.robust) == (None, "mean", "worst5")
    assert worst.hypervolume >= worst.hypervolume_evolved
    found = worst.points
    assert (found.speed_worst5 < found.speed).all()
    assert (found.cost_of_transport_worst5 > found.cost_of_transport).any()
    assert (found.speed_worst5 >= 0.1 * fitted.body.length).all()
    assert mean.evaluations % 4 == 0
    # The fastest gait of the worst robots is slower than that of all on average.
    assert worst.values[:, 0].max() < mean.values[:, 0].max()


def test_robust_optima(fitted: ht.Robot) -> None:
    how = {"maximize": "speed", "method": "gradient", "particles": 2, "seed": 1, "samples": 4}
    plain, mean, worst = (optimize(fitted, robust=robust, **how) for robust in (None, "mean", "worst5"))
    assert plain.value == pytest.approx(-plain.speed)
    # The swim is that of the robot itself; the value is the speed over the sampled robots.
    problem = Problem(fitted, gait_bounds(fitted), (objective("speed"),))
    for best, robust in ((mean, "mean"), (worst, "worst5")):
        value = over_fit(problem, robust, samples=4, seed=1).evaluate(problem.space.point(best.gait)[np.newaxis]).value
        assert best.value == pytest.approx(value[0, 0])
        assert best.speed <= plain.speed * (1 + 1e-6)
    assert worst.value > mean.value


def test_robust_optima_name_both_speeds_and_count_every_swim(fitted: ht.Robot) -> None:
    how = {"speed": 0.4, "robust": "mean", "samples": 4, "particles": 6, "iterations": 4}
    told: list[tuple[int, int]] = []
    best = optimize(fitted, **how, progress=lambda *numbers: told.append(numbers))
    assert best.robust == "mean"
    assert best.evaluations == best.swum[-1] == 4 * 6 * 4
    assert told[-1] == (best.evaluations, best.evaluations)
    assert best.weight_threshold is None
    mean = np.mean([ht.swim(robot, best.gait).speed for robot in sample_robots(fitted, 4, 1)])
    out = optimize(fitted, **how | {"speed": 2.0})
    drawn = np.mean([ht.swim(robot, out.gait).speed for robot in sample_robots(fitted, 4, 1)])
    assert abs(mean - 0.4) < abs(drawn - 2.0)
    said = f"swim the gait at {drawn:.4g} m/s on average, the robot itself at {out.speed:.4g} m/s, instead of"
    assert said in out.remark


def test_robust_margins_are_those_of_the_robot_nearest_to_the_limit(fitted: ht.Robot) -> None:
    best = optimize(fitted, maximize="speed", robust="mean", samples=4, limits=gait_limits(fitted, torque=0.5))
    assert best.gait is not None
    margin = best.margins[0]
    torque = max(ht.swim(robot, best.gait).torque_peak for robot in sample_robots(fitted, 4, 1))
    assert margin.value == pytest.approx(torque)
    assert margin.margin == pytest.approx(1 - torque / 0.5)


def test_bad_draws_are_refused(tuna: ht.Robot, problem: Problem) -> None:
    with pytest.raises(InputError, match="hypertuna identify"):
        over_fit(problem, "mean", samples=4, seed=1)
    with pytest.raises(InputError, match="samples must be from 1 to 10000, but is 0"):
        over_fit(problem, "mean", samples=0, seed=1)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"names": ["w;ater.lumped.drag[7]"]}, r"fit.names w;ater.lumped.drag\[7\] is not a coefficient"),
        ({"names": ["water.lumped.drag[70]"]}, "must have indices from 0 to 7"),
        ({"names": ["name"]}, "fit.names name is not a coefficient"),
        ({"names": ["water.strip.drag_normal[1]"]}, "is not used by model.water = 'lumped'"),
        ({"scale": ["log"], "lower": [0.0]}, r"fit.lower\[0\] must be greater than 0 in log scale"),
        ({"value": [1e10]}, r"fit.value\[0\] must be from lower to upper"),
        ({"covariance": [[-1.0]]}, r"fit.covariance\[0\] must be a row of a covariance"),
    ],
)
def test_a_damaged_fit_is_refused(tuna: ht.Robot, change: dict[str, object], sentence: str) -> None:
    """Of a robot's table [fit]: nothing that sampling would trip over."""
    frees = free(tuna, ["water.drag[7]"], bounds={"water.drag[7]": (0.0, 100.0)})
    fitted = with_fit(tuna, frees, np.array([30.0]), covariance=np.eye(1), trials="a.csv", seed=0, text="fit")
    document = fitted.document()
    document["fit"] |= change
    with pytest.raises(InputError, match=sentence):
        sample_robots(parse(document), 2, 1)
