"""The check before a swim, and the key: on the bench, by the commands."""

import json
from pathlib import Path

import pytest

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")

from program import Run
from radio_bench import free_port, running


def test_a_sound_robot_may_be_armed(run: Run) -> None:
    port = free_port()
    with running(port):
        code, told, errors = run("radio", "check", "--connect", f"udp:{port}", "--json")
    assert code == 0, errors
    found = json.loads(told)
    assert (found["ready"], found["reasons"]) == (True, [])
    assert found["battery_v"] == pytest.approx(15, abs=0.1)
    assert found["depth_m"] == pytest.approx(0, abs=0.02)  # a robot that boots at the surface takes its zero there


def test_a_robot_without_battery_says_why(run: Run, tmp_path: Path) -> None:
    """The readings of a robot whose battery is at 12.5 V: low, which forbids arming; exit code 1."""
    port, readings = free_port(), tmp_path / "readings"
    readings.write_text("0 0 9.81 0 0 0 -0.6 0 -0.8 12.5 0.05")
    with running(port, readings):
        from hypertuna.radio.client import connect

        with connect(f"udp:{port}") as robot:
            robot.wait(lambda m: m.get_type() == "PILOT" and m.fault >> 6 & 1, 30)
        code, told, errors = run("radio", "check", "--connect", f"udp:{port}", "--json")
        found = json.loads(told)
        assert (code, found["ready"]) == (1, False), errors
        assert {"name": "low_battery", "sentence": "the battery is low", "forbids_arming": True} in found["faults"]
        assert found["reasons"] != []
        code, told, _ = run("radio", "check", "--connect", f"udp:{port}")
        assert (code, "may not be armed" in told) == (1, True)


def test_a_key_is_given_changed_and_deleted(run: Run, tmp_path: Path) -> None:
    port = free_port()
    place = ("--connect", f"udp:{port}")
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_bytes(bytes(range(32)))
    new.write_bytes(bytes(range(1, 33)))
    with running(port):
        code, told, errors = run("radio", "sign", str(old), *place, "--json")
        assert (code, json.loads(told)["signed"] if told else None) == (0, True), errors
        code, _, errors = run("radio", "params", *place, "--set", "link_rate=115200")
        assert (code, "error" in errors) == (2, True)
        code, _, errors = run("radio", "sign", str(new), *place, "--key", str(new))
        assert (code, "must" in errors) == (2, True), errors
        code, _, errors = run("radio", "sign", str(new), *place, "--key", str(old))
        assert code == 0, errors
        code, _, errors = run("radio", "params", *place, "--key", str(new), "--set", "link_rate=115200")
        assert code == 0, errors
        code, told, errors = run("radio", "sign", "--off", *place, "--key", str(new))
        assert (code, "has no key" in told) == (0, True), errors
        assert run("radio", "params", *place, "--set", "link_rate=9600")[0] == 0


def test_a_key_is_a_file_of_32_bytes(run: Run, tmp_path: Path) -> None:
    short, zeros = tmp_path / "short", tmp_path / "zeros"
    short.write_bytes(bytes(31))
    place = ("--connect", f"udp:{free_port()}")
    for options, wanted in (
        ((str(short),), "must have 32 bytes, but is 31 bytes long"),
        ((str(tmp_path / "none"),), "must be a file, but is missing"),
        ((), "FILE or --off must be given"),
        ((str(zeros), "--off"), "FILE or --off must be given"),
    ):
        code, _, errors = run("radio", "sign", *options, *place)
        assert (code, wanted in errors) == (2, True), errors
