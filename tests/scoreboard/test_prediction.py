"""Predictions of published swimmers: their gaits, thrust at rest, and a drag area fitted to one speed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.scoreboard.fits import Other, other_speeds, with_drag_area
from hypertuna.scoreboard.prediction import EXCURSION, first_robot, held, own_robot, predict, predict_runs, run_gait
from hypertuna.scoreboard.swimmers import Run, Swimmer
from hypertuna.swimming.band import speed_band
from hypertuna.swimming.gait import Gaits

ROBOT = parse(new_robot("fish", links=3, length=0.3, mass=0.85))
SIZES: dict[str, Any] = {"length_m": 0.3, "mass_kg": 0.85}


def run(**keys: Any) -> Run:
    return Run.model_validate({"name": "one", "frequency_hz": 2.0, "speed_m_s": 0.1} | keys)


def swimmer(body: dict[str, Any] = SIZES, **tables: Any) -> Swimmer:
    document: dict[str, Any] = {"name": "fish", "reference": "paper", "nose": "robot", "links": 3, "body": body}
    document["runs"] = [{"name": "one", "frequency_hz": 2.0, "speed_m_s": 0.1}]
    document |= tables
    names = [name for name in ("nose", "links", "body", "fin", "runs") if name in document]
    return Swimmer.model_validate(document | {"sources": dict.fromkeys(names, "paper")})


def test_the_first_robot_is_that_of_robot_new() -> None:
    assert first_robot(swimmer()).hash == ROBOT.hash
    assert own_robot(swimmer()) is None


def test_own_sections_are_those_published() -> None:
    fish = own_robot(swimmer(SIZES | {"height_m": 0.08}, fin={"span_m": 0.1, "area_m2": 0.003}))
    assert fish is not None
    assert fish.water.strip is not None
    assert fish.water.strip.edge_height == 0.1
    area = fish.links.lateral_area[-1]
    assert area == pytest.approx(new_area(fish), rel=1e-3)
    lengths = own_robot(swimmer(links={"length_m": [0.2, 0.06, 0.04]}))
    assert lengths is not None
    assert lengths.links.length == (0.2, 0.06, 0.04)


def new_area(fish: ht.Robot) -> float:
    """Side area of the last link of `robot new` with a fin of 30 mm chord [m^2]."""
    made = new_robot("fish", links=3, length=0.3, mass=0.85, height=0.08, fin_span=0.1, fin_chord=0.03)
    return float(made["links"]["lateral_area_m2"][-1])


def test_a_gait_reaches_the_published_excursion_and_else_a_fifth_of_the_length() -> None:
    for excursion, aim in ((0.05, 0.05), (None, EXCURSION * 0.3)):
        keys = {} if excursion is None else {"excursion_m": excursion}
        gait = run_gait(ROBOT, run(**keys))
        assert gait is not None
        assert ht.swim(ROBOT, gait).tail_excursion == pytest.approx(aim, rel=1e-3)
        cruise = ht.named_gait(ROBOT, "cruise")
        assert np.ptp(np.divide(gait.amplitude, cruise.amplitude)) < 1e-9
        assert gait.phase == cruise.phase


def test_a_published_angle_is_taken_as_it_is() -> None:
    gait = run_gait(ROBOT, run(amplitude_deg=[5.0, 10.0]))
    assert gait is not None
    assert np.degrees(gait.amplitude) == pytest.approx([5, 10])
    assert gait.phase == ht.named_gait(ROBOT, "cruise").phase
    gait = run_gait(ROBOT, run(amplitude_deg=[5.0, 10.0], phase_deg=[0.0, 60.0]))
    assert gait is not None
    assert np.degrees(gait.phase) == pytest.approx([0, 60])


def test_an_excursion_out_of_reach_has_no_prediction() -> None:
    assert run_gait(ROBOT, run(excursion_m=0.5)) is None
    assert np.isnan(predict(ROBOT, run(excursion_m=0.5)).speed)


def test_a_prediction_is_the_settled_swim() -> None:
    found = predict(ROBOT, run(amplitude_deg=[5.0, 10.0]))
    assert found.gait is not None
    done = ht.swim(ROBOT, found.gait)
    assert (found.speed, found.excursion, found.power) == (done.speed, done.tail_excursion, done.mechanical_power)


def test_a_band_holds_the_prediction_and_is_that_of_the_swim() -> None:
    first, second = predict_runs(ROBOT, [run(name="a"), run(name="b", frequency_hz=1.0)])
    for one in (first, second):
        assert one.gait is not None
        band = speed_band(ROBOT, Gaits.of([one.gait]))
        assert band is not None
        assert one.band == (band.low[0], band.high[0])
        assert one.band[0] < one.speed < one.band[1]


def test_an_excursion_is_assumed_where_it_is_an_estimate() -> None:
    keys: dict[str, Any] = {"frequency_hz": 2.0, "speed_m_s": 0.1}
    fish = swimmer(
        runs=[
            {"name": "a"} | keys,
            {"name": "b", "excursion_m": 0.05} | keys,
            {"name": "c", "amplitude_deg": [5, 9]} | keys,
        ]
    )
    assert [fish.assumes_excursion(one) for one in fish.runs] == [True, False, False]
    sources = {"sources": fish.sources | {"runs.excursion_m": "estimate: 0.2 L"}}
    assert fish.model_copy(update=sources).assumes_excursion(fish.runs[1])


def test_a_rigid_tail_held_fixed_moves_as_a_pendulum() -> None:
    fish = parse(new_robot("fish", links=2, length=0.3, mass=0.85))
    found = predict(fish, run(speed_m_s=0.0, thrust_n=0.1, amplitude_deg=[30.0]))
    assert found.excursion == pytest.approx(2 * fish.links.length[1] * np.sin(np.radians(30)), rel=1e-9)


def test_forces_at_rest_grow_with_the_square_of_the_frequency() -> None:
    gait = ht.named_gait(ROBOT, "cruise")
    once, twice = (held(ROBOT, replace(gait, frequency=f)) for f in (1.0, 2.0))
    assert once.thrust != 0
    assert twice.thrust == pytest.approx(4 * once.thrust, rel=1e-9)
    assert twice.power == pytest.approx(8 * once.power, rel=1e-9)


@pytest.mark.parametrize("links", [2, 3])
def test_thrust_at_rest_is_that_of_a_very_heavy_fish(links: int) -> None:
    document = new_robot("fish", links=links, length=0.3, mass=0.85)
    fish = parse(document)
    document["links"]["mass_kg"] = [1e6, *document["links"]["mass_kg"][1:]]
    document["links"]["inertia_kg_m2"] = [1e6, *fish.links.inertia[1:]]
    del document["body"]["mass_kg"]
    heavy = parse(document)
    gait = ht.named_gait(fish, "cruise")
    motion = ht.swim(heavy, gait, from_rest=2.0).trajectory
    ahead = motion.forward_speed.values
    beat = int(len(ahead) - 1) // 4
    gained = 1e6 * (ahead[2 * beat] - ahead[beat]) * gait.frequency
    assert held(fish, gait).thrust == pytest.approx(gained, rel=1e-3)


def test_a_drag_area_fitted_to_one_speed_predicts_the_others() -> None:
    fish = with_drag_area(ROBOT, 0.003)
    speeds = {f: ht.swim(fish, replace(ht.named_gait(fish, "cruise"), frequency=f)).speed for f in (1.0, 2.0)}
    angles = np.degrees(ht.named_gait(fish, "cruise").amplitude).tolist()
    runs = [run(name=f"{f}", frequency_hz=f, speed_m_s=speed, amplitude_deg=angles) for f, speed in speeds.items()]
    found = other_speeds(ROBOT, runs)
    assert [(other.fitted, other.run) for other in found] == [("1.0", "2.0"), ("2.0", "1.0")]
    assert [other.ratio for other in found] == pytest.approx([1, 1], rel=1e-3)
    assert all(other.holds for other in found)
    assert other_speeds(ROBOT, runs[:1]) == []
    assert np.isnan([other.ratio for other in other_speeds(ROBOT, [runs[0], run(speed_m_s=50.0)])][-1])


def test_other_speeds_hold_within_a_tenth_and_the_published_error() -> None:
    assert Other("a", "b", 1.09, 0.0).holds
    assert not Other("a", "b", 1.12, 0.0).holds
    assert Other("a", "b", 1.12, 0.03).holds
    assert not Other("a", "b", float("nan"), 0.0).holds
