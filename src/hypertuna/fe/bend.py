"""Bend of a soft joint under rising pressure, by finite elements."""

from __future__ import annotations

import math
import time
import zlib
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.actuation.bending import check_pressure, check_side, straightness
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import drive_unit, joint_group
from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.fe.measure import Measured, measure
from hypertuna.fe.model import FeModel, FeOptions, equilibrium, fe_model
from hypertuna.io.checkpoint import Journal
from hypertuna.io.door import read_bytes
from hypertuna.io.files import dataset, write_atomically

if TYPE_CHECKING:
    import xarray as xr

JOURNAL = "journal.jsonl"  # file of the journal in the folder of a run
SUMMARY = "bend.json"  # file of the record in the folder of a run
STRAIN, STRESS = "largest principal logarithmic strain of the matrix", "largest von Mises stress of the matrix"
SCALARS = {  # fields of `Measured` in a dataset: unit and meaning
    "strain_max": ("1", STRAIN),
    "strain_99": ("1", "99 % quantile of that strain over the matrix"),
    "stress_max": ("Pa", STRESS),
    "stress_99": ("Pa", "99 % quantile of that stress over the matrix"),
}

Each = Callable[[FeModel, int, Measured], None]  # called at each pressure: model, index of the pressure, measurements


@dataclass(frozen=True)
class FeBend(Plotted, Tabular, data=lambda bend: bend.record()["steps"]):
    """Bend of a joint under the pressure of one side, in three dimensions and without friction."""

    robot: Robot
    joint: str  # joint group
    side: str  # side under pressure
    options: FeOptions
    pressure: Array  # (n,) rising gauge pressures that converged [Pa]
    measured: tuple[Measured, ...]  # measurements at each pressure
    iterations: tuple[int, ...]  # Newton steps to each pressure from the one before
    seconds: tuple[float, ...]  # processor time for each pressure [s]
    elements: int  # number of elements
    unknowns: int  # number of unknowns
    status: str  # "converged", or "failed" at a pressure
    status_text: str  # the status as a sentence, with pressure and reason of a failure

    @property
    def material(self) -> str:
        """Material set of the options, else of the robot."""
        return self.options.material_of(self.robot)

    @property
    def angle(self) -> Array:
        """Angle toward the side with the pressure [rad], shape (n,)."""
        sign = 1 if self.side == "left" else -1
        return sign * np.array([state.angle for state in self.measured])

    @property
    def volume(self) -> Array:
        """Oil in the drive units of the side with the pressure [m^3], shape (n,)."""
        return np.array([state.volume[SIDES.index(self.side)] for state in self.measured])

    @property
    def oil(self) -> Array:
        """Oil taken in since rest by the side with the pressure [m^3], shape (n,).

        It follows from the ratio of the volumes inside the braids, now and at rest on the same mesh, since the channels
        of a mesh are round to 1e-4 only.
        """
        group, actuator = joint_group(self.robot, self.joint)
        hose_volume = math.pi * (drive_unit(self.robot).outer_diameter / 2) ** 2 * sum(actuator.segment_length)
        swelling = np.array([state.swelling[SIDES.index(self.side)] for state in self.measured])
        return (swelling - 1) * (group.drive_units or 0) * hose_volume

    def r_squared(self) -> float:
        """Return the coefficient of determination of a line through the angle over the pressure [1]."""
        return straightness(self.pressure, self.angle)

    def record(self) -> dict[str, Any]:
        """Return all numbers by names with units; the list "steps" has a record for each pressure."""
        r_squared = self.r_squared()
        facts = {"ngsolve_version": ngsolve_version(), "joint": self.joint, "side": self.side}
        numbers = {
            "elements": self.elements,
            "unknowns": self.unknowns,
            "seconds": sum(self.seconds),
            "status": self.status,
            "status_text": self.status_text,
            "r_squared": None if math.isnan(r_squared) else r_squared,
        }
        columns = {
            "pressure_kpa": (self.pressure / 1e3).tolist(),
            "bend_deg": [math.degrees(angle) for angle in self.angle],
            "oil_taken_ml": (1e6 * self.oil).tolist(),
        }
        steps = [
            dict(zip(columns, values, strict=True)) | state.record() | {"iterations": iterations, "seconds": seconds}
            for *values, state, iterations, seconds in zip(
                *columns.values(), self.measured, self.iterations, self.seconds, strict=True
            )
        ]
        origin = provenance(self.robot, water=False)
        return origin | facts | self.options.facts(self.robot) | numbers | {"steps": steps}

    def dataset(self) -> xr.Dataset:
        """Return all numbers as a labeled dataset."""
        variables = {
            "angle": ("pressure", self.angle, "rad", "angle toward the side with the pressure"),
            "volume": ("pressure", self.volume, "m^3", "oil in the drive units of that side"),
        }
        for name, (unit, text) in SCALARS.items():
            values = np.array([getattr(state, name) for state in self.measured], dtype=np.float64)
            variables[name] = ("pressure", values, unit, text)
        coordinates = {"pressure": ("pressure", self.pressure, "Pa", "gauge pressure")}
        facts = {"joint": self.joint, "side": self.side, "material": self.material, "status": self.status_text}
        facts |= {"elements": str(self.elements), "unknowns": str(self.unknowns), "ngsolve": ngsolve_version()}
        return dataset(variables, coordinates, provenance(self.robot, water=False) | facts)


