"""The box of gaits: what is free, in which order and unit, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hypertuna as ht
from hypertuna.description.robot import load, parse
from hypertuna.errors import InputError
from hypertuna.optimization.design_space import gait_bounds, gait_columns
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.model import parameter_names
from models import changed


def test_box_of_hypertuna_is_that_of_the_paper(tuna: ht.Robot) -> None:
    space = gait_bounds(tuna)
    assert space.names == ("frequency_hz", "amplitude_I_deg", "amplitude_II_deg", "phase_II_deg")
    units = space.unit[space.free]
    assert (space.upper / units).tolist() == pytest.approx([6, 16, 25, 80])  # Eq. 41
    assert (space.lower / units).tolist() == pytest.approx([0.1, 0, 0, 0])  # no beat, no gait


def test_every_robot_that_comes_along_has_a_box() -> None:
    for name in ht.robots():
        robot = load(name)
        space = gait_bounds(robot)
        assert set(space.columns) == set(gait_columns(robot))
        swum = ht.swim(robot, space.gait((space.lower + space.upper) / 2))
        assert swum.settled


@given(part=st.lists(st.floats(0, 1), min_size=4, max_size=4))
def test_point_and_gait_are_one_and_the_same(tuna: ht.Robot, part: list[float]) -> None:
    space = gait_bounds(tuna)
    x = space.lower + np.array(part) * (space.upper - space.lower)
    gait = space.gait(x)
    assert space.point(gait).tolist() == x.tolist()
    gaits = space.gaits([x, x])
    assert gaits.frequency.tolist() == [gait.frequency] * 2
    assert gaits.phase[1].tolist() == list(gait.phase) == [0.0, x[3]]


def test_directions_lead_where_the_coordinates_do(tuna: ht.Robot) -> None:
    space = gait_bounds(tuna)
    directions = space.directions(tuna)
    names = np.array(parameter_names(tuna))
    told = [names[column.astype(bool)].tolist() for column in directions.T]
    assert told == [["gait.frequency"], ["gait.amplitude[0]"], ["gait.amplitude[1]"], ["gait.phase[1]"]]
    assert directions.sum() == 4


@pytest.mark.parametrize("name", ["amplitude_II_deg", "amplitude_II"])
def test_bounds_of_one_value_by_its_name(tuna: ht.Robot, name: str) -> None:
    space = gait_bounds(tuna, {name: (3, 4)})
    k = space.columns.index("amplitude_II_deg")
    assert space.low[k] == pytest.approx(math.radians(3))
    assert space.high[k] == pytest.approx(math.radians(4))
    other = space.columns.index("amplitude_I_deg")
    assert space.high[other] == pytest.approx(math.radians(16))


@pytest.mark.parametrize("name", ["amplitude", "amplitude_deg"])
def test_bounds_of_all_groups_at_once(tuna: ht.Robot, name: str) -> None:
    space = gait_bounds(tuna, {name: (1, 2)})
    assert np.degrees(space.high[1:3]).tolist() == pytest.approx([2, 2])


def test_equal_bounds_fix_a_value(tuna: ht.Robot) -> None:
    space = gait_bounds(tuna, {"frequency": (2, 2), "bias_I": (5, 5)})
    assert "frequency_hz" not in space.names
    gait = space.gait(space.lower)
    assert gait.frequency == 2
    assert math.degrees(gait.bias[0]) == pytest.approx(5)
    assert isinstance(gait, Gait)


@pytest.mark.parametrize(
    ("bounds", "sentence"),
    [
        ({"frequenzy": (1, 2)}, "must name a value of a gait, but is 'frequenzy': did you mean frequency"),
        ({"frequency": (2, 1)}, "bounds of frequency must have the lower value first, but is 2:1"),
        ({"frequency": (0, 1)}, "bounds of frequency must be greater than 0"),
        ({"amplitude_I": (-1, 1)}, "bounds of amplitude_I must not be negative"),
        ({"amplitude_I": (0, 200)}, "must stay within 180 deg"),
        ({"phase": (0, math.inf)}, "must be finite"),
        ({"frequency": (1, 1), "amplitude": (5, 5), "phase": (0, 0)}, "must leave at least one gait parameter free"),
    ],
)
def test_bounds_that_cannot_be_used_are_refused(
    tuna: ht.Robot, bounds: dict[str, tuple[float, float]], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        gait_bounds(tuna, bounds)


def test_robot_without_a_box_needs_bounds_of_everything_but_bias(tuna: ht.Robot) -> None:
    document = {key: value for key, value in tuna.document().items() if key != "gait_bounds"}
    document["sources"] = {key: text for key, text in document["sources"].items() if key != "gait_bounds"}
    bare = parse(document)
    with pytest.raises(InputError, match=r"frequency_hz has no bounds: add the table \[gait_bounds\]"):
        gait_bounds(bare)
    full = {"frequency": (1.0, 2.0), "amplitude": (0.0, 10.0), "phase": (0.0, 90.0)}
    assert gait_bounds(bare, full).names[-1] == "phase_II_deg"


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ({"frequency_hz": [6.0, 0.1]}, "gait_bounds.frequency_hz must have the lower value first"),
        ({"amplitude_deg": [[0.0, 16.0], [25.0, 1.0]]}, r"gait_bounds.amplitude_deg\[1\] must have the lower"),
        ({"amplitude_deg": [[0.0, 16.0]]}, "gait_bounds.amplitude_deg must be 2 long, one value per joint group"),
        ({"frequency_hz": [0.0, 6.0]}, r"gait_bounds.frequency_hz\[0\] must be greater than 0"),
    ],
)
def test_table_of_the_file_is_checked(tuna: ht.Robot, value: dict[str, object], sentence: str, tmp_path: Path) -> None:
    table = tuna.document()["gait_bounds"] | value
    with pytest.raises(InputError, match=sentence):
        changed(tuna, {"gait_bounds": table})
