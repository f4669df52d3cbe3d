"""What the swimming speeds say of the family afterwards: data/twin/posterior.json, all of it of the class "fitted".

python validation/twin/posterior.py [STEPS] [--seed N]    96 steps in a generation: three minutes on two cores

Each member of the family counts by the speeds of the four unoptimised gaits that budget.py has stored. Their errors
have one standard deviation, which nobody knows: it is integrated out (Jeffreys' prior). The four optimised gaits and
both powers judge. Then a search looks for the member that swims the four best: with an axis that holds as the family
has it, and with one that carries what it must.
"""

import argparse
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import budget
import family
import numpy as np
from study import lines, rms

import hypertuna as ht
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.arrays import Array
from hypertuna.characterization.designs import Designs
from hypertuna.io.files import version, write_atomically
from hypertuna.paper.computed import SPEEDS
from hypertuna.paper.seeds import taken_hash

FILE = budget.FOLDER / "posterior.json"
IN = SPEEDS[:4]  # the unoptimised gaits, which give the weights; the optimised ones test them
SWUM = ("speed_m_s", "power_w")  # stored results of the eight gaits
ARM = 0.08  # m, from the joint's middle to the hook of the scale that measures its force
AXES = {  # buckling force of what lies on a joint's axis, ranges of joints I and II [N]
    "best with a free axis": ((2.4, 13.0), (2.4, 13.0)),
    "best with any axis": ((2.4, 1000.0), (2.4, 1000.0)),
}
# Generations of the search; best candidates that each starts from; step, over a range
GENERATIONS, BEST, STEP = 4, 8, 0.08
# Quantities of the page, in its units: name in family.json, and factor from SI.
QUANTITIES = {
    "blocked moment of joint I [N m]": ("blocked moment of joint I", 1.0),
    "blocked moment of joint II [N m]": ("blocked moment of joint II", 1.0),
    "shortening of joint I [mm]": ("shortening of joint I", 1e3),
    "lever of joint I [mm]": ("lever[I]", 1e3),
    "lever of joint II [mm]": ("lever[II]", 1e3),
    "outer diameter of the hose [mm]": ("outer_diameter", 1e3),
    "braid angle [deg]": ("braid_angle", math.degrees(1)),
    "friction of the braid": ("friction", 1.0),
    "axis of joint I buckles at [N]": ("axis_buckling[I]", 1.0),
    "working limit [kPa]": ("controller.pressure_work_pa", 1e-3),
    "fill pressure [kPa]": ("joints.line.fill_pressure_pa", 1e-3),
    "bore of the lines [mm]": ("joints.line.bore_m", 1e3),
    "bore of the pump [mm]": ("pump.bore_m", 1e3),
    "idle current of a servo [A]": (family.IDLE, 1.0),
}


def weights(speeds: Array) -> Array:
    """Return members' weights by their speeds in the four gaits, from those in the eight (members, 8)."""
    logs = np.log(np.maximum(speeds, 1e-3) / budget.PUBLISHED)[:, : len(IN)]
    part = np.where(np.isfinite(speeds).all(axis=1), np.sum(logs**2, axis=1) ** (-len(IN) / 2), 0)
    return np.asarray(part / part.sum())


def interval(values: Array, weight: Array) -> list[float]:
    """Return the 90 % interval and the median of weighted values; a value without weight may be NaN."""
    order = np.argsort(values[weight > 0])
    value, part = values[weight > 0][order], weight[weight > 0][order]
    share = np.cumsum(part) - part / 2
    ends = np.interp(np.array(budget.PERCENT) / 100 * part.sum(), share, value)
    return [float(f"{end:.4g}") for end in ends]


def afterwards(members: Sequence[Mapping[str, float]], speeds: Array, powers: Array) -> dict[str, Any]:
    """Return intervals of quantities, speeds and powers, without and with weights by the four speeds."""
    after = weights(speeds)
    before = (after > 0) / np.count_nonzero(after)
    numbers = {name: factor * np.array([one[key] for one in members]) for name, (key, factor) in QUANTITIES.items()}
    for name, speed, power in zip(SPEEDS, speeds.T, powers.T, strict=True):
        numbers |= {f"speed, {name}": speed, f"power, {name}": power}
    found = {name: [interval(values, weight) for weight in (before, after)] for name, values in numbers.items()}
    counting = round(float(1 / np.sum(after**2)), 1)
    return {"counting_as": counting, "weights": after.round(5).tolist(), "before_and_after": found}


def numbers_of(robot: ht.Robot, swum: Mapping[str, Sequence[float]]) -> dict[str, Any]:
    """Return a robot's changes, speeds, powers, errors and bench values, for the page."""
    halves = [round(100 * rms(swum[SWUM[0]][part], SPEEDS[part]), 1) for part in (slice(4), slice(4, 8))]
    return {
        "changes": family.changes(robot, ht.load("hypertuna")),
        **{key: [float(f"{value:.4g}") for value in values] for key, values in swum.items()},
        **{"rms_in_percent": halves[0], "rms_out_percent": halves[1]},
        "statics": family.finite(family.statics(robot)),
        "axis_n": {group.name: round(held(robot, j), 1) for j, group in enumerate(robot.joints)},
    }


