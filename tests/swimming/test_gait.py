"""Gaits: units, checks, and the named gaits of the shipped robots."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hypertuna.description.robot import load, robots
from hypertuna.errors import InputError
from hypertuna.swimming import gait_checks
from hypertuna.swimming.gait import Gait, check_gait, named_gait

GOOD: dict[str, Any] = {"frequency": 6, "amplitude": (16, 25), "phase": (0, 40)}

BAD = [
    ({"frequency": 0}, "frequency must be greater than 0, but is 0: give it in Hz."),
    ({"frequency": -2.5}, "frequency must be greater than 0, but is -2.5: give it in Hz."),
    ({"frequency": math.nan}, "frequency must be a finite number, but is nan: give it in Hz."),
    ({"frequency": "fast"}, "frequency must be a finite number, but is 'fast': give it in Hz."),
    (
        {"amplitude": (16, math.inf)},
        "amplitude[1] must be a finite number, but is inf: give one angle per joint group.",
    ),
    ({"amplitude": (-16, 25)}, "amplitude[0] must not be negative, but is -16: add half a turn to its phase instead."),
    ({"amplitude": 16}, "amplitude must be a list of numbers, but is 16: give one angle per joint group."),
    ({"phase": (0, None)}, "phase[1] must be a finite number, but is None: give one angle per joint group."),
    ({"phase": (0,)}, "phase must be 2 long, as amplitude is, but is 1 long: give one value per joint group."),
    ({"bias": (0, 0, 0)}, "bias must be 2 long, as amplitude is, but is 3 long: give one value per joint group."),
]


@pytest.mark.parametrize(("change", "sentence"), BAD)
def test_bad_input_gives_one_sentence(change: dict[str, Any], sentence: str) -> None:
    for make in (Gait.from_degrees, Gait):
        with pytest.raises(InputError) as caught:
            make(**(GOOD | change))
        assert str(caught.value) == sentence


def test_a_gait_must_fit_the_robot() -> None:
    gait = Gait.from_degrees(frequency=6, amplitude=(16, 25, 30), phase=(0, 40, 80))
    with pytest.raises(InputError) as caught:
        check_gait(gait, load("hypertuna"))
    assert str(caught.value) == (
        "amplitude must be 2 long, one value per joint group of hypertuna (I, II), but is 3 long: "
        "give 2 values for amplitude, phase and bias each."
    )
    check_gait(Gait.from_degrees(**GOOD), load("hypertuna"))


ANGLES = st.lists(st.floats(0, 180), min_size=1, max_size=5)


@given(frequency=st.floats(1e-3, 1e3), angles=ANGLES)
def test_degrees_are_degrees(frequency: float, angles: list[float]) -> None:
    radians = tuple(math.radians(angle) for angle in angles)
    gait = Gait.from_degrees(frequency=frequency, amplitude=angles, phase=angles, bias=angles)
    assert gait.frequency == frequency
    for values in (gait.amplitude, gait.phase, gait.bias):
        assert values == pytest.approx(radians, rel=1e-15)
    assert Gait.from_degrees(frequency=frequency, amplitude=angles, phase=angles).bias == (0.0,) * len(angles)


def test_gaits_are_values() -> None:
    assert Gait.from_degrees(**GOOD) == Gait.from_degrees(**GOOD)
    assert len({Gait.from_degrees(**GOOD), Gait.from_degrees(**GOOD)}) == 1
    assert Gait(1, [1], [2]).amplitude == (1.0,)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", robots())
def test_every_named_gait_fits_its_robot(name: str) -> None:
    robot = load(name)
    for key, raw in robot.gaits.items():
        gait = named_gait(robot, key)
        check_gait(gait, robot)
        assert (gait.frequency, gait.amplitude, gait.phase) == (raw.frequency, raw.amplitude, raw.phase)


def test_an_unknown_name_gets_the_nearest() -> None:
    with pytest.raises(InputError) as caught:
        named_gait(load("rexeel"), "wave-40")
    assert str(caught.value).startswith("robots/rexeel.toml: gait must be a gait of the robot, but is 'wave-40': did")


def test_the_eel_makes_a_wave_from_head_to_tail() -> None:
    eel = load("rexeel")
    for gait in (named_gait(eel, key) for key in eel.gaits):
        lags = [later - sooner for sooner, later in zip(gait.phase, gait.phase[1:], strict=False)]
        assert lags == pytest.approx([0.7 * math.tau / len(eel.joints)] * 4)


def test_degrees_taken_for_radians_are_refused() -> None:
    fix = r"for degrees take Gait.from_degrees or Gaits.grid_degrees\.$"
    with pytest.raises(InputError, match=rf"^amplitude\[0\] must be at most 3.14159 rad, but is 16: {fix}"):
        Gait(6, (16, 25), (0, 40))
    with pytest.raises(InputError, match=rf"^phase\[1\] must be at most 6.28319 rad, but is 40: {fix}"):
        Gait(6, (0.3, 0.4), (0, 40))
    with pytest.raises(InputError, match=r"^phase\[1\] must be at most 360 deg, but is 361: check its unit\.$"):
        Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 361))
    assert Gait.from_degrees(frequency=6, amplitude=(9,) * 3, phase=(0, 360, 720)).phase[2] == 4 * math.pi
    assert Gait.from_degrees(frequency=6, amplitude=(180, 0), phase=(0, 0)).amplitude[0] == math.pi


def test_axes_that_are_sound_are_checked_all_at_once() -> None:
    """A grid with an error is checked again, value by value, so that the message can name the value."""
    axes = {"frequency": [1.0, 2.0], "amplitude": [(0.1, 0.2)], "phase": [(0.0, 0.5), (0.0, 1.0)], "bias": None}
    sound = gait_checks._sound_axes(axes, 1.0)
    assert sound is not None
    slow = gait_checks.grid_axes(axes | {"frequency": [np.float64(1.0), np.float64(2.0)]}, 1.0)
    assert {name: axis.tolist() for name, axis in sound.items()} == {name: axis.tolist() for name, axis in slow.items()}
    assert gait_checks._sound_axes(axes | {"phase": [(0.0, 0.5, 1.0)]}, 1.0) is None
    assert gait_checks._sound_axes(axes | {"amplitude": [(-0.1, 0.2)]}, 1.0) is None
