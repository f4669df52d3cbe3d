"""The paper's two angles by brute force: actuators drawn within the bounds that meet both, and their combinations.

`python sampled.py [COUNT]` draws the unknowns but the two levers from what is held possible, solves for the levers, keeps
those within their bounds (by importance: the levers' own likelihood), and prints how many lie in the fit's intervals.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import hypertuna as ht
from hypertuna.actuator import bend
from hypertuna.bench import read_bench
from hypertuna.bench_fit import fit_bench
from hypertuna.bench_unknowns import Unknown, with_unknowns

FISH = ht.load("hypertuna")
PAPER = Path(__file__).parents[2] / "examples" / "bench" / "paper.csv"


def draw(rng: np.random.Generator, one: Unknown) -> float:
    """Draw an unknown: normal in its logarithm, within its bounds."""
    while True:
        log = one.log(one.described) + one.spread * rng.standard_normal()
        if one.kind != "diameter_ratio" or log < 0:
            value = one.value(log)
            if one.lower <= value <= one.upper:
                return value


def main(count: int) -> None:
    """Draw, solve, compare."""
    rng, fit = np.random.default_rng(0), fit_bench(FISH, read_bench(PAPER, FISH), starts=1)
    print(f"{len(fit.draws)} draws of the fit meet the bench")
    levers = [k for k, one in enumerate(fit.free) if one.kind == "lever"]
    kept, tried = [], 0
    while len(kept) < count:
        tried += 1
        values = np.array([draw(rng, one) for one in fit.free])
        weight = 1.0
        for k, target in zip(levers, np.degrees(fit.bench.angle), strict=True):
            one = fit.free[k]

            def off(lever: float, k: int = k, target: float = target) -> float:
                trial = with_unknowns(FISH, fit.free, np.where(np.arange(len(values)) == k, lever, values), checked=False)
                return float(np.degrees(bend(trial, fit.free[k].joint, [250e3]).angle[0])) - target

            grid = np.geomspace(one.lower, one.upper, 9)
            signs = np.array([off(lever) for lever in grid])
            crossings = np.flatnonzero(signs[:-1] * signs[1:] < 0)
            if not len(crossings):
                weight = 0.0
                break
            m = int(rng.choice(crossings))
            values[k] = brentq(off, grid[m], grid[m + 1], rtol=1e-6)
            # a described lever is as likely as its bounds say, and the slope turns densities of bends into those of levers
            z = (one.log(values[k]) - one.log(one.described)) / one.spread
            slope = (off(values[k] * 1.001) - off(values[k] / 1.001)) / 0.002
            weight *= float(np.exp(-0.5 * z**2)) / abs(slope) * len(crossings)
        if weight:
            kept.append((weight, values))
    weights = np.array([w for w, _ in kept])
    weights /= weights.sum()
    print(f"{count} of {tried} drawn meet both angles; effective number {1 / np.sum(weights**2):.0f}")
    for one in fit.combinations:
        logs = [{u.factor: u.log(v) - u.log(u.described) for u, v in zip(fit.free, x, strict=True)} for _, x in kept]
        value = np.array([sum(e * log[name] for name, e in one.exponents.items()) for log in logs])
        order = np.argsort(value)
        low, high = (value[order][np.searchsorted(np.cumsum(weights[order]), q)] for q in (0.025, 0.975))
        inside = float(weights[(np.log(one.low) <= value) & (value <= np.log(one.high))].sum())
        print(f"{one.text}\n  fit {one.low:.3g} .. {one.high:.3g}, drawn {np.exp(low):.3g} .. {np.exp(high):.3g}, inside {inside:.2f}")
    for k, one in enumerate(fit.free):
        x = np.array([v[k] for _, v in kept])
        inside = float(weights[(fit.low[k] <= x) & (x <= fit.high[k])].sum())
        print(f"{one.name}: inside {inside:.2f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
