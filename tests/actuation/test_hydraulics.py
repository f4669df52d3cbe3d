"""Hydraulics: oil, lines and slider-crank against numbers by hand; the size of the pump against its parts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.hydraulics import (
    circuits,
    line_inertance,
    line_loss,
    line_resistance,
    servo_angle,
    supply_voltage,
    viscosity,
    with_bore,
)
from hypertuna.actuation.sizing import Size, largest_beat, size_pump
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.arrays import rounded_number
from hypertuna.description.robot import parse
from hypertuna.errors import InputError

WARM = 293.15


def changed(robot: ht.Robot, **tables: dict[str, object]) -> ht.Robot:
    """Return the robot with other values in the tables named; ``line`` is that of every joint."""
    document = robot.document()
    for name, values in tables.items():
        for table in [group["line"] for group in document["joints"]] if name == "line" else [document[name]]:
            table.update(values)
    return parse(document, file="changed.toml")


def test_viscosity_passes_through_both_points_and_is_134_cst_at_20_degrees(tuna: ht.Robot) -> None:
    assert tuna.oil is not None
    np.testing.assert_allclose(viscosity(tuna.oil, [313.15, 373.15]), [46e-6, 6.8e-6], rtol=1e-12)
    assert float(viscosity(tuna.oil, WARM)) == pytest.approx(134e-6, rel=5e-3)
    # A straight line in Walther's axes: the point halfway in log T is the mean of both ordinates.
    middle = float(viscosity(tuna.oil, np.sqrt(313.15 * 373.15)))
    ordinates = np.log10(np.log10(np.array([46, middle * 1e6, 6.8]) + 0.7))
    assert ordinates[1] == pytest.approx((ordinates[0] + ordinates[2]) / 2, rel=1e-12)


@pytest.mark.parametrize("celsius", [-20.0, 130.0, float("nan")])
def test_oil_has_no_viscosity_outside_its_range(tuna: ht.Robot, celsius: float) -> None:
    with pytest.raises(InputError, match=r"temperature must be from -9 to 100 degC, but is .* degC: L-HM46 flows"):
        circuits(tuna, celsius + 273.15)


def test_lines_by_hand() -> None:
    # 80 mm of 3 mm, 0.1164 Pa s: Poiseuille's mean velocity under 1 bar is d^2 p / (32 mu l) = 3.02 m/s.
    flow = 1e5 / float(line_resistance(0.08, 0.003, 0.1164))
    area = np.pi / 4 * 0.003**2
    assert flow / area == pytest.approx(0.003**2 * 1e5 / (32 * 0.1164 * 0.08), rel=1e-12)
    # The oil in it, a third heavier for its parabolic profile: m dv/dt = area dp.
    mass = 870 * area * 0.08
    assert float(line_inertance(0.08, 0.003, 870)) == pytest.approx(4 / 3 * mass / area**2, rel=1e-12)
    assert float(line_loss(0.003, 1.5, 870)) * flow**2 == pytest.approx(1.5 * 870 / 2 * (flow / area) ** 2, rel=1e-12)


def test_resistance_of_a_circuit_is_that_of_its_line(tuna: ht.Robot) -> None:
    found = circuits(with_bore(tuna, 0.004), WARM)
    assert found.names == ("I-left", "I-right", "II-left", "II-right")
    mu = rounded_number(float(viscosity(tuna.oil, WARM))) * 870.0
    expected = [128 * mu * length / (np.pi * 0.004**4) for length in (0.08, 0.08, 0.20, 0.20)]
    np.testing.assert_allclose(found.column("resistance"), expected, rtol=1e-12)


@given(angle=st.floats(-1.5, 1.5))
def test_inverse_of_the_slider_crank(angle: float) -> None:
    found = circuits(ht.load("hypertuna"))
    volume, slope = _core.displaced(found.values[0], np.array([angle]))[0]
    assert float(servo_angle(found, volume)) == pytest.approx(angle, abs=1e-9)
    assert slope > 0
    assert np.isnan(servo_angle(found, 1e-3))  # beyond the dead center


def run(robot: ht.Robot, target: np.ndarray, joint: int = 0) -> dict[str, np.ndarray]:
    """Run a joint's pair through servo angles held for 10 ms each."""
    model, found = joint_models(robot)[joint], circuits(robot)
    rows = np.ascontiguousarray(found.values[2 * joint : 2 * joint + 2])
    options = {"supply": supply_voltage(robot), "interval": 0.01, "steps": 40}
    return _core.run_pair(rows, model.row, target=np.ascontiguousarray(target), **options)