def described_bend(robot: Robot, joint: str) -> tuple[float, float] | None:
    """Return largest pressure [Pa] and largest bend [rad] in a joint's description; None if either is missing."""
    group, _ = joint_group(robot, joint)
    return None if group.pressure_max is None or group.bend_max is None else (group.pressure_max, group.bend_max)


def ngsolve_version() -> str:
    """Return the version of NGSolve, empty if it is not installed."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed("ngsolve")
    except PackageNotFoundError:
        return ""


def fe_bend(
    robot: Robot,
    joint: str | int,
    pressure: ArrayLike,
    *,
    side: str = "left",
    options: FeOptions | None = None,
    folder: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    each: Each | None = None,
    work: str = "fe bend",
) -> FeBend:
    """Compute the bend of a joint by finite elements, from rest, at rising pressures (n,) [Pa] of one side.

    `folder` keeps a journal and the states, from which the same call resumes; `each` is called at every new pressure;
    `work` names the kind of work in the journal.
    """
    rising, options = check_pressure(pressure), options or FeOptions()
    check_side(side)
    model = fe_model(robot, joint, options)
    group, _ = joint_group(robot, joint)
    directory = None if folder is None else Path(folder)
    facts = {"joint": group.name, "side": side, "ngsolve": ngsolve_version()} | options.facts(robot)
    steps: list[dict[str, Any]] = []
    with Journal(directory / JOURNAL if directory else None, journal_header(work, robot, facts)) as journal:
        _check_course(journal, directory, rising)
        for k, value in enumerate(rising.tolist()):

            def reach(k: int = k, value: float = value) -> dict[str, Any]:
                former = float(rising[k - 1]) if k else 0.0
                if max(load.Get() for load in model.problem.loads[:2]) != former:
                    _restore(model, directory, k - 1, _loads(former, side), steps[k - 1].get("state") if k else None)
                return _reach(model, directory, k, _loads(value, side), each)

            steps.append(journal.answer({"pressure": value}, reach))
            if progress is not None:
                progress(k + 1, len(rising))
            if steps[-1]["fault"]:
                break
    reached = [step for step in steps if not step["fault"]]
    return FeBend(
        robot=robot,
        joint=group.name,
        side=side,
        options=options,
        pressure=rising[: len(reached)],
        measured=tuple(Measured(**_tuples(step["measured"])) for step in reached),
        iterations=tuple(step["iterations"] for step in reached),
        seconds=tuple(step["seconds"] for step in reached),
        elements=int(model.mesh.ne),
        unknowns=model.unknowns,
        status="failed" if steps[-1]["fault"] else "converged",
        status_text=_status_text(rising, len(reached), steps[-1]["fault"]),
    )


def _status_text(pressure: Array, reached: int, fault: str) -> str:
    """Return a sentence on the number of pressures [Pa] that were reached, and on the failure at the next one."""
    if not fault:
        subjects = {1: "The pressure was", 2: "Both pressures were"}
        return f"{subjects.get(reached, f'All {reached} pressures were')} reached."
    extent = f"results end at {pressure[reached - 1] / 1e3:g} kPa" if reached else "there are no results"
    return f"{pressure[reached] / 1e3:g} kPa was not reached ({fault}); {extent}."


def _check_course(journal: Journal, place: Path | None, rising: Array) -> None:
    """Check that the rising pressures [Pa] begin with all pressures of the journal."""
    for k, record in enumerate(journal.records):
        asked, new = record.get("asked"), float(rising[k]) if k < len(rising) else None
        stored = asked.get("pressure") if isinstance(asked, dict) else None
        if isinstance(stored, float) and stored != new:  # the journal itself refuses other questions
            text = "none now" if new is None else f"{new / 1e3:g} kPa now"
            rule = f"has {stored / 1e3:g} kPa as pressure {k + 1}, but --pressure has {text}"
            fix = "a run may add higher pressures, but neither omit nor change one: give another folder"
            raise InputError(rule, file=None if place is None else str(place / JOURNAL), fix=fix)


def _loads(value: float, side: str) -> tuple[float, float]:
    """Return the pressures of the left and right sides [Pa], given the pressure of one side."""
    return (value, 0.0) if side == "left" else (0.0, value)


def _reach(model: FeModel, place: Path | None, k: int, loads: tuple[float, float], each: Each | None) -> dict[str, Any]:
    """Bring the model to a pair of pressures [Pa], store its displacements, and return its measurements."""
    start = time.process_time()
    result = equilibrium(model, pressure=loads)
    measured = measure(model) if result.converged else None
    fault = result.text if measured is None else measured.fault
    seconds = time.process_time() - start
    state = np.asarray(model.problem.state.vec).tobytes()
    if not fault and place is not None:
        write_atomically(_state(place, k), state)
    if measured is not None and not fault and each is not None:
        each(model, k, measured)
    record = {"fault": fault, "iterations": result.iterations, "seconds": seconds, "state": zlib.crc32(state)}
    return record | {"measured": None if measured is None else asdict(measured)}


def _state(place: Path, k: int) -> Path:
    """Return the path of the file with the displacements at the k-th pressure."""
    return place / f"state-{k:03d}.bin"


def _restore(model: FeModel, place: Path | None, k: int, loads: tuple[float, float], checksum: int | None) -> None:
    """Set the model to the stored state of the k-th pressure, and check it against the journal's checksum."""
    if place is None:
        raise RuntimeError("a journal in memory has no stored states")
    path, fix = _state(place, k), "remove the folder to start over"
    content = read_bytes(path, "state")
    count = len(model.problem.state.vec)
    if len(content) != 8 * count:
        rule = f"must hold {count} finite numbers of 8 bytes"
        raise InputError(rule, file=str(path), value=f"{len(content)} bytes", fix=fix)
    if zlib.crc32(content) != checksum:
        raise InputError("is damaged: it is not what the journal tells", file=str(path), fix=fix)
    np.asarray(model.problem.state.vec)[:] = np.frombuffer(content)
    for load, pressure in zip(model.problem.loads, (*loads, 0.0), strict=True):
        load.Set(pressure)


def _tuples(record: dict[str, Any]) -> dict[str, Any]:
    """Return a record of the journal with tuples in place of lists."""
    return {key: tuple(value) if isinstance(value, list) else value for key, value in record.items()}
