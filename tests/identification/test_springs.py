"""Springs of hinges as free coefficients: their names, derivatives, priors, and fits of robots with a hidden spring."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.description.writer import write_robot
from hypertuna.design.kinds import STEPS
from hypertuna.design.prediction import Row
from hypertuna.design.prediction import predict as predicted
from hypertuna.design.runs import TankRun
from hypertuna.design.unknowns import unknowns_of
from hypertuna.identification.coefficients import free, from_scale, sample_robots, to_scale, with_values
from hypertuna.identification.experiment import NAMES, experiment
from hypertuna.identification.fixed import fixed_coefficients, model_errors
from hypertuna.identification.identify import identify
from hypertuna.identification.image import sampled_image
from hypertuna.identification.names import prior_factor
from hypertuna.identification.prediction import predict
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gait, Gaits
from hypertuna.trials.numbers import HeldThrust, PowerRun, Tow, TurnRun
from hypertuna.trials.steady import MeasuredBend, SteadyRun
from hypertuna.trials.trials import Trials

STIFFNESS, NOISE = 0.05, 0.01  # N m/rad, near resonance with 2 Hz; relative noise of measured values
SPRING = {"stiffness_n_m_per_rad": STIFFNESS, "damping_n_m_s_per_rad": 3e-4}


def fish(hinges: int = 1, source: str = "bench", **numbers: float) -> ht.Robot:
    """A fish with one driven joint, and hinges at its last links; `source`: of the springs' numbers."""
    document = new_robot("fish", links=2 + hinges, length=0.3, mass=0.85)
    document["joints"] = document["joints"][:1]
    for name in ("gaits", "gait_bounds"):
        del document[name], document["sources"][name]
    tables = [{"link": 2 + d, **SPRING, **numbers} for d in range(hinges)]
    key, value = ("hinge", tables[0]) if hinges == 1 else ("hinges", tables)
    return parse(document | {key: value, "sources": document["sources"] | {key: source}}, file="fish.toml")


def gait(frequency: float, amplitude: float, bias: float = 0.0) -> Gait:
    return Gait.from_degrees(frequency=frequency, amplitude=(amplitude,), phase=(0,), bias=(bias,))


GAITS = [gait(f, a) for f in (1.0, 1.4, 1.8, 2.2, 2.6, 3.0) for a in (10, 18)]


def swum(robot: ht.Robot, seed: int | None = None) -> Trials:
    """Speed and cost of each gait as a robot swims it, with noise of a seed."""
    beats = settle(robot, Gaits.of(GAITS))
    noise = np.zeros((2, len(GAITS))) if seed is None else np.random.default_rng(seed).standard_normal((2, len(GAITS)))
    speed, cost = np.array([beats["speed"], beats["cost_of_transport"]]) * (1 + NOISE * noise)
    rows = zip(GAITS, speed.tolist(), cost.tolist(), strict=True)
    return Trials(tuple(SteadyRun(str(k), g, v, NOISE * v, c, NOISE * c) for k, (g, v, c) in enumerate(rows)))


@pytest.mark.parametrize(
    ("hinges", "name", "found"),
    [
        (1, "hinge.stiffness", ["hinge.stiffness"]),
        (1, "hinge.stiffness_n_m_per_rad", ["hinge.stiffness"]),  # as the file has it
        (1, "hinge.damping_n_m_s_per_rad=common", ["hinge.damping=common"]),
        (1, "hinge.rest_deg", ["hinge.rest"]),
        (2, "hinges.stiffness", ["hinges.stiffness[0-1]"]),  # one value for both
        (2, "hinges.stiffness=common", ["hinges.stiffness[0-1]=common"]),  # one factor on both: of the modulus
        (2, "hinges.stiffness[*]", ["hinges.stiffness[0]", "hinges.stiffness[1]"]),
        (2, "hinges[1].damping", ["hinges.damping[1]"]),  # as --design and `gradient` write it
        (2, "hinges[0].stiffness_n_m_per_rad", ["hinges.stiffness[0]"]),
    ],
)
def test_names(hinges: int, name: str, found: list[str]) -> None:
    assert [f.name for f in free(fish(hinges, cubic_n_m_per_rad3=0.1), [name])] == found


