"""The paper's future work: joint II as a passive hinge of tuned stiffness, and other fins; compared with literature.

validation/twin/passive.py stores the searches; the settled beats of the best gaits are swum again here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.io.files import published
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.chapters.budget import read_stored
from hypertuna.paper.computed import COSTS, OURS
from hypertuna.paper.passive import KINDS, LAWS, PLACE, PLACES, passive_robot
from hypertuna.reports.html import Section, Shown, Table
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.swim import swim

SAME = 0.02  # largest relative difference of recomputed speeds and costs: the search interpolated on a grid of gaits
SURE = 1.0  # %: the grid of gaits does not determine the sign of a smaller change
FIN_KEYS = ("active", "0.3"), ("passive", "0.3"), ("passive", "max")  # columns of the table of fins: joint II, speed


@dataclass(frozen=True)
class PassiveJoints:
    """The stored results of robots with a passive joint, or why there are no valid ones."""

    robot: Robot
    record: Mapping[str, Any] = field(default_factory=dict)  # empty where there is no valid one
    reason: str = ""  # why there is none; without a full stop
    gap: float = math.nan  # largest relative difference between the stored results and those recomputed now


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> PassiveJoints:
    """Read the stored results, and swim their best settled gaits again."""
    return read_passive(trials[OURS].robot)


def read_passive(robot: Robot) -> PassiveJoints:
    """Read the stored results, and swim their best settled gaits again."""
    record, reason = read_stored("passive", robot)
    if reason:
        return PassiveJoints(robot, reason=reason)
    gap = max(gaps(robot, record))
    if gap > SAME:
        reason = f"stale: its gaits swim up to {100 * gap:.1f} % differently now; validation/twin/passive.py"
    return PassiveJoints(robot, {} if reason else record, reason, gap)


def gaps(robot: Robot, record: Mapping[str, Any]) -> Iterator[float]:
    """Yield relative differences of speeds and costs between the stored settled gaits and those swum now."""
    for law in LAWS:
        water = robot.using(water=law)
        for kind, best in record["mechanical"][law].items():
            if kind not in ("active", PLACE):
                continue
            for stored in (best[name] for name in (*COSTS, "max") if best[name]):
                swum = swim(*_robot_and_gait(water, kind, stored))
                yield abs(swum.speed / stored["speed"] - 1)
                yield abs(swum.cost_of_transport / stored["cost"] - 1)


def _robot_and_gait(robot: Robot, kind: str, stored: Mapping[str, float]) -> tuple[Robot, Gait]:
    """Return the robot, active or passive, and the gait that a stored result is of."""
    if kind == "active":
        amplitude = stored["amplitude_I"], stored["amplitude_II"]
        phase = 0.0, stored["phase_II"]
        return robot, Gait.from_degrees(frequency=stored["frequency"], amplitude=amplitude, phase=phase)
    gait = Gait.from_degrees(frequency=stored["frequency"], amplitude=(stored["size"],), phase=(0.0,))
    return passive_robot(robot, stored["row"], link=PLACES[kind]), gait


# --- the answer


def change(pair: Mapping[str, Any], name: str) -> float:
    """Return the passive joint's change of the cost at a speed, or of the largest speed [%]; NaN if not reached."""
    active, passive = (pair[kind][name] for kind in KINDS)
    if not (active and passive):
        return math.nan
    key = "speed" if name == "max" else "cost"
    return float(100 * (passive[key] / active[key] - 1))


def changes(record: Mapping[str, Any], law: str, name: str) -> list[float]:
    """Return the passive joint's change [%] for each member of the family that reaches the speed with both joints."""
    relative = (change(member, name) for member in record["family"][law].values())
    return [x for x in relative if not math.isnan(x)]


def band(values: list[float]) -> tuple[float, float, float]:
    """Return the 5th, 50th and 95th percentile of values."""
    low, middle, high = np.percentile(values, (5, 50, 95)).tolist()
    return low, middle, high


def verdict(record: Mapping[str, Any], name: str) -> str:
    """Return which joint is better at a speed, if the family's bands agree on it in both waters."""
    by_law = [changes(record, law, name) for law in LAWS]
    if not all(by_law):
        return "not decided" if any(by_law) else "not reached"
    bands = [band(values) for values in by_law]
    low, high = min(values[0] for values in bands), max(values[2] for values in bands)
    higher, lower = ("faster", "slower") if name == "max" else ("dearer", "cheaper")
    return f"passive is {higher}" if low > 0 else f"passive is {lower}" if high < 0 else "not decided"


def answer_table(record: Mapping[str, Any]) -> Table:
    """Tabulate electrical costs at each speed, and largest speeds, with active joint and with hinge."""
    rows = []
    for name, law, label in _cases():
        rows.append([_speed_words(name), label, *_pair(record["electrical"][law], name), _members(record, law, name)])
        rows[-1].append(verdict(record, name))
    return Table(["speed", "water", "active", "passive", "change [%]", "family: change [%], members", "verdict"], rows)


