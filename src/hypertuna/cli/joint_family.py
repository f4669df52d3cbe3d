"""The command `hypertuna joint family`: all designs of an actuator that meet what was measured."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.characterization.data import read_bench
from hypertuna.characterization.family import MEMBERS, MODEL_ERROR, Family, Next, chosen_robot, family
from hypertuna.cli import options as opt
from hypertuna.cli.console import counted, progress_bar, table
from hypertuna.cli.emit import emit
from hypertuna.cli.joint import Bounds, Free
from hypertuna.description.writer import write_robot
from hypertuna.ranges import Range

ERRORS = Range(min=0, max=50, unit="percent")
MEASUREMENTS, NARROWED = 8, 3  # rows of the list of measurements, and quantities named in each


@opt.grouped
def family_command(
    files: Annotated[
        list[str],
        typer.Argument(help="CSV files of bench runs: bends, blocked forces or moments, shortenings, oil volumes."),
    ],
    robot: opt.RobotOptions,
    free: Free = None,
    bounds: Bounds = None,
    members: Annotated[int, opt.whole_number("--members", "Number of designs in the sample.")] = MEMBERS,
    model_error: Annotated[
        float,
        opt.number(
            "--model-error", "percent", "Error of the fast model, relative to each measured value.", limits=ERRORS
        ),
    ] = 100 * MODEL_ERROR,
    seed: opt.Seed = 0,
    plot: opt.Plot = None,
    output: opt.RobotOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Sample all designs of an actuator that meet measured bends, forces, shortenings and volumes.

    Lists what the measurements leave open, and what to measure next.
    """
    fish = robot.load(output)
    bench = read_bench(files, fish)
    prior = {name: (low, high) for name, low, high in bounds or []}
    options: dict[str, Any] = {"bounds": prior, "members": members, "model_error": model_error / 100, "seed": seed}
    with progress_bar("drawing designs") as progress:
        found = family(fish, bench, free, progress=progress, **options)
    if output is not None:
        write_robot(chosen_robot(found), output, note="one of many that fit, see [sources]")
    checks = [
        f"hypertuna fe bend --robot {output or 'FILE.toml'} --joint {fish.joints[joint].name} --pressure 0:{top:g}:6"
        for joint in bench.joints
        for top in [bench.pressure[bench.joint == joint].max() / 1e3]
    ]
    emit(
        found,
        record=lambda found: found.record | {"files": files, "checks": checks, "output": output},
        lines=lambda found: _lines(found, checks, output),
        plot=plot,
        written=(output,),
        figure="hypertuna.characterization.family_plots:plot_family",
        as_json=as_json,
    )


def _lines(found: Family, checks: list[str], output: str | None) -> Iterator[Any]:
    """Lay out a family."""
    bench, robot = found.space.bench, found.space.robot
    joints = f"joint{'s' * (len(bench.joints) > 1)} {' and '.join(robot.joints[j].name for j in bench.joints)}"
    yield (
        f"{robot.name}, {joints}: {len(found.members)} designs that meet {counted(len(found.space.sd), 'value')}",
        "bold",
    )
    rows = [
        [
            *(f"{one['joint']}, {one['pressure_kpa']:g} kPa: {one['kind']}", one["unit"]),
            *(f"{one[key]:.3g}" for key in ("measured", "sd")),
            *(f"{one['low']:.3g} .. {one['high']:.3g}", f"{one['chosen']:.3g}", f"{one['residual']:+.1f}"),
        ]
        for one in found.facts
    ]
    yield table(["measured", "unit", "value", "sd", "90 % of designs", "chosen", "residual\n[sd]"], rows, left=(0, 1))
    rows = [
        [one.text, one.unit, f"{one.interval[0]:.3g} .. {one.interval[2]:.3g}", f"{one.values[found.middle]:.3g}"]
        for one in found.quantities
    ]
    yield table(["open", "unit", "90 % of designs", "chosen"], rows, left=(0, 1))
    rows = [
        [
            *(one["name"], one["unit"].removeprefix("1"), f"{one['lower']:.3g} .. {one['upper']:.3g}"),
            *(f"{one['low']:.3g} .. {one['high']:.3g}", f"{one['chosen']:.3g}"),
        ]
        for one in found.rows
    ]
    yield table(["unknown", "unit", "bounds", "90 % of designs", "chosen"], rows, left=(0, 1))
    yield "What to measure next, the most informative first:", "bold"
    for measurement in found.next[:MEASUREMENTS]:
        yield _told(measurement)
    yield f"To check the chosen design by finite elements{'' if output else ', write it by -o FILE.toml, then'}:"
    yield from checks
    for warning in found.warnings:
        yield warning, "yellow"
    population = found.population
    yield (
        f"{counted(population.tried, 'design')} drawn within the bounds, {counted(population.evaluations, 'design')} "
        f"computed in all, seed {found.seed}, {found.seconds:.1f} s.",
        "green",
    )


def _told(one: Next) -> str:
    """Write what a measurement would tell."""
    expected = ", or ".join(f"{low:.3g} to {high:.3g}" for low, high in one.expected)
    most = list(one.narrows.items())
    parts = [f"{text} to {100 * ratio:.0f} %" for text, ratio in most[:NARROWED]]
    parts += [f"{len(most) - NARROWED} more"] * (len(most) > NARROWED)
    narrowed = ", ".join(parts) or "nothing by a tenth"
    return f"{one.bits:4.1f} bits  {one.text}: {expected} {one.unit}. It narrows {narrowed}."
