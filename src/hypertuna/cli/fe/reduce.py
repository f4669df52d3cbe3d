"""The command `hypertuna fe reduce`."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.characterization.data import joint_index
from hypertuna.cli.fe.options import (
    LAW,
    MIXED,
    POISSON,
    Law,
    Material,
    Mesh,
    Mixed,
    Poisson,
    elements,
    rising_pressures,
)
from hypertuna.cli.old_console import check_suffix, command_line, number, print_json, progress_bar, ranges, tell_written
from hypertuna.cli.old_options import AsJson, Joint, Name
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.fe.bend import ngsolve_version
from hypertuna.fe.reduction import ReducedJoint, reduce_joint, write_reduced

__all__ = ["reduce_command"]


def reduce_command(
    robot: Name,
    joint: Joint,
    pressure: Annotated[
        str, typer.Option("--pressure", help="Rising gauge pressures of the left side in kPa, start:stop:count.")
    ] = "0:250:6",
    moment: Annotated[
        str | None,
        typer.Option(
            "--moment",
            help="Couples on the tip in N m, start:stop:count. (default: 5, to half of what the pressure makes)",
        ),
    ] = None,
    fill: Annotated[
        str | None,
        typer.Option(
            "--fill",
            help="Fill pressure in kPa: the right side has twice that less the left's, or none; 0 for one side alone.  "
            "(default: that of the robot's line)",
        ),
    ] = None,
    material: Material = None,
    law: Law = LAW,
    poisson: Poisson = POISSON,
    mixed: Mixed = MIXED,
    mesh: Mesh = "coarse",
    checkpoint: Annotated[
        str | None, typer.Option("--checkpoint", help="Keep a journal here; the same command resumes from it.")
    ] = None,
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Write the robot with the table to this .toml file.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Reduce a joint of finite elements to a table of moment and volume that the twin can use.

    Every couple takes about as long as `fe bend`, so the mesh is coarse unless asked otherwise: half an hour a joint.
    Angles are positive to the left. The exit code is 1 if some points were not found (the table is fitted to the
    others), 2 for bad input.
    """
    check_suffix(output, (".toml",), "--output")
    fish = load(robot)
    name = fish.joints[joint_index(joint, fish)].name
    options = elements(material, law, poisson, mesh, mixed=mixed)
    with progress_bar("points", lines=True) as progress:
        reduced = reduce_joint(
            fish,
            name,
            pressure=rising_pressures(pressure),
            couple=None if moment is None else _couples(moment),
            fill=None if fill is None else 1e3 * number(fill, "--fill", "kPa"),
            options=options,
            checkpoint=checkpoint,
            progress=progress,
        )
    if output is not None:
        write_reduced(robot, reduced, output)
    if as_json:
        print_json(_record(reduced, output))
    else:
        _print(reduced)
        tell_written(output)
    if reduced.status != "converged":
        raise typer.Exit(1)


def _couples(text: str) -> list[float]:
    """Read couples: every part of the list in turn."""
    return [value for k, part in enumerate(text.split(",")) for (value,) in ranges(part, f"--moment[{k}]", "N m")]


def _record(reduced: ReducedJoint, output: str | None) -> dict[str, Any]:
    """Tell a reduced joint, for programs: over couples and pressures, the table, over its angles and pressures."""
    fit, table = reduced.potential, reduced.table()
    moment, volume = reduced.over_angle(np.radians(table["angle_deg"]))
    return provenance(reduced.robot, water=False) | {
        "command": command_line(),
        "ngsolve_version": ngsolve_version(),
        "joint": reduced.joint,
        "mesh": str(reduced.options.mesh),
        "material": reduced.material,
        "law": reduced.options.law,
        "poisson": reduced.options.poisson,
        "mixed": reduced.options.mixed,
        "pressure_left_kpa": reduced.pressure[:, 0] / 1e3,
        "pressure_right_kpa": reduced.pressure[:, 1] / 1e3,
        "couple_n_m": reduced.couple,
        "angle_deg": np.degrees(reduced.angle),
        "moment_n_m": reduced.moment,
        "volume_left_ml": 1e6 * reduced.volume[..., 0],
        "volume_right_ml": 1e6 * reduced.volume[..., 1],
        "table": table,
        "over_angle": {"moment_n_m": moment, "volume_left_ml": 1e6 * volume[..., 0]},
        "terms": {"elastic": len(fit.elastic_terms), "volume": len(fit.volume_terms)},
        "compliance_m3_pa": fit.compliance,
        "cross_compliance_m3_pa": fit.cross,
        "moment_rms_n_m": reduced.left.moment,
        "volume_rms_ml": 1e6 * reduced.left.volume,
        "moment_rms_left_out_n_m": reduced.left_new.moment,
        "volume_rms_left_out_ml": 1e6 * reduced.left_new.volume,
        "seconds": reduced.seconds,
        "output": output,
        "status": reduced.status,
        "status_text": reduced.status_text,
    }


def _print(reduced: ReducedJoint) -> None:
    """Print angles and volumes of the points, and what the table leaves of them."""
    console, fit = Console(), reduced.potential
    console.print(Text(f"{reduced.robot.name}: joint {reduced.joint}, mesh {reduced.options.mesh}", style="bold"))
    table = Table(box=None, pad_edge=False, header_style="bold")
    for head in ("left\n[kPa]", "right\n[kPa]", *(f"{couple:+.3g} N m\n[deg]  [ml]" for couple in reduced.couple)):
        table.add_column(Text(head, justify="right"), justify="right")
    for p, (one, other) in enumerate(reduced.pressure / 1e3):
        points = zip(np.degrees(reduced.angle[:, p]), 1e6 * reduced.volume[:, p, 0], strict=True)
        cells = [f"{angle:.2f}  {volume:.3f}" if np.isfinite(angle) else "not found" for angle, volume in points]
        table.add_row(f"{one:.4g}", f"{other:.4g}", *cells)
    console.print(table)
    reach, rms = np.degrees(fit.reach), f"{1e3 * reduced.left.moment:.3g} mN m and {1e6 * reduced.left.volume:.2g} ml"
    new = f"{1e3 * reduced.left_new.moment:.3g} and {1e6 * reduced.left_new.volume:.2g}"
    console.print(Text(f"table to {reach:.1f} deg either way; it leaves {rms} rms ({new} of couples not fitted)"))
    give, cross = fit.compliance, fit.cross
    text = f"angle held, a side takes {give:.2g} m^3/Pa for its own pressure, {cross:.2g} for the other's"
    console.print(Text(f"{text}: {give - cross:.2g} where their sum stays"))
    console.print(Text(reduced.status_text, style="green" if reduced.status == "converged" else "bold yellow"))
