"""Detect slow motion, which shows a beat outside the robot's range, and frames that were made from others."""

from itertools import islice, pairwise

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.film.source import Film
from hypertuna.trials.head_motion import raised_by

FRAMES, REDUCED, CHANGED = 90, 4, 0.999  # that are compared; how many times smaller; quantile of pixels that change


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


def check_made(film: Film) -> None:
    """Check that frames of a film were filmed, and not made from others to raise its frame rate."""
    import cv2

    first, part = max((len(film.time) - FRAMES) // 2, 0), 1 / REDUCED
    pictures = [
        cv2.resize(picture, None, fx=part, fy=part, interpolation=cv2.INTER_AREA).astype(np.int16)
        for _, picture in islice(film.frames(first), FRAMES)
    ]
    steps = [after - before for before, after in pairwise(pictures)]
    for what, changes in (("repeat others", steps), ("lie between others", [b - a for a, b in pairwise(steps)])):
        factor = raised_by(np.array([np.quantile(np.abs(change), CHANGED) for change in changes]))
        if factor > 1:
            rule, value = "must have frames that were filmed", f"with {100 * (1 - 1 / float(factor)):.0f} % that {what}"
            fix = "was the frame rate raised? Give the film as the camera wrote it, or the frames that were filmed: "
            fix += f"ffmpeg -i FILM -vf fps={film.rate / factor:.4g} film.mp4"
            raise InputError(rule, file=film.file, value=value, fix=fix)
