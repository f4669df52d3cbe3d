"""Identify: the coefficients that made synthetic runs come back, exactly or within their intervals."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.identification.coefficients import Free, free, from_scale, to_scale, with_values
from hypertuna.identification.experiment import experiment
from hypertuna.identification.identify import compare, identify
from hypertuna.identification.posterior import posterior, with_posterior
from hypertuna.identification.prediction import predict, weighted
from hypertuna.trials.kind import FAILED
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.trials import Trials, digest, split
from models import MODELS, changed
from synthetic import NINE, grid, steady, swims

FEW = grid([2, 4, 6], [(8, 15), (16, 25)], [0, 30, 60])  # 18 gaits
THREE = ("water.drag[0,1-6,7]",)
BACK = {"water.drag": 10.0}  # Table III's start


def values_of(robot: ht.Robot, frees: tuple[Free, ...]) -> np.ndarray:
    return np.array([f.start for f in free(robot, [f.name for f in frees])])


def test_coefficients_come_back_exactly(tuna: ht.Robot) -> None:
    fit = identify(tuna, steady(tuna, FEW), THREE, start=BACK, validate=0, starts=1)
    assert fit.values == pytest.approx(values_of(tuna, fit.free), rel=1e-6)
    assert fit.converged
    assert fit.stop.startswith("The search converged: ")
    assert fit.noise == {"speed": 1e-6, "cost_of_transport": 1e-6}  # nothing is known better than it is computed
    assert not fit.warnings


@pytest.mark.parametrize("model", ["hypertuna-lumped", "hypertuna-strip-shedding", "rexeel-theory-strip-linear"])
def test_derivatives_of_residuals(model: str) -> None:
    """Every kind of coefficient and of run, in natural and log scale, against differences."""
    robot = MODELS[model]
    names = [
        "links.mass[1]",
        "links.length[0]",
        "water.density",
        "joints.phase_offset[1]",
        "cost_factor",
        "time_offset",
    ]
    names += {
        "hypertuna-lumped": ["water.drag[1-6]", "joints.bandwidth"],
        "hypertuna-strip-shedding": ["water.drag_normal[7]", "water.tail_shedding", "joints.bandwidth"],
        "rexeel-theory-strip-linear": ["water.drag_tangential", "water.linear_normal[1-5]"],
    }[model]
    trials = steady(robot, FEW[:2] if robot.name == "hypertuna" else [gait_of_eel(robot)]) + swims(robot, late=0.013)
    offsets = {recording.name: 0.02 for recording in trials.recordings}
    frees = free(robot, names, log=["cost_factor", "links.mass", "water.density"], recordings=offsets)
    data, x = experiment(robot, trials, frees), to_scale(frees, [f.start for f in frees])
    levels = dict.fromkeys(data.unknown_kinds, 0.01)

    def residual(x: np.ndarray) -> np.ndarray:
        return weighted(data, predict(data, from_scale(frees, x), gradient_steps=None), levels)[0]

    _, slope = weighted(data, predict(data, from_scale(frees, x)), levels)
    for k, f in enumerate(frees):
        # the track is straight between two steps of the replay: no step of the difference may cross one
        step = 1e-5 * max(abs(x[k]), 0.1) * np.eye(len(x))[k]
        difference = (residual(x + step) - residual(x - step)) / (2 * step[k])
        assert slope[:, k] == pytest.approx(difference, rel=1e-4, abs=1e-5 * abs(difference).max()), f.name


def gait_of_eel(robot: ht.Robot) -> ht.Gait:
    return ht.named_gait(robot, "wave-30")


def test_recordings_give_coefficients_and_the_offset_of_their_clock() -> None:
    eel = MODELS["rexeel-theory-strip"]
    trials = swims(eel, late=0.05)
    names = ["water.drag_normal", "water.drag_tangential", "time_offset"]
    fit = identify(eel, trials, names, validate=0, starts=1, start={"water.drag_normal": 3.0})
    assert fit.values == pytest.approx([1.98, 0.0101, 0.05], rel=1e-3)  # poses are interpolated between steps
    assert fit.train.rms["x_m"] < 1e-5


def test_both_kinds_of_trials_in_one_fit(tuna: ht.Robot) -> None:
    trials = steady(tuna, FEW, noise=0.01, told=True) + swims(tuna, runs=8, noise=0.01)
    fit = identify(tuna, trials, ["water.drag[7]", "water.friction[1-6]"], validate=0.2, seed=1, starts=1)
    assert set(fit.train.rms) == {"speed_relative", "cost_of_transport_relative", "x_m", "y_m", "yaw_deg"}
    assert (fit.uncertainty.low < [20.7766, 0.16131]).all()
    assert (fit.uncertainty.high > [20.7766, 0.16131]).all()
    assert not fit.noise


def test_noise_is_estimated_and_covered(tuna: ht.Robot) -> None:
    """One sample of the study in validation/identify: noise of 2 % is found within 3 of its standard deviations."""
    fit = identify(tuna, steady(tuna, FEW, noise=0.02, seed=4), THREE, validate=0, starts=1)
    assert fit.noise["speed"] == pytest.approx(0.02, rel=3 / np.sqrt(2 * 18))
    assert fit.noise["cost_of_transport"] == pytest.approx(0.02, rel=3 / np.sqrt(2 * 18))
    truth = values_of(tuna, fit.free)
    assert ((fit.uncertainty.low <= truth) & (truth <= fit.uncertainty.high)).all()


def test_one_bad_run_does_little_with_a_robust_loss(tuna: ht.Robot) -> None:
    trials = steady(tuna, FEW, noise=0.01, seed=1, cost=False)
    runs = list(trials.steady)
    runs[5] = SteadyRun(name="bad", gait=runs[5].gait, speed=2 * runs[5].speed)  # type: ignore[operator]
    truth, off = 20.7766, {}
    for loss in ("linear", "soft_l1", "huber", "cauchy"):
        fit = identify(tuna, Trials(tuple(runs)), ["water.drag[7]"], validate=0, starts=1, loss=loss)
        off[loss] = abs(fit.values[0] / truth - 1)
    assert off["linear"] > 5 * max(off[loss] for loss in ("soft_l1", "huber", "cauchy"))


def test_a_run_that_does_not_settle_counts_as_far_off(tuna: ht.Robot) -> None:
    """A search turns back from it: a large, finite residual with zero Jacobian; and it is reported."""
    frees = free(tuna, ["water.drag[7]"], bounds={"water.drag": (0, 1e9)})
    trials = steady(tuna, FEW[-2:])
    data = experiment(tuna, trials, frees, steps=8)
    found = predict(data, [1e9], gradient_steps=8)
    assert found.failed.all()
    assert found.computed == pytest.approx(FAILED * data.measured)
    assert not found.jacobian.any()


def test_unidentifiable_directions_and_values_on_bounds_are_reported(tuna: ht.Robot) -> None:
    fit = identify(tuna, steady(tuna, FEW, noise=0.01, cost=False), NINE, validate=0, starts=1)
    assert not all(d.constrained for d in fit.uncertainty.directions)
    assert any(f.startswith("The runs leave some coefficients unidentifiable") for f in fit.warnings)
    assert all(
        "cannot be distinguished from speed alone" in d.sentence or "not constrained by speed" in d.sentence
        for d in fit.uncertainty.directions
        if not d.constrained
    )
    fit = identify(
        tuna,
        steady(tuna, FEW),
        ["water.drag[7]"],
        bounds={"water.drag": (0, 15)},
        start={"water.drag": 10},
        validate=0,
        starts=1,
    )
    assert fit.uncertainty.bound == ("upper",)
    assert fit.values[0] == 15
    assert fit.warnings[0].startswith("water.lumped.drag[7] is on its upper bound, 15")


def test_fewer_runs_than_coefficients_is_a_sentence(tuna: ht.Robot) -> None:
    fit = identify(tuna, steady(tuna, FEW[:2], cost=False), THREE, validate=0, starts=1)
    assert any("3 free coefficients and 2 independent measurements" in text for text in fit.warnings)
    assert fit.criteria["aicc"] is None


def test_split_is_by_run_and_by_seed(tuna: ht.Robot) -> None:
    trials = steady(tuna, FEW, cost=False) + swims(tuna, runs=7)
    training, unseen = split(trials, 0.2, seed=1)
    assert len(unseen.runs) == 5
    assert sorted(training.runs + unseen.runs) == sorted(trials.runs)
    assert split(trials, 0.2, seed=1)[1].runs == unseen.runs
    assert split(trials, 0.2, seed=2)[1].runs != unseen.runs
    assert split(trials.only(trials.runs[:1]), 0.9, seed=0)[0].runs == trials.runs[:1]


def test_validation_runs_are_not_seen(tuna: ht.Robot) -> None:
    """Whatever they hold, the fit is the same."""
    trials = steady(tuna, FEW, noise=0.01)
    _, unseen = split(trials, 0.2, seed=0)
    wrong = {run.name: 3 * run.speed for run in unseen.steady}  # type: ignore[operator]
    other = Trials(
        tuple(
            SteadyRun(
                name=run.name,
                gait=run.gait,
                speed=wrong.get(run.name, run.speed),
                cost_of_transport=run.cost_of_transport,
            )
            for run in trials.steady
        )
    )
    first, second = (identify(tuna, runs, ["water.drag[7]"], starts=1) for runs in (trials, other))
    assert first.values == second.values
    assert first.validation is not None
    assert second.validation is not None
    assert second.validation.rms["speed_relative"] > 0.5 > 0.1 > first.validation.rms["speed_relative"]


def test_threads_and_repetition_change_nothing(tuna: ht.Robot) -> None:
    trials = steady(tuna, FEW[::3], noise=0.01)
    fits = [identify(tuna, trials, ["water.drag[1-6,7]"], starts=3, threads=threads) for threads in (1, 2, 2)]
    for fit in fits[1:]:
        assert (fit.values == fits[0].values).all()
        assert fit.costs == fits[0].costs


def test_fitted_robots_load_and_swim(tuna: ht.Robot, tmp_path: Path) -> None:
    from hypertuna.description.writer import write_robot

    fit = identify(tuna, steady(tuna, FEW, noise=0.01), ["water.drag[7]", "joints.bandwidth"], starts=1)
    robot = ht.load(write_robot(fit.robot, tmp_path / "fit.toml"))
    assert robot.hash == fit.robot.hash
    assert robot.fit is not None
    assert robot.fit.names == ("water.lumped.drag[7]", "joints.bandwidth[0-1]")
    assert ht.swim(robot, FEW[0]).speed == ht.swim(fit.robot, FEW[0]).speed


def test_laws_are_compared(tuna: ht.Robot) -> None:
    """Runs that the strip law made are fitted better by it."""
    strip = tuna.using(water="strip")
    trials = steady(strip, FEW, noise=0.01)
    fits = compare(
        tuna, trials, ["water.drag[7]", "water.drag_normal[7]", "joints.bandwidth"], ["lumped", "strip"], starts=1
    )
    assert [f.name for f in fits["lumped"].free] == ["water.lumped.drag[7]", "joints.bandwidth[0-1]"]
    assert [f.name for f in fits["strip"].free] == ["water.strip.drag_normal[7]", "joints.bandwidth[0-1]"]
    assert fits["strip"].criteria["aicc"] < fits["lumped"].criteria["aicc"] - 10
    assert fits["strip"].validation.rms["speed_relative"] < fits["lumped"].validation.rms["speed_relative"]  # type: ignore[union-attr]


def test_posterior_agrees_with_the_linear_interval(tuna: ht.Robot) -> None:
    """One well-determined coefficient: both intervals are as long as each other, but for what few steps leave."""
    fit = identify(
        tuna, steady(tuna, FEW[::6], noise=0.01, told=True), ["water.drag[7]"], validate=0, starts=1, loss="linear"
    )
    sampled = posterior(fit, 80)
    assert (sampled.high - sampled.low) / (fit.uncertainty.high - fit.uncertainty.low) == pytest.approx(1, abs=0.25)
    assert 0.3 < sampled.acceptance < 0.9
    assert sampled.sentence.startswith("The chain is ")
    assert with_posterior(fit, sampled).fit.covariance[0][0] == sampled.covariance[0, 0]  # type: ignore[union-attr]


def test_posterior_resumes_to_the_same_draws(tuna: ht.Robot, tmp_path: Path) -> None:
    fit = identify(tuna, steady(tuna, FEW[::6], noise=0.01, told=True), ["water.drag[7]"], validate=0, starts=1)
    path = tmp_path / "draws.jsonl"
    whole = posterior(fit, 60, checkpoint=path)
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:2]))  # the header and the first block
    assert (posterior(fit, 60, checkpoint=path).samples == whole.samples).all()
    with ThreadPoolExecutor(3) as pool:
        assert (posterior(fit, 60, executor=pool).samples == whole.samples).all()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"validate": 1.0}, "validate must be at least 0 and less than 1, but is 1"),
        ({"validate": float("nan")}, "validate must be a finite number"),
        ({"loss": "soft"}, "loss must be a known loss, but is 'soft': did you mean soft_l1?"),
        ({"starts": 0}, "starts must be from 1 to 4096"),
        ({"seed": -1}, "seed must not be negative"),
    ],
)
def test_bad_options(tuna: ht.Robot, options: dict[str, object], sentence: str) -> None:
    with pytest.raises(ht.InputError) as error:
        identify(tuna, steady(tuna, FEW[:3]), ["water.drag"], **options)  # type: ignore[arg-type]
    assert sentence in str(error.value)


def test_trials_that_cannot_be_fitted(tuna: ht.Robot) -> None:
    with pytest.raises(ht.InputError, match="trials must have at least one run"):
        identify(tuna, Trials(), ["water.drag"])
    with pytest.raises(ht.InputError, match="needs measured costs of transport, and the trials have none"):
        identify(tuna, steady(tuna, FEW[:3], cost=False), ["cost_factor"])
    still = Trials((SteadyRun(name="still", gait=FEW[0], speed=0.0, file="tank.csv", line=3),))
    with pytest.raises(
        ht.InputError, match=r"tank.csv: line 3, speed_m_s must have a standard deviation where it is 0"
    ):
        identify(tuna, still, ["water.drag"])


def test_digest_sees_what_the_runs_hold_and_not_where_they_lie(tuna: ht.Robot) -> None:
    from dataclasses import replace

    trials = steady(tuna, FEW[:2]) + swims(tuna)
    moved = Trials(tuple(replace(trial, file="elsewhere.csv") for trial in trials.members))
    other = Trials((replace(trials.steady[0], speed=0.1), *trials.members[1:]))
    assert digest(moved) == digest(trials) != digest(other)


FIT = """
    import sys
    import hypertuna as ht
    from hypertuna.identification.identify import identify
    sys.path.insert(0, {tests!r})
    from synthetic import grid, steady

    robot = ht.load("hypertuna")
    gaits = grid([2, 4, 6], [(16, 25)], [0, 40])
    fit = identify(robot, steady(robot, gaits, noise=0.01), ["water.drag[1-6,7]"], starts=4, checkpoint={path!r},
                   progress=lambda done, total: print(done, flush=True))
    print("values", fit.values.tolist(), fit.evaluations, flush=True)
