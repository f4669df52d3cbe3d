"""The paper's two angles by brute force: actuators drawn within the bounds that meet both, and their combinations.

`python sampled.py [COUNT]` draws the unknowns but the two levers from what is held possible, solves for the levers
within their bounds, weighs every actuator by its likelihood, and prints how many lie in the fit's intervals.
"""

import runpy
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from hypertuna.actuation.bending import bend
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.fit import BenchFit, fit_bench
from hypertuna.characterization.unknowns import with_unknowns
from hypertuna.errors import InputError

study = runpy.run_path(str(Path(__file__).with_name("study.py")))
FISH, drawn = study["FISH"], study["drawn"]

PAPER = Path(__file__).parents[2] / "examples" / "bench" / "paper.csv"
NEAR = 1.001  # for a derivative by differences


def error(fit: BenchFit, values: np.ndarray, k: int, lever: float, angle: float) -> float:
    """Bend of a lever's joint by 250 kPa, less that of the paper [rad]."""
    fish = with_unknowns(FISH, fit.free, np.where(np.arange(len(values)) == k, lever, values), checked=False)
    return float(bend(fish, fit.free[k].joint, [250e3]).angle[0]) - angle


def met(fit: BenchFit, rng: np.random.Generator) -> tuple[float, np.ndarray] | None:
    """Draw an actuator that meets both angles, with its weight; None where no lever does."""
    values, weight = drawn(rng, fit.free), 1.0
    levers = [k for k, one in enumerate(fit.free) if one.kind == "lever"]
    for k, angle in zip(levers, fit.bench.angle, strict=True):
        one = fit.free[k]
        grid = np.geomspace(one.lower, one.upper, 9)
        try:
            off = np.array([error(fit, values, k, lever, angle) for lever in grid])
        except InputError:  # hoses that leave no room
            return None
        crossings = np.flatnonzero(off[:-1] * off[1:] < 0)  # a longer lever pulls harder, and shortens its muscle more
        if not len(crossings):
            return None
        m = int(rng.choice(crossings))
        values[k] = brentq(lambda x, k=k, v=values, a=angle: error(fit, v, k, x, a), grid[m], grid[m + 1], rtol=1e-6)
        # how likely this lever is by itself; the slope turns the density of bends into that of levers
        z = (one.log(values[k]) - one.log(one.described)) / one.prior_sd
        up, down = (error(fit, values, k, values[k] * NEAR**side, angle) for side in (1, -1))
        weight *= float(np.exp(-0.5 * z**2)) * len(crossings) * 2 * np.log(NEAR) / abs(up - down)
    return weight, values


def main(count: int) -> None:
    """Draw, solve, compare."""
    rng, fit = np.random.default_rng(0), fit_bench(FISH, read_bench(PAPER, FISH), starts=1)
    found, tried = [], 0
    while len(found) < count:
        tried += 1
        if (one := met(fit, rng)) is not None:
            found.append(one)
    weight = np.array([w for w, _ in found]) / sum(w for w, _ in found)
    points = np.array([values for _, values in found])
    print(f"{count} of {tried} drawn meet both angles; they count as {1 / np.sum(weight**2):.0f}")
    logs = {u.factor: np.array([u.log(x) - u.log(u.described) for x in points[:, k]]) for k, u in enumerate(fit.free)}
    for one in fit.combinations:
        value = np.exp(sum(e * logs[name] for name, e in one.exponents.items()))
        order = np.argsort(value)
        low, high = (value[order][np.searchsorted(np.cumsum(weight[order]), q)] for q in (0.025, 0.975))
        inside = weight[(one.low <= value) & (value <= one.high)].sum()
        print(f"{one.text}\n  fit {one.low:.2g} .. {one.high:.2g}, drawn {low:.2g} .. {high:.2g}, inside {inside:.2f}")
    for k, one in enumerate(fit.free):
        inside = weight[(fit.low[k] <= points[:, k]) & (points[:, k] <= fit.high[k])].sum()
        print(f"{one.name}: inside {inside:.2f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
