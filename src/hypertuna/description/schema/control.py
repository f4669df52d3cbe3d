"""The tables of the controller, the sensors and the pilot in a robot description."""

import math
from collections.abc import Collection, Iterator, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from hypertuna import _core
from hypertuna.description.channels import CHANNELS
from hypertuna.description.schema.base import (
    Check,
    Microseconds,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    PositiveFraction,
    Radio,
    Real,
    Scale,
    Spread,
    Text,
    entry,
    number,
    same_length,
)
from hypertuna.errors import did_you_mean
from hypertuna.ranges import Range

# How values scale from HyperTuna's to another robot.
LENGTH = Scale("as HyperTuna's in body lengths", {"length": 1})
MASS = Scale("HyperTuna's in proportion to the mass", {"mass": 1})
SPEED = Scale("HyperTuna's in proportion to the speed of the gait", {"speed": 1})
TIME = Scale("HyperTuna's way at this robot's speed", {"speed": -1})
RATE = Scale("as HyperTuna's in body lengths traveled", {"length": -1, "speed": 1})
PRESSURE = {"pressure": 1}  # powers: in proportion to the working pressure
WORKING = 0.8  # default of the working pressure over the soft limit
Smoothing = Annotated[float, number(Range(min=1e-3))]  # s: the controller divides by it


class Controller(Part, table="controller", how="as `hypertuna robot new` writes it; tune on the twin"):
    """The controller on board: oscillators, posture control per beat, pressure supervisor, servo pulses."""

    renamed: ClassVar[Mapping[str, str]] = {"integral": "learning"}

    rate: Positive = entry("control rate", "Hz", usual=(5.0, 5000.0))
    convergence: Positive = entry("rate at which an oscillator converges to its limit cycle", "1/s")
    coupling: Positive = entry("rate at which oscillators converge to their phase difference", "1/s")
    smoothing: Smoothing = entry(
        "time constant with which amplitude, bias and frequency follow a command", "s", usual=(0.005, 30.0)
    )
    learning: PositiveFraction = entry(
        "weight of a new beat in the corrections of amplitude and bias", radio=Radio(1, 0.0, 1.0, bounds=True)
    )
    frequency_max: Positive = entry(
        "highest beat frequency of a command", "Hz", usual=(0.2, 50.0), radio=Radio(6, 0.1, 1.0)
    )
    fin_max: PositiveDegrees = entry(
        "largest angle of the pectoral fins to either side", "deg", usual=(1.6, 90.0), radio=Radio(7, 0.0, 1.0)
    )
    voltage_low: Positive = entry(
        "battery voltage below which the status warns",
        "V",
        how="voltage of the pack at a fifth of its charge",
        usual=(1.0, 60.0),
        radio=Radio(8, 1.0, 1.2),
    )
    pressure_step: Positive | None = entry(
        "largest change within a tick beside the pump's; a larger one is a faulty sensor",
        "Pa",
        default=None,
        scale=Scale("as the working pressure", PRESSURE, digits=4),
    )
    pressure_work: Positive | None = entry(
        "largest pressure of a steady beat, to which the amplitude is governed (default: 0.8 of the soft limit)",
        "Pa",
        default=None,
        how="pressure of the largest bend",
        usual=(2e3, 1e7),
        radio=Radio(3, 0.5, 1.0),
        scale=Scale("as joints.pressure_max_pa", PRESSURE, digits=4),
        spread=Spread(9, "working limit", 5 / 11, 15 / 11, along=("pressure_soft_pa", "pressure_hard_pa")),
    )
    pressure_soft: Positive | None = entry(
        "pressure to which the supervisor limits commands within a tick: water hammer included",
        "Pa",
        default=None,
        how="1.25 times the working pressure",
        usual=(2e3, 1e7),
        radio=Radio(4, 0.5, 1.0),
        scale=Scale("1.25 times the working pressure, for what hammer adds between readings", PRESSURE, digits=4),
    )
    pressure_hard: Positive | None = entry(
        "pressure at which a circuit is released for good",
        "Pa",
        default=None,
        how="1.2 times the soft limit, below the burst pressure and in the range of the sensor",
        usual=(2e3, 1e7),
        radio=Radio(5, 0.5, 1.0),
        scale=Scale("1.2 times the soft limit", PRESSURE, digits=4),
    )
    timeout: Positive = entry(
        "time without a command after which the tail rests",
        "s",
        usual=(0.02, 60.0),
        radio=Radio(9, 0.2, 1.0, whole=True, name="timeout_ticks"),
    )
    pulse_center: Microseconds = entry(
        "servo pulse of the neutral angle",
        "us",
        how="data sheet of the servo: pulse of the middle",
        usual=(300.0, 3000.0),
        radio=Radio(10, 0.9, 1.1),
    )
    pulse_per_rad: Microseconds = entry(
        "change of the servo pulse per angle",
        "us/rad",
        key="pulse_us_per_rad",
        how="data sheet of the servo: range of pulses over range of angles",
        usual=(100.0, 3000.0),
        radio=Radio(11, 0.8, 1.25),
    )
    pulse_min: Microseconds = entry(
        "shortest servo pulse", "us", how="data sheet of the servo", usual=(300.0, 3000.0), radio=Radio(12, 1.0, 1.5)
    )
    pulse_max: Microseconds = entry(
        "longest servo pulse", "us", how="data sheet of the servo", usual=(300.0, 3000.0), radio=Radio(13, 0.75, 1.0)
    )
    slew: Positive = entry(
        "largest rate of the commanded servo angle", "rad/s", usual=(0.5, 200.0), radio=Radio(14, 0.1, 1.0)
    )

    @property
    def works_at(self) -> float | None:
        """Working pressure [Pa], to which the amplitude is limited; water hammer adds a fifth or more to readings."""
        return self.pressure_work or (None if self.pressure_soft is None else WORKING * self.pressure_soft)

    def _checks(self) -> Iterator[Check]:
        if self.pressure_soft is not None and self.pressure_hard is not None:
            yield self.ordered("pressure_soft", "pressure_hard")
        if self.pressure_work is not None and self.pressure_soft is not None:
            yield self.ordered("pressure_work", "pressure_soft")
        yield self.ordered("pulse_min", "pulse_center")
        yield self.ordered("pulse_center", "pulse_max")

    def fill(self, pressure: float, key: str) -> Check:
        """Return the check that a circuit's fill pressure [Pa] is below the working pressure."""
        limit = self.works_at or math.inf
        text = f"must be less than the working pressure, controller.pressure_work_pa = {limit:g}"
        fix = "lower the fill pressure or raise the limit"
        return Check(pressure < limit, key, text, fix, f"{pressure:g}")


