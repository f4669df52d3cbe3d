"""The finite-element model of section III.B: stored bends of both joints, beside the fast model."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.actuation.bending import Bend, bend, straightness
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import drive_unit, joint_group, joint_models
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.fe.bend import described_bend, fe_bend
from hypertuna.fe.model import FeOptions
from hypertuna.fe.states import States, apart, fast_states, holding_moment
from hypertuna.io.files import shipped
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.chapters.actuator import LINES, line_findings
from hypertuna.paper.ledger import Finding
from hypertuna.reports.html import WIDTH, Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FE = "finite elements"
ROBOT = "hypertuna"
MESH = "medium"  # name of the mesh of stored results
PRESSURES = "0:250:6"  # kPa
FAST_ALONE = {"friction", "stiffness_factor"}  # keys that only the fast model uses
AGAIN = "validation/fe/ledger.py computes it again"  # which command repeats stored results, for reasons
NESTED = "nested.json"  # stored series of nested spaces of displacements


@dataclass(frozen=True)
class Solved:
    """One joint by finite elements, beside the fast model of the same description."""

    robot: Robot
    joint: str
    record: Mapping[str, Any] | None  # from ``hypertuna fe bend --json``; None where there is no valid one
    reason: str = ""  # why there is none, or why it was not computed again; without a full stop
    maps: tuple[Mapping[str, Any], ...] = ()  # from ``hypertuna fe map --json``
    nested: tuple[Mapping[str, Any], ...] = ()  # series of nested spaces, from validation/fe/nested.py

    def column(self, key: str) -> Array:
        """Return a number of the record at every pressure, shape (n,)."""
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
    def fast(self) -> Bend:
        """Bend by the fast model at the same pressures, also without friction."""
        return bend(self.robot, self.joint, self.pressure, friction=False)

    @property
    def r_squared(self) -> float:
        """Coefficient of determination of a line through the bend over 100 to 250 kPa [1]."""
        return straightness(self.pressure, self.angle)

    @property
    def difference(self) -> Array:
        """Bend of the fast model over that of finite elements, less 1, shape (n,) [1]; 0 without pressure."""
        return self._ratio_less_one(self.fast.angle, self.angle)

    @property
    def oil_difference(self) -> Array:
        """Oil taken in by the fast model over that by finite elements, less 1, shape (n,) [1]; 0 without pressure."""
        return self._ratio_less_one(1e6 * self.fast.volume, self.column("oil_taken_ml"))

    def _ratio_less_one(self, ours: Array, theirs: Array) -> Array:
        """Return ours over theirs, less 1, shape (n,) [1]; 0 without pressure."""
        no_pressure = self.pressure == 0
        return np.where(no_pressure, 0.0, ours / np.where(no_pressure, 1.0, theirs) - 1)

    @property
    def points(self) -> tuple[Array, States]:
        """All states of finite elements: pairs of pressures (n, 2) [Pa], and states (1, n)."""
        assert self.record is not None
        volume = np.stack([1e-6 * self.column(f"volume_{side}_ml") for side in SIDES], axis=1)
        pressure = [np.stack([self.pressure, 0 * self.pressure], axis=1)]
        parts = [(self.angle, 0 * self.angle, volume, self.column("length_mm") / 1e3)]
        for stored_map in self.maps:
            elements = {key: np.array(value, float) for key, value in stored_map["elements"].items()}
            pairs = 1e3 * np.stack([np.array(stored_map[f"pressure_{side}_kpa"], float) for side in SIDES], axis=1)
            pressure.append(np.tile(pairs, (len(elements["angle_deg"]), 1)))
            oil = np.stack([1e-6 * elements[f"volume_{side}_ml"] for side in SIDES], axis=-1).reshape(-1, 2)
            others = (elements["moment_n_m"].ravel(), oil, elements["length_mm"].ravel() / 1e3)
            parts.append((np.radians(elements["angle_deg"].ravel()), *others))
        columns = (np.concatenate(column)[None] for column in zip(*parts, strict=True))
        return np.concatenate(pressure), States(*columns)

    @property
    def over_points(self) -> dict[str, float]:
        """Largest differences of moment and volume over all states, as `JointMap` has them [1]."""
        model = next(model for model in joint_models(self.robot) if model.name == self.joint)
        pressure, elements = self.points
        beside = fast_states(self.robot, model, pressure, elements)
        straight = abs(holding_moment(model, 0.0, (pressure.max(), 0.0)))
        scale = float(np.nanmax(elements.volume) - np.nanmin(elements.volume))
        return {
            "moment": apart(elements, beside, "moment") / straight,
            "volume": apart(elements, beside, "volume") / scale,
        }


@dataclass(frozen=True)
class Elements:
    """Results of finite elements for both joints of the paper's robot, and pictures."""

    solved: dict[str, Solved]  # by joint
    pictures: dict[str, bytes]  # deformed shapes as PNG, by joint