def parts_table(record: Mapping[str, Any]) -> Table:
    """Tabulate the best spring at each speed, the part of idle pumps in the change, and mechanical costs."""
    rows = []
    for name, law, label in _cases():
        pair = record["electrical"][law]
        settled = {"active": record["mechanical"][law]["active"], "passive": record["mechanical"][law][PLACE]}
        spring = f"{best['row']:.2f}" if (best := pair["passive"][name]) else ""
        rows.append([_speed_words(name), label, spring, _idle(record, pair, name), *_pair(settled, name)])
    header = ["spring [N m/rad]", "idle pumps [%]", "active, mechanical", "passive, mechanical", "change [%]"]
    return Table(["speed", "water", *header], rows)


def _cases() -> Iterator[tuple[str, str, str]]:
    """Yield the name of a speed, a water law and the law's label, for each pair of speed and law."""
    yield from ((name, law, label) for name in (*COSTS, "max") for law, label in LAWS.items())


def _speed_words(name: str) -> str:
    """Return the words for a speed: "full speed", or its number with the unit."""
    return "full speed" if name == "max" else f"{name} m/s"


def _members(record: Mapping[str, Any], law: str, name: str) -> str:
    """Write the change over the family [%], the number of members that reach the speed, and of those that then fail."""
    values, family = changes(record, law, name), record["family"][law].values()
    if not values:
        return ""
    low, middle, high = band(values)
    failed = sum(bool(member["active"][name] and not member["passive"][name]) for member in family)
    return f"{middle:+.0f} ({low:+.0f} to {high:+.0f}), {len(values)}" + f"; {failed} fail" * bool(failed)


def _idle(record: Mapping[str, Any], pair: Mapping[str, Any], name: str) -> str:
    """Write the change of a cost that follows from the idle power of the removed pumps alone [%]."""
    best = pair["active"][name]
    if name == "max" or not best:
        return ""
    return f"{-100 * pair['idle_w'] / (record['mass_kg'] * best['speed'] * best['cost']):+.0f}"


def _pair(pair: Mapping[str, Any], name: str) -> list[str]:
    """Write both costs [J/(kg m)] or both largest speeds [m/s] of a pair of robots, and the change [%]."""
    key, unit, form = ("speed", " m/s", ".3f") if name == "max" else ("cost", "", ".3g")
    cells = [f"{pair[kind][name][key]:{form}}{unit}" if pair[kind][name] else "not reached" for kind in KINDS]
    changed = change(pair, name)
    return [*cells, "" if math.isnan(changed) else f"{changed:+.0f}"]


def spring_table(record: Mapping[str, Any]) -> Table:
    """Tabulate the one spring that is best for all speeds: the default robot's, and its range over the family."""
    rows = []
    for law, label in LAWS.items():
        default = record["electrical"][law]["one_spring"]
        members = [spring for member in record["family"][law].values() if (spring := member["one_spring"])]
        low, middle, high = band([spring["stiffness"] for spring in members])
        worst = band([100 * (spring["worst_over_tuned"] - 1) for spring in members])
        cells = [f"{default['stiffness']:.2f}", f"{100 * (default['worst_over_tuned'] - 1):.1f}"]
        rows.append([label, *cells, f"{middle:.2f} ({low:.2f} to {high:.2f})", f"{worst[1]:.1f}, up to {worst[2]:.1f}"])
    header = ["spring [N m/rad]", "over a tuned one at its worst speed [%]", "springs of the family", "over tuned [%]"]
    return Table(["water", *header], rows)


def stiffness_table(record: Mapping[str, Any]) -> Table:
    """Tabulate the best stiffness at each speed, and the power of the speed by which it grows."""
    rows = []
    for law, label in LAWS.items():
        for name, case in record["mechanical"][law].items():
            if name == "active":
                continue
            springs = [_spring(case["tuned"].get(speed)) for speed in ("0.2", "0.3", "0.4")]
            rows.append([name, label, f"{case['0.3']['cost']:.3f}", f"{case['exponent']:.2f}", *springs])
    header = [f"spring at {speed} m/s" for speed in ("0.2", "0.3", "0.4")]
    return Table(["hinge", "water", "cost at 0.3 m/s", "power of the speed", *header], rows)


def _spring(spring: Mapping[str, float] | None) -> str:
    """Write a best stiffness and its range [N m/rad]."""
    return "" if spring is None else f"{spring['stiffness']:.3f}, {spring['low']:.3f} to {spring['high']:.3f}"


def fin_table(record: Mapping[str, Any]) -> Table:
    """Tabulate changes of mechanical cost and largest speed by other fins [%]."""
    unchanged = {law: next(fin for fin in record["fins"][law] if fin["span"] == fin["chord"] == 1) for law in LAWS}
    rows = []
    for k, fin in enumerate(record["fins"]["strip"]):
        span, chord = fin["span"], fin["chord"]
        if span == chord == 1:
            continue
        relative = {
            law: [_relative_change(record["fins"][law][k], unchanged[law], *what) for what in FIN_KEYS] for law in LAWS
        }
        costs = [numbers[1] for numbers in relative.values()]
        judgment = "cheaper" if max(costs) < -SURE else "dearer" if min(costs) > SURE else "not decided"
        texts = [[f"{x:+z.0f}" if math.isfinite(x) else "not reached" for x in row] for row in relative.values()]
        cells = [cell for active, passive, fast in texts for cell in (f"{active}, {passive}", fast)]
        rows.append([f"{span:g}", f"{chord:g}", f"{span * chord:.2g}", f"{span / chord:.2g}", *cells, judgment])
    header = [f"{label}: {what}" for label in LAWS.values() for what in ("cost", "full speed")]
    return Table(["span", "chord", "area", "aspect ratio", *header, "cost with the spring"], rows)


