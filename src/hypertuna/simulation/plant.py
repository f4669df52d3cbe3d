"""Build the core's plant, sensors and controller of a robot, and simulate a command with them."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.actuation.battery import battery_columns
from hypertuna.actuation.hydraulics import DRIVES, SOFTER, Circuits, circuits, drive_names, require_oil
from hypertuna.actuation.soft_joint import SMALL, JointModel, drive_unit, joint_models
from hypertuna.arrays import Array
from hypertuna.control.controller import controller_columns
from hypertuna.control.sensors import fault_texts, sensor_columns
from hypertuna.control.sensors import faults as read_faults
from hypertuna.description.pose import coordinate_shares
from hypertuna.description.robot import Robot, cached, joint_key
from hypertuna.description.schema.body import JointGroup
from hypertuna.description.schema.water import LAWS
from hypertuna.description.twin import require_controller, require_mass_at_hinge, require_passive_hinges
from hypertuna.errors import InputError
from hypertuna.ranges import FINITE, Range, Whole
from hypertuna.simulation.recorded import VARIABLES
from hypertuna.simulation.sea import space_columns
from hypertuna.swimming.gait import Gait, lags
from hypertuna.swimming.model import core_model
from hypertuna.swimming.swim import settled_speed
from hypertuna.swimming.yielding import SPRING, dampers, key_of, spring_of, steepest

STEP = 1 / 3000  # s: integration step; half of it changes results by less than 0.1 % (docs/twin.md)
MAX_RATE_STEP = 2.2  # largest product of rate and step that is used; Runge-Kutta is unstable beyond 2.7
MIN_STEP = 1e-6  # s: with shorter steps, one simulated second takes minutes
TOLERANCE = 1e-9  # relative: by which a command converted from degrees may exceed a bound
MAX_TICKS = 1_000_000  # longest run [control ticks], whose record takes a gigabyte
SEEDS = Whole(min=0, max=2**64 - 1)  # seeds that the core accepts


@dataclass(frozen=True)
class Parts:
    """The core's plant and sensors of a robot, and the fastest rate of the plant."""

    plant: _core.Plant
    fastest: float  # fastest rate at which the plant responds [1/s]; the integration step must resolve it
    stiffest: tuple[str, str]  # key of the value that causes the fastest rate, and a fix for the user
    sensors: dict[str, list[float]]
    temperature: float  # oil temperature [K]


def parts_of(robot: Robot, medium: str, temperature: float | None) -> Parts:
    """Return plant and sensors of a robot in water or air, at an oil temperature [K]."""
    return cached(robot, ("plant", medium, temperature), lambda: _make_parts(robot, medium, temperature))


def controller_of(robot: Robot) -> dict[str, list[float]]:
    """Return the columns of a robot's controller for the core."""
    return cached(robot, "controller", lambda: controller_columns(robot))


def _make_parts(robot: Robot, medium: str, temperature: float | None) -> Parts:
    """Build plant and sensors for `parts_of`, which caches them with the robot."""
    oil, models = circuits(robot, temperature), _viscous(robot)
    law, zeros = robot.model.water, [0.0] * len(robot.links.name)
    # In air, the density is zero, and so are added mass and drag that do not depend on density.
    in_air = {"water.density": [0.0], **{f"water.{law}.{name}": zeros for name in LAWS[law].dry}}
    model = core_model(robot, None if medium == "water" else in_air)
    plant = _core.Plant(model, _plant_columns(robot, oil, models))
    fastest, stiffest = _fastest(robot, plant, medium == "air", oil, models)
    return Parts(plant, fastest, stiffest, sensor_columns(robot), oil.temperature)


def plant_columns(robot: Robot) -> dict[str, Any]:
    """Return the columns from which the core makes a robot's plant, at the oil temperature of its file."""
    return _plant_columns(robot, circuits(robot), _viscous(robot))


def _plant_columns(robot: Robot, oil: Circuits, models: Sequence[JointModel]) -> dict[str, Any]:
    """Return the plant's columns for given oil circuits and joint models."""
    require_mass_at_hinge(robot)
    require_passive_hinges(robot)
    fin_servos = [servo for servo in robot.servos if servo.drives != DRIVES]
    columns: dict[str, Any] = {
        "share": coordinate_shares(robot),
        "joints": len(models),
        **{f"joint.{name}": [model[name] for model in models] for name in _core.joint_columns()},
        **{f"circuit.{name}": oil.column(name) for name in oil.columns},
        "direct": [0.0 if group.drive.oil else group.turns for group in robot.joints],
        "armature": _armature(robot),
        **{f"battery.{name}": value for name, value in battery_columns(robot).items()},
        "idle": sum(servo.count * (servo.idle_current or 0.0) * (servo.voltage or 0.0) for servo in fin_servos),
    }
    if robot.hinges:
        springs = [spring_of(hinge) for hinge in robot.hinges]
        columns |= {f"spring.{name}": [spring[name] for spring in springs] for name in SPRING}
    if robot.spatial is not None and robot.fins is not None:
        columns |= space_columns(robot)
    return columns


