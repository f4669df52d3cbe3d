"""The table of the pilot in a robot description: estimator, steering, and what it does when something fails."""

from __future__ import annotations

from collections.abc import Collection
from typing import Self

from pydantic import model_validator

from hypertuna.description.schema.base import (
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    PositiveFraction,
    Real,
    Text,
    entry,
    same_length,
)
from hypertuna.errors import InputError, did_you_mean


class Guidance(Part):
    """The pilot on board: where the robot is, where it goes, and when it comes home."""

    gaits: tuple[Text, ...] = entry(
        "gaits", "named gaits of the gait table, slowest first; between two of them everything is linear", min_length=1
    )
    speed: tuple[Positive, ...] | None = entry(
        "speed_m_s",
        "speed through the water of each of them (default: computed, joints by bandwidth)",
        "m/s",
        default=None,
    )
    decisions: Positive = entry("decisions_hz", "rate of decisions; it divides the control rate", "Hz")

    gravity_rate: Positive = entry("gravity_rate_1_s", "rate at which gravity pulls the attitude", "1/s")
    field_rate: Positive = entry("field_rate_1_s", "rate at which the magnetic field pulls the heading", "1/s")
    drift_max: PositiveDegrees = entry("drift_max_deg_s", "largest offset of a gyroscope that is believed", "deg/s")
    depth_rate: Positive = entry("depth_rate_1_s", "rate of the depth observer", "1/s")
    walk: Positive = entry("walk_m", "scatter of the dead reckoning after 1 s", "m")
    current_walk: Positive = entry("current_walk_m_s", "change of the current within 1 s, at random", "m/s")
    current_error: Positive = entry("current_error_m_s", "standard deviation of the current before any fix", "m/s")
    factor_error: PositiveFraction = entry("factor_error", "standard deviation of the speed over the gait table's")
    factor_walk: Positive = entry("factor_walk", "change of that factor within 1 s, at random")
    start_error: Positive = entry("start_error_m", "standard deviation of the start's position", "m")

    bias_max: tuple[PositiveDegrees, ...] = entry("bias_max_deg", "tail bias that steers, of each joint group", "deg")
    heading_rate: Positive = entry("heading_rate_1_s", "bandwidth of the heading loop", "1/s")
    turn_max: PositiveDegrees = entry("turn_max_deg_s", "fastest turn that it asks for", "deg/s")
    rate_gain: NotNegative = entry("rate_gain", "gain on what is missing of the rate of turn")
    heading_integral: NotNegative = entry("heading_integral_1_s", "rate of the integral in the heading loop", "1/s")
    lookahead: Positive = entry("lookahead_m", "distance of the point on the leg that it steers to", "m")
    depth_lookahead: Positive = entry("depth_lookahead_m", "the same along the way up or down", "m")
    climb_max: PositiveDegrees = entry("climb_max_deg", "steepest path that it asks for", "deg")
    pitch_max: PositiveDegrees = entry("pitch_max_deg", "pitch at which it asks for none", "deg")
    depth_integral: NotNegative = entry("depth_integral_1_s", "rate of the integral against a trim that is off", "1/s")
    climb_lead: Positive = entry("climb_lead", "fin angle per climb that is asked for")
    climb_gain: NotNegative = entry("climb_gain", "fin angle per climb that is missing")
    pitch_gain: Real = entry("pitch_gain", "fin angle against pitch")
    pitch_damping: NotNegative = entry("pitch_damping_s", "fin angle against the rate of pitch", "s")
    speed_min: Positive = entry("speed_min_m_s", "slowest speed that fins and tail steer at", "m/s")

    surface_depth: Positive = entry("surface_depth_m", "depth above which the robot counts as at the surface", "m")
    fence_margin: Positive = entry(
        "fence_margin_m", "distance to the fence, beside twice the position's error, at which the robot turns", "m"
    )
    error_max: Positive = entry("error_max_m", "position error at which it comes up for a fix", "m")
    error_near: Positive = entry("error_near_m", "the same near the fence", "m")
    error_lost: Positive = entry("error_lost_m", "position error without any fix at which it goes home", "m")
    drift_enough: Positive = entry("drift_enough_m_s", "error of the way per second that it begins a dive with", "m/s")
    patience: Positive = entry("patience_s", "longest wait at the surface for a fix", "s")
    retry: Positive = entry("retry_s", "time until it comes up again after a wait in vain", "s")
    sensor_timeout: Positive = entry("sensor_timeout_s", "time without readings after which a sensor is lost", "s")
    compass_patience: Positive = entry("compass_patience_s", "time that the gyroscope alone is trusted for", "s")
    fin_tilt: PositiveDegrees = entry("fin_tilt_deg", "roll that tells of a fin that does not follow", "deg")
    fin_least: PositiveDegrees = entry("fin_least_deg", "fin angle at which roll is watched", "deg")
    fin_after: Positive = entry("fin_after_s", "time of such roll after which the fin is lost", "s")
    fin_alone: PositiveDegrees = entry("fin_alone_deg", "largest angle of a fin that is left alone", "deg")
    answer_after: Positive = entry("answer_after_s", "time in which the depth must answer to fins at their limit", "s")
    answer_depth: Positive = entry("answer_depth_m", "change of depth that is an answer", "m")
    blind_fin: PositiveDegrees = entry("blind_fin_deg", "fin angle on the way up without depth or IMU", "deg")
    blind_speed: Positive = entry("blind_speed_m_s", "speed on the way up without an IMU", "m/s")
    power: Positive = entry("power_w", "electrical power at the fastest gait, for the way home", "W")
    overhead: NotNegative = entry("overhead_s", "time added to every way home", "s")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.speed is not None:
            if len(self.speed) != len(self.gaits):
                rule, fix = f"must be {len(self.gaits)} long, one per gait", "give a speed per gait, or none"
                value = f"{len(self.speed)} long"
                raise InputError(rule, key="guidance.speed_m_s", value=value, fix=fix)
            if any(a >= b for a, b in zip(self.speed, self.speed[1:], strict=False)):
                rule, fix = "must rise from gait to gait", "put the slowest gait first"
                raise InputError(rule, key="guidance.speed_m_s", value=f"{list(self.speed)}", fix=fix)
        for low, high in (("error_near", "error_max"), ("error_max", "error_lost")):
            below, above = getattr(self, low), getattr(self, high)
            if below > above:
                alias = type(self).model_fields[low].alias
                rule = f"must be at most {type(self).model_fields[high].alias}"
                raise InputError(rule, key=f"guidance.{alias}", value=f"{below:g}", fix="exchange the two")
        return self


def check_guidance(guidance: Guidance | None, gaits: Collection[str], groups: int) -> None:
    """Check that the pilot's gaits exist and that it has a tail bias for each joint group."""
    if guidance is None:
        return
    for k, name in enumerate(guidance.gaits):
        if name not in gaits:
            fix = did_you_mean(name, gaits)
            raise InputError("must be a named gait", key=f"guidance.gaits[{k}]", value=repr(name), fix=fix)
    same_length(guidance, "guidance", groups, "joint group", but=("gaits", "speed"))
