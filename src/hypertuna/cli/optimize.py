"""The command `hypertuna optimize`."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import (
    check_suffix,
    command_line,
    number,
    print_json,
    progress_bar,
    tell_written,
    whole_number,
)
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load, parse
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError, shown
from hypertuna.optimization.constraints import Limit, gait_limits
from hypertuna.optimization.optimize import Margin, Optimum, optimize
from hypertuna.optimization.robust import STATISTICS
from hypertuna.swimming.beat import QUANTITIES
from hypertuna.swimming.gait import Gait

__all__ = ["bounds_of", "gait_record", "limits_of", "optimize_app"]

optimize_app = typer.Typer(invoke_without_command=True)

Name = Annotated[
    str | None, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
]
Maximize = Annotated[str | None, typer.Option("--maximize", help="A quantity to make large: speed, efficiency ...")]
Minimize = Annotated[str | None, typer.Option("--minimize", help="A quantity to make small: cost_of_transport ...")]
Speed = Annotated[str | None, typer.Option("--speed", help="Expected speed in m/s, at low cost of transport (Eq. 42).")]
Weight = Annotated[
    str | None,
    typer.Option("--weight", help="k of Eq. 42, in m/s per J/(kg m) (default: small enough to hold the speed)"),
]
Method = Annotated[str, typer.Option("--method", help="pso, cma, gradient or de.")]
Particles = Annotated[
    str | None, typer.Option("--particles", help="Gaits per batch; starts of gradient (default: 15; gradient 6)")
]
Iterations = Annotated[str | None, typer.Option("--iterations", help="Batches at most (default: 60; cma 200)")]
Bounds = Annotated[
    list[str] | None,
    typer.Option("--bounds", help="NAME=LOW:HIGH, such as frequency_hz=1:4 or phase_II_deg=0:90; may be given again."),
]
Robust = Annotated[
    str | None,
    typer.Option("--robust", help="mean or worst5: the objective over robots sampled from the fit of --robot."),
]
Samples = Annotated[str, typer.Option("--samples", help="Robots to draw, with --robust.")]
Seed = Annotated[str, typer.Option("--seed", help="The same seed gives the same result.")]
Rate = Annotated[str | None, typer.Option("--max-joint-rate", help="Largest rate of a joint group in deg/s.")]
Torque = Annotated[str | None, typer.Option("--max-torque", help="Largest torque of a joint in N m.")]
Reach = Annotated[
    bool,
    typer.Option("--amplitude-by-bandwidth", help="Command no more than a joint makes of its largest amplitude."),
]
Strouhal = Annotated[str | None, typer.Option("--strouhal", help="LOW:HIGH of the Strouhal number.")]
Least = Annotated[str | None, typer.Option("--min-speed", help="Least speed in m/s.")]
Joints = Annotated[str | None, typer.Option("--joints", help="ideal or bandwidth (default: the robot's choice)")]
Areas = Annotated[str | None, typer.Option("--areas", help="consistent or as-printed (default: the robot's choice)")]
Water = Annotated[str | None, typer.Option("--water", help="lumped or strip (default: the robot's choice)")]


@optimize_app.callback()
def optimize_command(
    context: typer.Context,
    robot: Name = None,
    maximize: Maximize = None,
    minimize: Minimize = None,
    speed: Speed = None,
    weight: Weight = None,
    method: Method = "pso",
    particles: Particles = None,
    iterations: Iterations = None,
    bounds: Bounds = None,
    robust: Robust = None,
    samples: Samples = "32",
    seed: Seed = "1",
    max_joint_rate: Rate = None,
    max_torque: Torque = None,
    amplitude_by_bandwidth: Reach = False,
    strouhal: Strouhal = None,
    min_speed: Least = None,
    joints: Joints = None,
    areas: Areas = None,
    water: Water = None,
    checkpoint: Annotated[
        str | None, typer.Option("--checkpoint", help="File to keep the work in, and to take it up from.")
    ] = None,
    plot: Annotated[
        str | None, typer.Option("--plot", help="Draw the convergence to this .svg, .png or .pdf file.")
    ] = None,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", help="Write the robot with the gait, named best, to this .toml file."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Find the best gait for an objective: the highest speed, or an expected speed at low cost of transport.

    The exit code is 0 for a gait, 1 if none keeps all limits, 2 for bad input.
    """
    if context.invoked_subcommand is not None:
        sources = {key: str(context.get_parameter_source(key)) for key in context.params}
        if given := [key for key, source in sources.items() if source.endswith("COMMANDLINE")]:
            rule = f"must come after {context.invoked_subcommand}"
            raise InputError(rule, key=f"--{given[0].replace('_', '-')}", fix="see its --help")
        return
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    check_suffix(output, (".toml",), "--output")
    if robot is None:
        raise InputError("is missing", key="--robot", fix="give a robot's name or the path of its file")
    fish = load(robot).using(joints=joints, areas=areas, water=water)
    limits = limits_of(fish, max_joint_rate, max_torque, amplitude_by_bandwidth, strouhal, min_speed)
    with progress_bar("optimizing") as progress:
        best = optimize(
            fish,
            maximize=maximize,
            minimize=minimize,
            speed=None if speed is None else number(speed, "--speed", "m/s"),
            weight=None if weight is None else number(weight, "--weight", "m/s per J/(kg m)"),
            bounds=bounds_of(bounds),
            limits=limits,
            method=method,
            particles=None if particles is None else whole_number(particles, "--particles"),
            iterations=None if iterations is None else whole_number(iterations, "--iterations"),
            robust=robust,
            samples=whole_number(samples, "--samples"),
            seed=whole_number(seed, "--seed"),
            checkpoint=checkpoint,
            progress=progress,
        )
    if as_json:
        print_json(_record(best))
    else:
        _print(best)
    if plot is not None:
        _plot(best, plot)
    if best.gait is None:
        raise typer.Exit(1)
    if output is not None:
        write_robot(_with_gait(best.robot, best.gait), output)
    if not as_json:
        tell_written(output, plot)


