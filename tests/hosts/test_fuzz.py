"""Damaged images never stop the reader, a swim or a twin, under sanitizers. The long run: validation/hosts."""

import subprocess
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.mission.image import robot_image

PROGRAM = Path(__file__).parents[2] / "build/hosts/fuzz_image"


@pytest.mark.parametrize("name", ["examples/servofish.toml", "examples/minnow.toml"])
def test_damaged_images_never_crash(name: str, tmp_path: Path) -> None:
    if not PROGRAM.is_file():
        pytest.skip("the program that damages images is not built: run `make fuzz-image`")
    image = tmp_path / "fish.robot"
    image.write_bytes(robot_image(ht.load(name)))
    run = subprocess.run([PROGRAM, image, "30", "2"], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert " 0 refused without a sentence" in run.stdout
    assert 5 < int(run.stdout.split(" read")[0].split()[-1]) < 30
