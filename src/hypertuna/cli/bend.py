"""The command `hypertuna bend`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.actuation.bending import MATERIAL_SETS, Bend, Step, bend, misprints, mooney
from hypertuna.characterization.data import joint_index
from hypertuna.cli.old_console import check_suffix, command_line, print_json, tell_written
from hypertuna.cli.old_options import AsJson, Joint, Name, Pressure, Side, pressures
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.io.files import rows_csv, write_atomically, write_netcdf

__all__ = ["bend_command"]

ALL = "all"  # every material set that the robot has the values of
SMOOTH = 50  # pressures of a drawn curve, at least
ROWS = 11  # pressures that the terminal shows


def bend_command(
    robot: Name,
    joint: Joint,
    pressure: Pressure = "0:250:26",
    side: Side = "left",
    unload: Annotated[bool, typer.Option("--unload", help="Go back too: the other branch of the hysteresis.")] = False,
    material: Annotated[
        str | None,
        typer.Option(
            "--material",
            help=f"Material set: {', '.join(MATERIAL_SETS)}, or all, with their spread. (default: the robot's)",
        ),
    ] = None,
    law: Annotated[
        str, typer.Option("--law", help="corrected, or as_printed: Eqs 4-18 as they stand in the paper.")
    ] = "corrected",
    no_friction: Annotated[bool, typer.Option("--no-friction", help="Braids that do not rub.")] = False,
    plot: Annotated[
        str | None,
        typer.Option("--plot", help="Draw loop and spread of the materials to this .svg, .png or .pdf file."),
    ] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write to this .nc or .csv file.")] = None,
    as_json: AsJson = False,
) -> None:
    """Bend a soft joint in air by the pressure of one side: angle over pressure, up and down."""
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    kind = check_suffix(output, (".nc", ".csv"), "--output")
    fish, path = load(robot), 1e3 * np.array(pressures(pressure))
    number = joint_index(joint, fish)

    def bent(chosen: str | None, path: NDArray[np.float64] = path) -> Bend:
        options: dict[str, Any] = {"side": side, "friction": not no_friction, "unload": unload, "law": law}
        return bend(fish, number, path, material=chosen, **options)

    first = bent(None if material == ALL else material)
    known = _known(fish) if material == ALL or plot is not None else ()
    others = {name: bent(name) for name in known if name != first.material}
    sets: dict[str, Bend] = {
        name: others.get(name, first) for name in MATERIAL_SETS if name in others or name == first.material
    }
    steps = misprints(fish, number, float(path[-1]), first.material) if law == "as_printed" else ()
    if plot is not None:
        drawn = _drawn(path)
        curves = sets if len(drawn) == len(path) else {name: bent(name, drawn) for name in sets}
        _plot(curves[first.material], curves, plot)
    shown_sets = sets if material == ALL else {first.material: first}
    if output is not None and kind == ".nc":
        write_netcdf(_dataset(first, shown_sets), output)
    if output is not None and kind == ".csv":
        write_atomically(output, _csv(first, shown_sets).encode())
    if as_json:
        print_json(_record(first, shown_sets, steps))
    else:
        _print(first, shown_sets, steps)
        tell_written(plot, output)


def _drawn(path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return pressures that draw a smooth curve: those asked for, or more of them up to the largest."""
    return path if len(path) >= SMOOTH else np.union1d(path, np.linspace(0, path[-1], SMOOTH))


def _known(robot: Robot) -> tuple[str, ...]:
    """List the material sets that the robot has all values of."""
    unit, known = robot.drive_unit, []
    for name in MATERIAL_SETS:
        try:
            for silicone in (unit.hose, unit.matrix) if unit else ():
                mooney(robot, silicone, name)
        except InputError:
            continue
        known.append(name)
    return tuple(known)


def _branches(found: Bend) -> dict[str, Any]:
    """Pressures and angles as they leave the program."""
    branches = {"pressure_kpa": found.pressure / 1e3, "angle_deg": np.degrees(found.angle)}
    if found.unload_pressure is not None and found.unload_angle is not None:
        branches["unload_pressure_kpa"] = found.unload_pressure / 1e3
        branches["unload_angle_deg"] = np.degrees(found.unload_angle)
    return branches


def _facts(found: Bend) -> dict[str, Any]:
    """Tell of a bend what stands beside its branches."""
    back = found.unload_angle is not None  # without the way back there is no loop
    return {
        "r_squared": found.r_squared(),
        "loop_area_kpa_deg": math.degrees(found.loop_area) / 1e3 if back else math.nan,
        "friction_loss_j": found.loss if back else math.nan,
        "braid_angle_max_deg": math.degrees(found.braid_angle),
        "lumen_left_min": found.lumen_left,
        "status": found.status,
        "status_text": found.status_text,
    }


