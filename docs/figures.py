"""Keep the documentation true: every table, console output and picture in it is made here, by the program itself.

`python docs/figures.py` brings README.md and docs/*.md up to date. Made anew are what stands between
``<!-- table: NAME -->`` and ``<!-- end -->``, the output below every ``$ hypertuna ...`` of a console block, and the
pictures. tests/test_docs.py fails where they differ from what is committed.
"""

from __future__ import annotations

import contextlib
import io
import math
import os
import re
import runpy
import shlex
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.special import ellipe

from hypertuna.beats import QUANTITIES
from hypertuna.cli import main
from hypertuna.description import load, parse
from hypertuna.dive import dive
from hypertuna.drawing import BODY, COLORS, EDGE, INK, draw, save
from hypertuna.gait import named_gait
from hypertuna.ledger import published
from hypertuna.limits import gait_limits
from hypertuna.manifest import reference as manifest_keys
from hypertuna.objective import OBJECTIVES
from hypertuna.optimize import METHODS, Optimum, optimize
from hypertuna.pareto import Front, pareto
from hypertuna.plots import plot_swim
from hypertuna.plots_dive import plot_dive
from hypertuna.plots_optimize import plot_convergence
from hypertuna.plots_pareto import plot_pareto
from hypertuna.plots_pump import plot_pump
from hypertuna.published_swims import SPEEDS, Trial, swim_published
from hypertuna.published_twins import swim_bores
from hypertuna.report import Table
from hypertuna.reproduce import Ledger, reproduce
from hypertuna.reproduce_fit import bandwidth_table, coefficient_table
from hypertuna.reproduce_optima import gait_table, method_table
from hypertuna.reproduce_others import computed_among, robot_table
from hypertuna.reproduce_twin import bore_table, speed_table, tank_table
from hypertuna.results_page import posture_table
from hypertuna.sizing import Size, largest_beat, size_pump
from hypertuna.steady import COLUMNS
from hypertuna.swim import Swim, swim
from hypertuna.twin import twin

ROOT = Path(__file__).resolve().parents[1]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))

PAPER = published()
MODELS = ("ideal joints", "joint bandwidth", "ideal joints, areas as printed", "joint bandwidth, areas as printed")
FISH = load("hypertuna")


@cache
def trials() -> dict[str, Trial]:
    """Swim everything that the paper reports, under every reading of its model."""
    return swim_published(FISH, PAPER, full=True)


@cache
def ledger() -> Ledger:
    """Compute the paper's numbers."""
    return reproduce()


def swum(gait: str, model: str) -> Swim:
    """Return how a gait of HyperTuna's file swims."""
    return trials()[model].gaits[gait]


def told(name: str) -> float:
    """Return a number of the paper."""
    value: float = PAPER["values"][name]["value"]
    return value


def change(before: float, after: float) -> float:
    """Return a relative change in percent."""
    return 100 * (after / before - 1)


def rows(head: Sequence[str], body: Sequence[Sequence[str]], left: int = 1) -> str:
    """Write a Markdown table; all columns but the first `left` ones are aligned to the right."""
    rule = ["---"] * left + ["---:"] * (len(head) - left)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, rule, *body))


def of_report(table: Table, left: int = 1) -> str:
    """Write a table of the report."""
    body = [[cell if isinstance(cell, str) else f"{cell:.3g}" for cell in row] for row in table.rows]
    return rows(table.columns, body, left)


# --- tables


def ledger_table() -> str:
    """Tabulate the ledger: every number of the paper with the verdict."""
    body = []
    for e in ledger().entries:
        computed = "" if e.computed is None else f"{e.computed:.3g}"
        told = "" if e.published is None else f"{e.published:.4g}"
        body.append([f"`{e.id}`", e.model, e.verdict, told, computed, e.unit])
    return rows(["number", "model", "verdict", "published", "computed", "unit"], body, left=3)


def speeds_table() -> str:
    """Tabulate the eight speeds, computed beside published."""
    models = MODELS[:2]
    body = []
    for name in SPEEDS:
        gait, truth = FISH.gaits[name], told(f"speed/{name}")
        angles = [", ".join(f"{math.degrees(a):.4g}" for a in values) for values in (gait.amplitude, gait.phase[1:])]
        cells = [f"`{name}`", f"{gait.frequency:.3g}", *angles, f"{truth:.3g}"]
        for model in models:
            speed = swum(name, model).speed
            cells += [f"{speed:.3f}", f"{change(truth, speed):+.0f}\u00a0%"]
        body.append(cells)
    heads = [part for model in models for part in (model, "error")]
    return rows(["gait", "f [Hz]", "A [deg]", "lag [deg]", "published [m/s]", *heads], body)


