"""Silicone: tensile tests read and fitted, made up ones exactly, and the one behind the shipped constants."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.silicone import Mooney, fit_silicone, read_tensile
from hypertuna.cli.main import main
from hypertuna.errors import InputError

DATA = Path(__file__).parents[3] / "shared" / "data" / "silicone"
HEADER = "PARAMETER;INFO;URL;;\nMaterial;Jelly;;;\n;;;;\n"
NAMES = "Time (s);True Strain;True Stress (MPa);Engineering Strain;Engineering Stress (MPa)\n"


def written(path: Path, c1: float, c2: float, *, ragged: bool = False, header: str = HEADER + NAMES) -> Path:
    """Write the test of a Mooney-Rivlin solid, in the columns of the Soft Robotics Materials Database."""
    rows = []
    for k, strain in enumerate(np.linspace(0, 2, 41)):
        stretch = 1 + strain
        stress = 2 * (stretch - stretch**-2) * (c1 + c2 / stretch) / 1e6
        cells = (0.1 * k, np.log(stretch), stress * stretch, strain, stress)
        rows.append(";".join(f"{cell:.12g}" for cell in (cells[:4] if ragged and k % 4 == 0 else cells)))
    path.write_text(header + "\n".join(rows) + "\n;;;;\n")
    return path


def test_a_solid_is_found_again(tmp_path: Path) -> None:
    test = read_tensile(written(tmp_path / "a.csv", 30e3, 8e3))
    fit = fit_silicone(test)
    assert (test.name, len(test.strain), test.omitted) == ("Jelly", 41, 0)
    assert fit.solid == pytest.approx((30e3, 8e3), rel=1e-6)
    assert fit.free == pytest.approx(fit.solid, rel=1e-6)
    assert fit.rms == pytest.approx(0, abs=1e-3)
    assert fit.stress_100 == pytest.approx(fit.solid.modulus_100, rel=1e-6) == pytest.approx(3.5 * 34e3)
    assert fit.solid.modulus == pytest.approx(6 * 38e3)
    assert fit.status == "Fitted to 20 rows up to 100 % strain."
    assert fit_silicone(test, up_to=2).points == 40


def test_short_rows_are_omitted_and_counted(tmp_path: Path) -> None:
    test = read_tensile(written(tmp_path / "a.csv", 30e3, 8e3, ragged=True))
    assert (len(test.strain), test.omitted) == (30, 11)
    assert fit_silicone(test).solid == pytest.approx((30e3, 8e3), rel=1e-6)


def test_true_stress_and_other_units_will_do(tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", 30e3, 8e3)
    table = [line.split(";") for line in path.read_text().splitlines()[4:]]
    rows = [f"{cells[1]},{1e3 * float(cells[2])}" for cells in table if cells[0]]
    path.write_text("\n".join(["True Strain,True Stress (kPa)", *rows]))
    test = read_tensile(path)
    assert test.name == "a"
    assert fit_silicone(test).solid == pytest.approx((30e3, 8e3), rel=1e-6)


def test_percent_in_the_name_is_a_hundredth(tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", 30e3, 8e3)
    table = [line.split(";") for line in path.read_text().splitlines()[4:]]
    rows = [f"{100 * float(cells[3])},{cells[4]}" for cells in table if cells[0]]
    path.write_text("\n".join(["Engineering Strain (%),Engineering Stress (MPa)", *rows]))
    assert fit_silicone(read_tensile(path)).solid == pytest.approx((30e3, 8e3), rel=1e-6)


def test_the_strain_that_the_data_reach_is_told(tmp_path: Path) -> None:
    fit = fit_silicone(read_tensile(written(tmp_path / "a.csv", 30e3, 8e3)), up_to=10)
    assert (fit.up_to, fit.requested) == (2, 10)
    assert fit.status == "Fitted to 40 rows up to 200 % strain, where the test ends (1000 % was requested)."


def test_a_negative_constant_is_kept_out(tmp_path: Path) -> None:
    """The best fit that is allowed has C2 = 0: then C1 is a ratio of sums."""
    test = read_tensile(written(tmp_path / "a.csv", 30e3, -8e3))
    fit = fit_silicone(test)
    stretch = 1 + test.strain[1:21]
    basis = 2 * (stretch - stretch**-2)
    assert fit.solid == pytest.approx((basis @ test.stress[1:21] / (basis @ basis), 0), rel=1e-9)
    assert fit.free == pytest.approx((30e3, -8e3), rel=1e-6)
    assert "C2 is at its bound of 0: unconstrained, C1 = 30.0 kPa, C2 = -8.0 kPa" in fit.status


@pytest.mark.parametrize(("key", "file"), [("EC50", "ecoflex-00-50.csv"), ("DR10", "dragon-skin-10-medium.csv")])
def test_the_shipped_constants_are_those_of_the_public_tests(tuna: ht.Robot, key: str, file: str) -> None:
    if not (DATA / file).exists():
        pytest.skip(f"no {DATA / file}: the Soft Robotics Materials Database is not beside the project")
    fit = fit_silicone(read_tensile(DATA / file))
    assert tuna.materials[key].tensile == tuple(map(round, fit.solid))
    softer = tuna.materials[key].modulus_100 / fit.stress_100
    assert softer == pytest.approx({"EC50": 2.0, "DR10": 1.3}[key], rel=0.05)  # than the data sheet says


BAD = {
    "missing": (None, "bad.csv must be a file, but is missing"),
    "no names": ("1;2\n", "must have a row of names with Engineering Strain and Engineering Stress"),
    "no unit": ("Engineering Strain;Engineering Stress\n0;0\n", "bad.csv:1 must give the unit of the stress as .*none"),
    "odd unit": ("Engineering Strain;Engineering Stress (psi)\n0;0\n", "must give the unit.* but is psi"),
    "a word": (
        "Engineering Strain;Engineering Stress (MPa)\n0;0\n0.1;much\n",
        "bad.csv:3 must be a finite number.*'much'",
    ),
    "1e300": (
        "Engineering Strain;Engineering Stress (MPa)\n0;1e300\n",
        "bad.csv:2 must be from -1e.12 to 1e.12, but is",
    ),
    "nan": ("Engineering Strain;Engineering Stress (MPa)\n0;nan\n", "bad.csv:2 must be a finite number"),
    "too few": (
        "Engineering Strain;Engineering Stress (MPa)\n0;0\n0.1;0.01\n",
        "bad must have 5 rows .* up to 100 %.* is 1",
    ),
    "percent": (
        "Engineering Strain;Engineering Stress (MPa)\n" + "50;1\n" * 9,
        r"bad.csv: Engineering Strain must be a fraction.* but is up to 50: .*\(%\)",
    ),
    "pushed": ("Engineering Strain,Engineering Stress (MPa)\n" + "0.5,-1\n" * 9, "bad must have positive stresses"),
    "pressed": ("Engineering Strain,Engineering Stress (MPa)\n" + "-0.5,-1\n" * 9, "bad must have positive strains"),
}


@pytest.mark.parametrize(("content", "sentence"), BAD.values(), ids=BAD.keys())
def test_bad_files_are_told(tmp_path: Path, content: str | None, sentence: str) -> None:
    path = tmp_path / "bad.csv"
    if content is not None:
        path.write_text(content)
    with pytest.raises(InputError, match=sentence):
        fit_silicone(read_tensile(path))
    with pytest.raises(InputError, match="up_to must be greater than 0"):
        fit_silicone(read_tensile(written(tmp_path / "good.csv", 1e3, 0)), up_to=0)


def test_the_command_tells_what_the_function_finds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path / "a.csv", 30e3, 8e3, ragged=True)
    said = []
    for arguments in (("--json",), ("--up-to", "200"), ("--up-to", "none")):
        monkeypatch.setattr(sys, "argv", ["hypertuna", "joint", "silicone", str(path), *arguments])
        with pytest.raises(SystemExit) as exit_:
            main()
        said.append((exit_.value.code or 0, *capsys.readouterr()))
    told = json.loads(said[0][1])
    fit = fit_silicone(read_tensile(path))
    assert Mooney(*told["tensile_pa"]) == fit.solid
    assert (told["left_out"], told["points"]) == (11, 15)
    assert "Jelly: tensile_pa = [30000, 8000]" in said[1][1]
    assert "11 rows lack strain or stress" in said[1][1]
    assert "up to 195 % strain, where the test ends (200 % was requested)" in said[1][1]
    assert said[2][0] == 2
    assert "--up-to must be a number" in said[2][2]