def test_a_stiffness_may_be_off_by_ten_and_a_hinge_may_have_no_damping() -> None:
    stiffness, damping, rest = free(fish(), ["hinge.stiffness", "hinge.damping", "hinge.rest"])
    assert (stiffness.lower, stiffness.start, stiffness.upper) == pytest.approx((0.005, 0.05, 0.5))
    assert (damping.lower, damping.start, damping.upper) == pytest.approx((0, 3e-4, 3e-3))
    assert (rest.lower, rest.start, rest.upper) == pytest.approx((-math.pi / 6, 0, math.pi / 6))
    assert [stiffness.border[0], damping.border[0], rest.border[0]] == ["N m/rad", "N m s/rad", "deg"]


@pytest.mark.parametrize(
    ("robot", "names", "options", "sentence"),
    [
        (ht.load("rexeel"), ["hinge.stiffness"], {}, "belongs to a hinge, which the robot lacks: leave it out, or add"),
        (fish(), ["hinge.stifness"], {}, "is not a coefficient that can be free: did you mean hinge.stiffness?"),
        (fish(), ["hinge.stop"], {}, "is not a coefficient that can be free"),  # no stops
        (fish(), ["hinge.stiffness[0]"], {}, "has one value only: write hinge.stiffness without brackets"),
        (fish(2), ["hinges[2].stiffness"], {}, "must have indices from 0 to 1, ranges such as 1-1, but is '2'"),
        (
            fish(),
            ["hinge.stiffness"],
            {"bounds": {"hinge.stiffness": (0, 1)}},
            "must keep the robot's file valid (at 0",
        ),
        (fish(), ["hinge.rest"], {"bounds": {"hinge.rest": (-2.0, 0.1)}}, "must keep the robot's file valid (at -2"),
        (
            fish(),
            ["hinge.cubic"],
            {},
            "bounds hinge.cubic must have a lower bound below its upper one",
        ),  # described as 0
    ],
)
def test_errors(robot: ht.Robot, names: list[str], options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ht.InputError) as error:
        free(robot, names, **options)
    assert sentence in str(error.value)


def test_trials_that_leave_the_hinge_rigid_cannot_know_its_spring() -> None:
    held = Trials((HeldThrust("a", 0.2, 0.01, gait=gait(1, 10)), Tow("b", 0.1, 0.01, u=0.3)))
    sentence = "free hinge.stiffness needs trials in which the spring bends the hinge"
    for given in (["hinge.stiffness"], free(fish(), ["hinge.stiffness"])):
        with pytest.raises(ht.InputError, match=sentence) as error:
            identify(fish(), held, given)
        assert "steady runs, power logs, turns" in str(error.value)


def test_bounds_that_no_beat_can_follow_are_refused_before_the_fit() -> None:
    with pytest.raises(ht.InputError, match="must have bounds that the beats can follow") as error:
        identify(fish(), swum(fish()), ["hinge.stiffness"], bounds={"hinge.stiffness": (0.01, 1e6)})
    assert "give lower --bounds" in str(error.value)


@pytest.mark.parametrize("hinges", [1, 2])
def test_derivatives_equal_differences(hinges: int) -> None:
    """Of all kinds of trials in one fit: hinges bend in three of them, and stay rigid in thrusts and tows."""
    robot = fish(hinges, cubic_n_m_per_rad3=0.05, moment_n_m=2e-3, moment_phase_deg=40.0)
    runs = [SteadyRun("a", gait(1.4, 12), 0.1, 0.01, 1.0, 0.1), SteadyRun("b", gait(2.2, 16), 0.1, 0.01, 1.0, 0.1)]
    forces = [HeldThrust("e", 0.2, 0.01, gait=gait(1, 10)), Tow("f", 0.1, 0.01, u=0.3)]
    others = [PowerRun("c", 0.1, 0.01, gait=gait(2, 14)), TurnRun("d", 0.1, 0.01, gait=gait(2, 14, 8)), *forces]
    table = "hinge" if hinges == 1 else "hinges"
    names = [f"{table}.{name}{'=common' * (hinges == 2)}" for name in ("stiffness", "damping", "cubic", "moment")]
    names += [f"{table}.rest", "water.strip.drag_tangential=common", "links.mass[1]"]
    frees = free(robot, names, log=[names[0]], bounds={names[4]: (-0.5, 0.5)}, start={names[4]: 0.05})
    data = experiment(robot, Trials((*runs, *others)), frees, steps=512)
    x, h = to_scale(frees, [f.start for f in frees]), 1e-4
    jacobian = predict(data, from_scale(frees, x), gradient_steps=512).jacobian
    for k in range(len(frees)):
        step = h * max(abs(x[k]), 1e-2) * np.eye(len(frees))[k]
        high, low = (predict(data, from_scale(frees, x + side * step), gradient_steps=None) for side in (1, -1))
        numeric = (high.computed - low.computed) / (2 * step[k])
        scale = max(float(np.abs(numeric).max()), 1e-12)
        assert jacobian[:, k] / scale == pytest.approx(numeric / scale, abs=1e-6), names[k]
    rigid = data.kind == NAMES.index("drag")
    rigid |= data.kind == NAMES.index("thrust")
    assert not jacobian[rigid, :5].any()
    assert jacobian[~rigid, :5].all()


