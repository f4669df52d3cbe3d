"""Open digital twin and control stack for soft robotic fish."""

from hypertuna.description import Robot, load, robots
from hypertuna.errors import InputError
from hypertuna.gait import Gait, named_gait
from hypertuna.measured import JointSeries, Track, read_joints, read_tracks
from hypertuna.replay import Pose, SmoothSeries, replay, residuals, rmse, smooth
from hypertuna.sweep import Gaits, Gradient, gradient, sweep
from hypertuna.swim import Swim, swim

__all__ = [
    "Gait",
    "Gaits",
    "Gradient",
    "InputError",
    "JointSeries",
    "Pose",
    "Robot",
    "SmoothSeries",
    "Swim",
    "Track",
    "gradient",
    "load",
    "named_gait",
    "read_joints",
    "read_tracks",
    "replay",
    "residuals",
    "rmse",
    "robots",
    "smooth",
    "sweep",
    "swim",
]
