"""Robots that users may bring, at random, and gaits for them; the same for the same seed.

A robot has 2 to 8 links, is 0.1 to 1.5 m long and floats: its mass is that of the water in elliptic sections as high as
the links and 0.3 to 1 times as wide. Coefficients span those of plates, cylinders and streamlined sections.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.yielding import reduced_inertia

LAWS = ("lumped", "strip", "elongated")


def random_robot(seed: int) -> ht.Robot:
    """A robot of the law `seed` modulo three."""
    random = np.random.default_rng(seed)

    def column(low: float, high: float) -> list[float]:
        return random.uniform(low, high, links).tolist()

    links = int(random.integers(2, 9))
    size = math.exp(random.uniform(math.log(0.1), math.log(1.5)))
    length = random.uniform(0.5, 1.5, links) * np.append(2.0, np.ones(links - 1))  # a head is longer
    length *= size / length.sum()
    height = size * random.uniform(0.08, 0.25) * random.uniform(0.5, 1.2, links)
    width = height * random.uniform(0.3, 1.0)
    lateral, mass = height * length, 1000 * math.pi / 4 * height * width * length
    groups = np.array_split(np.arange(1, links), int(random.integers(1, links)))
    document: dict[str, Any] = {
        "format": 1,
        "name": f"random-{seed}",
        "description": "a robot made at random",
        "body": {"length_m": float(length.sum()), "mass_kg": float(mass.sum())},
        "links": {
            "name": [f"L{i}" for i in range(links)],
            "length_m": length.tolist(),
            "com_m": (length * random.uniform(0.4, 0.6, links)).tolist(),
            "mass_kg": mass.tolist(),
            "lateral_area_m2": lateral.tolist(),
            "wetted_area_m2": (2.2 * lateral).tolist(),
        },
        "joints": [{"name": str(g), "links": joints.tolist()} for g, joints in enumerate(groups)],
        "model": {"water": LAWS[seed % 3], "joints": "ideal"},
        "water": {
            "density_kg_m3": 1000.0,
            "lumped": {"added_mass": column(0.1, 1.0), "friction": column(0.01, 0.1), "drag": column(0.5, 5.0)},
            "strip": {
                "added_mass_normal": column(0.5, 1.2),
                "added_mass_tangential": column(0.0, 0.1),
                "added_inertia": column(0.5, 1.2),
                "drag_normal": column(0.5, 2.5),
                "drag_tangential": column(0.003, 0.05),
                "cross_flow": bool(random.integers(2)),
                "tail_shedding": float(random.choice([0.0, 0.5, 1.0])),
            },
            "elongated": {
                "added_mass_normal": column(0.5, 1.2),
                "added_mass_edge": float(random.uniform(0.5, 2.0)),
                "drag_normal": column(0.5, 2.5),
                "drag_tangential": column(0.003, 0.05),
            },
        },
    }
    if seed % 2 == 0:  # a fin of its own
        document["water"]["strip"] |= {"edge_height_m": 1.3 * float(height[-1]), "edge_lift": 0.6}
    return parse(document)


def with_random_springs(robot: ht.Robot, frequency: float, seed: int) -> ht.Robot:
    """The robot with hinges at one to three of its last links, as many as leave it a driven joint.

    Each is of 0.05 to 30 times the stiffness that is in resonance at a frequency [Hz], and has a damping ratio of 0.001
    to 0.3; a third rest up to 10 deg off, a third harden, and a third have stops at 15 to 60 deg.
    """
    random, document, links = np.random.default_rng(seed), robot.document(), len(robot.links.name)
    at = range(links - int(random.integers(1, min(3, links - 2) + 1)), links)
    groups = [group | {"links": [link for link in group["links"] if link not in at]} for group in document["joints"]]
    document["joints"] = [group for group in groups if group["links"]]
    tables = [{"link": link, "stiffness_n_m_per_rad": 1.0} for link in at]
    inertia = reduced_inertia(parse(document | {"hinges": tables})).diagonal()
    ratio, zeta = np.exp(random.uniform(np.log([0.05, 0.001]), np.log([30.0, 0.3]), (len(at), 2))).T
    for table, stiffness, damping in zip(
        tables,
        (ratio * inertia * (2 * math.pi * frequency) ** 2).tolist(),
        (2 * zeta * np.sqrt(ratio) * inertia * 2 * math.pi * frequency).tolist(),
        strict=True,
    ):
        table |= {"stiffness_n_m_per_rad": stiffness, "damping_n_m_s_per_rad": damping}
        kind = random.integers(3, size=3)
        if kind[0] == 0:
            table["rest_deg"] = float(random.uniform(-10, 10))
        if kind[1] == 0:
            table["cubic_n_m_per_rad3"] = stiffness * float(random.uniform(0, 3))
        if kind[2] == 0:
            table["stop_deg"] = float(random.uniform(15, 60))
            table["stop_stiffness_n_m_per_rad"] = stiffness * float(random.uniform(3, 30))
    return parse(document | {"hinges": tables})


def random_gaits(robot: ht.Robot, count: int, seed: int) -> Gaits:
    """Gaits of 0.3 to 10 Hz. The even ones are such as one may try: 3 to 45 deg, lags of -60 to 150 deg from group to
    group, half of them with a bias; the odd ones are vehement, up to 170 deg, and spin many a robot about itself.
    """
    random, shape = np.random.default_rng(seed), (count, len(robot.joints))
    wild = (np.arange(count) % 2 == 1)[:, np.newaxis]
    frequency = np.exp(random.uniform(math.log(0.3), math.log(10.0), count))
    amplitude = np.radians(np.where(wild, random.uniform(30, 170, shape), random.uniform(3, 45, shape)))
    lag = np.radians(np.where(wild, random.uniform(-180, 180, shape), random.uniform(-60, 150, shape))).cumsum(axis=1)
    bias = np.radians(np.where(wild, random.uniform(-90, 90, shape), random.uniform(-40, 40, shape)))
    bias *= wild | (random.random((count, 1)) < 0.5)
    return Gaits(frequency, amplitude, lag - lag[:, :1], bias, shape=(count,))