"""


def test_kill_in_the_middle_and_resume(tmp_path: Path) -> None:
    """kill -9 after the second start: the resumed fit tells the same values and evaluations as one left alone."""

    def program(name: str) -> list[str]:
        text = FIT.format(tests=str(Path(__file__).parents[1]), path=str(tmp_path / name))
        return [sys.executable, "-c", textwrap.dedent(text)]

    alone = subprocess.run(program("alone.jsonl"), capture_output=True, text=True, check=True).stdout.splitlines()[-1]
    killed = subprocess.Popen(program("killed.jsonl"), stdout=subprocess.PIPE, text=True)
    assert killed.stdout is not None
    while (line := killed.stdout.readline()) and line.strip() != "2":
        time.sleep(0)
    os.kill(killed.pid, signal.SIGKILL)
    killed.wait()
    killed.stdout.close()
    assert len((tmp_path / "killed.jsonl").read_bytes().splitlines()) < len(
        (tmp_path / "alone.jsonl").read_bytes().splitlines()
    )
    resumed = subprocess.run(program("killed.jsonl"), capture_output=True, text=True, check=True).stdout.splitlines()[
        -1
    ]
    assert resumed.splitlines()[-1] == alone
    assert alone.startswith("values")


def test_a_checkpoint_of_another_fit_is_refused(tuna: ht.Robot, tmp_path: Path) -> None:
    path = tmp_path / "fit.jsonl"
    trials = steady(tuna, FEW[:4])
    identify(tuna, trials, ["water.drag[7]"], starts=1, validate=0, checkpoint=path)
    with pytest.raises(ht.InputError, match="was started with seed = 0, but now it is 1"):
        identify(tuna, trials, ["water.drag[7]"], starts=1, validate=0, seed=1, checkpoint=path)
    heavier = changed(tuna, {"body.mass_kg": 3.4})
    with pytest.raises(ht.InputError, match="was started with robot_hash"):
        identify(heavier, trials, ["water.drag[7]"], starts=1, validate=0, checkpoint=path)


def test_a_robot_of_fitted_values_is_predicted_as_its_columns_are(tuna: ht.Robot) -> None:
    """The core's model with changed columns is the model of the changed robot."""
    frees = free(tuna, ["water.drag[7]", "links.mass[3]", "joints.bandwidth[I]"])
    values = [12.0, 0.08, 4.0]
    trials = steady(tuna, FEW[:4])
    changed_columns = predict(experiment(tuna, trials, frees), values).computed
    robot = with_values(tuna, frees, values)
    assert changed_columns == pytest.approx(predict(experiment(robot, trials), ()).computed, rel=1e-14)


