"""Tables and picture of docs/joint.md, from results stored in data/twin; docs/figures.py includes them."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from figures_common import FISH, paper_value, rows
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from hypertuna.characterization.problem import held_at
from hypertuna.figures import COLORS, EDGE, INK, SHAPES, TIGHT, WIDTH, styled
from hypertuna.paper.computed import SPEEDS

ROOT = Path(__file__).parents[1]
MOMENT, LEVER = "blocked moment of joint I", "lever[I]"
POWERS = {"power, unoptimised-max": "power/fastest", "power, optimised-0.5": "power/lake"}
AXES = (2.4, 13, 45, 100, 210)  # N, bounds of the groups of members; the sensor's film alone reaches 13 N
FILLS = (0, 60, 120, 180, 251)  # kPa, bounds of the groups of members


@cache
def stored(name: str) -> dict[str, Any]:
    """Return a stored result of data/twin, by the name of its file."""
    content: dict[str, Any] = json.loads((ROOT / f"data/twin/{name}.json").read_text(encoding="utf-8"))
    return content


def members() -> list[dict[str, float]]:
    """Return the quantities of each member of the family, by name."""
    return [one["values"] for one in stored("family")["members"]]


def number(value: float) -> str:
    """Write a number to three digits, without an exponent."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def force(moment: float) -> float:
    """Return the force [N] that holds joint I at the arm of the measurement, from its blocked moment [N m]."""
    arm: float = stored("posterior")["arm_m"]
    return held_at(moment, FISH.joints[0].actuator.length, arm) / arm


def span(ends: Sequence[float]) -> str:
    """Write median and 90 % interval."""
    low, middle, high = map(number, ends)
    return f"{middle} ({low} to {high})"


def percentiles(values: Iterable[float], factor: float = 1.0) -> str:
    """Write median and 90 % interval of the members."""
    return span(np.percentile(factor * np.array(list(values)), (5, 50, 95), method="inverted_cdf").tolist())


def fact_table() -> str:
    """Tabulate the facts: where each is published, how it enters, and what it excludes."""
    found, known = stored("family"), members()
    drawn, judged = (Counter(one["excluded"] for one in found[key]) for key in ("drawn", "candidates"))
    no_room = sum(count for why, count in drawn.items() if "room" in why)

    def part(count: int, of: Counter[str], name: str) -> str:
        return f"{100 * count / of.total():.0f} % of the {name}"

    suction = f"weighs; {100 * sum(one['lowest'] < 0 for one in known) / len(known):.0f} % of the members fall below 0"
    body = [
        ["hoses, lines and walls of silicone fit into the sections", "Table II", part(no_room, drawn, "draws")],
        ["bends of 18.2 and 31.2 deg at 250 kPa, ± 3 %, friction included", "III.A", "all but a thin sheet of designs"],
        ["from 100 to 250 kPa on a straight line: R² of 0.96 and more, ± 0.01", "III.A", "weighs"],
        ["the pumps have the stroke", "II.B", part(judged["stroke of the pump"], judged, "candidates")],
        [
            "the servos have the torque for the working limit",
            "Table I",
            part(judged["torque of the servos"], judged, "candidates"),
        ],
        [
            "20 deg of joint II within 4 s, at 1 to 6 Hz in air",
            "III.C, Fig. 8",
            part(judged["Fig. 8"], judged, "candidates"),
        ],
        ["at least 12, 16 and 20 W at 2, 3 and 5 Hz, ± 10 %", "III.D", "weighs"],
        ["no negative pressure: 50 kPa below 0 count as one deviation", "II.B", suction],
    ]
    return rows(["fact", "section", "excludes"], body, left=3)


