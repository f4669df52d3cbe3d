"""What the firmware is made with is what the robot's description says."""

import dataclasses
import json
import lzma
import re
import shlex
import tomllib
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.new import first_robot
from hypertuna.control.controller import controller_columns, sensor_range
from hypertuna.control.guidance import pilot_columns
from hypertuna.description.channels import CHANNELS, COUNTED
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.firmware.header import TEXTS, File, header, metadata
from hypertuna.firmware.lockstep import NO_SAMPLE, Counts
from hypertuna.firmware.parameters import NAME_LENGTH_MAX, firmware_table
from program import Run

FIRMWARE = Path(__file__).parents[2] / "firmware"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?f?")


@pytest.fixture(scope="module")
def table():
    return firmware_table(ht.load("hypertuna"))


BYTES = re.compile(r"inline constexpr std::uint8_t file_(\d)\[\] = \{(.*?)\};", re.DOTALL)


def test_parameters_describe_themselves(table) -> None:
    """Every parameter has text, unit and range; the compressed file in the header says the same."""
    general, packed = metadata(table)
    entries = json.loads(lzma.decompress(packed.content))["parameters"]
    assert [entry["name"].lower() for entry in entries] == [p.name for p in table.parameters]
    assert all(entry["min"] <= entry["default"] <= entry["max"] and len(entry["shortDesc"]) > 8 for entry in entries)
    units = {entry["name"]: entry.get("units") for entry in entries}
    assert (units["FIN_MAX"], units["PULSE_CENTER"], units["LOOKAHEAD"]) == ("rad", "s", "m")
    assert json.loads(general.content)["metadataTypes"][0]["fileCrc"] == packed.crc
    assert File("", b"123456789").crc == 0x2DFD2D88  # CRC-32 from zero, not inverted
    committed = dict(BYTES.findall((FIRMWARE / "robots" / "hypertuna.hpp").read_text()))
    content = bytes(int(byte) for byte in re.findall(r"\d+", committed["1"]))
    assert json.loads(lzma.decompress(content))["parameters"] == entries
    assert (
        File("", content).crc
        == json.loads(bytes(map(int, re.findall(r"\d+", committed["0"]))))["metadataTypes"][0]["fileCrc"]
    )


def test_committed_header_is_what_the_description_makes(table) -> None:
    # Another machine may compress the metadata differently: they are compared above.
    files = re.compile(rf"{BYTES.pattern}|inline constexpr FileInfo.*?\}};", re.DOTALL)
    committed, made = (
        files.sub("", text) for text in ((FIRMWARE / "robots" / "hypertuna.hpp").read_text(), header(table))
    )
    # Another machine's linear algebra may round the last bit of a fit differently.
    assert NUMBER.sub("#", committed) == NUMBER.sub("#", made), "run `hypertuna firmware params -o ...` anew"
    found, wanted = ([float(n.rstrip("f")) for n in NUMBER.findall(text)] for text in (committed, made))
    np.testing.assert_allclose(found, wanted, rtol=3e-7, atol=1e-12)


def test_page_counts_the_numbers_and_parameters(table) -> None:
    page = " ".join((FIRMWARE.parent / "docs" / "firmware.md").read_text().split())
    assert f"| `hypertuna` | 2 | {len(table.fields)} | {len(table.parameters)} |" in page


def test_every_number_is_the_columns(table) -> None:
    robot = table.robot
    columns = {"controller": controller_columns(robot), "pilot": pilot_columns(robot)}
    for (part, name, k), value in zip(table.fields, table.values, strict=True):
        if part in columns:
            assert value == np.float32(columns[part][name][k])
    assert len(set(table.fields)) == len(table.fields)


def test_fields_are_the_firmware_s_in_its_order(table) -> None:
    """The limits are listed in Python too: in the order of the C++ header. The calibration has the core's channels."""
    sources = (FIRMWARE / "app" / "vehicle" / "parameters.hpp").read_text()
    limits = re.findall(r'visit\("(\w+)", 0, m\.\w+\)', sources)
    assert [name for part, name, _ in table.fields if part == "limits"] == limits
    pairs = [(f"{name}_zero", f"{name}_scale") for name in COUNTED]
    calibration = dict.fromkeys(name for part, name, _ in table.fields if part == "calibration")
    assert list(calibration) == [name for pair in pairs for name in pair] + ["servo_trim"]


def test_parameters_of_as_many_joint_groups_as_a_board_takes_fit_the_memory() -> None:
    robot = parse(tomllib.loads(first_robot("fish", links=_core.BOARD_JOINTS + 1, actuation="servo", sea=True)))
    assert len(firmware_table(robot).parameters) == 123 <= _core.MAX_PARAMETERS


def test_parameters_fit_mavlink(table) -> None:
    names = [p.name for p in table.parameters]
    assert len(set(names)) == len(names)
    assert max(map(len, names)) <= NAME_LENGTH_MAX
    for p in table.parameters:
        assert p.low <= p.standard <= p.high
        assert p.standard == table.values[p.field]


