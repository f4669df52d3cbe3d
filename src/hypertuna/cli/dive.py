"""The command `hypertuna dive`."""

import math
from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np

from hypertuna.cli import options as opt
from hypertuna.cli.console import attended, table
from hypertuna.cli.emit import emit
from hypertuna.cli.gait import GaitOptions, gait_degrees, gait_text
from hypertuna.cli.twin import made_by_twin
from hypertuna.io.files import Csv, columns_csv
from hypertuna.io.quantity import columns
from hypertuna.simulation.dive import Dive, dive


@opt.grouped
def dive_command(
    robot: opt.RobotOptions,
    gait: GaitOptions,
    fins: Annotated[
        float,
        opt.number("--fins", "degrees", "Angle of the pectoral fins in degrees: this far down, then this far up."),
    ] = 45,
    duration: Annotated[float, opt.number("--duration", "seconds", "Total duration of both halves in s.")] = 30,
    depth: Annotated[float, opt.number("--depth", "m", "Depth at the start in m.")] = 2,
    seed: opt.Seed = 0,
    files: opt.Files = opt.NO_FILES,
) -> None:
    """Dive with the pectoral fins down for half of the time, then rise with them up.

    The exit code is 0 if the robot descends with fins down and rises with fins up, 1 if not, 2 for bad input.
    """
    fish = robot.load()
    beat = gait.make(fish)
    options: Any = {"angle": math.radians(fins), "duration": duration, "depth": depth, "seed": seed}
    result = attended("diving", lambda: dive(fish, beat, **options))
    emit(
        result,
        record=_record,
        lines=_lines,
        csv=_csv,
        dataset=lambda result: result.run.dataset(),
        figure="hypertuna.simulation.plots:plot_dive",
        **vars(files),
        failed=result.run.status == "diverged" or not all(leg.right for leg in result.legs),
    )


def _record(result: Dive) -> dict[str, Any]:
    """Return the JSON record."""
    run = result.run
    legs = [
        columns(leg) | {"depth_from_m": leg.depth[0], "depth_to_m": leg.depth[1], "steady": leg.steady}
        for leg in result.legs
    ]
    return (
        {"legs": legs, "symmetry": result.symmetry}
        | {"status": run.status, "status_text": list(result.sentences)}
        | gait_degrees(run.gait)
        | {"duration_s": run.duration, "depth_m": float(run.depth[0]), "seed": run.seed}
        | {"frame": "depth down from the surface, pitch nose up, roll starboard down"}
        | made_by_twin(run.robot)
    )


def _csv(result: Dive) -> Csv:
    """Write a dive as comma-separated values, one row per control period."""
    run = result.run
    table: dict[str, Any] = {
        "time_s": run.time,
        "depth_m": run.depth,
        "pitch_deg": np.degrees(run.pitch),
        "roll_deg": np.degrees(run.roll),
        "heading_deg": np.degrees(run.heading),
        "speed_m_s": run.speed,
        "sink_m_s": run.sink,
        "fin_port_deg": np.degrees(run.data["fin"][:, 0]),
        "fin_starboard_deg": np.degrees(run.data["fin"][:, 1]),
        "east_m": run.position[:, 0],
        "north_m": run.position[:, 1],
        "electrical_power_w": run.data["power"],
    }
    return columns_csv({key: value for key, value in _record(result).items() if key != "legs"}, table)


def _lines(result: Dive) -> Iterator[Any]:
    """Lay out both halves, and describe them."""
    run = result.run
    yield f"{run.robot.name}, {gait_text(run.gait)}", "bold"
    yield f"{run.duration:g} s from a depth of {run.depth[0]:g} m", "dim"
    rows = []
    for leg in result.legs:
        fins, pitch = f"{math.degrees(leg.fins):+z.3g}", f"{math.degrees(leg.pitch):+z.1f}"
        path, rate = f"{leg.depth[0]:.2f} to {leg.depth[1]:.2f}", f"{100 * leg.depth_rate:+z.1f}"
        rows.append((fins, path, rate, pitch, f"{leg.speed:.3f}"))
    yield table(["fins\n[deg]", "depth\n[m]", "depth rate\n[cm/s]", "pitch\n[deg]", "speed\n[m/s]"], rows, left=())
    yield ""
    good = run.status == "completed" and all(leg.right for leg in result.legs)
    style = "bold red" if not good else "green" if all(leg.steady for leg in result.legs) else "yellow"
    for sentence in result.sentences:
        yield sentence, style
