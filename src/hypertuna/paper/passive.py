"""Robots of the paper's last section, whose joint II is a passive hinge."""

from __future__ import annotations

from hypertuna.description.robot import Robot, parse

PLACES = {"front of joint II": 5, "middle of joint II": 6, "root of the fin": 7}  # place of the hinge -> link behind it
PLACE = "root of the fin"  # place of the hinge whose costs are compared with the active joint
ROOT = PLACES[PLACE]
LAWS = {"lumped": "lumped", "strip": "strips"}  # water law -> its label
KINDS = ("active", "passive")  # joint II driven, or on a spring
PUMP = "piston pump"  # name of the pumps' servo
RELAXATION = 0.005  # s, damping over stiffness of a hinge of silicone: the relaxation time of HyperTuna's materials
AT_SEA = ("guidance", "firmware", "fins", "spatial")  # tables with values for two joints, used at sea only


def passive_robot(robot: Robot, stiffness: float, *, relaxation: float = RELAXATION, link: int = ROOT) -> Robot:
    """Return a robot whose last joint group is a passive hinge [N m/rad] at the front of a link.

    Its damping is the stiffness times a relaxation time [s]. The pumps of that joint are gone, its mass stays.
    """
    document = {key: part for key, part in robot.document().items() if key not in (*AT_SEA, "gaits", "uncertainty")}
    groups = len(document["joints"])
    document["joints"] = document["joints"][:-1]
    bounds = document["gait_bounds"]
    document["gait_bounds"] = bounds | {key: bounds[key][:-1] for key in ("amplitude_deg", "phase_deg")}
    document["servos"] = [
        one | {"count": one["count"] * (groups - 1) // groups} if one["drives"] == PUMP else one
        for one in document["servos"]
    ]
    spring = {"stiffness_n_m_per_rad": stiffness, "damping_n_m_s_per_rad": relaxation * stiffness}
    return parse(document | {"hinge": {"link": link} | spring, "sources": {}}, file=robot.file)
