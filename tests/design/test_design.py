"""Designs: exact narrowing, discrepancies in design and fit, check runs, tows, days, and what no run can tell."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hidden_fish import Tank, hidden, synthetic_unknowns, unseen, with_linear_drag
from hypertuna.design.criterion import Design, design
from hypertuna.design.discrepancy import correlation
from hypertuna.design.posterior import infer
from hypertuna.design.prediction import Row, predict
from hypertuna.design.runs import (
    Measurement,
    TankRun,
    candidate_gaits,
    run_of,
    run_record,
    shared_frequency,
    swims,
    target_gaits,
)
from hypertuna.design.steps import warnings_of
from hypertuna.design.tank import TankDesign, half_width
from hypertuna.design.unknowns import Unknowns, unknowns_of
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import with_fit
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.swimming.beat import settle
from models import changed

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def unknowns() -> Unknowns:
    return unknowns_of(ht.load(EXAMPLES / "minnow.toml"))


@pytest.fixture(scope="module")
def gaits(unknowns: Unknowns) -> list[TankRun]:
    return gaits_of(unknowns)


@pytest.fixture(scope="module")
def targets(unknowns: Unknowns) -> list[Row]:
    return [Row(run, "speed") for run in swims(target_gaits(gait_bounds(unknowns.robot), unknowns.robot, 30))]


def told(unknowns: Unknowns, runs: list[TankRun], quantity: str = "speed") -> list[Measurement]:
    """Return results that are exactly what is expected."""
    log = predict(unknowns, unknowns.mean, [Row(run, quantity) for run in runs]).log
    return [Measurement(run, quantity, float(np.exp(value))) for run, value in zip(runs, log, strict=True)]


def test_derivatives_are_those_of_differences(unknowns: Unknowns, gaits: list[TankRun]) -> None:
    gait = gaits[40].gait
    assert gait is not None
    left, right = (TankRun("steady", replace(gait, bias=(side, side, side))) for side in (0.1, -0.1))
    rows = [Row(gaits[40], name) for name in ("speed", "cost_of_transport", "power")]
    rows += [Row(left, "turn_rate"), Row(right, "turn_rate"), Row(left, "speed")]
    rows += [Row(TankRun("thrusts", gait), "thrust"), Row(TankRun("tows", u=0.3), "drag")]
    rows += [Row(TankRun("glides", u=0.3), "coasting_length")]
    assert np.isfinite(predict(unknowns, unknowns.mean, rows).log).all()
    exact = predict(unknowns, unknowns.mean, rows).jacobian
    for j, step in enumerate(1e-4 * np.eye(len(unknowns.free))):
        ends = [predict(unknowns, unknowns.mean + sign * step, rows).log for sign in (1, -1)]
        assert exact[:, j] == pytest.approx((ends[0] - ends[1]) / 2e-4, rel=1e-3, abs=1e-6)


def test_the_drag_of_a_tow_is_the_area_of_the_straight_body(unknowns: Unknowns) -> None:
    robot = unknowns.robot
    assert robot.water.strip is not None
    area = float(np.dot(robot.water.strip.drag_tangential, robot.links.wetted_area))
    expected = 0.5 * robot.water.density * area * 0.4**2
    found = predict(unknowns, unknowns.mean, [Row(TankRun("tows", u=0.4), "drag")])
    assert np.exp(found.log[0]) == pytest.approx(expected, rel=1e-12)
    assert found.jacobian.sum() == pytest.approx(1, rel=1e-6)  # twice the coefficient, twice the drag


def test_a_glide_tells_the_length_over_which_the_body_coasts(unknowns: Unknowns) -> None:
    """Of quadratic drag 0.657 u^2 and the mass 0.415 of the links alone; by a track of it, and by the model."""
    bare = changed(unknowns.robot, {"water.strip.added_mass_tangential": [0.0] * 4})
    expected, time = 0.415 / 0.657, np.linspace(0, 3, 31)
    found = predict(unknowns_of(bare), unknowns.mean, [Row(TankRun("glides", u=0.4), "coasting_length")])
    assert np.exp(found.log[0]) == pytest.approx(expected, rel=1e-6)
    rng = np.random.default_rng(1)
    true = 0.4 / (1 + 0.4 * time / expected)
    lengths, sds = np.array(
        [ht.Glide("a", time, true + 0.004 * rng.standard_normal(31), sd).coasting()[:2] for sd in 100 * [0.004, None]]
    ).T
    assert lengths.mean() == pytest.approx(expected, rel=0.01)
    assert np.std(lengths) == pytest.approx(sds.mean(), rel=0.2)
    with pytest.raises(InputError, match="must slow down"):
        ht.Glide("a", time, 0.1 + 0.1 * time).coasting()


def test_turns_are_narrowed_by_turns(unknowns: Unknowns) -> None:
    """Exact rates of a hidden fish: after six runs the rates of unseen turns are known better than before."""
    robot = unknowns.robot
    fish = hidden(unknowns, np.random.default_rng(3))
    with TankDesign(None, robot, want="turn", bounds={"bias": (0, 15)}) as tank:
        assert all(row.run.turns and row.quantity == "turn_rate" for row in tank.targets)
        assert {run.turns for run in tank.candidates} == {True, False}
        before = half_width(tank.posterior, tank.targets)
        for _ in range(6):
            run = tank.ask().choices[0].run
            assert run.gait is not None
            rate, speed = (float(settle(fish, ht.Gaits.of([run.gait]))[name][0]) for name in ("turn_rate", "speed"))
            tank.tell([ht.TurnRun("a", rate, gait=run.gait) if run.turns else ht.SteadyRun("a", run.gait, speed)])
        mean, sd = tank.posterior.predict(tank.targets)
    assert half_width(tank.posterior, tank.targets) < 0.3 * before
    rates = settle(fish, ht.Gaits.of([row.run.gait for row in tank.targets if row.run.gait]), steps=64)["turn_rate"]
    assert np.mean(np.abs(mean - np.log(np.abs(rates))) <= 1.96 * sd) >= 0.9


def test_a_robot_that_cannot_bend_to_one_side_has_no_turns(unknowns: Unknowns) -> None:
    with pytest.raises(InputError, match="range of bias"):
        TankDesign(None, unknowns.robot, want="turn")


def test_a_design_takes_trials_of_every_kind(unknowns: Unknowns, gaits: list[TankRun]) -> None:
    gait, time = gaits[40].gait, np.linspace(0, 3, 31)
    assert gait is not None
    trials = [
        ht.SteadyRun("swim", gait, 0.25, 0.01, repeats=4),
        ht.TurnRun("turn", -0.4, gait=replace(gait, bias=(np.radians(5),) * 3)),
        ht.PowerRun("power", 0.03, gait=gait),
        ht.Tow("tow", 0.06, u=0.3),
        ht.HeldThrust("held", 0.05, gait=gait),
        ht.Glide("glide", time, 0.4 / (1 + 0.5 * time), 0.004),
    ]
    with TankDesign(None, unknowns.robot, tow=True, hold=True, glide=True) as tank:
        assert {run.kind for run in tank.candidates} == {"steady", "tows", "thrusts", "glides"}
        tank.tell(trials, "monday")
        assert [one.quantity for one in tank.results] == [
            "speed", "turn_rate", "power", "drag", "thrust", "coasting_length",
        ]  # fmt: skip
        assert {one.day for one in tank.results} == {"monday"}
        assert tank.results[0].noise == pytest.approx(0.01 / 2 / 0.25)
        assert all(run_of(run_record(one.run)) == one.run for one in tank.results)
        with pytest.raises(InputError, match="must be a run that a design knows"):
            tank.tell([ht.YawDecay("yaw", time, 1 / (1 + time))])


def test_a_design_foresees_what_runs_narrow(unknowns: Unknowns, gaits: list[TankRun], targets: list[Row]) -> None:
    """Results as expected, and one size of the discrepancy: the refit has the very width that the design expected."""
    size = (0.05,)
    plan = design(infer(unknowns, [], size), "speed", gaits, targets)
    runs: list[TankRun] = []
    for _ in range(3):
        runs.append(plan.best())
        plan = plan.after([runs[-1]])
    after = infer(unknowns, told(unknowns, runs), size)
    assert np.sqrt(np.mean(after.predict(targets)[1] ** 2)) == pytest.approx(plan.width(), rel=1e-6)
    assert after.coefficients[1] == pytest.approx(plan.sd(), rel=1e-6)
    assert after.coefficients[0] == pytest.approx(unknowns.mean, abs=1e-9)


def test_the_best_run_narrows_more_than_any_other(unknowns: Unknowns, gaits: list[TankRun], targets: list[Row]) -> None:
    plan = design(infer(unknowns, []), "speed", gaits, targets)
    widths = {gait: plan.after([gait]).width() for gait in plan.places}
    assert min(widths, key=lambda gait: widths[gait]) == plan.best()


def test_a_check_is_made_far_from_all_runs(unknowns: Unknowns, gaits: list[TankRun], targets: list[Row]) -> None:
    plan = design(infer(unknowns, []), "speed", gaits, targets)
    slow = [run for run in gaits if run.gait and gaits[0].gait and run.gait.frequency == gaits[0].gait.frequency]
    check = plan.after(slow[:3]).farthest()
    near = correlation([Row(check, "speed")], [Row(gait, "speed") for gait in gaits])[0]
    made = [near[gaits.index(gait)] for gait in slow[:3]]
    assert max(made) < 0.15 < np.sort(near)[-2]


def asked(tank: TankDesign, fish: Tank, runs: int) -> None:
    """Make a number of runs, each as the design asks for it."""
    for _ in range(runs):
        choice = tank.ask().choices[0]
        result = fish.measure(choice.run, name=choice.name)
        assert result is not None
        tank.tell([result])


def test_a_misfit_is_not_reported_smaller_than_it_is(unknowns: Unknowns) -> None:
    """A linear drag that the fit lacks: the intervals hold the errors; a fit that trusts its model has no such ones.

    Half of the drag at 0.3 m/s, more at less: what grease in a bearing, or a cable, does.
    """
    rng = np.random.default_rng(7)
    fish = Tank(with_linear_drag(hidden(unknowns, rng), 0.5), rng)
    rows = unseen(unknowns.robot, rng)
    with TankDesign(None, unknowns.robot) as tank:
        asked(tank, fish, 12)
        mean, sd = tank.posterior.predict(rows)
        trusting = infer(unknowns, tank.results, (0.0,))
    true = fish.speeds([row.run for row in rows])
    good = true > 0.01
    off, plain = np.log(true[good]) - mean[good], np.log(true[good]) - trusting.predict(rows)[0][good]
    assert np.mean(np.abs(off) <= 1.96 * sd[good]) >= 0.85
    assert np.mean(np.abs(plain) <= 1.96 * trusting.predict(rows)[1][good]) < 0.85
    assert tank.posterior.size > 0.03


def test_twelve_designed_runs_reach_the_error_of_a_grid() -> None:
    """A share of validation/design: three hidden robots, whose noise alone leaves about 1 % after 24 runs of a grid."""
    robot = ht.load(EXAMPLES / "minnow.toml")
    errors, held, counted = [], 0, 0
    for seed in range(3):
        rng = np.random.default_rng(seed)
        unknowns = unknowns_of(robot)
        fish = Tank(hidden(unknowns, rng), rng)
        rows = unseen(robot, rng)
        with TankDesign(None, robot, width=0.001) as tank:
            asked(tank, fish, 12)
            mean, sd = tank.posterior.predict(rows)
        true = np.log(fish.speeds([row.run for row in rows]))
        good = np.isfinite(true) & np.isfinite(mean)
        errors.append(float(np.sqrt(np.mean((mean - true)[good] ** 2))))
        held += int(np.sum(np.abs(mean - true)[good] <= 1.96 * sd[good]))
        counted += int(good.sum())
    assert np.median(errors) < 0.02
    assert held / counted >= 0.9


def test_a_suggestion_takes_less_than_two_seconds(unknowns: Unknowns, gaits: list[TankRun]) -> None:
    with TankDesign(None, unknowns.robot, tow=True) as tank:
        tank.tell(told(unknowns, [*gaits[20:31]]))
        begin = time.process_time()
        tank.posterior = infer(unknowns, tank.results)
        tank.ask()
        assert time.process_time() - begin < 2


def test_a_tow_narrows_the_drag_area_and_a_gait_does_not(unknowns: Unknowns, gaits: list[TankRun]) -> None:
    """The minnow has friction alone, which its tow measures to the noise and the discrepancy of 5 %."""
    place = [name.endswith("drag_tangential[0-3]=common") for name in unknowns.names].index(True)
    towed = infer(unknowns, told(unknowns, [TankRun("tows", u=0.5)], "drag"), (0.05,)).coefficients[1][place]
    swum = infer(unknowns, told(unknowns, [gaits[40]]), (0.05,)).coefficients[1][place]
    assert towed < 0.08 < swum
    with TankDesign(None, unknowns.robot, want="coefficients", tow=True) as tank:
        assert tank.ask().choices[0].run.kind == "tows"


def test_no_tow_parts_the_friction_from_the_drag_of_the_head() -> None:
    """Both go with the square of the speed: every tow has the same row, of their shares a and b of the drag.

    However exact, tows leave the head's coefficient its prior times a / sqrt(a^2 + b^2); so do 12 gaits with them, to a
    tenth. A second body parts the two: with three times the area of the head its row is another.
    """
    unknowns = synthetic_unknowns(_synthetic())
    head, friction = (
        next(k for k, name in enumerate(unknowns.names) if part in name) for part in ("blunt_area", "drag_tangential")
    )
    tows = [Row(TankRun("tows", u=u), "drag") for u in (0.05, 0.3, 2.0)]
    rows = predict(unknowns, unknowns.mean, tows).jacobian
    assert np.linalg.matrix_rank(rows, tol=1e-9) == 1
    a, b = rows[0, [friction, head]]
    assert a + b == pytest.approx(1, abs=1e-6)

    def sd(*told: tuple[np.ndarray, float]) -> tuple[float, float]:
        """Standard deviations of the head's coefficient and of the drag, by rows with a relative noise."""
        information = sum((row.T @ row / noise**2 for row, noise in told), np.linalg.inv(unknowns.covariance))
        covariance = np.linalg.inv(information)
        return float(np.sqrt(covariance[head, head])), float(np.sqrt(rows[0] @ covariance @ rows[0]))

    limit = unknowns.sd[head] * a / np.hypot(a, b)
    swum = predict(unknowns, unknowns.mean, [Row(run, "speed") for run in gaits_of(unknowns)[::8]]).jacobian
    assert sd((rows, 1e-4))[0] == pytest.approx(limit, rel=1e-3)
    assert sd((swum, 0.03))[1] > 0.07
    assert 0.9 * limit < sd((swum, 0.03), (rows, 1e-4))[0] < limit
    assert sd((swum, 0.03), (rows, 0.04))[1] < 0.03
    other = np.zeros((3, len(unknowns.free)))
    other[:, [friction, head]] = np.array([a, 3 * b]) / (a + 3 * b)
    assert sd((swum, 0.03), (rows, 0.04), (other, 0.04))[0] < 0.3 * limit


