"""How often do the 90 % intervals of `hypertuna joint family` hold the truth, and do rows narrow them as expected?

`python family.py [COUNT] [MEMBERS]` draws actuators of joint I within the bounds, bends each by 250 kPa to the left,
and samples the family of that one bend, and that with the blocked force of the joint as well. It prints how many
intervals hold the truth, and by how much the force narrowed that of the stiffness, as expected and once measured.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import hypertuna as ht
from hypertuna.actuation.bending import bend
from hypertuna.characterization.data import Bench, read_bench
from hypertuna.characterization.designs import designs, with_room
from hypertuna.characterization.experiment_design import open_quantities
from hypertuna.characterization.family import Family, family
from hypertuna.characterization.problem import blocked_moment
from hypertuna.characterization.unknowns import with_unknowns
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError

FISH = ht.load("hypertuna")
TOP, ARM = 250e3, 0.08  # highest pressure [Pa]; from the joint to where its force is measured [m]
ANGLE, FORCE = np.radians(0.2), 0.05  # noise of measured angles [rad], and relative noise of forces
HEAD = "joint,side,pressure_kpa,angle_deg,angle_sd_deg,force_n,arm_mm"  # columns of a bench file
BENDS = np.radians([2, 60])  # least and largest bend at the highest pressure; other draws are dropped


def drawn(rng: np.random.Generator, bench: Bench) -> Robot | None:
    """Draw an actuator from the family's prior; None where its parts do not fit, or it bends too little or too much."""
    space = designs(FISH, bench, model_error=0.0)
    values = space.values(rng.random(len(space.free)))
    try:
        fish = with_room(with_unknowns(FISH, space.free, values, checked=False), 0)
    except InputError:
        return None
    curve = bend(fish, 0, [TOP])
    return fish if curve.status == "free" and BENDS[0] < curve.angle[0] < BENDS[1] else None


def measured(folder: Path, *rows: str) -> Bench:
    """Write these rows to a bench file, and read it."""
    path = folder / "bench.csv"
    path.write_text("\n".join([HEAD, *rows]) + "\n", encoding="utf-8")
    return read_bench(path, FISH)


def repeat(seed: int, members: int, folder: Path) -> tuple[Robot, Family, Family] | None:
    """Draw an actuator; return it, the family of its measured bend, and that of its bend and blocked force."""
    rng = np.random.default_rng(seed)
    any_row = measured(folder, "I,left,250,10,0.2,,")
    fish = drawn(rng, any_row)
    if fish is None:
        return None
    angle = np.degrees(float(bend(fish, 0, [TOP]).angle[0]) + ANGLE * rng.standard_normal())
    force = blocked_moment(fish, 0, TOP, arm=ARM) / ARM * (1 + FORCE * rng.standard_normal())
    rows = (f"I,left,250,{angle:.5f},{np.degrees(ANGLE):.3f},,", f"I,left,250,,,{force:.5f},{1e3 * ARM:g}")
    alone, both = (family(FISH, measured(folder, *part), members=members, model_error=0.0) for part in (rows[:1], rows))
    return fish, alone, both


def quantities(found: Family) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the name and every member's value of the quantities that a measured bend leaves open."""
    bench = replace(found.space.bench, moment=np.full_like(found.space.bench.moment, np.nan))
    for one in open_quantities(FISH, bench):
        yield one.text.partition(" of joint")[0], np.array([one.of(member.robot) for member in found.members])


def main(count: int, members: int) -> None:
    """Count."""
    inside: dict[str, list[bool]] = {}
    narrowed, seed = [], 0
    with TemporaryDirectory() as folder:
        while len(narrowed) < count:
            found = repeat(seed, members, Path(folder))
            seed += 1
            if found is None:
                continue
            fish, *families = found
            spread = []
            for name, one in zip(("bend", "bend and force"), families, strict=True):
                truths = {
                    q.text.partition(" of joint")[0]: q.of(fish) for q in open_quantities(FISH, families[0].space.bench)
                }
                for text, values in quantities(one):
                    low, high = np.quantile(values, (0.05, 0.95))
                    inside.setdefault(f"{text} by {name}", []).append(bool(low <= truths[text] <= high))
                    if text.startswith("moment per bend"):
                        spread.append(np.std(np.log(values)))
            told = next(one for one in families[0].next if one.text.startswith("blocked force of joint I"))
            expected = next((r for text, r in told.narrows.items() if text.startswith("moment per bend")), 1.0)
            narrowed.append((expected, spread[1] / spread[0]))
            held = {text: f"{np.mean(v):.2f}" for text, v in inside.items() if text.startswith("blocked")}
            print(seed, len(narrowed), held, np.round(narrowed[-1], 2), flush=True)
    for text, held in inside.items():
        print(f"{text}: {100 * np.mean(held):.0f} % of {len(held)}")
    expected, real = np.exp(np.mean(np.log(narrowed), axis=0))
    print(f"the force narrows the moment per bend to {100 * expected:.0f} % expected, {100 * real:.0f} % measured")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100, int(sys.argv[2]) if len(sys.argv) > 2 else 100)
