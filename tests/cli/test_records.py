"""What commands make of results: units at the border, command lines of other machines, exit codes."""

import numpy as np
import pytest
import xarray as xr

from hypertuna.cli.replay import _compared_at_border
from hypertuna.cli.shards import _placeless


def test_a_sweep_s_command_is_the_same_on_all_machines() -> None:
    words = ["sweep", "--shard", "2/8", "--frequency", "1:6:9", "--cluster=tcp://host:8786", "-o", "a b.shards"]
    assert _placeless(words) == "hypertuna sweep --frequency 1:6:9 -o 'a b.shards'"


def test_errors_of_a_replay_are_in_cm_and_degrees_and_ratios_without_unit() -> None:
    axes = ["x", "y", "yaw"]
    values = {name: ("axis", np.array([0.01, 0.02, np.radians(3)])) for name in ("rmse", "repeatability")}
    runs = {"run_rmse": (("axis", "run"), np.array([[0.01], [0.02], [np.radians(3)]]))}
    ratio = {"ratio": ("axis", np.array([1.5, 2.5, 3.5])), "frames": ("run", np.array([60]))}
    compared = xr.Dataset(values | runs | ratio, coords={"axis": axes, "run": ["one"]})
    record = _compared_at_border(compared)["axes"]
    assert record["x"] == {"rmse_cm": pytest.approx(1), "repeatability_cm": pytest.approx(1), "ratio": 1.5,
                           "run_rmse_cm": pytest.approx([1])}  # fmt: skip
    assert record["yaw"]["rmse_deg"] == pytest.approx(3)
    assert record["yaw"]["ratio"] == 3.5
