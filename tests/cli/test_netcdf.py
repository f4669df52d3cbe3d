"""NetCDF files of the commands: the checker of the CF conventions finds nothing in any of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import xarray as xr
from typer.main import get_command

import hypertuna as ht
from cf_checker import cf_issues
from hypertuna.cli.main import app
from hypertuna.io.files import dataset, write_netcdf
from program import Run

TANK = Path(__file__).parents[2] / "examples" / "tank"
GRID = ("--frequency", "1:2:2", "--amplitude", "8,15", "--phase", "0,40")
GAIT = ("--gait", "optimised-0.3")
COMMANDS = [
    ("swim", *GAIT),
    ("sweep", *GRID, "--check-rest"),
    ("turn", *GRID, "--bias", "10,10"),
    ("pump", "--frequency", "1,2", "--over", "joints.II.actuator.lever_m=0.005:0.009:2"),
    ("joint bend", "--joint", "I", "--unload"),
    ("joint bend", "--joint", "I", "--material", "all"),
    ("pareto", "--population", "4", "--generations", "1", "--no-polish"),
    ("twin", *GAIT, "--duration", "1"),
    ("twin", *GAIT, "--duration", "1", "--medium", "air"),
    ("dive", *GAIT, "--duration", "4"),
    ("mission", "box", "--seeds", "0:2", "--duration", "2"),
    ("posture-test", "--frequency", "1", "--angle", "5,5", "--duration", "3"),
    ("replay", str(TANK / "angles.csv"), "--columns", "joint_I,joint_II"),
    ("replay", str(TANK / "tank.toml")),  # a group for each recording
]
# Checked by the tests marked fe, where that extra is installed, and below.
ELSEWHERE = {"fe bend", "fe map", "shards merge"}


def writers(command: Any, name: str = "") -> Iterator[str]:
    """Name the commands that offer to write .nc files."""
    for word, one in getattr(command, "commands", {}).items():
        yield from writers(one, f"{name} {word}".strip())
    if any(".nc" in (getattr(option, "help", None) or "") for option in command.params):
        yield name


def groups(file: Path) -> Iterator[Path]:
    """Yield a file, and each of its groups as a file of its own, with the attributes of the whole."""
    yield file
    with xr.open_datatree(file, engine="h5netcdf", decode_cf=False) as tree:
        for name, group in tree.children.items():
            data = group.to_dataset(inherit=False).assign_attrs(tree.attrs)
            for variable in data.variables.values():
                variable.encoding["_FillValue"] = variable.attrs.pop("_FillValue", None)
            data.to_netcdf(file.with_name(f"{file.stem}-{name}.nc"), engine="h5netcdf")
            yield file.with_name(f"{file.stem}-{name}.nc")


def test_every_file_of_a_command_is_by_the_conventions(run: Run, tmp_path: Path) -> None:
    assert {command[0] for command in COMMANDS} | ELSEWHERE == {*writers(get_command(app))}
    files = []
    for k, (command, *options) in enumerate(COMMANDS):
        file = tmp_path / f"{k}-{command.replace(' ', '-')}.nc"
        code, _, errors = run(*command.split(), *options, "--robot", "hypertuna", "-o", str(file))
        assert code in (0, 1), errors
        files += groups(file)
    assert len(files) == len(COMMANDS) + 1
    shards, merged = str(tmp_path / "a.shards"), tmp_path / "merged.nc"
    assert run("sweep", *GRID, "--robot", "hypertuna", "-o", shards)[0] == 0
    assert run("shards", "merge", shards, "-o", str(merged))[0] == 0
    files.append(merged)
    assert cf_issues(*files) == ""


def test_a_sweep_in_degrees_and_a_run_at_sea_are_by_the_conventions(tuna: ht.Robot, tmp_path: Path) -> None:
    gaits = ht.Gaits.grid_degrees(frequency=[1, 2], amplitude=[(8, 15)], phase=[(0, 40), (0, 60)])
    sea = ht.twin_at_sea(tuna, ht.named_gait(tuna, "optimised-0.3"), duration=2.0)
    files = [write_netcdf(data, tmp_path / f"{k}.nc") for k, data in enumerate((ht.sweep(tuna, gaits), sea.dataset()))]
    assert cf_issues(*files) == ""


def test_the_checker_finds_what_is_wrong(tmp_path: Path) -> None:
    data = dataset({"status": ("gait", [0, 1]), "x": ("gait", [0.0, 1.0], "bl", "way")}, {}, {})
    report = cf_issues(write_netcdf(data, tmp_path / "wrong.nc"))
    assert 'units for x, "bl" are not recognized by UDUNITS' in report
    assert "highly recommended for variable status" in report


def test_labels_and_time_of_a_file_select(run: Run, tmp_path: Path) -> None:
    """As the manual has it."""
    assert run("twin", *GAIT, "--duration", "1", "--robot", "hypertuna", "-o", str(tmp_path / "twin.nc"))[0] == 0
    with xr.open_dataset(tmp_path / "twin.nc") as data:
        angle = data.set_index(joint="joint_name").angle.sel(joint="II", elapsed_time=0.5, method=None)
    assert angle.attrs["units"] == "rad"
    assert data.attrs["Conventions"] == "CF-1.11"
