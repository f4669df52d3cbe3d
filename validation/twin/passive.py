"""The question that the paper ends with, joint II passive and tuned: data/twin/passive.json.

python validation/twin/passive.py [--members N] [--seed N]    ten minutes of one core

Mechanical costs are of settled beats, electrical ones of the twin, which swims grids of gaits. Each robot swims its own
best gait at each speed. One of some members of data/twin/family.json swims too, in both water laws. docs/passive.md
has the answer.
"""

import argparse
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import budget
import family
import numpy as np
from passive_search import Best, Swum, best_of, cheapest, fastest, swim_passive, tuned, with_fin
from study import lines

import hypertuna as ht
from hypertuna.cli.console import progress_bar
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.io.files import version, write_atomically
from hypertuna.optimization.constraints import gait_limits
from hypertuna.paper.passive import LAWS, PLACES, PUMP, RELAXATION, ROOT, passive_robot
from hypertuna.paper.seeds import taken_hash
from hypertuna.simulation.run import TwinRun
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits

FILE = budget.FOLDER / "passive.json"
SPEEDS = (0.3, 0.4, 0.5)  # m/s, at which gaits with a passive joint II are compared
SLOPE = tuple(np.arange(0.15, 0.5, 0.05).round(2).tolist())  # m/s, at which the best stiffness is sought
MIDDLE = 0.3  # m/s, for which a fixed spring is chosen
# Passive hinges that are tried: relaxation time [s], link behind the hinge, model of joint I.
CASES: dict[str, tuple[float, int, str]] = {
    **{name: (RELAXATION, link, "bandwidth") for name, link in PLACES.items()},
    "root of the fin, no damping": (0.0, ROOT, "bandwidth"),
    "root of the fin, three times the damping": (3 * RELAXATION, ROOT, "bandwidth"),
    "root of the fin, joint I without lag": (RELAXATION, ROOT, "ideal"),
    "root of the fin, no damping, joint I without lag": (0.0, ROOT, "ideal"),
}
# Span and chord of fins, over the robot's
FINS = ((1.0, 1.0), (0.7, 1.0), (1.4, 1.0), (1.0, 0.7), (1.0, 1.4), (0.7, 1.4), (1.4, 0.7))
COARSE = tuple(np.geomspace(0.03, 6.0, 26).tolist())  # N m/rad, stiffnesses tried with each of these fins

# Gaits of the twin.
TWIN_FREQUENCY = tuple(np.geomspace(1.8, 6.0, 7).tolist())  # Hz
TWIN_STIFFNESS = {"lumped": (0.08, 1.2), "strip": (0.25, 3.0)}  # N m/rad, at the root of the fin
PHASES = (20.0, 50.0, 80.0)  # deg, lags of joint II where it is driven
FACTORS, ANGLES = (0.7, 1.0), (11.0, 16.0)  # amplitudes of both joints over 16 and 25 deg; of joint I alone [deg]
SPRINGS, SECONDS, THREADS = 6, 6.0, 1  # stiffnesses tried with the twin; duration of its runs [s]


def short(value: float) -> float:
    """Round a number to four digits."""
    return float(f"{value:.4g}")


def written(best: Best | None) -> dict[str, float] | None:
    """Return the cheapest gait's values for the stored file."""
    return None if best is None else {name: short(value) for name, value in vars(best).items()}


def active(robot: ht.Robot) -> dict[str, Any]:
    """Return the best settled gaits of the robot with both joints driven."""
    goals: dict[str, dict[str, Any]] = {
        f"{speed:g}": {"minimize": "cost_of_transport", "limits": gait_limits(robot, speed=speed)} for speed in SPEEDS
    }
    found: dict[str, Any] = {}
    for name, goal in (goals | {"max": {"maximize": "speed"}}).items():
        best = ht.optimize(robot, **goal)
        if best.gait is None:
            found[name] = None
            continue
        angles = {
            "frequency": best.gait.frequency,
            "amplitude_I": math.degrees(best.gait.amplitude[0]),
            "amplitude_II": math.degrees(best.gait.amplitude[1]),
            "phase_II": math.degrees(best.gait.phase[1]),
        }
        numbers = {"cost": best.cost_of_transport, "speed": best.speed} | angles
        found[name] = {key: short(value) for key, value in numbers.items()}
    return found


def bests(swum: Swum) -> dict[str, Any]:
    """Return the cheapest gaits at `SPEEDS`, and the fastest."""
    return {f"{speed:g}": written(best_of(swum, speed)) for speed in SPEEDS} | {"max": written(fastest(swum))}


