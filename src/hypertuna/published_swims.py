"""Swims of everything that the paper reports, under its own model and ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.swimming.gait import Gait, named_gait
from hypertuna.swimming.sweep import Gaits, sweep
from hypertuna.swimming.swim import Swim, swim

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["AS_PRINTED", "MODELS", "OURS", "PAPER", "SPEEDS", "WISHES", "Trial", "bandwidths", "swim_published"]

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
