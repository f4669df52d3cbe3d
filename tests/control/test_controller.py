"""The controller from a robot's description: volume maps, limits, status, and that it beats."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.hydraulics import circuits
from hypertuna.actuation.new import first_robot
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.control.controller import _water_load, controller_columns, pump_map
from hypertuna.description.changes import changed
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.swimming.model import core_model

# Pa, limits of HyperTuna's controller that its gaits reach.
LOW_LIMITS = {"work": 200e3, "soft": 250e3, "hard": 300e3}
PAGE = Path(__file__).parents[2] / "docs" / "control.md"


@pytest.fixture(scope="module")
def robot() -> ht.Robot:
    return ht.load("hypertuna")


@pytest.fixture(scope="module")
def columns(robot: ht.Robot) -> dict[str, list[float]]:
    return controller_columns(robot)


def test_the_volume_map_fits(robot: ht.Robot) -> None:
    """The map errs by a twentieth of its travel at most, less than a degree of the servo, and not at all at rest."""
    found = circuits(robot)
    for c in range(4):
        fit = pump_map(robot, found, c)
        angles = fit.angle(np.linspace(-1.2, 1.2, 201) * float(robot.joints[c // 2].bend_max or 0.0))
        travel = np.ptp(_core.displaced(found.values[c], angles)[:, 0])
        assert fit.residual_volume < 0.05 * travel
        assert fit.residual_volume < np.radians(1) * _core.displaced(found.values[c], np.zeros(1))[0, 1]
        assert fit.residual_angle < np.radians(1)
        assert fit.angle(np.zeros(1)) == 0
        assert fit.angle([fit.low - 1e-9, fit.high + 1e-9]) == pytest.approx(fit.angle([fit.low, fit.high]), abs=1e-8)


def test_the_map_pushes_out_what_the_units_take(robot: ht.Robot) -> None:
    """Beyond the joint's volume the pump fills what pressure makes of air and hoses: more, but not twice as much."""
    found = circuits(robot)
    for j, model in enumerate(joint_models(robot)):
        bend = np.array([0.0, 0.5 * float(robot.joints[j].bend_max or 0.0)])
        angle = pump_map(robot, found, 2 * j).angle(bend)
        pushed = np.diff(_core.displaced(found.values[2 * j], angle)[:, 0])[0]
        taken = np.diff(model.hold(bend)["volume"][:, 0])[0]
        assert taken < pushed < 2 * taken


def test_the_joint_with_a_blind_circuit_beats_less_the_faster(robot: ht.Robot) -> None:
    """Its model alone keeps the working pressure: a lower one, with the limits above it, leaves less."""
    low = {f"controller.pressure_{name}_pa": pressure for name, pressure in LOW_LIMITS.items()}
    before = [math.inf, math.inf]
    for limited in (robot, changed(robot, low)):
        columns = controller_columns(limited)
        for j in range(2):
            safe = [
                1 / (columns["safe_static"][j] + f * columns["safe_rate"][j] + f * f * columns["safe_square"][j])
                for f in (1, 3, 6)
            ]
            assert before[j] > safe[0] > safe[1] > safe[2] > 0
            assert columns["amplitude"][j] > safe[1]
            before[j] = min(safe[0], columns["amplitude"][j])


def test_constants_by_hand(robot: ht.Robot, columns: dict[str, list[float]]) -> None:
    """Rates of robots/hypertuna.toml per tick of 10 ms, ranges of its sensors, and the choices of docs/control.md."""
    smoothing = 4.7439 * 0.01 / 0.3  # (1 + x) e^-x = 0.05 at x = 4.7439
    expected = {
        "joints": 2, "tick": 0.01, "relax": math.exp(-0.2), "couple": math.exp(-0.1), "timeout": 50, "slew": 15.0,
        "smoothing_rate": smoothing, "smoothing_decay": math.exp(-smoothing),
        "missing": 0.25, "limited": 0.1, "moving": 0.05, "amplitude_min": math.radians(3),
        "pressure_low": -100e3, "pressure_high": 1e6, "current_low": -5, "current_high": 5,
        "rate_high": 34.9, "acceleration_high": 157, "voltage_min": 0, "voltage_max": 20,
        "pressure_work": 440e3, "pressure_soft": 550e3, "pressure_hard": 660e3, "pressure_step": 440e3,
    }  # fmt: skip
    assert {name: columns[name] for name in expected} == {name: [pytest.approx(x)] for name, x in expected.items()}


