"""The body of a run in motion: its last beats from above, as computed."""

import numpy as np

from hypertuna.arrays import Array
from hypertuna.display import number
from hypertuna.frames import rotation_of
from hypertuna.pictures import captioned
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.sea_run import SeaRun
from hypertuna.swimming.outline import bodies, film_svg, followed, water_step
from hypertuna.swimming.trajectory import body_points, group_shares

BEATS, FRAMES = 3, 20  # shown, and pictures of each
COARSE = 8  # rows of the record in a beat, below which the body cannot be drawn


def last_beats(run: TwinRun | SeaRun) -> str:
    """Return the body over the last beats of a run as an animated SVG, with a line that says which."""
    time, frequency = run.time, run.gait.frequency
    if len(time) < 2 or (time[1] - time[0]) * frequency * COARSE > 1:
        return captioned("", f"The body is not drawn: the record has fewer than {COARSE} rows a beat.")
    begin = max(time[0], time[-1] - BEATS / frequency)
    seconds = time[-1] - begin
    instants = np.linspace(begin, time[-1], round(FRAMES * seconds * frequency) + 1)
    columns = np.column_stack([_pose(run), run.data["angle"]])
    rows = np.stack([np.interp(instants, time, column) for column in columns.T], axis=1)
    pose, bends = rows[:, :3], rows[:, 3:]
    lines = body_points(run.robot, pose, bends @ group_shares(run.robot).T)
    shapes = bodies(run.robot, followed(lines, pose[:, 2]))
    step = water_step(run.robot, lines[:, 0], pose[:, 2]) / (seconds * frequency)
    film = film_svg(shapes, step, 1 / frequency, seconds, f"{run.robot.name} from above")
    span = f"{number(begin)} to {number(time[-1], 's')}"
    hinge = "" if run.robot.hinge is None else "; its passive hinge is drawn straight"
    return captioned(film, f"The last {seconds * frequency:.2g} beats from above, {span}, in real time{hinge}.")


def _pose(run: TwinRun | SeaRun) -> Array:
    """Return x, y [m] of the nose and the angle of the head's axis from above [rad] (T, 3)."""
    if isinstance(run, TwinRun):
        return np.column_stack([run.data[name] for name in ("x", "y", "heading")])
    axis = rotation_of(run.attitude)[:, :, 0]
    return np.column_stack([run.position[:, :2], np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))])
