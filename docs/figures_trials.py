"""Tables of docs/trials.md; docs/figures.py includes them."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from figures_common import rows
from figures_reference import sections
from matplotlib.figure import Figure

from hypertuna.description.robot import load
from hypertuna.identification.identify import identify
from hypertuna.trials.comparison import compare_recording, replay_recording
from hypertuna.trials.manifest import Manifest
from hypertuna.trials.marker_import import read_marker_run, write_marker_runs
from hypertuna.trials.plots_markers import plot_markers
from hypertuna.trials.steady import COLUMNS
from hypertuna.trials.trials import read_trials

SWING = ", as in results of `swim`: amplitude and lag of its angle"
ROOT = Path(__file__).resolve().parents[1]


def steady_columns() -> str:
    """Tabulate the columns of a file of steady runs."""
    body = [
        ["`frequency_hz`", "Hz", "yes", "beat frequency"],
        ["`amplitude_GROUP_deg`", "deg", "yes", "commanded amplitude of each joint group"],
        ["`phase_GROUP_deg`", "deg", "yes", "lag of each joint group; default of the first: 0"],
        ["`bias_GROUP_deg`", "deg", "", "mean angle of each joint group (default: 0)"],
        ["`{speed}`", "m/s", "either", "speed along the mean path"],
        ["`{speed_sd}`", "m/s", "", "standard deviation of the speed of a single swim"],
        ["`speed_bl_s`, `speed_sd_bl_s`", "BL/s", "", "the same in body lengths a second, in place of these"],
        ["`{cost_of_transport}`", "J/(kg m)", "or", "mechanical power over mass of the robot and speed"],
        ["`{cost_of_transport_sd}`", "J/(kg m)", "", "standard deviation of the cost of transport of a single swim"],
        ["`power_w`, `power_sd_w`", "W", "", "mechanical power, in place of these: it is divided by mass and speed"],
        ["`bend_amplitude_deg`, `bend_lag_deg`", "deg", "or", f"swing of a passive hinge{SWING}"],
        ["`bend_amplitude_sd_deg`, `bend_lag_sd_deg`", "deg", "", "their standard deviations in a single swim"],
        ["`{repeats}`", "", "", "number of swims that the row is the mean of (default: 1)"],
        ["`{name}`", "", "", "name of the run (default: FILE:LINE)"],
    ]
    return rows(
        ["column", "unit", "required", "meaning"], [[cell.format(**COLUMNS) for cell in r] for r in body], left=4
    )


def quoted(name: str, kind: str, lines: int | None = None) -> str:
    """Quote the first lines of a file of the examples."""
    text = (ROOT / "examples" / name).read_text().splitlines()
    return "\n".join([f"```{kind}", *text[:lines], *(["..."] if lines else []), "```"])


def markers_predicted() -> str:
    """Fit two swims of the example of markers, and tabulate errors of a third, before and after the fit."""
    robot, runs = load("rexeel"), {}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("slow", "middle", "fast"):
            run = read_marker_run(robot, ROOT / "examples/eel" / f"{name}.csv", scale=0.001, y_down=True)
            write_marker_runs([run], robot, Path(folder) / f"{name}.toml", "made by docs/figures.py")
            runs[name] = read_trials(Path(folder) / f"{name}.toml", robot)
    fit = identify(robot, runs["slow"] + runs["middle"], validate=0)
    (fast,) = runs["fast"].recordings
    body = []
    for label, fish in (("as described", robot), ("fitted to the two slower swims", fit.robot)):
        x, y, yaw = compare_recording(fish, fast, replay_recording(fish, fast)).rmse.to_numpy()
        body.append([label, f"{1000 * x:.1f}", f"{1000 * y:.1f}", f"{np.degrees(yaw):.1f}"])
    return rows(["coefficients", "rmse of x [mm]", "y [mm]", "yaw [deg]"], body)


def strangers(kind: str) -> list[dict[str, Any]]:
    """Return the stored runs of validation/identify/strangers.py of a kind."""
    document = json.loads((ROOT / "validation/identify/strangers.json").read_text())
    return [run for run in document["runs"] if run["kind"] == kind]


def held_out() -> str:
    """Tabulate errors of swims that the fit has not seen, two for each robot."""
    body = []
    for run in strangers("held out"):
        own = [
            run[name][key] for name in ("described", "fitted") for key in ("travel_percent", "settled_speed_percent")
        ]
        path = 100 * max(run["fitted"]["path_rmse_lengths"])
        errors = [", ".join(f"{error:+.1f}" for error in pair) for pair in own]
        shed = f"{run['tail_shedding']:g}"
        body.append([run["robot"], run["swims"], run["begin"], shed, errors[0], errors[2], errors[3], f"{path:.1f}"])
    heads = [
        "robot",
        "swims",
        "begin",
        "`tail_shedding`",
        "distance, handbook [%]",
        "distance, fitted [%]",
        "settled speed, fitted [%]",
    ]
    return rows([*heads, "path [% of length]"], body, left=3)


def coverage(kind: str) -> str:
    """Tabulate errors and 90 % intervals of coefficients over repeats with other noise."""
    runs = strangers(kind)
    error, half, holds = (np.array([run[key] for run in runs]) for key in ("error", "half_width", "held"))
    body = []
    for k, name in enumerate(("drag along", "drag across", "added mass")):
        held = f"{holds[:, k].sum()} of {len(runs)}"
        body.append(
            [name, *(f"{100 * x:.1f}" for x in (error[:, k].mean(), error[:, k].std(), half[:, k].mean())), held]
        )
    return rows(["factor on", "mean error [%]", "scatter [%]", "half-width [%]", "interval holds the truth"], body)


def defaults() -> str:
    """Tabulate errors of the robot eel's swims that a fit has not seen, by what is free, over their repeatability."""
    runs = json.loads((ROOT / "validation/identify/defaults.json").read_text())["runs"]
    splits = ("10 to 30 deg", "30 to 10 deg", "early to all")
    by = {(run["joints"], run["free"], run["tail_shedding"]): run for run in runs}
    shown = [(joints, name) for joints, name, shedding in by if shedding == 1 and joints == "measured"]
    shown += [("targets", name) for _, name in shown if name == "the same, with priors"]
    body = []
    for joints, name in shown:
        label = "the same, targets of the joints" if joints == "targets" else name
        errors = [by[joints, name, shedding][split]["over_repeatability"] for shedding in (0, 1) for split in splits]
        body.append([label, *(f"{error:.2f}" for error in errors)])
    heads = [f"{split}, shedding {shedding}" for shedding in (0, 1) for split in splits]
    return rows(["free", *heads], body)


TABLES: dict[str, Callable[[], str]] = {
    "steady columns": steady_columns,
    "steady example": lambda: quoted("tank/tank.csv", "text", 5),
    "manifest example": lambda: quoted("tank/tank.toml", "toml"),
    "manifest keys": lambda: sections(Manifest),
    "markers predicted": markers_predicted,
    "strangers held out": held_out,
    "strangers coverage": lambda: coverage("coverage"),
    "strangers without priors": lambda: coverage("without priors"),
    "defaults": defaults,
}


def markers() -> Figure:
    """Plot the chain over the markers of an example."""
    path = ROOT / "examples/eel/slow.csv"
    return plot_markers(read_marker_run(load("rexeel"), path, scale=0.001, y_down=True))


PICTURES: dict[str, Callable[[], Figure]] = {"docs/markers.svg": markers}
