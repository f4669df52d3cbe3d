"""The twin's numbers over the family, the robots that the published facts allow: data/twin/budget.json.

python validation/twin/budget.py [--seed N]    some minutes on two cores

Every member of data/twin/family.json swims the eight gaits and the tank tests in the water of Table III, and the eight
in strips. One of four turns, dives, settles in air, swims on a lake and with other phases. The controller knows the
member. A second set varies all else that the paper leaves open, too: links with or
without the mass that Table II leaves out; the areas of Table II as named or as printed; a fin from soft to rigid.
"""

import argparse
import hashlib
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import family
import numpy as np
from study import lines

import hypertuna as ht
from hypertuna.arrays import Array
from hypertuna.cli.console import progress_bar
from hypertuna.description.robot import parse
from hypertuna.io.files import version, write_atomically
from hypertuna.paper.chapters.budget import PERCENT, POWERS, bands
from hypertuna.paper.computed import SPEEDS
from hypertuna.paper.ledger import published_value
from hypertuna.paper.seeds import taken_hash
from hypertuna.paper.studies import STUDIES, Diverged, swim_gaits, swum
from hypertuna.simulation.run import TwinRun

FOLDER = Path(__file__).resolve().parents[2] / "data" / "twin"
FILE = FOLDER / "budget.json"
MASS = (1.0, 3.3 / 2.687)  # of the links: Table II, or all of Table I
FIN = (0.3, 30.0)  # N m/rad, of the caudal fin's root: softer than any that swims well, as good as rigid
PUBLISHED = np.array([published_value(f"speed/{name}") for name in SPEEDS])  # m/s
SECONDS = 12.0  # of a run, of which the last beats count
THREADS, BLOCK = 2, 8  # members whose runs share the lanes

STUDIED = ("postures", "dives", "lakes", "phases", "turns")
PART = 4  # members, of which one runs these studies: they take as long as all swims

Numbers = dict[str, Array]  # by name, a value for each member; NaN where the run diverged


def members() -> list[ht.Robot]:
    """Return the family."""
    return family.members_of(ht.load("hypertuna"))


def opened(robot: ht.Robot, rng: np.random.Generator) -> ht.Robot:
    """Return a robot with another mass of its links, reading of the areas and fin."""
    parts, document = rng.random(3), robot.document()
    scale = MASS[0] + (MASS[1] - MASS[0]) * parts[0]
    document["links"]["mass_kg"] = [scale * mass for mass in document["links"]["mass_kg"]]
    document["model"]["areas"] = "consistent" if parts[1] < 0.5 else "as-printed"
    stiffness = FIN[0] * (FIN[1] / FIN[0]) ** parts[2]
    document["hinge"] = {"link": len(robot.links.name) - 1, "stiffness_n_m_per_rad": stiffness}
    return parse(document, file=robot.file)


def measured(run: TwinRun) -> dict[str, float]:
    """Return the numbers of a run, NaN where it diverged."""
    numbers = {key.strip(): number for key, number in swum("", run.robot, run).items()}
    highest = run.pressure_max.reshape(-1, 2).max(axis=1) / 1e3
    numbers |= {f"cylinder {name}": kpa for name, kpa in zip(run.joints, highest.tolist(), strict=True)}
    return numbers if run.status == "completed" else dict.fromkeys(numbers, math.nan)


def swim(robots: Sequence[ht.Robot], names: Sequence[str], label: str, seeds: Sequence[int] | None = None) -> Numbers:
    """Swim gaits by name with every robot, by the seeds of their sensors' noise: by default the robots' places."""
    found: list[dict[str, float]] = []
    with progress_bar(label, slow=True) as progress:
        for first in range(0, len(robots), BLOCK):
            block = list(zip(seeds or range(len(robots)), robots, strict=True))[first : first + BLOCK]
            runs = [
                {"robot": robot, "gait": gaits[name], "seed": k, "duration": SECONDS, "start": "swimming"}
                for k, robot in block
                for gaits in (swim_gaits(robot),)
                for name in names
            ]
            seen = iter(ht.twins(runs, measure=measured, threads=THREADS))
            for _ in block:
                found.append({f"{name} {key}": value for name in names for key, value in next(seen).items()})
            progress(len(found), len(robots))
    return {key: np.array([one[key] for one in found]) for key in found[0]}


def studied(robots: Sequence[ht.Robot], study: str) -> Numbers:
    """Run a study of the ledger with every robot, whose place is the seed, and leave out who diverges."""

    def run(robot: ht.Robot, seed: int) -> dict[str, float] | None:
        try:
            return STUDIES[study].run(robot, seed)
        except Diverged:
            return None

    found: list[dict[str, float]] = []
    with ThreadPoolExecutor(THREADS) as pool, progress_bar(study, slow=True) as progress:
        for done, one in enumerate(pool.map(run, robots, range(len(robots))), 1):
            found += [one] if one is not None else []
            progress(done, len(robots))
    return {key: np.array([one[key] for one in found]) for key in found[0]}


def interval(values: Array) -> list[float]:
    """Return the ends of the 90 % interval, and the median between them."""
    low, middle, high = np.percentile(values, PERCENT, method="inverted_cdf")
    return [float(f"{value:.4g}") for value in (low, middle, high)]