def ranges() -> dict[str, tuple[str, float, str, str]]:
    """Return the quantities that are drawn: name in the page, factor, range and reason, by name in family.json."""
    return {
        "lever[I]": ("lever, joint I [mm]", 1e3, "3.5 to 22", "from the middle to the skin of the narrowest section"),
        "lever[II]": ("lever, joint II [mm]", 1e3, "3.5 to 14", "the same"),
        "outer_diameter": (
            "hose, outside [mm]",
            1e3,
            "2.5 to 8",
            "the thinnest that is cast by hand; the widest that fits",
        ),
        "diameter_ratio": ("hose, inside over outside", 1.0, "0.5 to 0.8", "walls of 10 to 25 % of the diameter"),
        "braid_angle": ("braid [deg]", math.degrees(1), "25 to 45", "braided sleeves at rest"),
        "friction": ("friction of the braid", 1.0, "0.03 to 0.3", "McKibben muscles lose 3 to 30 % of their force"),
        "axis_buckling[I]": (
            "axis of joint I buckles at [N]",
            1.0,
            "2.4 to 210",
            "film of the bend sensor; two plastic oil pipes",
        ),
        "axis_buckling[II]": (
            "axis of joint II buckles at [N]",
            1.0,
            "2.4 to 13",
            "film of the bend sensor; no pipe passes it",
        ),
        "controller.pressure_work_pa": ("working limit [kPa]", 1e-3, "200 to 600", "III.D names a limit, and no value"),
        "joints.line.fill_pressure_pa": (
            "fill pressure [kPa]",
            1e-3,
            "0 to 250",
            "up to the largest pressure on the bench",
        ),
        "joints.line.bore_m": ("bore of the lines [mm]", 1e3, "3 to 6", "common hoses that pass joint I"),
        "oil.air": ("air in the oil [%]", 1e2, "0.5 to 5", "working hydraulics; filled by hand"),
        "oil.temperature_c": ("oil [°C]", 1.0, "10 to 30", "a tank, a lake"),
        "pump.bore_m": ("bore of the pump [mm]", 1e3, "10 to 24", "four cylinders that the head has room for"),
        "pump.seal_friction_n": ("friction of a seal [N]", 1.0, "3 to 30", "handbook laws of O-rings"),
        "servos.piston pump.torque_n_m": ("torque of a servo [N m]", 1.0, "5.8 to 7.9", "Table I, ± 15 %"),
        "servos.piston pump.speed_rad_s": (
            "speed of a servo [rad/s]",
            1.0,
            "6.7 to 8.3",
            "data sheets: 0.13 to 0.16 s for 60 deg",
        ),
        "servos.piston pump.bandwidth_hz": ("bandwidth of a servo [Hz]", 1.0, "5 to 20", "from cheap to good ones"),
        "servos.piston pump.inertia_kg_m2": (
            "inertia of a servo [kg cm²]",
            1e4,
            "32 to 135",
            "coreless motors to iron cores",
        ),
        "servos.piston pump.friction_n_m": (
            "friction of a servo [N m]",
            1.0,
            "0.15 to 0.6",
            "0.15 to 0.6 A without load",
        ),
        "servos.piston pump.stall_current_a": ("stall current of a servo [A]", 1.0, "5 to 9", "data sheets"),
        "servos.piston pump.idle_current_a": (
            "idle current of a servo [A]",
            1.0,
            "0.01 to 0.4",
            "data sheets, and what the powers ask for",
        ),
    }


def member_table() -> str:
    """Tabulate the drawn quantities: their range, its reason, and their values in the family."""
    body = []
    for key, (name, factor, drawn, reason) in ranges().items():
        body.append([name, drawn, percentiles((one[key] for one in members()), factor), reason])
    return rows(["quantity", "drawn from", "family", "because"], body, left=1)


def fill_table() -> str:
    """Tabulate the lowest pressure and the power over the fill pressure."""
    body, known = [], members()
    fills = np.array([one["joints.line.fill_pressure_pa"] for one in known]) / 1e3
    for low, high in pairwise(FILLS):
        group = [one for one, fill in zip(known, fills, strict=True) if low <= fill < high]
        lowest = [one["lowest"] / 1e3 for one in group]
        powers = (
            [np.median([one[f"power, unoptimised-{u}"] for one in group]) for u in ("0.3", "0.4", "0.5")]
            if group
            else []
        )
        cells = [percentiles(lowest) if group else "", str(sum(p >= 0 for p in lowest)), ", ".join(map(number, powers))]
        body.append([f"{low} to {min(high, 250)} kPa", str(len(group)), *cells])
    heads = ["filled to", "members", "lowest pressure [kPa]", "without suction", "power at 2, 3, 5 Hz [W]"]
    return rows(heads, body)