def gaits_of(unknowns: Unknowns) -> list[TankRun]:
    return swims(candidate_gaits(gait_bounds(unknowns.robot), unknowns.robot))


def test_a_repeat_is_a_run_to_choose(unknowns: Unknowns, gaits: list[TankRun], targets: list[Row]) -> None:
    """A run that was very noisy is worth another."""
    noisy = [Measurement(one.run, "speed", one.value, sd=one.value) for one in told(unknowns, [gaits[40]])]
    plan = design(infer(unknowns, noisy), "speed", [gaits[40]], targets)
    assert plan.best() == gaits[40]
    assert plan.after([gaits[40]]).width() < plan.width()


def warned(unknowns: Unknowns, results: list[Measurement]) -> str:
    return " ".join(warnings_of(infer(unknowns, results), [], [], 0 * unknowns.sd))


def test_days_repeats_and_drifts_are_told(unknowns: Unknowns, gaits: list[TankRun]) -> None:
    quiet = told(unknowns, [gaits[20], gaits[33], gaits[40], gaits[51], gaits[62], gaits[70]])
    assert warned(unknowns, quiet) == ""
    again = [Measurement(one.run, "speed", one.value * factor) for one in quiet[:3] for factor in (1.0, 1.2)]
    assert "Repeats differ by" in warned(unknowns, again)
    days = [Measurement(one.run, "speed", one.value * f, day=d) for one in quiet for d, f in (("1", 1.0), ("2", 1.1))]
    assert "Days differ by" in warned(unknowns, days)
    posterior = infer(unknowns, days)
    assert 0.02 < posterior.day <= 0.05
    falling = [Measurement(quiet[2].run, "speed", quiet[2].value * 0.98**k) for k in range(12)]
    assert "drift by -" in warned(unknowns, falling)


