"""Pump sizing: loads and limits of servos, cylinders and lines in a beat, and the bend reached."""

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated, Any

import numpy as np

from hypertuna import _core
from hypertuna.actuation.hydraulics import SOFTER, Circuits, circuits, has_oil, servo_angle, supply_voltage, with_bore
from hypertuna.actuation.soft_joint import SMALL, JointModel, joint_models
from hypertuna.arrays import Array
from hypertuna.description.changes import changed
from hypertuna.description.robot import Robot, joint_key, require
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.io.quantity import Format, columns
from hypertuna.ranges import POSITIVE, Range

SAMPLE = 1e-3  # s between rows of a run
SHORTEST = 1e-5  # s, shortest allowed step; with a shorter one a beat takes minutes to compute
MAX_STEPS = 150_000  # most steps of a run, which take some seconds
BEATS, LAGS = 4, 6.0  # length of a run: this many beats or time constants of the line, whichever is longer
STABLE = 1.5  # step times the circuit's fastest rate; Runge-Kutta is stable up to 2.7
STIFF = 1e6  # Pa, pressure at which a step must be stable
FLOWS = 200  # instants of a beat at which the joint's flow is computed
HALVINGS = 8  # steps of the bisection for the command that keeps the pressure at its limit
REACHED = 0.95  # part of the command that counts as reached; a servo, compliance or line that passes less is a limit
SETTLED = 0.5  # s, longer than servos take to reach a constant angle
DURATION_MAX = 80.0  # s, longest run
LAMINAR = 2300  # Reynolds number up to which a line's flow is laminar
DEEP_SUCTION = 0.8  # part of the cavitation pressure below which air expands so that the passive side no longer follows
MARGINS = ("torque_margin", "servo_speed_margin", "stroke_margin")  # properties of a `Size` that records add


@dataclass(frozen=True)
class Size:
    """Loads, limits and bend of one joint at one frequency, line bore and oil temperature."""

    joint: Annotated[str, Format()]  # name of the joint group
    temperature: Annotated[float, Format("degC")]  # K, of the oil
    frequency: Annotated[float, Format("Hz")]  # Hz, of the beat
    bore: Annotated[float, Format("mm")]  # m, of the line
    viscosity: Annotated[float, Format("mm^2/s")]  # m^2/s, kinematic viscosity of the oil
    command: Annotated[float, Format("deg")]  # rad, amplitude commanded to the servos
    torque: Annotated[float, Format("N m")]  # N m, of a servo at the joint's pressure limit, with friction
    torque_limit: Annotated[float, Format("N m")]  # N m, stall torque of a servo
    servo_speed: Annotated[float, Format("rad/s")]  # rad/s, largest rate of a servo that follows the beat exactly
    servo_speed_limit: Annotated[float, Format("rad/s")]  # rad/s, of a servo without load
    stroke: Annotated[float, Format("deg")]  # rad, largest servo angle to either side for the command
    stroke_limit: Annotated[float, Format("deg")]  # rad, angle of the nearer dead center
    line_resistance: Annotated[float, Format("Pa s/m^3")]  # Pa s/m^3, of the line
    line_inertance: Annotated[float, Format("Pa s^2/m^3")]  # Pa s^2/m^3, of the line
    capacity_rest: Annotated[float, Format("m^3/Pa")]  # m^3/Pa, volume of one side per pressure, at rest
    capacity: Annotated[float, Format("m^3/Pa")]  # m^3/Pa, the same up to the pressure limit
    corner_rest: Annotated[float, Format("Hz")]  # Hz, corner frequency of line and `capacity_rest`, 1 / (2 pi R C)
    corner: Annotated[float, Format("Hz")]  # Hz, corner frequency of line and `capacity`
    resonance: Annotated[float, Format("Hz")]  # Hz, of inertance and `capacity`, 1 / (2 pi sqrt(I C))
    damping_ratio: Annotated[float, Format()]  # damping ratio of `resonance`
    # Hz, resonance of the inertance with oil and air of the cylinder at the fill pressure; steps of the servo excite it
    ring: Annotated[float, Format("Hz")]
    ring_damping_ratio: Annotated[float, Format()]  # damping ratio of `ring`
    # Pa, largest pressure drop along the line if the joint follows the command, by laminar flow
    pressure_drop: Annotated[float, Format("kPa")]
    reynolds: Annotated[float, Format()]  # largest Reynolds number of that flow
    bend: Annotated[float, Format("deg")]  # rad, first harmonic of the bend, in air, without inertia
    lag: Annotated[float, Format("deg")]  # rad, phase of the bend behind the command
    command_fraction: Annotated[float, Format()]  # part of the command that is sent; below 1 at the pressure limit
    pressure_max: Annotated[float, Format("kPa")]  # Pa, of the cylinders
    pressure_min: Annotated[float, Format("kPa")]  # Pa, of the cylinders
    limits: tuple[str, ...]  # what limits the bend: "pressure", "suction", "servo", "compliance", "line"
    electrical_power: dict[str, float]  # W, mean electrical power of both servos: ``total`` and its shares
    values: Mapping[str, float] = field(default_factory=dict)  # values that `size_over` varies, by key

    @property
    def turbulent(self) -> bool:
        """Whether the line's flow is turbulent, so that its pressure drop is underestimated."""
        return self.reynolds > LAMINAR

    @property
    def reached(self) -> bool:
        """Whether the bend is at least 95 % of the command, and the servos can hold the pressure limit."""
        return self.bend >= REACHED * self.command and self.torque <= self.torque_limit

    @property
    def torque_margin(self) -> float:
        """Torque that the servo has beyond the torque needed, over the torque needed [1]."""
        return self.torque_limit / self.torque - 1

    @property
    def servo_speed_margin(self) -> float:
        """Speed that the servo has beyond the speed needed, over the speed needed [1]."""
        return self.servo_speed_limit / self.servo_speed - 1

    @property
    def stroke_margin(self) -> float:
        """Stroke that the servo has beyond the stroke needed, over the stroke needed [1]."""
        return self.stroke_limit / self.stroke - 1

    def record(self) -> dict[str, Any]:
        """Return the numbers of the case by their names in JSON and files."""
        power = {f"electrical_power_{name}_w": watts for name, watts in self.electrical_power.items()}
        return (
            {**self.values}
            | columns(self)
            | {name: getattr(self, name) for name in MARGINS}
            | {"turbulent": self.turbulent, "limits": list(self.limits)}
            | power
        )