def error_table() -> str:
    """Tabulate the errors of the speeds under every reading of the model."""
    body = []
    for model in MODELS:
        errors = np.array([change(told(f"speed/{name}"), swum(name, model).speed) for name in SPEEDS])
        first, rest = np.sqrt(np.mean(errors[:4] ** 2)), np.sqrt(np.mean(errors[4:] ** 2))
        cells = (np.sqrt(np.mean(errors**2)), np.abs(errors).max(), first, rest)
        body.append([model, *(f"{error:.1f}\u00a0%" for error in cells)])
    return rows(["model", "rms of eight", "largest", "rms, four unoptimized", "rms, four optimized"], body)


def section_table() -> str:
    """Tabulate the ellipses that Table II's areas imply: one area as height, the other as perimeter, times length."""
    links = FISH.links
    wetted = [10 * links.wetted_area[0], *links.wetted_area[1:]]
    names = [f"{links.name[0]}, $S_y$ = 903 cm²", *links.name[1:-1]]
    body = []
    for name, length, mass, side, skin in zip(
        names, links.length, links.mass, links.lateral_area, wetted, strict=False
    ):
        a, perimeter = side / length / 2, skin / length

        def excess(b: float, a: float = a, perimeter: float = perimeter) -> float:
            return 4 * a * float(ellipe(1 - (b / a) ** 2)) - perimeter

        b = brentq(excess, 1e-4 * a, 1.5 * a)
        cells = (200 * a, 100 * perimeter, 200 * b, mass / (math.pi * a * b * length) / 1000)
        body.append([name, *(f"{cell:.1f}" for cell in cells[:3]), f"{cells[3]:.2f}"])
    return rows(["link", "height $S_x/l$ [cm]", "perimeter $S_y/l$ [cm]", "width [cm]", "density [g/cm³]"], body)


def cost_table() -> str:
    """Tabulate how cost of transport changes from the unoptimised to the optimised gaits."""
    body = []
    for what in ("0.3", "0.4", "0.5"):
        cells = [f"{what} m/s", f"{told(f'cost-of-transport/change-{what}'):+.1f}\u00a0%"]
        for model in MODELS:
            costs = [swum(f"{before}-{what}", model).cost_of_transport for before in ("unoptimised", "optimised")]
            cells.append(f"{change(*costs):+.1f}\u00a0%")
        body.append(cells)
    return rows(["speed", "published", *MODELS], body)


def frequency_table() -> str:
    """Tabulate speed over frequency: constant without linear terms and lags, not so as published."""
    body = []
    for name in ("optimised-0.3", "optimised-max"):
        f, values = FISH.gaits[name].frequency, [told(f"speed/{name}")]
        values += [swum(name, model).speed for model in MODELS[:2]]
        body.append([f"`{name}`", f"{f:.3g}", *(f"{value / f:.3f}" for value in values)])
    return rows(["gait", "f [Hz]", "published $U/f$ [m]", *MODELS[:2]], body)


def phase_table() -> str:
    """Tabulate the fastest phase of every frequency and amplitude, and how far it is ahead of the next best."""
    phases = np.array(PAPER["tank"]["phase_deg"])
    body = []
    for model in MODELS:
        for k, amplitude in enumerate(PAPER["tank"]["amplitude_deg"]):
            cells = []
            for speeds in trials()[model].tank.speed.isel(amplitude=k, bias=0).values:
                second, first = np.sort(speeds)[-2:]
                cells.append(f"{phases[speeds.argmax()]:.0f} ({change(second, first):.1f})")
            body.append([model if k == 0 else "", amplitude, *cells])
    heads = [f"{f:.0f} Hz" for f in PAPER["tank"]["frequency_hz"]]
    return rows(["model", "amplitude", *heads], body, left=2)


def phase_cost_table() -> str:
    """Tabulate cost of transport against phase at large amplitude."""
    costs = trials()["joint bandwidth"].tank.cost_of_transport.isel(amplitude=-1, bias=0)
    body = [
        [f"{f:.0f} Hz", *(f"{cost:.2f}" for cost in row)]
        for f, row in zip(PAPER["tank"]["frequency_hz"], costs.values, strict=True)
    ]
    return rows(["frequency", *(f"{p:.0f} deg" for p in PAPER["tank"]["phase_deg"])], body)