def test_filled_circuits_rest_at_their_fill_pressure(tuna: ht.Robot) -> None:
    seen = run(tuna, np.zeros((100, 2)))
    np.testing.assert_allclose(seen["bend"], 0, atol=1e-9)
    line = tuna.joints[0].line
    assert line is not None
    for end in ("pump", "unit"):
        np.testing.assert_allclose(seen[f"{end}_pressure"], line.fill_pressure, rtol=1e-6)


def test_left_and_right_are_mirrored(tuna: ht.Robot) -> None:
    wave = 0.2 * np.sin(2 * np.pi * 2 * 0.01 * np.arange(100))
    seen, mirrored = (run(tuna, np.stack([sign * wave, -sign * wave], axis=1)) for sign in (1, -1))
    np.testing.assert_allclose(seen["bend"], -mirrored["bend"], atol=1e-9)
    np.testing.assert_allclose(seen["pump_pressure"], mirrored["pump_pressure"][:, ::-1], atol=1e-2)


def test_stiff_circuits_bend_the_joint_as_commanded(tuna: ht.Robot) -> None:
    stiff = changed(tuna, line={"compliance_m3_pa": 0.0}, oil={"air": 1e-6})
    model, found = joint_models(stiff)[0], circuits(stiff)
    bend = np.radians(10) * (1 - np.cos(np.pi * np.minimum(1, np.arange(300) / 200))) / 2
    volume = model.hold(bend)["volume"] - model.at(0.0)["volume"]
    seen = run(stiff, np.stack([servo_angle(found, volume[:, s]) for s in (0, 1)], axis=1))
    assert np.degrees(seen["bend"][-1]) == pytest.approx(10, rel=2e-3)


def test_shares_of_the_power_add_up(tuna: ht.Robot) -> None:
    wave = 0.3 * np.sin(2 * np.pi * 3 * 0.01 * np.arange(100))
    seen = run(tuna, np.stack([wave, -wave], axis=1))
    shares = [power for name, power in seen.items() if name.startswith("power_")]
    assert len(shares) == 7
    total = sum(shares)
    np.testing.assert_allclose(total, seen["power"], atol=1e-12)
    assert (seen["power"] >= seen["power_idle"] - 1e-12).all()


@pytest.fixture(scope="module")
def sizes() -> list[Size]:
    tuna = ht.load("hypertuna")
    frequency, _ = largest_beat(tuna)
    amplitude = [float(group.bend_max or 0.0) for group in tuna.joints]  # narrow lines pass the pressure limit
    return size_pump(
        tuna, frequency=[frequency], amplitude=amplitude, bore=[0.0025, 0.004], temperature=[WARM, WARM + 15]
    )


def test_size_by_its_parts(tuna: ht.Robot, sizes: list[Size]) -> None:
    assert {(size.joint, size.bore) for size in sizes} == {
        (name, bore) for name in ("I", "II") for bore in (2.5e-3, 4e-3)
    }
    for size in sizes:
        assert size.corner == pytest.approx(1 / (2 * np.pi * size.line_resistance * size.capacity))
        assert size.resonance == pytest.approx(1 / (2 * np.pi * np.sqrt(size.line_inertance * size.capacity)))
        # Quality factor 1 / (2 zeta) of R, L, C in series.
        reactance = np.sqrt(size.line_inertance / size.capacity)
        assert size.damping_ratio == pytest.approx(size.line_resistance / (2 * reactance))
        # The cylinder's air and oil are stiffer than the muscles: the line rings higher with them, and is damped less.
        assert size.ring / size.resonance == pytest.approx(size.damping_ratio / size.ring_damping_ratio)
        assert size.ring > 2 * size.resonance
        total, *shares = size.electrical_power.values()
        assert sum(shares) == pytest.approx(total)
        assert next(iter(size.electrical_power)) == "total"
        for part in ("torque", "servo_speed", "stroke"):  # the margin is to spare, as a part of what is needed
            needed, limit = getattr(size, part), getattr(size, f"{part}_limit")
            assert needed * (1 + getattr(size, f"{part}_margin")) == pytest.approx(limit)
        row = circuits(tuna).row(0)
        slope = _core.displaced(circuits(tuna).values[0], np.linspace(-size.stroke, size.stroke, 101))[:, 1]
        against = working_pressure(tuna) + row["seal"] / row["area"]  # Pa on the piston
        assert against * slope[50] <= size.torque - row["friction"] <= against * slope.max()


