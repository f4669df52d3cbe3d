"""Studies of the twin that depend on its sensors' noise: the numbers of one seed, by name."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hypertuna.description.robot import Robot, load
from hypertuna.description.schema.water import WaterLaw
from hypertuna.paper.computed import LEVELS, SPEEDS, SWIM, TANK, TANK_PHASE
from hypertuna.paper.ledger import published
from hypertuna.simulation.dive import dive
from hypertuna.simulation.posture import hold
from hypertuna.simulation.run import Run, TwinRun
from hypertuna.simulation.twin import twin, twin_at_sea
from hypertuna.swimming.gait import Gait, named_gait
from hypertuna.swimming.turn import fit_circle

SHORT = 8.0  # s: duration of the runs for best phases, which are compared only with one another
ROUND = 30.0  # s: duration of a turn, whose second half is a quarter of a circle or more
HERTZ = (2.0, 6.0)  # frequencies of the tank tests over phases [Hz]
PHASES = tuple(phase for phase in published()["tank"]["phase_deg"] if phase <= 80)  # deg, as far as Eq. 41
LAKE = 60.0  # s: duration of a straight run in still water
SHALLOW = 0.4  # depth of the mission `lake` [m]
LAKE_GAITS = ("optimised-0.5", "unoptimised-0.4")  # the paper's, and the pilot's next slower one


class Diverged(Exception):
    """Error: a run of a study diverged, so that its numbers mean nothing."""


def swims(robot: Robot, seed: int) -> dict[str, float]:
    """Return the numbers of the eight gaits, and of the gaits of large amplitude over frequency."""
    return _swum(robot, swim_gaits(robot), seed)


def swim_gaits(robot: Robot) -> dict[str, Gait]:
    """Return the eight gaits, and the gaits of large amplitude over frequency, by name."""
    tank = {tank_name(hertz): tank_gait(TANK, hertz, TANK_PHASE) for hertz in published()["tank"]["frequency_hz"]}
    return {name: named_gait(robot, name) for name in SPEEDS} | tank


def eight(robot: Robot, seed: int) -> dict[str, float]:
    """Return the numbers of the eight gaits."""
    return _swum(robot, {name: named_gait(robot, name) for name in SPEEDS}, seed)


def _swum(robot: Robot, gaits: Mapping[str, Gait], seed: int) -> dict[str, float]:
    """Swim gaits, and return the numbers of all, by gait and quantity."""
    runs = {name: _swim(robot, gait, SWIM, seed) for name, gait in gaits.items()}
    return {key: number for name, run in runs.items() for key, number in swum(name, robot, run).items()}


def swum(name: str, robot: Robot, run: TwinRun) -> dict[str, float]:
    """Return a run's numbers by name: speed [m/s], power [W], lowest pressure [kPa], swing of each joint [deg]."""
    numbers = {f"{name} speed": run.speed, f"{name} power": run.electrical_power}
    numbers[f"{name} pressure"] = float(run.pressure_min.min()) / 1e3
    swings = zip(robot.joints, np.degrees(run.swing).tolist(), strict=True)
    return numbers | {f"{name} swing {group.name}": angle for group, angle in swings}


def postures(robot: Robot, seed: int) -> dict[str, float]:
    """Return settling times at the angle of Fig. 8 [s] by bend sensor and by true bend; if never, the run's end."""
    numbers: dict[str, float] = {}
    facts = published()["posture"]
    angle = [math.radians(facts["angle_deg"]) if group.name == facts["joint"] else 0.0 for group in robot.joints]
    for hertz in facts["frequency_hz"]:
        (held,) = hold(robot, hertz, angle, duration=facts["duration_s"], medium="air", seed=seed)
        _check(held.run)
        end = float(held.time[-1])
        numbers[f"{hertz:g} Hz sensor"] = end if held.settling_measured is None else held.settling_measured
        numbers[f"{hertz:g} Hz bend"] = end if held.settling is None else held.settling
    return numbers


def phases(robot: Robot, seed: int) -> dict[str, float]:
    """Return speed [m/s] and power [W] of the tank tests over amplitude, frequency and phase difference."""
    numbers: dict[str, float] = {}
    for level in LEVELS:
        for hertz in HERTZ:
            for phase in PHASES:
                run = _swim(robot, tank_gait(level, hertz, phase), SHORT, seed)
                name = phase_name(level, hertz, phase)
                numbers |= {f"{name} speed": run.speed, f"{name} power": run.electrical_power}
    return numbers


