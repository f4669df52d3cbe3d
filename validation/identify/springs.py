"""Do intervals hold the stiffness of a hinge that nobody has measured? Fits of synthetic runs of tails that yield.

    python validation/identify/springs.py [REPEATS] [-o springs.jsonl]      # half an hour; resumes

Every fish swims twelve gaits with 2 % noise on speed and cost, which the file does not state. Its springs are off by
factors drawn at random. `noise`: HyperTuna with a spring in place of joint II, whose water is known, so that noise is
all that intervals have to hold. `handbooks`: a fish of `robot new --tail`, all of whose estimated coefficients differ
from the described ones by factors drawn from their priors; free are the springs alone, or the default coefficients too,
with their priors. Seeds from 1000 on; lower ones were used during development.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.actuation.tail import with_tail
from hypertuna.description.robot import parse
from hypertuna.identification.coefficients import Free, bounds_of, free, from_scale, with_values
from hypertuna.identification.fixed import fixed_coefficients
from hypertuna.identification.identify import identify
from hypertuna.identification.names import default_names, default_priors, prior_factor
from hypertuna.io.checkpoint import Journal
from hypertuna.swimming.beat import settle
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.trials import Trials

FIRST_SEED, NOISE, OFF = 1000, 0.02, 1.4  # relative noise of values; factor of a spring, one standard deviation
SWIMS = [(f, a) for f in (0.6, 0.8, 1.0, 1.2, 1.4, 1.7) for a in (0.6, 1.0)]  # over those of the described gait
CASES = ("noise", "handbooks, spring alone", "handbooks, spring and water")


def fish(case: str) -> tuple[ht.Robot, ht.Gait]:
    """Return a described fish, and the gait about which it swims."""
    if case == "noise":
        full = ht.load("hypertuna").document()
        kept = {name: full[name] for name in ("format", "name", "body", "links", "model", "water")}
        hinge = {"link": 7, "stiffness_n_m_per_rad": 0.2, "damping_n_m_s_per_rad": 1e-3}
        robot = parse(kept | {"joints": full["joints"][:1], "hinge": hinge, "sources": {"hinge": "known"}})
        return robot, ht.Gait.from_degrees(frequency=2, amplitude=(15,), phase=(0,))
    robot = parse(with_tail("fish", "passive", links=3, length=0.3, mass=0.85))
    return robot, ht.named_gait(robot, "cruise")


def drawn(robot: ht.Robot, frees: tuple[Free, ...], random: np.random.Generator) -> ht.Robot:
    """Return the robot with free and fixed estimated coefficients drawn about the described ones, by their priors."""
    fixed = [one for one in fixed_coefficients(robot, frees) if one.common and prior_factor(robot, one.column)]
    factors = [one.prior[1] if one.prior else OFF for one in frees]
    factors += [prior_factor(robot, one.column) or 1.0 for one in fixed]
    every = (*frees, *(replace(one, scale="log", lower=1e-3) for one in fixed))
    lower, upper = bounds_of(every)
    start = np.log([one.start for one in every])
    scaled = start + np.log(factors) * random.standard_normal(len(every))
    return with_values(robot, every, from_scale(every, np.clip(scaled, lower, upper)))


def repeat(case: str, seed: int) -> dict[str, Any]:
    """Fit once; return the error of the stiffness in its logarithm, and whether the 95 % interval holds the truth."""
    (robot, gait), name, random = fish(case), "hinge.stiffness", np.random.default_rng(seed)
    names = [name, *(default_names(robot) if "water" in case else ())]
    priors = default_priors(robot) if "water" in case else {}
    frees = free(robot, names, log=[name], prior=priors)
    gaits = [ht.Gait(gait.frequency * f, tuple(a * x for x in gait.amplitude), gait.phase) for f, a in SWIMS]
    hidden = drawn(robot, frees, random)
    beats, truth = settle(hidden, ht.Gaits.of(gaits)), hidden.hinges[0].stiffness
    noise = 1 + NOISE * random.standard_normal((2, len(gaits)))
    values = np.array([beats["speed"], beats["cost_of_transport"]]) * noise
    rows = zip(gaits, *values.tolist(), strict=True)
    runs = Trials(tuple(SteadyRun(str(k), g, v, None, c) for k, (g, v, c) in enumerate(rows)))
    fit = identify(robot, runs, frees, starts=1, validate=0, threads=1)
    low, high = float(fit.uncertainty.low[0]), float(fit.uncertainty.high[0])
    return {
        "case": case,
        "seed": seed,
        "off": math.log(float(fit.values[0]) / truth),
        "half_width": math.log(high / low) / 2,
        "held": low <= truth <= high,
        "constrained": bool(fit.uncertainty.constrained[0]),
        "converged": fit.converged,
    }


def table(records: list[dict[str, Any]]) -> str:
    """Return a Markdown table by case: how often intervals hold the truth, and how long they are."""
    rows = [
        "| case | fits | 95 % intervals hold | error, median | half-width | constrained | of these hold |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for case in CASES:
        own = [record for record in records if record["case"] == case]
        if own:
            held, said = (np.array([record[what] for record in own]) for what in ("held", "constrained"))
            error, half = (np.exp(np.median([abs(record[what]) for record in own])) for what in ("off", "half_width"))
            shares = f"{100 * held.mean():.0f} % | x {error:.3f} | x {half:.3f} | {100 * said.mean():.0f} %"
            rows.append(f"| {case} | {len(own)} | {shares} | {100 * held[said].mean():.0f} % |")
    return "\n".join(rows)


def main() -> None:
    """Run the study; finished fits are stored, so that an interrupted study continues."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repeats", nargs="?", type=int, default=100)
    parser.add_argument("-o", "--output", type=Path, default=Path("springs.jsonl"))
    given = parser.parse_args()
    jobs = [(case, FIRST_SEED + k) for k in range(given.repeats) for case in CASES]
    with Journal(given.output, {"kind": "study of springs"}) as journal:
        records = [journal.answer(job, partial(repeat, *job)) for job in jobs]
    print(table(records))


if __name__ == "__main__":
    main()
