"""The finite-element model of section III.B: stored bends of both joints, beside the analytic model."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.actuation.bending import Bend, bend, straightness
from hypertuna.actuation.soft_joint import drive_unit, joint_group
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.fe.bend import described_bend, fe_bend
from hypertuna.fe.model import FeOptions
from hypertuna.io.files import shipped
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.ledger import Class, Finding
from hypertuna.reports.html import WIDTH, Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FE = "finite elements"
ROBOTS = {FE: "hypertuna-fe", f"{FE}, geometry of hypertuna": "hypertuna"}  # by the name of the model in the ledger
MESH = "medium"
PRESSURES = "0:250:6"  # kPa
ANALYTIC_ALONE = {"sleeve", "friction", "stiffness_factor"}  # values that elements do not use
AGAIN = "validation/fe/ledger.py computes it again"


@dataclass(frozen=True)
class Solved:
    """Bend of one joint by finite elements, beside the analytic model of the same description."""

    robot: Robot
    joint: str
    record: Mapping[str, Any] | None  # from ``hypertuna fe bend --json``; None where there is no valid one
    reason: str = ""  # why there is none, or why it was not computed again; without a full stop

    def column(self, key: str) -> Array:
        """Return a number of the record for every pressure, shape (n,)."""
        assert self.record is not None
        return np.array([step[key] for step in self.record["steps"]], float)

    @property
    def pressure(self) -> Array:
        """Gauge pressures, shape (n,) [Pa]."""
        return 1e3 * self.column("pressure_kpa")

    @property
    def angle(self) -> Array:
        """Bends, shape (n,) [rad]."""
        return np.radians(self.column("bend_deg"))

    @property
    def analytic(self) -> Bend:
        """The analytic model at the same pressures, with friction as described, on the way up."""
        return bend(self.robot, self.joint, self.pressure)

    @property
    def r_squared(self) -> float:
        """Coefficient of determination of a line over 100 to 250 kPa, as tested [1]."""
        return straightness(self.pressure, self.angle)

    @property
    def difference(self) -> Array:
        """Bend of the analytic model over that of finite elements, less 1, shape (n,) [1]; 0 without pressure."""
        still = self.pressure == 0
        return np.where(still, 0.0, self.analytic.angle / np.where(still, 1.0, self.angle) - 1)


@dataclass(frozen=True)
class Elements:
    """Results of finite elements for the paper's robot."""

    solved: dict[str, dict[str, Solved]]  # by model of the ledger, as in `ROBOTS`, and joint
    pictures: dict[str, bytes]  # deformed shapes of the first model's joints as PNG, by joint


def command(robot: str, joint: str, mesh: str = MESH) -> list[str]:
    """Return the arguments of the command whose output is stored."""
    return ["fe", "bend", "--robot", robot, "--joint", joint, "--pressure", PRESSURES, "--mesh", mesh, "--json"]


