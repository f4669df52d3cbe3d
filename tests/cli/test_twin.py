"""The commands `hypertuna twin` and `hypertuna posture-test`: what they print and write, and what they refuse."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hypertuna as ht
from hypertuna.cli import twin as cli_twin
from hypertuna.simulation.losses import PLACES
from hypertuna.simulation.posture import PostureTest, posture_test
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twin
from hypertuna.swimming.gait import Gait
from program import Run

GAIT = ("--frequency", "3", "--amplitude", "12,20", "--phase", "0,20")
SHORT = ("twin", "--robot", "hypertuna", *GAIT, "--duration", "3")
FIG8 = ("posture-test", "--robot", "hypertuna", "--frequency", "2,4", "--no-limits", "--duration", "6")


@pytest.fixture(scope="module")
def short(tuna: ht.Robot) -> TwinRun:
    return twin(tuna, Gait.from_degrees(frequency=3, amplitude=(12, 20), phase=(0, 20)), duration=3)


@pytest.fixture(scope="module")
def fig8(tuna: ht.Robot) -> PostureTest:
    return posture_test(tuna, frequencies=[2, 4], angle=[0.0, math.radians(20)], duration=6, limits=False)


def test_json_tells_the_run_of_the_function(run: Run, short: TwinRun) -> None:
    code, output, _ = run(*SHORT, "--json")
    told = json.loads(output)
    assert code == 0
    assert told["speed_m_s"] == short.speed
    assert told["electrical_power_w"] == short.electrical_power
    assert told["cost_of_transport_j_per_kg_m"] == pytest.approx(short.electrical_power / (3.3 * short.speed))
    assert [joint["name"] for joint in told["joints"]] == ["I", "II"]
    for joint, swing, wished in zip(told["joints"], short.swing, (12, 20), strict=True):
        assert joint["amplitude_set_deg"] == pytest.approx(wished)
        assert joint["swing_deg"] == pytest.approx(math.degrees(swing))
        assert joint["swing_error_deg"] == pytest.approx(math.degrees(swing) - wished)
    assert [circuit["name"] for circuit in told["circuits"]] == ["I-left", "I-right", "II-left", "II-right"]
    pressures = [circuit["pressure_max_kpa"] for circuit in told["circuits"]]
    np.testing.assert_allclose(pressures, short.pressure_max / 1e3)
    assert (told["status"], told["faults"], told["limits"]) == ("completed", list(short.faults), list(short.limits))
    assert (told["frequency_hz"], told["amplitude_deg"], told["duration_s"]) == (3, [12, 20], 3)


def test_the_table_says_the_same(run: Run, short: TwinRun) -> None:
    code, output, _ = run(*SHORT)
    assert code == 0
    assert f"{short.speed:.3g}" in output
    for joint, swing in zip(["I", "II"], np.degrees(short.swing), strict=True):
        (line,) = [line for line in output.splitlines() if line.split()[:1] == [joint]]
        assert f"{swing:.1f}" in line
    for c, name in enumerate(short.circuits):
        (line,) = [line for line in output.splitlines() if line.startswith(name)]
        assert line.split()[2:] == [f"{kpa / 1e3:.0f}" for kpa in (short.pressure_max[c], short.pressure_highest[c])]


def test_the_largest_pressure_is_that_of_the_whole_run(run: Run) -> None:
    """A surge above the hard limit, before the last beats: in the table, in JSON and in a sentence."""
    gait = ("--frequency", "1", "--amplitude", "2,2", "--phase", "0,0", "--duration", "4")
    limits = {"work": "130.1e3", "soft": "130.2e3", "hard": "130.4e3"}
    low = [part for name, limit in limits.items() for part in ("--set", f"controller.pressure_{name}_pa={limit}")]
    told = json.loads(run("twin", "--robot", "hypertuna", *gait, *low, "--json")[1])
    highest = max(circuit["pressure_highest_kpa"] for circuit in told["circuits"])
    assert highest > 130.4
    assert highest >= max(circuit["pressure_max_kpa"] for circuit in told["circuits"])
    assert f"The pressure rose to {highest:.0f} kPa" in " ".join(told["status_text"])


def test_losses_are_told_drawn_and_stored(run: Run, short: TwinRun, tmp_path: Path) -> None:
    losses, picture, data = short.losses, tmp_path / "losses.svg", tmp_path / "run.nc"
    code, output, _ = run(*SHORT, "--losses", str(picture), "-o", str(data))
    assert code == 0
    for place in PLACES:
        (line,) = [line for line in output.splitlines() if line.split()[:1] == [place]]
        assert f"{losses.at(place):.3g}" in line
    assert "windings" in picture.read_text()
    attributes = xr.open_dataset(data).attrs
    told = json.loads(run(*SHORT, "--json")[1])
    assert told["battery_power_w"] == attributes["battery_power_w"] == losses.power
    assert sum(loss["power_w"] for loss in told["losses"]) == pytest.approx(losses.power)
    for loss in losses.losses:
        assert attributes[f"{loss.name}_power_w"] == loss.power


def test_files_hold_the_run(run: Run, short: TwinRun, tmp_path: Path) -> None:
    table, data, plot = (str(tmp_path / name) for name in ("run.csv", "run.nc", "run.svg"))
    assert run(*SHORT, "-o", table, "--plot", plot)[0] == 0
    lines = Path(table).read_text().splitlines()
    rows = np.genfromtxt(lines, delimiter=",", names=True)
    np.testing.assert_allclose(rows["angle_II_deg"], np.degrees(short.data["angle"][:, 1]), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(rows["pump_pressure_I_left_kpa"], short.data["pump_pressure"][:, 0] / 1e3, rtol=1e-5)
    assert json.loads(Path(f"{table}.json").read_text())["robot_hash"] == short.robot.hash
    assert "pump pressure [kPa]" in Path(plot).read_text()
    assert run(*SHORT, "-o", data)[0] == 0
    with xr.open_dataset(data, engine="h5netcdf") as found:
        np.testing.assert_array_equal(found.angle, short.data["angle"])
        assert found.pump_pressure.attrs["units"] == "Pa"
        assert found.attrs["speed_m_s"] == short.speed
        assert found.attrs["II_amplitude_set_deg"] == pytest.approx(20)


def test_a_named_gait_and_its_changes(run: Run) -> None:
    options = ("twin", "--robot", "hypertuna", "--gait", "turning", "--duration", "2", "--json")
    told = json.loads(run(*options)[1])
    assert (told["frequency_hz"], told["bias_deg"]) == (2, [16, 25])
    assert json.loads(run(*options, "--frequency", "3")[1])["frequency_hz"] == 3  # as with `hypertuna swim`


def test_options_reach_the_twin(run: Run, monkeypatch: pytest.MonkeyPatch, short: TwinRun) -> None:
    given: dict[str, object] = {}

    def spy(robot: ht.Robot, gait: Gait, **options: object) -> TwinRun:
        given.update(options, bores=[group.line.bore for group in robot.joints if group.line], gait=gait)
        return short

    monkeypatch.setattr(cli_twin, "twin", spy)
    options = ("--fault", "bend-II:stuck@1", "--fault", "imu:nan@2", "--open-loop", "--medium", "air", "--seed", "7")
    more = ("--temperature", "5", "--line-bore", "2.5", "--start", "swimming", "--bias", "1,2")
    assert run(*SHORT, *options, *more)[0] == 0
    assert given["faults"] == ("bend-II:stuck@1", "imu:nan@2")
    assert (given["closed_loop"], given["medium"], given["seed"]) == (False, "air", 7)
    assert (given["temperature"], given["start"], given["duration"]) == (278.15, "swimming", 3)
    assert given["bores"] == pytest.approx([0.0025, 0.0025])
    assert isinstance(given["gait"], Gait)
    np.testing.assert_allclose(given["gait"].bias, np.radians([1, 2]))


def _with(command: tuple[str, ...], options: tuple[str, ...]) -> list[str]:
    """Return a command with its first option's value replaced, or with the options added."""
    words = list(command)
    if options[0] in words:
        at = words.index(options[0])
        del words[at : at + 2]
    return [*words, *options]


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (
            ("--amplitude", "12,20", "--amplitude", "12"),
            "--amplitude must be a single set of angles, but is 12,20 and 12: give one",
        ),
        (("--duration", "0"), "duration must be"),
        (("--duration", "1e9"), "duration must be"),
        (("--duration", "x"), "--duration must be a number, but is 'x'"),
        (("--medium", "oil"), "--medium must be water or air, but is 'oil'"),
        (("--start", "swiming"), "did you mean swimming?"),
        (("--line-bore", "0"), "--line-bore must be from 1 to 20 mm, but is 0"),
        (("--fault", "bend-II:stock@1"), "use one of stuck, open, spike, nan"),
        (("--fault", "bend-III:stuck@1"), "did you mean bend-II?"),
        (("--fault", "bend-II:stuck@9"), "fault must start before the run ends at 3 s"),
        (("--temperature", "-50"), "temperature must be from -9 to 100 degC"),
        (("--temperature", "hot"), "--temperature must be a number"),
        (
            ("--duration", "0.5"),
            "duration must be at least two beats, 0.6667 s at 3 Hz, but is 0.5 s: give at least 0.67",
        ),
        (("--seed", "1.5"), "--seed must be a whole number"),
        (("--gait", "optimised-max2"), "did you mean optimised-max?"),
        (("--plot", "run.gif"), "--plot must end in .svg, .png or .pdf"),
        (("-o", "run.txt"), "--output must end in .nc or .csv"),
        (("-o", "/nowhere/run.nc"), "must be in a folder that exists"),
    ],
)
def test_bad_input_is_one_sentence(run: Run, options: tuple[str, ...], told: str, tmp_path: Path) -> None:
    code, output, errors = run(*_with(SHORT, options))
    assert code == 2
    assert output == ""
    assert told in errors
    assert errors.count("\n") == 1
    assert "Traceback" not in errors


