"""Export a robot as an SDF model for Gazebo: links with added mass, joints, buoyancy, and drag as far as possible."""

import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, robot_of
from hypertuna.export.link_water import LinkWater, balanced, links_water, lost_drag, moments
from hypertuna.export.outlook import FIN, SKIN, SOFT, edge_height, sections
from hypertuna.export.xml import Element, add, check_names, document, notes, written
from hypertuna.io.files import version

AXES = "xyzpqr"  # names of the axes in <fluid_added_mass>
MAX_RATE = 50.0  # rad/s: limit of the joints' position controllers
MAX_ANGLE = math.pi / 2  # rad: limit of each joint to both sides


@checked
def sdf(robot: Robot | str | Path) -> str:
    """Return a robot as an SDF 1.10 model, for Gazebo Garden or later with the DART engine.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.

    Returns
    -------
    str
        Content of the file: each link at its center of mass, with its inertia and the 6 x 6 added mass of the robot's
        water law; buoyancy by collision boxes of the links' volumes; drag as far as Gazebo's hydrodynamics has it.

    Raises
    ------
    InputError
        If a link has the name of a joint of the file, or of the world.

    Examples
    --------
    >>> import hypertuna as ht
    >>> "<fluid_added_mass>" in ht.sdf(ht.load("hypertuna").using(water="strip"))
    True
    """
    robot = robot_of(robot)
    root = ElementTree.Element("sdf", version="1.10")
    title = f"{robot.name}, written by hypertuna {version()} from {robot.file or 'a robot without a file'}."
    root.append(notes([title, *_facts(robot)], sdf_losses(robot)))
    model = add(root, "model", name=robot.name)
    fronts = np.concatenate([[0], np.cumsum(robot.links.length)])
    heights = _com_heights(robot)
    for i, water in enumerate(links_water(robot)):
        _link(model, robot, i, (fronts[i] + robot.links.com[i], 0, heights[i]), water)
    driven = {link for group in robot.joints for link in group.links}
    for i in range(1, len(robot.links.name)):
        _joint(model, robot, i, (-robot.links.com[i], 0, -heights[i]), turns=i in driven)
    check_names(robot, model, alike=True)
    for i, water in enumerate(links_water(robot)):
        _drag(model, robot, i, water)
    for i in sorted(driven):
        plugin = _plugin(model, "joint-position-controller", "JointPositionController")
        add(plugin, "joint_name", f"joint-{robot.links.name[i]}")
        add(plugin, "topic", f"bend/{robot.links.name[i]}")
        add(plugin, "use_velocity_commands", True)
        add(plugin, "cmd_max", MAX_RATE)
    return document(root)


def added_mass(robot: Robot, link: int, water: LinkWater) -> Array:
    """Return the added mass (6, 6) of a link about its center of mass, in the order of `AXES` [kg, kg m, kg m^2]."""
    matrix = np.zeros((6, 6))
    plane = water.inertia - np.diag([robot.links.mass[link]] * 2 + [robot.links.inertia[link]])
    matrix[np.ix_((0, 1, 5), (0, 1, 5))] = plane
    if robot.spatial is None:
        return matrix
    # As in the core, the planar part acts at the height of the center of buoyancy; heave, pitch and roll are added.
    spatial, length = robot.spatial, robot.links.length[link]
    matrix = _raised(matrix, spatial.buoyancy_height[link])
    width, height, arm = spatial.width[link], spatial.height[link], length / 2 - robot.links.com[link]
    heave = spatial.added_mass_vertical[link] * robot.water.density * math.pi / 4 * width**2 * length
    matrix[2, 2] += heave
    matrix[2, 4] -= heave * arm
    matrix[4, 2] -= heave * arm
    matrix[4, 4] += heave * (arm**2 + length**2 / 12)
    matrix[3, 3] += robot.water.density * math.pi / 128 * (height**2 - width**2) ** 2 * length
    return _raised(matrix, -spatial.com_height[link])