def followed(swum: Swum) -> dict[str, Any]:
    """Return the best stiffness over speed, its exponent, and what a fixed spring costs over a tuned one."""
    found = {speed: one for speed in SLOPE if (one := tuned(swum, speed)) is not None}
    logs = np.log([[speed, one[1]] for speed, one in found.items()])
    fixed = int(np.argmin(abs(np.log(swum.rows) - math.log(found[MIDDLE][1]))))
    stays = Swum((swum.rows[fixed],), *vars_of(swum), swum.speed[[fixed]], swum.cost[[fixed]])
    over = {}
    for speed, one in found.items():
        best = best_of(stays, speed)
        over[f"{speed:g}"] = None if best is None else short(best.cost / one[0])
    names = ("cost", "stiffness", "low", "high")
    rows = {f"{speed:g}": dict(zip(names, map(short, one), strict=True)) for speed, one in found.items()}
    return {"exponent": short(float(np.polyfit(*logs.T, 1)[0])), "tuned": rows, "fixed_over_tuned": over}


def vars_of(swum: Swum) -> tuple[Sequence[float], Sequence[float]]:
    """Return the frequencies and amplitudes of gaits."""
    return swum.frequency, swum.size


def mechanical(robot: ht.Robot) -> dict[str, Any]:
    """Return the best settled gaits with each passive hinge, in the robot's water."""
    found: dict[str, Any] = {"active": active(robot)}
    for name, (relaxation, link, joints) in CASES.items():
        swum = swim_passive(robot.using(joints=joints), relaxation=relaxation, link=link)
        found[name] = bests(swum) | followed(swum)
        print(robot.model.water, name, found[name]["exponent"], flush=True)
    return found


def fins(robot: ht.Robot) -> list[dict[str, Any]]:
    """Return the best settled gaits with fins of other span and chord, with both joints and with the hinge."""
    rows = []
    for span, chord in FINS:
        other = with_fin(robot, span, chord)
        swum = swim_passive(other, stiffness=COARSE)
        kept = {key: one and {name: one[name] for name in ("cost", "speed")} for key, one in active(other).items()}
        rows.append({"span": span, "chord": chord, "active": kept, "passive": bests(swum)})
        print(robot.model.water, span, chord, flush=True)
    return rows


# --- the twin


def measured(run: TwinRun) -> tuple[float, float]:
    """Return speed [m/s] and electrical cost of transport [J/(kg m)]."""
    swims = run.status == "completed" and run.speed > 0.02
    return (run.speed, run.cost_of_transport) if swims else (math.nan, math.nan)


def swim_twin(robots: Sequence[ht.Robot], rows: Sequence[float], kind: str, seed: int) -> Swum:
    """Simulate the twin over robots, frequencies and amplitudes."""
    sizes = FACTORS if kind == "active" else ANGLES

    def gait(row: float, frequency: float, size: float) -> ht.Gait:
        if kind == "active":
            return ht.Gait.from_degrees(frequency=frequency, amplitude=(16 * size, 25 * size), phase=(0.0, row))
        return ht.Gait.from_degrees(frequency=frequency, amplitude=(size,), phase=(0.0,))

    base = {"duration": SECONDS, "start": "swimming", "seed": seed}
    runs = [
        base | {"robot": robot, "gait": gait(row, frequency, size)}
        for robot, row in zip(robots, rows, strict=True)
        for frequency in TWIN_FREQUENCY
        for size in sizes
    ]
    seen = np.array(ht.twins(runs, measure=measured, threads=THREADS)).reshape(len(rows), -1, len(sizes), 2)
    return Swum(rows, TWIN_FREQUENCY, sizes, seen[..., 0], seen[..., 1])