def test_one_text_of_names_and_paths_of_trials() -> None:
    tank = Path(__file__).parents[2] / "examples" / "tank" / "tank.csv"
    tuna = ht.load("hypertuna")
    names = "water.drag[7],joints.bandwidth"
    first = identify(tuna, ht.read_trials(tank, tuna), names.split(","), starts=1)
    for trials in (str(tank), [tank]):
        assert (identify(tuna, trials, names, starts=1).values == first.values).all()


@pytest.mark.parametrize(
    ("robot", "trials", "names", "sentence"),
    [
        (3, Trials(), "water.drag", "robot must be a .*, but is 3"),
        (MODELS["hypertuna-lumped"], 3, "water.drag", "trials must be .*, but is (3|a int)"),
        (MODELS["hypertuna-lumped"], [Trials()], "water.drag", "trials must be .*, but is "),
        (MODELS["hypertuna-lumped"], Trials(), 3, "free must be .*, but is (3|a int)"),
    ],
)
def test_wrong_types_are_reported(robot: object, trials: object, names: object, sentence: str) -> None:
    for fit in (lambda: identify(robot, trials, names), lambda: compare(robot, trials, names, ["lumped"])):  # type: ignore[arg-type]
        with pytest.raises(ht.InputError, match=sentence):
            fit()