def _raised(matrix: Array, height: float) -> Array:
    """Shift an inertia matrix (6, 6) to a reference point that is `height` [m] lower."""
    shift = np.eye(6)
    shift[0, 4], shift[1, 3] = height, -height  # gives the upper point's velocity from the lower point's
    raised: Array = shift.T @ matrix @ shift
    return raised


def sdf_losses(robot: Robot) -> list[str]:
    """List, in words, the parts of the robot's model that the file lacks."""
    degrees = math.degrees(MAX_ANGLE)
    lacking = [
        "drive units with their limits, pumps, oil, battery, controller, and the sensors' noise",
        "gaits: bend = bias + amplitude sin(2 pi frequency t - phase) of each joint group is for you to command",
        f"joints beyond {MAX_RATE:g} rad/s and {degrees:g} deg: their position controllers and limits stop there",
        "surface, current, waves and bottom: they are the world's",
    ]
    for group in robot.joints:
        parts = zip(group.links, group.share, strict=True)
        shares = ", ".join(f"joint-{robot.links.name[link]} {written(part)}" for link, part in parts)
        lacking.append(f"coupling of joint group {group.name}: command each joint with its share of the bend: {shares}")
        if robot.model.joints == "bandwidth" and group.bandwidth is not None:
            lacking.append(f"first-order lag of joint group {group.name}: {written(group.bandwidth)} Hz")
        if group.phase_offset:
            offset = written(group.phase_offset)
            lacking.append(f"phase offset of joint group {group.name}: {offset} rad, to add to a gait's phase")
    if robot.fins is not None:
        lacking.append("pectoral fins: neither bodies, joints nor lift")
    if robot.spatial is not None:
        lacking.append("drag of each link's own pitch, and the tail fin's force up and down")
    if robot.model.water == "lumped":
        return lacking
    return [
        *lacking,
        "drag of a link that moves across and turns at once: Gazebo adds up the two alone",
        "the tail fin's force: its lift, and what cancels the backward pull of its added mass. Speeds are too low",
        *lost_drag(robot),
    ]


def _facts(robot: Robot) -> list[str]:
    """Return the lines of the comment that describes the file."""
    vertical = "" if robot.spatial else " No table [spatial]: no added mass, drag or buoyancy beyond the plane's."
    return [
        f"Water law {robot.model.water}. SI and radians. Nose at the model's origin, tail along +x, z up.{vertical}",
        "Each joint-LINK takes its angle in rad, counter-clockwise, from the topic bend/LINK.",
        "Where a link's moments of inertia are not those of a body (one exceeds the sum of the others), the excess",
        "stands in fluid_added_mass: the sum is the robot's.",
        "fluid_added_mass is the law's own, exactly; DART has it in the mass matrix. The world needs the systems",
        "Buoyancy (uniform_fluid_density as the robot's water) and Physics with DART.",
    ]


def _com_heights(robot: Robot) -> tuple[float, ...]:
    """Return the heights of the centers of mass above the joints' axis [m]."""
    return robot.spatial.com_height if robot.spatial is not None else (0.0,) * len(robot.links.name)


def _link(model: Element, robot: Robot, i: int, place: tuple[float, float, float], water: LinkWater) -> None:
    """Add a link, with its frame at its center of mass."""
    links = robot.links
    link = add(model, "link", name=links.name[i])
    add(link, "pose", (*place, 0, 0, 0))
    inertial = add(link, "inertial")
    add(inertial, "mass", links.mass[i])
    inertia, (body, excess) = add(inertial, "inertia"), balanced(moments(robot, i))
    for name, value in zip(
        ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), (body[0], 0, 0, body[1], 0, body[2]), strict=True
    ):
        add(inertia, name, value)
    element, matrix = add(inertial, "fluid_added_mass"), added_mass(robot, i, water) + np.diag([0, 0, 0, *excess])
    for a, row in enumerate(AXES):
        for b, column in enumerate(AXES[a:], start=a):
            add(element, row + column, matrix[a, b] + 0.0)
    _shape(link, robot, i)
    if i == 0:
        sensor = add(link, "sensor", name="imu", type="imu")
        add(sensor, "update_rate", 100)


