"""Image of a robot with samples of its fit or of its estimates, so that a page can show how certain its numbers are."""

from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.identification.coefficients import sample_robots
from hypertuna.mission.image import robot_image
from hypertuna.swimming import band
from hypertuna.swimming.model import model_columns

SAMPLES, SEED = 64, 0  # of a fit


def sampled_image(robot: Robot) -> bytes:
    """Return the image of a robot, as `robot_image`, with samples of its own model if its numbers are uncertain.

    The samples are those of `speed_band` for a robot with estimates of known uncertainty, otherwise those of its table
    [fit]. Column ``samples.NAME`` (samples, n) has what model 0 has in its column NAME, for each sample. The text holds
    the factors of the speed by the law, with estimates.
    """
    estimates = band.sampled_columns(robot)
    if estimates is not None:
        samples = [model_columns(robot, columns) for columns in estimates[0]]
        facts: dict[str, Any] = {"seed": band.SEED, "speed_factors": estimates[1].tolist()}
    elif robot.fit is not None:
        samples = [model_columns(sample, {}) for sample in sample_robots(robot, SAMPLES, SEED)]
        facts = {"seed": SEED}
    else:
        return robot_image(robot)
    model = model_columns(robot, {})
    changed = [name for name in model if any(not np.array_equal(sample[name], model[name]) for sample in samples)]
    columns = {f"samples.{name}": np.array([np.ravel(sample[name]) for sample in samples]) for name in changed}
    return robot_image(robot, columns, {"samples": {"count": len(samples)} | facts})
