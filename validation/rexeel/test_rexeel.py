"""The robot eel's free swims, replayed with coefficients from theory: README.md beside this file."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.measured import read_joints, read_tracks
from hypertuna.replay import replay, rmse
from hypertuna.smoothing import smooth

DATA = Path(os.environ.get("HYPERTUNA_DATA", Path(__file__).parents[3] / "shared" / "data")) / "rexeel"
BORDER = np.array([100, 100, 180 / math.pi])  # cm, cm, deg

FOUND = {10: (0.80, 2.13, 1.18), 30: (2.93, 6.89, 6.06)}  # rmse of x [cm], y [cm], yaw [deg]
REPEATABILITY = {10: (0.66, 0.66, 0.78), 30: (1.20, 0.96, 1.94)}  # as the authors report it
RUNS = {10: 21, 30: 20}

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(),
    reason=f"The eel's measured swims are not at {DATA}: set HYPERTUNA_DATA to the folder that holds rexeel/.",
)


def measured(amplitude):
    joints = read_joints(
        DATA / f"{amplitude}deg_hardware_motor_angles.csv",
        time="time_s",
        columns=[f"actual_{joint}" for joint in range(1, 6)],
        unit="deg",
    )
    tracks = read_tracks(
        DATA / f"{amplitude}deg_hardware_trajectories.csv",
        time="timestamp",
        pose=("x_cm", "y_cm", "robot_yaw"),
        run="video",
        length_unit="cm",
        angle_unit="deg",
        yaw_zero=math.pi,
        clockwise=True,
    )
    return joints, tracks


@pytest.mark.parametrize("amplitude", FOUND)
def test_head_follows_the_tracked_runs(amplitude):
    eel = ht.load("rexeel")
    joints, tracks = measured(amplitude)
    assert len(tracks) == RUNS[amplitude]
    result = replay(eel, joints)
    compared = rmse(eel, result, tracks)
    error = compared.rmse.to_numpy() * BORDER
    x, y, yaw = error
    print(f"{amplitude} deg: rmse of head x {x:.2f} cm, y {y:.2f} cm, yaw {yaw:.2f} deg")
    assert result.status == "completed"
    assert error == pytest.approx(FOUND[amplitude], rel=0.05)
    assert compared.repeatability.to_numpy() * BORDER == pytest.approx(REPEATABILITY[amplitude], rel=0.02)


@pytest.mark.parametrize("amplitude", FOUND)
def test_smoothing_and_step_hardly_matter(amplitude):
    eel = ht.load("rexeel")
    joints, tracks = measured(amplitude)
    error = rmse(eel, replay(eel, joints), tracks).rmse.to_numpy()
    finer = rmse(eel, replay(eel, joints, step=0.002), tracks).rmse.to_numpy()
    rough = rmse(eel, replay(eel, smooth(joints, noise=0)), tracks).rmse.to_numpy()
    assert finer == pytest.approx(error, rel=1e-3)
    assert rough == pytest.approx(error, rel=5e-3)
