"""Twin with joints of finite elements: reduces the joints of a robot, and swims it with analytic and reduced ones.

Run: python validation/fe/reduced.py [ROBOT] [--mesh MESH] [--keep FOLDER], half an hour per joint on the mesh coarse;
points in FOLDER are not solved again. Stores the tables of docs/fe.md in reduced-ROBOT.json beside this file, and
writes FOLDER/ROBOT-reduced.toml.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import hypertuna as ht
from hypertuna.actuation.soft_joint import joint_tables
from hypertuna.cli.console import progress_bar
from hypertuna.description.provenance import provenance
from hypertuna.description.writer import write_robot
from hypertuna.fe.measure import measure
from hypertuna.fe.model import FeOptions, equilibrium, fe_model
from hypertuna.fe.reduction import ReducedJoint, reduce_joint, with_reduced
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twin

PAIRS = ((60, 60), (80, 40), (100, 20), (120, 0), (120, 60), (180, 0), (180, 60))  # kPa
PRESSURE = np.linspace(0, 250e3, 6)
GAITS = ("unoptimised-0.3", "unoptimised-max")  # 2 Hz and 6 Hz, large amplitude


def reduced_joints(robot: ht.Robot, mesh: str, keep: Path) -> list[ReducedJoint]:
    """Reduce every joint."""
    options, found = FeOptions(mesh=mesh), []
    for group in robot.joints:
        with progress_bar(f"joint {group.name}") as progress:
            checkpoint = keep / f"{robot.name}-{group.name}-{mesh}.journal"
            given = {"pressure": PRESSURE, "options": options, "checkpoint": checkpoint, "progress": progress}
            found.append(reduce_joint(robot, group.name, **given))
    return found


def lengths(robot: ht.Robot, joint: str, mesh: str) -> Iterator[list[str]]:
    """Show that the sum of the pressures shortens a joint, and their difference bends it."""
    yield ["left", "right", "bend", "length", "oil, left", "oil, right"]
    model = fe_model(robot, joint, FeOptions(mesh=mesh))
    for pair in PAIRS:
        ended = equilibrium(model, pressure=(1e3 * pair[0], 1e3 * pair[1]))
        if not ended.converged:
            yield [f"{pair[0]} kPa", f"{pair[1]} kPa", ended.text]
            return
        seen = measure(model)
        shape = (f"{math.degrees(seen.angle):.2f}°", f"{1e3 * seen.length:.2f} mm")
        oil = (f"{1e6 * volume:.3f} ml" for volume in seen.volume)
        yield [f"{pair[0]} kPa", f"{pair[1]} kPa", *shape, *oil]


def fits(found: Sequence[ReducedJoint]) -> Iterator[list[str]]:
    """What the tables leave of the points."""
    heads = ("moment, rms", "of couples not fitted", "volume, rms", "own compliance", "of the other side")
    yield ["joint", "points", "to", *heads]
    for joint in found:
        fit, left, new = joint.potential, joint.residual, joint.residual_new
        cells = (
            f"{np.isfinite(joint.angle).sum()} of {joint.angle.size}",
            f"{math.degrees(fit.reach):.1f}°",
            f"{1e3 * left.moment:.1f} mN m",
            f"{1e3 * new.moment:.1f} mN m",
            f"{1e6 * left.volume:.3f} ml",
            f"{1e12 * fit.compliance:.1f}e-12 m³/Pa",
            f"{1e12 * fit.cross:.1f}e-12 m³/Pa",
        )
        yield [joint.joint, *cells]


def tables(robot: ht.Robot, reduced: ht.Robot) -> Iterator[list[str]]:
    """Compare stiffness, volume per angle and bend of one side of the two tables."""
    yield ["joint", "table", "moment at 10°", "dV/dα at rest", "at 10°", "bend at 250 kPa"]
    for ours, other in zip(joint_tables(robot), joint_tables(reduced), strict=True):
        for name, table in (("analytic", ours), ("reduced", other)):
            at = table.at(np.radians([0, 10]))
            angle = table.angle[table.angle >= 0]
            load = table.at(angle)
            excess = load["elastic"] + 250e3 * load["slope"][:, 0]
            free = float(np.interp(0, -excess, angle))
            slopes = (f"{1e6 * slope:.2f} ml/rad" for slope in at["slope"][:, 0])
            yield [ours.name, name, f"{-at['elastic'][1]:.3f} N m", *slopes, f"{math.degrees(free):.1f}°"]


def runs(robot: ht.Robot, reduced: ht.Robot) -> Iterator[list[str]]:
    """Swim with either."""
    yield ["gait", "joints", "I", "II", "speed", "largest pressure I, II", "electrical power"]
    for name in GAITS:
        for kind, fish in (("analytic", robot), ("reduced", reduced)):
            run: TwinRun = twin(fish, ht.named_gait(fish, name), duration=10, start="swimming")
            swing = (f"{angle:.1f}°" for angle in np.degrees(run.swing))
            most = run.pressure_max.reshape(-1, 2).max(axis=1) / 1e3
            pressure = f"{most[0]:.0f}, {most[1]:.0f} kPa"
            yield [f"`{name}`", kind, *swing, f"{run.speed:.3f} m/s", pressure, f"{run.power:.1f} W"]


def main() -> None:
    """Read the command line, solve, and store the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot", nargs="?", default="hypertuna-fe")
    parser.add_argument("--mesh", default="coarse")
    parser.add_argument("--keep", type=Path, default=Path())
    asked = parser.parse_args()
    robot = ht.load(asked.robot)
    found = reduced_joints(robot, asked.mesh, asked.keep)
    reduced = robot
    for joint in found:
        print(f"joint {joint.joint}: {joint.status_text} {joint.seconds:.0f} s")
        reduced = with_reduced(reduced, joint)
    write_robot(reduced, asked.keep / f"{robot.name}-reduced.toml", note="reduced, see [sources]")
    last = robot.joints[-1].name
    stored = {
        "made by": provenance(robot) | vars(FeOptions(mesh=asked.mesh)),
        "lengths": list(lengths(robot, last, asked.mesh)),
        "fits": list(fits(found)),
        "tables": list(tables(robot, reduced)),
        "runs": list(runs(robot, reduced)),
    }
    path = Path(__file__).with_name(f"reduced-{robot.name}.json")
    path.write_text(json.dumps(stored, indent=1, ensure_ascii=False) + "\n")
    print(path.read_text())


if __name__ == "__main__":
    main()
