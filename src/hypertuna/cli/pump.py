"""The command `hypertuna pump`."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.actuation.hydraulics import ZERO_CELSIUS, circuits
from hypertuna.actuation.sizing import Size, largest_beat, size_pump
from hypertuna.cli.old_console import (
    check_suffix,
    command_line,
    number_list,
    print_json,
    progress_bar,
    ranges,
    tell_written,
)
from hypertuna.cli.old_options import BORES
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.io.files import dataset, rows_csv, write_atomically, write_netcdf
from hypertuna.swimming.gait import named_gait

__all__ = ["COLUMNS", "pump_command"]

RANGE = "a value or a range start:stop:count"

# What is told of a size: name with its unit, attribute, factor from SI.
COLUMNS = (
    ("frequency_hz", "frequency", 1.0),
    ("bore_mm", "bore", 1e3),
    ("viscosity_mm2_s", "viscosity", 1e6),
    ("command_deg", "command", 180 / math.pi),
    ("torque_n_m", "torque", 1.0),
    ("torque_limit_n_m", "torque_limit", 1.0),
    ("servo_speed_rad_s", "speed", 1.0),
    ("servo_speed_limit_rad_s", "speed_limit", 1.0),
    ("stroke_deg", "stroke", 180 / math.pi),
    ("stroke_limit_deg", "stroke_limit", 180 / math.pi),
    ("line_resistance_pa_s_m3", "resistance", 1.0),
    ("line_inertance_pa_s2_m3", "inertance", 1.0),
    ("capacity_rest_m3_pa", "capacity_rest", 1.0),
    ("capacity_m3_pa", "capacity", 1.0),
    ("corner_rest_hz", "corner_rest", 1.0),
    ("corner_hz", "corner", 1.0),
    ("resonance_hz", "resonance", 1.0),
    ("damping_ratio", "damping", 1.0),
    ("ring_hz", "ring", 1.0),
    ("ring_damping_ratio", "ring_damping", 1.0),
    ("pressure_drop_kpa", "drop", 1e-3),
    ("reynolds", "reynolds", 1.0),
    ("amplitude_deg", "amplitude", 180 / math.pi),
    ("lag_deg", "lag", 180 / math.pi),
    ("command_part", "part", 1.0),
    ("pressure_max_kpa", "pressure_max", 1e-3),
    ("pressure_min_kpa", "pressure_min", 1e-3),
)
LIMITS = {"pressure": "the pressure limit", "suction": "suction", "servo": "a servo that is too slow"}
LETTERS = {"pressure": "p", "suction": "s", "servo": "v"}
TURBULENT = "turbulent: the drop is told too small"  # of a line beyond the laminar law
MARGINS = {"torque": "torque_limit", "servo_speed": "speed_limit", "stroke": "stroke_limit"}


def pump_command(
    robot: Annotated[
        str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
    ],
    gait: Annotated[
        str | None, typer.Option("--gait", help="A gait of the robot's file: its frequency and amplitude.")
    ] = None,
    frequency: Annotated[
        str | None, typer.Option("--frequency", help=f"Beat frequency in Hz, {RANGE}. (default: the highest)")
    ] = None,
    amplitude: Annotated[
        str | None,
        typer.Option("--amplitude", help="Commanded amplitude in degrees, one per joint group. (default: the largest)"),
    ] = None,
    bore: Annotated[
        str | None, typer.Option("--bore", help=f"Bore of all lines in mm, {RANGE}. (default: the robot's)")
    ] = None,
    temperature: Annotated[
        str | None,
        typer.Option("--temperature", help=f"Temperature of the oil in C, {RANGE}. (default: the robot's)"),
    ] = None,
    plot: Annotated[str | None, typer.Option("--plot", help="Draw to this .svg, .png or .pdf file.")] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write to this .nc or .csv file.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Size the pump: torque, speed and stroke of its servos, drop and bandwidth of the lines, bend that is left.

    Each joint beats alone, in air and without mass: what hydraulics alone can do. Exit code 2 means bad input.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    kind = check_suffix(output, (".nc", ".csv"), "--output")
    fish = load(robot)
    circuits(fish)  # says what the file lacks
    frequencies, amplitudes = _beat(fish, gait, frequency, amplitude)
    bores = [None] if bore is None else _bores(bore)
    celsius = [None] if temperature is None else _axis(temperature, "temperature", "C")
    with progress_bar("sizing") as progress:
        sizes = size_pump(
            fish,
            frequency=frequencies,
            amplitude=amplitudes,
            bore=bores,
            temperature=[None if value is None else value + ZERO_CELSIUS for value in celsius],
            progress=progress,
        )
    if plot is not None:
        from hypertuna.actuation.plots import plot_pump
        from hypertuna.figures import save

        save(plot_pump(sizes), plot)
    if output is not None and kind == ".nc":
        facts = provenance(fish) | {"command": command_line()}
        write_netcdf(dataset(_variables(sizes), {}, facts), output)
    if output is not None and kind == ".csv":
        write_atomically(output, _csv(fish, sizes).encode())
    if as_json:
        print_json(provenance(fish) | {"sizes": [_record(size) for size in sizes]})
    else:
        _print(fish, sizes)
        tell_written(plot, output)


def _beat(
    fish: Robot, gait: str | None, frequency: str | None, amplitude: str | None
) -> tuple[list[float], tuple[float, ...]]:
    """Read the beat: a named gait or the largest one, or what is given."""
    if gait is not None and (frequency is not None or amplitude is not None):
        fix = "give the gait alone, or frequency and amplitude"
        raise InputError("has a frequency and amplitudes of its own", key="--gait", fix=fix)
    if gait is not None:
        named = named_gait(fish, gait)
        return [named.frequency], tuple(named.amplitude)
    fastest, largest = largest_beat(fish) if frequency is None or amplitude is None else (0.0, ())
    frequencies = [fastest] if frequency is None else _axis(frequency, "frequency", "Hz")
    if amplitude is not None:
        largest = tuple(math.radians(angle) for angle in number_list(amplitude, "amplitude", "degrees"))
    return frequencies, largest


def _axis(text: str, key: str, unit: str) -> list[float]:
    """Read one axis of the table."""
    values = ranges(text, key, unit)
    if len(values[0]) > 1:
        rule, fix = f"must be {RANGE}", "write, for example, 2:5:4 for 2, 3, 4 and 5"
        raise InputError(rule, key=key, value=repr(text), fix=fix)
    return [value for (value,) in values]


def _bores(text: str) -> list[float | None]:
    """Read bores of the lines [m]: those that the twin takes, too."""
    values, (low, high) = _axis(text, "bore", "mm"), BORES
    for value in values:
        if not low <= value <= high:
            fix = "give the inner diameter of the oil lines in mm"
            raise InputError(f"must be from {low:g} to {high:g} mm", key="bore", value=f"{value:g}", fix=fix)
    return [value * 1e-3 for value in values]


def _limits(size: Size) -> tuple[str, ...]:
    """Name what costs bend: at the pressure limit a quicker servo would only be told less."""
    return tuple(name for name in size.limits if name != "servo" or "pressure" not in size.limits)


def _record(size: Size) -> dict[str, Any]:
    """Tell a size, for programs."""
    record: dict[str, Any] = {"joint": size.joint, "temperature_c": size.temperature - ZERO_CELSIUS}
    record |= {name: getattr(size, attribute) * factor for name, attribute, factor in COLUMNS}
    for name, limit in MARGINS.items():
        attribute = "speed" if name == "servo_speed" else name
        record[f"{name}_margin"] = getattr(size, limit) / getattr(size, attribute) - 1
    record |= {"turbulent": size.turbulent, "limits": list(size.limits)}
    return record | {f"power_{name}_w": watts for name, watts in size.power.items()}


def _flat(size: Size) -> dict[str, Any]:
    """Tell a size on one line."""
    return _record(size) | {"turbulent": int(size.turbulent), "limits": " ".join(size.limits)}


def _variables(sizes: list[Size]) -> dict[str, Any]:
    """Return one variable for each column, along the cases."""
    rows = [_flat(size) for size in sizes]
    return {name: ("case", np.array([row[name] for row in rows])) for name in rows[0]}


def _csv(fish: Robot, sizes: list[Size]) -> str:
    """Write sizes as comma-separated values, below comments that say what made them."""
    return rows_csv(provenance(fish) | {"command": command_line()}, (_flat(size) for size in sizes))


def _print(fish: Robot, sizes: list[Size]) -> None:
    """Print what each joint asks of its servos; below it one case in words, or a table over bore and temperature."""
    console = Console()
    console.print(Text(f"{fish.name}: the pump's servos, the lines, and what is left of the bend in air", style="bold"))
    beats: dict[tuple[str, float], list[Size]] = {}
    for size in sizes:
        beats.setdefault((size.joint, size.frequency), []).append(size)
    for cases in beats.values():
        _print_servo(console, cases[0])
        if len(cases) == 1:
            _print_case(console, cases[0])
        else:
            _print_table(console, cases)
    if len(sizes) > len(beats):
        legend = "; ".join(f"{letter} {LIMITS[name]}" for name, letter in LETTERS.items())
        if any(size.turbulent for size in sizes):
            legend += f"; t {TURBULENT}"
        console.print(Text(f"bend that is left [deg] (corner of the line [Hz]); {legend}"))


def _print_servo(console: Console, size: Size) -> None:
    """Print what a beat asks of a servo, beside what it can do."""
    record = _record(size)
    told = f"joint {size.joint} at {size.frequency:.3g} Hz, {record['command_deg']:.3g} deg told"
    left = size.speed_limit * max(0.0, 1 - size.torque / size.torque_limit)
    console.print(Text(f"{told}; a servo needs, and has", style="bold"))
    console.print(f"  torque at the pressure limit  {size.torque:8.3g} of {size.torque_limit:.3g} N m")
    console.print(
        f"  speed                         {size.speed:8.3g} of {size.speed_limit:.3g} rad/s, {left:.3g} at that torque"
    )
    console.print(
        f"  stroke                        {record['stroke_deg']:8.3g} of {record['stroke_limit_deg']:.3g} deg"
    )


def _print_case(console: Console, size: Size) -> None:
    """Print all of one case."""
    record = _record(size)
    shares = ", ".join(f"{name} {watts:.2g}" for name, watts in size.power.items() if name != "total")
    limits = " and ".join(LIMITS[name] for name in _limits(size)) or "nothing"
    turbulent = f", {TURBULENT}" if size.turbulent else ""
    lines = (
        ("oil", f"{record['temperature_c']:.3g} C, {record['viscosity_mm2_s']:.4g} mm^2/s"),
        ("line", f"{record['bore_mm']:.3g} mm, Reynolds number {size.reynolds:.3g}{turbulent}"),
        ("pressure drop along the line", f"{record['pressure_drop_kpa']:.3g} kPa for the whole bend"),
        ("corner frequency of the line", f"{size.corner:.3g} Hz, for small motions {size.corner_rest:.3g} Hz"),
        ("resonance with the muscles", f"{size.resonance:.3g} Hz, damping ratio {size.damping:.2g}"),
        ("resonance with the cylinder", f"{size.ring:.3g} Hz, damping ratio {size.ring_damping:.2g}"),
        ("bend that is left", f"{record['amplitude_deg']:.3g} deg, {record['lag_deg']:.3g} deg late"),
        ("told to the servos", f"{100 * size.part:.3g} % of the whole"),
        ("pressure of the cylinders", f"{record['pressure_min_kpa']:.0f} to {record['pressure_max_kpa']:.0f} kPa"),
        ("limited by", limits),
        ("power of its two servos", f"{size.power['total']:.3g} W: {shares}"),
    )
    for name, text in lines:
        console.print(Text(f"  {name:30}{text}"))


def _print_table(console: Console, cases: list[Size]) -> None:
    """Print the bend that is left over bore and temperature."""
    temperatures = list(dict.fromkeys(size.temperature for size in cases))
    bores = list(dict.fromkeys(size.bore for size in cases))
    known = {(size.bore, size.temperature): size for size in cases}
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column(Text("  bore [mm]", justify="left"), justify="right")
    for temperature in temperatures:
        viscosity = known[bores[0], temperature].viscosity * 1e6
        head = f"{temperature - ZERO_CELSIUS:.3g} C\n{viscosity:.3g} mm^2/s"
        table.add_column(Text(head, justify="right"), justify="right", no_wrap=True)
    for bore in bores:
        row = (known[bore, temperature] for temperature in temperatures)
        table.add_row(f"{bore * 1e3:.3g}", *(_cell(size) for size in row))
    console.print(table)


def _cell(size: Size) -> str:
    """Tell a case in a few letters."""
    letters = "".join(LETTERS[name] for name in _limits(size)) + "t" * size.turbulent
    return f"{math.degrees(size.amplitude):.1f}{letters} ({size.corner:.2g})"