def turning_table() -> str:
    """Tabulate the one-sided beat against phase."""
    found, frequency = trials()["joint bandwidth"].turning.squeeze(), FISH.gaits["turning"].frequency
    body = []
    for k, p in enumerate(PAPER["turning"]["phase_deg"]):
        at = found.isel(phase=k)
        turn = math.degrees(float(at.turn_rate)) / frequency
        cells = (f"{float(at.turn_radius) / FISH.body.length:.2f}", f"{float(at.speed):+.3f}", f"{turn:+.1f}")
        body.append([f"{p:.0f}", *cells])
    return rows(["phase [deg]", "radius [BL]", "speed [m/s]", "turn [deg/beat]"], body, left=0)


def range_table() -> str:
    """Tabulate how far the battery carries the robot: the paper's way and with the cells of Table I."""
    battery = FISH.battery
    assert battery is not None
    cost = told("cost-of-transport/minimum")
    charge, cells, volt = battery.capacity / 3600, battery.cells, PAPER["range"]["charged_cell_v"]
    cases = (
        (f"14 Ah × {cells} × {volt} V", PAPER["range"]["battery_ah"] * cells * volt),
        (f"{cells} × {charge:.1f} Ah × {battery.voltage} V", cells * charge * battery.voltage),
    )
    body = [[text, f"{energy:.1f}", f"{energy * 3.6 / (cost * FISH.body.mass):.2f}"] for text, energy in cases]
    body.append(["published", "", f"{told('range/battery'):.2f}"])
    return rows(["battery", "energy [Wh]", "range [km]"], body)


@cache
def front() -> Front:
    """Find HyperTuna's Pareto front of speed and cost of transport."""
    return pareto(FISH)


def front_table() -> str:
    """Tabulate what the paper's gaits cost in the model beside the cheapest gaits that are as fast."""
    body = []
    for name in SPEEDS:
        done = swum(name, "joint bandwidth")
        fast = gait_limits(FISH, speed=done.speed)
        least = optimize(FISH, minimize="cost_of_transport", limits=fast, method="gradient").cost_of_transport
        cells = (f"{done.speed:.3f}", f"{done.cost_of_transport:.3f}", f"{least:.3f}")
        body.append([f"`{name}`", *cells, f"{round(change(least, done.cost_of_transport)):+d}\u00a0%"])
    return rows(["gait", "speed [m/s]", "cost of transport [J/(kg m)]", "of the cheapest", "more"], body)


def objectives_table() -> str:
    """Tabulate the objectives."""
    body = [
        [f"`{name}`", QUANTITIES[name].unit, "large" if large else "small", QUANTITIES[name].meaning]
        for name, large in OBJECTIVES.items()
    ]
    return rows(["objective", "unit", "better", "meaning"], body, left=4)


@cache
def optimum(model: str, method: str, **wish: Any) -> Optimum:
    """Optimize HyperTuna under a reading of its joints."""
    return optimize(FISH.using(joints="ideal" if model == "ideal joints" else "bandwidth"), **wish, method=method)


def methods_table() -> str:
    """Tabulate what every method finds, and how many gaits it swims."""
    body = []
    for wish in ({"maximize": "speed"}, {"speed": 0.4}):
        for method in METHODS:
            best = optimum("joint bandwidth", method, **wish)
            assert best.gait is not None
            degrees = [f"{x:.2f}" for x in np.degrees([*best.gait.amplitude, best.gait.phase[1]])]
            cells = (f"{best.gait.frequency:.3f}", *degrees, f"{best.speed:.4f}", f"{best.cost_of_transport:.4f}")
            body.append(["highest" if "maximize" in wish else "0.4 m/s", f"`{method}`", *cells, str(best.evaluations)])
    head = ["speed", "method", "f [Hz]", "A1 [deg]", "A2 [deg]", "phase [deg]", "U [m/s]", "COT [J/(kg m)]", "gaits"]
    return rows(head, body, left=2)


