"""Frames: cases by hand, round trips, and that poses and twists agree with each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hypertuna.errors import InputError
from hypertuna.frames import Frame, pose_from, pose_to, twist_from, twist_to

FRAMES: tuple[Frame, ...] = ("ned", "enu")
TRIPLES = st.tuples(*[st.floats(-10, 10)] * 3)

# Ours (tail direction) to theirs (facing direction), with x east and y north.
BY_HAND = [
    ("ned", (1.0, 2.0, -np.pi / 2), (2.0, 1.0, 0.0)),  # tail south, facing north: heading 0
    ("ned", (1.0, 2.0, np.pi), (2.0, 1.0, -3 * np.pi / 2)),  # facing east: heading 90 degrees, less a turn
    ("enu", (1.0, 2.0, -np.pi), (1.0, 2.0, 0.0)),  # facing east: yaw 0
    ("enu", (1.0, 2.0, -np.pi / 2), (1.0, 2.0, np.pi / 2)),  # facing north
]


@pytest.mark.parametrize(("frame", "ours", "theirs"), BY_HAND)
def test_poses_by_hand(frame: Frame, ours: tuple[float, ...], theirs: tuple[float, ...]) -> None:
    assert pose_to(frame, ours) == pytest.approx(theirs)


def test_twists_by_hand() -> None:
    forward, toward_y, turning_left = np.diag([-1.0, 1.0, 1.0])
    assert twist_to("ned", forward) == pytest.approx([1, 0, 0])
    assert twist_to("ned", toward_y) == pytest.approx([0, 1, 0])  # facing -x with y to the right: starboard
    assert twist_to("ned", turning_left) == pytest.approx([0, 0, -1])
    assert twist_to("enu", forward) == pytest.approx([1, 0, 0])
    assert twist_to("enu", toward_y) == pytest.approx([0, -1, 0])
    assert twist_to("enu", turning_left) == pytest.approx([0, 0, 1])


def world_rate(heading: float, twist: np.ndarray) -> np.ndarray:
    """Rate of a planar pose whose body axes stand at a heading: Fossen's eta' = R(psi) nu."""
    c, s = np.cos(heading), np.sin(heading)
    return np.array([c * twist[0] - s * twist[1], s * twist[0] + c * twist[1], twist[2]])


@pytest.mark.parametrize("frame", FRAMES)
@given(pose=TRIPLES, twist=TRIPLES)
def test_twist_is_the_rate_of_pose_in_every_frame(
    frame: Frame, pose: tuple[float, ...], twist: tuple[float, ...]
) -> None:
    ours, theirs = np.array(pose), pose_to(frame, pose)
    moved = pose_to(frame, ours + world_rate(ours[2], np.array(twist)))  # the map is affine: a step shows the rate
    assert moved - theirs == pytest.approx(world_rate(theirs[2], twist_to(frame, twist)), abs=1e-12)


@pytest.mark.parametrize("frame", FRAMES)
@given(rows=st.lists(TRIPLES, min_size=1, max_size=4))
def test_round_trip(frame: Frame, rows: list[tuple[float, ...]]) -> None:
    values = np.array(rows)
    assert pose_from(frame, pose_to(frame, values)) == pytest.approx(values, abs=1e-14)
    assert twist_from(frame, twist_to(frame, values)) == pytest.approx(values, abs=0)


def test_bad_input_gives_one_sentence() -> None:
    with pytest.raises(InputError, match=r"^frame must be a known frame, but is 'nad': did you mean ned\?$"):
        pose_to("nad", np.zeros(3))  # type: ignore[arg-type]
    for bad in (1.0, [1.0, 2.0], np.zeros((3, 2))):
        with pytest.raises(InputError, match=r"^twist must have shape \(\.\.\., 3\), but is of shape"):
            twist_from("ned", bad)
