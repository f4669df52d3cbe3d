"""Datasets as columns and attributes: names, units, rows and words by hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from hypertuna.cli.emit import attributes
from hypertuna.io.files import columns_csv, dataset, rows_csv, variable_columns


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
