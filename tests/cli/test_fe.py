"""The commands `hypertuna fe geometry` and `fe bend`: what they print, write and draw, what they say of bad input."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomlkit
import xarray as xr

import hypertuna as ht
from cf_checker import cf_issues
from hypertuna.fe import bend as path_module
from hypertuna.fe import extra as fe_extra
from hypertuna.fe import pictures as fe_pictures
from hypertuna.fe.geometry import joint_body
from hypertuna.fe.newton import Equilibrium
from hypertuna.fe.plots import plot_fe_bend
from hypertuna.io.extras import install_command
from program import Run

BEND = ("fe", "bend", "--robot", "hypertuna", "--joint", "II")
PRESSURES = ("--pressure", "40,80", "--mesh", "coarse")
FISH = Path(ht.load("hypertuna").file)


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> str:
    """HyperTuna with a joint II of one pair of drive units and one segment: seconds instead of a minute."""
    document = tomlkit.parse(FISH.read_text())
    joint = document["joints"][1]  # type: ignore[index]
    joint["drive_units"] = 1
    joint["actuator"] |= {"segment_length_m": [0.03], "semi_major_m": [0.014], "semi_minor_m": [0.013]}
    file = tmp_path_factory.mktemp("small") / "small.toml"
    file.write_text(tomlkit.dumps(document))
    return str(file)


@pytest.fixture(scope="module")
def whole(small: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a finished run of the small joint, with its pictures and what it printed."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    files = ("-o", str(folder), "--plot", str(folder.parent / "plot.svg"), "--json")
    done = subprocess.run(program(small, *files), capture_output=True, text=True, check=True, timeout=300)
    (folder.parent / "printed.json").write_text(done.stdout)
    for part in (r"1 of 2, \d+ s, about \d+", r"2 of 2, \d+ s, about 0"):
        assert re.search(rf"^pressures: {part} s left$", done.stderr, re.MULTILINE)
    # Slow machines print more of these lines; no talk of VTK, NGSolve or Netgen.
    assert re.fullmatch(r"((pressures|pictures)(: \d of \d)?, \d+ s(, about \d+ s left)?\n)+", done.stderr)
    return folder


def program(robot: str, *options: str) -> list[str]:
    """Command that bends the small joint, in a process of its own."""
    return [sys.executable, "-m", "hypertuna", "fe", "bend", "--robot", robot, "--joint", "II", *PRESSURES, *options]


def record(folder: Path) -> dict[str, Any]:
    """Return what a run tells, without what it took."""
    told: dict[str, Any] = json.loads((folder / "bend.json").read_text())
    for facts in (told, *told["steps"]):
        facts.pop("seconds")
    return told


def test_help_is_in_the_order_of_the_work_and_tells_what_is_taken(run: Run) -> None:
    commands = ["geometry", "bend", "compare", "map"]
    assert re.findall(rf"^\W*({'|'.join(commands)}) ", run("fe", "--help")[1], flags=re.MULTILINE) == commands
    for command, mesh in (("bend", "medium"), ("compare", "medium"), ("map", "coarse")):
        text = " ".join(run("fe", command, "--help")[1].split())
        assert f"coarse, medium, fine. [default: {mesh}]" in text
        assert "(default: the robot's)" in text
        for option in ("--material", "--law", "--poisson", "--mesh"):
            assert option in text


def test_geometry_is_told_without_the_extra(run: Run, tuna: ht.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hypertuna.io.extras.find_spec", lambda name: None)
    code, output, _ = run("fe", "geometry", "--robot", "hypertuna", "--joint", "2", "--json")
    told = json.loads(output)
    assert code == 0
    assert (told["joint"], told["robot_hash"], told["file"]) == ("II", tuna.hash, None)
    assert told["station_mm"] == pytest.approx([0, 20, 40, 60])
    assert told["semi_major_mm"][1:3] == pytest.approx([(31.81 + 26.75) / 2, (26.75 + 23.0) / 2])  # between middles
    places = [(channel["side"], round(channel["y_mm"], 9)) for channel in told["channels"]]
    actuator, unit = tuna.joints[1].actuator, tuna.drive_unit
    assert actuator is not None
    assert unit is not None
    lever = round(1e3 * actuator.lever, 9)
    assert places == 3 * [(0, lever)] + 3 * [(1, -lever)]
    heights = [1e3 * k * actuator.spacing for k in (-1, 0, 1)]
    assert [channel["z_mm"] for channel in told["channels"]] == pytest.approx(2 * heights)
    assert (
        f"3 pairs of channels of {1e3 * unit.outer_diameter:g} mm"
        in run("fe", "geometry", "--robot", "hypertuna", "--joint", "II")[1]
    )


@pytest.mark.fe
@pytest.mark.parametrize("suffix", [".step", ".stl"])
def test_geometry_files_hold_the_body(run: Run, tuna: ht.Robot, tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"body{suffix}"
    assert run("fe", "geometry", "--robot", "hypertuna", "--joint", "II", "-o", str(file))[0] == 0
    body = joint_body(tuna, "II")
    ends = math.pi * (body.semi_major[[0, -1]] * body.semi_minor[[0, -1]]).sum() * body.plate
    expected = 1e9 * (body.volume + ends)  # mm^3
    if suffix == ".step":
        from netgen.occ import OCCGeometry

        shape = OCCGeometry(str(file)).shape
        assert shape.mass == pytest.approx(expected, rel=1e-4)
        assert len(shape.solids) == 3  # connector plate, matrix, tip plate
        return
    import pyvista as pv

    surface = pv.read(file).clean()
    assert surface.volume == pytest.approx(expected, rel=0.01)
    assert surface.n_open_edges == 0  # no triangle lacks a neighbor


@pytest.mark.fe
def test_a_run_prints_what_its_files_hold(whole: Path) -> None:
    told = json.loads((whole.parent / "printed.json").read_text())
    assert told == json.loads((whole / "bend.json").read_text())
    assert (told["status"], told["mesh"], told["joint"]) == ("converged", "coarse", "II")
    assert not {"joints", "water", "areas"} & set(told)  # the model of the water has no part in it
    steps = told["steps"]
    assert [step["pressure_kpa"] for step in steps] == [40, 80]
    bends = [step["bend_deg"] for step in steps]
    assert 1 < bends[0] < bends[1]
    assert steps[1]["oil_taken_ml"] > steps[0]["oil_taken_ml"] > 0.01
    assert steps[1]["stress_max_kpa"] > steps[1]["stress_99_kpa"] > steps[0]["stress_99_kpa"] > 0
    text = (whole / "bend.csv").read_text()
    assert not {"None", "False", "True"} & set(re.split(r"[,:\n ]", text))
    lines = text.splitlines()
    assert [float(line.split(",")[1]) for line in lines[1:]] == bends
    labeled = xr.load_dataset(whole / "bend.nc")
    np.testing.assert_allclose(np.degrees(labeled.angle), bends)
    assert labeled.attrs["command"].startswith("hypertuna fe bend --robot")
    assert cf_issues(whole / "bend.nc") == ""


@pytest.mark.fe
def test_fields_are_those_that_were_measured(whole: Path) -> None:
    import pyvista as pv

    told = json.loads((whole / "bend.json").read_text())["steps"]
    bent = pv.read(whole / "volume-001.vtu")
    assert list(bent.point_data) == ["displacement [m]", fe_pictures.STRESS, fe_pictures.STRAIN]
    np.testing.assert_allclose(bent.bounds, (0, 0.033, -0.013, 0.013, 0, 0.014), atol=1e-4)  # m: half of it, with plate
    tip = bent.points[:, 0] > 0.0329
    angle, off = np.radians(told[1]["bend_deg"]), bent.points[tip, 1].mean()  # the points' mean is not the center
    moved = (bent.points + bent["displacement [m]"])[tip].mean(axis=0)[:2] + off * np.array(
        [np.sin(angle), -np.cos(angle)]
    )
    assert 1e3 * moved == pytest.approx([told[1]["tip_x_mm"], told[1]["tip_y_mm"]], abs=0.2)
    assert 1e-3 * np.quantile(bent[fe_pictures.STRESS], 0.99) == pytest.approx(told[1]["stress_99_kpa"], rel=0.5)
    assert np.quantile(bent[fe_pictures.STRAIN], 0.99) == pytest.approx(told[1]["strain_99"], rel=0.5)


@pytest.mark.fe
def test_pictures_show_the_bend(whole: Path) -> None:
    from matplotlib.image import imread

    for kind in ("stress", "strain"):
        first, bent = (imread(whole / f"{kind}-00{k}.png")[..., :3] for k in (0, 1))
        assert first.shape == bent.shape  # one camera for all
        assert np.abs(first - bent).max() > 0.5
        left = bent[:, : bent.shape[1] * 8 // 10]  # without the color bar
        assert (np.ptp(left, axis=2) > 0.3).mean() > 0.05  # colors, not gray alone
    strip = whole / "filmstrip.png"
    assert strip.stat().st_size < 200_000
    assert 900 < imread(strip).shape[1] < 1100


@pytest.mark.fe
def test_colors_end_where_nearly_all_walls_do(whole: Path) -> None:
    film = fe_pictures.read_film(whole)
    walls = film.faces[-1]["left"][fe_pictures.STRESS]
    assert np.quantile(walls, 0.98) <= film.top("stress") <= 2 * np.quantile(walls, 0.98)
    assert film.text(1).startswith("80 kPa: ")


@pytest.mark.fe
def test_killed_it_goes_on_where_it_was(small: str, whole: Path, run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    job = subprocess.Popen(program(small, "-o", str(folder), "--no-pictures"), stdout=subprocess.DEVNULL)
    journal, deadline = folder / "journal.jsonl", time.monotonic() + 120
    while time.monotonic() < deadline and (not journal.exists() or journal.read_bytes().count(b"\n") < 2):
        time.sleep(0.02)
    os.kill(job.pid, signal.SIGKILL)
    job.wait()
    kept = journal.read_text().splitlines()
    assert len(kept) == 2  # header and one pressure: the other was under way
    arguments = program(small, "-o", str(folder), "--no-pictures", "--json")[3:]
    code, output, _ = run(*arguments)
    assert code == 0
    assert journal.read_text().splitlines()[: len(kept)] == kept  # nothing was done twice
    expected, found = record(whole), record(folder)
    for facts in (expected, found):
        facts.pop("command")
    assert found == expected  # to the last digit
    assert json.loads(output)["steps"][1]["bend_deg"] == expected["steps"][1]["bend_deg"]
    code, _, errors = run(*arguments, "--side", "right")
    assert code == 2
    assert "was started with side = 'left', but now it is 'right'" in errors


@pytest.mark.fe
def test_a_failed_step_keeps_what_converged(
    run: Run, small: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = path_module.equilibrium

    def stubborn(model: Any, *, pressure: tuple[float, float]) -> Equilibrium:
        return (
            Equilibrium(False, 7, "the tangent is singular") if max(pressure) > 5e4 else real(model, pressure=pressure)
        )

    monkeypatch.setattr(path_module, "equilibrium", stubborn)
    arguments = program(small, "-o", str(tmp_path / "run"), "--no-pictures")[3:]
    code, output, _ = run(*arguments)
    assert code == 1
    assert "80 kPa was not reached (the tangent is singular); results end at 40 kPa." in output
    told = record(tmp_path / "run")
    assert [step["pressure_kpa"] for step in told["steps"]] == [40]
    assert told["status"] == "failed"


@pytest.mark.fe
def test_a_run_that_reaches_nothing_says_so(
    run: Run, small: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(path_module, "equilibrium", lambda model, pressure: Equilibrium(False, 1, "no step goes down"))
    arguments = program(small, "-o", str(tmp_path / "run"), "--plot", str(tmp_path / "plot.svg"))[3:]
    code, output, _ = run(*arguments)
    assert code == 1
    assert "40 kPa was not reached (no step goes down); there are no results." in output
    assert record(tmp_path / "run")["steps"] == []
    assert not (tmp_path / "plot.svg").exists()  # nothing to draw, and it is not said to be written
    assert "plot.svg" not in output


def test_the_figure_shows_what_it_is_given() -> None:
    pressure, angle = [0.0, 1e5, 2.5e5], [0.0, 0.1, 0.2]
    alone = plot_fe_bend(pressure, angle)
    np.testing.assert_allclose(alone.axes[0].lines[0].get_xydata()[-1], [250, math.degrees(0.2)])
    oil, other = [0.0, 4e-7, 1e-6], ([0.0, 2.5e5], [0.0, 0.3], [0.0, 9e-7])
    both = plot_fe_bend(pressure, angle, oil, analytic=other, published=(2.5e5, 0.31), title="joint II")
    labels = [text.get_text() for text in both.legends[0].get_texts()]
    assert labels == ["fast model (no friction)", "finite elements", "published"]
    np.testing.assert_allclose(both.axes[1].lines[-1].get_xydata()[-1], [1, 250])


@pytest.mark.parametrize(("value", "rounded"), [(0, 1), (0.31, 0.4), (61, 80), (80, 80), (81, 100), (1.2, 1.5)])
def test_the_colors_end_at_a_round_number(value: float, rounded: float) -> None:
    assert fe_pictures._round_up(value) == pytest.approx(rounded)


BAD = {
    "joint": ((*BEND[:-1], "III"), "joint must be a joint of hypertuna, but is 'III': did you mean II?"),
    "robot": (
        (*BEND[:3], "rexeel", "--joint", "1"),
        "robots/rexeel.toml: drive_unit is missing: add the table [drive_unit].",
    ),
    "falling": (
        (*BEND, "--pressure", "60,30"),
        "60 kPa, then 30 kPa: write the lower one first, and each once: 30,60.",
    ),
    "twice": (
        (*BEND, "--pressure", "60,60"),
        "60 kPa, then 60 kPa: write the lower one first, and each once: 60.",
    ),
    "many": ((*BEND, "--pressure", "0:250:201"), "--pressure must be at most 200 pressures, but is 201: ask for fewer"),
    "jointless": (BEND[:-2], "`hypertuna fe bend` needs --joint JOINT"),
    "negative": ((*BEND, "--pressure", "-50:250:4"), "pressure must not be negative, but is -50 kPa"),
    "pascal": ((*BEND, "--pressure", "250000"), "--pressure must be at most 2000, but is 250000: give it in kPa"),
    "word": ((*BEND, "--poisson", "soft"), "--poisson must be a number, but is 'soft'"),
    "plot": ((*BEND, "--plot", "bend.txt"), "--plot must end in .svg, .png or .pdf"),
    "drawing": (("fe", "geometry", *BEND[2:], "-o", "body.obj"), "--output must end in .step, .stp or .stl"),
    "nowhere": (("fe", "geometry", *BEND[2:], "-o", "nowhere/a.stl"), "--output must be in a folder that exists"),
    "other": (("fe", "geometry", *BEND[2:-1], "III"), "joint must be a joint of hypertuna"),
}


@pytest.mark.parametrize(("arguments", "sentence"), BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_sentence(run: Run, arguments: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run(*arguments)
    assert (code, output) == (2, "")
    assert sentence in errors
    assert errors.count("\n") == 1


BAD_OPTIONS = {
    "material": (("--material", "rubber"), "must be a known material set, but is 'rubber'"),
    "law": (("--law", "hooke"), "but is 'hooke': use one of linear, neo_hookean, mooney_rivlin; linear is Hooke's."),
    "mesh": (("--mesh", "tiny"), "mesh must be a known mesh, but is 'tiny': use one of coarse, medium, fine"),
    "poisson": (("--poisson", "0.5"), "poisson must be at least 0 and less than 0.5, but is 0.5"),
    "stretchy": (("--poisson", "-0.1"), "poisson must be at least 0 and less than 0.5, but is -0.1"),
    "side": (("--side", "up"), "side must be left or right, but is 'up'"),
}


@pytest.mark.fe
@pytest.mark.parametrize(("options", "sentence"), BAD_OPTIONS.values(), ids=BAD_OPTIONS.keys())
def test_bad_options_leave_no_folder(run: Run, tmp_path: Path, options: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run(*BEND, *options, "-o", str(tmp_path / "run"))
    assert (code, output) == (2, "")
    assert sentence in errors
    assert errors.count("\n") == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.fe
def test_a_folder_that_cannot_be_made_is_bad_input(run: Run, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    said = {"file": "must be a folder, but is the file", "file/run": "must be a folder that can be made, but is"}
    said["nowhere/run"] = said["file/run"]
    for place, sentence in said.items():
        code, output, errors = run(*BEND, "-o", str(tmp_path / place))
        assert (code, output) == (2, "")
        assert f"--output {sentence} {tmp_path / place}" in errors


@pytest.mark.fe
def test_a_folder_with_files_of_ones_own_is_left_alone(run: Run, tmp_path: Path) -> None:
    (tmp_path / "bend.csv").write_text("precious")
    code, output, errors = run(*BEND, "-o", str(tmp_path))
    assert (code, output) == (2, "")
    assert "--output must be a new or empty folder, or one that such a run made, but is" in errors
    assert (tmp_path / "bend.csv").read_text() == "precious"


def test_without_the_extra_the_command_says_how_to_get_it(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hypertuna.io.extras.find_spec", lambda name: None)
    for command in (BEND, ("fe", "map", *BEND[2:], "-o", str(tmp_path / "a.shards"))):
        code, output, errors = run(*command)
        assert (code, output) == (2, "")
        assert " ".join(errors.split()).endswith(f"is not installed: {install_command('fe')}.")
    assert not [*tmp_path.iterdir()]


@pytest.mark.fe
def test_where_nothing_can_draw_it_is_said_before_the_work(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fe_extra, "_loadable", lambda library: False)
    code, output, errors = run(*BEND, "-o", str(tmp_path / "run"))
    assert (code, output) == (2, "")
    assert "apt-get install libosmesa6, or leave the pictures out with --no-pictures" in errors
    assert not (tmp_path / "run").exists()