def test_an_offset_of_a_day_is_no_property_of_its_gaits(unknowns: Unknowns, gaits: list[TankRun]) -> None:
    """Three gaits on a fast day, three on a slow one, one on both: their difference is put down to the days."""
    quiet = told(unknowns, [gaits[20], gaits[33], gaits[40], gaits[51], gaits[62], gaits[70], gaits[40], gaits[51]])
    days = ["1", "1", "1", "1", "2", "2", "2", "2"]
    shifted = [
        Measurement(one.run, "speed", one.value * (1.08 if day == "1" else 1.0), day=day)
        for one, day in zip(quiet, days, strict=True)
    ]
    known = infer(unknowns, shifted)
    unknown = infer(unknowns, [Measurement(one.run, "speed", one.value) for one in shifted])
    rows = [Row(gaits[62], "speed"), Row(gaits[20], "speed")]
    gaps = [float(np.diff(one.predict(rows)[0])[0]) for one in (known, unknown)]
    true = float(np.diff(predict(unknowns, unknowns.mean, rows).log)[0])
    assert abs(gaps[0] - true) < abs(gaps[1] - true)


def test_runs_of_one_frequency_are_warned_of(gaits: list[TankRun]) -> None:
    same = [run for run in gaits if run.gait and gaits[0].gait and run.gait.frequency == gaits[0].gait.frequency]
    other = [run for run in gaits if run not in same]
    assert shared_frequency([*same[:3], other[0]]) == (same[0].gait.frequency, 3)
    assert shared_frequency([*same[:3], *other[:2]]) is None
    assert shared_frequency(same[:3]) is None  # too few


