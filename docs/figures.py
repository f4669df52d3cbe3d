"""Keep the documentation true: every table, console output and picture in it is made here, by the program itself.

`python docs/figures.py` brings README.md and docs/*.md up to date. It writes anew the text between
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
import threading
from collections.abc import Callable
from functools import cache
from pathlib import Path
from unittest import mock

import numpy as np
from figures_reference import reference
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.special import ellipe

from hypertuna.cli.main import main
from hypertuna.description.plots import plot_robot
from hypertuna.description.robot import load
from hypertuna.figures import save
from hypertuna.paper.chapters.budget import interval_table
from hypertuna.paper.chapters.coefficients import bandwidth_table, coefficient_table
from hypertuna.paper.chapters.optima import gait_table, method_table
from hypertuna.paper.chapters.others import computed_among, robot_table
from hypertuna.paper.chapters.seeds import seed_table
from hypertuna.paper.chapters.twin import bore_table, speed_table, tank_table
from hypertuna.paper.computed import SPEEDS, swim_bores
from hypertuna.paper.ledger import CLASSES, VERDICTS
from hypertuna.paper.reproduce import Ledger, reproduce
from hypertuna.reports.html import Table, table_of
from hypertuna.simulation.cards import posture_table
from hypertuna.simulation.dive import dive
from hypertuna.simulation.plots import plot_dive, plot_posture
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.plots import plot_swim

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "docs"))
from figures_common import FISH, MODELS, PAPER, change, paper_value, rows, swum, trials  # noqa: E402  # in this folder
from figures_stated import stated  # noqa: E402

PAGES = (ROOT / "README.md", *sorted(path for path in (ROOT / "docs").rglob("*.md") if "_build" not in path.parts))


@cache
def ledger() -> Ledger:
    """Compute the paper's numbers."""
    return reproduce()


def of_report(table: Table, left: int = 1) -> str:
    """Return a table of the ledger's page as Markdown."""
    body = [[cell if isinstance(cell, str) else f"{cell:.3g}" for cell in row] for row in table.rows]
    return rows(table.columns, body, left)


# --- tables


def ledger_table() -> str:
    """Tabulate the ledger: every number of the paper with the verdict."""
    body = []
    for e in ledger().entries:
        computed = "" if e.computed is None else f"{e.computed:.3g}"
        published = "" if e.published is None else f"{e.published:.4g}"
        body.append([f"`{e.id}`", e.model, e.class_, e.verdict, e.seeds_text, published, computed, e.band_text, e.unit])
    heads = ["number", "model", "class", "verdict", "seeds", "published", "computed", "90 % of the family", "unit"]
    return rows(heads, body, left=4)


PREDICTED = ("reproduced", "holds", "deviates", "violated", "undetermined")  # verdicts that a prediction may have


def prediction_table() -> str:
    """Count the predictions of every model and of all, and give the model's error of the eight speeds.

    The last row counts a number that several models predict once, by the best verdict.
    """
    found = [e for e in ledger().entries if e.class_ == "prediction"]
    worst_first = sorted(found, key=lambda e: -VERDICTS.index(e.verdict))
    once = list({e.id: e for e in worst_first}.values())
    models = dict.fromkeys([*ledger().summary["speeds"], *(e.model for e in found)])
    parts = {model: [e for e in found if e.model == model] for model in models} | {"each number once": once}
    body = []
    for model, part in ((model, part) for model, part in parts.items() if part):
        verdicts = [e.verdict for e in part]
        met = [e for e in part if e.verdict == "reproduced" and e.kind == "measured"]
        counts = (len(part), *(verdicts.count(verdict) for verdict in PREDICTED), len(met))
        body.append([model, *map(str, counts), _speed_error(model)])
    heads = ["reproduced", "bound holds", "deviates", "bound violated", "undetermined", "reproduced of measured"]
    return rows(["model", "predictions", *heads, "rms error of the eight speeds"], body)


def _speed_error(model: str) -> str:
    """Write the error of a model's eight speeds, and how many of them were fitted or chosen in sight."""
    errors = ledger().summary["speeds"].get(model)
    if errors is None:
        return ""
    classes = [e.class_ for e in ledger().entries if e.model == model and e.id.removeprefix("speed/") in SPEEDS]
    used = [f"{classes.count(name)} {name}" for name in CLASSES if name != "prediction" and name in classes]
    return ", ".join([f"{100 * errors['rms_relative_error']:.1f} %", *used])


