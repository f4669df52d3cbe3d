"""The wiring is that of [firmware] in the robot's file, of the board's source, and of resistors that can be bought."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from drawn import apart
from hypertuna.description.channels import ANALOG
from hypertuna.description.robot import load
from hypertuna.firmware.parameters import firmware_table
from hypertuna.firmware.plots import LEFT, RIGHT, plot_wiring
from hypertuna.firmware.wiring import E24, I2C_RATE, IMU_BAUD, RECEIVER_BAUD, SUPPLY, wiring_of
from program import Run

TEENSY = Path(__file__).parents[2] / "firmware/boards/teensy41"


@pytest.fixture(scope="module")
def wiring():
    return wiring_of(ht.load("hypertuna"))


def test_every_pin_of_the_file_is_wired_once(wiring) -> None:
    firmware = ht.load("hypertuna").firmware
    at = {wire.pin: wire for wire in wiring.wires}
    assert len(at) == len(wiring.wires)
    assert [at[pin].signal for pin in firmware.servo_pins] == [f"servo_{k}" for k in range(6)]
    assert at[firmware.servo_pins[1]].part == "servo of joint I, right"
    assert [at[pin].signal for pin in firmware.pressure_pins] == [f"pressure_{k}" for k in range(4)]
    assert at[firmware.pressure_pins[2]].part == "XGZP6858A, joint II, left"
    assert at[firmware.voltage_pin].signal == "voltage"
    assert at[firmware.leak_pin].part == "leak probe"
    assert (at[7].bus, at[7].rate, at[7].to) == ("Serial2", firmware.radio_baud, "board")


def test_signals_are_names_of_the_calibration(wiring) -> None:
    """What the table calls a signal, `radio calibrate --sensor` calls a sensor or servo."""
    from hypertuna.radio.calibration import parse_sensor, zero_and_scale

    names = {p.name for p in firmware_table(wiring.robot).parameters}
    assert {"analog", "pulses"} <= {wire.bus for wire in wiring.wires}
    for wire in wiring.wires:
        if wire.bus == "analog":
            assert set(zero_and_scale(wire.signal)) <= names
        if wire.bus == "pulses":
            assert f"servo_trim_{parse_sensor(wire.signal)[1]}" in names


def test_levels_are_those_of_the_calibration(wiring) -> None:
    """The volts at the ends of a range are counts whose readings are the ends."""
    table = firmware_table(wiring.robot)
    for name, factor in (("bend", 180 / np.pi), ("pressure", 1e-3), ("current", 1), ("voltage", 1)):
        wire = next(wire for wire in wiring.wires if wire.signal.startswith(name))
        for volts, value in zip(wire.level.split(" to "), wire.range.split(" to "), strict=True):
            counts = 65536 * float(volts.split()[0]) / SUPPLY
            read = table.column(f"{name}_scale")[0] * (counts - table.column(f"{name}_zero")[0]) * factor
            assert read == pytest.approx(float(value.split()[0]), rel=1e-3)


def test_divider_keeps_the_battery_below_the_board_s_supply(wiring) -> None:
    """Kirchhoff at the pin; 0 V lifts it above an open wire, and the end of the range stays below 3.3 V."""
    divider = wiring.divider
    for battery in (0.0, 12.0, 16.8, 20.0):
        v = divider.volts(battery)
        assert (battery - v) / divider.upper + (SUPPLY - v) / divider.lift == pytest.approx(v / divider.lower)
    assert divider.volts(0) == pytest.approx(0.1 * SUPPLY, rel=0.06)
    assert divider.volts(20) == pytest.approx(0.9 * SUPPLY, rel=0.06)
    for ohm in divider:
        assert ohm / 10 ** np.floor(np.log10(ohm) - 1) in [pytest.approx(step) for step in E24]
    scale = 20 / (65536 * (divider.volts(20) - divider.volts(0)) / SUPPLY)
    standard = next(p for p in firmware_table(wiring.robot).parameters if p.name == "voltage_scale")
    assert standard.low < scale < standard.high


def test_rates_are_those_of_the_board_s_source() -> None:
    source = " ".join(path.read_text() for path in TEENSY.glob("*.hpp")).replace("'", "")
    for rate in (IMU_BAUD, RECEIVER_BAUD, I2C_RATE):
        assert re.search(rf"\b{rate}\b", source), rate


def test_figure_has_every_wire(wiring) -> None:
    assert len(LEFT) == len(RIGHT) == 24
    assert sorted(int(name) for name in (*LEFT, *RIGHT) if name.isdigit()) == list(range(42))
    texts = {text.get_text() for text in plot_wiring(wiring).axes[0].texts}
    for wire in wiring.wires:
        assert any(wire.part in text and wire.signal in text for text in texts), wire


def test_a_robot_without_oil_has_its_own_wiring(tmp_path: Path, run: Run) -> None:
    """A robot of `robot new --sea` with servos on its axles: no pressure sensors, a servo per joint and two fins."""
    file = str(tmp_path / "fish.toml")
    assert (
        run("robot", "new", file, "--links", "3", "--length", "0.32", "--mass", "0.9", "--actuation", "servo", "--sea")[
            0
        ]
        == 0
    )
    code, told, errors = run("firmware", "wiring", "--robot", file, "--json")
    assert code == 0, errors
    wires = json.loads(told)["wires"]
    robot = load(file)
    assert sum(wire["bus"] == "pulses" for wire in wires) == len(robot.joints) + 2
    assert "on the axle of joint" in next(wire["part"] for wire in wires if wire["signal"] == "servo_0")
    assert not any(wire["signal"].startswith("pressure") for wire in wires)
    plot_wiring(wiring_of(robot))


def test_all_texts_of_the_figure_are_inside_and_none_is_over_another(wiring) -> None:
    figure = plot_wiring(wiring)
    figure.canvas.draw()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    width, height = figure.bbox.size
    assert all(0 <= box.x0 < box.x1 <= width and 0 <= box.y0 < box.y1 <= height for box in boxes)
    assert apart(boxes)


def test_command(tmp_path: Path, run: Run) -> None:
    table, figure = tmp_path / "wiring.csv", tmp_path / "wiring.svg"
    code, told, errors = run("firmware", "wiring", "-o", str(table), "--plot", str(figure))
    assert code == 0, errors
    assert "100 kohm from the battery" in told
    assert f"written: {figure}" in told
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert len(rows) == len(wiring_of(ht.load("hypertuna")).wires)
    assert rows[0]["rate_bit_s"] == "115200"
    code, _, errors = run("firmware", "wiring", "--robot", "rexeel")
    assert (code, "joints must be at most 4 groups for the firmware" in errors) == (2, True)


def test_analog_signals_have_units() -> None:
    from hypertuna.firmware.wiring import UNITS

    assert set(UNITS) == set(ANALOG)