@pytest.mark.parametrize("command", ["twin", "posture-test"])
def test_a_robot_without_a_controller_gets_the_command_that_writes_one(
    run: Run, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("robot", "new", "own.toml")[0] == 0
    options = ("--duration", "2") if command == "twin" else ("--frequency", "2", "--duration", "2", "--no-limits")
    code, output, errors = run(command, "--robot", "own.toml", *options)
    assert (code, output, errors.count("\n")) == (2, "", 1)
    assert "own.toml: controller is missing: copy it and the drives of [[joints]] from a robot of this size" in errors
    written = shlex.split(errors.split("`")[1])
    assert run(*written[1:])[0] == 0
    assert run(command, "--robot", "own-twin.toml", *options)[0] in (0, 1)


def test_a_robot_that_stays_where_it_is_has_no_cost_of_transport(run: Run) -> None:
    code, output, _ = run("twin", "--robot", "hypertuna", "--frequency", "2", "--amplitude", "0,0", "--phase", "0,0",
                          "--duration", "2", "--json")  # fmt: skip
    told = json.loads(output)
    assert code == 0
    assert told["cost_of_transport_j_per_kg_m"] is None
    assert "does not swim head first" in told["status_text"][-1]
    assert told["command"].startswith("hypertuna twin")


def test_a_run_that_diverges_is_exit_code_1(run: Run, monkeypatch: pytest.MonkeyPatch, short: TwinRun) -> None:
    from dataclasses import replace

    monkeypatch.setattr(cli_twin, "twin", lambda *_, **__: replace(short, status="diverged"))
    assert run(*SHORT)[0] == 1
    code, output, _ = run(*SHORT, "--json")
    assert code == 1
    assert json.loads(output)["status"] == "diverged"


def test_posture_test_tells_fig_8(run: Run, fig8: PostureTest, tmp_path: Path) -> None:
    table, data, plot = (str(tmp_path / name) for name in ("fig8.csv", "fig8.nc", "fig8.svg"))
    code, output, _ = run(*FIG8, "--json", "-o", table, "--plot", plot)
    told = json.loads(output)
    assert code == (1 if any(one.settling is None for one in fig8.held) else 0)
    for row, one in zip(told["tests"], fig8.held, strict=True):
        assert (row["frequency_hz"], row["joint"], row["settling_s"]) == (one.frequency, "II", one.settling)
        np.testing.assert_allclose(row["beat_error_deg"], np.degrees(one.error))
    lines = Path(table).read_text().splitlines()
    head = lines[0].split(",")
    assert head[:4] == ["frequency_hz", "joint", "angle_set_deg", "time_s"]
    beats = [line for line in lines if line[0].isdigit()]
    assert len(beats) == sum(len(one.time) for one in fig8.held)
    assert "error of the" in Path(plot).read_text()
    assert run(*FIG8, "-o", data)[0] == code
    with xr.open_dataset(data, engine="h5netcdf") as found:
        np.testing.assert_allclose(found.settling.values[:, 0], [one.settling or np.nan for one in fig8.held])


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--angle", "40"), "angle must be at most 31.2 deg, the bend_max_deg of joint II, but is 40 deg"),
        (("--angle", "20,20"), "angle must be at most 18.2 deg, the bend_max_deg of joint I, but is 20 deg"),
        (("--frequency", "9"), "frequency must be at most 8 Hz, the controller.frequency_max_hz of hypertuna"),
        (("--angle", "10,20,30"), "angle must be 2 values, for joint groups I, II"),
        (("--frequency", "0"), "frequency must be greater than 0"),
        (("--frequency", "1:6"), "--frequency must be a number or start:stop:count"),
        (("--duration", "0.1"), "duration must be from two beats to 600 s"),
    ],
)
def test_posture_test_refuses(run: Run, options: tuple[str, ...], told: str) -> None:
    code, _, errors = run(*_with(FIG8, options))
    assert code == 2
    assert told in errors
