"""Points of a joint of finite elements: under a couple, along a path of pressures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hypertuna.description.robot import Robot
from hypertuna.fe_measure import measure
from hypertuna.fe_model import FeOptions, equilibrium, fe_model

__all__ = ["Joint", "Pair", "joint_by_elements"]

Pair = tuple[float, float]
# Answers for a couple [N m]: the joint under the last of the pairs of pressures [Pa] after having gone through those
# before: angle [rad], volume [m^3] of either side, fault (a sentence, empty where there is none).
Joint = Callable[[float, Sequence[Pair]], Mapping[str, Any]]


def joint_by_elements(robot: Robot, joint: str | int, options: FeOptions | None = None) -> Joint:
    """Make a joint of finite elements that answers point by point.

    It goes on from where it is where a path only grows longer, and begins at rest where it does not.

    Parameters
    ----------
    robot : Robot
    joint : str or int
        Name or index of the joint group.
    options : FeOptions, optional

    Returns
    -------
    callable
        Of a couple [N m] and pairs of pressures [Pa] that lead to a point; a mapping with angle [rad], volume [m^3] and
        fault.
    """
    model: Any = None
    place: tuple[float, tuple[Pair, ...]] | None = None

    def solve(couple: float, path: Sequence[Pair]) -> Mapping[str, Any]:
        nonlocal model, place
        model = model or fe_model(robot, joint, options)
        steps = list(path)
        if place == (couple, tuple(path[:-1])):
            steps = steps[-1:]
        else:
            _rest(model)
        place = None
        for pair in steps:
            ended = equilibrium(model, pressure=pair, couple=couple)
            if not ended.converged:
                return {"fault": ended.text}
        place = couple, tuple(path)
        measured = measure(model)
        return {"angle": measured.angle, "volume": list(measured.volume), "fault": measured.fault}

    return solve


def _rest(model: Any) -> None:
    """Take all loads and all displacement from a model."""
    for given in model.problem.loads:
        given.Set(0.0)
    model.displacement.vec[:] = 0.0