def electrical(robot: ht.Robot, *, seed: int = 0) -> dict[str, Any]:
    """Return the best gaits of the twin, with both joints and with the hinge; and the power of the two idle servos."""
    low, high = TWIN_STIFFNESS[robot.model.water]
    stiffness = tuple(np.geomspace(low, high, SPRINGS).tolist())
    both = swim_twin([robot] * len(PHASES), PHASES, "active", seed)
    hinged = swim_twin([passive_robot(robot, one) for one in stiffness], stiffness, "passive", seed)
    servo = next(servo for servo in robot.servos if servo.drives == PUMP)
    idle = (servo.count - servo.count // len(robot.joints)) * (servo.voltage or 0) * (servo.idle_current or 0)
    return {"idle_w": short(idle), "active": bests(both), "passive": bests(hinged), "one_spring": one_spring(hinged)}


def one_spring(swum: Swum) -> dict[str, float] | None:
    """Return the stiffness whose cost over tuned springs is least at its worst speed, among speeds that any reaches.

    None where no robot swims at any of the speeds.
    """
    least = [best.cost for speed in SPEEDS if (best := best_of(swum, speed)) is not None]
    if not least:
        return None
    rows = np.array([[math.nan if one is None else one.cost for one in cheapest(swum, speed)] for speed in SPEEDS])
    over = rows[: len(least)] / np.array(least)[:, None]  # (speeds, rows)
    worst = np.where(np.isnan(over).any(axis=0), np.inf, over.max(axis=0))
    k = int(worst.argmin())
    return {"stiffness": short(swum.rows[k]), "worst_over_tuned": short(float(worst[k])), "speeds": len(least)}


def of_family(robots: Mapping[int, ht.Robot], law: Any) -> dict[str, Any]:
    """Return the best gaits of members of the family."""
    found = {}
    with progress_bar(f"the family, {law}", slow=True) as progress:
        for done, (k, robot) in enumerate(robots.items(), 1):
            found[f"{k}"] = electrical(robot.using(water=law), seed=k)
            progress(done, len(robots))
    return found


# --- what others found


def platform() -> dict[str, float]:
    """Return the best a fish of 0.30 m with a spring at the peduncle does at 3 Hz and a swing of 0.2 lengths."""
    document = new_robot("platform", links=3, length=0.3, nose="streamlined")
    document["joints"] = document["joints"][:1]
    for name in ("gaits", "gait_bounds"):
        del document[name], document["sources"][name]
    angles = np.radians(np.linspace(2, 30, 29))
    gaits = Gaits.grid(frequency=[3.0], amplitude=[(one,) for one in angles], phase=[(0.0,)])
    best = {"speed_bl_s": 0.0}
    for stiffness in np.geomspace(0.005, 1.0, 40):
        spring = {"stiffness_n_m_per_rad": stiffness, "damping_n_m_s_per_rad": RELAXATION * stiffness}
        beat = settle(parse(document | {"hinge": {"link": 2} | spring}), gaits)
        k = int(np.argmin(abs(beat["tail_excursion"] / 0.06 - 1)))
        near = beat["status"][k] == 0 and abs(beat["tail_excursion"][k] / 0.06 - 1) < 0.1
        if near and beat["speed"][k] / 0.3 > best["speed_bl_s"]:
            numbers = {"speed_bl_s": beat["speed"][k] / 0.3, "strouhal": beat["strouhal"][k]}
            numbers |= {"stiffness": float(stiffness), "stiffness_ratio": beat["stiffness_ratio"][k]}
            best = numbers | {"lag_deg": math.degrees(beat["bend_lag"][k])}
    return {name: short(float(value)) for name, value in best.items()}


def trends(robot: ht.Robot) -> dict[str, float]:
    """Return trends over frequency and stiffness with a hinge at the fin's root, at 16 deg of joint I, in one water."""
    stiffness = np.geomspace(0.01, 20.0, 300)
    hertz = np.array([1.5, 2.0, 3.0, 4.0])
    gaits = Gaits.grid(frequency=hertz.tolist(), amplitude=[(math.radians(16.0),)], phase=[(0.0,)])
    beats = [settle(passive_robot(robot.using(joints="ideal"), one, relaxation=0.0), gaits) for one in stiffness]
    names = ("speed", "cost_of_transport", "efficiency", "bend_lag", "stiffness_ratio")
    every = {name: np.array([beat[name] for beat in beats]) for name in names}
    best, fast = every["efficiency"].argmax(axis=0), every["speed"].argmax(axis=0)
    at = np.arange(len(hertz))
    slope = np.polyfit(np.log(hertz), np.log(stiffness[best]), 1)[0]
    speed, cost = every["speed"][best, at], every["cost_of_transport"][best, at]
    numbers = {
        "fastest_ratio": every["stiffness_ratio"][fast[1], 1],
        "efficient_ratio": every["stiffness_ratio"][best[1], 1],
        "softer_over_fastest": np.interp(stiffness[fast[1]] / 2, stiffness, every["speed"][:, 1])
        / every["speed"][fast[1], 1],
        "stiff_over_fastest": every["speed"][-1, 1] / every["speed"][fast[1], 1],
        "stiffness_over_frequency": slope,
        "speed_twice_the_frequency": speed[3] / speed[1],
        "cost_twice_the_frequency": cost[3] / cost[1],
        "lag_deg": math.degrees(every["bend_lag"][best[1], 1]),
    }
    return {name: short(float(value)) for name, value in numbers.items()}


def main() -> None:
    """Compute all cases, and store them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--members", type=int, default=16)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    robot = ht.load("hypertuna")
    stored = json.loads(family.FILE.read_text(encoding="utf-8"))
    record: dict[str, Any] = {"hypertuna_version": version(), "taken_hash": taken_hash(robot)}
    record |= {"family_hash": budget.family_hash(), "family_version": stored["hypertuna_version"]}
    record |= {"command": "python validation/twin/passive.py", **vars(asked), "platform": platform()}
    record["mass_kg"] = robot.body.mass
    laws = {law: robot.using(water=law) for law in LAWS}
    record["trends"] = {law: trends(one) for law, one in laws.items()}
    record["mechanical"] = {law: mechanical(one) for law, one in laws.items()}
    record["fins"] = {law: fins(one) for law, one in laws.items()}
    record["electrical"] = {law: electrical(one, seed=asked.seed) for law, one in laws.items()}
    every = budget.members()
    places = np.linspace(0, len(every) - 1, asked.members).round().astype(int).tolist()
    record["family"] = {law: of_family({k: every[k] for k in places}, law) for law in LAWS}
    write_atomically(FILE, lines(record))


if __name__ == "__main__":
    main()