def _relative_change(fin: Mapping[str, Any], unchanged: Mapping[str, Any], kind: str, name: str) -> float:
    """Return the change of a cost or of the largest speed from the unchanged fin [%]; infinite where not reached."""
    key, (new, old) = "speed" if name == "max" else "cost", (one[kind][name] for one in (fin, unchanged))
    return float(100 * (new[key] / old[key] - 1)) if new and old else math.inf


# --- what others found


def claim_table(record: Mapping[str, Any]) -> Table:
    """Tabulate claims of the literature with our numbers beside them."""
    ours = {name: _our_number(record, name) for name in [claim["id"] for claim in published("springs")["claims"]]}
    rows = [
        [claim["claim"], f"{claim['source']} ({claim['read']})", *ours[claim["id"]]]
        for claim in published("springs")["claims"]
    ]
    rows += [[one["what"], "", f"not read: {one['why']}", ""] for one in published("springs")["unread"]]
    return Table(["claim", "source", "here: lumped / strips", "agrees in sign"], rows)


def _our_number(record: Mapping[str, Any], name: str) -> tuple[str, str]:
    """Return our number beside a claim as text, and "yes", "no" or "not decided": whether its sign agrees."""
    if name == "one-length-a-second":
        fish = record["platform"]
        text = f"{fish['speed_bl_s']:.2f} lengths a second at 3 Hz, Strouhal number {fish['strouhal']:.2f}"
        return text, "yes" if fish["speed_bl_s"] > 1 else "no"
    texts, agree = zip(*(_of_law(record, law, name) for law in LAWS), strict=True)
    answer = {(True,): "yes", (False,): "no"}.get(tuple(set(agree)), "not decided")
    return " / ".join(texts), answer


def _of_law(record: Mapping[str, Any], law: str, name: str) -> tuple[str, bool | None]:
    """Return our number in one water as text, and whether its sign is the claim's; None where that is not decided."""
    trend, case = record["trends"][law], record["mechanical"][law][PLACE]
    fixed, tuned = case["fixed_over_tuned"], [case_at["stiffness"] for case_at in case["tuned"].values()]
    slow, missed = next(iter(fixed)), next((speed for speed, case_at in fixed.items() if case_at is None), None)
    softer, rigid = trend["softer_over_fastest"], trend["stiff_over_fastest"]
    speed, cost = trend["speed_twice_the_frequency"], trend["cost_twice_the_frequency"]
    lag = trend["lag_deg"]
    answers: dict[str, tuple[str, bool | None]] = {
        "speed-squared": (f"power {case['exponent']:.2f}", case["exponent"] > 0),
        "up-to-twice": (f"mechanical, {fixed[slow]:.2f} times at {slow} m/s", 1 < fixed[slow] < 2.2),
        "saves-more-fast": (f"does not reach {missed} m/s", None if missed else fixed[max(fixed)] > fixed[slow]),
        "no-one-stiffness": (f"{tuned[0]:.2f} to {tuned[-1]:.2f} N m/rad", tuned[-1] > tuned[0]),
        "stiffer-faster": (
            f"{softer:.2f} of the largest speed at half its stiffness, {rigid:.2f} if rigid",
            None if softer < 1 and rigid < 1 else softer < rigid,
        ),
        "frequency-faster": (f"{speed:.2f} times at twice the frequency", speed > 1),
        "speed-against-economy": (f"{cost:.1f} times the cost at twice the frequency", speed > 1 and cost > 1),
        "best-stiffness": (f"{trend['efficient_ratio']:.1f} times that of resonance", softer < 1 and rigid < 1),
        "travelling-wave": (f"the tail lags by {lag:.0f} deg", 45 < lag < 135),
    }
    return answers[name]


def sections(passive: PassiveJoints) -> list[Section]:
    """Show the tables of costs, springs, fins and claims."""
    if not passive.record:
        return compose("passive", {}, record={}, reason=passive.reason, gap=0.0, verdicts={})
    from hypertuna.paper.figures import plot_passive

    record = passive.record
    shown: dict[str, Shown] = {
        "passive": plot_passive(record),
        "passive-answer": answer_table(record),
        "passive-parts": parts_table(record),
        "passive-spring": spring_table(record),
        "passive-stiffness": stiffness_table(record),
        "passive-fins": fin_table(record),
        "passive-claims": claim_table(record),
    }
    facts = {
        "reason": "",
        "gap": passive.gap,
        "verdicts": {name: verdict(record, name) for name in (*COSTS, "max")},
    }
    return compose("passive", shown, record=record, **facts)


CHAPTER = Chapter("passive", sections, compute=compute)
