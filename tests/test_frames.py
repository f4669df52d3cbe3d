"""Frames: cases by hand, round trips, and that poses and twists agree with each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hypertuna.errors import InputError
from hypertuna.frames import (
    Frame,
    angles_of,
    attitude_from,
    attitude_of,
    attitude_to,
    pose_from,
    pose_to,
    rotation_of,
    twist_from,
    twist_to,
)

FRAMES: tuple[Frame, ...] = ("ned", "enu")
TRIPLES = st.tuples(*[st.floats(-10, 10)] * 3)

# Rotations of vectors from our axes to theirs, of the world (east, north, up) and of the body (tail, starboard, up).
AXES = {
    "ned": (np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]), np.diag([-1.0, 1, -1])),
    "enu": (np.eye(3), np.diag([-1.0, -1, 1])),
}

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


# Roll, pitch, heading in degrees; where nose, starboard side and back point: east, north, up.
ATTITUDES = [
    ((0, 0, 0), (0, 1, 0), (1, 0, 0), (0, 0, 1)),  # to the north: starboard is east
    ((0, 0, 90), (1, 0, 0), (0, -1, 0), (0, 0, 1)),
    ((0, 90, 0), (0, 0, 1), (1, 0, 0), (0, -1, 0)),  # nose up
    ((90, 0, 0), (0, 1, 0), (0, 0, -1), (1, 0, 0)),  # starboard side down
    ((0, 30, 180), (0, -np.sqrt(0.75), 0.5), (-1, 0, 0), (0, 0.5, np.sqrt(0.75))),
]


@pytest.mark.parametrize(("angles", "nose", "starboard", "back"), ATTITUDES)
def test_attitudes_by_hand(angles: tuple[float, ...], nose: tuple[float, ...], starboard: object, back: object) -> None:
    roll, pitch, heading = np.radians(angles)
    r = rotation_of(attitude_of(roll=roll, pitch=pitch, heading=heading))
    assert -r[:, 0] == pytest.approx(nose, abs=1e-12)  # our x points to the tail
    assert r[:, 1] == pytest.approx(starboard, abs=1e-12)
    assert r[:, 2] == pytest.approx(back, abs=1e-12)


@given(roll=st.floats(-3, 3), pitch=st.floats(-1.5, 1.5), heading=st.floats(0, 6.28))
def test_angles_are_those_of_the_attitude(roll: float, pitch: float, heading: float) -> None:
    q = attitude_of(roll=roll, pitch=pitch, heading=heading)
    assert np.linalg.norm(q) == pytest.approx(1, abs=1e-14)
    found = angles_of(q)
    assert np.exp(1j * found) == pytest.approx(np.exp(1j * np.array([roll, pitch, heading])), abs=1e-12)
    assert not np.signbit(angles_of([0.0, 0.0, 0.0, 1.0])).any()  # no minus before a zero


@pytest.mark.parametrize("frame", FRAMES)
@given(q=st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1), v=TRIPLES)
def test_attitudes_turn_the_same_vector_in_every_frame(
    frame: Frame, q: tuple[float, ...], v: tuple[float, ...]
) -> None:
    ours = np.array(q) / np.linalg.norm(q)
    theirs = attitude_to(frame, ours)
    world, body = AXES[frame]
    assert rotation_of(theirs) @ body @ v == pytest.approx(world @ rotation_of(ours) @ v, abs=1e-12)
    back = attitude_from(frame, theirs)
    assert min(abs(back - ours).max(), abs(back + ours).max()) < 1e-14


@pytest.mark.parametrize("frame", FRAMES)
@given(heading=st.floats(-3, 3), twist=TRIPLES)
def test_in_the_plane_space_is_planar(frame: Frame, heading: float, twist: tuple[float, ...]) -> None:
    level = np.array([np.cos(heading / 2), 0, 0, np.sin(heading / 2)])
    theirs = pose_to(frame, [0.0, 0.0, heading])[2]
    expected = [np.cos(theirs / 2), 0, 0, np.sin(theirs / 2)]
    got = attitude_to(frame, level)
    assert min(abs(got - expected).max(), abs(got + np.array(expected)).max()) < 1e-12
    u, v, r = twist_to(frame, twist)
    assert (AXES[frame][1] @ [twist[0], twist[1], 0.0])[:2] == pytest.approx([u, v], abs=1e-12)
    assert (AXES[frame][1] @ [0.0, 0.0, twist[2]])[2] == pytest.approx(r, abs=1e-12)
