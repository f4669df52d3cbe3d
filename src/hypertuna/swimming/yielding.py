"""A joint that yields: the core's rows of its settled beats, the steps that its spring needs, and how it swings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.description.schema.actuator import Hinge
from hypertuna.errors import InputError
from hypertuna.io.quantity import Format
from hypertuna.swimming.gait import Gait, Gaits
from hypertuna.swimming.model import core_model

MAX_STEPS = 1024  # a beat, that a stiff spring may ask for by itself
STABLE = 2.3  # steps a beat for each beat's angular frequency that the fastest motion of a spring has: RK4's limit
SOFT = 0.3  # of the stiffness at resonance: above, the search finds every beat

# What a sweep says of the joint beside the quantities of a beat: unit and meaning.
BEND = {
    "stiffness_ratio": ("1", "stiffness of the hinge over that at resonance with the beat"),
    "bend_amplitude": ("rad", "amplitude of the hinge's angle: that of its part at the beat's frequency"),
    "bend_lag": ("rad", "how far that part lags behind the gait's clock"),
    "bend_peak": ("rad", "largest angle of the hinge"),
    "damping_power": ("W", "mean power that the hinge's damper takes"),
}


@dataclass(frozen=True)
class Bend:
    """How a joint that yields swings in a settled beat."""

    stiffness_ratio: Annotated[float, Format()]  # over the stiffness at resonance
    bend_amplitude: Annotated[float, Format("deg")]  # rad, of the part at the beat's frequency
    bend_lag: Annotated[float, Format("deg")]  # rad, of that part behind the gait's clock
    bend_peak: Annotated[float, Format("deg")]  # rad, largest angle
    damping_power: Annotated[float, Format("W")]  # W


def hinge_of(robot: Robot) -> Hinge | None:
    """Return the hinge of a robot, if it has one that the core can follow."""
    if not robot.hinges:
        return None
    (hinge,) = robot.hinges
    if len(robot.links.name) - hinge.link > _core.YIELD_LINKS:
        rule = f"must have at most {_core.YIELD_LINKS} links behind it"
        raise InputError(rule, key="hinge.link", value=f"{hinge.link}", fix="put it further back", file=robot.file)
    return hinge


def resonance(robot: Robot, frequency: Any, model: _core.Model | None = None) -> Any:
    """Return the stiffness [N m/rad] at which the hinge of the free, straight robot resonates with a beat [Hz]."""
    hinge = hinge_of(robot)
    assert hinge is not None
    return _core.reduced_inertia(model or core_model(robot), hinge.link) * (2 * np.pi * frequency) ** 2


def steps_for(robot: Robot, frequency: Array, steps: int, model: _core.Model | None = None) -> NDArray[np.int64]:
    """Return the steps of a beat at each frequency [Hz]: doubled until half of them follow the spring."""
    hinge = hinge_of(robot)
    assert hinge is not None
    inertia = _core.reduced_inertia(model or core_model(robot), hinge.link)
    decay, square = hinge.damping / (2 * inertia), hinge.stiffness / inertia
    fastest = decay + math.sqrt(decay**2 - square) if decay**2 > square else math.sqrt(square)  # 1/s
    needed = 2 * STABLE * fastest / (2 * np.pi * np.asarray(frequency))
    most = max(steps, MAX_STEPS)
    if (needed > most).any():
        damped = decay**2 > square
        word, value = ("damping", hinge.damping) if damped else ("stiffness", hinge.stiffness)
        rule = f"must let {most} steps of a beat at {np.min(frequency):g} Hz follow it"
        fix = f"give less {word}, more --steps where the command has them, or leave [hinge] out for a rigid joint"
        key = f"hinge.{word}_n_m_{'s_' * bool(damped)}per_rad"
        raise InputError(rule, key=key, value=f"{value:g}", fix=fix, file=robot.file)
    return np.asarray(steps * 2 ** np.ceil(np.log2(np.maximum(needed / steps, 1))), dtype=np.int64)


def yield_rows(
    robot: Robot, gaits: Gaits, model: _core.Model, steps: int, options: Mapping[str, Any]
) -> tuple[Array, list[str], int]:
    """Return the core's rows of settled beats with the hinge, the names of their columns, and the size of the state."""
    names, size = _core.yield_columns(), _core.YIELD_STATE_SIZE
    rows = np.empty((len(gaits.columns[0]), len(names) + size * (size + 1)))
    each = steps_for(robot, gaits.columns[0], steps, model)
    for count in np.unique(each):
        some = np.flatnonzero(each == count)
        part = [np.ascontiguousarray(column[some]) for column in gaits.columns]
        spring, (hinge,) = _spring(robot, len(some)), robot.hinges
        rows[some] = _core.yield_settle(model, hinge.link, spring, *part, steps=int(count), **options)
    return rows, names, size


