"""Record of a run of the twin, and the means and amplitudes of its last whole beats."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.hydraulics import drive_names
from hypertuna.arrays import Array
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, require
from hypertuna.description.twin import require_controller
from hypertuna.display import Plotted, Tabular
from hypertuna.io.files import dataset
from hypertuna.io.quantity import Format, Quantity, summarized
from hypertuna.simulation.losses import Losses, losses_of
from hypertuna.simulation.recorded import CONDITIONS, NAMES, VARIABLES, Variables
from hypertuna.simulation.series import between, trend
from hypertuna.swimming.gait import Gait, gait_text

if TYPE_CHECKING:
    import xarray as xr

LAST_PART = 0.3  # fraction of the run whose whole beats are averaged
MAX_CHANGE = 2e-3  # largest relative change per beat of speed or amplitude in a settled run
CAVITATION_MARGIN = 0.02  # oil counts as cavitating within this fraction of its cavitation pressure
SUBSTEPS = 8  # points per tick at which peaks are searched


@dataclass(frozen=True)
class Run(Tabular, data=lambda run: run.dataset()):
    """A run of the twin, in the plane or at sea: its command, its record, and results computed from both."""

    robot: Robot = field(repr=False)
    gait: Gait  # command
    duration: float  # [s] as requested
    closed_loop: bool
    seed: int
    temperature: float  # oil temperature [K]
    faults_given: tuple[str, ...]  # as on the command line
    step: float  # integration step [s]
    time: Array = field(repr=False)  # (T,) start of every recorded control tick [s]
    # By the names of VARIABLES, (T,) or (T, n) [SI]; status_at: bits of places.
    data: dict[str, Array] = field(repr=False)
    status: str  # "completed" or "diverged"

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joint groups."""
        return tuple(group.name for group in self.robot.joints)

    @property
    def hinges(self) -> tuple[str, ...]:
        """Names of the links behind the passive hinges, nose to tail."""
        return tuple(self.robot.links.name[hinge.link] for hinge in self.robot.hinges)

    @property
    def circuits(self) -> tuple[str, ...]:
        """Names of the oil circuits: I-left, I-right, ..."""
        return tuple(name for name in drive_names(self.robot, oil=True) if name)

    @property
    def drives(self) -> tuple[str, ...]:
        """Names of the servos that move the joints: the circuit's name, or the joint's for a servo on an axle."""
        return tuple(name for name in drive_names(self.robot) if name)

    @property
    def servos(self) -> tuple[str, ...]:
        """Names of all servos: the joints' servos, then the fins'."""
        return (*self.drives, "fin 1", "fin 2")

    @cached_property
    def tick(self) -> float:
        """Control tick [s]."""
        return 1 / require_controller(self.robot).rate

    @cached_property
    def interval(self) -> float:
        """Time from one row of the record to the next [s]."""
        return float(self.time[1] - self.time[0]) if len(self.time) > 1 else self.tick

    @cached_property
    def beat_count(self) -> int:
        """Number of whole beats at the end that are averaged, at least one; 0 if the run is shorter than a beat."""
        beats = len(self.time) * self.interval * self.gait.frequency * (1 + 1e-9)
        return int(min(beats - self.gait.frequency * self.interval, max(1.0, LAST_PART * beats)))

    @cached_property
    def beats(self) -> slice:
        """Rows of the last whole beats, which are averaged."""
        rows = round(self.beat_count / (self.gait.frequency * self.interval))
        return slice(max(0, len(self.time) - max(1, rows)), len(self.time))

    @property
    def losses(self) -> Losses:
        """Where the power goes: means over the last whole beats."""
        return losses_of(self.robot, f"{self.robot.name}, {gait_text(self.gait)}", self.data, self.beats)

    @property
    def battery_power(self) -> float:
        """Mean power that the battery's cells give [W]."""
        return self.losses.power

    @property
    def divergence(self) -> str:
        """Sentence that says when the run diverged."""
        seconds = self.time.size * self.tick
        return f"The run diverged after {seconds:.2f} s: the plant's state is no longer a robot's."

    def _labeled(
        self, names: Variables, coordinates: Mapping[str, Sequence[str]], attributes: dict[str, Any]
    ) -> xr.Dataset:
        """Return the record as a data set, with units, meanings, and names along every dimension."""
        variables = {
            NAMES.get(name, name): (("time", dim) if dim else ("time",), self.data[name], unit, text)
            for name, (dim, unit, text) in names.items()
            if dim != "hinge" or self.hinges
        }
        own = ("joint", *["hinge"] * bool(self.hinges), "circuit", "drive", "servo")
        places = {dim: getattr(self, f"{dim}s") for dim in own} | dict(coordinates)
        time = ("time", self.time, "s", "start of the control tick")
        labels = {name: (name, np.array(list(texts), dtype=str)) for name, texts in places.items()}
        data = dataset(variables, {"time": time} | labels, provenance(self.robot) | attributes)
        flags = {"flag_masks": [1 << bit for bit in range(len(CONDITIONS))], "flag_meanings": " ".join(CONDITIONS)}
        data["status"] = data["status"].astype(np.int64).assign_attrs(flags)
        return data