def _record(first: Bend, sets: Mapping[str, Bend], steps: tuple[Step, ...]) -> dict[str, Any]:
    """Tell a bend, for programs."""
    record: dict[str, Any] = provenance(first.robot) | {
        "command": command_line(),
        "joint": first.joint,
        "side": first.side,
        "material": first.material,
        "law": first.law,
        "friction": first.friction,
    }
    record |= _branches(first) | _facts(first)
    if len(sets) > 1:
        record["materials"] = {name: _branches(found) | _facts(found) for name, found in sets.items()}
        largest = [math.degrees(found.angle[-1]) for found in sets.values()]
        record["spread_deg"] = {"smallest": min(largest), "largest": max(largest)}
    if steps:
        record["misprints"] = [{"step": step.text, "angle_deg": math.degrees(step.angle)} for step in steps]
    return record


def _dataset(first: Bend, sets: Mapping[str, Bend]) -> Any:
    """Label a bend, or those of several material sets along a dimension of their own."""
    if len(sets) == 1:
        return first.dataset().assign_attrs(command=command_line())
    import xarray as xr

    whole = xr.concat([found.dataset().expand_dims(material=[name]) for name, found in sets.items()], "material")
    return whole.assign_attrs(first.dataset().attrs | {"command": command_line(), "material": ALL})


def _csv(first: Bend, sets: Mapping[str, Bend]) -> str:
    """Write bends as comma-separated values, a row per pressure, below comments that say what made them."""
    facts = provenance(first.robot) | {"command": command_line(), "joint": first.joint, "side": first.side}
    facts |= {"law": first.law, "status": first.status_text}
    rows = []
    for name, found in sets.items():
        columns = [column.tolist() for column in _branches(found).values()]
        for branch, *ways in zip(("load", "unload"), columns[::2], columns[1::2], strict=False):
            rows += [
                {"material": name, "branch": branch, "pressure_kpa": pressure, "angle_deg": angle}
                for pressure, angle in zip(*ways, strict=True)
            ]
    return rows_csv(facts, rows)


def _plot(first: Bend, sets: Mapping[str, Bend], plot: str) -> None:
    """Draw a bend; what draws is imported only now, because that takes long."""
    from hypertuna.actuation.plots import plot_bend
    from hypertuna.figures import save

    save(plot_bend(first, sets), plot)


def _print(first: Bend, sets: Mapping[str, Bend], steps: tuple[Step, ...]) -> None:
    """Print a bend, or every so many of its pressures."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column(Text("pressure\n[kPa]", justify="right"), justify="right")
    columns = []
    for name, found in sets.items():
        title = f"{name}\n" if len(sets) > 1 else "angle\n"
        columns.append((f"{title}[deg]", np.degrees(found.angle)))
        if found.unload_angle is not None:
            columns.append(
                (f"{'back' if len(sets) > 1 else 'on the way back'}\n[deg]", np.degrees(found.unload_angle[::-1]))
            )
    for head, _ in columns:
        table.add_column(Text(head, justify="right"), justify="right")
    count = len(first.pressure)
    for k in np.unique(np.linspace(0, count - 1, min(count, ROWS)).round().astype(int)):
        table.add_row(f"{first.pressure[k] / 1e3:.4g}", *(f"{column[k]:.2f}" for _, column in columns))
    console = Console()
    which = "" if len(sets) > 1 else f", material set {first.material}"
    equations = "" if first.law == "corrected" else ", equations as printed"
    console.print(Text(f"{first.robot.name}: joint {first.joint}, {first.side} side{which}{equations}", style="bold"))
    console.print(table)
    squared = first.r_squared()
    if math.isfinite(squared):
        console.print(Text(f"line over 100 to 250 kPa, on the way up: R^2 = {squared:.4f}"))
    if first.unload_angle is not None:
        console.print(
            Text(f"loop: {math.degrees(first.loop_area) / 1e3:.1f} kPa deg; friction took {first.loss:.2g} J")
        )
    if len(sets) > 1:
        low, high = (pick(math.degrees(found.angle[-1]) for found in sets.values()) for pick in (min, max))
        console.print(Text(f"spread of the materials at {first.pressure[-1] / 1e3:g} kPa: {low:.1f} to {high:.1f} deg"))
    for step in steps:
        console.print(Text(f"{math.degrees(step.angle):6.2f} deg  {step.text}"))
    console.print(Text(first.status_text, style="green" if first.status == "free" else "bold yellow"))
