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
    Real,
    Text,
    entry,
    number,
    same_length,
)
from hypertuna.errors import did_you_mean
from hypertuna.ranges import Range

WORKING = 0.8  # of the soft limit: the working pressure by default
Smoothing = Annotated[float, number(Range(min=1e-3))]  # s: the controller divides by it


class Controller(Part, table="controller"):
    """The controller on board: oscillators, posture control per beat, pressure supervisor, servo pulses."""

    renamed: ClassVar[Mapping[str, str]] = {"integral": "learning"}

    rate: Positive = entry("control rate", "Hz")
    convergence: Positive = entry("rate at which an oscillator converges to its limit cycle", "1/s")
    coupling: Positive = entry("rate at which oscillators converge to their phase difference", "1/s")
    smoothing: Smoothing = entry("time constant with which amplitude, bias and frequency follow a command", "s")
    learning: PositiveFraction = entry("weight of a new beat in the corrections of amplitude and bias")
    frequency_max: Positive = entry("highest beat frequency of a command", "Hz")
    fin_max: PositiveDegrees = entry("largest angle of the pectoral fins to either side", "deg")
    voltage_low: Positive = entry("battery voltage below which the status warns", "V")
    pressure_step: Positive | None = entry(
        "largest change within a tick beside the pump's; a larger one is a faulty sensor", "Pa", default=None
    )
    pressure_work: Positive | None = entry(
        "largest pressure of a steady beat, to which the amplitude is governed (default: 0.8 of the soft limit)",
        "Pa",
        default=None,
    )
    pressure_soft: Positive | None = entry(
        "pressure to which the supervisor limits commands within a tick: water hammer included", "Pa", default=None
    )
    pressure_hard: Positive | None = entry("pressure at which a circuit is released for good", "Pa", default=None)
    timeout: Positive = entry("time without a command after which the tail rests", "s")
    pulse_center: Microseconds = entry("servo pulse of the neutral angle", "us")
    pulse_per_rad: Microseconds = entry("change of the servo pulse per angle", "us/rad", key="pulse_us_per_rad")
    pulse_min: Microseconds = entry("shortest servo pulse", "us")
    pulse_max: Microseconds = entry("longest servo pulse", "us")
    slew: Positive = entry("largest rate of the commanded servo angle", "rad/s")

    @property
    def works_at(self) -> float | None:
        """Pressure to which the amplitude is governed [Pa]: between readings, hammer adds a fifth and more."""
        return self.pressure_work or (None if self.pressure_soft is None else WORKING * self.pressure_soft)

    def _checks(self) -> Iterator[Check]:
        if self.pressure_soft is not None and self.pressure_hard is not None:
            yield self.ordered("pressure_soft", "pressure_hard")
        if self.pressure_work is not None and self.pressure_soft is not None:
            yield self.ordered("pressure_work", "pressure_soft")
        yield self.ordered("pulse_min", "pulse_center")
        yield self.ordered("pulse_center", "pulse_max")

    def fill(self, pressure: float, key: str) -> Check:
        """Check that the supervisor allows a circuit its fill pressure."""
        limit = self.works_at or math.inf
        text = f"must be less than the working pressure, controller.pressure_work_pa = {limit:g}"
        fix = "lower the fill pressure or raise the limit"
        return Check(pressure < limit, key, text, fix, f"{pressure:g}")


if TYPE_CHECKING:
    Quantity = str
else:
    Quantity = Literal[tuple(CHANNELS)]


NOISY = 0.7  # steps of its resolution: noise from which equal readings show that a sensor is stuck


class Sensor(Part, table="sensors"):
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
    noise: NotNegative = entry("standard deviation of its noise, in SI units", default=0.0)
    resolution: NotNegative = entry("step of its quantization, in SI units", default=0.0)
    drift: NotNegative = entry("standard deviation of its random walk after 1 s, in SI units", default=0.0)
    bias: NotNegative = entry("standard deviation of its constant offset, in SI units", default=0.0)
    nonlinearity: NotNegative = entry("largest deviation from a line, as a fraction of its range", default=0.0)
    period: Positive | None = entry("time between two fixes, for quantity = 'position' only", "s", default=None)

    @property
    def hidden_change(self) -> float:
        """Change that a working sensor may not show [SI]: two steps, or 0 where its noise reaches `NOISY`.

        In the middle of a step a reading then repeats with a probability of erf(0.5 / (0.7 sqrt 2)) = 0.52; 25 times in
        a row, which is taken for a stuck sensor, with 1e-7.
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


class Guidance(Part, table="guidance"):
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
        "named gaits of the gait table, slowest first; linear interpolation in between", min_length=1
    )
    speed: tuple[Positive, ...] | None = entry(
        "speed of each of these gaits through the water (default: computed, joints by bandwidth)", "m/s", default=None
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
    heading_rate: Positive = entry("bandwidth of the heading loop", "1/s")
    turn_max: PositiveDegrees = entry("largest turning rate that the pilot commands", "deg/s")
    rate_gain: NotNegative = entry("gain on the error of the turning rate")
    heading_integral: NotNegative = entry("integral gain of the heading loop", "1/s")
    lookahead: Positive = entry("lookahead distance along the leg", "m")
    depth_lookahead: Positive = entry("lookahead distance in depth", "m")
    climb_max: PositiveDegrees = entry("steepest path angle that the pilot commands", "deg")
    pitch_max: PositiveDegrees = entry("pitch at which the commanded path angle is zero", "deg")
    depth_integral: NotNegative = entry("integral gain of the depth loop", "1/s")
    climb_lead: Positive = entry("fin angle per commanded path angle")
    climb_gain: NotNegative = entry("fin angle per error of the path angle")
    pitch_gain: Real = entry("fin angle per pitch, opposed to the pitch")
    pitch_damping: NotNegative = entry("fin angle per pitch rate, against it", "s")
    speed_min: Positive = entry("minimum speed that the steering gains assume", "m/s")

    surface_depth: Positive = entry("depth above which the robot counts as at the surface", "m")
    fence_margin: Positive = entry(
        "distance to the fence at which the robot turns, added to twice the position's standard deviation", "m"
    )
    error_max: Positive = entry("position error at which the robot surfaces for a fix", "m")
    error_near: Positive = entry("position error near the fence at which the robot surfaces for a fix", "m")
    error_lost: Positive = entry("position error without any fix at which the robot goes home", "m")
    drift_error_max: Positive = entry("growth rate of the position error below which a dive begins", "m/s")
    fix_timeout: Positive = entry("longest wait at the surface for a fix", "s")
    retry: Positive = entry("time until the next attempt after no fix", "s")
    sensor_timeout: Positive = entry("time without readings after which a sensor is lost", "s")
    compass_timeout: Positive = entry("time without a compass after which the robot surfaces", "s")
    fin_tilt: PositiveDegrees = entry("roll that reveals a fin that does not follow", "deg")
    fin_min: PositiveDegrees = entry("fin angle above which the roll is monitored", "deg")
    fin_after: Positive = entry("time of the roll after which the fin is lost", "s")
    single_fin_max: PositiveDegrees = entry("largest angle of the fin that still works", "deg")
    response_time: Positive = entry("time within which the depth must respond to fins at their limit", "s")
    response_depth: Positive = entry("change of depth that counts as a response", "m")
    blind_fin: PositiveDegrees = entry("fin angle during ascent without depth sensor or IMU", "deg")
    blind_speed: Positive = entry("speed during ascent without an IMU", "m/s")
    power: Positive = entry("electrical power at the fastest gait, for the energy to reach home", "W")
    overhead: NotNegative = entry("time added to every estimated return home", "s")

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
