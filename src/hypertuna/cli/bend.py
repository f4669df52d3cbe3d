"""The command `hypertuna joint bend`."""

import contextlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from hypertuna.actuation.bending import Bend, Correction, bend, misprints
from hypertuna.actuation.cards import bends_card, spread
from hypertuna.actuation.soft_joint import MATERIAL_SETS, drive_unit, mooney
from hypertuna.arrays import Array
from hypertuna.characterization.data import joint_index
from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit, made_by
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.files import Csv, rows_csv

ALL = "all"  # value of --material: every material set for which the robot has all values
MIN_PLOT_POINTS = 50  # a plotted curve of fewer pressures gets this many more
PRESSURES: Any = "0:250:26"  # default of --pressure [kPa], as typed


@dataclass(frozen=True)
class Bends:
    """Bends of one joint, by material set."""

    first: Bend  # with the material set of --material, or the robot's own
    sets: Mapping[str, Bend]  # material set -> bend
    misprints: tuple[Correction, ...]  # bends after each correction of the printed equations, with --law as_printed


@opt.grouped
def bend_command(
    robot: opt.RobotOptions,
    joint: opt.Joint,
    pressure: opt.Pressures = PRESSURES,
    side: opt.Side = "left",
    unload: Annotated[
        bool, opt.flag("--unload", "Unload as well, for the other branch of the hysteresis loop.")
    ] = False,
    material: Annotated[
        str | None,
        opt.text("--material", f"{', '.join(MATERIAL_SETS)}, or all of them and their spread. (default: the robot's)"),
    ] = None,
    law: Annotated[
        str, opt.text("--law", "corrected, or as_printed: Eqs 4-18 as they stand in the paper.")
    ] = "corrected",
    no_friction: Annotated[bool, opt.flag("--no-friction", "Leave out the friction of the braids.")] = False,
    files: opt.Files = opt.NO_FILES,
) -> None:
    """Bend a soft joint in air: angle over pressure, up and down."""
    fish, path = robot.load(), 1e3 * np.array(pressure)
    number = joint_index(joint, fish)

    def bend_of(chosen: str | None, path: Array = path) -> Bend:
        options: dict[str, Any] = {"side": side, "friction": not no_friction, "unload": unload, "law": law}
        return bend(fish, number, path, material=chosen, **options)

    first = bend_of(None if material == ALL else material)
    complete = _complete_sets(fish) if material == ALL or files.plot is not None else ()
    sets = {name: first if name == first.material else bend_of(name) for name in complete} | {first.material: first}
    curves = sets
    if files.plot is not None and len(path) < MIN_PLOT_POINTS:
        smooth = np.union1d(path, np.linspace(0, path[-1], MIN_PLOT_POINTS))
        curves = {name: bend_of(name, smooth) for name in sets}
    steps = misprints(fish, number, float(path[-1]), first.material) if law == "as_printed" else ()
    emit(
        Bends(first, sets if material == ALL else {first.material: first}, tuple(steps)),
        record=_record,
        lines=lambda bends: bends_card(bends.first, bends.sets, bends.misprints).lines(),
        csv=_csv,
        dataset=_dataset,
        figure=lambda _: _figure(curves[first.material], curves),
        **vars(files),
    )


def _complete_sets(robot: Robot) -> Iterator[str]:
    """Yield the names of the material sets for which the robot has all values."""
    unit = drive_unit(robot)
    for name in MATERIAL_SETS:
        with contextlib.suppress(InputError):
            mooney(robot, unit.hose, name)
            mooney(robot, unit.matrix, name)
            yield name


def _figure(first: Bend, curves: Mapping[str, Bend]) -> Any:
    """Return the figure of a bend; several material sets are drawn as a band."""
    from hypertuna.actuation.plots import plot_bend  # slow to import

    return plot_bend(first, curves)


def _branches(result: Bend) -> dict[str, Any]:
    """Return pressures [kPa] and angles [deg] of loading and unloading, by the keys of the JSON record."""
    columns: dict[str, Any] = {}
    for start, (pressure, angle) in zip(("", "unload_"), result.branches.values(), strict=False):
        columns |= {f"{start}pressure_kpa": pressure / 1e3, f"{start}angle_deg": np.degrees(angle)}
    return columns


def _facts(result: Bend) -> dict[str, Any]:
    """Return the JSON record of a bend without its branches: r squared, hysteresis, friction loss, limits, status."""
    loop, loss = (result.loop_area, result.friction_loss) if result.unload_angle is not None else (math.nan, math.nan)
    return {
        "r_squared": result.r_squared(),
        "loop_area_kpa_deg": math.degrees(loop) / 1e3,
        "friction_loss_j": loss,
        "braid_angle_max_deg": math.degrees(result.braid_angle_max),
        "lumen_left_min": result.lumen_left_min,
        "status": result.status,
        "status_text": result.status_text,
    }


def _record(bends: Bends) -> dict[str, Any]:
    """Return the JSON record of the bends."""
    first = bends.first
    record = made_by(first.robot, joint=first.joint, side=first.side, material=first.material)
    record |= {"law": first.law, "friction": first.friction} | _branches(first) | _facts(first)
    if len(bends.sets) > 1:
        record["materials"] = {name: _branches(bend) | _facts(bend) for name, bend in bends.sets.items()}
        low, high = spread(bends.sets)
        record["spread_deg"] = {"smallest": low, "largest": high}
    if bends.misprints:
        record["misprints"] = [{"step": step.text, "angle_deg": math.degrees(step.angle)} for step in bends.misprints]
    return record


def _dataset(bends: Bends) -> Any:
    """Return a bend as a dataset; the bends of several material sets lie along its dimension `material`."""
    if len(bends.sets) == 1:
        return bends.first.dataset()
    import xarray as xr

    whole = xr.concat([bend.dataset().expand_dims(material=[name]) for name, bend in bends.sets.items()], "material")
    return whole.assign_attrs(bends.first.dataset().attrs | {"material": ALL})


def _csv(bends: Bends) -> Csv:
    """Return the CSV table of bends, a row per pressure."""
    first = bends.first
    rows = [
        {"material": name, "branch": branch.removesuffix("ing"), "pressure_kpa": pressure, "angle_deg": angle}
        for name, bend in bends.sets.items()
        for branch, (pressures, angles) in bend.branches.items()
        for pressure, angle in zip((pressures / 1e3).tolist(), np.degrees(angles).tolist(), strict=True)
    ]
    facts = made_by(first.robot, joint=first.joint, side=first.side, law=first.law, status=first.status_text)
    return rows_csv(facts, rows)
