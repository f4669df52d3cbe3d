"""Detect slow motion: it shows a beat outside the robot's range."""

from hypertuna.description.robot import Robot


def pace_warnings(robot: Robot, beat: float | None, rate: float) -> list[str]:
    """Return a warning if the beat [Hz] is outside the bounds of the robot's gaits; rate: frames per second [Hz]."""
    bounds = robot.gait_bounds
    if beat is None or bounds is None:
        return []
    low, high = bounds.frequency
    if low <= beat <= high:
        return []
    beats = f"the beat of {beat:.3g} Hz is outside the robot's {low:g} to {high:g} Hz"
    return [
        f"{beats}: is the film slow motion, or sped up? Then give the rate of filming by --frame-rate, not {rate:.4g}"
    ]