def phases_table() -> str:
    """Tabulate how little the highest speed depends on the phase."""
    printed = swum("optimised-max", MODELS[0]).gait.phase[1]
    body = []
    for model in MODELS[:2]:
        best = optimum(model, "gradient", maximize="speed")
        assert best.gait is not None
        there = swim(best.robot, replace(best.gait, phase=(0.0, printed))).speed
        cells = (f"{np.degrees(best.gait.phase[1]):.1f}", f"{best.speed:.4f}", f"{there:.4f}")
        body.append([model, *cells, f"{change(best.speed, there):.2f}\u00a0%"])
    at = f"at {np.degrees(printed):.2f} deg"
    return rows(["model", "best phase [deg]", "highest speed [m/s]", f"{at} [m/s]", "change"], body)


def weights_table() -> str:
    """Tabulate up to which weight k of Eq. 42 the speed stays as expected."""
    body = []
    for speed in (0.2, 0.3, 0.4, 0.5, 0.55, 0.57):
        tracked = [optimum(model, "gradient", speed=speed) for model in MODELS[:2]]
        cells = [f(best) for best in tracked for f in (_threshold, lambda best: f"{best.cost_of_transport:.3f}")]
        body.append([f"{speed:g}", *cells])
    head = [f"{name}, {model}" for model in MODELS[:2] for name in ("largest k", "COT")]
    return rows(["expected speed [m/s]", *head], body)


def _threshold(best: Optimum) -> str:
    """Write the largest weight that holds the speed."""
    return "" if best.weight_threshold is None else f"{best.weight_threshold:.3f}"


def steady_columns() -> str:
    """Tabulate the columns of a file of steady runs."""
    body = [
        ["`frequency_hz`", "Hz", "yes", "beat frequency"],
        ["`amplitude_GROUP_deg`", "deg", "yes", "commanded amplitude of each joint group"],
        ["`phase_GROUP_deg`", "deg", "yes", "lag of each joint group; the first may be left out: 0"],
        ["`bias_GROUP_deg`", "deg", "", "mean angle of each joint group (default: 0)"],
        ["`{speed}`", "m/s", "either", "speed along the mean path"],
        ["`{speed_sd}`", "m/s", "", "standard deviation of the speed of a single swim"],
        ["`{cost_of_transport}`", "J/(kg m)", "or", "mechanical power over mass of the robot and speed"],
        ["`{cost_of_transport_sd}`", "J/(kg m)", "", "standard deviation of a single swim's"],
        ["`{repeats}`", "", "", "number of swims that the row is the mean of (default: 1)"],
        ["`{name}`", "", "", "name of the run (default: FILE:LINE)"],
    ]
    return rows(["column", "unit", "needed", "meaning"], [[cell.format(**COLUMNS) for cell in r] for r in body], left=4)


def quoted(name: str, kind: str, lines: int | None = None) -> str:
    """Quote the first lines of a file of the examples."""
    text = (ROOT / "examples" / name).read_text().splitlines()
    return "\n".join([f"```{kind}", *text[:lines], *(["..."] if lines else []), "```"])


def servo_power_table() -> str:
    """Tabulate the twin's electrical power in the two gaits whose power is published, over what it hangs on."""
    cost, lake = told("cost-of-transport/minimum"), PAPER["lake"]
    body = [["published", f"{cost * FISH.body.mass * told('speed/unoptimised-max'):.3g}", "", ""]]
    body[0][2] = f"{lake['energy_wh'] / 0.5:.3g}"  # in 30 minutes
    servo = next(k for k, s in enumerate(FISH.servos) if s.drives == "piston pump")
    stiff = {"bandwidth_hz": 20.0, "inertia_kg_m2": 0.009, "idle_current_a": 0.3}
    cases: dict[str, tuple[str, dict[str, float]]] = {
        "the twin": ("", {}),
        "first guess: 20 Hz, 0.009 kg m², 0.3 A": ("servos", stiff),
        "position loop of 15 Hz instead of 10": ("servos", {"bandwidth_hz": 15.0}),
        "rotor twice as heavy": ("servos", {"inertia_kg_m2": 0.009}),
        "twice the friction": ("servos", {"friction_n_m": 0.6}),
        "idle current of 0.3 A instead of 0.05": ("servos", {"idle_current_a": 0.3}),
        "oil of 35 C": ("oil", {"temperature_c": 35.0}),
        "lines of 3 mm": ("line", {"bore_m": 0.003}),
        "lines of 5 mm": ("line", {"bore_m": 0.005}),
    }
    for name, (where, values) in cases.items():
        document = FISH.document()
        tables = {"servos": [document["servos"][servo]], "oil": [document["oil"]]}
        for table in tables.get(where, [group["line"] for group in document["joints"]] if where else []):
            table.update(values)
        robot = parse(document)
        runs = [twin(robot, named_gait(robot, gait), duration=12) for gait in ("unoptimised-max", "optimised-0.5")]
        body.append([name, *(f"{run.power:.3g}" for run in runs), ", ".join(f"{run.speed:.2f}" for run in runs)])
    return rows(("", "fastest gait [W]", "lake gait [W]", "their speeds [m/s]"), body)