def _viscous(robot: Robot) -> tuple[JointModel, ...]:
    """Return the joint models, after checking that all silicone has an axial viscosity, which the twin needs."""
    models = joint_models(robot)
    viscosities = [m["axial_viscosity"] for m, group in zip(models, robot.joints, strict=True) if group.drive.oil]
    if min(viscosities, default=1.0) <= 0:
        key, fix = f"materials.{drive_unit(robot).matrix}.relaxation_s", "give 0.005, an estimate for silicone"
        raise InputError("must be positive in the twin", file=robot.file or None, key=key, value="0", fix=fix)
    return models


def _armature(robot: Robot) -> list[float]:
    """Return the inertia of the servo's rotor about each joint or hinge [kg m^2]; zero without a servo on it."""
    rotors = [0.0 if group.servo is None else group.turns**2 * group.servo.inertia for group in robot.joints]
    return rotors + [0.0] * len(robot.hinges)


def _fastest(
    robot: Robot, plant: _core.Plant, clamped: bool, oil: Circuits, models: Sequence[JointModel]
) -> tuple[float, tuple[str, str]]:
    """Return the fastest rate of the plant at the hard pressure limit [1/s], the key that causes it, and a fix.

    Rates come from each joint's oil or servo, from each hinge, and from all joints moving together against the
    viscosity of their silicone.
    """
    coordinates = len(models) + len(robot.hinges)
    response = plant.accelerations(  # rad/s^2 per N m of every coordinate of the straight tail
        _core.World({"clamped": float(clamped)}),
        bend=np.zeros((coordinates, 2, coordinates)),
        twist=np.zeros((coordinates, 6)),
        pose=np.zeros((coordinates, 9)),
        moment=np.eye(coordinates),
    )[:, 6:]
    mobility = response.diagonal()
    root = np.sqrt([m["viscosity"] if group.drive.oil else 0.0 for m, group in zip(models, robot.joints, strict=True)])
    viscous = np.linalg.eigvalsh(np.outer(root, root) * response[: len(models), : len(models)])[-1]
    rates = {("joints", "fewer joint groups, or longer links"): float(viscous)}
    for j, (group, model) in enumerate(zip(robot.joints, models, strict=True)):
        pair = oil.values[2 * j : 2 * j + 2]
        if group.servo is not None:
            key = f"{joint_key(robot, group.name)}.servo", "less friction or bandwidth, or a heavier rotor"
            rates[key] = _core.axle_stiffness(pair[0], group.turns**2 * float(mobility[j]))
        else:
            rates |= _oil_rates(robot, model, dict(zip(oil.columns, pair.T, strict=True)), pair, float(mobility[j]))
    for place, hinge, free in zip(robot.hinge_keys, robot.hinges, mobility[len(models) :].tolist(), strict=True):
        parts = steepest(hinge)
        steep = key_of(max(parts, key=lambda part: parts[part]))
        rates[f"{place}.{steep}", "a softer hinge, or none"] = math.sqrt(sum(parts.values()) * free)
        damping = dampers(hinge)
        damper = key_of(max(damping, key=lambda part: damping[part]))
        rates[f"{place}.{damper}", "less damping"] = sum(damping.values()) * free
    stiffest = max(rates, key=lambda name: rates[name])
    return float(rates[stiffest]), stiffest


