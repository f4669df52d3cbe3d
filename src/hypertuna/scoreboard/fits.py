"""One drag area fitted to one speed of a swimmer, and the other speeds predicted with it."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import NamedTuple

from scipy.optimize import brentq

from hypertuna.description.robot import Robot, parse
from hypertuna.scoreboard.prediction import predict
from hypertuna.scoreboard.swimmers import Run

AREAS = 1e-7, 1.0  # range of the drag areas tried, over the length squared
TOLERANCE = 0.1  # relative error within which another speed counts as predicted, beside the published error


class Other(NamedTuple):
    """A predicted speed of a swimmer, with the drag area that was fitted to another of its runs."""

    fitted: str  # run whose speed the drag area meets
    run: str  # run whose speed is predicted
    ratio: float  # predicted over published; NaN where no drag area meets the fitted speed
    error: float  # published relative errors of both runs, combined; 0 if there are none

    @property
    def holds(self) -> bool:
        """Whether the speed is within 10 % and the published errors."""
        return abs(self.ratio - 1) <= TOLERANCE + self.error


def other_speeds(robot: Robot, runs: Sequence[Run]) -> list[Other]:
    """Fit the drag area to each speed of a robot in turn, and predict its other speeds; empty with a single speed."""
    runs = [run for run in runs if run.thrust is None]
    others = []
    for fitted_run in runs if len(runs) > 1 else ():
        fitted = fitted_robot(robot, fitted_run)
        for run in (run for run in runs if run is not fitted_run):
            speed = math.nan if fitted is None else predict(fitted, run).speed
            error = math.hypot(fitted_run.speed_error or 0.0, run.speed_error or 0.0)
            others.append(Other(fitted_run.name, run.name, speed / run.speed, error))
    return others


def fitted_robot(robot: Robot, run: Run) -> Robot | None:
    """Return a robot with the drag area of the head that meets the speed of a run; None where none does."""

    def excess(log_area: float) -> float:
        speed = predict(with_drag_area(robot, math.exp(log_area)), run).speed
        return (speed if math.isfinite(speed) else 0.0) - run.speed

    low, high = (math.log(area * robot.body.length**2) for area in AREAS)
    if excess(low) * excess(high) >= 0:
        return None
    return with_drag_area(robot, math.exp(brentq(excess, low, high, xtol=1e-4)))


def with_drag_area(robot: Robot, area: float) -> Robot:
    """Return a robot on strip water with another drag area of the head [m^2]."""
    document = copy.deepcopy(robot.document())
    document["water"]["strip"]["blunt_area_m2"][0] = area
    return parse(document)
