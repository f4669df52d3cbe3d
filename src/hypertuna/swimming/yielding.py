"""Hinges that yield: the core's rows of settled beats with them, the steps that springs need, and the hinges' swing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sized
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.description.schema.actuator import Hinge
from hypertuna.errors import InputError
from hypertuna.io.quantity import Format, Quantity, summarized
from hypertuna.swimming.gait import Gait, Gaits
from hypertuna.swimming.model import core_model

SOFT = 0.3  # stiffness over that at resonance; above this, the search finds every beat

# Quantities of each hinge in results: unit and meaning.
BEND = {
    "stiffness_ratio": ("1", "stiffness of the hinge over that at resonance with the beat, other hinges rigid"),
    "bend_amplitude": ("rad", "amplitude of the hinge's angle: that of its part at the beat's frequency"),
    "bend_lag": ("rad", "how far that part lags behind the gait's clock"),
    "bend_peak": ("rad", "largest angle of the hinge"),
    "damping_power": ("W", "mean power that the hinge's damper takes, and that of its stops"),
}
SPRING = tuple(_core.spring_columns())  # numbers of a hinge with respect to which results have derivatives


@dataclass(frozen=True)
class Bend:
    """The swing of a hinge in a settled beat."""

    stiffness_ratio: float  # stiffness over that at resonance, other hinges rigid
    bend_amplitude: float  # rad, amplitude of the angle's harmonic at the beat frequency
    bend_lag: float  # rad, lag of this harmonic behind the gait's clock
    bend_peak: float  # rad, largest angle
    damping_power: float  # W, mean power that damper and stops take


def spring_of(hinge: Hinge) -> dict[str, float]:
    """Return the numbers of a hinge's spring [SI] by the core's names; those of missing stops are 0."""
    return {name: getattr(hinge, name) or 0.0 for name in SPRING}


def bend_name(hinges: Sized, name: str, d: int) -> str:
    """Return the name of a quantity of hinge d in results: numbered from 1 if there are several hinges."""
    return name if len(hinges) == 1 else f"{name}_{d + 1}"


def bend_table(robot: Robot) -> dict[str, tuple[str, str]]:
    """Return unit and meaning of all quantities of the hinges in results, by name."""
    return {bend_name(robot.hinges, name, d): row for d in range(len(robot.hinges)) for name, row in BEND.items()}


def bends_of(robot: Robot, result: Mapping[str, Array]) -> tuple[Bend, ...]:
    """Return the swing of each hinge in the first beat of a result of `settle`."""
    return tuple(
        Bend(**{name: float(result[bend_name(robot.hinges, name, d)][0]) for name in BEND})
        for d in range(len(robot.hinges))
    )


def bend_summary(robot: Robot, bends: tuple[Bend, ...]) -> dict[str, Quantity]:
    """Return the swings of all hinges as quantities for summaries, by name."""
    values = {
        bend_name(robot.hinges, name, d): value for d, bend in enumerate(bends) for name, value in vars(bend).items()
    }
    units = {"1": "", "rad": "deg"}
    formats = {name: Format(units.get(unit, unit)) for name, (unit, _) in bend_table(robot).items()}
    return summarized(SimpleNamespace(**values), formats)


def hinge_links(robot: Robot) -> list[int]:
    """Return the link behind each hinge; refuse hinges with more links behind them than the core can compute."""
    links = [hinge.link for hinge in robot.hinges]
    if links and len(robot.links.name) - links[0] > _core.YIELD_LINKS:
        rule, key = f"must have at most {_core.YIELD_LINKS} links behind it", f"{robot.hinge_keys[0]}.link"
        raise InputError(rule, key=key, value=f"{links[0]}", fix="put it further back", file=robot.file)
    return links


def reduced_inertia(robot: Robot, model: _core.Model | None = None) -> Array:
    """Return the inertia that the free, straight body opposes to its hinges (D, D) [kg m^2]."""
    return _core.hinge_inertia(model or core_model(robot), hinge_links(robot))


def steps_for(robot: Robot, frequency: Array, steps: int, model: _core.Model | None = None) -> NDArray[np.int64]:
    """Return the steps per beat at each frequency [Hz] that follow the springs: `steps`, doubled where needed."""
    model = model or core_model(robot)
    springs = _springs(robot, 1).reshape(len(robot.hinges), -1)
    taken = np.array(_core.spring_steps(model, hinge_links(robot), springs, frequency, steps), dtype=np.int64)
    if taken.all():
        return taken
    inertia = reduced_inertia(robot, model).diagonal()
    swing = np.sqrt([sum(steepest(hinge).values()) for hinge in robot.hinges] / inertia)  # rad/s
    decay = [sum(dampers(hinge).values()) for hinge in robot.hinges] / inertia
    d = int(np.maximum(swing, decay).argmax())
    parts, key = (dampers if decay[d] > 2 * swing[d] else steepest)(robot.hinges[d]), robot.hinge_keys[d]
    name = max(parts, key=lambda part: parts[part])
    word, value = {"cubic": "cubic term"}.get(name, name.replace("_", " ")), getattr(robot.hinges[d], name)
    rule = f"must let {max(steps, _core.MOST_SPRING_STEPS)} steps of a beat at {np.min(frequency):g} Hz follow it"
    fix = f"give a lower {word}, more --steps where the command has them, or leave [{key}] out for a rigid joint"
    raise InputError(rule, key=f"{key}.{key_of(name)}", value=f"{value:g}", fix=fix, file=robot.file)


def key_of(name: str) -> str:
    """Return the key in a robot's file of a spring's number, such as ``stop_deg`` of "stop"."""
    return str(Hinge.model_fields[name].alias)


def steepest(hinge: Hinge) -> dict[str, float]:
    """Return the stiffness [N m/rad] of each part of a hinge's spring where the part is steepest, by name."""
    bent = _core.BENT if hinge.stop is None else hinge.stop + abs(hinge.rest)
    return {
        "stiffness": hinge.stiffness,
        "cubic": 3 * hinge.cubic * bent**2,
        "stop_stiffness": hinge.stop_stiffness or 0.0,
    }


