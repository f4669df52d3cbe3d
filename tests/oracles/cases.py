"""Random chains, coefficients and states, as a robot file would give them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from oracles.planar import Chain, Joints, Lumped, Real, Strip, elongated_of, strip_of

DENSITY = 1000.0


@dataclass(frozen=True)
class Case:
    """One chain of n links with both water laws' coefficients (n,), named as in a robot file, and one state of motion.

    ``twist`` (3,): velocity u, v [m/s] and turning rate r [rad/s] of the head frame (at the nose) in its own axes.
    """

    chain: Chain
    lateral_area: Real
    wetted_area: Real
    lumped: dict[str, Real]
    strip: dict[str, Real | float | bool]
    joints: Joints
    twist: Real
    density: float = DENSITY

    @property
    def state(self) -> Real:
        """Nose at the origin, head along x: there the twist is the world velocity (6,)."""
        return np.concatenate([np.zeros(3), self.twist])

    def lumped_water(self, areas: str) -> Lumped:
        """``consistent``: friction on the wetted area, drag on the lateral one; ``as-printed``: exchanged."""
        pair = (self.wetted_area, self.lateral_area)
        friction_area, drag_area = pair if areas == "consistent" else pair[::-1]
        return Lumped(self.density, friction_area=friction_area, drag_area=drag_area, **self.lumped)

    def strip_water(self) -> Strip:
        return strip_of(self.chain, self.density, self.lateral_area, self.wetted_area, **self.strip)

    @property
    def elongated(self) -> dict[str, Real | float]:
        """Coefficients of elongated-body theory: those of the strips that it has, and an edge of a depth of its own."""
        shared = {name: self.strip[name] for name in ("added_mass_normal", "drag_normal", "drag_tangential")}
        return shared | {"added_mass_edge": 2.0 * self.strip["tail_shedding"]}

    def elongated_water(self) -> Strip:
        return elongated_of(self.chain, self.density, self.lateral_area, self.wetted_area, **self.elongated)

    def without_drag(self) -> Case:
        """Only the added mass of the strip law left."""
        drag = {name: value for name, value in self.strip.items() if not name.startswith("added")}
        nothing = {name: 0 * value for name, value in drag.items()}  # False and 0.0 for the options
        return replace(self, strip=self.strip | nothing)


def random_case(rng: np.random.Generator, links: int) -> Case:
    """Sizes, coefficients and motions as swimming robots have them, up to several beats a second."""
    n = links
    length = rng.uniform(0.02, 0.3, n)
    mass = rng.uniform(0.02, 2.0, n)
    chain = Chain(length, length * rng.uniform(0.2, 0.8, n), mass, mass * length**2 / 12 * rng.uniform(0.5, 2.0, n))
    lateral_area = length * rng.uniform(0.03, 0.2, n)

    def moving(scale: float) -> Real:
        return np.concatenate([[0.0], rng.uniform(-scale, scale, n - 1)])

    return Case(
        chain,
        lateral_area,
        lateral_area * rng.uniform(1.5, 3.0, n),
        {"added_mass": rng.uniform(0, 1, n), "friction": rng.uniform(0, 1, n), "drag": rng.uniform(0, 30, n)},
        {
            "added_mass_normal": rng.uniform(0.2, 1.5, n),
            "added_mass_tangential": rng.uniform(0, 0.3, n),
            "added_inertia": rng.uniform(0.5, 1.5, n),
            "drag_normal": rng.uniform(0, 3, n),
            "drag_tangential": rng.uniform(0, 0.1, n),
            "linear_normal": rng.uniform(0, 1, n),
            "linear_tangential": rng.uniform(0, 1, n),
            "cross_flow": bool(rng.integers(2)),
            "tail_shedding": float(rng.uniform(0, 1)),
            "drag_beating": rng.uniform(0, 4, n),
            "blunt_area": rng.uniform(0, 0.01, n),
            "edge_height": float(rng.choice([0.0, 0.15])),
            "edge_lift": float(rng.uniform(0.1, 1)),
            "edge_aspect": float(rng.choice([0.0, 1.0]) * rng.uniform(0.5, 8)),
            "edge_added_mass": float(rng.uniform(0.3, 1.2)),
            "edge_suction": float(rng.uniform(0, 1)),
        },
        Joints(moving(0.7), moving(10.0), moving(300.0)),
        rng.uniform(-1, 1, 3) * np.array([1.0, 1.0, 5.0]),
    )
