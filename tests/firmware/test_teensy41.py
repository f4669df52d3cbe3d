"""The project of the board teensy41: every path in it exists, and its sources compile with its flags.

`make firmware-teensy` compiles and links it with the real core; the stand-in for that is in firmware/tests/boards.
"""

import re
import shlex
import shutil
import subprocess
from configparser import ConfigParser
from itertools import pairwise
from pathlib import Path

import pytest

from hypertuna.description.schema.firmware import PULSE_PINS

ROOT = Path(__file__).resolve().parents[2]
PROJECT = ROOT / "firmware/boards/teensy41"


def _project() -> tuple[list[Path], list[str]]:
    """Return the sources and the flags of platformio.ini."""
    settings = ConfigParser()
    settings.read(PROJECT / "platformio.ini")
    names = re.findall(r"\+<([^>]*)>", settings["env:teensy41"]["build_src_filter"])
    return [PROJECT / settings["platformio"]["src_dir"] / name for name in names], shlex.split(
        settings["env:teensy41"]["build_flags"]
    )


def test_paths_of_the_project_exist() -> None:
    sources, flags = _project()
    assert {source.name for source in sources} == {"main.cpp", "controller.cpp", "radio.cpp"}
    for source in sources:
        assert source.is_file()
    folders = [folder for flag, folder in pairwise(flags) if flag in {"-I", "-isystem"}]
    for folder in folders:
        assert (PROJECT / folder).is_dir() or folder.startswith("../../../build/")
    assert len(folders) == 3


def test_sources_of_the_project_compile_with_its_flags() -> None:
    sources, flags = _project()
    if not (ROOT / "build/firmware/pc/firmware/mavlink/include").is_dir():
        pytest.skip("the MAVLink headers are missing: make firmware-pc")
    compiler = shutil.which("g++") or shutil.which("c++") or "c++"
    stand_in = ["-I", str(ROOT / "firmware/tests/boards/arduino")]
    for source in sources:
        command = [compiler, "-c", "-o", "/dev/null", *flags, *stand_in, str(source.relative_to(PROJECT))]
        ran = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True)
        assert ran.returncode == 0, ran.stderr


def test_sizes_are_those_of_the_docs() -> None:
    image = ROOT / "build/firmware/hypertuna-teensy41.elf"
    if not image.is_file() or shutil.which("arm-none-eabi-size") is None:
        pytest.skip("the image is missing: make firmware-teensy")
    printed = subprocess.run(["arm-none-eabi-size", image], capture_output=True, text=True, check=True).stdout
    page = (ROOT / "docs/firmware.md").read_text()
    told = re.search(r"(\d+) kB of text, (\d+) kB of data and (\d+) kB of zeroed memory", page)
    assert told is not None
    assert [int(size) / 1024 for size in printed.split()[6:9]] == pytest.approx(
        [float(k) for k in told.groups()], rel=0.05
    )


def test_pins_with_pulses_are_the_same_in_the_description_and_on_the_board() -> None:
    text = (PROJECT / "servos.hpp").read_text()
    body = re.search(r"has_pulses\(int pin\) \{\s*return (.*?);", text, re.DOTALL)
    assert body is not None
    rule = body[1].replace("||", "or").replace("&&", "and")
    assert tuple(pin for pin in range(56) if eval(" ".join(rule.split()), {"pin": pin})) == PULSE_PINS