def dampers(hinge: Hinge) -> dict[str, float]:
    """Return the damping [N m s/rad] of each part of a hinge where the part is strongest, by name."""
    return {"damping": hinge.damping, "stop_dissipation": hinge.stop_dissipation * _core.COMPRESSED}


def softness(robot: Robot, frequency: float) -> float:
    """Return the squared ratio of the hinges' lowest natural frequency to the beat's [Hz]; k/k_r for one hinge."""
    stiffness = np.array([hinge.stiffness for hinge in robot.hinges])
    square = np.linalg.eigvals(np.linalg.inv(reduced_inertia(robot)) * stiffness).real.min()
    return float(square / (2 * np.pi * frequency) ** 2)


def yield_rows(
    robot: Robot, gaits: Gaits, model: _core.Model, steps: int, options: Mapping[str, Any]
) -> tuple[Array, int, NDArray[np.int64]]:
    """Return the core's rows of settled beats with the hinges, the size of the state, and the steps of each beat."""
    beat_steps = steps_for(robot, gaits.columns[0], steps, model)
    rows = _by_steps(_core.yield_settle, robot, gaits, model, beat_steps, lambda some: options)
    return rows, 3 + 2 * len(robot.hinges), beat_steps


def swing_of(robot: Robot, gaits: Gaits, swings: Array, model: _core.Model) -> dict[str, Any]:
    """Return the columns of `BEND` for each hinge and beat, from mean, sine, cosine, peak and damping (gaits, 5 D)."""
    inertia, omega_squared = reduced_inertia(robot, model).diagonal(), (2 * np.pi * gaits.columns[0]) ** 2
    result: dict[str, Any] = {}
    for d, hinge in enumerate(robot.hinges):
        _, sine, cosine, peak, damping = swings[:, 5 * d : 5 * d + 5].T
        amplitude, lag = np.hypot(sine, cosine), np.arctan2(-cosine, sine) % (2 * np.pi)
        peak = np.where(np.isfinite(amplitude), peak, np.nan)  # a beat that diverged has none
        results = hinge.stiffness / (inertia[d] * omega_squared), amplitude, lag, peak, damping
        result |= {bend_name(robot.hinges, name, d): value for name, value in zip(BEND, results, strict=True)}
    return result


def spring_values(robot: Robot) -> dict[str, float]:
    """Return the springs' numbers [SI], with respect to which results have derivatives, by key in a robot's file."""
    hinges = zip(robot.hinge_keys, robot.hinges, strict=True)
    return {f"{key}.{name}": value for key, hinge in hinges for name, value in spring_of(hinge).items()}


