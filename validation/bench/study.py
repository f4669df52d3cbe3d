"""How often do the intervals of `hypertuna joint fit` hold the truth? Benches of drawn actuators, with drawn noise.

`python study.py [COUNT] [SD_DEG]` prints how many unknowns and combinations lie in their 95 % intervals.
"""

import sys
from dataclasses import replace

import numpy as np

import hypertuna as ht
from hypertuna.characterization.data import MEASURED, Bench, Loop
from hypertuna.characterization.fit import BenchFit, fit_bench
from hypertuna.characterization.problem import computed
from hypertuna.characterization.unknowns import Unknown, unknowns, with_unknowns

FISH = ht.load("hypertuna")
PRESSURES = np.linspace(50e3, 250e3, 5)  # Pa, of the loops


def empty(
    pressures: np.ndarray = PRESSURES, joints: tuple[int, ...] = (0, 1), sides: tuple[int, ...] = (0, 1)
) -> Bench:
    """Return a bench of loops to the highest pressure and back, without angles."""
    grid = np.array([(j, s, p, u) for j in joints for s in sides for u in (0, 1) for p in pressures]).T
    joint, side = grid[0].astype(int), grid[1].astype(int)
    rows = len(joint)
    loops = [Loop(j, s, pressures.max(), np.flatnonzero((joint == j) & (side == s))) for j in joints for s in sides]
    none = np.full(rows, np.nan)
    known = {"joint": joint, "side": side, "pressure": grid[2], "unload": grid[3] > 0, "angle": np.zeros(rows)}
    given = dict.fromkeys(MEASURED, none) | {"arm": np.full(rows, np.inf)} | known
    return Bench(**given, loops=tuple(loops), files=("study",) * rows, lines=(0,) * rows)


def drawn(rng: np.random.Generator, frees: tuple[Unknown, ...]) -> np.ndarray:
    """Draw an actuator's unknowns by the standard deviations of the description, within the bounds."""
    values = []
    for one in frees:
        while True:
            log = one.log(one.described) + one.prior_sd * rng.standard_normal()
            if one.kind == "diameter_ratio" and log >= 0:
                continue
            value = one.value(log)
            if one.lower <= value <= one.upper:
                break
        values.append(value)
    return np.array(values)


def repeat(seed: int, sd: float) -> tuple[BenchFit, np.ndarray] | None:
    """Fit the bench of a drawn actuator; None where its bends have no solution, or are below 3 or above 60 deg."""
    rng = np.random.default_rng(seed)
    bench = empty()
    frees = unknowns(FISH, (0, 1), both_sides=(0, 1))
    truth = drawn(rng, frees)
    angle = computed(with_unknowns(FISH, frees, truth, checked=False), bench)["angle"]
    if not np.isfinite(angle).all() or angle.max() > np.radians(60) or angle.max() < np.radians(3):
        return None
    bench = replace(bench, angle=angle + np.radians(sd) * rng.standard_normal(len(angle)))
    return fit_bench(FISH, bench, starts=1), truth


def main(count: int, sd: float) -> None:
    """Count."""
    held: dict[str, list[bool]] = {"unknowns": [], "combinations": []}
    levels, seed, done = [], 0, 0
    by_name: dict[str, list[bool]] = {}
    while done < count:
        found = repeat(seed, sd)
        seed += 1
        if found is None:
            continue
        fit, truth = found
        done += 1
        log = {one.factor: one.log(v) - one.log(one.described) for one, v in zip(fit.free, truth, strict=True)}
        inside = (fit.low <= truth * (1 + 1e-9)) & (truth <= fit.high * (1 + 1e-9))
        held["unknowns"] += inside.tolist()
        for one in fit.combinations:
            value = np.exp(sum(e * log[name] for name, e in one.exponents.items()))
            good = bool(one.low <= value <= one.high)
            held["combinations"].append(good)
            by_name.setdefault(one.unknown, []).append(good)
        levels.append(np.degrees(fit.noise["angle"]) / sd)
        print(
            seed,
            {k: f"{np.mean(v):.3f} of {len(v)}" for k, v in held.items()},
            fit.converged,
            f"{levels[-1]:.3f}",
            len(fit.combinations),
            flush=True,
        )
    print({k: f"{np.mean(v):.2f} of {len(v)}" for k, v in by_name.items()})
    print(f"noise {np.mean(levels):.3f} +- {np.std(levels) / np.sqrt(count):.3f} of the true one")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40, float(sys.argv[2]) if len(sys.argv) > 2 else 0.2)
