"""Bands of speed by the factors of a robot's estimates."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.new import new_robot
from hypertuna.description.plausibility import implausible
from hypertuna.description.robot import Robot, parse
from hypertuna.identification.coefficients import free, with_fit
from hypertuna.swimming import band
from hypertuna.swimming.band import estimated, speed_band
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits, named_gait
from hypertuna.swimming.swim import swim


def fish(uncertainty: dict[str, float] | None = None, **sizes: Any) -> Robot:
    """Return a first robot, maybe with other factors."""
    document = new_robot("fish", **sizes)
    return parse(document if uncertainty is None else document | {"uncertainty": uncertainty})


def cruise(robot: Robot) -> Gaits:
    """Return the cruise."""
    return Gaits.of([named_gait(robot, "cruise")])


def test_small_factors_leave_the_band_of_the_exact_gradient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(band, "LAW", 1.0)
    monkeypatch.setattr(band, "SAMPLES", 1000)
    robot = fish({"water.strip": 1.01, "water.strip.blunt_area_m2": 1.04})
    found = ht.gradient(robot, named_gait(robot, "cruise"))
    slopes: dict[str, float] = {}
    values = dict(zip(found.names, found.values, strict=True))
    for name, slope in zip(found.names, found.speed, strict=True):
        place = name.partition("[")[0]
        if math.isfinite(values[name]):  # joints without lag have an infinite bandwidth
            slopes[place] = slopes.get(place, 0.0) + slope * values[name]
    factors = estimated(robot)
    assert factors["water.strip.blunt_area"] == 1.04
    assert {"water.strip.drag_normal", "water.strip.edge_height"} <= {*factors}
    width = math.sqrt(sum((slopes[place] * math.log(factor)) ** 2 for place, factor in factors.items()))
    speed = swim(robot, "cruise").speed
    left = speed_band(robot, cruise(robot))
    assert left is not None
    assert left.low[0] == pytest.approx(speed - width, abs=0.12 * width)
    assert left.high[0] == pytest.approx(speed + width, abs=0.12 * width)


def test_bands_grow_with_the_factor_and_hold_the_speed() -> None:
    ends = []
    for factor in (1.5, 2.5, 4.0):
        robot = fish({"water.strip.blunt_area_m2": factor})
        left = speed_band(robot, cruise(robot))
        assert left is not None
        ends.append(left.high[0] / left.low[0])
        assert left.low[0] < swim(robot, "cruise").speed < left.high[0]
    assert ends == sorted(ends)
    assert ends[0] > band.LAW**1.8  # that of the law alone


def test_many_gaits_have_the_bands_of_each() -> None:
    robot = fish()
    gait = named_gait(robot, "cruise")
    half = ht.Gait(0.5 * gait.frequency, gait.amplitude, gait.phase)
    both = speed_band(robot, Gaits.of([gait, half]))
    alone = swim(robot, gait).band
    assert both is not None
    assert alone is not None
    assert (both.low[0], both.high[0]) == pytest.approx((alone.low[0], alone.high[0]))
    assert both.high[1] == pytest.approx(0.5 * both.high[0], rel=1e-3)  # all drag is quadratic


def test_measured_values_and_robots_without_factors_have_no_band() -> None:
    document = new_robot("fish")
    document["uncertainty"] = {"water.strip.blunt_area_m2": 2.0}
    document["sources"]["water.strip.blunt_area_m2"] = "measured, towed"
    assert speed_band(parse(document), cruise(parse(document))) is None
    assert swim("hypertuna", "unoptimised-max").band is None
    robot = fish()
    assert swim(robot, "cruise", from_rest=5.0).band is None


def test_a_fitted_value_has_no_factor_any_more() -> None:
    robot = fish()
    frees = free(robot, ["water.blunt_area[0]"])
    assert robot.water.strip is not None
    area = robot.water.strip.blunt_area[:1]
    fitted = with_fit(robot, frees, area, covariance=np.eye(1), trials="runs.csv", seed=1, text="fitted")
    assert fitted.uncertainty is not None
    assert "water.strip.blunt_area_m2" not in fitted.uncertainty
    assert fitted.uncertainty.items() <= (robot.uncertainty or {}).items()
    assert implausible(fitted) == []
    before, after = speed_band(robot, cruise(robot)), speed_band(fitted, cruise(fitted))
    assert before is not None
    assert after is not None
    assert after.high[0] / after.low[0] < 0.8 * before.high[0] / before.low[0]


def test_samples_that_do_not_settle_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = fish()
    lost = iter([1, 0, 0, 0] * band.SAMPLES)

    def rarely(*arguments: Any, **options: Any) -> dict[str, Any]:
        beat = settle(*arguments, **options)
        return beat | {"status": beat["status"] + np.int8(next(lost))}

    monkeypatch.setattr(band, "settle", rarely)
    left = speed_band(robot, cruise(robot))
    assert left is not None
    assert left.settled[0] == 0.75
    assert "25 % of the samples do not settle" in left.sentence()
    lost = iter([1] * band.SAMPLES)
    none = speed_band(robot, cruise(robot))
    assert none is not None
    assert math.isnan(none.low[0])
    assert "none of the samples settles" in none.sentence()


def test_fractions_stay_fractions() -> None:
    robot = fish({"water.strip.edge_lift": 5.0})
    assert speed_band(robot, cruise(robot)) is not None  # the core refuses none of the samples


def test_the_program_prints_the_band(run: Any, tmp_path: Path) -> None:
    file = str(tmp_path / "fish.toml")
    assert run("robot", "new", file, "--nose", "blunt")[0] == 0
    left = swim(file, "cruise").band
    assert left is not None
    text = run("swim", "--robot", file)[1]
    assert f"By the estimates of its file alone, {left.low[0]:.3g} to {left.high[0]:.3g} m/s (90 %)." in text
    record = json.loads(run("swim", "--robot", file, "--json")[1])["band"]
    assert record == pytest.approx({"low_m_s": left.low[0], "high_m_s": left.high[0], "settled": 1.0})
    assert json.loads(run("swim", "--robot", "hypertuna", "--gait", "unoptimised-max", "--json")[1])["band"] is None
