"""The command `hypertuna joint family`: designs of an actuator that agree with bench measurements."""

import math
from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.characterization.cards import fact_text
from hypertuna.characterization.checked import MESH, Checked, check_chosen
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.family import MEMBERS, MODEL_ERROR, Family, chosen_robot, family
from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.cli.joint import Bounds, Free
from hypertuna.description.writer import write_robot
from hypertuna.display import Part, Table, card_of
from hypertuna.errors import InputError
from hypertuna.fe.extra import need_fe
from hypertuna.fe.mesh import MESHES, mesh_size
from hypertuna.fe.model import FeOptions
from hypertuna.ranges import Range

ERRORS = Range(min=0, max=50, unit="percent")  # of --model-error
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
        opt.flag("--check", "Solve the chosen design by finite elements too, at the bench's pressures."),
    ] = False,
    mesh: Annotated[str | None, opt.text("--mesh", f"{', '.join(MESHES)}. (default: {MESH})")] = None,
    plot: opt.Plot = None,
    output: opt.RobotOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Sample the actuator designs that agree with measured bends, forces, shortenings and oil volumes.

    Lists what the measurements leave open, and what to measure next. --check needs the extra fe and takes about a
    minute for each pressure; the exit code is 1 if finite elements did not reach one.
    """
    if mesh is not None and not check:
        raise InputError("is used only with --check", key="--mesh", fix="add --check")
    fish, elements = robot.load(output), FeOptions(mesh=mesh or MESH)
    bench = read_bench(files, fish)
    if check:  # raises errors before minutes of work
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
        f"hypertuna fe bend --robot {output or 'FILE.toml'} --joint {fish.joints[joint].name} --pressure 0:{peak:g}:6"
        for joint in bench.joints
        for peak in [bench.pressure[bench.joint == joint].max() / 1e3]
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
        as_json=as_json,
        failed=checked is not None and any(checked.faults),
    )


def _lines(found: Family, checks: list[str], output: str | None, checked: Checked | None) -> Iterator[Part]:
    """Yield the lines that the terminal prints for a family of designs, with its check before the warnings."""
    lines = card_of(found).lines()
    warnings_start = len(lines) - 1 - len(found.warnings)
    yield from lines[:warnings_start]
    if checked is not None:
        yield from _check_lines(checked)
    else:
        next_step = "run" if output else "write it by -o FILE.toml, then"
        yield f"To check the chosen design by finite elements, add --check, or {next_step}:"
        yield from checks
    yield from lines[warnings_start:]


def _check_lines(checked: Checked) -> Iterator[Part]:
    """Yield the lines that compare the chosen design by finite elements with the fast model."""
    yield f"Chosen design by finite elements, mesh {checked.options.mesh}:", "bold"
    rows = [
        [
            *(fact_text(fact), fact["unit"], f"{fact['measured']:.3g}", f"{fact['chosen']:.3g}"),
            *(f"{fact['without_friction']:.3g}", f"{fact['elements']:.3g}" if math.isfinite(fact["elements"]) else ""),
            f"{fact['difference_percent']:+z.1f}" if math.isfinite(fact["difference_percent"]) else "",
        ]
        for fact in checked.facts
    ]
    heads = ["measured", "unit", "value", "fast model", "without\nfriction", "elements", "differs\n[%]"]
    yield Table(heads, rows, left=(0, 1))
    yield CHECK_LEGEND, "dim"
    for fault in dict.fromkeys(filter(None, checked.faults)):
        yield fault, "bold red"
