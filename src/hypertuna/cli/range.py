"""The command `hypertuna range`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import typer

from hypertuna.actuation.battery import Range, range_of
from hypertuna.cli import options as opt
from hypertuna.cli.console import print_json, print_lines
from hypertuna.cli.emit import emit
from hypertuna.cli.gait import check_duration, gait_record
from hypertuna.cli.twin import BACKWARD, swims_forward
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.paper.chapters.gaits import range_finding
from hypertuna.paper.ledger import judge, published
from hypertuna.simulation.twin import twin
from hypertuna.swimming.gait import Gait, named_gait

PAPER = "hypertuna"  # the robot whose range is published


@dataclass(frozen=True)
class Cruise:
    """Power and speed of a robot, and the twin's run that they are from."""

    robot: Robot
    power: float  # W, electrical
    speed: float  # m/s; NaN if the robot does not swim forward
    run: dict[str, Any] = field(default_factory=dict)  # JSON of the twin's run; empty if power and speed are given


def range_command(
    robot: opt.RobotName,
    gait: opt.GaitName = None,
    frequency: opt.Frequency = None,
    amplitude: opt.Amplitude = None,
    phase: opt.Phase = None,
    power: Annotated[
        float | None, opt.number("--power", "W", "Mean power of the servos in W, instead of a gait.")
    ] = None,
    speed: Annotated[float | None, opt.number("--speed", "m/s", "Speed in m/s, with --power.")] = None,
    reserve: Annotated[
        float, opt.number("--reserve", "parts of one", "Fraction of the charge kept in reserve, 0 to 1.")
    ] = 0,
    duration: opt.Duration = 20,
    as_json: opt.AsJson = False,
) -> None:
    """Compute range and endurance on one battery charge: at the twin's power and speed in a gait, or at given ones.

    The exit code is 0 for a range, 1 if the twin does not reach steady swimming, 2 for bad input.
    """
    fish = load(robot)
    beat = {"--frequency": frequency, "--amplitude": amplitude, "--phase": phase}
    _check_choice(gait, beat, power, speed)
    if power is not None or speed is not None:
        cruise = _given(fish, power, speed)
    else:
        cruise = _swum(fish, _gait(fish, gait, frequency, amplitude, phase), duration)
    if not math.isfinite(cruise.power + cruise.speed):
        if as_json:
            none = {"power_w": cruise.power, "range_km": None, "endurance_h": None}
            print_json(provenance(fish) | cruise.run | none)
        else:
            print_lines([(cruise.run["status_text"], "bold red")])
        raise typer.Exit(1)
    result = range_of(fish, power=cruise.power, speed=cruise.speed, reserve=reserve)
    emit(
        result,
        record=lambda result: _record(cruise, result),
        lines=lambda result: _lines(cruise, result),
        as_json=as_json,
        failed=not cruise.run.get("settled", True),
    )


def _check_choice(gait: str | None, beat: dict[str, Any], power: float | None, speed: float | None) -> None:
    """Check that power and speed come from one source."""
    swum = any(value is not None for value in beat.values())
    given = power is not None or speed is not None
    if gait is not None and (swum or given):
        fix = "give the gait alone"
        raise InputError(
            "cannot be combined with --frequency, --amplitude, --phase, --power or --speed", key="--gait", fix=fix
        )
    if swum and given:
        fix = "give either a beat for the twin, or power and speed"
        raise InputError("cannot be combined with --frequency, --amplitude or --phase", key="--power", fix=fix)
    if not (gait is not None or swum or given):
        fix = "give --gait NAME, or --frequency and --amplitude, or --power and --speed"
        raise InputError("needs a gait, or power and speed", key="range", fix=fix)


def _given(robot: Robot, power: float | None, speed: float | None) -> Cruise:
    """Take power and speed as given."""
    if power is None or speed is None:
        key, other = ("--power", "--speed") if power is None else ("--speed", "--power")
        raise InputError(f"is needed beside {other}", key=key, fix="give both, or a gait")
    if speed <= 0:
        raise InputError("must be greater than 0", key="--speed", value=f"{speed:g}", fix="give the speed ahead in m/s")
    return Cruise(robot, power, speed)


