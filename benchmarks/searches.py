"""The measured searches: for the best gait, and for nine coefficients from 180 gaits."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

import hypertuna
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.trials import Trials
from items import Item, Row, setting
from peers import numba_tasks
from peers.fish import Array, Fish
from timing import Race, processor_seconds

FREE = tuple(f"water.lumped.{name}[0,1-6,7]" for name in ("added_mass", "friction", "drag"))
RANGES = (slice(0, 1), slice(1, 7), slice(7, 8))  # links that share a coefficient
LARGEST = np.repeat([1.0, 1.0, 30.0], 3)  # upper bounds of Table III
START = np.repeat([0.2, 0.2, 10.0], 3)  # its initial values


def gait_search(turns: int) -> Item:
    """(g) Time the search for the fastest gait: swarms of hypertuna and of the peer, and exact gradients."""
    robot, fish, _, _ = setting()
    lower, upper = np.array([0.1, 0, 0, 0]), np.array([6.0, *np.radians([16, 25, 80])])

    def ours(method: str, seed: int = 1) -> hypertuna.Optimum:
        return hypertuna.optimize(robot, maximize="speed", method=method, seed=seed)

    def peer() -> float:
        return numba_tasks.particle_swarm(fish, lower, upper, particles=15, iterations=60, seed=1)

    swarms = [ours("pso", seed) for seed in range(1, 21)]
    best = max(swarm.speed for swarm in swarms)
    gradient, evolved = ours("gradient"), ours("cma")
    race = Race({"pso": lambda: ours("pso"), "gradient": lambda: ours("gradient"), "numba": peer}, turns)
    rows = [
        Row("pso_s", "hypertuna, swarm of 15 particles, 60 iterations", race.seconds("pso"), "s", "0.25 or less"),
        Row("pso_numba_s", "numba and a swarm's loop", race.seconds("numba"), "s"),
        Row("ratio_pso_numba", "numba and a swarm's loop over hypertuna", race.ratio("numba", "pso"), "x"),
        Row("gradient_s", "hypertuna, gradient", race.seconds("gradient"), "s"),
        Row("gradient_evaluations", "gaits that the gradient swims", gradient.evaluations, "", "under 180, 1/5 of 900"),
        Row(
            "gradient_short_percent", "gradient below the best swarm of 20", _short(gradient, best), "%", "0.1 or less"
        ),
        Row("cma_short_percent", "CMA-ES below the best swarm of 20", _short(evolved, best), "%", "0.5 or less"),
        Row("swarm_spread_percent", "worst of 20 swarms below the best", max(_short(s, best) for s in swarms), "%"),
    ]
    method = (
        "The highest speed within Eq. 41, with ideal joints, on one thread. The peer is a straightforward program: "
        "numba swims each gait from rest until its speed changes by less than 1e-9 per beat, in a textbook swarm whose "
        f"inertia falls from 0.9 to 0.4. Median of {turns} turns."
    )
    return Item("Gait search", method, rows)


@cache
def synthetic() -> tuple[Trials, Array]:
    """Return noise-free speeds of the grid with Table III's coefficients, as trials and as numbers [m/s]."""
    robot, _, _, gaits = setting()
    speeds = np.asarray(hypertuna.sweep(robot, gaits, threads=1)["speed"])
    columns = zip(gaits.frequency, gaits.amplitude, gaits.phase, speeds, strict=True)
    runs = [
        SteadyRun(f"{k}", hypertuna.Gait(float(f), tuple(map(float, a)), tuple(map(float, p))), speed=float(u))
        for k, (f, a, p, u) in enumerate(columns)
    ]
    return Trials(tuple(runs)), speeds


def identification(turns: int) -> Item:
    """(h) Time the identification of nine coefficients from the speeds of 180 gaits."""
    robot, fish, grid, _ = setting()
    trials, speeds = synthetic()
    lumped = robot.water.lumped
    assert lumped is not None
    truth = np.array([column[i] for column in (lumped.added_mass, lumped.friction, lumped.drag) for i in (0, 1, 7)])
    half, areas = robot.water.density / 2, robot.links

    def refit(values: Array) -> Fish:
        """Return the peer's fish with other coefficients."""
        column = np.repeat(values.reshape(3, 3), [1, 6, 1], axis=1)
        return replace(
            fish,
            added=column[0] * fish.mass,
            k_t=half * column[1] * np.array(areas.wetted_area),
            k_n=half * column[2] * np.array(areas.lateral_area),
        )

    start = dict(zip((f"{name[:-9]}[{i}]" for name in FREE for i in ("0", "1-6", "7")), START, strict=True))

    def ours() -> hypertuna.Fit:
        return hypertuna.identify(
            robot, trials, FREE, validate=0, loss="linear", starts=1, start=start, seed=1, threads=1
        )

    def peer() -> Array:
        return np.asarray(numba_tasks.fit(refit, grid, np.abs(speeds), START, LARGEST).x)

    race = Race({"us": ours}, max(1, turns // 3))
    found: dict[str, Array] = {"us": ours().values}
    seconds = processor_seconds(lambda: found.update(numba=peer()))  # takes minutes: timed once
    errors = {name: float(np.abs(values / truth - 1).max()) for name, values in found.items()}
    rows = [
        Row("fit_s", "hypertuna, one start", race.seconds("us"), "s", "2 or less"),
        Row("fit_numba_s", "numba, SciPy's finite differences", seconds, "s"),
        Row("ratio_fit_numba", "numba and finite differences over hypertuna", seconds / race.seconds("us"), "x"),
        Row("fit_error", "largest relative error of a coefficient", errors["us"], "", "1e-6 or less"),
        Row("fit_numba_error", "the same, of numba and finite differences", errors["numba"], ""),
    ]
    method = (
        "A fit to the speeds of the 180 gaits above, without noise, from Table III's start values to its results. Both "
        "use `least_squares`. Ours has exact derivatives of settled beats, and its time includes intervals and "
        "undetermined directions. The peer stops after 25 iterations."
    )
    return Item("Identification", method, rows)


def _short(optimum: hypertuna.Optimum, best: float) -> float:
    """Return how far an optimum's speed is below the best one, in percent."""
    return 100 * (1 - optimum.speed / best)
