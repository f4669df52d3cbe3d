"""Range of speed that a robot's estimates leave: settled beats of robots sampled with the factors in [uncertainty]."""

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from annotated_types import Le
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from hypertuna.arrays import Array
from hypertuna.description.provenance import factor_of
from hypertuna.description.robot import Robot
from hypertuna.description.validation import nested_model
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model, model_values

SAMPLES, SEED = 128, 1  # number of samples, and seed of the random numbers
STEPS = 32  # Runge-Kutta steps per beat: an error of 3e-4 of the speed
INSIDE = 0.9  # part of the samples inside the band
# Uncertainty factor of the speed due to the water law: the thrust of plates that pitch and heave is within 30 % of
# thin-airfoil theory, and the speed is off by half of that. HyperTuna's unfitted gaits are off by 6 % (rms).
LAW = 1.2


@dataclass(frozen=True)
class Band:
    """The range of speed [m/s] that holds 90 % of the samples, for each gait."""

    low: Array  # (gaits,) [m/s]
    high: Array  # (gaits,) [m/s]
    settled: Array  # (gaits,), part of the samples whose beat settles; the band is over these samples

    def ends(self, gait: int = 0) -> str:
        """Return the two ends of a gait's band [m/s] as text: ``0.118 to 0.325``."""
        return f"{self.low[gait]:.3g} to {self.high[gait]:.3g}" if self.settled[gait] else "no sample settles"

    def sentence(self, gait: int = 0) -> str:
        """Return a sentence on the band of a gait, and on samples that do not settle."""
        lost = f"{100 * (1 - self.settled[gait]):.2g} % of the samples do not settle" * bool(self.settled[gait] < 1)
        if not self.settled[gait]:
            return "The estimates of the robot's file leave no speed: none of the samples settles."
        ends = self.ends(gait)
        return f"By the estimates of its file alone, {ends} m/s ({100 * INSIDE:.0f} %){f'; {lost}' * bool(lost)}."


def estimated(robot: Robot) -> dict[str, float]:
    """Return the uncertainty factors of the estimates that the robot's model uses, by place in the description."""
    keys = {place: ".".join(field.alias or "" for field in _fields(place)) for place in model_values(robot)}
    return {place: factor for place, key in keys.items() if (factor := factor_of(robot, key)) > 1}


def speed_band(robot: Robot, gaits: Gaits) -> Band | None:
    """Return the speed bands of gaits; None for a robot without estimates of known uncertainty.

    Each estimate has a lognormal distribution with its factor, and one value for all links; one more factor stands for
    the water law.

    Parameters
    ----------
    robot : Robot
        Robot with the factors of its estimates in ``[uncertainty]``.
    gaits : Gaits
        Gaits that fit the robot.

    Returns
    -------
    Band or None
    """
    samples = sampled_columns(robot)
    if samples is None:
        return None
    speeds = np.full((SAMPLES, len(gaits)), np.nan)
    for k, (columns, law) in enumerate(zip(*samples, strict=True)):
        beat = settle(robot, gaits, model=core_model(robot, columns), steps=STEPS)
        speeds[k] = np.where(beat["status"] == 0, law * beat["speed"], np.nan)
    settled = np.isfinite(speeds)
    ends = np.full((2, len(gaits)), np.nan)
    any_settled = settled.any(axis=0)
    ends[:, any_settled] = np.nanquantile(speeds[:, any_settled], [(1 - INSIDE) / 2, (1 + INSIDE) / 2], axis=0)
    return Band(ends[0], ends[1], settled.mean(axis=0))


def sampled_columns(robot: Robot) -> tuple[list[dict[str, list[float]]], Array] | None:
    """Return samples of a robot's estimated columns, and of the water law's factor on the speed; None without any."""
    factors = estimated(robot)
    if not factors:
        return None
    values, scales = model_values(robot), _drawn([*factors.values(), LAW])
    limits = {place: _largest(place) for place in factors}
    columns = [
        {
            place: [min(scale * x, limits[place]) for x in values[place]]
            for place, scale in zip(factors, row, strict=False)
        }
        for row in scales
    ]
    return columns, scales[:, -1]


def _drawn(factors: list[float]) -> Array:
    """Return lognormal scales (samples, factors); each factor takes each of its quantiles once (Latin hypercube)."""
    generator, normal = np.random.default_rng(SEED), NormalDist()
    quantiles = np.array([normal.inv_cdf((k + 0.5) / SAMPLES) for k in range(SAMPLES)])
    quantiles /= normal.inv_cdf((1 + INSIDE) / 2)
    return np.stack([factor ** generator.permutation(quantiles) for factor in factors], axis=1)


def _fields(place: str) -> list[FieldInfo]:
    """Return the schema's fields from the robot down to a place such as ``water.strip.edge_lift``."""
    model: type[BaseModel] | None = Robot
    fields = []
    for name in place.split("."):
        assert model is not None
        fields.append(model.model_fields[name])
        model = nested_model(fields[-1].annotation)
    return fields


def _largest(place: str) -> float:
    """Return the upper limit that the schema sets for the number at a place; infinity without one."""
    return min((float(str(rule.le)) for rule in _fields(place)[-1].metadata if isinstance(rule, Le)), default=math.inf)
