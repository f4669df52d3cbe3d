"""Joints, hydraulics and servos that HyperTuna may have had: data/twin/family.json.

python validation/twin/family.py [CANDIDATES] [--seed N]    3000 candidates: a quarter of an hour on two cores
python validation/twin/family.py --strong                   write examples/hypertuna-strong.toml
python validation/twin/family.py --of ROBOT                 how a robot meets the facts, over 32 seeds of its sensors

Actuators are drawn from their ranges where both published bends allow them (`hypertuna joint family`), all else from
`OTHERS`. The twin runs each candidate through the other published facts: it excludes what contradicts one, and weighs
what falls short of a soft one. Members are drawn by these weights. No speed is computed. docs/joint.md has the result.
"""

import argparse
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.hydraulics import circuits
from hypertuna.actuation.soft_joint import mooney, soft_joint
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.designs import Designs, designs
from hypertuna.characterization.population import populate
from hypertuna.characterization.problem import blocked_moment, shortening
from hypertuna.cli.console import progress_bar
from hypertuna.description.changes import NAMES, changed
from hypertuna.description.robot import parse
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError
from hypertuna.io.files import version, write_atomically
from hypertuna.paper.ledger import published, published_value
from hypertuna.simulation.plant import controller_of
from hypertuna.simulation.posture import MAX_ERROR, fitted_peaks
from hypertuna.simulation.run import TwinRun

FILE = Path(__file__).resolve().parents[2] / "data" / "twin" / "family.json"
MEMBERS = 200  # of the stored family
SEEDS = 32  # of the sensors' noise, for the default robot
THREADS = 2
BLOCK = 64  # candidates that run at once, in the lanes of a vector
# Values that are stored of all candidates, excluded ones too
SHOWN = ("lever[I]", "lever[II]", "blocked moment of joint I", "blocked moment of joint II")
# Ranges of the actuator's unknowns, [SI] or relative to the description; docs/joint.md has the reasons.
SILICONE = {"matrix_modulus": (67.2e3, 141.8e3), "hose_modulus": (169.1e3, 260.1e3)}  # Pa: tensile tests, Table I
ACTUATOR = {
    "lever[I]": (0.0035, 0.022),
    "lever[II]": (0.0035, 0.0141),
    "outer_diameter": (0.0025, 0.008),
    "diameter_ratio": (0.5, 0.8),
    "braid_angle": (math.radians(25.0), math.radians(45.0)),
    "friction": (0.03, 0.3),
    "axis_buckling[I]": (2.4, 210.0),  # from the bend sensor's film to two plastic oil pipes
    "axis_buckling[II]": (2.4, 13.0),  # no pipe passes joint II
}
# Unknowns of the actuator that are drawn
FREE = ("lever", *SILICONE, "outer_diameter", "diameter_ratio", "braid_angle", "friction", "axis_buckling")
# Ranges of all else, drawn evenly on a logarithmic scale but for the fill pressure; "times": over the description.
OTHERS = {
    "controller.pressure_work_pa": (200e3, 600e3),
    "joints.line.fill_pressure_pa": (0.0, 250e3),
    "joints.line.bore_m": (0.003, 0.006),
    "times joints.line.compliance_m3_pa": (0.3, 3.0),
    "oil.air": (0.005, 0.05),
    "oil.temperature_c": (10.0, 30.0),
    "pump.bore_m": (0.010, 0.024),
    "pump.seal_friction_n": (3.0, 30.0),
    "servos.piston pump.torque_n_m": (5.8, 7.9),
    "servos.piston pump.speed_rad_s": (6.7, 8.3),
    "servos.piston pump.bandwidth_hz": (5.0, 20.0),
    "servos.piston pump.inertia_kg_m2": (0.0032, 0.0135),
    "servos.piston pump.friction_n_m": (0.15, 0.6),
    "servos.piston pump.stall_current_a": (5.0, 9.0),
    "servos.piston pump.idle_current_a": (0.01, 0.4),
}
SENSOR_HIGH = (500e3, 1000e3)  # Pa: upper ends of the pressure sensor's range