def class_table() -> str:
    """Count the ledger's entries by class and verdict."""
    counts = ledger().summary["classes"]
    body = [[name, text, *(str(counts[name][verdict] or "") for verdict in VERDICTS)] for name, text in CLASSES.items()]
    return rows(["class", "because", *VERDICTS], body, left=2)


def speeds_table() -> str:
    """Tabulate the eight speeds, computed beside published."""
    models = MODELS[:2]
    body = []
    for name in SPEEDS:
        gait, truth = FISH.gaits[name], paper_value(f"speed/{name}")
        angles = [", ".join(f"{math.degrees(a):.4g}" for a in values) for values in (gait.amplitude, gait.phase[1:])]
        cells = [f"`{name}`", f"{gait.frequency:.3g}", *angles, f"{truth:.3g}"]
        for model in models:
            speed = swum(name, model).speed
            cells += [f"{speed:.3f}", f"{change(truth, speed):+.0f}\u00a0%"]
        body.append(cells)
    heads = [part for model in models for part in (model, "error")]
    return rows(["gait", "f [Hz]", "A [deg]", "lag [deg]", "published [m/s]", *heads], body)


def error_table() -> str:
    """Tabulate the errors of the speeds for every variant of the model."""
    body = []
    for model in MODELS:
        errors = np.array([change(paper_value(f"speed/{name}"), swum(name, model).speed) for name in SPEEDS])
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
        cells = [f"{what} m/s", f"{paper_value(f'cost-of-transport/change-{what}'):+.1f}\u00a0%"]
        for model in MODELS:
            costs = [swum(f"{before}-{what}", model).cost_of_transport for before in ("unoptimised", "optimised")]
            cells.append(f"{change(*costs):+.1f}\u00a0%")
        body.append(cells)
    return rows(["speed", "published", *MODELS], body)


def frequency_table() -> str:
    """Tabulate speed over frequency, which is constant for ideal joints without linear drag, but not as published."""
    body = []
    for name in ("optimised-0.3", "optimised-max"):
        f, values = FISH.gaits[name].frequency, [paper_value(f"speed/{name}")]
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
    """Tabulate the range on the battery: with the paper's charge, and with the cells of Table I."""
    battery = FISH.battery
    assert battery is not None
    cost = paper_value("cost-of-transport/minimum")
    charge, cells, volt = battery.capacity / 3600, battery.cells, PAPER["range"]["charged_cell_v"]
    cases = (
        (f"14 Ah × {cells} × {volt} V", PAPER["range"]["battery_ah"] * cells * volt),
        (f"{cells} × {charge:.1f} Ah × {battery.voltage} V", cells * charge * battery.voltage),
    )
    body = [[text, f"{energy:.1f}", f"{energy * 3.6 / (cost * FISH.body.mass):.2f}"] for text, energy in cases]
    body.append(["published", "", f"{paper_value('range/battery'):.2f}"])
    return rows(["battery", "energy [Wh]", "range [km]"], body)


TABLES: dict[str, Callable[[], str]] = {
    "settling": lambda: runpy.run_path(str(ROOT / "validation/control/settling.py"))["table"](),
    "ledger": ledger_table,
    "classes": class_table,
    "seeds": lambda: of_report(seed_table(list(ledger().entries)), 2),
    "predictions": prediction_table,
    "speeds": speeds_table,
    "errors": error_table,
    "sections": section_table,
    "cost of transport": cost_table,
    "speed over frequency": frequency_table,
    "best phase": phase_table,
    "cost against phase": phase_cost_table,
    "turning": turning_table,
    "range": range_table,
    "Table III": lambda: of_report(coefficient_table(ledger().results["fits"])),
    "bandwidth": lambda: of_report(bandwidth_table(ledger().results["fits"])),
    "Table IV": lambda: of_report(gait_table(ledger().results["optima"]), 2),
    "optimizers": lambda: of_report(method_table(ledger().results["optima"]), 2),
    "twin speeds": lambda: of_report(speed_table(ledger().results["twins"]), 1),
    "twin amplitudes": lambda: of_report(tank_table(ledger().results["twins"]), 1),
    "twin budget": lambda: of_report(interval_table(ledger().results["budget"])[0], 2),
    "twin bores": lambda: of_report(bore_table(swim_bores(FISH))),
    "posture": lambda: of_report(table_of(posture_table(ledger().results["twins"].posture)), 2),
    "Table V": lambda: of_report(robot_table(computed_among(ledger().trials)[0]), 2),
}

