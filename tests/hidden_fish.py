"""Synthetic robots whose coefficients are hidden, and tanks that measure them: for tests and studies of designs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import parse
from hypertuna.design.prediction import Row
from hypertuna.design.runs import AMPLITUDES, FINS, LAGS, QUANTITIES, Measurement, TankRun, gait_of_shares, swims
from hypertuna.design.unknowns import Unknowns, unknowns_of
from hypertuna.identification.coefficients import bounds_of, from_scale, with_values
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model

# Factors by which the robot's values may be off: of a body and a fin that nobody has measured.
PRIOR = {
    "water.strip.drag_tangential=common": 2.0,
    "water.strip.blunt_area=common": 2.0,
    "water.strip.drag_normal=common": 1.5,
    "water.strip.added_mass_normal=common": 1.5,
    "water.strip.drag_beating=common": 1.5,
    "water.strip.edge_lift": 1.3,
}
CRUISE = 0.3  # m/s, at which the share of a hidden linear drag is stated


@dataclass(frozen=True)
class Tank:
    """A hidden robot, and noise."""

    fish: ht.Robot
    rng: np.random.Generator

    def speeds(self, runs: Sequence[TankRun]) -> Array:
        """True speeds (runs,) of swims [m/s]."""
        return np.asarray(settle(self.fish, Gaits.of([run.gait for run in runs if run.gait]), steps=64)["speed"])

    def measure(self, run: TankRun, **about: Any) -> Measurement | None:
        """Measure a speed with the usual noise; None of a gait that does not advance."""
        relative, absolute, *_ = QUANTITIES["speed"]
        true = float(self.speeds([run])[0])
        value = true * (1 + relative * self.rng.standard_normal()) + absolute * self.rng.standard_normal()
        return Measurement(run, "speed", value, **about) if np.isfinite(true) and value > absolute else None


def hidden(unknowns: Unknowns, rng: np.random.Generator, linear: float = 0.0) -> ht.Robot:
    """Draw a robot from the prior, within the bounds; with a linear drag of this share of the drag at 0.3 m/s."""
    lower, upper = bounds_of(unknowns.free)
    while True:
        x = unknowns.mean + unknowns.sd * rng.standard_normal(len(unknowns.mean))
        if np.all((lower < x) & (x < upper)):
            break
    fish = with_values(unknowns.robot, unknowns.free, from_scale(unknowns.free, x))
    return with_linear_drag(fish, linear) if linear else fish


def with_linear_drag(fish: ht.Robot, share: float) -> ht.Robot:
    """Return a robot with a linear drag along the body of this share of its drag at 0.3 m/s."""
    links = len(fish.links.name)
    state = _core.dynamics(core_model(fish), np.zeros((1, links, 3)), np.array([[CRUISE, 0.0, 0.0]]))
    drag = -float(state["wrench"][0, 0])
    document = fish.document()
    document["water"]["strip"]["linear_tangential_pa_s"] = [share * drag / CRUISE / fish.body.length] * links
    return parse(document, file=fish.file)


def unseen(robot: ht.Robot, rng: np.random.Generator, count: int = 40) -> list[Row]:
    """Draw gaits at random within the box of the candidates."""
    space = gait_bounds(robot)
    ends = ((space.low[0], space.high[0]), *((levels[0], levels[-1]) for levels in (AMPLITUDES, LAGS, FINS)))
    shares = [[rng.uniform(*pair) for pair in ends] for _ in range(count)]
    return [Row(run, "speed") for run in swims(gait_of_shares(space, robot, *share) for share in shares)]


def synthetic_unknowns(robot: ht.Robot) -> Unknowns:
    """Return the unknowns of a robot under the strip law."""
    return unknowns_of(robot, PRIOR)
