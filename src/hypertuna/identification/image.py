"""Image of a robot with samples of its fit or its estimates, with which a page shows how certain its numbers are."""

from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.identification.coefficients import sample_robots
from hypertuna.mission.image import robot_image
from hypertuna.simulation.image import spring_columns
from hypertuna.swimming import band
from hypertuna.swimming.model import model_columns

SAMPLES, SEED = 64, 0  # number and seed of the samples of a fit


def sampled_image(robot: Robot) -> bytes:
    """Return the image of a robot by `robot_image`, with samples of its own model if its numbers are uncertain.

    The samples are those of `speed_band` for a robot with estimates of known uncertainty, otherwise those of its table
    [fit]. Column ``samples.NAME`` (samples, n) replaces column NAME of model 0 for each sample. With estimates, the
    text has factors on the speed for the uncertainty of the water law.
    """
    estimates = band.sampled_columns(robot)
    if estimates is not None:
        samples = [model_columns(robot, columns) for columns in estimates[0]]
        facts: dict[str, Any] = {"seed": band.SEED, "speed_factors": estimates[1].tolist()}
    elif robot.fit is not None:
        samples = [model_columns(sample, {}) | spring_columns(sample) for sample in sample_robots(robot, SAMPLES, SEED)]
        facts = {"seed": SEED}
    else:
        return robot_image(robot)
    model = model_columns(robot, {}) | spring_columns(robot)
    columns = {}
    for name, values in model.items():
        drawn = np.array([np.ravel(sample.get(name, values)) for sample in samples])
        if (drawn != np.ravel(values)).any():
            columns[f"samples.{name}"] = drawn
    return robot_image(robot, columns, {"samples": {"count": len(samples)} | facts})
