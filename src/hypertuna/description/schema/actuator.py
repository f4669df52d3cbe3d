"""The tables of the actuator in a robot description: drive units, soft joints, silicones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from hypertuna import _core
from hypertuna.description.schema.base import (
    Check,
    Degrees,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    QuarterTurn,
    Scale,
    Spread,
    Text,
    entry,
    number,
    same_length,
)
from hypertuna.errors import did_you_mean
from hypertuna.ranges import Range

NEUTRAL_BRAID = math.acos(1 / math.sqrt(3))  # rad, braid angle with the largest volume, cos^2 theta = 1/3: no pull
HOSE = Scale("HyperTuna's hoses, scaled to the narrowest section", {"width": 1}, digits=3)
MaterialSet = Literal["datasheet", "fe", "tensile", "mean"]


class DriveUnit(Part, table="drive_unit", how="calipers on a muscle, or its data sheet"):
    """A McKibben muscle: a silicone hose in a braided net; one design for all joints."""

    outer_diameter: Positive = entry("outer diameter of the hose at rest", "m", usual=(0.0006, 0.1), scale=HOSE)
    inner_diameter: Positive = entry("inner diameter of the hose at rest", "m", usual=(0.0003, 0.1), scale=HOSE)
    braid_angle: PositiveDegrees = entry(
        "angle of the braid from the axis, snug at rest",
        "deg",
        how="photograph: angle of the threads to the axis at rest",
        usual=(5.0, 54.7),
    )
    friction: NotNegative = entry(
        "friction coefficient between braid and hose, on the section inside the braid",
        default=0.0,
        how="bench: bend up and down in pressure (`joint fit`)",
    )
    braid_stiffness: Positive = entry(
        "modulus times net thickness of each of the braid's two families of fibers; for finite elements, inextensible "
        "otherwise",
        "N/m",
        key="braid_stiffness_n_per_m",
        default=1e6,
        how="bench: bend over pressure (`joint fit`)",
    )
    hose: Text = entry("material of the hose, a key of the table materials", how="name the material")
    matrix: Text = entry("material of the matrix, a key of the table materials", how="name the material")
    material_set: MaterialSet = entry(
        "set of elastic constants to use",
        default="datasheet",
        how="choose: datasheet, fe, tensile, or mean of the first and the last",
    )

    def _checks(self) -> Iterator[Check]:
        yield self.ordered("inner_diameter", "outer_diameter", fix="exchange the two, or measure again")
        neutral = f"{math.degrees(NEUTRAL_BRAID):.2f}, where pressure no longer shortens a muscle"
        fix = "measure it from the axis of the hose"
        yield Check(self.braid_angle < NEUTRAL_BRAID, "braid_angle", f"must be less than {neutral}", fix)

    def check_materials(self, materials: Mapping[str, Material]) -> Iterator[Check]:
        """Check that the materials exist, and have the constants of the set."""
        constants = {"fe": "modulus_fe", "tensile": "tensile", "mean": "tensile"}
        constant = constants.get(self.material_set, "modulus_100")
        for name in ("hose", "matrix"):
            material = getattr(self, name)
            exists, text = material in materials, "must be a material of the table [materials]"
            fix = "" if exists else did_you_mean(material, materials) if materials else "add that table"
            yield Check(exists, f"drive_unit.{name}", text, fix, repr(material))
            if not exists:
                continue
            has_constant = getattr(materials[material], constant) is not None
            key = f"materials.{material}.{Material.model_fields[constant].alias}"
            fix = "give it, or choose another set"
            yield Check(has_constant, key, f"is missing for drive_unit.material_set = {self.material_set!r}", fix)


class Actuator(Part, table="joints.actuator", how="calipers on the mold, or CAD"):
    """The soft body of a joint in segments; in each, muscles bend an elliptical section of matrix."""

    renamed: ClassVar[Mapping[str, str]] = {"strip_width_m": "axis_width_m, with axis_stiffness_n and axis_buckling_n"}

    lever: Positive = entry(
        "distance of the drive units from the middle",
        "m",
        how="calipers on the mold: middle of the muscles to the middle of the body",
        usual=(5e-4, 0.2),
    )
    segment_length: tuple[Positive, ...] = entry("length of each segment", "m", min_length=1, usual=(0.001, 1.0))
    semi_major: tuple[Positive, ...] = entry("half height of each segment's section", "m", usual=(0.002, 1.0))
    semi_minor: tuple[Positive, ...] = entry("half width of each segment's section", "m", usual=(0.002, 1.0))
    stiffness_factor: Positive = entry(
        "factor on the bending stiffness E I of the matrix, for the strip, pipes and channels inside",
        default=1.0,
        how="bench: bend over pressure (`joint fit`)",
        usual=(0.2, 20.0),
        spread=Spread(10, "stiffness of the silicone", 0.7, 1.4),
    )
    spacing: Positive | None = entry(
        "distance of neighboring drive units of a side, across the plane of bending; for finite elements (default: "
        "evenly over the height of the narrowest section)",
        "m",
        default=None,
        usual=(5e-4, 0.2),
    )
    plate: Positive = entry("thickness of the stiff plates at both ends; for finite elements", "m", default=0.003)
    axis_width: Positive = entry(
        "width, across the plane of bending, over which what lies on the axis spreads its force; for finite elements",
        "m",
        default=0.00635,
    )
    axis_stiffness: NotNegative = entry(
        "stiffness in tension, E A, of what lies on the axis and holds its length: a film, pipes; 0 for none",
        "N",
        default=0.0,
    )
    axis_buckling: Positive | None = entry(
        "compression at which that buckles, and which it carries from there on (default: it never buckles)",
        "N",
        default=None,
    )
    asymmetry: Annotated[float, number(Range(above=-1, below=1))] = entry(
        "difference of the levers, left minus right, over their mean",
        default=0.0,
        how="bench: bend to the left and to the right (`joint fit`)",
    )

    @property
    def levers(self) -> tuple[float, float]:
        """Distances of the left and the right drive units from the middle [m]."""
        return self.lever * (1 + self.asymmetry / 2), self.lever * (1 - self.asymmetry / 2)

    @property
    def axis(self) -> tuple[float, float]:
        """Stiffness [N] of the member on the axis, and the compressive strain at which it buckles."""
        if self.axis_buckling is None:
            return self.axis_stiffness, 1.0  # no axis gets that short
        return self.axis_stiffness, self.axis_buckling / self.axis_stiffness

    @property
    def length(self) -> float:
        """Length of the soft body [m]."""
        return math.fsum(self.segment_length)

    def _checks(self) -> Iterator[Check]:
        yield from same_length(self, "joints.actuator", len(self.segment_length), "segment")
        narrowest = min(self.semi_minor)
        text = f"must be less than the smallest semi_minor_m = {narrowest:g}: the drive units run inside the body"
        yield Check(self.lever < narrowest, "lever", text, "give it in m, measured from the middle of the section")
        held = self.axis_buckling is None or self.axis_stiffness > 0
        text = "belongs to something on the axis that axis_stiffness_n describes"
        yield Check(held, "axis_buckling", text, "give axis_stiffness_n too, or leave it out")


class Material(Part, how="data sheet of the silicone"):
    """A silicone."""

    tensile_strength: Positive = entry("tensile strength", "Pa", usual=(1e4, 1e9))
    modulus_100: Positive = entry("stress at 100 % strain", "Pa", usual=(2e3, 1e8))
    shore: Text = entry("Shore hardness with its scale")
    modulus_fe: Positive | None = entry(
        "Young's modulus of the material set fe",
        "Pa",
        default=None,
        how="tensile test: slope at small strain",
        usual=(2e3, 1e8),
    )
    tensile: tuple[NotNegative, NotNegative] | None = entry(
        "Mooney-Rivlin C1 and C2 of the material set tensile, fitted to tensile tests",
        "Pa",
        default=None,
        how="tensile test (`joint silicone`)",
    )
    relaxation: NotNegative = entry(
        "relaxation time: viscous stress over the rate of the elastic stress",
        "s",
        default=0.0,
        how="loss factor over 2 pi f, from a data sheet; or 5 ms",
        usual=(0.0, 1.0),
    )


class Hinge(Part):
    """A hinge at the front of a link, in series with the joint there: passive (a soft fin) or driven by a moment."""

    link: Annotated[int, Field(strict=True, ge=1)] = entry(
        "link that the hinge carries", how="count the links from the head, which is 0"
    )
    stiffness: Positive = entry(
        "stiffness of its spring",
        "N m/rad",
        key="stiffness_n_m_per_rad",
        how="hang weights at a known lever: torque over angle",
        follows={"stiffness": 1},
        usual=(1e-4, 1e3),
    )
    damping: NotNegative = entry(
        "viscous damping",
        "N m s/rad",
        key="damping_n_m_s_per_rad",
        default=0.0,
        how="let the fin swing in air: decay of the swings",
        usual=(1e-6, 10.0),
    )
    rest: QuarterTurn = entry(
        "angle at which its spring rests, counter-clockwise from above",
        "deg",
        default=0.0,
        how="photo from above, out of the water",
    )
    cubic: NotNegative = entry(
        "cubic term of a spring that hardens: moment over the cube of the angle from rest",
        "N m/rad^3",
        key="cubic_n_m_per_rad3",
        default=0.0,
        how="hang weights up to large angles: what the moment is beyond stiffness times angle",
        usual=(1e-4, 1e5),
    )
    stop: PositiveDegrees | None = entry(
        "angle of its stops, to either side of straight", "deg", default=None, how="turn the fin until it stands"
    )
    stop_stiffness: Positive | None = entry(
        "stiffness of a stop, beside that of the spring",
        "N m/rad",
        key="stop_stiffness_n_m_per_rad",
        default=None,
        how="hang weights against the stop; or 10 times the spring's",
        usual=(1e-3, 1e5),
    )
    stop_dissipation: NotNegative = entry(
        "damping of a stop over the angle beyond it",
        "N m s/rad^2",
        key="stop_dissipation_n_m_s_per_rad2",
        default=0.0,
        how="let the fin fall on the stop: 1.5 stop_stiffness times the loss of speed, over the square of the speed",
        usual=(1e-5, 1e5),
    )
    moment: NotNegative = entry(
        "amplitude of a moment that drives the hinge at the beat's frequency: of motor, magnet or muscle; no twin "
        "has it, settled beats do",
        "N m",
        key="moment_n_m",
        default=0.0,
        how="motor: torque at the hinge; muscle: stiffness times the angle to which it bends the hinge without load",
        follows={"moment": 1},
        usual=(0.0, 1e3),
    )
    moment_phase: Degrees = entry(
        "lag of this moment behind the gait's clock",
        "deg",
        default=0.0,
        how="choose it, or let a search: `optimize --design`",
    )


def hinges_in_order(hinges: Mapping[str, Hinge], last: int) -> Iterator[Check]:
    """Check that hinges, by key, are listed from nose to tail and are on links up to `last`, and check their stops."""
    count, most = len(hinges), _core.MAX_HINGES
    yield Check(count <= most, "hinge_list", f"must be at most {most} hinges", "join some", f"{count}")
    ahead = 0
    for key, hinge in hinges.items():
        text = f"must be behind link {ahead}, and at most {last}" if ahead else f"must be a link from 1 to {last}"
        fix = "list the hinges from nose to tail, one a link" if ahead else "link 0 is the head"
        yield Check(ahead < hinge.link <= last, f"{key}.link", text, fix, f"{hinge.link}")
        yield from _stops(key, hinge)
        ahead = hinge.link


def _stops(key: str, hinge: Hinge) -> Iterator[Check]:
    """Check the stops of a hinge, between which its spring must rest."""
    fix = "give stop_deg and stop_stiffness_n_m_per_rad, or no stops"
    if hinge.stop is None:
        consistent = hinge.stop_stiffness is None and not hinge.stop_dissipation
        yield Check(consistent, f"{key}.stop_deg", "must be given with the numbers of stops", fix, "missing")
    else:
        place, text = f"{key}.stop_stiffness_n_m_per_rad", "must be given with stop_deg"
        yield Check(hinge.stop_stiffness is not None, place, text, fix, "missing")
        side, rest = math.degrees(hinge.stop), math.degrees(hinge.rest)
        text, fix = f"must be between the stops, at -{side:g} and {side:g}", "rest the spring between them"
        yield Check(abs(hinge.rest) < hinge.stop, f"{key}.rest_deg", text, fix, f"{rest:g}")
