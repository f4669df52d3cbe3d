"""Geometry of a soft joint for finite elements: a tapered elliptical body, channels for the drive units, end plates.

Axes are as in docs/conventions.md: x along the joint from the connector (0) toward the tail; y to the left, toward
which the left drive units bend the joint; z up. The body is symmetric about the plane z = 0, in which it bends.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import drive_unit, joint_group
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.fe.extra import need_fe, need_pictures
from hypertuna.io.files import scratch, write_atomically

MM = 1e3  # mm per m: drawings are in mm, the default of STEP
WALL = 0.0005  # m, least thickness of matrix between hoses, and between hose and water
SAME = 1e-4  # mm, tolerance of coordinates in a drawing, since OCC pads its bounding boxes

DRAWINGS = (".step", ".stp", ".stl")  # allowed suffixes of drawing files

# Names of the faces of the half body, a regular expression for each kind.
FACES = {
    "fixed": "fixed",
    "symmetry": "symmetry",
    "outer": "outer",
    "tip": "tip",
    "axis": "axis",
    "walls": "wall_.*",
    "left": "wall_left|cap_left",
    "right": "wall_right|cap_right",
}


@dataclass(frozen=True)
class Channel:
    """The straight channel of a drive unit along x: side, and position of its center in the section."""

    side: int  # 0 for left, at positive y; 1 for right
    y: float  # position of the channel's axis [m]
    z: float  # position of the channel's axis [m]


@dataclass(frozen=True)
class JointBody:
    """The soft body of a joint: semi-axes of its sections, channels, end plates, and the strip on its axis."""

    name: str  # name of the joint group
    stations: Array  # (k,) places of sections from 0 to the length [m]; semi-axes are linear in between
    semi_major: Array  # (k,) half height of the elliptical sections, along z [m]
    semi_minor: Array  # (k,) half width of the elliptical sections, along y [m]
    radius: float  # outer radius of the hoses [m]
    channels: tuple[Channel, ...]  # channels of both halves: left side, then right side, each from bottom to top
    plate: float  # thickness of the plates at both ends [m]
    axis: float  # width of the strip that holds the axis, in the neutral layer [m]; 0 for none

    @property
    def length(self) -> float:
        """Length of the neutral layer [m]."""
        return float(self.stations[-1])

    @property
    def upper(self) -> tuple[Channel, ...]:
        """Channels of the half body with z >= 0; a channel at z = 0 is cut in half."""
        return tuple(channel for channel in self.channels if channel.z > -SAME / MM)

    @property
    def volume(self) -> float:
        """Volume of the matrix without the channels, in both halves [m^3]."""
        a, b, dx = self.semi_major, self.semi_minor, np.diff(self.stations)
        cone = a[:-1] * b[:-1] + a[1:] * b[1:] + (a[:-1] * b[1:] + a[1:] * b[:-1]) / 2
        return float(math.pi / 3 * (cone * dx).sum()) - len(self.channels) * math.pi * self.radius**2 * self.length

    def record(self) -> dict[str, Any]:
        """Return the sizes of the body by names with units."""
        return {
            "joint": self.name,
            "station_mm": MM * self.stations,
            "semi_major_mm": MM * self.semi_major,
            "semi_minor_mm": MM * self.semi_minor,
            "channel_radius_mm": MM * self.radius,
            "channels": [{"side": c.side, "y_mm": MM * c.y, "z_mm": MM * c.z} for c in self.channels],
            "plate_mm": MM * self.plate,
            "axis_width_mm": MM * self.axis,
            "matrix_volume_mm3": MM**3 * self.volume,
        }

    @property
    def symmetry_area(self) -> float:
        """Area of matrix and tip plate in the plane z = 0 [m^2]."""
        sides = np.trapezoid(2 * self.semi_minor, self.stations) + 2 * float(self.semi_minor[-1]) * self.plate
        chords = [2 * math.sqrt(max(0.0, self.radius**2 - channel.z**2)) for channel in self.channels]
        return float(sides) - sum(chords) * self.length


def joint_body(robot: Robot, joint: str | int) -> JointBody:
    """Return the soft body of a joint with its channels; InputError if the channels do not fit.

    The semi-axes of ``[joints.actuator]`` apply at the middle of their segments; elsewhere the body tapers linearly.
    """
    unit, (group, actuator) = drive_unit(robot), joint_group(robot, joint)
    lengths = np.array(actuator.segment_length)
    stations = np.concatenate([[0.0], np.cumsum(lengths)])
    middles = stations[:-1] + lengths / 2
    semi_major, semi_minor = (
        _taper(stations, middles, np.array(a)) for a in (actuator.semi_major, actuator.semi_minor)
    )
    file, key = robot.file or None, f"[joints.actuator] of {group.name}"
    narrowest = float(semi_major.min()), float(semi_minor.min())
    if min(narrowest) <= 0:
        raise InputError("must leave a section at both ends", file=file, key=key, fix="give half axes that taper less")
    count, radius = cast(int, group.drive_units), unit.outer_diameter / 2
    levers = list(actuator.levers)
    spacing = actuator.spacing or _widest(narrowest, max(levers), count, radius)
    heights = spacing * (np.arange(count) - (count - 1) / 2)
    if min(levers) < radius + WALL / 2:
        rule, fix = "must keep the hoses of both sides apart", "give a longer lever or thinner hoses"
        value = f"{1e3 * min(levers):.3g} mm for hoses of {2e3 * radius:.3g} mm"
        raise InputError(rule, file=file, key=f"{key}: lever_m", value=value, fix=fix)
    if count > 1 and spacing < 2 * radius + WALL:
        value = f"{1e3 * spacing:.3g} mm for hoses of {2e3 * radius:.3g} mm"
        fix = "give thinner hoses, a shorter lever or fewer drive units"
        raise InputError("must keep neighboring hoses apart", file=file, key=f"{key}: spacing_m", value=value, fix=fix)
    wall = _clearance(narrowest, max(levers), float(heights[-1])) - radius
    if wall < WALL:
        value = f"{1e3 * wall:.2g} mm at the narrowest section"
        rule = f"must leave {1e3 * WALL:g} mm of matrix around the outermost hoses"
        fix = "give a smaller spacing_m, a shorter lever or thinner hoses"
        raise InputError(rule, file=file, key=key, value=value, fix=fix)
    channels = tuple(Channel(s, (1 - 2 * s) * levers[s], float(z)) for s in (0, 1) for z in heights)
    axis_width = actuator.axis_width if actuator.axis_stiffness else 0.0
    if axis_width > 2 * (narrowest[0] - WALL):
        rule, value = "must leave matrix above and below", f"{1e3 * axis_width:.3g} mm in {2e3 * narrowest[0]:.3g} mm"
        raise InputError(rule, file=file, key=f"{key}: axis_width_m", value=value, fix="give a smaller axis_width_m")
    return JointBody(group.name, stations, semi_major, semi_minor, radius, channels, actuator.plate, axis_width)


def _taper(stations: Array, middles: Array, values: Array) -> Array:
    """Return semi-axes at the ends of segments from those at the segments' middles; exact for a linear taper."""
    if len(values) == 1:
        return np.repeat(values, 2)
    inner = np.interp(stations, middles, values)
    first, last = (np.diff(values) / np.diff(middles))[[0, -1]]
    inner[0] = values[0] - first * middles[0]
    inner[-1] = values[-1] + last * (stations[-1] - middles[-1])
    return inner