# Published facts with the standard deviation that they count with.
BENCH = Path(__file__).resolve().parents[2] / "examples" / "bench" / "paper.csv"  # both bends, at 3 % of the model
PRESSURES = np.array([100e3, 150e3, 200e3, 250e3])  # Pa, at which bends are checked for a line
STRAIGHT, STRAIGHT_SD = 0.96, 0.01  # R^2 taken for "a linear trend", and its standard deviation
POSTURE = published()["posture"]  # published numbers of the posture test
BOUNDS = {"unoptimised-0.3": 0.3, "unoptimised-0.4": 0.4, "unoptimised-0.5": 0.5}  # m/s, published
POWER_PART = 0.1  # relative standard deviation of a measured power
SUCTION = 50e3  # Pa of suction that count as one standard deviation from "no negative pressure"
SECONDS, WITHIN = 8.0, 4.0  # s, duration of a run, and within which a joint must settle
IDLE = "servos.piston pump.idle_current_a"  # key of the idle current


@dataclass
class Candidate:
    """A robot, its estimates and computed values, and how well it meets each fact [nats, 0 or less]."""

    robot: ht.Robot
    values: dict[str, float]
    facts: dict[str, float] = field(default_factory=dict)

    @property
    def excluded(self) -> str:
        """Return the name of the fact that excludes the candidate; empty if none does."""
        return next((fact for fact, value in self.facts.items() if value == -math.inf), "")


def space_of(robot: ht.Robot, ranges: Mapping[str, tuple[float, float]] = ACTUATOR) -> Designs:
    """Return the space of actuators that meet both bends."""
    own = {name: mooney(robot, getattr(robot.drive_unit, name.removesuffix("_modulus"))).modulus for name in SILICONE}
    bounds = {**ranges} | {name: (low / own[name], high / own[name]) for name, (low, high) in SILICONE.items()}
    return designs(robot, read_bench(BENCH, robot), FREE, bounds=bounds)


def actuators(space: Designs, count: int, seed: int) -> tuple[list[Candidate], list[dict[str, Any]]]:
    """Return actuators that meet both bends and fit the body, and the reasons why other draws were excluded."""
    with progress_bar("actuators") as progress:
        found = populate(space, count, seed=seed, progress=progress)
    names = [one.name for one in space.free]
    drawn = [
        {"excluded": one.excluded or "bends"}
        | finite({n: v for n, v in zip(names, one.values.tolist(), strict=True) if n in SHOWN})
        for one in found.drawn
    ]
    return [Candidate(one.robot, dict(zip(names, one.values.tolist(), strict=True))) for one in found.members], drawn


def complete(candidate: Candidate, parts: Iterator[float]) -> Candidate | None:
    """Add `OTHERS` to a candidate, at parts of their ranges in order; None where its fill pressure is too high."""
    values = {
        name: low * (high / low) ** next(parts) if low > 0 else high * next(parts)
        for name, (low, high) in OTHERS.items()
    }
    changes = {name: value for name, value in values.items() if not name.startswith("times ")}
    for group in candidate.robot.joints:
        key = f"joints.{group.name}.line.compliance_m3_pa"
        changes[key] = values["times joints.line.compliance_m3_pa"] * group.line.compliance
    work = values["controller.pressure_work_pa"]
    limits = {"soft": 1.25, "hard": 1.5, "step": 1.0}
    changes |= {f"controller.pressure_{name}_pa": times * work for name, times in limits.items()}
    changes["sensors.pressure.high"] = next(
        high for high in SENSOR_HIGH if 1.5 * work <= high or high == max(SENSOR_HIGH)
    )
    try:
        return Candidate(changed(candidate.robot, changes), candidate.values | values)
    except InputError:
        return None


def measured(run: TwinRun) -> dict[str, float]:
    """Return a run's measures: time to settle by the bend sensor [s], power, idle power [W], suction [Pa]."""
    if run.status == "diverged":
        return {"settled": math.inf, "power": math.nan, "lowest": math.nan}
    if run.medium == "water":
        return {"power": run.electrical_power, "lowest": float(run.pressure_min.min())}
    joint = run.joints.index(POSTURE["joint"])
    end, peaks = fitted_peaks(run.time, run.data["angle_measured"][:, joint], run.gait.frequency)
    late = np.flatnonzero(~(abs(peaks - math.radians(POSTURE["angle_deg"])).max(axis=1) < MAX_ERROR))
    first = late[-1] + 1 if late.size else 0
    return {"settled": math.inf if first == len(end) else float(end[first])}


