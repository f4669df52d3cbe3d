"""The commands `hypertuna actuator ...`: what tests at the bench tell of an actuator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.actuation.silicone import UP_TO, TensileFit, TensileTest, fit_silicone, read_tensile
from hypertuna.characterization.combinations import DETERMINED, Combination
from hypertuna.characterization.data import Bench, read_bench
from hypertuna.characterization.experiment_design import InformationGain, information_gain
from hypertuna.characterization.fit import BenchFit, fit_bench
from hypertuna.characterization.unknowns import BORDER, FACTORS, Unknown
from hypertuna.cli.old_console import check_suffix, number, print_json, progress_bar, tell_written, whole_number
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError
from hypertuna.io.files import version

__all__ = ["actuator_app"]

actuator_app = typer.Typer(no_args_is_help=True, help="What tests at the bench tell of an actuator.")


@actuator_app.command("silicone")
def silicone_command(
    file: Annotated[
        str,
        typer.Argument(
            help="CSV file of a tensile test: Engineering Strain (a fraction, or with (%) in its name), then "
            "Engineering Stress (MPa), (kPa) or (Pa)."
        ),
    ],
    up_to: Annotated[str, typer.Option("--up-to", help="Largest strain to fit, in percent.")] = f"{100 * UP_TO:g}",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Fit the elastic constants of a silicone, C1 and C2 of Mooney and Rivlin, to a tensile test."""
    test = read_tensile(file)
    fit = fit_silicone(test, up_to=number(up_to, "--up-to", "percent") / 100)
    if as_json:
        print_json(_record(file, test, fit))
        return
    solid, console = fit.solid, Console()
    console.print(Text(f"{test.name}: tensile_pa = [{solid.c1:.0f}, {solid.c2:.0f}]", style="bold"))
    console.print(Text(f"Young's modulus at small strain: {solid.modulus / 1e3:.1f} kPa"))
    if math.isfinite(fit.stress_100):
        fitted, measured = solid.modulus_100 / 1e3, fit.stress_100 / 1e3
        console.print(Text(f"stress at 100 % strain: {measured:.1f} kPa measured, {fitted:.1f} kPa fitted"))
    console.print(Text(f"rms of what the fit leaves: {fit.rms / 1e3:.2g} kPa"))
    if test.left_out:
        console.print(Text(f"{test.left_out} rows lack strain or stress and were left out"))
    console.print(Text(fit.status, style="green"))


def _record(file: str, test: TensileTest, fit: TensileFit) -> dict[str, Any]:
    """Tell a fit, for programs."""
    return {
        "hypertuna_version": version(),
        "file": file,
        "material": test.name,
        "tensile_pa": list(fit.solid),
        "without_bounds_pa": list(fit.free),
        "modulus_pa": fit.solid.modulus,
        "stress_100_pa": fit.stress_100,
        "stress_100_fitted_pa": fit.solid.modulus_100,
        "strain_max": fit.up_to,
        "strain_asked": fit.asked,
        "points": fit.points,
        "left_out": test.left_out,
        "rms_pa": fit.rms,
        "status": fit.status,
    }


NOISE = {"angle": ("deg", 180 / math.pi), "volume": ("ml", 1e6)}
COUNTED = {
    "segment_length": "x described",
    "hose_modulus": "x described",
    "matrix_modulus": "x described",
    "asymmetry": "left / right",
    "diameter_ratio": "inner / outer",
}
SMALL = 0.5  # an interval of a logarithm that still reads well as a percentage
MEASUREMENTS, NARROWED = 8, 3  # rows of the table of measurements, and unknowns told in each