if TYPE_CHECKING:
    Quantity = str
else:
    Quantity = Literal[tuple(CHANNELS)]


NOISY = 0.7  # noise over resolution above which equal readings show that a sensor is stuck


class Sensor(Part, table="sensors", how="data sheet of the sensor"):
    """Sensors of one kind and their errors."""

    measures: Text = entry("quantity that is measured, in words")
    part: Text = entry("part number")
    quantity: Quantity | None = entry(
        "channel of the twin; rate and acceleration of an IMU, field of a compass in units of its strength, position "
        "of a satellite receiver",
        default=None,
    )
    low: Real | None = entry("lower end of its range, in SI units of the quantity", default=None)
    high: Real | None = entry("upper end of its range, in SI units", default=None)
    noise: NotNegative = entry(
        "standard deviation of its noise, in SI units", default=0.0, how="log a minute at rest: standard deviation"
    )
    resolution: NotNegative = entry("step of its quantization, in SI units", default=0.0)
    drift: NotNegative = entry(
        "standard deviation of its random walk after 1 s, in SI units",
        default=0.0,
        how="log an hour at rest: change over time",
    )
    bias: NotNegative = entry(
        "standard deviation of its constant offset, in SI units",
        default=0.0,
        how="log at rest after several starts: standard deviation of the means",
    )
    nonlinearity: NotNegative = entry("largest deviation from a line, as a fraction of its range", default=0.0)
    period: Positive | None = entry("time between two fixes, for quantity = 'position' only", "s", default=None)

    @property
    def hidden_change(self) -> float:
        """Largest change [SI] within which a working sensor may repeat its reading: two steps, or 0 with enough noise.

        With enough noise, a reading in the middle of a step repeats with a probability of erf(0.5 / (0.7 sqrt 2)) =
        0.52. It repeats 25 times in a row, which counts as a stuck sensor, with a probability of 1e-7.
        """
        return 0.0 if self.noise >= NOISY * self.resolution else 2 * self.resolution

    def _checks(self) -> Iterator[Check]:
        fix = "leave it out: all other sensors are read every tick"
        timed = self.period is None or self.quantity == "position"
        yield Check(timed, "period", "belongs to quantity = 'position'", fix)
        if self.quantity is None:
            return
        fix = "give the range of the sensor in SI units"
        for name in ("low", "high"):
            missing = getattr(self, name) is None
            yield Check(not missing, f"sensors.{name}", f"is missing beside quantity = {self.quantity!r}", fix)
        low, high = self.low or 0.0, self.high or 0.0
        yield Check(high > max(low, 0.0), "high", "must be positive and greater than low", fix)


