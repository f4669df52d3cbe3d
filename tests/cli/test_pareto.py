"""The command `hypertuna pareto`: what it prints and writes, that it resumes, and what it says of bad input."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hypertuna as ht
from hypertuna.optimization.objective import OBJECTIVES
from hypertuna.optimization.optimizers import nondominated
from hypertuna.optimization.pareto import Front, pareto
from hypertuna.optimization.plots import plot_pareto
from program import Run

SMALL = ("pareto", "--robot", "hypertuna", "--population", "8", "--generations", "3")


@pytest.fixture(scope="module")
def front(tuna: ht.Robot) -> Front:
    return pareto(tuna, population=8, generations=3)


def test_json_tells_the_front_that_the_function_finds(run: Run, front: Front) -> None:
    code, output, _ = run(*SMALL, "--json")
    told = json.loads(output)
    assert code == 0
    speed, cost = ([gait[name] for gait in told["front"]] for name in ("speed_m_s", "cost_of_transport_j_per_kg_m"))
    np.testing.assert_allclose(np.array([speed, cost]).T, front.values, rtol=1e-12)
    assert told["hypervolume"]["front"] == front.hypervolume
    assert told["hypervolume"]["before_polishing"] == front.hypervolume_evolved
    assert list(told["hypervolume"]["reference"].values()) == front.reference.tolist()
    assert (told["evaluations"], told["stop"]) == (front.evaluations, front.stop)
    first = told["front"][0]["gait"]
    assert first.keys() == {"frequency_hz", "amplitude_deg", "phase_deg"}
    np.testing.assert_allclose(np.radians(first["amplitude_deg"]), front.gaits[0].amplitude)


def test_files_hold_the_front(run: Run, front: Front, tmp_path: Path) -> None:
    table, data, plot = (str(tmp_path / name) for name in ("front.csv", "front.nc", "front.svg"))
    assert run(*SMALL, "-o", table, "--plot", plot)[0] == 0
    lines = Path(table).read_text().splitlines()
    rows = np.genfromtxt(lines, delimiter=",", names=True)
    np.testing.assert_allclose(rows["speed_m_s"], front.values[:, 0], rtol=1e-12)
    np.testing.assert_allclose(rows["frequency_hz"], [gait.frequency for gait in front.gaits])
    assert "unoptimised-0.4" in Path(plot).read_text()
    assert run(*SMALL, "-o", data)[0] == 0
    with xr.open_dataset(data, engine="h5netcdf") as found:
        np.testing.assert_allclose(found.cost_of_transport, front.values[:, 1], rtol=1e-12)
        assert found.attrs["hypervolume"] == front.hypervolume


def test_table_and_sentence(run: Run, front: Front) -> None:
    code, output, _ = run(*SMALL)
    assert code == 0
    assert f"{front.values[-1, 0]:.4g}" in output
    assert front.stop in output
    assert f"hypervolume {front.hypervolume:.5g}" in output


def test_no_gait_is_exit_code_1(run: Run) -> None:
    options = ("pareto", "--robot", "hypertuna", "--population", "4", "--generations", "2", "--min-speed", "9")
    code, output, _ = run(*options)
    assert code == 1
    assert "No gait satisfied all limits" in output
    code, output, _ = run(*options, "--json")
    assert code == 1
    assert json.loads(output)["front"] == []


def test_limits_and_bounds_of_the_command_line_hold(run: Run) -> None:
    options = ("--max-joint-rate", "150", "--bounds", "frequency_hz=1:5", "--min-speed", "0.1", "--no-polish")
    told = json.loads(run(*SMALL, *options, "--joints", "ideal", "--json")[1])
    assert told["joints"] == "ideal"
    for point in told["front"]:
        gait = point["gait"]
        assert 2 * np.pi * gait["frequency_hz"] * max(gait["amplitude_deg"]) <= 150
        assert 1 <= gait["frequency_hz"] <= 5
        assert point["speed_m_s"] >= 0.1


def test_resumes_after_a_kill_to_the_same_front(run: Run, tmp_path: Path) -> None:
    journal = tmp_path / "run.jsonl"
    arguments = (*SMALL[:-1], "8", "--json")
    checkpoint = ("--checkpoint", str(journal))
    command = [sys.executable, "-m", "hypertuna", *arguments, *checkpoint]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as killed:
        while not journal.exists() or journal.read_bytes().count(b"\n") < 4:
            assert killed.poll() is None, "it was done before it could be killed"
            time.sleep(0.005)
        os.kill(killed.pid, signal.SIGKILL)
    known = journal.read_bytes().count(b"\n")
    resumed, through = (json.loads(run(*arguments, *more)[1]) for more in (checkpoint, ()))
    assert known < journal.read_bytes().count(b"\n")
    assert {**resumed, "seconds": 0} == {**through, "seconds": 0}


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--objectives", "speed,cost_transport"), "did you mean cost_of_transport?"),
        (("--objectives", "speed"), "must name two or three different quantities"),
        (("--objectives", "speed,speed"), "must name two or three different quantities"),
        (("--population", "many"), "must be a whole number"),
        (("--population", "1"), "population must be from 2 to 10000"),
        (("--seed", "-1"), "seed must be from 0"),
        (("--min-speed", "fast"), "must be a number"),
        (("--bounds", "frequency_hz"), "must be NAME=LOW:HIGH"),
        (("--robust", "median"), "robust must be mean or worst5"),
        (("--robust", "mean"), "hypertuna identify"),
        (("--plot", "front.doc"), "must end in .svg, .png or .pdf"),
        (("-o", "front.txt"), "must end in .nc or .csv"),
    ],
)
def test_bad_input_is_told_in_one_sentence(run: Run, options: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run("pareto", "--robot", "hypertuna", *options)
    assert code == 2
    assert output == ""
    assert errors.startswith("error: ")
    assert errors.count("\n") == 1
    assert sentence in errors


# --- the plot


def test_plot_shows_points_and_named_gaits(front: Front) -> None:
    axes = plot_pareto(front).axes[0]
    shown = axes.collections[0].get_offsets()
    np.testing.assert_array_equal(shown, front.values)
    labels = axes.get_legend_handles_labels()[1]
    straight = [name for name, gait in front.robot.gaits.items() if not any(gait.bias)]
    assert [label.split()[-1] for label in labels[: len(straight)]] == straight
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("speed [m/s]", "cost of transport [J/(kg m)]")


def test_plot_of_three_objectives_colors_by_the_third(tuna: ht.Robot) -> None:
    front = pareto(tuna, ["speed", "cost_of_transport", "mechanical_power"], population=4, generations=2, polish=False)
    axes = plot_pareto(front, width=3.9).axes
    np.testing.assert_array_equal(axes[0].collections[0].get_array(), front.values[:, 2])
    assert axes[1].get_ylabel() == "mechanical power [W]"


def test_every_objective_has_a_name_with_its_unit() -> None:
    from hypertuna.cli.pareto import NAMES

    assert set(OBJECTIVES) <= set(NAMES)


def test_points_of_a_front_do_not_dominate_each_other(front: Front) -> None:
    assert len(nondominated(front.values * [-1, 1])) == len(front.values)
