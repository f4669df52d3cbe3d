"""Priors: what is known of coefficients without runs, and what a fit makes of it."""

import math

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.identification.coefficients import free, prior_rows, with_values
from hypertuna.identification.identify import identify
from hypertuna.identification.names import default_names, default_priors
from hypertuna.identification.sentences import held_by_priors
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.trials import Trials

DRAG = "water.strip.drag_tangential=common"
FACTOR, TRUE = 3.0, 2.0  # of the prior, and of the robot that swims over the described one


@pytest.fixture(scope="module")
def eel():
    return ht.load("rexeel")


def speed_of(robot, drag):
    """Speed of the wave of 30 deg with a factor on the drag along the body."""
    return ht.swim(with_values(robot, free(robot, [DRAG]), [drag]), ht.named_gait(robot, "wave-30")).speed


def fit_of(robot, relative_sd, prior=FACTOR):
    """A fit of the drag along the body to one speed, measured without error and known to a standard deviation."""
    speed = speed_of(robot, TRUE)
    gait = ht.named_gait(robot, "wave-30")
    run = SteadyRun("one", gait, speed, relative_sd * speed)
    options = {"prior": None if prior is None else {DRAG: prior}, "loss": "linear", "starts": 1, "validate": 0}
    return identify(robot, Trials((run,)), [DRAG], threads=1, **options)


@pytest.mark.parametrize(("part", "held"), [(0.69, False), (0.71, True)])
@pytest.mark.parametrize("factor", [1.1, 10.0])
def test_a_coefficient_is_held_by_its_prior_from_seven_tenths_of_its_deviation_on(eel, factor, part, held):
    frees = free(eel, [DRAG], prior={DRAG: factor})
    assert bool(held_by_priors(frees, np.array([part * math.log(factor)]))) == held


def test_a_prior_is_one_standard_deviation_of_the_logarithm(eel):
    (one,) = free(eel, [DRAG], prior={DRAG: FACTOR})
    assert one.prior == (1.0, FACTOR)
    assert one.scale == "log"
    for value, residual in ((1.0, 0.0), (FACTOR, 1.0), (1 / FACTOR, -1.0)):
        rows, by = prior_rows([one], np.array([math.log(value)]))
        assert rows == pytest.approx([residual])
        assert by == pytest.approx(np.array([[1 / math.log(FACTOR)]]))
    assert prior_rows(free(eel, [DRAG]), np.zeros(1))[0].size == 0


def test_a_fit_is_where_prior_and_speed_balance(eel):
    """The derivative of ((s - m)/sd)^2 + (ln v/ln f)^2 by ln v is 0 at the fit, by differences."""
    fit = fit_of(eel, 0.2)
    value, measured = float(fit.values[0]), speed_of(eel, TRUE)
    assert 1.0 < value < TRUE
    assert 0 < fit.seconds < 600
    slope = (speed_of(eel, value * 1.001) - speed_of(eel, value / 1.001)) / (2 * math.log(1.001))
    pull = (speed_of(eel, value) - measured) / (0.2 * measured) ** 2 * slope
    assert pull == pytest.approx(-math.log(value) / math.log(FACTOR) ** 2, rel=1e-3)


def test_an_exact_speed_outweighs_the_prior_and_a_vague_one_leaves_it(eel):
    assert float(fit_of(eel, 1e-4).values[0]) == pytest.approx(TRUE, rel=1e-3)
    assert not any("prior" in text for text in fit_of(eel, 1e-4).warnings)
    vague = fit_of(eel, 10.0)
    assert float(vague.values[0]) == pytest.approx(1.0, rel=1e-2)
    assert any("is held by its prior, the robot's value within a factor of 3" in text for text in vague.warnings)
    assert float(vague.uncertainty.sd[0]) == pytest.approx(math.log(FACTOR), rel=0.01)
    assert vague.parameters[0]["prior"] == {"value": 1.0, "factor": FACTOR}


def test_default_coefficients_have_priors_unless_they_are_named(eel):
    priors = default_priors(eel)
    assert tuple(priors) == default_names(eel)
    assert [priors[name] for name in default_names(eel)] == [10.0, 1.5, 2.0]
    assert not default_priors(ht.load("hypertuna"))  # the lumped law's coefficients are of no handbook
    assert fit_of(eel, 0.2, prior=None).free[0].prior is None


@pytest.mark.parametrize(
    ("name", "factor", "text"),
    [(DRAG, 1.0, "must be greater than 1"), (DRAG, math.inf, "must be"), ("time_offset", 2.0, "belongs to the trials")],
)
def test_wrong_priors_are_told(eel, name, factor, text):
    with pytest.raises(ht.InputError, match=text):
        free(eel, [name], prior={name: factor}, recordings={"a": 0.0})