def test_a_hidden_stiffness_is_found_and_written(tmp_path: Any) -> None:
    robot, names = fish(), ["hinge.stiffness", "water.strip.drag_tangential=common"]
    frees = free(robot, names)
    hidden = with_values(robot, frees, [0.09, 1.3])
    fit = identify(robot, swum(hidden), names, starts=2, validate=0, loss="linear")
    assert fit.converged
    assert fit.values == pytest.approx([0.09, 1.3], rel=1e-5)
    noisy = identify(robot, swum(hidden, seed=1), names, starts=1, validate=0, loss="linear")
    assert noisy.uncertainty.low[0] < 0.09 < noisy.uncertainty.high[0]
    assert fit.uncertainty.directions[0].sentence.startswith("Speed and cost of transport constrain ")

    assert fit.robot.hinge is not None
    assert fit.robot.hinge.stiffness == pytest.approx(0.09, rel=1e-5)
    assert fit.robot.source("hinge.stiffness_n_m_per_rad") == "identified from memory, see [fit]"
    assert fit.robot.source("hinge.damping_n_m_s_per_rad") == "bench"
    write_robot(fit.robot, tmp_path / "fit.toml")
    read = ht.load(tmp_path / "fit.toml")
    drawn = [sample.hinge.stiffness for sample in sample_robots(read, 64, seed=0) if sample.hinge]
    assert np.std(drawn) == pytest.approx(float(fit.uncertainty.sd[0]), rel=0.3)
    certain = parse({name: part for name, part in read.document().items() if name != "uncertainty"})
    assert b"samples.spring.stiffness" in sampled_image(certain)  # the studio's band, unless it is of estimates
    assert [f.name for f in unknowns_of(read).free][:2] == ["hinge.stiffness", names[1].replace("=", "[0-2]=")]


def filmed(robot: ht.Robot, *, seed: int | None = None, bends: bool = True) -> Trials:
    """Speed, and amplitude and lag of each hinge, of four gaits as a robot swims them, with noise of a seed."""
    gaits = [gait(f, 14) for f in (1.2, 1.8, 2.4, 3.0)]
    beats, hinges = settle(robot, Gaits.of(gaits)), len(robot.hinges)
    ends = [f"_{d + 1}" for d in range(hinges)] if hinges > 1 else [""]
    draws = np.zeros((4, 1 + 2 * hinges)) if seed is None else np.random.default_rng(seed).standard_normal((4, 3))
    runs = []
    for k, (one, noise) in enumerate(zip(gaits, 0.03 * draws, strict=True)):
        measured = []
        for d, end in enumerate(ends):
            swing, lag = (float(beats[f"bend_{name}{end}"][k]) for name in ("amplitude", "lag"))
            swing, lag = swing * (1 + noise[1 + 2 * d]), lag + noise[2 + 2 * d] - 2 * math.pi * (k % 2)  # a turn less
            measured.append(MeasuredBend(swing, 0.03 * swing, lag, 0.03))
        speed = float(beats["speed"][k]) * (1 + noise[0])
        runs.append(SteadyRun(f"{k}", one, speed, 0.03 * speed, bends=tuple(measured) if bends else ()))
    return Trials(tuple(runs))


@pytest.mark.parametrize("hinges", [1, 2])
def test_measured_bends_are_predicted_with_their_derivatives(hinges: int) -> None:
    """Of amplitude and lag of each hinge; a lag of a turn less is the same."""
    robot = fish(hinges)
    table = "hinge" if hinges == 1 else "hinges"
    names = [f"{table}.stiffness{'=common' * (hinges == 2)}", "water.strip.drag_tangential=common", "links.mass[1]"]
    frees = free(robot, names, log=names[:1])
    data = experiment(robot, filmed(robot), frees)
    assert len(data.measured) == 4 * (1 + 2 * hinges)
    x = to_scale(frees, [f.start for f in frees])
    found = predict(data, from_scale(frees, x))
    assert found.computed == pytest.approx(data.measured, rel=1e-12)
    for k in range(len(frees)):
        step = 1e-4 * np.eye(len(frees))[k]
        high, low = (predict(data, from_scale(frees, x + side * step), gradient_steps=None) for side in (1, -1))
        numeric = (high.computed - low.computed) / 2e-4
        assert found.jacobian[:, k] == pytest.approx(numeric, abs=1e-5 * np.abs(numeric).max()), names[k]


