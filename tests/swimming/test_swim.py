"""One gait: settled, from rest, turning, backward, in a current, and when it does not settle."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import resample

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.pose import body_points
from hypertuna.io.files import write_netcdf
from hypertuna.swimming.beat import STATUSES
from hypertuna.swimming.gait import named_gait
from models import MODELS, changed, fastest, later, turning
from oracles import beats
from oracles.planar import Chain, Lumped, Water, elongated_of, strip_of

Array = NDArray[np.float64]

PUBLISHED = [f"{kind}-{speed}" for kind in ("unoptimised", "optimised") for speed in ("0.3", "0.4", "0.5", "max")]


# --- against the oracle


def oracle(robot: ht.Robot) -> tuple[Chain, Water]:
    """The robot as the oracle takes it."""
    links, water = robot.links, robot.water
    chain = Chain(*(np.array(getattr(links, name)) for name in ("length", "com", "mass", "inertia")))
    lateral, wetted = np.array(links.lateral_area), np.array(links.wetted_area)
    if robot.model.water != "lumped":
        table = dict(getattr(water, robot.model.water))
        columns = {name: np.array(value) if isinstance(value, tuple) else value for name, value in table.items()}
        law = {"strip": strip_of, "elongated": elongated_of}[robot.model.water]
        return chain, law(chain, water.density, lateral, wetted, **columns)
    assert water.lumped is not None
    friction, drag = (wetted, lateral) if robot.model.areas == "consistent" else (lateral, wetted)
    columns = {name: np.array(value) for name, value in dict(water.lumped).items()}
    return chain, Lumped(water.density, friction_area=friction, drag_area=drag, **columns)


def oracle_gaits(robot: ht.Robot, gaits: list[ht.Gait]) -> beats.Gait:
    """The gaits as the oracle takes them, all in one."""
    share = np.zeros((len(robot.joints), len(robot.links.name)))
    for g, group in enumerate(robot.joints):
        share[g, list(group.links)] = group.share
    lags = robot.model.joints == "bandwidth"
    (bandwidth,) = {group.bandwidth if lags else np.inf for group in robot.joints}  # the oracle has one for all groups
    angles = (np.array([getattr(gait, name) for gait in gaits]) for name in ("amplitude", "phase", "bias"))
    return beats.Gait(np.array([gait.frequency for gait in gaits]), *angles, share, bandwidth or np.inf)


def check_against_oracle(robot: ht.Robot, gaits: list[ht.Gait]) -> None:
    """From the settled beat's start the oracle swims the same beat: it closes there too, as far, at the same cost."""
    swims = [ht.swim(robot, gait) for gait in gaits]
    assert all(swim.settled for swim in swims)
    starts = [[float(swim.trajectory[name][0]) for name in ("u", "v", "r")] for swim in swims]
    ends = [[float(swim.trajectory[name][-1]) for name in ("x", "y", "heading")] for swim in swims]
    (chain, water), same = oracle(robot), oracle_gaits(robot, gaits)
    states = beats.beat(chain, water, same, np.pad(starts, ((0, 0), (3, 0))))
    # Both take 128 steps, in other variables: their errors differ, by 1e-5 at most (test_convergence.py).
    scale = robot.body.length * np.array([[gait.frequency] for gait in gaits])
    np.testing.assert_allclose(beats.twist(states[-1])[:, :2] / scale, beats.twist(states[0])[:, :2] / scale, atol=1e-5)
    np.testing.assert_allclose(states[-1, :, :3], ends, atol=1e-5)
    np.testing.assert_allclose(
        [swim.mechanical_power for swim in swims], beats.mean_power(chain, water, same, states), rtol=1e-4
    )


@pytest.mark.parametrize("areas", ["consistent", "as-printed"])
@pytest.mark.parametrize("joints", ["ideal", "bandwidth"])
def test_the_published_gaits_against_the_oracle(tuna: ht.Robot, joints: str, areas: str) -> None:
    robot = tuna.using(joints=joints, areas=areas)
    check_against_oracle(robot, [named_gait(robot, name) for name in (*PUBLISHED, "turning")])


def test_every_model_against_the_oracle(every_model: ht.Robot) -> None:
    check_against_oracle(every_model, [fastest(every_model), turning(every_model)])


