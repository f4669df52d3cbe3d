"""The fit's uncertainty that the studio shows is Python's own: samples of the same seed, and their quantiles."""

from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from host_library import InNode
from host_library import Robot as InHost
from hypertuna.description.robot import parse
from hypertuna.identification.coefficients import sample_robots
from hypertuna.identification.image import SAMPLES, SEED, fitted_image
from hypertuna.mission.image import robot_image
from hypertuna.simulation.image_body import _knobs, with_factors
from hypertuna.swimming.gait import Gait
from image_file import columns_of, text_of
from studio_code import Page

QUANTITIES = ["speed", "mechanical_power", "cost_of_transport"]
PARTS = (0.05, 0.95)
FIT = {  # of the drag and of a link's mass, which changes a slender rod's inertia too
    **{"text": "a fit", "trials": "none", "seed": 1, "names": ["water.lumped.drag[1-6]", "links.mass[7]"]},
    **{"units": ["1", "kg"], "scale": ["log", "natural"], "value": [3.9829, 0.049], "lower": [1.0, 0.03]},
    **{"upper": [9.0, 0.07], "covariance": [[0.04, 0.0], [0.0, 2.5e-5]]},
}


def fitted() -> ht.Robot:
    """Return hypertuna with a table [fit]."""
    return parse(ht.load("hypertuna").document() | {"fit": FIT})


def band(page: Page, core: InNode, image: bytes, factors: dict[str, float], gait: Gait) -> dict[str, Any]:
    """Return the spread of a gait, as the page computes it."""
    values = []
    for one in page.samples(image, factors):
        sample = InHost.read(one, core)
        assert isinstance(sample, InHost)
        swum = sample.swim(0, [gait])
        values.append({name: float(swum[name][0]) for name in ("status", *QUANTITIES)})
    return page.spread(values, QUANTITIES)


@pytest.mark.parametrize("robot", [ht.load("rexeel"), fitted()], ids=["rexeel", "hypertuna"])
def test_intervals_are_the_quantiles_of_the_samples(page: Page, core: InNode, robot: ht.Robot) -> None:
    image = fitted_image(robot)
    found = next(iter(robot.gaits.values()))
    gait = Gait(**{key: getattr(found, key) for key in ("frequency", "amplitude", "phase", "bias")})
    spread = band(page, core, image, {}, gait)
    swims = [ht.swim(one, gait) for one in sample_robots(robot, SAMPLES, SEED)]
    assert spread["count"] == spread["settled"] == SAMPLES == text_of(image)["samples"]["count"]
    for name in QUANTITIES:
        ours = np.quantile([getattr(swim, name) for swim in swims], PARTS)
        assert spread["intervals"][name] == pytest.approx(ours.tolist(), rel=1e-9)
        assert ours[0] < getattr(ht.swim(robot, gait), name) < ours[1]


def test_a_changed_body_takes_the_samples_with_it(page: Page, core: InNode) -> None:
    robot = ht.load("rexeel")
    factors = {"length-5": 1.3, "mass-5": 0.8}
    gait = Gait(frequency=0.5, amplitude=(0.3,) * 5, phase=(0.0, 0.9, 1.8, 2.7, 3.6))
    spread = band(page, core, fitted_image(robot), factors, gait)
    knobs = list(_knobs(robot, robot.document()))
    changed = [parse(with_factors(one.document(), knobs, factors)) for one in sample_robots(robot, SAMPLES, SEED)]
    speeds = np.quantile([ht.swim(one, gait).speed for one in changed], PARTS)
    assert spread["intervals"]["speed"] == pytest.approx(speeds.tolist(), rel=1e-9)


def test_samples_that_do_not_settle_are_left_out_and_counted(page: Page) -> None:
    settled = [{"status": 0.0, "speed": float(k)} for k in range(1, 11)]
    lost = [{"status": 3.0, "speed": 100.0}, {"status": 2.0, "speed": -100.0}]
    assert page.spread([*lost, *settled], ["speed"]) == {
        "settled": 10,
        "count": 12,
        "intervals": {"speed": pytest.approx([1.45, 9.55])},
    }
    assert page.spread(lost, ["speed"])["intervals"] == {"speed": [None, None]}  # NaN


def test_only_what_the_samples_change_is_in_the_image() -> None:
    robot = fitted()
    columns, plain = columns_of(fitted_image(robot)), columns_of(robot_image(robot))
    added = {name: len(column) for name, column in columns.items() if name not in plain}
    assert added == {f"samples.{name}": 8 * SAMPLES for name in ("mass", "inertia", "drag")}
    described = ht.load("rexeel-theory")
    assert "samples" not in text_of(fitted_image(described))
    assert fitted_image(described) == robot_image(described)