@dataclass(frozen=True)
class TwinRun(Run, Plotted):
    """A run of the twin in the plane; means and amplitudes are over its last whole beats."""

    medium: str  # "water" or "air"
    start: str  # "rest" or "swimming"

    @cached_property
    def speeds(self) -> Array:
        """Speed in each last beat (beats,) [m/s]: the nose's displacement over the period, negative backward."""
        if self.medium == "air" or not self.beat_count:
            return np.full(max(1, self.beat_count), math.nan)
        instants = self.time[-1] - np.arange(self.beat_count, -1, -1) / self.gait.frequency
        cosine, sine = np.cos(self.data["heading"]), np.sin(self.data["heading"])
        surge, sway = -self.data["speed"], self.data["sway"]
        x = between(self.time, self.data["x"], cosine * surge - sine * sway, instants)
        y = between(self.time, self.data["y"], sine * surge + cosine * sway, instants)
        heading = between(self.time, self.data["heading"], self.data["yaw"], instants)
        dx, dy = np.diff(x), np.diff(y)
        ahead = -(dx * np.cos(heading[:-1]) + dy * np.sin(heading[:-1]))
        result: Array = np.copysign(np.hypot(dx, dy), ahead) * self.gait.frequency
        return result

    @property
    def speed(self) -> float:
        """Mean of `speeds` [m/s]; NaN in air."""
        return float(self.speeds.mean())

    @property
    def speed_bl(self) -> float:
        """Mean speed in body lengths per second [1/s]; NaN in air."""
        return self.speed / self.robot.body.length

    @cached_property
    def change_per_beat(self) -> float:
        """Largest relative change per beat of the speed or a joint's swing, less the trend's uncertainty [1]."""
        trends = [trend(swing) for swing in self._swings.T if swing.size > 1 and swing.mean() > 1e-3]
        if self.medium == "water":
            trends.append(trend(self.speeds))
        return max(trends, key=abs, default=math.nan)

    def summary(self) -> dict[str, Quantity]:
        """Summarize speed, power and cost of transport; in air, only power has a label and is shown.

        Returns
        -------
        dict of str to Quantity
            By the keys of the JSON record.
        """
        note = "" if self.medium == "water" else None
        shown = {
            "speed": Format("m/s", note),
            "speed_bl": Format("BL/s", note),
            "electrical_power": Format("W"),
            "mechanical_power": Format("W", None),
            "cost_of_transport": Format("J/(kg m)", note),
        }
        summary = summarized(self, shown)
        if not self.settled:
            summary["speed_m_s"] = summary["speed_m_s"]._replace(unit="m/s, still changing")
        return summary

    @property
    def settled(self) -> bool:
        """Whether speed and swings change by less than 0.2 % per beat."""
        return self.status == "completed" and abs(self.change_per_beat) < MAX_CHANGE

    @cached_property
    def first_harmonic(self) -> Array:
        """Amplitude of the first harmonic of each joint group's bend (joints,) [rad]."""
        return np.abs(self._harmonic("angle"))

    @cached_property
    def phase(self) -> Array:
        """Phase lag of each joint group's first harmonic behind the gait's clock (joints,) [rad]."""
        return self._lag("angle")

    @cached_property
    def bends(self) -> tuple[dict[str, float], ...]:
        """Swing of each hinge over the last beats [rad], as in a settled beat, and the part of time in its stops."""
        if not self.hinges:
            return ()
        swing, lag = np.abs(self._harmonic("hinge_angle")), self._lag("hinge_angle") % (2 * math.pi)
        paths = np.abs(self._paths("hinge_angle", "hinge_rate"))
        stops = [math.inf if hinge.stop is None else hinge.stop for hinge in self.robot.hinges]
        held = (paths >= stops).mean(axis=0)
        columns = {"bend_amplitude": swing, "bend_lag": lag, "bend_peak": paths.max(axis=0), "in_stops": held}
        return tuple({name: float(column[d]) for name, column in columns.items()} for d in range(len(stops)))

    @cached_property
    def bias(self) -> Array:
        """Mean bend of each joint group (joints,) [rad]."""
        return np.asarray(self.data["angle"][self.beats].mean(axis=0))

    @property
    def swing(self) -> Array:
        """Half of the peak-to-peak bend of each joint group, mean over the last beats (joints,) [rad]."""
        return np.asarray(self._swings.mean(axis=0))

    @property
    def electrical_power(self) -> float:
        """Mean electrical power of all servos [W]."""
        return float(self.data["power"][self.beats].mean())

    @property
    def mechanical_power(self) -> float:
        """Mean power of the joint groups' moments on the tail [W]."""
        return float((self.data["loss_water"] + self.data["loss_hinge"])[self.beats].mean())

    @property
    def cost_of_transport(self) -> float:
        """Electrical power over mass and speed [J/(kg m)] (Eq. 38, in which the paper omits the mass)."""
        return self.electrical_power / (self.robot.body.mass * abs(self.speed)) if self.speed else math.inf

    @property
    def pressure_max(self) -> Array:
        """Largest pressure in each cylinder over the last beats (circuits,) [Pa]."""
        return np.asarray(self.data["pump_pressure_high"][self.beats].max(axis=0))

    @property
    def pressure_min(self) -> Array:
        """Smallest pressure in each cylinder over the last beats (circuits,) [Pa]."""
        return np.asarray(self.data["pump_pressure_low"][self.beats].min(axis=0))

    @property
    def pressure_highest(self) -> Array:
        """Largest pressure of each circuit, in its cylinder or units, at any time of the run (circuits,) [Pa]."""
        pump, unit = (self.data[f"{part}_pressure_high"] for part in ("pump", "unit"))
        return np.asarray(np.maximum(pump, unit).max(axis=0))

    @property
    def pressure_peak(self) -> float:
        """Largest pressure of any circuit at any time of the run [Pa]; NaN without oil."""
        return float(self.pressure_highest.max()) if self.circuits else math.nan

    @property
    def flags(self) -> int:
        """All flags of the controller's status that were ever set, as bits."""
        return int(np.bitwise_or.reduce(self.data["status"].astype(np.int64), initial=0))

    @cached_property
    def _held(self) -> NDArray[np.bool_]:
        """Whether each of `CONDITIONS` held in each tick (T, conditions)."""
        flags = self.data["status"].astype(np.int64)
        return np.asarray(flags[:, np.newaxis] >> np.arange(len(CONDITIONS)) & 1, dtype=bool)

    @cached_property
    def acting(self) -> dict[str, float]:
        """Fraction of the last beats' ticks in which each condition held, including cavitation [1]."""
        fractions = dict(zip(CONDITIONS, self._held[self.beats].mean(axis=0).tolist(), strict=True))
        if self.circuits:
            limit = require(self.robot.oil, "oil", self.robot).cavitation * (1 - CAVITATION_MARGIN)
            fractions["cavitation"] = float((self.data["pump_pressure_low"][self.beats].min(axis=1) < limit).mean())
        return {name: fraction for name, fraction in fractions.items() if fraction > 0}

    @property
    def limits(self) -> tuple[str, ...]:
        """Names of the limits that acted in the last beats, the most frequent first."""
        names = [name for name in self.acting if name.endswith(("_limit", "_stop", "cavitation", "low_voltage"))]
        return tuple(sorted(names, key=lambda name: -self.acting[name]))

    @property
    def faults(self) -> tuple[str, ...]:
        """Names of the sensor faults that the controller detected, in the order of its table."""
        held = zip(CONDITIONS, self._held.T, strict=True)
        return tuple(name for name, ticks in held if name.endswith("_fault") and ticks.any())

    @cached_property
    def sentences(self) -> tuple[str, ...]:
        """A sentence on whether the run settled, and one for each condition that held: where and how often."""
        settled = "settled" if self.settled else "not settled"
        first = f"The run is {settled}: the largest change is {_percent(abs(self.change_per_beat))} per beat."
        if math.isnan(self.change_per_beat):
            first = "The run is too short to tell whether it is settled."
        if self.status == "diverged":
            first = self.divergence
        drives = drive_names(self.robot)
        names = {"joint": self.joints, "circuit": drives, "servo": (*drives, *self.servos[-2:])}
        sentences = [first]
        for bit, (place, text) in enumerate(CONDITIONS.values()):
            held = self._held[:, bit]
            if held.any():
                place_bits = int(np.bitwise_or.reduce(self.data["status_at"][held, bit].astype(np.int64)))
                places = [name for k, name in enumerate(names.get(place, ())) if place_bits >> k & 1]
                location = f" ({', '.join(places)})" if places else ""
                sentences.append(f"{text[0].upper()}{text[1:]}{location}: {_percent(held.mean())} of the ticks.")
        hard = require_controller(self.robot).pressure_hard
        if hard is not None and self.pressure_peak > hard:
            place, kpa = self.circuits[int(self.pressure_highest.argmax())], f"{self.pressure_peak / 1e3:.0f}"
            sentences.append(f"The pressure rose to {kpa} kPa ({place}), above the hard limit of {hard / 1e3:g} kPa.")
        if "cavitation" in self.acting:
            fraction = _percent(self.acting["cavitation"])
            sentences.append(f"The oil cavitated in a cylinder: {fraction} of the last beats' ticks.")
        return tuple(sentences)

    def dataset(self) -> xr.Dataset:
        """Return the record as a data set: dimensions time, joint, circuit, drive, servo; units in the attributes.

        Returns
        -------
        xarray.Dataset
        """
        angles = {f"{key}_deg": np.degrees(getattr(self.gait, key)).tolist() for key in ("amplitude", "phase", "bias")}
        attributes = {
            "frequency_hz": self.gait.frequency,
            **angles,
            "medium": self.medium,
            "closed_loop": int(self.closed_loop),
            "seed": self.seed,
            "temperature_k": self.temperature,
            "faults": " ".join(self.faults_given),
            "step_s": self.step,
            "run_status": self.status,
        }
        return self._labeled(VARIABLES, {}, attributes)

    @cached_property
    def _swings(self) -> Array:
        """Half of the peak-to-peak bend of each joint group in each of the last beats (beats, joints) [rad]."""
        if not self.beat_count:
            return np.full((1, self.data["angle"].shape[1]), math.nan)
        paths = self._paths("angle", "rate")
        samples = (len(paths) - 1) // self.beat_count
        beats = np.arange(self.beat_count)[:, np.newaxis] * samples + np.arange(samples + 1)
        return np.asarray(np.ptp(paths[beats], axis=1) / 2)

    def _paths(self, angle: str, rate: str) -> Array:
        """Return angles (instants, n) [rad] over the last beats, `SUBSTEPS` instants a tick; names of their columns."""
        if not self.beat_count:
            return self.data[angle]
        samples = round(SUBSTEPS / (self.gait.frequency * self.tick))  # points per beat
        instants = self.time[-1] - np.arange(self.beat_count * samples, -1, -1) / (samples * self.gait.frequency)
        columns = zip(self.data[angle].T, self.data[rate].T, strict=True)
        return np.stack([between(self.time, *column, instants) for column in columns], axis=1)

    def _lag(self, name: str) -> Array:
        """Return how far the first harmonics of angles lag behind the gait's clock [rad], from -pi/2 on."""
        target, bend = self._harmonic("angle_set"), self._harmonic(name)
        g = int(abs(target).argmax())
        clock = np.angle(target[g]) + self.gait.phase[g]
        result: Array = (clock - np.angle(bend) + math.pi / 2) % (2 * math.pi) - math.pi / 2
        return result

    def _harmonic(self, name: str) -> NDArray[np.complex128]:
        """Return the first harmonic of a column over the last beats: a (joints,) in Re(a exp(i (2 pi f t - pi/2)))."""
        values, t = self.data[name][self.beats], self.time[self.beats]
        turn = 2 * math.pi * self.gait.frequency * t
        basis = np.stack([np.ones_like(turn), np.sin(turn), np.cos(turn)], axis=1)
        _, sine, cosine = np.linalg.lstsq(basis, values, rcond=None)[0]
        result: NDArray[np.complex128] = sine + 1j * cosine
        return result


def _percent(part: float) -> str:
    """Return a fraction as a percentage with two digits and no exponent."""
    percent = 100 * float(part)
    return f"{percent:.0f} %" if percent >= 10 else f"{percent:.2g} %" if percent >= 0.01 else "less than 0.01 %"
