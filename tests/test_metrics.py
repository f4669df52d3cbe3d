"""Metrics against numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import metrics
from oracles.beats import mean_speed


def test_speed_of_a_straight_path_is_its_length_over_time() -> None:
    """Swaying to and fro does not add to it."""
    t = np.linspace(0, 1, 65)
    assert mean_speed(0.3 * t, 0.05 * np.sin(2 * np.pi * t), 0.0, 0.5) == pytest.approx(0.6)
    assert mean_speed(np.zeros(2), np.zeros(2), 0.0, 0.5) == 0.0


@pytest.mark.parametrize("turn", [math.pi / 2, -math.pi / 2, 0.01])
@pytest.mark.parametrize("phase", [0.0, 1.0, 4.0])
def test_speed_of_a_turning_path_is_the_arc_at_the_mean_distance_from_its_center(turn: float, phase: float) -> None:
    """On a circle of 2 m on the mean, swaying by 0.1 m across it, in 4 s, wherever the beat begins."""
    t = np.linspace(0, 1, 65)
    path = (2 + 0.1 * np.sin(2 * np.pi * t + phase)) * np.exp(1j * turn * t)
    path -= path[0]
    assert mean_speed(path.real, path.imag, turn, 4.0) == pytest.approx(2 * abs(turn) / 4)


@pytest.mark.parametrize("bias", [0.0, 10.0])
def test_speed_of_a_swim_is_that_of_its_path(bias: float) -> None:
    """The core's mean speed against the arc through the positions of the nose."""
    fish = ht.load("hypertuna")
    gait = ht.Gait.from_degrees(frequency=4, amplitude=(16, 25), phase=(0, 40), bias=(0, bias))
    swim = ht.swim(fish, gait)
    x, y, heading = (swim.trajectory[name].values for name in ("x", "y", "heading"))
    assert mean_speed(x, y, heading[-1] - heading[0], 1 / 4) == pytest.approx(abs(swim.speed), rel=1e-4)


def test_cost_of_transport() -> None:
    # 12.15 J/(kg m), 3.3 kg and 0.56 m/s of the paper are 22.45 W
    assert metrics.cost_of_transport(22.45, 3.3, 0.56) == pytest.approx(12.15, abs=0.005)
    assert metrics.cost_of_transport(22.45, 3.3, -0.56) == pytest.approx(12.15, abs=0.005)  # backward costs too
    assert metrics.cost_of_transport(1.0, 3.3, 0.0) == math.inf


def test_strouhal() -> None:
    assert metrics.strouhal(2.0, 0.1, 0.5) == pytest.approx(0.4)
    assert metrics.strouhal(2.0, 0.1, -0.5) == pytest.approx(0.4)
    assert metrics.strouhal(2.0, 0.1, 0.0) == math.inf


def test_stride_length() -> None:
    assert metrics.stride_length(0.6, 2.0, 0.3) == pytest.approx(1.0)


def test_arguments_broadcast() -> None:
    speed, mass = np.array([1.0, 2.0]), np.array([[1.0], [4.0]])
    np.testing.assert_allclose(metrics.cost_of_transport(8.0, mass, speed), [[8.0, 4.0], [2.0, 1.0]])
