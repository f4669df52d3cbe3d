"""Datasets as columns and attributes: names, units, rows and words by hand."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from hypertuna.cli.emit import attributes
from hypertuna.io.files import (
    by_conventions,
    columns_csv,
    dataset,
    rows_csv,
    variable_columns,
    version,
    write_atomically,
)
from hypertuna.io.quantity import key_of, scaled


def test_columns_have_labels_and_units() -> None:
    """Labels of a dimension stand in the names of columns; angles are in degrees, pressures in kPa."""
    data = dataset(
        {
            "angle": (("time", "joint"), np.radians([[1.0, 2.0], [3.0, 4.0]]), "rad", "bend"),
            "pressure": (("time", "circuit"), np.array([[1e3], [2e3]]), "Pa", "gauge pressure"),
            "power": ("time", np.array([5.0, np.nan]), "W", "electrical power"),
            "drag": ("time", np.array([1.0, 2.0]), "J/(kg m)", "cost of transport"),
            "rate": ("time", np.array([1.0, 2.0]), "1/s", "speed in body lengths"),
        },
        {"time": ("time", [0.0, 0.5], "s", "time"), "joint": ["I", "II"], "circuit": ["I-left"]},
        {},
    )
    names = {name: name for name in ("time", "angle", "pressure", "drag", "rate")} | {"power": "electrical_power"}
    columns = variable_columns(data, names)
    assert list(columns) == [
        "time_s",
        "angle_I_deg",
        "angle_II_deg",
        "pressure_I_left_kpa",
        "drag_j_per_kg_m",
        "rate_s",
        "electrical_power_w",
    ]
    assert columns["angle_II_deg"] == pytest.approx([2.0, 4.0])
    assert columns["pressure_I_left_kpa"] == pytest.approx([1.0, 2.0])
    table = columns_csv({"robot": "fish"}, {name: columns[name] for name in ("time_s", "electrical_power_w")})
    assert table.text == "time_s,electrical_power_w\n0,5\n0.5,\n"


def test_what_made_a_csv_file_stands_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    columns_csv({"robot": "fish", "counts": np.arange(2)}, {"time_s": [0.0, 0.5], "name": ["a", "b, c"]}).write(path)
    table = pd.read_csv(path)  # as it stands, without options
    assert list(table.columns) == ["time_s", "name"]
    assert table.name.tolist() == ["a", "b, c"]
    assert json.loads((tmp_path / "table.csv.json").read_text()) == {"robot": "fish", "counts": [0, 1]}
    rows_csv({}, [{"a": 1}]).write(tmp_path / "plain.csv")
    assert not (tmp_path / "plain.csv.json").exists()


def test_a_grid_has_a_row_for_each_combination() -> None:
    """Coordinates are repeated along the other dimensions; codes become words."""
    codes = {"flag_values": [0, 1], "flag_meanings": "settled unstable"}
    data = dataset(
        {"status": (("frequency", "phase"), np.array([[0, 1], [1, 0]]), codes)},
        {
            "frequency": ("frequency", [2.0, 3.0], "Hz", "f"),
            "phase_I": ("phase", np.radians([0.0, 40.0]), "rad", "lag"),
        },
        {},
    )
    columns = variable_columns(data, ["frequency", "phase_I", "status"])
    assert columns["frequency_hz"].tolist() == [2.0, 2.0, 3.0, 3.0]
    assert columns["phase_I_deg"].tolist() == [0.0, 40.0, 0.0, 40.0]
    assert columns["status"].tolist() == ["settled", "unstable", "unstable", "settled"]


def test_attributes_are_what_netcdf_holds() -> None:
    record = {"speed_m_s": 0.5, "settled": True, "limits": ["a", "b"], "faults": [], "from_rest_s": None}
    record |= {"joints": [{"name": "I-left", "bias_deg": 1.0}], "amplitude_deg": [16.0, 25.0]}
    assert attributes(record) == {
        "speed_m_s": 0.5,
        "settled": 1,
        "limits": "a; b",
        "faults": "",
        "I_left_bias_deg": 1.0,
        "amplitude_deg": [16.0, 25.0],
    }


def test_cells_are_written_to_digits_or_in_full() -> None:
    columns: dict[str, list[Any]] = {"a": [1 / 3, -0.0, np.nan, 2], "b": ["x", "1.23456789", "", "y"]}
    assert columns_csv({}, columns).text.splitlines()[1:] == ["0.333333,x", "0,1.23456789", ",", "2,y"]
    assert columns_csv({}, columns, digits=2).text.splitlines()[1] == "0.33,x"
    full = [f"{1 / 3},x", "-0.0,1.23456789", "nan,", "2,y"]
    assert columns_csv({}, columns, digits=None).text.splitlines()[1:] == full


def test_rows_have_one_head() -> None:
    rows = [{"a": 1, "b": 2}, {"a": 3, "b": 4}, {"a": 5, "b": 6}]
    assert rows_csv({}, rows).text == "a,b\n1,2\n3,4\n5,6\n"
    assert rows_csv({}, []).text == ""


def test_a_part_of_a_dataset_has_its_unit_and_meaning() -> None:
    data = dataset({"a": ("t", [1.0], "m", "way"), "b": ("t", [2.0])}, {"t": ("t", [0.0], "s", "time")}, {"robot": "x"})
    assert data.a.attrs == {"units": "m", "long_name": "way"}
    assert data.t.attrs == {"units": "s", "long_name": "time"}
    assert not data.b.attrs


def test_a_file_by_the_conventions(tmp_path: Path) -> None:
    """Coordinates have no value for what is missing; a date and the pressure of the air have other names."""
    parts = {"a": (("time", "joint"), [[1.0]], "Wh", "energy")}
    places = {"time": ("time", [0.0], "deg", "time"), "joint": ["I"], "x": ("time", [1.0])}
    data = by_conventions(dataset(parts, places, {"robot": "fish"}))
    assert set(data.variables) == {"a", "elapsed_time", "joint_name", "x"}
    assert {name for name, one in data.variables.items() if "_FillValue" in one.encoding} == {*data.coords}
    assert (data.a.attrs["units"], data.elapsed_time.attrs["units"]) == ("W h", "degree")
    assert data.attrs["title"] == f"Robot fish, computed by hypertuna {version()}"
    assert data.attrs["history"] == f"hypertuna {version()}: in Python"
    assert by_conventions(data.assign_attrs(robot="")).attrs["title"] == f"Computed by hypertuna {version()}"


def test_a_file_has_the_rights_that_the_user_gives(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        written = write_atomically(tmp_path / "new" / "a", b"1")
        assert os.umask(0o027) == 0o027  # and the mask stays
    finally:
        os.umask(before)
    assert written.stat().st_mode & 0o777 == 0o640
    assert [one.name for one in written.parent.iterdir()] == ["a"]


@pytest.mark.parametrize(
    ("unit", "value", "end"),
    [
        ("deg", np.pi / 180, "_deg"),
        ("degC", 274.15, "_c"),
        ("kPa", 1000, "_kpa"),
        ("kPa deg", 1000 * np.pi / 180, "_kpa_deg"),
        ("mm", 0.001, "_mm"),
        ("mm^2/s", 1e-6, "_mm2_s"),
        ("km", 1000, "_km"),
        ("h", 3600, "_h"),
        ("Wh", 3600, "_wh"),
        ("m/s", 1, "_m_s"),
        ("J/(kg m)", 1, "_j_per_kg_m"),
        ("1/s", 1, "_s"),
        ("", 1, ""),
        ("1", 1, ""),
    ],
)
def test_one_of_each_unit(unit: str, value: float, end: str) -> None:
    assert scaled(value, unit) == pytest.approx(1, rel=1e-12)
    assert scaled(None, unit) is None
    assert scaled(2 * value, unit) == pytest.approx(1 + value if unit == "degC" else 2, rel=1e-12)
    assert key_of("a", unit) == f"a{end}"


@pytest.mark.parametrize(("umask", "mode"), [(0o000, 0o666), (0o022, 0o644), (0o077, 0o600)])
def test_a_file_has_the_mode_of_a_new_one(tmp_path: Path, umask: int, mode: int) -> None:
    before = os.umask(umask)
    try:
        write_atomically(tmp_path / "a", b"x")
        assert os.umask(umask) == umask  # as it was
    finally:
        os.umask(before)
    assert (tmp_path / "a").stat().st_mode & 0o777 == mode