def ran(candidates: Sequence[Candidate], gaits: Sequence[Any], **options: Any) -> list[list[dict[str, float]]]:
    """Run every candidate through every gait."""
    base = {"duration": SECONDS, **options}
    runs = [base | {"robot": one.robot, "gait": gait} for one in candidates for gait in gaits]
    seen = ht.twins(runs, measure=measured, threads=THREADS)
    return [seen[k : k + len(gaits)] for k in range(0, len(seen), len(gaits))]


def bench(candidate: Candidate) -> None:
    """Judge a candidate by facts that need no run: straightness of bends, the pump's stroke, the servos' torque."""
    robot, facts = candidate.robot, candidate.facts
    facts["straightness"] = 0.0
    for joint, _ in enumerate(robot.joints):
        short = max(0.0, STRAIGHT - straightness(robot, joint)[1])
        facts["straightness"] -= 0.5 * (short / STRAIGHT_SD) ** 2
    try:
        controller_of(robot)
    except InputError:
        facts["stroke of the pump"] = -math.inf
        return
    if torque_at_limit(robot) > 1:
        facts["torque of the servos"] = -math.inf
    candidate.values.update(statics(robot))


def judge(candidates: Sequence[Candidate]) -> None:
    """Judge candidates by all facts; the first that excludes one ends its judgment."""
    for one in candidates:
        bench(one)
    left = [one for one in candidates if not one.excluded]
    for frequency in reversed(POSTURE["frequency_hz"]):  # the one that excludes most comes first
        if not left:
            return
        for one, (seen,) in zip(left, ran(left, [posture_gait(left, frequency)], medium="air"), strict=True):
            one.values[f"settling at {frequency:g} Hz"] = seen["settled"]
            if seen["settled"] > WITHIN:
                one.facts["Fig. 8"] = -math.inf
        left = [one for one in left if not one.excluded]
    for one, swims in zip(left, ran(left, list(BOUNDS), start="swimming"), strict=True):
        one.values.update({f"power, {name}": run["power"] for name, run in zip(BOUNDS, swims, strict=True)})
        one.values["lowest"] = min(run["lowest"] for run in swims)
        one.facts["no suction"] = -0.5 * (min(0.0, one.values["lowest"]) / SUCTION) ** 2
        if not all(run["power"] > 0 for run in swims):
            one.facts["diverged"] = -math.inf


def posture_gait(candidates: Sequence[Candidate], frequency: float) -> ht.Gait:
    """Return the command of Fig. 8 at a frequency."""
    names = [group.name for one in candidates[:1] for group in one.robot.joints]
    angle = tuple(POSTURE["angle_deg"] if name == POSTURE["joint"] else 0.0 for name in names)
    return ht.Gait.from_degrees(frequency=frequency, amplitude=angle, phase=(0.0,) * len(angle))


def idled(candidate: Candidate, rng: np.random.Generator) -> tuple[float, Candidate]:
    """Draw an idle current that fits the bounds of the power; return the candidate's weight [nats], too.

    Nothing but the power depends on it: so it is drawn after the runs, from its whole range at once.
    """
    servo = next(servo for servo in candidate.robot.servos if servo.drives == "piston pump")
    low, high = OTHERS[IDLE]
    grid = low * (high / low) ** np.linspace(0, 1, 60)
    least = published_value("cost-of-transport/minimum") * candidate.robot.body.mass  # J/m
    added = servo.count * servo.voltage * (grid - candidate.values[IDLE])  # W
    power = {name: candidate.values[f"power, {name}"] + added for name in BOUNDS}
    short = sum(np.log(np.maximum(1, least * BOUNDS[name] / power[name])) ** 2 for name in BOUNDS)
    chance = np.exp(-0.5 * short / POWER_PART**2)
    k = int(rng.choice(len(grid), p=chance / chance.sum()))
    values = candidate.values | {IDLE: float(grid[k])} | {f"power, {name}": float(p[k]) for name, p in power.items()}
    robot = changed(candidate.robot, {IDLE: float(grid[k])})
    return math.log(chance.mean()), Candidate(robot, values, candidate.facts)


