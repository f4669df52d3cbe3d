"""The tables of the controller and its sensors in a robot description."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import model_validator

from hypertuna.description.schema.base import (
    Microseconds,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    Real,
    Text,
    entry,
)
from hypertuna.errors import InputError


class Controller(Part):
    """The controller on board: oscillators, posture control per beat, pressure supervisor, servo pulses."""

    rate: Positive = entry("rate_hz", "control rate", "Hz")
    convergence: Positive = entry("convergence_1_s", "rate at which an oscillator returns to its cycle", "1/s")
    coupling: Positive = entry("coupling_1_s", "rate at which oscillators take up their phase difference", "1/s")
    smoothing: Positive = entry("smoothing_s", "time in which amplitude, bias and frequency follow a new command", "s")
    proportional: NotNegative = entry("proportional", "proportional gain on a beat's error of the peak bend")
    integral: NotNegative = entry("integral", "integral gain, per beat")
    derivative: NotNegative = entry("derivative", "derivative gain, in beats")
    peak_smoothing: Positive = entry(
        "peak_smoothing", "time constant of the low-pass that a beat's peaks are taken behind, in beats"
    )
    frequency_max: Positive = entry("frequency_max_hz", "highest beat frequency that a command may ask for", "Hz")
    fin_max: PositiveDegrees = entry("fin_max_deg", "largest angle of the pectoral fins to either side", "deg")
    voltage_low: Positive = entry("voltage_low_v", "battery voltage below which the status warns", "V")
    pressure_step: Positive = entry(
        "pressure_step_pa", "change within a tick, beyond what the pump explains, that no sound sensor shows", "Pa"
    )
    pressure_soft: Positive = entry("pressure_soft_pa", "pressure that the supervisor lets no command exceed", "Pa")
    pressure_hard: Positive = entry("pressure_hard_pa", "pressure at which a circuit is released and stays so", "Pa")
    timeout: Positive = entry("timeout_s", "time without a command after which the tail comes to rest", "s")
    pulse_center: Microseconds = entry("pulse_center_us", "servo pulse of the neutral angle", "us")
    pulse_per_rad: Microseconds = entry("pulse_us_per_rad", "change of the servo pulse per angle", "us/rad")
    pulse_min: Microseconds = entry("pulse_min_us", "shortest servo pulse", "us")
    pulse_max: Microseconds = entry("pulse_max_us", "longest servo pulse", "us")
    slew: Positive = entry("slew_rad_s", "fastest change of the servo angle that is commanded", "rad/s")

    @model_validator(mode="after")
    def _check(self) -> Self:
        for low, high in (
            ("pressure_soft", "pressure_hard"),
            ("pulse_min", "pulse_center"),
            ("pulse_center", "pulse_max"),
        ):
            below, above = getattr(self, low), getattr(self, high)
            if below >= above:
                alias = type(self).model_fields[low].alias
                rule = f"must be less than {type(self).model_fields[high].alias}"
                raise InputError(rule, key=f"controller.{alias}", value=f"{below:g}", fix="exchange the two")
        return self

    def check_fill(self, pressure: float, key: str) -> None:
        """Refuse a fill pressure that the supervisor does not let a circuit have, even at rest."""
        if pressure >= self.pressure_soft:
            rule = f"must be less than controller.pressure_soft_pa = {self.pressure_soft:g}"
            fix = "fill with less, or let the supervisor allow more"
            raise InputError(rule, key=key, value=f"{pressure:g}", fix=fix)


Quantity = Literal["bend", "pressure", "current", "rate", "acceleration", "voltage", "depth", "field", "position"]


class Sensor(Part):
    """Sensors of one kind, and what they get wrong."""

    measures: Text = entry("measures", "quantity that is measured, in words")
    part: Text = entry("part", "part number")
    quantity: Quantity | None = entry(
        "quantity",
        "channel of the twin that it feeds; the IMU has rate and acceleration, a compass the field in units of its "
        "strength, a satellite receiver the position",
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
    period: Positive | None = entry("period_s", "time between two fixes, of a position alone", "s", default=None)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.period is not None and self.quantity != "position":
            rule, fix = "belongs to quantity = 'position'", "leave it out: what else is read is read in every tick"
            raise InputError(rule, key="sensors.period_s", value=f"{self.period:g}", fix=fix)
        if self.quantity is None:
            return self
        for name, end in (("low", self.low), ("high", self.high)):
            if end is None:
                rule, fix = f"is needed with quantity = {self.quantity!r}", "give the range of the sensor in SI units"
                raise InputError(rule, key=f"sensors.{name}", fix=fix)
        if self.low >= self.high or self.high <= 0:  # type: ignore[operator]
            rule, fix = "must be positive and more than low", "give the range of the sensor in SI units"
            raise InputError(rule, key="sensors.high", value=f"{self.high:g}", fix=fix)
        return self
