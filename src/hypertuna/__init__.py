"""Open digital twin and control stack for soft robotic fish."""

from hypertuna.actuation.bending import Bend, bend
from hypertuna.description.robot import Robot, load, robots
from hypertuna.errors import InputError
from hypertuna.identification.identify import Fit, identify
from hypertuna.mission.file import MissionFile, read_mission
from hypertuna.mission.flight import Flight, fly
from hypertuna.optimization.constraints import Limit, gait_limits
from hypertuna.optimization.optimize import Optimum, optimize
from hypertuna.optimization.pareto import Front, pareto
from hypertuna.reports.results import report
from hypertuna.simulation.dive import Dive, Leg, dive
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.sea import Sea
from hypertuna.simulation.sea_run import SeaRun
from hypertuna.simulation.sea_twin import twin_at_sea
from hypertuna.simulation.twin import twin, twins
from hypertuna.swimming.gait import Gait, named_gait
from hypertuna.swimming.sweep import Gaits, Gradient, gradient, sweep
from hypertuna.swimming.swim import Swim, swim
from hypertuna.swimming.turn import Turning, turn
from hypertuna.trials.comparison import compare_recording, replay_recording
from hypertuna.trials.replay import Pose, replay, residuals, rmse
from hypertuna.trials.smoothing import SmoothSeries, smooth
from hypertuna.trials.tracks import JointSeries, Track, read_joints, read_tracks
from hypertuna.trials.trials import Recording, SteadyRun, Trials, read_trials

__all__ = [
    "Bend",
    "Dive",
    "Fit",
    "Flight",
    "Front",
    "Gait",
    "Gaits",
    "Gradient",
    "InputError",
    "JointSeries",
    "Leg",
    "Limit",
    "MissionFile",
    "Optimum",
    "Pose",
    "Recording",
    "Robot",
    "Sea",
    "SeaRun",
    "SmoothSeries",
    "SteadyRun",
    "Swim",
    "Track",
    "Trials",
    "Turning",
    "TwinRun",
    "bend",
    "compare_recording",
    "dive",
    "fly",
    "gait_limits",
    "gradient",
    "identify",
    "load",
    "named_gait",
    "optimize",
    "pareto",
    "read_joints",
    "read_mission",
    "read_tracks",
    "read_trials",
    "replay",
    "replay_recording",
    "report",
    "residuals",
    "rmse",
    "robots",
    "smooth",
    "sweep",
    "swim",
    "turn",
    "twin",
    "twin_at_sea",
    "twins",
]
