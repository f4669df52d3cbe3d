"""The same twenty seconds everywhere: in Python alone and in lanes, by the C interface, in WebAssembly, as FMUs, and in
the environment for learning.
"""

from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from host_library import InNode, Native, Robot, Twin
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.mission.image import robot_image
from hypertuna.simulation.plant import controller_of, parts_of

ROBOT = ht.load("hypertuna")
SEED, SECONDS, TICK = 3, 20, 0.01
TICKS = round(SECONDS / TICK)
ACTION = np.array([-0.5, 0.1, 0.3, -0.4, 0.5, 0.5])  # of the environment: every host gets the gait that it means
SAME = 1e-9  # m and rad


def gait_of_action() -> ht.Gait:
    from hypertuna.learning.spans import span_of

    frequency, amplitude, phase, bias = (part[0].tolist() for part in span_of(ROBOT).gait(ACTION[np.newaxis]))
    return ht.Gait(frequency, tuple(amplitude), tuple(phase), tuple(bias))


GAIT = gait_of_action()


@pytest.fixture(scope="module")
def path() -> Array:
    """x, y [m] and heading [rad] at every tick, by `ht.twin`."""
    run = ht.twin(ROBOT, GAIT, duration=SECONDS + TICK, seed=SEED)
    path = np.stack([run.data[name] for name in ("x", "y", "heading")], axis=1)
    assert len(path) == TICKS + 1
    assert np.hypot(*path[-1, :2]) > 2  # m
    assert abs(path[-1, 2]) > 0.5
    return path


def test_in_lanes(path: Array) -> None:
    options = {"robot": ROBOT, "gait": GAIT, "duration": SECONDS + TICK}
    runs = ht.twins([options | {"seed": seed} for seed in (1, SEED, 2)], measure=lambda run: run.data)
    for k, name in enumerate(("x", "y", "heading")):
        np.testing.assert_array_equal(runs[1][name], path[:, k])


@pytest.mark.parametrize("host", [Native, InNode], ids=["C", "WebAssembly"])
def test_by_the_c_interface(host: type, path: Array) -> None:
    made = host()
    robot = Robot.read(robot_image(ROBOT), made)
    assert isinstance(robot, Robot)
    twin = Twin(robot, seed=SEED)
    twin.command(GAIT)
    for tick, ticks in ((500, 501), (1000, 500), (TICKS, TICKS - 1000)):
        last = twin.advance(ticks)
        at = [float(last[name][0]) for name in ("x", "y", "heading")]
        np.testing.assert_allclose(at, path[tick], atol=SAME, rtol=0)
    del twin, robot
    made.close()


@pytest.mark.parametrize("fmi", [2, 3])
def test_as_an_fmu(fmi: int, path: Array, tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy")
    file = tmp_path / "fish.fmu"
    file.write_bytes(ht.fmu(ROBOT, fmi=fmi))
    angles = {"amplitude": GAIT.amplitude, "phase": GAIT.phase, "bias": GAIT.bias}
    given = {
        f"{name}_{joint}": value for name, row in angles.items() for joint, value in zip(("I", "II"), row, strict=True)
    }
    start = given | {"seed": SEED, "frequency": GAIT.frequency, "armed": True}
    options = {"stop_time": SECONDS, "step_size": TICK, "output_interval": TICK, "output": ["x", "y", "heading"]}
    rows = fmpy.simulate_fmu(str(file), start_values=start, **options)
    assert len(rows) == TICKS + 1
    np.testing.assert_allclose(
        np.stack([rows[name] for name in ("x", "y", "heading")], axis=1), path, atol=SAME, rtol=0
    )


def test_in_the_environment(path: Array) -> None:
    pytest.importorskip("gymnasium")
    from hypertuna.learning.environments import SwimmerVectorEnv
    from hypertuna.learning.tasks import Swim

    env = SwimmerVectorEnv(2, Swim(seconds=2 * SECONDS))
    env.reset(seed=1)
    swimmers, parts = env.swimmers, parts_of(ROBOT, "water", None)
    swimmers._batch.restart(
        1, (parts.plant, _core.LiveController(controller_of(ROBOT)), _core.Sensors(parts.sensors, SEED), 0.0)
    )
    for k in range(1, TICKS // 10 + 1):
        env.step(np.tile(ACTION, (2, 1)))
        heading = swimmers.seen.heading[1] - np.pi
        at = [*swimmers.seen.position[1] * ROBOT.body.length, heading]
        np.testing.assert_allclose(at, path[10 * k], atol=SAME, rtol=0)