def held(robot: ht.Robot, joint: int) -> float:
    """Return a joint axis's largest compression [N]: filled, and with one side at the working limit."""
    model, limit = joint_models(robot)[joint], robot.controller.works_at
    sides = np.array([[model.fill, model.fill], [limit, 0.0], [limit, model.fill]])
    strain = model.balance(sides)["strain"] + model["rest"]
    return float(model["axis_stiffness"] * np.clip(-strain, 0, model["axis_buckling"]).max())


# --- search


def beside(one: family.Candidate, space: Designs, rng: np.random.Generator) -> family.Candidate | None:
    """Return a candidate one random step from another; None where its parts do not fit or it cannot be filled."""

    def stepped(part: float) -> float:
        return float(np.clip(part + STEP * rng.normal(), 0, 1))

    point = [stepped(place(u.log(one.values[u.name]), u.log(u.lower), u.log(u.upper))) for u in space.free]
    design = space.at(np.array([*point, *np.zeros(len(space.solved))]))
    if design.excluded:
        return None
    values = dict(zip([u.name for u in space.free], design.values.tolist(), strict=True))
    others = (
        place(math.log(one.values[name]), math.log(low), math.log(high)) if low > 0 else one.values[name] / high
        for name, (low, high) in family.OTHERS.items()
    )
    return family.complete(family.Candidate(design.robot, values), map(stepped, others))


def place(value: float, low: float, high: float) -> float:
    """Return a value's place between two others, 0 to 1."""
    return (value - low) / (high - low)


def swum(candidates: Sequence[family.Candidate | None], rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Swim the eight gaits with the candidates that meet all facts; yield their values."""
    known = [one for one in candidates if one is not None]
    family.judge(known)
    kept = [family.idled(one, rng)[1] for one in known if not one.excluded]
    runs = budget.swim([one.robot for one in kept], SPEEDS, "speeds") if kept else {}
    for k, one in enumerate(kept):
        speeds = [budget.eight(runs, key)[k] for key in ("speed", "power")]
        if np.isfinite(speeds).all():
            yield {"candidate": one, "score": rms(speeds[0][:4], IN), "swum": dict(zip(SWUM, speeds, strict=True))}


def search(
    axes: Sequence[tuple[float, float]], known: Sequence[dict[str, Any]], steps: int, seed: int
) -> dict[str, Any]:
    """Find the candidate whose four speeds fit best, by random steps from the best ones so far."""
    bounds, rng = dict(zip(("axis_buckling[I]", "axis_buckling[II]"), axes, strict=True)), np.random.default_rng(seed)
    space = family.space_of(ht.load("hypertuna"), family.ACTUATOR | bounds)

    def allowed(values: Mapping[str, float]) -> bool:
        return all(low <= values[key] <= high for key, (low, high) in bounds.items())

    found = [one for one in known if allowed(one["candidate"].values)]
    for _ in range(GENERATIONS):
        best = sorted(found, key=lambda one: one["score"])[:BEST]
        found += swum([beside(best[k % len(best)]["candidate"], space, rng) for k in range(steps)], rng)
    robot = min(found, key=lambda one: one["score"])["candidate"].robot
    runs = budget.swim([robot], SPEEDS, "the best")  # with other noise, which was chosen for nobody
    speeds = {name: budget.eight(runs, key)[0] for name, key in zip(SWUM, ("speed", "power"), strict=True)}
    return {"swum": len(found), **numbers_of(robot, speeds)}


def main() -> None:
    """Weigh the family, search, store."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("steps", type=int, nargs="?", default=96)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    robot = ht.load("hypertuna")
    swims = json.loads(budget.FILE.read_text(encoding="utf-8"))
    if swims["family_hash"] != budget.family_hash():
        parser.error("data/twin/budget.json is of another family: run python validation/twin/budget.py first")
    members = [one["values"] for one in json.loads(family.FILE.read_text(encoding="utf-8"))["members"]]
    laws = {law: [np.array(found[key], float) for key in SWUM] for law, found in swims["members"].items()}
    known = [
        {"candidate": family.Candidate(other, values), "score": rms(u[:4], IN), "swum": {SWUM[0]: u, SWUM[1]: p}}
        for other, values, u, p in zip(budget.members(), members, *laws["lumped"], strict=True)
    ]
    record = {"hypertuna_version": version(), "taken_hash": taken_hash(robot), "family_hash": budget.family_hash()}
    record |= {"command": "python validation/twin/posterior.py", **vars(asked), "class": "fitted", "arm_m": ARM}
    record |= {law: afterwards(members, *found) for law, found in laws.items()}
    own = {key: list(swims["shipped"][key].values()) for key in SWUM}
    robots = {name: search(axes, known, asked.steps, asked.seed) for name, axes in AXES.items()}
    record["robots"] = {"default robot": numbers_of(robot, own), **robots}
    write_atomically(FILE, lines(record))


if __name__ == "__main__":
    main()
