"""The command `hypertuna joint spring`: the spring of a hinge from a bench test."""

import math
from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.characterization.spring import COLUMNS, SpringFit, fit_spring, hinge_of, read_spring, with_spring
from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit
from hypertuna.description.robot import Robot
from hypertuna.description.writer import write_robot
from hypertuna.display import Part, card_of
from hypertuna.io.files import version


@opt.grouped
def spring_command(
    file: Annotated[str, typer.Argument(help=f"CSV file of a bench test: {', '.join(COLUMNS)}; one load in each row.")],
    robot: opt.RobotOptions,
    arm: Annotated[
        float | None, opt.number("--arm", "m", "Distance of the loads from the hinge's axis, of rows without arm_m.")
    ] = None,
    tilt: Annotated[
        float, opt.number("--tilt", "degrees", "Angle of the fin below the horizontal without a load.")
    ] = 0,
    hinge: Annotated[
        str | None,
        opt.text("--hinge", "Link behind the hinge, or its number from the head, where there are several.", "HINGE"),
    ] = None,
    plot: opt.Plot = None,
    output: opt.RobotOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Fit the stiffness of a hinge to weights and angles, with its 95 % interval.

    A cubic term is added where it improves the fit significantly. -o writes the spring of one hinge to the robot.
    """
    fish = robot.load(output)
    if hinge is not None:
        hinge_of(fish, hinge)
    fit = fit_spring(read_spring(file, arm=arm), tilt=math.radians(tilt))
    if output is not None:
        write_robot(with_spring(fish, fit, hinge), output, note="bench test, see [sources]")
    emit(
        fit,
        record=lambda fit: _record(fish, fit) | {"output": output},
        lines=lambda fit: _lines(fish, fit),
        plot=plot,
        written=(output,),
        as_json=as_json,
    )


def _record(fish: Robot, fit: SpringFit) -> dict[str, Any]:
    """Return the JSON record of a fit."""
    return {
        "hypertuna_version": version(),
        "file": fit.test.file,
        "rows": fit.rows,
        "tilt_deg": math.degrees(fit.tilt),
        "stiffness_n_m_per_rad": fit.stiffness,
        "stiffness_sd_n_m_per_rad": fit.stiffness_sd,
        "stiffness_interval_n_m_per_rad": fit.stiffness_interval,
        "zero_deg": math.degrees(fit.zero),
        "zero_interval_deg": [math.degrees(end) for end in fit.zero_interval],
        "cubic_n_m_per_rad3": fit.cubic,
        "cubic_interval_n_m_per_rad3": fit.cubic_interval,
        "cubic_chance": fit.chance,
        "softens": fit.softens,
        "rms_deg": math.degrees(fit.rms),
        "rms_without_cubic_deg": math.degrees(fit.rms_straight),
        "described_n_m_per_rad": [hinge.stiffness for hinge in fish.hinges],
    }


def _lines(fish: Robot, fit: SpringFit) -> Iterator[Part]:
    """Yield the lines that the terminal prints for a fit, and what the robot's file has."""
    yield from card_of(fit).lines()
    if fish.hinges:
        yield f"{fish.name} has {', '.join(f'{hinge.stiffness:.4g}' for hinge in fish.hinges)} N m/rad"
