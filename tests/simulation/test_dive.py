"""Diving and floating: the command, its record and its errors."""

from __future__ import annotations

import csv
import json
import math
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.cli.main import main
from hypertuna.description.inversion import inversion_speed
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.swimming.gait import named_gait

ROBOT = ht.load("hypertuna")
SWIMS = ht.Gait.from_degrees(frequency=3, amplitude=(16, 25), phase=(0, 0))


def run(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr(sys, "argv", ["hypertuna", "dive", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    return int(stop.value.code or 0)


def test_legs_are_what_the_run_says() -> None:
    done = ht.dive(ROBOT, SWIMS, duration=16, depth=3)
    down, up = done.legs
    run, late = done.run, slice(400, 800)
    assert down.right
    assert up.right
    assert down.depth_rate == pytest.approx((run.depth[799] - run.depth[400]) / 3.99, rel=1e-6)
    assert down.depth_rate == pytest.approx(run.sink[late].mean(), rel=0.01)
    assert down.speed == pytest.approx(run.speed[late].mean())
    assert (down.depth[0], up.depth[1]) == (run.depth[0], run.depth[-1])
    assert np.radians(-45) == pytest.approx(run.data["fin"][750].mean(), abs=1e-6)
    assert 0.5 < done.symmetry < 1.5
    assert len(done.sentences) == 2


def test_more_fin_is_a_faster_dive_up_to_the_peak_of_the_lift() -> None:
    """Down and up; from 30 deg on the rate stays within a tenth, as the lift of plates of aspect ratio 2.5 does."""
    dives = [ht.dive(ROBOT, SWIMS, angle=np.radians(angle), duration=20, depth=3) for angle in (10, 20, 30, 45)]
    for leg in (0, 1):
        rates = [abs(dive.legs[leg].depth_rate) for dive in dives]
        assert rates[0] < 0.7 * rates[1] < 0.7 * rates[2]
        assert rates[3] == pytest.approx(rates[2], rel=0.1)


def test_a_dive_that_is_no_dive_is_told_so(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Hardly beating, it does not come down: exit code 1."""
    weak = ["--frequency", "1", "--amplitude", "0.5,0.5", "--phase", "0,0", "--duration", "10", "--fins", "3"]
    assert run(monkeypatch, "--robot", "hypertuna", *weak) == 1
    assert "does not: its depth changes by" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    "sizes", [{}, {"length": 1.0, "links": 5}, {"links": 4, "nose": "streamlined"}, {"links": 2, "nose": "blunt"}]
)
def test_depth_rates_follow_the_balance_of_fins_hull_and_ballast(sizes: dict[str, Any]) -> None:
    """By hand: d A / (A + k) U (1 - q^2), q the speed U over that of inversion, d the fin angle, A and k the lifts."""
    document = tomllib.loads(first_robot("fish", actuation="servo", sea=True, **sizes))
    robot, fins = parse(document), document["fins"]
    gait, (height, *tail) = named_gait(robot, "cruise"), document["spatial"]["com_height_m"]
    aspect = 2 * fins["span_m"] / fins["chord_m"]
    fin = 1000 * fins["span_m"] * fins["chord_m"] * 2 * np.pi * aspect / (2 + np.sqrt(4 + aspect**2))
    hull = 0.28 * 0.9 * 1000 * np.pi / 4 * document["spatial"]["width_m"][0] ** 2
    for share in (0.5, 0.7):  # of the speed of inversion, by the ballast alone
        lower = height * (ht.swim(robot, gait).speed / share / inversion_speed(robot)) ** 2
        made = parse(document | {"spatial": document["spatial"] | {"com_height_m": [lower, *tail]}})
        down = ht.dive(made, gait, angle=np.radians(10), duration=80 / gait.frequency, depth=5.0).legs[0]
        path = np.radians(10) * fin / (fin + hull) * (1 - (down.speed / inversion_speed(made)) ** 2)
        assert down.depth_rate == pytest.approx(down.speed * path, rel=0.15)


def test_a_dive_above_the_speed_of_inversion_is_told_so() -> None:
    robot = parse(tomllib.loads(first_robot("fish", actuation="servo", sea=True)))
    gait, sentence = named_gait(robot, "cruise"), f"Near and above {inversion_speed(robot):.3g} m/s the water turns"
    for factor, told in ((1.0, 0), (1.5, 1)):
        fast = replace(gait, amplitude=tuple(factor * a for a in gait.amplitude))
        dive = ht.dive(robot, fast, duration=30)
        assert sum(line.startswith(sentence) for line in dive.sentences) == told
        assert all(leg.right for leg in dive.legs) == (not told)


def test_a_hull_that_flow_does_not_turn_has_no_speed_of_inversion() -> None:
    document = ROBOT.document()
    document["spatial"]["shedding_vertical"] = 1.0
    assert inversion_speed(parse(document)) == math.inf
    document["spatial"] |= {"shedding_vertical": 0.0, "com_height_m": [0.01] * 8}
    assert inversion_speed(parse(document)) == 0.0


def test_a_duration_may_end_within_a_tick() -> None:
    done = ht.dive(ROBOT, SWIMS, duration=8.004)
    assert (len(done.legs), len(done.sentences)) == (2, 2)


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    table, picture = tmp_path / "dive.csv", tmp_path / "dive.svg"
    options = ["--robot", "hypertuna", "--gait", "unoptimised-0.4", "--duration", "12"]
    assert run(monkeypatch, *options, "--json", "-o", str(table), "--plot", str(picture)) == 0
    record = json.loads(capsys.readouterr().out)
    assert [leg["fins_deg"] for leg in record["legs"]] == [-45, 45]
    assert record["legs"][0]["depth_rate_m_s"] > 0 > record["legs"][1]["depth_rate_m_s"]
    assert record["robot_hash"] == ROBOT.hash
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert len(rows) == 1200
    assert float(rows[599]["depth_m"]) == pytest.approx(record["legs"][0]["depth_to_m"], abs=1e-4)
    assert "<svg" in picture.read_text()
    assert run(monkeypatch, *options, "-o", str(tmp_path / "dive.nc")) == 0
    assert "cm/s" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"angle": -0.1}, "angle must be greater than 0"),
        ({"angle": 2.0}, "fins must be at most 45 deg"),
        ({"duration": 1.0}, "duration must be at least eight beats, 2.67 s at 3 Hz"),
    ],
)
def test_bad_input_gives_one_sentence(options: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ht.dive(ROBOT, SWIMS, **options)  # type: ignore[arg-type]


def test_a_spring_that_its_settled_beat_cannot_follow_is_refused_with_advice_that_dives_have() -> None:
    document = tomllib.loads(first_robot("fish", actuation="servo", sea=True, tail="passive"))
    document["hinge"]["stiffness_n_m_per_rad"] = 5000.0
    document["hinge"]["damping_n_m_s_per_rad"] = 0.0
    fish = parse(document)
    with pytest.raises(
        InputError, match="a run at sea begins with the speed of the settled beat; give less"
    ) as refused:
        ht.dive(fish, "cruise")
    assert "--steps" not in str(refused.value)
    assert ht.twin(fish, "cruise", duration=0.5).status == "completed"
