"""The silhouette: its derivatives, and a body that another program has drawn, found again."""

import numpy as np
import pytest

import hypertuna as ht
from film.rendered import Scene, frames
from film.small import DEPTH, EYE, body, camera, fish
from hypertuna.description.robot import parse
from hypertuna.film.sections import body_of

POSE, ANGLE = np.array([-0.13, -0.02, 0.2]), np.array([0.1, -0.2, 0.25])
GROUPS = 3
EMPTY = np.array([9.0, 0.0, 0.0])


def test_derivatives_agree_with_differences() -> None:
    own, draw = body(fish()), np.random.default_rng(0)
    u = np.concatenate([[0.01, 0.02, 0.3], [0.2, -0.3, 0.4], [0.02, -0.03, 100.0]])
    place = np.column_stack([draw.uniform(-0.03, 0.32, 3000), draw.uniform(-0.05, 0.2, 3000)])
    pixels = np.column_stack([place, draw.normal(0, 0.2, (3000, 2)), np.zeros(3000)])
    by = own.draw(pixels, u, 0.002)["by"]
    for k in range(own.unknowns):
        step = 1e-6 * np.eye(own.unknowns)[k]
        high, low = (own.draw(pixels, u + sign * step, 0.002)["value"] for sign in (1, -1))
        difference = (high - low) / 2e-6
        off = np.abs(difference - by[:, k]) / np.abs(difference).max()
        assert np.quantile(off, 0.98) < 0.005  # the others lie where the nearest link changes


def test_a_hinge_is_an_angle_like_that_of_a_joint() -> None:
    document = ht.load("hypertuna").document()
    springs = {"stiffness_n_m_per_rad": 0.1, "damping_n_m_s_per_rad": 1e-3}
    document |= {"hinge": {"link": 7, **springs}, "sources": document["sources"] | {"hinge": "bench"}}
    own = body_of(parse(document))
    assert own.groups == ("I", "II", "hinge")
    assert own.share[:, 2].tolist() == [0.0] * 7 + [1.0]  # the last of eight links turns with it


def pixels_of(drawn, pose=POSE):
    """Pixels of a fish that is drawn in a pose, less the empty tank."""
    setting = Scene(EYE, drawn, depth=DEPTH, noise=0.0, exposure=0.0)
    with_fish = next(frames(setting, lambda t: (pose, ANGLE), [0.0])).astype(float)
    without = next(frames(setting, lambda t: (EMPTY, ANGLE), [0.0]))
    grid = np.stack(np.meshgrid(*(np.arange(n, dtype=float) for n in EYE.size)), axis=-1)
    place, lean = camera(EYE).sight(grid, DEPTH)
    return np.concatenate([place, lean, (without - with_fish)[..., np.newaxis]], axis=-1).reshape(-1, 5)


def fitted(own, pixels, pose=POSE, *, free=False):
    """Fit a body from a start that is 3 px and 3 deg off."""
    size = camera(EYE).pixel_size([240, 136], DEPTH)
    start = np.concatenate([pose + np.array([3 * size, -2 * size, 0.05]), np.zeros(3), [0.0, 0.0, 100.0]])
    precision = np.zeros(own.unknowns)
    precision[-3:-1] = 0.0 if free else 1e12
    stages = size * np.array([[4.0, 14.0], [1.8, 8.0], [0.35, 6.0]])
    return own.fit(pixels, start, (np.zeros(own.unknowns), precision), stages, 40.0).unknowns, size


def test_a_drawn_pose_is_found_again() -> None:
    """No pixel is shifted by a half: the renderer traces rays, the tracker draws distances."""
    drawn = fish()
    found, size = fitted(body(drawn), pixels_of(drawn))
    assert np.abs(found[:2] - POSE[:2]).max() < 0.05 * size
    assert np.abs(found[2] - POSE[2]) < np.radians(0.05)
    assert np.abs(np.degrees(found[3:6] - ANGLE)).max() < 0.2


def test_half_heights_matter_where_the_sight_is_oblique() -> None:
    drawn = fish()
    flat = body(drawn)
    flat.section[:, 1] = 0.0
    corner = np.array([0.2, 0.25, 0.2])  # of the picture
    pixels = pixels_of(drawn, corner)
    own, _ = fitted(body(drawn), pixels, corner)
    other, _ = fitted(flat, pixels, corner)
    off, worse = (np.abs(np.degrees(z[3:6] - ANGLE)).max() for z in (own, other))
    assert worse > 2 * off


@pytest.mark.parametrize(("size", "girth"), [(1.05, 1.0), (1.0, 1.1)])
def test_planted_errors_of_length_and_width_are_found(size, girth) -> None:
    drawn = fish()
    wrong = body(drawn)
    wrong.section[:, 0] *= girth**2 / size**2
    wrong.section[:, 1] /= size**2
    wrong = type(wrong)(wrong.length / size, wrong.share, wrong.section, wrong.groups)
    found, _ = fitted(wrong, pixels_of(drawn), free=True)
    assert found[6] == pytest.approx(np.log(size), abs=0.004)
    assert found[7] == pytest.approx(-np.log(girth), abs=0.01)
