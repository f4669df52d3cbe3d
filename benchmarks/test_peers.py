"""Every peer computes the same model, or its speed means nothing. Run by `pytest benchmarks`, with the bench extra."""

import numpy as np
import pytest

import hypertuna
from peers import fish as fishes
from peers import jax_sweep, mujoco_swim, numba_rhs, numba_tasks, scipy_swim

FISH = fishes.load()
GAITS = fishes.gaits_from_degrees([2, 3, 5, 6], [(16, 25)] * 4, [(0, 0), (0, 0), (0, 60), (0, 40)])
# Steady speeds of the paper's four unoptimized gaits, ideal joints, from prototypes that are independent of this code.
SPEEDS = np.array([0.288, 0.432, 0.729, 0.906])
SETTLED = 300  # beats after which the speed changes by less than the digits above
BEATS = 40


@pytest.fixture(scope="module")
def by_hypertuna():
    """Return the speeds of all gaits after `BEATS` beats from rest [m/s]."""
    robot = hypertuna.load("hypertuna").using(joints="ideal")
    columns = (GAITS.frequency, GAITS.amplitude, GAITS.phase, np.zeros_like(GAITS.phase))
    gaits = [
        hypertuna.Gait(float(f), *(tuple(map(float, column)) for column in rest))
        for f, *rest in zip(*columns, strict=True)
    ]
    return hypertuna.sweep(robot, gaits, method="beats", beats=BEATS, threads=1)["speed"].to_numpy()


def test_numba(by_hypertuna):
    np.testing.assert_allclose(numba_rhs.swim(FISH, GAITS, SETTLED), SPEEDS, atol=5.1e-4)
    np.testing.assert_allclose(numba_rhs.swim(FISH, GAITS, BEATS), by_hypertuna, rtol=1e-6)


def test_numba_loops_over_links_or_gaits_first():
    one = GAITS[2:3]
    state, table, dt = numba_rhs.prepare(FISH, one)
    numba_rhs.compile_beats(FISH, 1)(state, table, dt, 200)
    pair, table, dt = numba_rhs.prepare(FISH, GAITS[2:4])
    numba_rhs.compile_beats(FISH, 2)(pair, table, dt, 200)
    np.testing.assert_allclose(pair[:, :1], state, rtol=1e-11)


@pytest.mark.parametrize("program", jax_sweep.PROGRAMS)
def test_jax(program, by_hypertuna):
    np.testing.assert_allclose(jax_sweep.compile_sweep(program, FISH, GAITS, SETTLED)(), SPEEDS, atol=5.1e-4)
    # `direct` steps the velocity and not the momentum: another scheme of the same order.
    tolerance = 1e-5 if program == "direct" else 1e-6
    np.testing.assert_allclose(jax_sweep.compile_sweep(program, FISH, GAITS, BEATS)(), by_hypertuna, rtol=tolerance)


@pytest.mark.parametrize("method", scipy_swim.METHODS)
def test_scipy(method, by_hypertuna):
    speed = scipy_swim.swim(FISH, GAITS[3:4], BEATS, method=method, rtol=1e-8)
    np.testing.assert_allclose(speed, by_hypertuna[3], rtol=2e-6)


def test_mujoco():
    coarse, fine = (
        np.array([mujoco_swim.swim(mujoco_swim.Swimmer(FISH, GAITS[k : k + 1], steps), SETTLED) for k in range(4)])
        for steps in (fishes.STEPS, 2 * fishes.STEPS)
    )
    # first order: 1 % off at this step, and right in the limit
    np.testing.assert_allclose(coarse, SPEEDS, rtol=0.01)
    np.testing.assert_allclose(2 * fine - coarse, SPEEDS, atol=1e-3)


def test_numba_searches():
    np.testing.assert_allclose(numba_tasks.swim(FISH, GAITS), SPEEDS, atol=5.1e-4)
    lower, upper = np.array([5.9, *np.radians([15.9, 24.9, 20])]), np.array([6.0, *np.radians([16, 25, 60])])
    best = numba_tasks.particle_swarm(FISH, lower, upper, particles=6, iterations=12, seed=1)
    assert best == pytest.approx(0.9084, rel=2e-3)  # at the upper bounds, phase 32 deg
