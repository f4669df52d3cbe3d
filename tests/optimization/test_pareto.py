"""Pareto fronts: toy problems whose fronts are known, then gaits."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.optimization.constraints import Limit
from hypertuna.optimization.objective import OBJECTIVES, Evaluation
from hypertuna.optimization.optimizers import hypervolume, nondominated, nsga2
from hypertuna.optimization.pareto import Front, pareto
from hypertuna.optimization.polish import Target, run_targets, stationarity


@dataclass(frozen=True)
class Box:
    lower: np.ndarray
    upper: np.ndarray


@dataclass
class Toy:
    """Two objectives over a box, with derivatives; x[0] <= most is its only limit."""

    space: Box = field(default_factory=lambda: Box(np.full(3, -1.0), np.full(3, 2.0)))
    most: float = 10.0
    evaluations: int = 0

    def evaluate(self, x: np.ndarray, *, derivatives: bool = False) -> Evaluation:
        self.evaluations += len(x)
        value, d_value = self.objectives(x)
        violation, d_violation = x[:, :1] - self.most, np.zeros((len(x), 1, x.shape[1]))
        d_violation[:, 0, 0] = 1.0
        return Evaluation(
            x, value, violation, {}, d_value if derivatives else None, d_violation if derivatives else None
        )


class Spheres(Toy):
    """Squared distances from 0 and from (1, 0, 0): the front is the line between, sqrt(f1) + sqrt(f2) = 1."""

    def objectives(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        away = np.stack([x, x - np.eye(3)[0]], axis=1)
        return (away**2).sum(axis=2), 2 * away


class Zdt1(Toy):
    """Zitzler, Deb and Thiele's first problem on a unit box: the front is f2 = 1 - sqrt(f1)."""

    def objectives(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        f, g = x[:, 0], 1 + 9 * x[:, 1:].mean(axis=1)
        return np.stack([f, g * (1 - np.sqrt(f / g))], axis=1), np.zeros((len(x), 2, x.shape[1]))


def evolved(toy: Toy, population: int = 40, generations: int = 60, seed: int = 1) -> Evaluation:
    sizes = {"population": population, "generations": generations, "seed": seed}
    evolution = nsga2(toy.space.lower, toy.space.upper, 2, **sizes)
    while evolution.stop is None:
        evolution.tell(toy.evaluate(evolution.ask()))
    return evolution.result


# --- dominance and hypervolume


def test_points_that_no_other_dominates() -> None:
    value = np.array([[1.0, 4.0], [2.0, 2.0], [2.0, 2.0], [3.0, 2.0], [4.0, 1.0], [5.0, 5.0]])
    np.testing.assert_array_equal(nondominated(value), [0, 1, 4])
    assert len(nondominated(np.zeros((0, 2)))) == 0


@pytest.mark.parametrize("objectives", [2, 3])
def test_nondominated_is_what_the_definition_says(objectives: int) -> None:
    value = np.random.default_rng(objectives).integers(0, 6, (60, objectives)).astype(float)
    worse = (value[:, None] >= value).all(axis=2) & (value[:, None] > value).any(axis=2)
    best = np.flatnonzero(~worse.any(axis=1))
    found = nondominated(value)
    assert set(found) <= set(best)
    assert {tuple(v) for v in value[found]} == {tuple(v) for v in value[best]}


def test_hypervolume_by_hand() -> None:
    reference = np.array([4.0, 4.0])
    assert hypervolume(np.array([[1.0, 3.0]]), reference) == 3.0
    assert hypervolume(np.array([[1.0, 3.0], [2.0, 1.0]]), reference) == 3 + 2 * 2
    assert hypervolume(np.array([[1.0, 3.0], [2.0, 1.0], [5.0, 0.0]]), reference) == 7.0  # beyond the reference
    assert hypervolume(np.array([[0.0, 0.0, 0.0]]), np.array([1.0, 2.0, 3.0])) == 6.0
    assert hypervolume(np.zeros((0, 2)), reference) == 0.0


# --- evolution


def test_evolution_finds_a_known_front() -> None:
    found = evolved(Zdt1(Box(np.zeros(4), np.ones(4))))
    exact = 2 / 3  # of the front below the reference point (1, 1): integral of sqrt(f)
    assert len(found.x) == 40
    # 40 points at equal distances leave 40 steps of it out, together about a fortieth of half the unit square.
    assert 0.97 * exact < hypervolume(found.value, np.ones(2)) < exact


def test_evolution_repeats_itself_by_seed() -> None:
    a, b, other = (evolved(Spheres(), 12, 6, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(a.x, b.x)
    assert not np.array_equal(a.x, other.x)


def test_evolution_keeps_to_limits_and_leaves_out_what_is_not_finite() -> None:
    class Holes(Spheres):
        def objectives(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            value, jacobian = super().objectives(x)
            value[x[:, 1] < 0] = np.inf
            return value, jacobian

    found = evolved(Holes(most=0.5), 20, 20)
    assert len(found.x) > 5
    assert (found.x[:, 0] <= 0.5).all()
    assert (found.x[:, 1] >= 0).all()


# --- polishing


def polished(toy: Toy, found: Evaluation) -> Evaluation:
    targets = [Target(x, 1, np.array([value[0], np.inf])) for x, value in zip(found.x, found.value, strict=True)]
    return toy.evaluate(run_targets(toy, targets, np.ones(2)), derivatives=True)


def test_polishing_reaches_a_known_front() -> None:
    toy = Spheres()
    before = evolved(toy, 20, 10)
    after = polished(toy, before)
    distance = np.abs(np.sqrt(after.value).sum(axis=1) - 1)
    assert distance.max() < 1e-6 < 1e-3 < np.abs(np.sqrt(before.value).sum(axis=1) - 1).max()
    assert (after.value[:, 0] <= before.value[:, 0]).all()
    scale = np.ptp(before.value, axis=0)
    assert stationarity(toy, after, scale).max() < 1e-3
    assert stationarity(toy, toy.evaluate(before.x, derivatives=True), scale).max() > 1e-2


@pytest.mark.parametrize("seed", range(3))
def test_polishing_never_worsens(seed: int) -> None:
    toy = Spheres(most=0.6)
    before = evolved(toy, 12, 4, seed)
    after = polished(toy, before)
    assert (after.value <= before.value).all()
    assert (after.violation <= 0).all()
    reference = before.value.max(axis=0) + 1
    assert hypervolume(after.value, reference) >= hypervolume(before.value, reference)


def test_a_search_stays_where_it_cannot_improve() -> None:
    toy, start = Spheres(), np.array([0.25, 0.0, 0.0])
    held = Target(start, 1, np.array([0.25**2, np.inf]))
    np.testing.assert_allclose(run_targets(toy, [held], np.ones(2))[0], start, atol=1e-6)


def test_stationarity_by_hand() -> None:
    toy = Spheres(most=0.5)
    on_front, beside, at_limit, off = [0.25, 0, 0], [0.25, 0.75, 0], [0.5, 0.0, 0], [-1.0, 0, 0]
    found = toy.evaluate(np.array([on_front, beside, at_limit, off]), derivatives=True)
    residual = stationarity(toy, found, np.ones(2))
    assert residual[0] < 1e-12  # opposite gradients
    # Both gradients have (., 1.5) in y; the one along x cancels: 1.5 over the longer gradient, hypot(1.5, 1.5).
    assert residual[1] == pytest.approx(1.5 / np.hypot(1.5, 1.5))
    assert residual[2] < 1e-12
    # On the lower bound of x both fall inwards; the shorter gradient, 2, over the longer, 4.
    assert residual[3] == pytest.approx(2 / 4)


def test_a_point_without_gradients_is_stationary_and_one_without_numbers_is_not_known() -> None:
    toy, at = Toy(), np.zeros((1, 3))
    for gradient, residual in ((0.0, 0.0), (np.nan, np.nan)):
        slopes = np.full((1, 2, 3), gradient)
        found = Evaluation(at, np.zeros((1, 2)), -np.ones((1, 1)), {}, slopes, np.zeros((1, 1, 3)))
        np.testing.assert_equal(stationarity(toy, found, np.ones(2)), [residual])


def test_stationarity_does_not_depend_on_the_width_of_the_box() -> None:
    """A limit that crosses the coordinates: its gradient is scaled by the box as the objectives' are."""
    wide = Box(np.zeros(2), np.array([1.0, 10.0]))  # in the unit box the gradients are (1, 10) and (-1, -10)
    at, limit = np.array([[0.5, 5.0]]), np.array([[[-1.0, -1.0]]])
    found = Evaluation(at, np.zeros((1, 1)), np.zeros((1, 1)), {}, np.ones((1, 1, 2)), limit)
    np.testing.assert_allclose(stationarity(Toy(wide), found, np.ones(1)), [0.0], atol=1e-12)


def test_a_limit_balances_gradients() -> None:
    toy = Spheres(most=-0.5)  # both objectives fall towards x = 0, but x <= -0.5
    found = toy.evaluate(np.array([[-0.5, 0, 0], [-0.6, 0, 0]]), derivatives=True)
    residual = stationarity(toy, found, np.ones(2))
    assert residual[0] < 1e-12
    assert residual[1] > 0.3


# --- gaits

SMALL = {"population": 8, "generations": 4}


@pytest.fixture(scope="module")
def front(tuna: ht.Robot) -> Front:
    return pareto(tuna, **SMALL)


def test_front_of_gaits_is_one(front: Front) -> None:
    value = front.values * [-1, 1]
    assert len(front.x) >= 8
    np.testing.assert_array_equal(nondominated(value), range(len(value)))
    assert (np.diff(front.values[:, 0]) > 0).all()
    found = front.points
    np.testing.assert_allclose(found.speed, front.values[:, 0], rtol=1e-12)
    np.testing.assert_allclose(found.cost_of_transport, front.values[:, 1], rtol=1e-12)
    assert found.settled.all()


def test_polishing_raises_the_hypervolume_and_leaves_stationary_points(tuna: ht.Robot, front: Front) -> None:
    assert front.polished
    assert front.hypervolume > 1.01 * front.hypervolume_evolved
    rough = pareto(tuna, **SMALL, polish=False)
    assert (rough.hypervolume, rough.polished) == (front.hypervolume_evolved, False)
    np.testing.assert_array_equal(np.sort(rough.values, axis=0), np.sort(front.evolved, axis=0))
    assert np.median(front.stationarity) < 1e-4 < 1e-2 < np.median(rough.stationarity)


def test_polishing_fills_gaps(tuna: ht.Robot, front: Front) -> None:
    ends = front.values[[0, -1], 0]  # they lie beyond those of the search
    before, after = np.diff(np.sort([*front.evolved[:, 0], *ends])), np.diff(front.values[:, 0])
    assert len(front.x) > len(front.evolved) + 2
    assert after.max() < 0.6 * before.max()


def test_each_gait_of_the_front_is_the_cheapest_at_its_speed(tuna: ht.Robot, front: Front) -> None:
    rng = np.random.default_rng(1)
    x = front.space.lower + rng.random((300, 4)) * (front.space.upper - front.space.lower)
    found = ht.sweep(tuna, front.space.gaits(x))
    beside = [found.cost_of_transport.values[found.speed.values >= speed] for speed, _ in front.values]
    assert sum(map(len, beside)) > 100
    for cost, faster in zip(front.values[:, 1], beside, strict=True):
        assert not len(faster) or faster.min() > cost


def test_with_ideal_joints_one_gait_is_the_cheapest_at_every_speed(tuna: ht.Robot) -> None:
    # All forces go with the square of the frequency, and so do power over frequency and cost over speed squared.
    front = pareto(tuna.using(joints="ideal"), **SMALL)
    gaits = front.space.gaits(front.x)
    below = gaits.frequency < 5.99
    assert 4 <= below.sum() < len(below)
    shape = np.column_stack([gaits.amplitude, gaits.phase, front.values[:, 1] / front.values[:, 0] ** 2])[below]
    np.testing.assert_allclose(shape, np.broadcast_to(shape[0], shape.shape), rtol=1e-6, atol=1e-6)
    assert shape[0, -1] == pytest.approx(5.084, rel=1e-3)
    assert (front.values[~below, 1] / front.values[~below, 0] ** 2 > shape[0, -1]).all()


def test_slowest_gait_is_as_fast_as_asked_for(tuna: ht.Robot, front: Front) -> None:
    assert front.values[0, 0] == pytest.approx(0.1 * tuna.body.length, rel=1e-6)
    faster = pareto(tuna, **SMALL, min_speed=0.3)
    assert faster.values[0, 0] == pytest.approx(0.3, rel=1e-6)
    assert faster.values[0, 0] >= 0.3


def test_limits_are_kept(tuna: ht.Robot) -> None:
    slow = Limit("rate_I", 4.0)
    front = pareto(tuna, **SMALL, limits=[slow])
    gaits = front.space.gaits(front.x)
    made = gaits.amplitude[:, 0] / np.sqrt(1 + (gaits.frequency / tuna.joints[0].bandwidth) ** 2)
    rate = 2 * np.pi * gaits.frequency * made
    assert rate.max() <= 4.0
    assert rate.max() == pytest.approx(4.0, rel=1e-5)


def test_three_objectives(tuna: ht.Robot) -> None:
    front = pareto(tuna, ["speed", "cost_of_transport", "mechanical_power"], **SMALL)
    assert front.values.shape[1] == 3
    assert front.hypervolume >= front.hypervolume_evolved
    np.testing.assert_array_equal(nondominated(front.values * [-1, 1, 1]), range(len(front.x)))


def test_objectives_without_derivatives_say_so(tuna: ht.Robot) -> None:
    front = pareto(tuna, ["speed", "efficiency"], population=4, generations=2)
    assert not front.polished
    assert "no exact derivatives of efficiency" in front.stop
    assert np.isnan(front.stationarity).all()


def test_no_gait_keeps_impossible_limits(tuna: ht.Robot) -> None:
    front = pareto(tuna, population=4, generations=2, min_speed=50.0)
    assert len(front.x) == 0
    assert front.stop.endswith("No gait satisfied all limits.")
    assert front.hypervolume == 0.0


def test_progress_counts_batches_up_to_the_most_that_there_can_be(tuna: ht.Robot) -> None:
    told: list[tuple[int, int]] = []
    pareto(tuna, **SMALL, progress=lambda *numbers: told.append(numbers))
    ((total, *others),) = [{total for _, total in told}]
    done = [count for count, _ in told]
    assert others == []
    assert done == sorted(done)
    assert SMALL["generations"] < done[-2] <= total == done[-1]


def test_same_seed_same_front_through_an_interruption(tuna: ht.Robot, front: Front, tmp_path: Path) -> None:
    path = tmp_path / "pareto.jsonl"

    class Killed(Exception):
        pass

    for batches in (1, 3, 6):  # in the search, at its end, in the polishing

        def stop(done: int, total: int, batches: int = batches) -> None:
            if done == batches:
                raise Killed

        with pytest.raises(Killed):
            pareto(tuna, **SMALL, checkpoint=path, progress=stop)
        path.write_bytes(path.read_bytes()[:-7])  # the last line is torn
    resumed = pareto(tuna, **SMALL, checkpoint=path)
    np.testing.assert_array_equal(resumed.x, front.x)
    np.testing.assert_array_equal(resumed.values, front.values)
    assert (resumed.stop, resumed.evaluations) == (front.stop, front.evaluations)
    assert resumed.hypervolume == front.hypervolume


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"objectives": ["speed", "cost_of_transprot"]}, "did you mean cost_of_transport?"),
        ({"objectives": ["speed"]}, "must name two or three different quantities"),
        ({"objectives": ["speed", "speed"]}, "must name two or three different quantities"),
        ({"objectives": list(OBJECTIVES)}, "must name two or three different quantities"),
        ({"population": 0}, "population must be from 2 to 10000"),
        ({"generations": -1}, "generations must be from 1 to 10000"),
        ({"min_speed": -0.1}, "min_speed must not be negative"),
        ({"robust": "mean"}, "identify"),
        ({"bounds": {"frequenzy_hz": (1, 2)}}, "did you mean frequency"),
    ],
)
def test_bad_input_is_refused(tuna: ht.Robot, arguments: dict, sentence: str) -> None:
    with pytest.raises(InputError) as error:
        pareto(tuna, **arguments)
    assert sentence in str(error.value)


def test_a_checkpoint_of_other_work_is_not_taken_up(tuna: ht.Robot, tmp_path: Path) -> None:
    pareto(tuna, population=4, generations=1, polish=False, checkpoint=tmp_path / "a.jsonl")
    with pytest.raises(InputError, match="population = 4, but now it is 5"):
        pareto(tuna, population=5, generations=1, polish=False, checkpoint=tmp_path / "a.jsonl")
