"""The studies of actuator fits run, on one drawn actuator each; their README has the whole."""

import runpy
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

HERE = Path(__file__).parent


def test_a_drawn_actuator_is_fitted() -> None:
    """One repeat of the study of coverage."""
    study = runpy.run_path(str(HERE / "study.py"))
    fit, truth = next(filter(None, (study["repeat"](seed, 0.2) for seed in range(5))))
    assert truth.shape == (len(fit.free),)
    assert np.mean((fit.low <= truth) & (truth <= fit.high)) > 0.7


def test_a_drawn_actuator_lies_in_its_families() -> None:
    """One repeat of the study of families: the force keeps the designs that have it."""
    study = runpy.run_path(str(HERE / "family.py"))
    with TemporaryDirectory() as folder:
        fish, *found = next(filter(None, (study["repeat"](seed, 50, Path(folder)) for seed in range(20))))
    truth = study["blocked_moment"](fish, 0, study["TOP"])
    alone, both = (
        np.array([study["blocked_moment"](one.robot, 0, study["TOP"]) for one in of.members]) for of in found
    )
    assert alone.min() < truth < alone.max()
    assert np.abs(np.log(both / truth)).max() < 6 * study["FORCE"]
    assert np.std(np.log(both)) < 0.5 * np.std(np.log(alone))