def command(joint: str, mesh: str = MESH) -> list[str]:
    """Return the arguments of the command whose output is the stored result."""
    return ["fe", "bend", "--robot", ROBOT, "--joint", joint, "--pressure", PRESSURES, "--mesh", mesh, "--json"]


def joint_hash(robot: Robot, joint: str) -> str:
    """Return a hash of all values of the description that the finite-element model of a joint uses."""
    group, actuator = joint_group(robot, joint)
    parts = [part.model_dump(mode="json", by_alias=True, exclude=FAST_ALONE) for part in (drive_unit(robot), actuator)]
    materials = {name: material.model_dump(mode="json", by_alias=True) for name, material in robot.materials.items()}
    content = json.dumps([*parts, materials, group.drive_units], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()


def read_elements() -> Elements:
    """Return the stored results, without those for another description, with the reason."""
    folder, robot = shipped("data/fe"), load(ROBOT)
    names = [group.name for group in robot.joints]
    nested = json.loads((folder / NESTED).read_text("utf-8")) if (folder / NESTED).is_file() else {}
    solved = {}
    for joint in names:
        series = tuple(one for one in nested.values() if one["joint_hash"] == joint_hash(robot, joint))
        solved[joint] = replace(_checked(robot, joint, *_stored(folder, joint)), nested=series)
    pictures = {joint: folder / f"{joint}.png" for joint in names}
    return Elements(solved, {joint: path.read_bytes() for joint, path in pictures.items() if path.is_file()})


def _stored(folder: Path, joint: str) -> Iterator[Any]:
    """Yield the stored bend of a joint, or None, then its stored maps."""
    file = folder / f"{ROBOT}-{joint}.json"
    yield json.loads(file.read_text("utf-8")) if file.is_file() else None
    for path in sorted(folder.glob(f"{ROBOT}-{joint}-map*.json")):
        yield json.loads(path.read_text("utf-8"))


def _checked(robot: Robot, joint: str, record: Mapping[str, Any] | None, *maps: Mapping[str, Any]) -> Solved:
    """Return a joint's stored result, without a record if that is invalid or stale, and the maps of the same joint."""
    valid_maps = tuple(one for one in maps if one["joint_hash"] == joint_hash(robot, joint))
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
    return Solved(robot, joint, None if reason else record, reason, valid_maps)


def solve_elements(stored: Elements, progress: Callable[[], None]) -> Elements:
    """Return all results computed again, where the extra `fe` is installed."""
    solved = {}
    for joint, solution in stored.solved.items():
        solved[joint] = _solved(solution)
        progress()
    return Elements(solved, stored.pictures)


def _solved(stored: Solved) -> Solved:
    """Return a joint's result computed again, or else the stored one with the reason."""
    low, high, count = map(int, PRESSURES.split(":"))
    pressure = 1e3 * np.linspace(low, high, count)
    try:
        result = fe_bend(stored.robot, stored.joint, pressure, options=FeOptions(mesh=MESH))
    except InputError as error:
        reasons = filter(None, (stored.reason, f"not computed again: {error}".rstrip(".")))
        return replace(stored, reason="; ".join(reasons))
    record = result.record() | {"joint_hash": joint_hash(stored.robot, stored.joint)}
    return replace(_checked(stored.robot, stored.joint, record, *stored.maps), nested=stored.nested)


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Elements:
    """Return the stored results; in full compute them again."""
    return solve_elements(read_elements(), step) if full else read_elements()


def findings(elements: Elements) -> Iterator[Finding]:
    """Yield the bend of each joint at the largest pressure, and how straight its curve is."""
    for joint, solution in elements.solved.items():
        angle = None if solution.record is None else float(np.degrees(solution.angle[-1]))
        yield Finding(f"fe/bending-{joint}", FE, "calibrated", angle, _note(solution))
        if solution.record is None:
            yield from (Finding(f"{key}-{joint}", FE, "prediction", None, solution.reason) for key in LINES)
        else:
            yield from line_findings(joint, FE, solution.pressure, solution.angle)


def sections(elements: Elements) -> list[Section]:
    """Show the deformed joints, their bends beside the fast model's, and the differences, if any are stored."""
    solved = {joint: one for joint, one in elements.solved.items() if one.record is not None}
    if not solved:
        return []
    shapes = {joint: png for joint, png in elements.pictures.items() if joint in solved}
    table = difference_table(elements)
    return compose(
        "finite_elements",
        {f"fe-shape-{joint}": png for joint, png in shapes.items()}
        | {f"fe-bend-{joint}": _curve(joint, one) for joint, one in solved.items()}
        | ({"bends": table} if table else {}),
        robot=ROBOT,
        angles=_angles(elements),
        shapes=shapes,
        curves=solved,
        nested={joint: "; ".join(map(nested_text, one.nested)) for joint, one in solved.items() if one.nested},
        command=lambda joint: " ".join(command(joint)[:-1]),
    )


def difference_table(elements: Elements) -> Table | None:
    """Tabulate bends by elements and fast model at each pressure; None where a joint has no result."""
    if any(one.record is None for one in elements.solved.values()):
        return None
    columns = [_cells(one) for one in elements.solved.values()]
    pressures = [f"{pressure / 1e3:g}" for pressure in next(iter(elements.solved.values())).pressure]
    rows = [[pressure, *itertools.chain(*cells)] for pressure, *cells in zip(pressures, *columns, strict=True)]
    heads = [f"{joint}: {what}" for joint in elements.solved for what in ("elements [deg]", "fast [deg]", "difference")]
    return Table(["pressure [kPa]", *heads], rows)


def _cells(solved: Solved) -> list[list[str]]:
    """Return a joint's bends in both models and their difference, at every pressure."""
    angles = zip(np.degrees(solved.angle), np.degrees(solved.fast.angle), solved.difference, strict=True)
    cells = [[f"{mesh:z.1f}", f"{fast:z.1f}", f"{100 * diff:+.0f} %"] for mesh, fast, diff in angles]
    cells[0][2] = ""  # without pressure
    return cells


def _note(solved: Solved) -> str:
    """Describe a joint's result: its geometry, straightness, mesh and convergence; or why there is none."""
    if solved.record is None:
        return solved.reason
    record = solved.record
    geometry = "the geometry, which is not published, was chosen to match both angles"
    mesh = f"{record['mesh']} mesh of {record['elements']:,} tetrahedra, {record['seconds']:.0f} s, stored"
    line = f"a line through 100 to 250 kPa has R² = {solved.r_squared:.3f}"
    convergence = "; ".join(map(nested_text, solved.nested))
    return "; ".join(filter(None, (f"{geometry}. {line[0].upper()}{line[1:]}", mesh, convergence, solved.reason)))


def nested_text(series: Mapping[str, Any]) -> str:
    """Describe how the bend converges over nested spaces: its values, observed order, limit and index."""
    levels, convergence = series["levels"], series["convergence_bend_deg"]
    kind = "bisected meshes" if levels[-1]["bisections"] else "rising orders"
    bends = ", ".join(f"{level['bend_deg']:.2f}" for level in levels)
    text = f"{kind} at {series['pressure_kpa']:g} kPa bend by {bends} deg"
    if convergence is None:
        return f"{text}, which tell no limit"
    limit = f"a limit of {convergence['limit']:.2f} deg with the observed order {convergence['order']:.1f}"
    return f"{text}: {limit}, grid convergence index {convergence['index_percent']:.2g} %"


def _curve(joint: str, solved: Solved) -> Figure:
    """Draw a joint's bend over the pressure."""
    from hypertuna.fe.plots import plot_fe_bend

    pressures = np.linspace(0, solved.pressure[-1], 51)
    fast = bend(solved.robot, joint, pressures, friction=False)
    return plot_fe_bend(
        solved.pressure,
        solved.angle,
        analytic=(pressures, fast.angle, fast.volume),
        published=described_bend(solved.robot, joint),
        width=WIDTH,
    )


def _angles(elements: Elements) -> str:
    """Describe how far the joints bend in both models; empty where a result is missing."""
    joints = elements.solved
    if any(one.record is None for one in joints.values()):
        return ""
    last_angles = [[one.angle[-1], one.fast.angle[-1]] for one in joints.values()]
    by_elements, by_fast = (" and ".join(f"{angle:.1f}" for angle in column) for column in np.degrees(last_angles).T)
    pressure_max = max(float(one.pressure[-1]) for one in joints.values()) / 1e3
    text = f"elements bend joints {' and '.join(joints)} by {by_elements} deg at {pressure_max:g} kPa"
    return f"{text}, the fast model without friction by {by_fast}"


CHAPTER = Chapter("elements", sections, findings, compute, full_steps=3)
