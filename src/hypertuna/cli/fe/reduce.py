"""The command `hypertuna fe reduce`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import numpy as np

from hypertuna.characterization.data import joint_index
from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar, table
from hypertuna.cli.emit import emit
from hypertuna.cli.fe.options import Law, Material, Mesh, Mixed, Poisson, rising
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.fe.bend import ngsolve_version
from hypertuna.fe.model import FeOptions
from hypertuna.fe.reduction import ReducedJoint, reduce_joint, write_reduced

PRESSURES: Any = "0:250:6"  # kPa, as typed


def reduce_command(
    robot: opt.RobotName,
    joint: opt.Joint,
    pressure: opt.Pressures = PRESSURES,
    moment: Annotated[
        Sequence[float] | None,
        opt.values(
            "--moment", "N m", "Couples on the tip in N m. (default: 5, to half of the moment that the pressure makes)"
        ),
    ] = None,
    fill: Annotated[
        float | None,
        opt.number(
            "--fill",
            "kPa",
            "Fill pressure in kPa: the right side has twice that less the left pressure, or none; 0 for one side "
            "alone. (default: that of the robot's line)",
        ),
    ] = None,
    material: Material = None,
    law: Law = FeOptions.law,
    poisson: Poisson = FeOptions.poisson,
    mixed: Mixed = FeOptions.mixed,
    mesh: Mesh = "coarse",
    checkpoint: opt.Checkpoint = None,
    output: opt.RobotOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Reduce a joint of finite elements to a table of moment and volume for the twin.

    Pressures are those of the left side; angles are positive to the left. Every couple takes about as long as
    `fe bend`, so the mesh is coarse unless asked otherwise: half an hour per joint. The exit code is 1 if some points
    were not reached (the table is fitted to the others), 2 for bad input.
    """
    fish = load(robot)
    name = fish.joints[joint_index(joint, fish)].name
    with progress_bar("points", lines=True) as progress:
        reduced = reduce_joint(
            fish,
            name,
            pressure=rising(pressure),
            couple=None if moment is None else list(moment),
            fill=None if fill is None else 1e3 * fill,
            options=FeOptions(material, law, poisson, mesh, mixed),
            checkpoint=checkpoint,
            progress=progress,
        )
    if output is not None:
        write_reduced(robot, reduced, output)
    emit(
        reduced,
        record=lambda reduced: _record(reduced, output),
        lines=_lines,
        written=(output,),
        as_json=as_json,
        failed=reduced.status != "converged",
    )


def _record(reduced: ReducedJoint, output: str | None) -> dict[str, Any]:
    """Return the JSON record: over couples and pressures, and the table, over its angles and pressures."""
    fit, fitted = reduced.potential, reduced.table()
    moment, volume = reduced.over_angle(np.radians(fitted["angle_deg"]))
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
        "table": fitted,
        "over_angle": {"moment_n_m": moment, "volume_left_ml": 1e6 * volume[..., 0]},
        "terms": {"elastic": len(fit.elastic_terms), "volume": len(fit.volume_terms)},
        "compliance_m3_pa": fit.compliance,
        "cross_compliance_m3_pa": fit.cross,
        "moment_rms_n_m": reduced.residual.moment,
        "volume_rms_ml": 1e6 * reduced.residual.volume,
        "moment_rms_left_out_n_m": reduced.residual_new.moment,
        "volume_rms_left_out_ml": 1e6 * reduced.residual_new.volume,
        "seconds": reduced.seconds,
        "output": output,
        "status": reduced.status,
        "status_text": reduced.status_text,
    }


def _lines(reduced: ReducedJoint) -> Iterator[Any]:
    """Lay out angles and volumes of the points, and the residuals of the table."""
    fit = reduced.potential
    heads = ["left\n[kPa]", "right\n[kPa]", *(f"{couple:+.3g} N m\n[deg]  [ml]" for couple in reduced.couple)]
    rows = []
    for p, (left, right) in enumerate(reduced.pressure / 1e3):
        points = zip(np.degrees(reduced.angle[:, p]), 1e6 * reduced.volume[:, p, 0], strict=True)
        cells = [f"{angle:.2f}  {volume:.3f}" if np.isfinite(angle) else "not found" for angle, volume in points]
        rows.append([f"{left:.4g}", f"{right:.4g}", *cells])
    yield f"{reduced.robot.name}: joint {reduced.joint}, mesh {reduced.options.mesh}", "bold"
    yield table(heads, rows, left=())
    rms = f"{1e3 * reduced.residual.moment:.3g} mN m and {1e6 * reduced.residual.volume:.2g} ml"
    new = f"{1e3 * reduced.residual_new.moment:.3g} and {1e6 * reduced.residual_new.volume:.2g}"
    yield f"table to {np.degrees(fit.reach):.1f} deg either way; residuals {rms} rms ({new} of couples not fitted)"
    give, cross = fit.compliance, fit.cross
    text = f"angle held, a side takes {give:.2g} m^3/Pa for its own pressure, {cross:.2g} for that of the other side"
    yield f"{text}: {give - cross:.2g} at a constant sum"
    yield reduced.status_text, "green" if reduced.status == "converged" else "bold yellow"