def test_a_filmed_hinge_narrows_its_stiffness() -> None:
    """To two thirds of what the speeds alone leave, around the hidden value."""
    robot, widths = fish(stiffness_n_m_per_rad=0.06), np.zeros((2, 2))
    for seed in range(2):
        for row, bends in enumerate((False, True)):
            trials = filmed(fish(), seed=seed, bends=bends)
            fit = identify(robot, trials, ["hinge.stiffness"], starts=1, validate=0, log=["hinge.stiffness"])
            (found,) = fit.parameters
            assert found["low"] < STIFFNESS < found["high"]
            widths[row, seed] = found["high"] - found["low"]
    assert np.median(widths[1] / widths[0]) < 0.7
    assert set(fit.train.rms) == {"speed_relative", "bend_amplitude_relative", "bend_lag_deg"}


def test_bends_of_another_number_of_hinges_are_refused() -> None:
    with pytest.raises(ht.InputError, match="must be one of each of the 2 hinges of fish, but is 1: give one of each"):
        identify(fish(2), filmed(fish()), ["hinges.stiffness=common"])


def test_one_factor_on_the_springs_of_a_flexible_fin() -> None:
    robot, names = fish(2), ["hinges.stiffness=common"]
    hidden = with_values(robot, free(robot, names), [0.6])
    fit = identify(robot, swum(hidden), names, starts=1, validate=0)
    assert [hinge.stiffness for hinge in fit.robot.hinges] == pytest.approx([0.6 * STIFFNESS] * 2, rel=1e-5)


def test_priors_of_estimated_springs_alone() -> None:
    """A spring that a bench has measured is known; others are as uncertain as handbooks, or the file, say."""
    assert prior_factor(fish(source="bench"), "hinge.stiffness") is None
    estimate = fish(source="estimate: a plate of 1 mm")
    assert [prior_factor(estimate, f"hinge.{name}") for name in ("stiffness", "damping", "rest")] == [1.4, 3.0, None]
    wide = parse(estimate.document() | {"uncertainty": {"hinge.stiffness_n_m_per_rad": 4.0}})
    assert prior_factor(wide, "hinge.stiffness") == pytest.approx(4 ** (1 / 1.645))  # 90 % of cases within 4
    (one,) = free(wide, ["hinge.stiffness"], prior={"hinge.stiffness": 2.0})
    assert (one.prior, one.scale) == ((STIFFNESS, 2.0), "log")


def test_estimated_springs_that_are_fixed_widen_the_intervals() -> None:
    """As if they were free with their priors; those from a bench do not."""
    names = [f.name for f in fixed_coefficients(fish(2, source="estimate"), ())]
    assert [name for name in names if "hinge" in name] == ["hinges.stiffness[0-1]=common", "hinges.damping[0-1]=common"]
    assert not [f.name for f in fixed_coefficients(fish(2), ()) if "hinge" in f.name]
    widths, counts = [], []
    for source in ("bench", "estimate"):
        robot = fish(source=source)
        fit = identify(robot, swum(robot, seed=2), starts=1, validate=0, loss="linear")
        widths.append(fit.uncertainty.sd)
        counts.append(model_errors(experiment(robot, fit.trials[0], fit.free), fit.values, {}).shape[1])
    assert counts[1] == counts[0] + 2  # stiffness and damping
    assert (widths[1] >= widths[0]).all()
    assert (widths[1] > 1.05 * widths[0]).any()


def test_a_design_narrows_the_spring_by_swims_alone() -> None:
    """The derivative of a predicted speed by the stiffness, by differences; a tow has none."""
    unknowns = unknowns_of(fish(source="estimate"))
    k = unknowns.names.index("hinge.stiffness=common")
    rows = [Row(TankRun("steady", GAITS[4]), "speed"), Row(TankRun("tows", None, 0.3), "drag")]
    step = 1e-4 * np.eye(len(unknowns.free))[k]
    high, low = (predicted(unknowns, unknowns.mean + side * step, rows).log for side in (1, -1))
    slope = predicted(unknowns, unknowns.mean, rows).jacobian[:, k]
    assert slope == pytest.approx((high - low) / (2 * step[k]), rel=1e-5, abs=1e-9)
    assert slope[0] != 0
    assert slope[1] == 0
    assert STEPS == 64  # of the beats, above which the difference would follow another path
