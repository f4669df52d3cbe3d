"""Calibration of accelerometer, gyroscope and compass on synthetic counts: what is known comes back, or is refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hypertuna.errors import InputError
from hypertuna.radio.imu import (
    FACES,
    POSITIONS,
    calibrate_accelerometer,
    calibrate_compass,
    calibrate_gyroscope,
    covered,
    fit_sphere,
)

GRAVITY = 9.80665
DIP = math.radians(60)
FIELD = np.array([0.0, math.cos(DIP), -math.sin(DIP)])  # world: east, north, up
UP = np.array([0.0, 0.0, GRAVITY])
ZERO, SCALE = np.array([400.0, -250.0, 130.0]), np.array([1 / 900, 1 / 1000, 1 / 1150])


def turned(count: int, seed: int = 0) -> Rotation:
    """Attitudes of a robot that is turned in all directions."""
    return Rotation.random(count, random_state=seed)


def compass_counts(attitude: Rotation, noise: float, seed: int = 1) -> np.ndarray:
    read = attitude.inv().apply(FIELD)
    read += noise * np.random.default_rng(seed).standard_normal(read.shape)
    return np.rint(read / SCALE + ZERO)


def test_faces_are_a_dodecahedrons() -> None:
    assert np.linalg.norm(FACES, axis=1) == pytest.approx(1)
    angles = np.degrees(np.arccos(np.clip(FACES @ FACES.T, -1, 1)))
    assert set(np.rint(angles[0])) == {0, 63, 117, 180}
    assert covered(FACES) == 12
    assert covered(np.array([[0.0, 0.0, 1.0]])) == 1


@given(
    st.integers(0, 1000),
    st.tuples(*[st.floats(-2000, 2000)] * 3),
    st.tuples(*[st.floats(0.8, 1.15)] * 3),
    st.floats(100, 16000),
)
@settings(max_examples=40, deadline=None)
def test_a_turned_compass_gives_its_iron_back(seed: int, zero: tuple, ratio: tuple, counts: float) -> None:
    """Any offset and any scales, 1 % noise: the heading is right within a degree, zero and scales within 2 %."""
    attitude = turned(300, seed)
    read = attitude.inv().apply(FIELD)
    noisy = read + 0.01 * np.random.default_rng(seed).standard_normal(read.shape)
    scale = np.array(ratio) / counts
    sphere = fit_sphere(noisy / scale + np.array(zero), 1.0)
    assert sphere is not None
    again = sphere.readings(read / scale + np.array(zero))
    assert np.abs(again - read).max() < 0.02
    assert sphere.rms == pytest.approx(0.01, rel=0.25)
    calibration = calibrate_compass(noisy / scale + np.array(zero))
    assert calibration.parameters["field_scale_1"] == pytest.approx(scale[1], rel=0.02)


def test_outliers_do_not_move_the_compass() -> None:
    counts = compass_counts(turned(300), 0.01)
    counts[::50] += 60  # 6 samples near a tool
    parameters = calibrate_compass(counts).parameters
    for k in range(3):
        assert abs(parameters[f"field_zero_{k}"] - ZERO[k]) * SCALE[k] < 0.015


def test_standard_error_is_that_of_many_runs() -> None:
    """The zeros scatter over 200 runs as the fit says of one, or less: outliers weigh less than it reckons with."""
    attitude = turned(60)
    fits = [fit_sphere(compass_counts(attitude, 0.02, seed), 1.0) for seed in range(200)]
    scatter = np.max(np.std([fit.zero * SCALE for fit in fits if fit], axis=0))
    assert scatter < np.mean([fit.error for fit in fits if fit]) < 1.5 * scatter


def level(count: int, tilt_deg: float) -> Rotation:
    """Attitudes of a robot that turns on the spot, tilted a little."""
    rng = np.random.default_rng(3)
    yaw = rng.uniform(0, 360, count)
    tilt = rng.uniform(-tilt_deg, tilt_deg, (count, 2))
    return Rotation.from_euler("ZYX", np.column_stack([yaw, tilt]), degrees=True)


@pytest.mark.parametrize("tilt", [0.0, 1.0, 5.0, 15.0])
@pytest.mark.parametrize("noise", [0.0, 0.003, 0.01])
def test_a_compass_that_only_turns_level_is_refused(tilt: float, noise: float) -> None:
    with pytest.raises(InputError, match=r"compass must (get samples that determine|be turned in all directions)"):
        calibrate_compass(compass_counts(level(500, tilt), noise))


def test_a_half_sphere_is_refused() -> None:
    counts = compass_counts(turned(400), 0.01)
    seen = (counts - ZERO) * SCALE
    with pytest.raises(
        InputError, match=r"compass must be turned in all directions, but is turned in \d of 12 directions"
    ):
        calibrate_compass(counts[seen[:, 2] > 0.1])


def test_a_disturbed_field_is_refused() -> None:
    """A field of 20 % beside a pump, in the world and not on board: its strength is not constant."""
    attitude = turned(300)
    read = attitude.inv().apply(FIELD * np.random.default_rng(5).uniform(0.7, 1.3, (300, 1)))
    with pytest.raises(InputError, match="compass must read a field of constant strength, but is off by"):
        calibrate_compass(read / SCALE + ZERO)


def test_a_stuck_axis_and_few_samples_are_refused() -> None:
    counts = compass_counts(turned(300), 0.01)
    counts[:, 1] = 7
    with pytest.raises(InputError, match="must get samples that determine all axes"):
        calibrate_compass(counts)
    with pytest.raises(InputError, match="must have at least 20 samples, but is limited to 19"):
        calibrate_compass(compass_counts(turned(19), 0.01))


def test_compass_and_accelerometer_must_have_the_same_axes() -> None:
    """An axis of the compass with the other sign, or two axes changed, fit a sphere as well; the dip does not."""
    attitude = turned(300)
    counts, gravity = compass_counts(attitude, 0.01), attitude.inv().apply(UP)
    notes = calibrate_compass(counts, gravity).notes
    assert notes == ("12 of 12 directions are covered", "the field dips by 60 +- 1 deg")
    for wrong in (counts * (1, 1, -1), counts[:, [1, 0, 2]], counts[:, [1, 2, 0]]):
        with pytest.raises(InputError, match="must read the field at a constant angle to gravity, but is off by"):
            calibrate_compass(wrong, gravity)
    with pytest.raises(InputError, match="must be turned without jerks"):
        calibrate_compass(counts, 2 * gravity)


def held(noise_deg: float = 3.0, seed: int = 0) -> dict:
    """Mean counts of every position, held by hand."""
    rng = np.random.default_rng(seed)
    oblique = {"nose half up": (-1, 0, 1), "rolled half to starboard": (0, -1, 1)}
    means = {}
    for position in POSITIONS:
        up = np.array(position.up or oblique.get(position.text, (1, 1, 1)), float)
        up = Rotation.from_rotvec(np.radians(noise_deg) * rng.standard_normal(3)).apply(up / np.linalg.norm(up))
        means[position] = GRAVITY * up / ACCEL_SCALE + ACCEL_ZERO
    return means


ACCEL_ZERO, ACCEL_SCALE = np.array([30.0, -55.0, 90.0]), 157 / 32768 * np.array([1.02, 0.99, 0.97])


def test_nine_positions_give_the_accelerometer_back() -> None:
    """Held by hand within some degrees: only the size of gravity counts, so that the fit is exact."""
    fit = calibrate_accelerometer(held())
    for k in range(3):
        assert fit.parameters[f"accel_zero_{k}"] == pytest.approx(ACCEL_ZERO[k], abs=0.1)
        assert fit.parameters[f"accel_scale_{k}"] == pytest.approx(ACCEL_SCALE[k], rel=1e-3)
    assert fit.rms < 1e-3


def test_an_accelerometer_that_moves_or_is_turned_is_refused() -> None:
    means = held()
    shaken = {position: mean * (1 + 0.2 * (k % 3 == 0)) for k, (position, mean) in enumerate(means.items())}
    with pytest.raises(InputError, match="accelerometer must"):
        calibrate_accelerometer(shaken)
    for wrong in ([1, 0, 2], [2, 1, 0]):
        with pytest.raises(
            InputError, match=r"must read gravity along [+-][xyz] when the robot is held (level|on its|nose)"
        ):
            calibrate_accelerometer({position: mean[wrong] for position, mean in means.items()})
    swapped = dict(zip(means, [*list(means.values())[1::-1], *list(means.values())[2:]], strict=True))
    with pytest.raises(InputError, match="must read gravity along"):
        calibrate_accelerometer(swapped)


def test_a_gyroscope_that_rests_gives_its_zeros() -> None:
    rng = np.random.default_rng(0)
    scale = np.full(3, 34.9 / 32768)
    counts = np.rint(rng.normal((8, -3, 15), 2.0, (200, 3)))
    fit = calibrate_gyroscope(counts, scale)
    assert [fit.parameters[f"rate_zero_{k}"] for k in range(3)] == pytest.approx([8, -3, 15], abs=0.6)
    assert fit.reading == (pytest.approx(2e-3, rel=0.2), "rad/s")
    with pytest.raises(InputError, match="gyroscope must be at rest, but is turning by"):
        calibrate_gyroscope(counts + 10 * np.linspace(0, 1, 200)[:, None], scale)
    with pytest.raises(InputError, match="gyroscope must be at rest"):
        calibrate_gyroscope(rng.normal(0, 40, (200, 3)), scale)
