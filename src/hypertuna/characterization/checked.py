"""Check of the chosen design of a family by finite elements, at the pressures of its bench."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import drive_unit, joint_group, joint_models
from hypertuna.arrays import Array
from hypertuna.characterization.data import BOTH, KINDS
from hypertuna.characterization.family import Family
from hypertuna.characterization.problem import blocked_moment, computed, held_at
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.fe.bend import ngsolve_version
from hypertuna.fe.joint_map import Joint, Pair, joint_by_elements
from hypertuna.fe.model import FeOptions

MESH = "coarse"  # default mesh
COUPLES = 2  # solutions, each with another couple, that find the couple which holds a joint straight
# Keys of a family's facts that the facts of a check keep.
FACTS = ("file", "line", "joint", "side", "branch", "pressure_kpa", "kind", "unit", "measured", "chosen")

Point = tuple[dict[str, float], str]  # values by kind [SI]; if there are none, the reason


@dataclass(frozen=True)
class Checked:
    """The chosen design of a family, computed by finite elements and by the fast model at each measured value.

    Finite elements have no friction, so they are compared with the fast model without friction.
    """

    family: Family
    options: FeOptions
    model: Array  # (elements,) values of the fast model without friction [SI]
    by_elements: Array  # (elements,) values of finite elements [SI]; NaN where they found no solution
    faults: tuple[str, ...]  # (elements,) why finite elements found no solution, as a sentence; empty if they did
    seconds: float

    @property
    def difference(self) -> Array:
        """Relative difference (elements,): fast model without friction minus finite elements; NaN at zero pressure."""
        at_rest = np.array([fact["pressure_kpa"] == 0 for fact in self.family.facts])
        reference = np.where(at_rest | (self.by_elements == 0), np.nan, self.by_elements)
        return np.asarray((self.model - self.by_elements) / reference)

    @property
    def facts(self) -> list[dict[str, Any]]:
        """Measured values, with the values of both models, in displayed units."""
        columns = (self.model, self.by_elements, 100 * self.difference)
        rows = []
        for fact, *values, fault in zip(self.family.facts, *columns, self.faults, strict=True):
            model, elements, difference = map(float, values)
            factor = KINDS[fact["kind"]].factor
            both = {"without_friction": factor * model, "elements": factor * elements, "difference_percent": difference}
            rows.append({key: fact[key] for key in FACTS} | both | {"fault": fault})
        return rows

    @property
    def record(self) -> dict[str, Any]:
        """Record of the check, for JSON."""
        options = {"ngsolve_version": ngsolve_version()} | self.options.facts(self.family.space.robot)
        return options | {"facts": self.facts, "seconds": self.seconds}


def check_chosen(
    family: Family,
    options: FeOptions | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
    solve: Callable[[Robot, int, FeOptions], Joint] = joint_by_elements,
) -> Checked:
    """Solve the chosen design of a family by finite elements, at the pressures of its bench.

    progress: called with solutions done and total. solve: makes the solver of a joint.
    """
    started, bench, chosen = time.monotonic(), family.space.bench, family.members[family.middle].robot
    unit = drive_unit(chosen).model_copy(update={"friction": 0.0})
    robot, options = chosen.model_copy(update={"drive_unit": unit}), options or FeOptions(mesh=MESH)
    groups: dict[tuple[int, int, bool], list[int]] = {}  # rows by joint, side and whether the joint is held
    keys = zip(bench.joint.tolist(), bench.side.tolist(), np.isfinite(bench.moment).tolist(), strict=True)
    for row, key in enumerate(keys):
        groups.setdefault(key, []).append(row)
    rising = {key: np.unique(np.append([] if key[2] else 0.0, bench.pressure[rows])) for key, rows in groups.items()}
    done, total = 0, sum(len(pressures) * (COUPLES if key[2] else 1) for key, pressures in rising.items())

    def tick() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, total)

    joints = {joint: _Solver(robot, joint, solve(robot, joint, options), tick) for joint in bench.joints}
    found, faults = {kind: np.full(len(bench.joint), np.nan) for kind in KINDS}, [""] * len(bench.joint)
    for (joint, side, held), rows in sorted(groups.items()):
        points = (joints[joint].held if held else joints[joint].free)(side, rising[joint, side, held].tolist())
        for row in rows:
            values, faults[row] = points[float(bench.pressure[row])]
            for kind, value in values.items():
                found[kind][row] = value
    held_rows = zip(found["moment"].tolist(), bench.joint.tolist(), bench.arm.tolist(), strict=True)
    found["moment"] = np.array([held_at(m, joint_group(robot, joint)[1].length, arm) for m, joint, arm in held_rows])
    measured = family.space.elements
    model, elements = (measured.of(values) for values in (computed(robot, bench), found))
    messages = tuple(faults[row] for row in measured.row.tolist())
    return Checked(family, options, model, elements, messages, time.monotonic() - started)


@dataclass(frozen=True)
class _Solver:
    """Solver of a joint at pressures (n,) [Pa] of one side; its results are by pressure: values by kind [SI], fault."""

    robot: Robot
    joint: int
    by_elements: Joint  # solves the joint by finite elements
    tick: Callable[[], None]  # called after each solution

    def free(self, side: int, rising: list[float]) -> dict[float, Point]:
        """Return results of the free joint; the first pressure is that of rest. After a fault, all have that fault."""
        path, states, fault = [_pair(side, pressure) for pressure in rising], [], ""
        points: dict[float, Point] = {}
        for k, pressure in enumerate(rising):
            if not fault:
                states.append(self._solve(0.0, path[: k + 1]))
                fault = self._fault(side, pressure, states[-1]["fault"])
            points[pressure] = ({} if fault else _since(states[0], states[-1], side), fault)
        return points

    def held(self, side: int, rising: list[float]) -> dict[float, Point]:
        """Return results of the joint held straight by a couple: one secant step from the fast model's couple."""
        points: dict[float, Point] = {}
        stiffness, sign = joint_models(self.robot)[self.joint].stiffness, 1 - 2 * side
        for pressure in rising:
            couple = -sign * blocked_moment(self.robot, self.joint, pressure, side)
            first = last = self._solve(couple, [_pair(side, pressure)])
            if not first["fault"]:
                second_couple = couple - stiffness * first["angle"]
                last = self._solve(second_couple, [_pair(side, pressure)])
            if fault := self._fault(side, pressure, last["fault"], ", held straight"):
                points[pressure] = {}, fault
                continue
            difference = last["angle"] - first["angle"]
            holding = second_couple - last["angle"] * (second_couple - couple) / difference if difference else couple
            points[pressure] = {"moment": -sign * holding}, ""
        return points

    def _solve(self, couple: float, path: list[Pair]) -> Mapping[str, Any]:
        """Return the state at the end of a path of pressures under a couple [N m]."""
        try:
            return self.by_elements(couple, path)
        except InputError as error:  # such as no mesh
            return {"fault": str(error)}
        finally:
            self.tick()

    def _fault(self, side: int, pressure: float, fault: str, condition: str = "") -> str:
        """Return a sentence that finite elements did not reach a pressure [Pa]; empty if there was no fault."""
        where = f"Joint {self.robot.joints[self.joint].name}, {(*SIDES, BOTH)[side]}{condition}"
        text = f"{where}: {pressure / 1e3:g} kPa was not reached by finite elements ({fault.rstrip('.')})."
        return text if fault else ""


def _pair(side: int, pressure: float) -> Pair:
    """Return the pressures [Pa] of the left and right sides, given the side under pressure (2: both)."""
    return pressure if side != 1 else 0.0, pressure if side else 0.0


def _since(rest: Mapping[str, Any], state: Mapping[str, Any], side: int) -> dict[str, float]:
    """Return a state's quantities as a bench measures them, relative to rest [SI], by kind."""
    values = {"shortening": rest["length"] - state["length"]}
    if side == len(SIDES):
        return values
    return values | {"angle": (1 - 2 * side) * state["angle"], "volume": state["volume"][side] - rest["volume"][side]}
