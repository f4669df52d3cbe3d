"""The studies of actuator fits run, on one drawn actuator each; their README has the whole."""

import runpy
from pathlib import Path

import numpy as np

import hypertuna as ht
from hypertuna.actuation.bending import bend

HERE = Path(__file__).parent


def test_a_drawn_actuator_is_fitted() -> None:
    """One repeat of the study of coverage."""
    study = runpy.run_path(str(HERE / "study.py"))
    fit, truth = next(filter(None, (study["repeat"](seed, 0.2) for seed in range(5))))
    assert truth.shape == (len(fit.free),)
    assert np.mean((fit.low <= truth) & (truth <= fit.high)) > 0.7


def test_a_drawn_actuator_meets_both_published_angles() -> None:
    """The levers are solved for: joint I bends by 18.2 deg and joint II by 31.2 deg at 250 kPa."""
    sampled = runpy.run_path(str(HERE / "sampled.py"))
    robot, rng = ht.load("hypertuna"), np.random.default_rng(0)
    fit = sampled["fit_bench"](robot, sampled["read_bench"](sampled["PAPER"], robot), starts=1)
    _, values = next(filter(None, (sampled["met"](fit, rng) for _ in range(50))))
    other = sampled["with_unknowns"](robot, fit.free, values, checked=False)
    angles = [np.degrees(bend(other, joint, [250e3]).angle[0]) for joint in ("I", "II")]
    np.testing.assert_allclose(angles, (18.2, 31.2), atol=0.01)
