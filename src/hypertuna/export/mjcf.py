"""Export a robot as an MJCF file for MuJoCo, with MuJoCo's own fluid forces or with this project's engine plugin.

MuJoCo computes a body's drag from the box with the body's inertia: half sizes r give a force 2 rho r_y r_z v |v| along
x and 2 rho r_x r_z v |v| across (y). So each link gets bodies of water whose boxes have the link's drag: a plate
without thickness in y, which has drag only across, and one which has drag only along. The taller the first plate (z),
the less it resists rotation (rho/2 r_z r_x^4). The plates also carry the isotropic part of the added mass.

A thickness follows from a difference of moments of inertia. Those of the plates are whole multiples of a power of two,
so the difference is exactly zero even in single precision.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, require, robot_of
from hypertuna.description.schema.actuator import Hinge
from hypertuna.errors import InputError
from hypertuna.export.link_water import LinkWater, links_water, lost_drag, rotor
from hypertuna.export.mjcf_plugin import add_fin_drives, add_link, add_plugin
from hypertuna.export.outlook import pieces
from hypertuna.export.xml import Element, add, check_names, document, notes, written
from hypertuna.io.files import version

TIMESTEP = 5e-4  # s, for the fourth-order Runge-Kutta integrator
START = 1.0  # m: initial depth of the nose, for motion in space
SERVO = 500.0  # rad/s: natural frequency of the position servos, which delay all joints by 2 zeta / SERVO = 2.8 ms
DAMPING = math.sqrt(0.5)  # damping ratio zeta of the servos, for a maximally flat response
# Fractions of a link's mass for its plates, tried in order: the first that leaves the rod enough inertia.
WATER_FRACTIONS = (0.5, 0.2, 0.05, 0.01)
ALONG_MASS = 0.25  # fraction of the plates' mass in those with drag along the link
ROD = 1e-9  # moment of inertia of the rod about its own axis, as a fraction of that about the vertical
MAX_HALF_LENGTH = 0.04  # largest r_x of plates with drag across, as a fraction of the body's length
MIN_DIFFERENCE = 1e-15  # kg m^2: smallest difference of moments of inertia in MuJoCo's boxes (mjMINVAL)
MIN_DIFFERENCE_MJX = 1e-12  # kg m^2: smallest difference of moments of inertia in MJX's boxes
NOTED_EXCESS = 1e-3  # relative excess of the drag along the robot above which the file has a note
INERTIA_BITS = 22  # bits of the moments of inertia; two more of single precision remain for sums
# Gauss-Legendre points on [-1, 1] and their weights, at which the drag across a link acts
POINTS = (-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526)
WEIGHTS = (0.1739274225687269, 0.3260725774312731, 0.3260725774312731, 0.1739274225687269)


@checked
def mjcf(robot: Robot | str | Path, *, plugin: bool = False, free: bool = False) -> str:
    """Return a robot as an MJCF model, for MuJoCo 3.3 or later.

    Without the plugin it moves in the plane, by MuJoCo's own fluid forces. The joints follow their commands
    against any load of the water, with ``joints = "bandwidth"`` in ``[model]`` after the description's first-order lag.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    plugin : bool
        Leave the water to the engine plugin: the whole water law, added mass in the mass matrix.
    free : bool
        Move in space, with weight, buoyancy and pectoral fins, instead of in the plane; with the plugin only.

    Returns
    -------
    str
        Content of the file. One position actuator for each joint group, whose control is its bend [rad], last a motor
        [N m] for each hinge that a moment drives, sensors, and each named gait as a custom numeric field: frequency
        [Hz], then amplitudes, phases and biases [rad].

    Raises
    ------
    InputError
        If `free` is given without the plugin, the robot lacks what motion in space needs, a link has no drag and the
        plugin is not to give it, or a link or joint group has the name of another part of the file.

    Examples
    --------
    >>> import hypertuna as ht
    >>> text = ht.mjcf(ht.load("hypertuna").using(joints="ideal"))
    >>> '<position name="II"' in text
    True
    """
    robot = robot_of(robot)
    if free and not plugin:
        rule = "must come with the engine plugin, since the boxes of water would keep the robot from rolling"
        raise InputError(rule, key="--free", fix="add --plugin, in Python plugin=True")
    if free:
        require(robot.spatial, "spatial", robot)
        require(robot.fins, "fins", robot)
    root = ElementTree.Element("mujoco", model=robot.name)
    title = f"{robot.name}, written by hypertuna {version()} from {robot.file or 'a robot without a file'}."
    option = {"timestep": TIMESTEP, "integrator": "RK4", "density": 0.0 if plugin else robot.water.density}
    facts = [title, *_facts(robot, option, free=free)]
    root.append(notes(facts, losses(robot, plugin=plugin, free=free)))
    add(root, "compiler", angle="radian", inertiafromgeom="false", autolimits="true")
    add(root, "option", **option, gravity=(0, 0, -9.81))
    _look(root, robot)
    if plugin:
        add_plugin(root, robot, free=free)
    _bodies(_world(root, robot, free=free), robot, plugin=plugin, free=free)
    _drives(root, robot, free=free)
    _sensors(root, robot)
    custom = add(root, "custom")
    for name, gait in robot.gaits.items():
        offsets = [group.phase_offset for group in robot.joints]
        numbers = (gait.frequency, *gait.amplitude, *np.add(gait.phase, offsets), *gait.bias)
        add(custom, "numeric", name=name, data=numbers)
    check_names(robot, root.iter(), alike=False)
    return document(root)


def _facts(robot: Robot, option: Mapping[str, Any], *, free: bool) -> list[str]:
    """Return the lines of the comment that describes the file."""
    joints = "ideal" if robot.model.joints == "ideal" else "first-order lags of the description's bandwidths"
    return [
        f"Water law {robot.model.water}; joints: {joints}; motion in {'space' if free else 'the plane'}.",
        "SI and radians. Nose at the origin, tail along +x, y to starboard, z up; bends counter-clockwise.",
        "Each actuator sets the bend of a joint group; its servo is stiff and its rotor heavy (armature), so that the",
        "joints go as commanded. An actuator's force contains the rotor's inertia: it is not the joint's torque.",
        "Each numeric field of <custom> is a gait: frequency in Hz, amplitudes, phases, biases in rad, for",
        "bend = bias + amplitude sin(2 pi frequency t - phase). The phases contain the joints' phase offsets.",
        *(
            f"The control of motor moment-{robot.links.name[hinge.link]} is a moment in N m: {written(hinge.moment)} "
            f"sin(2 pi frequency t - {written(hinge.moment_phase)}) in any gait."
            for hinge in robot.hinges
            if hinge.moment
        ),
        "In another scene (MjSpec.attach) the options are those of the scene. It must have these, or the robot swims",
        f"otherwise: {', '.join(f'{name} {written(value)}' for name, value in option.items())}.",
    ]


def losses(robot: Robot, *, plugin: bool, free: bool) -> list[str]:
    """List, in words, the parts of the robot's model that the file lacks."""
    law = robot.model.water
    lacking = [
        "drive units with their limits, pumps, oil, battery, controller, and the sensors' noise",
        "current, waves and bottom",
        f"exact timing: the servos turn all joints {2000 * DAMPING / SERVO:.1f} ms late",
    ]
    if any(hinge.stop is not None for hinge in robot.hinges):
        lacking.append("stiffness and damping of the hinges' stops: MuJoCo's own limits of joints stand there")
    if any(hinge.cubic for hinge in robot.hinges):
        lacking.append("MuJoCo before 4, whose springs have no cubic term")
    if plugin:
        lacking.append("MJX and MuJoCo Warp, which run no engine plugins")
    if free:
        return [*lacking, "the pectoral servos' limit of rate"]
    drawn_only = " (they are drawn only)" if robot.fins is not None else ""
    lacking.append(f"motion out of the plane: depth, roll, pitch, pectoral fins{drawn_only}")
    if plugin:
        return lacking
    turning, along = excess(robot)
    detail = f"the boxes of water add {100 * turning:.2g} % to the drag of turning in place"
    lacking.append(f"rotation as free as in the water law: {detail}")
    if along > NOTED_EXCESS:
        detail = f"MuJoCo's smallest boxes add {100 * along:.2g} % to the drag along the robot"
        lacking.append(f"friction as low as in the water law: {detail}")
    detail = f"its smallest boxes add {100 * (excess(robot, MIN_DIFFERENCE_MJX)[1] - along):.2g} % along the robot"
    lacking.append(f"the same drag in MJX: {detail}; MuJoCo Warp agrees with MuJoCo")
    if law == "lumped":
        return lacking
    lacking.append(f"added mass across the links: the {law} law's is not alike in all directions")
    lacking.append("the tail fin's force, most of the thrust: without the plugin, speeds are too low")
    return lacking + lost_drag(robot)