def test_a_parameter_that_is_a_key_has_its_value_in_the_unit_of_its_text(table) -> None:
    """What is another number than the key says so in a text of its own: a sine, ticks."""
    parts = {"controller": table.robot.controller, "pilot": table.robot.guidance, "limits": table.robot.firmware}
    seen = 0
    for p in table.parameters:
        part, column, _ = table.fields[p.field]
        if part in parts and p.name not in TEXTS and column not in TEXTS:
            assert p.standard == pytest.approx(getattr(parts[part], column), rel=1e-6), p.name
            seen += 1
    assert seen > 30


def test_limits_can_only_be_made_tighter(table) -> None:
    at = {p.name: p for p in table.parameters}
    for name in (
        "pressure_work",
        "pressure_soft",
        "pressure_hard",
        "frequency_max",
        "slew",
        "pulse_max",
        "amplitude_0",
        "tilt_max",
    ):
        assert at[name].high == at[name].standard, name
    for name in ("pulse_min", "voltage_low", "voltage_empty"):
        assert at[name].low == at[name].standard, name


def test_layout_tells_other_parameters_apart(table) -> None:
    fewer = dataclasses.replace(table, parameters=table.parameters[:-1])
    assert fewer.layout != table.layout


def test_counts_are_the_inverse_of_the_calibration(table) -> None:
    counts = Counts(table, (0, 0))
    wanted = {"bend": 0.2, "pressure": 80e3, "current": 1.5, "rate": -0.3, "acceleration": 9.0, "voltage": 15.0}
    wanted |= {"depth": 1.25, "field": 0.4}
    readings = np.array([wanted[name] for name in counts.names])
    samples = counts.of(readings)[counts.channels]
    assert (abs(counts.scale * (samples - counts.zero) - readings) <= 0.5001 * counts.scale).all()


def test_open_wire_of_an_analog_sensor_reads_zero_counts(table) -> None:
    """The twin's open sensor shows an eighth of its range below the live zero: no volts at the converter."""
    counts = Counts(table, (0, 0))
    readings = np.zeros(len(counts.names))
    pressure = counts.names.index("pressure")
    low, high = sensor_range(ht.load("hypertuna"), "pressure")
    readings[pressure] = low - (high - low) / 8
    assert counts.of(readings)[CHANNELS["bend"].count(_core.BOARD_JOINTS)] == 0
    readings[pressure] = np.nan
    assert counts.of(readings)[CHANNELS["bend"].count(_core.BOARD_JOINTS)] == NO_SAMPLE


def test_a_robot_of_too_many_joint_groups_gets_the_command_that_writes_another(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, told = run("firmware", "params", "--robot", "rexeel")
    assert code == 2
    assert "joints must be at most 4 groups for the firmware, but is 5" in told
    assert run(*shlex.split(told.split("`")[1])[1:])[0] == 0
    assert run("firmware", "params", "--robot", "rexeel-sea.toml")[0] == 0


def test_pins_have_one_use(table) -> None:
    document = table.robot.document()
    wrong = document["firmware"] | {"leak_pin": 26}
    with pytest.raises(InputError, match="pin 26"):
        parse(document | {"firmware": wrong})
    with pytest.raises(InputError, match=r"firmware\.servo_pins"):
        parse(document | {"firmware": document["firmware"] | {"servo_pins": [2, 3]}})


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"leak_pin": 99}, "leak_pin must be from 0 to 41, but is 99"),
        ({"servo_pins": [2, 3, 4, 5, 6, 30]}, "servo_pins must have pulses by hardware: 0 to 15, 18, .*, but is 30"),
        ({"recovery_pin": 28}, "recovery_pin must leave pin 28 to leak_pin"),
        ({"bend_pins": [14, 30]}, "bend_pins must be one of 14 to 27 or 38 to 41, but is 30"),
        ({"leak_pin": 18}, "leak_pin must leave pin 18 to the depth sensor"),
        ({"leak_pin": 0}, "leak_pin must leave pin 0 to imu_serial"),
        ({"imu_serial": 2}, "radio_serial must leave pin 7 to imu_serial"),
        ({"imu_serial": 9}, "imu_serial must be from 1 to 8, but is 9"),
    ],
)
def test_pins_and_ports_are_those_of_the_board(table, wrong: dict, told: str) -> None:
    document = table.robot.document()
    with pytest.raises(InputError, match=told):
        parse(document | {"firmware": document["firmware"] | wrong})


def test_firmware_changes_no_hash(table) -> None:
    document = table.robot.document()
    assert parse(document | {"firmware": document["firmware"] | {"system_id": 7}}).hash == table.robot.hash


def test_commands(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "hypertuna.hpp"
    code, told, _ = run("firmware", "params", "--robot", "hypertuna", "-o", str(path))
    assert code == 0
    assert "written" in told
    assert run("firmware", "params", "--robot", "hypertuna", "--check", str(path))[0] == 0
    path.write_text(path.read_text().replace("0.01f", "0.02f"))
    assert run("firmware", "params", "--robot", "hypertuna", "--check", str(path))[0] == 1
    path.write_bytes(path.read_bytes() + b"\xff")
    code, _, told = run("firmware", "params", "--robot", "hypertuna", "--check", str(path))
    assert (code, "must be readable" in told) == (2, True)
    code, told, _ = run("firmware", "faults", "--json")
    assert code == 0
    assert "water in the hull" in told