def _gait(
    robot: Robot,
    name: str | None,
    frequency: float | None,
    amplitude: Sequence[float] | None,
    phase: Sequence[float] | None,
) -> Gait:
    """Make the gait of the options [Hz, deg]."""
    if name is not None:
        return named_gait(robot, name)
    fix = "give --frequency and --amplitude, or --gait NAME"
    if frequency is None:
        raise InputError("is needed for a beat", key="--frequency", fix=fix)
    if amplitude is None:
        raise InputError("is needed for a beat", key="--amplitude", fix=fix)
    return Gait.from_degrees(frequency=frequency, amplitude=amplitude, phase=phase or (0.0,) * len(amplitude))


def _swum(robot: Robot, gait: Gait, duration: float) -> Cruise:
    """Take power and speed from the twin."""
    check_duration(gait, duration)
    run = twin(robot, gait, duration=duration, start="swimming")
    forward = swims_forward(run)
    facts = {
        "gait": gait_record(gait),
        "duration_s": run.duration,
        "settled": run.settled,
        "limits": list(run.limits),
        "status_text": " ".join([*run.sentences, *([] if forward else [BACKWARD])]),
    }
    return Cruise(robot, run.power, run.speed if forward else math.nan, facts)


def _record(cruise: Cruise, result: Range) -> dict[str, Any]:
    """Return the JSON record."""
    fish = cruise.robot
    record: dict[str, Any] = provenance(fish) | cruise.run
    record |= {
        "power_w": result.power,
        "speed_m_s": result.speed,
        "cost_of_transport_j_per_kg_m": result.cost_of_transport,
        "mass_kg": fish.body.mass,
        "battery": _battery(fish, result),
        "reserve": result.reserve,
        "energy_at_servos_wh": result.delivered / 3600,
        "servo_supply_min_v": result.supply,
        "range_km": result.range / 1e3,
        "endurance_h": result.endurance / 3600,
        "nominal_range_km": result.nominal_range / 1e3,
        "nominal_endurance_h": result.nominal_endurance / 3600,
    }
    if fish.name == PAPER:
        paper = published()
        entry = judge(paper, range_finding(fish))
        facts = {"range_km": entry.published, "verdict": entry.verdict, "computed_km": entry.computed}
        record["published"] = facts | {"arithmetic": entry.note}
    return record


def _battery(robot: Robot, result: Range) -> dict[str, Any]:
    """Return the battery's part of the record."""
    battery = robot.battery
    assert battery is not None  # or there were no range
    series = battery.series or battery.cells
    return {
        "cells": battery.cells,
        "series": series,
        "parallel": battery.cells // series,
        "capacity_ah": battery.capacity / 3600,
        "cell_v": battery.voltage,
        "energy_wh": result.energy / 3600,
        "usable": battery.usable,
        "converter_efficiency": battery.efficiency,
        "voltage_start_v": result.voltage[0],
        "voltage_end_v": result.voltage[1],
    }


def _lines(cruise: Cruise, result: Range) -> Iterator[Any]:
    """Lay out a range with its arithmetic."""
    fish, record = cruise.robot, _record(cruise, result)
    battery = record["battery"]
    cells = f"{battery['cells']} cells x {battery['capacity_ah']:g} Ah x {battery['cell_v']:g} V"
    groups = f"{battery['series']} in series, {battery['parallel']} parallel"
    charge = f"{100 * battery['usable']:.3g} % of the charge, {100 * result.reserve:.3g} % of that in reserve"
    volts = f"{result.voltage[0]:.4g} to {result.voltage[1]:.4g} V under load"
    converter = f"converter {100 * battery['converter_efficiency']:.3g} %"
    rows = {
        "power of the servos": f"{result.power:.4g} W",
        "speed": f"{result.speed:.4g} m/s",
        "cost of transport": f"{result.cost_of_transport:.4g} J/(kg m), over {fish.body.mass:g} kg",
        "battery": f"{cells} = {battery['energy_wh']:.4g} Wh; {groups}",
        "without losses": f"{result.nominal_range / 1e3:.4g} km, {result.nominal_endurance / 3600:.4g} h",
        "energy at the servos": f"{result.delivered / 3600:.4g} Wh: {charge}, {volts}, {converter}",
        "range": f"{result.range / 1e3:.4g} km",
        "endurance": f"{result.endurance / 3600:.4g} h",
    }
    yield f"{fish.name}: range on one charge", "bold"
    for name, text in rows.items():
        yield f"{name:26}{text}"
    if cruise.run:
        yield f"Power and speed are the twin's. {cruise.run['status_text']}", "" if cruise.run["settled"] else "red"
    if "published" in record:
        yield "published: {range_km:g} km is {verdict}. {arithmetic}.".format(**record["published"])
