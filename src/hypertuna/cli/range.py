"""The command `hypertuna range`."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from hypertuna.actuation.battery import Range, range_of
from hypertuna.cli.old_console import number, number_list, print_json
from hypertuna.cli.old_options import BACKWARD, check_beats, heads_first
from hypertuna.cli.optimize import gait_record
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.paper.chapters.gaits import range_finding
from hypertuna.paper.ledger import judge, published
from hypertuna.simulation.twin import twin
from hypertuna.swimming.gait import Gait, named_gait

__all__ = ["range_command"]

PAPER = "hypertuna"  # the robot whose range is published


def range_command(
    robot: Annotated[
        str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
    ],
    gait: Annotated[str | None, typer.Option("--gait", help="A gait of the robot's file, swum by the twin.")] = None,
    frequency: Annotated[str | None, typer.Option("--frequency", help="Beat frequency in Hz, for the twin.")] = None,
    amplitude: Annotated[
        str | None, typer.Option("--amplitude", help="Amplitude in degrees, one per joint group, for the twin.")
    ] = None,
    phase: Annotated[
        str | None, typer.Option("--phase", help="Lag in degrees, one per joint group, for the twin. (default: 0)")
    ] = None,
    power: Annotated[
        str | None, typer.Option("--power", help="Mean power of the servos in W, instead of a gait.")
    ] = None,
    speed: Annotated[str | None, typer.Option("--speed", help="Speed in m/s, with --power.")] = None,
    reserve: Annotated[str, typer.Option("--reserve", help="Part of the charge that is kept.")] = "0",
    duration: Annotated[str, typer.Option("--duration", help="Seconds that the twin swims.")] = "20",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Tell how far and how long the battery carries: at the twin's power and speed in a gait, or at given ones.

    The exit code is 0 for a range, 1 if the twin does not come to swim steadily, 2 for bad input.
    """
    fish = load(robot)
    kept = number(reserve, "reserve", "parts of one")
    _check_choice(gait, frequency, amplitude, phase, power, speed)
    told: dict[str, Any] = {}
    if power is not None or speed is not None:
        watts, going = _given(power, speed)
    else:
        watts, going, told = _swum(fish, _gait(fish, gait, frequency, amplitude, phase), duration)
    if not math.isfinite(watts + going):
        if as_json:
            print_json(provenance(fish) | told | {"power_w": watts, "range_km": None, "endurance_h": None})
        else:
            Console().print(Text(told["status_text"], style="bold red"))
        raise typer.Exit(1)
    found = range_of(fish, power=watts, speed=going, reserve=kept)
    if as_json:
        print_json(_record(fish, found, told))
    else:
        _print(fish, found, told)
    if not told.get("settled", True):
        raise typer.Exit(1)


def _check_choice(
    gait: str | None,
    frequency: str | None,
    amplitude: str | None,
    phase: str | None,
    power: str | None,
    speed: str | None,
) -> None:
    """Check that there is one way to power and speed."""
    beat = any(value is not None for value in (frequency, amplitude, phase))
    given = power is not None or speed is not None
    if gait is not None and (beat or given):
        fix = "give the gait alone"
        raise InputError("cannot go with --frequency, --amplitude, --phase, --power or --speed", key="--gait", fix=fix)
    if beat and given:
        fix = "give either a beat for the twin, or power and speed"
        raise InputError("cannot go with --frequency, --amplitude or --phase", key="--power", fix=fix)
    if not (gait is not None or beat or given):
        fix = "give --gait NAME, or --frequency and --amplitude, or --power and --speed"
        raise InputError("needs a gait, or power and speed", key="range", fix=fix)


def _given(power: str | None, speed: str | None) -> tuple[float, float]:
    """Read power and speed."""
    for key, other, value in (("--power", "--speed", power), ("--speed", "--power", speed)):
        if value is None:
            raise InputError(f"is needed beside {other}", key=key, fix="give both, or a gait")
    going = number(speed or "", "speed", "m/s")
    if going <= 0:
        raise InputError("must be greater than 0", key="--speed", value=f"{going:g}", fix="give the speed ahead in m/s")
    return number(power or "", "power", "W"), going


def _gait(fish: Robot, gait: str | None, frequency: str | None, amplitude: str | None, phase: str | None) -> Gait:
    """Read the gait."""
    if gait is not None:
        return named_gait(fish, gait)
    for key, value in (("--frequency", frequency), ("--amplitude", amplitude)):
        if value is None:
            raise InputError("is needed for a beat", key=key, fix="give --frequency and --amplitude, or --gait NAME")
    angles = number_list(amplitude or "", "amplitude", "degrees")
    lags = (0.0,) * len(angles) if phase is None else number_list(phase, "phase", "degrees")
    return Gait.from_degrees(frequency=number(frequency or "", "frequency", "Hz"), amplitude=angles, phase=lags)