def _world(root: Element, robot: Robot, *, free: bool) -> Element:
    """Add the world with a light and a visible floor, and return it."""
    world = add(root, "worldbody")
    floor = -robot.body.length - (START if free else 0)
    add(world, "light", pos=(0, 0, 4), dir=(0, 0, -1), castshadow=False)
    add(world, "geom", type="plane", size=(0, 0, 1), pos=(0, 0, floor), material="floor", contype=0, conaffinity=0)
    return world


def _bodies(world: Element, robot: Robot, *, plugin: bool, free: bool) -> None:
    """Add the links, each as a child body of the link ahead, with joints, masses and visible pieces."""
    links, waters = robot.links, links_water(robot)
    driven = {link for group in robot.joints for link in group.links}
    hinges = {hinge.link: hinge for hinge in robot.hinges}
    parent = world
    for i, name in enumerate(links.name):
        place = (links.length[i - 1], 0, 0) if i else (0, 0, -START if free else 0)
        body = add(parent, "body", name=name, pos=place)
        if i == 0:
            _head(body, robot, free=free)
        elif i in driven:
            add(body, "joint", name=f"joint-{name}", axis=(0, 0, 1), armature=rotor(robot))
        if i in hinges:
            _hinge(body, hinges[i], name)
        if plugin:
            add_link(body, robot, i, free=free)
        else:
            _link(body, robot, i, waters[i])
        parent = body
    bodies = {body.get("name"): body for body in world.iter("body")}
    for piece in pieces(robot):
        geom = {"type": "mesh", "mesh": piece.name, "rgba": piece.color, "contype": 0, "conaffinity": 0}
        if piece.name in bodies and piece.name not in links.name:  # a pectoral fin that can turn
            add(bodies[piece.name], "geom", **geom)
        else:
            add(bodies[links.name[piece.link]], "geom", **geom, pos=piece.place)


