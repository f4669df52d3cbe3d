"""The tables of the hydraulics in a robot description: pump, oil, lines, servos, battery."""

import math
from collections.abc import Iterator

from hypertuna import _core
from hypertuna.description.schema.base import (
    AmpereHours,
    Celsius,
    Check,
    Count,
    Fraction,
    Negative,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    PositiveFraction,
    Real,
    Spread,
    Text,
    entry,
)
from hypertuna.io.quantity import ZERO_CELSIUS

HOTTEST = ZERO_CELSIUS + 100  # K, the higher of the two temperatures at which the viscosity is given
SOFTEST = 1e8  # Pa, smallest allowed bulk modulus: all liquids have more
SPEED = Spread(6, "speed of the servos", 0.9, 1.1)  # error of data sheets
BANDWIDTH = Spread(7, "bandwidth of the servos", 0.5, 2.0)  # from cheap to good servos
GEARS = entry(
    "friction torque of its gears, at the output",
    "N m",
    default=0.0,
    how="ammeter: current without load over the stall current, times the stall torque",
    usual=(1e-4, 20.0),
)
INERTIA = Spread(8, "inertia of the servos", 0.7, 3.0)  # up to motors with iron cores
MOST_SHARE = 10.0  # largest share of a joint in the bend of its group
THINNEST = 0.3e-6  # m^2/s, viscosity at and below which log10 log10 (nu + 0.7), nu in mm^2/s, is undefined


class Pump(Part, table="pump", how="calipers on the pump, or CAD"):
    """One cylinder of the piston pump: a servo turns a crank that drives a piston."""

    bore: Positive = entry("diameter of the piston", "m", usual=(0.002, 0.2))
    crank: Positive = entry("length of the crank", "m", usual=(0.001, 0.5))
    rod: Positive = entry("length of the connecting rod", "m", usual=(0.002, 1.0))
    neutral: PositiveDegrees = entry(
        "angle of the crank from full retraction at which the circuits were filled",
        "deg",
        how="protractor at rest; 90 has the crank across the piston",
    )
    dead_volume: NotNegative = entry(
        "volume of oil in the cylinder at full stroke",
        "m^3",
        how="volume that the piston leaves at its end, from CAD",
        usual=(0.0, 1e-3),
    )
    seal_friction: NotNegative = entry(
        "friction of the piston's seals, at rest and in motion",
        "N",
        default=0.0,
        how="luggage scale: pull the piston slowly through the open, oiled cylinder",
        usual=(0.0, 500.0),
    )

    def _checks(self) -> Iterator[Check]:
        text, fix = f"must be more than crank_m = {self.crank:g}", "a shorter rod cannot turn the crank"
        yield Check(self.rod > self.crank, "rod", text, fix)


class Oil(Part, table="oil", how="data sheet of the oil"):
    """The hydraulic oil."""

    name: Text = entry("name of the oil")
    viscosity_40: Positive = entry("kinematic viscosity at 40 C", "m^2/s", usual=(3e-7, 1e-2))
    viscosity_100: Positive = entry("kinematic viscosity at 100 C", "m^2/s", usual=(3e-7, 1e-2))
    density: Positive = entry("density", "kg/m^3", usual=(500.0, 2500.0))
    bulk_modulus: Positive = entry("bulk modulus without air", "Pa", usual=(4e8, 1e10))
    air: Fraction = entry(
        "entrained air, as a fraction of the oil's volume at atmospheric pressure",
        how="1 % filled by hand, 0.1 % under vacuum; bench: volume over pressure of a closed circuit",
        spread=Spread(3, "entrained air", 0.5, 5.0),
    )
    temperature: Celsius = entry(
        "temperature of the oil",
        "degC",
        how="thermometer: that of the water",
        spread=Spread(2, "temperature of the oil", -10.0, 10.0, added=True),
    )
    pour_point: Celsius = entry("temperature below which the oil does not flow", "degC")
    cavitation: Negative = entry("gauge pressure below which the oil cavitates", "Pa", usual=(-101325.0, -1e4))

    def _checks(self) -> Iterator[Check]:
        yield self.ordered("viscosity_100", "viscosity_40", fix="exchange the two: oil thins as it warms")
        text = f"must be at least {SOFTEST:g}: no liquid is softer"
        yield Check(self.bulk_modulus >= SOFTEST, "bulk_modulus", text, "give it in Pa, not MPa or bar")
        text = f"must be more than {THINNEST:g}, below which ASTM D341 has no logarithm"
        yield Check(self.viscosity_100 > THINNEST, "viscosity_100", text, "give it in m^2/s")
        text = f"must be more than {-_core.ATMOSPHERE:g}, a perfect vacuum"
        yield Check(self.cavitation > -_core.ATMOSPHERE, "cavitation", text, "give the pressure above atmosphere")
        low, high = (kelvin - ZERO_CELSIUS for kelvin in (self.pour_point, HOTTEST))
        flows, text = self.pour_point <= self.temperature <= HOTTEST, f"oil.pour_point_c = {low:.5g} to {high:g}"
        yield Check(flows, "temperature", f"must be from {text}", "give a temperature at which the oil flows")


