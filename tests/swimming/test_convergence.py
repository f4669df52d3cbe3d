"""How fast errors vanish with the steps of a beat."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import hypertuna as ht
from hypertuna.description.robot import cached
from models import MODELS, fastest

# Runge and Kutta's method is of the fourth order where forces are smooth: with the cross-flow form v_n |v| of drag.
# v_n |v_n| has a kink in its slope wherever a section comes to rest, twice a beat; the step across it errs by h^3.
SMOOTH = [name for name in MODELS if name.endswith("cross-flow")]
# Errors of 5e-7 at 64 steps leave no room for an order: Newton's tolerance, and a disturbance that shrinks to 0.92 of
# itself each beat, leave 1e-8.
ACCURATE = ["hypertuna-elongated"]
FINEST = 4096


def errors(robot: ht.Robot, factor: int) -> NDArray[np.float64]:
    """Relative errors of speed and power, and imbalance of power and loss, at `factor` times about 64 steps.

    Root of the mean square over some numbers of steps: where in its step a kink falls is a matter of luck.
    """
    gait = fastest(robot)
    exact = cached(robot, "exact", lambda: ht.swim(robot, gait, steps=FINEST))
    rows = []
    for steps in range(48 * factor, 80 * factor, 4 * factor):
        swim = ht.swim(robot, gait, steps=steps)
        rows.append(
            (
                swim.speed / exact.speed - 1,
                swim.mechanical_power / exact.mechanical_power - 1,
                swim.mechanical_power / swim.power_to_water - 1,
            )
        )
    return np.sqrt(np.mean(np.square(rows), axis=0))


@pytest.mark.parametrize("name", SMOOTH)
def test_fourth_order(name: str) -> None:
    """From 256 steps on: longer steps are too long for the share that beating has of the drag."""
    order = np.log2(errors(MODELS[name], 4) / errors(MODELS[name], 8))
    np.testing.assert_allclose(order, 4, atol=0.3)


@pytest.mark.parametrize("name", sorted(MODELS.keys() - {*SMOOTH, *ACCURATE}))
def test_third_order_where_drag_has_kinks(name: str) -> None:
    """Slope of a line through four numbers of steps: between two of them the order is a matter of luck, too."""
    falls = np.log2([errors(MODELS[name], factor) for factor in (1, 2, 4, 8)])
    assert (-np.polyfit(np.arange(4), falls, 1)[0] > 2.5).all()


@pytest.mark.parametrize("name", ACCURATE)
def test_errors_below_the_tolerance_of_newton_s_method(name: str) -> None:
    assert (errors(MODELS[name], 1) < 1e-6).all()


def test_the_usual_number_of_steps_is_enough(every_model: ht.Robot) -> None:
    """The default of 128 steps leaves less than a hundred thousandth."""
    speed, power, balance = errors(every_model, 2)
    assert speed < 5e-6
    assert power < 1e-5
    assert balance < 1e-5