def _hinge(body: Element, hinge: Hinge, name: str) -> None:
    """Add the passive hinge at the front of a link, in series with its joint."""
    spring = (hinge.stiffness, 0.0, hinge.cubic) if hinge.cubic else hinge.stiffness
    stops = {} if hinge.stop is None else {"range": (-hinge.stop, hinge.stop)}
    attributes = {"axis": (0, 0, 1), "stiffness": spring, "springref": hinge.rest, "damping": hinge.damping}
    add(body, "joint", name=f"hinge-{name}", **attributes, **stops)


def _head(head: Element, robot: Robot, *, free: bool) -> None:
    """Add the joints by which the head moves freely, its sites and a camera."""
    if free:
        add(head, "freejoint", name="head")
    else:
        for name, kind, axis in (("x", "slide", (1, 0, 0)), ("y", "slide", (0, 1, 0)), ("heading", "hinge", (0, 0, 1))):
            add(head, "joint", name=name, type=kind, axis=axis)
    size, com = robot.body.length, robot.links.com[0]
    add(
        head,
        "camera",
        name="beside",
        mode="track",
        pos=(0.5 * size, -1.1 * size, 0.6 * size),
        xyaxes=(1, 0, 0, 0, 0.5, 0.85),
    )
    add(head, "site", name="nose", size=0.004)
    add(head, "site", name="imu", pos=(com, 0, 0), size=0.004)


@dataclass(frozen=True)
class _Part:
    """A rod or plate of a link."""

    at: float  # place behind the link's front joint [m]
    mass: float  # [kg]
    inertia: tuple[float, float, float]  # moments of inertia about x, y, z [kg m^2]

    def half_sizes(self, smallest: float) -> Array:
        """Return the half sizes (3,) [m] of the box that MuJoCo computes; smallest: its least difference of inertia."""
        x, y, z = self.inertia
        return np.sqrt(1.5 / self.mass * np.maximum(smallest, [y + z - x, x + z - y, x + y - z]))


