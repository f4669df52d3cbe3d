"""FMUs of the twin at sea with `steered`: the robot's own pilot holds the depth and the heading that are commanded."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from fmu_unit import TICK, Unit
from hypertuna.arrays import Array
from hypertuna.control.guidance import gait_table
from hypertuna.control.mission import Mission, Waypoint
from hypertuna.description.robot import parse
from hypertuna.mission.run import fly_parts, joined_parts, mission_start

ROBOT = ht.load("hypertuna")
TABLE = gait_table(ROBOT)
GAIT, SPEED = TABLE.gaits[0], TABLE.speed[0]
BEAT = {"frequency": GAIT.frequency, "armed": True} | {
    f"{kind}_{name}": value
    for kind in ("amplitude", "phase")
    for name, value in zip(("I", "II"), getattr(GAIT, kind), strict=True)
}
HELD = ("depth", "heading")


@pytest.fixture(scope="module", params=[2, 3])
def file(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(ROBOT, tmp_path_factory.mktemp("fmu"), fmi=request.param)


def written(robot: ht.Robot, folder: Path, **options: Any) -> Path:
    """Write the FMU of a robot at sea."""
    path = folder / "fish.fmu"
    path.write_bytes(ht.fmu(robot, sea=True, **options))
    return path


def swim(unit: Unit, seconds: float) -> Array:
    """Depth and heading at the ends of steps of 0.1 s, (n, 2); the heading goes on beyond a turn."""
    rows = []
    for _ in range(round(seconds / 0.1)):
        unit.step(0.1)
        rows.append(unit.get(*HELD))
    return np.array(rows) * [1, 0] + np.unwrap(np.array(rows), axis=0) * [0, 1]


def test_it_swims_as_on_the_leg_of_a_mission(file: Path) -> None:
    """From the surface, facing north: to the east and down to 3 m, with the same noise of the sensors.

    Waypoint and lookahead are so far away that the leg is a heading, and the pilot waits for no fix. Measured: 1e-13 m.
    """
    changed = {"lookahead": 1e101, "fix_timeout": TICK}
    guidance = ROBOT.guidance.model_copy(update=changed) if ROBOT.guidance else None
    always = ((0.0, 1e6),)
    east = Mission((Waypoint(1e100, 0, 3, SPEED, 2),), heading=-math.pi / 2, gaps=always, home_speed=SPEED)
    start = mission_start(ROBOT.model_copy(update={"guidance": guidance}), east, seed=3, every=1, duration=40)
    run = joined_parts(start, [part for _, part in fly_parts(start)])
    command = {"steered": True, "depth_command": 3.0, "heading_command": math.pi / 2}
    unit = Unit(file, **BEAT, **command, start_depth=0.0, seed=3)
    path = []
    for _ in run.time:
        path.append(unit.get("position_east", "position_north", "position_up", "fin_target_port", "angle_set_I"))
        unit.step()
    unit.close()
    np.testing.assert_allclose(np.array(path)[:, :3], run.data["position"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.array(path)[1:, 3], run.data["fin_target"][:-1, 0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.array(path)[1:, 4], run.data["angle_set"][:-1, 0], rtol=0, atol=1e-9)
    assert path[-1][0] > 8
    assert path[-1][2] < -2.5


@pytest.mark.parametrize("seed", [1, 2])
def test_it_reaches_depth_and_heading(file: Path, seed: int) -> None:
    """In a current. Within 10 cm, as missions are: the offset of the depth sensor and the overshoot. Within 6 degrees,
    the offset of the compass, as a mean over the swing of the beat.
    """
    current = {"current_east": 0.08, "current_north": -0.05}
    unit = Unit(file, **BEAT, **current, start_speed=0.2, seed=seed, steered=True)
    for depth, heading in ((2.0, 0.0), (3.0, math.radians(70)), (1.0, math.radians(-50))):
        unit.set(depth_command=depth, heading_command=heading)
        held = swim(unit, 50)[-50:]
        assert np.abs(held[:, 0] - depth).max() < 0.1
        off = math.remainder(held[:, 1].mean() - heading, 2 * math.pi)
        assert abs(math.degrees(off)) < 6
    unit.close()


def test_it_believes_its_sensors(tmp_path: Path) -> None:
    """A depth sensor with a large offset is believed: the robot is off by that, as the plant's readings show it."""
    sensors = [one.model_copy(update={"bias": 0.5} if one.quantity == "depth" else {}) for one in ROBOT.sensors]
    robot = ROBOT.model_copy(update={"sensors": tuple(sensors)})
    plant, off = Unit(written(robot, tmp_path, kind="plant"), seed=1), []
    for _ in range(100):
        plant.step()
        off.append(np.subtract(*plant.get("depth_read", "depth")))
    plant.close()
    unit = Unit(written(robot, tmp_path), **BEAT, start_speed=0.2, seed=1, steered=True, depth_command=2.0)
    held = swim(unit, 60)[-50:, 0].mean()
    unit.close()
    assert abs(np.mean(off)) > 0.2
    assert held + np.mean(off) == pytest.approx(2.0, abs=0.05)


def test_the_command_holds_again_after_it(file: Path) -> None:
    """Fins and mean bends are the pilot's, then those of the command. The gait stays."""
    fins = {"fin_command_port": 0.1, "fin_command_starboard": 0.1}
    unit = Unit(file, **BEAT, **fins, start_speed=0.2, steered=True, depth_command=6.0, heading_command=1.5)
    for steered in (True, False):
        unit.set(steered=steered)
        unit.step(2.0)
        bends = []
        for _ in range(round(1 / GAIT.frequency / TICK)):
            unit.step()
            bends.append(unit.get("angle_set_I"))
        fin, bias = unit.get("fin_target_port", "fin_target_starboard"), np.mean(bends)
        assert np.ptp(bends) > 0.1
        assert (abs(bias) > 0.05) == steered
        assert (fin < -0.3).all() if steered else fin == pytest.approx([0.1, 0.1], abs=1e-9)
    unit.close()


def test_only_a_pilot_at_sea_is_commanded(file: Path, tmp_path: Path) -> None:
    """The plane, the plant and a robot without a pilot have no such inputs."""
    steering = {"steered", "depth_command", "heading_command"}

    def has(path: Path) -> set[str]:
        unit = Unit(path)
        inputs = {name for name, one in unit.variables.items() if one.causality == "input"}
        unit.close()
        return inputs & steering

    assert has(file) == steering
    assert has(written(ROBOT, tmp_path, kind="plant")) == set()
    document = ROBOT.document()
    del document["guidance"]
    document["sources"] = {key: text for key, text in document["sources"].items() if not key.startswith("guidance")}
    assert has(written(parse(document), tmp_path)) == set()
    (tmp_path / "plane.fmu").write_bytes(ht.fmu(ROBOT))
    assert has(tmp_path / "plane.fmu") == set()