def _swum(fish: Robot, gait: Gait, duration: str) -> tuple[float, float, dict[str, Any]]:
    """Let the twin swim a gait: power, speed, and what it says."""
    seconds = number(duration, "--duration", "seconds")
    check_beats(gait, seconds)
    run = twin(fish, gait, duration=seconds, start="swimming")
    ahead = heads_first(run)
    told = {
        "gait": gait_record(gait),
        "duration_s": run.duration,
        "settled": run.settled,
        "limits": list(run.limits),
        "status_text": " ".join([*run.sentences, *([] if ahead else [BACKWARD])]),
    }
    return run.power, run.speed if ahead else math.nan, told


def _record(fish: Robot, found: Range, told: dict[str, Any]) -> dict[str, Any]:
    """Tell a range, for programs."""
    battery = fish.battery
    assert battery is not None  # or there were no range
    series = battery.series or battery.cells
    record: dict[str, Any] = provenance(fish) | told
    record |= {
        "power_w": found.power,
        "speed_m_s": found.speed,
        "cost_of_transport_j_per_kg_m": found.cost_of_transport,
        "mass_kg": fish.body.mass,
        "battery": {
            "cells": battery.cells,
            "series": series,
            "parallel": battery.cells // series,
            "capacity_ah": battery.capacity / 3600,
            "cell_v": battery.voltage,
            "energy_wh": found.energy / 3600,
            "usable": battery.usable,
            "converter_efficiency": battery.efficiency,
            "voltage_start_v": found.voltage[0],
            "voltage_end_v": found.voltage[1],
        },
        "reserve": found.reserve,
        "energy_at_servos_wh": found.given / 3600,
        "servo_supply_min_v": found.supply,
        "range_km": found.range / 1e3,
        "endurance_h": found.endurance / 3600,
        "nominal_range_km": found.nominal_range / 1e3,
        "nominal_endurance_h": found.nominal_endurance / 3600,
    }
    if fish.name == PAPER:
        paper = published()
        entry = judge(paper, range_finding(fish, paper))
        record["published"] = {"range_km": entry.published, "verdict": entry.verdict, "computed_km": entry.computed}
        record["published"]["arithmetic"] = entry.note
    return record


def _print(fish: Robot, found: Range, told: dict[str, Any]) -> None:
    """Print a range with its arithmetic."""
    record = _record(fish, found, told)
    battery, console = record["battery"], Console()
    console.print(Text(f"{fish.name}: range on one charge", style="bold"))
    cells = f"{battery['cells']} cells x {battery['capacity_ah']:g} Ah x {battery['cell_v']:g} V"
    of_charge = f"{100 * battery['usable']:.3g} % of the charge, {100 * found.reserve:.3g} % of that in reserve"
    volts = f"{found.voltage[0]:.4g} to {found.voltage[1]:.4g} V under load"
    converter = f"converter {100 * battery['converter_efficiency']:.3g} %"
    joined = f"{battery['series']} in series, {battery['parallel']} parallel"
    lines = (
        ("power of the servos", f"{found.power:.4g} W"),
        ("speed", f"{found.speed:.4g} m/s"),
        ("cost of transport", f"{found.cost_of_transport:.4g} J/(kg m), over {fish.body.mass:g} kg"),
        ("battery", f"{cells} = {battery['energy_wh']:.4g} Wh; {joined}"),
        ("all of it at the servos", f"{found.nominal_range / 1e3:.4g} km, {found.nominal_endurance / 3600:.4g} h"),
        ("what reaches the servos", f"{found.given / 3600:.4g} Wh: {of_charge}, {volts}, {converter}"),
        ("range", f"{found.range / 1e3:.4g} km"),
        ("endurance", f"{found.endurance / 3600:.4g} h"),
    )
    for name, text in lines:
        console.print(Text(f"{name:26}{text}"))
    if told:
        console.print(
            Text(f"power and speed are the twin's. {told['status_text']}", style="" if told["settled"] else "red")
        )
    if "published" in record:
        told_there = record["published"]
        console.print(
            Text(f"published: {told_there['range_km']:g} km is {told_there['verdict']}. {told_there['arithmetic']}.")
        )
