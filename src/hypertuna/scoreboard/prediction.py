"""Prediction of a published swimmer: its robot by `hypertuna robot new`, its gaits and its settled speeds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.new import Sizes, new_robot
from hypertuna.description.robot import Robot, parse
from hypertuna.scoreboard.swimmers import Run, Swimmer
from hypertuna.swimming.band import speed_band
from hypertuna.swimming.beat import DEFAULT_STEPS, settle
from hypertuna.swimming.gait import Gait, Gaits, named_gait
from hypertuna.swimming.model import core_model

EXCURSION = 0.2  # assumed excursion over length, peak to peak: that of most swimmers (Saadat et al. 2017)
STEEPEST = math.radians(80)  # largest amplitude of a joint tried [rad]
SCALES = 24  # scales of the default wave tried at once


@dataclass(frozen=True)
class Predicted:
    """Prediction of a run; NaN for what is not known."""

    gait: Gait | None  # None where no amplitude reaches the excursion
    speed: float = math.nan  # m/s
    thrust: float = math.nan  # N, of a fish held fixed
    power: float = math.nan  # W, mechanical
    excursion: float = math.nan  # m, peak to peak
    band: tuple[float, float] = (math.nan, math.nan)  # speeds that the robot's estimates allow [m/s]


def first_robot(swimmer: Swimmer) -> Robot:
    """Return a swimmer's first robot, that of `hypertuna robot new`: by links, length, nose, and mass if published."""
    body = swimmer.body
    sizes = Sizes(links=swimmer.link_count, length=body.length, mass=body.mass, nose=swimmer.nose)
    return parse(new_robot(swimmer.name, joints=swimmer.joints, **sizes))


def own_robot(swimmer: Swimmer) -> Robot | None:
    """Return a swimmer's first robot with its published lengths, sections and fin; None where none are published."""
    body, fin = swimmer.body, swimmer.fin
    chord = fin.area / fin.span if fin.area and fin.span else fin.chord
    measures = {"height": body.height, "width": body.width, "fin_span": fin.span, "fin_chord": chord}
    if not swimmer.lengths and not any(measures.values()):
        return None
    extent = {"lengths": swimmer.lengths} if swimmer.lengths else {"links": swimmer.link_count, "length": body.length}
    sizes: Any = measures | extent | {"mass": body.mass, "nose": swimmer.nose}
    return parse(new_robot(swimmer.name, joints=swimmer.joints, **sizes))


def predict_runs(robot: Robot, runs: Sequence[Run]) -> list[Predicted]:
    """Return the predictions of a robot's runs, each speed with the band of the robot's estimates."""
    predictions = [predict(robot, run) for run in runs]
    gaits = {k: p.gait for k, p in enumerate(predictions) if p.gait is not None and math.isfinite(p.speed)}
    if gaits and (bands := speed_band(robot, Gaits.of([*gaits.values()]))) is not None:
        for k, low, high in zip(gaits, bands.low.tolist(), bands.high.tolist(), strict=True):
            predictions[k] = replace(predictions[k], band=(low, high))
    return predictions


def predict(robot: Robot, run: Run) -> Predicted:
    """Return the prediction of a robot's run: its settled speed, or the thrust of a fish held fixed."""
    gait = run_gait(robot, run)
    if gait is None:
        return Predicted(None)
    if run.thrust is not None:
        return held(robot, gait)
    beat = settle(robot, Gaits.of([gait]))
    if beat["status"][0] != 0:
        return Predicted(gait)
    speed, power, excursion = (float(beat[name][0]) for name in ("speed", "mechanical_power", "tail_excursion"))
    return Predicted(gait, speed, power=power, excursion=excursion)


def run_gait(robot: Robot, run: Run) -> Gait | None:
    """Return the gait of a run: published angles, else the default wave at the published excursion; None if too large.

    Where phases alone are missing, they are those of the default wave.
    """
    wave = replace(named_gait(robot, "cruise"), frequency=run.frequency)
    wave = replace(wave, phase=run.phase or wave.phase)
    if run.amplitude is not None:
        return replace(wave, amplitude=run.amplitude)
    return _scaled_to(robot, wave, run.excursion or EXCURSION * robot.body.length, held=run.thrust is not None)


def _scaled_to(robot: Robot, wave: Gait, excursion: float, *, held: bool) -> Gait | None:
    """Return a wave scaled so that the tail tip has an excursion [m]; None if no amplitude reaches it."""
    low, high = 0.02, STEEPEST / max(wave.amplitude)
    for _ in range(3):  # each pass divides the logarithmic interval by 23
        scales = np.geomspace(low, high, SCALES)
        gaits = [replace(wave, amplitude=tuple(scale * a for a in wave.amplitude)) for scale in scales.tolist()]
        excursions = held_excursion(robot, gaits) if held else settle(robot, Gaits.of(gaits))["tail_excursion"]
        too_large = np.flatnonzero(excursions >= excursion)
        if not len(too_large) or too_large[0] == 0:
            return None
        low, high = scales[too_large[0] - 1], scales[too_large[0]]
    return replace(wave, amplitude=tuple(math.sqrt(low * high) * a for a in wave.amplitude))


def held(robot: Robot, gait: Gait) -> Predicted:
    """Return the mean thrust and power of a gait whose head is held still in still water.

    Over a beat the momentum of body and entrained water does not change, so that the mean force of the water is that
    of the core's equations of swimming at twist zero.
    """
    joints = _joint_motion(robot, gait)
    state = _core.dynamics(core_model(robot), joints, np.zeros((len(joints), 3)))
    power = float(state["loss"].mean())  # equals the joints' mean power, as the energy returns every beat
    excursion = float(held_excursion(robot, [gait])[0])
    return Predicted(gait, thrust=-float(state["wrench"][:, 0].mean()), power=power, excursion=excursion)


def held_excursion(robot: Robot, gaits: list[Gait]) -> Array:
    """Return the excursions [m] of the tail tip, peak to peak (gaits,), of a robot whose head is held still."""
    angles = np.stack([_joint_motion(robot, gait)[:, :, 0] for gait in gaits]).cumsum(axis=2)
    tip = (np.sin(angles) * robot.links.length).sum(axis=2)
    result: Array = np.ptp(tip, axis=1)
    return result


def _joint_motion(robot: Robot, gait: Gait) -> Array:
    """Return angle, rate and acceleration of every joint over a beat (steps, links, 3)."""
    clock: Array = 2 * np.pi / DEFAULT_STEPS * np.arange(DEFAULT_STEPS, dtype=np.float64)
    return _core.joint_motion(core_model(robot), **vars(gait), clock=clock)