def test_the_load_of_the_water_is_that_of_a_whole_beat(robot: ht.Robot) -> None:
    """Both joints beat in phase at their largest bends, ten times as many instants of the beat."""
    amplitude, zero, clock = (
        [group.bend_max or 0.0 for group in robot.joints],
        [0.0, 0.0],
        np.linspace(0, 2 * math.pi, 641),
    )
    model = core_model(robot, {"joints.bandwidth": [math.inf] * 2})
    motion = _core.joint_motion(model, frequency=2.0, amplitude=amplitude, phase=zero, bias=zero, clock=clock)
    torque = _core.dynamics(model, motion, np.zeros((641, 3)))["torque"]
    largest = [abs(torque[:, list(group.links)] @ np.array(group.share)).max() for group in robot.joints]
    np.testing.assert_allclose(_water_load(robot, 2.0), largest, rtol=5e-3)


def test_a_robot_without_oil_has_no_pressures() -> None:
    columns = controller_columns(parse(tomllib.loads(first_robot("eel", joints=["J1", "J2"], actuation="servo"))))
    names = [name for name in columns if name.startswith("pressure_") and len(columns[name]) == 1]
    assert {"pressure_work", "pressure_soft", "pressure_hard", "pressure_step", "pressure_low"} <= set(names)
    assert {name: columns[name] for name in names} == {name: [0.0] for name in names}


def test_the_oil_of_a_circuit_gives_by_hand(robot: ht.Robot, columns: dict[str, list[float]]) -> None:
    """A servo turns by what hose, oil and its air give per pressure, over the volume per angle where it is largest."""
    for circuit in range(4):
        at = circuits(robot).row(circuit)
        turn = np.linspace(-0.5, 0.5, 51)
        volume = _core.displaced(circuits(robot).values[circuit], turn)[:, 0]
        slope = np.diff(volume).max() / (turn[1] - turn[0])
        air = at["air"] * 101325 / (101325 + 550e3) ** 2
        gives = at["compliance"] + (at["oil_pump"] + at["oil_unit"]) * (1 / at["bulk_modulus"] + air)
        assert columns["compliance"][circuit] == pytest.approx(gives / slope, rel=1e-3)
        assert columns["servo_stall"][circuit] == pytest.approx(at["stall_torque"] / slope, rel=1e-3)


def test_a_robot_without_pump_is_told_what_it_lacks() -> None:
    with pytest.raises(InputError, match="controller"):
        controller_columns(parse(new_robot("fish")))


@pytest.mark.parametrize("fill", [0.0, -2e4])
def test_circuits_without_pressure_have_no_map(fill: float) -> None:
    slack = changed(ht.load("hypertuna"), {"joints.I.line.fill_pressure_pa": fill})
    rule = r"joints\[0\]\.line\.fill_pressure_pa must keep both sides of the straight joint under pressure, but is"
    with pytest.raises(InputError, match=rule):
        controller_columns(slack)


def test_pulses_start_in_the_middle_and_follow_the_command(columns: dict[str, list[float]]) -> None:
    pilot = _core.LiveController(columns)
    calm = {"bend": [0.0, 0.0], "pressure": columns["fill"], "current": [0.3] * 4, "rate": [0.0] * 3}
    calm |= {"acceleration": [0.0, 0.0, 9.8], "voltage": [15.0]}
    command = {"frequency": [2.0], "amplitude": [0.2, 0.3], "phase": [0.0, 0.5], "fin": [0.3, -0.3]}
    first = pilot.step(calm, command)
    assert np.allclose(first["pulse"], columns["pulse_center"][0], atol=20e-6)
    for _ in range(300):
        last = pilot.step(calm, command)
    assert np.allclose(last["target"][4:], [0.3, -0.3], atol=1e-6)
    assert np.ptp([pilot.step(calm, command)["set"][1] for _ in range(50)]) == pytest.approx(0.6, rel=0.01)


def test_the_page_has_every_condition() -> None:
    rows = [f"| `{name}` | {place} | {sentence} |" for name, place, sentence in _core.condition_table()]
    text = PAGE.read_text()
    assert [row for row in rows if row not in text] == []