class Sizes(Plotted, Tabular, list[Size], data=lambda sizes: [size.record() for size in sizes]):
    """List of the cases of a robot, each a `Size`."""

    def __init__(self, robot: Robot, sizes: Iterable[Size] = ()) -> None:
        super().__init__(sizes)
        self.robot = robot


def largest_beat(robot: Robot) -> tuple[float, tuple[float, ...]]:
    """Return the highest frequency [Hz] and the largest amplitude of each joint group [rad] of the description."""
    bounds = require(robot.gait_bounds, "gait_bounds", robot, "give a frequency")
    amplitudes = tuple(
        require(group.amplitude_max, f"{joint_key(robot, group.name)}.amplitude_max_deg", robot, "give an amplitude")
        for group in robot.joints
    )
    return bounds.frequency[1], amplitudes


def size_pump(
    robot: Robot,
    *,
    frequency: Sequence[float],
    amplitude: Sequence[float],
    bore: Sequence[float | None] = (None,),
    temperature: Sequence[float | None] = (None,),
    progress: Callable[[int, int], None] | None = None,
) -> Sizes:
    """Return pump sizes for every joint at every frequency [Hz], line bore [m] and oil temperature [K].

    A bore or temperature of None is the robot's. `amplitude` [rad] is commanded to the joint groups. In the result,
    joints change fastest, then temperatures, bores, frequencies. `progress` receives the numbers of done and all cases.
    """
    _check(robot, frequency, amplitude)
    if not has_oil(robot):
        rule, fix = "has no pump: servos turn all its joints", "name a robot with oil"
        raise InputError(rule, file=robot.file or None, key=f"robot {robot.name}", fix=fix)
    models = joint_models(robot)
    cases = list(itertools.product(frequency, bore, temperature))
    variants = {d: robot if d is None else with_bore(robot, d) for d in bore}
    built = {(d, t): circuits(variants[d], t) for d in bore for t in temperature}  # checks all input
    sizes = Sizes(robot)
    for k, (f, d, t) in enumerate(cases):
        for j, angle in enumerate(amplitude):
            if not robot.joints[j].drive.oil:
                continue
            sizes.append(_size(variants[d], built[d, t], models[j], j, f, angle))
        if progress is not None:
            progress(k + 1, len(cases))
    return sizes


