"""Tables of docs/fe.md, from stored results; docs/figures.py includes them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from figures_common import rows

from hypertuna.actuation.axis import film, held_compression, pipe
from hypertuna.actuation.soft_joint import drive_unit, joint_models, mooney
from hypertuna.description.robot import load
from hypertuna.fe.states import fast_states
from hypertuna.paper.chapters.finite_elements import difference_table, read_elements

ROOT = Path(__file__).resolve().parents[1]
ELEMENTS = read_elements()  # stored results of finite elements


def bend_table() -> str:
    """Tabulate bends by finite elements and by the fast model."""
    table = difference_table(ELEMENTS)
    assert table is not None, "run: python validation/fe/ledger.py"
    return rows(table.columns, [[str(cell) for cell in row] for row in table.rows], left=0)


def state_table() -> str:
    """Tabulate volumes and length of stored states, and the moment of the fast model at the elements' angle."""
    body = []
    for joint, one in ELEMENTS.solved.items():
        pressure, there = one.points
        model = next(model for model in joint_models(one.robot) if model.name == joint)
        ours = fast_states(one.robot, model, pressure, there)
        for k, (left, right) in enumerate(pressure / 1e3):
            cells = [joint, f"{left:.0f}", f"{right:.0f}", f"{1e3 * there.moment[0, k]:z.0f}"]
            for name, scale, digits in (("angle", 180 / math.pi, 2), ("volume", 1e6, 2), ("length", 1e3, 1)):
                pairs = zip(*(np.atleast_1d(getattr(states, name)[0, k]) for states in (there, ours)), strict=True)
                cells += [f"{scale * a:z.{digits}f}, {scale * b:z.{digits}f}" for a, b in pairs]
            body.append([*cells, f"{1e3 * (ours.moment[0, k] - there.moment[0, k]):+z.1f}"])
    head = ["joint", "left [kPa]", "right [kPa]", "moment [mN m]", "bend [deg]", "oil left [ml]", "oil right [ml]"]
    return rows([*head, "length [mm]", "moment off [mN m]"], body, left=1)


def apart_table() -> str:
    """Tabulate the largest differences of the fast model over all stored states."""
    body = []
    for joint, one in ELEMENTS.solved.items():
        curves = (one.difference, one.oil_difference)
        values = [*(np.abs(curve).max() for curve in curves), *one.over_points.values()]
        body.append([joint, f"{len(one.points[0])}", *(f"{100 * value:.1f} %" for value in values)])
    return rows(["joint", "states", "bend", "oil", "moment", "volume"], body, left=1)


def run_table() -> str:
    """Tabulate the sizes of the stored runs, their time and memory."""
    body = []
    for one in ELEMENTS.solved.values():
        record = one.record
        assert record is not None
        sizes = (f"{record['elements']:,}", f"{record['unknowns']:,}")
        cost = (f"{record['seconds']:.0f}", f"{record['memory_gb']:.2f}")
        body.append([one.joint, f"{one.column('bend_deg')[-1]:.2f}", f"{one.r_squared:.3f}", *sizes, *cost])
    head = ["joint", "at 250 kPa [deg]", "R², 100–250 kPa", "tetrahedra", "unknowns", "time [s]"]
    return rows([*head, "memory [GB]"], body, left=1)


def case_table() -> str:
    """Tabulate the stored output of `validation/fe/validate.py --json`."""
    cases = json.loads((ROOT / "validation" / "fe" / "cases.json").read_text())["cases"]
    body, group = [], ""
    for case in cases:
        limit = f"{'over ' if case['locks'] else ''}{100 * case['tolerance']:.3g}"
        numbers = (f"{case['computed']:.5g}", f"{case['theory']:.5g}", case["unit"], f"{100 * case['difference']:+.2f}")
        body.append([case["group"] if case["group"] != group else "", case["name"], *numbers, limit])
        group = case["group"]
    head = ["case", "what", "computed", "theory", "unit", "difference [%]", "allowed [%]"]
    return rows(head, body, left=2)


def convergence_table() -> str:
    """Tabulate the bend over mesh and order, as validation/fe/convergence.py stored it."""
    body = []
    for row in _convergence():
        reached = dict(zip(row["pressure_kpa"], row["bend_deg"], strict=True))
        bends = [f"{reached[pressure]:.2f}" if pressure in reached else "" for pressure in (50, 100, 250)]
        sizes = (f"{row['order']}", f"{row['poisson']:g}", f"{row['elements']:,}", f"{row['unknowns']:,}")
        steps, cost = sum(row["iterations"]), row["seconds"]
        body.append([row["joint"], row["mesh"], *sizes, *bends, f"{cost:.0f}", f"{steps}", f"{cost / steps:.1f}"])
    head = ["joint", "mesh", "order", "ν", "tetrahedra", "unknowns", "50 kPa [deg]", "100 kPa [deg]", "250 kPa [deg]"]
    return rows([*head, "time [s]", "Newton steps", "s per step"], body, left=2)