def bounds_of(texts: list[str] | None) -> dict[str, tuple[float, float]]:
    """Read bounds NAME=LOW:HIGH.

    Parameters
    ----------
    texts : list of str or None

    Returns
    -------
    dict
        Lowest and highest value as given, by name [Hz or deg].

    Raises
    ------
    InputError
        If one cannot be read.
    """
    bounds = {}
    for text in texts or []:
        name, equals, pair = text.partition("=")
        if not equals:
            fix = "write, for example, --bounds frequency_hz=1:4"
            raise InputError("must be NAME=LOW:HIGH", key="--bounds", value=shown(text), fix=fix)
        bounds[name] = _pair_of(pair, f"--bounds {name}", "Hz or degrees")
    return bounds


def limits_of(
    robot: Robot, rate: str | None, torque: str | None, reach: bool, strouhal: str | None, speed: str | None
) -> tuple[Limit, ...]:
    """Read the limits.

    Parameters
    ----------
    robot : Robot
    rate, torque, strouhal, speed : str or None
        Values of the options --max-joint-rate, --max-torque, --strouhal and --min-speed.
    reach : bool
        That of --amplitude-by-bandwidth.

    Returns
    -------
    tuple of Limit

    Raises
    ------
    InputError
        If one cannot be read or used.
    """
    return gait_limits(
        robot,
        joint_rate=None if rate is None else float(np.radians(number(rate, "--max-joint-rate", "deg/s"))),
        torque=None if torque is None else number(torque, "--max-torque", "N m"),
        amplitude_by_bandwidth=reach,
        strouhal=None if strouhal is None else _pair_of(strouhal, "--strouhal", "1"),
        speed=None if speed is None else number(speed, "--min-speed", "m/s"),
    )


def _pair_of(text: str, key: str, unit: str) -> tuple[float, float]:
    """Read LOW:HIGH, as given."""
    parts = text.split(":")
    if len(parts) != 2:
        raise InputError("must be LOW:HIGH", key=key, value=shown(text), fix=f"give two numbers in {unit}")
    return number(parts[0], key, unit), number(parts[1], key, unit)


def _record(best: Optimum) -> dict[str, Any]:
    """Say what was found, for programs."""
    target = best.objective
    return {
        "gait": None if best.gait is None else gait_record(best.gait),
        "speed_m_s": best.speed,
        "cost_of_transport_j_per_kg_m": best.cost_of_transport,
        "evaluations": best.evaluations,
        "seconds": best.seconds,
        "stop": best.stop,
        "remark": best.remark,
        "method": best.method,
        "seed": best.seed,
        "objective": {
            "name": target.name,
            "terms": dict(target.terms),
            "expected_speed_m_s": target.expected,
            "weight_threshold_m_s_per_j_per_kg_m": best.weight_threshold,
        },
        "value": best.value,
        "robust": best.robust,
        "history": best.history,
        "constraints": [_margin_record(margin) for margin in best.margins],
        "on_bounds": dict(best.bounds),
        "near_best": {name: np.round(ends, 10) for name, ends in best.near_best.items()},
        "command": command_line(),
    } | provenance(best.robot)


