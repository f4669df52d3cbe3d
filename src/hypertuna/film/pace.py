"""Whether a film runs at the pace at which it was filmed: slow motion shows a beat that the robot does not make."""

from hypertuna.description.robot import Robot


def pace_doubts(robot: Robot, beat: float | None, rate: float) -> list[str]:
    """Return a warning of a beat [Hz], in a film of a frame rate [Hz], outside the bounds of the robot's gaits."""
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
