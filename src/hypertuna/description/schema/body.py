"""The tables of body, links, fins, joints and gaits in a robot description."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from hypertuna import _core
from hypertuna.description.schema.actuator import Actuator, DriveUnit
from hypertuna.description.schema.base import (
    Amplitude,
    Check,
    Count,
    Degrees,
    Fraction,
    Index,
    Name,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    Real,
    entry,
    inside,
    same_length,
    unique,
)
from hypertuna.description.schema.hydraulics import JointServo, Line, Pump, Tendons

ROUNDED = 1e-9  # relative tolerance of angles that were converted from degrees
AROUND = 2.55  # perimeter over height of an ellipse 0.6 times as wide as high


class Body(Part):
    """The robot as a whole."""

    length: Positive = entry(
        "length from nose to tail tip (default: the sum of the links)",
        "m",
        default_factory=lambda: 0.0,
        how="ruler: nose to tail tip",
        usual=(0.02, 20.0),
    )
    mass: Positive = entry(
        "mass of the whole robot, which cost of transport is divided by (default: the sum of the links)",
        "kg",
        default_factory=lambda: 0.0,
        how="hang the fish on a scale, in air, filled as it swims",
    )
    width: Positive | None = entry(
        "largest width, fins included", "m", default=None, how="calipers, fins spread", usual=(0.002, 10.0)
    )
    height: Positive | None = entry(
        "largest height, fins included", "m", default=None, how="calipers", usual=(0.002, 10.0)
    )

    def of(self, links: Links) -> Body:
        """Return the body; if length or mass is not given, it is the sum over the links."""
        sums = {"length": math.fsum(links.length), "mass": math.fsum(links.mass)}
        sums = {name: total for name, total in sums.items() if name not in self.model_fields_set}
        body = self.model_copy(update=sums)
        body.__pydantic_fields_set__ -= sums.keys()
        return body


class Links(Part, table="links"):
    """The rigid links, nose to tail, one column per quantity; link 0 is the head."""

    length: tuple[Positive, ...] = entry(
        "length of each link",
        "m",
        min_length=1,
        how="ruler: from joint axle to joint axle, nose and tail tip at the ends",
        usual=(5e-4, 10.0),
        follows={"length": 1},
    )
    name: tuple[Name, ...] = entry(
        "name of each link (default: L0, L1, ...)",
        default_factory=lambda links: tuple(f"L{i}" for i in range(len(links["length"]))),
        how="choose one",
    )
    com: tuple[NotNegative, ...] = entry(
        "distance of each center of mass from the link's front end (default: the middle of the link)",
        "m",
        default_factory=lambda links: tuple(length / 2 for length in links["length"]),
        how="balance each link on an edge; ruler from its front axle",
        follows={"length": 1},
    )
    mass: tuple[Positive, ...] = entry(
        "mass of each link", "kg", how="scale: each link with all that it carries", follows={"mass": 1}
    )
    inertia: tuple[Positive, ...] = entry(
        "moment of inertia of each link about its center of mass (default: a slender rod's m l^2/12)",
        "kg m^2",
        default_factory=lambda links: tuple(
            mass * length * length / 12 for mass, length in zip(links["mass"], links["length"], strict=False)
        ),
        how="pendulum test: hang the link at its front, time ten swings; or CAD",
        usual=(1e-9, 100.0),
        follows={"length": 2, "mass": 1},
    )
    lateral_area: tuple[Positive, ...] = entry(
        "area of each link seen from the side",
        "m^2",
        how="side view on squared paper, count the squares; or CAD",
        follows={"length": 1, "height": 1},
    )
    wetted_area: tuple[Positive, ...] = entry(
        f"reference area of each link's friction (default: {AROUND:g} times the lateral area, an ellipse 0.6 times as "
        "wide as high)",
        "m^2",
        default_factory=lambda links: tuple(AROUND * area for area in links["lateral_area"]),
        how="tape around the sections, times their length; or CAD",
        follows={"length": 1, "height": 1},
    )

    def _checks(self) -> Iterator[Check]:
        counts = [len(column) for name in self.model_fields_set if isinstance(column := getattr(self, name), tuple)]
        count = max(dict.fromkeys([len(self.length), *counts]), key=counts.count)  # the most frequent length
        differs = count != len(self.length)
        yield from same_length(
            self, "links", count, "link, as in the other columns" if differs else "link in links.length_m"
        )
        yield from unique(self.name, "links.name[{}]")
        fix = "correct the link's mass and length"
        for i, inertia in enumerate(self.inertia):  # the default is not checked by its type
            value = f"{inertia:g}, from m l^2/12"
            yield Check(0 < inertia < math.inf, f"inertia[{i}]", "must be positive and finite", fix, value)
        yield from inside(self.com, self.length, "com", "measure the center of mass from the link's front end in m")


class Spatial(Part, table="spatial"):
    """The links in space, one value per link; heights are above the axis through the joints."""

    com_height: tuple[Real, ...] = entry(
        "height of each center of mass",
        "m",
        how="hold each link tilted in water by a weight, and measure its lever; or CAD",
        usual=(-1.0, 1.0),
    )
    volume: tuple[Positive, ...] = entry(
        "volume of each link, for its buoyancy",
        "m^3",
        how="scale: mass in air less mass shown in water, over the density of water",
    )
    buoyancy_center: tuple[NotNegative, ...] = entry(
        "distance of each center of buoyancy from the link's front end",
        "m",
        how="CAD: center of the volume; or as com_m",
        follows={"length": 1},
    )
    buoyancy_height: tuple[Real, ...] = entry(
        "height of each center of buoyancy, where the planar water forces act too",
        "m",
        how="CAD: center of the volume above the axes of the joints; or 0",
    )
    height: tuple[Positive, ...] = entry(
        "height of each section, mean over the link",
        "m",
        how="calipers: mean over the link",
        usual=(0.001, 5.0),
        follows={"height": 1},
    )
    width: tuple[Positive, ...] = entry(
        "width of each section, mean over the link", "m", how="calipers: mean over the link", usual=(5e-4, 5.0)
    )
    drag_vertical: tuple[NotNegative, ...] = entry(
        "drag coefficient up and down, on length x width",
        how="0.015 (1 + h/b) + 1.1 b/h by Hoerner, h the height and b the width",
        usual=(0.02, 5.0),
    )
    added_mass_vertical: tuple[NotNegative, ...] = entry(
        "added mass per length up and down, in units of rho pi/4 width^2", how="0.9 for ellipses of finite length"
    )
    drag_roll: tuple[NotNegative, ...] = entry(
        "drag coefficient of a section's height in rotation about the link's axis",
        how="1.2 for a plate, 0.3 for round sections",
    )
    shedding_vertical: Fraction = entry(
        "fraction of Lighthill's vertical reactive force, of the widest section, that acts at the tail end",
        default=0.0,
        how="0.28, a hull's without a horizontal fin, as HyperTuna's",
    )
    inertia_roll: tuple[Positive, ...] | None = entry(
        "moment of inertia about the axis of each link through its center of mass (default: an ellipsoid's)",
        "kg m^2",
        default=None,
        how="pendulum test about the long axis; or CAD",
        follows={"mass": 1},
    )
    inertia_pitch: tuple[Positive, ...] | None = entry(
        "moment of inertia about the axis across each link through its center of mass (default: an ellipsoid's)",
        "kg m^2",
        default=None,
        how="pendulum test about the axis across; or CAD",
        follows={"length": 2, "mass": 1},
    )

    def centers(self, length: tuple[float, ...]) -> Iterator[Check]:
        """Check that every center of buoyancy lies inside its link."""
        fix = "measure it from the link's front end in m"
        return inside(self.buoyancy_center, length, "spatial.buoyancy_center_m", fix)


class Fins(Part, table="fins", how="ruler"):
    """The pair of pectoral fins: flat plates on both sides of the head, pitched by servos."""

    x: NotNegative = entry(
        "distance of the centers of area from the nose, along the head", "m", usual=(0.002, 10.0), follows={"length": 1}
    )
    y: Positive = entry("distance of the centers of area from the middle plane", "m", usual=(0.002, 5.0))
    z: Real = entry("height of the centers of area above the axis through the joints", "m")
    span: Positive = entry("span of one fin", "m", usual=(0.002, 2.0))
    chord: Positive = entry("chord of one fin", "m", usual=(0.002, 2.0))
    stall: PositiveDegrees = entry(
        "angle of attack at which half of the flow is stalled",
        "deg",
        how="handbook: plates of aspect ratio 2 to 3 stall at 15 to 20 deg",
        usual=(5.0, 60.0),
    )
    drag_zero: NotNegative = entry(
        "drag coefficient along the plate", how="handbook: friction of both sides of a plate", usual=(0.001, 0.5)
    )
    bandwidth: Positive = entry(
        "bandwidth of the servos' first-order lag", "Hz", how="data sheet of the fins' servos", usual=(0.3, 50.0)
    )
    speed: Positive = entry(
        "largest rate of the servos", "rad/s", how="data sheet of the fins' servos", usual=(0.3, 60.0)
    )

    def _checks(self) -> Iterator[Check]:
        fix = "measure it from the middle plane to the middle of a fin, in m"
        yield Check(self.y >= self.span / 2, "y", f"must be at least half of span_m = {self.span:g}", fix)

    def on_head(self, head: float) -> Check:
        """Check that the fins are on the head."""
        text, fix = f"must be on the head, at most {head:g}", "measure it from the nose in m"
        return Check(self.x <= head, "fins.x_m", text, fix, f"{self.x:g}")


def _shares(links: Sequence[int], tendons: Tendons | None) -> tuple[float, ...]:
    """Return the share of a group's bend that each of its joints takes: from the tendons, or equal shares."""
    return (1 / len(links),) * len(links) if tendons is None else tendons.share


