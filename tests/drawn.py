"""What must hold of a drawn figure."""

from collections.abc import Sequence

from matplotlib.transforms import BboxBase


def apart(boxes: Sequence[BboxBase]) -> bool:
    """Whether no box overlaps another."""
    return not any(one.overlaps(other) for k, one in enumerate(boxes) for other in boxes[:k])
