"""Where the twin's power goes: numbers by hand, sums over every kind of robot, seals, battery, table, picture."""

import copy
import math
import re
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from drawn import apart
from hypertuna import _core
from hypertuna.description.robot import Robot, parse
from hypertuna.simulation.cards import losses_card
from hypertuna.simulation.losses import PLACES
from hypertuna.simulation.plant import parts_of, steps_of
from hypertuna.simulation.plots_losses import REACH, TIP, TURN, _branch
from hypertuna.simulation.recorded import LOSSES
from simulation.test_servo_joints import with_servos

FISH = ht.load("hypertuna")
GAIT = ht.Gait.from_degrees(frequency=2, amplitude=(8, 12), phase=(0, 40))
HINGE = {"link": 7, "stiffness_n_m_per_rad": 0.5, "damping_n_m_s_per_rad": 0.002}
STORED = ("rotor", "elastic")  # what comes back within a beat


def with_keys(robot: Robot = FISH, **tables: dict[str, Any]) -> Robot:
    """A robot with other values in some tables; those of the pump's servos are `servos`."""
    document = copy.deepcopy(robot.document())
    for name, values in tables.items():
        kinds = document[name] if isinstance(document[name], list) else [document[name]]
        for table in kinds:
            if table.get("drives", "piston pump") == "piston pump":
                table.update(values)
    return parse(document)


def driven(robot: Robot, target: Any, ticks: int = 200) -> dict[str, Any]:
    """Drive the servos of a robot on the bench to targets (ticks, circuits) [rad], without a controller."""
    parts = parts_of(robot, "air", None)
    angles = np.ascontiguousarray(np.broadcast_to(target, (ticks, 2 * len(robot.joints))))
    world = _core.World({"clamped": 1.0})
    steps = steps_of(0.01, parts, robot)
    return _core.simulate(parts.plant, angles, world, twist=np.zeros(6), tick=0.01, steps=steps)


KINDS = {
    "oil": FISH,
    "oil, no seals": with_keys(pump={"seal_friction_n": 0.0}),
    "oil, seals": with_keys(pump={"seal_friction_n": 15.0}),
    "servos on all axles": with_servos(0, 1),
    "a servo on one axle": with_servos(1),
    "strips": FISH.using(water="strip"),
    "hinge": parse(FISH.document() | {"hinge": HINGE}),
}


@pytest.mark.parametrize("kind", KINDS)
def test_losses_add_up_to_the_power(kind: str) -> None:
    """In every tick to rounding; what is stored comes back over whole beats."""
    robot = KINDS[kind]
    run = ht.twin(robot, GAIT, duration=8, start="swimming", closed_loop=False)
    total = sum(run.data[f"loss_{name}"] for name in LOSSES)
    np.testing.assert_allclose(total, run.data["power"], rtol=1e-9)
    losses = run.losses
    each = {loss.name: loss.power for loss in losses.losses}
    lost = sum(power for name, power in each.items() if LOSSES.get(name) and name not in STORED)
    assert lost == pytest.approx(run.electrical_power, rel=5e-3)
    assert sum(map(losses.at, PLACES)) == pytest.approx(losses.power, rel=1e-12)
    lossy = {"line", "braid", "silicone"} if run.circuits else set()
    lossy |= {"seals"} if robot.pump is not None and robot.pump.seal_friction else set()
    lossy |= {"hinge"} if kind == "hinge" else set()
    assert {name for name in ("line", "braid", "silicone", "seals", "hinge") if each[name] > 0} == lossy
    if not set(run.drives) & set(run.joints):  # instants of ticks alias with a servo's steps on the axle
        instants = (run.data["moment"] * run.data["rate"])[run.beats].sum(axis=1).mean()
        assert run.mechanical_power == pytest.approx(instants, rel=0.05)


def test_springs_of_hinges_store_no_power_in_oil() -> None:
    """A robot without oil loses none there, whether or not its fin hangs on a spring."""
    run = ht.twin(parse(KINDS["servos on all axles"].document() | {"hinge": HINGE}), GAIT, duration=3)
    assert run.losses.at("oil") == 0
    assert not run.data["loss_elastic"].any()
    assert "oil" not in repr(run)
    stored = (run.data["loss_hinge"] < 0).mean()
    assert 0 < stored < 0.5  # the spring gives back within a beat


def test_at_sea_and_side_by_side_they_are_the_same() -> None:
    alone = ht.twin(FISH, GAIT, duration=3)
    [first, _] = ht.twins([{"robot": FISH, "gait": GAIT, "duration": 3, "seed": k} for k in (0, 1)], measure=dict_of)
    for name in (*(f"loss_{name}" for name in LOSSES), "battery_current"):
        np.testing.assert_array_equal(first[name], alone.data[name])
    sea = ht.twin_at_sea(FISH, GAIT, duration=3, speed=0.0)
    assert sum(sea.data[f"loss_{name}"] for name in LOSSES) == pytest.approx(sea.data["power"], rel=1e-9)
    assert sea.losses.at("oil") == pytest.approx(alone.losses.at("oil"), rel=0.05)


def dict_of(run: ht.TwinRun) -> dict[str, Any]:
    """Return the record of a run."""
    return run.data