def after_table() -> str:
    """Tabulate the quantities before and after the four speeds are used."""
    laws = [stored("posterior")[law]["before_and_after"] for law in ("lumped", "strips")]
    body = [
        [name, span(before), *(span(law[name][1]) for law in laws)]
        for name, (before, _) in laws[0].items()
        if not name.startswith(("speed", "power"))
    ]
    return rows(["quantity", "family", "after four speeds, lumped", "strips"], body)


def judged_table() -> str:
    """Tabulate speeds and powers before and after the four speeds are used."""
    laws = [stored("posterior")[law]["before_and_after"] for law in ("lumped", "strips")]
    published = {f"speed, {name}": paper_value(f"speed/{name}") for name in SPEEDS} | {
        n: paper_value(key) for n, key in POWERS.items()
    }
    body = []
    for k, (name, value) in enumerate(published.items()):
        cells = [span(part) for law in laws for part in law[name]]
        body.append([name, "in" if k < 4 else "judged", number(value), *cells])
    heads = ["lumped: family", "after", "strips: family", "after"]
    return rows(["number [m/s, W]", "", "published", *heads], body, left=2)


def robot_table() -> str:
    """Tabulate the default robot and the best ones of the search."""
    found = stored("posterior")["robots"]
    powers = [SPEEDS.index(name.removeprefix("power, ")) for name in POWERS]
    lines: dict[str, Callable[[dict[str, Any]], str]] = {
        **{f"{name} [m/s]": (lambda one, k=k: f"{one['speed_m_s'][k]:.3f}") for k, name in enumerate(SPEEDS)},
        "rms, four that fit": lambda one: f"{one['rms_in_percent']:.1f} %",
        "rms, four that judge": lambda one: f"{one['rms_out_percent']:.1f} %",
        **{
            f"{name} [W]": (lambda one, k=k: f"{one['power_w'][k]:.1f}") for name, k in zip(POWERS, powers, strict=True)
        },
        "blocked moment of joint I [N m]": lambda one: number(one["statics"][MOMENT]),
        "compression of the axes, I / II [N]": lambda one: " / ".join(number(n) for n in one["axis_n"].values()),
    }
    published = (
        [f"{paper_value(f'speed/{name}'):g}" for name in SPEEDS]
        + ["", ""]
        + [f"{paper_value(p):.1f}" for p in POWERS.values()]
    )
    body = [
        [name, value, *(line(one) for one in found.values())]
        for (name, line), value in zip(lines.items(), [*published, "", ""], strict=True)
    ]
    return rows(["", "published", *found], body)


def bench_table() -> str:
    """Tabulate the expected results of two cheap measurements."""
    found, shrinks = stored("posterior"), "shortening of joint I"
    shown = {
        f"force at {found['arm_m']:g} m [N]": (f"{MOMENT} [N m]", force, lambda one: force(one[MOMENT])),
        f"{shrinks} [mm]": (f"{shrinks} [mm]", lambda x: x, lambda one: 1e3 * one[shrinks]),
    }
    body = []
    for what, (key, of_stored, of_robot) in shown.items():
        pair = [span([of_stored(x) for x in part]) for part in found["lumped"]["before_and_after"][key]]
        body.append([what, *pair, *(number(of_robot(one["statics"])) for one in found["robots"].values())])
    return rows(["both at 250 kPa", "family", "after four speeds", *found["robots"]], body)


def axis_table() -> str:
    """Tabulate the expected results of both measurements, over the buckling load of the axis of joint I."""
    body, known = [], members()
    for low, high in pairwise(AXES):
        group = [one for one in known if low <= one["axis_buckling[I]"] < high]
        shown = [percentiles((one["shortening of joint I"] for one in group), 1e3)]
        shown.append(percentiles(force(one[MOMENT]) for one in group))
        body.append([f"{low:g} to {high:g} N", str(len(group)), *shown])
    return rows(["axis of joint I buckles at", "members", "shortening [mm]", "force [N]"], body)


