"""What the twin reaches: the tables of docs/twin.md, printed, or with --page written into that page (some minutes).

python validation/twin/study.py [--page] [amplitudes speeds bore]
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.hydraulics import circuits, servo_angle
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.description.robot import parse
from hypertuna.simulation.plant import parts_of
from hypertuna.simulation.run import TwinRun

ROBOT = ht.load("hypertuna")
GAITS = [f"{kind}-{speed}" for kind in ("unoptimised", "optimised") for speed in ("0.3", "0.4", "0.5", "max")]
PUBLISHED = np.array([0.30, 0.40, 0.50, 0.56, 0.30, 0.40, 0.50, 0.582])
THREADS = 2


def changed(**values: Any) -> ht.Robot:
    """The robot with values of every line, or of other tables, replaced: line__bore_m=0.005, oil__air=0.02."""
    document = ROBOT.document()
    for name, value in values.items():
        table, key = name.split("__")
        if table == "line":
            for joint in document["joints"]:
                joint["line"][key] = value
        elif table == "servo":
            next(s for s in document["servos"] if s["drives"] == "piston pump")[key] = value
        else:
            document[table][key] = value
    return parse(document, file=ROBOT.file)


def cell(run: TwinRun) -> str:
    """Amplitudes, pressures and limits of a run."""
    names = [name.removesuffix("_limit") for name in run.limits if run.acting[name] > 0.05]
    a, p = np.degrees(run.swing), run.pressure_max / 1e3
    low = run.pressure_min.min() / 1e3
    return (
        f"{a[0]:.1f} / {a[1]:.1f} | {p[:2].max():.0f} / {p[2:].max():.0f} | {low:.0f} | {run.speed:.3f} | "
        f"{run.electrical_power:.1f} | {', '.join(names)}"
    )


def amplitudes() -> Iterator[str]:
    """Amplitudes reached at 1 to 6 Hz for 16 and 25 deg."""
    for closed in (True, False):
        yield f"{'Closed' if closed else 'Open'} loop:\n"
        yield "| Hz | I / II, deg | by a lag of 4.7 Hz | cylinder I / II, kPa | lowest, kPa | m/s | W | limits |"
        yield "|---:|---:|---:|---:|---:|---:|---:|---|"
        runs = [options(frequency=f, amplitude=(16, 25), closed_loop=closed) for f in range(1, 7)]
        for run in ht.twins(runs, measure=lambda run: run, threads=THREADS):
            part = 1 / math.sqrt(1 + (run.gait.frequency / 4.7) ** 2)
            first, rest = cell(run).split(" | ", 1)
            yield f"| {run.gait.frequency:g} | {first} | {16 * part:.1f} / {25 * part:.1f} | {rest} |"
        yield ""


def options(frequency: float, amplitude: Iterable[float], **more: Any) -> dict[str, Any]:
    """Arguments of a run of 20 s."""
    gait = ht.Gait.from_degrees(frequency=frequency, amplitude=tuple(amplitude), phase=(0, 0))
    return {"robot": ROBOT, "gait": gait, "duration": 20.0, "start": "swimming", **more}


def eight(robot: ht.Robot = ROBOT, **more: Any) -> list[TwinRun]:
    """The published gaits."""
    named = [ht.named_gait(robot, name) for name in GAITS]
    runs = [{"robot": robot, "gait": gait, "duration": 20.0, "start": "swimming", **more} for gait in named]
    return ht.twins(runs, measure=lambda run: run, threads=THREADS)


def row(label: str, found: list[TwinRun]) -> str:
    """Their speeds, and how far those are from the published ones."""
    speeds = np.array([run.speed for run in found])
    rms = 100 * math.sqrt(float(np.mean((speeds / PUBLISHED - 1) ** 2)))
    return f"| {label} | {' | '.join(f'{speed:.3f}' for speed in speeds)} | {rms:.1f} % |"


def speeds() -> Iterator[str]:
    """The eight speeds, and what moves them."""
    yield "| gait | published | twin, m/s | I / II, deg | cylinder I / II, kPa | lowest, kPa | W | limits |"
    yield "|---|---:|---:|---:|---:|---:|---:|---|"
    shipped = eight()
    for name, published, run in zip(GAITS, PUBLISHED, shipped, strict=True):
        angles, pressures, low, speed, power, limits = cell(run).split(" | ")
        yield f"| {name} | {published:g} | {speed} | {angles} | {pressures} | {low} | {power} | {limits} |"
    yield ""
    yield f"| | {' | '.join(f'{speed:g}' for speed in PUBLISHED)} | rms |"
    yield "|---|" + "---:|" * 9
    yield row("as shipped", shipped)
    yield row("open loop", eight(closed_loop=False))
    unlimited = changed(controller__pressure_soft_pa=2e6, controller__pressure_hard_pa=3e6)
    yield row("no pressure limit", eight(controller_robot=unlimited, closed_loop=False))
    for bore in (3, 4, 6):
        yield row(f"lines of {bore} mm", eight(changed(line__bore_m=bore / 1e3)))
    for celsius in (10, 30):
        yield row(f"oil at {celsius} C", eight(temperature=celsius + 273.15))
    for soft in (200, 300):
        limits_at = {"controller__pressure_soft_pa": soft * 1e3, "controller__pressure_hard_pa": 1.2e3 * soft}
        yield row(f"soft limit {soft} kPa", eight(changed(**limits_at)))
    for rate in (5, 10):
        yield row(f"servos of {rate} rad/s", eight(changed(servo__speed_rad_s=float(rate))))
    for fill in (30, 90):
        yield row(f"filled to {fill} kPa", eight(changed(line__fill_pressure_pa=fill * 1e3)))
    for air in (0.0, 0.03):
        yield row(f"{100 * air:g} % air", eight(changed(oil__air=air)))
    yield ""


def driven(robot: ht.Robot, frequency: float, amplitude: Any, medium: str) -> tuple[Any, Any]:
    """Amplitude [deg] and largest pump pressure [kPa] of both joints, servos driven by the inverse volumes."""
    parts, models, oil = parts_of(robot, medium, None), joint_models(robot), circuits(robot)
    t = np.arange(400) * 0.01
    target = np.zeros((len(t), 4))
    for j in range(2):
        bend = np.radians(amplitude[j]) * np.sin(2 * np.pi * frequency * t) * np.minimum(1, t * frequency)
        gained = models[j].hold(bend)["volume"] - models[j].at(0.0)["volume"][0]
        for side in range(2):
            target[:, 2 * j + side] = servo_angle(oil, gained[:, side], 2 * j + side)
    world = _core.World({"clamped": medium == "air"})
    target = np.nan_to_num(target, nan=1.2)
    out = _core.simulate(parts.plant, target, world, twist=np.zeros(6), tick=0.01, steps=20)
    last = slice(200, 400)
    turn = np.exp(-2j * np.pi * frequency * t[last])
    angle = np.degrees(abs(2 * np.mean(out["angle"][last] * turn[:, None], axis=0)))
    return angle, out["pump_pressure_high"][last].max(axis=0).reshape(2, 2).max(axis=1) / 1e3


def bore() -> Iterator[str]:
    """Fig. 8 on the bench: pressure that 20 deg of joint II take at the cylinder, joint I at rest and at 16 deg."""
    yield "| bore | 1 Hz | 3 Hz | 6 Hz | 6 Hz, joint I asked for 16 deg too |"
    yield "|---:|---:|---:|---:|---:|"
    for mm in (3, 4, 5, 6):
        robot, cells = changed(line__bore_m=mm / 1e3), []
        for frequency, other in ((1, 0.0), (3, 0.0), (6, 0.0), (6, 16.0)):
            amplitude = np.array([other, 20.0])
            for _ in range(10):
                angle, pressure = driven(robot, frequency, amplitude, "air")
                amplitude[1] = min(amplitude[1] * np.clip(20 / angle[1], 0.5, 1.5), 40.0)
            cells.append(f"{pressure[1]:.0f} kPa" + ("" if angle[1] > 19.9 else f", {angle[1]:.1f} deg only"))
        yield f"| {mm} mm | {' | '.join(cells)} |"
    yield ""


def write_page(name: str, lines: list[str]) -> None:
    """Put a table between its marks in the page."""
    page = Path(__file__).resolve().parents[2] / "docs" / "twin.md"
    table = "\n".join(lines).strip()
    text = re.sub(
        rf"(<!-- {name} -->\n).*?(<!-- end -->)",
        lambda found: f"{found[1]}\n{table}\n\n{found[2]}",
        page.read_text(encoding="utf-8"),
        flags=re.DOTALL,
    )
    page.write_text(text, encoding="utf-8")


def main(parts: dict[str, Callable[[], Iterator[str]]]) -> None:
    """Print the parts that the command names, or all; with --page, put them into docs/twin.md too."""
    for part in [part for part in sys.argv[1:] if part in parts] or list(parts):
        lines = []
        for line in parts[part]():
            print(line, flush=True)
            lines.append(line)
        if "--page" in sys.argv:
            write_page(part, lines)


if __name__ == "__main__":
    main({"amplitudes": amplitudes, "speeds": speeds, "bore": bore})