class Drive(NamedTuple):
    """A kind of drive of a joint group, with its properties for pins, sensors, records, circuits and texts."""

    actuation: str  # name in the option --actuation of `robot new`
    place: str  # part that its servo turns
    servos: tuple[str, ...]  # one or two servos: endings of their names after the group's name
    oil: bool  # whether oil drives it, with sensors of bend and pressure
    on_board: int  # most such groups of a robot with firmware


AXLE = Drive("servo", "axle", servos=("",), oil=False, on_board=_core.BOARD_JOINTS)
DRUM = Drive("tendons", "drum", servos=("",), oil=False, on_board=_core.BOARD_JOINTS)
MUSCLES = Drive("hydraulic", "crank", servos=("-left", "-right"), oil=True, on_board=3)  # 3: pins of a Teensy 4.1
DRIVES = {drive.actuation: drive for drive in (AXLE, DRUM, MUSCLES)}


class JointGroup(Part):
    """A joint group: one drive whose angle is shared by the joints at the front ends of its links."""

    name: Name = entry("name of the joint group", how="choose one")
    links: tuple[Index, ...] = entry(
        "links whose front joints this group bends", min_length=1, how="count the links from the head, which is 0"
    )
    tendons: Tendons | None = entry("table of the tendons by which a servo bends its joints", default=None)
    share: tuple[Real, ...] = entry(
        "each joint's share of the group's angle (default: by the tendons, equal without)",
        default_factory=lambda group: _shares(group["links"], group["tendons"]),
        how="photograph the bent joint; angle of each axle over the whole",
    )
    bandwidth: Positive | None = entry(
        "bandwidth of the first-order lag: 71 % of the amplitude at this frequency",
        "Hz",
        default=None,
        how="in water, the frequency at which 71 % of the amplitude is left (`identify` fits it)",
        usual=(0.1, 200.0),
    )
    phase_offset: Degrees = entry(
        "phase lag of the joints beyond the model of the joints; added to a gait's phase",
        "deg",
        default=0.0,
        how="tracked angles behind the command, less the model's (`identify` fits it)",
    )
    amplitude_max: PositiveDegrees | None = entry(
        "largest commanded amplitude",
        "deg",
        default=None,
        how="largest amplitude to command: 0.85 times the largest bend",
        usual=(1.6, 180.0),
    )
    bend_max: PositiveDegrees | None = entry(
        "largest bend in air", "deg", default=None, how="protractor: largest bend in air", usual=(1.6, 180.0)
    )
    pressure_max: Positive | None = entry(
        "pressure of the largest bend", "Pa", default=None, how="pressure gauge at the largest bend", usual=(2e3, 5e6)
    )
    drive_units: Count | None = entry(
        "number of pairs of artificial muscles", default=None, how="count the pairs of muscles"
    )
    actuator: Actuator | None = entry("table of the soft body", default=None)
    line: Line | None = entry("table of the oil line of each of its two circuits", default=None)
    servo: JointServo | None = entry("table of the servo on its axle or drum, in place of muscles", default=None)

    @property
    def drive(self) -> Drive:
        """The kind of drive: muscles on oil, or a servo on the axle or on the drum of tendons."""
        return MUSCLES if self.servo is None else AXLE if self.tendons is None else DRUM

    @property
    def driven(self) -> bool:
        """Whether the file describes a drive."""
        return self.servo is not None or self.actuator is not None

    @property
    def stall_power(self) -> float:
        """Electrical power of the servo on axle or drum at stall; 0 without one [W]."""
        return 0.0 if self.servo is None else self.servo.voltage * self.servo.stall_current

    @property
    def turns(self) -> float:
        """Angle of the servo's axle or drum over the bend of the group: 1 on the axle [1]."""
        return 1.0 if self.tendons is None else self.tendons.turns

    def one_drive(self, key: str) -> Iterator[Check]:
        """Check that a joint with a servo or tendons has no muscles, and that tendons alone share its bend."""
        fix = "remove it, or the table servo: a joint is turned by muscles or by a servo"
        for name in ("drive_units", "actuator", "line"):
            one_kind = self.servo is None or getattr(self, name) is None
            yield Check(one_kind, f"{key}.{name}", f"must not stand beside {key}.servo", fix)
        if (tendons := self.tendons) is None:
            return
        fix = "remove it: the levers of the tendons share the bend"
        for name in ("share", "drive_units", "actuator", "line"):
            text = f"must not stand beside {key}.tendons"
            yield Check(name not in self.model_fields_set, f"{key}.{name}", text, fix, "given")
        yield from same_length(tendons, f"{key}.tendons", len(self.links), "joint of the group")
        for k, (share, stop) in enumerate(zip(self.share, tendons.stop or (), strict=False)):
            bend, fix = abs(share) * (self.bend_max or 0.0), "give the bend of the whole group at the first stop"
            text = f"must leave joint {self.links[k]} within its stop_deg = {math.degrees(stop):g}"
            value = f"{math.degrees(self.bend_max or 0.0):g}, of which that joint bends {math.degrees(bend):.4g}"
            yield Check(bend <= stop * (1 + ROUNDED), f"{key}.bend_max_deg", text, fix, value)