def swing_of(robot: Robot, gaits: Gaits, row: Mapping[str, Array], model: _core.Model) -> dict[str, Array]:
    """Return how the hinge swings in each settled beat: `BEND`."""
    (hinge,) = robot.hinges
    return {
        "stiffness_ratio": hinge.stiffness / resonance(robot, gaits.columns[0], model),
        "bend_amplitude": np.hypot(row["bend_sine"], row["bend_cosine"]),
        "bend_lag": np.arctan2(-row["bend_cosine"], row["bend_sine"]) % (2 * np.pi),
        "bend_peak": row["bend_peak"],
        "damping_power": row["damping_power"],
        "rung": row["rung"],
    }


def yield_derivatives(
    robot: Robot, gaits: Gaits, state: Array, along: Array, model: _core.Model, steps: int, options: Any
) -> Array:
    """Return derivatives as `_core.gradient`, along directions (parameters, or 3 more for the spring; directions)."""
    missing = len(model.parameter_names()) + 3 - len(along)
    along = np.ascontiguousarray(np.vstack([along, np.zeros((missing, along.shape[1]))]))
    each = steps_for(robot, gaits.columns[0], steps, model)
    (hinge,) = robot.hinges
    rows: Array | None = None
    for count in np.unique(each):
        some = np.flatnonzero(each == count)
        part = [np.ascontiguousarray(column[some]) for column in gaits.columns]
        how = {"state": np.ascontiguousarray(state[some]), "directions": along, "steps": int(count)} | options
        found = _core.yield_gradient(model, hinge.link, _spring(robot, len(some)), *part, **how)
        rows = np.empty((len(each), *found.shape[1:])) if rows is None else rows
        rows[some] = found
    assert rows is not None
    return rows


def bend_joints(robot: Robot, gait: Gait, joints: Array, state: Array, steps: int) -> Array:
    """Bend the hinge over joint motions (instants, links, 3), two instants a step, from a state of the core on."""
    (hinge,) = robot.hinges
    gaits = Gaits.of([gait])
    finer = int(steps_for(robot, gaits.columns[0], 2 * steps)[0]) // (2 * steps)
    count = finer * (len(joints) - 1) + 1
    options: Any = {"steps": 2 * steps * finer, "count": count}
    bends = _core.yield_bends(core_model(robot), hinge.link, _spring(robot, 1), *gaits.columns, state, **options)
    bent = joints.copy()
    bent[:, hinge.link] += bends[::finer]
    return bent


def too_soft(ratio: float) -> str:
    """Say why a search found no beat."""
    why = "the tail is too soft, " if ratio < SOFT else ""
    return f"no steady beat: {why}k/k_r = {ratio:.2g} (stiffness of the hinge over that at resonance)."


def folds(peak: float) -> str:
    """Say, as a further sentence, that a hinge swings its tail through the body; nothing of one that does not."""
    return " The hinge bends by more than half a turn, through the body: nothing stops it there." * (peak > math.pi)


def _spring(robot: Robot, count: int) -> Array:
    """Return stiffness, damping and rest angle of the hinge for some gaits (gaits, 3)."""
    (hinge,) = robot.hinges
    return np.tile([hinge.stiffness, hinge.damping, 0.0], (count, 1))
