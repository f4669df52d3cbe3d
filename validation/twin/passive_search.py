"""Best gaits of robots with a passive joint II or another fin: grids of gaits, and the cheapest ones at a speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.design import designed, variable
from hypertuna.description.robot import Robot
from hypertuna.paper.passive import RELAXATION, ROOT, passive_robot
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits

STIFFNESS = tuple(np.geomspace(0.015, 6.0, 46).tolist())  # N m/rad
FREQUENCY = tuple(np.geomspace(0.8, 6.0, 21).tolist())  # Hz
AMPLITUDE = (8.0, 12.0, 16.0)  # deg, of joint I


def with_fin(robot: Robot, span: float, chord: float) -> Robot:
    """Return a robot whose fin's span and chord are multiplied by factors; the mass of its link follows the area."""
    mass = f"links.mass[{len(robot.links.name) - 1}]"
    factors = {"fin.span": span, "fin.chord": chord, mass: robot.links.mass[-1] * span * chord}
    design = [variable(robot, name, 0.99 * value, value) for name, value in factors.items()]
    return designed(robot, design, list(factors.values()))


@dataclass(frozen=True)
class Swum:
    """Speeds and costs of gaits (rows, frequencies, sizes); NaN where a gait does not settle."""

    rows: Sequence[float]  # stiffness [N m/rad], or phase difference [deg]
    frequency: Sequence[float]  # Hz
    size: Sequence[float]  # amplitude [deg], or a factor on the amplitudes
    speed: Array  # m/s
    cost: Array  # J/(kg m)


@dataclass(frozen=True)
class Best:
    """The cheapest gait at a speed, or the fastest one: its cost, speed, row, frequency and amplitude."""

    cost: float  # J/(kg m)
    speed: float  # m/s
    row: float
    frequency: float  # Hz
    size: float


def swim_passive(
    robot: Robot, *, stiffness: Sequence[float] = STIFFNESS, relaxation: float = RELAXATION, link: int = ROOT
) -> Swum:
    """Swim a robot with a passive hinge over stiffness, frequency and amplitude; return settled speeds and costs."""
    amplitudes = [(float(angle),) for angle in np.radians(AMPLITUDE)]
    gaits = Gaits.grid(frequency=list(FREQUENCY), amplitude=amplitudes, phase=[(0.0,)])
    shape = len(FREQUENCY), len(AMPLITUDE)
    rows = []
    for spring in stiffness:
        beat = settle(passive_robot(robot, spring, relaxation=relaxation, link=link), gaits)
        settled = (beat["status"] == 0) & (beat["speed"] > 0)
        rows.append([np.where(settled, beat[key], np.nan).reshape(shape) for key in ("speed", "cost_of_transport")])
    speed, cost = np.moveaxis(np.array(rows), 1, 0)
    return Swum(stiffness, FREQUENCY, AMPLITUDE, speed, cost)


def cheapest(swum: Swum, target: float) -> list[Best | None]:
    """Return each row's cheapest gait at a speed [m/s], by power laws between neighbors; None if out of its reach."""
    best: list[Best | None] = [None] * len(swum.rows)
    axes = np.meshgrid(swum.frequency, swum.size, indexing="ij")
    for axis in (1, 2):
        with np.errstate(invalid="ignore", divide="ignore"):
            speed, cost = (_ends(np.log(values), axis) for values in (swum.speed, swum.cost))
            fraction = (np.log(target) - speed[0]) / (speed[1] - speed[0])
        inside = (fraction >= 0) & (fraction <= 1)
        logs = np.where(inside, cost[0] + np.where(inside, fraction, 0.0) * (cost[1] - cost[0]), np.inf)
        logs[np.isnan(logs)] = np.inf
        for row, costs in enumerate(logs):
            k = np.unravel_index(int(costs.argmin()), costs.shape)
            former = best[row]
            if np.isfinite(costs[k]) and (former is None or costs[k] < np.log(former.cost)):
                numbers = [_between(place, axis, k, float(fraction[(row, *k)])) for place in axes]
                best[row] = Best(float(np.exp(costs[k])), target, swum.rows[row], *map(float, numbers))
    return best


def _ends(values: Array, axis: int) -> tuple[Array, Array]:
    """Return the values at the start and at the end of each step along an axis."""
    count = values.shape[axis]
    return np.take(values, range(count - 1), axis), np.take(values, range(1, count), axis)


def _between(values: Array, axis: int, k: tuple[Any, ...], fraction: float) -> float:
    """Return the value at a fraction of the step that begins at index k along an axis, on a logarithmic scale."""
    low, high = (float(np.log(ends[k])) for ends in _ends(values, axis - 1))
    return float(np.exp(low + fraction * (high - low)))


def fastest(swum: Swum) -> Best:
    """Return the fastest of all gaits."""
    k = np.unravel_index(int(np.nanargmax(swum.speed)), swum.speed.shape)
    row, hertz, size = (int(index) for index in k)
    return Best(float(swum.cost[k]), float(swum.speed[k]), swum.rows[row], swum.frequency[hertz], swum.size[size])


def best_of(swum: Swum, target: float) -> Best | None:
    """Return the cheapest gait of all rows at a speed [m/s]; None where no row reaches it."""
    reached = [gait for gait in cheapest(swum, target) if gait is not None]
    return min(reached, key=lambda gait: gait.cost, default=None)


def tuned(swum: Swum, target: float) -> tuple[float, float, float, float] | None:
    """Return the least cost [J/(kg m)], its stiffness, and the lowest and highest stiffness that cost at most 5 % more.

    The least cost is that of a parabola through the lowest cost and its neighbors, over the stiffness's logarithm.
    """
    rows = cheapest(swum, target)
    cost = np.array([np.inf if g is None else g.cost for g in rows])
    k = int(cost.argmin())
    if not np.isfinite(cost[k]):
        return None
    logs = np.log(np.asarray(swum.rows))
    best, least = float(logs[k]), float(cost[k])
    if 0 < k < len(cost) - 1 and np.isfinite(cost[k - 1 : k + 2]).all():
        a, b, c = np.polyfit(logs[k - 1 : k + 2] - logs[k], cost[k - 1 : k + 2], 2)
        if a > 0:
            best, least = float(logs[k] - b / (2 * a)), float(c - b**2 / (4 * a))
    good = logs[cost <= 1.05 * least]
    low, high = (float(np.exp(end)) for end in (good.min(), good.max())) if good.size else (np.exp(best),) * 2
    return least, float(np.exp(best)), low, high