@cache
def sizes() -> list[Size]:
    """Size the pump over bore and temperature."""
    frequency, amplitude = largest_beat(FISH)
    celsius = (5, 10, 15, 20, 25, 30)
    bores, kelvin = [2e-3, 3e-3, 4e-3, 5e-3], [273.15 + t for t in celsius]
    return size_pump(FISH, frequency=[frequency], amplitude=amplitude, bore=bores, temperature=kelvin)


def prototype_table() -> str:
    """Tabulate what an independent prototype found for joint I at 6 Hz and 16 deg, beside ours."""
    bores, corners, bends = (2, 3, 4, 5), (1.1, 5.7, 18.0, 44.0), (4.2, 10.1, 12.7, 13.5)
    ours = {round(1e3 * s.bore): s for s in sizes() if s.joint == "I" and round(s.temperature - 273.15) == 20}
    body = [
        [f"{bore}", f"{corner:g}", f"{ours[bore].corner:.2g}", f"{bend:g}", f"{math.degrees(ours[bore].amplitude):.1f}"]
        for bore, corner, bend in zip(bores, corners, bends, strict=True)
    ]
    one, resistance = ours[3], 128 * 0.1164 * 0.08 / (math.pi * 0.003**4)
    oil = [250e3 / (2 * math.pi * resistance * 5.7), 250e3 * one.capacity]
    told = rows(("bore [mm]", "corner [Hz]", "ours", "bend [deg]", "ours"), body)
    volumes = f"{1e6 * oil[0]:.1f} ml in the prototype's muscles and {1e6 * oil[1]:.1f} ml in ours"
    speed = f"{one.speed / one.speed_limit:.2g} times what it has"
    return f"{told}\n\nOil on the way to 250 kPa: {volumes}. Speed that the beat asks of our servo: {speed}."


TABLES: dict[str, Callable[[], str]] = {
    "prototype": prototype_table,
    "servo power": servo_power_table,
    "front": front_table,
    "objectives": objectives_table,
    "methods": methods_table,
    "phases": phases_table,
    "weights": weights_table,
    "steady columns": steady_columns,
    "steady example": lambda: quoted("tank/tank.csv", "text", 5),
    "manifest example": lambda: quoted("tank/tank.toml", "toml"),
    "manifest keys": manifest_keys,
    "ledger": ledger_table,
    "speeds": speeds_table,
    "errors": error_table,
    "sections": section_table,
    "cost of transport": cost_table,
    "speed over frequency": frequency_table,
    "best phase": phase_table,
    "cost against phase": phase_cost_table,
    "turning": turning_table,
    "range": range_table,
    "Table III": lambda: of_report(coefficient_table(ledger().fits, PAPER)),
    "bandwidth": lambda: of_report(bandwidth_table(ledger().fits, PAPER)),
    "Table IV": lambda: of_report(gait_table(ledger().optima, ledger().trials), 2),
    "optimizers": lambda: of_report(method_table(ledger().optima), 2),
    "twin speeds": lambda: of_report(speed_table(ledger().twins, PAPER), 1),
    "twin amplitudes": lambda: of_report(tank_table(ledger().twins), 1),
    "twin bores": lambda: of_report(bore_table(swim_bores(FISH), PAPER)),
    "posture": lambda: of_report(posture_table(ledger().twins.posture), 2),
    "Table V": lambda: of_report(robot_table(computed_among(ledger().trials)[0]), 2),
}

# --- the drawing of frames and signs