def nested_table() -> str:
    """Tabulate the bend over nested spaces, as validation/fe/nested.py stored it, with order, limit and index."""
    body = []
    for name, series in json.loads((ROOT / "data" / "fe" / "nested.json").read_text()).items():
        found, levels = series["convergence_bend_deg"], series["levels"]
        told = ["", "", ""]
        if found is not None:
            told = [f"{found['order']:.1f}", f"{found['limit']:.2f}", f"{found['index_percent']:.2g}"]
        for k, level in enumerate(levels):
            sizes = (f"{level['order']}", f"{level['elements']:,}", f"{level['unknowns']:,}")
            seen = (f"{level['bend_deg']:.2f}", f"{level['energy_mj']:.2f}", f"{level['seconds']:.0f}")
            body.append([name.split()[0], *sizes, *seen, *(told if k == len(levels) - 1 else ["", "", ""])])
    head = ["joint", "order", "tetrahedra", "unknowns", "bend [deg]", "energy [mJ]", "time [s]"]
    return rows([*head, "observed order", "limit [deg]", "index [%]"], body, left=1)


def volume_table() -> str:
    """Tabulate the volume ratio J away from the ends, as validation/fe/convergence.py stored it."""
    body = []
    for row in _convergence():
        for pressure, seen in zip(row["pressure_kpa"], row.get("volume_ratio", ()), strict=False):
            thousandths = f"{seen['low']:.3f} to {seen['high']:.3f}"
            ends = f"{seen['min']:.3f} to {seen['max']:.3f}"
            sizes = (f"{row['order']}", f"{row['poisson']:g}", f"{pressure:g}")
            part, place = f"{seen['not_kept_percent']:.3f}", f"{seen['at_hose']:.2f}"
            body.append([row["joint"], row["mesh"], *sizes, part, thousandths, ends, place])
    head = ["joint", "mesh", "order", "ν", "pressure [kPa]", "volume beyond 2 % [%]", "99.8 % of the volume"]
    return rows([*head, "all", "largest at [radii]"], body, left=2)


def _convergence() -> list[dict[str, Any]]:
    """Return the results that validation/fe/convergence.py stored."""
    found: list[dict[str, Any]] = json.loads((ROOT / "validation" / "fe" / "convergence.json").read_text())
    return found


MEMBERS = (  # name, modulus [GPa] and section of parts that may lie on a joint's axis
    ("polyimide film, 6.35 × 0.125 mm", 2.5, partial(film, 6.35e-3, 0.125e-3)),
    ("polyester film, 6.35 × 0.43 mm", 4.9, partial(film, 6.35e-3, 0.43e-3)),
    ("polyethylene pipe, 4 × 2.5 mm", 0.2, partial(pipe, 4e-3, 2.5e-3)),
    ("polyamide pipe, 4 × 2.5 mm", 1.4, partial(pipe, 4e-3, 2.5e-3)),
    ("polyamide pipe, 6 × 4 mm", 1.4, partial(pipe, 6e-3, 4e-3)),
    ("silicone hose, 6 × 4 mm", 0.003, partial(pipe, 6e-3, 4e-3)),
)


def member_table() -> str:
    """Tabulate stiffness and buckling load of `MEMBERS` in the matrix of the shipped robot."""
    robot, body = load("hypertuna"), []
    silicone = mooney(robot, drive_unit(robot).matrix).modulus
    for name, modulus, member in MEMBERS:
        one = member(1e9 * modulus, silicone)
        sizes = (f"{modulus:g}", f"{one.stiffness:,.0f}", f"{one.bending:.2g}")
        body.append([name, *sizes, f"{one.buckling:.1f}", f"{1e3 * one.wavelength:.0f}"])
    head = ["member", "E [GPa]", "E A [N]", "E I [N m²]", "buckles at [N]", "in waves of [mm]"]
    return rows(head, body, left=1)


def compression_table() -> str:
    """Tabulate the compression of an axis that keeps its length."""
    robot, body = load("hypertuna"), []
    for group in robot.joints:
        highest = group.pressure_max or 0.0
        found = held_compression(robot, group.name, [[highest, 0.0], [highest, highest]])
        body.append([group.name, f"{highest / 1e3:.0f}", *(f"{force:.0f}" for force in found)])
    return rows(["joint", "pressure [kPa]", "on one side [N]", "on both sides [N]"], body, left=1)


TABLES: dict[str, Callable[[], str]] = {
    "axis members": member_table,
    "axis compression": compression_table,
    "fe bends": bend_table,
    "fe states": state_table,
    "fe apart": apart_table,
    "fe runs": run_table,
    "fe cases": case_table,
    "fe convergence": convergence_table,
    "fe nested": nested_table,
    "fe volume": volume_table,
}
PICTURES: dict[str, Any] = {}