def _shape(link: Element, robot: Robot, i: int) -> None:
    """Add a link's visual, and a collision box whose volume gives its buoyancy."""
    (height, width), length = (column[i] for column in sections(robot)), robot.links.length[i]
    middle, z = length / 2 - robot.links.com[i], -_com_heights(robot)[i]
    soft = any(i in group.links for group in robot.joints)
    last = i == len(robot.links.length) - 1
    visual = add(link, "visual", name="body")
    add(visual, "pose", (middle, 0, z, 0, 0, 0))
    add(add(add(visual, "geometry"), "ellipsoid"), "radii", (0.55 * length, width / 2, height / 2))
    _color(visual, SOFT if soft and not last else SKIN)
    if last and (edge := edge_height(robot)) > height:
        fin = add(link, "visual", name="fin")
        add(fin, "pose", (middle + length / 4, 0, z, 0, 0, 0))
        add(add(add(fin, "geometry"), "box"), "size", (length / 2, 0.003 * robot.body.length, edge))
        _color(fin, FIN)
    spatial = robot.spatial
    if spatial is None:
        volume, center = robot.links.mass[i] / robot.water.density, 0.0
    else:
        volume, center = spatial.volume[i], spatial.buoyancy_center[i] - robot.links.com[i]
        z += spatial.buoyancy_height[i]
    factor = math.sqrt(volume / (length * width * height))
    box = add(link, "collision", name="volume")
    add(box, "pose", (center, 0, z, 0, 0, 0))
    add(add(add(box, "geometry"), "box"), "size", (length, factor * width, factor * height))


def _color(visual: Element, color: str) -> None:
    """Set the color of a visual."""
    material = add(visual, "material")
    add(material, "ambient", color)
    add(material, "diffuse", color)


def _joint(model: Element, robot: Robot, i: int, place: tuple[float, float, float], *, turns: bool) -> None:
    """Add the joint between a link and the link ahead; it is fixed if no joint group turns it."""
    name, parent = robot.links.name[i], robot.links.name[i - 1]
    joint = add(model, "joint", name=f"joint-{name}", type="revolute" if turns else "fixed")
    add(joint, "pose", (*place, 0, 0, 0))
    add(joint, "parent", parent)
    add(joint, "child", name)
    if turns:
        axis = add(joint, "axis")
        add(axis, "xyz", (0, 0, 1))
        limit = add(axis, "limit")
        add(limit, "lower", -MAX_ANGLE)
        add(limit, "upper", MAX_ANGLE)


def _drag(model: Element, robot: Robot, i: int, water: LinkWater) -> None:
    """Add a link's drag along, across and vertical, at its center of mass, with Gazebo's signs."""
    plugin = _plugin(model, "hydrodynamics", "Hydrodynamics")
    add(plugin, "link_name", robot.links.name[i])
    add(plugin, "water_density", robot.water.density)
    add(plugin, "xUabsU", -water.along)
    add(plugin, "yVabsV", -water.across)
    add(plugin, "nRabsR", -water.turn)
    if robot.spatial is not None:
        spatial, length = robot.spatial, robot.links.length[i]
        half_density = robot.water.density / 2
        add(plugin, "zWabsW", -half_density * spatial.drag_vertical[i] * length * spatial.width[i])
        add(plugin, "kPabsP", -half_density * spatial.drag_roll[i] * length * spatial.height[i] ** 4 / 32)


def _plugin(model: Element, file: str, name: str) -> Element:
    """Add a plugin element that loads a system of Gazebo."""
    return add(model, "plugin", filename=f"gz-sim-{file}-system", name=f"gz::sim::systems::{name}")
