"""The command `hypertuna dive`."""

import math
from typing import Annotated, Any

import numpy as np

from hypertuna.cli import options as opt
from hypertuna.cli.console import attended
from hypertuna.cli.emit import emit
from hypertuna.cli.gait import GaitOptions
from hypertuna.cli.twin import made_by_twin
from hypertuna.io.files import Csv, columns_csv
from hypertuna.io.quantity import columns
from hypertuna.simulation.dive import Dive, dive
from hypertuna.swimming.gait import gait_degrees


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
        csv=_csv,
        dataset=lambda result: result.run.dataset(),
        **vars(files),
        failed=result.run.status == "diverged" or not all(leg.right for leg in result.legs),
    )


def _record(result: Dive) -> dict[str, Any]:
    """Return the JSON record of a dive."""
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
    """Return the CSV table of a dive, one row per control period."""
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