class Line(Part, table="joints.line"):
    """The oil line from a cylinder to the drive units of one side of a joint, and the compliance of its circuit."""

    length: Positive = entry("length of the line", "m", how="tape along the hose", usual=(0.005, 20.0))
    bore: Positive = entry(
        "inner diameter of the line",
        "m",
        how="data sheet of the hose, or a drill bit as gauge",
        usual=(0.0005, 0.03),
        spread=Spread(1, "bore of the lines", 0.8, 1.2),
    )
    compliance: NotNegative = entry(
        "compliance of hoses, braids and fittings: volume per pressure",
        "m^3/Pa",
        default=0.0,
        how="close the joint's end, push oil in with a syringe: volume over pressure",
        usual=(0.0, 1e-9),
        spread=Spread(4, "compliance of the circuits", 0.3, 3.0),
    )
    loss: NotNegative = entry(
        "loss coefficient of entry and exit, in units of the dynamic pressure",
        default=0.0,
        how="1.5 for sharp entry and exit",
    )
    fill_pressure: Real = entry(
        "gauge pressure with the tail straight and the pump at neutral",
        "Pa",
        default=0.0,
        how="pressure gauge with the tail straight and the pump at neutral",
        usual=(1e3, 1e6),
        spread=Spread(5, "fill pressure", 0.4, 1.6),
    )

    def _checks(self) -> Iterator[Check]:
        text = f"must be less than length_m = {self.length:g}: a line is longer than it is wide"
        yield Check(self.bore < self.length, "bore", text, "give both in m")


class Battery(Part, table="battery", how="data sheet of the cell"):
    """The battery."""

    cells: Count = entry("number of cells", how="count them")
    capacity: AmpereHours = entry("capacity of one cell", "A h", key="capacity_ah", usual=(0.02, 500.0))
    voltage: Positive = entry("nominal voltage of one cell", "V", usual=(1.0, 60.0))
    charged: Positive | None = entry(
        "open-circuit voltage of a full cell; it falls linearly to as far below the nominal one (default: constant)",
        "V",
        default=None,
        how="voltmeter on a full cell",
        usual=(1.0, 60.0),
    )
    series: Count | None = entry(
        "number of cells in series; strings of them are in parallel",
        default=None,
        how="count them: nominal voltage of the pack over that of a cell",
    )
    resistance: NotNegative = entry(
        "inner resistance of one cell",
        "ohm",
        default=0.0,
        how="voltmeter: drop of a cell's voltage over the current that causes it",
        usual=(1e-3, 1.0),
    )
    usable: Fraction = entry(
        "usable fraction of the rated capacity", default=1.0, how="discharge once: charge drawn over the rated one"
    )
    converter: Positive | None = entry(
        "output voltage of the servos' converter (default: servos on the battery)",
        "V",
        default=None,
        how="voltmeter behind the converter",
        usual=(1.0, 60.0),
    )
    efficiency: PositiveFraction = entry(
        "efficiency of the converter",
        key="converter_efficiency",
        default=1.0,
        how="data sheet of the converter; or power out over power in",
    )
    electronics: NotNegative = entry(
        "power that board, sensors and radio draw at the battery",
        "W",
        default=0.0,
        how="ammeter at the battery with the servos unplugged, times its voltage",
        usual=(0.0, 200.0),
    )

    def _checks(self) -> Iterator[Check]:
        divides = self.series is None or self.cells % self.series == 0
        yield Check(divides, "series", f"must divide cells = {self.cells}", "give the number of cells of one string")
        full = self.charged is None or self.voltage <= self.charged < 2 * self.voltage
        text = f"must be at least voltage_v = {self.voltage:g}, and less than twice that voltage"
        yield Check(full, "charged", text, "give the voltage of one full cell")


class JointServo(Part, table="joints.servo", how="data sheet of the servo"):
    """A servo on the axle of a joint group, or on the drum of its tendons, without oil and without a bend sensor."""

    torque: Positive = entry("stall torque", "N m", usual=(0.01, 200.0))
    speed: Positive = entry("speed without load", "rad/s", usual=(0.3, 60.0), spread=SPEED)
    voltage: Positive = entry("voltage of torque and speed", "V", usual=(2.0, 60.0))
    stall_current: Positive = entry(
        "current at stall (default: torque x speed / voltage, a motor without losses)",
        "A",
        default_factory=lambda servo: servo["torque"] * servo["speed"] / servo["voltage"],
        usual=(0.05, 200.0),
    )
    idle_current: NotNegative = entry(
        "current without load, at rest", "A", default=0.0, how="ammeter with the servo at rest", usual=(0.001, 2.0)
    )
    friction: NotNegative = GEARS
    inertia: Positive = entry(
        "moment of inertia of rotor and gears, at the output (default: speed reached in 5 ms, a coreless motor)",
        "kg m^2",
        default_factory=lambda servo: 0.005 * servo["torque"] / servo["speed"],
        usual=(1e-8, 1.0),
        spread=INERTIA,
    )
    bandwidth: Positive = entry(
        "bandwidth of its position loop, without load and below its limits",
        "Hz",
        default=10.0,
        how="without load, the frequency at which 71 % of the amplitude is left",
        usual=(1.0, 100.0),
        spread=BANDWIDTH,
    )


