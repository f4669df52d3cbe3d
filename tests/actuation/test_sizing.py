"""Pumps are sized case by case with one count of progress, and hold what compliance and bubbles of air take."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation import new
from hypertuna.actuation.sizing import size_over


def test_several_sizings_count_as_one(tuna: ht.Robot) -> None:
    told: list[tuple[int, int]] = []
    cases = {"pump.crank_m": [0.024, 0.012]}
    amplitude = np.radians([10, 10])
    options: dict[str, Any] = {"frequency": [1.0], "amplitude": amplitude}
    sizes = size_over(tuna, cases, **options, progress=lambda *numbers: told.append(numbers))
    done = [count for count, _ in told]
    assert len(sizes) == 2 * len(tuna.joints)
    assert {total for _, total in told} == {done[-1]}
    assert done == sorted(set(done))
    assert sizes == size_over(tuna, cases, **options)


def test_a_cylinder_holds_what_hoses_and_bubbles_take_too() -> None:
    """By hand: 2 ml move; hoses of 3e-12 m^3/Pa and bubbles, which give way by their volume over an atmosphere."""
    straight, fill, pressure = 10e-6, 50e3, 150e3
    held = {"pressure": np.array([fill, pressure]), "volume": np.array([straight, straight + 2e-6])}
    joint: Any = SimpleNamespace(hold=lambda bends: held, at=lambda bend: {"volume": straight}, fill=fill)
    swelling = 3e-12 + new.AIR * straight / _core.ATMOSPHERE
    assert new._displaced(3e-12, joint, 0.3) == pytest.approx(2e-6 + swelling * 100e3, rel=1e-12)
