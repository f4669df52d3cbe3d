"""The parts of an MJCF file that leave the water to the engine plugin, hosts/mujoco_water.cpp."""

import math

import numpy as np

from hypertuna.description.robot import Robot, require
from hypertuna.export.link_water import balanced, moments, rotor
from hypertuna.export.xml import Element, add, written
from hypertuna.simulation.sea import space_columns
from hypertuna.swimming.model import model_columns

NAME = "hypertuna.water"  # of the plugin in MuJoCo
FIN_MASS = 1e-6  # mass of a fin as a fraction of the head's; in the core, fins have no mass


def add_plugin(root: Element, robot: Robot, *, free: bool) -> None:
    """Add the plugin, with the robot's columns in the format that hosts/mujoco_water.cpp reads."""
    columns = dict(model_columns(robot, {})) | (space_columns(robot) if free else {})
    columns["share"] = [0.0] * len(robot.links.name)  # MuJoCo simulates the joints
    columns["excess"] = [balanced(moments(robot, i))[1] for i in range(len(robot.links.name))]
    texts = []
    for name, values in columns.items():
        table = np.array(values, dtype=np.float64)
        table = table.reshape(len(table), -1) if table.ndim else table.reshape(1, 1)
        texts.append(f"{name} {table.shape[0]} {table.shape[1]} {written(table.ravel())}")
    plugin = add(add(root, "extension"), "plugin", plugin=NAME)
    instance = add(plugin, "instance", name="water")
    add(instance, "config", key="law", value=robot.model.water)
    add(instance, "config", key="columns", value="\n".join(texts))


def add_link(body: Element, robot: Robot, i: int, *, free: bool) -> None:
    """Add a link's own mass and, for the head in space, its fins as the first child bodies."""
    links = robot.links
    height = robot.spatial.com_height[i] if free and robot.spatial is not None else 0
    fin_share = 2 * FIN_MASS if free and i == 0 else 0
    inertia, _ = balanced(moments(robot, i))
    add(body, "plugin", instance="water")
    add(body, "inertial", pos=(links.com[i], 0, height), mass=(1 - fin_share) * links.mass[i], diaginertia=inertia)
    if fin_share:
        for side, name in ((-1, "port"), (1, "starboard")):
            _fin(body, robot, side, name)


def add_fin_drives(actuator: Element, robot: Robot, *, stiffness: float, damping: float) -> None:
    """Add the position actuators of the pectoral fins."""
    fins = require(robot.fins, "fins", robot)
    drive = {"kp": stiffness, "kv": damping, "timeconst": 1 / (2 * math.pi * fins.bandwidth)}
    for side in ("port", "starboard"):
        add(actuator, "position", name=f"pectoral-{side}", joint=f"pectoral-{side}", **drive)


def _fin(head: Element, robot: Robot, side: int, name: str) -> None:
    """Add a pectoral fin: positive angles raise its leading edge."""
    fins, mass = require(robot.fins, "fins", robot), FIN_MASS * robot.links.mass[0]
    body = add(head, "body", name=f"pectoral-{name}", pos=(fins.x, side * fins.y, fins.z))
    add(body, "plugin", instance="water")
    inertia = mass * fins.span**2
    add(body, "inertial", pos=(0, 0, 0), mass=mass, diaginertia=(inertia, inertia, inertia))
    add(body, "joint", name=f"pectoral-{name}", axis=(0, 1, 0), armature=rotor(robot))