class Tendons(Part, table="joints.tendons", how="calipers"):
    """Tendons from the drum of a servo to the joints of its group: a pair to each, always taut, that does not stretch.

    Row by row, what the drum winds up is what the bends take: drum_i phi = sum over j of lever_ij q_j.
    """

    drum: tuple[Positive, ...] = entry(
        "radius at which the drum winds the tendon to each joint", "m", min_length=1, usual=(1e-4, 1.0)
    )
    lever: tuple[tuple[Real, ...], ...] = entry(
        "lever arms of the tendon to each joint, a list: at the group's first joint, the next, up to that where it "
        "ends; 0 where it runs through the axle, negative where it crosses to the other side",
        "m",
        min_length=1,
    )
    stop: tuple[PositiveDegrees, ...] | None = entry(
        "largest bend of each joint to either side, at its stop (default: none)",
        "deg",
        default=None,
        how="protractor: bend each joint to its stop",
    )

    def _checks(self) -> Iterator[Check]:
        text = f"must be {len(self.drum)} lists, one for the tendon to each joint of drum_m"
        fix = "give a drum radius and a list of levers for each joint: without a tendon a joint's bend is open"
        yield Check(len(self.lever) == len(self.drum), "lever", text, fix, f"{len(self.lever)}")
        for i, row in enumerate(self.lever):
            text, fix = f"must be {i + 1} long, a lever at each joint up to the tendon's own", "give 0 if none"
            yield Check(len(row) == i + 1, f"lever[{i}]", text, fix, f"{len(row)} long")
            yield Check(row[-1] != 0, f"lever[{i}]", "must not end with 0: the tendon bends that joint", "measure it")
        text, fix = "must bend the joints of the group to one side in sum", "change the sides of each pair at the drum"
        yield Check(self.turns > 0, "lever", text, fix)
        text = "must share the bend so that no joint bends more than ten times the sum of all"
        yield Check(max(map(abs, self.share)) <= MOST_SHARE, "lever", text, "describe a group for each side")

    @property
    def ratio(self) -> tuple[float, ...]:
        """Bend of each joint over the angle of the drum [1]: the column q / phi of the coupling matrix."""
        bends: list[float] = []
        for drum, row in zip(self.drum, self.lever, strict=True):
            bends.append((drum - math.fsum(a * q for a, q in zip(row, bends, strict=False))) / row[-1])
        return tuple(bends)

    @property
    def turns(self) -> float:
        """Angle of the drum over the group's bend [1]; 0 if the bends of the joints cancel."""
        total = math.fsum(self.ratio)
        return 1 / total if total else 0.0

    @property
    def share(self) -> tuple[float, ...]:
        """Part of the group's bend that each joint takes [1]."""
        return tuple(ratio * self.turns for ratio in self.ratio)


class Servo(Part, how="data sheet of the servo"):
    """Servos of one kind."""

    drives: Text = entry("part that these servos drive", how="name what it drives: piston pump, pectoral fins")
    count: Count = entry("number of these servos", how="count them")
    torque: Positive = entry("stall torque of one servo", "N m", usual=(0.005, 200.0))
    speed: Positive | None = entry("speed without load", "rad/s", default=None, usual=(0.3, 60.0), spread=SPEED)
    voltage: Positive | None = entry("voltage of torque and speed", "V", default=None, usual=(2.0, 60.0))
    stall_current: Positive | None = entry("current at stall", "A", default=None, usual=(0.005, 200.0))
    idle_current: NotNegative | None = entry(
        "current without load, at rest", "A", default=None, how="ammeter with the servo at rest", usual=(0.001, 2.0)
    )
    friction: NotNegative = GEARS
    inertia: Positive | None = entry(
        "moment of inertia of rotor and gears, at the output", "kg m^2", default=None, usual=(1e-7, 1.0), spread=INERTIA
    )
    bandwidth: Positive | None = entry(
        "bandwidth of its position loop, without load and below its limits",
        "Hz",
        default=None,
        how="without load, the frequency at which 71 % of the amplitude is left",
        usual=(0.5, 200.0),
        spread=BANDWIDTH,
    )
