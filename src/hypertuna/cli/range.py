"""The command `hypertuna range`."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any

from hypertuna.actuation.battery import CruisingRange, range_of
from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit
from hypertuna.cli.gait import GaitOptions, check_duration
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.quantity import columns, listed
from hypertuna.paper.chapters.gaits import range_finding
from hypertuna.paper.ledger import judge, published
from hypertuna.ranges import POSITIVE
from hypertuna.simulation.cards import BACKWARD, swims_forward
from hypertuna.simulation.twin import twin
from hypertuna.swimming.gait import Gait, gait_record

PAPER = "hypertuna"  # the robot whose range is published


@dataclass(frozen=True)
class Cruise:
    """A robot's cruising range, with the run of the twin that gave its power and speed, if there is one."""

    robot: Robot
    power: float  # W, electrical
    range: CruisingRange | None  # None if the robot does not swim forward
    run: dict[str, Any]  # JSON of the twin's run; empty if power and speed are given


@opt.grouped
def range_command(
    robot: opt.RobotOptions,
    gait: GaitOptions,
    power: Annotated[
        float | None, opt.number("--power", "W", "Mean electrical power of the servos in W; replaces the gait options.")
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
    fish = robot.load()
    _check_source(gait, power, speed)
    facts: dict[str, Any] = {}
    if power is None or speed is None:
        lags = [[(0.0,) * len(fish.joints)]] if gait.gait is None and gait.phase is None else gait.phase
        power, speed, facts = _twin(fish, replace(gait, phase=lags).make(fish), duration)
    else:
        POSITIVE.check(speed, "--speed", "give the speed ahead in m/s")
    swims = math.isfinite(power + speed)
    emit(
        Cruise(fish, power, range_of(fish, power=power, speed=speed, reserve=reserve) if swims else None, facts),
        record=_record,
        lines=_lines,
        as_json=as_json,
        failed=not (swims and facts.get("settled", True)),
    )


def _check_source(gait: GaitOptions, power: float | None, speed: float | None) -> None:
    """Check that power and speed come either from a gait or from --power and --speed."""
    numbers = {"--power": power, "--speed": speed}
    missing = [key for key, value in numbers.items() if value is None]
    gait_given = gait.gait is not None or bool(gait.given)
    if gait_given and len(missing) < 2:
        fix = "give either a gait for the twin, or power and speed"
        raise InputError(
            "cannot be combined with a gait", key=listed([key for key in numbers if key not in missing]), fix=fix
        )
    if not gait_given and len(missing) == 2:
        fix = "give --gait NAME, or --frequency and --amplitude, or --power and --speed"
        raise InputError("needs a gait, or power and speed", key="range", fix=fix)
    if len(missing) == 1:
        (other,) = numbers.keys() - {*missing}
        raise InputError(f"is needed beside {other}", key=missing[0], fix="give both, or a gait")


def _twin(robot: Robot, gait: Gait, duration: float) -> tuple[float, float, dict[str, Any]]:
    """Return power [W] and speed [m/s] of the twin, NaN if it does not swim forward, and the record of its run."""
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
    return run.electrical_power, run.speed if forward else math.nan, facts


def _record(cruise: Cruise) -> dict[str, Any]:
    """Return the JSON record of a cruising range."""
    fish, result = cruise.robot, cruise.range
    record: dict[str, Any] = provenance(fish) | cruise.run
    if result is None:
        return record | {"electrical_power_w": cruise.power, "range_km": None, "endurance_h": None}
    numbers = columns(result)
    first = {key: numbers.pop(key) for key in ("electrical_power_w", "speed_m_s", "cost_of_transport_j_per_kg_m")}
    record |= first | {"mass_kg": fish.body.mass, "battery": _battery(fish, result)} | numbers
    if fish.name == PAPER:
        entry = judge(published(), range_finding(fish))
        facts = {"range_km": entry.published, "verdict": entry.verdict, "computed_km": entry.computed}
        record["published"] = facts | {"arithmetic": entry.note}
    return record


def _battery(robot: Robot, result: CruisingRange) -> dict[str, Any]:
    """Return the JSON record of the battery: cells, charge, voltages [V] and efficiencies."""
    battery = robot.battery
    assert battery is not None  # without a battery there is no range
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


def _lines(cruise: Cruise) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a range: each step of its computation."""
    fish, result = cruise.robot, cruise.range
    if result is None:
        yield cruise.run["status_text"], "bold red"
        return
    record = _record(cruise)
    battery = record["battery"]
    cells = f"{battery['cells']} cells x {battery['capacity_ah']:g} Ah x {battery['cell_v']:g} V"
    groups = f"{battery['series']} in series, {battery['parallel']} parallel"
    charge = f"{100 * battery['usable']:.3g} % of the charge, {100 * result.reserve:.3g} % of that in reserve"
    volts = f"{result.voltage[0]:.4g} to {result.voltage[1]:.4g} V under load"
    converter = f"converter {100 * battery['converter_efficiency']:.3g} %"
    rows = {
        "electrical power": f"{result.electrical_power:.4g} W",
        "speed": f"{result.speed:.4g} m/s",
        "cost of transport": f"{result.cost_of_transport:.4g} J/(kg m), over {fish.body.mass:g} kg",
        "battery": f"{cells} = {battery['energy_wh']:.4g} Wh; {groups}",
        "nominal range, endurance": f"{result.nominal_range / 1e3:.4g} km, {result.nominal_endurance / 3600:.4g} h",
        "energy at servos": f"{result.energy_at_servos / 3600:.4g} Wh: {charge}, {volts}, {converter}",
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
