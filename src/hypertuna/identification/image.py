"""Image of a fitted robot: with samples of its coefficients, so that a page can show how certain its numbers are."""

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.identification.coefficients import sample_robots
from hypertuna.mission.image import robot_image
from hypertuna.swimming.model import model_columns

SAMPLES, SEED = 64, 0


def fitted_image(robot: Robot) -> bytes:
    """Return the image of a robot, as `robot_image`; of one with a table [fit], with samples of its own model.

    Column ``samples.NAME`` (samples, n) has what model 0 has in its column NAME, for each sample.
    """
    if robot.fit is None:
        return robot_image(robot)
    samples = [model_columns(one, {}) for one in sample_robots(robot, SAMPLES, SEED)]
    own = model_columns(robot, {})
    changed = [name for name in own if any(not np.array_equal(one[name], own[name]) for one in samples)]
    columns = {f"samples.{name}": np.array([np.ravel(one[name]) for one in samples]) for name in changed}
    return robot_image(robot, columns, {"samples": {"count": SAMPLES, "seed": SEED}})
