"""Properties of every optimizer, on problems whose optimum is known by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

from hypertuna.errors import InputError
from hypertuna.optimization.objective import Evaluation
from hypertuna.optimization.optimizers import CMAES, Optimizer, de, pso
from hypertuna.optimization.sqp import MultiStart, latin_hypercube

LOWER, UPPER = np.array([-1.0, 0.0, 10.0]), np.array([1.0, 2.0, 40.0])
WIDTH = UPPER - LOWER


@dataclass(frozen=True)
class Toy:
    """A parabola over a box, with its lowest point `bottom` in units of the box.

    Its speed is the sum of the coordinates; |speed - expected| is added with `weight`, and what falls short of `least`
    passes the only limit. Where the first coordinate is above `cliff`, nothing settles.
    """

    bottom: tuple[float, float, float] = (0.3, 0.6, 0.5)
    expected: float | None = None
    factor: float = 1.0
    least: float = -10.0
    cliff: float = np.inf

    def evaluate(self, x: np.ndarray) -> Evaluation:
        """Value, violation and derivatives; those of the box scaled back to its units."""
        u = (x - LOWER) / WIDTH
        away, speed = u - self.bottom, u.sum(axis=1)
        value, slope = self.factor * (away**2).sum(axis=1), 2 * self.factor * away
        if self.expected is not None:
            value = value + abs(speed - self.expected)
            slope = slope + np.sign(speed - self.expected)[:, np.newaxis]
        gone = u[:, 0] > self.cliff
        violation = np.where(gone, 1e3, self.least - speed)[:, np.newaxis]
        ones = np.ones_like(u)
        return Evaluation(
            x,
            np.where(gone, np.inf, value)[:, np.newaxis],
            violation,
            {"speed": speed, "status": np.where(gone, 1.0, 0.0)},
            np.where(gone[:, np.newaxis], np.nan, slope / WIDTH)[:, np.newaxis],
            (-ones / WIDTH)[:, np.newaxis],
            ones / WIDTH,
        )


Make = Callable[[int, Toy], Optimizer]

METHODS: dict[str, Make] = {
    "pso": lambda seed, _: pso(LOWER, UPPER, seed=seed, particles=15, iterations=60),
    "de": lambda seed, _: de(LOWER, UPPER, seed=seed, particles=15, iterations=60),
    "cma": lambda seed, _: CMAES(LOWER, UPPER, particles=None, iterations=150, seed=seed),
    "gradient": lambda seed, toy: MultiStart(LOWER, UPPER, toy.expected, 1.0, starts=3, iterations=40, seed=seed),
}


@pytest.fixture(params=METHODS.values(), ids=METHODS.keys())
def make(request: pytest.FixtureRequest) -> Make:
    """Make each optimizer in turn."""
    method: Make = request.param
    return method


def run(optimizer: Optimizer, toy: Toy, batches: int = 1000) -> Optimizer:
    """Drive an optimizer on the toy until it stops, or for a given number of batches."""
    while optimizer.stop is None and batches > 0:
        optimizer.tell(toy.evaluate(optimizer.ask()))
        batches -= 1
    return optimizer


def best(optimizer: Optimizer) -> np.ndarray:
    """Return the best point in units of the box."""
    assert optimizer.result is not None
    return np.asarray((optimizer.result.x[0] - LOWER) / WIDTH)


def test_bottom_inside_the_box_is_found(make: Make) -> None:
    toy = Toy()
    assert best(run(make(1, toy), toy)) == pytest.approx(toy.bottom, abs=3e-3)


def test_bottom_beyond_the_box_is_met_on_its_edge(make: Make) -> None:
    toy = Toy(bottom=(1.5, 0.6, -0.2))
    assert best(run(make(1, toy), toy)) == pytest.approx([1.0, 0.6, 0.0], abs=3e-3)


def test_limit_holds_the_best_point(make: Make) -> None:
    # Nearest to (0.3, 0.6, 0.5) with a sum of at least 2 lies 0.2 further along each coordinate.
    toy = Toy(least=2.0)
    found = run(make(2, toy), toy)
    assert found.result is not None
    assert found.result.feasible[0]
    assert best(found) == pytest.approx([0.5, 0.8, 0.7], abs=3e-2)
    assert best(found).sum() == pytest.approx(2.0, abs=1e-3)


def test_expected_speed_is_held_below_the_threshold(make: Make) -> None:
    # On the way from the bottom to sum 1.7 the parabola rises by 2 k 0.1 per unit of each coordinate, and 1 holds it.
    toy = Toy(expected=1.7)
    assert best(run(make(1, toy), toy)).sum() == pytest.approx(1.7, abs=2e-3)


def test_expected_speed_gives_way_above_the_threshold() -> None:
    # d|s - 1.7| = 3 a t balances 2 k t: with k = 10 the point stays where 2 k t = 1, at t = 0.05 of the 0.1 to go.
    toy = Toy(expected=1.7, factor=10.0)
    found = run(METHODS["gradient"](1, toy), toy)
    assert best(found) == pytest.approx(np.array(toy.bottom) + 0.05, abs=1e-4)


def test_points_that_do_not_settle_never_win(make: Make) -> None:
    toy = Toy(cliff=0.2)  # the bottom lies behind it
    found = run(make(1, toy), toy)
    assert found.result is not None
    assert found.result.feasible[0]
    assert best(found)[0] <= 0.2
    assert np.isfinite(found.history[-1])


def test_nothing_feasible_is_no_solution(make: Make) -> None:
    toy = Toy(least=5.0)  # more than the box has
    found = run(make(1, toy), toy)
    assert found.result is not None
    assert not found.result.feasible[0]
    assert set(found.history) == {np.inf}
    assert found.result.violation[0, 0] == pytest.approx(2.0, abs=0.2)  # the nearest point told is at sum 3


def test_asked_points_keep_to_the_box(make: Make) -> None:
    toy = Toy(bottom=(3.0, -3.0, 0.5))
    optimizer = make(1, toy)
    while optimizer.stop is None:
        asked = optimizer.ask()
        assert (asked >= LOWER).all()
        assert (asked <= UPPER).all()
        optimizer.tell(toy.evaluate(asked))


def test_asking_twice_gives_the_same_batch(make: Make) -> None:
    toy = Toy()
    optimizer, twin = make(1, toy), make(1, toy)
    for _ in range(4):
        first = optimizer.ask()
        first[:] = 0.0  # what is done to the answer stays with whoever does it
        assert optimizer.ask().tolist() == twin.ask().tolist()
        for each in (optimizer, twin):
            each.tell(toy.evaluate(each.ask()))


def test_same_seed_same_points_and_other_seed_others(make: Make) -> None:
    toy = Toy()
    np.random.seed(1)  # noqa: NPY002  global numbers must not matter
    one = run(make(5, toy), toy, batches=5)
    np.random.seed(2)  # noqa: NPY002
    assert run(make(5, toy), toy, batches=5).history == one.history
    assert run(make(6, toy), toy, batches=5).history != one.history


def test_points_are_told_in_the_order_asked(make: Make) -> None:
    toy = Toy()
    optimizer = make(1, toy)
    with pytest.raises(InputError, match="must be the last points that ask returned"):
        optimizer.tell(toy.evaluate(LOWER[np.newaxis]))
    asked = optimizer.ask()
    for wrong in (asked[::-1], asked[:-1], asked + 1e-9):
        with pytest.raises(InputError, match="must be the last points that ask returned"):
            optimizer.tell(toy.evaluate(wrong))
    optimizer.tell(toy.evaluate(asked))
    assert optimizer.evaluations == len(asked)


def test_best_value_never_rises_and_the_end_has_a_reason(make: Make) -> None:
    toy = Toy(least=1.5)
    optimizer = run(make(1, toy), toy)
    values = np.array(optimizer.history)
    assert (np.diff(values[np.isfinite(values)]) <= 0).all()
    assert len(values) == len(optimizer.batches)
    assert sum(optimizer.batches) == optimizer.evaluations
    assert optimizer.stop is not None
    assert optimizer.stop.endswith(".")
    assert optimizer.stop[0].isupper()


def test_limits_come_first_when_points_are_compared() -> None:
    toy = Toy(least=2.0)
    lows = np.array([[0.3, 0.6, 0.5], [0.9, 0.9, 0.9], [0.6, 0.8, 0.7]])  # lowest but short; kept; kept and lower
    optimizer = pso(LOWER, UPPER, particles=3, iterations=1, seed=1)
    optimizer._batch = LOWER + lows * WIDTH
    optimizer.ask = partial(lambda batch: batch, optimizer._batch)  # type: ignore[method-assign]
    told = toy.evaluate(optimizer.ask())
    assert optimizer._better(told).x[0].tolist() == told.x[2].tolist()


def test_starts_are_spread_over_every_coordinate() -> None:
    starts = latin_hypercube(7, 3, seed=4)
    for column in starts.T:
        assert sorted((column * 7).astype(int)) == list(range(7))
    assert starts.tolist() != latin_hypercube(7, 3, seed=5).tolist()


def test_a_search_from_the_expected_speed_knows_its_gradient() -> None:
    """At U = U_e the value has a kink, but not the speed: the first step keeps it, and the way is a short one."""
    start = MultiStart(LOWER, UPPER, None, 1.0, starts=1, iterations=40, seed=1).ask()[0]
    toy = Toy(expected=float(((start - LOWER) / WIDTH).sum()))
    optimizer = MultiStart(LOWER, UPPER, toy.expected, 1.0, starts=1, iterations=40, seed=1)
    told = toy.evaluate(optimizer.ask())
    assert told.quantities["speed"][0] == toy.expected
    optimizer.tell(told)
    assert toy.evaluate(optimizer.ask()).quantities["speed"][0] == pytest.approx(toy.expected, rel=1e-9)
    assert run(optimizer, toy).evaluations < 10
    assert best(optimizer).sum() == pytest.approx(toy.expected)
    # Nearest to the bottom of all points with this sum.
    assert best(optimizer) == pytest.approx(toy.bottom + (toy.expected - np.sum(toy.bottom)) / 3, abs=1e-4)


def test_sqp_needs_few_points() -> None:
    """A parabola is what sequential quadratic programming is made for."""
    toy = Toy()
    optimizer = run(METHODS["gradient"](1, toy), toy)
    assert optimizer.evaluations < 30
    assert best(optimizer) == pytest.approx(toy.bottom, abs=1e-6)