def working_pressure(robot: ht.Robot) -> float:
    """The pressure [Pa] that a pump is sized for."""
    assert robot.controller is not None
    return float(robot.controller.pressure_work or math.nan)


def test_pressure_limit_is_kept_and_named(tuna: ht.Robot, sizes: list[Size]) -> None:
    limited = [size for size in sizes if "pressure" in size.limits]
    assert limited
    assert len(limited) < len(sizes)
    for size in sizes:
        assert size.pressure_max <= working_pressure(tuna)
        assert (size.command_fraction < 1) == ("pressure" in size.limits)
        assert size.pressure_min >= -95e3
        assert 0 < size.bend < size.command


def test_warm_oil_and_wide_lines_leave_more_bend(sizes: list[Size]) -> None:
    for joint in ("I", "II"):
        (narrow, narrow_warm), (wide, wide_warm) = np.reshape(
            [size.bend for size in sizes if size.joint == joint], (2, 2)
        )
        assert narrow < min(narrow_warm, wide)
        assert narrow_warm < 1.01 * wide_warm  # warm oil leaves little to win


def test_slow_beats_lose_only_what_gives(tuna: ht.Robot) -> None:
    stiff = changed(tuna, line={"compliance_m3_pa": 0.0}, oil={"air": 1e-6})
    (size, _) = size_pump(stiff, frequency=[0.25], amplitude=np.radians([10, 10]))
    assert size.bend == pytest.approx(size.command, rel=5e-3)
    assert size.limits == ()


@pytest.mark.parametrize(
    ("tables", "key"),
    [
        (("pump",), "pump"),
        (("oil",), "oil"),
        (("servos",), "servos"),
        (("drive_unit",), "drive_unit"),
    ],
)
def test_a_robot_without_a_table_is_told_which(tuna: ht.Robot, tables: tuple[str, ...], key: str) -> None:
    document = {name: table for name, table in tuna.document().items() if name not in tables}
    document["sources"] = {}
    with pytest.raises(InputError, match=rf"tuna.toml: .*{key}.* is missing: add"):
        circuits(parse(document, file="tuna.toml"))


@pytest.mark.parametrize(
    ("table", "values", "sentence"),
    [
        ("oil", {"viscosity_40_m2_s": 1e-6, "viscosity_100_m2_s": 3e-7}, "viscosity_100_m2_s must be more than 3e-07"),
        ("oil", {"cavitation_pa": -102e3}, "cavitation_pa must be more than -101325, a perfect vacuum"),
        (
            "line",
            {"fill_pressure_pa": 1e6},
            r"joints\[0\].line.fill_pressure_pa must be less than .*controller.pressure",
        ),
        (
            "line",
            {"fill_pressure_pa": -95e3},
            r"joints\[0\].line.fill_pressure_pa must be more than oil.cavitation_pa = -95000",
        ),
    ],
)
def test_oil_that_cannot_be_is_refused(tuna: ht.Robot, table: str, values: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        circuits(changed(tuna, **{table: values}))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"bore": [0.0]}, "bore must be greater than 0, but is 0: give the inner diameter of the lines in mm"),
        ({"frequency": [-1.0]}, "frequency must be greater than 0"),
        ({"amplitude": (0.1,)}, "amplitude must be 2 long"),
        ({"amplitude": (1.5, 0.1)}, r"amplitude_deg\[0\] must be at most what pump and joint can do"),
    ],
)
def test_sizes_of_nothing_are_refused(tuna: ht.Robot, options: dict[str, object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        size_pump(tuna, **({"frequency": [1.0], "amplitude": (0.1, 0.1)} | options))  # type: ignore[arg-type]