def _oil_rates(
    robot: Robot, model: JointModel, column: dict[str, Array], pair: Array, mobility: float
) -> dict[tuple[str, str], float]:
    """Return upper bounds of the rates of a hydraulic joint [1/s], by key and fix; mobility [rad/s^2 per N m]."""
    pressure = 0.0 if robot.controller is None else robot.controller.pressure_hard or 0.0
    swelling = 1 / column["bulk_modulus"]
    swelling = swelling + column["air"] * _core.ATMOSPHERE / (_core.ATMOSPHERE + pressure) ** 2
    compliance = column["compliance"] + column["oil_unit"] * swelling  # m^3/Pa: drive units and the oil in them
    straight = model.at(0.0, -model["rest"])  # without filling, where a muscle's volume changes fastest
    swing = math.sqrt(float((straight["slope"][0] ** 2 / compliance).sum() * mobility))
    # With filling, where the axis may have buckled, and without.
    spans = [[at - SMALL, at + SMALL] for at in (0.0, -model["rest"])]
    silicone = max(-float(np.diff(model.at(0.0, span)["axial"])[0]) / (2 * SMALL) for span in spans)
    axial_stiffness = silicone + float((straight["gain"][0] ** 2 / compliance).sum())
    material = f"materials.{drive_unit(robot).matrix}.relaxation_s", "a longer relaxation time, or more compliance"
    of_circuit = max(_core.circuit_stiffness(row, pressure, 0.0) for row in pair)
    line = (f"{joint_key(robot, model.name)}.line", SOFTER)
    return {material: axial_stiffness / model["axial_viscosity"], line: math.hypot(of_circuit, swing)}


def check_command(robot: Robot, gait: Gait) -> None:
    """Raise an error for a command beyond the controller's bounds; on board, the controller would clamp it."""
    limit = require_controller(robot).frequency_max
    if gait.frequency > limit * (1 + TOLERANCE):
        rule = f"must be at most {limit:g} Hz, the controller.frequency_max_hz of {robot.name}"
        raise InputError(rule, key="frequency", value=f"{gait.frequency:g}", fix="give less")
    for j, group in enumerate(robot.joints):
        check_bend(group, gait.amplitude[j], f"amplitude[{j}]")
        check_bend(group, gait.bias[j], f"bias[{j}]")


def check_bend(group: JointGroup, bend: float, key: str) -> None:
    """Raise an error for a bend [rad] beyond the largest bend that the joint group's description allows."""
    if group.bend_max is not None and abs(bend) > group.bend_max * (1 + TOLERANCE):
        rule = f"must be at most {math.degrees(group.bend_max):g} deg, the bend_max_deg of joint {group.name}"
        raise InputError(rule, key=key, value=f"{math.degrees(bend):g} deg", fix="give a bend that the joint reaches")


def steps_of(tick: float, parts: Parts, robot: Robot, step: float | None = None) -> int:
    """Return the number of integration steps per tick [s]; without a given step [s], as many as the plant needs."""
    if step is None:
        step = min(STEP, tick, MAX_RATE_STEP / parts.fastest)
        if step < MIN_STEP:
            key, fix = parts.stiffest
            rule = f"must not be so stiff that the twin needs steps of less than {MIN_STEP:g} s"
            value = f"so stiff that it needs {step:.1g} s"
            raise InputError(rule, file=robot.file or None, key=key, value=value, fix=f"describe {fix}")
    elif not MIN_STEP <= FINITE.check(step, "step", f"omit it for {STEP:g}") <= tick * (1 + 1e-12):
        rule = f"must be from {MIN_STEP:g} to the control tick of {tick:g} s"
        raise InputError(rule, key="step", value=f"{step:g}", fix=f"omit it for {STEP:g}")
    return math.ceil(tick / step * (1 - 1e-12))