def size_over(
    robot: Robot,
    over: Mapping[str, Sequence[float]],
    *,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> Sizes:
    """Return pump sizes for every combination of values of keys of the robot's file; `over`: values by key.

    The options are those of `size_pump`. In the result, the last key changes faster than the first one, and joints,
    temperatures, bores and frequencies change faster than all keys.
    """
    cases = [dict(zip(over, values, strict=True)) for values in itertools.product(*over.values())]
    robots = [changed(robot, case, "--over") for case in cases]  # checks all input
    sizes = Sizes(robot)
    for k, (case, variant) in enumerate(zip(cases, robots, strict=True)):
        report = progress and partial(_report, progress, k, len(cases))
        sizes += [replace(size, values=case) for size in size_pump(variant, progress=report, **options)]
    return sizes


def _report(progress: Callable[[int, int], None], k: int, cases: int, count: int, total: int) -> None:
    """Report the progress of the k-th of several calls of `size_pump` as the progress of all."""
    progress(k * total + count, cases * total)


def _check(robot: Robot, frequency: Sequence[float], amplitude: Sequence[float]) -> None:
    """Check that frequencies and amplitudes are positive, with one amplitude per joint group."""
    if len(amplitude) != len(robot.joints):
        rule, fix = f"must be {len(robot.joints)} long, one value per joint group", "give one for each joint group"
        raise InputError(rule, key="amplitude", value=f"{len(amplitude)} long", fix=fix)
    for key, values, unit in (("frequency", frequency, "Hz"), ("amplitude", np.degrees(amplitude), "deg")):
        for value in values:
            POSITIVE.check(value, key, f"give it in {unit}")
    limits, fix = Range(min=BEATS / DURATION_MAX, max=1000, unit="Hz"), "other beats take too long to compute"
    for value in frequency:
        limits.check(value, "frequency", fix)


def _size(robot: Robot, hydraulics: Circuits, model: JointModel, j: int, frequency: float, amplitude: float) -> Size:
    """Return the pump size for joint j at a frequency [Hz] and an amplitude [rad]."""
    group, supply = robot.joints[j], supply_voltage(robot)
    working = robot.controller.works_at if robot.controller is not None else None
    limit = working or require(group.pressure_max, f"{joint_key(robot, group.name)}.pressure_max_pa", robot)
    column = hydraulics.row(2 * j)
    hose = require(group.line, "joints.line", robot)
    line = _line(hydraulics, model, j, limit)
    time, period = _times(frequency, line["line_resistance"] * line["capacity_rest"])
    target = _target(hydraulics, model, j, amplitude * np.sin(2 * np.pi * frequency * time))
    rows = np.ascontiguousarray(hydraulics.values[2 * j : 2 * j + 2])
    simulate = _simulator(robot, rows, model, supply, time[1], len(time))
    run, fraction = _limited(simulate, _sent_by_ticks(robot, target, time), period, limit)
    last_beat = target[-period:]
    settling_rows = math.ceil((SETTLED + LAGS * line["line_resistance"] * line["capacity_rest"]) / time[1])
    extremes = [last_beat[round(share * period)] * fraction for share in (0.25, 0.75)]
    held_bends = [simulate(np.tile(angles, (settling_rows, 1)))["bend"][-1] for angles in extremes]
    slow_bend = abs(held_bends[0] - held_bends[1]) / 2
    volume = model.hold(amplitude * np.sin(2 * np.pi * np.linspace(0, 1, FLOWS + 1)))["volume"]
    peak_flow = float(np.abs(np.diff(volume, axis=0)).max() * FLOWS * frequency)
    size = Size(
        joint=group.name,
        frequency=frequency,
        bore=hose.bore,
        temperature=hydraulics.temperature,
        viscosity=hydraulics.viscosity,
        command=amplitude,
        pressure_drop=line["line_resistance"] * peak_flow + column["loss"] * peak_flow**2,
        reynolds=4 * peak_flow / (np.pi * hose.bore * hydraulics.viscosity),
        command_fraction=fraction,
        **line,
        **_servo(column, rows[0], last_beat, time[1], supply / column["voltage"], limit),
        **_beat(column, run, fraction * last_beat, frequency, time[1], fraction, amplitude, slow_bend),
    )
    not_finite = [key for key, value in size.record().items() if isinstance(value, float) and not math.isfinite(value)]
    if not_finite:
        rule, fix = (
            f"must have sizes with which {not_finite[0]} is a finite number",
            "check their units and powers of ten",
        )
        raise InputError(rule, file=robot.file or None, key=f"{joint_key(robot, group.name)}", fix=fix)
    return size


def _servo(
    column: dict[str, float], row: Array, target: Array, interval: float, voltage: float, limit: float
) -> dict[str, Any]:
    """Return loads and limits of a servo in a beat; voltage: supply over rated voltage [1]."""
    slopes = _core.displaced(row, np.ascontiguousarray(target.ravel()))[:, 1]
    return {
        "torque": (limit + column["seal"] / column["area"]) * float(slopes.max()) + column["friction"],
        "torque_limit": column["stall_torque"] * voltage,
        "servo_speed": float(np.abs(np.diff(target, axis=0)).max() / interval),
        "servo_speed_limit": column["speed"] * voltage,
        "stroke": float(np.abs(target).max()),
        "stroke_limit": min(column["neutral"], np.pi - column["neutral"]),
    }


def _beat(
    column: dict[str, float],
    run: dict[str, Array],
    target: Array,
    frequency: float,
    interval: float,
    fraction: float,
    command: float,
    slow_bend: float,
) -> dict[str, Any]:
    """Return bend, pressures, powers and limits of a run's last beat; slow_bend: amplitude of a slow beat [rad]."""
    period, rows = len(target), len(run["bend"])
    clock = np.exp(-2j * np.pi * frequency * interval * np.arange(rows - period, rows))
    harmonic = complex(2j * np.mean(run["bend"][-period:] * clock))
    commanded, actual = (abs(np.mean(angle[-period:] * clock[:, None], axis=0)) for angle in (target, run["angle"]))
    pressure = run["pump_pressure"][-period:]
    parts: dict[str, float] = {}  # part of the command that each limit passes
    if fraction > 0:
        parts = {"servo": float(np.min(actual / commanded)), "compliance": slow_bend / (fraction * command)}
        parts["line"] = abs(harmonic) / (slow_bend * min(1.0, parts["servo"]))
    too_small = abs(harmonic) < REACHED * command
    limits = {
        "pressure": fraction < 1,
        "suction": pressure.min() < DEEP_SUCTION * column["cavitation"],
        **{name: part < REACHED for name, part in parts.items()},
    }
    if too_small and not any(limits.values()):  # several limits, each small
        limits[min(parts, key=parts.__getitem__)] = True
    shares = {"total": "power"} | {key.removeprefix("power_"): key for key in run if key.startswith("power_")}
    return {
        "bend": abs(harmonic),
        "lag": -float(np.angle(harmonic)),
        "pressure_max": float(pressure.max()),
        "pressure_min": float(pressure.min()),
        "limits": tuple(name for name, acts in limits.items() if acts),
        "electrical_power": {name: float(run[key][-period:].sum(axis=1).mean()) for name, key in shares.items()},
    }


def _line(hydraulics: Circuits, model: JointModel, j: int, limit: float) -> dict[str, Any]:
    """Return resistance, capacity and frequencies of a joint's line, for small motions and up to the pressure limit."""
    column = hydraulics.row(2 * j)
    resistance, inertance = column["resistance"], column["inertance"]
    small = SMALL * limit
    # Oil that one side takes in as its pressure rises, from the fill pressure and from 0; the other side's is constant.
    filled = model.balance([[model.fill - small, model.fill], [model.fill + small, model.fill]])["volume"][:, 0]
    capacity_rest = float(np.diff(filled)[0]) / (2 * small)
    capacity = float(np.diff(model.balance([[0.0, 0.0], [limit, 0.0]])["volume"][:, 0])[0]) / limit
    air = column["air"] * _core.ATMOSPHERE / (_core.ATMOSPHERE + model.fill) ** 2
    compliance = column["oil_pump"] * (1 / column["bulk_modulus"] + air)
    return {
        "line_resistance": resistance,
        "line_inertance": inertance,
        "capacity_rest": capacity_rest,
        "capacity": capacity,
        "corner_rest": 1 / (2 * np.pi * resistance * capacity_rest),
        "corner": 1 / (2 * np.pi * resistance * capacity),
        "resonance": 1 / (2 * np.pi * math.sqrt(inertance * capacity)),
        "damping_ratio": resistance / 2 * math.sqrt(capacity / inertance),
        "ring": 1 / (2 * np.pi * math.sqrt(inertance * compliance)),
        "ring_damping_ratio": resistance / 2 * math.sqrt(compliance / inertance),
    }


def _times(frequency: float, lag: float) -> tuple[Array, int]:
    """Return the times of a run's rows [s], and the number of rows in a beat; lag: time constant of the line [s]."""
    if LAGS * lag > DURATION_MAX:
        rule, value = f"must settle within {DURATION_MAX:g} s", f"so narrow that it takes {LAGS * lag:.3g} s"
        raise InputError(rule, key="bore of a line", value=value, fix="use wider lines or warmer oil")
    period = max(8, round(1 / frequency / SAMPLE))
    beats = max(BEATS, math.ceil(LAGS * lag * frequency))
    return np.arange(beats * period) / (period * frequency), period


def _target(hydraulics: Circuits, model: JointModel, j: int, bend: Array) -> Array:
    """Return the servo angles of both sides [rad] (rows, 2) that displace the oil of a bend [rad] (rows,)."""
    volume = model.hold(bend)["volume"] - model.at(0.0)["volume"]
    target = np.stack([servo_angle(hydraulics, volume[:, s], 2 * j + s) for s in (0, 1)], axis=1)
    reach = model.reach
    if not np.isfinite(target).all() or np.abs(bend).max() > reach:
        rule = f"must be at most what pump and joint can do: the joint locks at {np.degrees(reach):.3g} deg"
        value = f"{np.degrees(np.abs(bend).max()):.4g}"
        fix = "command a smaller amplitude, or describe a pump with more stroke"
        raise InputError(rule, key=f"amplitude_deg[{j}]", value=value, fix=fix)
    return target


def _sent_by_ticks(robot: Robot, target: Array, time: Array) -> Array:
    """Return the targets (rows, 2) as the controller sends them: each is held for a tick."""
    if robot.controller is None:
        return target
    sent = np.floor(time * robot.controller.rate + 1e-9) / robot.controller.rate
    return np.stack([np.interp(sent, time, side) for side in target.T], axis=1)


def _simulator(
    robot: Robot, rows: Array, model: JointModel, supply: float, interval: float, count: int
) -> Callable[[Array], dict[str, Array]]:
    """Return a function that simulates a joint, given servo angles (count, 2) [rad] at an interval [s]."""
    step = STABLE / _core.circuit_stiffness(rows[0], STIFF, 0.0)
    if not step >= SHORTEST:
        rule = f"must not be so stiff that a run needs steps of less than {SHORTEST:g} s"
        key, value = f"{joint_key(robot, model.name)}.line", f"so stiff that it needs {step:.1g} s"
        raise InputError(rule, file=robot.file or None, key=key, value=value, fix=f"describe {SOFTER}")
    steps = max(1, math.ceil(interval / step))
    if steps * count > MAX_STEPS:
        rule = f"must not be so narrow and so stiff that a run needs more than {MAX_STEPS} steps"
        value = f"{steps * count} steps for {interval * count:.3g} s"
        fix = "give wider or shorter lines, warmer oil, or a higher frequency"
        raise InputError(
            rule, file=robot.file or None, key=f"{joint_key(robot, model.name)}.line", value=value, fix=fix
        )

    def run(target: Array) -> dict[str, Array]:
        angles = np.ascontiguousarray(target)
        result: dict[str, Array] = _core.run_pair(
            rows, model.row, target=angles, supply=supply, interval=interval, steps=steps
        )
        return result

    return run


def _limited(
    run: Callable[[Array], dict[str, Array]], target: Array, period: int, limit: float
) -> tuple[dict[str, Array], float]:
    """Return the run with the largest part of the command that keeps the pressure below its limit, and the part."""
    full_run, low, high = run(target), 0.0, 1.0
    if full_run["pump_pressure"][-period:].max() <= limit:
        return full_run, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        within = run(middle * target)["pump_pressure"][-period:].max() <= limit
        low, high = (middle, high) if within else (low, middle)
    return run(low * target), low
