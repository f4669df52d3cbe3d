"""The uncertainty that the studio shows is Python's own: samples of the same seed, and their quantiles."""

from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from host_library import InNode
from host_library import Robot as InHost
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.identification.coefficients import free, sample_robots, with_fit
from hypertuna.identification.image import SAMPLES, SEED, sampled_image
from hypertuna.mission.image import robot_image
from hypertuna.simulation.image_body import _knobs, with_factors
from hypertuna.swimming.band import SAMPLES as SAMPLES_OF_ESTIMATES
from hypertuna.swimming.band import sampled_columns
from hypertuna.swimming.gait import Gait, named_gait
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
    return page.spread(values, QUANTITIES, text_of(image)["samples"].get("speed_factors"))


@pytest.mark.parametrize("robot", [ht.load("rexeel"), fitted()], ids=["rexeel", "hypertuna"])
def test_intervals_are_the_quantiles_of_the_samples(page: Page, core: InNode, robot: ht.Robot) -> None:
    image = sampled_image(robot)
    found = next(iter(robot.gaits.values()))
    gait = Gait(**{key: getattr(found, key) for key in ("frequency", "amplitude", "phase", "bias")})
    spread = band(page, core, image, {}, gait)
    swims = [ht.swim(one, gait) for one in sample_robots(robot, SAMPLES, SEED)]
    assert spread["count"] == spread["settled"] == SAMPLES == text_of(image)["samples"]["count"]
    for name in QUANTITIES:
        ours = np.quantile([getattr(swim, name) for swim in swims], PARTS)
        assert spread["intervals"][name] == pytest.approx(ours.tolist(), rel=1e-9)
        assert ours[0] < getattr(ht.swim(robot, gait), name) < ours[1]


@pytest.mark.parametrize("links", [2, 5])
@pytest.mark.parametrize("factors", [{}, {"length-1": 1.3, "mass-1": 0.8}], ids=["described", "changed"])
def test_the_band_of_estimates_is_that_of_swim(page: Page, core: InNode, links: int, factors: dict[str, float]) -> None:
    document = new_robot("fish", links=links)
    robot = parse(document)
    gait = named_gait(robot, "cruise")
    spread = band(page, core, sampled_image(robot), factors, gait)
    low, high = spread["intervals"]["speed"]
    changed = parse(with_factors(document, list(_knobs(robot, document)), factors))
    left = ht.swim(changed, gait).band
    assert left is not None
    assert spread["of"] == "estimates"
    assert spread["settled"] == spread["count"] == SAMPLES_OF_ESTIMATES
    assert (low, high) == pytest.approx((left.low[0], left.high[0]), rel=1e-3)  # other steps of a beat


def test_estimates_come_before_a_fit() -> None:
    frees = free(robot := parse(new_robot("fish")), ["water.blunt_area[0]"])
    assert robot.water.strip is not None
    area = robot.water.strip.blunt_area[:1]
    fitted = with_fit(robot, frees, area, covariance=np.eye(1), trials="runs.csv", seed=1, text="fitted")
    samples, wanted = text_of(sampled_image(fitted))["samples"], sampled_columns(fitted)
    assert wanted is not None
    assert samples["speed_factors"] == wanted[1].tolist()


def test_a_changed_body_takes_the_samples_with_it(page: Page, core: InNode) -> None:
    robot = ht.load("rexeel")
    factors = {"length-5": 1.3, "mass-5": 0.8}
    gait = Gait(frequency=0.5, amplitude=(0.3,) * 5, phase=(0.0, 0.9, 1.8, 2.7, 3.6))
    spread = band(page, core, sampled_image(robot), factors, gait)
    knobs = list(_knobs(robot, robot.document()))
    changed = [parse(with_factors(one.document(), knobs, factors)) for one in sample_robots(robot, SAMPLES, SEED)]
    speeds = np.quantile([ht.swim(one, gait).speed for one in changed], PARTS)
    assert spread["intervals"]["speed"] == pytest.approx(speeds.tolist(), rel=1e-9)


def test_samples_that_do_not_settle_are_left_out_and_counted(page: Page) -> None:
    settled = [{"status": 0.0, "speed": float(k)} for k in range(1, 11)]
    lost = [
        {"status": 3.0, "speed": 100.0},
        {"status": 2.0, "speed": -100.0},
        {"status": 0.0},
    ]  # a body that spins has no speed
    assert page.spread([*lost, *settled], ["speed"]) == {
        "of": "fit",
        "settled": 10,
        "count": 13,
        "intervals": {"speed": pytest.approx([1.45, 9.55])},
    }
    assert page.spread(lost, ["speed"])["intervals"] == {"speed": [None, None]}  # NaN


def test_only_what_the_samples_change_is_in_the_image() -> None:
    robot = fitted()
    columns, plain = columns_of(sampled_image(robot)), columns_of(robot_image(robot))
    added = {name: len(column) for name, column in columns.items() if name not in plain}
    assert added == {f"samples.{name}": 8 * SAMPLES for name in ("mass", "inertia", "drag")}
    described = ht.load("rexeel-theory")
    assert "samples" not in text_of(sampled_image(described))
    assert sampled_image(described) == robot_image(described)