def eight(numbers: Numbers, key: str) -> Array:
    """Return a number of the eight gaits (members, 8)."""
    return np.stack([numbers[f"{name} {key}"] for name in SPEEDS], axis=1)


def errors(numbers: Numbers) -> Array:
    """Return the rms error of the eight speeds of each member [%]."""
    return np.asarray(100 * np.sqrt(np.mean((eight(numbers, "speed") / PUBLISHED - 1) ** 2, axis=1)))


def kept(numbers: Numbers) -> Numbers:
    """Leave out members of whom a run diverged."""
    whole = np.all([np.isfinite(values) for values in numbers.values()], axis=0)
    return {key: values[whole] for key, values in numbers.items()}


def intervals(numbers: Numbers) -> dict[str, Any]:
    """Return intervals of speeds, powers, bends and pressures of the eight gaits, and of the error of all."""
    keys = {"speed_m_s": "speed", "power_w": "power", "lowest_kpa": "pressure"}
    for joint in ("I", "II"):
        keys |= {f"bend_deg_{joint}": f"swing {joint}", f"cylinder_kpa_{joint}": f"cylinder {joint}"}
    found = {name: {gait: interval(numbers[f"{gait} {key}"]) for gait in SPEEDS} for name, key in keys.items()}
    published = {"speed_m_s": dict(zip(SPEEDS, PUBLISHED, strict=True))}
    published["power_w"] = {gait: published_value(key) for key, gait in POWERS.items()}
    ends = [(found[name][gait], value) for name, values in published.items() for gait, value in values.items()]
    inside = sum(bool(low <= value <= high) for (low, _, high), value in ends)
    width = float(np.mean([(high - low) / 2 / middle for (low, middle, high), _ in ends]))
    return found | {"rms_percent": interval(errors(numbers)), "inside": inside, "half_width": round(width, 3)}


def standing(numbers: Numbers, own: Numbers) -> dict[str, Any]:
    """Return the default robot's numbers, and which part of the family is below them [%]."""
    rms, power = float(errors(own)[0]), "unoptimised-max power"
    below = [np.mean(errors(numbers) < rms), np.mean(numbers[power] < own[power][0])]
    return {
        "speed_m_s": dict(zip(SPEEDS, eight(own, "speed")[0].round(4).tolist(), strict=True)),
        "power_w": dict(zip(SPEEDS, eight(own, "power")[0].round(2).tolist(), strict=True)),
        "rms_percent": round(rms, 2),
        "percentile_rms": round(100 * float(below[0]), 1),
        "percentile_power": round(100 * float(below[1]), 1),
    }


def summary(robot: ht.Robot, lumped: Numbers, strips: Numbers, studies: Mapping[str, Numbers]) -> dict[str, Any]:
    """Return all intervals of the family, and where the default robot stands, which comes last."""
    found = {}
    for law, numbers in (("lumped", lumped), ("strips", strips)):
        whole, own = ({key: values[part] for key, values in numbers.items()} for part in (slice(-1), slice(-1, None)))
        total, whole = len(errors(whole)), kept(whole)
        lost = total - len(errors(whole))
        found[law] = (whole, intervals(whole) | {"shipped": standing(whole, own), "diverged": lost})
    shares = bands(robot, {"swims": found["lumped"][0], "strips": found["strips"][0], **studies})
    entries = {key: [float(f"{value:.6g}") for value in band] for key, band in shares.items()}
    return found["lumped"][1] | {"strips": found["strips"][1], "entries": entries}


def family_hash() -> str:
    """Return what changes with the family."""
    return hashlib.sha256(family.FILE.read_bytes()).hexdigest()


def every(numbers: Numbers) -> dict[str, list[list[float | None]]]:
    """Return speeds and powers of each member, which posterior.py reads; null where a run diverged."""
    rows = {name: eight(numbers, key)[:-1].round(4) for name, key in (("speed_m_s", "speed"), ("power_w", "power"))}
    return {name: np.where(np.isnan(row), None, row).tolist() for name, row in rows.items()}


def main() -> None:
    """Swim, store the intervals."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    robot, robots, rng = ht.load("hypertuna"), members(), np.random.default_rng(asked.seed)
    made = {"hypertuna_version": version(), "taken_hash": taken_hash(robot), "family_hash": family_hash()}
    open_too = [opened(one, rng) for one in robots]
    lumped = swim([*robots, robot], list(swim_gaits(robot)), "the family in lumped water")
    strips = swim([one.using(water="strip") for one in (*robots, robot)], SPEEDS, "the family in strips")
    studies = {study: studied(robots[::PART], study) for study in STUDIED}
    wide = swim(open_too, SPEEDS, "with all that is open, in lumped water")
    record = made | {"command": "python validation/twin/budget.py", **vars(asked), "draws": len(robots)}
    record |= {"interval_percent": [PERCENT[0], PERCENT[-1]], **summary(robot, lumped, strips, studies)}
    record["studied"] = {study: len(next(iter(numbers.values()))) for study, numbers in studies.items()}
    record["with all that is open"] = intervals(kept(wide))
    record["members"] = {law: every(found) for law, found in (("lumped", lumped), ("strips", strips))}
    write_atomically(FILE, lines(record))


if __name__ == "__main__":
    main()
