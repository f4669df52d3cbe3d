"""The program: what it prints and writes, and what it says of bad input."""

import errno
import json
import math
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from typer.main import get_command

import hypertuna as ht
from hypertuna import _core
from hypertuna.cli import main as cli
from hypertuna.cli.console import plain, progress_bar
from hypertuna.cli.parsing import numbers, ranges
from hypertuna.figures import save
from hypertuna.io.files import version
from program import Run

FAST = ("--frequency", "6", "--amplitude", "16,25", "--phase", "0,40")


def strict(text: str) -> dict[str, object]:
    """Read JSON that has no NaN or infinity."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is not JSON")

    value = json.loads(text, parse_constant=refuse)
    assert isinstance(value, dict)
    return value


def test_swim_says_what_the_function_computes(run: Run) -> None:
    code, output, _ = run("swim", "--robot", "hypertuna", *FAST, "--json")
    told = strict(output)
    swim = ht.swim(ht.load("hypertuna"), ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40)))
    assert code == 0
    assert told["speed_m_s"] == swim.speed
    assert told["speed_bl_s"] == swim.speed_bl
    assert told["mechanical_power_w"] == swim.mechanical_power
    assert told["cost_of_transport_j_per_kg_m"] == swim.cost_of_transport
    assert told["strouhal"] == swim.strouhal
    assert told["stride_length"] == swim.stride_length
    assert told["spectral_radius"] == swim.spectral_radius
    assert (told["status"], told["settled"], told["beats"]) == ("settled", True, swim.beats)
    assert told["status_text"] == swim.status_text
    assert told["turn_radius_m"] is None  # infinite
    code, output, _ = run("swim", "--robot", "hypertuna", *FAST)
    assert code == 0
    assert f"{swim.speed:.4g}  m/s" in output
    assert swim.status_text in output


def test_swim_chooses_the_model(run: Run) -> None:
    def speed(*options: str) -> object:
        return strict(run("swim", "--robot", "hypertuna", "--gait", "unoptimised-max", "--json", *options)[1])[
            "speed_m_s"
        ]

    fish = ht.load("hypertuna")
    gait = fish.gaits["unoptimised-max"]
    for choice in ({"joints": "ideal"}, {"areas": "as-printed"}, {"water": "strip"}):
        options = [part for key, value in choice.items() for part in (f"--{key}", value)]
        assert (
            speed(*options) == ht.swim(fish.using(**choice), ht.Gait(gait.frequency, gait.amplitude, gait.phase)).speed
        )
    changed = ht.swim(fish, ht.Gait(3.0, gait.amplitude, gait.phase))
    assert speed("--frequency", "3") == pytest.approx(changed.speed, rel=1e-9)
    assert speed("--bias", "5,5") != speed()


def test_swim_from_rest_is_unsettled_when_short(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "rest.nc"
    arguments = ("--from-rest", "2", "--current", "0.1,0", "-o", str(file))
    code, output, _ = run("swim", "--robot", "hypertuna", *FAST, *arguments, "--json")
    told = strict(output)
    assert (code, told["status"], told["settled"]) == (1, "unsettled", False)
    with xr.open_dataset(file) as motion:
        assert motion.elapsed_time[-1] == pytest.approx(2)
        assert motion.x.attrs["units"] == "m"
        assert motion.attrs["speed_m_s"] == told["speed_m_s"]
        assert motion.attrs["command"].startswith("hypertuna swim --robot hypertuna --frequency 6")
        assert motion.attrs["robot_hash"] == ht.load("hypertuna").hash


@pytest.mark.parametrize("robot", ["hypertuna", "rexeel"])
def test_sweep_gives_every_gait(run: Run, robot: str, tmp_path: Path) -> None:
    fish = ht.load(robot)
    lags = ",".join(f"{math.degrees(p):g}" for p in next(iter(fish.gaits.values())).phase[:-1])
    amplitudes = (",".join(["10"] * len(fish.joints)), ",".join(["5"] * len(fish.joints)))
    grid = (
        "--frequency",
        "0.5:1:3",
        "--phase",
        f"{lags},0:90:4",
        "--amplitude",
        amplitudes[0],
        "--amplitude",
        amplitudes[1],
    )
    table = tmp_path / "sweep.csv"
    code, output, _ = run("sweep", "--robot", robot, *grid, "-o", str(table), "--json")
    gaits = strict(output)["gaits"]
    assert isinstance(gaits, list)
    assert (code, len(gaits)) == (0, 3 * 4 * 2)
    last = fish.joints[-1].name
    for told in gaits[::5]:
        angles = {
            key: [told[f"{key}_{group.name}_deg"] for group in fish.joints] for key in ("amplitude", "phase", "bias")
        }
        swim = ht.swim(fish, ht.Gait.from_degrees(frequency=told["frequency_hz"], **angles))
        assert told["speed_m_s"] == pytest.approx(swim.speed, rel=1e-9)
        assert told["status"] == swim.status
    lines = table.read_text().splitlines()
    assert len(lines) == 1 + len(gaits)
    assert dict(zip(lines[0].split(","), lines[-1].split(","), strict=True))[f"phase_{last}_deg"] == "90.0"
    file = tmp_path / "sweep.nc"
    assert run("sweep", "--robot", robot, *grid, "-o", str(file))[0] == 0
    with xr.open_dataset(file) as found:
        assert found.speed.values.ravel() == pytest.approx([told["speed_m_s"] for told in gaits], rel=1e-12)


def test_sweep_of_many_shows_the_best(run: Run) -> None:
    arguments = ("--frequency", "1:6:6", "--amplitude", "16,25", "--phase", "0,0:100:11")
    _, output, _ = run("sweep", "--robot", "hypertuna", *arguments)
    told = strict(run("sweep", "--robot", "hypertuna", *arguments, "--json")[1])["gaits"]
    assert isinstance(told, list)
    best = max(gait["speed_m_s"] for gait in told)
    (line,) = [line for line in output.splitlines() if "fastest" in line]
    assert f" {best:.3g} " in line
    assert len(output.splitlines()) < 10


@pytest.mark.parametrize(
    "arguments",
    [
        ("--amplitude", "8,15", "--amplitude", "16,25", "--phase", "0,0:100:2"),
        ("--amplitude", "8,15", "--amplitude", "16,25", "--phase", "0,0:100:2", "--bias", "0,0:2:2"),
        ("--amplitude", "8,15", "--amplitude", "16,25", "--phase", "0,0:100:11"),
    ],
)
def test_sweep_fits_80_columns(run: Run, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    _, output, _ = run("sweep", "--robot", "hypertuna", "--frequency", "5:6:2", *arguments)
    rows = [line for line in output.splitlines()[1:] if any(digit in line for digit in "0123456789")]
    assert len(rows) in (2, 8, 16)
    assert all(row.endswith(" settled") for row in rows)
    assert "amplit" not in output.replace("amplitude", "")


@pytest.mark.parametrize(
    ("command", "line"),
    [
        ("fe bend", "--poisson NUMBER"),
        ("range", "--reserve NUMBER"),
        ("replay", "--start m,m,deg "),
        ("radio calibrate", "--at NUMBER,..."),
        ("paper", "--output FOLDER"),
    ],
)
def test_help_has_plain_metavars(run: Run, command: str, line: str) -> None:
    _, output, _ = run(*command.split(), "--help")
    assert line in output


def test_help_of_identify_has_the_log_scale_beside_the_other_options(run: Run) -> None:
    _, output, _ = run("identify", "--help")
    assert "<" not in output  # no type in Python's words
    assert output.index("--log NAME") < output.index("Output:")


def test_version(run: Run) -> None:
    assert run("--version") == (0, f"hypertuna {version()}\n", "")
    _, output, _ = run("version")
    assert version() in output
    assert _core.isa() in output
    assert strict(run("version", "--json")[1])["isas"] == _core.isas()


SWIM = ("swim", "--robot", "hypertuna")
BAD = {
    "no number": ((*SWIM, "--frequency", "six", *FAST[2:]), "frequency must be a number, but is 'six'"),
    "no finite number": ((*SWIM, "--frequency", "nan", *FAST[2:]), "frequency must be a finite number, but is nan"),
    "frequency 0": ((*SWIM, "--frequency", "0", *FAST[2:]), "frequency must be greater than 0, but is 0"),
    "negative amplitude": ((*SWIM, *FAST[:2], "--amplitude", "16,-1", *FAST[4:]), "amplitude[1] must not be negative"),
    "too few": ((*SWIM, *FAST[:2], "--amplitude", "16", *FAST[4:]), "--amplitude must be 2 values"),
    "too many": ((*SWIM, *FAST, "--bias", "1,2,3"), "--bias must be 2 values"),
    "missing": ((*SWIM, *FAST[:4]), "--phase is missing"),
    "robot": (("swim", "--robot", "hypertun", *FAST), "robots/hypertun.toml does not exist: did you mean hypertuna?"),
    "gait": ((*SWIM, "--gait", "turnin"), "did you mean turning?"),
    "joints": ((*SWIM, *FAST, "--joints", "idle"), "--joints must be ideal or bandwidth, but is 'idle'"),
    "steps": ((*SWIM, *FAST, "--steps", "2.5"), "steps must be a whole number, but is '2.5'"),
    "current": ((*SWIM, *FAST, "--current", "1"), "--current must be 2 numbers, but is 1"),
    "plot": ((*SWIM, *FAST, "--plot", "fish.jpg"), "--plot must end in .svg, .png, .pdf or .gif"),
    "folder": ((*SWIM, *FAST, "-o", "missing/fish.nc"), "--output must be in a folder that exists"),
    "option": ((*SWIM, *FAST, "--speed", "1"), "--speed is not an option of `hypertuna swim`"),
    "command": (("swin",), "swin is not a command of `hypertuna`: did you mean "),
    "range": (("sweep", *SWIM[1:], "--frequency", "1:6", *FAST[2:]), "frequency must be a number or start:stop:count"),
    "count": (("sweep", *SWIM[1:], "--frequency", "1:6:0", *FAST[2:]), "frequency's count must be from 1 to "),
    "threads": (("sweep", *SWIM[1:], *FAST, "--threads", "0"), "threads must be at least 1, but is 0"),
    "frequencies": (
        (*SWIM, "--frequency", "6,5", *FAST[2:]),
        "--frequency must be a single value, but is 6 and 5: give one, with a decimal point; `hypertuna sweep`",
    ),
    "no robot": (("swim", "--robot", ".", *FAST), "error: . is a folder: give the path of a TOML file."),
    "one point": (("sweep", *SWIM[1:], *FAST, "--plot", "sweep.svg"), "plot must show several frequencies or phases"),
}


@pytest.mark.parametrize(("arguments", "sentence"), BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_sentence(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, arguments: tuple[str, ...], sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, output, errors = run(*arguments)
    assert code == 2
    assert output == ""
    assert errors.startswith("error: ")
    assert sentence in errors
    assert errors.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("raised", "code", "told"),
    [
        (KeyboardInterrupt(), 130, "interrupted\n"),
        (OSError(errno.ENOSPC, "No space left on device"), 2, "error: standard output: No space left on device.\n"),
        (OSError(errno.EACCES, "Permission denied", "fish.nc"), 2, "error: fish.nc: Permission denied.\n"),
        (
            MemoryError(),
            2,
            "error: there is not enough memory: give the process more, or this command less to do at once.\n",
        ),
        (BrokenPipeError(), 0, ""),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else "",
)
def test_what_stops_the_program_is_told_without_a_traceback(
    run: Run, monkeypatch: pytest.MonkeyPatch, raised: BaseException, code: int, told: str
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise raised

    monkeypatch.setattr("hypertuna.cli.swim.swim", stop)
    got, output, errors = run(*SWIM, *FAST)
    assert (got, output, errors.lstrip("\n")) == (code, "", told)


@pytest.mark.parametrize(
    ("function", "parts", "arguments"),
    [
        ("mission.fly_seeds", "flights are", ("mission", "box", "--seeds", "0:5", "-o", "all.csv")),
        ("sweep.sweep", "gaits are", ("sweep", "--gait", "optimised-max", "-o", "all.csv")),
        ("optimize.optimize", "gaits are", ("optimize", "--maximize", "speed", "-o", "all.toml")),
        ("pareto.pareto", "rounds are", ("pareto", "-o", "all.csv")),
    ],
    ids=lambda value: value.partition(".")[0] if isinstance(value, str) else "",
)
def test_ctrl_c_tells_what_is_done_and_writes_nothing(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, function: str, parts: str, arguments: tuple[str, ...]
) -> None:
    def stop(*_: object, **options: Any) -> None:
        report = options["report" if "report" in options else "progress"]
        report(2, 5)
        raise KeyboardInterrupt

    monkeypatch.setattr(f"hypertuna.cli.{function}", stop)
    monkeypatch.chdir(tmp_path)
    done = f"interrupted: 2 of 5 {parts} done"
    again = " and kept in f; run the same command again to go on\n"
    assert run(*arguments, "--checkpoint", "f") == (130, "", done + again)
    assert run(*arguments) == (130, "", f"{done}, but not kept: --checkpoint FILE keeps them\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_disk_behind_the_output_is_one_sentence() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "hypertuna", "version"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (done.returncode, done.stderr) == (2, "error: standard output: No space left on device.\n")


def test_an_unknown_instruction_set_is_one_sentence() -> None:
    command, wish = [sys.executable, "-m", "hypertuna", "version"], os.environ | {"HYPERTUNA_ISA": "none-such"}
    done = subprocess.run(command, capture_output=True, text=True, env=wish, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("error: HYPERTUNA_ISA must name an instruction set")
    assert "none-such" in done.stderr


def test_what_diverged_is_told_but_not_drawn(run: Run, tmp_path: Path) -> None:
    wild = ("--frequency", "8", "--amplitude", "30,30", "--phase", "0,0", "--steps", "8", "--joints", "ideal")
    for suffix in ("svg", "gif"):
        code, output, errors = run(*SWIM, *wild, "--plot", str(tmp_path / f"fish.{suffix}"))
        assert "The gait diverged" in output
        assert code == 2
        assert errors.splitlines()[-1].startswith("error: plot has nothing finite to draw")
        assert errors.count("error: ") == 1
    assert list(tmp_path.iterdir()) == []


def test_swim_names_the_current_and_the_files(run: Run, tmp_path: Path) -> None:
    file = str(tmp_path / "fish.nc")
    _, output, _ = run(*SWIM, *FAST, "--current", "0.1,0", "-o", file)
    assert "current 0.1, 0 m/s; speed is through the water" in output
    assert f"written: {file}\n" in output
    _, output, _ = run(*SWIM, *FAST)
    assert "current" not in output
    assert "written" not in output
    strict(run(*SWIM, *FAST, "-o", file, "--json")[1])


def test_negative_noise_and_folders_of_angles(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "angles.csv"
    lines = [f"{0.1 * k:.1f},{math.sin(k):.3f},0" for k in range(20)]
    file.write_text("\n".join(["time_s,a,b", *lines]), encoding="utf-8-sig")
    rest = ("--robot", "hypertuna", "--columns", "a,b")
    code, output, errors = run("replay", str(file), *rest, "--noise", "-1")
    assert (code, output) == (2, "")
    assert errors.startswith("error: --noise must not be negative, but is -1: give it in degrees")
    code, _, errors = run("replay", str(tmp_path), *rest)
    assert code == 2
    assert errors.startswith("error: --columns cannot be combined with a manifest or a folder: ")
    code, _, errors = run("replay", str(tmp_path), *rest[:2])
    assert code == 2
    assert errors.startswith(f"error: {tmp_path} holds no known published files: ")
    assert run("replay", str(file), *rest)[0] == 0  # the mark of byte order is no part of the first name


def test_a_robot_file_may_begin_with_a_mark_of_byte_order(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "fish.toml"
    source = Path(__file__).parents[2] / "robots" / "hypertuna.toml"
    file.write_text(source.read_text(encoding="utf-8"), encoding="utf-8-sig")
    assert run("robot", "check", str(file))[0] == 0


@pytest.mark.parametrize("option", ["--plot", "-o"])
def test_an_output_that_cannot_be_written_leaves_nothing(run: Run, tmp_path: Path, option: str) -> None:
    target = tmp_path / ("fish.svg" if option == "--plot" else "fish.nc")
    target.mkdir()  # a folder stands where the file should
    code, _, errors = run("swim", "--robot", "hypertuna", *FAST, option, str(target))
    assert code == 2
    assert errors.startswith("error: ")
    assert [path.name for path in tmp_path.iterdir()] == [target.name]


def test_help_names_every_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "hypertuna", "--help"],
        capture_output=True,
        text=True,
        env=os.environ | {"COLUMNS": "200"},
        check=True,
    )
    assert all(name in done.stdout for name in ("swim", "sweep", "replay", "paper", "robot", "version"))


def test_help_shows_all_that_it_says() -> None:
    """Text in brackets would be taken as markup, and vanish."""
    groups, texts = [get_command(cli.app)], []
    while groups:
        command = groups.pop()
        groups += getattr(command, "commands", {}).values()
        texts += [getattr(option, "help", None) or "" for option in command.params]
    assert len(texts) > 200
    assert [text for text in texts if re.search(r"\[[a-z]", text)] == []


def test_ranges_and_lists() -> None:
    assert ranges("0,0:180:3", "phase", "deg") == [(0, 0), (0, 90), (0, 180)]
    assert ranges("1:2:2,3:4:2", "phase", "deg") == [(1, 3), (1, 4), (2, 3), (2, 4)]
    assert numbers("1,-2.5", "bias", "deg") == (1, -2.5)


def test_plain_values_are_strict_json() -> None:
    value = {"a": np.float64("nan"), "b": np.array([1.0, np.inf]), "c": (np.int64(3), True, None, "x")}
    assert plain(value) == {"a": None, "b": [1.0, None], "c": [3, True, None, "x"]}


def test_progress_is_not_written_into_files(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("working") as report:
        report(1, 2)
        report(2, 2)
    assert capsys.readouterr() == ("", "")


def test_dollar_signs_of_names_are_no_formulas_in_figures(tmp_path: Path) -> None:
    """An open formula would end the drawing; the labels of logarithmic axes stay formulas."""
    figure = Figure()
    axes = figure.subplots()
    axes.semilogy([1, 2], [1, 1000], label="b$x^")
    axes.set_title("run $\\frac{$")
    axes.legend()
    save(figure, tmp_path / "figure.svg")
    text = (tmp_path / "figure.svg").read_text(encoding="utf-8")
    assert "run $\\frac{$" in text
    assert "mathdefault" in text


def test_an_option_with_one_value_is_given_once(run) -> None:
    code, output, error = run("swim", "--gait", "unoptimised-max", "--steps", "64", "--steps", "128")
    assert (code, output) == (2, "")
    assert error == "error: --steps must be given once: remove all but one.\n"
    assert run("turn", "--frequency", "2", "--frequency", "3", "--json")[0] == 2
    assert run("swim", "--gait", "unoptimised-max", "--json", "--json")[0] == 0  # a flag is the same twice


def test_a_sweep_resumes_after_kill(tmp_path: Path) -> None:
    options = ("--frequency", "1:6:150", "--amplitude", "10:16:20,24", "--phase", "0,0:80:10", "--threads", "1")
    command = [sys.executable, "-m", "hypertuna", "sweep", *options, "--steps", "16", "-o"]
    journal = tmp_path / "sweep.journal"
    killed = subprocess.Popen([*command, "killed.csv", "--checkpoint", journal.name], cwd=tmp_path)
    while killed.poll() is None and (not journal.exists() or journal.read_bytes().count(b"\n") < 2):
        time.sleep(0.02)
    killed.kill()
    killed.wait()
    assert killed.returncode == -9
    for name, more in {"whole.csv": [], "killed.csv": ["--checkpoint", journal.name]}.items():
        subprocess.run([*command, name, *more], cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "killed.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