# Speeds [m/s] to five digits by the oracle's own search for the settled beat, which takes minutes.
SPEEDS = {
    "ideal": (0.28802, 0.43203, 0.72874, 0.90582, 0.31480, 0.57492, 0.71026, 0.90423),
    "bandwidth": (0.26924, 0.37496, 0.51117, 0.57752, 0.28996, 0.40482, 0.48265, 0.57764),
}


@pytest.mark.parametrize(("joints", "speeds"), SPEEDS.items())
def test_the_published_gaits_have_the_speeds_that_the_oracle_settles_at(
    tuna: ht.Robot, joints: str, speeds: tuple[float, ...]
) -> None:
    robot = tuna.using(joints=joints)
    found = [ht.swim(robot, named_gait(robot, name)).speed for name in PUBLISHED]
    np.testing.assert_allclose(found, speeds, atol=0.5e-5, rtol=0)


# --- statuses


def test_a_settled_gait_says_so(tuna: ht.Robot) -> None:
    swim = ht.swim(tuna, fastest(tuna))
    assert swim.settled
    assert swim.change_per_beat < 1e-8
    assert abs(swim.multipliers[0]) == swim.spectral_radius < 1
    expected = (
        r"The gait is settled: consecutive beats agree .* "
        rf"decays by {100 * (1 - swim.spectral_radius):.0f} % each beat\. "
        r"From rest the robot reaches this motion in \d+ beats\."
    )
    assert re.fullmatch(expected, swim.status_text)


@pytest.mark.parametrize(
    ("status", "radius", "words"),
    [
        ("settled", 0.754, "a disturbance decays by 25 % each beat."),
        ("settled", 0.9998, "a disturbance decays slowly, by 0.02 % each beat."),
        ("settled", 0.9999999, "a disturbance hardly decays."),
        ("unstable", 1.012, "a disturbance grows by 1.2 % each beat, so the robot will not stay in it."),
        ("unstable", 3.2, "a disturbance grows to 3.2 times its size each beat, so the robot will not stay in it."),
    ],
)
def test_how_a_disturbance_goes_on(status: str, radius: float, words: str) -> None:
    assert _core.verdict(STATUSES.index(status), 5, 1e-9, radius, 0).endswith(words)


@pytest.mark.parametrize("from_rest", [None, 5.0])
def test_a_gait_that_diverges_is_not_settled(from_rest: float | None) -> None:
    robot = MODELS["hypertuna-lumped"]
    stiff = changed(robot, {"water.lumped.drag": [1e6] * len(robot.links.name)})
    swim = ht.swim(stiff, fastest(stiff), steps=8, from_rest=from_rest)
    assert swim.status == "diverged"
    assert not swim.settled
    assert "check the robot first (`hypertuna robot check FILE`)" in swim.status_text
    assert swim.status_text.endswith(".")


def test_a_straight_gait_may_be_unstable() -> None:
    """With half of the reactive force at its tail HyperTuna's straight course is none that it would keep."""
    plain = {
        "tail_shedding": 0.5,
        "edge_height_m": 0.0,
        "edge_aspect": 0.0,
        "edge_lift": 1.0,
        "edge_suction": 1.0,
        "drag_beating": [0.0] * 8,
    }
    plain |= {"blunt_area_m2": [0.0] * 8, "added_mass_normal": [1.0] * 8}
    robot = changed(MODELS["hypertuna-strip"], {f"water.strip.{key}": value for key, value in plain.items()})
    gait = ht.Gait.from_degrees(frequency=6, amplitude=(2, 20), phase=(0, 70))
    straight = ht.swim(robot, gait)
    assert straight.status == "unstable"
    assert not straight.settled
    assert straight.spectral_radius > 1
    assert f"grows by {100 * (straight.spectral_radius - 1):.2g} % each beat" in straight.status_text
    # A tiny bias is such a disturbance: the robot ends on a circle, far from anything that the bias itself would do.
    gone = ht.sweep(robot, [replace(gait, bias=(0.0, 1e-6))], method="beats", beats=2000)
    assert abs(float(gone.turn_rate[0])) > 1e3 * 1e-6 * gait.frequency