class Guidance(Part, table="guidance", how="as HyperTuna's; tune on the twin at sea (`hypertuna mission`)"):
    """The pilot on board: where the robot is, where it goes, and when it comes home."""

    renamed: ClassVar[Mapping[str, str]] = {
        "walk_m": "position_walk_m",
        "drift_enough_m_s": "drift_error_max_m_s",
        "patience_s": "fix_timeout_s",
        "compass_patience_s": "compass_timeout_s",
        "fin_least_deg": "fin_min_deg",
        "fin_alone_deg": "single_fin_max_deg",
        "answer_after_s": "response_time_s",
        "answer_depth_m": "response_depth_m",
    }

    gaits: tuple[Text, ...] = entry(
        "named gaits of the gait table, slowest first; linear interpolation in between",
        min_length=1,
        how="name gaits of the file, slow to fast",
    )
    speed: tuple[Positive, ...] | None = entry(
        "speed of each of these gaits through the water (default: computed, joints by bandwidth)",
        "m/s",
        default=None,
        how="time each of these gaits over a known distance, or `hypertuna twin`",
    )
    decisions: Positive = entry("rate of decisions; it divides the control rate", "Hz")

    gravity_rate: Positive = entry("gain of the attitude's correction by gravity", "1/s")
    field_rate: Positive = entry("gain of the heading's correction by the magnetic field", "1/s")
    drift_max: PositiveDegrees = entry("largest offset of a gyroscope that is corrected", "deg/s")
    depth_rate: Positive = entry("bandwidth of the depth observer", "1/s")
    position_walk: Positive = entry("standard deviation of dead reckoning after 1 s, a random walk", "m")
    current_walk: Positive = entry("standard deviation of the current's change within 1 s, a random walk", "m/s")
    current_error: Positive = entry("standard deviation of the current before any fix", "m/s")
    factor_error: PositiveFraction = entry("standard deviation of the speed factor: speed over that of the gait table")
    factor_walk: Positive = entry("standard deviation of the speed factor's change within 1 s, a random walk")
    start_error: Positive = entry("standard deviation of the start's position", "m")

    bias_max: tuple[PositiveDegrees, ...] = entry("largest tail bias that steers, of each joint group", "deg")
    heading_rate: Positive = entry("bandwidth of the heading loop", "1/s", radio=Radio(1), scale=RATE)
    turn_max: PositiveDegrees = entry(
        "largest turning rate that the pilot commands", "deg/s", usual=(1.6, 400.0), radio=Radio(4), scale=RATE
    )
    rate_gain: NotNegative = entry("gain on the error of the turning rate", radio=Radio(3))
    heading_integral: NotNegative = entry("integral gain of the heading loop", "1/s", radio=Radio(2), scale=RATE)
    lookahead: Positive = entry(
        "lookahead distance along the leg", "m", usual=(0.1, 100.0), radio=Radio(6), scale=LENGTH
    )
    depth_lookahead: Positive = entry("lookahead distance in depth", "m", radio=Radio(7), scale=LENGTH)
    climb_max: PositiveDegrees = entry("steepest path angle that the pilot commands", "deg", usual=(1.6, 90.0))
    pitch_max: PositiveDegrees = entry("pitch at which the commanded path angle is zero", "deg", usual=(1.6, 90.0))
    depth_integral: NotNegative = entry("integral gain of the depth loop", "1/s", radio=Radio(8), scale=RATE)
    climb_lead: Positive = entry("fin angle per commanded path angle", radio=Radio(9))
    climb_gain: NotNegative = entry("fin angle per error of the path angle", radio=Radio(10))
    pitch_gain: Real = entry("fin angle per pitch, opposed to the pitch")
    pitch_damping: NotNegative = entry("fin angle per pitch rate, against it", "s", radio=Radio(11))
    speed_min: Positive = entry("minimum speed that the steering gains assume", "m/s", radio=Radio(12), scale=SPEED)

    surface_depth: Positive = entry(
        "depth above which the robot counts as at the surface", "m", usual=(0.005, 5.0), radio=Radio(13)
    )
    fence_margin: Positive = entry(
        "distance to the fence at which the robot turns, added to twice the position's standard deviation",
        "m",
        radio=Radio(14),
    )
    error_max: Positive = entry("position error at which the robot surfaces for a fix", "m", radio=Radio(15))
    error_near: Positive = entry("position error near the fence at which the robot surfaces for a fix", "m")
    error_lost: Positive = entry("position error without any fix at which the robot goes home", "m")
    drift_error_max: Positive = entry("growth rate of the position error below which a dive begins", "m/s")
    fix_timeout: Positive = entry("longest wait at the surface for a fix", "s", radio=Radio(16))
    retry: Positive = entry("time until the next attempt after no fix", "s")
    sensor_timeout: Positive = entry("time without readings after which a sensor is lost", "s")
    compass_timeout: Positive = entry("time without a compass after which the robot surfaces", "s")
    fin_tilt: PositiveDegrees = entry("roll that reveals a fin that does not follow", "deg")
    fin_min: PositiveDegrees = entry("fin angle above which the roll is monitored", "deg")
    fin_after: Positive = entry("time of the roll after which the fin is lost", "s")
    single_fin_max: PositiveDegrees = entry("largest angle of the fin that still works", "deg", usual=(1.6, 90.0))
    response_time: Positive = entry("time within which the depth must respond to fins at their limit", "s", scale=TIME)
    response_depth: Positive = entry("change of depth that counts as a response", "m")
    blind_fin: PositiveDegrees = entry("fin angle during ascent without depth sensor or IMU", "deg")
    blind_speed: Positive = entry("speed during ascent without an IMU", "m/s", scale=SPEED)
    power: Positive = entry(
        "electrical power at the fastest gait, for the energy to reach home",
        "W",
        how="wattmeter at the fastest of the gaits, or `hypertuna twin`",
        usual=(0.02, 1e4),
        scale=MASS,
    )
    overhead: NotNegative = entry(
        "time added to every estimated return home", "s", how="fly the mission on the twin (`hypertuna mission`)"
    )

    def _checks(self) -> Iterator[Check]:
        count, speed, most = len(self.gaits), self.speed or (), _core.MAX_GAITS
        fix = "omit some: gaits between two of them are interpolated"
        yield Check(count <= most, "gaits", f"must have 1 to {most} gaits", fix, f"{count}")
        text, fix = f"must be {count} long, one per gait", "give a speed per gait, or none"
        yield Check(self.speed is None or len(speed) == count, "speed", text, fix, f"{len(speed)} long")
        rising = all(a < b for a, b in pairwise(speed))
        yield Check(rising, "speed", "must rise from gait to gait", "put the slowest gait first", f"{list(speed)}")
        yield self.ordered("error_near", "error_max", equal=True)
        yield self.ordered("error_max", "error_lost", equal=True)

    def check_robot(self, gaits: Collection[str], groups: int) -> Iterator[Check]:
        """Check that the pilot's gaits exist and that each joint group has its largest bias."""
        for k, name in enumerate(self.gaits):
            fix = "" if name in gaits else did_you_mean(name, gaits)
            yield Check(name in gaits, f"guidance.gaits[{k}]", "must be a known gait", fix, repr(name))
        yield from same_length(self, "guidance", groups, "joint group", but=("gaits", "speed"))
