"""What a new quantity, loss, MAVLink message or kind of joint costs: how many files name one that is there."""

import re
import subprocess
from functools import cache
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.sizing import size_pump

TOP = Path(__file__).parents[1]
WHERE = ("src", "core/include", "core/src", "bindings", "hosts", "firmware/app", "firmware/mavlink", "studio", "robots")
NOT = ("studio/tests/", "studio/interface.ts")  # tests, and what is generated
# Asks which kind a joint is of, or names one.
KIND = (
    r"\.(?:servo|tendons|actuator) is (?:not )?None|\"servo\" (?:not )?in\b|\bactuation (?:[!=]=|in)|\"tendons\""
    r"|(?:[!=]=|is|in) (?:AXLE|DRUM|MUSCLES)\b|\.hinge\b|\bdirect\b|\bhasOil\b"
)


@cache
def sources() -> dict[str, str]:
    """Return the tracked sources that people write, with one robot: a key has a default."""
    listed = subprocess.run(["git", "ls-files", *WHERE], cwd=TOP, capture_output=True, text=True, check=True)
    written = (".py", "pp", ".ts", ".xml", "robots/hypertuna.toml")
    names = [name for name in listed.stdout.split() if name.endswith(written) and not name.startswith(NOT)]
    return {name: (TOP / name).read_text() for name in names}


def naming(pattern: str, *under: str) -> list[str]:
    """Return the sources in some folders that have a pattern."""
    return [name for name, text in sources().items() if name.startswith(under or "") and re.search(pattern, text)]


@pytest.mark.parametrize(
    ("quantity", "most"),
    [
        ("(?:mechanical_)?power_positive", 4),  # of the beat: beat.hpp, quantities.hpp, swim.py; and a hinge's moment
        ("rate_peak|largest_rate", 3),  # of the gait: gait.hpp, quantities.hpp, swim.py
        ("torque_peak", 4),  # and a limit of optimizations
    ],
)
def test_a_quantity_is_named_by_few_files(quantity: str, most: int) -> None:
    files = naming(rf"\b(?:{quantity})\b")
    assert len(files) in range(2, most + 1), files


@pytest.mark.parametrize(
    ("loss", "most"),
    [
        ("braking", 2),  # of a servo, from numbers that are there
        ("windings", 3),  # and an example in a docstring
        # Of the pump, with a key that the core calls otherwise, and that `hypertuna pump` adds to the torque.
        (r"seals?|seal_friction(?:_n)?", 7),
    ],
)
def test_a_loss_is_named_by_few_files(loss: str, most: int) -> None:
    files = naming(rf"\b(?:{loss})\b")
    assert len(files) in range(2, most + 1), files


def test_what_a_servo_draws_is_lost_under_the_same_names_or_reaches_the_oil(tuna: ht.Robot) -> None:
    lost = {name for name, place, _ in _core.loss_table() if place == "servos"}
    size = size_pump(tuna, frequency=[2.0], amplitude=[0.1] * len(tuna.joints))[0]
    assert {*size.electrical_power} == lost | {"total", "hydraulic"}


@pytest.mark.parametrize(
    ("message", "firmware", "ground"),
    [
        ("hydraulics", ["firmware/app/radio/messages.hpp", "firmware/mavlink/hypertuna.xml"], 3),  # sent
        ("gait_set", ["firmware/app/radio/commands.hpp", "firmware/mavlink/hypertuna.xml"], 1),  # accepted
        ("mission_set_current", ["firmware/app/radio/commands.hpp"], 0),  # of the standard dialect
        ("timesync", ["firmware/app/radio/dispatch.hpp"], 0),  # from anybody
    ],
)
def test_a_message_is_in_the_dialect_and_in_one_file_of_the_firmware(
    message: str, firmware: list[str], ground: int
) -> None:
    pattern = rf"\b(?:mavlink_)?(?i:{message})(?:_t)?\b"
    assert naming(pattern, "firmware") == firmware
    assert len(naming(rf"\b{message}\b|\b{message.upper()}\b", "src/hypertuna/radio", "src/hypertuna/trials")) <= ground


def test_few_files_ask_which_kind_a_joint_is_of() -> None:
    """The others ask what its drive has (`JointGroup.drive`), and what passive hinges there are (`Robot.hinges`)."""
    files = naming(KIND)
    assert len(files) in range(10, 21), files
