"""The twin: repeats itself, converges, is symmetrical, closes the loop, and says what limits it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.simulation.cards import hinge_rows
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twin, twins

ROBOT = ht.load("hypertuna")
LONG = parse(new_robot("eel", links=15, length=0.9))
SPRINGS = [{"link": link, "stiffness_n_m_per_rad": 0.5} for link in (11, 12)]
SUPPLE = parse(new_robot("eel", links=13, length=0.9) | {"hinges": SPRINGS})
SMALL = ht.Gait.from_degrees(frequency=2, amplitude=(6, 9), phase=(0, 30))


def command(frequency: float, amplitude: tuple[float, float], bias: tuple[float, float] = (0, 0)) -> ht.Gait:
    return ht.Gait.from_degrees(frequency=frequency, amplitude=amplitude, phase=(0, 30), bias=bias)


@cache
def small_run() -> TwinRun:
    return twin(ROBOT, SMALL, duration=10, start="swimming")


def changed(table: str, **values: Any) -> ht.Robot:
    """The robot with values of one table replaced, keys as in the file."""
    document = ROBOT.document()
    return parse(document | {table: document.get(table, {}) | values}, file=ROBOT.file)


def noiseless() -> ht.Robot:
    """The robot with sensors that tell the truth."""
    document = ROBOT.document()
    errors = ("noise", "resolution", "drift", "bias", "nonlinearity")
    sensors = [{key: value for key, value in s.items() if key not in errors} for s in document["sensors"]]
    return parse(document | {"sensors": sensors}, file=ROBOT.file)


def test_a_stiffer_plant_gets_the_steps_that_it_needs() -> None:
    document = ROBOT.document()
    document["oil"]["air"] = 0.0
    for group in document["joints"]:
        group["line"]["compliance_m3_pa"] = 0.0
    stiff, gait = parse(document), ht.Gait.from_degrees(frequency=3, amplitude=(8, 12), phase=(0, 20))
    run = twin(stiff, gait, duration=0.5)
    fine = twin(stiff, gait, duration=0.5, step=run.step / 1.5)
    coarse = twin(stiff, gait, duration=0.5, step=1 / 3000)  # the step of the shipped robot
    assert run.step < coarse.step == small_run().step
    assert run.pressure_peak == pytest.approx(fine.pressure_peak, rel=5e-3)
    assert run.swing == pytest.approx(fine.swing, rel=1e-3)
    assert coarse.pressure_peak > 1.1 * fine.pressure_peak, "it rings, and nothing else tells"


def test_a_robot_that_does_not_move_has_no_cost_of_transport() -> None:
    document = ht.load("examples/servofish.toml").document()
    document["controller"]["smoothing_s"] = 1e5  # the tail has not begun to beat
    run = twin(parse(document), "cruise", duration=1)
    assert run.speed == 0
    assert run.cost_of_transport == np.inf


def test_areas_beyond_measure_give_a_run_that_diverged() -> None:
    document = ROBOT.document()
    document["links"]["lateral_area_m2"][-1] = 1e12
    run = twin(parse(document), SMALL, duration=0.5)
    assert (run.status, len(run.time)) == ("diverged", 1)  # it breaks at once: the start alone is shown
    assert run.summary()
    assert "diverged" in run._repr_html_()


def test_a_hinge_that_hardly_gives_is_a_stiff_plant_too() -> None:
    robot = changed("hinge", link=7, stiffness_n_m_per_rad=5000.0, damping_n_m_s_per_rad=1.0)
    run = twin(robot, SMALL, duration=0.3)
    assert run.status == "completed"
    assert np.ptp(run.data["hinge_angle"]) < 1e-3


def test_a_seed_repeats_to_the_last_bit_whoever_runs_it() -> None:
    options = [{"robot": ROBOT, "gait": SMALL, "duration": 1.0, "seed": seed} for seed in (0, 1, 0)]
    runs = twins(options, measure=lambda run: run, threads=2)
    for name in runs[0].data:
        assert (runs[0].data[name] == runs[2].data[name]).all(), name
    assert (runs[0].data["angle_measured"] != runs[1].data["angle_measured"]).any()
    alone = twins(options[:1], measure=lambda run: run.data["angle"])
    assert (alone[0] == runs[0].data["angle"]).all()


@pytest.mark.parametrize("threads", [0, -3])
def test_twins_need_a_thread(threads: int) -> None:
    with pytest.raises(ht.InputError, match=f"threads must be at least 1, but is {threads}"):
        twins([], measure=lambda run: run, threads=threads)


SPRUNG = {
    "link": 7,
    "stiffness_n_m_per_rad": 0.5,
    "rest_deg": 1.0,
    "cubic_n_m_per_rad3": 5.0,
    "stop_deg": 3.0,
    "stop_stiffness_n_m_per_rad": 20.0,
    "stop_dissipation_n_m_s_per_rad2": 5.0,
}


def test_runs_side_by_side_have_the_bits_that_they_have_alone() -> None:
    """Laws, hinges, servos, air, faults, other numbers, other lengths, and one that diverges among its neighbors."""
    wild = ROBOT.document()
    wild["links"]["lateral_area_m2"][-1] = 1e12
    hinged = changed("hinge", link=7, stiffness_n_m_per_rad=0.5, damping_n_m_s_per_rad=0.002)
    robots = [ROBOT, parse(wild), other_lines(compliance_m3_pa=4e-12), ROBOT.using(water="strip"), hinged]
    robots.append(changed("hinge", **SPRUNG))
    two = [{"link": link, "stiffness_n_m_per_rad": 0.7, "damping_n_m_s_per_rad": 0.002} for link in (6, 7)]
    robots.append(parse(ROBOT.document() | {"hinges": two}))
    fast = ht.named_gait(ROBOT, "unoptimised-max")
    runs = [
        {"robot": robot, "gait": gait, "duration": duration, "seed": seed, "medium": medium, "faults": faults}
        for robot in robots
        for gait, seed, duration in ((SMALL, 1, 0.5), (fast, 2, 0.5), (fast, 3, 0.4))
        for medium, faults in (("water", "bend-II:stuck@0.2"), ("air", ()))
        if robot is not robots[1] or medium == "water"
    ]
    runs += [
        {"robot": "examples/servofish.toml", "gait": "cruise", "duration": 0.5, "seed": seed} for seed in (1, 2, 3)
    ]
    together = twins(runs, measure=lambda run: run, threads=2)
    assert {run.status for run in together} == {"completed", "diverged"}
    for options, run in zip(runs, together, strict=True):
        alone = twin(**options)
        assert run.status == alone.status
        for name, values in alone.data.items():
            np.testing.assert_array_equal(run.data[name], values, err_msg=name)


def other_lines(**values: float) -> ht.Robot:
    """The robot with values of both its oil lines replaced."""
    document = ROBOT.document()
    return parse(document | {"joints": [j | {"line": j["line"] | values} for j in document["joints"]]}, file=ROBOT.file)


def test_posture_control_reaches_what_the_pumps_alone_miss() -> None:
    """Hoses that give five times as much as the controller believes cost degrees, until it learns."""
    soft = other_lines(compliance_m3_pa=1e-11)
    closed, alone = (
        twin(soft, SMALL, duration=12, start="swimming", controller_robot=ROBOT, closed_loop=c) for c in (True, False)
    )
    assert abs(closed.change_per_beat) < 0.02
    assert closed.status == "completed"
    error, missed = (abs(np.degrees(run.swing) - (6, 9)).max() for run in (closed, alone))
    assert 10 * error < 2 < missed


def test_joint_two_lags_by_the_phase_of_the_gait() -> None:
    """Both joints come later than commanded; their difference is near the phase, as they lag alike."""
    run = small_run()
    assert np.degrees(run.phase[1] - run.phase[0]) == pytest.approx(30, abs=15)
    assert 0 < np.degrees(run.phase[0]) < 90


def test_straight_gait_swims_straight() -> None:
    run = small_run()
    assert abs(np.degrees(run.bias)).max() < 0.5
    assert 0.05 < run.speed < 0.5
    assert run.speed_bl == pytest.approx(run.speed / 0.52)
    assert run.cost_of_transport == pytest.approx(run.electrical_power / (3.3 * run.speed))
    assert 0 < run.mechanical_power < run.electrical_power


def test_mirrored_gait_is_the_mirror_image() -> None:
    """Without noise a gait half a beat later is the same motion with left and right exchanged."""
    robot = noiseless()
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(6, 9), phase=(0, 30), bias=(2, -1))
    mirror = ht.Gait.from_degrees(frequency=2, amplitude=(6, 9), phase=(0, 30), bias=(-2, 1))
    a, b = (twin(robot, g, duration=10, start="swimming") for g in (gait, mirror))
    assert a.speed == pytest.approx(b.speed, rel=3e-3)
    assert a.bias == pytest.approx(-b.bias, abs=np.radians(0.05))
    assert a.pressure_max[[0, 2]] == pytest.approx(b.pressure_max[[1, 3]], rel=0.01)


@pytest.mark.parametrize("gait", [SMALL, ROBOT.gaits["unoptimised-0.4"], ROBOT.gaits["unoptimised-max"]])
def test_half_the_step_changes_nothing_above_a_thousandth(gait: Any) -> None:
    """Servos told where to go: with the controller, noise of sensors would decide when a limit acts."""
    named = ht.Gait(gait.frequency, gait.amplitude, gait.phase)
    commanded = twin(noiseless(), named, duration=2, closed_loop=False)
    coarse, fine = (driven(commanded.data["servo_target"], steps) for steps in (30, 60))
    last = slice(100, None)
    for name in ("angle", "pump_pressure", "unit_pressure", "servo_angle", "surge"):
        a, b = coarse[name][last], fine[name][last]
        assert abs(a - b).max() < 1e-3 * np.ptp(b), name
    for name in ("pump_pressure_high", "unit_pressure_high"):
        assert coarse[name][last].max() == pytest.approx(fine[name][last].max(), rel=1.5e-3), name


def driven(target: Any, steps: int) -> dict[str, Any]:
    """The plant alone, its servos told where to go."""
    from hypertuna.simulation.plant import parts_of

    parts = parts_of(ROBOT, "water", None)
    return _core.simulate(
        parts.plant, np.ascontiguousarray(target), _core.World({}), twist=np.zeros(6), tick=0.01, steps=steps
    )


def test_in_air_the_head_stays_and_the_joints_bend_easier() -> None:
    gait = ht.Gait.from_degrees(frequency=4, amplitude=(8, 15), phase=(0, 0))
    air, water = (twin(ROBOT, gait, duration=4, medium=medium) for medium in ("air", "water"))
    assert np.isnan(air.speed)
    assert np.isnan(air.cost_of_transport)
    assert not air.data["x"].any()
    assert not air.data["yaw"].any()
    assert air.pressure_max[2:].max() < 0.8 * water.pressure_max[2:].max()


def test_cold_oil_needs_more_pressure() -> None:
    gait = ht.Gait.from_degrees(frequency=3, amplitude=(10, 15), phase=(0, 0))
    warm, cold = (twin(ROBOT, gait, duration=4, temperature=t + 273.15) for t in (35, 5))
    assert cold.pressure_max.max() > 1.05 * warm.pressure_max.max()


def test_without_commands_the_tail_comes_to_rest() -> None:
    run = twin(ROBOT, SMALL, duration=6, command_lost_at=3.0)
    angle = np.degrees(abs(run.data["angle"]))
    assert angle[:300].max() > 4
    assert angle[-50:].max() < 0.5
    assert any("no command" in sentence.lower() for sentence in run.sentences)


def test_a_stuck_sensor_is_told_and_the_tail_beats_on() -> None:
    run = twin(ROBOT, SMALL, duration=8, faults="bend-II:stuck@4", start="swimming")
    assert run.faults == ("bend_fault",)
    assert any("bend sensor" in sentence and "(II)" in sentence for sentence in run.sentences)
    assert np.degrees(run.swing) == pytest.approx((6, 9), abs=2.0)


def test_a_hinge_rests_at_its_angle_and_hits_its_stops() -> None:
    """It starts and rests at the angle of its spring; a beat stops where the stops stand, and loses power there."""
    still = ht.Gait(1.0, (0.0, 0.0), (0.0, 0.0))
    run = twin(changed("hinge", **SPRUNG), still, duration=1.0)
    assert run.data["hinge_angle"][0] == math.radians(1.0)
    np.testing.assert_allclose(run.data["hinge_angle"], math.radians(1.0), atol=1e-4)
    soft = {"link": 7, "stiffness_n_m_per_rad": 0.15}
    stops = {name: value for name, value in SPRUNG.items() if name.startswith("stop")}
    free, stopped = (twin(changed("hinge", **keys), SMALL, duration=3) for keys in (soft, soft | stops))
    assert np.degrees(abs(stopped.data["hinge_angle"]).max()) < 3.5
    assert np.degrees(abs(free.data["hinge_angle"]).max()) > 10
    damped = twin(changed("hinge", **soft, damping_n_m_s_per_rad=2e-3), SMALL, duration=3)
    lost = [{loss.name: loss.power for loss in run.losses.losses}["hinge"] for run in (free, damped)]
    assert abs(lost[0]) < 1e-2 * lost[1]  # a spring gives back what it takes
    assert lost[1] == pytest.approx((2e-3 * damped.data["hinge_rate"][damped.beats] ** 2).mean(), rel=0.05)
    (still,), (swung,), (held,) = run.bends, free.bends, stopped.bends
    assert (still["bend_peak"], still["in_stops"]) == (pytest.approx(math.radians(1.0), abs=1e-4), 0)
    assert swung["in_stops"] == 0 < held["in_stops"] < 1
    assert swung["bend_peak"] == pytest.approx(abs(free.data["hinge_angle"][free.beats]).max(), rel=1e-2)
    settled = ht.swim(changed("hinge", **soft), SMALL).bends[0]
    assert swung["bend_amplitude"] == pytest.approx(settled.bend_amplitude, rel=0.2)  # swings err
    assert swung["bend_lag"] == pytest.approx(settled.bend_lag, abs=0.2)
    assert f"{100 * held['in_stops']:.0f} %" in stopped._repr_html_()
    (row,) = hinge_rows(free)
    assert row["name"] == "L7"
    assert row["bend_peak_deg"] == math.degrees(swung["bend_peak"])


def test_hinge_softens_the_fin() -> None:
    """A stiff hinge is none; a soft one bends, and changes how the robot swims."""
    stiff, soft = (
        twin(changed("hinge", link=7, stiffness_n_m_per_rad=k, damping_n_m_s_per_rad=0.002), SMALL, duration=5)
        for k in (50.0, 0.3)
    )
    plain = twin(ROBOT, SMALL, duration=5)
    assert stiff.speed == pytest.approx(plain.speed, rel=0.02)
    assert np.degrees(np.ptp(soft.data["hinge_angle"])) > 5 > np.degrees(np.ptp(stiff.data["hinge_angle"]))
    assert abs(soft.speed / plain.speed - 1) > 0.05


def test_several_hinges_bend_in_series() -> None:
    """One that hardly gives before another is none; soft ones both bend, and datasets name the links behind them."""

    def with_hinges(*stiffness: float) -> ht.Robot:
        tables = [
            {"link": link, "stiffness_n_m_per_rad": k, "damping_n_m_s_per_rad": 0.002}
            for link, k in zip((6, 7), stiffness, strict=True)
        ]
        return parse(ROBOT.document() | {"hinges": tables}, file=ROBOT.file)

    one = changed("hinge", link=7, stiffness_n_m_per_rad=0.3, damping_n_m_s_per_rad=0.002)
    alone, stiff, soft = (twin(robot, SMALL, duration=5) for robot in (one, with_hinges(50, 0.3), with_hinges(1, 0.3)))
    assert stiff.speed == pytest.approx(alone.speed, rel=0.02)
    assert np.ptp(stiff.data["hinge_angle"][:, 1]) == pytest.approx(np.ptp(alone.data["hinge_angle"]), rel=0.05)
    assert np.degrees(np.ptp(soft.data["hinge_angle"], axis=0)).min() > 5
    bends = soft.dataset().hinge_angle
    assert bends.hinge.values.tolist() == [ROBOT.links.name[link] for link in (6, 7)]
    spring = -np.array([1, 0.3]) * soft.data["hinge_angle"] - 0.002 * soft.data["hinge_rate"]
    np.testing.assert_allclose(soft.data["hinge_moment"], spring, rtol=1e-9, atol=1e-12)
    assert "hinge_angle" not in twin(ROBOT, SMALL, duration=0.1).dataset()


def test_believing_in_another_robot_shows() -> None:
    """A controller that takes the lines for wider than they are pumps the same volumes, and sees other pressures."""
    narrow = other_lines(bore_m=0.003)
    knows, believes = (twin(narrow, SMALL, duration=4, controller_robot=robot) for robot in (None, ROBOT))
    assert (knows.data["servo_target"] != believes.data["servo_target"]).any()
    assert believes.pressure_max.max() > small_run().pressure_max.max()


def test_a_step_too_long_ends_in_a_sentence_and_not_in_nan() -> None:
    run = twin(ROBOT, ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 0)), duration=3, step=0.01)
    assert run.status == "diverged"
    assert "diverged after" in run.sentences[0]
    assert len(run.time) < 300
    assert all(np.isfinite(values).all() for values in run.data.values())


def test_a_short_run_says_that_it_is_too_short_to_tell() -> None:
    little = ht.Gait.from_degrees(frequency=2, amplitude=(2, 3), phase=(0, 30))
    first, *conditions = twin(changed("controller", voltage_low_v=20.0), little, duration=0.4).sentences
    assert first == "The run is too short to tell whether it is settled."
    assert conditions == ["The battery voltage is low: 100 % of the ticks."]


def test_oil_that_cavitates_is_told_as_a_limit() -> None:
    """The plant holds a cavitating cylinder at the cavitation pressure itself, here in a quarter of the last ticks."""
    run, vacuum = small_run(), -95e3  # Pa, of HyperTuna's oil
    assert "cavitation" not in run.limits
    low = run.data["pump_pressure_low"].copy()
    low[-(run.beats.stop - run.beats.start) // 4 :, 1] = vacuum
    dry = replace(run, data=run.data | {"pump_pressure_low": low})
    assert dry.acting["cavitation"] == pytest.approx(0.25, abs=0.01)
    assert dry.limits == (*run.limits, "cavitation")
    assert dry.sentences[-1] == "The oil cavitated in a cylinder: 25 % of the last beats' ticks."


def test_dataset_has_units_and_the_flags_their_names() -> None:
    data = small_run().dataset()
    assert data.sizes == {"time": 1000, "joint": 2, "circuit": 4, "drive": 4, "servo": 6}
    assert list(data["circuit"].values) == ["I-left", "I-right", "II-left", "II-right"]
    assert all(data[name].attrs["units"] for name in data)
    assert data["status"].attrs["flag_meanings"].split()[0] == "bend_fault"
    assert data.attrs["frequency_hz"] == 2


def test_a_command_at_the_controllers_bounds_is_taken() -> None:
    bend = np.degrees([group.bend_max for group in ROBOT.joints])  # and back again to radians
    widest = command(ROBOT.controller.frequency_max, tuple(bend), tuple(-bend))  # type: ignore[union-attr]
    run = twin(ROBOT, widest, duration=0.1)
    names = [name for name, _, _ in _core.condition_table()]
    assert not run.flags >> names.index("bad_command") & 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"medium": "milk"}, "medium must be water or air, but is 'milk'"),
        ({"start": "resting"}, "did you mean rest?"),
        ({"duration": 0.0}, "duration must be from 0.01 to"),
        ({"duration": float("nan")}, "duration must be a finite number"),
        ({"step": 0.02}, "step must be from 1e-06 to the control tick of 0.01 s"),
        ({"faults": "bend-II:stuck@50"}, "must start before the run ends at 2 s"),
        ({"faults": "bend-III:stuck@1"}, "did you mean bend-II?"),
        ({"faults": "depth:nan@1"}, "fault must be of a sensor that is read in this run, but is 'depth:nan@1'"),
        ({"seed": -1}, "seed must be from 0"),
        ({"seed": 1.5}, "seed must be a whole number, but is 1.5"),
        ({"duration": "3"}, "duration must be a number, but is '3' (str)"),
        ({"temperature": "cold"}, "temperature must be a number, but is 'cold' (str)"),
        ({"command_lost_at": float("nan")}, "command_lost_at must be a finite number, but is nan"),
        ({"step": True}, "step must be a number, but is True (bool)"),
        ({"faults": [3]}, "faults must be text or a list of them, but is [3] (list)"),
        ({"robot": changed("hinge", link=7, stiffness_n_m_per_rad=1e12)}, "hinge.stiffness_n_m_per_rad must not be so"),
        ({"gait": command(9, (6, 9))}, "frequency must be at most 8 Hz, the controller.frequency_max_hz of hypertuna"),
        ({"gait": command(2, (6, 40))}, "amplitude[1] must be at most 31.2 deg, the bend_max_deg of joint II"),
        (
            {"gait": command(2, (6, 9), (-19, 0))},
            "bias[0] must be at most 18.2 deg, the bend_max_deg of joint I, but is",
        ),
        ({"gait": ht.Gait(1.0, (0.1,), (0.0,))}, "amplitude must be 2 long"),
        ({"robot": LONG, "gait": ht.Gait(1.0, (0.1,) * 14, (0.0,) * 14)}, "joints must be at most 12 groups"),
        ({"robot": SUPPLE, "gait": ht.Gait(1.0, (0.1,) * 12, (0.0,) * 12)}, "hinges must be at most 1 in the twin"),
        ({"robot": ht.load("rexeel"), "gait": ht.Gait(1.0, (0.1,) * 5, (0.0,) * 5)}, "controller is missing"),
    ],
)
def test_bad_options_are_told(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ht.InputError) as told:
        twin(**{"robot": ROBOT, "gait": SMALL, "duration": 2.0} | options)
    assert message in str(told.value)