def _clearance(section: tuple[float, float], y: float, z: float) -> float:
    """Return the distance [m] from a point (y, z) to the rim of an elliptical section; negative outside."""
    angles = np.linspace(0, 2 * math.pi, 2001)
    distance = np.hypot(section[0] * np.cos(angles) - z, section[1] * np.sin(angles) - y).min()
    inside = (z / section[0]) ** 2 + (y / section[1]) ** 2 < 1
    return float(distance) if inside else -float(distance)


def _widest(section: tuple[float, float], lever: float, count: int, radius: float) -> float:
    """Return the default spacing of channels [m]: equal parts of the chord (section II.C).

    The spacing is less if the outermost hoses would otherwise have less than a quarter radius of matrix around them.
    """
    if count == 1:
        return 0.0
    chord = section[0] * math.sqrt(max(0.0, 1 - (lever / section[1]) ** 2))
    spacings = np.linspace(2 * chord / count, 2 * radius, 500)
    possible = [_clearance(section, lever, s * (count - 1) / 2) >= 1.25 * radius for s in spacings]
    return float(spacings[int(np.argmax(possible))]) if any(possible) else 2 * radius + WALL


def half_shape(body: JointBody, *, squeeze: float = 1.0) -> Any:
    """Return the drawing of the half body with z >= 0 in mm: matrix and tip plate, with named solids, faces, edges."""
    need_fe()
    from netgen.occ import Axes, Box, Glue, WorkPlane, X, Y

    length, plate = MM * body.length / squeeze, MM * body.plate / squeeze
    beyond = 2 * MM * max(float(body.semi_major.max()), body.length)
    upper = Box((-beyond, -beyond, 0), (beyond, beyond, beyond))
    matrix, tip = (solid * upper for solid in _solids(body, squeeze, body.upper))
    parts = [matrix, tip]
    if body.axis > 0:  # a face in the neutral layer
        half_width = MM * body.axis / 2
        parts.insert(1, WorkPlane(Axes((0, 0, 0), n=-Y, h=X)).Rectangle(length, half_width).Face())
    shape = Glue(parts)
    *soft_solids, plate_solid = sorted(shape.solids, key=lambda solid: solid.center.x)
    for solid in soft_solids:
        solid.mat("matrix")
    plate_solid.mat("plate")
    for face in shape.faces:
        face.name = _face_name(face, body, length, plate)
        if face.name == "axis":
            max(face.edges, key=lambda edge: edge.center.z).name = "rim"
    return shape