def test_no_nan_is_settled() -> None:
    """With any coefficients and few steps, settled means finite."""
    robot, gait = MODELS["hypertuna-lumped"], fastest(MODELS["hypertuna-lumped"])
    seen = set()
    for drag in np.logspace(0, 7, 8):
        wild = changed(robot, {"water.lumped.drag": [float(drag)] * len(robot.links.name)})
        found = ht.sweep(wild, [replace(gait, frequency=f) for f in (0.5, 2.0, 6.0)], steps=8)
        good = found.where(found.settled, drop=True)
        assert np.isfinite(good.speed).all()
        assert np.isfinite(good.mechanical_power).all()
        seen |= {STATUSES[k] for k in found.status.values.tolist()}
    assert {"settled", "diverged"} <= seen


# --- turning and backward


def test_a_bend_to_one_side_turns_to_that_side(every_model: ht.Robot) -> None:
    """Joints bent counter-clockwise hold the tail to the right of a robot that swims toward -x: it turns right."""
    to_right, to_left = (ht.swim(every_model, turning(every_model, bias)) for bias in (0.3, -0.3))
    motion = to_right.trajectory
    tail = ((motion.tail_x - motion.x) + 1j * (motion.tail_y - motion.y)) * np.exp(-1j * motion.heading)
    assert float(tail.imag.mean()) > 0
    assert to_right.speed > 0
    assert to_right.turn_rate < 0 < to_left.turn_rate
    assert to_right.turn_rate == pytest.approx(-to_left.turn_rate, rel=1e-4)
    assert to_right.turn_radius == pytest.approx(to_left.turn_radius, rel=1e-4)


def test_without_bias_it_swims_straight(every_model: ht.Robot) -> None:
    swim = ht.swim(every_model, fastest(every_model))
    assert abs(swim.turn_rate) < 1e-7 * swim.gait.frequency
    assert swim.turn_radius == math.inf


def test_a_wave_from_tail_to_head_swims_backward(tuna: ht.Robot) -> None:
    """At 200 degrees joint II is ahead of joint I: the published turning gait swims tail first, to the other side."""
    backward = ht.swim(tuna, named_gait(tuna, "turning"))
    assert backward.settled
    assert backward.speed < 0
    assert float(backward.trajectory.forward_speed.mean()) < 0
    assert backward.turn_rate > 0
    assert backward.cost_of_transport > 0
    assert backward.strouhal > 0
    forward = ht.swim(tuna, replace(backward.gait, phase=(0.0, 0.0)))
    assert forward.speed > 0 > forward.turn_rate


# --- the trajectory


def test_every_variable_has_a_unit_and_a_meaning(tuna: ht.Robot) -> None:
    motion = ht.swim(tuna, fastest(tuna)).trajectory
    assert motion.sizes == {"time": 129, "link": 8, "group": 2}
    for name in (*motion.data_vars, "time"):
        assert motion[name].attrs["units"], name
        assert motion[name].attrs["long_name"], name
    assert motion.attrs["robot"] == tuna.name
    assert motion.attrs["robot_hash"] == tuna.hash
    assert motion.attrs["water"] == "lumped"


def test_the_trajectory_moves_as_its_velocities_say(tuna: ht.Robot) -> None:
    current = (0.3, -0.2)
    swim = ht.swim(tuna, turning(tuna), steps=512, current=current)
    motion = swim.trajectory
    step = float(motion.time[1])
    # Five-point differences err by h^4 / 30 of the fifth derivative where it exists, and by more at the drag's kinks.
    allowed = 1e-6
    velocity = (motion.u + 1j * motion.v) * np.exp(1j * motion.heading) + current[0] + 1j * current[1]
    for path, rate in ((motion.x + 1j * motion.y, velocity), (motion.heading, motion.r)):
        p = path.values
        slope = (p[:-4] - 8 * p[1:-3] + 8 * p[3:-1] - p[4:]) / (12 * step)
        np.testing.assert_allclose(slope, rate.values[2:-2], atol=allowed * float(abs(rate).max()), rtol=0)