def test_a_robot_at_rest_draws_the_idle_current_and_what_holds_its_pressure() -> None:
    """Both sides filled to 60 kPa load the crank: what gears and seals do not hold, the windings do."""
    pump = FISH.pump
    assert pump is not None
    servo = next(servo for servo in FISH.servos if servo.drives == "piston pump")
    idle = sum(one.count * (one.idle_current or 0) * (one.voltage or 0) for one in FISH.servos)
    fill = [group.line.fill_pressure for group in FISH.joints if group.line is not None]
    for seal in (0.0, 5.0, 1000.0):
        record = driven(with_keys(pump={"seal_friction_n": seal}), 0.0)
        slope = pump.crank  # the crank stands across, and the rod upright enough
        load = [p * math.pi / 4 * pump.bore**2 * slope for p in fill for _ in range(2)]
        held = [max(0.0, torque - servo.friction - seal * slope) for torque in load]
        windings = sum((torque / servo.torque) ** 2 * servo.voltage * servo.stall_current for torque in held)
        assert record["loss_idle"][-1] == pytest.approx(idle, rel=1e-12)
        assert record["loss_windings"][-1] == pytest.approx(windings, rel=0.02, abs=1e-9)
        assert record["power"][-1] == pytest.approx(idle + windings, rel=0.02)


def test_seals_take_force_times_way() -> None:
    """A servo that goes to and fro at a constant rate: F times the piston's way, over the whole run."""
    force, ticks = 15.0, 400
    way = np.abs((np.arange(ticks + 1) * 0.01 * 0.5 + 0.25) % 1.0 - 0.5) - 0.25  # rad, at 0.5 rad/s
    robot = with_keys(pump={"seal_friction_n": force})
    record = driven(robot, way[1:, np.newaxis] * [1, -1, 1, -1], ticks)
    circuit = ht.actuation.hydraulics.circuits(robot)
    angles = record["servo_angle"]
    pushed = np.stack([_core.displaced(circuit.values[c], np.ascontiguousarray(angles[:, c]))[:, 0] for c in range(4)])
    piston = np.abs(np.diff(pushed, axis=1)).sum() / circuit.row(0)["area"]
    assert (record["loss_seals"][:-1] * 0.01).sum() == pytest.approx(force * piston, rel=0.02)


def test_the_battery_gives_what_converter_electronics_and_servos_take() -> None:
    run = ht.twin(with_keys(battery={"electronics_w": 2.5, "converter_efficiency": 0.8}), GAIT, duration=2)
    each = {loss.name: loss.power for loss in run.losses.losses}
    power = run.electrical_power
    assert each["electronics"] == 2.5
    assert each["converter"] == pytest.approx(0.25 * power, rel=1e-9)
    current = run.data["battery_current"][run.beats]
    assert each["resistance"] == pytest.approx(4 * 0.035 * (current**2).mean(), rel=1e-9)
    open_circuit = 4 * 4.2 - 4 * 1.2 * (np.cumsum(run.data["battery_current"]) * 0.01 / 12600)[run.beats]
    assert run.losses.power == pytest.approx((open_circuit * current).mean(), rel=1e-3)


def test_table_and_picture() -> None:
    losses = ht.twin(FISH, GAIT, duration=2).losses
    table = losses.to_pandas()
    assert table["part"].sum() == pytest.approx(1)
    assert set(table["place"]) == set(PLACES)
    assert table["power_w"].sum() == pytest.approx(losses.power)
    summary = losses.summary()
    assert summary["power_w"].value == losses.power
    assert summary["windings_w"].unit == "W"
    assert "power of the cells" in repr(losses)
    with pytest.raises(ht.InputError, match="place must be"):
        losses.at("oils")
    for width in (7.2, 3.6):
        figure = losses.plot(width=width)
        texts = [text for text in figure.axes[0].texts if text.get_text()]
        boxes = [text.get_window_extent() for text in texts]
        assert all(figure.bbox.contains(box.x0, box.y0) for box in boxes)
        assert apart(boxes)


@pytest.mark.parametrize("size", [0.01, 0.1, 0.6])
def test_a_branch_of_the_picture_is_as_wide_as_its_loss(size: float) -> None:
    """A quarter of a ring, a bar and a triangle; 25 corners on each arc leave a thousandth."""
    x, y = _branch(0.3, 0.9, size).T
    area = abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    tip = min(size / 2, TIP)
    bar = 1 + TURN + REACH - tip - (0.9 + TURN)
    ring = math.pi / 4 * ((TURN + size) ** 2 - TURN**2)
    assert area == pytest.approx(ring + size * bar + size * tip / 2, rel=2e-3)


def test_the_larger_losses_of_a_place_are_named_and_drawn_from_zero() -> None:
    run = ht.twin(FISH, GAIT, duration=4, start="swimming", closed_loop=False)
    losses = run.losses
    for place in PLACES:
        named = [part.rsplit(" ", 1) for part in losses.named(place).split(", ") if part]
        assert place not in dict(named)
        assert all(float(power) == pytest.approx(next(o.power for o in losses.losses if o.name == name), abs=0.006)
                   for name, power in named)  # fmt: skip
        assert sum(float(power) for _, power in named) == pytest.approx(losses.at(place), abs=0.1 * losses.power)
    svg = losses_card(losses).picture()
    zero = float(re.search(r'class="mark" d="M([\d.]+) 20V', svg)[1])
    for left, width in re.findall(r'<rect class="joint" x="([\d.]+)" y="\d+" width="([\d.]+)"', svg):
        assert min(abs(float(left) - zero), abs(float(left) + float(width) - zero)) < 0.2
