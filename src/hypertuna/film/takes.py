"""Split a film that was joined from several takes: a new take begins where the fish jumps between two frames."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from hypertuna.arrays import Array
from hypertuna.trials.marker_run import Frames
from hypertuna.trials.tracks import MIN_SAMPLES

JUMP, JUMP_STEPS = 0.1, 6.0  # a longer step than both is a jump: body lengths; multiples of the median step


def split_takes(stretches: Sequence[Frames], place: Array, length: float) -> tuple[Frames, ...]:
    """Split stretches of frames where the fish's place (frames, 2) [m] jumps; drop short parts. length: fish's [m]."""
    parts: list[Frames] = []
    for frames in stretches:
        step = np.linalg.norm(np.diff(place[frames], axis=0), axis=1) / np.diff(frames)
        far = step > max(JUMP * length, JUMP_STEPS * float(np.median(step)))
        parts += np.split(frames, np.flatnonzero(far) + 1)
    return tuple(part for part in parts if len(part) >= MIN_SAMPLES)


def jumps(stretches: Sequence[Frames], time: Array) -> list[str]:
    """Return a warning for each jump of the fish, with the time [s] of the last frame before it."""
    return [
        f"the fish jumps after {time[one[-1]]:.2f} s, so the film is taken as several recordings: were films joined?"
        for one, other in pairwise(stretches)
        if other[0] == one[-1] + 1
    ]
