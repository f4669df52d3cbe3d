"""Tows, held thrusts, powers, glides and yaw decays against formulas, and what each tells that swims do not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.identification.coefficients import free, parameter_jacobian, prior_rows
from hypertuna.identification.experiment import experiment
from hypertuna.identification.identify import identify
from hypertuna.identification.prediction import predict, weighted
from hypertuna.io import door, tables
from hypertuna.swimming.beat import directional_derivatives, settle
from hypertuna.swimming.model import core_model
from hypertuna.trials.decay import Decay, Glide, YawDecay
from hypertuna.trials.kind_decay import YawDecays
from hypertuna.trials.numbers import HeldThrust, NumberRun, PowerRun, Tow, TurnRun
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.tables import read_runs
from hypertuna.trials.trials import Trials, implausible, read_trials
from models import changed

EXAMPLES = Path(__file__).parents[2] / "examples"
TANK = EXAMPLES / "tank"
TIME = np.linspace(0, 3, 31)


@pytest.fixture(scope="module")
def minnow() -> ht.Robot:
    return ht.load(EXAMPLES / "minnow.toml")


@pytest.fixture(scope="module")
def fish() -> ht.Robot:
    """A fish whose head has a drag area of its own."""
    return ht.load(EXAMPLES / "myfish.toml")


def computed(robot: ht.Robot, *runs: Any) -> np.ndarray:
    return predict(experiment(robot, Trials(runs)), [], gradient_steps=None).computed


def made(robot: ht.Robot, run: NumberRun | Decay, noise: float, rng: np.random.Generator) -> Any:
    """A run as the robot would have made it, with stated noise: relative, of a decay over its first value."""
    value = computed(robot, run)
    if isinstance(run, NumberRun):
        sd = noise * abs(float(value[0]))
        return replace(run, value=float(value[0]) + sd * rng.standard_normal(), sd=sd)
    sd = noise * abs(float(run.value[0]))
    return replace(run, value=value + sd * rng.standard_normal(len(value)), sd=sd)


def tow(u: float) -> Tow:
    return Tow(f"tow {u}", 1.0, u=u)


def test_the_drag_of_a_tow_is_that_of_the_wetted_area(minnow: ht.Robot) -> None:
    """By hand: 1/2 1000 0.03 (0.0204 + 0.0087 + 0.005 + 0.0097) u^2 = 0.657 u^2."""
    assert computed(minnow, tow(0.3), tow(0.6)) == pytest.approx([0.657 * 0.09, 0.657 * 0.36], rel=1e-9)


def test_a_glide_slows_down_by_its_length(minnow: ht.Robot) -> None:
    """Of quadratic drag 0.657 u^2 and the mass 0.415 of the links alone: u = u0 / (1 + u0 t / L), L = 0.415 / 0.657."""
    bare = changed(minnow, {"water.strip.added_mass_tangential": [0.0] * 4})
    speed = 0.4 / (1 + 0.4 * TIME / (0.415 / 0.657))
    assert computed(bare, Glide("a", TIME, speed)) == pytest.approx(speed, rel=2e-6)


def test_a_yaw_decay_is_that_of_the_equations_of_motion(minnow: ht.Robot) -> None:
    """The rate at which it begins to fall is the angular acceleration of the turn about the center of mass."""
    first, dt = 1.5, 1e-3
    twist = first * YawDecays().begin(minnow)
    still = np.zeros((1, 4, 3))
    acceleration = _core.dynamics(core_model(minnow), still, twist[np.newaxis])["acceleration"][0, 2]
    time = dt * np.arange(5)
    value = computed(minnow, YawDecay("a", time, first + acceleration * time))
    assert acceleration < 0
    assert (value[1] - value[0]) / dt == pytest.approx(acceleration, rel=0.03)


def test_the_thrust_of_a_held_fish_is_the_mean_force_of_the_water(minnow: ht.Robot) -> None:
    """Summed in Python over the instants of a beat; and a beat that the head is towed along with at no thrust swims."""
    gait, u = ht.named_gait(minnow, "cruise"), 0.1
    clock = 2 * np.pi * np.arange(256) / 256
    waves = {kind: list(getattr(gait, kind)) for kind in ("amplitude", "phase", "bias")}
    joints = _core.joint_motion(core_model(minnow), frequency=gait.frequency, **waves, clock=clock)
    twist = np.tile([-u, 0.0, 0.0], (256, 1))
    wrench = _core.dynamics(core_model(minnow), joints, twist)["wrench"]
    held = HeldThrust("a", 1.0, gait=gait, u=u)
    assert computed(minnow, held)[0] == pytest.approx(-wrench[:, 0].mean(), rel=1e-9)


def test_the_power_of_a_gait_is_that_of_its_beat(minnow: ht.Robot) -> None:
    gait = ht.named_gait(minnow, "cruise")
    assert computed(minnow, PowerRun("a", 1.0, gait=gait))[0] == pytest.approx(ht.swim(minnow, gait).mechanical_power)


def test_a_turn_is_that_of_its_beat_and_its_file_is_in_degrees(minnow: ht.Robot, tmp_path: Path) -> None:
    gait = replace(ht.named_gait(minnow, "cruise"), bias=(0.1, 0.1, 0.1))
    swim = ht.swim(minnow, gait)
    rate = computed(minnow, TurnRun("a", 1.0, gait=gait))[0]
    assert rate == pytest.approx(swim.turn_rate)
    assert abs(rate) * swim.turn_radius == pytest.approx(swim.speed)  # so that a radius and a speed give the rate
    path, made = tmp_path / "turns.csv", TurnRun("a", rate, 0.01 * abs(rate), gait=gait)
    made.to_pandas().to_csv(path, index=False)
    (read,) = read_runs(path, minnow)
    assert isinstance(read, TurnRun)
    assert (read.value, read.sd) == pytest.approx((made.value, made.sd))


@pytest.mark.parametrize("name", ["tank", "tow", "turn", "glide"])
def test_a_table_of_runs_is_read_once(tuna: ht.Robot, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []

    def counted(*given: Any) -> str:
        opened.append(given)
        return door.read_text(*given)

    monkeypatch.setattr(tables, "read_text", counted)
    assert read_runs(TANK / f"{name}.csv", tuna)
    assert len(opened) == 1


def test_tows_tell_the_drag_and_hardly_the_speed(fish: ht.Robot) -> None:
    """By the linear covariance of 12 gaits of 2 % and 3 mm/s, six coefficients with priors, and tows of 3 % and 5 mN.

    The drag of the straight body at 0.3 m/s, in which friction and the head's drag are one, is what they narrow.
    """
    widths = {"drag_tangential": 2.0, "blunt_area": 2.0, "drag_normal": 1.5, "added_mass_normal": 1.5}
    widths |= {"drag_beating": 1.5, "edge_lift": 1.3}
    names = {f"water.strip.{name}=common": width for name, width in widths.items()}
    frees, cruise = free(fish, list(names), prior=names), ht.named_gait(fish, "cruise")
    values = [f.start for f in frees]

    def beats(frequencies: tuple[float, ...], amplitudes: tuple[float, ...]) -> list[ht.Gait]:
        return [
            replace(cruise, frequency=f * cruise.frequency, amplitude=tuple(a * x for x in cruise.amplitude))
            for f in frequencies
            for a in amplitudes
        ]

    def covariance(*runs: Any) -> np.ndarray:
        data = experiment(fish, Trials(runs), frees)
        rows = [weighted(data, predict(data, values), {})[1], prior_rows(frees, np.zeros(len(frees)))[1]]
        return np.linalg.inv(sum(row.T @ row for row in rows))

    gaits, others = beats((0.4, 0.7, 1.0, 1.3), (0.5, 0.75, 1.0)), ht.Gaits.of(beats((0.5, 0.9, 1.2), (0.6, 0.9)))
    speeds = settle(fish, ht.Gaits.of(gaits))["speed"].tolist()
    runs = [
        SteadyRun(f"{k}", g, v, speed_sd=0.02 * v + 0.003) for k, (g, v) in enumerate(zip(gaits, speeds, strict=True))
    ]
    drags = zip((0.15, 0.3, 0.5), computed(fish, tow(0.15), tow(0.3), tow(0.5)).tolist(), strict=True)
    tows = [Tow(f"tow {u}", drag, u=u, sd=0.03 * drag + 0.005) for u, drag in drags]
    without, with_tows = covariance(*runs), covariance(*runs, *tows)
    one = predict(experiment(fish, Trials((tow(0.3),)), frees), values)
    settled = settle(fish, others)
    along = parameter_jacobian(fish, frees, values)
    speed = directional_derivatives(fish, others, settled, along)["speed"] / settled["speed"][:, np.newaxis]
    drag = one.jacobian / one.computed[:, np.newaxis]
    was, now = (
        [float(np.sqrt(np.mean(np.einsum("gi,ij,gj->g", by, c, by)))) for by in (drag, speed)]
        for c in (without, with_tows)
    )
    assert now[0] < 0.5 * was[0]
    assert now[0] < 0.05
    assert 0.8 * was[1] < now[1] < was[1]


FORCES = [
    *(tow(u) for u in (0.2, 0.4)),
    Glide("glide", TIME, 0.4 / (1 + 0.5 * TIME)),
    YawDecay("yaw", TIME[:10], 2 / (1 + 2 * TIME[:10])),
]


def test_intervals_of_forces_hold_the_truth(minnow: ht.Robot) -> None:
    """Without a swim: tows, a glide, a yaw decay, held thrusts and powers together, in 10 draws of 2 % of noise.

    Drag along, drag across and added mass are determined to 15 % or better; of 30 intervals of 95 %, 27 hold the truth.
    """
    cruise, names = ht.named_gait(minnow, "cruise"), ("drag_tangential", "drag_normal", "added_mass_normal")
    beats = [replace(cruise, frequency=f * cruise.frequency) for f in (0.6, 1.0)]
    runs = FORCES + [HeldThrust(f"held {k}", 1.0, gait=g) for k, g in enumerate(beats)]
    runs += [PowerRun(f"power {k}", 1.0, gait=g) for k, g in enumerate(beats)]
    free_names, ends = [f"water.strip.{name}=common" for name in names], []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        trials = Trials(tuple(made(minnow, run, 0.02, rng) for run in runs))
        fit = identify(minnow, trials, free_names, validate=0, starts=1)
        ends += [(row["low"], row["high"]) for row in fit.parameters]
    low, high = np.array(ends).T
    assert np.median((high - low).reshape(-1, 3) / 2, axis=0).max() < 0.15
    assert ((low <= 1) & (high >= 1)).sum() >= 27


def test_forces_in_another_unit_or_of_the_other_sign_are_unlikely(fish: ht.Robot) -> None:
    drag = float(computed(fish, tow(0.3))[0])
    for factor, words in ((1.0, ""), (102.0, "are 1e+02 times"), (-1.0, "are -1 times"), (0.01, "are 0.01 times")):
        _, warnings = implausible(Trials((replace(tow(0.3), value=factor * drag, file="tow.csv"),)), fish)
        assert len(warnings) == bool(words)
        assert all(f"tow.csv: the measured values of drag {words} those of the model" in text for text in warnings)


@pytest.mark.parametrize(
    ("time", "value", "sentence"),
    [
        (1.0, 1.0, ""),
        (1000.0, 1.0, "decays at 0.001 times the rate of the model"),
        (1 / 60, 1.0, "decays at 60 times the rate of the model"),
        (1.0, 100.0, "decays at 0.01 times the rate of the model"),
        (1.0, -1.0, "moves backward"),
    ],
)
def test_glides_in_another_unit_are_unlikely(minnow: ht.Robot, time: float, value: float, sentence: str) -> None:
    """A glide of the model itself is not; 1/speed grows by the same amount in each second."""
    speed = value * computed(minnow, Glide("a", TIME, np.full(31, 0.4), 0.01))
    _, warnings = implausible(Trials((Glide("a", time * TIME, speed),)), minnow)
    assert (len(warnings), sentence in " ".join(warnings)) == (bool(sentence), True), warnings


def test_decays_that_rise_are_unlikely(minnow: ht.Robot) -> None:
    """A push before the body was let go, two glides in one, a speed that stays; noise of 5 % is no rise."""
    speed = 0.4 / (1 + TIME)
    noisy = speed + np.random.default_rng(0).normal(0, 0.02, 31)
    cases = {"": noisy, "gets faster until 0.9 s": np.append(np.linspace(0.02, 0.4, 10), speed[:21])}
    cases |= {"gets faster until 1.6 s": np.append(speed[:16], speed[:15]), "does not slow down": np.full(31, 0.3)}
    for sentence, value in cases.items():
        _, warnings = implausible(Trials((Glide("a", TIME, value),)), minnow)
        assert (len(warnings), sentence in " ".join(warnings)) == (bool(sentence), True), warnings


@pytest.mark.parametrize("column", ["power_w", "drag_n", "thrust_n"])
def test_a_log_over_time_is_no_table_of_runs(tuna: ht.Robot, tmp_path: Path, column: str) -> None:
    (tmp_path / "log.csv").write_text(f"time_s,{column}\n0,1\n0.1,2\n")
    with pytest.raises(ht.InputError, match=f"line 1, {column} is a log over time: write a row for each run, with the"):
        read_runs(tmp_path / "log.csv", tuna)


def test_files_of_forces_are_told_by_their_columns(tuna: ht.Robot, tmp_path: Path) -> None:
    tank = EXAMPLES / "tank"
    whole = read_trials(tank / "forces.toml", tuna)
    alone = [tank / f"{name}.csv" for name in ("tow", "thrust", "power", "glide", "yaw")]
    assert [type(one) for one in read_trials(alone, tuna).members] == [type(one) for one in whole.members]
    for text, sentence in (
        (
            "u_m_s,drag_mn\n0.2,1\n",
            "drag_mn is not a known column: did you mean drag_n? Then divide the numbers by 1000.",
        ),
        ("u_cm_s,drag_n\n20,1\n", "u_cm_s is not a known column: did you mean u_m_s? Then divide the numbers by 100."),
        ("u_m_s,drag_n\n-0.2,1\n", "line 2, u_m_s must be greater than 0 and at most 100 m/s, but is -0.2"),
        ("u_m_s,drag_n\n0.2,x\n", "line 2, drag_n must be a number, but is 'x'"),
        ("u_m_s,drag_n\n0.2,0\n", "line 2, drag_n must have a standard deviation where it is 0"),
        ("time_s,speed_m_s\n0,1\n1,0.5\n", "run file must have at least 4 rows, but is 2"),
        ("time_s,yaw_rate_rad_s\n0,1\n", "did you mean yaw_rate_deg_s? Then multiply the numbers by 57.2958"),
        ("time_s,speed_m_s\n0,1\n1,0.5\n1,0.4\n2,0.2\n", "time_s must be later than the previous row, at 1 s"),
    ):
        (tmp_path / "file.csv").write_text(text)
        with pytest.raises(ht.InputError) as error:
            read_trials(tmp_path / "file.csv", tuna)
        assert sentence in str(error.value)
