"""Runs of the twin through what the paper reports: the eight gaits, the tank tests over frequency, Fig. 8."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.sizing import with_bore
from hypertuna.description.robot import Robot
from hypertuna.published_swims import SPEEDS
from hypertuna.simulation.posture_test import PostureTest, posture_test
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twins
from hypertuna.swimming.gait import Gait, named_gait

__all__ = ["SWIM", "TANK_PHASE", "Twins", "run_published", "swim_bores"]

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
