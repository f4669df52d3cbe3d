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

    rate: Positive = entry("rate_hz", "control rate", "Hz")
    convergence: Positive = entry("convergence_1_s", "rate at which an oscillator converges to its limit cycle", "1/s")
    coupling: Positive = entry("coupling_1_s", "rate at which oscillators converge to their phase difference", "1/s")
    smoothing: Positive = entry(
        "smoothing_s", "time constant with which amplitude, bias and frequency follow a command", "s"
    )
    proportional: NotNegative = entry("proportional", "proportional gain on the error of a beat's peak bend")
    integral: NotNegative = entry("integral", "integral gain per beat")
    derivative: NotNegative = entry("derivative", "derivative gain, in beats")
    peak_smoothing: Positive = entry(
        "peak_smoothing", "time constant of the low-pass filter ahead of the peaks, in beats"
    )
    frequency_max: Positive = entry("frequency_max_hz", "highest beat frequency of a command", "Hz")
    fin_max: PositiveDegrees = entry("fin_max_deg", "largest angle of the pectoral fins to either side", "deg")
    voltage_low: Positive = entry("voltage_low_v", "battery voltage below which the status warns", "V")
    pressure_step: Positive = entry(
        "pressure_step_pa", "largest change within a tick beside the pump's; a larger one is a faulty sensor", "Pa"
    )
    pressure_soft: Positive = entry("pressure_soft_pa", "pressure to which the supervisor limits commands", "Pa")
    pressure_hard: Positive = entry("pressure_hard_pa", "pressure at which a circuit is released for good", "Pa")
    timeout: Positive = entry("timeout_s", "time without a command after which the tail rests", "s")
    pulse_center: Microseconds = entry("pulse_center_us", "servo pulse of the neutral angle", "us")
    pulse_per_rad: Microseconds = entry("pulse_us_per_rad", "change of the servo pulse per angle", "us/rad")
    pulse_min: Microseconds = entry("pulse_min_us", "shortest servo pulse", "us")
    pulse_max: Microseconds = entry("pulse_max_us", "longest servo pulse", "us")
    slew: Positive = entry("slew_rad_s", "largest rate of the commanded servo angle", "rad/s")

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

    measures: Text = entry("measures", "quantity that is measured, in words")
    part: Text = entry("part", "part number")
    quantity: Quantity | None = entry(
        "quantity",
        "channel of the twin; rate and acceleration of an IMU, field of a compass in units of its strength, position "
        "of a satellite receiver",
        default=None,
    )
    low: Real | None = entry("low", "lower end of its range, in SI units of the quantity", default=None)
    high: Real | None = entry("high", "upper end of its range, in SI units", default=None)
    noise: NotNegative = entry("noise", "standard deviation of its noise, in SI units", default=0.0)
    resolution: NotNegative = entry("resolution", "step of its quantization, in SI units", default=0.0)
    drift: NotNegative = entry("drift", "standard deviation of its random walk after 1 s, in SI units", default=0.0)
    bias: NotNegative = entry("bias", "standard deviation of its constant offset, in SI units", default=0.0)
    nonlinearity: NotNegative = entry(
        "nonlinearity", "largest deviation from a line, as a fraction of its range", default=0.0
    )
    period: Positive | None = entry(
        "period_s", "time between two fixes, for quantity = 'position' only", "s", default=None
    )

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