def straightness(robot: ht.Robot, joint: int) -> tuple[float, float]:
    """Return the bend at the largest pressure [rad], and R^2 of a line through the bends."""
    path = np.asarray(soft_joint(robot, joint).bend(np.column_stack([PRESSURES, 0 * PRESSURES])))
    bends = path[..., 0].sum(axis=1)
    return float(bends[-1]), float(np.corrcoef(PRESSURES, bends)[0, 1] ** 2)


def torque_at_limit(robot: ht.Robot) -> float:
    """Return the torque that a pump's servo needs at the working pressure, over its stall torque."""
    oil = circuits(robot)
    slope = max(float(_core.displaced(row, np.linspace(-0.5, 0.5, 51))[:, 1].max()) for row in oil.values)
    return robot.controller.works_at * slope / float(oil.column("stall_torque").min())


def statics(robot: ht.Robot) -> dict[str, float]:
    """Return the joints' blocked moments and shortenings at 250 kPa, as on a bench [N m, m]."""
    found = {}
    for joint, group in enumerate(robot.joints):
        found[f"blocked moment of joint {group.name}"] = blocked_moment(robot, joint, float(PRESSURES[-1]))
        found[f"shortening of joint {group.name}"] = float(shortening(robot, joint, PRESSURES)[-1])
    return found


