"""The commands `hypertuna joint fit` and `hypertuna joint silicone`: characterize an actuator by tests on the bench."""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import typer

from hypertuna.actuation.silicone import UP_TO, TensileFit, TensileTest, fit_silicone, read_tensile
from hypertuna.characterization.cards import MEASUREMENTS, NARROWED, half_text
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.experiment_design import InformationGain, information_gain
from hypertuna.characterization.fit import BenchFit, fit_bench
from hypertuna.characterization.unknowns import BORDER, KINDS
from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.description.writer import write_robot
from hypertuna.display import Part, card_of
from hypertuna.io.files import version


def silicone_command(
    file: Annotated[
        str,
        typer.Argument(
            help="CSV file of a tensile test: Engineering Strain (a fraction, or with (%) in its name), then "
            "Engineering Stress (MPa), (kPa) or (Pa)."
        ),
    ],
    up_to: Annotated[float, opt.number("--up-to", "percent", "Maximum strain to fit, in percent.")] = 100 * UP_TO,
    as_json: opt.AsJson = False,
) -> None:
    """Fit the elastic constants of a silicone to a tensile test: C1 and C2 of Mooney and Rivlin."""
    test = read_tensile(file)
    emit(
        fit_silicone(test, up_to=up_to / 100),
        record=lambda fit: _silicone_record(file, test, fit),
        lines=lambda fit: _silicone_lines(test, fit),
        as_json=as_json,
    )


def _silicone_record(file: str, test: TensileTest, fit: TensileFit) -> dict[str, Any]:
    """Return the JSON record of a fit to a tensile test."""
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
        "strain_asked": fit.requested,
        "points": fit.points,
        "left_out": test.omitted,
        "rms_pa": fit.rms,
        "status": fit.status,
    }


def _silicone_lines(test: TensileTest, fit: TensileFit) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a fit to a tensile test."""
    solid = fit.solid
    yield f"{test.name}: tensile_pa = [{solid.c1:.0f}, {solid.c2:.0f}]", "bold"
    yield f"Young's modulus at small strain: {solid.modulus / 1e3:.1f} kPa"
    if math.isfinite(fit.stress_100):
        fitted, measured = solid.modulus_100 / 1e3, fit.stress_100 / 1e3
        yield f"stress at 100 % strain: {measured:.1f} kPa measured, {fitted:.1f} kPa fitted"
    yield f"rms of the residuals: {fit.rms / 1e3:.2g} kPa"
    if test.omitted:
        yield f"{test.omitted} rows lack strain or stress and were omitted"
    yield fit.status, "green"


def _bound(text: str, key: str) -> parsing.Bound:
    """Return name, low and high [SI] from NAME=LOW:HIGH in the units of the command line."""
    kind = text.partition("=")[0].partition("[")[0].strip()
    unit, factor = BORDER[KINDS[kind].unit if kind in KINDS else "1"]
    name, low, high = parsing.bound(text, key, unit)
    return parsing.Bound(name, low / factor, high / factor)


Free = Annotated[str | None, opt.text("--free", "Unknowns to fit, such as lever,friction. (default: all)")]
Bounds = Annotated[
    list[Any] | None,
    opt.option(("--bounds",), "Prior bounds of an unknown in mm, deg or 1; repeatable.", "NAME=LOW:HIGH", _bound),
]


@opt.grouped
def fit_command(
    files: Annotated[
        list[str],
        typer.Argument(
            help="CSV files of bench runs: joint, side, pressure_kpa, angle_deg, and angle_sd_deg where rows are few "
            "(up to about the number of unknowns)."
        ),
    ],
    robot: opt.RobotOptions,
    free: Free = None,
    bounds: Bounds = None,
    loss: opt.Loss = "soft_l1",
    starts: opt.Starts = 3,
    seed: opt.Seed = 0,
    plot: opt.Plot = None,
    output: opt.RobotOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Identify the unknowns of an actuator from bench pressures and bends.

    The unknowns that remain undetermined are reported.

    Exit code 1 means that the search did not converge.
    """
    fish = robot.load(output)
    bench = read_bench(files, fish)
    prior = {name: (low, high) for name, low, high in bounds or []}
    with progress_bar("fitting") as progress:
        fit = fit_bench(fish, bench, free, bounds=prior, loss=loss, starts=starts, seed=seed, progress=progress)
    gains = information_gain(fit)
    if output is not None:
        write_robot(fit.robot, output, note="fitted, see [sources]")
    emit(
        fit,
        record=lambda fit: (
            fit.record | {"files": files, "measurements": [one.record for one in gains], "output": output}
        ),
        lines=lambda fit: _lines(fit, gains),
        plot=plot,
        written=(output,),
        as_json=as_json,
        failed=not fit.converged,
    )


def _lines(fit: BenchFit, gains: Sequence[InformationGain]) -> Iterator[Part]:
    """Yield the lines that the terminal prints for a fit; before its warnings, the measurements that would add most."""
    lines = card_of(fit).lines()
    warnings_start = len(lines) - 1 - len(fit.warnings)
    yield from lines[:warnings_start]
    if gains:
        yield "Additional measurements, the most informative first:", "bold"
    for gain in gains[:MEASUREMENTS]:
        parts = [f"{name} {half_text(gain.before[name])} to {half_text(after)}" for name, after in gain.after.items()]
        rest = len(parts) - NARROWED
        narrowed = ", ".join(parts[:NARROWED]) + f", {rest} more" * (rest > 0)
        expected = f"expected {gain.value:.3g} \u00b1 {gain.half_interval:.2g} {gain.unit}, known to {gain.sd:.2g}"
        yield f"{gain.bits:4.1f} bits  {gain.text} ({expected}): {narrowed or 'no unknown by a tenth'}"
    yield from lines[warnings_start:]
