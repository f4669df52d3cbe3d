"""The command `hypertuna joint family`: all designs of an actuator that meet what was measured."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

import typer

from hypertuna.characterization.checked import MESH, Checked, check_chosen
from hypertuna.characterization.data import BRANCHES, read_bench
from hypertuna.characterization.family import MEMBERS, MODEL_ERROR, Family, Next, chosen_robot, family
from hypertuna.cli import options as opt
from hypertuna.cli.console import counted, progress_bar, table
from hypertuna.cli.emit import emit
from hypertuna.cli.joint import Bounds, Free
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError
from hypertuna.fe.extra import need_fe
from hypertuna.fe.mesh import MESHES, mesh_size
from hypertuna.fe.model import FeOptions
from hypertuna.ranges import Range

ERRORS = Range(min=0, max=50, unit="percent")
MEASUREMENTS, NARROWED = 8, 3  # rows of the list of measurements, and quantities named in each
CHECK_LEGEND = (
    "Measured values contain the friction of the braids, and so does the fast model. Finite elements have no friction: "
    "the last column is the difference of the fast model without friction from them."
)


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
    check: Annotated[
        bool,
        typer.Option("--check", help="Solve the chosen design by finite elements too, at the bench's pressures."),
    ] = False,
    mesh: Annotated[str | None, opt.text("--mesh", f"{', '.join(MESHES)}. (default: {MESH})")] = None,
    plot: opt.Plot = None,
    output: opt.RobotOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Sample all designs of an actuator that meet measured bends, forces, shortenings and volumes.

    Lists what the measurements leave open, and what to measure next. --check needs the extra fe and takes about a
    minute for each pressure; the exit code is 1 if finite elements did not reach one.
    """
    if mesh is not None and not check:
        raise InputError("is used only with --check", key="--mesh", fix="add --check")
    fish, elements = robot.load(output), FeOptions(mesh=mesh or MESH)
    bench = read_bench(files, fish)
    if check:  # before minutes of work
        mesh_size(elements.mesh)
        need_fe()
    prior = {name: (low, high) for name, low, high in bounds or []}
    options: dict[str, Any] = {"bounds": prior, "members": members, "model_error": model_error / 100, "seed": seed}
    with progress_bar("drawing designs") as progress:
        found = family(fish, bench, free, progress=progress, **options)
    if output is not None:
        write_robot(chosen_robot(found), output, note="one of many that fit, see [sources]")
    checked = None
    if check:
        with progress_bar("finite elements", slow=True) as progress:
            checked = check_chosen(found, elements, progress=progress)
    checks = [
        f"hypertuna fe bend --robot {output or 'FILE.toml'} --joint {fish.joints[joint].name} --pressure 0:{top:g}:6"
        for joint in bench.joints
        for top in [bench.pressure[bench.joint == joint].max() / 1e3]
    ]
    emit(
        found,
        record=lambda found: (
            found.record
            | {"files": files, "checks": checks, "output": output}
            | ({} if checked is None else {"check": checked.record})
        ),
        lines=lambda found: _lines(found, checks, output, checked),
        plot=plot,
        written=(output,),
        figure="hypertuna.characterization.family_plots:plot_family",
        as_json=as_json,
        failed=checked is not None and any(checked.faults),
    )


def _lines(found: Family, checks: list[str], output: str | None, checked: Checked | None) -> Iterator[Any]:
    """Lay out a family."""
    bench, robot = found.space.bench, found.space.robot
    joints = f"joint{'s' * (len(bench.joints) > 1)} {' and '.join(robot.joints[j].name for j in bench.joints)}"
    yield (
        f"{robot.name}, {joints}: {len(found.members)} designs that meet {counted(len(found.space.sd), 'value')}",
        "bold",
    )
    rows = [
        [
            *(_fact(one), one["unit"]),
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
    if checked is not None:
        yield from _check_lines(checked)
    else:
        then = "run" if output else "write it by -o FILE.toml, then"
        yield f"To check the chosen design by finite elements, add --check, or {then}:"
        yield from checks
    for warning in found.warnings:
        yield warning, "yellow"
    population = found.population
    yield (
        f"{counted(population.tried, 'design')} drawn within the bounds, {counted(population.evaluations, 'design')} "
        f"computed in all, seed {found.seed}, {found.seconds:.1f} s.",
        "green",
    )


def _fact(one: Mapping[str, Any]) -> str:
    """Name a measured value."""
    falling = ", falling" if one["branch"] == BRANCHES[1] else ""
    return f"{one['joint']}, {one['side']}, {one['pressure_kpa']:g} kPa{falling}: {one['kind']}"


def _check_lines(checked: Checked) -> Iterator[Any]:
    """Lay out the chosen design by finite elements, beside the fast model."""
    yield f"Chosen design by finite elements, mesh {checked.options.mesh}:", "bold"
    rows = [
        [
            *(_fact(one), one["unit"], f"{one['measured']:.3g}", f"{one['chosen']:.3g}"),
            *(f"{one['without_friction']:.3g}", f"{one['elements']:.3g}" if math.isfinite(one["elements"]) else ""),
            f"{one['difference_percent']:+z.1f}" if math.isfinite(one["difference_percent"]) else "",
        ]
        for one in checked.facts
    ]
    heads = ["measured", "unit", "value", "fast model", "without\nfriction", "elements", "differs\n[%]"]
    yield table(heads, rows, left=(0, 1))
    yield CHECK_LEGEND, "dim"
    for fault in dict.fromkeys(filter(None, checked.faults)):
        yield fault, "bold red"


def _told(one: Next) -> str:
    """Write what a measurement would tell."""
    expected = ", or ".join(f"{low:.3g} to {high:.3g}" for low, high in one.expected)
    most = list(one.narrows.items())
    parts = [f"{text} to {100 * ratio:.0f} %" for text, ratio in most[:NARROWED]]
    parts += [f"{len(most) - NARROWED} more"] * (len(most) > NARROWED)
    narrowed = ", ".join(parts) or "nothing by a tenth"
    return f"{one.bits:4.1f} bits  {one.text}: {expected} {one.unit}. It narrows {narrowed}."