def _link(body: Element, robot: Robot, i: int, water: LinkWater) -> None:
    """Add a link's own body, a thin rod without drag, and its plates of water, which have the drag."""
    rod, *plates = _parts(robot, i, water)
    add(body, "inertial", pos=(rod.at, 0, 0), mass=rod.mass, diaginertia=rod.inertia)
    for k, plate in enumerate(plates):
        dragged = add(body, "body", name=f"{robot.links.name[i]}-water-{k}", pos=(plate.at, 0, 0))
        add(dragged, "inertial", pos=(0, 0, 0), mass=plate.mass, diaginertia=plate.inertia)


def _parts(robot: Robot, i: int, water: LinkWater) -> list[_Part]:
    """Return the rod and the plates of a link; together they have its mass and inertia, with isotropic added mass."""
    isotropic = float(min(water.inertia[0, 0], water.inertia[1, 1]))
    com, turn = robot.links.com[i], float(water.inertia[2, 2])
    for water_part in WATER_FRACTIONS:
        mass = (1 - water_part) * robot.links.mass[i]
        plates = [*_plates(robot, i, water, isotropic - mass)]
        place = (isotropic * com - sum(plate.mass * plate.at for plate in plates)) / mass
        rod_inertia = turn + isotropic * com**2 - mass * place**2
        rod_inertia -= sum(plate.mass * plate.at**2 + plate.inertia[2] for plate in plates)
        if rod_inertia > turn / 2:
            break
    return [_Part(place, mass, (ROD * rod_inertia, rod_inertia, rod_inertia)), *plates]


def _points(robot: Robot, i: int) -> list[tuple[float, float]]:
    """Return where drag acts on a link: places behind its front joint [m], and each one's fraction of the drag."""
    if robot.model.water == "lumped":
        return [(robot.links.com[i], 1.0)]
    return [(robot.links.length[i] / 2 * (1 + point), weight) for point, weight in zip(POINTS, WEIGHTS, strict=True)]


def _plates(robot: Robot, i: int, water: LinkWater, wet: float) -> Iterator[_Part]:
    """Yield the plates of a link, which have a mass `wet` [kg] together."""
    if not water.along or not water.across:
        rule, fix = "must drag each link along and across, since boxes of water do", "give drag to it, or add --plugin"
        value = f"0 {'across' if water.along else 'along'} link {robot.links.name[i]}"
        raise InputError(rule, file=robot.file or None, key=f"water.{robot.model.water}", value=value, fix=fix)
    half_width = min(MAX_HALF_LENGTH * robot.body.length, math.sqrt(float(water.inertia[2, 2]) / wet))
    for place, share in _points(robot, i):
        along, across = (share * drag / (2 * robot.water.density) for drag in (water.along, water.across))  # m^2
        about_z, about_x, about_y = _plate_inertia((1 - ALONG_MASS) * share * wet, half_width, across)
        plate = _Part(place, (1 - ALONG_MASS) * share * wet, (about_x, about_y, about_z))
        yield plate
        _, y, z = plate.half_sizes(MIN_DIFFERENCE)
        if along > y * z:
            mass, area = ALONG_MASS * share * wet, along - y * z
            about_z, about_y, about_x = _plate_inertia(mass, math.sqrt(area), area)
            yield _Part(place, mass, (about_x, about_y, about_z))


def _plate_inertia(mass: float, half: float, area: float) -> tuple[float, float, float]:
    """Return a plate's moments of inertia about the axes along its height, its width and its normal [kg m^2].

    half: half width [m]; area: half width times half height [m^2]. Sums and differences are exact in single precision.
    """
    height = area / half
    unit = 2.0 ** (math.frexp(mass / 3 * (half**2 + height**2))[1] - INERTIA_BITS)
    about_height = unit * max(1, round(mass / 3 * half**2 / unit))
    height = area / math.sqrt(3 * about_height / mass)
    about_width = unit * max(1, round(mass / 3 * height**2 / unit))
    return about_height, about_width, about_height + about_width


