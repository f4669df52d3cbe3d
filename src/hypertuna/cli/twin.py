"""The command `hypertuna twin`."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.actuation.hydraulics import ZERO_CELSIUS
from hypertuna.cli.old_console import check_suffix, command_line, number, print_json, tell_written, whole_number
from hypertuna.cli.old_options import (
    BACKWARD,
    MEDIA,
    Amplitude,
    Bias,
    Bore,
    Frequency,
    Medium,
    Name,
    Named,
    Phase,
    Seed,
    Temperature,
    celsius,
    check_beats,
    choice,
    gait_axes,
    heads_first,
    one_gait,
    robot_of,
    spelled,
)
from hypertuna.description.provenance import provenance
from hypertuna.io.files import columns_csv, write_atomically, write_netcdf
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twin

__all__ = ["twin_command"]

STARTS = ("rest", "swimming")
KILO = 1e3


def twin_command(
    robot: Name,
    gait: Named = None,
    frequency: Frequency = None,
    amplitude: Amplitude = None,
    phase: Phase = None,
    bias: Bias = None,
    duration: Annotated[str, typer.Option("--duration", help="Length of the run in s.")] = "20",
    fault: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            help="Fault of a sensor, CHANNEL:KIND@START or CHANNEL:KIND@START-END with times in s; may be given "
            "several times. Channels: bend, pressure and current, each alone or with -JOINT, the last two also with "
            "-JOINT-left or -JOINT-right; imu; battery. Kinds: stuck, open, spike, nan. Such as bend-II:stuck@5, "
            "imu:nan@5-8.",
        ),
    ] = None,
    open_loop: Annotated[bool, typer.Option("--open-loop", help="Leave out the posture control per beat.")] = False,
    medium: Medium = "water",
    temperature: Temperature = None,
    line_bore: Bore = None,
    seed: Seed = "0",
    start: Annotated[str, typer.Option("--start", help="rest, or swimming: at the gait's settled speed.")] = "rest",
    plot: Annotated[str | None, typer.Option("--plot", help="Draw the run to this .svg, .png or .pdf file.")] = None,
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Write the run to this .nc or .csv file.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Run the whole robot: controller, servos, pumps, oil, muscles, tail, water, and its sensors.

    The exit code is 0 for a run, 1 for one that diverged (what it did until then is still printed), 2 for bad input.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    kind = check_suffix(output, (".nc", ".csv"), "--output")
    fish = robot_of(robot, line_bore)
    wished = {"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias}
    beat, seconds = one_gait(gait_axes(fish, gait, wished)), number(duration, "--duration", "seconds")
    check_beats(beat, seconds)
    done = twin(
        fish,
        beat,
        duration=seconds,
        fish_in=choice(medium, MEDIA, "--medium"),
        faults=tuple(fault or ()),
        seed=whole_number(seed, "--seed"),
        closed_loop=not open_loop,
        temperature=celsius(temperature),
        start=choice(start, STARTS, "--start"),
    )
    if output is not None and kind == ".nc":
        write_netcdf(done.dataset().assign_attrs(_attributes(done)), output)
    if output is not None and kind == ".csv":
        write_atomically(output, _csv(done).encode())
    if plot is not None:
        _plot(done, plot)
    if as_json:
        print_json(_record(done))
    else:
        _print(done)
        tell_written(output, plot)
    if done.status == "diverged":
        raise typer.Exit(1)


def _joints(done: TwinRun) -> list[dict[str, Any]]:
    """Say what each joint group was told and did, over the last whole beats."""
    gait = done.gait
    return [
        {
            "name": group.name,
            "amplitude_set_deg": np.degrees(gait.amplitude[j]),
            "amplitude_deg": np.degrees(done.swing[j]),
            "first_harmonic_deg": np.degrees(done.amplitude[j]),
            "peak_error_deg": np.degrees(done.swing[j] - gait.amplitude[j]),
            "bias_set_deg": np.degrees(gait.bias[j]),
            "bias_deg": np.degrees(done.bias[j]),
            "phase_set_deg": np.degrees(gait.phase[j]),
            "phase_deg": np.degrees(done.phase[j]),
        }
        for j, group in enumerate(done.robot.joints)
    ]


def _circuits(done: TwinRun) -> list[dict[str, Any]]:
    """Say what each oil circuit did."""
    return [
        {"name": name, "pressure_max_kpa": done.pressure_max[c] / KILO, "pressure_min_kpa": done.pressure_min[c] / KILO}
        for c, name in enumerate(done.circuits)
    ]


def _sentences(done: TwinRun) -> list[str]:
    """Say what the run says, and whether the robot swam at all."""
    return [*done.sentences, *([] if heads_first(done) else [BACKWARD])]


def _record(done: TwinRun) -> dict[str, Any]:
    """Say how the robot ran, for programs."""
    gait = done.gait
    return (
        {
            "speed_m_s": done.speed,
            "speed_bl_s": done.speed_bl,
            "electrical_power_w": done.power,
            "mechanical_power_w": done.mechanical_power,
            "cost_of_transport_j_per_kg_m": done.cost_of_transport if heads_first(done) else math.nan,
            "joints": _joints(done),
            "circuits": _circuits(done),
            "limits": list(done.limits),
            "faults": list(done.faults),
            "status": done.status,
            "status_text": _sentences(done),
            "settled": done.settled,
        }
        | {"frequency_hz": gait.frequency}
        | {f"{key}_deg": np.degrees(getattr(gait, key)).round(10).tolist() for key in ("amplitude", "phase", "bias")}
        | {"duration_s": done.duration, "medium": done.fish_in, "start": done.start, "seed": done.seed}
        | {"closed_loop": done.closed_loop, "oil_temperature_c": done.temperature - ZERO_CELSIUS}
        | {key: value for key, value in provenance(done.robot).items() if key != "joints"}  # the twin moves its own
        | {"command": command_line()}
    )


def _attributes(done: TwinRun) -> dict[str, Any]:
    """Return what NetCDF can hold of the record beside the run."""
    flat = {key: value for key, value in _record(done).items() if key not in ("joints", "circuits")}
    texts = {key: "; ".join(flat.pop(key)) for key in ("limits", "faults", "status_text")}
    for row in (*_joints(done), *_circuits(done)):
        name = row.pop("name").replace("-", "_")
        flat |= {f"{name}_{key}": value for key, value in row.items()}
    flags = {key: int(flat.pop(key)) for key in ("settled", "closed_loop")}
    return flat | texts | flags


def _csv(done: TwinRun) -> str:
    """Write a run as comma-separated values, one row per control period, below comments that say what made it."""
    joints = [group.name for group in done.robot.joints]
    circuits = [name.replace("-", "_") for name in done.circuits]
    columns: dict[str, Any] = {"time_s": done.time}
    for key in ("angle_set", "angle", "angle_measured"):
        columns |= {f"{key}_{name}_deg": np.degrees(done.data[key][:, j]) for j, name in enumerate(joints)}
    for key in ("pump_pressure", "unit_pressure"):
        columns |= {f"{key}_{name}_kpa": done.data[key][:, c] / KILO for c, name in enumerate(circuits)}
    columns |= {
        f"servo_angle_{name}_deg": np.degrees(done.data["servo_angle"][:, c]) for c, name in enumerate(circuits)
    }
    columns |= {"electrical_power_w": done.data["power"]}
    columns |= {"x_m": done.data["x"], "y_m": done.data["y"], "heading_deg": np.degrees(done.data["heading"])}
    columns |= {"speed_m_s": done.data["speed"], "status": done.data["status"]}
    return columns_csv(_attributes(done), columns)


def _plot(done: TwinRun, plot: str) -> None:
    """Draw a run; what draws is imported only now, because that takes longer than the run."""
    from hypertuna.figures import save
    from hypertuna.simulation.plots import plot_twin

    save(plot_twin(done), plot)


def _print(done: TwinRun) -> None:
    """Print a run as three small tables and its sentences."""
    console = Console()
    console.print(Text(f"{done.robot.name}, {spelled(done.gait)}", style="bold"))
    loop = "closed loop" if done.closed_loop else "open loop"
    warm = done.temperature - ZERO_CELSIUS
    how = f"{done.duration:g} s in {done.fish_in} from {done.start}, {loop}, oil at {warm:.3g} C"
    console.print(Text(how, style="dim"))
    console.print(_totals(done))
    console.print()
    console.print(_joint_table(done))
    console.print()
    beats = f"last {done.beat_count} beats" if done.beat_count > 1 else "last beat"
    console.print(Text(f"cylinder pressure, peaks within ticks, {beats}", style="dim"))
    console.print(_circuit_table(done))
    console.print()
    good = done.settled and not done.limits and not done.faults
    for k, sentence in enumerate(_sentences(done)):
        bad = done.status == "diverged" or bool(done.faults)
        style = "green" if good or (k == 0 and done.settled) else "bold red" if bad else "yellow"
        console.print(Text(sentence, style=style))


def _totals(done: TwinRun) -> Table:
    """Tabulate speed and power."""
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(style="dim")
    table.add_column(justify="right", style="bold")
    table.add_column()
    if done.fish_in == "water":
        table.add_row("speed", f"{done.speed:.3g}", "m/s" if done.settled else "m/s, still changing")
        table.add_row("", f"{done.speed_bl:.3g}", "BL/s")
    table.add_row("electrical power", f"{done.power:.3g}", "W")
    if done.fish_in == "water":
        cells = (f"{done.cost_of_transport:.3g}", "J/(kg m)") if heads_first(done) else ("–", "")
        table.add_row("cost of transport", *cells)
    return table


def _joint_table(done: TwinRun) -> Table:
    """Tabulate what the joints were told and did."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("joint")
    bias = any(done.gait.bias)
    heads = ["amplitude\n[deg]", "set\n[deg]", "error\n[deg]", *(["bias\n[deg]", "set\n[deg]"] if bias else [])]
    for head in (*heads, "phase\n[deg]", "set\n[deg]"):
        table.add_column(Text(head, justify="right"), justify="right")
    for row in _joints(done):
        cells = [f"{row[key]:.1f}" for key in ("amplitude_deg", "amplitude_set_deg")]
        cells.append(f"{row['peak_error_deg']:+.1f}")
        cells += [f"{row[key]:.1f}" for key in ("bias_deg", "bias_set_deg")] if bias else []
        table.add_row(row["name"], *cells, *(f"{row[key]:.0f}" for key in ("phase_deg", "phase_set_deg")))
    return table


def _circuit_table(done: TwinRun) -> Table:
    """Tabulate the pressures of the oil circuits."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("circuit")
    for head in ("least\n[kPa]", "greatest\n[kPa]"):
        table.add_column(Text(head, justify="right"), justify="right")
    for row in _circuits(done):
        table.add_row(row["name"], f"{row['pressure_min_kpa']:.0f}", f"{row['pressure_max_kpa']:.0f}")
    return table
