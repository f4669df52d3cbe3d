"""The bending tests of section III.A: Fig. 6(e), loading and unloading, and the equations as they are printed."""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hypertuna.actuation.bending import Bend, Correction, bend, misprints, straightness
from hypertuna.actuation.soft_joint import MATERIAL_SETS
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import OURS
from hypertuna.paper.ledger import FAMILY, Finding
from hypertuna.reports.html import WIDTH, Section, Table

ACTUATOR = "actuator"
PRINTED = "actuator, equations as printed"
TESTED = np.array([100.0, 150.0, 200.0, 250.0])  # pressures of the test [kPa]
LINES = ("bending/linear", "bending/below-250kpa")  # starts of the ids of the two measures of straightness
SPAN = "100, 150, 200 and 250 kPa"
POINTS = 51  # of a curve from no pressure to the largest


@dataclass(frozen=True)
class Bends:
    """Bends against pressure of every joint group, by name: printed equations, all material sets, and corrections."""

    sets: dict[str, dict[str, Bend]]  # corrected equations, loading and unloading, with each material set of the robot
    printed: dict[str, Bend]  # the equations as the paper prints them, with the robot's own set
    steps: dict[
        str, tuple[Correction, ...]
    ]  # from the printed equations to the corrected ones, at the largest pressure

    @property
    def corrected(self) -> dict[str, Bend]:
        """Bends by joint group, with the corrected equations and the robot's own set of material constants."""
        return {name: sets[self.printed[name].material] for name, sets in self.sets.items()}


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Bends:
    """Bend every joint of the paper's robot."""
    return bend_published(trials[OURS].robot)


def bend_published(robot: Robot) -> Bends:
    """Bend every joint with rising and falling pressure, up to the largest pressure of its group."""
    sets: dict[str, dict[str, Bend]] = {}
    printed, steps = {}, {}
    for group in robot.joints:
        assert group.pressure_max is not None  # the paper's robot has it
        pressure = np.linspace(0, group.pressure_max, POINTS)
        printed[group.name] = bend(robot, group.name, pressure, law="as_printed")
        steps[group.name] = misprints(robot, group.name, group.pressure_max)
        sets[group.name] = {}
        for material in MATERIAL_SETS:
            with contextlib.suppress(InputError):  # a set that the description does not have
                sets[group.name][material] = bend(robot, group.name, pressure, material=material, unload=True)
    return Bends(sets, printed, steps)


def findings(bends: Bends) -> Iterator[Finding]:
    """Yield the bend of each joint at its largest pressure, and how straight its curve is."""
    for name, curve in bends.corrected.items():
        angle = float(np.degrees(curve.angle[-1]))
        note = (
            "the geometry, which is not published, was chosen to match both angles. A "
            f"line through 100 to 250 kPa has R² = {curve.r_squared():.3f}; rising and falling pressure differ by "
            f"{_hysteresis(curve):.2g} deg at most"
        )
        yield Finding(f"bending/{name}", ACTUATOR, "calibrated", angle, note)
        yield from line_findings(name, ACTUATOR, curve.pressure, curve.angle)
        printed = float(np.degrees(bends.printed[name].angle[-1]))
        note = f"the same geometry in the equations as they stand: {100 * (printed / angle - 1):+.0f} %"
        yield Finding(f"bending/{name}", PRINTED, "calibrated", printed, f"{note} beside the corrected ones")


def line_findings(joint: str, model: str, pressure: Array, angle: Array) -> Iterator[Finding]:
    """Yield findings on the straightness of bends [rad] over pressures [Pa], at 100 to 250 kPa."""
    bend = np.degrees(np.interp(TESTED, pressure / 1e3, angle))
    first, *_, last = np.diff(bend) / np.diff(TESTED)
    line = bend[-1] * TESTED / TESTED[-1]
    values = (float(last / first), float(np.mean(bend[:-1] / line[:-1])))
    notes = (
        f"R² = {straightness(pressure, angle):.3f}; {', '.join(f'{one:.3g}' for one in bend)} deg at {SPAN}; {FAMILY}",
        f"beside a line from no bend without pressure, with {', '.join(f'{one:.3g}' for one in line[:-1])} deg",
    )
    for key, value, note in zip(LINES, values, notes, strict=True):
        yield Finding(f"{key}-{joint}", model, "in sight", value, note)


def sections(bends: Bends) -> list[Section]:
    """Show bends against pressure."""
    from hypertuna.actuation.plots import plot_bend

    corrected = bends.corrected
    figures = {f"hysteresis-{name}": plot_bend(bend, bends.sets[name], width=WIDTH) for name, bend in corrected.items()}
    errors = [bends.printed[name].angle[-1] / bend.angle[-1] - 1 for name, bend in corrected.items()]
    last_angles = [[np.degrees(bend.angle[-1]) for bend in sets.values()] for sets in bends.sets.values()]
    return compose(
        "actuator",
        figures | {"steps": step_table(bends)},
        joints=list(corrected),
        slopes=" and ".join(f"{one.computed:.2f}" for one in findings(bends) if one.id.startswith(LINES[0])),
        r_squared=" and ".join(f"{bend.r_squared():.3f}" for bend in corrected.values()),
        loops=" and ".join(f"{_hysteresis(bend):.2g}" for bend in corrected.values()),
        spreads=" and ".join(f"{min(angles):.1f} to {max(angles):.1f}" for angles in last_angles),
        printed=" and ".join(f"{100 * error:+.0f} %" for error in errors),
    )


def step_table(bends: Bends) -> Table:
    """Tabulate the bend of each joint after each correction of the printed equations."""
    steps = zip(*bends.steps.values(), strict=True)
    rows = [[joints[0].text, *(f"{np.degrees(joint.angle):.1f}" for joint in joints)] for joints in steps]
    return Table(["equations", *(f"{name} [deg]" for name in bends.steps)], rows)


def _hysteresis(result: Bend) -> float:
    """Return the largest difference of bend between loading and unloading [deg]."""
    pressure, angle = result.branches["unloading"]
    unloading = np.interp(result.pressure, pressure[::-1], angle[::-1])
    return float(np.degrees(np.abs(unloading - result.angle).max()))


CHAPTER = Chapter("bends", sections, findings, compute)