def turns(robot: Robot, seed: int) -> dict[str, float]:
    """Return radius of the nose's path [BL] and speed [m/s] of turns at the phases of the turning test."""
    numbers: dict[str, float] = {}
    gait = named_gait(robot, "turning")
    for phase in published()["turning"]["phase_deg"]:
        shifted = Gait(gait.frequency, gait.amplitude, (0.0, math.radians(phase)), gait.bias)
        run = _swim(robot, shifted, ROUND, seed)
        second_half = run.time >= ROUND / 2
        path = run.data["x"][second_half] + 1j * run.data["y"][second_half]
        numbers |= {f"{phase:g} deg radius": fit_circle(path).radius / robot.body.length}
        numbers |= {f"{phase:g} deg speed": run.speed}
    return numbers


def lakes(robot: Robot, seed: int) -> dict[str, float]:
    """Return ground speed [m/s] and servo power [W] of straight swims in shallow water, over each run's second half."""
    numbers: dict[str, float] = {}
    for name in LAKE_GAITS:
        run = twin_at_sea(robot, named_gait(robot, name), duration=LAKE, depth=SHALLOW, seed=seed)
        _check(run)
        beats = round(LAKE / 2 * run.gait.frequency) / run.gait.frequency
        first = int(np.searchsorted(run.time, run.time[-1] - beats))
        path = run.position[-1, :2] - run.position[first, :2]
        numbers[f"{name} speed"] = float(np.hypot(*path) / (run.time[-1] - run.time[first]))
        numbers[f"{name} power"] = float(run.data["power"][first:].mean())
    return numbers


def dives(robot: Robot, seed: int) -> dict[str, float]:
    """Return rates [cm/s] and pitches [deg] of diving and floating as in Fig. 15."""
    facts = published()["diving"]
    result = dive(robot, named_gait(robot, facts["gait"]), angle=math.radians(facts["fins_deg"]), seed=seed)
    _check(result.run)
    numbers: dict[str, float] = {}
    for name, leg in zip(("down", "up"), result.legs, strict=True):
        numbers |= {f"{name} rate": 100 * leg.depth_rate, f"{name} pitch": math.degrees(leg.pitch)}
        numbers[f"{name} pitch range"] = math.degrees(leg.pitch_range)
    return numbers


@dataclass(frozen=True)
class Study:
    """A study: its function of robot and seed, and the water law of the robot."""

    run: Callable[[Robot, int], dict[str, float]]
    water: WaterLaw | None = None  # law, where not the robot's own

    def robot(self) -> Robot:
        """Return the paper's robot with the study's water law."""
        return load(ROBOT) if self.water is None else load(ROBOT).using(water=self.water)


ROBOT = "hypertuna"
STUDIES = {  # studies of the ledger, by name
    "swims": Study(swims),
    "postures": Study(postures),
    "phases": Study(phases),
    "turns": Study(turns),
    "lakes": Study(lakes),
    "dives": Study(dives),
    "strips": Study(eight, "strip"),
}


def tank_gait(level: str, hertz: float, phase: float) -> Gait:
    """Return a gait of the tank tests, with a phase difference in degrees."""
    return Gait.from_degrees(frequency=hertz, amplitude=published()["tank"]["amplitude_deg"][level], phase=(0.0, phase))


def tank_name(hertz: float) -> str:
    """Return the name of the tank test of large amplitude at a frequency [Hz]."""
    return f"tank {hertz:g} Hz"


def phase_name(level: str, hertz: float, phase: float) -> str:
    """Return the name of a gait of the tank tests: amplitude, frequency and phase."""
    return f"{level} {hertz:g} Hz {phase:g} deg"


def _swim(robot: Robot, gait: Gait, seconds: float, seed: int) -> TwinRun:
    """Return a run of the twin that starts at the speed of the settled swim with lagging joints."""
    run = twin(robot, gait, duration=seconds, start="swimming", seed=seed)
    _check(run)
    return run


def _check(run: Run) -> None:
    """Check that a run did not diverge."""
    if run.status == "diverged":
        raise Diverged("a run diverged")
