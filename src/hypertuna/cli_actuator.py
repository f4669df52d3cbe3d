"""The commands `hypertuna actuator ...`: what tests at the bench tell of an actuator."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from hypertuna.actuation.silicone import UP_TO, TensileFit, TensileTest, fit_silicone, read_tensile
from hypertuna.cli_bench import fit_command
from hypertuna.console import number, print_json
from hypertuna.io.files import version

__all__ = ["actuator_app"]

actuator_app = typer.Typer(no_args_is_help=True, help="What tests at the bench tell of an actuator.")
actuator_app.command("fit")(fit_command)


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