# --- pictures

PICTURES: dict[str, Callable[[], Figure]] = {
    "docs/swim.svg": lambda: plot_swim(swum("unoptimised-max", "joint bandwidth")),
    "docs/control.svg": lambda: plot_posture(ledger().results["twins"].posture),
    "docs/dive.svg": lambda: plot_dive(dive(load("hypertuna"), named_gait(load("hypertuna"), "unoptimised-0.4"))),
    "docs/minnow.svg": lambda: plot_robot(load(ROOT / "examples/minnow.toml")),
}

# Other pages have a module of their own.
for part in (
    "gallery",
    "frames",
    "hydraulics",
    "trials",
    "actuator",
    "bench",
    "fe",
    "model",
    "flow",
    "turn",
    "optimize",
    "design",
    "mission",
    "fin",
    "fin_force",
    "bring_up",
    "firmware",
    "learning",
    "scoreboard",
    "twin",
    "joint",
    "passive",
):
    made = runpy.run_path(str(ROOT / "docs" / f"figures_{part}.py"))
    TABLES |= made["TABLES"]
    PICTURES |= made["PICTURES"]

made = runpy.run_path(str(ROOT / "docs/figures_swim.py"))  # what figures_swim.py defines
TABLES |= made["TABLES"]
FILES: dict[str, Callable[[], str]] = made["FILES"]  # animated pictures, which are written as text

# --- pages


@cache
def output(command: str) -> str:
    """Run a command of the program in a folder that has robots and trials of the examples; return what it prints."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for robot in (ROOT / "examples").glob("*.toml"):
            shutil.copy(robot, folder)
        for trials in ("tank", "eel"):
            shutil.copytree(ROOT / "examples" / trials, Path(folder) / trials)
        lines = (ROOT / "examples/tank/tank.csv").read_text().splitlines()
        Path(folder, "tank/bad.csv").write_text("\n".join([*lines[:2], lines[2].replace("1,", "1 Hz,", 1)]))
        if " robot new " in command:
            Path("myfish.toml").unlink()
        return _run(command)


def _run(command: str) -> str:
    """Run a command of the program here; return what it prints."""
    said = io.StringIO()
    with (
        mock.patch.dict(os.environ, {"COLUMNS": "80", "NO_COLOR": "1", "TERM": "dumb"}),
        mock.patch.object(sys, "argv", shlex.split(command)),
        mock.patch("hypertuna.cli.console.PERIOD", threading.TIMEOUT_MAX),  # no lines of progress on slow machines
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(said),
        contextlib.suppress(SystemExit),
    ):
        main()
    return "\n".join(line.rstrip() for line in said.getvalue().splitlines())


def filled(page: str) -> str:
    """Return a page with its tables, its numbers of the ledger and its console outputs written anew."""
    page = re.sub(
        r"(<!-- table: (.+?) -->\n).*?(<!-- end -->)",
        lambda m: f"{m[1]}\n{TABLES[m[2]]()}\n\n{m[3]}",
        page,
        flags=re.DOTALL,
    )
    page = stated(page, ledger)
    return re.sub(
        r"```console\n(\$ hypertuna.*?)\n```", lambda m: f"```console\n{_console(m[1])}\n```", page, flags=re.DOTALL
    )


def _console(block: str) -> str:
    """Run the commands of a console block."""
    commands = re.findall(r"^\$ (.*)$", block, flags=re.MULTILINE)
    return "\n\n".join("\n".join(filter(None, (f"$ {command}", output(command)))) for command in commands)


if __name__ == "__main__":
    (ROOT / "docs/description.md").write_text(reference())
    for path in PAGES:
        path.write_text(filled(path.read_text()))
    for name, text in FILES.items():
        (ROOT / name).write_text(text())
    for name, picture in PICTURES.items():
        save(picture(), ROOT / name)