@actuator_app.command("fit")
def fit_command(
    files: Annotated[
        list[str],
        typer.Argument(
            help="CSV files of bench runs: joint, side, pressure_kpa, angle_deg, and angle_sd_deg where rows are few "
            "(up to about as many as unknowns)."
        ),
    ],
    robot: Annotated[
        str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
    ],
    free: Annotated[
        str | None, typer.Option("--free", help="Unknowns to fit, such as lever,friction (default: all)")
    ] = None,
    bounds: Annotated[
        list[str] | None,
        typer.Option("--bounds", help="NAME=LOW:HIGH in mm, deg or 1: what you know of an unknown; again for more."),
    ] = None,
    loss: Annotated[str, typer.Option("--loss", help="soft_l1, linear, huber or cauchy.")] = "soft_l1",
    starts: Annotated[str, typer.Option("--starts", help="Searches, each from another start.")] = "3",
    seed: Annotated[str, typer.Option("--seed", help="Of the starts.")] = "0",
    plot: Annotated[
        str | None, typer.Option("--plot", help="Draw loops and spectrum to this .svg, .png or .pdf file.")
    ] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write the fitted robot to this .toml.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Identify what pressures and bends of a bench tell of an actuator, and say what they leave free.

    Exit code 1 means that the search did not converge.
    """
    check_suffix(output, (".toml",), "--output")
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    fish = load(robot)
    bench = read_bench(files, fish)
    with progress_bar("fitting") as progress:
        fit = fit_bench(
            fish,
            bench,
            free,
            bounds=_bounds(bounds or []),
            loss=loss,
            starts=whole_number(starts, "--starts"),
            seed=whole_number(seed, "--seed"),
            progress=progress,
        )
    more = information_gain(fit)
    if plot is not None:
        from hypertuna.characterization.plots import plot_bench
        from hypertuna.figures import save

        save(plot_bench(fit), plot)
    if output is not None:
        write_robot(fit.robot, output, note="fitted, see [sources]")
    if as_json:
        print_json(_bench_record(fit, more, files, output))
    else:
        _print(fit, more)
        tell_written(plot, output)
    if not fit.converged:
        raise typer.Exit(1)


def _bounds(texts: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Read bounds, in the units of the border."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        ends = value.split(":")
        if not equals or len(ends) != 2:
            fix = "write it as lever[I]=10:16"
            raise InputError("must be NAME=LOW:HIGH", key="--bounds", value=text, fix=fix)
        kind = name.partition("[")[0].strip()
        unit, factor = BORDER[Unknown(kind, None, "", 1.0, 1.0, 1.0).unit]
        low, high = (number(end, f"--bounds {name}", unit) / factor for end in ends)
        found[name.strip()] = (low, high)
    return found


def _unknowns(fit: BenchFit) -> list[dict[str, Any]]:
    """Say what became of each unknown, in the units that people read."""
    rows = []
    for one, value, low, high, narrowing in zip(fit.free, fit.values, fit.low, fit.high, fit.narrowing, strict=True):
        unit, factor = BORDER[one.unit]
        rows.append(
            {
                "name": one.name,
                "described": one.described * factor,
                "value": value * factor,
                "low": low * factor,
                "high": high * factor,
                "unit": unit,
                "counted": COUNTED.get(one.kind, ""),
                "lower": one.lower * factor,
                "upper": one.upper * factor,
                "narrowing": narrowing,
                "determined": bool(narrowing >= DETERMINED),
            }
        )
    return rows


def _bench_record(
    fit: BenchFit, more: Sequence[InformationGain], files: Sequence[str], output: str | None
) -> dict[str, Any]:
    """Say what a fit found, for programs."""
    bench = fit.bench
    return provenance(fit.described) | {
        "files": list(files),
        "rows": len(bench.angle),
        "joints_measured": [fit.described.joints[j].name for j in bench.joints],
        "unknowns": _unknowns(fit),
        "determined": len(fit.combinations),
        "combinations": [_combination(one) for one in fit.combinations],
        "spectrum": [
            {"singular_value": d.singular_value, "sd": d.sd, "determined": d.determined, "vector": d.vector}
            for d in fit.directions
        ],
        "correlation": fit.correlation,
        "measurements": [_measurement(one) for one in more],
        "noise": {f"{kind}_{NOISE[kind][0]}": value * NOISE[kind][1] for kind, value in fit.noise.items()},
        "rms": {f"{kind}_{NOISE[kind][0]}": value * NOISE[kind][1] for kind, value in fit.rms.items()},
        "residual_scale": fit.residual_scale,
        "freedom": fit.freedom,
        "stop": fit.stop,
        "converged": fit.converged,
        "evaluations": fit.evaluations,
        "seconds": fit.seconds,
        "loss": fit.loss,
        "warnings": fit.warnings,
        "fit_hash": fit.robot.hash,
        "output": output,
    }


def _combination(one: Combination) -> dict[str, Any]:
    """Tell a combination, for programs."""
    return {
        "text": one.text,
        "exponents": one.exponents,
        "unknown": one.unknown,
        "value": one.value,
        "low": one.low,
        "high": one.high,
        "narrowing": one.narrowing,
    }


def _measurement(one: InformationGain) -> dict[str, Any]:
    """Tell what a measurement is worth, for programs."""
    narrowed = [{"name": name, "before_log": one.before[name], "after_log": after} for name, after in one.after.items()]
    facts = {"measure": one.text, "unit": one.unit, "expected": one.value, "expected_half_interval": one.half_interval}
    return facts | {"sd": one.sd, "bits": one.bits, "narrowed": narrowed}


def _print(fit: BenchFit, more: Sequence[InformationGain]) -> None:
    """Print a fit as tables and sentences."""
    console, bench = Console(), fit.bench
    joints = " and ".join(fit.described.joints[j].name for j in bench.joints)
    rows, n, known = len(bench.angle), len(fit.free), len(fit.combinations)
    console.print(Text(f"{fit.robot.name}, {_joints(bench)} {joints}: {_count(rows, 'row')}", style="bold"))
    told = [f"{kind} {value * NOISE[kind][1]:.2g} {NOISE[kind][0]}" for kind, value in fit.rms.items()]
    console.print(Text(f"rms of what the fit leaves: {', '.join(told)}"))
    console.print(_unknown_table(fit))
    sentence = f"The bench determines {known} of {n} combinations of the unknowns, {n - known} stay free."
    console.print(Text(sentence, style="bold"))
    table = Table("combination, over the described one", box=None, pad_edge=False, header_style="bold")
    for name in ("value", "95 % interval"):
        table.add_column(name, justify="right", no_wrap=True)
    for one in fit.combinations:
        sure = f"{one.low:.3g} .. {one.high:.3g}, {_half(math.log(one.high / one.low) / 2)}"
        table.add_row(Text(one.text), f"{one.value:.3g}", sure)
    console.print(table)
    used = {name for one in fit.combinations for name in one.exponents}
    for name, meaning in FACTORS.values():
        if name in used:
            console.print(Text(f"{name} = {meaning}", style="dim"))
    spectrum = ", ".join(f"{d.singular_value:.2g}" if d.singular_value > 1e-3 else "0" for d in fit.directions)
    console.print(Text(f"singular values, bench over bounds: {spectrum}"))
    if more:
        _print_information_gain(console, more)
    for warning in fit.warnings:
        console.print(Text(warning, style="yellow"))
    ending = f"{fit.stop} {fit.seconds:.1f} s in all."
    console.print(Text(ending, style="green" if fit.converged else "bold red"))


def _unknown_table(fit: BenchFit) -> Table:
    """Lay out the unknowns."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("unknown", overflow="fold")
    for name in ("described", "fitted", "95 % interval"):
        table.add_column(name, justify="right", no_wrap=True)
    for name in ("unit", ""):
        table.add_column(name, no_wrap=True)
    for row in _unknowns(fit):
        interval = f"{row['low']:.3g} .. {row['high']:.3g}"
        unit = row["counted"] or row["unit"].removeprefix("1")
        remark = "" if row["determined"] else "free"
        cells = (f"{row['described']:.3g}", f"{row['value']:.3g}", interval, unit)
        table.add_row(Text(row["name"]), *cells, Text(remark, style="yellow"))
    return table


def _print_information_gain(console: Console, more: Sequence[InformationGain]) -> None:
    """Say what measurements are worth, one to a paragraph."""
    console.print(Text("What one more measurement would narrow, the most informative first:", style="bold"))
    for one in more[:MEASUREMENTS]:
        parts = [f"{name} {_half(one.before[name])} to {_half(after)}" for name, after in one.after.items()]
        left = len(parts) - NARROWED
        told = ", ".join(parts[:NARROWED]) + f", {left} more" * (left > 0)
        expected = f"expected {one.value:.3g} \u00b1 {one.half_interval:.2g} {one.unit}, known to {one.sd:.2g}"
        console.print(Text(f"{one.bits:4.1f} bits  {one.text} ({expected}): {told or 'no unknown by a tenth'}"))


def _half(log: float) -> str:
    """Write half an interval of a logarithm: as a percentage, or as a factor where it is wide."""
    return f"\u00b1{100 * log:.2g} %" if log < SMALL else f"\u00d7/\u00f7 {math.exp(log):.2g}"


def _joints(bench: Bench) -> str:
    """Say joint or joints."""
    return "joints" if len(bench.joints) > 1 else "joint"


def _count(number: int, noun: str) -> str:
    """Count things in words."""
    return f"{number} {noun}{'s' * (number != 1)}"