@dataclass(frozen=True)
class PlannedRun:
    """A command, and all that the core needs to simulate it."""

    fields: dict[str, Any]  # fields of its `Run`, except time, data and status
    core: dict[str, Any]  # arguments of `_core.simulate`

    def run(self) -> dict[str, Any]:
        """Simulate the command, and return the fields of its `Run`."""
        return self.fields_of(_core.simulate(**self.core))

    def fields_of(self, record: dict[str, Array]) -> dict[str, Any]:
        """Return the fields of its `Run` from the core's record."""
        ticks_run, every, robot = int(record.pop("ticks")[0]), self.core["every"], self.fields["robot"]
        tick = 1 / require_controller(robot).rate
        rows = max(-(-ticks_run // every), 1)  # at least the start, if the run diverges at once
        return self.fields | {
            "time": np.arange(rows, dtype=np.float64) * tick * every,
            "data": _named(record, rows, robot),
            "status": "completed" if ticks_run == self.core["ticks"] else "diverged",
        }


def plan_command(
    robot: Robot,
    gait: Gait,
    world: _core.World,
    *,
    medium: str,
    duration: float,
    faults: str | Iterable[str],
    seed: int,
    closed_loop: bool,
    temperature: float | None,
    step: float | None,
    command_lost_at: float,
    speed: float | None,
    controller_robot: Robot | None = None,
    pose: Array | None = None,
    fins: Callable[[int, float], Array] | None = None,
    every: int = 1,
) -> PlannedRun:
    """Plan a run: check the command, and build plant, sensors, controller and start.

    speed: at the start [m/s]; None: that of the settled beat. fins: called with the number of ticks and their length
    [s], it returns the angles of the fins (ticks, 2) [rad].
    """
    if temperature is not None:
        require_oil(robot, "temperature")
        temperature = FINITE.check(temperature, "temperature", "give the temperature of the oil in K")
    if command_lost_at != math.inf:
        FINITE.check(command_lost_at, "command_lost_at", "omit it for a command without end")
    tick = 1 / require_controller(robot).rate
    duration = Range(min=tick, max=MAX_TICKS * tick).check(duration, "duration", "give the seconds to run")
    ticks = int(duration / tick * (1 + 1e-12))
    texts = fault_texts(faults)
    parts = parts_of(robot, medium, temperature)
    steps = steps_of(tick, parts, robot, step)
    configured = robot if controller_robot is None else controller_robot
    check_command(configured, gait)
    open_loop = {} if closed_loop else {"learning": [0.0]}  # the pumps' inverse maps alone
    controller = _core.LiveController(controller_of(configured) | open_loop)
    angles = {"amplitude": gait.amplitude, "phase": lags(gait), "bias": gait.bias}
    command: dict[str, Any] = {"since": 0.0, "armed": 1.0, "frequency": gait.frequency}
    command |= {name: np.atleast_2d(values) for name, values in angles.items()}
    command |= {} if fins is None else {"fin": fins(ticks, tick)}
    speed = _settled_start(robot, gait) if speed is None else speed
    core = {
        "plant": parts.plant,
        "command": _core.GaitCommand(controller, command, lost_at=command_lost_at),
        "world": world,
        "sensors": _core.Sensors(parts.sensors, SEEDS.check(seed, "seed")),
        "faults": list(read_faults(texts, robot, duration)),
        "twist": np.array([0.0 - speed, 0.0, 0.0, 0.0, 0.0, 0.0]),
        "pose": pose,
        "ticks": ticks,
        "steps": steps,
        "every": every,
    }
    fields = {
        "robot": robot,
        "gait": gait,
        "duration": duration,
        "closed_loop": closed_loop,
        "seed": seed,
        "temperature": parts.temperature,
        "faults_given": texts,
        "step": tick / steps,
    }
    return PlannedRun(fields, core)


def _settled_start(robot: Robot, gait: Gait) -> float:
    """Return the speed of the settled beat [m/s], with which a run at sea begins; 0 where the search finds none."""
    try:
        settled = settled_speed(robot, gait)
    except InputError as error:
        start = "a run at sea begins with the speed of the settled beat"
        fix = f"{start}; give less, leave the hinge out for a rigid joint, or run `twin`, which begins at rest"
        raise InputError(error.rule, file=error.file, key=error.key, value=error.value, fix=fix) from None
    return settled if math.isfinite(settled) else 0.0


def _named(record: dict[str, Array], rows: int, robot: Robot) -> dict[str, Array]:
    """Cut a record to `rows` and to the robot's drives, split off hinges, and turn surge into speed, positive ahead."""
    joints = len(robot.joints)
    data = existing({name: column[:rows] for name, column in record.items()}, robot)
    if "surge" in data:
        data["speed"] = -data.pop("surge")
    for name in ("angle", "rate", "moment"):
        if data[name].shape[1] > joints:
            data[f"hinge_{name}"], data[name] = data[name][:, joints:], data[name][:, :joints]
    return data


def existing(data: dict[str, Array], robot: Robot) -> dict[str, Array]:
    """Drop a record's columns of circuits and servos that the robot lacks: a servo on an axle has no oil circuit."""
    names = drive_names(robot)
    drives = [c for c, name in enumerate(names) if name]
    oil = [c for c, name in enumerate(drive_names(robot, oil=True)) if name]
    indices = {"circuit": oil, "drive": drives, "servo": [*drives, len(names), len(names) + 1]}
    for name, column in data.items():
        dim = VARIABLES.get(name, ("",))[0]
        if len(oil) < len(names) and dim in indices:
            data[name] = column[:, indices[dim]]
    without_sensor = [not group.drive.oil for group in robot.joints]
    if any(without_sensor):
        data["angle_measured"] = np.where(without_sensor, math.nan, data["angle_measured"])
    return data