def _solids(body: JointBody, squeeze: float, channels: tuple[Channel, ...]) -> tuple[Any, Any]:
    """Return the solids, in mm, of the matrix with its channels and of the tip plate, both with z < 0 and z >= 0."""
    from netgen.occ import Cylinder, Pnt, ThruSections, X

    stations, length = MM * body.stations / squeeze, MM * body.length / squeeze

    def section(x: float, k: int) -> Any:
        return _ellipse(body, k, x).Wire()

    pieces = [
        ThruSections([section(float(stations[k]), k), section(float(stations[k + 1]), k + 1)], True)
        for k in range(len(stations) - 1)
    ]
    matrix = pieces[0]
    for piece in pieces[1:]:
        matrix = matrix + piece
    for channel in channels:
        start = Pnt(0, MM * channel.y, MM * channel.z)
        matrix = matrix - Cylinder(start, X, r=MM * body.radius, h=length)
    tip = ThruSections([section(length, -1), section(length + MM * body.plate / squeeze, -1)], True)
    return matrix, tip


def _face_name(face: Any, body: JointBody, length: float, plate: float) -> str:
    """Return the name of a face of the drawing; it follows from the face's position."""
    low, high = face.bounding_box

    def lies(axis: str, place: float) -> bool:
        return bool(max(abs(getattr(end, axis) - place) for end in (low, high)) < SAME)

    def inside(channel: Channel) -> bool:
        y, z, r = MM * channel.y, MM * channel.z, MM * body.radius + SAME
        return bool(y - r < low.y and high.y < y + r and z - r < low.z and high.z < z + r)

    for axis, place, name in (("x", 0, "fixed"), ("x", length + plate, "tip"), ("z", 0, "symmetry"), ("y", 0, "axis")):
        if lies(axis, place):
            return name
    for channel in filter(inside, body.upper):
        return f"{'cap' if lies('x', length) else 'wall'}_{SIDES[channel.side]}"
    return "tie" if lies("x", length) else "outer"


def write_geometry(body: JointBody, path: str | Path) -> None:
    """Write the whole body with both plates as STEP or STL, in mm."""
    need_fe()
    from netgen.occ import Compound

    path, kind = Path(path), Path(path).suffix.lower()
    if kind not in DRAWINGS:
        raise InputError("must end in .step, .stp or .stl", key="path", value=str(path), fix="rename the file")
    connector = _ellipse(body, 0, -MM * body.plate).Face().Extrude(MM * body.plate)
    matrix, tip = _solids(body, 1.0, body.channels)
    with scratch() as folder:
        draft = str(folder / f"draft{kind}")
        if kind == ".stl":  # one solid, since triangles on shared faces would not match
            _surface(connector + matrix + tip, MM * body.radius).save(draft)
        else:
            Compound([connector, matrix, tip]).WriteStep(draft)
        write_atomically(path, Path(draft).read_bytes())


def _surface(solid: Any, size: float) -> Any:
    """Return triangles of size `size` [mm] or less on the faces of a solid."""
    need_pictures()
    import pyvista as pv
    from netgen.meshing import MeshingStep
    from netgen.occ import OCCGeometry

    options = {"maxh": size, "curvaturesafety": 2.0, "grading": 0.5}
    mesh = OCCGeometry(solid).GenerateMesh(perfstepsend=MeshingStep.MESHSURFACE, **options)
    points = np.array([point.p for point in mesh.Points()])
    corners = np.array([[vertex.nr - 1 for vertex in face.vertices] for face in mesh.Elements2D()])
    return pv.PolyData.from_regular_faces(points, corners)


def _ellipse(body: JointBody, k: int, x: float) -> Any:
    """Return the rim of section k as an ellipse at x [mm]; the CAD kernel takes the longer semi-axis first."""
    from netgen.occ import Axes, WorkPlane, X, Y, Z

    height, width = MM * float(body.semi_major[k]), MM * float(body.semi_minor[k])
    plane = WorkPlane(Axes((x, 0, 0), n=X, h=Z if height >= width else Y))
    return plane.Ellipse(max(height, width), min(height, width))