def _arrow(axes: Axes, start: complex, end: complex, color: str, text: str = "", shift: complex = 0j) -> None:
    """Draw an arrow with a label at its end."""
    style = {"arrowstyle": "-|>", "color": color, "lw": 1.5, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    axes.annotate("", (end.real, end.imag), (start.real, start.imag), arrowprops=style, zorder=5)
    at = end + shift
    axes.text(at.real, at.imag, text, color=color, ha="center", va="center", fontsize=9.5)


def _arc(
    axes: Axes, center: complex, radius: float, start: float, stop: float, color: str, text: str, out: float
) -> None:
    """Draw an angle from start to stop [rad] with an arrow head at its end, and its name beside its middle."""
    points = center + radius * np.exp(1j * np.linspace(start, stop, 40))
    axes.plot(points.real, points.imag, color=color, lw=1.1)
    _arrow(axes, points[-3], points[-1], color)
    at = center + out * radius * np.exp(0.5j * (start + stop))
    axes.text(at.real, at.imag, text, color=color, ha="center", va="center", fontsize=9.5)


def _draw_body(axes: Axes) -> None:
    """Draw world and body axes, and the angles and axes of a link."""
    red, blue, green = COLORS[:3]
    theta, psi = math.radians(14), np.radians([0, 20, 48])
    lengths, nose = (2.6, 1.5, 1.9), 1.95 + 0.75j
    joints = nose + np.concatenate([[0], np.cumsum(lengths * np.exp(1j * (theta + psi)))])
    origin, ahead = 0.45 + 0.15j, np.exp(1j * theta)
    _arrow(axes, origin, origin + 0.9, INK, "$x$ (east)", 0.45)
    _arrow(axes, origin, origin + 0.9j, INK, "$y$ (north)", 0.14j)
    for a, b, width in zip(joints, joints[1:], (11, 8, 6), strict=False):
        axes.plot([a.real, b.real], [a.imag, b.imag], color=BODY, lw=width, solid_capstyle="round", zorder=1)
        axes.plot([a.real, b.real], [a.imag, b.imag], color=EDGE, lw=1.0, zorder=2)
    axes.plot(joints[1:-1].real, joints[1:-1].imag, "o", color="white", mec=INK, ms=6, zorder=6)
    # from the nose: heading, body axes, twist
    _dashes(axes, nose, nose + 1.9)
    _arc(axes, nose, 1.6, 0, theta, INK, r"$\theta$", 1.1)
    _arrow(axes, nose, nose + 1.0 * ahead, blue, "$x_0,\\,u$", 0.2j - 0.1)
    _arrow(axes, nose, nose + 1.0j * ahead, blue, "$y_0,\\,v$", 0.15j)
    _arc(axes, nose, 0.32, theta + 0.2, theta + 1.3, blue, "$r$", 1.5)
    _arrow(axes, nose - 0.12 * ahead, nose - 1.0 * ahead, EDGE, "swims\nthis way", 0.36j - 0.02)
    # a link: its angles and its axes
    middle, axis = 0.5 * (joints[2] + joints[3]), np.exp(1j * (theta + psi[2]))
    _dashes(axes, joints[2], joints[2] + 1.0 * np.exp(1j * (theta + psi[1])))
    _arc(axes, joints[2], 0.7, theta + psi[1], theta + psi[2], green, r"$\varphi_i$", 1.25)
    _dashes(axes, joints[2], joints[2] + 1.5 * ahead)
    _arc(axes, joints[2], 1.3, theta, theta + psi[2], green, r"$\psi_i$", 1.12)
    axes.plot(middle.real, middle.imag, "+", color=INK, ms=8, mew=1.4, zorder=6)
    _arrow(axes, middle, middle + 0.75 * axis, red, "$t,\\,v_t$", 0.3 - 0.02j)
    _arrow(axes, middle, middle + 0.75j * axis, red, "$n,\\,v_n$", -0.3 + 0.02j)
    axes.set(xlim=(-0.15, 8.2), ylim=(-0.1, 4.1), aspect="equal")


def _dashes(axes: Axes, start: complex, end: complex) -> None:
    """Draw a line that only shows where an angle begins."""
    axes.plot([start.real, end.real], [start.imag, end.imag], color=EDGE, lw=0.9, ls=(0, (4, 3)), zorder=0)


def _draw_conventions(axes: Axes) -> None:
    """Draw the axes that count as positive in three conventions, on a robot that faces left."""
    cases = (
        ("hypertuna: from the nose to the tail", 1, 1j, "$u$", "$v$", 1),
        ("ENU world, forward-left-up body", -1, -1j, "forward", "left", 1),
        ("NED world, forward-right-down body", -1, 1j, "surge", "sway", -1),
    )
    for k, (title, along, across, first, second, sense) in enumerate(cases):
        nose = 2.78 * k + 1.15 + 0j
        for a, b, width in ((0, 0.8, 9), (0.8, 1.25, 5)):
            axes.plot([nose.real + a, nose.real + b], [0, 0], color=BODY, lw=width, solid_capstyle="round", zorder=1)
        _arrow(axes, nose, nose + 0.7 * along, COLORS[1], first, 0.17j)
        _arrow(axes, nose, nose + 0.6 * across, COLORS[1], second, 0.14 * across)
        start = float(np.angle(along))
        _arc(axes, nose, 0.33, start + 0.3 * sense, start + 1.3 * sense, COLORS[1], "$r$", 1.5)
        axes.text(nose.real + 0.1, -1.12, title, ha="center", fontsize=8, color=INK)
    axes.set(xlim=(-0.15, 8.2), ylim=(-1.25, 0.95), aspect="equal")


def draw_frames() -> Figure:
    """Draw the frames and signs of docs/conventions.md."""
    figure = Figure(figsize=(7.2, 5.45), facecolor="white")
    body, conventions = figure.subplots(2, 1, height_ratios=[4.05, 2.2])
    figure.subplots_adjust(left=0, right=1, top=1, bottom=0, hspace=0)
    _draw_body(body)
    _draw_conventions(conventions)
    for axes in (body, conventions):
        axes.set_axis_off()
    return figure


# --- pictures

PICTURES: dict[str, Callable[[], Figure]] = {
    "docs/swim.svg": lambda: plot_swim(swum("unoptimised-max", "joint bandwidth")),
    "docs/frames.svg": draw_frames,
    "docs/dive.svg": lambda: plot_dive(dive(load("hypertuna"), named_gait(load("hypertuna"), "unoptimised-0.4"))),
    "docs/pump.svg": lambda: plot_pump(sizes()),
    "docs/pareto.svg": lambda: plot_pareto(front()),
    "docs/convergence.svg": lambda: plot_convergence([optimum(MODELS[1], m, speed=0.4) for m in METHODS]),
    "docs/minnow.svg": lambda: draw(load(ROOT / "examples/minnow.toml")),
}

# Other pages have a module of their own.
for part in ("figures_actuator.py", "figures_bench.py", "figures_fe.py", "figures_mission.py", "figures_turn.py"):
    made = runpy.run_path(str(ROOT / "docs" / part))
    TABLES |= made["TABLES"]
    PICTURES |= made["PICTURES"]

# --- pages


@cache
def output(command: str) -> str:
    """Run a command of the program in a folder that has robots and trials of the examples; return what it prints."""
    said = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for robot in (ROOT / "examples").glob("*.toml"):
            shutil.copy(robot, folder)
        shutil.copytree(ROOT / "examples/tank", Path(folder) / "tank")
        lines = (ROOT / "examples/tank/tank.csv").read_text().splitlines()
        Path(folder, "tank/bad.csv").write_text("\n".join([*lines[:2], lines[2].replace("1,", "1 Hz,", 1)]))
        with (
            mock.patch.dict(os.environ, {"COLUMNS": "80", "NO_COLOR": "1", "TERM": "dumb"}),
            mock.patch.object(sys, "argv", shlex.split(command)),
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
            contextlib.suppress(SystemExit),
        ):
            main()
    return "\n".join(line.rstrip() for line in said.getvalue().splitlines())


def filled(page: str) -> str:
    """Return a page with its tables and console outputs made anew."""
    page = re.sub(
        r"(<!-- table: (.+?) -->\n).*?(<!-- end -->)",
        lambda m: f"{m[1]}\n{TABLES[m[2]]()}\n\n{m[3]}",
        page,
        flags=re.DOTALL,
    )
    return re.sub(
        r"```console\n(\$ hypertuna.*?)\n```", lambda m: f"```console\n{_console(m[1])}\n```", page, flags=re.DOTALL
    )


def _console(block: str) -> str:
    """Run the commands of a console block."""
    commands = re.findall(r"^\$ (.*)$", block, flags=re.MULTILINE)
    return "\n\n".join("\n".join(filter(None, (f"$ {command}", output(command)))) for command in commands)


if __name__ == "__main__":
    for path in PAGES:
        path.write_text(filled(path.read_text()))
    for name, picture in PICTURES.items():
        save(picture(), ROOT / name)
