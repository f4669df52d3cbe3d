"""Laws that swimmers obey: Gazzola's line, and random fish of `hypertuna robot new` beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hypertuna import metrics
from hypertuna.arrays import Array
from hypertuna.description.drag import VISCOSITY
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits, named_gait

FISH, SEED = 100, 35  # number of random fish, and seed of their random numbers
LAMINAR = 1e4  # swimming number below which the boundary layer is laminar


def swimming_number(frequency: ArrayLike, excursion: ArrayLike, length: ArrayLike) -> Array:
    """Return the swimming number Sw = 2 pi f A L / nu [1], A the whole excursion of the tail tip [m]."""
    number: Array = 2 * math.pi * np.asarray(frequency) * np.asarray(excursion) * np.asarray(length) / VISCOSITY
    return number


def gazzola(swimming: ArrayLike) -> Array:
    """Return the Reynolds number of swimmers: 0.03 Sw^(4/3) laminar, 0.4 Sw turbulent (Gazzola et al. 2014).

    The turbulent branch is a Strouhal number of 1 / (2 pi 0.4) = 0.40 with the whole excursion.
    """
    sw = np.asarray(swimming, dtype=np.float64)
    reynolds: Array = np.where(sw < LAMINAR, 0.03 * sw ** (4 / 3), 0.4 * sw)
    return reynolds


@dataclass(frozen=True)
class Shoal:
    """Settled swims of many fish, (fish,) each."""

    length: Array  # m
    frequency: Array  # Hz
    speed: Array  # m/s; NaN where a gait does not settle
    excursion: Array  # m, peak to peak

    @property
    def swimming(self) -> Array:
        """Swimming numbers Sw, (fish,) [1]."""
        return swimming_number(self.frequency, self.excursion, self.length)

    @property
    def reynolds(self) -> Array:
        """Reynolds numbers U L / nu."""
        return self.speed * self.length / VISCOSITY

    @property
    def over_gazzola(self) -> Array:
        """Reynolds numbers over those of Gazzola's line."""
        return self.reynolds / gazzola(self.swimming)

    @property
    def strouhal(self) -> Array:
        """Strouhal numbers f A / U."""
        return metrics.strouhal(self.frequency, self.excursion, self.speed)

    @property
    def stride(self) -> Array:
        """Stride lengths U / (f L)."""
        return metrics.stride_length(self.speed, self.frequency, self.length)


def random_shoal(count: int = FISH, seed: int = SEED) -> Shoal:
    """Return the settled swims of random fish of `hypertuna robot new` at their default gaits.

    They have 2 to 8 links, are 0.1 to 1.5 m long, and weigh 10 to 40 kg/m^3 times the cube of their length.
    """
    random = np.random.default_rng(seed)
    links = random.integers(2, 9, count)
    length = np.exp(random.uniform(math.log(0.1), math.log(1.5), count))
    mass = length**3 * np.exp(random.uniform(math.log(10.0), math.log(40.0), count))
    rows = []
    for k in range(count):
        fish = parse(new_robot(f"random-{k}", links=int(links[k]), length=float(length[k]), mass=float(mass[k])))
        gait = named_gait(fish, "cruise")
        beat = settle(fish, Gaits.of([gait]))
        speed = float(beat["speed"][0]) if beat["status"][0] == 0 else math.nan
        rows.append((gait.frequency, speed, float(beat["tail_excursion"][0])))
    frequency, speeds, excursion = np.array(rows).T
    return Shoal(length, frequency, speeds, excursion)