class NamedGait(Part, how="choose what your robot swims"):
    """A gait with a name; one value per joint group."""

    frequency: Positive = entry("beat frequency", "Hz", usual=(0.02, 20.0))
    amplitude: tuple[Amplitude, ...] = entry("amplitude of each joint group", "deg", usual=(1.6, 180.0))
    phase: tuple[Degrees, ...] = entry("lag of each joint group behind the clock of the first", "deg")
    bias: tuple[Degrees, ...] = entry(
        "mean angle of each joint group (default: 0)",
        "deg",
        default_factory=lambda gait: (0.0,) * len(gait["amplitude"]),
    )


class GaitBounds(Part, table="gait_bounds", how="choose within what joints and servos do"):
    """Bounds of the gaits that optimizers search, lowest and highest value; equal bounds fix the value."""

    frequency: tuple[Positive, Positive] = entry("lowest and highest beat frequency", "Hz", usual=(0.01, 30.0))
    amplitude: tuple[tuple[Amplitude, Amplitude], ...] = entry(
        "lowest and highest amplitude of each joint group", "deg"
    )
    phase: tuple[tuple[Degrees, Degrees], ...] = entry(
        "lowest and highest lag of each joint group behind the clock of the first", "deg"
    )
    bias: tuple[tuple[Degrees, Degrees], ...] = entry(
        "lowest and highest mean angle of each joint group (default: 0)",
        "deg",
        default_factory=lambda bounds: ((0.0, 0.0),) * len(bounds["amplitude"]),
    )

    def _checks(self) -> Iterator[Check]:
        places: dict[str, tuple[float, float]] = {"gait_bounds.frequency_hz": self.frequency}
        for kind in ("amplitude", "phase", "bias"):
            places |= {f"gait_bounds.{kind}_deg[{g}]": pair for g, pair in enumerate(getattr(self, kind))}
        for place, (low, high) in places.items():
            yield Check(low <= high, place, "must have the lower value first", "exchange the two")


def fits(length: float, joints: Sequence[JointGroup], unit: DriveUnit | None, pump: Pump | None) -> Iterator[Check]:
    """Check that muscles and lines fit into their sections, and sections and pump into the body."""
    across_body = [(f"pump.{name}_m", getattr(pump, name)) for name in ("bore", "crank", "rod") if pump is not None]
    for g, group in enumerate(joints):
        if (body := group.actuator) is None:
            continue
        for name in ("segment_length", "semi_major", "semi_minor"):
            across_body += [(f"joints[{g}].actuator.{name}_m[{i}]", size) for i, size in enumerate(getattr(body, name))]
        in_section = [(f"joints[{g}].line.bore_m", group.line.bore)] if group.line is not None else []
        in_section += [("drive_unit.outer_diameter_m", unit.outer_diameter)] if unit is not None else []
        width = 2 * min(body.semi_minor)
        text = f"must be less than {width:g}, the width of the narrowest section of joint {group.name}"
        yield from (Check(value < width, key, text, "give it in m, not mm", f"{value:g}") for key, value in in_section)
    text = f"must be less than body.length_m = {length:g}: it is inside the body"
    yield from (Check(value < length, key, text, "give it in m, not mm", f"{value:g}") for key, value in across_body)
