"""What the twin's numbers may be, with all that is estimated drawn together: data/twin/budget.json.

python validation/twin/budget.py [DRAWS] [--seed N]    200 draws: some 15 minutes

Each draw is another robot that the paper describes as well: an actuator that meets both published bends
(validation/bench/sampled.py); lines, oil, servos and controller within the ranges of simulation/estimates.py; links
with or without the mass that Table II leaves out; the areas of Table II as named or as printed; a caudal fin from
soft to rigid; other noise and offsets of the sensors. The controller of each knows the description alone. A draw
counts by the likelihood of its levers. Water is Table III's: the authors identified it, and no range is published.
"""

import argparse
import json
import math
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.cli.console import progress_bar
from hypertuna.description.robot import parse
from hypertuna.io.files import version, write_atomically
from hypertuna.paper.computed import SPEEDS
from hypertuna.paper.ledger import published_value
from hypertuna.paper.seeds import taken_hash
from hypertuna.simulation.estimates import FACTORS, Factor, varied

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "data" / "twin" / "budget.json"
sampled = runpy.run_path(str(ROOT / "validation" / "bench" / "sampled.py"))

GEOMETRY = "stiffness of the silicone"  # drawn with the actuator
OTHERS = (
    Factor("torque of the servos", "servos.torque_n_m", 0.85, 1.15),
    Factor("friction of the servos", "servos.friction_n_m", 0.5, 2.0),
)
DRAWN = tuple(factor for factor in FACTORS if factor.name != GEOMETRY) + OTHERS
MASS = (1.0, 3.3 / 2.687)  # of the links: Table II, or all of Table I
FIN = (0.3, 30.0)  # N m/rad, of the caudal fin's root: softer than any that swims well, as good as rigid
SECONDS = 12.0  # of which the last beats count
LEVEL = (5.0, 95.0)  # percent: the interval
PUBLISHED = np.array([published_value(f"speed/{name}") for name in SPEEDS])  # m/s


def robots(shipped: ht.Robot, count: int, seed: int) -> Iterator[tuple[float, ht.Robot, ht.Robot]]:
    """Yield weight, robot and the robot that its controller knows."""
    rng = np.random.default_rng(seed)
    fit = sampled["fit_bench"](shipped, sampled["read_bench"](sampled["PAPER"], shipped), starts=1)
    while count:
        met = sampled["met"](fit, rng)
        parts = rng.random(len(DRAWN) + 3)
        if met is None:
            continue
        weight, values = met
        changes = {factor: float(factor.change(part)) for factor, part in zip(DRAWN, parts, strict=False)}
        robot = varied(sampled["with_unknowns"](shipped, fit.free, values, checked=False), changes)
        document = robot.document()
        scale = MASS[0] + (MASS[1] - MASS[0]) * parts[-3]
        document["links"]["mass_kg"] = [scale * mass for mass in document["links"]["mass_kg"]]
        document["model"]["areas"] = "consistent" if parts[-2] < 0.5 else "as-printed"
        stiffness = math.exp(math.log(FIN[0]) + math.log(FIN[1] / FIN[0]) * parts[-1])
        document["hinge"] = {"link": len(robot.links.name) - 1, "stiffness_n_m_per_rad": stiffness}
        limits = {factor: change for factor, change in changes.items() if factor.key.startswith("controller.")}
        count -= 1
        yield weight, parse(document, file=shipped.file), varied(shipped, limits)


def outputs(run: Any) -> list[float]:
    """Return speed [m/s] and electrical power [W] of a run; NaN where it diverged."""
    return [math.nan, math.nan] if run.status == "diverged" else [run.speed, run.electrical_power]


def weighted(values: np.ndarray, weight: np.ndarray, percent: float) -> float:
    """Return a weighted percentile."""
    order = np.argsort(values)
    share = np.cumsum(weight[order]) - weight[order] / 2
    return float(np.interp(percent / 100 * weight.sum(), share, values[order]))


def summary(runs: np.ndarray, weight: np.ndarray, shipped: np.ndarray) -> dict[str, Any]:
    """Return intervals, and where the shipped robot stands: runs (draws, gaits, 2), shipped (gaits, 2)."""
    kept = np.isfinite(runs).all(axis=(1, 2))
    runs, weight = runs[kept], weight[kept]
    rms = [100 * np.sqrt(np.mean((each[..., 0] / PUBLISHED - 1) ** 2, axis=-1)) for each in (runs, shipped)]
    fastest = SPEEDS.index("unoptimised-max")

    def interval(values: np.ndarray) -> list[float]:
        return [float(f"{weighted(values, weight, percent):.4g}") for percent in (LEVEL[0], 50.0, LEVEL[1])]

    def standing(values: np.ndarray, own: float) -> float:
        return round(100 * float(weight[values < own].sum() / weight.sum()), 1)

    return {
        "speed_m_s": {name: interval(runs[:, k, 0]) for k, name in enumerate(SPEEDS)},
        "power_w": {name: interval(runs[:, k, 1]) for k, name in enumerate(SPEEDS)},
        "rms_percent": interval(rms[0]),
        "shipped": {
            "speed_m_s": dict(zip(SPEEDS, shipped[:, 0].round(4).tolist(), strict=True)),
            "power_w": dict(zip(SPEEDS, shipped[:, 1].round(2).tolist(), strict=True)),
            "rms_percent": round(float(rms[1]), 2),
            "percentile_rms": standing(rms[0], float(rms[1])),
            "percentile_power": standing(runs[:, fastest, 1], float(shipped[fastest, 1])),
        },
        "diverged": int((~kept).sum()),
        "counting_as": round(float(weight.sum() ** 2 / (weight**2).sum()), 1),
    }


def main() -> None:
    """Draw, swim the eight gaits, store the intervals."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("draws", type=int, nargs="?", default=200)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    robot = ht.load("hypertuna")
    gaits = [ht.named_gait(robot, name) for name in SPEEDS]
    base = {"duration": SECONDS, "start": "swimming"}
    own = ht.twins([base | {"robot": robot, "gait": gait} for gait in gaits], measure=outputs, threads=2)
    weights, runs = [], []
    with progress_bar("draws", slow=True) as progress:
        for k, (weight, drawn, known) in enumerate(robots(robot, asked.draws, asked.seed)):
            options = base | {"robot": drawn, "controller_robot": known, "seed": k}
            runs.append(ht.twins([options | {"gait": gait} for gait in gaits], measure=outputs, threads=2))
            weights.append(weight)
            progress(k + 1, asked.draws)
    made = {"hypertuna_version": version(), "robot_hash": robot.hash, "taken_hash": taken_hash(robot)}
    made |= {"command": "python validation/twin/budget.py", **vars(asked), "interval_percent": LEVEL}
    record = made | summary(np.array(runs), np.array(weights), np.array(own))
    write_atomically(FILE, (json.dumps(record, indent=1) + "\n").encode())
    print(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