def gait_record(gait: Gait) -> dict[str, Any]:
    """Write a gait as files do; a bias only if there is one.

    Parameters
    ----------
    gait : Gait

    Returns
    -------
    dict
    """
    kinds = ("amplitude", "phase", "bias") if any(gait.bias) else ("amplitude", "phase")
    angles = {f"{kind}_deg": np.degrees(getattr(gait, kind)).round(10).tolist() for kind in kinds}
    return {"frequency_hz": gait.frequency} | angles


def _margin_record(margin: Margin) -> dict[str, Any]:
    """Say how a limit is kept."""
    limit = margin.limit
    return {
        "name": limit.quantity,
        "value": margin.value / limit.scale,
        "limit": limit.limit / limit.scale,
        "unit": limit.unit,
        "kind": "largest" if limit.upper else "least",
        "margin": margin.margin,
        "active": margin.active,
    }


def _print(best: Optimum) -> None:
    """Print the gait as a small table, and sentences."""
    console = Console()
    console.print(Text(f"{best.robot.name}, {_wished(best)}", style="bold"))
    if best.gait is not None and best.swim is not None:
        table = Table(box=None, pad_edge=False, show_header=False)
        table.add_column(style="dim")
        table.add_column(justify="right", style="bold")
        table.add_column()
        for row in _rows(best, best.gait):
            table.add_row(*row)
        console.print(table)
    console.print(Text(best.stop, style="green" if best.gait is not None else "bold red"))
    if best.remark:
        console.print(Text(best.remark, style="" if best.near_best else "yellow"))
    console.print(Text(f"{best.evaluations} gaits by {best.method}, seed {best.seed}", style="dim"))


def _wished(best: Optimum) -> str:
    """Describe the objective."""
    target = best.objective
    name, factor = target.terms[0]
    words = f"{'largest' if factor < 0 else 'least'} {name.replace('_', ' ')}"
    if target.expected is not None:
        words = f"expected speed {target.expected:g} m/s at low cost of transport, weight {factor:g}"
    return words if best.robust is None else f"{words}, over robots sampled from the fit"


def _rows(best: Optimum, gait: Gait) -> list[tuple[str, str, str]]:
    """Rows of the table: the gait with the bounds that it lies on, what it makes, its limits."""
    groups = [group.name for group in best.robot.joints]

    def end(column: str) -> str:
        return f" ({best.bounds[column]} bound)" if column in best.bounds else ""

    rows = [("frequency", f"{gait.frequency:.4g}", "Hz" + end("frequency_hz"))]
    for kind in ("amplitude", "phase") + (("bias",) if any(gait.bias) else ()):
        for name, angle in zip(groups, np.degrees(getattr(gait, kind)), strict=True):
            rows.append((f"{kind} {name}", f"{angle:.4g}", "deg" + end(f"{kind}_{name}_deg")))
    rows += [
        ("speed", f"{best.speed:.4g}", "m/s"),
        ("cost of transport", f"{best.cost_of_transport:.4g}", "J/(kg m)"),
    ]
    if best.robust is not None:  # all above is of the robot itself
        name, factor = best.objective.terms[0]
        value, unit = factor * best.value, QUANTITIES[name].unit
        if best.objective.expected is not None:
            name, value, unit = "|U - Ue| + k COT", best.value, "m/s"
        rows.append((f"{name.replace('_', ' ')}, sampled robots", f"{value:.4g}", f"{unit}, {STATISTICS[best.robust]}"))
    for margin in best.margins:
        record = _margin_record(margin)
        unit = "" if record["unit"] == "1" else f" {record['unit']}"
        side = "at most" if margin.limit.upper else "at least"
        active = ", active" if margin.active else ""
        name = record["name"].replace("_", " ")
        rows.append((name, f"{record['value']:.4g}", f"{unit.strip()} ({side} {record['limit']:g}{active})".strip()))
    return rows


def _with_gait(robot: Robot, gait: Gait) -> Robot:
    """Return the robot with one more gait in its file, and where that is from."""
    document = robot.document()
    gaits = document.get("gaits", {}) | {"best": gait_record(gait)}
    sources = document.get("sources", {}) | {"gaits.best": command_line()}
    return parse(document | {"gaits": gaits, "sources": sources}, file=robot.file)


def _plot(best: Optimum, plot: str) -> None:
    """Draw the convergence."""
    from hypertuna.figures import save
    from hypertuna.optimization.plots import plot_convergence

    save(plot_convergence([best]), plot)


# Both need what is above.
from hypertuna.cli.experiment import ask_command, tell_command  # noqa: E402

optimize_app.command("ask")(ask_command)
optimize_app.command("tell")(tell_command)