def test_what_no_run_can_tell_is_told() -> None:
    """Friction and head are one sum in a tank: without a prior that parts them, no run tells the friction."""
    unknowns = synthetic_unknowns(_synthetic())
    with TankDesign(None, unknowns.robot, prior=_prior()) as tank:
        result = tank.ask(3)
    assert any("drag_tangential" in warning and "0.69" in warning for warning in result.warnings)
    never = dict(zip(result.unknowns.names, result.never, strict=True))
    friction = next(value for name, value in never.items() if "drag_tangential" in name)
    assert 0.6 < friction < 0.69


def _synthetic() -> ht.Robot:
    import tomllib

    from hypertuna.actuation.new import first_robot
    from hypertuna.description.robot import parse

    return parse(tomllib.loads(first_robot("synthetic", actuation="servo", links=4)), file="synthetic.toml")


def _prior() -> dict[str, float]:
    from hidden_fish import PRIOR

    return PRIOR


def test_the_prior_of_a_fit_is_its_covariance(unknowns: Unknowns) -> None:
    robot, frees = unknowns.robot, unknowns.free[:2]
    fitted = with_fit(
        robot, frees, [1.3, 0.9], covariance=np.array([[0.01, 0.002], [0.002, 0.04]]), trials="a.csv", seed=0, text="a"
    )
    found = unknowns_of(fitted)
    assert found.covariance[:2, :2] == pytest.approx(np.array([[0.01, 0.002], [0.002, 0.04]]) / [[1, 1], [1, 1]])
    assert set(found.names) == set(unknowns.names)
    there = predict(found, found.mean, [Row(TankRun("tows", u=0.3), "drag")]).log
    moved = unknowns.mean.copy()
    moved[:2] = np.log([1.3, 0.9])
    assert there == pytest.approx(predict(unknowns, moved, [Row(TankRun("tows", u=0.3), "drag")]).log)


@pytest.mark.parametrize(
    ("quantity", "value", "words"),
    [("speed", -0.1, "must be greater than 0"), ("speed", float("nan"), "must be"), ("drag", 0.1, "such a run")],
)
def test_results_that_no_logarithm_takes_are_refused(
    gaits: list[TankRun], quantity: str, value: float, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        Measurement(gaits[0], quantity, value)


def test_nothing_widens_by_a_run(unknowns: Unknowns, gaits: list[TankRun], targets: list[Row]) -> None:
    plan: Design = design(infer(unknowns, []), "cost", gaits, [Row(row.run, "cost_of_transport") for row in targets])
    before = np.diag(plan.covariance)
    assert np.all(np.diag(plan.after([plan.best()]).covariance) <= before + 1e-12)
