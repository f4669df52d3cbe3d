"""Diving and floating: the command, its record and its errors."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.cli.main import main
from hypertuna.errors import InputError

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