def test_a_current_carries_the_trajectory_along_and_changes_nothing_else(every_model: ht.Robot) -> None:
    current = (0.4, -0.7)
    still, carried = (ht.swim(every_model, turning(every_model), current=c) for c in ((0.0, 0.0), current))
    for name in ("speed", "mechanical_power", "turn_rate", "strouhal", "status"):
        assert getattr(carried, name) == getattr(still, name)
    time = still.trajectory.time
    for name, speed in {"x": current[0], "tail_x": current[0], "y": current[1], "tail_y": current[1]}.items():
        np.testing.assert_allclose(carried.trajectory[name], still.trajectory[name] + speed * time, atol=1e-12)
    for name in ("heading", "u", "v", "r", "joint_torque", "mechanical_power", "power_to_water", "energy"):
        np.testing.assert_array_equal(carried.trajectory[name], still.trajectory[name])


def smooth(series: Array) -> Array:
    """A periodic series at 32 times as many instants."""
    return resample(series, 32 * len(series))


def test_the_straight_trajectory_has_the_reported_metrics(every_model: ht.Robot) -> None:
    swim = ht.swim(every_model, fastest(every_model))
    motion, period, length = swim.trajectory, 1 / swim.gait.frequency, every_model.body.length
    way = complex(motion.x[-1] + 1j * motion.y[-1])
    assert float(motion.time[-1]) == pytest.approx(period)
    assert swim.speed == pytest.approx(abs(way) / period)
    assert swim.speed_bl == pytest.approx(swim.speed / length)
    assert swim.stride_length == pytest.approx(abs(way) / length)
    beat = motion.isel(time=slice(-1))  # the last instant is the first of the next beat
    assert swim.mechanical_power == pytest.approx(float(beat.mechanical_power.mean()))
    assert swim.mechanical_power_positive == pytest.approx(
        float(beat.group_mechanical_power.clip(min=0).sum("group").mean())
    )
    assert swim.power_to_water == pytest.approx(float(beat.power_to_water.mean()))
    assert swim.cost_of_transport == pytest.approx(swim.mechanical_power / (every_model.body.mass * swim.speed))
    across = ((beat.tail_x + 1j * beat.tail_y) * np.conj(way) / abs(way)).values.imag
    # the peak is found by a parabola through three of 128 samples, which errs by (2 pi / 128)^4 or so
    excursion = np.ptp(smooth(across))
    assert swim.tail_excursion == pytest.approx(excursion, rel=1e-5)
    assert swim.strouhal == pytest.approx(swim.gait.frequency * excursion / swim.speed, rel=1e-5)


def test_the_turning_trajectory_has_the_reported_metrics(every_model: ht.Robot) -> None:
    swim = ht.swim(every_model, turning(every_model))
    motion = swim.trajectory
    turn = float(motion.heading[-1])
    assert swim.turn_rate == pytest.approx(turn * swim.gait.frequency)
    # The center of the turn stays where it is: end = center + exp(i turn) (start - center).
    end = complex(motion.x[-1] + 1j * motion.y[-1])
    center = end / (1 - np.exp(1j * turn))
    nose = (motion.x + 1j * motion.y).values[:-1]
    assert swim.turn_radius == pytest.approx(abs(nose - center).mean())
    assert swim.speed == pytest.approx(swim.turn_radius * abs(swim.turn_rate))
    distance = abs((motion.tail_x + 1j * motion.tail_y).values[:-1] - center)
    assert swim.tail_excursion == pytest.approx(np.ptp(smooth(distance)), rel=1e-5)


def test_the_body_hangs_together(every_model: ht.Robot) -> None:
    motion = ht.swim(every_model, turning(every_model)).trajectory
    pose = np.stack([motion.x, motion.y, motion.heading], axis=1)
    points = body_points(every_model, pose, motion.joint_angle.values)
    np.testing.assert_allclose(points[:, 0], pose[:, 0] + 1j * pose[:, 1])
    np.testing.assert_allclose(points[:, -1], motion.tail_x + 1j * motion.tail_y)
    lengths = np.abs(np.diff(points, axis=1))
    np.testing.assert_allclose(lengths, np.broadcast_to(every_model.links.length, lengths.shape))


