"""Damage images of robots and read them in the sanitized core: python validation/hosts/fuzz.py [IMAGES] [SEED].

Of each accepted image a gait settles and twins run in the plane and at sea. `make fuzz-image` builds the program.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import hypertuna as ht
from hypertuna.mission.image import robot_image

TOP = Path(__file__).parents[2]
PROGRAM = TOP / "build/hosts/fuzz_image"  # reader of images, built with sanitizers
ROBOTS = ("hypertuna", "examples/servofish.toml", "rexeel", "examples/minnow.toml")


def main() -> None:
    images = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    seed = sys.argv[2] if len(sys.argv) > 2 else "1"
    with tempfile.TemporaryDirectory() as folder:
        for name in ROBOTS:
            image = Path(folder) / "fish.robot"
            image.write_bytes(robot_image(ht.load(TOP / name if "/" in name else name)))
            print(Path(name).stem, end=": ", flush=True)
            subprocess.run([PROGRAM, image, str(images // len(ROBOTS)), seed], check=True)


if __name__ == "__main__":
    main()
