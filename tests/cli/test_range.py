"""The command `hypertuna range`: what it prints, and what it says of bad input."""

from __future__ import annotations

import json

import pytest

import hypertuna as ht
from hypertuna.actuation.battery import range_of
from hypertuna.simulation.twin import twin
from program import Run

RANGE = ("range", "--robot", "hypertuna")


def test_json_has_the_arithmetic_and_the_published_range_beside_it(run: Run, tuna: ht.Robot) -> None:
    code, output, _ = run(*RANGE, "--power", "22.45", "--speed", "0.56", "--reserve", "0.1", "--json")
    told = json.loads(output)
    found = range_of(tuna, power=22.45, speed=0.56, reserve=0.1)
    assert code == 0
    assert told["range_km"] == pytest.approx(found.range / 1e3)
    assert told["nominal_range_km"] == pytest.approx(4.526, abs=1e-3)
    assert told["cost_of_transport_j_per_kg_m"] == pytest.approx(22.45 / (3.3 * 0.56))
    assert (told["battery"]["series"], told["battery"]["parallel"]) == (4, 1)
    assert told["published"]["range_km"] == 21.12
    assert told["published"]["verdict"] == "contradicted"
    assert told["published"]["computed_km"] == pytest.approx(4.5, abs=0.05)
    assert "14 Ah x 16.8 V" in told["published"]["arithmetic"]


def test_text_tells_where_the_energy_goes(run: Run) -> None:
    code, output, _ = run(*RANGE, "--power", "18.2", "--speed", "0.444")
    assert code == 0
    for words in ("= 50.4 Wh; 4 in series, 1 parallel", "converter 90 %", "0 % of that in reserve", "21.12 km"):
        assert words in output, words


def test_a_gait_has_the_power_and_speed_of_the_twin(run: Run, tuna: ht.Robot) -> None:
    code, output, _ = run(*RANGE, "--frequency", "1", "--amplitude", "8,12", "--duration", "6", "--json")
    told = json.loads(output)
    gait = ht.Gait.from_degrees(frequency=1, amplitude=(8, 12), phase=(0, 0))
    done = twin(tuna, gait, duration=6, start="swimming")
    assert code == (0 if done.settled else 1)
    assert (told["electrical_power_w"], told["speed_m_s"]) == pytest.approx((done.electrical_power, done.speed))
    assert told["gait"]["amplitude_deg"] == [8, 12]
    assert told["settled"] == done.settled


def test_a_robot_that_hardly_moves_has_no_range(run: Run) -> None:
    still = ("--frequency", "2", "--amplitude", "0,0", "--duration", "2")
    code, output, _ = run(*RANGE, *still)
    assert code == 1
    assert "does not swim head first" in output
    told = json.loads(run(*RANGE, *still, "--json")[1])
    assert told["range_km"] is None


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ((), "range needs a gait, or power and speed"),
        (("--power", "20"), "--speed is needed beside --power"),
        (("--speed", "0.5"), "--power is needed beside --speed"),
        (("--power", "-3", "--speed", "1"), "power must be greater than 0, but is -3"),
        (("--power", "20", "--speed", "fast"), "speed must be a number"),
        (("--power", "20", "--speed", "-0.5"), "--speed must be greater than 0, but is -0.5"),
        (("--frequency", "2", "--amplitude", "8,12", "--duration", "0.5"), "duration must be at least two beats, 1 s"),
        (("--frequency", "2", "--amplitude", "8,60"), "amplitude[1] must be at most 31.2 deg"),
        (("--power", "20", "--speed", "1", "--reserve", "1"), "reserve must be at least 0 and less than 1"),
        (("--power", "20", "--speed", "1", "--frequency", "2"), "--power and --speed cannot be combined with a gait"),
        (("--gait", "optimise-0.5"), "did you mean optimised-0.5?"),
        (("--frequency", "3"), "--amplitude is missing: give it, or --gait with one of "),
    ],
)
def test_bad_input_is_told_in_one_sentence(run: Run, options: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run(*RANGE, *options)
    assert code == 2
    assert not output
    assert sentence in errors
    assert errors.count("error: ") == 1
    assert errors.splitlines()[-1].startswith("error: ")


def test_a_robot_without_a_battery_is_told_so(run: Run) -> None:
    code, _, errors = run("range", "--robot", "rexeel", "--power", "20", "--speed", "0.5")
    assert code == 2
    assert errors == "error: robots/rexeel.toml: battery is missing: add the table [battery].\n"
