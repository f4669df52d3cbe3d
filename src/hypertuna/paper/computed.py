"""Simulations of all tests that the paper reports: swims by the paper's model and ours, and runs of the twin."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from hypertuna.actuation.hydraulics import with_bore
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, require
from hypertuna.simulation.posture import PostureTest, posture_test
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twins
from hypertuna.swimming.gait import Gait, Gaits, named_gait
from hypertuna.swimming.sweep import sweep
from hypertuna.swimming.swim import Swim, swim

if TYPE_CHECKING:
    import xarray as xr

PAPER = "ideal joints"  # the paper's own model
OURS = "joint bandwidth"  # our model: one more parameter, the joints' bandwidth
# Options of a robot, by name of the model
MODELS: dict[str, dict[str, str]] = {PAPER: {"joints": "ideal"}, OURS: {"joints": "bandwidth"}}
# The same models with the areas that the paper prints
AS_PRINTED = {f"{name}, areas as printed": choice | {"areas": "as-printed"} for name, choice in MODELS.items()}
TWIN = "twin"  # name of the twin among the models
STRIPS = "strips"  # the strip law, with joints that lag
TARGETS = ("0.3", "0.4", "0.5", "max")  # expected speeds of Table IV [m/s]
COSTS = TARGETS[:3]  # speeds at which the paper compares costs of transport
SPEEDS = tuple(f"{kind}optimised-{speed}" for kind in ("un", "") for speed in TARGETS)  # gaits of Table IV
REST = 20.0  # s: duration of the start of Fig. 12(c), in which the speed settles beyond the tank's length

# Bore of the oil lines [m] -> gait -> speed [m/s], swing of each joint [rad] and power [W].
Bores: TypeAlias = dict[float, dict[str, tuple[float, Array, float]]]

THREADS = 2  # for runs of the twin
SWIM = 20.0  # s: duration of a run that starts at the settled speed; the controller's transients end sooner
TANK = "large"  # amplitude of the tank tests that the twin swims over frequency
LEVELS = ("small", "large")  # amplitudes whose best phase is published
TANK_PHASE = 40.0  # phase difference of the fastest gait [deg]
BORES = (0.003, 0.004, 0.005, 0.006)  # possible bores of the oil lines [m]


@dataclass(frozen=True)
class Trial:
    """Swims of all tests that the paper reports, by one model."""

    robot: Robot
    gaits: dict[str, Swim]  # the robot's named gaits
    tank: xr.Dataset  # the grid of the paper's tank tests
    turning: xr.Dataset  # the turning gait over phases
    feasible: xr.Dataset  # the turning gait with strokes up to the joints' largest bends
    start: Swim  # from rest, as in Fig. 12(c)


def bandwidths(robot: Robot) -> str:
    """Return the distinct bandwidths of a robot's joints [Hz] as text."""
    return " and ".join(dict.fromkeys(f"{group.bandwidth:.3g}" for group in robot.joints if group.bandwidth))


def swim_published(
    robot: Robot, paper: Mapping[str, Any], *, full: bool = False, progress: Callable[[], None] | None = None
) -> dict[str, Trial]:
    """Return swims of all tests in the paper by model; in full also with the areas as Table II prints them."""
    trials = {}
    for name, choice in (MODELS | (AS_PRINTED if full else {})).items():
        trials[name] = try_robot(robot.using(**choice), paper)
        if progress is not None:
            progress()
    return trials


def try_robot(robot: Robot, paper: Mapping[str, Any]) -> Trial:
    """Return swims of all tests in the paper by one robot."""
    tank, turn, start = paper["tank"], named_gait(robot, "turning"), paper["start"]
    phases = [(0.0, float(phase)) for phase in np.radians(tank["phase_deg"])]
    amplitudes = np.radians(list(tank["amplitude_deg"].values())).tolist()
    half_of_limit = tuple(require(group.bend_max, "joints.bend_max_deg", robot) / 2 for group in robot.joints)
    at_start = Gait.from_degrees(
        frequency=start["frequency_hz"],
        amplitude=tank["amplitude_deg"][start["amplitude"]],
        phase=(0, start["phase_deg"]),
    )
    return Trial(
        robot=robot,
        gaits={name: swim(robot, named_gait(robot, name)) for name in robot.gaits},
        tank=sweep(robot, Gaits.grid(frequency=tank["frequency_hz"], amplitude=amplitudes, phase=phases)),
        turning=_turns(robot, paper, turn),
        feasible=_turns(robot, paper, replace(turn, amplitude=half_of_limit, bias=half_of_limit)),
        start=swim(robot, at_start, from_rest=REST),
    )


def _turns(robot: Robot, paper: Mapping[str, Any], gait: Gait) -> xr.Dataset:
    """Return settled beats of a one-sided gait over phase differences."""
    phases = [(0.0, float(phase)) for phase in np.radians(paper["turning"]["phase_deg"])]
    return sweep(
        robot, Gaits.grid(frequency=[gait.frequency], amplitude=[gait.amplitude], phase=phases, bias=[gait.bias])
    )


@dataclass(frozen=True)
class Twins:
    """The twin's runs of the tests reported in the paper."""

    robot: Robot
    gaits: dict[str, TwinRun]  # the eight gaits of Table IV
    tank: tuple[TwinRun, ...]  # large amplitude at the frequencies of the tank tests
    posture: PostureTest  # Fig. 8
    bores: Bores  # empty unless computed in full


def run_published(
    robot: Robot, paper: Mapping[str, Any], *, full: bool = False, progress: Callable[[], None] | None = None
) -> Twins:
    """Return the twin's runs of all tests in the paper; in full also with other oil lines."""
    tank, posture = paper["tank"], paper["posture"]
    amplitude, phase = tank["amplitude_deg"][TANK], (0.0, TANK_PHASE)
    swept = [Gait.from_degrees(frequency=hertz, amplitude=amplitude, phase=phase) for hertz in tank["frequency_hz"]]
    runs = _swims(robot, [*(named_gait(robot, name) for name in SPEEDS), *swept])
    gaits, beats = dict(zip(SPEEDS, runs, strict=False)), tuple(runs[len(SPEEDS) :])
    if progress is not None:
        progress()
    angle = np.radians([posture["angle_deg"] if group.name == posture["joint"] else 0.0 for group in robot.joints])
    held = posture_test(robot, frequencies=posture["frequency_hz"], angle=angle.tolist())
    return Twins(robot, gaits, beats, held, swim_bores(robot) if full else {})


def swim_bores(robot: Robot) -> Bores:
    """Return speed, swing and power of the eight gaits with other bores of the oil lines, which are not published."""
    results = {}
    for bore in BORES:
        with_bores = with_bore(robot, bore)
        runs = _swims(with_bores, [named_gait(with_bores, name) for name in SPEEDS])
        results[bore] = {
            name: (run.speed, run.swing, run.electrical_power) for name, run in zip(SPEEDS, runs, strict=True)
        }
    return results


def _swims(robot: Robot, gaits: Sequence[Gait]) -> list[TwinRun]:
    """Return runs of the twin in gaits, long enough to settle."""
    options = [{"robot": robot, "gait": gait, "duration": SWIM, "start": "swimming"} for gait in gaits]
    return twins(options, measure=lambda run: run, threads=THREADS)
