"""What the twin reaches: the tables of docs/twin.md. Run: python validation/twin/study.py [PART ...]."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuator import joint_tables
from hypertuna.description import parse
from hypertuna.hydraulics import circuits, servo_angle
from hypertuna.twin import _parts_of
from hypertuna.twin_run import TwinRun

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
    a, p = np.degrees(run.amplitude), run.pressure_max / 1e3
    low = run.pressure_min.min() / 1e3
    return (
        f"{a[0]:.1f} / {a[1]:.1f} | {p[:2].max():.0f} / {p[2:].max():.0f} | {low:.0f} | {run.speed:.3f} | "
        f"{run.power:.1f} | {', '.join(names)}"
    )


def amplitudes() -> None:
    """Amplitudes reached at 1 to 6 Hz for 16 and 25 deg."""
    for closed in (True, False):
        print(f"\n{'Closed' if closed else 'Open'} loop, 16 and 25 deg set, phase 0, in water\n")
        print("| Hz | deg | lag 4.7 Hz | pump kPa | lowest | m/s | W | limits |")
        runs = [options(frequency=f, amplitude=(16, 25), closed_loop=closed) for f in range(1, 7)]
        for run in ht.twins(runs, measure=lambda run: run, threads=THREADS):
            part = 1 / math.sqrt(1 + (run.gait.frequency / 4.7) ** 2)
            first, rest = cell(run).split(" | ", 1)
            print(f"| {run.gait.frequency:g} | {first} | {16 * part:.1f} / {25 * part:.1f} | {rest} |")


def options(frequency: float, amplitude: Iterable[float], **more: Any) -> dict[str, Any]:
    """Arguments of a run of 20 s."""
    gait = ht.Gait.from_degrees(frequency=frequency, amplitude=tuple(amplitude), phase=(0, 0))
    return {"robot": ROBOT, "gait": gait, "duration": 20.0, "start": "swimming", **more}


def eight(label: str, **more: Any) -> None:
    """The published gaits."""
    robot = more.pop("robot", ROBOT)
    runs = [
        {"robot": robot, "gait": ht.named_gait(robot, g), "duration": 20.0, "start": "swimming", **more} for g in GAITS
    ]
    found = ht.twins(runs, measure=lambda run: run, threads=THREADS)
    speeds = np.array([run.speed for run in found])
    rms = 100 * math.sqrt(float(np.mean((speeds / PUBLISHED - 1) ** 2)))
    print(f"| {label} | {' | '.join(f'{s:.3f}' for s in speeds)} | {rms:.1f} % |", flush=True)
    if label == "as shipped":
        for name, run in zip(GAITS, found, strict=True):
            print(f"    {name}: {cell(run)} settled {run.settled} ({100 * run.change:.2f} %/beat)")


def speeds() -> None:
    """The eight speeds, and what moves them."""
    print("\n| | " + " | ".join(f"{s:g}" for s in PUBLISHED) + " | rms |")
    eight("as shipped")
    eight("open loop", closed_loop=False)
    no_limit = changed(controller__pressure_soft_pa=2e6, controller__pressure_hard_pa=3e6)
    eight("no pressure limit", believed=no_limit, closed_loop=False)
    for bore in (3, 5, 6):
        eight(f"{bore} mm lines", robot=changed(line__bore_m=bore / 1e3))
    for celsius in (10, 30, 40):
        eight(f"{celsius} C", temperature=celsius + 273.15)
    for soft in (300, 400):
        limits = {"controller__pressure_soft_pa": soft * 1e3, "controller__pressure_hard_pa": 1.2e3 * soft}
        eight(f"{soft} kPa soft", robot=changed(**limits))
    for speed in (6, 10):
        eight(f"{speed} rad/s servos", robot=changed(servo__speed_rad_s=float(speed)))
    for fill in (30, 90):
        eight(f"{fill} kPa fill", robot=changed(line__fill_pressure_pa=fill * 1e3))
    for air in (0.0, 0.03):
        eight(f"{100 * air:g} % air", robot=changed(oil__air=air))


def driven(robot: ht.Robot, frequency: float, amplitude: Any, fish_in: str) -> tuple[Any, Any]:
    """Amplitude [deg] and largest pump pressure [kPa] of both joints, servos driven by the inverse volumes."""
    parts, tables, oil = _parts_of(robot, fish_in, None), joint_tables(robot), circuits(robot)
    t = np.arange(400) * 0.01
    target = np.zeros((len(t), 4))
    for j in range(2):
        bend = np.radians(amplitude[j]) * np.sin(2 * np.pi * frequency * t) * np.minimum(1, t * frequency)
        gained = tables[j].at(bend)["volume"] - tables[j].at([0.0])["volume"][0]
        for side in range(2):
            target[:, 2 * j + side] = servo_angle(oil, gained[:, side], 2 * j + side)
    out = _core.run_plant(**parts.plant, twist=np.zeros(3), target=np.nan_to_num(target, nan=1.2), tick=0.01, steps=20)
    last = slice(200, 400)
    turn = np.exp(-2j * np.pi * frequency * t[last])
    angle = np.degrees(abs(2 * np.mean(out["angle"][last] * turn[:, None], axis=0)))
    return angle, out["pump_pressure_high"][last].max(axis=0).reshape(2, 2).max(axis=1) / 1e3


def bore() -> None:
    """Fig. 8 on the bench: pressure that 20 deg of joint II take at the cylinder, joint I at rest and at 16 deg."""
    print("\n| bore mm | 1 Hz | 3 Hz | 6 Hz | 6 Hz, joint I asked for 16 deg too |")
    for mm in (3, 4, 5, 6):
        robot, row = changed(line__bore_m=mm / 1e3), []
        for frequency, other in ((1, 0.0), (3, 0.0), (6, 0.0), (6, 16.0)):
            amplitude = np.array([other, 20.0])
            for _ in range(10):
                angle, pressure = driven(robot, frequency, amplitude, "air")
                amplitude[1] = min(amplitude[1] * np.clip(20 / angle[1], 0.5, 1.5), 40.0)
            row.append(f"{pressure[1]:.0f}" + ("" if angle[1] > 19.9 else f" ({angle[1]:.1f} deg)"))
        print(f"| {mm} | {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    parts = {"amplitudes": amplitudes, "speeds": speeds, "bore": bore}
    for part in sys.argv[1:] or parts:
        parts[part]()