def excess(robot: Robot, smallest: float = MIN_DIFFERENCE) -> tuple[float, float]:
    """Return the relative excess of the boxes' drag over the straight robot's: when turning in place, and along it.

    The robot turns about its center of mass. smallest: the engine's least difference of inertia [kg m^2].
    """
    links, turning, along, resisted, dragged = robot.links, 0.0, 0.0, 0.0, 0.0
    fronts = np.cumsum([0, *links.length[:-1]])
    com = np.dot(links.mass, fronts + links.com) / np.sum(links.mass)
    for i, water in enumerate(links_water(robot)):
        for place, share in _points(robot, i):
            turning += share * water.across / robot.water.density * abs(fronts[i] + place - com) ** 3
        along += water.along / (2 * robot.water.density)
        for plate in _parts(robot, i, water)[1:]:
            x, y, z = plate.half_sizes(smallest)
            resisted += z / 2 * (x**4 + y**4)
            dragged += y * z
    return float(resisted / turning), float(dragged / along - 1)


def _look(root: Element, robot: Robot) -> None:
    """Add light, colors and the meshes of the body's pieces."""
    visual = add(root, "visual")
    add(visual, "headlight", ambient=(0.4, 0.4, 0.4), diffuse=(0.5, 0.5, 0.5))
    add(visual, "global", offwidth=1280, offheight=720)
    add(root, "statistic", extent=robot.body.length, center=(robot.body.length / 2, 0, 0))
    asset = add(root, "asset")
    add(
        asset,
        "texture",
        type="skybox",
        builtin="gradient",
        rgb1=(0.75, 0.88, 0.95),
        rgb2=(0.2, 0.45, 0.6),
        width=64,
        height=64,
    )
    add(
        asset,
        "texture",
        name="floor",
        type="2d",
        builtin="checker",
        rgb1=(0.55, 0.75, 0.83),
        rgb2=(0.6, 0.8, 0.87),
        width=64,
        height=64,
    )
    add(asset, "material", name="floor", texture="floor", texrepeat=(2, 2), texuniform="true")
    for piece in pieces(robot):
        add(asset, "mesh", name=piece.name, vertex=tuple(np.round(piece.points, 5).ravel()))


def _drives(root: Element, robot: Robot, *, free: bool) -> None:
    """Add for each joint group a tendon with its bend, a position actuator on the tendon, and couplings of joints."""
    inertia = rotor(robot)
    equality, tendon, actuator = (add(root, tag) for tag in ("equality", "tendon", "actuator"))
    for group in robot.joints:
        joints = [f"joint-{robot.links.name[link]}" for link in group.links]
        squares = sum(part * part for part in group.share)
        bend = add(tendon, "fixed", name=group.name)
        for joint, part in zip(joints, group.share, strict=True):
            add(bend, "joint", joint=joint, coef=part / squares)
        lead, lead_share = max(zip(joints, group.share, strict=True), key=lambda pair: abs(pair[1]))  # a share may be 0
        for joint, part in zip(joints, group.share, strict=True):
            if joint != lead:
                add(equality, "joint", joint1=joint, joint2=lead, polycoef=(0, part / lead_share, 0, 0, 0))
        lag = {}
        if robot.model.joints == "bandwidth" and group.bandwidth is not None:
            lag = {"timeconst": 1 / (2 * math.pi * group.bandwidth)}
        stiffness, damping = inertia * squares * SERVO**2, 2 * DAMPING * inertia * squares * SERVO
        add(actuator, "position", name=group.name, tendon=group.name, kp=stiffness, kv=damping, **lag)
    if free:
        add_fin_drives(actuator, robot, stiffness=inertia * SERVO**2, damping=2 * DAMPING * inertia * SERVO)
    for name in (robot.links.name[hinge.link] for hinge in robot.hinges if hinge.moment):
        add(actuator, "motor", name=f"moment-{name}", joint=f"hinge-{name}")


def _sensors(root: Element, robot: Robot) -> None:
    """Add sensors: the IMU, position and attitude of the nose, and the bends."""
    sensor = add(root, "sensor")
    add(sensor, "gyro", name="rate", site="imu")
    add(sensor, "accelerometer", name="acceleration", site="imu")
    add(sensor, "framepos", name="position", objtype="site", objname="nose")  # depth is -z
    add(sensor, "framequat", name="attitude", objtype="site", objname="nose")
    add(sensor, "velocimeter", name="velocity", site="nose")
    for group in robot.joints:
        add(sensor, "tendonpos", name=f"bend-{group.name}", tendon=group.name)