def given_springs(robot: Robot) -> list[str]:
    """Return the keys of `spring_values` that a robot's file gives, and always those of stiffness and damping."""
    hinges = zip(robot.hinge_keys, robot.hinges, strict=True)
    always = {"stiffness", "damping"}
    return [f"{key}.{name}" for key, hinge in hinges for name in SPRING if name in always | hinge.model_fields_set]


def yield_derivatives(
    robot: Robot, gaits: Gaits, state: Array, along: Array, model: _core.Model, steps: int, options: Mapping[str, Any]
) -> Array:
    """Return derivatives as `_core.gradient` does; along: directions (parameters, directions).

    The rows of `along` are the model's parameters, and after them those of the springs (`spring_values`), if any.
    """
    links, parameters = hinge_links(robot), len(model.parameter_names())
    if len(along) == parameters:
        along = np.vstack([along, np.zeros((len(links) * len(SPRING), along.shape[1]))])
    along = np.ascontiguousarray(along)
    beat_steps = steps_for(robot, gaits.columns[0], steps, model)

    def options_of(some: NDArray[np.intp]) -> Mapping[str, Any]:
        return {"state": np.ascontiguousarray(state[some]), "directions": along, **options}

    return _by_steps(_core.yield_gradient, robot, gaits, model, beat_steps, options_of)


def _by_steps(
    kernel: Callable[..., Array],
    robot: Robot,
    gaits: Gaits,
    model: _core.Model,
    each: NDArray[np.int64],
    how: Callable[[NDArray[np.intp]], Mapping[str, Any]],
) -> Array:
    """Return a kernel's rows (gaits, n), computed in one call for all gaits with equal steps per beat.

    each: steps per beat of each gait. how: returns the kernel's options, given indices of gaits.
    """
    links, rows = hinge_links(robot), dict[int, Array]()
    for count in np.unique(each):
        indices = np.flatnonzero(each == count)
        part = [np.ascontiguousarray(column[indices]) for column in gaits.columns]
        computed = kernel(model, links, _springs(robot, len(indices)), *part, steps=int(count), **how(indices))
        rows |= zip(indices.tolist(), computed, strict=True)
    return np.array([rows[k] for k in range(len(each))])


def bend_joints(robot: Robot, gait: Gait, joints: Array, state: Array, steps: int) -> Array:
    """Return joint motions (instants, links, 3) with the hinges bent by the flow, starting from a state of the core."""
    gaits, links = Gaits.of([gait]), hinge_links(robot)
    finer = int(steps_for(robot, gaits.columns[0], 2 * steps)[0]) // (2 * steps)
    count = finer * (len(joints) - 1) + 1
    options: Any = {"steps": 2 * steps * finer, "count": count}
    bends = _core.yield_bends(core_model(robot), links, _springs(robot, 1), *gaits.columns, state, **options)
    bent = joints.copy()
    bent[:, links] += bends[::finer]
    return bent


def moment_power(robot: Robot, clock: Array, joints: Array) -> Array:
    """Return the power (instants,) [W] of the moments that drive hinges, of joints (instants, links, 3)."""
    moment = [hinge.moment * np.sin(clock - hinge.moment_phase) for hinge in robot.hinges]
    power: Array = (np.transpose(moment) * joints[:, hinge_links(robot), 1]).sum(axis=1)
    return power


def too_soft(ratio: float) -> str:
    """Return a sentence on the reason why a search found no beat, from the hinges' softness k/k_r."""
    why = "the tail is too soft, " if ratio < SOFT else ""
    return f"No steady beat: {why}k/k_r = {ratio:.2g} (stiffness of the hinge over that at resonance)."


def folds(bends: tuple[Bend, ...]) -> str:
    """Return a sentence if a hinge swings the tail through the body, an empty text otherwise."""
    folded = any(bend.bend_peak > math.pi for bend in bends)
    return " The hinge bends by more than half a turn, through the body: nothing stops it there." * folded


def _springs(robot: Robot, count: int) -> Array:
    """Return the springs' numbers of all hinges (count, hinges x SPRING), repeated for `count` gaits."""
    return np.tile([*spring_values(robot).values()], (count, 1))