def joint_hash(robot: Robot, joint: str) -> str:
    """Return a hash of everything that the finite-element model of a joint takes from the description."""
    group, actuator = joint_group(robot, joint)
    parts = [
        part.model_dump(mode="json", by_alias=True, exclude=ANALYTIC_ALONE) for part in (drive_unit(robot), actuator)
    ]
    materials = {name: material.model_dump(mode="json", by_alias=True) for name, material in robot.materials.items()}
    content = json.dumps([*parts, materials, group.drive_units], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()


def read_elements() -> Elements:
    """Read the stored results; one that was computed for another description is left out, with the reason."""
    folder = shipped("data/fe")
    solved: dict[str, dict[str, Solved]] = {}
    for model, robot in ((model, load(name)) for model, name in ROBOTS.items()):
        paths = {group.name: folder / f"{robot.name}-{group.name}.json" for group in robot.joints}
        records = {joint: json.loads(path.read_text("utf-8")) for joint, path in paths.items() if path.is_file()}
        solved[model] = {joint: _checked(robot, joint, records.get(joint)) for joint in paths}
    pictures = {path.stem: path.read_bytes() for path in sorted(folder.glob("*.png"))}
    return Elements(solved, {joint: pictures[joint] for joint in solved[FE] if joint in pictures})


def _checked(robot: Robot, joint: str, record: Mapping[str, Any] | None) -> Solved:
    """Return a stored result if it is valid."""
    reason = ""
    if record is None:
        reason = f"no result is stored; {AGAIN}"
    elif record["joint_hash"] != joint_hash(robot, joint):
        reason = f"the stored result belongs to another joint {joint} than the one in {robot.file}; {AGAIN}"
    elif record["status"] != "converged":
        reason = record["status_text"].rstrip(".")
    else:
        for key, value in FeOptions(mesh=MESH).facts(robot).items():  # on which `command` relies
            if record[key] != value:
                reason = f"the stored result has {key} = {record[key]}, but it is {value} now; {AGAIN}"
    return Solved(robot, joint, None if reason else record, reason)


def solve_elements(stored: Elements, progress: Callable[[], None]) -> Elements:
    """Compute every stored result again, where the extra `fe` is installed."""
    solved: dict[str, dict[str, Solved]] = {model: {} for model in stored.solved}
    for model, one in ((model, one) for model, joints in stored.solved.items() for one in joints.values()):
        solved[model][one.joint] = _solved(one)
        progress()
    return Elements(solved, stored.pictures)


def _solved(stored: Solved) -> Solved:
    """Compute a joint again, or return the stored result with the reason."""
    low, high, count = map(int, PRESSURES.split(":"))
    pressure = 1e3 * np.linspace(low, high, count)
    try:
        result = fe_bend(stored.robot, stored.joint, pressure, options=FeOptions(mesh=MESH))
    except InputError as error:
        reasons = filter(None, (stored.reason, f"not computed again: {error}".rstrip(".")))
        return Solved(stored.robot, stored.joint, stored.record, "; ".join(reasons))
    record = result.record() | {"joint_hash": joint_hash(stored.robot, stored.joint)}
    return _checked(stored.robot, stored.joint, record)


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Elements:
    """Read the stored results; in full compute them again."""
    return solve_elements(read_elements(), step) if full else read_elements()


def findings(elements: Elements) -> Iterator[Finding]:
    """Yield the bend of each joint at the largest pressure, and how far the analytic model is from it."""
    for model, joints in elements.solved.items():
        for joint, one in joints.items():
            angle = None if one.record is None else float(np.degrees(one.angle[-1]))
            class_: Class = "calibrated" if model == FE else "prediction"
            yield Finding(f"fe/bending-{joint}", model, class_, angle, _note(model, one))
        yield _difference(model, joints)


def sections(elements: Elements) -> list[Section]:
    """Show the deformed joints, their bends beside the analytic model's, and the differences, if any are stored."""
    solved = {joint: one for joint, one in elements.solved[FE].items() if one.record is not None}
    if not solved:
        return []
    shapes = {joint: png for joint, png in elements.pictures.items() if joint in solved}
    tables = {ROBOTS[model]: difference_table(elements, model) for model in elements.solved}
    return compose(
        "finite_elements",
        {f"fe-shape-{joint}": png for joint, png in shapes.items()}
        | {f"fe-bend-{joint}": _curve(joint, one) for joint, one in solved.items()}
        | {robot: table for robot, table in tables.items() if table},
        described=[(ROBOTS[model], text) for model in elements.solved if (text := _angles(elements, model))],
        shapes=shapes,
        curves=solved,
        command=lambda joint: " ".join(command(ROBOTS[FE], joint)[:-1]),
    )


def difference_table(elements: Elements, model: str = FE) -> Table | None:
    """Tabulate bends by finite elements and by the analytic model over the pressure; None where a joint has none."""
    joints = elements.solved[model]
    if any(one.record is None for one in joints.values()):
        return None
    columns = [_cells(one) for one in joints.values()]
    pressures = [f"{pressure / 1e3:g}" for pressure in next(iter(joints.values())).pressure]
    rows = [[pressure, *itertools.chain(*cells)] for pressure, *cells in zip(pressures, *columns, strict=True)]
    heads = [f"{joint}: {what}" for joint in joints for what in ("elements [deg]", "analytic [deg]", "difference")]
    folded = "" if model == FE else f"The same with the geometry of {ROBOTS[model]}"
    return Table(["pressure [kPa]", *heads], rows, folded=folded)


def _cells(one: Solved) -> list[list[str]]:
    """Return a joint's bends in both models and their difference, at every pressure."""
    angles = zip(np.degrees(one.angle), np.degrees(one.analytic.angle), one.difference, strict=True)
    cells = [[f"{ours:z.1f}", f"{beside:z.1f}", f"{100 * apart:+.0f} %"] for ours, beside, apart in angles]
    cells[0][2] = ""  # without pressure
    return cells


def _note(model: str, one: Solved) -> str:
    """Describe how a bend was computed."""
    if one.record is None:
        return one.reason
    record = one.record
    chosen = "the geometry with which the analytic model meets both angles"
    if model == FE:
        chosen = "the geometry, which is not published, was chosen so that both come out"
    made = f"{record['mesh']} mesh of {record['elements']:,} tetrahedra, {record['seconds']:.0f} s, stored"
    straight = f"a line through 100 to 250 kPa has R² = {one.r_squared:.3f}"
    return "; ".join(filter(None, (f"{chosen}. {straight[0].upper()}{straight[1:]}", made, one.reason)))


def _difference(model: str, joints: Mapping[str, Solved]) -> Finding:
    """Return the largest difference of the analytic model from finite elements with the same geometry [%]."""
    missing = [one.reason for one in joints.values() if one.record is None]
    if missing:
        return Finding("fe-vs-analytic", model, "prediction", None, missing[0])
    last = {joint: 100 * float(one.difference[-1]) for joint, one in joints.items()}
    text = ", ".join(f"joint {joint} {value:+.1f} %" for joint, value in last.items())
    note = f"bend of the analytic model over that of {FE} at {_top(joints):g} kPa, same description: {text}"
    return Finding("fe-vs-analytic", model, "prediction", max(last.values(), key=abs), note)


def _top(joints: Mapping[str, Solved]) -> float:
    """Return the largest pressure of all [kPa]."""
    return max(float(one.pressure[-1]) for one in joints.values()) / 1e3


def _curve(joint: str, one: Solved) -> Figure:
    """Draw a joint's bend over the pressure."""
    from hypertuna.fe.plots import plot_fe_bend

    fine = np.linspace(0, one.pressure[-1], 51)
    beside = bend(one.robot, joint, fine)
    return plot_fe_bend(
        one.pressure,
        one.angle,
        analytic=(fine, beside.angle, beside.volume),
        published=described_bend(one.robot, joint),
        width=WIDTH,
    )


def _angles(elements: Elements, model: str) -> str:
    """Describe how far the joints of a description bend in both models; empty where a result is missing."""
    joints = elements.solved[model]
    if any(one.record is None for one in joints.values()):
        return ""
    last = [[one.angle[-1], one.analytic.angle[-1]] for one in joints.values()]
    ours, beside = (" and ".join(f"{angle:.1f}" for angle in column) for column in np.degrees(last).T)
    text = f"elements bend joints {' and '.join(joints)} by {ours} deg at {_top(joints):g} kPa"
    return f"{text}, the analytic model by {beside}"


CHAPTER = Chapter("elements", sections, findings, compute, full_steps=5)