def resampled(weight: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Draw indices by weights in nats, evenly spread (systematic resampling)."""
    part = np.exp(weight - weight.max())
    places = (rng.random() + np.arange(count)) / count
    return np.searchsorted(np.cumsum(part / part.sum()), places)


def leaves(node: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of a document by their keys; the tables of a list by name."""
    if isinstance(node, dict):
        for name, part in node.items():
            yield from leaves(part, f"{key}.{name}".lstrip("."))
    elif isinstance(node, list) and node and isinstance(node[0], dict):
        for k, part in enumerate(node):
            name = next((str(part[one]) for one in NAMES if one in part), f"[{k}]")
            yield from leaves(part, f"{key}.{name}")
    else:
        yield key, node


def changes(robot: ht.Robot, base: ht.Robot) -> dict[str, Any]:
    """Return what differs from a robot, as `hypertuna.description.changes.changed` takes it."""
    own = dict(leaves(base.document() | {"sources": {}}))
    found = {k: v for k, v in leaves(robot.document() | {"sources": {}}) if own.get(k) != v}
    return {k: [float(f"{x:.5g}") for x in v] if isinstance(v, list) else float(f"{v:.5g}") for k, v in found.items()}


def finite(values: Mapping[str, float]) -> dict[str, float]:
    """Round numbers to five digits, and leave out what is not finite."""
    return {name: float(f"{value:.5g}") for name, value in values.items() if math.isfinite(value)}


def strong() -> ht.Robot:
    """Return the stored member at the 95th percentile of strength, the mean of both joints'."""
    stored = json.loads(FILE.read_text(encoding="utf-8"))["members"]
    moments = np.log([[one["values"][f"blocked moment of joint {name}"] for name in ("I", "II")] for one in stored])
    strength = ((moments - moments.mean(axis=0)) / moments.std(axis=0)).mean(axis=1)
    k = int(np.argmin(abs(strength - np.quantile(strength, 0.95))))
    document = changed(ht.load("hypertuna"), stored[k]["changes"]).document()
    text = f"estimate: member {k} of data/twin/family.json, whose joints are as strong as those of 95 % of all"
    document["sources"] = {key: text if " set to " in one else one for key, one in document["sources"].items()}
    document |= {
        "name": "hypertuna-strong",
        "description": "HyperTuna with the strong joints that published facts allow",
    }
    return parse(document, file=ht.load("hypertuna").file)


def members_of(robot: ht.Robot) -> list[ht.Robot]:
    """Return the stored members as robots."""
    return [changed(robot, one["changes"]) for one in json.loads(FILE.read_text(encoding="utf-8"))["members"]]


def from_middle(members: Sequence[Candidate]) -> np.ndarray:
    """Return members' distances from the family's middle, in standard deviations of all logarithmic values."""
    names = [name for name in members[0].values if "power" not in name and "settling" not in name and name != "lowest"]
    logs = np.log(np.maximum([[one.values[name] for name in names] for one in members], 1e-9))
    return np.sqrt((((logs - np.median(logs, axis=0)) / logs.std(axis=0)) ** 2).mean(axis=1))


def standing(robot: ht.Robot) -> Iterator[str]:
    """Yield lines of text on how a robot meets the facts, over seeds of the sensors' noise."""
    for joint, group in enumerate(robot.joints):
        bend, straight = straightness(robot, joint)
        yield f"joint {group.name}: {math.degrees(bend):.2f} deg at 250 kPa, R^2 {straight:.3f}"
    yield f"torque at the limit over the stall torque: {torque_at_limit(robot):.2f}"
    yield from (f"{name}: {value:.4g}" for name, value in statics(robot).items())
    one = Candidate(robot, {})
    for frequency in POSTURE["frequency_hz"]:
        gait = posture_gait([one], frequency)
        base = {"robot": robot, "gait": gait, "duration": SECONDS, "medium": "air"}
        seen = ht.twins([base | {"seed": seed} for seed in range(SEEDS)], measure=measured, threads=THREADS)
        count = sum(run["settled"] <= WITHIN for run in seen)
        yield f"Fig. 8 at {frequency:g} Hz: {count} of {SEEDS} settle within {WITHIN:g} s"
    least = published_value("cost-of-transport/minimum") * robot.body.mass
    for (name, speed), run in zip(BOUNDS.items(), ran([one], list(BOUNDS), start="swimming")[0], strict=True):
        lowest = run["lowest"] / 1e3
        yield f"{name}: {run['power']:.1f} W, at least {least * speed:.1f}; lowest pressure {lowest:.0f} kPa"


def main() -> None:
    """Draw candidates, run them through the facts, draw members, store."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("candidates", type=int, nargs="?", default=3000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--of", metavar="ROBOT")
    parser.add_argument("--strong", action="store_true")
    asked = parser.parse_args()
    if asked.strong:
        print("written:", write_robot(strong(), FILE.parents[2] / "examples" / "hypertuna-strong.toml"))
        return
    if asked.of:
        print(*standing(ht.load(asked.of)), sep="\n")
        return
    robot, rng = ht.load("hypertuna"), np.random.default_rng(asked.seed)
    bent, excluded = actuators(space_of(robot), asked.candidates, asked.seed)
    parts = iter(rng.random, None)
    candidates = [one for part in bent if (one := complete(part, parts)) is not None]
    with progress_bar("candidates", slow=True) as progress:
        for k in range(0, len(candidates), BLOCK):
            judge(candidates[k : k + BLOCK])
            progress(min(k + BLOCK, len(candidates)), len(candidates))
    kept = [one for one in candidates if not one.excluded]
    idle = [idled(one, rng) for one in kept]
    weight = np.array([one.facts["no suction"] + one.facts["straightness"] + own for own, one in idle])
    members = [idle[k][1] for k in resampled(weight, MEMBERS, rng)]
    away, part = from_middle(members), np.exp(weight - weight.max())
    made = {"hypertuna_version": version(), "command": "python validation/twin/family.py", "robot_hash": robot.hash}
    made |= {"candidates": asked.candidates, "seed": asked.seed, "judged": len(candidates), "kept": len(kept)}
    made |= {"counting_as": float(part.sum() ** 2 / (part**2).sum())}
    stored = [
        {"from_middle": float(d), "changes": changes(one.robot, robot), "values": finite(one.values)}
        for d, one in zip(away, members, strict=True)
    ]
    others = [
        {"excluded": one.excluded, **finite({k: one.values[k] for k in one.values if k in SHOWN})} for one in candidates
    ]
    record = made | {"members": stored, "candidates": others, "drawn": excluded}
    write_atomically(FILE, (json.dumps(record, separators=(",", ":")) + "\n").encode())
    print(f"{len(kept)} of {len(candidates)} candidates meet all facts; they count as {made['counting_as']:.0f}")
    print(f"nearest to the middle: {sorted(range(len(members)), key=lambda k: away[k])[:5]}")


if __name__ == "__main__":
    main()
