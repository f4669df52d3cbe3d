"""Films that were joined: a fish that jumps from one frame to the next is that of another take."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from hypertuna.arrays import Array
from hypertuna.trials.marker_run import Frames
from hypertuna.trials.tracks import MIN_SAMPLES

JUMP, STEPS = 0.1, 6.0  # lengths in a frame, and usual steps: farther is a jump


def split_takes(stretches: Sequence[Frames], place: Array, length: float) -> tuple[Frames, ...]:
    """Split frames at jumps of a place (frames, 2) [m] on a fish of a length [m]; leave out short parts."""
    parts: list[Frames] = []
    for own in stretches:
        step = np.linalg.norm(np.diff(place[own], axis=0), axis=1) / np.diff(own)
        far = step > max(JUMP * length, STEPS * float(np.median(step)))
        parts += np.split(own, np.flatnonzero(far) + 1)
    return tuple(part for part in parts if len(part) >= MIN_SAMPLES)


def jumps(stretches: Sequence[Frames], time: Array) -> list[str]:
    """Return what to tell of frames that follow each other in two recordings."""
    return [
        f"the fish jumps after {time[one[-1]]:.2f} s, so the film is taken as several recordings: were films joined?"
        for one, other in pairwise(stretches)
        if other[0] == one[-1] + 1
    ]
