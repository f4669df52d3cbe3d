"""The tables of the controller and the sensors in a robot description."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal

from hypertuna.description.channels import CHANNELS
from hypertuna.description.schema.base import (
    Microseconds,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    Real,
    Rule,
    Text,
    entry,
)


class Controller(Part, table="controller"):
    """The controller on board: oscillators, posture control per beat, pressure supervisor, servo pulses."""

    rate: Positive = entry("control rate", "Hz")
    convergence: Positive = entry("rate at which an oscillator converges to its limit cycle", "1/s")
    coupling: Positive = entry("rate at which oscillators converge to their phase difference", "1/s")
    smoothing: Positive = entry("time constant with which amplitude, bias and frequency follow a command", "s")
    proportional: NotNegative = entry("proportional gain on the error of a beat's peak bend")
    integral: NotNegative = entry("integral gain per beat")
    derivative: NotNegative = entry("derivative gain, in beats")
    peak_smoothing: Positive = entry("time constant of the low-pass filter ahead of the peaks, in beats")
    frequency_max: Positive = entry("highest beat frequency of a command", "Hz")
    fin_max: PositiveDegrees = entry("largest angle of the pectoral fins to either side", "deg")
    voltage_low: Positive = entry("battery voltage below which the status warns", "V")
    pressure_step: Positive = entry(
        "largest change within a tick beside the pump's; a larger one is a faulty sensor", "Pa"
    )
    pressure_soft: Positive = entry("pressure to which the supervisor limits commands", "Pa")
    pressure_hard: Positive = entry("pressure at which a circuit is released for good", "Pa")
    timeout: Positive = entry("time without a command after which the tail rests", "s")
    pulse_center: Microseconds = entry("servo pulse of the neutral angle", "us")
    pulse_per_rad: Microseconds = entry("change of the servo pulse per angle", "us/rad", key="pulse_us_per_rad")
    pulse_min: Microseconds = entry("shortest servo pulse", "us")
    pulse_max: Microseconds = entry("longest servo pulse", "us")
    slew: Positive = entry("largest rate of the commanded servo angle", "rad/s")

    def _rules(self) -> Iterator[Rule]:
        yield self.ordered("pressure_soft", "pressure_hard")
        yield self.ordered("pulse_min", "pulse_center")
        yield self.ordered("pulse_center", "pulse_max")

    def fill(self, pressure: float, key: str) -> Rule:
        """Return the rule that the supervisor allows a circuit its fill pressure."""
        text = f"must be less than controller.pressure_soft_pa = {self.pressure_soft:g}"
        fix = "lower the fill pressure or raise the limit"
        return Rule(pressure < self.pressure_soft, key, text, fix, f"{pressure:g}")


if TYPE_CHECKING:
    Quantity = str
else:
    Quantity = Literal[tuple(CHANNELS)]


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

    def _rules(self) -> Iterator[Rule]:
        fix = "leave it out: all other sensors are read every tick"
        timed = self.period is None or self.quantity == "position"
        yield Rule(timed, "period", "belongs to quantity = 'position'", fix)
        if self.quantity is None:
            return
        fix = "give the range of the sensor in SI units"
        for name in ("low", "high"):
            missing = getattr(self, name) is None
            yield Rule(not missing, f"sensors.{name}", f"is missing beside quantity = {self.quantity!r}", fix)
        low, high = self.low or 0.0, self.high or 0.0
        yield Rule(high > max(low, 0.0), "high", "must be positive and greater than low", fix)
