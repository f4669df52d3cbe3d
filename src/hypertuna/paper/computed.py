"""Swims of everything that the paper reports, under its own model and ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.sizing import with_bore
from hypertuna.description.robot import Robot
from hypertuna.simulation.posture_test import PostureTest, posture_test
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twins
from hypertuna.swimming.gait import Gait, named_gait
from hypertuna.swimming.sweep import Gaits, sweep
from hypertuna.swimming.swim import Swim, swim

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "AS_PRINTED",
    "MODELS",
    "OURS",
    "PAPER",
    "SPEEDS",
    "SWIM",
    "TANK_PHASE",
    "WISHES",
    "Trial",
    "Twins",
    "bandwidths",
    "run_published",
    "swim_bores",
    "swim_published",
]

PAPER = "ideal joints"  # the paper's own model
OURS = "joint bandwidth"  # with our one parameter more
MODELS: dict[str, dict[str, str]] = {PAPER: {"joints": "ideal"}, OURS: {"joints": "bandwidth"}}
AS_PRINTED = {f"{name}, areas as printed": choice | {"areas": "as-printed"} for name, choice in MODELS.items()}
WISHES = ("0.3", "0.4", "0.5", "max")  # expected speeds of Table IV [m/s]
SPEEDS = tuple(f"{kind}optimised-{wish}" for kind in ("un", "") for wish in WISHES)
REST = 10.0  # s: Fig. 12(c), from rest until long after the speed has settled


@dataclass(frozen=True)
class Trial:
    """What one model computes.

    Attributes
    ----------
    robot : Robot
    gaits : dict of str to Swim
        The robot's named gaits.
    tank : xarray.Dataset
        The grid of the paper's tank tests.
    turning : xarray.Dataset
        The turning gait over phases.
    start : Swim
        From rest, as in Fig. 12(c).
    """

    robot: Robot
    gaits: dict[str, Swim]
    tank: xr.Dataset
    turning: xr.Dataset
    start: Swim


def bandwidths(robot: Robot) -> str:
    """Say the bandwidths of a robot's joints.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    str
        In Hz, each once.
    """
    return " and ".join(dict.fromkeys(f"{group.bandwidth:.3g}" for group in robot.joints if group.bandwidth))


def swim_published(
    robot: Robot, paper: Mapping[str, Any], *, full: bool = False, progress: Callable[[], None] | None = None
) -> dict[str, Trial]:
    """Swim everything that the paper reports.

    Parameters
    ----------
    robot : Robot
    paper : mapping
        Content of data/published/published.toml.
    full : bool
        Also under the areas as Table II prints them.
    progress : callable, optional
        Called after each model.

    Returns
    -------
    dict of str to Trial
        By model.
    """
    trials = {}
    for name, choice in (MODELS | (AS_PRINTED if full else {})).items():
        trials[name] = _try(robot.using(**choice), paper)
        if progress is not None:
            progress()
    return trials


def _try(robot: Robot, paper: Mapping[str, Any]) -> Trial:
    """Swim it under one model."""
    tank, turn, start = paper["tank"], named_gait(robot, "turning"), paper["start"]
    phases = [(0.0, float(phase)) for phase in np.radians(tank["phase_deg"])]
    amplitudes = np.radians(list(tank["amplitude_deg"].values())).tolist()
    turns = [(0.0, float(phase)) for phase in np.radians(paper["turning"]["phase_deg"])]
    at_start = Gait.from_degrees(
        frequency=start["frequency_hz"],
        amplitude=tank["amplitude_deg"][start["amplitude"]],
        phase=(0, start["phase_deg"]),
    )
    return Trial(
        robot=robot,
        gaits={name: swim(robot, named_gait(robot, name)) for name in robot.gaits},
        tank=sweep(robot, Gaits.grid(frequency=tank["frequency_hz"], amplitude=amplitudes, phase=phases)),
        turning=sweep(
            robot, Gaits.grid(frequency=[turn.frequency], amplitude=[turn.amplitude], phase=turns, bias=[turn.bias])
        ),
        start=swim(robot, at_start, from_rest=REST),
    )


Array = NDArray[np.float64]

THREADS = 2
SWIM = 20.0  # s: from the speed of the lagging joints, until the controller's own transients are over
TANK = "large"  # amplitude of the tank tests at which joints are watched over frequency
TANK_PHASE = 40.0  # deg, of the fastest gait
BORES = (0.003, 0.004, 0.005, 0.006)  # m, of the oil lines: what may be


@dataclass(frozen=True)
class Twins:
    """What the twin computes.

    Attributes
    ----------
    robot : Robot
    gaits : dict of str to TwinRun
        The eight gaits of Table IV.
    tank : tuple of TwinRun
        Large amplitude at the frequencies of the tank tests.
    posture : PostureTest
        Fig. 8.
    bores : dict of float to dict of str to tuple
        By bore of the oil lines [m]: speed [m/s], swing of each joint [rad] and power [W] of the eight gaits; empty if
        it was not asked for.
    """

    robot: Robot
    gaits: dict[str, TwinRun]
    tank: tuple[TwinRun, ...]
    posture: PostureTest
    bores: dict[float, dict[str, tuple[float, Array, float]]]


def run_published(
    robot: Robot, paper: Mapping[str, Any], *, full: bool = False, progress: Callable[[], None] | None = None
) -> Twins:
    """Run the twin through what the paper reports.

    Parameters
    ----------
    robot : Robot
    paper : mapping
        Content of data/published/published.toml.
    full : bool
        Also with other oil lines.
    progress : callable, optional
        Called after the swims and after the posture test.

    Returns
    -------
    Twins
    """
    tank, posture = paper["tank"], paper["posture"]
    amplitude, phase = tank["amplitude_deg"][TANK], (0.0, TANK_PHASE)
    swept = [Gait.from_degrees(frequency=hertz, amplitude=amplitude, phase=phase) for hertz in tank["frequency_hz"]]
    runs = _swims(robot, [*(named_gait(robot, name) for name in SPEEDS), *swept])
    gaits, beats = dict(zip(SPEEDS, runs, strict=False)), tuple(runs[len(SPEEDS) :])
    if progress is not None:
        progress()
    angle = np.radians([posture["angle_deg"] if group.name == posture["joint"] else 0.0 for group in robot.joints])
    held = posture_test(robot, frequencies=posture["frequency_hz"], angle=angle.tolist())
    if progress is not None:
        progress()
    return Twins(robot, gaits, beats, held, swim_bores(robot) if full else {})


def swim_bores(robot: Robot) -> dict[float, dict[str, tuple[float, Array, float]]]:
    """Swim the eight gaits with oil lines of other bores, which are not published.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    dict of float to dict of str to tuple
        As `Twins` holds it.
    """
    found = {}
    for bore in BORES:
        other = with_bore(robot, bore)
        runs = _swims(other, [named_gait(other, name) for name in SPEEDS])
        found[bore] = {name: (run.speed, run.swing, run.power) for name, run in zip(SPEEDS, runs, strict=True)}
    return found


def _swims(robot: Robot, gaits: Sequence[Gait]) -> list[TwinRun]:
    """Swim gaits until they have settled."""
    options = [{"robot": robot, "gait": gait, "duration": SWIM, "start": "swimming"} for gait in gaits]
    return twins(options, measure=lambda run: run, threads=THREADS)