# --- picture


def ticks(axes: Axes, axis: str, values: Sequence[float]) -> None:
    """Set a logarithmic axis whose ticks are plain numbers."""
    getattr(axes, f"set_{axis}scale")("log")
    getattr(axes, f"set_{axis}ticks")(values, [f"{value:g}" for value in values])
    getattr(axes, f"{axis}axis").set_minor_formatter(NullFormatter())


def draw_family(axes: Axes) -> None:
    """Plot the blocked moment of joint I over its lever, colored by what excludes a candidate."""
    candidates = [one for one in stored("family")["candidates"] if MOMENT in one]
    texts = {
        "Fig. 8": "Fig. 8 excludes (every second)",
        "torque of the servos": "torque of the servos excludes",
        "": "meets all facts",
    }
    for (why, text), color in zip(texts.items(), (0, 4, 2), strict=True):
        own = [(1e3 * one[LEVER], one[MOMENT]) for one in candidates if one["excluded"] == why]
        own = own[::2] if why == "Fig. 8" else own
        style = {"color": COLORS[color], "ms": 2.2, "mew": 0, "alpha": 0.6, "label": text}
        axes.plot(*zip(*own, strict=True), SHAPES[color], **style)
    own = [(1e3 * one[LEVER], one[MOMENT]) for one in members()]
    axes.plot(*zip(*own, strict=True), "o", mfc="none", mec=COLORS[1], ms=4.5, mew=0.9, label="member of the family")
    for (name, one), shape in zip(stored("posterior")["robots"].items(), "*PX", strict=True):
        lever = one["changes"].get("joints.I.actuator.lever_m", FISH.joints[0].actuator.lever)
        style = {"color": INK, "ms": 10 if shape == "*" else 7, "mec": "white", "label": name}
        axes.plot(1e3 * lever, one["statics"][MOMENT], shape, **style)
    ticks(axes, "y", (0.3, 0.5, 1, 2))
    axes.set(xlabel="lever of joint I [mm]", ylabel="blocked moment at 250 kPa [N m]", ylim=(0.22, 5))
    axes.set_title("What the facts leave of joint I")
    axes.legend(loc="upper left", ncols=2, fontsize=7.5, **TIGHT)


def draw_scale(axes: Axes) -> None:
    """Plot the force that a luggage scale would show: of the family, and after four speeds."""
    found, arm = stored("posterior"), stored("posterior")["arm_m"]
    shown = np.array([force(one[MOMENT]) for one in members()])
    bins = np.geomspace(0.95 * shown.min(), 1.05 * shown.max(), 14)
    axes.hist(shown, bins=bins, color=EDGE, label="family")
    weight = len(shown) * np.array(found["lumped"]["weights"])
    style = {"histtype": "step", "color": COLORS[0], "lw": 1.6, "label": "after four speeds"}
    axes.hist(shown, bins=bins, weights=weight, **style)
    for one, shape in zip(found["robots"].values(), "*PX", strict=True):
        axes.plot(force(one["statics"][MOMENT]), 1.5, shape, color=INK, ms=10 if shape == "*" else 7, mec="white")
    ticks(axes, "x", (5, 10, 20))
    axes.set(xlabel=f"force at {arm:g} m [N]", ylabel="members")
    axes.set_title("On a luggage scale")
    axes.set_ylim(0, 1.35 * axes.get_ylim()[1])
    axes.legend(loc="upper right")


@styled
def plot_joint() -> Figure:
    """Plot the family, and the measurement that would decide between its members."""
    figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.6, 1))
    draw_family(left)
    draw_scale(right)
    return figure


TABLES: dict[str, Callable[[], str]] = {
    "joint facts": fact_table,
    "joint members": member_table,
    "joint fills": fill_table,
    "joint afterwards": after_table,
    "joint judged": judged_table,
    "joint robots": robot_table,
    "joint bench": bench_table,
    "joint axes": axis_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/joint.svg": plot_joint}
