"""Prediction of all runs of the trials by the model, with exact derivatives by the free coefficients."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.identification.coefficients import columns, parameter_jacobian, position
from hypertuna.identification.experiment import KINDS, Experiment, Replayed
from hypertuna.swimming.beat import DEFAULT_STEPS, directional_derivatives, settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model, parameter_names
from hypertuna.trials.replay import replay_jacobian
from hypertuna.trials.start import between, head_of, meet

Flags = NDArray[np.bool_]

FAILED = 10.0  # error of a run without a settled beat: times what was measured, or body lengths, or rad
USABLE = (0, 2)  # settled, and periodic but unstable: both have derivatives


@dataclass(frozen=True)
class Prediction:
    """Computed runs of an experiment."""

    computed: Array  # (elements,), in the units of what was measured
    jacobian: Array  # (elements, n), by the free coefficients, each in its scale
    failed: Flags  # (runs,), without a settled beat
    unstable: Flags  # (runs,), periodic but unstable
    measurable: dict[str, tuple[Array, Array]]  # speed and cost of transport of all steady runs, and their Jacobians


def predict(
    data: Experiment,
    values: Sequence[float] | Array,
    *,
    gradient_steps: int | None = DEFAULT_STEPS,
    levels: Mapping[str, float] | None = None,
) -> Prediction:
    """Compute every run of the trials for values (n,) of the free coefficients [SI].

    A run without a settled beat is far off, with zero Jacobian, so that a search turns back. gradient_steps:
    Runge-Kutta steps per beat of the derivatives of steady runs; None leaves all Jacobians zero. levels: noise of
    frames, by kind, for runs of which it is not known how they begin.
    """
    model = core_model(data.robot, columns(data.robot, data.free, values))
    along = None if gradient_steps is None else parameter_jacobian(data.robot, data.free, values)
    runs = len(data.trials.runs)
    failed, unstable = np.zeros(runs, dtype=bool), np.zeros(runs, dtype=bool)
    computed: list[Array] = []
    jacobians: list[Array] = []
    measurable: dict[str, tuple[Array, Array]] = {}
    if steady := data.trials.steady:
        measurable, status = _steady(data, values, model, along, gradient_steps or data.steps)
        failed[: len(steady)], unstable[: len(steady)] = ~np.isin(status, USABLE), status == 2
        kind = data.kind[: (data.kind < 2).sum()]
        run = data.run[: len(kind)]
        for table, parts in enumerate((computed, jacobians)):
            both = np.stack([measurable[name][table] for name in KINDS[:2]])
            parts.append(both[kind, run])
        wrong = failed[run]
        size = np.maximum(np.abs(data.measured[: len(kind)]), data.sd[: len(kind)])
        computed[0][wrong] = FAILED * size[wrong]
        jacobians[0][wrong] = 0.0
    first = len(steady)
    for recording in data.recordings:
        poses, jacobian, sound = _tracked(data, recording, values, model, along, levels or {})
        computed.append(poses)
        jacobians.append(jacobian)
        failed[first : first + recording.runs] = not sound
        first += recording.runs
    return Prediction(np.concatenate(computed), np.concatenate(jacobians), failed, unstable, measurable)


def weighted(data: Experiment, prediction: Prediction, levels: dict[str, float]) -> tuple[Array, Array]:
    """Return residuals (elements,), computed minus measured, and their Jacobian, in units of their standard deviation.

    levels: noise of the kinds whose noise is unknown, relative for speed and cost of transport [1], [m] and [rad].
    """
    scale = (data.noise(levels) * np.sqrt(data.count))[data.sample]
    return (prediction.computed - data.measured) / scale, prediction.jacobian / scale[:, np.newaxis]


def _steady(
    data: Experiment, values: Sequence[float] | Array, model: Any, along: Array | None, gradient_steps: int
) -> tuple[dict[str, tuple[Array, Array]], NDArray[Any]]:
    """Compute speed and cost of transport of every steady run, with their Jacobians, and its status."""
    gaits = Gaits.of([run.gait for run in data.trials.steady])
    beats = settle(data.robot, gaits, model=model, steps=data.steps, threads=data.threads)
    by: dict[str, Array] = dict.fromkeys(KINDS[:2], np.zeros((len(gaits), len(data.free))))
    if along is not None:
        with np.errstate(all="ignore"):  # gaits without a settled beat have no derivatives
            options: dict[str, Any] = {"model": model, "steps": gradient_steps, "threads": data.threads}
            by = directional_derivatives(data.robot, gaits, beats, along, **options)
    usable = np.isin(beats["status"], USABLE) & np.isfinite(beats["cost_of_transport"]) & (beats["speed"] != 0)
    status = np.where(usable, beats["status"], 3)
    table = {
        name: (beats[name], np.where(usable[:, np.newaxis] & np.isfinite(by[name]), by[name], 0.0))
        for name in KINDS[:2]
    }
    if (k := position(data.free, "cost_factor")) is not None:
        # the measured cost of transport is the mechanical one times this factor
        cost, jacobian = table["cost_of_transport"]
        factor = float(values[k])
        jacobian = factor * jacobian
        jacobian[:, k] = np.where(usable, cost * (factor if data.free[k].scale == "log" else 1.0), 0.0)
        table["cost_of_transport"] = factor * cost, jacobian
    return table, status


def _tracked(
    data: Experiment,
    recording: Replayed,
    values: Sequence[float] | Array,
    model: Any,
    along: Array | None,
    levels: Mapping[str, float],
) -> tuple[Array, Array, bool]:
    """Return poses at the frames of all runs, axis by axis, their Jacobian, and whether the replay is finite."""
    frames, n = len(recording.frames), len(data.free)
    gradient = along is not None
    along = np.zeros((len(parameter_names(data.robot)), 0)) if along is None else along
    half = columns(data.robot, data.free, values).get("links.length", data.robot.links.length)[0] / 2
    by_half = along[parameter_names(data.robot).index("links.length[0]")] / 2
    # at the frames, between two steps of the replay; before its start the robot rests
    k = position(data.free, "time_offset", recording.name)
    shift = 0.0 if k is None else float(values[k]) - recording.offset
    clock = (recording.frames - shift - recording.time[0]) / recording.step

    def swum(twist: Array | None) -> tuple[Array, Array, Array]:
        pose, _, by = replay_jacobian(data.robot, recording.joints, recording.step, along, model=model, twist=twist)
        first = 0 if twist is None else 3
        by_own = by_half if twist is None else np.append(np.zeros(3), by_half)
        center, by = head_of(half, pose, by, by_own)
        at, by = between(center, by, clock)
        if k is not None and gradient:
            left = np.clip(np.floor(clock).astype(int), 0, len(center) - 2)
            rate = (center[left + 1] - center[left]) / recording.step
            by[:, :, first + k] = np.where((clock < 0)[:, np.newaxis], 0.0, -rate)
        return at, by[..., :first], by[..., first:]

    if recording.unknown is None:
        at, _, by = swum(recording.twist)
    else:
        noise = data.frame_noise(recording.name, levels)
        at, by = meet(recording.unknown, swum, recording.twist, recording.error, noise)[2:]
    by = by if gradient else np.zeros((frames, 3, n))
    if not (np.isfinite(at).all() and np.isfinite(by).all()):
        far = FAILED * np.array([data.robot.body.length, data.robot.body.length, 1.0])
        return np.repeat(far, frames), np.zeros((3 * frames, n)), False
    turn = recording.turn
    rotation = np.stack([np.cos(turn), -np.sin(turn), np.sin(turn), np.cos(turn)], -1).reshape(-1, 2, 2)
    at[:, :2] = np.einsum("fij,fj->fi", rotation, at[:, :2])
    by[:, :2] = np.einsum("fij,fjn->fin", rotation, by[:, :2])
    return at.T.ravel(), np.moveaxis(by, 1, 0).reshape(3 * frames, n), True
