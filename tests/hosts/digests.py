"""Print a digest of all that must be the same on every processor, of the robots named: image, firmware, twin, mission.

`BLAS` and `NumPy` are what differs between processors: where neither does, the comparison shows nothing.
"""

import contextlib
import hashlib
import json
import sys

import numpy as np

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.firmware.header import header
from hypertuna.firmware.parameters import firmware_table
from hypertuna.mission.image import robot_image
from hypertuna.mission.run import fly_part, mission_start

SECONDS = 4


def digest(*arrays: np.ndarray) -> str:
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()[:16]


def digests(name: str) -> dict[str, str]:
    """Return the digests of a robot, of what it has."""
    robot = ht.load(name)
    found = {"image": hashlib.sha256(robot_image(robot)).hexdigest()[:16]}
    with contextlib.suppress(InputError):
        found["firmware"] = digest(np.frombuffer(header(firmware_table(robot)).encode(), np.uint8))
    if robot.controller is not None:
        gait = ht.Gait(1.0, (0.15,) * len(robot.joints), tuple(0.5 * j for j in range(len(robot.joints))))
        found["twin"] = digest(*ht.twin(robot, gait, duration=SECONDS, seed=3).data.values())
    if robot.guidance is not None:
        start = mission_start(robot, ht.read_mission("box").mission, seed=1)
        found["mission"] = digest(*fly_part(start, 100 * SECONDS, None)[0].values())
    return found


if __name__ == "__main__":
    matrix = np.random.default_rng(0).normal(size=(60, 60))
    machine = {"BLAS": digest(np.linalg.solve(matrix, matrix[0])), "NumPy": digest(np.arccos(np.linspace(-1, 1, 1001)))}
    print(json.dumps({"machine": machine, **{name: digests(name) for name in sys.argv[1:]}}))
