"""The tables of the controller and the sensors in a robot description."""

from typing import TYPE_CHECKING, Literal, Self

from pydantic import model_validator

from hypertuna.description.channels import CHANNELS
from hypertuna.description.schema.base import (
    Microseconds,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    Real,
    Text,
    check_order,
    entry,
)
from hypertuna.errors import InputError


class Controller(Part):
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

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_order(self, "controller", "pressure_soft", "pressure_hard")
        check_order(self, "controller", "pulse_min", "pulse_center")
        check_order(self, "controller", "pulse_center", "pulse_max")
        return self

    def check_fill(self, pressure: float, key: str) -> None:
        """Check that the supervisor allows a circuit its fill pressure."""
        if pressure >= self.pressure_soft:
            rule = f"must be less than controller.pressure_soft_pa = {self.pressure_soft:g}"
            fix = "lower the fill pressure or raise the limit"
            raise InputError(rule, key=key, value=f"{pressure:g}", fix=fix)


if TYPE_CHECKING:
    Quantity = str
else:
    Quantity = Literal[tuple(CHANNELS)]


class Sensor(Part):
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

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.period is not None and self.quantity != "position":
            rule, fix = "belongs to quantity = 'position'", "leave it out: all other sensors are read every tick"
            raise InputError(rule, key="sensors.period_s", value=f"{self.period:g}", fix=fix)
        if self.quantity is None:
            return self
        fix = "give the range of the sensor in SI units"
        if self.low is None or self.high is None:
            key = "sensors.low" if self.low is None else "sensors.high"
            raise InputError(f"is missing beside quantity = {self.quantity!r}", key=key, fix=fix)
        if self.low >= self.high or self.high <= 0:
            raise InputError(
                "must be positive and greater than low", key="sensors.high", value=f"{self.high:g}", fix=fix
            )
        return self
