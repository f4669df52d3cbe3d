"""Radio logs of a tank run and of a bench test, made without a robot."""

import math
from pathlib import Path

import numpy as np

import hypertuna as ht
from hypertuna.radio.dialect import dialect
from hypertuna.radio.log import RadioLogWriter

START = 1_800_000_000.0  # s since 1970
ROBOT, CAMERA = 1, 200


def message(name: str, source: int, **fields: object) -> object:
    """A message as it comes from the line."""
    made = getattr(dialect(), f"MAVLink_{name.lower()}_message")(**fields)
    made.pack(dialect().MAVLink(None, srcSystem=source))
    return made


def gait_message(gait: ht.Gait, time: float) -> object:
    centi = [[round(math.degrees(value) * 100) for value in row] for row in (gait.amplitude, gait.phase, gait.bias)]
    return message("GAIT", ROBOT, time_boot_ms=round(1000 * time), frequency=round(1000 * gait.frequency),
                   amplitude=centi[0], lag=centi[1], bias=centi[2], fin=[0, 0], state=1)  # fmt: skip


def tank_run(path: Path, robot: ht.Robot, gaits: list[ht.Gait]) -> None:
    """Each gait for 20 s: it gathers speed in 2 s, and swims at the model's own then; a camera sees it to 3 mm."""
    random, x, clock = np.random.default_rng(1), 0.0, 0.0
    with RadioLogWriter(path, robot.name) as log:
        for gait in gaits:
            speed = ht.swim(robot, gait).speed
            for k in range(400):
                x += 0.05 * speed * (1 - math.exp(-k * 0.05 / 2))
                clock += 0.05
                if k % 40 == 0:
                    log.write(gait_message(gait, clock), START + clock + 0.1 * random.uniform())
                place = np.array([0.8 * x, 0.6 * x]) + 3e-3 * random.standard_normal(2)
                pose = message("ATT_POS_MOCAP", CAMERA, time_usec=0, q=[1, 0, 0, 0], x=place[0], y=place[1], z=0.3)
                log.write(pose, START + clock)


def bench_test(path: Path, robot: ht.Robot) -> None:
    """Up to 200 kPa and down again at 10 kPa/s, each side of joint I."""
    with RadioLogWriter(path, robot.name) as log:
        for side in (0, 1):
            for k in range(401):
                own = 10e3 * (20 - abs(k * 0.1 - 20))
                pressure, bend = [0, 0, 0, 0], [0, 0]
                pressure[side], bend[0] = round(own / 100), round((1 - 2 * side) * own / 1e4 * 100)
                time = 50 * side + k * 0.1
                log.write(message("HYDRAULICS", ROBOT, time_boot_ms=round(1000 * time), condition=0, bend=bend,
                                  pressure=pressure, current=[0] * 4), START + time)  # fmt: skip