def test_joints_bend_as_the_gait_says(every_model: ht.Robot) -> None:
    robot = every_model.using(joints="ideal")
    gait = turning(robot)
    motion = ht.swim(robot, gait).trajectory
    clock = 2 * np.pi * gait.frequency * motion.time.values[:, None]
    expected = np.array(gait.bias) + np.array(gait.amplitude) * np.sin(clock - np.array(gait.phase))
    np.testing.assert_allclose(motion.bend, expected, atol=1e-13)


def test_netcdf_round_trip(tuna: ht.Robot, tmp_path: Path) -> None:
    motion = ht.swim(tuna, fastest(tuna), current=(0.1, 0.0)).trajectory
    path = write_netcdf(motion, tmp_path / "swim.nc")
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as found:
        same = found.load().rename(elapsed_time="time").set_index(link="link_name", group="group_name")
        xr.testing.assert_equal(same, motion)
        assert motion.attrs.items() <= found.attrs.items()
        assert all(motion[name].attrs == same[name].attrs for name in motion.data_vars)


# --- options and bad input


def test_the_clock_of_all_groups_together_is_arbitrary(tuna: ht.Robot) -> None:
    gait = fastest(tuna)
    assert ht.swim(tuna, later(gait, 0.75)).speed == pytest.approx(ht.swim(tuna, gait).speed, rel=1e-9)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"steps": 0}, "steps must be a multiple of 4 from 8 to 8192, but is 0: take 128."),
        ({"steps": 130}, "steps must be a multiple of 4 from 8 to 8192, but is 130: take 128."),
        (
            {"from_rest": 0.01},
            "from_rest must last between one beat and 10000 beats, but is 0.01 s of 6 Hz: give the seconds to swim.",
        ),
        (
            {"from_rest": math.nan},
            "from_rest must last between one beat and 10000 beats, but is nan s of 6 Hz: give the seconds to swim.",
        ),
        (
            {"current": (math.nan, 0.0)},
            "current must be two finite numbers, but is (nan, 0.0): give m/s along x and y.",
        ),
        (
            {"current": (1.0,)},
            "current must be 2 values, each a number, but is (1.0,) (tuple): write current=(a, b).",
        ),
        (
            {"current": (1.0, 2.0, 3.0)},
            "current must be 2 values, each a number, but is (1.0, 2.0, 3.0) (tuple): write current=(a, b).",
        ),
    ],
)
def test_bad_options_are_told_in_a_sentence(tuna: ht.Robot, options: dict[str, object], sentence: str) -> None:
    with pytest.raises(ht.InputError) as error:
        ht.swim(tuna, fastest(tuna), **options)  # type: ignore[arg-type]
    assert str(error.value) == sentence


def test_a_gait_must_fit_the_robot(tuna: ht.Robot) -> None:
    gait = ht.Gait.from_degrees(frequency=1, amplitude=(10, 10, 10), phase=(0, 0, 0))
    with pytest.raises(ht.InputError) as error:
        ht.swim(tuna, gait)
    assert str(error.value) == (
        "amplitude must be 2 long, one value per joint group of hypertuna (I, II), but is 3 long: "
        "give 2 values for amplitude, phase and bias each."
    )


@pytest.mark.parametrize("gait_of", [fastest, turning])
def test_the_largest_torque_is_that_of_the_trajectory(every_model: ht.Robot, gait_of: Callable[..., ht.Gait]) -> None:
    """The parabola through the highest of 128 samples against the highest of 2048, which is 1e-6 low at most."""
    gait = gait_of(every_model)
    driven = [link for group in every_model.joints for link in group.links]
    torque = ht.swim(every_model, gait, steps=2048).trajectory["joint_torque"].to_numpy()[:, driven]
    assert ht.swim(every_model, gait).torque_peak == pytest.approx(np.abs(torque).max(), rel=3e-4)


def test_the_largest_rate_is_that_of_the_trajectory(every_model: ht.Robot) -> None:
    gait = fastest(every_model)
    swim = ht.swim(every_model, gait)
    rate = swim.trajectory["joint_rate"].to_numpy()
    of_groups = [rate[:, list(group.links)].sum(axis=1) for group in every_model.joints]
    assert swim.rate_peak == pytest.approx(np.abs(of_groups).max(), rel=3e-4)
