"""Do intervals hold the truth while the rest of the model is wrong? Fits of synthetic runs of fish of `robot new`.

    python validation/identify/coverage.py [REPEATS] [-o coverage.jsonl]      # some minutes; resumes

Every fish swims twelve gaits with 2 % noise on the speed, which the file does not state. Drag along the body, drag
across it and added mass differ from the described ones by factors drawn at random. Three models are fitted: the right
one; one whose head has half or twice the drag area; one whose fin has 1/1.5 or 1.5 times the lift slope. Free are the
drag along the body alone (only this one differs then), all three with their priors, or the default coefficients,
which include the drag area. Seeds from 1000 on; lower ones were used during development.
"""

from __future__ import annotations

import argparse
import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtrit

import hypertuna as ht
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.identification.coefficients import to_scale
from hypertuna.identification.identify import identify
from hypertuna.identification.names import default_priors
from hypertuna.io.checkpoint import Journal
from hypertuna.swimming.beat import settle
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.trials import Trials

# Lower seeds were used in development; relative noise of speeds; factor from which the table calls an interval "open"
FIRST_SEED, NOISE, WIDE = 1000, 0.02, 100.0
NAMES = ("drag_tangential", "drag_normal", "added_mass_normal")  # coefficients, common to all links
SPREAD = (1.5, 1.2, 1.3)  # of the true factors, one standard deviation of the logarithm
SWIMS = [(f, a) for f in (0.5, 0.7, 1.0, 1.3, 1.6, 2.0) for a in (0.6, 1.0)]  # over those of "cruise"
MODELS = {  # key of the strip law that is wrong in the fitted model, and by which factor
    "right": ("edge_lift", 1.0),
    "drag area off by 2": ("blunt_area_m2", 2.0),
    "lift slope off by 1.5": ("edge_lift", 1.5),
}
FREE = {"drag along": 1, "drags, added mass": 3, "defaults": 0}  # how many of NAMES are fitted; 0: defaults
CASES = [(model, free) for free in FREE for model in MODELS]  # all pairs of model and free coefficients


def fish(seed: int, free: int) -> tuple[dict[str, Any], dict[str, Any], np.ndarray]:
    """Return documents of a fish as its user describes it and as it is, and the coefficients' factors between them."""
    random = np.random.default_rng(seed)
    links, length = int(random.integers(2, 7)), float(np.exp(random.uniform(np.log(0.1), np.log(1.0))))
    described = new_robot("fish", links=links, length=round(length, 3))
    truth = json.loads(json.dumps(described))
    factors = np.exp(np.log(SPREAD) * random.standard_normal(3))
    factors[free or 3 :] = 1.0
    for name, factor in zip(NAMES, factors, strict=True):
        truth["water"]["strip"][name] = [factor * x for x in truth["water"]["strip"][name]]
    return described, truth, factors


def runs_of(truth: ht.Robot, seed: int) -> Trials:
    """Return the measured speeds of a fish, with noise."""
    cruise, random = ht.named_gait(truth, "cruise"), np.random.default_rng([seed, 1])
    gaits = [
        ht.Gait(cruise.frequency * f, tuple(a * x for x in cruise.amplitude), cruise.phase, cruise.bias)
        for f, a in SWIMS
    ]
    speeds = settle(truth, ht.Gaits.of(gaits))["speed"] * (1 + NOISE * random.standard_normal(len(gaits)))
    return Trials(tuple(SteadyRun(str(k), g, float(v)) for k, (g, v) in enumerate(zip(gaits, speeds, strict=True))))


def fitted(model: str, free: str, seed: int) -> dict[str, Any]:
    """Fit once; return errors and half-widths of 90 % intervals, in logarithms, and which intervals hold the truth."""
    (key, off), count = MODELS[model], FREE[free]
    described, truth, factors = fish(seed, count)
    trials = runs_of(parse(truth, file="truth"), seed)
    strip, factor = described["water"]["strip"], off ** (1 if seed % 2 else -1)
    strip[key] = [factor * x for x in strip[key]] if isinstance(strip[key], list) else min(factor * strip[key], 1.0)
    robot = parse(described, file="described")
    names = [f"water.strip.{name}=common" for name in NAMES[:count]]
    priors = {name: factor for name, factor in default_priors(robot).items() if name in names and count > 1}
    chosen: dict[str, Any] = {"free": names, "prior": priors, "log": names} if count else {}
    fit = identify(robot, trials, validate=0, starts=1, threads=1, **chosen)
    at = [[f.name.split(".")[2].split("[")[0] for f in fit.free].index(name) for name in NAMES[: count or 3]]
    off_by = to_scale(fit.free, fit.values)[at] - np.log(factors[: len(at)])
    half = float(stdtrit(fit.uncertainty.freedom, 0.95)) * np.sqrt(np.diag(fit.uncertainty.covariance))[at]
    return {
        "model": model,
        "free": free,
        "seed": seed,
        "off": off_by.tolist(),
        "half_width": half.tolist(),
        "held": (np.abs(off_by) <= half).tolist(),
        "constrained": [bool(fit.uncertainty.constrained[k]) for k in at],
        "noise": fit.noise["speed"],
        "training_error": fit.train.rms["speed_relative"],
        "coefficients": [f.name for f in fit.free],
        "converged": fit.converged,
    }


def table(records: list[dict[str, Any]]) -> str:
    """Return a Markdown table by model and coefficient: how often intervals hold the truth, or are called short."""
    rows = [
        "| free | model | factor on | 90 % intervals hold | half-width, median | called constrained | of these hold |"
    ]
    rows.append("|---|---|---|---:|---:|---:|---:|")
    for model, free in CASES:
        own = [record for record in records if (record["model"], record["free"]) == (model, free)]
        for k, name in enumerate(NAMES[: FREE[free] or 3]) if own else ():
            held, said = (np.array([record[what][k] for record in own]) for what in ("held", "constrained"))
            half = np.exp(np.median([record["half_width"][k] for record in own]))
            of_these = f"{100 * held[said].mean():.0f} %" if said.any() else ""
            width = f"x {half:.2f}" if half < WIDE else "open"
            cells = f"{100 * held.mean():.0f} % | {width} | {100 * said.mean():.0f} % | {of_these}"
            rows.append(f"| {free} | {model} | {name.replace('_', ' ')} | {cells} |")
    return "\n".join(rows)


def main() -> None:
    """Run the study; finished fits are stored, so that an interrupted study continues."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repeats", nargs="?", type=int, default=40)
    parser.add_argument("-o", "--output", type=Path, default=Path("coverage.jsonl"))
    given = parser.parse_args()
    jobs = [(*case, FIRST_SEED + k) for k in range(given.repeats) for case in CASES]
    with Journal(given.output, {"kind": "study of intervals"}) as journal:
        records = [journal.answer(job, partial(fitted, *job)) for job in jobs]
    print(table(records))


if __name__ == "__main__":
    main()
